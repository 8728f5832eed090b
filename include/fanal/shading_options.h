/* SPDX-License-Identifier: MIT */
/** The settings of shading paths, a struct for each family of them; those of deferred shading are in fanal/gbuffer.h. */
#ifndef FANAL_SHADING_OPTIONS_H
#define FANAL_SHADING_OPTIONS_H

#include "fanal/base.h"

#ifdef __cplusplus
extern "C" {
#endif

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
    /** Six channels; surfaces take 4 bytes: normal and roughness in 7 bits and a sign, and one bit for whether reflectance rises at grazing angles as it does
        for a common dielectric (F0 0.04). An approximation (M. Mikkelsen, "Fine Pruned Tiled Light Lists", GPU Pro 7, 2016). With MSAA, replaced by two. */
    FNL_LIGHT_BUFFER_NARROW,
    FNL_LIGHT_BUFFER_COUNT
} fnl_light_buffer;

typedef struct fnl_light_buffer_options {
    /** Default auto. inferred uses `four` instead of `two` and `narrow`. */
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
    FNL_LIGHT_PACKING_STENCIL, /**< the same layers: four draws with a stencil test; each draw stores the next light in the next channel. Without S8_UINT: max */
    /** Four sets of lights per layer, 255 lights per set. The CPU puts overlapping lights into different sets; a pixel stores one light per set. */
    FNL_LIGHT_PACKING_SETS,
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
    /**
     * Foveation: how far from where the viewer looks (fnl_frame.gaze) each pixel is shaded, 0 .. 180 degrees. Farther out blocks are shaded once, whatever they show:
     * criterion and tolerances are not used. Perspective cameras. 0 (default): off.
     */
    float fovea;
    /** With fovea and size 4: up to this angle, 0 .. 180 degrees, each 2x2 pixels are shaded once, farther out each 4x4. Default 30. */
    float fovea_far;
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
