/* SPDX-License-Identifier: MIT */
/* fnl_scene_save: the call, the JSON, and the binary file (glTF 2.0, 4.4). */
#include "scene/glb.h"

#include "base/check.h"

#define GLB_MAGIC 0x46546c67u
#define GLB_CHUNK_JSON 0x4e4f534au
#define GLB_CHUNK_BIN 0x004e4942u

/* ---- messages and memory ---- */

void glb_fail(struct glb *g, fnl_result result, const char *format, ...) {
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    text_format_list(text, sizeof text, format, arguments);
    va_end(arguments);
    if (g->result == FNL_OK) log_error(g->host, "%s: %s; it is not written", g->path, text);
    if (g->result == FNL_OK) g->result = result;
}

void glb_left_out(const struct glb *g, const char *format, ...) {
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    text_format_list(text, sizeof text, format, arguments);
    va_end(arguments);
    log_warning(g->host, "%s: left out: %s", g->path, text);
}

static void fail_memory(struct glb *g) {
    if (g->result == FNL_OK) glb_fail(g, FNL_ERROR_MEMORY, "memory ran out");
}

void *glb_memory(struct glb *g, uint64_t count, size_t size) {
    void *block = count > (SIZE_MAX >> 1) / size ? NULL : arena_allocate_zero(&g->memory, (size_t)MAX(count, 1) * size);
    if (!block) fail_memory(g);
    return block;
}

/* ---- JSON ---- */

json_t *glb_text(const struct glb *g, const char *text) {
    json_t *json = json_string(text);
    char *copy = json ? NULL : host_allocate(g->host, strlen(text) + 1);
    if (!copy) return json;
    strcpy(copy, text);
    fnl_text_clean(copy);
    json = json_string(copy);
    glb_left_out(g, "bytes of the name '%s' that are not UTF-8", copy);
    host_free(g->host, copy, strlen(text) + 1);
    return json;
}

/* The shortest text of a float that reads as it again makes the double that is written. */
json_t *glb_float(float value) {
    char text[32];
    for (int digits = 6; digits <= 9; digits++) {
        text_format(text, sizeof text, "%.*g", digits, (double)value);
        if ((float)number_read(text, NULL) == value) break;
    }
    return json_real(number_read(text, NULL));
}

json_t *glb_floats(const float *values, uint32_t count) {
    json_t *array = json_array();
    for (uint32_t i = 0; i < count; i++)
        if (!array || json_array_append_new(array, glb_float(values[i])) != 0) {
            json_decref(array);
            return NULL;
        }
    return array;
}

json_t *glb_doubles(const double *values, uint32_t count) {
    json_t *array = json_array();
    for (uint32_t i = 0; i < count; i++) {
        const bool rounded = (double)(float)values[i] == values[i];
        if (!array || json_array_append_new(array, rounded ? glb_float((float)values[i]) : json_real(values[i])) != 0) {
            json_decref(array);
            return NULL;
        }
    }
    return array;
}

void glb_set(struct glb *g, json_t *object, const char *key, json_t *value) {
    if (json_object_set_new(object, key, value) != 0) fail_memory(g);
}

static json_t *made(struct glb *g, json_t *object, const char *key, json_t *(*make)(void), bool good) {
    if (!good) glb_set(g, object, key, make());
    return json_object_get(object, key);
}
json_t *glb_object(struct glb *g, json_t *object, const char *key) {
    return made(g, object, key, json_object, json_is_object(json_object_get(object, key)));
}
json_t *glb_array(struct glb *g, json_t *object, const char *key) {
    return made(g, object, key, json_array, json_is_array(json_object_get(object, key)));
}

json_t *glb_extension(struct glb *g, json_t *object, const char *name) {
    json_t *used = glb_array(g, g->root, "extensionsUsed");
    bool known = false;
    for (size_t i = 0; i < json_array_size(used) && !known; i++) {
        const char *text = json_string_value(json_array_get(used, i));
        known = text && strcmp(text, name) == 0;
    }
    if (!known) glb_append(g, used, json_string(name));
    return glb_object(g, glb_object(g, object, "extensions"), name);
}

void glb_remove_extension(json_t *object, const char *name) {
    json_t *extensions = json_object_get(object, "extensions");
    json_object_del(extensions, name);
    if (extensions && json_object_size(extensions) == 0) json_object_del(object, "extensions");
}

uint32_t glb_append(struct glb *g, json_t *array, json_t *value) {
    if (json_array_append_new(array, value) != 0) {
        fail_memory(g);
        return SCENE_NONE;
    }
    return (uint32_t)json_array_size(array) - 1;
}

uint32_t glb_add(struct glb *g, const char *array, json_t *value) { return glb_append(g, glb_array(g, g->root, array), value); }

