/* SPDX-License-Identifier: MIT */
#include "passes/lights/cells.h"

#include "passes/geometry/prefix_sum.h"
#include "shaders.h"

enum { MAX_SUMS = 1 << 24, MAX_CHUNKS = 65535 };
enum { MAX_TESTS = 1 << 26 }; /* of lights against cells in a dispatch: a fraction of a second on a slow device */

/* Lights are marked from so many on; fewer are tested as fast. */
enum { MARKED_LIGHTS = 2048, MARK_BYTES = 64 << 20 };
/* The count keeps what it finds for the fill, a bit for each light and cell, where that takes no more than this. */
enum { KEPT_BYTES = 64 << 20 };

static uint32_t blocks_of(const struct gpu_light_list *grid, uint32_t side) {
    return DIVIDE_UP(grid->tiles_x, side) * DIVIDE_UP(grid->tiles_y, side) * DIVIDE_UP(grid->slices, CELLS_BLOCK_SLICES);
}

/* Side of the blocks that lights are marked for, in tiles; 0: they are not. Blocks grow until their marks fit. */
static uint32_t block_side(const struct cells_build *build, uint32_t light_count) {
    const struct gpu_light_list *grid = build->header;
    if (!grid || build->scattered_cells || light_count < MARKED_LIGHTS) return 0;
    const uint64_t bytes = DIVIDE_UP(light_count, 32u) * 4ull;
    uint32_t side = grid->slices > 2 ? 2 : 4; /* clusters have larger tiles */
    while (blocks_of(grid, side) * bytes > MARK_BYTES && side < MAX(grid->tiles_x, grid->tiles_y)) side *= 2;
    return side;
}

/* Mark, count and fill: chunks of lights against so many cells, or blocks of them. Each row's member is in `push`. */
static struct graph_pass *add_tests(struct graph *graph, const char *name, enum graph_queue queue,
                                    const struct gpu_compute_params *pipeline, struct gpu_cells_push *push, uint32_t count,
                                    const struct graph_row *rows, uint32_t row_count) {
    /* Systems reset a device that stays with one piece of work for seconds. */
    const uint32_t groups = DIVIDE_UP(count, 64u);
    const uint32_t cells = 64 * (uint32_t)CLAMP(MAX_TESTS / (64ull * push->chunk_size), 1u, (uint64_t)groups);
    const uint32_t chunks = (uint32_t)MAX(MAX_TESTS / ((uint64_t)cells * push->chunk_size), 1u);
    struct graph_pass *pass = NULL;
    for (push->first_cell = 0; push->first_cell < count; push->first_cell += cells)
        for (push->first_chunk = 0; push->first_chunk < push->chunk_count; push->first_chunk += chunks)
            pass = graph_dispatch(graph, &(struct graph_dispatch){.pass = pass,
                                                                  .name = name,
                                                                  .queue = queue,
                                                                  .pipeline = *pipeline,
                                                                  .groups = {MIN(cells / 64, groups - push->first_cell / 64),
                                                                             MIN(chunks, push->chunk_count - push->first_chunk)},
                                                                  .push = push,
                                                                  .push_size = sizeof *push,
                                                                  .rows = rows,
                                                                  .row_count = row_count});
    return pass;
}

