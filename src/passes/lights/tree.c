/* SPDX-License-Identifier: MIT */
#include "passes/lights/tree.h"

#include "passes/lights/cells_shared.h"

/* As in cells.glsl. */
#define SLACK 1e-4
#define CAPACITY (1u << 26)

struct light_tree_params light_tree_params_default(void) {
    return (struct light_tree_params){.tile_size = 16, .hybrid = true};
}

void light_tree_init(struct light_tree *builder, const fnl_host *host) {
    *builder = (struct light_tree){.host = host, .capacity = CAPACITY};
}

void light_tree_finish(struct light_tree *builder) {
    array_free(builder->host, &builder->spheres);
    array_free(builder->host, &builder->cells);
    array_free(builder->host, &builder->ids);
    array_free(builder->host, &builder->ranges);
    array_free(builder->host, &builder->nodes);
}

uint32_t light_tree_depth_code(float view_depth) {
    uint32_t bits;
    view_depth = view_depth > 0 ? view_depth : 0;
    memcpy(&bits, &view_depth, sizeof bits);
    int64_t code = (int64_t)(bits >> 12) - (116 << 11);
    return (uint32_t)MIN(MAX(code, 0), 0xffff);
}

/* ---- lights in view space ---- */

static double dot3(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* See disk_slopes() in cells_reach.glsl. */
static void disk_slopes(double x, double depth, double radius, double near, double out[2]) {
    double cut = sqrt(fmax(radius * radius - (near - depth) * (near - depth), 0)), distance2 = x * x + depth * depth;
    out[0] = (x - cut) / near;
    out[1] = (x + cut) / near;
    double tangent = sqrt(fmax(distance2 - radius * radius, 0));
    if (!(tangent > 0)) return;
    double least = near * distance2 / tangent, low = tangent * depth + radius * x, high = tangent * depth - radius * x;
    if (low >= least) out[0] = (tangent * x - radius * depth) / low;
    if (high >= least) out[1] = (tangent * x + radius * depth) / high;
}

/* The screen's edges in the measure of the rectangles. */
static double edge_at(const struct gpu_view *view, int axis, double pixel) {
    double size = axis ? view->size.y : view->size.x, ndc = axis ? 1 - 2 * pixel / size : 2 * pixel / size - 1;
    return axis ? ndc * (double)view->ndc_scale.y + (double)view->ndc_offset.y
                : ndc * (double)view->ndc_scale.x + (double)view->ndc_offset.x;
}

fnl_result light_tree_see(struct light_tree *builder, const struct gpu_entity_bounds *bounds, uint32_t count, uint32_t kinds,
                          const struct gpu_view *view) {
    if (!array_reserve(builder->host, &builder->spheres, count)) return FNL_ERROR_MEMORY;
    builder->spheres.count = builder->in_view = 0;
    float eye_distance = vec3_length(view->eye);
    double screen[4] = {edge_at(view, 0, 0), edge_at(view, 0, view->size.x), edge_at(view, 1, view->size.y),
                        edge_at(view, 1, 0)};
    for (uint32_t i = 0; i < count; i++) {
        struct light_tree_sphere s = {.radius = bounds_are_listed(&bounds[i], kinds) ? bounds[i].radius : 0};
        vec3 center = mat4_point(&view->world_to_view, bounds[i].center);
        s.center[0] = center.x;
        s.center[1] = center.y;
        s.center[2] = center.z;
        s.slack = s.radius * SLACK + SLACK * (1e-2 + sqrt(dot3(s.center, s.center)) * 1e-2) +
                  BOUND_ROUNDING * ((double)vec3_length(bounds[i].center) + (double)eye_distance);
        bool broken = !isfinite(s.radius) || !vec3_finite(center); /* it is everywhere */
        if (s.radius > 0) s.radius += s.slack;
        for (int axis = 0; axis < 2; axis++) {
            s.slopes[axis * 2] = s.center[axis] - s.radius;
            s.slopes[axis * 2 + 1] = s.center[axis] + s.radius;
            if (view->orthographic < 0.5f)
                disk_slopes(s.center[axis], -s.center[2], s.radius, (double)view->near_distance, &s.slopes[axis * 2]);
            if (broken) s.slopes[axis * 2] = -(s.slopes[axis * 2 + 1] = INFINITY);
        }
        if (broken && !(s.radius <= 0)) s.radius = INFINITY;
        if (!broken && (s.center[2] - s.radius > -(double)view->near_distance || s.slopes[0] > screen[1] ||
                        s.slopes[1] < screen[0] || s.slopes[2] > screen[3] || s.slopes[3] < screen[2]))
            s.radius = 0;
        builder->in_view += s.radius > 0;
        builder->spheres.data[builder->spheres.count++] = s;
    }
    return FNL_OK;
}

/* ---- depths between which a sphere is in a tile ---- */

struct tile {
    double planes[4][4]; /* unit normals that point inward */
    double edges[4];     /* left, right, bottom, top */
    bool orthographic;
};

static struct tile tile_of(const struct gpu_view *view, const struct gpu_light_list *header, uint32_t x, uint32_t y) {
    struct tile t = {.orthographic = view->orthographic > 0.5f};
    uint32_t size = header->tile_size;
    t.edges[0] = edge_at(view, 0, x * size);
    t.edges[1] = edge_at(view, 0, MIN((x + 1) * size, view->size.x));
    t.edges[2] = edge_at(view, 1, MIN((y + 1) * size, view->size.y));
    t.edges[3] = edge_at(view, 1, y * size);
    for (int i = 0; i < 4; i++) {
        double sign = i & 1 ? -1 : 1, length = t.orthographic ? 1 : sqrt(1 + t.edges[i] * t.edges[i]);
        t.planes[i][i / 2] = sign / length;
        t.planes[i][t.orthographic ? 3 : 2] = (t.orthographic ? -sign : sign) * t.edges[i] / length;
    }
    return t;
}

static bool inside(const struct tile *t, const double p[3], double slack) {
    for (int i = 0; i < 4; i++)
        if (dot3(t->planes[i], p) + t->planes[i][3] < -slack) return false;
    return true;
}

static void widen(double depths[2], double depth) {
    depths[0] = fmin(depths[0], depth);
    depths[1] = fmax(depths[1], depth);
}

/* See cell_sphere_depths() in cells_depths.glsl, which this is the twin of. */
static bool sphere_depths(const struct tile *t, const struct light_tree_sphere *s, double depths[2]) {
    depths[0] = INFINITY;
    depths[1] = -INFINITY;
    if (isinf(s->radius)) {
        depths[0] = 0;
        depths[1] = 1e30;
        return true;
    }
    const double *c = s->center;
    double radius2 = s->radius * s->radius;
    for (int end = -1; end <= 1; end += 2) { /* the nearest point is towards +z */
        double p[3] = {c[0], c[1], c[2] - end * s->radius};
        if (inside(t, p, s->slack)) {
            widen(depths, -p[2]);
            continue;
        }
        for (int i = 0; i < 4; i++) {
            const double *n = t->planes[i];
            double distance = dot3(n, c) + n[3], cut2 = radius2 - distance * distance, along[3];
            for (int k = 0; k < 3; k++) along[k] = (k == 2 ? -end : 0) + end * n[2] * n[k];
            double along2 = dot3(along, along), length = sqrt(fmax(cut2, 0) / along2);
            if (cut2 < 0 || !(along2 > 0)) continue;
            for (int k = 0; k < 3; k++) p[k] = c[k] - distance * n[k] + length * along[k];
            if (inside(t, p, s->slack)) widen(depths, -p[2]);
        }
    }
    for (int corner = 0; corner < 4; corner++) {
        double x = t->edges[corner & 1], y = t->edges[2 + (corner >> 1)];
        double ray[3] = {t->orthographic ? 0 : x, t->orthographic ? 0 : y, -1};
        double from[3] = {(t->orthographic ? x : 0) - c[0], (t->orthographic ? y : 0) - c[1], -c[2]};
        double length2 = dot3(ray, ray), middle = -dot3(from, ray) / length2;
        for (int k = 0; k < 3; k++) from[k] += middle * ray[k];
        double rest2 = radius2 - dot3(from, from);
        if (rest2 < 0) continue;
        widen(depths, middle - sqrt(rest2 / length2));
        widen(depths, middle + sqrt(rest2 / length2));
    }
    if (!t->orthographic && dot3(c, c) < radius2) widen(depths, 0);
    return depths[1] >= 0 && depths[0] <= depths[1];
}

/* ---- lists: count, then fill, a row of tiles at a time ---- */

struct build {
    struct light_tree *builder;
    const struct gpu_light_list *header;
    const struct gpu_view *view;
    bool fill, hybrid;
};

static void visit_row(void *context, uint32_t y) {
    struct build *b = context;
    const struct gpu_light_list *header = b->header;
    struct gpu_cell *row = b->builder->cells.data + (size_t)y * header->tiles_x;
    struct tile first = tile_of(b->view, header, 0, y), last = tile_of(b->view, header, header->tiles_x - 1, y);
    double width = (last.edges[1] - first.edges[0]) / b->view->size.x * header->tile_size; /* edges are even in pixels */
    for (uint32_t light = 0; light < b->builder->spheres.count; light++) {
        const struct light_tree_sphere *s = &b->builder->spheres.data[light];
        if (!(s->radius > 0) || s->slopes[2] > first.edges[3] || s->slopes[3] < first.edges[2]) continue;
        /* One column more at both ends than division says: it rounds. */
        double from = floor((s->slopes[0] - first.edges[0]) / width) - 1,
               to = floor((s->slopes[1] - first.edges[0]) / width) + 1;
        uint32_t end = (uint32_t)fmin(fmax(to + 1, 0), header->tiles_x);
        for (uint32_t x = (uint32_t)fmin(fmax(from, 0), header->tiles_x); x < end; x++) {
            struct tile t = tile_of(b->view, header, x, y);
            double depths[2];
            if (row[x].count == GPU_CELL_ALL || s->slopes[0] > t.edges[1] || s->slopes[1] < t.edges[0]) continue;
            if (!sphere_depths(&t, s, depths)) continue;
            if (b->fill) {
                uint32_t at = row[x].offset + row[x].count;
                b->builder->ids.data[at] = light;
                b->builder->ranges.data[at] = light_tree_depth_code((float)(depths[0] - s->slack)) |
                                              light_tree_depth_code((float)(depths[1] + s->slack)) << 16;
            }
            row[x].count++;
        }
    }
}

/* ---- trees ---- */

struct tree {
    const uint32_t *ranges; /* of its lights */
    uint32_t *nodes;        /* two words each; node 0 holds their number */
    uint32_t count;
    uint64_t inner_length; /* sum of the lengths of all inner ranges */
    uint32_t order[GPU_TREE_LIGHTS];
};

static uint32_t length_of(uint32_t range) { return (range >> 16) - (range & 0xffff) + 1; }

/* Lights order[first .. end) as a subtree in preorder; returns its range. */
static uint32_t add_nodes(struct tree *t, uint32_t first, uint32_t end) {
    uint32_t node = ++t->count;
    if (end - first == 1) {
        uint32_t bit = t->order[first] % GPU_TREE_LIGHTS;
        t->nodes[2 * node] = t->ranges[bit];
        t->nodes[2 * node + 1] = GPU_TREE_LEAF | bit;
        return t->ranges[bit];
    }
    uint32_t middle = first + (end - first) / 2, a = add_nodes(t, first, middle), b = add_nodes(t, middle, end);
    uint32_t range = MIN(a & 0xffff, b & 0xffff) | MAX(a >> 16, b >> 16) << 16;
    t->nodes[2 * node] = range;
    t->nodes[2 * node + 1] = t->count + 1;
    t->inner_length += length_of(range);
    return range;
}

static int compare(const void *a, const void *b) {
    uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return x < y ? -1 : x > y;
}

static void make_tree(const uint32_t *ranges, uint32_t *nodes, uint32_t light_count, bool hybrid) {
    struct tree t = {.ranges = ranges, .nodes = nodes};
    /* By the middle of the range: 17 bits, and 7 of the light's. */
    for (uint32_t i = 0; i < light_count; i++) t.order[i] = ((ranges[i] & 0xffff) + (ranges[i] >> 16)) * GPU_TREE_LIGHTS + i;
    qsort(t.order, light_count, sizeof t.order[0], compare);
    uint32_t range = add_nodes(&t, 0, light_count);
    /* A walk at a depth in the root's range visits the root and, of each inner node whose range holds the depth, both children. */
    if (hybrid && length_of(range) + 2 * t.inner_length >= (uint64_t)light_count * length_of(range)) {
        t.count = light_count;
        for (uint32_t i = 0; i < light_count; i++) {
            nodes[2 * i + 2] = ranges[i];
            nodes[2 * i + 3] = GPU_TREE_LEAF | i;
        }
    }
    nodes[0] = t.count;
    nodes[1] = 0;
}

static void make_row(void *context, uint32_t y) {
    struct build *b = context;
    struct light_tree *builder = b->builder;
    for (uint32_t x = 0; x < b->header->tiles_x; x++) {
        struct gpu_cell cell = builder->cells.data[(size_t)y * b->header->tiles_x + x];
        if (cell.count == GPU_CELL_ALL) continue;
        for (uint32_t i = 0; i < cell.count; i += GPU_TREE_LIGHTS) {
            size_t first = (size_t)cell.offset + i;
            make_tree(builder->ranges.data + first, builder->nodes.data + 4 * first, MIN(cell.count - i, GPU_TREE_LIGHTS),
                      b->hybrid);
        }
    }
}

fnl_result light_tree_build(struct light_tree *builder, struct jobs *jobs, const struct gpu_light_list *header,
                            const struct gpu_view *view, bool hybrid) {
    uint32_t cell_count = header->tiles_x * header->tiles_y;
    if (!array_reserve(builder->host, &builder->cells, cell_count)) return FNL_ERROR_MEMORY;
    builder->cells.count = cell_count;
    memset(builder->cells.data, 0, cell_count * sizeof *builder->cells.data);
    struct build build = {.builder = builder, .header = header, .view = view, .hybrid = hybrid};
    jobs_parallel_for(jobs, header->tiles_y, visit_row, &build);
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
    if (!array_reserve(builder->host, &builder->ids, total) || !array_reserve(builder->host, &builder->ranges, total) ||
        !array_reserve(builder->host, &builder->nodes, 4 * total))
        return FNL_ERROR_MEMORY;
    builder->ids.count = builder->ranges.count = (uint32_t)total;
    builder->nodes.count = (uint32_t)(4 * total);
    build.fill = true;
    jobs_parallel_for(jobs, header->tiles_y, visit_row, &build);
    jobs_parallel_for(jobs, header->tiles_y, make_row, &build);
    return FNL_OK;
}

uint32_t light_tree_walk(const struct light_tree *builder, uint32_t cell, float view_depth, uint32_t *out,
                         uint64_t *visited) {
    struct gpu_cell c = builder->cells.data[cell];
    uint32_t code = light_tree_depth_code(view_depth), count = 0;
    for (uint32_t i = 0; i < c.count; i += GPU_TREE_LIGHTS) {
        const uint32_t *nodes = builder->nodes.data + 4 * ((size_t)c.offset + i);
        uint32_t found[GPU_TREE_LIGHTS / 32] = {0};
        for (uint32_t node = 1; node <= nodes[0];) {
            uint32_t range = nodes[2 * node], link = nodes[2 * node + 1], bit = link & ~GPU_TREE_LEAF;
            bool holds = code >= (range & 0xffff) && code <= range >> 16, leaf = link & GPU_TREE_LEAF;
            if (leaf && holds) found[bit / 32] |= 1u << bit % 32;
            node = leaf || holds ? node + 1 : link;
            (*visited)++;
        }
        for (uint32_t bit = 0; bit < GPU_TREE_LIGHTS; bit++)
            if (found[bit / 32] >> bit % 32 & 1) out[count++] = i + bit;
    }
    return count;
}

/* ---- to the device ---- */

static VkDeviceAddress send(gpu_device *device, const void *data, uint64_t size) {
    struct gpu_slice slice = gpu_frame_allocate(device, MAX(size, (uint64_t)4));
    if (slice.data && size) memcpy(slice.data, data, size);
    return slice.data ? slice.address : 0;
}

struct light_list light_tree_add(struct light_tree *builder, gpu_device *device, const struct light_input *input,
                                 const struct gpu_entity_bounds *bounds, const struct gpu_view *view,
                                 const struct light_tree_params *params) {
    struct light_list list = {.kind = GPU_LIST_TREE, .lights = input->set.buffer, .totals_known = true};
    struct gpu_light_list *header = light_list_header(device, input, &list.header);
    if (!header) return list;
    header->tile_size = params->tile_size;
    header->tiles_x = DIVIDE_UP(input->width, params->tile_size);
    header->tiles_y = DIVIDE_UP(input->height, params->tile_size);
    if (light_tree_see(builder, bounds, input->set.local_count, input->kinds, view) != FNL_OK ||
        light_tree_build(builder, gpu_jobs(device), header, view, params->hybrid) != FNL_OK) {
        gpu_fail(device, FNL_ERROR_MEMORY);
        return list;
    }
    uint64_t cell_bytes = builder->cells.count * sizeof(struct gpu_cell);
    header->cells = send(device, builder->cells.data, cell_bytes);
    header->ids = send(device, builder->ids.data, builder->ids.count * 4ull);
    header->extra = send(device, builder->nodes.data, builder->nodes.count * 4ull);
    list.cell_count = builder->cells.count;
    list.fixed_bytes = cell_bytes;
    list.entry_bytes = 20;
    list.byte_count = cell_bytes + builder->ids.count * 20ull;
    list.known = (struct light_totals){.in_view = builder->in_view,
                                       .entries = (uint32_t)MIN(builder->entry_count, (uint64_t)UINT32_MAX),
                                       .overflow_cells = builder->overflow_cells};
    return list;
}
