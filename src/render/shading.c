/* SPDX-License-Identifier: MIT */
#include "render/shading.h"
#include "render/decals.h"
#include "render/orders.h"

#include "passes/lights/sprites.h"
#include "passes/shade/gbuffer_layouts.h"
#include "passes/shade/regroup.h"

bool order_has_blend(const struct frame_state *f) {
    for (uint32_t i = 0; i < f->scene->geometry.bucket_count; i++)
        if (f->scene->geometry.buckets[i].blend) return true;
    return false;
}

static struct lists_context lists_context(struct frame_state *f) {
    return (struct lists_context){.graph = f->graph,
                                  .device = f->r->device,
                                  .frame = f->frame,
                                  .view = &f->view,
                                  .device_scene = &f->r->device_scene,
                                  .scene = &f->scene->geometry,
                                  .draws = &f->draws,
                                  .input = &f->scene->lights,
                                  .state = &f->r->lists,
                                  .has_blend = order_has_blend(f),
                                  .estimates = f->graph != f->r->asking_graph,
                                  .pool_capacity = f->r->pool_capacity,
                                  .pool_limit = pools_list_limit(f->r)};
}

void order_add_lists(struct frame_state *f, graph_image depth, const struct gbuffer *gbuffer) {
    struct lists_context context = lists_context(f);
    context.depth = depth;
    context.gbuffer = gbuffer;
    lists_add(&context);
    f->lights = context.lights;
    f->blend_lights = context.blend_lights;
}

struct light_list order_add_fallback_lists(struct frame_state *f) {
    struct lists_context context = lists_context(f);
    return lists_add_fallback(&context);
}

/* ---- blended surfaces ---- */

static void add_transparency(struct frame_state *f, const struct shade_input *input) {
    fnl_renderer *r = f->r;
    if (f->frame->transparency == FNL_TRANSPARENCY_LINKED) {
        struct linked_params params = {r->blend_capacity};
        f->linked = linked_add(f->graph, input, &params, f->radiance, f->depth);
        f->blend_bytes = f->linked.byte_count;
    } else if (f->frame->transparency == FNL_TRANSPARENCY_WEIGHTED) {
        bool half = r->weighted_half || weighted_needs_half(r->device);
        weighted_add(f->graph, input, half, f->radiance, f->depth);
        f->blend_bytes = (uint64_t)f->frame->width * f->frame->height * f->frame->msaa * weighted_bytes(half);
    } else {
        forward_add(f->graph, input, GEOMETRY_BLEND, false, f->radiance, f->depth);
    }
}

static uint32_t blend_draw_count(const struct frame_state *f) {
    uint32_t draws = geometry_draw_count(&f->scene->geometry, GEOMETRY_BLEND);
    if (!order_has_blend(f) || f->frame->transparency == FNL_TRANSPARENCY_SORTED) return draws;
    return (f->frame->transparency == FNL_TRANSPARENCY_LINKED ? 2 : 1) * draws + f->frame->msaa;
}

/* ---- the table ---- */

