/* SPDX-License-Identifier: MIT */
/*
 * Baked decals: what is painted goes into copies of the instance's textures, once, on the CPU: base colour, roughness and metalness,
 * normals, emission. Materials, meshes and pictures that others use too are copied first. Each kind of texture is painted for itself.
 */
#include "image/image.h"
#include "scene/scene.h"

/* A picture being read; pixels NULL: white. */
struct picture {
    fnl_image decoded; /* owned */
    const uint8_t *pixels;
    uint32_t width, height;
};

static fnl_result open_picture(const fnl_scene *scene, uint32_t index, struct picture *out) {
    *out = (struct picture){0};
    if (index == SCENE_NONE) return FNL_OK;
    const struct scene_image *image = &scene->images.data[index];
    out->width = image->width;
    out->height = image->height;
    out->pixels = image->pixels;
    if (out->pixels || !image->encoded || image->width == 0) return FNL_OK;
    fnl_result result = image_decode(&scene->host, image->encoded, image->encoded_size, image->name, true, &out->decoded);
    if (result == FNL_OK) {
        out->pixels = out->decoded.pixels;
        out->width = out->decoded.width;
        out->height = out->decoded.height;
    }
    return result == FNL_ERROR_MEMORY ? result : FNL_OK; /* what is broken was logged and is white */
}

static void close_picture(const fnl_scene *scene, struct picture *picture) {
    if (picture->decoded.pixels) fnl_image_free(&scene->host, &picture->decoded);
}

/* Linear, premultiplied if asked; bilinear, clamped at the edge. `none`: what there is without a picture. */
enum sampling { SAMPLE_COLOR, SAMPLE_PREMULTIPLIED, SAMPLE_RAW };
static vec4 sample(const struct picture *p, float u, float v, enum sampling how, vec4 none) {
    if (!p->pixels) return none;
    float x = u * (float)p->width - 0.5f, y = v * (float)p->height - 0.5f;
    int32_t x0 = (int32_t)floorf(x), y0 = (int32_t)floorf(y);
    float fx = x - (float)x0, fy = y - (float)y0, sum[4] = {0};
    for (int32_t k = 0; k < 4; k++) {
        int32_t tx = CLAMP(x0 + (k & 1), 0, (int32_t)p->width - 1), ty = CLAMP(y0 + (k >> 1), 0, (int32_t)p->height - 1);
        const uint8_t *texel = p->pixels + ((size_t)ty * p->width + (size_t)tx) * 4;
        float weight = (k & 1 ? fx : 1 - fx) * (k >> 1 ? fy : 1 - fy), alpha = (float)texel[3] / 255;
        for (int c = 0; c < 3; c++) {
            float value = (float)texel[c] / 255;
            sum[c] += weight * (how == SAMPLE_RAW ? value : decode_srgb(value)) * (how == SAMPLE_PREMULTIPLIED ? alpha : 1);
        }
        sum[3] += weight * alpha;
    }
    return (vec4){sum[0], sum[1], sum[2], sum[3]};
}

/* One decal as seen from the mesh. */
struct brush {
    const fnl_decal_params *params;
    struct picture color, metallic_roughness, normal, emissive;
    mat4 inverse;
    vec3 side, up, facing; /* unit: the box's +X and +Y, and where it is seen from */
};

/* The kinds of textures that are painted, and what a decal changes in them. */
static const struct {
    enum scene_texture_slot slot;
    uint32_t channels;
} canvases[] = {{SCENE_TEXTURE_BASE_COLOR, FNL_DECAL_COLOR},
                {SCENE_TEXTURE_METALLIC_ROUGHNESS, FNL_DECAL_ROUGHNESS | FNL_DECAL_METALLIC},
                {SCENE_TEXTURE_NORMAL, FNL_DECAL_NORMAL},
                {SCENE_TEXTURE_EMISSIVE, FNL_DECAL_EMISSION}};

static float smooth(float x) {
    x = CLAMP(x, 0.0f, 1.0f);
    return x * x * (3 - 2 * x);
}

