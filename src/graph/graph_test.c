/* SPDX-License-Identifier: MIT */
/** Plans as text, on the null back end. graph_misuse_test.c is about mistakes, memory that runs out, and the cost. */
#include "tests/graph_cases.h"

static void expect_plan(struct graph *graph, const char *expected) {
    static char text[16384], again[16384];
    fnl_result result = graph_compile(graph);
    if (result != FNL_OK) fail_msg("not compiled: %s", logged);
    size_t length = graph_print(graph, text, sizeof text);
    assert_true(length < sizeof text && length == strlen(text));
    if (strcmp(text, expected) != 0) {
        print_error("the plan is\n");
        for (char *line = strtok(text, "\n"); line; line = strtok(NULL, "\n")) print_error("%s\n", line);
        fail_msg("it differs from the expected one");
    }
    assert_int_equal(graph_compile(graph), FNL_OK);
    graph_print(graph, again, sizeof again);
    assert_string_equal(text, again);
    char cut[10];
    assert_int_equal(graph_print(graph, cut, sizeof cut), length);
    assert_memory_equal(cut, text, sizeof cut - 1);
    assert_int_equal(cut[9], 0);
    graph_destroy(&graph);
    assert_null(graph);
}

static struct gpu_buffer readback_buffer = {.size = 1024}, lights_buffer = {.size = 4096};

/* ---- plans ---- */

static void test_chain(void **state) {
    UNUSED(state);
    struct graph *graph = make_graph();
    graph_image hdr = color_image(graph, "hdr", 64), depth = depth_image(graph, "depth", 1), output = import_output(graph);
    struct graph_pass *draw = pass_of(graph, "draw");
    graph_color(draw, hdr, VK_ATTACHMENT_LOAD_OP_CLEAR, NULL);
    graph_depth(draw, depth, VK_ATTACHMENT_LOAD_OP_CLEAR, 0);
    struct graph_pass *tonemap = pass_of(graph, "tonemap");
    graph_use_image(tonemap, hdr, GRAPH_SAMPLE_COMPUTE);
    graph_use_image(tonemap, output, GRAPH_WRITE_COMPUTE);
    expect_plan(graph, "2 passes, 0 culled, 5 barriers, 1 batches, 32768 bytes (32768 without aliasing)\n"
                       "batch 0 graphics:\n"
                       "  pass 0 'draw' graphics:\n"
                       "    barrier hdr UNDEFINED->COLOR_ATTACHMENT_OPTIMAL (COLOR_ATTACHMENT_OUTPUT/NONE -> "
                       "COLOR_ATTACHMENT_OUTPUT/COLOR_ATTACHMENT_READ|COLOR_ATTACHMENT_WRITE)\n"
                       "    barrier depth UNDEFINED->DEPTH_ATTACHMENT_OPTIMAL "
                       "(EARLY_FRAGMENT_TESTS|LATE_FRAGMENT_TESTS/NONE -> "
                       "EARLY_FRAGMENT_TESTS|LATE_FRAGMENT_TESTS/DEPTH_ATTACHMENT_READ|DEPTH_ATTACHMENT_WRITE)\n"
                       "    writes hdr in COLOR_ATTACHMENT_OPTIMAL\n"
                       "    writes depth in DEPTH_ATTACHMENT_OPTIMAL\n"
                       "  pass 1 'tonemap' graphics:\n"
                       "    barrier hdr COLOR_ATTACHMENT_OPTIMAL->SHADER_READ_ONLY_OPTIMAL "
                       "(COLOR_ATTACHMENT_OUTPUT/COLOR_ATTACHMENT_WRITE -> COMPUTE_SHADER/SHADER_SAMPLED_READ)\n"
                       "    barrier output UNDEFINED->GENERAL (ALL_COMMANDS/MEMORY_WRITE -> "
                       "COMPUTE_SHADER/SHADER_STORAGE_WRITE)\n"
                       "    reads hdr in SHADER_READ_ONLY_OPTIMAL\n"
                       "    writes output in GENERAL\n"
                       "  at the end: barrier output GENERAL->TRANSFER_SRC_OPTIMAL "
                       "(COMPUTE_SHADER/SHADER_STORAGE_WRITE -> ALL_COMMANDS/MEMORY_READ|MEMORY_WRITE)\n"
                       "memory of images, types 0x1: 32768 bytes\n"
                       "  at 0, 16384 bytes, passes 0 to 1: hdr\n"
                       "  at 16384, 16384 bytes, passes 0 to 0: depth\n");
}

