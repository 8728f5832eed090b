/* SPDX-License-Identifier: MIT */
#include "passes/lights/mesh_lists.h"

#include "passes/lights/cells.h"
#include "shaders.h"

enum { ITEM_LIMIT = 65535 * 64 - 1 }; /* of a dispatch of one thread per cell */

struct light_list mesh_lists_add(struct graph *graph, gpu_device *device, const struct light_input *input,
                                 const struct lights_in_view *in_view, const struct geometry_scene *scene,
                                 uint32_t pool_capacity) {
    static const struct cells_names names = CELLS_NAMES("mesh");
    if (scene->item_count == 0 || scene->item_count > ITEM_LIMIT) return light_list_all_add(graph, device, input);
    struct cells_build build = {.names = &names,
                                .bounds_shader = &shader_mesh_bounds_comp,
                                .bounds_samples = 1,
                                .bounds_groups_x = DIVIDE_UP(scene->item_count, 64u),
                                .bounds_input = scene->vertices,
                                .pool_capacity = pool_capacity};
    build.header = light_list_header(device, input, &build.header_address);
    if (build.header) {
        build.header->tiles_x = scene->item_count;
        build.header->extra = scene->scene;
    }
    struct light_list list = cells_add(graph, input, in_view, &build);
    list.kind = GPU_LIST_ITEMS;
    return list;
}