static float blend_channel(fnl_decal_blend blend, float base, float premultiplied, float alpha) {
    switch (blend) {
    case FNL_DECAL_BLEND_MULTIPLY:
        return base * (1 - alpha) + base * premultiplied;
    case FNL_DECAL_BLEND_ADD:
        return fminf(base + premultiplied, 1);
    case FNL_DECAL_BLEND_SCREEN:
        return base + premultiplied * (1 - base);
    case FNL_DECAL_BLEND_OVERLAY:
        return base * (1 - alpha) +
               (base < 0.5f ? 2 * base * premultiplied : alpha - 2 * (1 - base) * (alpha - premultiplied));
    default:
        return base * (1 - alpha) + premultiplied;
    }
}

static float mix(float a, float b, float alpha) { return a + (b - a) * alpha; }

/* Where a brush touches a point of the mesh. */
struct touch {
    float u, v, alpha, faded; /* of its pictures; the decal's alpha; what the premultiplied picture is multiplied by */
    float rgb[3];             /* of the picture, linear, premultiplied */
};

static bool touch_at(const struct brush *b, vec3 position, vec3 normal, struct touch *out) {
    const fnl_decal_params *p = b->params;
    vec3 q = mat4_point(&b->inverse, position);
    if (!(fabsf(q.x) <= 0.5f && fabsf(q.y) <= 0.5f && fabsf(q.z) <= 0.5f)) return false;
    float high = cosf(p->fade_start), low = cosf(p->fade_end);
    float fade = smooth((vec3_dot(normal, b->facing) - low) / fmaxf(high - low, 1e-4f));
    out->u = q.x + 0.5f;
    out->v = 0.5f - q.y;
    vec4 texel =
        sample(&b->color, out->u, out->v, p->distance_field ? SAMPLE_COLOR : SAMPLE_PREMULTIPLIED, (vec4){1, 1, 1, 1});
    float cut = !p->distance_field ? 1 : texel.w >= p->cut ? 1 : 0;
    out->faded = cut * p->color[3] * fade;
    out->alpha = (p->distance_field ? cut : texel.w) * p->color[3] * fade;
    memcpy(out->rgb, &texel, sizeof out->rgb);
    return true;
}

/* As decal_bend() of shaders/decals.glsl, which see. */
static vec3 bend(vec3 normal, vec3 mapped, const struct brush *b, vec3 facing) {
    vec3 t = vec3_sub(b->side, vec3_scale(facing, vec3_dot(facing, b->side)));
    float t2 = vec3_dot(t, t);
    if (t2 < 1e-12f) return normal;
    t = vec3_scale(t, 1 / sqrtf(t2));
    t = vec3_sub(t, vec3_scale(vec3_add(normal, facing), vec3_dot(normal, t) / fmaxf(1 + vec3_dot(normal, facing), 1e-3f)));
    vec3 bitangent = vec3_cross(normal, t);
    if (vec3_dot(vec3_cross(facing, b->side), b->up) < 0) bitangent = vec3_scale(bitangent, -1);
    vec3 bent = vec3_add(vec3_add(vec3_scale(t, mapped.x), vec3_scale(bitangent, mapped.y)), vec3_scale(normal, mapped.z));
    return vec3_dot(bent, bent) > 1e-12f ? vec3_normalize(bent) : normal;
}

/* The point of the mesh that a texel shows. */
struct spot {
    vec3 position, normal; /* the latter unit */
    vec3 tangent, bitangent;
};

