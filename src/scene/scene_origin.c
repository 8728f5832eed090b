/* SPDX-License-Identifier: MIT */
/*
 * The origin of a scene. Nodes store their transforms in doubles, and entities without a node their positions (`place`
 * in struct scene_light and others). Floats are derived relative to the origin, again whenever the origin moves.
 */
#include "scene/scene.h"

static const double FAR = 2048;  /* meters from 0, 0, 0 beyond which a loaded scene gets an origin */
static const double LARGE = 4; /* a scene gets no origin if half its extent is at least 1 / LARGE of its distance */

/* ---- moving the origin ---- */

static void move_nodes(fnl_scene *scene) {
    const uint64_t version = ++scene->transform_version;
    for (uint32_t i = 0; i < scene->nodes.count; i++) { /* also removed nodes, which may be joints */
        struct scene_node *node = &scene->nodes.data[i];
        node->world = mat4_from_affine(&node->world_exact, scene->origin);
        node->moved_version = version;
    }
    scene->moved.count = 0;
    scene->moved_since = scene->origin_version = version;
    scene_pose_lights(scene, version);
}

/* The planes are still relative to the old origin. */
static void move_hull(struct light_hull *hull, const double by[3], const double origin[3]) {
    hull->center = vec3_from_place(hull->place, origin);
    for (uint32_t i = 0; i < hull->plane_count; i++) {
        double *p = hull->planes[i];
        p[3] += p[0] * by[0] + p[1] * by[1] + p[2] * by[2];
    }
}

static void move_lights(fnl_scene *scene, const double by[3]) {
    for (uint32_t i = 0; i < scene->lights.count; i++) {
        struct scene_light *light = &scene->lights.data[i];
        if (light->removed && !light->staged) continue;
        if (light->node == SCENE_NONE) light->params.position = vec3_from_place(light->place, scene->origin);
        if (light->hull) move_hull(light->hull, by, scene->origin);
    }
    scene_lights_changed(scene);
}

static void move_decals(fnl_scene *scene) {
    for (uint32_t i = 0; i < scene->decals.count; i++) {
        struct scene_decal *decal = &scene->decals.data[i];
        if (decal->removed || decal->node != SCENE_NONE) continue;
        const vec3 at = vec3_from_place(decal->place, scene->origin);
        memcpy(decal->params.transform.m + 12, &at, sizeof at);
    }
    scene->decal_version++;
}

static void move_probes(fnl_scene *scene) {
    for (uint32_t i = 0; i < scene->probes.count; i++)
        scene->probes.data[i].params.centre = vec3_from_place(scene->probes.data[i].place, scene->origin);
    scene->probe_version++;
}

static void move_cameras(fnl_scene *scene) {
    for (uint32_t i = 0; i < scene->cameras.count; i++) {
        struct scene_camera *camera = &scene->cameras.data[i];
        if (camera->node != SCENE_NONE) continue;
        const vec3 ahead = vec3_sub(camera->camera.target, camera->camera.position);
        camera->camera.position = vec3_from_place(camera->place, scene->origin);
        camera->camera.target = vec3_add(camera->camera.position, ahead);
    }
}

static void move_origin(fnl_scene *scene, const double to[3]) {
    double by[3];
    bool moves = false;
    for (int i = 0; i < 3; i++) {
        by[i] = to[i] - scene->origin[i];
        moves |= by[i] != 0;
        scene->origin[i] = to[i];
    }
    if (!moves) return;
    move_nodes(scene);
    move_lights(scene, by);
    move_decals(scene);
    move_probes(scene);
    move_cameras(scene);
    struct box *staged = &scene->stage.bounds;
    if (!box_is_empty(staged)) {
        const vec3 back = vec3_make((float)-by[0], (float)-by[1], (float)-by[2]);
        staged->low = vec3_add(staged->low, back);
        staged->high = vec3_add(staged->high, back);
    }
}

fnl_result fnl_scene_set_origin(fnl_scene *scene, const double origin[3]) {
    static const char *const names[] = {"origin[0]", "origin[1]", "origin[2]"};
    TRY(check_handle(__func__, "scene", scene));
    TRY(check_pointer(CALL(&scene->host), "origin", origin));
    for (int i = 0; i < 3; i++) TRY(check_range(CALL(&scene->host), names[i], origin[i], -FNL_ORIGIN_MAX, FNL_ORIGIN_MAX, " m"));
    move_origin(scene, origin);
    return FNL_OK;
}

fnl_result fnl_scene_query_origin(const fnl_scene *scene, double out[3]) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(check_pointer(CALL(&scene->host), "out", out));
    memcpy(out, scene->origin, sizeof scene->origin);
    return FNL_OK;
}

/* ---- the origin of a file ---- */

struct extent {
    double low[3], high[3];
};

static void add_place(struct extent *e, const double place[3]) {
    for (int i = 0; i < 3; i++) {
        e->low[i] = fmin(e->low[i], place[i]);
        e->high[i] = fmax(e->high[i], place[i]);
    }
}

static void add_corners(struct extent *e, const struct box *box, const struct affine *world) {
    for (int corner = 0; corner < 8; corner++) {
        const double p[3] = {(double)(corner & 1 ? box->high.x : box->low.x), (double)(corner & 2 ? box->high.y : box->low.y),
                             (double)(corner & 4 ? box->high.z : box->low.z)};
        double place[3];
        for (int i = 0; i < 3; i++) place[i] = world->m[i] * p[0] + world->m[3 + i] * p[1] + world->m[6 + i] * p[2] + world->m[9 + i];
        add_place(e, place);
    }
}

/* For a skinned node, the positions of its joints. */
static void add_node(const fnl_scene *scene, const struct scene_node *node, struct extent *e) {
    const struct box *bounds = &scene->meshes.data[node->mesh].bounds;
    if (node->skin != SCENE_NONE) {
        const struct scene_skin *skin = &scene->skins.data[node->skin];
        for (uint32_t i = 0; i < skin->joint_count; i++) add_place(e, scene->nodes.data[skin->joints[i]].world_exact.m + 9);
        return;
    }
    for (uint32_t k = 0; k < node->instance_count && !box_is_empty(bounds); k++) {
        const struct affine world = scene_instance_exact(node, k);
        add_corners(e, bounds, &world);
    }
}

void scene_find_origin(fnl_scene *scene) {
    struct extent e = {{DBL_MAX, DBL_MAX, DBL_MAX}, {-DBL_MAX, -DBL_MAX, -DBL_MAX}};
    for (uint32_t i = 0; i < scene->nodes.count; i++)
        if (scene_node_draws(&scene->nodes.data[i])) add_node(scene, &scene->nodes.data[i], &e);
    if (e.low[0] > e.high[0]) return;
    double origin[3], distance = 0, half = 0;
    for (int i = 0; i < 3; i++) {
        const double middle = (e.low[i] + e.high[i]) / 2;
        origin[i] = round(middle / ORIGIN_STEP) * ORIGIN_STEP;
        distance = fmax(distance, fabs(middle));
        half = fmax(half, (e.high[i] - e.low[i]) / 2);
    }
    if (distance > FAR && distance <= FNL_ORIGIN_MAX && half * LARGE < distance) move_origin(scene, origin);
}
