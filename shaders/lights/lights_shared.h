/* SPDX-License-Identifier: MIT */
/** Lights, and the lists that say which of them reach a pixel. */
#ifndef FNL_SHADERS_LIGHTS_SHARED_H
#define FNL_SHADERS_LIGHTS_SHARED_H

#include "lights/bounds_shared.h"

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

/* How a pixel finds its lights; a specialisation constant of every shader that iterates. */
#define GPU_LIST_ALL 0u     /* every light, every pixel: the oracle */
#define GPU_LIST_TILES 1u   /* cells of the screen */
#define GPU_LIST_CLUSTERS 2u /* cells of the screen times slices of depth */
#define GPU_LIST_HALVES 3u  /* tiles with two depth ranges each */
#define GPU_LIST_RANGES 4u  /* tiles whose entries carry a depth range */
#define GPU_LIST_TREE 5u    /* tiles with a tree over depth ranges */
#define GPU_LIST_FINE 6u    /* tiles with masks per pixel */
#define GPU_LIST_SPARSE 7u  /* occupied clusters only, found through a table */
#define GPU_LIST_LINKS 8u   /* clusters with linked lists */
#define GPU_LIST_BINS 9u    /* bit masks of tiles, cut by ranges of depth bins */
#define GPU_LIST_WORLD 10u  /* a grid in world space */
#define GPU_LIST_ITEMS 11u  /* a cell for each draw item */
#define GPU_LIST_ONE 12u    /* one light, for a pass per light */
#define GPU_LIST_KINDS 0xffu /* the bits of the kind */
/* Beside the kind: points may be shaded off their pixel and off the surfaces that depth shows (MSAA); each is looked up where it is itself. */
#define GPU_LIST_SCATTERED 0x100u
/* Beside the kind: every light is a sphere or a cone without a hull. Shaders then have no code for other shapes, which costs registers. */
#define GPU_LIST_SIMPLE 0x200u
/* Beside the kind: lights cast shadows, which rays find, or maps. With both bits rays find those that have no map. */
#define GPU_LIST_RAYS 0x400u
#define GPU_LIST_MAPS 0x800u
/* Beside GPU_LIST_RAYS: lights have a size, and several rays find how much of it is seen. */
#define GPU_LIST_SOFT 0x1000u
/* Beside GPU_LIST_MAPS: gpu_frame.shadow_filter smooths their edges. */
#define GPU_LIST_FILTERED 0x2000u
/* Beside GPU_LIST_RAYS: of a point's lights only some are sent a ray (shadows/sampled.glsl). */
#define GPU_LIST_SAMPLED 0x4000u
/* Beside GPU_LIST_RAYS: rays go through the device's own structures, not the trees (shadows/ray_query.glsl). */
#define GPU_LIST_RAY_QUERY 0x8000u
/* Beside GPU_LIST_RAYS: cube maps say where light comes into rooms (shadows/cubemap.glsl). */
#define GPU_LIST_CUBEMAP 0x20000u
/* Any of the seven above; and those of them with which lights cast shadows. */
#define GPU_LIST_SHADOWED 0x2fc00u
#define GPU_LIST_CASTS (GPU_LIST_RAYS | GPU_LIST_MAPS | GPU_LIST_CUBEMAP)
/* Beside GPU_LIST_SAMPLED: what earlier frames saw of lights guides the choice (shadows/guide_shared.h). Of passes, not of lists. */
#define GPU_LIST_GUIDED 0x1000000u
/* Beside GPU_LIST_SAMPLED: what the chosen lights give is kept apart, to be denoised (passes/shadow/denoise.h). Of passes, not of lists. */
#define GPU_LIST_DENOISED 0x10000u
/* Beside the kind: ambient light comes from the environment (shaders/environment.glsl). */
#define GPU_LIST_ENVIRONMENT 0x40000u
/* Beside the kind: some surfaces have layers (shaders/layers.glsl). */
#define GPU_LIST_LAYERS 0x80000u
/* Blended surfaces that are drawn before glass: those in front of gpu_view.glass are left out. */
#define GPU_LIST_BEHIND_GLASS 0x400000u
/* Beside the kind: some spheres and cones have a profile (lights/profile.glsl). */
#define GPU_LIST_PROFILES 0x100000u

/* Beside the kind: some lights are rectangles (lights/area.glsl). */
#define GPU_LIST_RECTANGLES 0x800000u

/* Light profiles, one after the other: steps of the vertical angle, steps of the horizontal one, and the values, a row for each vertical angle. */
#ifdef GL_core_profile
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer profile_array { float at[]; };
#endif
/* Of rectangles: how the specular lobe is made of a cosine, by roughness and then by the viewer's angle (tools/area_lobes.c). In alphas, the stretch along
   the plane of the normal and the viewer, and across; the sine of the angle from the mirror direction to the axis; shear; what the transformed cosine is
   multiplied by; and the part of it above the surface. */
#define AREA_LOBE_ROWS 16
#define AREA_LOBE_COLUMNS 32
#define AREA_LOBE_VALUES 6
#ifdef GL_core_profile
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer lobe_array { float at[]; };
#endif
/* Beside the kind: in the boxes of reflection probes ambient light comes from these (shaders/reflections.glsl). */
#define GPU_LIST_REFLECTIONS 0x200000u

/* count of a cell whose list did not fit into the pool: the spare list is used instead. */
#define GPU_CELL_ALL 0xffffffffu

/*
 * The spare list serves points that no cell does: bit masks over all local lights, a row for each of a few tiles of the screen and for each
 * of SPARE_BINS ranges of depth. A point visits the lights that are in both of its rows. It takes 16 bytes a light and no pool, so that it
 * cannot overflow. Word 0 says whether this frame made it; where it did not, all lights are used.
 */
