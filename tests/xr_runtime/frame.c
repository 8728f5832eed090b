/* SPDX-License-Identifier: MIT */
/* Swapchains, frames and what is submitted with them. */
#include "runtime.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define SESSION(handle)                                                                                                     \
    do {                                                                                                                    \
        XrResult lost_;                                                                                                     \
        ENTER();                                                                                                            \
        if (!find_object(handle, KIND_SESSION)) return mistake(XR_ERROR_HANDLE_INVALID, "the session is none");             \
        if (is_lost(&lost_)) return lost_;                                                                                  \
    } while (0)
#define RUNNING()                                                                                                           \
    if (!rt.running) return mistake(XR_ERROR_SESSION_NOT_RUNNING, "the session does not run")

/* ---- swapchains ---- */

static XRAPI_ATTR XrResult XRAPI_CALL callEnumerateSwapchainFormats(XrSession session, uint32_t capacity, uint32_t *count, int64_t *out) {
    SESSION(session);
    *count = rt.script.format_count;
    if (capacity == 0) return XR_SUCCESS;
    if (capacity < *count) return XR_ERROR_SIZE_INSUFFICIENT;
    memcpy(out, rt.script.formats, *count * sizeof *out);
    return XR_SUCCESS;
}

static bool is_depth(int64_t format) { return format >= VK_FORMAT_D16_UNORM && format <= VK_FORMAT_D32_SFLOAT_S8_UINT; }

static XRAPI_ATTR XrResult XRAPI_CALL callCreateSwapchain(XrSession session, const XrSwapchainCreateInfo *info, XrSwapchain *out) {
    SESSION(session);
    CHECK_TYPE(info, XR_TYPE_SWAPCHAIN_CREATE_INFO);
    bool offered = false;
    for (uint32_t i = 0; i < rt.script.format_count; i++) offered |= rt.script.formats[i] == info->format;
    if (!offered) return mistake(XR_ERROR_SWAPCHAIN_FORMAT_UNSUPPORTED, "format %lld was not offered", (long long)info->format);
    if (info->width == 0 || info->height == 0 || info->width > 4096 || info->height > 4096 || info->arraySize == 0 || info->mipCount != 1 || info->faceCount != 1 ||
        info->sampleCount != 1)
        return mistake(XR_ERROR_VALIDATION_FAILURE, "size %ux%u, %u layers, %u mips, %u faces, %u samples", info->width, info->height, info->arraySize,
                       info->mipCount, info->faceCount, info->sampleCount);
    const bool depth = is_depth(info->format);
    const XrSwapchainUsageFlags wanted = depth ? XR_SWAPCHAIN_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT : XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT;
    if (!(info->usageFlags & wanted)) return mistake(XR_ERROR_VALIDATION_FAILURE, "images of a swapchain are left in an attachment's layout, but usageFlags has no such bit");
    struct object *object = new_object(KIND_SWAPCHAIN, (struct object *)session);
    if (!object) return XR_ERROR_LIMIT_REACHED;
    object->swapchain = (struct swapchain){.info = *info, .acquired = -1, .waited = -1, .released = -1, .is_depth = depth};
    object->swapchain.info.next = NULL;
    const XrResult result = images_make(&object->swapchain);
    if (result != XR_SUCCESS) {
        destroy_object(object);
        return result;
    }
    note("swapchain format %lld %ux%u layers %u", (long long)info->format, info->width, info->height, info->arraySize);
    *out = (XrSwapchain)object;
    return XR_SUCCESS;
}

#define SWAPCHAIN(handle)                                                                                                   \
    ENTER();                                                                                                                \
    struct object *object = find_object(handle, KIND_SWAPCHAIN);                                                            \
    if (!object) return mistake(XR_ERROR_HANDLE_INVALID, "the swapchain is none");                                          \
    struct swapchain *chain = &object->swapchain;                                                                           \
    XrResult lost_;                                                                                                         \
    if (is_lost(&lost_)) return lost_

