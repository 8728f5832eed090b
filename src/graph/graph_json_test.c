/* SPDX-License-Identifier: MIT */
/** Plans as JSON say what the text says. No device. */
#include "tests/graph_cases.h"

#include <jansson.h>

static struct gpu_buffer readback_buffer = {.size = 1024};

static uint32_t count_of(const char *text, const char *what) {
    uint32_t count = 0;
    for (const char *at = text; (at = strstr(at, what)); at += strlen(what)) count++;
    return count;
}

static const char *string_of(const json_t *json, const char *key) {
    const char *value = json_string_value(json_object_get(json, key));
    if (!value) fail_msg("no text '%s'", key);
    return value;
}

/* A line of the text for each barrier, made from the JSON. */
static void expect_barriers(const char *text, const json_t *barriers, const json_t *resources) {
    size_t i, k;
    json_t *barrier, *index;
    json_array_foreach(barriers, i, barrier) {
        char line[2048] = "";
        size_t at = 0;
        const json_t *of = json_object_get(barrier, "resources");
        const bool is_image = json_is_string(json_object_get(barrier, "from_layout"));
        at += (size_t)snprintf(line, sizeof line, "barrier %s", is_image ? "" : "memory of ");
        json_array_foreach(of, k, index) {
            const json_t *resource = json_array_get(resources, (size_t)json_integer_value(index));
            const bool previous = strcmp(string_of(resource, "lifetime"), "history of the last frame") == 0;
            at += (size_t)snprintf(line + at, sizeof line - at, "%s%s%s", k ? ", " : "", string_of(resource, "name"), previous ? " (previous)" : "");
        }
        if (is_image) {
            const char *from = string_of(barrier, "from_layout"), *to = string_of(barrier, "to_layout");
            at += (size_t)snprintf(line + at, sizeof line - at, " %s%s%s", from, strcmp(from, to) ? "->" : "", strcmp(from, to) ? to : "");
        }
        snprintf(line + at, sizeof line - at, " (%s/%s -> %s/%s)\n", string_of(barrier, "from_stages"), string_of(barrier, "from_access"),
                 string_of(barrier, "to_stages"), string_of(barrier, "to_access"));
        if (!strstr(text, line)) fail_msg("the text has no\n%s", line);
    }
}

/* Parses the plan, and compares all that both have. */
static json_t *check_plan(struct graph *graph) {
    static char text[65536], json_text[131072], again[131072];
    if (graph_compile(graph) != FNL_OK) fail_msg("not compiled: %s", logged);
    assert_true(graph_print(graph, text, sizeof text) < sizeof text);
    const size_t length = graph_print_json(graph, json_text, sizeof json_text);
    assert_true(length < sizeof json_text && length == strlen(json_text));
    char cut[10];
    assert_int_equal(graph_print_json(graph, cut, sizeof cut), length);
    assert_memory_equal(cut, json_text, sizeof cut - 1);
    assert_int_equal(graph_compile(graph), FNL_OK);
    graph_print_json(graph, again, sizeof again);
    assert_string_equal(json_text, again);

    json_error_t error;
    json_t *plan = json_loads(json_text, JSON_REJECT_DUPLICATES, &error);
    if (!plan) fail_msg("line %d: %s", error.line, error.text);
    const struct graph_stats stats = graph_query_stats(graph);
    json_t *passes = json_object_get(plan, "passes"), *resources = json_object_get(plan, "resources"), *batches = json_object_get(plan, "batches");
    assert_int_equal(json_array_size(passes), stats.pass_count);
    assert_int_equal(json_array_size(batches), stats.batch_count);
    assert_int_equal(json_array_size(passes), count_of(text, "  pass "));
    assert_int_equal(json_integer_value(json_object_get(plan, "barriers")), stats.barrier_count);
    assert_int_equal(json_integer_value(json_object_get(plan, "transient_bytes")), stats.transient_bytes);
    assert_int_equal(json_integer_value(json_object_get(plan, "unaliased_bytes")), stats.transient_bytes_unaliased);
    size_t i, k, barriers = 0, uses = 0;
    json_t *pass, *batch, *use;
    json_array_foreach(passes, i, pass) {
        char line[512];
        snprintf(line, sizeof line, "pass %zu '%s' %s", i, string_of(pass, "name"), string_of(pass, "queue"));
        if (!strstr(text, line)) fail_msg("the text has no %s", line);
        barriers += json_array_size(json_object_get(pass, "barriers"));
        expect_barriers(text, json_object_get(pass, "barriers"), resources);
        json_array_foreach(json_object_get(pass, "uses"), k, use) {
            const json_t *resource = json_array_get(resources, (size_t)json_integer_value(json_object_get(use, "resource")));
            const bool reads = json_is_true(json_object_get(use, "reads")), writes = json_is_true(json_object_get(use, "writes"));
            snprintf(line, sizeof line, "    %s %s", writes ? (reads ? "reads, writes" : "writes") : "reads", string_of(resource, "name"));
            if (!strstr(text, line)) fail_msg("the text has no %s", line);
            assert_true((json_int_t)i >= json_integer_value(json_object_get(resource, "first_pass")));
            assert_true((json_int_t)i <= json_integer_value(json_object_get(resource, "last_pass")));
            uses++;
        }
    }
    json_array_foreach(batches, i, batch) {
        barriers += json_array_size(json_object_get(batch, "barriers_after"));
        expect_barriers(text, json_object_get(batch, "barriers_after"), resources);
    }
    assert_int_equal(barriers, stats.barrier_count);
    assert_int_equal(uses, count_of(text, "\n    reads") + count_of(text, "\n    writes"));
    return plan;
}

