/* SPDX-License-Identifier: MIT */
/**
 * Lists by conservative rasterisation: entry by entry against meshes in double precision and against points that lights reach. Numbers of
 * the checklist are those of the digest of "Clustered Shading: Assigning Lights Using Conservative Rasterization in DirectX 12".
 */
#include "passes/lights/light_proxy.h"
#include "passes/lights/raster_mesh.h"
#include "tests/raster_bench.h"

enum { LIGHTS = 300, MOST = 65536, WIDTH = 301, HEIGHT = 173 };

static fnl_light_params params[MOST];
static struct list_light lights[MOST];

/* ---- the oracle: a mesh in tiles, in double ---- */

struct tile_range {
    double near, far; /* near > far: nothing */
};

struct double_polygon {
    double at[24][3];
    uint32_t count;
};

static void cut_polygon(struct double_polygon *p, const double plane[4]) {
    struct double_polygon result = {.count = 0};
    for (uint32_t i = 0; i < p->count; i++) {
        const double *a = p->at[i], *b = p->at[(i + 1) % p->count];
        double da = plane[0] * a[0] + plane[1] * a[1] + plane[2] * a[2] + plane[3],
               db = plane[0] * b[0] + plane[1] * b[1] + plane[2] * b[2] + plane[3];
        if (da >= 0) memcpy(result.at[result.count++], a, sizeof result.at[0]);
        if ((da >= 0) != (db >= 0)) {
            for (int k = 0; k < 3; k++) result.at[result.count][k] = a[k] + (b[k] - a[k]) * (da / (da - db));
            result.count++;
        }
    }
    *p = result;
}

static double slope_at(const struct gpu_view *v, int axis, double pixel) {
    double size = axis ? v->size.y : v->size.x, ndc = axis ? 1 - 2 * pixel / size : 2 * pixel / size - 1;
    return axis ? ndc * (double)v->ndc_scale.y + (double)v->ndc_offset.y
                : ndc * (double)v->ndc_scale.x + (double)v->ndc_offset.x;
}

static void to_depth_space(const struct gpu_view *v, vec3 world, double out[3]) {
    const float *m = v->world_to_view.m;
    for (int row = 0; row < 3; row++)
        out[row] = (double)m[row] * (double)world.x + (double)m[4 + row] * (double)world.y +
                   (double)m[8 + row] * (double)world.z + (double)m[12 + row];
    out[2] = -out[2];
}

/* Depths of a convex mesh within a tile that is `slack` pixels wider, nearer than the near plane left out. */
static struct tile_range mesh_in_tile(const struct gpu_view *v, const vec3 *corners, uint32_t triangles, uint32_t tile_size,
                                      uint32_t tile_x, uint32_t tile_y, double slack, double near) {
    struct tile_range range = {1e300, -1e300};
    double edges[4] = {
        slope_at(v, 0, tile_x * tile_size - slack), slope_at(v, 0, fmin((tile_x + 1) * tile_size, v->size.x) + slack),
        slope_at(v, 1, fmin((tile_y + 1) * tile_size, v->size.y) + slack), slope_at(v, 1, tile_y * tile_size - slack)};
    bool orthographic = v->orthographic > 0.5f, inside = true;
    double middle[3] = {0}, eye[3];
    for (uint32_t i = 0; i < triangles * 3; i++) {
        double p[3];
        to_depth_space(v, corners[i], p);
        for (int k = 0; k < 3; k++) middle[k] += p[k] / (triangles * 3);
    }
    for (int k = 0; k < 3; k++) /* a corner of the tile on the near plane */
        eye[k] = k == 2 ? near : edges[k * 2] * (orthographic ? 1 : near);
    for (uint32_t t = 0; t < triangles; t++) {
        struct double_polygon p = {.count = 3};
        for (int i = 0; i < 3; i++) to_depth_space(v, corners[t * 3 + i], p.at[i]);
        double u[3], w[3], n[3], to_middle = 0, to_eye = 0;
        for (int k = 0; k < 3; k++) {
            u[k] = p.at[1][k] - p.at[0][k];
            w[k] = p.at[2][k] - p.at[0][k];
        }
        for (int k = 0; k < 3; k++) n[k] = u[(k + 1) % 3] * w[(k + 2) % 3] - u[(k + 2) % 3] * w[(k + 1) % 3];
        for (int k = 0; k < 3; k++) {
            to_middle += n[k] * (middle[k] - p.at[0][k]);
            to_eye += n[k] * (eye[k] - p.at[0][k]);
        }
        if (to_eye * (to_middle > 0 ? 1 : -1) < 0) inside = false;
        cut_polygon(&p, (double[]){0, 0, 1, -near});
        for (int i = 0; i < 4 && p.count; i++) {
            double plane[4] = {0}, sign = i & 1 ? -1 : 1;
            plane[i / 2] = sign;
            plane[orthographic ? 3 : 2] = -sign * edges[i];
            cut_polygon(&p, plane);
        }
        for (uint32_t i = 0; i < p.count; i++) {
            range.near = fmin(range.near, p.at[i][2]);
            range.far = fmax(range.far, p.at[i][2]);
        }
    }
    if (inside && range.far >= near) range.near = near;
    return range;
}

