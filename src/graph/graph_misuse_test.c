/* SPDX-License-Identifier: MIT */
/** Misuse, memory running out, and the cost of compiling, on the null back end. */
#include "tests/graph_cases.h"

/* ---- misuse ---- */

static void test_misuse_of_resources(void **state) {
    UNUSED(state);
    struct graph *graph = make_graph();
    graph_use_image(pass_of(graph, "x"), color_image(graph, "y", 64), GRAPH_SAMPLE_COMPUTE);
    expect_misuse(graph, "graph: pass 'x' reads 'y', which nobody wrote before");

    graph = make_graph();
    graph_color(pass_of(graph, "x"), color_image(graph, "y", 64), VK_ATTACHMENT_LOAD_OP_LOAD, NULL);
    expect_misuse(graph, "graph: pass 'x' reads 'y', which nobody wrote before");

    graph = make_graph();
    graph_image stale = color_image(graph, "y", 64);
    graph_begin(graph);
    color_image(graph, "z", 64);
    graph_use_image(pass_of(graph, "x"), stale, GRAPH_WRITE_COMPUTE);
    expect_misuse(graph, "graph: pass 'x' is given image handle 0x100001 of an earlier frame");

    graph = make_graph();
    graph_use_image(pass_of(graph, "x"), (graph_image){0}, GRAPH_WRITE_COMPUTE);
    expect_misuse(graph, "graph: pass 'x' is given no image (its handle is 0)");

    graph = make_graph();
    graph_use_buffer(pass_of(graph, "x"), (graph_buffer){color_image(graph, "y", 64).id}, GRAPH_WRITE_COMPUTE);
    expect_misuse(graph, "graph: pass 'x' is given 0x100001, which is no buffer handle");

    graph = make_graph();
    graph_use_buffer(pass_of(graph, "x"), graph_create_buffer(graph, "y", 4), GRAPH_SAMPLE_COMPUTE);
    expect_misuse(graph, "graph: pass 'x' uses 'y' as GRAPH_SAMPLE_COMPUTE, which is not for buffers");

    graph = make_graph();
    graph_use_buffer(pass_of(graph, "x"), graph_create_buffer(graph, "y", 4), GRAPH_READ_HOST);
    expect_misuse(graph, "graph: pass 'x': the host cannot read 'y', which is not imported");

    graph = make_graph();
    graph_use_image(async_pass_of(graph, "x"), color_image(graph, "y", 64), GRAPH_SAMPLE_FRAGMENT);
    expect_misuse(graph, "graph: pass 'x' uses 'y' as GRAPH_SAMPLE_FRAGMENT, which a compute queue cannot do");

    graph = make_graph();
    graph_image twice = import_output(graph);
    graph_use_image(pass_of(graph, "x"), twice, GRAPH_WRITE_COMPUTE);
    struct graph_pass *pass = pass_of(graph, "z");
    graph_use_image(pass, twice, GRAPH_READ_COMPUTE);
    graph_use_image(pass, twice, GRAPH_SAMPLE_COMPUTE);
    expect_misuse(graph, "graph: pass 'z' uses 'output' in two layouts at once");

    graph = make_graph();
    color_image(graph, "y", 0);
    expect_misuse(graph, "graph: image 'y' is 0x64 with format 37");

    graph = make_graph();
    import_output(graph);
    graph_import_image(graph, output_image(), VK_IMAGE_LAYOUT_GENERAL, VK_IMAGE_LAYOUT_GENERAL);
    expect_misuse(graph, "graph: image 'output' is imported twice with different layouts");

    graph = make_graph();
    struct graph_image_params params = {.name = "average", .format = VK_FORMAT_R8G8B8A8_UNORM, .width = 64, .height = 64};
    struct graph_pass *accumulate = pass_of(graph, "accumulate");
    graph_use_image(accumulate, graph_history(graph, &params).current, GRAPH_WRITE_COMPUTE);
    graph_keep(accumulate);
    assert_int_equal(graph_compile(graph), FNL_OK);
    graph_begin(graph);
    graph_use_image(pass_of(graph, "x"), graph_history(graph, &params).previous, GRAPH_WRITE_COMPUTE);
    expect_misuse(graph, "graph: pass 'x' writes the previous frame's 'average'");
}

