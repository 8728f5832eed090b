/* SPDX-License-Identifier: MIT */
/*
 * Baked decals: what is painted goes into copies of the instance's base colour textures, once, on the CPU. Materials, meshes and pictures
 * that others use too are copied first.
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

/* IEC 61966-2-1. */
static float decode_srgb(float x) { return x <= 0.04045f ? x / 12.92f : powf((x + 0.055f) / 1.055f, 2.4f); }
static float encode_srgb(float x) { return x <= 0.0031308f ? 12.92f * x : 1.055f * powf(x, 1 / 2.4f) - 0.055f; }
static uint8_t to_byte(float x) { return (uint8_t)(CLAMP(x, 0.0f, 1.0f) * 255 + 0.5f); }

/* Linear, premultiplied; bilinear, clamped at the edge. */
static vec4 sample(const struct picture *p, float u, float v, bool premultiplies) {
    if (!p->pixels) return (vec4){1, 1, 1, 1};
    float x = u * (float)p->width - 0.5f, y = v * (float)p->height - 0.5f;
    int32_t x0 = (int32_t)floorf(x), y0 = (int32_t)floorf(y);
    float fx = x - (float)x0, fy = y - (float)y0, sum[4] = {0};
    for (int32_t k = 0; k < 4; k++) {
        int32_t tx = CLAMP(x0 + (k & 1), 0, (int32_t)p->width - 1), ty = CLAMP(y0 + (k >> 1), 0, (int32_t)p->height - 1);
        const uint8_t *texel = p->pixels + ((size_t)ty * p->width + (size_t)tx) * 4;
        float weight = (k & 1 ? fx : 1 - fx) * (k >> 1 ? fy : 1 - fy), alpha = (float)texel[3] / 255;
        for (int c = 0; c < 3; c++) sum[c] += weight * decode_srgb((float)texel[c] / 255) * (premultiplies ? alpha : 1);
        sum[3] += weight * alpha;
    }
    return (vec4){sum[0], sum[1], sum[2], sum[3]};
}

/* One decal as seen from the mesh. */
struct brush {
    const fnl_decal_params *params;
    struct picture picture;
    mat4 inverse;
    vec3 facing; /* unit: the box's +Z */
};

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

/* Linear base colour under a brush. */
static void apply(const struct brush *b, vec3 position, vec3 normal, float color[3]) {
    const fnl_decal_params *p = b->params;
    vec3 q = mat4_point(&b->inverse, position);
    if (!(fabsf(q.x) <= 0.5f && fabsf(q.y) <= 0.5f && fabsf(q.z) <= 0.5f)) return;
    float high = cosf(p->fade_start), low = cosf(p->fade_end);
    float fade = smooth((vec3_dot(normal, b->facing) - low) / fmaxf(high - low, 1e-4f));
    vec4 texel = sample(&b->picture, q.x + 0.5f, 0.5f - q.y, !p->distance_field);
    const float rgb[3] = {texel.x, texel.y, texel.z};
    float cut = !p->distance_field ? 1 : texel.w >= p->cut ? 1 : 0;
    float alpha = (p->distance_field ? cut : texel.w) * p->color[3] * fade;
    for (int c = 0; c < 3; c++)
        color[c] = blend_channel(p->blend, color[c], rgb[c] * cut * p->color[c] * p->color[3] * fade, alpha);
}

/* ---- one primitive ---- */

struct paint {
    fnl_scene *scene;
    const struct brush *brushes;
    uint32_t brush_count;
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

static void paint_texel(struct paint *w, int64_t x, int64_t y, vec3 position, vec3 normal, bool inside) {
    size_t at = (size_t)wrap(y, w->height) * w->width + wrap(x, w->width);
    uint8_t bit = (uint8_t)(1u << (at & 7));
    if (w->covered[at >> 3] & bit) {
        w->shared += inside;
        return;
    }
    uint8_t *texel = w->pixels + at * 4;
    float color[3], before[3];
    for (int c = 0; c < 3; c++) before[c] = color[c] = decode_srgb((float)texel[c] / 255);
    for (uint32_t i = 0; i < w->brush_count; i++) apply(&w->brushes[i], position, normal, color);
    if (memcmp(color, before, sizeof color) != 0)
        for (int c = 0; c < 3; c++) texel[c] = to_byte(encode_srgb(CLAMP(color[c], 0.0f, 1.0f)));
    w->painted += inside;
    w->covered[at >> 3] |= bit;
}

static bool brushes_touch(const struct paint *w, const vec3 p[3]) {
    for (uint32_t i = 0; i < w->brush_count; i++) {
        vec3 corners[3];
        for (int k = 0; k < 3; k++) corners[k] = mat4_point(&w->brushes[i].inverse, p[k]);
        if (decal_touches(corners)) return true;
    }
    return false;
}

/* Texels whose middle is in the triangle; with `rim` those beside it too, which filtering reads at its edge. */
static void paint_triangle(struct paint *w, const vec3 p[3], const vec3 n[3], const vec2 t[3], bool rim) {
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
            vec3 position = {0, 0, 0}, normal = {0, 0, 0};
            for (int k = 0; k < 3; k++) {
                position = vec3_add_scaled(position, p[k], b[k]);
                normal = vec3_add_scaled(normal, n[k], b[k]);
            }
            paint_texel(w, x, y, position, vec3_normalize(normal), inside);
        }
}