static XRAPI_ATTR XrResult XRAPI_CALL callDestroySwapchain(XrSwapchain handle) {
    const XrResult injected = enter(__func__ + 4); /* what is destroyed is gone even then */
    struct object *object = find_object(handle, KIND_SWAPCHAIN);
    if (!object) return mistake(XR_ERROR_HANDLE_INVALID, "the swapchain is none");
    destroy_object(object);
    return injected;
}

static XRAPI_ATTR XrResult XRAPI_CALL callEnumerateSwapchainImages(XrSwapchain handle, uint32_t capacity, uint32_t *count, XrSwapchainImageBaseHeader *out) {
    SWAPCHAIN(handle);
    XrSwapchainImageVulkan2KHR *images = (XrSwapchainImageVulkan2KHR *)out;
    *count = IMAGES;
    if (capacity == 0) return XR_SUCCESS;
    if (capacity < IMAGES) return XR_ERROR_SIZE_INSUFFICIENT;
    for (uint32_t i = 0; i < IMAGES; i++) {
        CHECK_TYPE(&images[i], XR_TYPE_SWAPCHAIN_IMAGE_VULKAN2_KHR);
        images[i].image = chain->images[i];
    }
    return XR_SUCCESS;
}

static XRAPI_ATTR XrResult XRAPI_CALL callAcquireSwapchainImage(XrSwapchain handle, const XrSwapchainImageAcquireInfo *info, uint32_t *out) {
    SWAPCHAIN(handle);
    if (info) CHECK_TYPE(info, XR_TYPE_SWAPCHAIN_IMAGE_ACQUIRE_INFO);
    if (chain->acquired >= 0) return mistake(XR_ERROR_CALL_ORDER_INVALID, "an image is acquired already");
    chain->acquired = (int)(chain->next++ % IMAGES);
    *out = (uint32_t)chain->acquired;
    return XR_SUCCESS;
}

static XRAPI_ATTR XrResult XRAPI_CALL callWaitSwapchainImage(XrSwapchain handle, const XrSwapchainImageWaitInfo *info) {
    SWAPCHAIN(handle);
    CHECK_TYPE(info, XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO);
    if (chain->acquired < 0) return mistake(XR_ERROR_CALL_ORDER_INVALID, "no image is acquired");
    if (chain->waited >= 0) return mistake(XR_ERROR_CALL_ORDER_INVALID, "the image was waited for already");
    chain->waited = chain->acquired;
    return XR_SUCCESS;
}

static XRAPI_ATTR XrResult XRAPI_CALL callReleaseSwapchainImage(XrSwapchain handle, const XrSwapchainImageReleaseInfo *info) {
    SWAPCHAIN(handle);
    if (info) CHECK_TYPE(info, XR_TYPE_SWAPCHAIN_IMAGE_RELEASE_INFO);
    if (chain->waited < 0) return mistake(XR_ERROR_CALL_ORDER_INVALID, "no image was waited for");
    chain->released = chain->waited;
    chain->acquired = chain->waited = -1;
    return XR_SUCCESS;
}

/* ---- time ---- */