static void test_diamond_merges_reads(void **state) {
    UNUSED(state);
    struct graph *graph = make_graph();
    graph_image a = color_image(graph, "a", 64), b = color_image(graph, "b", 64), c = color_image(graph, "c", 64),
                output = import_output(graph);
    graph_use_image(pass_of(graph, "make a"), a, GRAPH_WRITE_COMPUTE);
    struct graph_pass *left = pass_of(graph, "left"), *right = pass_of(graph, "right"), *join = pass_of(graph, "join");
    graph_use_image(left, a, GRAPH_SAMPLE_COMPUTE);
    graph_use_image(left, b, GRAPH_WRITE_COMPUTE);
    graph_color(right, c, VK_ATTACHMENT_LOAD_OP_DONT_CARE, NULL);
    graph_use_image(right, a, GRAPH_SAMPLE_FRAGMENT);
    graph_use_image(join, b, GRAPH_SAMPLE_COMPUTE);
    graph_use_image(join, c, GRAPH_SAMPLE_COMPUTE);
    graph_use_image(join, output, GRAPH_WRITE_COMPUTE);
    expect_plan(graph, "4 passes, 0 culled, 8 barriers, 1 batches, 49152 bytes (49152 without aliasing)\n"
                       "batch 0 graphics:\n"
                       "  pass 0 'make a' graphics:\n"
                       "    barrier a UNDEFINED->GENERAL (COMPUTE_SHADER/NONE -> "
                       "COMPUTE_SHADER/SHADER_STORAGE_WRITE)\n"
                       "    writes a in GENERAL\n"
                       "  pass 1 'left' graphics:\n"
                       "    barrier a GENERAL->SHADER_READ_ONLY_OPTIMAL (COMPUTE_SHADER/SHADER_STORAGE_WRITE -> "
                       "FRAGMENT_SHADER|COMPUTE_SHADER/SHADER_SAMPLED_READ)\n"
                       "    barrier b UNDEFINED->GENERAL (COMPUTE_SHADER/NONE -> "
                       "COMPUTE_SHADER/SHADER_STORAGE_WRITE)\n"
                       "    reads a in SHADER_READ_ONLY_OPTIMAL\n"
                       "    writes b in GENERAL\n"
                       "  pass 2 'right' graphics:\n"
                       "    barrier c UNDEFINED->COLOR_ATTACHMENT_OPTIMAL (COLOR_ATTACHMENT_OUTPUT/NONE -> "
                       "COLOR_ATTACHMENT_OUTPUT/COLOR_ATTACHMENT_READ|COLOR_ATTACHMENT_WRITE)\n"
                       "    writes c in COLOR_ATTACHMENT_OPTIMAL\n"
                       "    reads a in SHADER_READ_ONLY_OPTIMAL\n"
                       "  pass 3 'join' graphics:\n"
                       "    barrier b GENERAL->SHADER_READ_ONLY_OPTIMAL (COMPUTE_SHADER/SHADER_STORAGE_WRITE -> "
                       "COMPUTE_SHADER/SHADER_SAMPLED_READ)\n"
                       "    barrier c COLOR_ATTACHMENT_OPTIMAL->SHADER_READ_ONLY_OPTIMAL "
                       "(COLOR_ATTACHMENT_OUTPUT/COLOR_ATTACHMENT_WRITE -> COMPUTE_SHADER/SHADER_SAMPLED_READ)\n"
                       "    barrier output UNDEFINED->GENERAL (ALL_COMMANDS/MEMORY_WRITE -> "
                       "COMPUTE_SHADER/SHADER_STORAGE_WRITE)\n"
                       "    reads b in SHADER_READ_ONLY_OPTIMAL\n"
                       "    reads c in SHADER_READ_ONLY_OPTIMAL\n"
                       "    writes output in GENERAL\n"
                       "  at the end: barrier output GENERAL->TRANSFER_SRC_OPTIMAL "
                       "(COMPUTE_SHADER/SHADER_STORAGE_WRITE -> ALL_COMMANDS/MEMORY_READ|MEMORY_WRITE)\n"
                       "memory of images, types 0x1: 49152 bytes\n"
                       "  at 0, 16384 bytes, passes 0 to 2: a\n"
                       "  at 16384, 16384 bytes, passes 1 to 3: b\n"
                       "  at 32768, 16384 bytes, passes 2 to 3: c\n");
}

/* Draws, shaders and copies that read a buffer one after the other wait once for who wrote it. */
static void test_readers_of_all_kinds_wait_once(void **state) {
    UNUSED(state);
    static const enum graph_use uses[] = {GRAPH_INDIRECT, GRAPH_READ_VERTEX, GRAPH_READ_COMPUTE, GRAPH_COPY_FROM};
    static const char *const names[] = {"indirect", "vertex", "compute", "copy"};
    struct graph *graph = make_graph();
    graph_buffer list = graph_create_buffer(graph, "list", 256);
    graph_use_buffer(pass_of(graph, "fill"), list, GRAPH_WRITE_COMPUTE);
    for (uint32_t i = 0; i < COUNT_OF(uses); i++) {
        struct graph_pass *pass = pass_of(graph, names[i]);
        graph_use_buffer(pass, list, uses[i]);
        graph_keep(pass);
    }
    expect_plan(graph, "5 passes, 0 culled, 1 barriers, 1 batches, 256 bytes (256 without aliasing)\n"
                       "batch 0 graphics:\n"
                       "  pass 0 'fill' graphics:\n"
                       "    writes list\n"
                       "  pass 1 'indirect' graphics:\n"
                       "    barrier memory of list (COMPUTE_SHADER/SHADER_STORAGE_WRITE -> "
                       "DRAW_INDIRECT|VERTEX_SHADER|COMPUTE_SHADER|ALL_TRANSFER/"
                       "INDIRECT_COMMAND_READ|SHADER_STORAGE_READ|TRANSFER_READ)\n"
                       "    reads list\n"
                       "  pass 2 'vertex' graphics:\n"
                       "    reads list\n"
                       "  pass 3 'compute' graphics:\n"
                       "    reads list\n"
                       "  pass 4 'copy' graphics:\n"
                       "    reads list\n"
                       "memory of buffers, types 0x1: 256 bytes\n"
                       "  at 0, 256 bytes, passes 0 to 4: list\n");
}

