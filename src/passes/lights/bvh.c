/* SPDX-License-Identifier: MIT */
#include "passes/lights/bvh.h"

#include "passes/geometry/radix_shared.h"
#include "passes/lights/bvh_shared.h"
#include "passes/lights/clustered.h"
#include "shaders.h"

/* ---- the tree ---- */

struct tree_data {
    struct light_input input;
    struct lights_in_view in_view;
    struct bvh tree;
    VkDeviceAddress header;
    const struct gpu_shader *shader;
    uint32_t threads, level; /* of bvh_level */
};

static void execute_tree(const struct graph_context *context, const void *data) {
    const struct tree_data *d = data;
    struct gpu_compute_params params = {.shader = d->shader};
    bool has_pairs = d->shader != &shader_bvh_level_comp, has_boxes = d->shader != &shader_bvh_keys_comp;
    struct gpu_bvh_tree_push push = {.view = d->input.view, .list = d->header};
    if (has_pairs) {
        push.count = graph_address(context, d->in_view.sums) + d->input.local_count * 4ull;
        push.bounds = graph_address(context, d->in_view.bounds);
        push.pairs = graph_address(context, d->tree.pairs);
    }
    if (has_boxes) {
        push.boxes = graph_address(context, d->tree.boxes);
        push.first_out = d->tree.firsts[d->level];
        push.capacity_out = d->tree.counts[d->level];
    }
    if (has_boxes && has_pairs) push.spheres = graph_address(context, d->tree.spheres);
    if (!has_pairs) {
        push.first_in = d->tree.firsts[d->level - 1];
        push.capacity_in = d->tree.counts[d->level - 1];
    }
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_dispatch_linear(context->commands, DIVIDE_UP(d->threads, 64u));
}

/* Leaves, nodes, nodes 2 … */
static const char *level_name(struct graph *graph, const char *leaves, const char *nodes, uint32_t level) {
    return level ? graph_numbered_name(graph, nodes, level > 1 ? level : 0) : leaves;
}

struct bvh bvh_tree_add(struct graph *graph, const struct light_input *input, const struct lights_in_view *in_view,
                        VkDeviceAddress header) {
    uint32_t count = MAX(input->local_count, 1u), box_count = 0;
    struct tree_data data = {.input = *input, .in_view = *in_view, .header = header, .threads = count};
    struct bvh *tree = &data.tree;
    for (uint32_t nodes = DIVIDE_UP(count, BVH_WIDTH);; nodes = DIVIDE_UP(nodes, BVH_WIDTH)) {
        tree->firsts[tree->level_count] = box_count;
        tree->counts[tree->level_count++] = nodes;
        box_count += nodes;
        if (nodes <= BVH_WIDTH) break;
    }
    graph_buffer pairs = graph_create_buffer(graph, "bvh keys", count * 8ull);
    tree->pairs = pairs;
    data.shader = &shader_bvh_keys_comp;
    struct graph_pass *pass = graph_add_pass(graph, "bvh keys", input->queue, execute_tree, &data, sizeof data);
    graph_use_buffer(pass, in_view->sums, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, in_view->bounds, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, pairs, GRAPH_WRITE_COMPUTE);

    tree->pairs = radix_sort_add(graph, &(struct radix_sort_params){.what = "bvh",
                                                                    .queue = input->queue,
                                                                    .pairs = pairs,
                                                                    .capacity = count,
                                                                    .bits = BVH_KEY_BITS,
                                                                    .count = in_view->sums,
                                                                    .count_offset = input->local_count * 4ull});
    tree->spheres = graph_create_buffer(graph, "bvh spheres", count * sizeof(struct gpu_bound));
    tree->boxes = graph_create_buffer(graph, "bvh boxes", box_count * sizeof(struct gpu_bvh_box));
    for (data.level = 0; data.level < tree->level_count; data.level++) {
        data.shader = data.level == 0 ? &shader_bvh_leaves_comp : &shader_bvh_level_comp;
        data.threads = tree->counts[data.level];
        pass = graph_add_pass(graph, level_name(graph, "bvh leaves", "bvh nodes", data.level), input->queue, execute_tree, &data,
                              sizeof data);
        if (data.level == 0) {
            graph_use_buffer(pass, in_view->sums, GRAPH_READ_COMPUTE);
            graph_use_buffer(pass, in_view->bounds, GRAPH_READ_COMPUTE);
            graph_use_buffer(pass, tree->pairs, GRAPH_READ_COMPUTE);
            graph_use_buffer(pass, tree->spheres, GRAPH_WRITE_COMPUTE);
        }
        graph_use_buffer(pass, tree->boxes, data.level == 0 ? GRAPH_WRITE_COMPUTE : GRAPH_READ_WRITE_COMPUTE);
    }
    return *tree;
}

