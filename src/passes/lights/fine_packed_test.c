/* SPDX-License-Identifier: MIT */
/** Fine-pruned tiles in 32 bytes each, and lists beside the first. */
#include "tests/fine_bench.h"

#include "passes/lights/light_proxy.h"
#include "tests/light_reference.h"

/* ---- packed ---- */

enum { PACKED_ALL = -1 };
enum { PROBE = GPU_ENTITY_DECAL + 1 }; /* a kind that only this test makes */

/* The local lights of a packed tile, or PACKED_ALL; fails unless its words have the form that the source gives them. */
static int unpack(const struct fine_copy *c, uint32_t cell, uint32_t out[GPU_PACKED_LIGHTS]) {
    const uint32_t *words = (const uint32_t *)c->data[COPY_CELLS] + (size_t)cell * GPU_PACKED_WORDS;
    const uint32_t *visible = c->data[COPY_IDS];
    int count = 0;
    if (words[0] == GPU_PACKED_ALL) {
        assert_int_equal(words[1], c->totals.in_view);
        return PACKED_ALL;
    }
    for (uint32_t w = 0; w < GPU_PACKED_WORDS; w++) {
        uint32_t held = words[w] >> 30;
        assert_true(w == 0 || held == 0 || words[w - 1] >> 30 == 3);
        for (uint32_t i = 0; i < 3; i++) {
            uint32_t place = words[w] >> 10 * i & 1023;
            if (i < held)
                out[count++] = visible[place];
            else
                assert_int_equal(place, 0);
        }
    }
    return count;
}

/* Tile by tile what the ordinary storage holds, or all in view where that is too much. */
static void check_packed(const struct fine_copy *packed, const struct fine_copy *plain) {
    uint32_t overflow = 0;
    assert_int_equal(packed->cell_count, plain->cell_count);
    assert_int_equal(packed->sizes[COPY_CELLS], packed->cell_count * 32ull);
    assert_int_equal(packed->totals.entries, plain->totals.entries);
    assert_int_equal(packed->totals.in_view, plain->totals.in_view);
    for (uint32_t cell = 0; cell < plain->cell_count; cell++) {
        uint32_t held[GPU_PACKED_LIGHTS], want = fine_cell_at(plain, cell).count;
        const uint32_t *visible = packed->data[COPY_IDS];
        int count = unpack(packed, cell, held);
        bool fits = want <= GPU_PACKED_LIGHTS;
        if (fits && want && packed->totals.in_view > 1024) fits = fine_ids_at(plain, cell)[want - 1] <= visible[1023];
        if (!fits) {
            assert_int_equal(count, PACKED_ALL);
            overflow++;
            continue;
        }
        assert_int_equal(count, want);
        if (want) assert_memory_equal(held, fine_ids_at(plain, cell), want * sizeof *held);
    }
    assert_int_equal(packed->totals.overflow_cells, overflow);
}

static struct fine_copy build_both(const struct gpu_view *view, uint32_t light_count, const float *depth, const float *front,
                                   struct fine_params p) {
    p.mask_size = 0;
    struct fine_copy plain = fine_build(view, light_count, depth, front, &p);
    p.packed = true;
    struct fine_copy packed = fine_build(view, light_count, depth, front, &p);
    check_packed(&packed, &plain);
    fine_copy_free(&plain);
    return packed;
}

