/* SPDX-License-Identifier: MIT */
#include "passes/lights/fine.h"

#include "passes/geometry/prefix_sum.h"
#include "passes/lights/cells_shared.h"
#include "shaders.h"

/* Larger masks are made coarser, or left out; more marks get larger blocks. */
enum { MASK_BYTES = 256 << 20, MARK_BYTES = 64 << 20, BLOCK_PIXELS = 64 };

struct fine_params fine_params_default(void) {
    return (struct fine_params){
        .tile_size = 16, .pruning = true, .mask_size = 1, .exact_positions = true, .pool_capacity = 1u << 20};
}

struct step_data {
    struct light_input input;
    struct lights_in_view in_view;
    struct gpu_light_list *headers[FINE_LISTS];
    VkDeviceAddress header;
    graph_image depth, front;
    graph_buffer boxes, ranges, marks, found, sums, overflow, cells, ids, extra;
    uint32_t list_count, lists, block, tile_size, samples, capacity;
    const struct gpu_shader *shader;
    uint32_t groups[3]; /* [1] 0: [0] groups in a row */
};

static VkDeviceAddress address_of(const struct graph_context *context, graph_buffer buffer) {
    return buffer.id ? graph_address(context, buffer) : 0;
}

static void execute_step(const struct graph_context *context, const void *data) {
    const struct step_data *d = data;
    bool fills = d->shader == &shader_fine_fill_comp;
    struct gpu_fine_push push = {.view = d->input.view,
                                 .list = d->header,
                                 .visible_sums = address_of(context, d->in_view.sums),
                                 .visible_ids = address_of(context, d->in_view.ids),
                                 .bounds = address_of(context, d->in_view.bounds),
                                 .boxes = address_of(context, d->boxes),
                                 .ranges = address_of(context, d->ranges),
                                 .marks = address_of(context, d->marks),
                                 .found = address_of(context, d->found),
                                 .sums = address_of(context, d->sums),
                                 .overflow = address_of(context, d->overflow),
                                 .ids = address_of(context, d->ids),
                                 .extra = address_of(context, d->extra),
                                 .depth = d->depth.id ? graph_sampled(context, d->depth) : GPU_NO_DEPTH,
                                 .front = d->front.id ? graph_sampled(context, d->front) : GPU_NO_DEPTH,
                                 .capacity = d->capacity,
                                 .block = d->block,
                                 .lists = d->lists};
    for (uint32_t i = 0; fills && i < d->list_count; i++) {
        if (!d->headers[i]) continue;
        d->headers[i]->cells = graph_address(context, d->cells);
        d->headers[i]->ids = d->headers[i]->packed ? push.visible_ids : push.ids;
        d->headers[i]->extra = push.extra;
    }
    struct gpu_compute_params params = {
        .shader = d->shader, .constant_count = 3, .constants = {GPU_LIST_ALL, d->samples, d->tile_size}};
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    if (d->groups[1])
        gpu_dispatch(context->commands, d->groups[0], d->groups[1], d->groups[2]);
    else
        gpu_dispatch_linear(context->commands, d->groups[0]);
}

/* What a step reads and writes; the rest of the buffers is taken out of its data. */
static void add_step(struct graph *graph, const char *name, const struct gpu_shader *shader, const struct step_data *all,
                     uint32_t x, uint32_t y, uint32_t z) {
    bool bounds = shader == &shader_fine_bounds_comp, depths = shader == &shader_fine_depths_comp,
         marks = shader == &shader_fine_mark_comp, counts = shader == &shader_fine_count_comp,
         fills = shader == &shader_fine_fill_comp, walks = counts || fills;
    struct step_data data = *all;
    graph_buffer none = {0};
    data.shader = shader;
    data.groups[0] = x;
    data.groups[1] = y;
    data.groups[2] = z;
    if (depths) data.in_view = (struct lights_in_view){none, none, none, none};
    if (!bounds) data.in_view.bounds = none;
    if (marks) data.in_view.ids = none;
    if (depths) data.boxes = none;
    if (bounds) data.ranges = none;
    if (!marks && !walks) data.marks = none;
    if (!walks) data.found = data.sums = data.overflow = none;
    if (!fills) data.ids = data.cells = none;
    if (!fills && !depths) data.extra = none;
    if (!depths && !walks) data.depth.id = data.front.id = 0;

    struct graph_pass *pass = graph_add_pass(graph, name, all->input.queue, execute_step, &data, sizeof data);
    if (data.depth.id) graph_use_image(pass, data.depth, GRAPH_SAMPLE_COMPUTE);
    if (data.front.id) graph_use_image(pass, data.front, GRAPH_SAMPLE_COMPUTE);
    graph_use_buffer(pass, all->input.buffer, GRAPH_READ_COMPUTE);
    const struct {
        graph_buffer buffer;
        bool writes, reads;
    } uses[] = {{data.in_view.sums, false, true}, {data.in_view.ids, false, true}, {data.in_view.bounds, false, true},
                {data.boxes, bounds, !bounds},    {data.ranges, depths, !depths},  {data.marks, marks, !marks},
                {data.found, counts, fills},      {data.sums, counts, fills},      {data.overflow, true, fills},
                {data.ids, true, false}, /* and it reads back what it wrote */
                {data.cells, true, false},        {data.extra, true, false}};
    for (uint32_t i = 0; i < COUNT_OF(uses); i++) {
        if (!uses[i].buffer.id) continue;
        graph_use_buffer(pass, uses[i].buffer,
                         !uses[i].writes ? GRAPH_READ_COMPUTE
                         : uses[i].reads ? GRAPH_READ_WRITE_COMPUTE
                                         : GRAPH_WRITE_COMPUTE);
    }
}

