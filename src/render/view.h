/* SPDX-License-Identifier: MIT */
/** From a camera to the matrices of a frame. */
#ifndef FNL_RENDER_VIEW_H
#define FNL_RENDER_VIEW_H

#include "base/maths.h"
#include "fanal/scene.h"
#include "view_shared.h"

/**
 * An orthographic camera whose planes are far apart gets planes about the scene: depth has few bits at a millionth of the distance. `deforms`: the scene
 * has vertices that may be out of its bounds.
 */
fnl_camera view_fit_depth(const fnl_camera *camera, const struct box *bounds, bool deforms);
/** Fills in everything that follows from the camera; samples, frame and decals stay zero. The camera was checked with camera_check. */
struct gpu_view view_from_camera(const fnl_camera *camera, uint32_t width, uint32_t height);

/** The same view, relative to an origin that has moved by `moved` (fnl_scene_set_origin). */
struct gpu_view view_with_origin(const struct gpu_view *view, const double moved[3]);
/** View depth of the farthest corner of a box in world space, 1 at least, metres. */
float view_reach(const struct gpu_view *view, const struct box *bounds);

#endif
