/* SPDX-License-Identifier: MIT */
#include "passes/decals/decals_gbuffer.h"

#include "passes/decals/decals_pass_shared.h"
#include "passes/geometry/prefix_sum.h"
#include "shaders.h"

#define RECEIVERS_FORMAT VK_FORMAT_R32G32_UINT
enum { BOX_INDICES = 36 };

/* ---- receivers ---- */

struct receivers_data {
    const struct geometry_scene *scene;
    struct geometry_draws draws;
    VkDeviceAddress view;
};

static void execute_receivers(const struct graph_context *context, const void *data) {
    const struct receivers_data *d = data;
    struct gpu_graphics_params state = {.fragment = &shader_decals_receivers_frag,
                                        .color_count = 1,
                                        .color_formats = {RECEIVERS_FORMAT},
                                        .depth_format = GEOMETRY_DEPTH_FORMAT,
                                        .depth_test = true,
                                        .depth_compare = VK_COMPARE_OP_EQUAL,
                                        .samples = 1};
    geometry_draw(context, d->scene, &d->draws, GEOMETRY_OPAQUE, &state, NULL, (struct gpu_geometry_push){.view = d->view});
}

static graph_image add_receivers(struct graph *graph, const struct shade_input *input, graph_image depth) {
    graph_image image = graph_create_image(
        graph, &(struct graph_image_params){
                   .name = "decal receivers", .format = RECEIVERS_FORMAT, .width = input->width, .height = input->height});
    struct receivers_data data = {input->scene, *input->draws, input->view};
    struct graph_pass *pass =
        graph_add_pass(graph, "decals receivers", GRAPH_QUEUE_GRAPHICS, execute_receivers, &data, sizeof data);
    geometry_use(pass, input->scene, input->draws, GEOMETRY_OPAQUE);
    graph_color(pass, image, VK_ATTACHMENT_LOAD_OP_CLEAR, (float[4]){0});
    graph_depth_read_only(pass, depth);
    return image;
}

/* ---- which tiles ---- */

struct tiles_data {
    struct light_input boxes;
    struct lights_in_view in_view;
    struct gpu_slice commands; /* an indirect draw without instances, then indices */
    graph_buffer draw, depths, sums, cursors, entries, totals, decals;
    graph_image depth;
    VkDeviceAddress set;
    uvec2 tiles;
    uint32_t tile_count, capacity;
    bool fills; /* the second time that boxes are drawn */
};

/* The number of boxes in view goes where the draw expects it. */
static void execute_begin(const struct graph_context *context, const void *data) {
    const struct tiles_data *d = data;
    if (!d->commands.data) return; /* the device carries a sticky error */
    const struct gpu_buffer *draw = graph_get_buffer(context, d->draw);
    const uint64_t before = offsetof(struct gpu_draw, instance_count), behind = before + 4;
    gpu_copy_buffer(context->commands, d->commands.buffer, d->commands.offset, draw, 0, before);
    gpu_copy_buffer(context->commands, d->commands.buffer, d->commands.offset + behind, draw, behind,
                    sizeof(struct gpu_draw) - behind);
    gpu_copy_buffer(context->commands, graph_get_buffer(context, d->in_view.sums), d->boxes.set.local_count * 4ull, draw, before,
                    4);
    gpu_fill_buffer(context->commands, graph_get_buffer(context, d->sums), 0, (d->tile_count + 1) * 4ull, 0);
}

static struct gpu_decals_box_push tiles_push(const struct tiles_data *d) {
    return (struct gpu_decals_box_push){.view = d->boxes.view, .set = d->set, .tiles = d->tiles, .capacity = d->capacity};
}

