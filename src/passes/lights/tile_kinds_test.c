/* SPDX-License-Identifier: MIT */
/** Tiles in halves, with depth masks, and with depth ranges: built on the device, compared with geometry in double precision. */
#include "passes/lights/tree.h"
#include "tests/list_bench.h"
#include "tests/vulkan_spy.h"

enum { LIGHTS = 300, WIDTH = 157, HEIGHT = 93 };

static const enum list_builder builders[] = {LIST_HALFZ, LIST_25D, LIST_ENHANCED};

static fnl_light_params params[4096];
static struct list_light lights[4096];

static struct list_request request_of(enum list_builder builder, const struct gpu_view *view, const float *depth,
                                      uint32_t light_count) {
    return (struct list_request){.builder = builder,
                                 .view = *view,
                                 .lights = lights,
                                 .light_count = light_count,
                                 .depth = builder == LIST_ENHANCED ? NULL : depth,
                                 .tiled = tiled_params_default(),
                                 .clustered = clustered_params_default()};
}

/* The range of an entry that holds a light, or one that holds no depth. */
static uint32_t range_of(const struct list_copy *list, uint32_t cell, uint32_t light) {
    for (uint32_t i = 0; i < list->cells[cell].count; i++)
        if (list->ids[list->cells[cell].offset + i] == light) return list->extra[list->cells[cell].offset + i];
    return 0xffff;
}

static bool range_holds(uint32_t range, double view_depth) {
    uint32_t code = light_tree_depth_code((float)view_depth);
    return code >= (range & 0xffff) && code <= range >> 16;
}

/* Every pixel's surface point against every light: wherever the pixel may look, none that reaches it is missing. */
static uint64_t check_surface_points(const struct list_request *r, const struct list_copy *list, const float *depths) {
    uint64_t lit = 0;
    for (uint32_t y = 0; y < r->view.size.y; y++)
        for (uint32_t x = 0; x < r->view.size.x; x++) {
            double depth = (double)depths[(size_t)y * r->view.size.x + x], seen[3], point[3];
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
                assert_true(list_holds(list, cells[0], i) && list_holds(list, cells[1], i));
                if (r->builder == LIST_ENHANCED) assert_true(range_holds(range_of(list, cells[0], i), view_depth));
            }
        }
    return lit;
}

static void test_sets_ES_45_ES_46_ES_65(void **state) {
    UNUSED(state);
    struct random_state random = {41};
    uint64_t lit[3] = {0};
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++) {
        struct gpu_view view = list_random_view(kind, &random, WIDTH, HEIGHT + kind);
        list_random_lights(&view, &random, LIGHTS, params, lights);
        float *depth = list_random_depth(&view, &random);
        for (uint32_t b = 0; b < COUNT_OF(builders); b++) {
            struct list_request r = request_of(builders[b], &view, depth, LIGHTS);
            r.tiled.tile_size = 8u << kind % 4;
            struct list_copy list = list_build(&r), again = list_build(&r);
            list_check_form(&list, LIGHTS);
            assert_true(list_equal(&list, &again));
            lit[b] += check_surface_points(&r, &list, depth);
            if (builders[b] == LIST_HALFZ) reference_check(&r, &list);
            list_free(&list);
            list_free(&again);
        }
        free(depth);
    }
    for (uint32_t b = 0; b < COUNT_OF(builders); b++) assert_true(lit[b] > 20000);
}

