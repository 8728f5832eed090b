/* SPDX-License-Identifier: MIT */
/* The rays of the controllers, as thin bars in the scene. They are made when a controller is first seen. */
#include "xr/xr.h"

static const float half_width = 0.002f, gap = 0.05f; /* metres */

/* White in the picture whatever the exposure. Blended surfaces cast no shadow. */
static fnl_material_params beam_material(float ev) {
    fnl_material_params material = fnl_material_params_default();
    const float white = 1.2f * exp2f(ev);
    material.base_color[0] = material.base_color[1] = material.base_color[2] = 0;
    material.base_color[3] = 0.7f;
    material.metallic = material.specular = 0;
    material.alpha_mode = FNL_ALPHA_BLEND;
    material.emissive[0] = material.emissive[1] = material.emissive[2] = 0.8f * white;
    return material;
}

/* Along -Z; its transform scales the length. */
static bool make_mesh(struct xr *x) {
    static const uint32_t sides[] = {0, 1, 5, 0, 5, 4, 1, 3, 7, 1, 7, 5, 3, 2, 6, 3, 6, 7, 2, 0, 4, 2, 4, 6, 4, 5, 7, 4, 7, 6, 0, 3, 1, 0, 2, 3};
    float corners[24];
    const float half = half_width * x->options->world_scale;
    for (uint32_t i = 0; i < 8; i++) {
        corners[3 * i] = i & 1 ? half : -half;
        corners[3 * i + 1] = i & 2 ? half : -half;
        corners[3 * i + 2] = i & 4 ? 0 : -1;
    }
    const fnl_material_params material = beam_material(x->ev);
    fnl_mesh_params mesh = {.vertex_count = 8, .index_count = sizeof sides / sizeof *sides, .positions = corners, .indices = sides};
    x->beams.ev = x->ev;
    return fnl_scene_add_material(x->scene, &material, &x->beams.material) == FNL_OK && (mesh.material = x->beams.material, true) &&
           fnl_scene_add_mesh(x->scene, &mesh, &x->beams.mesh) == FNL_OK;
}

/* `start`: from where on the ray shows. */
static fnl_mat4 placed(const fnl_rigid_pose *pose, float start, float length) {
    const fnl_vec3 back = quat_turn(pose->rotation, (fnl_vec3){0, 0, 1});
    const fnl_vec3 a = quat_turn(pose->rotation, (fnl_vec3){1, 0, 0}), b = quat_turn(pose->rotation, (fnl_vec3){0, 1, 0}),
                   c = scale3(back, length - start), p = add3(pose->position, scale3(back, -start));
    return (fnl_mat4){{a.x, a.y, a.z, 0, b.x, b.y, b.z, 0, c.x, c.y, c.z, 0, p.x, p.y, p.z, 1}};
}

void xr_show_beams(struct xr *x) {
    struct xr_beams *beams = &x->beams;
    for (uint32_t i = 0; i < XR_HANDS; i++) {
        const struct xr_hand *hand = &x->hands[i];
        const bool shown = hand->active && x->has_input;
        if (shown) {
            const fnl_mat4 transform = placed(&hand->pose, gap * x->options->world_scale, xr_ray_length(x, hand));
            if (!beams->mesh.generation && !make_mesh(x)) return; /* the library has told why; the next frame tries again */
            if (!beams->instances[i].generation) {
                if (fnl_scene_add_instance(x->scene, beams->mesh, &transform, &beams->instances[i]) != FNL_OK) return;
                beams->shown[i] = true;
            }
            (void)fnl_scene_set_instance_transform(x->scene, beams->instances[i], &transform);
        }
        if (shown == beams->shown[i]) continue;
        beams->shown[i] = shown;
        (void)fnl_scene_set_instance_visible(x->scene, beams->instances[i], shown);
    }
    if (!beams->mesh.generation || fabsf(beams->ev - x->ev) < 0.5f) return;
    const fnl_material_params material = beam_material(beams->ev = x->ev);
    (void)fnl_scene_set_material(x->scene, beams->material, &material);
}
