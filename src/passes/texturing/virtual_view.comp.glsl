#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Debug views of virtual texturing: the atlas, and the page that each pixel shows.
#include "common.glsl"
#include "scene.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"
#include "passes/texturing/texturing.glsl"
#include "passes/texturing/virtual_view_shared.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform push_block { gpu_virtual_view_push push; };

const int SEEN_SAMPLES = 1;

uvec4 target(uint i, ivec2 pixel, int at) { return texelFetch(textures_uint[push.uv], pixel, 0); } // TARGET_UV alone
float depth_at(ivec2 pixel, int at) { return texelFetch(textures[push.depth], pixel, 0).r; }

#include "passes/texturing/virtual_sample.glsl"

// Well apart from one another, and bright.
vec3 page_color(uint page) {
    uint h = page * 0x9e3779b1u;
    h = (h ^ h >> 15) * 0x85ebca6bu;
    h ^= h >> 13;
    vec3 hue = abs(fract(float(h & 0xffffu) / 65536.0 + vec3(0.0, 2.0, 1.0) / 3.0) * 6.0 - 3.0) - 1.0;
    return mix(vec3(1.0), clamp(hue, 0.0, 1.0), 0.4 + 0.4 * float(h >> 16 & 255u) / 255.0);
}

// A square as high and as wide as fits, in the middle. Means of a pixel's area, as far as 8 x 8 texels in it tell; not decoded.
vec3 atlas_view(ivec2 pixel, ivec2 size) {
    int side = min(size.x, size.y);
    vec2 at = (vec2(pixel) - vec2(size - side) * 0.5) / float(side);
    if (any(lessThan(at, vec2(0.0))) || any(greaterThanEqual(at, vec2(1.0)))) return vec3(0.0);
    float texels = float(push.pages.v.across * VIRTUAL_PAGE);
    vec3 sum = vec3(0.0);
    for (int i = 0; i < 64; i++) {
        ivec2 texel = ivec2(min((at + (vec2(i & 7, i >> 3) + 0.5) / (8.0 * float(side))) * texels, vec2(texels - 1.0)));
        uvec2 place = uvec2(texel) / VIRTUAL_PAGE;
        bool empty = push.pages.v.owners.at[place.y * push.pages.v.across + place.x] == 0u;
        vec3 color = texelFetch(textures[push.pages.v.sampled[VIRTUAL_BASE]], texel, 0).rgb;
        sum += empty ? vec3((pixel.x + pixel.y & 7) == 0 ? 0.25 : 0.1) : color;
    }
    return sum / 64.0;
}

// The darker the coarser; striped where a page with more detail was wanted.
vec3 pages_view(ivec2 pixel) {
    if (depth_at(pixel, 0) <= 0.0) return vec3(0.0);
    uint packed = target(TARGET_UV, pixel, 0).x;
    if (packed == VIRTUAL_NOWHERE) return vec3((pixel.x + pixel.y & 3) == 0 ? 0.3 : 0.5);
    virtual_find(pixel, 0);
    uvec2 place = uvec2(packed & 0xffffu, packed >> 16) / (8u * VIRTUAL_PAGE);
    vec3 color = page_color(push.pages.v.owners.at[place.y * push.pages.v.across + place.x]) * pow(0.72, float(atlas_tier));
    bool hole = atlas_tier > 0u && atlas_asked < -0.25 && atlas_asked > -19.0; // beyond: not from coordinates
    return hole && (pixel.x + pixel.y & 3) == 0 ? vec3(1.0, 0.0, 1.0) : color;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = ivec2(push.view.view.size);
    if (any(greaterThanEqual(pixel, size))) return;
    vec3 color = push.mode == VIRTUAL_VIEW_ATLAS ? atlas_view(pixel, size) : pages_view(pixel);
    imageStore(images[push.target], pixel, vec4(push.swap == 1u ? color.bgr : color, 1.0));
}
