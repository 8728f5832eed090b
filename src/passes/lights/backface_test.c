/* SPDX-License-Identifier: MIT */
/** Tiles without the lights behind their surfaces: the sets against double precision, whole frames against plain tiles. */
#include "passes/lights/backface.h"
#include "passes/lights/backface_shared.h"
#include "tests/list_bench.h"
#include "tests/vulkan_spy.h"

enum { LIGHTS = 400, MANY = 1500, WIDTH = 157, HEIGHT = 93 };

static fnl_light_params params[2048];
static struct list_light lights[2048];

/* ---- made-up surfaces ---- */

enum surface { SURFACE_FLAT, SURFACE_CURVED, SURFACE_NOISY, SURFACE_WILD, SURFACE_COUNT };

struct surfaces {
    float *depth;      /* reversed */
    uint16_t *normals; /* four to a pixel, as the G-buffer has them */
};

static struct surfaces make_surfaces(const struct gpu_view *view, enum surface kind, struct random_state *random) {
    size_t count = (size_t)view->size.x * view->size.y;
    struct surfaces s = {malloc(count * sizeof *s.depth), malloc(count * 4 * sizeof *s.normals)};
    assert_non_null(s.depth);
    assert_non_null(s.normals);
    double base = (double)random_range(random, 3, 12);
    vec3 towards = vec3_normalize(vec3_add(view->back, vec3_make(0.2f, 0.1f, -0.15f)));
    for (uint32_t y = 0; y < view->size.y; y++)
        for (uint32_t x = 0; x < view->size.x; x++) {
            size_t i = (size_t)y * view->size.x + x;
            double at = base + 0.005 * x + (x / 40 % 2 ? 0.5 * base : 0);
            bool sky = (y < 20 && x > 100) || (x + y) % 57 == 3;
            s.depth[i] = sky ? 0 : depth_of_view_depth(view, at);
            vec3 n = towards;
            float bend = kind == SURFACE_CURVED ? 0.6f * sinf(0.05f * (float)x) : 0, noise = kind == SURFACE_NOISY  ? 0.15f
                                                                                             : kind == SURFACE_WILD ? 2
                                                                                                                    : 0;
            n = vec3_add(n, vec3_make(bend + noise * random_range(random, -1, 1), noise * random_range(random, -1, 1),
                                      noise * random_range(random, -1, 1)));
            pack_normal((double[]){(double)n.x, (double)n.y, (double)n.z}, s.normals + 4 * i);
        }
    return s;
}

static void free_surfaces(struct surfaces *s) {
    free(s->depth);
    free(s->normals);
}

/* ---- building ---- */

/* What is behind a list: the cones of its tiles, and the dispatch, the number and the tiles that were picked. */
struct insides {
    struct gpu_cone *cones;
    uint32_t *picks;
};

static bool loses_bounds; /* those of lights in view are zeros once lights are counted */

