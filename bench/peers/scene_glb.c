/* SPDX-License-Identifier: MIT */
/*
 * Writes a built-in scene as a binary glTF 2.0 file, so that other renderers can be measured with it: scene_glb builtin:hall?lights=256 hall.glb
 * Meshes, materials with their pictures as PNG, instances as nodes, cameras, and lights after KHR_lights_punctual. What glTF has no words for
 * (capsules, wedges and boxes, skins, decals) is refused rather than left out. Ambient light and background are not in the file either:
 * they are printed, and a renderer is given them by hand (README.md).
 */
#include "base/base.h"
#include "scene/scene.h"

#include <jansson.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

struct glb {
    const fnl_scene *scene;
    json_t *root, *accessors, *views, *nodes, *images, *textures, *materials, *meshes, *lights, *cameras, *samplers, *extensions;
    char *bytes;
    size_t size, capacity;
    int32_t *image_of, *material_of, *mesh_of; /* of the scene's, in the file; -1: not there yet */
};

enum { BYTE_LENGTH_MAX = 0x7fffffff, TARGET_VERTICES = 34962, TARGET_INDICES = 34963, FLOATS = 5126, UINT16S = 5123, UINT32S = 5125 };

static void fail(const char *what) {
    fprintf(stderr, "scene_glb: %s\n", what);
    exit(2);
}

static int append(json_t *array, json_t *element) {
    if (!element || json_array_append_new(array, element) != 0) fail("memory ran out");
    return (int)json_array_size(array) - 1;
}

/* ---- the binary part ---- */

static int add_view(struct glb *g, const void *bytes, size_t size, int target) {
    size_t at = (g->size + 3) & ~(size_t)3;
    if (at + size > BYTE_LENGTH_MAX) fail("the scene takes more than 2 GiB");
    if (at + size > g->capacity) {
        g->capacity = 2 * (at + size);
        g->bytes = realloc(g->bytes, g->capacity);
        if (!g->bytes) fail("memory ran out");
    }
    memset(g->bytes + g->size, 0, at - g->size);
    memcpy(g->bytes + at, bytes, size);
    g->size = at + size;
    json_t *view = json_pack("{s:i,s:I,s:I}", "buffer", 0, "byteOffset", (json_int_t)at, "byteLength", (json_int_t)size);
    if (target) json_object_set_new(view, "target", json_integer(target));
    return append(g->views, view);
}

static int add_accessor(struct glb *g, const void *bytes, size_t size, uint32_t count, int component, const char *type, int target) {
    return append(g->accessors, json_pack("{s:i,s:i,s:I,s:s}", "bufferView", add_view(g, bytes, size, target), "componentType", component, "count",
                                          (json_int_t)count, "type", type));
}

static int add_vectors(struct glb *g, const void *vectors, uint32_t count, int width) {
    static const char *const types[] = {"", "", "VEC2", "VEC3", "VEC4"};
    return add_accessor(g, vectors, (size_t)count * (size_t)width * sizeof(float), count, FLOATS, types[width], TARGET_VERTICES);
}

static int add_indices(struct glb *g, const struct scene_primitive *p) {
    if (p->vertex_count > UINT16_MAX) /* 65535 ends strips in some programs */
        return add_accessor(g, p->indices, p->index_count * sizeof(uint32_t), p->index_count, UINT32S, "SCALAR", TARGET_INDICES);
    uint16_t *narrow = malloc(MAX(p->index_count, 1u) * sizeof *narrow);
    if (!narrow) fail("memory ran out");
    for (uint32_t i = 0; i < p->index_count; i++) narrow[i] = (uint16_t)p->indices[i];
    int accessor = add_accessor(g, narrow, p->index_count * sizeof *narrow, p->index_count, UINT16S, "SCALAR", TARGET_INDICES);
    free(narrow);
    return accessor;
}

/* ---- what is in it ---- */

static json_t *numbers(const float *values, int count) {
    json_t *array = json_array();
    for (int i = 0; i < count; i++) append(array, json_real((double)values[i]));
    return array;
}

static void use_extension(struct glb *g, const char *name) {
    for (size_t i = 0; i < json_array_size(g->extensions); i++)
        if (strcmp(json_string_value(json_array_get(g->extensions, i)), name) == 0) return;
    append(g->extensions, json_string(name));
}

