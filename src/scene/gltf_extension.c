/* SPDX-License-Identifier: MIT */
/* Which extensions a file uses, how each is treated, and whether each extension object stands where it may. */
#include "scene/gltf.h"

/** A place is the JSON pointer with '#' for indices; TEXTURE_PLACE stands for every texture reference of a material. */
#define TEXTURE_PLACE "texture"
struct known_extension {
    const char *name, *treatment;
    bool may_be_required; /* core glTF alone shows enough to be useful: lenient loading takes it, required or not */
    const char *places[8];
};

/** No file uses this many; the lists are searched for each extension object. */
#define EXTENSION_MAX 256u

#define FULL "full"
#ifdef FANAL_DRACO
#define DRACO_TREATMENT FULL
#else
#define DRACO_TREATMENT "not read: Fanal was built without libdraco (Debian and Ubuntu: libdraco-dev)"
#endif
#define MATERIAL_FALLBACK "ignored: the material is shown with its core properties"

static const struct known_extension known_extensions[] = {
#define LAYER(member, type, extension) {extension, FULL, true, {"/materials/#"}},
    MATERIAL_LAYERS(LAYER)
#undef LAYER
    {"KHR_lights_punctual", FULL, true, {"", "/nodes/#"}},
    {"KHR_texture_transform", FULL, true, {TEXTURE_PLACE}},
    {"KHR_materials_unlit", FULL, true, {"/materials/#"}},
    {"KHR_materials_emissive_strength", FULL, true, {"/materials/#"}},
    {"KHR_materials_ior", FULL, true, {"/materials/#"}},
    {"KHR_materials_specular", FULL, true, {"/materials/#"}},
    {"KHR_materials_variants", FULL, true, {"", "/meshes/#/primitives/#"}},
    {"EXT_lights_image_based", FULL, true, {"", "/scenes/#"}},
    {"KHR_xmp_json_ld", FULL, true, {"", "/asset", "/scenes/#", "/nodes/#", "/meshes/#", "/materials/#", "/images/#", "/animations/#"}},
    {"KHR_mesh_quantization", FULL, true, {NULL}},
    {"KHR_draco_mesh_compression", DRACO_TREATMENT, false, {"/meshes/#/primitives/#"}},
    {"KHR_node_visibility", FULL, true, {"/nodes/#"}},
    {"KHR_meshopt_compression", FULL, true, {"/bufferViews/#", "/buffers/#"}},
    {"EXT_meshopt_compression", FULL, true, {"/bufferViews/#", "/buffers/#"}},
    {"EXT_lights_ies", FULL, true, {"", "/nodes/#"}},
    {"EXT_mesh_gpu_instancing", FULL, true, {"/nodes/#"}},
    {"MSFT_lod", FULL, true, {"/nodes/#", "/materials/#"}},
    {"EXT_texture_webp", FULL, true, {"/textures/#"}},
    {"KHR_texture_basisu", FULL, true, {"/textures/#"}},
    {"MSFT_texture_dds", FULL, true, {"/textures/#"}},
    {"FNL_decal", FULL, true, {"/nodes/#"}},
    {"FNL_surroundings", FULL, true, {"/scenes/#"}},
    {"KHR_materials_pbrSpecularGlossiness", MATERIAL_FALLBACK, true, {"/materials/#"}},
    {"KHR_animation_pointer", FULL, true, {"/animations/#/channels/#/target"}},
};

static const struct known_extension *find_known(const char *name) {
    for (uint32_t i = 0; i < COUNT_OF(known_extensions); i++)
        if (strcmp(known_extensions[i].name, name) == 0) return &known_extensions[i];
    return NULL;
}

/* ---- extensionsUsed, extensionsRequired ---- */

/** Whether an array holds the string in its first `count` elements. */
static bool array_has_string(json_t *array, size_t count, const char *text) {
    for (size_t i = 0; i < count; i++) {
        const char *other = json_string_value(json_array_get(array, i));
        if (other && strcmp(other, text) == 0) return true;
    }
    return false;
}

static void check_required(struct gltf *g, json_t *required) {
    const struct at *at = AT_KEY(&g->top, "extensionsRequired");
    for (uint32_t i = 0; i < MIN(gltf_count(required), EXTENSION_MAX); i++) {
        const char *name = json_string_value(json_array_get(required, i));
        if (!name) {
            gltf_warn(g, AT_INDEX(at, i), "is not a string; it is ignored");
            continue;
        }
        if (array_has_string(required, i, name)) gltf_warn(g, AT_INDEX(at, i), "names %s for the second time", name);
        if (!gltf_uses(g, name)) gltf_warn(g, AT_INDEX(at, i), "%s is not in extensionsUsed; it is taken as used", name);
        const struct known_extension *known = find_known(name);
        if (known && !known->may_be_required && strcmp(known->treatment, FULL) != 0)
            gltf_fail(g, FNL_ERROR_UNSUPPORTED, AT_INDEX(at, i), "the file requires the extension %s, which is %s", name, known->treatment);
        else if (!known)
            gltf_fail(g, FNL_ERROR_UNSUPPORTED, AT_INDEX(at, i),
                      "the file requires the extension %s, which is not supported", name);
        else if (strcmp(known->treatment, FULL) != 0 && !g->params.lenient)
            gltf_fail(g, FNL_ERROR_UNSUPPORTED, AT_INDEX(at, i),
                      "the file requires the extension %s, which is not supported; only lenient loading shows it without",
                      name);
    }
}

