/* SPDX-License-Identifier: MIT */
/**
 * For tests: animals and people in the place of sample models, which not every checkout has. A tube of rings round a chain of joints, skinned to two joints
 * each, with texture coordinates, a picture, and animations in which every joint but the first turns.
 */
#ifndef FNL_TESTS_FIGURE_FILE_H
#define FNL_TESTS_FIGURE_FILE_H

#include "tests/gltf_test_file.h"

struct figure {
    const char *name; /* of the sample that it replaces */
    uint32_t rings, segments, joints, animations;
    float length, radius; /* in the sample's units */
    bool upright;         /* along Y, from 0; else along Z, on a height of two radii */
};

/** As many triangles as the samples have, or almost. */
static const struct figure figures[] = {{"Fox.glb", 48, 6, 24, 3, 150, 20, false}, {"CesiumMan.glb", 83, 28, 19, 1, 1.5f, 0.2f, true}};

static inline const struct figure *figure_find(const char *name) {
    for (size_t i = 0; i < COUNT_OF(figures); i++)
        if (strcmp(figures[i].name, name) == 0) return &figures[i];
    return NULL;
}

struct figure_file {
    char json[65536];
    size_t used;
    unsigned char *bytes;
    size_t size;
    uint32_t views;
    char view_text[8192];
};

static inline void figure_add(struct figure_file *f, const char *format, ...) __attribute__((format(printf, 2, 3)));
static inline void figure_add(struct figure_file *f, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    f->used += (size_t)vsnprintf(f->json + f->used, sizeof f->json - f->used, format, arguments);
    va_end(arguments);
}

/** Accessor i reads buffer view i. */
static inline void figure_view(struct figure_file *f, const void *data, size_t size) {
    const size_t used = strlen(f->view_text);
    f->bytes = realloc(f->bytes, f->size + size + 4);
    memcpy(f->bytes + f->size, data, size);
    snprintf(f->view_text + used, sizeof f->view_text - used, "%s{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu}", f->views++ ? "," : "", f->size, size);
    f->size = (f->size + size + 3) / 4 * 4;
}

static inline vec3 figure_at(const struct figure *figure, float along, float x, float y) {
    return figure->upright ? vec3_make(x, along * figure->length, y) : vec3_make(x, 2 * figure->radius + y, (along - 0.5f) * figure->length);
}

static inline void figure_mesh(const struct figure *figure, struct figure_file *f, uint32_t *vertices, uint32_t *corners) {
    const uint32_t across = figure->segments + 1, count = (figure->rings + 1) * across;
    vec3 *positions = calloc(count, sizeof *positions), *normals = calloc(count, sizeof *normals);
    vec2 *uv = calloc(count, sizeof *uv);
    uint8_t(*joints)[4] = calloc(count, sizeof *joints);
    vec4 *weights = calloc(count, sizeof *weights);
    uint16_t *indices = calloc((size_t)figure->rings * figure->segments * 6, sizeof *indices);
    *vertices = count;
    *corners = 0;
    for (uint32_t r = 0; r <= figure->rings; r++)
        for (uint32_t s = 0; s < across; s++) {
            const float along = (float)r / (float)figure->rings, angle = 6.2831853f * (float)(s % figure->segments) / (float)figure->segments;
            const float thick = figure->radius * (0.05f + 0.95f * sinf(3.1415927f * along)), place = along * (float)(figure->joints - 1);
            const uint32_t i = r * across + s, joint = MIN((uint32_t)place, figure->joints - 2);
            positions[i] = figure_at(figure, along, thick * cosf(angle), thick * sinf(angle));
            normals[i] = figure->upright ? vec3_make(cosf(angle), 0, sinf(angle)) : vec3_make(cosf(angle), sinf(angle), 0);
            uv[i] = (vec2){(float)s / (float)figure->segments, along};
            joints[i][0] = (uint8_t)joint, joints[i][1] = (uint8_t)(joint + 1);
            weights[i] = (vec4){1 - (place - (float)joint), place - (float)joint, 0, 0};
            if (r == figure->rings || s == figure->segments) continue;
            const uint16_t a = (uint16_t)i, b = (uint16_t)(i + 1), c = (uint16_t)(i + across), d = (uint16_t)(c + 1);
            const uint16_t out[6] = {a, b, c, b, d, c}, turned[6] = {a, c, b, b, c, d};
            memcpy(indices + *corners, figure->upright ? turned : out, sizeof out);
            *corners += 6;
        }
    figure_view(f, positions, count * sizeof *positions);
    figure_view(f, normals, count * sizeof *normals);
    figure_view(f, uv, count * sizeof *uv);
    figure_view(f, joints, count * sizeof *joints);
    figure_view(f, weights, count * sizeof *weights);
    figure_view(f, indices, *corners * sizeof *indices);
    free(positions), free(normals), free(uv), free(joints), free(weights), free(indices);
}

