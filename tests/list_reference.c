/* SPDX-License-Identifier: MIT */
/* What light lists must hold, in double precision. */
#include "tests/list_bench.h"

#include "tests/light_reference.h"

static void transform(const mat4 *m, const double p[3], double out[3]) {
    for (int row = 0; row < 3; row++)
        out[row] =
            (double)m->m[row] * p[0] + (double)m->m[4 + row] * p[1] + (double)m->m[8 + row] * p[2] + (double)m->m[12 + row];
}

void world_to_view(const struct gpu_view *view, const double from[3], double out[3]) {
    transform(&view->world_to_view, from, out);
}

void view_to_world(const struct gpu_view *view, const double from[3], double out[3]) {
    /* The inverse of what the GPU multiplies with, not the stored inverse: rigid, but perhaps mirrored. */
    double d[3] = {from[0] - (double)view->world_to_view.m[12], from[1] - (double)view->world_to_view.m[13],
                   from[2] - (double)view->world_to_view.m[14]};
    for (int i = 0; i < 3; i++) {
        const float *column = &view->world_to_view.m[i * 4];
        out[i] = (double)column[0] * d[0] + (double)column[1] * d[1] + (double)column[2] * d[2];
    }
}

static double screen_edge(const struct gpu_view *view, int axis, double pixel) {
    double size = axis ? view->size.y : view->size.x, ndc = axis ? 1 - 2 * pixel / size : 2 * pixel / size - 1;
    return axis ? ndc * (double)view->ndc_scale.y + (double)view->ndc_offset.y
                : ndc * (double)view->ndc_scale.x + (double)view->ndc_offset.x;
}

void view_of_pixel(const struct gpu_view *view, double x, double y, double view_depth, double out[3]) {
    double spread = view->orthographic > 0.5f ? 1 : view_depth;
    out[0] = screen_edge(view, 0, x) * spread;
    out[1] = screen_edge(view, 1, y) * spread;
    out[2] = -view_depth;
}

float depth_of_view_depth(const struct gpu_view *view, double view_depth) {
    /* view depth = (x + y d) / (z + w d) */
    double x = view->depth_decode.x, y = view->depth_decode.y, z = view->depth_decode.z, w = view->depth_decode.w;
    return (float)((x - view_depth * z) / (view_depth * w - y));
}

double view_depth_of_depth(const struct gpu_view *view, float depth) {
    double d = depth;
    return ((double)view->depth_decode.x + (double)view->depth_decode.y * d) /
           ((double)view->depth_decode.z + (double)view->depth_decode.w * d);
}

bool list_position_of(const struct gpu_view *view, const float *depth, uint32_t x, uint32_t y, double out[3]) {
    float stored = depth[(size_t)y * view->size.x + x];
    if (stored <= 0) return false;
    double seen[3];
    view_of_pixel(view, x + 0.5, y + 0.5, view_depth_of_depth(view, stored), seen);
    view_to_world(view, seen, out);
    return true;
}

void pack_normal(const double n[3], uint16_t out[4]) {
    double sum = fabs(n[0]) + fabs(n[1]) + fabs(n[2]), e[2] = {n[0] / sum, n[1] / sum};
    if (n[2] < 0) {
        double x = (1 - fabs(e[1])) * (e[0] < 0 ? -1 : 1), y = (1 - fabs(e[0])) * (e[1] < 0 ? -1 : 1);
        e[0] = x;
        e[1] = y;
    }
    for (int i = 0; i < 2; i++) out[i] = (uint16_t)lrint((e[i] * 0.5 + 0.5) * 65535);
    out[2] = out[3] = 0;
}

void unpack_normal(const uint16_t in[4], double n[3]) {
    double x = in[0] / 65535.0 * 2 - 1, y = in[1] / 65535.0 * 2 - 1;
    n[2] = 1 - fabs(x) - fabs(y);
    n[0] = n[2] < 0 ? (1 - fabs(y)) * (x < 0 ? -1 : 1) : x;
    n[1] = n[2] < 0 ? (1 - fabs(x)) * (y < 0 ? -1 : 1) : y;
    double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int i = 0; i < 3; i++) n[i] /= length;
}

