/* SPDX-License-Identifier: MIT */
/**
 * Fine-pruned tiles, entry by entry and bit by bit: built on the device, compared with the lights' volumes in double precision at the
 * pixels' positions; then whole frames.
 */
#include "tests/list_bench.h"

#include "passes/lights/fine.h"
#include "passes/lights/light_proxy.h"
#include "tests/light_reference.h"

enum { LIGHTS_MAX = 6000, WIDTH = 109, HEIGHT = 61 };

static fnl_light_params params[LIGHTS_MAX];
static struct gpu_light lights[LIGHTS_MAX];

/* ---- building and reading back ---- */

enum { COPY_CELLS, COPY_IDS, COPY_EXTRA, COPY_BOXES, COPY_VISIBLE, COPY_TOTALS, COPY_COUNT };

struct fine_copy {
    void *data[COPY_COUNT];
    uint64_t sizes[COPY_COUNT];
    struct light_totals totals;
    uint32_t tile_size, tiles_x, tiles_y, cell_count, mask_size;
};

/* `front`: depth of blended surfaces, or NULL. */
static struct fine_copy build(const struct gpu_view *view, uint32_t light_count, const float *depth, const float *front,
                              const struct fine_params *given) {
    struct list_lab lab = list_lab_open(view, lights, light_count);
    struct fine_params p = *given;
    graph_image depth_handle = list_lab_depth(&lab, depth);
    p.blend_depth = list_lab_depth(&lab, front);
    p.eye_distance = vec3_length(view->eye);
    list_lab_begin(&lab);
    struct fine_lists lists = fine_add(lab.graph, harness_device(), &lab.input, &lab.in_view, depth_handle, &p);
    struct fine_copy copy = {.tile_size = p.tile_size,
                             .tiles_x = DIVIDE_UP(view->size.x, p.tile_size),
                             .tiles_y = DIVIDE_UP(view->size.y, p.tile_size),
                             .cell_count = lists.lights.cell_count,
                             .mask_size = depth && p.pruning ? MIN(p.mask_size, p.tile_size / 8) : 0};
    list_lab_run(&lab,
                 (graph_buffer[COPY_COUNT]){lists.lights.cells, lists.lights.ids, lists.lights.extra, lists.boxes,
                                            lab.in_view.ids, lists.lights.totals},
                 COPY_COUNT);
    for (uint32_t i = 0; i < COPY_COUNT; i++) {
        copy.data[i] = list_reads_take(&lab.reads, i);
        copy.sizes[i] = lab.reads.buffers[i].size;
    }
    memcpy(&copy.totals, copy.data[COPY_TOTALS], sizeof copy.totals);
    list_lab_close(&lab);
    return copy;
}

static void copy_free(struct fine_copy *copy) {
    for (int i = 0; i < COPY_COUNT; i++) free(copy->data[i]);
}

static struct gpu_cell cell_at(const struct fine_copy *c, uint32_t cell) {
    return ((struct gpu_cell *)c->data[COPY_CELLS])[cell];
}
static const uint32_t *ids_at(const struct fine_copy *c, uint32_t cell) {
    return (const uint32_t *)c->data[COPY_IDS] + cell_at(c, cell).offset;
}

static struct list_copy list_of(const struct fine_copy *c) {
    return (struct list_copy){
        .cells = c->data[COPY_CELLS], .ids = c->data[COPY_IDS], .cell_count = c->cell_count, .totals = c->totals};
}

static bool holds(const struct fine_copy *c, uint32_t cell, uint32_t light) {
    struct list_copy list = list_of(c);
    return list_holds(&list, cell, light);
}

/* Whether a pixel visits entry `entry` of its cell, as shaders/lights/fine.glsl finds it. */
static bool visits(const struct fine_copy *c, uint32_t cell, uint32_t x, uint32_t y, uint32_t entry) {
    if (!c->mask_size) return true;
    struct gpu_cell at = cell_at(c, cell);
    uint32_t side = c->tile_size / c->mask_size, words = (at.count + 31) / 32;
    uint32_t square = y % c->tile_size / c->mask_size * side + x % c->tile_size / c->mask_size;
    uint64_t word = (uint64_t)(at.offset / 32 + cell) * side * side + square * words + entry / 32;
    assert_true((word + 1) * 4 <= c->sizes[COPY_EXTRA]);
    return ((const uint32_t *)c->data[COPY_EXTRA])[word] >> entry % 32 & 1;
}

static void check_form(const struct fine_copy *c, uint32_t light_count) {
    struct list_copy list = list_of(c);
    list_check_form(&list, light_count);
    assert_int_equal(c->totals.overflow_cells, 0);
}

static bool is_equal(const struct fine_copy *a, const struct fine_copy *b, const struct gpu_view *view) {
    struct list_copy lists[] = {list_of(a), list_of(b)};
    if (!list_equal(&lists[0], &lists[1])) return false;
    for (uint32_t y = 0; y < view->size.y; y++)
        for (uint32_t x = 0; x < view->size.x; x++) {
            uint32_t cell = y / a->tile_size * a->tiles_x + x / a->tile_size;
            for (uint32_t i = 0; i < cell_at(a, cell).count; i++)
                if (visits(a, cell, x, y, i) != visits(b, cell, x, y, i)) return false;
        }
    return true;
}

/* ---- the reference ---- */

static double length_of(const double v[3]) { return sqrt(light_dot(v, v)); }