static void execute_boxes(const struct graph_context *context, const void *data) {
    const struct tiles_data *d = data;
    if (!d->commands.data) return;
    const bool fills = d->fills;
    /* Back faces, so that the viewer may be inside. */
    struct gpu_graphics_params state = {.vertex = &shader_decals_box_vert,
                                        .fragment = &shader_decals_box_frag,
                                        .constant_count = 2,
                                        .constants = {GPU_LIST_ALL, fills},
                                        .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST,
                                        .cull = VK_CULL_MODE_FRONT_BIT,
                                        .color_count = 1,
                                        .color_formats = {VK_FORMAT_R8_UNORM},
                                        .depth_clamp = true,
                                        .samples = 1};
    struct gpu_decals_box_push push = tiles_push(d);
    push.ids = graph_address(context, d->in_view.ids);
    push.counts = graph_address(context, fills ? d->cursors : d->sums);
    push.entries = fills ? graph_address(context, d->entries) : 0;
    push.depths = graph_address(context, d->depths);
    gpu_bind(context->commands, graph_pipeline(context, &state));
    gpu_push(context->commands, &push, sizeof push);
    gpu_bind_indices(context->commands, d->commands.buffer, d->commands.offset + sizeof(struct gpu_draw));
    gpu_draw_indexed_indirect(context->commands, graph_get_buffer(context, d->draw), 0, 1);
}

static void execute_cursors(const struct graph_context *context, const void *data) {
    const struct tiles_data *d = data;
    const struct gpu_buffer *sums = graph_get_buffer(context, d->sums), *totals = graph_get_buffer(context, d->totals);
    gpu_copy_buffer(context->commands, sums, 0, graph_get_buffer(context, d->cursors), 0, d->tile_count * 4ull);
    gpu_copy_buffer(context->commands, sums, d->tile_count * 4ull, totals, offsetof(struct decals_gbuffer_totals, entries),
                    4);
    gpu_fill_buffer(context->commands, totals, offsetof(struct decals_gbuffer_totals, overflow_pixels), 4, 0);
    gpu_copy_buffer(context->commands, graph_get_buffer(context, d->in_view.sums), d->boxes.set.local_count * 4ull, totals,
                    offsetof(struct decals_gbuffer_totals, in_view), 4);
    /* Entries are written where they are counted; the graph sees them begin here. */
    gpu_fill_buffer(context->commands, graph_get_buffer(context, d->entries), 0, 4, 0);
}

/* Drawn to an image of a texel a tile that nobody reads: it gives the grid its size. */
static void add_boxes(struct graph *graph, const char *name, const char *image_name, struct tiles_data *data) {
    graph_image grid = graph_create_image(
        graph, &(struct graph_image_params){
                   .name = image_name, .format = VK_FORMAT_R8_UNORM, .width = data->tiles.x, .height = data->tiles.y});
    const bool fills = data->fills;
    struct graph_pass *pass = graph_add_pass(graph, name, GRAPH_QUEUE_GRAPHICS, execute_boxes, data, sizeof *data);
    graph_use_buffer(pass, data->draw, GRAPH_INDIRECT);
    graph_use_buffer(pass, data->in_view.ids, GRAPH_READ_VERTEX);
    graph_use_buffer(pass, data->decals, GRAPH_READ_VERTEX);
    graph_use_buffer(pass, data->depths, GRAPH_READ_FRAGMENT);
    graph_use_buffer(pass, fills ? data->cursors : data->sums, GRAPH_READ_WRITE_FRAGMENT);
    if (fills) graph_use_buffer(pass, data->entries, GRAPH_READ_WRITE_FRAGMENT);
    graph_color(pass, grid, VK_ATTACHMENT_LOAD_OP_CLEAR, (float[4]){0});
}

/* Faces seen from outside are counter-clockwise; corner i is at (i & 1, i >> 1 & 1, i >> 2). */
static const uint32_t box_indices[BOX_INDICES] = {0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4,
                                                  2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6};

