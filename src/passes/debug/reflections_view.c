/* SPDX-License-Identifier: MIT */
#include "passes/debug/debug.h"

#include "passes/debug/reflections_view_shared.h"
#include "shaders.h"

void reflections_view_add(struct graph *graph, const struct aov_images *aov, const struct environment_light *light, VkDeviceAddress view,
                          graph_image target, bool swap) {
    const struct graph_image_params image = graph_image_info(graph, target);
    struct gpu_reflections_view_push push = {.view = view, .swap = swap};
    struct graph_pass *pass = graph_dispatch(
        graph, &(struct graph_dispatch){.name = "debug view",
                                        .pipeline = {&shader_reflections_view_comp, 1, {environment_kind(light) & GPU_LIGHTING_REFLECTIONS}},
                                        .groups = {DIVIDE_UP(image.width, 8u), DIVIDE_UP(image.height, 8u)},
                                        GRAPH_PUSH(push),
                                        GRAPH_ROWS(graph_samples(&push.albedo, aov->albedo), graph_samples(&push.normal, aov->normal),
                                                   graph_samples(&push.position, aov->position), graph_stores(&push.target, target))});
    environment_use(pass, light, GRAPH_READ_COMPUTE);
}
