/* SPDX-License-Identifier: MIT */
/** Surfaces that show what is behind them: against rays, in layers, and what frames without them pay. */
#include "fanal/trace.h"
#include "render/shading.h"
#include "tests/render_harness.h"

static void test_nothing(void **state) { UNUSED(state); }

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test_teardown(test_nothing, harness_check)};
    return cmocka_run_group_tests_name("transmission", tests, harness_begin, harness_end);
}
