#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The last step: the picture, or radiance for those that go on with it.
#include "common.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"

layout(buffer_reference) buffer float_array;
#include "passes/post/post_shared.h"
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer float_array { float at[]; };
#include "passes/post/tonemap.glsl"
#define MOBILE_READS 1
#include "passes/mobile/mobile.glsl"

layout(push_constant, scalar) uniform push_block { gpu_mobile_push push; };

layout(constant_id = 13) const bool COVERS = false; // COVERS_ID: alpha says where opaque surfaces are
layout(location = 0) out vec4 out_color;

void main() {
    mobile_texel g;
    MOBILE_LOAD_LIGHT(g)
    float covered = 1.0;
    if (COVERS) {
        MOBILE_LOAD_PLACE(g)
        covered = mobile_is_sky(g) ? 0.0 : 1.0;
    }
    vec3 color = mobile_light(g) / push.view.view.frame.frame.light_scale;
    if (push.encode == 1u) {
        color = min(color * push.factor, vec3(1e15)); // as the pass of its own does
        color = srgb_encode(clamp(tone_map(push.tonemap, color), 0.0, 1.0));
    } else {
        color = min(color * push.factor, vec3(push.encode == 0u ? push.view.view.frame.frame.hdr_max : 1e15));
    }
    out_color = vec4(push.swap == 1u ? color.bgr : color, covered);
}
