/* SPDX-License-Identifier: MIT */
#include "render/shading.h"
#include "render/decals.h"
#include "render/mono.h"
#include "render/orders/order.h"
#include "render/stereo.h"
#include "render/step.h"

#include "passes/lights/sprites.h"
#include "passes/shade/gbuffer_layouts.h"
#include "passes/sky/sky.h"
#include "passes/stereo/hidden_area.h"
#include "passes/transmission/transmission.h"

void shading_begin(struct frame_state *f) {
    const struct order *order = shading_order(f->frame->shading);
    f->shared.light_scale = f->shared.light_max = 1;
    if (order->begin) order->begin(f);
}

/* ---- what orders share ---- */

void order_note_gbuffer(struct frame_state *f, uint32_t extra_bytes) {
    uint64_t bytes = gbuffer_bytes(surfaces_layout(f), f->frame->gbuffer.normals, f->frame->gbuffer.chroma) +
                     (f->stored.gbuffer.form & GBUFFER_FORM_GEOMETRIC ? 4 : 0) + (f->stored.gbuffer.mask.id ? 1 : 0) + extra_bytes;
    counters_note(f, "gbuffer.bytes", bytes * f->frame->width * f->frame->height * f->frame->msaa);
}

struct volumes order_prepare_volumes(struct frame_state *f, uint32_t shape, uint32_t batch) {
    struct volumes_input input = {.scopes = &f->lighting,
                                  .view = f->view_address,
                                  .cull = f->frame->list.frustum_cull,
                                  .shape = shape,
                                  .batch = batch,
                                  .hook = renderer_tests(f->r).volume_hook};
    return volumes_prepare(f->graph, f->r->device, &input);
}

void order_count_volumes(struct frame_state *f, const struct volumes *volumes) {
    f->lights.list.totals = f->blend_lights.list.totals = volumes->totals;
    f->lights.list.totals_known = false;
}

fnl_result order_check_primitive_ids(const struct call *call, const fnl_renderer *r, const fnl_frame *frame) {
    if (gpu_info(r->device)->primitive_ids) return FNL_OK;
    return unsupported(call, "this device has no primitive_ids, which %s shading needs",
                       fnl_value_name(FNL_ENUM_SHADING, frame->shading));
}

/* ---- blended surfaces ---- */

static void add_transparency(struct frame_state *f, const struct shade_input *input, graph_image depth) {
    const fnl_renderer *r = f->r;
    if (f->frame->transparency == FNL_TRANSPARENCY_LINKED) {
        struct linked_params params = {r->shading.blend_capacity};
        struct linked_lists linked = linked_add(f->graph, input, &params, f->radiance, depth);
        if (input->glass.id)
            COUNTERS_COPY(f, linked.totals, 0, shading, blend_behind);
        else
            COUNTERS_COPY(f, linked.totals, 0, shading, blend);
        if (!input->glass.id) counters_note(f, "transparency.bytes", linked.byte_count);
    } else if (f->frame->transparency == FNL_TRANSPARENCY_WEIGHTED) {
        bool half = renderer_tests(r).weighted_half || weighted_needs_half(r->device);
        weighted_add(f->graph, input, half, f->radiance, depth);
        uint64_t samples = (uint64_t)f->frame->width * f->frame->height * f->frame->msaa;
        if (!input->glass.id) counters_note(f, "transparency.bytes", samples * weighted_bytes(half));
    } else {
        forward_add(f->graph, input, GEOMETRY_BLEND, false, f->radiance, depth);
    }
}

static uint32_t blend_draw_count(const struct frame_state *f) {
    uint32_t draws = geometry_draw_count(&f->scene->geometry, GEOMETRY_BLEND);
    if (!surfaces_have_blend(f) || f->frame->transparency == FNL_TRANSPARENCY_SORTED) return draws;
    return (f->frame->transparency == FNL_TRANSPARENCY_LINKED ? 2 : 1) * draws + f->frame->msaa;
}

/* ---- the frame ---- */

bool shading_shows_volumes(const fnl_frame *frame) {
    return (frame->debug == FNL_DEBUG_LIGHTS || frame->pixel.asked) && frame_is(frame, SHADING_VOLUMES);
}

