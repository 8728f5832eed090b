/* SPDX-License-Identifier: MIT */
/* Images, samplers, textures and materials of a file that is saved. */
#include "image/image.h"
#include "scene/glb.h"

/* ---- images ---- */

/* Whether its pixels are others than the file's. */
static bool is_repainted(const struct glb *g, uint32_t image) {
    return image < g->image_count && g->file && g->scene->images.data[image].version != g->file->images.data[image].version;
}

static uint32_t add_picture(struct glb *g, const void *bytes, uint64_t size, const char *kind) {
    char type[40];
    snprintf(type, sizeof type, "image/%s", strcmp(kind, "dds") == 0 ? "vnd-ms.dds" : kind);
    const uint32_t view = glb_add_view(g, bytes, size, 0);
    return glb_add(g, "images", json_pack("{s:i,s:s}", "bufferView", (int)view, "mimeType", type));
}

static uint32_t add_pixels(struct glb *g, const struct scene_image *image) {
    const fnl_image picture = {image->width, image->height, FNL_PIXEL_FORMAT_RGBA8, image->pixels};
    char *bytes;
    size_t size;
    const fnl_result result = image_png_encode(g->host, image->name, &picture, &bytes, &size);
    if (result == FNL_OK && array_push(g->host, &g->pictures, bytes)) return add_picture(g, bytes, size, "png");
    if (result == FNL_OK) free(bytes);
    if (g->result == FNL_OK) g->result = result == FNL_OK ? FNL_ERROR_MEMORY : result;
    return SCENE_NONE;
}

/* The bytes as they are in the document: for colours and for numbers there may be two images in the scene. */
static uint32_t twin_of(const struct glb *g, const struct scene_image *image) {
    for (uint32_t i = 0; i < g->image_count && image->encoded; i++)
        if (g->scene->images.data[i].encoded == image->encoded) return i;
    return SCENE_NONE;
}

static uint32_t image_of(struct glb *g, uint32_t index) {
    const struct scene_image *image = &g->scene->images.data[index];
    if (g->images[index] != SCENE_NONE || image->width == 0) return g->images[index];
    const bool of_file = g->file && index < g->file->images.count && image->version == g->file->images.data[index].version;
    uint32_t place = of_file && index < g->image_count ? index : of_file ? twin_of(g, image) : SCENE_NONE;
    if (place == SCENE_NONE)
        place = image->pixels ? add_pixels(g, image) : image->encoded ? add_picture(g, image->encoded, image->encoded_size, image->file_kind) : SCENE_NONE;
    return g->images[index] = place;
}

/* ---- samplers and textures ---- */

static uint32_t sampler_of(struct glb *g, uint32_t index) {
    enum { NEAREST = 9728, LINEAR = 9729, MIPMAPPED = 256, MIPMAPPED_LINEAR = 258 }; /* the mipmapped filters follow the plain ones */
    static const int wraps[] = {[SCENE_WRAP_REPEAT] = 10497, [SCENE_WRAP_MIRROR] = 33648, [SCENE_WRAP_CLAMP] = 33071};
    if (index == 0) return SCENE_NONE; /* glTF's default */
    if (index <= g->sampler_count && g->file) return index - 1;
    if (g->samplers[index] != SCENE_NONE) return g->samplers[index];
    const struct scene_sampler *s = &g->scene->samplers.data[index];
    int min = s->min == SCENE_FILTER_LINEAR ? LINEAR : NEAREST;
    if (s->mipmapped) min += s->mip == SCENE_FILTER_LINEAR ? MIPMAPPED_LINEAR : MIPMAPPED;
    return g->samplers[index] = glb_add(g, "samplers", json_pack("{s:i,s:i,s:i,s:i}", "magFilter", s->mag == SCENE_FILTER_LINEAR ? LINEAR : NEAREST, "minFilter",
                                                                 min, "wrapS", wraps[s->wrap_u], "wrapT", wraps[s->wrap_v]));
}

