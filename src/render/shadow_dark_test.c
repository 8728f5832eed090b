/* SPDX-License-Identifier: MIT */
/** Lights that leave the lists of tiles where maps show them in shadow (shadow.classify): which do, and that the picture stays as it is. */
#include "tests/render_harness.h"
#include "tests/shadow_cases.h"

static struct shot shoot(struct stage *s, bool classify) {
    s->frame.shadows = FNL_SHADOWS_MAPS;
    s->frame.outputs = FNL_OUTPUT_RADIANCE;
    s->frame.count_lights = true;
    s->frame.shadow.classify = classify;
    return stage_shoot(s, &s->frame);
}

struct work {
    uint64_t entries, dark, evaluations, before; /* before: evaluations without */
};

/* The frame as it is next, and once more without: by then nothing is drawn, so the maps are the same. */
static struct work expect_alike(struct stage *s, const char *what) {
    struct shot with = shoot(s, true), without = shoot(s, false);
    if (count_differing(&with.radiance, &without.radiance) > 0)
        fail_msg("%s, %s: %llu pixels differ", what, fnl_value_name(FNL_ENUM_SHADING, s->frame.shading),
                 (unsigned long long)count_differing(&with.radiance, &without.radiance));
    assert_int_equal(counter(&without.stats, "shadows.drawn"), 0);
    assert_int_equal(counter(&without.stats, "shadows.dark"), 0);
    const struct work work = {counter(&with.stats, "shadows.entries"), counter(&with.stats, "shadows.dark"), with.stats.evaluations,
                              without.stats.evaluations};
    shot_free(&with);
    shot_free(&without);
    return work;
}

/* ---- scenes ---- */

/* At most this part of the evaluations is left. */
static void expect_work(const char *source, double most) {
    static const fnl_shading paths[] = {FNL_SHADING_DEFERRED, FNL_SHADING_FORWARD, FNL_SHADING_VISIBILITY};
    struct stage s = stage_open(source, 0);
    s.frame.width = 157, s.frame.height = 83;
    s.frame.lists = FNL_LISTS_TILED;
    const uint32_t count = strstr(source, "interior") ? COUNT_OF(paths) : 1; /* all shapes of lights, glass and cutouts */
    for (uint32_t i = 0; i < count; i++) {
        s.frame.shading = paths[i];
        const struct work work = expect_alike(&s, source);
        print_message("%s: %llu of %llu entries leave, %.2f of the evaluations are left\n", source, (unsigned long long)work.dark,
                      (unsigned long long)work.entries, (double)work.evaluations / (double)work.before);
        assert_true((double)work.evaluations < most * (double)work.before);
    }
    stage_close(&s);
}

static void test_dark_lights_leave_with_the_same_picture_ES_49(void **state) {
    UNUSED(state);
    expect_work("builtin:hall?lights=256", 0.65);
    expect_work("builtin:city?lights=256&blocks=1", 0.67);
    expect_work("builtin:interior?lights=40", 0.55);
}

/* ---- which ones ---- */

enum { TILE = 8, TILES = SHADOW_SIZE / TILE };

/* Tiles in which no pixel has light. */
static uint32_t dark_tiles(const fnl_image *radiance) {
    uint32_t count = 0;
    for (uint32_t tile = 0; tile < TILES * TILES; tile++) {
        bool is_dark = true;
        for (uint32_t i = 0; i < TILE * TILE && is_dark; i++) {
            const uint32_t x = tile % TILES * TILE + i % TILE, y = tile / TILES * TILE + i / TILE;
            is_dark = ((const float *)radiance->pixels)[(y * SHADOW_SIZE + x) * 4] == 0;
        }
        count += is_dark;
    }
    return count;
}

/* A square over a floor under one lamp, whose shadow is seen at several sizes: a light leaves just the tiles that are all dark, but for some whose squares
   of texels reach beyond the edge. */
static void test_a_light_leaves_all_dark_tiles_ES_49(void **state) {
    UNUSED(state);
    static const float sizes[] = {0.5f, 1, 1.7f, 2.6f};
    uint32_t dark = 0, left = 0, tiles = 0;
    for (uint32_t i = 0; i < COUNT_OF(sizes); i++) {
        fnl_scene *scene = shadow_floor();
        const fnl_material_params material = matt(1);
        add_square(scene, &material, (vec3){sizes[i], 1, sizes[i]}, (vec3){0, 1, 0});
        struct stage s = stage_open_scene(scene);
        const fnl_trace_params view = look_down((vec3){0, 0, 0}, 8, 0.5f, SHADOW_SIZE);
        s.frame.width = view.width, s.frame.height = view.height;
        s.frame.camera = view.camera;
        s.frame.shading = FNL_SHADING_DEFERRED;
        struct shot shot = shoot(&s, true);
        const uint32_t truth = dark_tiles(&shot.radiance);
        assert_int_equal(shot.stats.evaluations, (TILES * TILES - counter(&shot.stats, "shadows.dark")) * TILE * TILE);
        assert_true(counter(&shot.stats, "shadows.dark") <= truth);
        dark += truth;
        left += (uint32_t)counter(&shot.stats, "shadows.dark");
        tiles += TILES * TILES;
        shot_free(&shot);
        expect_alike(&s, "square");
        stage_close(&s);
    }
    print_message("%u of %u tiles are dark, the light has left %u\n", dark, tiles, left);
    assert_true(dark > tiles / 4 && dark < tiles && left * 10 > dark * 7);
}

