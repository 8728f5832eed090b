/* SPDX-License-Identifier: MIT */
/** Merged scopes: their plans, their misuse, what they move, and on a device the same pixels as without. */
#include "graph/graph_internal.h"
#include "shaders.h"
#include "tests/graph_world.h"

enum { WIDTH = 13, HEIGHT = 7, BYTES = WIDTH * HEIGHT * 16 };

static char logged[2048];

static void keep_log(void *user, fnl_log_level level, const char *line) {
    UNUSED(user);
    if (level < FNL_LOG_WARNING) return;
    if (strncmp(line, "validation", 10) == 0) print_error("%s\n", line);
    snprintf(logged + strlen(logged), sizeof logged - strlen(logged), "%s\n", line);
}

static struct graph *make_graph(void) {
    fnl_host host = {.log = keep_log};
    struct graph *graph;
    assert_int_equal(graph_create(&host, NULL, &graph), FNL_OK);
    logged[0] = 0;
    graph_begin(graph);
    return graph;
}

static graph_image image(struct graph *graph, const char *name, VkFormat format) {
    return graph_create_image(
        graph, &(struct graph_image_params){.name = name, .format = format, .width = WIDTH, .height = HEIGHT});
}

/* ---- passes: what is below plus a half ---- */

struct draw {
    graph_image below;
    bool merged;
    VkFormat format, depth;
};

static void execute_draw(const struct graph_context *context, const void *data) {
    const struct draw *d = data;
    struct gpu_graphics_params params;
    memset(&params, 0, sizeof params);
    params.vertex = &shader_graph_test_vert;
    params.fragment = d->merged ? &shader_graph_test_local_frag : &shader_graph_test_frag;
    params.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
    params.color_count = 1;
    params.color_formats[0] = d->format;
    params.depth_format = d->depth;
    params.samples = 1;
    gpu_bind(context->commands, graph_pipeline(context, &params));
    uint32_t push[2] = {d->merged ? 0 : graph_sampled(context, d->below)};
    gpu_push(context->commands, push, sizeof push);
    gpu_draw(context->commands, 3, 1, 0, 0);
}

static void execute_copy(const struct graph_context *context, const void *data) {
    const struct {
        graph_image from;
        graph_buffer to;
    } *copy = data;
    gpu_copy_image_to_buffer(context->commands, graph_get_image(context, copy->from), graph_get_buffer(context, copy->to),
                             0);
}

/* A cleared image, rewritten with a half more, read with a half more into a last one, which is copied out. */
static bool declare(struct graph *graph, bool separate, const struct gpu_buffer *readback) {
    const float quarter[4] = {0.25f, 0.25f, 0.25f, 0.25f};
    const VkFormat half = VK_FORMAT_R16G16B16A16_SFLOAT, full = VK_FORMAT_R32G32B32A32_SFLOAT;
    graph_image below = image(graph, "below", half), depth = image(graph, "depth", VK_FORMAT_D32_SFLOAT);
    graph_image above = image(graph, "above", full);
    bool merged = graph_begin_scope(graph, &(struct graph_scope_params){"scope", 1, 2, separate});
    struct graph_pass *pass = graph_add_pass(graph, "clear", GRAPH_QUEUE_GRAPHICS, NULL, NULL, 0);
    graph_color(pass, below, VK_ATTACHMENT_LOAD_OP_CLEAR, quarter);
    graph_depth(pass, depth, VK_ATTACHMENT_LOAD_OP_CLEAR, 0);

    struct draw draw = {below, merged, half, VK_FORMAT_UNDEFINED};
    pass = graph_add_pass(graph, "rewrite", GRAPH_QUEUE_GRAPHICS, execute_draw, &draw, sizeof draw);
    draw.below = graph_local_rewrite(pass, 1, below);
    assert_int_equal(draw.below.id == below.id, merged);

    draw.format = full;
    draw.depth = VK_FORMAT_D32_SFLOAT;
    pass = graph_add_pass(graph, "finish", GRAPH_QUEUE_GRAPHICS, execute_draw, &draw, sizeof draw);
    graph_local_read(pass, 1, draw.below);
    graph_color(pass, above, VK_ATTACHMENT_LOAD_OP_DONT_CARE, NULL);
    graph_depth_read_only(pass, depth);
    graph_end_scope(graph);

    struct {
        graph_image from;
        graph_buffer to;
    } copy = {above, graph_import_buffer(graph, "readback", readback)};
    pass = graph_add_pass(graph, "copy", GRAPH_QUEUE_GRAPHICS, execute_copy, &copy, sizeof copy);
    graph_use_image(pass, copy.from, GRAPH_COPY_FROM);
    graph_use_buffer(pass, copy.to, GRAPH_COPY_TO);
    return merged;
}

/* ---- plans ---- */

static const struct gpu_buffer fake_readback = {.size = BYTES};