/* SCENE_NONE: the image is missing, and shown as white anyway. */
static uint32_t texture_of(struct glb *g, uint32_t image, uint32_t sampler) {
    static const char *const extensions[][2] = {{"webp", "EXT_texture_webp"}, {"ktx2", "KHR_texture_basisu"}, {"dds", "MSFT_texture_dds"}};
    for (uint32_t i = 0; i < g->textures.count; i++)
        if (g->textures.data[i].image == image && g->textures.data[i].sampler == sampler) return g->textures.data[i].index;
    const uint32_t source = image_of(g, image), filter = sampler_of(g, sampler);
    if (source == SCENE_NONE) return SCENE_NONE;
    json_t *texture = json_object(), *holder = texture;
    const struct scene_image *what = &g->scene->images.data[image];
    for (uint32_t i = 0; i < COUNT_OF(extensions); i++)
        if (!what->pixels && strcmp(what->file_kind, extensions[i][0]) == 0) holder = glb_extension(g, texture, extensions[i][1]);
    glb_set(g, holder, "source", json_integer((json_int_t)source));
    if (filter != SCENE_NONE) glb_set(g, texture, "sampler", json_integer((json_int_t)filter));
    const struct glb_texture made = {image, sampler, glb_add(g, "textures", texture)};
    if (!array_push(g->host, &g->textures, made) && g->result == FNL_OK) g->result = FNL_ERROR_MEMORY;
    return made.index;
}

static void set_transform(struct glb *g, json_t *info, const struct scene_texture *texture, const struct scene_texture_turn *said) {
    struct scene_texture_turn turn = *said;
    struct scene_texture again = *texture;
    const float *t = texture->transform;
    scene_turn_texture(&again, said);
    bool same = true;
    for (int i = 0; i < 6; i++) same = same && again.transform[i] == t[i];
    if (!same) {
        const bool turned = t[1] != 0 || t[3] != 0;
        turn = (struct scene_texture_turn){{t[2], t[5]}, {t[0], t[4]}, turned ? atan2f(-t[3], t[0]) : 0};
        if (turned) turn.scale[0] = sqrtf(t[0] * t[0] + t[3] * t[3]);
        if (turned) turn.scale[1] = copysignf(sqrtf(t[1] * t[1] + t[4] * t[4]), t[0] * t[4] - t[1] * t[3]);
    }
    glb_remove_extension(info, "KHR_texture_transform");
    if (turn.offset[0] == 0 && turn.offset[1] == 0 && turn.scale[0] == 1 && turn.scale[1] == 1 && turn.rotation == 0) return;
    json_t *extension = glb_extension(g, info, "KHR_texture_transform");
    glb_set(g, extension, "offset", glb_floats(turn.offset, 2));
    glb_set(g, extension, "scale", glb_floats(turn.scale, 2));
    if (turn.rotation != 0) glb_set(g, extension, "rotation", glb_float(turn.rotation));
}

/* ---- materials ---- */

/* The object that a path of names leads to, but for the last name, which `leaf` gets. `make`: missing ones are made, else NULL. */
static json_t *reach(struct glb *g, json_t *object, const char *path, bool make, char leaf[64]) {
    for (const char *end; object && (end = strchr(path, '/')); path = end + 1) {
        char name[64];
        snprintf(name, sizeof name, "%.*s", (int)(end - path), path);
        if (strcmp(name, "extensions") == 0) {
            path = end + 1;
            end = strchr(path, '/');
            snprintf(name, sizeof name, "%.*s", (int)(end - path), path);
            object = make ? glb_extension(g, object, name) : json_object_get(json_object_get(object, "extensions"), name);
        } else {
            object = make ? glb_object(g, object, name) : json_object_get(object, name);
        }
    }
    snprintf(leaf, 64, "%s", path);
    return object;
}

struct writing {
    struct glb *g;
    json_t *object;
    const struct scene_material *now, *base; /* base: what `object` says so far */
    uint32_t index;
    bool whole; /* it is new */
};

/* "KHR_materials_…" of a row's path; "" for the core. */
static void extension_of(const char *path, char out[64]) {
    static const char prefix[] = "extensions/";
    const bool has = strncmp(path, prefix, sizeof prefix - 1) == 0;
    const char *name = path + sizeof prefix - 1;
    snprintf(out, 64, "%.*s", has ? (int)strcspn(name, "/") : 0, has ? name : "");
}

static const float *value_of(const struct scene_material *material, const struct scene_property *property) {
    return (const float *)(const void *)((const char *)material + property->offset);
}

static bool texture_differs(const struct writing *w, enum scene_texture_slot slot) {
    const struct scene_texture *now = &w->now->textures[slot], *base = &w->base->textures[slot];
    if (now->image == SCENE_NONE && base->image == SCENE_NONE) return false;
    return now->image != base->image || now->sampler != base->sampler || now->uv_set != base->uv_set || is_repainted(w->g, now->image) ||
           (memcmp(now->transform, base->transform, sizeof now->transform) != 0 &&
            !glb_animates(w->g, SCENE_PROPERTY_MATERIAL, w->index, offsetof(struct scene_material, parts.turns) + slot * sizeof w->now->parts.turns[0] + offsetof(struct scene_texture_turn, offset)));
}