/* ---- checks ---- */

/* Whether the cells in which a point may look itself up hold the light: two where its depth is on the border of slices. */
static bool holds_at(const struct list_copy *list, double x, double y, double depth, uint32_t light) {
    const struct gpu_light_list *g = &list->grid;
    uint32_t tile = (uint32_t)y / g->tile_size * g->tiles_x + (uint32_t)x / g->tile_size, tiles = g->tiles_x * g->tiles_y;
    return list_holds(list, list_slice_at(g, depth * (1 - 2e-6)) * tiles + tile, light) &&
           list_holds(list, list_slice_at(g, depth * (1 + 2e-6)) * tiles + tile, light);
}

/* No light misses a point that it reaches: points in the lights themselves. Returns how many of them are seen. `others`: another list, which
   may miss points; how many is counted. */
static uint64_t check_reached(const struct raster_request *r, const struct list_copy *list, struct random_state *random,
                              uint32_t tries, const struct list_copy *others, uint64_t *out_missed) {
    uint64_t seen = 0;
    for (uint32_t i = 0; i < r->light_count; i++) {
        const struct list_light *light = &lights[i];
        vec3 corners[8];
        shape_corners(&light->shape, &light->bounds, corners);
        for (uint32_t k = 0; k < tries; k++) {
            double point[3], view[3];
            float a = random_float(random), b = random_float(random), c = random_float(random);
            if (k % 4 == 0) a = a < 0.5f ? 0 : 1; /* on the sides */
            vec3 low = vec3_lerp(vec3_lerp(corners[0], corners[1], a), vec3_lerp(corners[2], corners[3], a), b),
                 high = vec3_lerp(vec3_lerp(corners[4], corners[5], a), vec3_lerp(corners[6], corners[7], a), b);
            vec3 at = vec3_lerp(low, high, c);
            if (light->shape.kind == GPU_SHAPE_SPHERE || (light->shape.kind == GPU_SHAPE_CONE && k % 2)) { /* near the rim */
                vec3 ray = vec3_sub(at, light->shape.position);
                float length = vec3_length(ray);
                if (length > 0) at = vec3_add_scaled(light->shape.position, ray, light->shape.range / length * (k % 3 ? 0.9999f : b));
            }
            point[0] = at.x, point[1] = at.y, point[2] = at.z;
            if (!light_reaches(&params[i], point)) continue;
            to_depth_space(&r->view, at, view);
            double spread = r->view.orthographic > 0.5f ? 1 : view[2];
            if (view[2] < (double)r->view.near_distance) continue;
            double x =
                ((view[0] / spread - (double)r->view.ndc_offset.x) / (double)r->view.ndc_scale.x + 1) / 2 * r->view.size.x;
            double y =
                (1 - (view[1] / spread - (double)r->view.ndc_offset.y) / (double)r->view.ndc_scale.y) / 2 * r->view.size.y;
            if (!(x >= 0 && y >= 0 && x < r->view.size.x && y < r->view.size.y)) continue;
            seen++;
            if (!holds_at(list, x, y, view[2], i))
                fail_msg("light %u of kind %u misses a point at (%g, %g), %g deep", i, light->shape.kind, x, y, view[2]);
            if (others) *out_missed += !holds_at(others, x, y, view[2], i);
        }
    }
    return seen;
}

/* A ball of 20 x 10 faces that encloses a sphere: a triangle is at most 18 degrees wide and high, so that its middle lies cos(12.8 degrees) as
   far out as its corners. */
enum { BALL_TRIANGLES = 2 * 20 * 9 };
static uint32_t ball_of(const struct gpu_entity_bounds *sphere, vec3 corners[3 * BALL_TRIANGLES]) {
    static const uint8_t order[2][3][2] = {{{0, 0}, {1, 1}, {0, 1}}, {{0, 0}, {1, 0}, {1, 1}}};
    uint32_t count = 0;
    for (uint32_t face = 0; face < 20 * 10; face++)
        for (uint32_t half = face / 20 == 9; half < (face / 20 ? 2 : 1); half++) /* one at the poles */
            for (uint32_t k = 0; k < 3; k++) {
                float turn = (float)M_PI / 10 * (float)(face % 20 + order[half][k][0]),
                      rise = (float)M_PI / 10 * (float)(face / 20 + order[half][k][1]);
                vec3 ray = {sinf(rise) * cosf(turn), cosf(rise), sinf(rise) * sinf(turn)};
                corners[count++] = vec3_add_scaled(sphere->center, ray, sphere->radius / 0.975f);
            }
    return count / 3;
}