/* Whether the light's volume, widened by what the builder may allow itself, holds the point. */
static bool nearly_reaches(const struct gpu_view *view, const fnl_light_params *light, const double point[3]) {
    double axes[3][3], from[3], at[3], range = light_reference_range(light);
    double slack = 4e-5 * (length_of(point) + (double)vec3_length(view->eye)) + 1e-5 * range;
    const float origin[3] = {light->position.x, light->position.y, light->position.z};
    for (int i = 0; i < 3; i++) from[i] = point[i] - (double)origin[i];
    double distance = length_of(from);
    if (light->kind == FNL_LIGHT_POINT) return distance <= range + slack;
    light_axes(light, axes);
    for (int i = 0; i < 3; i++) at[i] = light_dot(from, axes[i]);
    switch (light->kind) {
    case FNL_LIGHT_SPOT:
        return distance <= range + slack &&
               at[2] + 2 * slack + 4e-6 * distance >= cos((double)light->outer_cone_angle) * distance;
    case FNL_LIGHT_CAPSULE: {
        double half = (double)light->length / 2, along = fmin(fmax(at[2], -half), half);
        return sqrt(at[0] * at[0] + at[1] * at[1] + (at[2] - along) * (at[2] - along)) <= range + slack;
    }
    case FNL_LIGHT_WEDGE:
        return distance <= range + slack && at[2] >= -slack &&
               fabs(at[0]) <= tan((double)light->wedge_angles[0]) * (at[2] + slack) + slack &&
               fabs(at[1]) <= tan((double)light->wedge_angles[1]) * (at[2] + slack) + slack;
    default:
        return fabs(at[0]) <= (double)light->box_size.x / 2 + slack &&
               fabs(at[1]) <= (double)light->box_size.y / 2 + slack && fabs(at[2]) <= (double)light->box_size.z / 2 + slack;
    }
}

/*
 * The lists of opaque surfaces: a tile holds each light that reaches one of its pixels, and none that comes near to none; a pixel's mask
 * the same. Returns the pairs of pixel and light that are lit.
 */
static uint64_t check_sets(const struct gpu_view *view, const float *depth, uint32_t light_count,
                           const struct fine_copy *c) {
    uint64_t lit = 0;
    uint32_t tile_count = c->tiles_x * c->tiles_y;
    uint8_t *near = calloc((size_t)tile_count * light_count + 1, 1);
    assert_non_null(near);
    for (uint32_t y = 0; y < view->size.y; y++)
        for (uint32_t x = 0; x < view->size.x; x++) {
            double point[3];
            uint32_t cell = y / c->tile_size * c->tiles_x + x / c->tile_size, count = cell_at(c, cell).count, entry = 0;
            bool solid = list_position_of(view, depth, x, y, point);
            for (uint32_t light = 0; light < light_count; light++) {
                while (entry < count && ids_at(c, cell)[entry] < light) entry++;
                bool held = entry < count && ids_at(c, cell)[entry] == light, visited = held && visits(c, cell, x, y, entry);
                bool reached = solid && light_reaches(&params[light], point);
                bool nearly = solid && nearly_reaches(view, &params[light], point);
                assert_true(nearly || !reached);
                if (reached && !visited)
                    fail_msg("pixel %u %u misses light %u, a %s", x, y, light, fnl_light_kind_name(params[light].kind));
                if (c->mask_size == 1 && visited && !nearly)
                    fail_msg("pixel %u %u visits light %u, a %s far from it", x, y, light,
                             fnl_light_kind_name(params[light].kind));
                if (nearly) near[(size_t)cell * light_count + light] = 1;
                lit += reached;
            }
        }
    for (uint32_t cell = 0; cell < tile_count; cell++)
        for (uint32_t i = 0; i < cell_at(c, cell).count; i++)
            if (!near[(size_t)cell * light_count + ids_at(c, cell)[i]])
                fail_msg("tile %u holds light %u, which reaches none of its pixels", cell, ids_at(c, cell)[i]);
    free(near);
    return lit;
}

/* Lights of all five shapes before and around the viewer. */
static void random_lights(const struct gpu_view *view, struct random_state *random, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) {
        fnl_light_params light = fnl_light_params_default();
        double seen[3], world[3], depth = exp2((double)random_range(random, -1, 5));
        view_of_pixel(view, (double)random_range(random, -0.2f, 1.2f) * view->size.x,
                      (double)random_range(random, -0.2f, 1.2f) * view->size.y, i % 11 == 3 ? -depth * 0.1 : depth, seen);
        view_to_world(view, seen, world);
        light.kind = (fnl_light_kind)(FNL_LIGHT_POINT + i % 5);
        light.position = vec3_make((float)world[0], (float)world[1], (float)world[2]);
        light.range = exp2f(random_range(random, -2, 3.5f));
        light.direction =
            vec3_normalize(vec3_make(random_range(random, -1, 1), random_range(random, -1, 1), random_range(random, -1, 1)));
        light.up = vec3_normalize(vec3_cross(light.direction, vec3_make(0.3f, 1, 0.1f)));
        light.outer_cone_angle = random_range(random, 0.04f, 1.57f);
        light.inner_cone_angle = light.outer_cone_angle * random_range(random, 0, 0.99f);
        light.length = random_range(random, 0, 6);
        light.wedge_angles[0] = random_range(random, 0.02f, 1.4f);
        light.wedge_angles[1] = random_range(random, 0.02f, 1.4f);
        light.box_size =
            vec3_make(random_range(random, 0.1f, 8), random_range(random, 0.1f, 8), random_range(random, 0.1f, 8));
        params[i] = light;
        lights[i] = device_light(&light);
    }
}

/* ---- the sets ---- */

static void test_sets_FP_2_FP_3_FP_14_ES_47(void **state) {
    UNUSED(state);
    static const struct { uint32_t tile_size, mask_size; } sizes[] = {{16, 1}, {16, 2}, {8, 1}, {32, 2}, {64, 1}};
    enum { LIGHTS = 150 };
    struct random_state random = {3};
    uint64_t lit = 0, fine_entries = 0, coarse_entries = 0;
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++) {
        struct gpu_view view = list_random_view(kind, &random, WIDTH + kind, HEIGHT);
        random_lights(&view, &random, LIGHTS);
        float *depth = list_random_depth(&view, &random);
        struct fine_params p = fine_params_default();
        p.tile_size = sizes[kind].tile_size;
        p.mask_size = sizes[kind].mask_size;
        p.pool_capacity = 1 << 16; /* so that masks for tiles of 64 pixels stay small enough to be made */
        struct fine_copy fine = build(&view, LIGHTS, depth, NULL, &p), again = build(&view, LIGHTS, depth, NULL, &p);
        p.pruning = false;
        struct fine_copy coarse = build(&view, LIGHTS, depth, NULL, &p);
        check_form(&fine, LIGHTS);
        check_form(&coarse, LIGHTS);
        assert_true(is_equal(&fine, &again, &view));
        lit += check_sets(&view, depth, LIGHTS, &fine);
        assert_int_equal(fine.cell_count, coarse.cell_count);
        for (uint32_t cell = 0; cell < fine.cell_count; cell++) {
            assert_true(cell_at(&fine, cell).count <= cell_at(&coarse, cell).count);
            for (uint32_t i = 0; i < cell_at(&fine, cell).count; i++)
                assert_true(holds(&coarse, cell, ids_at(&fine, cell)[i]));
        }
        fine_entries += fine.totals.entries;
        coarse_entries += coarse.totals.entries;
        copy_free(&fine);
        copy_free(&again);
        copy_free(&coarse);
        free(depth);
    }
    print_message("entries: %llu by boxes, %llu by pixels\n", (unsigned long long)coarse_entries,
                  (unsigned long long)fine_entries);
    assert_true(lit > 30000);
    assert_true((double)fine_entries < 0.8 * (double)coarse_entries);
}

