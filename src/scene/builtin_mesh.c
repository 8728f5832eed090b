/* SPDX-License-Identifier: MIT */
#include "scene/builtin_mesh.h"

/** cos of the angle up to which neighbouring faces of a profile are shaded as one. */
#define SMOOTH_COSINE 0.766f

void mesh_begin(struct mesh_builder *m, struct builtin *b) {
    *m = (struct mesh_builder){.builtin = b, .transform = mat4_identity()};
}

void mesh_material(struct mesh_builder *m, uint32_t material) {
    for (m->part = 0; m->part < m->part_count; m->part++)
        if (m->parts[m->part].material == material) return;
    if (m->part_count == COUNT_OF(m->parts)) {
        log_error(&m->builtin->scene->host, "%s: a mesh has more than %u materials", m->builtin->scene->source,
                  m->part_count);
        m->builtin->failed = true;
        m->part = 0;
        return;
    }
    m->parts[m->part_count++] = (struct mesh_part){.material = material};
}

/** Copies a part into the scene's memory. */
static struct scene_primitive part_primitive(struct builtin *b, const struct mesh_part *part) {
    struct arena *arena = &b->scene->arena;
    struct scene_primitive p = {
        .material = part->material,
        .vertex_count = part->positions.count,
        .index_count = part->indices.count,
        .positions = arena_copy(arena, part->positions.data, sizeof(vec3) * part->positions.count),
        .normals = arena_copy(arena, part->normals.data, sizeof(vec3) * part->normals.count),
        .uv = {arena_copy(arena, part->uv.data, sizeof(vec2) * part->uv.count)},
        .indices = arena_copy(arena, part->indices.data, sizeof(uint32_t) * part->indices.count),
    };
    if (!p.positions || !p.normals || !p.uv[0] || !p.indices || mesh_complete(arena, &p) != FNL_OK) b->failed = true;
    return p;
}

uint32_t mesh_end(struct mesh_builder *m, const char *name) {
    struct builtin *b = m->builtin;
    const fnl_host *host = &b->scene->host;
    struct scene_primitive primitives[COUNT_OF(m->parts)];
    uint32_t count = 0, mesh = 0;
    for (uint32_t i = 0; i < m->part_count && !b->failed; i++)
        if (m->parts[i].indices.count) primitives[count++] = part_primitive(b, &m->parts[i]);
    if (!b->failed && count) mesh = scene_add_mesh(b->scene, name, primitives, count);
    if (mesh == SCENE_NONE) {
        b->failed = true;
        mesh = 0;
    }
    for (uint32_t i = 0; i < m->part_count; i++) {
        struct mesh_part *part = &m->parts[i];
        array_free(host, &part->positions);
        array_free(host, &part->normals);
        array_free(host, &part->uv);
        array_free(host, &part->indices);
    }
    mesh_begin(m, b);
    return mesh;
}

/** A normal goes through the inverse transpose: the cofactors, whose sign keeps it outward when the matrix mirrors. */
static vec3 transform_normal(const mat4 *matrix, vec3 n) {
    const float *m = matrix->m;
    vec3 x = {m[0], m[1], m[2]}, y = {m[4], m[5], m[6]}, z = {m[8], m[9], m[10]};
    vec3 r = vec3_add(vec3_add(vec3_scale(vec3_cross(y, z), n.x), vec3_scale(vec3_cross(z, x), n.y)),
                      vec3_scale(vec3_cross(x, y), n.z));
    return vec3_normalize(mat4_determinant3(matrix) < 0 ? vec3_scale(r, -1) : r);
}

uint32_t mesh_vertex(struct mesh_builder *m, vec3 position, vec3 normal, vec2 uv) {
    struct builtin *b = m->builtin;
    const fnl_host *host = &b->scene->host;
    if (b->failed) return 0;
    struct mesh_part *part = &m->parts[m->part];
    if (!array_push(host, &part->positions, mat4_point(&m->transform, position)) ||
        !array_push(host, &part->normals, transform_normal(&m->transform, normal)) || !array_push(host, &part->uv, uv))
        b->failed = true;
    return b->failed ? 0 : part->positions.count - 1;
}

