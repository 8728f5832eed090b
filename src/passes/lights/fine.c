/* SPDX-License-Identifier: MIT */
#include "passes/lights/fine.h"

#include "passes/geometry/prefix_sum.h"
#include "passes/lights/cells_shared.h"
#include "shaders.h"

/* Larger masks are made coarser, or left out; more marks get larger blocks. */
enum { MASK_BYTES = 256 << 20, MARK_BYTES = 64 << 20, BLOCK_PIXELS = 64 };
/* Of masks the count keeps up to so many words for each square of pixels, fewer where all would take more than this. */
enum { KEPT_WORDS = 16, KEPT_BYTES = 128 << 20 };

struct fine_params fine_params_default(void) {
    return (struct fine_params){
        .tile_size = 16, .group_side = 16, .pruning = true, .mask_size = 1, .exact_positions = true, .pool_capacity = 1u << 20};
}

struct fine_data {
    graph_image depth, front;
    graph_buffer boxes, volumes, ranges, marks, found, sums, overflow, cells, ids, extra;
    uint32_t tiles_x, tiles_y, cell_count, block, samples, kept_words;
    uint32_t list_count, lists, flags[FINE_LISTS]; /* `lists`: the flags of all, a byte each */
    uint32_t blend, others[GPU_ENTITY_KINDS];      /* which of the lists; 0: none of its own */
};

/* How large the squares are that share a mask. */
static uint32_t mask_size_of(const struct fine_params *params, uint32_t cell_count) {
    uint32_t size = params->pruning && !params->packed ? params->mask_size : 0;
    if (size > params->tile_size / 8) size = params->tile_size / 8; /* no more than 8 x 8 squares at least */
    for (; size && size <= 2; size *= 2) {
        uint64_t side = params->tile_size / size;
        if ((params->pool_capacity / 32ull + cell_count) * side * side * 4 <= MASK_BYTES && size <= params->tile_size / 8)
            return size;
    }
    return 0;
}

/* The lists: of opaque surfaces; of blended ones, and of those that MSAA shades elsewhere; of other kinds. */
static void choose_lists(struct fine_data *all, const struct light_input *input, const struct fine_params *params,
                         bool prunes) {
    const bool several = all->samples > 1;
    const uint32_t solid = all->depth.id ? FINE_MIN_DEPTH | FINE_MAX_DEPTH | (prunes ? FINE_PIXELS : 0) : 0;
    uint32_t kind = 0;
    while (kind + 1 < GPU_ENTITY_KINDS && !(input->kinds >> kind & 1)) kind++;
    all->flags[0] = solid | kind << FINE_KIND_SHIFT;
    all->list_count = 1;
    if (all->depth.id && (params->blend || several)) {
        all->blend = all->list_count++;
        all->flags[all->blend] = (several ? 0 : FINE_MAX_DEPTH) | kind << FINE_KIND_SHIFT;
        if (params->blend_depth.id && !several) {
            all->front = params->blend_depth;
            all->flags[all->blend] = all->flags[0] | FINE_BLENDED;
        }
    }
    for (uint32_t other = kind + 1; other < GPU_ENTITY_KINDS; other++)
        if (input->kinds >> other & 1) {
            all->others[other] = all->list_count++;
            all->flags[all->others[other]] = solid | other << FINE_KIND_SHIFT;
        }
    for (uint32_t i = 0; i < all->list_count; i++) all->lists |= all->flags[i] << i * 8;
}

static uint32_t light_words(const struct light_input *input) { return MAX(DIVIDE_UP(input->set.local_count, 32u), 1u); }

static uint32_t block_count(const struct fine_data *all) {
    return DIVIDE_UP(all->tiles_x, all->block) * DIVIDE_UP(all->tiles_y, all->block);
}

