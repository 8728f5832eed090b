/* SPDX-License-Identifier: MIT */
/** The rows of all orders. */
#include "render/orders/order.h"

#include <stdio.h>
#include <string.h>

#define ORDER_ROW(value, name) [FNL_SHADING_##value] = &order_##name,
#define COUNT_ORDER(value, name) +1
_Static_assert(0 ORDERS(COUNT_ORDER) == FNL_SHADING_AUTO, "each shading path except auto has its row");
static const struct order *const orders[FNL_SHADING_AUTO] = {ORDERS(ORDER_ROW)};

const struct order *shading_order(fnl_shading shading) { return orders[shading]; }

bool shading_is(fnl_shading shading, uint32_t traits) {
    return (uint32_t)shading < FNL_SHADING_AUTO && (orders[shading]->traits & traits) == traits;
}

bool frame_is(const fnl_frame *frame, uint32_t traits) {
    const struct order *order = orders[frame->shading];
    uint32_t has = order->traits;
    if (has & SHADING_MAY_PREPASS && frame->gbuffer.prepass) has |= SHADING_PREPASS;
    if (order->adjust) has = order->adjust(frame, has);
    return (has & traits) == traits;
}

fnl_result shading_refuse(const struct call *call, const char *what, const fnl_frame *frame, uint32_t traits) {
    char names[512] = "";
    uint32_t left = 0;
    for (fnl_shading s = 0; s < FNL_SHADING_AUTO; s++) left += shading_is(s, traits);
    for (fnl_shading s = 0; s < FNL_SHADING_AUTO; s++) {
        if (!shading_is(s, traits)) continue;
        const size_t end = strlen(names);
        left--;
        snprintf(names + end, sizeof names - end, "%s%s", fnl_value_name(FNL_ENUM_SHADING, s), left > 1 ? ", " : left == 1 ? " or " : "");
    }
    return unsupported(call, "%s needs the shading %s, not %s%s", what, names, fnl_value_name(FNL_ENUM_SHADING, frame->shading),
                       shading_is(frame->shading, traits) ? " with these options" : "");
}