/* What a texture means at a spot: base colour; roughness and metalness in y and z; a unit normal of the mesh's space; emission. */
static vec3 apply(const struct brush *b, enum scene_texture_slot slot, const struct spot *at, vec3 value) {
    const fnl_decal_params *p = b->params;
    struct touch t;
    if (!touch_at(b, at->position, at->normal, &t)) return value;
    const vec4 white = {1, 1, 1, 1}, flat = {0.5f, 0.5f, 1, 1};
    vec4 texel;
    switch (slot) {
    case SCENE_TEXTURE_METALLIC_ROUGHNESS:
        texel = sample(&b->metallic_roughness, t.u, t.v, SAMPLE_RAW, white);
        if (p->channels & FNL_DECAL_ROUGHNESS) value.y = mix(value.y, p->roughness * texel.y, t.alpha);
        if (p->channels & FNL_DECAL_METALLIC) value.z = mix(value.z, p->metallic * texel.z, t.alpha);
        return value;
    case SCENE_TEXTURE_NORMAL: {
        texel = sample(&b->normal, t.u, t.v, SAMPLE_RAW, flat);
        vec3 mapped = {(texel.x * 2 - 1) * p->normal_scale, (texel.y * 2 - 1) * p->normal_scale, texel.z * 2 - 1};
        vec3 bent = bend(p->flatten ? at->normal : value, mapped, b, at->normal);
        vec3 mixed = vec3_add(vec3_scale(value, 1 - t.alpha), vec3_scale(bent, t.alpha));
        return vec3_dot(mixed, mixed) > 1e-12f ? vec3_normalize(mixed) : value;
    }
    case SCENE_TEXTURE_EMISSIVE:
        texel = sample(&b->emissive, t.u, t.v, SAMPLE_COLOR, white);
        value.x = mix(value.x, p->emissive[0] * texel.x, t.alpha);
        value.y = mix(value.y, p->emissive[1] * texel.y, t.alpha);
        value.z = mix(value.z, p->emissive[2] * texel.z, t.alpha);
        return value;
    default:
        value.x = blend_channel(p->blend, value.x, t.rgb[0] * t.faded * p->color[0], t.alpha);
        value.y = blend_channel(p->blend, value.y, t.rgb[1] * t.faded * p->color[1], t.alpha);
        value.z = blend_channel(p->blend, value.z, t.rgb[2] * t.faded * p->color[2], t.alpha);
        return value;
    }
}

/* ---- one primitive ---- */

struct paint {
    fnl_scene *scene;
    const struct brush *brushes;
    uint32_t brush_count;
    enum scene_texture_slot slot;
    uint32_t channels; /* of decals that change it */
    float factor[3];   /* what the material multiplies texels by; normals: x and y by [0] */
    uint8_t *pixels;
    uint8_t *covered; /* a bit a texel: painted by an earlier triangle */
    uint32_t width, height;
    uint64_t painted, shared; /* texels inside of triangles; those that more than one shows */
};

static uint32_t wrap(int64_t x, uint32_t size) {
    int64_t r = x % (int64_t)size;
    return (uint32_t)(r < 0 ? r + size : r);
}

static float edge(vec2 a, vec2 b, vec2 p) { return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x); }

static bool is_srgb(enum scene_texture_slot slot) {
    return slot == SCENE_TEXTURE_BASE_COLOR || slot == SCENE_TEXTURE_EMISSIVE;
}

static vec3 read_texel(const struct paint *w, const uint8_t *texel, const struct spot *at) {
    float v[3];
    for (int c = 0; c < 3; c++) v[c] = is_srgb(w->slot) ? decode_srgb((float)texel[c] / 255) : (float)texel[c] / 255;
    if (w->slot != SCENE_TEXTURE_NORMAL) return (vec3){v[0] * w->factor[0], v[1] * w->factor[1], v[2] * w->factor[2]};
    vec3 n = vec3_scale(at->tangent, (v[0] * 2 - 1) * w->factor[0]);
    n = vec3_add(vec3_add_scaled(n, at->bitangent, (v[1] * 2 - 1) * w->factor[0]), vec3_scale(at->normal, v[2] * 2 - 1));
    return vec3_dot(n, n) > 1e-12f ? vec3_normalize(n) : at->normal;
}