/* Plain tiles without `p`; the insides are for the caller to free, if asked for. */
static struct list_copy build_inside(const struct gpu_view *v, const struct surfaces *s, uint32_t count,
                                     const struct tiled_params *tiles, const struct backface_params *p,
                                     struct insides *out) {
    struct list_request request = {
        .builder = LIST_TILED, .view = *v, .lights = lights, .light_count = count, .tiled = *tiles};
    if (!p) {
        request.depth = s->depth;
        return list_build(&request);
    }
    struct list_lab lab = list_lab_open(v, lights, count);
    graph_image depth = list_lab_depth(&lab, s->depth);
    graph_image normals = list_lab_image(&lab, VK_FORMAT_R16G16B16A16_UNORM, 8, s->normals);
    list_lab_begin(&lab);
    struct backface_params own = *p;
    own.tiles = *tiles;
    struct gbuffer gbuffer = {.depth = depth,
                              .normal = normals,
                              .targets = {{0}, normals},
                              .target_count = 2,
                              .form = GBUFFER_FORM(GBUFFER_DEFAULT, NORMALS_OCTAHEDRAL),
                              .view = lab.input.view};
    struct light_list list = backface_add(lab.graph, harness_device(), &lab.input, &lab.in_view, &gbuffer, &own);
    struct gpu_buffer picks = {0}, zeros = {0};
    if (loses_bounds) {
        assert_int_equal(gpu_buffer_create(harness_device(), "zeros", count * sizeof(struct gpu_bound), GPU_MEMORY_UPLOAD, &zeros), FNL_OK);
        memset(zeros.mapped, 0, zeros.size);
        spy_begin(harness_device());
        spy_overwrite(lab.graph, "backface count", "light bounds", 0, zeros.size, &zeros);
    }
    if (out) {
        assert_int_equal(
            gpu_buffer_create(harness_device(), "picked", (list.cell_count + 4) * 4ull, GPU_MEMORY_READBACK, &picks),
            FNL_OK);
        spy_begin(harness_device());
        spy_capture(lab.graph, "backface pick", "backface picks", &picks);
    }
    list_lab_run(&lab, (graph_buffer[]){list.cells, list.ids, list.totals, list.cones}, 4);
    spy_end();
    if (loses_bounds) gpu_buffer_destroy(harness_device(), &zeros);
    if (out) {
        out->cones = list_reads_take(&lab.reads, 3);
        out->picks = malloc(picks.size);
        assert_non_null(out->picks);
        memcpy(out->picks, picks.mapped, picks.size);
        gpu_buffer_destroy(harness_device(), &picks);
    }
    struct list_copy copy = {.grid = list_grid(&request), .cell_count = list.cell_count};
    copy.cells = list_reads_take(&lab.reads, 0);
    copy.ids = list_reads_take(&lab.reads, 1);
    memcpy(&copy.totals, lab.reads.buffers[2].mapped, sizeof copy.totals);
    list_lab_close(&lab);
    return copy;
}

static struct list_copy build(const struct gpu_view *v, const struct surfaces *s, uint32_t count,
                              const struct tiled_params *tiles, const struct backface_params *p) {
    return build_inside(v, s, count, tiles, p, NULL);
}

/* ---- sets ---- */

static bool point_of(const struct gpu_view *view, const struct surfaces *s, uint32_t x, uint32_t y, double point[3],
                     double normal[3]) {
    if (!list_position_of(view, s->depth, x, y, point)) return false;
    unpack_normal(s->normals + 4 * ((size_t)y * view->size.x + x), normal);
    return true;
}

/* Cosine, times a length, between a normal and the direction to the light: the largest that any point of the light has. */
static double facing(const struct list_light *light, const double point[3], const double normal[3]) {
    double best = -1e30;
    for (int end = -1; end <= 1; end += 2) {
        vec3 at = light->shape.position;
        if (light->shape.kind == GPU_SHAPE_CAPSULE) at = vec3_add_scaled(at, light->shape.direction, (float)end * light->shape.size.x);
        double ray[3] = {(double)at.x - point[0], (double)at.y - point[1], (double)at.z - point[2]};
        if (light->shape.kind == GPU_SHAPE_BOX) {
            ray[0] = -(double)light->shape.direction.x;
            ray[1] = -(double)light->shape.direction.y;
            ray[2] = -(double)light->shape.direction.z;
        }
        best = fmax(best, ray[0] * normal[0] + ray[1] * normal[1] + ray[2] * normal[2]);
    }
    return best;
}

