/* SPDX-License-Identifier: MIT */
/* What is picked: icons of lights and decals over the picture, and the frame round what was chosen. */
#include "view/view.h"

#include "print.h"
#include "view/ui.h"
#include "view/view_maths.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

enum { ICONS_MOST = 2048, ICON_SIZE = 5 }; /* the nearest; half the icon size in pixels */
enum { PICKED_COLOR = (int)0xffb000ffu, KEY_ESCAPE = 256, KEY_DELETE = 261 };

/* ---- which ---- */

void view_select_nothing(struct view *v) {
    v->select.kind = VIEW_PICKED_NOTHING;
    v->select.gizmo.held = -1;
    v->select.typed.parts = false;
    view_want(v, 2);
}

void view_select_reset(struct view *v) {
    view_select_nothing(v);
    v->select.edits.count = v->select.edits.done = 0;
    v->marked.count = v->marked.off_count = 0;
    v->select.stamp++;
}

void view_select_free(struct view *v) {
    free(v->select.icons.all);
    free(v->select.icons.shown);
    v->select.icons = (struct view_icons){0};
}

void view_select_changed(struct view *v) {
    if (!v->shown.scene) return;
    fnl_scene_query_info(v->shown.scene, &v->shown.info);
    view_choose_shadows(v);
    v->shown.changed = true;
    v->select.stamp++;
    view_want(v, 2);
}

static fnl_entity entity_of(enum view_picked kind) {
    return kind == VIEW_PICKED_LIGHT ? FNL_ENTITY_LIGHT : kind == VIEW_PICKED_DECAL ? FNL_ENTITY_DECAL : FNL_ENTITY_INSTANCE;
}

bool view_select_index(const struct view *v, uint32_t *out) {
    return v->select.kind != VIEW_PICKED_NOTHING && view_find(v, entity_of(v->select.kind), v->select.id, out);
}

static void select_index(struct view *v, enum view_picked kind, uint32_t index) {
    fnl_entity_info info;
    view_select_nothing(v);
    if (fnl_scene_query_entity(v->shown.scene, entity_of(kind), index, &info) != FNL_OK) return;
    v->select.kind = kind;
    v->select.id = kind == VIEW_PICKED_LIGHT   ? (struct view_id){info.id.light.index, info.id.light.generation}
                   : kind == VIEW_PICKED_DECAL ? (struct view_id){info.id.decal.index, info.id.decal.generation}
                                               : (struct view_id){info.id.instance.index, info.id.instance.generation};
    if (kind == VIEW_PICKED_LIGHT) v->light = index;
}

void view_select_light(struct view *v, uint32_t index) { select_index(v, VIEW_PICKED_LIGHT, index); }

void view_select_object(struct view *v, const float object[4]) {
    if (!(object[0] >= 1)) {
        view_select_nothing(v);
        return;
    }
    select_index(v, VIEW_PICKED_OBJECT, (uint32_t)object[0] - 1);
    v->select.primitive = (uint32_t)object[1];
    v->select.material = (int32_t)object[2];
}

/* ---- where ---- */

/* The world of the instance that a decal is on or moves with. */
static fnl_mat4 parent_of(const struct view *v, const fnl_decal_params *decal) {
    fnl_instance_info info;
    uint32_t index;
    const struct view_id id = {decal->instance.index, decal->instance.generation};
    if (!view_find(v, FNL_ENTITY_INSTANCE, id, &index) || fnl_scene_query_instance(v->shown.scene, index, &info) != FNL_OK) return maths_identity();
    return info.world;
}

