/* SPDX-License-Identifier: MIT */
#include "tests/list_pairs.h"

#include "render/shading.h"

const char *pair_name(const fnl_frame *frame) {
    static char text[96];
    snprintf(text, sizeof text, "%s + %s at %ux%u, %u samples", fnl_value_name(FNL_ENUM_SHADING, frame->shading),
             fnl_value_name(FNL_ENUM_LISTS, frame->lists), frame->width, frame->height, frame->msaa);
    return text;
}

/* Which pairs were compared, with one sample a pixel and with several. */
static uint32_t tried[2][FNL_SHADING_AUTO][FNL_LISTS_COUNT];

static bool is_comparable(fnl_shading shading, fnl_light_lists lists, uint32_t msaa) {
    if (!fnl_shading_supports(shading, lists, msaa)) return false;
    /* Lists of blended surfaces alone, which all orders draw alike. */
    if (shading_is(shading, SHADING_VOLUMES)) return lists == FNL_LISTS_TILED || lists == FNL_LISTS_CLUSTERED;
    return msaa == 1 || (lists != FNL_LISTS_BATCHES && lists != FNL_LISTS_MULTIPASS); /* for which mesh lists stand in */
}

/* Shoots what the others are compared with. */
static struct shot shoot_all(struct stage *stage, fnl_frame frame) {
    frame.lists = FNL_LISTS_ALL;
    struct shot all = stage_shoot(stage, &frame);
    assert_int_equal(count_broken(&all.radiance), 0);
    if (frame.shading == FNL_SHADING_VIRTUAL_TEXTURING) /* pages come with the frames that want them */
        for (int i = 0; i < 3; i++) {
            shot_free(&all);
            all = stage_shoot(stage, &frame);
        }
    return all;
}

static void check_list(struct stage *stage, fnl_frame frame, fnl_light_lists lists, const struct shot *all) {
    frame.lists = lists;
    if (lists == FNL_LISTS_MULTIPASS && all->stats.lights_total > 128) return; /* draws all that overflows once per light */
    tried[frame.msaa > 1][frame.shading][lists]++;
    struct shot shot = stage_shoot(stage, &frame);
    if (shot.stats.overflow_cells) { /* right already, but the pool has to grow first */
        assert_int_equal(count_differing(&all->radiance, &shot.radiance), 0);
        shot_free(&shot);
        shot = stage_shoot(stage, &frame);
    }
    uint64_t differing = count_differing(&all->radiance, &shot.radiance);
    if (differing)
        fail_msg("%s: %llu pixels differ from all, %d/255 at most", pair_name(&frame), (unsigned long long)differing,
                 greatest_difference(&all->color, &shot.color));
    /* Lights that volumes write into pixels have so many layers; pixels with more are counted, and take all lights. */
    if (shot.stats.overflow_cells && !shading_is(frame.shading, SHADING_VOLUMES))
        fail_msg("%s: %u cells overflow", pair_name(&frame), shot.stats.overflow_cells);
    assert_int_equal(shot.stats.lights_total, all->stats.lights_total);
    shot_free(&shot);
}

struct shot pairs_check_lists(struct stage *stage, fnl_frame frame, uint32_t step, uint32_t phase) {
    struct shot all = shoot_all(stage, frame);
    for (uint32_t l = FNL_LISTS_TILED; l < FNL_LISTS_COUNT; l++)
        if (l % step == phase % step && is_comparable(frame.shading, (fnl_light_lists)l, frame.msaa))
            check_list(stage, frame, (fnl_light_lists)l, &all);
    return all;
}

enum { ORDERS = FNL_SHADING_AUTO, STEP = 5 }; /* which have no common divisor; turns that follow one another seldom meet the same order */

/*
 * The order that tries a list in a turn. Each turn sees each list once. The orders go round: as many turns as there are orders see every pair
 * that can be compared.
 */
static fnl_shading order_of_list(fnl_light_lists lists, uint32_t turn, uint32_t msaa) {
    for (uint32_t k = 0; k < ORDERS; k++) {
        fnl_shading shading = (fnl_shading)(((uint32_t)lists + STEP * turn + k) % ORDERS);
        if (is_comparable(shading, lists, msaa)) return shading;
    }
    return FNL_SHADING_AUTO;
}

static bool has_lists(fnl_shading shading, uint32_t turn, uint32_t msaa) {
    for (uint32_t l = FNL_LISTS_TILED; l < FNL_LISTS_COUNT; l++)
        if (order_of_list((fnl_light_lists)l, turn, msaa) == shading) return true;
    return false;
}

void pairs_check_orders(struct stage *stage, fnl_frame frame) {
    static uint32_t turns[2]; /* of one sample and several */
    const uint32_t turn = turns[frame.msaa > 1]++;
    struct shot first = {0};
    for (uint32_t s = 0; s < ORDERS; s++) {
        frame.shading = (fnl_shading)s;
        if (!fnl_shading_supports(frame.shading, FNL_LISTS_AUTO, frame.msaa)) continue;
        if (frame.msaa > 1 && s > 0 && !has_lists(frame.shading, turn, frame.msaa)) continue;
        struct shot all = shoot_all(stage, frame);
        for (uint32_t l = FNL_LISTS_TILED; l < FNL_LISTS_COUNT; l++)
            if (order_of_list((fnl_light_lists)l, turn, frame.msaa) == frame.shading) check_list(stage, frame, (fnl_light_lists)l, &all);
        if (s == 0) {
            first = all;
            continue;
        }
        int difference = greatest_difference(&first.color, &all.color);
        if (difference > PAIRS_ALLOWED && frame.msaa == 1 && !shading_is(frame.shading, SHADING_APPROXIMATE))
            fail_msg("%s: %d/255 from forward", pair_name(&frame), difference);
        shot_free(&all);
    }
    shot_free(&first);
}

void pairs_check_tried(uint32_t msaa, uint32_t part) {
    uint32_t of_order[ORDERS][2] = {0}, of_list[FNL_LISTS_COUNT][2] = {0}; /* pairs that can be compared, and that were */
    for (uint32_t s = 0; s < ORDERS; s++)
        for (uint32_t l = FNL_LISTS_TILED; l < FNL_LISTS_COUNT; l++) {
            const bool pair[2] = {is_comparable((fnl_shading)s, (fnl_light_lists)l, msaa), tried[msaa > 1][s][l] > 0};
            for (uint32_t k = 0; k < 2; k++) {
                of_order[s][k] += pair[k];
                of_list[l][k] += pair[k];
            }
        }
    for (uint32_t s = 0; s < ORDERS; s++)
        if (of_order[s][1] * part < of_order[s][0])
            fail_msg("%s at %u samples was tried with %u of %u lists", fnl_value_name(FNL_ENUM_SHADING, (fnl_shading)s), msaa, of_order[s][1],
                     of_order[s][0]);
    for (uint32_t l = FNL_LISTS_TILED; l < FNL_LISTS_COUNT; l++)
        if (of_list[l][1] * part < of_list[l][0])
            fail_msg("%s at %u samples was tried with %u of %u orders", fnl_value_name(FNL_ENUM_LISTS, (fnl_light_lists)l), msaa, of_list[l][1],
                     of_list[l][0]);
}
