/* SPDX-License-Identifier: MIT */
#include "passes/dais/dais.h"

#include "passes/geometry/mesh_shared.h"
#include "scene_shared.h"
#include "shaders.h"

#define REFERENCE_FORMAT VK_FORMAT_R32_UINT

static uint64_t address_or_zero(const struct graph_context *context, graph_buffer buffer) {
    return buffer.id ? graph_address(context, buffer) : 0;
}

bool dais_target_supported(const gpu_device *device, uint32_t samples) {
    return samples == 1 || gpu_target_samples(device, REFERENCE_FORMAT) & samples;
}

/* ---- visibility ---- */

struct visibility_data {
    const struct geometry_scene *scene;
    struct geometry_draws draws;
    struct dais dais;
    graph_buffer cache;
    VkDeviceAddress view;
    struct gpu_graphics_params state;
};

static void execute_visibility(const struct graph_context *context, const void *data) {
    const struct visibility_data *d = data;
    const struct dais *dais = &d->dais;
    struct gpu_dais_visibility_push push = {.geometry = {.view = d->view},
                                            .indices = d->scene->indices->address,
                                            .pool = graph_address(context, dais->pool),
                                            .counts = graph_address(context, dais->counts),
                                            .cache = graph_address(context, d->cache),
                                            .stored = graph_address(context, dais->stored),
                                            .heads = address_or_zero(context, dais->heads),
                                            .nodes = address_or_zero(context, dais->nodes),
                                            .samples = address_or_zero(context, dais->samples),
                                            .bucket_mask = dais->params.buckets - 1,
                                            .capacity = dais->params.capacity,
                                            .node_capacity = dais->params.node_capacity,
                                            .sample_capacity = dais->sample_capacity};
    geometry_draw_with(context, d->scene, &d->draws, GEOMETRY_OPAQUE, &d->state, NULL, &push.geometry, sizeof push);
}

static const struct gpu_shader *visibility_shader(const struct dais_params *params) {
    bool quads = params->shared_samples && params->quads;
    if (!params->lists) return quads ? &shader_dais_target_quad_frag : &shader_dais_target_frag;
    if (params->each_sample) return &shader_dais_list_samples_frag;
    return quads ? &shader_dais_list_quad_frag : &shader_dais_list_frag;
}

static void add_visibility(struct graph *graph, const struct shade_input *input, const struct dais *dais,
                           graph_buffer cache) {
    struct visibility_data data = {
        .scene = input->scene, .draws = *input->draws, .dais = *dais, .cache = cache, .view = input->view};
    data.state = (struct gpu_graphics_params){
        .fragment = visibility_shader(&dais->params),
        .constant_count = DAIS_ATTEMPTS_ID + 1,
        .constants = {[DAIS_STORE_SHARED_ID] = dais->params.shared_samples,
                      [DAIS_COLORS_ID] = (input->scene->attributes & GEOMETRY_COLORS) != 0,
                      [SAMPLES_ID] = dais->sample_count,
                      [DAIS_ATTEMPTS_ID] = dais->params.attempts},
        .color_count = (dais->references.id != 0) + (dais->shared.id != 0),
        .color_formats = {dais->references.id ? REFERENCE_FORMAT : 0, dais->shared.id ? REFERENCE_FORMAT : 0},
        .depth_format = GEOMETRY_DEPTH_FORMAT,
        .depth_test = true,
        .depth_compare = VK_COMPARE_OP_EQUAL,
        .samples = dais->sample_count};
    struct graph_pass *pass =
        graph_add_pass(graph, "dais visibility", GRAPH_QUEUE_GRAPHICS, execute_visibility, &data, sizeof data);
    geometry_use(pass, input->scene, input->draws, GEOMETRY_OPAQUE);
    graph_use_buffer(pass, input->scene->vertices, GRAPH_READ_GRAPHICS);
    graph_buffer cleared[] = {dais->counts, cache, dais->heads}; /* others are read where this pass has written */
    graph_buffer written[] = {dais->pool, dais->stored, dais->nodes, dais->samples};
    for (uint32_t i = 0; i < COUNT_OF(cleared); i++)
        if (cleared[i].id) graph_use_buffer(pass, cleared[i], GRAPH_READ_WRITE_FRAGMENT);
    for (uint32_t i = 0; i < COUNT_OF(written); i++)
        if (written[i].id) graph_use_buffer(pass, written[i], GRAPH_WRITE_FRAGMENT);
    static const float none[4];
    if (dais->references.id) graph_color(pass, dais->references, VK_ATTACHMENT_LOAD_OP_CLEAR, none);
    if (dais->shared.id) graph_color(pass, dais->shared, VK_ATTACHMENT_LOAD_OP_CLEAR, none);
    graph_depth_read_only(pass, dais->depth);
}

