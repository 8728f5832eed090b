/* SPDX-License-Identifier: MIT */
/*
 * The reach of lights without a range. Up to FNL_UNLIMITED_LIGHTS_MAX of them are unlimited: their range is so large that its fade is invisible in the scene.
 * If there are more, each light ends where its illuminance falls below a shared threshold.
 */
#include "scene/light_kinds.h"
#include "scene/scene.h"

static const double FADE_ROOM = 64;     /* unlimited lights: least ratio of the range to the distance of the farthest point; the fade is 2 / 64^4 there */
static const double SHARE = 1.0 / 1024; /* the threshold, as a part of the mean illuminance of all these lights without shadows */
static const double FARTHEST = 0x1p59;  /* the square of a range must be finite */

bool light_is_unlimited(const struct scene_light *light) {
    return scene_light_shines(light) && light_kinds[light->params.kind].info.has_range && isinf(light->params.range);
}

static double candela_of(const fnl_light_params *light) {
    return (double)light->intensity * (double)fmaxf(light->color[0], fmaxf(light->color[1], light->color[2]));
}

/* The least power of two that is not below `distance` times FADE_ROOM, so that small changes of the scene change no light. */
static float beyond(double distance) {
    const double range = exp2(ceil(log2(fmax(distance, 1e-12) * FADE_ROOM)));
    return (float)(range < FARTHEST ? range : FARTHEST);
}

static double farthest_in(const struct box *bounds, vec3 from) {
    if (box_is_empty(bounds)) return 1;
    const double x = fmax(fabs((double)bounds->low.x - (double)from.x), fabs((double)bounds->high.x - (double)from.x));
    const double y = fmax(fabs((double)bounds->low.y - (double)from.y), fabs((double)bounds->high.y - (double)from.y));
    const double z = fmax(fabs((double)bounds->low.z - (double)from.z), fabs((double)bounds->high.z - (double)from.z));
    return sqrt(x * x + y * y + z * z);
}

/*
 * In a sphere of radius r, a light of I cd at the center gives 3 I / r^2 lx on average. The sphere encloses the scene and these lights. The intensity is the
 * geometric mean, so a few very bright lights change it little. Integer sums make the result independent of the order of the list.
 */
static double threshold_of(const fnl_scene *scene, const struct box *bounds) {
    struct box around = *bounds;
    int64_t exponents = 0;
    uint32_t count = 0;
    for (uint32_t i = 0; i < scene->unlimited.count; i++) {
        const fnl_light_params *light = &scene->lights.data[scene->unlimited.data[i]].params;
        const double candela = candela_of(light);
        box_add_point(&around, light->position);
        if (!(candela > 0)) continue;
        exponents += llround(log2(candela) * 65536);
        count++;
    }
    if (count == 0) return 1;
    const double x = (double)around.high.x - (double)around.low.x, y = (double)around.high.y - (double)around.low.y, z = (double)around.high.z - (double)around.low.z;
    const double radius2 = fmax(0.25 * (x * x + y * y + z * z), 1e-24);
    return exp2(floor(log2(SHARE * 3 * count / radius2) + (double)exponents / 65536 / count));
}

double scene_light_threshold(const fnl_scene *scene, const struct box *bounds) {
    if (scene->cutoff_illuminance > 0) return (double)scene->cutoff_illuminance;
    return scene->unlimited.count > FNL_UNLIMITED_LIGHTS_MAX ? threshold_of(scene, bounds) : 0;
}

/* Adds the boxes of nodes that were added or moved since the last update; removed nodes do not shrink the bounds. False: the lists of edits do not reach back so far. */
static bool grow_bounds(fnl_scene *scene, struct scene_reach *reach) {
    if (reach->structure_version < scene->edited_since || reach->transform_version < scene->moved_since) return false;
    for (int list = 0; list < 2; list++) {
        const uint32_t count = list ? scene->moved.count : scene->edited.count, *nodes = list ? scene->moved.data : scene->edited.data;
        for (uint32_t i = 0; i < count; i++) {
            const struct scene_node *node = &scene->nodes.data[nodes[i]];
            const bool known = node->moved_version <= reach->transform_version && node->edited_version <= reach->structure_version;
            if (known || !scene_node_draws(node) || node->staged) continue;
            for (uint32_t k = 0; k < node->instance_count; k++) {
                const mat4 world = scene_instance_world(scene, node, k);
                const struct box box = box_transform(&scene->meshes.data[node->mesh].bounds, &world);
                if (!box_is_empty(&box)) box_add_box(&reach->bounds, &box);
            }
        }
    }
    return true;
}

static float reach_of(const fnl_scene *scene, const fnl_light_params *light, double threshold) {
    const float far = beyond(farthest_in(&scene->reach.bounds, light->position));
    if (scene->cutoff_illuminance > 0) return fnl_light_range(light, scene->cutoff_roughness, scene->cutoff_illuminance);
    return threshold > 0 ? fminf((float)sqrt(candela_of(light) / threshold), far) : far;
}

void scene_follow_reach(fnl_scene *scene) {
    struct scene_reach *reach = &scene->reach;
    const bool stands = reach->structure_version == scene->structure_version && reach->transform_version == scene->transform_version;
    if (scene->unlimited.count == 0) {
        reach->structure_version = UINT64_MAX;
        return;
    }
    if (stands && reach->light_version == scene->light_version) return;
    const bool exact = scene->unlimited.count > FNL_UNLIMITED_LIGHTS_MAX;
    if (exact ? !stands || reach->grown : !stands && (reach->structure_version == UINT64_MAX || !grow_bounds(scene, reach))) {
        reach->bounds = scene_bounds(scene);
        reach->grown = false;
    } else {
        reach->grown |= !stands;
    }
    reach->structure_version = scene->structure_version;
    reach->transform_version = scene->transform_version;
    const double threshold = scene_light_threshold(scene, &reach->bounds);
    for (uint32_t i = 0; i < scene->unlimited.count; i++) {
        const uint32_t index = scene->unlimited.data[i];
        const float now = reach_of(scene, &scene->lights.data[index].params, threshold);
        if (scene->lights.data[index].reach == now) continue;
        scene->lights.data[index].reach = now;
        scene_light_changed(scene, index);
    }
    reach->light_version = scene->light_version;
}
