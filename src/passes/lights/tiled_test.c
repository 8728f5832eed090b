/* SPDX-License-Identifier: MIT */
/** The tiles' lists, entry by entry: built on the device, compared with geometry in double precision. */
#include "tests/list_bench.h"

enum { LIGHTS = 300, WIDTH = 157, HEIGHT = 93 };

static fnl_light_params params[4096];
static struct list_light lights[4096];

static struct list_request request_of(const struct gpu_view *view, const float *depth, uint32_t light_count) {
    return (struct list_request){.builder = LIST_TILED,
                                 .view = *view,
                                 .lights = lights,
                                 .light_count = light_count,
                                 .depth = depth,
                                 .tiled = tiled_params_default(),
                                 .clustered = clustered_params_default()};
}

/* Every pixel's surface point against every light: none that reaches it is missing. Returns the pairs that are lit. */
static uint64_t check_surface_points(const struct list_request *r, const struct list_copy *list) {
    uint64_t lit = 0;
    for (uint32_t y = 0; y < r->view.size.y; y++)
        for (uint32_t x = 0; x < r->view.size.x; x++) {
            double depth = (double)r->depth[(size_t)y * r->view.size.x + x], seen[3], point[3];
            if (depth <= 0) continue;
            const vec4 *d = &r->view.depth_decode;
            double view_depth = ((double)d->x + (double)d->y * depth) / ((double)d->z + (double)d->w * depth);
            view_of_pixel(&r->view, x + 0.5, y + 0.5, view_depth, seen);
            view_to_world(&r->view, seen, point);
            uint32_t cells[2];
            list_cells_of(list, x, y, view_depth, cells);
            for (uint32_t i = 0; i < r->light_count; i++) {
                if (!light_reaches(&params[i], point)) continue;
                lit++;
                assert_true(list_holds(list, cells[0], i));
            }
        }
    return lit;
}

/* Lights in view are those whose sphere touches the planes of the view, or by rounding nearly does; and that is not all of them. */
static void check_in_view(const struct list_request *r, uint32_t in_view) {
    uint32_t least = 0, most = 0;
    for (uint32_t i = 0; i < r->light_count; i++) {
        const struct list_light *light = &r->lights[i];
        double distance = INFINITY, slack = 1e-3 * (1 + (double)light->bounds.radius);
        for (int p = 0; p < 5; p++) {
            const vec4 *plane = &r->view.planes[p];
            distance = fmin(distance, (double)plane->x * (double)light->bounds.center.x +
                                          (double)plane->y * (double)light->bounds.center.y +
                                          (double)plane->z * (double)light->bounds.center.z + (double)plane->w);
        }
        slack += 1e-5 * (double)vec3_length(light->bounds.center);
        least += distance >= -(double)light->bounds.radius;
        most += distance >= -(double)light->bounds.radius - slack;
    }
    assert_true(in_view >= least && in_view <= most);
    assert_true(most < r->light_count);
}

static void test_sets_ES_37(void **state) {
    UNUSED(state);
    struct random_state random = {7};
    uint64_t lit = 0;
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++) {
        struct gpu_view view = list_random_view(kind, &random, WIDTH + kind, HEIGHT);
        list_random_lights(&view, &random, LIGHTS, params, lights);
        float *depth = list_random_depth(&view, &random);
        for (int flags = 0; flags < 4; flags++) {
            struct list_request r = request_of(&view, depth, LIGHTS);
            r.tiled.min_depth = flags & 1;
            r.tiled.max_depth = flags & 2;
            if (flags == 2) r.tiled.tile_size = 32;
            struct list_copy list = list_build(&r);
            list_check_form(&list, LIGHTS);
            assert_int_equal(list.totals.overflow_cells, 0);
            check_in_view(&r, list.totals.in_view);
            reference_check(&r, &list);
            lit += check_surface_points(&r, &list);
            list_free(&list);
        }
        struct list_request r = request_of(&view, NULL, LIGHTS); /* no depth: tiles of the whole frustum */
        struct list_copy list = list_build(&r);
        list_check_form(&list, LIGHTS);
        reference_check(&r, &list);
        list_free(&list);
        free(depth);
    }
    assert_true(lit > 50000);
}

