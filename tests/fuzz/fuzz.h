/* SPDX-License-Identifier: MIT */
/** What the fuzzers share: reading values off the input, and a host that is silent. */
#ifndef FNL_FUZZ_H
#define FNL_FUZZ_H

#include "base/base.h"

#include <float.h>
#include <math.h>
#include <unistd.h>

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size);

static inline void fuzz_drop_line(void *user, fnl_log_level level, const char *line) {
    UNUSED(user);
    UNUSED(level);
    UNUSED(line);
}

static inline fnl_host fuzz_host(void) { return host_resolve(&(fnl_host){.log = fuzz_drop_line}); }

/** What is left of the input; zeros follow when it has ended. */
struct fuzz_input {
    const uint8_t *bytes;
    size_t size;
};

static inline void fuzz_take(struct fuzz_input *in, void *out, size_t size) {
    size_t there = MIN(size, in->size);
    memset(out, 0, size);
    memcpy(out, in->bytes, there);
    in->bytes += there;
    in->size -= there;
}

static inline uint8_t fuzz_byte(struct fuzz_input *in) {
    uint8_t value;
    fuzz_take(in, &value, sizeof value);
    return value;
}

static inline uint32_t fuzz_u32(struct fuzz_input *in) {
    uint32_t value;
    fuzz_take(in, &value, sizeof value);
    return value;
}

/** One of the values that break things, a plain one, or any bits. */
static inline float fuzz_float(struct fuzz_input *in) {
    static const float special[] = {0,       -0.0f,    1,     -1,    NAN,     INFINITY, -INFINITY, FLT_MAX, -FLT_MAX, FLT_MIN,
                                    1e-45f,  FLT_EPSILON, 1e30f, -1e30f, 1e10f,   1e-10f,   0.5f,      3.1415927f, 1.5707964f, 100};
    uint8_t which = fuzz_byte(in);
    if (which < COUNT_OF(special)) return special[which];
    if (which < 128) return ((float)which - 64) / 8;
    uint32_t bits = fuzz_u32(in);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static inline void fuzz_floats(struct fuzz_input *in, float *out, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) out[i] = fuzz_float(in);
}

static inline fnl_vec3 fuzz_vec3(struct fuzz_input *in) {
    float v[3];
    fuzz_floats(in, v, 3);
    return (fnl_vec3){v[0], v[1], v[2]};
}

/** A folder of this process under $TMPDIR, made at the first call; files in it are written over and over. */
static inline const char *fuzz_folder(void) {
    static char folder[256];
    if (!*folder) {
        const char *base = getenv("TMPDIR");
        snprintf(folder, sizeof folder, "%s/fanal-fuzz-XXXXXX", base ? base : "/tmp");
        if (!mkdtemp(folder)) abort();
    }
    return folder;
}

/** Writes a file of that folder; returns its path, which the next call replaces. */
static inline const char *fuzz_file(const char *name, const void *bytes, size_t size) {
    static char path[512];
    snprintf(path, sizeof path, "%s/%s", fuzz_folder(), name);
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(bytes, 1, size, file) != size || fclose(file) != 0) abort();
    return path;
}

#endif
