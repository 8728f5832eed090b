/* SPDX-License-Identifier: MIT */
#include "passes/shadow/fill.h"

#include "passes/geometry/prefix_sum.h"
#include "passes/shadow/fill_shared.h"
#include "shaders.h"

struct draw_data {
    const struct geometry_scene *scene;
    graph_buffer draws, totals;
    struct gpu_slice corners;
    struct gpu_fill_draw_push push;
    bool casts[2]; /* opaque, cutout: whether the scene has any */
};

static void execute_draw(const struct graph_context *context, const void *data) {
    const struct draw_data *d = data;
    struct gpu_commands *commands = context->commands;
    const struct gpu_buffer *draws = graph_get_buffer(context, d->draws), *totals = graph_get_buffer(context, d->totals);
    struct gpu_graphics_params params = {.vertex = &shader_fill_clear_vert,
                                         .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST,
                                         .depth_format = GEOMETRY_DEPTH_FORMAT,
                                         .depth_test = true,
                                         .depth_write = true,
                                         .depth_compare = VK_COMPARE_OP_ALWAYS,
                                         .samples = 1};
    gpu_bind_indices(commands, d->corners.buffer, d->corners.offset);
    gpu_bind(commands, graph_pipeline(context, &params));
    gpu_push(commands, &d->push, sizeof d->push);
    gpu_draw_indexed_indirect(commands, totals, offsetof(struct gpu_fill_totals, clear), 1);
    gpu_bind_indices(commands, d->scene->indices, 0);
    params.depth_compare = VK_COMPARE_OP_GREATER;
    for (uint32_t cutout = 0; cutout < 2; cutout++) {
        if (!d->casts[cutout]) continue;
        params.vertex = cutout ? &shader_fill_cutout_vert : &shader_fill_vert;
        params.fragment = cutout ? &shader_depth_casters_frag : NULL;
        gpu_bind(commands, graph_pipeline(context, &params));
        gpu_push(commands, &d->push, sizeof d->push);
        gpu_draw_indexed_indirect_count(commands, draws, (uint64_t)cutout * d->scene->unit_count * sizeof(struct gpu_draw),
                                        totals, offsetof(struct gpu_fill_totals, draw_counts) + cutout * 4ull,
                                        d->scene->unit_count);
    }
}

static void add_draw(struct graph *graph, gpu_device *device, const struct shadow_fill_input *in,
                     const struct shadow_fill *fill, graph_buffer draws) {
    static const uint32_t corners[6] = {0, 1, 2, 3, 4, 5};
    struct draw_data data = {.scene = in->scene,
                             .draws = draws,
                             .totals = fill->totals,
                             .corners = gpu_frame_allocate(device, sizeof corners),
                             .push = {.geometry = {.scene = in->scene->scene},
                                      .side = (float)graph_image_info(graph, in->atlas).width}};
    if (!data.corners.data) return; /* the error sticks to the device */
    memcpy(data.corners.data, corners, sizeof corners);
    for (uint32_t i = 0; i < in->scene->bucket_count; i++) {
        const struct geometry_bucket *bucket = &in->scene->buckets[i];
        if (geometry_bucket_clustered(bucket)) data.casts[bucket->mask] = true;
        if (bucket->forward_layouts >> GEOMETRY_TRANSMISSIVE & 1) data.casts[1] = true; /* clear parts are holes */
    }
    const enum graph_role before = graph_set_role(graph, GRAPH_ROLE_SHADOW_FILL);
    struct graph_pass *pass = graph_add_pass(graph, "shadow fill", GRAPH_QUEUE_GRAPHICS, execute_draw, &data, sizeof data);
    graph_set_role(graph, before);
    graph_use_buffer(pass, in->scene->vertices, GRAPH_READ_VERTEX);
    graph_use_buffer(pass, draws, GRAPH_INDIRECT);
    graph_use_buffer(pass, fill->totals, GRAPH_INDIRECT);
    graph_add_row(pass, graph_buffer_row(&data.push.pairs, fill->pairs, GRAPH_READ_VERTEX));
    graph_add_row(pass, graph_buffer_row(&data.push.drawn, fill->drawn, GRAPH_READ_VERTEX));
    graph_add_row(pass, graph_buffer_row(&data.push.pages, in->pages, GRAPH_READ_VERTEX));
    graph_add_row(pass, graph_buffer_row(&data.push.shapes, in->shapes, GRAPH_READ_VERTEX));
    graph_depth(pass, in->atlas, VK_ATTACHMENT_LOAD_OP_LOAD, 0);
}