static void happen(const struct moment *m) {
    note("moment %s", m->what);
    if (strcmp(m->what, "stall") == 0) rt.now += (int64_t)(m->numbers[0] * 1e6);
    if (strcmp(m->what, "lose_session") == 0) rt.session_lost = true;
    if (strcmp(m->what, "lose_instance") == 0) rt.instance_lost = true;
    if (strcmp(m->what, "session_loss_pending") == 0) set_state(XR_SESSION_STATE_LOSS_PENDING);
    if (strcmp(m->what, "instance_loss_pending") == 0) {
        XrEventDataInstanceLossPending event = {.type = XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING, .lossTime = rt.now};
        push_event(&event, sizeof event);
    }
    if (strcmp(m->what, "events_lost") == 0) {
        XrEventDataEventsLost event = {.type = XR_TYPE_EVENT_DATA_EVENTS_LOST, .lostEventCount = 1};
        push_event(&event, sizeof event);
    }
    if (strcmp(m->what, "unknown_event") == 0) {
        XrEventDataEventsLost event = {.type = (XrStructureType)1999999999};
        push_event(&event, sizeof event);
    }
    if (strcmp(m->what, "profile") == 0) {
        XrEventDataInteractionProfileChanged event = {.type = XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED, .session = (XrSession)rt.session};
        push_event(&event, sizeof event);
    }
    if (strcmp(m->what, "mask") == 0) { /* view, part of the edge; 0: none */
        const uint32_t view = (uint32_t)m->numbers[0] % VIEWS;
        const double part = m->numbers[1];
        struct mask *mask = &rt.script.masks[view];
        for (uint32_t i = 0; i < mask->vertex_count; i++) mask->vertices[i].x *= (float)part, mask->vertices[i].y *= (float)part;
        if (part == 0) *mask = (struct mask){0};
        XrEventDataVisibilityMaskChangedKHR event = {.type = XR_TYPE_EVENT_DATA_VISIBILITY_MASK_CHANGED_KHR,
                                                     .session = (XrSession)rt.session,
                                                     .viewConfigurationType = rt.configuration,
                                                     .viewIndex = view};
        if (rt.ext_mask) push_event(&event, sizeof event);
    }
    if (strcmp(m->what, "bad_pose") == 0) rt.bad_until = rt.frame + (uint32_t)m->numbers[0];
    if (strcmp(m->what, "fov") == 0) /* wider by this factor */
        for (uint32_t i = 0; i < VIEWS; i++) {
            XrFovf *f = &rt.script.fov[i];
            *f = (XrFovf){f->angleLeft * (float)m->numbers[0], f->angleRight * (float)m->numbers[0], f->angleUp * (float)m->numbers[0], f->angleDown * (float)m->numbers[0]};
        }
    if (strcmp(m->what, "walk") == 0) { /* to x y z */
        rt.script.head.x = m->numbers[0];
        rt.script.head.y = m->numbers[1];
        rt.script.head.z = m->numbers[2];
    }
    if (strcmp(m->what, "recenter") == 0) { /* where LOCAL will be in STAGE: x z yaw (degrees), in two frames */
        const double half = m->numbers[2] * 3.14159265358979323846 / 360;
        rt.recentered = (XrPosef){{0, (float)sin(half), 0, (float)cos(half)}, {(float)m->numbers[0], 1.6f, (float)m->numbers[1]}};
        rt.recenter_time = rt.now + (int64_t)(4e6 * rt.script.period);
        const XrPosef inverse = pose_inverse(&rt.local_origin);
        XrEventDataReferenceSpaceChangePending event = {.type = XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING,
                                                        .session = (XrSession)rt.session,
                                                        .referenceSpaceType = XR_REFERENCE_SPACE_TYPE_LOCAL,
                                                        .changeTime = rt.recenter_time,
                                                        .poseValid = XR_TRUE,
                                                        .poseInPreviousSpace = pose_mul(&inverse, &rt.recentered)};
        push_event(&event, sizeof event);
    }
    if (strcmp(m->what, "hide") == 0) { /* frames */
        rt.hidden_frames = (uint32_t)m->numbers[0];
        if (rt.state == XR_SESSION_STATE_FOCUSED) set_state(XR_SESSION_STATE_VISIBLE);
        set_state(XR_SESSION_STATE_SYNCHRONIZED);
    }
    if (strcmp(m->what, "pause") == 0 || strcmp(m->what, "exit") == 0) { /* polls until it may go on */
        rt.pausing = strcmp(m->what, "pause") == 0;
        rt.pause_polls = (uint32_t)m->numbers[0];
        if (rt.state == XR_SESSION_STATE_FOCUSED) set_state(XR_SESSION_STATE_VISIBLE);
        if (rt.state == XR_SESSION_STATE_VISIBLE) set_state(XR_SESSION_STATE_SYNCHRONIZED);
        set_state(XR_SESSION_STATE_STOPPING);
    }
}

