/* SPDX-License-Identifier: MIT */
/** Lists of grids in world space: the sets against brute force in double precision, and what frames make of them. */
#include "tests/list_bench.h"

enum { LIGHTS = 400 };

static struct gpu_entity_bounds lights[LIGHTS];

static void random_lights(struct random_state *random, vec3 about, float spread, float radius) {
    for (uint32_t i = 0; i < LIGHTS; i++) {
        lights[i] = (struct gpu_entity_bounds){.shape = GPU_NO_SHAPE, .radius = radius * random_range(random, 0.01f, 1)};
        lights[i].center = vec3_make(about.x + random_range(random, -spread, spread),
                                           about.y + random_range(random, -spread, spread) * 0.3f,
                                           about.z + random_range(random, -spread, spread));
        if (i % 37 == 0) lights[i].radius = 0; /* dark */
    }
}

static bool grid_holds(const struct world_grid *g, uint32_t cell, uint32_t light) {
    const struct gpu_cell *c = &g->cells.data[cell];
    if (c->count == GPU_CELL_ALL) return true;
    for (uint32_t i = 0; i < c->count; i++)
        if (g->ids.data[c->offset + i] == light) return true;
    return false;
}

static void check_form(const struct world_grid *g, uint32_t light_count) {
    uint64_t sum = 0;
    uint32_t overflowed = 0;
    assert_int_equal(g->cells.count, g->size[0] * g->size[1] * g->size[2]);
    for (uint32_t c = 0; c < g->cells.count; c++) {
        struct gpu_cell cell = g->cells.data[c];
        if (cell.count == GPU_CELL_ALL) {
            overflowed++;
            continue;
        }
        assert_int_equal(cell.offset, sum);
        sum += cell.count;
        for (uint32_t i = 0; i < cell.count; i++) {
            assert_true(g->ids.data[cell.offset + i] < light_count);
            assert_true(i == 0 || g->ids.data[cell.offset + i - 1] < g->ids.data[cell.offset + i]);
        }
    }
    assert_int_equal(g->overflow_cells, overflowed);
    assert_true(overflowed ? g->entry_count > sum : g->entry_count == sum);
}

/* Every point is looked up where each light that holds it is; a listed light is no farther from the cell than a hair. */
static void check_sets(const struct world_grid *g, struct random_state *random, vec3 about, float spread) {
    uint32_t lit = 0;
    for (uint32_t n = 0; n < 20000; n++) {
        vec3 p = vec3_make(about.x + random_range(random, -spread, spread) * 1.3f,
                           about.y + random_range(random, -spread, spread) * 0.5f,
                           about.z + random_range(random, -spread, spread) * 1.3f);
        uint32_t cell = world_grid_cell(g, p);
        assert_true(cell < g->cells.count);
        for (uint32_t i = 0; i < LIGHTS; i++) {
            vec3 c = lights[i].center;
            double x = (double)p.x - (double)c.x, y = (double)p.y - (double)c.y, z = (double)p.z - (double)c.z;
            double r = (double)lights[i].radius;
            if (x * x + y * y + z * z >= r * r) continue;
            lit++;
            assert_true(grid_holds(g, cell, i));
        }
    }
    assert_true(lit > 1000);
    for (uint32_t c = 0; c < g->cells.count; c++) {
        uint32_t at[3] = {c % g->size[0], c / g->size[0] % g->size[1], c / g->size[0] / g->size[1]};
        const float *origin = &g->origin.x;
        for (uint32_t k = 0; k < g->cells.data[c].count; k++) {
            const struct gpu_entity_bounds *light = &lights[g->ids.data[g->cells.data[c].offset + k]];
            const float *center = &light->center.x;
            double distance = 0;
            for (int a = 0; a < 3; a++) {
                double low = (double)origin[a] + at[a] * (double)g->cell_size, high = low + (double)g->cell_size, gap = 0;
                if (at[a] > 0) gap = fmax(gap, low - (double)center[a]);
                if (at[a] + 1 < g->size[a]) gap = fmax(gap, (double)center[a] - high);
                distance += gap * gap;
            }
            double slack = 1e-3 * (double)g->cell_size + 3e-6 * (double)vec3_length(about);
            assert_true(sqrt(distance) <= (double)light->radius * 1.001 + slack);
        }
    }
}

