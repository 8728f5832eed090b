/* SPDX-License-Identifier: MIT */
#include "passes/geometry/cull_shared.h"

#include "passes/geometry/cull.h"
#include "passes/geometry/radix_sort.h"
#include "shaders.h"

static void add_sort(struct graph *graph, const struct geometry_scene *scene, VkDeviceAddress view,
                     struct geometry_draws *draws) {
    uint32_t count = scene->blend_item_count;
    struct gpu_sort_push push = {
        .view = view, .scene = scene->scene, .first_item = scene->blend_first_item, .item_count = count};
    graph_buffer keys = graph_create_buffer(graph, "sort keys", count * 8ull);
    graph_dispatch(
        graph, &(struct graph_dispatch){.name = "sort keys",
                                        .pipeline = {.shader = &shader_sort_keys_comp},
                                        .groups = {DIVIDE_UP(count, 64u)},
                                        GRAPH_PUSH(push),
                                        GRAPH_ROWS(graph_writes(&push.keys_out, keys), graph_reads(&push.sums, draws->sums),
                                                   graph_reads(NULL, scene->vertices))});
    keys = radix_sort_add(graph, &(struct radix_sort_params){.what = "blend", .pairs = keys, .capacity = count, .bits = 32});
    draws->blend_draws = graph_create_buffer(graph, "blend draws", count * sizeof(struct gpu_draw));
    draws->blend_visible = graph_create_buffer(graph, "blend visible", count * 4ull);
    push.view = 0;
    graph_dispatch(graph, &(struct graph_dispatch){.name = "sort draws",
                                                   .pipeline = {.shader = &shader_sort_draws_comp},
                                                   .groups = {DIVIDE_UP(count, 64u)},
                                                   GRAPH_PUSH(push),
                                                   GRAPH_ROWS(graph_reads(&push.keys_in, keys),
                                                              graph_writes(&push.draws, draws->blend_draws),
                                                              graph_writes(&push.visible, draws->blend_visible))});
}

static struct geometry_draws create_draws(struct graph *graph, const char *what, const struct geometry_scene *scene) {
    return (struct geometry_draws){
        .sums = graph_create_buffer(graph, graph_name(graph, "%s visible sums", what), (scene->item_count + 1) * 4ull),
        .visible =
            graph_create_buffer(graph, graph_name(graph, "%s visible items", what), MAX(scene->item_count, 1u) * 4ull),
        .draws = graph_create_buffer(graph, graph_name(graph, "%s draw list", what),
                                     MAX(scene->group_count, 1u) * sizeof(struct gpu_draw))};
}

/* From marks to draws. */
static void add_fill(struct graph *graph, const char *what, const struct geometry_scene *scene, VkDeviceAddress view,
                     const struct geometry_draws *draws) {
    struct gpu_cull_push push = {
        .view = view, .scene = scene->scene, .item_count = scene->item_count, .group_count = scene->group_count, .repeat = 1};
    prefix_sum_add(graph, what, GRAPH_QUEUE_GRAPHICS, draws->sums, scene->item_count + 1);
    graph_dispatch(graph, &(struct graph_dispatch){.name = graph_name(graph, "%s fill", what),
                                                   .pipeline = {.shader = &shader_cull_fill_comp},
                                                   .groups = {DIVIDE_UP(scene->item_count + 1, 64u)},
                                                   GRAPH_PUSH(push),
                                                   GRAPH_ROWS(graph_reads(&push.sums, draws->sums),
                                                              graph_writes(&push.visible, draws->visible),
                                                              graph_writes(&push.draws, draws->draws))});
}

struct geometry_draws cull_items_add(struct graph *graph, const char *what, const struct geometry_scene *scene,
                                     VkDeviceAddress view, const struct hierarchy *occluders) {
    return cull_large_add(graph, what, scene, view, occluders, 0);
}

