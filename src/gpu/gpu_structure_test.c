/* SPDX-License-Identifier: MIT */
/* Acceleration structures: what rays meet in them as built, updated and compacted, and the memory that they take. */
#include "tests/gpu_test.h"

enum { SQUARES = 64, RAYS = 2 };

struct world {
    struct gpu_buffer positions, indices, instances, scratch, to;
    struct gpu_structure bottom, top, smaller;
    struct gpu_structure_queries queries;
    struct gpu_structure_build builds[2];
    const struct gpu_structure *shown;
    bool updates, measures, compacts;
};

/* Squares at z 0, 1, 2 … of two triangles each; the first of each holds the corner. */
static void place(struct world *w, float x) {
    fnl_vec3 *at = w->positions.mapped;
    uint32_t *indices = w->indices.mapped;
    static const uint32_t corners[] = {0, 1, 2, 2, 1, 3};
    for (uint32_t i = 0; i < SQUARES * 4; i++) at[i] = (fnl_vec3){x + (float)(i & 1), (float)(i >> 1 & 1), (float)(i / 4)};
    for (uint32_t i = 0; i < SQUARES * 6; i++) indices[i] = i / 6 * 4 + corners[i % 6];
}

static void record(struct gpu_commands *commands, void *context) {
    struct world *w = context;
    w->builds[0].update = w->updates;
    if (w->compacts)
        gpu_compact_structure(commands, &w->bottom, &w->smaller);
    else
        gpu_build_structures(commands, &w->builds[0], 1, &w->scratch);
    test_barrier(commands);
    if (w->measures) gpu_measure_structures(commands, &w->queries, 0, &w->bottom, 1);
    VkAccelerationStructureInstanceKHR *instance = w->instances.mapped;
    *instance = (VkAccelerationStructureInstanceKHR){.transform.matrix = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}},
                                                     .instanceCustomIndex = 7,
                                                     .mask = 0xff,
                                                     .accelerationStructureReference = w->shown->address};
    gpu_build_structures(commands, &w->builds[1], 1, &w->scratch);
    test_barrier(commands);
    test_dispatch(commands, TEST_TRACE, 0, &(struct test_push){.from = w->top.address, .to = w->to.address, .count = RAYS, .u = 2.5f});
    test_barrier(commands);
}

/* Of the squares, the ray of this number meets the two at z 0 and 1, the other one none. */
static void expect_met(gpu_device *device, struct world *w, uint32_t number) {
    const fnl_vec4 *found = w->to.mapped;
    memset(w->to.mapped, 0xff, w->to.size);
    test_run(device, record, w);
    assert_float_equal(found[number].x, 2, 0);
    assert_float_equal(found[number].y, 7, 0);
    assert_true(found[number].z == 0 || found[number].z == 2);
    assert_float_equal(found[number].w, 1 + found[number].z / 2, 1e-5);
    assert_float_equal(found[1 - number].x, 0, 0);
}

static void test_rays_meet_what_is_there(void **state) {
    UNUSED(state);
    gpu_device *device = test_device_create(NULL);
    if (!gpu_info(device)->ray_query) {
        test_device_destroy(&device);
        skip();
    }
    for (int changes = 0; changes < 2; changes++) {
        struct world w = {.shown = &w.bottom};
        assert_int_equal(gpu_buffer_create(device, "positions", SQUARES * 4 * 12, GPU_MEMORY_UPLOAD, &w.positions), FNL_OK);
        assert_int_equal(gpu_buffer_create(device, "indices", SQUARES * 6 * 4, GPU_MEMORY_UPLOAD, &w.indices), FNL_OK);
        assert_int_equal(gpu_buffer_create(device, "instances", 64, GPU_MEMORY_UPLOAD, &w.instances), FNL_OK);
        assert_int_equal(gpu_buffer_create(device, "to", RAYS * 16, GPU_MEMORY_READBACK, &w.to), FNL_OK);
        place(&w, 0);
        w.builds[0] = (struct gpu_structure_build){.input = {.count = SQUARES * 2,
                                                             .positions = w.positions.address,
                                                             .indices = w.indices.address,
                                                             .vertex_count = SQUARES * 4,
                                                             .changes = changes},
                                                   .to = &w.bottom};
        w.builds[1] = (struct gpu_structure_build){.input = {.count = 1, .instances = w.instances.address, .of_instances = true}, .to = &w.top};
        const struct gpu_structure_sizes bottom = gpu_structure_sizes(device, &w.builds[0].input), top = gpu_structure_sizes(device, &w.builds[1].input);
        const uint64_t scratch = MAX(bottom.build_scratch, bottom.update_scratch) + top.build_scratch;
        w.builds[1].scratch = scratch - top.build_scratch;
        assert_int_equal(gpu_buffer_create(device, "scratch", scratch + gpu_scratch_padding(device), GPU_MEMORY_DEVICE, &w.scratch), FNL_OK);
        assert_int_equal(gpu_memory_stats(device).structure_bytes, 0);
        assert_int_equal(gpu_structure_create(device, "bottom", false, bottom.size, &w.bottom), FNL_OK);
        assert_int_equal(gpu_structure_create(device, "top", true, top.size, &w.top), FNL_OK);
        assert_true(gpu_memory_stats(device).structure_bytes >= bottom.size + top.size);
        assert_int_equal(gpu_structure_queries_create(device, 1, &w.queries), FNL_OK);
        w.measures = !changes;
        expect_met(device, &w, 0);
        w.measures = false;
        if (changes) {
            place(&w, 100);
            w.updates = true;
            expect_met(device, &w, 1);
        } else {
            uint64_t size;
            assert_true(gpu_structure_queries_read(device, &w.queries, &size));
            print_message("a structure of %u triangles: %u bytes, compacted %u\n", SQUARES * 2, (unsigned)bottom.size, (unsigned)size);
            assert_true(size > 0 && size <= bottom.size);
            assert_int_equal(gpu_structure_create(device, "smaller", false, size, &w.smaller), FNL_OK);
            w.compacts = true;
            w.shown = &w.smaller;
            expect_met(device, &w, 0);
        }
        gpu_structure_destroy(device, &w.bottom);
        gpu_structure_destroy(device, &w.smaller);
        gpu_structure_destroy(device, &w.top);
        gpu_structure_queries_destroy(device, &w.queries);
        struct gpu_buffer *const buffers[] = {&w.positions, &w.indices, &w.instances, &w.scratch, &w.to};
        for (uint32_t i = 0; i < COUNT_OF(buffers); i++) gpu_buffer_destroy(device, buffers[i]);
        assert_int_equal(gpu_wait_idle(device), FNL_OK);
        assert_int_equal(gpu_memory_stats(device).structure_bytes, 0);
    }
    test_device_destroy(&device);
}

const struct CMUnitTest structure_tests[] = {
    cmocka_unit_test(test_rays_meet_what_is_there),
};
const size_t structure_test_count = COUNT_OF(structure_tests);
