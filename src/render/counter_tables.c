/* SPDX-License-Identifier: MIT */
/** The numbers of all steps and orders. */
#include "render/orders/order.h"
#include "render/shadows/method.h"
#include "render/step.h"

/* Of the steps; of what finds shadows; then those of each order. */
enum { FIRST_ORDER = FRAME_STEP_COUNT + FNL_SHADOWS_AUTO, TABLE_COUNT = FIRST_ORDER + FNL_SHADING_AUTO };

uint32_t counter_table_count(void) { return TABLE_COUNT; }

static const struct counter_table *table_of(uint32_t index) {
    if (index < FRAME_STEP_COUNT) return frame_step_at(index)->counters;
    if (index < FIRST_ORDER) return shadow_method((fnl_shadows)(index - FRAME_STEP_COUNT))->counters;
    return shading_order((fnl_shading)(index - FIRST_ORDER))->counters;
}

/* Frames call it for each copy. A table that several paths share gets room for each of them. */
uint64_t counters_place(const struct counter_table *table) {
    uint64_t place = 0;
    for (uint32_t i = 0; i < TABLE_COUNT; i++) {
        const struct counter_table *before = table_of(i);
        if (before && before == table) break;
        place += before ? before->counts_size : 0;
    }
    return place;
}

uint64_t counters_size(void) { return counters_place(NULL); }

const struct counter_table *counter_table_at(uint32_t index, uint32_t *out_shadings) {
    const struct counter_table *table = table_of(index);
    *out_shadings = UINT32_MAX;
    if (index < FIRST_ORDER) return table;
    *out_shadings = 0;
    bool is_first = true;
    for (uint32_t i = 0; i < FNL_SHADING_AUTO; i++) {
        if (shading_order((fnl_shading)i)->counters != table) continue;
        *out_shadings |= 1u << i;
        is_first &= i >= index - FIRST_ORDER;
    }
    return is_first ? table : NULL;
}