static void test_sizes_and_counts(void **state) {
    UNUSED(state);
    static const uint32_t sizes[][2] = {{1, 1}, {1, 95}, {17, 1}, {131, 83}};
    static const uint32_t counts[] = {0, 1, 257, 4096};
    struct random_state random = {3};
    for (uint32_t s = 0; s < COUNT_OF(sizes); s++)
        for (uint32_t c = 0; c < COUNT_OF(counts); c++)
            for (uint32_t b = 0; b < COUNT_OF(builders); b++) {
                struct gpu_view view = list_random_view(s % LIST_VIEWS, &random, sizes[s][0], sizes[s][1]);
                list_random_lights(&view, &random, counts[c], params, lights);
                float *depth = list_random_depth(&view, &random);
                struct list_request r = request_of(builders[b], &view, depth, counts[c]);
                if (counts[c] == 257) { /* one is everywhere, one nowhere */
                    lights[2].bounds.radius = INFINITY;
                    lights[1].bounds.radius = 0;
                }
                struct list_copy list = list_build(&r);
                list_check_form(&list, counts[c]);
                for (uint32_t cell = 0; cell < list.cell_count && counts[c] == 257; cell++) {
                    assert_false(list_holds(&list, cell, 1));
                    if (builders[b] == LIST_ENHANCED) assert_true(range_holds(range_of(&list, cell, 2), 5));
                }
                list_free(&list);
                free(depth);
            }
}

static void test_overflow(void **state) {
    UNUSED(state);
    struct random_state random = {5};
    struct gpu_view view = list_random_view(0, &random, WIDTH, HEIGHT);
    list_random_lights(&view, &random, LIGHTS, params, lights);
    float *depth = list_random_depth(&view, &random);
    for (uint32_t b = 0; b < COUNT_OF(builders); b++) {
        struct list_request r = request_of(builders[b], &view, depth, LIGHTS);
        struct list_copy full = list_build(&r);
        uint32_t entries = (uint32_t)list_entries(&full);
        assert_true(entries > 100);
        const uint32_t capacities[] = {0, entries / 2, entries - 1, entries};
        for (uint32_t k = 0; k < COUNT_OF(capacities); k++) {
            r.tiled.pool_capacity = capacities[k];
            struct list_copy list = list_build(&r);
            list_check_form(&list, LIGHTS);
            assert_int_equal(list.totals.entries, entries);
            assert_true((list.totals.overflow_cells > 0) == (capacities[k] < entries));
            for (uint32_t c = 0; c < full.cell_count; c++) {
                struct gpu_cell want = full.cells[c];
                bool fits = want.offset + want.count <= capacities[k];
                assert_int_equal(list.cells[c].count, fits ? want.count : GPU_CELL_ALL);
                if (!fits) continue;
                assert_memory_equal(list.ids + want.offset, full.ids + want.offset, want.count * 4ull);
                if (builders[b] == LIST_ENHANCED)
                    assert_memory_equal(list.extra + want.offset, full.extra + want.offset, want.count * 4ull);
            }
            list_free(&list);
        }
        list_free(&full);
    }
    free(depth);
}

/* ---- one tile, looked into along its axis ---- */

enum { SIDE = 16 };

static struct gpu_view tile_view(void) {
    fnl_camera camera = fnl_camera_default();
    camera.vertical_fov = 0.1f;
    return view_from_camera(&camera, SIDE, SIDE);
}

static void place(const struct gpu_view *view, uint32_t index, double view_depth, double radius) {
    double at[3], world[3];
    view_of_pixel(view, SIDE / 2.0, SIDE / 2.0, view_depth, at);
    view_to_world(view, at, world);
    params[index] = fnl_light_params_default();
    params[index].position = vec3_make((float)world[0], (float)world[1], (float)world[2]);
    params[index].range = (float)radius;
    lights[index] = list_light_of(&params[index], index);
}

/* Columns of pixels at two depths. */
static void two_depths(const struct gpu_view *view, float *depth, double a, double b) {
    for (uint32_t i = 0; i < SIDE * SIDE; i++) depth[i] = depth_of_view_depth(view, i % SIDE < 5 ? a : b);
}

static uint32_t bits_of(const struct list_copy *list, uint32_t cell) {
    uint32_t bits = 0;
    for (uint32_t i = 0; i < list->cells[cell].count; i++) bits |= 1u << list->ids[list->cells[cell].offset + i];
    return bits;
}

