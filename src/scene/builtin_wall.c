/* SPDX-License-Identifier: MIT */
/**
 * A yard before a house whose many lit rooms lie behind one long wall: for culling lights by the normals they could reach.
 * After the four tests of Ishmukhametov, "Efficient Tile-Based Deferred Shading Pipeline" (2013), table of chapter 5:
 * 1500, 1600, 2000 and 2500 lights, 55, 183, 583 and 1083 of them in the view, 0, 100, 500 and 1000 of those behind the
 * wall. The counts hold for the camera "front" at 16:9. Lights behind the wall reach through it, but touch only backs of
 * surfaces; lights out of the view lie behind the camera. `lights=` takes the first of: before the wall, behind it, out of
 * the view. EV100 4 suits it.
 */
#include "scene/builtin_mesh.h"

/* Metres. */
#define WALL 20.0f /* distance from the camera */
#define THICK 0.3f
#define ROOM 6.0f /* width and depth */
#define STOREY 4.0f
#define EYE 6.0f /* height of the camera */

enum { ROOMS = 14, STOREYS = 5 };

static const struct {
    uint32_t total, visible, behind;
} tests[4] = {{1500, 55, 0}, {1600, 183, 100}, {2000, 583, 500}, {2500, 1083, 1000}};

/** A material whose normals are exactly the geometry's: what lies behind the surface then gives exactly nothing. */
static uint32_t flat_material(struct builtin *b, const char *name, enum builtin_texture texture, vec3 tint) {
    uint32_t index = builtin_material(b, name, texture, tint);
    builtin_material_at(b, index)->textures[SCENE_TEXTURE_NORMAL] = scene_texture_none();
    return index;
}

static void place_house(struct builtin *b) {
    const float half = ROOM * ROOMS / 2, height = STOREY * STOREYS;
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, flat_material(b, "wall", TEXTURE_BRICK, vec3_make(1, 1, 1)));
    mesh_box(&m, vec3_make(-half, 0, -WALL - THICK), vec3_make(half, height, -WALL), FACE_ALL);
    mesh_material(&m, flat_material(b, "rooms", TEXTURE_PLASTER, vec3_make(0.9f, 0.8f, 0.65f)));
    for (int i = 0; i <= ROOMS; i++) {
        float x = -half + ROOM * (float)i;
        mesh_box(&m, vec3_make(x - 0.1f, 0, -WALL - THICK - ROOM), vec3_make(x + 0.1f, height, -WALL - THICK), FACE_SIDES);
    }
    mesh_material(&m, flat_material(b, "boards", TEXTURE_WOOD, vec3_make(1, 1, 1)));
    for (int i = 0; i <= STOREYS; i++) {
        float y = STOREY * (float)i;
        mesh_box(&m, vec3_make(-half, y - 0.2f, -WALL - THICK - ROOM), vec3_make(half, y, -WALL - THICK), FACE_ALL);
    }
    builtin_place(b, mesh_end(&m, "house"), mat4_identity());
}

static void place_yard(struct builtin *b) {
    const float half = ROOM * ROOMS / 2;
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, flat_material(b, "yard", TEXTURE_PAVING, vec3_make(1, 1, 1)));
    mesh_quad(&m, vec3_make(-half, 0, 44), vec3_make(2 * half, 0, 0), vec3_make(0, 0, -44 - WALL));
    builtin_place(b, mesh_end(&m, "yard"), mat4_identity());
    mesh_material(&m, flat_material(b, "post", TEXTURE_STONE, vec3_make(1, 1, 1)));
    mesh_bevel_box(&m, vec3_make(-0.4f, 0, -0.4f), vec3_make(0.4f, 3.4f, 0.4f), 0.06f);
    mesh_bevel_box(&m, vec3_make(-0.55f, 3.4f, -0.55f), vec3_make(0.55f, 3.7f, 0.55f), 0.06f);
    mesh_sphere(&m, vec3_make(0, 4.15f, 0), 0.45f, 24);
    uint32_t post = mesh_end(&m, "post");
    for (int i = -3; i <= 3; i++) builtin_place(b, post, builtin_at(4 * (float)i, 0, -12, 0, 1));
    mesh_material(&m, flat_material(b, "garden wall", TEXTURE_STONE, vec3_make(1, 1, 1)));
    mesh_box(&m, vec3_make(-0.15f, 0, -5), vec3_make(0.15f, 3, 5), FACE_NO_BOTTOM);
    uint32_t garden = mesh_end(&m, "garden wall");
    for (int i = 0; i < 24; i++)
        builtin_place(b, garden, builtin_at(-36 + 12 * (float)(i % 7), 0, 10 + 11 * (float)(i / 7), i % 3 ? 0 : PI / 2, 1));
}

static void add_light(struct builtin *b, vec3 position, float range) {
    vec3 color = vec3_lerp(LIGHT_WARM, builtin_hue(random_float(&b->random), 0.8f), 0.45f);
    builtin_point(b, position, color, 9 * range * range, range);
}

/** Before the wall, by turns near it and over the yard. */
static void add_before(struct builtin *b, uint64_t index) {
    float x = random_range(&b->random, -14, 14), y = random_range(&b->random, 0.5f, 13.5f);
    if (index % 2)
        add_light(b, vec3_make(x, y, -WALL + random_range(&b->random, 0.3f, 0.9f)), random_range(&b->random, 2, 3.5f));
    else
        add_light(b, vec3_make(0.5f * x, random_range(&b->random, 0.5f, 2), random_range(&b->random, -17, -12)),
                  random_range(&b->random, 2, 4));
}

/**
 * In the rooms, reaching far through the wall; clear of the yard's ground and of what the posts hide, so that only the wall's back is
 * within reach. As in the source they are so large that most of the frame's time is theirs.
 */
static void add_behind(struct builtin *b) {
    float x = random_range(&b->random, -15, 15), range = random_range(&b->random, 3.5f, 5.5f),
          y = random_range(&b->random, range + 4.8f, 13.5f), depth = random_range(&b->random, 0.1f, 0.8f) + THICK;
    add_light(b, vec3_make(x, y, -WALL - depth), range);
}

/** In the gardens behind the camera, no nearer to it than their range. */
static void add_outside(struct builtin *b) {
    float x = random_range(&b->random, -38, 38), range = random_range(&b->random, 1.5f, 4);
    add_light(b, vec3_make(x, random_range(&b->random, 0.4f, 2.5f), random_range(&b->random, 0.1f, 38) + range), range);
}

void builtin_make_wall(struct builtin *b, const uint64_t *values) {
    const uint32_t total = tests[values[0] - 1].total, visible = tests[values[0] - 1].visible,
                   behind = tests[values[0] - 1].behind;
    uint64_t count = values[1] == BUILTIN_NOT_GIVEN ? total : values[1];
    b->random.state = values[2];
    place_house(b);
    place_yard(b);
    for (uint64_t i = 0; i < count; i++) {
        if (i < visible - behind)
            add_before(b, i);
        else if (i < visible)
            add_behind(b);
        else
            add_outside(b);
    }
    b->scene->ambient_sky = vec3_make(0.25f, 0.3f, 0.45f);
    b->scene->ambient_ground = vec3_make(0.15f, 0.14f, 0.13f);
    b->scene->background = vec3_make(0.06f, 0.09f, 0.2f);
    builtin_camera(b, "front", vec3_make(0, EYE, 0), vec3_make(0, EYE, -WALL), 0.9f);
    builtin_camera(b, "rooms", vec3_make(-16, 13, -WALL - 24), vec3_make(0, 8, -WALL), 0.9f);
}
