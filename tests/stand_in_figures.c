/* SPDX-License-Identifier: MIT */
/*
 * Animals and people. A tube of rings round a chain of joints, skinned to two joints each, with texture coordinates, a picture, and animations in which
 * every joint except the first turns.
 */
#include "tests/glb_build.h"
#include "tests/stand_in.h"

struct figure {
    const char *name; /* of the sample that it replaces */
    uint32_t rings, segments, joints, animations;
    float length, radius; /* in the sample's units */
    float turn;           /* of a joint, in radians */
    bool upright;         /* along Y, from 0; else along Z, on a height of two radii */
};

/** As many triangles as the samples have, or almost. The first animation is the longest, as in Fox.glb, and
 * curls the animal over its own back. */
static const struct figure figures[] = {{"Fox.glb", 48, 6, 24, 3, 150, 20, -0.07f, false}, {"CesiumMan.glb", 83, 28, 19, 1, 1.5f, 0.2f, 0.045f, true}};

static vec3 figure_at(const struct figure *figure, float along, float x, float y) {
    return figure->upright ? vec3_make(x, along * figure->length, y) : vec3_make(x, 2 * figure->radius + y, (along - 0.5f) * figure->length);
}

/** Bulges are in each other's shadow, and have upper sides, where decals from above show. */
static float figure_radius(const struct figure *figure, float along) {
    return figure->radius * (0.05f + 0.95f * sinf(3.1415927f * along)) * (1 + 0.3f * sinf(31.415927f * along));
}

static void figure_mesh(const struct figure *figure, struct glb *f, uint32_t *vertices, uint32_t *corners) {
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
            const float thick = figure_radius(figure, along), slope = (figure_radius(figure, along + 0.001f) - figure_radius(figure, along - 0.001f)) / 0.002f / figure->length;
            const float place = along * (float)(figure->joints - 1);
            const uint32_t i = r * across + s, joint = MIN((uint32_t)place, figure->joints - 2);
            positions[i] = figure_at(figure, along, thick * cosf(angle), thick * sinf(angle));
            normals[i] = vec3_normalize(figure->upright ? vec3_make(cosf(angle), -slope, sinf(angle)) : vec3_make(cosf(angle), sinf(angle), -slope));
            uv[i] = (vec2){(float)s / (float)figure->segments, along};
            joints[i][0] = (uint8_t)joint, joints[i][1] = (uint8_t)(joint + 1);
            weights[i] = (vec4){1 - (place - (float)joint), place - (float)joint, 0, 0};
            if (r == figure->rings || s == figure->segments) continue;
            const uint16_t a = (uint16_t)i, b = (uint16_t)(i + 1), c = (uint16_t)(i + across), d = (uint16_t)(c + 1);
            const uint16_t out[6] = {a, b, c, b, d, c}, turned[6] = {a, c, b, b, c, d};
            memcpy(indices + *corners, figure->upright ? turned : out, sizeof out);
            *corners += 6;
        }
    glb_view(f, positions, count * sizeof *positions);
    glb_view(f, normals, count * sizeof *normals);
    glb_view(f, uv, count * sizeof *uv);
    glb_view(f, joints, count * sizeof *joints);
    glb_view(f, weights, count * sizeof *weights);
    glb_view(f, indices, *corners * sizeof *indices);
    free(positions), free(normals), free(uv), free(joints), free(weights), free(indices);
}

static void figure_joints(const struct figure *figure, struct glb *f) {
    mat4 *inverse = calloc(figure->joints, sizeof *inverse);
    for (uint32_t i = 0; i < figure->joints; i++) {
        const vec3 at = figure_at(figure, (float)i / (float)(figure->joints - 1), 0, 0);
        inverse[i] = mat4_identity();
        inverse[i].m[12] = -at.x, inverse[i].m[13] = -at.y, inverse[i].m[14] = -at.z;
    }
    glb_view(f, inverse, figure->joints * sizeof *inverse);
    free(inverse);
}