/* A row of gltf_query_property that is a material's: its path below the material. */
static const char *row_path(uint32_t row, uint32_t *width, const struct scene_property **property, bool *more) {
    static const char prefix[] = "/materials/#/";
    const char *pointer;
    *more = gltf_query_property(row, &pointer, width, property);
    return *more && (*property)->owner == SCENE_PROPERTY_MATERIAL ? pointer + sizeof prefix - 1 : NULL;
}

static bool row_differs(const struct writing *w, const char *path, uint32_t width, const struct scene_property *property) {
    static const char end[] = "/extensions/KHR_texture_transform/offset";
    if (property->effect == SCENE_EFFECT_TURN) {
        const size_t length = strlen(path);
        return length > sizeof end && strcmp(path + length - (sizeof end - 1), end) == 0 && texture_differs(w, property->slot);
    }
    if (property->effect == SCENE_EFFECT_EMISSIVE) return false;
    return memcmp(value_of(w->now, property), value_of(w->base, property), width * sizeof(float)) != 0 &&
           !glb_animates(w->g, SCENE_PROPERTY_MATERIAL, w->index, property->offset);
}

/* Which extensions are new to the material: all their numbers are said then, as what they say by default is not what their absence says. */
struct extensions {
    uint32_t count;
    struct {
        char name[64];
        bool there, differs;
    } rows[32];
};

static void find_extensions(const struct writing *w, struct extensions *out) {
    const struct scene_property *property;
    uint32_t width;
    bool more = true;
    for (uint32_t row = 0; more; row++) {
        const char *path = row_path(row, &width, &property, &more);
        char name[64];
        if (!path) continue;
        extension_of(path, name);
        uint32_t i = 0;
        while (i < out->count && strcmp(out->rows[i].name, name) != 0) i++;
        if (i == COUNT_OF(out->rows)) continue;
        if (i == out->count) {
            out->count++;
            strcpy(out->rows[i].name, name);
            out->rows[i].there = !*name || json_object_get(json_object_get(w->object, "extensions"), name);
            out->rows[i].differs = false;
        }
        out->rows[i].differs = out->rows[i].differs || row_differs(w, path, width, property);
    }
}

static void write_texture(const struct writing *w, const char *path, enum scene_texture_slot slot) {
    char place[160], leaf[64];
    snprintf(place, sizeof place, "%.*s", (int)(strstr(path, "/extensions/KHR_texture_transform") - path), path);
    const struct scene_texture *texture = &w->now->textures[slot];
    const uint32_t index = texture->image == SCENE_NONE ? SCENE_NONE : texture_of(w->g, texture->image, texture->sampler);
    json_t *above = reach(w->g, w->object, place, index != SCENE_NONE, leaf);
    if (index == SCENE_NONE) {
        json_object_del(above, leaf);
        return;
    }
    json_t *info = glb_object(w->g, above, leaf);
    glb_set(w->g, info, "index", json_integer((json_int_t)index));
    if (texture->uv_set || json_object_get(info, "texCoord")) glb_set(w->g, info, "texCoord", json_integer((json_int_t)texture->uv_set));
    set_transform(w->g, info, texture, &w->now->parts.turns[slot]);
}

static void write_number(const struct writing *w, const char *path, uint32_t width, const struct scene_property *property) {
    char leaf[64];
    const float *value = value_of(w->now, property);
    const bool of_texture = strstr(path, "Texture/") != NULL; /* which is there already, or the number has no meaning */
    json_t *above = reach(w->g, w->object, path, !of_texture, leaf);
    if (!above) return;
    if (isfinite(*value))
        glb_set(w->g, above, leaf, width == 1 ? glb_float(*value) : glb_floats(value, width));
    else
        json_object_del(above, leaf);
}

static void write_rows(const struct writing *w, const struct extensions *extensions, bool textures) {
    const struct scene_property *property;
    uint32_t width;
    bool more = true;
    for (uint32_t row = 0; more; row++) {
        const char *path = row_path(row, &width, &property, &more);
        char name[64];
        if (!path || (property->effect == SCENE_EFFECT_TURN) != textures || property->effect == SCENE_EFFECT_EMISSIVE) continue;
        extension_of(path, name);
        uint32_t i = 0;
        while (i < extensions->count && strcmp(extensions->rows[i].name, name) != 0) i++;
        const bool differs = row_differs(w, path, width, property), introduced = i < extensions->count && !extensions->rows[i].there && extensions->rows[i].differs;
        if (textures && differs) write_texture(w, path, property->slot);
        if (!textures && (differs || introduced || (w->whole && strstr(path, "Texture/")))) write_number(w, path, width, property);
    }
}

