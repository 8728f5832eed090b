/* SPDX-License-Identifier: MIT */
#include "passes/shadow/split.h"

#include "passes/lighting/lighting.h"
#include "passes/shadow/fill.h"
#include "passes/shadow/fill_shared.h"
#include "passes/shadow/pages.h"
#include "constants_shared.h"
#include "shaders.h"

graph_buffer shadow_split_add(struct graph *graph, const struct shadow_split_input *input, const struct shadow_split_rows *rows) {
    graph_buffer traced = graph_create_buffer(graph, "shadow traced", rows->row_count * 4ull);
    graph_add_clear(graph, "shadow split clear", GRAPH_QUEUE_GRAPHICS, (struct graph_clear){.buffers = {rows->counts}});
    struct gpu_shadow_split_push push = {
        .row_count = rows->row_count, .known_rows = rows->known_rows, .sun_rows = rows->sun_rows, .page_rays = input->page_rays};
    graph_dispatch(graph, &(struct graph_dispatch){.name = "shadow split",
                                                   .pipeline = {.shader = &shader_split_comp},
                                                   .groups = {DIVIDE_UP(rows->row_count, 64u)},
                                                   GRAPH_PUSH(push),
                                                   GRAPH_ROWS(graph_changes(&push.wanted, rows->wanted), graph_reads(&push.rows, rows->rows),
                                                              graph_changes(&push.kept, rows->kept), graph_writes(&push.traced, traced),
                                                              graph_changes(&push.counts, rows->counts))});
    return traced;
}

void shadow_drawn_add(struct graph *graph, const struct shadow_pages *pages, const struct shadow_fill *fill) {
    struct gpu_shadow_drawn_push push = {0};
    graph_dispatch(graph, &(struct graph_dispatch){.name = "shadow drawn",
                                                   .pipeline = {.shader = &shader_split_drawn_comp},
                                                   .indirect = fill->totals,
                                                   .indirect_offset = offsetof(struct gpu_fill_totals, groups),
                                                   GRAPH_PUSH(push),
                                                   GRAPH_ROWS(graph_reads(&push.drawn, fill->drawn), graph_reads(&push.pages, pages->pages),
                                                              graph_changes(&push.kept, pages->split))});
}

void shadow_probe_add(struct graph *graph, const struct shadow_pages *pages, const struct lighting *lighting, graph_image depth, uint32_t seed) {
    const struct graph_image_params image = graph_image_info(graph, depth);
    struct lighting rays = *lighting;
    rays.bits &= ~(GPU_LIGHTING_MAPS | GPU_LIGHTING_FILTERED);
    rays.shadows.maps = (struct shadow_maps){0};
    struct gpu_shadow_probe_push push = {.lighting = lighting->address, .seed = seed};
    const enum graph_role before = graph_set_role(graph, GRAPH_ROLE_SHADOW_PROBE);
    struct graph_pass *pass =
        graph_dispatch(graph, &(struct graph_dispatch){.name = "shadow probe",
                                                       .pipeline = {&shader_split_probe_comp, 1, {[LIGHTING_ID] = rays.bits}},
                                                       .groups = {DIVIDE_UP(image.width, 32u), DIVIDE_UP(image.height, 32u)},
                                                       GRAPH_PUSH(push),
                                                       GRAPH_ROWS(graph_changes(&push.counts, pages->split_counts), graph_samples(&push.depth, depth))});
    graph_set_role(graph, before);
    lighting_use(pass, &rays, GRAPH_READ_COMPUTE);
}
