/* SPDX-License-Identifier: MIT */
/**
 * A two-storey colonnade: a nave under a coffered barrel vault, aisles and galleries under groin vaults behind arches.
 * Along Z, entrance at +Z. Lit by torches, lanterns, chandeliers and candles alone; EV100 4 suits it.
 */
#include "scene/builtin_mesh.h"

enum { BAYS = 8 };

/* Metres. */
#define BAY 4.8f /* distance of columns along the nave */
#define HALF_LENGTH (BAY * BAYS / 2)
#define NAVE 5.0f  /* half width, to the middle of the columns */
#define AISLE 4.8f /* width */
#define OUTER (NAVE + AISLE)
#define ARCH 2.0f        /* inner radius of all arches */
#define LOW_SPRING 3.3f  /* where the lower arches begin, over the floor */
#define GALLERY 6.0f     /* height of the upper floor */
#define HIGH_SPRING 2.5f /* over the upper floor */
#define CORNICE 11.2f
#define THICK 0.8f /* of the arcade walls */

struct hall {
    uint32_t stone, ashlar, marble, plaster, floor, wood, iron, terracotta, leaves, flame, candle;
    uint32_t torch_mesh, lantern_mesh, chandelier_mesh, candle_mesh;
    uint64_t lights_left;
};

/** Takes one of the lights that are still wanted. */
static bool take_light(struct hall *h) {
    if (!h->lights_left) return false;
    h->lights_left--;
    return true;
}

/** Appends an arc to a profile, `steps` + 1 points. */
static void profile_arc(vec2 *profile, uint32_t *count, vec2 centre, float radius, float from, float to, int steps) {
    for (int i = 0; i <= steps; i++) {
        float a = from + (to - from) * (float)i / (float)steps;
        profile[(*count)++] = vec2_make(centre.x + radius * cosf(a), centre.y + radius * sinf(a));
    }
}

static uint32_t make_column(struct builtin *b, const struct hall *h, float radius, float height, uint32_t segments) {
    vec2 p[96];
    uint32_t n = 0;
    float base = 0.16f, neck = height - 0.62f;
    p[n++] = vec2_make(radius * 1.34f, base);
    profile_arc(p, &n, vec2_make(radius * 1.30f, base + 0.07f), 0.07f, -PI / 2, PI / 2, 4);
    profile_arc(p, &n, vec2_make(radius * 1.20f, base + 0.20f), 0.045f, -PI * 0.9f, -PI * 1.5f, 2);
    profile_arc(p, &n, vec2_make(radius * 1.12f, base + 0.27f), 0.04f, -PI / 2, PI / 2, 3);
    p[n++] = vec2_make(radius * 1.04f, base + 0.33f);
    for (int i = 0; i <= 6; i++) { /* the shaft, swelling a little below its middle */
        float t = (float)i / 6;
        p[n++] = vec2_make(radius * (1 - 0.14f * t + 0.05f * sinf(PI * t)), base + 0.36f + (neck - base - 0.36f) * t);
    }
    profile_arc(p, &n, vec2_make(radius * 0.90f, neck + 0.04f), 0.04f, -PI / 2, PI / 2, 3);
    for (int i = 0; i <= 5; i++) { /* the bell of the capital */
        float t = (float)i / 5;
        p[n++] = vec2_make(radius * (0.86f + 0.55f * t * t), neck + 0.10f + 0.34f * t);
    }
    p[n++] = vec2_make(radius * 1.41f, height - 0.14f);
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, h->stone);
    mesh_lathe(&m, vec3_make(0, 0, 0), p, n, segments);
    float plinth = radius * 1.55f;
    mesh_bevel_box(&m, vec3_make(-plinth, 0, -plinth), vec3_make(plinth, base, plinth), 0.02f);
    mesh_bevel_box(&m, vec3_make(-plinth, height - 0.14f, -plinth), vec3_make(plinth, height, plinth), 0.03f);
    for (int i = 0; i < 16; i++) { /* two rows of leaves around the bell */
        float angle = 2 * PI * (float)i / 16, reach = i & 1 ? 1.14f : 1.34f, low = neck + (i & 1 ? 0.08f : 0.18f);
        float c = cosf(angle), s = -sinf(angle);
        const vec2 bend[] = {{0.86f, 0}, {0.94f, 0.10f}, {reach - 0.06f, 0.19f}, {reach, 0.215f}};
        vec3 path[COUNT_OF(bend)];
        for (uint32_t k = 0; k < COUNT_OF(bend); k++)
            path[k] = vec3_make(radius * bend[k].x * c, low + bend[k].y, radius * bend[k].x * s);
        mesh_tube(&m, path, COUNT_OF(path), 0.11f * radius, 4);
    }
    return mesh_end(&m, "column");
}

