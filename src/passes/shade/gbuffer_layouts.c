/* SPDX-License-Identifier: MIT */
#include "passes/shade/gbuffer_layouts.h"

#include "base/check.h"

_Static_assert((uint32_t)FNL_GBUFFER_COUNT == GBUFFER_LAYOUTS && (uint32_t)FNL_GBUFFER_LAYERS == GBUFFER_LAYERS &&
                   (uint32_t)FNL_NORMALS_COUNT == NORMALS_COUNT && (uint32_t)FNL_NORMALS_FLOAT == NORMALS_FLOAT,
               "gbuffer_shared.h has the values of fnl_gbuffer and fnl_normal_encoding");

#define BIT(encoding) (1u << FNL_NORMALS_##encoding)
/* Encodings in two components of 0 .. 1; the target for comparisons goes with any layout whose normal holds nothing else. */
#define TWO (BIT(OCTAHEDRAL) | BIT(XY) | BIT(SPHERICAL) | BIT(SPHERE_MAP) | BIT(STEREOGRAPHIC) | BIT(VIEW) | BIT(FLOAT))

#define RGBA8 VK_FORMAT_R8G8B8A8_UNORM
#define SRGB8 VK_FORMAT_R8G8B8A8_SRGB
#define RGBA16 VK_FORMAT_R16G16B16A16_UNORM
#define RGBA16F VK_FORMAT_R16G16B16A16_SFLOAT
#define RG16F VK_FORMAT_R16G16_SFLOAT
#define RGB10 VK_FORMAT_A2B10G10R10_UNORM_PACK32
#define RG16 VK_FORMAT_R16G16_UNORM

