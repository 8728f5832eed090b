/* SPDX-License-Identifier: MIT */
#include "render/orders.h"

#include "passes/visibility/visibility.h"

_Static_assert((int)FNL_VISIBILITY_SORT_CLASS == VISIBILITY_SORT_CLASS &&
                   (int)FNL_VISIBILITY_SORT_COUNT == VISIBILITY_SORT_MATERIAL + 1,
               "visibility.h has the values of fnl_visibility_sort");

void order_visibility(struct frame_state *f, struct shade_input *input, bool prepass) {
    UNUSED(prepass);
    struct visibility visibility = visibility_add(f->graph, input, f->r->visibility_bits, f->frame->visibility.barycentrics, f->depth);
    order_add_lists(f, f->depth, NULL);
    enum visibility_sort sort = (enum visibility_sort)f->frame->visibility.sort;
    struct visibility_shaded shaded = visibility_shade_add(f->graph, input, &visibility, sort, f->radiance);
    f->visible_ranges = shaded.ranges;
    f->surfaces = shaded.words;
    f->edge_counts = shaded.counts;
}
