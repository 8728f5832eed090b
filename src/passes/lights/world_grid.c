/* SPDX-License-Identifier: MIT */
#include "passes/lights/world_grid.h"

#include "passes/lights/cells_shared.h"

/* As in cells.glsl: tests are widened so that rounding never loses a light. */
static const double SLACK = 1e-4;

enum { SIDE_LIMIT = 4096, CELLS_PER_LIGHT = 8, CELLS_LEAST = 4096 };

struct world_grid_params world_grid_params_default(void) {
    return (struct world_grid_params){.cell_limit = 1u << 20, .span_limit = 1u << 26, .entry_limit = 1u << 28};
}

void world_grid_init(struct world_grid *grid, const fnl_host *host) {
    *grid = (struct world_grid){.host = host, .version = UINT64_MAX};
}

void world_grid_finish(struct world_grid *grid, gpu_device *device) {
    array_free(grid->host, &grid->cells);
    array_free(grid->host, &grid->ids);
    gpu_buffer_destroy(device, &grid->cell_buffer);
    gpu_buffer_destroy(device, &grid->id_buffer);
}

/* ---- the grid ---- */

static double axis(vec3 v, int k) { return (double)(k == 0 ? v.x : k == 1 ? v.y : v.z); }

/* Those whose position or range is not finite are in every cell. */
static bool has_place(const struct gpu_entity_bounds *bounds) {
    return vec3_finite(bounds->center) && isfinite(bounds->radius);
}

static uint32_t place_on(double position, double origin, double inverse_size, uint32_t count) {
    double at = (position - origin) * inverse_size;
    return at > 0 ? (uint32_t)fmin(at, count - 1.0) : 0; /* NaN: 0 */
}

uint32_t world_grid_cell(const struct world_grid *grid, vec3 position) {
    uint32_t at[3];
    for (int k = 0; k < 3; k++)
        at[k] = place_on(axis(position, k), axis(grid->origin, k), (double)grid->inverse_size, grid->size[k]);
    return (at[2] * grid->size[1] + at[1]) * grid->size[0] + at[0];
}

struct span {
    uint32_t first[3], last[3];
    double center[3], radius;
};

static struct span span_of(const struct world_grid *grid, const struct gpu_entity_bounds *bounds) {
    struct span s = {0};
    bool placed = has_place(bounds);
    double far_out = 0;
    for (int k = 0; k < 3; k++) {
        s.center[k] = axis(bounds->center, k);
        far_out += fabs(s.center[k]) + fabs(axis(grid->origin, k)) + (double)grid->cell_size * grid->size[k];
    }
    s.radius = placed
                   ? (double)bounds->radius * (1 + SLACK) + SLACK * (double)grid->cell_size + BOUND_ROUNDING * far_out
                   : (double)INFINITY;
    for (int k = 0; k < 3; k++) {
        double origin = axis(grid->origin, k), inverse = (double)grid->inverse_size;
        s.first[k] = placed ? place_on(s.center[k] - s.radius, origin, inverse, grid->size[k]) : 0;
        s.last[k] = placed ? place_on(s.center[k] + s.radius, origin, inverse, grid->size[k]) : grid->size[k] - 1;
    }
    return s;
}

/* Cells in the spans of all; stops beyond `most`. */
static uint64_t spanned(const struct world_grid *grid, const struct gpu_entity_bounds *bounds, uint32_t count, uint32_t kinds,
                        uint64_t most) {
    uint64_t sum = 0;
    for (uint32_t i = 0; i < count && sum <= most; i++) {
        if (!bounds_are_listed(&bounds[i], kinds)) continue;
        struct span s = span_of(grid, &bounds[i]);
        uint64_t cells = 1;
        for (int k = 0; k < 3; k++) cells *= s.last[k] - s.first[k] + 1;
        sum += cells;
    }
    return sum;
}

