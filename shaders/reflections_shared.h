/* SPDX-License-Identifier: MIT */
/** Reflection probes: boxes that are lit by what was seen from a point in them, as shaders find them by gpu_view.reflections. */
#ifndef FNL_SHADERS_REFLECTIONS_SHARED_H
#define FNL_SHADERS_REFLECTIONS_SHARED_H

#include "shared.h"

struct gpu_reflection {
    vec4 rows[3];        /* world to the box's axes: metres from its centre */
    vec3 half_size;
    float reach;         /* metres beyond the faces where it ends */
    vec3 capture;        /* world: where the cube map was seen from. Its axes are the world's */
    float inverse_blend; /* its weight: metres inside of where it ends, times this, 0 .. 1 */
    float intensity;
    float last_mip;      /* of the cube */
    uint cube;           /* sampled: GGX lobes by mips; GPU_REFLECTION_DARK: nothing was seen yet, which is black */
    uint rank;           /* those of one priority share it */
    uint mask;           /* 8 bits: surfaces whose light mask shares one see it; with GPU_LIGHTING_MASKS */
};

#define GPU_REFLECTION_DARK 0xffffffffu

/* Those of a scene as one view sees them: those of the highest priority first. */
struct gpu_reflection_set {
    ADDRESS(reflection_array) reflections;
    ADDRESS(harmonics_array) diffuse;   /* struct gpu_environment of each, in the world's axes */
    ADDRESS(light_list_block) list;     /* GPU_LIST_CLUSTERS over the boxes; 0: there are so few that all are looked at */
    uint count;
    uint sampler_index;
    float mip_scale; /* 1 over the last mip that the table of reflectance is for */
    uint parallax;   /* 0: looked up in the direction of the reflected ray itself */
};

#endif
