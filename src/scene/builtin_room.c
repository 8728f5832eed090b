/* SPDX-License-Identifier: MIT */
/**
 * A room for lights that shine in from outside: its walls are the faces of a box, in which there are an open window, a pane of coloured and one of clear
 * glass. Points of light stand outside; a table and a pillar inside; with `moving` a ball rolls to and fro. With `cave` the walls are uneven: they
 * come up to so many centimetres into the box. It has a probe whose box is that of the walls. EV100 10 suits it.
 */
#include "scene/builtin_mesh.h"

#include <math.h>

/* Metres. */
static const vec3 low = {-3, 0, -4}, high = {3, 3, 4};
#define CELL 0.25f /* of uneven walls */

/* A hole in a wall: low and high along its two axes, metres from its corner. */
struct hole {
    float u0, v0, u1, v1;
};

/* Where a point of an even wall is, if walls come up to `depth` into the box: nearer to the centre, by a function of the point alone, so that walls meet. */
static vec3 uneven(vec3 p, float depth) {
    const vec3 centre = vec3_scale(vec3_add(low, high), 0.5f), from = vec3_sub(p, centre);
    const float wave = 0.5f + 0.17f * sinf(2.1f * p.x + 3.1f * p.y + 1) + 0.17f * sinf(2.7f * p.z - 1.9f * p.y) + 0.16f * sinf(3.3f * p.x + 2.3f * p.z + 2);
    return vec3_add(centre, vec3_scale(from, 1 - depth * wave / 4));
}

/* Sorted places of cuts along an axis. */
struct cuts {
    float at[64];
    uint32_t count;
};

static struct cuts cut(float length, const struct hole *holes, uint32_t count, bool v, float depth) {
    struct cuts marks = {.at = {0, length}, .count = 2}, out = {.count = 0};
    for (uint32_t i = 0; i < count; i++) {
        marks.at[marks.count++] = v ? holes[i].v0 : holes[i].u0;
        marks.at[marks.count++] = v ? holes[i].v1 : holes[i].u1;
    }
    for (uint32_t i = 1; i < marks.count; i++)
        for (uint32_t k = i; k > 0 && marks.at[k - 1] > marks.at[k]; k--) {
            float other = marks.at[k];
            marks.at[k] = marks.at[k - 1];
            marks.at[k - 1] = other;
        }
    for (uint32_t i = 0; i + 1 < marks.count; i++) {
        const uint32_t steps = depth > 0 ? (uint32_t)ceilf((marks.at[i + 1] - marks.at[i]) / CELL) : 1;
        for (uint32_t k = 0; k < steps; k++) out.at[out.count++] = marks.at[i] + (marks.at[i + 1] - marks.at[i]) * (float)k / (float)steps;
    }
    out.at[out.count++] = length;
    return out;
}

/* A wall from corner p along u and v (lengths in metres), seen from where u x v points. */
static void add_wall(struct mesh_builder *m, vec3 p, vec3 u, vec3 v, const struct hole *holes, uint32_t count, float depth) {
    const float width = vec3_length(u), height = vec3_length(v);
    const vec3 along = vec3_scale(u, 1 / width), up = vec3_scale(v, 1 / height);
    const struct cuts a = cut(width, holes, count, false, depth), b = cut(height, holes, count, true, depth);
    for (uint32_t i = 0; i + 1 < a.count; i++)
        for (uint32_t k = 0; k + 1 < b.count; k++) {
            const float x = 0.5f * (a.at[i] + a.at[i + 1]), y = 0.5f * (b.at[k] + b.at[k + 1]);
            bool open = a.at[i + 1] - a.at[i] < 1e-5f || b.at[k + 1] - b.at[k] < 1e-5f;
            for (uint32_t h = 0; h < count; h++) open |= x > holes[h].u0 && x < holes[h].u1 && y > holes[h].v0 && y < holes[h].v1;
            if (open) continue;
            vec3 corners[4];
            vec2 uv[4];
            for (int c = 0; c < 4; c++) {
                const float s = a.at[i + (c == 1 || c == 2)], t = b.at[k + (c > 1)];
                uv[c] = vec2_make(s, height - t);
                corners[c] = vec3_add(p, vec3_add(vec3_scale(along, s), vec3_scale(up, t)));
                if (depth > 0) corners[c] = uneven(corners[c], depth);
            }
            const vec3 normal = vec3_normalize(vec3_cross(vec3_sub(corners[2], corners[0]), vec3_sub(corners[3], corners[1])));
            uint32_t at[4];
            for (int c = 0; c < 4; c++) at[c] = mesh_vertex(m, corners[c], normal, uv[c]);
            mesh_triangle(m, at[0], at[1], at[2]);
            mesh_triangle(m, at[0], at[2], at[3]);
        }
}

static void add_ball(struct builtin *b, uint32_t material) {
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, material);
    mesh_sphere(&m, vec3_make(0, 0, 0), 0.35f, 32);
    const uint32_t mesh = mesh_end(&m, "ball");
    const mat4 place = builtin_at(-1.2f, 0.35f, 0.6f, 0, 1);
    const uint32_t node = b->failed ? SCENE_NONE : scene_add_node(b->scene, "ball", SCENE_NONE, &place, mesh);
    static const float times[] = {0, 2, 4}, places[] = {-1.2f, 0.35f, 0.6f, 1.2f, 0.35f, -0.8f, -1.2f, 0.35f, 0.6f};
    struct scene_channel channel = {.node = node,
                                    .path = SCENE_PATH_TRANSLATION,
                                    .interpolation = SCENE_INTERPOLATION_LINEAR,
                                    .key_count = COUNT_OF(times),
                                    .width = 3,
                                    .times = arena_copy(&b->scene->arena, times, sizeof times),
                                    .values = arena_copy(&b->scene->arena, places, sizeof places)};
    const struct scene_animation animation = {.name = "roll", .channels = arena_copy(&b->scene->arena, &channel, sizeof channel), .channel_count = 1, .duration = 4};
    if (node == SCENE_NONE || !channel.times || !channel.values || !animation.channels || !array_push(&b->scene->host, &b->scene->animations, animation)) {
        b->failed = true;
        return;
    }
    struct scene_node *moves = &b->scene->nodes.data[node];
    moves->has_matrix = false;
    memcpy(moves->translation, (const double[3]){-1.2, 0.35, 0.6}, sizeof moves->translation);
    scene_pose_node(moves);
}