static void test_halves_ES_45(void **state) {
    UNUSED(state);
    struct gpu_view view = tile_view();
    float depth[SIDE * SIDE];
    place(&view, 0, 2.5, 1);  /* by the near surface */
    place(&view, 1, 20, 1);   /* by the far one */
    place(&view, 2, 11, 1);   /* in the gap, where the halves meet */
    place(&view, 3, 11, 9.5); /* everywhere */
    place(&view, 4, 6, 1);    /* in the near half, but its surfaces are not there */
    struct list_request r = request_of(LIST_HALFZ, &view, depth, 5);
    two_depths(&view, depth, 2, 20);
    struct list_copy list = list_build(&r);
    assert_int_equal(list.cell_count, 2);
    assert_int_equal(bits_of(&list, 0), 1 | 8);
    assert_int_equal(bits_of(&list, 1), 2 | 8);
    float split;
    memcpy(&split, list.extra, 4);
    assert_float_equal(split, 11, 0.01f);
    list_free(&list);
    two_depths(&view, depth, 20, 20); /* flat: whichever half a pixel takes has the wall's lights */
    list = list_build(&r);
    assert_int_equal(bits_of(&list, 0), 2 | 8);
    assert_int_equal(bits_of(&list, 1), 2 | 8);
    list_free(&list);
    two_depths(&view, depth, 7, 20); /* the far half begins at 13.5 */
    list = list_build(&r);
    assert_int_equal(bits_of(&list, 0), 8 | 16);
    list_free(&list);
}

/* The figure has 8 cells: surfaces in 10000001, a light over 11000000, so 10000000 is left and the light stays. */
static void test_figure_ES_46(void **state) {
    UNUSED(state);
    struct gpu_view view = tile_view();
    float depth[SIDE * SIDE];
    place(&view, 0, 10.9, 1);   /* the two nearest of 8 cells from 10 to 18 */
    place(&view, 1, 14, 2);     /* the gap */
    place(&view, 2, 11.5, 0.4); /* the second cell alone */
    place(&view, 3, 17.9, 0.5);
    struct list_request r = request_of(LIST_25D, &view, depth, 4);
    two_depths(&view, depth, 10, 18);
    struct list_copy list = list_build(&r);
    uint32_t eighths = 0;
    for (uint32_t i = 0; i < 32; i++)
        if (list.extra[0] >> i & 1) eighths |= 0x80u >> i / 4;
    assert_int_equal(eighths, 0x81);
    assert_int_equal(bits_of(&list, 0), 1 | 8);
    list_free(&list);
    r.builder = LIST_TILED; /* which plain tiles do not see */
    list = list_build(&r);
    assert_int_equal(bits_of(&list, 0), 15);
    list_free(&list);
    r.builder = LIST_25D;
    for (int orthographic = 0; orthographic < 2; orthographic++) { /* no depth between nearest and farthest */
        two_depths(&view, depth, 10, 10);
        list = list_build(&r);
        assert_int_equal(bits_of(&list, 0), 1);
        assert_true(list.extra[0] != 0);
        list_free(&list);
    }
}

/* Cells of a tile's depths `low` .. `high`, of 32: where `ends` are its nearest and farthest. */
static uint32_t mask_between(const double ends[2], double low, double high) {
    double scale = 32 / fmax(ends[1] - ends[0], 1e-30);
    uint32_t first = (uint32_t)fmin(fmax((low - ends[0]) * scale, 0), 31),
             last = (uint32_t)fmin(fmax((high - ends[0]) * scale, 0), 31);
    return (0xffffffffu >> (31 - (last - first))) << first;
}