uint32_t list_slice_at(const struct gpu_light_list *g, double depth) {
    double slice = (g->linear ? depth : log2(fmax(depth, 1e-30))) * (double)g->slice_scale + (double)g->slice_bias;
    return (uint32_t)fmin(fmax(slice, 0), g->slices - 1);
}

static const double FAR_AWAY = 1e9;

static double slice_start(const struct gpu_light_list *grid, double slice) {
    double start = (slice - (double)grid->slice_bias) / (double)grid->slice_scale;
    return grid->linear ? start : exp2(start);
}

struct reference_cell reference_cell_of(const struct list_request *request, const struct gpu_light_list *grid, uint32_t cell,
                                        double slack) {
    const struct gpu_view *v = &request->view;
    struct reference_cell r = {0};
    uint32_t tile_x = cell % grid->tiles_x, tile_y = cell / grid->tiles_x % grid->tiles_y,
             slice = cell / (grid->tiles_x * grid->tiles_y);
    uint32_t x0 = tile_x * grid->tile_size, y0 = tile_y * grid->tile_size;
    uint32_t x1 = MIN(x0 + grid->tile_size, v->size.x), y1 = MIN(y0 + grid->tile_size, v->size.y);
    double near = 0, far = FAR_AWAY;
    if (list_is_tiled(request)) {
        if (request->depth && request->builder != LIST_ENHANCED) {
            double nearest = FAR_AWAY, farthest = 0;
            for (uint32_t y = y0; y < y1; y++)
                for (uint32_t x = x0; x < x1; x++) {
                    float d = request->depth[(size_t)y * v->size.x + x], f = d;
                    if (request->front) f = request->front[(size_t)y * v->size.x + x];
                    if (request->front ? f <= d : d <= 0) continue;
                    nearest = fmin(nearest, view_depth_of_depth(v, f));
                    farthest = fmax(farthest, d <= 0 ? FAR_AWAY : view_depth_of_depth(v, d));
                }
            r.empty = farthest == 0;
            if (list_has_halves(request)) { /* each from its nearest to its farthest pixel */
                double split = 0.5 * (nearest * (1 - 1e-4) + farthest * (1 + 1e-4)), ends[2] = {FAR_AWAY, 0};
                for (uint32_t y = y0; y < y1; y++)
                    for (uint32_t x = x0; x < x1; x++) {
                        float d = request->depth[(size_t)y * v->size.x + x];
                        double z = d <= 0 ? 0 : view_depth_of_depth(v, d);
                        if (d <= 0 || (slice == 0 ? z > split * (1 + slack) : z < split * (1 - slack))) continue;
                        ends[0] = fmin(ends[0], z);
                        ends[1] = fmax(ends[1], z);
                    }
                r.empty = r.empty || ends[1] == 0;
                nearest = ends[0];
                farthest = ends[1];
            }
            if (request->tiled.min_depth) near = nearest * (1 - slack);
            if (request->tiled.max_depth && farthest < FAR_AWAY) far = farthest * (1 + slack);
        }
    } else {
        if (slice > 0) near = slice_start(grid, slice) * (1 - slack);
        if (slice + 1 < grid->slices) far = slice_start(grid, slice + 1.0) * (1 + slack);
    }
    double *edges = r.edges;
    edges[0] = screen_edge(v, 0, x0);
    edges[1] = screen_edge(v, 0, x1);
    edges[2] = screen_edge(v, 1, y1);
    edges[3] = screen_edge(v, 1, y0);
    bool orthographic = v->orthographic > 0.5f;
    for (int i = 0; i < 4; i++) {
        double sign = i & 1 ? -1 : 1, length = orthographic ? 1 : sqrt(1 + edges[i] * edges[i]);
        r.planes[i][i / 2] = sign / length;
        if (orthographic)
            r.planes[i][3] = -sign * edges[i];
        else
            r.planes[i][2] = sign * edges[i] / length;
    }
    double spread_near = orthographic ? 1 : near, spread_far = orthographic ? 1 : far;
    for (int axis = 0; axis < 2; axis++) {
        r.low[axis] = fmin(edges[axis * 2] * spread_near, edges[axis * 2] * spread_far);
        r.high[axis] = fmax(edges[axis * 2 + 1] * spread_near, edges[axis * 2 + 1] * spread_far);
    }
    r.low[2] = -far;
    r.high[2] = -near;
    return r;
}

