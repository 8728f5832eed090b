/* SPDX-License-Identifier: MIT */
#include "render/temporal.h"

#include "passes/aa/taa.h"
#include "render/frame_state.h"
#include "render/options.h"
#include "render/traits.h"
#include "render/view.h"
#include "render/step.h"

bool temporal_needs_motion(const fnl_frame *frame) {
    return frame->aa == FNL_ANTIALIASING_TAA || shadows_denoised(frame) || shadows_guided(frame) || frame->debug == FNL_DEBUG_MOTION || frame->outputs & FNL_OUTPUT_MOTION;
}

/* Is the last frame one of the same camera at the same scene? */
static bool keeps(const struct frame_state *f, const struct gpu_view *view) {
    const struct temporal_state *s = &f->kept->temporal;
    return s->valid && !f->scene->lost && !f->frame->reset_history && s->frame.view_count == f->frame->view_count &&
           s->view.size.x == view->size.x && s->view.size.y == view->size.y && s->view.orthographic == view->orthographic;
}

/* Is what frames have collected so far a picture of the same scene? Not if they had no textures yet. */
static bool collects(const struct frame_state *f) {
    const struct temporal_state *s = &f->kept->temporal;
    return f->temporal.keeps && s->frame.aa == FNL_ANTIALIASING_TAA && s->image_arrivals == f->r->device_scene->image_arrivals;
}

/* Would the last frame, but for its jitter, have been this one? */
static bool is_still(const struct frame_state *f, const struct gpu_view *view) {
    const struct temporal_state *s = &f->kept->temporal;
    const fnl_scene *scene = f->r->scene;
    fnl_frame last = s->frame;
    last.jitter = f->frame->jitter;
    last.reset_history = f->frame->reset_history;
    return !f->scene->moved && s->uploads == f->r->device_scene->upload_count && s->light_version == scene->light_version &&
           s->shadow_requests == scene->shadow_requests && s->decal_version == scene->decal_version && s->probe_version == scene->probe_version &&
           s->view.mask == view->mask && memcmp(&s->view.world_to_clip, &view->world_to_clip, sizeof view->world_to_clip) == 0 &&
           memcmp(&s->background, &scene->background, sizeof scene->background) == 0 && options_equal(f->frame, &last);
}

/* The jitter of the frame, with that of its place in the sequence of temporal antialiasing. */
static vec2 choose_jitter(struct frame_state *f) {
    vec2 jitter = f->frame->jitter;
    if (f->frame->aa != FNL_ANTIALIASING_TAA) return jitter;
    f->temporal.index = collects(f) ? f->kept->temporal.index + 1 : 0;
    const vec2 place = pixel_jitter(f->temporal.index);
    return (vec2){jitter.x + place.x, jitter.y + place.y};
}

fnl_camera frame_camera(const struct frame_state *f) {
    const struct device_scene *d = f->r->device_scene;
    return view_fit_depth(&f->frame->camera, &d->bounds, d->deformed.count > 0);
}

void temporal_begin(struct frame_state *f) {
    struct frame_temporal *t = &f->temporal;
    const struct temporal_state *s = &f->kept->temporal;
    const fnl_camera camera = frame_camera(f);
    t->view = view_from_camera(&camera, f->frame->width, f->frame->height);
    for (int i = 0; i < 3; i++) t->origin_moved[i] = f->r->scene->origin[i] - s->origin[i];
    t->previous = view_with_origin(&s->view, t->origin_moved);
    t->keeps = keeps(f, &t->view);
    t->still = t->keeps && is_still(f, &t->view);
    t->still_frames = t->still ? s->still + 1 : 0;
    if (shadows_denoised(f->frame) || shadows_guided(f->frame)) t->sequence = t->keeps ? s->sequence + 1 : 0;
    t->jitter = choose_jitter(f);
    t->same = t->still && t->jitter.x == s->jitter.x && t->jitter.y == s->jitter.y && !f->frame->hidden_areas;
}

