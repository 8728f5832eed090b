/* SPDX-License-Identifier: MIT */
/**
 * Lists by conservative rasterisation: what they cost, slices, pools that overflow, forms of storage, and whole pictures. Numbers of the
 * checklist are those of the digest of "Clustered Shading: Assigning Lights Using Conservative Rasterization in DirectX 12".
 */
#include "tests/raster_bench.h"
#include "tests/frame_plain.h"

enum { LIGHTS = 300, MOST = 65536, WIDTH = 301, HEIGHT = 173 };

static fnl_light_params params[MOST];
static struct list_light lights[MOST];

/* ---- lights per pixel ---- */

static double mean_per_pixel(const struct list_copy *list, const struct gpu_view *view, const float *depth) {
    uint64_t sum = 0, pixels = 0;
    for (uint32_t y = 1; y < view->size.y; y += 5)
        for (uint32_t x = 1; x < view->size.x; x += 5) {
            float d = depth[(size_t)y * view->size.x + x];
            uint32_t cells[2];
            if (d <= 0) continue;
            list_cells_of(list, x, y,
                          ((double)view->depth_decode.x + (double)view->depth_decode.y * (double)d) /
                              ((double)view->depth_decode.z + (double)view->depth_decode.w * (double)d),
                          cells);
            sum += list->cells[cells[0]].count;
            pixels++;
        }
    return (double)sum / (double)pixels;
}

static void test_lights_per_pixel(void **state) {
    UNUSED(state);
    enum { COUNT = 512, W = 1536, H = 768 };
    struct random_state random = {9};
    double ratio[2];
    for (int spots = 0; spots < 2; spots++) {
        struct gpu_view view = list_random_view(0, &random, W, H);
        float *depth = list_random_depth(&view, &random);
        for (uint32_t i = 0; i < COUNT; i++) {
            double at[3], world[3];
            view_of_pixel(&view, (double)random_range(&random, 0, W), (double)random_range(&random, 0, H),
                          (double)random_range(&random, 1, 60), at);
            view_to_world(&view, at, world);
            params[i] = fnl_light_params_default();
            params[i].position = vec3_make((float)world[0], (float)world[1], (float)world[2]);
            params[i].range = random_range(&random, 1, 4);
            if (spots || i % 2) {
                params[i].kind = FNL_LIGHT_SPOT;
                params[i].direction = vec3_normalize(
                    vec3_make(random_range(&random, -1, 1), random_range(&random, -1, 1), random_range(&random, -1, 1)));
                params[i].outer_cone_angle = 0.4f;
            }
            lights[i] = list_light_of(&params[i], i);
        }
        struct raster_request r = raster_request_of(&view, lights, COUNT);
        r.raster.grid.tile_size = 64; /* 24 x 12 x 128 */
        r.raster.grid.slices = 128;
        struct raster_copy copy = raster_build(&r);
        struct list_request tiles = {.builder = LIST_TILED,
                                     .view = view,
                                     .lights = lights,
                                     .light_count = COUNT,
                                     .depth = depth,
                                     .tiled = tiled_params_default(),
                                     .clustered = clustered_params_default()};
        tiles.tiled.cone_tests = false; /* as in the source */
        struct list_copy tiled = list_build(&tiles);
        double clustered_mean = mean_per_pixel(&copy.list, &view, depth), tiled_mean = mean_per_pixel(&tiled, &view, depth);
        ratio[spots] = clustered_mean / tiled_mean;
        print_message("lights per pixel, %s: %.2f in clusters, %.2f in tiles\n", spots ? "spots" : "points and spots",
                      clustered_mean, tiled_mean);
        list_free(&tiled);
        raster_copy_free(&copy);
        free(depth);
    }
    assert_true(ratio[0] < 1);
    assert_true(ratio[1] < 0.7);
}

/* ---- depth ---- */

