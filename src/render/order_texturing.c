/* SPDX-License-Identifier: MIT */
#include "render/orders.h"

#include "passes/texturing/texturing.h"

static void shade(struct frame_state *f, struct shade_input *input, const struct texturing *texturing) {
    f->gbuffer_bytes = (uint64_t)texturing->bytes * f->frame->width * f->frame->height;
    order_add_lists(f, f->depth, NULL);
    struct visible_list surfaces = texturing_shade_add(f->graph, input, texturing, f->radiance);
    f->surfaces = surfaces.words;
    f->edge_counts = surfaces.counts;
}

void order_texturing(struct frame_state *f, struct shade_input *input, bool prepass) {
    bool derived = f->frame->texturing.gradients == FNL_GRADIENTS_DERIVED;
    struct texturing texturing = texturing_add(f->graph, input, derived, prepass, f->depth);
    shade(f, input, &texturing);
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
    f->texturing = texturing;
    shade(f, input, &texturing);
    texturing_forward_add(f->graph, input, f->radiance, f->depth);
}
