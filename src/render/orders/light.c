/* SPDX-License-Identifier: MIT */
#include "render/orders/order.h"

#include "render/debug_views.h"
#include "render/shading.h"

#include "passes/shade/inferred.h"
#include "passes/shade/light_indexed.h"
#include "passes/shade/pre_lighting.h"
#include "passes/shade/zioma.h"
#include "render/decals.h"

/* ---- light apart from materials ---- */

_Static_assert((int)FNL_LIGHT_BUFFER_RGBA == LIGHT_BUFFER_RGBA && (int)FNL_LIGHT_BUFFER_FOUR == LIGHT_BUFFER_FOUR &&
                   (int)FNL_LIGHT_BUFFER_NARROW == LIGHT_BUFFER_NARROW && FNL_LIGHT_BUFFER_COUNT == FNL_LIGHT_BUFFER_NARROW + 1,
               "the shaders' values are the options'");

static uint32_t light_buffer(const struct frame_state *f, uint32_t automatic) {
    fnl_light_buffer buffer = f->frame->light_buffer.kind;
    return buffer == FNL_LIGHT_BUFFER_AUTO ? automatic : (uint32_t)buffer;
}

static uint64_t geometric_bytes(const struct light_surfaces *surfaces) { return surfaces->geometric.id ? 4 : 0; }

/* Bytes of the targets of sums, and with them of the surfaces that they were made for. */
static void note_light_bytes(struct frame_state *f, const struct light_sums *sums, uint64_t surface_bytes) {
    uint32_t texel = graph_image_info(f->graph, sums->targets[0]).format == VK_FORMAT_R32G32B32A32_SFLOAT ? 16 : 8;
    uint64_t texels = (uint64_t)sums->width * sums->height;
    counters_note(f, "light-buffer.bytes",
                  surface_bytes + texels * (sums->layers * sums->target_count * texel + (sums->samples.id ? 4 : 0)));
}

/* Of several samples a pixel lists see all depths, but no normals. At full resolution each surface of a pixel is lit. */
static void split_surfaces(struct frame_state *f, const struct shade_input *input, struct light_surfaces *surfaces) {
    if (surfaces->samples == 1) return;
    struct edges edges = light_surfaces_split(f->graph, input, surfaces);
    f->stored.surfaces = edges.surfaces;
    COUNTERS_COPY(f, edges.counts, 0, shading, edges);
}

static void add_light_sums(struct frame_state *f, struct shade_input *input, bool prepass, uint32_t buffer, uint32_t scale) {
    if (buffer == LIGHT_BUFFER_NARROW && f->frame->msaa > 1) buffer = LIGHT_BUFFER_TWO; /* edges.h does not support narrow normals */
    struct light_surfaces surfaces = light_surfaces_add(f->graph, input, prepass, buffer, f->depth);
    struct gbuffer normals = light_surfaces_normals(&surfaces);
    if (scale == 1) split_surfaces(f, input, &surfaces);
    order_add_lists(f, f->depth, surfaces.samples > 1 || buffer == LIGHT_BUFFER_NARROW ? NULL : &normals);
    struct light_sums sums = light_sums_create(f->graph, input, buffer, scale,
                                               graph_image_info(f->graph, f->radiance).format, surfaces.layers.count);
    light_sums_add(f->graph, input, &surfaces, &sums);
    light_material_add(f->graph, input, &surfaces, &sums, f->radiance);
    uint32_t texel_bytes = buffer == LIGHT_BUFFER_TWO ? 12 : buffer == LIGHT_BUFFER_NARROW ? 4 : 8;
    note_light_bytes(f, &sums, (texel_bytes + geometric_bytes(&surfaces)) * surfaces.samples * input->width * input->height);
}

static void add_light_prepass(struct frame_state *f, struct shade_input *input, bool prepass) {
    add_light_sums(f, input, prepass, light_buffer(f, LIGHT_BUFFER_TWO), 1);
}

/* Lists of blended surfaces alone, where opaque ones find their lights without. */
static void add_blend_lists(struct frame_state *f) {
    if (surfaces_have_blend(f)) {
        order_add_lists(f, f->depth, NULL);
        f->lights = f->blend_lights;
    } else {
        f->lights = f->blend_lights = order_light_by_all(f);
        graph_set_role(f->graph, GRAPH_ROLE_SHADING);
    }
}

