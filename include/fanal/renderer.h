/* SPDX-License-Identifier: MIT */
/** Renders a scene on a device, frame by frame. */
#ifndef FANAL_RENDERER_H
#define FANAL_RENDERER_H

#include "fanal/device.h"
#include "fanal/image.h"
#include "fanal/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct fnl_renderer fnl_renderer;

/** The order in which surfaces are shaded. All give the same picture, except those that say otherwise. */
typedef enum fnl_shading {
    FNL_SHADING_FORWARD = 0,     /**< one pass over the geometry */
    FNL_SHADING_FORWARD_PREPASS, /**< depth first, then each visible fragment once */
    FNL_SHADING_DEFERRED, /**< G-buffer, then compute shading; transparent surfaces forward; MSAA by fnl_frame.msaa_method */
    FNL_SHADING_DEFERRED_VOLUMES, /**< G-buffer, then a volume drawn for each light and blended additively, the traditional way; lists serve only
                                       transparent surfaces; no MSAA */
    /** Sums the light of each pixel from normals and roughness alone; a second pass over the geometry applies the materials; no MSAA. */
    FNL_SHADING_LIGHT_PREPASS,
    /** The same, but the lights are drawn as rectangles and blended into a diffuse and a specular buffer; lists serve only transparent
        surfaces; no MSAA. */
    FNL_SHADING_PRE_LIGHTING,
    /** The same at reduced resolution (`light_scale`), filtered by depth, normal and roughness. Close, not equal; no MSAA. */
    FNL_SHADING_LOW_RES,
    /**
     * Normals, depth and items at reduced resolution (`light_scale`), with blended surfaces stippled in among the others; light for each of
     * those texels; materials at full resolution, which filter the light by item, depth and normal. Close, not equal; no MSAA.
     */
    FNL_SHADING_INFERRED,
    /** Depth first; volumes of lights write ids into each pixel, which forward shading reads; lists serve only transparent surfaces; no MSAA. */
    FNL_SHADING_LIGHT_INDEXED,
    /** The same, but the volumes write the direction, colour and attenuation of each light, in layers. */
    FNL_SHADING_ZIOMA,
    FNL_SHADING_VISIBILITY, /**< ids of triangles, then compute shading that interpolates by itself; transparent surfaces forward */
    /**
     * Texture coordinates with their gradients, the tangent frame and the material, then compute shading that reads textures only for visible
     * surfaces; transparent surfaces forward; no MSAA. Normals are rounded as in a G-buffer.
     */
    FNL_SHADING_TEXTURING,
    /**
     * The same with 8 bytes a pixel: an atlas address, which also identifies the material, and the tangent frame. The atlas is filled with the pages
     * that frames request; pages that do not fit show less detail. Close, not equal. docs/techniques/deferred-texturing.md
     */
    FNL_SHADING_VIRTUAL_TEXTURING,
    /** Deferred, but blocks of pixels whose surfaces are alike are lit once: fnl_frame.coarse. Close, not equal; no MSAA. */
    FNL_SHADING_COARSE,
    /** References to triangles, and each visible triangle stored once; compute shading that interpolates by derivatives; transparent surfaces
        forward. fnl_frame.dais, docs/techniques/dais.md */
    FNL_SHADING_DAIS,
    FNL_SHADING_MOBILE, /**< for tile-based GPUs: G-buffer, lights and tone mapping in tile memory, of which only the picture is stored;
                             few bits a pixel, so pictures differ by rounding; no MSAA. docs/techniques/mobile.md */
    FNL_SHADING_AUTO, /**< the fastest order of the first three on this scene and device, found by measuring */
    FNL_SHADING_COUNT
} fnl_shading;

/** How a pixel finds the lights that reach it. All give the same picture, to the bit for one shading order. */
typedef enum fnl_light_lists {
    FNL_LISTS_ALL = 0,       /**< every light for every pixel: the reference */
    FNL_LISTS_TILED,         /**< 16 x 16 pixel tiles with depth bounds, built on the GPU */
    FNL_LISTS_CLUSTERED,     /**< 64 x 64 pixel tiles times exponential depth slices, built on the GPU */
    FNL_LISTS_CLUSTERED_CPU, /**< the same clusters, built by threads on the CPU */
    FNL_LISTS_MESH,          /**< a list for each drawn primitive; forward orders only */
    FNL_LISTS_BATCHES, /**< the same, drawn in batches of similar light counts by shaders with fixed loop counts; forward-prepass only */
    FNL_LISTS_MULTIPASS, /**< one pass over the geometry per light, added up; forward-prepass only */
    FNL_LISTS_GRID2D,    /**< a world-space grid seen from above */
    FNL_LISTS_WORLD,     /**< world-space clusters, kept while the camera moves */
    FNL_LISTS_HALFZ,     /**< tiles split in two at the middle of their depth range */
    FNL_LISTS_25D,       /**< tiles with masks of occupied depth cells */
    FNL_LISTS_ENHANCED,  /**< tiles whose entries carry a depth range that each pixel tests */
    FNL_LISTS_TREE,      /**< tiles with a tree over the depth ranges of their lights, built on the CPU */
    FNL_LISTS_BACKFACE,  /**< tiles that drop lights behind all of their normals */
    FNL_LISTS_FINE,      /**< tiles that keep only lights whose volume holds a pixel */
    FNL_LISTS_SPARSE,    /**< occupied clusters only, with tight bounds */
    FNL_LISTS_BVH,       /**< clusters filled from a tree over the lights that is rebuilt in every frame */
    FNL_LISTS_RASTER,    /**< clusters filled by conservative rasterisation of light meshes */
    FNL_LISTS_ZBIN,      /**< bit masks of tiles, cut by bins of depth */
    FNL_LISTS_AUTO,      /**< the fastest of those that give the same bits, found by measuring them in the first frames */
    FNL_LISTS_COUNT
} fnl_light_lists;

/** What a tile's bounds are, besides its depth range. */
typedef enum fnl_tile_bounds {
    FNL_TILE_BOUNDS_PLANES = 0, /**< four side planes */
    FNL_TILE_BOUNDS_BOX,        /**< planes, then a box round the tile */
    FNL_TILE_BOUNDS_PROJECTED,  /**< the light's bounding rectangle on the screen against the tile's pixels */
    FNL_TILE_BOUNDS_COUNT
} fnl_tile_bounds;

/** How depth is cut into the slices of clusters. */
typedef enum fnl_slices {
    FNL_SLICES_EXPONENTIAL = 0, /**< each slice is deeper than the last by a constant factor */
    FNL_SLICES_LINEAR,          /**< equal depths */
    FNL_SLICES_COUNT
} fnl_slices;

/** What draws the light meshes of raster lists. */
typedef enum fnl_raster_path {
    FNL_RASTER_AUTO = 0, /**< hardware where it can rasterise conservatively (fnl_device_info.conservative_raster) */
    FNL_RASTER_HARDWARE, /**< the same: there is nothing else that hardware could do without losing lights */
    FNL_RASTER_SOFTWARE, /**< compute shaders */
    FNL_RASTER_COUNT
} fnl_raster_path;