void mesh_triangle(struct mesh_builder *m, uint32_t a, uint32_t b, uint32_t c) {
    if (m->builtin->failed) return;
    struct mesh_part *part = &m->parts[m->part];
    bool mirrored = mat4_determinant3(&m->transform) < 0;
    uint32_t corners[3] = {a, mirrored ? c : b, mirrored ? b : c};
    for (int i = 0; i < 3; i++)
        if (!array_push(&m->builtin->scene->host, &part->indices, corners[i])) m->builtin->failed = true;
}

static void quad_indices(struct mesh_builder *m, uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
    mesh_triangle(m, a, b, c);
    mesh_triangle(m, a, c, d);
}

void mesh_quad_uv(struct mesh_builder *m, vec3 p, vec3 u, vec3 v, vec2 uv_low, vec2 uv_high) {
    vec3 n = vec3_normalize(vec3_cross(u, v));
    uint32_t a = mesh_vertex(m, p, n, uv_low);
    uint32_t b = mesh_vertex(m, vec3_add(p, u), n, vec2_make(uv_high.x, uv_low.y));
    uint32_t c = mesh_vertex(m, vec3_add(vec3_add(p, u), v), n, uv_high);
    uint32_t d = mesh_vertex(m, vec3_add(p, v), n, vec2_make(uv_low.x, uv_high.y));
    quad_indices(m, a, b, c, d);
}

void mesh_quad(struct mesh_builder *m, vec3 p, vec3 u, vec3 v) {
    mesh_quad_uv(m, p, u, v, vec2_make(0, vec3_length(v)), vec2_make(vec3_length(u), 0));
}

void mesh_box(struct mesh_builder *m, vec3 a, vec3 b, unsigned faces) {
    vec3 s = vec3_sub(b, a), x = {s.x, 0, 0}, y = {0, s.y, 0}, z = {0, 0, s.z}, back_x = {-s.x, 0, 0}, back_z = {0, 0, -s.z};
    if (faces & FACE_LEFT) mesh_quad(m, a, z, y);
    if (faces & FACE_RIGHT) mesh_quad(m, vec3_make(b.x, a.y, b.z), back_z, y);
    if (faces & FACE_BOTTOM) mesh_quad(m, a, x, z);
    if (faces & FACE_TOP) mesh_quad(m, vec3_make(a.x, b.y, b.z), x, back_z);
    if (faces & FACE_BACK) mesh_quad(m, vec3_make(b.x, a.y, a.z), back_x, y);
    if (faces & FACE_FRONT) mesh_quad(m, vec3_make(a.x, a.y, b.z), x, y);
}

/** One flat polygon of 3 or 4 corners; uvs by projection along the normal's greatest axis. */
static void flat_polygon(struct mesh_builder *m, const vec3 *p, uint32_t count) {
    vec3 n = vec3_normalize(vec3_cross(vec3_sub(p[1], p[0]), vec3_sub(p[2], p[0])));
    uint32_t v[4];
    for (uint32_t i = 0; i < count; i++) {
        float ax = fabsf(n.x), ay = fabsf(n.y), az = fabsf(n.z);
        vec2 uv = ay >= ax && ay >= az ? vec2_make(p[i].x, p[i].z * (n.y < 0 ? -1.0f : 1.0f))
                  : ax >= az           ? vec2_make(p[i].z * (n.x > 0 ? -1.0f : 1.0f), -p[i].y)
                                       : vec2_make(p[i].x * (n.z < 0 ? -1.0f : 1.0f), -p[i].y);
        v[i] = mesh_vertex(m, p[i], n, uv);
    }
    for (uint32_t i = 2; i < count; i++) mesh_triangle(m, v[0], v[i - 1], v[i]);
}