static void write_texel(const struct paint *w, uint8_t *texel, const struct spot *at, vec3 value) {
    float v[3] = {value.x, value.y, value.z};
    if (w->slot == SCENE_TEXTURE_NORMAL) { /* in the frame of the mesh's tangents, which need not be at right angles */
        vec3 across = vec3_cross(at->bitangent, at->normal);
        float size = vec3_dot(at->tangent, across);
        if (!(fabsf(size) > 1e-6f)) return;
        vec3 n = {vec3_dot(value, across) / (size * w->factor[0]),
                  vec3_dot(value, vec3_cross(at->normal, at->tangent)) / (size * w->factor[0]),
                  vec3_dot(value, vec3_cross(at->tangent, at->bitangent)) / size};
        n = vec3_normalize(n);
        v[0] = n.x * 0.5f + 0.5f;
        v[1] = n.y * 0.5f + 0.5f;
        v[2] = n.z * 0.5f + 0.5f;
    } else {
        for (int c = 0; c < 3; c++) v[c] = w->factor[c] > 0 ? CLAMP(v[c] / w->factor[c], 0.0f, 1.0f) : 0;
    }
    int first = w->slot == SCENE_TEXTURE_METALLIC_ROUGHNESS ? 1 : 0; /* red is another's */
    for (int c = first; c < 3; c++) texel[c] = encode_byte(is_srgb(w->slot) ? encode_srgb(v[c]) : v[c]);
}

static void paint_texel(struct paint *w, int64_t x, int64_t y, const struct spot *spot, bool inside) {
    size_t at = (size_t)wrap(y, w->height) * w->width + wrap(x, w->width);
    uint8_t bit = (uint8_t)(1u << (at & 7));
    if (w->covered[at >> 3] & bit) {
        w->shared += inside;
        return;
    }
    uint8_t *texel = w->pixels + at * 4;
    vec3 before = read_texel(w, texel, spot), value = before;
    for (uint32_t i = 0; i < w->brush_count; i++)
        if (w->brushes[i].params->channels & w->channels) value = apply(&w->brushes[i], w->slot, spot, value);
    if (memcmp(&value, &before, sizeof value) != 0) write_texel(w, texel, spot, value);
    w->painted += inside;
    w->covered[at >> 3] |= bit;
}

static bool brushes_touch(const struct paint *w, const vec3 p[3]) {
    for (uint32_t i = 0; i < w->brush_count; i++) {
        vec3 corners[3];
        for (int k = 0; k < 3; k++) corners[k] = mat4_point(&w->brushes[i].inverse, p[k]);
        if (w->brushes[i].params->channels & w->channels && decal_touches(corners)) return true;
    }
    return false;
}

/* Texels whose middle is in the triangle; with `rim` those beside it too, which filtering reads at its edge. */
static void paint_triangle(struct paint *w, const vec3 p[3], const vec3 n[3], const vec4 tangents[3], const vec2 t[3],
                           bool rim) {
    float area = edge(t[0], t[1], t[2]);
    if (!(fabsf(area) > 1e-9f)) return;
    float low_x = fminf(t[0].x, fminf(t[1].x, t[2].x)), high_x = fmaxf(t[0].x, fmaxf(t[1].x, t[2].x));
    float low_y = fminf(t[0].y, fminf(t[1].y, t[2].y)), high_y = fmaxf(t[0].y, fmaxf(t[1].y, t[2].y));
    /* A triangle that repeats the texture many times shows all of it. */
    if (!(high_x - low_x <= 16.0f * (float)w->width && high_y - low_y <= 16.0f * (float)w->height)) return;
    for (int64_t y = (int64_t)floorf(low_y) - 1; y <= (int64_t)ceilf(high_y); y++)
        for (int64_t x = (int64_t)floorf(low_x) - 1; x <= (int64_t)ceilf(high_x); x++) {
            vec2 at = {(float)x + 0.5f, (float)y + 0.5f};
            float b[3] = {edge(t[1], t[2], at) / area, edge(t[2], t[0], at) / area, 0};
            b[2] = 1 - b[0] - b[1];
            bool inside = b[0] >= 0 && b[1] >= 0 && b[2] >= 0;
            if (inside == rim) continue;
            if (rim) {
                bool near = true;
                for (int k = 0; k < 3; k++) {
                    vec2 from = t[(k + 1) % 3], to = t[(k + 2) % 3];
                    near = near && b[k] * fabsf(area) >= -1.0f * hypotf(to.x - from.x, to.y - from.y);
                }
                if (!near) continue;
            }
            struct spot spot = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
            for (int k = 0; k < 3; k++) {
                spot.position = vec3_add_scaled(spot.position, p[k], b[k]);
                spot.normal = vec3_add_scaled(spot.normal, n[k], b[k]);
                spot.tangent = vec3_add_scaled(spot.tangent, (vec3){tangents[k].x, tangents[k].y, tangents[k].z}, b[k]);
            }
            spot.normal = vec3_normalize(spot.normal);
            spot.bitangent = vec3_scale(vec3_cross(spot.normal, spot.tangent), tangents[0].w);
            paint_texel(w, x, y, &spot, inside);
        }
}