/** How the clusters of raster lists hold their lights. */
typedef enum fnl_raster_nodes {
    FNL_RASTER_ARRAY = 0, /**< an array for each cluster */
    FNL_RASTER_LINKS64,   /**< linked lists, 64 bits a light */
    FNL_RASTER_LINKS32,   /**< linked lists, 32 bits a light; up to 4096 lights and 1 048 575 links, then 64 */
    FNL_RASTER_NODES_COUNT
} fnl_raster_nodes;

/** What deferred-volumes draws for a light. */
typedef enum fnl_volume_shape {
    FNL_VOLUME_SOLIDS = 0, /**< the back faces of a sphere or a pyramid, where they are not in front of the surface */
    FNL_VOLUME_QUADS,      /**< its rectangle on the screen, as near as its nearest point, where no surface is nearer */
    FNL_VOLUME_FULLSCREEN, /**< the whole screen: every pixel asks whether the light reaches it */
    FNL_VOLUME_ELLIPSE,    /**< as quads, but an octagon round the ellipse that the bounding sphere is on the screen */
    FNL_VOLUME_DEPTH_BOUNDS, /**< as solids, and nothing where the surface is nearer than the light's nearest point or beyond its farthest */
    FNL_VOLUME_STENCIL, /**< as solids, but where its front faces are behind the surface a stencil holds a light off: light by light, two draws each; the lights in view beyond 2048 as solids. Falls back to depth-bounds where there is no D32_SFLOAT_S8_UINT */
    FNL_VOLUME_SHAPE_COUNT
} fnl_volume_shape;

/** What the shading orders that keep light separate from materials accumulate per pixel. */
typedef enum fnl_light_buffer {
    FNL_LIGHT_BUFFER_AUTO = 0, /**< two; four where light has a lower resolution than materials */
    FNL_LIGHT_BUFFER_RGBA, /**< four channels: diffuse light, and the luminance of highlights. Reflectance does not rise at grazing angles,
                                    and highlights take the hue of the diffuse light: an approximation */
    FNL_LIGHT_BUFFER_TWO,  /**< six: diffuse light and highlights, with the reflectance of the surface already in both */
    FNL_LIGHT_BUFFER_FOUR, /**< twelve: what any material needs, without knowing its reflectance */
    FNL_LIGHT_BUFFER_COUNT
} fnl_light_buffer;

/** How light-indexed stores the lights of a pixel. Pixels reached by more lights than fit use all lights and count in overflow_cells. */
typedef enum fnl_light_packing {
    FNL_LIGHT_PACKING_IDS = 0, /**< four 16-bit ids a layer, by integer atomics */
    FNL_LIGHT_PACKING_SHIFT, /**< a layer for each 255 lights in view: four 8-bit ids in RGBA8, by blending that shifts bits */
    FNL_LIGHT_PACKING_MAX,   /**< the same layers: the greatest and the least id by blending, twice */
    FNL_LIGHT_PACKING_COUNT
} fnl_light_packing;

/** Where the axis of the cone round a tile's normals comes from. */
typedef enum fnl_backface_axis {
    FNL_BACKFACE_AXIS_SAMPLES = 0, /**< the mean of four pixels */
    FNL_BACKFACE_AXIS_SUM,         /**< a sum over the pixels of those tiles that need one */
    FNL_BACKFACE_AXIS_MIPS,        /**< a level of a pyramid of all normals */
    FNL_BACKFACE_AXIS_COUNT
} fnl_backface_axis;

/**
 * How the G-buffer is laid out: that of this renderer, and published ones (docs/techniques/gbuffer.md). All give the same picture within
 * their quantisation: materials that a layout cannot hold are lit forward in the same frame.
 */
typedef enum fnl_gbuffer {
    FNL_GBUFFER_DEFAULT = 0, /**< 16 bytes a pixel; holds every material */
    FNL_GBUFFER_SIEGE,       /**< 16 bytes: Rainbow Six Siege, with motion and a material ID */
    FNL_GBUFFER_KILLZONE2,   /**< 12 bytes: Killzone 2, dielectrics alone */
    FNL_GBUFFER_FROSTBITE2,  /**< 12 bytes: Battlefield 3, with a material ID */
    FNL_GBUFFER_STALKER,     /**< 20 bytes: S.T.A.L.K.E.R., with a position and a material ID */
    FNL_GBUFFER_CLEAR_SKY,   /**< 12 bytes: S.T.A.L.K.E.R. Clear Sky, with a material ID */
    FNL_GBUFFER_ENGEL,       /**< 12 bytes: Engel 2009, dielectrics alone */
    FNL_GBUFFER_DESTINY,     /**< 8 bytes: Destiny, with a material ID; smoothness is in the normal's length */
    FNL_GBUFFER_COUNT
} fnl_gbuffer;

/** The pass type of deferred lighting. Both give the same bits. */
typedef enum fnl_deferred_pass {
    FNL_DEFERRED_COMPUTE = 0, /**< a dispatch; each thread checks whether its pixel needs lighting */
    FNL_DEFERRED_FRAGMENT, /**< a full-screen draw with a stencil test; compute where the device has no stencil format of its own */
    FNL_DEFERRED_PASS_COUNT
} fnl_deferred_pass;

/** How normals are stored in the G-buffer. docs/techniques/gbuffer.md compares their precision. */
typedef enum fnl_normal_encoding {
    FNL_NORMALS_LAYOUT = 0, /**< as the layout defines them */
    FNL_NORMALS_OCTAHEDRAL,
    FNL_NORMALS_XYZ,           /**< three components */
    FNL_NORMALS_XY,            /**< x and y in view space; wrong where a normal looks away along the axis of the view */
    FNL_NORMALS_SPHERICAL,     /**< two angles, one of them as its cosine */
    FNL_NORMALS_SPHERE_MAP,    /**< Lambert's azimuthal projection */
    FNL_NORMALS_STEREOGRAPHIC, /**< in view space; wrong where a normal looks away by more than 30 degrees */
    FNL_NORMALS_VIEW,     /**< x and y relative to the view direction of the pixel; wrong where a normal looks away from it */
    FNL_NORMALS_BEST_FIT, /**< three components of 8 bits, scaled to the length with the least error */
    FNL_NORMALS_FLOAT,    /**< 16 bytes in a target of its own: what the others are compared with */
    FNL_NORMALS_COUNT
} fnl_normal_encoding;