struct light_list cells_add(struct graph *graph, const struct light_input *input, const struct lights_in_view *in_view,
                            const struct cells_build *build) {
    const char *what = build->what;
    /* Without memory for the header the device already carries a sticky error; the grid only has to be valid. */
    const uint32_t cell_count = build->header ? build->header->tiles_x * build->header->tiles_y * build->header->slices : 1;
    /* Chunks keep a big device busy; there need not be more than a few million of them. */
    const uint32_t side = block_side(build, input->set.local_count);
    const uint64_t kept_bytes = cell_count * (uint64_t)DIVIDE_UP(MAX(input->set.local_count, 1u), 32u) * 4;
    const bool keeps = kept_bytes <= KEPT_BYTES;
    const struct gpu_compute_params tests = {.constant_count = 3,
                                             .constants = {GPU_LIST_ALL, build->flags | (keeps ? CELLS_KEPT : 0), side}};
    struct gpu_compute_params pipeline = tests;
    uint32_t chunk_size = side ? CELL_MARKED_CHUNK : CELL_CHUNK;
    for (uint32_t chunks; (chunks = DIVIDE_UP(input->set.local_count, chunk_size)) > MAX_CHUNKS ||
                          (chunks > 1 && (uint64_t)cell_count * chunks > MAX_SUMS);)
        chunk_size *= 2;
    const uint32_t chunk_count = MAX(DIVIDE_UP(input->set.local_count, chunk_size), 1u),
                   sum_count = cell_count * chunk_count + 1;
    graph_buffer bounds =
        graph_create_buffer(graph, graph_name(graph, "%s cell bounds", what), cell_count * sizeof(struct gpu_cell_bounds));
    graph_buffer sums = graph_create_buffer(graph, graph_name(graph, "%s sums", what), sum_count * 4ull);
    graph_buffer cells =
        graph_create_buffer(graph, graph_name(graph, "%s cells", what), cell_count * sizeof(struct gpu_cell));
    graph_buffer ids = graph_create_buffer(graph, graph_name(graph, "%s ids", what), MAX(build->pool_capacity, 1u) * 4ull);
    graph_buffer overflow = graph_create_buffer(graph, graph_name(graph, "%s overflow", what), 4), extra = {0}, kept = {0};
    if (keeps) kept = graph_create_buffer(graph, graph_name(graph, "%s kept", what), kept_bytes);
    if (build->extra_bytes) extra = graph_create_buffer(graph, graph_name(graph, "%s extra", what), build->extra_bytes);
    const bool ranges = build->flags & CELLS_RANGES; /* then fill writes what is extra, else the bounds do */
    const bool reaches = cells_use_reaches(build->flags);
    const struct cells_refine *refine = &build->refine;
    const struct gpu_cells_push common = {.view = input->view,
                                          .list = build->header_address,
                                          .cell_count = cell_count,
                                          .chunk_size = chunk_size,
                                          .chunk_count = chunk_count,
                                          .capacity = build->pool_capacity,
                                          .depth = GPU_NO_DEPTH,
                                          .front = GPU_NO_DEPTH};
    struct gpu_cells_push push = common;
    graph_dispatch(graph, &(struct graph_dispatch){
                              .name = graph_name(graph, "%s bounds", what),
                              .queue = input->queue,
                              .pipeline = {build->bounds_shader,
                                           4,
                                           {GPU_LIST_ALL, build->bounds_samples, build->bounds_rows, build->flags}},
                              .groups = {build->bounds_groups_x, build->bounds_groups_y},
                              GRAPH_PUSH(push),
                              GRAPH_ROWS(graph_row_if(build->depth.id, graph_samples(&push.depth, build->depth)),
                                         graph_row_if(build->front.id, graph_samples(&push.front, build->front)),
                                         graph_row_if(build->bounds_input.id, graph_reads(NULL, build->bounds_input)),
                                         graph_writes(&push.cells, bounds),
                                         graph_row_if(extra.id && !ranges, graph_writes(&push.extra, extra)))});

    graph_buffer marks = {0};
    if (side) {
        const uint32_t block_count = blocks_of(build->header, side);
        graph_buffer blocks =
            graph_create_buffer(graph, graph_name(graph, "%s blocks", what), block_count * sizeof(struct gpu_cell_block));
        marks = graph_create_buffer(graph, graph_name(graph, "%s marks", what),
                                    block_count * (uint64_t)DIVIDE_UP(input->set.local_count, 32u) * 4);
        push = common;
        pipeline.shader = &shader_cells_blocks_comp;
        graph_dispatch(graph, &(struct graph_dispatch){
                                  .name = graph_name(graph, "%s blocks", what),
                                  .queue = input->queue,
                                  .pipeline = pipeline,
                                  .groups = {DIVIDE_UP(block_count, 64u)},
                                  GRAPH_PUSH(push),
                                  GRAPH_ROWS(graph_reads(&push.cells, bounds), graph_writes(&push.extra, blocks))});
        push = common;
        const struct graph_row mark_rows[] = {graph_reads(&push.extra, blocks), graph_reads(&push.visible_sums, in_view->sums),
                                              graph_reads(&push.bounds, in_view->bounds),
                                              graph_row_if(reaches, graph_reads(&push.reaches, in_view->reaches)),
                                              graph_writes(&push.marks, marks)};
        pipeline.shader = &shader_cells_mark_comp;
        add_tests(graph, graph_name(graph, "%s mark", what), input->queue, &pipeline, &push, block_count, mark_rows,
                  COUNT_OF(mark_rows));
    }

    push = common;
    if (refine->add) push.extra = refine->address;
    const struct graph_row count_rows[] = {
        graph_row_if(side, graph_reads(&push.marks, marks)),
        graph_reads(&push.cells, bounds),
        graph_reads(&push.visible_sums, in_view->sums),
        graph_reads(&push.bounds, in_view->bounds),
        graph_row_if(reaches, graph_reads(&push.reaches, in_view->reaches)),
        graph_writes(&push.sums, sums),
        graph_writes(&push.overflow, overflow),
        graph_row_if(kept.id, graph_writes(&push.ids, kept)),
        graph_row_if(extra.id && !ranges, graph_reads(refine->add ? NULL : &push.extra, extra))};
    pipeline.shader = &shader_cells_count_comp;
    add_tests(graph, graph_name(graph, "%s count", what), input->queue, &pipeline, &push, cell_count + 1, count_rows,
              COUNT_OF(count_rows));

    if (refine->add)
        refine->add(graph, &(struct cells_counted){.input = input,
                                                   .in_view = in_view,
                                                   .build = build,
                                                   .bounds = bounds,
                                                   .sums = sums,
                                                   .marks = keeps ? kept : marks,
                                                   .cell_count = cell_count,
                                                   .chunk_size = chunk_size,
                                                   .chunk_count = chunk_count,
                                                   .tests = tests},
                    refine->user);

    prefix_sum_add(graph, what, input->queue, sums, sum_count);

    push = common;
    if (refine->add) push.extra = refine->address;
    const struct graph_row fill_rows[] = {
        graph_row_if(side && !keeps, graph_reads(&push.marks, marks)),
        graph_row_if(kept.id, graph_reads(&push.marks, kept)),
        graph_reads(&push.cells, bounds),
        graph_reads(&push.sums, sums),
        graph_reads(&push.visible_sums, in_view->sums),
        graph_reads(&push.visible_ids, in_view->ids),
        graph_reads(&push.bounds, in_view->bounds),
        graph_row_if(reaches, graph_reads(&push.reaches, in_view->reaches)),
        graph_row_if(refine->add, graph_reads(NULL, input->set.buffer)),
        graph_row_if(refine->add, graph_reads(NULL, refine->cones)),
        graph_row_if(refine->marks.id, graph_changes(NULL, refine->marks)),
        graph_changes(&push.overflow, overflow),
        graph_writes(NULL, cells),
        graph_writes(&push.ids, ids),
        graph_row_if(extra.id, graph_buffer_row(refine->add ? NULL : &push.extra, extra,
                                                ranges ? GRAPH_WRITE_COMPUTE : GRAPH_READ_COMPUTE))};
    pipeline.shader = refine->add ? refine->fill_shader : &shader_cells_fill_comp;
    add_tests(graph, graph_name(graph, "%s fill", what), input->queue, &pipeline, &push, cell_count, fill_rows,
              COUNT_OF(fill_rows));
    if (build->header) {
        graph_put_address(graph, &build->header->cells, cells);
        graph_put_address(graph, &build->header->ids, ids);
        if (input->scattered) graph_put_address(graph, &build->header->bounds, bounds);
        if (extra.id) graph_put_address(graph, &build->header->extra, extra);
    }

    graph_buffer spare = light_spare_add(graph, what, input, in_view, overflow, &build->header, &build->header_address, 1,
                                         input->scattered && (build->depth.id || build->bounds_input.id));
    uint64_t fixed_bytes = cell_count * sizeof(struct gpu_cell) + (ranges ? 0 : build->extra_bytes);
    uint32_t entry_bytes = ranges ? 8 : 4;
    return (struct light_list){.lights = input->set.buffer,
                               .header = build->header_address,
                               .cells = cells,
                               .ids = ids,
                               .extra = extra,
                               .bounds = input->scattered ? bounds : (graph_buffer){0},
                               .spare = spare,
                               .cell_count = cell_count,
                               .byte_count = fixed_bytes + (uint64_t)build->pool_capacity * entry_bytes,
                               .fixed_bytes = fixed_bytes,
                               .entry_bytes = entry_bytes,
                               .totals = light_totals_add(graph, what, input, in_view, sums, sum_count, overflow)};
}
