/* SPDX-License-Identifier: MIT */
#include "passes/lights/bvh.h"

#include "passes/geometry/radix_shared.h"
#include "passes/lights/bvh_shared.h"
#include "passes/lights/clustered.h"
#include "shaders.h"

/* ---- the tree ---- */

/* Leaves, nodes, nodes 2 … */
static const char *level_name(struct graph *graph, const char *leaves, const char *nodes, uint32_t level) {
    return level ? graph_numbered_name(graph, nodes, level > 1 ? level : 0) : leaves;
}

struct bvh bvh_tree_add(struct graph *graph, const struct light_input *input, const struct lights_in_view *in_view,
                        VkDeviceAddress header) {
    uint32_t count = MAX(input->set.local_count, 1u), box_count = 0;
    const uint64_t count_offset = input->set.local_count * 4ull; /* of the number in view, after the sums */
    struct bvh tree = {0};
    for (uint32_t nodes = DIVIDE_UP(count, BVH_WIDTH);; nodes = DIVIDE_UP(nodes, BVH_WIDTH)) {
        tree.firsts[tree.level_count] = box_count;
        tree.counts[tree.level_count++] = nodes;
        box_count += nodes;
        if (nodes <= BVH_WIDTH) break;
    }
    graph_buffer pairs = graph_create_buffer(graph, "bvh keys", count * 8ull);
    const struct gpu_bvh_tree_push common = {.view = input->view, .list = header};
    struct gpu_bvh_tree_push push = common;
    graph_dispatch(graph, &(struct graph_dispatch){
                              .name = "bvh keys",
                              .queue = input->queue,
                              .pipeline = {.shader = &shader_bvh_keys_comp},
                              .groups = {DIVIDE_UP(count, 64u)},
                              GRAPH_PUSH(push),
                              GRAPH_ROWS(graph_row_at(count_offset, graph_reads(&push.count, in_view->sums)),
                                         graph_reads(&push.bounds, in_view->bounds), graph_writes(&push.pairs, pairs))});

    tree.pairs = radix_sort_add(graph, &(struct radix_sort_params){.what = "bvh",
                                                                   .queue = input->queue,
                                                                   .pairs = pairs,
                                                                   .capacity = count,
                                                                   .bits = BVH_KEY_BITS,
                                                                   .count = in_view->sums,
                                                                   .count_offset = count_offset});
    tree.spheres = graph_create_buffer(graph, "bvh spheres", count * sizeof(struct gpu_bound));
    tree.boxes = graph_create_buffer(graph, "bvh boxes", box_count * sizeof(struct gpu_bvh_box));
    push = common;
    push.first_out = tree.firsts[0];
    push.capacity_out = tree.counts[0];
    graph_dispatch(graph, &(struct graph_dispatch){
                              .name = "bvh leaves",
                              .queue = input->queue,
                              .pipeline = {.shader = &shader_bvh_leaves_comp},
                              .groups = {DIVIDE_UP(tree.counts[0], 64u)},
                              GRAPH_PUSH(push),
                              GRAPH_ROWS(graph_row_at(count_offset, graph_reads(&push.count, in_view->sums)),
                                         graph_reads(&push.bounds, in_view->bounds), graph_reads(&push.pairs, tree.pairs),
                                         graph_writes(&push.spheres, tree.spheres), graph_writes(&push.boxes, tree.boxes))});
    for (uint32_t level = 1; level < tree.level_count; level++) {
        push = common;
        push.first_in = tree.firsts[level - 1];
        push.capacity_in = tree.counts[level - 1];
        push.first_out = tree.firsts[level];
        push.capacity_out = tree.counts[level];
        graph_dispatch(graph, &(struct graph_dispatch){.name = level_name(graph, "bvh leaves", "bvh nodes", level),
                                                       .queue = input->queue,
                                                       .pipeline = {.shader = &shader_bvh_level_comp},
                                                       .groups = {DIVIDE_UP(tree.counts[level], 64u)},
                                                       GRAPH_PUSH(push),
                                                       GRAPH_ROWS(graph_changes(&push.boxes, tree.boxes))});
    }
    return tree;
}

/* ---- queries ---- */

/* Masks of groups take at most this many words, and sums this many numbers, unless there are more cells than that. */
enum { MASKS_LIMIT = 1 << 23, SUMS_LIMIT = 1 << 20, SPARSE_SUMS_LIMIT = 1 << 18, SORT_GROUPS = 1 << 12 };

