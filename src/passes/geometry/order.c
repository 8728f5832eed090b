/* SPDX-License-Identifier: MIT */
#include "passes/geometry/order.h"

#include "passes/geometry/order_shared.h"
#include "passes/geometry/radix_sort.h"
#include "shaders.h"

static uint32_t bits_of(uint32_t most) {
    uint32_t bits = 1;
    while (bits < 32 && most >> bits) bits++;
    return bits;
}

/* Uploads the first group of each bucket, with ORDER_KEPT if the bucket is not opaque. */
static VkDeviceAddress upload_buckets(gpu_device *device, const struct geometry_scene *scene) {
    const struct gpu_slice slice = gpu_frame_allocate(device, scene->bucket_count * sizeof(uint32_t));
    uint32_t *buckets = slice.data;
    for (uint32_t i = 0; i < scene->bucket_count && buckets; i++)
        buckets[i] = scene->buckets[i].first_group | (geometry_bucket_opaque(&scene->buckets[i]) ? 0 : ORDER_KEPT);
    return slice.address;
}

struct order {
    struct graph *graph;
    struct gpu_order_push push;
    graph_buffer sums, visible, draws, vertices;
};

/* Adds a step; `in`, `out` and `ordered` may have id 0: not used. */
static void add_step(const struct order *o, const char *name, uint32_t step, uint32_t count, graph_buffer in, graph_buffer out, graph_buffer ordered) {
    struct gpu_order_push push = o->push;
    struct graph_pass *pass = graph_dispatch(o->graph, &(struct graph_dispatch){.name = name,
                                                                                 .pipeline = {&shader_order_comp, 2, {[1] = step}},
                                                                                 .groups = {DIVIDE_UP(count, 64u)},
                                                                                 GRAPH_PUSH(push),
                                                                                 GRAPH_ROWS(graph_reads(NULL, o->vertices), graph_reads(&push.sums, o->sums),
                                                                                            graph_row_if(in.id > 0, graph_reads(&push.pairs_in, in)),
                                                                                            graph_row_if(out.id > 0, graph_writes(&push.pairs_out, out)),
                                                                                            graph_row_if(ordered.id > 0, graph_writes(&push.ordered, ordered)))});
    if (step == ORDER_ITEMS)
        graph_add_row(pass, graph_writes(&push.visible, o->visible));
    else if (step == ORDER_KEYS)
        graph_add_row(pass, graph_reads(&push.visible, o->visible));
    if (step == ORDER_KEYS || step == ORDER_DRAWS) graph_add_row(pass, graph_reads(&push.draws, o->draws));
}

void order_front_to_back(struct graph *graph, gpu_device *device, const struct geometry_scene *scene, VkDeviceAddress view, struct geometry_draws *draws) {
    if (scene->item_count == 0 || scene->bucket_count == 0 || scene->bucket_count > ORDER_MOST_BUCKETS) return;
    const uint32_t items = scene->item_count, groups = scene->group_count;
    graph_buffer none = {0}, by_depth = graph_create_buffer(graph, "order depths", items * 8ull), by_group = graph_create_buffer(graph, "order groups", items * 8ull),
                 keys = graph_create_buffer(graph, "order keys", groups * 8ull), ordered = graph_create_buffer(graph, "ordered draws", groups * sizeof(struct gpu_draw));
    const struct order o = {.graph = graph,
                            .push = {.view = view,
                                     .scene = scene->scene,
                                     .buckets = upload_buckets(device, scene),
                                     .item_count = items,
                                     .group_count = groups,
                                     .bucket_count = scene->bucket_count},
                            .sums = draws->sums,
                            .visible = draws->visible,
                            .draws = draws->draws,
                            .vertices = scene->vertices};
    if (!o.push.buckets) return; /* the frame fails */
    add_step(&o, "order depths", ORDER_DEPTHS, items, none, by_depth, none);
    by_depth = radix_sort_add(graph, &(struct radix_sort_params){.what = "order depth", .pairs = by_depth, .capacity = items, .bits = 32});
    add_step(&o, "order groups", ORDER_GROUPS, items, by_depth, by_group, none);
    by_group = radix_sort_add(graph, &(struct radix_sort_params){.what = "order group", .pairs = by_group, .capacity = items, .bits = bits_of(groups)});
    add_step(&o, "order items", ORDER_ITEMS, items, by_group, none, none);
    add_step(&o, "order keys", ORDER_KEYS, groups, none, keys, none);
    keys = radix_sort_add(graph, &(struct radix_sort_params){.what = "order draw", .pairs = keys, .capacity = groups, .bits = 32});
    add_step(&o, "order draws", ORDER_DRAWS, groups, keys, none, ordered);
    draws->draws = ordered;
}