static int image_of(struct glb *g, uint32_t index) {
    const struct scene_image *image = &g->scene->images.data[index];
    if (g->image_of[index] >= 0) return g->image_of[index];
    if (!image->pixels) fail("an image has no pixels of its own: only built-in scenes can be written");
    char path[] = "/tmp/scene_glb-XXXXXX.png";
    int descriptor = mkstemps(path, 4);
    if (descriptor < 0) fail("/tmp cannot be written to");
    close(descriptor);
    const fnl_image picture = {.width = image->width, .height = image->height, .format = FNL_PIXEL_FORMAT_RGBA8, .pixels = image->pixels};
    bool saved = fnl_image_save(NULL, path, &picture) == FNL_OK;
    FILE *file = saved ? fopen(path, "rb") : NULL;
    char *bytes = file && fseek(file, 0, SEEK_END) == 0 ? malloc((size_t)ftell(file) + 1) : NULL;
    size_t size = bytes ? (size_t)ftell(file) : 0;
    if (file) rewind(file);
    bool read = bytes && fread(bytes, 1, size, file) == size;
    if (file) fclose(file);
    unlink(path);
    if (!read) fail("a picture could not be written to /tmp");
    int view = add_view(g, bytes, size, 0);
    free(bytes);
    return g->image_of[index] = append(g->images, json_pack("{s:i,s:s}", "bufferView", view, "mimeType", "image/png"));
}

static json_t *sampler_of(const struct scene_sampler *s) {
    enum { NEAREST = 9728, LINEAR = 9729, MIPMAPPED = 256, MIPMAPPED_LINEAR = 258 }; /* the mipmapped filters follow the plain ones */
    static const int wraps[] = {[SCENE_WRAP_REPEAT] = 10497, [SCENE_WRAP_MIRROR] = 33648, [SCENE_WRAP_CLAMP] = 33071};
    int min = s->min == SCENE_FILTER_LINEAR ? LINEAR : NEAREST;
    if (s->mipmapped) min += s->mip == SCENE_FILTER_LINEAR ? MIPMAPPED_LINEAR : MIPMAPPED;
    return json_pack("{s:i,s:i,s:i,s:i}", "magFilter", s->mag == SCENE_FILTER_LINEAR ? LINEAR : NEAREST, "minFilter", min, "wrapS", wraps[s->wrap_u],
                     "wrapT", wraps[s->wrap_v]);
}

static void set_texture(struct glb *g, json_t *object, const char *key, const struct scene_texture *texture) {
    const float *t = texture->transform;
    if (texture->image == SCENE_NONE) return;
    int index = append(g->textures, json_pack("{s:i,s:i}", "sampler", (int)texture->sampler, "source", image_of(g, texture->image)));
    json_t *info = json_pack("{s:i,s:i}", "index", index, "texCoord", (int)texture->uv_set);
    json_object_set_new(object, key, info);
    if (t[1] != 0 || t[3] != 0) fail("texture coordinates are turned");
    if (t[0] == 1 && t[4] == 1 && t[2] == 0 && t[5] == 0) return;
    use_extension(g, "KHR_texture_transform");
    json_object_set_new(info, "extensions", json_pack("{s:{s:[f,f],s:[f,f]}}", "KHR_texture_transform", "offset", (double)t[2], (double)t[5], "scale",
                                                      (double)t[0], (double)t[4]));
}

