/* SPDX-License-Identifier: MIT */
/** Shading paths: how visible surfaces are shaded, and the settings of each path. docs/choosing.md compares them. */
#ifndef FANAL_SHADING_H
#define FANAL_SHADING_H

#include "fanal/lights.h"

#ifdef __cplusplus
extern "C" {
#endif

/** The shading paths. All give the same picture, except those that say otherwise. fnl_shading_supports() says which have MSAA. */
typedef enum fnl_shading {
    FNL_SHADING_FORWARD = 0,     /**< one pass over the geometry */
    FNL_SHADING_FORWARD_PREPASS, /**< depth first, then each visible fragment once */
    FNL_SHADING_DEFERRED,        /**< G-buffer, then a lighting pass; blended surfaces forward */
    /** G-buffer, then a volume drawn for each light and added up: the traditional way. Lists serve only blended surfaces. */
    FNL_SHADING_DEFERRED_VOLUMES,
    /** Sums the light of each pixel from normals and roughness alone; a second pass over the geometry adds the materials. */
    FNL_SHADING_LIGHT_PREPASS,
    /** The same, but lights are drawn as rectangles and blended into a diffuse and a specular buffer. Lists serve only blended surfaces. */
    FNL_SHADING_PRE_LIGHTING,
    /** The same at a part of the resolution, fnl_frame.light_buffer, filtered by depth, normal and roughness. Close, not equal. */
    FNL_SHADING_LOW_RES,
    /** Inferred lighting: normals, depth and object ids at a part of the resolution, blended surfaces stippled among the others; light for each of
        those texels; materials at full resolution. Close, not equal. */
    FNL_SHADING_INFERRED,
    /** Depth first; light volumes write light ids into each pixel, which forward shading reads. Lists serve only blended surfaces. */
    FNL_SHADING_LIGHT_INDEXED,
    /** The same, but the volumes write direction, colour and attenuation of each light, in layers. */
    FNL_SHADING_ZIOMA,
    /** Visibility buffer: triangle ids, then a compute pass that fetches and interpolates vertices; blended surfaces forward. Close, not equal. */
    FNL_SHADING_VISIBILITY,
    /** Deferred texturing: texture coordinates, gradients, tangent frame and material, then a compute pass that samples the textures of visible
        surfaces only. Normals are rounded as in a G-buffer. Close, not equal. */
    FNL_SHADING_TEXTURING,
    /** The same with 8 bytes per pixel: a place in a texture atlas and the tangent frame. The atlas holds the pages that frames need; where it is
        full, surfaces show less detail. Close, not equal. docs/techniques/deferred-texturing.md */
    FNL_SHADING_VIRTUAL_TEXTURING,
    /** Deferred, but blocks of pixels with similar surfaces are shaded once. Close, not equal. docs/techniques/coarse.md */
    FNL_SHADING_COARSE,
    /** Deferred attribute interpolation: references to triangles, each visible triangle stored once, then a compute pass that interpolates by
        derivatives. Close, not equal. docs/techniques/dais.md */
    FNL_SHADING_DAIS,
    /** For tile-based GPUs: G-buffer, lighting and tone mapping in tile memory; only the picture is stored. Fewer bits per pixel, so the
        picture differs by rounding. docs/techniques/mobile.md */
    FNL_SHADING_MOBILE,
    FNL_SHADING_AUTO, /**< measures the first three, and visibility with fnl_frame.choose_close, on this scene and device and keeps the fastest */
    FNL_SHADING_COUNT
} fnl_shading;

/**
 * Whether a path can use a kind of light list with `msaa` samples per pixel (1, 2, 4 or 8; false for other numbers); a frame that asks for what it
 * cannot fails with FNL_ERROR_UNSUPPORTED. FNL_LISTS_AUTO: whether some lists can, so this asks for the path and the samples alone.
 * FNL_SHADING_AUTO: whether some path can. The device may have fewer samples: fnl_device_info.msaa_counts.
 */
FNL_API bool fnl_shading_supports(fnl_shading shading, fnl_light_lists lists, uint32_t msaa);
/** What fnl_shading_likely() finds; bits. */
typedef enum fnl_likely {
    FNL_LIKELY_SHADING = 1, /**< FNL_SHADING_AUTO chooses from paths with this one among them; with MSAA, from those that shade forward alone */
    FNL_LIKELY_LISTS = 2,   /**< FNL_LISTS_AUTO measures these lists with this path */
    FNL_LIKELY_CLOSE = 4    /**< as FNL_LIKELY_SHADING, but only in frames with fnl_frame.choose_close */
} fnl_likely;

/**
 * What `auto` would try of this pair, in a scene with `light_count` point, spot and shaped lights and `msaa` samples per pixel; fnl_likely bits.
 * The first two are set for a few dozen pairs of several hundred. AUTO itself is never likely, nor are lists that do not go with the path.
 */
FNL_API uint32_t fnl_shading_likely(fnl_shading shading, fnl_light_lists lists, uint32_t light_count, uint32_t msaa);

/* ---- G-buffers: deferred, deferred-volumes ---- */

/**
 * Layouts of the G-buffer: Fanal's own, and published ones (docs/techniques/gbuffer.md). All give the same picture within their quantisation:
 * materials that a layout cannot hold are shaded forward in the same frame.
 */
typedef enum fnl_gbuffer {
    FNL_GBUFFER_DEFAULT = 0, /**< 16 bytes per pixel; holds every material */
    FNL_GBUFFER_SIEGE,       /**< 16 bytes: Rainbow Six Siege, with motion and a material id */
    FNL_GBUFFER_KILLZONE2,   /**< 12 bytes: Killzone 2, dielectrics only */
    FNL_GBUFFER_FROSTBITE2,  /**< 12 bytes: Battlefield 3, with a material id */
    FNL_GBUFFER_STALKER,     /**< 20 bytes: S.T.A.L.K.E.R., with a position and a material id */
    FNL_GBUFFER_CLEAR_SKY,   /**< 12 bytes: S.T.A.L.K.E.R. Clear Sky, with a material id */
    FNL_GBUFFER_ENGEL,       /**< 12 bytes: Engel 2009, dielectrics only */
    FNL_GBUFFER_DESTINY,     /**< 8 bytes: Destiny, with a material id; smoothness is the length of the normal */
    FNL_GBUFFER_COUNT
} fnl_gbuffer;

/** Encodings of normals in the G-buffer. docs/techniques/gbuffer.md compares them. */
typedef enum fnl_normal_encoding {
    FNL_NORMALS_LAYOUT = 0, /**< that of the layout */
    FNL_NORMALS_OCTAHEDRAL,
    FNL_NORMALS_XYZ,           /**< three components */
    FNL_NORMALS_XY,            /**< x and y in view space; wrong where a normal points away along the view axis */
    FNL_NORMALS_SPHERICAL,     /**< two angles, one of them as its cosine */
    FNL_NORMALS_SPHERE_MAP,    /**< Lambert azimuthal projection */
    FNL_NORMALS_STEREOGRAPHIC, /**< in view space; wrong where a normal points away by more than 30 degrees */
    FNL_NORMALS_VIEW,          /**< x and y in a frame around each pixel's own view ray; wrong where a normal points away from it */
    FNL_NORMALS_BEST_FIT,      /**< three 8-bit components, scaled to the length with the least error */
    FNL_NORMALS_FLOAT,         /**< 16 bytes in a target of its own: the reference for the others */
    FNL_NORMALS_COUNT
} fnl_normal_encoding;

typedef struct fnl_gbuffer_options {
    /** Default FNL_GBUFFER_DEFAULT. */
    fnl_gbuffer layout;
    /** One that the layout's normal can hold (fnl_gbuffer_info.encodings). Default FNL_NORMALS_LAYOUT. */
    fnl_normal_encoding normals;
    /** Default layout only: base colour as luma and one half of the chroma per pixel, 14 bytes. Default false. */
    bool chroma;
    /** Draws depth first, so that occluded surfaces read no textures; the picture is the same. All paths with a G-buffer except inferred, and
        texturing, virtual-texturing and mobile. Default false. */
    bool prepass;
} fnl_gbuffer_options;

/** A field of a G-buffer layout. Its bits lie in render target `target`; a field that shares its bits with another has 0. */
typedef struct fnl_gbuffer_field {
    const char *name;
    uint32_t target, bits;
} fnl_gbuffer_field;

typedef struct fnl_gbuffer_info {
    uint32_t target_count;
    uint32_t target_bits[5]; /**< per pixel */
    /** Sum of those: what Fanal stores besides depth (32), radiance (64) and, where needed, a mask (8). */
    uint32_t bits;
    uint32_t published_bits;     /**< of the publication, including its depth, stencil and light accumulation */
    uint32_t material_count;     /**< that its ids can tell apart; 0: it has no id */
    fnl_normal_encoding normals; /**< what FNL_NORMALS_LAYOUT means */
    uint32_t encodings;          /**< bit 1 << e: encoding e works with the layout */
    uint32_t field_count;
    const fnl_gbuffer_field *fields;
} fnl_gbuffer_info;

/** Describes a layout. */
FNL_API fnl_result fnl_gbuffer_query_info(fnl_gbuffer layout, fnl_gbuffer_info *out);

/* ---- deferred ---- */

/** What runs the lighting pass. Both give the same bits. */
typedef enum fnl_deferred_pass {
    FNL_DEFERRED_COMPUTE = 0, /**< a dispatch; each thread checks whether its pixel needs light */
    FNL_DEFERRED_FRAGMENT,    /**< a full-screen draw behind a stencil test; compute where the device has no separate stencil format */
    FNL_DEFERRED_PASS_COUNT
} fnl_deferred_pass;

/** Which samples are shaded with MSAA. all .. compact give the same bits. docs/techniques/deferred-msaa.md compares them. */
typedef enum fnl_msaa_method {
    FNL_MSAA_ALL = 0,   /**< every sample */
    FNL_MSAA_TILES,     /**< every sample of 8 x 8 pixel tiles that contain an edge, one per pixel elsewhere */
    FNL_MSAA_STENCIL,   /**< every sample of edge pixels, in a pass of their own */
    FNL_MSAA_COMPACT,   /**< every surface of a pixel once; those beyond the first from a list */
    FNL_MSAA_COVERAGE,  /**< one surface per pixel; the others take the light of a neighbouring pixel: not exact */
    FNL_MSAA_AGGREGATE, /**< similar surfaces of a pixel are merged and shaded by their statistics: not exact */
    FNL_MSAA_METHOD_COUNT
} fnl_msaa_method;

typedef struct fnl_deferred_options {
    /** With class_blocks 0 and 1 sample. Default compute. */
    fnl_deferred_pass pass;
    /** Sorts blocks of 8x8 or 4x4 pixels by the parts of the shader that they need and shades each class with a variant that has nothing else;
        8, 4, or 0 (default): one shader for all. 1 sample. The picture is the same. */
    uint32_t class_blocks;
    /** Default compact. */
    fnl_msaa_method msaa_method;
    /** aggregate: surfaces per pixel at most, 2 or 3. Default 2. */
    uint32_t msaa_groups;
    /** Samples whose colours, parameters and normals (as a chord) differ by no more than this, 0 .. 1, count as one surface, which is shaded as the
        first of them. 0 (default): only equal ones. Not with FNL_MSAA_ALL. */
    float msaa_tolerance;
} fnl_deferred_options;

/* ---- light volumes: deferred-volumes, mobile ---- */

/** The shape drawn for each light. */
typedef enum fnl_volume_shape {
    FNL_VOLUME_SOLIDS = 0,   /**< back faces of a sphere or pyramid, where they are not in front of the surface */
    FNL_VOLUME_QUADS,        /**< the light's rectangle on the screen at its nearest depth, where no surface is nearer */
    FNL_VOLUME_FULLSCREEN,   /**< the whole screen: every pixel tests the light */
    FNL_VOLUME_ELLIPSE,      /**< as quads, with an octagon around the ellipse that the bounding sphere projects to */
    FNL_VOLUME_DEPTH_BOUNDS, /**< as solids, but nothing where the surface lies outside the light's depth range */
    /** As solids, but a stencil rejects pixels whose surface is in front of the volume: light by light, two draws each; lights in view beyond 2048 as
        solids. Depth-bounds where the device has no D32_SFLOAT_S8_UINT. */
    FNL_VOLUME_STENCIL,
    FNL_VOLUME_SHAPE_COUNT
} fnl_volume_shape;

/* ---- light buffers: light-prepass, low-res, inferred ---- */

/** What paths that separate light from materials sum up per pixel. */
typedef enum fnl_light_buffer {
    FNL_LIGHT_BUFFER_AUTO = 0, /**< two; four where light has a lower resolution than materials */
    /** Four channels: diffuse light, and the luminance of highlights. Reflectance does not rise at grazing angles, and highlights take the hue of the
        diffuse light: an approximation. */
    FNL_LIGHT_BUFFER_RGBA,
    FNL_LIGHT_BUFFER_TWO,  /**< six channels: diffuse light and highlights, both including the reflectance of the surface */
    FNL_LIGHT_BUFFER_FOUR, /**< twelve channels: what any material needs, without knowing its reflectance */
    FNL_LIGHT_BUFFER_COUNT
} fnl_light_buffer;

typedef struct fnl_light_buffer_options {
    /** inferred takes `two` as `four`. Default auto. */
    fnl_light_buffer kind;
    /** low-res and inferred: side in pixels of the squares that are lit once, 2 or 4. Default 2. */
    uint32_t scale;
} fnl_light_buffer_options;

/* ---- light-indexed, zioma ---- */

/** How light-indexed stores the lights of a pixel. Pixels with more lights than fit use all lights and count in overflow_cells. */
typedef enum fnl_light_packing {
    FNL_LIGHT_PACKING_IDS = 0, /**< four 16-bit ids per layer, by integer atomics */
    FNL_LIGHT_PACKING_SHIFT,   /**< a layer for each 255 lights in view: four 8-bit ids in RGBA8, by blending that shifts bits */
    FNL_LIGHT_PACKING_MAX,     /**< the same layers: the greatest and the least id by blending, twice */
    FNL_LIGHT_PACKING_COUNT
} fnl_light_packing;

typedef struct fnl_light_indexed_options {
    /** light-indexed. Default ids. */
    fnl_light_packing packing;
    /** light-indexed: layers, 1 .. 16. zioma: lights per pixel, 1 .. 8. Default 4. */
    uint32_t layers;
} fnl_light_indexed_options;

/* ---- visibility ---- */

/** What visibility sorts pixels by, so that each class of materials is shaded by a shader that has only what it needs. */
typedef enum fnl_visibility_sort {
    FNL_VISIBILITY_SORT_OFF = 0,  /**< nothing: one shader for all */
    FNL_VISIBILITY_SORT_CLASS,    /**< what the material needs: light, metal, textures, a normal map */
    FNL_VISIBILITY_SORT_MATERIAL, /**< the same, then the material */
    FNL_VISIBILITY_SORT_COUNT
} fnl_visibility_sort;

typedef struct fnl_visibility_options {
    /** The picture is the same. Default off. */
    fnl_visibility_sort sort;
    /** The id pass stores barycentrics, so that shading fetches no positions; 1 sample. Default false. */
    bool barycentrics;
    /** Draws ids into a target of half the size with four samples, one per pixel of the picture: a quarter of the fragments. Pixels are then sampled a
        quarter of a pixel off their centres. 1 sample, not with barycentrics; no effect where decals redraw surfaces. Default false. */
    bool grid;
} fnl_visibility_options;

/* ---- texturing, virtual-texturing ---- */

/** Where texturing gets the gradients of texture coordinates from. */
typedef enum fnl_gradients {
    FNL_GRADIENTS_STORED = 0, /**< the geometry pass stores them: 8 bytes per pixel, 16 with a second set of coordinates */
    /** From neighbours that lie on the same surface, which stored depth slopes show, 4 bytes per pixel. Approximate: where no neighbour does, the mip
        level is a guess. */
    FNL_GRADIENTS_DERIVED,
    FNL_GRADIENTS_COUNT
} fnl_gradients;

typedef struct fnl_texturing_options {
    /** texturing. Default stored. */
    fnl_gradients gradients;
    /** virtual-texturing: greatest side of the atlas in texels, a multiple of 256, 256 .. 8192. The atlas takes no more than the scene needs, nor more
        than a quarter of the device's memory. Default 8192. */
    uint32_t atlas_size;
} fnl_texturing_options;

/* ---- coarse ---- */

/** What shows that the pixels of a block lie on one surface; normals and materials are compared besides. */
typedef enum fnl_coarse_criterion {
    FNL_COARSE_CRITERION_Z = 0,  /**< view depths differ from the first pixel's by no more than its gradient explains */
    FNL_COARSE_CRITERION_ID,     /**< one triangle of one object; needs fnl_device_info.primitive_ids */
    FNL_COARSE_CRITERION_MINMAX, /**< ranges of depth and normal, by min/max samplers where the device has them; finds no more blocks than z */
    FNL_COARSE_CRITERION_COUNT
} fnl_coarse_criterion;

/** What of the light a block shares; the rest is computed for each pixel. */
typedef enum fnl_coarse_split {
    FNL_COARSE_SPLIT_NONE = 0,   /**< all of it, with a base colour filtered over the block: fnl_coarse_filter */
    FNL_COARSE_SPLIT_ALBEDO,     /**< all of it, before base colours: each pixel has its own */
    FNL_COARSE_SPLIT_HIGHLIGHTS, /**< diffuse and ambient light; each pixel has its own highlights */
    FNL_COARSE_SPLIT_SHARP,      /**< all but lights with visible edges: spots, wedges, boxes and clipped ones light each pixel */
    FNL_COARSE_SPLIT_COUNT
} fnl_coarse_split;

/** Where the base colour of a block comes from. Not with FNL_COARSE_SPLIT_ALBEDO. */
typedef enum fnl_coarse_filter {
    FNL_COARSE_FILTER_MEAN = 0, /**< the mean of its pixels */
    FNL_COARSE_FILTER_SAMPLED,  /**< a target of its own, 4 bytes per pixel: textures sampled at the size of a block */
    FNL_COARSE_FILTER_NONE,     /**< its first pixel, which flickers in motion */
    FNL_COARSE_FILTER_COUNT
} fnl_coarse_filter;

typedef struct fnl_coarse_options {
    /** Side of a block in pixels: 2, 4, or 1: every pixel is shaded, as in deferred. Default 2. */
    uint32_t size;
    /** Default z. */
    fnl_coarse_criterion criterion;
    /** z and minmax: depths may differ by this much of size * sqrt(2) * (|dz/dx| + |dz/dy|), >= 0; on a plane they differ by about
        (size - 1) / (size * sqrt(2)) of that. Default 1. */
    float depth_factor;
    /** Normals may differ by this angle, 0 .. 180 degrees. Default 2. */
    float normal_degrees;
    /** Roughness, metalness, occlusion, F90 and the root of F0 may differ by this, 0 .. 1. Default 0.05. */
    float tolerance;
    /** Linear base colours may differ by this, 0 .. 1. Default 1: by any amount, as they are filtered. */
    float albedo_tolerance;
    /** Default none. */
    fnl_coarse_split split;
    /** Default mean. */
    fnl_coarse_filter filter;
    /** Writes what blocks share in a pass of its own after everything else is shaded; the picture is the same. Default false. */
    bool gather;
    /** Radius of ambient occlusion in metres, >= 0, computed at the same coarse rate. 0 (default): off. */
    float ao_radius;
} fnl_coarse_options;

/* ---- dais ---- */

/** Where dais stores its references to triangles. Both give the same picture. */
typedef enum fnl_dais_mode {
    FNL_DAIS_TARGET = 0, /**< a render target with as many samples as the picture */
    FNL_DAIS_LIST,       /**< a word per pixel, and list elements for triangles that cover only part of it */
    FNL_DAIS_MODE_COUNT
} fnl_dais_mode;

typedef struct fnl_dais_options {
    /** Default target. */
    fnl_dais_mode mode;
    /** Buckets of the triangle cache, two triangles each: a power of two, 1 .. 2^22. Default 65536. */
    uint32_t cache_buckets;
    /** Computes ambient light once for four pixels of a triangle: close, not equal. Default false. */
    bool multirate;
} fnl_dais_options;

/* ---- mobile ---- */

/** What tile memory holds per pixel, and its bits. */
typedef enum fnl_mobile_layout {
    FNL_MOBILE_METALLIC_128 = 0, /**< light, depth, normal and roughness, colour and metalness; dielectrics reflect 4 % */
    FNL_MOBILE_SPECULAR_160,     /**< light, depth, normal and roughness, diffuse colour, specular colour */
    FNL_MOBILE_METALLIC_256,     /**< positions, and everything in floating point */
    FNL_MOBILE_SPECULAR_256,
    FNL_MOBILE_LAYOUT_COUNT
} fnl_mobile_layout;

/** How layouts with 8 bits per channel encode colours. */
typedef enum fnl_mobile_gamma {
    FNL_MOBILE_GAMMA_SRGB = 0, /**< by the hardware */
    FNL_MOBILE_GAMMA_SQRT,     /**< exponent 2, in the shader */
    FNL_MOBILE_GAMMA_POWER,    /**< exponent 2.2, in the shader */
    FNL_MOBILE_GAMMA_COUNT
} fnl_mobile_gamma;

/** The format in which the layouts of 128 and 160 bits sum up light. */
typedef enum fnl_mobile_light {
    FNL_MOBILE_LIGHT_FLOAT = 0, /**< 11, 11 and 10 bits of floating point: nothing clips */
    FNL_MOBILE_LIGHT_UNORM,     /**< 10 bits each, up to `range`; needs a fixed exposure, else float */
    FNL_MOBILE_LIGHT_COUNT
} fnl_mobile_light;

/** How mobile finds the lights of a pixel. Both give the same picture but for the rounding of sums. */
typedef enum fnl_mobile_lights {
    FNL_MOBILE_LIGHTS_LISTS = 0, /**< by fnl_frame.lists */
    /** A volume drawn for each light (fnl_frame.volume_shape), added up in an extra target of 64 or 128 bits. Lists serve only blended surfaces. */
    FNL_MOBILE_LIGHTS_VOLUMES,
    FNL_MOBILE_LIGHTS_COUNT
} fnl_mobile_lights;

typedef struct fnl_mobile_options {
    fnl_mobile_layout layout; /**< default metallic-128 */
    fnl_mobile_gamma gamma;   /**< default srgb */
    fnl_mobile_light light;   /**< default float */
    fnl_mobile_lights lights; /**< default lists */
    /** unorm light: the greatest exposed radiance it can hold, > 0. Default 8. */
    float range;
    /** Runs separate passes, as on devices that cannot merge them. Default false. */
    bool separate;
    /** Layouts of 128 and 160 bits: the picture reuses the memory of the normals, one attachment less. Default false. */
    bool recycle;
} fnl_mobile_options;

/** One attachment of a layout. */
typedef struct fnl_mobile_target {
    const char *name;
    uint32_t bits, used_bits;
} fnl_mobile_target;
/** Fills in at most `capacity` attachments and returns how many there are, with light in 10 bits; 0 for a value out of range. */
FNL_API uint32_t fnl_mobile_layout_targets(fnl_mobile_layout layout, fnl_mobile_target *out, uint32_t capacity);

#ifdef __cplusplus
}
#endif
#endif
