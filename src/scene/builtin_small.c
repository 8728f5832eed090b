/* SPDX-License-Identifier: MIT */
/**
 * The material grid and the small worst cases for light lists. Each has one camera, made for 16:9 pictures; the cases that
 * aim at pixels mean 1280x720 and tiles of 16x16. A fixed exposure of EV100 5 suits all of them.
 */
#include "scene/builtin_mesh.h"

/** Field of view of all cameras here, and the size of a pixel at distance 1 in a picture 720 rows high. */
#define FOV 0.9f
#define PIXEL (2 * 0.48305507f / 720)

static vec3 random_hue(struct builtin *b, float saturation) { return builtin_hue(random_float(&b->random), saturation); }

static vec3 random_in_box(struct builtin *b, vec3 low, vec3 high) {
    float x = random_range(&b->random, low.x, high.x), y = random_range(&b->random, low.y, high.y);
    return vec3_make(x, y, random_range(&b->random, low.z, high.z));
}

/** One horizontal quad, placed. */
static void add_floor(struct builtin *b, uint32_t material, vec3 low, vec3 high) {
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, material);
    mesh_quad(&m, vec3_make(low.x, low.y, high.z), vec3_make(high.x - low.x, 0, 0), vec3_make(0, 0, low.z - high.z));
    builtin_place(b, mesh_end(&m, "floor"), mat4_identity());
}

/** One quad that faces +Z, placed. */
static void add_wall(struct builtin *b, uint32_t material, vec3 low, float width, float height) {
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, material);
    mesh_quad(&m, low, vec3_make(width, 0, 0), vec3_make(0, height, 0));
    builtin_place(b, mesh_end(&m, "wall"), mat4_identity());
}

/** The point at `depth` that shows at a pixel position of a 1280x720 picture, camera at the origin looking down -Z. */
static vec3 at_pixel(float x, float y, float depth) {
    return vec3_make((x - 640) * PIXEL * depth, (360 - y) * PIXEL * depth, -depth);
}

void builtin_make_spheres(struct builtin *b, const uint64_t *values) {
    enum { COLUMNS = 9, ROWS = 5 };
    b->random.state = values[1];
    for (int row = 0; row < ROWS; row++)
        for (int column = 0; column < COLUMNS; column++) {
            float metallic = (float)row / (ROWS - 1), roughness = fmaxf(0.04f, (float)column / (COLUMNS - 1));
            char *name = arena_format(&b->scene->arena, "metallic %.2f roughness %.2f", (double)metallic, (double)roughness);
            struct mesh_builder m;
            mesh_begin(&m, b);
            mesh_material(&m, builtin_plain(b, name, vec3_make(0.95f, 0.64f, 0.36f), metallic, roughness));
            mesh_sphere(&m, vec3_make(0, 0, 0), 0.45f, (uint32_t)values[2]);
            builtin_place(b, mesh_end(&m, name), builtin_at((float)column - 4, 0.5f + (float)row, 0, 0, 1));
        }
    add_floor(b, builtin_material(b, "floor", TEXTURE_TILES, vec3_make(1, 1, 1)), vec3_make(-12, 0, -4),
              vec3_make(12, 0, 8));
    add_wall(b, builtin_material(b, "back", TEXTURE_PLASTER, vec3_make(0.25f, 0.27f, 0.3f)), vec3_make(-12, 0, -4), 24, 9);
    for (uint64_t i = 0; i < values[0]; i++) {
        vec3 p = random_in_box(b, vec3_make(-6, 0.3f, 0.8f), vec3_make(6, 6, 5));
        builtin_point(b, p, random_hue(b, 0.35f), 700.0f / (float)(values[0] + 20), 9);
    }
    b->scene->ambient_sky = vec3_make(1.2f, 1.3f, 1.6f);
    b->scene->ambient_ground = vec3_make(0.5f, 0.45f, 0.4f);
    b->scene->background = vec3_make(0.3f, 0.35f, 0.45f);
    builtin_camera(b, "front", vec3_make(0, 3.2f, 8.2f), vec3_make(0, 2.45f, 0), 0.75f);
}