enum { KEPT_HEAD = sizeof(uint32_t) };

uint64_t shadow_fill_kept_bytes(uint32_t item_count) {
    return KEPT_HEAD + MAX(item_count, 1u) * (uint64_t)sizeof(struct gpu_fill_caster);
}

/* Marks the pages that show what has changed. */
static void add_marks(struct graph *graph, const struct shadow_fill_input *in, const struct gpu_fill_push *fill) {
    const uint32_t item_count = in->scene->item_count,
                   most = (uint32_t)((in->kept->size - KEPT_HEAD) / sizeof(struct gpu_fill_caster)); /* that are or were */
    graph_buffer kept = graph_import_buffer(graph, "shadow fill kept", in->kept),
                 changed = graph_create_buffer(graph, "shadow fill changed", (most + 1) * 4ull);
    struct gpu_fill_mark_push push = {.rays = fill->rays,
                                      .page_limit = in->page_limit,
                                      .item_count = item_count,
                                      .caster_count = fill->caster_count,
                                      .all_changed = in->all_changed};
    struct graph_pass *pass;
    if (!in->all_changed) {
        graph_add_clear(graph, "shadow fill changes clear", GRAPH_QUEUE_GRAPHICS,
                        (struct graph_clear){.buffers = {changed}});
        pass = graph_dispatch(graph, &(struct graph_dispatch){
                                         .name = "shadow fill changes",
                                         .pipeline = {.shader = &shader_fill_changes_comp},
                                         .groups = {DIVIDE_UP(most, 64u)},
                                         GRAPH_PUSH(push),
                                         GRAPH_ROWS(graph_reads(&push.kept, kept), graph_changes(&push.changed, changed))});
        rays_use(pass, in->rays, GRAPH_READ_COMPUTE);
    }
    pass = graph_dispatch(
        graph,
        &(struct graph_dispatch){.name = "shadow fill mark",
                                 .pipeline = {.shader = &shader_fill_mark_comp},
                                 .groups = {DIVIDE_UP(in->page_limit, 64u)},
                                 GRAPH_PUSH(push),
                                 GRAPH_ROWS(graph_changes(&push.pages, in->pages), graph_changes(&push.counts, in->counts),
                                            graph_reads(&push.shapes, in->shapes),
                                            graph_row_if(!in->all_changed, graph_reads(&push.kept, kept)),
                                            graph_row_if(!in->all_changed, graph_reads(&push.changed, changed)))});
    rays_use(pass, in->rays, GRAPH_READ_COMPUTE);
    pass = graph_dispatch(graph, &(struct graph_dispatch){.name = "shadow fill keep",
                                                          .pipeline = {.shader = &shader_fill_keep_comp},
                                                          .groups = {DIVIDE_UP(MAX(item_count, 1u), 64u)},
                                                          GRAPH_PUSH(push),
                                                          GRAPH_ROWS(graph_writes(&push.kept, kept))});
    rays_use(pass, in->rays, GRAPH_READ_COMPUTE);
}

