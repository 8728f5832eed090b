/* SPDX-License-Identifier: MIT */
/** What a frame did at one pixel: the surface, its lights and their shadows, from the frame's own data. docs/techniques/inspect.md shows it. */
#ifndef FANAL_PIXEL_H
#define FANAL_PIXEL_H

#include "fanal/scene_ids.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Asks a frame for a pixel (fnl_frame.pixel). Without it nothing is done; with it a few small passes are. The picture is the same. */
typedef struct fnl_pixel_query {
    bool asked;    /**< default false */
    uint32_t x, y; /**< right and down, inside of the frame */
    uint32_t view; /**< of a frame with several; 0 for frames of one */
} fnl_pixel_query;

/** What found how much of a light is seen. */
typedef enum fnl_pixel_shadow {
    FNL_PIXEL_SHADOW_NONE = 0, /**< nothing: the frame has no shadows, the light casts none, or no page of its map is there */
    FNL_PIXEL_SHADOW_BEHIND,   /**< nothing: its light comes from behind the surface */
    FNL_PIXEL_SHADOW_MAP,      /**< a page of its shadow map */
    FNL_PIXEL_SHADOW_RAYS,     /**< rays */
    FNL_PIXEL_SHADOW_CUBEMAP,  /**< the cube map of a room, and rays for what it does not hold */
    FNL_PIXEL_SHADOW_COUNT
} fnl_pixel_shadow;

enum {
    FNL_PIXEL_LIGHTS = 256,      /**< lights that are told one by one */
    FNL_PIXEL_NONE = 0x7fffffff  /**< no such index */
};

typedef struct fnl_pixel_light {
    fnl_light_id id;     /**< all-zero: it was removed after the frame */
    uint32_t index;      /**< among the lights of the scene, as fnl_scene_query_light() takes it; FNL_PIXEL_NONE: it was removed */
    bool directional;
    bool listed;         /**< the list of the pixel has it; true where there is no list. One that gives nothing on all of a tile may be left out */
    float radiance[3];   /**< that it adds to the pixel, RGB in cd/m^2: after shadows, before exposure */
    float luminance;     /**< of that, cd/m^2 */
    float visibility;    /**< the part of it that its shadow lets through, 0 .. 1; of the colour that it lets through most */
    fnl_pixel_shadow shadow;
    /** Of FNL_PIXEL_SHADOW_MAP. Face of the light's cube, 0 .. 5: +X -X +Y -Y +Z -Z; 0 for directional lights and boxes. */
    uint32_t shadow_face;
    uint32_t shadow_level;    /**< 0 .. 7, the finest first */
    uint32_t shadow_page[2];  /**< column and row among the pages of the level */
    uint32_t shadow_atlas[2]; /**< where the page lies: texels of the atlas, right and down */
} fnl_pixel_light;

typedef struct fnl_pixel_info {
    fnl_pixel_query query;

    /* ---- the surface: the nearest at the pixel's centre that is neither blended nor shows what is behind it ---- */

    bool hit;            /**< false: there is none, and all below is 0 */
    fnl_vec3 position;   /**< world space, metres */
    fnl_vec3 normal;     /**< world space, unit, with normal maps and decals */
    float view_depth;    /**< along the axis of the view, metres */
    float base_color[3]; /**< linear RGB */
    float metallic, roughness;
    float emission[3];   /**< its own glow, cd/m^2 */
    bool unlit;          /**< its material has no light: the base colour glows */

    /* ---- the list in which it looked its lights up ---- */

    /** Whether there is one. Some paths find the lights of opaque surfaces by drawing their volumes: then visited lights are those drawn over the pixel. */
    bool has_list;
    uint32_t cell;          /**< FNL_PIXEL_NONE: lists are not in cells (`all`) */
    uint32_t cell_place[3]; /**< column and row of its tile, and its slice or bin of depth, or half; of grids in the world its place in these */
    bool unserved;          /**< the list of the cell did not fit, or is of other surfaces: a coarser one, or all lights, stood in for it */

    /* ---- its lights ---- */

    uint32_t lights_visited;      /**< that shading looked at for this pixel; without directional lights */
    uint32_t lights_reaching;     /**< whose volume holds the surface, without directional lights: the least that any list could have */
    /** Of these, not in the list, as they give nothing on all of the tile: in shadow (shadow.classify), or behind its surfaces (lists backface, and sparse
        with normal-cones). 0 where there is no list. */
    uint32_t lights_left_out;
    uint32_t lights_contributing; /**< that add light, directional ones too: they are in front of the surface, and something is left by their shadows */
    float lit[3];                 /**< what all lights add, RGB in cd/m^2. With shadows=sampled: the mean over all choices of lights */
    float rest[3];                /**< ambient light and the surface's own. `lit` and `rest` together are the radiance of the surface */

    /** Those that reach the surface and directional ones, the most luminance first: all, or the first FNL_PIXEL_LIGHTS. The renderer's, until the next call on it. */
    const fnl_pixel_light *lights;
    uint32_t light_count;
    uint32_t lights_untold; /**< how many more there are; each adds no more than any of those */
} fnl_pixel_info;

#ifdef __cplusplus
}
#endif
#endif
