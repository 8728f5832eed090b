/* SPDX-License-Identifier: MIT */
/* Graffiti, cracks, footprints and stains: their pictures, and scattering them over the surfaces of a scene. */
#include "scene/builtin_texel.h"
#include "scene/scene.h"

enum { SIDE = 256 };

/* One point of a picture; u to the right, v downwards, 0..1. */
struct dab {
    vec3 color; /* linear */
    float alpha, height, roughness;
};
typedef struct dab dab_function(float u, float v, uint32_t seed);

static float segment_distance(vec2 p, vec2 a, vec2 b) {
    float dx = b.x - a.x, dy = b.y - a.y, px = p.x - a.x, py = p.y - a.y;
    float t = CLAMP((px * dx + py * dy) / fmaxf(dx * dx + dy * dy, 1e-12f), 0.0f, 1.0f);
    return hypotf(px - t * dx, py - t * dy);
}

static vec3 hue(float h) {
    float c[3];
    for (int i = 0; i < 3; i++)
        c[i] = 0.06f + 0.84f * smooth_step(0.15f, 0.75f, 0.5f + 0.5f * cosf(2 * PI * (h - (float)i / 3)));
    return vec3_make(c[0], c[1], c[2]);
}

/* Distance to a scrawl of loops that look like letters. */
static float scrawl(float u, float v, uint32_t seed) {
    vec2 p = {u, v}, last = {0, 0};
    float nearest = 1;
    for (int letter = 0; letter < 4; letter++)
        for (int i = 0; i < 6; i++) {
            float x = 0.2f + 0.2f * (float)letter + 0.13f * (noise_hash(letter * 8 + i, 1, seed) - 0.5f);
            float y = 0.3f + 0.4f * (i & 1 ? 0.75f + 0.25f * noise_hash(letter * 8 + i, 2, seed)
                                           : 0.3f * noise_hash(letter * 8 + i, 2, seed));
            vec2 at = {x, y};
            if (i > 0) nearest = fminf(nearest, segment_distance(p, last, at));
            last = at;
        }
    return nearest;
}

static struct dab dab_graffiti(float u, float v, uint32_t seed) {
    float wobble = 0.008f * (noise_fractal(u, v, 9, 9, 3, seed) - 0.5f), d = scrawl(u, v, seed) + wobble;
    float shade = scrawl(u - 0.022f, v - 0.022f, seed) + wobble, mist = noise_fractal(u, v, 24, 24, 3, seed + 1);
    float fill = smooth_step(0.040f, 0.034f, d), line = smooth_step(0.054f, 0.049f, d),
          drop = smooth_step(0.054f, 0.049f, shade);
    float tint = (float)(seed % 7) / 7;
    vec3 top = hue(tint), low = hue(tint + 0.3f);
    vec3 color = vec3_lerp(top, low, smooth_step(0.3f, 0.7f, v + 0.1f * mist));
    color = vec3_lerp(color, vec3_make(0.95f, 0.95f, 0.95f),
                      0.8f * smooth_step(0.012f, 0.006f, fabsf(d - 0.018f)) * smooth_step(0.5f, 0.3f, v));
    color = vec3_lerp(vec3_make(0.01f, 0.01f, 0.012f), color, fill);
    float alpha = fmaxf(line, 0.75f * drop);
    if (line < 0.5f) color = vec3_make(0.02f, 0.02f, 0.03f);
    float spray = 0.5f * smooth_step(0.13f, 0.05f, d) * smooth_step(0.45f, 0.7f, mist);
    if (alpha < spray) {
        color = top;
        alpha = spray;
    }
    return (struct dab){color, 0.96f * alpha * smooth_step(0.95f, 0.7f, 0.8f * mist), 0, 0.35f};
}