/* What the source drops: angle between the axis and the way from the tile's middle to the light beyond 90 degrees and both cones. */
static bool dropped_by_angles(const struct gpu_view *view, const struct surfaces *s, uint32_t x0, uint32_t y0, uint32_t size,
                              vec3 light) {
    double axis[3] = {0}, point[3], normal[3], near = 1e30, far = 0, lowest = 1;
    uint32_t x1 = MIN(x0 + size, view->size.x), y1 = MIN(y0 + size, view->size.y);
    for (int round = 0; round < 2; round++) {
        for (uint32_t y = y0; y < y1; y++)
            for (uint32_t x = x0; x < x1; x++) {
                if (!point_of(view, s, x, y, point, normal)) continue;
                double dot = 0;
                for (int k = 0; k < 3; k++) round ? (dot += axis[k] * normal[k]) : (axis[k] += normal[k]);
                if (round) lowest = fmin(lowest, dot);
                vec3 seen = mat4_point(&view->world_to_view, vec3_make((float)point[0], (float)point[1], (float)point[2]));
                near = fmin(near, (double)-seen.z);
                far = fmax(far, (double)-seen.z);
            }
        double length = sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
        if (!(length > 0)) return false;
        for (int k = 0; k < 3; k++) axis[k] /= length;
    }
    double corners[8][3], middle[3] = {0}, to[3], spread = 1, along = 0, length = 0;
    for (int i = 0; i < 8; i++) {
        double seen[3];
        view_of_pixel(view, i & 1 ? x1 : x0, i & 2 ? y1 : y0, i & 4 ? far : near, seen);
        view_to_world(view, seen, corners[i]);
        for (int k = 0; k < 3; k++) middle[k] += corners[i][k] / 8;
    }
    const double at[3] = {(double)light.x, (double)light.y, (double)light.z};
    for (int k = 0; k < 3; k++) {
        to[k] = at[k] - middle[k];
        length += to[k] * to[k];
    }
    for (int k = 0; k < 3; k++) along += (to[k] /= sqrt(length)) * axis[k];
    for (int i = 0; i < 8; i++) {
        double dot = 0, distance = 0;
        for (int k = 0; k < 3; k++) {
            dot += to[k] * (at[k] - corners[i][k]);
            distance += (at[k] - corners[i][k]) * (at[k] - corners[i][k]);
        }
        spread = fmin(spread, dot / sqrt(distance));
    }
    return acos(fmin(fmax(along, -1), 1)) > 1.5707963 + acos(fmin(lowest, 1)) + acos(fmin(fmax(spread, -1), 1)) + 2e-3;
}

struct counts {
    uint64_t plain, kept, angles;
};

/* Kept lists are plain ones without lights that face no pixel of the tile; what the source drops is gone. */
static void check_sets(const struct gpu_view *view, const struct surfaces *s, const struct list_copy *plain,
                       const struct list_copy *list, bool by_angles, struct counts *counts) {
    uint32_t size = list->grid.tile_size;
    for (uint32_t c = 0; c < list->cell_count; c++) {
        uint32_t x0 = c % list->grid.tiles_x * size, y0 = c / list->grid.tiles_x * size;
        for (uint32_t n = 0; n < list->cells[c].count; n++)
            assert_true(list_holds(plain, c, list->ids[list->cells[c].offset + n])); /* TD-5 */
        for (uint32_t n = 0; n < plain->cells[c].count; n++) {
            uint32_t light = plain->ids[plain->cells[c].offset + n];
            bool kept = list_holds(list, c, light);
            counts->plain++;
            counts->kept += kept;
            if (by_angles && lights[light].shape.kind <= GPU_SHAPE_CONE &&
                dropped_by_angles(view, s, x0, y0, size, lights[light].shape.position)) {
                counts->angles++;
                assert_false(kept);
            }
            if (kept) continue;
            for (uint32_t y = y0; y < MIN(y0 + size, view->size.y); y++)
                for (uint32_t x = x0; x < MIN(x0 + size, view->size.x); x++) {
                    double point[3], normal[3];
                    if (!point_of(view, s, x, y, point, normal)) continue;
                    double facing_it = facing(&lights[light], point, normal);
                    if (facing_it >= 0)
                        fail_msg("light %u faces pixel %u, %u by %g but tile %u dropped it", light, x, y, facing_it, c);
                }
        }
    }
}

