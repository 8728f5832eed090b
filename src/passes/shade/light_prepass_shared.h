/* SPDX-License-Identifier: MIT */
/** Light kept apart from materials: the buffers that hold it, and the passes that fill and read them. */
#ifndef FNL_PASSES_LIGHT_PREPASS_SHARED_H
#define FNL_PASSES_LIGHT_PREPASS_SHARED_H

#include "passes/geometry/geometry_shared.h"

/* How sums of light are kept; the values of fnl_light_buffer. */
#define LIGHT_BUFFER_RGBA 1u /* diffuse RGB, luminance of the specular lobe */
#define LIGHT_BUFFER_TWO 2u  /* diffuse, specular; reflectance is folded in */
#define LIGHT_BUFFER_FOUR 3u /* diffuse and specular lobe, each as it is and times (1 - v.h)^5 */
#define LIGHT_BUFFER_NARROW 4u /* diffuse; specular divided by the reflectance at normal incidence. Surfaces: one RGBA8 target */
#define LIGHT_BUFFER_TARGETS 4u

/* Bindless indices of what the first pass over the geometry drew. */
struct gpu_light_surfaces {
    uint depth;
    uint normal;      /* RGBA16 UNORM: octahedral normal, roughness, two bytes: root of the greatest dielectric F0, dielectric F90;
                      LIGHT_BUFFER_NARROW: RGBA8 UNORM, read as -1 .. 1: normal, roughness; the sign of the roughness is the Fresnel switch */
    uint reflectance; /* RGBA8 UNORM: root of F0, F90; with LIGHT_BUFFER_TWO alone */
    uint geometric;   /* RG16 UNORM: octahedral; GPU_TEXTURE_NONE without GPU_FEATURE_LEANING */
};

struct gpu_light_prepass_push {
    ADDRESS(view_block) view;
    ADDRESS(lighting_block) lighting;
    ADDRESS(uint_array) counters;
    ADDRESS(uint_array) words;           /* with several samples a pixel: edges_shared.h */
    STRUCT(gpu_light_surfaces) surfaces;
    uint targets[LIGHT_BUFFER_TARGETS]; /* storage */
    uint scale;                         /* pixels of the screen along a side of a texel of the targets: 1, 2 or 4 */
    uint samples;                       /* storage: which of its pixels a texel stands for, where scale is not 1 */
    uint width;                         /* texels of the targets */
    uint height;
    uint layer;                         /* with several samples a pixel: which surface of each is lit */
};

struct gpu_light_material_push {
    STRUCT(gpu_geometry_push) geometry;
    ADDRESS(uint_array) words;           /* with several samples a pixel, as the next: edges_shared.h */
    ADDRESS(const_uint_array) layers;    /* LIGHT_BUFFER_TARGETS bindless indices of each layer of sums */
    STRUCT(gpu_light_surfaces) surfaces;
    uint targets[LIGHT_BUFFER_TARGETS]; /* bindless, as the next */
    uint samples;
    uint scale;
};

#endif