static struct dab dab_crack(float u, float v, uint32_t seed) {
    float bent_u = u + 0.08f * (noise_fractal(u, v, 6, 6, 4, seed) - 0.5f),
          bent_v = v + 0.08f * (noise_fractal(u, v, 6, 6, 4, seed + 1) - 0.5f);
    struct noise_cell coarse = noise_cells(bent_u, bent_v, 3, 3, seed), fine = noise_cells(bent_u, bent_v, 8, 8, seed + 2);
    float radius = hypotf(u - 0.5f, v - 0.5f),
          here = smooth_step(0.48f, 0.18f, radius + 0.12f * noise_value(u, v, 5, 5, seed));
    float wide = smooth_step(0.055f * here, 0.0f, coarse.second - coarse.first);
    float thin = smooth_step(0.06f * here, 0.0f, fine.second - fine.first) * smooth_step(0.3f, 0.05f, radius);
    float depth = fmaxf(wide, 0.7f * thin) * smooth_step(0, 0.2f, here);
    return (struct dab){vec3_make(0.22f, 0.2f, 0.18f), depth, -0.012f * depth, 0.95f};
}

/* A shoe seen from above, toes up; `seed` odd: the left one. */
static struct dab dab_footprint(float u, float v, uint32_t seed) {
    float x = (seed & 1 ? 1 - u : u) - 0.5f, y = v - 0.5f;
    float sole = hypotf((x - 0.02f - 0.06f * y) / 0.17f, (y + 0.14f) / 0.28f),
          heel = hypotf((x + 0.02f) / 0.125f, (y - 0.31f) / 0.14f);
    float inside = fmaxf(smooth_step(1.0f, 0.93f, sole), smooth_step(1.0f, 0.9f, heel));
    float tread = 0.5f + 0.5f * cosf(2 * PI * (y * 17 + 4 * x * x * 3));
    float worn = noise_fractal(u, v, 12, 12, 3, seed);
    float press = inside * smooth_step(0.25f, 0.6f, tread) * smooth_step(0.2f, 0.45f, worn + 0.2f);
    return (struct dab){vec3_make(0.16f, 0.12f, 0.09f), 0.85f * press, -0.006f * press, 0.25f};
}

static struct dab dab_stain(float u, float v, uint32_t seed) {
    float angle = atan2f(v - 0.5f, u - 0.5f) / (2 * PI) + 0.5f, radius = hypotf(u - 0.5f, v - 0.5f);
    float edge = 0.22f + 0.14f * noise_fractal(angle, 0.5f, 9, 1, 4, seed), drops = noise_cells(u, v, 9, 9, seed).first;
    float body = smooth_step(edge, edge - 0.05f, radius),
          drop = smooth_step(0.16f, 0.12f, drops) * smooth_step(0.46f, 0.4f, radius);
    float ring = smooth_step(0.03f, 0.0f, fabsf(radius - edge + 0.03f));
    return (struct dab){vec3_lerp(vec3_make(0.35f, 0.28f, 0.2f), vec3_make(0.12f, 0.08f, 0.05f), ring),
                        fmaxf(0.8f * body, 0.7f * drop), 0, 0.12f};
}

static uint8_t byte_of(float x) { return (uint8_t)(CLAMP(x, 0.0f, 1.0f) * 255 + 0.5f); }
static uint8_t byte_srgb(float x) {
    x = CLAMP(x, 0.0f, 1.0f);
    return byte_of(x <= 0.0031308f ? 12.92f * x : 1.055f * powf(x, 1 / 2.4f) - 0.055f);
}

static fnl_result add_picture(fnl_scene *scene, const char *name, uint8_t *pixels, bool color, fnl_image_id *out) {
    struct scene_image image = {.name = arena_format(&scene->arena, "%s: %s", scene->source, name),
                                .file_kind = "generated",
                                .width = SIDE,
                                .height = SIDE,
                                .pixels = pixels,
                                .color = color};
    uint32_t index = image.name && pixels ? scene_add_image(scene, &image) : SCENE_NONE;
    *out = (fnl_image_id){index, 1};
    return index == SCENE_NONE ? FNL_ERROR_MEMORY : FNL_OK;
}

