/* SPDX-License-Identifier: MIT */
/* Shifts the positions that the window stores when the scene's origin follows the camera (origin.h). */
#include "origin.h"
#include "view/view.h"
#include "view/view_maths.h"

static void shift_camera(fnl_camera *camera, fnl_vec3 by) {
    camera->position = maths_add(camera->position, by, 1);
    camera->target = maths_add(camera->target, by, 1);
}

static void shift_matrix(fnl_mat4 *matrix, fnl_vec3 by) {
    matrix->m[12] += by.x;
    matrix->m[13] += by.y;
    matrix->m[14] += by.z;
}

static bool is_root(const struct view *v, struct view_id id) {
    uint32_t index;
    fnl_instance_info info;
    return view_find(v, FNL_ENTITY_INSTANCE, id, &index) && fnl_scene_query_instance(v->shown.scene, index, &info) == FNL_OK && info.parent.generation == 0;
}

static void shift_edit(const struct view *v, struct view_edit *e, fnl_vec3 by) {
    union view_value *values[] = {&e->before, &e->after};
    for (int i = 0; i < 2; i++) {
        union view_value *value = values[i];
        if (e->kind == VIEW_EDIT_LIGHT || e->kind == VIEW_EDIT_LIGHT_THERE) value->light.position = maths_add(value->light.position, by, 1);
        if ((e->kind == VIEW_EDIT_DECAL || e->kind == VIEW_EDIT_DECAL_THERE) && value->decal.instance.generation == 0) shift_matrix(&value->decal.transform, by);
        if (e->kind == VIEW_EDIT_TRANSFORM && is_root(v, e->id)) shift_matrix(&value->transform, by);
    }
}

void view_follow_origin(struct view *v) {
    const fnl_camera before = v->camera.now;
    if (!v->shown.scene || v->select.gizmo.held >= 0 || !origin_follow_camera(v->shown.scene, &v->camera.now)) return;
    const fnl_vec3 by = maths_add(v->camera.now.position, before.position, -1);
    if (by.x == 0 && by.y == 0 && by.z == 0) return;
    shift_camera(&v->shown.camera, by);
    shift_camera(&v->framed, by);
    for (uint32_t i = 0; i < v->select.edits.count; i++) shift_edit(v, &v->select.edits.list[i], by);
    v->select.stamp++; /* the lights' positions have changed */
}
