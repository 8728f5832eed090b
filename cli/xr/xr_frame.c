/* SPDX-License-Identifier: MIT */
/*
 * One frame. The head is asked for twice: at first for all that moves with the user, and again when the images are there, just before the frame is
 * recorded. The later pose is the better one: the picture is rendered and handed over with it.
 */
#include "xr/xr.h"

#include "print.h"

#include <stdio.h>
#include <string.h>
#include <time.h>

struct located {
    XrView views[XR_VIEWS];
    fnl_rigid_pose head; /* between the eyes, in the space of play */
    bool valid;
};

static double now_ms(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec * 1e-6;
}

bool xr_is_pose(struct xr *x, enum xr_pose_of of, const XrPosef *pose) {
    static const struct {
        const char *function, *name;
    } kinds[XR_POSES] = {{"xrLocateViews", "a view"}, {"xrLocateSpace", "the gaze"}, {"xrLocateSpace", "a controller"}, {"xrLocateSpace", "the head"}};
    const double most = 1e6; /* metres */
    const XrQuaternionf *q = &pose->orientation;
    const XrVector3f *p = &pose->position;
    const float length = sqrtf(q->x * q->x + q->y * q->y + q->z * q->z + q->w * q->w);
    if (fabsf(length - 1) < 1e-3f && fabs((double)p->x) < most && fabs((double)p->y) < most && fabs((double)p->z) < most) return true;
    if (!x->told_of_poses[of])
        fprintf(stderr, "fanal: warning: %s: the pose of %s is %g, %g, %g metres, quaternion %g, %g, %g, %g (frame %u): it is not used\n", kinds[of].function, kinds[of].name, (double)p->x,
                (double)p->y, (double)p->z, (double)q->x, (double)q->y, (double)q->z, (double)q->w, x->numbers.rendered);
    x->told_of_poses[of] = true;
    return false;
}

static bool locate(struct xr *x, XrTime time, struct located *out) {
    const XrViewLocateInfo info = {.type = XR_TYPE_VIEW_LOCATE_INFO, .viewConfigurationType = x->configuration, .displayTime = time, .space = x->space};
    XrViewState state = {.type = XR_TYPE_VIEW_STATE};
    uint32_t count = 0;
    for (uint32_t i = 0; i < XR_VIEWS; i++) out->views[i] = (XrView){.type = XR_TYPE_VIEW};
    if (!xr_good(x, "xrLocateViews", xrLocateViews(x->session, &info, &state, XR_VIEWS, &count, out->views))) return false;
    const XrViewStateFlags wanted = XR_VIEW_STATE_ORIENTATION_VALID_BIT | XR_VIEW_STATE_POSITION_VALID_BIT;
    out->valid = count == x->view_count && (state.viewStateFlags & wanted) == wanted;
    for (uint32_t i = 0; i < x->view_count && out->valid; i++) out->valid = xr_is_pose(x, XR_POSE_VIEW, &out->views[i].pose);
    const fnl_rigid_pose left = xr_pose(x, &out->views[0].pose), right = xr_pose(x, &out->views[1].pose);
    out->head = (fnl_rigid_pose){scale3(add3(left.position, right.position), 0.5f), left.rotation};
    return true;
}

/* Puts the user where the scene's camera is, looking as it does; after the headset was centred anew, where he is. */
static void place(struct xr *x, const fnl_rigid_pose *head, XrTime time) {
    if (x->replace_at && time >= x->replace_at) {
        x->replace_at = 0;
        x->placed = false;
        x->keeps_place = true;
        x->past_count = 0; /* poses of before are in another space */
        x->numbers.recenters++;
    }
    if (!x->placed) {
        const fnl_vec3 ahead = sub3(x->home.target, x->home.position);
        const bool has_heading = ahead.x != 0 || ahead.z != 0;
        const float yaw = has_heading ? atan2f(-ahead.x, -ahead.z) : 0;
        x->rig.rotation = quat_yaw(yaw - yaw_of(head->rotation));
        const fnl_vec3 goal = x->keeps_place ? x->head_in_world : x->home.position;
        x->rig.position = sub3(goal, quat_turn(x->rig.rotation, head->position));
        x->placed = true;
    }
    x->head_in_world = pose_mul(&x->rig, head).position;
}