static void test_buffers_share_one_barrier_and_reads_hold_back_writes(void **state) {
    UNUSED(state);
    struct graph *graph = make_graph();
    graph_buffer counts = graph_create_buffer(graph, "counts", 256), list = graph_create_buffer(graph, "list", 1000);
    graph_buffer lights = graph_import_buffer(graph, "lights", &lights_buffer),
                 readback = graph_import_buffer(graph, "readback", &readback_buffer);
    struct graph_pass *clear = pass_of(graph, "clear"), *count = pass_of(graph, "count"), *fill = pass_of(graph, "fill");
    struct graph_pass *again = pass_of(graph, "clear again"), *copy = pass_of(graph, "copy");
    graph_use_buffer(clear, counts, GRAPH_COPY_TO);
    graph_use_buffer(count, lights, GRAPH_READ_COMPUTE);
    graph_use_buffer(count, counts, GRAPH_READ_WRITE_COMPUTE);
    graph_use_buffer(count, list, GRAPH_WRITE_COMPUTE);
    graph_use_buffer(fill, counts, GRAPH_INDIRECT);
    graph_use_buffer(fill, list, GRAPH_READ_WRITE_COMPUTE);
    graph_use_buffer(again, counts, GRAPH_COPY_TO);
    graph_use_buffer(copy, counts, GRAPH_COPY_FROM);
    graph_use_buffer(copy, list, GRAPH_COPY_FROM);
    graph_use_buffer(copy, readback, GRAPH_COPY_TO);
    graph_use_buffer(copy, readback, GRAPH_READ_HOST);
    expect_plan(graph, "5 passes, 0 culled, 5 barriers, 1 batches, 1280 bytes (1280 without aliasing)\n"
                       "batch 0 graphics:\n"
                       "  pass 0 'clear' graphics:\n"
                       "    writes counts\n"
                       "  pass 1 'count' graphics:\n"
                       "    barrier memory of counts (ALL_TRANSFER/TRANSFER_WRITE -> "
                       "COMPUTE_SHADER/SHADER_STORAGE_READ|SHADER_STORAGE_WRITE)\n"
                       "    reads lights\n"
                       "    reads, writes counts\n"
                       "    writes list\n"
                       "  pass 2 'fill' graphics:\n"
                       "    barrier memory of counts, list (COMPUTE_SHADER/SHADER_STORAGE_WRITE -> "
                       "DRAW_INDIRECT|COMPUTE_SHADER/INDIRECT_COMMAND_READ|SHADER_STORAGE_READ|"
                       "SHADER_STORAGE_WRITE)\n"
                       "    reads counts\n"
                       "    reads, writes list\n"
                       "  pass 3 'clear again' graphics:\n"
                       "    barrier memory of counts (DRAW_INDIRECT/NONE -> ALL_TRANSFER/TRANSFER_WRITE)\n"
                       "    writes counts\n"
                       "  pass 4 'copy' graphics:\n"
                       "    barrier memory of counts, list "
                       "(COMPUTE_SHADER|ALL_TRANSFER/SHADER_STORAGE_WRITE|TRANSFER_WRITE -> "
                       "ALL_TRANSFER/TRANSFER_READ)\n"
                       "    reads counts\n"
                       "    reads list\n"
                       "    writes readback\n"
                       "  at the end: barrier memory of readback (ALL_TRANSFER/TRANSFER_WRITE -> HOST/HOST_READ)\n"
                       "memory of buffers, types 0x1: 1280 bytes\n"
                       "  at 0, 1000 bytes, passes 1 to 4: list\n"
                       "  at 1024, 256 bytes, passes 0 to 4: counts\n");
}

static void test_culling(void **state) {
    UNUSED(state);
    struct graph *graph = make_graph();
    graph_image unused = color_image(graph, "unused", 64), feeds = color_image(graph, "feeds", 64),
                replaced = color_image(graph, "replaced", 64);
    graph_buffer kept = graph_create_buffer(graph, "kept", 64);
    graph_image output = import_output(graph);
    graph_use_image(pass_of(graph, "feeds unused"), feeds, GRAPH_WRITE_COMPUTE);
    struct graph_pass *dead = pass_of(graph, "unused");
    graph_use_image(dead, feeds, GRAPH_SAMPLE_COMPUTE);
    graph_use_image(dead, unused, GRAPH_WRITE_COMPUTE);
    graph_color(pass_of(graph, "overdrawn"), replaced, VK_ATTACHMENT_LOAD_OP_CLEAR, NULL);
    graph_color(pass_of(graph, "clears"), replaced, VK_ATTACHMENT_LOAD_OP_CLEAR, NULL);
    graph_color(pass_of(graph, "adds"), replaced, VK_ATTACHMENT_LOAD_OP_LOAD, NULL);
    struct graph_pass *copy = pass_of(graph, "copy");
    graph_use_image(copy, replaced, GRAPH_COPY_FROM);
    graph_use_image(copy, output, GRAPH_COPY_TO);
    struct graph_pass *probe = pass_of(graph, "probe");
    graph_use_buffer(probe, kept, GRAPH_WRITE_COMPUTE);
    graph_keep(probe);
    expect_plan(graph, "4 passes, 3 culled, 5 barriers, 1 batches, 16448 bytes (16640 without aliasing)\n"
                       "batch 0 graphics:\n"
                       "  pass 0 'clears' graphics:\n"
                       "    barrier replaced UNDEFINED->COLOR_ATTACHMENT_OPTIMAL (COLOR_ATTACHMENT_OUTPUT/NONE -> "
                       "COLOR_ATTACHMENT_OUTPUT/COLOR_ATTACHMENT_READ|COLOR_ATTACHMENT_WRITE)\n"
                       "    writes replaced in COLOR_ATTACHMENT_OPTIMAL\n"
                       "  pass 1 'adds' graphics:\n"
                       "    barrier replaced COLOR_ATTACHMENT_OPTIMAL "
                       "(COLOR_ATTACHMENT_OUTPUT/COLOR_ATTACHMENT_WRITE -> "
                       "COLOR_ATTACHMENT_OUTPUT/COLOR_ATTACHMENT_READ|COLOR_ATTACHMENT_WRITE)\n"
                       "    reads, writes replaced in COLOR_ATTACHMENT_OPTIMAL\n"
                       "  pass 2 'copy' graphics:\n"
                       "    barrier replaced COLOR_ATTACHMENT_OPTIMAL->TRANSFER_SRC_OPTIMAL "
                       "(COLOR_ATTACHMENT_OUTPUT/COLOR_ATTACHMENT_WRITE -> ALL_TRANSFER/TRANSFER_READ)\n"
                       "    barrier output UNDEFINED->TRANSFER_DST_OPTIMAL (ALL_COMMANDS/MEMORY_WRITE -> "
                       "ALL_TRANSFER/TRANSFER_WRITE)\n"
                       "    reads replaced in TRANSFER_SRC_OPTIMAL\n"
                       "    writes output in TRANSFER_DST_OPTIMAL\n"
                       "  pass 3 'probe' graphics:\n"
                       "    writes kept\n"
                       "  at the end: barrier output TRANSFER_DST_OPTIMAL->TRANSFER_SRC_OPTIMAL "
                       "(ALL_TRANSFER/TRANSFER_WRITE -> ALL_COMMANDS/MEMORY_READ|MEMORY_WRITE)\n"
                       "memory of images, types 0x1: 16384 bytes\n"
                       "  at 0, 16384 bytes, passes 0 to 2: replaced\n"
                       "memory of buffers, types 0x1: 64 bytes\n"
                       "  at 0, 64 bytes, passes 3 to 3: kept\n");
}

