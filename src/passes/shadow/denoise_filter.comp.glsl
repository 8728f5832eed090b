#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Denoising, in space: one level of an a-trous wavelet that stops at edges (Dammertz et al. 2010, Schied et al. 2017). The last one adds the light.
#include "passes/shadow/denoise.glsl"

layout(constant_id = 0) const uint LAST = 0u;

layout(local_size_x = DENOISE_GROUP, local_size_y = DENOISE_GROUP) in;
layout(push_constant, scalar) uniform push_block { gpu_denoise_filter_push push; };

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy), size = ivec2(push.view.view.size);
    if (any(greaterThanEqual(p, size))) return;
    vec4 place = texelFetch(textures[push.places], p, 0);
    vec4 seen = texelFetch(textures[push.seen], p, 0);
    vec4 drawn = texelFetch(textures[push.drawn], p, 0);
    if (place.x > 0.0 && seen.a > 0.0) {
        denoise_place here = place_of(push.view, place, p);
        vec3 across = mat3(push.view.view.world_to_view) * unpack_direction(place.z);
        float guess = drawn.a, pixel = pixel_width(push.view, place.x), variance = seen.a;
        float sharp = 1.0 / (DENOISE_SHARP * sqrt(variance) + 1e-3), weights = 1.0;
        for (int i = 0; i < 9; i++) {
            ivec2 side = ivec2(i % 3 - 1, i / 3 - 1), q = p + side * int(push.step);
            if (side == ivec2(0) || any(lessThan(q, ivec2(0))) || any(greaterThanEqual(q, size))) continue;
            float weight = (side.x == 0 || side.y == 0 ? 0.5 : 0.25) *
                           alike(here, across, place_of(push.view, texelFetch(textures[push.places], q, 0), q), pixel);
            if (weight < 1e-4) continue;
            vec4 other_seen = texelFetch(textures[push.seen], q, 0);
            vec4 other_drawn = texelFetch(textures[push.drawn], q, 0);
            weight *= exp(-abs(other_drawn.a - guess) * sharp);
            seen.rgb += weight * other_seen.rgb;
            drawn += weight * other_drawn;
            variance += weight * weight * other_seen.a;
            weights += weight;
        }
        seen = vec4(seen.rgb / weights, variance / (weights * weights));
        drawn /= weights;
    }
    if (LAST == 0u) {
        imageStore(images[push.to_seen], p, seen);
        imageStore(images[push.to_drawn], p, drawn);
        return;
    }
    if (!(place.x > 0.0)) return;
    // For each colour the part of what was drawn that is seen; where next to nothing was drawn of it, that of all colours.
    vec3 part = min((seen.rgb + 1e-3 * part_seen(seen.rgb, drawn.rgb)) / (drawn.rgb + 1e-3), vec3(1.0));
    vec3 light = texelFetch(textures[push.open], p, 0).rgb * part;
    vec3 sum = imageLoad(images[push.radiance], p).rgb + light;
    imageStore(images[push.radiance], p, vec4(min(sum, vec3(push.view.view.frame.frame.hdr_max)), 1.0));
}