static XRAPI_ATTR XrResult XRAPI_CALL callWaitFrame(XrSession session, const XrFrameWaitInfo *info, XrFrameState *out) {
    SESSION(session);
    RUNNING();
    if (info) CHECK_TYPE(info, XR_TYPE_FRAME_WAIT_INFO);
    CHECK_TYPE(out, XR_TYPE_FRAME_STATE);
    if (rt.waited) return mistake(XR_ERROR_CALL_ORDER_INVALID, "called twice without xrBeginFrame: a real runtime would wait for ever");
    const int64_t period = (int64_t)(rt.script.period * 1e6);
    rt.frame++;
    /* An application is woken two periods before its picture is shown. */
    rt.wake += period;
    if (rt.wake < rt.now) rt.wake += (rt.now - rt.wake + period - 1) / period * period;
    rt.now = rt.wake;
    rt.waited_display = rt.wake + 2 * period;
    rt.waited = true;
    if (rt.recenter_time >= 0 && rt.now >= rt.recenter_time) {
        rt.local_origin = rt.recentered;
        rt.recenter_time = -1;
    }
    for (uint32_t i = 0; i < rt.script.moment_count; i++) {
        struct moment *m = &rt.script.moments[i];
        if (m->frame != rt.frame || m->done) continue;
        m->done = true;
        happen(m);
    }
    XrResult lost;
    if (is_lost(&lost)) return lost;
    out->predictedDisplayTime = rt.waited_display;
    out->predictedDisplayPeriod = period;
    out->shouldRender = rt.state == XR_SESSION_STATE_VISIBLE || rt.state == XR_SESSION_STATE_FOCUSED;
    return XR_SUCCESS;
}

static XRAPI_ATTR XrResult XRAPI_CALL callBeginFrame(XrSession session, const XrFrameBeginInfo *info) {
    SESSION(session);
    RUNNING();
    if (info) CHECK_TYPE(info, XR_TYPE_FRAME_BEGIN_INFO);
    if (!rt.waited) return mistake(XR_ERROR_CALL_ORDER_INVALID, "without xrWaitFrame");
    const bool discarded = rt.begun;
    rt.waited = false;
    rt.begun = true;
    rt.has_given = false;
    rt.given_count = 0;
    rt.begun_display = rt.waited_display;
    return discarded ? XR_FRAME_DISCARDED : XR_SUCCESS;
}

static XRAPI_ATTR XrResult XRAPI_CALL callLocateViews(XrSession session, const XrViewLocateInfo *info, XrViewState *state, uint32_t capacity, uint32_t *count, XrView *out) {
    SESSION(session);
    CHECK_TYPE(info, XR_TYPE_VIEW_LOCATE_INFO);
    CHECK_TYPE(state, XR_TYPE_VIEW_STATE);
    const struct object *space = find_object(info->space, KIND_SPACE);
    if (!space) return mistake(XR_ERROR_HANDLE_INVALID, "the space is none");
    if (info->displayTime <= 0) return mistake(XR_ERROR_TIME_INVALID, "the time is %lld", (long long)info->displayTime);
    if (info->viewConfigurationType != rt.configuration) return mistake(XR_ERROR_VALIDATION_FAILURE, "the session's views are of another type");
    *count = rt.configuration == XR_VIEW_CONFIGURATION_TYPE_PRIMARY_QUAD_VARJO ? 4 : rt.script.view_count == 1 ? 1 : 2;
    if (capacity == 0) return XR_SUCCESS;
    if (capacity < *count) return XR_ERROR_SIZE_INSUFFICIENT;
    const XrPosef head = predicted_head(rt.now, info->displayTime), origin = space_in_stage(space, info->displayTime), inverse = pose_inverse(&origin);
    state->viewStateFlags = XR_VIEW_STATE_ORIENTATION_VALID_BIT | XR_VIEW_STATE_POSITION_VALID_BIT | XR_VIEW_STATE_ORIENTATION_TRACKED_BIT | XR_VIEW_STATE_POSITION_TRACKED_BIT;
    const bool now = rt.begun && info->displayTime == rt.begun_display;
    for (uint32_t i = 0; i < *count; i++) {
        CHECK_TYPE(&out[i], XR_TYPE_VIEW);
        const XrPosef eye = pose_mul(&head, &rt.script.eye[i]);
        out[i].pose = pose_mul(&inverse, &eye);
        if (rt.frame < rt.bad_until && i + 1 == *count) out[i].pose.orientation.y = NAN;
        out[i].fov = rt.script.fov[i];
        if (now) rt.given[i] = out[i];
    }
    if (now) {
        rt.has_given = true;
        rt.given_space = (struct object *)space;
        if (rt.given_count < 8) rt.given_head[rt.given_count++] = head;
    }
    return XR_SUCCESS;
}

