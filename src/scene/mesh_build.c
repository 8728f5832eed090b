/* SPDX-License-Identifier: MIT */
#include "scene/scene.h"

/* ---- gathering: every attribute of new vertex i comes from old vertex source[i] ---- */

static const void *gather(struct arena *arena, const void *data, size_t element_size, const uint32_t *source,
                          uint32_t count) {
    unsigned char *out = arena_allocate(arena, element_size * count);
    for (uint32_t i = 0; out && i < count; i++)
        memcpy(out + element_size * i, (const unsigned char *)data + element_size * source[i], element_size);
    return out;
}

/** Replaces `pointer` by its gathered copy; a NULL array stays NULL. */
#define GATHER(pointer, element_size)                                                                                       \
    ((pointer) == NULL || ((pointer) = gather(arena, pointer, element_size, source, count)) != NULL)

static bool gather_primitive(struct arena *arena, struct scene_primitive *p, const uint32_t *source, uint32_t count) {
    bool done = GATHER(p->positions, sizeof(vec3)) && GATHER(p->normals, sizeof(vec3)) &&
                GATHER(p->tangents, sizeof(vec4)) && GATHER(p->uv[0], sizeof(vec2)) && GATHER(p->uv[1], sizeof(vec2)) &&
                GATHER(p->colors, sizeof(vec4)) && GATHER(p->joints, sizeof(uint16_t) * p->joint_count) &&
                GATHER(p->weights, sizeof(float) * p->joint_count);
    if (done && p->morph_target_count) {
        struct scene_morph_target *targets =
            arena_copy(arena, p->morph_targets, sizeof(*targets) * (size_t)p->morph_target_count);
        if (!targets) return false;
        for (uint32_t i = 0; i < p->morph_target_count; i++)
            done = done && GATHER(targets[i].positions, sizeof(vec3)) && GATHER(targets[i].normals, sizeof(vec3)) &&
                   GATHER(targets[i].tangents, sizeof(vec3));
        p->morph_targets = targets;
    }
    p->vertex_count = count;
    return done;
}

/* ---- indices and flat normals ---- */

static fnl_result number_vertices(struct arena *arena, struct scene_primitive *p) {
    p->index_count = p->vertex_count / 3 * 3;
    uint32_t *indices = arena_allocate(arena, sizeof(uint32_t) * (size_t)MAX(p->index_count, 1));
    if (!indices) return FNL_ERROR_MEMORY;
    for (uint32_t i = 0; i < p->index_count; i++) indices[i] = i;
    p->indices = indices;
    return FNL_OK;
}

/** glTF 2.0, 3.7.2.1: "flat normals" when none are given; so every face gets vertices of its own. */
static fnl_result make_flat_normals(struct arena *arena, struct scene_primitive *p) {
    uint32_t count = p->index_count;
    if (!gather_primitive(arena, p, p->indices, count)) return FNL_ERROR_MEMORY;
    vec3 *normals = arena_allocate(arena, sizeof(vec3) * (size_t)MAX(count, 1));
    uint32_t *indices = arena_allocate(arena, sizeof(uint32_t) * (size_t)MAX(count, 1));
    if (!normals || !indices) return FNL_ERROR_MEMORY;
    for (uint32_t i = 0; i + 2 < count; i += 3) {
        const vec3 *corner = p->positions + i;
        vec3 n = vec3_normalize(vec3_cross(vec3_sub(corner[1], corner[0]), vec3_sub(corner[2], corner[0])));
        if (!(vec3_dot(n, n) > 0.5f)) n = vec3_make(0, 1, 0); /* a face without area is never seen */
        for (uint32_t k = 0; k < 3; k++) {
            normals[i + k] = n;
            indices[i + k] = i + k;
        }
    }
    p->normals = normals;
    p->tangents = NULL; /* given tangents mean nothing without the normals they belong to */
    p->indices = indices;
    return FNL_OK;
}

/* ---- tangents: Mikkelsen, "Simulation of Wrinkled Surfaces Revisited" (2008), chapter "tangent space" ---- */

struct weld_key {
    float v[8];
};

static struct weld_key weld_key(const struct scene_primitive *p, const vec2 *uv, uint32_t i) {
    vec3 a = p->positions[i], n = p->normals[i];
    /* + 0 turns the negative zero into the positive one: equal keys have equal bytes. */
    return (struct weld_key){{a.x + 0, a.y + 0, a.z + 0, n.x + 0, n.y + 0, n.z + 0, uv[i].x + 0, uv[i].y + 0}};
}

