/* SPDX-License-Identifier: MIT */
/**
 * Cameras: where a frame is seen from. Those of a scene come from its file or from fnl_scene_add_camera; a frame takes any.
 */
#ifndef FANAL_CAMERA_H
#define FANAL_CAMERA_H

#include "fanal/scene_ids.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct fnl_camera {
    fnl_vec3 position;     /**< metres */
    fnl_vec3 target;       /**< a point that it looks at; must differ from the position */
    fnl_vec3 up;           /**< default 0, 1, 0 */
    bool orthographic;     /**< default false */
    float vertical_fov;    /**< radians, 0 .. pi; default 0.9 */
    float vertical_extent; /**< orthographic: height of the view in metres; default 10 */
    float near_distance;   /**< metres, > 0, or >= 0 if orthographic; default 0.05 */
    float far_distance;    /**< orthographic only, metres, > near_distance; perspective views reach to infinity; default 1000 */
    fnl_vec2 shift;        /**< off-axis projection: shifts the picture, in half widths and half heights; default 0 */
    float pixel_aspect;    /**< width of a pixel by its height, > 0; default 1. Headsets have pixels that are not square */
    /** View mask, 8 bits: the camera shows instances that share a bit with it (fnl_scene_set_instance_view_mask); default 255. The others still cast shadows. */
    uint32_t view_mask;
} fnl_camera;

static inline fnl_camera fnl_camera_default(void) {
    const fnl_camera camera = {{0, 0, 5}, {0, 0, 0}, {0, 1, 0}, false, 0.9f, 10, 0.05f, 1000, {0, 0}, 1, 255};
    return camera;
}
/** Queries a camera by index, in the order of the file. Its pose follows its node. */
FNL_API fnl_result fnl_scene_query_camera(const fnl_scene *scene, uint32_t index, fnl_camera *out);
FNL_API fnl_result fnl_scene_add_camera(fnl_scene *scene, const char *name, const fnl_camera *camera);
/** Removes a camera; later cameras move down by one index. */
FNL_API fnl_result fnl_scene_remove_camera(fnl_scene *scene, uint32_t index);
/**
 * A camera that frames the scene in a picture of the given aspect (width / height), from the front right and slightly
 * above. The triangles, lines and points of all visible instances, in their current pose, fill 80 % of the width or
 * height, whichever they reach first. Unused vertices, meshes of zero size and lights are ignored; in a scene with only
 * lights, the positions of the lights are framed. The field of view is 0.7 radians, or narrower if the camera would
 * come closer than the scene's radius.
 */
FNL_API fnl_result fnl_scene_query_framing_camera(const fnl_scene *scene, float aspect, fnl_camera *out);

#ifdef __cplusplus
}
#endif
#endif