/** Half an annulus in the XY plane, from z0 to z1, all faces but the springing ones. */
static void add_arch_ring(struct mesh_builder *m, float inner, float outer, float spring, float z0, float z1,
                          uint32_t segments) {
    vec2 in[65], out[65];
    for (uint32_t i = 0; i <= segments; i++) {
        float a = PI * (float)i / (float)segments;
        in[i] = vec2_make(inner * cosf(a), spring + inner * sinf(a));
        out[segments - i] = vec2_make(outer * cosf(a), spring + outer * sinf(a));
    }
    mesh_strip(m, in, segments + 1, z0, z1);
    mesh_strip(m, out, segments + 1, z0, z1);
    for (int side = 0; side < 2; side++)
        for (uint32_t i = 0; i < segments; i++) {
            float z = side ? z1 : z0;
            vec2 corner[4] = {in[i], out[segments - i], out[segments - i - 1], in[i + 1]};
            uint32_t v[4];
            for (int k = 0; k < 4; k++)
                v[k] = mesh_vertex(m, vec3_make(corner[k].x, corner[k].y, z), vec3_make(0, 0, side ? 1.0f : -1.0f),
                                   vec2_make(side ? corner[k].x : -corner[k].x, -corner[k].y));
            mesh_triangle(m, v[0], v[side ? 1 : 2], v[side ? 2 : 1]);
            mesh_triangle(m, v[0], v[side ? 2 : 3], v[side ? 3 : 2]);
        }
}

/** The wall above one arch, as wide as a bay, from the springing up to `top`. */
static void add_spandrel(struct mesh_builder *m, float radius, float spring, float top, float thick) {
    enum { STEPS = 28 };
    float half = BAY / 2;
    for (int side = 0; side < 2; side++) {
        float z = side ? thick / 2 : -thick / 2, sign = side ? 1.0f : -1.0f;
        for (int i = -1; i <= STEPS; i++) { /* -1 and STEPS: the corners beside the springings */
            float a = PI * (float)MAX(i, 0) / STEPS, e = PI * (float)MIN(i + 1, STEPS) / STEPS;
            vec2 p[4] = {{radius * cosf(a), spring + radius * sinf(a)},
                         {half * cosf(a), top},
                         {half * cosf(e), top},
                         {radius * cosf(e), spring + radius * sinf(e)}};
            if (i == -1) p[1] = vec2_make(half, spring), p[2] = vec2_make(half, top), p[3] = vec2_make(radius, spring);
            if (i == STEPS)
                p[1] = vec2_make(-half, top), p[2] = vec2_make(-half, spring), p[0] = p[3] = vec2_make(-radius, spring);
            uint32_t v[4];
            for (int k = 0; k < 4; k++)
                v[k] =
                    mesh_vertex(m, vec3_make(p[k].x, p[k].y, z), vec3_make(0, 0, sign), vec2_make(sign * p[k].x, -p[k].y));
            if (i != STEPS) mesh_triangle(m, v[0], v[side ? 1 : 2], v[side ? 2 : 1]);
            if (i != -1) mesh_triangle(m, v[0], v[side ? 2 : 3], v[side ? 3 : 2]);
            if (i == STEPS) mesh_triangle(m, v[0], v[side ? 1 : 2], v[side ? 2 : 1]);
        }
    }
}

/** One bay of an arcade wall in the XY plane: spandrel, arch stones, keystone, cornice. */
static uint32_t make_arcade(struct builtin *b, const struct hall *h, float spring, float top) {
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, h->ashlar);
    add_spandrel(&m, ARCH + 0.02f, spring, top, THICK);
    mesh_material(&m, h->stone);
    add_arch_ring(&m, ARCH, ARCH + 0.28f, spring, -THICK / 2 - 0.06f, THICK / 2 + 0.06f, 36);
    add_arch_ring(&m, ARCH + 0.28f, ARCH + 0.36f, spring, -THICK / 2 - 0.11f, THICK / 2 + 0.11f, 36);
    mesh_bevel_box(&m, vec3_make(-0.16f, spring + ARCH - 0.06f, -THICK / 2 - 0.16f),
                   vec3_make(0.16f, spring + ARCH + 0.46f, THICK / 2 + 0.16f), 0.03f);
    for (int side = -1; side <= 1; side += 2) { /* a moulding along the top, on both faces */
        vec2 p[24];
        uint32_t n = 0;
        float z = THICK / 2;
        p[n++] = vec2_make(z, top - 0.5f);
        profile_arc(p, &n, vec2_make(z + 0.02f, top - 0.42f), 0.05f, -PI / 2, PI / 4, 5);
        profile_arc(p, &n, vec2_make(z + 0.24f, top - 0.30f), 0.16f, PI, PI / 2, 6);
        p[n++] = vec2_make(z + 0.30f, top - 0.14f);
        p[n++] = vec2_make(z + 0.30f, top - 0.015f);
        p[n++] = vec2_make(z - 0.1f, top - 0.015f); /* just under the floor */
        /* The profile's plane is XY with x outwards; turned so that it runs along the wall. */
        for (uint32_t i = 0; i < n / 2; i++) {
            vec2 swap = p[i];
            p[i] = p[n - 1 - i];
            p[n - 1 - i] = swap;
        }
        m.transform = builtin_at(0, 0, 0, side > 0 ? -PI / 2 : PI / 2, 1);
        mesh_strip(&m, p, n, -BAY / 2, BAY / 2);
    }
    return mesh_end(&m, "arcade");
}

