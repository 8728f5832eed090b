/* SPDX-License-Identifier: MIT */
#include "passes/aa/taa.h"

#include "passes/aa/taa_shared.h"
#include "shaders.h"

graph_image taa_add(struct graph *graph, graph_image radiance, const struct taa_params *params) {
    struct graph_image_params image = graph_image_info(graph, radiance);
    image.name = "collected radiance";
    image.format = VK_FORMAT_R32G32B32A32_SFLOAT;
    struct graph_history color = graph_history(graph, &image);
    image.name = "collected depth";
    image.format = VK_FORMAT_R16G16B16A16_SFLOAT;
    struct graph_history depth = graph_history(graph, &image);
    bool keeps = params->keeps && color.previous.id && depth.previous.id, metered = params->exposure.id;
    struct gpu_taa_push push = {
        .view = params->view, .factor = params->factor, .metered = metered, .keeps = keeps, .still = params->still};
    graph_dispatch(
        graph, &(struct graph_dispatch){
                   .name = "taa",
                   .pipeline = {&shader_taa_comp, 1, {params->tonemap}},
                   .groups = {DIVIDE_UP(image.width, 8u), DIVIDE_UP(image.height, 8u)},
                   GRAPH_PUSH(push),
                   GRAPH_ROWS(graph_samples(&push.radiance, radiance), graph_samples(&push.depth, params->depth),
                              graph_samples(&push.motion, params->motion),
                              graph_row_if(metered, graph_reads(&push.exposure, params->exposure)),
                              graph_row_if(keeps, graph_samples(&push.history, color.previous)),
                              graph_row_if(keeps, graph_samples(&push.history_depth, depth.previous)),
                              graph_stores(&push.target, color.current), graph_stores(&push.target_depth, depth.current))});
    return color.current;
}
