/* SPDX-License-Identifier: MIT */
/** Decals of all kinds against what the CPU makes of the positions that the GPU shows, and both ways of applying them. */
#include "tests/render_test.h"

#include "tests/decals_cases.h"

/* A wall and a floor, boxes at all angles, seen from many sides, one of them inside of a box: a pixel shows a decal in either way where
   the CPU says. */
static void test_boxes_hold_what_the_CPU_says_ES_30(void **state) {
    (void)state;
    fnl_scene *scene = wall_scene();
    uint32_t quad = test_quad_mesh(scene, add_grey(scene));
    mat4 floor = mat4_from_trs((vec3){0, -1, 1}, quat_axis_angle((vec3){1, 0, 0}, -PI / 2), (vec3){1, 1, 1});
    scene_add_node(scene, "", SCENE_NONE, &floor, quad);
    scene_update_transforms(scene);
    mat4 boxes[4] = {
        box_at((vec3){0.2f, -0.1f, 0}, quat_axis_angle(vec3_normalize((vec3){1, 2, 3}), 0.7f), (vec3){0.9f, 0.5f, 0.6f}),
        box_at((vec3){-0.5f, 0.5f, 0.1f}, quat_identity(), (vec3){0.4f, 0.7f, 0.3f}),
        box_at((vec3){0.1f, -1, 0.9f}, quat_axis_angle((vec3){1, 0, 0}, -PI / 2), (vec3){1.1f, 0.6f, 0.2f}),
        {{0.5f, 0.2f, 0, 0, -0.1f, 0.5f, 0.1f, 0, 0.2f, 0, 0.8f, 0, 0.6f, 0.6f, 0, 1}}, /* skewed */
    };
    for (int i = 0; i < 4; i++) {
        fnl_decal_params p = plain(1, 0, 0, 1, boxes[i]);
        p.fade_start = p.fade_end = PI; /* on faces of all directions */
        add(scene, &p);
    }
    const fnl_camera cameras[5] = {
        test_front_camera(), eye_camera((vec3){1.3f, 0.4f, 2.1f}, (vec3){0, -0.4f, 0.3f}, 0.9f),
        eye_camera((vec3){0.25f, -0.1f, 0.2f}, (vec3){0.1f, -0.2f, 0}, 1.4f), /* inside the first box */
        eye_camera((vec3){-0.4f, 0.5f, 0.15f}, (vec3){-0.5f, 0.4f, 0}, 1.2f),
        eye_camera((vec3){0, -0.95f, 1.8f}, (vec3){0, -0.9f, 0}, 0.7f)};
    const fnl_shading shadings[2] = {FNL_SHADING_FORWARD, FNL_SHADING_DEFERRED};
    for (int c = 0; c < 5; c++)
        for (int way = 0; way < 3; way++) {
            fnl_frame frame = frame_with(shadings[way > 0], way == 2 ? FNL_DECALS_GBUFFER : FNL_DECALS_LISTS,
                                         FNL_OUTPUT_RADIANCE | FNL_OUTPUT_POSITION);
            frame.camera = cameras[c];
            frame.width = 61;
            frame.height = 47;
            fnl_renderer *r = test_renderer(scene);
            test_render_frame(r, &frame);
            fnl_image radiance = test_read(r, FNL_OUTPUT_RADIANCE), position = test_read(r, FNL_OUTPUT_POSITION);
            uint32_t inside = 0, outside = 0;
            for (uint32_t i = 0; i < frame.width * frame.height; i++) {
                const float *at = test_pixel(&position, i % frame.width, i / frame.width),
                            *seen = test_pixel(&radiance, i % frame.width, i / frame.width);
                if (at[3] == 0) continue;
                bool expected = false, close = false;
                for (int k = 0; k < 4; k++) {
                    mat4 inverse;
                    double nearest;
                    assert_true(mat4_inverse(&boxes[k], &inverse));
                    expected |= holds(&inverse, at, &nearest);
                    close |= nearest < 2e-5;
                }
                if (close) continue;
                bool is_red = seen[1] < 0.3f * seen[0];
                if (is_red != expected) fail_msg("camera %d, way %d, pixel %u: red %d, box %d", c, way, i, is_red, expected);
                expected ? inside++ : outside++;
            }
            if (c != 2) assert_true(inside > 40 && outside > 40);
            free_picture(&radiance);
            free_picture(&position);
            fnl_renderer_destroy(&r);
        }
    fnl_scene_destroy(&scene);
}

/* Four slices of one colour each on a slanted cut through the box: linear between the middles of slices. */
static void slice_texel(uint32_t x, uint32_t y, uint8_t out[4]) {
    static const uint8_t colors[4][4] = {{255, 0, 0, 255}, {0, 255, 0, 255}, {0, 0, 255, 255}, {255, 255, 255, 255}};
    (void)x;
    memcpy(out, colors[y / 8], 4);
}

