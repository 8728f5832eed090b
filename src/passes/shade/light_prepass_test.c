/* SPDX-License-Identifier: MIT */
/** Light apart from materials, at full and at lower resolution, against deferred shading. */
#include "tests/msaa_cases.h"
#include "tests/order_cases.h"
#include "scene/scene.h"

/* ---- full resolution ---- */

/* Either buffer gives the picture of deferred shading, with the very same evaluations. */
static void check_equal(struct stage *stage, const char *what) {
    struct shot deferred = order_shoot(stage, FNL_SHADING_DEFERRED, FNL_LISTS_ALL);
    for (int b = FNL_LIGHT_BUFFER_TWO; b <= FNL_LIGHT_BUFFER_FOUR; b++) {
        stage->frame.light_buffer.kind = (fnl_light_buffer)b;
        struct shot shot = order_shoot(stage, FNL_SHADING_LIGHT_PREPASS, FNL_LISTS_ALL);
        int difference = greatest_difference(&deferred.color, &shot.color);
        print_message("  %s, %s: %d/255\n", what, fnl_value_name(FNL_ENUM_LIGHT_BUFFER, (fnl_light_buffer)b), difference);
        assert_int_equal(count_broken(&shot.radiance), 0);
        assert_true(difference <= 2);
        assert_int_equal(shot.stats.evaluations_useful, deferred.stats.evaluations_useful);
        assert_int_equal(shot.stats.evaluations, deferred.stats.evaluations);
        uint64_t pixels = (uint64_t)stage->frame.width * stage->frame.height;
        assert_int_equal(counter(&shot.stats, "light-buffer.bytes"),
                         pixels * (b == FNL_LIGHT_BUFFER_TWO ? 16 + 32 : 12 + 64)); /* sums of 32-bit floats */
        stage->frame.gbuffer.prepass = true;
        struct shot again = order_shoot(stage, FNL_SHADING_LIGHT_PREPASS, FNL_LISTS_TILED);
        assert_int_equal(count_differing(&shot.radiance, &again.radiance), 0);
        assert_true(again.stats.evaluations <= shot.stats.evaluations);
        stage->frame.gbuffer.prepass = false;
        shot_free(&shot);
        shot_free(&again);
    }
    stage->frame.light_buffer.kind = FNL_LIGHT_BUFFER_AUTO;
    shot_free(&deferred);
}

static void test_scenes_equal(void **state) {
    UNUSED(state);
    order_scenes(check_equal);
    order_cameras(check_equal);
}

/* So does what is drawn as rectangles; of use are the same lights. */
static void check_volumes(struct stage *stage, const char *what) {
    struct shot deferred = order_shoot(stage, FNL_SHADING_DEFERRED, FNL_LISTS_ALL);
    struct shot shot = order_shoot(stage, FNL_SHADING_PRE_LIGHTING, FNL_LISTS_ALL);
    struct shot again = order_shoot(stage, FNL_SHADING_PRE_LIGHTING, FNL_LISTS_TILED);
    int difference = greatest_difference(&deferred.color, &shot.color);
    print_message("  %s: %d/255, %llu of %llu evaluations\n", what, difference, (unsigned long long)shot.stats.evaluations,
                  (unsigned long long)deferred.stats.evaluations);
    assert_int_equal(count_broken(&shot.radiance), 0);
    assert_true(difference <= 2);
    assert_int_equal(shot.stats.evaluations_useful, deferred.stats.evaluations_useful);
    assert_true(shot.stats.evaluations <= deferred.stats.evaluations);
    assert_int_equal(count_differing(&shot.radiance, &again.radiance), 0);
    shot_free(&deferred);
    shot_free(&shot);
    shot_free(&again);
}

static void test_pre_lighting(void **state) {
    UNUSED(state);
    order_scenes(check_volumes);
    order_cameras(check_volumes);
}