static void test_aliasing(void **state) {
    UNUSED(state);
    struct graph *graph = make_graph();
    graph_image chain[4] = {color_image(graph, "a", 64), color_image(graph, "b", 32), color_image(graph, "c", 64),
                            color_image(graph, "d", 32)};
    const char *names[4] = {"write a", "a to b", "b to c", "c to d"};
    for (uint32_t i = 0; i < 4; i++) {
        struct graph_pass *pass = pass_of(graph, names[i]);
        if (i > 0) graph_use_image(pass, chain[i - 1], GRAPH_SAMPLE_COMPUTE);
        graph_use_image(pass, chain[i], GRAPH_WRITE_COMPUTE);
    }
    struct graph_pass *last = pass_of(graph, "d to output");
    graph_use_image(last, chain[3], GRAPH_SAMPLE_COMPUTE);
    graph_use_image(last, import_output(graph), GRAPH_WRITE_COMPUTE);
    expect_plan(graph, "5 passes, 0 culled, 10 barriers, 1 batches, 24576 bytes (49152 without aliasing)\n"
                       "batch 0 graphics:\n"
                       "  pass 0 'write a' graphics:\n"
                       "    barrier a UNDEFINED->GENERAL (COMPUTE_SHADER/NONE -> "
                       "COMPUTE_SHADER/SHADER_STORAGE_WRITE)\n"
                       "    writes a in GENERAL\n"
                       "  pass 1 'a to b' graphics:\n"
                       "    barrier a GENERAL->SHADER_READ_ONLY_OPTIMAL (COMPUTE_SHADER/SHADER_STORAGE_WRITE -> "
                       "COMPUTE_SHADER/SHADER_SAMPLED_READ)\n"
                       "    barrier b UNDEFINED->GENERAL (COMPUTE_SHADER/NONE -> "
                       "COMPUTE_SHADER/SHADER_STORAGE_WRITE)\n"
                       "    reads a in SHADER_READ_ONLY_OPTIMAL\n"
                       "    writes b in GENERAL\n"
                       "  pass 2 'b to c' graphics:\n"
                       "    barrier b GENERAL->SHADER_READ_ONLY_OPTIMAL (COMPUTE_SHADER/SHADER_STORAGE_WRITE -> "
                       "COMPUTE_SHADER/SHADER_SAMPLED_READ)\n"
                       "    barrier c UNDEFINED->GENERAL (COMPUTE_SHADER/NONE -> "
                       "COMPUTE_SHADER/SHADER_STORAGE_WRITE)\n"
                       "    reads b in SHADER_READ_ONLY_OPTIMAL\n"
                       "    writes c in GENERAL\n"
                       "  pass 3 'c to d' graphics:\n"
                       "    barrier c GENERAL->SHADER_READ_ONLY_OPTIMAL (COMPUTE_SHADER/SHADER_STORAGE_WRITE -> "
                       "COMPUTE_SHADER/SHADER_SAMPLED_READ)\n"
                       "    barrier d UNDEFINED->GENERAL (COMPUTE_SHADER/NONE -> "
                       "COMPUTE_SHADER/SHADER_STORAGE_WRITE)\n"
                       "    reads c in SHADER_READ_ONLY_OPTIMAL\n"
                       "    writes d in GENERAL\n"
                       "  pass 4 'd to output' graphics:\n"
                       "    barrier d GENERAL->SHADER_READ_ONLY_OPTIMAL (COMPUTE_SHADER/SHADER_STORAGE_WRITE -> "
                       "COMPUTE_SHADER/SHADER_SAMPLED_READ)\n"
                       "    barrier output UNDEFINED->GENERAL (ALL_COMMANDS/MEMORY_WRITE -> "
                       "COMPUTE_SHADER/SHADER_STORAGE_WRITE)\n"
                       "    reads d in SHADER_READ_ONLY_OPTIMAL\n"
                       "    writes output in GENERAL\n"
                       "  at the end: barrier output GENERAL->TRANSFER_SRC_OPTIMAL "
                       "(COMPUTE_SHADER/SHADER_STORAGE_WRITE -> ALL_COMMANDS/MEMORY_READ|MEMORY_WRITE)\n"
                       "memory of images, types 0x1: 24576 bytes\n"
                       "  at 0, 16384 bytes, passes 0 to 1: a\n"
                       "  at 0, 16384 bytes, passes 2 to 3: c\n"
                       "  at 16384, 8192 bytes, passes 1 to 2: b\n"
                       "  at 16384, 8192 bytes, passes 3 to 4: d\n");
}