static void test_misuse_of_passes(void **state) {
    UNUSED(state);
    struct graph *graph = make_graph();
    pass_of(graph, "x");
    pass_of(graph, "x");
    expect_misuse(graph, "graph: two passes are called 'x'");

    graph = make_graph();
    struct graph_pass *pass = pass_of(graph, "x");
    graph_color(pass, color_image(graph, "a", 64), VK_ATTACHMENT_LOAD_OP_CLEAR, NULL);
    graph_color(pass, color_image(graph, "b", 32), VK_ATTACHMENT_LOAD_OP_CLEAR, NULL);
    expect_misuse(graph, "graph: pass 'x' has attachments of different sizes: 'a' is 64x64, 1 layers, 1 samples, 'b' is "
                         "32x64, 1 layers, 1 samples");

    graph = make_graph();
    pass = pass_of(graph, "x");
    graph_color(pass, color_image(graph, "a", 64), VK_ATTACHMENT_LOAD_OP_CLEAR, NULL);
    graph_depth(pass, depth_image(graph, "b", 4), VK_ATTACHMENT_LOAD_OP_CLEAR, 0);
    expect_misuse(graph, "'a' is 64x64, 1 layers, 1 samples, 'b' is 64x64, 1 layers, 4 samples");

    graph = make_graph();
    graph_color(pass_of(graph, "x"), depth_image(graph, "a", 1), VK_ATTACHMENT_LOAD_OP_CLEAR, NULL);
    expect_misuse(graph, "graph: pass 'x' takes 'a' as a colour attachment, but its format is 126");

    graph = make_graph();
    graph_depth(async_pass_of(graph, "x"), depth_image(graph, "a", 1), VK_ATTACHMENT_LOAD_OP_CLEAR, 0);
    expect_misuse(graph, "graph: pass 'x' has the attachment 'a', but a compute queue cannot draw");

    graph = make_graph();
    pass = pass_of(graph, "x");
    graph_depth(pass, depth_image(graph, "a", 1), VK_ATTACHMENT_LOAD_OP_CLEAR, 0);
    graph_depth(pass, depth_image(graph, "b", 1), VK_ATTACHMENT_LOAD_OP_CLEAR, 0);
    expect_misuse(graph, "graph: pass 'x' has two depth attachments");

    graph = make_graph();
    pass = pass_of(graph, "x");
    graph_resolve(pass, 0, color_image(graph, "a", 64));
    expect_misuse(graph, "graph: pass 'x' resolves colour attachment 0 into 'a', but it has 0 of them");

    graph = make_graph();
    pass = pass_of(graph, "x");
    graph_color(pass, color_image(graph, "a", 64), VK_ATTACHMENT_LOAD_OP_CLEAR, NULL);
    graph_resolve(pass, 0, color_image(graph, "b", 64));
    expect_misuse(graph, "graph: pass 'x' cannot resolve 'a' (1 samples, format 37) into 'b' (1 samples, format 37)");

    graph = make_graph();
    pass = pass_of(graph, "x");
    for (uint32_t i = 0; i <= GPU_MAX_COLORS; i++)
        graph_color(pass, color_image(graph, "a", 64), VK_ATTACHMENT_LOAD_OP_CLEAR, NULL);
    expect_misuse(graph, "graph: pass 'x' has more than 8 colour attachments");

    graph = make_graph();
    assert_int_equal(graph_execute_frame(graph, NULL), FNL_ERROR_INVALID);
    graph_destroy(&graph);
}

/* ---- memory running out, and cost ---- */

static uint64_t allocations_left;

static void *run_out_of_memory(void *user, void *old, size_t old_size, size_t new_size) {
    if (new_size && allocations_left-- == 0) {
        allocations_left = 0;
        return NULL;
    }
    return count_allocations(user, old, old_size, new_size);
}