static void test_packed_round_trip_FP_9_FP_10(void **state) {
    UNUSED(state);
    enum { HIDDEN = 5 };
    static const uint32_t counts[] = {0, 1, 2, 3, 4, 23, 24, 25, 70};
    fnl_camera camera = fnl_camera_default();
    struct gpu_view view = view_from_camera(&camera, 24, 20);
    float depth[24 * 20];
    for (uint32_t i = 0; i < COUNT_OF(depth); i++) depth[i] = depth_of_view_depth(&view, 10);
    struct fine_params p = fine_params_default();
    for (uint32_t n = 0; n < COUNT_OF(counts); n++) {
        for (uint32_t i = 0; i < HIDDEN; i++)
            fine_place(&view, i, 8, 8, -10, 0.4f, false); /* so that places are not indices */
        for (uint32_t i = 0; i < counts[n]; i++) fine_place(&view, HIDDEN + i, 8.5, 8.5, 10, 0.3f, false);
        struct fine_copy c = build_both(&view, HIDDEN + counts[n], depth, NULL, p);
        uint32_t held[GPU_PACKED_LIGHTS];
        int count = unpack(&c, 0, held);
        assert_int_equal(count, counts[n] <= 24 ? (int)counts[n] : PACKED_ALL);
        for (int i = 0; i < count; i++) assert_int_equal(held[i], HIDDEN + i);
        assert_int_equal(c.totals.in_view, counts[n]);
        assert_int_equal(c.totals.overflow_cells, counts[n] > 24);
        fine_copy_free(&c);
    }
    /* Places up to 1023 are stored. With one light more in view, tiles that hold it are not, and the others are. */
    for (uint32_t in_view = 1024; in_view <= 1025; in_view++) {
        for (uint32_t i = 0; i < HIDDEN; i++) fine_place(&view, i, 8, 8, -10, 0.4f, false);
        for (uint32_t i = 0; i < in_view; i++) fine_place(&view, HIDDEN + i, 8, 8, 5, 0.2f, false); /* before all surfaces */
        fine_place(&view, HIDDEN + 511, 8.5, 8.5, 10, 0.3f, false);
        fine_place(&view, HIDDEN + 1023, 8.5, 8.5, 10, 0.3f, false);
        fine_place(&view, HIDDEN + 1022, 20.5, 8.5, 10, 0.05f, false); /* the tile on the right */
        if (in_view > 1024) fine_place(&view, HIDDEN + 1024, 8.5, 8.5, 10, 0.3f, false);
        struct fine_copy c = build_both(&view, HIDDEN + in_view, depth, NULL, p);
        const uint32_t *words = c.data[COPY_CELLS];
        assert_int_equal(c.totals.in_view, in_view);
        assert_int_equal(words[0], in_view == 1024 ? 2u << 30 | 1023u << 10 | 511u : GPU_PACKED_ALL);
        assert_int_equal(words[GPU_PACKED_WORDS], 1u << 30 | 1022u);
        assert_int_equal(c.totals.overflow_cells, in_view == 1025);
        fine_copy_free(&c);
    }
}

static void test_packed_equals_plain_FP_9(void **state) {
    UNUSED(state);
    enum { LIGHTS = 140 };
    struct random_state random = {31};
    uint32_t packed_entries = 0, overflow = 0;
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++) {
        struct gpu_view view = list_random_view(kind, &random, FINE_WIDTH, FINE_HEIGHT);
        fine_random_lights(&view, &random, LIGHTS);
        for (uint32_t i = 0; i < LIGHTS; i++)
            lights[i].bounds.kind = kind == 2 && i % 3 == 0 ? PROBE : GPU_ENTITY_LIGHT;
        float *depth = list_random_depth(&view, &random), *front = list_random_depth(&view, &random);
        struct fine_params p = fine_params_default();
        p.tile_size = kind == 1 ? 8 : kind == 3 ? 32 : 16;
        p.pruning = kind != 4;
        p.blend = kind != 2;
        fine_kinds = 1u << GPU_ENTITY_LIGHT | (kind == 2 ? 1u << PROBE : 0);
        struct fine_copy c = build_both(&view, LIGHTS, kind == 3 ? NULL : depth, p.blend ? front : NULL, p);
        packed_entries += c.totals.entries;
        overflow += c.totals.overflow_cells;
        fine_copy_free(&c);
        free(depth);
        free(front);
    }
    assert_true(packed_entries > 2000 && overflow > 3);
}

/* ---- lists beside the first ---- */

