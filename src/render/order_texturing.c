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

/* The first frame draws the geometry once more, to know which pages it wants; later ones have what the frame before wanted. */
void order_virtual_texturing(struct frame_state *f, struct shade_input *input, bool prepass) {
    fnl_renderer *r = f->r;
    struct virtual_frame pages = virtual_begin(f->graph, r->device, &r->atlas, r->device_scene.materials.address);
    if (r->atlas.fresh) texturing_virtual_add(f->graph, input, &pages, "texturing wanted", prepass, f->depth);
    virtual_update_add(f->graph, &pages);
    f->page_commands = pages.commands;
    struct texturing texturing = texturing_virtual_add(f->graph, input, &pages, "texturing", prepass, f->depth);
    texturing.shows_levels = r->show_levels;
    f->gbuffer_bytes = (uint64_t)texturing.bytes * f->frame->width * f->frame->height;
    order_add_lists(f, f->depth, NULL);
    texturing_shade_add(f->graph, input, &texturing, f->radiance);
    texturing_forward_add(f->graph, input, f->radiance, f->depth);
}