/* Whether anything was touched. */
static bool paint_primitive(struct paint *w, const struct scene_primitive *primitive, const struct scene_texture *texture) {
    const vec2 *uv = primitive->uv[MIN(texture->uv_set, 1u)];
    bool any = false;
    if (!uv || primitive->topology != SCENE_TOPOLOGY_TRIANGLES || !primitive->normals) return false;
    if (w->slot == SCENE_TEXTURE_NORMAL && !primitive->tangents) return false;
    for (int rim = 0; rim < 2; rim++)
        for (uint32_t i = 0; i + 2 < primitive->index_count; i += 3) {
            vec3 p[3], n[3];
            vec4 tangents[3] = {{0}};
            vec2 t[3];
            for (int k = 0; k < 3; k++) {
                uint32_t v = primitive->indices[i + (uint32_t)k];
                p[k] = primitive->positions[v];
                n[k] = primitive->normals[v];
                if (primitive->tangents) tangents[k] = primitive->tangents[v];
                const float *m = texture->transform;
                t[k] = (vec2){(m[0] * uv[v].x + m[1] * uv[v].y + m[2]) * (float)w->width,
                              (m[3] * uv[v].x + m[4] * uv[v].y + m[5]) * (float)w->height};
            }
            if (!brushes_touch(w, p)) continue;
            any = true;
            paint_triangle(w, p, n, tangents, t, rim != 0);
        }
    return any;
}

/* ---- one node ---- */

enum { PLAIN_SIDE = 512 }; /* of the picture of a material that had none */

static struct scene_painted *find_painted(fnl_scene *scene, uint32_t node) {
    for (uint32_t i = 0; i < scene->painted.count; i++)
        if (scene->painted.data[i].node == node) return &scene->painted.data[i];
    return NULL;
}

/* A copy of the mesh with materials of its own. */
static uint32_t copy_mesh(fnl_scene *scene, uint32_t source) {
    struct scene_mesh mesh = scene->meshes.data[source];
    const size_t size = mesh.primitive_count * sizeof(struct scene_primitive);
    struct scene_primitive *copies = host_allocate(&scene->host, size);
    uint32_t index = SCENE_NONE, made = 0;
    if (!copies) return SCENE_NONE;
    for (; made < mesh.primitive_count; made++) {
        const uint32_t i = made;
        copies[i] = scene->primitives.data[mesh.first_primitive + i];
        copies[i].memory = (struct arena){0}; /* the source's */
        copies[i].mapping_count = 0;          /* they follow it */
        struct scene_material material =
            copies[i].material == SCENE_NONE ? scene_material_default() : scene->materials.data[copies[i].material];
        if (copies[i].material == SCENE_NONE) material.name = "";
        copies[i].material = copies[i].standard_material = scene_add_material(scene, &material);
        if (copies[i].material == SCENE_NONE) break;
    }
    if (made == mesh.primitive_count) index = scene_add_mesh(scene, mesh.name, copies, mesh.primitive_count);
    if (index != SCENE_NONE) scene->meshes.data[index].morph_weights = mesh.morph_weights;
    for (uint32_t i = 0; i < made && index == SCENE_NONE; i++) scene_remove_material(scene, copies[i].material);
    host_free(&scene->host, copies, size);
    return index;
}

/* Removes the painted images: those that differ from the original material's. */
static void remove_pictures(fnl_scene *scene, uint32_t own, uint32_t original) {
    for (int slot = 0; slot < SCENE_TEXTURE_SLOT_COUNT; slot++) {
        const uint32_t image = scene->materials.data[own].textures[slot].image;
        const bool shared = original != SCENE_NONE && scene->materials.data[original].textures[slot].image == image;
        if (image == SCENE_NONE || shared || scene->images.data[image].removed) continue;
        scene_remove_image(scene, image);
    }
}