static void test_resolve_and_depth_read_by_its_own_pass(void **state) {
    UNUSED(state);
    struct graph *graph = make_graph();
    struct graph_image_params params = {
        .name = "color 4x", .format = VK_FORMAT_R8G8B8A8_UNORM, .width = 64, .height = 64, .samples = 4};
    graph_image color = graph_create_image(graph, &params), depth = depth_image(graph, "depth 4x", 4),
                output = import_output(graph);
    graph_depth(pass_of(graph, "prepass"), depth, VK_ATTACHMENT_LOAD_OP_CLEAR, 0);
    struct graph_pass *shade = pass_of(graph, "shade");
    graph_color(shade, color, VK_ATTACHMENT_LOAD_OP_CLEAR, (float[4]){0, 0, 0, 1});
    graph_resolve(shade, 0, output);
    graph_depth_read_only(shade, depth);
    graph_use_image(shade, depth, GRAPH_SAMPLE_FRAGMENT);
    expect_plan(graph, "2 passes, 0 culled, 5 barriers, 1 batches, 131072 bytes (131072 without aliasing)\n"
                       "batch 0 graphics:\n"
                       "  pass 0 'prepass' graphics:\n"
                       "    barrier depth 4x UNDEFINED->DEPTH_ATTACHMENT_OPTIMAL "
                       "(EARLY_FRAGMENT_TESTS|LATE_FRAGMENT_TESTS/NONE -> "
                       "EARLY_FRAGMENT_TESTS|LATE_FRAGMENT_TESTS/DEPTH_ATTACHMENT_READ|DEPTH_ATTACHMENT_WRITE)\n"
                       "    writes depth 4x in DEPTH_ATTACHMENT_OPTIMAL\n"
                       "  pass 1 'shade' graphics:\n"
                       "    barrier color 4x UNDEFINED->COLOR_ATTACHMENT_OPTIMAL (COLOR_ATTACHMENT_OUTPUT/NONE -> "
                       "COLOR_ATTACHMENT_OUTPUT/COLOR_ATTACHMENT_READ|COLOR_ATTACHMENT_WRITE)\n"
                       "    barrier output UNDEFINED->COLOR_ATTACHMENT_OPTIMAL (ALL_COMMANDS/MEMORY_WRITE -> "
                       "COLOR_ATTACHMENT_OUTPUT/COLOR_ATTACHMENT_READ|COLOR_ATTACHMENT_WRITE)\n"
                       "    barrier depth 4x DEPTH_ATTACHMENT_OPTIMAL->DEPTH_READ_ONLY_OPTIMAL "
                       "(EARLY_FRAGMENT_TESTS|LATE_FRAGMENT_TESTS/DEPTH_ATTACHMENT_WRITE -> "
                       "EARLY_FRAGMENT_TESTS|FRAGMENT_SHADER|LATE_FRAGMENT_TESTS/SHADER_SAMPLED_READ|"
                       "DEPTH_ATTACHMENT_READ)\n"
                       "    writes color 4x in COLOR_ATTACHMENT_OPTIMAL\n"
                       "    writes output in COLOR_ATTACHMENT_OPTIMAL\n"
                       "    reads depth 4x in DEPTH_READ_ONLY_OPTIMAL\n"
                       "  at the end: barrier output COLOR_ATTACHMENT_OPTIMAL->TRANSFER_SRC_OPTIMAL "
                       "(COLOR_ATTACHMENT_OUTPUT/COLOR_ATTACHMENT_WRITE -> ALL_COMMANDS/MEMORY_READ|MEMORY_WRITE)\n"
                       "memory of images, types 0x1: 131072 bytes\n"
                       "  at 0, 65536 bytes, passes 0 to 1: depth 4x\n"
                       "  at 65536, 65536 bytes, passes 1 to 1: color 4x\n");
}

