/* SPDX-License-Identifier: MIT */
/* Front-to-back order and a depth prepass of large instances shade fewer hidden fragments and keep the picture. */
#include "tests/render_harness.h"
#include "tests/trace_world.h"

enum { LAYERS = 12 };

static fnl_material_params color_of(uint32_t i) {
    fnl_material_params m = matt(1);
    m.base_color[0] = (float)(i % 3) / 2, m.base_color[1] = (float)(i % 4) / 3, m.base_color[2] = (float)(i % 5) / 4;
    return m;
}

/* The path forward counts light evaluations, with all lights for each pixel. */
static struct stage forward_stage(fnl_scene *scene) {
    struct stage s = stage_open_scene(scene);
    s.frame.width = 96, s.frame.height = 64;
    s.frame.camera.position = (vec3){0, 0, 6};
    s.frame.camera.target = (vec3){0, 0, 0};
    s.frame.shading = FNL_SHADING_FORWARD;
    s.frame.lists = FNL_LISTS_ALL;
    s.frame.shadows = FNL_SHADOWS_OFF;
    s.frame.count_lights = true;
    s.frame.outputs = FNL_OUTPUT_RADIANCE;
    return s;
}

/* Upright squares one behind the other, added from the farthest to the nearest; every fifth one is mirrored. */
static void add_layers(fnl_scene *scene, fnl_mesh_id mesh, float from, uint32_t count, float half) {
    for (uint32_t i = 0; i < count; i++)
        add_instance(scene, mesh, mat4_from_trs((vec3){0.3f * (float)(i % 3), 0, from + (float)i}, quat_axis_angle((vec3){1, 0, 0}, PI / 2), (vec3){i % 5 == 4 ? -half : half, 1, half}));
}

/* Large squares that share one mesh or have a mesh each, with small squares in front and behind. */
static struct stage wall_of_layers(bool one_mesh, bool cutout) {
    fnl_scene *scene = world_create(NULL);
    fnl_material_params white = color_of(1);
    if (one_mesh) {
        add_layers(scene, add_square_mesh(scene, add_material(scene, &white)), -(float)LAYERS, LAYERS, 3);
    } else {
        for (uint32_t i = 0; i < LAYERS; i++) {
            white = color_of(i);
            add_layers(scene, add_square_mesh(scene, add_material(scene, &white)), (float)i - LAYERS, 1, 3);
        }
    }
    fnl_material_params small = color_of(2);
    const fnl_mesh_id bit = add_square_mesh(scene, add_material(scene, &small));
    for (uint32_t i = 0; i < 20; i++)
        add_instance(scene, bit, mat4_from_trs((vec3){0.4f * (float)(i % 7) - 1.2f, 0.5f * (float)(i % 5) - 1, i % 2 ? 0.5f : -14}, quat_axis_angle((vec3){1, 0, 0}, PI / 2), (vec3){0.1f, 1, 0.1f}));
    if (cutout) { /* its holes show what is behind */
        const unsigned char texels[16] = {255, 255, 255, 255, 255, 255, 255, 0, 255, 255, 255, 0, 255, 255, 255, 255};
        fnl_material_params holes = matt(0.5f);
        holes.alpha_mode = FNL_ALPHA_MASK;
        holes.alpha_cutoff = 0.5f;
        fnl_image image = {.format = FNL_PIXEL_FORMAT_RGBA8, .width = 2, .height = 2, .pixels = (void *)texels};
        fnl_image_id id;
        assert_int_equal(fnl_scene_add_image(scene, &image, true, &id), FNL_OK);
        holes.base_color_image = id;
        add_layers(scene, add_square_mesh(scene, add_material(scene, &holes)), 1.5f, 1, 1.5f);
    }
    for (uint32_t i = 0; i < 3; i++) add_point_light(scene, (vec3){2 * (float)i - 2, 2, 4}, 100);
    return forward_stage(scene);
}

static uint32_t differing(const fnl_image *a, const fnl_image *b) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < a->width * a->height; i++) count += memcmp((float *)a->pixels + 4 * i, (float *)b->pixels + 4 * i, 16) != 0;
    return count;
}

/* Returns the number of light evaluations; the picture must equal the first one. With MSAA, a driver may shade a
   partly covered surface at another position. */
static uint64_t evaluations_of(struct stage *s, struct shot *first, const char *what) {
    struct shot shot = stage_shoot(s, &s->frame);
    const uint64_t evaluations = shot.stats.evaluations;
    print_message("%s: %llu evaluations, %u pixels differ\n", what, (unsigned long long)evaluations, first->radiance.pixels ? differing(&shot.radiance, &first->radiance) : 0);
    if (first->radiance.pixels) {
        assert_true(differing(&shot.radiance, &first->radiance) <= (s->frame.msaa > 1 ? 300 : 0));
        shot_free(&shot);
    } else {
        *first = shot;
    }
    return evaluations;
}

