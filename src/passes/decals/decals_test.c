/* SPDX-License-Identifier: MIT */
/** Decals of all kinds against what the CPU makes of the positions that the GPU shows, and both ways of applying them. */
#include "render/render_test.h"

enum { SIDE = 64 };

/* ---- scenes ---- */

static struct scene_material grey_material(void) {
    struct scene_material m = scene_material_default();
    m.name = "";
    m.base_color = (vec4){0.5f, 0.5f, 0.5f, 1};
    m.metallic = 0;
    return m;
}

static uint32_t add_grey(fnl_scene *scene) {
    struct scene_material m = grey_material();
    return scene_add_material(scene, &m);
}

/* A grey wall from -1 to 1 in light from all around. */
static fnl_scene *wall_scene(void) {
    fnl_scene *scene = test_scene();
    test_place(scene, test_quad_mesh(scene, add_grey(scene)), (vec3){0, 0, 0}, (vec3){1, 1, 1});
    assert_int_equal(fnl_scene_set_ambient(scene, (vec3){1, 1, 1}, (vec3){1, 1, 1}), FNL_OK);
    scene_update_transforms(scene);
    return scene;
}

static mat4 box_at(vec3 position, quat rotation, vec3 size) { return mat4_from_trs(position, rotation, size); }

static fnl_decal_params plain(float r, float g, float b, float alpha, mat4 transform) {
    fnl_decal_params p = fnl_decal_params_default();
    p.transform = transform;
    p.color[0] = r;
    p.color[1] = g;
    p.color[2] = b;
    p.color[3] = alpha;
    p.channels = FNL_DECAL_COLOR;
    return p;
}

static fnl_decal_id add(fnl_scene *scene, const fnl_decal_params *p) {
    fnl_decal_id id;
    assert_int_equal(fnl_scene_add_decal(scene, p, &id), FNL_OK);
    return id;
}

/* An RGBA8 picture from a function of the texel. */
static fnl_image_id add_picture(fnl_scene *scene, uint32_t width, uint32_t height, bool color,
                                void (*texel)(uint32_t x, uint32_t y, uint8_t out[4])) {
    uint8_t *pixels = malloc((size_t)width * height * 4);
    for (uint32_t i = 0; i < width * height; i++) texel(i % width, i / width, pixels + (size_t)i * 4);
    fnl_image image = {.width = width, .height = height, .format = FNL_PIXEL_FORMAT_RGBA8, .pixels = pixels};
    fnl_image_id id;
    assert_int_equal(fnl_scene_add_image(scene, &image, color, &id), FNL_OK);
    free(pixels);
    return id;
}

static fnl_frame frame_with(fnl_shading shading, fnl_decals decals, uint32_t outputs) {
    fnl_frame frame = test_frame(outputs);
    frame.shading = shading;
    frame.decals = decals;
    return frame;
}

static fnl_camera eye_camera(vec3 eye, vec3 target, float fov) {
    fnl_camera camera = fnl_camera_default();
    camera.position = eye;
    camera.target = target;
    camera.vertical_fov = fov;
    return camera;
}

static bool holds(const mat4 *inverse, const float *position, double *nearest) {
    double far = 0;
    for (int r = 0; r < 3; r++) {
        double q = inverse->m[12 + r];
        for (int c = 0; c < 3; c++) q += (double)inverse->m[c * 4 + r] * (double)position[c];
        far = fmax(far, fabs(q));
    }
    *nearest = fabs(far - 0.5);
    return far <= 0.5;
}

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
            scene->structure_version++;
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

