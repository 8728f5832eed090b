/* SPDX-License-Identifier: MIT */
#include "render/orders.h"

#include "passes/texturing/texturing.h"

void order_texturing(struct frame_state *f, struct shade_input *input, bool prepass) {
    bool derived = f->frame->gradients == FNL_GRADIENTS_DERIVED;
    struct texturing texturing = texturing_add(f->graph, input, derived, prepass, f->depth);
    f->gbuffer_bytes = (uint64_t)texturing.bytes * f->frame->width * f->frame->height;
    order_add_lists(f, f->depth, NULL);
    texturing_shade_add(f->graph, input, &texturing, f->radiance);
}
