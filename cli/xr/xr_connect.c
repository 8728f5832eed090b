/* SPDX-License-Identifier: MIT */
/* From the loader to a session, and the session's states. */
#include "xr/xr.h"

#include "print.h"

#include <openxr/openxr_reflection.h>
#include <stdio.h>
#include <string.h>

/* ---- results ---- */

#define RESULT_ROW(name, value) {#name, value},
static const struct {
    const char *name;
    int value;
} results[] = {XR_LIST_ENUM_XrResult(RESULT_ROW)};

const char *xr_result_text(XrResult result) {
    for (size_t i = 0; i < sizeof results / sizeof *results; i++)
        if (results[i].value == (int)result) return results[i].name;
    return "an unknown error";
}

static bool is_loss(XrResult result) { return result == XR_ERROR_SESSION_LOST || result == XR_ERROR_INSTANCE_LOST; }

bool xr_good(struct xr *x, const char *function, XrResult result) {
    if (XR_SUCCEEDED(result)) return true;
    if (x->end == XR_LOST || x->end == XR_FAILED) return false;
    x->end = is_loss(result) ? XR_LOST : XR_FAILED;
    fprintf(stderr, "fanal: %s: %s: %s\n", x->end == XR_LOST ? "warning" : "error", function, xr_result_text(result));
    return false;
}

bool xr_may(struct xr *x, const char *function, XrResult result, const char *left_out) {
    if (XR_SUCCEEDED(result)) return true;
    if (is_loss(result)) return xr_good(x, function, result);
    fprintf(stderr, "fanal: warning: %s: %s: goes on without %s\n", function, xr_result_text(result), left_out);
    return false;
}

/* ---- instance and system ---- */

static bool has_extension(const XrExtensionProperties *all, uint32_t count, const char *name) {
    for (uint32_t i = 0; i < count; i++)
        if (strcmp(all[i].extensionName, name) == 0) return true;
    return false;
}

static bool tell_no_runtime(struct xr *x, const char *function, XrResult result) {
    if (result != XR_ERROR_RUNTIME_UNAVAILABLE && result != XR_ERROR_FILE_ACCESS_ERROR) return xr_good(x, function, result);
    fputs("fanal: error: no OpenXR runtime was found: start that of the headset (SteamVR, Monado …), or name its file in XR_RUNTIME_JSON\n", stderr);
    x->end = XR_FAILED;
    return false;
}

static bool create_instance(struct xr *x) {
    enum { MOST = 256 };
    XrExtensionProperties all[MOST];
    uint32_t count = 0;
    XrResult result = xrEnumerateInstanceExtensionProperties(NULL, 0, &count, NULL);
    if (XR_FAILED(result)) return tell_no_runtime(x, "xrEnumerateInstanceExtensionProperties", result);
    if (count > MOST) count = MOST;
    for (uint32_t i = 0; i < count; i++) all[i] = (XrExtensionProperties){.type = XR_TYPE_EXTENSION_PROPERTIES};
    result = xrEnumerateInstanceExtensionProperties(NULL, count, &count, all);
    if (XR_FAILED(result)) return tell_no_runtime(x, "xrEnumerateInstanceExtensionProperties", result);
    const char *names[5];
    XrInstanceCreateInfo info = {.type = XR_TYPE_INSTANCE_CREATE_INFO, .enabledExtensionNames = names};
    if (!has_extension(all, count, XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME)) {
        fputs("fanal: error: the OpenXR runtime has no " XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME ": it cannot take pictures from Vulkan\n", stderr);
        x->end = XR_FAILED;
        return false;
    }
    names[info.enabledExtensionCount++] = XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME;
    x->has_depth = !x->options->no_depth && has_extension(all, count, XR_KHR_COMPOSITION_LAYER_DEPTH_EXTENSION_NAME);
    x->has_mask = !x->options->no_mask && has_extension(all, count, XR_KHR_VISIBILITY_MASK_EXTENSION_NAME);
    x->has_gaze = xr_wants_gaze(x) && has_extension(all, count, XR_EXT_EYE_GAZE_INTERACTION_EXTENSION_NAME);
    x->has_quad = !x->options->stereo_only && has_extension(all, count, XR_VARJO_QUAD_VIEWS_EXTENSION_NAME);
    if (x->has_depth) names[info.enabledExtensionCount++] = XR_KHR_COMPOSITION_LAYER_DEPTH_EXTENSION_NAME;
    if (x->has_mask) names[info.enabledExtensionCount++] = XR_KHR_VISIBILITY_MASK_EXTENSION_NAME;
    if (x->has_gaze) names[info.enabledExtensionCount++] = XR_EXT_EYE_GAZE_INTERACTION_EXTENSION_NAME;
    if (x->has_quad) names[info.enabledExtensionCount++] = XR_VARJO_QUAD_VIEWS_EXTENSION_NAME;
    snprintf(info.applicationInfo.applicationName, sizeof info.applicationInfo.applicationName, "fanal xr");
    snprintf(info.applicationInfo.engineName, sizeof info.applicationInfo.engineName, "Fanal");
    info.applicationInfo.applicationVersion = info.applicationInfo.engineVersion = FNL_VERSION_MAJOR << 16 | FNL_VERSION_MINOR << 8 | FNL_VERSION_PATCH;
    info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 0); /* all that is used */
    result = xrCreateInstance(&info, &x->instance);
    if (XR_FAILED(result)) {
        x->instance = XR_NULL_HANDLE;
        return tell_no_runtime(x, "xrCreateInstance", result);
    }
    XrInstanceProperties properties = {.type = XR_TYPE_INSTANCE_PROPERTIES};
    if (xr_may(x, "xrGetInstanceProperties", xrGetInstanceProperties(x->instance, &properties), "the runtime's name"))
        snprintf(x->runtime_name, sizeof x->runtime_name, "%s", properties.runtimeName);
    return x->end == XR_RUNS;
}

