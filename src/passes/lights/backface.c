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

/* The steps of this list alone; those of all cells are in cells.c. */
enum step { STEP_PICK, STEP_CULL, STEP_TALLY, STEP_BLOCKS, STEP_AXES };

struct own_data {
    struct light_input input;
    struct lights_in_view in_view;
    struct cells_build build;
    struct gbuffer gbuffer;
    graph_buffer bounds, sums, cones, picks, blocks, axes, marks, tally;
    struct gpu_backface *block; /* addresses are filled in while recording */
    VkDeviceAddress block_address;
    uint32_t cell_count, chunk_size, chunk_count;
    enum step step;
};

static void execute_clear(const struct graph_context *context, const void *data) {
    const struct own_data *d = data;
    const struct gpu_buffer *picks = graph_get_buffer(context, d->picks);
    static const uint32_t dispatch[4] = {BACKFACE_ROW, 0, 1, 0};
    for (uint32_t i = 0; i < 4; i++) gpu_fill_buffer(context->commands, picks, i * 4ull, 4, dispatch[i]);
    if (!d->marks.id) return;
    if (d->block) d->block->marks = graph_address(context, d->marks);
    gpu_fill_buffer(context->commands, graph_get_buffer(context, d->marks), 0, MAX(d->input.local_count, 1u) * 4ull, 0);
    gpu_fill_buffer(context->commands, graph_get_buffer(context, d->tally), 0, 4, 0);
}

/* The pyramid of normals: level 2, then the level of the tiles. */
static void execute_pyramid(const struct graph_context *context, const void *data) {
    const struct own_data *d = data;
    bool tiles = d->step == STEP_AXES;
    struct gpu_compute_params params = {.shader = tiles ? &shader_backface_axes_comp : &shader_backface_blocks_comp};
    struct gpu_cells_push push = {.view = d->input.view, .list = d->build.header_address, .extra = d->block_address};
    if (tiles) {
        if (d->block) d->block->axes = graph_address(context, d->axes);
    } else {
        if (d->block) d->block->blocks = graph_address(context, d->blocks);
        if (d->block) d->block->gbuffer = gbuffer_normal_handles(context, &d->gbuffer);
        push.depth = graph_sampled(context, d->gbuffer.depth);
        gbuffer_specialise(&d->gbuffer, params.constants, &params.constant_count);
    }
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    uint32_t threads = tiles ? d->build.bounds_groups_x * d->build.bounds_groups_y
                             : DIVIDE_UP(d->input.width, 4u) * DIVIDE_UP(d->input.height, 4u);
    gpu_dispatch_linear(context->commands, DIVIDE_UP(threads, 64u));
}

static void execute_step(const struct graph_context *context, const void *data) {
    const struct own_data *d = data;
    static const struct gpu_shader *const shaders[] = {[STEP_PICK] = &shader_backface_pick_comp,
                                                       [STEP_CULL] = &shader_backface_cull_comp,
                                                       [STEP_TALLY] = &shader_backface_tally_comp};
    struct gpu_compute_params params = {.shader = shaders[d->step]};
    struct gpu_cells_push push = {.view = d->input.view,
                                  .list = d->build.header_address,
                                  .extra = d->block_address,
                                  .light_count = d->input.local_count,
                                  .cell_count = d->cell_count,
                                  .chunk_size = d->chunk_size,
                                  .chunk_count = d->chunk_count,
                                  .flags = d->build.flags,
                                  .front = GPU_NO_DEPTH};
    if (d->step != STEP_TALLY) push.sums = graph_address(context, d->sums);
    if (d->step != STEP_PICK) push.visible_sums = graph_address(context, d->in_view.sums);
    if (d->step == STEP_PICK && d->block) d->block->cones = graph_address(context, d->cones);
    if (d->step == STEP_PICK && d->block) d->block->picks = graph_address(context, d->picks);
    if (d->step == STEP_TALLY && d->block) d->block->tally = graph_address(context, d->tally);
    if (d->step == STEP_CULL) {
        push.cells = graph_address(context, d->bounds);
        push.visible_ids = graph_address(context, d->in_view.ids);
        push.bounds = graph_address(context, d->in_view.bounds);
        if (cells_use_reaches(push.flags)) push.reaches = graph_address(context, d->in_view.reaches);
        push.depth = graph_sampled(context, d->gbuffer.depth);
        if (d->block) d->block->gbuffer = gbuffer_normal_handles(context, &d->gbuffer);
        gbuffer_specialise(&d->gbuffer, params.constants, &params.constant_count);
    }
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    if (d->step == STEP_CULL)
        gpu_dispatch_indirect(context->commands, graph_get_buffer(context, d->picks), 0);
    else
        gpu_dispatch_linear(context->commands,
                            DIVIDE_UP(d->step == STEP_PICK ? d->cell_count : MAX(d->input.local_count, 1u), 64u));
}