/* A factor ends at 1, so what shines more has a strength: a power of two, by which division is exact. */
static void write_emission(const struct writing *w) {
    const vec3 now = w->now->emissive;
    const float most = fmaxf(now.x, fmaxf(now.y, now.z));
    if (memcmp(&now, &w->base->emissive, sizeof now) == 0 ||
        glb_animates(w->g, SCENE_PROPERTY_MATERIAL, w->index, offsetof(struct scene_material, parts.emissive)) ||
        glb_animates(w->g, SCENE_PROPERTY_MATERIAL, w->index, offsetof(struct scene_material, parts.emissive_strength)))
        return;
    int exponent = 0;
    if (most > 1) frexpf(most, &exponent);
    const float factor[3] = {ldexpf(now.x, -exponent), ldexpf(now.y, -exponent), ldexpf(now.z, -exponent)};
    glb_set(w->g, w->object, "emissiveFactor", glb_floats(factor, 3));
    glb_remove_extension(w->object, "KHR_materials_emissive_strength");
    if (exponent) glb_set(w->g, glb_extension(w->g, w->object, "KHR_materials_emissive_strength"), "emissiveStrength", glb_float(ldexpf(1, exponent)));
}

static void write_material(const struct writing *w) {
    static const char *const modes[] = {[FNL_ALPHA_OPAQUE] = "OPAQUE", [FNL_ALPHA_MASK] = "MASK", [FNL_ALPHA_BLEND] = "BLEND"};
    struct extensions extensions = {0};
    find_extensions(w, &extensions);
    write_rows(w, &extensions, true);
    bool any = w->whole;
    for (uint32_t i = 0; i < extensions.count; i++) any = any || extensions.rows[i].differs;
    if (any) write_rows(w, &extensions, false);
    write_emission(w);
    if (w->now->alpha_mode != w->base->alpha_mode) glb_set(w->g, w->object, "alphaMode", json_string(modes[w->now->alpha_mode]));
    if (w->now->alpha_mode != FNL_ALPHA_MASK && json_is_real(json_object_get(w->object, "alphaCutoff")) && w->whole) json_object_del(w->object, "alphaCutoff");
    if (w->now->double_sided != w->base->double_sided) glb_set(w->g, w->object, "doubleSided", json_boolean(w->now->double_sided));
    if (w->now->casts_shadows != w->base->casts_shadows)
        glb_set_extra(w->g, w->object, "FNL_material_shadows", w->now->casts_shadows ? json_object() : json_pack("{s:b}", "castsShadows", 0));
    if (w->now->unlit && !w->base->unlit) glb_extension(w->g, w->object, "KHR_materials_unlit");
    if (!w->now->unlit && w->base->unlit) glb_remove_extension(w->object, "KHR_materials_unlit");
}

uint32_t glb_material(struct glb *g, uint32_t material) {
    if (material == SCENE_NONE || g->materials[material] != SCENE_NONE) return material == SCENE_NONE ? SCENE_NONE : g->materials[material];
    const struct scene_material base = scene_material_default(), *now = &g->scene->materials.data[material];
    const struct writing w = {g, json_object(), now, &base, SCENE_NONE, true};
    glb_set_name(g, w.object, now->name, now->extras);
    write_material(&w);
    return g->materials[material] = glb_add(g, "materials", w.object);
}

void glb_save_materials(struct glb *g) {
    json_t *array = json_object_get(g->root, "materials");
    for (uint32_t i = 0; i < g->material_count && g->result == FNL_OK; i++) {
        const struct writing w = {g, json_array_get(array, i), &g->scene->materials.data[i], &g->file->materials.data[i], i, false};
        if (json_is_object(w.object)) write_material(&w);
    }
    const uint32_t first = g->file ? g->file->materials.count : 0; /* what the loader adds itself it will add again */
    for (uint32_t i = first; i < g->scene->materials.count && g->scene->painted.count == 0 && g->result == FNL_OK; i++)
        if (!g->scene->materials.data[i].removed && i != g->scene->stage.material) glb_material(g, i);
}