/* Whether each light, or the mesh round it, touches each cell that lists it. Also counts what bounding spheres would list. */
static void check_tight(const struct raster_request *r, const struct list_copy *list, uint64_t *out_listed,
                        uint64_t *out_spheres, bool spots_only) {
    const struct gpu_light_list *g = &list->grid;
    struct list_request sphere_request = {.builder = LIST_CLUSTERED,
                                          .view = r->view,
                                          .lights = lights,
                                          .light_count = r->light_count,
                                          .clustered = r->raster.grid};
    double near = (double)r->view.near_distance / 2;
    for (uint32_t i = 0; i < r->light_count; i++) {
        vec3 corners[3 * BALL_TRIANGLES];
        uint32_t triangles = lights[i].shape.kind == GPU_SHAPE_SPHERE
                                 ? ball_of(&lights[i].bounds, corners)
                                 : light_mesh(&lights[i].shape, &lights[i].bounds, corners);
        for (uint32_t tile = 0; tile < g->tiles_x * g->tiles_y; tile++) {
            struct tile_range range = {1, 0};
            bool known = false;
            for (uint32_t slice = 0; slice < g->slices; slice++) {
                uint32_t cell = slice * g->tiles_x * g->tiles_y + tile;
                if (!spots_only || lights[i].shape.kind == GPU_SHAPE_CONE) {
                    struct reference_cell c = reference_cell_of(&sphere_request, g, cell, 0);
                    *out_spheres += reference_touches(&c, &sphere_request, i, 0, true);
                }
                if (!list_holds(list, cell, i)) continue;
                if (!spots_only || lights[i].shape.kind == GPU_SHAPE_CONE) ++*out_listed;
                if (!known) {
                    range = mesh_in_tile(&r->view, corners, triangles, g->tile_size, tile % g->tiles_x, tile / g->tiles_x,
                                         0.05, near);
                    known = true;
                }
                if (range.near > range.far || slice < list_slice_at(g, range.near * (1 - 3e-4) - 1e-4) ||
                    slice > list_slice_at(g, range.far * (1 + 3e-4) + 1e-4))
                    fail_msg("light %u of kind %u does not touch tile %u, slice %u (%g .. %g)", i, lights[i].shape.kind, tile,
                             slice, range.near, range.far);
            }
        }
    }
}

/* ---- meshes ---- */

/* How far a point is outside of a convex mesh. */
static double outside_by(const vec3 *corners, uint32_t triangles, const double point[3]) {
    double middle[3] = {0}, most = -1e300;
    for (uint32_t i = 0; i < triangles * 3; i++) {
        middle[0] += (double)corners[i].x / (triangles * 3);
        middle[1] += (double)corners[i].y / (triangles * 3);
        middle[2] += (double)corners[i].z / (triangles * 3);
    }
    for (uint32_t t = 0; t < triangles; t++) {
        double p[3][3], u[3], w[3], n[3], length = 0, side = 0, to_middle = 0;
        for (int i = 0; i < 3; i++) {
            p[i][0] = corners[t * 3 + i].x;
            p[i][1] = corners[t * 3 + i].y;
            p[i][2] = corners[t * 3 + i].z;
        }
        for (int k = 0; k < 3; k++) {
            u[k] = p[1][k] - p[0][k];
            w[k] = p[2][k] - p[0][k];
        }
        for (int k = 0; k < 3; k++) n[k] = u[(k + 1) % 3] * w[(k + 2) % 3] - u[(k + 2) % 3] * w[(k + 1) % 3];
        for (int k = 0; k < 3; k++) length += n[k] * n[k];
        length = sqrt(length);
        if (length < 1e-6) continue; /* a sliver has no direction */
        for (int k = 0; k < 3; k++) {
            side += n[k] / length * (point[k] - p[0][k]);
            to_middle += n[k] / length * (middle[k] - p[0][k]);
        }
        most = fmax(most, to_middle > 0 ? -side : side);
    }
    return most;
}

