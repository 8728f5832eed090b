/* SPDX-License-Identifier: MIT */
/* The loader's way in, instances, systems, sessions and spaces. */
#include "runtime.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

struct runtime rt;

void note(const char *format, ...) {
    va_list arguments;
    if (!rt.log) return;
    va_start(arguments, format);
    vfprintf(rt.log, format, arguments);
    va_end(arguments);
    fputc('\n', rt.log);
    fflush(rt.log);
}

static char current[64]; /* function */

XrResult mistake(XrResult result, const char *format, ...) {
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    rt.errors++;
    note("MISTAKE xr%s: %s", current, text);
    return result;
}

static struct {
    char name[64];
    uint32_t count;
} calls[128];

XrResult enter(const char *function) {
    uint32_t i = 0;
    while (i < 127 && calls[i].name[0] && strcmp(calls[i].name, function) != 0) i++;
    if (!calls[i].name[0]) snprintf(calls[i].name, sizeof calls[i].name, "%s", function);
    calls[i].count++;
    snprintf(current, sizeof current, "%s", function);
    for (uint32_t k = 0; k < rt.script.cost_count; k++)
        if (strcmp(rt.script.costs[k].function + 2, function) == 0) rt.now += (int64_t)(rt.script.costs[k].milliseconds * 1e6);
    for (uint32_t k = 0; k < rt.script.fault_count; k++) {
        const struct fault *f = &rt.script.faults[k];
        if (strcmp(f->function + 2, function) == 0 && (f->call == 0 || f->call == calls[i].count)) {
            note("injected xr%s %s", function, result_name(f->result));
            if (f->result == XR_ERROR_SESSION_LOST) rt.session_lost = true;
            if (f->result == XR_ERROR_INSTANCE_LOST) rt.instance_lost = true;
            if (f->result == XR_SESSION_LOSS_PENDING) { /* a success: the call does its work */
                set_state(XR_SESSION_STATE_LOSS_PENDING);
                return XR_SUCCESS;
            }
            return f->result;
        }
    }
    return XR_SUCCESS;
}

struct object *new_object(enum kind kind, struct object *parent) {
    if (rt.object_count == OBJECTS) return NULL;
    struct object *object = &rt.objects[rt.object_count++];
    *object = (struct object){.kind = kind, .parent = parent};
    return object;
}

struct object *find_object(const void *handle, enum kind kind) {
    for (uint32_t i = 0; i < rt.object_count; i++)
        if (&rt.objects[i] == handle) return rt.objects[i].kind == kind ? &rt.objects[i] : NULL;
    return NULL;
}

void destroy_object(struct object *object) {
    for (uint32_t i = 0; i < rt.object_count; i++)
        if (rt.objects[i].kind && rt.objects[i].parent == object) destroy_object(&rt.objects[i]);
    if (object->kind == KIND_SWAPCHAIN) images_free(&object->swapchain);
    object->kind = 0;
}

void push_event(const void *event, size_t size) {
    if (rt.event_count == EVENTS) return;
    memset(&rt.events[rt.event_count], 0, sizeof rt.events[0]);
    memcpy(&rt.events[rt.event_count++], event, size);
}

void set_state(XrSessionState state) {
    static const char *const names[] = {"UNKNOWN", "IDLE", "READY", "SYNCHRONIZED", "VISIBLE", "FOCUSED", "STOPPING", "LOSS_PENDING", "EXITING"};
    XrEventDataSessionStateChanged event = {.type = XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED, .session = (XrSession)rt.session, .state = state, .time = rt.now};
    rt.state = state;
    note("state %s", names[state]);
    push_event(&event, sizeof event);
}

/* After a loss every call but those that destroy says so. */
bool is_lost(XrResult *out) {
    *out = rt.instance_lost ? XR_ERROR_INSTANCE_LOST : rt.session_lost ? XR_ERROR_SESSION_LOST : XR_SUCCESS;
    return *out != XR_SUCCESS;
}
#define NOT_LOST()                                                                                                          \
    do {                                                                                                                    \
        XrResult lost_;                                                                                                     \
        if (is_lost(&lost_)) return lost_;                                                                                  \
    } while (0)
