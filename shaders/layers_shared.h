/* SPDX-License-Identifier: MIT */
/** The layers of a material in device memory, and of a surface in shaders. */
#ifndef FNL_SHADERS_LAYERS_SHARED_H
#define FNL_SHADERS_LAYERS_SHARED_H

#include "texture_shared.h"

/* gpu_layers.textures, in the order of MATERIAL_LAYER_TEXTURES (src/scene/material_layers.h). */
#define GPU_TEXTURE_CLEARCOAT 0
#define GPU_TEXTURE_CLEARCOAT_ROUGHNESS 1
#define GPU_TEXTURE_CLEARCOAT_NORMAL 2
#define GPU_TEXTURE_SHEEN_COLOR 3
#define GPU_TEXTURE_SHEEN_ROUGHNESS 4
#define GPU_TEXTURE_IRIDESCENCE 5
#define GPU_TEXTURE_IRIDESCENCE_THICKNESS 6
#define GPU_TEXTURE_ANISOTROPY 7
#define GPU_TEXTURE_TRANSMISSION 8
#define GPU_TEXTURE_THICKNESS 9
#define GPU_TEXTURE_DIFFUSE_TRANSMISSION 10
#define GPU_TEXTURE_DIFFUSE_TRANSMISSION_COLOR 11
#define GPU_LAYER_TEXTURE_COUNT 12

/* What layers add to a material. */
struct gpu_layers {
    /* Each number of MATERIAL_LAYER_NUMBERS under its id. */
    float clearcoat, clearcoat_roughness, clearcoat_normal_scale;
    vec3 sheen_color;
    float sheen_roughness;
    float film, film_ior, film_thinnest, film_thickest; /* nanometers */
    float anisotropy, anisotropy_rotation;
    float transmission;
    float thickness; /* meters of the mesh; 0: a sheet */
    float attenuation_distance;
    vec3 attenuation_color;
    float dispersion;
    float diffuse_transmission;
    vec3 diffuse_transmission_color;
    /* Derived from the numbers and the textures. */
    vec4 clearcoat_normal_turn; /* as gpu_material.normal_turn */
    vec4 anisotropy_turn;       /* rows of a 2x2 matrix: from the texture, or (1, 0), to tangent and bitangent */
    vec3 absorption;            /* per meter */
    float ior;
    STRUCT(gpu_texture) textures[GPU_LAYER_TEXTURE_COUNT];
};

/*
 * Members that a surface gets from its material: PLAIN(member) unchanged, TEXTURED(member, texture, channels) times a texture (channels r, g, a or rgb).
 * material.glsl and ray/ray_surface.c compute the members that need more. LAYERS_TEXTURED_THROUGH lists the members that only transmissive surfaces have.
 */
#define LAYERS_PLAIN(PLAIN) PLAIN(film_ior)
#define LAYERS_TEXTURED(TEXTURED)                                                                \
    TEXTURED(clearcoat, GPU_TEXTURE_CLEARCOAT, r)                                                \
    TEXTURED(clearcoat_roughness, GPU_TEXTURE_CLEARCOAT_ROUGHNESS, g)                            \
    TEXTURED(sheen_color, GPU_TEXTURE_SHEEN_COLOR, rgb)                                          \
    TEXTURED(sheen_roughness, GPU_TEXTURE_SHEEN_ROUGHNESS, a)                                    \
    TEXTURED(film, GPU_TEXTURE_IRIDESCENCE, r)                                                   \
    TEXTURED(diffuse_transmission, GPU_TEXTURE_DIFFUSE_TRANSMISSION, a)                          \
    TEXTURED(diffuse_transmission_color, GPU_TEXTURE_DIFFUSE_TRANSMISSION_COLOR, rgb)
#define LAYERS_TEXTURED_THROUGH(TEXTURED)                                                        \
    TEXTURED(transmission, GPU_TEXTURE_TRANSMISSION, r)                                          \
    TEXTURED(thickness, GPU_TEXTURE_THICKNESS, g)

/* Vectors that hold a surface's layers (layers_pack()). */
#define SURFACE_LAYERS_VECTORS 5

#ifdef GL_core_profile

// What lies over the material, or changes how it mirrors; read only by shaders of lists with GPU_LIGHTING_LAYERS (layers.glsl).
struct surface_layers {
    vec3 clearcoat_normal;
    float clearcoat, clearcoat_roughness;
    vec3 sheen_color;
    float sheen_roughness;
    float film, film_ior, film_thickness; // nanometers
    vec3 tangent;                         // unit, at right angles to the normal: along it highlights are stretched
    float anisotropy;
    float diffuse_transmission; // the part of the diffuse lobe that lies behind the surface
    vec3 diffuse_transmission_color;
#ifdef TRANSMISSION // only in shaders that draw transmissive surfaces
    float transmission;
    float thickness; // meters of the world; 0: a sheet
    vec3 absorption; // per meter
    float ior, dispersion;
#endif
};

// With every layer off.
surface_layers no_layers() {
    surface_layers l;
    l.clearcoat_normal = l.sheen_color = l.tangent = l.diffuse_transmission_color = vec3(0.0);
    l.clearcoat = l.clearcoat_roughness = l.sheen_roughness = l.film = l.film_thickness = l.anisotropy = l.diffuse_transmission = 0.0;
    l.film_ior = 1.0;
#ifdef TRANSMISSION
    l.transmission = l.thickness = l.dispersion = 0.0;
    l.absorption = vec3(0.0);
    l.ior = 1.5;
#endif
    return l;
}

// For passes that store layers in images. Leaves out the members of TRANSMISSION.
vec4[SURFACE_LAYERS_VECTORS] layers_pack(surface_layers l) {
    return vec4[](vec4(l.clearcoat_normal, l.clearcoat), vec4(l.sheen_color, l.sheen_roughness), vec4(l.tangent, l.anisotropy),
                  vec4(l.film, l.film_ior, l.film_thickness, l.clearcoat_roughness),
                  vec4(l.diffuse_transmission_color, l.diffuse_transmission));
}

surface_layers layers_unpack(vec4 v[SURFACE_LAYERS_VECTORS]) {
    surface_layers l = no_layers();
    l.clearcoat_normal = v[0].xyz;
    l.clearcoat = v[0].w;
    l.sheen_color = v[1].rgb;
    l.sheen_roughness = v[1].a;
    l.tangent = v[2].xyz;
    l.anisotropy = v[2].w;
    l.film = v[3].x;
    l.film_ior = v[3].y;
    l.film_thickness = v[3].z;
    l.clearcoat_roughness = v[3].w;
    l.diffuse_transmission_color = v[4].rgb;
    l.diffuse_transmission = v[4].a;
    return l;
}

#endif
#endif