static void add_refine(struct graph *graph, const struct cells_counted *counted, const void *user) {
    struct own_data data = *(const struct own_data *)user;
    const enum graph_queue queue = data.input.queue;
    data.bounds = counted->bounds;
    data.sums = counted->sums;
    data.cell_count = counted->cell_count;
    data.chunk_size = counted->chunk_size;
    data.chunk_count = counted->chunk_count;
    data.step = STEP_PICK;
    struct graph_pass *pass = graph_add_pass(graph, "backface pick", queue, execute_step, &data, sizeof data);
    graph_use_buffer(pass, data.sums, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, data.cones, GRAPH_WRITE_COMPUTE);
    graph_use_buffer(pass, data.picks, GRAPH_READ_WRITE_COMPUTE);
    data.step = STEP_CULL;
    pass = graph_add_pass(graph, "backface cull", queue, execute_step, &data, sizeof data);
    gbuffer_use_normal(pass, &data.gbuffer, GRAPH_SAMPLE_COMPUTE);
    graph_use_buffer(pass, data.input.buffer, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, data.picks, GRAPH_INDIRECT);
    graph_use_buffer(pass, data.picks, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, data.bounds, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, data.in_view.sums, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, data.in_view.ids, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, data.in_view.bounds, GRAPH_READ_COMPUTE);
    if (cells_use_reaches(data.build.flags)) graph_use_buffer(pass, data.in_view.reaches, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, data.sums, GRAPH_READ_WRITE_COMPUTE);
    graph_use_buffer(pass, data.cones, GRAPH_READ_WRITE_COMPUTE);
    if (data.axes.id) graph_use_buffer(pass, data.axes, GRAPH_READ_COMPUTE);
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
    data.block = slice.data;
    data.block_address = slice.address;
    if (data.block)
        *data.block = (struct gpu_backface){.axis = (uint32_t)params->axis,
                                            .least = params->least,
                                            .every_tile = params->every_tile || params->tally,
                                            .marking = params->tally};
    data.cones = graph_create_buffer(graph, "backface cones", tile_count * sizeof(struct gpu_cone));
    data.picks = graph_create_buffer(graph, "backface picks", (tile_count + 4ull) * 4);
    if (params->tally) {
        data.marks = graph_create_buffer(graph, "backface marks", MAX(input->local_count, 1u) * 4ull);
        data.tally = graph_create_buffer(graph, "backface tally", 4);
    }
    struct graph_pass *pass = graph_add_pass(graph, "backface clear", input->queue, execute_clear, &data, sizeof data);
    graph_use_buffer(pass, data.picks, GRAPH_COPY_TO);
    if (params->tally) {
        graph_use_buffer(pass, data.marks, GRAPH_COPY_TO);
        graph_use_buffer(pass, data.tally, GRAPH_COPY_TO);
    }
    if (params->axis == BACKFACE_PYRAMID) {
        data.blocks = graph_create_buffer(
            graph, "backface blocks", (uint64_t)DIVIDE_UP(input->width, 4u) * DIVIDE_UP(input->height, 4u) * sizeof(vec3));
        data.axes = graph_create_buffer(graph, "backface axes", tile_count * sizeof(vec3));
        data.step = STEP_BLOCKS;
        pass = graph_add_pass(graph, "backface blocks", input->queue, execute_pyramid, &data, sizeof data);
        gbuffer_use_normal(pass, gbuffer, GRAPH_SAMPLE_COMPUTE);
        graph_use_buffer(pass, data.blocks, GRAPH_WRITE_COMPUTE);
        data.step = STEP_AXES;
        pass = graph_add_pass(graph, "backface axes", input->queue, execute_pyramid, &data, sizeof data);
        graph_use_buffer(pass, data.blocks, GRAPH_READ_COMPUTE);
        graph_use_buffer(pass, data.axes, GRAPH_WRITE_COMPUTE);
    }
    struct cells_build build = data.build;
    build.refine = (struct cells_refine){.add = add_refine,
                                         .user = &data,
                                         .fill_shader = &shader_backface_fill_comp,
                                         .address = data.block_address,
                                         .cones = data.cones,
                                         .marks = data.marks};
    struct light_list list = cells_add(graph, input, in_view, &build);
    list.kind = GPU_LIST_TILES;
    list.cones = data.cones;
    if (!params->tally) return list;
    data.step = STEP_TALLY;
    pass = graph_add_pass(graph, "backface tally", input->queue, execute_step, &data, sizeof data);
    graph_use_buffer(pass, in_view->sums, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, data.marks, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, data.tally, GRAPH_READ_WRITE_COMPUTE);
    list.culled = data.tally;
    return list;
}
