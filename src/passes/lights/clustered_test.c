/* SPDX-License-Identifier: MIT */
/** The clusters' lists of both builders, entry by entry, against geometry in double precision and sampled points. */
#include "base/jobs.h"
#include "tests/list_bench.h"

enum { LIGHTS = 400, WIDTH = 301, HEIGHT = 173, POINTS = 20000 };

static fnl_light_params params[4096];
static struct list_light lights[4096];

static struct list_request request_of(const struct gpu_view *view, enum list_builder builder, uint32_t light_count) {
    struct list_request r = {.builder = builder,
                             .view = *view,
                             .lights = lights,
                             .light_count = light_count,
                             .tiled = tiled_params_default(),
                             .clustered = clustered_params_default()};
    r.clustered.tile_size = 32;
    return r;
}

/* Random points in the view, surfaces or air: no light that reaches them is missing. Returns the pairs that are lit. */
static uint64_t check_points(const struct list_request *r, const struct list_copy *list, struct random_state *random,
                             double nearest, double farthest) {
    uint64_t lit = 0;
    for (uint32_t k = 0; k < POINTS; k++) {
        double view_depth = nearest * exp2((double)random_float(random) * log2(farthest / nearest)), seen[3], point[3];
        double x = (double)random_range(random, 0, (float)r->view.size.x),
               y = (double)random_range(random, 0, (float)r->view.size.y);
        view_of_pixel(&r->view, x, y, view_depth, seen);
        view_to_world(&r->view, seen, point);
        uint32_t cells[2];
        list_cells_of(list, MIN((uint32_t)x, r->view.size.x - 1), MIN((uint32_t)y, r->view.size.y - 1), view_depth, cells);
        for (uint32_t i = 0; i < r->light_count; i++) {
            if (!light_reaches(&params[i], point)) continue;
            lit++;
            assert_true(list_holds(list, cells[0], i) && list_holds(list, cells[1], i));
        }
    }
    return lit;
}

static void test_sets_ES_50_ES_53(void **state) {
    UNUSED(state);
    struct random_state random = {21};
    uint64_t lit = 0;
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++) {
        struct gpu_view view = list_random_view(kind, &random, WIDTH - 3 * kind, HEIGHT + kind);
        list_random_lights(&view, &random, LIGHTS, params, lights);
        struct list_request r = request_of(&view, LIST_CLUSTERED, LIGHTS);
        struct list_copy gpu = list_build(&r), again = list_build(&r);
        list_check_form(&gpu, LIGHTS);
        assert_true(list_equal(&gpu, &again));
        reference_check(&r, &gpu);
        lit += check_points(&r, &gpu, &random, (double)view.near_distance, 300);
        r.builder = LIST_CLUSTERED_CPU;
        struct list_copy cpu = list_build(&r);
        list_check_form(&cpu, LIGHTS);
        lit += check_points(&r, &cpu, &random, (double)view.near_distance, 300);

        /* Two different tests of the same cells; both hold whatever touches them. */
        uint64_t common = 0, entries[2] = {list_entries(&gpu), list_entries(&cpu)};
        for (uint32_t c = 0; c < gpu.cell_count; c++)
            for (uint32_t k = 0; k < gpu.cells[c].count; k++)
                common += list_holds(&cpu, c, gpu.ids[gpu.cells[c].offset + k]);
        print_message("%s: %llu entries on the GPU, %llu on the CPU, %llu in both\n", list_view_names[kind],
                      (unsigned long long)entries[0], (unsigned long long)entries[1], (unsigned long long)common);
        assert_true((double)common > 0.8 * (double)entries[0]);
        list_free(&gpu);
        list_free(&again);
        list_free(&cpu);
    }
    assert_true(lit > 10000);
}