static void test_meshes_enclose_CL_2(void **state) {
    UNUSED(state);
    struct random_state random = {5};
    double closest = -1e300;
    for (uint32_t i = 0; i < 60; i++) {
        fnl_light_params light = fnl_light_params_default();
        light.position = vec3_make(random_range(&random, -9, 9), 3, random_range(&random, -9, 9));
        light.range = exp2f(random_range(&random, -3, 4));
        light.kind = FNL_LIGHT_SPOT;
        light.direction = vec3_normalize(
            vec3_make(random_range(&random, -1, 1), random_range(&random, -1, 1), random_range(&random, -1, 1)));
        light.outer_cone_angle = i == 1 ? 1.5707963f : i == 2 ? 0.001f : random_range(&random, 0.01f, 1.57f);
        light.inner_cone_angle = 0;
        struct list_light g = list_light_of(&light, 0);
        vec3 corners[3 * GPU_CONE_TRIANGLES];
        uint32_t triangles = light_mesh(&g.shape, &g.bounds, corners);
        assert_int_equal(triangles, GPU_CONE_TRIANGLES);
        for (uint32_t k = 0; k < 3000; k++) { /* on the rim, where meshes are nearest */
            vec3 ray = vec3_normalize(
                vec3_make(random_range(&random, -1, 1), random_range(&random, -1, 1), random_range(&random, -1, 1)));
            /* bend it into the cone, mostly to its edge */
            vec3 across = vec3_normalize(vec3_add_scaled(ray, light.direction, -vec3_dot(ray, light.direction)));
            float angle = light.outer_cone_angle * (k % 2 ? 0.99999f : random_float(&random));
            ray = vec3_add_scaled(vec3_scale(light.direction, cosf(angle)), across, sinf(angle));
            float distance = light.range * (k % 3 ? 0.99999f : random_float(&random));
            vec3 at = vec3_add_scaled(light.position, ray, distance);
            double outside = outside_by(corners, triangles, (double[]){at.x, at.y, at.z}) / (double)light.range;
            closest = fmax(closest, outside);
            if (outside > 2e-6) fail_msg("a mesh of kind %u leaves out a point by %g ranges", g.shape.kind, outside);
        }
    }
    print_message("meshes: the nearest point is %g ranges inside\n", -closest);
}

/* ---- sets ---- */

static void test_never_misses_and_tight_CL_2_CL_3_ES_60(void **state) {
    UNUSED(state);
    struct random_state random = {21};
    uint64_t seen = 0, listed = 0, spheres = 0;
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++) {
        struct gpu_view view = list_random_view(kind, &random, WIDTH - 3 * kind, HEIGHT + kind);
        list_random_shapes(&view, &random, LIGHTS, params, lights);
        struct raster_request r = raster_request_of(&view, lights, LIGHTS);
        r.raster.grid.linear = kind == 2;
        struct raster_copy copy = raster_build(&r), again = raster_build(&r);
        list_check_form(&copy.list, LIGHTS);
        assert_true(list_equal(&copy.list, &again.list));
        seen += check_reached(&r, &copy.list, &random, 200, NULL, NULL);
        check_tight(&r, &copy.list, &listed, &spheres, true);
        raster_copy_free(&copy);
        raster_copy_free(&again);
    }
    print_message("%llu points seen; spots: %llu entries, %llu by bounding spheres\n", (unsigned long long)seen,
                  (unsigned long long)listed, (unsigned long long)spheres);
    assert_true(seen > 20000);
    assert_true(listed > 1000 && (double)listed < 0.7 * (double)spheres);
}

/* Lights much smaller than a cell, on the edges of tiles and anywhere; and cones that are seen edge on. */
static void test_small_and_edge_on_ES_60(void **state) {
    UNUSED(state);
    struct random_state random = {77};
    struct gpu_view view = list_random_view(0, &random, WIDTH, HEIGHT);
    for (uint32_t i = 0; i < LIGHTS; i++) {
        double at[3], world[3], depth = (double)random_range(&random, 0.5f, 60), x = (double)random_range(&random, 0, WIDTH),
                                y = (double)random_range(&random, 0, HEIGHT);
        if (i % 3 == 0) x = floor(x / 32) * 32;
        if (i % 6 == 0) y = floor(y / 32) * 32;
        view_of_pixel(&view, x, y, depth, at);
        view_to_world(&view, at, world);
        params[i] = fnl_light_params_default();
        params[i].position = vec3_make((float)world[0], (float)world[1], (float)world[2]);
        params[i].range = 1e-3f * (float)depth;
        if (i % 2) { /* its axis in a plane through the eye: half of the sides are seen edge on */
            params[i].kind = FNL_LIGHT_SPOT;
            params[i].direction = vec3_normalize(vec3_sub(params[i].position, view.eye));
            if (i % 4 == 1) params[i].direction = vec3_scale(params[i].direction, -1);
            params[i].outer_cone_angle = 0.02f;
            params[i].inner_cone_angle = 0;
            params[i].range = 5;
        }
        lights[i] = list_light_of(&params[i], i);
    }
    struct raster_request r = raster_request_of(&view, lights, LIGHTS);
    struct raster_copy copy = raster_build(&r);
    assert_true(check_reached(&r, &copy.list, &random, 300, NULL, NULL) > 5000);
    uint64_t listed = 0, spheres = 0;
    check_tight(&r, &copy.list, &listed, &spheres, false);
    raster_copy_free(&copy);
}

/* First and last slice that the shell of a light gives a tile of its rectangle; first > last: none. */
static void shell_at(const struct raster_copy *copy, uint32_t index, uint32_t slot, uint32_t out[2]) {
    const struct gpu_raster_slot *s = &copy->slots[slot];
    uint32_t slices = copy->rectangles[index].slices;
    out[0] = 1, out[1] = 0;
    if (s->last == RASTER_UNSET) return;
    out[0] = s->first == RASTER_UNSET ? slices & 0xffff : MAX(slices & 0xffff, s->first);
    out[1] = MIN(slices >> 16, 0xffff - s->last);
}

