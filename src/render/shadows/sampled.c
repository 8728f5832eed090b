/* SPDX-License-Identifier: MIT */
#include "render/shadows/sampled.h"

#include "passes/shadow/guide.h"
#include "render/shadows/method.h"
#include "render/temporal.h"

/* ---- guided ---- */

struct shade_guide shadow_sampled_guide(struct frame_state *f) {
    const bool moves = f->temporal.keeps && !f->temporal.still;
    if (moves) temporal_add_motion(f);
    const struct guide_input input = {.view = f->view_address,
                                      .width = f->frame->width,
                                      .height = f->frame->height,
                                      .motion = moves ? f->temporal.motion : (graph_image){0},
                                      .keeps = f->temporal.keeps,
                                      .adverse = renderer_tests(f->r).guide_adverse};
    return guide_add(f->graph, &input);
}

/* ---- denoised ---- */

void shadow_sampled_denoise(struct frame_state *f, const struct shade_apart *apart) {
    temporal_add_motion(f);
    const struct denoise_input input = {.view = f->view_address,
                                        .previous = f->temporal.keeps ? &f->temporal.previous : NULL,
                                        .depth = f->depth,
                                        .motion = f->temporal.motion,
                                        .apart = apart,
                                        .still = f->temporal.still_frames,
                                        .whole = f->temporal.still_frames >= f->temporal.sequence};
    f->shadows.denoise = denoise_add(f->graph, f->r->device, &input, f->radiance);
}

/* ---- the method ---- */

static fnl_result check(const struct call *call, const fnl_renderer *r, const fnl_frame *frame) {
    UNUSED(r);
    const bool denoised = shadows_denoised(frame);
    if (!(denoised || shadows_guided(frame)) || frame->shading == FNL_SHADING_DEFERRED) return FNL_OK;
    return unsupported(call, "shadow.%s needs deferred shading, not %s", denoised ? "denoise" : "guide", fnl_value_name(FNL_ENUM_SHADING, frame->shading));
}

static void begin_view(struct frame_state *f) {
    struct shadows *shadows = &f->lighting.shadows;
    shadows->bits |= GPU_LIGHTING_SAMPLED;
    shadows->ray_count = f->frame->shadow.rays;
    shadows->seed = f->frame->shadow.seed + MAX(f->temporal.index, f->temporal.sequence);
}

/* Noise in what is captured would last. */
const struct shadow_method shadow_method_sampled = {.traits = SHADOWS_RAYS | SHADOWS_CHOSEN, .captured_as = FNL_SHADOWS_RAYS, .check = check, .begin_view = begin_view};
