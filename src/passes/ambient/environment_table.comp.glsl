#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// What the specular lobe of brdf.glsl reflects of light that is the same all around, in two parts, which f0 and f90 are multiplied by
// (Karis 2013, "Real Shading in Unreal Engine 4"); which mip of the environment it is aimed at; and what white fibres (sheen.glsl) reflect.
#include "passes/ambient/environment_texels.glsl"
#include "roughness.glsl"
#include "layers/sheen_lobe.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform push_block { gpu_environment_table_push push; };

// 1 minus the mean cosine that a lobe's directions make with its axis, each weighed by its cosine.
float lobe_width(float roughness) {
    float alpha = alpha_of(roughness), alpha2 = alpha * alpha, sum = 0.0, weight = 0.0;
    for (uint i = 0u; i < ENVIRONMENT_TABLE_SAMPLES; i++) {
        float u = (float(i) + 0.5) / float(ENVIRONMENT_TABLE_SAMPLES), n_l = 2.0 * (1.0 - u) / (1.0 + (alpha2 - 1.0) * u) - 1.0;
        if (n_l <= 0.0) break;
        sum += n_l * (1.0 - n_l);
        weight += n_l;
    }
    return sum / weight;
}

// Between the two mips whose lobes are narrower and wider.
float mip_of(float roughness) {
    float mip = min(floor(pow(roughness, 1.0 / ENVIRONMENT_ROUGHNESS_POWER) * push.last_mip), push.last_mip - 1.0);
    float low = mip > 0.0 ? lobe_width(pow(mip / push.last_mip, ENVIRONMENT_ROUGHNESS_POWER)) : 0.0;
    float high = lobe_width(pow((mip + 1.0) / push.last_mip, ENVIRONMENT_ROUGHNESS_POWER));
    return mip + clamp((lobe_width(roughness) - low) / (high - low), 0.0, 1.0);
}

// Directions all over the hemisphere count alike.
float sheen_albedo(vec3 to_view, float roughness) {
    float sum = 0.0;
    for (uint i = 0u; i < ENVIRONMENT_TABLE_SAMPLES; i++) {
        vec2 point = even_point(i, ENVIRONMENT_TABLE_SAMPLES);
        float n_l = point.x, away = sqrt(1.0 - n_l * n_l), angle = 2.0 * PI * point.y;
        vec3 half_vector = normalize(to_view + vec3(away * cos(angle), away * sin(angle), n_l));
        sum += sheen_lobe(roughness, n_l, to_view.z, half_vector.z) * n_l;
    }
    return min(sum * 2.0 * PI / float(ENVIRONMENT_TABLE_SAMPLES), 1.0);
}

void main() {
    uvec2 at = gl_GlobalInvocationID.xy;
    vec2 place = vec2(at) / float(ENVIRONMENT_TABLE_SIDE - 1u);
    float n_v = max(place.x, 1e-3), alpha = alpha_of(place.y), alpha2 = alpha * alpha;
    vec3 to_view = vec3(sqrt(1.0 - n_v * n_v), 0.0, n_v);
    float masking = n_v + sqrt(alpha2 + (1.0 - alpha2) * n_v * n_v);
    vec2 sum = vec2(0.0);
    for (uint i = 0u; i < ENVIRONMENT_TABLE_SAMPLES; i++) {
        // Normals of the microfacets that the viewer sees (Heitz 2018): of what they mirror, all but what is shadowed arrives.
        vec2 point = even_point(i, ENVIRONMENT_TABLE_SAMPLES);
        vec3 stretched = normalize(vec3(alpha * to_view.x, 0.0, to_view.z));
        vec3 t1 = vec3(0.0, 1.0, 0.0), t2 = cross(stretched, t1);
        float radius = sqrt(point.x), a = radius * cos(2.0 * PI * point.y), b = radius * sin(2.0 * PI * point.y), part = 0.5 * (1.0 + stretched.z);
        b = (1.0 - part) * sqrt(max(1.0 - a * a, 0.0)) + part * b;
        vec3 normal = a * t1 + b * t2 + sqrt(max(1.0 - a * a - b * b, 0.0)) * stretched;
        vec3 half_vector = normalize(vec3(alpha * normal.xy, max(normal.z, 1e-6)));
        float v_h = dot(to_view, half_vector), n_l = 2.0 * v_h * half_vector.z - to_view.z;
        if (!(n_l > 0.0)) continue;
        float arrives = 2.0 * n_l / (n_l + sqrt(alpha2 + (1.0 - alpha2) * n_l * n_l)), m5 = pow(1.0 - clamp(v_h, 0.0, 1.0), 5.0);
        sum += arrives * vec2(1.0 - m5, m5);
    }
    push.texels.at[at.y * ENVIRONMENT_TABLE_SIDE + at.x] =
        uvec2(packHalf2x16(sum / float(ENVIRONMENT_TABLE_SAMPLES)), packHalf2x16(vec2(mip_of(place.y), sheen_albedo(to_view, place.y))));
}
