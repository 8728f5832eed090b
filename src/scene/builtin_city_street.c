/* SPDX-License-Identifier: MIT */
/** What lies and stands in the city's streets. */
#include "scene/builtin_city.h"

const vec3 city_sign_colors[CITY_SIGNS] = {{1, 0.62f, 0.25f}, {1, 0.18f, 0.12f}, {0.25f, 0.65f, 1},
                                           {0.3f, 1, 0.5f},   {1, 0.25f, 0.75f}, {0.95f, 0.9f, 0.8f}};

/* ---- ground ---- */

static void add_stripe(struct mesh_builder *m, float x, float z, float width, float length) {
    mesh_quad_uv(m, vec3_make(x - width / 2, 0.008f, z + length / 2), vec3_make(width, 0, 0), vec3_make(0, 0, -length),
                 vec2_make(x, z + length / 2), vec2_make(x + width, z - length / 2));
}

static void make_ground(struct builtin *b, struct city_meshes *meshes) {
    const float length = CITY_BLOCK + 2 * CITY_PAVEMENT, r = CITY_ROAD / 2;
    uint32_t asphalt = builtin_material(b, "wet asphalt", TEXTURE_ASPHALT, vec3_make(1, 1, 1));
    uint32_t paint = builtin_material(b, "road marking", TEXTURE_MARKING, vec3_make(1, 1, 1));
    builtin_material_at(b, paint)->roughness = 0.35f;
    uint32_t paving = builtin_material(b, "paving", TEXTURE_PAVING, vec3_make(1, 1, 1));
    uint32_t granite = builtin_material(b, "kerb", TEXTURE_CONCRETE, vec3_make(1.1f, 1.1f, 1.15f));
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, asphalt); /* along Z */
    mesh_quad(&m, vec3_make(-r, 0, length / 2), vec3_make(CITY_ROAD, 0, 0), vec3_make(0, 0, -length));
    mesh_material(&m, paint);
    for (int i = 0; i < 9; i++) add_stripe(&m, 0, -26 + 6.5f * (float)i, 0.14f, 3);
    for (int side = -1; side <= 1; side += 2) {
        for (int i = 0; i < 8; i++)
            add_stripe(&m, (float)side * (r - 2.3f), -24.5f + 7 * (float)i, 0.1f, 1.2f); /* parking */
        for (int i = 0; i < 10; i++)
            add_stripe(&m, -5.2f + 1.15f * (float)i, (float)side * (length / 2 - 1.9f), 0.55f, 2.6f); /* zebra */
        add_stripe(&m, (float)side * r / 2, (float)side * (length / 2 - 4.1f), r - 0.8f, 0.32f);      /* stop line */
    }
    meshes->road = mesh_end(&m, "road");
    mesh_material(&m, asphalt);
    mesh_quad(&m, vec3_make(-r, 0, r), vec3_make(CITY_ROAD, 0, 0), vec3_make(0, 0, -CITY_ROAD));
    meshes->crossing = mesh_end(&m, "crossing");

    float in = CITY_BLOCK / 2, out = length / 2;
    for (int side = 0; side < 4; side++) {
        m.transform = builtin_at(0, 0, 0, PI / 2 * (float)side, 1);
        mesh_material(&m, paving);
        mesh_quad(&m, vec3_make(-in, CITY_KERB, out - 0.3f), vec3_make(in + out - 0.3f, 0, 0),
                  vec3_make(0, 0, in - out + 0.3f));
        mesh_material(&m, granite);
        const vec2 kerb[] = {{out, 0}, {out, CITY_KERB - 0.03f}, {out - 0.03f, CITY_KERB}, {out - 0.3f, CITY_KERB}};
        vec2 turned[4];
        for (int i = 0; i < 4; i++) turned[i] = kerb[3 - i];
        m.transform = builtin_at(0, 0, 0, PI / 2 * (float)side - PI / 2, 1);
        mesh_strip(&m, turned, 4, -out, out);
    }
    m.transform = mat4_identity();
    mesh_material(&m, builtin_material(b, "courtyard", TEXTURE_GROUND, vec3_make(1, 1, 1)));
    mesh_quad(&m, vec3_make(-in, 0.05f, in), vec3_make(2 * in, 0, 0), vec3_make(0, 0, -2 * in));
    meshes->pavement = mesh_end(&m, "pavement");
}

