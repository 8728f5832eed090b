/* SPDX-License-Identifier: MIT */
#include "render/decals.h"
#include "render/orders.h"

#include "passes/visibility/visibility.h"

_Static_assert((int)FNL_VISIBILITY_SORT_CLASS == VISIBILITY_SORT_CLASS &&
                   (int)FNL_VISIBILITY_SORT_COUNT == VISIBILITY_SORT_MATERIAL + 1,
               "visibility.h has the values of fnl_visibility_sort");

void order_visibility(struct frame_state *f, struct shade_input *input, bool prepass) {
    UNUSED(prepass);
    const fnl_visibility_options *options = &f->frame->visibility;
    uint32_t bits = f->r->visibility_bits;
    struct visibility visibility;
    if (options->grid && !decals_redraws(f)) /* which look for the very depth of pixels' centres */
        visibility = visibility_grid_add(f->graph, f->r->device, input, &f->view, bits, f->depth);
    else
        visibility = visibility_add(f->graph, input, bits, options->barycentrics, f->depth);
    order_add_lists(f, f->depth, NULL);
    enum visibility_sort sort = (enum visibility_sort)options->sort;
    struct visibility_shaded shaded = visibility_shade_add(f->graph, input, &visibility, sort, f->radiance);
    f->visible_ranges = shaded.ranges;
    f->visible_fragments = visibility.fragments;
    f->surfaces = shaded.words;
    f->edge_counts = shaded.counts;
}
