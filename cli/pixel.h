/* SPDX-License-Identifier: MIT */
/** What a frame says about a pixel, for people and for programs. */
#ifndef FNL_CLI_PIXEL_H
#define FNL_CLI_PIXEL_H

#include "fanal/fanal.h"

#include <jansson.h>
#include <stddef.h>

/** "none", "behind", "map", "rays", "cubemap". */
const char *pixel_shadow_name(fnl_pixel_shadow shadow);
/** The light's name, or "". */
const char *pixel_light_name(const fnl_scene *scene, const fnl_pixel_light *light);
/** Its name, or of one that has none its kind. */
const char *pixel_light_title(const fnl_scene *scene, const fnl_pixel_light *light);
/** Such as "map: face 2, level 3, page 4 5, at 128 256 of the atlas". */
void pixel_describe_shadow(const fnl_pixel_light *light, char *text, size_t capacity);
/** Such as "cell 37: tile 4, 2, slice 9". */
void pixel_describe_cell(const fnl_pixel_info *pixel, char *text, size_t capacity);

void pixel_print(const fnl_scene *scene, const fnl_pixel_info *pixel);
/** By docs/stats.schema.json; null where no pixel was asked for. */
json_t *pixel_json(const fnl_scene *scene, const fnl_pixel_info *pixel);
/** "X,Y" or "X,Y,VIEW". */
bool pixel_parse(const char *option, const char *text, fnl_pixel_query *out);

#endif
