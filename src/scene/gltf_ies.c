/* SPDX-License-Identifier: MIT */
/* EXT_lights_ies: luminaires on nodes. */
#include "scene/gltf.h"

static void load_profile(struct gltf *g, json_t *object, const struct at *at, fnl_light_profile_id *out) {
    const unsigned char *data = NULL;
    uint64_t size = 0;
    const char *uri = gltf_string(g, object, at, "uri", false), *place = uri ? "uri" : "bufferView";
    if (uri) {
        if (!gltf_read_uri(g, AT_KEY(at, "uri"), uri, false, &data, &size)) return;
    } else {
        const uint32_t view = gltf_index(g, object, at, "bufferView", true, g->view_count);
        if (view == SCENE_NONE) return;
        data = g->views[view].data;
        size = g->views[view].size;
    }
    const char *type = gltf_string(g, object, at, "mimeType", false);
    if (type && strcmp(type, "application/x-ies-lm-63") != 0)
        gltf_warn(g, AT_KEY(at, "mimeType"), "is not application/x-ies-lm-63; it is read all the same");
    if (!data) {
        gltf_warn(g, AT_KEY(at, place), "has no bytes; the lights are left out");
        return;
    }
    struct gltf_quiet_host quiet;
    gltf_quiet_host_init(&quiet, g->host);
    if (!gltf_spend(g, at, SCENE_PROFILE_BYTES_MOST)) return;
    const fnl_result result = scene_add_profile(g->scene, &quiet.host, "it", data, (size_t)size, out);
    if (result == FNL_ERROR_MEMORY) gltf_fail_memory(g);
    if (result != FNL_OK) gltf_warn(g, AT_KEY(at, place), "is no light profile: %s; the lights are left out", quiet.line);
}

void gltf_load_profiles(struct gltf *g) {
    struct gltf_extension_place place;
    json_t *extension = gltf_extension(g->root, &g->top, "EXT_lights_ies", &place);
    json_t *array = extension ? gltf_array(g, extension, &place.extension, "lights", true) : NULL;
    const struct at *at = AT_KEY(&place.extension, "lights");
    g->profile_count = gltf_count(array);
    g->profiles = gltf_scratch(g, g->profile_count, sizeof *g->profiles);
    for (uint32_t i = 0; i < g->profile_count && g->result == FNL_OK; i++) {
        json_t *object = gltf_element(g, array, at, i);
        if (object) load_profile(g, object, AT_INDEX(at, i), &g->profiles[i]);
    }
}

bool gltf_read_profile_light(struct gltf *g, uint32_t node, fnl_light_params *out) {
    struct gltf_extension_place place;
    const struct at *nodes_at = AT_KEY(&g->top, "nodes"), *at = AT_INDEX(nodes_at, node);
    json_t *object = json_array_get(json_object_get(g->root, "nodes"), node);
    json_t *extension = json_is_object(object) ? gltf_extension(object, at, "EXT_lights_ies", &place) : NULL;
    float multiplier = 1;
    if (!extension) return false;
    const uint32_t index = gltf_index(g, extension, &place.extension, "light", true, g->profile_count);
    if (index == SCENE_NONE || !g->profiles[index].generation) return false;
    *out = fnl_light_params_default();
    gltf_floats(g, extension, &place.extension, "color", 3, 0, 1, out->color);
    gltf_float(g, extension, &place.extension, "multiplier", false, 0, FLT_MAX, &multiplier);
    out->profile = g->profiles[index];
    out->intensity = fminf(multiplier * g->scene->profiles.data[out->profile.index].candela, FLT_MAX);
    return true;
}