/* ES-4 a, c, d: a full prepass evaluates the fewest lights, scene order the most. */
static void test_less_is_shaded_ES_4(void **state) {
    UNUSED(state);
    for (uint32_t i = 0; i < 8; i++) {
        const bool one_mesh = i & 1, cutout = i & 2;
        struct stage s = wall_of_layers(one_mesh, cutout);
        s.frame.msaa = i & 4 ? 4 : 1;
        struct shot first = {0};
        const uint64_t back_to_front = evaluations_of(&s, &first, "as the scene has it");
        s.frame.front_to_back = true;
        const uint64_t sorted = evaluations_of(&s, &first, "front to back");
        s.frame.front_to_back = false;
        s.frame.prepass_pixels = 20;
        const uint64_t large = evaluations_of(&s, &first, "large things first");
        s.frame.prepass_pixels = 10000;
        assert_int_equal(evaluations_of(&s, &first, "nothing is so large"), back_to_front);
        s.frame.prepass_pixels = 1e-3f;
        const uint64_t all = evaluations_of(&s, &first, "all are");
        s.frame.prepass_pixels = 0;
        s.frame.shading = FNL_SHADING_FORWARD_PREPASS;
        const uint64_t least = evaluations_of(&s, &first, "prepass");
        assert_true(sorted < back_to_front / 3 && large < back_to_front / 3);
        assert_true(least <= all && all <= large && least <= sorted);
        assert_true(cutout || sorted < least + least / 20); /* within a group, only sorted items overlap */
        assert_true(large > least);                          /* the prepass leaves out small squares in front of the wall */
        shot_free(&first);
        stage_close(&s);
    }
}

/* Large means wide or high: a wide, low strip is in the prepass, before the wall that it hides in part. */
static void test_a_strip_is_large(void **state) {
    UNUSED(state);
    fnl_scene *scene = world_create(NULL);
    const fnl_material_params white = color_of(1), gray = color_of(2);
    add_layers(scene, add_square_mesh(scene, add_material(scene, &white)), -1, 1, 3);
    add_instance(scene, add_square_mesh(scene, add_material(scene, &gray)),
                 mat4_from_trs((vec3){0, 0, 1}, quat_axis_angle((vec3){1, 0, 0}, PI / 2), (vec3){1.5f, 1, 0.1f}));
    add_point_light(scene, (vec3){0, 2, 4}, 100);
    struct stage s = forward_stage(scene);
    struct shot first = {0};
    const uint64_t before = evaluations_of(&s, &first, "wall, then strip");
    s.frame.prepass_pixels = 20;
    const uint64_t large = evaluations_of(&s, &first, "strip first");
    s.frame.prepass_pixels = 0;
    s.frame.shading = FNL_SHADING_FORWARD_PREPASS;
    assert_int_equal(large, evaluations_of(&s, &first, "prepass"));
    assert_true(large < before);
    shot_free(&first);
    stage_close(&s);
}

/* The picture stays the same in three paths, also with lines and with blended surfaces, which have their own order. */
static void test_the_picture_stays(void **state) {
    UNUSED(state);
    static const char *const sources[] = {"builtin:hall?lights=32", "builtin:glass", "builtin:city?lights=64"};
    static const fnl_shading paths[] = {FNL_SHADING_FORWARD, FNL_SHADING_DEFERRED, FNL_SHADING_VISIBILITY};
    for (uint32_t i = 0; i < COUNT_OF(sources); i++) {
        struct stage s = stage_open(sources[i], 0);
        s.frame.shadows = FNL_SHADOWS_OFF;
        for (uint32_t k = 0; k < COUNT_OF(paths); k++) {
            s.frame.shading = paths[k];
            s.frame.front_to_back = false;
            struct shot before = stage_shoot(&s, &s.frame);
            s.frame.front_to_back = true;
            struct shot after = stage_shoot(&s, &s.frame);
            const uint32_t differ = differing(&before.radiance, &after.radiance);
            print_message("%s, path %u: %u pixels differ\n", sources[i], (uint32_t)paths[k], differ);
            assert_true(differ <= after.radiance.width * after.radiance.height / 500); /* coplanar surfaces */
            shot_free(&before);
            shot_free(&after);
        }
        stage_close(&s);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_less_is_shaded_ES_4, harness_check),
        cmocka_unit_test_teardown(test_a_strip_is_large, harness_check),
        cmocka_unit_test_teardown(test_the_picture_stays, harness_check),
    };
    return cmocka_run_group_tests_name("draw_order", tests, harness_begin, harness_end);
}