static void test_sets_TD_2_TD_4_TD_5_TD_9(void **state) {
    UNUSED(state);
    struct random_state random = {21};
    for (uint32_t surface = 0; surface < SURFACE_COUNT; surface++) {
        struct counts counts = {0};
        for (uint32_t kind = 0; kind < LIST_VIEWS; kind++) {
            struct gpu_view view = list_random_view(kind, &random, WIDTH + kind, HEIGHT);
            list_random_shapes(&view, &random, LIGHTS, params, lights);
            struct surfaces s = make_surfaces(&view, (enum surface)surface, &random);
            struct tiled_params tiles = tiled_params_default();
            if (kind == 2) tiles.tile_size = 8;
            if (kind == 3) tiles.tile_size = 64;
            struct list_copy plain = build(&view, &s, LIGHTS, &tiles, NULL);
            for (uint32_t axis = 0; axis < 3; axis++) {
                struct backface_params p = backface_params_default();
                p.axis = (enum backface_axis)axis;
                p.least = 0;
                p.tally = axis == 0;
                struct list_copy list = build(&view, &s, LIGHTS, &tiles, &p), again = build(&view, &s, LIGHTS, &tiles, &p);
                list_check_form(&list, LIGHTS);
                assert_true(list_equal(&list, &again));
                check_sets(&view, &s, &plain, &list, axis == BACKFACE_SUM, &counts);
                p.least = 12; /* only tiles that are worth it */
                struct list_copy some = build(&view, &s, LIGHTS, &tiles, &p);
                list_check_form(&some, LIGHTS);
                check_sets(&view, &s, &plain, &some, false, &(struct counts){0});
                assert_true(list_entries(&some) >= list_entries(&list));
                list_free(&list);
                list_free(&again);
                list_free(&some);
            }
            list_free(&plain);
            free_surfaces(&s);
        }
        print_message("surface %u: %llu entries of %llu are left; the angles of the source alone drop %llu of a third\n",
                      surface, (unsigned long long)counts.kept, (unsigned long long)counts.plain,
                      (unsigned long long)counts.angles);
        if (surface != SURFACE_WILD) {
            assert_true(counts.kept * 100 < counts.plain * 95);
            assert_true(counts.plain - counts.kept > 3 * counts.angles && counts.angles > 20);
        }
    }
}

/* ---- cones ---- */

/* The axis that a tile should have, times a length. */
static void axis_of(const struct gpu_view *view, const struct surfaces *s, enum backface_axis kind, uint32_t x0, uint32_t y0,
                    uint32_t size, double out[3]) {
    uint32_t x1 = MIN(x0 + size, view->size.x), y1 = MIN(y0 + size, view->size.y);
    double point[3], normal[3];
    memset(out, 0, 3 * sizeof *out);
    for (uint32_t k = 0; k < 4 && kind == BACKFACE_SAMPLES; k++) {
        uint32_t x = MIN(x0 + (k % 2 * 2 + 1) * size / 4, x1 - 1), y = MIN(y0 + (k / 2 * 2 + 1) * size / 4, y1 - 1);
        if (!point_of(view, s, x, y, point, normal)) continue;
        for (int a = 0; a < 3; a++) out[a] += normal[a];
    }
    for (uint32_t y = y0; y < y1 && kind != BACKFACE_SAMPLES; y++)
        for (uint32_t x = x0; x < x1; x++) {
            if (!point_of(view, s, x, y, point, normal)) continue;
            for (int a = 0; a < 3; a++) out[a] += normal[a];
        }
}

/* Lights of a plain tile behind four of its pixels: at least, and at most, as rounding goes. */
static void count_candidates(const struct gpu_view *view, const struct surfaces *s, const struct list_copy *plain,
                             uint32_t cell, uint32_t size, uint32_t out[2]) {
    uint32_t x0 = cell % plain->grid.tiles_x * size, y0 = cell / plain->grid.tiles_x * size;
    out[0] = out[1] = 0;
    for (uint32_t i = 0; i < plain->cells[cell].count; i++) {
        const struct list_light *light = &lights[plain->ids[plain->cells[cell].offset + i]];
        double most = -INFINITY, point[3], normal[3];
        for (uint32_t k = 0; k < 4; k++) {
            uint32_t x = MIN(x0 + (k % 2 * 2 + 1) * size / 4, view->size.x - 1),
                     y = MIN(y0 + (k / 2 * 2 + 1) * size / 4, view->size.y - 1);
            if (point_of(view, s, x, y, point, normal)) most = fmax(most, facing(light, point, normal));
        }
        out[0] += most < -1e-3;
        out[1] += most < 1e-3;
    }
}

/*
 * Just the tiles with enough lights are picked; of these the ones with enough lights behind four pixels get a cone: round the axis that was
 * asked for, and just as wide as the normals need. What it drops is what the list lacks.
 */
