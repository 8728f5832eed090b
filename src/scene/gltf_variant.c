/* SPDX-License-Identifier: MIT */
/* KHR_materials_variants: the names of the variants, and which material each primitive has in them. */
#include "scene/gltf.h"

/* More are not compared: each is with all before it. */
enum { COMPARED_MAX = 1024 };

static void check_name(struct gltf *g, const struct at *at, const struct scene_variant *variant, uint32_t index) {
    if (!*variant->name) {
        gltf_warn(g, at, "has no name; only its number, %u, selects it", index);
        return;
    }
    for (uint32_t i = 0; i < MIN(index, COMPARED_MAX); i++)
        if (strcmp(g->scene->variants.data[i].name, variant->name) == 0) {
            gltf_warn(g, AT_KEY(at, "name"), "'%.100s' is the name of variant %u too; only its number, %u, selects it", variant->name, i, index);
            return;
        }
}

void gltf_load_variants(struct gltf *g) {
    struct gltf_extension_place place;
    json_t *extension = gltf_extension(g->root, &g->top, "KHR_materials_variants", &place);
    json_t *array = extension ? gltf_array(g, extension, &place.extension, "variants", true) : NULL;
    const uint32_t count = gltf_count(array);
    const struct at *at = AT_KEY(&place.extension, "variants");
    g->variant_stamps = gltf_scratch(g, count, sizeof *g->variant_stamps);
    if (!array_reserve(g->host, &g->scene->variants, count)) gltf_fail_memory(g);
    for (uint32_t i = 0; i < count && g->result == FNL_OK; i++) {
        struct scene_variant variant = {.name = ""};
        json_t *object = gltf_element(g, array, at, i);
        if (object) {
            variant.name = gltf_name(g, object, AT_INDEX(at, i));
            variant.extras = gltf_extras(g, object);
            check_name(g, AT_INDEX(at, i), &variant, i);
        }
        g->scene->variants.data[g->scene->variants.count++] = variant; /* numbers stay those of the file */
    }
}

/* ---- primitives ---- */

/* One element of "mappings": appended to what is there. */
static void load_mapping(struct gltf *g, json_t *object, const struct at *at, struct scene_mapping *mappings, uint32_t *count) {
    const uint32_t material = gltf_index(g, object, at, "material", true, g->material_count);
    json_t *variants = gltf_array(g, object, at, "variants", true);
    const struct at *here = AT_KEY(at, "variants");
    for (uint32_t i = 0; i < gltf_count(variants); i++) {
        const uint32_t variant = gltf_index_value(g, json_array_get(variants, i), AT_INDEX(here, i), g->scene->variants.count);
        if (variant == SCENE_NONE || material == SCENE_NONE) continue;
        if (g->variant_stamps[variant] == g->variant_stamp) {
            gltf_warn(g, AT_INDEX(here, i), "variant %u has its material already; this one is ignored", variant);
            continue;
        }
        g->variant_stamps[variant] = g->variant_stamp;
        mappings[(*count)++] = (struct scene_mapping){variant, material};
    }
}

bool gltf_load_mappings(struct gltf *g, json_t *primitive, const struct at *at, struct scene_primitive *out) {
    out->standard_material = out->material;
    struct gltf_extension_place place;
    json_t *extension = gltf_extension(primitive, at, "KHR_materials_variants", &place);
    json_t *array = extension ? gltf_array(g, extension, &place.extension, "mappings", true) : NULL;
    if (gltf_count(array) == 0) return true;
    const struct at *here = AT_KEY(&place.extension, "mappings");
    if (!json_object_get(json_object_get(g->root, "extensions"), "KHR_materials_variants")) {
        gltf_warn(g, AT_INDEX(here, 0), "the file has no /extensions/KHR_materials_variants; all mappings are ignored");
        return true;
    }
    uint64_t most = 0;
    for (uint32_t i = 0; i < gltf_count(array); i++) most += gltf_count(json_object_get(json_array_get(array, i), "variants"));
    if (!gltf_take_memory(g, here, most * sizeof *out->mappings)) return false;
    struct scene_mapping *mappings = gltf_keep(g, most, sizeof *mappings);
    if (!mappings) return false;
    g->variant_stamp++;
    for (uint32_t i = 0; i < gltf_count(array); i++) {
        json_t *object = gltf_element(g, array, here, i);
        if (object) load_mapping(g, object, AT_INDEX(here, i), mappings, &out->mapping_count);
    }
    out->mappings = mappings;
    return true;
}