static void animate(struct xr *x, XrTime time) {
    if (!x->first_display) x->first_display = time;
    if (x->scene_info.animation_count == 0) return;
    if (!world_set_time(&x->options->world, x->scene, x->options->world.time + (double)(time - x->first_display) * 1e-9)) x->end = XR_FAILED;
}

/* Real-Time Rendering, 4th ed., chapter 21: what makes people sick, and what makes the world look larger or smaller than it is. Told once. */
static void lint(struct xr *x, const struct located *l) {
    const float scale = x->options->world_scale;
    const fnl_vec3 apart = sub3(xr_pose(x, &l->views[1].pose).position, xr_pose(x, &l->views[0].pose).position);
    const float ipd = sqrtf(dot3(apart, apart)) / scale;
    if (!x->told_of_scale && !x->options->quiet && scale != 1) {
        x->told_of_scale = true;
        fprintf(stderr, "fanal: warning: --world-scale %g makes a scene in meters appear %s than life size\n",
                (double)scale, scale > 1 ? "smaller" : "larger");
    }
    if (!x->told_of_eyes && !x->options->quiet && (ipd < 0.052f || ipd > 0.078f)) {
        x->told_of_eyes = true;
        fprintf(stderr, "fanal: warning: the eyes are %g mm apart, those of people 52 to 78 mm\n", (double)ipd * 1000);
    }
    for (uint32_t i = 0; i < x->view_count; i++) {
        const XrFovf *a = &x->fields[i], *b = &l->views[i].fov;
        const bool same = a->angleLeft == b->angleLeft && a->angleRight == b->angleRight && a->angleUp == b->angleUp && a->angleDown == b->angleDown;
        if (x->has_fields && !same && !x->told_of_fields && !x->options->quiet) {
            x->told_of_fields = true;
            fprintf(stderr, "fanal: warning: the field of view changes while the scene is shown (view %u, frame %u): people get sick of that\n", i, x->numbers.rendered);
        }
        x->fields[i] = *b;
    }
    x->has_fields = true;
}

/* ---- rendering ---- */

static bool make_cameras(struct xr *x, const struct xr_group *group, const struct located *l, uint32_t width, uint32_t height, fnl_camera *out) {
    for (uint32_t i = 0; i < group->count; i++) {
        const XrView *view = &l->views[group->first + i];
        const fnl_eye eye = {.pose = xr_pose(x, &view->pose),
                             .left = tanf(view->fov.angleLeft),
                             .right = tanf(view->fov.angleRight),
                             .down = tanf(view->fov.angleDown),
                             .up = tanf(view->fov.angleUp)};
        if (fnl_eye_query_camera(&x->host, &eye, &x->rig, width, height, x->home.near_distance, &out[i]) != FNL_OK) {
            fprintf(stderr, "fanal: error: view %u of the headset cannot be drawn: its field of view is %g to %g, %g to %g radians\n", group->first + i,
                    (double)view->fov.angleLeft, (double)view->fov.angleRight, (double)view->fov.angleDown, (double)view->fov.angleUp);
            x->end = XR_FAILED;
            return false;
        }
    }
    return true;
}

static fnl_vulkan_target target_of(const struct xr *x, const struct xr_group *group, const fnl_frame *frame, VkImage color, VkImage depth) {
    return (fnl_vulkan_target){.image = color,
                               .format = (VkFormat)x->color_format,
                               .initial_layout = VK_IMAGE_LAYOUT_UNDEFINED, /* what is outside of the part is not shown */
                               .final_layout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                               .width = group->width,
                               .height = group->height,
                               .part = {0, 0, frame->width, frame->height, true},
                               .depth = depth,
                               .depth_initial_layout = VK_IMAGE_LAYOUT_UNDEFINED,
                               .depth_final_layout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL,
                               .depth_forward = x->options->forward_depth};
}

