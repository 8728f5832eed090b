/* SPDX-License-Identifier: MIT */
/** What drawing ids costs against drawing a G-buffer, where surfaces hide one another: the hall, drawn back to front. */
#include "tests/render_harness.h"

static double pass_time(struct stage *stage, const fnl_frame *frame, const char *name) {
    struct shot shot = stage_shoot(stage, frame);
    shot_free(&shot);
    fnl_frame_stats stats;
    assert_int_equal(fnl_renderer_query_stats(stage->renderer, &stats), FNL_OK);
    for (uint32_t i = 0; i < stats.pass_count; i++)
        if (strcmp(stats.passes[i].name, name) == 0) return stats.passes[i].milliseconds;
    fail_msg("no pass %s", name);
    return 0;
}

static void test_overdraw(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:hall?lights=2&overdraw=1", 0);
    fnl_frame frame = stage.frame;
    frame.lists = FNL_LISTS_ALL;
    frame.count_lights = true;
    frame.shading = FNL_SHADING_FORWARD;
    struct shot shot = stage_shoot(&stage, &frame);
    double overdraw = (double)shot.stats.evaluations / 2 / (frame.width * frame.height);
    shot_free(&shot);
    frame.count_lights = false;
    frame.timers = true;
    frame.width = 480;
    frame.height = 270;
    double ids = INFINITY, gbuffer = INFINITY;
    for (int i = 0; i < 6; i++) { /* other programs make some of them slow */
        frame.shading = FNL_SHADING_DEFERRED;
        gbuffer = fmin(gbuffer, pass_time(&stage, &frame, "gbuffer"));
        frame.shading = FNL_SHADING_VISIBILITY;
        ids = fmin(ids, pass_time(&stage, &frame, "visibility"));
    }
    print_message("%.2f fragments a pixel pass the depth test; ids in %.2f of the G-buffer's time\n", overdraw,
                  ids / gbuffer);
    assert_true(overdraw > 3.6 && overdraw < 4.4);
    assert_true(ids <= 0.6 * gbuffer);
    stage_close(&stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        {"ES-73: ids take at most 0.6 of the time of a G-buffer, the hall drawn back to front", test_overdraw, NULL,
         harness_check, NULL}};
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
