/* SPDX-License-Identifier: MIT */
/* What a document refers to goes into its binary chunk: all buffers become one, and pictures and light profiles become buffer views. */
#include "scene/glb.h"

#include <strings.h>

/* ---- buffers ---- */

/* Where a buffer went: the first one, at an offset, or another without bytes. */
struct moved {
    bool embedded;
    uint64_t offset;
    uint32_t index;
};

static void move_view(struct glb *g, json_t *view, const struct moved *moved, uint32_t count) {
    const double number = json_number_value(json_object_get(view, "buffer"));
    if (!json_is_object(view) || !json_is_number(json_object_get(view, "buffer")) || !(number >= 0 && number < count)) return;
    const struct moved *to = &moved[(uint32_t)number];
    glb_set(g, view, "buffer", json_integer(to->embedded ? 0 : (json_int_t)to->index));
    const json_int_t offset = (json_int_t)json_number_value(json_object_get(view, "byteOffset"));
    if (to->embedded && to->offset) glb_set(g, view, "byteOffset", json_integer(offset + (json_int_t)to->offset));
}

static void embed_buffers(struct glb *g) {
    const struct scene_document *document = &g->file->document;
    json_t *before = json_object_get(g->root, "buffers"), *after = json_array(), *views = json_object_get(g->root, "bufferViews");
    const uint32_t count = MIN(document->buffer_count, gltf_count(before));
    struct moved *moved = glb_memory(g, count, sizeof *moved);
    if (!moved || count == 0) {
        json_decref(after);
        return;
    }
    glb_append(g, after, json_object()); /* what all bytes are in */
    for (uint32_t i = 0; i < count && g->result == FNL_OK; i++) {
        json_t *buffer = json_array_get(before, i);
        moved[i].embedded = document->buffers[i].data != NULL;
        if (!moved[i].embedded) {
            moved[i].index = glb_append(g, after, json_incref(buffer));
            continue;
        }
        moved[i].offset = glb_add_bytes(g, document->buffers[i].data, document->buffers[i].size);
        const char *key;
        json_t *value;
        json_object_foreach(buffer, key, value) {
            if (strcmp(key, "uri") == 0 || strcmp(key, "byteLength") == 0) continue;
            if (json_object_get(json_array_get(after, 0), key))
                glb_left_out(g, "'%.40s' of buffer %u, which becomes a part of the first one", key, i);
            else
                glb_set(g, json_array_get(after, 0), key, json_incref(value));
        }
    }
    for (uint32_t i = 0; i < gltf_count(views); i++) {
        json_t *view = json_array_get(views, i), *extensions = json_object_get(view, "extensions");
        move_view(g, view, moved, count);
        move_view(g, json_object_get(extensions, "KHR_meshopt_compression"), moved, count);
        move_view(g, json_object_get(extensions, "EXT_meshopt_compression"), moved, count);
    }
    glb_set(g, g->root, "buffers", after);
}

void glb_finish_buffers(struct glb *g) {
    json_t *buffers = json_object_get(g->root, "buffers");
    if (g->size == 0 && json_array_size(buffers) > 1) glb_add_bytes(g, "\0\0\0", 4); /* the others are not that of the chunk */
    if (g->size == 0) {
        json_object_del(g->root, "buffers");
        return;
    }
    buffers = glb_array(g, g->root, "buffers");
    if (json_array_size(buffers) == 0) glb_append(g, buffers, json_object());
    glb_set(g, json_array_get(buffers, 0), "byteLength", json_integer((json_int_t)g->size));
}

/* ---- pictures and profiles ---- */

static void embed(struct glb *g, json_t *object, const void *data, uint64_t size, const char *type) {
    const uint32_t view = glb_add_view(g, data, size, 0);
    json_object_del(object, "uri");
    glb_set(g, object, "bufferView", json_integer((json_int_t)view));
    if (type) glb_set(g, object, "mimeType", json_string(type));
}

static void embed_images(struct glb *g) {
    json_t *images = json_object_get(g->root, "images");
    for (uint32_t i = 0; i < MIN(gltf_count(images), g->file->images.count) && g->result == FNL_OK; i++) {
        const struct scene_image *image = &g->file->images.data[i];
        json_t *object = json_array_get(images, i);
        char type[40];
        if (!json_object_get(object, "uri") || !image->encoded) continue;
        snprintf(type, sizeof type, "image/%s", strcmp(image->file_kind, "dds") == 0 ? "vnd-ms.dds" : image->file_kind);
        embed(g, object, image->encoded, image->encoded_size, type);
    }
}

static void embed_profiles(struct glb *g) {
    json_t *lights = json_object_get(json_object_get(json_object_get(g->root, "extensions"), "EXT_lights_ies"), "lights");
    for (uint32_t i = 0; i < gltf_count(lights); i++) {
        json_t *object = json_array_get(lights, i);
        const char *uri = json_string_value(json_object_get(object, "uri"));
        for (uint32_t k = 0; uri && k < g->file->sources.count; k++) {
            const struct scene_source *source = &g->file->sources.data[k];
            if (!source->uri || strcmp(source->uri, uri) != 0 || !source->data) continue;
            embed(g, object, source->data, source->size, "application/x-ies-lm-63");
            break;
        }
    }
}

/* What still is in another file: an extension's that Fanal does not know, or what is missing. */
static void tell_of_files(const struct glb *g, json_t *value, uint32_t depth) {
    const char *key;
    json_t *member;
    size_t index;
    if (depth > 64) return;
    if (json_is_array(value))
        json_array_foreach(value, index, member) tell_of_files(g, member, depth + 1);
    json_object_foreach(value, key, member) {
        const char *text = strcmp(key, "uri") == 0 ? json_string_value(member) : NULL;
        if (text && strncasecmp(text, "data:", 5) != 0) glb_left_out(g, "the file '%.200s', which is still referred to", text);
        if (strcmp(key, "extras") != 0) tell_of_files(g, member, depth + 1);
    }
}

void glb_embed(struct glb *g) {
    if (!g->file) return;
    embed_buffers(g);
    embed_images(g);
    embed_profiles(g);
    tell_of_files(g, g->root, 0);
}
