// SPDX-License-Identifier: MIT
// Reading the scene from device memory.
#ifndef SCENE_GLSL
#define SCENE_GLSL

#include "common.glsl"

#ifndef POSITION_ACCESS
#define POSITION_ACCESS readonly
#endif

layout(buffer_reference) buffer position_array;
layout(buffer_reference) buffer attributes_array;
layout(buffer_reference) buffer instance_array;
layout(buffer_reference) buffer primitive_array;
layout(buffer_reference) buffer material_array;
layout(buffer_reference) buffer item_array;
layout(buffer_reference) buffer group_array;
layout(buffer_reference) buffer cluster_array;
layout(buffer_reference) buffer layers_block;

#include "scene_shared.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) POSITION_ACCESS buffer position_array { vec3 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) POSITION_ACCESS buffer attributes_array { gpu_attributes at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer instance_array { gpu_instance at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer primitive_array { gpu_primitive at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer material_array { gpu_material at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer layers_block { gpu_layers layers; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer item_array { gpu_item at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer group_array { gpu_group at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer cluster_array { gpu_cluster at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer scene_block { gpu_scene scene; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer draw_array { gpu_draw at[]; };

// The light mask of a draw item.
uint item_light_mask(scene_block scene, uint item) { return scene.scene.items.at[item].receivers >> GPU_ITEM_LIGHTS_SHIFT & 255u; }

vec3 transform_point(gpu_instance instance, vec3 p) {
    vec4 h = vec4(p, 1.0);
    return vec3(dot(instance.rows[0], h), dot(instance.rows[1], h), dot(instance.rows[2], h));
}

vec3 transform_direction(gpu_instance instance, vec3 d) {
    return vec3(dot(instance.rows[0].xyz, d), dot(instance.rows[1].xyz, d), dot(instance.rows[2].xyz, d));
}

// Normals go through the cofactor matrix; `mirror` is -1 for a mirroring transform, else 1.
vec3 transform_normal(gpu_instance instance, vec3 n, out float mirror) {
    vec3 x = instance.rows[0].xyz, y = instance.rows[1].xyz, z = instance.rows[2].xyz;
    // The exponent of the largest element is taken out, exactly: products of very large or small scales are none of a float's.
    vec3 most = max(max(abs(x), abs(y)), abs(z));
    uint exponent = clamp(floatBitsToUint(max(most.x, max(most.y, most.z))) & 0x7f800000u, 0x00800000u, 0x7e000000u);
    float scale = uintBitsToFloat(0x7f000000u - exponent);
    x *= scale, y *= scale, z *= scale;
    vec3 cx = cross(y, z);
    mirror = dot(x, cx) < 0.0 ? -1.0 : 1.0;
    return vec3(dot(cx, n), dot(cross(z, x), n), dot(cross(x, y), n)) * mirror;
}

vec3 unpack_normal(uint bits) { return octahedral_decode(unpackSnorm2x16(bits)); }

vec4 unpack_tangent(uint bits) {
    vec2 e = vec2(float(bits & 0xffffu) / 65535.0, float(bits >> 16 & 0x7fffu) / 32767.0) * 2.0 - 1.0;
    return vec4(octahedral_decode(e), (bits & 0x80000000u) != 0u ? -1.0 : 1.0);
}

uint pack_normal(vec3 n) { return packSnorm2x16(octahedral_encode(n)); }

uint pack_tangent(vec3 t, bool negative) {
    uvec2 e = uvec2(round(clamp(octahedral_encode(t) * 0.5 + 0.5, 0.0, 1.0) * vec2(65535.0, 32767.0)));
    return e.x | e.y << 16 | (negative ? 0x80000000u : 0u);
}

#endif
