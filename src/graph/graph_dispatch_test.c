/* SPDX-License-Identifier: MIT */
/** What rows declare, on the null back end; graph_device_test.c has what they write. */
#include "tests/graph_cases.h"

static const struct gpu_shader shader = {.name = "no shader"}; /* nothing is executed */

struct push {
    uint64_t counts, cells;
    uint32_t depth, picture, size;
};

struct resources {
    graph_buffer counts, cells, commands;
    graph_image depth, picture;
};

/* What the dispatch reads is there before it; what it writes is kept by a last pass. */
static struct resources add_resources(struct graph *graph) {
    struct resources r = {.counts = graph_create_buffer(graph, "counts", 64),
                          .cells = graph_create_buffer(graph, "cells", 64),
                          .commands = graph_create_buffer(graph, "commands", 64),
                          .depth = color_image(graph, "depth", 64),
                          .picture = color_image(graph, "picture", 64)};
    struct graph_pass *pass = pass_of(graph, "before");
    graph_use_buffer(pass, r.counts, GRAPH_WRITE_COMPUTE);
    graph_use_buffer(pass, r.commands, GRAPH_WRITE_COMPUTE);
    graph_use_image(pass, r.depth, GRAPH_WRITE_COMPUTE);
    return r;
}

static void add_reader(struct graph *graph, const struct resources *r) {
    struct graph_pass *pass = pass_of(graph, "after");
    graph_use_buffer(pass, r->cells, GRAPH_READ_COMPUTE);
    graph_use_image(pass, r->picture, GRAPH_SAMPLE_COMPUTE);
    graph_keep(pass);
}

static void add_dispatch(struct graph *graph, const struct resources *r) {
    struct push push = {.size = 3};
    graph_dispatch(graph, &(struct graph_dispatch){
                              .name = "dispatch",
                              .queue = GRAPH_QUEUE_ASYNC,
                              .pipeline = {.shader = &shader},
                              .indirect = r->commands,
                              GRAPH_PUSH(push),
                              GRAPH_ROWS(graph_reads(&push.counts, r->counts), graph_writes(&push.cells, r->cells),
                                         graph_samples(&push.depth, r->depth), graph_stores(&push.picture, r->picture),
                                         graph_row_if(false, graph_reads(&push.counts, (graph_buffer){0})))});
}

static void test_uses_follow_from_rows(void **state) {
    UNUSED(state);
    static char by_rows[8192], by_hand[8192];
    struct graph *graph = make_graph();
    struct resources r = add_resources(graph);
    add_dispatch(graph, &r);
    add_reader(graph, &r);
    if (graph_compile(graph) != FNL_OK) fail_msg("not compiled: %s", logged);
    graph_print(graph, by_rows, sizeof by_rows);
    graph_begin(graph);
    r = add_resources(graph);
    struct graph_pass *pass = graph_add_pass(graph, "dispatch", GRAPH_QUEUE_ASYNC, NULL, NULL, 0);
    graph_use_buffer(pass, r.counts, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, r.cells, GRAPH_WRITE_COMPUTE);
    graph_use_image(pass, r.depth, GRAPH_SAMPLE_COMPUTE);
    graph_use_image(pass, r.picture, GRAPH_WRITE_COMPUTE);
    graph_use_buffer(pass, r.commands, GRAPH_INDIRECT);
    add_reader(graph, &r);
    assert_int_equal(graph_compile(graph), FNL_OK);
    graph_print(graph, by_hand, sizeof by_hand);
    assert_string_equal(by_rows, by_hand);
    assert_non_null(strstr(by_rows, "pass 1 'dispatch'"));
    assert_string_equal(logged, "");
    graph_destroy(&graph);
}

