/* SPDX-License-Identifier: MIT */
/**
 * Every light list gives the same picture with several samples a pixel: bit-equal radiance for one shading order. Where in a pixel an edge is
 * shaded may depend on what the depth test has left of it, so only pictures of one order are compared. lists_test.c tries every pair with one
 * sample; how a list is walked knows nothing of samples, so that here each list meets several orders, and each order several lists.
 */
#include "tests/list_pairs.h"

struct scene_case {
    const char *source;
    float ev;
};

static fnl_frame frame_of(const struct stage *stage, float ev) {
    fnl_frame frame = stage->frame;
    frame.ev = ev;
    frame.msaa = 4;
    frame.width = 61;
    frame.height = 37;
    return frame;
}

static void test_scene(void **state) {
    const struct scene_case *c = *state;
    struct stage stage = stage_open(c->source, 0);
    pairs_check_orders(&stage, frame_of(&stage, c->ev));
    stage_close(&stage);
}

/* Orders that hardly any list serves, which the turns may miss. */
static void test_orders_with_few_lists(void **state) {
    UNUSED(state);
    static const fnl_shading orders[] = {FNL_SHADING_DEFERRED_VOLUMES, FNL_SHADING_PRE_LIGHTING, FNL_SHADING_LIGHT_INDEXED, FNL_SHADING_ZIOMA};
    struct stage stage = stage_open("builtin:hall?lights=256", 0);
    fnl_frame frame = frame_of(&stage, 3);
    for (uint32_t i = 0; i < COUNT_OF(orders); i++) {
        frame.shading = orders[i];
        struct shot all = pairs_check_lists(&stage, frame, 1, 0);
        shot_free(&all);
    }
    stage_close(&stage);
}

/* After the tests above. */
static void test_many_pairs_were_tried(void **state) {
    UNUSED(state);
    pairs_check_tried(4, 3);
}

/* ---- decals ---- */

/* The list of decals with several samples: clusters, a tree and the spare list, which serves cells that overflow, give the same bits. */
static void test_decals_and_samples(void **state) {
    UNUSED(state);
    static const fnl_shading orders[] = {FNL_SHADING_FORWARD_PREPASS, FNL_SHADING_DEFERRED, FNL_SHADING_VISIBILITY};
    struct stage stage = stage_open("builtin:hall?lights=16&decals=300", 0);
    fnl_frame frame = stage.frame;
    frame.width = 97;
    frame.height = 55;
    frame.ev = 3;
    frame.msaa = 4;
    frame.lists = FNL_LISTS_CLUSTERED;
    const uint32_t capacity = stage.renderer->decals.capacity, tree = stage.renderer->decals.tree_from;
    for (uint32_t s = 0; s < COUNT_OF(orders); s++) {
        frame.shading = orders[s];
        struct shot shots[3];
        for (uint32_t way = 0; way < COUNT_OF(shots); way++) {
            stage.renderer->decals.capacity = way == 2 ? 1 : capacity;
            stage.renderer->decals.tree_from = way == 1 ? 1 : tree;
            memset(stage.renderer->slots.views, 0, sizeof stage.renderer->slots.views);
            shots[way] = stage_shoot(&stage, &frame);
            assert_int_equal(counter(&shots[way].stats, "decals.overflow") > 0, way == 2);
            uint64_t differing = count_differing(&shots[0].radiance, &shots[way].radiance);
            if (differing) fail_msg("%s, way %u: %llu pixels differ", pair_name(&frame), way, (unsigned long long)differing);
        }
        frame.decals = FNL_DECALS_OFF;
        struct shot none = stage_shoot(&stage, &frame);
        frame.decals = FNL_DECALS_LISTS;
        assert_true(count_differing(&none.radiance, &shots[0].radiance) > 100);
        shot_free(&none);
        for (uint32_t way = 0; way < COUNT_OF(shots); way++) shot_free(&shots[way]);
    }
    stage_close(&stage);
}

#define SCENE(name, source, ev)                                                                                             \
    {                                                                                                                       \
        "EQ of all orders and lists, MP-23: " name, test_scene, NULL, harness_check,                                        \
            &(struct scene_case) {                                                                                          \
            source, ev                                                                                                      \
        }                                                                                                                   \
    }

int main(void) {
    const struct CMUnitTest tests[] = {
        SCENE("hall", "builtin:hall?lights=256", 3),
        SCENE("interior", "builtin:interior", 5),
        SCENE("city", "builtin:city?blocks=1&lights=160", 3),
        SCENE("pole", "builtin:pole", 5),
        SCENE("grass", "builtin:grass", 5),
        SCENE("glass", "builtin:glass", 5),
        cmocka_unit_test_teardown(test_orders_with_few_lists, harness_check),
        cmocka_unit_test_teardown(test_many_pairs_were_tried, harness_check),
        cmocka_unit_test_teardown(test_decals_and_samples, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