/** Void of two crossing barrels of radius 1, seen from below; angles as parameters keep the steep springings smooth. */
static vec3 groin(const void *context, float s, float t, vec2 *uv) {
    const float *size = context; /* half sizes in x and z, rise */
    float x = -cosf(PI * s), z = -cosf(PI * t), h = sqrtf(fmaxf(0, 1 - fminf(x * x, z * z)));
    *uv = vec2_make(size[0] * PI * s, size[1] * PI * t);
    return vec3_make(size[0] * x, size[2] * h, size[1] * z);
}

static uint32_t make_groin(struct builtin *b, const struct hall *h, float rise) {
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, h->plaster);
    float size[3] = {AISLE / 2, BAY / 2, rise};
    mesh_surface(&m, 16, 16, groin, size);
    mesh_material(&m, h->stone);
    for (int side = -1; side <= 1; side += 2) { /* ribs under the groins */
        vec3 path[15];
        for (int i = 0; i <= 14; i++) {
            float x = -cosf(PI * (float)i / 14);
            path[i] = vec3_make(AISLE / 2 * x, rise * sqrtf(fmaxf(0, 1 - x * x)) - 0.02f, (float)side * BAY / 2 * x);
        }
        mesh_tube(&m, path, 15, 0.09f, 6);
    }
    m.transform = mat4_translation(vec3_make(0, rise - 0.1f, 0));
    mesh_sphere(&m, vec3_make(0, 0, 0), 0.22f, 10);
    return mesh_end(&m, "groin vault");
}

/** The nave's vault over one bay, with 10 x 2 sunk coffers. */
static vec3 barrel(const void *context, float s, float t, vec2 *uv) {
    UNUSED(context);
    float across = s * 10 - floorf(s * 10) - 0.5f, along = t * 2 - floorf(t * 2) - 0.5f,
          edge = 0.5f - fmaxf(fabsf(across), fabsf(along));
    float first = CLAMP((edge - 0.11f) / 0.03f, 0.0f, 1.0f), second = CLAMP((edge - 0.21f) / 0.03f, 0.0f, 1.0f);
    float r = NAVE + 0.14f * first + 0.12f * second, angle = PI * s;
    *uv = vec2_make(NAVE * PI * s, BAY * t);
    return vec3_make(-r * cosf(angle), r * sinf(angle), BAY * (t - 0.5f));
}

static uint32_t make_barrel(struct builtin *b, const struct hall *h) {
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, h->plaster);
    mesh_surface(&m, 100, 16, barrel, NULL);
    mesh_material(&m, h->stone);
    m.transform = mat4_translation(vec3_make(0, 0, BAY / 2));
    add_arch_ring(&m, NAVE - 0.22f, NAVE + 0.1f, 0, -0.3f, 0.3f, 48);
    return mesh_end(&m, "barrel vault");
}

static uint32_t make_balusters(struct builtin *b, const struct hall *h) {
    vec2 p[32];
    uint32_t n = 0;
    p[n++] = vec2_make(0.075f, 0);
    p[n++] = vec2_make(0.075f, 0.06f);
    for (int i = 0; i <= 6; i++) {
        float t = (float)i / 6;
        p[n++] = vec2_make(0.032f + 0.048f * powf(sinf(PI * powf(t, 0.62f)), 2) * (1 - 0.35f * t), 0.08f + 0.56f * t);
    }
    p[n++] = vec2_make(0.07f, 0.66f);
    p[n++] = vec2_make(0.07f, 0.72f);
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, h->marble);
    for (int i = 0; i < 13; i++) mesh_lathe(&m, vec3_make(-1.86f + 0.31f * (float)i, 0.12f, 0), p, n, 7);
    mesh_bevel_box(&m, vec3_make(-BAY / 2, 0, -0.14f), vec3_make(BAY / 2, 0.12f, 0.14f), 0.02f);
    mesh_bevel_box(&m, vec3_make(-BAY / 2, 0.84f, -0.16f), vec3_make(BAY / 2, 0.98f, 0.16f), 0.03f);
    return mesh_end(&m, "balustrade");
}