#define INSTANCE(handle)                                                                                                    \
    do {                                                                                                                    \
        ENTER();                                                                                                            \
        if (!find_object(handle, KIND_INSTANCE)) return mistake(XR_ERROR_HANDLE_INVALID, "the instance is none");           \
        if (rt.instance_lost) return XR_ERROR_INSTANCE_LOST;                                                                \
    } while (0)
#define SESSION(handle)                                                                                                     \
    do {                                                                                                                    \
        ENTER();                                                                                                            \
        if (!find_object(handle, KIND_SESSION)) return mistake(XR_ERROR_HANDLE_INVALID, "the session is none");             \
        NOT_LOST();                                                                                                         \
    } while (0)

/* ---- instance and system ---- */

static const struct {
    const char *name;
    uint32_t version;
} extensions[] = {{"XR_KHR_vulkan_enable2", 2}, {"XR_KHR_composition_layer_depth", 5}, {"XR_KHR_visibility_mask", 2}, {"XR_VARJO_quad_views", 1},
                  {"XR_EXT_eye_gaze_interaction", 2}};

static bool has_extension(const char *name) {
    for (uint32_t i = 0; i < rt.script.without_count; i++)
        if (strcmp(rt.script.without[i], name) == 0) return false;
    if (strcmp(name, "XR_VARJO_quad_views") == 0 && rt.script.view_count != 4) return false;
    for (size_t i = 0; i < sizeof extensions / sizeof *extensions; i++)
        if (strcmp(extensions[i].name, name) == 0) return true;
    return false;
}

static XRAPI_ATTR XrResult XRAPI_CALL callEnumerateInstanceExtensionProperties(const char *layer, uint32_t capacity, uint32_t *count, XrExtensionProperties *out) {
    ENTER();
    (void)layer;
    *count = 0;
    for (size_t i = 0; i < sizeof extensions / sizeof *extensions; i++) {
        if (!has_extension(extensions[i].name)) continue;
        if (*count < capacity) {
            if (out[*count].type != XR_TYPE_EXTENSION_PROPERTIES) return mistake(XR_ERROR_VALIDATION_FAILURE, "properties[%u].type is wrong", *count);
            snprintf(out[*count].extensionName, sizeof out->extensionName, "%s", extensions[i].name);
            out[*count].extensionVersion = extensions[i].version;
        }
        ++*count;
    }
    return capacity && capacity < *count ? XR_ERROR_SIZE_INSUFFICIENT : XR_SUCCESS;
}

static XRAPI_ATTR XrResult XRAPI_CALL callCreateInstance(const XrInstanceCreateInfo *info, XrInstance *out) {
    ENTER();
    CHECK_TYPE(info, XR_TYPE_INSTANCE_CREATE_INFO);
    rt.ext_depth = rt.ext_mask = rt.ext_quad = rt.ext_gaze = false;
    bool vulkan = false;
    for (uint32_t i = 0; i < info->enabledExtensionCount; i++) {
        const char *name = info->enabledExtensionNames[i];
        if (!has_extension(name)) return mistake(XR_ERROR_EXTENSION_NOT_PRESENT, "%s was not offered", name);
        vulkan |= strcmp(name, "XR_KHR_vulkan_enable2") == 0;
        rt.ext_depth |= strcmp(name, "XR_KHR_composition_layer_depth") == 0;
        rt.ext_mask |= strcmp(name, "XR_KHR_visibility_mask") == 0;
        rt.ext_quad |= strcmp(name, "XR_VARJO_quad_views") == 0;
        rt.ext_gaze |= strcmp(name, "XR_EXT_eye_gaze_interaction") == 0;
    }
    if (!vulkan) return mistake(XR_ERROR_INITIALIZATION_FAILED, "XR_KHR_vulkan_enable2 is not enabled");
    if (!memchr(info->applicationInfo.applicationName, 0, XR_MAX_APPLICATION_NAME_SIZE) || !info->applicationInfo.applicationName[0])
        return mistake(XR_ERROR_NAME_INVALID, "the application has no name");
    rt.instance_lost = rt.session_lost = false;
    rt.event_count = 0;
    rt.asked_requirements = rt.asked_device = false;
    rt.session = NULL;
    *out = (XrInstance)new_object(KIND_INSTANCE, NULL);
    return *out ? XR_SUCCESS : XR_ERROR_LIMIT_REACHED;
}

