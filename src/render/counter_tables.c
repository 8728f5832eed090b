/* SPDX-License-Identifier: MIT */
/** The numbers of all steps and orders. */
#include "render/orders/order.h"
#include "render/step.h"

/* Of the steps; then those of each order. */
enum { TABLE_COUNT = FRAME_STEP_COUNT + FNL_SHADING_AUTO };

uint32_t counter_table_count(void) { return TABLE_COUNT; }

struct counter_table counter_table_at(uint32_t index, uint32_t *out_shadings) {
    *out_shadings = UINT32_MAX;
    const struct frame_step *step = frame_step_at(index);
    if (step) return (struct counter_table){step->counters, step->counter_count};
    const struct order *order = shading_order((fnl_shading)(index - FRAME_STEP_COUNT));
    struct counter_table table = {order->counters, order->counter_count};
    *out_shadings = 0;
    for (uint32_t i = FNL_SHADING_AUTO; i-- > 0 && table.count > 0;) {
        if (shading_order((fnl_shading)i)->counters != table.rows) continue;
        *out_shadings |= 1u << i;
        if (i < index - FRAME_STEP_COUNT) table.count = 0;
    }
    return table;
}