/* ---- what is submitted ---- */

static XrResult check_part(const XrSwapchainSubImage *image, const char *what, bool depth, const struct swapchain **out) {
    const struct object *object = find_object(image->swapchain, KIND_SWAPCHAIN);
    if (!object) return mistake(XR_ERROR_HANDLE_INVALID, "the swapchain of the %s is none", what);
    const struct swapchain *chain = *out = &object->swapchain;
    const XrRect2Di *r = &image->imageRect;
    if (chain->is_depth != depth) return mistake(XR_ERROR_LAYER_INVALID, "the %s has format %lld", what, (long long)chain->info.format);
    if (chain->acquired >= 0) return mistake(XR_ERROR_LAYER_INVALID, "the image of the %s was not released", what);
    if (chain->released < 0) return mistake(XR_ERROR_LAYER_INVALID, "no image of the %s was ever released", what);
    if (image->imageArrayIndex >= chain->info.arraySize) return mistake(XR_ERROR_VALIDATION_FAILURE, "the %s has no layer %u", what, image->imageArrayIndex);
    if (r->offset.x < 0 || r->offset.y < 0 || r->extent.width <= 0 || r->extent.height <= 0 || (uint32_t)(r->offset.x + r->extent.width) > chain->info.width ||
        (uint32_t)(r->offset.y + r->extent.height) > chain->info.height)
        return mistake(XR_ERROR_SWAPCHAIN_RECT_INVALID, "the rectangle of the %s, %dx%d at %d,%d, is not inside of %ux%u", what, r->extent.width, r->extent.height,
                       r->offset.x, r->offset.y, chain->info.width, chain->info.height);
    return XR_SUCCESS;
}

static void save(const char *name, uint32_t view, const struct swapchain *chain, const XrSwapchainSubImage *image) {
    char path[640];
    if (rt.frame < rt.script.save_first || rt.frame >= rt.script.save_first + rt.script.save_count) return;
    snprintf(path, sizeof path, "%s/%s-%u-%u.raw", rt.script.save, name, rt.frame, view);
    if (!image_save(chain, image->imageArrayIndex, &image->imageRect, path)) mistake(XR_SUCCESS, "%s cannot be written", path);
}

/* What the program was told of the views: position, rotation, and the field of view in radians: left, right, down, up. */
static void save_views(uint32_t count) {
    char path[640];
    if (rt.frame < rt.script.save_first || rt.frame >= rt.script.save_first + rt.script.save_count) return;
    snprintf(path, sizeof path, "%s/views-%u.txt", rt.script.save, rt.frame);
    FILE *file = fopen(path, "w");
    for (uint32_t i = 0; file && i < count; i++) {
        const XrPosef *p = &rt.given[i].pose;
        const XrFovf *f = &rt.given[i].fov;
        fprintf(file, "%.9g %.9g %.9g %.9g %.9g %.9g %.9g %.9g %.9g %.9g %.9g\n", (double)p->position.x, (double)p->position.y, (double)p->position.z,
                (double)p->orientation.x, (double)p->orientation.y, (double)p->orientation.z, (double)p->orientation.w, (double)f->angleLeft, (double)f->angleRight,
                (double)f->angleDown, (double)f->angleUp);
    }
    if (!file || fclose(file) != 0) mistake(XR_SUCCESS, "%s cannot be written", path);
}

