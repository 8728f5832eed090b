/* SPDX-License-Identifier: MIT */
/** Asks lists, by the loop that shading runs, what they give to points: shared by the files of the test light_walk. */
#ifndef FNL_PASSES_WALK_TEST_H
#define FNL_PASSES_WALK_TEST_H

#include "passes/lights/walk_test_shared.h"
#include "tests/list_bench.h"

enum { WALK_POINTS = 600, WALK_ROW = GPU_WALK_ROOM + 1 };

extern struct gpu_walk_point points[WALK_POINTS];

/** Adds the walk of the list to the lab's graph and runs that. Rows of answers, to be freed, and copies of `reads` in lab->reads. */
uint32_t *walk(struct list_lab *lab, const struct light_list *list, const graph_buffer *reads, uint32_t read_count);

/** walk_kinds_test.c */
void test_kinds(void **state);

#endif