/** Corner of a bevelled box that lies on the face of `axis`; `signs` bit i: the high side of axis i. */
static vec3 bevel_corner(vec3 low, vec3 high, float bevel, unsigned signs, int axis) {
    float l[3] = {low.x, low.y, low.z}, h[3] = {high.x, high.y, high.z}, r[3];
    for (int i = 0; i < 3; i++) {
        float inset = i == axis ? 0 : bevel;
        r[i] = signs >> i & 1 ? h[i] - inset : l[i] + inset;
    }
    return vec3_make(r[0], r[1], r[2]);
}

/** Adds a polygon turned so that it faces away from the box's centre. */
static void outward_polygon(struct mesh_builder *m, vec3 centre, vec3 *p, uint32_t count) {
    vec3 n = vec3_cross(vec3_sub(p[1], p[0]), vec3_sub(p[2], p[0]));
    if (vec3_dot(n, vec3_sub(p[0], centre)) < 0)
        for (uint32_t i = 1; i <= (count - 1) / 2; i++) {
            vec3 swap = p[i];
            p[i] = p[count - i];
            p[count - i] = swap;
        }
    flat_polygon(m, p, count);
}

void mesh_bevel_box(struct mesh_builder *m, vec3 low, vec3 high, float bevel) {
    vec3 centre = vec3_scale(vec3_add(low, high), 0.5f);
    for (int axis = 0; axis < 3; axis++) {
        unsigned a = 1u << axis, b = 1u << (axis + 1) % 3, c = 1u << (axis + 2) % 3;
        for (unsigned side = 0; side < 2; side++) {
            unsigned s = side ? a : 0;
            vec3 face[4] = {bevel_corner(low, high, bevel, s, axis), bevel_corner(low, high, bevel, s | b, axis),
                            bevel_corner(low, high, bevel, s | b | c, axis), bevel_corner(low, high, bevel, s | c, axis)};
            outward_polygon(m, centre, face, 4);
        }
        for (unsigned edge = 0; edge < 4; edge++) { /* the four edges along `axis` */
            unsigned s = (edge & 1 ? b : 0) | (edge & 2 ? c : 0);
            int b_axis = (axis + 1) % 3, c_axis = (axis + 2) % 3;
            vec3 face[4] = {bevel_corner(low, high, bevel, s, b_axis), bevel_corner(low, high, bevel, s | a, b_axis),
                            bevel_corner(low, high, bevel, s | a, c_axis), bevel_corner(low, high, bevel, s, c_axis)};
            outward_polygon(m, centre, face, 4);
        }
    }
    for (unsigned s = 0; s < 8; s++) {
        vec3 face[3] = {bevel_corner(low, high, bevel, s, 0), bevel_corner(low, high, bevel, s, 1),
                        bevel_corner(low, high, bevel, s, 2)};
        outward_polygon(m, centre, face, 3);
    }
}

/* ---- profiles ---- */

static vec2 segment_normal(vec2 a, vec2 b) {
    vec3 n = vec3_normalize(vec3_make(b.y - a.y, a.x - b.x, 0));
    return vec2_make(n.x, n.y);
}

/** The normal (to the right of the direction) at an end of segment i: its own, or smoothed with the neighbour's. */
static vec2 profile_normal(const vec2 *p, uint32_t count, uint32_t i, bool at_end) {
    vec2 own = segment_normal(p[i], p[i + 1]);
    if ((at_end && i + 2 >= count) || (!at_end && i == 0)) return own;
    vec2 other = at_end ? segment_normal(p[i + 1], p[i + 2]) : segment_normal(p[i - 1], p[i]);
    if (own.x * other.x + own.y * other.y < SMOOTH_COSINE) return own;
    vec3 n = vec3_normalize(vec3_make(own.x + other.x, own.y + other.y, 0));
    return vec2_make(n.x, n.y);
}

