/* SPDX-License-Identifier: MIT */
/* Handles at what is picked: three arrows along the world's axes to move it, or three rings about them to turn it. */
#include "view/view.h"

#include "view/ui.h"
#include "view/view_maths.h"

#include <string.h>

enum { RING = 64 }; /* parts that a ring is drawn with */
#define PI_F 3.14159265f

/* The handles as they are shown: about as large on the screen wherever it stands. */
struct handles {
    struct maths_eye eye;
    fnl_vec3 center;
    fnl_vec2 at;
    float metres; /* of an arrow, or radius of a ring */
    float pixels; /* of an arrow that is seen from its side */
};

static bool can_turn(const struct view *v) {
    fnl_light_params light;
    uint32_t index;
    if (v->select.kind != VIEW_PICKED_LIGHT) return true;
    return view_select_index(v, &index) && fnl_scene_query_light(v->shown.scene, index, &light) == FNL_OK &&
           (fnl_light_kind_find(light.kind)->has_direction || light.profile.generation);
}

static bool find_handles(const struct view *v, struct handles *h) {
    if (!v->shown.scene || v->width == 0 || v->height == 0 || (v->select.turns && !can_turn(v)) || !view_select_center(v, &h->center)) return false;
    h->eye = view_select_eye(v);
    h->pixels = fminf(90 * v->scale, 0.2f * fminf(h->eye.width, h->eye.height));
    h->metres = h->pixels / maths_pixels(&h->eye, maths_depth(&h->eye, h->center));
    return maths_project(&h->eye, h->center, &h->at);
}

/* The direction in which its centre is seen. */
static fnl_vec3 sight_of(const struct handles *h) {
    return h->eye.camera.orthographic ? h->eye.forward : maths_unit(maths_add(h->center, h->eye.camera.position, -1));
}

static bool points_at_eye(const struct handles *h, int axis) { return fabsf(maths_dot(sight_of(h), maths_axis(axis))) > 0.97f; }

static fnl_vec3 ring_point(const struct handles *h, int axis, float angle) {
    fnl_vec3 beside[2];
    maths_beside(maths_axis(axis), beside);
    return maths_add(maths_add(h->center, beside[0], h->metres * cosf(angle)), beside[1], h->metres * sinf(angle));
}

bool view_gizmo_place(const struct view *v, int axis, fnl_vec2 *out_center, fnl_vec2 *out_tip) {
    struct handles h;
    if (!find_handles(v, &h)) return false;
    *out_center = h.at;
    return maths_project(&h.eye, v->select.turns ? ring_point(&h, axis, 0) : maths_add(h.center, maths_axis(axis), h.metres), out_tip);
}

/* ---- what is under the mouse ---- */

static float distance_to(fnl_vec2 a, fnl_vec2 b, float x, float y) {
    const float dx = b.x - a.x, dy = b.y - a.y, squared = dx * dx + dy * dy;
    const float t = squared > 0 ? fmaxf(0, fminf(1, ((x - a.x) * dx + (y - a.y) * dy) / squared)) : 0;
    return hypotf(a.x + t * dx - x, a.y + t * dy - y);
}

static float axis_distance(const struct view *v, const struct handles *h, int axis, float x, float y, float *angle) {
    fnl_vec2 last, next;
    float nearest = 1e9f;
    *angle = 0;
    if (!v->select.turns) {
        if (!maths_project(&h->eye, maths_add(h->center, maths_axis(axis), h->metres), &next)) return nearest;
        /* Arrows do not begin in the middle, where all three meet. */
        last = points_at_eye(h, axis) ? next : (fnl_vec2){h->at.x + 0.2f * (next.x - h->at.x), h->at.y + 0.2f * (next.y - h->at.y)};
        return distance_to(last, next, x, y);
    }
    bool had = maths_project(&h->eye, ring_point(h, axis, 0), &last);
    for (int i = 1; i <= RING; i++) {
        const float turn = 2 * PI_F * (float)i / RING;
        const bool has = maths_project(&h->eye, ring_point(h, axis, turn), &next);
        const float distance = had && has ? distance_to(last, next, x, y) : 1e9f;
        if (distance < nearest) {
            nearest = distance;
            *angle = turn;
        }
        last = next;
        had = has;
    }
    return nearest;
}

static int find_axis(const struct view *v, const struct handles *h, float x, float y, float *out_angle) {
    float nearest = 7 * v->scale, angle;
    int best = -1;
    for (int axis = 0; axis < 3; axis++) {
        const float distance = axis_distance(v, h, axis, x, y, &angle);
        if (distance >= nearest) continue;
        nearest = distance;
        best = axis;
        *out_angle = angle;
    }
    return best;
}

/* ---- drags ---- */

