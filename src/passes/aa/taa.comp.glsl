#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Temporal antialiasing (taa.h).
#include "common.glsl"
#include "view.glsl"

layout(buffer_reference) buffer float_array;
#include "passes/aa/taa_shared.h"
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer float_array { float at[]; };
#include "passes/aa/tone_space.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform push_block { gpu_taa_push push; };

ivec2 size;
float exposure;

vec4 tone(vec4 c) { return vec4(to_tone(c.rgb * exposure), c.a); }
vec4 untone(vec4 c) { return vec4(from_tone(c.rgb) / exposure, c.a); }

// Of what is black the metered exposure may be anything: no more than a float holds.
void read_exposure() {
    exposure = clamp(push.metered == 1u ? push.exposure.at[0] : push.factor, 1e-12, 1e12);
}

ivec2 inside(ivec2 p) { return clamp(p, ivec2(0), size - 1); }
vec4 radiance_at(ivec2 p) { return tone(texelFetch(textures[push.radiance], inside(p), 0)); }
float depth_at(ivec2 p) { return texelFetch(textures[push.depth], inside(p), 0).x; }

vec3 to_ycocg(vec3 c) { return vec3(dot(c, vec3(0.25, 0.5, 0.25)), 0.5 * (c.r - c.b), dot(c, vec3(-0.25, 0.5, -0.25))); }
vec3 from_ycocg(vec3 c) { return vec3(c.x + c.y - c.z, c.x + c.z, c.x - c.y - c.z); }

// Catmull-Rom weights of the texels -1 .. 2 about t in [0, 1).
vec4 cubic(float t) {
    float t2 = t * t, t3 = t2 * t;
    return vec4(-0.5 * t + t2 - 0.5 * t3, 1.0 - 2.5 * t2 + 1.5 * t3, 0.5 * t + 2.0 * t2 - 1.5 * t3, -0.5 * t2 + 0.5 * t3);
}

vec4 history_at(vec2 place) {
    vec2 at = place - 0.5, base = floor(at);
    vec4 wx = cubic(at.x - base.x), wy = cubic(at.y - base.y), sum = vec4(0.0);
    for (int y = 0; y < 4; y++)
        for (int x = 0; x < 4; x++)
            sum += wx[x] * wy[y] * tone(texelFetch(textures[push.history], inside(ivec2(base) + ivec2(x, y) - 1), 0));
    return max(sum, vec4(0.0));
}

// Moves a colour towards the mean until it is within the spread.
vec3 clipped(vec3 color, vec3 mean, vec3 spread) {
    vec3 off = color - mean, units = abs(off) / max(spread, vec3(1e-5));
    float most = max_component(units);
    return most > 1.0 ? mean + off / most : color;
}

// Did the last frame see what is at q where it was, or next to it, by its depth?
bool was_seen(ivec2 q, vec4 motion) {
    ivec2 center = ivec2(floor(vec2(q) + 0.5 + motion.xy));
    float depth = min(motion.z, TAA_FARTHEST);
    if (motion.w <= 0.0) return false;
    for (int i = 0; i < 9; i++) {
        float was = texelFetch(textures[push.history_depth], inside(center + ivec2(i % 3, i / 3) - 1), 0).x;
        if (abs(was - depth) <= TAA_DEPTH_TOLERANCE * min(was, depth)) return true;
    }
    return false;
}

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    size = ivec2(push.view.view.size);
    if (any(greaterThanEqual(p, size))) return;
    read_exposure();
    vec4 raw = texelFetch(textures[push.radiance], p, 0);
    float depth = depth_at(p);
    bool sky = depth <= 0.0 && push.view.view.orthographic < 0.5;
    float view_depth = sky ? TAA_FARTHEST : min(view_depth_of(push.view, depth), TAA_FARTHEST);
    vec4 motion = vec4(0.0);
    vec4 result = raw, old = vec4(0.0), old_raw = vec4(0.0);
    float count = 0.0;

    if (push.keeps == 1u && push.still == 1u) {
        old_raw = texelFetch(textures[push.history], p, 0);
        old = tone(old_raw);
        count = texelFetch(textures[push.history_depth], p, 0).y;
    } else if (push.keeps == 1u) {
        vec4 sum = vec4(0.0), squares = vec4(0.0);
        ivec2 nearest = p;
        float nearest_depth = depth;
        for (int i = 0; i < 9; i++) {
            ivec2 q = inside(p + ivec2(i % 3, i / 3) - 1);
            vec4 c = radiance_at(q);
            c.rgb = to_ycocg(c.rgb);
            sum += c;
            squares += c * c;
            float d = depth_at(q);
            if (d > nearest_depth) {
                nearest_depth = d;
                nearest = q;
            }
        }
        // Edges move with what is in front; where that was not seen before, thin as it may be, with what the pixel itself shows.
        motion = texelFetch(textures[push.motion], nearest, 0);
        bool seen = was_seen(nearest, motion);
        if (!seen) {
            motion = texelFetch(textures[push.motion], p, 0);
            seen = was_seen(p, motion);
        }
        vec2 place = vec2(p) + 0.5 + motion.xy;
        if (seen && all(greaterThanEqual(place, vec2(0.0))) && all(lessThan(place, vec2(size)))) {
            vec4 mean = sum / 9.0, spread = TAA_SPREAD * sqrt(max(squares / 9.0 - mean * mean, vec4(0.0)));
            old = history_at(place);
            old.rgb = max(from_ycocg(clipped(to_ycocg(old.rgb), mean.rgb, spread.rgb)), vec3(0.0));
            old.a = clamp(old.a, mean.a - spread.a, mean.a + spread.a);
            old_raw = texelFetch(textures[push.history], ivec2(place), 0);
            // Each fetch between texels blurs a little: the faster, the sooner samples are replaced.
            float most = mix(TAA_SLOW, TAA_FAST, clamp(length(motion.xy), 0.0, 1.0));
            vec4 before = texelFetch(textures[push.history_depth], ivec2(place), 0);
            // What moved at another speed of its own in the last frame was something else, though a pixel beside was this.
            count = abs(before.z - (motion.w - 1.0)) > 1.0 ? 0.0 : min(before.y, most);
        }
    }
    if (count > 0.0) {
        float part = 1.0 / (count + 1.0);
        // What is far beyond white in both shows as white; there only plain means keep its radiance.
        bool beyond = min(max_component(old_raw.rgb), max_component(raw.rgb)) * exposure > 16.0;
        result = beyond ? mix(old_raw, raw, part) : untone(mix(old, tone(raw), part));
    }
    imageStore(images[push.target], p, result);
    imageStore(images[push.target_depth], p, vec4(view_depth, min(count + 1.0, 2048.0), clamp(motion.w - 1.0, 0.0, 6e4), 0.0));
}