static void test_sets_ES_67_ES_8(void **state) {
    UNUSED(state);
    static const vec3 places[] = {
        {0, 0, 0}, {-3000, 20, 5000}, {2e6f, 0, -1e6f}}; /* the last: a float there has steps of 1/8 m */
    struct random_state random = {21};
    for (uint32_t p = 0; p < COUNT_OF(places); p++)
        for (int flat = 0; flat < 2; flat++)
            for (int inside = 0; inside < 2; inside++) {
                random_lights(&random, places[p], 60, 9);
                /* A scene smaller than its lights: many of them lie beyond the border. */
                struct box scene = box_empty();
                if (inside) {
                    scene.low = vec3_make(places[p].x - 30, places[p].y - 5, places[p].z - 20);
                    scene.high = vec3_make(places[p].x + 30, places[p].y + 5, places[p].z + 20);
                }
                struct world_grid_params params = world_grid_params_default();
                params.flat = flat;
                struct world_grid g, again;
                world_grid_init(&g, gpu_host(harness_device()));
                world_grid_init(&again, gpu_host(harness_device()));
                assert_int_equal(world_grid_build(&g, lights, LIGHTS, 1u << GPU_ENTITY_LIGHT, &scene, &params), FNL_OK);
                assert_int_equal(world_grid_build(&again, lights, LIGHTS, 1u << GPU_ENTITY_LIGHT, &scene, &params), FNL_OK);
                if (!flat) /* eight cells for each light, but no fewer than 4096; one more a side, as sides are rounded up */
                    assert_true(g.cells.count >= MAX(8 * LIGHTS, 4096) && g.cells.count < 2 * MAX(8 * LIGHTS, 4096));
                /* The grid ends where the scene does, though lights reach on: by a cell, and what a float rounds. */
                for (int k = 0; k < 3 && inside; k++) {
                    double low = (double)(&scene.low.x)[k], high = (double)(&scene.high.x)[k],
                           slack = 1e-6 * fabs(low) + 1e-3;
                    assert_true((double)(&g.origin.x)[k] >= low - slack);
                    assert_true(g.size[k] * (double)g.cell_size <= high - low + (double)g.cell_size + slack ||
                                (flat && k == 1));
                }
                if (flat) {
                    assert_int_equal(g.size[1], 1);
                    assert_true(g.cell_size == 4);
                }
                check_form(&g, LIGHTS);
                check_sets(&g, &random, places[p], 60);
                assert_int_equal(g.ids.count, again.ids.count);
                assert_memory_equal(g.ids.data, again.ids.data, g.ids.count * 4ull);
                world_grid_finish(&g, harness_device());
                world_grid_finish(&again, harness_device());
            }
}

/* No light, broken lights, huge ones, positions that are no number, a limit on cells. */
static void test_limits_ES_67_ES_8(void **state) {
    UNUSED(state);
    struct world_grid g;
    struct world_grid_params params = world_grid_params_default();
    struct box none = box_empty();
    world_grid_init(&g, gpu_host(harness_device()));
    assert_int_equal(world_grid_build(&g, NULL, 0, 1u << GPU_ENTITY_LIGHT, &none, &params), FNL_OK);
    assert_int_equal(g.entry_count, 0);
    assert_int_equal(world_grid_cell(&g, vec3_make(NAN, INFINITY, -INFINITY)), 0);

    struct random_state random = {2};
    random_lights(&random, vec3_make(0, 0, 0), 1000, 5);
    lights[3].center.y = NAN;
    lights[5].radius = INFINITY;
    lights[8].radius = 3e37f;
    params.cell_limit = 1000;
    for (int flat = 0; flat < 2; flat++) {
        params.flat = flat;
        assert_int_equal(world_grid_build(&g, lights, LIGHTS, 1u << GPU_ENTITY_LIGHT, &none, &params), FNL_OK);
        assert_true(g.cells.count <= 1000);
        check_form(&g, LIGHTS);
        for (uint32_t c = 0; c < g.cells.count; c++) {
            assert_true(grid_holds(&g, c, 3));
            assert_true(grid_holds(&g, c, 5));
        }
        assert_true(grid_holds(&g, world_grid_cell(&g, vec3_make(1e9f, 0, 1e9f)), 8));
        assert_true(world_grid_cell(&g, vec3_make(NAN, NAN, NAN)) < g.cells.count);
    }
    world_grid_finish(&g, harness_device());
}

