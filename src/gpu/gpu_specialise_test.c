/* SPDX-License-Identifier: MIT */
/* Shaders whose constants are known before the driver sees them. */
#include "gpu/specialise.h"
#include "shaders.h"
#include "tests/gpu_test.h"

typedef uint32_t uint;
#define WALK static uint
#include "gpu/gpu_test_walk.h"

enum { COUNT = 128, CONSTANTS = 6, OP_SPEC_CONSTANT_TRUE = 48, OP_SPEC_CONSTANT_OP = 52, OP_LABEL = 248, OP_LOOP_MERGE = 246 };

struct dispatch {
    struct gpu_buffer from, to;
    uint32_t constants[CONSTANTS];
};

static void record(struct gpu_commands *commands, void *context) {
    struct dispatch *dispatch = context;
    struct gpu_compute_params params = {.shader = &shader_gpu_test_walk_comp, .constant_count = CONSTANTS};
    memcpy(params.constants, dispatch->constants, sizeof dispatch->constants);
    gpu_bind(commands, gpu_compute_pipeline(gpu_commands_device(commands), &params));
    const struct test_push push = {.from = dispatch->from.address, .to = dispatch->to.address, .count = COUNT};
    gpu_push(commands, &push, offsetof(struct test_push, width));
    gpu_dispatch(commands, DIVIDE_UP(COUNT, dispatch->constants[2]), 1, 1);
    test_barrier(commands);
}

/* Branches, cases that fall through, loops that are left at once, in the middle or never, returns from deep within; validation reads what is made. */
static void test_what_is_left_computes_the_same(void **state) {
    UNUSED(state);
    gpu_device *device = test_device_create(NULL);
    struct dispatch d;
    assert_int_equal(gpu_buffer_create(device, "from", COUNT * 4, GPU_MEMORY_UPLOAD, &d.from), FNL_OK);
    assert_int_equal(gpu_buffer_create(device, "to", COUNT * 4, GPU_MEMORY_READBACK, &d.to), FNL_OK);
    uint32_t *from = d.from.mapped, *to = d.to.mapped;
    for (uint32_t i = 0; i < COUNT; i++) from[i] = i;
    static const uint32_t turns[] = {0, 1, 6};
    for (uint32_t mode = 0; mode < 8; mode++)
        for (uint32_t k = 0; k < COUNT_OF(turns); k++) {
            const bool doubled = mode & 1;
            const uint32_t shift = k == 2 ? 3 : 0xffffffffu;
            const float scale = k == 1 ? 2.5f : 1.25f;
            const uint32_t constants[CONSTANTS] = {mode, turns[k], k == 0 ? 32 : 16, doubled};
            memcpy(d.constants, constants, sizeof constants);
            memcpy(&d.constants[4], &scale, 4);
            d.constants[5] = shift;
            memset(to, 0, COUNT * 4);
            test_run(device, record, &d);
            for (uint32_t i = 0; i < COUNT; i++) {
                uint32_t expected = walk(mode, turns[k], i) * (doubled ? 2 : 1);
                expected = shift == 3 ? expected << 3 : expected + (uint32_t)(4 * scale);
                if (to[i] != expected) fail_msg("mode %u, %u turns: %u becomes %u, not %u", mode, turns[k], i, to[i], expected);
            }
        }
    gpu_buffer_destroy(device, &d.from);
    gpu_buffer_destroy(device, &d.to);
    test_device_destroy(&device);
}

static uint32_t count_operations(const struct gpu_spirv *spirv, uint32_t first, uint32_t last) {
    uint32_t count = 0;
    for (size_t i = 5; i < spirv->count; i += spirv->words[i] >> 16) {
        assert_true(spirv->words[i] >> 16 > 0);
        count += (spirv->words[i] & 0xffff) >= first && (spirv->words[i] & 0xffff) <= last;
    }
    return count;
}

