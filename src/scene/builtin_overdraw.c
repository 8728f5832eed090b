/* SPDX-License-Identifier: MIT */
/** A scene that hides much of what it draws: its triangles from the farthest to the nearest, cut into slabs that are drawn in their order. */
#include "scene/builtin.h"

#include <stdlib.h>

enum {
    SLABS = 96,
    AGAIN = 13 /* so many slabs of 20 are drawn twice over, which makes four fragments a pixel of two and a half */
};

/** A triangle of an instance. */
struct piece {
    uint32_t node, instance, primitive, first; /* of its indices */
    uint32_t place;                            /* in the scene: decides between equal depths */
    float depth;
};

static int farthest_first(const void *a, const void *b) {
    const struct piece *x = a, *y = b;
    if (x->depth != y->depth) return x->depth > y->depth ? -1 : 1;
    return (x->place > y->place) - (x->place < y->place);
}

static vec3 transform(const mat4 *matrix, vec3 p) {
    vec4 h = mat4_mul_vec4(matrix, (vec4){p.x, p.y, p.z, 1});
    return (vec3){h.x, h.y, h.z};
}

static uint32_t list_pieces(const fnl_scene *scene, vec3 eye, vec3 axis, struct piece *out) {
    uint32_t count = 0;
    for (uint32_t n = 0; n < scene->nodes.count; n++) {
        const struct scene_node *node = &scene->nodes.data[n];
        if (node->mesh == SCENE_NONE || !node->active) continue;
        const struct scene_mesh *mesh = &scene->meshes.data[node->mesh];
        for (uint32_t i = 0; i < node->instance_count; i++) {
            mat4 matrix = scene_instance_world(scene, node, i);
            for (uint32_t p = mesh->first_primitive; p < mesh->first_primitive + mesh->primitive_count; p++) {
                const struct scene_primitive *primitive = &scene->primitives.data[p];
                if (primitive->topology != SCENE_TOPOLOGY_TRIANGLES) continue;
                for (uint32_t k = 0; k < primitive->index_count; k += 3) {
                    if (out) {
                        vec3 sum = {0, 0, 0};
                        for (int c = 0; c < 3; c++)
                            sum = vec3_add(sum, transform(&matrix, primitive->positions[primitive->indices[k + c]]));
                        out[count] =
                            (struct piece){n, i, p, k, count, vec3_dot(vec3_sub(vec3_scale(sum, 1.0f / 3), eye), axis)};
                    }
                    count++;
                }
            }
        }
    }
    return count;
}

/** Adds the triangles of a slab that have one material, as a mesh in world space. */
static bool add_slab(fnl_scene *scene, const struct piece *pieces, uint32_t count, uint32_t material) {
    uint32_t wanted = 0, used = 0;
    for (uint32_t i = 0; i < count; i++) wanted += scene->primitives.data[pieces[i].primitive].material == material;
    if (wanted == 0) return true;
    vec3 *positions = ARENA_ARRAY(&scene->arena, vec3, wanted * 3), *normals = ARENA_ARRAY(&scene->arena, vec3, wanted * 3);
    vec2 *uv = ARENA_ARRAY(&scene->arena, vec2, wanted * 3);
    uint32_t *indices = ARENA_ARRAY(&scene->arena, uint32_t, wanted * 3);
    if (!positions || !normals || !uv || !indices) return false;
    for (uint32_t i = 0; i < count; i++) {
        const struct scene_primitive *p = &scene->primitives.data[pieces[i].primitive];
        if (p->material != material) continue;
        mat4 matrix = scene_instance_world(scene, &scene->nodes.data[pieces[i].node], pieces[i].instance);
        for (uint32_t c = 0; c < 3; c++, used++) {
            uint32_t v = p->indices[pieces[i].first + c];
            vec3 end = transform(&matrix, vec3_add(p->positions[v], p->normals[v]));
            positions[used] = transform(&matrix, p->positions[v]);
            normals[used] = vec3_normalize(vec3_sub(end, positions[used]));
            uv[used] = p->uv[0] ? p->uv[0][v] : (vec2){0, 0};
            indices[used] = used;
        }
    }
    struct scene_primitive primitive = {.material = material,
                                        .vertex_count = used,
                                        .index_count = used,
                                        .indices = indices,
                                        .positions = positions,
                                        .normals = normals,
                                        .uv = {uv}};
    if (mesh_complete(&scene->arena, &primitive) != FNL_OK) return false;
    mat4 identity = mat4_identity();
    uint32_t mesh = scene_add_mesh(scene, "slab", &primitive, 1);
    return mesh != SCENE_NONE && scene_add_node(scene, "slab", SCENE_NONE, &identity, mesh) != SCENE_NONE;
}

void builtin_overdraw(struct builtin *b) {
    fnl_scene *scene = b->scene;
    fnl_camera camera;
    if (b->failed || fnl_scene_query_camera(scene, 0, &camera) != FNL_OK) return;
    vec3 axis = vec3_normalize(vec3_sub(camera.target, camera.position));
    uint32_t count = list_pieces(scene, camera.position, axis, NULL), node_count = scene->nodes.count;
    struct piece *pieces = host_allocate(&scene->host, MAX(count, 1u) * sizeof *pieces);
    if (!pieces) {
        b->failed = true;
        return;
    }
    list_pieces(scene, camera.position, axis, pieces);
    qsort(pieces, count, sizeof *pieces, farthest_first);
    for (uint32_t slab = 0; slab < SLABS; slab++) {
        uint32_t first = (uint32_t)((uint64_t)count * slab / SLABS), end = (uint32_t)((uint64_t)count * (slab + 1) / SLABS);
        for (uint32_t m = 0; m < scene->materials.count; m++)
            for (int times = 0; times < 1 + (slab % 20 < AGAIN) && !b->failed; times++)
                b->failed = !add_slab(scene, pieces + first, end - first, m);
    }
    host_free(&scene->host, pieces, MAX(count, 1u) * sizeof *pieces);
    for (uint32_t n = 0; n < node_count; n++) scene->nodes.data[n].mesh = SCENE_NONE;
}
