/* SPDX-License-Identifier: MIT */
/** Lists that say which lights reach a pixel. */
#ifndef FNL_SHADERS_LIGHTS_SHARED_H
#define FNL_SHADERS_LIGHTS_SHARED_H

#include "lights/bounds_shared.h"

/* How a pixel finds its lights; part of the specialization constant LIGHTING_ID. */
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
    uint directional_count; /* of `lights`, as the next; where the local lights begin */
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
    ADDRESS(light_set_block) lights; /* what the list is over: lights, decals … */
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
    ADDRESS(view_block) view; /* of the cells and the spare list; that of a head where its eyes share the list */
    ADDRESS(bounds_array) bounds; /* of the cells, where kinds built from depth or boxes of items serve scattered points; or 0 */
    uint masks_depth;    /* tiles: 1: extra has a mask of occupied depth cells for each */
    ADDRESS(const_uint_array) spare; /* the spare list; or 0 */
    uint spare_words;    /* of a row; 0: there is no spare list */
    uint spare_tile_size; /* pixels */
    uvec2 spare_tiles;
    uint buckets;        /* sparse: keys of a cluster, 1 or one for each range of normals. In extra: the occupied ones before each, and one more */
    uint cell_limit;     /* sparse: cells that there is memory for */
};

#endif