static void list_extension(struct gltf *g, const char *name, bool required) {
    const struct known_extension *known = find_known(name);
    struct scene_extension extension = {
        .name = arena_string(&g->scene->arena, name),
        .treatment = known ? known->treatment : "ignored",
        .required = required,
    };
    if (!extension.name || !array_push(g->host, &g->scene->extensions, extension)) gltf_fail_memory(g);
}

/* ---- extension objects ---- */

/** More would be no glTF, and this bounds the walk's use of the stack (jansson itself stops at 2048). */
#define WALK_DEPTH_MAX 64
#define PLACE_SIZE 128

static bool place_matches(const char *pattern, const char *place) {
    if (strcmp(pattern, TEXTURE_PLACE) != 0) return strcmp(pattern, place) == 0;
    size_t length = strlen(place);
    return strncmp(place, "/materials/#/", 13) == 0 && length > 7 && strcmp(place + length - 7, "Texture") == 0;
}

static void check_extension_objects(struct gltf *g, json_t *extensions, const struct at *at, const char *place) {
    const struct at *here = AT_KEY(at, "extensions");
    if (!json_is_object(extensions)) {
        gltf_warn(g, here, "is not an object; it is ignored");
        return;
    }
    const char *name;
    json_t *value;
    json_object_foreach(extensions, name, value) {
        const struct at *extension_at = AT_KEY(here, name);
        if (!json_is_object(value)) {
            gltf_warn(g, extension_at, "is not an object; it is ignored");
            continue;
        }
        if (!gltf_uses(g, name)) gltf_warn(g, extension_at, "%s is not in extensionsUsed; it is taken as used", name);
        const struct known_extension *known = find_known(name);
        if (!known) continue;
        bool allowed = false;
        for (uint32_t i = 0; i < COUNT_OF(known->places) && known->places[i]; i++)
            allowed |= place_matches(known->places[i], place);
        if (!allowed) gltf_warn(g, extension_at, "%s has no meaning here; it is ignored", name);
    }
}

/** Visits every object with a member "extensions". */
static void walk(struct gltf *g, json_t *value, const struct at *at, const char *place, uint32_t depth) {
    char below[PLACE_SIZE];
    if (depth > WALK_DEPTH_MAX) return;
    if (json_is_array(value)) {
        if (snprintf(below, sizeof below, "%s/#", place) >= PLACE_SIZE) return;
        for (size_t i = 0; i < json_array_size(value); i++) {
            json_t *element = json_array_get(value, i);
            if (json_is_object(element) || json_is_array(element)) walk(g, element, AT_INDEX(at, i), below, depth + 1);
        }
    } else if (json_is_object(value)) {
        const char *key;
        json_t *member;
        json_object_foreach(value, key, member) {
            if (strcmp(key, "extras") == 0) continue;
            if (strcmp(key, "extensions") == 0) check_extension_objects(g, member, at, place);
            if (!json_is_object(member) && !json_is_array(member)) continue;
            if (snprintf(below, sizeof below, "%s/%s", place, key) >= PLACE_SIZE) continue;
            if (strcmp(below, "/extensions/KHR_xmp_json_ld/packets") == 0) continue; /* no glTF */
            walk(g, member, AT_KEY(at, key), below, depth + 1);
        }
    }
}

void gltf_load_extensions(struct gltf *g) {
    json_t *used = gltf_array(g, g->root, &g->top, "extensionsUsed", false);
    json_t *required = gltf_array(g, g->root, &g->top, "extensionsRequired", false);
    if (gltf_count(used) > EXTENSION_MAX)
        gltf_warn(g, &g->top, "lists more than %u extensions; the others are ignored", EXTENSION_MAX);
    if (gltf_count(required) > EXTENSION_MAX)
        gltf_fail(g, FNL_ERROR_UNSUPPORTED, AT_KEY(&g->top, "extensionsRequired"), "lists more than %u extensions",
                  EXTENSION_MAX);
    check_required(g, required);
    const struct at *at = AT_KEY(&g->top, "extensionsUsed");
    for (uint32_t i = 0; i < MIN(gltf_count(used), EXTENSION_MAX) && g->result == FNL_OK; i++) {
        const char *name = json_string_value(json_array_get(used, i));
        if (!name) {
            gltf_warn(g, AT_INDEX(at, i), "is not a string; it is ignored");
            continue;
        }
        if (array_has_string(used, i, name)) {
            gltf_warn(g, AT_INDEX(at, i), "names %s for the second time", name);
            continue;
        }
        bool is_required = array_has_string(required, json_array_size(required), name);
        const struct known_extension *known = find_known(name);
        if (!known || strcmp(known->treatment, FULL) != 0)
            gltf_warn(g, AT_INDEX(at, i), "%s is %s", name, known ? known->treatment : "not known; it is ignored");
        if (strcmp(name, "KHR_mesh_quantization") == 0 && !is_required)
            gltf_warn(g, AT_INDEX(at, i), "%s must also be in extensionsRequired; it is used all the same", name);
        list_extension(g, name, is_required);
    }
    if (g->result == FNL_OK) walk(g, g->root, &g->top, "", 0);
}
