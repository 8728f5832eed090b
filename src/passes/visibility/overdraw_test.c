/* SPDX-License-Identifier: MIT */
/** What drawing ids writes against drawing a G-buffer, where surfaces hide one another: the hall, drawn back to front. */
#include "tests/render_harness.h"
#include "tests/vulkan_spy.h"

/* Bytes of a pixel in the attachments that a pass stores: what each fragment that passes the depth test writes. */
static double bytes_written(struct stage *stage, const fnl_frame *frame, const char *name) {
    spy_clear();
    struct shot shot = stage_shoot(stage, frame);
    shot_free(&shot);
    uint64_t sum = 0;
    for (uint32_t i = 0; i < spy.attachment_count; i++)
        if (strcmp(spy.attachments[i].label, name) == 0) sum += spy_stored(&spy.attachments[i]);
    if (sum == 0) fail_msg("no pass %s", name);
    return (double)sum / (frame->width * frame->height);
}

static void test_overdraw(void **state) {
    UNUSED(state);
    spy_begin(harness_device());
    struct stage stage = stage_open("builtin:hall?lights=2&overdraw=1", 0);
    fnl_frame frame = stage.frame;
    frame.lists = FNL_LISTS_ALL;
    frame.count_lights = true;
    frame.shading = FNL_SHADING_FORWARD;
    struct shot shot = stage_shoot(&stage, &frame);
    double overdraw = (double)shot.stats.evaluations / 2 / (frame.width * frame.height);
    shot_free(&shot);
    frame.count_lights = false;
    frame.record_threads = 1;
    frame.shading = FNL_SHADING_DEFERRED;
    const double gbuffer = bytes_written(&stage, &frame, "gbuffer");
    frame.shading = FNL_SHADING_VISIBILITY;
    const double ids = bytes_written(&stage, &frame, "visibility");
    spy_end();
    print_message("%.2f fragments a pixel pass the depth test; ids take %.0f bytes of a pixel, the G-buffer %.0f\n", overdraw, ids, gbuffer);
    assert_true(overdraw > 3.6 && overdraw < 4.4);
    assert_true(ids <= 0.6 * gbuffer);
    stage_close(&stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        {"ES-73: ids write at most 0.6 of the bytes of a G-buffer, the hall drawn back to front", test_overdraw, NULL,
         harness_check, NULL}};
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
