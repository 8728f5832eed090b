/* SPDX-License-Identifier: MIT */
/** The scenes and cameras that every shading order is tried on, for tests. */
#ifndef FNL_TESTS_ORDER_CASES_H
#define FNL_TESTS_ORDER_CASES_H

#include "tests/render_harness.h"

/** `check` gets a stage whose frame is ready but for the shading order. */
typedef void order_check(struct stage *stage, const char *what);

static inline void order_scenes(order_check *check) {
    static const struct {
        const char *source;
        float ev;
    } scenes[] = {{"builtin:hall?lights=256", 3}, {"builtin:interior", 5},  {"builtin:spheres?lights=100", 5},
                  {"builtin:lamps", 5},           {"builtin:nearplane", 5}, {"builtin:onetile?lights=300", 5},
                  {"builtin:glass?lights=40", 5}, {"builtin:sky", 5},       {"builtin:spheres?lights=0", 5},
                  {"builtin:spheres?lights=1", 5}};
    for (uint32_t i = 0; i < COUNT_OF(scenes); i++) {
        struct stage stage = stage_open(scenes[i].source, 0);
        stage.frame.ev = scenes[i].ev;
        stage.frame.width = 73;
        stage.frame.height = 41;
        check(&stage, scenes[i].source);
        stage_close(&stage);
    }
}

static inline void order_cameras(order_check *check) {
    static const char *const names[] = {"in many lights", "orthographic", "off axis", "upside down and wide",
                                        "one pixel",      "at the rim",   "odd size"};
    struct stage stage = stage_open("builtin:spheres?lights=80", 0);
    stage.frame.width = 61;
    stage.frame.height = 37;
    const fnl_frame start = stage.frame;
    for (uint32_t kind = 0; kind < COUNT_OF(names); kind++) {
        stage.frame = start;
        fnl_camera *camera = &stage.frame.camera;
        if (kind == 0 || kind == 5) {
            fnl_light_params light;
            assert_int_equal(fnl_scene_query_light(stage.scene, 5, &light), FNL_OK);
            camera->position = light.position;
            camera->position.x += kind ? light.range : 1e-3f;
        } else if (kind == 1) {
            camera->orthographic = true;
            camera->vertical_extent = 8;
            camera->far_distance = 9; /* in the midst of lights: their far sides are beyond it */
        } else if (kind == 2) {
            camera->shift = (fnl_vec2){0.7f, -0.4f};
        } else if (kind == 3) {
            camera->up = (fnl_vec3){0.2f, -1, 0};
            camera->vertical_fov = 2.6f;
        } else if (kind == 4) {
            stage.frame.width = stage.frame.height = 1;
        } else {
            stage.frame.width = 43;
            stage.frame.height = 67;
        }
        check(&stage, names[kind]);
    }
    stage_close(&stage);
}

/** A shot of `stage` with an order and lists, lights counted. */
static inline struct shot order_shoot(struct stage *stage, fnl_shading shading, fnl_light_lists lists) {
    fnl_frame frame = stage->frame;
    frame.count_lights = true;
    frame.shading = shading;
    frame.lists = lists;
    return stage_shoot(stage, &frame);
}

/** PSNR of two pictures, dB. */
static inline double order_psnr(const fnl_image *a, const fnl_image *b) {
    fnl_image_difference difference;
    assert_int_equal(fnl_image_compare(gpu_host(harness_device()), a, b, &difference), FNL_OK);
    return difference.psnr;
}

#endif
