/* SPDX-License-Identifier: MIT */
/**
 * A gallery: a corridor under skylights, four rooms on each side behind wide doorways, sculptures, pictures and benches. Lit by few but
 * large lights of all five shapes that overlap, most of them narrow and slanted: after the interior of M. Mikkelsen, "Fine Pruned Tiled
 * Light Lists" (GPU Pro 7), where 40 to 120 lights are in view and their boxes cover nearly everything while a pixel is lit by few.
 * The first 40 lights are of all shapes; from 96 on small points float in the air. Along -Z from the entrance; EV100 4 suits it.
 * `overlap` makes the lights reach that many times as far, and as much narrower: nothing shadows them, so they pass walls and light
 * rooms behind, and their boxes cover more of the screen while they light about as much of it.
 */
#include "scene/builtin_mesh.h"

enum { BAYS = 4 };

/* Metres. */
#define BAY 9.0f /* length of a room */
#define LENGTH (BAY * BAYS)
#define HALF_WIDTH 3.2f /* of the corridor */
#define WALL 0.3f       /* thickness */
#define DEPTH 8.0f      /* of a room */
#define HEIGHT 4.6f
#define DOOR_WIDTH 4.0f
#define DOOR_HEIGHT 3.3f
#define OUTER (HALF_WIDTH + WALL + DEPTH)
#define ROOM_MIDDLE (HALF_WIDTH + WALL + DEPTH / 2)

struct interior {
    uint32_t floor, boards, plaster, trim, ceiling, wood, stone, marble, brass, iron, frame, sky, tube, cloth;
    uint64_t lights_left;
};

static bool take_light(struct interior *s) {
    if (!s->lights_left) return false;
    s->lights_left--;
    return true;
}

/* ---- rooms ---- */

/** The wall between corridor and room of one bay, at x = 0, its doorway in the middle; from z = 0 to -BAY. */
static uint32_t make_corridor_wall(struct builtin *b, const struct interior *s) {
    const float side = (BAY - DOOR_WIDTH) / 2, half = WALL / 2;
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, s->plaster);
    mesh_box(&m, vec3_make(-half, 0, -side), vec3_make(half, HEIGHT, 0), FACE_SIDES);
    mesh_box(&m, vec3_make(-half, 0, -BAY), vec3_make(half, HEIGHT, -BAY + side), FACE_SIDES);
    mesh_box(&m, vec3_make(-half, DOOR_HEIGHT, -BAY + side), vec3_make(half, HEIGHT, -side), FACE_ALL);
    mesh_material(&m, s->trim); /* wainscot, door case and cornice stand a little before the plaster */
    for (int end = 0; end < 2; end++) {
        float z = end ? -BAY : -side, to = end ? -BAY + side : 0;
        mesh_bevel_box(&m, vec3_make(-half - 0.03f, 0, z), vec3_make(half + 0.03f, 0.95f, to), 0.015f);
        mesh_bevel_box(&m, vec3_make(-half - 0.06f, 0.95f, z - 0.01f), vec3_make(half + 0.06f, 1.03f, to + 0.01f), 0.02f);
        mesh_bevel_box(&m, vec3_make(-half - 0.05f, 0, z), vec3_make(half + 0.05f, 0.14f, to), 0.015f);
    }
    for (int end = 0; end < 2; end++) {
        float z = end ? -BAY + side : -side, sign = end ? -1.0f : 1.0f;
        mesh_bevel_box(&m, vec3_make(-half - 0.08f, 0, fminf(z, z + sign * 0.22f)),
                       vec3_make(half + 0.08f, DOOR_HEIGHT + 0.1f, fmaxf(z, z + sign * 0.22f)), 0.02f);
    }
    mesh_bevel_box(&m, vec3_make(-half - 0.1f, DOOR_HEIGHT, -BAY + side - 0.3f),
                   vec3_make(half + 0.1f, DOOR_HEIGHT + 0.24f, -side + 0.3f), 0.03f);
    mesh_bevel_box(&m, vec3_make(-half - 0.14f, HEIGHT - 0.26f, -BAY), vec3_make(half + 0.14f, HEIGHT, 0), 0.07f);
    return mesh_end(&m, "corridor wall");
}