/** Settings of the light lists; each names the lists that use it. None changes the picture except light_buffer and light_scale. */
typedef struct fnl_list_options {
    bool
        frustum_cull; /**< lights outside the view are culled first; default true. Lists made on the GPU from the view, and
                            deferred-volumes; without it lights_in_view counts all */
    uint32_t tile_size;          /**< pixels, 8, 16, 32 or 64; default 16. Lists of tiles */
    fnl_tile_bounds tile_bounds; /**< default FNL_TILE_BOUNDS_BOX. tiled, halfz, 2.5d */
    bool min_depth,
        max_depth;   /**< lights before the nearest, beyond the farthest pixel of a tile are left out; default true. tiled */
    bool cone_tests; /**< spots are tested as cones, not as spheres; default true. tiled, halfz, 2.5d, clustered, bvh */
    bool fine_pruning;   /**< each pixel is tested against the lights' true volumes; default true. fine */
    uint32_t fine_masks; /**< side in pixels of the squares that share a mask: 1, 2, or 0: no masks; default 1. fine */
    bool
        fine_packed; /**< a tile takes 32 bytes, without masks and pool: 24 lights of the first 1024 in view; tiles with others count in
                            overflow_cells and use all lights in view; default false. fine */
    bool
        normal_cones; /**< lights behind all surfaces of a cluster are left out; default true. sparse, with deferred shading */
    fnl_backface_axis backface_axis; /**< default samples. backface */
    bool tree_hybrid;      /**< lights are kept in a flat array where a tree is not expected to save tests; default true. tree */
    uint32_t cluster_size; /**< pixels, 8 .. 256; default 64. Lists of clusters */
    uint32_t slices;       /**< 1 .. 1024; default 32. Lists of clusters */
    fnl_slices distribution; /**< default exponential. Lists of clusters */
    float cluster_near; /**< view depth in metres where the first slice ends, > 0; INFINITY (default): chosen by the scene */
    float
        cluster_far; /**< view depth where the last slice begins, > cluster_near; INFINITY (default): chosen by the scene */
    fnl_raster_path raster_path;   /**< default auto. raster */
    fnl_raster_nodes raster_nodes; /**< default array. raster */
    fnl_volume_shape volume_shape; /**< default solids. The shading order deferred-volumes */
    fnl_light_buffer
        light_buffer; /**< default auto. The shading orders light-prepass, low-res and inferred (which takes two for four) */
    fnl_light_packing light_packing; /**< default ids. The shading order light-indexed */
    uint32_t
        light_layers; /**< of light-indexed, 1 .. 16 (see fnl_light_packing), and lights a pixel of zioma, 1 .. 8; default 4 */
    uint32_t
        light_scale; /**< pixels along a side of what is lit once, 2 or 4; default 2. The shading orders low-res and inferred */
} fnl_list_options;

FNL_API fnl_list_options fnl_list_options_default(void);

/**
 * Which samples deferred shading lights where pixels have several (`msaa`). all .. compact give the same bits; docs/techniques/deferred-msaa.md
 * compares them.
 */
typedef enum fnl_msaa_method {
    FNL_MSAA_ALL = 0,   /**< every sample */
    FNL_MSAA_TILES,     /**< every sample of 8 x 8 pixel tiles that have an edge, one of each pixel elsewhere */
    FNL_MSAA_STENCIL,   /**< every sample of pixels that show an edge, in a pass of their own */
    FNL_MSAA_COMPACT,   /**< every surface of a pixel once; those beyond the first from a list */
    FNL_MSAA_COVERAGE,  /**< one surface of each pixel; what else it shows takes the light of a neighbour: not exact */
    FNL_MSAA_AGGREGATE, /**< like surfaces of a pixel are merged and shaded by their statistics: not exact */
    FNL_MSAA_METHOD_COUNT
} fnl_msaa_method;

/** Where FNL_SHADING_DAIS keeps its references. Both give the same picture. */
typedef enum fnl_dais_mode {
    FNL_DAIS_TARGET = 0, /**< a render target with as many samples as the picture */
    FNL_DAIS_LIST,       /**< a word a pixel, and list elements for triangles that do not cover all of it */
    FNL_DAIS_MODE_COUNT
} fnl_dais_mode;

typedef struct fnl_dais_options {
    fnl_dais_mode mode;     /**< default target */
    uint32_t cache_buckets; /**< of the cache of triangles, two triangles each: a power of two, 1 .. 2^22; default 65536 */
    bool multirate; /**< ambient light is found once for four pixels of a triangle: close, not equal; default false */
} fnl_dais_options;

FNL_API fnl_dais_options fnl_dais_options_default(void);

/** How blended surfaces (FNL_ALPHA_BLEND) that overlap in a pixel are composed. */
typedef enum fnl_transparency {
    FNL_TRANSPARENCY_SORTED =
        0, /**< objects are drawn back to front by their centres: wrong where they intersect */
    FNL_TRANSPARENCY_WEIGHTED, /**< in no order: a mean weighted by distance; exact where one surface covers a pixel */
    FNL_TRANSPARENCY_LINKED,   /**< exact: the fragments of each pixel are listed and sorted */
    FNL_TRANSPARENCY_COUNT
} fnl_transparency;
/** Antialiasing of edges, besides `msaa`. docs/techniques/antialiasing.md compares them. */
typedef enum fnl_antialiasing {
    FNL_ANTIALIASING_NONE = 0,
    FNL_ANTIALIASING_MLAA, /**< morphological: from the shapes of edges in the picture, by the rules of its first publication */
    FNL_ANTIALIASING_SMAA, /**< the same with diagonals, sharp corners and local contrast adaptation */
    FNL_ANTIALIASING_TAA, /**< temporal: sample positions change from frame to frame, and surfaces accumulate their samples; no MSAA */
    FNL_ANTIALIASING_COUNT
} fnl_antialiasing;

/** How box and volume decals are applied to surfaces. Both ways give the same picture. docs/techniques/decals.md compares them. */
typedef enum fnl_decals {
    FNL_DECALS_LISTS = 0, /**< surfaces look them up in a list while they are drawn, blended ones too */
    FNL_DECALS_GBUFFER, /**< boxes are drawn over the finished G-buffer (mobile: close, not equal); blended surfaces, orders without a G-buffer and MSAA
                               use lists all the same */
    FNL_DECALS_OFF,     /**< none, except those that are baked */
    FNL_DECALS_COUNT
} fnl_decals;
/** The granularity of culling. The picture is the same. docs/techniques/culling.md compares them. */
typedef enum fnl_culling {
    FNL_CULLING_INSTANCES = 0, /**< primitives of instances out of the view */
    FNL_CULLING_CLUSTERS,  /**< of the others, clusters of up to 124 triangles that are out of it, face away, or lie between samples */
    FNL_CULLING_TRIANGLES, /**< of the others, each triangle likewise */
    FNL_CULLING_COUNT
} fnl_culling;

/** What draws the clusters that remain after fnl_culling. The picture is the same. docs/techniques/culling.md compares them. */
typedef enum fnl_geometry {
    FNL_GEOMETRY_VERTEX = 0, /**< vertex shaders, by indices that culling writes */
    FNL_GEOMETRY_MESH, /**< mesh shaders, a work group for each cluster; needs fnl_device_info.mesh_shader and culling by clusters or triangles */
    FNL_GEOMETRY_AUTO, /**< mesh where these are there and no CPU runs them, which takes several times as long; else vertex */
    FNL_GEOMETRY_COUNT
} fnl_geometry;

