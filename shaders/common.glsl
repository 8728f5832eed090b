// SPDX-License-Identifier: MIT
// Extensions, the bindless set and small helpers. Every entry point includes this first.
#ifndef COMMON_GLSL
#define COMMON_GLSL

#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference2 : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_nonuniform_qualifier : require
#extension GL_EXT_samplerless_texture_functions : require
#extension GL_EXT_shader_image_load_formatted : require
#ifdef MULTIVIEW
#extension GL_EXT_multiview : require
#define SEVERAL_VIEWS
#endif
#ifdef SEVERAL_VIEWS
#extension GL_EXT_buffer_reference_uvec2 : require
#endif

#include "shared.h"
#include "constants_shared.h"

layout(set = 0, binding = 0) uniform texture2D textures[];
layout(set = 0, binding = 0) uniform texture2DMS textures_multisampled[];
layout(set = 0, binding = 0) uniform textureCube cubes[];
layout(set = 0, binding = 0) uniform utexture2D textures_uint[];
layout(set = 0, binding = 1) uniform sampler samplers[];
layout(set = 0, binding = 2) uniform image2D images[];
layout(set = 0, binding = 2) uniform uimage2D images_uint[];

// One block per element type that is reached by address.
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer uint_array { uint at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer const_uint_array { uint at[]; };

// Number of the work group or invocation in a dispatch made by gpu_dispatch_linear, which may have two dimensions and a few
// groups too many.
#define LINEAR_GROUP (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x)
#define LINEAR_INVOCATION (LINEAR_GROUP * gl_WorkGroupSize.x + gl_LocalInvocationID.x)

const float PI = 3.14159265358979323846;
const uint LIGHT_MASK_ALL = 255u; // a light mask of surfaces that every light affects

// The library keeps a finite largest value in 16-bit targets.
const float HALF_MAX = 65504.0;

float max_component(vec3 v) { return max(v.x, max(v.y, v.z)); }
float luminance(vec3 color) { return dot(color, vec3(0.2126, 0.7152, 0.0722)); }

// The transfer function of IEC 61966-2-1, for values in 0..1.
vec3 srgb_encode(vec3 c) {
    return mix(12.92 * c, 1.055 * pow(max(c, vec3(0.0031308)), vec3(1.0 / 2.4)) - 0.055, greaterThan(c, vec3(0.0031308)));
}

vec3 octahedral_decode(vec2 e) {
    vec3 n = vec3(e, 1.0 - abs(e.x) - abs(e.y));
    if (n.z < 0.0) n.xy = (1.0 - abs(n.yx)) * vec2(n.x < 0.0 ? -1.0 : 1.0, n.y < 0.0 ? -1.0 : 1.0);
    return normalize(n);
}

vec2 octahedral_encode(vec3 n) {
    vec2 p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    if (n.z < 0.0) p = (1.0 - abs(p.yx)) * vec2(p.x < 0.0 ? -1.0 : 1.0, p.y < 0.0 ? -1.0 : 1.0);
    return p;
}

#endif
