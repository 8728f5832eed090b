/* SPDX-License-Identifier: MIT */
/**
 * The layers of materials, each with its numbers and textures. A row here is all that loading, saving, animation, the public calls and user interfaces
 * need for a number or a texture (layer_rows.h). A new layer also needs its struct in fanal/mesh.h, its members in shaders/layers_shared.h, and its light
 * in shaders/layers.glsl and ray/layers.c.
 */
#ifndef FNL_SCENE_MATERIAL_LAYERS_H
#define FNL_SCENE_MATERIAL_LAYERS_H

#include "fanal/mesh.h"

/* LAYER(member, type, extension): the member of fnl_material_params and struct scene_material, and the glTF extension. In the order of loading. */
#define MATERIAL_LAYERS(LAYER)                                                 \
    LAYER(clearcoat, fnl_clearcoat_params, "KHR_materials_clearcoat")          \
    LAYER(sheen, fnl_sheen_params, "KHR_materials_sheen")                      \
    LAYER(iridescence, fnl_iridescence_params, "KHR_materials_iridescence")    \
    LAYER(anisotropy, fnl_anisotropy_params, "KHR_materials_anisotropy")       \
    LAYER(transmission, fnl_transmission_params, "KHR_materials_transmission") \
    LAYER(volume, fnl_volume_params, "KHR_materials_volume")                   \
    LAYER(dispersion, float, "KHR_materials_dispersion")                       \
    LAYER(diffuse_transmission, fnl_diffuse_transmission_params, "KHR_materials_diffuse_transmission")

/*
 * SCALAR or COLOR(id, member, extension, key, low, high, more): a float, or three of a linear color. `id` is its name in gpu_layers and ray_layers; `key`
 * its JSON key, which may lead into a texture of the layer; low and high are its limits; `more` sets further members of struct layer_number.
 */
#define MATERIAL_LAYER_NUMBERS(SCALAR, COLOR)                                                                                                           \
    SCALAR(clearcoat, clearcoat.strength, "KHR_materials_clearcoat", "clearcoatFactor", 0, 1, .on = LAYER_IN_GBUFFER, .label = "clearcoat")             \
    SCALAR(clearcoat_roughness, clearcoat.roughness, "KHR_materials_clearcoat", "clearcoatRoughnessFactor", 0, 1, .label = "coat roughness")            \
    SCALAR(clearcoat_normal_scale, clearcoat.normal_scale, "KHR_materials_clearcoat", "clearcoatNormalTexture/scale", -FLT_MAX, FLT_MAX, .zero = 1)     \
    COLOR(sheen_color, sheen.color, "KHR_materials_sheen", "sheenColorFactor", 0, 1, .on = LAYER_FORWARD, .label = "sheen")                             \
    SCALAR(sheen_roughness, sheen.roughness, "KHR_materials_sheen", "sheenRoughnessFactor", 0, 1, .label = "sheen roughness")                           \
    SCALAR(film, iridescence.strength, "KHR_materials_iridescence", "iridescenceFactor", 0, 1, .on = LAYER_FORWARD, .label = "iridescence")             \
    SCALAR(film_ior, iridescence.ior, "KHR_materials_iridescence", "iridescenceIor", 1, FLT_MAX, .zero = 1.3f)                                          \
    SCALAR(film_thinnest, iridescence.thickness_minimum, "KHR_materials_iridescence", "iridescenceThicknessMinimum", 0, FLT_MAX, .zero = 100,           \
           .zero_with = PARAMS(iridescence.thickness_maximum), .unit = " nm", .label = "film, nm at least", .most = 1200,                               \
           .under = PARAMS(iridescence.strength))                                                                                                       \
    SCALAR(film_thickest, iridescence.thickness_maximum, "KHR_materials_iridescence", "iridescenceThicknessMaximum", 0, FLT_MAX, .zero = 400,           \
           .zero_with = PARAMS(iridescence.thickness_minimum), .unit = " nm", .label = "film, nm at most", .most = 1200,                                \
           .under = PARAMS(iridescence.strength))                                                                                                       \
    SCALAR(anisotropy, anisotropy.strength, "KHR_materials_anisotropy", "anisotropyStrength", 0, 1, .on = LAYER_IN_GBUFFER, .label = "anisotropy")      \
    SCALAR(anisotropy_rotation, anisotropy.rotation, "KHR_materials_anisotropy", "anisotropyRotation", -FLT_MAX, FLT_MAX, .unit = " radians",           \
           .label = "anisotropy direction", .help = "Radians from the tangent", .least = -3.1416f, .most = 3.1416f)                                     \
    SCALAR(transmission, transmission.strength, "KHR_materials_transmission", "transmissionFactor", 0, 1, .on = LAYER_FORWARD, .label = "transmission") \
    SCALAR(thickness, volume.thickness, "KHR_materials_volume", "thicknessFactor", 0, FLT_MAX, .unit = " m", .label = "thickness", .most = 10)          \
    SCALAR(attenuation_distance, volume.attenuation_distance, "KHR_materials_volume", "attenuationDistance", 1e-30f, FLT_MAX, .zero = INFINITY,         \
           .unit = " m", .label = "attenuation, m", .most = 100,                                                                                        \
           .help = "Distance in meters at which white light takes on the color below; 0: no attenuation")                                               \
    COLOR(attenuation_color, volume.attenuation_color, "KHR_materials_volume", "attenuationColor", 0, 1, .unsaid = 1, .label = "attenuation")           \
    SCALAR(dispersion, dispersion, "KHR_materials_dispersion", "dispersion", 0, FLT_MAX, .label = "dispersion", .most = 10)                             \
    SCALAR(diffuse_transmission, diffuse_transmission.strength, "KHR_materials_diffuse_transmission", "diffuseTransmissionFactor", 0, 1,                \
           .on = LAYER_FORWARD, .label = "diffuse transmission")                                                                                        \
    COLOR(diffuse_transmission_color, diffuse_transmission.color, "KHR_materials_diffuse_transmission", "diffuseTransmissionColorFactor", 0, 1,         \
          .unsaid = 1, .label = "diffuse transmission color")