static void test_sizes_and_counts_ES_37(void **state) {
    UNUSED(state);
    static const uint32_t sizes[][2] = {{1, 1}, {1, 95}, {15, 16}, {17, 1}, {131, 83}};
    static const uint32_t counts[] = {0, 1, 255, 256, 257, 4096};
    struct random_state random = {3};
    for (uint32_t s = 0; s < COUNT_OF(sizes); s++)
        for (uint32_t c = 0; c < COUNT_OF(counts); c++) {
            if (s > 0 && s < 4 && counts[c] > 1 && counts[c] < 4096) continue;
            struct gpu_view view = list_random_view(0, &random, sizes[s][0], sizes[s][1]);
            list_random_lights(&view, &random, counts[c], params, lights);
            float *depth = list_random_depth(&view, &random);
            struct list_request r = request_of(&view, depth, counts[c]);
            struct list_copy list = list_build(&r), again = list_build(&r);
            list_check_form(&list, counts[c]);
            reference_check(&r, &list);
            assert_true(list_equal(&list, &again));
            list_free(&list);
            list_free(&again);
            free(depth);
        }
}

/* Each test keeps the lights that its own geometry says, at all sizes of tiles; the box rejects many that planes keep. */
static void test_bounds_and_tile_sizes_ES_15_ES_37_ES_38_ES_39(void **state) {
    UNUSED(state);
    struct random_state random = {11};
    uint64_t by_planes = 0, by_box = 0;
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++) {
        struct gpu_view view = list_random_view(kind, &random, WIDTH, HEIGHT + kind);
        list_random_lights(&view, &random, LIGHTS, params, lights);
        float *depth = list_random_depth(&view, &random);
        for (uint32_t size = 8; size <= 64; size *= 2) {
            struct list_request r = request_of(&view, kind == 4 ? NULL : depth, LIGHTS);
            r.tiled.tile_size = size;
            r.tiled.cone_tests = false;
            uint64_t entries[3];
            for (int bounds = TILE_PLANES; bounds <= TILE_RECTANGLE; bounds++) {
                r.tiled.bounds = (enum tile_bounds)bounds;
                struct list_copy list = list_build(&r);
                list_check_form(&list, LIGHTS);
                reference_check(&r, &list);
                if (r.depth) check_surface_points(&r, &list);
                entries[bounds] = list_entries(&list);
                list_free(&list);
            }
            by_planes += entries[TILE_PLANES];
            by_box += entries[TILE_BOX];
            assert_true(entries[TILE_BOX] <= entries[TILE_PLANES]);
            print_message("%s, tiles of %u: %llu entries by planes, %llu with the box, %llu by rectangles\n",
                          list_view_names[kind], size, (unsigned long long)entries[TILE_PLANES],
                          (unsigned long long)entries[TILE_BOX], (unsigned long long)entries[TILE_RECTANGLE]);
        }
        free(depth);
    }
    assert_true((double)by_box < 0.9 * (double)by_planes);
}

