/* SPDX-License-Identifier: MIT */
/** The numbers of all steps and orders. */
#include "render/orders/order.h"
#include "render/shadows/method.h"
#include "render/step.h"

/* Of the steps; of what finds shadows; then those of each order. */
enum { FIRST_ORDER = FRAME_STEP_COUNT + FNL_SHADOWS_AUTO, TABLE_COUNT = FIRST_ORDER + FNL_SHADING_AUTO };

uint32_t counter_table_count(void) { return TABLE_COUNT; }

const struct counter_table *counter_table_at(uint32_t index, uint32_t *out_shadings) {
    *out_shadings = UINT32_MAX;
    if (index < FRAME_STEP_COUNT) return frame_step_at(index)->counters;
    if (index < FIRST_ORDER) return shadow_method((fnl_shadows)(index - FRAME_STEP_COUNT))->counters;
    const struct counter_table *table = shading_order((fnl_shading)(index - FIRST_ORDER))->counters;
    *out_shadings = 0;
    bool is_first = true;
    for (uint32_t i = 0; i < FNL_SHADING_AUTO; i++) {
        if (shading_order((fnl_shading)i)->counters != table) continue;
        *out_shadings |= 1u << i;
        is_first &= i >= index - FIRST_ORDER;
    }
    return is_first ? table : NULL;
}
