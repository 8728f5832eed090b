/* SPDX-License-Identifier: MIT */
#include "passes/lights/backface.h"

#include "passes/lights/backface_shared.h"
#include "passes/lights/cells.h"
#include "shaders.h"

_Static_assert((uint32_t)BACKFACE_SUM == BACKFACE_AXIS_SUM && (uint32_t)BACKFACE_PYRAMID == BACKFACE_AXIS_PYRAMID,
               "backface_shared.h has the values of backface_axis");

struct backface_params backface_params_default(void) {
    return (struct backface_params){.tiles = tiled_params_default(), .least = 12};
}

/* Of the steps of this list alone; those of all cells are in cells.c. */
struct own_data {
    struct light_input input;
    struct lights_in_view in_view;
    struct cells_build build;
    struct gbuffer gbuffer;
    graph_buffer cones, picks, axes, marks, tally;
    VkDeviceAddress block; /* struct gpu_backface */
};

static void execute_clear(const struct graph_context *context, const void *data) {
    const struct own_data *d = data;
    const struct gpu_buffer *picks = graph_get_buffer(context, d->picks);
    static const uint32_t dispatch[4] = {BACKFACE_ROW, 0, 1, 0};
    for (uint32_t i = 0; i < 4; i++) gpu_fill_buffer(context->commands, picks, i * 4ull, 4, dispatch[i]);
    if (!d->marks.id) return;
    gpu_fill_buffer(context->commands, graph_get_buffer(context, d->marks), 0, MAX(d->input.set.local_count, 1u) * 4ull, 0);
    gpu_fill_buffer(context->commands, graph_get_buffer(context, d->tally), 0, 4, 0);
}

static struct gpu_cells_push push_of(const struct own_data *d) {
    return (struct gpu_cells_push){.view = d->input.view,
                                   .list = d->build.header_address,
                                   .extra = d->block,
                                   .front = GPU_NO_DEPTH};
}

static void add_refine(struct graph *graph, const struct cells_counted *counted, const void *user) {
    const struct own_data *d = user;
    struct gpu_cells_push common = push_of(d);
    common.cell_count = counted->cell_count;
    common.chunk_size = counted->chunk_size;
    common.chunk_count = counted->chunk_count;
    struct gpu_cells_push push = common;
    graph_dispatch(graph, &(struct graph_dispatch){.name = "backface pick",
                                                   .queue = d->input.queue,
                                                   .pipeline = {.shader = &shader_backface_pick_comp},
                                                   .groups = {DIVIDE_UP(counted->cell_count, 64u)},
                                                   GRAPH_PUSH(push),
                                                   GRAPH_ROWS(graph_reads(&push.sums, counted->sums),
                                                              graph_writes(NULL, d->cones), graph_changes(NULL, d->picks))});
    push = common;
    struct gpu_compute_params pipeline = counted->tests;
    pipeline.shader = &shader_backface_cull_comp;
    gbuffer_specialise(&d->gbuffer, pipeline.constants, &pipeline.constant_count);
    bool reaches = cells_use_reaches(d->build.flags);
    struct graph_pass *pass = graph_dispatch(
        graph, &(struct graph_dispatch){
                   .name = "backface cull",
                   .queue = d->input.queue,
                   .pipeline = pipeline,
                   .indirect = d->picks,
                   GRAPH_PUSH(push),
                   GRAPH_ROWS(graph_samples(&push.depth, d->gbuffer.depth), graph_reads(NULL, d->input.set.buffer),
                              graph_reads(NULL, d->picks), graph_reads(&push.cells, counted->bounds),
                              graph_reads(&push.visible_sums, d->in_view.sums),
                              graph_reads(&push.visible_ids, d->in_view.ids), graph_reads(&push.bounds, d->in_view.bounds),
                              graph_row_if(reaches, graph_reads(&push.reaches, d->in_view.reaches)),
                              graph_row_if(counted->marks.id, graph_reads(&push.marks, counted->marks)),
                              graph_changes(&push.sums, counted->sums), graph_changes(NULL, d->cones),
                              graph_row_if(d->axes.id, graph_reads(NULL, d->axes)))});
    gbuffer_use_normal(pass, &d->gbuffer, GRAPH_SAMPLE_COMPUTE);
}