void decal_forget_removed(fnl_scene *scene) {
    for (uint32_t i = scene->painted.count; i > 0; i--) {
        const struct scene_painted painted = scene->painted.data[i - 1];
        if (!scene->nodes.data[painted.node].removed) continue;
        const struct scene_mesh *source = &scene->meshes.data[painted.mesh], *own = &scene->meshes.data[painted.own_mesh];
        for (uint32_t k = 0; k < own->primitive_count; k++) {
            const uint32_t material = scene->primitives.data[own->first_primitive + k].material;
            remove_pictures(scene, material, scene->primitives.data[source->first_primitive + k].material);
            scene_remove_material(scene, material);
        }
        scene_remove_mesh(scene, painted.own_mesh);
        scene->painted.data[i - 1] = scene->painted.data[--scene->painted.count];
    }
}

/* The picture that is painted on: that of the copied material, which is made when there is none yet. `original`: what it begins as. */
static uint32_t own_image(fnl_scene *scene, const struct scene_texture *original, uint32_t material,
                          enum scene_texture_slot slot, const struct picture *source) {
    struct scene_texture *texture = &scene->materials.data[material].textures[slot];
    uint32_t width = source->pixels ? source->width : PLAIN_SIDE, height = source->pixels ? source->height : PLAIN_SIDE;
    size_t bytes = (size_t)width * height * 4;
    if (texture->image == original->image) {
        struct scene_image image;
        const bool made = scene_image_create(scene, "painted picture", width, height, is_srgb(slot), &image);
        const uint32_t index = made ? scene_add_image(scene, &image) : SCENE_NONE;
        if (index == SCENE_NONE) return SCENE_NONE;
        texture = &scene->materials.data[material].textures[slot];
        *texture = *original;
        texture->image = index;
    }
    uint8_t *pixels = scene->images.data[texture->image].pixels;
    scene->images.data[texture->image].version++;
    if (source->pixels)
        memcpy(pixels, source->pixels, bytes);
    else
        memset(pixels, 255, bytes);
    for (size_t i = 0; slot == SCENE_TEXTURE_NORMAL && !source->pixels && i < bytes; i += 4) pixels[i] = pixels[i + 1] = 128;
    return texture->image;
}

/* The factors of the copied material: no less than the original's nor than what the brushes paint, for texels go up to 1. */
static void choose_factors(const struct paint *w, const struct scene_material *original, struct scene_material *own,
                           float before[3]) {
    const float emissive[3] = {original->emissive.x, original->emissive.y, original->emissive.z};
    for (int c = 0; c < 3; c++) before[c] = 1;
    if (w->slot == SCENE_TEXTURE_METALLIC_ROUGHNESS) {
        before[1] = original->roughness;
        before[2] = original->metallic;
    } else if (w->slot == SCENE_TEXTURE_EMISSIVE) {
        memcpy(before, emissive, sizeof emissive);
    }
    float factor[3];
    memcpy(factor, before, sizeof factor);
    for (uint32_t i = 0; i < w->brush_count; i++) {
        const fnl_decal_params *p = w->brushes[i].params;
        if (w->slot == SCENE_TEXTURE_METALLIC_ROUGHNESS) {
            if (p->channels & FNL_DECAL_ROUGHNESS) factor[1] = fmaxf(factor[1], p->roughness);
            if (p->channels & FNL_DECAL_METALLIC) factor[2] = fmaxf(factor[2], p->metallic);
        } else if (w->slot == SCENE_TEXTURE_EMISSIVE && p->channels & FNL_DECAL_EMISSION) {
            for (int c = 0; c < 3; c++) factor[c] = fmaxf(factor[c], p->emissive[c]);
        }
    }
    if (w->slot == SCENE_TEXTURE_METALLIC_ROUGHNESS) {
        own->roughness = factor[1];
        own->metallic = factor[2];
    } else if (w->slot == SCENE_TEXTURE_EMISSIVE) {
        own->emissive = (vec3){factor[0], factor[1], factor[2]};
    } else if (w->slot == SCENE_TEXTURE_NORMAL) {
        bool had = original->textures[w->slot].image != SCENE_NONE && fabsf(original->normal_scale) > 1e-6f;
        own->normal_scale = had ? original->normal_scale : 1;
    }
}