/* Lights that all reach far take larger cells in place of millions of steps. */
static void test_large_lights_get_large_cells_ES_67_ES_8(void **state) {
    UNUSED(state);
    struct random_state random = {6};
    random_lights(&random, vec3_make(0, 0, 0), 50, 200);
    struct world_grid g;
    struct world_grid_params params = world_grid_params_default();
    struct box none = box_empty();
    world_grid_init(&g, gpu_host(harness_device()));
    assert_int_equal(world_grid_build(&g, lights, LIGHTS, 1u << GPU_ENTITY_LIGHT, &none, &params), FNL_OK);
    const uint64_t entries = g.entry_count;
    const float cell_size = g.cell_size;
    assert_true(entries > 200000);
    params.span_limit = 50000;
    for (int flat = 0; flat < 2; flat++) {
        params.flat = flat;
        assert_int_equal(world_grid_build(&g, lights, LIGHTS, 1u << GPU_ENTITY_LIGHT, &none, &params), FNL_OK);
        check_form(&g, LIGHTS);
        assert_true(g.entry_count <= 50000 && g.entry_count > 50000 / 16 && g.overflow_cells == 0);
        if (!flat) assert_true(g.cell_size == 2 * cell_size || g.cell_size == 4 * cell_size);
    }
    params.span_limit = 0; /* then one cell is left */
    assert_int_equal(world_grid_build(&g, lights, LIGHTS, 1u << GPU_ENTITY_LIGHT, &none, &params), FNL_OK);
    assert_int_equal(g.cells.count, 1);
    check_form(&g, LIGHTS);
    world_grid_finish(&g, harness_device());
}

/* Cells that do not fit use all lights and are counted, the same ones every time. */
static void test_overflow_CL_10_ES_8(void **state) {
    UNUSED(state);
    struct random_state random = {4};
    random_lights(&random, vec3_make(0, 0, 0), 60, 9);
    struct world_grid fits, tight;
    struct world_grid_params params = world_grid_params_default();
    struct box none = box_empty();
    params.flat = true;
    world_grid_init(&fits, gpu_host(harness_device()));
    world_grid_init(&tight, gpu_host(harness_device()));
    assert_int_equal(world_grid_build(&fits, lights, LIGHTS, 1u << GPU_ENTITY_LIGHT, &none, &params), FNL_OK);
    params.entry_limit = fits.entry_count / 2;
    uint32_t first = 0;
    for (int run = 0; run < 2; run++) {
        assert_int_equal(world_grid_build(&tight, lights, LIGHTS, 1u << GPU_ENTITY_LIGHT, &none, &params), FNL_OK);
        check_form(&tight, LIGHTS);
        assert_int_equal(tight.entry_count, fits.entry_count);
        assert_true(tight.overflow_cells > 0 && tight.overflow_cells < tight.cells.count);
        if (run) assert_int_equal(tight.overflow_cells, first);
        first = tight.overflow_cells;
        for (uint32_t c = 0; c < fits.cells.count; c++)
            assert_true(tight.cells.data[c].count == GPU_CELL_ALL || tight.cells.data[c].count == fits.cells.data[c].count);
    }
    world_grid_finish(&fits, harness_device());
    world_grid_finish(&tight, harness_device());
}

/* ---- frames ---- */