/* The mask has the cells in which pixels are, and no others; of a plain tile's lights the list has those that meet it. */
static void check_mask(const struct gpu_view *view, const float *depth, const struct list_copy *list,
                       const struct list_copy *plain, uint32_t cell) {
    uint32_t x0 = cell % list->grid.tiles_x * 16, y0 = cell / list->grid.tiles_x * 16, must = 0, may = 0;
    double ends[2] = {INFINITY, 0};
    for (int round = 0; round < 2; round++)
        for (uint32_t y = y0; y < MIN(y0 + 16, view->size.y); y++)
            for (uint32_t x = x0; x < MIN(x0 + 16, view->size.x); x++) {
                float d = depth[(size_t)y * view->size.x + x];
                if (d <= 0) continue;
                double z = view_depth_of_depth(view, d), slack = 1e-5 * z;
                if (round == 0) {
                    ends[0] = fmin(ends[0], z * (1 - 1e-4));
                    ends[1] = fmax(ends[1], z * (1 + 1e-4));
                    continue;
                }
                uint32_t near_bit = mask_between(ends, z - slack, z - slack),
                         far_bit = mask_between(ends, z + slack, z + slack);
                may |= mask_between(ends, z - slack, z + slack);
                if (near_bit == far_bit) must |= near_bit;
            }
    if (!(ends[1] > 0)) return;
    uint32_t mask = list->extra[cell];
    assert_int_equal(must & ~mask, 0);
    assert_int_equal(mask & ~may, 0);
    for (uint32_t k = 0; k < plain->cells[cell].count; k++) {
        uint32_t light = plain->ids[plain->cells[cell].offset + k];
        const double world[3] = {(double)lights[light].bounds.center.x, (double)lights[light].bounds.center.y,
                                 (double)lights[light].bounds.center.z};
        double at[3], radius = (double)lights[light].bounds.radius, slack = 1e-5 * ends[1];
        world_to_view(view, world, at);
        double wide =
            radius * (1 + 3e-4) + 3e-4 * (1e-2 + sqrt(at[0] * at[0] + at[1] * at[1] + at[2] * at[2]) * 1e-2) + slack;
        bool holds = list_holds(list, cell, light);
        assert_true(holds || !(mask & mask_between(ends, -at[2] - radius + slack,
                                                   fmax(-at[2] + radius - slack, -at[2] - radius + slack))));
        assert_true(!holds || mask & mask_between(ends, -at[2] - wide, -at[2] + wide));
    }
}

/* What a mask drops lights no pixel of the tile, and it drops all that it can. */
static void test_masks_ES_46(void **state) {
    UNUSED(state);
    struct random_state random = {51};
    uint64_t plain_entries = 0, entries = 0;
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++) {
        struct gpu_view view = list_random_view(kind, &random, WIDTH, HEIGHT);
        list_random_lights(&view, &random, LIGHTS, params, lights);
        float *depth = list_random_depth(&view, &random);
        struct list_request r = request_of(LIST_25D, &view, depth, LIGHTS);
        struct list_copy list = list_build(&r);
        r.builder = LIST_TILED;
        struct list_copy plain = list_build(&r);
        for (uint32_t c = 0; c < list.cell_count; c++) {
            for (uint32_t i = 0; i < LIGHTS; i++) assert_true(list_holds(&plain, c, i) || !list_holds(&list, c, i));
            check_mask(&view, depth, &list, &plain, c);
        }
        plain_entries += list_entries(&plain);
        entries += list_entries(&list);
        list_free(&plain);
        list_free(&list);
        free(depth);
    }
    print_message("%llu entries of plain tiles, %llu with masks\n", (unsigned long long)plain_entries,
                  (unsigned long long)entries);
    assert_true((double)entries < 0.97 * (double)plain_entries);
}