/** Floor, ceiling with beams and a skylight over one bay of the corridor; x from -HALF_WIDTH, z from 0 to -BAY. */
static uint32_t make_corridor(struct builtin *b, const struct interior *s) {
    const float w = HALF_WIDTH;
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, s->floor);
    mesh_quad(&m, vec3_make(-w - WALL, 0, 0), vec3_make(2 * (w + WALL), 0, 0), vec3_make(0, 0, -BAY));
    mesh_material(&m, s->ceiling);
    mesh_quad(&m, vec3_make(-w, HEIGHT, -BAY), vec3_make(2 * w, 0, 0), vec3_make(0, 0, BAY));
    mesh_material(&m, s->wood);
    for (int i = 0; i < 3; i++) {
        float z = -BAY * ((float)i + 0.5f) / 3;
        mesh_bevel_box(&m, vec3_make(-w, HEIGHT - 0.34f, z - 0.13f), vec3_make(w, HEIGHT, z + 0.13f), 0.02f);
    }
    for (int i = 0; i < 2; i++) { /* skylights between the beams */
        float z = -BAY * ((float)i + 1) / 3;
        mesh_material(&m, s->sky);
        mesh_quad(&m, vec3_make(-1.5f, HEIGHT - 0.01f, z - 0.9f), vec3_make(3, 0, 0), vec3_make(0, 0, 1.8f));
        mesh_material(&m, s->iron);
        for (int k = 0; k <= 4; k++) {
            float x = -1.5f + 0.75f * (float)k;
            mesh_box(&m, vec3_make(x - 0.03f, HEIGHT - 0.06f, z - 0.9f), vec3_make(x + 0.03f, HEIGHT, z + 0.9f), FACE_ALL);
        }
    }
    return mesh_end(&m, "corridor");
}

/** One room right of the corridor: x from 0 to DEPTH, z from 0 to -BAY; windows in the outer wall. */
static uint32_t make_room(struct builtin *b, const struct interior *s) {
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, s->boards);
    mesh_quad(&m, vec3_make(0, 0, 0), vec3_make(DEPTH, 0, 0), vec3_make(0, 0, -BAY));
    mesh_material(&m, s->ceiling);
    mesh_quad(&m, vec3_make(0, HEIGHT, -BAY), vec3_make(DEPTH, 0, 0), vec3_make(0, 0, BAY));
    mesh_material(&m, s->plaster);
    mesh_quad(&m, vec3_make(DEPTH, 0, -BAY), vec3_make(0, 0, BAY), vec3_make(0, HEIGHT, 0));
    mesh_box(&m, vec3_make(0, 0, -BAY - 0.1f), vec3_make(DEPTH, HEIGHT, -BAY + 0.1f), FACE_BACK | FACE_FRONT);
    mesh_material(&m, s->trim);
    for (int end = 0; end < 2; end++) {
        float z = end ? -BAY + 0.1f : -0.1f, to = end ? z + 0.04f : z - 0.04f;
        mesh_bevel_box(&m, vec3_make(0, 0, fminf(z, to)), vec3_make(DEPTH, 0.16f, fmaxf(z, to)), 0.012f);
        mesh_bevel_box(&m, vec3_make(0, HEIGHT - 0.2f, fminf(z, to) - 0.04f), vec3_make(DEPTH, HEIGHT, fmaxf(z, to) + 0.04f),
                       0.03f);
    }
    mesh_bevel_box(&m, vec3_make(DEPTH - 0.05f, 0, -BAY), vec3_make(DEPTH, 0.16f, 0), 0.012f);
    for (int i = 0; i < 3; i++) {
        float z = -BAY * ((float)i + 0.5f) / 3, x = DEPTH - 0.02f;
        mesh_material(&m, s->sky);
        mesh_quad(&m, vec3_make(x, 2.3f, z - 0.7f), vec3_make(0, 0, 1.4f), vec3_make(0, 1.8f, 0));
        mesh_material(&m, s->trim);
        for (int k = -1; k <= 1; k++)
            mesh_bevel_box(&m, vec3_make(x - 0.06f, 2.2f, z + 0.7f * (float)k - 0.05f),
                           vec3_make(x + 0.02f, 4.2f, z + 0.7f * (float)k + 0.05f), 0.015f);
        for (int k = 0; k < 3; k++)
            mesh_bevel_box(&m, vec3_make(x - 0.08f, 2.25f + 0.9f * (float)k, z - 0.8f),
                           vec3_make(x + 0.02f, 2.35f + 0.9f * (float)k, z + 0.8f), 0.015f);
        mesh_material(&m, s->wood); /* beams */
        mesh_bevel_box(&m, vec3_make(0, HEIGHT - 0.28f, z - 0.11f), vec3_make(DEPTH, HEIGHT, z + 0.11f), 0.02f);
    }
    return mesh_end(&m, "room");
}

