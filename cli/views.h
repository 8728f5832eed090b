/* SPDX-License-Identifier: MIT */
/** Cameras by name: those of `fanal render --views` and of --camera. */
#ifndef FNL_CLI_VIEWS_H
#define FNL_CLI_VIEWS_H

#include "fanal/fanal.h"

/** A camera of the scene by its name or index; false after a message that names the option and the cameras that there are. */
bool views_find_camera(const fnl_scene *scene, const char *option, const char *name, fnl_camera *out);
/** "cube". */
bool views_are_cube(const char *text);
/** "cube": six faces around the position of `from`; "all": the cameras of the scene; else their names or indices, with commas. False after a message. */
bool views_choose(const char *text, const fnl_scene *scene, const fnl_camera *from, fnl_camera out[FNL_VIEWS_MAX], uint32_t *out_count);

#endif
