/* SPDX-License-Identifier: MIT */
#include "passes/lights/clustered.h"

#include "passes/lights/cells_shared.h"

/* As in cells.glsl: tests are widened so that rounding never loses a light. */
static const float SLACK = 1e-4f;

void clustered_cpu_init(struct clustered_cpu *builder, const fnl_host *host) {
    *builder = (struct clustered_cpu){.host = host, .capacity = 1u << 26};
}

void clustered_cpu_finish(struct clustered_cpu *builder) {
    array_free(builder->host, &builder->cells);
    array_free(builder->host, &builder->ids);
    array_free(builder->host, &builder->spheres);
}

struct build {
    struct clustered_cpu *builder;
    const struct gpu_light_list *header;
    const struct clustered_cpu_view *view;
    bool fill;
};

/* Plane through the view rays of one tile edge; `axis` 0: x, 1: y. Distance is positive on the side of greater coordinates. */
struct edge {
    float slope, scale, offset;
};

static struct edge edge_at(const struct clustered_cpu_view *view, int axis, float pixel) {
    float size = axis == 0 ? (float)view->width : (float)view->height;
    float ndc = axis == 0 ? pixel / size * 2 - 1 : 1 - pixel / size * 2;
    float scale = axis == 0 ? view->ndc_scale.x : view->ndc_scale.y,
          shift = axis == 0 ? view->ndc_offset.x : view->ndc_offset.y;
    float at = ndc * scale + shift;
    if (view->orthographic) return (struct edge){0, 1, -at};
    return (struct edge){at, 1 / sqrtf(1 + at * at), 0};
}

/* Signed distance of a point with this coordinate and view depth from the plane coordinate = slope * depth. */
static float edge_distance(struct edge e, float coordinate, float depth) {
    return (coordinate - e.slope * depth) * e.scale + e.offset;
}

static float slice_start(const struct gpu_light_list *header, uint32_t slice) {
    float start = ((float)slice - header->slice_bias) / header->slice_scale;
    return header->linear ? start : exp2f(start);
}

/* A sphere cut by a plane at `distance` from its centre: what lies beyond fits into a smaller sphere around the cut. */
static float shrink(float radius, float distance) {
    float rest = radius * radius - distance * distance;
    return rest > 0 ? sqrtf(rest) : -1;
}

static void visit_cell(struct build *b, uint32_t cell, uint32_t light) {
    struct gpu_cell *c = &b->builder->cells.data[cell];
    if (c->count == GPU_CELL_ALL) return;
    if (b->fill) b->builder->ids.data[c->offset + c->count] = light;
    c->count++;
}

/* Columns of a row from both ends, until the sphere no longer is wholly beyond the column's inner edge. */
static void narrow_columns(const struct build *b, uint32_t *first, uint32_t *end, float x, float depth, float radius) {
    float tile = (float)b->header->tile_size;
    float width = (float)b->view->width;
    while (*first < *end && edge_distance(edge_at(b->view, 0, fminf((float)(*first + 1) * tile, width)), x, depth) > radius)
        (*first)++;
    while (*end > *first && edge_distance(edge_at(b->view, 0, (float)(*end - 1) * tile), x, depth) < -radius) (*end)--;
}

static void visit_slice(void *context, uint32_t slice) {
    struct build *b = context;
    const struct gpu_light_list *header = b->header;
    float near = slice == 0 ? 0 : slice_start(header, slice) * (1 - SLACK);
    float far = slice + 1 == header->slices ? FLT_MAX : slice_start(header, slice + 1) * (1 + SLACK);
    float tile = (float)header->tile_size;
    for (uint32_t light = 0; light < b->builder->spheres.count; light++) {
        struct clustered_cpu_sphere sphere = b->builder->spheres.data[light];
        if (!(sphere.radius > 0)) continue;
        float whole_depth = -sphere.center.z, depth = whole_depth, radius = sphere.radius;
        if (depth + radius < near || depth - radius > far) continue;
        if (depth < near) {
            radius = shrink(radius, near - depth);
            depth = near;
        } else if (depth > far) {
            radius = shrink(radius, depth - far);
            depth = far;
        }
        if (radius < 0) continue;
        /* A smaller sphere may bulge out of the whole one on the far side of its plane: both must touch. */
        uint32_t first = 0, end = header->tiles_x;
        narrow_columns(b, &first, &end, sphere.center.x, whole_depth, sphere.radius);
        narrow_columns(b, &first, &end, sphere.center.x, depth, radius);
        for (uint32_t row = 0; row < header->tiles_y; row++) {
            /* Rows go down the screen, y goes up. */
            struct edge top = edge_at(b->view, 1, (float)row * tile);
            struct edge bottom = edge_at(b->view, 1, fminf((float)(row + 1) * tile, (float)b->view->height));
            float above = edge_distance(top, sphere.center.y, depth), below = -edge_distance(bottom, sphere.center.y, depth);
            float distance = fmaxf(above, below);
            if (distance > radius) continue;
            if (edge_distance(top, sphere.center.y, whole_depth) > sphere.radius) continue;
            if (edge_distance(bottom, sphere.center.y, whole_depth) < -sphere.radius) continue;
            uint32_t row_first = first, row_end = end, row_start = (slice * header->tiles_y + row) * header->tiles_x;
            if (distance > 0) { /* the centre is not in the row */
                /* Shrink onto the facing plane and move the centre there: the plane's normal leans in y and depth. */
                struct edge facing = above > below ? top : bottom;
                float moved_depth = depth + (above > below ? distance : -distance) * facing.slope * facing.scale;
                narrow_columns(b, &row_first, &row_end, sphere.center.x, moved_depth, shrink(radius, distance));
            }
            for (uint32_t x = row_first; x < row_end; x++) visit_cell(b, row_start + x, light);
        }
    }
}