void builtin_make_pole(struct builtin *b, const uint64_t *values) {
    b->random.state = values[1];
    add_floor(b, builtin_material(b, "floor", TEXTURE_CONCRETE, vec3_make(1, 1, 1)), vec3_make(-60, 0, -60),
              vec3_make(60, 0, 5));
    add_wall(b, builtin_material(b, "far wall", TEXTURE_BRICK, vec3_make(1, 1, 1)), vec3_make(-60, 0, -60), 120, 40);
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, builtin_material(b, "pole", TEXTURE_METAL, vec3_make(0.8f, 0.8f, 0.8f)));
    mesh_cylinder(&m, vec3_make(0, 0, 0), 0.06f, 0.05f, 6, 24);
    builtin_place(b, mesh_end(&m, "pole"), builtin_at(0.2f, 0, -4, 0, 1));
    /* A third of the lights by the pole, a third by the wall, and a third in the empty depth between, where a tile's depth
       range holds them though they light nothing there. */
    for (uint64_t i = 0; i < values[0]; i++) {
        vec3 low = {-1, 0.2f, -5}, high = {1.4f, 3.5f, -3};
        float range = 1.2f, intensity = 6;
        if (i % 3 == 1) {
            low = vec3_make(-50, 0.5f, -59);
            high = vec3_make(50, 26, -56);
            range = 7;
            intensity = 400;
        } else if (i % 3 == 2) {
            low = vec3_make(-6, 4, -50);
            high = vec3_make(6, 9, -10);
            range = 3.5f;
            intensity = 90;
        }
        vec3 p = random_in_box(b, low, high);
        builtin_point(b, p, random_hue(b, 0.6f), intensity, range);
    }
    b->scene->ambient_sky = b->scene->ambient_ground = vec3_make(0.3f, 0.32f, 0.4f);
    b->scene->background = vec3_make(0.1f, 0.12f, 0.2f);
    builtin_camera(b, "front", vec3_make(0, 1.7f, 0), vec3_make(0, 2.2f, -10), FOV);
}

void builtin_make_lamps(struct builtin *b, const uint64_t *values) {
    b->random.state = values[1];
    uint64_t count = values[0];
    float spacing = fminf(4, 2000.0f / (float)(count + 1)), length = fmaxf(200, spacing * (float)count + 20);
    add_floor(b, builtin_material(b, "road", TEXTURE_ASPHALT, vec3_make(1, 1, 1)), vec3_make(-30, 0, -length),
              vec3_make(30, 0, 10));
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, builtin_globe(b, "lamp", vec3_make(300, 210, 120)));
    mesh_sphere(&m, vec3_make(0, 0, 0), 0.08f, 12);
    mesh_material(&m, builtin_material(b, "mast", TEXTURE_METAL, vec3_make(0.3f, 0.3f, 0.3f)));
    mesh_cylinder(&m, vec3_make(0, -2.2f, 0), 0.03f, 0.02f, 2.1f, 8);
    uint32_t lamp = mesh_end(&m, "lamp");
    /* All on the view axis: in a picture they fall on one tile. */
    for (uint64_t i = 0; i < count; i++) {
        float z = -3 - spacing * (float)i;
        builtin_place(b, lamp, builtin_at(0, 2.2f, z, 0, 1));
        builtin_point(b, vec3_make(0, 2.2f, z), LIGHT_WARM, 160, 9);
    }
    b->scene->ambient_sky = vec3_make(0.15f, 0.2f, 0.35f);
    b->scene->background = vec3_make(0.02f, 0.03f, 0.06f);
    builtin_camera(b, "axis", vec3_make(0, 2.2f, 2), vec3_make(0, 2.2f, -10), FOV);
}

void builtin_make_grass(struct builtin *b, const uint64_t *values) {
    enum { TUFTS = 24000 };
    b->random.state = values[1];
    add_floor(b, builtin_material(b, "ground", TEXTURE_GROUND, vec3_make(1, 1, 1)), vec3_make(-30, 0, -50),
              vec3_make(30, 0, 6));
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, builtin_material(b, "grass", TEXTURE_GRASS, vec3_make(1, 1, 1)));
    for (int i = 0; i < 3; i++) {
        float angle = PI * (float)i / 3 + 0.3f, c = cosf(angle), s = sinf(angle);
        mesh_quad_uv(&m, vec3_make(-0.35f * c, 0, -0.35f * s), vec3_make(0.7f * c, 0, 0.7f * s),
                     vec3_make(0.05f, 0.55f, 0.04f), vec2_make(0.37f * (float)i, 1), vec2_make(0.37f * (float)i + 0.8f, 0));
    }
    uint32_t tuft = mesh_end(&m, "grass tuft");
    for (int i = 0; i < TUFTS; i++) {
        float x = random_range(&b->random, -22, 22), z = random_range(&b->random, -44, 3),
              yaw = random_range(&b->random, 0, 6.28f);
        builtin_place(b, tuft, builtin_at(x, 0, z, yaw, random_range(&b->random, 0.6f, 1.4f)));
    }
    for (uint64_t i = 0; i < values[0]; i++) { /* fireflies and lanterns */
        vec3 p = random_in_box(b, vec3_make(-20, 0.3f, -42), vec3_make(20, 1.8f, 2));
        builtin_point(b, p, vec3_lerp(LIGHT_WARM, random_hue(b, 0.8f), 0.4f), 30, random_range(&b->random, 1.5f, 4));
    }
    b->scene->ambient_sky = vec3_make(0.5f, 0.6f, 0.9f);
    b->scene->background = vec3_make(0.06f, 0.08f, 0.16f);
    builtin_camera(b, "field", vec3_make(0, 1.4f, 4), vec3_make(0, 0.7f, -8), FOV);
}

