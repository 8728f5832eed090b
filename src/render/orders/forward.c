/* SPDX-License-Identifier: MIT */
#include "render/orders/order.h"

#include "render/debug_views.h"
#include "render/shading.h"

#include "passes/geometry/cull.h"
#include "passes/shade/regroup.h"

/* Batches and passes per light draw in an order of their own; what they are not for is shaded as with lists of objects. */
static bool draws_batches(const struct frame_state *f) {
    return f->frame->lists == FNL_LISTS_BATCHES && f->frame->msaa == 1 && list_kind(&f->lights.list) == GPU_LIST_ITEMS;
}

static bool draws_per_light(const struct frame_state *f) {
    return f->frame->lists == FNL_LISTS_MULTIPASS && f->frame->msaa == 1 && list_kind(&f->lights.list) == GPU_LIST_ITEMS &&
           multipass_fits(f->r->device, &f->scene->geometry, f->lighting.lights.local_count);
}

/* The log is told once by each renderer that mesh lists stand in for others, the statistics with every frame. */
static void tell_of_mesh_lists(struct frame_state *f) {
    bool own = f->frame->lists == FNL_LISTS_BATCHES || f->frame->lists == FNL_LISTS_MULTIPASS;
    if (!own || list_kind(&f->lights.list) != GPU_LIST_ITEMS || draws_batches(f) || draws_per_light(f)) return;
    f->lists.drawn = FNL_LISTS_MESH;
    if (!FRAME_TELLS(f, mesh_lists)) return;
    const char *name = fnl_value_name(FNL_ENUM_LISTS, f->frame->lists);
    if (f->frame->msaa > 1)
        log_warning(&f->r->host, "%s lists have no MSAA: with %u samples per pixel objects are drawn with mesh lists", name,
                    f->frame->msaa);
    else
        log_warning(&f->r->host,
                    "%s lists: %u lights times %u groups of objects are too many passes, or this device cannot add 32-bit "
                    "floats: objects are drawn with mesh lists",
                    name, f->lighting.lights.local_count, f->scene->geometry.group_count);
}

/* The depth of what is large on the screen, so that less is shaded behind it. */
static struct geometry_draws add_large(struct frame_state *f, const struct shade_input *input) {
    struct geometry_draws draws = *input->draws, large = cull_large_add(f->graph, "large", input->scene, f->view_address, NULL, f->frame->prepass_pixels);
    large.depth_begun = draws.depth_begun;
    geometry_depth_add(f->graph, "large depth", input->scene, &large, f->view_address, f->depth);
    draws.depth_begun = true;
    return draws;
}

static void add(struct frame_state *f, struct shade_input *input, bool prepass) {
    const struct light_set *lights = &f->lighting.lights;
    order_add_lists(f, prepass ? f->depth : (graph_image){0}, NULL); /* a single pass knows no depth beforehand */
    if (draws_batches(f)) {
        batches_add(f->graph, input, f->radiance, f->depth);
        f->calls.opaque = batches_draw_count(input->scene);
    } else if (draws_per_light(f)) {
        multipass_add(f->graph, input, lights->local_count, lights->directional_count, f->r->lists.pool_capacity, f->radiance,
                      f->depth);
        f->calls.opaque = multipass_draw_count(input->scene, lights->local_count, lights->directional_count);
    } else {
        const struct geometry_draws *all = input->draws, draws = !prepass && f->frame->prepass_pixels > 0 ? add_large(f, input) : *all;
        input->draws = &draws;
        forward_add(f->graph, input, GEOMETRY_OPAQUE, prepass, f->radiance, f->depth);
        input->draws = all;
    }
    tell_of_mesh_lists(f);
}

enum { TRAITS = SHADING_LAYERS | SHADING_FULL_RASTER | SHADING_FORWARD | SHADING_LISTS_FIRST | SHADING_ITEMS | SHADING_SAMPLES | SHADING_SURFACES | SHADING_HIDDEN };
const struct order order_forward = {.traits = TRAITS | SHADING_VIEWS, .add = add};
const struct order order_forward_prepass = {.traits = TRAITS | SHADING_PREPASS | SHADING_VIEWS | SHADING_MULTIVIEW, .add = add};