/* ---- derivatives ---- */

/* A pass over what was stored, with the groups that `arguments` has counted, or, before that, one group. */
static struct graph_pass *add_derive(struct graph *graph, const char *name, const struct gpu_shader *shader, bool counted,
                                     const struct dais *dais, const struct gpu_dais_derive_push *common, graph_buffer table,
                                     enum graph_use pool) {
    struct gpu_dais_derive_push push = *common;
    if (table.id) push.table_size = (uint32_t)(graph_buffer_size(graph, table) / 4);
    return graph_dispatch(
        graph, &(struct graph_dispatch){.name = name,
                                        .pipeline = {.shader = shader},
                                        .groups = {1},
                                        .indirect = counted ? dais->counts : (graph_buffer){0},
                                        .indirect_offset = DAIS_DISPATCH * 4,
                                        GRAPH_PUSH(push),
                                        GRAPH_ROWS(graph_changes(&push.counts, dais->counts),
                                                   graph_row_if(counted, graph_reads(&push.stored, dais->stored)),
                                                   graph_row_if(counted, graph_buffer_row(&push.pool, dais->pool, pool)),
                                                   graph_row_if(table.id, graph_changes(&push.table, table)))});
}

struct dais dais_add(struct graph *graph, const struct shade_input *input, const struct dais_params *params,
                     graph_image depth) {
    struct dais dais = {.params = *params,
                        .depth = depth,
                        .width = input->width,
                        .height = input->height,
                        .sample_count = MAX(graph_image_info(graph, depth).samples, 1u)};
    uint64_t pixels = (uint64_t)input->width * input->height;
    dais.pool = graph_create_buffer(graph, "dais triangles", params->capacity * 4ull);
    dais.stored = graph_create_buffer(graph, "dais stored", (params->capacity / (DAIS_HEADER + 12) + 1) * 4ull);
    dais.counts = graph_create_buffer(graph, "dais counts", DAIS_COUNTS * 4);
    graph_buffer cache = graph_create_buffer(graph, "dais cache", params->buckets * DAIS_BUCKET * 4ull);
    dais.fixed_bytes = params->buckets * DAIS_BUCKET * 4ull;
    uint64_t references = pixels * 4 * (params->shared_samples ? 2 : 1);
    if (params->lists) {
        dais.heads = graph_create_buffer(graph, "dais heads", references);
        dais.nodes = graph_create_buffer(graph, "dais nodes", params->node_capacity * DAIS_NODE * 4ull);
        dais.fixed_bytes += references;
    } else {
        struct graph_image_params target = {.name = "dais references",
                                            .format = REFERENCE_FORMAT,
                                            .width = input->width,
                                            .height = input->height,
                                            .samples = dais.sample_count};
        dais.references = graph_create_image(graph, &target);
        target.name = "dais shared samples";
        if (params->shared_samples) dais.shared = graph_create_image(graph, &target);
        dais.fixed_bytes += references * dais.sample_count;
    }
    if (params->shared_samples) { /* one a sample, and some where surfaces lie in one plane; with more than that nothing is shared */
        dais.sample_capacity = (uint32_t)MIN(pixels * dais.sample_count + pixels / 4 + 64, UINT32_MAX / 2u);
        dais.samples = graph_create_buffer(graph, "dais samples", dais.sample_capacity * 8ull);
    }
    graph_add_clear(graph, "dais clear", GRAPH_QUEUE_GRAPHICS,
                    (struct graph_clear){.buffers = {dais.counts, cache, dais.heads}});
    add_visibility(graph, input, &dais, cache);

    const struct gpu_dais_derive_push common = {.view = input->view,
                                                .scene = input->scene->scene,
                                                .indices = input->scene->indices->address,
                                                .sample_capacity = dais.sample_capacity};
    const graph_buffer none = {0};
    add_derive(graph, "dais arguments", &shader_dais_arguments_comp, false, &dais, &common, none, GRAPH_READ_COMPUTE);
    struct graph_pass *pass = add_derive(graph, "dais derivatives", &shader_dais_derive_comp, true, &dais, &common, none,
                                         GRAPH_READ_WRITE_COMPUTE);
    graph_use_buffer(pass, input->scene->vertices, GRAPH_READ_COMPUTE); /* instances */
    if (!input->counters.id) return dais;
    uint32_t size = 1;
    while (size < params->capacity / (DAIS_HEADER + 12) * 2) size *= 2;
    graph_buffer table = graph_create_buffer(graph, "dais unique table", size * 4ull);
    graph_add_clear(graph, "dais unique clear", GRAPH_QUEUE_GRAPHICS, (struct graph_clear){.buffers = {table}});
    add_derive(graph, "dais unique", &shader_dais_unique_comp, true, &dais, &common, table, GRAPH_READ_COMPUTE);
    return dais;
}

