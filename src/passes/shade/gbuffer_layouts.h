/* SPDX-License-Identifier: MIT */
/** The layouts of the G-buffer: targets, fields, and which materials each can hold. shaders/gbuffer_layouts.glsl packs them. */
#ifndef FNL_PASSES_GBUFFER_LAYOUTS_H
#define FNL_PASSES_GBUFFER_LAYOUTS_H

#include "fanal/renderer.h"
#include "gbuffer_shared.h"
#include "gpu/gpu.h"
#include "passes/shade/gbuffer_view_shared.h"

enum { GBUFFER_FIELDS = 13 };

struct gbuffer_layout {
    uint32_t target_count, field_count;
    struct {
        const char *name; /* a literal: the image's name in the graph */
        VkFormat format;
    } targets[GBUFFER_TARGETS];
    fnl_gbuffer_field fields[GBUFFER_FIELDS];
    uint8_t semantics[GBUFFER_FIELDS]; /* GBUFFER_SEEN_…: how views show the field */
    uint32_t color_target, normal_target;
    uint32_t id_count;             /* materials that an ID tells apart; 0: no ID */
    fnl_normal_encoding own;       /* normals as the layout has them */
    uint32_t encodings;            /* a bit for each fnl_normal_encoding that its field holds */
    uint32_t published_bits;       /* with depth, stencil and the light accumulation of the publication */
    bool metallic, strength, tint; /* held by the pixel, not by the material's entry: metalness, strength and colour of F0 */
    bool layers;                   /* clearcoat and anisotropy are */
};

extern const struct gbuffer_layout gbuffer_layouts[FNL_GBUFFER_COUNT];

/** Bits of a texel of the formats that layouts use. */
uint32_t gbuffer_format_bits(VkFormat format);
/** Bytes of the targets that a frame with these settings has, for one sample; depth, radiance and mask are left out. */
uint32_t gbuffer_bytes(fnl_gbuffer layout, fnl_normal_encoding normals, bool chroma);
/** The form (gbuffer_shared.h) of a frame's G-buffer. */
uint32_t gbuffer_form_of(fnl_gbuffer layout, fnl_normal_encoding normals, bool chroma);

/** What decides whether a layout holds a material. */
struct gbuffer_material {
    uint32_t id;
    float metallic;
    vec3 dielectric_f0;
    float specular;
    bool unlit, metallic_texture, specular_texture, specular_color_texture;
    bool layered, other_layers; /* it has layers; of them some besides clearcoat and anisotropy */
};
bool gbuffer_holds(fnl_gbuffer layout, const struct gbuffer_material *material);
/** The entry that layouts with an ID look up. */
struct gpu_material_entry gbuffer_entry(const struct gbuffer_material *material);

#endif