/* Matter without Fresnel's rise under white lights: an index of refraction of 0 reflects the share `specular` from all sides. */
static fnl_scene *plain_scene(bool white) {
    fnl_scene *scene;
    assert_int_equal(scene_load_plain(gpu_host(harness_device()), "builtin:spheres?lights=60", NULL, &scene), FNL_OK);
    for (uint32_t i = 0; i < scene->materials.count; i++) {
        struct scene_material *m = &scene->materials.data[i];
        m->ior = 0;
        m->specular = 0.1f + 0.6f * (float)i / (float)scene->materials.count;
        m->metallic = 0;
    }
    for (uint32_t i = 0; i < scene->lights.count; i++) {
        fnl_light_id id = {i, scene->lights.data[i].generation};
        fnl_light_params light = scene->lights.data[i].params;
        if (white) light.color[0] = light.color[1] = light.color[2] = 1;
        assert_int_equal(fnl_scene_set_light(scene, id, &light), FNL_OK);
    }
    return scene;
}

static void test_four_channels(void **state) {
    UNUSED(state);
    for (int white = 1; white >= 0; white--) {
        struct stage stage = stage_open_scene(plain_scene(white));
        struct shot deferred = order_shoot(&stage, FNL_SHADING_DEFERRED, FNL_LISTS_ALL);
        stage.frame.light_buffer.kind = FNL_LIGHT_BUFFER_RGBA;
        struct shot rgba = order_shoot(&stage, FNL_SHADING_LIGHT_PREPASS, FNL_LISTS_ALL);
        int difference = greatest_difference(&deferred.color, &rgba.color);
        print_message("  %s lights: %d/255, PSNR %.1f dB\n", white ? "white" : "coloured", difference,
                      order_psnr(&deferred.color, &rgba.color));
        if (white)
            assert_true(difference <= 2);
        else
            assert_true(difference > 2 && order_psnr(&deferred.color, &rgba.color) > 30);
        shot_free(&deferred);
        shot_free(&rgba);
        stage_close(&stage);
    }
}

/* Surfaces of four bytes: close to deferred shading where reflectance is that of common dielectrics, whose rise at grazing angles one bit switches. */
static void test_narrow(void **state) {
    UNUSED(state);
    for (int metal = 0; metal < 2; metal++) {
        fnl_scene *scene;
        assert_int_equal(scene_load_plain(gpu_host(harness_device()), "builtin:hall?lights=256", NULL, &scene), FNL_OK);
        for (uint32_t i = 0; i < scene->materials.count; i++) {
            scene->materials.data[i].metallic = (float)metal;
            scene->materials.data[i].roughness = 0.4f;
        }
        struct stage stage = stage_open_scene(scene);
        struct shot deferred = order_shoot(&stage, FNL_SHADING_DEFERRED, FNL_LISTS_ALL);
        stage.frame.light_buffer.kind = FNL_LIGHT_BUFFER_RGBA;
        struct shot rgba = order_shoot(&stage, FNL_SHADING_LIGHT_PREPASS, FNL_LISTS_ALL);
        stage.frame.light_buffer.kind = FNL_LIGHT_BUFFER_NARROW;
        struct shot narrow = order_shoot(&stage, FNL_SHADING_LIGHT_PREPASS, FNL_LISTS_ALL);
        struct shot tiled = order_shoot(&stage, FNL_SHADING_LIGHT_PREPASS, FNL_LISTS_BACKFACE);
        const double got = order_psnr(&deferred.color, &narrow.color), other = order_psnr(&deferred.color, &rgba.color);
        print_message("  %s: narrow %.1f dB, rgba %.1f dB\n", metal ? "metals" : "dielectrics", got, other);
        assert_int_equal(count_broken(&narrow.radiance), 0);
        assert_true(got > 50 && got > other + 5);
        assert_int_equal(narrow.stats.evaluations_useful, deferred.stats.evaluations_useful);
        assert_int_equal(count_differing(&narrow.radiance, &tiled.radiance), 0);
        const uint64_t pixels = (uint64_t)stage.frame.width * stage.frame.height, leaning = counter(&rgba.stats, "light-buffer.bytes") - pixels * (8 + 16);
        assert_int_equal(counter(&narrow.stats, "light-buffer.bytes"), pixels * (4 + 32) + leaning);
        stage.frame.light_buffer.scale = 2;
        struct shot low = order_shoot(&stage, FNL_SHADING_LOW_RES, FNL_LISTS_TILED);
        assert_true(order_psnr(&narrow.color, &low.color) > 30);
        shot_free(&deferred);
        shot_free(&rgba);
        shot_free(&narrow);
        shot_free(&tiled);
        shot_free(&low);
        stage_close(&stage);
    }
}

