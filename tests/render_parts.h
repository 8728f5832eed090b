/* SPDX-License-Identifier: MIT */
/**
 * The program of all tests that render. Its parts are the programs of fanal_render_test(), each with its own groups of tests; they share one
 * device, and with it the pipelines, which take longer to make than everything the tests draw.
 *
 *     test_render [PART[:TEST]…]     all parts without arguments; TEST may have * and ?
 *
 * Those that $FANAL_SKIP names, with blanks between them, are left out.
 */
#ifndef FNL_TESTS_RENDER_PARTS_H
#define FNL_TESTS_RENDER_PARTS_H

#include <stddef.h>

struct render_part {
    const char *name;
    int (*run)(void); /* tests that failed */
};
/** Written by the build. */
extern const struct render_part render_parts[];
extern const size_t render_part_count;

#endif