/* No point of a sphere that lies beyond the near plane is seen outside of its rectangle, and the rectangle is no larger than it must be. */
static void test_rectangle_of_sphere_ES_15(void **state) {
    UNUSED(state);
    enum { SPHERES = 2000, AROUND = 720 };
    struct random_state random = {21};
    uint32_t crossing = 0, inside = 0;
    for (uint32_t i = 0; i < SPHERES; i++) {
        double near = 0.1, radius = exp2((double)random_range(&random, -3, 3)), slopes[2], low = INFINITY, high = -INFINITY;
        double x = (double)random_range(&random, -6, 6), depth = near + (double)random_range(&random, -1, 2) * radius;
        if (depth + radius < near * 1.01) continue;
        reference_slopes(x, depth, radius, near, slopes);
        for (int k = 0; k < AROUND; k++) { /* the disk that the sphere is, seen along the other axis */
            double at[2] = {x + radius * cos(k * 2 * M_PI / AROUND), depth + radius * sin(k * 2 * M_PI / AROUND)};
            if (at[1] < near) { /* the rim's point is cut off: the cut's own is in its place */
                if (depth - radius > near) continue;
                at[0] = fmin(fmax(at[0], x - sqrt(radius * radius - (near - depth) * (near - depth))),
                             x + sqrt(radius * radius - (near - depth) * (near - depth)));
                at[1] = near;
            }
            assert_true(at[0] / at[1] >= slopes[0] - 1e-9 * fabs(slopes[0]) &&
                        at[0] / at[1] <= slopes[1] + 1e-9 * fabs(slopes[1]));
            low = fmin(low, at[0] / at[1]);
            high = fmax(high, at[0] / at[1]);
        }
        crossing += depth - radius < near;
        inside += x * x + depth * depth < radius * radius;
        assert_true(high - low >= 0.98 * (slopes[1] - slopes[0]));
    }
    assert_true(crossing > 200 && inside > 50);
}

/* ---- cones ---- */

static void make_spots(struct random_state *random, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) {
        params[i].kind = FNL_LIGHT_SPOT;
        params[i].direction =
            vec3_normalize(vec3_make(random_range(random, -1, 1), random_range(random, -1, 1), random_range(random, -1, 1)));
        params[i].range = exp2f(random_range(random, -2, 4.5f));
        params[i].outer_cone_angle = i % 16 == 0 ? PI / 2 : i % 16 == 1 ? 0.002f : exp2f(random_range(random, -5, 0.6f));
        params[i].inner_cone_angle = i % 3 ? params[i].outer_cone_angle * 0.5f : params[i].outer_cone_angle;
        lights[i] = list_light_of(&params[i], i);
    }
}

/* Of 10^5 cones whose sphere touches a tile none is dropped that touches it too, nor one that lights a surface point; of those that
   do not touch few are kept. */
static void test_cones_ES_40(void **state) {
    UNUSED(state);
    enum { SPOTS = 700 };
    struct random_state random = {31};
    uint64_t spheres = 0, kept = 0, needless = 0, lit = 0;
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++)
        for (int with_depth = 0; with_depth < 2; with_depth++) {
            struct gpu_view view = list_random_view(kind, &random, WIDTH, HEIGHT);
            list_random_lights(&view, &random, SPOTS, params, lights);
            make_spots(&random, SPOTS);
            float *depth = with_depth ? list_random_depth(&view, &random) : NULL;
            struct list_request r = request_of(&view, depth, SPOTS);
            if (with_depth) r.tiled.tile_size = 8;
            struct list_copy list = list_build(&r);
            list_check_form(&list, SPOTS);
            reference_check(&r, &list); /* whatever is missing lies beyond a plane */
            if (with_depth) lit += check_surface_points(&r, &list);
            for (uint32_t c = 0; c < list.cell_count; c++) {
                struct reference_cell cell = reference_cell_of(&r, &list.grid, c, 0);
                for (uint32_t i = 0; i < SPOTS; i++) {
                    if (!reference_takes(&cell, &r, i, 0)) continue;
                    spheres++;
                    if (!list_holds(&list, c, i)) continue;
                    kept++;
                    needless += (kept % 8 == 0) * 8u * (reference_cone_gap(&cell, &r, i) > 0.01 * (double)params[i].range);
                }
            }
            list_free(&list);
            free(depth);
        }
    print_message("%llu spheres touch, %llu cones are kept, about %llu of them needlessly; %llu lit pairs\n",
                  (unsigned long long)spheres, (unsigned long long)kept, (unsigned long long)needless,
                  (unsigned long long)lit);
    assert_true(spheres > 100000 && lit > 20000);
    assert_true((double)kept < 0.7 * (double)spheres);
    assert_true((double)needless < 0.05 * (double)kept);
}

