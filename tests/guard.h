/* SPDX-License-Identifier: MIT */
/**
 * Memory that nothing may touch for a while: proves, without a clock, that a step does not walk over an array. A read or write ends the test
 * with a segmentation fault, which cmocka reports as a failure.
 */
#ifndef FNL_TESTS_GUARD_H
#define FNL_TESTS_GUARD_H

#include <assert.h>
#include <stdint.h>
#include <sys/mman.h>
#include <unistd.h>

struct guard {
    void *begin;
    size_t size;
};

/** Guards the whole pages within an array; what is on its first and last page can still be read. */
static inline struct guard guard_begin(const void *data, size_t size) {
    const uintptr_t page = (uintptr_t)sysconf(_SC_PAGESIZE), begin = ((uintptr_t)data + page - 1) / page * page, end = ((uintptr_t)data + size) / page * page;
    if (end <= begin) return (struct guard){0};
    struct guard guard = {(void *)begin, end - begin};
    if (mprotect(guard.begin, guard.size, PROT_NONE) != 0) guard.size = 0;
    return guard;
}

static inline void guard_end(struct guard *guard) {
    if (guard->size) mprotect(guard->begin, guard->size, PROT_READ | PROT_WRITE);
    *guard = (struct guard){0};
}

#endif