static XRAPI_ATTR XrResult XRAPI_CALL callDestroyInstance(XrInstance instance) {
    const XrResult injected = enter(__func__ + 4); /* what is destroyed is gone even then */
    struct object *object = find_object(instance, KIND_INSTANCE);
    if (!object) return mistake(XR_ERROR_HANDLE_INVALID, "the instance is none");
    if (rt.session && rt.session->kind) mistake(XR_SUCCESS, "a session is still there");
    destroy_object(object);
    note("instance destroyed, %u mistakes", rt.errors);
    return injected;
}

static XRAPI_ATTR XrResult XRAPI_CALL callGetInstanceProperties(XrInstance instance, XrInstanceProperties *out) {
    INSTANCE(instance);
    CHECK_TYPE(out, XR_TYPE_INSTANCE_PROPERTIES);
    snprintf(out->runtimeName, sizeof out->runtimeName, "Fanal test runtime");
    out->runtimeVersion = XR_MAKE_VERSION(1, 0, 0);
    return XR_SUCCESS;
}

static XRAPI_ATTR XrResult XRAPI_CALL callPollEvent(XrInstance instance, XrEventDataBuffer *out) {
    ENTER();
    if (!find_object(instance, KIND_INSTANCE)) return mistake(XR_ERROR_HANDLE_INVALID, "the instance is none");
    CHECK_TYPE(out, XR_TYPE_EVENT_DATA_BUFFER);
    if (rt.instance_lost) return XR_ERROR_INSTANCE_LOST;
    if (rt.pausing && rt.state == XR_SESSION_STATE_IDLE && rt.event_count == 0 && rt.pause_polls-- == 0) {
        rt.pausing = false;
        rt.has_resumed = true;
        set_state(XR_SESSION_STATE_READY);
    }
    if (rt.event_count == 0) return XR_EVENT_UNAVAILABLE;
    *out = rt.events[0];
    memmove(rt.events, rt.events + 1, --rt.event_count * sizeof *rt.events);
    return XR_SUCCESS;
}

static XRAPI_ATTR XrResult XRAPI_CALL callResultToString(XrInstance instance, XrResult value, char buffer[XR_MAX_RESULT_STRING_SIZE]) {
    ENTER();
    (void)instance;
    snprintf(buffer, XR_MAX_RESULT_STRING_SIZE, "%s", result_name(value));
    return XR_SUCCESS;
}

static XRAPI_ATTR XrResult XRAPI_CALL callStructureTypeToString(XrInstance instance, XrStructureType value, char buffer[XR_MAX_STRUCTURE_NAME_SIZE]) {
    ENTER();
    (void)instance;
    snprintf(buffer, XR_MAX_STRUCTURE_NAME_SIZE, "XR_UNKNOWN_STRUCTURE_TYPE_%d", (int)value);
    return XR_SUCCESS;
}

static XRAPI_ATTR XrResult XRAPI_CALL callGetSystem(XrInstance instance, const XrSystemGetInfo *info, XrSystemId *out) {
    INSTANCE(instance);
    CHECK_TYPE(info, XR_TYPE_SYSTEM_GET_INFO);
    if (info->formFactor != XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY) return XR_ERROR_FORM_FACTOR_UNSUPPORTED;
    if (rt.script.no_system) return XR_ERROR_FORM_FACTOR_UNAVAILABLE;
    *out = 1;
    return XR_SUCCESS;
}

