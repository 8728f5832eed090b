/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_GBUFFER_TEST_SHARED_H
#define FNL_PASSES_GBUFFER_TEST_SHARED_H

#include "gbuffer_shared.h"

/* How a render target rounds. */
#define ROUND_UNORM8 0u
#define ROUND_SRGB8 1u
#define ROUND_UNORM16 2u
#define ROUND_UNORM10 3u /* alpha 2 bits */
#define ROUND_HALF 4u
#define ROUND_FLOAT 5u

struct gpu_gbuffer_case {
    vec3 normal;
    float roughness;
    vec3 base_color; /* out, with chroma: sRGB-encoded */
    float metallic;
    vec3 dielectric_f0;
    float dielectric_f90;
    vec3 motion;
    float occlusion;
    vec3 position;   /* view space; out: what the layout stores of it */
    uint id;
    vec3 coat_normal;
    float coat;      /* 0, and anisotropy 0: no layers */
    vec3 tangent;    /* at right angles to the normal */
    float anisotropy;
    float coat_roughness;
};

struct gpu_gbuffer_test_push {
    ADDRESS(case_array) cases;
    ADDRESS(case_array) results;
    ADDRESS(material_entries) entries;
    uint count;
    uint form;
    uint formats;    /* 4 bits a target */
};

#endif
