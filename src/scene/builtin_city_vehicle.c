/* SPDX-License-Identifier: MIT */
/** The city's cars, and what of it is only seen from far away. */
#include "scene/builtin_city.h"

/* ---- cars: 4.3 m long, the front towards +Z ---- */

#define CAR_HALF 2.15f
#define CAR_WIDTH 0.88f

/** |x|^p with the sign of x. */
static float signed_power(float x, float p) { return copysignf(powf(fabsf(x), p), x); }

/** 0 below `low`, 1 above `high`, smooth between. */
static float ramp(float low, float high, float x) {
    float t = CLAMP((x - low) / (high - low), 0.0f, 1.0f);
    return t * t * (3 - 2 * t);
}

/** A rounded box's outline: x across, y from 0 to 1, as `s` runs from the right sill over the top to the left one. */
static vec2 section(float s, float power) {
    float a = PI * s;
    return vec2_make(signed_power(cosf(a), 2 / power), powf(fmaxf(sinf(a), 0), 2 / power));
}

/** How much of its full size a body has at `t` in 0..1 along it: full in the middle, rounded off to nothing at the ends. */
static float end_rounding(float t, float power) { return powf(fmaxf(0, 1 - powf(fabsf(2 * t - 1), power)), 1 / power); }

static vec3 car_body(const void *context, float s, float t, vec2 *uv) {
    UNUSED(context);
    float z = CAR_HALF * (2 * t - 1), e = end_rounding(t, 14), bonnet = ramp(0.5f, 2.0f, z), boot = ramp(1.2f, 2.1f, -z);
    float top = 0.70f - 0.20f * bonnet - 0.06f * boot, waist = CAR_WIDTH * (0.80f + 0.20f * e) * (1 - 0.06f * bonnet);
    vec2 p = section(s, 4.5f);
    float lift = 0.24f + 0.06f * bonnet * e;
    *uv = vec2_make(z, s * 2.6f);
    return vec3_make(waist * p.x * (1 - 0.07f * p.y), lift + (top * (0.55f + 0.45f * e)) * p.y, z);
}

static vec3 car_cabin(const void *context, float s, float t, vec2 *uv) {
    const float *grow = context;
    float z = -1.75f + 2.75f * t, shape = powf(fmaxf(0, sinf(PI * powf(t, 0.85f))), 0.55f);
    vec2 p = section(s, 3.6f);
    float height = 0.60f * shape;
    *uv = vec2_make(z, s * 2);
    return vec3_make((CAR_WIDTH - 0.08f) * p.x * (1 - 0.24f * p.y * shape), 0.84f + *grow + height * p.y, z);
}

/** The roof: the middle of the cabin, a little above it. */
static vec3 car_roof(const void *context, float s, float t, vec2 *uv) {
    return car_cabin(context, 0.27f + 0.46f * s, 0.30f + 0.36f * t, uv);
}

static void add_wheels(struct mesh_builder *m, uint32_t tyre, uint32_t rim) {
    const vec2 outline[] = {{0.315f, -0.1f}, {0.315f, 0.075f}, {0.29f, 0.1f}, {0.2f, 0.1f}};
    const vec2 disc[] = {{0.2f, 0.085f}, {0.13f, 0.065f}, {0, 0.095f}};
    const vec2 arch[] = {{0.375f, -0.1f}, {0.375f, 0.083f}, {0.2f, 0.083f}};
    for (int i = 0; i < 4; i++) {
        float x = i & 1 ? 0.80f : -0.80f, z = i & 2 ? 1.32f : -1.30f, side = i & 1 ? 1.0f : -1.0f;
        /* The lathe's axis +Y turns outwards, to +X or -X. */
        m->transform = (mat4){{0, -side, 0, 0, side, 0, 0, 0, 0, 0, 1, 0, x, 0.315f, z, 1}};
        mesh_material(m, tyre);
        mesh_lathe(m, vec3_make(0, 0, 0), arch, COUNT_OF(arch), 16);
        mesh_lathe(m, vec3_make(0, 0, 0), outline, COUNT_OF(outline), 16);
        mesh_material(m, rim);
        mesh_lathe(m, vec3_make(0, 0, 0), disc, COUNT_OF(disc), 10);
    }
    m->transform = mat4_identity();
}

