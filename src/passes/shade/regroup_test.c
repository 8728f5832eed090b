/* SPDX-License-Identifier: MIT */
/** Batches by number of lights, and one pass per light: the same bits as brute force, and only the objects that a light touches. */
#include "tests/render_harness.h"

static struct shot shoot(struct stage *stage, fnl_light_lists lists) {
    fnl_frame frame = stage->frame;
    frame.lists = lists;
    frame.shading = FNL_SHADING_FORWARD_PREPASS;
    frame.count_lights = true;
    return stage_shoot(stage, &frame);
}

static void add_light(fnl_scene *scene, float x, float y, float z, float range) {
    fnl_light_params light = fnl_light_params_default();
    fnl_light_id id;
    light.position = (fnl_vec3){x, y, z};
    light.range = range;
    light.intensity = 30;
    assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
}

/* Quads side by side, facing the camera, each with a number of lights of its own in front of it. */
static struct stage open_quads(const uint32_t *light_counts, uint32_t count) {
    static const float positions[12] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
    static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    fnl_mesh_params params = {.vertex_count = 4, .index_count = 6, .positions = positions, .indices = indices};
    fnl_scene *scene;
    fnl_mesh_id mesh;
    assert_int_equal(fnl_scene_create(gpu_host(harness_device()), &scene), FNL_OK);
    assert_int_equal(fnl_scene_add_mesh(scene, &params, &mesh), FNL_OK);
    for (uint32_t i = 0; i < count; i++) {
        float x = ((float)i - 0.5f * (float)(count - 1)) * 8;
        fnl_mat4 at = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, 0, 0, 1}};
        fnl_instance_id id;
        assert_int_equal(fnl_scene_add_instance(scene, mesh, &at, &id), FNL_OK);
        for (uint32_t l = 0; l < light_counts[i]; l++) add_light(scene, x + 0.05f * (float)l, 0.02f * (float)l, 0.7f, 2);
    }
    struct stage stage = stage_open_scene(scene);
    stage.frame.camera.position = (fnl_vec3){0, 0, 6 * (float)count};
    stage.frame.camera.target = (fnl_vec3){0, 0, 0};
    return stage;
}

/* Three lights fill up to four, four fit exactly; likewise at the other steps, and beyond the last one. */
static void test_padded_loops_MP_17(void **state) {
    UNUSED(state);
    static const uint32_t counts[] = {3, 4, 0, 1, 2, 5, 8, 9, 16, 17, 40};
    for (uint32_t n = 2; n <= COUNT_OF(counts); n += COUNT_OF(counts) - 2) {
        struct stage stage = open_quads(counts, n);
        struct shot all = shoot(&stage, FNL_LISTS_ALL), mesh = shoot(&stage, FNL_LISTS_MESH),
                    batches = shoot(&stage, FNL_LISTS_BATCHES);
        uint32_t lights = 0;
        for (uint32_t i = 0; i < n; i++) lights += counts[i];
        assert_int_equal(batches.stats.list_entries, lights);
        assert_true(batches.stats.evaluations > 0);
        assert_int_equal(batches.stats.evaluations, mesh.stats.evaluations); /* turns without a light are none */
        assert_int_equal(count_differing(&all.radiance, &batches.radiance), 0);
        shot_free(&all);
        shot_free(&mesh);
        shot_free(&batches);
        stage_close(&stage);
    }
}

