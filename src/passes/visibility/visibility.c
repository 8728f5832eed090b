/* SPDX-License-Identifier: MIT */
#include "passes/visibility/visibility.h"

#include "passes/shade/samples_shared.h"
#include "passes/visibility/visibility_shared.h"
#include "passes/visibility/visible.h"
#include "scene_shared.h"
#include "shaders.h"

static uint32_t bits_of(uint64_t value) {
    uint32_t bits = 0;
    for (; value; value >>= 1) bits++;
    return bits;
}

uint32_t visibility_bits(uint32_t item_count, uint32_t triangle_count, uint32_t *out_triangle_bits) {
    *out_triangle_bits = triangle_count > 1 ? bits_of(triangle_count - 1) : 0;
    uint32_t bits = *out_triangle_bits + bits_of(item_count);
    return bits <= 32 ? 32 : bits <= 48 ? 48 : 64;
}

/* ---- ids ---- */

struct ids_data {
    const struct geometry_scene *scene;
    struct geometry_draws draws;
    VkDeviceAddress view;
    graph_buffer fragments;
    struct gpu_graphics_params state;
};

static void execute_ids(const struct graph_context *context, const void *data) {
    const struct ids_data *d = data;
    const struct gpu_shader *mask = d->state.geometry      ? &shader_weights_mask_frag
                                    : d->state.samples > 1 ? &shader_visibility_samples_mask_frag
                                                           : &shader_visibility_mask_frag;
    geometry_draw(
        context, d->scene, &d->draws, GEOMETRY_OPAQUE, &d->state, mask,
        (struct gpu_geometry_push){.view = d->view, .counters = d->fragments.id ? graph_address(context, d->fragments) : 0});
}

static graph_image add_target(struct graph *graph, const char *name, VkFormat format, const struct shade_input *input,
                              uint32_t layers, struct gpu_graphics_params *state) {
    state->color_formats[state->color_count++] = format;
    return graph_create_image(
        graph,
        &(struct graph_image_params){.name = name,
                                     .format = format,
                                     .width = input->width,
                                     .height = input->height,
                                     .layers = layers,
                                     .samples = state->samples});
}

struct visibility visibility_add(struct graph *graph, const struct shade_input *input, uint32_t bits, bool weights,
                                 graph_image depth) {
    struct visibility v = {.depth = depth};
    uint32_t item_count = input->scene->item_count;
    uint32_t needed = visibility_bits(item_count, input->scene->most_triangles, &v.triangle_bits);
    if (bits > needed) v.triangle_bits = MIN(bits - bits_of(item_count), 31u); /* items reach into the upper bits */
    bits = MAX(bits, needed);
    const struct graph_image_params like = graph_image_info(graph, depth);
    const uint32_t samples = MAX(like.samples, 1u);
    struct ids_data data = {.scene = input->scene, .draws = *input->draws, .view = input->view};
    data.state =
        (struct gpu_graphics_params){.fragment = samples > 1 ? &shader_visibility_samples_frag : &shader_visibility_frag,
                                     .constant_count = COUNT_FRAGMENTS_ID + 1,
                                     .constants = {[TRIANGLE_BITS_ID] = v.triangle_bits, [COUNT_FRAGMENTS_ID] = input->counters.id != 0},
                                     .depth_format = GEOMETRY_DEPTH_FORMAT,
                                     .depth_test = true,
                                     .depth_write = true,
                                     /* Of surfaces at equal depth the last one drawn wins, as in forward shading. */
                                     .depth_compare = VK_COMPARE_OP_GREATER_OR_EQUAL,
                                     .samples = samples};
    if (weights && samples == 1) {
        data.state.vertex = &shader_weights_vert;
        data.state.geometry = &shader_weights_geom;
        data.state.fragment = &shader_weights_frag;
        v.weights = add_target(graph, "visibility weights", VK_FORMAT_R32G32_SFLOAT, input, 1, &data.state);
        v.gradients = add_target(graph, "visibility gradients", VK_FORMAT_R16G16B16A16_SFLOAT, input, 1, &data.state);
    }
    VkFormat word = samples > 1 ? VK_FORMAT_R8G8B8A8_UNORM : VK_FORMAT_R32_UINT;
    v.ids = add_target(graph, "visibility", word, input, like.layers, &data.state);
    if (bits > 32)
        v.ids_high =
            add_target(graph, "visibility high", samples == 1 && bits == 48 ? VK_FORMAT_R16_UINT : word, input, like.layers,
                       &data.state);
    if (input->counters.id) {
        data.fragments = v.fragments = graph_create_buffer(graph, "visibility fragments", 4);
        graph_add_clear(graph, "visibility clear", GRAPH_QUEUE_GRAPHICS, (struct graph_clear){.buffers = {v.fragments}});
    }
    struct graph_pass *pass = graph_add_pass(graph, "visibility", GRAPH_QUEUE_GRAPHICS, execute_ids, &data, sizeof data);
    if (v.fragments.id) graph_use_buffer(pass, v.fragments, GRAPH_READ_WRITE_FRAGMENT);
    geometry_use(pass, input->scene, input->draws, GEOMETRY_OPAQUE);
    static const float none[4];
    if (v.weights.id) {
        graph_color(pass, v.weights, VK_ATTACHMENT_LOAD_OP_DONT_CARE, none);
        graph_color(pass, v.gradients, VK_ATTACHMENT_LOAD_OP_DONT_CARE, none);
    }
    graph_color(pass, v.ids, VK_ATTACHMENT_LOAD_OP_CLEAR, none);
    if (v.ids_high.id) graph_color(pass, v.ids_high, VK_ATTACHMENT_LOAD_OP_CLEAR, none);
    graph_depth(pass, depth, geometry_depth_load(input->draws), 0);
    geometry_set_layers(pass, input->draws);
    return v;
}