static void test_async(void **state) {
    UNUSED(state);
    struct graph *graph = make_graph();
    graph_image depth = depth_image(graph, "depth", 1), shadow = depth_image(graph, "shadow", 1),
                hdr = color_image(graph, "hdr", 64);
    graph_buffer lists = graph_create_buffer(graph, "lists", 4096);
    graph_depth(pass_of(graph, "prepass"), depth, VK_ATTACHMENT_LOAD_OP_CLEAR, 0);
    struct graph_pass *cull = async_pass_of(graph, "light lists");
    graph_use_image(cull, depth, GRAPH_SAMPLE_COMPUTE);
    graph_use_buffer(cull, lists, GRAPH_WRITE_COMPUTE);
    graph_depth(pass_of(graph, "shadows"), shadow, VK_ATTACHMENT_LOAD_OP_CLEAR, 0);
    struct graph_pass *shade = pass_of(graph, "shade");
    graph_color(shade, hdr, VK_ATTACHMENT_LOAD_OP_CLEAR, NULL);
    graph_depth_read_only(shade, depth);
    graph_use_image(shade, shadow, GRAPH_SAMPLE_FRAGMENT);
    graph_use_buffer(shade, lists, GRAPH_READ_FRAGMENT);
    struct graph_pass *post = async_pass_of(graph, "post");
    graph_use_image(post, hdr, GRAPH_SAMPLE_COMPUTE);
    graph_use_image(post, import_output(graph), GRAPH_WRITE_COMPUTE);
    expect_plan(graph, "5 passes, 0 culled, 8 barriers, 7 batches, 53248 bytes (53248 without aliasing)\n"
                       "batch 0 graphics:\n"
                       "batch 1 graphics:\n"
                       "  pass 0 'prepass' graphics:\n"
                       "    barrier depth UNDEFINED->DEPTH_ATTACHMENT_OPTIMAL "
                       "(EARLY_FRAGMENT_TESTS|LATE_FRAGMENT_TESTS/NONE -> "
                       "EARLY_FRAGMENT_TESTS|LATE_FRAGMENT_TESTS/DEPTH_ATTACHMENT_READ|DEPTH_ATTACHMENT_WRITE)\n"
                       "    writes depth in DEPTH_ATTACHMENT_OPTIMAL\n"
                       "  at the end: barrier depth DEPTH_ATTACHMENT_OPTIMAL->DEPTH_READ_ONLY_OPTIMAL "
                       "(EARLY_FRAGMENT_TESTS|LATE_FRAGMENT_TESTS/DEPTH_ATTACHMENT_WRITE -> "
                       "ALL_COMMANDS/MEMORY_READ)\n"
                       "batch 2 compute, waits for batch 1:\n"
                       "  pass 1 'light lists' compute:\n"
                       "    reads depth in DEPTH_READ_ONLY_OPTIMAL\n"
                       "    writes lists\n"
                       "batch 3 graphics:\n"
                       "  pass 2 'shadows' graphics:\n"
                       "    barrier shadow UNDEFINED->DEPTH_ATTACHMENT_OPTIMAL "
                       "(EARLY_FRAGMENT_TESTS|LATE_FRAGMENT_TESTS/NONE -> "
                       "EARLY_FRAGMENT_TESTS|LATE_FRAGMENT_TESTS/DEPTH_ATTACHMENT_READ|DEPTH_ATTACHMENT_WRITE)\n"
                       "    writes shadow in DEPTH_ATTACHMENT_OPTIMAL\n"
                       "batch 4 graphics, waits for batch 2:\n"
                       "  pass 3 'shade' graphics:\n"
                       "    barrier hdr UNDEFINED->COLOR_ATTACHMENT_OPTIMAL (COLOR_ATTACHMENT_OUTPUT/NONE -> "
                       "COLOR_ATTACHMENT_OUTPUT/COLOR_ATTACHMENT_READ|COLOR_ATTACHMENT_WRITE)\n"
                       "    barrier shadow DEPTH_ATTACHMENT_OPTIMAL->DEPTH_READ_ONLY_OPTIMAL "
                       "(EARLY_FRAGMENT_TESTS|LATE_FRAGMENT_TESTS/DEPTH_ATTACHMENT_WRITE -> "
                       "FRAGMENT_SHADER/SHADER_SAMPLED_READ)\n"
                       "    writes hdr in COLOR_ATTACHMENT_OPTIMAL\n"
                       "    reads depth in DEPTH_READ_ONLY_OPTIMAL\n"
                       "    reads shadow in DEPTH_READ_ONLY_OPTIMAL\n"
                       "    reads lists\n"
                       "  at the end: barrier hdr COLOR_ATTACHMENT_OPTIMAL->SHADER_READ_ONLY_OPTIMAL "
                       "(COLOR_ATTACHMENT_OUTPUT/COLOR_ATTACHMENT_WRITE -> ALL_COMMANDS/MEMORY_READ)\n"
                       "batch 5 compute, waits for batch 4:\n"
                       "  pass 4 'post' compute:\n"
                       "    barrier output UNDEFINED->GENERAL (COMPUTE_SHADER/NONE -> "
                       "COMPUTE_SHADER/SHADER_STORAGE_WRITE)\n"
                       "    reads hdr in SHADER_READ_ONLY_OPTIMAL\n"
                       "    writes output in GENERAL\n"
                       "batch 6 graphics, waits for batch 5:\n"
                       "  at the end: barrier output GENERAL->TRANSFER_SRC_OPTIMAL (ALL_COMMANDS/MEMORY_WRITE -> "
                       "ALL_COMMANDS/MEMORY_READ|MEMORY_WRITE)\n"
                       "memory of images, types 0x1: 49152 bytes\n"
                       "  at 0, 16384 bytes, passes 0 to 4: depth\n"
                       "  at 16384, 16384 bytes, passes 0 to 4: hdr\n"
                       "  at 32768, 16384 bytes, passes 2 to 3: shadow\n"
                       "memory of buffers, types 0x1: 4096 bytes\n"
                       "  at 0, 4096 bytes, passes 0 to 4: lists\n");
}

static void declare_history(struct graph *graph, uint32_t width, bool write) {
    struct graph_image_params params = {.name = "average", .format = VK_FORMAT_R8G8B8A8_UNORM, .width = width, .height = 64};
    struct graph_history history = graph_history(graph, &params);
    struct graph_pass *pass = pass_of(graph, "accumulate");
    if (history.previous.id) graph_use_image(pass, history.previous, GRAPH_SAMPLE_COMPUTE);
    if (write) graph_use_image(pass, history.current, GRAPH_WRITE_COMPUTE);
    graph_keep(pass);
}

