// SPDX-License-Identifier: MIT
#ifndef MOTION_GLSL
#define MOTION_GLSL

#include "common.glsl"
#include "scene.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"

layout(buffer_reference) buffer motion_block;
#include "passes/aa/motion_shared.h"
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer motion_block { gpu_motion motion; };

// What motion_add() stores for a point of the last frame's view space (w 0: a direction) that is now seen at the centre of `pixel`.
vec4 motion_of(motion_block m, vec2 pixel, vec4 previous) {
    gpu_view v = m.motion.previous;
    float view_depth = -previous.z, spread = v.orthographic > 0.5 ? 1.0 : view_depth;
    if (m.motion.has_previous == 0u || spread <= 0.0) return vec4(0.0, 0.0, previous.w == 0.0 ? MOTION_SKY_DEPTH : abs(view_depth), 0.0);
    vec2 ndc = (previous.xy / spread - v.ndc_offset) / v.ndc_scale;
    vec2 was = (vec2(ndc.x, -ndc.y) * 0.5 + 0.5) * vec2(v.size);
    return vec4(was - (pixel + m.motion.jitter), previous.w == 0.0 ? MOTION_SKY_DEPTH : view_depth, 1.0);
}

#endif
