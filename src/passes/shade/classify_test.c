/* SPDX-License-Identifier: MIT */
/* Specialised deferred shading: the bits of the one shader, and exact counts of blocks. */
#include "passes/shade/classify_shared.h"
#include "shaders.h"
#include "tests/render_harness.h"
#include "tests/vulkan_spy.h"

/* Blocks of a class; SHADE_NOTHING: of none. */
static uint32_t blocks_of(const struct shot *shot, uint32_t class) {
    static const char *const names[] = {
        "plain", "lights", "metal", "lights-metal", "full", "lights-full", "metal-full", "lights-metal-full", "empty"};
    char key[64];
    snprintf(key, sizeof key, "shading-blocks.%s", names[class]);
    return (uint32_t)counter(&shot->stats, key);
}

static uint32_t sum_of(const struct shot *shot) {
    uint32_t sum = 0;
    for (uint32_t i = 0; i <= SHADE_CLASSES; i++) sum += blocks_of(shot, i);
    return sum;
}

static void test_equal_to_one_shader_ES_48(void **state) {
    UNUSED(state);
    static const char *const scenes[] = {"builtin:hall?lights=64", "builtin:spheres?lights=30", "builtin:glass",
                                         "builtin:sky"};
    static const fnl_light_lists lists[] = {FNL_LISTS_ALL, FNL_LISTS_TILED, FNL_LISTS_CLUSTERED};
    for (uint32_t s = 0; s < COUNT_OF(scenes); s++) {
        struct stage stage = stage_open(scenes[s], 0);
        stage.frame.shading = FNL_SHADING_DEFERRED;
        stage.frame.width = 147; /* neither side is a multiple of a block's */
        stage.frame.height = 83;
        for (uint32_t l = 0; l < COUNT_OF(lists); l++) {
            stage.frame.lists = lists[l];
            stage.frame.deferred.class_blocks = 0;
            struct shot plain = stage_shoot(&stage, &stage.frame);
            assert_false(has_counter(&plain.stats, "shading-blocks.empty"));
            for (uint32_t block = 4; block <= 8; block += 4) {
                stage.frame.deferred.class_blocks = block;
                struct shot classified = stage_shoot(&stage, &stage.frame);
                assert_int_equal(count_differing(&plain.radiance, &classified.radiance), 0);
                assert_int_equal(sum_of(&classified), DIVIDE_UP(147u, block) * DIVIDE_UP(83u, block));
                shot_free(&classified);
            }
            shot_free(&plain);
        }
        stage_close(&stage);
    }
}

static void add_quad(fnl_scene *scene, float x, float metallic, bool unlit) {
    static const float positions[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
    static const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    fnl_material_params material = fnl_material_params_default();
    material.metallic = metallic;
    material.unlit = unlit;
    fnl_material_id material_id;
    assert_int_equal(fnl_scene_add_material(scene, &material, &material_id), FNL_OK);
    fnl_mesh_params mesh = {
        .vertex_count = 4, .index_count = 6, .positions = positions, .indices = indices, .material = material_id};
    fnl_mesh_id mesh_id;
    fnl_instance_id instance;
    assert_int_equal(fnl_scene_add_mesh(scene, &mesh, &mesh_id), FNL_OK);
    fnl_mat4 matrix = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, 0, 0, 1}};
    assert_int_equal(fnl_scene_add_instance(scene, mesh_id, &matrix, &instance), FNL_OK);
}

/* Four squares of 64 pixels side by side: unlit, plastic, plastic in a light's reach, metal in its reach; above and below sky. */
static void test_counts_ES_48(void **state) {
    UNUSED(state);
    fnl_scene *scene;
    assert_int_equal(fnl_scene_create(NULL, &scene), FNL_OK);
    add_quad(scene, -3, 0, true);
    add_quad(scene, -1, 0, false);
    add_quad(scene, 1, 0, false);
    add_quad(scene, 3, 1, false);
    fnl_light_params light = fnl_light_params_default();
    light.position = (fnl_vec3){2, 0, 0.5f};
    light.range = 0.9f; /* tiles and their neighbours: x = 1.1 .. 2.9, y = -0.9 .. 0.9 */
    fnl_light_id id;
    assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
    struct stage stage = stage_open_scene(scene);
    fnl_frame *frame = &stage.frame;
    frame->width = 256;
    frame->height = 128;
    frame->shading = FNL_SHADING_DEFERRED;
    frame->lists = FNL_LISTS_ALL; /* one light everywhere */
    frame->camera.orthographic = true;
    frame->camera.vertical_extent = 4;
    frame->camera.near_distance = 0.5f;
    frame->camera.far_distance = 20;
    frame->camera.position = (fnl_vec3){0, 0, 5};
    frame->camera.target = (fnl_vec3){0, 0, 0};
    for (uint32_t size = 4; size <= 8; size += 4) {
        uint32_t square = 64 / size * (64 / size);
        frame->deferred.class_blocks = size;
        frame->lists = FNL_LISTS_ALL;
        struct shot shot = stage_shoot(&stage, frame);
        assert_int_equal(blocks_of(&shot, SHADE_LIGHTS | SHADE_FULL), 2 * square);
        assert_int_equal(blocks_of(&shot, SHADE_LIGHTS | SHADE_METAL | SHADE_FULL), square);
        assert_int_equal(blocks_of(&shot, SHADE_NOTHING), 5 * square); /* unlit, and the sky */
        assert_int_equal(sum_of(&shot), 8 * square);
        shot_free(&shot);
        frame->lists = FNL_LISTS_TILED; /* blocks without lights take no loop */
        frame->tiles.size = 16;
        shot = stage_shoot(&stage, frame);
        uint32_t unlit_plastic = blocks_of(&shot, SHADE_FULL);
        uint32_t lit_plastic = blocks_of(&shot, SHADE_LIGHTS | SHADE_FULL);
        assert_int_equal(unlit_plastic + lit_plastic, 2 * square);
        assert_true(unlit_plastic > square && lit_plastic >= square / 4 && lit_plastic < square);
        assert_true(blocks_of(&shot, SHADE_METAL | SHADE_FULL) > 0);
        shot_free(&shot);
    }
    stage_close(&stage);
}