static void lay_grid(struct world_grid *grid, const struct gpu_entity_bounds *bounds, uint32_t count, uint32_t kinds,
                     const struct box *scene, const struct world_grid_params *params) {
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY}, extent[3];
    for (uint32_t i = 0; i < count; i++) {
        if (!bounds_are_listed(&bounds[i], kinds) || !has_place(&bounds[i])) continue;
        for (int k = 0; k < 3; k++) {
            low[k] = fmin(low[k], axis(bounds[i].center, k) - (double)bounds[i].radius);
            high[k] = fmax(high[k], axis(bounds[i].center, k) + (double)bounds[i].radius);
        }
    }
    for (int k = 0; k < 3; k++) {
        if (!box_is_empty(scene) && isfinite(axis(scene->low, k)) && isfinite(axis(scene->high, k))) {
            low[k] = fmax(low[k], axis(scene->low, k));
            high[k] = fmin(high[k], axis(scene->high, k));
        }
        if (!(high[k] - low[k] > 0)) low[k] = isfinite(low[k]) ? low[k] : 0, high[k] = low[k];
        extent[k] = fmin(high[k] - low[k], 1e18);
    }
    if (params->flat) extent[1] = 0;
    grid->origin = vec3_make((float)low[0], (float)low[1], (float)low[2]);
    double size = (double)params->cell_size;
    if (!(size > 0)) {
        double cells = fmin(fmax((double)count * CELLS_PER_LIGHT, CELLS_LEAST), params->cell_limit);
        double least = 1e-3 * fmax(extent[0], fmax(extent[1], extent[2])) + 1e-6;
        size = params->flat ? 4 : cbrt(fmax(extent[0], least) * fmax(extent[1], least) * fmax(extent[2], least) / cells);
    }
    for (;; size *= 2) {
        double total = 1;
        bool fits = true;
        for (int k = 0; k < 3; k++) {
            double side = floor(extent[k] / size) + 1;
            fits = fits && side <= SIDE_LIMIT;
            grid->size[k] = (uint32_t)fmin(side, SIDE_LIMIT);
            total *= side;
        }
        grid->cell_size = (float)size;
        grid->inverse_size = 1 / grid->cell_size;
        if (!fits || total > MAX(params->cell_limit, 1u)) continue;
        if (total <= 1 || spanned(grid, bounds, count, kinds, params->span_limit) <= params->span_limit) break;
    }
}

/* ---- the lists ---- */

/* Squared distance of the sphere's centre from a row of cells on one axis; those at the border never end. */
static double outside(const struct world_grid *grid, const struct span *s, int k, uint32_t at) {
    double low = axis(grid->origin, k) + at * (double)grid->cell_size, high = low + (double)grid->cell_size, distance = 0;
    if (at > 0) distance = fmax(distance, low - s->center[k]);
    if (at + 1 < grid->size[k]) distance = fmax(distance, s->center[k] - high);
    return distance * distance;
}

static void visit(struct world_grid *grid, const struct gpu_entity_bounds *bounds, uint32_t id, bool fill) {
    struct span s = span_of(grid, bounds);
    double limit = s.radius * s.radius;
    for (uint32_t z = s.first[2]; z <= s.last[2]; z++) {
        double from_z = outside(grid, &s, 2, z);
        for (uint32_t y = s.first[1]; y <= s.last[1]; y++) {
            double from_y = from_z + outside(grid, &s, 1, y);
            if (from_y > limit) continue;
            struct gpu_cell *row = &grid->cells.data[(size_t)(z * grid->size[1] + y) * grid->size[0]];
            for (uint32_t x = s.first[0]; x <= s.last[0]; x++) {
                if (from_y + outside(grid, &s, 0, x) > limit || row[x].count == GPU_CELL_ALL) continue;
                if (fill) grid->ids.data[row[x].offset + row[x].count] = id;
                row[x].count++;
            }
        }
    }
}

fnl_result world_grid_build(struct world_grid *grid, const struct gpu_entity_bounds *bounds, uint32_t count, uint32_t kinds,
                            const struct box *scene, const struct world_grid_params *params) {
    lay_grid(grid, bounds, count, kinds, scene, params);
    uint32_t cell_count = grid->size[0] * grid->size[1] * grid->size[2];
    if (!array_reserve(grid->host, &grid->cells, cell_count)) return FNL_ERROR_MEMORY;
    grid->cells.count = cell_count;
    memset(grid->cells.data, 0, cell_count * sizeof *grid->cells.data);
    grid->light_count = 0;
    for (uint32_t i = 0; i < count; i++) {
        if (!bounds_are_listed(&bounds[i], kinds)) continue;
        visit(grid, &bounds[i], i, false);
        grid->light_count++;
    }
    uint64_t total = 0;
    grid->entry_count = grid->overflow_cells = 0;
    for (uint32_t i = 0; i < cell_count; i++) {
        struct gpu_cell *cell = &grid->cells.data[i];
        grid->entry_count += cell->count;
        bool fits = total + cell->count <= MIN(params->entry_limit, (uint64_t)UINT32_MAX - 1);
        cell->offset = (uint32_t)total;
        total += fits ? cell->count : 0;
        cell->count = fits ? 0 : GPU_CELL_ALL;
        grid->overflow_cells += !fits;
    }
    if (!array_reserve(grid->host, &grid->ids, MAX(total, 1u))) return FNL_ERROR_MEMORY;
    grid->ids.count = (uint32_t)total;
    for (uint32_t i = 0; i < count; i++)
        if (bounds_are_listed(&bounds[i], kinds)) visit(grid, &bounds[i], i, true);
    return FNL_OK;
}

