/* SPDX-License-Identifier: MIT */
/* KHR_xmp_json_ld: packets of metadata, and what in the file each is about. */
#include "scene/gltf.h"

#define NAME "KHR_xmp_json_ld"

/* What refers to a packet. */
struct reference {
    const char *pointer;
    uint32_t packet;
};
struct references {
    ARRAY(struct reference) list;
};

static void load_reference(struct gltf *g, json_t *object, const struct at *at, struct references *out) {
    struct gltf_extension_place place;
    json_t *extension = gltf_extension(object, at, NAME, &place);
    if (!extension) return;
    if (!json_object_get(json_object_get(g->root, "extensions"), NAME)) {
        gltf_warn(g, &place.extension, "the file has no /extensions/" NAME "; it is ignored");
        return;
    }
    const uint32_t packet = gltf_index(g, extension, &place.extension, "packet", true, g->scene->packets.count);
    if (packet == SCENE_NONE) return;
    char pointer[64];
    gltf_pointer(at, pointer, sizeof pointer);
    struct reference reference = {arena_string(&g->scratch, pointer), packet};
    if (!reference.pointer || !array_push(g->host, &out->list, reference)) gltf_fail_memory(g);
}

static void load_references(struct gltf *g, struct references *out) {
    static const char *const kinds[] = {"scenes", "nodes", "meshes", "materials", "images", "animations"};
    json_t *asset = json_object_get(g->root, "asset");
    if (json_is_object(asset)) load_reference(g, asset, AT_KEY(&g->top, "asset"), out);
    for (uint32_t k = 0; k < COUNT_OF(kinds); k++) {
        json_t *array = json_object_get(g->root, kinds[k]); /* of what is no array, or no object in it, its own loader complains */
        const struct at *at = AT_KEY(&g->top, kinds[k]);
        for (uint32_t i = 0; i < gltf_count(array) && g->result == FNL_OK; i++)
            if (json_is_object(json_array_get(array, i))) load_reference(g, json_array_get(array, i), AT_INDEX(at, i), out);
    }
}

/* Each packet's pointers, with blanks between. */
static void join_references(struct gltf *g, const struct references *references) {
    const uint32_t count = g->scene->packets.count;
    size_t *sizes = gltf_scratch(g, count, sizeof *sizes);
    char **ends = gltf_scratch(g, count, sizeof *ends);
    if (!sizes || !ends) return;
    for (uint32_t i = 0; i < references->list.count; i++) sizes[references->list.data[i].packet] += strlen(references->list.data[i].pointer) + 1;
    for (uint32_t i = 0; i < count; i++) {
        if (sizes[i] == 0) continue;
        g->scene->packets.data[i].about = ends[i] = gltf_keep(g, sizes[i], 1);
        if (!ends[i]) return;
    }
    for (uint32_t i = 0; i < references->list.count; i++) {
        const struct reference *r = &references->list.data[i];
        const size_t length = strlen(r->pointer);
        if (ends[r->packet] != g->scene->packets.data[r->packet].about) *ends[r->packet]++ = ' ';
        memcpy(ends[r->packet], r->pointer, length);
        ends[r->packet] += length;
    }
}

static void load_packet(struct gltf *g, json_t *object, const struct at *at) {
    struct scene_packet packet = {.about = ""};
    if (object) {
        if (!json_object_get(object, "@context")) gltf_warn(g, at, "has no '@context', so is not JSON-LD; it is kept all the same");
        char *text = json_dumps(object, JSON_COMPACT);
        packet.text = text ? arena_string(&g->scene->arena, text) : NULL;
        free(text);
        if (!packet.text) gltf_fail_memory(g);
    }
    g->scene->packets.data[g->scene->packets.count++] = packet; /* numbers stay those of the file */
}

void gltf_load_xmp(struct gltf *g) {
    struct gltf_extension_place place;
    json_t *extension = gltf_extension(g->root, &g->top, NAME, &place);
    json_t *array = extension ? gltf_array(g, extension, &place.extension, "packets", true) : NULL;
    const struct at *at = AT_KEY(&place.extension, "packets");
    if (!array_reserve(g->host, &g->scene->packets, gltf_count(array))) gltf_fail_memory(g);
    for (uint32_t i = 0; i < gltf_count(array) && g->result == FNL_OK; i++) load_packet(g, gltf_element(g, array, at, i), AT_INDEX(at, i));
    struct references references = {{0}};
    if (g->result == FNL_OK) load_references(g, &references);
    if (g->result == FNL_OK) join_references(g, &references);
    array_free(g->host, &references.list);
}
