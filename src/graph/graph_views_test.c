/* SPDX-License-Identifier: MIT */
/** Layers of images, and passes that draw into several at once: plans, misuse, and on a device the pixels of each layer. */
#include "shaders.h"
#include "tests/graph_cases.h"
#include "tests/graph_world.h"

enum { WIDTH = 13, HEIGHT = 7, MOST = 6, LAYER_FLOATS = WIDTH * HEIGHT * 4, BYTES = MOST * LAYER_FLOATS * 4 };

static graph_image array_image(struct graph *graph, const char *name, uint32_t layers) {
    return graph_create_image(graph, &(struct graph_image_params){.name = name,
                                                                  .format = VK_FORMAT_R32G32B32A32_SFLOAT,
                                                                  .width = WIDTH,
                                                                  .height = HEIGHT,
                                                                  .layers = layers});
}

/* ---- passes ---- */

struct draw {
    const struct gpu_shader *fragment;
    graph_image from; /* id 0: reads nothing */
};

static void execute_draw(const struct graph_context *context, const void *data) {
    const struct draw *d = data;
    struct gpu_graphics_params params;
    memset(&params, 0, sizeof params);
    params.vertex = &shader_graph_test_vert;
    params.fragment = d->fragment;
    params.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
    params.color_count = 1;
    params.color_formats[0] = VK_FORMAT_R32G32B32A32_SFLOAT;
    params.samples = 1;
    gpu_bind(context->commands, graph_pipeline(context, &params));
    uint32_t push[2] = {d->from.id ? graph_sampled(context, d->from) : 0};
    gpu_push(context->commands, push, sizeof push);
    gpu_draw(context->commands, 3, 1, 0, 0);
}

struct copy {
    graph_image from;
    graph_buffer to;
    uint64_t offset;
};

static void execute_copy(const struct graph_context *context, const void *data) {
    const struct copy *copy = data;
    gpu_copy_image_to_buffer(context->commands, graph_get_image(context, copy->from), graph_get_buffer(context, copy->to),
                             copy->offset);
}

/* Draws into `mask` of the layers of an image; what they hold plus a half into another image, back to front; and that to the buffer. */
static void declare(struct graph *graph, uint32_t layers, uint32_t mask, const struct gpu_buffer *readback) {
    static const char *const names[2][MOST] = {{"half 0", "half 1", "half 2", "half 3", "half 4", "half 5"},
                                               {"copy 0", "copy 1", "copy 2", "copy 3", "copy 4", "copy 5"}};
    const float tenth[4] = {0.125f, 0.125f, 0.125f, 0.125f};
    graph_image views = array_image(graph, "views", layers), halves = array_image(graph, "halves", layers);
    graph_buffer to = graph_import_buffer(graph, "readback", readback);
    struct draw draw = {.fragment = &shader_graph_test_views_frag};
    struct graph_pass *pass = graph_add_pass(graph, "draw", GRAPH_QUEUE_GRAPHICS, execute_draw, &draw, sizeof draw);
    graph_color(pass, views, VK_ATTACHMENT_LOAD_OP_CLEAR, tenth);
    graph_view_mask(pass, mask);
    for (uint32_t i = 0; i < layers; i++) {
        if (!(mask >> i & 1)) continue;
        draw = (struct draw){&shader_graph_test_frag, graph_image_layer(graph, views, i)};
        pass = graph_add_pass(graph, names[0][i], GRAPH_QUEUE_GRAPHICS, execute_draw, &draw, sizeof draw);
        graph_use_image(pass, draw.from, GRAPH_SAMPLE_FRAGMENT);
        graph_color(pass, graph_image_layer(graph, halves, layers - 1 - i), VK_ATTACHMENT_LOAD_OP_CLEAR, tenth);
    }
    for (uint32_t i = 0; i < layers; i++) {
        if (!(mask >> i & 1)) continue;
        struct copy copy = {graph_image_layer(graph, halves, layers - 1 - i), to, i * LAYER_FLOATS * 4ull};
        pass = graph_add_pass(graph, names[1][i], GRAPH_QUEUE_GRAPHICS, execute_copy, &copy, sizeof copy);
        graph_use_image(pass, copy.from, GRAPH_COPY_FROM);
        graph_use_buffer(pass, to, GRAPH_COPY_TO);
    }
}

/* ---- plans ---- */

static const struct gpu_buffer fake_readback = {.size = BYTES};

static void expect_text(const char *text, const char *part) {
    if (!strstr(text, part)) fail_msg("the text is\n%s\nand lacks\n%s", text, part);
}

