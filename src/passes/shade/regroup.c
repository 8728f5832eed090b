/* SPDX-License-Identifier: MIT */
#include "passes/shade/regroup.h"

#include "passes/geometry/prefix_sum.h"
#include "passes/shade/regroup_shared.h"
#include "shaders.h"

enum { DRAW_LIMIT = 1 << 18 }; /* lights times groups; most of these draws have nothing to draw, but each is looked at */

/* ---- items by key ---- */

struct regroup {
    const struct geometry_scene *scene;
    struct geometry_draws culled;
    VkDeviceAddress list;
    graph_buffer counts, cursors, items, draws;
    uint32_t key_count, capacity;
    bool by_class;
};

static uint32_t draw_count(const struct regroup *r) { return r->key_count * r->scene->group_count; }

/* Counts the items of each key, fills them in, or makes the draws: REGROUP_… */
static void add_step(struct graph *graph, const char *name, const struct regroup *r, const struct light_list *lists,
                     uint32_t step) {
    bool counts = step == REGROUP_COUNT, fills = step == REGROUP_FILL, draws = step == REGROUP_DRAWS;
    struct gpu_regroup_push push = {.scene = r->scene->scene,
                                    .list = r->list,
                                    .item_count = r->scene->item_count,
                                    .group_count = r->scene->group_count,
                                    .key_count = r->key_count,
                                    .capacity = r->capacity};
    struct graph_pass *pass = graph_dispatch(
        graph, &(struct graph_dispatch){.name = name,
                                        .pipeline = {&shader_regroup_comp, 3, {GPU_LIST_ITEMS, step, r->by_class}},
                                        .groups = {DIVIDE_UP(draws ? draw_count(r) : r->scene->item_count, 64u)},
                                        GRAPH_PUSH(push),
                                        GRAPH_ROWS(graph_reads(&push.culled, r->culled.sums),
                                                   graph_buffer_row(&push.counts, r->counts,
                                                                    counts ? GRAPH_READ_WRITE_COMPUTE : GRAPH_READ_COMPUTE),
                                                   graph_row_if(fills, graph_changes(&push.cursors, r->cursors)),
                                                   graph_row_if(fills, graph_writes(&push.items, r->items)),
                                                   graph_row_if(draws, graph_writes(&push.draws, r->draws)))});
    if (!draws) light_list_use(pass, lists, GRAPH_READ_COMPUTE);
}

static void regroup_add(struct graph *graph, const char *what, const struct light_list *lists, struct regroup *r) {
    uint64_t size = (draw_count(r) + 1) * 4ull;
    r->counts = graph_create_buffer(graph, graph_name(graph, "%s counts", what), size);
    r->cursors = graph_create_buffer(graph, graph_name(graph, "%s cursors", what), size);
    r->items = graph_create_buffer(graph, graph_name(graph, "%s items", what),
                                   MAX((uint64_t)r->scene->item_count + r->capacity, 1u) * 4ull);
    r->draws = graph_create_buffer(graph, graph_name(graph, "%s draw list", what),
                                   MAX(draw_count(r), 1u) * sizeof(struct gpu_draw));
    graph_add_clear(graph, graph_name(graph, "%s clear", what), GRAPH_QUEUE_GRAPHICS,
                    (struct graph_clear){.buffers = {r->counts, r->cursors}});
    add_step(graph, graph_name(graph, "%s count", what), r, lists, REGROUP_COUNT);
    prefix_sum_add(graph, what, GRAPH_QUEUE_GRAPHICS, r->counts, draw_count(r) + 1);
    add_step(graph, graph_name(graph, "%s fill", what), r, lists, REGROUP_FILL);
    add_step(graph, graph_name(graph, "%s draws", what), r, lists, REGROUP_DRAWS);
}

/* ---- drawing ---- */

struct draw_data {
    struct regroup r;
    VkDeviceAddress view, lighting;
    graph_buffer counters;
    graph_image owners, sum;
    uint32_t directional_count, bits; /* bits: of the lighting */
    struct gpu_graphics_params state;
};