struct query_data {
    struct light_input input;
    struct lights_in_view in_view;
    struct bvh tree;
    struct bvh_query query;
    struct gpu_bvh_groups rule;
    VkDeviceAddress block; /* struct gpu_bvh_query */
    graph_buffer groups, masks, sums, cells, ids, unsorted, overflow;
    uint32_t group_count, chunk_count, sort_steps;
    uint32_t words[BVH_LEVELS], first_masks[BVH_LEVELS];
};

/* The number of cells, and that of lights in view. */
static struct graph_row counter_row(const uint64_t *member, const struct query_data *d) {
    return graph_row_if(d->query.cell_counter.id,
                        graph_row_at(d->query.cell_counter_offset, graph_reads(member, d->query.cell_counter)));
}

static struct graph_row count_row(const uint64_t *member, const struct query_data *d) {
    return graph_row_at(d->input.set.local_count * 4ull, graph_reads(member, d->in_view.sums));
}

static bool uses_reaches(const struct bvh_query *query) { return query->cone_tests || query->facings.id; }

/* Groups that are small, but not so many that their masks take too much. */
static void choose_groups(struct query_data *d) {
    const struct gpu_light_list *grid = d->query.header;
    bool blocks = !d->query.cell_counter.id && grid;
    d->rule = (struct gpu_bvh_groups){.run = blocks ? 0 : 8, .block = {2, 2, 4}};
    for (;;) {
        if (blocks)
            d->group_count = DIVIDE_UP(grid->tiles_x, d->rule.block.x) * DIVIDE_UP(grid->tiles_y, d->rule.block.y) *
                             DIVIDE_UP(grid->slices, d->rule.block.z);
        else
            d->group_count = DIVIDE_UP(d->query.cell_count, d->rule.run);
        if (d->group_count == 1 || (uint64_t)d->group_count * d->words[0] <= MASKS_LIMIT) return;
        d->rule.run *= 2;
        d->rule.block = (uvec3){d->rule.block.x * 2, d->rule.block.y * 2, d->rule.block.z * 2};
    }
}

static void add_masks(struct graph *graph, struct query_data *d) {
    const char *what = d->query.what;
    uint32_t mask_count = 0;
    for (uint32_t l = 0; l < d->tree.level_count; l++) d->words[l] = DIVIDE_UP(d->tree.counts[l], 32u);
    choose_groups(d);
    for (uint32_t l = 0; l < d->tree.level_count; l++) {
        d->first_masks[l] = mask_count;
        mask_count += d->group_count * d->words[l];
    }
    d->groups =
        graph_create_buffer(graph, graph_name(graph, "%s group boxes", what), d->group_count * sizeof(struct gpu_bvh_box));
    d->masks = graph_create_buffer(graph, graph_name(graph, "%s masks", what), mask_count * 4ull);
    const struct gpu_bvh_mask_push common = {
        .list = d->query.header_address, .cell_count = d->query.cell_count, .rule = d->rule, .group_count = d->group_count};
    struct gpu_bvh_mask_push push = common;
    graph_dispatch(graph, &(struct graph_dispatch){.name = graph_name(graph, "%s groups", what),
                                                   .queue = d->input.queue,
                                                   .pipeline = {.shader = &shader_bvh_groups_comp},
                                                   .groups = {DIVIDE_UP(d->group_count, 64u)},
                                                   GRAPH_PUSH(push),
                                                   GRAPH_ROWS(counter_row(&push.cell_counter, d),
                                                              graph_reads(&push.cells, d->query.bounds),
                                                              graph_writes(&push.groups, d->groups))});
    const char *leaves = graph_name(graph, "%s leaves touched", what), *nodes = graph_name(graph, "%s nodes touched", what);
    for (uint32_t l = d->tree.level_count; l-- > 0;) {
        bool top = l + 1 == d->tree.level_count;
        push = common;
        push.first_node = d->tree.firsts[l];
        push.node_lights = BVH_WIDTH << (5 * l);
        push.first_mask = d->first_masks[l];
        push.words = d->words[l];
        push.first_parent = top ? 0 : d->first_masks[l + 1];
        push.parent_words = top ? 0 : d->words[l + 1];
        graph_dispatch(graph, &(struct graph_dispatch){
                                  .name = level_name(graph, leaves, nodes, l),
                                  .queue = d->input.queue,
                                  .pipeline = {.shader = &shader_bvh_mask_comp},
                                  .groups = {DIVIDE_UP(d->group_count * push.words, 64u)},
                                  GRAPH_PUSH(push),
                                  GRAPH_ROWS(counter_row(&push.cell_counter, d), count_row(&push.count, d),
                                             graph_reads(&push.groups, d->groups), graph_reads(&push.boxes, d->tree.boxes),
                                             graph_buffer_row(&push.masks, d->masks,
                                                              top ? GRAPH_WRITE_COMPUTE : GRAPH_READ_WRITE_COMPUTE))});
    }
}

