/* SPDX-License-Identifier: MIT */
/** Sets of lights that do not overlap. */
#include "passes/shade/light_sets.h"
#include "tests/render_test.h"

enum { LIGHTS = 3000 };
static struct gpu_entity_bounds bounds[LIGHTS];
static uint32_t codes[LIGHTS], members[INDEXED_SETS << 8];

static struct gpu_entity_bounds sphere(float x, float y, float z, float radius) {
    return (struct gpu_entity_bounds){.center = {x, y, z}, .radius = radius, .shape = GPU_NO_SHAPE};
}

static bool meet(const struct gpu_entity_bounds *a, const struct gpu_entity_bounds *b) {
    return (double)vec3_distance(a->center, b->center) < (double)a->radius + (double)b->radius;
}

static uint32_t find(uint32_t count, uint32_t sets) {
    return light_sets_find(&(struct light_sets_input){.bounds = bounds, .count = count, .set_count = sets}, codes, members);
}

/* Whatever the lights: no two of a set meet, tables agree, and one without a set meets a member of each or finds it full. */
static void check(uint32_t count, uint32_t sets, uint32_t without) {
    uint32_t sizes[INDEXED_SETS] = {0}, missing = 0;
    for (uint32_t i = 0; i < count; i++)
        if (codes[i]) sizes[codes[i] >> 8]++;
    for (uint32_t i = 0; i < count; i++) {
        if (!(bounds[i].radius > 0)) {
            assert_int_equal(codes[i], 0);
            continue;
        }
        if (codes[i]) {
            assert_true(codes[i] >> 8 < sets && (codes[i] & 255) >= 1 && (codes[i] & 255) <= sizes[codes[i] >> 8]);
            assert_int_equal(members[codes[i]], i);
        }
        bool meets[INDEXED_SETS] = {false};
        for (uint32_t j = 0; j < count; j++)
            if (j != i && codes[j] && meet(&bounds[i], &bounds[j])) meets[codes[j] >> 8] = true;
        if (codes[i])
            assert_false(meets[codes[i] >> 8]);
        else
            missing++;
        for (uint32_t s = 0; s < sets && !codes[i]; s++) assert_true(meets[s] || sizes[s] == INDEXED_BATCH);
    }
    assert_int_equal(missing, without);
}

static void test_random(void **state) {
    UNUSED(state);
    struct random_state random = {7};
    uint32_t before = UINT32_MAX;
    for (uint32_t i = 0; i < LIGHTS; i++)
        bounds[i] = sphere(random_range(&random, -30, 30), random_range(&random, 0, 8), random_range(&random, -30, 30), i % 50 ? random_range(&random, 0.5f, 2) : 0);
    for (uint32_t sets = 4; sets <= INDEXED_SETS; sets *= 2) {
        const uint32_t without = find(LIGHTS, sets);
        print_message("  %u sets: %u of %u lights without\n", sets, without, LIGHTS);
        check(LIGHTS, sets, without);
        assert_true(without < before || without == 0);
        before = without;
    }
    assert_int_equal(before, 0);
}

/* Lights apart fill one set after the other, 255 each; the next one has none. */
static void test_full(void **state) {
    UNUSED(state);
    for (uint32_t i = 0; i < 4 * INDEXED_BATCH + 2; i++) bounds[i] = sphere(10 * (float)i, 0, 0, 4.9f);
    assert_int_equal(find(4 * INDEXED_BATCH, 4), 0);
    for (uint32_t i = 0; i < 4 * INDEXED_BATCH; i++) assert_int_equal(codes[i], (i / INDEXED_BATCH) << 8 | (i % INDEXED_BATCH + 1));
    assert_int_equal(find(4 * INDEXED_BATCH + 2, 4), 2);
    assert_int_equal(codes[4 * INDEXED_BATCH], 0);
}

/* Four lights on one another take four sets, a fifth none. One that is not a number meets all; those outside of a plane need no set. */
static void test_overlaps(void **state) {
    UNUSED(state);
    for (uint32_t i = 0; i < 5; i++) bounds[i] = sphere(0.1f * (float)i, 0, 0, 1);
    assert_int_equal(find(5, 4), 1);
    for (uint32_t i = 0; i < 4; i++) assert_int_equal(codes[i], i << 8 | 1);
    bounds[0] = sphere(NAN, 0, 0, 1);
    bounds[1] = sphere(1000, 0, 0, 1);
    assert_int_equal(find(2, 1), 1);
    assert_int_equal(find(2, 2), 0);
    const vec4 plane = {1, 0, 0, -500}; /* x >= 500 */
    bounds[0] = sphere(498.9f, 0, 0, 1);
    bounds[1] = sphere(499.1f, 0, 0, 1);
    const struct light_sets_input input = {.bounds = bounds, .count = 2, .planes = &plane, .plane_count = 1, .set_count = 1};
    assert_int_equal(light_sets_find(&input, codes, members), 0);
    assert_int_equal(codes[0], 0);
    assert_int_equal(codes[1], 1);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_random),
        cmocka_unit_test(test_full),
        cmocka_unit_test(test_overlaps),
    };
    return cmocka_run_group_tests_name("ES-26: sets of lights that do not overlap", tests, NULL, NULL);
}
