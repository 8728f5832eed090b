/* SPDX-License-Identifier: MIT */
/** The radix sort against qsort on the CPU. */
#include "passes/geometry/radix_sort.h"
#include "tests/render_harness.h"

struct pair {
    uint32_t key, value;
};

static uint32_t low_bits(uint32_t key, uint32_t bits) { return bits == 32 ? key : key & ((1u << bits) - 1); }
static uint32_t compared_bits;

static int compare(const void *a, const void *b) {
    const struct pair *x = a, *y = b;
    uint32_t i = low_bits(x->key, compared_bits), k = low_bits(y->key, compared_bits);
    if (i != k) return i < k ? -1 : 1;
    return x->value < y->value ? -1 : x->value > y->value; /* values ascend: equal keys keep their order */
}

struct copy_data {
    graph_buffer from, to;
    uint64_t size;
};

static void execute_copy(const struct graph_context *context, const void *data) {
    const struct copy_data *d = data;
    gpu_copy_buffer(context->commands, graph_get_buffer(context, d->from), 0, graph_get_buffer(context, d->to), 0, d->size);
}

static void execute_nothing(const struct graph_context *context, const void *data) {
    UNUSED(context);
    UNUSED(data);
}

/* Sorts the first `count` of `capacity` pairs on the device; the result is to be freed. */
static struct pair *sort(const struct pair *pairs, uint32_t capacity, uint32_t count, uint32_t bits) {
    gpu_device *device = harness_device();
    struct graph *graph;
    struct gpu_buffer in, counts, out;
    assert_int_equal(graph_create(gpu_host(device), device, &graph), FNL_OK);
    assert_int_equal(gpu_buffer_create(device, "in", capacity * 8ull, GPU_MEMORY_UPLOAD, &in), FNL_OK);
    assert_int_equal(gpu_buffer_create(device, "counts", 16, GPU_MEMORY_UPLOAD, &counts), FNL_OK);
    assert_int_equal(gpu_buffer_create(device, "out", capacity * 8ull, GPU_MEMORY_READBACK, &out), FNL_OK);
    memcpy(in.mapped, pairs, capacity * 8ull);
    ((uint32_t *)counts.mapped)[1] = count;
    graph_begin(graph);
    assert_int_equal(gpu_frame_begin(device), FNL_OK);
    struct radix_sort_params params = {
        .what = "test", .pairs = graph_import_buffer(graph, "in", &in), .capacity = capacity, .bits = bits};
    if (count < capacity) {
        params.count = graph_import_buffer(graph, "counts", &counts);
        params.count_offset = 4;
    }
    struct copy_data copy = {radix_sort_add(graph, &params), graph_import_buffer(graph, "out", &out), capacity * 8ull};
    struct graph_pass *pass = graph_add_pass(graph, "read", GRAPH_QUEUE_GRAPHICS, execute_copy, &copy, sizeof copy);
    graph_use_buffer(pass, copy.from, GRAPH_COPY_FROM);
    graph_use_buffer(pass, copy.to, GRAPH_COPY_TO);
    pass = graph_add_pass(graph, "host", GRAPH_QUEUE_GRAPHICS, execute_nothing, NULL, 0);
    graph_use_buffer(pass, copy.to, GRAPH_READ_HOST);
    assert_int_equal(graph_compile(graph), FNL_OK);
    assert_int_equal(graph_execute_frame(graph, NULL), FNL_OK);
    assert_int_equal(gpu_wait_idle(device), FNL_OK);
    struct pair *sorted = malloc(capacity * sizeof *sorted);
    assert_non_null(sorted);
    memcpy(sorted, out.mapped, capacity * sizeof *sorted);
    graph_destroy(&graph);
    gpu_buffer_destroy(device, &in);
    gpu_buffer_destroy(device, &counts);
    gpu_buffer_destroy(device, &out);
    return sorted;
}

/* All sizes round a thread's, a block's; keys that are random, few, all equal, sorted, sorted backwards. */
static void check(uint32_t count, uint32_t spare, uint32_t bits, int pattern) {
    struct random_state random = {count * 31 + bits};
    uint32_t capacity = count + spare;
    struct pair *pairs = malloc(capacity * sizeof *pairs);
    assert_non_null(pairs);
    for (uint32_t i = 0; i < capacity; i++) {
        uint32_t keys[] = {(uint32_t)random_bits(&random), (uint32_t)random_bits(&random) % 7 * 0x1010101u, 0xdeadbeefu,
                           i * 3, ~i};
        pairs[i] = (struct pair){keys[pattern], i};
    }
    struct pair *sorted = sort(pairs, capacity, count, bits);
    compared_bits = bits;
    qsort(pairs, count, sizeof *pairs, compare);
    assert_memory_equal(sorted, pairs, count * sizeof *pairs);
    free(sorted);
    free(pairs);
}

static void test_keys_stable_ES_57(void **state) {
    UNUSED(state);
    static const uint32_t counts[] = {1, 2, 15, 16, 17, 63, 1023, 1024, 1025, 4097, 70001};
    for (uint32_t c = 0; c < COUNT_OF(counts); c++)
        for (int pattern = 0; pattern < 5; pattern++) check(counts[c], 0, 32, pattern);
}

static void test_bits_and_counts_ES_57(void **state) {
    UNUSED(state);
    for (uint32_t bits = 1; bits <= 32; bits += 5) {
        uint32_t rounded = DIVIDE_UP(bits, 4) * 4; /* whole steps of four */
        check(3001, 0, rounded, 0);
        check(3001, 1, rounded, 1);
        check(3001, 5000, rounded, 0);
        check(0, 2000, rounded, 0);
    }
}

static void test_a_million_keys_ES_57(void **state) {
    UNUSED(state);
    check(1 << 20, 0, 32, 0);
    check((1 << 20) - 1, 1, 24, 1);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_keys_stable_ES_57, harness_check),
        cmocka_unit_test_teardown(test_bits_and_counts_ES_57, harness_check),
        cmocka_unit_test_teardown(test_a_million_keys_ES_57, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
