/* SPDX-License-Identifier: MIT */
#include "passes/shadow/oblong.h"

#include "passes/shadow/oblong_shared.h"
#include "shaders.h"

/* Least number of pixels that must need a page before it is used; a page has room for 14 400. Pages that fewer pixels
   sample cost more than they show. */
enum { LEAST_PIXELS = 360 };

void shadow_oblong_add(struct graph *graph, const struct lighting *lighting, graph_buffer suns, graph_image depth, graph_buffer planes, graph_buffer keys) {
    const struct graph_image_params image = graph_image_info(graph, depth);
    const uint32_t count = lighting->lights.directional_count;
    graph_buffer found = graph_create_buffer(graph, "shadow blocks", count * (uint64_t)OBLONG_FOUND * 8);
    graph_add_clear(graph, "shadow blocks clear", GRAPH_QUEUE_GRAPHICS, (struct graph_clear){.buffers = {found}});
    struct gpu_shadow_planes_push push = {.lighting = lighting->address};
    graph_dispatch(graph, &(struct graph_dispatch){.name = "shadow planes",
                                                   .pipeline = {&shader_planes_comp, 2, {lighting->bits, MAX(image.samples, 1u)}},
                                                   .groups = {DIVIDE_UP(image.width, 8u), DIVIDE_UP(image.height, 8u)},
                                                   GRAPH_PUSH(push),
                                                   GRAPH_ROWS(graph_samples(&push.depth, depth), graph_reads(&push.suns, suns), graph_writes(&push.planes, planes),
                                                              graph_changes(&push.found, found), graph_reads(NULL, lighting->lights.buffer))});
    struct gpu_shadow_oblong_push rows = {.least = LEAST_PIXELS};
    graph_dispatch(graph, &(struct graph_dispatch){.name = "shadow blocks",
                                                   .pipeline = {.shader = &shader_oblong_comp},
                                                   .groups = {count},
                                                   GRAPH_PUSH(rows),
                                                   GRAPH_ROWS(graph_reads(&rows.found, found), graph_writes(&rows.keys, keys))});
}
