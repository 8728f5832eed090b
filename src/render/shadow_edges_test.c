/* SPDX-License-Identifier: MIT */
/* What shadow maps of other renderers get wrong: odd places of lights and casters, budgets and edits. Mirrored, stretched and cutout casters are among tests/shadow_cases.c. */
#include "tests/render_harness.h"
#include "tests/shadow_cases.h"
#include "tests/shadow_leak.h"

static struct stage floor_stage(fnl_scene *scene, float height) {
    const fnl_trace_params view = look_down((vec3){0, 0, 0}, 8, height, SHADOW_SIZE);
    struct stage s = shadow_stage(scene, &view);
    s.frame.shadows = FNL_SHADOWS_MAPS;
    return s;
}

static fnl_scene *bare_floor(void) {
    fnl_scene *scene = world_create(NULL);
    const fnl_material_params material = matt(1);
    add_square(scene, &material, (vec3){10, 1, 10}, (vec3){0, 0, 0});
    return scene;
}

/* An upright square, half a metre to each side of x = `x`, `high` metres tall, standing on the floor. */
static void add_wall(fnl_scene *scene, float x, float wide, float low, float high) {
    const fnl_material_params material = matt(1);
    const mat4 place = mat4_from_trs((vec3){x, 0.5f * (low + high), 0}, quat_axis_angle((vec3){0, 0, 1}, PI / 2), (vec3){0.5f * (high - low), 1, wide});
    add_instance(scene, add_square_mesh(scene, add_material(scene, &material)), place);
}

static void parts_of(struct stage *s, fnl_shadows shadows, float *out) {
    s->frame.shadows = shadows;
    shadow_parts(s, out);
    for (uint32_t i = 0; i < SHADOW_SIZE * SHADOW_SIZE; i++) assert_true(out[i] >= 0 && out[i] < 1.0001f);
}

/* Pixels that maps and rays do not show alike, at the edges of shadows in any case. */
static uint32_t wrong_pixels(struct stage *s, uint32_t *out_dark) {
    static float maps[SHADOW_SIZE * SHADOW_SIZE], rays[SHADOW_SIZE * SHADOW_SIZE];
    parts_of(s, FNL_SHADOWS_RAYS, rays);
    parts_of(s, FNL_SHADOWS_MAPS, maps);
    uint32_t wrong = 0;
    for (uint32_t i = 0; i < COUNT_OF(maps); i++) {
        const bool differ = fabsf(maps[i] - rays[i]) > 0.01f;
        if (differ && wrong < 3) print_message("%u %u: %g by maps, %g by rays\n", i % SHADOW_SIZE, i / SHADOW_SIZE, (double)maps[i], (double)rays[i]);
        wrong += differ;
        *out_dark += rays[i] < 0.5f;
    }
    return wrong;
}

static void test_a_light_in_a_wall_lights_nothing(void **state) {
    UNUSED(state);
    fnl_scene *scene = bare_floor();
    const fnl_material_params material = matt(1);
    for (int i = 0; i < 2; i++) { /* the faces of a wall of 20 cm */
        add_wall(scene, i ? 0.1f : -0.1f, 0.51f, 0.49f, 1.51f);
        add_square(scene, &material, (vec3){0.11f, 1, 0.51f}, (vec3){0, i ? 1.5f : 0.5f, 0});
        add_instance(scene, add_square_mesh(scene, add_material(scene, &material)),
                     mat4_from_trs((vec3){0, 1, i ? 0.5f : -0.5f}, quat_axis_angle((vec3){1, 0, 0}, PI / 2), (vec3){0.11f, 1, 0.51f}));
    }
    add_point_light(scene, (vec3){0.02f, 1, 0.1f}, 50);
    struct stage s = floor_stage(scene, 0.4f);
    uint32_t dark = 0;
    assert_int_equal(wrong_pixels(&s, &dark), 0);
    assert_int_equal(dark, SHADOW_SIZE * SHADOW_SIZE);
    stage_close(&s);
}

/* What hides a light may be nearer to a surface than a pixel is wide, with several samples per pixel too. Here a square a quarter of a pixel above the floor, which faces it, so
   that the viewer looks through. */