/* ---- lower resolution ---- */

static void shoot_scaled(struct stage *stage, const char *what, double psnr, double share) {
    struct shot deferred = order_shoot(stage, FNL_SHADING_DEFERRED, FNL_LISTS_TILED);
    for (uint32_t scale = 2; scale <= 4; scale *= 2) {
        stage->frame.light_buffer.scale = scale;
        struct shot shot = order_shoot(stage, FNL_SHADING_LOW_RES, FNL_LISTS_TILED);
        double got = order_psnr(&deferred.color, &shot.color),
               part = (double)shot.stats.evaluations / (double)deferred.stats.evaluations;
        print_message("  %s, 1/%u: %.1f dB, %.2f of the evaluations\n", what, scale, got, part);
        assert_int_equal(count_broken(&shot.radiance), 0);
        assert_true(got > psnr && part < share);
        shot_free(&shot);
    }
    stage->frame.light_buffer.scale = 2;
    shot_free(&deferred);
}

static void test_low_res_quality(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:hall?lights=256", 0);
    stage.frame.ev = 3;
    stage.frame.width = 320;
    stage.frame.height = 180;
    shoot_scaled(&stage, "hall", 33, 0.6);
    stage_close(&stage);
    stage = stage_open("builtin:city?lights=512", 0);
    stage.frame.ev = 3;
    stage.frame.width = 320;
    stage.frame.height = 180;
    shoot_scaled(&stage, "city", 33, 0.7);
    stage_close(&stage);
}

/* Whether the pole's edge is within five pixels to either side. */
static bool by_edge(const fnl_image *normals, uint32_t x, uint32_t y) {
    const float *row = (const float *)normals->pixels + (size_t)y * normals->width * 4;
    bool near = false, far = false;
    for (uint32_t i = x > 5 ? x - 5 : 0; i <= MIN(x + 5, normals->width - 1); i++) {
        near = near || row[4 * i + 3] < 6;
        far = far || row[4 * i + 3] > 50;
    }
    return near && far;
}

/* A dark pole before a bright wall, and a bright pole before a dark wall: what no light reaches stays dark at every edge, what one
   reaches stays lit. */