static void test_cones_TD_9(void **state) {
    UNUSED(state);
    struct random_state random = {23};
    uint32_t cones = 0, without = 0;
    double turned = 0; /* how far the axes of the kinds are from each other at most */
    for (uint32_t surface = 0; surface < SURFACE_WILD; surface++)
        for (uint32_t kind = 0; kind < 3; kind++) {
            struct gpu_view view = list_random_view(kind, &random, WIDTH + kind, HEIGHT);
            list_random_shapes(&view, &random, LIGHTS, params, lights);
            struct surfaces s = make_surfaces(&view, (enum surface)surface, &random);
            struct tiled_params tiles = tiled_params_default();
            if (kind == 2) tiles.tile_size = 32;
            uint32_t size = tiles.tile_size;
            struct list_copy plain = build(&view, &s, LIGHTS, &tiles, NULL);
            for (uint32_t axis = 0; axis < 3; axis++) {
                struct backface_params p = backface_params_default();
                p.axis = (enum backface_axis)axis;
                struct insides in;
                struct list_copy list = build_inside(&view, &s, LIGHTS, &tiles, &p, &in);
                uint32_t picked = 0;
                for (uint32_t c = 0; c < list.cell_count; c++) {
                    const struct gpu_cone *cone = &in.cones[c];
                    uint32_t candidates[2], count = plain.cells[c].count;
                    double want[3], first[3], length = 0, first_length = 0, first_dot = 0;
                    picked += count >= p.least;
                    count_candidates(&view, &s, &plain, c, size, candidates);
                    bool has_cone = cone->axis.x != 0 || cone->axis.y != 0 || cone->axis.z != 0;
                    assert_true(has_cone || count < p.least || 3 * candidates[0] < p.least || plain.cells[c].count == 0);
                    assert_true(!has_cone || (count >= p.least && 3 * candidates[1] >= p.least));
                    assert_int_equal(list.cells[c].count + (cone->keeps ? 0 : cone->dropped), count);
                    without += !has_cone;
                    if (!has_cone) continue;
                    uint32_t x0 = c % list.grid.tiles_x * size, y0 = c / list.grid.tiles_x * size;
                    axis_of(&view, &s, (enum backface_axis)axis, x0, y0, size, want);
                    axis_of(&view, &s, BACKFACE_SAMPLES, x0, y0, size, first);
                    const double is[3] = {(double)cone->axis.x, (double)cone->axis.y, (double)cone->axis.z};
                    for (int a = 0; a < 3; a++) {
                        length += want[a] * want[a];
                        first_length += first[a] * first[a];
                        first_dot += want[a] * first[a];
                    }
                    double between = 0, lowest = 1, point[3], normal[3];
                    for (int a = 0; a < 3; a++) between += is[a] * want[a] / sqrt(length);
                    assert_true(between > 0.9999);
                    turned = fmax(turned, 1 - first_dot / sqrt(length * first_length));
                    for (uint32_t y = y0; y < MIN(y0 + size, view.size.y); y++)
                        for (uint32_t x = x0; x < MIN(x0 + size, view.size.x); x++) {
                            double dot = 0;
                            if (!point_of(&view, &s, x, y, point, normal)) continue;
                            for (int a = 0; a < 3; a++) dot += is[a] * normal[a];
                            lowest = fmin(lowest, dot);
                        }
                    double sine = lowest > 0 ? sqrt(1 - fmin(lowest * lowest, 1)) : (double)BACKFACE_WIDE;
                    assert_true(fabs((double)cone->sine - sine) < 2e-3);
                    cones++;
                }
                assert_int_equal(in.picks[3], picked);
                assert_int_equal(in.picks[0], BACKFACE_ROW);
                assert_int_equal(in.picks[1], DIVIDE_UP(picked, BACKFACE_ROW));
                free(in.cones);
                free(in.picks);
                list_free(&list);
            }
            list_free(&plain);
            free_surfaces(&s);
        }
    print_message("%u tiles have cones, %u do not need any; axes differ by up to %.3f\n", cones, without, turned);
    assert_true(cones > 50 && without > 500 && turned > 2e-3);
}

