/* SPDX-License-Identifier: MIT */
#include "passes/lights/raster.h"

#include "passes/geometry/prefix_sum.h"
#include "passes/lights/clustered.h"
#include "passes/lights/raster_mesh.h"
#include "shaders.h"

enum { MAX_SUMS = 1 << 24, CHUNK = 4096, SLOTS_START = 1 << 18 };
enum { ARGUMENT_BYTES = 32, DRAW_OFFSET = 12, DRAW_INDICES = 3 * GPU_CONE_TRIANGLES };

struct raster_params raster_params_default(void) {
    return (struct raster_params){
        .grid = clustered_params_default(), .nodes = GPU_NODES_ARRAY, .slot_capacity = SLOTS_START};
}

/* ---- what it takes ---- */

/* 32-bit nodes hold 4096 lights and 2^20 - 1 links. */
uint32_t raster_nodes(const struct raster_params *params, uint32_t light_count) {
    bool fits = light_count <= GPU_NODE_32_LIGHTS && params->grid.pool_capacity <= GPU_NODE_32_END + 1;
    return params->nodes == GPU_NODES_32 && !fits ? GPU_NODES_64 : params->nodes;
}

static uint32_t pool_capacity(const struct raster_params *params, uint32_t nodes) {
    uint32_t capacity = MAX(params->grid.pool_capacity, 1u);
    return nodes == GPU_NODES_32 ? MIN(capacity, GPU_NODE_32_END) : capacity;
}

static uint32_t entry_bytes(uint32_t nodes) { return nodes == GPU_NODES_64 ? 8 : 4; }
static uint32_t cell_bytes(uint32_t nodes) { return nodes == GPU_NODES_ARRAY ? sizeof(struct gpu_cell) : 4; }

struct raster_memory raster_memory(const struct raster_params *params, uint32_t width, uint32_t height,
                                   uint32_t light_count) {
    uint32_t nodes = raster_nodes(params, light_count);
    uint64_t cells =
        (uint64_t)DIVIDE_UP(width, params->grid.tile_size) * DIVIDE_UP(height, params->grid.tile_size) * params->grid.slices;
    return (struct raster_memory){.offsets = cells * cell_bytes(nodes),
                                  .list = (uint64_t)pool_capacity(params, nodes) * entry_bytes(nodes),
                                  .shells = (uint64_t)params->slot_capacity * sizeof(struct gpu_raster_slot)};
}

/* ---- passes ---- */

struct raster_data {
    struct light_input input;
    struct lights_in_view in_view;
    struct gpu_raster *block;
    VkDeviceAddress block_address;
    struct gpu_light_list *header;
    graph_buffer lights, slot_sums, slots, arguments, sums, cells, ids, overflow;
    struct gpu_slice indices; /* of the draw */
    uint32_t cell_count, chunk_count, tile_count, nodes;
    bool centers;
};

/* All resources are in the block: rows have no members. */
#define ADD_STEP(name_, shader_, size_, ...)                                                                                \
    graph_dispatch(graph, &(struct graph_dispatch){.name = name_,                                                           \
                                                   .queue = d->input.queue,                                                 \
                                                   .pipeline = {&shader_, 2, {GPU_LIST_CLUSTERS, d->nodes}},                \
                                                   size_,                                                                   \
                                                   GRAPH_PUSH(push),                                                        \
                                                   GRAPH_ROWS(__VA_ARGS__)})
#define READS(field) graph_reads(NULL, d->field)
#define WRITES(field) graph_writes(NULL, d->field)
#define SHELLS READS(in_view.bounds), READS(in_view.sums), READS(lights), READS(slot_sums), READS(slots)