/* Slices as they are asked for: the first ends at `near`, the last begins at `far`, and those between are alike. */
static void test_distributions_ES_50_ES_51(void **state) {
    UNUSED(state);
    for (int linear = 0; linear < 2; linear++) {
        struct clustered_params p = clustered_params_default();
        p.near = 2;
        p.far = 50;
        p.slices = 18;
        p.linear = linear;
        struct list_copy list = {0};
        clustered_grid(&list.grid, 64, 64, &p);
        uint32_t cells[2];
        for (uint32_t k = 0; k <= 16; k++) {
            double start = linear ? 2 + 48.0 * k / 16 : 2 * pow(25, k / 16.0);
            list_cells_of(&list, 0, 0, start * 0.999, cells);
            assert_int_equal(cells[0], k);
            list_cells_of(&list, 0, 0, start * 1.001, cells);
            assert_int_equal(cells[0], k + 1);
        }
    }
}

static void test_grids_and_counts_ES_53(void **state) {
    UNUSED(state);
    static const uint32_t counts[] = {0, 1, 255, 256, 257, 2048};
    static const struct {
        uint32_t width, height, tile_size, slices;
        float near, far;
        bool linear;
    } grids[] = {{1, 1, 64, 24, 0.5f, 100, false},    {65, 3, 64, 1, 0.5f, 100, true}, {97, 61, 16, 2, 1, 2, false},
                 {97, 61, 48, 3, 3, 4, false},        {97, 61, 48, 3, 3, 4, true},     {120, 67, 40, 64, 0.01f, 1000, false},
                 {120, 67, 40, 64, 0.01f, 1000, true}};
    struct random_state random = {4};
    for (uint32_t g = 0; g < COUNT_OF(grids); g++)
        for (uint32_t c = 0; c < COUNT_OF(counts); c++)
            for (int cpu = 0; cpu < 2; cpu++) {
                if (counts[c] > 257 && g != 3) continue;
                struct gpu_view view = list_random_view(g % LIST_VIEWS, &random, grids[g].width, grids[g].height);
                list_random_lights(&view, &random, counts[c], params, lights);
                struct list_request r = request_of(&view, cpu ? LIST_CLUSTERED_CPU : LIST_CLUSTERED, counts[c]);
                r.clustered.tile_size = grids[g].tile_size;
                r.clustered.slices = grids[g].slices;
                r.clustered.near = grids[g].near;
                r.clustered.far = grids[g].far;
                r.clustered.linear = grids[g].linear;
                struct list_copy list = list_build(&r);
                list_check_form(&list, counts[c]);
                if (!cpu) reference_check(&r, &list);
                list_free(&list);
            }
}

/* Nearer than the first slice's end and beyond the last one's start there are still cells, and they hold their lights. */
static void test_depths_outside_ES_51(void **state) {
    UNUSED(state);
    struct random_state random = {8};
    for (int cpu = 0; cpu < 2; cpu++)
        for (uint32_t kind = 0; kind < 4; kind++) {
            struct gpu_view view = list_random_view(kind % 2, &random, WIDTH, HEIGHT);
            list_random_lights(&view, &random, LIGHTS, params, lights);
            for (uint32_t i = 0; i < LIGHTS; i += 2) { /* half of them very near, or very far and large */
                double at[3], world[3], depth = i % 4 ? 0.3 : 3000;
                view_of_pixel(&view, (double)random_range(&random, 0, WIDTH), (double)random_range(&random, 0, HEIGHT),
                              depth, at);
                view_to_world(&view, at, world);
                params[i].position = vec3_make((float)world[0], (float)world[1], (float)world[2]);
                params[i].range = i % 4 ? 0.3f : 700;
                lights[i] = list_light_of(&params[i], i);
            }
            struct list_request r = request_of(&view, cpu ? LIST_CLUSTERED_CPU : LIST_CLUSTERED, LIGHTS);
            r.clustered.near = 2;
            r.clustered.far = 20;
            r.clustered.linear = kind >= 2;
            struct list_copy list = list_build(&r);
            assert_true(check_points(&r, &list, &random, 0.05, 2) > 100);
            assert_true(check_points(&r, &list, &random, 20, 1e4) > 100);
            uint32_t cells[2];
            const double depths[] = {1e-30, 1e-3, 1.999, 20.001, 1e6, 1e30};
            for (uint32_t k = 0; k < COUNT_OF(depths); k++) {
                list_cells_of(&list, WIDTH - 1, HEIGHT - 1, depths[k], cells);
                uint32_t slice = cells[0] / (list.grid.tiles_x * list.grid.tiles_y);
                assert_int_equal(slice, k < 3 ? 0 : list.grid.slices - 1);
                assert_true(cells[0] < list.cell_count);
            }
            list_free(&list);
        }
}

