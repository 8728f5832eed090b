// SPDX-License-Identifier: MIT
// How much of a light is left at its size on the screen.
#ifndef SPRITES_GLSL
#define SPRITES_GLSL

#include "view.glsl"
#include "lights/iterate.glsl"
#include "passes/lights/sprites_shared.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer light_out_array { gpu_light at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer entity_out_array { gpu_entity_bounds at[]; };

// The twin of light_fade() in sprites.c. What is not a number is kept whole.
float light_fade(view_block v, vec3 center, float radius, float lod) {
    precise float spread = v.view.orthographic > 0.5 ? 1.0 : distance(center, v.view.eye);
    precise float pixels = radius * float(v.view.size.y) / max(2.0 * abs(v.view.ndc_scale.y) * spread, 1e-20);
    precise float t = pixels / lod - 1.0;
    if (!(t < 1.0)) return 1.0;
    t = max(t, 0.0);
    precise float fade = t * t * (3.0 - 2.0 * t);
    return fade;
}

#endif