/* ---- what is shown ---- */

static uint32_t make_picture(struct builtin *b, const struct interior *s, uint32_t index, float width, float height) {
    struct mesh_builder m;
    mesh_begin(&m, b);
    float w = width / 2, h = height / 2, f = 0.09f;
    const enum builtin_texture textures[] = {TEXTURE_MARBLE, TEXTURE_FABRIC, TEXTURE_BARK, TEXTURE_TILES};
    mesh_material(&m, builtin_material(b, "canvas", textures[index % 4], builtin_hue(0.13f * (float)index, 0.55f)));
    mesh_quad_uv(&m, vec3_make(-w, -h, 0.03f), vec3_make(width, 0, 0), vec3_make(0, height, 0), vec2_make(0, 0.8f * height),
                 vec2_make(0.8f * width, 0));
    mesh_material(&m, s->frame);
    mesh_bevel_box(&m, vec3_make(-w - f, h, 0), vec3_make(w + f, h + f, 0.07f), 0.02f);
    mesh_bevel_box(&m, vec3_make(-w - f, -h - f, 0), vec3_make(w + f, -h, 0.07f), 0.02f);
    mesh_bevel_box(&m, vec3_make(-w - f, -h, 0), vec3_make(-w, h, 0.07f), 0.02f);
    mesh_bevel_box(&m, vec3_make(w, -h, 0), vec3_make(w + f, h, 0.07f), 0.02f);
    return mesh_end(&m, "picture");
}

static void add_pedestal(struct mesh_builder *m, const struct interior *s, float height) {
    mesh_material(m, s->stone);
    mesh_bevel_box(m, vec3_make(-0.42f, 0, -0.42f), vec3_make(0.42f, 0.12f, 0.42f), 0.025f);
    mesh_bevel_box(m, vec3_make(-0.33f, 0.12f, -0.33f), vec3_make(0.33f, height - 0.1f, 0.33f), 0.02f);
    mesh_bevel_box(m, vec3_make(-0.4f, height - 0.1f, -0.4f), vec3_make(0.4f, height, 0.4f), 0.025f);
}

/** Four sculptures on pedestals: a vase, a knot, stacked spheres, a column of turned slabs. */
static uint32_t make_sculpture(struct builtin *b, const struct interior *s, int kind) {
    struct mesh_builder m;
    mesh_begin(&m, b);
    float top = kind == 3 ? 0.5f : 0.9f;
    add_pedestal(&m, s, top);
    mesh_material(&m, kind & 1 ? s->brass : s->marble);
    if (kind == 0) {
        vec2 p[22];
        for (int i = 0; i < 22; i++) {
            float t = (float)i / 21;
            p[i] = vec2_make(0.10f + 0.22f * sinf(PI * fminf(1, t * 1.25f)) * (1 - 0.25f * t) +
                                 0.10f * fmaxf(0, t - 0.85f) / 0.15f,
                             1.05f * t);
        }
        mesh_lathe(&m, vec3_make(0, top, 0), p, COUNT_OF(p), 40);
    } else if (kind == 1) {
        vec3 path[97];
        for (int i = 0; i <= 96; i++) { /* a trefoil */
            float a = 2 * PI * (float)i / 96;
            path[i] = vec3_make(0.17f * (sinf(a) + 2 * sinf(2 * a)), top + 0.62f + 0.17f * (cosf(a) - 2 * cosf(2 * a)),
                                -0.2f * sinf(3 * a));
        }
        mesh_tube(&m, path, COUNT_OF(path), 0.085f, 14);
    } else if (kind == 2) {
        mesh_sphere(&m, vec3_make(0, top + 0.3f, 0), 0.3f, 32);
        mesh_sphere(&m, vec3_make(0.03f, top + 0.78f, 0.02f), 0.2f, 28);
        mesh_sphere(&m, vec3_make(-0.02f, top + 1.1f, 0), 0.13f, 24);
    } else {
        for (int i = 0; i < 14; i++) {
            m.transform = builtin_at(0, top + 0.13f * (float)i, 0, 0.22f * (float)i, 1 - 0.045f * (float)i);
            mesh_bevel_box(&m, vec3_make(-0.34f, 0, -0.2f), vec3_make(0.34f, 0.12f, 0.2f), 0.02f);
        }
        m.transform = mat4_identity();
    }
    return mesh_end(&m, "sculpture");
}

