/* SPDX-License-Identifier: MIT */
#include "passes/shade/gbuffer_layouts.h"
#include "render/device/scene.h"

static VkSamplerAddressMode address_mode(enum scene_wrap wrap) {
    return wrap == SCENE_WRAP_REPEAT   ? VK_SAMPLER_ADDRESS_MODE_REPEAT
           : wrap == SCENE_WRAP_MIRROR ? VK_SAMPLER_ADDRESS_MODE_MIRRORED_REPEAT
                                       : VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
}

static bool is_anisotropic(const struct scene_sampler *s) { return s->mipmapped && s->min == SCENE_FILTER_LINEAR; }

static uint32_t sampler_index(struct device_scene *d, uint32_t index) {
    const struct scene_sampler *s = &d->scene->samplers.data[index];
    struct gpu_sampler_params params = {
        .mag = s->mag == SCENE_FILTER_LINEAR ? VK_FILTER_LINEAR : VK_FILTER_NEAREST,
        .min = s->min == SCENE_FILTER_LINEAR ? VK_FILTER_LINEAR : VK_FILTER_NEAREST,
        .mip = s->mip == SCENE_FILTER_LINEAR ? VK_SAMPLER_MIPMAP_MODE_LINEAR : VK_SAMPLER_MIPMAP_MODE_NEAREST,
        .mipmapped = s->mipmapped,
        .wrap_u = address_mode(s->wrap_u),
        .wrap_v = address_mode(s->wrap_v),
        .anisotropy = is_anisotropic(s) ? d->scene->anisotropy : 1,
        .bias = s->mipmapped ? d->scene->texture_bias : 0};
    return gpu_sampler_index(d->device, &params);
}

/* At normal incidence, before the strength; an index of 0 means total reflection (KHR_materials_ior). */
static vec3 dielectric_f0(const struct scene_material *m) {
    float r = m->ior > 0 ? (m->ior - 1) / (m->ior + 1) : 1;
    return vec3_scale(m->specular_color, r * r);
}

bool device_has_texture(const struct device_scene *d, const struct scene_material *m, enum scene_texture_slot slot) {
    uint32_t image = m->textures[slot].image;
    return image != SCENE_NONE && (d->images.data[image].gpu.handle || d->images.data[image].coming);
}

static struct gbuffer_material gbuffer_material(const struct device_scene *d, const struct scene_material *m, uint32_t id) {
    /* A texture of one metalness is as good as a factor: roughness often comes with a blue of nothing but 0. */
    bool textured = device_has_texture(d, m, SCENE_TEXTURE_METALLIC_ROUGHNESS);
    int16_t blue = textured ? d->images.data[m->textures[SCENE_TEXTURE_METALLIC_ROUGHNESS].image].blue : 255;
    return (struct gbuffer_material){.id = id,
                                     .metallic = blue < 0 ? m->metallic : m->metallic * (float)blue / 255,
                                     .dielectric_f0 = dielectric_f0(m),
                                     .specular = m->specular,
                                     .unlit = m->unlit,
                                     .metallic_texture = blue < 0,
                                     .specular_texture = device_has_texture(d, m, SCENE_TEXTURE_SPECULAR),
                                     .specular_color_texture = device_has_texture(d, m, SCENE_TEXTURE_SPECULAR_COLOR),
                                     .layered = scene_material_layered(m),
                                     .other_layers = scene_material_layered_besides(m)};
}

uint32_t device_material_forward_layouts(const struct device_scene *d, const struct scene_material *m, uint32_t id) {
    struct gbuffer_material material = gbuffer_material(d, m, id);
    uint32_t bits = 0;
    for (uint32_t i = 0; i < FNL_GBUFFER_COUNT; i++) bits |= (uint32_t)!gbuffer_holds((fnl_gbuffer)i, &material) << i;
    if (material.layered) bits |= 1u << GEOMETRY_LAYERED;
    if (scene_material_transmissive(m)) bits |= 1u << GEOMETRY_TRANSMISSIVE;
    if (!device_virtual_holds(d, m)) bits |= 1u << VIRTUAL_FORWARD;
    return bits;
}

/* A factor of 0 leaves nothing for a texture to multiply. */
static uint32_t material_class(const struct device_scene *d, const struct scene_material *m) {
    uint32_t bits = m->unlit ? 0 : GPU_CLASS_LIT | (m->metallic > 0 ? GPU_CLASS_METAL : 0);
    for (int slot = 0; slot < SCENE_TEXTURE_SLOT_COUNT; slot++)
        if (device_has_texture(d, m, (enum scene_texture_slot)slot)) bits |= GPU_CLASS_TEXTURES;
    if (scene_material_layered(m)) bits |= GPU_CLASS_LAYERS | GPU_CLASS_METAL;
    return bits | (device_has_texture(d, m, SCENE_TEXTURE_NORMAL) ? GPU_CLASS_NORMAL_MAP : 0);
}