static void test_slices_CL_9(void **state) {
    UNUSED(state);
    /* The source's f ends the last slice, ours begins it: one step of the same row of depths further. */
    const double n = 200, f = 3000, c = 64;
    struct clustered_params p = clustered_params_default();
    p.slices = 64;
    p.near = (float)n;
    p.far = (float)(n * pow(f / n, (c - 2) / (c - 1)));
    struct gpu_light_list grid = {0};
    clustered_grid(&grid, 1536, 768, &p);
    assert_float_equal((double)grid.slice_scale * log2(n) + (double)grid.slice_bias, 1, 1e-4);
    assert_float_equal((double)grid.slice_scale * log2(f) + (double)grid.slice_bias, c, 1e-4);
    assert_float_equal(grid.slice_scale, (c - 1) / (log2(f) - log2(n)), 1e-4);

    /* Tiny lights at random depths: the shell puts each into the slice that the formula gives, and into no other by more than a rounding. */
    struct random_state random = {3};
    fnl_camera camera = fnl_camera_default();
    camera.position = vec3_make(0, 0, 0);
    camera.target = vec3_make(0, 0, -1);
    camera.near_distance = 0.01f;
    struct gpu_view view = view_from_camera(&camera, 64, 64);
    uint32_t doubled = 0;
    for (int linear = 0; linear < 2; linear++) {
        for (uint32_t i = 0; i < MOST; i++) {
            double depth = i < 8 ? (double)(0.02f + (float)i) : exp2((double)random_range(&random, -5, 13));
            params[i] = fnl_light_params_default();
            params[i].position = vec3_make(0, 0, (float)-depth);
            params[i].range = (float)(1e-6 * depth);
            lights[i] = list_light_of(&params[i], i);
        }
        struct raster_request r = raster_request_of(&view, lights, MOST);
        r.raster.grid = p;
        r.raster.grid.linear = linear;
        r.raster.grid.tile_size = 64;
        struct raster_copy copy = raster_build(&r);
        list_check_form(&copy.list, MOST);
        for (uint32_t i = 0; i < MOST; i++) {
            double depth = -(double)params[i].position.z;
            uint32_t low = list_slice_at(&copy.list.grid, depth * (1 - 6e-5)),
                     high = list_slice_at(&copy.list.grid, depth * (1 + 6e-5));
            assert_true(list_holds(&copy.list, list_slice_at(&copy.list.grid, depth), i));
            assert_true(low == 0 || !list_holds(&copy.list, low - 1, i));
            assert_true(high == 63 || !list_holds(&copy.list, high + 1, i));
            doubled += low != high;
        }
        assert_true(copy.list.cells[0].count > 1000 && copy.list.cells[63].count > 1000); /* clamped at both ends */
        raster_copy_free(&copy);
    }
    assert_true(doubled < MOST / 50);
}

/* ---- pools ---- */

static void test_overflow_CL_10(void **state) {
    UNUSED(state);
    struct random_state random = {14};
    struct gpu_view view = list_random_view(0, &random, WIDTH, HEIGHT);
    list_random_shapes(&view, &random, LIGHTS, params, lights);
    for (uint32_t nodes = GPU_NODES_ARRAY; nodes <= GPU_NODES_32; nodes++) {
        struct raster_request r = raster_request_of(&view, lights, LIGHTS);
        r.raster.nodes = nodes;
        struct raster_copy whole = raster_build(&r);
        assert_int_equal(whole.list.totals.overflow_cells, 0);
        uint32_t entries = whole.list.totals.entries;
        for (uint32_t k = 0; k < 3; k++) {
            r.raster.grid.pool_capacity = k == 0 ? 1 : k == 1 ? entries / 2 : entries - 1;
            struct raster_copy over = raster_build(&r);
            assert_int_equal(over.list.totals.entries, entries); /* exact all the same */
            assert_true(over.list.totals.overflow_cells > 0);
            uint32_t all = 0;
            for (uint32_t c = 0; c < over.list.cell_count; c++) {
                if (over.list.cells[c].count == GPU_CELL_ALL) {
                    all++;
                    continue;
                }
                assert_int_equal(over.list.cells[c].count, whole.list.cells[c].count);
                assert_memory_equal(over.list.ids + over.list.cells[c].offset, whole.list.ids + whole.list.cells[c].offset,
                                    over.list.cells[c].count * 4);
            }
            assert_int_equal(all, over.list.totals.overflow_cells);
            struct raster_copy again = raster_build(&r); /* the dark blocks that the source would show are where they were */
            assert_true(list_equal(&over.list, &again.list));
            raster_copy_free(&over);
            raster_copy_free(&again);
        }
        raster_copy_free(&whole);
    }
}