static uint32_t make_bench(struct builtin *b, const struct interior *s) {
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, s->cloth);
    mesh_bevel_box(&m, vec3_make(-0.95f, 0.40f, -0.28f), vec3_make(0.95f, 0.52f, 0.28f), 0.04f);
    mesh_material(&m, s->wood);
    mesh_bevel_box(&m, vec3_make(-1, 0.34f, -0.3f), vec3_make(1, 0.41f, 0.3f), 0.012f);
    for (int i = 0; i < 4; i++) {
        float x = i & 1 ? 0.86f : -0.86f, z = i & 2 ? 0.2f : -0.2f;
        mesh_bevel_box(&m, vec3_make(x - 0.05f, 0, z - 0.05f), vec3_make(x + 0.05f, 0.35f, z + 0.05f), 0.01f);
    }
    return mesh_end(&m, "bench");
}

/* ---- lamps ---- */

/** A tube of 2.4 m in a channel below the ceiling, along Z. */
static uint32_t make_tube(struct builtin *b, const struct interior *s) {
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, s->tube);
    const vec3 path[2] = {{0, 0, -1.2f}, {0, 0, 1.2f}};
    mesh_tube(&m, path, 2, 0.035f, 10);
    mesh_material(&m, s->iron);
    mesh_bevel_box(&m, vec3_make(-0.07f, 0.05f, -1.26f), vec3_make(0.07f, 0.12f, 1.26f), 0.01f);
    for (int i = -1; i <= 1; i += 2) {
        const vec3 wire[2] = {{0, 0.1f, 0.9f * (float)i}, {0, 1.0f, 0.9f * (float)i}};
        mesh_tube(&m, wire, 2, 0.01f, 5);
    }
    return mesh_end(&m, "tube lamp");
}

static uint32_t make_pendant(struct builtin *b, const struct interior *s) {
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, s->tube);
    mesh_sphere(&m, vec3_make(0, 0, 0), 0.16f, 20);
    mesh_material(&m, s->brass);
    mesh_cylinder(&m, vec3_make(0, 0.13f, 0), 0.09f, 0.03f, 0.1f, 16);
    const vec3 cord[2] = {{0, 0.2f, 0}, {0, 1.7f, 0}};
    mesh_tube(&m, cord, 2, 0.012f, 6);
    return mesh_end(&m, "pendant");
}

/** A spot's housing at the origin that looks along -Y. */
static uint32_t make_housing(struct builtin *b, const struct interior *s) {
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, s->iron);
    mesh_cylinder(&m, vec3_make(0, 0.02f, 0), 0.075f, 0.06f, 0.2f, 14);
    mesh_material(&m, s->tube);
    mesh_cylinder(&m, vec3_make(0, 0, 0), 0.055f, 0.055f, 0.02f, 14);
    return mesh_end(&m, "housing");
}

/* ---- lights ---- */

struct lamps {
    uint32_t tube, pendant, housing;
};

static fnl_light_params light_of(fnl_light_kind kind, vec3 position, vec3 direction, vec3 color, float intensity,
                                 float range) {
    fnl_light_params light = fnl_light_params_default();
    light.kind = kind;
    light.position = position;
    light.direction = vec3_normalize(direction);
    light.color[0] = color.x;
    light.color[1] = color.y;
    light.color[2] = color.z;
    light.intensity = intensity;
    light.range = range;
    return light;
}

