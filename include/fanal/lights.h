/* SPDX-License-Identifier: MIT */
/** Light lists: how a pixel finds the lights that reach it. docs/choosing.md compares them. */
#ifndef FANAL_LIGHTS_H
#define FANAL_LIGHTS_H

#include "fanal/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/** The kinds of light lists. For one shading path all of them give the same picture, to the bit. */
typedef enum fnl_light_lists {
    FNL_LISTS_ALL = 0,       /**< brute force: every light for every pixel; the reference */
    FNL_LISTS_TILED,         /**< tiles of the screen with depth bounds, built on the GPU */
    FNL_LISTS_CLUSTERED,     /**< tiles of the screen times depth slices, built on the GPU */
    FNL_LISTS_CLUSTERED_CPU, /**< the same clusters, built by threads on the CPU */
    FNL_LISTS_MESH,          /**< a list for each drawn primitive; forward, forward-prepass, visibility and dais only */
    FNL_LISTS_BATCHES,       /**< the same; primitives with similar light counts are drawn by shaders with fixed loops; forward-prepass only */
    FNL_LISTS_MULTIPASS,     /**< one pass over the geometry for each light, added up; forward-prepass only */
    FNL_LISTS_GRID2D,        /**< a world-space grid, seen from above */
    FNL_LISTS_WORLD,         /**< world-space clusters, kept while the camera moves */
    FNL_LISTS_HALFZ,         /**< tiles split in two at the middle of their depth range */
    FNL_LISTS_25D,           /**< tiles with bit masks of the depth slices that contain surfaces */
    FNL_LISTS_ENHANCED,      /**< tiles whose entries carry a depth range that each pixel tests */
    FNL_LISTS_TREE,          /**< tiles with a tree over the depth ranges of their lights, built on the CPU */
    FNL_LISTS_BACKFACE,      /**< tiles that drop lights behind all of their surfaces */
    FNL_LISTS_FINE,          /**< tiles that keep only lights whose volume contains one of their pixels */
    FNL_LISTS_SPARSE,        /**< only those clusters that hold surfaces, with tight bounds */
    FNL_LISTS_BVH,           /**< clusters filled from a light tree that is rebuilt every frame */
    FNL_LISTS_RASTER,        /**< clusters filled by conservative rasterisation of the light volumes */
    FNL_LISTS_ZBIN,          /**< bit masks of tiles, intersected with bins of depth */
    FNL_LISTS_AUTO,          /**< measures the likely kinds in the first frames and keeps the fastest */
    FNL_LISTS_COUNT
} fnl_light_lists;

/** Where the axis of the cone around a tile's normals comes from. */
typedef enum fnl_backface_axis {
    FNL_BACKFACE_AXIS_SAMPLES = 0, /**< the mean normal of four pixels */
    FNL_BACKFACE_AXIS_SUM,         /**< the mean normal of all pixels, for those tiles that need one */
    FNL_BACKFACE_AXIS_MIPS,        /**< a level of a pyramid of all normals */
    FNL_BACKFACE_AXIS_COUNT
} fnl_backface_axis;

/** Settings of several kinds of lists. None of the settings in this header changes the picture. */
typedef struct fnl_list_options {
    /** Culls lights outside the view before lists are built. Lists built on the GPU from the view, and the light volumes of shading paths; without
        it fnl_frame_stats.lights_in_view counts all lights. Default true. */
    bool frustum_cull;
    /** Tests spot lights as cones, not as spheres: tiled, halfz, 2.5d, enhanced, backface, clustered, sparse, bvh. Default true. */
    bool cone_tests;
    /** backface: where the axis of the cone around a tile's normals comes from. Default samples. */
    fnl_backface_axis backface_axis;
    /** tree: a tile keeps a plain list where a tree is not expected to save tests. Default true. */
    bool tree_hybrid;
    /** sparse with deferred paths: drops lights behind all surfaces of a cluster. Default true. */
    bool normal_cones;
} fnl_list_options;

/** What bounds a tile besides its depth range. */
typedef enum fnl_tile_bounds {
    FNL_TILE_BOUNDS_PLANES = 0, /**< the four side planes of its frustum */
    FNL_TILE_BOUNDS_BOX,        /**< the planes, then a box around the frustum */
    FNL_TILE_BOUNDS_PROJECTED,  /**< none: the light's bounding rectangle on the screen is compared with the tile's pixels */
    FNL_TILE_BOUNDS_COUNT
} fnl_tile_bounds;

/** Settings of lists of tiles. */
typedef struct fnl_tile_options {
    /** Side of a tile in pixels: 8, 16, 32 or 64. Default 16. */
    uint32_t size;
    /** tiled, halfz, 2.5d, backface. Default box. */
    fnl_tile_bounds bounds;
    /** tiled, backface: drops lights in front of the nearest pixel of a tile, and behind the farthest. Default true. */
    bool min_depth, max_depth;
} fnl_tile_options;

/** How depth is divided into the slices of clusters. */
typedef enum fnl_slices {
    FNL_SLICES_EXPONENTIAL = 0, /**< each slice is deeper than the last by the same factor */
    FNL_SLICES_LINEAR,          /**< all slices are equally deep */
    FNL_SLICES_COUNT
} fnl_slices;

/** Settings of lists of clusters; zbin divides depth by them too, four bins to a slice. */
typedef struct fnl_cluster_options {
    /** Side of a cluster on the screen in pixels, 8 .. 256. Default 64. */
    uint32_t size;
    /** Number of depth slices, 1 .. 1024. Default 32. */
    uint32_t slices;
    /** Default exponential. */
    fnl_slices distribution;
    /** View depth in metres where the first slice ends, > 0, and where the last slice begins, > near. INFINITY (default): chosen from the scene. */
    float near, far;
} fnl_cluster_options;

/** Settings of the lists `fine`. */
typedef struct fnl_fine_options {
    /** Tests each pixel of a tile against the volumes of the lights. Default true. */
    bool pruning;
    /** Side in pixels of the squares that share a bit mask of lights: 1 or 2; 0: no masks. Default 1. */
    uint32_t masks;
    /** Stores a tile in 32 bytes, without masks or a pool: up to 24 lights among the first 1024 in view. Tiles with other lights count in
        overflow_cells and use all lights in view. Default false. */
    bool packed;
} fnl_fine_options;

/** What rasterises the light volumes of the lists `raster`. */
typedef enum fnl_raster_path {
    FNL_RASTER_AUTO = 0, /**< the hardware, where it rasterises conservatively (fnl_device_info.conservative_raster) */
    FNL_RASTER_HARDWARE, /**< the same; without conservative rasterisation hardware would lose lights, so compute shaders are used */
    FNL_RASTER_SOFTWARE, /**< compute shaders */
    FNL_RASTER_COUNT
} fnl_raster_path;

/** How clusters of the lists `raster` store their lights. */
typedef enum fnl_raster_nodes {
    FNL_RASTER_ARRAY = 0, /**< an array for each cluster */
    FNL_RASTER_LINKS64,   /**< linked lists with 64 bits per light */
    FNL_RASTER_LINKS32,   /**< linked lists with 32 bits per light, for up to 4096 lights and 1 048 575 links; 64 bits beyond */
    FNL_RASTER_NODES_COUNT
} fnl_raster_nodes;

/** Settings of the lists `raster`. */
typedef struct fnl_raster_options {
    fnl_raster_path path;   /**< default auto */
    fnl_raster_nodes nodes; /**< default array */
} fnl_raster_options;

#ifdef __cplusplus
}
#endif
#endif
