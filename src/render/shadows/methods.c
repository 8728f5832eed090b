/* SPDX-License-Identifier: MIT */
/** The rows of all methods, and those of the two that need no code here. */
#include "render/shadows/method.h"

const struct shadow_method shadow_method_off = {.captured_as = FNL_SHADOWS_OFF};
const struct shadow_method shadow_method_rays = {.traits = SHADOWS_RAYS | SHADOWS_EXACT, .captured_as = FNL_SHADOWS_RAYS};

#define SHADOW_METHOD_ROW(value, name) [FNL_SHADOWS_##value] = &shadow_method_##name,
#define COUNT_SHADOW_METHOD(value, name) +1
_Static_assert(0 SHADOW_METHODS(COUNT_SHADOW_METHOD) == FNL_SHADOWS_AUTO, "each method except auto has its row");
static const struct shadow_method *const methods[FNL_SHADOWS_AUTO] = {SHADOW_METHODS(SHADOW_METHOD_ROW)};

const struct shadow_method *shadow_method(fnl_shadows shadows) { return methods[shadows]; }

bool shadows_have(const fnl_frame *frame, uint32_t traits) {
    return (uint32_t)frame->shadows < FNL_SHADOWS_AUTO && (methods[frame->shadows]->traits & traits) == traits;
}
