/* SPDX-License-Identifier: MIT */
/** G-buffers, and the lighting pass of deferred shading. */
#ifndef FANAL_GBUFFER_H
#define FANAL_GBUFFER_H

#include "fanal/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- G-buffers: deferred, deferred-volumes ---- */

/**
 * Layouts of the G-buffer: Fanal's own, and published ones (docs/techniques/gbuffer.md). All give the same picture within their quantisation:
 * materials that a layout cannot hold are shaded forward in the same frame. Scenes with smooth normals, normal maps or decals add 4 bytes
 * per pixel for the geometric normal.
 */
typedef enum fnl_gbuffer {
    FNL_GBUFFER_DEFAULT = 0, /**< 16 bytes per pixel; holds every material without layers. In scenes with clearcoat or anisotropy that FNL_GBUFFER_LAYERS
                                  holds it is that, unless `normals` is float or `chroma` is on */
    FNL_GBUFFER_SIEGE,       /**< 16 bytes: Rainbow Six Siege, with motion and a material id */
    FNL_GBUFFER_KILLZONE2,   /**< 12 bytes: Killzone 2, dielectrics only */
    FNL_GBUFFER_FROSTBITE2,  /**< 12 bytes: Battlefield 3, with a material id */
    FNL_GBUFFER_STALKER,     /**< 20 bytes: S.T.A.L.K.E.R., with a position and a material id */
    FNL_GBUFFER_CLEAR_SKY,   /**< 12 bytes: S.T.A.L.K.E.R. Clear Sky, with a material id */
    FNL_GBUFFER_ENGEL,       /**< 12 bytes: Engel 2009, dielectrics only */
    FNL_GBUFFER_DESTINY,     /**< 8 bytes: Destiny, with a material id; smoothness is the length of the normal */
    FNL_GBUFFER_LAYERS,      /**< 28 bytes: the default's, with clearcoat and anisotropy */
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

#ifdef __cplusplus
}
#endif
#endif
