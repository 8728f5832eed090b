/* SPDX-License-Identifier: MIT */
/**
 * Places are positions in the coordinates of the scene's file, in doubles. Options, camera path files and reports use
 * places; positions in the library are relative to the scene's origin (fnl_scene_set_origin).
 */
#ifndef FNL_CLI_ORIGIN_H
#define FNL_CLI_ORIGIN_H

#include "fanal/scene.h"

#include <jansson.h>

fnl_vec3 origin_position(const fnl_scene *scene, const double place[3]);
void origin_place(const fnl_scene *scene, fnl_vec3 position, double out[3]);
/** [x, y, z] of the place. */
json_t *origin_json(const fnl_scene *scene, fnl_vec3 position);
/** Digits that print a place without loss: 9, as for a float, if the origin is 0, 0, 0; otherwise 17 (a double). */
int origin_digits(const fnl_scene *scene);
/** Moves the origin to this place, rounded to 16 m, if it is over 2048 m away on any axis. False with a message. */
bool origin_follow(fnl_scene *scene, const double place[3]);
/** The same for a camera; converts its position and target to the new origin. */
bool origin_follow_camera(fnl_scene *scene, fnl_camera *camera);

#endif
