/* SPDX-License-Identifier: MIT */
/** What every file uses: memory and log through the host, checks, arenas, arrays. */
#ifndef FNL_BASE_BASE_H
#define FNL_BASE_BASE_H

#include "base/number.h"

#include "fanal/base.h"
#include "fanal/values.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define COUNT_OF(array) ((uint32_t)(sizeof(array) / sizeof((array)[0])))
#define MIN(a, b) ((a) < (b) ? (a) : (b))
#define MAX(a, b) ((a) > (b) ? (a) : (b))
#define CLAMP(x, low, high) MIN(MAX(x, low), high)
#define DIVIDE_UP(a, b) (((a) + (b)-1) / (b))
#define UNUSED(x) ((void)(x))

/** Rounds up to a multiple of a power of two. */
static inline uint64_t align_up(uint64_t value, uint64_t alignment) { return (value + alignment - 1) & ~(alignment - 1); }

/* ---- host: memory and log ---- */

/** Fills in the defaults of NULL callbacks; a NULL host gives all defaults. */
fnl_host host_resolve(const fnl_host *host);

/** Uninitialised memory; size 0 gives NULL. NULL with a logged error when memory ran out. */
void *host_allocate(const fnl_host *host, size_t size);
void *host_allocate_zero(const fnl_host *host, size_t size);
/** Resizes; on failure NULL, and the old block stays. */
void *host_resize(const fnl_host *host, void *old, size_t old_size, size_t new_size);
void host_free(const fnl_host *host, void *block, size_t size);

/** What a file may decode to unless somebody says otherwise: half of the machine's memory. */
uint64_t host_memory_limit(void);

void host_log(const fnl_host *host, fnl_log_level level, const char *format, ...) __attribute__((format(printf, 3, 4)));
void host_log_list(const fnl_host *host, fnl_log_level level, const char *format, va_list arguments);

#define log_debug(host, ...) host_log(host, FNL_LOG_DEBUG, __VA_ARGS__)
#define log_info(host, ...) host_log(host, FNL_LOG_INFO, __VA_ARGS__)
#define log_warning(host, ...) host_log(host, FNL_LOG_WARNING, __VA_ARGS__)
#define log_error(host, ...) host_log(host, FNL_LOG_ERROR, __VA_ARGS__)

/** What only Fanal's own code can get wrong: logs the failed expression and returns FNL_ERROR_INVALID. For arguments of public functions: check.h. */
#define REQUIRE(host, expression)                                                                                           \
    do {                                                                                                                    \
        if (!(expression)) {                                                                                                \
            log_error(host, "internal error: %s: '%s' does not hold", __func__, #expression);                                       \
            return FNL_ERROR_INVALID;                                                                                       \
        }                                                                                                                   \
    } while (0)

/** Returns early with the result of a call that failed. */
#define TRY(call)                                                                                                           \
    do {                                                                                                                    \
        fnl_result try_result_ = (call);                                                                                    \
        if (try_result_ != FNL_OK) return try_result_;                                                                      \
    } while (0)

/* ---- arena: memory that is freed all at once ---- */

struct arena_block;

/** Grows in blocks; reset keeps the blocks, so a steady state allocates nothing from the host. Not thread-safe. */
struct arena {
    const fnl_host *host;
    struct arena_block *first, *current;
    size_t block_size;
};

void arena_init(struct arena *arena, const fnl_host *host, size_t block_size);
void arena_finish(struct arena *arena);
void arena_reset(struct arena *arena);
/** Takes over all that another arena of the same host holds; what was allocated stays where it is. */
void arena_adopt(struct arena *arena, struct arena *from);
/** 16-byte aligned, not cleared. NULL when memory ran out. */
void *arena_allocate(struct arena *arena, size_t size);
void *arena_allocate_zero(struct arena *arena, size_t size);
void *arena_copy(struct arena *arena, const void *data, size_t size);
/** A copy with a terminating zero. */
char *arena_string(struct arena *arena, const char *text);
char *arena_format(struct arena *arena, const char *format, ...) __attribute__((format(printf, 2, 3)));

#define ARENA_ARRAY(arena, type, count) ((type *)arena_allocate_zero(arena, sizeof(type) * (size_t)(count)))

/* ---- growing arrays: ARRAY(struct light) lights = {0}; ---- */

#define ARRAY(type)                                                                                                         \
    struct {                                                                                                                \
        type *data;                                                                                                         \
        uint32_t count, capacity;                                                                                           \
    }

/** Makes room for `needed` elements in all. False (and a logged error) when memory ran out. */
bool array_reserve_raw(const fnl_host *host, void **data, uint32_t *capacity, uint64_t needed, size_t element_size);

#define array_reserve(host, array, needed)                                                                                  \
    array_reserve_raw(host, (void **)&(array)->data, &(array)->capacity, needed, sizeof(*(array)->data))
/** Appends `value`; false when memory ran out. */
#define array_push(host, array, value)                                                                                      \
    (array_reserve(host, array, (uint64_t)(array)->count + 1) ? ((array)->data[(array)->count++] = (value), true) : false)
#define array_free(host, array)                                                                                             \
    do {                                                                                                                    \
        host_free(host, (array)->data, sizeof(*(array)->data) * (size_t)(array)->capacity);                                 \
        (array)->data = NULL;                                                                                               \
        (array)->count = (array)->capacity = 0;                                                                             \
    } while (0)

/* ---- hashing ---- */

#define HASH_SEED 0x9e3779b97f4a7c15ull
/** 64-bit hash of bytes, chained through `seed`. Stable across runs; not for untrusted keys. */
uint64_t hash_bytes(const void *data, size_t size, uint64_t seed);

/* ---- deterministic random numbers (SplitMix64, Steele et al. 2014) ---- */

struct random_state {
    uint64_t state;
};
uint64_t random_bits(struct random_state *random);
/** Uniform in [0, 1). */
float random_float(struct random_state *random);
/** Uniform in [low, high). */
float random_range(struct random_state *random, float low, float high);

/* ---- time ---- */

/** Monotonic clock in seconds. */
double time_now(void);

#endif