static bool has_previous(struct graph *graph, uint32_t width, bool write) {
    graph_begin(graph);
    struct graph_image_params params = {.name = "average", .format = VK_FORMAT_R8G8B8A8_UNORM, .width = width, .height = 64};
    struct graph_history first = graph_history(graph, &params), second = graph_history(graph, &params);
    assert_true(first.current.id != 0 && first.current.id == second.current.id && first.previous.id == second.previous.id);
    declare_history(graph, width, write);
    assert_int_equal(graph_compile(graph), FNL_OK);
    return first.previous.id != 0;
}

static void test_history(void **state) {
    UNUSED(state);
    struct graph *graph = make_graph();
    assert_false(has_previous(graph, 64, true)); /* the first frame */
    assert_true(has_previous(graph, 64, true));
    assert_false(has_previous(graph, 32, true)); /* another size */
    assert_true(has_previous(graph, 32, false));
    assert_false(has_previous(graph, 32, true)); /* nobody wrote it in the last frame */
    graph_begin(graph);
    assert_false(has_previous(graph, 32, true)); /* not used in the last frame */
    for (uint32_t i = 0; i < 6; i++) graph_begin(graph);
    assert_false(has_previous(graph, 32, true));
    graph_begin(graph);
    declare_history(graph, 32, true);
    expect_plan(graph, "1 passes, 0 culled, 2 barriers, 1 batches, 0 bytes (0 without aliasing)\n"
                       "batch 0 graphics:\n"
                       "  pass 0 'accumulate' graphics:\n"
                       "    barrier average (previous) GENERAL->SHADER_READ_ONLY_OPTIMAL (COMPUTE_SHADER/SHADER_STORAGE_WRITE -> "
                       "COMPUTE_SHADER/SHADER_SAMPLED_READ)\n"
                       "    barrier average UNDEFINED->GENERAL (COMPUTE_SHADER/NONE -> "
                       "COMPUTE_SHADER/SHADER_STORAGE_WRITE)\n"
                       "    reads average (previous) in SHADER_READ_ONLY_OPTIMAL\n"
                       "    writes average in GENERAL\n");
}

static void test_imports(void **state) {
    UNUSED(state);
    struct graph *graph = make_graph();
    struct gpu_image untouched_image = *output_image(), texture_image = *output_image();
    untouched_image.params.name = "untouched";
    texture_image.params.name = "texture";
    graph_import_image(graph, &untouched_image, VK_IMAGE_LAYOUT_GENERAL, VK_IMAGE_LAYOUT_PRESENT_SRC_KHR);
    graph_image texture =
        graph_import_image(graph, &texture_image, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, VK_IMAGE_LAYOUT_UNDEFINED);
    graph_image same =
        graph_import_image(graph, &texture_image, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, VK_IMAGE_LAYOUT_UNDEFINED);
    assert_int_equal(texture.id, same.id);
    graph_buffer lights = graph_import_buffer(graph, "lights", &lights_buffer);
    assert_int_equal(lights.id, graph_import_buffer(graph, "lights", &lights_buffer).id);
    assert_int_equal(graph_buffer_size(graph, lights), 4096);
    assert_int_equal(graph_image_info(graph, texture).samples, 1);
    struct graph_pass *draw = pass_of(graph, "draw");
    graph_use_image(draw, texture, GRAPH_SAMPLE_FRAGMENT);
    graph_use_buffer(draw, lights, GRAPH_READ_FRAGMENT);
    graph_color(draw, import_output(graph), VK_ATTACHMENT_LOAD_OP_CLEAR, NULL);
    expect_plan(graph, "1 passes, 0 culled, 4 barriers, 1 batches, 0 bytes (0 without aliasing)\n"
                       "batch 0 graphics:\n"
                       "  pass 0 'draw' graphics:\n"
                       "    barrier texture SHADER_READ_ONLY_OPTIMAL (ALL_COMMANDS/MEMORY_WRITE -> "
                       "FRAGMENT_SHADER/SHADER_SAMPLED_READ)\n"
                       "    barrier output UNDEFINED->COLOR_ATTACHMENT_OPTIMAL (ALL_COMMANDS/MEMORY_WRITE -> "
                       "COLOR_ATTACHMENT_OUTPUT/COLOR_ATTACHMENT_READ|COLOR_ATTACHMENT_WRITE)\n"
                       "    reads texture in SHADER_READ_ONLY_OPTIMAL\n"
                       "    reads lights\n"
                       "    writes output in COLOR_ATTACHMENT_OPTIMAL\n"
                       "  at the end: barrier untouched GENERAL->PRESENT_SRC (ALL_COMMANDS/MEMORY_WRITE -> "
                       "ALL_COMMANDS/MEMORY_READ|MEMORY_WRITE)\n"
                       "  at the end: barrier output COLOR_ATTACHMENT_OPTIMAL->TRANSFER_SRC_OPTIMAL "
                       "(COLOR_ATTACHMENT_OUTPUT/COLOR_ATTACHMENT_WRITE -> ALL_COMMANDS/MEMORY_READ|MEMORY_WRITE)\n");
}

/* ---- from frame to frame ---- */

