/* SPDX-License-Identifier: MIT */
/* What the mouse and the keys do, and what goes on by itself. */
#include "view/view.h"

#include "view/ui.h"

#include "fanal/vulkan.h"

#include <math.h>
#include <string.h>

enum { KEY_SPACE = 32, KEY_ESCAPE = 256, KEY_TAB = 258, KEY_F1 = 290, KEY_F2, KEY_F3, KEY_SHIFT = 340, KEY_CONTROL = 341 };

static void capture_mouse(struct view *v, bool captured) {
    v->captured = captured;
    if (captured && v->settings.navigation == VIEW_ORBIT) v->settings.navigation = VIEW_FLY;
    if (v->window) view_window_capture_mouse(v->window, captured);
}

static void press_key(struct view *v, int key) {
    if (key == KEY_ESCAPE && v->captured) {
        capture_mouse(v, false);
        return;
    }
    if (key == KEY_ESCAPE && ui_menu_is_open()) return;
    if (key == KEY_ESCAPE && (v->files.browses || v->shows_help)) {
        v->files.browses = v->shows_help = false;
        return;
    }
    if (view_select_key(v, key)) return;
    switch (key) {
    case 'F':
        view_frame_all(v);
        break;
    case 'O':
        if (v->modifiers & VIEW_CONTROL) view_browse(v, false);
        break;
    case 'V':
        view_toggle_flight(v);
        break;
    case 'P':
        view_save_next_picture(v);
        break;
    case 'Q':
        v->quit = v->modifiers & VIEW_CONTROL;
        break;
    case KEY_SPACE:
        v->plays = !v->plays && v->shown.info.animation_count > 0;
        break;
    case KEY_TAB:
        v->hides_panels = !v->hides_panels;
        break;
    case 'N':
        v->settings.navigation = (v->settings.navigation + 1) % VIEW_NAVIGATION_COUNT;
        break;
    case 'M':
        capture_mouse(v, !v->captured);
        break;
    case KEY_F1:
        v->shows_help = !v->shows_help;
        break;
    case KEY_F2:
        view_show_wide(v, VIEW_TIMELINE);
        break;
    case KEY_F3:
        view_show_wide(v, VIEW_GRAPH);
        break;
    default:
        break;
    }
}

static void drag(struct view *v, float x, float y) {
    const float dx = x - v->mouse_x, dy = y - v->mouse_y, height = fmaxf(view_area(v).height, 1);
    const bool sideways = v->drag == 2 || (v->drag == 0 && v->modifiers & VIEW_SHIFT);
    if (view_gizmo_drag(v, x, y) || (v->drag < 0 && !v->captured) || !v->shown.scene) return;
    if (sideways)
        view_camera_pan(&v->camera, dx / height, dy / height);
    else if (v->drag == 0 && v->settings.navigation == VIEW_ORBIT)
        view_camera_orbit(&v->camera, dx / height * 3, dy / height * 3);
    else
        view_camera_look(&v->camera, dx / height * 2, dy / height * 2);
    v->moving = true;
}

static void press_button(struct view *v, const struct view_event *e) {
    if (view_compare_press(v, e)) return;
    if (!e->down) {
        if (e->code == 0) view_gizmo_release(v, false);
        if (v->drag == e->code) v->drag = -1;
        return;
    }
    v->select.edits.gesture++;
    if (ui_wants_mouse()) return;
    if (e->code == 0 && v->modifiers & VIEW_CONTROL) {
        if (view_select_icon(v, v->mouse_x, v->mouse_y)) return;
        v->pick.asked = v->pick.clicked = v->shown.scene && v->mouse_x >= 0 && v->mouse_y >= 0;
        v->pick.x = (uint32_t)fmaxf(v->mouse_x, 0);
        v->pick.y = (uint32_t)fmaxf(v->mouse_y, 0);
        return;
    }
    if (e->code == 0 && view_gizmo_press(v, v->mouse_x, v->mouse_y)) return;
    v->drag = e->code;
}

/* Of a gamepad, by the places of their letters on Microsoft's. */
static void press_pad(struct view *v, int button) {
    enum { PAD_A = 0, PAD_X = 2, PAD_Y = 3, PAD_START = 7 };
    if (button == PAD_A) press_key(v, KEY_SPACE);
    if (button == PAD_X) press_key(v, 'N');
    if (button == PAD_Y) press_key(v, 'F');
    if (button == PAD_START) press_key(v, KEY_TAB);
}

/* Letters and movement of the mouse alone change nothing in the scene; keys from Escape on may (enum view_key). */
static bool is_for_panels(const struct view *v, const struct view_event *e) {
    if (e->kind == VIEW_MOVE) return v->drag < 0 && !v->captured && !v->compare.drags && v->select.gizmo.held < 0;
    return e->kind == VIEW_CHARACTER || (e->kind == VIEW_KEY && e->code < KEY_ESCAPE && ui_wants_keys());
}

