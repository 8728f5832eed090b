/* SPDX-License-Identifier: MIT */
/** The numbers of all steps and orders. */
#include "render/orders/order.h"
#include "render/shadows/method.h"
#include "render/step.h"

/* Of the steps; of what finds shadows; then those of each order. */
enum { FIRST_ORDER = FRAME_STEP_COUNT + FNL_SHADOWS_AUTO, TABLE_COUNT = FIRST_ORDER + FNL_SHADING_AUTO };

uint32_t counter_table_count(void) { return TABLE_COUNT; }

struct counter_table counter_table_at(uint32_t index, uint32_t *out_shadings) {
    *out_shadings = UINT32_MAX;
    const struct frame_step *step = frame_step_at(index);
    if (step) return (struct counter_table){step->counters, step->counter_count};
    if (index < FIRST_ORDER) {
        const struct shadow_method *method = shadow_method((fnl_shadows)(index - FRAME_STEP_COUNT));
        return (struct counter_table){method->counters, method->counter_count};
    }
    const struct order *order = shading_order((fnl_shading)(index - FIRST_ORDER));
    struct counter_table table = {order->counters, order->counter_count};
    *out_shadings = 0;
    for (uint32_t i = FNL_SHADING_AUTO; i-- > 0 && table.count > 0;) {
        if (shading_order((fnl_shading)i)->counters != table.rows) continue;
        *out_shadings |= 1u << i;
        if (i < index - FIRST_ORDER) table.count = 0;
    }
    return table;
}