/* A narrow beam across the picture is in few of the tiles that its sphere covers. */
static void test_narrow_cone_ES_40(void **state) {
    UNUSED(state);
    fnl_camera camera = fnl_camera_default();
    camera.position = vec3_make(0, 0, 0);
    camera.target = vec3_make(0, 0, -1);
    struct gpu_view view = view_from_camera(&camera, 320, 180);
    params[0] = fnl_light_params_default();
    params[0].kind = FNL_LIGHT_SPOT;
    params[0].position = vec3_make(-6, -3, -14);
    params[0].direction = vec3_normalize(vec3_make(2, 1, 0));
    params[0].range = 12;
    params[0].outer_cone_angle = 0.06f;
    params[0].inner_cone_angle = 0.03f;
    lights[0] = list_light_of(&params[0], 0);
    uint64_t tiles[2];
    for (int cones = 0; cones < 2; cones++) {
        struct list_request r = request_of(&view, NULL, 1);
        r.tiled.cone_tests = cones;
        struct list_copy list = list_build(&r);
        reference_check(&r, &list);
        tiles[cones] = list_entries(&list);
        list_free(&list);
    }
    print_message("a narrow cone is in %llu tiles, its sphere in %llu\n", (unsigned long long)tiles[1],
                  (unsigned long long)tiles[0]);
    assert_true(tiles[1] > 4 && tiles[1] * 5 < tiles[0]);
}

/* ---- the figure: 6 x 6 tiles, A sees lights 1 and 2, B all three, C the third ---- */

enum { TILE = 16, SIDE = 6 * TILE, TILE_A = 2 * 6 + 1, TILE_B = 2 * 6 + 2, TILE_C = 2 * 6 + 3, TILE_SKY = 1 * 6 + 3 };

/* A sphere at tile coordinates whose radius is given in tiles. */
static void place(const struct gpu_view *view, uint32_t index, double x, double y, double view_depth, double radius) {
    double at[3], edge[3], world[3];
    view_of_pixel(view, x * TILE, y * TILE, view_depth, at);
    view_of_pixel(view, (x + radius) * TILE, y * TILE, view_depth, edge);
    view_to_world(view, at, world);
    params[index] = fnl_light_params_default();
    params[index].position = vec3_make((float)world[0], (float)world[1], (float)world[2]);
    params[index].range = (float)(edge[0] - at[0]);
    lights[index] = list_light_of(&params[index], index);
}

static uint32_t bits_of(const struct list_copy *list, uint32_t cell) {
    uint32_t bits = 0;
    for (uint32_t i = 0; i < list->cells[cell].count; i++) bits |= 1u << list->ids[list->cells[cell].offset + i];
    return bits;
}