/* True when a frame must be drawn before the next event: widgets see a button or a key only if it stays as it is for a frame. */
static bool handle(struct view *v, const struct view_event *e) {
    if (is_for_panels(v, e))
        view_want_panels(v, 3);
    else
        view_want(v, 3);
    if (e->kind == VIEW_BUTTON || e->kind == VIEW_KEY) {
        v->modifiers = e->modifiers;
        /* The event of a modifier's own key does not count that key. */
        if (e->kind == VIEW_KEY && (e->code == KEY_SHIFT || e->code == KEY_SHIFT + 4))
            v->modifiers = e->down ? v->modifiers | VIEW_SHIFT : v->modifiers & ~(uint32_t)VIEW_SHIFT;
        if (e->kind == VIEW_KEY && (e->code == KEY_CONTROL || e->code == KEY_CONTROL + 4))
            v->modifiers = e->down ? v->modifiers | VIEW_CONTROL : v->modifiers & ~(uint32_t)VIEW_CONTROL;
        ui_modifiers(v->modifiers & VIEW_CONTROL, v->modifiers & VIEW_SHIFT, v->modifiers & VIEW_ALT);
    }
    switch (e->kind) {
    case VIEW_MOVE:
        v->stale = true;
        if (!v->captured) ui_mouse_moved(e->x, e->y);
        drag(v, e->x, e->y);
        v->mouse_x = e->x;
        v->mouse_y = e->y;
        view_compare_move(v);
        return false;
    case VIEW_BUTTON:
        ui_mouse_button(e->code, e->down);
        press_button(v, e);
        return true;
    case VIEW_WHEEL:
        ui_mouse_wheel(e->x, e->y);
        if (ui_wants_mouse() || !v->shown.scene) return false;
        view_camera_dolly(&v->camera, e->y);
        v->moving = true;
        return false;
    case VIEW_KEY:
        ui_key(e->code, e->down);
        v->keys[e->code] = e->down && !ui_wants_keys();
        v->select.edits.gesture += e->down;
        if (v->keys[e->code] || (e->down && e->code == KEY_ESCAPE && v->files.browses)) press_key(v, e->code);
        return true;
    case VIEW_CHARACTER:
        ui_character((uint32_t)e->code);
        return false;
    case VIEW_SIZE:
        v->width = (uint32_t)e->x;
        v->height = (uint32_t)e->y;
        view_apply_settings(v);
        return false;
    case VIEW_SCALE:
        if (v->settings.scale == 0) v->scale = e->x;
        view_apply_settings(v);
        return false;
    case VIEW_PAD:
        v->pad[e->code] = e->x;
        return false;
    case VIEW_PAD_BUTTON:
        if (e->down) press_pad(v, e->code);
        return false;
    case VIEW_DROP:
        view_open(v, e->text);
        return false;
    case VIEW_CLOSE:
        v->quit = true;
        return false;
    default:
        return false;
    }
}

/* Hands an event on, between frames where that matters: first for a button, which belongs to what is under the mouse. */
bool view_feed(struct view *v, const struct view_event *e, bool *out_wants_frame) {
    if (e->kind == VIEW_BUTTON && v->stale && !view_draw_frame(v, 1.0 / 60)) return false;
    *out_wants_frame = handle(v, e);
    return true;
}

/* What goes on by itself: keys that are held down, the animation, what is being loaded. */
void view_advance(struct view *v, double seconds) {
    if (view_take_loaded(v, false)) view_want(v, 2);
    if (v->loader.running || v->pending > 0) {
        view_want(v, 1);
        v->moving = true;
    }
    if (v->plays) {
        view_set_time(v, v->time + seconds * v->speed);
        v->moving = true;
    }
    const float step = v->camera.size * 0.4f * (v->modifiers & VIEW_SHIFT ? 4.0f : 1.0f) * (float)seconds;
    enum { LEFT_X, LEFT_Y, RIGHT_X, RIGHT_Y, LEFT_TRIGGER, RIGHT_TRIGGER };
    const float *pad = v->pad;
    const fnl_vec3 by = {step * ((float)(v->keys['D'] - v->keys['A']) + pad[LEFT_X]),
                         step * ((float)(v->keys['E'] - v->keys['Q']) + pad[RIGHT_TRIGGER] - pad[LEFT_TRIGGER]),
                         step * ((float)(v->keys['W'] - v->keys['S']) - pad[LEFT_Y])};
    if ((by.x != 0 || by.y != 0 || by.z != 0) && v->shown.scene) {
        if (v->settings.navigation == VIEW_WALK)
            view_camera_walk(&v->camera, by);
        else
            view_camera_fly(&v->camera, by);
        v->moving = true;
        view_want(v, 2);
    }
    if ((pad[RIGHT_X] != 0 || pad[RIGHT_Y] != 0) && v->shown.scene) {
        const float turn = 2 * (float)seconds;
        if (v->settings.navigation == VIEW_ORBIT)
            view_camera_orbit(&v->camera, turn * pad[RIGHT_X], turn * pad[RIGHT_Y]);
        else
            view_camera_look(&v->camera, turn * pad[RIGHT_X], turn * pad[RIGHT_Y]);
        v->moving = true;
        view_want(v, 2);
    }
    view_record_flight(v, seconds);
    if (v->files.flight.records && v->window) view_want(v, 1); /* a place for each picture, at rest too */
    if (v->drag >= 0 || v->select.gizmo.held >= 0) v->moving = true;
    const bool b_gathers = v->compare.mode != VIEW_COMPARE_OFF && v->compare.frame.aa == FNL_ANTIALIASING_TAA;
    if ((v->frame.aa == FNL_ANTIALIASING_TAA || b_gathers) && v->moving) view_want(v, 16);
}