static const struct order {
    /* Declares lists and opaque surfaces; f->depth is complete with `prepass`. `input` is a copy that the order may change. */
    void (*add)(struct frame_state *f, struct shade_input *input, bool prepass);
    uint32_t traits;
} orders[FNL_SHADING_COUNT] = {
    [FNL_SHADING_FORWARD] = {order_forward, SHADING_FULL_RASTER | SHADING_FORWARD | SHADING_ITEMS | SHADING_SAMPLES},
    [FNL_SHADING_FORWARD_PREPASS] = {order_forward, SHADING_FULL_RASTER | SHADING_FORWARD | SHADING_ITEMS | SHADING_PREPASS | SHADING_SAMPLES},
    [FNL_SHADING_DEFERRED] = {order_deferred, SHADING_FULL_RASTER | SHADING_GBUFFER | SHADING_POSITIONS | SHADING_SAMPLES | SHADING_LAYOUTS},
    [FNL_SHADING_DEFERRED_VOLUMES] = {order_volumes, SHADING_FULL_RASTER | SHADING_GBUFFER | SHADING_BLENDS | SHADING_LAYOUTS | SHADING_VOLUMES |
                                                            SHADING_SAMPLES},
    [FNL_SHADING_LIGHT_PREPASS] = {order_light_prepass, SHADING_FULL_RASTER | SHADING_GBUFFER | SHADING_POSITIONS | SHADING_REDRAW | SHADING_SAMPLES},
    [FNL_SHADING_PRE_LIGHTING] = {order_pre_lighting, SHADING_FULL_RASTER | SHADING_GBUFFER | SHADING_REDRAW | SHADING_VOLUMES | SHADING_SAMPLES},
    [FNL_SHADING_INFERRED] = {order_inferred,
                              SHADING_GBUFFER | SHADING_PREPASS | SHADING_POSITIONS | SHADING_REDRAW | SHADING_APPROXIMATE |
                                  SHADING_SAMPLES},
    [FNL_SHADING_LIGHT_INDEXED] = {order_light_indexed, SHADING_FULL_RASTER | SHADING_PREPASS | SHADING_VOLUMES | SHADING_SAMPLES},
    [FNL_SHADING_ZIOMA] = {order_zioma, SHADING_FULL_RASTER | SHADING_PREPASS | SHADING_VOLUMES | SHADING_SAMPLES},
    [FNL_SHADING_LOW_RES] = {order_low_res, SHADING_GBUFFER | SHADING_POSITIONS | SHADING_REDRAW | SHADING_APPROXIMATE |
                                                SHADING_SAMPLES},
    /* Drivers filter explicit gradients in ways of their own: passes/visibility/scenes_test.c compares it without anisotropy. */
    [FNL_SHADING_VISIBILITY] = {order_visibility, SHADING_FULL_RASTER | SHADING_ITEMS | SHADING_APPROXIMATE | SHADING_SAMPLES},
    [FNL_SHADING_TEXTURING] = {order_texturing, SHADING_FULL_RASTER | SHADING_POSITIONS | SHADING_APPROXIMATE | SHADING_SAMPLES}, /* as above; normals are rounded */
    [FNL_SHADING_VIRTUAL_TEXTURING] = {order_virtual_texturing, SHADING_FULL_RASTER | SHADING_APPROXIMATE | SHADING_SAMPLES},
    [FNL_SHADING_COARSE] = {order_coarse, SHADING_FULL_RASTER | SHADING_GBUFFER | SHADING_POSITIONS | SHADING_APPROXIMATE},
    [FNL_SHADING_DAIS] = {order_dais, SHADING_FULL_RASTER | SHADING_ITEMS | SHADING_PREPASS | SHADING_SAMPLES | SHADING_APPROXIMATE},
    [FNL_SHADING_MOBILE] = {order_mobile, SHADING_FULL_RASTER | SHADING_POSITIONS | SHADING_APPROXIMATE},
};

bool shading_is(fnl_shading shading, uint32_t traits) { return (orders[shading].traits & traits) == traits; }

bool fnl_msaa_supported(fnl_shading shading) {
    return shading == FNL_SHADING_AUTO || ((uint32_t)shading < FNL_SHADING_COUNT && shading_is(shading, SHADING_SAMPLES));
}

bool shading_has_prepass(const fnl_frame *frame) {
    return shading_is(frame->shading, SHADING_PREPASS) ||
           ((shading_is(frame->shading, SHADING_GBUFFER) || frame->shading == FNL_SHADING_TEXTURING ||
             frame->shading == FNL_SHADING_VIRTUAL_TEXTURING || frame->shading == FNL_SHADING_MOBILE) &&
            frame->gbuffer.prepass);
}