/* A strip of two quads on two joints. Its decal is at its middle before it deforms. */
static fnl_scene *strip_scene(uint32_t *out_node, uint32_t joints[2]) {
    fnl_scene *scene = test_scene();
    static const vec3 positions[6] = {{-1, -0.5f, 0}, {0, -0.5f, 0}, {1, -0.5f, 0},
                                      {-1, 0.5f, 0},  {0, 0.5f, 0},  {1, 0.5f, 0}};
    static const uint32_t indices[12] = {0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4};
    static const uint16_t influences[24] = {0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0};
    static const float weights[24] = {1, 0, 0, 0, 0.5f, 0.5f, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0.5f, 0.5f, 0, 0, 1, 0, 0, 0};
    struct scene_primitive strip = {.material = add_grey(scene),
                                    .vertex_count = 6,
                                    .index_count = 12,
                                    .indices = indices,
                                    .positions = positions,
                                    .joints = influences,
                                    .weights = weights,
                                    .joint_count = 4};
    assert_int_equal(mesh_complete(&scene->arena, &strip), FNL_OK);
    uint32_t mesh = scene_add_mesh(scene, "", &strip, 1);
    mat4 identity = mat4_identity();
    *out_node = scene_add_node(scene, "", SCENE_NONE, &identity, mesh);
    uint32_t *list = ARENA_ARRAY(&scene->arena, uint32_t, 2);
    mat4 *inverse_bind = ARENA_ARRAY(&scene->arena, mat4, 2);
    for (int i = 0; i < 2; i++) {
        list[i] = joints[i] = scene_add_node(scene, "", SCENE_NONE, &identity, SCENE_NONE);
        inverse_bind[i] = identity;
    }
    struct scene_skin skin = {.name = "", .joints = list, .inverse_bind = inverse_bind, .joint_count = 2};
    assert_true(array_push(&scene->host, &scene->skins, skin));
    scene->nodes.data[*out_node].skin = 0;
    scene_update_transforms(scene);
    return scene;
}

/* One joint goes aside: the strip stretches, and the decal stays on the same vertices, as wide again. */
static void test_mesh_decals_do_not_slide_ES_27(void **state) {
    (void)state;
    uint32_t node, joints[2];
    fnl_scene *scene = strip_scene(&node, joints);
    fnl_decal_params p = plain(1, 0, 0, 1, box_at((vec3){0.5f, 0, 0}, quat_identity(), (vec3){0.5f, 0.4f, 0.2f}));
    p.kind = FNL_DECAL_MESH;
    p.instance = (fnl_instance_id){node, scene->nodes.data[node].generation};
    add(scene, &p);
    fnl_renderer *r = test_renderer(scene);
    for (int step = 0; step < 4; step++)
        for (int way = 0; way < 3; way++) {
            float moved = 0.3f * (float)step;
            mat4 aside = mat4_translation((vec3){moved, 0.1f * (float)step, 0});
            scene_move_node(scene, joints[1], &aside);
            fnl_frame frame =
                frame_with(way ? FNL_SHADING_DEFERRED : FNL_SHADING_FORWARD,
                           way == 2 ? FNL_DECALS_GBUFFER : FNL_DECALS_LISTS, FNL_OUTPUT_SURFACE | FNL_OUTPUT_POSITION);
            frame.camera.vertical_extent = 4;
            test_render_frame(r, &frame);
            fnl_image surface = test_read(r, FNL_OUTPUT_SURFACE), position = test_read(r, FNL_OUTPUT_POSITION);
            uint32_t red = 0;
            for (uint32_t i = 0; i < SIDE * SIDE; i++) {
                const float *at = test_pixel(&position, i % SIDE, i / SIDE),
                            *seen = test_pixel(&surface, i % SIDE, i / SIDE);
                if (at[3] == 0 || at[0] < 0.51f * moved) continue; /* the right half: from moved / 2 to 1 + moved */
                double u =
                    ((double)at[0] - (double)moved / 2) / (1 + (double)moved / 2); /* 0 .. 1 before it was stretched */
                double v = (double)at[1] - 0.1 * step * (0.5 + 0.5 * u), far = fmax(fabs(u - 0.5) / 0.25, fabs(v) / 0.2);
                if (fabs(far - 1) < 1e-3) continue;
                bool is_red = seen[1] < 0.1f;
                if (is_red != (far < 1)) fail_msg("step %d, way %d, pixel %u", step, way, i);
                red += is_red;
            }
            assert_true(red > 40);
            free_picture(&surface);
            free_picture(&position);
        }
    fnl_renderer_destroy(&r);
    fnl_scene_destroy(&scene);
}

static fnl_instance_id instance_of(const fnl_scene *scene, uint32_t node) {
    return (fnl_instance_id){node, scene->nodes.data[node].generation};
}

