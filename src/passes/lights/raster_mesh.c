/* SPDX-License-Identifier: MIT */
#include "passes/lights/raster_mesh.h"

#include "passes/lights/light_proxy.h"

/* ---- unit meshes ---- */

static uint32_t pack(uint32_t a, uint32_t b, uint32_t c) { return a | b << 8 | c << 16; }

static void make_cone(vec3 *vertices, uint32_t *triangles) {
    enum { SIDES = GPU_CONE_SIDES, RIM = 1, CAP = RIM + SIDES, POLE = CAP + SIDES };
    vertices[0] = (vec3){0, 0, GPU_CONE_APEX};
    vertices[POLE] = (vec3){0, 0, GPU_CONE_POLE};
    for (uint32_t i = 0; i < SIDES; i++) {
        float angle = (float)i * 6.2831853f / SIDES;
        vertices[RIM + i] = (vec3){cosf(angle), sinf(angle), GPU_CONE_RIM};
        vertices[CAP + i] = (vec3){cosf(angle), sinf(angle), GPU_CONE_CAP};
        uint32_t next = (i + 1) % SIDES;
        triangles[i * 4] = pack(0, RIM + i, RIM + next);
        triangles[i * 4 + 1] = pack(RIM + i, CAP + i, RIM + next);
        triangles[i * 4 + 2] = pack(RIM + next, CAP + i, CAP + next);
        triangles[i * 4 + 3] = pack(POLE, CAP + i, CAP + next);
    }
}

void raster_mesh_tables(vec3 vertices[GPU_CONE_VERTICES], uint32_t triangles[GPU_RASTER_TRIANGLES]) {
    static const uint8_t sides[6][4] = {{0, 1, 3, 2}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 3, 7, 5}};
    make_cone(vertices, triangles);
    triangles += GPU_CONE_TRIANGLES;
    for (uint32_t i = 0; i < 6; i++) {
        triangles[i * 2] = pack(sides[i][0], sides[i][1], sides[i][2]);
        triangles[i * 2 + 1] = pack(sides[i][0], sides[i][2], sides[i][3]);
    }
}

/* As in raster.glsl. */
static vec3 cone_vertex(const struct gpu_shape *shape, vec3 part) {
    float cosine = fminf(fmaxf(-shape->spot_offset / shape->spot_scale - 1e-6f, 0), 1), sine = sqrtf(1 - cosine * cosine);
    float along = part.z == (float)GPU_CONE_APEX ? 0 : part.z == (float)GPU_CONE_RIM ? cosine : 1;
    float across = part.z == (float)GPU_CONE_RIM ? sine : part.z == (float)GPU_CONE_CAP ? sine / (1 + cosine) : 0;
    across *= (float)GPU_CONE_SCALE;
    vec3 up = vec3_cross(shape->side, shape->direction);
    vec3 offset = vec3_scale(shape->direction, along);
    offset = vec3_add_scaled(vec3_add_scaled(offset, shape->side, part.x * across), up, part.y * across);
    return vec3_add_scaled(shape->position, offset, shape->range);
}

uint32_t light_mesh(const struct gpu_shape *shape, const struct gpu_entity_bounds *bounds, vec3 *corners) {
    vec3 tables[GPU_CONE_VERTICES], points[GPU_CONE_VERTICES];
    uint32_t triangles[GPU_RASTER_TRIANGLES], first = 0, count = GPU_CONE_TRIANGLES;
    raster_mesh_tables(tables, triangles);
    if (shape->kind == GPU_SHAPE_CONE) {
        for (uint32_t i = 0; i < GPU_CONE_VERTICES; i++) points[i] = cone_vertex(shape, tables[i]);
    } else {
        shape_corners(shape, bounds, points);
        first = GPU_CONE_TRIANGLES;
        count = GPU_BOX_TRIANGLES;
    }
    for (uint32_t i = 0; i < count * 3; i++) corners[i] = points[triangles[first + i / 3] >> i % 3 * 8 & 255];
    return count;
}

/* ---- meshes for one light ---- */

static void put_quad(vec3 *corners, uint32_t *count, const vec3 *p, uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
    const vec3 quad[6] = {p[a], p[b], p[c], p[a], p[c], p[d]};
    memcpy(corners + *count * 3, quad, sizeof quad);
    *count += 2;
}

