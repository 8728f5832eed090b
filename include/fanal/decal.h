/* SPDX-License-Identifier: MIT */
/**
 * Decals: pictures that change the surfaces they lie on. Calls on one scene are not thread-safe.
 */
#ifndef FANAL_DECAL_H
#define FANAL_DECAL_H

#include "fanal/scene_ids.h"

#ifdef __cplusplus
extern "C" {
#endif

/** How a decal finds the surface that it changes. docs/techniques/decals.md says when to use which. */
typedef enum fnl_decal_kind {
    FNL_DECAL_BOX = 0, /**< projected along the box's -Z onto whatever is in the box */
    FNL_DECAL_VOLUME,  /**< a 3D picture, stored as a stack of slices: a surface shows the texel at its position (marble, a cut) */
    FNL_DECAL_MESH,    /**< on one instance, in the space of its undeformed mesh: it stretches and moves with the skin */
    FNL_DECAL_REDRAW,  /**< draws the triangles of one instance that the box touches again, over the instance, and lights them separately */
    FNL_DECAL_BAKED,   /**< painted into copies of one instance's textures when it is added: costs nothing per frame */
    FNL_DECAL_KIND_COUNT
} fnl_decal_kind;

/** How a decal's colour `c` combines with the surface's base colour `b`. The result is mixed with `b` by the decal's alpha. */
typedef enum fnl_decal_blend {
    FNL_DECAL_BLEND_ALPHA = 0, /**< c */
    FNL_DECAL_BLEND_MULTIPLY,  /**< b c */
    FNL_DECAL_BLEND_ADD,       /**< b + c, at most 1 */
    FNL_DECAL_BLEND_SCREEN,    /**< b + c - b c */
    FNL_DECAL_BLEND_OVERLAY,   /**< 2 b c where b < 1/2, else 1 - 2 (1 - b) (1 - c) */
    FNL_DECAL_BLEND_COUNT
} fnl_decal_blend;

/** Which properties of the surface a decal changes; bits. */
typedef enum fnl_decal_channel {
    FNL_DECAL_COLOR = 1,  /**< by itself: a tattoo */
    FNL_DECAL_NORMAL = 2, /**< by itself: an embossing */
    FNL_DECAL_ROUGHNESS = 4,
    FNL_DECAL_METALLIC = 8,
    FNL_DECAL_EMISSION = 16,
    FNL_DECAL_ALL = 31 /**< a sticker */
} fnl_decal_channel;

typedef struct fnl_decal_params {
    fnl_decal_kind kind; /**< default box */
    /**
     * From the unit cube (-1/2 .. 1/2) to the world, or to the space of `instance` if there is one: affine and invertible,
     * may mirror. The picture lies in the cube's xy plane, +Y up, and faces +Z. Default: identity.
     */
    fnl_mat4 transform;
    /** Mesh, redraw and baked decals: the instance that they are on. Box and volume decals: the instance that they move
        with; all-zero (default): none. */
    fnl_instance_id instance;
    float color[4];     /**< linear RGB and alpha, 0..1, multiplied with the picture; default 1 */
    float metallic;     /**< 0..1; default 0 */
    float roughness;    /**< 0..1; default 0.5 */
    float normal_scale; /**< scales the normal map's x and y; default 1 */
    float emissive[3];  /**< cd/m^2, >= 0; default 0 */
    fnl_image_id color_image, normal_image, metallic_roughness_image, emissive_image; /**< all-zero (default): none */
    uint32_t channels;     /**< fnl_decal_channel bits; default colour, roughness and metallic */
    fnl_decal_blend blend; /**< default alpha */
    bool flatten;     /**< the normal map replaces the normal map of the surface instead of adding to it; default false */
    int32_t sort_key; /**< decals are applied by ascending key, those with equal keys in the order they were added; default 0 */
    /**
     * The decal fades by the angle between the surface normal and the box's +Z, radians, 0 .. pi: full strength up to
     * fade_start, nothing from fade_end (>= fade_start) on. Default 65 and 85 degrees, because the picture would smear into
     * streaks on faces seen edge-on. Not for volume decals.
     */
    float fade_start, fade_end;
    /** 8 bits. The decal applies to instances that share a bit with it (fnl_scene_set_instance_receivers); default 255. */
    uint32_t receivers;
    bool distance_field; /**< the picture's alpha is a distance field, with the edge at `cut`; default false */
    float cut;           /**< 0..1; default 0.5 */
    uint32_t slices;     /**< volume decals: number of slices stacked in each image, the topmost at +Z, 1 .. 4096; default 1 */
} fnl_decal_params;

FNL_API fnl_decal_params fnl_decal_params_default(void);
FNL_API fnl_result fnl_scene_add_decal(fnl_scene *scene, const fnl_decal_params *params, fnl_decal_id *out);
/** Cannot change the kind, nor the instance unless it is a box or volume decal. A baked decal is painted again. */
FNL_API fnl_result fnl_scene_set_decal(fnl_scene *scene, fnl_decal_id decal, const fnl_decal_params *params);
FNL_API fnl_result fnl_scene_remove_decal(fnl_scene *scene, fnl_decal_id decal);

/**
 * Adds `count` box decals (graffiti, cracks, footprints, made by the library) at pseudo-random places on the scene's
 * surfaces, or fewer if it finds too few surfaces. The same scene, count and seed give the same decals. An
 * error adds none.
 */
FNL_API fnl_result fnl_scene_scatter_decals(fnl_scene *scene, uint32_t count, uint64_t seed);

#ifdef __cplusplus
}
#endif
#endif