/** Floor slabs, outer walls and roofs of one bay on one side; x grows outwards from the arcade. */
static uint32_t make_aisle(struct builtin *b, const struct hall *h) {
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, h->floor);
    mesh_quad(&m, vec3_make(0, 0, BAY / 2), vec3_make(OUTER, 0, 0), vec3_make(0, 0, -BAY));
    mesh_quad(&m, vec3_make(NAVE - THICK / 2, GALLERY, BAY / 2), vec3_make(AISLE + THICK / 2, 0, 0), vec3_make(0, 0, -BAY));
    mesh_material(&m, h->ashlar);
    mesh_quad(&m, vec3_make(OUTER, 0, -BAY / 2), vec3_make(0, 0, BAY), vec3_make(0, CORNICE, 0));
    mesh_material(&m, h->stone);
    for (int floor = 0; floor < 2; floor++) { /* blind arches and half columns */
        float y = floor ? GALLERY : 0, spring = floor ? HIGH_SPRING : LOW_SPRING;
        m.transform = mat4_mul(mat4_translation(vec3_make(OUTER, y, 0)), builtin_at(0, 0, 0, PI / 2, 1));
        add_arch_ring(&m, ARCH - 0.1f, ARCH + 0.2f, spring, -0.18f, 0.18f, 32);
        m.transform = mat4_translation(vec3_make(OUTER, y, BAY / 2));
        mesh_bevel_box(&m, vec3_make(-0.22f, 0, -0.3f), vec3_make(0.1f, spring, 0.3f), 0.04f);
        mesh_bevel_box(&m, vec3_make(-0.3f, spring - 0.2f, -0.38f), vec3_make(0.1f, spring, 0.38f), 0.04f);
    }
    return mesh_end(&m, "aisle");
}

/** A gathered cloth, tied aside at two thirds of its height. */
static vec3 curtain(const void *context, float s, float t, vec2 *uv) {
    const float *size = context; /* width, height, phase */
    float tie = expf(-powf((t - 0.62f) / 0.16f, 2)), spread = 1 - 0.62f * tie - 0.08f * t,
          fold = sinf(2 * PI * 9 * s + size[2] + 2 * t);
    float depth = 0.09f * (0.5f + 0.8f * t) * (1 - 0.35f * tie), x = (s - 0.5f) * size[0] * spread - 0.30f * size[0] * tie;
    *uv = vec2_make(s * size[0] * 1.5f, t * size[1]);
    return vec3_make(x, -size[1] * t, depth * fold + 0.05f * sinf(5 * s + 3 * t + size[2]));
}

static uint32_t make_curtain(struct builtin *b, const struct hall *h, vec3 dye, float phase) {
    struct mesh_builder m;
    mesh_begin(&m, b);
    uint32_t cloth = builtin_material(b, "curtain", TEXTURE_FABRIC, dye);
    builtin_material_at(b, cloth)->double_sided = true;
    mesh_material(&m, cloth);
    float size[3] = {3.5f, 3.9f, phase};
    mesh_surface(&m, 64, 16, curtain, size);
    mesh_material(&m, h->iron);
    vec3 rod[2] = {{-ARCH, 0.03f, 0}, {ARCH, 0.03f, 0}};
    mesh_tube(&m, rod, 2, 0.03f, 10);
    return mesh_end(&m, "curtain");
}

static uint32_t make_pot(struct builtin *b, const struct hall *h) {
    const vec2 p[] = {{0, 0},         {0.24f, 0},     {0.27f, 0.05f}, {0.22f, 0.09f}, {0.33f, 0.28f},
                      {0.38f, 0.45f}, {0.36f, 0.58f}, {0.31f, 0.66f}, {0.38f, 0.70f}, {0.38f, 0.76f},
                      {0.32f, 0.76f}, {0.29f, 0.68f}, {0, 0.68f}};
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, h->terracotta);
    mesh_lathe(&m, vec3_make(0, 0, 0), p, COUNT_OF(p), 28);
    mesh_material(&m, h->leaves);
    for (int i = 0; i < 22; i++) {
        float angle = 2.4f * (float)i, tilt = 0.2f + 0.9f * (float)(i % 7) / 7, c = cosf(angle), s = sinf(angle),
              size = 0.42f + 0.03f * (float)(i % 5);
        vec3 across = {-s * size, 0, c * size},
             up = {c * sinf(tilt) * size * 1.5f, cosf(tilt) * size * 1.7f, s * sinf(tilt) * size * 1.5f};
        vec3 foot = {0.06f * c - across.x / 2, 0.66f + 0.03f * (float)(i % 9), 0.06f * s - across.z / 2};
        mesh_quad_uv(&m, foot, across, up, vec2_make(0.13f * (float)i, 1), vec2_make(0.13f * (float)i + 0.55f, 0.2f));
    }
    return mesh_end(&m, "plant");
}