/* Sizes that no tile divides, tiles of nothing but sky, no lights. */
static void test_sizes_and_sky_FP_11(void **state) {
    UNUSED(state);
    static const uint32_t sizes[][2] = {{1, 1}, {1, 67}, {15, 16}, {33, 1}};
    struct random_state random = {5};
    for (uint32_t s = 0; s < COUNT_OF(sizes); s++)
        for (uint32_t count = 0; count <= 40; count += 40) {
            struct gpu_view view = list_random_view(0, &random, sizes[s][0], sizes[s][1]);
            random_lights(&view, &random, count);
            float *depth = list_random_depth(&view, &random);
            struct fine_params p = fine_params_default();
            struct fine_copy c = build(&view, count, depth, NULL, &p);
            check_form(&c, count);
            check_sets(&view, depth, count, &c);
            copy_free(&c);
            for (uint32_t i = 0; i < sizes[s][0] * sizes[s][1]; i++) depth[i] = 0;
            c = build(&view, count, depth, NULL, &p);
            assert_int_equal(c.totals.entries, 0);
            copy_free(&c);
            free(depth);
        }
}

/* The viewer inside of every shape, at its middle and at its rim. */
static void test_camera_inside_FP_11(void **state) {
    UNUSED(state);
    struct random_state random = {8};
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++) {
        struct gpu_view view = list_random_view(kind, &random, 48, 32);
        float *depth = list_random_depth(&view, &random);
        enum { LIGHTS = 60 };
        random_lights(&view, &random, LIGHTS);
        for (uint32_t i = 0; i < LIGHTS; i++) {
            double t = i < 20 ? 0 : i < 40 ? 0.5 : 0.97;
            params[i].range = 4 + (float)(i % 7) * 6;
            params[i].position = vec3_add_scaled(view.eye, params[i].direction, (float)-t * params[i].range);
            params[i].outer_cone_angle = 0.3f + 0.2f * (float)(i % 5);
            params[i].box_size = vec3_make(params[i].range, params[i].range, 2 * params[i].range);
            lights[i] = device_light(&params[i]);
        }
        struct fine_params p = fine_params_default();
        struct fine_copy c = build(&view, LIGHTS, depth, NULL, &p);
        check_form(&c, LIGHTS);
        assert_true(check_sets(&view, depth, LIGHTS, &c) > 1000);
        copy_free(&c);
        free(depth);
    }
}

/* One light's broken numbers do not take others along. */
static void test_broken_lights(void **state) {
    UNUSED(state);
    struct random_state random = {9};
    enum { LIGHTS = 60 };
    struct gpu_view view = list_random_view(0, &random, 64, 48);
    random_lights(&view, &random, LIGHTS);
    float *depth = list_random_depth(&view, &random);
    struct fine_params p = fine_params_default();
    struct gpu_light dark = lights[7], lost = lights[12], endless = lights[20];
    lights[7].bound_radius = lights[12].bound_radius = lights[20].bound_radius = 0;
    struct fine_copy without = build(&view, LIGHTS, depth, NULL, &p);
    lights[12] = lost;
    lights[20] = endless;
    lights[12].position.y = lights[12].bound_center.y = NAN;
    lights[20].range = lights[20].bound_radius = INFINITY;
    struct fine_copy with = build(&view, LIGHTS, depth, NULL, &p);
    check_form(&with, LIGHTS);
    for (uint32_t cell = 0; cell < with.cell_count; cell++)
        for (uint32_t i = 0; i < LIGHTS; i++)
            if (i != 12 && i != 20) assert_int_equal(holds(&with, cell, i), holds(&without, cell, i));
    lights[7] = dark;
    copy_free(&with);
    copy_free(&without);
    free(depth);
}

/* ---- boxes ---- */

/* Bounds on the screen (pixels) and in depth of a sphere before the near plane; false when it is not wholly there. */
static bool sphere_box(const struct gpu_view *view, const struct gpu_light *light, double out[6]) {
    double c[3] = {0}, r = (double)light->bound_radius;
    const float at[3] = {light->bound_center.x, light->bound_center.y, light->bound_center.z};
    for (int i = 0; i < 3; i++) {
        c[i] = (double)view->world_to_view.m[12 + i];
        for (int k = 0; k < 3; k++) c[i] += (double)view->world_to_view.m[k * 4 + i] * (double)at[k];
    }
    double z = -c[2];
    if (z - r <= (double)view->near_distance) return false;
    const double scale[2] = {view->ndc_scale.x, view->ndc_scale.y}, offset[2] = {view->ndc_offset.x, view->ndc_offset.y},
                 size[2] = {view->size.x, view->size.y};
    for (int i = 0; i < 2; i++) {
        double low = c[i] - r, high = c[i] + r;
        if (view->orthographic < 0.5f) {
            double root = sqrt(c[i] * c[i] + z * z - r * r);
            low = (c[i] * z - r * root) / (z * z - r * r);
            high = (c[i] * z + r * root) / (z * z - r * r);
        }
        low = ((low - offset[i]) / scale[i] + 1) / 2 * size[i];
        high = ((high - offset[i]) / scale[i] + 1) / 2 * size[i];
        out[i] = i ? size[i] - high : low;
        out[i + 3] = i ? size[i] - low : high;
    }
    out[2] = z - r;
    out[5] = z + r;
    return true;
}