/** What the shading order mobile stores per pixel, and in how many bits. */
typedef enum fnl_mobile_layout {
    FNL_MOBILE_METALLIC_128 = 0, /**< light, depth, normal and roughness, colour and metalness; dielectrics reflect 4 % */
    FNL_MOBILE_SPECULAR_160,     /**< light, depth, normal and roughness, diffuse colour, specular colour */
    FNL_MOBILE_METALLIC_256,     /**< positions, and everything in floating point */
    FNL_MOBILE_SPECULAR_256,
    FNL_MOBILE_LAYOUT_COUNT
} fnl_mobile_layout;

/** How the layouts of 8 bits a channel keep colours. */
typedef enum fnl_mobile_gamma {
    FNL_MOBILE_GAMMA_SRGB = 0, /**< by the hardware */
    FNL_MOBILE_GAMMA_SQRT,     /**< exponent 2, in the shader */
    FNL_MOBILE_GAMMA_POWER,    /**< exponent 2.2, in the shader */
    FNL_MOBILE_GAMMA_COUNT
} fnl_mobile_gamma;

/** The format in which light accumulates, in the layouts of 128 and 160 bits. */
typedef enum fnl_mobile_light {
    FNL_MOBILE_LIGHT_FLOAT = 0, /**< 11, 11 and 10 bits of floating point: nothing clips */
    FNL_MOBILE_LIGHT_UNORM, /**< 10 bits each, up to `range` of white; needs an exposure that is known beforehand, else float */
    FNL_MOBILE_LIGHT_COUNT
} fnl_mobile_light;

/** How the order mobile finds the lights of a pixel. */
typedef enum fnl_mobile_lights {
    FNL_MOBILE_LIGHTS_LISTS = 0, /**< by fnl_frame.lists */
    FNL_MOBILE_LIGHTS_VOLUMES,   /**< a volume drawn for each (fnl_list_options.volume_shape), added up in a target of 64 or 128 bits besides;
                                      lists serve only blended surfaces. The same lights and the same picture, to the rounding of sums */
    FNL_MOBILE_LIGHTS_COUNT
} fnl_mobile_lights;

/** Settings of the order mobile. */
typedef struct fnl_mobile_options {
    fnl_mobile_layout layout; /**< default metallic-128 */
    fnl_mobile_gamma gamma;   /**< default srgb */
    fnl_mobile_light light;   /**< default float */
    fnl_mobile_lights lights; /**< default lists */
    float range;              /**< of unorm light: exposed radiance that it can hold, > 0; default 8 */
    bool separate;            /**< passes of their own, as where the device cannot merge them; default false */
    bool
        recycle; /**< the picture takes the memory of the normals, one attachment less; layouts of 128 and 160 bits; default false */
} fnl_mobile_options;

FNL_API fnl_mobile_options fnl_mobile_options_default(void);
FNL_API const char *fnl_mobile_layout_name(fnl_mobile_layout layout);
FNL_API const char *fnl_mobile_gamma_name(fnl_mobile_gamma gamma);
FNL_API const char *fnl_mobile_light_name(fnl_mobile_light light);
FNL_API const char *fnl_mobile_lights_name(fnl_mobile_lights lights);

/** One attachment of a layout. */
typedef struct fnl_mobile_target {
    const char *name;
    uint32_t bits, used_bits;
} fnl_mobile_target;
/** Fills in at most `capacity` and returns how many there are; with light in 10 bits. 0 for a value out of range. */
FNL_API uint32_t fnl_mobile_layout_targets(fnl_mobile_layout layout, fnl_mobile_target *out, uint32_t capacity);

/** Where the shading order texturing gets texture gradients from. */
typedef enum fnl_gradients {
    FNL_GRADIENTS_STORED = 0, /**< the geometry pass writes them: 8 bytes a pixel, 16 with a second set of coordinates */
    FNL_GRADIENTS_DERIVED, /**< from neighbours that stored slopes of depth, 4 bytes a pixel, show to lie on the same surface. Approximate: where no
                                neighbour does, the level of textures is a guess */
    FNL_GRADIENTS_COUNT
} fnl_gradients;
/** What decides that the pixels of a block lie on one surface, in addition to comparing normals and materials. */
typedef enum fnl_coarse_criterion {
    FNL_COARSE_CRITERION_Z = 0, /**< view depths differ from the first pixel's by no more than its gradient explains */
    FNL_COARSE_CRITERION_ID,    /**< one triangle of one object; needs fnl_device_info.primitive_ids */
    FNL_COARSE_CRITERION_MINMAX, /**< ranges of depth and normal, by samplers where the device has them: finds no more blocks than z */
    FNL_COARSE_CRITERION_COUNT
} fnl_coarse_criterion;

/** Which part of the light a block shares; the rest is computed per pixel. */
typedef enum fnl_coarse_split {
    FNL_COARSE_SPLIT_NONE = 0,   /**< all of it, by a base colour that is filtered over the block: fnl_coarse_filter */
    FNL_COARSE_SPLIT_ALBEDO,     /**< all of it, before base colours: each pixel has its own */
    FNL_COARSE_SPLIT_HIGHLIGHTS, /**< diffuse and ambient light; the highlights of lights are made for each pixel */
    FNL_COARSE_SPLIT_SHARP, /**< all but lights whose edge shows: spots, wedges, boxes and clipped ones light each pixel */
    FNL_COARSE_SPLIT_COUNT
} fnl_coarse_split;

/** Where the base colour of a block comes from. Not with FNL_COARSE_SPLIT_ALBEDO. */
typedef enum fnl_coarse_filter {
    FNL_COARSE_FILTER_MEAN = 0, /**< its pixels' mean */
    FNL_COARSE_FILTER_SAMPLED,  /**< a target of its own, 4 bytes a pixel: textures as a pixel of the block's size samples them */
    FNL_COARSE_FILTER_NONE,     /**< its first pixel, which flickers in motion */
    FNL_COARSE_FILTER_COUNT
} fnl_coarse_filter;

/** Settings of the order coarse. docs/techniques/coarse.md describes their effect on time and picture. */
typedef struct fnl_coarse_options {
    uint32_t size; /**< pixels along a side of a block: 2, 4, or 1: every pixel is lit, which gives the picture of deferred; default 2 */
    fnl_coarse_criterion criterion; /**< default z */
    /** Depths may differ by this much of size * sqrt(2) * (|dz/dx| + |dz/dy|), >= 0; on a plane the greatest difference is about
        (size - 1) / (size * sqrt(2)) of that. Default 1. z and minmax */
    float depth_factor;
    float normal_degrees;   /**< normals may differ by this angle, 0 .. 180; default 2 */
    float tolerance;        /**< so may roughness, metalness, occlusion, F90 and the root of F0, 0 .. 1; default 0.05 */
    float albedo_tolerance; /**< and linear base colours, 0 .. 1; default 1: by any amount, as they are filtered */
    fnl_coarse_split split; /**< default none */
    fnl_coarse_filter filter; /**< default mean */
    bool gather; /**< what blocks share is written after all else is lit, not at once: the same picture; default false */
    float ao_radius; /**< metres, >= 0: ambient light is dimmed by what is so near, found at the same coarse rate. 0 (default): off */
} fnl_coarse_options;