/* ---- on the device ---- */

struct upload_data {
    struct gpu_slice slices[2];
    graph_buffer targets[2];
    uint64_t sizes[2];
};

static void execute_upload(const struct graph_context *context, const void *data) {
    const struct upload_data *d = data;
    for (int i = 0; i < 2; i++)
        if (d->sizes[i])
            gpu_copy_buffer(context->commands, d->slices[i].buffer, d->slices[i].offset,
                            graph_get_buffer(context, d->targets[i]), 0, d->sizes[i]);
}

static fnl_result keep(gpu_device *device, const char *name, struct gpu_buffer *buffer, uint64_t size) {
    if (buffer->size >= size && buffer->handle) return FNL_OK;
    gpu_buffer_destroy(device, buffer);
    return gpu_buffer_create_for(device, GPU_USE_LIGHTS, name, size + size / 4, GPU_MEMORY_DEVICE, buffer);
}

static fnl_result rebuild(struct world_grid *grid, gpu_device *device, const struct light_input *input,
                          const struct gpu_entity_bounds *bounds, const struct box *scene, const struct world_grid_params *params,
                          struct upload_data *upload) {
    grid->version = UINT64_MAX;
    TRY(world_grid_build(grid, bounds, input->set.local_count, input->kinds, scene, params));
    upload->sizes[0] = grid->cells.count * sizeof(struct gpu_cell);
    upload->sizes[1] = grid->ids.count * 4ull;
    TRY(keep(device, "world cells", &grid->cell_buffer, upload->sizes[0]));
    TRY(keep(device, "world ids", &grid->id_buffer, MAX(upload->sizes[1], 4u)));
    const void *sources[2] = {grid->cells.data, grid->ids.data};
    for (int i = 0; i < 2; i++) {
        if (!upload->sizes[i]) continue;
        upload->slices[i] = gpu_frame_allocate(device, upload->sizes[i]);
        if (!upload->slices[i].data) return FNL_ERROR_MEMORY;
        memcpy(upload->slices[i].data, sources[i], upload->sizes[i]);
    }
    return FNL_OK;
}

struct light_list world_grid_add(struct world_grid *grid, struct graph *graph, gpu_device *device,
                                 const struct light_input *input, const struct gpu_entity_bounds *bounds, uint64_t version,
                                 const struct box *scene, const struct world_grid_params *params) {
    struct light_list list = {.kind = GPU_LIST_WORLD, .lights = input->set.buffer, .totals_known = true};
    struct gpu_light_list *header = light_list_header(device, input, &list.header);
    struct upload_data upload = {0};
    const struct world_grid_params *p = &grid->params;
    bool stale = grid->version != version || p->flat != params->flat || p->cell_size != params->cell_size ||
                 p->cell_limit != params->cell_limit || p->span_limit != params->span_limit || p->entry_limit != params->entry_limit;
    if (stale) {
        fnl_result result = rebuild(grid, device, input, bounds, scene, params, &upload);
        if (result != FNL_OK) {
            gpu_fail(device, result);
            list.kind = GPU_LIST_ALL;
            return list;
        }
        grid->version = version;
        grid->params = *params;
        grid->build_count++;
    }
    list.cells = graph_import_buffer(graph, "world cells", &grid->cell_buffer);
    list.ids = graph_import_buffer(graph, "world ids", &grid->id_buffer);
    if (stale) {
        upload.targets[0] = list.cells;
        upload.targets[1] = list.ids;
        struct graph_pass *pass =
            graph_add_pass(graph, "world upload", GRAPH_QUEUE_GRAPHICS, execute_upload, &upload, sizeof upload);
        graph_use_buffer(pass, list.cells, GRAPH_COPY_TO);
        graph_use_buffer(pass, list.ids, GRAPH_COPY_TO);
    }
    if (header) {
        header->tiles_x = grid->size[0];
        header->tiles_y = grid->size[1];
        header->slices = grid->size[2];
        header->origin = grid->origin;
        header->inverse_size = grid->inverse_size;
        header->cells = grid->cell_buffer.address;
        header->ids = grid->id_buffer.address;
    }
    list.cell_count = grid->cells.count;
    list.fixed_bytes = grid->cells.count * sizeof(struct gpu_cell);
    list.byte_count = list.fixed_bytes + grid->ids.count * 4ull;
    list.entry_bytes = 4;
    list.known = (struct light_totals){.in_view = grid->light_count,
                                       .entries = (uint32_t)MIN(grid->entry_count, (uint64_t)UINT32_MAX),
                                       .overflow_cells = grid->overflow_cells};
    return list;
}