const struct gbuffer_layout gbuffer_layouts[FNL_GBUFFER_COUNT] = {
    [FNL_GBUFFER_DEFAULT] =
        {.target_count = 3,
         .targets = {{"gbuffer color", RGB10}, {"gbuffer normal", RGBA16}, {"gbuffer dielectric", RGBA8}},
         .field_count = 8,
         .fields = {{"base colour", 0, 30},
                    {"unused", 0, 2},
                    {"normal", 1, 32},
                    {"roughness", 1, 16},
                    {"metalness", 1, 8},
                    {"occlusion", 1, 8},
                    {"dielectric F0", 2, 24},
                    {"F90", 2, 8}},
         .semantics = {GBUFFER_SEEN_COLOR, GBUFFER_SEEN_CHANNEL(3), GBUFFER_SEEN_NORMAL, GBUFFER_SEEN_ROUGHNESS,
                       GBUFFER_SEEN_METALLIC, GBUFFER_SEEN_OCCLUSION, GBUFFER_SEEN_F0, GBUFFER_SEEN_F90},
         .color_target = 0,
         .normal_target = 1,
         .own = FNL_NORMALS_OCTAHEDRAL,
         .encodings = TWO,
         .published_bits = 224, /* ours: depth 32, these 128, radiance 64 */
         .metallic = true,
         .strength = true,
         .tint = true},
    [FNL_GBUFFER_SIEGE] = {.target_count = 4,
                           .targets = {{"gbuffer normal", RGB10},
                                       {"gbuffer color", SRGB8},
                                       {"gbuffer parameters", RGBA8},
                                       {"gbuffer motion", RGBA8}},
                           .field_count = 9,
                           .fields = {{"normal", 0, 30},
                                      {"bias of indirect light (0)", 0, 2},
                                      {"base colour", 1, 24},
                                      {"material ID", 1, 8},
                                      {"metalness", 2, 8},
                                      {"smoothness", 2, 8},
                                      {"occlusion", 2, 8},
                                      {"aliased: specular strength, or smoothness", 2, 8},
                                      {"motion", 3, 32}},
                           .semantics = {GBUFFER_SEEN_NORMAL, GBUFFER_SEEN_CHANNEL(3), GBUFFER_SEEN_COLOR,
                                         GBUFFER_SEEN_MATERIAL, GBUFFER_SEEN_METALLIC, GBUFFER_SEEN_ROUGHNESS,
                                         GBUFFER_SEEN_OCCLUSION, GBUFFER_SEEN_CHANNEL(3), GBUFFER_SEEN_MOTION},
                           .color_target = 1,
                           .normal_target = 0,
                           .id_count = 256,
                           .own = FNL_NORMALS_XYZ,
                           .encodings = TWO | BIT(XYZ),
                           .published_bits = 160,
                           .metallic = true,
                           .strength = true},
    [FNL_GBUFFER_KILLZONE2] = {.target_count = 3,
                               .targets = {{"gbuffer normal", RGBA8},
                                           {"gbuffer parameters", RGBA8},
                                           {"gbuffer color", SRGB8}},
                               .field_count = 6,
                               .fields = {{"normal", 0, 32},
                                          {"motion", 1, 16},
                                          {"specular power", 1, 8},
                                          {"specular intensity", 1, 8},
                                          {"base colour", 2, 24},
                                          {"occlusion", 2, 8}},
                               .semantics = {GBUFFER_SEEN_NORMAL, GBUFFER_SEEN_MOTION, GBUFFER_SEEN_ROUGHNESS,
                                             GBUFFER_SEEN_F0, GBUFFER_SEEN_COLOR, GBUFFER_SEEN_OCCLUSION},
                               .color_target = 2,
                               .normal_target = 0,
                               .own = FNL_NORMALS_VIEW,
                               .encodings = TWO,
                               .published_bits = 160},
    [FNL_GBUFFER_FROSTBITE2] =
        {.target_count = 3,
         .targets = {{"gbuffer normal", RGBA8}, {"gbuffer color", SRGB8}, {"gbuffer parameters", RGBA8}},
         .field_count = 8,
         .fields = {{"normal", 0, 24},
                    {"smoothness", 0, 8},
                    {"base colour", 1, 24},
                    {"specular strength", 1, 8},
                    {"occlusion", 2, 8},
                    {"environment map (0)", 2, 8},
                    {"parameter: metalness, or smoothness", 2, 8},
                    {"material ID", 2, 8}},
         .semantics = {GBUFFER_SEEN_NORMAL, GBUFFER_SEEN_ROUGHNESS, GBUFFER_SEEN_COLOR, GBUFFER_SEEN_F90,
                       GBUFFER_SEEN_OCCLUSION, GBUFFER_SEEN_CHANNEL(1), GBUFFER_SEEN_CHANNEL(2), GBUFFER_SEEN_MATERIAL},
         .color_target = 1,
         .normal_target = 0,
         .id_count = 256,
         .own = FNL_NORMALS_XYZ,
         .encodings = TWO | BIT(XYZ) | BIT(BEST_FIT),
         .published_bits = 160,
         .metallic = true,
         .strength = true},
    [FNL_GBUFFER_STALKER] =
        {.target_count = 3,
         .targets = {{"gbuffer position", RGBA16F}, {"gbuffer normal", RGBA16F}, {"gbuffer color", SRGB8}},
         .field_count = 6,
         .fields = {{"position", 0, 48},
                    {"material ID", 0, 16},
                    {"normal", 1, 48},
                    {"occlusion", 1, 16},
                    {"base colour", 2, 24},
                    {"smoothness", 2, 8}},
         .semantics = {GBUFFER_SEEN_POSITION, GBUFFER_SEEN_MATERIAL, GBUFFER_SEEN_NORMAL, GBUFFER_SEEN_OCCLUSION,
                       GBUFFER_SEEN_COLOR, GBUFFER_SEEN_ROUGHNESS},
         .color_target = 2,
         .normal_target = 1,
         .id_count = 2048, /* half floats hold all integers up to here */
         .own = FNL_NORMALS_XYZ,
         .encodings = TWO | BIT(XYZ),
         .published_bits = 160},
    [FNL_GBUFFER_CLEAR_SKY] = {.target_count = 2,
                               .targets = {{"gbuffer normal", RGBA16F}, {"gbuffer color", SRGB8}},
                               .field_count = 6,
                               .fields = {{"normal", 0, 32},
                                          {"view depth", 0, 16},
                                          {"material ID", 0, 8},
                                          {"occlusion", 0, 7},
                                          {"base colour", 1, 24},
                                          {"smoothness", 1, 8}},
                               .semantics = {GBUFFER_SEEN_NORMAL, GBUFFER_SEEN_DEPTH, GBUFFER_SEEN_MATERIAL,
                                             GBUFFER_SEEN_OCCLUSION, GBUFFER_SEEN_COLOR, GBUFFER_SEEN_ROUGHNESS},
                               .color_target = 1,
                               .normal_target = 0,
                               .id_count = 256,
                               .own = FNL_NORMALS_VIEW,
                               .encodings = TWO,
                               .published_bits = 96},
    [FNL_GBUFFER_ENGEL] = {.target_count = 3,
                           .targets = {{"gbuffer normal", RG16F}, {"gbuffer parameters", RGBA8}, {"gbuffer color", SRGB8}},
                           .field_count = 6,
                           .fields = {{"normal", 0, 32},
                                      {"motion", 1, 16},
                                      {"specular power", 1, 8},
                                      {"specular intensity", 1, 8},
                                      {"base colour", 2, 24},
                                      {"occlusion", 2, 8}},
                           .semantics = {GBUFFER_SEEN_NORMAL, GBUFFER_SEEN_MOTION, GBUFFER_SEEN_ROUGHNESS, GBUFFER_SEEN_F0,
                                         GBUFFER_SEEN_COLOR, GBUFFER_SEEN_OCCLUSION},
                           .color_target = 2,
                           .normal_target = 0,
                           .own = FNL_NORMALS_VIEW,
                           .encodings = TWO,
                           .published_bits = 160},
    [FNL_GBUFFER_DESTINY] = {.target_count = 2,
                             .targets = {{"gbuffer color", SRGB8}, {"gbuffer normal", RGBA8}},
                             .field_count = 5,
                             .fields = {{"base colour", 0, 24},
                                        {"occlusion", 0, 8},
                                        {"normal", 1, 24},
                                        {"smoothness, in the normal's length", 1, 0},
                                        {"material ID", 1, 8}},
                             .semantics = {GBUFFER_SEEN_COLOR, GBUFFER_SEEN_OCCLUSION, GBUFFER_SEEN_NORMAL,
                                           GBUFFER_SEEN_ROUGHNESS, GBUFFER_SEEN_MATERIAL},
                             .color_target = 0,
                             .normal_target = 1,
                             .id_count = 256,
                             .own = FNL_NORMALS_XYZ,
                             .encodings = BIT(XYZ),
                             .published_bits = 96},
    [FNL_GBUFFER_LAYERS] = {.target_count = 5,
                            .targets = {{"gbuffer color", RGB10},
                                        {"gbuffer normal", RGBA16},
                                        {"gbuffer dielectric", RGBA8},
                                        {"gbuffer coat", RGBA16},
                                        {"gbuffer anisotropy", RG16}},
                            .field_count = 13,
                            .fields = {{"base colour", 0, 30},
                                       {"unused", 0, 2},
                                       {"normal", 1, 32},
                                       {"roughness", 1, 16},
                                       {"metalness", 1, 8},
                                       {"occlusion", 1, 8},
                                       {"dielectric F0", 2, 24},
                                       {"F90", 2, 8},
                                       {"normal of the coat", 3, 32},
                                       {"roughness of the coat", 3, 16},
                                       {"strength of the coat", 3, 16},
                                       {"strength of the anisotropy", 4, 16},
                                       {"angle of the anisotropy", 4, 16}},
                            .semantics = {GBUFFER_SEEN_COLOR, GBUFFER_SEEN_CHANNEL(3), GBUFFER_SEEN_NORMAL, GBUFFER_SEEN_ROUGHNESS,
                                          GBUFFER_SEEN_METALLIC, GBUFFER_SEEN_OCCLUSION, GBUFFER_SEEN_F0, GBUFFER_SEEN_F90, GBUFFER_SEEN_COAT_NORMAL,
                                          GBUFFER_SEEN_CHANNEL(2), GBUFFER_SEEN_CHANNEL(3), GBUFFER_SEEN_CHANNEL(0), GBUFFER_SEEN_CHANNEL(1)},
                            .color_target = 0,
                            .normal_target = 1,
                            .own = FNL_NORMALS_OCTAHEDRAL,
                            .encodings = TWO & ~BIT(FLOAT), /* there is no sixth target */
                            .published_bits = 320, /* ours: depth 32, these 224, radiance 64 */
                            .metallic = true,
                            .strength = true,
                            .tint = true,
                            .layers = true},
};

