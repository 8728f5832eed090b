/* SPDX-License-Identifier: MIT */
#include "passes/lights/mesh_lists.h"

#include "passes/lights/bvh.h"
#include "passes/lights/clustered.h"
#include "shaders.h"

enum { ITEM_LIMIT = 65535 * 64 - 1 }; /* of a dispatch of one thread per cell */

struct mesh_lists_params mesh_lists_params_default(void) {
    return (struct mesh_lists_params){.grid = clustered_params_default(), .tree_lights = 4096};
}

static struct light_list add_by_tree(struct graph *graph, gpu_device *device, const struct light_input *input,
                                     const struct lights_in_view *in_view, const struct geometry_scene *scene,
                                     const struct mesh_lists_params *params, struct gpu_light_list *header,
                                     VkDeviceAddress header_address) {
    VkDeviceAddress curve;
    struct gpu_light_list *curve_header = light_list_header(device, input, &curve);
    if (curve_header) clustered_grid(curve_header, input->width, input->height, &params->grid);
    graph_buffer bounds = graph_create_buffer(graph, "mesh cell bounds", scene->item_count * sizeof(struct gpu_cell_bounds));
    struct gpu_cells_push push = {.view = input->view, .list = header_address, .cell_count = scene->item_count};
    graph_dispatch(
        graph, &(struct graph_dispatch){.name = "mesh bounds",
                                        .queue = input->queue,
                                        .pipeline = {.shader = &shader_mesh_bounds_comp},
                                        .groups = {DIVIDE_UP(scene->item_count, 64u)},
                                        GRAPH_PUSH(push),
                                        GRAPH_ROWS(graph_reads(NULL, scene->vertices), graph_writes(&push.cells, bounds))});
    struct bvh tree = bvh_tree_add(graph, input, in_view, curve);
    struct bvh_query query = {.what = "mesh",
                              .bounds = bounds,
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
                                .scattered_cells = true,
                                .pool_capacity = params->grid.pool_capacity};
    build.header = light_list_header(device, input, &build.header_address);
    if (build.header) {
        build.header->tiles_x = scene->item_count;
        build.header->extra = scene->scene;
    }
    struct light_list list =
        input->set.local_count < params->tree_lights
            ? cells_add(graph, input, in_view, &build)
            : add_by_tree(graph, device, input, in_view, scene, params, build.header, build.header_address);
    list.kind = GPU_LIST_ITEMS;
    return list;
}