static void test_the_plan_of_layers(void **state) {
    UNUSED(state);
    struct graph *graph = make_graph();
    declare(graph, 2, 3, &fake_readback);
    assert_int_equal(graph_compile(graph), FNL_OK);
    static char text[8192];
    assert_true(graph_print(graph, text, sizeof text) < sizeof text);
    expect_text(text, "  pass 0 'draw' graphics, views 0x3 at once:\n"
                      "    barrier views UNDEFINED->COLOR_ATTACHMENT_OPTIMAL (COLOR_ATTACHMENT_OUTPUT/NONE -> "
                      "COLOR_ATTACHMENT_OUTPUT/COLOR_ATTACHMENT_READ|COLOR_ATTACHMENT_WRITE)\n"
                      "    writes views in COLOR_ATTACHMENT_OPTIMAL\n"
                      "  pass 1 'half 0' graphics:\n"
                      "    barrier views COLOR_ATTACHMENT_OPTIMAL->SHADER_READ_ONLY_OPTIMAL "
                      "(COLOR_ATTACHMENT_OUTPUT/COLOR_ATTACHMENT_WRITE -> FRAGMENT_SHADER/SHADER_SAMPLED_READ)\n"
                      "    barrier halves UNDEFINED->COLOR_ATTACHMENT_OPTIMAL (COLOR_ATTACHMENT_OUTPUT/NONE -> "
                      "COLOR_ATTACHMENT_OUTPUT/COLOR_ATTACHMENT_READ|COLOR_ATTACHMENT_WRITE)\n"
                      "    reads views layer 0 in SHADER_READ_ONLY_OPTIMAL\n"
                      "    writes halves layer 1 in COLOR_ATTACHMENT_OPTIMAL\n"
                      "  pass 2 'half 1' graphics:\n"
                      /* the other layer: contents stay */
                      "    barrier halves COLOR_ATTACHMENT_OPTIMAL (COLOR_ATTACHMENT_OUTPUT/COLOR_ATTACHMENT_WRITE -> "
                      "COLOR_ATTACHMENT_OUTPUT/COLOR_ATTACHMENT_READ|COLOR_ATTACHMENT_WRITE)\n"
                      "    reads views layer 1 in SHADER_READ_ONLY_OPTIMAL\n"
                      "    writes halves layer 0 in COLOR_ATTACHMENT_OPTIMAL\n");
    expect_text(text, "bytes, passes 0 to 2: views\n"); /* once, with both layers */
    expect_text(text, "bytes, passes 1 to 4: halves\n");
    const uint64_t layer = WIDTH * HEIGHT * 16;
    struct graph_traffic rows[16];
    assert_int_equal(graph_query_traffic(graph, rows, COUNT_OF(rows)), 5);
    assert_int_equal(rows[0].bytes_written, 2 * layer);
    for (uint32_t i = 1; i < 5; i += 2) {
        assert_int_equal(rows[i].bytes_written, layer);
        assert_int_equal(rows[i].store, VK_ATTACHMENT_STORE_OP_STORE);
        assert_int_equal(rows[i + 1].bytes_read, layer);
    }
    graph_destroy(&graph);
}

static void test_layers_are_handles(void **state) {
    UNUSED(state);
    struct graph *graph = make_graph();
    graph_image several = array_image(graph, "several", 3), flat = array_image(graph, "flat", 1);
    graph_image first = graph_image_layer(graph, several, 0), last = graph_image_layer(graph, several, 2);
    assert_true(first.id && last.id && first.id != last.id && first.id != several.id);
    assert_int_equal(graph_image_layer(graph, several, 2).id, last.id);
    assert_int_equal(graph_image_layer(graph, flat, 0).id, flat.id);
    assert_int_equal(graph_image_info(graph, last).layers, 1);
    assert_int_equal(graph_image_info(graph, last).width, WIDTH);
    assert_int_equal(graph_image_info(graph, several).layers, 3);
    graph_destroy(&graph);
}