FNL_API fnl_coarse_options fnl_coarse_options_default(void);
FNL_API const char *fnl_coarse_criterion_name(fnl_coarse_criterion criterion);
FNL_API const char *fnl_coarse_split_name(fnl_coarse_split split);
FNL_API const char *fnl_coarse_filter_name(fnl_coarse_filter filter);

typedef enum fnl_tonemap {
    FNL_TONEMAP_NONE = 0,
    FNL_TONEMAP_KHRONOS_NEUTRAL,
    FNL_TONEMAP_ACES,
    FNL_TONEMAP_AGX,
    FNL_TONEMAP_COUNT
} fnl_tonemap;

typedef enum fnl_exposure {
    FNL_EXPOSURE_AUTO = 0, /**< metered from the frame itself */
    FNL_EXPOSURE_EV,       /**< by fnl_frame.ev: radiance is scaled by 1 / (1.2 * 2^ev) */
    FNL_EXPOSURE_NONE      /**< radiance is shown as it is */
} fnl_exposure;

typedef enum fnl_debug_view {
    FNL_DEBUG_NONE = 0,
    FNL_DEBUG_ALBEDO,
    FNL_DEBUG_NORMAL,
    FNL_DEBUG_DEPTH,
    FNL_DEBUG_ROUGHNESS,
    FNL_DEBUG_LIGHTS,       /**< heat map of the lights that a pixel visits, with a legend */
    FNL_DEBUG_CELLS,        /**< tiles, or depth slices in colours, of the light lists */
    FNL_DEBUG_OVERDRAW,     /**< fragments per pixel, hidden ones too, with a legend */
    FNL_DEBUG_TILE_NORMALS, /**< mean normals of the tiles of backface lists */
    FNL_DEBUG_BACKFACES,    /**< heat map of the lights that backface lists drop from each tile, with a legend */
    FNL_DEBUG_OVERSHADING, /**< invocations of the fragment shader per pixel of visible surfaces, helpers of 2x2 squares too, with a legend */
    FNL_DEBUG_LAYERS, /**< heat map of the blended surfaces that a pixel shows, with a legend */
    FNL_DEBUG_DECALS, /**< heat map of the boxes and volumes of decals that hold a pixel's surface, with a legend */
    FNL_DEBUG_GBUFFER_0, /**< fields of a render target of the G-buffer, as lighting reads them; a quarter of the picture each, if several */
    FNL_DEBUG_GBUFFER_1,
    FNL_DEBUG_GBUFFER_2,
    FNL_DEBUG_GBUFFER_3,
    FNL_DEBUG_GBUFFER_4,
    FNL_DEBUG_MATERIAL_ID, /**< colours for the material IDs in the G-buffer */
    FNL_DEBUG_LIT_FORWARD, /**< white where the layout cannot hold the material, which is therefore lit forward */
    FNL_DEBUG_EDGES, /**< deferred MSAA: pixels that show several things: blue one surface and sky, green 2 surfaces, yellow 3, red more */
    FNL_DEBUG_MOTION, /**< motion vectors: hue is direction, saturation speed; grey stands still */
    FNL_DEBUG_HALOS, /**< metals blue; what is neither metal nor not, metalness from 0.1 to 0.9, red, the brighter the more its colour shines */
    FNL_DEBUG_COARSE, /**< FNL_SHADING_COARSE: green where a block is lit once */
    FNL_DEBUG_COARSE_REASON, /**< and why others are not: depth or triangle red, normal blue, material yellow */
    FNL_DEBUG_DAIS_ADDRESSES, /**< FNL_SHADING_DAIS: a colour for each stored triangle; white: there was no room for it */
    FNL_DEBUG_DAIS_TRIANGLES, /**< different triangles that a pixel shows: 1 grey, 2 green, 3 yellow, more red */
    FNL_DEBUG_DAIS_FAILURES,  /**< red where a triangle was stored because its bucket of the cache stayed locked */
    FNL_DEBUG_CLUSTERS, /**< colours for the clusters of triangles that culling knows; needs fnl_device_info.primitive_ids */
    FNL_DEBUG_ATLAS, /**< FNL_SHADING_VIRTUAL_TEXTURING: the base colours that its atlas holds; hatched where it is empty */
    FNL_DEBUG_PAGES, /**< the same: a colour for each page, darker the coarser; striped where a finer one was wanted; 1 sample */
    FNL_DEBUG_COUNT
} fnl_debug_view;

/** Names as the command line takes them, such as "forward-prepass"; NULL for a value out of range. */
FNL_API const char *fnl_shading_name(fnl_shading shading);
FNL_API const char *fnl_light_lists_name(fnl_light_lists lists);
FNL_API const char *fnl_tile_bounds_name(fnl_tile_bounds bounds);
FNL_API const char *fnl_backface_axis_name(fnl_backface_axis axis);
FNL_API const char *fnl_slices_name(fnl_slices slices);
FNL_API const char *fnl_raster_path_name(fnl_raster_path path);
FNL_API const char *fnl_raster_nodes_name(fnl_raster_nodes nodes);
FNL_API const char *fnl_volume_shape_name(fnl_volume_shape shape);
FNL_API const char *fnl_msaa_method_name(fnl_msaa_method method);
FNL_API const char *fnl_dais_mode_name(fnl_dais_mode mode);
FNL_API const char *fnl_transparency_name(fnl_transparency transparency);
FNL_API const char *fnl_decals_name(fnl_decals decals);
FNL_API const char *fnl_culling_name(fnl_culling culling);
FNL_API const char *fnl_geometry_name(fnl_geometry geometry);
FNL_API const char *fnl_antialiasing_name(fnl_antialiasing aa);
FNL_API const char *fnl_deferred_pass_name(fnl_deferred_pass pass);
FNL_API const char *fnl_gbuffer_name(fnl_gbuffer layout);
FNL_API const char *fnl_normal_encoding_name(fnl_normal_encoding normals);
FNL_API const char *fnl_light_packing_name(fnl_light_packing packing);
FNL_API const char *fnl_light_buffer_name(fnl_light_buffer buffer);
FNL_API const char *fnl_gradients_name(fnl_gradients gradients);
FNL_API const char *fnl_tonemap_name(fnl_tonemap tonemap);
FNL_API const char *fnl_debug_view_name(fnl_debug_view view);