static void test_a_row_without_a_member_is_a_use(void **state) {
    UNUSED(state);
    static char text[8192];
    struct graph *graph = make_graph();
    graph_buffer table = graph_create_buffer(graph, "table", 64);
    graph_use_buffer(pass_of(graph, "before"), table, GRAPH_WRITE_COMPUTE);
    struct graph_pass *pass = graph_dispatch(graph, &(struct graph_dispatch){.name = "dispatch",
                                                                             .pipeline = {.shader = &shader},
                                                                             .groups = {1},
                                                                             GRAPH_ROWS(graph_reads(NULL, table))});
    graph_keep(pass);
    assert_int_equal(graph_compile(graph), FNL_OK);
    graph_print(graph, text, sizeof text);
    assert_non_null(strstr(text, "    reads table\n"));
    graph_destroy(&graph);
}

static void add_row(struct graph *graph, struct graph_row row, const struct push *push, size_t size) {
    graph_dispatch(graph, &(struct graph_dispatch){.name = "dispatch",
                                                   .pipeline = {.shader = &shader},
                                                   .groups = {1},
                                                   .push = push,
                                                   .push_size = size,
                                                   .rows = &row,
                                                   .row_count = 1});
}

static void test_misuse_of_rows(void **state) {
    UNUSED(state);
    static const char outside[] = "pass 'dispatch' has a row for 'cells' whose member is outside of its";
    struct push push[2] = {{0}};
    const size_t sizes[] = {sizeof push[0], 8, 15, 0};
    const uint64_t *members[] = {&push[1].counts, &push[0].cells, &push[0].cells, &push[0].counts};
    for (uint32_t i = 0; i < COUNT_OF(sizes); i++) {
        struct graph *graph = make_graph();
        add_row(graph, graph_writes(members[i], graph_create_buffer(graph, "cells", 64)), &push[0], sizes[i]);
        expect_misuse(graph, outside);
    }
    struct graph *graph = make_graph();
    add_row(graph, graph_writes(&push[0].counts, graph_create_buffer(graph, "cells", 64)), &push[1], sizeof push[1]);
    expect_misuse(graph, outside); /* before it */

    graph = make_graph(); /* an index has 4 bytes, an address 8 */
    add_row(graph, graph_stores(&push[0].picture, color_image(graph, "cells", 64)), &push[0], 24);
    assert_int_equal(graph_compile(graph), FNL_OK);
    graph_begin(graph);
    add_row(graph, graph_stores(&push[0].picture, color_image(graph, "cells", 64)), &push[0], 23);
    expect_misuse(graph, outside);

    graph = make_graph();
    add_row(graph, graph_reads(&push[0].counts, (graph_buffer){0}), &push[0], sizeof push[0]);
    expect_misuse(graph, "pass 'dispatch' is given no buffer (its handle is 0)");

    graph = make_graph();
    add_row(graph, graph_samples(&push[0].depth, (graph_image){0}), &push[0], sizeof push[0]);
    expect_misuse(graph, "pass 'dispatch' is given no image (its handle is 0)");

    graph = make_graph();
    const char large[GPU_PUSH_BYTES + 4] = {0};
    graph_dispatch(graph, &(struct graph_dispatch){.name = "dispatch", .pipeline = {.shader = &shader}, GRAPH_PUSH(large)});
    expect_misuse(graph, "pass 'dispatch' has 132 bytes of push constants, which is more than 128");

    graph = make_graph();
    struct push data = {0};
    struct graph_pass *pass = graph_add_pass(graph, "draw", GRAPH_QUEUE_GRAPHICS, NULL, &data, sizeof data);
    graph_add_row(pass, graph_writes(&data.counts, graph_create_buffer(graph, "cells", 64)));
    assert_int_equal(graph_compile(graph), FNL_OK);
    graph_begin(graph);
    pass = graph_add_pass(graph, "draw", GRAPH_QUEUE_GRAPHICS, NULL, &data, sizeof data);
    graph_add_row(pass, graph_writes(&push[0].counts, graph_create_buffer(graph, "cells", 64)));
    expect_misuse(graph, "pass 'draw' has a row for 'cells' whose member is outside of its 32 bytes");

    graph = make_graph();
    uint64_t place;
    graph_put_address(graph, &place, (graph_buffer){0});
    expect_misuse(graph, "an address is asked for of 0, which is no buffer handle");
}

