/* SPDX-License-Identifier: MIT */
#include "render/orders/order.h"

#include "render/debug_views.h"
#include "render/shading.h"

#include "passes/debug/colors_shared.h"
#include "passes/shade/coarse.h"

/* passes/shade/coarse_shared.h */
struct coarse_counts {
    uint32_t blocks[COARSE_COUNTS];
};
static const struct counter_table counters_coarse;

static fnl_result check(const struct call *call, const fnl_renderer *r, const fnl_frame *frame) {
    if (frame->coarse.criterion == FNL_COARSE_CRITERION_ID && !gpu_info(r->device)->primitive_ids)
        return unsupported(call, "this device has no primitive_ids, which coarse.criterion=id needs; use z");
    for (uint32_t i = 0; frame->coarse.fovea > 0 && i < MAX(frame->view_count, 1); i++)
        if ((frame->view_count ? &frame->views[i] : &frame->camera)->orthographic)
            return unsupported(call, "coarse.fovea is an angle from where the viewer looks, and the camera of view %u is orthographic", i);
    return FNL_OK;
}

/* Where the viewer looks, seen from a view; without a gaze, or at the eye itself, straight ahead. */
static vec3 gaze_in(const struct gpu_view *view, const fnl_vec3 *gaze) {
    const vec3 ahead = {0, 0, -1};
    if (!gaze) return ahead;
    const vec3 to = vec3_sub(*gaze, view->eye);
    const float *m = view->view_to_world.m;
    const vec3 seen = {vec3_dot(to, (vec3){m[0], m[1], m[2]}), vec3_dot(to, (vec3){m[4], m[5], m[6]}), vec3_dot(to, (vec3){m[8], m[9], m[10]})};
    return vec3_length(seen) > 0 ? vec3_normalize(seen) : ahead;
}

static void add(struct frame_state *f, struct shade_input *input, bool prepass) {
    fnl_debug_view view = f->frame->debug;
    struct coarse_params params = {.options = f->frame->coarse,
                                   .samplers = coarse_has_samplers(f->r->device) && !renderer_tests(f->r).no_minmax,
                                   .words = view == FNL_DEBUG_COARSE || view == FNL_DEBUG_COARSE_REASON,
                                   .gaze = gaze_in(&f->view, f->frame->gaze)};
    struct gbuffer gbuffer = coarse_gbuffer_add(f->graph, input, &params, prepass, f->radiance, f->depth);
    order_add_lists(f, f->depth, &gbuffer);
    struct coarse coarse = coarse_add(f->graph, f->r->device, input, &params, &gbuffer, f->radiance);
    f->stored.gbuffer = gbuffer;
    order_note_gbuffer(f, coarse_extra_bytes(&params.options));
    COUNTERS_COPY(f, coarse.counts, 0, coarse, blocks);
    f->stored.coarse_words = coarse.words;
}

static void add_view(struct frame_state *f, bool swap) {
    debug_views_add_counts(f, (struct debug_counts){f->stored.coarse_words, 1}, swap);
}

static const struct debug_legend_color kinds_shared[] = {{DEBUG_COARSE_SHARED(LEGEND_COLOR), "shaded once"},
                                                         {DEBUG_COARSE_HALF(LEGEND_COLOR), "2x2 once (fovea)"},
                                                         {DEBUG_COARSE_EACH(LEGEND_COLOR), "each pixel (fovea)"}};
static const struct debug_legend_color kinds[] = {{DEBUG_COARSE_SHARED(LEGEND_COLOR), "shaded once"},
                                                  {DEBUG_COARSE_DEPTH(LEGEND_COLOR), "depth or triangle"},
                                                  {DEBUG_COARSE_NORMAL(LEGEND_COLOR), "normal"},
                                                  {DEBUG_COARSE_OTHER(LEGEND_COLOR), "material"},
                                                  {DEBUG_COARSE_EACH(LEGEND_COLOR), "gaze"}};

static const struct debug_view views[] = {
    {FNL_DEBUG_COARSE, LEGEND_COLORS("grey: other blocks", kinds_shared), .surfaces = true, .add = add_view},
    {FNL_DEBUG_COARSE_REASON, LEGEND_COLORS("what keeps a block from being shaded once", kinds), .surfaces = true, .add = add_view},
};

static const struct counter rows[] = {
    {"coarse.blocks", "blocks", "blocks that show a surface",
     COUNTED_SUM(coarse, blocks[COARSE_SHARED], COARSE_KINDS - COARSE_SHARED)},
    {"coarse.shared", "blocks", "blocks shaded once", COUNTED(coarse, blocks[COARSE_SHARED])},
    {"coarse.by-depth", "blocks", "blocks shaded pixel by pixel because depths or triangles differ",
     COUNTED(coarse, blocks[COARSE_DEPTH])},
    {"coarse.by-normal", "blocks", "blocks shaded pixel by pixel because normals differ", COUNTED(coarse, blocks[COARSE_NORMAL])},
    {"coarse.by-material", "blocks", "blocks shaded pixel by pixel because materials differ", COUNTED(coarse, blocks[COARSE_OTHER])},
    {"coarse.by-gaze", "blocks", "blocks shaded pixel by pixel because the viewer looks there", COUNTED(coarse, blocks[COARSE_EACH]), .needs = "coarse.fovea"},
    {"coarse.halves", "blocks", "blocks of 4x4 of which each 2x2 pixels are shaded once", COUNTED(coarse, blocks[COARSE_HALF]), .needs = "coarse.fovea"},
    {"coarse.pixels", "pixels", "pixels that show a surface", COUNTED(coarse, blocks[COARSE_COUNT_PIXELS])},
    {"coarse.shaded", "", "how often a pixel, a block or a quarter of one was shaded", COUNTED(coarse, blocks[COARSE_COUNT_SHADED])},
    {"coarse.ao-shaded", "", "how often ambient occlusion was computed", COUNTED(coarse, blocks[COARSE_COUNT_AO]),
     .needs = "coarse.ao-radius"},
};
static const struct counter_table counters_coarse = COUNTER_TABLE_COUNTED(rows, coarse);

const struct order order_coarse = {.traits = SHADING_FULL_RASTER | SHADING_GBUFFER | SHADING_MAY_PREPASS |
                                             SHADING_POSITIONS | SHADING_APPROXIMATE | SHADING_VIEWS,
                                   .check = check,
                                   .add = add,
                                   .views = views,
                                   .view_count = COUNT_OF(views),
                                   .counters = &counters_coarse};