/* Compares the shells of two ways to make them: `inner` lies within `outer`. Returns the tiles that inner lacks. */
static uint32_t check_within(const struct raster_request *r, const struct raster_copy *inner,
                             const struct raster_copy *outer, uint32_t *out_tiles, uint32_t *out_looser) {
    uint32_t missing = 0;
    assert_memory_equal(inner->slot_sums, outer->slot_sums, (r->light_count + 1) * 4);
    for (uint32_t i = 0; i < inner->list.totals.in_view; i++)
        for (uint32_t slot = inner->slot_sums[i]; slot < inner->slot_sums[i + 1]; slot++) {
            uint32_t a[2], b[2];
            shell_at(inner, i, slot, a);
            shell_at(outer, i, slot, b);
            if (b[0] > b[1]) {
                assert_true(a[0] > a[1]);
                continue;
            }
            ++*out_tiles;
            missing += a[0] > a[1];
            if (a[0] > a[1]) continue;
            /* Without the faces that it has missed, the inner one may take the viewer to be inside. */
            assert_true((inner->slots[slot].first == RASTER_UNSET || a[0] >= b[0]) && a[1] <= b[1]);
            *out_looser += a[0] != b[0] || a[1] != b[1];
        }
    return missing;
}

/*
 * Rasterising by the middles of tiles, as hardware does by itself, leaves lit points without their light. It is the same draw as that of the
 * hardware path but for one switch, so what it finds must lie within the shells of the software path.
 */
static void test_centers_miss_CL_4(void **state) {
    UNUSED(state);
    struct random_state random = {6};
    uint32_t tiles = 0, missing = 0, looser = 0;
    uint64_t lit = 0, lit_missing = 0;
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++) {
        struct gpu_view view = list_random_view(kind, &random, WIDTH + kind, HEIGHT);
        list_random_shapes(&view, &random, LIGHTS, params, lights);
        struct raster_request r = raster_request_of(&view, lights, LIGHTS);
        struct raster_copy software = raster_build(&r);
        r.raster.centers = true;
        struct raster_copy centers = raster_build(&r);
        list_check_form(&centers.list, LIGHTS);
        missing += check_within(&r, &centers, &software, &tiles, &looser);
        lit += check_reached(&r, &software.list, &random, 100, &centers.list, &lit_missing);
        raster_copy_free(&centers);
        raster_copy_free(&software);
    }
    print_message("of %u tiles under lights, middles miss %u and cut %u short; %llu of %llu lit points lose their light\n",
                  tiles, missing, looser, (unsigned long long)lit_missing, (unsigned long long)lit);
    assert_true(missing > tiles / 40 && lit_missing > 10);
}

/* On a device that can: the draw finds what the compute shader finds, and nothing else. */
static void test_hardware_shells(void **state) {
    UNUSED(state);
    struct random_state random = {61};
    if (!gpu_info(harness_device())->conservative_raster) {
        print_message("%s does not rasterise conservatively: skipped\n", gpu_info(harness_device())->name);
        skip();
    }
    uint32_t tiles = 0, looser = 0;
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++) {
        struct gpu_view view = list_random_view(kind, &random, WIDTH, HEIGHT);
        list_random_shapes(&view, &random, LIGHTS, params, lights);
        struct raster_request r = raster_request_of(&view, lights, LIGHTS);
        struct raster_copy hardware = raster_build(&r);
        assert_true(raster_on_hardware(harness_device(), &r.raster));
        r.raster.path = RASTER_PATH_SOFTWARE;
        struct raster_copy software = raster_build(&r);
        assert_true(check_reached(&r, &hardware.list, &random, 100, NULL, NULL) > 1000);
        /* Where either finds a tile that the other does not, the triangle only touches its widened edge. */
        uint32_t missing = check_within(&r, &hardware, &software, &tiles, &looser);
        assert_true(missing + looser <= tiles / 100);
        raster_copy_free(&hardware);
        raster_copy_free(&software);
    }
}