static bool find_system(struct xr *x) {
    const XrSystemGetInfo info = {.type = XR_TYPE_SYSTEM_GET_INFO, .formFactor = XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY};
    const XrResult result = xrGetSystem(x->instance, &info, &x->system);
    if (result == XR_ERROR_FORM_FACTOR_UNAVAILABLE || result == XR_ERROR_FORM_FACTOR_UNSUPPORTED) {
        fprintf(stderr, "fanal: error: the OpenXR runtime (%s) has no headset%s\n", x->runtime_name,
                result == XR_ERROR_FORM_FACTOR_UNAVAILABLE ? " now: is it connected and switched on?" : "");
        x->end = XR_FAILED;
        return false;
    }
    if (!xr_good(x, "xrGetSystem", result)) return false;
    XrSystemEyeGazeInteractionPropertiesEXT eyes = {.type = XR_TYPE_SYSTEM_EYE_GAZE_INTERACTION_PROPERTIES_EXT};
    XrSystemProperties properties = {.type = XR_TYPE_SYSTEM_PROPERTIES, .next = x->has_gaze ? &eyes : NULL};
    if (xr_may(x, "xrGetSystemProperties", xrGetSystemProperties(x->instance, x->system, &properties), "the headset's name"))
        snprintf(x->system_name, sizeof x->system_name, "%s", properties.systemName);
    x->has_gaze = x->has_gaze && eyes.supportsEyeGazeInteraction;
    return x->end == XR_RUNS;
}

/* Four views where the runtime has them, else two. */
static bool choose_views(struct xr *x) {
    XrViewConfigurationType types[16];
    uint32_t count = 0;
    if (!xr_good(x, "xrEnumerateViewConfigurations", xrEnumerateViewConfigurations(x->instance, x->system, 16, &count, types))) return false;
    x->configuration = XR_VIEW_CONFIGURATION_TYPE_MAX_ENUM;
    for (uint32_t i = 0; i < count && x->configuration == XR_VIEW_CONFIGURATION_TYPE_MAX_ENUM; i++) /* the runtime likes the first best */
        if (types[i] == XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO || (x->has_quad && types[i] == XR_VIEW_CONFIGURATION_TYPE_PRIMARY_QUAD_VARJO))
            x->configuration = types[i];
    if (x->configuration == XR_VIEW_CONFIGURATION_TYPE_MAX_ENUM) {
        fprintf(stderr, "fanal: error: the headset (%s) has no stereo views\n", x->system_name);
        x->end = XR_FAILED;
        return false;
    }
    for (uint32_t i = 0; i < XR_VIEWS; i++) x->configured[i] = (XrViewConfigurationView){.type = XR_TYPE_VIEW_CONFIGURATION_VIEW};
    if (!xr_good(x, "xrEnumerateViewConfigurationViews",
                 xrEnumerateViewConfigurationViews(x->instance, x->system, x->configuration, XR_VIEWS, &x->view_count, x->configured)))
        return false;
    XrEnvironmentBlendMode modes[8];
    if (!xr_good(x, "xrEnumerateEnvironmentBlendModes",
                 xrEnumerateEnvironmentBlendModes(x->instance, x->system, x->configuration, 8, &count, modes)))
        return false;
    x->blend = count ? modes[0] : XR_ENVIRONMENT_BLEND_MODE_OPAQUE; /* the runtime's favourite, unless it can hide what is around */
    for (uint32_t i = 0; i < count; i++)
        if (modes[i] == XR_ENVIRONMENT_BLEND_MODE_OPAQUE) x->blend = modes[i];
    return true;
}