/* ---- trees ---- */

/** A card of leaves, turned outwards, shaded as part of a round crown. */
static void add_leaf_card(struct mesh_builder *m, struct random_state *random, vec3 crown, vec3 size) {
    float z = random_range(random, -0.75f, 1), angle = random_range(random, 0, 2 * PI), r = sqrtf(1 - z * z);
    vec3 out = {r * cosf(angle), z, r * sinf(angle)};
    float inside = random_range(random, 0.55f, 1.0f);
    vec3 middle = vec3_add(crown, vec3_scale(vec3_mul(out, size), inside));
    vec3 jitter = {random_range(random, -0.7f, 0.7f), random_range(random, -0.7f, 0.7f), random_range(random, -0.7f, 0.7f)};
    vec3 n = vec3_normalize(vec3_add(out, jitter)), u = vec3_perpendicular(n), v = vec3_cross(n, u);
    float spin = random_range(random, 0, 2 * PI), half = random_range(random, 0.55f, 0.85f), c = cosf(spin) * half,
          s = sinf(spin) * half;
    vec3 across = vec3_add(vec3_scale(u, c), vec3_scale(v, s)), up = vec3_sub(vec3_scale(v, c), vec3_scale(u, s));
    float u0 = random_float(random), v0 = random_float(random);
    uint32_t corner[4];
    for (int i = 0; i < 4; i++) {
        float x = i == 1 || i == 2 ? 1.0f : -1.0f, y = i >= 2 ? 1.0f : -1.0f;
        vec3 p = vec3_add(middle, vec3_add(vec3_scale(across, x), vec3_scale(up, y)));
        vec3 soft = vec3_normalize(vec3_add(vec3_scale(n, 0.7f), vec3_normalize(vec3_sub(p, crown))));
        corner[i] = mesh_vertex(m, p, vec3_dot(soft, n) > 0.1f ? soft : n,
                                vec2_make(u0 + 0.5f * x * half * 1.3f, v0 - 0.5f * y * half * 1.3f));
    }
    mesh_triangle(m, corner[0], corner[1], corner[2]);
    mesh_triangle(m, corner[0], corner[2], corner[3]);
}

static void make_trees(struct builtin *b, struct city_meshes *meshes) {
    uint32_t bark = builtin_material(b, "bark", TEXTURE_BARK, vec3_make(1, 1, 1));
    uint32_t leaves = builtin_material(b, "leaves", TEXTURE_LEAVES, vec3_make(1, 1, 1));
    uint32_t iron = builtin_material(b, "tree grate", TEXTURE_METAL, vec3_make(0.06f, 0.06f, 0.06f));
    for (uint32_t kind = 0; kind < COUNT_OF(meshes->tree); kind++) {
        struct random_state random = {kind + 5};
        vec3 crown = {0, 4.3f + 0.4f * (float)kind, 0},
             size = {1.7f + 0.2f * (float)kind, 1.7f + 0.3f * (float)kind, 1.7f + 0.2f * (float)kind};
        struct mesh_builder m;
        mesh_begin(&m, b);
        mesh_material(&m, bark);
        vec3 trunk[4] = {{0, -0.1f, 0}, {0.03f, 1, 0.02f}, {-0.02f, 2, 0.04f}, {0.02f, 3.3f, 0}};
        mesh_tube(&m, trunk, 4, 0.12f, 9);
        for (int i = 0; i < 6; i++) {
            float a = 2.4f * (float)i;
            vec3 end = vec3_add(
                crown, vec3_mul(size, vec3_make(0.6f * cosf(a), random_range(&random, -0.2f, 0.5f), 0.6f * sinf(a))));
            vec3 branch[3] = {{0, 2.1f + 0.18f * (float)i, 0}, {0, 0, 0}, end};
            branch[1] = vec3_lerp(branch[0], end, 0.5f);
            branch[1].y += 0.12f;
            mesh_tube(&m, branch, 3, 0.045f, 5);
        }
        mesh_material(&m, leaves);
        for (int i = 0; i < 110; i++) add_leaf_card(&m, &random, crown, size);
        mesh_material(&m, iron);
        for (int i = 0; i < 7; i++)
            mesh_box(&m, vec3_make(-0.65f, 0, -0.63f + 0.2f * (float)i), vec3_make(0.65f, 0.02f, -0.53f + 0.2f * (float)i),
                     FACE_NO_BOTTOM);
        meshes->tree[kind] = mesh_end(&m, "tree");
    }
}