static double area_of(const struct gpu_fine_box *box) {
    return fmax(0, (double)box->rect.z - (double)box->rect.x) * fmax(0, (double)box->rect.w - (double)box->rect.y);
}

static void test_boxes_FP_4(void **state) {
    UNUSED(state);
    enum { LIGHTS = 400, POINTS = 400 };
    struct random_state random = {13};
    uint32_t seen_points = 0, spheres = 0, narrow = 0;
    double narrow_area = 0, narrow_sphere_area = 0;
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++) {
        struct gpu_view view = list_random_view(kind, &random, WIDTH, HEIGHT);
        random_lights(&view, &random, LIGHTS);
        struct fine_params p = fine_params_default();
        struct fine_copy c = build(&view, LIGHTS, NULL, NULL, &p);
        const uint32_t *visible = c.data[COPY_VISIBLE];
        const struct gpu_fine_box *boxes = c.data[COPY_BOXES];
        for (uint32_t v = 0; v < c.totals.in_view; v++) {
            const struct gpu_light *light = &lights[visible[v]];
            const struct gpu_fine_box *box = &boxes[v];
            vec3 corners[8];
            light_corners(light, corners);
            for (uint32_t k = 0; k < POINTS; k++) { /* points of the proxy in the view are in the box */
                float weights[3], seen[3], world[3] = {0};
                for (int i = 0; i < 3; i++) weights[i] = k % 3 == 0 ? roundf(random_float(&random)) : random_float(&random);
                for (uint32_t i = 0; i < 8; i++) {
                    float w = (i & 1 ? weights[0] : 1 - weights[0]) * (i & 2 ? weights[1] : 1 - weights[1]) *
                              (i & 4 ? weights[2] : 1 - weights[2]);
                    world[0] += w * corners[i].x;
                    world[1] += w * corners[i].y;
                    world[2] += w * corners[i].z;
                }
                vec3 in_view = mat4_point(&view.world_to_view, vec3_make(world[0], world[1], world[2]));
                if (vec3_distance(vec3_make(world[0], world[1], world[2]), light->bound_center) > light->bound_radius)
                    continue;
                seen[2] = -in_view.z;
                if (seen[2] < view.near_distance) continue;
                float spread = view.orthographic > 0.5f ? 1 : seen[2];
                seen[0] = ((in_view.x / spread - view.ndc_offset.x) / view.ndc_scale.x + 1) / 2 * (float)view.size.x;
                seen[1] = (1 - (in_view.y / spread - view.ndc_offset.y) / view.ndc_scale.y) / 2 * (float)view.size.y;
                if (!(seen[0] >= 0 && seen[1] >= 0 && seen[0] <= (float)view.size.x && seen[1] <= (float)view.size.y))
                    continue;
                seen_points++;
                if (seen[0] < box->rect.x || seen[0] > box->rect.z || seen[1] < box->rect.y || seen[1] > box->rect.w ||
                    seen[2] < box->depth.x || seen[2] > box->depth.y)
                    fail_msg("%s: the box of light %u misses pixel %.2f %.2f at %.3f m", list_view_names[kind], visible[v],
                             (double)seen[0], (double)seen[1], (double)seen[2]);
            }
            double sphere[6];
            if (box->rect.x > box->rect.z || !sphere_box(&view, light, sphere)) continue;
            spheres++;
            double margin = 0.05 + 1e-3 * (sphere[3] - sphere[0] + sphere[4] - sphere[1]);
            assert_true((double)box->rect.x >= fmin(sphere[0], view.size.x) - margin &&
                        (double)box->rect.z <= sphere[3] + margin);
            assert_true((double)box->rect.y >= fmin(sphere[1], view.size.y) - margin &&
                        (double)box->rect.w <= sphere[4] + margin);
            assert_true((double)box->depth.x >= sphere[2] * 0.999 - 0.01 &&
                        (double)box->depth.y <= sphere[5] * 1.001 + 0.01);
            if (params[visible[v]].kind == FNL_LIGHT_SPOT && params[visible[v]].outer_cone_angle < 0.3f) {
                struct gpu_fine_box of_sphere = {.rect = {fmaxf((float)sphere[0], 0), fmaxf((float)sphere[1], 0),
                                                          fminf((float)sphere[3], (float)view.size.x),
                                                          fminf((float)sphere[4], (float)view.size.y)}};
                narrow++;
                narrow_area += area_of(box);
                narrow_sphere_area += area_of(&of_sphere);
            }
        }
        copy_free(&c);
    }
    print_message("%u points, %u whole spheres; %u narrow spots take %.2f of their spheres' area\n", seen_points, spheres,
                  narrow, narrow_area / narrow_sphere_area);
    assert_true(seen_points > 50000 && spheres > 100 && narrow > 5);
    assert_true(narrow_area < 0.6 * narrow_sphere_area);
}

/* ---- the figure: nine lights in a tile's box, one of them at its surfaces ---- */

static void place(const struct gpu_view *view, uint32_t index, double x, double y, double view_depth, float range,
                  bool spot) {
    double seen[3], world[3];
    view_of_pixel(view, x, y, view_depth, seen);
    view_to_world(view, seen, world);
    params[index] = fnl_light_params_default();
    params[index].position = vec3_make((float)world[0], (float)world[1], (float)world[2]);
    params[index].range = range;
    if (spot) {
        params[index].kind = FNL_LIGHT_SPOT;
        params[index].direction = vec3_make(1, 0, 0);
        params[index].outer_cone_angle = 0.2f;
    }
    lights[index] = device_light(&params[index]);
}

