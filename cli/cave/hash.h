/* SPDX-License-Identifier: MIT */
/** FNV-1a, 64 bits: what ranks compare. */
#ifndef FNL_CLI_CAVE_HASH_H
#define FNL_CLI_CAVE_HASH_H

#include <stddef.h>
#include <stdint.h>

#define CAVE_HASH_SEED UINT64_C(0xcbf29ce484222325)

static inline uint64_t cave_hash(const void *bytes, size_t size, uint64_t hash) {
    for (size_t i = 0; i < size; i++) hash = (hash ^ ((const uint8_t *)bytes)[i]) * UINT64_C(0x100000001b3);
    return hash;
}

#endif