/* ---- lamps, signs, strings of lights ---- */

vec3 city_bulb(uint32_t i) {
    float t = ((float)i + 0.5f) / CITY_BULBS, x = 2 * t - 1;
    return vec3_make(CITY_STRING / 2 * x, 1.3f * (x * x - 1) - 0.1f, 0);
}

static void make_lamps(struct builtin *b, struct city_meshes *meshes) {
    uint32_t steel = builtin_material(b, "lamp post", TEXTURE_METAL, vec3_make(0.10f, 0.12f, 0.11f));
    uint32_t lamp = builtin_glow(b, "street lamp", vec3_make(420, 270, 130)),
             opal = builtin_glow(b, "lantern", vec3_make(34, 18, 7));
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, steel);
    const vec2 foot[] = {{0.2f, 0},      {0.2f, 0.1f},  {0.15f, 0.18f}, {0.13f, 0.9f},
                         {0.15f, 0.95f}, {0.1f, 1.05f}, {0.055f, 7.0f}};
    mesh_lathe(&m, vec3_make(0, 0, 0), foot, COUNT_OF(foot), 10);
    vec3 arm[6];
    for (int i = 0; i < 6; i++)
        arm[i] = vec3_make(0, 6.9f + 0.6f * sinf(PI / 2 * (float)i / 5), 1.7f * (1 - cosf(PI / 2 * (float)i / 5)));
    mesh_tube(&m, arm, 6, 0.045f, 7);
    mesh_bevel_box(&m, vec3_make(-0.13f, 7.42f, 1.35f), vec3_make(0.13f, 7.54f, 2.1f), 0.04f);
    mesh_material(&m, lamp);
    mesh_box(&m, vec3_make(-0.1f, 7.39f, 1.42f), vec3_make(0.1f, 7.425f, 2.05f), FACE_ALL & ~(unsigned)FACE_TOP);
    meshes->lamp = mesh_end(&m, "street lamp");

    mesh_material(&m, steel);
    const vec2 post[] = {{0.16f, 0},     {0.16f, 0.25f}, {0.09f, 0.4f}, {0.07f, 0.9f}, {0.09f, 0.95f},
                         {0.05f, 1.05f}, {0.04f, 2.9f},  {0.09f, 3.0f}, {0.12f, 3.05f}};
    mesh_lathe(&m, vec3_make(0, 0, 0), post, COUNT_OF(post), 10);
    const vec2 hat[] = {{0.19f, 3.42f}, {0.2f, 3.45f}, {0.1f, 3.56f}, {0.03f, 3.6f}, {0.03f, 3.7f}, {0, 3.72f}};
    mesh_lathe(&m, vec3_make(0, 0, 0), hat, COUNT_OF(hat), 8);
    mesh_material(&m, opal);
    mesh_cylinder(&m, vec3_make(0, 3.05f, 0), 0.1f, 0.16f, 0.38f, 8);
    meshes->lantern = mesh_end(&m, "lantern post");

    uint32_t wire = builtin_plain(b, "wire", vec3_make(0.02f, 0.02f, 0.02f), 0, 0.6f);
    uint32_t colored[3], bulb = builtin_glow(b, "bulb", vec3_make(24, 12, 4));
    for (int i = 0; i < 3; i++) colored[i] = builtin_glow(b, "coloured bulb", vec3_scale(city_sign_colors[i], 20));
    for (int kind = 0; kind < 2; kind++) {
        mesh_material(&m, wire);
        vec3 line[13];
        for (int i = 0; i <= 12; i++) {
            float x = (float)i / 6 - 1;
            line[i] = vec3_make(CITY_STRING / 2 * x, 1.3f * (x * x - 1), 0);
        }
        mesh_tube(&m, line, 13, 0.012f, 3);
        for (uint32_t i = 0; i < CITY_BULBS; i++) {
            mesh_material(&m, kind ? colored[i % 3] : bulb);
            mesh_sphere(&m, city_bulb(i), 0.07f, 6);
        }
        meshes->string[kind] = mesh_end(&m, "string of lights");
    }
    for (int i = 0; i < CITY_SIGNS; i++) { /* a sign that stands out from the wall, readable along the street */
        mesh_material(&m, wire);
        mesh_box(&m, vec3_make(-0.02f, 1.5f, 0), vec3_make(0.02f, 1.54f, 0.9f), FACE_ALL);
        mesh_bevel_box(&m, vec3_make(-0.06f, 0, 0.15f), vec3_make(0.06f, 1.5f, 0.85f), 0.02f);
        mesh_material(&m, builtin_glow(b, "neon", vec3_scale(city_sign_colors[i], 10)));
        for (int side = -1; side <= 1; side += 2) {
            float x = 0.085f * (float)side;
            vec3 path[25];
            for (int k = 0; k <= 24; k++) {
                float a = 2 * PI * (float)k / 24, star = i % 3 == 0   ? 1 + 0.32f * cosf(5 * a)
                                                         : i % 3 == 1 ? 1.0f
                                                                      : 1 - 0.3f * fabsf(sinf(2 * a));
                path[k] = vec3_make(x, 1.08f + 0.24f * star * sinf(a), 0.5f + 0.24f * star * cosf(a));
            }
            mesh_tube(&m, path, 25, 0.018f, 5);
            for (int k = 0; k < 3; k++) {
                vec3 bar[2] = {{x, 0.2f + 0.18f * (float)k, 0.26f},
                               {x, 0.2f + 0.18f * (float)k, 0.62f + 0.06f * (float)((k + i) % 3)}};
                mesh_tube(&m, bar, 2, 0.018f, 5);
            }
        }
        meshes->signs[i] = mesh_end(&m, "neon sign");
    }
}