static int material_of(struct glb *g, uint32_t index) {
    const struct scene_material *m = &g->scene->materials.data[index];
    const struct scene_texture *t = m->textures;
    static const char *const modes[] = {[FNL_ALPHA_OPAQUE] = "OPAQUE", [FNL_ALPHA_MASK] = "MASK", [FNL_ALPHA_BLEND] = "BLEND"};
    if (g->material_of[index] >= 0) return g->material_of[index];
    json_t *pbr = json_object(), *material = json_pack("{s:s,s:s,s:b}", "name", m->name ? m->name : "", "alphaMode", modes[m->alpha_mode],
                                                       "doubleSided", m->double_sided), *extensions = json_object();
    json_object_set_new(pbr, "baseColorFactor", numbers(&m->base_color.x, 4));
    json_object_set_new(pbr, "metallicFactor", json_real((double)m->metallic));
    json_object_set_new(pbr, "roughnessFactor", json_real((double)m->roughness));
    set_texture(g, pbr, "baseColorTexture", &t[SCENE_TEXTURE_BASE_COLOR]);
    set_texture(g, pbr, "metallicRoughnessTexture", &t[SCENE_TEXTURE_METALLIC_ROUGHNESS]);
    json_object_set_new(material, "pbrMetallicRoughness", pbr);
    set_texture(g, material, "normalTexture", &t[SCENE_TEXTURE_NORMAL]);
    set_texture(g, material, "occlusionTexture", &t[SCENE_TEXTURE_OCCLUSION]);
    set_texture(g, material, "emissiveTexture", &t[SCENE_TEXTURE_EMISSIVE]);
    if (t[SCENE_TEXTURE_SPECULAR].image != SCENE_NONE || t[SCENE_TEXTURE_SPECULAR_COLOR].image != SCENE_NONE) fail("a material has specular textures");
    if (t[SCENE_TEXTURE_NORMAL].image != SCENE_NONE) json_object_set_new(json_object_get(material, "normalTexture"), "scale", json_real((double)m->normal_scale));
    if (t[SCENE_TEXTURE_OCCLUSION].image != SCENE_NONE)
        json_object_set_new(json_object_get(material, "occlusionTexture"), "strength", json_real((double)m->occlusion_strength));
    if (m->alpha_mode == FNL_ALPHA_MASK) json_object_set_new(material, "alphaCutoff", json_real((double)m->alpha_cutoff));
    /* Factors end at 1: what shines more has a strength. */
    float strength = fmaxf(fmaxf(m->emissive.x, m->emissive.y), fmaxf(m->emissive.z, 1));
    vec3 factor = vec3_scale(m->emissive, 1 / strength);
    json_object_set_new(material, "emissiveFactor", numbers(&factor.x, 3));
    if (strength > 1) {
        use_extension(g, "KHR_materials_emissive_strength");
        json_object_set_new(extensions, "KHR_materials_emissive_strength", json_pack("{s:f}", "emissiveStrength", (double)strength));
    }
    if (m->ior != 1.5f) {
        use_extension(g, "KHR_materials_ior");
        json_object_set_new(extensions, "KHR_materials_ior", json_pack("{s:f}", "ior", (double)m->ior));
    }
    if (m->specular != 1 || m->specular_color.x != 1 || m->specular_color.y != 1 || m->specular_color.z != 1) {
        use_extension(g, "KHR_materials_specular");
        json_object_set_new(extensions, "KHR_materials_specular",
                            json_pack("{s:f,s:o}", "specularFactor", (double)m->specular, "specularColorFactor", numbers(&m->specular_color.x, 3)));
    }
    if (m->unlit) {
        use_extension(g, "KHR_materials_unlit");
        json_object_set_new(extensions, "KHR_materials_unlit", json_object());
    }
    if (json_object_size(extensions)) json_object_set(material, "extensions", extensions);
    json_decref(extensions);
    return g->material_of[index] = append(g->materials, material);
}

static int mesh_of(struct glb *g, uint32_t index) {
    const struct scene_mesh *mesh = &g->scene->meshes.data[index];
    if (g->mesh_of[index] >= 0) return g->mesh_of[index];
    json_t *primitives = json_array();
    for (uint32_t i = 0; i < mesh->primitive_count; i++) {
        const struct scene_primitive *p = &g->scene->primitives.data[mesh->first_primitive + i];
        if (p->topology != SCENE_TOPOLOGY_TRIANGLES || p->joint_count || p->morph_target_count) fail("a mesh has joints, morph targets, lines or points");
        json_t *attributes = json_object();
        int position = add_vectors(g, p->positions, p->vertex_count, 3);
        struct box box = box_empty();
        for (uint32_t v = 0; v < p->vertex_count; v++) box_add_point(&box, p->positions[v]);
        json_object_set_new(json_array_get(g->accessors, (size_t)position), "min", numbers(&box.low.x, 3));
        json_object_set_new(json_array_get(g->accessors, (size_t)position), "max", numbers(&box.high.x, 3));
        json_object_set_new(attributes, "POSITION", json_integer(position));
        if (p->normals) json_object_set_new(attributes, "NORMAL", json_integer(add_vectors(g, p->normals, p->vertex_count, 3)));
        if (p->tangents) json_object_set_new(attributes, "TANGENT", json_integer(add_vectors(g, p->tangents, p->vertex_count, 4)));
        if (p->uv[0]) json_object_set_new(attributes, "TEXCOORD_0", json_integer(add_vectors(g, p->uv[0], p->vertex_count, 2)));
        if (p->uv[1]) json_object_set_new(attributes, "TEXCOORD_1", json_integer(add_vectors(g, p->uv[1], p->vertex_count, 2)));
        if (p->colors) json_object_set_new(attributes, "COLOR_0", json_integer(add_vectors(g, p->colors, p->vertex_count, 4)));
        json_t *primitive = json_pack("{s:o,s:i}", "attributes", attributes, "indices", add_indices(g, p));
        if (p->material != SCENE_NONE) json_object_set_new(primitive, "material", json_integer(material_of(g, p->material)));
        append(primitives, primitive);
    }
    return g->mesh_of[index] = append(g->meshes, json_pack("{s:o}", "primitives", primitives));
}