static void test_sizes_overflow_and_broken_lights_TD_11(void **state) {
    UNUSED(state);
    static const uint32_t sizes[][2] = {{1, 1}, {1, 95}, {17, 1}, {131, 83}};
    static const uint32_t light_counts[] = {0, 1, 257, 2048};
    struct random_state random = {5};
    struct tiled_params tiles = tiled_params_default();
    struct backface_params p = backface_params_default();
    for (uint32_t i = 0; i < COUNT_OF(sizes); i++)
        for (uint32_t k = 0; k < COUNT_OF(light_counts); k++) {
            struct gpu_view view = list_random_view(0, &random, sizes[i][0], sizes[i][1]);
            list_random_shapes(&view, &random, light_counts[k], params, lights);
            struct surfaces s = make_surfaces(&view, SURFACE_FLAT, &random);
            struct list_copy plain = build(&view, &s, light_counts[k], &tiles, NULL),
                             list = build(&view, &s, light_counts[k], &tiles, &p);
            list_check_form(&list, light_counts[k]);
            check_sets(&view, &s, &plain, &list, false, &(struct counts){0});
            list_free(&plain);
            list_free(&list);
            free_surfaces(&s);
        }
    struct gpu_view view = list_random_view(0, &random, WIDTH, HEIGHT);
    list_random_shapes(&view, &random, LIGHTS, params, lights);
    for (uint32_t i = 0; i < LIGHTS; i += 40) lights[i].shape.position.y = NAN; /* NaN is never behind */
    struct surfaces s = make_surfaces(&view, SURFACE_FLAT, &random);
    struct list_copy plain = build(&view, &s, LIGHTS, &tiles, NULL), full = build(&view, &s, LIGHTS, &tiles, &p);
    for (uint32_t c = 0; c < plain.cell_count; c++)
        for (uint32_t i = 0; i < LIGHTS; i += 40) assert_int_equal(list_holds(&plain, c, i), list_holds(&full, c, i));
    loses_bounds = true; /* each light is tested once: the count keeps what it finds */
    struct list_copy once = build(&view, &s, LIGHTS, &tiles, &p);
    loses_bounds = false;
    assert_true(list_equal(&full, &once));
    list_free(&once);
    uint32_t entries = (uint32_t)list_entries(&full), overflow = 0;
    tiles.pool_capacity = entries / 2;
    struct list_copy over = build(&view, &s, LIGHTS, &tiles, &p);
    assert_int_equal(over.totals.entries, entries);
    for (uint32_t c = 0; c < full.cell_count; c++) {
        struct gpu_cell want = full.cells[c];
        bool fits = want.offset + want.count <= entries / 2;
        assert_int_equal(over.cells[c].count, fits ? want.count : GPU_CELL_ALL);
        overflow += !fits;
    }
    assert_int_equal(over.totals.overflow_cells, overflow);
    assert_true(overflow > 0);
    list_free(&plain);
    list_free(&full);
    list_free(&over);
    free_surfaces(&s);
    view = list_random_view(0, &random, 21, 13); /* tiles with more lights than are listed while they are looked at */
    list_random_shapes(&view, &random, MANY, params, lights);
    for (uint32_t i = 0; i < MANY; i++) lights[i].bounds.radius = 1000;
    s = make_surfaces(&view, SURFACE_FLAT, &random);
    tiles = tiled_params_default();
    plain = build(&view, &s, MANY, &tiles, NULL);
    full = build(&view, &s, MANY, &tiles, &p);
    assert_true(plain.cells[0].count > 600);
    list_check_form(&full, MANY);
    check_sets(&view, &s, &plain, &full, false, &(struct counts){0});
    assert_true(list_entries(&full) * 100 < list_entries(&plain) * 95);
    list_free(&plain);
    list_free(&full);
    free_surfaces(&s);
}

/* The tile planes as the source prints them, made unit: right and bottom lie one tile too far out. Ours hold no light more, and what is
   missing reaches no pixel. */
