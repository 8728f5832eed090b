/* SPDX-License-Identifier: MIT */
/** Shading paths: how visible surfaces are shaded. docs/choosing.md compares them. */
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
/** What fnl_shading_likely() knows; bits. */
typedef enum fnl_likely {
    FNL_LIKELY_SHADING = 1, /**< FNL_SHADING_AUTO chooses from paths with this one among them; with MSAA, from those that shade forward alone */
    FNL_LIKELY_LISTS = 2,   /**< FNL_LISTS_AUTO measures these lists with this path */
    FNL_LIKELY_CLOSE = 4,   /**< as FNL_LIKELY_SHADING, but only in frames with fnl_frame.choose_close */
    FNL_LIKELY_BLENDED = 8  /**< the path finds the lights of opaque surfaces by drawing their volumes: lists make a difference to blended ones alone */
} fnl_likely;

/**
 * What `auto` would try of this pair, in a scene with `light_count` point, spot and shaped lights and `msaa` samples per pixel; fnl_likely bits.
 * The first two are set for a few dozen pairs of several hundred. AUTO itself is never likely, nor are lists that do not go with the path.
 * FNL_LIKELY_BLENDED says which measurements are not worth their time: it depends on the path alone.
 */
FNL_API uint32_t fnl_shading_likely(fnl_shading shading, fnl_light_lists lists, uint32_t light_count, uint32_t msaa);

#ifdef __cplusplus
}
#endif
#endif