#define SPARE_ROWS 128u
#define SPARE_BINS 32u            /* half an octave of view depth each, from the near plane on; the last has no end */

/* GPU_LIST_LINKS: cells are the numbers of first nodes, a uint each; ids are nodes of one word (light << 20 | next) or two (kind << 24 |
   light, next). Nodes ascend by light. */
#define GPU_NODES_ARRAY 0u  /* no nodes: GPU_LIST_CLUSTERS */
#define GPU_NODES_64 1u
#define GPU_NODES_32 2u
#define GPU_NODE_END 0xffffffffu
#define GPU_NODE_ALL 0xfffffffeu /* first node of a cell that did not fit */
#define GPU_NODE_32_END 0xfffffu /* next of the last node */
#define GPU_NODE_32_LIGHTS 4096u /* that fit into the bits */

/*
 * GPU_LIST_FINE, packed: a tile takes GPU_PACKED_WORDS words in place of a cell. Each holds the places of up to three lights among those in
 * view, GPU_PACKED_BITS each from the least bit up, and how many in its two highest bits. Words are full from the first on. A tile whose
 * lights these cannot hold has GPU_PACKED_ALL (no lights, and places that are not 0) in its first word, the number of lights in view in its
 * second, and uses all of those. gpu_light_list.ids: lights in view -> local lights.
 */
#define GPU_PACKED_WORDS 8u
#define GPU_PACKED_BITS 10u
#define GPU_PACKED_LIGHTS 24u     /* of a tile */
#define GPU_PACKED_IN_VIEW 1024u
#define GPU_PACKED_ALL 0x3fffffffu

/* GPU_LIST_TREE */
#define GPU_TREE_LIGHTS 128u /* that share a tree */
#define GPU_TREE_LEAF 0x80000000u

struct gpu_cell {
    uint offset;         /* into ids */
    uint count;          /* or GPU_CELL_ALL */
};

/*
 * What a cell encloses, in view space: between four planes (inside is dot(normal, p) + d >= 0, unit normals) and in a box. z is
 * negative in front of the viewer. low.z > high.z: the cell is empty and takes no light.
 */
struct gpu_cell_bounds {
    vec4 planes[4];
    vec3 low;
    vec3 high;
};

struct gpu_light_list {
    uint directional_count;
    uint local_count;    /* lights that are not directional, or whatever bounds the list is over */
    uint tile_size;      /* pixels */
    uint tiles_x;
    uint tiles_y;
    uint slices;         /* 1 for tiles */
    float slice_scale;   /* slice = log2(view depth) * scale + bias, clamped; view depth * scale + bias where linear is 1 */
    float slice_bias;
    vec3 origin;         /* world: least corner of the grid */
    float inverse_size;  /* world: cells a metre */
    uint linear;
    uint zone_slices;    /* bins: that a tile's mask is for */
    uint nodes;          /* GPU_NODES_…, of GPU_LIST_LINKS */
    ADDRESS(light_array) lights; /* directional ones first */
    ADDRESS(entity_array) entities; /* bounds of what the list is over: local lights, decals … */
    ADDRESS(shape_block) shapes; /* see gpu_entity_bounds */
    ADDRESS(plane_array) planes; /* of hulls */
    ADDRESS(cell_array) cells;   /* x fastest, then y, then slice */
    ADDRESS(const_uint_array) ids; /* ascending in each cell; 0 is the first local light */
    ADDRESS(const_uint_array) extra; /* what else a kind needs. Bins: lights in view -> local lights. Items: the scene. Fine: masks and
                                        positions. Halves: bits of the view depth where a tile's farther half begins. Ranges: a depth
                                        range for each entry. Tree: nodes */
    uint first_cell;     /* fine: of this list in cells */
    uint other_cell;     /* fine: of the list for points that no mask was made for; GPU_CELL_ALL: they take all lights */
    uint mask_size;      /* fine: side of the squares of pixels that share a mask; 0: no masks */
    uint positions;      /* fine: where in extra the tested positions begin; 0: they are those of shading */
    float eye_distance;  /* fine: of the eye from the world's origin, metres */
    uint packed;         /* fine: 1: cells are GPU_PACKED_WORDS words each, without masks */
    ADDRESS(view_block) view;       /* what is shaded for */
    ADDRESS(view_block) cells_view; /* what the cells and the spare list are of: the same, or the view of a head for its eyes */
    ADDRESS(bounds_array) bounds; /* of the cells, where kinds built from depth or boxes of items serve scattered points; or 0 */
    uint masks_depth;    /* tiles: 1: extra has a mask of occupied depth cells for each */
    ADDRESS(const_uint_array) spare; /* the spare list; or 0 */
    uint spare_words;    /* of a row; 0: there is no spare list */
    uint spare_tile_size; /* pixels */
    uvec2 spare_tiles;
    uint buckets;        /* sparse: keys of a cluster, 1 or one for each range of normals. In extra: the occupied ones before each, and one more */
    uint cell_limit;     /* sparse: cells that there is memory for */
    uvec2 rays;          /* address of a struct gpu_rays; of lists with GPU_LIST_RAYS */
    uvec2 shadow_maps;   /* address of a struct gpu_shadow_maps; of lists with GPU_LIST_MAPS */
    uvec2 probes;        /* address of a struct gpu_probes; of lists with GPU_LIST_CUBEMAP */
    uint shadow_rays;    /* that a point sends; of lists with GPU_LIST_SAMPLED, as the next */
    ADDRESS(profile_array) profiles; /* of lists with GPU_LIST_PROFILES */
    uint shadow_seed;    /* what the choice of lights depends on, besides the pixel */
    ADDRESS(lobe_array) lobes; /* of lists with GPU_LIST_RECTANGLES */
};

#endif