/* ---- queries ---- */

/* Masks of groups take at most this many words, and sums this many numbers, unless there are more cells than that. */
enum { MASKS_LIMIT = 1 << 23, SUMS_LIMIT = 1 << 20, SPARSE_SUMS_LIMIT = 1 << 18, SORT_GROUPS = 1 << 12 };
enum query_step { QUERY_GROUPS, QUERY_MASKS, QUERY_COUNT, QUERY_FILL, QUERY_SORT };

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
    uint32_t level;
    enum query_step step;
};

static VkDeviceAddress counter_address(const struct graph_context *context, const struct query_data *d) {
    if (!d->query.cell_counter.id) return 0;
    return graph_address(context, d->query.cell_counter) + d->query.cell_counter_offset;
}

static VkDeviceAddress count_address(const struct graph_context *context, const struct query_data *d) {
    return graph_address(context, d->in_view.sums) + d->input.local_count * 4ull;
}

static void execute_masks(const struct graph_context *context, const void *data) {
    const struct query_data *d = data;
    bool groups = d->step == QUERY_GROUPS;
    struct gpu_compute_params params = {.shader = groups ? &shader_bvh_groups_comp : &shader_bvh_mask_comp};
    struct gpu_bvh_mask_push push = {.list = d->query.header_address,
                                     .cell_counter = counter_address(context, d),
                                     .groups = graph_address(context, d->groups),
                                     .cell_count = d->query.cell_count,
                                     .rule = d->rule,
                                     .group_count = d->group_count};
    if (groups) {
        push.cells = graph_address(context, d->query.bounds);
    } else {
        bool top = d->level + 1 == d->tree.level_count;
        push.count = count_address(context, d);
        push.boxes = graph_address(context, d->tree.boxes);
        push.masks = graph_address(context, d->masks);
        push.first_node = d->tree.firsts[d->level];
        push.node_lights = BVH_WIDTH << (5 * d->level);
        push.first_mask = d->first_masks[d->level];
        push.words = d->words[d->level];
        push.first_parent = top ? 0 : d->first_masks[d->level + 1];
        push.parent_words = top ? 0 : d->words[d->level + 1];
    }
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_dispatch_linear(context->commands, DIVIDE_UP(groups ? d->group_count : d->group_count * push.words, 64u));
}

static bool uses_reaches(const struct bvh_query *query) { return query->cone_tests || query->facings.id; }

static void execute_query(const struct graph_context *context, const void *data) {
    const struct query_data *d = data;
    uint32_t fills = d->step == QUERY_FILL;
    struct gpu_compute_params params = {
        .shader = &shader_bvh_query_comp, .constant_count = 2, .constants = {GPU_LIST_ALL, fills}};
    struct gpu_bvh_query_push push = {.query = d->block,
                                      .list = d->query.header_address,
                                      .count = count_address(context, d),
                                      .cell_counter = counter_address(context, d),
                                      .cells = graph_address(context, d->query.bounds),
                                      .boxes = graph_address(context, d->tree.boxes),
                                      .masks = graph_address(context, d->masks) + d->first_masks[0] * 4ull,
                                      .spheres = graph_address(context, d->tree.spheres),
                                      .pairs = graph_address(context, d->tree.pairs),
                                      .visible_ids = graph_address(context, d->in_view.ids),
                                      .sums = graph_address(context, d->sums),
                                      .overflow = graph_address(context, d->overflow)};
    if (uses_reaches(&d->query)) push.reaches = graph_address(context, d->in_view.reaches);
    if (d->query.facings.id) push.facings = graph_address(context, d->query.facings);
    if (fills) {
        push.ids = graph_address(context, d->sort_steps % 2 ? d->unsorted : d->ids);
        if (d->query.header) {
            d->query.header->cells = graph_address(context, d->cells);
            d->query.header->ids = graph_address(context, d->ids);
            if (d->query.occupied && d->input.scattered) d->query.header->bounds = graph_address(context, d->query.bounds);
        }
    }
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_dispatch_linear(context->commands, DIVIDE_UP((d->query.cell_count + 1) * d->chunk_count, 64u));
}

