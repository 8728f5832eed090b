/* SPDX-License-Identifier: MIT */
/** The names of enum values, as the command and its files spell them. */
#ifndef FANAL_VALUES_H
#define FANAL_VALUES_H

#include "fanal/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/** The enums whose values have names. */
typedef enum fnl_enum {
    FNL_ENUM_SHADING = 0,      /**< fnl_shading */
    FNL_ENUM_LISTS,            /**< fnl_light_lists */
    FNL_ENUM_TILE_BOUNDS,      /**< fnl_tile_bounds */
    FNL_ENUM_BACKFACE_AXIS,    /**< fnl_backface_axis */
    FNL_ENUM_SLICES,           /**< fnl_slices */
    FNL_ENUM_RASTER_PATH,      /**< fnl_raster_path */
    FNL_ENUM_RASTER_NODES,     /**< fnl_raster_nodes */
    FNL_ENUM_VOLUME_SHAPE,     /**< fnl_volume_shape */
    FNL_ENUM_LIGHT_BUFFER,     /**< fnl_light_buffer */
    FNL_ENUM_LIGHT_PACKING,    /**< fnl_light_packing */
    FNL_ENUM_MSAA_METHOD,      /**< fnl_msaa_method */
    FNL_ENUM_SHADOWS,          /**< fnl_shadows */
    FNL_ENUM_SHADOW_FILTER,    /**< fnl_shadow_filter */
    FNL_ENUM_CUBEMAP_LOD,      /**< fnl_cubemap_lod */
    FNL_ENUM_CUBEMAP_INSIDE,   /**< fnl_cubemap_inside */
    FNL_ENUM_RAY_BACKEND,      /**< fnl_ray_backend */
    FNL_ENUM_TRANSPARENCY,     /**< fnl_transparency */
    FNL_ENUM_DECALS,           /**< fnl_decals */
    FNL_ENUM_CULLING,          /**< fnl_culling */
    FNL_ENUM_GEOMETRY,         /**< fnl_geometry */
    FNL_ENUM_OCCLUSION,        /**< fnl_occlusion */
    FNL_ENUM_MULTIVIEW,        /**< fnl_multiview */
    FNL_ENUM_STEREO_LISTS,     /**< fnl_stereo_lists */
    FNL_ENUM_STEREO_PATH,      /**< fnl_stereo_path */
    FNL_ENUM_ANTIALIASING,     /**< fnl_antialiasing */
    FNL_ENUM_GROUND,           /**< fnl_ground */
    FNL_ENUM_BACKGROUND,       /**< fnl_background */
    FNL_ENUM_ENERGY,           /**< fnl_energy */
    FNL_ENUM_DEFERRED_PASS,    /**< fnl_deferred_pass */
    FNL_ENUM_GBUFFER,          /**< fnl_gbuffer */
    FNL_ENUM_NORMALS,          /**< fnl_normal_encoding */
    FNL_ENUM_GRADIENTS,        /**< fnl_gradients */
    FNL_ENUM_VISIBILITY_SORT,  /**< fnl_visibility_sort */
    FNL_ENUM_COARSE_CRITERION, /**< fnl_coarse_criterion */
    FNL_ENUM_COARSE_SPLIT,     /**< fnl_coarse_split */
    FNL_ENUM_COARSE_FILTER,    /**< fnl_coarse_filter */
    FNL_ENUM_DAIS_MODE,        /**< fnl_dais_mode */
    FNL_ENUM_MOBILE_LAYOUT,    /**< fnl_mobile_layout */
    FNL_ENUM_MOBILE_GAMMA,     /**< fnl_mobile_gamma */
    FNL_ENUM_MOBILE_LIGHT,     /**< fnl_mobile_light */
    FNL_ENUM_MOBILE_LIGHTS,    /**< fnl_mobile_lights */
    FNL_ENUM_TONEMAP,          /**< fnl_tonemap */
    FNL_ENUM_EXPOSURE,         /**< fnl_exposure */
    FNL_ENUM_DEBUG_VIEW,       /**< fnl_debug_view */
    FNL_ENUM_LIGHT_KIND,       /**< fnl_light_kind */
    FNL_ENUM_SHADOW_UPDATE,    /**< fnl_shadow_update */
    FNL_ENUM_DECAL_KIND,       /**< fnl_decal_kind */
    FNL_ENUM_DECAL_BLEND,      /**< fnl_decal_blend */
    FNL_ENUM_DEVICE_TYPE,      /**< fnl_device_type */
    FNL_ENUM_QUEUE,            /**< fnl_queue */
    FNL_ENUM_PASS_ROLE,        /**< fnl_pass_role */
    FNL_ENUM_COUNT
} fnl_enum;

/** The name of a value, such as "forward-prepass" for FNL_SHADING_FORWARD_PREPASS; NULL where there is none. */
FNL_API const char *fnl_value_name(fnl_enum type, uint32_t value);
/** One line that says what a value is; NULL for values that only the headers and pages describe. Today debug views have one. */
FNL_API const char *fnl_value_help(fnl_enum type, uint32_t value);
/** The value with a name; false if there is none. `out` may be NULL. "all" and "brute-force" name FNL_LISTS_ALL. */
FNL_API bool fnl_value_find(fnl_enum type, const char *name, uint32_t *out);

#ifdef __cplusplus
}
#endif
#endif