static const char *table_of(struct graph *graph) {
    static char text[4096];
    assert_true(graph_print_traffic(graph, text, sizeof text) < sizeof text);
    return text;
}

static void test_a_merged_scope_stores_only_what_is_used_after_it_MB_2(void **state) {
    UNUSED(state);
    struct graph *graph = make_graph();
    assert_true(declare(graph, false, &fake_readback));
    assert_int_equal(graph_compile(graph), FNL_OK);
    char plan[4096];
    graph_print(graph, plan, sizeof plan);
    assert_non_null(strstr(plan, "pass 0 'scope' graphics, one scope of 'clear', 'rewrite', 'finish':\n"));
    assert_string_equal(
        table_of(graph),
        "pass                     image                    load    store     bytes read      written\n"
        "scope                    below                    clear   -                  0            0 in tiles\n"
        "                         depth                    clear   -                  0            0 in tiles\n"
        "                         above                    -       store              0         1456\n"
        "all                                                                          0         1456\n");
    struct graph_stats stats = graph_query_stats(graph);
    assert_int_equal(stats.pass_count, 2);
    assert_int_equal(stats.image_bytes_read, 0);
    assert_int_equal(stats.image_bytes_written, BYTES);
    assert_int_equal(stats.tile_bytes, WIDTH * HEIGHT * (8 + 4));
    struct graph_traffic rows[8];
    assert_int_equal(graph_query_traffic(graph, rows, COUNT_OF(rows)), 3);
    assert_true(rows[0].transient && rows[1].transient && !rows[2].transient);
    assert_int_equal(graph_query_traffic(graph, rows, 1), 3);

    graph_begin(graph);
    assert_false(declare(graph, true, &fake_readback));
    assert_int_equal(graph_compile(graph), FNL_OK);
    stats = graph_query_stats(graph);
    assert_int_equal(stats.pass_count, 4);
    assert_int_equal(stats.image_bytes_read, WIDTH * HEIGHT * (8 + 8 + 4)); /* below, below again, depth */
    assert_int_equal(stats.image_bytes_written, WIDTH * HEIGHT * (8 + 4 + 8 + 16));
    assert_int_equal(stats.tile_bytes, 0);
    graph_destroy(&graph);
}

/* What nobody needs is dropped from a scope as from a frame; a scope of one pass is still a scope. */
static void test_culling_inside_a_scope(void **state) {
    UNUSED(state);
    struct graph *graph = make_graph();
    graph_image target = image(graph, "target", VK_FORMAT_R8G8B8A8_UNORM),
                unused = image(graph, "unused", VK_FORMAT_R8_UNORM);
    graph_begin_scope(graph, &(struct graph_scope_params){"scope", 1, 1, false});
    struct graph_pass *pass = graph_add_pass(graph, "useless", GRAPH_QUEUE_GRAPHICS, NULL, NULL, 0);
    graph_color(pass, unused, VK_ATTACHMENT_LOAD_OP_CLEAR, NULL);
    pass = graph_add_pass(graph, "useful", GRAPH_QUEUE_GRAPHICS, NULL, NULL, 0);
    graph_color(pass, target, VK_ATTACHMENT_LOAD_OP_CLEAR, NULL);
    graph_keep(pass);
    graph_end_scope(graph);
    assert_int_equal(graph_compile(graph), FNL_OK);
    char plan[2048];
    graph_print(graph, plan, sizeof plan);
    assert_non_null(strstr(plan, "pass 0 'scope' graphics, one scope of 'useful':\n"));
    assert_int_equal(graph_query_stats(graph).culled_pass_count, 1);
    graph_destroy(&graph);
}

static struct graph_pass *begin(struct graph *graph, graph_image target) {
    graph_begin_scope(graph, &(struct graph_scope_params){"scope", 2, 1, false});
    struct graph_pass *pass = graph_add_pass(graph, "first", GRAPH_QUEUE_GRAPHICS, NULL, NULL, 0);
    graph_color(pass, target, VK_ATTACHMENT_LOAD_OP_CLEAR, NULL);
    graph_keep(pass);
    pass = graph_add_pass(graph, "second", GRAPH_QUEUE_GRAPHICS, NULL, NULL, 0);
    graph_keep(pass);
    return pass;
}

static void expect_misuse(struct graph *graph, const char *message) {
    if (graph_compile(graph) != FNL_ERROR_INVALID) fail_msg("no misuse: %s", message);
    if (!strstr(logged, message)) fail_msg("the log is\n%s\nand lacks\n%s", logged, message);
    logged[0] = 0;
    graph_begin(graph);
}