/* Each light draws the objects that it touches and no others; the sum in floats is that of one pass, to the bit. */
static void test_pass_per_light_ES_2_MP_18(void **state) {
    UNUSED(state);
    static const uint32_t counts[] = {1, 3, 0, 7};
    struct stage stage = open_quads(counts, 4);
    struct shot all = shoot(&stage, FNL_LISTS_ALL), mesh = shoot(&stage, FNL_LISTS_MESH),
                passes = shoot(&stage, FNL_LISTS_MULTIPASS);
    assert_int_equal(passes.stats.list_entries, 11); /* objects of all lights together */
    assert_int_equal(passes.stats.evaluations, mesh.stats.evaluations);
    assert_int_equal(passes.stats.evaluations_useful, all.stats.evaluations_useful);
    assert_int_equal(count_differing(&all.radiance, &passes.radiance), 0);
    /* depth, owners, the rest, and one call for each of 11 lights; a call for depth and one for shading without. */
    assert_int_equal(all.stats.draws, 2);
    assert_int_equal(passes.stats.draws, 3 + 11);
    shot_free(&all);
    shot_free(&mesh);
    shot_free(&passes);
    /* With a target of halves the sum is still one of floats. */
    stage.frame.outputs = FNL_OUTPUT_COLOR;
    all = shoot(&stage, FNL_LISTS_ALL);
    passes = shoot(&stage, FNL_LISTS_MULTIPASS);
    assert_int_equal(count_differing(&all.color, &passes.color), 0);
    shot_free(&all);
    shot_free(&passes);
    stage_close(&stage);
}

/* Cutouts, blended and mirrored surfaces, surfaces in one plane, a thousand lights. */
static void test_scenes_ES_2_MP_17_MP_18(void **state) {
    UNUSED(state);
    static const char *const sources[] = {"builtin:glass?lights=1000", "builtin:grass", "builtin:hall?lights=64"};
    for (uint32_t i = 0; i < COUNT_OF(sources); i++) {
        struct stage stage = stage_open(sources[i], 0);
        struct shot all = shoot(&stage, FNL_LISTS_ALL);
        for (int k = 0; k < 2; k++) {
            struct shot shot = shoot(&stage, k ? FNL_LISTS_MULTIPASS : FNL_LISTS_BATCHES);
            assert_int_equal(count_differing(&all.radiance, &shot.radiance), 0);
            assert_true(shot.stats.evaluations < all.stats.evaluations);
            shot_free(&shot);
        }
        shot_free(&all);
        stage_close(&stage);
    }
}

/*
 * Maps are there before objects are grouped by lights, and before the first light's pass: both give the bits of brute force. The maps of all lights share one
 * image of a mebibyte.
 */
static void test_with_shadow_maps_ES_18_MP_17_MP_18(void **state) {
    UNUSED(state);
    static const uint32_t counts[] = {3, 4, 5, 0, 9};
    static const float positions[12] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
    static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    struct stage stage = open_quads(counts, COUNT_OF(counts));
    stage.frame.camera.position.z = 20;
    fnl_mesh_params params = {.vertex_count = 4, .index_count = 6, .positions = positions, .indices = indices};
    fnl_mesh_id mesh;
    assert_int_equal(fnl_scene_add_mesh(stage.scene, &params, &mesh), FNL_OK);
    for (uint32_t i = 0; i < COUNT_OF(counts); i++) { /* small, before each, in front of some of its lights' light */
        fnl_mat4 at = {{0.3f, 0, 0, 0, 0, 0.3f, 0, 0, 0, 0, 1, 0, ((float)i - 2) * 8 + 0.3f, 0.2f, 0.3f, 1}};
        fnl_instance_id id;
        assert_int_equal(fnl_scene_add_instance(stage.scene, mesh, &at, &id), FNL_OK);
    }
    struct shot plain = shoot(&stage, FNL_LISTS_ALL);
    stage.frame.shadows = FNL_SHADOWS_MAPS;
    stage.frame.shadow.memory = 1;
    struct shot all = shoot(&stage, FNL_LISTS_ALL);
    assert_true(count_differing(&plain.radiance, &all.radiance) > 10);
    for (int k = 0; k < 2; k++) {
        struct shot shot = shoot(&stage, k ? FNL_LISTS_MULTIPASS : FNL_LISTS_BATCHES);
        assert_int_equal(shot.stats.lists, k ? FNL_LISTS_MULTIPASS : FNL_LISTS_BATCHES);
        assert_int_equal(count_differing(&all.radiance, &shot.radiance), 0);
        assert_true(counter(&shot.stats, "shadows.pages") >= 21 && counter(&shot.stats, "shadows.cells") * 65536 <= 1048576);
        assert_int_equal(counter(&shot.stats, "shadows.traced"), 0);
        shot_free(&shot);
    }
    shot_free(&all);
    stage.frame.shadows = FNL_SHADOWS_RAYS;
    all = shoot(&stage, FNL_LISTS_ALL);
    for (int k = 0; k < 2; k++) {
        struct shot shot = shoot(&stage, k ? FNL_LISTS_MULTIPASS : FNL_LISTS_BATCHES);
        assert_int_equal(count_differing(&all.radiance, &shot.radiance), 0);
        assert_int_equal(counter(&shot.stats, "shadows.rays"), counter(&all.stats, "shadows.rays"));
        shot_free(&shot);
    }
    shot_free(&plain);
    shot_free(&all);
    stage_close(&stage);
}