struct geometry_draws cull_large_add(struct graph *graph, const char *what, const struct geometry_scene *scene,
                                     VkDeviceAddress view, const struct hierarchy *occluders, float least_pixels) {
    struct geometry_draws draws = create_draws(graph, what, scene);
    struct gpu_cull_push push = {.view = view,
                                 .scene = scene->scene,
                                 .item_count = scene->item_count,
                                 .group_count = scene->group_count,
                                 .least_pixels = least_pixels};
    if (occluders) {
        draws.hidden = graph_create_buffer(graph, graph_name(graph, "%s hidden", what), (scene->item_count + 1) * 4ull);
        push.hierarchy_width = occluders->width;
        push.hierarchy_height = occluders->height;
        push.occludee_count = scene->blend_item_count ? scene->blend_first_item : scene->item_count;
        graph_add_clear(graph, graph_name(graph, "%s clear", what), GRAPH_QUEUE_GRAPHICS,
                        (struct graph_clear){.buffers = {draws.hidden}});
    }
    struct graph_pass *pass = graph_dispatch(
        graph,
        &(struct graph_dispatch){.name = graph_name(graph, "%s mark", what),
                                 .pipeline = {.shader = &shader_cull_mark_comp},
                                 .groups = {DIVIDE_UP(scene->item_count + 1, 64u)},
                                 GRAPH_PUSH(push),
                                 GRAPH_ROWS(graph_reads(NULL, scene->vertices), graph_writes(&push.sums, draws.sums))});
    if (occluders) {
        graph_add_row(pass, graph_reads(&push.hierarchy, occluders->levels));
        graph_add_row(pass, graph_changes(&push.hidden, draws.hidden));
    }
    add_fill(graph, what, scene, view, &draws);
    return draws;
}

void cull_sort_add(struct graph *graph, const struct geometry_scene *scene, VkDeviceAddress view, struct geometry_draws *draws) {
    if (scene->blend_item_count) add_sort(graph, scene, view, draws);
}

struct geometry_draws cull_views_add(struct graph *graph, const struct geometry_scene *scene, VkDeviceAddress views,
                                     uint32_t view_count) {
    struct geometry_draws draws = create_draws(graph, "cull", scene);
    draws.view_mask = UINT32_MAX >> (32 - view_count);
    struct gpu_cull_views_push push = {
        .view = views, .scene = scene->scene, .item_count = scene->item_count, .view_count = view_count};
    graph_dispatch(graph, &(struct graph_dispatch){.name = "cull mark",
                                                   .pipeline = {.shader = &shader_cull_views_mark_comp},
                                                   .groups = {DIVIDE_UP(scene->item_count + 1, 64u)},
                                                   GRAPH_PUSH(push),
                                                   GRAPH_ROWS(graph_reads(NULL, scene->vertices),
                                                              graph_writes(&push.sums, draws.sums))});
    add_fill(graph, "cull", scene, views, &draws);
    return draws;
}

struct geometry_draws cull_union_add(struct graph *graph, const struct geometry_scene *scene, const struct geometry_draws *const views[],
                                     uint32_t view_count, uint32_t together) {
    struct geometry_draws draws = create_draws(graph, "cull", scene);
    draws.view_mask = UINT32_MAX >> (32 - together);
    struct gpu_cull_union_push push = {.item_count = scene->item_count, .view_count = MIN(view_count, (uint32_t)COUNT_OF(push.views))};
    struct graph_pass *pass = graph_dispatch(graph, &(struct graph_dispatch){.name = "cull union",
                                                                             .pipeline = {.shader = &shader_cull_union_comp},
                                                                             .groups = {DIVIDE_UP(scene->item_count + 1, 64u)},
                                                                             GRAPH_PUSH(push),
                                                                             GRAPH_ROWS(graph_writes(&push.sums, draws.sums))});
    for (uint32_t i = 0; i < push.view_count; i++) graph_add_row(pass, graph_reads(&push.views[i], views[i]->sums));
    add_fill(graph, "cull", scene, 0, &draws);
    return draws;
}

void cull_repeat_add(struct graph *graph, const struct geometry_scene *scene, struct geometry_draws *draws) {
    struct gpu_cull_push push = {.scene = scene->scene, .group_count = scene->group_count, .repeat = geometry_view_count(draws)};
    draws->layers = GEOMETRY_LAYERS_INSTANCES;
    draws->draws = graph_create_buffer(graph, "repeated draw list", MAX(scene->group_count, 1u) * sizeof(struct gpu_draw));
    graph_dispatch(graph, &(struct graph_dispatch){.name = "cull repeat",
                                                   .pipeline = {.shader = &shader_cull_fill_comp},
                                                   .groups = {DIVIDE_UP(scene->group_count, 64u)},
                                                   GRAPH_PUSH(push),
                                                   GRAPH_ROWS(graph_reads(&push.sums, draws->sums), graph_writes(&push.draws, draws->draws))});
}

struct geometry_draws cull_add_hidden(struct graph *graph, const struct geometry_scene *scene, VkDeviceAddress view,
                                      const struct hierarchy *occluders) {
    struct geometry_draws draws = cull_items_add(graph, "cull", scene, view, occluders);
    cull_sort_add(graph, scene, view, &draws);
    return draws;
}

struct geometry_draws cull_add(struct graph *graph, const struct geometry_scene *scene, VkDeviceAddress view) {
    return cull_add_hidden(graph, scene, view, NULL);
}