static void add_steps(struct graph *graph, const struct light_input *input, const struct lights_in_view *in_view,
                      const struct fine_params *params, const struct fine_data *all, VkDeviceAddress list) {
    const struct gpu_fine_push common = {.view = input->view,
                                         .list = list,
                                         .depth = GPU_NO_DEPTH,
                                         .front = GPU_NO_DEPTH,
                                         .capacity = params->pool_capacity,
                                         .block = all->block,
                                         .lists = all->lists};
    struct gpu_fine_push push = common;
    const uint32_t list_bits = input->set.simple && input->kinds == 1u << GPU_ENTITY_LIGHT ? GPU_LIST_ALL | GPU_LIGHTING_SIMPLE : GPU_LIST_ALL;
    const uint32_t group_side = MIN(params->tile_size, params->group_side);
    const uint32_t blocks = block_count(all);
#define STEP(name_, shader_, ...)                                                                                           \
    .name = name_, .queue = input->queue,                                                                                   \
    .pipeline = {&shader_, 6,                                                                                               \
                 {list_bits, all->samples, params->tile_size, group_side, all->front.id != 0, all->kept_words}},            \
    .groups = {__VA_ARGS__}
#define ADD_STEP(step, ...)                                                                                                 \
    push = common;                                                                                                          \
    graph_dispatch(                                                                                                         \
        graph, &(struct graph_dispatch){step, GRAPH_PUSH(push), GRAPH_ROWS(graph_reads(NULL, input->set.buffer), __VA_ARGS__)})
#define DEPTHS                                                                                                              \
    graph_row_if(all->depth.id, graph_samples(&push.depth, all->depth)),                                                    \
        graph_row_if(all->front.id, graph_samples(&push.front, all->front))
#define RANGES graph_row_if(all->ranges.id, graph_reads(&push.ranges, all->ranges))
    ADD_STEP(STEP("fine bounds", shader_fine_bounds_comp, DIVIDE_UP(MAX(input->set.local_count, 1u), 64u)),
             graph_reads(&push.visible_sums, in_view->sums), graph_reads(&push.visible_ids, in_view->ids),
             graph_reads(&push.bounds, in_view->bounds), graph_writes(&push.boxes, all->boxes), graph_writes(&push.extra, all->volumes));
    if (all->depth.id) {
        ADD_STEP(STEP("fine depths", shader_fine_depths_comp, all->tiles_x, all->tiles_y, 1), DEPTHS,
                 graph_writes(&push.ranges, all->ranges), graph_writes(&push.extra, all->extra));
    }
    ADD_STEP(STEP("fine mark", shader_fine_mark_comp, DIVIDE_UP(light_words(input), 64u), blocks, all->list_count),
             graph_reads(&push.visible_sums, in_view->sums), graph_reads(&push.boxes, all->boxes), RANGES,
             graph_writes(&push.marks, all->marks));
    ADD_STEP(STEP("fine count", shader_fine_count_comp, all->tiles_x, all->tiles_y, all->list_count), DEPTHS,
             graph_reads(&push.visible_sums, in_view->sums), graph_reads(&push.visible_ids, in_view->ids),
             graph_reads(&push.bounds, all->volumes), graph_reads(&push.boxes, all->boxes), RANGES, graph_reads(&push.marks, all->marks),
             graph_writes(&push.found, all->found), graph_writes(&push.sums, all->sums),
             graph_writes(&push.overflow, all->overflow));
    prefix_sum_add(graph, "fine", input->queue, all->sums, all->cell_count + 1);
    ADD_STEP(STEP("fine fill", shader_fine_fill_comp, all->tiles_x, all->tiles_y, all->list_count), DEPTHS,
             graph_reads(&push.visible_sums, in_view->sums), graph_reads(&push.visible_ids, in_view->ids),
             graph_reads(&push.bounds, all->volumes), graph_reads(&push.boxes, all->boxes), RANGES, graph_reads(&push.marks, all->marks),
             graph_reads(&push.found, all->found), graph_reads(&push.sums, all->sums),
             graph_changes(&push.overflow, all->overflow), graph_writes(NULL, all->cells),
             graph_row_if(all->ids.id, graph_writes(&push.ids, all->ids)), /* and it reads back what it wrote */
             graph_writes(&push.extra, all->extra));
#undef RANGES
#undef DEPTHS
#undef ADD_STEP
#undef STEP
}