static void test_casters_may_be_nearer_than_a_pixel(void **state) {
    UNUSED(state);
    fnl_device_info info;
    assert_int_equal(fnl_device_query_info(harness_device(), &info), FNL_OK);
    fnl_scene *scene = bare_floor();
    const fnl_material_params material = matt(1);
    add_instance(scene, add_square_mesh(scene, add_material(scene, &material)),
                 mat4_from_trs((vec3){2, 0.03f, 0}, quat_axis_angle((vec3){1, 0, 0}, PI), (vec3){2, 1, 4}));
    add_point_light(scene, (vec3){0, 3, 0}, 50);
    struct stage s = floor_stage(scene, 0.4f);
    s.frame.shadows = FNL_SHADOWS_RAYS;
    for (uint32_t i = 0; i < 4; i++) {
        static float parts[SHADOW_SIZE * SHADOW_SIZE];
        s.frame.msaa = i % 2 ? 4 : 1;
        s.frame.shading = i < 2 ? FNL_SHADING_FORWARD : FNL_SHADING_DEFERRED;
        if (!(info.msaa_counts & s.frame.msaa)) continue;
        shadow_parts(&s, parts);
        uint32_t wrong = 0;
        for (uint32_t k = 0; k < COUNT_OF(parts); k++) {
            const uint32_t x = k % SHADOW_SIZE;
            if (x == SHADOW_SIZE / 2 - 1 || x == SHADOW_SIZE / 2) continue; /* the edge */
            wrong += x > SHADOW_SIZE / 2 ? parts[k] > 0.01f : parts[k] < 0.99f;
        }
        if (wrong) fail_msg("%s, %u samples: %u pixels are wrong", fnl_value_name(FNL_ENUM_SHADING, s.frame.shading), s.frame.msaa, wrong);
    }
    stage_close(&s);
}

/* A millimetre before a wall, in the very plane of it, and on a ceiling. */
static void test_lights_on_surfaces_shine(void **state) {
    UNUSED(state);
    for (int i = 0; i < 3; i++) {
        fnl_scene *scene = bare_floor();
        const fnl_material_params material = matt(1);
        add_wall(scene, 1, 1, 0, 1);
        if (i == 2) add_square(scene, &material, (vec3){2, 1, 2}, (vec3){0, 2, 0});
        add_point_light(scene, i == 2 ? (vec3){0, 2, 0} : (vec3){i ? 1 : 0.999f, 0.5f, 0}, 50);
        struct stage s = floor_stage(scene, 0.4f);
        uint32_t dark = 0;
        const uint32_t wrong = wrong_pixels(&s, &dark);
        print_message("case %d: %u wrong, %u dark\n", i, wrong, dark);
        assert_true(wrong <= SHADOW_SIZE * SHADOW_SIZE / 50);
        assert_true(i == 1 || (dark > 150 && dark < SHADOW_SIZE * SHADOW_SIZE * 6 / 10));
        stage_close(&s);
    }
}

/* A wall that passes 2 cm, then 2 mm, beside the light: behind it in one face, before it in others, and across their sides. */
static void test_casters_cross_the_near_plane(void **state) {
    UNUSED(state);
    for (int i = 0; i < 2; i++) {
        fnl_scene *scene = bare_floor();
        const float away = i ? 0.002f : 0.02f;
        add_wall(scene, 0.3f + away, 1.5f, 0.5f, 1.6f);
        add_point_light(scene, (vec3){0.3f, 1, 0}, 50);
        struct stage s = floor_stage(scene, 0.4f);
        uint32_t dark = 0;
        const uint32_t wrong = wrong_pixels(&s, &dark);
        print_message("%g m: %u wrong, %u dark\n", (double)away, wrong, dark);
        assert_true(dark > SHADOW_SIZE * SHADOW_SIZE / 4);
        assert_true(wrong <= 3 * SHADOW_SIZE);
        stage_close(&s);
    }
}

/* Pictures of one pixel, whose faces have 8 texels. */
static void test_faces_of_few_texels(void **state) {
    UNUSED(state);
    fnl_scene *scene = shadow_floor();
    const fnl_material_params material = matt(1);
    add_square(scene, &material, (vec3){6, 1, 6}, (vec3){0, 1, 0});
    struct stage s = floor_stage(scene, 0.5f);
    for (uint32_t size = 1; size <= 3; size++) {
        s.frame.width = s.frame.height = size;
        s.frame.shadows = FNL_SHADOWS_MAPS;
        struct shot maps = stage_shoot(&s, &s.frame);
        assert_int_equal(count_broken(&maps.radiance), 0);
        assert_true(counter(&maps.stats, "shadows.cells") <= 1 && counter(&maps.stats, "shadows.pages") > 0);
        for (uint32_t i = 0; i < size * size; i++) assert_true(pixel_at(&maps.radiance, i % size, i / size)[1] == 0);
        shot_free(&maps);
    }
    stage_close(&s);
}