uint32_t light_mesh_from_depth(const struct gpu_shape *light, const float *depth, uint32_t size, uint32_t blocks,
                               vec3 *corners) {
    if (light->kind != GPU_SHAPE_CONE) return 0;
    float cosine = -light->spot_offset / light->spot_scale - 1e-6f;
    if (!(cosine > 0.02f) || !blocks || size % blocks) return 0;
    float tangent = sqrtf(fmaxf(1 - cosine * cosine, 0)) / cosine * (1 + 1e-5f);
    uint32_t count = 0, step = size / blocks;
    vec3 up = vec3_cross(light->side, light->direction);
    for (uint32_t by = 0; by < blocks; by++)
        for (uint32_t bx = 0; bx < blocks; bx++) {
            float far = 0;
            for (uint32_t y = by * step; y < (by + 1) * step; y++)
                for (uint32_t x = bx * step; x < (bx + 1) * step; x++) far = fmaxf(far, depth[(size_t)y * size + x]);
            far = fminf(far, light->range) * (1 + 1e-5f);
            if (!(far > 0)) continue;
            float x0 = 2 * (float)bx / (float)blocks - 1, y0 = 1 - 2 * (float)by / (float)blocks, part = 2 / (float)blocks;
            /* Blocks in the corners of the view that the cone does not touch. */
            float nearest_x = fmaxf(fmaxf(x0, -(x0 + part)), 0), nearest_y = fmaxf(fmaxf(y0 - part, -y0), 0);
            if (nearest_x * nearest_x + nearest_y * nearest_y > 1) continue;
            vec3 p[5] = {light->position};
            for (uint32_t i = 0; i < 4; i++) {
                float u = (x0 + (i == 1 || i == 2 ? part : 0)) * tangent, v = (y0 - (i >= 2 ? part : 0)) * tangent;
                vec3 ray = vec3_add_scaled(vec3_add_scaled(light->direction, light->side, u), up, v);
                p[1 + i] = vec3_add_scaled(light->position, ray, far);
            }
            for (uint32_t i = 0; i < 4; i++) {
                const vec3 side[3] = {p[0], p[1 + i], p[1 + (i + 1) % 4]};
                memcpy(corners + count++ * 3, side, sizeof side);
            }
            put_quad(corners, &count, p, 1, 2, 3, 4);
        }
    return count;
}

uint32_t light_mesh_from_planes(vec3 position, const vec4 *planes, uint32_t plane_count, float extent, vec3 *corners) {
    enum { MOST = 4 + 64 };
    uint32_t count = 0;
    if (plane_count > 64) return 0;
    for (uint32_t f = 0; f < plane_count; f++) {
        /* A square on the plane, larger than the hull, cut by all other planes; in double, as faces may be slivers. */
        vec3 normal = {planes[f].x, planes[f].y, planes[f].z}, across = vec3_perpendicular(normal),
             up = vec3_cross(normal, across);
        double polygon[MOST][3], rest[MOST][3];
        uint32_t corner_count = 4;
        for (uint32_t i = 0; i < 4; i++) {
            float u = (i == 1 || i == 2 ? 2 : -2) * extent, v = (i >= 2 ? 2 : -2) * extent;
            vec3 at = vec3_add_scaled(vec3_add_scaled(vec3_scale(normal, planes[f].w), across, u), up, v);
            polygon[i][0] = at.x, polygon[i][1] = at.y, polygon[i][2] = at.z;
        }
        for (uint32_t k = 0; k < plane_count && corner_count; k++) {
            if (k == f) continue;
            uint32_t kept = 0;
            /* A hair wider, so that corners where many planes meet do not vanish. */
            const double n[3] = {planes[k].x, planes[k].y, planes[k].z}, limit = (double)planes[k].w + 1e-6 * (double)extent;
            for (uint32_t i = 0; i < corner_count; i++) {
                const double *a = polygon[i], *b = polygon[(i + 1) % corner_count];
                double da = n[0] * a[0] + n[1] * a[1] + n[2] * a[2] - limit,
                       db = n[0] * b[0] + n[1] * b[1] + n[2] * b[2] - limit;
                if (da <= 0) memcpy(rest[kept++], a, sizeof rest[0]);
                if ((da <= 0) != (db <= 0)) {
                    for (int axis = 0; axis < 3; axis++) rest[kept][axis] = a[axis] + (b[axis] - a[axis]) * (da / (da - db));
                    kept++;
                }
            }
            corner_count = kept;
            memcpy(polygon, rest, kept * sizeof rest[0]);
        }
        for (uint32_t i = 0; i < corner_count; i++)
            for (int axis = 0; axis < 3; axis++)
                if (fabs(polygon[i][axis]) > 1.5 * (double)extent) return 0; /* not closed */
        for (uint32_t i = 2; i < corner_count; i++) {
            const double *triangle[3] = {polygon[0], polygon[i - 1], polygon[i]};
            for (uint32_t c = 0; c < 3; c++)
                corners[count * 3 + c] = (vec3){position.x + (float)triangle[c][0], position.y + (float)triangle[c][1],
                                                position.z + (float)triangle[c][2]};
            count++;
        }
    }
    return count;
}