void glb_set_name(struct glb *g, json_t *object, const char *name, const char *extras) {
    if (name && *name) glb_set(g, object, "name", glb_text(g, name));
    if (extras) glb_set(g, object, "extras", json_loads(extras, JSON_DECODE_ANY | JSON_ALLOW_NUL, NULL));
}

void glb_set_extra(struct glb *g, json_t *object, const char *name, json_t *value) {
    json_t *extras = json_object_get(object, "extras");
    if (json_is_object(value) ? json_object_size(value) > 0 : value != NULL) {
        if (extras && !json_is_object(extras)) glb_left_out(g, "extras that are no object");
        glb_set(g, glb_object(g, object, "extras"), name, value);
        return;
    }
    json_decref(value);
    if (json_object_get(extras, name)) json_object_del(extras, name);
    if (json_is_object(extras) && json_object_size(extras) == 0) json_object_del(object, "extras");
}

/* ---- what animations set ---- */

static bool animates(const struct glb *g, uint32_t node, enum scene_animation_path path, enum scene_property_owner owner, uint32_t object,
                     size_t offset) {
    for (uint32_t i = 0; g->file && i < g->file->animations.count; i++) {
        const struct scene_animation *animation = &g->file->animations.data[i];
        for (uint32_t k = 0; k < animation->channel_count; k++) {
            const struct scene_channel *c = &animation->channels[k];
            if (c->path == path && (path == SCENE_PATH_PROPERTY ? c->property && c->property->owner == owner && c->object == object && c->property->offset == offset
                                                                : c->node == node))
                return true;
        }
    }
    return false;
}
bool glb_animates_node(const struct glb *g, uint32_t node, enum scene_animation_path path) {
    return animates(g, node, path, SCENE_PROPERTY_MATERIAL, 0, 0);
}
bool glb_animates(const struct glb *g, enum scene_property_owner owner, uint32_t object, size_t offset) {
    return animates(g, SCENE_NONE, SCENE_PATH_PROPERTY, owner, object, offset);
}

/* ---- bytes ---- */

uint64_t glb_add_bytes(struct glb *g, const void *data, uint64_t size) {
    static const char zeros[4];
    const uint64_t place = align_up(g->size, 4), padding = place - g->size;
    const struct glb_part pad = {zeros, padding}, part = {data, size};
    if (place + size > g->max_size) {
        glb_fail(g, FNL_ERROR_UNSUPPORTED, "the file would have more than %u bytes", g->max_size);
        return 0;
    }
    if ((padding && !array_push(g->host, &g->parts, pad)) || !array_push(g->host, &g->parts, part)) fail_memory(g);
    g->size = place + size;
    return place;
}

uint32_t glb_add_view(struct glb *g, const void *data, uint64_t size, int target) {
    const uint64_t place = glb_add_bytes(g, data, size);
    json_t *view = json_pack("{s:i,s:I,s:I}", "buffer", 0, "byteOffset", (json_int_t)place, "byteLength", (json_int_t)size);
    if (target) glb_set(g, view, "target", json_integer(target));
    return glb_add(g, "bufferViews", view);
}

uint32_t glb_add_accessor(struct glb *g, const void *data, uint32_t count, enum gltf_component component, enum gltf_type type, int target) {
    static const char *const names[] = {"SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"};
    for (uint32_t i = 0; i < COUNT_OF(g->known); i++)
        if (g->known[i].data == data && g->known[i].count == count && g->known[i].type == type) return g->known[i].accessor;
    const uint64_t size = (uint64_t)count * gltf_component_size(component) * gltf_type_components(type);
    const uint32_t view = glb_add_view(g, data, size, target);
    const uint32_t index = glb_add(g, "accessors", json_pack("{s:i,s:i,s:I,s:s}", "bufferView", (int)view, "componentType", (int)component, "count",
                                                             (json_int_t)count, "type", names[type]));
    const uint32_t next = g->known_next++ % COUNT_OF(g->known);
    g->known[next].data = data;
    g->known[next].count = count;
    g->known[next].type = type;
    g->known[next].accessor = index;
    return index;
}

static void write_u32(FILE *stream, uint32_t value) {
    const unsigned char bytes[4] = {(unsigned char)value, (unsigned char)(value >> 8), (unsigned char)(value >> 16), (unsigned char)(value >> 24)};
    fwrite(bytes, 1, sizeof bytes, stream);
}