/* ---- shading ---- */

struct shade_data {
    struct dais dais;
    const struct geometry_scene *scene;
    graph_image radiance;
    VkDeviceAddress view, lighting;
    graph_buffer counters, results, slots;
    VkFormat format;
    uint32_t bits;
    float background[3];
};

static void set_constants(const struct shade_data *d, uint32_t *count, uint32_t *constants) {
    const struct dais_params *params = &d->dais.params;
    const uint32_t values[15] = {[LIGHTING_ID] = d->bits,
                                 [COUNT_LIGHTS_ID] = d->counters.id != 0,
                                 [HAS_LIGHTS_ID] = 1,
                                 [HAS_METAL_ID] = 1,
                                 [DAIS_SAMPLES_ID] = d->dais.sample_count,
                                 [DAIS_LISTS_ID] = params->lists,
                                 [FOUND_FEATURES_ID] = d->scene->features,
                                 [HAS_TEXTURES_ID] = 1,
                                 [HAS_NORMAL_MAP_ID] = 1,
                                 [DAIS_SHARED_ID] = params->shared_samples,
                                 [DAIS_FLOATS_ID] = d->format == VK_FORMAT_R32G32B32A32_SFLOAT,
                                 [DAIS_SHOW_ID] = params->probe};
    *count = COUNT_OF(values);
    memcpy(constants, values, sizeof values);
    memcpy(&constants[GRADIENT_TAPS_ID], &d->scene->gradient_taps, sizeof(float));
}

static struct gpu_dais_shade_push push_of(const struct shade_data *d) {
    return (struct gpu_dais_shade_push){.view = d->view,
                                        .scene = d->scene->scene,
                                        .lighting = d->lighting,
                                        .references = GPU_TEXTURE_NONE,
                                        .shared_samples = GPU_TEXTURE_NONE,
                                        .target = GPU_TEXTURE_NONE,
                                        .background = {d->background[0], d->background[1], d->background[2]},
                                        .sample_capacity = d->dais.sample_capacity};
}

/* A pass that looks at the triangle of each sample of each pixel. */
static struct graph_pass *add_pixels(struct graph *graph, const char *name, const struct gpu_compute_params *pipeline,
                                     const struct dais *dais, struct gpu_dais_shade_push *push) {
    return graph_dispatch(
        graph, &(struct graph_dispatch){
                   .name = name,
                   .pipeline = *pipeline,
                   .groups = {DIVIDE_UP(dais->width, 8u), DIVIDE_UP(dais->height, 8u)},
                   .push = push,
                   .push_size = sizeof *push,
                   GRAPH_ROWS(graph_reads(&push->pool, dais->pool),
                              graph_row_if(dais->references.id, graph_samples(&push->references, dais->references)),
                              graph_row_if(dais->shared.id, graph_samples(&push->shared_samples, dais->shared)),
                              graph_row_if(dais->heads.id, graph_reads(&push->heads, dais->heads)),
                              graph_row_if(dais->nodes.id, graph_reads(&push->nodes, dais->nodes)))});
}

static void add_spawned(struct graph *graph, const struct shade_data *d) {
    struct gpu_compute_params pipeline = {.shader = &shader_dais_spawned_comp};
    set_constants(d, &pipeline.constant_count, pipeline.constants);
    struct gpu_dais_shade_push push = {
        .view = d->view, .scene = d->scene->scene, .sample_capacity = d->dais.sample_capacity};
    graph_dispatch(graph,
                   &(struct graph_dispatch){
                       .name = "dais shared samples",
                       .pipeline = pipeline,
                       .indirect = d->dais.counts,
                       .indirect_offset = DAIS_SPAWNED * 4,
                       GRAPH_PUSH(push),
                       GRAPH_ROWS(graph_reads(&push.pool, d->dais.pool), graph_changes(&push.samples, d->dais.samples),
                                  graph_reads(&push.counts, d->dais.counts), graph_reads(NULL, d->scene->vertices))});
}

