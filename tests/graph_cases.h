/* SPDX-License-Identifier: MIT */
/** What tests of plans on the null back end share. */
#ifndef FNL_TESTS_GRAPH_CASES_H
#define FNL_TESTS_GRAPH_CASES_H

#include "graph/graph.h"

#include <setjmp.h>

#include <cmocka.h>

/* ---- a host that keeps the log and counts allocations ---- */

static char logged[8192];
static uint64_t allocation_count;

static inline void keep_log(void *user, fnl_log_level level, const char *line) {
    UNUSED(user);
    UNUSED(level);
    size_t length = strlen(logged);
    snprintf(logged + length, sizeof logged - length, "%s\n", line);
}

static inline void *count_allocations(void *user, void *old, size_t old_size, size_t new_size) {
    UNUSED(user);
    UNUSED(old_size);
    if (new_size == 0) {
        free(old);
        return NULL;
    }
    allocation_count++;
    return realloc(old, new_size);
}

static inline struct graph *make_graph(void) {
    fnl_host host = {.log = keep_log, .reallocate = count_allocations};
    struct graph *graph;
    assert_int_equal(graph_create(&host, NULL, &graph), FNL_OK);
    logged[0] = 0;
    graph_begin(graph);
    return graph;
}

static inline graph_image color_image(struct graph *graph, const char *name, uint32_t width) {
    return graph_create_image(
        graph, &(struct graph_image_params){.name = name, .format = VK_FORMAT_R8G8B8A8_UNORM, .width = width, .height = 64});
}

static inline graph_image depth_image(struct graph *graph, const char *name, uint32_t samples) {
    return graph_create_image(
        graph, &(struct graph_image_params){
                   .name = name, .format = VK_FORMAT_D32_SFLOAT, .width = 64, .height = 64, .samples = samples});
}

/** What a frame is drawn into, from outside. */
static inline struct gpu_image *output_image(void) {
    static struct gpu_image image = {.params = {.name = "output",
                                                .format = VK_FORMAT_R8G8B8A8_UNORM,
                                                .width = 64,
                                                .height = 64,
                                                .layers = 1,
                                                .mips = 1,
                                                .samples = 1}};
    return &image;
}

static inline graph_image import_output(struct graph *graph) {
    return graph_import_image(graph, output_image(), VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
}

static inline struct graph_pass *async_pass_of(struct graph *graph, const char *name) {
    return graph_add_pass(graph, name, GRAPH_QUEUE_ASYNC, NULL, NULL, 0);
}

static inline struct graph_pass *pass_of(struct graph *graph, const char *name) {
    return graph_add_pass(graph, name, GRAPH_QUEUE_GRAPHICS, NULL, NULL, 0);
}

static inline void expect_misuse(struct graph *graph, const char *message) {
    assert_int_equal(graph_compile(graph), FNL_ERROR_INVALID);
    if (!strstr(logged, message)) fail_msg("the log is\n%s\nand lacks\n%s", logged, message);
    char text[100];
    graph_print(graph, text, sizeof text);
    assert_string_equal(text, "no plan: the graph is not compiled\n");
    /* The next frame is not concerned. */
    logged[0] = 0;
    graph_begin(graph);
    assert_int_equal(graph_compile(graph), FNL_OK);
    assert_string_equal(logged, "");
    graph_destroy(&graph);
}

#endif