/* How far along the axis the place in the picture is: where the line of sight comes nearest to it. */
static bool place_along(const struct handles *h, fnl_vec3 center, fnl_vec3 axis, fnl_vec2 mouse, float *out) {
    fnl_vec3 origin, sight;
    maths_ray(&h->eye, mouse, &origin, &sight);
    const fnl_vec3 to = maths_add(center, origin, -1);
    const float both = maths_dot(axis, sight), apart = 1 - both * both;
    if (apart < 1e-4f) return false;
    *out = (both * maths_dot(sight, to) - maths_dot(axis, to)) / apart;
    const float depth = maths_dot(sight, to) + both * *out;
    return h->eye.camera.orthographic || depth > h->eye.camera.near_distance; /* beyond the vanishing point lines meet behind the eye */
}

static bool angle_about(const struct handles *h, fnl_vec3 center, fnl_vec3 axis, fnl_vec2 mouse, float *out) {
    fnl_vec3 origin, sight, beside[2];
    maths_ray(&h->eye, mouse, &origin, &sight);
    maths_beside(axis, beside);
    const float along = maths_dot(maths_add(center, origin, -1), axis) / maths_dot(sight, axis);
    const fnl_vec3 from = maths_add(maths_add(origin, sight, along), center, -1);
    *out = atan2f(maths_dot(from, beside[1]), maths_dot(from, beside[0]));
    return isfinite(*out) && (h->eye.camera.orthographic || along > 0);
}

/* Before anything has changed. */
static bool begin_edit(struct view *v) {
    struct view_gizmo *g = &v->select.gizmo;
    uint32_t index;
    fnl_mat4 own, inverse;
    memset(&g->edit, 0, sizeof g->edit);
    g->edit.id = v->select.id;
    if (!view_select_index(v, &index)) return false;
    switch (v->select.kind) {
    case VIEW_PICKED_LIGHT:
        g->edit.kind = VIEW_EDIT_LIGHT;
        return fnl_scene_query_light(v->shown.scene, index, &g->edit.before.light) == FNL_OK;
    case VIEW_PICKED_DECAL:
        g->edit.kind = VIEW_EDIT_DECAL;
        return fnl_scene_query_decal(v->shown.scene, index, &g->edit.before.decal) == FNL_OK && view_select_matrices(v, &g->world, &own) &&
               maths_inverse(&g->world, &inverse);
    case VIEW_PICKED_OBJECT:
        g->edit.kind = VIEW_EDIT_TRANSFORM;
        return view_select_matrices(v, &g->world, &g->edit.before.transform) && maths_inverse(&g->world, &inverse);
    case VIEW_PICKED_NOTHING:
        break;
    }
    return false;
}

bool view_gizmo_press(struct view *v, float x, float y) {
    struct view_gizmo *g = &v->select.gizmo;
    struct handles h;
    float angle = 0;
    if (v->select.kind == VIEW_PICKED_NOTHING || !find_handles(v, &h)) return false;
    const int axis = find_axis(v, &h, x, y, &angle);
    if (axis < 0 || !begin_edit(v)) return false;
    const fnl_vec3 direction = maths_axis(axis);
    g->from = (fnl_vec2){x, y};
    g->center = h.center;
    g->per_unit = (fnl_vec2){0, 0};
    if (!v->select.turns && points_at_eye(&h, axis)) { /* up is away from the eye */
        g->per_unit.y = h.pixels / h.metres * (maths_dot(sight_of(&h), direction) > 0 ? -1.0f : 1.0f);
    } else if (v->select.turns && fabsf(maths_dot(sight_of(&h), direction)) < 0.2f) {
        fnl_vec2 a, b;
        if (!maths_project(&h.eye, ring_point(&h, axis, angle - 0.01f), &a) || !maths_project(&h.eye, ring_point(&h, axis, angle + 0.01f), &b)) return false;
        g->per_unit = (fnl_vec2){(b.x - a.x) / 0.02f, (b.y - a.y) / 0.02f};
        if (hypotf(g->per_unit.x, g->per_unit.y) < h.pixels * 0.3f) { /* at the end of a ring that is a line: it is turned as from the middle */
            const float length = fmaxf(hypotf(g->per_unit.x, g->per_unit.y), 1e-6f);
            g->per_unit = (fnl_vec2){g->per_unit.x / length * h.pixels, g->per_unit.y / length * h.pixels};
        }
    } else if (!(v->select.turns ? angle_about(&h, g->center, direction, g->from, &g->start) : place_along(&h, g->center, direction, g->from, &g->start))) {
        return false;
    }
    g->held = axis;
    return true;
}

static fnl_mat4 moved(const struct view_gizmo *g, const fnl_mat4 *own, const fnl_mat4 *motion) {
    fnl_mat4 inverse, world = maths_multiply(motion, &g->world);
    if (memcmp(own, &g->world, sizeof *own) == 0 || !maths_inverse(&g->world, &inverse)) return world;
    const fnl_mat4 to_parent = maths_multiply(own, &inverse);
    return maths_multiply(&to_parent, &world);
}

