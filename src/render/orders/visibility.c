/* SPDX-License-Identifier: MIT */
#include "render/decals.h"
#include "render/orders/order.h"

#include "render/debug_views.h"
#include "render/shading.h"

#include "passes/visibility/visibility.h"

_Static_assert((int)FNL_VISIBILITY_SORT_CLASS == VISIBILITY_SORT_CLASS &&
                   (int)FNL_VISIBILITY_SORT_COUNT == VISIBILITY_SORT_MATERIAL + 1,
               "visibility.h has the values of fnl_visibility_sort");

/* What the GPU counts. */
struct visibility_counts {
    uint32_t fragments;
    uint32_t ranges[GPU_CLASSES][2]; /* first and end of what is listed, by class */
};
static const struct counter_table counters_visibility;

/* A grid of samples looks beside the centres of pixels; barycentrics are stored by a geometry shader, or by vertices of their own. */
static uint32_t adjust(const fnl_frame *frame, uint32_t traits) {
    if (frame->visibility.grid) traits &= ~(uint32_t)(SHADING_FULL_RASTER | SHADING_SURFACES | SHADING_HIDDEN);
    /* The grid, barycentrics and the count of fragments work for one view. */
    if (frame->visibility.grid || frame->visibility.barycentrics || frame->count_lights)
        traits &= ~(uint32_t)SHADING_MULTIVIEW;
    return frame->visibility.barycentrics ? traits | SHADING_VERTICES : traits;
}

static fnl_result check(const struct call *call, const fnl_renderer *r, const fnl_frame *frame) {
    const fnl_visibility_options *o = &frame->visibility;
    if (o->grid && (frame->msaa > 1 || o->barycentrics || !visibility_grid_supported(r->device)))
        return unsupported(call, "visibility.grid needs 1 sample per pixel, no visibility.barycentrics, and a device with 4x MSAA");
    if (o->barycentrics && frame->msaa > 1)
        return unsupported(call, "visibility.barycentrics needs 1 sample per pixel, not %u", frame->msaa);
    return order_check_primitive_ids(call, r, frame);
}

static void draw(struct frame_state *f, struct shade_input *input, bool prepass) {
    UNUSED(prepass);
    const fnl_visibility_options *options = &f->frame->visibility;
    uint32_t bits = renderer_tests(f->r).visibility_bits;
    if (options->grid && !decals_redraws(f)) /* which look for the very depth of pixels' centres */
        f->stored.visibility = visibility_grid_add(f->graph, f->r->device, input, &f->view, bits, f->depth);
    else
        f->stored.visibility = visibility_add(f->graph, input, bits, options->barycentrics, f->depth);
}

static void add(struct frame_state *f, struct shade_input *input, bool prepass) {
    UNUSED(prepass);
    order_add_lists(f, f->depth, NULL);
    enum visibility_sort sort = (enum visibility_sort)f->frame->visibility.sort;
    struct visibility_shaded shaded = visibility_shade_add(f->graph, input, &f->stored.visibility, sort, f->radiance);
    f->stored.surfaces = shaded.words;
    COUNTERS_COPY(f, shaded.ranges, 0, visibility, ranges);
    COUNTERS_COPY(f, f->stored.visibility.fragments, 0, visibility, fragments);
    COUNTERS_COPY(f, shaded.counts, 0, shading, edges);
}

static bool find_entries(const struct counted *counted, uint64_t *value) {
    const struct visibility_counts *counts = COUNTS(counted->counts, visibility);
    for (uint32_t c = 0; c < GPU_CLASSES; c++) *value += counts->ranges[c][1] - counts->ranges[c][0];
    return COUNTED_HAS(counted, visibility, ranges);
}

static bool find_classes(const struct counted *counted, uint64_t *value) {
    const struct visibility_counts *counts = COUNTS(counted->counts, visibility);
    for (uint32_t c = 0; c < GPU_CLASSES; c++) *value += counts->ranges[c][1] > counts->ranges[c][0];
    return COUNTED_HAS(counted, visibility, ranges);
}

static const struct counter rows[] = {
    {"visibility.fragments", "fragments", "how often the id pass wrote an id", COUNTED(visibility, fragments),
     .needs = "count-lights"},
    {"visibility.entries", "", "pixels, or triangles of pixels, to shade: with visibility.sort or MSAA",
     .find = find_entries},
    {"visibility.classes", "classes", "shader classes among those entries", .find = find_classes},
};
static const struct counter_table counters_visibility = COUNTER_TABLE_COUNTED(rows, visibility);

/* Drivers filter explicit gradients in ways of their own: passes/visibility/scenes_test.c compares it without anisotropy. */
const struct order order_visibility = {.traits = SHADING_LAYERS | SHADING_FULL_RASTER | SHADING_ITEMS | SHADING_APPROXIMATE |
                                                 SHADING_SAMPLES | SHADING_SURFACES | SHADING_VIEWS | SHADING_MULTIVIEW | SHADING_HIDDEN,
                                       .adjust = adjust,
                                       .check = check,
                                       .draw = draw,
                                       .add = add,
                                       .counters = &counters_visibility};