/* ---- session and spaces ---- */

static bool create_session(struct xr *x) {
    const XrGraphicsBindingVulkan2KHR binding = {.type = XR_TYPE_GRAPHICS_BINDING_VULKAN2_KHR,
                                                 .instance = x->vulkan,
                                                 .physicalDevice = x->physical,
                                                 .device = x->vk_device,
                                                 .queueFamilyIndex = x->family};
    const XrSessionCreateInfo info = {.type = XR_TYPE_SESSION_CREATE_INFO, .next = &binding, .systemId = x->system};
    if (!xr_good(x, "xrCreateSession", xrCreateSession(x->instance, &info, &x->session))) {
        x->session = XR_NULL_HANDLE;
        return false;
    }
    return true;
}

static const char *space_name(XrReferenceSpaceType type) {
    return type == XR_REFERENCE_SPACE_TYPE_STAGE ? "stage" : type == XR_REFERENCE_SPACE_TYPE_LOCAL ? "local" : "view";
}

static bool create_space(struct xr *x, XrReferenceSpaceType type, XrSpace *out) {
    const XrReferenceSpaceCreateInfo info = {.type = XR_TYPE_REFERENCE_SPACE_CREATE_INFO, .referenceSpaceType = type, .poseInReferenceSpace = {{0, 0, 0, 1}, {0, 0, 0}}};
    const bool good = xr_good(x, "xrCreateReferenceSpace", xrCreateReferenceSpace(x->session, &info, out));
    if (!good) *out = XR_NULL_HANDLE;
    return good;
}

/* The stage, on the floor of a room; else where the user sits. */
static bool choose_space(struct xr *x) {
    XrReferenceSpaceType types[16];
    uint32_t count = 0;
    bool has_stage = false, has_local = false;
    if (!xr_good(x, "xrEnumerateReferenceSpaces", xrEnumerateReferenceSpaces(x->session, 16, &count, types))) return false;
    for (uint32_t i = 0; i < count; i++) {
        has_stage |= types[i] == XR_REFERENCE_SPACE_TYPE_STAGE;
        has_local |= types[i] == XR_REFERENCE_SPACE_TYPE_LOCAL;
    }
    const XrReferenceSpaceType wanted = x->options->space;
    x->space_type = has_stage && wanted != XR_REFERENCE_SPACE_TYPE_LOCAL ? XR_REFERENCE_SPACE_TYPE_STAGE
                    : has_local                                         ? XR_REFERENCE_SPACE_TYPE_LOCAL
                    : has_stage                                         ? XR_REFERENCE_SPACE_TYPE_STAGE
                                                                        : XR_REFERENCE_SPACE_TYPE_VIEW;
    if (x->space_type == XR_REFERENCE_SPACE_TYPE_VIEW) {
        fputs("fanal: error: the headset has neither a stage nor a local space to stand in\n", stderr);
        x->end = XR_FAILED;
        return false;
    }
    if (wanted != XR_REFERENCE_SPACE_TYPE_VIEW && wanted != x->space_type)
        fprintf(stderr, "fanal: warning: the headset has no %s space: %s is taken\n", space_name(wanted), space_name(x->space_type));
    return create_space(x, x->space_type, &x->space) && create_space(x, XR_REFERENCE_SPACE_TYPE_VIEW, &x->head_space);
}

bool xr_connect(struct xr *x) {
    x->end = XR_RUNS;
    x->numbers.connections++;
    if (!create_instance(x) || !find_system(x) || !choose_views(x) || !xr_open_device(x) || !create_session(x) || !choose_space(x) || !xr_make_images(x)) return false;
    if (x->has_mask && !xr_may(x, "xrGetInstanceProcAddr",
                               xrGetInstanceProcAddr(x->instance, "xrGetVisibilityMaskKHR", (PFN_xrVoidFunction *)&x->get_mask), "the visibility mask"))
        x->has_mask = false;
    xr_start_input(x);
    return x->end == XR_RUNS;
}