static uint32_t make_car(struct builtin *b, uint32_t paint, uint32_t glass, uint32_t black, uint32_t chrome, uint32_t lens) {
    const float flush = 0, above = 0.012f;
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, paint);
    mesh_surface(&m, 14, 16, car_body, NULL);
    mesh_surface(&m, 6, 5, car_roof, &above);
    mesh_material(&m, glass);
    mesh_surface(&m, 12, 10, car_cabin, &flush);
    mesh_material(&m, black);
    mesh_box(&m, vec3_make(-0.8f, 0.17f, -2.0f), vec3_make(0.8f, 0.32f, 2.0f), FACE_ALL);
    mesh_bevel_box(&m, vec3_make(-0.82f, 0.28f, 1.98f), vec3_make(0.82f, 0.46f, 2.19f), 0.05f);
    mesh_bevel_box(&m, vec3_make(-0.82f, 0.30f, -2.19f), vec3_make(0.82f, 0.50f, -1.98f), 0.05f);
    mesh_box(&m, vec3_make(-0.4f, 0.50f, 2.05f), vec3_make(0.4f, 0.62f, 2.15f), FACE_FRONT | FACE_TOP);
    mesh_material(&m, chrome);
    for (int side = -1; side <= 1; side += 2) {
        float x = (float)side;
        mesh_bevel_box(&m, vec3_make(fminf(0.8f * x, 0.98f * x), 0.88f, 0.62f),
                       vec3_make(fmaxf(0.8f * x, 0.98f * x), 1.0f, 0.74f), 0.02f);
        mesh_material(&m, lens);
        mesh_box(&m, vec3_make(0.62f * x - 0.16f, 0.52f, 2.0f), vec3_make(0.62f * x + 0.16f, 0.66f, 2.14f), FACE_NO_BOTTOM);
        mesh_box(&m, vec3_make(0.64f * x - 0.14f, 0.62f, -2.15f), vec3_make(0.64f * x + 0.14f, 0.80f, -2.0f),
                 FACE_NO_BOTTOM);
        mesh_material(&m, chrome);
    }
    add_wheels(&m, black, chrome);
    return mesh_end(&m, "car");
}

void city_make_vehicles(struct builtin *b, struct city_meshes *meshes) {
    const vec3 paints[CITY_PAINTS] = {{0.55f, 0.55f, 0.56f}, {0.02f, 0.02f, 0.025f}, {0.32f, 0.02f, 0.02f},
                                      {0.02f, 0.06f, 0.20f}, {0.65f, 0.63f, 0.58f},  {0.05f, 0.12f, 0.08f}};
    uint32_t glass = builtin_plain(b, "car glass", vec3_make(0.01f, 0.012f, 0.014f), 0, 0.05f),
             black = builtin_plain(b, "rubber", vec3_make(0.02f, 0.02f, 0.02f), 0, 0.6f);
    uint32_t chrome = builtin_plain(b, "chrome", vec3_make(0.7f, 0.7f, 0.72f), 1, 0.22f),
             lens = builtin_plain(b, "lamp lens", vec3_make(0.25f, 0.1f, 0.09f), 0, 0.1f);
    for (int i = 0; i < CITY_PAINTS; i++)
        meshes->cars[i] =
            make_car(b, builtin_plain(b, "car paint", paints[i], i % 2 ? 0.0f : 0.4f, 0.22f), glass, black, chrome, lens);
    struct mesh_builder m;
    mesh_begin(&m, b); /* laid over the lenses of a car that drives */
    for (int side = -1; side <= 1; side += 2) {
        float x = (float)side;
        mesh_material(&m, builtin_glow(b, "headlight", vec3_make(420, 400, 350)));
        mesh_bevel_box(&m, vec3_make(0.62f * x - 0.13f, 0.53f, 2.05f), vec3_make(0.62f * x + 0.13f, 0.65f, 2.155f), 0.03f);
        mesh_material(&m, builtin_glow(b, "tail light", vec3_make(60, 2.2f, 1.2f)));
        mesh_bevel_box(&m, vec3_make(0.64f * x - 0.145f, 0.63f, -2.165f), vec3_make(0.64f * x + 0.145f, 0.79f, -2.05f),
                       0.03f);
    }
    meshes->car_lights = mesh_end(&m, "car lights");
}