static void add_flame(struct mesh_builder *m, const struct hall *h, vec3 base, float size) {
    const vec2 p[] = {
        {0, 0}, {0.26f * size, 0.18f * size}, {0.28f * size, 0.34f * size}, {0.16f * size, 0.66f * size}, {0, size}};
    mesh_material(m, h->flame);
    mesh_lathe(m, base, p, COUNT_OF(p), 5);
}

static void make_lamps(struct builtin *b, struct hall *h) {
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, h->iron); /* a bracket that points to +Z */
    vec3 arm[4] = {{0, -0.35f, 0}, {0, -0.35f, 0.14f}, {0, -0.25f, 0.24f}, {0, -0.1f, 0.26f}};
    mesh_tube(&m, arm, 4, 0.02f, 8);
    mesh_cylinder(&m, vec3_make(0, -0.14f, 0.26f), 0.03f, 0.09f, 0.14f, 12);
    mesh_bevel_box(&m, vec3_make(-0.08f, -0.5f, -0.02f), vec3_make(0.08f, -0.2f, 0.03f), 0.01f);
    add_flame(&m, h, vec3_make(0, 0, 0.26f), 0.24f);
    h->torch_mesh = mesh_end(&m, "torch");

    mesh_material(&m, h->iron); /* a cage that hangs on a rod; the flame at the origin */
    vec3 rod[2] = {{0, 0.3f, 0}, {0, 1.5f, 0}};
    mesh_tube(&m, rod, 2, 0.012f, 6);
    mesh_cylinder(&m, vec3_make(0, 0.17f, 0), 0.16f, 0.02f, 0.15f, 6);
    mesh_cylinder(&m, vec3_make(0, -0.2f, 0), 0.08f, 0.13f, 0.05f, 6);
    for (int i = 0; i < 6; i++) {
        float a = PI / 3 * (float)i;
        vec3 bar[2] = {{0.12f * cosf(a), -0.16f, 0.12f * sinf(a)}, {0.14f * cosf(a), 0.18f, 0.14f * sinf(a)}};
        mesh_tube(&m, bar, 2, 0.01f, 4);
    }
    add_flame(&m, h, vec3_make(0, -0.12f, 0), 0.22f);
    h->lantern_mesh = mesh_end(&m, "lantern");

    mesh_material(&m, h->iron); /* a ring with 12 candles */
    vec3 ring[25];
    for (int i = 0; i <= 24; i++) ring[i] = vec3_make(1.1f * cosf(PI / 12 * (float)i), 0, 1.1f * sinf(PI / 12 * (float)i));
    mesh_tube(&m, ring, 25, 0.035f, 8);
    for (int i = 0; i < 4; i++) {
        float a = PI / 2 * (float)i;
        vec3 chain[2] = {{1.1f * cosf(a), 0, 1.1f * sinf(a)}, {0, 1.5f, 0}};
        mesh_tube(&m, chain, 2, 0.015f, 5);
    }
    vec3 rope[2] = {{0, 1.5f, 0}, {0, 7, 0}};
    mesh_tube(&m, rope, 2, 0.02f, 6);
    for (int i = 0; i < 12; i++) {
        float a = PI / 6 * (float)i;
        vec3 foot = {1.1f * cosf(a), 0.03f, 1.1f * sinf(a)};
        mesh_material(&m, h->candle);
        mesh_cylinder(&m, foot, 0.03f, 0.028f, 0.16f, 8);
        add_flame(&m, h, vec3_add(foot, vec3_make(0, 0.17f, 0)), 0.09f);
    }
    h->chandelier_mesh = mesh_end(&m, "chandelier");

    mesh_material(&m, h->candle);
    mesh_cylinder(&m, vec3_make(0, 0, 0), 0.032f, 0.03f, 0.2f, 6);
    add_flame(&m, h, vec3_make(0, 0.21f, 0), 0.07f);
    h->candle_mesh = mesh_end(&m, "candle");
}

