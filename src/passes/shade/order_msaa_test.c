/* SPDX-License-Identifier: MIT */
/**
 * The shading orders with four samples a pixel, each against forward-prepass with as many: pixels that show one surface to 2/255, pictures by
 * decibels, surfaces whose light hardly changes within a pixel at their silhouettes too, where light that bleeds would show.
 */
#include "tests/msaa_cases.h"
#include "render/shading.h"

struct order_case {
    fnl_shading shading;
    double least;   /* decibels from forward-prepass */
    int silhouette; /* greatest difference of flat surfaces, of 255, at their silhouettes */
    bool exact;     /* lights each surface of a pixel for itself */
};

static const struct order_case orders[] = {
    {FNL_SHADING_DEFERRED, 44, 2, true},      {FNL_SHADING_LIGHT_PREPASS, 44, 2, true},
    {FNL_SHADING_PRE_LIGHTING, 44, 2, true},  {FNL_SHADING_LOW_RES, 26, 6, false},
    {FNL_SHADING_INFERRED, 26, 6, false},     {FNL_SHADING_DEFERRED_VOLUMES, 44, 2, true},
    {FNL_SHADING_LIGHT_INDEXED, 60, 1, false}, {FNL_SHADING_ZIOMA, 60, 1, false},
    {FNL_SHADING_TEXTURING, 44, 2, true},     {FNL_SHADING_VIRTUAL_TEXTURING, 44, 2, false},
};

static fnl_frame frame_of(const struct stage *stage, fnl_shading shading) {
    fnl_frame frame = stage->frame;
    frame.width = 77;
    frame.height = 43;
    frame.msaa = 4;
    frame.shading = shading;
    frame.lists = FNL_LISTS_CLUSTERED;
    return frame;
}

static fnl_frame small_frame(const struct stage *stage, fnl_shading shading) {
    fnl_frame frame = frame_of(stage, shading);
    frame.width = 61;
    frame.height = 37;
    return frame;
}

/* The pixels that the view of edges leaves grey: of one surface, lit at their middle by all. */
static void check_inner(struct stage *stage, fnl_frame frame, const struct shot *shot, const struct shot *forward) {
    frame.debug = FNL_DEBUG_EDGES;
    struct shot edges = stage_shoot(stage, &frame);
    const uint8_t *map = edges.color.pixels, *a = shot->color.pixels, *b = forward->color.pixels;
    uint32_t pixels = frame.width * frame.height, inner = 0, off = 0;
    for (uint32_t i = 0; i < pixels; i++) {
        if (map[4 * i] != map[4 * i + 1] || map[4 * i] != map[4 * i + 2]) continue;
        int difference = 0;
        for (int k = 0; k < 3; k++) difference = MAX(difference, abs(a[4 * i + k] - b[4 * i + k]));
        off += difference > 2;
        inner++;
    }
    print_message("    %u pixels are no edges, %u of them off\n", inner, off);
    assert_true(inner > pixels / 5);
    /* Gradients of stored coordinates beside silhouettes are those of the centroids that hardware takes, a square in its own way. */
    assert_true(off * 100 <= (shading_is(frame.shading, SHADING_APPROXIMATE) ? inner : 0));
    assert_true(counter(&shot->stats, "msaa.pixels") > 0 && counter(&shot->stats, "msaa.edge-pixels") > 0);
    shot_free(&edges);
}