/** weld[i] = the first vertex with the position, normal and uv of vertex i. */
static fnl_result weld_vertices(const fnl_host *host, const struct scene_primitive *p, const vec2 *uv, uint32_t *weld) {
    uint64_t slots = 16;
    while (slots < (uint64_t)p->vertex_count * 2) slots *= 2;
    uint32_t *table = host_allocate(host, sizeof(uint32_t) * (size_t)slots);
    if (!table) return FNL_ERROR_MEMORY;
    memset(table, 0xff, sizeof(uint32_t) * (size_t)slots);
    for (uint32_t i = 0; i < p->vertex_count; i++) {
        struct weld_key key = weld_key(p, uv, i);
        uint64_t slot = hash_bytes(&key, sizeof key, HASH_SEED) & (slots - 1);
        for (; table[slot] != UINT32_MAX; slot = (slot + 1) & (slots - 1)) {
            struct weld_key other = weld_key(p, uv, table[slot]);
            if (memcmp(&key, &other, sizeof key) == 0) break;
        }
        if (table[slot] == UINT32_MAX) table[slot] = i;
        weld[i] = table[slot];
    }
    host_free(host, table, sizeof(uint32_t) * (size_t)slots);
    return FNL_OK;
}

/** A face's direction of growing u (not normalised), and on which side of the picture it shows. */
struct face_tangent {
    vec3 u;
    int side; /* 0: as in the picture, 1: mirrored, -1: the uvs span no area */
};

/** v runs down in glTF's pictures and up in the paper, hence its sign. */
static struct face_tangent face_tangent(const vec3 *p0, const vec3 *p1, const vec3 *p2, vec2 t0, vec2 t1, vec2 t2) {
    vec3 e1 = vec3_sub(*p1, *p0), e2 = vec3_sub(*p2, *p0);
    float u1 = t1.x - t0.x, v1 = t0.y - t1.y, u2 = t2.x - t0.x, v2 = t0.y - t2.y;
    float area = u1 * v2 - u2 * v1;
    if (!(fabsf(area) > FLT_MIN)) return (struct face_tangent){.side = -1};
    vec3 u = vec3_sub(vec3_scale(e1, v2), vec3_scale(e2, v1));
    return (struct face_tangent){vec3_scale(u, area < 0 ? -1.0f : 1.0f), area < 0};
}

static vec3 on_plane(vec3 v, vec3 n) { return vec3_normalize(vec3_sub(v, vec3_scale(n, vec3_dot(v, n)))); }

struct tangent_work {
    uint32_t *weld;     /* per vertex */
    vec3 (*sums)[2];    /* per welded vertex and side */
    uint8_t *sides;     /* per vertex: bit s when a face of side s uses it */
    int8_t *face_sides; /* per face */
};

static void sum_face_tangents(const struct scene_primitive *p, const vec2 *uv, struct tangent_work *work) {
    for (uint32_t f = 0; f < p->index_count / 3; f++) {
        const uint32_t *v = p->indices + 3 * (size_t)f;
        const vec3 *a = p->positions;
        struct face_tangent face = face_tangent(&a[v[0]], &a[v[1]], &a[v[2]], uv[v[0]], uv[v[1]], uv[v[2]]);
        work->face_sides[f] = (int8_t)face.side;
        if (face.side < 0) continue;
        for (int k = 0; k < 3; k++) {
            vec3 n = p->normals[v[k]], corner = a[v[k]];
            vec3 e1 = on_plane(vec3_sub(a[v[(k + 1) % 3]], corner), n),
                 e2 = on_plane(vec3_sub(a[v[(k + 2) % 3]], corner), n);
            float angle = acosf(CLAMP(vec3_dot(e1, e2), -1.0f, 1.0f));
            vec3 *sum = &work->sums[work->weld[v[k]]][face.side];
            *sum = vec3_add_scaled(*sum, on_plane(face.u, n), angle);
            work->sides[v[k]] |= (uint8_t)(1 << face.side);
        }
    }
}

