/* SPDX-License-Identifier: MIT */
/**
 * Eyes: what a headset, or a wall that is looked through, says about a view, and the camera that it makes. A stereo frame has one camera for each eye
 * (fnl_frame.views).
 */
#ifndef FANAL_STEREO_H
#define FANAL_STEREO_H

#include "fanal/camera.h"

#ifdef __cplusplus
extern "C" {
#endif

/** A place and a direction. Without rotation +X is right, +Y up, and -Z ahead. */
typedef struct fnl_rigid_pose {
    fnl_vec3 position; /**< metres */
    fnl_vec4 rotation; /**< unit quaternion x, y, z, w */
} fnl_rigid_pose;

/** One eye, in the space of the head. */
typedef struct fnl_eye {
    fnl_rigid_pose pose;                /**< seen from the head; of two eyes that look straight ahead: half the distance between them along X, no rotation */
    float left, right, down, up; /**< edges of the picture: tangents of their angles to the eye's axis; left < right, down < up. -1, 1, -1, 1: 90 degrees */
} fnl_eye;

/** What the light lists of two eyes are made for. docs/techniques/stereo.md compares them. */
typedef enum fnl_stereo_lists {
    FNL_STEREO_LISTS_EYE = 0, /**< one for each eye */
    FNL_STEREO_LISTS_HEAD,    /**< one for both, over all that either sees: of the kinds clustered, clustered-cpu, bvh, zbin and raster; others as eye */
    FNL_STEREO_LISTS_COUNT
} fnl_stereo_lists;

/**
 * Views of a frame (fnl_frame.views) that are the eyes of one viewer, before one display. They are culled together, by one frustum that holds all of
 * theirs; they share shadow maps, exposure, and the choice of levels of detail, which goes by the middle between them. With an exposure that is given
 * and room for all shadow maps, pictures equal those of each eye alone to the bit.
 */
typedef struct fnl_stereo_options {
    /** Every so many views are the eyes of a display: 2 .. 6, of which view_count is a multiple; 0 (default): views have nothing to do with one another. */
    uint32_t eyes;
    /** Default eye. */
    fnl_stereo_lists lists;
    /** Degrees by which the common frustum is wider on each side, 0 .. 20: heads may turn so far after culling. Default 0. */
    float margin;
} fnl_stereo_options;

/**
 * The camera of an eye for a picture of width x height pixels, 1 .. 16384. `head` is the head's pose in the world. near_distance: metres, > 0. Fails with
 * FNL_ERROR_INVALID where an argument other than `host` is NULL or not as above.
 */
FNL_API fnl_result fnl_eye_query_camera(const fnl_host *host, const fnl_eye *eye, const fnl_rigid_pose *head, uint32_t width, uint32_t height,
                                        float near_distance, fnl_camera *out);

#ifdef __cplusplus
}
#endif
#endif