static void execute_sort(const struct graph_context *context, const void *data) {
    const struct query_data *d = data;
    struct gpu_compute_params params = {.shader = &shader_bvh_sort_comp};
    bool odd = d->sort_steps % 2;
    VkDeviceAddress ids = graph_address(context, d->ids), unsorted = graph_address(context, d->unsorted);
    struct gpu_bvh_sort_push push = {.list = d->query.header_address,
                                     .cell_counter = counter_address(context, d),
                                     .first = odd ? unsorted : ids,
                                     .second = odd ? ids : unsorted,
                                     .target = ids,
                                     .cell_count = d->query.cell_count,
                                     .counted = d->query.cell_counter.id != 0,
                                     .steps = d->sort_steps};
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_dispatch_linear(context->commands, MIN(d->query.cell_count, (uint32_t)SORT_GROUPS));
}

static struct graph_pass *add_query_pass(struct graph *graph, const char *name, graph_execute *execute,
                                         const struct query_data *data) {
    struct graph_pass *pass = graph_add_pass(graph, name, data->input.queue, execute, data, sizeof *data);
    if (data->query.cell_counter.id) graph_use_buffer(pass, data->query.cell_counter, GRAPH_READ_COMPUTE);
    return pass;
}

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
    d->groups = graph_create_buffer(graph, graph_name(graph, "%s group boxes", what), d->group_count * sizeof(struct gpu_bvh_box));
    d->masks = graph_create_buffer(graph, graph_name(graph, "%s masks", what), mask_count * 4ull);
    d->step = QUERY_GROUPS;
    struct graph_pass *pass = add_query_pass(graph, graph_name(graph, "%s groups", what), execute_masks, d);
    graph_use_buffer(pass, d->query.bounds, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, d->groups, GRAPH_WRITE_COMPUTE);
    d->step = QUERY_MASKS;
    const char *leaves = graph_name(graph, "%s leaves touched", what), *nodes = graph_name(graph, "%s nodes touched", what);
    for (uint32_t l = d->tree.level_count; l-- > 0;) {
        d->level = l;
        pass = add_query_pass(graph, level_name(graph, leaves, nodes, l), execute_masks, d);
        graph_use_buffer(pass, d->in_view.sums, GRAPH_READ_COMPUTE);
        graph_use_buffer(pass, d->groups, GRAPH_READ_COMPUTE);
        graph_use_buffer(pass, d->tree.boxes, GRAPH_READ_COMPUTE);
        graph_use_buffer(pass, d->masks, l + 1 == d->tree.level_count ? GRAPH_WRITE_COMPUTE : GRAPH_READ_WRITE_COMPUTE);
    }
}