static void test_misuse_of_scopes(void **state) {
    UNUSED(state);
    const VkFormat format = VK_FORMAT_R8G8B8A8_UNORM;
    struct graph *graph = make_graph();
    graph_image a = image(graph, "a", format);
    struct graph_pass *pass = begin(graph, a);
    graph_color(pass, a, VK_ATTACHMENT_LOAD_OP_CLEAR, NULL);
    expect_misuse(graph, "pass 'second' clears 'a', which scope 'scope' has drawn into");

    a = image(graph, "a", format);
    pass = begin(graph, a);
    graph_local_read(pass, 0, a);
    expect_misuse(graph, "pass 'second' draws nothing in scope 'scope'");

    a = image(graph, "a", format);
    pass = begin(graph, a);
    graph_use_image(pass, a, GRAPH_SAMPLE_FRAGMENT);
    graph_color(pass, image(graph, "b", format), VK_ATTACHMENT_LOAD_OP_CLEAR, NULL);
    graph_local_read(pass, 0, a);
    expect_misuse(graph, "pass 'second' uses 'a' in two layouts at once");

    a = image(graph, "a", format);
    pass = begin(graph, a);
    graph_use_image(pass, a, GRAPH_SAMPLE_FRAGMENT);
    graph_color(pass, image(graph, "b", format), VK_ATTACHMENT_LOAD_OP_CLEAR, NULL);
    expect_misuse(graph, "pass 'second' uses 'a' in another layout than an earlier pass of scope 'scope'");

    a = image(graph, "a", format);
    pass = begin(graph, a);
    graph_image small = graph_create_image(
        graph, &(struct graph_image_params){.name = "small", .format = format, .width = WIDTH, .height = 1});
    graph_color(pass, small, VK_ATTACHMENT_LOAD_OP_CLEAR, NULL);
    expect_misuse(graph,
                  "scope 'scope' has attachments of different sizes: 'a' is 13x7, 1 layers, 'small' is 13x1, 1 layers");

    a = image(graph, "a", format);
    graph_buffer shared = graph_create_buffer(graph, "shared", 64);
    pass = begin(graph, a);
    graph_use_buffer(graph->passes.data[0], shared, GRAPH_READ_WRITE_FRAGMENT);
    graph_use_buffer(pass, shared, GRAPH_READ_VERTEX);
    graph_color(pass, a, VK_ATTACHMENT_LOAD_OP_LOAD, NULL);
    graph->resources.data[1].has_contents = true;
    expect_misuse(graph, "passes of scope 'scope' write and use 'shared' beyond their own pixel");

    a = image(graph, "a", format);
    pass = graph_add_pass(graph, "outside", GRAPH_QUEUE_GRAPHICS, NULL, NULL, 0);
    graph_local_read(pass, 0, a);
    expect_misuse(graph, "pass 'outside' reads 'a' as local input 0, but is in no scope");

    graph_end_scope(graph);
    expect_misuse(graph, "a scope ends that was not begun");

    graph_begin_scope(graph, &(struct graph_scope_params){"outer", 1, 1, false});
    graph_begin_scope(graph, &(struct graph_scope_params){"inner", 1, 1, false});
    expect_misuse(graph, "scope 'inner' begins inside scope 'outer'");

    /* More than there is room for in a pass: not merged, and no misuse. */
    assert_false(graph_begin_scope(graph, &(struct graph_scope_params){"wide", 1, GPU_MAX_INPUTS + 1, false}));
    assert_int_equal(graph_compile(graph), FNL_OK);
    graph_destroy(&graph);
}

/* ---- on a device ---- */

static void test_merged_and_separate_passes_leave_the_same_pixels(void **state) {
    UNUSED(state);
    fnl_host host = fnl_host_default();
    host.log = keep_log;
    struct graph_world world;
    graph_world_open(&world, &host, BYTES);
    for (uint32_t frame = 0; frame < 5; frame++) {
        graph_begin(world.graph);
        bool separate = frame & 1;
        assert_int_equal(declare(world.graph, separate, &world.readback), !separate);
        graph_world_run(&world, &(struct graph_execute_params){.timers = true});
        const float *pixels = world.readback.mapped;
        for (uint32_t i = 0; i < BYTES / 4; i++) assert_true(pixels[i] == 1.25f);
        const struct graph_timer *timers;
        uint32_t count;
        if (graph_query_timers(world.graph, gpu_frame_number(world.device), &timers, &count)) {
            assert_int_equal(count, separate ? 4 : 2);
            assert_string_equal(timers[0].name, separate ? "clear" : "scope");
        }
        struct graph_lazy_memory lazy = graph_query_lazy_memory(world.graph);
        assert_true(lazy.committed_bytes <= lazy.reserved_bytes);
    }
    graph_world_close(&world);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_merged_scope_stores_only_what_is_used_after_it_MB_2),
        cmocka_unit_test(test_culling_inside_a_scope),
        cmocka_unit_test(test_misuse_of_scopes),
        cmocka_unit_test(test_merged_and_separate_passes_leave_the_same_pixels),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