#define SYSTEM(id)                                                                                                          \
    if ((id) != 1) return mistake(XR_ERROR_SYSTEM_INVALID, "the system is none")

static XRAPI_ATTR XrResult XRAPI_CALL callGetSystemProperties(XrInstance instance, XrSystemId system, XrSystemProperties *out) {
    INSTANCE(instance);
    SYSTEM(system);
    CHECK_TYPE(out, XR_TYPE_SYSTEM_PROPERTIES);
    out->systemId = 1;
    out->vendorId = 0;
    snprintf(out->systemName, sizeof out->systemName, "Scripted headset");
    out->graphicsProperties = (XrSystemGraphicsProperties){4096, 4096, LAYERS};
    out->trackingProperties = (XrSystemTrackingProperties){XR_TRUE, XR_TRUE};
    for (XrBaseOutStructure *next = out->next; next; next = next->next) {
        if (next->type != XR_TYPE_SYSTEM_EYE_GAZE_INTERACTION_PROPERTIES_EXT) return mistake(XR_ERROR_VALIDATION_FAILURE, "next has type %d", (int)next->type);
        if (!rt.ext_gaze) return mistake(XR_ERROR_VALIDATION_FAILURE, "XR_EXT_eye_gaze_interaction is not enabled");
        ((XrSystemEyeGazeInteractionPropertiesEXT *)next)->supportsEyeGazeInteraction = rt.script.gaze_count > 0;
    }
    return XR_SUCCESS;
}

/* ---- views ---- */

static XrViewConfigurationType configuration_of(uint32_t count) {
    return count == 1 ? XR_VIEW_CONFIGURATION_TYPE_PRIMARY_MONO : XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
}

static uint32_t views_of(XrViewConfigurationType type) {
    if (type == XR_VIEW_CONFIGURATION_TYPE_PRIMARY_QUAD_VARJO) return rt.ext_quad ? 4 : 0;
    if (type == XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO) return rt.script.view_count == 1 ? 0 : 2;
    return type == XR_VIEW_CONFIGURATION_TYPE_PRIMARY_MONO && rt.script.view_count == 1 ? 1 : 0;
}

static XRAPI_ATTR XrResult XRAPI_CALL callEnumerateViewConfigurations(XrInstance instance, XrSystemId system, uint32_t capacity, uint32_t *count, XrViewConfigurationType *out) {
    INSTANCE(instance);
    SYSTEM(system);
    *count = rt.ext_quad ? 2 : 1;
    if (capacity == 0) return XR_SUCCESS;
    if (capacity < *count) return XR_ERROR_SIZE_INSUFFICIENT;
    if (rt.ext_quad) *out++ = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_QUAD_VARJO;
    *out = configuration_of(rt.script.view_count);
    return XR_SUCCESS;
}

static XRAPI_ATTR XrResult XRAPI_CALL callGetViewConfigurationProperties(XrInstance instance, XrSystemId system, XrViewConfigurationType type,
                                                                         XrViewConfigurationProperties *out) {
    INSTANCE(instance);
    SYSTEM(system);
    CHECK_TYPE(out, XR_TYPE_VIEW_CONFIGURATION_PROPERTIES);
    if (!views_of(type)) return mistake(XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED, "views of type %d were not offered", (int)type);
    out->viewConfigurationType = type;
    out->fovMutable = XR_TRUE;
    return XR_SUCCESS;
}

static XRAPI_ATTR XrResult XRAPI_CALL callEnumerateViewConfigurationViews(XrInstance instance, XrSystemId system, XrViewConfigurationType type, uint32_t capacity,
                                                                          uint32_t *count, XrViewConfigurationView *out) {
    INSTANCE(instance);
    SYSTEM(system);
    *count = views_of(type);
    if (!*count) return mistake(XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED, "views of type %d were not offered", (int)type);
    if (capacity == 0) return XR_SUCCESS;
    if (capacity < *count) return XR_ERROR_SIZE_INSUFFICIENT;
    for (uint32_t i = 0; i < *count; i++) {
        CHECK_TYPE(&out[i], XR_TYPE_VIEW_CONFIGURATION_VIEW);
        out[i].recommendedImageRectWidth = rt.script.width[i];
        out[i].recommendedImageRectHeight = rt.script.height[i];
        out[i].maxImageRectWidth = out[i].maxImageRectHeight = 4096;
        out[i].recommendedSwapchainSampleCount = out[i].maxSwapchainSampleCount = 1;
    }
    return XR_SUCCESS;
}

