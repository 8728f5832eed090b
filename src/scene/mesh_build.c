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

/** glTF 2.0, 3.7.2.1: "flat normals" when none are given; so every face gets vertices of its own. */
static fnl_result make_flat_normals(struct arena *arena, struct scene_primitive *p) {
    uint32_t count = p->index_count;
    if (!mesh_gather(arena, p, p->indices, count)) return FNL_ERROR_MEMORY;
    vec3 *normals = arena_allocate(arena, sizeof(vec3) * (size_t)MAX(count, 1));
    uint32_t *indices = arena_allocate(arena, sizeof(uint32_t) * (size_t)MAX(count, 1));
    if (!normals || !indices) return FNL_ERROR_MEMORY;
    for (uint32_t i = 0; i + 2 < count; i += 3) {
        const vec3 *corner = p->positions + i;
        const vec3 e1 = vec3_sub(corner[1], corner[0]), e2 = vec3_sub(corner[2], corner[0]);
        vec3 n = vec3_normalize(vec3_cross(e1, e2));
        if (!(vec3_dot(n, n) > 0.5f)) n = vec3_normalize(vec3_cross(vec3_normalize(e1), vec3_normalize(e2))); /* too large or small a product */
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
    }
    if ((p->uv[0] || p->uv[1]) && (!p->tangents || !p->normals))
        bytes += corners * TANGENT_CORNER_BYTES + vertices * TANGENT_VERTEX_BYTES +
                 (corners + vertices) * (vertex_bytes + sizeof(vec4)) + corners * sizeof(uint32_t);
    return bytes;
}

fnl_result mesh_complete(struct arena *arena, struct scene_primitive *primitive) {
    if (primitive->topology != SCENE_TOPOLOGY_TRIANGLES || primitive->vertex_count == 0) return FNL_OK;
    if (!primitive->indices) TRY(number_vertices(arena, primitive));
    if (primitive->index_count < 3) return FNL_OK;
    if (!primitive->normals) TRY(make_flat_normals(arena, primitive));
    const vec2 *uv = primitive->uv[0] ? primitive->uv[0] : primitive->uv[1];
    if (!primitive->tangents && uv) TRY(mesh_make_tangents(arena, primitive, uv));
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
