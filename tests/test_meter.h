/* SPDX-License-Identifier: MIT */
/** Memory of a host, measured: how much is held, and the most that was held at once. For one thread. */
#ifndef FNL_TESTS_TEST_METER_H
#define FNL_TESTS_TEST_METER_H

#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

struct test_meter {
    uint64_t held, peak; /* bytes */
};

/** fnl_host.reallocate with a struct test_meter as `user`. */
static inline void *test_meter_reallocate(void *user, void *old, size_t old_size, size_t new_size) {
    struct test_meter *meter = user;
    meter->held += new_size - old_size;
    if (meter->peak < meter->held) meter->peak = meter->held;
    if (new_size > 0) return realloc(old, new_size);
    free(old);
    return NULL;
}

#endif