struct shadow_fill shadow_fill_add(struct graph *graph, gpu_device *device, const struct shadow_fill_input *in) {
    const struct geometry_scene *scene = in->scene;
    const uint32_t capacity = MAX(in->pair_capacity, MAX(scene->item_count, 1u));
    struct shadow_fill fill = {
        .pairs = graph_create_buffer(graph, "shadow fill pairs", capacity * (uint64_t)sizeof(struct gpu_fill_pair)),
        .drawn = graph_create_buffer(graph, "shadow fill drawn", in->page_limit * 4ull),
        .totals = graph_create_buffer(graph, "shadow fill totals", sizeof(struct gpu_fill_totals))};
    graph_buffer sums = graph_create_buffer(graph, "shadow fill sums", (in->page_limit + 1) * 4ull),
                 unit_sums = graph_create_buffer(graph, "shadow fill unit sums", (scene->unit_count + 1) * 4ull),
                 entries =
                     graph_create_buffer(graph, "shadow fill entries", capacity * (uint64_t)sizeof(struct gpu_fill_entry)),
                 draws = graph_create_buffer(graph, "shadow fill draws",
                                             MAX(scene->unit_count, 1u) * 2ull * sizeof(struct gpu_draw));
    struct gpu_fill_push push = {.rays = in->rays->address,
                                 .page_limit = in->page_limit,
                                 .pair_capacity = capacity,
                                 .caster_count = scene->caster_count,
                                 .group_count = scene->group_count,
                                 .unit_count = scene->unit_count};
    const uint32_t page_groups = DIVIDE_UP(in->page_limit + 1, 64u);
    if (in->all_changed || in->moved) add_marks(graph, in, &push);
    graph_add_clear(graph, "shadow fill clear", GRAPH_QUEUE_GRAPHICS,
                    (struct graph_clear){.buffers = {unit_sums, fill.totals}});
    struct graph_pass *pass = graph_dispatch(
        graph,
        &(struct graph_dispatch){.name = "shadow fill count",
                                 .pipeline = {.shader = &shader_fill_count_comp},
                                 .groups = {page_groups},
                                 GRAPH_PUSH(push),
                                 GRAPH_ROWS(graph_reads(&push.pages, in->pages), graph_reads(&push.counts, in->counts),
                                            graph_reads(&push.shapes, in->shapes), graph_writes(&push.sums, sums))});
    rays_use(pass, in->rays, GRAPH_READ_COMPUTE);
    prefix_sum_add(graph, "shadow fill pages", GRAPH_QUEUE_GRAPHICS, sums, in->page_limit + 1);
    pass = graph_dispatch(graph,
                          &(struct graph_dispatch){
                              .name = "shadow fill list",
                              .pipeline = {.shader = &shader_fill_list_comp},
                              .groups = {page_groups},
                              GRAPH_PUSH(push),
                              GRAPH_ROWS(graph_changes(&push.pages, in->pages), graph_changes(&push.counts, in->counts),
                                         graph_reads(&push.shapes, in->shapes), graph_reads(&push.sums, sums),
                                         graph_changes(&push.unit_sums, unit_sums), graph_writes(&push.entries, entries),
                                         graph_writes(&push.drawn, fill.drawn), graph_changes(&push.totals, fill.totals))});
    rays_use(pass, in->rays, GRAPH_READ_COMPUTE);
    prefix_sum_add(graph, "shadow fill units", GRAPH_QUEUE_GRAPHICS, unit_sums, scene->unit_count + 1);
    graph_dispatch(graph, &(struct graph_dispatch){
                              .name = "shadow fill place",
                              .pipeline = {.shader = &shader_fill_place_comp},
                              .groups = {DIVIDE_UP(MAX(in->page_limit, scene->unit_count), 64u)},
                              GRAPH_PUSH(push),
                              GRAPH_ROWS(graph_reads(&push.sums, sums), graph_reads(&push.unit_sums, unit_sums),
                                         graph_reads(&push.entries, entries), graph_writes(&push.pairs, fill.pairs),
                                         graph_writes(&push.draws, draws), graph_changes(&push.totals, fill.totals))});
    add_draw(graph, device, in, &fill, draws);
    return fill;
}