static json_t *named(const json_t *plan, const char *list, const char *name) {
    size_t i;
    json_t *one;
    json_array_foreach(json_object_get(plan, list), i, one) if (strcmp(string_of(one, "name"), name) == 0) return one;
    fail_msg("%s has no '%s'", list, name);
    return NULL;
}

static void finish(struct graph *graph, json_t *plan) {
    json_decref(plan);
    graph_destroy(&graph);
}

/* Attachments, layers, a history, a resource of the host, and a pass that nobody needs. */
static void test_json_of_a_frame(void **state) {
    UNUSED(state);
    struct graph *graph = make_graph();
    graph_image hdr = color_image(graph, "hdr \"half\\", 64), depth = depth_image(graph, "depth", 1), output = import_output(graph);
    graph_image two = graph_create_image(
        graph, &(struct graph_image_params){.name = "two", .format = VK_FORMAT_R32_SFLOAT, .width = 5, .height = 3, .layers = 2});
    const struct graph_history history =
        graph_history(graph, &(struct graph_image_params){.name = "kept", .format = VK_FORMAT_R16G16_SFLOAT, .width = 7, .height = 9});
    graph_buffer counts = graph_create_buffer(graph, "counts", 100), readback = graph_import_buffer(graph, "readback", &readback_buffer);
    graph_use_image(pass_of(graph, "in vain"), color_image(graph, "nothing", 8), GRAPH_WRITE_COMPUTE);
    struct graph_pass *draw = pass_of(graph, "draw");
    graph_color(draw, hdr, VK_ATTACHMENT_LOAD_OP_CLEAR, NULL);
    graph_depth(draw, depth, VK_ATTACHMENT_LOAD_OP_CLEAR, 0);
    graph_use_image(pass_of(graph, "one layer"), graph_image_layer(graph, two, 1), GRAPH_WRITE_COMPUTE);
    struct graph_pass *shade = pass_of(graph, "shade");
    graph_use_image(shade, hdr, GRAPH_SAMPLE_COMPUTE);
    graph_use_image(shade, graph_image_layer(graph, two, 1), GRAPH_READ_COMPUTE);
    graph_use_image(shade, history.current, GRAPH_WRITE_COMPUTE);
    graph_use_buffer(shade, counts, GRAPH_WRITE_COMPUTE);
    struct graph_pass *copy = pass_of(graph, "copy");
    graph_use_image(copy, history.current, GRAPH_COPY_FROM);
    graph_use_buffer(copy, counts, GRAPH_COPY_FROM);
    graph_use_image(copy, output, GRAPH_COPY_TO);
    graph_use_buffer(copy, readback, GRAPH_COPY_TO);
    json_t *plan = check_plan(graph);
    assert_int_equal(json_integer_value(json_object_get(plan, "culled_passes")), 1);

    const json_t *use = json_array_get(json_object_get(named(plan, "passes", "draw"), "uses"), 0);
    assert_string_equal(string_of(use, "load"), "clear");
    assert_string_equal(string_of(use, "store"), "store");
    assert_string_equal(string_of(use, "stages"), "COLOR_ATTACHMENT_OUTPUT");
    assert_string_equal(string_of(json_array_get(json_object_get(named(plan, "passes", "draw"), "uses"), 1), "store"), "discard");
    const json_t *layers = json_object_get(json_array_get(json_object_get(named(plan, "passes", "one layer"), "uses"), 0), "layers");
    assert_int_equal(json_array_size(layers), 1);
    assert_int_equal(json_integer_value(json_array_get(layers, 0)), 1);
    const struct {
        const char *name, *kind, *lifetime;
        uint64_t bytes;
        int first, last;
    } rows[] = {{"hdr \"half\\", "image", "transient", 64 * 64 * 4, 0, 2}, {"two", "image", "transient", 5 * 3 * 4 * 2, 1, 2},
                {"kept", "image", "history", 7 * 9 * 4, 2, 3},           {"counts", "buffer", "transient", 100, 2, 3},
                {"output", "image", "imported", 64 * 64 * 4, 3, 3},      {"readback", "buffer", "imported", 1024, 3, 3}};
    for (size_t i = 0; i < COUNT_OF(rows); i++) {
        const json_t *resource = named(plan, "resources", rows[i].name);
        assert_string_equal(string_of(resource, "kind"), rows[i].kind);
        assert_string_equal(string_of(resource, "lifetime"), rows[i].lifetime);
        assert_int_equal(json_integer_value(json_object_get(resource, "bytes")), rows[i].bytes);
        assert_int_equal(json_integer_value(json_object_get(resource, "first_pass")), rows[i].first);
        assert_int_equal(json_integer_value(json_object_get(resource, "last_pass")), rows[i].last);
        assert_int_equal(json_is_object(json_object_get(resource, "memory")), strcmp(rows[i].lifetime, "transient") == 0);
    }
    assert_int_equal(json_array_size(json_object_get(plan, "resources")), COUNT_OF(rows) + 1); /* depth; not what only a dropped pass uses */
    assert_string_equal(string_of(named(plan, "resources", "two"), "format"), "R32_SFLOAT");
    assert_int_equal(json_integer_value(json_object_get(named(plan, "resources", "two"), "layers")), 2);
    finish(graph, plan);
}

