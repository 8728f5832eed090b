/* SPDX-License-Identifier: MIT */
#include "origin.h"

#include <math.h>
#include <string.h>

static const double STEP = 16, FARTHEST = 2048; /* meters */

fnl_vec3 origin_position(const fnl_scene *scene, const double place[3]) {
    double origin[3] = {0, 0, 0};
    (void)fnl_scene_query_origin(scene, origin);
    return (fnl_vec3){(float)(place[0] - origin[0]), (float)(place[1] - origin[1]), (float)(place[2] - origin[2])};
}

void origin_place(const fnl_scene *scene, fnl_vec3 position, double out[3]) {
    double origin[3] = {0, 0, 0};
    (void)fnl_scene_query_origin(scene, origin);
    out[0] = origin[0] + (double)position.x;
    out[1] = origin[1] + (double)position.y;
    out[2] = origin[2] + (double)position.z;
}

json_t *origin_json(const fnl_scene *scene, fnl_vec3 position) {
    double place[3];
    origin_place(scene, position, place);
    return json_pack("[f,f,f]", place[0], place[1], place[2]);
}

int origin_digits(const fnl_scene *scene) {
    double origin[3] = {0, 0, 0};
    (void)fnl_scene_query_origin(scene, origin);
    return origin[0] == 0 && origin[1] == 0 && origin[2] == 0 ? 9 : 17;
}

bool origin_follow(fnl_scene *scene, const double place[3]) {
    double origin[3];
    bool is_far = false;
    if (fnl_scene_query_origin(scene, origin) != FNL_OK) return false;
    for (int i = 0; i < 3; i++) is_far |= fabs(place[i] - origin[i]) > FARTHEST;
    for (int i = 0; i < 3; i++) origin[i] = fmin(fmax(round(place[i] / STEP) * STEP, -FNL_ORIGIN_MAX), FNL_ORIGIN_MAX);
    return !is_far || fnl_scene_set_origin(scene, origin) == FNL_OK;
}

bool origin_follow_camera(fnl_scene *scene, fnl_camera *camera) {
    double position[3], target[3], before[3], after[3];
    origin_place(scene, camera->position, position);
    origin_place(scene, camera->target, target);
    if (fnl_scene_query_origin(scene, before) != FNL_OK || !origin_follow(scene, position) || fnl_scene_query_origin(scene, after) != FNL_OK) return false;
    if (memcmp(before, after, sizeof before) == 0) return true; /* floats keep their last bits */
    camera->position = origin_position(scene, position);
    camera->target = origin_position(scene, target);
    return true;
}