/* ---- acne, contact ---- */

/* A lamp that grazes a floor, and walls that stand on it: no shadow where there is nothing, and none missing at a wall's foot. */
static void test_no_acne_and_no_gap_MP_6(void **state) {
    UNUSED(state);
    static float seen[SHADOW_SIZE * SHADOW_SIZE];
    for (int walls = 0; walls < 2; walls++) {
        fnl_scene *scene = bare_floor();
        add_point_light(scene, (vec3){-4.2f, 0.15f, 0.3f}, 50); /* 1 degree above the floor at the other side */
        if (walls) add_wall(scene, 0, 6, 0, 0.1f);
        struct stage s = floor_stage(scene, 1.5f);
        parts_of(&s, FNL_SHADOWS_MAPS, seen);
        uint32_t dark = 0, gap = 0, early = 0;
        for (uint32_t y = 0; y < SHADOW_SIZE; y++)
            for (uint32_t x = 0; x < SHADOW_SIZE; x++) {
                const bool is_dark = seen[y * SHADOW_SIZE + x] < 0.5f;
                dark += is_dark;
                gap += x == SHADOW_SIZE / 2 + 2 && !is_dark; /* two pixels, so at least two texels, behind the wall */
                early += x < SHADOW_SIZE / 2 - 4 && is_dark; /* two texels are wider yet on a floor that is seen at such an angle */
            }
        print_message("%d walls: %u dark, %u of them before it, %u missing at its foot\n", walls, dark, early, gap);
        assert_int_equal(early, 0);
        if (!walls) assert_int_equal(dark, 0);
        if (walls) assert_true(gap == 0 && dark > 100);
        stage_close(&s);
    }
}

/* A closed room casts no shadow in itself, wherever its lamp is: beside a wall the walls' depths are steep, and texels in corners show two of them. */
static void test_a_lamp_beside_a_wall(void **state) {
    UNUSED(state);
    static const float away[] = {0.01f, 0.05f, 0.3f};
    for (uint32_t k = 0; k < COUNT_OF(away); k++) {
        fnl_scene *scene = world_create(NULL);
        const fnl_material_params material = matt(1);
        const fnl_mesh_id mesh = add_square_mesh(scene, add_material(scene, &material));
        for (int wall = 0; wall < 6; wall++) {
            const float side = wall & 1 ? 3 : -3;
            const quat turn = wall < 2 ? quat_axis_angle((vec3){0, 0, 1}, wall & 1 ? PI / 2 : -PI / 2)
                              : wall < 4 ? quat_axis_angle((vec3){1, 0, 0}, wall & 1 ? PI : 0)
                                         : quat_axis_angle((vec3){1, 0, 0}, wall & 1 ? -PI / 2 : PI / 2);
            add_instance(scene, mesh, mat4_from_trs((vec3){wall < 2 ? side : 0, wall / 2 == 1 ? side : 0, wall > 3 ? side : 0}, turn, (vec3){3, 1, 3}));
        }
        add_point_light(scene, (vec3){3 - away[k], 0.2f, 0.1f}, 20);
        struct stage s = stage_open_scene(scene);
        s.frame.width = 40, s.frame.height = 23;
        s.frame.camera = fnl_camera_default();
        s.frame.camera.position = (vec3){0, 0, 2.2f};
        s.frame.camera.target = (vec3){0, 0, 0};
        s.frame.camera.vertical_fov = 1.9f;
        struct shot open = stage_shoot(&s, &s.frame);
        s.frame.shadows = FNL_SHADOWS_MAPS;
        struct shot maps = stage_shoot(&s, &s.frame);
        uint32_t lit = 0, dark = 0;
        for (uint32_t i = 0; i < s.frame.width * s.frame.height; i++) {
            const float want = pixel_at(&open.radiance, i % 40, i / 40)[1], got = pixel_at(&maps.radiance, i % 40, i / 40)[1];
            lit += want > 0;
            dark += got < 0.9f * want;
        }
        print_message("%g m from a wall: %u of %u pixels are dark\n", (double)away[k], dark, lit);
        assert_true(lit > 800);
        assert_int_equal(dark, 0);
        shot_free(&open);
        shot_free(&maps);
        stage_close(&s);
    }
}