/* Lights whose shells find no place are in all slices of all tiles of their rectangle: more than they need, and none is lost. */
static void test_slots_overflow_CL_10(void **state) {
    UNUSED(state);
    struct random_state random = {15};
    struct gpu_view view = list_random_view(3, &random, WIDTH, HEIGHT);
    list_random_shapes(&view, &random, LIGHTS, params, lights);
    struct raster_request r = raster_request_of(&view, lights, LIGHTS);
    struct raster_copy whole = raster_build(&r);
    uint32_t wanted = whole.slot_sums[LIGHTS];
    assert_true(wanted > 500 && wanted < r.raster.slot_capacity);
    for (uint32_t k = 0; k < 3; k++) {
        r.raster.slot_capacity = k == 0 ? 1 : k == 1 ? wanted / 2 : wanted;
        struct raster_copy some = raster_build(&r);
        list_check_form(&some.list, LIGHTS);
        assert_int_equal(some.slot_sums[LIGHTS], wanted);
        for (uint32_t c = 0; c < whole.list.cell_count; c++)
            for (uint32_t i = 0; i < whole.list.cells[c].count; i++)
                assert_true(list_holds(&some.list, c, whole.list.ids[whole.list.cells[c].offset + i]));
        assert_true(k == 2 ? list_equal(&some.list, &whole.list) : some.list.totals.entries > whole.list.totals.entries);
        raster_copy_free(&some);
    }
    raster_copy_free(&whole);
}

static void test_nodes_CL_11_CL_12(void **state) {
    UNUSED(state);
    struct random_state random = {16};
    for (uint32_t kind = 0; kind < 2; kind++) {
        struct gpu_view view = list_random_view(kind, &random, WIDTH, HEIGHT);
        list_random_shapes(&view, &random, LIGHTS, params, lights);
        struct raster_request r = raster_request_of(&view, lights, LIGHTS);
        struct raster_copy copies[3];
        for (uint32_t nodes = 0; nodes < 3; nodes++) {
            r.raster.nodes = nodes;
            copies[nodes] = raster_build(&r);
            assert_int_equal(copies[nodes].kind, nodes ? GPU_LIST_LINKS : GPU_LIST_CLUSTERS);
            list_check_form(&copies[nodes].list, LIGHTS); /* ascending, without cycles: the walk ends */
            assert_true(list_equal(&copies[0].list, &copies[nodes].list));
        }
        for (uint32_t nodes = 0; nodes < 3; nodes++) raster_copy_free(&copies[nodes]);
    }
    /* Limits: 12 bits of light, 20 of link with one value for the end. */
    struct raster_params p = raster_params_default();
    p.nodes = GPU_NODES_32;
    p.grid.pool_capacity = 1u << 20;
    assert_int_equal(raster_nodes(&p, 4096), GPU_NODES_32);
    assert_int_equal(raster_memory(&p, 64, 64, 4096).list, 4 * 1048575);
    assert_int_equal(raster_nodes(&p, 4097), GPU_NODES_64);
    assert_int_equal(raster_memory(&p, 64, 64, 4097).list, 8 * 1048576);
    p.grid.pool_capacity++;
    assert_int_equal(raster_nodes(&p, 4), GPU_NODES_64);
    p.nodes = GPU_NODES_64;
    assert_int_equal(raster_nodes(&p, 1 << 24), GPU_NODES_64);
    p.nodes = GPU_NODES_ARRAY;
    assert_int_equal(raster_nodes(&p, 9), GPU_NODES_ARRAY);
    /* No lights; and nothing in most clusters. */
    struct gpu_view view = list_random_view(0, &random, 1, 1);
    for (uint32_t count = 0; count < 2; count++)
        for (uint32_t nodes = 0; nodes < 3; nodes++) {
            if (count) list_random_lights(&view, &random, 1, params, lights);
            struct raster_request r = raster_request_of(&view, lights, count);
            r.raster.nodes = nodes;
            r.raster.grid.slices = 7;
            struct raster_copy copy = raster_build(&r);
            list_check_form(&copy.list, count);
            assert_int_equal(copy.list.cell_count, 7);
            if (!count) assert_int_equal(copy.list.totals.entries, 0);
            raster_copy_free(&copy);
        }
}