uint32_t gbuffer_format_bits(VkFormat format) {
    switch (format) {
    case VK_FORMAT_R8G8_UNORM:
        return 16;
    case RGBA16:
    case RGBA16F:
        return 64;
    case VK_FORMAT_R32G32B32A32_SFLOAT:
        return 128;
    default:
        return 32;
    }
}

uint32_t gbuffer_bytes(fnl_gbuffer layout, fnl_normal_encoding normals, bool chroma) {
    const struct gbuffer_layout *l = &gbuffer_layouts[layout];
    uint32_t bits = 0;
    for (uint32_t i = 0; i < l->target_count; i++) bits += gbuffer_format_bits(l->targets[i].format);
    if (chroma) bits -= 16;
    if (normals == FNL_NORMALS_FLOAT) bits += 128;
    return bits / 8;
}

uint32_t gbuffer_form_of(fnl_gbuffer layout, fnl_normal_encoding normals, bool chroma) {
    fnl_normal_encoding used = normals == FNL_NORMALS_LAYOUT ? gbuffer_layouts[layout].own : normals;
    return GBUFFER_FORM((uint32_t)layout, (uint32_t)used) | (chroma ? GBUFFER_FORM_CHROMA : 0);
}

bool gbuffer_holds(fnl_gbuffer layout, const struct gbuffer_material *m) {
    const struct gbuffer_layout *l = &gbuffer_layouts[layout];
    if (m->layered && (!l->layers || m->other_layers)) return false;
    if (l->tint) return true;
    if (m->id >= l->id_count && l->id_count) return false;
    if (m->unlit) return true;
    if (m->specular_color_texture || (m->specular_texture && !l->strength)) return false;
    if (l->id_count) return l->metallic || m->metallic == 0 || !m->metallic_texture;
    /* One reflectance for all colours, and nothing to say that a surface is a metal or weaker than its reflectance says. */
    vec3 f0 = m->dielectric_f0;
    return m->metallic == 0 && m->specular == 1 && f0.x == f0.y && f0.y == f0.z && f0.x > 0;
}