/* The pyramid of normals: level 2, then the level of the tiles. */
static graph_buffer add_pyramid(struct graph *graph, const struct own_data *d, struct gpu_backface *block,
                                uint32_t tile_count) {
    const uint32_t block_count = DIVIDE_UP(d->input.width, 4u) * DIVIDE_UP(d->input.height, 4u);
    graph_buffer blocks = graph_create_buffer(graph, "backface blocks", block_count * (uint64_t)sizeof(vec3));
    graph_buffer axes = graph_create_buffer(graph, "backface axes", tile_count * sizeof(vec3));
    if (block) {
        graph_put_address(graph, &block->blocks, blocks);
        graph_put_address(graph, &block->axes, axes);
    }
    struct gpu_cells_push push = {.view = d->input.view, .list = d->build.header_address, .extra = d->block};
    struct gpu_compute_params pipeline = {.shader = &shader_backface_blocks_comp};
    gbuffer_specialise(&d->gbuffer, pipeline.constants, &pipeline.constant_count);
    struct graph_pass *pass = graph_dispatch(
        graph,
        &(struct graph_dispatch){.name = "backface blocks",
                                 .queue = d->input.queue,
                                 .pipeline = pipeline,
                                 .groups = {DIVIDE_UP(block_count, 64u)},
                                 GRAPH_PUSH(push),
                                 GRAPH_ROWS(graph_samples(&push.depth, d->gbuffer.depth), graph_writes(NULL, blocks))});
    gbuffer_use_normal(pass, &d->gbuffer, GRAPH_SAMPLE_COMPUTE);
    push.depth = 0;
    graph_dispatch(graph, &(struct graph_dispatch){.name = "backface axes",
                                                   .queue = d->input.queue,
                                                   .pipeline = {.shader = &shader_backface_axes_comp},
                                                   .groups = {DIVIDE_UP(tile_count, 64u)},
                                                   GRAPH_PUSH(push),
                                                   GRAPH_ROWS(graph_reads(NULL, blocks), graph_writes(NULL, axes))});
    return axes;
}

struct light_list backface_add(struct graph *graph, gpu_device *device, const struct light_input *input,
                               const struct lights_in_view *in_view, const struct gbuffer *gbuffer,
                               const struct backface_params *params) {
    struct own_data data = {.input = *input,
                            .in_view = *in_view,
                            .build = tiled_build(graph, device, input, gbuffer->depth, &params->tiles),
                            .gbuffer = *gbuffer};
    data.build.what = "backface";
    const uint32_t tile_count = data.build.bounds_groups_x * data.build.bounds_groups_y;
    struct gpu_slice slice = gpu_frame_allocate(device, sizeof(struct gpu_backface));
    struct gpu_backface *block = slice.data;
    data.block = slice.address;
    if (block)
        *block = (struct gpu_backface){.axis = (uint32_t)params->axis,
                                       .least = params->least,
                                       .every_tile = params->every_tile || params->tally,
                                       .marking = params->tally};
    data.cones = graph_create_buffer(graph, "backface cones", tile_count * sizeof(struct gpu_cone));
    data.picks = graph_create_buffer(graph, "backface picks", (tile_count + 4ull) * 4);
    if (params->tally) {
        data.marks = graph_create_buffer(graph, "backface marks", MAX(input->set.local_count, 1u) * 4ull);
        data.tally = graph_create_buffer(graph, "backface tally", 4);
    }
    if (block) {
        gbuffer_put_normal(graph, &block->gbuffer, gbuffer);
        graph_put_address(graph, &block->cones, data.cones);
        graph_put_address(graph, &block->picks, data.picks);
        if (params->tally) {
            graph_put_address(graph, &block->marks, data.marks);
            graph_put_address(graph, &block->tally, data.tally);
        }
    }
    struct graph_pass *pass = graph_add_pass(graph, "backface clear", input->queue, execute_clear, &data, sizeof data);
    graph_use_buffer(pass, data.picks, GRAPH_COPY_TO);
    if (params->tally) {
        graph_use_buffer(pass, data.marks, GRAPH_COPY_TO);
        graph_use_buffer(pass, data.tally, GRAPH_COPY_TO);
    }
    if (params->axis == BACKFACE_PYRAMID) data.axes = add_pyramid(graph, &data, block, tile_count);
    struct cells_build build = data.build;
    build.refine = (struct cells_refine){.add = add_refine,
                                         .user = &data,
                                         .fill_shader = &shader_backface_fill_comp,
                                         .address = data.block,
                                         .cones = data.cones,
                                         .marks = data.marks};
    struct light_list list = cells_add(graph, input, in_view, &build);
    list.kind = GPU_LIST_TILES;
    list.cones = data.cones;
    if (!params->tally) return list;
    struct gpu_cells_push push = push_of(&data);
    graph_dispatch(graph,
                   &(struct graph_dispatch){.name = "backface tally",
                                            .queue = input->queue,
                                            .pipeline = {.shader = &shader_backface_tally_comp},
                                            .groups = {DIVIDE_UP(MAX(input->set.local_count, 1u), 64u)},
                                            GRAPH_PUSH(push),
                                            GRAPH_ROWS(graph_reads(&push.visible_sums, in_view->sums),
                                                       graph_reads(NULL, data.marks), graph_changes(NULL, data.tally))});
    list.culled = data.tally;
    return list;
}
