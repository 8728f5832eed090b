/* SPDX-License-Identifier: MIT */
/* Which lights may reach a point: boxes around them, in a tree of Embree's. */
#include "ray/ray_internal.h"

enum { FEW = 32 }; /* lights that are asked one by one */

static void bound_light(const struct RTCBoundsFunctionArguments *arguments) {
    const struct ray_scene *s = arguments->geometryUserPtr;
    const struct ray_light *l = &s->lights.data[s->sun_count + arguments->primID];
    double radius = ray_light_radius(l);
    radius += 1e-5 * (radius + dvec3_reach(l->position)); /* floats round */
    *arguments->bounds_o = (struct RTCBounds){.lower_x = (float)fmax(l->position.x - radius, -1e18),
                                              .lower_y = (float)fmax(l->position.y - radius, -1e18),
                                              .lower_z = (float)fmax(l->position.z - radius, -1e18),
                                              .upper_x = (float)fmin(l->position.x + radius, 1e18),
                                              .upper_y = (float)fmin(l->position.y + radius, 1e18),
                                              .upper_z = (float)fmin(l->position.z + radius, 1e18)};
}

static fnl_result make_tree(struct ray_scene *s) {
    s->light_tree = rtcNewScene(s->device);
    RTCGeometry geometry = rtcNewGeometry(s->device, RTC_GEOMETRY_TYPE_USER);
    if (s->light_tree && geometry) {
        rtcSetGeometryUserPrimitiveCount(geometry, s->lights.count - s->sun_count);
        rtcSetGeometryUserData(geometry, s);
        rtcSetGeometryBoundsFunction(geometry, bound_light, NULL);
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(s->light_tree, geometry);
        rtcCommitScene(s->light_tree);
    }
    rtcReleaseGeometry(geometry);
    return ray_scene_check(s);
}

fnl_result ray_lights_create(struct ray_scene *s) {
    const fnl_scene *scene = s->scene;
    for (int suns = 1; suns >= 0; suns--) {
        for (uint32_t i = 0; i < scene->lights.count; i++) {
            const struct scene_light *light = &scene->lights.data[i];
            if (!scene_light_shines(light) || (light->node != SCENE_NONE && !scene->nodes.data[light->node].active)) continue;
            if ((light->params.kind == FNL_LIGHT_DIRECTIONAL) != suns) continue;
            struct ray_light made = ray_light_make(&light->params, (double)light_effective_range(light), light->hull);
            made.profile = scene_light_profile(scene, &light->params);
            if (dvec3_max(made.color) > 0 && !array_push(&scene->host, &s->lights, made)) return FNL_ERROR_MEMORY;
        }
        if (suns) s->sun_count = s->lights.count;
    }
    return s->lights.count - s->sun_count > FEW ? make_tree(s) : FNL_OK;
}

void ray_lights_destroy(struct ray_scene *s) {
    if (s->light_tree) rtcReleaseScene(s->light_tree);
    array_free(&s->scene->host, &s->lights);
}

const struct ray_light *ray_scene_light(const struct ray_scene *s, uint32_t index) { return &s->lights.data[index]; }

struct near_lights {
    const struct ray_scene *scene;
    struct ray_walk *walk;
};

static bool take_light(struct RTCPointQueryFunctionArguments *arguments) {
    struct near_lights *near = arguments->userPtr;
    const uint32_t light = near->scene->sun_count + arguments->primID;
    if (!array_push(&near->scene->scene->host, &near->walk->lights, light)) near->walk->failed = true;
    return false; /* the radius stays */
}

static int compare_indices(const void *a, const void *b) {
    const uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return x < y ? -1 : x > y;
}

void ray_scene_find_lights(const struct ray_scene *s, dvec3 position, struct ray_walk *walk) {
    const uint32_t first = s->light_tree ? s->sun_count : s->lights.count;
    walk->lights.count = 0;
    if (!array_reserve(&s->scene->host, &walk->lights, first)) {
        walk->failed = true;
        return;
    }
    while (walk->lights.count < first) {
        walk->lights.data[walk->lights.count] = walk->lights.count;
        walk->lights.count++;
    }
    if (!s->light_tree) return;
    struct near_lights near = {s, walk};
    struct RTCPointQueryContext context;
    struct RTCPointQuery query = {.x = (float)position.x,
                                  .y = (float)position.y,
                                  .z = (float)position.z,
                                  .radius = (float)ray_rounding(dvec3_reach(position))};
    rtcInitPointQueryContext(&context);
    rtcPointQuery(s->light_tree, &query, &context, take_light, &near);
    if (walk->lights.count > first) /* the order of the tree is no order of light */
        qsort(walk->lights.data + first, walk->lights.count - first, sizeof *walk->lights.data, compare_indices);
}
