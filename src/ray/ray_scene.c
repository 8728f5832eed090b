/* SPDX-License-Identifier: MIT */
#include "ray/ray_internal.h"

/* ---- what a ray is asked ---- */

struct query {
    embree_query embree; /* first: filters get it */
    enum ray_kind kind;
    const struct ray_neighbours *neighbours; /* or NULL */
    struct ray_walk *walk;
    double visibility;
};

/* Rays are asked for one by one: what filters get has the layout of one. */
static const struct RTCRay *filter_ray(const struct RTCFilterFunctionNArguments *arguments) {
    return (const struct RTCRay *)(const void *)arguments->ray;
}
static const struct RTCHit *filter_hit(const struct RTCFilterFunctionNArguments *arguments) {
    return (const struct RTCHit *)(const void *)arguments->hit;
}

/* A chance in 0..1 that does not depend on the order in which surfaces are found. */
static double chance_of(uint64_t key, uint32_t instance, uint32_t part, uint32_t triangle) {
    struct random_state random = {key ^ (uint64_t)triangle * 0x9e3779b97f4a7c15ull ^
                                  ((uint64_t)instance << 32 | part) * 0xd1b54a32d192ed03ull};
    return (double)random_float(&random);
}

static struct ray_hit hit_of(const struct ray_part *part, const struct RTCRay *ray, const struct RTCHit *hit) {
    return (struct ray_hit){.instance = hit->instID[0],
                            .part = part->index,
                            .triangle = hit->primID,
                            .u = (double)hit->u,
                            .v = (double)hit->v,
                            .distance = (double)ray->tfar,
                            .front = ray->dir_x * hit->Ng_x + ray->dir_y * hit->Ng_y + ray->dir_z * hit->Ng_z < 0};
}

static bool is_on_edge(const struct ray_hit *hit) { return fmin(fmin(hit->u, hit->v), 1 - hit->u - hit->v) < 1e-5; }

/* A ray through the edge that two triangles share meets both, and no crack: for what is passed they count as one. */
static bool is_same_crossing(const struct ray_hit *a, const struct ray_hit *b) {
    return a->part == b->part && a->instance == b->instance && fabs(a->distance - b->distance) <= 1e-5 * a->distance &&
           is_on_edge(a) && is_on_edge(b);
}

void ray_filter_nearest(const struct RTCFilterFunctionNArguments *arguments) {
    const struct ray_part *part = arguments->geometryUserPtr;
    const struct query *query = (const struct query *)(const void *)arguments->context;
    const struct scene_material *m = part->material;
    const struct ray_hit hit = hit_of(part, filter_ray(arguments), filter_hit(arguments)); /* in the space of the instance */
    const bool views = query->kind == RAY_CAMERA || query->kind == RAY_THROUGH;
    if (views && !(part->scene->instances.data[hit.instance].view_mask & ~query->walk->unseen)) { /* the camera does not show it */
        arguments->valid[0] = 0;
        return;
    }
    if (query->kind != RAY_PATH && !hit.front && !m->double_sided) {
        arguments->valid[0] = 0;
        return;
    }
    if (m->alpha_mode == FNL_ALPHA_OPAQUE) return;
    double cover =
        query->kind == RAY_CAMERA && m->alpha_mode == FNL_ALPHA_BLEND
            ? 0
            : ray_coverage(part, &part->scene->instances.data[hit.instance], hit.triangle, hit.u, hit.v, query->neighbours);
    if (m->alpha_mode == FNL_ALPHA_BLEND) {
        struct ray_walk *walk = query->walk;
        if (query->kind == RAY_CAMERA && !array_push(&part->scene->scene->host, &walk->layers, hit)) walk->failed = true;
        if (query->kind != RAY_CAMERA && chance_of(walk->key, hit.instance, hit.part, hit.triangle) < cover) return;
        cover = 0;
    }
    if (cover == 0) arguments->valid[0] = 0;
}

void ray_filter_shadow(const struct RTCFilterFunctionNArguments *arguments) {
    const struct ray_part *part = arguments->geometryUserPtr;
    struct query *query = (struct query *)(void *)arguments->context;
    if (query->kind == RAY_LAMP && !part->material->casts_shadows) {
        arguments->valid[0] = 0;
        return;
    }
    const struct ray_hit hit = hit_of(part, filter_ray(arguments), filter_hit(arguments));
    struct ray_walk *walk = query->walk;
    double cover = ray_coverage(part, NULL, hit.triangle, hit.u, hit.v, NULL);
    if (query->kind == RAY_LAMP) cover *= 1 - ray_transmission(part, hit.triangle, hit.u, hit.v);
    for (uint32_t i = 0; i < walk->crossed.count && cover < 1; i++)
        if (is_same_crossing(&hit, &walk->crossed.data[i])) cover = 0;
    query->visibility *= 1 - cover;
    if (query->visibility == 0) return;
    arguments->valid[0] = 0;
    if (cover > 0 && is_on_edge(&hit) && !array_push(&part->scene->scene->host, &walk->crossed, hit)) walk->failed = true;
}

/* ---- life ---- */

fnl_result ray_scene_create(const fnl_scene *scene, fnl_energy energy, struct jobs *jobs, struct ray_scene **out) {
    struct ray_scene *s = *out = host_allocate_zero(&scene->host, sizeof *s);
    if (!s) return FNL_ERROR_MEMORY;
    s->scene = scene;
    s->standard = scene_material_default();
    s->conserving = energy == FNL_ENERGY_CONSERVING;
    fnl_result result = ray_environment_create(&scene->host, &scene->environment, &s->albedos, &s->environment);
    bool wants_albedos = s->conserving || ray_environment_is(&s->environment);
    for (uint32_t i = 0; i < scene->materials.count; i++) wants_albedos |= scene_material_layered(&scene->materials.data[i]);
    if (wants_albedos) ray_albedos_fill(&s->albedos);
    if (result == FNL_OK) result = ray_scene_build(s, jobs);
    if (result == FNL_OK) result = ray_lights_create(s);
    if (result == FNL_OK) result = ray_emitters_create(s);
    if (result != FNL_OK) ray_scene_destroy(out);
    return result;
}