static void test_nine_lights_FP_5(void **state) {
    UNUSED(state);
    enum { SIDE = 48 };
    fnl_camera camera = fnl_camera_default();
    camera.position = vec3_make(1, 2, 3);
    camera.target = vec3_make(1, 2, 2);
    struct gpu_view view = view_from_camera(&camera, SIDE, SIDE);
    float depth[SIDE * SIDE];
    for (uint32_t i = 0; i < SIDE * SIDE; i++) depth[i] = depth_of_view_depth(&view, i % SIDE % 16 < 8 ? 10 : 30);
    for (uint32_t i = 0; i < 6; i++) place(&view, i, 24, 24, 13 + 2.0 * i, 0.2f, false);
    for (uint32_t i = 6; i < 9; i++) place(&view, i, 22, 26, 12 + 4.0 * i - 24, 0.3f, true);
    place(&view, 4, 20, 24, 10.1, 0.2f, false); /* this one touches the near half */
    struct fine_params p = fine_params_default();
    struct fine_copy fine = build(&view, 9, depth, NULL, &p);
    p.pruning = false;
    struct fine_copy coarse = build(&view, 9, depth, NULL, &p);
    assert_int_equal(cell_at(&coarse, 4).count, 9);
    assert_int_equal(cell_at(&fine, 4).count, 1);
    assert_int_equal(ids_at(&fine, 4)[0], 4);
    copy_free(&fine);
    copy_free(&coarse);
}

/* ---- more than the source's limits ---- */

/* 65 and more by boxes, 25 and more by pixels, 1025 and more in view: nothing is lost, whatever is kept for later or flushed between. */
static void test_many_lights_FP_10(void **state) {
    UNUSED(state);
    static const uint32_t counts[] = {24, 25, 33, 64, 65, 128, 129, 1025, 3100, LIGHTS_MAX};
    struct random_state random = {21};
    fnl_camera camera = fnl_camera_default();
    struct gpu_view view = view_from_camera(&camera, 24, 20);
    float depth[24 * 20];
    for (uint32_t i = 0; i < COUNT_OF(depth); i++) depth[i] = depth_of_view_depth(&view, 10 + 0.05 * (i % 7));
    for (uint32_t n = 0; n < COUNT_OF(counts); n++) {
        for (uint32_t i = 0; i < counts[n]; i++)
            place(&view, i, 3 + 10 * (double)random_float(&random), 3 + 10 * (double)random_float(&random), 10, 0.4f,
                  i % 3 == 0);
        struct fine_params p = fine_params_default();
        struct fine_copy c = build(&view, counts[n], depth, NULL, &p);
        check_form(&c, counts[n]);
        check_sets(&view, depth, counts[n], &c);
        assert_true(cell_at(&c, 0).count > counts[n] / 2);
        copy_free(&c);
        p.pruning = false;
        c = build(&view, counts[n], depth, NULL, &p);
        assert_int_equal(cell_at(&c, 0).count, counts[n]);
        copy_free(&c);
    }
}

static void test_overflow_FP_10(void **state) {
    UNUSED(state);
    enum { LIGHTS = 200 };
    struct random_state random = {5};
    struct gpu_view view = list_random_view(0, &random, WIDTH, HEIGHT);
    random_lights(&view, &random, LIGHTS);
    float *depth = list_random_depth(&view, &random);
    struct fine_params p = fine_params_default();
    struct fine_copy full = build(&view, LIGHTS, depth, NULL, &p);
    uint32_t entries = full.totals.entries;
    assert_true(entries > 100);
    const uint32_t capacities[] = {0, 1, entries / 2, entries - 1, entries};
    for (uint32_t k = 0; k < COUNT_OF(capacities); k++) {
        p.pool_capacity = capacities[k];
        struct fine_copy c = build(&view, LIGHTS, depth, NULL, &p);
        assert_int_equal(c.totals.entries, entries);
        uint32_t overflow = 0;
        for (uint32_t cell = 0; cell < full.cell_count; cell++) {
            struct gpu_cell want = cell_at(&full, cell), is = cell_at(&c, cell);
            if (want.offset + want.count > capacities[k]) {
                assert_int_equal(is.count, GPU_CELL_ALL);
                overflow++;
            } else {
                assert_int_equal(is.count, want.count);
                assert_memory_equal(ids_at(&c, cell), ids_at(&full, cell), want.count * 4ull);
            }
        }
        assert_int_equal(c.totals.overflow_cells, overflow);
        assert_true((overflow > 0) == (capacities[k] < entries));
        copy_free(&c);
    }
    copy_free(&full);
    free(depth);
}

/* ---- packed ---- */

enum { PACKED_ALL = -1 };

/* The local lights of a packed tile, or PACKED_ALL; fails unless its words have the form that the source gives them. */
static int unpack(const struct fine_copy *c, uint32_t cell, uint32_t out[GPU_PACKED_LIGHTS]) {
    const uint32_t *words = (const uint32_t *)c->data[COPY_CELLS] + (size_t)cell * GPU_PACKED_WORDS;
    const uint32_t *visible = c->data[COPY_IDS];
    int count = 0;
    if (words[0] == GPU_PACKED_ALL) {
        assert_int_equal(words[1], c->totals.in_view);
        return PACKED_ALL;
    }
    for (uint32_t w = 0; w < GPU_PACKED_WORDS; w++) {
        uint32_t held = words[w] >> 30;
        assert_true(w == 0 || held == 0 || words[w - 1] >> 30 == 3);
        for (uint32_t i = 0; i < 3; i++) {
            uint32_t place = words[w] >> 10 * i & 1023;
            if (i < held)
                out[count++] = visible[place];
            else
                assert_int_equal(place, 0);
        }
    }
    return count;
}

/* Tile by tile what the ordinary storage holds, or all in view where that is too much. */
static void check_packed(const struct fine_copy *packed, const struct fine_copy *plain) {
    uint32_t overflow = 0;
    assert_int_equal(packed->cell_count, plain->cell_count);
    assert_int_equal(packed->sizes[COPY_CELLS], packed->cell_count * 32ull);
    assert_int_equal(packed->totals.entries, plain->totals.entries);
    assert_int_equal(packed->totals.in_view, plain->totals.in_view);
    for (uint32_t cell = 0; cell < plain->cell_count; cell++) {
        uint32_t held[GPU_PACKED_LIGHTS], want = cell_at(plain, cell).count;
        const uint32_t *visible = packed->data[COPY_IDS];
        int count = unpack(packed, cell, held);
        bool fits = want <= GPU_PACKED_LIGHTS;
        if (fits && want && packed->totals.in_view > 1024) fits = ids_at(plain, cell)[want - 1] <= visible[1023];
        if (!fits) {
            assert_int_equal(count, PACKED_ALL);
            overflow++;
            continue;
        }
        assert_int_equal(count, want);
        if (want) assert_memory_equal(held, ids_at(plain, cell), want * sizeof *held);
    }
    assert_int_equal(packed->totals.overflow_cells, overflow);
}

