/* SPDX-License-Identifier: MIT */
#include "render/orders.h"

#include "passes/visibility/visibility.h"

void order_visibility(struct frame_state *f, struct shade_input *input, bool prepass) {
    UNUSED(prepass);
    struct visibility visibility = visibility_add(f->graph, input, f->r->visibility_bits, f->depth);
    order_add_lists(f, f->depth, NULL);
    visibility_shade_add(f->graph, input, &visibility, f->radiance);
}