unsigned char *stand_in_figure(const char *name, size_t *size) {
    enum { KEYS = 3, TIMES = 7 }; /* TIMES: the first accessor behind those of the mesh and the joints */
    const struct figure *figure = NULL;
    struct glb glb = {0}, *f = &glb;
    for (size_t i = 0; i < COUNT_OF(figures); i++)
        if (strcmp(figures[i].name, name) == 0) figure = &figures[i];
    if (!figure) return NULL;
    uint32_t vertices, corners;
    figure_mesh(figure, f, &vertices, &corners);
    figure_joints(figure, f);
    for (uint32_t a = 0; a < figure->animations; a++) {
        const float end = 1.2f + 1.1f * (float)(figure->animations - 1 - a), times[KEYS] = {0, 0.6f, end}, angle = (a % 2 ? -figure->turn : figure->turn) / 2;
        const vec4 turns[KEYS] = {{0, 0, 0, 1}, {sinf(angle), 0, 0, cosf(angle)}, {0, 0, 0, 1}};
        glb_view(f, times, sizeof times);
        glb_view(f, turns, sizeof turns);
    }
    glb_view(f, test_png, sizeof test_png);
    const uint32_t count = f->view_count - 1;
    glb_begin_json(f);
    glb_add(&f->json, ",\"scene\":0,\"scenes\":[{\"nodes\":[0,1]}],\"accessors\":[");
    glb_add(&f->json, "{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":%u},{\"bufferView\":1,\"componentType\":5126,\"type\":\"VEC3\",\"count\":%u},", vertices, vertices);
    glb_add(&f->json, "{\"bufferView\":2,\"componentType\":5126,\"type\":\"VEC2\",\"count\":%u},{\"bufferView\":3,\"componentType\":5121,\"type\":\"VEC4\",\"count\":%u},", vertices, vertices);
    glb_add(&f->json, "{\"bufferView\":4,\"componentType\":5126,\"type\":\"VEC4\",\"count\":%u},{\"bufferView\":5,\"componentType\":5123,\"type\":\"SCALAR\",\"count\":%u},", vertices, corners);
    glb_add(&f->json, "{\"bufferView\":6,\"componentType\":5126,\"type\":\"MAT4\",\"count\":%u}", figure->joints);
    for (uint32_t a = 0; a < figure->animations; a++)
        glb_add(&f->json, ",{\"bufferView\":%u,\"componentType\":5126,\"type\":\"SCALAR\",\"count\":%d},{\"bufferView\":%u,\"componentType\":5126,\"type\":\"VEC4\",\"count\":%d}", TIMES + 2 * a, KEYS,
                   TIMES + 2 * a + 1, KEYS);
    glb_add(&f->json, "],\"images\":[{\"bufferView\":%u,\"mimeType\":\"image/png\"}],\"textures\":[{\"source\":0}],\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0},", count);
    glb_add(&f->json, "\"metallicFactor\":0,\"roughnessFactor\":0.6}}],\"meshes\":[{\"primitives\":[{\"material\":0,\"indices\":5,\"attributes\":{\"POSITION\":0,\"NORMAL\":1,");
    glb_add(&f->json, "\"TEXCOORD_0\":2,\"JOINTS_0\":3,\"WEIGHTS_0\":4}}]}],\"skins\":[{\"inverseBindMatrices\":6,\"joints\":[");
    for (uint32_t i = 0; i < figure->joints; i++) glb_add(&f->json, "%s%u", i ? "," : "", 1 + i);
    glb_add(&f->json, "]}],\"nodes\":[{\"mesh\":0,\"skin\":0}");
    for (uint32_t i = 0; i < figure->joints; i++) {
        const vec3 at = figure_at(figure, (float)i / (float)(figure->joints - 1), 0, 0), up = i ? figure_at(figure, (float)(i - 1) / (float)(figure->joints - 1), 0, 0) : vec3_make(0, 0, 0);
        glb_add(&f->json, ",{\"translation\":[%.9g,%.9g,%.9g]", (double)(at.x - up.x), (double)(at.y - up.y), (double)(at.z - up.z));
        glb_add(&f->json, i + 1 < figure->joints ? ",\"children\":[%u]}" : "}", i + 2);
    }
    glb_add(&f->json, "],\"animations\":[");
    for (uint32_t a = 0; a < figure->animations; a++) {
        glb_add(&f->json, "%s{\"samplers\":[{\"input\":%u,\"output\":%u}],\"channels\":[", a ? "," : "", TIMES + 2 * a, TIMES + 2 * a + 1);
        for (uint32_t i = 1; i < figure->joints; i++) glb_add(&f->json, "%s{\"sampler\":0,\"target\":{\"node\":%u,\"path\":\"rotation\"}}", i > 1 ? "," : "", 1 + i);
        glb_add(&f->json, "]}");
    }
    glb_add(&f->json, "]}");
    return glb_finish(f, size);
}