bool shading_shows_sky(const struct frame_state *f) {
    const struct scene_environment *e = &f->r->scene->environment;
    const bool has_cube = f->lighting.environment.cube.id;
    switch (shading_background(f)) {
    case FNL_BACKGROUND_GRADIENT:
        return true;
    case FNL_BACKGROUND_BLUR:
        return has_cube;
    default:
        return has_cube && (e->background || f->r->capture.owner);
    }
}

fnl_background shading_background(const struct frame_state *f) {
    const struct scene_environment *e = &f->r->scene->environment;
    if (f->r->capture.owner) return FNL_BACKGROUND_SCENE;
    if (f->frame->background == FNL_BACKGROUND_AUTO) return e->staged ? FNL_BACKGROUND_GRADIENT : FNL_BACKGROUND_SCENE;
    if (f->frame->background == FNL_BACKGROUND_BLUR && !f->lighting.environment.cube.id) return FNL_BACKGROUND_SCENE;
    return f->frame->background;
}

void shading_add_sky(struct frame_state *f) {
    if (f->done.sky || !shading_shows_sky(f)) return;
    f->done.sky = true;
    const fnl_background background = shading_background(f);
    const struct sky_params params = {.gradient = background == FNL_BACKGROUND_GRADIENT,
                                      .blur = background == FNL_BACKGROUND_BLUR ? f->frame->background_blur : 0};
    sky_add(f->graph, &f->lighting.environment, &params, f->view_address, f->radiance, f->depth);
}

VkFormat shading_format(const struct frame_state *f) {
    if (f->frame->outputs & FNL_OUTPUT_RADIANCE || f->r->capture.owner) return VK_FORMAT_R32G32B32A32_SFLOAT;
    return shading_is(f->frame->shading, SHADING_BLENDS) ? volumes_format(f->r->device) : VK_FORMAT_R16G16B16A16_SFLOAT;
}

static struct shade_input input_of(const struct frame_state *f) {
    vec3 background = f->r->scene->background;
    return (struct shade_input){.scene = &f->scene->geometry,
                                .draws = &f->draws,
                                .lighting = &f->lights,
                                .view = f->view_address,
                                .width = f->frame->width,
                                .height = f->frame->height,
                                .light_count = f->lighting.lights.local_count,
                                .counters = f->counters,
                                .environment = f->lighting.environment,
                                .background = {background.x, background.y, background.z},
                                .layout = surfaces_layout(f),
                                .normals = f->frame->gbuffer.normals,
                                .chroma = f->frame->gbuffer.chroma};
}

static graph_image create_target(struct frame_state *f, const char *name, VkFormat format) {
    const uint32_t layers = geometry_view_count(&f->draws);
    return graph_create_image(f->graph, &(struct graph_image_params){.name = name,
                                                                     .format = format,
                                                                     .width = f->frame->width,
                                                                     .height = f->frame->height,
                                                                     .layers = layers,
                                                                     .samples = f->frame->msaa});
}

/* ---- what nobody sees ---- */

/* Into depth, in a layer for each of the views that are drawn at once. */
static void add_hidden(struct frame_state *f, const char *name, enum hidden_area_depth to, bool clears) {
    const uint32_t layers = MAX(graph_image_info(f->graph, f->depth).layers, 1u);
    for (uint32_t i = 0; i < layers; i++) {
        const struct hidden_area *area = f->group.layers ? &f->group.layers[MIN(i, f->group.layer_count - 1)].hidden : &f->hidden;
        hidden_area_add(f->graph, graph_numbered_name(f->graph, name, i), area, to, clears, graph_image_layer(f->graph, f->depth, i));
    }
}

/* Whether something is in the depth before anything is drawn: what is hidden, or belongs to another view. */
static bool begins_depth(const struct frame_state *f) { return f->frame->hidden_areas || f->group.mono || f->group.eyes; }

/* What is drawn next, with these draws, loses against it. */
static struct geometry_draws begin_depth(struct frame_state *f) {
    struct geometry_draws draws = f->draws;
    draws.depth_begun = begins_depth(f);
    if (f->group.mono || f->group.eyes) mono_begin_depth(f);
    if (f->frame->hidden_areas) add_hidden(f, "hidden area", HIDDEN_AREA_NEAR, !f->group.mono);
    return draws;
}