static void test_figure_ES_43(void **state) {
    UNUSED(state);
    for (int orthographic = 0; orthographic < 2; orthographic++) {
        fnl_camera camera = fnl_camera_default();
        camera.position = vec3_make(1, 2, 3);
        camera.target = vec3_make(1, 2, 2);
        camera.orthographic = orthographic;
        struct gpu_view view = view_from_camera(&camera, SIDE, SIDE);
        place(&view, 0, 2.0, 2.5, 10, 0.4); /* over A and B */
        place(&view, 1, 2.1, 2.5, 11, 0.3);
        place(&view, 2, 3.1, 2.3, 20, 0.4); /* over B and C, far behind, and over the tiles above them */
        float depth[SIDE * SIDE];
        for (uint32_t y = 0; y < SIDE; y++)
            for (uint32_t x = 0; x < SIDE; x++) {
                uint32_t tile = y / TILE * 6 + x / TILE;
                double at = tile == TILE_A || tile == TILE_B ? (x + y) % 2 ? 10 : 11 : 20;
                depth[y * SIDE + x] = tile == TILE_SKY ? 0 : depth_of_view_depth(&view, at);
            }
        struct list_request r = request_of(&view, NULL, 3);
        struct list_copy list = list_build(&r);
        assert_int_equal(bits_of(&list, TILE_A), 3);
        assert_int_equal(bits_of(&list, TILE_B), 7);
        assert_int_equal(bits_of(&list, TILE_C), 4);
        assert_int_equal(bits_of(&list, TILE_SKY), 4);
        list_free(&list);

        for (int flags = 1; flags < 4; flags++) { /* the farthest pixel drops the third light from B */
            r.depth = depth;
            r.tiled.min_depth = flags & 1;
            r.tiled.max_depth = flags & 2;
            list = list_build(&r);
            assert_int_equal(bits_of(&list, TILE_A), 3);
            assert_int_equal(bits_of(&list, TILE_B), flags & 2 ? 3 : 7);
            assert_int_equal(bits_of(&list, TILE_C), 4);
            if (flags & 1) assert_int_equal(list.cells[TILE_SKY].count, 0);
            for (uint32_t c = 0; c < list.cell_count; c++)
                if (c != TILE_A && c != TILE_B && c != TILE_C && c != TILE_SKY && c != TILE_B - 6)
                    assert_int_equal(list.cells[c].count, 0);
            list_free(&list);
        }
        for (uint32_t i = 0; i < SIDE * SIDE; i++) depth[i] = depth_of_view_depth(&view, 20);
        for (int flags = 1; flags < 4; flags++) { /* the first two hang before a far wall: the nearest pixel drops them */
            r.tiled.min_depth = flags & 1;
            r.tiled.max_depth = flags & 2;
            list = list_build(&r);
            assert_int_equal(bits_of(&list, TILE_A), flags & 1 ? 0 : 3);
            assert_int_equal(bits_of(&list, TILE_B), flags & 1 ? 4 : 7);
            list_free(&list);
        }
    }
}

/* A window before a wall, before the sky and behind the wall: its list has the lamps that hang between it and what is behind. */
static void test_window_and_lamps_ES_44(void **state) {
    UNUSED(state);
    enum { OPEN = 2 * 6 + 1, SKY = 2 * 6 + 3, HIDDEN = 2 * 6 + 5, BETWEEN = 1, BEHIND = 2, BEFORE = 4, FAR = 8 };
    fnl_camera camera = fnl_camera_default();
    struct gpu_view view = view_from_camera(&camera, SIDE, SIDE);
    static float depth[SIDE * SIDE], front[SIDE * SIDE];
    for (uint32_t y = 0; y < SIDE; y++)
        for (uint32_t x = 0; x < SIDE; x++) {
            uint32_t tile = y / TILE * 6 + x / TILE, at = y * SIDE + x;
            bool hole = tile == SKY && x % TILE > 8;
            depth[at] = hole ? 0 : depth_of_view_depth(&view, 20);
            front[at] = 0;
            if ((tile == OPEN || tile == SKY) && y % 3) front[at] = depth_of_view_depth(&view, 5);
            if (tile == HIDDEN) front[at] = depth_of_view_depth(&view, 25);
        }
    static const uint32_t tiles[] = {OPEN, SKY, HIDDEN};
    for (uint32_t t = 0; t < COUNT_OF(tiles); t++) {
        double x = tiles[t] % 6 + 0.5, y = tiles[t] / 6 + 0.5;
        place(&view, 0, x, y, 7, 2);    /* lights the window's far side */
        place(&view, 1, x, y, 25, 0.4); /* behind the wall */
        place(&view, 2, x, y, 2, 0.4);  /* too far before the window */
        place(&view, 3, x, y, 200, 0.4);
        struct list_request r = request_of(&view, depth, 4);
        r.front = front;
        struct list_copy list = list_build(&r);
        list_check_form(&list, 4);
        reference_check(&r, &list);
        static const uint32_t want[] = {BETWEEN, BETWEEN | BEHIND | FAR, 0};
        assert_int_equal(bits_of(&list, tiles[t]), want[t]);
        assert_int_equal(list.cells[0].count, 0); /* no window there */
        list_free(&list);
        r.tiled.min_depth = false;
        list = list_build(&r);
        reference_check(&r, &list);
        assert_int_equal(bits_of(&list, tiles[t]), want[t] ? want[t] | BEFORE : 0);
        list_free(&list);
    }
}

