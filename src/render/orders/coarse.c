/* SPDX-License-Identifier: MIT */
#include "render/orders/order.h"

#include "passes/shade/coarse.h"

static fnl_result check(const struct call *call, const fnl_renderer *r, const fnl_frame *frame) {
    if (frame->coarse.criterion == FNL_COARSE_CRITERION_ID && !gpu_info(r->device)->primitive_ids)
        return unsupported(call, "this device has no primitive_ids, which coarse.criterion=id needs; use z");
    return FNL_OK;
}

static void add(struct frame_state *f, struct shade_input *input, bool prepass) {
    fnl_debug_view view = f->frame->debug;
    struct coarse_params params = {.options = f->frame->coarse,
                                   .samplers = coarse_has_samplers(f->r->device) && !renderer_tests(f->r).no_minmax,
                                   .words = view == FNL_DEBUG_COARSE || view == FNL_DEBUG_COARSE_REASON};
    struct gbuffer gbuffer = coarse_gbuffer_add(f->graph, input, &params, prepass, f->radiance, f->depth);
    order_add_lists(f, f->depth, &gbuffer);
    struct coarse coarse = coarse_add(f->graph, f->r->device, input, &params, &gbuffer, f->radiance);
    f->gbuffer = gbuffer;
    f->coarse_bytes = coarse_extra_bytes(&params.options);
    f->coarse_counts = coarse.counts;
    f->coarse_words = coarse.words;
}

static void add_view(struct frame_state *f, bool swap) {
    debug_views_add_counts(f, (struct debug_counts){f->coarse_words, 1}, swap);
}

static const struct debug_view views[] = {
    {FNL_DEBUG_COARSE, .surfaces = true, .add = add_view},
    {FNL_DEBUG_COARSE_REASON, .surfaces = true, .add = add_view},
};

const struct order order_coarse = {
    .traits = SHADING_FULL_RASTER | SHADING_GBUFFER | SHADING_MAY_PREPASS | SHADING_POSITIONS | SHADING_APPROXIMATE | SHADING_VIEWS,
    .check = check,
    .add = add,
    .views = views,
    .view_count = COUNT_OF(views)};