static XrResult check_depth(const XrCompositionLayerDepthInfoKHR *depth, const XrSwapchainSubImage *color, uint32_t view) {
    const struct swapchain *chain;
    if (!rt.ext_depth) return mistake(XR_ERROR_LAYER_INVALID, "depth, but XR_KHR_composition_layer_depth is not enabled");
    const XrResult result = check_part(&depth->subImage, "depth", true, &chain);
    if (result != XR_SUCCESS) return result;
    if (!(depth->minDepth >= 0 && depth->minDepth < depth->maxDepth && depth->maxDepth <= 1))
        return mistake(XR_ERROR_LAYER_INVALID, "depth from %g to %g", (double)depth->minDepth, (double)depth->maxDepth);
    if (!(depth->nearZ > 0) || !(depth->farZ > 0) || depth->nearZ == depth->farZ)
        return mistake(XR_ERROR_LAYER_INVALID, "nearZ %g, farZ %g", (double)depth->nearZ, (double)depth->farZ);
    if (depth->subImage.imageRect.extent.width != color->imageRect.extent.width || depth->subImage.imageRect.extent.height != color->imageRect.extent.height)
        return mistake(XR_ERROR_LAYER_INVALID, "depth and colour have not the same size");
    if (view == 0) note("depth from %g to %g, nearZ %g, farZ %g", (double)depth->minDepth, (double)depth->maxDepth, (double)depth->nearZ, (double)depth->farZ);
    save("depth", view, chain, &depth->subImage);
    return XR_SUCCESS;
}

static XrResult check_projection(const XrCompositionLayerProjection *layer, bool *has_depth, XrRect2Di *rect) {
    const struct object *space = find_object(layer->space, KIND_SPACE);
    const uint32_t count = rt.configuration == XR_VIEW_CONFIGURATION_TYPE_PRIMARY_QUAD_VARJO ? 4 : rt.script.view_count == 1 ? 1 : 2;
    if (!space) return mistake(XR_ERROR_HANDLE_INVALID, "the layer's space is none");
    if (layer->viewCount != count || !layer->views) return mistake(XR_ERROR_VALIDATION_FAILURE, "the layer has %u views, must have %u", layer->viewCount, count);
    if (!rt.has_given || rt.given_space != space) return mistake(XR_ERROR_LAYER_INVALID, "no views were located for this frame and space");
    for (uint32_t i = 0; i < count; i++) {
        const XrCompositionLayerProjectionView *view = &layer->views[i];
        const struct swapchain *chain;
        CHECK_TYPE(view, XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW);
        if (memcmp(&view->pose, &rt.given[i].pose, sizeof view->pose) != 0) return mistake(XR_ERROR_LAYER_INVALID, "view %u has another pose than was given", i);
        if (memcmp(&view->fov, &rt.given[i].fov, sizeof view->fov) != 0) return mistake(XR_ERROR_LAYER_INVALID, "view %u has another field of view than was given", i);
        const XrResult result = check_part(&view->subImage, "picture", false, &chain);
        if (result != XR_SUCCESS) return result;
        if (i == 0) *rect = view->subImage.imageRect;
        save("color", i, chain, &view->subImage);
        for (const XrBaseInStructure *s = view->next; s; s = s->next) {
            if (s->type != XR_TYPE_COMPOSITION_LAYER_DEPTH_INFO_KHR) continue;
            const XrResult deep = check_depth((const XrCompositionLayerDepthInfoKHR *)(const void *)s, &view->subImage, i);
            if (deep != XR_SUCCESS) return deep;
            *has_depth = true;
        }
    }
    save_views(count);
    return XR_SUCCESS;
}

