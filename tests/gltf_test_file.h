/* SPDX-License-Identifier: MIT */
/** For tests: glTF files put together in memory, and a host that keeps what is logged. */
#ifndef FNL_TESTS_GLTF_TEST_FILE_H
#define FNL_TESTS_GLTF_TEST_FILE_H

#include "scene/scene.h"

struct test_log {
    char text[65536];
    size_t length;
    uint32_t count;
};

static inline void test_log_line(void *user, fnl_log_level level, const char *line) {
    struct test_log *log = user;
    if (level < FNL_LOG_WARNING) return;
    log->count++;
    int written = snprintf(log->text + log->length, sizeof log->text - log->length, "%s\n", line);
    log->length = MIN(log->length + (size_t)written, sizeof log->text - 1);
}

static inline fnl_host test_host(struct test_log *log) {
    log->length = log->count = 0;
    log->text[0] = 0;
    fnl_host host = fnl_host_default();
    host.user = log;
    host.log = test_log_line;
    return host;
}

/** A GLB of a JSON text (without buffers) and a BIN chunk, which becomes buffer 0. Free with free(). */
static inline unsigned char *test_glb(const char *json, const void *binary, size_t binary_size, size_t *size) {
    size_t json_size = (strlen(json) + 3) / 4 * 4, padded = (binary_size + 3) / 4 * 4;
    *size = 12 + 8 + json_size + (binary ? 8 + padded : 0);
    unsigned char *glb = calloc(1, *size);
    uint32_t header[5] = {0x46546c67, 2, (uint32_t)*size, (uint32_t)json_size, 0x4e4f534a};
    memcpy(glb, header, 20);
    memset(glb + 20, ' ', json_size);
    memcpy(glb + 20, json, strlen(json));
    if (binary) {
        uint32_t chunk[2] = {(uint32_t)padded, 0x004e4942};
        memcpy(glb + 20 + json_size, chunk, 8);
        memcpy(glb + 28 + json_size, binary, binary_size);
    }
    return glb;
}

/** Loads such a GLB under the name "test.glb". */
static inline fnl_result test_load_with(struct test_log *log, const fnl_load_params *params, const char *json,
                                        const void *binary, size_t binary_size, fnl_scene **out) {
    size_t size;
    unsigned char *glb = test_glb(json, binary, binary_size, &size);
    fnl_host host = test_host(log);
    fnl_result result = gltf_load_memory(&host, glb, size, "test.glb", params, out);
    free(glb);
    return result;
}

static inline fnl_result test_load(struct test_log *log, const char *json, const void *binary, size_t binary_size,
                                   fnl_scene **out) {
    return test_load_with(log, NULL, json, binary, binary_size, out);
}

/** A PNG of one grey pixel. */
#define TEST_PNG_BASE64                                                                                                     \
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAAC0lEQVR4nGP4DwQACfsD/fteaysAAAAASUVORK5CYII="
static const unsigned char test_png[] = {
    0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44, 0x52, 0x00, 0x00,
    0x00, 0x01, 0x00, 0x00, 0x00, 0x01, 0x08, 0x06, 0x00, 0x00, 0x00, 0x1f, 0x15, 0xc4, 0x89, 0x00, 0x00, 0x00,
    0x0b, 0x49, 0x44, 0x41, 0x54, 0x78, 0x9c, 0x63, 0xf8, 0x0f, 0x04, 0x00, 0x09, 0xfb, 0x03, 0xfd, 0xfb, 0x5e,
    0x6b, 0x2b, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};

#endif
