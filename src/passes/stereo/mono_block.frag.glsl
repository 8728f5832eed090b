#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Near into the depth of the mono view, where every eye sees something nearer than the plane whatever the depth there is.
#define SEVERAL_VIEWS
#include "passes/stereo/mono.glsl"

layout(push_constant, scalar) uniform push_block { gpu_mono_block_push push; };

// Pixels of an eye in which a point of the mono view may be seen, and the taps of the composition round it.
const int MOST = 16;

bool covered(view_block eye, uint depth, vec3 toward) {
    view_block mono = push.mono;
    mat3 to_eye = mat3(eye.view.world_to_view) * mat3(mono.view.view_to_world);
    vec3 offset = mat3(eye.view.world_to_view) * (mono.view.eye - eye.view.eye);
    vec2 low = vec2(1e9), high = vec2(-1e9);
    for (int i = 0; i < 2; i++) { // from where the mono view begins to infinity
        vec3 p = to_eye * toward + offset * (i == 0 ? 1.0 / mono.view.near_distance : 0.0);
        if (p.z > -1e-4) return false;
        vec2 ndc = (p.xy / -p.z - eye.view.ndc_offset) / eye.view.ndc_scale;
        vec2 at = (vec2(ndc.x, -ndc.y) * 0.5 + 0.5) * vec2(eye.view.size);
        low = min(low, at);
        high = max(high, at);
    }
    vec2 last = vec2(eye.view.size) - 1.0;
    low = clamp(ceil(low - 2.0), vec2(0.0), last + 1.0);
    high = clamp(floor(high + 1.0), vec2(-1.0), last);
    if (high.x - low.x >= float(MOST) || high.y - low.y >= float(MOST)) return false;
    for (float y = low.y; y <= high.y; y += 1.0)
        for (float x = low.x; x <= high.x; x += 1.0)
            if (texelFetch(textures[depth], ivec2(x, y), 0).r <= 0.0) return false;
    return true;
}

void main() {
    vec3 toward = view_position_of(push.mono, ndc_of_pixel(push.mono, gl_FragCoord.xy), 1.0);
    for (uint i = 0u; i < push.eye_count; i++)
        if (!covered(view_at(push.eyes, i), push.depths[i], toward)) discard;
    gl_FragDepth = 1.0;
}
