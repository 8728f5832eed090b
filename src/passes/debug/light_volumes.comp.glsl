#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Debug view of the volumes of lights: surfaces within a volume are tinted in the hue of its light, and a line marks where the volume cuts them.
#include "common.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"
#include "lighting/reach.glsl"
#include "passes/debug/light_volumes_shared.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform push_block { gpu_light_volumes_push push; };

vec3 hue_of(uint light) { return clamp(abs(fract(float(light) * 0.381966 + vec3(0.0, 0.333, 0.667)) * 6.0 - 3.0) - 1.0, 0.0, 1.0); }

bool position_at(ivec2 pixel, out vec3 position) {
    position = vec3(0.0);
    if (any(lessThan(pixel, ivec2(0))) || any(greaterThanEqual(uvec2(pixel), push.view.view.size))) return false;
    vec4 found = texelFetch(textures[push.position], pixel, 0);
    position = found.xyz;
    return found.w > 0.0;
}

// The neighbors to both sides, if they and the pixel lie about on a line: there are no lines along silhouettes.
bool on_surface(ivec2 pixel, ivec2 step, vec3 position, out vec3 before, out vec3 after) {
    bool both = position_at(pixel - step, before) && position_at(pixel + step, after);
    return both && length(before + after - 2.0 * position) <= 0.4 * length(after - before);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(uvec2(pixel), push.view.view.size))) return;
    vec4 albedo = texelFetch(textures[push.albedo], pixel, 0), normal = texelFetch(textures[push.normal], pixel, 0),
         position = texelFetch(textures[push.position], pixel, 0);
    vec3 color = vec3(0.0);
    if (normal.w > 0.0) {
        vec3 neighbors[4];
        bool known[2] = bool[](on_surface(pixel, ivec2(1, 0), position.xyz, neighbors[0], neighbors[1]),
                               on_surface(pixel, ivec2(0, 1), position.xyz, neighbors[2], neighbors[3]));
        color = vec3(0.5 * (0.12 + 0.88 * luminance(albedo.rgb) * (0.6 + 0.4 * normal.y)));
        light_list_block list = list_of(push.lighting);
        light_set_block lights = lights_of(push.lighting);
        light_point point = light_point(uvec2(pixel), normal.w, position.xyz, normal.xyz, uint(position.w) - 1u);
        light_cursor cursor = lights_begin(list, point);
        vec3 tint = vec3(0.0), line = vec3(0.0);
        uint held = 0u;
        bool edge = false;
        FOR_EACH_LIGHT(list, cursor, light) {
            if (!light_reaches(lights, light, position.xyz)) continue;
            tint += hue_of(light);
            held++;
            for (int i = 0; i < 4; i++)
                if (known[i / 2] && !light_reaches(lights, light, neighbors[i])) {
                    line = hue_of(light);
                    edge = true;
                }
        }
        if (held > 0u) color = mix(color, tint / float(held), 0.5 - 0.35 / float(held));
        if (edge) color = mix(line, vec3(1.0), 0.25);
    }
    imageStore(images[push.target], pixel, push.swap == 1u ? vec4(color.bgr, 1.0) : vec4(color, 1.0));
}
