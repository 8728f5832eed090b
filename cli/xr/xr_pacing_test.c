/* SPDX-License-Identifier: MIT */
/* How large frames in a headset are, by the times of those before: against made-up times. */
#include "xr/xr.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

/* What only predictions need, which are not made here. */
bool xr_good(struct xr *x, const char *function, XrResult result) {
    (void)x, (void)function;
    return XR_SUCCEEDED(result);
}

bool xr_is_pose(struct xr *x, enum xr_pose_of of, const XrPosef *pose) {
    (void)x, (void)of, (void)pose;
    return true;
}

#define PERIOD 10.0 /* milliseconds */
enum { WINDOW = 8, CALM = 100 /* frames of a second */ };
static struct xr_options options;
static struct xr x;

static void begin(float scale, double budget) {
    options = (struct xr_options){.scale = scale, .budget = budget};
    x = (struct xr){.options = &options, .scale = scale > 0 ? scale : 1};
    x.numbers.period = PERIOD;
    x.numbers.least_scale = x.scale;
}

static void frames(uint32_t count, double time) {
    for (uint32_t i = 0; i < count; i++) xr_note_times(&x, i % 2 ? time : 1, i % 2 ? 1 : time); /* the longer of both counts */
}

/* Frames of this time until the size is another; fails after 1000. */
static uint32_t until_change(double time) {
    const float before = x.scale;
    for (uint32_t i = 1; i <= 1000; i++) {
        frames(1, time);
        if (x.scale != before) return i;
    }
    fail_msg("the size stays %g", (double)before);
    return 0;
}

static void test_the_size_falls_and_rises_again(void **state) {
    (void)state;
    begin(0, 0);
    assert_int_equal(until_change(20), WINDOW); /* at once, so that 85 % of the budget suffice: the root of 8.5 / 20 */
    assert_true(x.scale == 10.0f / 16 && x.numbers.least_scale == 10.0f / 16);
    for (uint32_t step = 11; step <= 16; step++) { /* a sixteenth for each second of ease */
        assert_int_equal(until_change(7.4), WINDOW - 1 + CALM);
        assert_true(x.scale == (float)step / 16 && x.numbers.least_scale == 10.0f / 16);
    }
    frames(5 * CALM, 1);
    assert_true(x.scale == 1); /* no larger than what the headset recommends */
    assert_int_equal(x.numbers.scale_changes, 7);
    assert_int_equal(until_change(9.6), WINDOW / 2); /* half of the last eight */
    assert_true(x.scale == 15.0f / 16); /* a sixteenth at least */
    until_change(1000);
    assert_true(x.scale == 0.5f);
    frames(50, 1000);
    assert_true(x.scale == 0.5f && x.numbers.least_scale == 0.5f);
}

/* Neither fast enough to rise nor too slow; single slow frames do not count, but a while without ease starts the second again. */
static void test_the_size_stays_between(void **state) {
    (void)state;
    begin(0, 0);
    until_change(20);
    frames(10 * CALM, 7.6);
    frames(10 * CALM, 9.4);
    assert_int_equal(x.numbers.scale_changes, 1);
    frames(CALM / 2, 7);
    for (uint32_t i = 0; i < 5; i++) {
        frames(CALM / 2, 7); /* never a second in a row */
        frames(WINDOW, 8);
    }
    assert_int_equal(x.numbers.scale_changes, 1);
    frames(WINDOW, 7);
    for (uint32_t i = 0; i < CALM / 5 && x.numbers.scale_changes == 1; i++) { /* a hitch now and then */
        frames(4, 7);
        frames(1, 60);
    }
    assert_int_equal(x.numbers.scale_changes, 2);
    assert_true(x.scale == 11.0f / 16);
}

static void test_budgets_and_given_sizes(void **state) {
    (void)state;
    begin(0, 40); /* in place of the period */
    frames(200, 37);
    assert_int_equal(x.numbers.scale_changes, 0);
    assert_int_equal(until_change(39), WINDOW / 2);
    assert_int_equal(until_change(29), WINDOW - 1 + CALM);
    assert_true(x.scale == 1);
    begin(0.75f, 0);
    frames(100, 50);
    frames(10 * CALM, 1);
    assert_true(x.scale == 0.75f && x.numbers.scale_changes == 0);
    assert_int_equal(x.numbers.over_budget, 100);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_the_size_falls_and_rises_again),
        cmocka_unit_test(test_the_size_stays_between),
        cmocka_unit_test(test_budgets_and_given_sizes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