static double depth_of_code(uint32_t code) {
    uint32_t bits = (code + (116 << 11)) << 12;
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* Ranges hold all that rays through the tile see of the sphere, and hardly more; and the builder of trees finds the same. */
static void test_ranges_ES_65(void **state) {
    UNUSED(state);
    enum { RAYS = 24 };
    struct random_state random = {61};
    double seen_length = 0, range_length = 0, light_length = 0;
    uint64_t other = 0, entries = 0;
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++) {
        struct gpu_view view = list_random_view(kind, &random, WIDTH, HEIGHT);
        list_random_lights(&view, &random, LIGHTS, params, lights);
        struct list_request r = request_of(LIST_ENHANCED, &view, NULL, LIGHTS);
        r.tiled.cone_tests = false;
        struct list_copy list = list_build(&r);
        struct light_tree tree;
        light_tree_init(&tree, gpu_host(harness_device()));
        struct gpu_entity_bounds *bounds = list_bounds_of(lights, LIGHTS);
        assert_int_equal(light_tree_see(&tree, bounds, LIGHTS, 1u << GPU_ENTITY_LIGHT, &view), FNL_OK);
        free(bounds);
        assert_int_equal(light_tree_build(&tree, gpu_jobs(harness_device()), &list.grid, &view, true), FNL_OK);
        for (uint32_t c = 0; c < list.cell_count; c++) {
            uint32_t x0 = c % list.grid.tiles_x * 16, y0 = c / list.grid.tiles_x * 16;
            double x_size = MIN(x0 + 16, WIDTH) - x0, y_size = MIN(y0 + 16, HEIGHT) - y0;
            for (uint32_t k = 0; k < list.cells[c].count; k++) {
                uint32_t light = list.ids[list.cells[c].offset + k], range = list.extra[list.cells[c].offset + k];
                double low = INFINITY, high = 0, radius = lights[light].bounds.radius, center[3], near[3], far[3];
                vec3 seen = mat4_point(&view.world_to_view, lights[light].bounds.center);
                center[0] = seen.x;
                center[1] = seen.y;
                center[2] = seen.z;
                for (int i = 0; i <= RAYS * (RAYS + 2); i++) {
                    double x = x0 + x_size * (i % (RAYS + 1)) / RAYS, y = y0 + y_size * (i / (RAYS + 1)) / RAYS;
                    view_of_pixel(&view, x, y, 1, near);
                    view_of_pixel(&view, x, y, 2, far);
                    double a = 0, b = 0, e = -radius * radius; /* along near + t (far - near), view depth 1 + t */
                    for (int m = 0; m < 3; m++) {
                        double d = far[m] - near[m], o = near[m] - center[m];
                        a += d * d;
                        b += d * o;
                        e += o * o;
                    }
                    if (b * b < a * e) continue;
                    double half = sqrt(b * b - a * e) / a, middle = 1 - b / a;
                    if (middle + half < 0) continue;
                    low = fmin(low, fmax(middle - half, 0));
                    high = fmax(high, middle + half);
                }
                light_length += 2 * radius;
                range_length += fmin(depth_of_code((range >> 16) + 1) - depth_of_code(range & 0xffff), 2 * radius);
                if (low > high) continue;
                seen_length += high - low;
                assert_true(range_holds(range, low) && range_holds(range, high));
            }
            struct gpu_cell cell = tree.cells.data[c];
            entries += cell.count;
            for (uint32_t k = 0; k < cell.count; k++) {
                uint32_t light = tree.ids.data[cell.offset + k], range = tree.ranges.data[cell.offset + k],
                         on_device = range_of(&list, c, light);
                double near_off = depth_of_code(range & 0xffff) - depth_of_code(on_device & 0xffff),
                       far_off = depth_of_code(range >> 16) - depth_of_code(on_device >> 16);
                other += fabs(near_off) > 0.005 * (1 + depth_of_code(range & 0xffff)) ||
                         fabs(far_off) > 0.005 * (1 + depth_of_code(range >> 16));
            }
        }
        list_free(&list);
        light_tree_finish(&tree);
    }
    print_message("lengths: lights %.0f, ranges %.0f, seen %.0f m; %llu of %llu entries are others on the CPU\n",
                  light_length, range_length, seen_length, (unsigned long long)other, (unsigned long long)entries);
    assert_true(range_length < 1.04 * seen_length && seen_length < 0.9 * light_length);
    assert_true(other * 100 < entries);
}