static void test_scene(void **state) {
    if (!msaa_has(4)) skip();
    struct stage stage = stage_open(*state, 0);
    assert_int_equal(fnl_scene_set_anisotropy(stage.scene, 1), FNL_OK); /* drivers filter explicit gradients in ways of their own */
    fnl_frame frame = frame_of(&stage, FNL_SHADING_FORWARD_PREPASS);
    struct shot forward = stage_shoot(&stage, &frame);
    for (uint32_t i = 0; i < COUNT_OF(orders); i++) {
        const struct order_case *c = &orders[i];
        frame = frame_of(&stage, c->shading);
        struct shot shot = stage_shoot(&stage, &frame);
        double near = msaa_psnr(&shot.color, &forward.color);
        print_message("  %s: %.1f dB\n", fnl_value_name(FNL_ENUM_SHADING, c->shading), near);
        assert_int_equal(count_broken(&shot.radiance), 0);
        if (c->exact) check_inner(&stage, frame, &shot, &forward);
        assert_true(near > c->least);
        bool texturing = c->shading == FNL_SHADING_TEXTURING || c->shading == FNL_SHADING_VIRTUAL_TEXTURING;
        if ((shading_is(c->shading, SHADING_GBUFFER) && c->exact) || texturing) {
            frame.gbuffer.prepass = true; /* cutouts keep what the prepass has left of them */
            struct shot again = stage_shoot(&stage, &frame);
            const double kept = msaa_psnr(&again.color, &forward.color);
            print_message("    with a prepass %.1f dB\n", kept);
            assert_true(kept > c->least);
            shot_free(&again);
        }
        shot_free(&shot);
    }
    shot_free(&forward);
    stage_close(&stage);
}

/* ---- silhouettes ---- */

static void add_light(fnl_scene *scene, vec3 position, float intensity, float range) {
    fnl_light_params light = fnl_light_params_default();
    fnl_light_id id;
    light.position = position;
    light.intensity = intensity;
    light.range = range;
    assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
}

/*
 * Dim squares, one of the wall's own material, before a wall that bright lights stand close to, and before the sky. No light reaches both.
 * What each shows hardly changes from pixel to pixel, so all orders agree at silhouettes, wherever within a pixel they light it.
 */
static fnl_scene *silhouettes(void) {
    fnl_scene *scene = msaa_scene();
    fnl_material_id white = msaa_material(scene, 0.8f, 0.8f, 0.8f, 0.9f), red = msaa_material(scene, 0.8f, 0.2f, 0.1f, 0.9f);
    msaa_square(scene, red, 0.4f, 0.35f, vec3_make(-0.4f, 0.1f, 2));
    msaa_square(scene, white, 0.2f, 0.3f, vec3_make(0.4f, -0.1f, 2));
    msaa_square(scene, white, 0.1f, 0.8f, vec3_make(0, -0.25f, -4));
    for (int i = 0; i < 9; i++) add_light(scene, vec3_make(0.6f * (float)(i % 3 - 1), 0.6f * (float)(i / 3 - 1), -1), 8, 5);
    for (int i = 0; i < 4; i++) add_light(scene, vec3_make((float)(i % 2) - 0.5f, (float)(i / 2) - 0.5f, 4.5f), 0.4f, 4.5f);
    assert_int_equal(fnl_scene_set_background(scene, (vec3){0.3f, 0.3f, 0.9f}), FNL_OK);
    return scene;
}

static void look_down(fnl_frame *frame) {
    frame->camera = fnl_camera_default();
    frame->camera.position = vec3_make(0, 0, 8);
    frame->camera.target = vec3_make(0, 0, 0);
    frame->camera.orthographic = true;
    frame->camera.vertical_extent = 2;
    frame->camera.far_distance = 20;
    frame->exposure = FNL_EXPOSURE_EV;
    frame->ev = -0.5f;
}

static void test_silhouettes(void **state) {
    UNUSED(state);
    if (!msaa_has(4)) skip();
    struct stage stage = stage_open_scene(silhouettes());
    fnl_frame frame = frame_of(&stage, FNL_SHADING_FORWARD_PREPASS);
    look_down(&frame);
    struct shot forward = stage_shoot(&stage, &frame);
    frame.msaa = 1;
    struct shot one = stage_shoot(&stage, &frame);
    assert_true(greatest_difference(&one.color, &forward.color) > 60); /* there are edges to get wrong */
    for (uint32_t i = 0; i < COUNT_OF(orders); i++) {
        frame = frame_of(&stage, orders[i].shading);
        look_down(&frame);
        struct shot shot = stage_shoot(&stage, &frame);
        int difference = greatest_difference(&shot.color, &forward.color);
        print_message("  %s: %d/255\n", fnl_value_name(FNL_ENUM_SHADING, orders[i].shading), difference);
        if (difference > orders[i].silhouette)
            fail_msg("%s: %d/255 at silhouettes", fnl_value_name(FNL_ENUM_SHADING, orders[i].shading), difference);
        shot_free(&shot);
    }
    shot_free(&one);
    shot_free(&forward);
    stage_close(&stage);
}