struct gpu_material_entry gbuffer_entry(const struct gbuffer_material *m) {
    struct gpu_material_entry entry = {0};
    if (m->unlit) return entry;
    vec3 f0 = m->dielectric_f0;
    entry.dielectric_f0 = (vec3){MIN(f0.x, 1), MIN(f0.y, 1), MIN(f0.z, 1)};
    entry.dielectric_f90 = m->specular;
    entry.metallic = m->metallic < 0 ? 0 : MIN(m->metallic, 1);
    entry.second = (m->specular_texture ? GBUFFER_SECOND_STRENGTH : 0) |
                   (m->metallic_texture && m->metallic > 0 ? GBUFFER_SECOND_METALLIC : 0);
    return entry;
}

fnl_result fnl_gbuffer_query_info(fnl_gbuffer layout, fnl_gbuffer_info *out) {
    const fnl_host host = fnl_host_default();
    TRY(check_enum(CALL(&host), "layout", (int)layout, FNL_GBUFFER_COUNT, "fnl_gbuffer"));
    TRY(check_pointer(CALL(&host), "out", out));
    const struct gbuffer_layout *l = &gbuffer_layouts[layout];
    *out = (fnl_gbuffer_info){.target_count = l->target_count,
                              .published_bits = l->published_bits,
                              .material_count = l->id_count,
                              .normals = l->own,
                              .encodings = l->encodings | 1u << FNL_NORMALS_LAYOUT,
                              .field_count = l->field_count,
                              .fields = l->fields};
    for (uint32_t i = 0; i < l->target_count; i++) {
        out->target_bits[i] = gbuffer_format_bits(l->targets[i].format);
        out->bits += out->target_bits[i];
    }
    return FNL_OK;
}