/* A decal with the default fade lies on the front of its instance, which may be mirrored. */
static void test_mirrored_instances_ES_27_ES_28(void **state) {
    (void)state;
    for (uint32_t i = 0; i < 4; i++) {
        fnl_scene *scene = test_scene();
        uint32_t node =
            test_place(scene, test_quad_mesh(scene, add_grey(scene)), (vec3){0, 0, 0}, (vec3){i % 2 ? -1 : 1, 1, 1});
        assert_int_equal(fnl_scene_set_ambient(scene, (vec3){1, 1, 1}, (vec3){1, 1, 1}), FNL_OK);
        scene_update_transforms(scene);
        fnl_decal_params p = plain(1, 0, 0, 1, box_at((vec3){0, 0, 0}, quat_identity(), (vec3){1, 1, 0.2f}));
        p.kind = i / 2 ? FNL_DECAL_REDRAW : FNL_DECAL_MESH;
        p.instance = instance_of(scene, node);
        add(scene, &p);
        fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
        fnl_image radiance = test_render(scene, &frame, FNL_OUTPUT_RADIANCE);
        const float *seen = test_pixel(&radiance, SIDE / 2, SIDE / 2);
        if (seen[0] < 10 * seen[1]) fail_msg("case %u: %g %g %g", i, (double)seen[0], (double)seen[1], (double)seen[2]);
        free_picture(&radiance);
        fnl_scene_destroy(&scene);
    }
}

/* A patch on a sphere: few triangles are drawn again, each pixel of the patch shows it, with MSAA too, and the rest keeps its bits. */
static void test_redrawn_triangles_ES_28(void **state) {
    (void)state;
    fnl_scene *scene = test_scene();
    uint32_t node =
        test_place(scene, test_sphere_mesh(scene, add_grey(scene), 24), (vec3){0, 0, 0}, (vec3){0.9f, 0.9f, 0.9f});
    scene_update_transforms(scene);
    assert_int_equal(fnl_scene_set_ambient(scene, (vec3){1, 1, 1}, (vec3){1, 1, 1}), FNL_OK);
    fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE | FNL_OUTPUT_POSITION);
    mat4 box = box_at((vec3){0.3f, 0.2f, 0.9f}, quat_identity(), (vec3){0.5f, 0.4f, 0.6f}), inverse;
    assert_true(mat4_inverse(&box, &inverse));
    static const struct {
        fnl_shading shading;
        uint32_t msaa;
    } cases[3] = {{FNL_SHADING_FORWARD, 1}, {FNL_SHADING_DEFERRED, 1}, {FNL_SHADING_FORWARD, 4}};
    fnl_image bare[3];
    for (int i = 0; i < 3; i++) {
        frame.shading = cases[i].shading;
        frame.msaa = cases[i].msaa;
        bare[i] = test_render(scene, &frame, FNL_OUTPUT_RADIANCE);
    }
    fnl_decal_params p = plain(1, 0, 0, 1, box);
    p.kind = FNL_DECAL_REDRAW;
    p.instance = instance_of(scene, node);
    p.fade_start = p.fade_end = PI;
    add(scene, &p);
    for (int i = 0; i < 3; i++) {
        frame.shading = cases[i].shading;
        frame.msaa = cases[i].msaa;
        fnl_renderer *r = test_renderer(scene);
        test_render_frame(r, &frame);
        uint64_t indices = r->device_scene.decals.redraw_indices.size / 4;
        assert_true(indices > 0 && indices < scene->primitives.data[0].index_count / 8);
        fnl_image seen = test_read(r, FNL_OUTPUT_RADIANCE), position = test_read(r, FNL_OUTPUT_POSITION);
        uint32_t red = 0;
        for (uint32_t k = 0; k < SIDE * SIDE; k++) {
            const float *at = test_pixel(&position, k % SIDE, k / SIDE), *c = test_pixel(&seen, k % SIDE, k / SIDE),
                        *b = test_pixel(&bare[i], k % SIDE, k / SIDE);
            float local[3] = {at[0] / 0.9f, at[1] / 0.9f, at[2] / 0.9f};
            double nearest = 0;
            bool inside = at[3] > 0 && holds(&inverse, local, &nearest);
            if (at[3] == 0 || nearest < (cases[i].msaa > 1 ? 0.1 : 1e-4)) continue;
            if (inside ? !(c[1] < 0.2f * c[0]) : memcmp(b, c, 12) != 0)
                fail_msg("case %d, pixel %u: %g %g %g, inside %d", i, k, (double)c[0], (double)c[1], (double)c[2], inside);
            red += inside;
        }
        assert_true(red > 60);
        free_picture(&seen);
        free_picture(&position);
        free_picture(&bare[i]);
        fnl_renderer_destroy(&r);
    }
    fnl_scene_destroy(&scene);
}

