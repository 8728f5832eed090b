/* SPDX-License-Identifier: MIT */
#include "passes/lights/mesh_lists.h"

#include "passes/lights/bvh.h"
#include "passes/lights/clustered.h"
#include "shaders.h"

enum { ITEM_LIMIT = 65535 * 64 - 1 }; /* of a dispatch of one thread per cell */

struct mesh_lists_params mesh_lists_params_default(void) {
    return (struct mesh_lists_params){.grid = clustered_params_default(), .tree_lights = 4096};
}

struct bounds_data {
    VkDeviceAddress view, header;
    graph_buffer bounds;
    uint32_t item_count;
};

static void execute_bounds(const struct graph_context *context, const void *data) {
    const struct bounds_data *d = data;
    struct gpu_compute_params params = {.shader = &shader_mesh_bounds_comp};
    struct gpu_cells_push push = {
        .view = d->view, .list = d->header, .cells = graph_address(context, d->bounds), .cell_count = d->item_count};
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_dispatch_linear(context->commands, DIVIDE_UP(d->item_count, 64u));
}

static struct light_list add_by_tree(struct graph *graph, gpu_device *device, const struct light_input *input,
                                     const struct lights_in_view *in_view, const struct geometry_scene *scene,
                                     const struct mesh_lists_params *params, struct gpu_light_list *header,
                                     VkDeviceAddress header_address) {
    VkDeviceAddress curve;
    struct gpu_light_list *curve_header = light_list_header(device, input, &curve);
    if (curve_header) clustered_grid(curve_header, input->width, input->height, &params->grid);
    struct bounds_data data = {.view = input->view, .header = header_address, .item_count = scene->item_count};
    data.bounds = graph_create_buffer(graph, "mesh cell bounds", scene->item_count * sizeof(struct gpu_cell_bounds));
    struct graph_pass *pass = graph_add_pass(graph, "mesh bounds", input->queue, execute_bounds, &data, sizeof data);
    graph_use_buffer(pass, scene->vertices, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, data.bounds, GRAPH_WRITE_COMPUTE);
    struct bvh tree = bvh_tree_add(graph, input, in_view, curve);
    struct bvh_query query = {.what = "mesh",
                              .bounds = data.bounds,
                              .cell_count = scene->item_count,
                              .occupied = true,
                              .pool_capacity = params->grid.pool_capacity,
                              .header = header,
                              .header_address = header_address};
    return bvh_query_add(graph, device, input, in_view, &tree, &query);
}

struct light_list mesh_lists_add(struct graph *graph, gpu_device *device, const struct light_input *input,
                                 const struct lights_in_view *in_view, const struct geometry_scene *scene,
                                 const struct mesh_lists_params *params) {
    if (scene->item_count == 0 || scene->item_count > ITEM_LIMIT) return light_list_all_add(graph, device, input);
    struct cells_build build = {.what = "mesh",
                                .bounds_shader = &shader_mesh_bounds_comp,
                                .bounds_samples = 1,
                                .bounds_groups_x = DIVIDE_UP(scene->item_count, 64u),
                                .bounds_input = scene->vertices,
                                .pool_capacity = params->grid.pool_capacity};
    build.header = light_list_header(device, input, &build.header_address);
    if (build.header) {
        build.header->tiles_x = scene->item_count;
        build.header->extra = scene->scene;
    }
    struct light_list list = input->local_count < params->tree_lights
                                 ? cells_add(graph, input, in_view, &build)
                                 : add_by_tree(graph, device, input, in_view, scene, params, build.header, build.header_address);
    list.kind = GPU_LIST_ITEMS;
    return list;
}
