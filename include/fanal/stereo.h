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