static void add_shade(struct graph *graph, const struct shade_input *input, const struct shade_data *d) {
    const struct dais *dais = &d->dais;
    const bool counts = d->counters.id, stores = dais->sample_count == 1, probes = dais->params.probe == DAIS_SHOW_DEPTH;
    struct gpu_compute_params pipeline = {.shader = &shader_dais_shade_comp};
    set_constants(d, &pipeline.constant_count, pipeline.constants);
    struct gpu_dais_shade_push push = push_of(d);
    struct graph_pass *pass = add_pixels(graph, "dais shade", &pipeline, dais, &push);
    const struct graph_row rows[] = {
        graph_row_if(dais->samples.id, graph_reads(&push.samples, dais->samples)),
        graph_reads(NULL, d->scene->vertices),
        graph_row_if(probes, graph_samples(&push.depth, dais->depth)),
        graph_row_if(!stores, graph_writes(&push.results, d->results)),
        graph_row_if(!stores, graph_writes(&push.slots, d->slots)),
        graph_row_if(stores, graph_stores(&push.target, d->radiance)),
        graph_buffer_row(&push.counts, dais->counts, counts ? GRAPH_READ_WRITE_COMPUTE : GRAPH_READ_COMPUTE),
        graph_row_if(counts, graph_changes(&push.counters, d->counters))};
    for (uint32_t i = 0; i < COUNT_OF(rows); i++) graph_add_row(pass, rows[i]);
    geometry_use_features(pass, d->scene, GRAPH_READ_COMPUTE);
    lighting_use(pass, input->lighting, GRAPH_READ_COMPUTE);
}