/* Shells against double precision: what the software path finds is what the mesh covers, or by a rounding more. */
static void test_software_shells(void **state) {
    UNUSED(state);
    struct random_state random = {62};
    uint32_t tiles = 0, more = 0;
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++) {
        struct gpu_view view = list_random_view(kind, &random, WIDTH, HEIGHT);
        list_random_shapes(&view, &random, LIGHTS, params, lights);
        struct raster_request r = raster_request_of(&view, lights, LIGHTS);
        r.raster.path = RASTER_PATH_SOFTWARE;
        struct raster_copy copy = raster_build(&r);
        const struct gpu_light_list *g = &copy.list.grid;
        double near = (double)view.near_distance / 2;
        for (uint32_t i = 0; i < copy.list.totals.in_view; i++) {
            uint32_t light = copy.visible[i];
            if (lights[light].shape.kind == GPU_SHAPE_SPHERE) continue; /* check_tight() and check_reached() look at them */
            vec3 corners[3 * GPU_CONE_TRIANGLES];
            uint32_t triangles = light_mesh(&lights[light].shape, &lights[light].bounds, corners);
            struct gpu_raster_light q = copy.rectangles[i];
            for (uint32_t slot = copy.slot_sums[i]; slot < copy.slot_sums[i + 1]; slot++) {
                uint32_t width = (q.columns >> 16) - (q.columns & 0xffff) + 1, at = slot - copy.slot_sums[i], found[2];
                struct tile_range exact =
                    mesh_in_tile(&view, corners, triangles, g->tile_size, (q.columns & 0xffff) + at % width,
                                 (q.rows & 0xffff) + at / width, 0, near);
                shell_at(&copy, i, slot, found);
                if (exact.near > exact.far) {
                    more += found[0] <= found[1]; /* it touches the tile's widened edge */
                    continue;
                }
                uint32_t first = MAX(list_slice_at(g, exact.near), q.slices & 0xffff),
                         last = MIN(list_slice_at(g, exact.far), q.slices >> 16);
                if (first > last)
                    continue; /* only the part of the mesh that sticks out of the light's sphere is in the tile */
                tiles++;
                assert_true(found[0] <= first && found[1] >= last);
                more += found[0] < first || found[1] > last;
            }
        }
        raster_copy_free(&copy);
    }
    print_message("of %u tiles under lights %u have more slices than the mesh, by rounding\n", tiles, more);
    assert_true(tiles > 2000 && more <= tiles / 200);
}

static void test_grids_CL_5(void **state) {
    UNUSED(state);
    static const uint32_t grids[6][2] = {{64, 32}, {64, 64}, {64, 128}, {32, 32}, {32, 64}, {32, 128}};
    static const uint32_t counts[3] = {1024, 2048, 4096};
    struct random_state random = {12};
    for (uint32_t k = 0; k < 12; k++) { /* each grid with both distributions of slices, each of those with every count of lights */
        uint32_t count = counts[(k + k / 6) % 3];
        struct gpu_view view = list_random_view(0, &random, 1536, 768);
        list_random_shapes(&view, &random, count, params, lights);
        for (uint32_t i = 0; i < count; i++) { /* many, and small */
            params[i].range *= 0.15f;
            params[i].box_size = vec3_scale(params[i].box_size, 0.15f);
            lights[i] = list_light_of(&params[i], i);
        }
        struct raster_request r = raster_request_of(&view, lights, count);
        r.raster.grid.tile_size = grids[k % 6][0];
        r.raster.grid.slices = grids[k % 6][1];
        r.raster.grid.linear = k / 6;
        r.raster.grid.pool_capacity = 1u << 23;
        struct raster_copy copy = raster_build(&r);
        assert_int_equal(copy.list.grid.tiles_x, 1536 / grids[k % 6][0]);
        assert_int_equal(copy.list.totals.overflow_cells, 0);
        list_check_form(&copy.list, count);
        assert_true(check_reached(&r, &copy.list, &random, 4, NULL, NULL) > 500);
        raster_copy_free(&copy);
    }
}

/* ---- variants ---- */

static void test_gradients_ES_61(void **state) {
    UNUSED(state);
    struct random_state random = {17};
    uint64_t exact_entries = 0, gradient_entries = 0;
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++) {
        struct gpu_view view = list_random_view(kind, &random, WIDTH, HEIGHT);
        list_random_shapes(&view, &random, LIGHTS, params, lights);
        struct raster_request r = raster_request_of(&view, lights, LIGHTS);
        struct raster_copy exact = raster_build(&r);
        r.raster.gradient = true;
        struct raster_copy gradient = raster_build(&r);
        list_check_form(&gradient.list, LIGHTS);
        for (uint32_t c = 0; c < exact.list.cell_count; c++)
            for (uint32_t i = 0; i < exact.list.cells[c].count; i++)
                assert_true(list_holds(&gradient.list, c, exact.list.ids[exact.list.cells[c].offset + i]));
        exact_entries += exact.list.totals.entries;
        gradient_entries += gradient.list.totals.entries;
        raster_copy_free(&exact);
        raster_copy_free(&gradient);
    }
    print_message("gradients: %.3f of the exact entries\n", (double)gradient_entries / (double)exact_entries);
    assert_true(gradient_entries > exact_entries && (double)gradient_entries < 1.5 * (double)exact_entries);
}

/* A spot above a floor with balls: what it sees, and what reaches past the balls. */
struct ball {
    double center[3], radius;
};
static const struct ball balls[] = {
    {{-1.2, 1, 0.5}, 0.7}, {{0.6, 2, -0.4}, 0.8}, {{1.5, 0.6, 1.2}, 0.5}, {{-0.3, 3.2, -1}, 0.4}};

