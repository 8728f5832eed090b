#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Depth without what it began with: of an eye, the plane; of the mono view, what both eyes cover. Nothing is there then.
#include "passes/stereo/mono.glsl"

layout(constant_id = 0) const uint COUNTS = 0u;
layout(push_constant, scalar) uniform push_block { gpu_mono_push push; };

void main() {
    float depth = texelFetch(textures[push.depth], ivec2(gl_FragCoord.xy), 0).r;
    bool begun = depth >= 1.0, shown = depth > 0.0 && !begun;
    if (push.distance > 0.0) {
        shown = depth > mono_plane_depth(push.eye, push.mono, gl_FragCoord.xy, push.distance) * 1.00001;
        begun = !shown;
    }
    if (COUNTS != 0u && shown) atomicAdd(push.counts.at[MONO_SHADED], 1u);
    if (COUNTS != 0u && begun) atomicAdd(push.counts.at[MONO_SPARED], 1u);
    gl_FragDepth = shown ? depth : 0.0;
}