static void add_pre_lighting(struct frame_state *f, struct shade_input *input, bool prepass) {
    struct light_surfaces surfaces = light_surfaces_add(f->graph, input, prepass, LIGHT_BUFFER_TWO, f->depth);
    split_surfaces(f, input, &surfaces);
    add_blend_lists(f);
    const struct lighting base = order_light_by_suns(f);
    input->lighting = &base;
    struct light_sums sums = light_sums_create(f->graph, input, LIGHT_BUFFER_TWO, 1, volumes_format(f->r->device),
                                               surfaces.layers.count);
    light_sums_add(f->graph, input, &surfaces, &sums);
    struct volumes volumes = order_prepare_volumes(f, VOLUME_QUADS, 1);
    pre_lighting_add(f->graph, input, &volumes, &surfaces, &sums);
    light_material_add(f->graph, input, &surfaces, &sums, f->radiance);
    note_light_bytes(f, &sums, (12 + geometric_bytes(&surfaces)) * surfaces.samples * input->width * input->height);
    if (!surfaces_have_blend(f)) order_count_volumes(f, &volumes);
}

/* ---- lights written into pixels ---- */

_Static_assert((int)FNL_LIGHT_PACKING_SHIFT == INDEXED_SHIFT && (int)FNL_LIGHT_PACKING_MAX == INDEXED_MAX &&
                   (int)FNL_LIGHT_PACKING_STENCIL == INDEXED_STENCIL && FNL_LIGHT_PACKING_COUNT == INDEXED_SETS_PACKING + 1,
               "light_indexed_shared.h has the values of fnl_light_packing");

static void add_light_indexed(struct frame_state *f, struct shade_input *input, bool prepass) {
    UNUSED(prepass);
    add_blend_lists(f);
    struct volumes volumes = order_prepare_volumes(f, VOLUME_DEPTH_BOUNDS, 1);
    struct indexed_params params = {.packing = (uint32_t)f->frame->light_indexed.packing,
                                    .layers = f->frame->light_indexed.layers,
                                    .bounds = f->r->device_scene->light_bounds.data,
                                    .planes = f->view.planes,
                                    .plane_count = f->frame->list.frustum_cull ? COUNT_OF(f->view.planes) : 0};
    if (params.packing == INDEXED_STENCIL && !light_indexed_stencil_supported(f->r->device)) params.packing = INDEXED_MAX;
    struct indexed_samples samples = {0};
    f->lights = light_indexed_add(f->graph, f->r->device, input, &volumes, &f->lighting, f->depth, &params, &samples);
    input->lighting = &f->lights;
    if (params.packing == INDEXED_SETS_PACKING) counters_note(f, "light-indexed.unplaced", samples.without_set);
    if (f->frame->msaa > 1)
        light_indexed_samples_add(f->graph, input, &samples, f->radiance, f->depth);
    else
        forward_add(f->graph, input, GEOMETRY_OPAQUE, true, f->radiance, f->depth);
}

static void add_zioma(struct frame_state *f, struct shade_input *input, bool prepass) {
    UNUSED(prepass);
    add_blend_lists(f);
    struct volumes volumes = order_prepare_volumes(f, VOLUME_SOLIDS, 1);
    uint32_t layers = MIN(f->frame->light_indexed.layers, ZIOMA_LAYERS);
    zioma_add(f->graph, input, &volumes, layers, f->radiance, f->depth);
    counters_note(f, "light-buffer.bytes", (f->frame->msaa > 1 ? 4ull : 36ull) * layers * input->width * input->height);
    f->lights.list.totals = volumes.totals;
    f->lights.list.totals_known = false;
}