static double hit_distance(const double from[3], const double ray[3]) {
    double nearest = ray[1] < 0 ? -from[1] / ray[1] : INFINITY;
    for (uint32_t b = 0; b < COUNT_OF(balls); b++) {
        double d[3], along = 0, square = 0, length2 = 0;
        for (int k = 0; k < 3; k++) {
            d[k] = from[k] - balls[b].center[k];
            along += d[k] * ray[k];
            square += d[k] * d[k];
            length2 += ray[k] * ray[k];
        }
        double root = along * along - length2 * (square - balls[b].radius * balls[b].radius);
        if (root > 0 && -along > sqrt(root)) nearest = fmin(nearest, (-along - sqrt(root)) / length2);
    }
    return nearest;
}

static void test_shadow_meshes_ES_63(void **state) {
    UNUSED(state);
    enum { SIZE = 64, BLOCKS = 8 };
    static float depth[SIZE * SIZE];
    static vec3 corners[36 * BLOCKS * BLOCKS];
    params[0] = fnl_light_params_default();
    params[0].kind = FNL_LIGHT_SPOT;
    params[0].position = vec3_make(0, 6, 0);
    params[0].direction = vec3_normalize(vec3_make(0.1f, -1, 0.05f));
    params[0].range = 12;
    params[0].outer_cone_angle = 0.5f;
    lights[0] = list_light_of(&params[0], 0);
    vec3 up = vec3_cross(lights[0].shape.side, lights[0].shape.direction);
    double tangent = tan(0.5), from[3] = {0, 6, 0};
    const double side[3] = {lights[0].shape.side.x, lights[0].shape.side.y, lights[0].shape.side.z}, above[3] = {up.x, up.y, up.z},
                 along[3] = {lights[0].shape.direction.x, lights[0].shape.direction.y, lights[0].shape.direction.z};
    double ray[3];
    for (uint32_t y = 0; y < SIZE; y++)
        for (uint32_t x = 0; x < SIZE; x++) { /* the farthest of several rays: a shadow map of maxima */
            double far = 0;
            for (int k = 0; k < 81; k++) {
                double u = (2 * (x + k % 9 / 8.0) / SIZE - 1) * tangent, v = (1 - 2 * (y + k / 9 / 8.0) / SIZE) * tangent;
                for (int a = 0; a < 3; a++) ray[a] = along[a] + u * side[a] + v * above[a];
                far = fmax(far, hit_distance(from, ray));
            }
            depth[y * SIZE + x] = (float)far;
        }
    uint32_t triangles = light_mesh_from_depth(&lights[0].shape, depth, SIZE, BLOCKS, corners);
    assert_true(triangles > 6 * 40 && triangles <= 12 * BLOCKS * BLOCKS);
    fnl_camera camera = fnl_camera_default();
    camera.position = vec3_make(8, 4, 9);
    camera.target = vec3_make(0, 2, 0);
    struct gpu_view view = view_from_camera(&camera, WIDTH, HEIGHT);
    struct raster_request r = raster_request_of(&view, lights, 1);
    r.raster.grid.tile_size = 8;
    r.raster.grid.slices = 64;
    r.raster.grid.near = 2;
    r.raster.grid.far = 40;
    struct raster_copy cone = raster_build(&r);
    struct gpu_raster_mesh mesh = {0, triangles};
    r.meshes = &mesh;
    r.points = corners;
    r.point_count = triangles * 3;
    struct raster_copy shadowed = raster_build(&r);
    list_check_form(&shadowed.list, 1);
    struct random_state random = {8};
    uint32_t lit = 0;
    for (uint32_t k = 0; k < 20000; k++) { /* surfaces and air that see the light */
        double u = (double)random_range(&random, -1, 1) * tangent, v = (double)random_range(&random, -1, 1) * tangent,
               point[3], seen[3];
        for (int a = 0; a < 3; a++) ray[a] = along[a] + u * side[a] + v * above[a];
        double distance = fmin(hit_distance(from, ray), 20) * (k % 2 ? 1 : (double)random_float(&random));
        for (int a = 0; a < 3; a++) point[a] = from[a] + ray[a] * distance;
        if (!light_reaches(&params[0], point)) continue;
        to_depth_space(&view, vec3_make((float)point[0], (float)point[1], (float)point[2]), seen);
        double x = (seen[0] / seen[2] / (double)view.ndc_scale.x + 1) / 2 * WIDTH,
               y = (1 - seen[1] / seen[2] / (double)view.ndc_scale.y) / 2 * HEIGHT;
        if (!(x >= 0 && y >= 0 && x < WIDTH && y < HEIGHT)) continue;
        assert_true(holds_at(&shadowed.list, x, y, seen[2], 0));
        lit++;
    }
    print_message("shadowed spot: %u lit points, %u clusters instead of %u\n", lit, shadowed.list.totals.entries,
                  cone.list.totals.entries);
    assert_true(lit > 5000);
    assert_true(shadowed.list.totals.entries < cone.list.totals.entries * 8 / 10);
    /* What it cannot stand for. */
    assert_int_equal(light_mesh_from_depth(&lights[0].shape, depth, SIZE, 7, corners), 0);
    params[0].kind = FNL_LIGHT_POINT;
    struct list_light point_light = list_light_of(&params[0], 0);
    assert_int_equal(light_mesh_from_depth(&point_light.shape, depth, SIZE, BLOCKS, corners), 0);
    raster_copy_free(&cone);
    raster_copy_free(&shadowed);
}