bool view_select_matrices(const struct view *v, fnl_mat4 *world, fnl_mat4 *own) {
    uint32_t index;
    fnl_instance_info instance;
    fnl_decal_params decal;
    if (!view_select_index(v, &index)) return false;
    if (v->select.kind == VIEW_PICKED_OBJECT && fnl_scene_query_instance(v->shown.scene, index, &instance) == FNL_OK) {
        *world = instance.world;
        *own = instance.transform;
        return true;
    }
    if (v->select.kind != VIEW_PICKED_DECAL || fnl_scene_query_decal(v->shown.scene, index, &decal) != FNL_OK) return false;
    const fnl_mat4 parent = parent_of(v, &decal);
    *own = decal.transform;
    *world = maths_multiply(&parent, &decal.transform);
    return true;
}

/* The mesh of the object, and whether its place is its node's, not that of joints. */
static bool query_bounds(const struct view *v, fnl_vec3 *low, fnl_vec3 *high, bool *stands) {
    uint32_t index;
    fnl_instance_info instance;
    fnl_mesh_info mesh;
    if (!view_select_index(v, &index) || fnl_scene_query_instance(v->shown.scene, index, &instance) != FNL_OK || !instance.mesh.generation ||
        fnl_scene_query_mesh(v->shown.scene, instance.mesh.index, 0, &mesh) != FNL_OK)
        return false;
    *low = mesh.bounds_low;
    *high = mesh.bounds_high;
    *stands = instance.joint_count == 0;
    return true;
}

bool view_select_center(const struct view *v, fnl_vec3 *out) {
    fnl_mat4 world, own;
    fnl_vec3 low, high;
    fnl_light_params light;
    uint32_t index;
    bool stands;
    if (v->select.kind == VIEW_PICKED_LIGHT) {
        if (!view_select_index(v, &index) || fnl_scene_query_light(v->shown.scene, index, &light) != FNL_OK || light.kind == FNL_LIGHT_DIRECTIONAL) return false;
        *out = light.position;
        return true;
    }
    if (!view_select_matrices(v, &world, &own)) return false;
    *out = maths_column(&world, 3);
    if (v->select.kind != VIEW_PICKED_OBJECT || !query_bounds(v, &low, &high, &stands)) return true;
    if (!stands) return false; /* its joints move it */
    *out = maths_point(&world, maths_scale(maths_add(low, high, 1), 0.5f));
    return true;
}

struct maths_eye view_select_eye(const struct view *v) {
    uint32_t first = 0;
    const fnl_camera camera = view_compare_camera(v, false);
    return maths_eye(&camera, view_compare_place(v, &first), v->height);
}

/* ---- icons ---- */

static bool gather(struct view *v) {
    struct view_icons *icons = &v->select.icons;
    fnl_scene *scene = v->shown.scene;
    const uint32_t lights = fnl_scene_count(scene, FNL_ENTITY_LIGHT), decals = fnl_scene_count(scene, FNL_ENTITY_DECAL);
    if (icons->scene == scene && icons->stamp == v->select.stamp && icons->light_count == lights) return !icons->failed;
    *icons = (struct view_icons){.all = icons->all, .shown = icons->shown, .scene = scene, .stamp = v->select.stamp, .light_count = lights};
    const size_t most = (size_t)lights + decals + 1;
    struct view_icon *all = realloc(icons->all, most * sizeof *all);
    if (all) icons->all = all;
    struct view_shown_icon *shown = all ? realloc(icons->shown, most * sizeof *shown) : NULL;
    if (shown) icons->shown = shown;
    icons->failed = !shown;
    for (uint32_t i = 0; i < lights && shown; i++) {
        fnl_light_params light;
        if (fnl_scene_query_light(scene, i, &light) == FNL_OK && light.kind != FNL_LIGHT_DIRECTIONAL)
            all[icons->count++] = (struct view_icon){light.position, i, false};
    }
    for (uint32_t i = 0; i < decals && shown; i++) {
        fnl_decal_params decal;
        if (fnl_scene_query_decal(scene, i, &decal) != FNL_OK) continue;
        const fnl_mat4 parent = parent_of(v, &decal), world = maths_multiply(&parent, &decal.transform);
        all[icons->count++] = (struct view_icon){maths_column(&world, 3), i, true};
    }
    return !icons->failed;
}