void ray_scene_destroy(struct ray_scene **handle) {
    struct ray_scene *s = *handle;
    if (!s) return;
    const fnl_host *host = &s->scene->host;
    ray_emitters_destroy(s);
    ray_lights_destroy(s);
    ray_environment_destroy(host, &s->environment);
    if (s->handle) rtcReleaseScene(s->handle);
    for (uint32_t i = 0; i < s->meshes.count; i++) rtcReleaseScene(s->meshes.data[i].handle);
    if (s->device) rtcReleaseDevice(s->device);
    for (uint32_t i = 0; i < s->parts.count; i++) host_free(host, s->parts.data[i].posed, s->parts.data[i].posed_size);
    ray_images_destroy(s->scene, &s->images);
    array_free(host, &s->parts);
    array_free(host, &s->meshes);
    array_free(host, &s->instances);
    host_free(host, s, sizeof *s);
    *handle = NULL;
}

const fnl_host *ray_scene_host(const struct ray_scene *s) { return &s->scene->host; }

void ray_scene_surroundings(const struct ray_scene *s, dvec3 *sky, dvec3 *ground, dvec3 *background) {
    *sky = dvec3_from(s->scene->ambient_sky);
    *ground = dvec3_from(s->scene->ambient_ground);
    *background = dvec3_from(s->scene->background);
}

const struct ray_environment *ray_scene_environment(const struct ray_scene *s) { return &s->environment; }

uint32_t ray_scene_unseen(const struct ray_scene *s) { return s->unseen; }

/* ---- asking ---- */

static struct RTCRay embree_ray(dvec3 origin, dvec3 direction, double low, double high) {
    return (struct RTCRay){.org_x = (float)origin.x,
                           .org_y = (float)origin.y,
                           .org_z = (float)origin.z,
                           .tnear = (float)low,
                           .dir_x = (float)direction.x,
                           .dir_y = (float)direction.y,
                           .dir_z = (float)direction.z,
                           .tfar = high < (double)FLT_MAX ? (float)high : INFINITY,
                           .mask = UINT32_MAX};
}

static int compare_layers(const void *a, const void *b) {
    const struct ray_hit *x = a, *y = b;
    if (x->distance != y->distance) return x->distance < y->distance ? -1 : 1;
    if (x->instance != y->instance) return x->instance < y->instance ? -1 : 1;
    if (x->part != y->part) return x->part < y->part ? -1 : 1;
    return x->triangle < y->triangle ? -1 : x->triangle > y->triangle;
}

bool ray_find(const struct ray_scene *s, enum ray_kind kind, dvec3 origin, dvec3 direction, double low, double high,
              const struct ray_neighbours *neighbours, struct ray_walk *walk, struct ray_hit *hit) {
    struct query query = {.kind = kind, .neighbours = neighbours, .walk = walk};
    struct RTCRayHit ray = {.ray = embree_ray(origin, direction, low, high),
                            .hit = {.geomID = RTC_INVALID_GEOMETRY_ID, .instID = {RTC_INVALID_GEOMETRY_ID}}};
    embree_query_init(&query.embree);
    if (kind == RAY_CAMERA) walk->layers.count = 0;
    walk->ray_count++;
    embree_intersect(s->handle, &query.embree, &ray);
    bool found = ray.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    if (found) {
        const struct ray_instance *in = &s->instances.data[ray.hit.instID[0]];
        dvec3 normal = {(double)ray.hit.Ng_x, (double)ray.hit.Ng_y, (double)ray.hit.Ng_z};
        *hit = (struct ray_hit){
            .instance = ray.hit.instID[0],
            .part = s->meshes.data[in->mesh].first_part + ray.hit.geomID,
            .triangle = ray.hit.primID,
            .u = (double)ray.hit.u,
            .v = (double)ray.hit.v,
            .distance = (double)ray.ray.tfar,
            .front = dvec3_dot(direction, dvec3_combine(in->cofactors[0], in->cofactors[1], in->cofactors[2], normal)) < 0};
    }
    if (kind != RAY_CAMERA) return found;
    if (walk->layers.count > 1) qsort(walk->layers.data, walk->layers.count, sizeof *walk->layers.data, compare_layers);
    uint32_t kept = 0;
    for (uint32_t i = 0; i < walk->layers.count; i++)
        if (kept == 0 || !is_same_crossing(&walk->layers.data[kept - 1], &walk->layers.data[i]))
            walk->layers.data[kept++] = walk->layers.data[i];
    walk->layers.count = kept;
    while (found && walk->layers.count && walk->layers.data[walk->layers.count - 1].distance >= hit->distance)
        walk->layers.count--;
    return found;
}

double ray_visibility(const struct ray_scene *s, enum ray_kind kind, dvec3 origin, dvec3 direction, double distance, struct ray_walk *walk) {
    struct query query = {.kind = kind, .visibility = 1, .walk = walk};
    struct RTCRay ray = embree_ray(origin, direction, 0, distance);
    embree_query_init(&query.embree);
    walk->crossed.count = 0;
    walk->ray_count++;
    embree_occluded(s->handle, &query.embree, &ray);
    return ray.tfar < 0 ? 0 : query.visibility;
}