static inline void figure_joints(const struct figure *figure, struct figure_file *f) {
    mat4 *inverse = calloc(figure->joints, sizeof *inverse);
    for (uint32_t i = 0; i < figure->joints; i++) {
        const vec3 at = figure_at(figure, (float)i / (float)(figure->joints - 1), 0, 0);
        inverse[i] = mat4_identity();
        inverse[i].m[12] = -at.x, inverse[i].m[13] = -at.y, inverse[i].m[14] = -at.z;
    }
    figure_view(f, inverse, figure->joints * sizeof *inverse);
    free(inverse);
}

/** A GLB; free it with free(). */
static inline unsigned char *figure_glb(const struct figure *figure, size_t *size) {
    enum { KEYS = 3, TIMES = 7 }; /* TIMES: the first accessor behind those of the mesh and the joints */
    struct figure_file *f = calloc(1, sizeof *f);
    uint32_t vertices, corners;
    figure_mesh(figure, f, &vertices, &corners);
    figure_joints(figure, f);
    for (uint32_t a = 0; a < figure->animations; a++) {
        const float end = 1.2f + 1.1f * (float)a, times[KEYS] = {0, end / 2, end}, angle = (a % 2 ? -0.045f : 0.045f) / 2;
        const vec4 turns[KEYS] = {{0, 0, 0, 1}, {sinf(angle), 0, 0, cosf(angle)}, {0, 0, 0, 1}};
        figure_view(f, times, sizeof times);
        figure_view(f, turns, sizeof turns);
    }
    figure_view(f, test_png, sizeof test_png);
    const uint32_t count = f->views - 1;
    figure_add(f, "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1]}],\"buffers\":[{\"byteLength\":%zu}],\"bufferViews\":[%s],\"accessors\":[", f->size, f->view_text);
    figure_add(f, "{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":%u},{\"bufferView\":1,\"componentType\":5126,\"type\":\"VEC3\",\"count\":%u},", vertices, vertices);
    figure_add(f, "{\"bufferView\":2,\"componentType\":5126,\"type\":\"VEC2\",\"count\":%u},{\"bufferView\":3,\"componentType\":5121,\"type\":\"VEC4\",\"count\":%u},", vertices, vertices);
    figure_add(f, "{\"bufferView\":4,\"componentType\":5126,\"type\":\"VEC4\",\"count\":%u},{\"bufferView\":5,\"componentType\":5123,\"type\":\"SCALAR\",\"count\":%u},", vertices, corners);
    figure_add(f, "{\"bufferView\":6,\"componentType\":5126,\"type\":\"MAT4\",\"count\":%u}", figure->joints);
    for (uint32_t a = 0; a < figure->animations; a++)
        figure_add(f, ",{\"bufferView\":%u,\"componentType\":5126,\"type\":\"SCALAR\",\"count\":%d},{\"bufferView\":%u,\"componentType\":5126,\"type\":\"VEC4\",\"count\":%d}", TIMES + 2 * a, KEYS,
                   TIMES + 2 * a + 1, KEYS);
    figure_add(f, "],\"images\":[{\"bufferView\":%u,\"mimeType\":\"image/png\"}],\"textures\":[{\"source\":0}],\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0},", count);
    figure_add(f, "\"metallicFactor\":0,\"roughnessFactor\":0.6}}],\"meshes\":[{\"primitives\":[{\"material\":0,\"indices\":5,\"attributes\":{\"POSITION\":0,\"NORMAL\":1,");
    figure_add(f, "\"TEXCOORD_0\":2,\"JOINTS_0\":3,\"WEIGHTS_0\":4}}]}],\"skins\":[{\"inverseBindMatrices\":6,\"joints\":[");
    for (uint32_t i = 0; i < figure->joints; i++) figure_add(f, "%s%u", i ? "," : "", 1 + i);
    figure_add(f, "]}],\"nodes\":[{\"mesh\":0,\"skin\":0}");
    for (uint32_t i = 0; i < figure->joints; i++) {
        const vec3 at = figure_at(figure, (float)i / (float)(figure->joints - 1), 0, 0), up = i ? figure_at(figure, (float)(i - 1) / (float)(figure->joints - 1), 0, 0) : vec3_make(0, 0, 0);
        figure_add(f, ",{\"translation\":[%.9g,%.9g,%.9g]", (double)(at.x - up.x), (double)(at.y - up.y), (double)(at.z - up.z));
        figure_add(f, i + 1 < figure->joints ? ",\"children\":[%u]}" : "}", i + 2);
    }
    figure_add(f, "],\"animations\":[");
    for (uint32_t a = 0; a < figure->animations; a++) {
        figure_add(f, "%s{\"samplers\":[{\"input\":%u,\"output\":%u}],\"channels\":[", a ? "," : "", TIMES + 2 * a, TIMES + 2 * a + 1);
        for (uint32_t i = 1; i < figure->joints; i++) figure_add(f, "%s{\"sampler\":0,\"target\":{\"node\":%u,\"path\":\"rotation\"}}", i > 1 ? "," : "", 1 + i);
        figure_add(f, "]}");
    }
    figure_add(f, "]}");
    unsigned char *glb = test_glb(f->json, f->bytes, f->size, size);
    free(f->bytes);
    free(f);
    return glb;
}

#endif