/* `depth`: of opaque surfaces. */
static void add_motion(struct frame_state *f, graph_image depth) {
    struct frame_temporal *t = &f->temporal;
    if (t->motion.id) return;
    const struct device_previous *previous = &f->scene->previous_layout;
    struct motion_input input = {.view = f->view_address,
                                 .current = &f->view,
                                 .previous = t->keeps ? &t->previous : NULL,
                                 .jitter = t->jitter,
                                 .depth = depth,
                                 .objects = {.scene = &f->scene->geometry,
                                             .draws = &f->draws,
                                             .previous = f->scene->previous,
                                             .position_offset = device_previous_offset(previous),
                                             .origin_moved = {(float)t->origin_moved[0], (float)t->origin_moved[1], (float)t->origin_moved[2]},
                                             .instance_count = previous->instance_count,
                                             .first_deformed = previous->first_deformed,
                                             .deformed_count = previous->deformed_count}};
    t->motion = motion_add(f->graph, f->r->device, &input);
}

void temporal_add_motion(struct frame_state *f) { add_motion(f, f->depth); }

/* Motion vectors; with temporal antialiasing f->radiance becomes the accumulated radiance. */
static void collect(struct frame_state *f) {
    struct frame_temporal *t = &f->temporal;
    const fnl_frame *frame = f->frame;
    if (!temporal_needs_motion(frame)) return;
    graph_image depth = f->depth;
    if (!depth.id)
        depth = motion_depth_add(f->graph, &f->scene->geometry, &f->draws, f->view_address, frame->width, frame->height);
    add_motion(f, depth);
    if (frame->aa != FNL_ANTIALIASING_TAA) return;
    struct taa_params params = {.view = f->view_address,
                                .depth = depth,
                                .motion = t->motion,
                                .exposure = f->exposure,
                                .factor = frame->exposure == FNL_EXPOSURE_EV ? 1 / (1.2f * exp2f(frame->ev)) : 1,
                                .tonemap = (uint32_t)frame->tonemap,
                                .keeps = collects(f),
                                .still = t->still};
    f->radiance = taa_add(f->graph, f->radiance, &params);
}

static void finish_view(struct frame_state *f) {
    graph_set_role(f->graph, GRAPH_ROLE_REST);
    collect(f);
    f->made->temporal = (struct temporal_state){.valid = true,
                                                .view = f->temporal.view,
                                                .origin = {f->r->scene->origin[0], f->r->scene->origin[1], f->r->scene->origin[2]},
                                                .jitter = f->temporal.jitter,
                                                .uploads = f->r->device_scene->upload_count,
                                                .light_version = f->r->scene->light_version,
                                                .decal_version = f->r->scene->decal_version,
                                                .probe_version = f->r->scene->probe_version,
                                                .shadow_requests = f->r->scene->shadow_requests,
                                                .image_arrivals = f->r->device_scene->image_arrivals,
                                                .background = f->r->scene->background,
                                                .frame = *f->frame,
                                                .index = f->temporal.index,
                                                .sequence = f->temporal.sequence,
                                                .still = f->temporal.still_frames};
}

static void submitted(fnl_renderer *r, const fnl_frame *frame) {
    for (uint32_t i = 0; i < frame_camera_count(frame); i++) r->views.data[i].temporal = r->last.data[i].temporal;
}

static fnl_result check(const struct call *call, fnl_renderer *r, const fnl_frame *frame) {
    UNUSED(r);
    if (!temporal_needs_motion(frame) || frame->msaa == 1) return FNL_OK;
    return unsupported(call, "motion vectors and temporal antialiasing need 1 sample per pixel, not %u", frame->msaa);
}

static void forget(fnl_renderer *r) {
    for (uint32_t i = 0; i < r->views.count; i++) r->views.data[i].temporal.valid = false;
}

const struct frame_step step_temporal = {.name = "temporal", .check = check, .finish_view = finish_view, .submitted = submitted, .forget = forget};
