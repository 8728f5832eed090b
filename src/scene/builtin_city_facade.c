/* SPDX-License-Identifier: MIT */
/** Pieces of the city's facades: windows, shop fronts, cornices, roofs. */
#include "scene/builtin_city.h"

struct facade_materials {
    uint32_t wall[CITY_STYLES], trim[CITY_STYLES], frame, dark, room, display, iron, roof, plaster, wood, shutter, glass,
        pane;
    uint32_t awning[2], letters[CITY_SHOPS], fascia[CITY_SHOPS], door_lamp;
};

/** The opening of a style's window, and how it is divided. */
struct window_shape {
    float half_width, low, high, depth;
    int bars_across, bars_up;
};

static const struct window_shape shapes[CITY_STYLES] = {
    {0.62f, 0.85f, 2.75f, 0.24f, 1, 1},
    {0.66f, 0.55f, 2.75f, 0.22f, 1, 2},
    {0.85f, 0.70f, 2.85f, 0.30f, 1, 1},
    {1.45f, 0.60f, 2.90f, 0.16f, 3, 0},
};

static void make_materials(struct builtin *b, struct facade_materials *f) {
    f->wall[0] = builtin_material(b, "brick", TEXTURE_BRICK, vec3_make(1, 1, 1));
    f->wall[1] = builtin_material(b, "cream plaster", TEXTURE_PLASTER, vec3_make(0.95f, 0.80f, 0.58f));
    f->wall[2] = builtin_material(b, "ashlar", TEXTURE_STONE, vec3_make(1, 0.97f, 0.92f));
    f->wall[3] = builtin_material(b, "concrete", TEXTURE_CONCRETE, vec3_make(0.95f, 1, 1.05f));
    f->trim[0] = builtin_material(b, "sandstone trim", TEXTURE_SANDSTONE, vec3_make(1, 1, 1));
    f->trim[1] = builtin_material(b, "white trim", TEXTURE_PLASTER, vec3_make(1, 0.97f, 0.92f));
    f->trim[2] = f->trim[0];
    f->trim[3] = builtin_material(b, "aluminium", TEXTURE_METAL, vec3_make(0.35f, 0.37f, 0.4f));
    f->frame = builtin_plain(b, "window frame", vec3_make(0.5f, 0.49f, 0.46f), 0, 0.45f);
    f->dark = builtin_plain(b, "dark window", vec3_make(0.012f, 0.014f, 0.02f), 0, 0.05f);
    f->room = builtin_material(b, "lit window", TEXTURE_ROOMS, vec3_make(1, 1, 1));
    f->display = builtin_material(b, "shop display", TEXTURE_ROOMS, vec3_make(1, 1, 1));
    builtin_material_at(b, f->room)->roughness = 0.08f;
    builtin_material_at(b, f->room)->emissive = vec3_make(6, 5.6f, 5);
    builtin_material_at(b, f->display)->emissive = vec3_make(12, 10.5f, 8.5f);
    f->iron = builtin_material(b, "wrought iron", TEXTURE_METAL, vec3_make(0.05f, 0.05f, 0.055f));
    f->roof = builtin_material(b, "roof", TEXTURE_CONCRETE, vec3_make(0.35f, 0.34f, 0.36f));
    f->plaster = builtin_material(b, "courtyard plaster", TEXTURE_PLASTER, vec3_make(0.7f, 0.66f, 0.6f));
    builtin_material_at(b, f->plaster)->double_sided = true;
    f->wood = builtin_material(b, "painted wood", TEXTURE_WOOD, vec3_make(0.35f, 0.6f, 0.5f));
    f->shutter = builtin_material(b, "shutter", TEXTURE_METAL, vec3_make(0.4f, 0.42f, 0.45f));
    f->glass = builtin_glass(b, "shop glass", vec3_make(0.6f, 0.7f, 0.72f), 0.12f);
    f->door_lamp = builtin_glow(b, "door lamp", vec3_make(60, 38, 18));
    const vec3 dyes[] = {{0.5f, 0.06f, 0.05f}, {0.08f, 0.25f, 0.16f}};
    for (int i = 0; i < 2; i++) {
        f->awning[i] = builtin_material(b, "awning", TEXTURE_FABRIC, dyes[i]);
        builtin_material_at(b, f->awning[i])->double_sided = true;
    }
    const vec3 fascias[] = {{0.03f, 0.05f, 0.04f}, {0.10f, 0.015f, 0.015f}, {0.02f, 0.03f, 0.07f}, {0.05f, 0.04f, 0.03f}};
    for (int i = 0; i < CITY_SHOPS; i++) {
        f->fascia[i] = builtin_plain(b, "fascia", fascias[i], 0, 0.35f);
        f->letters[i] = builtin_glow(b, "shop letters", vec3_scale(city_sign_colors[i], 9));
    }
}

