/* SPDX-License-Identifier: MIT */
/*
 * Convex hulls that bound lights. Of few points every triple is tried: it makes a face where no point lies beyond its plane. That is
 * slow beside incremental hulls and cannot go wrong: points are floats, planes doubles, and a plane that is left out (of a sliver, or
 * nearly in another face) only leaves the hull a hair too large.
 */
#include "scene/scene.h"

/* All relative to the extent of the points. */
#define SUPPORT_TOLERANCE 1e-9 /* how far a point may lie beyond a face's plane */
#define MERGE_TOLERANCE 1e-6   /* faces whose corners are this near to a plane are part of it */
#define LEAST_THICKNESS 1e-5   /* flatter points have no hull */

static void subtract(const double a[3], const double b[3], double out[3]) {
    for (int i = 0; i < 3; i++) out[i] = a[i] - b[i];
}
static double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
static void cross(const double a[3], const double b[3], double out[3]) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

struct cloud {
    double p[LIGHT_HULL_POINTS_MAX][3]; /* relative to the first point */
    uint32_t count;
    double extent;
};

/* Unit normal of a triple's plane and twice its area; 0 for points on a line. */
static double plane_of(const struct cloud *c, const uint32_t corners[3], double normal[3]) {
    double u[3], v[3];
    subtract(c->p[corners[1]], c->p[corners[0]], u);
    subtract(c->p[corners[2]], c->p[corners[0]], v);
    cross(u, v, normal);
    double area = sqrt(dot(normal, normal));
    if (!(area > 1e-12 * c->extent * c->extent)) return 0;
    for (int i = 0; i < 3; i++) normal[i] /= area;
    return area;
}

/* What is wrong with the points, or NULL. */
static const char *flatness(const struct cloud *c) {
    uint32_t far = 0;
    double best = 0, line[3] = {0}, normal[3] = {0}, thickness = 0;
    for (uint32_t i = 1; i < c->count; i++)
        if (dot(c->p[i], c->p[i]) > best) {
            best = dot(c->p[i], c->p[i]);
            far = i;
        }
    if (!(best > 0)) return "are all in one place";
    for (int k = 0; k < 3; k++) line[k] = c->p[far][k] / sqrt(best);
    best = 0;
    for (uint32_t i = 1; i < c->count; i++) {
        double n[3];
        cross(line, c->p[i], n);
        if (dot(n, n) > best) {
            best = dot(n, n);
            memcpy(normal, n, sizeof n);
        }
    }
    if (!(sqrt(best) > LEAST_THICKNESS * c->extent)) return "lie on one line";
    double low = 0, high = 0;
    for (uint32_t i = 1; i < c->count; i++) {
        double d = dot(normal, c->p[i]) / sqrt(best);
        low = fmin(low, d);
        high = fmax(high, d);
    }
    thickness = high - low;
    return thickness > LEAST_THICKNESS * c->extent ? NULL : "lie in one plane";
}

struct face {
    double area, normal[3], offset; /* the points have dot(normal, p) <= offset */
    uint32_t corners[3];
};

static int compare_faces(const void *a, const void *b) {
    const struct face *x = a, *y = b;
    if (x->area != y->area) return x->area < y->area ? 1 : -1;
    return memcmp(x->corners, y->corners, sizeof x->corners);
}

/* Whether the triple is part of the surface; turns the normal outward. */
static bool make_face(const struct cloud *c, struct face *face) {
    face->area = plane_of(c, face->corners, face->normal);
    if (face->area == 0) return false;
    double at = dot(face->normal, c->p[face->corners[0]]), low = at, high = at;
    for (uint32_t i = 0; i < c->count; i++) {
        double d = dot(face->normal, c->p[i]);
        low = fmin(low, d);
        high = fmax(high, d);
        if (high - at > SUPPORT_TOLERANCE * c->extent && at - low > SUPPORT_TOLERANCE * c->extent) return false;
    }
    face->offset = high;
    if (high - at > SUPPORT_TOLERANCE * c->extent) {
        for (int i = 0; i < 3; i++) face->normal[i] = -face->normal[i];
        face->offset = -low;
    }
    return true;
}