static struct fine_copy build_both(const struct gpu_view *view, uint32_t light_count, const float *depth, const float *front,
                                   struct fine_params p) {
    p.mask_size = 0;
    struct fine_copy plain = build(view, light_count, depth, front, &p);
    p.packed = true;
    struct fine_copy packed = build(view, light_count, depth, front, &p);
    check_packed(&packed, &plain);
    copy_free(&plain);
    return packed;
}

static void test_packed_round_trip_FP_9_FP_10(void **state) {
    UNUSED(state);
    enum { HIDDEN = 5 };
    static const uint32_t counts[] = {0, 1, 2, 3, 4, 23, 24, 25, 70};
    fnl_camera camera = fnl_camera_default();
    struct gpu_view view = view_from_camera(&camera, 24, 20);
    float depth[24 * 20];
    for (uint32_t i = 0; i < COUNT_OF(depth); i++) depth[i] = depth_of_view_depth(&view, 10);
    struct fine_params p = fine_params_default();
    for (uint32_t n = 0; n < COUNT_OF(counts); n++) {
        for (uint32_t i = 0; i < HIDDEN; i++) place(&view, i, 8, 8, -10, 0.4f, false); /* so that places are not indices */
        for (uint32_t i = 0; i < counts[n]; i++) place(&view, HIDDEN + i, 8.5, 8.5, 10, 0.3f, false);
        struct fine_copy c = build_both(&view, HIDDEN + counts[n], depth, NULL, p);
        uint32_t held[GPU_PACKED_LIGHTS];
        int count = unpack(&c, 0, held);
        assert_int_equal(count, counts[n] <= 24 ? (int)counts[n] : PACKED_ALL);
        for (int i = 0; i < count; i++) assert_int_equal(held[i], HIDDEN + i);
        assert_int_equal(c.totals.in_view, counts[n]);
        assert_int_equal(c.totals.overflow_cells, counts[n] > 24);
        copy_free(&c);
    }
    /* Places up to 1023 are stored. With one light more in view, tiles that hold it are not, and the others are. */
    for (uint32_t in_view = 1024; in_view <= 1025; in_view++) {
        for (uint32_t i = 0; i < HIDDEN; i++) place(&view, i, 8, 8, -10, 0.4f, false);
        for (uint32_t i = 0; i < in_view; i++) place(&view, HIDDEN + i, 8, 8, 5, 0.2f, false); /* before all surfaces */
        place(&view, HIDDEN + 511, 8.5, 8.5, 10, 0.3f, false);
        place(&view, HIDDEN + 1023, 8.5, 8.5, 10, 0.3f, false);
        place(&view, HIDDEN + 1022, 20.5, 8.5, 10, 0.05f, false); /* the tile on the right */
        if (in_view > 1024) place(&view, HIDDEN + 1024, 8.5, 8.5, 10, 0.3f, false);
        struct fine_copy c = build_both(&view, HIDDEN + in_view, depth, NULL, p);
        const uint32_t *words = c.data[COPY_CELLS];
        assert_int_equal(c.totals.in_view, in_view);
        assert_int_equal(words[0], in_view == 1024 ? 2u << 30 | 1023u << 10 | 511u : GPU_PACKED_ALL);
        assert_int_equal(words[GPU_PACKED_WORDS], 1u << 30 | 1022u);
        assert_int_equal(c.totals.overflow_cells, in_view == 1025);
        copy_free(&c);
    }
}

static void test_packed_equals_plain_FP_9(void **state) {
    UNUSED(state);
    enum { LIGHTS = 140 };
    struct random_state random = {31};
    uint32_t packed_entries = 0, overflow = 0;
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++) {
        struct gpu_view view = list_random_view(kind, &random, WIDTH, HEIGHT);
        random_lights(&view, &random, LIGHTS);
        for (uint32_t i = 0; i < LIGHTS; i++)
            lights[i].entity = kind == 2 && i % 3 == 0 ? GPU_ENTITY_PROBE : GPU_ENTITY_LIGHT;
        float *depth = list_random_depth(&view, &random), *front = list_random_depth(&view, &random);
        struct fine_params p = fine_params_default();
        p.tile_size = kind == 1 ? 8 : kind == 3 ? 32 : 16;
        p.pruning = kind != 4;
        p.blend = kind != 2;
        p.probes = kind == 2;
        struct fine_copy c = build_both(&view, LIGHTS, kind == 3 ? NULL : depth, p.blend ? front : NULL, p);
        packed_entries += c.totals.entries;
        overflow += c.totals.overflow_cells;
        copy_free(&c);
        free(depth);
        free(front);
    }
    assert_true(packed_entries > 2000 && overflow > 3);
}

/* ---- lists beside the first ---- */

static void test_lights_and_probes_FP_12(void **state) {
    UNUSED(state);
    enum { LIGHTS = 120 };
    struct random_state random = {6};
    struct gpu_view view = list_random_view(0, &random, WIDTH, HEIGHT);
    random_lights(&view, &random, LIGHTS);
    float *depth = list_random_depth(&view, &random);
    struct fine_params p = fine_params_default();
    struct fine_copy one = build(&view, LIGHTS, depth, NULL, &p);
    for (uint32_t i = 0; i < LIGHTS; i++)
        lights[i].entity = i % 3 == 0 ? GPU_ENTITY_PROBE : i % 7 == 1 ? GPU_ENTITY_DECAL : GPU_ENTITY_LIGHT;
    p.probes = true;
    struct fine_copy two = build(&view, LIGHTS, depth, NULL, &p);
    check_form(&two, LIGHTS);
    uint32_t tile_count = one.cell_count, probes = 0;
    assert_int_equal(two.cell_count, 2 * tile_count);
    for (uint32_t cell = 0; cell < tile_count; cell++)
        for (uint32_t i = 0; i < LIGHTS; i++) {
            bool is = holds(&one, cell, i);
            assert_int_equal(holds(&two, cell, i), is && lights[i].entity == GPU_ENTITY_LIGHT);
            assert_int_equal(holds(&two, tile_count + cell, i), is && lights[i].entity == GPU_ENTITY_PROBE);
            probes += is && lights[i].entity == GPU_ENTITY_PROBE;
        }
    assert_true(probes > 15);
    copy_free(&one);
    copy_free(&two);
    free(depth);
}