/** A wall in the plane z = 0 with a rectangular opening, and the opening's four inner faces. */
static void add_wall_with_opening(struct mesh_builder *m, float height, float half, float low, float high, float depth) {
    const float w = CITY_BAY / 2;
    mesh_quad(m, vec3_make(-w, 0, 0), vec3_make(w - half, 0, 0), vec3_make(0, height, 0));
    mesh_quad(m, vec3_make(half, 0, 0), vec3_make(w - half, 0, 0), vec3_make(0, height, 0));
    if (low > 0) mesh_quad(m, vec3_make(-half, 0, 0), vec3_make(2 * half, 0, 0), vec3_make(0, low, 0));
    if (high < height) mesh_quad(m, vec3_make(-half, high, 0), vec3_make(2 * half, 0, 0), vec3_make(0, height - high, 0));
    mesh_quad(m, vec3_make(-half, low, 0), vec3_make(0, 0, -depth), vec3_make(0, high - low, 0));
    mesh_quad(m, vec3_make(half, low, -depth), vec3_make(0, 0, depth), vec3_make(0, high - low, 0));
    mesh_quad(m, vec3_make(-half, low, 0), vec3_make(2 * half, 0, 0), vec3_make(0, 0, -depth));
    mesh_quad(m, vec3_make(-half, high, -depth), vec3_make(2 * half, 0, 0), vec3_make(0, 0, depth));
}

/** A picture of the 4 x 4 rooms on a rectangle that faces +Z. */
static void add_room(struct mesh_builder *m, int cell, vec3 low, float width, float height) {
    float u = (float)(cell % 4) / 4, v = (float)(cell / 4) / 4, margin = 0.004f;
    mesh_quad_uv(m, low, vec3_make(width, 0, 0), vec3_make(0, height, 0), vec2_make(u + margin, v + 0.25f - margin),
                 vec2_make(u + 0.25f - margin, v + margin));
}

static void add_bars(struct mesh_builder *m, const struct window_shape *s) {
    const unsigned faces = FACE_LEFT | FACE_RIGHT | FACE_TOP | FACE_BOTTOM | FACE_FRONT;
    float z = -s->depth;
    for (int i = 1; i <= s->bars_across; i++) {
        float x = -s->half_width + 2 * s->half_width * (float)i / (float)(s->bars_across + 1);
        mesh_box(m, vec3_make(x - 0.03f, s->low, z), vec3_make(x + 0.03f, s->high, z + 0.05f),
                 faces & ~(unsigned)(FACE_TOP | FACE_BOTTOM));
    }
    for (int i = 1; i <= s->bars_up; i++) {
        float y = s->low + (s->high - s->low) * (0.3f + 0.4f * (float)i / (float)s->bars_up);
        mesh_box(m, vec3_make(-s->half_width, y - 0.025f, z), vec3_make(s->half_width, y + 0.025f, z + 0.045f),
                 faces & ~(unsigned)(FACE_LEFT | FACE_RIGHT));
    }
    float e = 0.05f;
    mesh_box(m, vec3_make(-s->half_width, s->low, z), vec3_make(-s->half_width + e, s->high, z + 0.06f),
             FACE_RIGHT | FACE_FRONT);
    mesh_box(m, vec3_make(s->half_width - e, s->low, z), vec3_make(s->half_width, s->high, z + 0.06f),
             FACE_LEFT | FACE_FRONT);
    mesh_box(m, vec3_make(-s->half_width, s->low, z), vec3_make(s->half_width, s->low + e, z + 0.06f),
             FACE_TOP | FACE_FRONT);
    mesh_box(m, vec3_make(-s->half_width, s->high - e, z), vec3_make(s->half_width, s->high, z + 0.06f),
             FACE_BOTTOM | FACE_FRONT);
}

/** A box that stands out of the wall: all faces but the back. */
static void add_block(struct mesh_builder *m, float x0, float y0, float x1, float y1, float out) {
    mesh_box(m, vec3_make(x0, y0, 0), vec3_make(x1, y1, out), FACE_ALL & ~(unsigned)FACE_BACK);
}