void shading_draw(struct frame_state *f) {
    graph_set_role(f->graph, GRAPH_ROLE_GEOMETRY);
    const struct order *order = shading_order(f->frame->shading);
    f->radiance = create_target(f, "radiance", shading_format(f));
    f->depth = create_target(f, "depth", GEOMETRY_DEPTH_FORMAT);
    struct shade_input input = input_of(f);
    const uint32_t calls = f->draws.layers == GEOMETRY_LAYERS_DRAWS ? geometry_view_count(&f->draws) : 1;
    const uint32_t draws = calls * geometry_draw_count(input.scene, GEOMETRY_OPAQUE);
    bool prepass = frame_is(f->frame, SHADING_PREPASS), first = prepass || order->draw, hides = f->frame->hidden_areas && first;
    struct geometry_draws drawn = first && begins_depth(f) ? begin_depth(f) : f->draws;
    const uint32_t passes = (uint32_t)prepass + (order->draw != NULL);
    input.draws = &drawn;
    stereo_count_work(f, &drawn, passes);
    if (prepass) prepass_add(f->graph, input.scene, &drawn, f->view_address, f->depth);
    if (prepass) drawn.first_query += geometry_query_count(&drawn);
    if (order->draw) order->draw(f, &input, prepass);
    if (hides) add_hidden(f, "hidden area empty", HIDDEN_AREA_FAR, false); /* those who look at depth find nothing there */
    f->calls.first = passes * draws;
}

void shading_take_layer(struct frame_state *f, const struct frame_state *together, uint32_t layer) {
    f->calls.first = layer ? 0 : together->calls.first;
    f->radiance = graph_image_layer(f->graph, together->radiance, layer);
    f->depth = graph_image_layer(f->graph, together->depth, layer);
    if (together->stored.gbuffer.depth.id) f->stored.gbuffer = gbuffer_layer(f->graph, &together->stored.gbuffer, layer, f->view_address);
    if (together->stored.visibility.depth.id) f->stored.visibility = visibility_layer(f->graph, &together->stored.visibility, layer);
}

/* What the path stores or sums up has no room for layers, or does not know the item. */
static void add_surfaces_over(struct frame_state *f, const struct shade_input *input) {
    const uint32_t layout = surfaces_over(f);
    if (!layout) return;
    graph_push_names(f->graph, layout == GEOMETRY_LAYERED ? "layers" : "masks");
    const struct lighting lights = order_add_fallback_lists(f); /* the order's own may be of other pixels, or none at all */
    graph_pop_names(f->graph);
    struct shade_input over = *input;
    over.lighting = &lights;
    forward_add(f->graph, &over, GEOMETRY_NOT_IN(layout), true, f->radiance, f->depth);
    f->forward_layouts |= 1u << layout;
    f->calls.opaque += geometry_draw_count(input->scene, GEOMETRY_NOT_IN(layout));
}

static struct transmission find_glass(struct frame_state *f, const struct shade_input *input) {
    const uint32_t layers = MIN(MAX(f->r->shading.transmission_layers, 1u), f->frame->transmission_layers);
    const struct transmission found = transmission_find(f->graph, f->r->device, input, layers, f->radiance, f->depth);
    f->made->transmission_layers = layers;
    f->made->transmission_limit = f->frame->transmission_layers;
    COUNTERS_COPY(f, found.totals, 0, shading, transmission);
    counters_note(f, "transmission.layers", layers);
    counters_note(f, "transmission.bytes", found.byte_count);
    f->calls.opaque += (2 * layers + 1) * geometry_draw_count(input->scene, GEOMETRY_GLASS);
    return found;
}

/* Blended surfaces between what is opaque and the nearest glass: all others come last. */
static void add_behind_glass(struct frame_state *f, const struct shade_input *blend, graph_image nearest) {
    struct lighting lighting = lighting_add(f->graph, f->r->device, &f->lighting, &blend->lighting->list);
    if (!lighting.memory) return; /* the error sticks to the device */
    graph_put_sampled(f->graph, &lighting.memory->glass, nearest);
    lighting.bits |= GPU_LIGHTING_BEHIND_GLASS;
    struct shade_input behind = *blend;
    behind.lighting = &lighting;
    behind.glass = nearest;
    graph_push_names(f->graph, "behind glass");
    add_transparency(f, &behind, f->depth);
    graph_pop_names(f->graph);
    f->calls.opaque += blend_draw_count(f);
}

