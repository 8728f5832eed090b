/* SPDX-License-Identifier: MIT */
/**
 * What lists are built from: a sphere, and a tighter shape where the sphere is too loose, around each thing that a pixel may find in a list.
 * Lights and decals have bounds, and so may anything else that fills a part of space. Builders read bounds; only those that ask which way a
 * light shines (backface, sparse with normal cones) look up the light itself. Shading reads the lights or decals and no bounds.
 */
#ifndef FNL_SHADERS_BOUNDS_SHARED_H
#define FNL_SHADERS_BOUNDS_SHARED_H

#include "shared.h"

/*
 * The values of fnl_light_kind. Lists bound each kind from GPU_SHAPE_BOX on by a box, so compare with `>=`. Kinds from GPU_SHAPE_RECTANGLE on are flat area
 * lights: spot_offset is negative if both sides shine, and the box extends past the light by the range on all sides.
 */
#define GPU_SHAPE_NONE 0u   /* of directional lights */
#define GPU_SHAPE_SPHERE 1u /* of point lights */
#define GPU_SHAPE_CONE 2u   /* a sector of a sphere, of spots */
#define GPU_SHAPE_CAPSULE 3u
#define GPU_SHAPE_WEDGE 4u  /* a pyramid with a spherical end */
#define GPU_SHAPE_BOX 5u
#define GPU_SHAPE_RECTANGLE 6u

#ifdef GL_core_profile
bool shape_is_area(uint kind) { return kind >= GPU_SHAPE_RECTANGLE; }
#endif

/* A convex volume in world space. It is the first member of a light, which contributes exactly zero outside it. */
struct gpu_shape {
    vec3 position;       /* centre, apex, or middle of a capsule or box */
    float range;         /* metres from the position; nothing of the shape is farther away */
    uint kind;           /* GPU_SHAPE_… */
    uint hull_count;     /* planes that bound it besides; 0: none */
    vec3 direction;      /* unit, its axis; of a light where it shines to */
    float spot_scale;    /* cone: the half angle's cosine is -offset / scale. Of a light its ramp: see gpu_light */
    float spot_offset;   /* rectangle: half its height, negative if both sides shine; spot_scale is half its width */
    vec3 side;           /* unit, at right angles to the direction: across a wedge or box; of spheres only those with a profile */
    vec3 size;           /* capsule: half length, radius; wedge: tangents of the half angles across and up;
                            box, area light: half sizes across, up and along; of lights that are spheres or cones x is the place of their profile, or 0 */
    uint hull_first;     /* of its first plane in gpu_light_set.planes */
};

/* Planes of hulls: xyz is unit and points outward, w the distance of the plane from the shape's position; inside is
   dot(xyz, p - position) < w. */
#ifdef GL_core_profile
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer plane_array { vec4 at[]; };
#endif

/* Whose bounds they are. light_input.kinds has a bit for each kind that is wanted. */
#define GPU_ENTITY_LIGHT 0u
#define GPU_ENTITY_DECAL 1u
#define GPU_ENTITY_PROBE 2u /* a reflection probe */
#define GPU_ENTITY_KINDS 3u

#define GPU_NO_SHAPE 0xffffffffu

/*
 * Bounds of one light, decal or other thing. Lists name places in an array of these. In an array of one kind, place and user index are the
 * same, and shading uses the place; a reader of a list over several kinds looks up `kind` and `user`.
 */
struct gpu_entity_bounds {
    vec3 center;  /* world-space sphere that holds all of it */
    float radius; /* 0: it reaches nothing, and is in no list */
    uint shape;   /* bytes from gpu_light_set.shapes to its gpu_shape; GPU_NO_SHAPE: the sphere is all there is */
    uint kind;    /* GPU_ENTITY_… */
    uint user;    /* which one of its kind */
};

#endif