/* Colour and alpha; the normals of its heights where it has any; roughness. `metres`: what a side measures. */
static fnl_result make_pictures(fnl_scene *scene, const char *name, dab_function *function, uint32_t seed, float metres,
                                bool has_normals, fnl_decal_params *out) {
    size_t dabs_size = sizeof(struct dab) * SIDE * SIDE;
    struct dab *dabs = host_allocate(&scene->host, dabs_size);
    if (!dabs) return FNL_ERROR_MEMORY;
    uint8_t *color = arena_allocate(&scene->arena, SIDE * SIDE * 4),
            *normal = has_normals ? arena_allocate(&scene->arena, SIDE * SIDE * 4) : NULL;
    for (int i = 0; i < SIDE * SIDE; i++) {
        float u = ((float)(i % SIDE) + 0.5f) / SIDE, v = ((float)(i / SIDE) + 0.5f) / SIDE;
        float rim = smooth_step(0.0f, 0.03f, fminf(fminf(u, 1 - u), fminf(v, 1 - v)));
        dabs[i] = function(u, v, seed);
        dabs[i].alpha *= rim; /* nothing is cut off by the box */
        dabs[i].height *= rim;
        if (!color) continue;
        color[i * 4] = byte_srgb(dabs[i].color.x);
        color[i * 4 + 1] = byte_srgb(dabs[i].color.y);
        color[i * 4 + 2] = byte_srgb(dabs[i].color.z);
        color[i * 4 + 3] = byte_of(dabs[i].alpha);
    }
    for (int i = 0; normal && i < SIDE * SIDE; i++) {
        int x = i % SIDE, y = i / SIDE;
        const struct dab *row = dabs + (size_t)y * SIDE;
        float dx = row[MIN(x + 1, SIDE - 1)].height - row[MAX(x - 1, 0)].height;
        float dy = dabs[MIN(y + 1, SIDE - 1) * SIDE + x].height - dabs[MAX(y - 1, 0) * SIDE + x].height;
        float step = 2 * metres / SIDE;
        vec3 n = vec3_normalize(vec3_make(-dx / step, dy / step, 1));
        normal[i * 4] = byte_of(n.x * 0.5f + 0.5f);
        normal[i * 4 + 1] = byte_of(n.y * 0.5f + 0.5f);
        normal[i * 4 + 2] = byte_of(n.z * 0.5f + 0.5f);
        normal[i * 4 + 3] = 255;
    }
    *out = fnl_decal_params_default();
    out->roughness = dabs[SIDE / 2 * SIDE + SIDE / 2].roughness;
    host_free(&scene->host, dabs, dabs_size);
    TRY(add_picture(scene, name, color, true, &out->color_image));
    if (has_normals) TRY(add_picture(scene, name, normal, false, &out->normal_image));
    return FNL_OK;
}

fnl_result decal_prototypes(fnl_scene *scene, uint64_t seed, fnl_decal_params out[SCATTER_DECAL_KINDS]) {
    uint32_t s = (uint32_t)(seed * 977 + 11);
    for (uint32_t i = 0; i < 3; i++) TRY(make_pictures(scene, "graffiti", dab_graffiti, s + i * 17, 2, false, &out[i]));
    for (uint32_t i = 3; i < 5; i++) {
        TRY(make_pictures(scene, "crack", dab_crack, s + i, 1, true, &out[i]));
        out[i].channels = FNL_DECAL_COLOR | FNL_DECAL_NORMAL | FNL_DECAL_ROUGHNESS;
        out[i].blend = FNL_DECAL_BLEND_MULTIPLY;
    }
    for (uint32_t i = 5; i < 7; i++) {
        TRY(make_pictures(scene, "footprint", dab_footprint, i, 0.34f, true, &out[i]));
        out[i].channels = FNL_DECAL_COLOR | FNL_DECAL_NORMAL | FNL_DECAL_ROUGHNESS;
        out[i].blend = FNL_DECAL_BLEND_MULTIPLY;
    }
    TRY(make_pictures(scene, "stain", dab_stain, s + 7, 1, false, &out[7]));
    out[7].blend = FNL_DECAL_BLEND_MULTIPLY;
    out[7].channels = FNL_DECAL_COLOR | FNL_DECAL_ROUGHNESS;
    return FNL_OK;
}

