/* SPDX-License-Identifier: MIT */
/** One camera of a frame, and what all cameras of a frame share. */
#ifndef FNL_SHADERS_VIEW_SHARED_H
#define FNL_SHADERS_VIEW_SHARED_H

#include "shared.h"

/* The values of fnl_shadow_filter. */
#define GPU_SHADOW_FILTER_HARD 0u
#define GPU_SHADOW_FILTER_PCF 1u
#define GPU_SHADOW_FILTER_PCSS 2u

/* What does not depend on the camera: one for each frame. */
struct gpu_frame {
    vec3 ambient_sky;    /* cd/m^2 */
    float hdr_max;       /* largest value that the radiance target holds */
    vec3 ambient_ground;
    uint shade_cost;     /* extra loop iterations each time a surface is lit */
    float light_scale;   /* the mobile order: what its accumulator holds of radiance 1 */
    float light_max;     /* and the most that it holds */
    float nothing;       /* 0, which shaders do not know */
    uint shadow_filter;  /* of shadow maps: GPU_SHADOW_FILTER_… */
    uint shadow_samples; /* shadow rays to a source with a size */
    float light_radius;  /* of sources that have none of their own, as gpu_light.source has them: metres */
    float sun_tangent;   /* and of directional lights and boxes */
    /* The environment; of lists with GPU_LIGHTING_ENVIRONMENT. */
    ADDRESS(environment_block) environment;
    uint environment_cube;      /* sampled: GGX lobes by mips */
    uint environment_table;     /* sampled: reflectance */
    uint environment_sampler;
    vec3 environment_rows[3];   /* of the matrix from world space to the axes of the cube map */
    float environment_scale;
};

/*
 * The camera: one for each view. Those of the views of a frame stand one after the other, in the order of the views.
 *
 * View space is right-handed and looks down -Z; "view depth" is the positive distance along the axis, -z. Reversed depth:
 * 1 at the near plane; 0 at infinity (perspective) or at the far plane (orthographic).
 */
struct gpu_view {
    mat4 world_to_view;
    mat4 view_to_clip;
    mat4 world_to_clip;
    mat4 view_to_world;
    vec4 planes[5];      /* world space, inside is dot(plane, (p, 1)) >= 0: left, right, bottom, top, near */
    vec3 eye;            /* world space; orthographic: on the near side of the axis */
    float near_distance;
    vec3 back;           /* world space unit vector out of the screen, towards the viewer */
    float orthographic;  /* 1 or 0 */
    vec2 ndc_scale;      /* view xy = (ndc * ndc_scale + ndc_offset) * (orthographic ? 1 : view depth) */
    vec2 ndc_offset;
    vec4 depth_decode;   /* view depth = (x + y * d) / (z + w * d) */
    uvec2 size;          /* pixels */
    vec2 inverse_size;
    uint samples;        /* of a pixel */
    uint mask;           /* 8 bits: items that share one are shown */
    uint pad;
    uint turn;           /* another number in each frame that is collected with others (TAA); else 0 */
    ADDRESS(frame_block) frame;
    uvec2 decals;        /* address of a struct gpu_decal_set, whose list is of this view; read only where a shader's features say that there is one */
    uvec2 reflections;   /* of a struct gpu_reflection_set; of lists with GPU_LIGHTING_REFLECTIONS */
};
#define GPU_VIEW_BYTES 456
#ifndef GL_core_profile
_Static_assert(sizeof(struct gpu_view) == GPU_VIEW_BYTES, "views stand one after the other as view_at() of view.glsl expects");
#endif

#endif