/*
 * TEXTURE(slot, member, extension, key, label, kind): SCENE_TEXTURE_slot, the member of fnl_material_params with the image, and what it holds: COLOR,
 * NUMBERS or NORMALS. The order is that of GPU_TEXTURE_… in shaders/layers_shared.h.
 */
#define MATERIAL_LAYER_TEXTURES(TEXTURE)                                                                                                           \
    TEXTURE(CLEARCOAT, clearcoat.image, "KHR_materials_clearcoat", "clearcoatTexture", "clearcoat", NUMBERS)                                       \
    TEXTURE(CLEARCOAT_ROUGHNESS, clearcoat.roughness_image, "KHR_materials_clearcoat", "clearcoatRoughnessTexture", "coat roughness", NUMBERS)     \
    TEXTURE(CLEARCOAT_NORMAL, clearcoat.normal_image, "KHR_materials_clearcoat", "clearcoatNormalTexture", "coat normals", NORMALS)                \
    TEXTURE(SHEEN_COLOR, sheen.color_image, "KHR_materials_sheen", "sheenColorTexture", "sheen", COLOR)                                            \
    TEXTURE(SHEEN_ROUGHNESS, sheen.roughness_image, "KHR_materials_sheen", "sheenRoughnessTexture", "sheen roughness", NUMBERS)                    \
    TEXTURE(IRIDESCENCE, iridescence.image, "KHR_materials_iridescence", "iridescenceTexture", "iridescence", NUMBERS)                             \
    TEXTURE(IRIDESCENCE_THICKNESS, iridescence.thickness_image, "KHR_materials_iridescence", "iridescenceThicknessTexture", "film", NUMBERS)       \
    TEXTURE(ANISOTROPY, anisotropy.image, "KHR_materials_anisotropy", "anisotropyTexture", "anisotropy", NUMBERS)                                  \
    TEXTURE(TRANSMISSION, transmission.image, "KHR_materials_transmission", "transmissionTexture", "transmission", NUMBERS)                        \
    TEXTURE(THICKNESS, volume.image, "KHR_materials_volume", "thicknessTexture", "thickness", NUMBERS)                                             \
    TEXTURE(DIFFUSE_TRANSMISSION, diffuse_transmission.image, "KHR_materials_diffuse_transmission", "diffuseTransmissionTexture",                  \
            "diffuse transmission", NUMBERS)                                                                                                       \
    TEXTURE(DIFFUSE_TRANSMISSION_COLOR, diffuse_transmission.color_image, "KHR_materials_diffuse_transmission", "diffuseTransmissionColorTexture", \
            "diffuse transmission color", COLOR)

#endif