static void test_low_res_edges(void **state) {
    UNUSED(state);
    for (int near = 0; near < 2; near++) {
        struct stage stage = stage_open("builtin:pole?lights=0", 0);
        stage.frame.outputs |= FNL_OUTPUT_NORMAL;
        stage.frame.width = 161; /* edges a few pixels apart */
        stage.frame.height = 91;
        struct shot dark = order_shoot(&stage, FNL_SHADING_DEFERRED, FNL_LISTS_ALL);
        fnl_light_params light = fnl_light_params_default();
        fnl_light_id id;
        light.position = near ? (fnl_vec3){0.6f, 2.2f, -3} : (fnl_vec3){1, 9, -54};
        light.range = near ? 2 : 25;
        light.intensity = near ? 60 : 9000;
        assert_int_equal(fnl_scene_add_light(stage.scene, &light, &id), FNL_OK);
        struct shot deferred = order_shoot(&stage, FNL_SHADING_DEFERRED, FNL_LISTS_ALL);
        for (uint32_t turn = 0; turn < 4; turn++) {
            uint32_t scale = turn & 1 ? 4 : 2;
            fnl_shading order = turn & 2 ? FNL_SHADING_INFERRED : FNL_SHADING_LOW_RES;
            stage.frame.light_buffer.scale = scale;
            struct shot shot = order_shoot(&stage, order, FNL_LISTS_ALL);
            const uint8_t *p = dark.color.pixels, *q = deferred.color.pixels, *r = shot.color.pixels;
            uint32_t unlit = 0, lit = 0, halo = 0, lost = 0;
            for (uint32_t i = 0; i < shot.color.width * shot.color.height; i++, p += 4, q += 4, r += 4) {
                if (!by_edge(&deferred.normal, i % shot.color.width, i / shot.color.width)) continue;
                int gain = 0, got = 0;
                for (int k = 0; k < 3; k++) {
                    gain = MAX(gain, abs(q[k] - p[k]));
                    got = MAX(got, abs(r[k] - p[k]));
                }
                unlit += gain == 0;
                lit += gain > 10;
                halo += gain == 0 && got > 3;
                lost += gain > 10 && got < gain / 2;
            }
            print_message("  %s, %s light, 1/%u: %u pixels unlit, %u of them bright; %u lit, %u of them dark\n",
                          fnl_value_name(FNL_ENUM_SHADING, order), near ? "near" : "far", scale, unlit, halo, lit, lost);
            assert_true(unlit > 100 && lit > 30);
            assert_int_equal(halo, 0);
            assert_true(lost * 20 <= lit); /* round the pole light changes from pixel to pixel */
            shot_free(&shot);
        }
        shot_free(&dark);
        shot_free(&deferred);
        stage_close(&stage);
    }
}

/*
 * A square before a wall that looks the same way, of the same material, with a light between them: nothing but the distance from the plane tells
 * their texels apart. The square's front gets no light, and what the wall gets does not leak onto it.
 */
static void test_steps_do_not_leak(void **state) {
    UNUSED(state);
    fnl_scene *scene = msaa_scene();
    fnl_material_id material = msaa_material(scene, 0.8f, 0.7f, 0.6f, 0.6f);
    msaa_square(scene, material, 0, 0.4f, vec3_make(-0.2f, 0.1f, 0.5f));
    msaa_square(scene, material, 0, 3, vec3_make(0, 0, 0));
    fnl_light_params light = fnl_light_params_default();
    fnl_light_id id;
    light.position = vec3_make(0.1f, 0, 0.25f);
    light.intensity = 5;
    light.range = 4;
    assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
    struct stage stage = stage_open_scene(scene);
    fnl_frame *frame = &stage.frame;
    frame->outputs |= FNL_OUTPUT_POSITION;
    frame->width = 90;
    frame->height = 90;
    frame->camera = fnl_camera_default();
    frame->camera.position = vec3_make(0, 0, 5);
    frame->camera.target = vec3_make(0, 0, 0);
    frame->camera.orthographic = true;
    frame->camera.vertical_extent = 2;
    frame->camera.far_distance = 20;
    struct shot deferred = order_shoot(&stage, FNL_SHADING_DEFERRED, FNL_LISTS_ALL);
    for (uint32_t turn = 0; turn < 4; turn++) {
        fnl_shading order = turn & 2 ? FNL_SHADING_INFERRED : FNL_SHADING_LOW_RES;
        frame->light_buffer.scale = turn & 1 ? 4 : 2;
        struct shot shot = order_shoot(&stage, order, FNL_LISTS_ALL);
        const float *p = deferred.radiance.pixels, *q = shot.radiance.pixels, *at = deferred.position.pixels;
        uint32_t front = 0, leaks = 0, wall = 0, lost = 0;
        for (uint32_t i = 0; i < frame->width * frame->height; i++) {
            bool is_front = at[4 * i + 2] > 0.25f;
            front += is_front;
            wall += !is_front;
            leaks += is_front && fabsf(p[4 * i] - q[4 * i]) > 1e-4f;
            lost += !is_front && q[4 * i] < 0.7f * p[4 * i];
        }
        print_message("  %s, 1/%u: %u of %u pixels of the square bright, %u of %u of the wall dark; %.2f of the evaluations\n",
                      fnl_value_name(FNL_ENUM_SHADING, order), frame->light_buffer.scale, leaks, front, lost, wall,
                      (double)shot.stats.evaluations / (double)deferred.stats.evaluations);
        assert_true(front > 1000 && wall > 1000);
        assert_int_equal(leaks, 0);
        assert_true(lost * 100 <= wall);
        assert_true(shot.stats.evaluations * 3 < deferred.stats.evaluations * (turn & 1 ? 1 : 2));
        shot_free(&shot);
    }
    shot_free(&deferred);
    stage_close(&stage);
}

