/* SPDX-License-Identifier: MIT */
/* glTF 2.0 import: containers, JSON, and the order of the parts. Section numbers are those of the glTF 2.0 specification. */
#include "scene/gltf.h"

#include "scene/scene_format.h"

#define GLB_MAGIC 0x46546c67u
#define GLB_CHUNK_JSON 0x4e4f534au
#define GLB_CHUNK_BIN 0x004e4942u

static uint32_t read_u32(const unsigned char *bytes) {
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

/* ---- JSON ---- */

/**
 * Replaces the number that ends before `position` by null and spaces. Jansson refuses numbers beyond double's range; as
 * null they are reported where they are used, with their JSON pointer.
 */
static bool blank_number(char *text, size_t position) {
    size_t end = position, start = position;
    while (start > 0 && text[start - 1] && strchr("0123456789+-.eE", text[start - 1])) start--;
    if (end - start < 4) return false;
    memset(text + start, ' ', end - start);
    memcpy(text + start, "null", 4);
    return true;
}

static void report_syntax(struct gltf *g, const json_error_t *error) {
    gltf_fail(g, FNL_ERROR_FORMAT, &g->top, "is not JSON: line %d, column %d: %s", error->line, error->column, error->text);
}

static void parse_json(struct gltf *g, const char *text, size_t size) {
    static const char byte_order_mark[] = "\xef\xbb\xbf";
    if (size >= 3 && memcmp(text, byte_order_mark, 3) == 0) {
        gltf_warn(g, &g->top, "begins with a byte order mark, which glTF forbids; it is skipped");
        text += 3;
        size -= 3;
    }
    const size_t flags = JSON_ALLOW_NUL;
    json_error_t error;
    g->root = json_loadb(text, size, flags, &error);
    if (!g->root && json_error_code(&error) == json_error_numeric_overflow) {
        char *patched = host_allocate(g->host, size);
        if (!patched) {
            gltf_fail_memory(g);
            return;
        }
        memcpy(patched, text, size);
        for (int i = 0; i < 64 && !g->root && json_error_code(&error) == json_error_numeric_overflow; i++) {
            if (error.position < 0 || (size_t)error.position > size || !blank_number(patched, (size_t)error.position)) break;
            g->root = json_loadb(patched, size, flags, &error);
        }
        host_free(g->host, patched, size);
    }
    if (!g->root && json_error_code(&error) == json_error_out_of_memory) {
        gltf_fail_memory(g);
    } else if (!g->root) {
        report_syntax(g, &error);
    } else if (!json_is_object(g->root)) {
        gltf_fail(g, FNL_ERROR_FORMAT, &g->top, "is not a JSON object");
    }
}

/* ---- GLB (4.4) ---- */

static bool parse_glb(struct gltf *g, const unsigned char *bytes, size_t size, const char **json, size_t *json_size) {
    if (size < 12) {
        gltf_fail(g, FNL_ERROR_FORMAT, &g->top, "is truncated: a GLB header has 12 bytes, the file has %zu", size);
        return false;
    }
    uint32_t version = read_u32(bytes + 4), length = read_u32(bytes + 8);
    if (version != 2) {
        gltf_fail(g, FNL_ERROR_UNSUPPORTED, &g->top, "is GLB version %u; only version 2 can be read", version);
        return false;
    }
    if (length > size) {
        gltf_fail(g, FNL_ERROR_FORMAT, &g->top, "is truncated: the GLB header says %u bytes, the file has %zu", length,
                  size);
        return false;
    }
    if (length < size)
        gltf_warn(g, &g->top, "goes on for %zu bytes after the end of the GLB; they are ignored", size - length);
    *json = NULL;
    uint32_t number = 0;
    for (uint64_t offset = 12; offset < length; number++) {
        if (length - offset < 8) {
            gltf_fail(g, FNL_ERROR_FORMAT, &g->top, "GLB chunk %u: its header at byte %llu is truncated", number,
                      (unsigned long long)offset);
            return false;
        }
        uint32_t chunk_size = read_u32(bytes + offset), type = read_u32(bytes + offset + 4);
        offset += 8;
        if (chunk_size > length - offset) {
            gltf_fail(g, FNL_ERROR_FORMAT, &g->top, "GLB chunk %u: has %u bytes, but only %llu are left in the file", number,
                      chunk_size, (unsigned long long)(length - offset));
            return false;
        }
        if (number == 0 && type != GLB_CHUNK_JSON) {
            gltf_fail(g, FNL_ERROR_FORMAT, &g->top, "the first GLB chunk must be JSON, but is of type 0x%08x", type);
            return false;
        }
        if (number == 0) {
            *json = (const char *)bytes + offset;
            *json_size = chunk_size;
            if (chunk_size == 0) gltf_warn(g, &g->top, "the JSON chunk of the GLB is empty");
        } else if (type == GLB_CHUNK_BIN && number == 1) {
            g->binary = bytes + offset;
            g->binary_size = chunk_size;
        } else if (type == GLB_CHUNK_BIN || type == GLB_CHUNK_JSON) {
            gltf_warn(g, &g->top, "GLB chunk %u: a second JSON chunk, or a BIN chunk that is not the second; it is ignored",
                      number);
        }
        offset += chunk_size;
    }
    if (!*json) gltf_fail(g, FNL_ERROR_FORMAT, &g->top, "the GLB has no chunks");
    uint32_t zeros = 0;
    for (; *json && zeros < 3 && zeros + 1 < *json_size && (*json)[*json_size - 1 - zeros] == 0;) zeros++;
    if (zeros) gltf_warn(g, &g->top, "the JSON chunk of the GLB is padded with zeros instead of spaces; they are skipped");
    *json_size -= zeros;
    return *json != NULL;
}

/* ---- asset (3.2) ---- */

static bool parse_version(const char *text, int *major, int *minor) {
    int used = 0;
    if (!text || text[strspn(text, "0123456789.")]) return false; /* %d takes blanks and signs too */
    return sscanf(text, "%9d.%9d%n", major, minor, &used) == 2 && text[used] == 0;
}

static void check_asset(struct gltf *g) {
    json_t *asset = json_object_get(g->root, "asset");
    const struct at *at = AT_KEY(&g->top, "asset");
    if (!json_is_object(asset)) {
        gltf_fail(g, FNL_ERROR_FORMAT, asset ? at : &g->top,
                  asset ? "is not an object" : "has no 'asset', so is not glTF 2.0");
        return;
    }
    int major, minor, needed_major = 2, needed_minor = 0;
    const char *version = json_string_value(json_object_get(asset, "version"));
    if (!parse_version(version, &major, &minor)) {
        gltf_fail(g, FNL_ERROR_FORMAT, AT_KEY(at, "version"), "is not a version such as \"2.0\"");
        return;
    }
    if (major != 2) {
        gltf_fail(g, FNL_ERROR_UNSUPPORTED, AT_KEY(at, "version"), "is %s; only glTF 2 can be read", version);
        return;
    }
    if (minor > 0) gltf_warn(g, AT_KEY(at, "version"), "is %s; it is read as 2.0", version);
    json_t *needed = json_object_get(asset, "minVersion");
    if (!needed) return;
    if (!parse_version(json_string_value(needed), &needed_major, &needed_minor))
        gltf_fail(g, FNL_ERROR_FORMAT, AT_KEY(at, "minVersion"), "is not a version such as \"2.0\"");
    else if (needed_major > major || (needed_major == major && needed_minor > minor))
        gltf_fail(g, FNL_ERROR_FORMAT, AT_KEY(at, "minVersion"), "is greater than the version of the file");
    else if (needed_major != 2 || needed_minor > 0)
        gltf_warn(g, AT_KEY(at, "minVersion"), "is %s; the file is read as 2.0 and may look wrong",
                  json_string_value(needed));
}

/* ---- the whole ---- */

static void tell_progress(struct gltf *g) {
    if (g->result != FNL_OK || !g->params.progress) return;
    if (!g->params.progress(g->params.user, g->steps_done, g->steps_total)) g->result = FNL_ERROR_CANCELLED;
}

void gltf_step(struct gltf *g) {
    g->steps_done++;
    tell_progress(g);
}

static void load_parts(struct gltf *g) {
    static void (*const parts[])(struct gltf *) = {
        check_asset,      gltf_load_extensions, gltf_load_buffers,     gltf_load_accessors, gltf_load_compressed, gltf_load_images,
        gltf_load_materials, gltf_load_variants, gltf_load_meshes,     gltf_load_cameras,   gltf_load_nodes,      gltf_load_levels, gltf_load_scenes,
        gltf_load_skins,  gltf_place,           gltf_load_decals,      gltf_load_animations, gltf_load_environment, gltf_load_surroundings, gltf_load_xmp,
        gltf_load_material_levels,
    };
    static const char *const counted[] = {"buffers", "images", "meshes", "animations"}; /* whose loaders call gltf_step */
    uint64_t total = COUNT_OF(parts);
    for (size_t i = 0; i < COUNT_OF(counted); i++) total += gltf_count(json_object_get(g->root, counted[i]));
    g->steps_total = (uint32_t)MIN(total, UINT32_MAX);
    tell_progress(g);
    for (size_t i = 0; i < COUNT_OF(parts) && g->result == FNL_OK; i++) {
        parts[i](g);
        if (i + 1 == COUNT_OF(parts) && g->result == FNL_OK) scene_update_transforms(g->scene);
        gltf_step(g);
    }
}

/** What fnl_scene_save needs to write the file again. */
static void keep_document(struct gltf *g, const unsigned char *bytes, size_t size) {
    struct scene_document *document = &g->scene->document;
    const fnl_scene *scene = g->scene;
    *document = (struct scene_document){.bytes = bytes,
                                        .size = size,
                                        .lenient = g->params.lenient,
                                        .buffers = gltf_keep(g, g->buffer_count, sizeof *document->buffers),
                                        .buffer_count = g->buffer_count,
                                        .counts = {[SCENE_IMAGES] = scene->images.count,
                                                   [SCENE_SAMPLERS] = scene->samplers.count,
                                                   [SCENE_MATERIALS] = scene->materials.count,
                                                   [SCENE_PRIMITIVES] = scene->primitives.count,
                                                   [SCENE_MESHES] = scene->meshes.count,
                                                   [SCENE_ANIMATIONS] = scene->animations.count,
                                                   [SCENE_CAMERAS] = scene->cameras.count}};
    for (uint32_t i = 0; i < g->buffer_count && document->buffers; i++)
        if (g->buffers[i].valid && g->buffers[i].data) document->buffers[i] = (struct scene_buffer){g->buffers[i].data, g->buffers[i].size};
}

/** Loads into an existing scene whose memory or files hold `bytes`. `out_root`, unless NULL, gets the document. */
static fnl_result load_into(fnl_scene *scene, const unsigned char *bytes, size_t size, const char *folder,
                            const fnl_load_params *params, json_t **out_root) {
    TRY(scene_refuse_foreign(&scene->host, scene->source, bytes, size));
    struct gltf g = {.scene = scene, .host = &scene->host, .name = scene->source, .folder = folder};
    g.params = params ? *params : fnl_load_params_default();
    g.memory_left = g.params.max_memory;
    arena_init(&g.scratch, g.host, (size_t)64 << 10);
    const char *json = (const char *)bytes;
    size_t json_size = size;
    g.is_glb = size >= 4 && read_u32(bytes) == GLB_MAGIC;
    if (!g.is_glb || parse_glb(&g, bytes, size, &json, &json_size)) parse_json(&g, json ? json : "", json_size);
    /* As the file says it: loading rewrites primitives that are compressed. */
    if (g.result == FNL_OK && out_root) g.document = json_deep_copy(g.root);
    if (g.result == FNL_OK && out_root && !g.document) gltf_fail_memory(&g);
    if (g.result == FNL_OK) load_parts(&g);
    if (g.result == FNL_OK) keep_document(&g, bytes, size);
    if (g.result == FNL_OK && out_root) *out_root = json_incref(g.document);
    json_decref(g.document);
    json_decref(g.root);
    array_free(g.host, &g.vertex_map);
    array_free(g.host, &g.primitive_joints);
    arena_finish(&g.scratch);
    return g.result;
}

fnl_result gltf_load(const fnl_host *host, const char *path, const fnl_load_params *params, fnl_scene **out) {
    fnl_scene *scene;
    *out = NULL;
    TRY(scene_create(host, path, &scene));
    struct file_view file = {0};
    char folder[4096];
    fnl_result result = file_load(&scene->host, path, &file);
    if (result == FNL_OK && !path_folder(path, folder, sizeof folder)) {
        log_error(&scene->host, "%.64s…: the path is too long", path);
        result = FNL_ERROR_FILE;
    }
    const struct scene_source source = {NULL, scene->source, file.data, file.size};
    if (result == FNL_OK && !array_push(&scene->host, &scene->sources, source)) result = FNL_ERROR_MEMORY;
    if (result == FNL_OK && !array_push(&scene->host, &scene->files, file)) result = FNL_ERROR_MEMORY;
    if (result != FNL_OK) file_free(&scene->host, &file);
    if (result == FNL_OK) result = load_into(scene, file.data, file.size, folder, params, NULL);
    if (result != FNL_OK) {
        fnl_scene_destroy(&scene);
        return result;
    }
    *out = scene;
    return FNL_OK;
}

fnl_result gltf_load_memory(const fnl_host *host, const void *bytes, size_t size, const char *name,
                            const fnl_load_params *params, fnl_scene **out) {
    fnl_scene *scene;
    *out = NULL;
    TRY(scene_create(host, name, &scene));
    /* Images point into the bytes for as long as the scene lives, so it keeps a copy. */
    unsigned char *copy = scene_keep_bytes(scene, size);
    if (copy && size) memcpy(copy, bytes, size);
    fnl_result result = copy ? load_into(scene, copy, size, NULL, params, NULL) : FNL_ERROR_MEMORY;
    if (result != FNL_OK) {
        fnl_scene_destroy(&scene);
        return result;
    }
    *out = scene;
    return FNL_OK;
}

/* ---- once more, for fnl_scene_save ---- */

struct again {
    const fnl_scene *scene;
    uint32_t next; /* the sources are asked for in the order in which they were found */
};

static fnl_result give_again(void *user, const char *uri, fnl_resource *out) {
    struct again *again = user;
    const uint32_t count = again->scene->sources.count;
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t at = (again->next + i) % count;
        const struct scene_source *source = &again->scene->sources.data[at];
        if (!source->uri || strcmp(source->uri, uri) != 0) continue;
        again->next = at + 1;
        out->data = source->data;
        out->size = (size_t)source->size;
        return source->data ? FNL_OK : FNL_ERROR_FILE;
    }
    return FNL_ERROR_FILE;
}

fnl_result gltf_load_again(const fnl_host *host, const fnl_scene *scene, fnl_scene **out, json_t **out_root) {
    struct again again = {scene, 0};
    fnl_load_params params = fnl_load_params_default();
    params.lenient = scene->document.lenient;
    params.max_memory = UINT64_MAX;
    params.resolve = give_again;
    params.user = &again;
    TRY(scene_create(host, scene->source, out));
    const fnl_result result = load_into(*out, scene->document.bytes, scene->document.size, NULL, &params, out_root);
    if (result != FNL_OK) fnl_scene_destroy(out);
    return result;
}