/* The `most` nearest come first (Hoare's selection). */
static void select_nearest(struct view_shown_icon *icons, uint32_t count, uint32_t most) {
    uint32_t low = 0, high = count;
    while (count > most && high - low > 1) {
        const float pivot = icons[low + (high - low) / 2].depth;
        uint32_t less = low, equal = low, more = high;
        while (equal < more) {
            const struct view_shown_icon icon = icons[equal];
            if (icon.depth < pivot) {
                icons[equal++] = icons[less];
                icons[less++] = icon;
            } else if (icon.depth > pivot) {
                icons[equal] = icons[--more];
                icons[more] = icon;
            } else {
                equal++;
            }
        }
        if (most < less)
            high = less;
        else if (most > more)
            low = more;
        else
            return;
    }
}

static int nearer_first(const void *a, const void *b) {
    const struct view_shown_icon *one = a, *other = b;
    if (one->depth != other->depth) return one->depth < other->depth ? -1 : 1;
    return (one->of > other->of) - (one->of < other->of);
}

/* The nearest to the camera first; they are drawn from the back. */
static void find_icons(struct view *v, const struct maths_eye *eye) {
    struct view_icons *icons = &v->select.icons;
    if (!gather(v)) return;
    icons->shown_count = 0;
    for (uint32_t i = 0; i < icons->count; i++) {
        fnl_vec2 at;
        if (!maths_project(eye, icons->all[i].place, &at) || at.x < 0 || at.y < 0 || at.x >= eye->width || at.y >= eye->height) continue;
        icons->shown[icons->shown_count++] = (struct view_shown_icon){at.x, at.y, maths_depth(eye, icons->all[i].place), i};
    }
    select_nearest(icons->shown, icons->shown_count, ICONS_MOST);
    if (icons->shown_count > ICONS_MOST) icons->shown_count = ICONS_MOST;
    qsort(icons->shown, icons->shown_count, sizeof *icons->shown, nearer_first);
}

/* Picks the front icon of those under the cursor; otherwise the icon nearest to the cursor. */
bool view_select_icon(struct view *v, float x, float y) {
    const struct maths_eye eye = view_select_eye(v);
    struct view_icons *icons = &v->select.icons;
    float nearest = 8 * v->scale;
    const float drawn = ICON_SIZE * v->scale;
    const struct view_icon *best = NULL;
    if (!v->select.shows_lights || !v->shown.scene) return false;
    find_icons(v, &eye);
    for (uint32_t i = 0; i < icons->shown_count; i++) {
        const float distance = hypotf(icons->shown[i].x - x, icons->shown[i].y - y);
        if (distance >= nearest) continue;
        nearest = distance;
        best = &icons->all[icons->shown[i].of];
        if (distance <= drawn) break;
    }
    if (best) select_index(v, best->decal ? VIEW_PICKED_DECAL : VIEW_PICKED_LIGHT, best->index);
    return best;
}

static uint32_t light_color(const struct view *v, uint32_t index) {
    fnl_light_params light;
    uint32_t color = 0;
    if (fnl_scene_query_light(v->shown.scene, index, &light) != FNL_OK) return 0xffffffff;
    const float most = fmaxf(light.color[0], fmaxf(light.color[1], fmaxf(light.color[2], 1e-6f)));
    for (int i = 0; i < 3; i++) color = color << 8 | (uint32_t)(sqrtf(fmaxf(light.color[i], 0) / most) * 255);
    return color << 8 | 0xff;
}

