/* SPDX-License-Identifier: MIT */
/** Names in scopes and names made from parts, on the null back end. */
#include "tests/graph_cases.h"

/* A pass that writes an image and a buffer, and one that reads them and writes a history. */
static struct graph_history declare_view(struct graph *graph) {
    graph_image image = color_image(graph, "picture", 64);
    graph_buffer counts = graph_create_buffer(graph, graph_name(graph, "%s counts", "tiled"), 64);
    struct graph_pass *pass = pass_of(graph, graph_name(graph, "tiled %d", 1));
    graph_use_image(pass, image, GRAPH_WRITE_COMPUTE);
    graph_use_buffer(pass, counts, GRAPH_WRITE_COMPUTE);
    struct graph_image_params params = {.name = "average", .format = VK_FORMAT_R8G8B8A8_UNORM, .width = 64, .height = 64};
    struct graph_history history = graph_history(graph, &params);
    pass = pass_of(graph, "accumulate");
    graph_use_image(pass, image, GRAPH_SAMPLE_COMPUTE);
    graph_use_buffer(pass, counts, GRAPH_READ_COMPUTE);
    graph_use_image(pass, history.current, GRAPH_WRITE_COMPUTE);
    return history;
}

static void test_name_scopes(void **state) {
    UNUSED(state);
    static char text[16384];
    struct graph *graph = make_graph();
    declare_view(graph);
    graph_push_names(graph, "left");
    declare_view(graph);
    graph_push_names(graph, "probe");
    declare_view(graph);
    graph_pop_names(graph);
    graph_begin_scope(graph, &(struct graph_scope_params){.name = "lighting", .most_colors = 1});
    graph_image gbuffer = color_image(graph, "gbuffer", 64);
    struct graph_pass *pass = pass_of(graph, "fill");
    graph_color(pass, gbuffer, VK_ATTACHMENT_LOAD_OP_CLEAR, NULL);
    graph_keep(pass);
    graph_end_scope(graph);
    graph_pop_names(graph);
    graph_keep(pass_of(graph, "end"));
    if (graph_compile(graph) != FNL_OK) fail_msg("not compiled: %s", logged);
    graph_print(graph, text, sizeof text);
    static const char *const expected[] = {
        "'tiled 1' graphics",      "'accumulate' graphics",      "'left/tiled 1' graphics", "'left/accumulate' graphics",
        "'left/probe/tiled 1' gr", "'left/probe/accumulate' gr", "'left/lighting' graphics", "of 'left/fill':",
        "'end' graphics",
    };
    const char *place = text;
    for (uint32_t i = 0; i < COUNT_OF(expected); i++) {
        place = strstr(place, expected[i]);
        if (!place) fail_msg("no %s in its place in the plan:\n%s", expected[i], text);
    }
    static const char *const resources[] = {" writes left/tiled counts\n", " reads left/probe/picture in ", " writes left/average in ",
                                            " writes tiled counts\n", ": left/gbuffer\n"};
    for (uint32_t i = 0; i < COUNT_OF(resources); i++)
        if (!strstr(text, resources[i])) fail_msg("no %s in the plan:\n%s", resources[i], text);
    struct graph_traffic rows[32];
    uint32_t count = graph_query_traffic(graph, rows, COUNT_OF(rows));
    assert_true(count >= 2 && count < COUNT_OF(rows));
    assert_string_equal(rows[count - 1].pass, "left/lighting");
    assert_string_equal(rows[count - 1].image, "left/gbuffer");
    graph_destroy(&graph);
}

static void test_rewritten_images_keep_their_name(void **state) {
    UNUSED(state);
    static char text[16384];
    struct graph *graph = make_graph();
    graph_push_names(graph, "left");
    graph_begin_scope(graph, &(struct graph_scope_params){.name = "lighting", .most_colors = 1, .most_inputs = 1, .separate = true});
    graph_image sum = color_image(graph, "sum", 64);
    graph_color(pass_of(graph, "first"), sum, VK_ATTACHMENT_LOAD_OP_CLEAR, NULL);
    struct graph_pass *pass = pass_of(graph, "second");
    graph_image target = graph_local_rewrite(pass, 0, sum);
    assert_int_not_equal(target.id, sum.id);
    graph_keep(pass);
    graph_end_scope(graph);
    graph_pop_names(graph);
    assert_int_equal(graph_compile(graph), FNL_OK);
    graph_print(graph, text, sizeof text);
    assert_non_null(strstr(text, "writes left/sum in"));
    assert_null(strstr(text, "left/left"));
    graph_destroy(&graph);
}