/* Where neither has a picture they are the same too. */
static bool same_texture(const struct gpu_texture *a, const struct gpu_texture *b) {
    return a->image == b->image && a->sampler_index == b->sampler_index && a->flags == b->flags &&
           memcmp(a->transform, b->transform, sizeof a->transform) == 0;
}

/* Until its image has come the material shows its factors. */
static struct gpu_texture device_texture(struct device_scene *d, const struct scene_material *m, enum scene_texture_slot slot) {
    const struct scene_texture *t = &m->textures[slot];
    struct gpu_texture out = {.image = GPU_TEXTURE_NONE};
    if (!device_has_texture(d, m, slot)) return out;
    const struct gpu_image *image = &d->images.data[t->image].gpu;
    if (image->handle) out.image = scene_texture_is_color(slot) && image->srgb_index != GPU_NO_INDEX ? image->srgb_index : image->sampled_index;
    out.sampler_index = sampler_index(d, t->sampler);
    const struct scene_sampler *s = &d->scene->samplers.data[t->sampler];
    out.flags = (t->uv_set ? GPU_TEXTURE_UV1 : 0) | (is_anisotropic(s) ? 0 : GPU_TEXTURE_ROUND);
    if (t->uv_set) d->texture_bits |= GEOMETRY_UV1;
    memcpy(out.transform, t->transform, sizeof out.transform);
    return out;
}

/* Beer's law, per metre: white light has the colour after the distance. */
static vec3 absorption_of(const fnl_volume_params *volume) {
    float out[3];
    for (int i = 0; i < 3; i++) out[i] = -logf(fmaxf(volume->attenuation_color[i], 1e-6f)) / volume->attenuation_distance;
    return vec3_make(out[0], out[1], out[2]);
}

static vec4 turn_of(const struct scene_material *m, enum scene_texture_slot slot, float scale) {
    float t[4];
    scene_texture_turn_of(m, slot, t);
    return vec4_make(t[0] * scale, t[1] * scale, t[2] * scale, t[3] * scale);
}

/* The material turns the direction within the texture's axes. */
static vec4 anisotropy_turn(const struct scene_material *m) {
    const float c = cosf(m->anisotropy.rotation), s = sinf(m->anisotropy.rotation);
    const vec4 t = turn_of(m, SCENE_TEXTURE_ANISOTROPY, 1);
    return vec4_make(t.x * c + t.y * s, t.y * c - t.x * s, t.z * c + t.w * s, t.w * c - t.z * s);
}