static void draw_icons(struct view *v, const struct maths_eye *eye) {
    const struct view_icons *icons = &v->select.icons;
    find_icons(v, eye);
    for (uint32_t i = icons->shown_count; i-- > 0;) {
        const struct view_shown_icon *s = &icons->shown[i];
        const struct view_icon *icon = &icons->all[s->of];
        const float size = (ICON_SIZE - 1) * v->scale;
        if (icon->decal) {
            for (int side = 0; side < 2; side++) {
                const float sign = side ? 1.0f : -1.0f;
                ui_line(s->x - size, s->y + sign * size, s->x + size, s->y + sign * size, 0x40d0ffff, 2 * v->scale);
                ui_line(s->x + sign * size, s->y - size, s->x + sign * size, s->y + size, 0x40d0ffff, 2 * v->scale);
            }
            continue;
        }
        ui_disc(s->x, s->y, size + v->scale, 0x000000c0);
        ui_disc(s->x, s->y, size, light_color(v, icon->index));
    }
}

/* ---- the frame round it ---- */

static void draw_line(const struct view *v, const struct maths_eye *eye, fnl_vec3 a, fnl_vec3 b, uint32_t color) {
    const float near = eye->camera.near_distance * 1.001f, from = maths_depth(eye, a), to = maths_depth(eye, b);
    fnl_vec2 p, q;
    if (from < near && to < near) return;
    if (from < near) a = maths_add(a, maths_add(b, a, -1), (near - from) / (to - from));
    if (to < near) b = maths_add(b, maths_add(a, b, -1), (near - to) / (from - to));
    if (maths_project(eye, a, &p) && maths_project(eye, b, &q)) ui_line(p.x, p.y, q.x, q.y, color, 1.5f * v->scale);
}

static void draw_box(const struct view *v, const struct maths_eye *eye, const fnl_mat4 *world, fnl_vec3 low, fnl_vec3 high) {
    for (int axis = 0; axis < 3; axis++)
        for (int k = 0; k < 4; k++) {
            const int bits = axis == 0 ? k << 1 : axis == 1 ? (k & 1) | (k & 2) << 1 : k;
            fnl_vec3 ends[2];
            for (int end = 0; end < 2; end++) {
                const int corner = bits | end << axis;
                ends[end] = maths_point(world, (fnl_vec3){corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y, corner & 4 ? high.z : low.z});
            }
            draw_line(v, eye, ends[0], ends[1], (uint32_t)PICKED_COLOR);
        }
}

/* A circle with the radius of the light's range, facing the eye. */
static void draw_range(const struct view *v, const struct maths_eye *eye, const fnl_light_params *light) {
    enum { PARTS = 64 };
    const float range = isinf(light->range) ? fnl_light_range(light, 1, 0.05f) : light->range;
    fnl_vec3 beside[2], last = {0, 0, 0};
    const fnl_vec3 towards = eye->camera.orthographic ? eye->forward : maths_unit(maths_add(light->position, eye->camera.position, -1));
    if (!(range < 1e6f)) return;
    maths_beside(towards, beside);
    for (int i = 0; i <= PARTS; i++) {
        const float angle = 6.2831853f * (float)i / PARTS;
        const fnl_vec3 place = maths_add(maths_add(light->position, beside[0], range * cosf(angle)), beside[1], range * sinf(angle));
        if (i > 0) draw_line(v, eye, last, place, (uint32_t)PICKED_COLOR);
        last = place;
    }
}

/* Cones and pyramids have about the same length on the screen at any distance. */
static void draw_outline(const struct view *v, const struct maths_eye *eye, const fnl_light_params *light) {
    enum { MOST = 256 };
    const float length = 120 * v->scale / maths_pixels(eye, fmaxf(maths_depth(eye, light->position), eye->camera.near_distance));
    fnl_vec3 points[MOST];
    const uint32_t count = fnl_light_outline(light, length, MOST, points);
    for (uint32_t i = 0; i + 1 < count && i + 1 < MOST; i += 2) draw_line(v, eye, points[i], points[i + 1], (uint32_t)PICKED_COLOR);
}