/* ---- scattering ---- */

/* A primitive at one place, with the area of all before it and itself. */
struct patch {
    uint32_t node, instance, primitive;
    double area_end;
};

struct surfaces {
    ARRAY(struct patch) patches;
    double area;
};

static mat4 patch_matrix(const fnl_scene *scene, const struct patch *patch) {
    return scene_instance_world(scene, &scene->nodes.data[patch->node], patch->instance);
}

static double triangle_area(const mat4 *m, const struct scene_primitive *p, uint32_t i, vec3 corners[3]) {
    for (uint32_t k = 0; k < 3; k++) corners[k] = mat4_point(m, p->positions[p->indices[i + k]]);
    vec3 cross = vec3_cross(vec3_sub(corners[1], corners[0]), vec3_sub(corners[2], corners[0]));
    double area = 0.5 * (double)vec3_length(cross);
    return isfinite(area) ? area : 0;
}

static fnl_result find_surfaces(fnl_scene *scene, struct surfaces *out) {
    vec3 corners[3];
    mat4 identity = mat4_identity();
    for (uint32_t n = 0; n < scene->nodes.count; n++) {
        const struct scene_node *node = &scene->nodes.data[n];
        if (!node->active || node->removed || node->mesh == SCENE_NONE || node->skin != SCENE_NONE) continue;
        const struct scene_mesh *mesh = &scene->meshes.data[node->mesh];
        for (uint32_t i = 0; i < mesh->primitive_count; i++) {
            const struct scene_primitive *p = &scene->primitives.data[mesh->first_primitive + i];
            if (p->topology != SCENE_TOPOLOGY_TRIANGLES) continue;
            double area = 0;
            for (uint32_t t = 0; t + 2 < p->index_count; t += 3) area += triangle_area(&identity, p, t, corners);
            for (uint32_t k = 0; k < node->instance_count; k++) {
                struct patch patch = {n, k, mesh->first_primitive + i, 0};
                mat4 m = patch_matrix(scene, &patch);
                out->area += area * pow(fabs((double)mat4_determinant3(&m)), 2.0 / 3);
                patch.area_end = out->area;
                if (!array_push(&scene->host, &out->patches, patch)) return FNL_ERROR_MEMORY;
            }
        }
    }
    return FNL_OK;
}

/* A random point on the surfaces and its unit normal. */
static bool random_point(fnl_scene *scene, const struct surfaces *s, struct random_state *random, vec3 *point,
                         vec3 *normal) {
    double wanted = (double)random_float(random) * s->area;
    uint32_t low = 0, high = s->patches.count - 1;
    while (low < high) {
        uint32_t middle = (low + high) / 2;
        if (s->patches.data[middle].area_end > wanted)
            high = middle;
        else
            low = middle + 1;
    }
    const struct patch *patch = &s->patches.data[low];
    const struct scene_primitive *p = &scene->primitives.data[patch->primitive];
    if (p->index_count < 3) return false;
    mat4 m = patch_matrix(scene, patch);
    /* By size: of a handful of random triangles, the one that a lot of their areas draws. */
    vec3 corners[3], chosen[3] = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
    double sum = 0;
    for (int i = 0; i < 24; i++) {
        double area = triangle_area(&m, p, (uint32_t)(random_bits(random) % (p->index_count / 3)) * 3, corners);
        sum += area;
        if (sum > 0 && (double)random_float(random) * sum <= area) memcpy(chosen, corners, sizeof chosen);
    }
    if (!(sum > 0)) return false;
    float a = random_float(random), b = random_float(random);
    if (a + b > 1) {
        a = 1 - a;
        b = 1 - b;
    }
    vec3 u = vec3_sub(chosen[1], chosen[0]), v = vec3_sub(chosen[2], chosen[0]);
    *point = vec3_add_scaled(vec3_add_scaled(chosen[0], u, a), v, b);
    *normal = vec3_normalize(vec3_cross(u, v));
    if (mat4_determinant3(&m) < 0) *normal = vec3_scale(*normal, -1);
    return vec3_dot(*normal, *normal) > 0.5f && vec3_finite(*point);
}

