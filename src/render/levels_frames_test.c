/* SPDX-License-Identifier: MIT */
/* Levels of detail in frames: each picture shows those that fit its camera, whatever the one before did; rays show the same. */
#include "fanal/trace.h"
#include "tests/levels_file.h"
#include "tests/render_harness.h"

static const char levels[] =
    LEVELS_FILE("", "", "{\"mesh\":0," LEVELS_IDS("1,2") "," LEVELS_COVERAGE("0.5,0.2,0.01") "},{\"mesh\":1},{\"mesh\":2}");

static struct stage open_levels(void) {
    fnl_scene *scene = NULL;
    size_t size;
    unsigned char *glb = test_glb(levels, levels_square, sizeof levels_square, &size);
    fnl_load_params load = fnl_load_params_default();
    load.data = glb;
    load.size = size;
    assert_int_equal(fnl_scene_load(NULL, "levels.glb", &load, &scene), FNL_OK);
    free(glb);
    struct stage s = stage_open_scene(scene);
    s.frame.width = s.frame.height = 33;
    s.frame.outputs = FNL_OUTPUT_RADIANCE;
    s.frame.shading = FNL_SHADING_FORWARD;
    return s;
}

/* r, g, b or - for nothing in the middle of a picture. */
static char middle(const fnl_image *image, uint32_t view) {
    const float *p = (const float *)image->pixels + ((size_t)view * 33 * 33 + 16 * 33 + 16) * 4;
    return p[0] > p[1] ? 'r' : p[1] > p[2] ? 'g' : p[2] > p[1] ? 'b' : '-';
}

static void test_frames_show_levels_MA_12(void **state) {
    UNUSED(state);
    struct stage s = open_levels();
    static const struct {
        float coverage;
        char color;
    } steps[] = {{0.8f, 'r'}, {0.3f, 'g'}, {0.19f, 'b'}, {0.8f, 'r'}, {0.3f, 'g'}};
    for (uint32_t i = 0; i < COUNT_OF(steps); i++) {
        s.frame.camera = levels_camera(sqrtf(2 / (steps[i].coverage * steps[i].coverage) + 2));
        struct shot shot = stage_shoot(&s, &s.frame);
        if (middle(&shot.radiance, 0) != steps[i].color) fail_msg("step %u: %c, not %c", i, middle(&shot.radiance, 0), steps[i].color);
        assert_int_equal(shot.stats.triangles_total, 2); /* of one level, not of three */
        shot_free(&shot);
    }
    s.frame.camera = levels_camera(300);
    struct shot shot = stage_shoot(&s, &s.frame);
    assert_int_equal(shot.stats.triangles_total, 0);
    shot_free(&shot);
    fnl_trace_params p = trace_plain();
    p.width = p.height = 33;
    for (uint32_t i = 0; i < COUNT_OF(steps); i++) {
        p.camera = levels_camera(sqrtf(2 / (steps[i].coverage * steps[i].coverage) + 2));
        fnl_trace trace;
        assert_int_equal(fnl_scene_trace(s.scene, &p, &trace), FNL_OK);
        assert_int_equal(middle(&trace.radiance, 0), steps[i].color);
        fnl_trace_free(&s.scene->host, &trace);
    }
    stage_close(&s);
}

/* All views of a frame show what fits the first. */
static void test_views_share_levels_MA_12(void **state) {
    UNUSED(state);
    struct stage s = open_levels();
    const fnl_camera views[2] = {levels_camera(sqrtf(2 / (0.3f * 0.3f) + 2)), levels_camera(2.5f)};
    s.frame.views = views;
    s.frame.view_count = 2;
    struct shot shot = stage_shoot(&s, &s.frame);
    assert_int_equal(middle(&shot.radiance, 0), 'g');
    shot_free(&shot);
    const fnl_camera turned[2] = {views[1], views[0]};
    s.frame.views = turned;
    shot = stage_shoot(&s, &s.frame);
    assert_int_equal(middle(&shot.radiance, 0), 'r');
    shot_free(&shot);
    stage_close(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_frames_show_levels_MA_12),
        cmocka_unit_test(test_views_share_levels_MA_12),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