static void draw_frame(const struct view *v, const struct maths_eye *eye) {
    fnl_mat4 world, own;
    fnl_vec3 low = {-0.5f, -0.5f, -0.5f}, high = {0.5f, 0.5f, 0.5f};
    fnl_light_params light;
    uint32_t index;
    bool stands = true;
    if (v->select.kind == VIEW_PICKED_LIGHT) {
        fnl_vec2 at;
        if (!view_select_index(v, &index) || fnl_scene_query_light(v->shown.scene, index, &light) != FNL_OK || light.kind == FNL_LIGHT_DIRECTIONAL) return;
        draw_outline(v, eye, &light);
        if (fnl_light_kind_find(light.kind)->has_range) draw_range(v, eye, &light);
        if (maths_project(eye, light.position, &at)) ui_disc(at.x, at.y, 6 * v->scale, (uint32_t)PICKED_COLOR);
        return;
    }
    if (!view_select_matrices(v, &world, &own)) return;
    if (v->select.kind == VIEW_PICKED_OBJECT && (!query_bounds(v, &low, &high, &stands) || !stands)) return;
    draw_box(v, eye, &world, low, high);
}

void view_select_draw(struct view *v) {
    if (!v->shown.scene || v->width == 0 || v->height == 0) return;
    const struct maths_eye eye = view_select_eye(v);
    if (v->select.shows_lights) draw_icons(v, &eye);
    if (v->select.kind == VIEW_PICKED_NOTHING) return;
    draw_frame(v, &eye);
    view_gizmo_draw(v);
}

/* ---- keys ---- */

static void remove_picked(struct view *v) {
    struct view_edit edit = {.id = v->select.id, .comes = false};
    uint32_t index;
    if (!view_select_index(v, &index)) return;
    const bool light = v->select.kind == VIEW_PICKED_LIGHT;
    edit.kind = light ? VIEW_EDIT_LIGHT_THERE : VIEW_EDIT_DECAL_THERE;
    if (v->select.kind == VIEW_PICKED_OBJECT) return;
    const fnl_result known = light ? fnl_scene_query_light(v->shown.scene, index, &edit.after.light)
                                   : fnl_scene_query_decal(v->shown.scene, index, &edit.after.decal);
    if (known == FNL_OK && view_edit_do(v, &edit)) view_select_nothing(v);
}

bool view_select_key(struct view *v, int key) {
    struct view_select *s = &v->select;
    if (v->modifiers & VIEW_CONTROL) {
        if (key != 'Z' && key != 'Y') return false;
        view_gizmo_release(v, true);
        if (key == 'Y' || v->modifiers & VIEW_SHIFT)
            view_edit_redo(v);
        else
            view_edit_undo(v);
        return true;
    }
    switch (key) {
    case 'L':
        s->shows_lights = !s->shows_lights;
        return true;
    case 'T':
    case '1':
        s->turns = false;
        return true;
    case 'R':
    case '2':
        s->turns = true;
        return true;
    case KEY_ESCAPE:
        if (s->gizmo.held >= 0)
            view_gizmo_release(v, true);
        else
            view_select_nothing(v);
        return true;
    case KEY_DELETE:
        view_gizmo_release(v, true);
        remove_picked(v);
        return true;
    default:
        return false;
    }
}

/* ---- as text ---- */

static void report_vector(FILE *file, fnl_vec3 v) { fprintf(file, "\t%.9g\t%.9g\t%.9g", (double)v.x, (double)v.y, (double)v.z); }