static void add_trim(struct mesh_builder *m, int style, const struct window_shape *s) {
    float w = CITY_BAY / 2, h = s->half_width;
    switch (style) {
    case 0: /* sill and lintel */
        add_block(m, -h - 0.14f, s->low - 0.12f, h + 0.14f, s->low, 0.10f);
        add_block(m, -h - 0.18f, s->high, h + 0.18f, s->high + 0.26f, 0.04f);
        add_block(m, -0.11f, s->high - 0.02f, 0.11f, s->high + 0.32f, 0.08f);
        break;
    case 1: { /* surround and pediment */
        add_block(m, -h - 0.16f, s->low, -h, s->high, 0.05f);
        add_block(m, h, s->low, h + 0.16f, s->high, 0.05f);
        add_block(m, -h - 0.24f, s->low - 0.10f, h + 0.24f, s->low, 0.14f);
        add_block(m, -h - 0.22f, s->high, h + 0.22f, s->high + 0.14f, 0.10f);
        const vec2 gable[] = {{-h - 0.26f, s->high + 0.14f}, {h + 0.26f, s->high + 0.14f}, {0, s->high + 0.46f}};
        mesh_prism(m, gable, 3, 0, 0.15f, true);
        break;
    }
    case 2: /* pilasters that run through, sill, keystone */
        add_block(m, -w, 0, -w + 0.24f, CITY_FLOOR, 0.12f);
        add_block(m, w - 0.24f, 0, w, CITY_FLOOR, 0.12f);
        add_block(m, -h - 0.10f, s->low - 0.14f, h + 0.10f, s->low, 0.12f);
        add_block(m, -h - 0.10f, s->high, h + 0.10f, s->high + 0.2f, 0.07f);
        add_block(m, -w, CITY_FLOOR - 0.18f, w, CITY_FLOOR, 0.16f);
        break;
    default: /* a metal band, and a fin */
        add_block(m, -w, 0, w, 0.22f, 0.06f);
        add_block(m, -w, 0.22f, -w + 0.08f, CITY_FLOOR, 0.22f);
    }
}

static uint32_t make_window(struct builtin *b, const struct facade_materials *f, int style, int kind) {
    static const int cells[CITY_WINDOWS] = {-1, -1, 0, 3, 6, 9, 13};
    const struct window_shape *s = &shapes[style];
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, f->wall[style]);
    add_wall_with_opening(&m, CITY_FLOOR, s->half_width, s->low, s->high, s->depth);
    mesh_material(&m, f->trim[style]);
    add_trim(&m, style, s);
    mesh_material(&m, f->frame);
    add_bars(&m, s);
    vec3 low = {-s->half_width, s->low, -s->depth};
    float width = 2 * s->half_width, height = s->high - s->low;
    if (kind == 1) { /* a blind, half drawn */
        mesh_material(&m, f->plaster);
        mesh_quad(&m, vec3_make(low.x, s->low + 0.45f * height, low.z + 0.005f), vec3_make(width, 0, 0),
                  vec3_make(0, 0.55f * height, 0));
    }
    mesh_material(&m, cells[kind] < 0 ? f->dark : f->room);
    if (cells[kind] < 0)
        mesh_quad(&m, low, vec3_make(width, 0, 0), vec3_make(0, height, 0));
    else
        add_room(&m, (cells[kind] + 5 * style) % 16, low, width, height);
    return mesh_end(&m, cells[kind] < 0 ? "dark window" : "lit window");
}

/** Boxes of various widths along the fascia: from across the street they read as a name. */
static void add_letters(struct mesh_builder *m, int seed) {
    struct random_state random = {(uint64_t)seed + 77};
    float x = -1.05f;
    while (x < 0.95f) {
        float width = random_range(&random, 0.07f, 0.17f), height = random_float(&random) < 0.3f ? 0.30f : 0.22f;
        if (random_float(&random) > 0.14f) {
            mesh_box(m, vec3_make(x, 3.42f, 0.12f), vec3_make(x + 0.045f, 3.42f + height, 0.15f), FACE_FRONT);
            mesh_box(m, vec3_make(x, 3.42f, 0.12f), vec3_make(x + width, 3.46f, 0.15f), FACE_FRONT);
            if (random_float(&random) < 0.6f)
                mesh_box(m, vec3_make(x, 3.56f, 0.12f), vec3_make(x + width, 3.60f, 0.15f), FACE_FRONT);
            if (random_float(&random) < 0.5f)
                mesh_box(m, vec3_make(x + width - 0.045f, 3.42f, 0.12f), vec3_make(x + width, 3.42f + height, 0.15f),
                         FACE_FRONT);
        }
        x += width + 0.06f;
    }
}