static XRAPI_ATTR XrResult XRAPI_CALL callEnumerateEnvironmentBlendModes(XrInstance instance, XrSystemId system, XrViewConfigurationType type, uint32_t capacity,
                                                                         uint32_t *count, XrEnvironmentBlendMode *out) {
    INSTANCE(instance);
    SYSTEM(system);
    if (!views_of(type)) return mistake(XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED, "views of type %d were not offered", (int)type);
    *count = 1;
    if (capacity) *out = XR_ENVIRONMENT_BLEND_MODE_OPAQUE;
    return XR_SUCCESS;
}

/* ---- session ---- */

static XRAPI_ATTR XrResult XRAPI_CALL callCreateSession(XrInstance instance, const XrSessionCreateInfo *info, XrSession *out) {
    INSTANCE(instance);
    CHECK_TYPE(info, XR_TYPE_SESSION_CREATE_INFO);
    SYSTEM(info->systemId);
    const XrGraphicsBindingVulkan2KHR *binding = info->next;
    CHECK_TYPE(binding, XR_TYPE_GRAPHICS_BINDING_VULKAN2_KHR);
    if (!rt.asked_requirements) return mistake(XR_ERROR_GRAPHICS_REQUIREMENTS_CALL_MISSING, "xrGetVulkanGraphicsRequirements2KHR was not called");
    if (!rt.asked_device) return mistake(XR_ERROR_VALIDATION_FAILURE, "xrGetVulkanGraphicsDevice2KHR was not called");
    if (!rt.device || binding->instance != rt.vulkan || binding->physicalDevice != rt.physical || binding->device != rt.device)
        return mistake(XR_ERROR_GRAPHICS_DEVICE_INVALID, "the device is not the one that this runtime made");
    if (rt.session && rt.session->kind) return mistake(XR_ERROR_LIMIT_REACHED, "there is a session already");
    rt.family = binding->queueFamilyIndex;
    PFN_vkGetDeviceQueue get_queue = (PFN_vkGetDeviceQueue)rt.get_proc(rt.vulkan, "vkGetDeviceQueue");
    get_queue(rt.device, rt.family, binding->queueIndex, &rt.queue);
    if (!rt.queue) return mistake(XR_ERROR_GRAPHICS_DEVICE_INVALID, "the device has no queue %u of family %u", binding->queueIndex, binding->queueFamilyIndex);
    rt.session = new_object(KIND_SESSION, (struct object *)instance);
    rt.running = rt.exit_requested = rt.attached = rt.session_lost = rt.pausing = rt.has_resumed = rt.waited = rt.begun = rt.has_given = false;
    rt.ended = rt.hidden_frames = 0;
    rt.recenter_time = -1;
    rt.local_origin = (XrPosef){{0, 0, 0, 1}, {0, 1.6f, 0}};
    if (rt.now == 0) rt.now = 1000000000;
    *out = (XrSession)rt.session;
    set_state(XR_SESSION_STATE_IDLE);
    set_state(XR_SESSION_STATE_READY);
    return XR_SUCCESS;
}

static XRAPI_ATTR XrResult XRAPI_CALL callDestroySession(XrSession session) {
    const XrResult injected = enter(__func__ + 4); /* what is destroyed is gone even then */
    struct object *object = find_object(session, KIND_SESSION);
    if (!object) return mistake(XR_ERROR_HANDLE_INVALID, "the session is none");
    destroy_object(object);
    vulkan_forget();
    note("session destroyed");
    return injected;
}

