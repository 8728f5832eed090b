#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Forward shading of pixels with several samples by the ids of the pixel that the shaded point lies on. Those were looked for where the
// samples are: a point somewhere else, as a triangle that is all but hidden may have it, goes through all lights.
#define HOLES_ARE_CUT
layout(early_fragment_tests) in;
#include "passes/shade/forward.glsl"
#include "passes/shade/sample_bounds.glsl"
#include "passes/shade/light_indexed_samples_shared.h"

layout(push_constant, scalar) uniform push_block { gpu_indexed_samples_push push; };

layout(location = 0) out vec4 out_radiance;

void main() {
    gpu_geometry_push geometry = push.geometry;
    vec3 view_position = (geometry.view.view.world_to_view * vec4(in_position, 1.0)).xyz;
    ivec2 pixel = ivec2(pixel_of(geometry.view, view_position));
    if (!sample_bounds_hold(texelFetch(textures[push.ranges], pixel, 0), -view_position.z)) geometry.lighting = push.all;
    float view_depth;
    out_radiance = forward_shade(geometry, view_depth);
}