/* Lights, decals and probes in one array: each kind gets a list of its own from the same dispatches, what is asked for and nothing else. */
static void test_lists_of_kinds_FP_12(void **state) {
    UNUSED(state);
    enum { LIGHTS = 120 };
    struct random_state random = {6};
    struct gpu_view view = list_random_view(0, &random, FINE_WIDTH, FINE_HEIGHT);
    fine_random_lights(&view, &random, LIGHTS);
    float *depth = list_random_depth(&view, &random);
    struct fine_params p = fine_params_default();
    struct fine_copy one = fine_build(&view, LIGHTS, depth, NULL, &p);
    for (uint32_t i = 0; i < LIGHTS; i++)
        lights[i].bounds.kind = i % 3 == 0 ? PROBE : i % 3 == 1 ? GPU_ENTITY_DECAL : GPU_ENTITY_LIGHT;
    static const uint32_t asked[] = {1u << GPU_ENTITY_LIGHT | 1u << PROBE, 1u << GPU_ENTITY_DECAL,
                                     1u << GPU_ENTITY_LIGHT | 1u << GPU_ENTITY_DECAL | 1u << PROBE};
    for (uint32_t k = 0; k < COUNT_OF(asked); k++) {
        fine_kinds = asked[k];
        struct fine_copy lists = fine_build(&view, LIGHTS, depth, NULL, &p);
        fine_check_form(&lists, LIGHTS);
        uint32_t tile_count = one.cell_count, list = 0, held[GPU_ENTITY_KINDS] = {0};
        for (uint32_t kind = 0; kind < GPU_ENTITY_KINDS; kind++) {
            if (!(asked[k] >> kind & 1)) continue;
            for (uint32_t cell = 0; cell < tile_count; cell++)
                for (uint32_t i = 0; i < LIGHTS; i++) {
                    bool is = fine_holds(&one, cell, i) && lights[i].bounds.kind == kind;
                    assert_int_equal(fine_holds(&lists, list * tile_count + cell, i), is);
                    held[kind] += is;
                }
            assert_true(held[kind] > 15);
            list++;
        }
        assert_int_equal(lists.cell_count, list * tile_count);
        fine_copy_free(&lists);
    }
    fine_kinds = 1u << GPU_ENTITY_LIGHT;
    fine_copy_free(&one);
    free(depth);
}

/* Blended surfaces: whatever reaches a point between the nearest of them and what is behind is in their list and mask. */
static void test_blended_surfaces(void **state) {
    UNUSED(state);
    enum { LIGHTS = 120 };
    struct random_state random = {16};
    uint64_t held_count = 0;
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++) {
        struct gpu_view view = list_random_view(kind, &random, FINE_WIDTH, FINE_HEIGHT);
        fine_random_lights(&view, &random, LIGHTS);
        float *depth = list_random_depth(&view, &random), *front = list_random_depth(&view, &random);
        struct fine_params p = fine_params_default();
        p.blend = true;
        struct fine_copy c = fine_build(&view, LIGHTS, depth, front, &p);
        fine_check_form(&c, LIGHTS);
        for (uint32_t y = 0; y < FINE_HEIGHT; y++)
            for (uint32_t x = 0; x < FINE_WIDTH; x++) {
                float near = front[y * FINE_WIDTH + x], far = depth[y * FINE_WIDTH + x];
                if (near <= 0 || near < far) continue;
                double from = view_depth_of_depth(&view, near), to = far > 0 ? view_depth_of_depth(&view, far) : from * 8;
                if (view.orthographic > 0.5f && far <= 0) to = from;
                uint32_t cell = c.tiles_x * c.tiles_y + y / c.tile_size * c.tiles_x + x / c.tile_size, entry = 0;
                for (uint32_t light = 0; light < LIGHTS; light++) {
                    while (entry < fine_cell_at(&c, cell).count && fine_ids_at(&c, cell)[entry] < light) entry++;
                    bool held = entry < fine_cell_at(&c, cell).count && fine_ids_at(&c, cell)[entry] == light &&
                                fine_visits(&c, cell, x, y, entry);
                    for (int k = 0; k <= 4 && !held; k++) {
                        double seen[3], point[3];
                        view_of_pixel(&view, x + 0.5, y + 0.5, from + (to - from) * k / 4, seen);
                        view_to_world(&view, seen, point);
                        if (light_reaches(&params[light], point))
                            fail_msg("%s: pixel %u %u misses light %u at %d/4", list_view_names[kind], x, y, light, k);
                    }
                    held_count += held;
                }
            }
        fine_copy_free(&c);
        free(depth);
        free(front);
    }
    assert_true(held_count > 10000);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_packed_round_trip_FP_9_FP_10, harness_check),
        cmocka_unit_test_teardown(test_packed_equals_plain_FP_9, harness_check),
        cmocka_unit_test_teardown(test_lists_of_kinds_FP_12, harness_check),
        cmocka_unit_test_teardown(test_blended_surfaces, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
