/* SPDX-License-Identifier: MIT */
#include "render/orders/order.h"

#include "passes/debug/colors_shared.h"
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
    order_note_gbuffer(f, coarse_extra_bytes(&params.options));
    COUNTERS_COPY(f, coarse.counts, 0, coarse);
    f->coarse_words = coarse.words;
}

static void add_view(struct frame_state *f, bool swap) {
    debug_views_add_counts(f, (struct debug_counts){f->coarse_words, 1}, swap);
}

static const struct debug_legend_color kinds_shared[] = {{DEBUG_COARSE_SHARED(LEGEND_COLOR), "shaded once"}};
static const struct debug_legend_color kinds[] = {{DEBUG_COARSE_SHARED(LEGEND_COLOR), "shaded once"},
                                                  {DEBUG_COARSE_DEPTH(LEGEND_COLOR), "depth or triangle"},
                                                  {DEBUG_COARSE_NORMAL(LEGEND_COLOR), "normal"},
                                                  {DEBUG_COARSE_OTHER(LEGEND_COLOR), "material"}};

static const struct debug_view views[] = {
    {FNL_DEBUG_COARSE, LEGEND_COLORS("grey: other blocks", kinds_shared), .surfaces = true, .add = add_view},
    {FNL_DEBUG_COARSE_REASON, LEGEND_COLORS("what keeps a block from being shaded once", kinds), .surfaces = true, .add = add_view},
};

static const struct counter counters[] = {
    {"coarse.blocks", "blocks", "blocks that show a surface",
     COUNTED_SUM(coarse[COARSE_SHARED], COARSE_OTHER - COARSE_SHARED + 1)},
    {"coarse.shared", "blocks", "blocks shaded once", COUNTED(coarse[COARSE_SHARED])},
    {"coarse.by-depth", "blocks", "blocks shaded pixel by pixel because depths or triangles differ",
     COUNTED(coarse[COARSE_DEPTH])},
    {"coarse.by-normal", "blocks", "blocks shaded pixel by pixel because normals differ", COUNTED(coarse[COARSE_NORMAL])},
    {"coarse.by-material", "blocks", "blocks shaded pixel by pixel because materials differ", COUNTED(coarse[COARSE_OTHER])},
    {"coarse.pixels", "pixels", "pixels that show a surface", COUNTED(coarse[COARSE_COUNT_PIXELS])},
    {"coarse.shaded", "", "how often a pixel or a block was shaded", COUNTED(coarse[COARSE_COUNT_SHADED])},
    {"coarse.ao-shaded", "", "how often ambient occlusion was computed", COUNTED(coarse[COARSE_COUNT_AO]),
     .needs = "coarse.ao-radius"},
};

const struct order order_coarse = {.traits = SHADING_FULL_RASTER | SHADING_GBUFFER | SHADING_MAY_PREPASS |
                                             SHADING_POSITIONS | SHADING_APPROXIMATE | SHADING_VIEWS,
                                   .check = check,
                                   .add = add,
                                   .views = views,
                                   .view_count = COUNT_OF(views),
                                   .counters = counters,
                                   .counter_count = COUNT_OF(counters)};