/* Positions are less exact far from the eye; casters of 5 cm still have their shadows at 20 km. */
static void test_shadows_far_from_the_eye(void **state) {
    UNUSED(state);
    static float seen[2][SHADOW_SIZE * SHADOW_SIZE];
    static const fnl_shadows kinds[] = {FNL_SHADOWS_RAYS, FNL_SHADOWS_MAPS};
    for (uint32_t k = 0; k < COUNT_OF(kinds); k++) {
        uint32_t dark = 0, wrong = 0;
        for (int far = 0; far < 2; far++) {
            fnl_scene *scene = bare_floor();
            add_wall(scene, 0, 6, 0, 0.05f);
            add_point_light(scene, (vec3){-1, 0.2f, 0}, 50);
            const fnl_trace_params view = look_down((vec3){0, 0, 0}, 2, far ? 20000 : 5, SHADOW_SIZE);
            struct stage s = shadow_stage(scene, &view);
            s.frame.camera.near_distance = 1;
            s.frame.camera.far_distance = far ? 20010 : 10;
            parts_of(&s, kinds[k], seen[far]);
            stage_close(&s);
        }
        for (uint32_t i = 0; i < COUNT_OF(seen[0]); i++) {
            dark += seen[0][i] < 0.5f;
            wrong += fabsf(seen[0][i] - seen[1][i]) > 0.5f;
        }
        print_message("%s: %u pixels are dark, %u others from afar\n", fnl_value_name(FNL_ENUM_SHADOWS, (uint32_t)kinds[k]), dark, wrong);
        assert_true(dark > 100 && wrong * 4 < dark); /* two columns of pixels at most, at the foot of the wall */
    }
}

/* ---- edits ---- */

static void expect_fresh(struct stage *s, const char *what) {
    struct shot kept = stage_shoot(s, &s->frame);
    struct stage other = *s;
    other.renderer = NULL;
    assert_int_equal(fnl_renderer_create(harness_device(), s->scene, &other.renderer), FNL_OK);
    struct shot fresh = stage_shoot(&other, &s->frame);
    if (count_differing(&kept.radiance, &fresh.radiance) != 0) fail_msg("%s: pages that were kept show something else", what);
    assert_int_equal(counter(&kept.stats, "shadows.traced"), 0);
    shot_free(&kept);
    shot_free(&fresh);
    fnl_renderer_destroy(&other.renderer);
}

static void test_lights_that_move_in_every_frame(void **state) {
    UNUSED(state);
    fnl_scene *scene = bare_floor();
    const fnl_material_params material = matt(1);
    add_square(scene, &material, (vec3){0.5f, 1, 0.5f}, (vec3){0, 0.5f, 0});
    fnl_light_params lamp = fnl_light_params_default();
    lamp.range = 20;
    lamp.intensity = 50;
    lamp.position = (vec3){-1, 2, 0.3f};
    fnl_light_id id;
    assert_int_equal(fnl_scene_add_light(scene, &lamp, &id), FNL_OK);
    struct stage s = floor_stage(scene, 0.4f);
    for (int i = 0; i < 6; i++) {
        expect_fresh(&s, "a light that moves");
        lamp.position.x += 0.37f;
        lamp.position.y -= 0.1f;
        assert_int_equal(fnl_scene_set_light(scene, id, &lamp), FNL_OK);
    }
    stage_close(&s);
}

