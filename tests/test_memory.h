/* SPDX-License-Identifier: MIT */
/** Memory of a test's host. */
#ifndef FNL_TESTS_TEST_MEMORY_H
#define FNL_TESTS_TEST_MEMORY_H

#include <setjmp.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/** A host that counts, checks the sizes that come back, can be made to fail, and keeps the last error. */
struct test_memory {
    atomic_llong live_bytes, allocations; /* allocations: new or bigger blocks */
    atomic_llong fail_at;                 /* this allocation and all after it fail; 0: none */
    atomic_int wrong_sizes, errors;       /* errors: lines logged as such */
    atomic_int warnings;                  /* as well */
    bool loud;                            /* render_test.h prints warnings and errors; validation messages in any case */
    char last_error[512];
};

/** fnl_host.reallocate with a struct test_memory as `user`. */
static inline void *test_memory_reallocate(void *user, void *old, size_t old_size, size_t new_size) {
    enum { SIZE_HEADER = 16 }; /* before each block */
    struct test_memory *memory = user;
    char *block = old ? (char *)old - SIZE_HEADER : NULL;
    size_t known = 0;
    if (block) memcpy(&known, block, sizeof known);
    if (known != old_size) atomic_fetch_add(&memory->wrong_sizes, 1);
    if (new_size == 0) {
        free(block);
        atomic_fetch_sub(&memory->live_bytes, (long long)known);
        return NULL;
    }
    long long number = atomic_fetch_add(&memory->allocations, 1) + 1, fail_at = atomic_load(&memory->fail_at);
    if (fail_at && number >= fail_at) return NULL;
    block = realloc(block, new_size + SIZE_HEADER);
    assert_non_null(block);
    memcpy(block, &new_size, sizeof new_size);
    atomic_fetch_add(&memory->live_bytes, (long long)new_size - (long long)known);
    return block + SIZE_HEADER;
}

#endif