/* Culls into a list, draws it, and tone maps into the output; the lights change in some frames. */
static void declare_usual_frame(struct graph *graph, bool lights_change) {
    static const struct gpu_buffer lights = {.size = 64};
    graph_begin(graph);
    graph_buffer imported = graph_import_buffer(graph, "lights", &lights), list = graph_create_buffer(graph, "list", 256);
    graph_image hdr = color_image(graph, "hdr", 64), output = import_output(graph);
    if (lights_change) {
        struct graph_pass *send = pass_of(graph, "send");
        graph_use_buffer(send, imported, GRAPH_COPY_TO);
    }
    struct graph_pass *cull = pass_of(graph, "cull");
    graph_use_buffer(cull, imported, GRAPH_READ_COMPUTE);
    graph_use_buffer(cull, list, GRAPH_WRITE_COMPUTE);
    struct graph_pass *draw = pass_of(graph, "draw");
    graph_use_buffer(draw, list, GRAPH_READ_FRAGMENT);
    graph_color(draw, hdr, VK_ATTACHMENT_LOAD_OP_DONT_CARE, NULL);
    struct graph_pass *tonemap = pass_of(graph, "tonemap");
    graph_use_image(tonemap, hdr, GRAPH_SAMPLE_COMPUTE);
    graph_use_image(tonemap, output, GRAPH_WRITE_COMPUTE);
}

/* What a pass waits for before it begins; "" for nothing. */
static const char *waits_of(struct graph *graph, const char *pass) {
    static char text[1 << 14], waits[2048];
    char head[64];
    assert_int_equal(graph_compile(graph), FNL_OK);
    assert_true(graph_print(graph, text, sizeof text) < sizeof text);
    int length = snprintf(head, sizeof head, "'%s' graphics:\n", pass);
    const char *begin = strstr(text, head);
    assert_non_null(begin);
    begin += length;
    const char *end = begin;
    while (strncmp(end, "    barrier ", 12) == 0) end = strchr(end, '\n') + 1;
    snprintf(waits, sizeof waits, "%.*s", (int)(end - begin), begin);
    return waits;
}

/* The first pass of a frame waits for nothing of the last one; those that take its images wait for whoever looked at these. */
static void test_a_frame_waits_for_named_resources_alone(void **state) {
    UNUSED(state);
    struct graph *graph = make_graph();
    for (int frame = 0; frame < 4; frame++) {
        declare_usual_frame(graph, frame == 2);
        assert_string_equal(waits_of(graph, "cull"),
                            frame == 2 ? "    barrier memory of lights (ALL_TRANSFER/TRANSFER_WRITE -> "
                                         "COMPUTE_SHADER/SHADER_STORAGE_READ)\n"
                                       : "");
        if (frame == 2) /* readers of the last frame hold the write back, without a flush */
            assert_string_equal(waits_of(graph, "send"), "    barrier memory of lights (COMPUTE_SHADER/NONE -> "
                                                         "ALL_TRANSFER/TRANSFER_WRITE)\n");
        assert_non_null(strstr(waits_of(graph, "draw"), frame == 0 ? "hdr UNDEFINED->COLOR_ATTACHMENT_OPTIMAL (COLOR_ATTACHMENT_OUTPUT/"
                                                                   : "hdr UNDEFINED->COLOR_ATTACHMENT_OPTIMAL (COMPUTE_SHADER/NONE"));
        static char text[1 << 14];
        graph_print(graph, text, sizeof text);
        if (frame > 0) assert_null(strstr(strstr(text, "batch 0"), "(ALL_COMMANDS/MEMORY_WRITE"));
    }
    graph_destroy(&graph);
}

/* A write that nobody has seen yet is seen after a frame that did without the buffer, and by another graph. */
static void test_a_write_is_waited_for_frames_later(void **state) {
    UNUSED(state);
    struct graph *graph = make_graph();
    declare_usual_frame(graph, false);
    assert_int_equal(graph_compile(graph), FNL_OK);
    static const struct gpu_buffer buffer = {.size = 64};
    for (int frame = 0; frame < 5; frame++) {
        graph_begin(graph);
        graph_buffer imported = graph_import_buffer(graph, "kept", &buffer);
        struct graph_pass *pass = pass_of(graph, "pass");
        graph_keep(pass);
        if (frame == 0) graph_use_buffer(pass, imported, GRAPH_COPY_TO);
        if (frame >= 3) graph_use_buffer(pass, imported, GRAPH_READ_VERTEX);
        assert_string_equal(waits_of(graph, "pass"), frame == 3 ? "    barrier memory of kept (ALL_TRANSFER/TRANSFER_WRITE -> "
                                                                  "VERTEX_SHADER/SHADER_STORAGE_READ)\n"
                                                                : "");
    }
    graph_destroy(&graph);
}

static void test_empty_frame(void **state) {
    UNUSED(state);
    expect_plan(make_graph(), "0 passes, 0 culled, 0 barriers, 1 batches, 0 bytes (0 without aliasing)\n"
                              "batch 0 graphics:\n" );
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_chain),
        cmocka_unit_test(test_diamond_merges_reads),
        cmocka_unit_test(test_readers_of_all_kinds_wait_once),
        cmocka_unit_test(test_buffers_share_one_barrier_and_reads_hold_back_writes),
        cmocka_unit_test(test_culling),
        cmocka_unit_test(test_aliasing),
        cmocka_unit_test(test_resolve_and_depth_read_by_its_own_pass),
        cmocka_unit_test(test_async),
        cmocka_unit_test(test_history),
        cmocka_unit_test(test_imports),
        cmocka_unit_test(test_a_frame_waits_for_named_resources_alone),
        cmocka_unit_test(test_a_write_is_waited_for_frames_later),
        cmocka_unit_test(test_empty_frame),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