/** The wall at an end of the hall, facing +Z, with a round window of coloured glass. */
static uint32_t make_end(struct builtin *b, const struct hall *h) {
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, h->ashlar);
    mesh_quad(&m, vec3_make(-OUTER, 0, 0), vec3_make(2 * OUTER, 0, 0), vec3_make(0, CORNICE + NAVE + 1, 0));
    const vec3 centre = {0, CORNICE - 0.4f, 0};
    uint32_t glass[3];
    for (int i = 0; i < 3; i++)
        glass[i] = builtin_glow(b, "stained glass", vec3_scale(builtin_hue(0.6f + 0.2f * (float)i, 0.85f), 5));
    for (int ring = 0; ring < 2; ring++)
        for (int i = 0; i < 16; i++) {
            float a = PI / 8 * (float)i, r0 = ring ? 1.75f : 0.55f, r1 = ring ? 2.75f : 1.6f, gap = 0.10f;
            mesh_material(&m, glass[(i + ring) % 3]);
            uint32_t v[8];
            for (int k = 0; k < 4; k++) {
                float t = a + gap / (ring ? 2.2f : 1.0f) + (PI / 8 - 2 * gap / (ring ? 2.2f : 1.0f)) * (float)k / 3;
                for (int e = 0; e < 2; e++) {
                    float r = e ? r1 : r0;
                    vec3 p = vec3_add(centre, vec3_make(r * cosf(t), r * sinf(t), 0.02f));
                    v[2 * k + e] = mesh_vertex(&m, p, vec3_make(0, 0, 1), vec2_make(p.x, -p.y));
                }
            }
            for (int k = 0; k < 3; k++) {
                mesh_triangle(&m, v[2 * k], v[2 * k + 1], v[2 * k + 3]);
                mesh_triangle(&m, v[2 * k], v[2 * k + 3], v[2 * k + 2]);
            }
        }
    mesh_material(&m, h->stone);
    for (int i = 0; i < 4; i++) {
        const float radii[] = {0.5f, 1.67f, 2.85f, 3.1f};
        vec3 path[49];
        for (int k = 0; k <= 48; k++)
            path[k] =
                vec3_add(centre, vec3_make(radii[i] * cosf(PI / 24 * (float)k), radii[i] * sinf(PI / 24 * (float)k), 0.04f));
        mesh_tube(&m, path, 49, i == 3 ? 0.16f : 0.09f, 8);
    }
    return mesh_end(&m, "end wall");
}

static void place_architecture(struct builtin *b, struct hall *h) {
    uint32_t low_column = make_column(b, h, 0.36f, LOW_SPRING, 22), high_column = make_column(b, h, 0.22f, HIGH_SPRING, 12);
    uint32_t low_arcade = make_arcade(b, h, LOW_SPRING, GALLERY),
             high_arcade = make_arcade(b, h, HIGH_SPRING, CORNICE - GALLERY);
    uint32_t low_groin = make_groin(b, h, GALLERY - LOW_SPRING - 0.2f),
             high_groin = make_groin(b, h, CORNICE - GALLERY - HIGH_SPRING - 0.1f);
    uint32_t vault = make_barrel(b, h), balusters = make_balusters(b, h), aisle = make_aisle(b, h), end = make_end(b, h);
    for (int i = 0; i <= BAYS; i++)
        for (int side = -1; side <= 1; side += 2) {
            float x = (float)side * NAVE, z = -HALF_LENGTH + BAY * (float)i, middle = z + BAY / 2;
            builtin_place(b, low_column, builtin_at(x, 0, z, 0, 1));
            for (int pair = -1; pair <= 1; pair += 2)
                builtin_place(b, high_column, builtin_at(x + 0.22f * (float)pair, GALLERY, z, 0, 1));
            if (i == BAYS) continue;
            builtin_place(b, low_arcade, builtin_at(x, 0, middle, PI / 2, 1));
            builtin_place(b, high_arcade, builtin_at(x, GALLERY, middle, PI / 2, 1));
            builtin_place(b, balusters, builtin_at(x, GALLERY, middle, PI / 2, 1));
            float aisle_x = (float)side * (NAVE + AISLE / 2);
            builtin_place(b, low_groin, builtin_at(aisle_x, LOW_SPRING, middle, 0, 1));
            builtin_place(b, high_groin, builtin_at(aisle_x, GALLERY + HIGH_SPRING, middle, 0, 1));
            builtin_place(b, aisle, builtin_at(0, 0, middle, side > 0 ? 0 : PI, 1));
            if (side > 0) builtin_place(b, vault, builtin_at(0, CORNICE, middle, 0, 1));
        }
    builtin_place(b, end, builtin_at(0, 0, -HALF_LENGTH, 0, 1));
    builtin_place(b, end, builtin_at(0, 0, HALF_LENGTH, PI, 1));
}