bool shading_draws_volumes(const fnl_frame *frame) {
    return shading_is(frame->shading, SHADING_VOLUMES) ||
           (frame->shading == FNL_SHADING_MOBILE && frame->mobile.lights == FNL_MOBILE_LIGHTS_VOLUMES);
}

bool shading_shows_volumes(const fnl_frame *frame) {
    return shading_draws_volumes(frame) && frame->debug == FNL_DEBUG_LIGHTS;
}

VkFormat shading_format(const struct frame_state *f) {
    if (f->frame->outputs & FNL_OUTPUT_RADIANCE) return VK_FORMAT_R32G32B32A32_SFLOAT;
    return shading_is(f->frame->shading, SHADING_BLENDS) ? volumes_format(f->r->device) : VK_FORMAT_R16G16B16A16_SFLOAT;
}

void shading_add(struct frame_state *f) {
    f->radiance = frame_create_image(f, "radiance", shading_format(f), f->frame->msaa);
    f->depth = frame_create_image(f, "depth", GEOMETRY_DEPTH_FORMAT, f->frame->msaa);
    vec3 background = f->r->scene->background;
    const struct shade_input input = {.scene = &f->scene->geometry,
                                      .draws = &f->draws,
                                      .lights = &f->lights,
                                      .view = f->view_address,
                                      .width = f->frame->width,
                                      .height = f->frame->height,
                                      .light_count = f->scene->lights.local_count,
                                      .counters = f->counters,
                                      .background = {background.x, background.y, background.z},
                                      .layout = f->frame->gbuffer.layout,
                                      .normals = f->frame->gbuffer.normals,
                                      .chroma = f->frame->gbuffer.chroma};
    bool prepass = shading_has_prepass(f->frame);
    if (prepass) prepass_add(f->graph, &f->scene->geometry, &f->draws, f->view_address, f->depth);
    struct shade_input opaque = input, blend = input;
    orders[f->frame->shading].add(f, &opaque, prepass);
    decals_redraw(f, &input);
    if (f->frame->light_lod > 0) sprites_add(f->graph, &f->whole_lights, f->frame->light_lod, f->radiance, f->depth);
    if (order_has_blend(f) && !f->blended) {
        blend.lights = &f->blend_lights;
        if (!f->frame->count_lights) blend.counters = (graph_buffer){0};
        add_transparency(f, &blend);
    }
}

uint64_t shading_gbuffer_bytes(const struct frame_state *f) {
    const struct gbuffer *g = &f->gbuffer;
    if (!g->depth.id) return f->gbuffer_bytes;
    uint64_t bytes = gbuffer_bytes(f->frame->gbuffer.layout, f->frame->gbuffer.normals, f->frame->gbuffer.chroma) + (g->mask.id ? 1 : 0) + f->coarse_bytes;
    return bytes * f->frame->width * f->frame->height * f->frame->msaa;
}

uint32_t shading_draw_count(const struct frame_state *f) {
    const struct geometry_scene *scene = &f->scene->geometry;
    uint32_t opaque = geometry_draw_count(scene, GEOMETRY_OPAQUE), prepass = shading_has_prepass(f->frame) ? opaque : 0;
    if (order_draws_batches(f)) opaque = batches_draw_count(scene);
    if (order_draws_per_light(f))
        opaque = multipass_draw_count(scene, f->scene->lights.local_count, f->scene->lights.directional_count);
    if (shading_is(f->frame->shading, SHADING_REDRAW) || f->dais.counts.id) opaque *= 2;
    if (f->frame->shading == FNL_SHADING_VIRTUAL_TEXTURING)
        opaque += geometry_draw_count(scene, GEOMETRY_NOT_IN(VIRTUAL_FORWARD)) + (f->r->atlas.fresh ? opaque : 0);
    if (f->gbuffer.mask.id) opaque += geometry_draw_count(scene, GEOMETRY_NOT_IN(f->frame->gbuffer.layout));
    return prepass + opaque + blend_draw_count(f);
}