static void test_edits_of_a_scene_whose_pages_are_kept(void **state) {
    UNUSED(state);
    fnl_scene *scene = shadow_floor();
    fnl_material_params material = matt(1);
    const fnl_instance_id square = add_square(scene, &material, (vec3){0.5f, 1, 0.5f}, (vec3){0, 1, 0});
    struct stage s = floor_stage(scene, 0.4f);
    expect_fresh(&s, "the first frame");
    assert_int_equal(fnl_scene_remove_instance(scene, square), FNL_OK);
    expect_fresh(&s, "an instance goes");
    const fnl_instance_id other = add_square(scene, &material, (vec3){1, 1, 0.25f}, (vec3){1, 0.7f, 1}); /* in its place */
    expect_fresh(&s, "another comes");
    const mat4 place = mat4_mul(mat4_translation((vec3){-1, 1.5f, 0}), mat4_scaling((vec3){-1, 1, 0.3f}));
    assert_int_equal(fnl_scene_set_instance_transform(scene, other, &place), FNL_OK);
    expect_fresh(&s, "it moves and is mirrored");
    fnl_light_params lamp = fnl_light_params_default();
    lamp.position = (vec3){2, 1, 2};
    lamp.range = 5;
    fnl_light_id id, next;
    assert_int_equal(fnl_scene_add_light(scene, &lamp, &id), FNL_OK);
    expect_fresh(&s, "a light comes");
    assert_int_equal(fnl_scene_remove_light(scene, id), FNL_OK);
    lamp.position = (vec3){-2, 1, 2};
    assert_int_equal(fnl_scene_add_light(scene, &lamp, &next), FNL_OK); /* in the slot of the last */
    expect_fresh(&s, "a light takes the place of another");
    stage_close(&s);
}

/* Ten thousand lamps, of which every other one is lit, in turns. */
static void test_ten_thousand_lights_toggle(void **state) {
    UNUSED(state);
    enum { COUNT = 10000, SIDE = 100 };
    static fnl_light_id ids[COUNT];
    fnl_scene *scene = bare_floor();
    const fnl_material_params material = matt(1);
    for (int i = 0; i < 8; i++) add_square(scene, &material, (vec3){0.2f, 1, 0.2f}, (vec3){-3.5f + (float)i, 0.15f, -3.2f + 0.9f * (float)i});
    fnl_light_params lamp = fnl_light_params_default();
    lamp.range = 0.45f;
    for (uint32_t turn = 0; turn < 3; turn++) {
        for (uint32_t i = 0; i < COUNT; i++) {
            lamp.position = (vec3){0.08f * ((float)(i % SIDE) - 49.5f), 0.3f, 0.08f * ((float)(i / SIDE) - 49.5f)};
            lamp.intensity = (i + turn) % 2 ? 1 : 0;
            if (turn == 0) assert_int_equal(fnl_scene_add_light(scene, &lamp, &ids[i]), FNL_OK);
            else assert_int_equal(fnl_scene_set_light(scene, ids[i], &lamp), FNL_OK);
        }
        static struct stage s;
        if (turn == 0) {
            s = floor_stage(scene, 0.1f);
            s.frame.width = s.frame.height = 24;
            s.frame.lists = FNL_LISTS_TILED;
        }
        struct shot shot = stage_shoot(&s, &s.frame);
        if (turn == 0) print_message("%u pages of %u, %u lights coarser\n", (uint32_t)counter(&shot.stats, "shadows.pages"), (uint32_t)counter(&shot.stats, "shadows.wanted"), (uint32_t)counter(&shot.stats, "shadows.coarsened"));
        assert_int_equal(counter(&shot.stats, "shadows.traced"), 0);
        assert_int_equal(count_broken(&shot.radiance), 0);
        shot_free(&shot);
        if (turn == 2) expect_fresh(&s, "lamps that were switched");
        if (turn == 2) stage_close(&s);
    }
}

/* ---- budgets and work ---- */

static fnl_frame_stats after_frame(struct stage *s) {
    assert_int_equal(fnl_renderer_render(s->renderer, &s->frame), FNL_OK);
    return harness_stats(s->renderer);
}

static void test_no_light_is_starved_ES_69(void **state) {
    UNUSED(state);
    static const char *const sources[] = {"builtin:hall?lights=64", "builtin:hall?lights=256"}; /* with more: docs/techniques/shadows.md */
    for (uint32_t i = 0; i < COUNT_OF(sources); i++) {
        struct stage s = stage_open(sources[i], 0);
        s.frame.width = 32, s.frame.height = 18;
        s.frame.shadows = FNL_SHADOWS_MAPS;
        s.frame.shadow.memory = 32;
        s.frame.outputs = 0;
        fnl_frame_stats stats = after_frame(&s);
        for (int k = 0; k < 4 && counter(&stats, "shadows.waiting") > 0; k++) stats = after_frame(&s);
        print_message("%s: %u pages of %u, %u lights coarser\n", sources[i], (uint32_t)counter(&stats, "shadows.pages"), (uint32_t)counter(&stats, "shadows.wanted"),
                      (uint32_t)counter(&stats, "shadows.coarsened"));
        assert_int_equal(counter(&stats, "shadows.traced") + counter(&stats, "shadows.waiting"), 0);
        stage_close(&s);
    }
}