/** Kinds 0 to 2 are lit shops, the first two with awnings; kind 3 is a house door beside a closed shutter. */
static uint32_t make_shop(struct builtin *b, const struct facade_materials *f, int style, int kind) {
    const float half = 1.42f, low = kind == 3 ? 0.0f : 0.45f, high = 3.2f, depth = kind == 3 ? 0.3f : 0.9f, w = CITY_BAY / 2;
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, f->wall[style == 3 ? 3 : 2]);
    add_wall_with_opening(&m, CITY_GROUND, half, low, high, depth);
    mesh_material(&m, f->trim[style]);
    add_block(&m, -w, 0, -w + 0.26f, 3.2f, 0.09f);
    add_block(&m, w - 0.26f, 0, w, 3.2f, 0.09f);
    add_block(&m, -w, CITY_GROUND - 0.22f, w, CITY_GROUND, 0.22f);
    if (kind == 3) {
        mesh_material(&m, f->shutter);
        for (int i = 0; i < 16; i++)
            mesh_box(&m, vec3_make(-0.1f, 0.1f + 0.19f * (float)i, -0.3f), vec3_make(half, 0.26f + 0.19f * (float)i, -0.24f),
                     FACE_FRONT | FACE_TOP | FACE_BOTTOM);
        mesh_material(&m, f->wood);
        mesh_quad(&m, vec3_make(-half, 0, -0.28f), vec3_make(half - 0.1f, 0, 0), vec3_make(0, 2.4f, 0));
        for (int i = 0; i < 4; i++)
            mesh_bevel_box(&m, vec3_make(-1.30f + 0.6f * (float)(i & 1), 0.25f + 1.05f * (float)(i >> 1), -0.29f),
                           vec3_make(-0.82f + 0.6f * (float)(i & 1), 1.15f + 1.05f * (float)(i >> 1), -0.24f), 0.02f);
        mesh_material(&m, f->dark);
        mesh_quad(&m, vec3_make(-half, 2.4f, -0.28f), vec3_make(half - 0.1f, 0, 0), vec3_make(0, 0.8f, 0));
        mesh_quad(&m, vec3_make(-0.1f, 0, -0.3f), vec3_make(half + 0.1f, 0, 0), vec3_make(0, high, 0));
        mesh_material(&m, f->door_lamp);
        mesh_sphere(&m, vec3_make(-0.78f, 2.85f, 0.16f), 0.09f, 6);
        return mesh_end(&m, "house door");
    }
    mesh_material(&m, f->display);
    add_room(&m, (kind * 5 + style * 3) % 16, vec3_make(-half, low, -depth), 2 * half, high - low);
    mesh_material(&m, f->frame); /* what is on show */
    for (int i = 0; i < 4; i++) {
        float x = -1.05f + 0.7f * (float)i, tall = 0.35f + 0.25f * (float)((i * 7 + kind * 3 + style) % 4);
        mesh_box(&m, vec3_make(x - 0.2f, low, -0.7f), vec3_make(x + 0.2f, low + 0.3f, -0.3f), FACE_NO_BOTTOM);
        if ((i + kind) % 2)
            mesh_cylinder(&m, vec3_make(x, low + 0.3f, -0.5f), 0.13f, 0.07f, tall, 7);
        else
            mesh_sphere(&m, vec3_make(x, low + 0.3f + 0.17f, -0.5f), 0.17f, 8);
    }
    mesh_box(&m, vec3_make(-0.03f, low, -0.06f), vec3_make(0.03f, high, 0), FACE_LEFT | FACE_RIGHT | FACE_FRONT | FACE_BACK);
    mesh_material(&m, f->fascia[(kind + style) % CITY_SHOPS]);
    mesh_bevel_box(&m, vec3_make(-w + 0.3f, 3.28f, -0.02f), vec3_make(w - 0.3f, 3.86f, 0.12f), 0.03f);
    mesh_material(&m, f->letters[(kind + 2 * style) % CITY_SHOPS]);
    add_letters(&m, kind * 4 + style);
    if (kind < 2) {
        mesh_material(&m, f->awning[(kind + style) % 2]);
        mesh_quad(&m, vec3_make(-1.5f, 2.75f, 1.15f), vec3_make(3, 0, 0), vec3_make(0, 0.5f, -1.05f));
        mesh_quad(&m, vec3_make(-1.5f, 2.55f, 1.15f), vec3_make(3, 0, 0), vec3_make(0, 0.2f, 0));
    }
    mesh_material(&m, f->glass);
    mesh_quad(&m, vec3_make(-half, low, -0.05f), vec3_make(2 * half, 0, 0), vec3_make(0, high - low, 0));
    return mesh_end(&m, "shop");
}