/* Least and greatest view depth of a spot's cone. */
static void cone_extent(const struct gpu_view *view, const struct list_light *light, double out[2]) {
    const double at[3] = {(double)light->shape.position.x, (double)light->shape.position.y, (double)light->shape.position.z};
    double apex[3], axis = 0, range = (double)light->shape.range;
    world_to_view(view, at, apex);
    for (int k = 0; k < 3; k++) axis -= (double)view->world_to_view.m[4 * k + 2] * (double)(&light->shape.direction.x)[k];
    double cosine = fmax(-(double)light->shape.spot_offset / (double)light->shape.spot_scale, 0),
           sine = sqrt(fmax(1 - cosine * cosine, 0));
    for (int end = 0; end < 2; end++) { /* the nearest point, the farthest */
        double sign = end ? 1 : -1, along = sign * axis;
        double rim = cosine * along + sine * sqrt(fmax(1 - along * along, 0));
        out[end] = -apex[2] + sign * range * (along >= cosine ? 1 : fmax(rim, 0));
    }
}

/* A cone cuts a range to its own depths, which are much shorter than those of its sphere. */
static void test_ranges_of_cones_ES_65(void **state) {
    UNUSED(state);
    struct random_state random = {67};
    double lengths[2] = {0};
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++) {
        struct gpu_view view = list_random_view(kind, &random, WIDTH, HEIGHT);
        list_random_lights(&view, &random, LIGHTS, params, lights);
        for (uint32_t i = 0; i < LIGHTS; i++) {
            params[i].kind = FNL_LIGHT_SPOT;
            params[i].outer_cone_angle = 0.1f + 0.001f * (float)i;
            params[i].inner_cone_angle = 0;
            lights[i] = list_light_of(&params[i], i);
        }
        struct list_request r = request_of(LIST_ENHANCED, &view, NULL, LIGHTS);
        for (int cones = 0; cones < 2; cones++) {
            r.tiled.cone_tests = cones;
            struct list_copy list = list_build(&r);
            for (uint32_t c = 0; c < list.cell_count; c++)
                for (uint32_t k = 0; k < list.cells[c].count; k++) {
                    uint32_t light = list.ids[list.cells[c].offset + k], range = list.extra[list.cells[c].offset + k];
                    double ends[2], low = depth_of_code(range & 0xffff), high = depth_of_code((range >> 16) + 1);
                    cone_extent(&view, &lights[light], ends);
                    double slack = 2e-3 * (1 + fabs(ends[0]) + fabs(ends[1]) + (double)lights[light].shape.range);
                    lengths[cones] += fmin(high, 1000) - low;
                    if (cones) assert_true(low >= ends[0] - slack && high <= fmax(ends[1], 0) + slack);
                }
            list_free(&list);
        }
    }
    print_message("lengths of spots' ranges: %.0f m by spheres, %.0f m by cones\n", lengths[0], lengths[1]);
    assert_true(lengths[1] < 0.5 * lengths[0]);
}

/* ---- evaluations ---- */

static uint64_t evaluations(struct stage *s, fnl_shading shading, fnl_light_lists lists) {
    fnl_frame frame = s->frame;
    frame.shading = shading;
    frame.lists = lists;
    frame.count_lights = true;
    struct shot shot = stage_shoot(s, &frame);
    uint64_t count = shot.stats.evaluations;
    shot_free(&shot);
    return count;
}

static void test_evaluations_ES_45_ES_46_ES_65(void **state) {
    UNUSED(state);
    struct stage pole = stage_open("builtin:pole", 0);
    uint64_t tiled = evaluations(&pole, FNL_SHADING_DEFERRED, FNL_LISTS_TILED),
             halfz = evaluations(&pole, FNL_SHADING_DEFERRED, FNL_LISTS_HALFZ),
             masks = evaluations(&pole, FNL_SHADING_DEFERRED, FNL_LISTS_25D),
             ranges = evaluations(&pole, FNL_SHADING_FORWARD, FNL_LISTS_ENHANCED),
             endless = evaluations(&pole, FNL_SHADING_FORWARD, FNL_LISTS_TILED);
    print_message(
        "evaluations at silhouettes: tiled %llu, halfz %llu, 2.5d %llu; without depth: tiled %llu, enhanced %llu\n",
        (unsigned long long)tiled, (unsigned long long)halfz, (unsigned long long)masks, (unsigned long long)endless,
        (unsigned long long)ranges);
    assert_true((double)halfz < 0.7 * (double)tiled);
    assert_true((double)masks < 0.9 * (double)tiled);
    assert_true((double)ranges < 0.5 * (double)endless);
    stage_close(&pole);
}

