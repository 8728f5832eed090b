/* SPDX-License-Identifier: MIT */
/**
 * The atlas of virtual texturing. A material's textures are cut, at each second level of detail (a tier), into pages of 120 x 120 texels;
 * a page of the atlas has 128 x 128, four of its neighbours' on each side, and two smaller levels of its own beside it.
 */
#ifndef FNL_PASSES_VIRTUAL_SHARED_H
#define FNL_PASSES_VIRTUAL_SHARED_H

#include "shared.h"

#ifdef GL_core_profile
layout(buffer_reference) buffer virtual_materials;
layout(buffer_reference) buffer virtual_pages;
layout(buffer_reference) buffer virtual_block;
#endif

#define VIRTUAL_PAGE 128u
#define VIRTUAL_BORDER 4u
#define VIRTUAL_INNER 120u
#define VIRTUAL_LEVELS 3u /* that a page has */
#define VIRTUAL_STEP 2u   /* levels from tier to tier */
#define VIRTUAL_TIERS 8u
#define VIRTUAL_NOWHERE 0xffffffffu       /* coordinates of what a forward pass lights */
#define VIRTUAL_BLOCKS (256u + 64u + 16u) /* of 8 x 8 texels that a page has, all levels */

#define VIRTUAL_BASE 0u     /* layers: base colour, sRGB */
#define VIRTUAL_NORMAL 1u   /* normal; occlusion */
#define VIRTUAL_PARAMS 2u   /* strength of the specular part, roughness, metalness */
#define VIRTUAL_EMISSIVE 3u /* sRGB; in scenes that have such textures, as is the next */
#define VIRTUAL_SPECULAR 4u /* specular colour, sRGB */
#define VIRTUAL_LAYERS 5u

#define VIRTUAL_REPEAT 0u
#define VIRTUAL_MIRROR 1u
#define VIRTUAL_CLAMP 2u

/* All textures of a material share coordinates and wraps. */
struct gpu_virtual_material {
    uint first_page[VIRTUAL_TIERS];
    uint tiers; /* down to that of one texel; 0: not in the atlas */
    uint whole; /* the first tier that is one page, which is always resident */
    uint width; /* of the largest texture */
    uint height;
    uint wrap; /* of u | of v << 2 */
    uint uv_set;
    float transform[6];
};

struct gpu_virtual_page {
    uint material;
    uint place; /* column | row << 14 | tier << 28 */
};

/* What is counted of a frame. */
struct gpu_virtual_counts {
    uint wanted;
    uint resident;
    uint filled;
    uint missing; /* wanted, but there was no room */
    uint evicted; /* gave way to those that were filled */
};

struct gpu_virtual {
    ADDRESS(virtual_materials) materials;
    ADDRESS(virtual_pages) pages;
    ADDRESS(uint_array) table;    /* page -> place in the atlas + 1, or 0 */
    ADDRESS(uint_array) owners;   /* place -> page + 1, or 0 */
    ADDRESS(uint_array) wanted;   /* page -> not 0 where the last frame wanted it */
    ADDRESS(uint_array) places;   /* places that may be filled; then of those that are to be */
    ADDRESS(uint_array) commands; /* VkDispatchIndirectCommand, a word left out, gpu_virtual_counts */
    ADDRESS(material_array) scene_materials;
    uint page_count;
    uint always; /* so many first pages are always resident: each material has one that holds all of it, its tier `whole` */
    uint capacity;
    uint across;                  /* pages along the atlas' side */
    uint sampled[VIRTUAL_LAYERS]; /* the layers; GPU_TEXTURE_NONE where there is none */
    uint storage[VIRTUAL_LAYERS];
    uint sampler_index;
};

struct gpu_virtual_push {
    ADDRESS(virtual_block) pages;
};

#ifdef GL_core_profile
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer virtual_materials {
    gpu_virtual_material at[];
};
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer virtual_pages { gpu_virtual_page at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer virtual_block { gpu_virtual v; };
#endif

#endif