static struct gpu_spirv specialise(const struct gpu_shader *shader, uint32_t count, const struct gpu_constant *constants) {
    const fnl_host host = fnl_host_default();
    uint32_t *code = gpu_shader_code(&host, shader);
    assert_non_null(code);
    struct gpu_spirv spirv, again;
    assert_int_equal(gpu_specialise(&host, code, shader->size / 4, count, constants, &spirv), FNL_OK);
    assert_int_equal(gpu_specialise(&host, code, shader->size / 4, count, constants, &again), FNL_OK);
    assert_int_equal(spirv.count, again.count);
    assert_memory_equal(spirv.words, again.words, spirv.count * 4);
    host_free(&host, again.words, again.size);
    host_free(&host, code, shader->size);
    return spirv;
}

/* Nothing is left that a constant could change, nor code that constants rule out; those that are not given have the values of the shader. */
static void test_what_is_ruled_out_is_gone(void **state) {
    UNUSED(state);
    const fnl_host host = fnl_host_default();
    const struct gpu_constant given[] = {{0, 5}, {1, 6}}, none[] = {{0, TEST_TRACE + 1}}, stated[] = {{0, 0}, {1, 5}};
    struct gpu_spirv few = specialise(&shader_gpu_test_walk_comp, 2, given), all = specialise(&shader_gpu_test_walk_comp, 0, NULL),
                     same = specialise(&shader_gpu_test_walk_comp, 2, stated), simple = specialise(&shader_gpu_test_comp, 1, none),
                     multiply = specialise(&shader_gpu_test_comp, 0, NULL);
    assert_int_equal(all.count, same.count);
    assert_memory_equal(all.words, same.words, all.count * 4);
    const struct gpu_spirv *const made[] = {&few, &all, &simple, &multiply};
    for (uint32_t i = 0; i < COUNT_OF(made); i++) {
        assert_true(made[i]->count * 4 <= made[i]->size);
        assert_int_equal(count_operations(made[i], OP_SPEC_CONSTANT_TRUE, OP_SPEC_CONSTANT_OP), 0);
    }
    /* walk(5, 6, x) returns 77 at once, and the loops of mode 4 end in their first turn or at a return. */
    print_message("walk: %zu words; 5 and 6: %zu, %u blocks; by default %zu, %u blocks\n", shader_gpu_test_walk_comp.size / 4, few.count,
                  count_operations(&few, OP_LABEL, OP_LABEL), all.count, count_operations(&all, OP_LABEL, OP_LABEL));
    assert_true(count_operations(&few, OP_LABEL, OP_LABEL) < count_operations(&all, OP_LABEL, OP_LABEL));
    /* There is no such mode: the shader has nothing but the test of its index. A multiplication needs no images. */
    enum { STORE = 62, IMAGE_FETCH = 95, IMAGE_WRITE = 99, TYPE_IMAGE = 25 };
    assert_int_equal(count_operations(&simple, STORE, STORE) + count_operations(&simple, IMAGE_FETCH, IMAGE_WRITE), 0);
    assert_int_equal(count_operations(&multiply, STORE, STORE), 1);
    assert_int_equal(count_operations(&multiply, IMAGE_FETCH, IMAGE_WRITE), 0);
    assert_int_equal(count_operations(&multiply, TYPE_IMAGE, TYPE_IMAGE), 0);
    for (uint32_t i = 0; i < COUNT_OF(made); i++) host_free(&host, made[i]->words, made[i]->size);
    host_free(&host, same.words, same.size);
}

enum { CAPABILITY = 17, EXTENSION = 10, LOAD = 61, CONVERT = 4447, TYPE_RAY_QUERY = 4472, INITIALIZE = 4473, CANDIDATE = 4479, TYPE_STRUCTURE = 5341,
       GETTERS = 6016, LAST_GETTER = 6032 };

