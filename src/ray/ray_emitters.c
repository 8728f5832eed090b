/* SPDX-License-Identifier: MIT */
/* Triangles that glow, chosen by what they send. */
#include "ray/ray_internal.h"

enum { EMITTERS_MAX = 1 << 22 }; /* surfaces beyond are left to paths that meet them */

static double area_of(const dvec3 p[3]) { return dvec3_length(dvec3_cross(dvec3_sub(p[1], p[0]), dvec3_sub(p[2], p[0]))) / 2; }

/* The triangles of a part of an instance; none where all are dark. */
static fnl_result add_part(struct ray_scene *s, uint32_t instance, uint32_t index, uint32_t *first, double *all) {
    const struct ray_part *part = &s->parts.data[index];
    const struct ray_instance *in = &s->instances.data[instance];
    const uint32_t triangles = part->primitive->index_count / 3;
    const double before = *all;
    *first = SCENE_NONE;
    if (!(dvec3_max(dvec3_from(part->material->emissive)) > 0) && !part->material->unlit) return FNL_OK;
    if ((uint64_t)s->emitters.count + triangles > EMITTERS_MAX) return FNL_OK;
    if (!array_reserve(&s->scene->host, &s->emitters, (uint64_t)s->emitters.count + triangles)) return FNL_ERROR_MEMORY;
    *first = s->emitters.count;
    for (uint32_t i = 0; i < triangles; i++) {
        dvec3 corners[3];
        ray_corners(part, in, i, corners);
        const double glow = ray_glow(part, i), power = glow * area_of(corners);
        const bool counts = isfinite(power) && power > 0;
        s->emitters.data[s->emitters.count++] = (struct ray_emitter){instance, index, i, *all += counts ? power : 0, counts ? glow : 0};
    }
    if (*all > before) return FNL_OK;
    s->emitters.count = *first;
    *first = SCENE_NONE;
    return FNL_OK;
}

fnl_result ray_emitters_create(struct ray_scene *s) {
    double all = 0;
    for (uint32_t i = 0; i < s->instances.count; i++) {
        const struct ray_mesh *mesh = &s->meshes.data[s->instances.data[i].mesh];
        const uint32_t begin = s->glows.count, emitters = s->emitters.count;
        for (uint32_t k = 0; k < mesh->part_count; k++) {
            uint32_t first;
            TRY(add_part(s, i, mesh->first_part + k, &first, &all));
            if (!array_push(&s->scene->host, &s->glows, first)) return FNL_ERROR_MEMORY;
        }
        if (s->emitters.count > emitters) s->instances.data[i].first_glow = begin;
        else s->glows.count = begin;
    }
    for (uint32_t i = 0; i < s->emitters.count; i++) {
        s->emitters.data[i].end /= all;
        s->emitters.data[i].density /= all;
    }
    return FNL_OK;
}

void ray_emitters_destroy(struct ray_scene *s) {
    array_free(&s->scene->host, &s->emitters);
    array_free(&s->scene->host, &s->glows);
}

bool ray_emitters_sample(const struct ray_scene *s, const double random[3], struct ray_emitter_point *out) {
    uint32_t index = 0;
    if (!s->emitters.count) return false;
    for (uint32_t high = s->emitters.count - 1; index < high;) { /* the first whose end is above */
        const uint32_t middle = (index + high) / 2;
        if (s->emitters.data[middle].end > random[0]) high = middle;
        else index = middle + 1;
    }
    const struct ray_emitter *e = &s->emitters.data[index];
    const double root = sqrt(random[1]), u = root * (1 - random[2]), v = root * random[2];
    dvec3 p[3];
    ray_corners(&s->parts.data[e->part], &s->instances.data[e->instance], e->triangle, p);
    out->hit = (struct ray_hit){.instance = e->instance, .part = e->part, .triangle = e->triangle, .u = u, .v = v};
    out->position = dvec3_add_scaled(dvec3_add_scaled(dvec3_scale(p[0], 1 - u - v), p[1], u), p[2], v);
    out->geometric = dvec3_normalize(dvec3_scale(dvec3_cross(dvec3_sub(p[1], p[0]), dvec3_sub(p[2], p[0])), s->instances.data[e->instance].mirror));
    out->density = e->density;
    return out->density > 0;
}

double ray_emitters_density(const struct ray_scene *s, const struct ray_hit *hit) {
    const uint32_t glow = s->instances.data[hit->instance].first_glow;
    if (glow == SCENE_NONE) return 0;
    const uint32_t first = s->glows.data[glow + hit->part - s->meshes.data[s->instances.data[hit->instance].mesh].first_part];
    return first == SCENE_NONE ? 0 : s->emitters.data[first + hit->triangle].density;
}
