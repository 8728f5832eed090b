/* SPDX-License-Identifier: MIT */
/** Checks of poses and eyes that a program passes. */
#ifndef FNL_SCENE_EYE_H
#define FNL_SCENE_EYE_H

#include "base/check.h"
#include "fanal/stereo.h"

/** A finite position and a unit quaternion. */
fnl_result rigid_pose_check(const struct call *call, const char *name, const fnl_rigid_pose *pose);
/** Edges of a picture: they ascend and lie within 1e4. */
fnl_result edges_check(const struct call *call, const char *name, float left, float right, float down, float up);
/** Both, of an argument that is called `eye`. */
fnl_result eye_check(const struct call *call, const fnl_eye *eye);

#endif