void mesh_lathe(struct mesh_builder *m, vec3 base, const vec2 *profile, uint32_t count, uint32_t segments) {
    float greatest = 0, along = 0;
    for (uint32_t i = 0; i < count; i++) greatest = fmaxf(greatest, profile[i].x);
    for (uint32_t i = 0; i + 1 < count; i++) {
        vec2 p[2] = {profile[i], profile[i + 1]},
             n[2] = {profile_normal(profile, count, i, false), profile_normal(profile, count, i, true)};
        float length = hypotf(p[1].x - p[0].x, p[1].y - p[0].y);
        uint32_t previous[2] = {0};
        for (uint32_t s = 0; s <= segments; s++) {
            float angle = 2 * PI * (float)(s % segments) / (float)segments, c = cosf(angle), d = -sinf(angle);
            float u = 2 * PI * greatest * (float)s / (float)segments;
            uint32_t row[2];
            for (int k = 0; k < 2; k++)
                row[k] = mesh_vertex(m, vec3_add(base, vec3_make(p[k].x * c, p[k].y, p[k].x * d)),
                                     vec3_make(n[k].x * c, n[k].y, n[k].x * d), vec2_make(u, -(along + (float)k * length)));
            if (s && p[0].x > 0) mesh_triangle(m, previous[0], row[0], row[1]);
            if (s && p[1].x > 0) mesh_triangle(m, previous[0], row[1], previous[1]);
            previous[0] = row[0];
            previous[1] = row[1];
        }
        along += length;
    }
}

void mesh_cylinder(struct mesh_builder *m, vec3 base, float radius_low, float radius_high, float height, uint32_t segments) {
    const vec2 profile[] = {{0, 0}, {radius_low, 0}, {radius_high, height}, {0, height}};
    uint32_t first = radius_low > 0 ? 0 : 1, last = radius_high > 0 ? 4 : 3;
    mesh_lathe(m, base, profile + first, last - first, segments);
}

void mesh_sphere(struct mesh_builder *m, vec3 centre, float radius, uint32_t segments) {
    uint32_t rings = segments / 2;
    for (uint32_t r = 0; r < rings; r++) {
        uint32_t previous[2] = {0};
        for (uint32_t s = 0; s <= segments; s++) {
            uint32_t row[2];
            for (uint32_t k = 0; k < 2; k++) {
                float polar = PI * (float)(r + k) / (float)rings, angle = 2 * PI * (float)(s % segments) / (float)segments;
                bool pole = r + k == 0 || r + k == rings;
                float ring = pole ? 0 : sinf(polar);
                vec3 n = {ring * cosf(angle), pole ? (r + k ? 1.0f : -1.0f) : -cosf(polar), -ring * sinf(angle)};
                float u = 2 * PI * radius * (float)s / (float)segments;
                row[k] = mesh_vertex(m, vec3_add_scaled(centre, n, radius), n, vec2_make(u, -radius * polar));
            }
            if (s && r > 0) mesh_triangle(m, previous[0], row[0], row[1]);
            if (s && r + 1 < rings) mesh_triangle(m, previous[0], row[1], previous[1]);
            previous[0] = row[0];
            previous[1] = row[1];
        }
    }
}

void mesh_tube(struct mesh_builder *m, const vec3 *path, uint32_t count, float radius, uint32_t sides) {
    float along = 0;
    vec3 side = {0, 0, 0};
    uint32_t last_row = 0;
    for (uint32_t i = 0; i < count; i++) {
        vec3 direction = vec3_normalize(vec3_sub(path[MIN(i + 1, count - 1)], path[i ? i - 1 : 0]));
        /* The frame is carried along the path, so that it does not twist. */
        side = i ? vec3_normalize(vec3_sub(side, vec3_scale(direction, vec3_dot(side, direction))))
                 : vec3_perpendicular(direction);
        vec3 other = vec3_cross(direction, side);
        if (i) along += vec3_distance(path[i], path[i - 1]);
        uint32_t row = 0;
        for (uint32_t s = 0; s <= sides; s++) {
            float angle = 2 * PI * (float)(s % sides) / (float)sides;
            vec3 n = vec3_add(vec3_scale(side, cosf(angle)), vec3_scale(other, sinf(angle)));
            uint32_t v = mesh_vertex(m, vec3_add_scaled(path[i], n, radius), n,
                                     vec2_make(2 * PI * radius * (float)s / (float)sides, -along));
            if (s == 0) row = v;
            if (i && s) quad_indices(m, last_row + s - 1, last_row + s, row + s, row + s - 1);
        }
        last_row = row;
    }
}