void xr_note_end(const struct xr *x, const char *function, XrResult result) {
    /* After a loss it is no news. */
    if (XR_FAILED(result) && !is_loss(result) && x->end != XR_LOST) fprintf(stderr, "fanal: warning: %s: %s\n", function, xr_result_text(result));
}

void xr_disconnect(struct xr *x) {
    for (uint32_t i = 0; i < x->group_count; i++) fnl_renderer_destroy(&x->groups[i].renderer); /* waits for the device */
    xr_free_images(x);
    xr_free_masks(x);
    if (x->session) xr_note_end(x, "xrDestroySession", xrDestroySession(x->session)); /* and its spaces */
    xr_close_device(x);
    if (x->instance) xr_note_end(x, "xrDestroyInstance", xrDestroyInstance(x->instance)); /* and its actions */
    x->instance = XR_NULL_HANDLE;
    x->session = XR_NULL_HANDLE;
    x->space = x->head_space = XR_NULL_HANDLE;
    x->actions = x->gaze_actions = XR_NULL_HANDLE;
    x->group_count = 0;
    x->running = x->asked_exit = x->has_input = x->has_gaze = x->gaze_known = x->placed = x->keeps_place = false;
    x->replace_at = x->first_display = x->past_display = 0;
    x->past_count = 0;
    x->state = XR_SESSION_STATE_UNKNOWN;
    for (uint32_t i = 0; i < XR_HANDS; i++) x->hands[i] = (struct xr_hand){0};
}

/* ---- events ---- */

static void change_state(struct xr *x, XrSessionState state) {
    struct xr_numbers *n = &x->numbers;
    x->state = state;
    if (n->state_count < XR_STATES) n->states[n->state_count++] = (uint32_t)state;
    if (state == XR_SESSION_STATE_READY && !x->running && xr_warm(x)) {
        const XrSessionBeginInfo info = {.type = XR_TYPE_SESSION_BEGIN_INFO, .primaryViewConfigurationType = x->configuration};
        x->running = xr_good(x, "xrBeginSession", xrBeginSession(x->session, &info));
        x->past_display = 0; /* what was paused has missed nothing */
        x->past_count = 0;
    }
    if (state == XR_SESSION_STATE_STOPPING) {
        x->running = false;
        xr_good(x, "xrEndSession", xrEndSession(x->session));
    }
    if (state == XR_SESSION_STATE_EXITING) x->end = XR_DONE;
    if (state == XR_SESSION_STATE_LOSS_PENDING) {
        fputs("fanal: warning: the OpenXR runtime is about to lose the session\n", stderr);
        x->end = XR_LOST;
    }
}

static void take_event(struct xr *x, const XrEventDataBuffer *event) {
    const void *data = event;
    if (event->type == XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED) {
        const XrEventDataSessionStateChanged *e = data;
        if (e->session == x->session) change_state(x, e->state);
    } else if (event->type == XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING) {
        fputs("fanal: warning: the OpenXR runtime is about to end\n", stderr);
        x->end = XR_LOST;
    } else if (event->type == XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING) {
        const XrEventDataReferenceSpaceChangePending *e = data;
        if (e->session == x->session && e->referenceSpaceType == x->space_type) x->replace_at = e->changeTime;
    } else if (event->type == XR_TYPE_EVENT_DATA_VISIBILITY_MASK_CHANGED_KHR) {
        const XrEventDataVisibilityMaskChangedKHR *e = data;
        if (e->session == x->session && e->viewConfigurationType == x->configuration && e->viewIndex < x->view_count && x->has_mask) {
            x->numbers.mask_changes++;
            xr_read_mask(x, e->viewIndex);
        }
    } /* else: nothing that concerns a viewer */
}

void xr_take_events(struct xr *x) {
    while (x->end == XR_RUNS) {
        XrEventDataBuffer event = {.type = XR_TYPE_EVENT_DATA_BUFFER};
        const XrResult result = xrPollEvent(x->instance, &event);
        if (result == XR_EVENT_UNAVAILABLE || !xr_good(x, "xrPollEvent", result)) return;
        take_event(x, &event);
    }
}