/** A field of a G-buffer layout. Its bits lie in render target `target`; those that share bits with another have 0. */
typedef struct fnl_gbuffer_field {
    const char *name;
    uint32_t target, bits;
} fnl_gbuffer_field;

typedef struct fnl_gbuffer_info {
    uint32_t target_count;
    uint32_t target_bits[5]; /**< a pixel */
    uint32_t
        bits; /**< sum of those: what this renderer stores beside depth (32), radiance (64) and, where needed, a mask (8) */
    uint32_t published_bits;     /**< of the publication: with its depth, stencil and light accumulation */
    uint32_t material_count;     /**< that its IDs tell apart; 0: no ID */
    fnl_normal_encoding normals; /**< FNL_NORMALS_LAYOUT means this one */
    uint32_t encodings;          /**< bit 1 << e: the encoding e goes with the layout */
    uint32_t field_count;
    const fnl_gbuffer_field *fields;
} fnl_gbuffer_info;

/** What a layout consists of. */
FNL_API fnl_result fnl_gbuffer_query_info(fnl_gbuffer layout, fnl_gbuffer_info *out);

/** Whether a shading order can be combined with a kind of lists; a frame that asks for a pair that cannot fails with FNL_ERROR_UNSUPPORTED. */
FNL_API bool fnl_lists_supported(fnl_shading shading, fnl_light_lists lists);
/** Whether FNL_SHADING_AUTO chooses among orders of which this is one. */
FNL_API bool fnl_shading_likely(fnl_shading shading);
/**
 * Whether FNL_LISTS_AUTO would measure these lists with this order, in a scene of so many point, spot and shaped lights, with 1, 2, 4 or 8 samples a
 * pixel: a few dozen pairs that are worth comparing, of several hundred. False for pairs that do not go together, and for AUTO itself.
 */
FNL_API bool fnl_lists_likely(fnl_shading shading, fnl_light_lists lists, uint32_t light_count, uint32_t msaa);
/** Whether pixels may have several samples (fnl_frame.msaa) with an order; FNL_SHADING_AUTO chooses one that has them. */
FNL_API bool fnl_msaa_supported(fnl_shading shading);

/** What visibility shading sorts pixels by, so that each class of materials is shaded by a shader that has only what it needs. */
typedef enum fnl_visibility_sort {
    FNL_VISIBILITY_SORT_OFF = 0,  /**< nothing: one shader for all */
    FNL_VISIBILITY_SORT_CLASS,    /**< what the material needs: light, metal, textures, a normal map */
    FNL_VISIBILITY_SORT_MATERIAL, /**< the same, then the material */
    FNL_VISIBILITY_SORT_COUNT
} fnl_visibility_sort;

/** Settings of the order visibility. */
typedef struct fnl_visibility_options {
    fnl_visibility_sort sort; /**< default off. The picture is the same */
    /** The id pass stores where in its triangle each pixel is, so that shading fetches no positions; 1 sample. Default false. */
    bool barycentrics;
    /**
     * The id pass draws a target of half the size with four samples, one for each pixel of the picture: a quarter of the fragments. Pixels are then
     * seen and shaded a quarter of a pixel off their centres, right or left and above or below, where samples stand. 1 sample, not with
     * barycentrics; plain where decals are drawn over surfaces again. Default false.
     */
    bool grid;
} fnl_visibility_options;

FNL_API fnl_visibility_options fnl_visibility_options_default(void);
FNL_API const char *fnl_visibility_sort_name(fnl_visibility_sort sort);

/** What a frame keeps for fnl_renderer_read; bits. */
typedef enum fnl_output {
    FNL_OUTPUT_COLOR = 1,     /**< tone-mapped, sRGB-encoded RGBA8: the picture, or the debug view */
    FNL_OUTPUT_RADIANCE = 2,  /**< linear radiance in cd/m^2 before exposure and tone mapping, RGBA32F */
    FNL_OUTPUT_SURFACE = 4,   /**< RGBA32F: base colour RGB, roughness, of the nearest surface (blended ones left out) */
    FNL_OUTPUT_NORMAL = 8,    /**< RGBA32F: world-space normal, view depth in metres; 0 where there is nothing */
    FNL_OUTPUT_POSITION = 16, /**< RGBA32F: world-space position; draw item id + 1, 0 where there is nothing */
    /**
     * RGBA32F: by how many pixels, right and down, an opaque surface or the background was elsewhere in the last frame; its view depth then,
     * metres, 1e30 for an empty background; 1 and the part of the motion, in pixels, that is not the camera's, or 0 where it was behind the
     * camera or there was no last frame. No MSAA.
     */
    FNL_OUTPUT_MOTION = 32
} fnl_output;