static void execute_draw(const struct graph_context *context, const void *data) {
    const struct raster_data *d = data;
    struct gpu_graphics_params params = {.vertex = &shader_raster_draw_vert,
                                         .fragment = &shader_raster_draw_frag,
                                         .constant_count = 1,
                                         .constants = {GPU_LIST_CLUSTERS},
                                         .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST,
                                         .cull = VK_CULL_MODE_NONE,
                                         .depth_clamp = true, /* nothing is cut off at the near and far planes */
                                         .conservative = !d->centers,
                                         .samples = 1};
    struct gpu_rendering rendering = {.width = d->header->tiles_x, .height = d->header->tiles_y};
    struct gpu_raster_push push = {d->block_address};
    gpu_begin_rendering(context->commands, &rendering);
    gpu_bind(context->commands, gpu_graphics_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_bind_indices(context->commands, d->indices.buffer, d->indices.offset);
    gpu_draw_indexed_indirect(context->commands, graph_get_buffer(context, d->arguments), DRAW_OFFSET, 1);
    gpu_end_rendering(context->commands);
}

/* ---- the list ---- */

static void put_addresses(struct graph *graph, const struct raster_data *d) {
    graph_put_address(graph, &d->block->visible_sums, d->in_view.sums);
    graph_put_address(graph, &d->block->visible_ids, d->in_view.ids);
    graph_put_address(graph, &d->block->bounds, d->in_view.bounds);
    graph_put_address(graph, &d->block->lights, d->lights);
    graph_put_address(graph, &d->block->slot_sums, d->slot_sums);
    graph_put_address(graph, &d->block->arguments, d->arguments);
    graph_put_address(graph, &d->block->slots, d->slots);
    graph_put_address(graph, &d->block->sums, d->sums);
    graph_put_address(graph, &d->block->overflow, d->overflow);
    graph_put_address(graph, &d->block->cells, d->cells);
    graph_put_address(graph, &d->block->ids, d->ids);
    graph_put_address(graph, &d->header->cells, d->cells);
    graph_put_address(graph, &d->header->ids, d->ids);
}

static void add_draw(struct graph *graph, const struct raster_data *d) {
    graph_add_clear(graph, "raster clear", GRAPH_QUEUE_GRAPHICS,
                    (struct graph_clear){.buffers = {d->slots}, .word = RASTER_UNSET});
    struct graph_pass *pass = graph_add_pass(graph, "raster draw", GRAPH_QUEUE_GRAPHICS, execute_draw, d, sizeof *d);
    graph_use_buffer(pass, d->input.set.buffer, GRAPH_READ_GRAPHICS);
    graph_use_buffer(pass, d->in_view.ids, GRAPH_READ_GRAPHICS);
    graph_use_buffer(pass, d->in_view.bounds, GRAPH_READ_GRAPHICS);
    graph_use_buffer(pass, d->lights, GRAPH_READ_GRAPHICS);
    graph_use_buffer(pass, d->slot_sums, GRAPH_READ_GRAPHICS);
    graph_use_buffer(pass, d->arguments, GRAPH_INDIRECT);
    graph_use_buffer(pass, d->slots, GRAPH_READ_WRITE_FRAGMENT);
}

static struct gpu_raster *make_block(gpu_device *device, const struct light_input *input, const struct raster_params *params,
                                     VkDeviceAddress *out_address) {
    struct gpu_slice slice = gpu_frame_allocate(device, sizeof(struct gpu_raster));
    struct gpu_raster *block = slice.data;
    *out_address = slice.address;
    if (!block) return NULL;
    *block = (struct gpu_raster){.view = input->view,
                                 .meshes = params->meshes,
                                 .points = params->points,
                                 .light_count = input->set.local_count,
                                 .slot_capacity = params->slot_capacity,
                                 .gradient = params->gradient,
                                 .own_meshes = params->meshes != 0,
                                 .near = params->near * 0.5f};
    raster_mesh_tables(block->vertices, block->triangles);
    return block;
}

static bool make_indices(gpu_device *device, struct raster_data *d) {
    d->indices = gpu_frame_allocate(device, DRAW_INDICES * 4);
    if (!d->indices.data) return false;
    for (uint32_t i = 0; i < DRAW_INDICES; i++) ((uint32_t *)d->indices.data)[i] = i;
    return true;
}

bool raster_on_hardware(const gpu_device *device, const struct raster_params *params) {
    if (params->path == RASTER_PATH_SOFTWARE || params->meshes || params->gradient) return false;
    return params->centers || gpu_info(device)->conservative_raster;
}

static void add_steps(struct graph *graph, const struct raster_data *d, uint32_t sum_count, bool draws) {
    const struct gpu_raster_push push = {d->block_address};
    const uint32_t light_count = d->input.set.local_count, walks = d->tile_count * d->chunk_count;
    ADD_STEP("raster rectangles", shader_raster_rects_comp, .groups = {DIVIDE_UP(light_count + 1, 64u)}, READS(input.set.buffer),
             READS(in_view.sums), READS(in_view.ids), READS(in_view.bounds), WRITES(lights), WRITES(slot_sums),
             WRITES(arguments));
    prefix_sum_add(graph, "raster slots", d->input.queue, d->slot_sums, light_count + 1);
    d->block->draws = draws;
    if (draws) add_draw(graph, d);
    ADD_STEP("raster shell", shader_raster_shell_comp, .indirect = d->arguments, READS(input.set.buffer), READS(in_view.sums),
             READS(in_view.ids), READS(in_view.bounds), READS(lights), READS(slot_sums),
             draws ? graph_changes(NULL, d->slots) : WRITES(slots));
    ADD_STEP("raster count", shader_raster_count_comp, .groups = {walks}, SHELLS, WRITES(sums), WRITES(overflow));
    prefix_sum_add(graph, "raster cells", d->input.queue, d->sums, sum_count);
    ADD_STEP("raster fill", shader_raster_fill_comp, .groups = {walks}, SHELLS, READS(in_view.ids), READS(input.set.buffer),
             READS(sums), graph_changes(NULL, d->overflow), WRITES(cells), WRITES(ids));
}

struct raster_list raster_add(struct graph *graph, gpu_device *device, const struct light_input *input,
                              const struct lights_in_view *in_view, const struct raster_params *params) {
    struct raster_data d = {.input = *input, .in_view = *in_view};
    struct raster_list out = {.list = {.kind = GPU_LIST_CLUSTERS, .lights = input->set.buffer}};
    d.nodes = raster_nodes(params, input->set.local_count);
    d.header = light_list_header(device, input, &out.list.header);
    d.block = make_block(device, input, params, &d.block_address);
    if (!d.header || !d.block) { /* the device carries a sticky error: the frame ends in it */
        out.list.totals_known = true;
        out.list.kind = GPU_LIST_ALL;
        return out;
    }
    clustered_grid(d.header, input->width, input->height, &params->grid);
    d.header->nodes = d.nodes;
    d.tile_count = d.header->tiles_x * d.header->tiles_y;
    d.cell_count = d.tile_count * d.header->slices;
    uint32_t chunk_size = CHUNK;
    while (DIVIDE_UP(input->set.local_count, chunk_size) > 1 &&
           (uint64_t)d.cell_count * DIVIDE_UP(input->set.local_count, chunk_size) > MAX_SUMS)
        chunk_size *= 2;
    d.chunk_count = MAX(DIVIDE_UP(input->set.local_count, chunk_size), 1u);
    uint32_t capacity = pool_capacity(params, d.nodes), sum_count = d.cell_count * d.chunk_count + 1;
    d.block->list = out.list.header;
    d.block->cell_count = d.cell_count;
    d.block->chunk_size = chunk_size;
    d.block->chunk_count = d.chunk_count;
    d.block->capacity = capacity;

    uint64_t lights = MAX(input->set.local_count, 1u);
    d.lights = graph_create_buffer(graph, "raster rectangles", lights * sizeof(struct gpu_raster_light));
    d.slot_sums = graph_create_buffer(graph, "raster slot sums", (input->set.local_count + 1) * 4ull);
    d.arguments = graph_create_buffer(graph, "raster arguments", ARGUMENT_BYTES);
    d.slots = graph_create_buffer(graph, "raster slots", MAX(params->slot_capacity, 1u) * sizeof(struct gpu_raster_slot));
    d.sums = graph_create_buffer(graph, "raster sums", sum_count * 4ull);
    d.cells = graph_create_buffer(graph, "raster cells", (uint64_t)d.cell_count * cell_bytes(d.nodes));
    d.ids = graph_create_buffer(graph, "raster ids", (uint64_t)capacity * entry_bytes(d.nodes));
    d.overflow = graph_create_buffer(graph, "raster overflow", 4);

    put_addresses(graph, &d);

    bool draws = raster_on_hardware(device, params) && make_indices(device, &d);
    d.centers = params->centers;
    add_steps(graph, &d, sum_count, draws);

    struct raster_memory memory = raster_memory(params, input->width, input->height, input->set.local_count);
    out.list.kind = d.nodes == GPU_NODES_ARRAY ? GPU_LIST_CLUSTERS : GPU_LIST_LINKS;
    out.list.cells = d.cells;
    out.list.ids = d.ids;
    out.list.cell_count = d.cell_count;
    out.list.byte_count = memory.offsets + memory.list;
    out.list.fixed_bytes = memory.offsets;
    out.list.entry_bytes = entry_bytes(d.nodes);
    out.list.totals = light_totals_add(graph, "raster", input, in_view, d.sums, sum_count, d.overflow);
    out.list.spare = light_spare_add(graph, "raster", input, in_view, d.overflow, &d.header, &out.list.header, 1, false);
    out.slots = d.slots;
    out.slot_sums = d.slot_sums;
    out.rectangles = d.lights;
    out.slot_total_offset = input->set.local_count * 4ull;
    return out;
}

/* ---- from frame to frame ---- */

void raster_state_finish(struct raster_state *state, gpu_device *device) {
    for (uint32_t i = 0; i < GPU_FRAMES_IN_FLIGHT; i++) gpu_buffer_destroy(device, &state->wanted[i]);
}

struct wanted_data {
    graph_buffer sums, wanted;
    uint64_t offset;
};

static void execute_wanted(const struct graph_context *context, const void *data) {
    const struct wanted_data *d = data;
    gpu_copy_buffer(context->commands, graph_get_buffer(context, d->sums), d->offset, graph_get_buffer(context, d->wanted),
                    0, 4);
}

struct light_list raster_add_kept(struct raster_state *state, struct graph *graph, gpu_device *device,
                                  const struct light_input *input, const struct lights_in_view *in_view,
                                  struct raster_params *params) {
    struct gpu_buffer *wanted = &state->wanted[gpu_frame_slot(device)];
    state->slot_capacity = MAX(state->slot_capacity, (uint32_t)SLOTS_START);
    if (wanted->mapped) {
        uint64_t count = *(const uint32_t *)wanted->mapped;
        if (count > state->slot_capacity) state->slot_capacity = (uint32_t)MIN(count + count / 4, (uint64_t)1 << 28);
    } else if (gpu_buffer_create(device, "raster slots wanted", 4, GPU_MEMORY_READBACK, wanted) != FNL_OK) {
        gpu_fail(device, FNL_ERROR_MEMORY);
    } else {
        *(uint32_t *)wanted->mapped = 0;
    }
    params->slot_capacity = state->slot_capacity;
    if (params->nodes == GPU_NODES_32 && raster_nodes(params, input->set.local_count) != GPU_NODES_32 && !state->warned) {
        log_warning(gpu_host(device),
                    "light lists: 32-bit nodes hold %u lights and %u links; %u lights in a pool of %u take 64-bit nodes",
                    GPU_NODE_32_LIGHTS, GPU_NODE_32_END, input->set.local_count, params->grid.pool_capacity);
        state->warned = true;
    }
    if (params->path == RASTER_PATH_HARDWARE && !raster_on_hardware(device, params) && !state->warned_path) {
        log_warning(gpu_host(device), "light lists: %s does not rasterise conservatively; compute shaders do it",
                    gpu_info(device)->name);
        state->warned_path = true;
    }
    struct raster_list built = raster_add(graph, device, input, in_view, params);
    if (!built.slot_sums.id || !wanted->mapped) return built.list;
    struct wanted_data data = {built.slot_sums, graph_import_buffer(graph, "raster slots wanted", wanted),
                               built.slot_total_offset};
    struct graph_pass *pass =
        graph_add_pass(graph, "raster slots wanted", GRAPH_QUEUE_GRAPHICS, execute_wanted, &data, sizeof data);
    graph_use_buffer(pass, data.sums, GRAPH_COPY_FROM);
    graph_use_buffer(pass, data.wanted, GRAPH_COPY_TO);
    struct graph_pass *host = graph_add_pass(graph, "raster slots to host", GRAPH_QUEUE_GRAPHICS, NULL, NULL, 0);
    graph_keep(host);
    graph_use_buffer(host, data.wanted, GRAPH_READ_HOST);
    return built.list;
}
