/* SPDX-License-Identifier: MIT */
/* The glTF importer: whatever the bytes, a scene that keeps its own rules, or an error; and all memory given back. */
#include "scene/scene.h"
#include "tests/fuzz/fuzz.h"

/** What a renderer relies on. */
static void check_primitive(const fnl_scene *scene, const struct scene_primitive *p) {
    if (!p->positions || !p->indices || (p->material != SCENE_NONE && p->material >= scene->materials.count)) abort();
    if (p->topology == SCENE_TOPOLOGY_TRIANGLES && (!p->normals || p->index_count % 3)) abort();
    for (uint32_t i = 0; i < p->index_count; i++)
        if (p->indices[i] >= p->vertex_count) abort();
    for (uint32_t i = 0; i < p->vertex_count; i++)
        if (!vec3_finite(p->positions[i])) abort();
}

static void check_node(const fnl_scene *scene, const struct scene_node *node) {
    if (node->parent != SCENE_NONE && node->parent >= scene->nodes.count) abort();
    if (node->mesh != SCENE_NONE && node->mesh >= scene->meshes.count) abort();
    if (node->skin == SCENE_NONE) return;
    const struct scene_skin *skin = &scene->skins.data[node->skin];
    const struct scene_mesh *mesh = &scene->meshes.data[node->mesh];
    for (uint32_t i = 0; i < mesh->primitive_count; i++) {
        const struct scene_primitive *p = &scene->primitives.data[mesh->first_primitive + i];
        for (uint64_t k = 0; k < (uint64_t)p->joint_count * p->vertex_count; k++)
            if (p->joints[k] >= skin->joint_count) abort();
    }
}

/** What a file refers to is the file itself, from its middle on. */
struct input {
    const uint8_t *bytes;
    size_t size;
    uint64_t given, released;
};

static void release(void *user, const void *data, size_t size) {
    struct input *input = user;
    if (data != input->bytes + input->size / 2 || size != input->size - input->size / 2) abort();
    input->released++;
}

static fnl_result resolve(void *user, const char *uri, fnl_resource *out) {
    struct input *input = user;
    if (!*uri) return FNL_ERROR_FILE;
    *out = (fnl_resource){input->bytes + input->size / 2, input->size - input->size / 2, release, input};
    input->given++;
    return FNL_OK;
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    fnl_host host = fuzz_host();
    struct input input = {.bytes = bytes, .size = size};
    fnl_load_params params = fnl_load_params_default();
    params.lenient = size % 2; /* goes on where others end */
    params.max_memory = (uint64_t)256 << 20;
    params.resolve = resolve;
    params.user = &input;
    fnl_scene *scene;
    params.data = bytes;
    params.size = size;
    if (fnl_scene_load(&host, "input", &params, &scene) != FNL_OK) {
        if (scene || input.released != input.given) abort();
        return 0;
    }
    for (uint32_t i = 0; i < scene->primitives.count; i++) check_primitive(scene, &scene->primitives.data[i]);
    for (uint32_t i = 0; i < scene->nodes.count; i++) check_node(scene, &scene->nodes.data[i]);
    fnl_scene_info info;
    fnl_camera camera;
    fnl_scene_query_info(scene, &info);
    if (fnl_scene_query_framing_camera(scene, 1.5f, &camera) == FNL_OK) scene_choose_levels(scene, &camera);
    for (uint32_t i = 0; i < scene->animations.count; i++) fnl_scene_set_time(scene, i, 0.3);
    fnl_scene_destroy(&scene);
    if (input.released != input.given) abort();
    return 0;
}