bool xr_warm(struct xr *x) {
    const fnl_camera cameras[XR_VIEWS] = {x->home, x->home, x->home, x->home};
    for (uint32_t i = 0; i < x->group_count; i++) {
        const struct xr_group *group = &x->groups[i];
        fnl_frame frame = x->frame;
        xr_scaled_size(x, group, &frame.width, &frame.height);
        frame.views = cameras;
        frame.view_count = group->count;
        frame.stereo.eyes = group->count > 1 ? group->count : 0;
        frame.outputs = 0;
        const fnl_vulkan_target target = target_of(x, group, &frame, group->colors[0].image, group->depth ? group->depths[0].image : VK_NULL_HANDLE);
        if (fnl_renderer_warm(group->renderer, &frame, &target, true, NULL) == FNL_OK) continue;
        x->end = XR_FAILED;
        return false;
    }
    return true;
}

static bool render(struct xr *x, struct xr_group *group, const struct located *l, VkImage color, VkImage depth) {
    fnl_camera cameras[XR_VIEWS];
    fnl_frame frame = x->frame;
    xr_scaled_size(x, group, &frame.width, &frame.height);
    if (!make_cameras(x, group, l, frame.width, frame.height, cameras)) return false;
    frame.camera = cameras[0];
    frame.views = cameras;
    frame.view_count = group->count;
    frame.stereo.eyes = group->count > 1 ? group->count : 0;
    frame.outputs = 0;
    frame.reset_history = x->past_count == 0;
    xr_use_masks(x, group, &frame);
    if (x->gaze_known) frame.gaze = &x->gaze;
    const fnl_vulkan_target target = target_of(x, group, &frame, color, depth);
    if (fnl_renderer_render_to(group->renderer, &frame, &target) != FNL_OK) {
        x->end = XR_FAILED;
        return false;
    }
    struct xr_numbers *n = &x->numbers;
    for (uint32_t i = 0; i < group->count; i++) {
        n->last_cameras[group->first + i] = cameras[i];
        n->last_hidden[group->first + i] = xr_mask_area(&x->masks[group->first + i], &l->views[group->first + i].fov);
        n->last_width[group->first + i] = frame.width;
        n->last_height[group->first + i] = frame.height;
    }
    n->last_count = x->view_count;
    n->last_rig = x->rig;
    group->drawn_width = frame.width;
    group->drawn_height = frame.height;
    group->has_stats = true;
    return true;
}

/* Of the last frame, which is over by now, or about to be. */
static bool note_last(struct xr *x, double cpu) {
    double gpu = 0;
    bool any = false;
    for (uint32_t i = 0; i < x->group_count; i++) {
        fnl_frame_stats stats;
        if (!x->groups[i].has_stats) continue;
        if (fnl_renderer_query_stats(x->groups[i].renderer, &stats) != FNL_OK) {
            x->end = XR_FAILED;
            return false;
        }
        gpu += stats.gpu_milliseconds;
        x->ev = stats.ev;
        x->groups[i].has_stats = false;
        any = true;
    }
    if (any) xr_note_times(x, cpu, gpu);
    return true;
}

static bool draw(struct xr *x, XrTime time, const struct located *simulated, struct located *rendered) {
    VkImage colors[XR_VIEWS], depths[XR_VIEWS];
    for (uint32_t i = 0; i < x->group_count; i++)
        if (!xr_take_images(x, &x->groups[i], &colors[i], &depths[i])) return false;
    if (!locate(x, time, rendered)) return false;
    if (!rendered->valid) *rendered = *simulated;
    lint(x, rendered);
    xr_find_gaze(x, time);
    if (x->end != XR_RUNS) return false;
    for (uint32_t i = 0; i < x->group_count; i++)
        if (!render(x, &x->groups[i], rendered, colors[i], depths[i])) return false;
    for (uint32_t i = 0; i < x->group_count; i++)
        if (!xr_release_images(x, &x->groups[i])) return false;
    return true;
}