/* ---- the voxeliser ---- */

/* Lists by screen and depth extents alone: slices, rows and columns of the sphere's box, each by its tangent planes. */
static bool in_box_fill(const struct list_request *r, const struct list_copy *list, uint32_t cell, uint32_t light) {
    const struct gpu_light_list *g = &list->grid;
    uint32_t tile = cell % (g->tiles_x * g->tiles_y), x = tile % g->tiles_x, y = tile / g->tiles_x,
             slice = cell / (g->tiles_x * g->tiles_y);
    /* A column of all rows and slices, a row of all columns and slices, a slice of all tiles. */
    for (int axis = 0; axis < 3; axis++) {
        struct list_request one = *r;
        struct gpu_light_list grid = *g;
        struct reference_cell cells[2];
        uint32_t first = axis == 0 ? x : axis == 1 ? y * g->tiles_x : slice * g->tiles_x * g->tiles_y;
        uint32_t last = axis == 0   ? first + (g->tiles_y - 1) * g->tiles_x
                        : axis == 1 ? first + g->tiles_x - 1
                                    : first + g->tiles_x * g->tiles_y - 1;
        if (axis < 2) last += (g->slices - 1) * g->tiles_x * g->tiles_y;
        cells[0] = reference_cell_of(&one, &grid, first, 2e-4);
        cells[1] = reference_cell_of(&one, &grid, last, 2e-4);
        struct reference_cell both = cells[0]; /* left, top and near of the first; right, bottom and far of the last */
        memcpy(both.planes[1], cells[1].planes[1], sizeof both.planes[1]);
        memcpy(both.planes[2], cells[1].planes[2], sizeof both.planes[2]);
        both.low[2] = cells[1].low[2];
        if (!reference_touches(&both, r, light, 3e-4, false)) return false;
    }
    return true;
}

/*
 * What the voxeliser is to do: the light's sphere, what its slice leaves of it, shrunk onto the slice's face, and what its row leaves of that, shrunk
 * onto the row's, all touch the column.
 */
static bool in_shrunk_fill(const struct list_request *r, const struct list_copy *list, uint32_t cell, uint32_t light) {
    struct reference_cell c = reference_cell_of(r, &list->grid, cell, 2e-4);
    const double world[3] = {(double)lights[light].bounds.center.x, (double)lights[light].bounds.center.y,
                             (double)lights[light].bounds.center.z};
    double at[3], radius = (double)lights[light].bounds.radius, row = 0;
    world_to_view(&r->view, world, at);
    radius = radius * (1 + 3e-4) + 3e-4 * (1e-2 + sqrt(at[0] * at[0] + at[1] * at[1] + at[2] * at[2]) * 1e-2);
    for (int stage = 0; stage < 3; stage++) {
        if (stage == 1) { /* onto the slice's face */
            double depth = fmin(fmax(-at[2], -c.high[2]), -c.low[2]), cut = depth + at[2];
            radius = sqrt(fmax(radius * radius - cut * cut, 0));
            at[2] = -depth;
        } else if (stage == 2) { /* onto the row's */
            const double *plane = c.planes[2];
            for (int i = 2; i < 4; i++) {
                double outside = -(c.planes[i][1] * at[1] + c.planes[i][2] * at[2] + c.planes[i][3]);
                if (outside > row) row = outside, plane = c.planes[i];
            }
            radius = sqrt(fmax(radius * radius - row * row, 0));
            at[1] += row * plane[1];
            at[2] += row * plane[2];
        }
        for (int i = 0; i < (stage == 2 ? 2 : 4); i++)
            if (c.planes[i][0] * at[0] + c.planes[i][1] * at[1] + c.planes[i][2] * at[2] + c.planes[i][3] < -radius - 1e-5)
                return false;
    }
    return true;
}

