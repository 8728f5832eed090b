/* SPDX-License-Identifier: MIT */
/** Decals in device memory. */
#ifndef FNL_SHADERS_DECALS_SHARED_H
#define FNL_SHADERS_DECALS_SHARED_H

#include "shared.h"

#define GPU_DECAL_COLOR 1u /* flags: the values of fnl_decal_channel */
#define GPU_DECAL_NORMAL 2u
#define GPU_DECAL_ROUGHNESS 4u
#define GPU_DECAL_METALLIC 8u
#define GPU_DECAL_EMISSION 16u
#define GPU_DECAL_FLATTEN 32u
#define GPU_DECAL_FIELD 64u    /* alpha is a distance, cut at `cut` */
#define GPU_DECAL_VOLUME 128u  /* slices instead of a projection */
#define GPU_DECAL_BLEND_SHIFT 8u /* 4 bits: the values of fnl_decal_blend */
#define GPU_DECAL_RECEIVERS_SHIFT 16u /* 8 bits */

#define GPU_DECAL_NO_IMAGE 0xffffffffu

#define GPU_DECAL_BLEND_ALPHA 0u
#define GPU_DECAL_BLEND_MULTIPLY 1u
#define GPU_DECAL_BLEND_ADD 2u
#define GPU_DECAL_BLEND_SCREEN 3u
#define GPU_DECAL_BLEND_OVERLAY 4u

struct gpu_decal {
    vec4 rows[3];      /* world, or for mesh decals the mesh before it deforms, to the cube -1/2 .. 1/2 */
    uint flags;
    vec3 side;         /* unit, world (not of mesh decals): where the picture's right side is */
    vec3 up;           /* unit: where its top is */
    vec3 facing;       /* unit, of the space of `rows`: the way it is seen from */
    vec4 color;        /* not premultiplied */
    vec3 emissive;     /* cd/m^2 */
    float metallic;
    float roughness;
    float normal_scale;
    float fade_scale;  /* smooth step of cos * scale + offset, cos between the surface's normal and `facing` */
    float fade_offset;
    float cut;
    float slices;
    uint color_image;  /* bindless, or GPU_DECAL_NO_IMAGE; premultiplied but for distance fields */
    uint normal_image;
    uint metallic_roughness_image;
    uint emissive_image;
};

/* All decals of a scene as one frame sees them: those of boxes and volumes first, then those of meshes, each in the order in which they
   are applied. */
struct gpu_decal_set {
    ADDRESS(decal_array) decals;
    ADDRESS(light_list_block) list;        /* GPU_LIST_CLUSTERS over the boxes */
    ADDRESS(const_uint_array) mesh_ranges; /* by instance: the first of its decals in mesh_ids; one more at the end */
    ADDRESS(const_uint_array) mesh_ids;
    uint count;       /* of boxes and volumes */
    uint sampler_index;
    uint in_gbuffer;  /* 1: boxes and volumes are applied to the G-buffer afterwards */
    uint mip_fix;
};


#endif