static void add_node(struct glb *g, const mat4 *matrix, const char *key, json_t *value) {
    json_t *node = json_pack("{s:o,s:o}", "matrix", numbers(&matrix->m[0], 16), key, value);
    append(g->nodes, node);
}

/* A pose whose -Z looks along `direction`. */
static mat4 pose(vec3 position, vec3 direction, vec3 up) {
    vec3 back = vec3_scale(vec3_normalize(direction), -1);
    if (vec3_length(vec3_cross(up, back)) < 1e-3f) up = fabsf(back.y) < 0.9f ? vec3_make(0, 1, 0) : vec3_make(1, 0, 0);
    vec3 side = vec3_normalize(vec3_cross(up, back)), top = vec3_cross(back, side);
    return (mat4){{side.x, side.y, side.z, 0, top.x, top.y, top.z, 0, back.x, back.y, back.z, 0, position.x, position.y, position.z, 1}};
}

static void add_light(struct glb *g, const fnl_light_params *light) {
    static const char *const kinds[] = {[FNL_LIGHT_DIRECTIONAL] = "directional", [FNL_LIGHT_POINT] = "point", [FNL_LIGHT_SPOT] = "spot"};
    if (light->kind > FNL_LIGHT_SPOT) fail("the scene has capsules, wedges or boxes, which KHR_lights_punctual lacks");
    json_t *object = json_pack("{s:s,s:o,s:f}", "type", kinds[light->kind], "color", numbers(light->color, 3), "intensity", (double)light->intensity);
    if (light->kind != FNL_LIGHT_DIRECTIONAL && isfinite(light->range)) json_object_set_new(object, "range", json_real((double)light->range));
    if (light->kind == FNL_LIGHT_SPOT)
        json_object_set_new(object, "spot", json_pack("{s:f,s:f}", "innerConeAngle", (double)light->inner_cone_angle, "outerConeAngle",
                                                      (double)light->outer_cone_angle));
    mat4 matrix = light->kind == FNL_LIGHT_POINT ? pose(light->position, vec3_make(0, 0, -1), vec3_make(0, 1, 0))
                                                 : pose(light->position, light->direction, vec3_make(0, 1, 0));
    use_extension(g, "KHR_lights_punctual");
    add_node(g, &matrix, "extensions", json_pack("{s:{s:i}}", "KHR_lights_punctual", "light", append(g->lights, object)));
}

static void add_all(struct glb *g) {
    const fnl_scene *scene = g->scene;
    if (scene->skins.count || scene_entity_count(scene, FNL_ENTITY_DECAL)) fail("the scene has skins or decals");
    for (uint32_t i = 0; i < scene->samplers.count; i++) append(g->samplers, sampler_of(&scene->samplers.data[i]));
    for (uint32_t i = 0; i < scene->cameras.count; i++) {
        fnl_camera camera;
        if (fnl_scene_query_camera(scene, i, &camera) != FNL_OK) fail("a camera has no pose");
        mat4 matrix = pose(camera.position, vec3_sub(camera.target, camera.position), camera.up);
        if (camera.orthographic) fail("a camera is orthographic");
        int index = append(g->cameras, json_pack("{s:s,s:{s:f,s:f}}", "type", "perspective", "perspective", "yfov", (double)camera.vertical_fov,
                                                 "znear", (double)camera.near_distance));
        add_node(g, &matrix, "camera", json_integer(index));
    }
    for (uint32_t n = 0; n < scene->nodes.count; n++) {
        const struct scene_node *node = &scene->nodes.data[n];
        if (node->removed || !node->active || node->mesh == SCENE_NONE) continue;
        for (uint32_t k = 0; k < node->instance_count; k++) {
            mat4 matrix = node->instances ? mat4_mul(node->world, node->instances[k]) : node->world;
            add_node(g, &matrix, "mesh", json_integer(mesh_of(g, node->mesh)));
        }
    }
    for (uint32_t i = 0; i < scene->lights.count; i++)
        if (!scene->lights.data[i].removed) add_light(g, &scene->lights.data[i].params);
}

/* ---- the file ---- */

static void set_if_any(struct glb *g, const char *key, json_t *array) {
    if (json_array_size(array)) json_object_set(g->root, key, array);
}