static void test_voxels_ES_52(void **state) {
    UNUSED(state);
    struct random_state random = {33};
    uint64_t voxels = 0, boxes = 0, shrunk = 0, held_in_front = 0;
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++) {
        struct gpu_view view = list_random_view(kind, &random, WIDTH, HEIGHT);
        list_random_lights(&view, &random, 80, params, lights);
        struct list_request r = request_of(&view, LIST_CLUSTERED_CPU, 80);
        struct list_copy list = list_build(&r);
        list_check_form(&list, 80);
        assert_true(check_points(&r, &list, &random, (double)view.near_distance, 300) > 100);
        bool behind[80];
        for (uint32_t i = 0; i < 80; i++) behind[i] = mat4_point(&view.world_to_view, lights[i].bounds.center).z > 0;
        for (uint32_t c = 0; c < list.cell_count; c++)
            for (uint32_t i = 0; i < 80; i++) {
                if (!reference_in_view(&r, i)) continue;
                bool held = list_holds(&list, c, i), boxed = in_box_fill(&r, &list, c, i);
                /* Beyond a right angle from the centre the distances of edges fall again: the scan stops early. */
                assert_true(boxed || !held || behind[i] || kind == 4);
                if (boxed && !behind[i] && kind != 4) { /* what boxes hold and shrinking does not is not there */
                    bool is_shrunk = in_shrunk_fill(&r, &list, c, i);
                    assert_true(is_shrunk || !held);
                    shrunk += is_shrunk;
                    held_in_front += held;
                }
                voxels += held;
                boxes += boxed;
            }
        list_free(&list);
    }
    print_message("%llu voxels, %llu by bounding boxes; before the viewer %llu, of %llu where shrunk spheres touch\n",
                  (unsigned long long)voxels, (unsigned long long)boxes, (unsigned long long)held_in_front,
                  (unsigned long long)shrunk);
    assert_true(held_in_front > 10000 && shrunk < held_in_front + held_in_front / 50);
    assert_true((double)voxels < 0.9 * (double)boxes);
}

static void test_threads_ES_52(void **state) {
    UNUSED(state);
    struct random_state random = {34};
    struct gpu_view view = list_random_view(0, &random, WIDTH, HEIGHT);
    list_random_lights(&view, &random, LIGHTS, params, lights);
    struct list_request r = request_of(&view, LIST_CLUSTERED_CPU, LIGHTS);
    struct gpu_light_list grid = list_grid(&r);
    struct clustered_cpu_view cpu_view = {view.ndc_scale, view.ndc_offset, false, WIDTH, HEIGHT};
    struct list_copy first = {0};
    for (uint32_t threads = 1; threads <= 5; threads++) {
        fnl_host host = host_resolve(NULL);
        host.thread_count = threads;
        struct jobs *jobs;
        assert_int_equal(jobs_create(&host, &jobs), FNL_OK);
        assert_int_equal(jobs_thread_count(jobs), threads);
        struct clustered_cpu builder;
        clustered_cpu_init(&builder, &host);
        for (uint32_t i = 0; i < LIGHTS; i++) {
            struct clustered_cpu_sphere sphere = {mat4_point(&view.world_to_view, lights[i].bounds.center),
                                                  lights[i].bounds.radius};
            assert_true(array_push(&host, &builder.spheres, sphere));
        }
        assert_int_equal(clustered_cpu_build(&builder, jobs, &grid, &cpu_view), FNL_OK);
        struct list_copy list = list_copy_of_cpu(&builder, &grid);
        list_check_form(&list, LIGHTS);
        if (threads == 1) {
            first = list;
        } else {
            assert_true(list_equal(&first, &list));
            list_free(&list);
        }
        clustered_cpu_finish(&builder);
        jobs_destroy(&jobs);
    }
    assert_true(list_entries(&first) > 1000);
    list_free(&first);
}

/* ---- cones ---- */

