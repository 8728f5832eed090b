/* SPDX-License-Identifier: MIT */
/* Frames whose light lists go through the compute queue. The CPU driver has one queue: its batches then alternate on it,
 * ordered by the same semaphores. */
#include "tests/render_harness.h"

static void test_async_lists_give_the_same_bytes(void **state) {
    UNUSED(state);
    struct stage s = stage_open("builtin:hall?lights=200", 0);
    s.frame.lists = FNL_LISTS_CLUSTERED;
    s.frame.timers = true;
    for (int shading = 0; shading < FNL_SHADING_DEFERRED + 1; shading++) {
        s.frame.shading = (fnl_shading)shading;
        harness_hooks(s.renderer)->force_async = false;
        struct shot plain = stage_shoot(&s, &s.frame);
        harness_hooks(s.renderer)->force_async = true;
        for (int frame = 0; frame < 3; frame++) { /* frames in flight reuse each other's memory */
            struct shot async = stage_shoot(&s, &s.frame);
            assert_int_equal(count_differing(&plain.radiance, &async.radiance), 0);
            assert_int_equal(plain.stats.list_entries, async.stats.list_entries);
            shot_free(&async);
        }
        char plan[65536];
        assert_true(fnl_renderer_print(s.renderer, FNL_PRINT_PLAN, plan, sizeof plan) < sizeof plan);
        assert_non_null(strstr(plan, "compute:")); /* the plan really has a second queue */
        fnl_frame_stats stats;
        assert_int_equal(fnl_renderer_query_stats(s.renderer, &stats), FNL_OK);
        for (uint32_t i = 0; i < stats.pass_count; i++) {
            char line[300];
            snprintf(line, sizeof line, "pass %u '%s' %s", i, stats.passes[i].name, fnl_value_name(FNL_ENUM_QUEUE, (uint32_t)stats.passes[i].queue));
            if (!strstr(plan, line)) fail_msg("the plan has no %s", line);
        }
        assert_true(stats.pass_count > 0);
        shot_free(&plain);
    }
    stage_close(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test_teardown(test_async_lists_give_the_same_bytes, harness_check)};
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