static void test_printed_planes_TD_10(void **state) {
    UNUSED(state);
    struct random_state random = {8};
    struct gpu_view view = list_random_view(0, &random, WIDTH, HEIGHT);
    list_random_lights(&view, &random, LIGHTS, params, lights);
    struct surfaces s = make_surfaces(&view, SURFACE_FLAT, &random);
    struct tiled_params tiles = tiled_params_default();
    tiles.cone_tests = false;
    struct list_copy list = build(&view, &s, LIGHTS, &tiles, NULL);
    uint64_t tight = 0, printed = 0;
    for (uint32_t c = 0; c < list.cell_count; c++) {
        uint32_t gx = c % list.grid.tiles_x, gy = c / list.grid.tiles_x;
        double near = 1e30, far = 0, sx = WIDTH / 32.0, sy = HEIGHT / 32.0;
        for (uint32_t y = gy * 16; y < MIN(gy * 16 + 16, HEIGHT); y++)
            for (uint32_t x = gx * 16; x < MIN(gx * 16 + 16, WIDTH); x++) {
                double point[3], normal[3];
                if (!point_of(&view, &s, x, y, point, normal)) continue;
                vec3 seen = mat4_point(&view.world_to_view, vec3_make((float)point[0], (float)point[1], (float)point[2]));
                near = fmin(near, (double)-seen.z);
                far = fmax(far, (double)-seen.z);
            }
        double c1[3] = {sx / (double)view.ndc_scale.x, 0, -(sx - gx)},
               c2[3] = {0, -sy / (double)view.ndc_scale.y, -(sy - gy)};
        double planes[4][3];
        for (int k = 0; k < 3; k++) {
            double c4 = k == 2 ? -1 : 0;
            planes[0][k] = c4 - c1[k];
            planes[1][k] = c4 + c1[k];
            planes[2][k] = c4 - c2[k];
            planes[3][k] = c4 + c2[k];
        }
        for (uint32_t i = 0; i < LIGHTS; i++) {
            vec3 at = mat4_point(&view.world_to_view, lights[i].bounds.center);
            double radius = (double)lights[i].bounds.radius, slack = radius * 1e-3 + 1e-3 * (1 + fabs((double)at.z));
            bool holds = far > 0 && near + (double)at.z <= radius + slack && -far - (double)at.z <= radius + slack;
            for (int p = 0; p < 4; p++) {
                const double *n = planes[p];
                double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
                holds =
                    holds && (n[0] * (double)at.x + n[1] * (double)at.y + n[2] * (double)at.z) / length >= -radius - slack;
            }
            printed += holds;
            bool held = list_holds(&list, c, i);
            tight += held;
            assert_true(holds || !held);
            for (uint32_t y = gy * 16; holds && !held && y < MIN(gy * 16 + 16, HEIGHT); y++)
                for (uint32_t x = gx * 16; x < MIN(gx * 16 + 16, WIDTH); x++) {
                    double point[3], normal[3];
                    if (point_of(&view, &s, x, y, point, normal)) assert_false(light_reaches(&params[i], point));
                }
        }
    }
    print_message("entries: %llu, by the printed planes %llu\n", (unsigned long long)tight, (unsigned long long)printed);
    assert_true(tight * 10 < printed * 9);
    list_free(&list);
    free_surfaces(&s);
}

/* ---- frames ---- */

/* Behind the wall are 0, 100, 500 and 1000 lights: these are dropped, no others, and what is left to visit is what the lights before it
   cost. */
static void test_walls_TD_6(void **state) {
    UNUSED(state);
    static const uint32_t behind[] = {0, 100, 500, 1000};
    uint64_t first = 0;
    for (uint32_t test = 0; test < 4; test++) {
        char source[32];
        snprintf(source, sizeof source, "builtin:wall?test=%u", test + 1);
        struct stage stage = stage_open(source, 0);
        stage.frame.width = 640;
        stage.frame.height = 360;
        stage.frame.count_lights = true;
        stage.frame.shading = FNL_SHADING_DEFERRED;
        stage.frame.lists = FNL_LISTS_TILED;
        struct shot tiled = stage_shoot(&stage, &stage.frame);
        stage.frame.lists = FNL_LISTS_BACKFACE;
        struct shot shot = stage_shoot(&stage, &stage.frame);
        assert_int_equal(count_differing(&tiled.radiance, &shot.radiance), 0);
        assert_int_equal(counter(&shot.stats, "lights.behind"), behind[test]);
        assert_false(has_counter(&tiled.stats, "lights.behind"));
        print_message("%s: %llu evaluations of %llu\n", source, (unsigned long long)shot.stats.evaluations,
                      (unsigned long long)tiled.stats.evaluations);
        if (test == 0) {
            first = tiled.stats.evaluations;
            assert_true(shot.stats.evaluations <= first);
        } else {
            static const double most[] = {0, 0.853, 0.667, 0.603}; /* the source's times, which shading alone must beat */
            assert_true((double)shot.stats.evaluations < most[test] * (double)tiled.stats.evaluations);
            assert_true(shot.stats.evaluations < 2 * first);
        }
        shot_free(&tiled);
        shot_free(&shot);
        stage_close(&stage);
    }
}