/*
 * Lights that are written into pixels are looked for where any of their samples lies: surfaces at silhouettes, of which some samples see one and
 * some the other, find theirs there too, and do not go through all lights.
 */
static void test_indexed_counts(void **state) {
    UNUSED(state);
    if (!msaa_has(4)) skip();
    fnl_scene *scene = silhouettes();
    for (int i = 0; i < 100; i++) /* in the air */
        add_light(scene, vec3_make(0.2f * (float)(i % 10) - 0.9f, 0.2f * (float)(i / 10) - 0.9f, 1), 1, 0.1f);
    struct stage stage = stage_open_scene(scene);
    fnl_frame frame = frame_of(&stage, FNL_SHADING_LIGHT_INDEXED);
    look_down(&frame);
    frame.light_indexed.layers = 16;
    frame.count_lights = true;
    struct shot shot = stage_shoot(&stage, &frame);
    double indexed = (double)shot.stats.evaluations, useful = (double)shot.stats.evaluations_useful;
    print_message("  %.0f evaluations, %.3f of the useful ones\n", indexed, indexed / useful);
    assert_true(indexed >= useful && indexed < 1.035 * useful); /* a pixel has the lights of both its surfaces */
    shot_free(&shot);
    stage_close(&stage);
}

/* ---- G-buffers of deferred shading ---- */

/* Every layout, encoding and chroma; what a layout cannot hold is lit forward, on its own samples alone. */
static void test_layouts(void **state) {
    UNUSED(state);
    if (!msaa_has(4)) skip();
    struct stage stage = stage_open("builtin:spheres?lights=40", 0);
    fnl_frame frame = small_frame(&stage, FNL_SHADING_FORWARD_PREPASS);
    struct shot forward = stage_shoot(&stage, &frame);
    for (uint32_t g = 0; g < FNL_GBUFFER_COUNT; g++) {
        for (uint32_t n = 0; n < FNL_NORMALS_COUNT + 1; n++) {
            bool chroma = n == FNL_NORMALS_COUNT;
            /* Encodings differ with the viewer's place or not. */
            if (chroma ? g > 0 : n > 0 && (g > 0 || (n != FNL_NORMALS_XY && n != FNL_NORMALS_VIEW))) continue;
            frame = small_frame(&stage, FNL_SHADING_DEFERRED);
            frame.gbuffer.layout = (fnl_gbuffer)g;
            frame.gbuffer.normals = chroma ? FNL_NORMALS_LAYOUT : (fnl_normal_encoding)n;
            frame.gbuffer.chroma = chroma;
            struct shot shot = stage_shoot(&stage, &frame);
            double near = msaa_psnr(&shot.color, &forward.color);
            print_message("  %s, normals %s%s: %.1f dB\n", fnl_value_name(FNL_ENUM_GBUFFER, (fnl_gbuffer)g),
                          fnl_value_name(FNL_ENUM_NORMALS, frame.gbuffer.normals), chroma ? ", chroma" : "", near);
            assert_int_equal(count_broken(&shot.radiance), 0);
            assert_true(near > 46); /* with one sample 49 to 59 */
            shot_free(&shot);
        }
    }
    shot_free(&forward);
    stage_close(&stage);
}

/* ---- options and cameras ---- */

