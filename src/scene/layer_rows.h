/* SPDX-License-Identifier: MIT */
/** The rows of material_layers.h as tables, and what follows from them: whether a material has layers, and their conversion from and to public params. */
#ifndef FNL_SCENE_LAYER_ROWS_H
#define FNL_SCENE_LAYER_ROWS_H

#include "scene/scene.h"

/** Whether a number above 0 switches its layer on. */
enum layer_on {
    LAYER_NO_SWITCH,
    LAYER_IN_GBUFFER, /* yes; some G-buffers hold the layer (passes/shade/gbuffer_layouts.h) */
    LAYER_FORWARD,    /* yes; paths with a G-buffer draw the surface forward */
};

struct layer_number {
    const char *name;            /* the member of fnl_material_params */
    const char *extension, *key; /* JSON; '/' in the key leads into a texture of the layer */
    size_t offset, params_offset; /* in struct scene_material and fnl_material_params */
    uint32_t count;              /* floats: 1, or 3 for a linear color */
    float low, high;
    float zero;       /* what 0 means in fnl_material_params, or 0; infinite: "never", which queries return as 0 */
    size_t zero_with; /* in fnl_material_params, or 0: the other number that must also be 0 */
    float unsaid;     /* default in files with the extension, if above 0; otherwise as without the extension */
    enum layer_on on;
    const char *unit;         /* with a space, or NULL; for messages */
    const char *label, *help; /* for user interfaces; no label: not shown */
    float least, most;        /* of its slider; equal: low and high */
    size_t under;             /* in fnl_material_params, or 0: the number that must be above 0 for this one to be shown */
};

struct layer_texture {
    enum scene_texture_slot slot;
    const char *name; /* the member of fnl_material_params */
    const char *extension, *key;
    size_t params_offset;
    const char *label;
    enum layer_texture_kind { LAYER_TEXTURE_NUMBERS, LAYER_TEXTURE_COLOR, LAYER_TEXTURE_NORMALS } kind;
};

#define COUNT_ROW(...) +1
enum {
    LAYER_COUNT = 0 MATERIAL_LAYERS(COUNT_ROW),
    LAYER_NUMBER_COUNT = 0 MATERIAL_LAYER_NUMBERS(COUNT_ROW, COUNT_ROW),
    LAYER_TEXTURE_COUNT = 0 MATERIAL_LAYER_TEXTURES(COUNT_ROW)
};
#undef COUNT_ROW

extern const char *const layer_extensions[LAYER_COUNT];
extern const struct layer_number layer_numbers[LAYER_NUMBER_COUNT];
extern const struct layer_texture layer_textures[LAYER_TEXTURE_COUNT];

/** The floats of a number. */
float *layer_value(struct scene_material *material, const struct layer_number *number);
/** All numbers of all layers, from public params and back. */
void layers_from_params(struct scene_material *out, const fnl_material_params *params);
void layers_to_params(const struct scene_material *material, fnl_material_params *out);
/** Whether the numbers are within their limits. */
fnl_result layers_check(const struct call *call, const fnl_material_params *params);

#endif
