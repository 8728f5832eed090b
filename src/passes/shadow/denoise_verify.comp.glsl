#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Denoising, between time and space: what this frame shows around a pixel confirms its history or refutes it, and says with it how far both may be
// off (denoise.h).
#include "passes/shadow/denoise.glsl"

layout(local_size_x = DENOISE_GROUP, local_size_y = DENOISE_GROUP) in;
layout(push_constant, scalar) uniform push_block { gpu_denoise_verify_push push; };

const int REACH = 2;

// Of the 5x5 pixels, as far as they show the same surface.
struct vicinity {
    float part;    // mean part seen, with history
    float excess;  // by how much this frame alone sees more
    float weights; // sum
    float squares; // of weights, sum
};

vicinity look_around(ivec2 p, denoise_place here, vec3 across, float pixel) {
    ivec2 size = ivec2(push.view.view.size);
    vicinity v = vicinity(0.0, 0.0, 0.0, 0.0);
    for (int y = -REACH; y <= REACH; y++)
        for (int x = -REACH; x <= REACH; x++) {
            ivec2 q = p + ivec2(x, y);
            if (any(lessThan(q, ivec2(0))) || any(greaterThanEqual(q, size))) continue;
            denoise_place there = place_of(push.view, texelFetch(textures[push.places], q, 0), q);
            float weight = q == p ? 1.0 : alike(here, across, there, pixel);
            if (weight <= 0.0) continue;
            vec4 drawn = texelFetch(textures[push.drawn], q, 0);
            float part = part_seen(texelFetch(textures[push.seen], q, 0).rgb, drawn.rgb);
            v.part += weight * part;
            v.excess += weight * (drawn.a - part);
            v.weights += weight;
            v.squares += weight * weight;
        }
    v.part /= v.weights;
    v.excess /= v.weights;
    return v;
}

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, ivec2(push.view.view.size)))) return;
    vec4 seen = texelFetch(textures[push.seen], p, 0), place = texelFetch(textures[push.places], p, 0);
    vec3 drawn = texelFetch(textures[push.drawn], p, 0).rgb;
    float noise = place.w, variance = 0.0, guess = part_seen(seen.rgb, drawn);
    if (place.x > 0.0 && noise > 0.0) {
        vec3 across = mat3(push.view.view.world_to_view) * unpack_direction(place.z);
        vicinity v = look_around(p, place_of(push.view, place, p), across, pixel_width(push.view, place.x));
        float count = v.weights * v.weights / v.squares;
        float mean = (v.part * count + 0.5) / (count + 1.0); // of few pixels nothing is sure: one more of doubt
        if (push.settled == 0u && seen.a > 1.0) {
            // A part is a mean of yes and no: that is its variance at most.
            float off = abs(v.excess) * seen.a / (seen.a - 1.0) / sqrt(mean * (1.0 - mean) * noise / count);
            float wrong = clamp((off - DENOISE_DOUBT) / (DENOISE_PROOF - DENOISE_DOUBT), 0.0, 1.0);
            if (wrong > 0.0) {
                float before = seen.a - 1.0, after = before * (1.0 - wrong) + 1.0;
                vec3 now_seen = texelFetch(textures[push.now_seen], p, 0).rgb, now_drawn = texelFetch(textures[push.now_drawn], p, 0).rgb;
                seen.rgb = mix(max(seen.rgb * seen.a - now_seen, 0.0) / before, now_seen, 1.0 / after);
                drawn = mix(max(drawn * seen.a - now_drawn, 0.0) / before, now_drawn, 1.0 / after);
                seen.a = after;
                mean = clamp(mean + v.excess * wrong, 0.0, 1.0);
                atomicAdd(push.counts.counts.refuted, 1u);
            }
        }
        // Of few frames nothing is sure either: the pixels around count as more of them.
        guess = (part_seen(seen.rgb, drawn) * seen.a + mean * DENOISE_PRIOR) / (seen.a + DENOISE_PRIOR);
        variance = guess * (1.0 - guess) * noise / seen.a;
    }
    imageStore(images[push.kept_seen], p, seen);
    imageStore(images[push.kept_drawn], p, vec4(drawn, 0.0));
    imageStore(images[push.to_seen], p, vec4(seen.rgb, variance));
    imageStore(images[push.to_drawn], p, vec4(drawn, guess));
}
