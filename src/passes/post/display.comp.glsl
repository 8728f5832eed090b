#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// From linear light to what a screen of high dynamic range takes. Highlights above half of the peak are compressed, at their hue.
#include "common.glsl"
#include "passes/post/display_shared.h"
#include "srgb.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform push_block { gpu_display_push push; };

// The shoulder of Khronos' neutral tone mapper, with another start and peak.
vec3 compress(vec3 color) {
    const float peak = HDR_PEAK / HDR_WHITE, start = 0.5 * peak, room = peak - start;
    float most = max_component(color);
    return most <= start ? color : color * ((peak - room * room / (most + room - start)) / most);
}

// SMPTE ST 2084, of 0 .. 1 = 10 000 cd/m^2.
vec3 perceptual_quantizer(vec3 light) {
    vec3 power = pow(light, vec3(2610.0 / 16384.0));
    return pow((3424.0 / 4096.0 + 2413.0 / 128.0 * power) / (1.0 + 2392.0 / 128.0 * power), vec3(2523.0 / 32.0));
}

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (pixel.x >= push.width || pixel.y >= push.height) return;
    vec3 color = max(texelFetch(textures[push.picture], ivec2(pixel), 0).rgb, vec3(0.0));
    if (push.decode == 1u) color = srgb_decode(color);
    if (push.format == GPU_DISPLAY_LINEAR) {
        imageStore(images[push.target], ivec2(pixel), vec4(color, 1.0));
        return;
    }
    // From the primaries of BT.709 to those of BT.2020 (ITU-R BT.2087).
    const mat3 wide = mat3(0.6274, 0.0691, 0.0164, 0.3293, 0.9195, 0.0880, 0.0433, 0.0114, 0.8956);
    color = perceptual_quantizer(clamp(wide * compress(min(color, vec3(1e6))) * (HDR_WHITE / 10000.0), 0.0, 1.0));
    uvec3 level = uvec3(color * 1023.0 + 0.5);
    if (push.format == GPU_DISPLAY_ARGB10) level = level.bgr;
    imageStore(images[push.target], ivec2(pixel), unpackUnorm4x8(3u << 30 | level.b << 20 | level.g << 10 | level.r));
}