/* Counts the lights of cells, or, given a pool, writes their ids. */
static struct graph_pass *add_query(struct graph *graph, const char *name, const struct query_data *d, graph_buffer pool) {
    bool fills = pool.id, facings = d->query.facings.id;
    struct gpu_bvh_query_push push = {.query = d->block, .list = d->query.header_address};
    return graph_dispatch(
        graph,
        &(struct graph_dispatch){
            .name = name,
            .queue = d->input.queue,
            .pipeline = {&shader_bvh_query_comp, 2, {GPU_LIST_ALL, fills}},
            .groups = {DIVIDE_UP((d->query.cell_count + 1) * d->chunk_count, 64u)},
            GRAPH_PUSH(push),
            GRAPH_ROWS(
                count_row(&push.count, d), counter_row(&push.cell_counter, d), graph_reads(&push.cells, d->query.bounds),
                graph_row_if(facings, graph_reads(&push.facings, d->query.facings)),
                graph_row_if(facings, graph_reads(NULL, d->input.set.buffer)), graph_reads(&push.boxes, d->tree.boxes),
                graph_row_at(d->first_masks[0] * 4ull, graph_reads(&push.masks, d->masks)),
                graph_reads(&push.spheres, d->tree.spheres), graph_reads(&push.pairs, d->tree.pairs),
                graph_row_if(uses_reaches(&d->query), graph_reads(&push.reaches, d->in_view.reaches)),
                graph_reads(&push.visible_ids, d->in_view.ids),
                graph_buffer_row(&push.sums, d->sums, fills ? GRAPH_READ_COMPUTE : GRAPH_WRITE_COMPUTE),
                graph_row_if(fills, graph_writes(&push.ids, pool)),
                graph_buffer_row(&push.overflow, d->overflow, fills ? GRAPH_READ_WRITE_COMPUTE : GRAPH_WRITE_COMPUTE))});
}

/* Puts the ids of each cell into order: step by step from one pool to the other, so that they end in d->ids. */
static void add_sort(struct graph *graph, const char *name, const struct query_data *d) {
    bool odd = d->sort_steps % 2;
    graph_buffer first = odd ? d->unsorted : d->ids, second = odd ? d->ids : d->unsorted;
    struct gpu_bvh_sort_push push = {.list = d->query.header_address,
                                     .cell_count = d->query.cell_count,
                                     .counted = d->query.cell_counter.id != 0,
                                     .steps = d->sort_steps};
    graph_dispatch(
        graph,
        &(struct graph_dispatch){
            .name = name,
            .queue = d->input.queue,
            .pipeline = {.shader = &shader_bvh_sort_comp},
            .groups = {MIN(d->query.cell_count, (uint32_t)SORT_GROUPS)},
            GRAPH_PUSH(push),
            GRAPH_ROWS(counter_row(&push.cell_counter, d), graph_reads(NULL, d->cells), graph_changes(&push.first, first),
                       graph_buffer_row(&push.second, second, odd ? GRAPH_READ_WRITE_COMPUTE : GRAPH_WRITE_COMPUTE),
                       graph_changes(&push.target, d->ids))});
}