/** Turns -Y into `direction` and moves the origin. */
static mat4 aim(vec3 position, vec3 direction) {
    vec3 y = vec3_scale(vec3_normalize(direction), -1), x = vec3_perpendicular(y), z = vec3_cross(x, y);
    return (mat4){{x.x, x.y, x.z, 0, y.x, y.y, y.z, 0, z.x, z.y, z.z, 0, position.x, position.y, position.z, 1}};
}

static void add_spot(struct builtin *b, const struct lamps *l, vec3 from, vec3 to, vec3 color, float intensity,
                     float angle) {
    vec3 direction = vec3_sub(to, from);
    builtin_place(b, l->housing, aim(from, direction));
    fnl_light_params light = light_of(FNL_LIGHT_SPOT, from, direction, color, intensity, 18);
    light.outer_cone_angle = angle;
    light.inner_cone_angle = 0.6f * angle;
    builtin_light(b, &light);
}

static void add_wedge(struct builtin *b, const struct lamps *l, vec3 from, vec3 to, vec3 color, float intensity, float range,
                      float across, float high) {
    vec3 direction = vec3_sub(to, from);
    builtin_place(b, l->housing, aim(from, direction));
    fnl_light_params light = light_of(FNL_LIGHT_WEDGE, from, direction, color, intensity, range);
    light.wedge_angles[0] = across;
    light.wedge_angles[1] = high;
    light.inner_fraction = 0.55f;
    light.up = light_up(light.direction, light.up);
    builtin_light(b, &light);
}

/** A shaft of daylight of the given width and height that ends `depth` from its start. */
static void add_shaft(struct builtin *b, vec3 start, vec3 direction, vec3 color, float lux, float width, float height,
                      float depth) {
    direction = vec3_normalize(direction);
    fnl_light_params light =
        light_of(FNL_LIGHT_BOX, vec3_add_scaled(start, direction, depth / 2), direction, color, lux, INFINITY);
    light.box_size = vec3_make(width, height, depth);
    light.inner_fraction = 0.8f;
    light.up = light_up(light.direction, light.up);
    light.range = 0.5f * vec3_length(light.box_size);
    builtin_light(b, &light);
}

static void add_tube(struct builtin *b, const struct lamps *l, vec3 at, vec3 color, float intensity, float range,
                     bool across) {
    builtin_place(b, l->tube, builtin_at(at.x, at.y, at.z, across ? PI / 2 : 0, 1));
    at.y -= 0.25f; /* below the tube, or the channel above it would shine as brightly */
    fnl_light_params light =
        light_of(FNL_LIGHT_CAPSULE, at, across ? vec3_make(1, 0, 0) : vec3_make(0, 0, -1), color, intensity, range);
    light.length = 2.4f;
    light.up = light_up(light.direction, light.up);
    builtin_light(b, &light);
}

