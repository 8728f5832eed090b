// SPDX-License-Identifier: MIT
// What the steps of the z-bin lists share.
#ifndef ZBIN_GLSL
#define ZBIN_GLSL

#include "passes/lights/cells.glsl"
#include "passes/lights/zbin_shared.h"

layout(push_constant, scalar) uniform push_block { gpu_zbin_push push; };

uint visible_count() { return push.visible_sums.at[push.light_count]; }
uint group_count() { return (visible_count() + ZBIN_GROUP - 1u) / ZBIN_GROUP; }
uint top_count() { return (group_count() + 31u) / 32u; }
bins_cell zbin_cell(uint cell) { return bins_cell_of(cell, push.cell_count, group_count(), top_count()); }

#endif