typedef struct fnl_frame {
    uint32_t width, height; /**< pixels, 1 .. 16384; default 1280 x 720 */
    fnl_camera camera;      /**< default fnl_camera_default() */
    fnl_shading shading;    /**< default FNL_SHADING_DEFERRED */
    fnl_light_lists lists;  /**< default FNL_LISTS_AUTO */
    fnl_list_options list_options;
    uint32_t
        msaa; /**< samples: 1, 2, 4, 8, as far as the device goes (fnl_device_info.max_msaa); orders with fnl_msaa_supported(); default 1 */
    fnl_msaa_method msaa_method; /**< default compact. FNL_SHADING_DEFERRED */
    uint32_t msaa_groups;        /**< surfaces of a pixel at most, 2 or 3; default 2. FNL_MSAA_AGGREGATE */
    /**
     * Samples of a pixel count as one surface up to this difference of colours, of parameters, and of normals as a chord, 0 .. 1; the surface
     * is then shaded as the first of them. 0 (default): what is stored must be equal. FNL_SHADING_DEFERRED, but for FNL_MSAA_ALL.
     */
    float msaa_tolerance;
    fnl_culling culling;           /**< of opaque and alpha-masked surfaces; default instances, which adds no passes: on the CPU driver it is as fast
                                        as any in scenes such as builtin:hall; larger ones gain by triangles, and most with occlusion */
    /**
     * Default vertex. Frames in which some pass has vertices in a way of its own are drawn by vertex shaders whatever this says: motion and taa, stored
     * barycentrics of visibility, the lists batches and multipass, mesh decals. fnl_frame_stats.geometry tells what the frame had.
     */
    fnl_geometry geometry;
    /**
     * Occluded opaque and alpha-masked surfaces are culled too, by the depth of this very frame; the picture is the same, the debug view
     * overdraw shows less. Default false. Without effect with low-res, inferred and the grid of visibility, and with MSAA where a debug view or an output of
     * surfaces looks at the centres of pixels.
     */
    bool occlusion;
    fnl_transparency transparency; /**< default sorted */
    fnl_decals decals;             /**< default lists */
    /**
     * FNL_DECALS_GBUFFER: pictures are filtered by how the surface itself lies, not by how positions differ from pixel to pixel, which at
     * silhouettes draws a fringe. Default true; false shows the fault.
     */
    bool decal_mip_fix;
    /** Default none. mlaa and smaa change the colour output alone; taa collects over the frames of a renderer. */
    fnl_antialiasing aa;
    /** What was collected from earlier frames is forgotten: for cuts of the camera, which cannot be told from fast motion. Default false. */
    bool reset_history;
    /** Pixels are sampled this far right of and below their centres, pixels, -8 .. 8; default 0. The mean of frames at the places that
        fnl_jitter() gives is a picture with as many samples per pixel. */
    fnl_vec2 jitter;
    fnl_tonemap tonemap;   /**< default FNL_TONEMAP_KHRONOS_NEUTRAL */
    fnl_exposure exposure; /**< default FNL_EXPOSURE_AUTO */
    float ev;              /**< EV100 for FNL_EXPOSURE_EV, -64 .. 64; default 0 */
    fnl_debug_view debug;  /**< default none */
    uint32_t outputs;      /**< fnl_output bits; default FNL_OUTPUT_COLOR */
    bool count_lights;     /**< count light evaluations exactly (slower); they then appear in the stats; default false */
    bool timers;           /**< measure each pass on the GPU; default true */
    /**
     * FNL_SHADING_DEFERRED: sorts blocks of 8x8 or 4x4 pixels by the parts of the shader that they need and shades each class with a
     * variant that has nothing else; 8, 4, or 0 (default): one shader for all. The picture is the same.
     */
    uint32_t class_blocks;
    /**
     * Lights whose bounding sphere has a smaller radius on the screen than this, pixels, >= 0, are drawn as points of as much light and
     * light nothing; up to twice the size they fade. 0 (default): off.
     */
    float light_lod;
    fnl_deferred_pass deferred_pass; /**< deferred, with class_blocks 0 and 1 sample; default compute */
    fnl_gbuffer gbuffer; /**< deferred, deferred-volumes; default FNL_GBUFFER_DEFAULT */
    fnl_normal_encoding normals; /**< the same; one that the layout's normal can hold; default FNL_NORMALS_LAYOUT */
    bool
        chroma; /**< the same, default layout: base colour as luma, and one half of the chroma a pixel: 14 bytes; default false */
    fnl_mobile_options mobile; /**< of FNL_SHADING_MOBILE */
    fnl_visibility_options visibility; /**< of FNL_SHADING_VISIBILITY */
    /** Of FNL_SHADING_VIRTUAL_TEXTURING: texels along the side of the atlas at most, a multiple of 256, 256 .. 8192; default 8192. It takes
        no more than the scene needs, nor than a quarter of the device's memory. */
    uint32_t atlas_size;
    fnl_gradients gradients;   /**< of FNL_SHADING_TEXTURING; default stored */
    fnl_coarse_options coarse; /**< of FNL_SHADING_COARSE */
    /**
     * Extra loop iterations per light evaluation, 0 .. 100000, to imitate a more expensive material; the
     * picture stays the same. Orders that keep light apart from materials and mobile take no notice. Default 0.
     */
    uint32_t shade_cost;
    fnl_dais_options dais;     /**< of FNL_SHADING_DAIS */
    /** Depth first, so that hidden surfaces read no textures; the picture is the same. Orders with a G-buffer (deferred, deferred-volumes,
        light-prepass, pre-lighting, low-res, coarse), texturing, virtual-texturing and mobile; others take no notice. Default false. */
    bool gbuffer_prepass;
    /**
     * With FNL_SHADING_AUTO or FNL_LISTS_AUTO: this frame is not for measuring. It tries no candidate, has no pipelines made for one and adds
     * no timers; it takes the choice made so far, or else the one remembered from an earlier run, the best of what was measured, or the
     * likely one. On in all frames, a renderer never measures, and a choice changes only with the scene, the size or what is asked for.
     * For single frames, and where every frame must cost the same. Default false.
     */
    bool pin_choice;
    uint32_t record_threads; /**< threads that record commands; 0 (default): as many as the job system has */
} fnl_frame;

FNL_API fnl_frame fnl_frame_default(void);
/** Place `index` of a sequence that fills the pixel evenly, -0.5 .. 0.5; the first is its centre. */
FNL_API fnl_vec2 fnl_jitter(uint32_t index);

/** Both must outlive the renderer. The scene is uploaded by the first frame. */
FNL_API fnl_result fnl_renderer_create(fnl_device *device, fnl_scene *scene, fnl_renderer **out);
FNL_API void fnl_renderer_destroy(fnl_renderer **renderer);

/** Submits one frame; `frame` NULL means defaults. Changes of the scene since the last frame are taken along. */
FNL_API fnl_result fnl_renderer_render(fnl_renderer *renderer, const fnl_frame *frame);
/** Waits for the last frame and hands out one of its outputs (exactly one bit); free with fnl_image_free. */
FNL_API fnl_result fnl_renderer_read(fnl_renderer *renderer, fnl_output output, fnl_image *out);

typedef struct fnl_pass_time {
    const char *name;
    double milliseconds;
} fnl_pass_time;