void builtin_make_onetile(struct builtin *b, const uint64_t *values) {
    const float tile_x = 648, tile_y = 360, wall = 20; /* the middle of tile (40, 22) */
    b->random.state = values[1];
    add_wall(b, builtin_material(b, "wall", TEXTURE_PLASTER, vec3_make(1, 1, 1)), vec3_make(-22, -12, -wall), 44, 24);
    for (uint64_t i = 0; i < values[0]; i++) {
        float depth = i & 1 ? wall - 0.03f : random_range(&b->random, 2, wall - 1), half = 8 * PIXEL * depth;
        float range = random_range(&b->random, 0.3f, 0.5f) * half;
        float dx = random_range(&b->random, -3.5f, 3.5f), dy = random_range(&b->random, -3.5f, 3.5f);
        builtin_point(b, at_pixel(tile_x + dx, tile_y + dy, depth), random_hue(b, 0.6f), 0.6f * range * range, range);
    }
    b->scene->ambient_sky = b->scene->ambient_ground = vec3_make(1, 1, 1);
    builtin_camera(b, "front", vec3_make(0, 0, 0), vec3_make(0, 0, -1), FOV);
}

void builtin_make_nearplane(struct builtin *b, const uint64_t *values) {
    const float near_distance = 0.05f;
    b->random.state = values[1];
    add_floor(b, builtin_material(b, "floor", TEXTURE_TILES, vec3_make(1, 1, 1)), vec3_make(-8, -1.2f, -9),
              vec3_make(8, 0, 2));
    add_wall(b, builtin_material(b, "wall", TEXTURE_STONE, vec3_make(1, 1, 1)), vec3_make(-9, -1.2f, -9), 18, 8);
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, builtin_material(b, "ball", TEXTURE_MARBLE, vec3_make(1, 1, 1)));
    mesh_sphere(&m, vec3_make(0, 0, 0), 0.6f, 48);
    uint32_t ball = mesh_end(&m, "ball");
    for (int i = -2; i <= 2; i++)
        builtin_place(b, ball, builtin_at(1.5f * (float)i, -0.6f, -4 + 0.7f * (float)(i & 1), 0, 1));
    for (uint64_t i = 0; i < values[0]; i++) {
        vec3 color = random_hue(b, 0.5f), p;
        float range = random_range(&b->random, 0.5f, 3), share = 60.0f / sqrtf((float)values[0] + 16);
        float tile_x = 16 * floorf(random_range(&b->random, 0, 81)), tile_y = 16 * floorf(random_range(&b->random, 0, 46));
        float depth = random_range(&b->random, 1, 8.5f);
        switch (i % 4) {
        case 0:
            p = at_pixel(tile_x, tile_y, near_distance);
            break; /* the centre on the near plane */
        case 1:
            p = at_pixel(tile_x, tile_y, depth);
            break; /* on a corner of four tiles */
        case 2:
            p = vec3_make(0, 0, -near_distance + range);
            break; /* behind it, touching it in one point */
        default:
            p = vec3_make(0, random_range(&b->random, -0.2f, 0.2f), 0); /* around the eye */
        }
        builtin_point(b, p, color, share * range, range);
    }
    b->scene->ambient_sky = b->scene->ambient_ground = vec3_make(0.4f, 0.4f, 0.45f);
    b->scene->background = vec3_make(0.1f, 0.12f, 0.2f);
    builtin_camera(b, "front", vec3_make(0, 0, 0), vec3_make(0, 0, -1), FOV);
}

void builtin_make_sky(struct builtin *b, const uint64_t *values) {
    b->random.state = values[1];
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, builtin_material(b, "balloon", TEXTURE_FABRIC, vec3_make(0.8f, 0.2f, 0.12f)));
    mesh_sphere(&m, vec3_make(0, 0, 0), 1, 32);
    mesh_material(&m, builtin_material(b, "basket", TEXTURE_WOOD, vec3_make(1, 1, 1)));
    mesh_bevel_box(&m, vec3_make(-0.22f, -1.75f, -0.22f), vec3_make(0.22f, -1.4f, 0.22f), 0.03f);
    uint32_t balloon = mesh_end(&m, "balloon");
    for (int i = 0; i < 7; i++) {
        vec3 p = random_in_box(b, vec3_make(-14, -5, -40), vec3_make(14, 9, -12));
        builtin_place(b, balloon, builtin_at(p.x, p.y, p.z, (float)i, random_range(&b->random, 0.7f, 1.6f)));
    }
    for (uint64_t i = 0; i < values[0]; i++) { /* nearly all of them shine on nothing */
        vec3 p = random_in_box(b, vec3_make(-18, -9, -45), vec3_make(18, 11, -8));
        builtin_point(b, p, random_hue(b, 0.5f), 150, random_range(&b->random, 4, 9));
    }
    b->scene->ambient_sky = vec3_make(6, 8, 12);
    b->scene->ambient_ground = vec3_make(3, 3, 3);
    b->scene->background = vec3_make(3, 6, 14);
    builtin_camera(b, "front", vec3_make(0, 0, 0), vec3_make(0, 0, -1), FOV);
}