/* Of four images in a row each second one can lie where the one two before lay. */
static void test_json_of_memory_that_is_shared(void **state) {
    UNUSED(state);
    static const char *const names[] = {"a", "b", "c", "d"};
    struct graph *graph = make_graph();
    graph_image last = color_image(graph, names[0], 64), alone = color_image(graph, "alone", 16);
    struct graph_pass *first = pass_of(graph, "make a");
    graph_use_image(first, last, GRAPH_WRITE_COMPUTE);
    graph_use_image(first, alone, GRAPH_WRITE_COMPUTE);
    for (uint32_t i = 1; i < COUNT_OF(names); i++) {
        graph_image next = color_image(graph, names[i], 64);
        struct graph_pass *pass = pass_of(graph, graph_name(graph, "make %s", names[i]));
        graph_use_image(pass, last, GRAPH_SAMPLE_COMPUTE);
        graph_use_image(pass, next, GRAPH_WRITE_COMPUTE);
        last = next;
    }
    struct graph_pass *end = pass_of(graph, "end");
    graph_use_image(end, last, GRAPH_SAMPLE_COMPUTE);
    graph_use_image(end, alone, GRAPH_SAMPLE_COMPUTE);
    graph_use_image(end, import_output(graph), GRAPH_WRITE_COMPUTE);
    json_t *plan = check_plan(graph);
    json_t *groups[4];
    for (uint32_t i = 0; i < 4; i++) groups[i] = json_object_get(named(plan, "resources", names[i]), "alias_group");
    assert_true(json_is_integer(groups[0]) && json_equal(groups[0], groups[2]) && json_equal(groups[1], groups[3]) && !json_equal(groups[0], groups[1]));
    assert_true(json_is_null(json_object_get(named(plan, "resources", "alone"), "alias_group")));
    assert_true(json_is_null(json_object_get(named(plan, "resources", "output"), "alias_group")));
    finish(graph, plan);
}

static void test_json_of_two_queues(void **state) {
    UNUSED(state);
    struct graph *graph = make_graph();
    graph_image a = color_image(graph, "a", 64), b = color_image(graph, "b", 64);
    graph_use_image(graph_add_pass(graph, "beside", GRAPH_QUEUE_ASYNC, NULL, NULL, 0), a, GRAPH_WRITE_COMPUTE);
    graph_color(pass_of(graph, "draw"), b, VK_ATTACHMENT_LOAD_OP_CLEAR, NULL);
    struct graph_pass *end = pass_of(graph, "end");
    graph_use_image(end, a, GRAPH_SAMPLE_COMPUTE);
    graph_use_image(end, b, GRAPH_SAMPLE_COMPUTE);
    graph_use_image(end, import_output(graph), GRAPH_WRITE_COMPUTE);
    json_t *plan = check_plan(graph);
    assert_string_equal(string_of(named(plan, "passes", "beside"), "queue"), "compute");
    assert_string_equal(string_of(named(plan, "passes", "draw"), "queue"), "graphics");
    const json_t *batch = json_array_get(json_object_get(plan, "batches"), (size_t)json_integer_value(json_object_get(named(plan, "passes", "end"), "batch")));
    assert_int_equal(json_integer_value(json_object_get(batch, "waits_for")), json_integer_value(json_object_get(named(plan, "passes", "beside"), "batch")));
    finish(graph, plan);
}

static void test_json_without_a_plan(void **state) {
    UNUSED(state);
    struct graph *graph = make_graph();
    char text[16];
    assert_int_equal(graph_print_json(graph, text, sizeof text), 5);
    assert_string_equal(text, "null\n");
    assert_int_equal(graph_compile(graph), FNL_OK);
    json_t *plan = check_plan(graph);
    assert_int_equal(json_array_size(json_object_get(plan, "passes")), 0);
    finish(graph, plan);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_json_of_a_frame), cmocka_unit_test(test_json_of_memory_that_is_shared),
                                       cmocka_unit_test(test_json_of_two_queues), cmocka_unit_test(test_json_without_a_plan)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