struct fine_lists fine_add(struct graph *graph, gpu_device *device, const struct light_input *input,
                           const struct lights_in_view *in_view, graph_image depth, const struct fine_params *params) {
    uint32_t tiles_x = DIVIDE_UP(input->width, params->tile_size), tiles_y = DIVIDE_UP(input->height, params->tile_size),
             tile_count = tiles_x * tiles_y;
    struct fine_data all = {.depth = depth,
                            .tiles_x = tiles_x,
                            .tiles_y = tiles_y,
                            .block = MAX(BLOCK_PIXELS / params->tile_size, 1u),
                            .samples = depth.id ? MAX(graph_image_info(graph, depth).samples, 1u) : 1};

    bool prunes = depth.id && params->pruning, several = all.samples > 1;
    choose_lists(&all, input, params, prunes);
    struct fine_params masked = *params;
    masked.pruning = prunes;
    uint32_t cell_count = all.cell_count = tile_count * all.list_count;
    uint32_t mask_size = mask_size_of(&masked, cell_count), side = mask_size ? params->tile_size / mask_size : 0;
    if (side) all.kept_words = (uint32_t)CLAMP(KEPT_BYTES / ((uint64_t)cell_count * side * side * 4), 1u, (uint64_t)KEPT_WORDS);
    const uint32_t found_words = FINE_FOUND_WORDS(MAX(all.kept_words * 32, FINE_FOUND), all.kept_words, side * side);
    bool compares = !params->exact_positions && (prunes || several);
    uint32_t pool = params->packed ? 0 : params->pool_capacity,
             cell_bytes = params->packed ? GPU_PACKED_WORDS * 4 : sizeof(struct gpu_cell);
    uint64_t mask_words = MAX((pool / 32ull + cell_count) * side * side, 1u),
             position_words = compares ? (uint64_t)tile_count * params->tile_size * params->tile_size * 3 : 0;

    VkDeviceAddress addresses[FINE_LISTS] = {0};
    struct gpu_light_list *headers[FINE_LISTS] = {0};
    for (uint32_t i = 0; i < all.list_count; i++) {
        struct gpu_light_list *header = headers[i] = light_list_header(device, input, &addresses[i]);
        if (!header) continue;
        header->tile_size = params->tile_size;
        header->tiles_x = tiles_x;
        header->tiles_y = tiles_y;
        header->first_cell = i * tile_count;
        header->other_cell = several && (i == 0 || i == all.blend) ? all.blend * tile_count : GPU_CELL_ALL;
        header->mask_size = all.flags[i] & FINE_PIXELS ? mask_size : 0;
        header->positions = compares && (i == 0 || i != all.blend) ? (uint32_t)mask_words : 0;
        header->eye_distance = params->eye_distance;
        header->packed = params->packed;
    }

    uint64_t block_bytes;
    for (;; all.block *= 2) {
        block_bytes = (uint64_t)block_count(&all) * all.list_count * light_words(input) * 4;
        if (block_bytes <= MARK_BYTES || all.block >= MAX(tiles_x, tiles_y)) break;
    }
    all.boxes = graph_create_buffer(graph, "fine boxes", MAX(input->set.local_count, 1u) * sizeof(struct gpu_fine_box));
    all.volumes = graph_create_buffer(graph, "fine volumes", MAX(input->set.local_count, 1u) * sizeof(struct gpu_fine_volume));
    if (depth.id)
        all.ranges =
            graph_create_buffer(graph, "fine ranges", tile_count * (all.front.id ? 2 : 1) * sizeof(struct gpu_fine_range));
    all.marks = graph_create_buffer(graph, "fine marks", block_bytes);
    all.found = graph_create_buffer(graph, "fine found", cell_count * (found_words * 4ull));
    all.sums = graph_create_buffer(graph, "fine sums", (cell_count + 1) * 4ull);
    all.overflow = graph_create_buffer(graph, "fine overflow", 4);
    all.cells = graph_create_buffer(graph, "fine cells", (uint64_t)cell_count * cell_bytes);
    if (!params->packed) all.ids = graph_create_buffer(graph, "fine ids", MAX(pool, 1u) * 4ull);
    all.extra = graph_create_buffer(graph, "fine masks", (mask_words + position_words) * 4);

    for (uint32_t i = 0; i < all.list_count; i++) {
        if (!headers[i]) continue;
        graph_put_address(graph, &headers[i]->cells, all.cells);
        graph_put_address(graph, &headers[i]->ids, params->packed ? in_view->ids : all.ids);
        graph_put_address(graph, &headers[i]->extra, all.extra);
    }

    add_steps(graph, input, in_view, params, &all, addresses[0]);
    graph_buffer totals = light_totals_add(graph, "fine", input, in_view, all.sums, cell_count + 1, all.overflow);

    struct fine_lists lists = {.boxes = all.boxes};
    lists.lights = (struct light_list){
        .kind = GPU_LIST_FINE,
        .lights = input->set.buffer,
        .header = addresses[0],
        .cells = all.cells,
        .ids = params->packed ? in_view->ids : all.ids,
        .extra = all.extra,
        .spare = light_spare_add(graph, "fine", input, in_view, all.overflow, headers, addresses, all.list_count, false),
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
    if (all.blend) {
        lists.blend = other;
        lists.blend.header = addresses[all.blend];
    }
    for (uint32_t k = 0; k < GPU_ENTITY_KINDS; k++)
        if (all.others[k]) {
            lists.others[k] = other;
            lists.others[k].header = addresses[all.others[k]];
        }
    return lists;
}