static bool has_pass(struct stage *stage, const char *part) {
    fnl_frame_stats stats;
    assert_int_equal(fnl_renderer_query_stats(stage->renderer, &stats), FNL_OK);
    assert_true(stats.pass_count > 0);
    for (uint32_t i = 0; i < stats.pass_count; i++)
        if (strstr(stats.passes[i].name, part)) return true;
    return false;
}

static void check_equal(struct stage *stage, fnl_frame frame) {
    struct shot shot = stage_shoot(stage, &frame);
    frame.lists = FNL_LISTS_ALL;
    struct shot all = stage_shoot(stage, &frame);
    assert_int_equal(count_differing(&all.radiance, &shot.radiance), 0);
    assert_int_equal(shot.stats.overflow_cells, 0);
    shot_free(&all);
    shot_free(&shot);
}

/* A moving camera costs nothing: no pass, no build. A light that moves costs one of each. */
static void test_kept_while_the_camera_moves_ES_67(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:hall?lights=64", 0);
    stage.frame.timers = true;
    stage.frame.lists = FNL_LISTS_WORLD;
    const struct world_grid *grid = &stage.renderer->lists.shared.world;
    struct shot shot = stage_shoot(&stage, &stage.frame);
    assert_true(has_pass(&stage, "world upload"));
    shot_free(&shot);
    for (int i = 0; i < 3; i++) {
        stage.frame.camera.position.x += 0.7f;
        stage.frame.camera.target.y += 0.3f;
        shot = stage_shoot(&stage, &stage.frame);
        assert_false(has_pass(&stage, "world"));
        assert_false(has_pass(&stage, "lights"));
        shot_free(&shot);
        check_equal(&stage, stage.frame);
        assert_int_equal(grid->build_count, 1);
    }
    fnl_light_id id;
    fnl_light_params light = fnl_light_params_default();
    light.position = (fnl_vec3){1, 2, 0};
    light.range = 3;
    light.intensity = 50;
    assert_int_equal(fnl_scene_add_light(stage.scene, &light, &id), FNL_OK);
    check_equal(&stage, stage.frame);
    assert_int_equal(grid->build_count, 2);
    light.position.y = 3;
    assert_int_equal(fnl_scene_set_light(stage.scene, id, &light), FNL_OK);
    check_equal(&stage, stage.frame);
    assert_int_equal(grid->build_count, 3);
    stage_close(&stage);
}

/* Lamps so far apart that no cell holds more than four, as in the source. */
static void test_four_lights_a_cell_ES_8(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:city?lights=0", 0);
    for (int i = 0; i < 400; i++) {
        fnl_light_params light = fnl_light_params_default();
        fnl_light_id id;
        light.position = (fnl_vec3){(float)(i % 20 - 10) * 9, 1.5f, (float)(i / 20 - 10) * 9};
        light.range = 6;
        light.intensity = 20;
        assert_int_equal(fnl_scene_add_light(stage.scene, &light, &id), FNL_OK);
    }
    stage.frame.timers = true;
    stage.frame.lists = FNL_LISTS_GRID2D;
    for (uint32_t s = 0; s <= FNL_SHADING_DEFERRED; s++) {
        stage.frame.shading = (fnl_shading)s;
        check_equal(&stage, stage.frame);
    }
    const struct world_grid *grid = &stage.renderer->lists.shared.grid2d;
    assert_int_equal(grid->build_count, 1);
    uint32_t most = 0;
    for (uint32_t c = 0; c < grid->cells.count; c++) most = MAX(most, grid->cells.data[c].count);
    assert_int_equal(most, 4);
    stage_close(&stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_sets_ES_67_ES_8, harness_check),
        cmocka_unit_test_teardown(test_limits_ES_67_ES_8, harness_check),
        cmocka_unit_test_teardown(test_large_lights_get_large_cells_ES_67_ES_8, harness_check),
        cmocka_unit_test_teardown(test_overflow_CL_10_ES_8, harness_check),
        cmocka_unit_test_teardown(test_kept_while_the_camera_moves_ES_67, harness_check),
        cmocka_unit_test_teardown(test_four_lights_a_cell_ES_8, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