/* What shows what is behind it, after that and before blended surfaces in front of it. */
static void add_over(struct frame_state *f, const struct shade_input *input) {
    const bool glass = surfaces_have_glass(f), blends = surfaces_have_blend(f) && !f->done.blended;
    struct shade_input blend = *input;
    struct transmission found;
    blend.lighting = &f->blend_lights;
    if (!f->frame->count_lights) blend.counters = (graph_buffer){0};
    f->made->transmission_layers = 0;
    if (glass) {
        found = find_glass(f, input);
        if (blends) add_behind_glass(f, &blend, found.depths[0]);
        graph_push_names(f->graph, "transmission");
        const struct lighting lights = order_add_fallback_lists(f); /* the order's own may be of other depths, or none at all */
        graph_pop_names(f->graph);
        struct shade_input over = blend;
        over.lighting = &lights;
        transmission_add(f->graph, &over, &found, f->radiance, f->depth);
    }
    if (blends) add_transparency(f, &blend, glass ? found.depths[0] : f->depth);
}

static void note_environment(struct frame_state *f) {
    const struct device_scene *d = f->r->device_scene;
    if (!f->lighting.environment.cube.id || f->view_index > 0) return;
    counters_note(f, "environment.filtered", d->environment_made == DEVICE_ENVIRONMENT_FILTERED);
    counters_note(f, "environment.cached", d->environment_made == DEVICE_ENVIRONMENT_KEPT);
}

/* Everything between the first draws and the picture: lists, opaque surfaces, sprites, blended surfaces. */
static void light_view(struct frame_state *f) {
    const struct order *order = shading_order(f->frame->shading);
    counters_note(f, "images.pending", f->r->device_scene->images_coming);
    note_environment(f);
    graph_set_role(f->graph, GRAPH_ROLE_GEOMETRY);
    const struct shade_input input = input_of(f);
    struct shade_input opaque = input;
    uint32_t draws = geometry_draw_count(input.scene, GEOMETRY_OPAQUE);
    f->calls.opaque = (frame_is(f->frame, SHADING_REDRAW) ? 2 : 1) * (order->draw ? 0 : draws);
    const bool hides = f->frame->hidden_areas, prepass = frame_is(f->frame, SHADING_PREPASS);
    const struct geometry_draws drawn = hides && !prepass && !order->draw ? begin_depth(f) : f->draws;
    opaque.draws = &drawn;
    order->add(f, &opaque, prepass);
    graph_set_role(f->graph, GRAPH_ROLE_SHADING);
    if (hides) hidden_area_blacken(f->graph, &f->hidden, f->radiance, f->depth);
    if (f->group.mono) mono_composite(f);
    add_surfaces_over(f, &input);
    decals_redraw(f, &input);
    if (f->group.eyes) return; /* the eyes draw the sky and transparent surfaces themselves */
    shading_add_sky(f);
    if (f->frame->light_lod > 0) sprites_add(f->graph, f->view_address, &f->lists.whole_lights, f->frame->light_lod, f->radiance, f->depth);
    add_over(f, &input);
}

uint32_t shading_draw_count(const struct frame_state *f) { return f->calls.first + f->calls.opaque + blend_draw_count(f); }

/* ---- numbers that do not depend on the order alone ---- */

/* From the draws of this frame, read back. */
static bool find_forward_items(const struct counted *counted, uint64_t *value) {
    const struct gpu_draw *draws = counted->view->draws.mapped;
    uint32_t layouts = counted->made->forward_layouts;
    for (uint32_t b = 0; b < counted->r->counted_buckets.count && layouts; b++) {
        const struct geometry_bucket *bucket = &counted->r->counted_buckets.data[b];
        bool forward = geometry_bucket_opaque(bucket) && bucket->forward_layouts & layouts;
        for (uint32_t i = 0; i < bucket->group_count && forward; i++)
            *value += draws[bucket->first_group + i].instance_count;
    }
    return layouts;
}