bool view_gizmo_drag(struct view *v, float x, float y) {
    struct view_gizmo *g = &v->select.gizmo;
    struct handles h;
    if (g->held < 0) return false;
    v->moving = true;
    if (v->width == 0 || v->height == 0) return true;
    h.eye = view_select_eye(v);
    const fnl_vec3 axis = maths_axis(g->held);
    const float squared = g->per_unit.x * g->per_unit.x + g->per_unit.y * g->per_unit.y;
    float by;
    if (squared > 0)
        by = ((x - g->from.x) * g->per_unit.x + (y - g->from.y) * g->per_unit.y) / squared;
    else if (v->select.turns ? angle_about(&h, g->center, axis, (fnl_vec2){x, y}, &by) : place_along(&h, g->center, axis, (fnl_vec2){x, y}, &by))
        by -= g->start;
    else
        return true;
    if (!isfinite(by)) return true;
    fnl_mat4 motion = v->select.turns ? maths_turn(g->center, axis, by) : maths_identity();
    if (!v->select.turns) motion.m[12 + g->held] = by;
    g->edit.after = g->edit.before;
    if (g->edit.kind == VIEW_EDIT_LIGHT) {
        fnl_light_params *light = &g->edit.after.light;
        if (v->select.turns) {
            light->direction = maths_direction(&motion, light->direction);
            light->up = maths_direction(&motion, light->up);
        } else {
            light->position = maths_add(light->position, axis, by);
        }
    } else if (g->edit.kind == VIEW_EDIT_DECAL) {
        g->edit.after.decal.transform = moved(g, &g->edit.before.decal.transform, &motion);
    } else {
        g->edit.after.transform = moved(g, &g->edit.before.transform, &motion);
    }
    view_edit_do(v, &g->edit);
    return true;
}

void view_gizmo_release(struct view *v, bool gives_up) {
    struct view_gizmo *g = &v->select.gizmo;
    struct view_edits *edits = &v->select.edits;
    if (g->held < 0) return;
    g->held = -1;
    view_want(v, 2);
    const struct view_edit *last = edits->done > 0 ? &edits->list[edits->done - 1] : NULL;
    if (!gives_up || !last || last->kind != g->edit.kind || last->gesture != g->edit.gesture || last->id.index != g->edit.id.index) return;
    view_edit_undo(v);
    edits->count = edits->done;
}

/* ---- how they look ---- */

static void draw_arrow(const struct view *v, const struct handles *h, int axis, uint32_t color) {
    fnl_vec2 tip;
    if (!maths_project(&h->eye, maths_add(h->center, maths_axis(axis), h->metres), &tip)) return;
    const float length = hypotf(tip.x - h->at.x, tip.y - h->at.y);
    if (points_at_eye(h, axis) || length < 1) {
        ui_disc(tip.x, tip.y, 6 * v->scale, color);
        return;
    }
    const float x = (tip.x - h->at.x) / length, y = (tip.y - h->at.y) / length, size = 5 * v->scale;
    ui_line(h->at.x, h->at.y, tip.x - x * 2 * size, tip.y - y * 2 * size, color, 3 * v->scale);
    ui_triangle(tip.x, tip.y, tip.x - x * 2 * size - y * size, tip.y - y * 2 * size + x * size, tip.x - x * 2 * size + y * size,
                tip.y - y * 2 * size - x * size, color);
}

static void draw_ring(const struct view *v, const struct handles *h, int axis, uint32_t color) {
    fnl_vec2 last, next;
    bool had = maths_project(&h->eye, ring_point(h, axis, 0), &last);
    for (int i = 1; i <= RING; i++) {
        const bool has = maths_project(&h->eye, ring_point(h, axis, 2 * PI_F * (float)i / RING), &next);
        if (had && has) ui_line(last.x, last.y, next.x, next.y, color, 2.5f * v->scale);
        last = next;
        had = has;
    }
}

void view_gizmo_draw(const struct view *v) {
    static const uint32_t colors[3] = {0xe04040ff, 0x40b040ff, 0x4070f0ff};
    struct handles h;
    float angle;
    if (!find_handles(v, &h)) return;
    const int hovered = v->select.gizmo.held >= 0 ? v->select.gizmo.held : ui_wants_mouse() ? -1 : find_axis(v, &h, v->mouse_x, v->mouse_y, &angle);
    for (int axis = 0; axis < 3; axis++) {
        const uint32_t color = axis == hovered ? 0xffe060ff : colors[axis];
        if (v->select.turns)
            draw_ring(v, &h, axis, color);
        else
            draw_arrow(v, &h, axis, color);
    }
}