static void test_one_more_dispatch_in_a_pass(void **state) {
    UNUSED(state);
    static char text[8192];
    struct graph *graph = make_graph();
    struct resources r = add_resources(graph);
    struct push push = {.size = 3};
    struct graph_dispatch dispatch = {
        .name = "dispatch", .pipeline = {.shader = &shader}, .groups = {1}, GRAPH_PUSH(push), GRAPH_ROWS(graph_reads(&push.counts, r.counts))};
    struct graph_pass *pass = graph_dispatch(graph, &dispatch);
    struct push other = {.size = 4}; /* rows are of the dispatch that was added last */
    assert_ptr_equal(graph_dispatch(graph, &(struct graph_dispatch){.pass = pass,
                                                                    .pipeline = {.shader = &shader},
                                                                    .indirect = r.commands,
                                                                    GRAPH_PUSH(other),
                                                                    GRAPH_ROWS(graph_writes(&other.cells, r.cells))}),
                     pass);
    graph_add_row(pass, graph_stores(&other.picture, r.picture));
    add_reader(graph, &r);
    if (graph_compile(graph) != FNL_OK) fail_msg("not compiled: %s", logged);
    graph_print(graph, text, sizeof text);
    const char *found = strstr(text, "pass 1 'dispatch'"), *end = strstr(text, "pass 2 'after'");
    assert_true(found && end);
    const char *uses[] = {"reads counts\n", "writes cells\n", "writes picture", "reads commands\n"};
    for (uint32_t i = 0; i < COUNT_OF(uses); i++) {
        const char *use = strstr(found, uses[i]);
        if (!use || use > end) fail_msg("the pass has no use '%s': %s", uses[i], text);
    }

    graph_begin(graph);
    r = add_resources(graph);
    pass = graph_dispatch(graph, &(struct graph_dispatch){.name = "dispatch", .pipeline = {.shader = &shader}, GRAPH_PUSH(push)});
    graph_dispatch(graph, &(struct graph_dispatch){.pass = pass, .pipeline = {.shader = &shader}, GRAPH_PUSH(other)});
    graph_add_row(pass, graph_reads(&push.counts, r.counts)); /* of the first one */
    expect_misuse(graph, "pass 'dispatch' has a row for 'counts' whose member is outside of its");

    graph = make_graph();
    graph_dispatch(graph, &(struct graph_dispatch){.pass = pass_of(graph, "by hand"), .pipeline = {.shader = &shader}, .groups = {1}});
    expect_misuse(graph, "pass 'by hand' is given one more dispatch, but graph_dispatch did not add it");

    graph = make_graph();
    const char large[GPU_PUSH_BYTES + 4] = {0};
    pass = graph_dispatch(graph, &(struct graph_dispatch){.name = "dispatch", .pipeline = {.shader = &shader}, .groups = {1}});
    graph_dispatch(graph, &(struct graph_dispatch){.pass = pass, .pipeline = {.shader = &shader}, GRAPH_PUSH(large)});
    expect_misuse(graph, "pass 'dispatch' has 132 bytes of push constants, which is more than 128");
}

static void test_dispatches_allocate_nothing(void **state) {
    UNUSED(state);
    struct graph *graph = make_graph();
    for (uint32_t frame = 0; frame < 8; frame++) {
        if (frame == 4) allocation_count = 0;
        graph_begin(graph);
        struct resources r = add_resources(graph);
        add_dispatch(graph, &r);
        add_reader(graph, &r);
        assert_int_equal(graph_compile(graph), FNL_OK);
    }
    assert_int_equal(allocation_count, 0);
    graph_destroy(&graph);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_uses_follow_from_rows),
        cmocka_unit_test(test_a_row_without_a_member_is_a_use),
        cmocka_unit_test(test_misuse_of_rows),
        cmocka_unit_test(test_one_more_dispatch_in_a_pass),
        cmocka_unit_test(test_dispatches_allocate_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