/* What the shaders know of the list and of its lights. */
static uint32_t bits_of(const struct draw_data *d) {
    return GPU_LIST_ITEMS | (d->bits & (GPU_LIGHTING_SHADOWED | GPU_LIGHTING_ENVIRONMENT | GPU_LIGHTING_REFLECTIONS | GPU_LIGHTING_LAYERS | GPU_LIGHTING_CONSERVING | GPU_LIGHTING_MASKS | GPU_LIGHTING_PROFILES | GPU_LIGHTING_AREA_LIGHTS));
}

static struct gpu_regroup_draw_push push_of(const struct graph_context *context, const struct draw_data *d) {
    return (struct gpu_regroup_draw_push){.geometry = {.view = d->view,
                                                       .scene = d->r.scene->scene,
                                                       .lighting = d->lighting,
                                                       .counters = d->counters.id ? graph_address(context, d->counters) : 0},
                                          .owners = d->owners.id ? graph_sampled(context, d->owners) : 0,
                                          .sum = d->sum.id ? graph_sampled(context, d->sum) : 0};
}

/* The opaque draws of a key; ALL_KEYS: all culled items. */
static const uint32_t ALL_KEYS = UINT32_MAX;

static void draw_key(const struct graph_context *context, const struct draw_data *d, const struct gpu_graphics_params *state,
                     const struct gpu_regroup_draw_push *push, uint32_t key) {
    const struct geometry_scene *scene = d->r.scene;
    struct gpu_graphics_params params = *state;
    params.vertex = &shader_geometry_vert;
    for (uint32_t i = 0; i < scene->bucket_count; i++) {
        const struct geometry_bucket *bucket = &scene->buckets[i];
        if (!geometry_bucket_opaque(bucket)) continue;
        params.topology = bucket->topology;
        params.cull = bucket->double_sided ? VK_CULL_MODE_NONE
                      : bucket->mirrored   ? VK_CULL_MODE_FRONT_BIT
                                           : VK_CULL_MODE_BACK_BIT;
        gpu_bind(context->commands, gpu_graphics_pipeline(context->device, &params));
        gpu_push(context->commands, push, sizeof *push);
        bool all = key == ALL_KEYS;
        uint64_t first = all ? bucket->first_group : (uint64_t)key * scene->group_count + bucket->first_group;
        gpu_draw_indexed_indirect(context->commands, graph_get_buffer(context, all ? d->r.culled.draws : d->r.draws),
                                  first * sizeof(struct gpu_draw), bucket->group_count);
    }
}

static void draw_all(const struct graph_context *context, const struct draw_data *d,
                     const struct gpu_graphics_params *state) {
    struct gpu_regroup_draw_push push = push_of(context, d);
    push.geometry.visible = graph_address(context, d->r.culled.visible);
    gpu_bind_indices(context->commands, d->r.scene->indices, 0);
    draw_key(context, d, state, &push, ALL_KEYS);
}

static void execute_all(const struct graph_context *context, const void *data) {
    const struct draw_data *d = data;
    draw_all(context, d, &d->state);
}

static struct gpu_graphics_params state_of(const struct gpu_shader *fragment, VkFormat format) {
    return (struct gpu_graphics_params){.fragment = fragment,
                                        .color_count = 1,
                                        .color_formats = {format},
                                        .depth_format = GEOMETRY_DEPTH_FORMAT,
                                        .depth_test = true,
                                        .depth_compare = VK_COMPARE_OP_EQUAL,
                                        .samples = 1};
}