static uint32_t make_cornice(struct builtin *b, const struct facade_materials *f, int style) {
    const float w = CITY_BAY / 2;
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, f->trim[style]);
    if (style == 3) {
        mesh_box(&m, vec3_make(-w, 0, -0.3f), vec3_make(w, 0.9f, 0.1f), FACE_FRONT | FACE_TOP | FACE_BACK | FACE_BOTTOM);
    } else {
        const vec2 p[] = {{-0.35f, 0.95f}, {0.02f, 0.95f}, {0.02f, 0.55f}, {0.52f, 0.55f}, {0.52f, 0.42f}, {0.44f, 0.40f},
                          {0.34f, 0.28f},  {0.22f, 0.22f}, {0.18f, 0.06f}, {0.06f, 0.0f},  {0, -0.1f}};
        m.transform = builtin_at(0, 0, 0, -PI / 2, 1); /* the profile's x becomes +Z */
        mesh_strip(&m, p, COUNT_OF(p), -w, w);
        m.transform = mat4_identity();
        for (int i = 0; i < 5; i++) { /* brackets */
            float x = -w + 0.35f + 0.7f * (float)i;
            mesh_box(&m, vec3_make(x - 0.09f, 0.08f, 0), vec3_make(x + 0.09f, 0.42f, 0.36f),
                     FACE_ALL & ~(unsigned)(FACE_BACK | FACE_TOP));
        }
    }
    return mesh_end(&m, "cornice");
}

static uint32_t make_balcony(struct builtin *b, const struct facade_materials *f) {
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, f->trim[0]);
    mesh_box(&m, vec3_make(-1.2f, 0.28f, 0), vec3_make(1.2f, 0.42f, 0.85f), FACE_ALL & ~(unsigned)FACE_BACK);
    mesh_material(&m, f->iron);
    for (int i = 0; i < 12; i++) {
        float x = -1.15f + 2.3f * (float)i / 11;
        mesh_box(&m, vec3_make(x - 0.01f, 0.42f, 0.79f), vec3_make(x + 0.01f, 1.3f, 0.81f),
                 FACE_SIDES & ~(unsigned)FACE_BACK);
    }
    for (int side = -1; side <= 1; side += 2)
        for (int i = 0; i < 6; i++)
            mesh_box(&m, vec3_make(1.15f * (float)side - 0.01f, 0.42f, 0.1f + 0.12f * (float)i),
                     vec3_make(1.15f * (float)side + 0.01f, 1.3f, 0.12f + 0.12f * (float)i), FACE_SIDES);
    mesh_box(&m, vec3_make(-1.18f, 1.3f, 0.77f), vec3_make(1.18f, 1.34f, 0.83f), FACE_ALL);
    mesh_box(&m, vec3_make(-1.18f, 1.3f, 0), vec3_make(-1.12f, 1.34f, 0.77f), FACE_ALL);
    mesh_box(&m, vec3_make(1.12f, 1.3f, 0), vec3_make(1.18f, 1.34f, 0.77f), FACE_ALL);
    return mesh_end(&m, "balcony");
}

void city_make_facades(struct builtin *b, struct city_meshes *meshes) {
    struct facade_materials f;
    make_materials(b, &f);
    for (int style = 0; style < CITY_STYLES; style++) {
        for (int kind = 0; kind < CITY_WINDOWS; kind++) meshes->windows[style][kind] = make_window(b, &f, style, kind);
        for (int kind = 0; kind < CITY_SHOPS; kind++) meshes->shops[style][kind] = make_shop(b, &f, style, kind);
        meshes->cornices[style] = make_cornice(b, &f, style);
    }
    meshes->balcony = make_balcony(b, &f);
    const float w = CITY_BAY / 2;
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, f.roof); /* from the facade's edge inwards */
    mesh_quad(&m, vec3_make(-w, 0, 0), vec3_make(CITY_BAY, 0, 0), vec3_make(0, 0, -CITY_DEPTH));
    meshes->roof = mesh_end(&m, "roof");
    mesh_material(&m, f.plaster);
    mesh_quad(&m, vec3_make(w, 0, -CITY_DEPTH), vec3_make(-CITY_BAY, 0, 0), vec3_make(0, CITY_FLOOR, 0));
    meshes->back = mesh_end(&m, "courtyard wall");
    mesh_material(&m, f.plaster);
    mesh_quad(&m, vec3_make(0, 0, 0), vec3_make(0, 0, -CITY_DEPTH), vec3_make(0, CITY_FLOOR + 0.8f, 0));
    meshes->party = mesh_end(&m, "party wall");
}