static mat4 decal_at(vec3 point, vec3 normal, float turn, vec3 size) {
    vec3 up =
        fabsf(normal.y) > 0.7f ? vec3_make(cosf(turn), 0, sinf(turn)) : vec3_make(0.15f * sinf(turn), 1, 0.15f * cosf(turn));
    vec3 x = vec3_normalize(vec3_cross(up, normal)), y = vec3_cross(normal, x);
    return (mat4){{x.x * size.x, x.y * size.x, x.z * size.x, 0, y.x * size.y, y.y * size.y, y.z * size.y, 0,
                   normal.x * size.z, normal.y * size.z, normal.z * size.z, 0, point.x, point.y, point.z, 1}};
}

static fnl_result scatter(fnl_scene *scene, uint32_t count, uint64_t seed, const struct surfaces *s) {
    fnl_decal_params prototypes[SCATTER_DECAL_KINDS];
    const uint64_t most = (uint64_t)scene->decals.count + count;
    if (most >= SCENE_NONE || !array_reserve(&scene->host, &scene->decals, most)) return FNL_ERROR_MEMORY;
    TRY(decal_prototypes(scene, seed, prototypes));
    struct random_state random = {seed * 2 + 1};
    struct box bounds = scene_bounds(scene);
    float scale = fminf(1, vec3_distance(bounds.low, bounds.high) / 15); /* a small thing gets small ones */
    for (uint32_t i = 0; i < count; i++) {
        vec3 point = {0, 0, 0}, normal = {0, 0, 0};
        bool found = false;
        for (int t = 0; t < 8 && !found; t++) found = random_point(scene, s, &random, &point, &normal);
        float turn = random_range(&random, 0, 2 * PI), size = random_float(&random), pick = random_float(&random);
        if (!found) continue;
        bool floor = normal.y > 0.7f, wall = fabsf(normal.y) < 0.5f;
        uint32_t kind = floor  ? (pick < 0.55f  ? 5 + (i & 1)
                                  : pick < 0.8f ? 7
                                                : 3 + (i & 1))
                        : wall ? (pick < 0.55f   ? i % 3
                                  : pick < 0.85f ? 3 + (i & 1)
                                                 : 7)
                               : 3 + (i & 1);
        float metres = scale * (kind < 3   ? 1.2f + 1.4f * size
                                : kind < 5 ? 0.7f + 1.3f * size
                                : kind < 7 ? 0.34f
                                           : 0.5f + size);
        fnl_decal_params decal = prototypes[kind];
        decal.transform = decal_at(point, normal, turn, vec3_make(metres, metres, fminf(0.5f * metres, 0.4f * scale)));
        if (decal_check(CALL(&scene->host), &decal) == FNL_OK) scene_add_decal(scene, &decal, SCENE_NONE); /* there is room */
    }
    return FNL_OK;
}

fnl_result fnl_scene_scatter_decals(fnl_scene *scene, uint32_t count, uint64_t seed) {
    TRY(check_handle(__func__, "scene", scene));
    if (count == 0) return FNL_OK;
    struct surfaces surfaces = {.area = 0};
    const uint32_t images = scene->images.count;
    fnl_result result = find_surfaces(scene, &surfaces);
    if (result == FNL_OK && surfaces.patches.count && surfaces.area > 0) result = scatter(scene, count, seed, &surfaces);
    array_free(&scene->host, &surfaces.patches);
    if (result != FNL_OK) scene->images.count = images; /* some of the decals' pictures may be there */
    return result;
}