/* ---- handing over ---- */

static void end_frame(struct xr *x, XrTime time, const struct located *l) {
    XrCompositionLayerProjectionView views[XR_VIEWS];
    XrCompositionLayerDepthInfoKHR depths[XR_VIEWS];
    for (uint32_t g = 0; g < x->group_count && l; g++) {
        const struct xr_group *group = &x->groups[g];
        for (uint32_t i = 0; i < group->count; i++) {
            const uint32_t view = group->first + i;
            const XrRect2Di rect = {{0, 0}, {(int32_t)group->drawn_width, (int32_t)group->drawn_height}};
            /* Depth falls from 1 at the near distance to 0 at infinity, unless it is turned round. */
            const bool forward = x->options->forward_depth;
            const float near_distance = x->home.near_distance / x->options->world_scale;
            depths[view] = (XrCompositionLayerDepthInfoKHR){.type = XR_TYPE_COMPOSITION_LAYER_DEPTH_INFO_KHR,
                                                            .subImage = {group->depth, rect, i},
                                                            .minDepth = 0,
                                                            .maxDepth = 1,
                                                            .nearZ = forward ? near_distance : INFINITY,
                                                            .farZ = forward ? INFINITY : near_distance};
            views[view] = (XrCompositionLayerProjectionView){.type = XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW,
                                                             .next = group->depth ? &depths[view] : NULL,
                                                             .pose = l->views[view].pose,
                                                             .fov = l->views[view].fov,
                                                             .subImage = {group->color, rect, i}};
        }
    }
    const XrCompositionLayerProjection layer = {.type = XR_TYPE_COMPOSITION_LAYER_PROJECTION, .space = x->space, .viewCount = x->view_count, .views = views};
    const XrCompositionLayerBaseHeader *layers[] = {(const XrCompositionLayerBaseHeader *)&layer};
    const XrFrameEndInfo info = {.type = XR_TYPE_FRAME_END_INFO,
                                 .displayTime = time,
                                 .environmentBlendMode = x->blend,
                                 .layerCount = l ? 1 : 0,
                                 .layers = layers};
    xr_good(x, "xrEndFrame", xrEndFrame(x->session, &info));
}

void xr_run_frame(struct xr *x) {
    static double cpu; /* of the last frame */
    XrFrameState state = {.type = XR_TYPE_FRAME_STATE};
    struct located simulated = {0}, rendered = {0};
    if (!xr_good(x, "xrWaitFrame", xrWaitFrame(x->session, NULL, &state))) return;
    const XrResult begun = xrBeginFrame(x->session, NULL);
    if (!xr_good(x, "xrBeginFrame", begun)) return;
    x->numbers.discarded += begun == XR_FRAME_DISCARDED;
    xr_pace(x, &state);
    if (!note_last(x, cpu)) return;
    const double start = now_ms();
    const XrTime time = state.predictedDisplayTime;
    if (!locate(x, time, &simulated)) return;
    if (simulated.valid) place(x, &simulated.head, time);
    xr_take_input(x, time);
    animate(x, time);
    if (x->end != XR_RUNS) return;
    const bool draws = state.shouldRender && simulated.valid;
    for (uint32_t i = 0; i < x->view_count && x->has_mask && draws; i++)
        if (x->masks[i].version == 0) xr_read_mask(x, i);
    if (draws && (x->end != XR_RUNS || !draw(x, time, &simulated, &rendered))) return;
    end_frame(x, time, draws ? &rendered : NULL);
    if (!draws || x->end != XR_RUNS) return;
    x->numbers.rendered++;
    x->numbers.gaze_frames += x->gaze_known;
    x->numbers.gaze_last = x->gaze_known;
    x->numbers.last_gaze = x->gaze;
    x->numbers.last_display = time;
    xr_note_prediction(x, time, &simulated.head, &rendered.head);
    cpu = now_ms() - start;
}