fnl_result clustered_cpu_build(struct clustered_cpu *builder, struct jobs *jobs, const struct gpu_light_list *header,
                               const struct clustered_cpu_view *view) {
    uint32_t cell_count = header->tiles_x * header->tiles_y * header->slices;
    if (!array_reserve(builder->host, &builder->cells, cell_count)) return FNL_ERROR_MEMORY;
    builder->cells.count = cell_count;
    memset(builder->cells.data, 0, cell_count * sizeof *builder->cells.data);
    for (uint32_t i = 0; i < builder->spheres.count; i++) {
        struct clustered_cpu_sphere *s = &builder->spheres.data[i];
        if (s->radius > 0) s->radius = s->radius * (1 + SLACK) + SLACK * (1e-2f + vec3_length(s->center) * 1e-2f);
    }
    struct build build = {.builder = builder, .header = header, .view = view};
    jobs_parallel_for(jobs, header->slices, visit_slice, &build);
    uint64_t total = 0;
    builder->entry_count = builder->overflow_cells = 0;
    for (uint32_t i = 0; i < cell_count; i++) {
        struct gpu_cell *cell = &builder->cells.data[i];
        builder->entry_count += cell->count;
        bool fits = total + cell->count <= builder->capacity;
        cell->offset = (uint32_t)total;
        total += fits ? cell->count : 0;
        cell->count = fits ? 0 : GPU_CELL_ALL;
        builder->overflow_cells += !fits;
    }
    if (!array_reserve(builder->host, &builder->ids, total)) return FNL_ERROR_MEMORY;
    builder->ids.count = (uint32_t)total;
    build.fill = true;
    jobs_parallel_for(jobs, header->slices, visit_slice, &build);
    return FNL_OK;
}

static bool outside_view(const struct clustered_cpu_view *view, const struct clustered_cpu_sphere *s) {
    float depth = -s->center.z;
    if (depth + s->radius < 0) return true;
    return edge_distance(edge_at(view, 0, 0), s->center.x, depth) < -s->radius ||
           edge_distance(edge_at(view, 0, (float)view->width), s->center.x, depth) > s->radius ||
           edge_distance(edge_at(view, 1, 0), s->center.y, depth) > s->radius ||
           edge_distance(edge_at(view, 1, (float)view->height), s->center.y, depth) < -s->radius;
}

struct light_list clustered_cpu_add(struct clustered_cpu *builder, gpu_device *device, const struct light_input *input,
                                    const struct gpu_entity_bounds *bounds, const mat4 *world_to_view,
                                    const struct clustered_cpu_view *view, const struct clustered_params *params) {
    struct light_list list = {.kind = GPU_LIST_CLUSTERS, .lights = input->set.buffer, .totals_known = true};
    struct gpu_light_list *header = light_list_header(device, input, &list.header);
    if (!header) return list;
    clustered_grid(header, input->width, input->height, params);
    builder->spheres.count = builder->in_view = 0;
    /* The translation of world_to_view is as long as the viewer is far from the origin. */
    float eye_distance = vec3_length((vec3){world_to_view->m[12], world_to_view->m[13], world_to_view->m[14]});
    bool failed = !array_reserve(builder->host, &builder->spheres, input->set.local_count);
    for (uint32_t i = 0; i < input->set.local_count && !failed; i++) {
        struct clustered_cpu_sphere sphere = {mat4_point(world_to_view, bounds[i].center), bounds[i].radius};
        bool listed = bounds_are_listed(&bounds[i], input->kinds);
        if (listed) sphere.radius += (float)BOUND_ROUNDING * (vec3_length(bounds[i].center) + eye_distance);
        if (!listed || outside_view(view, &sphere))
            sphere.radius = 0;
        else
            builder->in_view++;
        builder->spheres.data[builder->spheres.count++] = sphere;
    }
    failed = failed || clustered_cpu_build(builder, gpu_jobs(device), header, view) != FNL_OK;
    if (failed) {
        gpu_fail(device, FNL_ERROR_MEMORY);
        return list;
    }
    uint64_t cell_bytes = builder->cells.count * sizeof(struct gpu_cell);
    struct gpu_slice cells = gpu_frame_allocate(device, cell_bytes),
                     ids = gpu_frame_allocate(device, MAX(builder->ids.count, 1u) * 4ull);
    if (!cells.data || !ids.data) return list;
    memcpy(cells.data, builder->cells.data, cell_bytes);
    if (builder->ids.count) memcpy(ids.data, builder->ids.data, builder->ids.count * 4ull);
    header->cells = cells.address;
    header->ids = ids.address;
    list.cell_count = builder->cells.count;
    list.byte_count = cell_bytes + builder->ids.count * 4ull;
    list.fixed_bytes = cell_bytes;
    list.entry_bytes = 4;
    list.known = (struct light_totals){.in_view = builder->in_view,
                                       .entries = (uint32_t)MIN(builder->entry_count, (uint64_t)UINT32_MAX),
                                       .overflow_cells = builder->overflow_cells};
    return list;
}