/* Edges at all places within texels and pixels, and floors that need several levels within a tile. */
static void test_edges_lie_anywhere(void **state) {
    UNUSED(state);
    enum { VIEWS = 40, LAMPS = 40 };
    struct random_state random = {31};
    fnl_scene *scene = shadow_floor();
    for (uint32_t i = 0; i < LAMPS; i++)
        add_point_light(scene, (vec3){random_range(&random, -3, 3), random_range(&random, 1.6f, 5), random_range(&random, -3, 3)}, 9);
    const fnl_material_params material = matt(1);
    const fnl_instance_id shade = add_square(scene, &material, (vec3){1, 1, 1}, (vec3){0, 1, 0});
    struct stage s = stage_open_scene(scene);
    s.frame.width = s.frame.height = SHADOW_SIZE;
    s.frame.shading = FNL_SHADING_DEFERRED;
    uint64_t dark = 0;
    for (uint32_t i = 0; i < VIEWS; i++) {
        const vec3 at = {random_range(&random, -0.5f, 0.5f), random_range(&random, 0.5f, 1.5f), random_range(&random, -0.5f, 0.5f)};
        const vec3 size = {random_range(&random, 0.4f, 2), 1, random_range(&random, 0.4f, 2)};
        const mat4 place = mat4_mul(mat4_translation(at), mat4_scaling(size));
        assert_int_equal(fnl_scene_set_instance_transform(scene, shade, &place), FNL_OK);
        s.frame.camera.position = (vec3){random_range(&random, -5, 5), random_range(&random, 0.3f, 6), random_range(&random, 2, 6)};
        s.frame.camera.target = (vec3){random_range(&random, -1, 1), 0, random_range(&random, -1, 1)};
        dark += expect_alike(&s, "edges").dark;
    }
    print_message("in %u views lights have left %.1f tiles of each\n", VIEWS, (double)dark / VIEWS / LAMPS);
    assert_true(dark > VIEWS * LAMPS * 2);
    stage_close(&s);
}

/* ---- what changes ---- */

/* What is known of pages is that of what was drawn last, wherever they lie. */
static void test_dark_lights_come_back(void **state) {
    UNUSED(state);
    fnl_scene *scene = shadow_floor();
    const fnl_material_params material = matt(1);
    const fnl_instance_id shade = add_square(scene, &material, (vec3){1.5f, 1, 1.5f}, (vec3){0, 1, 0});
    fnl_light_params lamp = fnl_light_params_default();
    lamp.position = (vec3){-2, 2.5f, 1};
    lamp.intensity = 20;
    lamp.range = 30;
    fnl_light_id id;
    assert_int_equal(fnl_scene_add_light(scene, &lamp, &id), FNL_OK);
    struct stage s = stage_open_scene(scene);
    const fnl_trace_params view = look_down((vec3){0, 0, 0}, 8, 0.5f, SHADOW_SIZE);
    s.frame.width = view.width, s.frame.height = view.height;
    s.frame.camera = view.camera;
    s.frame.shading = FNL_SHADING_DEFERRED;
    const uint64_t first = expect_alike(&s, "first").dark;
    const mat4 away = mat4_translation((vec3){9, 1, 9}), back = mat4_mul(mat4_translation((vec3){0, 1, 0}), mat4_scaling((vec3){1.5f, 1, 1.5f}));
    assert_int_equal(fnl_scene_set_instance_transform(scene, shade, &away), FNL_OK);
    assert_int_equal(expect_alike(&s, "square away").dark, 0);
    assert_int_equal(fnl_scene_set_instance_transform(scene, shade, &back), FNL_OK);
    assert_int_equal(expect_alike(&s, "square back").dark, first);
    lamp.position = (vec3){2, 2.5f, -1};
    assert_int_equal(fnl_scene_set_light(scene, id, &lamp), FNL_OK);
    const uint64_t moved = expect_alike(&s, "lamp moved").dark;
    lamp.casts_shadows = false;
    assert_int_equal(fnl_scene_set_light(scene, id, &lamp), FNL_OK);
    const uint64_t one = expect_alike(&s, "no shadows").dark;
    assert_true(first > 4 && one > 2 && moved > one);
    s.frame.camera.position.x += 3.3f;
    expect_alike(&s, "viewer moved");
    s.frame.shadow.filter = FNL_SHADOW_FILTER_PCF; /* what filters look up is not looked at */
    assert_int_equal(expect_alike(&s, "filtered").entries, 0);
    s.frame.shadow.filter = FNL_SHADOW_FILTER_HARD;
    s.frame.msaa = 4;
    assert_int_equal(expect_alike(&s, "several samples").entries, 0);
    s.frame.msaa = 1;
    s.frame.width = s.frame.height = 1;
    expect_alike(&s, "one pixel");
    stage_close(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_dark_lights_leave_with_the_same_picture_ES_49, harness_check),
        cmocka_unit_test_teardown(test_a_light_leaves_all_dark_tiles_ES_49, harness_check),
        cmocka_unit_test_teardown(test_edges_lie_anywhere, harness_check),
        cmocka_unit_test_teardown(test_dark_lights_come_back, harness_check),
    };
    return cmocka_run_group_tests_name("shadow_dark", tests, harness_begin, harness_end);
}