/* ---- far away ---- */

static void make_tower(struct builtin *b, struct city_meshes *meshes) {
    uint32_t stone = builtin_material(b, "tower stone", TEXTURE_STONE, vec3_make(1, 0.95f, 0.85f)),
             trim = builtin_material(b, "tower trim", TEXTURE_SANDSTONE, vec3_make(1, 1, 1));
    uint32_t face = builtin_glow(b, "clock face", vec3_make(22, 19, 13)),
             copper = builtin_material(b, "copper roof", TEXTURE_METAL, vec3_make(0.12f, 0.28f, 0.22f));
    uint32_t black = builtin_plain(b, "clock hands", vec3_make(0.01f, 0.01f, 0.01f), 0, 0.5f),
             lit = builtin_glow(b, "belfry", vec3_make(12, 7.5f, 3));
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, stone);
    mesh_box(&m, vec3_make(-5.5f, 0, -5.5f), vec3_make(5.5f, 36, 5.5f), FACE_SIDES);
    mesh_box(&m, vec3_make(-9, 0, -7), vec3_make(9, 12, 7), FACE_NO_BOTTOM);
    mesh_material(&m, trim);
    const float ledges[] = {12, 20, 27, 36};
    for (uint32_t i = 0; i < COUNT_OF(ledges); i++)
        mesh_bevel_box(&m, vec3_make(-6, ledges[i], -6), vec3_make(6, ledges[i] + 0.6f, 6), 0.15f);
    for (int i = 0; i < 4; i++) {
        float x = i & 1 ? 5.1f : -5.1f, z = i & 2 ? 5.1f : -5.1f;
        mesh_bevel_box(&m, vec3_make(x - 0.8f, 0, z - 0.8f), vec3_make(x + 0.8f, 36.5f, z + 0.8f), 0.1f);
        mesh_bevel_box(&m, vec3_make(x * 0.86f - 0.6f, 36.6f, z * 0.86f - 0.6f),
                       vec3_make(x * 0.86f + 0.6f, 42, z * 0.86f + 0.6f), 0.08f);
        mesh_cylinder(&m, vec3_make(x, 36.5f, z), 0.7f, 0, 3.4f, 8);
    }
    mesh_bevel_box(&m, vec3_make(-5.3f, 42, -5.3f), vec3_make(5.3f, 42.6f, 5.3f), 0.12f);
    mesh_material(&m, lit);
    mesh_box(&m, vec3_make(-3.6f, 36.6f, -3.6f), vec3_make(3.6f, 42, 3.6f), FACE_SIDES);
    mesh_material(&m, copper);
    const vec2 spire[] = {{5.4f, 42.6f}, {4.6f, 43.4f}, {3.4f, 46}, {1.6f, 49}, {1.2f, 50.2f}, {0.5f, 53}, {0, 62}};
    mesh_lathe(&m, vec3_make(0, 0, 0), spire, COUNT_OF(spire), 8);
    for (int side = 0; side < 4; side++) {
        mat4 turn = builtin_at(0, 0, 0, PI / 2 * (float)side, 1),
             tip = {{1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 31.8f, 5.5f, 1}};
        m.transform = mat4_mul(turn, tip); /* +Y of the discs points out of the wall */
        mesh_material(&m, trim);
        mesh_cylinder(&m, vec3_make(0, 0, 0), 3.5f, 3.4f, 0.25f, 40);
        mesh_material(&m, face);
        mesh_cylinder(&m, vec3_make(0, 0.25f, 0), 3.0f, 3.0f, 0.05f, 40);
        mesh_material(&m, black);
        m.transform = turn;
        mesh_box(&m, vec3_make(-0.1f, 31.8f, 5.82f), vec3_make(0.1f, 34.3f, 5.86f), FACE_ALL);
        mesh_box(&m, vec3_make(-0.1f, 31.7f, 5.82f), vec3_make(1.8f, 31.9f, 5.86f), FACE_ALL);
        for (int hour = 0; hour < 12; hour++) {
            float a = PI / 6 * (float)hour, x = 2.65f * sinf(a), y = 31.8f + 2.65f * cosf(a);
            mesh_box(&m, vec3_make(x - 0.09f, y - 0.09f, 5.81f), vec3_make(x + 0.09f, y + 0.09f, 5.84f), FACE_ALL);
        }
    }
    m.transform = mat4_identity();
    meshes->tower = mesh_end(&m, "clock tower");
}