struct visibility visibility_layer(struct graph *graph, const struct visibility *visibility, uint32_t layer) {
    struct visibility one = *visibility;
    one.depth = graph_image_layer(graph, visibility->depth, layer);
    one.ids = graph_image_layer(graph, visibility->ids, layer);
    if (visibility->ids_high.id) one.ids_high = graph_image_layer(graph, visibility->ids_high, layer);
    return one;
}

/* ---- shading ---- */

struct shade_data {
    struct visibility visibility;
    struct visible_list list;
    const struct geometry_scene *scene;
    graph_image radiance;
    VkDeviceAddress view, lighting;
    graph_buffer counters, results;
    uint32_t bits, width, height, samples;
    VkFormat format;
    float background[3];
};

/* Decals may give a material what it has not. */
static void set_constants(const struct shade_data *d, uint32_t class_bits, struct gpu_compute_params *params) {
    bool all = d->list.listed != VISIBLE_SORTED, decals = (d->scene->features & GPU_FEATURES_DECALS) != 0;
    const uint32_t values[16] = {[LIGHTING_ID] = all || class_bits & GPU_CLASS_LAYERS ? d->bits : d->bits & ~GPU_LIGHTING_LAYERS,
                                 [COUNT_LIGHTS_ID] = d->counters.id != 0,
                                 [HAS_LIGHTS_ID] = all || decals || class_bits & GPU_CLASS_LIT,
                                 [HAS_METAL_ID] = all || decals || class_bits & GPU_CLASS_METAL,
                                 [VISIBILITY_GRID_ID] = d->visibility.grid,
                                 [FOUND_FEATURES_ID] = d->scene->features,
                                 [HAS_TEXTURES_ID] = all || class_bits & GPU_CLASS_TEXTURES,
                                 [HAS_NORMAL_MAP_ID] = all || class_bits & GPU_CLASS_NORMAL_MAP,
                                 [VISIBLE_LISTED_ID] = d->list.listed,
                                 [VISIBLE_SAMPLES_ID] = d->samples,
                                 [VISIBLE_FLOATS_ID] = d->format == VK_FORMAT_R32G32B32A32_SFLOAT,
                                 [STORED_WEIGHTS_ID] = d->visibility.weights.id != 0};
    params->constant_count = COUNT_OF(values);
    memcpy(params->constants, values, sizeof values);
    memcpy(&params->constants[GRADIENT_TAPS_ID], &d->scene->gradient_taps, sizeof(float));
}