static bool find_overflow(const struct counted *counted, uint64_t *value) {
    const struct shading_counts *c = COUNTS(counted->counts, shading);
    if (!COUNTED_HAS(counted, shading, blend)) return false;
    *value = c->blend.overflow_pixels;
    if (COUNTED_HAS(counted, shading, blend_behind)) *value += c->blend_behind.overflow_pixels;
    return true;
}

/* Surfaces that were left out for want of layers, and for which the next frame has some. */
static bool find_left_out(const struct counted *counted, uint64_t *value) {
    const uint64_t longest = MIN(COUNTS(counted->counts, shading)->transmission.longest, counted->made->transmission_limit);
    *value = longest - MIN(longest, counted->made->transmission_layers);
    return counted->made->transmission_layers > 0;
}

static const struct counter rows[] = {
    {"environment.filtered", "", "1: this frame filters the environment's picture", NOTED},
    {"environment.cached", "", "1: this frame takes the environment's maps from the cache folder", NOTED},
    {"images.pending", "images", "images that are still being decoded (fnl_load_params.async); 0: the frame shows all", NOTED},
    {"gbuffer.bytes", "bytes", "memory of the G-buffer's targets; without depth and radiance", NOTED},
    {"gbuffer.items-forward", "items", "visible items that the G-buffer cannot hold: a forward pass shades them",
     .find = find_forward_items, .needs = "count-lights"},
    {"msaa.pixels", "pixels", "pixels that show a surface in some sample", COUNTED(shading, edges[EDGES_PIXELS])},
    {"msaa.edge-pixels", "pixels", "pixels whose samples show more than one thing, sky being one",
     COUNTED(shading, edges[EDGES_MIXED])},
    {"msaa.surfaces", "surfaces", "surfaces, summed over all pixels; in visibility each triangle is one",
     COUNTED(shading, edges[EDGES_SURFACES])},
    {"msaa.samples", "samples", "samples that show a surface", COUNTED(shading, edges[EDGES_SAMPLES])},
    {"msaa.shaded", "surfaces", "surfaces shaded", COUNTED(shading, edges[EDGES_SHADED]), .needs = "count-lights"},
    {"transparency.bytes", "bytes", "memory for blended surfaces besides the picture", NOTED},
    {"transparency.fragments", "fragments", "blended fragments that nothing opaque occludes", COUNTED(shading, blend.fragments),
     .needs = "transparency=linked"},
    {"transparency.longest", "fragments", "most blended fragments in one pixel", COUNTED(shading, blend.longest),
     .needs = "transparency=linked"},
    {"transparency.overflow-pixels", "pixels", "pixels drawn as sorted because the pool was too small",
     .find = find_overflow, .needs = "transparency=linked", .kind = FNL_COUNTER_OVERFLOW},
    {"transmission.layers", "layers", "of surfaces that show what is behind them, drawn one over the other", NOTED},
    {"transmission.bytes", "bytes", "memory for the depth of these layers and for what is behind", NOTED},
    {"transmission.fragments", "fragments", "of such surfaces that nothing opaque occludes", COUNTED(shading, transmission.fragments)},
    {"transmission.longest", "fragments", "most of them in one pixel", COUNTED(shading, transmission.longest)},
    {"transmission.overflow-layers", "layers", "that were left out and that the next frame has (transmission-layers at most)",
     .find = find_left_out, .kind = FNL_COUNTER_OVERFLOW},
};

const struct counter_table counters_shading = COUNTER_TABLE_COUNTED(rows, shading);
/* ---- the step ---- */

enum { BLEND_POOL_START = 1 << 16 };

static void init(fnl_renderer *r) {
    for (uint32_t i = 0; i < FNL_SHADING_AUTO; i++)
        if (shading_order((fnl_shading)i)->init) shading_order((fnl_shading)i)->init(r);
}

