/* SPDX-License-Identifier: MIT */
#include "scene/layer_rows.h"

#define LAYER(member, type, extension) extension,
const char *const layer_extensions[] = {MATERIAL_LAYERS(LAYER)};
#undef LAYER

#define PARAMS(member) offsetof(fnl_material_params, member)
#define NUMBER(id, member, extension, key, low, high, ...)                                                                       \
    {#member, extension, key, offsetof(struct scene_material, member), PARAMS(member), sizeof((fnl_material_params *)0)->member / sizeof(float), \
     low, high, __VA_ARGS__},
const struct layer_number layer_numbers[] = {MATERIAL_LAYER_NUMBERS(NUMBER, NUMBER)};
#undef NUMBER

#define TEXTURE(slot, member, extension, key, label, kind) {SCENE_TEXTURE_##slot, #member, extension, key, PARAMS(member), label, LAYER_TEXTURE_##kind},
const struct layer_texture layer_textures[] = {MATERIAL_LAYER_TEXTURES(TEXTURE)};
#undef TEXTURE

bool scene_texture_is_color(enum scene_texture_slot slot) {
    if (slot >= SCENE_TEXTURE_CORE_COUNT) return layer_textures[slot - SCENE_TEXTURE_CORE_COUNT].kind == LAYER_TEXTURE_COLOR;
    return slot == SCENE_TEXTURE_BASE_COLOR || slot == SCENE_TEXTURE_EMISSIVE || slot == SCENE_TEXTURE_SPECULAR_COLOR;
}

bool scene_texture_is_normals(enum scene_texture_slot slot) {
    return slot == SCENE_TEXTURE_NORMAL ||
           (slot >= SCENE_TEXTURE_CORE_COUNT && layer_textures[slot - SCENE_TEXTURE_CORE_COUNT].kind == LAYER_TEXTURE_NORMALS);
}

/* ---- which are on ---- */

static bool is_on(const struct scene_material *material, const struct layer_number *number) {
    const float *value = (const float *)(const void *)((const char *)material + number->offset);
    bool on = false;
    for (uint32_t i = 0; i < number->count; i++) on = on || value[i] > 0;
    return on;
}

static bool has_layer(const struct scene_material *material, bool held_too) {
    bool any = false;
    for (uint32_t i = 0; i < LAYER_NUMBER_COUNT; i++) {
        const enum layer_on on = layer_numbers[i].on;
        if (on == LAYER_FORWARD || (on == LAYER_IN_GBUFFER && held_too)) any = any || is_on(material, &layer_numbers[i]);
    }
    return any && !material->unlit;
}

bool scene_material_layered(const struct scene_material *material) { return has_layer(material, true); }
bool scene_material_layered_besides(const struct scene_material *material) { return has_layer(material, false); }

/* ---- public params ---- */

float *layer_value(struct scene_material *material, const struct layer_number *number) {
    return (float *)(void *)((char *)material + number->offset);
}

static const float *params_value(const fnl_material_params *params, size_t offset) {
    return (const float *)(const void *)((const char *)params + offset);
}

void layers_from_params(struct scene_material *out, const fnl_material_params *params) {
    for (uint32_t i = 0; i < LAYER_NUMBER_COUNT; i++) {
        const struct layer_number *number = &layer_numbers[i];
        const float *value = params_value(params, number->params_offset);
        const bool zero = *value == 0 && number->zero != 0 && (!number->zero_with || *params_value(params, number->zero_with) == 0);
        memcpy(layer_value(out, number), zero ? &number->zero : value, number->count * sizeof *value);
    }
}

void layers_to_params(const struct scene_material *material, fnl_material_params *out) {
    for (uint32_t i = 0; i < LAYER_NUMBER_COUNT; i++) {
        const struct layer_number *number = &layer_numbers[i];
        const float *value = (const float *)(const void *)((const char *)material + number->offset);
        const float never = 0;
        memcpy((char *)out + number->params_offset, *value == INFINITY ? &never : value, number->count * sizeof *value);
    }
}

fnl_result layers_check(const struct call *call, const fnl_material_params *params) {
    for (uint32_t i = 0; i < LAYER_NUMBER_COUNT; i++) {
        const struct layer_number *number = &layer_numbers[i];
        const float *value = params_value(params, number->params_offset);
        const char *unit = number->unit ? number->unit : "";
        const double low = isinf(number->zero) ? 0 : (double)number->low;
        if (number->zero != 0 && (*value == 0 || (isinf(number->zero) && *value == number->zero))) continue;
        if (number->count > 1)
            TRY(check_floats(call, number->name, value, number->count, low, (double)number->high, unit));
        else
            TRY(check_range(call, number->name, (double)*value, low, (double)number->high, unit));
    }
    return FNL_OK;
}

bool fnl_layer_number_query(uint32_t index, fnl_layer_number *out) {
    if (check_handle(__func__, "out", out) != FNL_OK || index >= LAYER_NUMBER_COUNT) return false;
    const struct layer_number *number = &layer_numbers[index];
    const bool slider = number->least < number->most;
    *out = (fnl_layer_number){.name = number->name,
                              .label = number->label ? number->label : "",
                              .help = number->help ? number->help : "",
                              .offset = number->params_offset,
                              .count = number->count,
                              .least = slider ? number->least : number->low,
                              .most = slider ? number->most : number->high,
                              .under = number->under};
    return true;
}

bool fnl_layer_texture_query(uint32_t index, fnl_layer_texture *out) {
    if (check_handle(__func__, "out", out) != FNL_OK || index >= LAYER_TEXTURE_COUNT) return false;
    *out = (fnl_layer_texture){layer_textures[index].name, layer_textures[index].label, layer_textures[index].params_offset};
    return true;
}