static void test_misuse(void **state) {
    UNUSED(state);
    struct graph *graph = make_graph();
    graph_image_layer(graph, array_image(graph, "a", 2), 2);
    expect_misuse(graph, "layer 2 is asked for of ");

    graph = make_graph();
    graph_image_layer(graph, graph_image_layer(graph, array_image(graph, "a", 2), 1), 0);
    expect_misuse(graph, "layer 0 is asked for of ");

    graph = make_graph();
    struct graph_pass *pass = pass_of(graph, "wide");
    graph_color(pass, array_image(graph, "a", 2), VK_ATTACHMENT_LOAD_OP_CLEAR, NULL);
    graph_view_mask(pass, 5);
    expect_misuse(graph, "pass 'wide' draws views 0x5, but 'a' has 2 layers");

    graph = make_graph();
    graph_view_mask(pass_of(graph, "nothing"), 3);
    expect_misuse(graph, "pass 'nothing' draws several views, but has no attachments");

    graph = make_graph();
    pass = pass_of(graph, "wide");
    graph_color(pass, array_image(graph, "a", 2), VK_ATTACHMENT_LOAD_OP_CLEAR, NULL);
    graph_vertex_layers(pass, 3);
    expect_misuse(graph, "pass 'wide' draws into 3 layers, but its attachments have fewer");

    graph = make_graph();
    pass = pass_of(graph, "both");
    graph_color(pass, array_image(graph, "a", 2), VK_ATTACHMENT_LOAD_OP_CLEAR, NULL);
    graph_vertex_layers(pass, 2);
    graph_view_mask(pass, 3);
    expect_misuse(graph, "pass 'both' draws into 2 layers, but has a view mask");

    graph = make_graph();
    graph_begin_scope(graph, &(struct graph_scope_params){"scope", 1, 1, false});
    pass = pass_of(graph, "inside");
    graph_color(pass, array_image(graph, "a", 2), VK_ATTACHMENT_LOAD_OP_CLEAR, NULL);
    graph_view_mask(pass, 3);
    graph_end_scope(graph);
    expect_misuse(graph, "pass 'inside' draws several views, but is in a scope");

    graph = make_graph();
    graph_begin_scope(graph, &(struct graph_scope_params){"scope", 1, 1, false});
    graph_color(pass_of(graph, "inside"), graph_image_layer(graph, array_image(graph, "a", 2), 1), VK_ATTACHMENT_LOAD_OP_CLEAR, NULL);
    graph_end_scope(graph);
    expect_misuse(graph, "pass 'inside' of scope 'scope' has a layer of 'a' as an attachment");

    /* One layer was written, the other one is read. */
    graph = make_graph();
    graph_image a = array_image(graph, "a", 2);
    graph_color(pass_of(graph, "write"), graph_image_layer(graph, a, 0), VK_ATTACHMENT_LOAD_OP_CLEAR, NULL);
    graph_use_image(pass_of(graph, "read"), graph_image_layer(graph, a, 1), GRAPH_SAMPLE_COMPUTE);
    expect_misuse(graph, "pass 'read' reads 'a', which nobody wrote before");

    graph = make_graph();
    a = array_image(graph, "a", 2);
    pass = pass_of(graph, "both");
    graph_color(pass, graph_image_layer(graph, a, 0), VK_ATTACHMENT_LOAD_OP_CLEAR, NULL);
    graph_use_image(pass, graph_image_layer(graph, a, 1), GRAPH_SAMPLE_FRAGMENT);
    expect_misuse(graph, "pass 'both' uses 'a' in two layouts at once");
}

/* ---- on a device ---- */

static void print_log(void *user, fnl_log_level level, const char *line) {
    UNUSED(user);
    if (level >= FNL_LOG_WARNING) print_error("%s\n", line);
}

static void test_each_view_has_pixels_of_its_own(void **state) {
    UNUSED(state);
    static const struct {
        uint32_t layers, mask;
    } cases[] = {{2, 3}, {6, 0x3f}, {3, 5}, {1, 1}, {2, 2}, {6, 0x3f}, {4, 0xf}};
    fnl_host host = fnl_host_default();
    host.log = print_log;
    struct graph_world world;
    graph_world_open(&world, &host, BYTES);
    assert_true(gpu_info(world.device)->multiview && gpu_info(world.device)->max_views >= MOST);
    for (uint32_t n = 0; n < 2 * COUNT_OF(cases); n++) { /* images come back, and some are let go */
        const uint32_t layers = cases[n % COUNT_OF(cases)].layers, mask = cases[n % COUNT_OF(cases)].mask;
        graph_begin(world.graph);
        declare(world.graph, layers, mask, &world.readback);
        graph_world_run(&world, NULL);
        const float *pixels = world.readback.mapped;
        for (uint32_t i = 0; i < MOST * LAYER_FLOATS; i++) {
            uint32_t view = i / LAYER_FLOATS;
            float expected = mask >> view & 1 ? (float)view + 1.5f : 0;
            if (pixels[i] != expected)
                fail_msg("case %u: view %u holds %g, not %g", n, view, (double)pixels[i], (double)expected);
        }
    }
    graph_world_close(&world);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_the_plan_of_layers),
        cmocka_unit_test(test_layers_are_handles),
        cmocka_unit_test(test_misuse),
        cmocka_unit_test(test_each_view_has_pixels_of_its_own),
    };
    return cmocka_run_group_tests_name("graph_views", tests, NULL, NULL);
}