/* A frame of `pass_count` passes: draws and dispatches over a few dozen images and buffers. */
static void declare_frame(struct graph *graph, uint32_t pass_count) {
    static char names[400][16];
    graph_image previous = {0}, depth = depth_image(graph, "depth", 1);
    graph_buffer list = graph_create_buffer(graph, "list", 1 << 20);
    for (uint32_t i = 0; i < pass_count; i++) {
        snprintf(names[i], sizeof names[i], "p%u", i);
        struct graph_pass *pass =
            graph_add_pass(graph, names[i], i % 7 == 5 && i % 4 ? GRAPH_QUEUE_ASYNC : GRAPH_QUEUE_GRAPHICS, NULL, names, 64);
        graph_image image = i + 1 == pass_count ? import_output(graph) : color_image(graph, "image", 64 + i % 3);
        if (i % 3 == 0) graph_use_buffer(pass, list, i ? GRAPH_READ_WRITE_COMPUTE : GRAPH_WRITE_COMPUTE);
        if (i % 4 == 0) {
            if (i % 3 == 0) graph_depth(pass, depth, VK_ATTACHMENT_LOAD_OP_CLEAR, 0);
            graph_color(pass, image, VK_ATTACHMENT_LOAD_OP_CLEAR, NULL);
            if (previous.id) graph_use_image(pass, previous, GRAPH_SAMPLE_FRAGMENT);
            if (i % 3 != 0) graph_use_buffer(pass, list, GRAPH_READ_FRAGMENT);
        } else {
            graph_use_image(pass, image, GRAPH_WRITE_COMPUTE);
            if (previous.id) graph_use_image(pass, previous, GRAPH_SAMPLE_COMPUTE);
        }
        previous = image;
    }
}

static void test_running_out_of_memory(void **state) {
    UNUSED(state);
    fnl_host host = {.log = keep_log, .reallocate = run_out_of_memory};
    uint32_t failures = 0;
    for (uint64_t budget = 0;; budget++) {
        allocations_left = budget;
        logged[0] = 0;
        struct graph *graph;
        fnl_result result = graph_create(&host, NULL, &graph);
        if (result == FNL_OK) {
            graph_begin(graph);
            graph_push_names(graph, "left");
            declare_frame(graph, 12);
            graph_pop_names(graph);
            result = graph_compile(graph);
            graph_destroy(&graph);
        }
        if (result == FNL_OK) break;
        assert_true(result == FNL_ERROR_MEMORY || result == FNL_ERROR_INVALID); /* a handle that could not be made is 0 */
        assert_non_null(strstr(logged, "out of memory"));
        failures++;
    }
    assert_true(failures > 4);
}

static void test_compiling_allocates_nothing(void **state) {
    UNUSED(state);
    struct graph *graph = make_graph();
    for (uint32_t frame = 0; frame < 60; frame++) {
        if (frame == 4) allocation_count = 0;
        graph_begin(graph);
        declare_frame(graph, 40);
        assert_int_equal(graph_compile(graph), FNL_OK);
    }
    assert_int_equal(allocation_count, 0);
    struct graph_stats stats = graph_query_stats(graph);
    print_message("%u passes: %u barriers, %u batches, %llu of %llu bytes\n", stats.pass_count,
                  stats.barrier_count, stats.batch_count, (unsigned long long)stats.transient_bytes,
                  (unsigned long long)stats.transient_bytes_unaliased);
    assert_int_equal(stats.pass_count, 40);
    graph_begin(graph);
    declare_frame(graph, 400);
    assert_int_equal(graph_compile(graph), FNL_OK);
    assert_int_equal(graph_query_stats(graph).pass_count, 400);
    graph_destroy(&graph);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_misuse_of_resources),
        cmocka_unit_test(test_misuse_of_passes),
        cmocka_unit_test(test_running_out_of_memory),
        cmocka_unit_test(test_compiling_allocates_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
