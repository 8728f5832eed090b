#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Which items differ from those that were kept, and KEEP: keeps them for the next frame. What deforms always differs: this step runs where
// something moved.
#include "common.glsl"
#include "passes/shadow/fill.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_fill_mark_push push; };

#ifndef KEEP
bool differ(gpu_fill_caster a, gpu_fill_caster b) {
    bool has_a = !(a.low.x > a.high.x), has_b = !(b.low.x > b.high.x);
    if (!has_a || !has_b) return has_a || has_b;
    return a.rows != b.rows || a.low != b.low || a.high != b.high || a.primitive != b.primitive ||
           push.rays.rays.scene.scene.primitives.at[b.primitive].bind_offset != 0;
}
#endif

void main() {
    uint index = LINEAR_INVOCATION;
    gpu_fill_caster before, now;
    before.low = now.low = vec3(1.0);
    before.high = now.high = vec3(0.0);
    if (index < push.item_count) now = caster_of(push.rays, index, push.caster_count);
#ifdef KEEP
    if (index < push.item_count) push.kept.at[index] = now;
    if (index == 0u) push.kept.count = push.item_count;
#else
    if (index < push.kept.count) before = push.kept.at[index];
    if (differ(before, now)) push.changed.at[atomicAdd(push.changed.at[0], 1u) + 1u] = index;
#endif
}
