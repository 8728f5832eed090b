// SPDX-License-Identifier: MIT
// What is lit: every shading order fills this struct and calls shade_surface() (shade.glsl).
#ifndef SURFACE_GLSL
#define SURFACE_GLSL

// What lies over the material, or changes how it mirrors; read only by shaders of lists with GPU_LIGHTING_LAYERS (layers.glsl).
struct surface_layers {
    vec3 clearcoat_normal;
    float clearcoat, clearcoat_roughness;
    vec3 sheen_color;
    float sheen_roughness;
    float film, film_ior, film_thickness; // nanometres
    vec3 tangent;                         // unit, at right angles to the normal: along it highlights are stretched
    float anisotropy;
    float diffuse_transmission; // the part of the diffuse lobe that lies behind the surface
    vec3 diffuse_transmission_color;
#ifdef TRANSMISSION // of shaders that draw what is behind shows through; else there is none
    float transmission;
    float thickness; // metres of the world; 0: a sheet
    vec3 absorption; // per metre
    float ior, dispersion;
#endif
};

struct surface {
    vec3 position;        // world space
    vec3 normal;          // world space, unit, shading normal on the viewer's side of double-sided surfaces
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

#endif
