#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference_uvec2 : require
// The debug view of reflection probes: a colour for each, by the parts that they have of a surface's light from all around.
#include "common.glsl"
#include "view.glsl"

vec3 ambient_radiance(view_block v, vec3 direction) { return vec3(0.25); } // what they leave
#define REFLECTIONS_SHOWN
#include "reflections.glsl"
#include "passes/debug/reflections_view_shared.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform push_block { gpu_reflections_view_push push; };

light_around reflection_light(reflections_block r, uint index, vec3 position, vec3 place, vec3 normal, vec3 direction, float lod, vec3 coat, float coat_lod) {
    vec3 hue = abs(fract(float(index) * 0.381966 + vec3(0.0, 0.333, 0.667)) * 6.0 - 3.0) - 1.0;
    return light_around(clamp(hue, 0.0, 1.0), vec3(0.0), vec3(0.0));
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(uvec2(pixel), push.view.view.size))) return;
    vec4 albedo = texelFetch(textures[push.albedo], pixel, 0), normal = texelFetch(textures[push.normal], pixel, 0),
         position = texelFetch(textures[push.position], pixel, 0);
    bool sky = normal.w <= 0.0;
    float grey = sky ? 0.0 : 0.12 + 0.88 * luminance(albedo.rgb) * (0.6 + 0.4 * normal.y);
    vec3 color = vec3(grey * 0.5);
    if (LIGHTING_REFLECTIONS && !sky)
        color = mix(vec3(grey), reflections_gather(push.view, position.xyz, normal.xyz, LIGHT_MASK_ALL, normal.xyz, 0.0, normal.xyz, -1.0).mirrored, 0.7);
    imageStore(images[push.target], pixel, push.swap == 1u ? vec4(color.bgr, 1.0) : vec4(color, 1.0));
}