/* Low resolution is its own brute force: every list gives the bits of `all`, in fewer evaluations. */
static void check_own_reference(struct stage *stage, const char *what) {
    static const fnl_light_lists lists[] = {FNL_LISTS_TILED,  FNL_LISTS_FINE,      FNL_LISTS_BACKFACE,
                                            FNL_LISTS_SPARSE, FNL_LISTS_CLUSTERED, FNL_LISTS_ZBIN};
    for (uint32_t scale = 2; scale <= 4; scale *= 2) {
        stage->frame.light_buffer.scale = scale;
        struct shot all = order_shoot(stage, FNL_SHADING_LOW_RES, FNL_LISTS_ALL);
        struct shot deferred = order_shoot(stage, FNL_SHADING_DEFERRED, FNL_LISTS_ALL);
        assert_int_equal(count_broken(&all.radiance), 0);
        assert_true(all.stats.evaluations <= deferred.stats.evaluations * 3 / 2);
        for (uint32_t i = 0; i < COUNT_OF(lists); i++) {
            struct shot shot = order_shoot(stage, FNL_SHADING_LOW_RES, lists[i]);
            if (count_differing(&all.radiance, &shot.radiance))
                fail_msg("%s, 1/%u: %s differs from all", what, scale, fnl_value_name(FNL_ENUM_LISTS, lists[i]));
            /* those that drop lights behind surfaces drop some that reach them too */
            assert_true(shot.stats.evaluations_useful <= all.stats.evaluations_useful);
            assert_true(shot.stats.evaluations <= all.stats.evaluations);
            shot_free(&shot);
        }
        shot_free(&all);
        shot_free(&deferred);
    }
    stage->frame.light_buffer.scale = 2;
}

static void test_low_res_lists(void **state) {
    UNUSED(state);
    order_cameras(check_own_reference);
    struct stage stage = stage_open("builtin:hall?lights=256", 0);
    check_own_reference(&stage, "hall");
    stage_close(&stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        {"ES-23: light-prepass with two and four sums equals deferred", test_scenes_equal, NULL, harness_check, NULL},
        {"ES-23: pre-lighting equals deferred", test_pre_lighting, NULL, harness_check, NULL},
        {"ES-23: four channels are right for white lights on Lambert with scalar highlights", test_four_channels, NULL,
         harness_check, NULL},
        {"ES-23: surfaces of four bytes with a Fresnel switch", test_narrow, NULL, harness_check, NULL},
        {"ES-24: low-res is close, in fewer evaluations", test_low_res_quality, NULL, harness_check, NULL},
        {"ES-24: neither low-res nor inferred has a halo at edges", test_low_res_edges, NULL, harness_check, NULL},
        {"ES-24: light does not leak from plane to plane", test_steps_do_not_leak, NULL, harness_check, NULL},
        {"FP-13: low-res is consistent with its own brute force", test_low_res_lists, NULL, harness_check, NULL},
    };
    return cmocka_run_group_tests_name("light apart from materials", tests, harness_begin, harness_end);
}
