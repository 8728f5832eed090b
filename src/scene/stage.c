/* SPDX-License-Identifier: MIT */
/* The stage: what pictures show around a scene that does not have it itself, a studio and a floor. No public call sees it. */
#include "scene/scene.h"

enum { FLOOR_SIDES = 64, FLOOR_RINGS = 12 };
static const float FLOOR_REACH = 3.5f;  /* radii of what stands on it */
static const float FLOOR_SOLID = 0.35f; /* of its own radius, within which it does not fade */

/* What the stage gives a scene. */
static enum stage_light light_for(const fnl_scene *scene) {
    const bool surrounded = (scene->environment.panorama.width > 0 && !scene->environment.staged) || scene_has_ambient(scene);
    const uint32_t count = surrounded ? 0 : scene_entity_count(scene, FNL_ENTITY_LIGHT);
    return surrounded || count > FNL_STUDIO_FILL_LIGHTS ? STAGE_NO_LIGHT : count > 0 ? STAGE_FILL : STAGE_STUDIO;
}

/* Follows the lights when they change. */
static void fill(fnl_scene *scene, bool anew) {
    struct scene_stage *stage = &scene->stage;
    if (anew || stage->bounds_version != scene->structure_version) stage->bounds = scene_bounds(scene);
    else if (stage->light_version == scene->light_version) return;
    stage->bounds_version = scene->structure_version;
    scene_environment_fill(scene, &stage->bounds);
    stage->light_version = scene->light_version;
}

/* ---- the floor ---- */

/* A disk of radius 1 in the plane y = 0, whose vertex colors fade to nothing at its border. */
static fnl_result make_floor(fnl_scene *scene) {
    const uint32_t vertex_count = 1 + FLOOR_SIDES * FLOOR_RINGS, index_count = 3 * FLOOR_SIDES * (2 * FLOOR_RINGS - 1);
    vec3 *positions = arena_allocate(&scene->arena, vertex_count * sizeof *positions), *normals = arena_allocate(&scene->arena, vertex_count * sizeof *normals);
    vec4 *colors = arena_allocate(&scene->arena, vertex_count * sizeof *colors), *tangents = arena_allocate(&scene->arena, vertex_count * sizeof *tangents);
    uint32_t *indices = arena_allocate(&scene->arena, index_count * sizeof *indices), *at = indices;
    if (!positions || !normals || !colors || !tangents || !indices) return FNL_ERROR_MEMORY;
    for (uint32_t i = 0; i < vertex_count; i++) {
        const uint32_t ring = i ? 1 + (i - 1) / FLOOR_SIDES : 0;
        const float radius = (float)ring / FLOOR_RINGS, angle = 2 * PI * (float)(i ? (i - 1) % FLOOR_SIDES : 0) / FLOOR_SIDES;
        const float fade = CLAMP((1 - radius) / (1 - FLOOR_SOLID), 0.0f, 1.0f);
        positions[i] = vec3_make(radius * cosf(angle), 0, radius * sinf(angle));
        normals[i] = vec3_make(0, 1, 0);
        tangents[i] = (vec4){1, 0, 0, 1};
        colors[i] = (vec4){1, 1, 1, fade * fade * (3 - 2 * fade)};
    }
    for (uint32_t ring = 0; ring < FLOOR_RINGS; ring++)
        for (uint32_t side = 0; side < FLOOR_SIDES; side++) {
            const uint32_t next = (side + 1) % FLOOR_SIDES, outer = 1 + ring * FLOOR_SIDES, inner = ring ? outer - FLOOR_SIDES : 0;
            const uint32_t a = ring ? inner + side : 0, b = ring ? inner + next : 0, c = outer + side, d = outer + next;
            *at++ = a, *at++ = d, *at++ = c; /* counterclockwise, seen from above */
            if (ring) *at++ = a, *at++ = b, *at++ = d;
        }
    struct scene_material material = scene_material_default();
    material.name = "ground";
    material.base_color = (vec4){0.2f, 0.2f, 0.2f, 1};
    material.metallic = 0;
    material.roughness = 1;
    material.specular = 0;
    material.alpha_mode = FNL_ALPHA_BLEND;
    material.casts_shadows = false;
    scene->stage.material = scene_add_material(scene, &material);
    if (scene->stage.material == SCENE_NONE) return FNL_ERROR_MEMORY;
    const struct scene_primitive primitive = {.material = scene->stage.material,
                                              .standard_material = scene->stage.material,
                                              .vertex_count = vertex_count,
                                              .index_count = index_count,
                                              .positions = positions,
                                              .normals = normals,
                                              .tangents = tangents,
                                              .colors = colors,
                                              .indices = indices};
    scene->stage.mesh = scene_add_mesh(scene, "ground", &primitive, 1);
    return scene->stage.mesh == SCENE_NONE ? FNL_ERROR_MEMORY : FNL_OK;
}

