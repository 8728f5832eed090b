/* SPDX-License-Identifier: MIT */
/**
 * Each pool, too small in a renderer's first frame: the frame says so and shows the same picture, or the one that its page promises; the pool
 * grows to what the frame needed, so that the next frame fits, and no further.
 */
#include "fanal/options.h"
#include "tests/render_harness.h"

struct pool_case {
    const char *name;
    fnl_shading shading;
    const char *settings[3][2];
    uint32_t too_small;
    size_t pool;       /* which member of fnl_renderer */
    const char *wants; /* counter of what a pool must hold; NULL: none says it */
    const char *overflow;  /* the counter; NULL: a member of the statistics */
    size_t member;
    bool other; /* a frame that overflows is drawn in another way, whose picture is close */
};

#define POOL(member_) .pool = offsetof(struct fnl_renderer, member_)
#define STAT(member_) .member = offsetof(fnl_frame_stats, member_)

static const struct pool_case pool_cases[] = {
    {"lists of lights", FNL_SHADING_DEFERRED, {{"lists", "tiled"}}, 8, POOL(lists.pool_capacity), .overflow = NULL, STAT(overflow_cells)},
    {"fragments", FNL_SHADING_FORWARD, {{"transparency", "linked"}}, 16, POOL(shading.blend_capacity), "transparency.fragments", "transparency.overflow-pixels",
     .other = true},
    {"list of decals", FNL_SHADING_DEFERRED, {{"decals", "lists"}}, 7, POOL(decals.capacity), "decals.entries", "decals.overflow"},
    {"tiles of decals", FNL_SHADING_DEFERRED, {{"decals", "gbuffer"}}, 7, POOL(decals.capacity), NULL, "decals.overflow"},
    {"clusters", FNL_SHADING_FORWARD_PREPASS, {{"culling", "clusters"}}, 1, POOL(culling.cluster_capacity), .overflow = NULL, STAT(items_whole)},
    {"triangles", FNL_SHADING_FORWARD_PREPASS, {{"culling", "triangles"}}, 1, POOL(culling.triangle_capacity), .overflow = NULL, STAT(items_whole)},
    {"triangles of dais", FNL_SHADING_DAIS, {{"dais.mode", "target"}}, 700, POOL(shading.dais_capacity), NULL, "dais.overflow", .other = true},
    {"elements of dais", FNL_SHADING_DAIS, {{"dais.mode", "list"}, {"msaa", "4"}}, 4, POOL(shading.dais_node_capacity), "dais.list-elements", "dais.overflow",
     .other = true},
};

static uint32_t *pool_of(fnl_renderer *r, const struct pool_case *c) { return (uint32_t *)((char *)r + c->pool); }

static uint64_t overflow_of(const fnl_frame_stats *stats, const struct pool_case *c) {
    if (!c->overflow) return *(const uint32_t *)((const char *)stats + c->member);
    const fnl_counter *counter = fnl_counter_find(stats, c->overflow);
    assert_non_null(counter);
    assert_int_equal(counter->kind, FNL_COUNTER_OVERFLOW); /* by which programs know that it is worth while to render again */
    return counter->value;
}

static void test_pool(struct stage *stage, const struct pool_case *c) {
    fnl_frame frame = stage->frame;
    frame.shading = c->shading;
    frame.lists = FNL_LISTS_TILED;
    for (uint32_t i = 0; i < COUNT_OF(c->settings) && c->settings[i][0]; i++)
        assert_int_equal(fnl_frame_set(NULL, &frame, c->settings[i][0], c->settings[i][1]), FNL_OK);
    struct shot fits = stage_shoot(stage, &frame);
    if (overflow_of(&fits.stats, c)) fail_msg("%s: there is no room from the start", c->name);

    struct stage own = {.scene = stage->scene, .frame = frame};
    assert_int_equal(fnl_renderer_create(harness_device(), own.scene, &own.renderer), FNL_OK);
    own.renderer->culling.cluster_capacity = own.renderer->culling.triangle_capacity = 1 << 17; /* 0 would make the first frame choose them */
    *pool_of(own.renderer, c) = c->too_small;
    harness_hooks(own.renderer)->fixed_pools = true;
    struct shot over = stage_shoot(&own, &frame);
    if (!overflow_of(&over.stats, c)) fail_msg("%s: %u are enough", c->name, c->too_small);
    uint64_t differing = count_differing(&fits.radiance, &over.radiance);
    if (c->other ? differing == 0 || greatest_difference(&fits.color, &over.color) > 16 : differing != 0)
        fail_msg("%s: %llu pixels differ without room, by %d at most", c->name, (unsigned long long)differing,
                 greatest_difference(&fits.color, &over.color));
    const uint32_t grown = *pool_of(own.renderer, c);
    assert_true(grown > c->too_small);
    if (c->wants) {
        uint64_t needed = counter(&fits.stats, c->wants);
        print_message("%s: %u, %llu needed\n", c->name, grown, (unsigned long long)needed);
        assert_true(grown >= needed && needed > c->too_small);
        assert_true(grown <= needed + needed / 4 + 4 || grown == *pool_of(stage->renderer, c)); /* as large as they start */
    }

    struct shot next = stage_shoot(&own, &frame);
    if (overflow_of(&next.stats, c)) fail_msg("%s: the next frame has no room either", c->name);
    assert_int_equal(count_differing(&fits.radiance, &next.radiance), 0);
    assert_int_equal(*pool_of(own.renderer, c), grown); /* what fits does not grow it */
    shot_free(&fits);
    shot_free(&over);
    shot_free(&next);
    fnl_renderer_destroy(&own.renderer);
}

static void test_pools_grow_for_the_next_frame(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:glass?lights=40", 0);
    assert_int_equal(fnl_scene_scatter_decals(stage.scene, 200, 1), FNL_OK);
    stage.frame.width = 97;
    stage.frame.height = 55;
    for (uint32_t i = 0; i < COUNT_OF(pool_cases); i++) test_pool(&stage, &pool_cases[i]);
    stage_close(&stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test_teardown(test_pools_grow_for_the_next_frame, harness_check)};
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