/* A light that a convex hull bounds is drawn as that hull. */
static void test_hull_meshes_CL_2(void **state) {
    UNUSED(state);
    struct random_state random = {41};
    static vec3 corners[3 * 4 * 64 * 64];
    uint32_t smaller = 0;
    for (uint32_t k = 0; k < 12; k++) {
        struct gpu_view view = list_random_view(k % LIST_VIEWS, &random, WIDTH, HEIGHT);
        double at[3], world[3];
        view_of_pixel(&view, 150, 80, 12, at);
        view_to_world(&view, at, world);
        params[0] = fnl_light_params_default();
        params[0].position = vec3_make((float)world[0], (float)world[1], (float)world[2]);
        params[0].range = 20;
        lights[0] = list_light_of(&params[0], 0);
        vec3 points[14];
        for (uint32_t i = 0; i < 14; i++)
            points[i] = vec3_add(params[0].position, vec3_make(random_range(&random, -3, 3), random_range(&random, -3, 3),
                                                               random_range(&random, -3, 3)));
        struct light_hull *hull;
        assert_int_equal(light_hull_create(gpu_host(harness_device()), points, 14, &hull), FNL_OK);
        vec4 planes[LIGHT_HULL_PLANES_MAX];
        vec3 origin = params[0].position;
        for (uint32_t i = 0; i < hull->plane_count; i++) {
            const double *n = hull->planes[i];
            planes[i] = (vec4){(float)n[0], (float)n[1], (float)n[2],
                               (float)-(n[0] * (double)origin.x + n[1] * (double)origin.y + n[2] * (double)origin.z + n[3])};
        }
        uint32_t triangles = light_mesh_from_planes(origin, planes, hull->plane_count, 20, corners);
        assert_true(triangles >= 4 && triangles <= 4 * hull->plane_count * hull->plane_count);
        assert_int_equal(light_mesh_from_planes(origin, planes, 3, 20, corners + 3 * triangles), 0); /* never closed */
        struct raster_request r = raster_request_of(&view, lights, 1);
        r.raster.grid.tile_size = 16;
        struct raster_copy sphere = raster_build(&r);
        struct gpu_raster_mesh mesh = {0, triangles};
        r.meshes = &mesh;
        r.points = corners;
        r.point_count = triangles * 3;
        struct raster_copy exact = raster_build(&r);
        list_check_form(&exact.list, 1);
        for (uint32_t p = 0; p < 4000; p++) { /* points between the hull's corners */
            vec3 in = points[p % 14];
            for (int i = 0; i < 4; i++) in = vec3_lerp(in, points[random_bits(&random) % 14], random_float(&random));
            double seen[3];
            to_depth_space(&view, in, seen);
            double spread = view.orthographic > 0.5f ? 1 : seen[2];
            if (seen[2] < (double)view.near_distance) continue;
            double x = ((seen[0] / spread - (double)view.ndc_offset.x) / (double)view.ndc_scale.x + 1) / 2 * WIDTH,
                   y = (1 - (seen[1] / spread - (double)view.ndc_offset.y) / (double)view.ndc_scale.y) / 2 * HEIGHT;
            if (!(x >= 0 && y >= 0 && x < WIDTH && y < HEIGHT)) continue;
            assert_true(holds_at(&exact.list, x, y, seen[2], 0));
        }
        smaller += exact.list.totals.entries * 2 < sphere.list.totals.entries;
        host_free(gpu_host(harness_device()), hull, sizeof *hull);
        raster_copy_free(&sphere);
        raster_copy_free(&exact);
    }
    assert_true(smaller >= 10);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_meshes_enclose_CL_2),
        cmocka_unit_test_teardown(test_never_misses_and_tight_CL_2_CL_3_ES_60, harness_check),
        cmocka_unit_test_teardown(test_small_and_edge_on_ES_60, harness_check),
        cmocka_unit_test_teardown(test_centers_miss_CL_4, harness_check),
        cmocka_unit_test_teardown(test_software_shells, harness_check),
        cmocka_unit_test_teardown(test_hardware_shells, harness_check),
        cmocka_unit_test_teardown(test_grids_CL_5, harness_check),
        cmocka_unit_test_teardown(test_gradients_ES_61, harness_check),
        cmocka_unit_test_teardown(test_shadow_meshes_ES_63, harness_check),
        cmocka_unit_test_teardown(test_hull_meshes_CL_2, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
