/* SPDX-License-Identifier: MIT */
/** Light meshes, shells and lists of the raster builder. */
#ifndef FNL_PASSES_RASTER_SHARED_H
#define FNL_PASSES_RASTER_SHARED_H

#include "shared.h"
#include "lighting/lighting_shared.h"

/*
 * Unit meshes. Cones: apex, rim, a second ring where the plane that touches the cap in its middle begins, and that middle; vertices are
 * (cos, sin, GPU_CONE_…) and become points when the cone's angle is known. Boxes have no vertices of their own: shape_corners() makes them.
 * Spheres have no mesh.
 */
#define GPU_CONE_SIDES 12u
#define GPU_CONE_VERTICES 26u
#define GPU_CONE_TRIANGLES 48u
#define GPU_BOX_VERTICES 8u
#define GPU_BOX_TRIANGLES 12u
#define GPU_CONE_APEX 0.0
#define GPU_CONE_RIM 1.0
#define GPU_CONE_CAP 2.0
#define GPU_CONE_POLE 3.0

#define GPU_RASTER_TRIANGLES (GPU_CONE_TRIANGLES + GPU_BOX_TRIANGLES)

/* 1 / cos(pi / GPU_CONE_SIDES): rings are drawn round their circles. */
#define GPU_CONE_SCALE 1.0352762

/* A light in view on the grid of tiles. */
struct gpu_raster_light {
    uint columns; /* first | last << 16 */
    uint rows;    /* the same; first > last: touches no tile */
    uint slices;  /* of the whole light, first | last << 16 */
};

/*
 * What a light's mesh covers of a tile; both are 0xffffffff where nothing was found. Only minima are taken, so the order in which
 * triangles come does not matter.
 */
struct gpu_raster_slot {
    uint first;     /* nearest slice of the faces that look at the viewer; unset beside a set `last`: the viewer is inside */
    uint last;      /* 0xffff - the farthest slice of all faces */
};
#define RASTER_UNSET 0xffffffffu

/* A mesh made for one light: any triangles, in world space, that enclose what it lights. */
struct gpu_raster_mesh {
    uint first;  /* triangle; its corners are at 3 * first in `points` */
    uint count;
};

/* What all steps of a frame share. */
struct gpu_raster {
    vec3 vertices[GPU_CONE_VERTICES];
    uint triangles[GPU_RASTER_TRIANGLES]; /* three times eight bits; cones, boxes; numbers within the mesh */
    ADDRESS(view_block) view;
    ADDRESS(light_list_block) list;
    ADDRESS(const_uint_array) visible_sums; /* its element light_count is the number of lights in view */
    ADDRESS(const_uint_array) visible_ids;
    ADDRESS(bound_array) bounds;
    ADDRESS(raster_light_array) lights;   /* one for each light in view */
    ADDRESS(uint_array) slot_sums;        /* tiles of each light in view, then where its slots begin; one more */
    ADDRESS(raster_slot_array) slots;     /* of light after light, row by row of its rectangle */
    ADDRESS(uint_array) arguments;        /* of the dispatch with a group for each light in view, and of the draw with an instance */
    ADDRESS(uint_array) sums;             /* cell * chunk_count + chunk, and one more: counts, then their prefix sum */
    ADDRESS(cell_array) cells;            /* or heads of linked lists, a uint each */
    ADDRESS(uint_array) ids;              /* the pool */
    ADDRESS(uint_array) overflow;         /* [0]: number of cells that did not fit */
    ADDRESS(raster_mesh_array) meshes;    /* with own_meshes: one for each local light, count 0: by its kind */
    ADDRESS(point_array) points;
    uint light_count;
    uint cell_count;
    uint chunk_size;
    uint chunk_count;
    uint capacity;      /* entries of the pool */
    uint slot_capacity;
    uint gradient;      /* 1: slices by the plane of a triangle over the tile, not by what the triangle covers of it (ES-61) */
    uint own_meshes;    /* 1: some lights have meshes of their own */
    uint draws;         /* 1: meshes are drawn, and only spheres are left to raster_shell.comp.glsl */
    float near;         /* no surface is nearer, metres */
};

struct gpu_raster_push {
    ADDRESS(raster_block) raster;
};

#endif