/* Which item each pixel shows: of those at equal depth the last, as in all orders. */
static graph_image owners_add(struct graph *graph, const char *name, const struct draw_data *draw,
                              const struct shade_input *input, graph_image depth) {
    struct draw_data data = *draw;
    graph_image owners = graph_create_image(
        graph, &(struct graph_image_params){
                   .name = "owners", .format = VK_FORMAT_R32G32_UINT, .width = input->width, .height = input->height});
    data.state = state_of(&shader_owners_frag, VK_FORMAT_R32G32_UINT);
    struct graph_pass *pass = graph_add_pass(graph, name, GRAPH_QUEUE_GRAPHICS, execute_all, &data, sizeof data);
    geometry_use(pass, input->scene, input->draws, GEOMETRY_OPAQUE);
    if (data.counters.id) graph_use_buffer(pass, data.counters, GRAPH_READ_WRITE_FRAGMENT);
    graph_color(pass, owners, VK_ATTACHMENT_LOAD_OP_CLEAR, (float[4]){0, 0, 0, 0});
    graph_depth_read_only(pass, depth);
    return owners;
}

static void use_regrouped(struct graph_pass *pass, const struct shade_input *input, const struct draw_data *data) {
    geometry_use(pass, input->scene, input->draws, GEOMETRY_OPAQUE);
    lighting_use(pass, input->lighting, GRAPH_READ_FRAGMENT);
    graph_use_image(pass, data->owners, GRAPH_SAMPLE_FRAGMENT);
    graph_use_buffer(pass, data->r.items, GRAPH_READ_VERTEX);
    graph_use_buffer(pass, data->r.draws, GRAPH_INDIRECT);
    if (data->counters.id) graph_use_buffer(pass, data->counters, GRAPH_READ_WRITE_FRAGMENT);
}

static struct draw_data draw_data_of(const struct shade_input *input, uint32_t key_count, uint32_t capacity, bool by_class) {
    return (struct draw_data){.r = {.scene = input->scene,
                                    .culled = *input->draws,
                                    .list = input->lighting->list.header,
                                    .key_count = key_count,
                                    .capacity = capacity,
                                    .by_class = by_class},
                              .view = input->view,
                              .lighting = input->lighting->address,
                              .bits = input->lighting->bits,
                              .counters = input->counters};
}

static uint32_t opaque_buckets(const struct geometry_scene *scene) { return geometry_draw_count(scene, GEOMETRY_OPAQUE); }

/* ---- batches ---- */

static void execute_batches(const struct graph_context *context, const void *data) {
    const struct draw_data *d = data;
    static const uint32_t loops[REGROUP_CLASSES] = {0, 1, 2, 4, 8, 16, 0};
    struct gpu_regroup_draw_push push = push_of(context, d);
    push.geometry.visible = graph_address(context, d->r.items);
    gpu_bind_indices(context->commands, d->r.scene->indices, 0);
    for (uint32_t c = 0; c < REGROUP_CLASSES; c++) {
        struct gpu_graphics_params state = d->state;
        state.constant_count = FIXED_LIGHTS_ID + 1;
        const uint32_t constants[FIXED_LIGHTS_ID + 1] = {[LIGHTING_ID] = bits_of(d), [COUNT_LIGHTS_ID] = d->counters.id != 0, [HAS_LIGHTS_ID] = c > 0,
                                                         [HAS_METAL_ID] = 1, [FIXED_LIGHTS_ID] = loops[c]};
        memcpy(state.constants, constants, sizeof constants);
        draw_key(context, d, &state, &push, c);
    }
}

void batches_add(struct graph *graph, const struct shade_input *input, graph_image radiance, graph_image depth) {
    struct draw_data data = draw_data_of(input, REGROUP_CLASSES, input->scene->item_count, true);
    regroup_add(graph, "batches", &input->lighting->list, &data.r);
    data.owners = owners_add(graph, "batches owners", &data, input, depth);
    data.state = state_of(&shader_batches_frag, graph_image_info(graph, radiance).format);
    struct graph_pass *pass =
        graph_add_pass(graph, "forward batches", GRAPH_QUEUE_GRAPHICS, execute_batches, &data, sizeof data);
    use_regrouped(pass, input, &data);
    graph_color(pass, radiance, VK_ATTACHMENT_LOAD_OP_CLEAR, input->background);
    graph_depth_read_only(pass, depth);
}