/* With MSAA, or too many lights times groups, lists of objects stand in: pictures stay right, and statistics and log say so. */
static void test_mesh_lists_stand_in(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:glass?lights=20", 0);
    for (uint32_t k = 0; k < 2; k++) {
        fnl_light_lists lists = k ? FNL_LISTS_MULTIPASS : FNL_LISTS_BATCHES;
        struct shot one = shoot(&stage, lists);
        assert_int_equal(one.stats.lists, lists);
        assert_false(stage.renderer->notes.mesh_lists);
        stage.frame.msaa = 4;
        struct shot several = shoot(&stage, lists), mesh = shoot(&stage, FNL_LISTS_MESH);
        assert_int_equal(several.stats.lists, FNL_LISTS_MESH);
        assert_true(stage.renderer->notes.mesh_lists);
        assert_int_equal(count_differing(&several.radiance, &mesh.radiance), 0);
        stage.frame.msaa = 1;
        stage.renderer->notes.mesh_lists = false;
        shot_free(&one);
        shot_free(&several);
        shot_free(&mesh);
    }
    fnl_scatter_params many = fnl_scatter_params_default();
    many.count = (1 << 18) / stage.renderer->device_scene->group_count + 1;
    many.radius_scale = 0.01f;
    assert_int_equal(fnl_scene_scatter_light_shapes(stage.scene, &many), FNL_OK);
    stage.frame.width = 33;
    stage.frame.height = 17;
    struct shot passes = shoot(&stage, FNL_LISTS_MULTIPASS), batches = shoot(&stage, FNL_LISTS_BATCHES);
    assert_int_equal(passes.stats.lists, FNL_LISTS_MESH);
    assert_int_equal(batches.stats.lists, FNL_LISTS_BATCHES);
    assert_true(stage.renderer->notes.mesh_lists);
    assert_int_equal(count_differing(&passes.radiance, &batches.radiance), 0);
    shot_free(&passes);
    shot_free(&batches);
    stage_close(&stage);
}

/* Pairs that find no place: groups are drawn whole, the pool grows. */
static void test_overflow_CL_10_MP_18(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:glass?lights=200", 0);
    struct shot fits = shoot(&stage, FNL_LISTS_MULTIPASS);
    harness_set_pool(&stage, 50);
    struct shot over = shoot(&stage, FNL_LISTS_MULTIPASS), next = shoot(&stage, FNL_LISTS_MULTIPASS);
    assert_true(over.stats.overflow_cells > 0);
    assert_int_equal(next.stats.overflow_cells, 0);
    assert_int_equal(count_differing(&fits.radiance, &over.radiance), 0);
    assert_int_equal(count_differing(&fits.radiance, &next.radiance), 0);
    shot_free(&fits);
    shot_free(&over);
    shot_free(&next);
    stage_close(&stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_padded_loops_MP_17, harness_check),
        cmocka_unit_test_teardown(test_pass_per_light_ES_2_MP_18, harness_check),
        cmocka_unit_test_teardown(test_scenes_ES_2_MP_17_MP_18, harness_check),
        cmocka_unit_test_teardown(test_with_shadow_maps_ES_18_MP_17_MP_18, harness_check),
        cmocka_unit_test_teardown(test_mesh_lists_stand_in, harness_check),
        cmocka_unit_test_teardown(test_overflow_CL_10_MP_18, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