/* Bit-equal to all lights for every axis and tile size, on curved and bumpy things, with glass, at odd sizes, before sky. */
static void test_frames_TD_1_TD_2_TD_9_TD_11(void **state) {
    UNUSED(state);
    static const struct {
        const char *source;
        uint32_t scattered, width, height;
    } scenes[] = {{"builtin:wall?test=2", 0, 161, 91},
                  {"builtin:spheres?lights=120", 0, 161, 91},
                  {"builtin:hall?lights=256", 0, 97, 55},
                  {"builtin:glass?lights=80", 0, 97, 55},
                  {"builtin:sky", 0, 61, 31},
                  {"builtin:spheres?lights=0", 0, 61, 31}};
    static const uint32_t tile_sizes[] = {8, 16, 32, 64};
    for (uint32_t i = 0; i < COUNT_OF(scenes); i++) {
        struct stage stage = stage_open(scenes[i].source, scenes[i].scattered);
        fnl_frame frame = stage.frame;
        frame.width = scenes[i].width;
        frame.height = scenes[i].height;
        frame.shading = FNL_SHADING_DEFERRED;
        frame.lists = FNL_LISTS_ALL;
        struct shot all = stage_shoot(&stage, &frame);
        frame.lists = FNL_LISTS_BACKFACE;
        for (uint32_t axis = 0; axis < FNL_BACKFACE_AXIS_COUNT; axis++)
            for (uint32_t t = 0; t < COUNT_OF(tile_sizes); t++) {
                if (axis != 0 && t != 1) continue;
                frame.list.backface_axis = (fnl_backface_axis)axis;
                frame.tiles.size = tile_sizes[t];
                struct shot shot = stage_shoot(&stage, &frame);
                if (count_differing(&all.radiance, &shot.radiance))
                    fail_msg("%s: axis %u, tiles of %u differ", scenes[i].source, axis, tile_sizes[t]);
                shot_free(&shot);
            }
        shot_free(&all);
        stage_close(&stage);
    }
}

static void test_views_TD_12(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:wall?test=3", 0);
    fnl_frame frame = stage.frame;
    frame.width = 320;
    frame.height = 180;
    frame.outputs = FNL_OUTPUT_COLOR;
    frame.shading = FNL_SHADING_DEFERRED;
    frame.lists = FNL_LISTS_BACKFACE;
    frame.debug = FNL_DEBUG_TILE_NORMALS;
    struct shot normals = stage_shoot(&stage, &frame);
    const uint8_t *wall = (const uint8_t *)normals.color.pixels + (60 * 320 + 150) * 4,
                  *ground = (const uint8_t *)normals.color.pixels + (170 * 320 + 120) * 4;
    assert_true(abs(wall[0] - 128) < 2 && abs(wall[1] - 128) < 2 && wall[2] == 255);       /* towards +z */
    assert_true(abs(ground[0] - 128) < 2 && ground[1] == 255 && abs(ground[2] - 128) < 2); /* up */
    frame.debug = FNL_DEBUG_BACKFACES;
    struct shot dropped = stage_shoot(&stage, &frame);
    wall = (const uint8_t *)dropped.color.pixels + (60 * 320 + 150) * 4;
    ground = (const uint8_t *)dropped.color.pixels + (150 * 320 + 120) * 4;
    assert_true(MAX(wall[0], wall[1]) > 130); /* dozens */
    assert_true(ground[0] == ground[1] && ground[1] == ground[2]);
    shot_free(&normals);
    shot_free(&dropped);
    stage_close(&stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_sets_TD_2_TD_4_TD_5_TD_9, harness_check),
        cmocka_unit_test_teardown(test_cones_TD_9, harness_check),
        cmocka_unit_test_teardown(test_sizes_overflow_and_broken_lights_TD_11, harness_check),
        cmocka_unit_test_teardown(test_printed_planes_TD_10, harness_check),
        cmocka_unit_test_teardown(test_walls_TD_6, harness_check),
        cmocka_unit_test_teardown(test_frames_TD_1_TD_2_TD_9_TD_11, harness_check),
        cmocka_unit_test_teardown(test_views_TD_12, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