/** One light of a role for room `i` (even ones on the left); the roles of a room differ in shape. */
static void add_room_light(struct builtin *b, const struct lamps *l, int role, int i) {
    float s = i & 1 ? 1.0f : -1.0f, z = -BAY * ((float)(i / 2) + 0.5f), turn = i / 2 % 2 ? -1.0f : 1.0f;
    vec3 warm = LIGHT_WARM, tint = builtin_hue(0.11f * (float)i + 0.05f, 0.6f), daylight = s < 0 ? LIGHT_COOL : LIGHT_SODIUM;
    vec3 middle = {s * ROOM_MIDDLE, 0, z};
    switch (role) {
    case 0: /* over the picture on the far end of the room, washing the wall */
        add_wedge(b, l, vec3_make(middle.x, HEIGHT - 0.5f, z + turn * 1.4f), vec3_make(middle.x, 1.9f, z + turn * BAY / 2),
                  warm, 380, 13, 0.62f, 0.36f);
        break;
    case 1: /* on the sculpture, across the room */
        add_spot(b, l, vec3_make(s * (OUTER - 0.9f), HEIGHT - 0.4f, z - turn * 3.6f), vec3_make(middle.x, 1.3f, z),
                 LIGHT_NEUTRAL, 1100, 0.21f);
        break;
    case 2:
        builtin_place(b, l->pendant, builtin_at(middle.x + s * 2.2f, 2.9f, z - turn * 2.6f, 0, 1));
        builtin_point(b, vec3_make(middle.x + s * 2.2f, 2.9f, z - turn * 2.6f), warm, 75, 6);
        break;
    case 3: /* through the windows, down to the boards */
        add_shaft(b, vec3_make(s * (OUTER + 0.4f), 3.4f, z + turn), vec3_make(-s, -0.62f, 0.35f * turn), daylight, 60, 4.2f,
                  1.5f, 9.5f);
        break;
    case 4:
        add_tube(b, l, vec3_make(middle.x, HEIGHT - 1.05f, z + turn * 2.4f), tint, 62, 6.5f, true);
        break;
    case 5: /* on the pictures of the other end */
        add_spot(b, l, vec3_make(middle.x + s * 2, HEIGHT - 0.4f, z + turn * 3),
                 vec3_make(middle.x - s, 1.7f, z - turn * BAY / 2), tint, 900, 0.24f);
        break;
    case 6: /* out of the room through its doorway onto the corridor's floor */
        add_wedge(b, l, vec3_make(s * (OUTER - 1.2f), 3.7f, z), vec3_make(s * 1.2f, 0, z), tint, 700, 15, 0.2f, 0.14f);
        break;
    default: /* on the sculpture from the doorway */
        add_spot(b, l, vec3_make(s * (HALF_WIDTH + 0.9f), HEIGHT - 0.4f, z + turn * 3.4f), vec3_make(middle.x, 1.2f, z),
                 warm, 800, 0.23f);
        break;
    }
}

/** The lights of a bay of the corridor. */
static void add_corridor_light(struct builtin *b, const struct lamps *l, int role, int i) {
    float z = -BAY * ((float)i + 0.5f);
    switch (role) {
    case 0:
        add_tube(b, l, vec3_make(0, HEIGHT - 1.0f, z), LIGHT_NEUTRAL, 58, 6, false);
        break;
    case 1: /* through a skylight */
        add_shaft(b, vec3_make(-0.9f, HEIGHT + 0.2f, z + 1.5f), vec3_make(0.42f, -1, -0.3f), LIGHT_COOL, 55, 2.6f, 1.7f,
                  6.2f);
        break;
    case 2:
    case 3: { /* washing the walls between the doorways */
        float s = role == 2 ? -1.0f : 1.0f;
        add_wedge(b, l, vec3_make(-s * 1.3f, HEIGHT - 0.5f, z + BAY / 2), vec3_make(s * HALF_WIDTH, 1.2f, z + BAY / 2),
                  LIGHT_WARM, 300, 13, 0.5f, 0.3f);
        break;
    }
    default: { /* along the corridor onto what stands beside the doorways */
        float s = role == 4 ? -1.0f : 1.0f;
        add_spot(b, l, vec3_make(-s * 1.6f, HEIGHT - 0.45f, z + 3.4f),
                 vec3_make(s * (HALF_WIDTH - 0.65f), 1.2f, z - BAY / 2 + 0.9f), LIGHT_NEUTRAL, 1300, 0.19f);
        break;
    }
    }
}

/** All of one role, then all of the next, so that few lights are spread over the whole and of all shapes. */
static void place_lights(struct builtin *b, struct interior *s) {
    const struct lamps lamps = {make_tube(b, s), make_pendant(b, s), make_housing(b, s)};
    static const int order[] = {0, 10, 1, 11, 2, 3, 12, 13, 4, 5, 6, 7, 14, 15}; /* from 10 on: of the corridor */
    for (uint32_t k = 0; k < COUNT_OF(order); k++)
        for (int i = 0; i < (order[k] < 10 ? 2 * BAYS : BAYS); i++) {
            if (!take_light(s)) return;
            if (order[k] < 10)
                add_room_light(b, &lamps, order[k], i);
            else
                add_corridor_light(b, &lamps, order[k] - 10, i);
        }
    builtin_fill(b, s->lights_left, vec3_make(-OUTER, 0.3f, -LENGTH), vec3_make(OUTER, 4, 0), 6, 3);
}