/* Everything of light at a lower resolution, lists included: the frame, for as long as they are made, is a smaller one. */
static void add_inferred(struct frame_state *f, struct shade_input *input, bool prepass) {
    UNUSED(prepass);
    const fnl_frame *frame = f->frame;
    struct gpu_view view = f->view;
    fnl_frame low_frame = *frame;
    low_frame.msaa = f->view.samples = 1; /* materials alone have more */
    low_frame.width = f->view.size.x = DIVIDE_UP(frame->width, frame->light_buffer.scale);
    low_frame.height = f->view.size.y = DIVIDE_UP(frame->height, frame->light_buffer.scale);
    f->view.inverse_size = (vec2){1 / (float)low_frame.width, 1 / (float)low_frame.height};
    struct gpu_slice slice = gpu_frame_allocate(f->r->device, sizeof f->view);
    if (slice.data) memcpy(slice.data, &f->view, sizeof f->view);
    f->lighting.view = slice.address;
    f->frame = &low_frame;

    /* What else is drawn over opaque surfaces comes before blended ones. */
    const bool more = surfaces_have_glass(f) || surfaces_over(f) || decals_redraws(f) || frame->light_lod > 0 || f->group.mono || f->group.eyes;
    const bool blend = surfaces_have_blend(f) && frame->transparency == FNL_TRANSPARENCY_SORTED && !more;
    struct shade_input low = *input;
    low.view = slice.address;
    low.width = low_frame.width;
    low.height = low_frame.height;
    struct inferred inferred = inferred_surfaces_add(f->graph, &low, blend);
    struct gbuffer normals = light_surfaces_normals(&inferred.surfaces);
    order_add_lists(f, inferred.surfaces.depth, &normals);
    uint32_t buffer = light_buffer(f, LIGHT_BUFFER_FOUR) == LIGHT_BUFFER_RGBA ? LIGHT_BUFFER_RGBA : LIGHT_BUFFER_FOUR;
    struct light_sums sums = light_sums_create(f->graph, &low, buffer, 1, graph_image_info(f->graph, f->radiance).format, 1);
    light_sums_add(f->graph, &low, &inferred.surfaces, &sums);

    f->view = view;
    f->frame = frame;
    f->lighting.view = f->view_address;
    graph_set_role(f->graph, GRAPH_ROLE_LISTS);
    f->blend_lights = order_add_fallback_lists(f);
    graph_set_role(f->graph, GRAPH_ROLE_SHADING);
    input->lighting = &f->blend_lights;
    inferred_material_add(f->graph, input, GEOMETRY_OPAQUE, &inferred, &sums, f->radiance, f->depth);
    if (blend) shading_add_sky(f);
    if (blend) inferred_material_add(f->graph, input, GEOMETRY_BLEND, &inferred, &sums, f->radiance, f->depth);
    f->done.blended = blend;
    note_light_bytes(f, &sums, (16 + geometric_bytes(&inferred.surfaces)) * low.width * low.height); /* its depth is not the frame's */
    if (frame->debug == FNL_DEBUG_LIGHTS || frame->debug == FNL_DEBUG_CELLS || frame->debug == FNL_DEBUG_LIGHT_VOLUMES || frame->pixel.asked)
        f->lights = f->blend_lights; /* the view would look for pixels where there are texels */
}

static void add_low_res(struct frame_state *f, struct shade_input *input, bool prepass) {
    add_light_sums(f, input, prepass, light_buffer(f, LIGHT_BUFFER_FOUR), f->frame->light_buffer.scale);
}

static const struct counter rows[] = {
    {"light-buffer.bytes", "bytes",
     "memory of what replaces the G-buffer: surfaces and sums of light, or layers of lights; without depth and radiance",
     NOTED},
};
static const struct counter indexed_rows[] = {
    {"light-indexed.unplaced", "lights", "lights in view for which every set is full or has a light that they overlap; their pixels visit all lights", NOTED,
     .needs = "light-indexed.packing=sets"},
};
static const struct counter_table counters_indexed = COUNTER_TABLE(indexed_rows);
static const struct counter_table counters_light = COUNTER_TABLE(rows);
#define COUNTERS .counters = &counters_light

enum { STORES = SHADING_GBUFFER | SHADING_MAY_PREPASS | SHADING_REDRAW | SHADING_SAMPLES };
const struct order order_light_prepass = {
    .traits = STORES | SHADING_FULL_RASTER | SHADING_POSITIONS | SHADING_VIEWS, .add = add_light_prepass, COUNTERS};
const struct order order_pre_lighting = {
    .traits = STORES | SHADING_FULL_RASTER | SHADING_VOLUMES | SHADING_VIEWS, .add = add_pre_lighting, COUNTERS};
const struct order order_low_res = {
    .traits = STORES | SHADING_POSITIONS | SHADING_APPROXIMATE | SHADING_VIEWS, .add = add_low_res, COUNTERS};
const struct order order_inferred = {
    .traits = STORES | SHADING_PREPASS | SHADING_POSITIONS | SHADING_APPROXIMATE | SHADING_VIEWS, .add = add_inferred, COUNTERS};

enum { WRITES_IDS = SHADING_LAYERS | SHADING_FULL_RASTER | SHADING_PREPASS | SHADING_VOLUMES | SHADING_SAMPLES };
const struct order order_light_indexed = {.traits = WRITES_IDS | SHADING_VIEWS, .add = add_light_indexed, .counters = &counters_indexed};
const struct order order_zioma = {.traits = WRITES_IDS | SHADING_VIEWS, .add = add_zioma, COUNTERS};