/* Work groups have as many rows of threads as the device's subgroups; lists are the same to the bit. */
static void test_any_size_of_subgroups_gives_the_same_lists(void **state) {
    UNUSED(state);
    static const struct {
        uint32_t subgroup, rows;
    } sizes[] = {{8, 1}, {4, 1}, {16, 2}, {32, 4}, {64, 8}, {128, 8}};
    static const enum list_builder kinds[] = {LIST_TILED, LIST_TILED, LIST_HALFZ, LIST_25D};
    struct random_state random = {17};
    struct gpu_view view = list_random_view(0, &random, WIDTH, HEIGHT);
    list_random_lights(&view, &random, LIGHTS, params, lights);
    float *depth = list_random_depth(&view, &random);
    static float front[WIDTH * HEIGHT]; /* glass before some pixels, behind others, elsewhere none */
    for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) front[i] = i % WIDTH < 100 ? depth[i] * (i % 5 == 1 ? 1.5f : i % 3 == 1 ? 0.8f : 0) : 0;
    fnl_device_info *info = (fnl_device_info *)(uintptr_t)gpu_info(harness_device());
    const uint32_t own = info->subgroup_size;
    spy_begin(harness_device());
    for (uint32_t k = 0; k < COUNT_OF(kinds); k++) {
        struct list_request r = request_of(kinds[k], &view, depth, LIGHTS);
        if (k == 1) r.front = front;
        struct list_copy first = {0};
        for (uint32_t i = 0; i < COUNT_OF(sizes); i++) {
            info->subgroup_size = sizes[i].subgroup;
            spy_clear();
            struct list_copy list = list_build(&r);
            uint32_t found = 0;
            for (uint32_t w = 0; w < spy.work_count; w++) {
                const struct gpu_compute_params *pipeline = spy_compute_params(spy.work[w].pipeline);
                if (!pipeline || !strstr(pipeline->shader->name, "_bounds")) continue;
                assert_int_equal(pipeline->constants[2], sizes[i].rows);
                found++;
            }
            if (found != 1) fail_msg("%u dispatches, %u of bounds", spy.work_count, found);
            if (i == 0) {
                first = list;
                if (list_entries(&first) < 200) fail_msg("builder %u: %llu entries", k, (unsigned long long)list_entries(&first));
                continue;
            }
            if (!list_equal(&first, &list)) fail_msg("builder %u: other lists with subgroups of %u", k, sizes[i].subgroup);
            list_free(&list);
        }
        list_free(&first);
    }
    info->subgroup_size = own;
    spy_end();
    free(depth);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_halves_ES_45, harness_check),
        cmocka_unit_test_teardown(test_figure_ES_46, harness_check),
        cmocka_unit_test_teardown(test_sets_ES_45_ES_46_ES_65, harness_check),
        cmocka_unit_test_teardown(test_masks_ES_46, harness_check),
        cmocka_unit_test_teardown(test_ranges_ES_65, harness_check),
        cmocka_unit_test_teardown(test_ranges_of_cones_ES_65, harness_check),
        cmocka_unit_test_teardown(test_sizes_and_counts, harness_check),
        cmocka_unit_test_teardown(test_overflow, harness_check),
        cmocka_unit_test_teardown(test_any_size_of_subgroups_gives_the_same_lists, spy_tear_down),
        cmocka_unit_test_teardown(test_evaluations_ES_45_ES_46_ES_65, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