/** The same lights farther and narrower, flatter and rather along the building; and as much brighter. Points stay. */
static void stretch_lights(struct builtin *b, float overlap) {
    for (uint32_t i = 0; i < b->scene->lights.count; i++) {
        fnl_light_params *light = &b->scene->lights.data[i].params;
        if (light->kind == FNL_LIGHT_POINT) continue;
        light->intensity *= overlap;
        float depth = light->kind == FNL_LIGHT_BOX ? light->box_size.z : 0;
        vec3 start = vec3_add_scaled(light->position, light->direction, -0.5f * depth);
        if (light->kind == FNL_LIGHT_CAPSULE) {
            light->direction = vec3_normalize(vec3_make(1, 0, -1));
            light->length *= overlap;
            light->range /= overlap;
        } else {
            light->direction =
                vec3_normalize(vec3_make(light->direction.x, light->direction.y / overlap, light->direction.z * overlap));
            light->position = vec3_add_scaled(start, light->direction, 0.5f * depth * overlap);
            light->range *= overlap;
            light->inner_cone_angle /= overlap;
            light->outer_cone_angle /= overlap;
            light->wedge_angles[0] /= overlap;
            light->wedge_angles[1] /= overlap;
        }
        if (light->kind == FNL_LIGHT_BOX) {
            light->box_size = vec3_make(light->box_size.x / overlap, light->box_size.y / overlap, depth * overlap);
            light->range = 0.5f * vec3_length(light->box_size);
        }
        light->up = light_up(light->direction, light->up);
    }
}

/* ---- the whole ---- */

static void place_rooms(struct builtin *b, const struct interior *s) {
    uint32_t wall = make_corridor_wall(b, s), corridor = make_corridor(b, s), room = make_room(b, s);
    for (int i = 0; i < BAYS; i++) {
        float z = -BAY * (float)i;
        builtin_place(b, corridor, builtin_at(0, 0, z, 0, 1));
        for (int side = -1; side <= 1; side += 2) {
            float x = (float)side * (HALF_WIDTH + WALL);
            builtin_place(b, wall, builtin_at((float)side * (HALF_WIDTH + WALL / 2), 0, z, 0, 1));
            builtin_place(b, room, builtin_at(x, 0, side > 0 ? z : z - BAY, side > 0 ? 0 : PI, 1));
        }
    }
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, s->plaster); /* the ends */
    mesh_quad(&m, vec3_make(-OUTER, 0, -LENGTH), vec3_make(2 * OUTER, 0, 0), vec3_make(0, HEIGHT, 0));
    mesh_quad(&m, vec3_make(OUTER, 0, 0), vec3_make(-2 * OUTER, 0, 0), vec3_make(0, HEIGHT, 0));
    builtin_place(b, mesh_end(&m, "ends"), mat4_identity());
}

static void place_exhibits(struct builtin *b, const struct interior *s) {
    uint32_t pictures[8], sculptures[4], bench = make_bench(b, s);
    for (uint32_t i = 0; i < 8; i++) pictures[i] = make_picture(b, s, i, i % 2 ? 1.3f : 2.6f, i % 3 ? 1.7f : 1.3f);
    for (int i = 0; i < 4; i++) sculptures[i] = make_sculpture(b, s, i);
    for (int i = 0; i < 2 * BAYS; i++) {
        float side = i & 1 ? 1.0f : -1.0f, z = -BAY * ((float)(i / 2) + 0.5f), x = side * ROOM_MIDDLE;
        builtin_place(b, sculptures[(i * 3 + i / 2) % 4], builtin_at(x, 0, z, random_range(&b->random, 0, 6), 1));
        builtin_place(b, bench, builtin_at(x + side * 2.4f, 0, z + (i & 2 ? 1.6f : -1.6f), 0.5f * PI, 1));
        for (int end = 0; end < 2; end++) {
            float at = z + (end ? -1.0f : 1.0f) * (BAY / 2 - 0.1f);
            builtin_place(b, pictures[(i * 5 + end) % 8], builtin_at(x + side * 1.1f, 1.8f, at, end ? 0 : PI, 1));
            builtin_place(b, pictures[(i * 3 + end + 2) % 8], builtin_at(x - side * 1.9f, 1.8f, at, end ? 0 : PI, 0.8f));
        }
        /* In the corridor: small pictures beside the doorways, sculptures before the piers. */
        float pier = z + BAY / 2;
        builtin_place(b, sculptures[(i + 1) % 4],
                      builtin_at(side * (HALF_WIDTH - 0.65f), 0, z - BAY / 2 + 0.9f, (float)i, 0.85f));
        builtin_place(b, pictures[(i * 2 + 1) % 8],
                      builtin_at(side * (HALF_WIDTH - 0.01f), 1.95f, pier - 1.2f, -side * PI / 2, 0.62f));
    }
    builtin_place(b, sculptures[1], builtin_at(0, 0, -LENGTH + 1.6f, 0, 1.5f));
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, s->cloth);
    mesh_box(&m, vec3_make(-1, 0, -LENGTH + 3.4f), vec3_make(1, 0.015f, -1.5f), FACE_NO_BOTTOM);
    builtin_place(b, mesh_end(&m, "runner"), mat4_identity());
}

