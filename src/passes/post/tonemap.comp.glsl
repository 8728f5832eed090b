#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Exposure, tone mapping, sRGB. The samples of a pixel are tone-mapped first and averaged then, so that bright edges stay smooth.
#include "common.glsl"

layout(buffer_reference) buffer float_array;
#include "passes/post/post_shared.h"
#include "passes/post/tonemap.glsl"
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer float_array { float at[]; };

layout(constant_id = 0) const uint SAMPLES = 1u;
layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform push_block { gpu_tonemap_push push; };

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= int(push.width) || pixel.y >= int(push.height)) return;
    float factor = push.metered == 1u ? push.exposure.at[0] : push.factor;
    vec4 sum = vec4(0.0);
    for (uint i = 0u; i < SAMPLES; i++) {
        vec4 c = SAMPLES > 1u ? texelFetch(textures_multisampled[push.radiance], pixel, int(i))
                              : texelFetch(textures[push.radiance], pixel, 0);
        c.rgb = min(c.rgb * factor, vec3(1e15)); // stays finite in what follows
        if (push.encode == 1u) c.rgb = clamp(tone_map(push.tonemap, c.rgb), 0.0, 1.0);
        sum += c;
    }
    sum /= float(SAMPLES);
    if (push.encode == 1u) sum.rgb = srgb_encode(sum.rgb);
    sum.a = 1.0;
    imageStore(images[push.target], pixel, push.swap == 1u ? sum.bgra : sum);
}