static XRAPI_ATTR XrResult XRAPI_CALL callBeginSession(XrSession session, const XrSessionBeginInfo *info) {
    SESSION(session);
    CHECK_TYPE(info, XR_TYPE_SESSION_BEGIN_INFO);
    if (rt.running) return mistake(XR_ERROR_SESSION_RUNNING, "the session runs already");
    if (rt.state != XR_SESSION_STATE_READY) return mistake(XR_ERROR_SESSION_NOT_READY, "the session is not READY");
    if (!views_of(info->primaryViewConfigurationType)) return mistake(XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED, "no such views were offered");
    rt.configuration = info->primaryViewConfigurationType;
    rt.running = true;
    rt.waited = rt.begun = false;
    rt.ended = 0;
    set_state(XR_SESSION_STATE_SYNCHRONIZED);
    return XR_SUCCESS;
}

static XRAPI_ATTR XrResult XRAPI_CALL callEndSession(XrSession session) {
    SESSION(session);
    if (!rt.running) return mistake(XR_ERROR_SESSION_NOT_RUNNING, "the session does not run");
    if (rt.state != XR_SESSION_STATE_STOPPING) return mistake(XR_ERROR_SESSION_NOT_STOPPING, "the session is not STOPPING");
    rt.running = false;
    set_state(XR_SESSION_STATE_IDLE);
    if (!rt.pausing) set_state(XR_SESSION_STATE_EXITING);
    return XR_SUCCESS;
}

static XRAPI_ATTR XrResult XRAPI_CALL callRequestExitSession(XrSession session) {
    SESSION(session);
    if (!rt.running) return mistake(XR_ERROR_SESSION_NOT_RUNNING, "the session does not run");
    if (rt.exit_requested) mistake(XR_SUCCESS, "asked twice");
    rt.exit_requested = true;
    if (rt.state == XR_SESSION_STATE_FOCUSED) set_state(XR_SESSION_STATE_VISIBLE);
    if (rt.state == XR_SESSION_STATE_VISIBLE) set_state(XR_SESSION_STATE_SYNCHRONIZED);
    set_state(XR_SESSION_STATE_STOPPING);
    return XR_SUCCESS;
}

/* ---- spaces ---- */

static XRAPI_ATTR XrResult XRAPI_CALL callEnumerateReferenceSpaces(XrSession session, uint32_t capacity, uint32_t *count, XrReferenceSpaceType *out) {
    SESSION(session);
    XrReferenceSpaceType all[3];
    *count = 0;
    all[(*count)++] = XR_REFERENCE_SPACE_TYPE_VIEW;
    if (!rt.script.no_local) all[(*count)++] = XR_REFERENCE_SPACE_TYPE_LOCAL;
    if (!rt.script.no_stage) all[(*count)++] = XR_REFERENCE_SPACE_TYPE_STAGE;
    if (capacity == 0) return XR_SUCCESS;
    if (capacity < *count) return XR_ERROR_SIZE_INSUFFICIENT;
    memcpy(out, all, *count * sizeof *all);
    return XR_SUCCESS;
}

static bool is_unit(const XrPosef *pose) {
    const XrQuaternionf q = pose->orientation;
    const float length = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
    return length > 0.98f && length < 1.02f;
}

static XRAPI_ATTR XrResult XRAPI_CALL callCreateReferenceSpace(XrSession session, const XrReferenceSpaceCreateInfo *info, XrSpace *out) {
    SESSION(session);
    CHECK_TYPE(info, XR_TYPE_REFERENCE_SPACE_CREATE_INFO);
    if (!is_unit(&info->poseInReferenceSpace)) return mistake(XR_ERROR_POSE_INVALID, "the rotation is no unit quaternion");
    const bool known = info->referenceSpaceType == XR_REFERENCE_SPACE_TYPE_VIEW ||
                       (info->referenceSpaceType == XR_REFERENCE_SPACE_TYPE_LOCAL && !rt.script.no_local) ||
                       (info->referenceSpaceType == XR_REFERENCE_SPACE_TYPE_STAGE && !rt.script.no_stage);
    if (!known) return mistake(XR_ERROR_REFERENCE_SPACE_UNSUPPORTED, "space %d was not offered", (int)info->referenceSpaceType);
    struct object *object = new_object(KIND_SPACE, (struct object *)session);
    if (!object) return XR_ERROR_LIMIT_REACHED;
    object->space.reference = info->referenceSpaceType;
    object->space.pose = info->poseInReferenceSpace;
    *out = (XrSpace)object;
    return XR_SUCCESS;
}