uint32_t batches_draw_count(const struct geometry_scene *scene) { return opaque_buckets(scene) * (1 + REGROUP_CLASSES); }

/* ---- one pass per light ---- */

static void set_step(struct gpu_graphics_params *state, const struct draw_data *d, uint32_t step) {
    const uint32_t constants[MULTIPASS_STEP_ID + 1] = {[LIGHTING_ID] = bits_of(d), [COUNT_LIGHTS_ID] = d->counters.id != 0, [HAS_LIGHTS_ID] = 1,
                                                       [HAS_METAL_ID] = 1, [MULTIPASS_STEP_ID] = step};
    state->constant_count = MULTIPASS_STEP_ID + 1;
    memcpy(state->constants, constants, sizeof constants);
}

static void execute_lights(const struct graph_context *context, const void *data) {
    const struct draw_data *d = data;
    struct gpu_graphics_params state = d->state;
    if (d->directional_count) {
        set_step(&state, d, MULTIPASS_DIRECTIONAL);
        draw_all(context, d, &state);
    }
    set_step(&state, d, MULTIPASS_LIGHT);
    struct gpu_regroup_draw_push push = push_of(context, d);
    push.geometry.visible = graph_address(context, d->r.items);
    gpu_bind_indices(context->commands, d->r.scene->indices, 0);
    for (uint32_t i = 0; i < d->r.key_count; i++) {
        push.light = d->directional_count + i;
        draw_key(context, d, &state, &push, i);
    }
}

bool multipass_fits(gpu_device *device, const struct geometry_scene *scene, uint32_t local_count) {
    return (uint64_t)local_count * scene->group_count <= DRAW_LIMIT &&
           gpu_format_supports(device, VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_FEATURE_2_COLOR_ATTACHMENT_BLEND_BIT);
}

void multipass_add(struct graph *graph, const struct shade_input *input, uint32_t local_count, uint32_t directional_count,
                   uint32_t capacity, graph_image radiance, graph_image depth) {
    struct draw_data data = draw_data_of(input, local_count, capacity, false);
    data.directional_count = directional_count;
    regroup_add(graph, "multipass", &input->lighting->list, &data.r);
    data.owners = owners_add(graph, "multipass owners", &data, input, depth);
    graph_image sum = graph_create_image(graph, &(struct graph_image_params){.name = "light sum",
                                                                             .format = VK_FORMAT_R32G32B32A32_SFLOAT,
                                                                             .width = input->width,
                                                                             .height = input->height});
    data.state = state_of(&shader_multipass_frag, VK_FORMAT_R32G32B32A32_SFLOAT);
    data.state.blends[0] = GPU_BLEND_ADD;
    struct graph_pass *pass =
        graph_add_pass(graph, "forward lights", GRAPH_QUEUE_GRAPHICS, execute_lights, &data, sizeof data);
    use_regrouped(pass, input, &data);
    graph_color(pass, sum, VK_ATTACHMENT_LOAD_OP_CLEAR, (float[4]){0, 0, 0, 0});
    graph_depth_read_only(pass, depth);

    data.sum = sum;
    data.state = state_of(&shader_multipass_frag, graph_image_info(graph, radiance).format);
    set_step(&data.state, &data, MULTIPASS_REST);
    pass = graph_add_pass(graph, "forward rest", GRAPH_QUEUE_GRAPHICS, execute_all, &data, sizeof data);
    use_regrouped(pass, input, &data);
    graph_use_image(pass, sum, GRAPH_SAMPLE_FRAGMENT);
    graph_color(pass, radiance, VK_ATTACHMENT_LOAD_OP_CLEAR, input->background);
    graph_depth_read_only(pass, depth);
}

uint32_t multipass_draw_count(const struct geometry_scene *scene, uint32_t local_count, uint32_t directional_count) {
    return opaque_buckets(scene) * (2 + (directional_count > 0) + local_count);
}
