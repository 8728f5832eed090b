/* SPDX-License-Identifier: MIT */
/*
 * KHR_draco_mesh_compression: the input is the compressed mesh of a file that is whole otherwise. Its head, which the importer reads itself, and what
 * libdraco makes of the rest: a mesh whose triangles name points that there are, or a warning.
 */
#include "scene/scene.h"
#include "tests/fuzz/fuzz.h"

enum { MESH_MOST = 4096 };

/* The first byte says which accessors the primitive declares: their counts, component types, and whether there is a normal. */
static size_t write_file(uint8_t what, const uint8_t *bytes, size_t size, uint8_t *out, size_t capacity) {
    static const uint32_t points[] = {3, 4, 9, 6}, corners[] = {3, 6, 24, 12}, index_types[] = {5121, 5123, 5125, 5125};
    char json[1024];
    const int written = snprintf(
        json, sizeof json,
        "{\"asset\":{\"version\":\"2.0\"},\"extensionsUsed\":[\"KHR_draco_mesh_compression\"],\"extensionsRequired\":[\"KHR_draco_mesh_compression\"],"
        "\"buffers\":[{\"byteLength\":%zu}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":%zu}],\"accessors\":[{\"componentType\":5126,\"type\":\"VEC3\","
        "\"count\":%u},{\"componentType\":%u,\"type\":\"SCALAR\",\"count\":%u},{\"componentType\":5121,\"normalized\":true,\"type\":\"VEC4\",\"count\":%u}],"
        "\"meshes\":[{\"primitives\":[{\"mode\":%d,\"indices\":1,\"attributes\":{\"POSITION\":0%s},\"extensions\":{\"KHR_draco_mesh_compression\":"
        "{\"bufferView\":0,\"attributes\":{\"POSITION\":0%s}}}}]}],\"nodes\":[{\"mesh\":0}]}",
        size, size, points[what & 3], index_types[what >> 4 & 3], corners[what >> 2 & 3], points[what & 3], what & 128 ? 5 : 4,
        what & 64 ? ",\"NORMAL\":0,\"COLOR_0\":2" : "", what & 64 ? ",\"NORMAL\":1,\"COLOR_0\":2" : "");
    const uint32_t length = ((uint32_t)written + 3) / 4 * 4, binary = ((uint32_t)size + 3) / 4 * 4;
    const uint32_t head[] = {0x46546c67, 2, 20 + length + 8 + binary, length, 0x4e4f534a}, chunk[] = {binary, 0x004e4942};
    if (head[2] > capacity) abort();
    memset(out, ' ', head[2]);
    memcpy(out, head, sizeof head);
    memcpy(out + 20, json, (size_t)written);
    memcpy(out + 20 + length, chunk, sizeof chunk);
    memcpy(out + 28 + length, bytes, size);
    return head[2];
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    static uint8_t file[MESH_MOST + 2048];
    if (size < 2 || size > MESH_MOST) return 0;
    fnl_host host = fuzz_host();
    fnl_load_params params = fnl_load_params_default();
    fnl_scene *scene;
    params.data = file;
    params.size = write_file(bytes[0], bytes + 1, size - 1, file, sizeof file);
    params.max_memory = (uint64_t)64 << 20;
    params.lenient = size % 2;
    if (fnl_scene_load(&host, "input", &params, &scene) != FNL_OK) return 0;
    for (uint32_t i = 0; i < scene->primitives.count; i++) {
        const struct scene_primitive *p = &scene->primitives.data[i];
        for (uint32_t k = 0; k < p->index_count; k++)
            if (p->indices[k] >= p->vertex_count) abort();
        for (uint32_t k = 0; k < p->vertex_count; k++)
            if (!vec3_finite(p->positions[k])) abort();
    }
    fnl_scene_destroy(&scene);
    return 0;
}