void builtin_make_interior(struct builtin *b, const uint64_t *values) {
    b->random.state = values[1];
    struct interior s = {
        .floor = builtin_material(b, "floor tiles", TEXTURE_TILES, vec3_make(0.9f, 0.88f, 0.85f)),
        .boards = builtin_material(b, "boards", TEXTURE_WOOD, vec3_make(0.8f, 0.72f, 0.62f)),
        .plaster = builtin_material(b, "plaster", TEXTURE_PLASTER, vec3_make(0.62f, 0.60f, 0.56f)),
        .trim = builtin_plain(b, "trim", vec3_make(0.72f, 0.70f, 0.66f), 0, 0.45f),
        .ceiling = builtin_plain(b, "ceiling", vec3_make(0.55f, 0.55f, 0.55f), 0, 0.9f),
        .wood = builtin_material(b, "dark wood", TEXTURE_WOOD, vec3_make(0.4f, 0.3f, 0.22f)),
        .stone = builtin_material(b, "pedestal", TEXTURE_SANDSTONE, vec3_make(0.8f, 0.8f, 0.82f)),
        .marble = builtin_material(b, "marble", TEXTURE_MARBLE, vec3_make(1, 1, 1)),
        .brass = builtin_plain(b, "brass", vec3_make(0.91f, 0.72f, 0.38f), 1, 0.28f),
        .iron = builtin_material(b, "iron", TEXTURE_METAL, vec3_make(0.12f, 0.12f, 0.13f)),
        .frame = builtin_plain(b, "gilt", vec3_make(0.75f, 0.55f, 0.25f), 1, 0.42f),
        .sky = builtin_glow(b, "evening sky", vec3_make(5, 7.5f, 13)),
        .tube = builtin_globe(b, "lamp", vec3_make(160, 136, 104)),
        .cloth = builtin_material(b, "cloth", TEXTURE_FABRIC, vec3_make(0.35f, 0.05f, 0.05f)),
        .lights_left = values[0],
    };
    place_rooms(b, &s);
    place_exhibits(b, &s);
    place_lights(b, &s);
    if (values[2] > 1) stretch_lights(b, (float)values[2]);
    b->scene->ambient_sky = vec3_make(0.34f, 0.35f, 0.40f);
    b->scene->ambient_ground = vec3_make(0.26f, 0.22f, 0.18f);
    b->scene->background = vec3_make(0.01f, 0.015f, 0.03f);
    builtin_camera(b, "corridor", vec3_make(0.9f, 1.7f, -0.6f), vec3_make(-0.25f, 1.75f, -10), 1.05f);
    builtin_camera(b, "room", vec3_make(HALF_WIDTH + 1.1f, 1.7f, -BAY - 0.9f), vec3_make(OUTER - 2.2f, 1.5f, -BAY - 7),
                   1.1f);
    builtin_camera(b, "across", vec3_make(-OUTER + 0.8f, 1.75f, -BAY * 2 - 2.2f), vec3_make(OUTER, 1.2f, -BAY * 2 - 5.6f),
                   0.95f);
}
