#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Denoising, over time: what the last frames saw of each surface, and this one (denoise.h).
#include "passes/shadow/denoise.glsl"

layout(local_size_x = DENOISE_GROUP, local_size_y = DENOISE_GROUP) in;
layout(push_constant, scalar) uniform push_block { gpu_denoise_collect_push push; };

shared uint pixels, fresh, frames;

ivec2 size;

vec3 position_at(ivec2 p) {
    float depth = texelFetch(textures[push.depth], clamp(p, ivec2(0), size - 1), 0).x;
    return view_position_of(push.view, ndc_of_pixel(push.view, vec2(p) + 0.5), view_depth_of(push.view, depth));
}

// The way to that neighbour which lies nearer in depth, from lesser to greater coordinates.
vec3 along(ivec2 p, ivec2 side, vec3 here) {
    vec3 after = position_at(p + side) - here, before = here - position_at(p - side);
    bool first = p + side != clamp(p + side, ivec2(0), size - 1), last = p - side != clamp(p - side, ivec2(0), size - 1);
    if (first || last) return first ? before : after;
    return abs(after.z) < abs(before.z) ? after : before;
}

// Of the depths around a pixel, world space; the shading normal where they tell nothing.
vec3 flat_normal(ivec2 p, vec3 here, vec3 normal) {
    vec3 n = cross(along(p, ivec2(0, 1), here), along(p, ivec2(1, 0), here));
    float l = length(n);
    if (!(l > 0.0) || isinf(l)) return normal;
    n = mat3(push.view.view.view_to_world) * (n / l);
    return dot(n, normal) < 0.0 ? -n : n;
}

// How much of the light is another than it was, 0 .. 1.
float changed(vec4 now, vec4 was) {
    float most = max(now.w, was.w);
    if (!(most > 0.0)) return 0.0;
    return (length(now.xyz * now.w - was.xyz * was.w) + abs(now.w - was.w)) / most;
}

struct history {
    vec4 seen, drawn;
    float frames, change;
};

// Catmull-Rom weights of the pixels -1 .. 2 about t in [0, 1).
vec4 cubic(float t) {
    float t2 = t * t, t3 = t2 * t;
    return vec4(-0.5 * t + t2 - 0.5 * t3, 1.0 - 2.5 * t2 + 1.5 * t3, 0.5 * t + 2.0 * t2 - 1.5 * t3, -0.5 * t2 + 0.5 * t3);
}

// Where a surface was in the last frame.
struct former {
    vec2 at;             // pixels
    vec3 place, normal;  // view space; the normal of the depths around
    vec3 facing;         // shading normal, world space
    float slack;         // metres off the plane
};

// Whether the last frame saw it at pixel q.
bool was_seen(former f, ivec2 q) {
    if (any(lessThan(q, ivec2(0))) || any(greaterThanEqual(q, size))) return false;
    vec4 was = texelFetch(textures[push.was_surface], q, 0);
    if (!(was.x > 0.0) || dot(octahedral_decode(was.yz), f.facing) < DENOISE_NORMAL) return false;
    vec3 there = view_position_of(push.previous, ndc_of_pixel(push.previous, vec2(q) + 0.5), was.x);
    return abs(dot(f.normal, there - f.place)) <= f.slack;
}