static void write_chunk(FILE *file, uint32_t type, const char *bytes, size_t size, char padding) {
    uint32_t padded = (uint32_t)((size + 3) & ~(size_t)3), head[2] = {padded, type};
    fwrite(head, sizeof head, 1, file);
    fwrite(bytes, 1, size, file);
    for (; size < padded; size++) fputc(padding, file);
}

static void save(struct glb *g, const char *path) {
    json_t *roots = json_array();
    for (size_t i = 0; i < json_array_size(g->nodes); i++) append(roots, json_integer((json_int_t)i));
    g->root = json_pack("{s:{s:s,s:s},s:i,s:[{s:o}],s:[{s:I}]}", "asset", "version", "2.0", "generator", "Fanal scene_glb", "scene", 0, "scenes",
                        "nodes", roots, "buffers", "byteLength", (json_int_t)g->size);
    set_if_any(g, "samplers", g->samplers);
    set_if_any(g, "accessors", g->accessors);
    set_if_any(g, "bufferViews", g->views);
    set_if_any(g, "nodes", g->nodes);
    set_if_any(g, "images", g->images);
    set_if_any(g, "textures", g->textures);
    set_if_any(g, "materials", g->materials);
    set_if_any(g, "meshes", g->meshes);
    set_if_any(g, "cameras", g->cameras);
    set_if_any(g, "extensionsUsed", g->extensions);
    if (json_array_size(g->lights))
        json_object_set_new(g->root, "extensions", json_pack("{s:{s:O}}", "KHR_lights_punctual", "lights", g->lights));
    char *text = json_dumps(g->root, JSON_COMPACT | JSON_REAL_PRECISION(9)), part[4096];
    FILE *file = snprintf(part, sizeof part, "%s.part", path) < (int)sizeof part ? fopen(part, "wb") : NULL;
    if (!text || !file) fail("the file cannot be written");
    size_t length = strlen(text), total = 12 + 8 + ((length + 3) & ~(size_t)3) + 8 + ((g->size + 3) & ~(size_t)3);
    const uint32_t head[3] = {0x46546c67, 2, (uint32_t)total};
    fwrite(head, sizeof head, 1, file);
    write_chunk(file, 0x4e4f534a, text, length, ' ');
    write_chunk(file, 0x004e4942, g->bytes, g->size, 0);
    bool good = !ferror(file);
    good = fclose(file) == 0 && good && rename(part, path) == 0;
    if (!good) unlink(part);
    if (!good) fail("the file cannot be written");
    free(text);
}

static int32_t *unknown(uint32_t count) {
    int32_t *places = malloc(MAX(count, 1u) * sizeof *places);
    if (!places) fail("memory ran out");
    for (uint32_t i = 0; i < count; i++) places[i] = -1;
    return places;
}

int main(int argc, char **argv) {
    fnl_scene *scene;
    if (argc != 3 || strncmp(argv[1], "builtin:", 8) != 0) {
        fputs("usage: scene_glb builtin:NAME[?OPTIONS] FILE.glb\n", stderr);
        return 2;
    }
    if (fnl_scene_load(NULL, argv[1], NULL, &scene) != FNL_OK) return 2; /* the log has said why */
    struct glb g = {.scene = scene, .accessors = json_array(), .views = json_array(), .nodes = json_array(), .images = json_array(),
                    .textures = json_array(), .materials = json_array(), .meshes = json_array(), .lights = json_array(),
                    .cameras = json_array(), .samplers = json_array(), .extensions = json_array(), .image_of = unknown(scene->images.count),
                    .material_of = unknown(scene->materials.count), .mesh_of = unknown(scene->meshes.count)};
    add_all(&g);
    save(&g, argv[2]);
    const vec3 *colors[] = {&scene->ambient_sky, &scene->ambient_ground, &scene->background};
    static const char *const names[] = {"ambient from above", "ambient from below", "background"};
    for (size_t i = 0; i < COUNT_OF(colors); i++)
        printf("%s: %g %g %g cd/m2\n", names[i], (double)colors[i]->x, (double)colors[i]->y, (double)colors[i]->z);
    json_t *all[] = {g.root, g.accessors, g.views, g.nodes, g.images, g.textures, g.materials, g.meshes, g.lights, g.cameras, g.samplers, g.extensions};
    for (size_t i = 0; i < COUNT_OF(all); i++) json_decref(all[i]);
    free(g.bytes);
    free(g.image_of);
    free(g.material_of);
    free(g.mesh_of);
    fnl_scene_destroy(&scene);
    return 0;
}
