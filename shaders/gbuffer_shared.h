/* SPDX-License-Identifier: MIT */
/** The G-buffer as shaders get it: bindless indices of sampled images, and how they are packed. In GLSL, view.glsl comes first. */
#ifndef FNL_GBUFFER_SHARED_H
#define FNL_GBUFFER_SHARED_H

#include "shared.h"

#define GBUFFER_TARGETS 5u /* at most, beside depth, the mask and the radiance target */

/* Values of fnl_gbuffer. */
#define GBUFFER_DEFAULT 0u
#define GBUFFER_SIEGE 1u
#define GBUFFER_KILLZONE2 2u
#define GBUFFER_FROSTBITE2 3u
#define GBUFFER_STALKER 4u
#define GBUFFER_CLEAR_SKY 5u
#define GBUFFER_ENGEL 6u
#define GBUFFER_DESTINY 7u
#define GBUFFER_LAYERS 8u
#define GBUFFER_LAYOUTS 9u

/* Values of fnl_normal_encoding; 0, the layout's own, is replaced by what that is. */
#define NORMALS_OCTAHEDRAL 1u
#define NORMALS_XYZ 2u
#define NORMALS_XY 3u
#define NORMALS_SPHERICAL 4u
#define NORMALS_SPHERE_MAP 5u
#define NORMALS_STEREOGRAPHIC 6u
#define NORMALS_VIEW 7u
#define NORMALS_BEST_FIT 8u
#define NORMALS_FLOAT 9u /* in a target of its own, after those of the layout: what the others are compared with */
#define NORMALS_COUNT 10u

/* How the targets are packed: layout | encoding of normals << 8 | flags. A specialisation constant with this id, or gpu_gbuffer.form where
   the constant is not given. */
#define GBUFFER_CONSTANT 8u
#define GBUFFER_EXTRA_CONSTANT 10u /* of shaders that write more targets than the layout has */
#define GBUFFER_FORM(layout, normals) ((layout) | (normals) << 8)
#define GBUFFER_FORM_LAYOUT(form) ((form) & 255u)
#define GBUFFER_FORM_NORMALS(form) ((form) >> 8 & 255u)
#define GBUFFER_FORM_CHROMA 0x10000u /* base colour as Y'CbCr, one of Cb and Cr a pixel */
#define GBUFFER_FORM_MASK 0x20000u   /* some pixels are lit by a forward pass: see gpu_gbuffer.mask */
#define GBUFFER_FORM_GEOMETRIC 0x40000u /* geometric normal in the last target (GBUFFER_LAYERS: its zw); else unknown */

/* What layouts with a material ID look up: the same for all pixels of a material. */
struct gpu_material_entry {
    vec3 dielectric_f0;   /* before the strength */
    float dielectric_f90; /* the strength of the dielectric specular part */
    float metallic;
    uint second;          /* bits: what fields hold at pixels of the material that hold something else at others */
};
#define GBUFFER_SECOND_STRENGTH 1u /* siege's aliased value: the strength of the specular part; else roughness, low bits */
#define GBUFFER_SECOND_METALLIC 2u /* frostbite2's parameter: metalness; else roughness, low bits */

#ifdef GL_core_profile
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer material_entries { gpu_material_entry at[]; };
#endif

struct gpu_gbuffer {
    ADDRESS(view_block) view;
    ADDRESS(material_entries) entries; /* by material ID */
    uint depth;
    uint targets[GBUFFER_TARGETS];
    uint mask;                         /* R8: not 0 where a forward pass lights the pixel */
    uint form;
};

#endif