static double bound_in_view(const struct list_request *request, uint32_t light, double center[3]) {
    const struct list_light *l = &request->lights[light];
    double world[3] = {l->bounds.center.x, l->bounds.center.y, l->bounds.center.z};
    transform(&request->view.world_to_view, world, center);
    return l->bounds.radius;
}

bool reference_touches(const struct reference_cell *cell, const struct list_request *request, uint32_t light, double slack,
                       bool box) {
    double c[3], radius = bound_in_view(request, light, c), outside2 = 0;
    if (!(radius > 0) || cell->empty) return false;
    radius = radius * (1 + slack) + slack * (1e-2 + sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]) * 1e-2);
    for (int i = 0; i < 4; i++)
        if (cell->planes[i][0] * c[0] + cell->planes[i][1] * c[1] + cell->planes[i][2] * c[2] + cell->planes[i][3] < -radius)
            return false;
    for (int i = box ? 0 : 2; i < 3; i++) {
        double d = fmax(fmax(cell->low[i] - c[i], c[i] - cell->high[i]), 0);
        outside2 += d * d;
    }
    return outside2 <= radius * radius;
}

void reference_slopes(double x, double depth, double radius, double near, double out[2]) {
    out[0] = INFINITY;
    out[1] = -INFINITY;
    double distance2 = x * x + depth * depth, candidates[4][2];
    double half = sqrt(fmax(radius * radius - (near - depth) * (near - depth), 0));
    for (int i = 0; i < 2; i++) { /* the ends of the cut, and where tangents from the viewer touch */
        double sign = i ? 1 : -1, tangent = sqrt(fmax(distance2 - radius * radius, 0)), scale = tangent / distance2;
        candidates[i][0] = x + sign * half;
        candidates[i][1] = depth - radius <= near ? near : 0;
        candidates[2 + i][0] = (tangent * x + sign * radius * depth) * scale;
        candidates[2 + i][1] = (tangent * depth - sign * radius * x) * scale;
    }
    for (int i = 0; i < 4; i++)
        if (candidates[i][1] >= near) {
            out[0] = fmin(out[0], candidates[i][0] / candidates[i][1]);
            out[1] = fmax(out[1], candidates[i][0] / candidates[i][1]);
        }
}

bool reference_takes(const struct reference_cell *cell, const struct list_request *request, uint32_t light, double slack) {
    bool box = !list_is_tiled(request) || request->tiled.bounds == TILE_BOX;
    if (box || request->tiled.bounds == TILE_PLANES) return reference_touches(cell, request, light, slack, box);
    double c[3], radius = bound_in_view(request, light, c), slopes[2];
    if (!(radius > 0) || cell->empty) return false;
    radius = radius * (1 + slack) + slack * (1e-2 + sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]) * 1e-2);
    for (int axis = 0; axis < 2; axis++) {
        if (request->view.orthographic > 0.5f) {
            slopes[0] = c[axis] - radius;
            slopes[1] = c[axis] + radius;
        } else {
            reference_slopes(c[axis], -c[2], radius, (double)request->view.near_distance, slopes);
        }
        if (slopes[0] > cell->edges[axis * 2 + 1] || slopes[1] < cell->edges[axis * 2]) return false;
    }
    return c[2] - radius <= cell->high[2] && c[2] + radius >= cell->low[2];
}