static void place_furniture(struct builtin *b, struct hall *h) {
    const vec3 dyes[] = {{0.55f, 0.04f, 0.04f}, {0.06f, 0.22f, 0.10f}, {0.06f, 0.10f, 0.35f}};
    uint32_t curtains[3], pot = make_pot(b, h);
    for (uint32_t i = 0; i < 3; i++) curtains[i] = make_curtain(b, h, dyes[i], 1.3f * (float)i);
    for (int i = 0; i < BAYS; i++)
        for (int side = -1; side <= 1; side += 2) {
            float z = -HALF_LENGTH + BAY * ((float)i + 0.5f), x = (float)side * NAVE;
            if ((i + (side > 0)) % 2 == 0)
                builtin_place(b, curtains[(uint32_t)(i + (side > 0)) / 2 % 3],
                              builtin_at(x, LOW_SPRING + 0.9f, z, (float)side * PI / 2, 1));
            builtin_place(
                b, pot,
                builtin_at(x - (float)side * 0.75f, 0, z - BAY / 2 + 0.1f, (float)i, random_range(&b->random, 0.9f, 1.25f)));
        }
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, builtin_material(b, "carpet", TEXTURE_FABRIC, vec3_make(0.42f, 0.05f, 0.04f)));
    mesh_box(&m, vec3_make(-1.25f, 0, -HALF_LENGTH + 2), vec3_make(1.25f, 0.015f, HALF_LENGTH - 2), FACE_NO_BOTTOM);
    mesh_material(&m, h->wood);
    for (int i = 0; i < 6; i++)
        for (int side = -1; side <= 1; side += 2) { /* benches in the aisles */
            float z = -HALF_LENGTH + BAY * ((float)i + 1.5f), x = (float)side * (OUTER - 0.75f);
            mesh_bevel_box(&m, vec3_make(x - 0.22f, 0.42f, z - 0.9f), vec3_make(x + 0.22f, 0.48f, z + 0.9f), 0.012f);
            for (int leg = -1; leg <= 1; leg += 2)
                mesh_bevel_box(&m, vec3_make(x - 0.18f, 0, z + 0.7f * (float)leg - 0.04f),
                               vec3_make(x + 0.18f, 0.42f, z + 0.7f * (float)leg + 0.04f), 0.01f);
        }
    builtin_place(b, mesh_end(&m, "furniture"), mat4_identity());
}

static void place_candle(struct builtin *b, struct hall *h, float x, float y, float z) {
    if (!take_light(h)) return;
    float scale = random_range(&b->random, 0.8f, 1.3f);
    builtin_place(b, h->candle_mesh, builtin_at(x, y, z, 0, scale));
    builtin_point(b, vec3_make(x, y + 0.28f * scale + 0.03f, z), LIGHT_WARM, 2.2f, 2.4f);
}

/** The great lights first, then the small ones, until as many are placed as are wanted; what is left floats in the air. A lamp's light is above its
    flame: flames are closed and cast shadows, so that from within one no light would come out. */