/* Blended surfaces: whatever reaches a point between the nearest of them and what is behind is in their list and mask. */
static void test_blended_surfaces(void **state) {
    UNUSED(state);
    enum { LIGHTS = 120 };
    struct random_state random = {16};
    uint64_t held_count = 0;
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++) {
        struct gpu_view view = list_random_view(kind, &random, WIDTH, HEIGHT);
        random_lights(&view, &random, LIGHTS);
        float *depth = list_random_depth(&view, &random), *front = list_random_depth(&view, &random);
        struct fine_params p = fine_params_default();
        p.blend = true;
        struct fine_copy c = build(&view, LIGHTS, depth, front, &p);
        check_form(&c, LIGHTS);
        for (uint32_t y = 0; y < HEIGHT; y++)
            for (uint32_t x = 0; x < WIDTH; x++) {
                float near = front[y * WIDTH + x], far = depth[y * WIDTH + x];
                if (near <= 0 || near < far) continue;
                double from = view_depth_of_depth(&view, near), to = far > 0 ? view_depth_of_depth(&view, far) : from * 8;
                if (view.orthographic > 0.5f && far <= 0) to = from;
                uint32_t cell = c.tiles_x * c.tiles_y + y / c.tile_size * c.tiles_x + x / c.tile_size, entry = 0;
                for (uint32_t light = 0; light < LIGHTS; light++) {
                    while (entry < cell_at(&c, cell).count && ids_at(&c, cell)[entry] < light) entry++;
                    bool held =
                        entry < cell_at(&c, cell).count && ids_at(&c, cell)[entry] == light && visits(&c, cell, x, y, entry);
                    for (int k = 0; k <= 4 && !held; k++) {
                        double seen[3], point[3];
                        view_of_pixel(&view, x + 0.5, y + 0.5, from + (to - from) * k / 4, seen);
                        view_to_world(&view, seen, point);
                        if (light_reaches(&params[light], point))
                            fail_msg("%s: pixel %u %u misses light %u at %d/4", list_view_names[kind], x, y, light, k);
                    }
                    held_count += held;
                }
            }
        copy_free(&c);
        free(depth);
        free(front);
    }
    assert_true(held_count > 10000);
}

/* ---- pictures ---- */

static struct shot shoot(struct stage *stage, fnl_shading shading, fnl_light_lists lists, uint32_t msaa,
                         fnl_list_options options) {
    fnl_frame frame = stage->frame;
    frame.width = 97;
    frame.height = 61;
    frame.shading = shading;
    frame.lists = lists;
    frame.msaa = msaa;
    frame.count_lights = true;
    frame.list_options = options;
    return stage_shoot(stage, &frame);
}

/* Pruned, not pruned and brute force are equal to the bit: each shape alone, and mixed. */
static void test_pictures_FP_1(void **state) {
    UNUSED(state);
    for (uint32_t kind = FNL_LIGHT_POINT; kind <= FNL_LIGHT_KIND_COUNT; kind++) {
        struct stage stage = stage_open("builtin:glass?lights=0", 0);
        fnl_scatter_params scatter = fnl_scatter_params_default();
        scatter.count = 80;
        for (uint32_t k = FNL_LIGHT_POINT; k < FNL_LIGHT_KIND_COUNT; k++)
            scatter.shares[k] = kind == FNL_LIGHT_KIND_COUNT || kind == k ? 1 : 0;
        assert_int_equal(fnl_scene_scatter_light_shapes(stage.scene, &scatter), FNL_OK);
        static const struct {
            fnl_shading shading;
            uint32_t msaa;
        } orders[] = {{FNL_SHADING_DEFERRED, 1}, {FNL_SHADING_FORWARD_PREPASS, 4}, {FNL_SHADING_FORWARD_PREPASS, 1}};
        for (uint32_t o = 0; o < COUNT_OF(orders); o++) {
            fnl_list_options options = fnl_list_options_default();
            struct shot all = shoot(&stage, orders[o].shading, FNL_LISTS_ALL, orders[o].msaa, options);
            assert_true(all.stats.evaluations_useful > 1000);
            static const uint32_t variants[] = {7, 2, 3}; /* of each order */
            for (uint32_t v = 0; v < variants[o]; v++) {
                options.fine_pruning = v != 1 && v != 6;
                options.fine_masks = v == 3 ? 0 : v == 4 ? 2 : 1;
                options.fine_packed = v == 2 || v == 6;
                options.tile_size = v == 4 ? 32 : v == 5 ? 8 : 16;
                struct shot fine = shoot(&stage, orders[o].shading, FNL_LISTS_FINE, orders[o].msaa, options);
                if (count_differing(&all.radiance, &fine.radiance))
                    fail_msg("shape %u, %s, %u samples, variant %u: %llu pixels differ", kind,
                             fnl_shading_name(orders[o].shading), orders[o].msaa, v,
                             (unsigned long long)count_differing(&all.radiance, &fine.radiance));
                assert_int_equal(fine.stats.evaluations_useful, all.stats.evaluations_useful);
                shot_free(&fine);
            }
            shot_free(&all);
        }
        stage_close(&stage);
    }
}

/* With MSAA a surface that covers a pixel in part may be shaded far off along its plane, in another tile. */
static void test_partly_covered_pixels_FP_1(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:hall?lights=1024", 0);
    stage.frame.msaa = 4;
    for (uint32_t s = FNL_SHADING_FORWARD; s <= FNL_SHADING_FORWARD_PREPASS; s++) {
        stage.frame.shading = (fnl_shading)s;
        stage.frame.lists = FNL_LISTS_ALL;
        struct shot all = stage_shoot(&stage, &stage.frame);
        stage.frame.lists = FNL_LISTS_FINE;
        struct shot fine = stage_shoot(&stage, &stage.frame);
        assert_int_equal(count_differing(&all.radiance, &fine.radiance), 0);
        shot_free(&all);
        shot_free(&fine);
    }
    stage_close(&stage);
}

