/* SPDX-License-Identifier: MIT */
#include "base/base.h"
#include "base/file.h"
#include "base/jobs.h"
#include "base/maths.h"

#include <setjmp.h>
#include <stdatomic.h>
#include <unistd.h>

#include <cmocka.h>

static void test_arena_reuses_its_blocks(void **state) {
    UNUSED(state);
    fnl_host host = host_resolve(NULL);
    struct arena arena;
    arena_init(&arena, &host, 1024);
    void *first = arena_allocate(&arena, 100);
    for (int i = 0; i < 50; i++) assert_non_null(arena_allocate(&arena, 500));
    arena_reset(&arena);
    assert_ptr_equal(arena_allocate(&arena, 100), first);
    assert_true(((uintptr_t)arena_allocate(&arena, 1) & 15) == 0);
    assert_string_equal(arena_format(&arena, "%d-%s", 7, "x"), "7-x");
    arena_finish(&arena);
}

static void add_index(void *context, uint32_t index) { atomic_fetch_add((atomic_ullong *)context, index + 1); }

static void test_parallel_for_visits_each_index_once(void **state) {
    UNUSED(state);
    for (uint32_t threads = 1; threads <= 5; threads++) {
        fnl_host host = host_resolve(NULL);
        host.thread_count = threads;
        struct jobs *jobs;
        assert_int_equal(jobs_create(&host, &jobs), FNL_OK);
        assert_int_equal(jobs_thread_count(jobs), threads);
        for (uint32_t count = 0; count < 200; count += 13) {
            atomic_ullong sum = 0;
            jobs_parallel_for(jobs, count, add_index, &sum);
            assert_int_equal(sum, (uint64_t)count * (count + 1) / 2);
        }
        jobs_destroy(&jobs);
        assert_null(jobs);
    }
}

static void test_file_appears_complete_or_not_at_all(void **state) {
    UNUSED(state);
    fnl_host host = host_resolve(NULL);
    char path[64];
    snprintf(path, sizeof path, "/tmp/fanal-base-test-%d", (int)getpid());
    struct file_writer writer;
    assert_int_equal(file_write_begin(&host, path, &writer), FNL_OK);
    fputs("half", writer.stream);
    assert_int_not_equal(access(path, F_OK), 0);
    file_write_abandon(&writer);
    assert_int_not_equal(access(path, F_OK), 0);
    assert_int_equal(file_save(&host, path, "whole", 5), FNL_OK);
    struct file_view view;
    assert_int_equal(file_map(&host, path, &view), FNL_OK);
    assert_int_equal(view.size, 5);
    assert_memory_equal(view.data, "whole", 5);
    file_unmap(&view);
    unlink(path);
}

static void test_half_floats_round_trip(void **state) {
    UNUSED(state);
    for (uint32_t half = 0; half < 0x10000; half++) {
        if ((half & 0x7c00) == 0x7c00 && (half & 0x3ff)) continue; /* NaN */
        assert_int_equal(half_from_float(half_to_float((uint16_t)half)), half);
    }
    assert_int_equal(half_from_float(65520.0f), 0x7c00);
    assert_int_equal(half_from_float(65519.0f), 0x7bff);
    assert_int_equal(half_from_float(1.0f + 0x1p-11f), 0x3c00); /* tie to even */
    assert_int_equal(half_from_float(1.0f + 3 * 0x1p-11f), 0x3c02);
}

static void test_matrix_inverse(void **state) {
    UNUSED(state);
    mat4 m = mat4_from_trs(vec3_make(1, -2, 3e4f), quat_normalize((quat){1, 2, 3, 4}), vec3_make(2, -3, 0.01f)), inverse;
    assert_true(mat4_inverse(&m, &inverse));
    vec3 p = mat4_point(&inverse, mat4_point(&m, vec3_make(5, 6, 7)));
    assert_true(vec3_distance(p, vec3_make(5, 6, 7)) < 0.3f); /* 3e4 / 0.01 leaves few bits */
    assert_true(mat4_determinant3(&m) < 0);
    mat4 flat = mat4_scaling(vec3_make(1, 0, 1));
    assert_false(mat4_inverse(&flat, &inverse));
}

static void test_octahedral_round_trip(void **state) {
    UNUSED(state);
    struct random_state random = {1};
    float worst = 1;
    for (int i = 0; i < 100000; i++) {
        vec3 n = vec3_normalize(
            vec3_make(random_range(&random, -1, 1), random_range(&random, -1, 1), random_range(&random, -1, 1)));
        worst = fminf(worst, vec3_dot(n, octahedral_decode(octahedral_encode(n))));
    }
    assert_true(worst > 0.999999f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_arena_reuses_its_blocks),
        cmocka_unit_test(test_parallel_for_visits_each_index_once),
        cmocka_unit_test(test_file_appears_complete_or_not_at_all),
        cmocka_unit_test(test_half_floats_round_trip),
        cmocka_unit_test(test_matrix_inverse),
        cmocka_unit_test(test_octahedral_round_trip),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