static struct gpu_layers device_layers(struct device_scene *d, const struct scene_material *m) {
    struct gpu_layers g = {.clearcoat_normal_turn = turn_of(m, SCENE_TEXTURE_CLEARCOAT_NORMAL, m->clearcoat.normal_scale),
                           .anisotropy_turn = anisotropy_turn(m),
                           .absorption = absorption_of(&m->volume),
                           .ior = m->ior > 0 ? m->ior : 1.5f};
#define NUMBER(id, member, ...)                                                            \
    _Static_assert(sizeof g.id == sizeof m->member, #id " is another type on the device"); \
    memcpy(&g.id, &m->member, sizeof g.id);
    MATERIAL_LAYER_NUMBERS(NUMBER, NUMBER)
#undef NUMBER
    for (int i = 0; i < GPU_LAYER_TEXTURE_COUNT; i++) g.textures[i] = device_texture(d, m, (enum scene_texture_slot)(SCENE_TEXTURE_CORE_COUNT + i));
    return g;
}

_Static_assert((int)SCENE_TEXTURE_CORE_COUNT == GPU_TEXTURE_COUNT &&
                   (int)SCENE_TEXTURE_SLOT_COUNT == GPU_TEXTURE_COUNT + GPU_LAYER_TEXTURE_COUNT,
               "the device has the slots of scene.h");
#define TEXTURE(slot, ...) _Static_assert((int)SCENE_TEXTURE_##slot == GPU_TEXTURE_COUNT + GPU_TEXTURE_##slot, #slot " has another slot on the device");
MATERIAL_LAYER_TEXTURES(TEXTURE)
#undef TEXTURE

static struct gpu_material device_material(struct device_scene *d, const struct scene_material *m, uint32_t id) {
    struct gpu_material g = {.base_color = m->base_color,
                             .emissive = m->emissive,
                             .metallic = m->metallic,
                             .roughness = m->roughness,
                             .dielectric_f0 = dielectric_f0(m),
                             .specular = m->specular,
                             .normal_turn = turn_of(m, SCENE_TEXTURE_NORMAL, m->normal_scale),
                             .occlusion_strength = m->occlusion_strength,
                             .alpha_cutoff = scene_material_cutoff(m),
                             .flags = (m->unlit ? GPU_MATERIAL_UNLIT : 0) |
                                      (m->alpha_mode == FNL_ALPHA_MASK ? GPU_MATERIAL_MASK : 0) |
                                      (m->alpha_mode == FNL_ALPHA_BLEND ? GPU_MATERIAL_BLEND : 0) |
                                      (m->double_sided ? GPU_MATERIAL_DOUBLE_SIDED : 0) |
                                      (m->casts_shadows ? 0 : GPU_MATERIAL_SHADOWLESS) |
                                      (scene_material_layered(m) ? GPU_MATERIAL_LAYERED : 0) |
                                      (scene_material_transmissive(m) ? GPU_MATERIAL_TRANSMISSIVE : 0) |
                                      (scene_material_dark(m) ? GPU_MATERIAL_DARK : 0) |
                                      material_class(d, m) << GPU_MATERIAL_CLASS_SHIFT,
                             .forward_layouts = device_material_forward_layouts(d, m, id)};
    for (int slot = 0; slot < SCENE_TEXTURE_CORE_COUNT; slot++) g.textures[slot] = device_texture(d, m, (enum scene_texture_slot)slot);
    /* Until it has come: most of such a picture is black, its factor would make everything glow. */
    if (device_has_texture(d, m, SCENE_TEXTURE_EMISSIVE) && g.textures[SCENE_TEXTURE_EMISSIVE].image == GPU_TEXTURE_NONE) g.emissive = (vec3){0, 0, 0};
    if (same_texture(&g.textures[SCENE_TEXTURE_OCCLUSION], &g.textures[SCENE_TEXTURE_METALLIC_ROUGHNESS]))
        g.flags |= GPU_MATERIAL_SHARED_OCCLUSION;
    return g;
}

/* By what device_items_upload() sorts. The last ones sent are those before. */
static bool moves_buckets(const struct device_scene *d, const struct gpu_material *materials, uint32_t count) {
    const struct gpu_material *before = (const struct gpu_material *)(const void *)d->materials.sent.data;
    if (d->materials.sent.count != count * sizeof *before) return true;
    for (uint32_t i = 0; i < count; i++)
        if (before[i].forward_layouts != materials[i].forward_layouts) return true;
    return false;
}

bool device_has_layers(const struct device_scene *d) { return d->layers.sent.count > 0; }

/* What layered materials have besides, and where each finds it. */
static fnl_result upload_layers(struct device_scene *d, struct gpu_material *materials) {
    ARRAY(struct gpu_layers) layers = {0};
    fnl_result result = FNL_OK;
    for (uint32_t i = 0; i < d->scene->materials.count && result == FNL_OK; i++) {
        const struct scene_material *m = &d->scene->materials.data[i];
        if (scene_material_layered(m) && !array_push(&d->host, &layers, device_layers(d, m))) result = FNL_ERROR_MEMORY;
    }
    if (result == FNL_OK && (layers.count > 0 || device_has_layers(d)))
        result = device_array_set(d, GPU_USE_GEOMETRY, "layers", &d->layers, layers.data, layers.count, sizeof *layers.data);
    for (uint32_t i = 0, at = 0; i < d->scene->materials.count && result == FNL_OK; i++)
        if (materials[i].flags & GPU_MATERIAL_LAYERED) materials[i].layers = d->layers.buffer.address + sizeof *layers.data * at++;
    array_free(&d->host, &layers);
    return result;
}

fnl_result device_materials_upload(struct device_scene *d, bool *out_regroup) {
    uint32_t count = d->scene->materials.count + 1;
    struct scene_material standard = scene_material_default();
    struct gpu_material *materials = host_allocate(&d->host, count * sizeof *materials);
    struct gpu_material_entry *entries = host_allocate(&d->host, count * sizeof *entries);
    fnl_result result = materials && entries ? FNL_OK : FNL_ERROR_MEMORY;
    d->material_count = count;
    d->material_classes = d->texture_bits = 0;
    d->mapped = false;
    for (uint32_t i = 0; i < count && result == FNL_OK; i++) {
        const struct scene_material *m = i + 1 < count ? &d->scene->materials.data[i] : &standard;
        materials[i] = device_material(d, m, i);
        d->mapped = d->mapped || device_has_texture(d, m, SCENE_TEXTURE_NORMAL) ||
                    device_has_texture(d, m, SCENE_TEXTURE_CLEARCOAT_NORMAL);
        if (!scene_material_transmissive(m)) d->material_classes |= 1u << material_class(d, m); /* no order but its own shades it */
        struct gbuffer_material held = gbuffer_material(d, m, i);
        entries[i] = gbuffer_entry(&held);
    }
    if (result == FNL_OK) result = upload_layers(d, materials);
    *out_regroup = result == FNL_OK && moves_buckets(d, materials, count);
    if (result == FNL_OK) result = device_array_set(d, GPU_USE_GEOMETRY, "materials", &d->materials, materials, count, sizeof *materials);
    if (result == FNL_OK)
        result = device_array_set(d, GPU_USE_GEOMETRY, "material entries", &d->material_entries, entries, count, sizeof *entries);
    if (materials) host_free(&d->host, materials, count * sizeof *materials);
    if (entries) host_free(&d->host, entries, count * sizeof *entries);
    return result;
}