static void add_tiles(struct graph *graph, gpu_device *device, struct tiles_data *data) {
    data->commands = gpu_frame_allocate(device, sizeof(struct gpu_draw) + sizeof box_indices);
    if (data->commands.data) {
        *(struct gpu_draw *)data->commands.data = (struct gpu_draw){.index_count = BOX_INDICES};
        memcpy((char *)data->commands.data + sizeof(struct gpu_draw), box_indices, sizeof box_indices);
    }
    data->draw = graph_create_buffer(graph, "decal draw", sizeof(struct gpu_draw));
    data->depths = graph_create_buffer(graph, "decal tile depths", data->tile_count * 8ull);
    data->sums = graph_create_buffer(graph, "decal tile sums", (data->tile_count + 1) * 4ull);
    data->cursors = graph_create_buffer(graph, "decal tile cursors", data->tile_count * 4ull);
    data->entries = graph_create_buffer(graph, "decal tile entries", data->capacity * 4ull);
    data->totals = graph_create_buffer(graph, "decal totals", sizeof(struct decals_gbuffer_totals));
    struct graph_pass *pass = graph_add_pass(graph, "decals begin", GRAPH_QUEUE_GRAPHICS, execute_begin, data, sizeof *data);
    graph_use_buffer(pass, data->in_view.sums, GRAPH_COPY_FROM);
    graph_use_buffer(pass, data->draw, GRAPH_COPY_TO);
    graph_use_buffer(pass, data->sums, GRAPH_COPY_TO);
    struct gpu_decals_box_push push = tiles_push(data);
    graph_dispatch(graph, &(struct graph_dispatch){
                              .name = "decals depths",
                              .pipeline = {.shader = &shader_decals_depths_comp},
                              .groups = {DIVIDE_UP(data->tiles.x, 8u), DIVIDE_UP(data->tiles.y, 8u)},
                              GRAPH_PUSH(push),
                              GRAPH_ROWS(graph_samples(&push.depth, data->depth), graph_writes(&push.depths, data->depths))});
    add_boxes(graph, "decals count", "decal grid", data);
    prefix_sum_add(graph, "decal tiles", GRAPH_QUEUE_GRAPHICS, data->sums, data->tile_count + 1);
    pass = graph_add_pass(graph, "decals cursors", GRAPH_QUEUE_GRAPHICS, execute_cursors, data, sizeof *data);
    graph_use_buffer(pass, data->sums, GRAPH_COPY_FROM);
    graph_use_buffer(pass, data->in_view.sums, GRAPH_COPY_FROM);
    graph_use_buffer(pass, data->cursors, GRAPH_COPY_TO);
    graph_use_buffer(pass, data->totals, GRAPH_COPY_TO);
    graph_use_buffer(pass, data->entries, GRAPH_COPY_TO);
    data->fills = true;
    add_boxes(graph, "decals fill", "decal grid 2", data);
    push = tiles_push(data);
    graph_dispatch(graph, &(struct graph_dispatch){
                              .name = "decals sort",
                              .pipeline = {.shader = &shader_decals_sort_comp},
                              .groups = {DIVIDE_UP(data->tile_count, 64u)},
                              GRAPH_PUSH(push),
                              GRAPH_ROWS(graph_reads(&push.counts, data->sums), graph_changes(&push.entries, data->entries))});
}

/* ---- what becomes of them ---- */

struct copies_data {
    graph_image from[GBUFFER_TARGETS + 1], to[GBUFFER_TARGETS + 1];
    uint32_t count;
};

static void execute_copies(const struct graph_context *context, const void *data) {
    const struct copies_data *d = data;
    for (uint32_t i = 0; i < d->count; i++)
        gpu_copy_image(context->commands, graph_get_image(context, d->from[i]), graph_get_image(context, d->to[i]), NULL);
}

static graph_image add_copy(struct graph *graph, struct copies_data *copies, graph_image from) {
    struct graph_image_params params = graph_image_info(graph, from);
    params.name = graph_name(graph, "gbuffer copy %u", copies->count);
    graph_image to = graph_create_image(graph, &params);
    copies->from[copies->count] = from;
    copies->to[copies->count++] = to;
    return to;
}

struct merge_data {
    struct gbuffer copy;
    graph_image receivers, radiance;
    graph_buffer sums, entries, totals;
    VkDeviceAddress set;
    uint32_t capacity, tiles_x;
    bool mip_fix;
    struct gpu_graphics_params state;
};

static void execute_merge(const struct graph_context *context, const void *data) {
    const struct merge_data *d = data;
    struct gpu_decals_merge_push push = {.gbuffer = gbuffer_handles(context, &d->copy),
                                         .set = d->set,
                                         .sums = graph_address(context, d->sums),
                                         .entries = graph_address(context, d->entries),
                                         .totals = graph_address(context, d->totals),
                                         .receivers = graph_sampled(context, d->receivers),
                                         .radiance = d->radiance.id ? graph_sampled(context, d->radiance) : 0,
                                         .capacity = d->capacity,
                                         .mip_fix = d->mip_fix,
                                         .tiles_x = d->tiles_x};
    gpu_bind(context->commands, gpu_graphics_pipeline(context->device, &d->state));
    gpu_push(context->commands, &push, sizeof push);
    gpu_draw(context->commands, 3, 1, 0, 0);
}