/* Whether anything was touched. */
static bool paint_primitive(struct paint *w, const struct scene_primitive *primitive, const struct scene_texture *texture) {
    const vec2 *uv = primitive->uv[MIN(texture->uv_set, 1u)];
    bool any = false;
    if (!uv || primitive->topology != SCENE_TOPOLOGY_TRIANGLES || !primitive->normals) return false;
    for (int rim = 0; rim < 2; rim++)
        for (uint32_t i = 0; i + 2 < primitive->index_count; i += 3) {
            vec3 p[3], n[3];
            vec2 t[3];
            for (int k = 0; k < 3; k++) {
                uint32_t v = primitive->indices[i + (uint32_t)k];
                p[k] = primitive->positions[v];
                n[k] = primitive->normals[v];
                const float *m = texture->transform;
                t[k] = (vec2){(m[0] * uv[v].x + m[1] * uv[v].y + m[2]) * (float)w->width,
                              (m[3] * uv[v].x + m[4] * uv[v].y + m[5]) * (float)w->height};
            }
            if (!brushes_touch(w, p)) continue;
            any = true;
            paint_triangle(w, p, n, t, rim != 0);
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
    struct scene_primitive *copies = ARENA_ARRAY(&scene->arena, struct scene_primitive, mesh.primitive_count);
    if (!copies) return SCENE_NONE;
    for (uint32_t i = 0; i < mesh.primitive_count; i++) {
        copies[i] = scene->primitives.data[mesh.first_primitive + i];
        struct scene_material material =
            copies[i].material == SCENE_NONE ? scene_material_default() : scene->materials.data[copies[i].material];
        if (copies[i].material == SCENE_NONE) material.name = "";
        copies[i].material = scene_add_material(scene, &material);
        if (copies[i].material == SCENE_NONE) return SCENE_NONE;
    }
    uint32_t index = scene_add_mesh(scene, mesh.name, copies, mesh.primitive_count);
    if (index != SCENE_NONE) scene->meshes.data[index].morph_weights = mesh.morph_weights;
    return index;
}

/* The picture that is painted on: that of the copied material, which is made when there is none yet. `original`: what it begins as. */
static uint32_t own_image(fnl_scene *scene, const struct scene_texture *original, uint32_t material,
                          const struct picture *source) {
    struct scene_texture *texture = &scene->materials.data[material].textures[SCENE_TEXTURE_BASE_COLOR];
    uint32_t width = source->pixels ? source->width : PLAIN_SIDE, height = source->pixels ? source->height : PLAIN_SIDE;
    size_t bytes = (size_t)width * height * 4;
    if (texture->image == original->image) {
        struct scene_image image = {
            .name = arena_format(&scene->arena, "%s: painted picture %u", scene->source, scene->images.count),
            .file_kind = "generated",
            .width = width,
            .height = height,
            .pixels = arena_allocate(&scene->arena, bytes),
            .color = true};
        uint32_t index = image.name && image.pixels ? scene_add_image(scene, &image) : SCENE_NONE;
        if (index == SCENE_NONE) return SCENE_NONE;
        texture = &scene->materials.data[material].textures[SCENE_TEXTURE_BASE_COLOR];
        *texture = *original;
        texture->image = index;
    }
    uint8_t *pixels = scene->images.data[texture->image].pixels;
    if (source->pixels)
        memcpy(pixels, source->pixels, bytes);
    else
        memset(pixels, 255, bytes);
    return texture->image;
}

static fnl_result paint_one(fnl_scene *scene, const struct brush *brushes, uint32_t brush_count, uint32_t source,
                            uint32_t own) {
    const struct scene_primitive primitive = scene->primitives.data[source];
    uint32_t material = scene->primitives.data[own].material;
    struct scene_texture texture = primitive.material == SCENE_NONE
                                       ? scene_texture_none()
                                       : scene->materials.data[primitive.material].textures[SCENE_TEXTURE_BASE_COLOR];
    struct picture picture;
    TRY(open_picture(scene, texture.image, &picture));
    uint32_t image = own_image(scene, &texture, material, &picture);
    close_picture(scene, &picture);
    if (image == SCENE_NONE) return FNL_ERROR_MEMORY;
    const struct scene_image *target = &scene->images.data[image];
    size_t mask_size = ((size_t)target->width * target->height + 7) / 8;
    struct paint paint = {.scene = scene,
                          .brushes = brushes,
                          .brush_count = brush_count,
                          .pixels = target->pixels,
                          .covered = host_allocate_zero(&scene->host, mask_size),
                          .width = target->width,
                          .height = target->height};
    if (!paint.covered) return FNL_ERROR_MEMORY;
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
        TRY(paint_one(scene, brushes, count, source.first_primitive + i, own.first_primitive + i));
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
        if (decal->params.kind != FNL_DECAL_BAKED || decal->node != node || !decal_shows(scene, decal)) continue;
        if (!(decal->params.channels & FNL_DECAL_COLOR)) continue;
        struct brush *b = &brushes[count++];
        b->params = &decal->params;
        vec3 z = mat4_direction(&decal->params.transform, vec3_make(0, 0, 1));
        b->facing = vec3_normalize(z);
        UNUSED(mat4_inverse(&decal->params.transform, &b->inverse)); /* checked when it was added */
        result = open_picture(scene, decal_image(decal->params.color_image), &b->picture);
    }
    struct scene_painted *painted = find_painted(scene, node);
    if (count) qsort(brushes, count, sizeof *brushes, compare_brushes);
    if (result == FNL_OK && count)
        result = paint_node(scene, node, brushes, count);
    else if (painted)
        scene->nodes.data[node].mesh = painted->mesh;
    scene->structure_version++;
    for (uint32_t i = 0; i < count; i++) close_picture(scene, &brushes[i].picture);
    host_free(&scene->host, brushes, MAX(most, 1u) * sizeof *brushes);
    return result;
}