/** Vertices that faces of both sides use are split; the copies come last, and mirrored faces use them. */
static fnl_result split_by_side(struct arena *arena, struct scene_primitive *p, const struct tangent_work *work,
                                uint32_t **out_source) {
    uint64_t count = p->vertex_count;
    for (uint32_t i = 0; i < p->vertex_count; i++) count += work->sides[i] == 3;
    if (count >= UINT32_MAX) return FNL_ERROR_UNSUPPORTED;
    uint32_t *source = arena_allocate(arena, sizeof(uint32_t) * (size_t)count);
    uint32_t *indices = arena_allocate(arena, sizeof(uint32_t) * (size_t)p->index_count);
    uint32_t *copies = arena_allocate_zero(arena, sizeof(uint32_t) * (size_t)p->vertex_count);
    if (!source || !indices || !copies) return FNL_ERROR_MEMORY;
    uint32_t next = p->vertex_count;
    for (uint32_t i = 0; i < p->vertex_count; i++) {
        source[i] = i;
        if (work->sides[i] == 3) source[copies[i] = next++] = i;
    }
    for (uint32_t i = 0; i < p->index_count; i++) {
        uint32_t v = p->indices[i];
        indices[i] = work->face_sides[i / 3] == 1 && copies[v] ? copies[v] : v;
    }
    p->indices = indices;
    *out_source = source;
    return gather_primitive(arena, p, source, (uint32_t)count) ? FNL_OK : FNL_ERROR_MEMORY;
}

static fnl_result finish_tangents(struct arena *arena, struct scene_primitive *p, const struct tangent_work *work) {
    uint32_t first_copy = p->vertex_count, *source = NULL;
    bool mixed = false;
    for (uint32_t i = 0; i < p->vertex_count && !mixed; i++) mixed = work->sides[i] == 3;
    if (mixed) TRY(split_by_side(arena, p, work, &source));
    vec4 *tangents = arena_allocate(arena, sizeof(vec4) * (size_t)p->vertex_count);
    if (!tangents) return FNL_ERROR_MEMORY;
    for (uint32_t i = 0; i < p->vertex_count; i++) {
        uint32_t origin = source ? source[i] : i;
        int side = i >= first_copy || work->sides[origin] == 2;
        vec3 n = p->normals[i], t = on_plane(work->sums[work->weld[origin]][side], n);
        if (!(vec3_dot(t, t) > 0.5f)) t = vec3_perpendicular(vec3_dot(n, n) > 0.5f ? n : vec3_make(0, 1, 0));
        tangents[i] = vec4_make(t.x, t.y, t.z, side ? -1.0f : 1.0f);
    }
    p->tangents = tangents;
    return FNL_OK;
}

static fnl_result make_tangents(struct arena *arena, struct scene_primitive *p, const vec2 *uv) {
    const fnl_host *host = arena->host;
    size_t vertices = p->vertex_count, faces = p->index_count / 3;
    struct tangent_work work = {
        .weld = host_allocate(host, sizeof(*work.weld) * vertices),
        .sums = host_allocate_zero(host, sizeof(*work.sums) * vertices),
        .sides = host_allocate_zero(host, vertices),
        .face_sides = host_allocate_zero(host, faces),
    };
    fnl_result result = FNL_ERROR_MEMORY;
    if (work.weld && work.sums && work.sides && work.face_sides) {
        result = weld_vertices(host, p, uv, work.weld);
        if (result == FNL_OK) {
            sum_face_tangents(p, uv, &work);
            result = finish_tangents(arena, p, &work);
        }
    }
    host_free(host, work.weld, sizeof(*work.weld) * vertices);
    host_free(host, work.sums, sizeof(*work.sums) * vertices);
    host_free(host, work.sides, vertices);
    host_free(host, work.face_sides, faces);
    return result;
}

fnl_result mesh_complete(struct arena *arena, struct scene_primitive *primitive) {
    if (primitive->topology != SCENE_TOPOLOGY_TRIANGLES || primitive->vertex_count == 0) return FNL_OK;
    if (!primitive->indices) TRY(number_vertices(arena, primitive));
    if (primitive->index_count < 3) return FNL_OK;
    if (!primitive->normals) TRY(make_flat_normals(arena, primitive));
    const vec2 *uv = primitive->uv[0] ? primitive->uv[0] : primitive->uv[1];
    if (!primitive->tangents && uv) TRY(make_tangents(arena, primitive, uv));
    return FNL_OK;
}

/** Weights are taken to stay in 0..1; each vertex then reaches at most the sum of its displacements of one sign. */
struct box primitive_bounds(const struct scene_primitive *primitive) {
    struct box box = box_empty();
    for (uint32_t i = 0; i < primitive->vertex_count; i++) {
        vec3 low = primitive->positions[i], high = low, zero = {0, 0, 0};
        for (uint32_t k = 0; k < primitive->morph_target_count; k++) {
            const vec3 *moves = primitive->morph_targets[k].positions;
            if (!moves) continue;
            low = vec3_add(low, vec3_min(moves[i], zero));
            high = vec3_add(high, vec3_max(moves[i], zero));
        }
        box_add_point(&box, low);
        box_add_point(&box, high);
    }
    return box;
}