static void add_merge(struct graph *graph, const struct decals_gbuffer_input *decals, const struct tiles_data *tiles,
                      graph_image receivers, const struct gbuffer *gbuffer, graph_image radiance) {
    struct copies_data copies = {.count = 0};
    struct merge_data merge = {.copy = *gbuffer,
                               .receivers = receivers,
                               .sums = tiles->sums,
                               .entries = tiles->entries,
                               .totals = tiles->totals,
                               .tiles_x = tiles->tiles.x,
                               .set = decals->set,
                               .capacity = decals->pool_capacity,
                               .mip_fix = decals->mip_fix};
    for (uint32_t i = 0; i < gbuffer->target_count; i++)
        merge.copy.targets[i] = add_copy(graph, &copies, gbuffer->targets[i]);
    merge.copy.mask = (graph_image){0}; /* what is lit forward is marked all the same */
    if (decals->emits) merge.radiance = add_copy(graph, &copies, radiance);
    struct graph_pass *pass =
        graph_add_pass(graph, "decals copy", GRAPH_QUEUE_GRAPHICS, execute_copies, &copies, sizeof copies);
    for (uint32_t i = 0; i < copies.count; i++) {
        graph_use_image(pass, copies.from[i], GRAPH_COPY_FROM);
        graph_use_image(pass, copies.to[i], GRAPH_COPY_TO);
    }
    merge.state = (struct gpu_graphics_params){.vertex = &shader_decals_merge_vert,
                                               .fragment = &shader_decals_merge_frag,
                                               .constant_count = 2,
                                               .constants = {GPU_LIST_ALL, decals->emits},
                                               .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST,
                                               .cull = VK_CULL_MODE_NONE,
                                               .samples = 1};
    graph_image targets[GBUFFER_TARGETS + 1];
    if (decals->emits) targets[merge.state.color_count++] = radiance;
    for (uint32_t i = 0; i < gbuffer->target_count; i++) targets[merge.state.color_count++] = gbuffer->targets[i];
    for (uint32_t i = 0; i < merge.state.color_count; i++)
        merge.state.color_formats[i] = graph_image_info(graph, targets[i]).format;
    gbuffer_specialise(&merge.copy, merge.state.constants, &merge.state.constant_count);
    pass = graph_add_pass(graph, "decals merge", GRAPH_QUEUE_GRAPHICS, execute_merge, &merge, sizeof merge);
    gbuffer_use(pass, &merge.copy, GRAPH_SAMPLE_FRAGMENT);
    if (merge.radiance.id) graph_use_image(pass, merge.radiance, GRAPH_SAMPLE_FRAGMENT);
    graph_use_image(pass, merge.receivers, GRAPH_SAMPLE_FRAGMENT);
    graph_use_buffer(pass, tiles->decals, GRAPH_READ_FRAGMENT);
    graph_use_buffer(pass, merge.sums, GRAPH_READ_FRAGMENT);
    graph_use_buffer(pass, merge.entries, GRAPH_READ_FRAGMENT);
    graph_use_buffer(pass, merge.totals, GRAPH_READ_WRITE_FRAGMENT);
    for (uint32_t i = 0; i < merge.state.color_count; i++)
        graph_color(pass, targets[i], VK_ATTACHMENT_LOAD_OP_LOAD, (float[4]){0});
}

graph_buffer decals_gbuffer_add(struct graph *graph, gpu_device *device, const struct shade_input *input,
                                const struct decals_gbuffer_input *decals, const struct gbuffer *gbuffer,
                                graph_image radiance) {
    struct tiles_data tiles = {.boxes = decals->boxes,
                               .in_view = decals->in_view,
                               .decals = decals->decals,
                               .depth = gbuffer->depth,
                               .set = decals->set,
                               .tiles = {DIVIDE_UP(input->width, DECAL_TILE), DIVIDE_UP(input->height, DECAL_TILE)},
                               .capacity = decals->pool_capacity};
    tiles.tile_count = tiles.tiles.x * tiles.tiles.y;
    graph_image receivers = add_receivers(graph, input, gbuffer->depth);
    add_tiles(graph, device, &tiles);
    add_merge(graph, decals, &tiles, receivers, gbuffer, radiance);
    return tiles.totals;
}