// What the last frame kept of the surface, from the pixels round its place there that saw it: four by four, whose cubic keeps edges of shadows sharp from
// frame to frame, or as many of the middle four as there are.
history history_at(vec4 motion, ivec2 p, vec3 normal, vec3 across, vec4 field) {
    history h = history(vec4(0.0), vec4(0.0), 0.0, 1.0);
    if (push.keeps == 0u || !(motion.w > 0.0)) return h;
    if (push.still == 1u) motion.xy = vec2(0.0); // it is so, but for rounding
    view_block v = push.previous;
    former f;
    f.at = vec2(p) + motion.xy;
    if (any(lessThan(f.at, vec2(-1.0))) || any(greaterThan(f.at, vec2(size)))) return h;
    f.place = view_position_of(v, ndc_of_pixel(v, f.at + 0.5), motion.z);
    f.normal = mat3(v.view.world_to_view) * across;
    f.facing = normal;
    f.slack = DENOISE_PLANE * pixel_width(v, motion.z) + 1e-3 * motion.z; // of depths in 16 bits
    ivec2 base = ivec2(floor(f.at));
    vec2 part = f.at - vec2(base);
    vec4 wx = cubic(part.x), wy = cubic(part.y), lx = vec4(0.0, 1.0 - part.x, part.x, 0.0), ly = vec4(0.0, 1.0 - part.y, part.y, 0.0);
    history smooth_ = h;
    vec4 between = vec4(0.0);
    float sum = 0.0;
    bool whole = true;
    for (int i = 0; i < 16; i++) {
        ivec2 side = ivec2(i & 3, i >> 2), q = base + side - 1;
        float weight = wx[side.x] * wy[side.y], linear = lx[side.x] * ly[side.y];
        if (weight == 0.0 && linear <= 0.0) continue;
        if (!was_seen(f, q)) {
            whole = false;
            continue;
        }
        vec4 seen = texelFetch(textures[push.was_seen], q, 0), drawn = texelFetch(textures[push.was_drawn], q, 0);
        smooth_.seen += weight * seen;
        smooth_.drawn += weight * drawn;
        if (linear <= 0.0) continue;
        vec4 was_field = texelFetch(textures[push.was_field], q, 0);
        h.seen += linear * seen;
        h.drawn += linear * drawn;
        between += linear * was_field;
        h.change = min(h.change, changed(field, was_field));
        sum += linear;
    }
    if (sum < 0.01) return history(vec4(0.0), vec4(0.0), 0.0, 1.0);
    h.seen /= sum;
    h.drawn /= sum;
    h.change = min(h.change, changed(field, between / sum)); // where light is uneven, each of them may be the better guess
    h.frames = h.seen.a * sum; // what only some of them saw is at an edge, and less sure
    if (whole) {
        h.seen = max(smooth_.seen, 0.0);
        h.drawn = max(smooth_.drawn, 0.0);
    }
    return h;
}

void count(uint length_) {
    atomicAdd(pixels, 1u);
    if (length_ <= 1u) atomicAdd(fresh, 1u);
    atomicAdd(frames, length_);
}

void store(ivec2 p, vec4 seen, vec4 drawn, vec4 surface, vec4 place) {
    imageStore(images[push.seen], p, seen);
    imageStore(images[push.drawn], p, drawn);
    imageStore(images[push.surface], p, surface);
    imageStore(images[push.places], p, place);
}

void collect(ivec2 p) {
    vec4 open = texelFetch(textures[push.open], p, 0);
    if (open.a == DENOISE_SKY) {
        store(p, vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0));
        return;
    }
    vec4 seen = texelFetch(textures[push.now_seen], p, 0), drawn = texelFetch(textures[push.now_drawn], p, 0);
    vec4 field = texelFetch(textures[push.now_field], p, 0);
    float noise = drawn.a, part = part_seen(seen.rgb, drawn.rgb), length_ = DENOISE_FRAMES;
    vec2 encoded = vec2(open.a, seen.a);
    vec3 normal = octahedral_decode(encoded), here = position_at(p), across = flat_normal(p, here, normal);
    if (noise > 0.0) { // else this frame knows all
        history h = history_at(texelFetch(textures[push.motion], p, 0), p, normal, across, field);
        float change = max(h.change - DENOISE_STEADY, 0.0);
        h.frames = min(h.frames, push.longest) * clamp(1.0 - DENOISE_CHANGE * change, 0.0, 1.0);
        length_ = h.frames + 1.0;
        seen.rgb = mix(h.seen.rgb, seen.rgb, 1.0 / length_);
        drawn.rgb = mix(h.drawn.rgb, drawn.rgb, 1.0 / length_);
        count(uint(round(length_)));
    }
    store(p, vec4(seen.rgb, length_), vec4(drawn.rgb, part), vec4(min(-here.z, 6e4), encoded, 0.0),
          vec4(-here.z, pack_direction(normal), pack_direction(across), noise));
}

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    size = ivec2(push.view.view.size);
    if (gl_LocalInvocationIndex == 0u) pixels = fresh = frames = 0u;
    barrier();
    if (all(lessThan(p, size))) collect(p);
    barrier();
    if (gl_LocalInvocationIndex != 0u || pixels == 0u) return;
    atomicAdd(push.counts.counts.pixels, pixels);
    atomicAdd(push.counts.counts.fresh, fresh);
    uint before = atomicAdd(push.counts.counts.frames[0], frames);
    if (before + frames < before) atomicAdd(push.counts.counts.frames[1], 1u);
}