struct light_list bvh_query_add(struct graph *graph, gpu_device *device, const struct light_input *input,
                                const struct lights_in_view *in_view, const struct bvh *tree,
                                const struct bvh_query *query) {
    const char *what = query->what;
    struct query_data data = {.input = *input, .in_view = *in_view, .tree = *tree, .query = *query};
    add_masks(graph, &data);

    uint32_t words = data.words[0], chunk_words = 1;
    uint32_t sums_limit = query->cell_counter.id ? SPARSE_SUMS_LIMIT : SUMS_LIMIT; /* few of the cells that could be are */
    while (chunk_words < words && (uint64_t)query->cell_count * DIVIDE_UP(words, chunk_words) > sums_limit) chunk_words *= 2;
    data.chunk_count = DIVIDE_UP(words, chunk_words);
    uint32_t sum_count = query->cell_count * data.chunk_count + 1;
    struct gpu_slice block = gpu_frame_allocate(device, sizeof(struct gpu_bvh_query));
    data.block = block.address;
    if (block.data)
        *(struct gpu_bvh_query *)block.data =
            (struct gpu_bvh_query){.cell_count = query->cell_count,
                                   .rule = data.rule,
                                   .words = words,
                                   .chunk_words = chunk_words,
                                   .chunk_count = data.chunk_count,
                                   .capacity = query->pool_capacity,
                                   .flags = (query->cone_tests ? CELLS_CONES : 0) | (query->facings.id ? BVH_FACINGS : 0)};
    uint32_t bits = 1;
    while (input->set.local_count > 1ull << bits) bits++;
    data.sort_steps = DIVIDE_UP(bits, RADIX_BITS);

    data.sums = graph_create_buffer(graph, graph_name(graph, "%s sums", what), sum_count * 4ull);
    data.cells =
        graph_create_buffer(graph, graph_name(graph, "%s cells", what), query->cell_count * sizeof(struct gpu_cell));
    data.ids = graph_create_buffer(graph, graph_name(graph, "%s ids", what), MAX(query->pool_capacity, 1u) * 4ull);
    data.unsorted =
        graph_create_buffer(graph, graph_name(graph, "%s unsorted ids", what), MAX(query->pool_capacity, 1u) * 4ull);
    data.overflow = graph_create_buffer(graph, graph_name(graph, "%s overflow", what), 4);

    add_query(graph, graph_name(graph, "%s count", what), &data, (graph_buffer){0});
    prefix_sum_add(graph, what, input->queue, data.sums, sum_count);
    struct graph_pass *pass =
        add_query(graph, graph_name(graph, "%s fill", what), &data, data.sort_steps % 2 ? data.unsorted : data.ids);
    graph_use_buffer(pass, data.cells, GRAPH_WRITE_COMPUTE);
    graph_use_buffer(pass, data.ids, GRAPH_WRITE_COMPUTE);
    add_sort(graph, graph_name(graph, "%s sort", what), &data);
    bool with_bounds = query->occupied && input->scattered;
    if (query->header) {
        graph_put_address(graph, &query->header->cells, data.cells);
        graph_put_address(graph, &query->header->ids, data.ids);
        if (with_bounds) graph_put_address(graph, &query->header->bounds, query->bounds);
    }

    return (struct light_list){.lights = input->set.buffer,
                               .header = query->header_address,
                               .cells = data.cells,
                               .ids = data.ids,
                               .spare = light_spare_add(graph, what, input, in_view, data.overflow, &query->header,
                                                        &query->header_address, 1, with_bounds),
                               .bounds = with_bounds ? query->bounds : (graph_buffer){0},
                               .cell_count = query->cell_count,
                               .byte_count = query->cell_count * sizeof(struct gpu_cell) + query->pool_capacity * 4ull,
                               .fixed_bytes = query->cell_count * sizeof(struct gpu_cell),
                               .entry_bytes = 4,
                               .totals = light_totals_add(graph, what, input, in_view, data.sums, sum_count, data.overflow)};
}

/* ---- clusters ---- */

struct light_list bvh_clusters_add(struct graph *graph, gpu_device *device, const struct light_input *input,
                                   const struct lights_in_view *in_view, const struct bvh *tree, const char *what,
                                   struct gpu_light_list *header, VkDeviceAddress header_address,
                                   const struct clustered_params *params) {
    const uint32_t cell_count = header ? header->tiles_x * header->tiles_y * header->slices : 1;
    graph_buffer bounds =
        graph_create_buffer(graph, graph_name(graph, "%s cell bounds", what), cell_count * sizeof(struct gpu_cell_bounds));
    struct gpu_cells_push push = {.view = input->view, .list = header_address, .cell_count = cell_count};
    graph_dispatch(graph, &(struct graph_dispatch){.name = graph_name(graph, "%s bounds", what),
                                                   .queue = input->queue,
                                                   .pipeline = {.shader = &shader_clustered_bounds_comp},
                                                   .groups = {DIVIDE_UP(cell_count, 64u)},
                                                   GRAPH_PUSH(push),
                                                   GRAPH_ROWS(graph_writes(&push.cells, bounds))});
    struct bvh_query query = {.what = what,
                              .bounds = bounds,
                              .cell_count = cell_count,
                              .cone_tests = params->cone_tests,
                              .pool_capacity = params->pool_capacity,
                              .header = header,
                              .header_address = header_address};
    struct light_list list = bvh_query_add(graph, device, input, in_view, tree, &query);
    list.kind = GPU_LIST_CLUSTERS;
    return list;
}

struct light_list bvh_add(struct graph *graph, gpu_device *device, const struct light_input *input,
                          const struct lights_in_view *in_view, const struct clustered_params *params) {
    VkDeviceAddress address;
    struct gpu_light_list *header = light_list_header(device, input, &address);
    if (header) clustered_grid(header, input->width, input->height, params);
    struct bvh tree = bvh_tree_add(graph, input, in_view, address);
    return bvh_clusters_add(graph, device, input, in_view, &tree, "bvh", header, address, params);
}
