/* SPDX-License-Identifier: MIT */
/** For tests: a GLB put together piece by piece. Free what has been put into it with glb_finish(). */
#ifndef FNL_TESTS_GLB_BUILD_H
#define FNL_TESTS_GLB_BUILD_H

#include "tests/gltf_test_file.h"

struct glb_text {
    char *text;
    size_t used, room;
};

struct glb {
    struct glb_text json, views;
    unsigned char *bytes;
    size_t size;
    uint32_t view_count;
};

static inline void glb_add(struct glb_text *t, const char *format, ...) __attribute__((format(printf, 2, 3)));
static inline void glb_add(struct glb_text *t, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    const int more = vsnprintf(NULL, 0, format, arguments);
    va_end(arguments);
    while (t->used + (size_t)more + 1 > t->room) t->text = realloc(t->text, t->room = t->room * 2 + 4096);
    va_start(arguments, format);
    t->used += (size_t)vsnprintf(t->text + t->used, t->room - t->used, format, arguments);
    va_end(arguments);
}

/** Adds a buffer view; returns its index. */
static inline uint32_t glb_view(struct glb *g, const void *data, size_t size) {
    g->bytes = realloc(g->bytes, g->size + size + 4);
    memcpy(g->bytes + g->size, data, size);
    memset(g->bytes + g->size + size, 0, 4);
    glb_add(&g->views, "%s{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu}", g->view_count ? "," : "", g->size, size);
    g->size = (g->size + size + 3) / 4 * 4;
    return g->view_count++;
}

/** Starts the JSON, through the buffer views; add every view first. */
static inline void glb_begin_json(struct glb *g) {
    glb_add(&g->json, "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":%zu}],\"bufferViews\":[%s]", g->size, g->views.text);
}

/** The file; free it with free(). */
static inline unsigned char *glb_finish(struct glb *g, size_t *size) {
    unsigned char *file = test_glb(g->json.text, g->bytes, g->size, size);
    free(g->json.text), free(g->views.text), free(g->bytes);
    *g = (struct glb){0};
    return file;
}

#endif