/* 256 lights, and one in twenty of the casters moves: a fifth of the work at most. With ever so many lights no pass more. */
static void test_little_is_drawn_where_little_moves_ES_69(void **state) {
    UNUSED(state);
    enum { CASTERS = 100, MOVING = 5, LIGHTS = 256 };
    fnl_scene *scene = bare_floor();
    const fnl_material_params material = matt(1);
    const fnl_mesh_id mesh = add_square_mesh(scene, add_material(scene, &material));
    fnl_instance_id casters[CASTERS];
    for (uint32_t i = 0; i < CASTERS; i++)
        casters[i] = add_instance(scene, mesh, mat4_mul(mat4_translation((vec3){0.8f * ((float)(i % 10) - 4.5f), 0.4f, 0.8f * ((float)(i / 10) - 4.5f)}), mat4_scaling((vec3){0.15f, 1, 0.15f})));
    for (uint32_t i = 0; i < LIGHTS; i++) {
        fnl_light_params lamp = fnl_light_params_default();
        fnl_light_id id;
        lamp.position = (vec3){0.5f * ((float)(i % 16) - 7.5f), 0.7f, 0.5f * ((float)(i / 16) - 7.5f)};
        lamp.range = 1;
        assert_int_equal(fnl_scene_add_light(scene, &lamp, &id), FNL_OK);
    }
    struct stage s = floor_stage(scene, 0.3f);
    s.frame.timers = true;
    fnl_frame_stats stats = after_frame(&s);
    for (int i = 0; i < 3; i++) stats = after_frame(&s);
    assert_int_equal(counter(&stats, "shadows.drawn"), 0);
    const uint64_t all = counter(&stats, "shadows.pages");
    uint64_t drawn = 0, pairs = 0;
    for (uint32_t k = 1; k <= 4; k++) {
        for (uint32_t i = 0; i < MOVING; i++) {
            const uint32_t at = i * 21;
            const mat4 place = mat4_mul(mat4_translation((vec3){0.8f * ((float)(at % 10) - 4.5f) + 0.02f * (float)k, 0.4f, 0.8f * ((float)(at / 10) - 4.5f)}), mat4_scaling((vec3){0.15f, 1, 0.15f}));
            assert_int_equal(fnl_scene_set_instance_transform(scene, casters[at], &place), FNL_OK);
        }
        stats = after_frame(&s);
        drawn += counter(&stats, "shadows.drawn");
        pairs += counter(&stats, "shadows.pairs");
    }
    print_message("%u pages, %.1f of them drawn in a frame, with %.1f items\n", (uint32_t)all, (double)drawn / 4, (double)pairs / 4);
    assert_true(drawn > 0 && drawn * 5 < all * 4);
    stage_close(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_a_light_in_a_wall_lights_nothing, harness_check),
        cmocka_unit_test_teardown(test_casters_may_be_nearer_than_a_pixel, harness_check),
        cmocka_unit_test_teardown(test_lights_on_surfaces_shine, harness_check),
        cmocka_unit_test_teardown(test_casters_cross_the_near_plane, harness_check),
        cmocka_unit_test_teardown(test_faces_of_few_texels, harness_check),
        cmocka_unit_test_teardown(test_no_acne_and_no_gap_MP_6, harness_check),
        cmocka_unit_test_teardown(test_a_lamp_beside_a_wall, harness_check),
        cmocka_unit_test_teardown(test_shadows_far_from_the_eye, harness_check),
        cmocka_unit_test_teardown(test_lights_that_move_in_every_frame, harness_check),
        cmocka_unit_test_teardown(test_edits_of_a_scene_whose_pages_are_kept, harness_check),
        cmocka_unit_test_teardown(test_ten_thousand_lights_toggle, harness_check),
        cmocka_unit_test_teardown(test_no_light_is_starved_ES_69, harness_check),
        cmocka_unit_test_teardown(test_little_is_drawn_where_little_moves_ES_69, harness_check),
    };
    return cmocka_run_group_tests_name("shadow_edges", tests, harness_begin, harness_end);
}
