// SPDX-License-Identifier: MIT
// Light from all around: of the environment (passes/ambient/environment.h), or where there is none two colours, from above and from below.
#ifndef ENVIRONMENT_GLSL
#define ENVIRONMENT_GLSL

#include "view.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer environment_block { gpu_environment light; };

// A direction in the axes of the cube map.
vec3 environment_axes(view_block v, vec3 direction) {
    vec3 rows[3] = v.view.frame.frame.environment_rows;
    precise vec3 turned = vec3(rows[0].x * direction.x + rows[0].y * direction.y + rows[0].z * direction.z,
                               rows[1].x * direction.x + rows[1].y * direction.y + rows[1].z * direction.z,
                               rows[2].x * direction.x + rows[2].y * direction.y + rows[2].z * direction.z);
    return turned;
}

// What is seen in a direction, or mirrored by a surface of some roughness; cd/m^2.
vec3 environment_radiance(view_block v, vec3 direction, float lod) {
    uint cube = v.view.frame.frame.environment_cube, sampler_index = v.view.frame.frame.environment_sampler;
    precise vec3 radiance = textureLod(samplerCube(cubes[cube], samplers[sampler_index]), environment_axes(v, direction), lod).rgb *
                            v.view.frame.frame.environment_scale;
    return radiance;
}

// What a white diffuse surface reflects whose normal is `n`, in the axes of the harmonics.
vec3 environment_harmonics(gpu_environment light, vec3 n) {
    return max(light.diffuse[0] + light.diffuse[1] * n.y + light.diffuse[2] * n.z + light.diffuse[3] * n.x + light.diffuse[4] * (n.x * n.y) +
                   light.diffuse[5] * (n.y * n.z) + light.diffuse[6] * (3.0 * n.z * n.z - 1.0) + light.diffuse[7] * (n.x * n.z) +
                   light.diffuse[8] * (n.x * n.x - n.y * n.y),
               vec3(0.0));
}

// What a white diffuse surface reflects; cd/m^2.
vec3 environment_diffuse(view_block v, vec3 normal) {
    environment_block e = v.view.frame.frame.environment;
    vec3 n = environment_axes(v, normal);
    precise vec3 sum = e.light.diffuse[0] + e.light.diffuse[1] * n.y + e.light.diffuse[2] * n.z + e.light.diffuse[3] * n.x +
                       e.light.diffuse[4] * (n.x * n.y) + e.light.diffuse[5] * (n.y * n.z) + e.light.diffuse[6] * (3.0 * n.z * n.z - 1.0) +
                       e.light.diffuse[7] * (n.x * n.z) + e.light.diffuse[8] * (n.x * n.x - n.y * n.y);
    precise vec3 light = max(sum, vec3(0.0)) * v.view.frame.frame.environment_scale;
    return light;
}

// What the specular lobe reflects of the same light from everywhere, f0 times x plus f90 times y; z: the mip that holds what it is aimed at.
vec3 environment_reflectance(view_block v, float n_v, float roughness) {
    uint table = v.view.frame.frame.environment_table, sampler_index = v.view.frame.frame.environment_sampler;
    return textureLod(sampler2D(textures[table], samplers[sampler_index]), vec2(n_v, roughness) * (63.0 / 64.0) + 0.5 / 64.0, 0.0).xyz;
}

// What white fibres (KHR_materials_sheen) reflect of the same light from everywhere.
float environment_sheen(view_block v, float n_v, float roughness) {
    uint table = v.view.frame.frame.environment_table, sampler_index = v.view.frame.frame.environment_sampler;
    return textureLod(sampler2D(textures[table], samplers[sampler_index]), vec2(n_v, roughness) * (63.0 / 64.0) + 0.5 / 64.0, 0.0).w;
}

#endif