void city_make_skyline(struct builtin *b, struct city_meshes *meshes) {
    uint32_t facade = builtin_material(b, "far facade", TEXTURE_FACADE, vec3_make(0.8f, 0.8f, 0.85f)),
             roof = builtin_plain(b, "far roof", vec3_make(0.06f, 0.06f, 0.07f), 0, 0.9f);
    builtin_material_at(b, facade)->emissive = vec3_make(7, 7, 7);
    struct mesh_builder m;
    mesh_begin(&m, b);
    for (int i = 0; i < CITY_SHELLS; i++) {
        float half = 12, height = 16 + 9.6f * (float)i;
        mesh_material(&m, facade);
        mesh_box(&m, vec3_make(-half, 0, -half), vec3_make(half, height, half), FACE_SIDES);
        mesh_material(&m, roof);
        mesh_box(&m, vec3_make(-half, height - 0.5f, -half), vec3_make(half, height, half), FACE_TOP);
        meshes->shells[i] = mesh_end(&m, "far building");
    }
    mesh_material(&m, roof);
    mesh_box(&m, vec3_make(-0.06f, 0, -0.06f), vec3_make(0.06f, 7.3f, 0.06f), FACE_SIDES);
    mesh_material(&m, builtin_glow(b, "far lamp", vec3_make(90, 60, 30)));
    mesh_box(&m, vec3_make(-0.15f, 7.3f, -0.15f), vec3_make(0.15f, 7.5f, 0.15f), FACE_SIDES | FACE_BOTTOM);
    meshes->far_lamp = mesh_end(&m, "far lamp");
    mesh_material(&m, builtin_material(b, "far leaves", TEXTURE_LEAVES, vec3_make(0.8f, 0.8f, 0.8f)));
    for (int i = 0; i < 3; i++) {
        float a = PI / 3 * (float)i;
        mesh_quad(&m, vec3_make(-1.6f * cosf(a), 1.8f, -1.6f * sinf(a)), vec3_make(3.2f * cosf(a), 0, 3.2f * sinf(a)),
                  vec3_make(0, 4, 0));
    }
    meshes->far_tree = mesh_end(&m, "far tree");
    mesh_material(&m, builtin_plain(b, "far ground", vec3_make(0.05f, 0.05f, 0.055f), 0, 0.7f));
    mesh_quad(&m, vec3_make(-CITY_PITCH / 2, -0.02f, CITY_PITCH / 2), vec3_make(CITY_PITCH, 0, 0),
              vec3_make(0, 0, -CITY_PITCH));
    meshes->far_block = mesh_end(&m, "far ground");
    make_tower(b, meshes);
}