static XRAPI_ATTR XrResult XRAPI_CALL callGetReferenceSpaceBoundsRect(XrSession session, XrReferenceSpaceType type, XrExtent2Df *out) {
    SESSION(session);
    *out = (XrExtent2Df){0, 0};
    if (type != XR_REFERENCE_SPACE_TYPE_STAGE) return XR_SPACE_BOUNDS_UNAVAILABLE;
    *out = (XrExtent2Df){3, 2};
    return XR_SUCCESS;
}

static XRAPI_ATTR XrResult XRAPI_CALL callDestroySpace(XrSpace space) {
    const XrResult injected = enter(__func__ + 4); /* what is destroyed is gone even then */
    struct object *object = find_object(space, KIND_SPACE);
    if (!object) return mistake(XR_ERROR_HANDLE_INVALID, "the space is none");
    destroy_object(object);
    return injected;
}

static XRAPI_ATTR XrResult XRAPI_CALL callLocateSpace(XrSpace space, XrSpace base, XrTime time, XrSpaceLocation *out) {
    ENTER();
    NOT_LOST();
    const struct object *object = find_object(space, KIND_SPACE), *origin = find_object(base, KIND_SPACE);
    if (!object || !origin) return mistake(XR_ERROR_HANDLE_INVALID, "a space is none");
    CHECK_TYPE(out, XR_TYPE_SPACE_LOCATION);
    if (time <= 0) return mistake(XR_ERROR_TIME_INVALID, "the time is %lld", (long long)time);
    out->locationFlags = 0;
    const bool is_gaze = object->space.action && object->space.action->action.is_gaze;
    const struct gaze_row *gaze = is_gaze ? gaze_now() : NULL;
    if (is_gaze ? !gaze || !gaze->active || !gaze->valid : object->space.action && !hand_now(object->space.hand)) return XR_SUCCESS;
    const XrPosef a = space_in_stage(origin, time), b = space_in_stage(object, time), inverse = pose_inverse(&a);
    out->pose = pose_mul(&inverse, &b);
    out->locationFlags = XR_SPACE_LOCATION_ORIENTATION_VALID_BIT | XR_SPACE_LOCATION_POSITION_VALID_BIT;
    if (!gaze || gaze->tracked) out->locationFlags |= XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT | XR_SPACE_LOCATION_POSITION_TRACKED_BIT;
    return XR_SUCCESS;
}

/* ---- the mask ---- */

static XRAPI_ATTR XrResult XRAPI_CALL callGetVisibilityMaskKHR(XrSession session, XrViewConfigurationType type, uint32_t view, XrVisibilityMaskTypeKHR kind,
                                                               XrVisibilityMaskKHR *out) {
    SESSION(session);
    CHECK_TYPE(out, XR_TYPE_VISIBILITY_MASK_KHR);
    if (!rt.ext_mask) return mistake(XR_ERROR_FUNCTION_UNSUPPORTED, "XR_KHR_visibility_mask is not enabled");
    if (view >= views_of(type)) return mistake(XR_ERROR_VALIDATION_FAILURE, "there is no view %u", view);
    if (kind != XR_VISIBILITY_MASK_TYPE_HIDDEN_TRIANGLE_MESH_KHR) return mistake(XR_ERROR_VALIDATION_FAILURE, "only hidden triangles are known here");
    const struct mask *mask = &rt.script.masks[view];
    out->vertexCountOutput = mask->vertex_count;
    out->indexCountOutput = mask->index_count;
    if (out->vertexCapacityInput == 0 && out->indexCapacityInput == 0) return XR_SUCCESS;
    if (out->vertexCapacityInput < mask->vertex_count || out->indexCapacityInput < mask->index_count) return XR_ERROR_SIZE_INSUFFICIENT;
    memcpy(out->vertices, mask->vertices, mask->vertex_count * sizeof *mask->vertices);
    memcpy(out->indices, mask->indices, mask->index_count * sizeof *mask->indices);
    return XR_SUCCESS;
}