static void use_tree(struct graph_pass *pass, const struct query_data *d) {
    const graph_buffer buffers[] = {d->in_view.sums, d->in_view.ids,  d->tree.boxes, d->tree.spheres,
                                    d->tree.pairs,   d->query.bounds, d->masks,      d->query.facings};
    if (uses_reaches(&d->query)) graph_use_buffer(pass, d->in_view.reaches, GRAPH_READ_COMPUTE);
    for (uint32_t i = 0; i < COUNT_OF(buffers); i++)
        if (buffers[i].id) graph_use_buffer(pass, buffers[i], GRAPH_READ_COMPUTE);
    if (d->query.facings.id) graph_use_buffer(pass, d->input.buffer, GRAPH_READ_COMPUTE);
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
    while (input->local_count > 1ull << bits) bits++;
    data.sort_steps = DIVIDE_UP(bits, RADIX_BITS);

    data.sums = graph_create_buffer(graph, graph_name(graph, "%s sums", what), sum_count * 4ull);
    data.cells = graph_create_buffer(graph, graph_name(graph, "%s cells", what), query->cell_count * sizeof(struct gpu_cell));
    data.ids = graph_create_buffer(graph, graph_name(graph, "%s ids", what), MAX(query->pool_capacity, 1u) * 4ull);
    data.unsorted = graph_create_buffer(graph, graph_name(graph, "%s unsorted ids", what), MAX(query->pool_capacity, 1u) * 4ull);
    data.overflow = graph_create_buffer(graph, graph_name(graph, "%s overflow", what), 4);

    data.step = QUERY_COUNT;
    struct graph_pass *pass = add_query_pass(graph, graph_name(graph, "%s count", what), execute_query, &data);
    use_tree(pass, &data);
    graph_use_buffer(pass, data.sums, GRAPH_WRITE_COMPUTE);
    graph_use_buffer(pass, data.overflow, GRAPH_WRITE_COMPUTE);

    prefix_sum_add(graph, what, input->queue, data.sums, sum_count);

    data.step = QUERY_FILL;
    pass = add_query_pass(graph, graph_name(graph, "%s fill", what), execute_query, &data);
    use_tree(pass, &data);
    graph_use_buffer(pass, data.sums, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, data.overflow, GRAPH_READ_WRITE_COMPUTE);
    graph_use_buffer(pass, data.cells, GRAPH_WRITE_COMPUTE);
    graph_use_buffer(pass, data.sort_steps % 2 ? data.unsorted : data.ids, GRAPH_WRITE_COMPUTE);
    graph_use_buffer(pass, data.ids, GRAPH_WRITE_COMPUTE);

    data.step = QUERY_SORT;
    pass = add_query_pass(graph, graph_name(graph, "%s sort", what), execute_sort, &data);
    graph_use_buffer(pass, data.cells, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, data.ids, GRAPH_READ_WRITE_COMPUTE);
    graph_use_buffer(pass, data.unsorted, data.sort_steps % 2 ? GRAPH_READ_WRITE_COMPUTE : GRAPH_WRITE_COMPUTE);

    return (struct light_list){.lights = input->buffer,
                               .header = query->header_address,
                               .cells = data.cells,
                               .ids = data.ids,
                               .spare = light_spare_add(graph, what, input, in_view,
                                                        data.overflow, &query->header, &query->header_address, 1,
                                                        input->scattered && query->occupied),
                               .bounds = query->occupied && input->scattered ? query->bounds : (graph_buffer){0},
                               .cell_count = query->cell_count,
                               .byte_count = query->cell_count * sizeof(struct gpu_cell) + query->pool_capacity * 4ull,
                               .fixed_bytes = query->cell_count * sizeof(struct gpu_cell),
                               .entry_bytes = 4,
                               .totals = light_totals_add(graph, what, input,
                                                          in_view, data.sums, sum_count, data.overflow)};
}

/* ---- clusters ---- */

struct bounds_data {
    VkDeviceAddress view, header;
    graph_buffer bounds;
    uint32_t cell_count;
};

static void execute_bounds(const struct graph_context *context, const void *data) {
    const struct bounds_data *d = data;
    struct gpu_compute_params params = {.shader = &shader_clustered_bounds_comp};
    struct gpu_cells_push push = {
        .view = d->view, .list = d->header, .cells = graph_address(context, d->bounds), .cell_count = d->cell_count};
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_dispatch_linear(context->commands, DIVIDE_UP(d->cell_count, 64u));
}

struct light_list bvh_clusters_add(struct graph *graph, gpu_device *device, const struct light_input *input,
                                   const struct lights_in_view *in_view, const struct bvh *tree, const char *what,
                                   struct gpu_light_list *header, VkDeviceAddress header_address,
                                   const struct clustered_params *params) {
    struct bounds_data data = {.view = input->view,
                               .header = header_address,
                               .cell_count = header ? header->tiles_x * header->tiles_y * header->slices : 1};
    data.bounds = graph_create_buffer(graph, graph_name(graph, "%s cell bounds", what), data.cell_count * sizeof(struct gpu_cell_bounds));
    struct graph_pass *pass = graph_add_pass(graph, graph_name(graph, "%s bounds", what), input->queue, execute_bounds, &data, sizeof data);
    graph_use_buffer(pass, data.bounds, GRAPH_WRITE_COMPUTE);
    struct bvh_query query = {.what = what,
                              .bounds = data.bounds,
                              .cell_count = data.cell_count,
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