/* What writes lights into pixels is forward shading: the same bits, with any packing, with room for all lights and for hardly any. */
static void check_indexed(struct stage *stage, fnl_frame frame, const char *what) {
    frame.shading = FNL_SHADING_FORWARD_PREPASS;
    frame.lists = FNL_LISTS_ALL;
    struct shot forward = stage_shoot(stage, &frame);
    enum { INDEXED = 7 };
    for (uint32_t i = 0; i < INDEXED + 2; i++) {
        static const uint32_t layers[INDEXED + 2] = {1, 16, 1, 8, 2, 2, 4, 1, 8};
        static const fnl_light_packing packings[INDEXED] = {FNL_LIGHT_PACKING_IDS, FNL_LIGHT_PACKING_IDS, FNL_LIGHT_PACKING_SHIFT,
                                                            FNL_LIGHT_PACKING_MAX, FNL_LIGHT_PACKING_MAX, FNL_LIGHT_PACKING_STENCIL, FNL_LIGHT_PACKING_SETS};
        frame.shading = i < INDEXED ? FNL_SHADING_LIGHT_INDEXED : FNL_SHADING_ZIOMA;
        frame.light_indexed.layers = layers[i];
        if (i < INDEXED) frame.light_indexed.packing = packings[i];
        struct shot shot = stage_shoot(stage, &frame);
        uint64_t differing = count_differing(&forward.radiance, &shot.radiance);
        int difference = greatest_difference(&forward.color, &shot.color);
        if (i < INDEXED ? differing > 0 : difference > 1)
            fail_msg("%s: %s, %u layers: %llu pixels differ, by %d/255", what, fnl_value_name(FNL_ENUM_SHADING, frame.shading), layers[i],
                     (unsigned long long)differing, difference);
        shot_free(&shot);
    }
    shot_free(&forward);
}

static void test_cameras(void **state) {
    UNUSED(state);
    if (!msaa_has(4)) skip();
    struct stage stage = stage_open("builtin:spheres?lights=60", 0);
    assert_int_equal(fnl_scene_set_anisotropy(stage.scene, 1), FNL_OK);
    fnl_light_params light;
    assert_int_equal(fnl_scene_query_light(stage.scene, 5, &light), FNL_OK);
    for (uint32_t kind = 0; kind < 5; kind++) {
        static const char *const names[] = {"in a light", "orthographic", "off axis", "sky", "one pixel"};
        fnl_frame frame = small_frame(&stage, FNL_SHADING_FORWARD_PREPASS);
        fnl_camera *camera = &frame.camera;
        if (kind == 0) {
            camera->position = light.position;
            camera->position.x += 1e-3f;
        } else if (kind == 1) {
            camera->orthographic = true;
            camera->vertical_extent = 8;
            camera->far_distance = 9;
        } else if (kind == 2) {
            camera->shift = (fnl_vec2){0.7f, -0.4f};
        } else if (kind == 3) {
            camera->target = vec3_add(camera->position, vec3_make(0, 10, 10));
        } else {
            frame.width = frame.height = 1;
        }
        check_indexed(&stage, frame, names[kind]);
        frame.shading = FNL_SHADING_DEFERRED;
        struct shot deferred = stage_shoot(&stage, &frame);
        for (uint32_t i = 0; i < COUNT_OF(orders); i++) {
            if (!orders[i].exact || orders[i].shading == FNL_SHADING_DEFERRED) continue;
            frame.shading = orders[i].shading;
            struct shot shot = stage_shoot(&stage, &frame);
            double near = msaa_psnr(&deferred.color, &shot.color);
            /* Where light alone is asked for, surfaces that differ in colour are one. */
            assert_int_equal(count_broken(&shot.radiance), 0);
            if (kind < 4 && near < (frame.shading == FNL_SHADING_DEFERRED_VOLUMES ? 55 : 40))
                fail_msg("%s: %s is %.1f dB from deferred", names[kind], fnl_value_name(FNL_ENUM_SHADING, frame.shading), near);
            shot_free(&shot);
        }
        shot_free(&deferred);
    }
    stage_close(&stage);
}

