/* SPDX-License-Identifier: MIT */
#include "passes/shadow/guide.h"

#include "shaders.h"
#include "shadows/guide_shared.h"

struct shade_guide guide_add(struct graph *graph, const struct guide_input *input) {
    const uint32_t across = DIVIDE_UP(input->width, GUIDE_TILE), down = DIVIDE_UP(input->height, GUIDE_TILE);
    const struct graph_history seen = graph_history(
        graph, &(struct graph_image_params){.name = "kept shadow rays", .format = VK_FORMAT_R32_UINT, .width = across * GUIDE_SIDE, .height = down * GUIDE_SIDE});
    const struct shade_guide guide = {.weights = graph_create_image(graph, &(struct graph_image_params){.name = "shadow guide",
                                                                                                        .format = VK_FORMAT_R8G8B8A8_UNORM,
                                                                                                        .width = across * GUIDE_SIDE / 2,
                                                                                                        .height = down * GUIDE_SIDE / 2}),
                                      .seen = seen.current};
    const bool keeps = input->keeps && seen.previous.id, moves = keeps && input->motion.id;
    struct gpu_guide_push push = {.view = input->view, .keeps = keeps, .moves = moves, .adverse = input->adverse};
    graph_dispatch(graph, &(struct graph_dispatch){.name = "shadow guide",
                                                   .pipeline = {.shader = &shader_guide_comp},
                                                   .groups = {across, down},
                                                   GRAPH_PUSH(push),
                                                   GRAPH_ROWS(graph_row_if(moves, graph_samples(&push.motion, input->motion)),
                                                              graph_row_if(keeps, graph_samples(&push.was, seen.previous)), graph_stores(&push.seen, guide.seen),
                                                              graph_stores(&push.weights, guide.weights))});
    return guide;
}
