/* SPDX-License-Identifier: MIT */
#include "scene/mesh_build.h"

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

bool mesh_gather(struct arena *arena, struct scene_primitive *p, const uint32_t *source, uint32_t count) {
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

/* Unit; no unit vector without area. */
static vec3 face_normal(vec3 a, vec3 b, vec3 c) {
    const vec3 e1 = vec3_sub(b, a), e2 = vec3_sub(c, a), n = vec3_normalize(vec3_cross(e1, e2));
    if (vec3_dot(n, n) > 0.5f) return n;
    return vec3_normalize(vec3_cross(vec3_normalize(e1), vec3_normalize(e2))); /* too large or small a product */
}

/* Of triangles whose corners follow each other. */
static void find_flat_normals(const vec3 *positions, uint32_t count, vec3 *normals) {
    for (uint32_t i = 0; i + 2 < count; i += 3) {
        vec3 n = face_normal(positions[i], positions[i + 1], positions[i + 2]);
        if (!(vec3_dot(n, n) > 0.5f)) n = vec3_make(0, 1, 0); /* a face without area is never seen */
        for (uint32_t k = 0; k < 3; k++) normals[i + k] = n;
    }
}

/** glTF 2.0, 3.7.2.1: "flat normals" when none are given; so every face gets vertices of its own. */
static fnl_result make_flat_normals(struct arena *arena, struct scene_primitive *p) {
    uint32_t count = p->index_count;
    if (!mesh_gather(arena, p, p->indices, count)) return FNL_ERROR_MEMORY;
    vec3 *normals = arena_allocate_zero(arena, sizeof(vec3) * (size_t)MAX(count, 1));
    uint32_t *indices = arena_allocate(arena, sizeof(uint32_t) * (size_t)MAX(count, 1));
    if (!normals || !indices) return FNL_ERROR_MEMORY;
    find_flat_normals(p->positions, count, normals);
    for (uint32_t i = 0; i < count; i++) indices[i] = i;
    p->normals = normals;
    p->tangents = NULL; /* given tangents mean nothing without the normals they belong to */
    p->indices = indices;
    return FNL_OK;
}

/* What a target makes of flat normals and of the tangents by `uv`, NULL: none. Every corner has a vertex of its own. */
static fnl_result make_target_normals(struct arena *arena, const struct scene_primitive *p, const vec2 *uv, struct scene_morph_target *target) {
    const uint32_t count = p->vertex_count;
    target->normals = target->tangents = NULL;
    if (!target->positions) return FNL_OK;
    vec3 *normals = arena_allocate(arena, sizeof(vec3) * (size_t)count), *tangents = uv ? arena_allocate(arena, sizeof(vec3) * (size_t)count) : NULL;
    struct arena passing;
    arena_init(&passing, arena->host, sizeof(vec3) * 2 * (size_t)count);
    vec3 *moved = arena_allocate(&passing, sizeof(vec3) * (size_t)count), *flat = arena_allocate_zero(&passing, sizeof(vec3) * (size_t)count);
    fnl_result result = normals && moved && flat && (tangents || !uv) ? FNL_OK : FNL_ERROR_MEMORY;
    for (uint32_t i = 0; i < count && result == FNL_OK; i++) moved[i] = vec3_add(p->positions[i], target->positions[i]);
    if (result == FNL_OK) find_flat_normals(moved, count, flat);
    for (uint32_t i = 0; i < count && result == FNL_OK; i++) normals[i] = vec3_sub(flat[i], p->normals[i]);
    struct scene_primitive there = *p;
    there.positions = moved;
    there.normals = flat;
    there.morph_target_count = 0;
    if (uv && result == FNL_OK) result = mesh_make_tangents(&passing, &there, uv);
    for (uint32_t i = 0; uv && i < count && result == FNL_OK; i++) {
        const vec4 a = p->tangents[i], b = there.tangents[i];
        tangents[i] = vec3_make(b.x - a.x, b.y - a.y, b.z - a.z);
    }
    arena_finish(&passing);
    target->normals = normals;
    target->tangents = tangents;
    return result;
}

/** glTF 2.0, 3.7.2.2: where the base has no normals, each target gets normals and tangents of its own. */
static fnl_result complete_targets(struct arena *arena, struct scene_primitive *p, const vec2 *uv) {
    if (!p->morph_target_count) return FNL_OK;
    struct scene_morph_target *targets = arena_copy(arena, p->morph_targets, sizeof *targets * (size_t)p->morph_target_count);
    if (!targets) return FNL_ERROR_MEMORY;
    for (uint32_t i = 0; i < p->morph_target_count; i++) TRY(make_target_normals(arena, p, uv, &targets[i]));
    p->morph_targets = targets;
    return FNL_OK;
}

uint64_t mesh_made_target_bytes(const struct scene_primitive *p) {
    if (p->topology != SCENE_TOPOLOGY_TRIANGLES || p->normals) return 0;
    const uint64_t corners = p->indices ? p->index_count : p->vertex_count;
    uint64_t moved = 0;
    for (uint32_t i = 0; i < p->morph_target_count; i++) moved += p->morph_targets[i].positions != NULL;
    return moved * corners * sizeof(vec3) * (p->uv[0] || p->uv[1] ? 2 : 1);
}

uint64_t mesh_vertex_bytes(const struct scene_primitive *p) {
    uint64_t size = sizeof(vec3) * (1 + (p->normals != NULL)) + sizeof(vec2) * ((p->uv[0] != NULL) + (p->uv[1] != NULL)) +
                    sizeof(vec4) * ((p->tangents != NULL) + (p->colors != NULL)) +
                    p->joint_count * (sizeof(uint16_t) + sizeof(float));
    for (uint32_t i = 0; i < p->morph_target_count; i++) {
        const struct scene_morph_target *target = &p->morph_targets[i];
        size += sizeof(vec3) * ((target->positions != NULL) + (target->normals != NULL) + (target->tangents != NULL));
    }
    return size;
}

/* Of tangents: per corner a third of a face (40), its edge (8), space (20, while the list grows 40), member (20), place in order and new
   index (8), and two numbers of a new vertex (8); per vertex its weld, the hash table of up to four slots, and what it is split by. */
#define TANGENT_CORNER_BYTES 100u
#define TANGENT_VERTEX_BYTES 44u

uint64_t mesh_complete_bytes(const struct scene_primitive *p) {
    if (p->topology != SCENE_TOPOLOGY_TRIANGLES) return 0;
    uint64_t corners = p->indices ? p->index_count : p->vertex_count, vertices = p->vertex_count, bytes = 0,
             vertex_bytes = mesh_vertex_bytes(p);
    if (!p->indices) bytes += corners * sizeof(uint32_t);
    if (!p->normals) {
        bytes += corners * (vertex_bytes + sizeof(vec3) + sizeof(uint32_t));
        vertex_bytes += sizeof(vec3);
        vertices = corners;
        if (p->morph_target_count) bytes += mesh_made_target_bytes(p) + corners * (sizeof(vec3) * 2 + sizeof(vec4)); /* and one that is being made */
    }
    if ((p->uv[0] || p->uv[1]) && (!p->tangents || !p->normals))
        bytes += corners * TANGENT_CORNER_BYTES + vertices * TANGENT_VERTEX_BYTES +
                 (corners + vertices) * (vertex_bytes + sizeof(vec4)) + corners * sizeof(uint32_t) + vertices * sizeof(vec2);
    return bytes;
}

/* The texture coordinates that tangents follow: a set as it is, or turned, in memory of `passing`. NULL: there are none, or (the result) no memory. */
static fnl_result find_tangent_uv(struct arena *passing, const struct scene_primitive *p, uint32_t set, const float *turn, const vec2 **out) {
    static const float identity[4] = {1, 0, 0, 1}, none[4] = {0};
    const vec2 *uv = *out = p->uv[set] ? p->uv[set] : p->uv[!set];
    if (!uv || !turn || memcmp(turn, identity, sizeof identity) == 0 || memcmp(turn, none, sizeof none) == 0) return FNL_OK;
    vec2 *turned = arena_allocate(passing, sizeof *turned * (size_t)p->vertex_count);
    for (uint32_t i = 0; turned && i < p->vertex_count; i++)
        turned[i] = vec2_make(turn[0] * uv[i].x + turn[1] * uv[i].y, turn[2] * uv[i].x + turn[3] * uv[i].y);
    *out = turned;
    return turned ? FNL_OK : FNL_ERROR_MEMORY;
}

fnl_result mesh_complete_by(struct arena *arena, struct scene_primitive *primitive, uint32_t set, const float *turn) {
    if (primitive->topology != SCENE_TOPOLOGY_TRIANGLES || primitive->vertex_count == 0) return FNL_OK;
    if (!primitive->indices) TRY(number_vertices(arena, primitive));
    if (primitive->index_count < 3) return FNL_OK;
    const bool flat = !primitive->normals;
    if (flat) TRY(make_flat_normals(arena, primitive));
    struct arena passing;
    arena_init(&passing, arena->host, 4096);
    const vec2 *uv;
    fnl_result result = find_tangent_uv(&passing, primitive, set, turn, &uv);
    if (result == FNL_OK && !primitive->tangents && uv) result = mesh_make_tangents(arena, primitive, uv);
    if (result == FNL_OK && flat) result = complete_targets(arena, primitive, uv);
    arena_finish(&passing);
    return result;
}

fnl_result mesh_complete(struct arena *arena, struct scene_primitive *primitive) { return mesh_complete_by(arena, primitive, 0, NULL); }

bool primitive_leans(const struct scene_primitive *p) {
    const float agrees = 0.9999f; /* cosine: some files have 8 or 16 bits per component */
    if (p->topology != SCENE_TOPOLOGY_TRIANGLES || !p->normals) return false;
    if (p->joint_count || p->morph_target_count) return true; /* what bends faces does not turn their normals alike */
    const uint32_t count = p->indices ? p->index_count : p->vertex_count;
    for (uint32_t i = 0; i + 2 < count; i += 3) {
        uint32_t v[3];
        for (uint32_t k = 0; k < 3; k++) v[k] = p->indices ? p->indices[i + k] : i + k;
        const vec3 face = face_normal(p->positions[v[0]], p->positions[v[1]], p->positions[v[2]]);
        if (!(vec3_dot(face, face) > 0.5f)) continue; /* no area */
        for (uint32_t k = 0; k < 3; k++)
            if (!(vec3_dot(face, vec3_normalize(p->normals[v[k]])) >= agrees)) return true;
    }
    return false;
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