/* Whatever a spot's cone test drops does not touch the cluster, as double precision says; and it drops most of what spheres keep. */
static void test_spot_cones_ES_62(void **state) {
    UNUSED(state);
    struct random_state random = {62};
    uint64_t spheres = 0, cones = 0, lit = 0;
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++) {
        struct gpu_view view = list_random_view(kind, &random, WIDTH, HEIGHT);
        list_random_lights(&view, &random, 300, params, lights);
        for (uint32_t i = 0; i < 300; i++) {
            params[i].kind = FNL_LIGHT_SPOT;
            params[i].direction = vec3_normalize(
                vec3_make(random_range(&random, -1, 1), random_range(&random, -1, 1), random_range(&random, -1, 1)));
            params[i].range = exp2f(random_range(&random, -1, 4.5f));
            params[i].outer_cone_angle = exp2f(random_range(&random, -6, 0));
            params[i].inner_cone_angle = params[i].outer_cone_angle * 0.5f;
            lights[i] = list_light_of(&params[i], i);
        }
        struct list_request r = request_of(&view, LIST_CLUSTERED, 300);
        struct list_copy tight = list_build(&r);
        r.clustered.cone_tests = false;
        struct list_copy loose = list_build(&r);
        for (uint32_t c = 0; c < tight.cell_count; c++)
            for (uint32_t i = 0; i < tight.cells[c].count; i++)
                assert_true(list_holds(&loose, c, tight.ids[tight.cells[c].offset + i]));
        r.clustered.cone_tests = true;
        reference_check(&r, &tight);
        lit += check_points(&r, &tight, &random, (double)view.near_distance, 300);
        spheres += list_entries(&loose);
        cones += list_entries(&tight);
        list_free(&tight);
        list_free(&loose);
    }
    print_message("entries of spots: %llu by spheres, %llu by cones; %llu lit pairs\n", (unsigned long long)spheres,
                  (unsigned long long)cones, (unsigned long long)lit);
    assert_true(spheres > 100000 && lit > 1000);
    assert_true((double)cones < 0.5 * (double)spheres);
}

/* ---- a row of lamps that a picture shows in one tile ---- */

static void test_lamp_row_ES_50(void **state) {
    UNUSED(state);
    enum { LAMPS = 200 };
    uint32_t least = UINT32_MAX, most = 0, tile = 0;
    for (uint32_t step = 0; step < 12; step++) { /* the camera walks along the row */
        fnl_camera camera = fnl_camera_default();
        camera.position = vec3_make(0, 2.2f, 2 - 0.7f * (float)step);
        camera.target = vec3_make(0, 2.2f, -1000);
        struct gpu_view view = view_from_camera(&camera, WIDTH, HEIGHT);
        for (uint32_t i = 0; i < LAMPS; i++) {
            params[i] = fnl_light_params_default();
            params[i].position = vec3_make(0, 2.2f, -3 - 4 * (float)i);
            params[i].range = 3;
            lights[i] = list_light_of(&params[i], i);
        }
        for (int cpu = 0; cpu < 2; cpu++) {
            struct list_request r = request_of(&view, cpu ? LIST_CLUSTERED_CPU : LIST_CLUSTERED, LAMPS);
            r.clustered.near = 1;
            r.clustered.far = 1000;
            r.clustered.slices = 115;
            struct list_copy list = list_build(&r);
            least = MIN(least, list_longest(&list));
            most = MAX(most, list_longest(&list));
            list_free(&list);
        }
        struct list_request tiles = request_of(&view, LIST_TILED, LAMPS);
        struct list_copy list = list_build(&tiles);
        tile = MAX(tile, list_longest(&list));
        list_free(&list);
    }
    print_message("lamps in a row: the fullest cluster holds %u .. %u, the fullest tile %u\n", least, most, tile);
    assert_int_equal(tile, LAMPS);
    assert_true(most <= LAMPS / 8 && most <= least + least / 2);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_sets_ES_50_ES_53, harness_check),
        cmocka_unit_test_teardown(test_distributions_ES_50_ES_51, harness_check),
        cmocka_unit_test_teardown(test_grids_and_counts_ES_53, harness_check),
        cmocka_unit_test_teardown(test_depths_outside_ES_51, harness_check),
        cmocka_unit_test_teardown(test_voxels_ES_52, harness_check),
        cmocka_unit_test_teardown(test_threads_ES_52, harness_check),
        cmocka_unit_test_teardown(test_spot_cones_ES_62, harness_check),
        cmocka_unit_test_teardown(test_lamp_row_ES_50, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