/* ---- furniture ---- */

static void make_furniture(struct builtin *b, struct city_meshes *meshes) {
    uint32_t steel = builtin_material(b, "black steel", TEXTURE_METAL, vec3_make(0.07f, 0.07f, 0.075f));
    uint32_t wood = builtin_material(b, "bench wood", TEXTURE_WOOD, vec3_make(1, 1, 1)),
             stone = builtin_material(b, "planter", TEXTURE_CONCRETE, vec3_make(1, 1, 1));
    uint32_t leaves = builtin_material(b, "hedge", TEXTURE_LEAVES, vec3_make(0.9f, 1, 0.9f));
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, wood);
    for (int i = 0; i < 4; i++) {
        mesh_bevel_box(&m, vec3_make(-0.9f, 0.43f, -0.2f + 0.12f * (float)i),
                       vec3_make(0.9f, 0.47f, -0.1f + 0.12f * (float)i), 0.008f);
        if (i < 3)
            mesh_bevel_box(&m, vec3_make(-0.9f, 0.56f + 0.13f * (float)i, -0.26f - 0.02f * (float)i),
                           vec3_make(0.9f, 0.66f + 0.13f * (float)i, -0.22f - 0.02f * (float)i), 0.008f);
    }
    mesh_material(&m, steel);
    for (int side = -1; side <= 1; side += 2) {
        float x = 0.7f * (float)side;
        mesh_box(&m, vec3_make(x - 0.03f, 0, 0.16f), vec3_make(x + 0.03f, 0.43f, 0.22f), FACE_SIDES);
        mesh_box(&m, vec3_make(x - 0.03f, 0, -0.24f), vec3_make(x + 0.03f, 0.9f, -0.2f), FACE_SIDES);
    }
    meshes->bench = mesh_end(&m, "bench");
    mesh_material(&m, steel);
    const vec2 bin[] = {{0.2f, 0}, {0.24f, 0.05f}, {0.26f, 0.8f}, {0.28f, 0.84f}, {0.28f, 0.9f}, {0.2f, 0.96f}, {0, 0.98f}};
    mesh_lathe(&m, vec3_make(0, 0, 0), bin, COUNT_OF(bin), 12);
    meshes->bin = mesh_end(&m, "bin");
    mesh_material(&m, steel);
    const vec2 bollard[] = {{0.09f, 0},      {0.09f, 0.1f},  {0.06f, 0.14f}, {0.055f, 0.8f},
                            {0.075f, 0.84f}, {0.075f, 0.9f}, {0, 0.98f}};
    mesh_lathe(&m, vec3_make(0, 0, 0), bollard, COUNT_OF(bollard), 8);
    meshes->bollard = mesh_end(&m, "bollard");
    mesh_material(&m, stone);
    mesh_bevel_box(&m, vec3_make(-0.7f, 0, -0.3f), vec3_make(0.7f, 0.5f, 0.3f), 0.04f);
    mesh_material(&m, leaves);
    struct random_state random = {3};
    for (int i = 0; i < 22; i++)
        add_leaf_card(&m, &random, vec3_make(-0.5f + 0.33f * (float)(i % 4), 0.62f, 0), vec3_make(0.25f, 0.3f, 0.2f));
    meshes->planter = mesh_end(&m, "planter");
    mesh_material(&m, steel);
    mesh_lathe(&m, vec3_make(0, 0.004f, 0),
               (const vec2[]){{0.36f, 0}, {0.34f, 0.012f}, {0.3f, 0.012f}, {0.28f, 0.006f}, {0, 0.008f}}, 5, 20);
    meshes->manhole = mesh_end(&m, "manhole");

    uint32_t off = builtin_plain(b, "lens", vec3_make(0.03f, 0.02f, 0.02f), 0, 0.2f);
    for (int go = 0; go < 2; go++) {
        mesh_material(&m, steel);
        mesh_cylinder(&m, vec3_make(0, 0, 0), 0.07f, 0.055f, 3.2f, 8);
        mesh_bevel_box(&m, vec3_make(-0.15f, 2.5f, 0.05f), vec3_make(0.15f, 3.4f, 0.28f), 0.03f);
        for (int i = 0; i < 3; i++) {
            bool lit = go ? i == 0 : i == 2;
            mesh_material(&m, lit ? builtin_glow(b, "signal", go ? vec3_make(4, 60, 28) : vec3_make(80, 4, 2)) : off);
            m.transform = mat4_mul(mat4_translation(vec3_make(0, 2.68f + 0.28f * (float)i, 0.28f)),
                                   (mat4){{1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1}});
            mesh_cylinder(&m, vec3_make(0, 0, 0), 0.1f, 0.09f, 0.02f, 12);
            m.transform = mat4_identity();
        }
        meshes->traffic_light[go] = mesh_end(&m, "traffic light");
    }
}

void city_make_street(struct builtin *b, struct city_meshes *meshes) {
    make_ground(b, meshes);
    make_trees(b, meshes);
    make_lamps(b, meshes);
    make_furniture(b, meshes);
}
