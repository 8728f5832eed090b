/* SPDX-License-Identifier: MIT */
#include "passes/lights/cells.h"

#include "passes/geometry/prefix_sum.h"
#include "shaders.h"

enum { MAX_SUMS = 1 << 24, MAX_CHUNKS = 65535 };
enum { MAX_TESTS = 1 << 26 }; /* of lights against cells in a dispatch: a fraction of a second on a slow device */

/* Count and fill: a pass of all lights against all cells. Each row's member is in `push`. */
static struct graph_pass *add_tests(struct graph *graph, const char *name, enum graph_queue queue, const struct gpu_shader *shader,
                                    struct gpu_cells_push *push, const struct graph_row *rows, uint32_t row_count) {
    /* Systems reset a device that stays with one piece of work for seconds. */
    const uint32_t groups = DIVIDE_UP(push->cell_count + 1, 64u);
    const uint32_t cells = 64 * (uint32_t)CLAMP(MAX_TESTS / (64ull * push->chunk_size), 1u, (uint64_t)groups);
    const uint32_t chunks = (uint32_t)MAX(MAX_TESTS / ((uint64_t)cells * push->chunk_size), 1u);
    struct graph_pass *pass = NULL;
    for (push->first_cell = 0; push->first_cell <= push->cell_count; push->first_cell += cells)
        for (push->first_chunk = 0; push->first_chunk < push->chunk_count; push->first_chunk += chunks)
            pass = graph_dispatch(graph, &(struct graph_dispatch){.pass = pass,
                                                                  .name = name,
                                                                  .queue = queue,
                                                                  .pipeline = {.shader = shader},
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
    uint32_t chunk_size = CELL_CHUNK;
    for (uint32_t chunks; (chunks = DIVIDE_UP(input->local_count, chunk_size)) > MAX_CHUNKS ||
                          (chunks > 1 && (uint64_t)cell_count * chunks > MAX_SUMS);)
        chunk_size *= 2;
    const uint32_t chunk_count = MAX(DIVIDE_UP(input->local_count, chunk_size), 1u),
                   sum_count = cell_count * chunk_count + 1;
    graph_buffer bounds =
        graph_create_buffer(graph, graph_name(graph, "%s cell bounds", what), cell_count * sizeof(struct gpu_cell_bounds));
    graph_buffer sums = graph_create_buffer(graph, graph_name(graph, "%s sums", what), sum_count * 4ull);
    graph_buffer cells =
        graph_create_buffer(graph, graph_name(graph, "%s cells", what), cell_count * sizeof(struct gpu_cell));
    graph_buffer ids = graph_create_buffer(graph, graph_name(graph, "%s ids", what), MAX(build->pool_capacity, 1u) * 4ull);
    graph_buffer overflow = graph_create_buffer(graph, graph_name(graph, "%s overflow", what), 4), extra = {0};
    if (build->extra_bytes) extra = graph_create_buffer(graph, graph_name(graph, "%s extra", what), build->extra_bytes);
    const bool ranges = build->flags & CELLS_RANGES; /* then fill writes what is extra, else the bounds do */
    const bool reaches = cells_use_reaches(build->flags);
    const struct cells_refine *refine = &build->refine;
    const struct gpu_cells_push common = {.view = input->view,
                                          .list = build->header_address,
                                          .light_count = input->local_count,
                                          .cell_count = cell_count,
                                          .chunk_size = chunk_size,
                                          .chunk_count = chunk_count,
                                          .capacity = build->pool_capacity,
                                          .flags = build->flags,
                                          .depth = GPU_NO_DEPTH,
                                          .front = GPU_NO_DEPTH};
    struct gpu_cells_push push = common;
    graph_dispatch(graph, &(struct graph_dispatch){
                              .name = graph_name(graph, "%s bounds", what),
                              .queue = input->queue,
                              .pipeline = {build->bounds_shader, 3, {GPU_LIST_ALL, build->bounds_samples, build->bounds_rows}},
                              .groups = {build->bounds_groups_x, build->bounds_groups_y},
                              GRAPH_PUSH(push),
                              GRAPH_ROWS(graph_row_if(build->depth.id, graph_samples(&push.depth, build->depth)),
                                         graph_row_if(build->front.id, graph_samples(&push.front, build->front)),
                                         graph_row_if(build->bounds_input.id, graph_reads(NULL, build->bounds_input)),
                                         graph_writes(&push.cells, bounds),
                                         graph_row_if(extra.id && !ranges, graph_writes(&push.extra, extra)))});

    push = common;
    if (refine->add) push.extra = refine->address;
    const struct graph_row count_rows[] = {
        graph_reads(&push.cells, bounds),
        graph_reads(&push.visible_sums, in_view->sums),
        graph_reads(&push.bounds, in_view->bounds),
        graph_row_if(reaches, graph_reads(&push.reaches, in_view->reaches)),
        graph_writes(&push.sums, sums),
        graph_writes(&push.overflow, overflow),
        graph_row_if(extra.id && !ranges, graph_reads(refine->add ? NULL : &push.extra, extra))};
    add_tests(graph, graph_name(graph, "%s count", what), input->queue, &shader_cells_count_comp, &push, count_rows,
              COUNT_OF(count_rows));

    if (refine->add)
        refine->add(graph, &(struct cells_counted){input, in_view, build, bounds, sums, cell_count, chunk_size, chunk_count},
                    refine->user);

    prefix_sum_add(graph, what, input->queue, sums, sum_count);

    push = common;
    if (refine->add) push.extra = refine->address;
    const struct graph_row fill_rows[] = {
        graph_reads(&push.cells, bounds),
        graph_reads(&push.sums, sums),
        graph_reads(&push.visible_sums, in_view->sums),
        graph_reads(&push.visible_ids, in_view->ids),
        graph_reads(&push.bounds, in_view->bounds),
        graph_row_if(reaches, graph_reads(&push.reaches, in_view->reaches)),
        graph_row_if(refine->add, graph_reads(NULL, input->buffer)),
        graph_row_if(refine->add, graph_reads(NULL, refine->cones)),
        graph_row_if(refine->marks.id, graph_changes(NULL, refine->marks)),
        graph_changes(&push.overflow, overflow),
        graph_writes(NULL, cells),
        graph_writes(&push.ids, ids),
        graph_row_if(extra.id, graph_buffer_row(refine->add ? NULL : &push.extra, extra,
                                                ranges ? GRAPH_WRITE_COMPUTE : GRAPH_READ_COMPUTE))};
    add_tests(graph, graph_name(graph, "%s fill", what), input->queue,
              refine->add ? refine->fill_shader : &shader_cells_fill_comp, &push, fill_rows, COUNT_OF(fill_rows));
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
    return (struct light_list){.lights = input->buffer,
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