static bool lies_in(const struct cloud *c, const struct face *face, const struct face *plane) {
    for (int i = 0; i < 3; i++)
        if (plane->offset - dot(plane->normal, c->p[face->corners[i]]) > MERGE_TOLERANCE * c->extent) return false;
    return dot(face->normal, plane->normal) > 0;
}

/* Collects the planes, the largest faces first. `faces` has room for all triples. */
static void collect(const struct cloud *c, const vec3 *origin, struct face *faces, struct light_hull *hull) {
    uint32_t count = 0, kept = 0;
    for (uint32_t i = 0; i < c->count; i++)
        for (uint32_t j = i + 1; j < c->count; j++)
            for (uint32_t k = j + 1; k < c->count; k++) {
                struct face face = {.corners = {i, j, k}};
                if (make_face(c, &face)) faces[count++] = face;
            }
    qsort(faces, count, sizeof *faces, compare_faces);
    for (uint32_t f = 0; f < count && kept < LIGHT_HULL_PLANES_MAX; f++) {
        bool is_new = true;
        for (uint32_t k = 0; k < kept && is_new; k++) is_new = !lies_in(c, &faces[f], &faces[k]);
        if (is_new) faces[kept++] = faces[f];
    }
    hull->plane_count = kept;
    const double at[3] = {origin->x, origin->y, origin->z};
    for (uint32_t k = 0; k < kept; k++) {
        memcpy(hull->planes[k], faces[k].normal, sizeof faces[k].normal);
        hull->planes[k][3] = -(faces[k].offset + dot(faces[k].normal, at));
    }
}

/* A small sphere round the points: steps towards the farthest point, each shorter (Badoiu & Clarkson 2003). */
static void enclose(const vec3 *points, uint32_t count, struct light_hull *hull) {
    struct box box = box_empty();
    for (uint32_t i = 0; i < count; i++) box_add_point(&box, points[i]);
    vec3 center = vec3_lerp(box.low, box.high, 0.5f);
    hull->radius = INFINITY;
    for (uint32_t step = 2; step < 200; step++) {
        uint32_t far = 0;
        for (uint32_t i = 1; i < count; i++)
            if (vec3_distance(points[i], center) > vec3_distance(points[far], center)) far = i;
        float radius = vec3_distance(points[far], center) * (1 + 1e-6f);
        if (radius < hull->radius) {
            hull->radius = radius;
            hull->center = center;
        }
        center = vec3_lerp(center, points[far], 1.0f / (float)step);
    }
}

fnl_result light_hull_create(const fnl_host *host, const vec3 *points, uint32_t count, struct light_hull **out) {
    *out = NULL;
    struct cloud cloud = {.count = count};
    struct box box = box_empty();
    for (uint32_t i = 0; i < count; i++) {
        cloud.p[i][0] = (double)points[i].x - (double)points[0].x;
        cloud.p[i][1] = (double)points[i].y - (double)points[0].y;
        cloud.p[i][2] = (double)points[i].z - (double)points[0].z;
        box_add_point(&box, points[i]);
    }
    cloud.extent = fmax((double)box.high.x - (double)box.low.x,
                        fmax((double)box.high.y - (double)box.low.y, (double)box.high.z - (double)box.low.z));
    const char *problem = flatness(&cloud);
    if (problem) {
        log_error(host, "fnl_scene_set_light_hull: the %u points %s; a hull needs a volume", count, problem);
        return FNL_ERROR_INVALID;
    }
    uint64_t triples = (uint64_t)count * (count - 1) * (count - 2) / 6;
    struct face *faces = host_allocate(host, triples * sizeof *faces);
    struct light_hull *hull = host_allocate_zero(host, sizeof *hull);
    if (faces && hull) {
        collect(&cloud, &points[0], faces, hull);
        enclose(points, count, hull);
        *out = hull;
    } else {
        host_free(host, hull, sizeof *hull);
    }
    host_free(host, faces, triples * sizeof *faces);
    return *out ? FNL_OK : FNL_ERROR_MEMORY;
}

void light_hull_free(fnl_scene *scene, struct scene_light *light) {
    if (!light->hull) return;
    scene->hull_plane_count -= light->hull->plane_count;
    host_free(&scene->host, light->hull, sizeof *light->hull);
    light->hull = NULL;
}