void mesh_strip(struct mesh_builder *m, const vec2 *profile, uint32_t count, float z0, float z1) {
    float along = 0;
    for (uint32_t i = 0; i + 1 < count; i++) {
        vec2 a = profile[i], b = profile[i + 1], na = profile_normal(profile, count, i, false),
             nb = profile_normal(profile, count, i, true);
        float length = hypotf(b.x - a.x, b.y - a.y);
        uint32_t v[4] = {
            mesh_vertex(m, vec3_make(a.x, a.y, z1), vec3_make(-na.x, -na.y, 0), vec2_make(along, z1)),
            mesh_vertex(m, vec3_make(b.x, b.y, z1), vec3_make(-nb.x, -nb.y, 0), vec2_make(along + length, z1)),
            mesh_vertex(m, vec3_make(b.x, b.y, z0), vec3_make(-nb.x, -nb.y, 0), vec2_make(along + length, z0)),
            mesh_vertex(m, vec3_make(a.x, a.y, z0), vec3_make(-na.x, -na.y, 0), vec2_make(along, z0)),
        };
        quad_indices(m, v[0], v[1], v[2], v[3]);
        along += length;
    }
}

void mesh_prism(struct mesh_builder *m, const vec2 *outline, uint32_t count, float z0, float z1, bool caps) {
    for (uint32_t i = 0; i < count; i++) {
        vec2 a = outline[i], b = outline[(i + 1) % count];
        mesh_quad(m, vec3_make(a.x, a.y, z0), vec3_make(b.x - a.x, b.y - a.y, 0), vec3_make(0, 0, z1 - z0));
    }
    for (int side = 0; caps && side < 2; side++) {
        uint32_t first = 0;
        for (uint32_t i = 0; i < count; i++) {
            vec2 p = outline[i];
            float sign = side ? 1.0f : -1.0f;
            uint32_t v =
                mesh_vertex(m, vec3_make(p.x, p.y, side ? z1 : z0), vec3_make(0, 0, sign), vec2_make(sign * p.x, -p.y));
            if (i == 0) first = v;
            if (i >= 2) mesh_triangle(m, first, side ? v - 1 : v, side ? v : v - 1);
        }
    }
}

void mesh_surface(struct mesh_builder *m, uint32_t columns, uint32_t rows, mesh_surface_function *function,
                  const void *context) {
    const float step = 1e-3f;
    uint32_t first = 0;
    for (uint32_t r = 0; r <= rows; r++)
        for (uint32_t c = 0; c <= columns; c++) {
            float s = (float)c / (float)columns, t = (float)r / (float)rows;
            /* One-sided at the borders, so that the function is only asked inside its square. */
            float s0 = fmaxf(s - step, 0), s1 = fminf(s + step, 1), t0 = fmaxf(t - step, 0), t1 = fminf(t + step, 1);
            vec2 uv, unused;
            vec3 p = function(context, s, t, &uv);
            vec3 along_s = vec3_sub(function(context, s1, t, &unused), function(context, s0, t, &unused));
            vec3 along_t = vec3_sub(function(context, s, t1, &unused), function(context, s, t0, &unused));
            vec3 n = vec3_normalize(vec3_cross(along_s, along_t));
            if (!(vec3_dot(n, n) > 0.5f)) n = vec3_make(0, 1, 0);
            uint32_t v = mesh_vertex(m, p, n, uv);
            if (r == 0 && c == 0) first = v;
        }
    for (uint32_t r = 0; r < rows; r++)
        for (uint32_t c = 0; c < columns; c++) {
            uint32_t a = first + r * (columns + 1) + c, d = a + columns + 1;
            quad_indices(m, a, a + 1, d + 1, d);
        }
}