typedef struct fnl_frame_stats {
    /** Light lists. Counts are exact and of this very frame. */
    uint32_t lights_total,
        lights_in_view; /**< in_view counts those whose bounds touch the view; for `all` lists it is the total */
    uint64_t list_bytes, list_entries;
    uint64_t list_used_bytes;       /**< the part of list_bytes that this frame's lights and cells fill */
    uint32_t cells,
        overflow_cells; /**< cells that used coarser lists, of about a hundredth of the screen, as the pool was too small in this frame */
    uint32_t lights_dropped;        /**< always 0: that is the contract */
    bool evaluations_counted;       /**< the next three, and mean and maximum, are only known with fnl_frame.count_lights */
    uint64_t unserved_points; /**< points shaded with coarser lists, or all lights: in cells that overflowed; with MSAA also off the surfaces of
                                 their cell or out of the view. Not counted by light-prepass, low-res and inferred */
    uint64_t evaluations;           /**< lights visited by shaded fragments, directional lights left out */
    uint64_t evaluations_useful; /**< those that reach the fragment's surface point: the least that any list could visit */
    uint64_t lights_behind;      /**< backface lists: lights in view that are behind the surfaces of every tile they touch */
    double mean_per_pixel;
    uint32_t max_per_pixel;
    uint32_t draws;                /**< draw calls (indirect ones count once) */
    uint64_t items, items_visible; /**< primitives of instances, and those left after culling */
    /**
     * Of what stands in place of a G-buffer where light is kept apart from materials, or in layers of lights: surfaces as lights need them,
     * sums of light, layers. Depth and radiance of the frame's size are left out; 0 with other orders. Ids of light-indexed are in list_bytes.
     */
    uint64_t light_bytes;
    uint32_t
        light_draws; /**< with deferred-volumes, draw calls of the volumes: 2, and 2 for each light that the shape stencil draws alone */
    uint64_t
        gbuffer_bytes; /**< of the G-buffer's targets in this frame, its mask included; depth and radiance are left out; 0 without one */
    /**
     * With FNL_SHADING_VIRTUAL_TEXTURING: pages that the scene has, that the atlas has room for, that the frame before wanted, that are
     * there, that were filled for this frame, that were wanted and found no room, and that gave way to others; bytes of the atlas.
     */
    uint32_t atlas_pages, atlas_capacity, atlas_wanted, atlas_resident, atlas_filled, atlas_missing, atlas_evicted;
    uint64_t atlas_bytes;
    uint64_t
        items_forward; /**< visible items that the G-buffer's layout cannot hold and a forward pass lights; known with count_lights */
    uint64_t triangles_visible; /**< of opaque and alpha-masked surfaces; known with count_lights */
    /**
     * Opaque and alpha-masked triangles of all instances, and with clusters or triangles of fnl_culling what became of them: drawn, out of the view,
     * facing away, between samples, occluded (with occlusion). Those of objects that one list or another draws in its own way (batches, multipass) count all the same.
     */
    uint64_t triangles_total, triangles_drawn, triangles_outside, triangles_back, triangles_small, triangles_occluded;
    uint64_t clusters_total, clusters_drawn; /**< clusters of all instances, those of which something is drawn */
    uint64_t items_occluded; /**< with occlusion: items in view that others hide */
    fnl_geometry geometry;   /**< what drew the clusters: vertex or mesh */
    uint32_t items_whole; /**< visible items that were drawn as a whole because a pool was too small in this frame */
    /** With class_blocks: blocks by class, bit 0 some pixel has lights, 1 some is metal, 2 all are shaded; [8]: nothing to shade. */
    uint32_t shading_blocks[9];
    /**
     * With FNL_TRANSPARENCY_LINKED: blended fragments that nothing opaque hides, the most in one pixel, and pixels that were
     * drawn as sorted because the pool was too small in this frame. Bytes: what linked and weighted take beside the picture.
     */
    uint64_t blend_fragments, blend_bytes;
    uint32_t blend_longest, blend_overflow;
    /** With FNL_SHADING_VISIBILITY and fnl_visibility_options.sort or MSAA: classes that occur, and pixels, or triangles of pixels, to shade. */
    uint32_t visibility_classes, visibility_entries;
    uint32_t visibility_fragments; /**< how often the id pass wrote; known with count_lights */
    /** With FNL_SHADING_DEFERRED and those of deferred texturing and MSAA, and FNL_SHADING_VISIBILITY, where each triangle is a surface. */
    uint32_t msaa_pixels,   /**< pixels that show a surface in some sample */
        msaa_edge_pixels;   /**< pixels whose samples show more than one thing, sky being one */
    uint64_t msaa_surfaces, /**< surfaces of all pixels; what msaa_groups and msaa_tolerance merge counts once */
        msaa_samples,       /**< samples that show a surface */
        msaa_shaded;        /**< how often a surface was shaded; known with count_lights */
    /** With FNL_SHADING_COARSE: blocks that show some surface; those lit once; those that are not for the sake of depths or triangles,
        normals, materials; pixels that show a surface; how often one was lit, for itself or its block. */
    uint32_t coarse_blocks, coarse_shared, coarse_by_depth, coarse_by_normal, coarse_by_material, coarse_pixels, coarse_shaded;
    uint32_t coarse_ao_shaded; /**< with ao_radius: how often occlusion was found */
    /** With FNL_SHADING_DAIS. */
    struct fnl_dais_stats {
        uint64_t bytes;           /**< of what this frame's references, triangles, cache and lists fill */
        uint32_t triangles;       /**< stored: each that is seen once, and those that the cache had forgotten */
        uint32_t unique;          /**< different ones among them; known with count_lights */
        uint32_t cache_failures;  /**< stored because a bucket of the cache stayed locked */
        uint32_t overflow;        /**< fragments that found a pool full and were shaded forward; the pool grows by the next frame */
        uint32_t list_elements;   /**< FNL_DAIS_LIST: triangles of pixels that they do not cover wholly */
        uint32_t shading_samples; /**< with multirate: places where ambient light was found */
        uint32_t shaded;          /**< triangles of all pixels, each of which is shaded once; known with count_lights */
    } dais;
    uint32_t decals_total,
        decals_in_view; /**< decals that are shown (baked ones left out); boxes and volumes whose bounds touch the view */
    uint64_t decal_entries; /**< of the list over them, and of the tiles of the G-buffer's way */
    uint32_t
        decal_overflow; /**< cells, or pixels of the G-buffer's way, that went through all decals as the pool was too small */
    /**
     * What the frame's passes move between images and memory, by formats and load and store operations and not measured: an attachment
     * that is loaded or stored, an image that a shader reads or writes, counts as a whole each time; copies, textures and buffers are
     * left out. fnl_renderer_print_traffic has it by passes.
     */
    uint64_t image_bytes_read, image_bytes_written;
    uint64_t tile_bytes; /**< of attachments that never leave tile memory on GPUs that have it */
    uint64_t lazy_bytes,
        lazy_committed_bytes; /**< lazily allocated memory of those, and what of it the driver had to back */
    bool mobile_merged;       /**< FNL_SHADING_MOBILE: the passes shared one scope */
    bool mobile_tonemapped;   /**< and tone mapping was in it */
    double cpu_milliseconds;  /**< recording and submitting */
    double gpu_milliseconds;  /**< sum of all passes; 0 without timers */
    float ev;                 /**< exposure used, EV100 */
    uint64_t device_bytes, device_peak_bytes;
    fnl_shading shading; /**< what the frame was rendered with: the choice of auto, or what was asked for */
    fnl_light_lists
        lists; /**< likewise; mesh where that stood in for batches or multipass, which have no MSAA and only so many passes */
    bool choosing;      /**< auto has not decided yet; false with pin_choice */
    /** Pipelines for candidates of auto that are still to be made in the background; as long as there are any it does not measure. */
    uint32_t pipelines_pending;
    const char *choice; /**< what auto chose by, or ""; owned by the renderer, valid until its next call */
    uint32_t pass_count;
    const fnl_pass_time *passes; /**< in order, owned by the renderer, valid until the next call on it */
} fnl_frame_stats;

/** Waits for the last frame and describes it. */
FNL_API fnl_result fnl_renderer_query_stats(fnl_renderer *renderer, fnl_frame_stats *out);
/** The compiled frame graph of the last frame as text, zero-terminated; returns the length it wants. */
FNL_API size_t fnl_renderer_print_plan(const fnl_renderer *renderer, char *text, size_t capacity);
/** The same way: what the passes of the last frame move between images and memory, as a table. */
FNL_API size_t fnl_renderer_print_traffic(const fnl_renderer *renderer, char *text, size_t capacity);

#ifdef __cplusplus
}
#endif
#endif
