// SPDX-License-Identifier: MIT
// What is lit: every shading order fills this struct and calls shade_surface() (shade.glsl).
#ifndef SURFACE_GLSL
#define SURFACE_GLSL

#include "layers_shared.h"

struct surface {
    vec3 position;        // world space
    vec3 normal;          // world space, unit, shading normal on the viewer's side of double-sided surfaces
    vec3 geometric;       // world space, geometric normal, any length, either side; 0 or NaN if unknown
    vec3 base_color;      // linear
    float alpha;
    float metallic;
    float roughness;      // perceptual
    float occlusion;      // 1: open
    vec3 emissive;        // cd/m^2; an unlit surface is black with its colour here
    vec3 dielectric_f0;   // reflectance at normal incidence of the non-metal part
    float dielectric_f90; // at grazing incidence (KHR_materials_specular's strength)
    uint light_mask;      // 8 bits: lights that share one affect it; LIGHT_MASK_ALL where the item is not known
    bool layered;         // the rest holds
    surface_layers layers;
};

// The geometric normal as a unit vector; the shading normal if unknown.
vec3 geometric_unit(surface s) {
    precise float length2 = dot(s.geometric, s.geometric);
    precise vec3 unit_normal = s.geometric * inversesqrt(length2);
    return length2 > 1e-20 ? unit_normal : s.normal;
}

// Geometric normal from two edge vectors of any length; NaN if one is zero.
vec3 geometric_of(vec3 a, vec3 b) { return cross(a * inversesqrt(dot(a, a)), b * inversesqrt(dot(b, b))); }

#endif