static void test_volume_decals_show_the_slice_ES_31(void **state) {
    (void)state;
    fnl_scene *scene = test_scene();
    mat4 slant = mat4_from_trs((vec3){0, 0, 0}, quat_axis_angle((vec3){0, 1, 0}, 0.9f), (vec3){1.6f, 1, 1});
    scene_add_node(scene, "", SCENE_NONE, &slant, test_quad_mesh(scene, add_grey(scene)));
    scene_update_transforms(scene);
    fnl_decal_params p = plain(1, 1, 1, 1, box_at((vec3){0, 0, 0}, quat_identity(), (vec3){2, 2, 2}));
    p.kind = FNL_DECAL_VOLUME;
    p.slices = 4;
    p.color_image = add_picture(scene, 8, 32, true, slice_texel);
    add(scene, &p);
    fnl_frame frame = frame_with(FNL_SHADING_FORWARD, FNL_DECALS_LISTS, FNL_OUTPUT_SURFACE | FNL_OUTPUT_POSITION);
    fnl_renderer *r = test_renderer(scene);
    test_render_frame(r, &frame);
    fnl_image surface = test_read(r, FNL_OUTPUT_SURFACE), position = test_read(r, FNL_OUTPUT_POSITION);
    uint32_t checked = 0;
    for (uint32_t i = 0; i < SIDE * SIDE; i++) {
        const float *at = test_pixel(&position, i % SIDE, i / SIDE);
        if (at[3] == 0 || fabsf(at[2]) > 0.999f) continue;
        static const double colors[4][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
        double z = fmin(fmax((0.5 - (double)at[2] / 2) * 4 - 0.5, 0), 3);
        int low = (int)floor(z), high = low < 3 ? low + 1 : 3;
        double f = z - low, expected[3];
        for (int k = 0; k < 3; k++) expected[k] = colors[low][k] * (1 - f) + colors[high][k] * f;
        assert_pixel(&surface, i % SIDE, i / SIDE, expected[0], expected[1], expected[2], 0.004);
        checked++;
    }
    assert_true(checked > 1500);
    free_picture(&surface);
    free_picture(&position);
    fnl_renderer_destroy(&r);
    fnl_scene_destroy(&scene);
}

/* A man on a floor with a decal that holds both: what refuses it keeps its bits, in both ways. */
static void test_characters_stay_clean_ES_32(void **state) {
    (void)state;
    fnl_scene *scene = test_load("CesiumMan.glb", true);
    uint32_t node_count = scene->nodes.count;
    mat4 floor = mat4_from_trs((vec3){0, 0, 0}, quat_axis_angle((vec3){1, 0, 0}, -PI / 2), (vec3){2, 2, 2});
    scene_add_node(scene, "", SCENE_NONE, &floor, test_quad_mesh(scene, add_grey(scene)));
    scene_update_transforms(scene);
    assert_int_equal(fnl_scene_set_ambient(scene, (vec3){1, 1, 1}, (vec3){1, 1, 1}), FNL_OK);
    fnl_decal_params p =
        plain(0, 1, 0, 1, box_at((vec3){0, 0.5f, 0}, quat_axis_angle((vec3){1, 0, 0}, -PI / 2), (vec3){2, 2, 2}));
    p.receivers = 1;
    add(scene, &p);
    fnl_frame frame = frame_with(FNL_SHADING_DEFERRED, FNL_DECALS_OFF, FNL_OUTPUT_COLOR | FNL_OUTPUT_POSITION);
    frame.camera = eye_camera((vec3){1.8f, 1.6f, 2.2f}, (vec3){0, 0.6f, 0}, 0.8f);
    fnl_renderer *r = test_renderer(scene);
    test_render_frame(r, &frame);
    fnl_image bare = test_read(r, FNL_OUTPUT_COLOR), position = test_read(r, FNL_OUTPUT_POSITION);
    for (uint32_t refuses = 0; refuses < 2; refuses++)
        for (int way = FNL_DECALS_LISTS; way <= FNL_DECALS_GBUFFER; way++) {
            for (uint32_t i = 0; i < node_count; i++) scene->nodes.data[i].refuses = refuses ? 1 : 0;
            scene_structure_changed(scene);
            frame.decals = (fnl_decals)way;
            test_render_frame(r, &frame);
            fnl_image seen = test_read(r, FNL_OUTPUT_COLOR);
            uint32_t floor_green = 0, man_changed = 0, man = 0;
            for (uint32_t i = 0; i < SIDE * SIDE; i++) {
                const float *at = test_pixel(&position, i % SIDE, i / SIDE);
                const uint8_t *a = test_pixel8(&bare, i % SIDE, i / SIDE), *b = test_pixel8(&seen, i % SIDE, i / SIDE);
                if (at[3] == 0) continue;
                if (fabsf(at[1]) > 0.02f) { /* not the floor, nor the soles */
                    man++;
                    man_changed += memcmp(a, b, 4) != 0;
                } else {
                    floor_green += b[1] > 2 * b[0] + 20;
                }
            }
            assert_true(man > 100 && floor_green > 100);
            if (refuses)
                assert_int_equal(man_changed, 0);
            else
                assert_true(man_changed > 50);
            free_picture(&seen);
        }
    free_picture(&bare);
    free_picture(&position);
    fnl_renderer_destroy(&r);
    fnl_scene_destroy(&scene);
}

/* Walls turned away more and more: in full, by the smooth step, not at all. */
static void test_steep_sides_fade_ES_33(void **state) {
    (void)state;
    for (int step = 0; step < 12; step++) {
        fnl_scene *scene = test_scene();
        float angle = (float)step * PI / 24, start = 30 * PI / 180, end = 70 * PI / 180;
        mat4 turned = mat4_from_trs((vec3){0, 0, 0}, quat_axis_angle((vec3){0, 1, 0}, angle), (vec3){0.4f, 0.4f, 0.4f});
        scene_add_node(scene, "", SCENE_NONE, &turned, test_quad_mesh(scene, add_grey(scene)));
        scene_update_transforms(scene);
        fnl_decal_params p = plain(1, 0, 0, 1, box_at((vec3){0, 0, 0}, quat_identity(), (vec3){2, 2, 2}));
        p.fade_start = start;
        p.fade_end = end;
        add(scene, &p);
        fnl_frame frame = test_frame(FNL_OUTPUT_SURFACE);
        fnl_image surface = test_render(scene, &frame, FNL_OUTPUT_SURFACE);
        double t = (cos((double)angle) - cos((double)end)) / (cos((double)start) - cos((double)end));
        t = fmin(fmax(t, 0), 1);
        t = t * t * (3 - 2 * t);
        assert_pixel(&surface, 32, 32, 0.5 + 0.5 * t, 0.5 - 0.5 * t, 0.5 - 0.5 * t, 1e-3);
        free_picture(&surface);
        fnl_scene_destroy(&scene);
    }
}

static void bump_texel(uint32_t x, uint32_t y, uint8_t out[4]) {
    out[0] = (uint8_t)(128 + 80 * ((x / 4) % 2 ? 1 : -1));
    out[1] = (uint8_t)(128 + 80 * ((y / 4) % 2 ? 1 : -1));
    out[2] = 220;
    out[3] = 255;
}

/* Layers given in another order than their keys; what only bumps leaves the bits of the base colour; two runs give the same bytes. */
static void test_layers_keep_their_order_ES_34(void **state) {
    (void)state;
    fnl_scene *scene = wall_scene();
    fnl_light_params light = test_point((vec3){0.7f, 0.3f, 0.8f}, 3, 5);
    scene_add_light(scene, &light, SCENE_NONE);
    static const float colors[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    static const int keys[3] = {30, 10, 20}; /* green, blue, red */
    mat4 box = box_at((vec3){0, 0, 0}, quat_identity(), (vec3){1.2f, 1.2f, 0.5f});
    for (int i = 0; i < 3; i++) {
        fnl_decal_params p = plain(colors[i][0], colors[i][1], colors[i][2], 0.5f, box);
        p.sort_key = keys[i];
        add(scene, &p);
    }
    fnl_frame frame = test_frame(FNL_OUTPUT_SURFACE);
    fnl_image surface = test_render(scene, &frame, FNL_OUTPUT_SURFACE);
    double expected[3] = {0.5, 0.5, 0.5};
    for (int layer = 0; layer < 3; layer++)
        for (int k = 0; k < 3; k++) expected[k] = expected[k] * 0.5 + 0.5 * (double)colors[(layer + 1) % 3][k];
    assert_pixel(&surface, 32, 32, expected[0], expected[1], expected[2], 1e-5);
    free_picture(&surface);

    frame = frame_with(FNL_SHADING_DEFERRED, FNL_DECALS_LISTS, FNL_OUTPUT_COLOR);
    fnl_image lists = test_render(scene, &frame, FNL_OUTPUT_COLOR);
    frame.decals = FNL_DECALS_GBUFFER;
    fnl_image first = test_render(scene, &frame, FNL_OUTPUT_COLOR), second = test_render(scene, &frame, FNL_OUTPUT_COLOR);
    assert_true(test_difference(&lists, &first) <= 2); /* the base colour was rounded once more */
    assert_true(test_equal(&first, &second));
    free_picture(&lists);
    free_picture(&first);
    free_picture(&second);
    fnl_scene_destroy(&scene);

    scene = wall_scene();
    scene_add_light(scene, &light, SCENE_NONE);
    frame.decals = FNL_DECALS_OFF;
    frame.debug = FNL_DEBUG_GBUFFER_0;
    fnl_image albedo = test_render(scene, &frame, FNL_OUTPUT_COLOR);
    frame.debug = FNL_DEBUG_NONE;
    fnl_image lit = test_render(scene, &frame, FNL_OUTPUT_COLOR);
    fnl_decal_params p = plain(1, 0, 0, 1, box);
    p.channels = FNL_DECAL_NORMAL;
    p.normal_image = add_picture(scene, 32, 32, false, bump_texel);
    add(scene, &p);
    for (int way = FNL_DECALS_LISTS; way <= FNL_DECALS_GBUFFER; way++) {
        frame.decals = (fnl_decals)way;
        frame.debug = FNL_DEBUG_GBUFFER_0;
        fnl_image same = test_render(scene, &frame, FNL_OUTPUT_COLOR);
        assert_true(test_equal(&albedo, &same));
        frame.debug = FNL_DEBUG_NONE;
        fnl_image bumped = test_render(scene, &frame, FNL_OUTPUT_COLOR);
        assert_true(test_difference(&lit, &bumped) > 10);
        free_picture(&same);
        free_picture(&bumped);
    }
    free_picture(&albedo);
    free_picture(&lit);
    fnl_scene_destroy(&scene);
}

/* Red, with a green that only coarse mips show. */
/* Each channel by itself, emission too, comes out alike both ways. */
static void test_both_ways_change_all_channels_ES_34(void **state) {
    (void)state;
    static const uint32_t channels[] = {FNL_DECAL_COLOR, FNL_DECAL_NORMAL, FNL_DECAL_ROUGHNESS, FNL_DECAL_METALLIC,
                                        FNL_DECAL_EMISSION};
    for (uint32_t i = 0; i < COUNT_OF(channels); i++) {
        fnl_scene *scene = wall_scene();
        fnl_light_params light = test_point((vec3){0.6f, 0.4f, 0.9f}, 4, 6);
        scene_add_light(scene, &light, SCENE_NONE);
        fnl_decal_params p = plain(0.9f, 0.3f, 0.2f, 0.75f, box_at((vec3){0, 0, 0}, quat_identity(), (vec3){1, 1, 0.2f}));
        p.channels = channels[i];
        p.roughness = 0.4f;
        p.metallic = 0.8f;
        p.emissive[1] = 0.7f;
        p.normal_image = add_picture(scene, 32, 32, false, bump_texel);
        add(scene, &p);
        fnl_image seen[3];
        for (int way = FNL_DECALS_LISTS; way < FNL_DECALS_COUNT; way++) {
            fnl_frame frame = frame_with(FNL_SHADING_DEFERRED, (fnl_decals)way, FNL_OUTPUT_RADIANCE);
            seen[way] = test_render(scene, &frame, FNL_OUTPUT_RADIANCE);
        }
        double off = 0, changed = 0;
        for (uint32_t k = 0; k < SIDE * SIDE; k++)
            for (int c = 0; c < 3; c++) {
                double lists = (double)test_pixel(&seen[FNL_DECALS_LISTS], k % SIDE, k / SIDE)[c];
                double gbuffer = (double)test_pixel(&seen[FNL_DECALS_GBUFFER], k % SIDE, k / SIDE)[c];
                off = fmax(off, fabs(lists - gbuffer) / (lists + 0.1));
                changed = fmax(changed, fabs(lists - (double)test_pixel(&seen[FNL_DECALS_OFF], k % SIDE, k / SIDE)[c]) /
                                            (lists + 0.1));
            }
        print_message("  channel %u: %.4f off, %.3f changed\n", channels[i], off, changed);
        assert_true(off < 0.04 && changed > 0.05);
        for (int k = 0; k < 3; k++) free_picture(&seen[k]);
        fnl_scene_destroy(&scene);
    }
}

static void fine_texel(uint32_t x, uint32_t y, uint8_t out[4]) {
    bool green = (x + y) % 2;
    out[0] = green ? 0 : 255;
    out[1] = green ? 255 : 0;
    out[2] = 0;
    out[3] = 255;
}

static void dark_clear_texel(uint32_t x, uint32_t y, uint8_t out[4]) {
    bool solid = (x / 8 + y / 8) % 2;
    memset(out, solid ? 0 : 255, 3); /* black, but white where it is clear */
    out[3] = solid ? 255 : 0;
}

static void field_texel(uint32_t x, uint32_t y, uint8_t out[4]) {
    double d = hypot(x - 31.5, y - 31.5) / 32;
    memset(out, 0, 3);
    out[0] = 255;
    out[3] = (uint8_t)fmin(fmax(255 * (1 - 0.75 * d), 0), 255);
}

/* (a) a pole before a wall with a picture: without the fix the pole's outline is drawn from small mips; (b) black on black stays black;
   (c) a cut has an edge of about a pixel. */
static void test_faults_have_their_cures_ES_35(void **state) {
    (void)state;
    fnl_scene *scene = wall_scene();
    uint32_t quad = test_quad_mesh(scene, add_grey(scene));
    test_place(scene, quad, (vec3){0, 0, 0.6f}, (vec3){0.08f, 1, 1});
    scene_update_transforms(scene);
    fnl_decal_params p = plain(1, 1, 1, 1, box_at((vec3){0, 0, 0.3f}, quat_identity(), (vec3){2, 2, 1}));
    p.color_image = add_picture(scene, 16, 16, true, fine_texel);
    add(scene, &p);
    fnl_frame frame = frame_with(FNL_SHADING_DEFERRED, FNL_DECALS_LISTS, FNL_OUTPUT_COLOR);
    frame.camera = eye_camera((vec3){0.3f, 0, 2.2f}, (vec3){0, 0, 0}, 0.8f);
    frame.width = frame.height = 128;
    fnl_image lists = test_render(scene, &frame, FNL_OUTPUT_COLOR);
    uint32_t rings[2];
    for (int fix = 0; fix < 2; fix++) {
        frame.decals = FNL_DECALS_GBUFFER;
        frame.decal_mip_fix = fix;
        fnl_image seen = test_render(scene, &frame, FNL_OUTPUT_COLOR);
        rings[fix] = 0;
        for (uint32_t i = 0; i < 128 * 128; i++) {
            const uint8_t *a = test_pixel8(&lists, i % 128, i / 128), *b = test_pixel8(&seen, i % 128, i / 128);
            rings[fix] += abs(a[0] - b[0]) > 4 || abs(a[1] - b[1]) > 4;
        }
        free_picture(&seen);
    }
    assert_true(rings[0] > 60); /* the outline of the pole */
    assert_int_equal(rings[1], 0);
    free_picture(&lists);
    fnl_scene_destroy(&scene);

    scene = test_scene();
    struct scene_material black = grey_material();
    black.base_color = (vec4){0, 0, 0, 1};
    test_place(scene, test_quad_mesh(scene, scene_add_material(scene, &black)), (vec3){0, 0, 0}, (vec3){1, 1, 1});
    scene_update_transforms(scene);
    p = plain(1, 1, 1, 1, box_at((vec3){0, 0, 0}, quat_axis_angle((vec3){0, 0, 1}, 0.3f), (vec3){1.3f, 1.3f, 1}));
    p.color_image = add_picture(scene, 64, 64, true, dark_clear_texel);
    add(scene, &p);
    frame = test_frame(FNL_OUTPUT_SURFACE);
    fnl_image surface = test_render(scene, &frame, FNL_OUTPUT_SURFACE);
    for (uint32_t i = 0; i < SIDE * SIDE; i++) assert_pixel(&surface, i % SIDE, i / SIDE, 0, 0, 0, 0);
    free_picture(&surface);
    fnl_scene_destroy(&scene);

    scene = wall_scene();
    p = plain(1, 1, 1, 1, box_at((vec3){0, 0, 0}, quat_identity(), (vec3){1.9f, 1.9f, 1}));
    p.color_image = add_picture(scene, 64, 64, true, field_texel);
    p.distance_field = true;
    p.cut = 0.55f;
    add(scene, &p);
    frame.width = frame.height = 256; /* magnified */
    surface = test_render(scene, &frame, FNL_OUTPUT_SURFACE);
    uint32_t full = 0, none = 0, between = 0;
    for (uint32_t x = 0; x < 256; x++) {
        double red = ((double)test_pixel(&surface, x, 128)[0] - 0.5) / 0.5;
        *(red > 0.99 ? &full : red < 0.01 ? &none : &between) += 1;
    }
    assert_true(between >= 2 && between <= 8 && full > 100 && none > 60);
    double radius = 0.5 * full / 256 * 2 / 1.9 * 2; /* of the cut, in half sides: 1 - 0.75 d = 0.55 */
    assert_true(fabs(radius - 0.6) < 0.03);
    free_picture(&surface);
    frame.width = frame.height =
        SIDE; /* the cut is as soft as the distance changes from pixel to pixel: a pixel all round */
    surface = test_render(scene, &frame, FNL_OUTPUT_SURFACE);
    between = 0;
    for (uint32_t i = 0; i < SIDE * SIDE; i++) {
        double red = ((double)test_pixel(&surface, i % SIDE, i / SIDE)[0] - 0.5) / 0.5;
        between += red > 0.02 && red < 0.98;
    }
    assert_in_range(between, 60, 200);
    free_picture(&surface);
    fnl_scene_destroy(&scene);
}

/* On glass, by a blend that no fixed function knows, in front of a wall that has the decal too. */
static void test_glass_gets_decals_ES_36_and_ES_59(void **state) {
    (void)state;
    for (int blend = 0; blend < FNL_DECAL_BLEND_COUNT; blend++) {
        fnl_scene *scene = test_scene();
        struct scene_material wall = grey_material(), glass = grey_material();
        wall.base_color = (vec4){0.7f, 0.3f, 0.6f, 1};
        wall.roughness = glass.roughness = 1;
        wall.specular = glass.specular = 0;
        glass.base_color = (vec4){0.2f, 0.8f, 0.4f, 0.5f};
        glass.alpha_mode = FNL_ALPHA_BLEND;
        test_place(scene, test_quad_mesh(scene, scene_add_material(scene, &wall)), (vec3){0, 0, 0}, (vec3){1, 1, 1});
        test_place(scene, test_quad_mesh(scene, scene_add_material(scene, &glass)), (vec3){0, 0, 0.5f}, (vec3){1, 1, 1});
        scene_update_transforms(scene);
        assert_int_equal(fnl_scene_set_ambient(scene, (vec3){1, 1, 1}, (vec3){1, 1, 1}), FNL_OK);
        static const double color[3] = {0.9, 0.4, 0.1}, alpha = 0.6;
        fnl_decal_params p = plain(0.9f, 0.4f, 0.1f, 0.6f, box_at((vec3){0, 0, 0.25f}, quat_identity(), (vec3){1, 1, 1}));
        p.blend = (fnl_decal_blend)blend;
        add(scene, &p);
        for (int shading = 0; shading < FNL_SHADING_AUTO; shading++)
            for (int way = FNL_DECALS_LISTS; way <= FNL_DECALS_GBUFFER; way++) {
                fnl_frame frame = frame_with((fnl_shading)shading, (fnl_decals)way, FNL_OUTPUT_RADIANCE);
                fnl_image seen = test_render(scene, &frame, FNL_OUTPUT_RADIANCE);
                double expected[3];
                for (int k = 0; k < 3; k++) {
                    const double bases[2] = {k == 0 ? 0.7 : k == 1 ? 0.3 : 0.6, k == 0 ? 0.2 : k == 1 ? 0.8 : 0.4};
                    double under[2];
                    for (int i = 0; i < 2; i++) {
                        double b = bases[i], c = color[k];
                        double full = blend == FNL_DECAL_BLEND_MULTIPLY  ? b * c
                                      : blend == FNL_DECAL_BLEND_ADD     ? b + c
                                      : blend == FNL_DECAL_BLEND_SCREEN  ? b + c - b * c
                                      : blend == FNL_DECAL_BLEND_OVERLAY ? (b < 0.5 ? 2 * b * c : 1 - 2 * (1 - b) * (1 - c))
                                                                         : c;
                        under[i] = fmin(blend == FNL_DECAL_BLEND_ADD ? b + alpha * c : b * (1 - alpha) + full * alpha, 1);
                    }
                    expected[k] = under[0] * 0.5 + under[1] * 0.5;
                }
                assert_pixel(&seen, 32, 32, expected[0], expected[1], expected[2], 0.02);
                assert_pixel(&seen, 4, 32, 0.45, 0.55, 0.5, 0.01);
                free_picture(&seen);
            }
        fnl_scene_destroy(&scene);
    }
}

/* All orders, both ways, MSAA: the same picture, and overflowing pools change no bit. */
static void test_all_orders_agree_EQ_ES_36_ES_59(void **state) {
    (void)state;
    static char plan[1 << 17];
    fnl_scene *scene = test_load("builtin:hall?lights=64&decals=1500", false);
    fnl_frame frame = test_frame(FNL_OUTPUT_COLOR);
    assert_int_equal(fnl_scene_query_camera(scene, 2, &frame.camera), FNL_OK);
    frame.width = 96;
    frame.height = 54;
    frame.exposure = FNL_EXPOSURE_EV;
    frame.ev = 3;
    frame.tonemap = FNL_TONEMAP_KHRONOS_NEUTRAL;
    frame.lists = FNL_LISTS_CLUSTERED;
    fnl_image reference = test_render(scene, &frame, FNL_OUTPUT_COLOR);
    frame.decals = FNL_DECALS_OFF;
    fnl_image bare = test_render(scene, &frame, FNL_OUTPUT_COLOR);
    assert_true(test_difference(&reference, &bare) > 20);
    const fnl_shading shadings[4] = {FNL_SHADING_FORWARD, FNL_SHADING_FORWARD_PREPASS, FNL_SHADING_DEFERRED,
                                     FNL_SHADING_DEFERRED_VOLUMES};
    for (int shading = 0; shading < 4; shading++)
        for (int way = FNL_DECALS_LISTS; way <= FNL_DECALS_GBUFFER; way++) {
            frame.shading = shadings[shading];
            frame.decals = (fnl_decals)way;
            fnl_renderer *r = test_renderer(scene);
            test_render_frame(r, &frame);
            fnl_image full = test_read(r, FNL_OUTPUT_COLOR);
            fnl_frame_stats stats;
            assert_int_equal(fnl_renderer_query_stats(r, &stats), FNL_OK);
            assert_true(counter(&stats, "decals.total") > 1400 && counter(&stats, "decals.in-view") > 0 &&
                        counter(&stats, "decals.entries") > 0);
            assert_int_equal(counter(&stats, "decals.overflow"), 0);
            uint32_t beyond = 0;
            for (uint32_t i = 0; i < frame.width * frame.height * 4; i++)
                beyond += abs(((const uint8_t *)full.pixels)[i] - ((const uint8_t *)reference.pixels)[i]) > 2;
            assert_true(beyond <= 4); /* single texels of steep faces, whose gradients are rounded */
            r->decals.capacity = 7;
            test_render_frame(r, &frame);
            fnl_image cramped = test_read(r, FNL_OUTPUT_COLOR);
            assert_int_equal(fnl_renderer_query_stats(r, &stats), FNL_OK);
            assert_true(counter(&stats, "decals.overflow") > 0);
            assert_true(test_equal(&full, &cramped));
            assert_true(r->decals.capacity > 7);         /* for the next frame */
            for (uint32_t tree = 0; tree < 2; tree++) { /* cells that ask each box, and a tree over few: the same entries */
                uint64_t entries = counter(&stats, "decals.entries");
                r->decals.tree_from = tree ? 0 : UINT32_MAX;
                test_render_frame(r, &frame);
                fnl_image same = test_read(r, FNL_OUTPUT_COLOR);
                assert_int_equal(fnl_renderer_query_stats(r, &stats), FNL_OK);
                assert_int_equal(counter(&stats, "decals.entries"), entries);
                assert_true(test_equal(&full, &same));
                free_picture(&same);
                fnl_renderer_print(r, FNL_PRINT_PLAN, plan, sizeof plan);
                bool cells = strstr(plan, "'decals/clustered count'"), boxes = strstr(plan, "'decals/bvh count'");
                assert_true(tree ? !cells : !boxes);
                assert_true(boxes == (strstr(plan, "'decals/bvh keys'") != NULL));
                assert_true(cells || boxes || way == FNL_DECALS_GBUFFER);
                assert_null(strstr(plan, "'bvh keys'"));
            }
            free_picture(&full);
            free_picture(&cramped);
            fnl_renderer_destroy(&r);
        }
    free_picture(&reference);
    free_picture(&bare);
    fnl_scene_destroy(&scene);
}

/* A scene without decals has no pass for them, and those that are off leave no trace. */
/* Small decals that are moved to the other corner of a wall, and turned into long ones: pictures are those of a renderer that never saw them
   elsewhere, in either way. */
static void test_edited_decals_are_found_where_they_are(void **state) {
    (void)state;
    const mat4 places[3] = {box_at((vec3){-0.7f, 0.7f, 0}, quat_identity(), (vec3){0.3f, 0.3f, 0.3f}),
                            box_at((vec3){0.7f, -0.7f, 0}, quat_identity(), (vec3){0.3f, 0.3f, 0.3f}),
                            box_at((vec3){0, -0.7f, 0}, quat_identity(), (vec3){1.8f, 0.3f, 0.3f})};
    for (int way = 0; way < 2; way++) {
        fnl_scene *scene = wall_scene();
        fnl_frame frame = frame_with(FNL_SHADING_DEFERRED, way ? FNL_DECALS_GBUFFER : FNL_DECALS_LISTS, FNL_OUTPUT_RADIANCE);
        frame.width = frame.height = 96; /* of nine tiles of the list */
        frame.camera = test_front_camera();
        fnl_decal_params p = plain(1, 0, 0, 1, places[0]);
        fnl_decal_id id = add(scene, &p);
        fnl_renderer *r = test_renderer(scene);
        for (int i = 0; i < 3; i++) {
            p.transform = places[i];
            assert_int_equal(fnl_scene_set_decal(scene, id, &p), FNL_OK);
            test_render_frame(r, &frame);
            fnl_renderer *fresh = test_renderer(scene);
            test_render_frame(fresh, &frame);
            fnl_image edited = test_read(r, FNL_OUTPUT_RADIANCE), whole = test_read(fresh, FNL_OUTPUT_RADIANCE);
            uint32_t red = 0;
            for (uint32_t k = 0; k < 96 * 96; k++) {
                const float *seen = test_pixel(&whole, k % 96, k / 96);
                red += seen[1] < 0.3f * seen[0];
            }
            assert_true(red > 60);
            assert_true(test_equal(&edited, &whole));
            free_picture(&edited);
            free_picture(&whole);
            fnl_renderer_destroy(&fresh);
        }
        fnl_renderer_destroy(&r);
        fnl_scene_destroy(&scene);
    }
}

static void test_none_cost_nothing(void **state) {
    (void)state;
    static char plan[1 << 16];
    for (int way = 0; way < FNL_DECALS_COUNT; way++) {
        fnl_scene *scene = wall_scene();
        fnl_frame frame = frame_with(FNL_SHADING_DEFERRED, (fnl_decals)way, FNL_OUTPUT_RADIANCE);
        fnl_renderer *r = test_renderer(scene);
        test_render_frame(r, &frame);
        fnl_renderer_print(r, FNL_PRINT_PLAN, plan, sizeof plan);
        assert_null(strstr(plan, "decal"));
        fnl_image bare = test_read(r, FNL_OUTPUT_RADIANCE);
        fnl_decal_params p = plain(1, 0, 0, 1, box_at((vec3){0, 0, 0}, quat_identity(), (vec3){1, 1, 1}));
        fnl_decal_id id = add(scene, &p);
        test_render_frame(r, &frame);
        fnl_renderer_print(r, FNL_PRINT_PLAN, plan, sizeof plan);
        assert_true((strstr(plan, "decal") != NULL) == (way != FNL_DECALS_OFF));
        assert_int_equal(fnl_scene_remove_decal(scene, id), FNL_OK);
        test_render_frame(r, &frame);
        fnl_image after = test_read(r, FNL_OUTPUT_RADIANCE);
        assert_true(test_equal(&bare, &after));
        free_picture(&bare);
        free_picture(&after);
        fnl_renderer_destroy(&r);
        fnl_scene_destroy(&scene);
    }
}

/*
 * Over the G-buffer a decal is noted at the tiles of 8 x 8 pixels where its box meets a surface in depth, and at no others: a wall in the
 * middle of the sky, one decal on it whose tiles are known, and others before it, behind it and beside it.
 */
static void test_tiles_note_what_meets_them_ES_30(void **state) {
    (void)state;
    fnl_scene *scene = test_scene();
    test_place(scene, test_quad_mesh(scene, add_grey(scene)), (vec3){0, 0, 0}, (vec3){0.9f, 0.9f, 1});
    fnl_frame frame = frame_with(FNL_SHADING_DEFERRED, FNL_DECALS_GBUFFER, FNL_OUTPUT_COLOR);
    frame.camera.vertical_extent = 4; /* 16 pixels a metre: the wall is in tiles 2 to 5 either way, the outer ones with some sky */
    fnl_renderer *r = test_renderer(scene);
    static const struct {
        const char *name;
        vec3 at, size;
        uint32_t tiles;
    } cases[] = {
        {"on the wall", {0, 0, 0}, {1.5f, 1.5f, 0.4f}, 16},        /* pixels 20 to 43 */
        {"in a corner of it", {-0.75f, 0.75f, 0}, {0.1f, 0.1f, 0.4f}, 1}, /* the middle of a tile */
        {"before it", {0, 0, 3}, {1.5f, 1.5f, 0.1f}, 0}, /* by more than half the sum of its sides */
        {"behind it", {0, 0, -3}, {1.5f, 1.5f, 0.1f}, 0},
        {"in the sky", {1.5f, 1.5f, 0}, {0.5f, 0.5f, 0.4f}, 0},
    };
    uint32_t expected = 0;
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        fnl_decal_params p = plain(1, 0, 0, 0.5f, box_at(cases[i].at, quat_identity(), cases[i].size));
        add(scene, &p);
        expected += cases[i].tiles;
        test_render_frame(r, &frame);
        fnl_frame_stats stats;
        assert_int_equal(fnl_renderer_query_stats(r, &stats), FNL_OK);
        print_message("%s: %llu entries\n", cases[i].name, (unsigned long long)counter(&stats, "decals.entries"));
        assert_int_equal(counter(&stats, "decals.in-view"), i + 1);
        assert_int_equal(counter(&stats, "decals.entries"), expected);
    }
    fnl_renderer_destroy(&r);
    fnl_scene_destroy(&scene);
}

/* A hundred thousand, most of them in view. */
static void test_a_hundred_thousand_decals(void **state) {
    (void)state;
    fnl_scene *scene = wall_scene();
    struct random_state random = {7};
    for (int i = 0; i < 100000; i++) {
        vec3 at = {random_range(&random, -1.2f, 1.2f), random_range(&random, -1.2f, 1.2f),
                   random_range(&random, -0.4f, 0.4f)};
        fnl_decal_params p = plain(random_float(&random), random_float(&random), random_float(&random), 0.5f,
                                   box_at(at, quat_identity(), (vec3){0.02f, 0.02f, 0.3f}));
        p.sort_key = i % 5;
        add(scene, &p);
    }
    fnl_frame frame = frame_with(FNL_SHADING_DEFERRED, FNL_DECALS_LISTS, FNL_OUTPUT_COLOR);
    fnl_image pictures[2];
    for (int way = FNL_DECALS_LISTS; way <= FNL_DECALS_GBUFFER; way++) {
        frame.decals = (fnl_decals)way;
        fnl_renderer *r = test_renderer(scene);
        fnl_frame_stats stats;
        for (int i = 0; i < 2; i++) { /* pools grow */
            test_render_frame(r, &frame);
            assert_int_equal(fnl_renderer_query_stats(r, &stats), FNL_OK);
        }
        assert_int_equal(counter(&stats, "decals.total"), 100000);
        assert_true(counter(&stats, "decals.in-view") > 60000);
        assert_int_equal(counter(&stats, "decals.overflow"), 0);
        pictures[way] = test_read(r, FNL_OUTPUT_COLOR);
        fnl_renderer_destroy(&r);
    }
    assert_true(test_difference(&pictures[0], &pictures[1]) <= 2);
    free_picture(&pictures[0]);
    free_picture(&pictures[1]);
    fnl_scene_destroy(&scene);
}

/* With several samples, and in orders without a G-buffer, lists stand in: the same bytes, and the log says so once. */
static void test_lists_stand_in_for_the_gbuffer_ES_59(void **state) {
    (void)state;
    static const struct {
        fnl_shading shading;
        uint32_t msaa;
        bool stands_in;
    } cases[] = {{FNL_SHADING_DEFERRED, 1, false}, {FNL_SHADING_DEFERRED, 4, true}, {FNL_SHADING_FORWARD, 1, true}};
    fnl_scene *scene = wall_scene();
    fnl_decal_params p = plain(1, 0, 0, 1, box_at((vec3){0, 0, 0}, quat_identity(), (vec3){0.9f, 0.7f, 0.5f}));
    add(scene, &p);
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        fnl_renderer *r = test_renderer(scene);
        fnl_image pictures[2];
        for (int way = FNL_DECALS_LISTS; way <= FNL_DECALS_GBUFFER; way++) {
            fnl_frame frame = frame_with(cases[i].shading, (fnl_decals)way, FNL_OUTPUT_RADIANCE);
            frame.msaa = cases[i].msaa;
            test_render_frame(r, &frame);
            pictures[way] = test_read(r, FNL_OUTPUT_RADIANCE);
            assert_int_equal(r->notes.decal_lists, way == FNL_DECALS_GBUFFER && cases[i].stands_in);
        }
        if (cases[i].stands_in) assert_true(test_equal(&pictures[0], &pictures[1]));
        for (int k = 0; k < 2; k++) free_picture(&pictures[k]);
        fnl_renderer_destroy(&r);
    }
    fnl_scene_destroy(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_tiles_note_what_meets_them_ES_30),
        cmocka_unit_test(test_boxes_hold_what_the_CPU_says_ES_30),
        cmocka_unit_test(test_volume_decals_show_the_slice_ES_31),
        cmocka_unit_test(test_characters_stay_clean_ES_32),
        cmocka_unit_test(test_steep_sides_fade_ES_33),
        cmocka_unit_test(test_layers_keep_their_order_ES_34),
        cmocka_unit_test(test_both_ways_change_all_channels_ES_34),
        cmocka_unit_test(test_faults_have_their_cures_ES_35),
        cmocka_unit_test(test_glass_gets_decals_ES_36_and_ES_59),
        cmocka_unit_test(test_all_orders_agree_EQ_ES_36_ES_59),
        cmocka_unit_test(test_lists_stand_in_for_the_gbuffer_ES_59),
        cmocka_unit_test(test_edited_decals_are_found_where_they_are),
        cmocka_unit_test(test_none_cost_nothing),
        cmocka_unit_test(test_a_hundred_thousand_decals),
    };
    return cmocka_run_group_tests(tests, test_group_begin, test_group_end);
}