static void place_lights(struct builtin *b, struct hall *h) {
    for (int i = 0; i < BAYS; i++)
        for (int k = 0; k < 12; k++) {
            float z = -HALF_LENGTH + BAY * ((float)i + 0.5f), a = PI / 6 * (float)k;
            if (k == 0) builtin_place(b, h->chandelier_mesh, builtin_at(0, 8.2f, z, 0, 1));
            if (take_light(h)) builtin_point(b, vec3_make(1.1f * cosf(a), 8.5f, z + 1.1f * sinf(a)), LIGHT_WARM, 22, 9);
        }
    for (int floor = 0; floor < 2; floor++)
        for (int i = 0; i < BAYS; i++)
            for (int side = -1; side <= 1; side += 2) {
                float z = -HALF_LENGTH + BAY * ((float)i + 0.5f), s = (float)side, y = floor ? GALLERY + 2.1f : 2.3f;
                builtin_place(b, h->torch_mesh, builtin_at(s * OUTER, y, z, -s * PI / 2, 1));
                if (take_light(h)) builtin_point(b, vec3_make(s * (OUTER - 0.26f), y + 0.27f, z), LIGHT_SODIUM, 45, 6.5f);
                float hang = floor ? GALLERY + 3.2f : 3.7f, x = s * (NAVE + AISLE / 2);
                builtin_place(b, h->lantern_mesh, builtin_at(x, hang, z, 0, 1));
                if (take_light(h)) builtin_point(b, vec3_make(x, hang + 0.13f, z), LIGHT_WARM, 26, 5.5f);
            }
    for (int i = 0; i < BAYS; i++) /* spots that wash the columns from the floor */
        for (int side = -1; side <= 1; side += 2) {
            float z = -HALF_LENGTH + BAY * (float)(i + 1), x = (float)side * (NAVE - 0.9f);
            if (take_light(h))
                builtin_spot(b, vec3_make(x, 0.1f, z), vec3_make((float)side * 0.18f, 1, 0), LIGHT_NEUTRAL, 120, 9, 0.45f);
        }
    for (int i = 0; i < BAYS; i++) /* and the vault from the cornices */
        for (int side = -1; side <= 1; side += 2) {
            float z = -HALF_LENGTH + BAY * ((float)i + 0.5f), s = (float)side;
            if (take_light(h))
                builtin_spot(b, vec3_make(s * (NAVE - 0.8f), CORNICE, z), vec3_make(-0.5f * s, 1, 0), LIGHT_WARM, 130, 8,
                             0.85f);
        }
    uint32_t rail = 20, row = 20;
    for (uint32_t i = 0; i < rail * BAYS; i++) { /* on the balustrades, then beside the carpet, then round the columns */
        float z = -HALF_LENGTH + BAY * BAYS * ((float)i + 0.5f) / (float)(rail * BAYS);
        for (int side = -1; side <= 1; side += 2) place_candle(b, h, (float)side * NAVE, GALLERY + 0.98f, z);
    }
    for (uint32_t i = 0; i < row * BAYS; i++) {
        float z = -HALF_LENGTH + BAY * BAYS * ((float)i + 0.5f) / (float)(row * BAYS);
        for (int side = -1; side <= 1; side += 2) place_candle(b, h, (float)side * (1.42f + 0.12f * (float)(i % 2)), 0, z);
    }
    builtin_fill(b, h->lights_left, vec3_make(-OUTER + 0.5f, 0.3f, -HALF_LENGTH), vec3_make(OUTER - 0.5f, 9, HALF_LENGTH), 8,
                 3);
}

void builtin_make_hall(struct builtin *b, const uint64_t *values) {
    b->random.state = values[1];
    struct hall h = {
        .stone = builtin_material(b, "sandstone", TEXTURE_SANDSTONE, vec3_make(1, 1, 1)),
        .ashlar = builtin_material(b, "ashlar", TEXTURE_STONE, vec3_make(1, 0.93f, 0.8f)),
        .marble = builtin_material(b, "marble", TEXTURE_MARBLE, vec3_make(1, 1, 1)),
        .plaster = builtin_material(b, "plaster", TEXTURE_PLASTER, vec3_make(0.85f, 0.74f, 0.58f)),
        .floor = builtin_material(b, "floor tiles", TEXTURE_TILES, vec3_make(1, 1, 1)),
        .wood = builtin_material(b, "wood", TEXTURE_WOOD, vec3_make(1, 1, 1)),
        .iron = builtin_material(b, "iron", TEXTURE_METAL, vec3_make(0.09f, 0.085f, 0.08f)),
        .terracotta = builtin_material(b, "terracotta", TEXTURE_PLASTER, vec3_make(0.75f, 0.32f, 0.18f)),
        .leaves = builtin_material(b, "leaves", TEXTURE_LEAVES, vec3_make(1, 1, 1)),
        .flame = builtin_glow(b, "flame", vec3_make(900, 460, 130)),
        .candle = builtin_plain(b, "wax", vec3_make(0.8f, 0.72f, 0.55f), 0, 0.5f),
        .lights_left = values[0],
    };
    make_lamps(b, &h);
    place_architecture(b, &h);
    place_furniture(b, &h);
    place_lights(b, &h);
    b->scene->ambient_sky = vec3_make(0.10f, 0.10f, 0.12f);
    b->scene->ambient_ground = vec3_make(0.10f, 0.07f, 0.05f);
    b->scene->background = vec3_make(0.01f, 0.015f, 0.03f);
    builtin_camera(b, "nave", vec3_make(1.9f, 1.75f, HALF_LENGTH - 1.2f), vec3_make(-0.6f, 4.4f, -8), 1.05f);
    builtin_camera(b, "gallery", vec3_make(-NAVE - 1.4f, GALLERY + 1.7f, HALF_LENGTH - 3), vec3_make(3, GALLERY + 1.2f, -6),
                   1.0f);
    builtin_camera(b, "aisle", vec3_make(NAVE + 2.6f, 1.65f, HALF_LENGTH - 1.5f), vec3_make(NAVE + 1.2f, 2.2f, -8), 1.0f);
}