static void test_memory_CL_14(void **state) {
    UNUSED(state);
    static const struct {
        uint32_t tile_size, slices, total64;
    } table[] = {{64, 32, 4608000},  {64, 64, 6856704},  {64, 128, 11354112},
                 {32, 32, 18432000}, {32, 64, 27426816}, {32, 128, 45416448}};
    for (uint32_t i = 0; i < COUNT_OF(table); i++) {
        uint32_t tiles = 1536 / table[i].tile_size * (768 / table[i].tile_size), clusters = tiles * table[i].slices;
        struct raster_params p = raster_params_default();
        p.grid.tile_size = table[i].tile_size;
        p.grid.slices = table[i].slices;
        p.grid.pool_capacity = clusters * 30;
        p.nodes = GPU_NODES_64;
        /* The source keeps two bytes for each tile and each of 4096 lights; here a slot is eight bytes for each tile that a light covers. */
        p.slot_capacity = tiles * 4096 / 4;
        struct raster_memory m = raster_memory(&p, 1536, 768, 4096);
        assert_int_equal(m.offsets, clusters * 4);
        assert_int_equal(m.list, clusters * 30 * 8);
        assert_int_equal(m.shells, tiles * 4096 * 2);
        assert_int_equal(m.offsets + m.list + m.shells, table[i].total64);
        p.nodes = GPU_NODES_32;
        bool fits = clusters * 30 <= 1 << 20;
        assert_int_equal(raster_memory(&p, 1536, 768, 4096).list, clusters * 30 * (fits ? 4 : 8));
    }
    /* And the list says the same of itself. */
    struct random_state random = {1};
    struct gpu_view view = list_random_view(0, &random, WIDTH, HEIGHT);
    list_random_shapes(&view, &random, 50, params, lights);
    for (uint32_t nodes = 0; nodes < 3; nodes++) {
        struct raster_request r = raster_request_of(&view, lights, 50);
        r.raster.nodes = nodes;
        r.raster.grid.pool_capacity = 12345;
        struct raster_copy copy = raster_build(&r);
        struct raster_memory m = raster_memory(&r.raster, WIDTH, HEIGHT, 50);
        assert_int_equal(copy.byte_count, m.offsets + m.list);
        assert_int_equal(m.offsets, 10 * 6 * 32 * (nodes ? 4 : 8));
        raster_copy_free(&copy);
    }
}

/* ---- pictures ---- */

static void test_pictures_CL_1(void **state) {
    UNUSED(state);
    static const fnl_shading orders[] = {FNL_SHADING_FORWARD, FNL_SHADING_DEFERRED};
    struct stage stage = stage_open("builtin:glass?lights=60", 40);
    stage.frame.width = 97;
    stage.frame.height = 61;
    for (uint32_t s = 0; s < 2; s++) {
        stage.frame.shading = orders[s];
        stage.frame.lists = FNL_LISTS_ALL;
        struct shot all = stage_shoot(&stage, &stage.frame);
        stage.frame.lists = FNL_LISTS_RASTER;
        uint64_t entries = 0;
        for (uint32_t k = 0; k < 6; k++) {
            stage.frame.clusters = frame_plain().clusters;
            stage.frame.raster.nodes = (fnl_raster_nodes)(k % 3);
            stage.frame.raster.path = k == 4 ? FNL_RASTER_SOFTWARE : FNL_RASTER_AUTO;
            stage.frame.clusters.distribution = k >= 3 ? FNL_SLICES_LINEAR : FNL_SLICES_EXPONENTIAL;
            if (k >= 3) stage.frame.clusters.size = 16;
            struct shot shot = stage_shoot(&stage, &stage.frame);
            assert_int_equal(count_differing(&all.radiance, &shot.radiance), 0);
            assert_int_equal(shot.stats.overflow_cells, 0);
            assert_true(shot.stats.list_entries > 100);
            if (k % 3) assert_int_equal(shot.stats.list_entries, entries);
            entries = shot.stats.list_entries;
            shot_free(&shot);
        }
        shot_free(&all);
    }
    stage_close(&stage);
}

/* More than 4096 lights do not fit into 32-bit nodes: 64-bit ones are taken, and the picture is right. */
static void test_node_limits_in_frames_CL_11(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:onetile?lights=0", 4200);
    stage.frame.width = 40;
    stage.frame.height = 24;
    stage.frame.lists = FNL_LISTS_ALL;
    struct shot all = stage_shoot(&stage, &stage.frame);
    stage.frame.lists = FNL_LISTS_RASTER;
    stage.frame.raster.nodes = FNL_RASTER_LINKS32;
    struct shot shot = stage_shoot(&stage, &stage.frame);
    assert_int_equal(count_differing(&all.radiance, &shot.radiance), 0);
    assert_int_equal(shot.stats.list_bytes - shot.stats.cells * 4, 8ull * stage.renderer->lists.pool_capacity);
    shot_free(&all);
    shot_free(&shot);
    stage_close(&stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_lights_per_pixel, harness_check),
        cmocka_unit_test_teardown(test_slices_CL_9, harness_check),
        cmocka_unit_test_teardown(test_overflow_CL_10, harness_check),
        cmocka_unit_test_teardown(test_slots_overflow_CL_10, harness_check),
        cmocka_unit_test_teardown(test_nodes_CL_11_CL_12, harness_check),
        cmocka_unit_test_teardown(test_memory_CL_14, harness_check),
        cmocka_unit_test_teardown(test_pictures_CL_1, harness_check),
        cmocka_unit_test_teardown(test_node_limits_in_frames_CL_11, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