/* Upward triangles near the lowest point cover most of what the scene covers, seen from above. */
static bool has_floor(const fnl_scene *scene, const struct box *bounds) {
    const float slack = 0.02f * (bounds->high.y - bounds->low.y);
    const double whole = (double)(bounds->high.x - bounds->low.x) * (double)(bounds->high.z - bounds->low.z);
    double covered = 0;
    for (uint32_t n = 0; n < scene->nodes.count; n++) {
        const struct scene_node *node = &scene->nodes.data[n];
        if (!scene_node_draws(node) || node->staged || node->skin != SCENE_NONE) continue;
        const struct scene_mesh *mesh = &scene->meshes.data[node->mesh];
        for (uint32_t k = 0; k < node->instance_count; k++) {
            const mat4 world = scene_instance_world(scene, node, k);
            const struct box box = box_transform(&mesh->bounds, &world);
            if (!(box.low.y <= bounds->low.y + slack)) continue;
            for (uint32_t i = 0; i < mesh->primitive_count; i++) {
                const struct scene_primitive *p = &scene->primitives.data[mesh->first_primitive + i];
                for (uint32_t t = 0; p->topology == SCENE_TOPOLOGY_TRIANGLES && t + 2 < p->index_count; t += 3) {
                    const vec3 a = mat4_point(&world, p->positions[p->indices[t]]), b = mat4_point(&world, p->positions[p->indices[t + 1]]),
                               c = mat4_point(&world, p->positions[p->indices[t + 2]]);
                    if (fmaxf(a.y, fmaxf(b.y, c.y)) > bounds->low.y + slack) continue;
                    const double up = ((double)b.z - (double)a.z) * ((double)c.x - (double)a.x) - ((double)b.x - (double)a.x) * ((double)c.z - (double)a.z);
                    covered += 0.5 * fmax(up, 0);
                }
            }
        }
    }
    return covered >= 0.5 * whole;
}

/* Under what stands in the scene now; later moves leave it where it is. */
static fnl_result place_floor(fnl_scene *scene, const struct box *bounds) {
    struct scene_stage *stage = &scene->stage;
    const vec3 half = vec3_scale(vec3_sub(bounds->high, bounds->low), 0.5f);
    const float radius = FLOOR_REACH * vec3_length(half);
    const vec3 center = vec3_make(bounds->low.x + half.x, bounds->low.y - 1e-3f * vec3_length(half), bounds->low.z + half.z);
    const mat4 place = mat4_from_trs(center, quat_identity(), vec3_make(radius, 1, radius));
    if (stage->mesh == SCENE_NONE) TRY(make_floor(scene));
    if (stage->node == SCENE_NONE) {
        stage->node = scene_add_node(scene, "ground", SCENE_NONE, &place, stage->mesh);
        if (stage->node == SCENE_NONE) return FNL_ERROR_MEMORY;
        struct scene_node *node = &scene->nodes.data[stage->node];
        node->staged = node->removed = true;
        scene->hole_counts[SCENE_NODES]++;
    } else {
        const fnl_instance_id id = {stage->node, scene->nodes.data[stage->node].generation};
        scene_move_nodes(scene, &id, &place, 1);
    }
    scene_show_node(scene, stage->node, true);
    return FNL_OK;
}

static fnl_result show_floor(fnl_scene *scene, fnl_ground ground, bool studio) {
    struct scene_stage *stage = &scene->stage;
    if (ground == FNL_GROUND_OFF || (ground == FNL_GROUND_AUTO && !studio)) {
        if (stage->node != SCENE_NONE) scene_show_node(scene, stage->node, false);
        stage->placed_version = UINT64_MAX;
        return FNL_OK;
    }
    if (stage->placed_version == scene->structure_version && stage->ground == ground) return FNL_OK;
    const struct box bounds = scene_bounds(scene);
    const vec3 size = vec3_sub(bounds.high, bounds.low);
    const bool shows = !box_is_empty(&bounds) && vec3_finite(size) && vec3_length(size) > 0 && vec3_length(size) < 1e18f &&
                       (ground == FNL_GROUND_ON || !has_floor(scene, &bounds));
    if (shows) TRY(place_floor(scene, &bounds));
    else if (stage->node != SCENE_NONE) scene_show_node(scene, stage->node, false);
    stage->ground = ground;
    stage->placed_version = scene->structure_version;
    return FNL_OK;
}

fnl_result scene_set_stage(fnl_scene *scene, bool studio, fnl_ground ground) {
    const enum stage_light light = studio ? light_for(scene) : STAGE_NO_LIGHT;
    const bool anew = scene->environment.staged != (light != STAGE_NO_LIGHT) || scene->stage.light != light;
    if (anew && (light != STAGE_NO_LIGHT || scene->environment.staged)) TRY(scene_environment_stage(scene, light));
    scene->stage.light = light;
    if (light == STAGE_FILL) fill(scene, anew);
    return show_floor(scene, ground, light != STAGE_NO_LIGHT);
}