/* A pool that is too small: exact counts, whole lists up to it, all lights beyond. */
static void test_overflow_ES_37(void **state) {
    UNUSED(state);
    struct random_state random = {5};
    struct gpu_view view = list_random_view(0, &random, WIDTH, HEIGHT);
    list_random_lights(&view, &random, LIGHTS, params, lights);
    float *depth = list_random_depth(&view, &random);
    struct list_request r = request_of(&view, depth, LIGHTS);
    struct list_copy full = list_build(&r);
    uint32_t entries = (uint32_t)list_entries(&full);
    assert_true(entries > 100);
    const uint32_t capacities[] = {0, 1, entries / 2, entries - 1, entries, entries + 1};
    for (uint32_t k = 0; k < COUNT_OF(capacities); k++) {
        r.tiled.pool_capacity = capacities[k];
        struct list_copy list = list_build(&r);
        list_check_form(&list, LIGHTS);
        assert_int_equal(list.totals.entries, entries);
        uint32_t overflow = 0;
        for (uint32_t c = 0; c < full.cell_count; c++) {
            struct gpu_cell want = full.cells[c];
            if (want.offset + want.count > capacities[k]) {
                assert_int_equal(list.cells[c].count, GPU_CELL_ALL);
                overflow++;
            } else {
                assert_int_equal(list.cells[c].count, want.count);
                assert_memory_equal(list.ids + want.offset, full.ids + want.offset, want.count * 4ull);
            }
        }
        assert_int_equal(list.totals.overflow_cells, overflow);
        assert_true((overflow > 0) == (capacities[k] < entries));
        list_free(&list);
    }
    list_free(&full);
    free(depth);
}

/* A NaN or an infinity in one light must not take others along, nor hang. */
static void test_broken_lights(void **state) {
    UNUSED(state);
    struct random_state random = {9};
    struct gpu_view view = list_random_view(0, &random, WIDTH, HEIGHT);
    list_random_lights(&view, &random, LIGHTS, params, lights);
    float *depth = list_random_depth(&view, &random);
    struct list_request r = request_of(&view, depth, LIGHTS);
    lights[17].bounds.radius = 0;
    lights[40].bounds.center.y = NAN;
    lights[41].bounds.radius = INFINITY;
    struct list_copy list = list_build(&r);
    list_check_form(&list, LIGHTS);
    for (uint32_t c = 0; c < list.cell_count; c++) {
        assert_false(list_holds(&list, c, 17));
        struct reference_cell cell = reference_cell_of(&r, &list.grid, c, 0);
        if (!cell.empty) assert_true(list_holds(&list, c, 41));
    }
    lights[40].bounds.center.y = 0;
    lights[40].bounds.radius = lights[41].bounds.radius = 0; /* the rest is as ever */
    struct list_copy rest = list_build(&r);
    for (uint32_t c = 0; c < list.cell_count; c++)
        for (uint32_t i = 0; i < LIGHTS; i++)
            if (i != 40 && i != 41) assert_int_equal(list_holds(&list, c, i), list_holds(&rest, c, i));
    reference_check(&r, &rest);
    list_free(&list);
    list_free(&rest);
    free(depth);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_figure_ES_43, harness_check),
        cmocka_unit_test_teardown(test_sets_ES_37, harness_check),
        cmocka_unit_test_teardown(test_sizes_and_counts_ES_37, harness_check),
        cmocka_unit_test_teardown(test_bounds_and_tile_sizes_ES_15_ES_37_ES_38_ES_39, harness_check),
        cmocka_unit_test_teardown(test_rectangle_of_sphere_ES_15, harness_check),
        cmocka_unit_test_teardown(test_cones_ES_40, harness_check),
        cmocka_unit_test_teardown(test_narrow_cone_ES_40, harness_check),
        cmocka_unit_test_teardown(test_window_and_lamps_ES_44, harness_check),
        cmocka_unit_test_teardown(test_overflow_ES_37, harness_check),
        cmocka_unit_test_teardown(test_broken_lights, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
