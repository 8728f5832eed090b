/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_INSPECT_SHARED_H
#define FNL_PASSES_INSPECT_SHARED_H

#include "layers_shared.h"
#include "lighting/lighting_shared.h"

#define INSPECT_LIGHTS 256u /* FNL_PIXEL_LIGHTS */
#define INSPECT_GROUP 64u   /* threads: each tells INSPECT_LIGHTS / INSPECT_GROUP lights from others */
#define INSPECT_NONE 0x7fffffffu

/* Texels of what the surface is drawn into: see inspect_surface.frag.glsl. */
#define INSPECT_TARGETS 7u

/* gpu_inspected.flags */
#define INSPECT_HIT 1u
#define INSPECT_LAYERED 2u
#define INSPECT_UNLIT 4u
#define INSPECT_UNSERVED 8u
#define INSPECT_LISTED 16u /* a list was looked at: gpu_inspect_light.listed and listed_reaching are known */

/* Values of fnl_pixel_shadow. */
#define INSPECT_SHADOW_NONE 0u
#define INSPECT_SHADOW_BEHIND 1u
#define INSPECT_SHADOW_MAP 2u
#define INSPECT_SHADOW_RAYS 3u
#define INSPECT_SHADOW_CUBEMAP 4u

struct gpu_inspect_light {
    vec3 radiance;
    uint light;      /* index into the light array */
    float visibility;
    uint shadow;     /* INSPECT_SHADOW_… */
    uint face;
    uint level;
    uvec2 page;
    uint place;      /* as gpu_shadow_page has it */
    uint listed;
};

/* The pixel, and behind it INSPECT_LIGHTS of the structs above, of which `told` are filled. */
struct gpu_inspected {
    vec3 position;
    float view_depth;
    vec3 normal;
    float roughness;
    vec3 base_color;
    float metallic;
    vec3 emission;
    uint flags;      /* INSPECT_… */
    vec3 lit;
    uint item;       /* draw item */
    vec3 rest;
    uint cell;
    uvec3 cell_place;
    uint visited;
    uint reaching;
    uint listed_reaching; /* of the list's own lights */
    uint contributing;
    uint total;      /* lights that would be told if there were room, directional ones too */
    uint told;
};

struct gpu_inspect_push {
    ADDRESS(view_block) view;
    ADDRESS(lighting_block) lighting;
    ADDRESS(inspected_block) out_pixel;
    ADDRESS(uint_array) counters; /* two for each pixel, the first of them the lights visited; or 0 with counter_stride 0 */
    uvec2 pixel;
    uint counter_stride;
    uint skips_layered; /* 1: layered surfaces were shaded by another list */
    uint targets[7];    /* sampled: INSPECT_TARGETS */
    uint layers[SURFACE_LAYERS_VECTORS];
};

#endif