/* ---- the variants ---- */

enum { LIGHTS_CONSTANT = 2, METAL_CONSTANT, FULL_CONSTANT, BLOCK_CONSTANT }; /* of deferred.comp.glsl and shade.glsl */
static uint32_t replaced_constant, replaced_value;

static const struct gpu_pipeline *replace_variant(gpu_device *device, const struct gpu_pipeline *bound) {
    if (!spy_compute_params(bound) || spy_compute_params(bound)->shader != &shader_deferred_comp) return bound;
    struct gpu_compute_params params;
    memcpy(&params, spy_compute_params(bound), sizeof params);
    params.constants[replaced_constant] = replaced_value;
    return gpu_compute_pipeline(device, &params);
}

/* Each class is shaded by the variant of its bits, from its own place of the dispatches; and the bits leave code out: what they stand for is
 * missing where a variant goes without. */
static void test_each_class_has_its_variant_ES_48(void **state) {
    UNUSED(state);
    spy_begin(harness_device());
    struct stage stage = stage_open("builtin:spheres?lights=30", 0);
    fnl_frame *frame = &stage.frame;
    frame->shading = FNL_SHADING_DEFERRED;
    frame->lists = FNL_LISTS_TILED;
    frame->tiles.size = 8;
    frame->deferred.class_blocks = 8;
    frame->record_threads = 1;
    spy_clear();
    struct shot shot = stage_shoot(&stage, frame);
    uint32_t seen = 0;
    for (uint32_t i = 0; i < spy.work_count; i++) {
        const struct spy_work *work = &spy.work[i];
        if (strcmp(work->label, "deferred")) continue;
        assert_true(work->indirect && work->offset % 12 == 0);
        uint32_t bits = (uint32_t)work->offset / 12;
        const uint32_t *constants = spy_compute_params(work->pipeline)->constants;
        assert_int_equal(constants[LIGHTS_CONSTANT] != 0, (bits & SHADE_LIGHTS) != 0);
        assert_int_equal(constants[METAL_CONSTANT] != 0, (bits & SHADE_METAL) != 0);
        assert_int_equal(constants[FULL_CONSTANT] != 0, (bits & SHADE_FULL) != 0);
        assert_int_equal(constants[BLOCK_CONSTANT], 8);
        seen |= 1u << bits;
    }
    assert_int_equal(seen, (1u << SHADE_CLASSES) - 1); /* all classes, each once */
    assert_int_equal(spy_count_work("deferred"), SHADE_CLASSES);
    static const struct {
        uint32_t constant, value;
        const char *name;
    } changes[] = {{LIGHTS_CONSTANT, 0, "without lights"}, {METAL_CONSTANT, 0, "without metals"}};
    for (uint32_t i = 0; i < COUNT_OF(changes); i++) {
        replaced_constant = changes[i].constant;
        replaced_value = changes[i].value;
        spy.replace = replace_variant;
        struct shot changed = stage_shoot(&stage, frame);
        spy.replace = NULL;
        uint64_t differing = count_differing(&shot.radiance, &changed.radiance);
        print_message("%s: %llu pixels differ\n", changes[i].name, (unsigned long long)differing);
        assert_true(differing > 50);
        shot_free(&changed);
    }
    shot_free(&shot);
    stage_close(&stage);
    spy_end();
}

static int tear_down(void **state) {
    spy_end();
    return harness_check(state);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_equal_to_one_shader_ES_48, harness_check),
        cmocka_unit_test_teardown(test_counts_ES_48, harness_check),
        cmocka_unit_test_teardown(test_each_class_has_its_variant_ES_48, tear_down),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
