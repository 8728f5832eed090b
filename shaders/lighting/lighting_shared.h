/* SPDX-License-Identifier: MIT */
/**
 * Everything that lights a point, by scope: the lights (of a frame), what finds their shadows (of a group of views), the view, and the list that says which
 * lights reach a pixel. The environment is in gpu_frame, reflection probes are in gpu_view.
 */
#ifndef FNL_SHADERS_LIGHTING_SHARED_H
#define FNL_SHADERS_LIGHTING_SHARED_H

#include "lights/lights_shared.h"

/* Directional lights come first in the light array; all others follow and are what lists index. Each of those keeps its index from when it is
   added until it is removed; an index that no light has, or a hidden one, holds a light without range, whose bounds have no radius. */
struct gpu_light {
    STRUCT(gpu_shape) shape; /* what it lights: exactly no light outside. The angular ramp of KHR_lights_punctual is
                                sat(cos * spot_scale + spot_offset)^2; of wedges and boxes sat((1 - part) * spot_scale)^2 of the part of the
                                way from axis to edge */
    vec3 color;              /* colour times intensity: cd, or lux */
    float source;            /* radius of what casts its shadows, metres; of directional lights and boxes the tangent of half the angle that it
                                fills; 0: a point; or GPU_LIGHT_UNSHADOWED */
};

#define GPU_LIGHT_UNSHADOWED -1.0f /* it casts none */

/* Light profiles, one after the other: steps of the vertical angle, steps of the horizontal one, and the values, a row for each vertical angle. */
#ifdef GL_core_profile
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer profile_array { float at[]; };
#endif
/* Rectangles: how the specular lobe is made of a cosine, by roughness and then by the viewer's angle (tools/area_lobes.c). In alphas, the stretch along
   the plane of the normal and the viewer, and across; the sine of the angle from the mirror direction to the axis; shear; what the transformed cosine is
   multiplied by; and the part of it above the surface. */
#define AREA_LOBE_ROWS 16
#define AREA_LOBE_COLUMNS 32
#define AREA_LOBE_VALUES 6
#ifdef GL_core_profile
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer lobe_array { float at[]; };
#endif

/*
 * Bits of the specialization constant LIGHTING_ID, beside the list's (GPU_LIST_KINDS, GPU_LIST_SCATTERED): shaders have no code for what a frame lacks.
 */
#define GPU_LIGHTING_SIMPLE 0x200u     /* every light is a sphere or a cone without a hull */
#define GPU_LIGHTING_PROFILES 0x100000u /* some spheres and cones have a profile (lights/profile.glsl) */
#define GPU_LIGHTING_MASKS 0x2000000u  /* some lights affect only surfaces whose light mask shares a bit with theirs */
#define GPU_LIGHTING_AREA_LIGHTS 0x800000u /* some lights are area lights (lights/area.glsl) */
#define GPU_LIGHTING_LAYERS 0x80000u   /* some surfaces have layers (shaders/layers.glsl) */
#define GPU_LIGHTING_ENVIRONMENT 0x40000u  /* ambient light comes from the environment (shaders/environment.glsl) */
#define GPU_LIGHTING_REFLECTIONS 0x200000u /* in the boxes of reflection probes it comes from these (shaders/reflections.glsl) */
#define GPU_LIGHTING_CONSERVING 0x8000000u /* surfaces conserve energy (FNL_ENERGY_CONSERVING); the environment's table is there */
#define GPU_LIGHTING_BEHIND_GLASS 0x400000u /* blended surfaces in front of gpu_lighting.glass are left out */
/* Shadows. With both of the first two, rays find the shadows of lights that have no map. */
#define GPU_LIGHTING_RAYS 0x400u
#define GPU_LIGHTING_MAPS 0x800u
#define GPU_LIGHTING_SOFT 0x1000u      /* with rays: sources have a size, and several rays find how much of one is seen */
#define GPU_LIGHTING_FILTERED 0x2000u  /* with maps: gpu_frame.shadow_filter smooths their edges */
#define GPU_LIGHTING_SAMPLED 0x4000u   /* with rays: only some of a point's lights are sent one (shadows/sampled.glsl) */
#define GPU_LIGHTING_RAY_QUERY 0x8000u /* with rays: they traverse the device's acceleration structures (shadows/ray_query.glsl) */
#define GPU_LIGHTING_CUBEMAP 0x20000u  /* with rays: cube maps say where light enters rooms (shadows/cubemap.glsl) */
#define GPU_LIGHTING_CONTACT 0x4000000u /* with or without another method: a march along the depth image (lighting/visibility_contact.glsl) */
#define GPU_LIGHTING_SHADOWED 0x402fc00u /* any of the eight above */
#define GPU_LIGHTING_CASTS (GPU_LIGHTING_RAYS | GPU_LIGHTING_MAPS | GPU_LIGHTING_CUBEMAP | GPU_LIGHTING_CONTACT) /* with one of these, lights cast shadows */
/* Of single passes, with GPU_LIGHTING_SAMPLED. */
#define GPU_LIGHTING_GUIDED 0x1000000u /* earlier frames' visibility guides the choice (shadows/guide_shared.h) */
#define GPU_LIGHTING_DENOISED 0x10000u /* the light of chosen lights is kept apart, to be denoised (passes/shadow/denoise.h) */

/* Lights, or the bounds of other entities that lists are built over. Scope: a frame; with light-lod a view. */
struct gpu_light_set {
    uint directional_count;
    uint local_count;               /* lights that are not directional, or bounds */
    ADDRESS(light_array) lights;    /* directional ones first; 0 if no light is among the bounds */
    ADDRESS(entity_array) entities; /* bounds, a place for each local light */
    ADDRESS(shape_block) shapes;    /* see gpu_entity_bounds */
    ADDRESS(plane_array) planes;    /* of hulls */
    ADDRESS(const_uint_array) masks; /* of lights: the mask in the low 8 bits, the contact shadow scale as a half in the high 16; with GPU_LIGHTING_MASKS */
    ADDRESS(profile_array) profiles; /* with GPU_LIGHTING_PROFILES */
    ADDRESS(lobe_array) lobes;      /* with GPU_LIGHTING_AREA_LIGHTS */
};

/* What finds shadows. Scope: a group of views. */
struct gpu_shadows {
    uvec2 rays;     /* address of a struct gpu_rays; with GPU_LIGHTING_RAYS */
    uvec2 maps;     /* of a struct gpu_shadow_maps; with GPU_LIGHTING_MAPS */
    uvec2 rooms;    /* of a struct gpu_probes; with GPU_LIGHTING_CUBEMAP */
    uint ray_count; /* that a point sends; with GPU_LIGHTING_SAMPLED, as the next */
    uint seed;      /* the choice of lights depends on it and on the pixel */
    uint contact;   /* sampled: depth of the view's opaque surfaces; with GPU_LIGHTING_CONTACT, as the next */
    uint contact_samples; /* of the image */
    float contact_length; /* meters */
};

/* One for each view and list. */
struct gpu_lighting {
    STRUCT(gpu_light_set) lights; /* first, so that a reference to the lighting is one to its lights; an address would cost shaders two registers */
    ADDRESS(light_list_block) list;
    ADDRESS(view_block) view;
    STRUCT(gpu_shadows) shadows;
    uint glass; /* sampled: the depth of the nearest glass; with GPU_LIGHTING_BEHIND_GLASS */
};

#endif