/* A dispatch of the pass: all pixels, all of the list, or the surfaces of a class of materials. */
static struct graph_pass *add_shade(struct graph *graph, struct graph_pass *pass, const struct shade_data *d, uint32_t class_bits) {
    const struct visibility *v = &d->visibility;
    const struct visible_list *list = &d->list;
    const bool listed = list->listed != VISIBLE_GRID, several = d->samples > 1, counts = d->counters.id;
    struct gpu_visibility_push push = {.view = d->view,
                                       .scene = d->scene->scene,
                                       .lighting = d->lighting,
                                       .indices = d->scene->indices->address,
                                       .ids_high = GPU_TEXTURE_NONE,
                                       .triangle_bits = v->triangle_bits,
                                       .background = {d->background[0], d->background[1], d->background[2]}};
    struct gpu_compute_params pipeline = {.shader = &shader_visibility_shade_comp};
    set_constants(d, class_bits, &pipeline);
    return graph_dispatch(
        graph,
        &(struct graph_dispatch){
            .pass = pass,
            .name = "visibility shade",
            .pipeline = pipeline,
            .groups = {DIVIDE_UP(d->width, 8u), DIVIDE_UP(d->height, 8u)},
            .indirect = list->dispatches, /* 0 without a list */
            .indirect_offset = class_bits * 12ull,
            GRAPH_PUSH(push),
            GRAPH_ROWS(graph_samples(&push.ids, v->ids),
                       graph_row_if(v->ids_high.id, graph_samples(&push.ids_high, v->ids_high)),
                       graph_row_if(v->weights.id, graph_samples(&push.weights, v->weights)),
                       graph_row_if(v->weights.id, graph_samples(&push.gradients, v->gradients)),
                       graph_row_if(v->weights.id, graph_samples(&push.depth, v->depth)),
                       graph_row_if(counts, graph_changes(&push.counters, d->counters)),
                       graph_row_if(listed, graph_reads(&push.entries, list->entries)),
                       graph_row_if(listed, graph_row_at(class_bits * 8ull, graph_reads(&push.range, list->ranges))),
                       graph_row_if(!several, graph_stores(&push.radiance, d->radiance)),
                       graph_row_if(several, graph_reads(&push.words, list->words)),
                       graph_row_if(several, graph_reads(&push.sums, list->sums)),
                       graph_row_if(several, graph_writes(&push.results, d->results)),
                       graph_row_if(several && counts, graph_changes(&push.counts, list->counts)))});
}

struct visibility_shaded visibility_shade_add(struct graph *graph, const struct shade_input *input,
                                              const struct visibility *visibility, enum visibility_sort sort,
                                              graph_image radiance) {
    struct graph_image_params target = graph_image_info(graph, radiance);
    struct shade_data data = {.visibility = *visibility,
                              .scene = input->scene,
                              .radiance = radiance,
                              .view = input->view,
                              .lighting = input->lighting->address,
                              .counters = input->counters,
                              .bits = input->lighting->bits,
                              .width = input->width,
                              .height = input->height,
                              .samples = MAX(target.samples, 1u),
                              .format = target.format,
                              .background = {input->background[0], input->background[1], input->background[2]}};
    bool lists = data.samples > 1 || sort != VISIBILITY_SORT_OFF;
    if (lists) data.list = visible_list_add(graph, input, visibility, sort, radiance);
    if (data.samples > 1)
        data.results = graph_create_buffer(
            graph, "visible results", data.list.capacity * (target.format == VK_FORMAT_R32G32B32A32_SFLOAT ? 12ull : 8ull));
    struct graph_pass *pass = NULL;
    for (uint32_t c = 0; c < (lists ? GPU_CLASSES : 1u); c++)
        if (!lists || data.list.classes >> c & 1) pass = add_shade(graph, pass, &data, c);
    graph_use_buffer(pass, input->scene->vertices, GRAPH_READ_COMPUTE);
    geometry_use_features(pass, input->scene, GRAPH_READ_COMPUTE);
    lighting_use(pass, input->lighting, GRAPH_READ_COMPUTE);
    if (data.samples == 1) return (struct visibility_shaded){.ranges = data.list.ranges};
    visible_spread_add(graph, input, &data.list, data.results, radiance);
    return (struct visibility_shaded){data.list.ranges, data.list.words, data.list.counts};
}