/* Volumes of all shapes light the same. */
static void test_shapes(void **state) {
    UNUSED(state);
    if (!msaa_has(4)) skip();
    struct stage stage = stage_open("builtin:hall?lights=64", 0);
    struct shot solids = {0};
    for (uint32_t v = 0; v < FNL_VOLUME_SHAPE_COUNT; v++) {
        fnl_frame frame = small_frame(&stage, FNL_SHADING_DEFERRED_VOLUMES);
        frame.volume_shape = (fnl_volume_shape)v;
        frame.count_lights = true;
        struct shot shot = stage_shoot(&stage, &frame);
        if (v == 0) {
            solids = shot;
            continue;
        }
        if (greatest_difference(&solids.color, &shot.color) > 1 ||
            llabs((long long)(solids.stats.evaluations_useful - shot.stats.evaluations_useful)) > 100)
            fail_msg("shape %u: %d/255 from solids, %llu evaluations of use instead of %llu", v,
                     greatest_difference(&solids.color, &shot.color), (unsigned long long)shot.stats.evaluations_useful,
                     (unsigned long long)solids.stats.evaluations_useful);
        shot_free(&shot);
    }
    shot_free(&solids);
    stage_close(&stage);
}

/* ---- what is drawn afterwards ---- */

static void test_glass(void **state) {
    UNUSED(state);
    if (!msaa_has(4)) skip();
    struct stage stage = stage_open("builtin:glass?lights=20", 0);
    for (uint32_t t = 0; t < FNL_TRANSPARENCY_COUNT; t++) {
        fnl_frame frame = small_frame(&stage, FNL_SHADING_FORWARD_PREPASS);
        frame.transparency = (fnl_transparency)t;
        struct shot forward = stage_shoot(&stage, &frame);
        for (uint32_t i = 0; i < COUNT_OF(orders); i++) {
            frame.shading = orders[i].shading;
            frame.debug = FNL_DEBUG_NONE;
            struct shot shot = stage_shoot(&stage, &frame);
            double near = msaa_psnr(&forward.color, &shot.color);
            print_message("  %s, transparency %u: %.1f dB\n", fnl_value_name(FNL_ENUM_SHADING, frame.shading), t, near);
            assert_int_equal(count_broken(&shot.radiance), 0);
            assert_true(near > orders[i].least);
            if (t == 0) { /* views of what such orders have */
                frame.debug = FNL_DEBUG_LIGHTS;
                struct shot view = stage_shoot(&stage, &frame);
                assert_true(greatest_difference(&view.color, &shot.color) > 20);
                shot_free(&view);
            }
            shot_free(&shot);
        }
        shot_free(&forward);
    }
    stage_close(&stage);
}

#define SCENE(source) {"ES-9, ES-20: shading orders with 4 samples near forward-prepass, " source, test_scene, NULL, harness_check, source}

int main(void) {
    const struct CMUnitTest tests[] = {
        SCENE("builtin:hall?lights=64"),
        SCENE("builtin:spheres?lights=30"),
        SCENE("builtin:grass?lights=40"),
        {"ES-20, ES-23: no light bleeds over silhouettes", test_silhouettes, NULL, harness_check, NULL},
        {"ES-26: lights of silhouettes are found by samples", test_indexed_counts, NULL, harness_check, NULL},
        {"ES-25, ES-26: cameras, packings and room", test_cameras, NULL, harness_check, NULL},
        {"ES-14, ES-18: volumes of all shapes", test_shapes, NULL, harness_check, NULL},
        {"ES-44: glass in three ways, and views", test_glass, NULL, harness_check, NULL},
        {"ES-10, ES-12, ES-13, FP-8: G-buffers with 4 samples", test_layouts, NULL, harness_check, NULL},
    };
    return cmocka_run_group_tests_name("shading orders with samples", tests, harness_begin, harness_end);
}
