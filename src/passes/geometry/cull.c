/* SPDX-License-Identifier: MIT */
#include "passes/geometry/cull_shared.h"

#include "passes/geometry/cull.h"
#include "passes/geometry/radix_sort.h"
#include "shaders.h"

struct cull_data {
    const struct geometry_scene *scene;
    VkDeviceAddress view;
    struct geometry_draws draws;
    struct hierarchy occluders; /* levels.id 0: none */
    const struct gpu_shader *shader;
};

static void execute_cull(const struct graph_context *context, const void *data) {
    const struct cull_data *d = data;
    bool fills = d->shader == &shader_cull_fill_comp;
    struct gpu_compute_params params = {.shader = d->shader};
    struct gpu_cull_push push = {.view = d->view,
                                 .scene = d->scene->scene,
                                 .sums = graph_address(context, d->draws.sums),
                                 .visible = fills ? graph_address(context, d->draws.visible) : 0,
                                 .draws = fills ? graph_address(context, d->draws.draws) : 0,
                                 .item_count = d->scene->item_count,
                                 .group_count = d->scene->group_count};
    if (d->occluders.levels.id && !fills) {
        push.hierarchy = graph_address(context, d->occluders.levels);
        push.hidden = graph_address(context, d->draws.hidden);
        push.hierarchy_width = d->occluders.width;
        push.hierarchy_height = d->occluders.height;
        push.occludee_count = d->scene->blend_item_count ? d->scene->blend_first_item : d->scene->item_count;
    }
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_dispatch_linear(context->commands, DIVIDE_UP(d->scene->item_count + 1, 64u));
}

struct sort_data {
    const struct geometry_scene *scene;
    VkDeviceAddress view;
    graph_buffer sums, keys_in, keys_out, draws, visible;
    const struct gpu_shader *shader;
};

static VkDeviceAddress address_or_zero(const struct graph_context *context, graph_buffer buffer) {
    return buffer.id ? graph_address(context, buffer) : 0;
}

static void execute_sort(const struct graph_context *context, const void *data) {
    const struct sort_data *d = data;
    struct gpu_compute_params params = {.shader = d->shader};
    struct gpu_sort_push push = {.view = d->view,
                                 .scene = d->scene->scene,
                                 .keys_in = address_or_zero(context, d->keys_in),
                                 .keys_out = address_or_zero(context, d->keys_out),
                                 .sums = address_or_zero(context, d->sums),
                                 .draws = address_or_zero(context, d->draws),
                                 .visible = address_or_zero(context, d->visible),
                                 .first_item = d->scene->blend_first_item,
                                 .item_count = d->scene->blend_item_count};
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_dispatch_linear(context->commands, DIVIDE_UP(d->scene->blend_item_count, 64u));
}

static struct graph_pass *add_sort_pass(struct graph *graph, const char *name, const struct sort_data *data) {
    struct graph_pass *pass = graph_add_pass(graph, name, GRAPH_QUEUE_GRAPHICS, execute_sort, data, sizeof *data);
    if (data->keys_in.id) graph_use_buffer(pass, data->keys_in, GRAPH_READ_COMPUTE);
    if (data->keys_out.id) graph_use_buffer(pass, data->keys_out, GRAPH_WRITE_COMPUTE);
    if (data->sums.id) graph_use_buffer(pass, data->sums, GRAPH_READ_COMPUTE);
    return pass;
}