static fnl_result check_gbuffer(const struct call *call, const fnl_frame *frame) {
    const bool plain = frame->gbuffer.layout == FNL_GBUFFER_DEFAULT && frame->gbuffer.normals == FNL_NORMALS_LAYOUT && !frame->gbuffer.chroma;
    const bool is_auto = frame->shading == FNL_SHADING_AUTO; /* may become deferred */
    if (plain || (!is_auto && !shading_is(frame->shading, SHADING_GBUFFER))) return FNL_OK;
    if (!is_auto && !shading_is(frame->shading, SHADING_LAYOUTS))
        return unsupported(call, "%s shading has a G-buffer of its own: gbuffer, normals and chroma are of deferred and deferred-volumes",
                           fnl_value_name(FNL_ENUM_SHADING, frame->shading));
    fnl_gbuffer_info info;
    TRY(fnl_gbuffer_query_info(frame->gbuffer.layout, &info));
    if (!(info.encodings >> frame->gbuffer.normals & 1))
        return unsupported(call, "the normals of G-buffer layout %s cannot hold encoding %s", fnl_value_name(FNL_ENUM_GBUFFER, frame->gbuffer.layout),
                           fnl_value_name(FNL_ENUM_NORMALS, frame->gbuffer.normals));
    if (frame->gbuffer.chroma && frame->gbuffer.layout != FNL_GBUFFER_DEFAULT)
        return unsupported(call, "gbuffer.chroma needs the default G-buffer layout, not %s", fnl_value_name(FNL_ENUM_GBUFFER, frame->gbuffer.layout));
    return FNL_OK;
}

static fnl_result check(const struct call *call, fnl_renderer *r, const fnl_frame *frame) {
    fnl_frame checked = *frame;
    TRY(check_gbuffer(call, frame));
    if (frame->shading == FNL_SHADING_AUTO && frame->choose_close && gpu_info(r->device)->primitive_ids)
        checked.shading = FNL_SHADING_VISIBILITY; /* it may be taken */
    if (checked.shading == FNL_SHADING_AUTO || !shading_order(checked.shading)->check) return FNL_OK;
    return shading_order(checked.shading)->check(call, r, &checked);
}

static void submitted(fnl_renderer *r, const fnl_frame *frame) {
    const struct order *order = shading_order(frame->shading);
    if (order->submitted) order->submitted(r);
}

static void forget(fnl_renderer *r) {
    for (uint32_t i = 0; i < FNL_SHADING_AUTO; i++)
        if (shading_order((fnl_shading)i)->forget) shading_order((fnl_shading)i)->forget(r);
}

/* The lists of blended fragments start with one per pixel. */
static uint32_t blend_capacity(const fnl_renderer *r, uint64_t wanted) {
    const uint64_t limit = gpu_info(r->device)->memory_bytes / 16 / linked_bytes(8);
    return (uint32_t)MIN(MAX(wanted, (uint64_t)BLEND_POOL_START), MIN(MAX(limit, (uint64_t)BLEND_POOL_START), LINKED_CAPACITY_MAX));
}

static fnl_result prepare(fnl_renderer *r, const fnl_frame *frame) {
    if (!r->shading.blend_capacity) r->shading.blend_capacity = blend_capacity(r, (uint64_t)frame->width * frame->height);
    const struct order *order = shading_order(frame->shading);
    return order->prepare ? order->prepare(r, frame) : FNL_OK;
}

static void grow(fnl_renderer *r, const struct frame_counts *counts) {
    const struct shading_counts *c = COUNTS(counts, shading);
    const uint64_t needed = MAX(c->blend.fragments, c->blend_behind.fragments);
    if (c->blend.overflow_pixels > 0 || c->blend_behind.overflow_pixels > 0) r->shading.blend_capacity = MAX(r->shading.blend_capacity, blend_capacity(r, needed + needed / 4));
    /* Each layer is a few passes: frames begin with one. */
    r->shading.transmission_layers = MAX(r->shading.transmission_layers, MIN(c->transmission.longest, (uint32_t)TRANSMISSION_LAYERS_MAX));
    for (uint32_t i = 0; i < FNL_SHADING_AUTO; i++)
        if (shading_order((fnl_shading)i)->grow) shading_order((fnl_shading)i)->grow(r, counts);
}

static void destroy(fnl_renderer *r) {
    for (uint32_t i = 0; i < FNL_SHADING_AUTO; i++)
        if (shading_order((fnl_shading)i)->destroy) shading_order((fnl_shading)i)->destroy(r);
}

const struct frame_step step_shading = {.name = "shading",
                                        .init = init,
                                        .check = check,
                                        .prepare = prepare,
                                        .light_view = light_view,
                                        .submitted = submitted,
                                        .forget = forget,
                                        .grow = grow,
                                        .destroy = destroy,
                                        .counters = &counters_shading};