/* Texels that meant something times `before` mean the same times the new factors. */
static void rescale(const struct paint *w, const float before[3]) {
    if (memcmp(before, w->factor, sizeof w->factor) == 0) return;
    struct paint old = *w;
    memcpy(old.factor, before, sizeof old.factor);
    for (size_t i = 0; i < (size_t)w->width * w->height * 4; i += 4)
        write_texel(w, w->pixels + i, NULL, read_texel(&old, w->pixels + i, NULL));
}

static fnl_result paint_one(fnl_scene *scene, const struct brush *brushes, uint32_t brush_count, uint32_t source,
                            uint32_t own, uint32_t canvas) {
    const struct scene_primitive primitive = scene->primitives.data[source];
    const enum scene_texture_slot slot = canvases[canvas].slot;
    uint32_t material = scene->primitives.data[own].material;
    struct scene_material original =
        primitive.material == SCENE_NONE ? scene_material_default() : scene->materials.data[primitive.material];
    struct scene_texture texture = original.textures[slot];
    struct paint paint = {.scene = scene,
                          .brushes = brushes,
                          .brush_count = brush_count,
                          .slot = slot,
                          .channels = canvases[canvas].channels,
                          .factor = {1, 1, 1}};
    float before[3];
    bool any = false;
    for (uint32_t i = 0; i < brush_count; i++) any = any || brushes[i].params->channels & paint.channels;
    struct scene_material *changed = &scene->materials.data[material];
    if (!any) { /* what an earlier decal left there */
        changed->textures[slot] = texture;
        paint.brush_count = 0;
        choose_factors(&paint, &original, changed, before);
        if (slot == SCENE_TEXTURE_NORMAL) changed->normal_scale = original.normal_scale;
        return FNL_OK;
    }
    choose_factors(&paint, &original, changed, before);
    if (slot == SCENE_TEXTURE_METALLIC_ROUGHNESS) {
        paint.factor[1] = changed->roughness;
        paint.factor[2] = changed->metallic;
    } else if (slot == SCENE_TEXTURE_EMISSIVE) {
        memcpy(paint.factor, &changed->emissive, sizeof paint.factor);
    } else if (slot == SCENE_TEXTURE_NORMAL) {
        paint.factor[0] = changed->normal_scale;
        if (fabsf(original.normal_scale) <= 1e-6f) texture.image = SCENE_NONE; /* it showed nothing */
    }
    struct picture picture;
    TRY(open_picture(scene, texture.image, &picture));
    uint32_t image = own_image(scene, &texture, material, slot, &picture);
    close_picture(scene, &picture);
    if (image == SCENE_NONE) return FNL_ERROR_MEMORY;
    const struct scene_image *target = &scene->images.data[image];
    size_t mask_size = ((size_t)target->width * target->height + 7) / 8;
    paint.pixels = target->pixels;
    paint.width = target->width;
    paint.height = target->height;
    paint.covered = host_allocate_zero(&scene->host, mask_size);
    if (!paint.covered) return FNL_ERROR_MEMORY;
    if (slot != SCENE_TEXTURE_NORMAL) rescale(&paint, before);
    paint_primitive(&paint, &primitive, &texture);
    host_free(&scene->host, paint.covered, mask_size);
    if (paint.shared > paint.painted / 16) /* texels in the middle of an edge belong to both sides */
        log_warning(&scene->host,
                    "%s: a baked decal is on a texture that repeats on its mesh (%llu texels): it shows more than once",
                    scene->source, (unsigned long long)paint.shared);
    return FNL_OK;
}

static int compare_brushes(const void *a, const void *b) {
    const fnl_decal_params *x = ((const struct brush *)a)->params, *y = ((const struct brush *)b)->params;
    if (x->sort_key != y->sort_key) return x->sort_key < y->sort_key ? -1 : 1;
    return x < y ? -1 : 1; /* elements of one array */
}

