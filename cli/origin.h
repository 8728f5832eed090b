/* SPDX-License-Identifier: MIT */
/**
 * Places far from 0, 0, 0. Options, files of camera paths and reports have places as the scene's file counts them, in doubles; positions of the library are
 * relative to the scene's origin (fnl_scene_set_origin).
 */
#ifndef FNL_CLI_ORIGIN_H
#define FNL_CLI_ORIGIN_H

#include "fanal/scene.h"

fnl_vec3 origin_position(const fnl_scene *scene, const double place[3]);
void origin_place(const fnl_scene *scene, fnl_vec3 position, double out[3]);
/** Digits that a place is printed with so that it reads as the same position: those of a float while the origin is 0, 0, 0. */
int origin_digits(const fnl_scene *scene);
/** Moves the origin, by multiples of 16 m, if it is more than 2048 m from this place on some axis; false with a message. */
bool origin_follow(fnl_scene *scene, const double place[3]);
/** The same for a camera, whose position and target stay where they are. */
bool origin_follow_camera(fnl_scene *scene, fnl_camera *camera);

#endif