static void write_file(struct glb *g) {
    char *text = json_dumps(g->root, JSON_COMPACT);
    if (!text) {
        fail_memory(g);
        return;
    }
    const uint64_t length = strlen(text), json = align_up(length, 4), binary = align_up(g->size, 4), total = 12 + 8 + json + (binary ? 8 + binary : 0);
    struct file_writer writer = {0};
    if (total > g->max_size)
        glb_fail(g, FNL_ERROR_UNSUPPORTED, "the file would have %llu bytes, more than %u", (unsigned long long)total, g->max_size);
    else
        g->result = file_write_begin(g->host, g->path, &writer);
    if (g->result == FNL_OK) {
        write_u32(writer.stream, GLB_MAGIC);
        write_u32(writer.stream, 2);
        write_u32(writer.stream, (uint32_t)total);
        write_u32(writer.stream, (uint32_t)json);
        write_u32(writer.stream, GLB_CHUNK_JSON);
        fwrite(text, 1, length, writer.stream);
        for (uint64_t i = length; i < json; i++) fputc(' ', writer.stream);
        if (binary) {
            write_u32(writer.stream, (uint32_t)binary);
            write_u32(writer.stream, GLB_CHUNK_BIN);
        }
        for (uint32_t i = 0; i < g->parts.count; i++) fwrite(g->parts.data[i].data, 1, (size_t)g->parts.data[i].size, writer.stream);
        for (uint64_t i = g->size; i < binary; i++) fputc(0, writer.stream);
        g->result = file_write_commit(&writer);
    }
    free(text);
}

/* ---- the call ---- */

static uint32_t *places(struct glb *g, uint32_t count, uint32_t same) {
    uint32_t *out = glb_memory(g, count, sizeof *out);
    for (uint32_t i = 0; out && i < count; i++) out[i] = i < same ? i : SCENE_NONE;
    return out;
}

static uint32_t document_count(const struct glb *g, const char *key, uint32_t scene_count) {
    return MIN(gltf_count(json_object_get(g->root, key)), scene_count);
}

static void save(struct glb *g) {
    const fnl_scene *scene = g->scene;
    if (!g->root) g->root = json_pack("{s:{s:s,s:s}}", "asset", "version", "2.0", "generator", "Fanal");
    if (!g->root) fail_memory(g);
    g->node_count = document_count(g, "nodes", scene->nodes.count);
    g->mesh_count = document_count(g, "meshes", scene->meshes.count);
    g->material_count = document_count(g, "materials", scene->materials.count);
    g->image_count = document_count(g, "images", scene->images.count);
    g->sampler_count = document_count(g, "samplers", scene->samplers.count);
    g->skin_count = document_count(g, "skins", scene->skins.count);
    g->nodes = places(g, scene->nodes.count, g->node_count);
    g->meshes = places(g, scene->meshes.count, g->mesh_count);
    g->materials = places(g, scene->materials.count, g->material_count);
    g->images = places(g, scene->images.count, 0); /* glb_material.c sees which are as they were */
    g->samplers = places(g, scene->samplers.count, 0);
    g->skins = places(g, scene->skins.count, g->skin_count);
    static void (*const parts[])(struct glb *) = {glb_embed,      glb_save_materials,    glb_save_meshes,   glb_save_nodes,
                                                  glb_save_lights, glb_save_surroundings, glb_finish_buffers, write_file};
    for (size_t i = 0; i < COUNT_OF(parts) && g->result == FNL_OK; i++) parts[i](g);
}

fnl_save_params fnl_save_params_default(void) { return (fnl_save_params){.max_size = UINT32_MAX}; }

fnl_result fnl_scene_save(const fnl_scene *scene, const char *path, const fnl_save_params *params) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(check_pointer(CALL(&scene->host), "path", path));
    const fnl_save_params p = params ? *params : fnl_save_params_default();
    struct gltf_quiet_host quiet; /* what is wrong with the file was told when it was loaded */
    gltf_quiet_host_init(&quiet, &scene->host);
    fnl_scene *file = NULL;
    struct glb g = {.scene = scene, .host = &scene->host, .path = path, .max_size = p.max_size};
    if (scene->document.bytes) {
        g.result = gltf_load_again(&quiet.host, scene, &file, &g.root);
        if (g.result != FNL_OK) log_error(&scene->host, "%s: %s cannot be read again: %s; it is not written", path, scene->source, quiet.line);
        g.file = file;
    }
    arena_init(&g.memory, &scene->host, (size_t)64 << 10);
    if (g.result == FNL_OK) save(&g);
    arena_finish(&g.memory);
    for (uint32_t i = 0; i < g.pictures.count; i++) free(g.pictures.data[i]);
    array_free(g.host, &g.pictures);
    array_free(g.host, &g.textures);
    array_free(g.host, &g.parts);
    json_decref(g.root);
    fnl_scene_destroy(&file);
    return g.result;
}

const char *fnl_scene_source(const fnl_scene *scene, uint32_t index) {
    if (check_handle(__func__, "scene", scene) != FNL_OK) return NULL;
    for (uint32_t i = 0; i < scene->sources.count; i++)
        if (scene->sources.data[i].path && index-- == 0) return scene->sources.data[i].path;
    const char *environment = scene->environment.name;
    return index == 0 && environment && strncmp(environment, "builtin:", 8) != 0 ? environment : NULL;
}