static fnl_result paint_node(fnl_scene *scene, uint32_t node, struct brush *brushes, uint32_t count) {
    struct scene_painted *painted = find_painted(scene, node);
    if (!painted) {
        struct scene_painted fresh = {.node = node, .mesh = scene->nodes.data[node].mesh};
        fresh.own_mesh = copy_mesh(scene, fresh.mesh);
        if (fresh.own_mesh == SCENE_NONE || !array_push(&scene->host, &scene->painted, fresh)) return FNL_ERROR_MEMORY;
        painted = &scene->painted.data[scene->painted.count - 1];
    }
    const struct scene_mesh source = scene->meshes.data[painted->mesh], own = scene->meshes.data[painted->own_mesh];
    for (uint32_t i = 0; i < source.primitive_count; i++)
        for (uint32_t k = 0; k < COUNT_OF(canvases); k++)
            TRY(paint_one(scene, brushes, count, source.first_primitive + i, own.first_primitive + i, k));
    scene->nodes.data[node].mesh = painted->own_mesh;
    return FNL_OK;
}

fnl_result decal_bake(fnl_scene *scene, uint32_t node) {
    if (scene->nodes.data[node].mesh == SCENE_NONE) return FNL_OK;
    uint32_t count = 0, most = 0;
    for (uint32_t i = 0; i < scene->decals.count; i++)
        most += scene->decals.data[i].params.kind == FNL_DECAL_BAKED && scene->decals.data[i].node == node;
    struct brush *brushes = host_allocate_zero(&scene->host, MAX(most, 1u) * sizeof *brushes);
    if (!brushes) return FNL_ERROR_MEMORY;
    fnl_result result = FNL_OK;
    for (uint32_t i = 0; i < scene->decals.count && result == FNL_OK; i++) {
        const struct scene_decal *decal = &scene->decals.data[i];
        if (decal->params.kind != FNL_DECAL_BAKED || decal->node != node || !decal_exists(scene, decal)) continue;
        if (!(decal->params.channels & FNL_DECAL_ALL)) continue;
        struct brush *b = &brushes[count++];
        b->params = &decal->params;
        b->side = vec3_normalize(mat4_direction(&decal->params.transform, vec3_make(1, 0, 0)));
        b->up = vec3_normalize(mat4_direction(&decal->params.transform, vec3_make(0, 1, 0)));
        b->facing = vec3_normalize(vec3_cross(b->side, b->up)); /* of skewed boxes too */
        if (vec3_dot(b->facing, mat4_direction(&decal->params.transform, vec3_make(0, 0, 1))) < 0)
            b->facing = vec3_scale(b->facing, -1);
        UNUSED(mat4_inverse(&decal->params.transform, &b->inverse)); /* checked when it was added */
        const struct {
            fnl_image_id id;
            struct picture *to;
        } pictures[] = {{decal->params.color_image, &b->color},
                        {decal->params.metallic_roughness_image, &b->metallic_roughness},
                        {decal->params.normal_image, &b->normal},
                        {decal->params.emissive_image, &b->emissive}};
        for (uint32_t k = 0; k < COUNT_OF(pictures) && result == FNL_OK; k++)
            result = open_picture(scene, decal_image(pictures[k].id), pictures[k].to);
    }
    struct scene_painted *painted = find_painted(scene, node);
    if (count) qsort(brushes, count, sizeof *brushes, compare_brushes);
    if (result == FNL_OK && count)
        result = paint_node(scene, node, brushes, count);
    else if (painted)
        scene->nodes.data[node].mesh = painted->mesh;
    scene_materials_changed(scene);
    for (uint32_t i = 0; i < count; i++) {
        close_picture(scene, &brushes[i].color);
        close_picture(scene, &brushes[i].metallic_roughness);
        close_picture(scene, &brushes[i].normal);
        close_picture(scene, &brushes[i].emissive);
    }
    host_free(&scene->host, brushes, MAX(most, 1u) * sizeof *brushes);
    return result;
}