void builtin_make_room(struct builtin *b, const uint64_t *values) {
    const vec3 size = vec3_sub(high, low);
    const float depth = (float)values[2] / 100;
    static const struct hole windows[] = {{1.0f, 1.0f, 4.0f, 2.7f}, {4.8f, 0.8f, 6.0f, 2.7f}, {6.4f, 0.8f, 7.4f, 2.7f}};
    struct mesh_builder m;
    mesh_begin(&m, b);
    mesh_material(&m, builtin_material(b, "plaster", TEXTURE_PLASTER, vec3_make(1, 1, 1)));
    add_wall(&m, vec3_make(low.x, low.y, high.z), vec3_make(0, 0, -size.z), vec3_make(0, size.y, 0), windows, COUNT_OF(windows), depth);
    add_wall(&m, vec3_make(high.x, low.y, low.z), vec3_make(0, 0, size.z), vec3_make(0, size.y, 0), NULL, 0, depth);
    add_wall(&m, low, vec3_make(size.x, 0, 0), vec3_make(0, size.y, 0), NULL, 0, depth);
    add_wall(&m, vec3_make(high.x, low.y, high.z), vec3_make(-size.x, 0, 0), vec3_make(0, size.y, 0), NULL, 0, depth);
    add_wall(&m, vec3_make(low.x, high.y, low.z), vec3_make(size.x, 0, 0), vec3_make(0, 0, size.z), NULL, 0, depth);
    mesh_material(&m, builtin_material(b, "floor", TEXTURE_WOOD, vec3_make(1, 1, 1)));
    add_wall(&m, vec3_make(low.x, low.y, high.z), vec3_make(size.x, 0, 0), vec3_make(0, 0, -size.z), NULL, 0, depth);
    builtin_place(b, mesh_end(&m, "room"), mat4_identity());
    for (uint32_t i = 1; i < COUNT_OF(windows); i++) {
        const struct hole *w = &windows[i];
        mesh_begin(&m, b);
        mesh_material(&m, builtin_glass(b, i == 1 ? "coloured pane" : "clear pane", i == 1 ? vec3_make(0.9f, 0.25f, 0.1f) : vec3_make(0.8f, 0.8f, 0.8f),
                                        i == 1 ? 0.3f : 0.5f));
        mesh_quad(&m, vec3_make(low.x, low.y + w->v0, high.z - w->u0), vec3_make(0, 0, w->u0 - w->u1), vec3_make(0, w->v1 - w->v0, 0));
        builtin_place(b, mesh_end(&m, "pane"), mat4_identity());
    }
    const uint32_t wood = builtin_material(b, "table", TEXTURE_WOOD, vec3_make(0.8f, 0.6f, 0.5f)), stone = builtin_plain(b, "stone", vec3_make(0.7f, 0.7f, 0.66f), 0, 0.7f);
    mesh_begin(&m, b);
    mesh_material(&m, wood);
    mesh_box(&m, vec3_make(-0.9f, 0.7f, -0.5f), vec3_make(0.9f, 0.76f, 0.5f), FACE_ALL);
    for (int i = 0; i < 4; i++) {
        const float x = i & 1 ? 0.8f : -0.8f, z = i & 2 ? 0.4f : -0.4f;
        mesh_box(&m, vec3_make(x - 0.04f, 0, z - 0.04f), vec3_make(x + 0.04f, 0.7f, z + 0.04f), FACE_SIDES);
    }
    builtin_place(b, mesh_end(&m, "table"), builtin_at(-0.6f, 0, -2.2f, 0.3f, 1));
    mesh_begin(&m, b);
    mesh_material(&m, stone);
    mesh_cylinder(&m, vec3_make(0, 0, 0), 0.18f, 0.15f, 1.6f, 24);
    builtin_place(b, mesh_end(&m, "pillar"), builtin_at(-1.7f, 0, 2.2f, 0, 1));
    if (values[3]) add_ball(b, stone);
    b->random.state = values[1];
    for (uint64_t i = 0; i < values[0]; i++) {
        const float turn = random_float(&b->random), z = random_range(&b->random, -3.5f, 3.5f), y = random_range(&b->random, 1.5f, 4);
        builtin_point(b, vec3_make(random_range(&b->random, -7, -4), y, z), builtin_hue(turn, 0.5f), 4e4f / (float)(values[0] + 1), 14);
    }
    fnl_probe_params probe = fnl_probe_params_default();
    probe.centre = vec3_scale(vec3_add(low, high), 0.5f);
    probe.half_size = vec3_scale(size, 0.5f);
    probe.wall = fmaxf(probe.wall, depth);
    if (!b->failed && scene_add_probe(b->scene, &probe) == SCENE_NONE) b->failed = true;
    b->scene->ambient_sky = b->scene->ambient_ground = vec3_make(180, 195, 225);
    b->scene->background = vec3_make(3000, 4000, 6000);
    builtin_camera(b, "inside", vec3_make(2.7f, 1.8f, 3.4f), vec3_make(-1.6f, 0.7f, -0.9f), 1.05f);
}