static void expect_queries(const struct gpu_spirv *spirv, bool traces) {
    bool capability = false, extension = false;
    for (size_t i = 5; i < spirv->count; i += spirv->words[i] >> 16) {
        const uint32_t op = spirv->words[i] & 0xffff;
        capability |= op == CAPABILITY && spirv->words[i + 1] == TYPE_RAY_QUERY;
        extension |= op == EXTENSION && strcmp((const char *)&spirv->words[i + 1], "SPV_KHR_ray_query") == 0;
    }
    assert_int_equal(capability, traces);
    assert_int_equal(extension, traces);
    assert_int_equal(count_operations(spirv, TYPE_RAY_QUERY, TYPE_RAY_QUERY), traces);
    assert_int_equal(count_operations(spirv, TYPE_STRUCTURE, TYPE_STRUCTURE), traces);
    assert_int_equal(count_operations(spirv, CONVERT, CONVERT), traces);
    assert_int_equal(count_operations(spirv, INITIALIZE, CANDIDATE) + count_operations(spirv, GETTERS, LAST_GETTER) > 0, traces);
}

/* Devices without ray queries must not see as much as their types. */
static void test_ray_queries_leave_nothing_behind(void **state) {
    UNUSED(state);
    const fnl_host host = fnl_host_default();
    for (uint32_t mode = 0; mode <= TEST_TRACE; mode++) {
        struct gpu_spirv spirv = specialise(&shader_gpu_test_comp, 1, &(struct gpu_constant){0, mode});
        expect_queries(&spirv, mode == TEST_TRACE);
        host_free(&host, spirv.words, spirv.size);
    }
    /* Not even where a number that is no id, the alignment of what is read, looks like that of a type. */
    static const uint32_t types[] = {TYPE_RAY_QUERY, TYPE_STRUCTURE};
    for (uint32_t k = 0; k < COUNT_OF(types); k++) {
        const size_t count = shader_gpu_test_comp.size / 4;
        uint32_t *code = gpu_shader_code(&host, &shader_gpu_test_comp), id = 0, patched = 0;
        for (size_t i = 5; i < count; i += code[i] >> 16)
            if ((code[i] & 0xffff) == types[k]) id = code[i + 1];
        for (size_t i = 5; i < count; i += code[i] >> 16)
            if ((code[i] & 0xffff) == LOAD && code[i] >> 16 == 6) code[i + 5] = id, patched++;
        assert_true(id > 0 && patched > 0);
        struct gpu_spirv spirv;
        assert_int_equal(gpu_specialise(&host, code, count, 2, (const struct gpu_constant[]){{0, TEST_MULTIPLY}, {1, 3}}, &spirv), FNL_OK);
        expect_queries(&spirv, false);
        host_free(&host, spirv.words, spirv.size);
        host_free(&host, code, shader_gpu_test_comp.size);
    }
}

static void test_words_that_are_no_module(void **state) {
    UNUSED(state);
    struct test_memory memory = {0};
    const fnl_host host = test_host(&memory);
    uint32_t *code = gpu_shader_code(&host, &shader_gpu_test_walk_comp);
    const size_t count = shader_gpu_test_walk_comp.size / 4;
    struct gpu_spirv spirv;
    assert_int_equal(gpu_specialise(&host, code, 4, 0, NULL, &spirv), FNL_ERROR_INVALID);
    assert_int_equal(gpu_specialise(&host, code, 6, 0, NULL, &spirv), FNL_ERROR_INVALID);
    assert_int_equal(gpu_specialise(&host, code + 1, count - 1, 0, NULL, &spirv), FNL_ERROR_INVALID);
    assert_int_equal(gpu_specialise(&host, code, count - 2, 0, NULL, &spirv), FNL_ERROR_INVALID);
    assert_null(spirv.words);
    host_free(&host, code, shader_gpu_test_walk_comp.size);
    assert_int_equal(memory.live_bytes, 0);
}

const struct CMUnitTest specialise_tests[] = {
    cmocka_unit_test(test_what_is_left_computes_the_same),
    cmocka_unit_test(test_what_is_ruled_out_is_gone),
    cmocka_unit_test(test_ray_queries_leave_nothing_behind),
    cmocka_unit_test(test_words_that_are_no_module),
};
const size_t specialise_test_count = COUNT_OF(specialise_tests);