static void test_histories_of_two_scopes(void **state) {
    UNUSED(state);
    struct graph *graph = make_graph();
    static const char *const eyes[] = {"left", "right"};
    for (uint32_t frame = 0; frame < 6; frame++) {
        graph_begin(graph);
        struct graph_history history[2];
        for (uint32_t i = 0; i < 2; i++) {
            if (frame == 2 && i == 0) continue; /* the left eye rests for a frame, and starts afresh */
            graph_push_names(graph, eyes[i]);
            history[i] = declare_view(graph);
            graph_pop_names(graph);
            assert_true((history[i].previous.id != 0) == (i == 0 ? frame != 0 && frame != 3 : frame != 0));
        }
        if (frame != 2) {
            assert_int_not_equal(history[0].current.id, history[1].current.id);
            if (frame != 0 && frame != 3) assert_int_not_equal(history[0].previous.id, history[1].previous.id);
        }
        assert_int_equal(graph_compile(graph), FNL_OK);
    }
    graph_destroy(&graph);
}

static void test_misuse_of_names(void **state) {
    UNUSED(state);
    struct graph *graph = make_graph();
    graph_push_names(graph, "left");
    declare_view(graph);
    expect_misuse(graph, "names 'left/' are pushed and never popped");

    graph = make_graph();
    graph_push_names(graph, "left");
    graph_pop_names(graph);
    graph_pop_names(graph);
    expect_misuse(graph, "names are popped that were not pushed");

    graph = make_graph();
    for (uint32_t i = 0; i < 2; i++) {
        graph_push_names(graph, "left");
        graph_keep(pass_of(graph, i ? "blur" : "draw"));
        graph_pop_names(graph);
        graph_keep(pass_of(graph, i ? "left/draw" : "draw"));
    }
    expect_misuse(graph, "two passes are called 'left/draw'");

    graph = make_graph();
    for (uint32_t i = 0; i < 9; i++) graph_push_names(graph, "deeper");
    for (uint32_t i = 0; i < 9; i++) graph_pop_names(graph);
    assert_null(strstr(logged, "popped"));
    expect_misuse(graph, "deeper than 8");

    graph = make_graph();
    char longest[256];
    memset(longest, 'n', 255);
    longest[255] = 0;
    assert_string_equal(graph_name(graph, "%s", longest), longest);
    assert_int_equal(graph_compile(graph), FNL_OK);
    graph_push_names(graph, longest);
    graph_pop_names(graph);
    expect_misuse(graph, "is longer than 255 bytes");
}

static void test_names_are_kept_once(void **state) {
    UNUSED(state);
    struct graph *graph = make_graph();
    const char *names[600];
    for (uint32_t frame = 0; frame < 8; frame++) {
        if (frame == 4) allocation_count = 0;
        graph_begin(graph);
        for (uint32_t i = 0; i < COUNT_OF(names); i++) {
            const char *name = graph_name(graph, "%s %u", "list", i);
            if (frame == 0) names[i] = name;
            assert_ptr_equal(name, names[i]); /* timers point to it */
        }
        for (uint32_t eye = 0; eye < 2; eye++) {
            graph_push_names(graph, eye ? "right" : "left");
            declare_view(graph);
            graph_pop_names(graph);
        }
        assert_int_equal(graph_compile(graph), FNL_OK);
    }
    for (uint32_t i = 0; i < COUNT_OF(names); i++) {
        char text[16];
        snprintf(text, sizeof text, "list %u", i);
        assert_string_equal(names[i], text);
    }
    assert_int_equal(allocation_count, 0);
    graph_destroy(&graph);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_name_scopes),
        cmocka_unit_test(test_rewritten_images_keep_their_name),
        cmocka_unit_test(test_histories_of_two_scopes),
        cmocka_unit_test(test_misuse_of_names),
        cmocka_unit_test(test_names_are_kept_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