static void scale_add(double out[3], const double a[3], double s) {
    for (int i = 0; i < 3; i++) out[i] += a[i] * s;
}
static double dot3(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/*
 * The point nearest to the origin of the hull of up to four points: of all their subsets, the one whose plane's nearest point lies between
 * its points. `points` keeps that subset. False when the origin is in the hull or points fall together.
 */
static bool nearest_of_hull(double points[4][3], uint32_t *count, double out[3]) {
    double best = INFINITY;
    uint32_t best_set = 0;
    for (uint32_t set = 1; set < 1u << *count; set++) {
        const double *p[4];
        double m[3][4], weights[4] = {1}, at[3] = {0};
        int n = 0;
        for (uint32_t i = 0; i < *count; i++)
            if (set & 1u << i) p[n++] = points[i];
        for (int i = 1; i < n; i++) {
            for (int j = 1; j < n; j++) {
                m[i - 1][j - 1] = 0;
                for (int k = 0; k < 3; k++) m[i - 1][j - 1] += (p[i][k] - p[0][k]) * (p[j][k] - p[0][k]);
            }
            m[i - 1][3] = 0;
            for (int k = 0; k < 3; k++) m[i - 1][3] -= (p[i][k] - p[0][k]) * p[0][k];
        }
        bool inside = true;
        for (int i = 0; i < n - 1; i++) { /* Gauss; the matrix is positive definite unless points fall together */
            if (!(m[i][i] > 1e-30)) inside = false;
            for (int j = 0; j < n - 1 && inside; j++) {
                double factor = j == i ? 0 : m[j][i] / m[i][i];
                for (int k = 0; k < 4; k++)
                    if (k < n - 1 || k == 3) m[j][k] -= factor * m[i][k];
            }
        }
        for (int i = 1; i < n && inside; i++) {
            weights[i] = m[i - 1][3] / m[i - 1][i - 1];
            weights[0] -= weights[i];
            inside = weights[i] >= 0;
        }
        if (!inside || weights[0] < 0) continue;
        for (int i = 0; i < n; i++) scale_add(at, p[i], weights[i]);
        if (dot3(at, at) < best) {
            best = dot3(at, at);
            best_set = set;
            memcpy(out, at, sizeof at);
        }
    }
    uint32_t kept = 0;
    for (uint32_t i = 0; i < *count; i++)
        if (best_set & 1u << i) memmove(points[kept++], points[i], sizeof points[i]);
    *count = kept;
    return kept > 0 && kept < 4;
}

/* By the algorithm of Gilbert, Johnson and Keerthi (1988) on extreme points of cell and cone. */
double reference_cone_gap(const struct reference_cell *cell, const struct list_request *request, uint32_t light) {
    const struct list_light *l = &request->lights[light];
    if (l->shape.kind != GPU_SHAPE_CONE) return 0;
    const mat4 *m = &request->view.world_to_view;
    double apex[3], tip[3], axis[3], world[3] = {l->shape.position.x, l->shape.position.y, l->shape.position.z}, range = l->shape.range;
    double cosine = fmax(-(double)l->shape.spot_offset / (double)l->shape.spot_scale, 0), sine = sqrt(fmax(1 - cosine * cosine, 0));
    transform(m, world, apex);
    world[0] += (double)l->shape.direction.x;
    world[1] += (double)l->shape.direction.y;
    world[2] += (double)l->shape.direction.z;
    transform(m, world, tip);
    for (int i = 0; i < 3; i++) axis[i] = tip[i] - apex[i];
    double axis_length = sqrt(dot3(axis, axis));
    for (int i = 0; i < 3; i++) axis[i] /= axis_length;
    /* A cell without end is cut where it is out of range. */
    double depths[2] = {fmax(-cell->high[2], -apex[2] - range), fmin(-cell->low[2], -apex[2] + range)};
    if (depths[0] > depths[1]) return depths[0] - depths[1];
    bool orthographic = request->view.orthographic > 0.5f;
    double points[4][3], gap[3] = {-apex[0], -apex[1], -depths[0] - apex[2]};
    uint32_t count = 0;
    for (int step = 0; step < 200; step++) {
        double length = sqrt(dot3(gap, gap));
        if (!(length > 1e-9)) return 0;
        double n[3] = {gap[0] / length, gap[1] / length, gap[2] / length}, least = INFINITY;
        for (int corner = 0; corner < 8; corner++) { /* of the cell, the least along n */
            double depth = depths[corner >> 2], spread = orthographic ? 1 : depth;
            double p[3] = {cell->edges[corner & 1] * spread, cell->edges[2 + (corner >> 1 & 1)] * spread, -depth};
            if (dot3(p, n) < least) {
                least = dot3(p, n);
                memcpy(points[count], p, sizeof p);
            }
        }
        double along = dot3(n, axis), q[3] = {apex[0], apex[1], apex[2]}, across[3] = {n[0], n[1], n[2]};
        scale_add(across, axis, -along);
        double across_length = sqrt(dot3(across, across));
        if (along >= cosine) {
            scale_add(q, n, range);
        } else if (cosine * along + sine * across_length > 1e-12) { /* the rim; else the apex */
            scale_add(q, axis, range * cosine);
            scale_add(q, across, range * sine / across_length);
        }
        if (least - dot3(q, n) > 1e-7) return least - dot3(q, n);
        scale_add(points[count++], q, -1);
        if (!nearest_of_hull(points, &count, gap)) return 0;
    }
    return 0;
}

bool reference_in_view(const struct list_request *request, uint32_t light) {
    double c[3], radius = bound_in_view(request, light, c);
    struct gpu_light_list whole = {
        .tile_size = MAX(request->view.size.x, request->view.size.y), .tiles_x = 1, .tiles_y = 1, .slices = 1};
    struct list_request all = *request;
    all.builder = LIST_TILED;
    all.depth = NULL;
    struct reference_cell frustum = reference_cell_of(&all, &whole, 0, 0);
    return -c[2] + radius >= (double)request->view.near_distance && reference_touches(&frustum, request, light, 0, false);
}

void reference_check(const struct list_request *request, const struct list_copy *list) {
    enum { SAID = 5 };
    uint32_t missing = 0, needless = 0;
    bool cones = list_is_tiled(request) ? request->tiled.cone_tests : request->clustered.cone_tests;
    bool *in_view = malloc(request->light_count + 1);
    assert_non_null(in_view);
    for (uint32_t light = 0; light < request->light_count; light++) in_view[light] = reference_in_view(request, light);
    for (uint32_t c = 0; c < list->cell_count; c++) {
        if (list->cells[c].count == GPU_CELL_ALL) continue;
        struct reference_cell exact = reference_cell_of(request, &list->grid, c, 0),
                              wide = reference_cell_of(request, &list->grid, c, 2e-4);
        for (uint32_t light = 0; light < request->light_count; light++) {
            bool holds = list_holds(list, c, light);
            if (!holds && in_view[light] && reference_takes(&exact, request, light, 0) &&
                !(cones && reference_cone_gap(&exact, request, light) > 0) && missing++ < SAID)
                print_error("cell %u misses light %u\n", c, light);
            if (holds && !reference_takes(&wide, request, light, 3e-4) && needless++ < SAID)
                print_error("cell %u holds light %u, which is far from it\n", c, light);
        }
    }
    free(in_view);
    assert_int_equal(missing, 0);
    assert_int_equal(needless, 0);
}

bool light_reaches(const fnl_light_params *light, const double point[3]) {
    const double at[3] = {light->position.x, light->position.y, light->position.z};
    double to_light[3];
    if (light->kind == FNL_LIGHT_DIRECTIONAL) return false;
    /* At its very position a light has no direction, but it is there. */
    if (light->kind <= FNL_LIGHT_SPOT && at[0] == point[0] && at[1] == point[1] && at[2] == point[2]) return true;
    return light_reference(light, point, to_light) > 0;
}