/* ---- the way in ---- */

static XRAPI_ATTR XrResult XRAPI_CALL get_instance_proc_addr(XrInstance instance, const char *name, PFN_xrVoidFunction *out);

static PFN_xrVoidFunction own_function(const char *name) {
    FUNCTION(EnumerateInstanceExtensionProperties, name)
    FUNCTION(CreateInstance, name)
    FUNCTION(DestroyInstance, name)
    FUNCTION(GetInstanceProperties, name)
    FUNCTION(PollEvent, name)
    FUNCTION(ResultToString, name)
    FUNCTION(StructureTypeToString, name)
    FUNCTION(GetSystem, name)
    FUNCTION(GetSystemProperties, name)
    FUNCTION(EnumerateViewConfigurations, name)
    FUNCTION(GetViewConfigurationProperties, name)
    FUNCTION(EnumerateViewConfigurationViews, name)
    FUNCTION(EnumerateEnvironmentBlendModes, name)
    FUNCTION(CreateSession, name)
    FUNCTION(DestroySession, name)
    FUNCTION(BeginSession, name)
    FUNCTION(EndSession, name)
    FUNCTION(RequestExitSession, name)
    FUNCTION(EnumerateReferenceSpaces, name)
    FUNCTION(CreateReferenceSpace, name)
    FUNCTION(GetReferenceSpaceBoundsRect, name)
    FUNCTION(DestroySpace, name)
    FUNCTION(LocateSpace, name)
    FUNCTION(GetVisibilityMaskKHR, name)
    return strcmp(name, "xrGetInstanceProcAddr") == 0 ? (PFN_xrVoidFunction)get_instance_proc_addr : NULL;
}

static XRAPI_ATTR XrResult XRAPI_CALL get_instance_proc_addr(XrInstance instance, const char *name, PFN_xrVoidFunction *out) {
    (void)instance;
    *out = own_function(name);
    if (!*out) *out = frame_function(name);
    if (!*out) *out = input_function(name);
    if (!*out) *out = vulkan_function(name);
    return *out ? XR_SUCCESS : XR_ERROR_FUNCTION_UNSUPPORTED;
}

/* As in the loader's document; Debian 12 has no header with these. */
struct loader_info {
    int type; /* 1 */
    uint32_t version;
    size_t size;
    uint32_t min_interface, max_interface;
    XrVersion min_api, max_api;
};
struct runtime_request {
    int type; /* 3 */
    uint32_t version;
    size_t size;
    uint32_t interface;
    XrVersion api;
    PFN_xrGetInstanceProcAddr get_instance_proc_addr;
};

__attribute__((visibility("default"))) XrResult xrNegotiateLoaderRuntimeInterface(const struct loader_info *loader, struct runtime_request *request);
XrResult xrNegotiateLoaderRuntimeInterface(const struct loader_info *loader, struct runtime_request *request) {
    if (!loader || !request || loader->type != 1 || request->type != 3 || loader->min_interface > 1) return XR_ERROR_INITIALIZATION_FAILED;
    if (!rt.log) {
        const char *path = getenv("FANAL_XR_LOG");
        if (path && *path) rt.log = fopen(path, "w");
        if (!script_read(getenv("FANAL_XR_SCRIPT"))) return XR_ERROR_INITIALIZATION_FAILED;
    }
    request->interface = 1;
    request->api = XR_MAKE_VERSION(1, 0, 0);
    request->get_instance_proc_addr = get_instance_proc_addr;
    return XR_SUCCESS;
}