/* Packed: more lights than fit, in a tile or in view, and MSAA; what fits costs as many evaluations as without masks. */
static void test_packed_pictures_FP_9_FP_10(void **state) {
    UNUSED(state);
    static const struct {
        fnl_shading shading;
        uint32_t msaa, lights;
    } cases[] = {{FNL_SHADING_DEFERRED, 1, 30},
                 {FNL_SHADING_DEFERRED, 1, 300},
                 {FNL_SHADING_DEFERRED, 1, 1100},
                 {FNL_SHADING_FORWARD, 4, 300},
                 {FNL_SHADING_FORWARD_PREPASS, 4, 300}};
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        struct stage stage = stage_open("builtin:glass?lights=0", cases[i].lights);
        fnl_list_options options = fnl_list_options_default();
        struct shot all = shoot(&stage, cases[i].shading, FNL_LISTS_ALL, cases[i].msaa, options);
        options.fine_masks = 0;
        options.frustum_cull = cases[i].lights < 1024; /* or all count as in view */
        struct shot plain = shoot(&stage, cases[i].shading, FNL_LISTS_FINE, cases[i].msaa, options);
        options.fine_packed = true;
        struct shot packed = shoot(&stage, cases[i].shading, FNL_LISTS_FINE, cases[i].msaa, options);
        if (count_differing(&all.radiance, &packed.radiance))
            fail_msg("case %u: %llu pixels differ", i, (unsigned long long)count_differing(&all.radiance, &packed.radiance));
        assert_int_equal(packed.stats.list_entries, plain.stats.list_entries);
        assert_true(cases[i].lights < 1024 || packed.stats.lights_in_view > 1024);
        assert_true((packed.stats.overflow_cells > 0) == (cases[i].lights > 30));
        assert_true(packed.stats.evaluations >= plain.stats.evaluations &&
                    packed.stats.evaluations <= all.stats.evaluations);
        if (cases[i].lights == 30) {
            assert_int_equal(packed.stats.evaluations, plain.stats.evaluations);
            assert_int_equal(packed.stats.list_bytes, 7 * 4 * 32 * 2); /* opaque and blended */
            assert_int_equal(packed.stats.list_used_bytes, packed.stats.list_bytes);
        }
        shot_free(&all);
        shot_free(&plain);
        shot_free(&packed);
        stage_close(&stage);
    }
}

/* A pixel visits hardly more lights than reach it: without blended surfaces, none but those within the slack. */
static void test_evaluations(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:spheres?lights=400", 0);
    fnl_list_options options = fnl_list_options_default();
    struct shot pixels = shoot(&stage, FNL_SHADING_DEFERRED, FNL_LISTS_FINE, 1, options);
    assert_true((double)pixels.stats.evaluations <= 1.01 * (double)pixels.stats.evaluations_useful);
    options.fine_masks = 2;
    struct shot quads = shoot(&stage, FNL_SHADING_DEFERRED, FNL_LISTS_FINE, 1, options);
    options.fine_masks = 0;
    struct shot tiles = shoot(&stage, FNL_SHADING_DEFERRED, FNL_LISTS_FINE, 1, options);
    options.fine_pruning = false;
    struct shot boxes = shoot(&stage, FNL_SHADING_DEFERRED, FNL_LISTS_FINE, 1, options);
    assert_true(pixels.stats.evaluations < quads.stats.evaluations && quads.stats.evaluations < tiles.stats.evaluations &&
                tiles.stats.evaluations < boxes.stats.evaluations);
    struct shot prepass = shoot(&stage, FNL_SHADING_FORWARD_PREPASS, FNL_LISTS_FINE, 1, fnl_list_options_default());
    assert_true((double)prepass.stats.evaluations <=
                1.02 * (double)prepass.stats.evaluations_useful); /* positions are near enough */
    print_message("evaluations that reach the surface: 1; by pixels %.3f, quads %.3f, tiles %.3f, boxes %.3f; interpolated "
                  "positions %.3f\n",
                  (double)pixels.stats.evaluations / (double)pixels.stats.evaluations_useful,
                  (double)quads.stats.evaluations / (double)quads.stats.evaluations_useful,
                  (double)tiles.stats.evaluations / (double)tiles.stats.evaluations_useful,
                  (double)boxes.stats.evaluations / (double)boxes.stats.evaluations_useful,
                  (double)prepass.stats.evaluations / (double)prepass.stats.evaluations_useful);
    shot_free(&pixels);
    shot_free(&quads);
    shot_free(&tiles);
    shot_free(&boxes);
    shot_free(&prepass);
    stage_close(&stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_nine_lights_FP_5, harness_check),
        cmocka_unit_test_teardown(test_sets_FP_2_FP_3_FP_14_ES_47, harness_check),
        cmocka_unit_test_teardown(test_sizes_and_sky_FP_11, harness_check),
        cmocka_unit_test_teardown(test_camera_inside_FP_11, harness_check),
        cmocka_unit_test_teardown(test_broken_lights, harness_check),
        cmocka_unit_test_teardown(test_boxes_FP_4, harness_check),
        cmocka_unit_test_teardown(test_many_lights_FP_10, harness_check),
        cmocka_unit_test_teardown(test_overflow_FP_10, harness_check),
        cmocka_unit_test_teardown(test_packed_round_trip_FP_9_FP_10, harness_check),
        cmocka_unit_test_teardown(test_packed_equals_plain_FP_9, harness_check),
        cmocka_unit_test_teardown(test_lights_and_probes_FP_12, harness_check),
        cmocka_unit_test_teardown(test_blended_surfaces, harness_check),
        cmocka_unit_test_teardown(test_pictures_FP_1, harness_check),
        cmocka_unit_test_teardown(test_partly_covered_pixels_FP_1, harness_check),
        cmocka_unit_test_teardown(test_packed_pictures_FP_9_FP_10, harness_check),
        cmocka_unit_test_teardown(test_evaluations, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