static void white_texel(uint32_t x, uint32_t y, uint8_t out[4]) {
    (void)x;
    (void)y;
    memset(out, 255, 4);
}

static uint32_t pass_count(fnl_renderer *r) {
    static char plan[1 << 16];
    fnl_renderer_print_plan(r, plan, sizeof plan);
    uint32_t lines = 0;
    for (const char *c = plan; *c; c++) lines += *c == '\n';
    return lines;
}

/* Two walls share mesh, material and picture; one is painted on. The frame's plan stays as it was, and taking it off restores the bits. */
static void test_baked_decals_cost_nothing_ES_29(void **state) {
    (void)state;
    fnl_scene *scene = test_scene();
    fnl_material_params m = fnl_material_params_default();
    m.metallic = 0;
    m.base_color_image = add_picture(scene, 64, 64, true, white_texel);
    uint32_t mesh = test_quad_mesh(scene, test_material(scene, &m).index);
    uint32_t left = test_place(scene, mesh, (vec3){-0.5f, 0, 0}, (vec3){0.45f, 0.9f, 1});
    test_place(scene, mesh, (vec3){0.5f, 0, 0}, (vec3){0.45f, 0.9f, 1});
    scene_update_transforms(scene);
    fnl_renderer *r = test_renderer(scene);
    fnl_frame frame = test_frame(FNL_OUTPUT_SURFACE);
    test_render_frame(r, &frame);
    uint32_t passes = pass_count(r);
    fnl_image before = test_read(r, FNL_OUTPUT_SURFACE);
    fnl_decal_params p = plain(1, 0, 0, 1, box_at((vec3){0, 0, 0}, quat_identity(), (vec3){1, 1, 0.2f}));
    p.kind = FNL_DECAL_BAKED;
    p.instance = instance_of(scene, left);
    fnl_decal_id id = add(scene, &p);
    test_render_frame(r, &frame);
    assert_int_equal(pass_count(r), passes);
    fnl_image painted = test_read(r, FNL_OUTPUT_SURFACE);
    assert_pixel(&painted, 16, 32, 1, 0, 0, 0.01); /* the middle of the left wall */
    assert_pixel(&painted, 5, 32, 1, 1, 1, 0.01);
    for (uint32_t i = 0; i < SIDE * SIDE; i++)
        if (i % SIDE >= SIDE / 2)
            assert_memory_equal(test_pixel(&before, i % SIDE, i / SIDE), test_pixel(&painted, i % SIDE, i / SIDE), 16);
    assert_int_equal(fnl_scene_remove_decal(scene, id), FNL_OK);
    test_render_frame(r, &frame);
    fnl_image after = test_read(r, FNL_OUTPUT_SURFACE);
    assert_true(test_equal(&before, &after));
    free_picture(&before);
    free_picture(&painted);
    free_picture(&after);
    fnl_renderer_destroy(&r);
    fnl_scene_destroy(&scene);
}

static void tilted_texel(uint32_t x, uint32_t y, uint8_t out[4]) {
    (void)x, (void)y;
    const uint8_t tilted[4] = {176, 104, 220, 255};
    memcpy(out, tilted, 4);
}

static void tilted_back_texel(uint32_t x, uint32_t y, uint8_t out[4]) {
    (void)x, (void)y;
    const uint8_t tilted[4] = {100, 140, 240, 255};
    memcpy(out, tilted, 4);
}

/* Each channel, and all of them, upon materials with and without textures of their own, flattened or not, mirrored, fading: what is
   baked looks like the decal on the mesh. Materials whose factors are less than what is painted keep what is beside it. */