static XRAPI_ATTR XrResult XRAPI_CALL callEndFrame(XrSession session, const XrFrameEndInfo *info) {
    SESSION(session);
    RUNNING();
    CHECK_TYPE(info, XR_TYPE_FRAME_END_INFO);
    if (!rt.begun) return mistake(XR_ERROR_CALL_ORDER_INVALID, "without xrBeginFrame");
    if (info->displayTime != rt.begun_display) return mistake(XR_ERROR_TIME_INVALID, "displayTime is not the one that xrWaitFrame predicted");
    if (info->environmentBlendMode != XR_ENVIRONMENT_BLEND_MODE_OPAQUE) return mistake(XR_ERROR_ENVIRONMENT_BLEND_MODE_UNSUPPORTED, "the blend mode was not offered");
    if (info->layerCount > LAYERS) return mistake(XR_ERROR_LAYER_LIMIT_EXCEEDED, "%u layers", info->layerCount);
    bool has_depth = false;
    XrRect2Di rect = {{0, 0}, {0, 0}};
    for (uint32_t i = 0; i < info->layerCount; i++) {
        const XrCompositionLayerBaseHeader *layer = info->layers[i];
        if (!layer) return mistake(XR_ERROR_LAYER_INVALID, "layer %u is NULL", i);
        if (layer->type != XR_TYPE_COMPOSITION_LAYER_PROJECTION) return mistake(XR_ERROR_LAYER_INVALID, "layer %u has type %d", i, (int)layer->type);
        const XrResult result = check_projection((const XrCompositionLayerProjection *)(const void *)layer, &has_depth, &rect);
        if (result != XR_SUCCESS) return result;
    }
    if (info->layerCount && rt.state != XR_SESSION_STATE_VISIBLE && rt.state != XR_SESSION_STATE_FOCUSED) note("a picture that nobody sees");
    note("frame %u display %lld layers %u depth %d rect %dx%d", rt.frame, (long long)info->displayTime, info->layerCount, has_depth, rect.extent.width, rect.extent.height);
    if (rt.given_count >= 2 && info->layerCount) { /* how far off: what the program knew first, what it knew last, what the compositor knows now */
        const XrPosef truth = true_head(rt.begun_display), warp = predicted_head(rt.now, rt.begun_display);
        note("prediction %.9f %.9f %.9f m %.9f %.9f %.9f rad", pose_distance(&truth, &rt.given_head[0]), pose_distance(&truth, &rt.given_head[rt.given_count - 1]),
             pose_distance(&truth, &warp), pose_angle(&truth, &rt.given_head[0]), pose_angle(&truth, &rt.given_head[rt.given_count - 1]), pose_angle(&truth, &warp));
    }
    rt.begun = false;
    rt.ended++;
    if (rt.hidden_frames > 0) rt.hidden_frames--;
    else if (rt.state == XR_SESSION_STATE_SYNCHRONIZED && !rt.exit_requested) set_state(XR_SESSION_STATE_VISIBLE);
    else if (rt.state == XR_SESSION_STATE_VISIBLE && !rt.exit_requested) set_state(XR_SESSION_STATE_FOCUSED);
    return XR_SUCCESS;
}

PFN_xrVoidFunction frame_function(const char *name) {
    FUNCTION(EnumerateSwapchainFormats, name)
    FUNCTION(CreateSwapchain, name)
    FUNCTION(DestroySwapchain, name)
    FUNCTION(EnumerateSwapchainImages, name)
    FUNCTION(AcquireSwapchainImage, name)
    FUNCTION(WaitSwapchainImage, name)
    FUNCTION(ReleaseSwapchainImage, name)
    FUNCTION(WaitFrame, name)
    FUNCTION(BeginFrame, name)
    FUNCTION(EndFrame, name)
    FUNCTION(LocateViews, name)
    return NULL;
}