/* How large the squares are that share a mask. */
static uint32_t mask_size_of(const struct fine_params *params, uint32_t cell_count) {
    uint32_t size = params->pruning && !params->packed ? params->mask_size : 0;
    if (size > params->tile_size / 8) size = params->tile_size / 8; /* no more than what a thread owns */
    for (; size && size <= 2; size *= 2) {
        uint64_t side = params->tile_size / size;
        if ((params->pool_capacity / 32ull + cell_count) * side * side * 4 <= MASK_BYTES && size <= params->tile_size / 8)
            return size;
    }
    return 0;
}

struct fine_lists fine_add(struct graph *graph, gpu_device *device, const struct light_input *input,
                           const struct lights_in_view *in_view, graph_image depth, const struct fine_params *params) {
    uint32_t tiles_x = DIVIDE_UP(input->width, params->tile_size), tiles_y = DIVIDE_UP(input->height, params->tile_size),
             tile_count = tiles_x * tiles_y, words = MAX(DIVIDE_UP(input->local_count, 32u), 1u);
    struct step_data all = {.input = *input,
                            .in_view = *in_view,
                            .depth = depth,
                            .block = MAX(BLOCK_PIXELS / params->tile_size, 1u),
                            .tile_size = params->tile_size,
                            .samples = depth.id ? MAX(graph_image_info(graph, depth).samples, 1u) : 1,
                            .capacity = params->pool_capacity};

    /* The lists: of opaque surfaces; of blended ones, and of those that MSAA shades elsewhere; of probes. */
    bool prunes = depth.id && params->pruning, several = all.samples > 1;
    uint32_t solid = depth.id ? FINE_MIN_DEPTH | FINE_MAX_DEPTH | (prunes ? FINE_PIXELS : 0) : 0;
    uint32_t flags[FINE_LISTS] = {solid}, blend = 0, probes = 0;
    all.list_count = 1;
    if (depth.id && (params->blend || several)) {
        blend = all.list_count++;
        flags[blend] = several ? 0 : FINE_MAX_DEPTH;
        if (params->blend_depth.id && !several) {
            all.front = params->blend_depth;
            flags[blend] = solid | FINE_BLENDED;
        }
    }
    if (params->probes) {
        probes = all.list_count++;
        flags[probes] = solid | GPU_ENTITY_PROBE << FINE_ENTITY_SHIFT;
    }
    for (uint32_t i = 0; i < all.list_count; i++) all.lists |= flags[i] << i * 8;

    struct fine_params masked = *params;
    masked.pruning = prunes;
    uint32_t cell_count = tile_count * all.list_count;
    uint32_t mask_size = mask_size_of(&masked, cell_count), side = mask_size ? params->tile_size / mask_size : 0;
    bool compares = !params->exact_positions && (prunes || several);
    uint32_t pool = params->packed ? 0 : params->pool_capacity,
             cell_bytes = params->packed ? GPU_PACKED_WORDS * 4 : sizeof(struct gpu_cell);
    uint64_t mask_words = MAX((pool / 32ull + cell_count) * side * side, 1u),
             position_words = compares ? (uint64_t)tile_count * params->tile_size * params->tile_size * 3 : 0;

    VkDeviceAddress addresses[FINE_LISTS] = {0};
    for (uint32_t i = 0; i < all.list_count; i++) {
        struct gpu_light_list *header = all.headers[i] = light_list_header(device, input, &addresses[i]);
        if (!header) continue;
        header->tile_size = params->tile_size;
        header->tiles_x = tiles_x;
        header->tiles_y = tiles_y;
        header->first_cell = i * tile_count;
        header->other_cell = several && (i == 0 || i != probes) ? blend * tile_count : GPU_CELL_ALL;
        header->mask_size = flags[i] & FINE_PIXELS ? mask_size : 0;
        header->positions = compares && (i == 0 || i != blend) ? (uint32_t)mask_words : 0;
        header->eye_distance = params->eye_distance;
        header->packed = params->packed;
    }
    all.header = addresses[0];

    uint64_t block_bytes;
    for (;; all.block *= 2) {
        block_bytes = (uint64_t)DIVIDE_UP(tiles_x, all.block) * DIVIDE_UP(tiles_y, all.block) * all.list_count * words * 4;
        if (block_bytes <= MARK_BYTES || all.block >= MAX(tiles_x, tiles_y)) break;
    }
    uint32_t visible = MAX(input->local_count, 1u);
    all.boxes = graph_create_buffer(graph, "fine boxes", visible * sizeof(struct gpu_fine_box));
    if (depth.id)
        all.ranges =
            graph_create_buffer(graph, "fine ranges", tile_count * (all.front.id ? 2 : 1) * sizeof(struct gpu_fine_range));
    all.marks = graph_create_buffer(graph, "fine marks", block_bytes);
    all.found = graph_create_buffer(graph, "fine found", (uint64_t)cell_count * (FINE_FOUND + side * side) * 4);
    all.sums = graph_create_buffer(graph, "fine sums", (cell_count + 1) * 4ull);
    all.overflow = graph_create_buffer(graph, "fine overflow", 4);
    all.cells = graph_create_buffer(graph, "fine cells", (uint64_t)cell_count * cell_bytes);
    if (!params->packed) all.ids = graph_create_buffer(graph, "fine ids", MAX(pool, 1u) * 4ull);
    all.extra = graph_create_buffer(graph, "fine masks", (mask_words + position_words) * 4);

    add_step(graph, "fine bounds", &shader_fine_bounds_comp, &all, DIVIDE_UP(visible, 64u), 0, 0);
    if (depth.id) add_step(graph, "fine depths", &shader_fine_depths_comp, &all, tiles_x, tiles_y, 1);
    add_step(graph, "fine mark", &shader_fine_mark_comp, &all, DIVIDE_UP(words, 64u),
             DIVIDE_UP(tiles_x, all.block) * DIVIDE_UP(tiles_y, all.block), all.list_count);
    add_step(graph, "fine count", &shader_fine_count_comp, &all, tiles_x, tiles_y, all.list_count);
    prefix_sum_add(graph, "fine", input->queue, all.sums, cell_count + 1);
    add_step(graph, "fine fill", &shader_fine_fill_comp, &all, tiles_x, tiles_y, all.list_count);
    graph_buffer totals = light_totals_add(graph, "fine", &all.input, &all.in_view, all.sums,
                                           cell_count + 1, all.overflow);

    struct fine_lists lists = {.boxes = all.boxes};
    lists.lights = (struct light_list){.kind = GPU_LIST_FINE,
                                       .lights = input->buffer,
                                       .header = addresses[0],
                                       .cells = all.cells,
                                       .ids = params->packed ? in_view->ids : all.ids,
                                       .extra = all.extra,
                                       .spare = light_spare_add(graph, "fine", &all.input,
                                                                &all.in_view, all.overflow, all.headers, addresses,
                                                                all.list_count, false),
                                       .cell_count = cell_count,
                                       .entry_bytes = params->packed ? 0 : 4 + side * side / 8,
                                       .totals = totals};
    lists.lights.fixed_bytes =
        (uint64_t)cell_count * cell_bytes + (uint64_t)cell_count * side * side * 4 + position_words * 4;
    lists.lights.byte_count =
        (uint64_t)cell_count * cell_bytes + pool * 4ull + (side ? mask_words : 0) * 4 + position_words * 4;
    /* The others lie in the same buffers, which are counted once. */
    struct light_list other = lists.lights;
    other.cell_count = other.entry_bytes = 0;
    other.byte_count = other.fixed_bytes = 0;
    if (blend) {
        lists.blend = other;
        lists.blend.header = addresses[blend];
    }
    if (probes) {
        lists.probes = other;
        lists.probes.header = addresses[probes];
    }
    return lists;
}