static void report_object(const struct view *v, FILE *file, uint32_t index) {
    fnl_instance_info instance;
    fnl_entity_info mesh, name;
    fnl_material_params m;
    if (fnl_scene_query_instance(v->shown.scene, index, &instance) != FNL_OK) return;
    if (instance.mesh.generation && fnl_scene_query_entity(v->shown.scene, FNL_ENTITY_MESH, instance.mesh.index, &mesh) == FNL_OK)
        fprintf(file, "picked_mesh\t%u\t%s\t%u\n", instance.mesh.index, mesh.name, v->select.primitive);
    fputs("picked_transform", file);
    for (int i = 0; i < 16; i++) fprintf(file, "\t%.9g", (double)instance.transform.m[i]);
    fprintf(file, "\npicked_visible\t%d\n", instance.visible);
    if (v->select.material < 0 || fnl_scene_query_entity(v->shown.scene, FNL_ENTITY_MATERIAL, (uint32_t)v->select.material, &name) != FNL_OK ||
        fnl_scene_query_material(v->shown.scene, (uint32_t)v->select.material, &m) != FNL_OK)
        return;
    fprintf(file, "picked_material\t%d\t%s\n", v->select.material, name.name);
    fprintf(file, "picked_base_color\t%.9g\t%.9g\t%.9g\t%.9g\n", (double)m.base_color[0], (double)m.base_color[1], (double)m.base_color[2],
            (double)m.base_color[3]);
    fprintf(file, "picked_metallic\t%.9g\npicked_roughness\t%.9g\npicked_emissive\t%.9g\t%.9g\t%.9g\n", (double)m.metallic, (double)m.roughness,
            (double)m.emissive[0], (double)m.emissive[1], (double)m.emissive[2]);
}

static void report_light(const struct view *v, FILE *file, uint32_t index) {
    fnl_light_params light;
    if (fnl_scene_query_light(v->shown.scene, index, &light) != FNL_OK) return;
    fprintf(file, "picked_light\t%s\npicked_position", fnl_value_name(FNL_ENUM_LIGHT_KIND, light.kind));
    report_vector(file, light.position);
    fputs("\npicked_direction", file);
    report_vector(file, light.direction);
    fprintf(file, "\npicked_color\t%.9g\t%.9g\t%.9g\npicked_intensity\t%.9g\npicked_range\t%.9g\n", (double)light.color[0], (double)light.color[1],
            (double)light.color[2], (double)light.intensity, (double)light.range);
}

static void report_decal(const struct view *v, FILE *file, uint32_t index) {
    fnl_decal_params decal;
    fnl_mat4 world, own;
    if (fnl_scene_query_decal(v->shown.scene, index, &decal) != FNL_OK || !view_select_matrices(v, &world, &own)) return;
    fprintf(file, "picked_decal\t%s\npicked_position", fnl_value_name(FNL_ENUM_DECAL_KIND, decal.kind));
    report_vector(file, maths_column(&world, 3));
    fputs("\npicked_size", file);
    report_vector(file, (fnl_vec3){maths_length(maths_column(&world, 0)), maths_length(maths_column(&world, 1)), maths_length(maths_column(&world, 2))});
    fputc('\n', file);
}

void view_select_report(const struct view *v, FILE *file) {
    static const char *const kinds[] = {"nothing", "object", "light", "decal"};
    uint32_t index;
    fnl_entity_info info;
    fnl_vec2 center, tip;
    if (v->select.shows_lights) fprintf(file, "icons\t%u\n", v->select.icons.shown_count);
    if (v->select.edits.count) fprintf(file, "edits\t%u\t%u\n", v->select.edits.done, v->select.edits.count);
    if (!view_select_index(v, &index) || fnl_scene_query_entity(v->shown.scene, entity_of(v->select.kind), index, &info) != FNL_OK) {
        fputs("picked\tnothing\n", file);
        return;
    }
    fprintf(file, "picked\t%s\t%u\t%s\n", kinds[v->select.kind], index, info.name);
    if (v->select.kind == VIEW_PICKED_OBJECT) report_object(v, file, index);
    if (v->select.kind == VIEW_PICKED_LIGHT) report_light(v, file, index);
    if (v->select.kind == VIEW_PICKED_DECAL) report_decal(v, file, index);
    for (int axis = 0; axis < 3; axis++)
        if (view_gizmo_place(v, axis, &center, &tip))
            fprintf(file, "handle\t%s\t%c\t%.9g\t%.9g\t%.9g\t%.9g\n", v->select.turns ? "turn" : "move", "xyz"[axis], (double)center.x, (double)center.y,
                    (double)tip.x, (double)tip.y);
}