/* Panes and balls of glass that reach into one another: no order of objects is right for them. */
static void add_crossing_glass(struct builtin *b) {
    static const vec3 tints[4] = {{0.95f, 0.25f, 0.2f}, {0.2f, 0.45f, 0.95f}, {0.3f, 0.9f, 0.4f}, {0.95f, 0.85f, 0.3f}};
    for (int i = 0; i < 4; i++) {
        struct mesh_builder m;
        bool ball = i >= 2;
        mesh_begin(&m, b);
        mesh_material(&m, builtin_glass(b, arena_format(&b->scene->arena, "crossing %d", i), tints[i], ball ? 0.35f : 0.5f));
        if (ball)
            mesh_sphere(&m, vec3_make(0, 0, 0), 0.6f, 24);
        else
            mesh_box(&m, vec3_make(-1.1f, 0.1f, -0.01f), vec3_make(1.1f, 2.6f, 0.01f), FACE_FRONT);
        mat4 place =
            ball ? builtin_at(3 + 0.8f * (float)(i - 2), 0.9f, -5.4f, 0, 1) : builtin_at(3.4f, 0, -6, i ? -0.7f : 0.6f, 1);
        builtin_place(b, mesh_end(&m, "crossing"), place);
    }
}

void builtin_make_glass(struct builtin *b, const uint64_t *values) {
    enum { PANES = 8 };
    b->random.state = values[1];
    add_floor(b, builtin_material(b, "floor", TEXTURE_WOOD, vec3_make(1, 1, 1)), vec3_make(-9, 0, -12), vec3_make(9, 0, 3));
    add_wall(b, builtin_material(b, "wall", TEXTURE_BRICK, vec3_make(1, 1, 1)), vec3_make(-12, 0, -12), 24, 9);
    uint32_t frame = builtin_material(b, "frame", TEXTURE_METAL, vec3_make(0.5f, 0.45f, 0.4f));
    for (int i = 0; i < PANES; i++) {
        vec3 tint = vec3_lerp(vec3_make(0.8f, 0.9f, 1), builtin_hue((float)i / PANES, 0.9f), 0.6f);
        struct mesh_builder m;
        mesh_begin(&m, b);
        mesh_material(&m, builtin_glass(b, arena_format(&b->scene->arena, "pane %d", i), tint, 0.16f));
        mesh_box(&m, vec3_make(-1.5f, 0.15f, -0.01f), vec3_make(1.5f, 2.8f, 0.01f), FACE_FRONT);
        mesh_material(&m, frame);
        mesh_bevel_box(&m, vec3_make(-1.6f, 0.02f, -0.05f), vec3_make(1.6f, 0.15f, 0.05f), 0.01f);
        mesh_bevel_box(&m, vec3_make(-1.6f, 2.8f, -0.05f), vec3_make(1.6f, 2.9f, 0.05f), 0.01f);
        builtin_place(b, mesh_end(&m, "pane"), builtin_at(0.35f * (float)i - 1.2f, 0, -2.5f - (float)i, 0, 1));
    }
    if (values[2]) add_crossing_glass(b);
    for (uint64_t i = 0; i < values[0]; i++) { /* half before the wall, a quarter between the panes, a quarter before them */
        vec3 low = {-7, 0.3f, -11.8f}, high = {7, 5, -10};
        if (i % 4 == 2) low = vec3_make(-3, 0.3f, -9.5f), high = vec3_make(3, 2.6f, -2.6f);
        if (i % 4 == 3) low = vec3_make(-4, 0.3f, -2.4f), high = vec3_make(4, 3, 0);
        vec3 p = random_in_box(b, low, high);
        builtin_point(b, p, random_hue(b, 0.5f), 12, random_range(&b->random, 1, 2.5f));
    }
    b->scene->ambient_sky = b->scene->ambient_ground = vec3_make(0.5f, 0.5f, 0.55f);
    b->scene->background = vec3_make(0.1f, 0.12f, 0.2f);
    builtin_camera(b, "front", vec3_make(0, 1.5f, 0.5f), vec3_make(0, 1.5f, -10), FOV);
}