static void test_baked_channels_ES_29(void **state) {
    (void)state;
    static const uint32_t channels[] = {FNL_DECAL_COLOR,    FNL_DECAL_NORMAL,   FNL_DECAL_ROUGHNESS,
                                        FNL_DECAL_METALLIC, FNL_DECAL_EMISSION, FNL_DECAL_ALL};
    for (uint32_t textured = 0; textured < 2; textured++)
        for (uint32_t i = 0; i < 2 * COUNT_OF(channels); i++) {
            fnl_scene *scene = test_scene();
            fnl_material_params m = fnl_material_params_default();
            m.metallic = 0.2f;
            m.roughness = textured ? 0.8f : 0.4f;
            m.emissive[0] = 0.1f;
            m.normal_scale = 0.8f;
            if (textured) {
                m.normal_image = add_picture(scene, 128, 128, false, tilted_back_texel);
                m.metallic_roughness_image = add_picture(scene, 128, 128, false, tilted_back_texel);
                m.emissive_image = add_picture(scene, 128, 128, true, tilted_texel);
            }
            uint32_t node =
                test_place(scene, test_quad_mesh(scene, test_material(scene, &m).index), (vec3){0, 0, 0}, (vec3){1, 1, 1});
            fnl_light_params light = test_point((vec3){0.6f, 0.4f, 0.9f}, 4, 6);
            scene_add_light(scene, &light, SCENE_NONE);
            assert_int_equal(fnl_scene_set_ambient(scene, (vec3){0.3f, 0.3f, 0.4f}, (vec3){0.1f, 0.1f, 0.1f}), FNL_OK);
            scene_update_transforms(scene);
            fnl_decal_params p = plain(0.9f, 0.3f, 0.2f, 0.75f,
                                       box_at((vec3){0, 0, 0}, quat_axis_angle((vec3){0, 0, 1}, 0.6f), (vec3){1, 1, 0.2f}));
            p.channels = channels[i / 2];
            if (textured && i % 2) /* seen from the side, so that it fades */
                p.transform = box_at((vec3){0, 0, 0}, quat_axis_angle((vec3){0, 1, 0}, 1.25f), (vec3){0.6f, 1, 0.95f});
            else if (textured) /* mirrored */
                p.transform = box_at((vec3){0, 0, 0}, quat_axis_angle((vec3){0, 0, 1}, 0.6f), (vec3){-1, 1, 0.2f});
            p.flatten = i % 2 == 1;
            p.roughness = 0.9f;
            p.metallic = 0.8f;
            p.normal_image = add_picture(scene, 8, 8, false, tilted_texel);
            p.emissive[0] = 0.05f;
            p.emissive[1] = 0.7f;
            p.instance = instance_of(scene, node);
            fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
            fnl_image seen[4];
            fnl_renderer *r = test_renderer(scene);
            for (int k = 0; k < 4; k++) { /* bare, on the mesh, baked, taken off again */
                fnl_decal_id id = {0};
                p.kind = k == 1 ? FNL_DECAL_MESH : FNL_DECAL_BAKED;
                if (k == 1 || k == 2) id = add(scene, &p);
                test_render_frame(r, &frame);
                seen[k] = test_read(r, FNL_OUTPUT_RADIANCE);
                if (id.generation) assert_int_equal(fnl_scene_remove_decal(scene, id), FNL_OK);
            }
            double off = 0, changed = 0, beside = 0;
            for (uint32_t y = 0; y < SIDE; y++)
                for (uint32_t x = 0; x < SIDE; x++)
                    for (int c = 0; c < 3; c++) {
                        double bare = (double)test_pixel(&seen[0], x, y)[c], mesh = (double)test_pixel(&seen[1], x, y)[c],
                               baked = (double)test_pixel(&seen[2], x, y)[c];
                        bool inside = hypot((double)x - 31.5, (double)y - 31.5) < 10;
                        bool outside = hypot((double)x - 31.5, (double)y - 31.5) > 26;
                        if (inside) off = fmax(off, fabs(mesh - baked) / (mesh + 0.05));
                        if (inside) changed = fmax(changed, fabs(mesh - bare) / (bare + 0.05));
                        if (outside) beside = fmax(beside, fabs(baked - bare) / (bare + 0.05));
                    }
            print_message("  channels %u, flatten %d, textured %u: %.4f off, %.3f changed, %.4f beside\n", p.channels,
                          p.flatten, textured, off, changed, beside);
            double most = p.channels & FNL_DECAL_NORMAL ? 0.06 : 0.02; /* eight bits have no level direction: 1/510 off */
            assert_true(off < most && changed > 0.03 && beside < most);
            assert_true(test_equal(&seen[0], &seen[3]));
            for (int k = 0; k < 4; k++) free_picture(&seen[k]);
            fnl_renderer_destroy(&r);
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
            assert_true(stats.decals_total > 1400 && stats.decals_in_view > 0 && stats.decal_entries > 0);
            assert_int_equal(stats.decal_overflow, 0);
            uint32_t beyond = 0;
            for (uint32_t i = 0; i < frame.width * frame.height * 4; i++)
                beyond += abs(((const uint8_t *)full.pixels)[i] - ((const uint8_t *)reference.pixels)[i]) > 2;
            assert_true(beyond <= 4); /* single texels of steep faces, whose gradients are rounded */
            r->decal_capacity = 7;
            test_render_frame(r, &frame);
            fnl_image cramped = test_read(r, FNL_OUTPUT_COLOR);
            assert_int_equal(fnl_renderer_query_stats(r, &stats), FNL_OK);
            assert_true(stats.decal_overflow > 0);
            assert_true(test_equal(&full, &cramped));
            assert_true(r->decal_capacity > 7);         /* for the next frame */
            for (uint32_t tree = 0; tree < 2; tree++) { /* cells that ask each box, and a tree over few: the same entries */
                uint64_t entries = stats.decal_entries;
                r->decal_tree = tree ? 0 : UINT32_MAX;
                test_render_frame(r, &frame);
                fnl_image same = test_read(r, FNL_OUTPUT_COLOR);
                assert_int_equal(fnl_renderer_query_stats(r, &stats), FNL_OK);
                assert_int_equal(stats.decal_entries, entries);
                assert_true(test_equal(&full, &same));
                free_picture(&same);
                fnl_renderer_print_plan(r, plan, sizeof plan);
                assert_true((strstr(plan, "decal bvh keys") != NULL) == (tree == 1 && strstr(plan, "decal cells count")));
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
static void test_none_cost_nothing(void **state) {
    (void)state;
    static char plan[1 << 16];
    for (int way = 0; way < FNL_DECALS_COUNT; way++) {
        fnl_scene *scene = wall_scene();
        fnl_frame frame = frame_with(FNL_SHADING_DEFERRED, (fnl_decals)way, FNL_OUTPUT_RADIANCE);
        fnl_renderer *r = test_renderer(scene);
        test_render_frame(r, &frame);
        fnl_renderer_print_plan(r, plan, sizeof plan);
        assert_null(strstr(plan, "decal"));
        fnl_image bare = test_read(r, FNL_OUTPUT_RADIANCE);
        fnl_decal_params p = plain(1, 0, 0, 1, box_at((vec3){0, 0, 0}, quat_identity(), (vec3){1, 1, 1}));
        fnl_decal_id id = add(scene, &p);
        test_render_frame(r, &frame);
        fnl_renderer_print_plan(r, plan, sizeof plan);
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
        assert_int_equal(stats.decals_total, 100000);
        assert_true(stats.decals_in_view > 60000);
        assert_int_equal(stats.decal_overflow, 0);
        pictures[way] = test_read(r, FNL_OUTPUT_COLOR);
        fnl_renderer_destroy(&r);
    }
    assert_true(test_difference(&pictures[0], &pictures[1]) <= 2);
    free_picture(&pictures[0]);
    free_picture(&pictures[1]);
    fnl_scene_destroy(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_boxes_hold_what_the_CPU_says_ES_30),
        cmocka_unit_test(test_volume_decals_show_the_slice_ES_31),
        cmocka_unit_test(test_characters_stay_clean_ES_32),
        cmocka_unit_test(test_steep_sides_fade_ES_33),
        cmocka_unit_test(test_layers_keep_their_order_ES_34),
        cmocka_unit_test(test_both_ways_change_all_channels_ES_34),
        cmocka_unit_test(test_faults_have_their_cures_ES_35),
        cmocka_unit_test(test_glass_gets_decals_ES_36_and_ES_59),
        cmocka_unit_test(test_mesh_decals_do_not_slide_ES_27),
        cmocka_unit_test(test_mirrored_instances_ES_27_ES_28),
        cmocka_unit_test(test_redrawn_triangles_ES_28),
        cmocka_unit_test(test_baked_decals_cost_nothing_ES_29),
        cmocka_unit_test(test_baked_channels_ES_29),
        cmocka_unit_test(test_all_orders_agree_EQ_ES_36_ES_59),
        cmocka_unit_test(test_none_cost_nothing),
        cmocka_unit_test(test_a_hundred_thousand_decals),
    };
    return cmocka_run_group_tests(tests, test_group_begin, test_group_end);
}
