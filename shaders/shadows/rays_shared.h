/* SPDX-License-Identifier: MIT */
/**
 * The scene as shadow rays see it: a tree over the triangles of all primitives, each in the space of its mesh, and one over the draw items that
 * place them in the world.
 */
#ifndef FNL_SHADERS_RAYS_SHARED_H
#define FNL_SHADERS_RAYS_SHARED_H

#include "scene_shared.h"

/* References to nodes: a number of the tree's nodes, or of a leaf with RAY_LEAF. */
#define RAY_LEAF 0x80000000u
#define RAY_END 0xffffffffu

/*
 * A node of a binary tree whose leaves are numbered from left to right. The walk needs no stack: below the node comes its first child; beside
 * it what gpu_ray_tree.next says of its last leaf.
 */
struct gpu_ray_node {
    vec3 low;
    uint first; /* reference of the first child */
    vec3 high;
    uint last;  /* number of the last leaf below */
};

struct gpu_ray_tree {
    ADDRESS(ray_node_array) nodes;
    ADDRESS(const_uint_array) next; /* by leaf: reference of what comes after it and all that end with it, or RAY_END */
    ADDRESS(const_uint_array) ids;  /* by leaf: what it is */
    uint root;                      /* reference, or RAY_END */
};

/* The triangles of a primitive among those of all, which are its leaves too: `first` and the `count` - 1 that follow. */
struct gpu_ray_mesh {
    uint first;
    uint count;
    vec3 low;   /* of the box round the vertices as they are modelled, object space */
    vec3 scale; /* 1 / size of that box, or 0 */
};

/* A draw item in the world. */
struct gpu_ray_item {
    vec4 rows[3]; /* world to object */
    uint primitive;
};

/* low.x > high.x: of what holds nothing. */
struct gpu_ray_box {
    vec3 low;
    vec3 high;
};

struct gpu_rays {
    STRUCT(gpu_ray_tree) meshes; /* leaves: triangles. The root is not used: each primitive has its own. May be missing, and `roots` too */
    STRUCT(gpu_ray_tree) items;
    ADDRESS(ray_mesh_array) mesh_table;
    ADDRESS(const_uint_array) roots; /* by primitive: reference in `meshes`, or RAY_END */
    ADDRESS(ray_item_array) placed;
    ADDRESS(ray_box_array) primitive_boxes; /* round the triangles of each, in the space of its mesh, as it is deformed */
    ADDRESS(scene_block) scene;
    ADDRESS(const_uint_array) indices;
    uvec2 top; /* with GPU_LIGHTING_RAY_QUERY: address of the device's structure of the instances, whose custom indices are numbers of draw items */
};

#endif
