/* SPDX-License-Identifier: MIT */
/** What is picked in the picture, what is done to it, and how that is taken back. */
#ifndef FNL_CLI_VIEW_SELECT_H
#define FNL_CLI_VIEW_SELECT_H

#include "fanal/scene.h"

#include <stdio.h>

struct view;
struct maths_eye;

enum view_picked { VIEW_PICKED_NOTHING, VIEW_PICKED_OBJECT, VIEW_PICKED_LIGHT, VIEW_PICKED_DECAL };

/** An id of the scene, of whatever kind. */
struct view_id {
    uint32_t index, generation;
};

/* ---- edits (view_edit.c) ---- */

enum view_edit_kind {
    VIEW_EDIT_LIGHT,
    VIEW_EDIT_DECAL,
    VIEW_EDIT_MATERIAL,
    VIEW_EDIT_TRANSFORM,
    VIEW_EDIT_VISIBLE,
    VIEW_EDIT_LIGHT_MASK,
    VIEW_EDIT_VIEW_MASK,
    VIEW_EDIT_LIGHT_THERE, /* a light comes, with `after`, or goes */
    VIEW_EDIT_DECAL_THERE,
};

struct view_edit {
    enum view_edit_kind kind;
    struct view_id id;
    bool comes;       /* of …_THERE */
    uint32_t gesture; /* edits of one gesture, such as a drag, are one */
    union view_value {
        fnl_light_params light;
        fnl_decal_params decal;
        fnl_material_params material;
        fnl_mat4 transform;
        bool visible;
        uint32_t light_mask, view_mask;
    } before, after;
};

enum { VIEW_EDITS = 256 };
struct view_edits {
    struct view_edit list[VIEW_EDITS]; /* the oldest is forgotten when it is full */
    uint32_t count, done;              /* those from `done` on were taken back */
    uint32_t gesture;                  /* counts buttons and keys that went down */
};

/** Does it, and keeps it to be taken back; false when the scene refuses it. A light or decal that comes gets its id. */
bool view_edit_do(struct view *view, struct view_edit *edit);
bool view_edit_undo(struct view *view);
bool view_edit_redo(struct view *view);
/** The index of what has this id; false: it is gone. */
bool view_find(const struct view *view, fnl_entity kind, struct view_id id, uint32_t *out);

/* ---- what is picked (view_select.c) ---- */

struct view_select {
    enum view_picked kind;
    struct view_id id;
    uint32_t primitive; /* of an object's mesh, and its material: where it was picked */
    int32_t material;   /* -1: none of the scene's */
    bool shows_lights, turns;
    uint32_t stamp; /* grows when lights or decals may stand elsewhere */
    /* The icons of the last frame. */
    struct view_icons {
        struct view_icon {
            fnl_vec3 place;
            uint32_t index;
            bool decal;
        } *all; /* malloc; as of `stamp` */
        uint32_t count, stamp, light_count;
        const fnl_scene *scene;
        struct view_shown_icon {
            float x, y, depth;
            uint32_t of; /* in `all` */
        } *shown;
        uint32_t shown_count;
        bool failed; /* memory ran out */
    } icons;
    struct view_gizmo {
        int held; /* axis, or -1 */
        fnl_vec2 from;
        fnl_vec3 center;
        float start; /* metres along the axis, or radians about it */
        fnl_vec2 per_unit; /* pixels, where the axis points at the eye or the ring is seen from its side; else 0 */
        struct view_edit edit;
        fnl_mat4 world; /* of an object or decal, when it began */
    } gizmo;
    /* The object's transform as it was last typed: angles are kept. */
    struct view_typed {
        fnl_mat4 of;
        fnl_vec3 place, degrees, scale;
        bool parts;
    } typed;
    struct view_edits edits;
};

void view_select_nothing(struct view *view);
/** Another scene: what was picked and done is forgotten. */
void view_select_reset(struct view *view);
void view_select_free(struct view *view);
/** A light by its index. */
void view_select_light(struct view *view, uint32_t index);
/** What FNL_OUTPUT_OBJECT says of a pixel. */
void view_select_object(struct view *view, const float object[4]);
/** The index of what is picked; false: nothing is, or it is gone. */
bool view_select_index(const struct view *view, uint32_t *out);
/** The light or decal whose icon is at this place of the picture; false: there is none. */
bool view_select_icon(struct view *view, float x, float y);
/** True: the key meant something to it. */
bool view_select_key(struct view *view, int key);
/** Icons, the frame round what is picked, and handles, over the picture; between ui_begin and ui_end. */
void view_select_draw(struct view *view);
/** Lights, decals or objects may stand elsewhere. */
void view_select_changed(struct view *view);
void view_select_report(const struct view *view, FILE *file);

/** An object's or decal's matrix to the world, and that which calls set; false: it has none. */
bool view_select_matrices(const struct view *view, fnl_mat4 *world, fnl_mat4 *own);
/** How the picture shows the world (view_maths.h): of two side by side the left one, which alone has icons and handles. */
struct maths_eye view_select_eye(const struct view *view);
/** The middle of what is picked. */
bool view_select_center(const struct view *view, fnl_vec3 *out);

/* ---- handles (view_gizmo.c) ---- */

/** Takes hold of what is under the mouse; false: nothing is. */
bool view_gizmo_press(struct view *view, float x, float y);
/** False: nothing is held. */
bool view_gizmo_drag(struct view *view, float x, float y);
/** Lets go; `gives_up`: as it was. */
void view_gizmo_release(struct view *view, bool gives_up);
void view_gizmo_draw(const struct view *view);
/** Where the handle of an axis is shown; false: nowhere. */
bool view_gizmo_place(const struct view *view, int axis, fnl_vec2 *out_center, fnl_vec2 *out_tip);

#endif