static void add_sort(struct graph *graph, const struct geometry_scene *scene, VkDeviceAddress view,
                     struct geometry_draws *draws) {
    uint32_t count = scene->blend_item_count;
    graph_buffer keys = graph_create_buffer(graph, "sort keys", count * 8ull);
    struct graph_pass *keys_pass = add_sort_pass(
        graph, "sort keys",
        &(struct sort_data){
            .scene = scene, .view = view, .sums = draws->sums, .keys_out = keys, .shader = &shader_sort_keys_comp});
    graph_use_buffer(keys_pass, scene->vertices, GRAPH_READ_COMPUTE);
    keys = radix_sort_add(graph,
                          &(struct radix_sort_params){
                              .what = "blend", .queue = GRAPH_QUEUE_GRAPHICS, .pairs = keys, .capacity = count, .bits = 32});
    draws->blend_draws = graph_create_buffer(graph, "blend draws", count * sizeof(struct gpu_draw));
    draws->blend_visible = graph_create_buffer(graph, "blend visible", count * 4ull);
    struct sort_data data = {.scene = scene,
                             .keys_in = keys,
                             .draws = draws->blend_draws,
                             .visible = draws->blend_visible,
                             .shader = &shader_sort_draws_comp};
    struct graph_pass *pass = add_sort_pass(graph, "sort draws", &data);
    graph_use_buffer(pass, draws->blend_draws, GRAPH_WRITE_COMPUTE);
    graph_use_buffer(pass, draws->blend_visible, GRAPH_WRITE_COMPUTE);
}

struct geometry_draws cull_items_add(struct graph *graph, const char *what, const struct geometry_scene *scene,
                                     VkDeviceAddress view, const struct hierarchy *occluders) {
    struct geometry_draws draws = {
        .sums = graph_create_buffer(graph, graph_name(graph, "%s visible sums", what), (scene->item_count + 1) * 4ull),
        .visible = graph_create_buffer(graph, graph_name(graph, "%s visible items", what), MAX(scene->item_count, 1u) * 4ull),
        .draws = graph_create_buffer(graph, graph_name(graph, "%s draw list", what), MAX(scene->group_count, 1u) * sizeof(struct gpu_draw))};
    if (occluders) draws.hidden = graph_create_buffer(graph, graph_name(graph, "%s hidden", what), (scene->item_count + 1) * 4ull);
    struct cull_data data = {.scene = scene, .view = view, .draws = draws, .shader = &shader_cull_mark_comp};
    if (occluders) {
        data.occluders = *occluders;
        graph_add_clear(graph, graph_name(graph, "%s clear", what), GRAPH_QUEUE_GRAPHICS, (struct graph_clear){.buffers = {draws.hidden}});
    }
    struct graph_pass *pass = graph_add_pass(graph, graph_name(graph, "%s mark", what), GRAPH_QUEUE_GRAPHICS, execute_cull, &data, sizeof data);
    graph_use_buffer(pass, scene->vertices, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, draws.sums, GRAPH_WRITE_COMPUTE);
    if (occluders) {
        graph_use_buffer(pass, occluders->levels, GRAPH_READ_COMPUTE);
        graph_use_buffer(pass, draws.hidden, GRAPH_READ_WRITE_COMPUTE);
    }
    prefix_sum_add(graph, what, GRAPH_QUEUE_GRAPHICS, draws.sums, scene->item_count + 1);
    data.shader = &shader_cull_fill_comp;
    pass = graph_add_pass(graph, graph_name(graph, "%s fill", what), GRAPH_QUEUE_GRAPHICS, execute_cull, &data, sizeof data);
    graph_use_buffer(pass, draws.sums, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, draws.visible, GRAPH_WRITE_COMPUTE);
    graph_use_buffer(pass, draws.draws, GRAPH_WRITE_COMPUTE);
    return draws;
}

struct geometry_draws cull_add_hidden(struct graph *graph, const struct geometry_scene *scene, VkDeviceAddress view,
                                      const struct hierarchy *occluders) {
    struct geometry_draws draws = cull_items_add(graph, "cull", scene, view, occluders);
    if (scene->blend_item_count) add_sort(graph, scene, view, &draws);
    return draws;
}

struct geometry_draws cull_add(struct graph *graph, const struct geometry_scene *scene, VkDeviceAddress view) {
    return cull_add_hidden(graph, scene, view, NULL);
}
