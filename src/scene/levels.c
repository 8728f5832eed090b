/* SPDX-License-Identifier: MIT */
/* Levels of detail: nodes, or meshes of a node, of which each picture shows one, by the size on its screen. */
#include "scene/scene.h"

/* ---- size on the screen ---- */

/** The sphere round what the first level shows, in its node's space. */
static void measure(const fnl_scene *scene, struct scene_levels *levels) {
    const uint32_t root = levels->nodes[0];
    struct box bounds = scene_tree_bounds(scene, root, levels->of_mesh);
    mat4 back;
    levels->measured = true;
    levels->radius = 0;
    if (bounds.low.x > bounds.high.x || !mat4_inverse(&scene->nodes.data[root].world, &back)) return;
    const vec3 center = vec3_scale(vec3_add(bounds.low, bounds.high), 0.5f);
    levels->center = mat4_point(&back, center);
    for (int i = 0; i < 8; i++) {
        const vec3 corner = {i & 1 ? bounds.high.x : bounds.low.x, i & 2 ? bounds.high.y : bounds.low.y, i & 4 ? bounds.high.z : bounds.low.z};
        levels->radius = fmaxf(levels->radius, vec3_length(vec3_sub(mat4_point(&back, corner), levels->center)));
    }
}

float scene_levels_coverage(const fnl_scene *scene, const struct scene_levels *levels, const fnl_camera *camera) {
    const mat4 *world = &scene->nodes.data[levels->nodes[0]].world;
    float scale = 0;
    for (int i = 0; i < 3; i++) scale = fmaxf(scale, vec3_length(vec3_make(world->m[i * 4], world->m[i * 4 + 1], world->m[i * 4 + 2])));
    const float radius = levels->radius * scale, distance = vec3_length(vec3_sub(mat4_point(world, levels->center), camera->position));
    if (!(radius > 0)) return 1;
    if (camera->orthographic) return fminf(2 * radius / camera->vertical_extent, 1);
    if (distance <= radius) return 1;
    return fminf(radius / (sqrtf(distance * distance - radius * radius) * tanf(camera->vertical_fov / 2)), 1);
}

/* ---- choosing ---- */

/** Shows one level; `count` of them: none. */
static void show_level(fnl_scene *scene, struct scene_levels *levels, uint32_t shown) {
    for (uint32_t k = 0; k < levels->count; k++) {
        struct scene_node *node = &scene->nodes.data[levels->nodes[k]];
        const bool off = k != shown;
        if (node->removed) continue;
        if (k == 0 && levels->of_mesh) {
            if (node->mesh_off != off) scene_node_edited(scene, levels->nodes[k]);
            node->mesh_off = off;
        } else if (node->unchosen != off) {
            node->unchosen = off;
            scene_activate(scene, levels->nodes[k]);
            scene->decal_version++;
            if (node->linked) scene_show_lights(scene, levels->nodes[k]);
        }
    }
    levels->shown = shown;
}

void scene_choose_levels(fnl_scene *scene, const fnl_camera *camera) {
    for (uint32_t i = 0; i < scene->levels.count; i++) {
        struct scene_levels *levels = &scene->levels.data[i];
        if (!levels->measured) measure(scene, levels);
        const float coverage = scene_levels_coverage(scene, levels, camera);
        uint32_t shown = 0;
        while (shown < levels->count && coverage < levels->coverage[shown]) shown++;
        if (shown != levels->shown) show_level(scene, levels, shown);
    }
}

bool scene_add_levels(fnl_scene *scene, const uint32_t *nodes, const float *coverage, uint32_t count, bool of_mesh) {
    const struct scene_levels levels = {.nodes = arena_copy(&scene->arena, nodes, count * sizeof *nodes),
                                        .coverage = arena_copy(&scene->arena, coverage, count * sizeof *coverage),
                                        .count = count,
                                        .of_mesh = of_mesh};
    if (!levels.nodes || !levels.coverage || !array_push(&scene->host, &scene->levels, levels)) return false;
    for (uint32_t k = 1; k < count; k++) {
        scene->nodes.data[nodes[k]].unchosen = true;
        if (scene->nodes.data[nodes[k]].active) scene_activate(scene, nodes[k]);
    }
    return true;
}
