/* SPDX-License-Identifier: MIT */
#include "tests/mobile_cases.h"

fnl_frame mobile_frame(const struct stage *stage) {
    fnl_frame frame = stage->frame;
    frame.shading = FNL_SHADING_MOBILE;
    frame.outputs = FNL_OUTPUT_COLOR;
    return frame;
}

void assert_same(const fnl_image *a, const fnl_image *b, const char *what) {
    uint64_t differing = count_differing(a, b);
    if (differing) fail_msg("%s: %llu pixels differ", what, (unsigned long long)differing);
}

double mean_difference(const fnl_image *a, const fnl_image *b) {
    const uint8_t *p = a->pixels, *q = b->pixels;
    double sum = 0;
    for (size_t i = 0; i < (size_t)a->width * a->height * 4; i++) sum += abs(p[i] - q[i]);
    return sum / ((double)a->width * a->height * 3);
}

struct stage edited_stage(const char *source, void (*edit)(struct scene_material *material, uint32_t index)) {
    fnl_scene *scene = NULL;
    assert_int_equal(scene_load_plain(NULL, source, NULL, &scene), FNL_OK);
    for (uint32_t i = 0; i < scene->materials.count; i++) edit(&scene->materials.data[i], i);
    return stage_open_scene(scene);
}