static void execute_spread(const struct graph_context *context, const void *data) {
    const struct shade_data *d = data;
    struct gpu_graphics_params params = {.vertex = &shader_deferred_msaa_spread_vert,
                                         .fragment = &shader_dais_spread_frag,
                                         .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST,
                                         .color_count = 1,
                                         .color_formats = {d->format},
                                         .samples = d->dais.sample_count};
    set_constants(d, &params.constant_count, params.constants);
    struct gpu_dais_shade_push push = {.view = d->view,
                                       .results = graph_address(context, d->results),
                                       .slots = graph_address(context, d->slots)};
    gpu_bind(context->commands, gpu_graphics_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_draw(context->commands, 3, d->dais.sample_count, 0, 0);
}

static void add_spread(struct graph *graph, const struct shade_data *data) {
    struct graph_pass *pass = graph_add_pass(graph, "dais spread", GRAPH_QUEUE_GRAPHICS, execute_spread, data, sizeof *data);
    graph_use_buffer(pass, data->results, GRAPH_READ_FRAGMENT);
    graph_use_buffer(pass, data->slots, GRAPH_READ_FRAGMENT);
    graph_color(pass, data->radiance, VK_ATTACHMENT_LOAD_OP_CLEAR,
                (float[4]){data->background[0], data->background[1], data->background[2], 0});
}

void dais_view_add(struct graph *graph, const struct shade_input *input, const struct dais *dais, uint32_t which,
                   graph_image color, bool swap) {
    const struct shade_data data = {.dais = *dais, .scene = input->scene, .view = input->view};
    struct gpu_compute_params pipeline = {.shader = &shader_dais_view_comp};
    set_constants(&data, &pipeline.constant_count, pipeline.constants);
    pipeline.constants[DAIS_SHOW_ID] = which;
    struct gpu_dais_shade_push push = push_of(&data);
    push.sample_capacity = swap;
    struct graph_pass *pass = add_pixels(graph, "debug dais", &pipeline, dais, &push);
    graph_add_row(pass, graph_stores(&push.target, color));
}

/* ---- frames that had no room ---- */

/* A copy of draws, or of counts of draws, that is empty unless something had no room: see gpu_dais_gate_push. */
static graph_buffer add_gate(struct graph *graph, const char *name, const struct dais *dais, graph_buffer from, uint32_t stride,
                             uint32_t place) {
    struct gpu_dais_gate_push push = {
        .word_count = (uint32_t)(graph_buffer_size(graph, from) / 4), .stride = stride, .place = place};
    graph_buffer to = graph_create_buffer(graph, name, push.word_count * 4ull);
    graph_dispatch(graph, &(struct graph_dispatch){.name = name,
                                                   .pipeline = {.shader = &shader_dais_gate_comp},
                                                   .groups = {DIVIDE_UP(push.word_count, 64u)},
                                                   GRAPH_PUSH(push),
                                                   GRAPH_ROWS(graph_reads(&push.counts, dais->counts),
                                                              graph_reads(&push.from, from), graph_writes(&push.to, to))});
    return to;
}

struct rest_data {
    struct shade_data shade;
    struct geometry_draws draws;
    struct gpu_graphics_params state;
};

static void execute_rest(const struct graph_context *context, const void *data) {
    const struct rest_data *d = data;
    struct gpu_geometry_push push = {.view = d->shade.view,
                                     .lighting = d->shade.lighting,
                                     .counters = address_or_zero(context, d->shade.counters)};
    const struct gpu_shader *mask_fragment = d->state.samples > 1 ? &shader_forward_known_frag : NULL;
    geometry_draw(context, d->shade.scene, &d->draws, GEOMETRY_OPAQUE, &d->state, mask_fragment, push);
}

/* Forward shading of all that is opaque, as after a depth prepass. */
static void add_rest(struct graph *graph, const struct shade_input *input, const struct shade_data *shade) {
    struct rest_data data = {.shade = *shade, .draws = *input->draws};
    if (input->scene->group_count > 0) {
        const struct geometry_draws *draws = input->draws;
        const uint32_t groups = offsetof(struct gpu_mesh_draw, groups) / 4;
        data.draws.draws = add_gate(graph, "dais gate", &shade->dais, draws->draws, 5, 1);
        if (draws->item_draws.id)
            data.draws.totals = add_gate(graph, "dais gate clusters", &shade->dais, draws->totals, 1, 0);
        if (draws->mesh_draws.id)
            data.draws.mesh_draws = add_gate(graph, "dais gate meshes", &shade->dais, draws->mesh_draws,
                                             sizeof(struct gpu_mesh_draw) / 4, groups);
    }
    data.state = (struct gpu_graphics_params){.fragment = &shader_forward_early_frag,
                                              .constant_count = 2,
                                              .constants = {[LIGHTING_ID] = shade->bits, [COUNT_LIGHTS_ID] = shade->counters.id != 0},
                                              .color_count = 1,
                                              .color_formats = {shade->format},
                                              .depth_format = GEOMETRY_DEPTH_FORMAT,
                                              .depth_test = true,
                                              .depth_compare = VK_COMPARE_OP_EQUAL,
                                              .samples = shade->dais.sample_count};
    struct graph_pass *pass = graph_add_pass(graph, "dais rest", GRAPH_QUEUE_GRAPHICS, execute_rest, &data, sizeof data);
    geometry_use(pass, input->scene, &data.draws, GEOMETRY_OPAQUE);
    lighting_use(pass, input->lighting, GRAPH_READ_FRAGMENT);
    if (input->counters.id) graph_use_buffer(pass, input->counters, GRAPH_READ_WRITE_FRAGMENT);
    graph_color(pass, shade->radiance, VK_ATTACHMENT_LOAD_OP_LOAD, (float[4]){0});
    graph_depth_read_only(pass, shade->dais.depth);
}

void dais_shade_add(struct graph *graph, const struct shade_input *input, const struct dais *dais, graph_image radiance) {
    struct shade_data data = {.dais = *dais,
                              .scene = input->scene,
                              .radiance = radiance,
                              .view = input->view,
                              .lighting = input->lighting->address,
                              .counters = input->counters,
                              .format = graph_image_info(graph, radiance).format,
                              .bits = input->lighting->bits,
                              .background = {input->background[0], input->background[1], input->background[2]}};
    if (dais->samples.id) add_spawned(graph, &data);
    if (dais->sample_count > 1) {
        uint64_t size = data.format == VK_FORMAT_R32G32B32A32_SFLOAT ? 12 : 8;
        uint64_t pixels = (uint64_t)dais->width * dais->height;
        data.results = graph_create_buffer(graph, "dais radiance", pixels * dais->sample_count * size);
        data.slots = graph_create_buffer(graph, "dais slots", pixels * 4);
    }
    add_shade(graph, input, &data);
    if (dais->sample_count > 1) add_spread(graph, &data);
    add_rest(graph, input, &data);
}
