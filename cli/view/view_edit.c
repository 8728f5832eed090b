/* SPDX-License-Identifier: MIT */
/* What was done to the scene, in order, so that it can be taken back. */
#include "view/view.h"

#include <string.h>

static struct view_id id_of(fnl_entity kind, const fnl_entity_info *info) {
    switch (kind) {
    case FNL_ENTITY_LIGHT:
        return (struct view_id){info->id.light.index, info->id.light.generation};
    case FNL_ENTITY_DECAL:
        return (struct view_id){info->id.decal.index, info->id.decal.generation};
    default:
        return (struct view_id){info->id.instance.index, info->id.instance.generation};
    }
}

bool view_find(const struct view *v, fnl_entity kind, struct view_id id, uint32_t *out) {
    const uint32_t count = v->shown.scene ? fnl_scene_count(v->shown.scene, kind) : 0;
    /* What was removed before it moves an index down, never up. */
    for (uint32_t i = id.index < count ? id.index + 1 : count; id.generation && i-- > 0;) {
        fnl_entity_info info;
        if (fnl_scene_query_entity(v->shown.scene, kind, i, &info) != FNL_OK) return false;
        const struct view_id found = id_of(kind, &info);
        if (found.index < id.index) return false; /* they ascend */
        if (found.index != id.index) continue;
        *out = i;
        return found.generation == id.generation;
    }
    return false;
}

/* What was removed and is there again has another id. */
static void rename_all(struct view *v, bool decal, struct view_id from, struct view_id to) {
    struct view_edits *edits = &v->select.edits;
    for (uint32_t i = 0; i < edits->count; i++) {
        struct view_edit *e = &edits->list[i];
        const bool same_kind = decal ? e->kind == VIEW_EDIT_DECAL || e->kind == VIEW_EDIT_DECAL_THERE
                                     : e->kind == VIEW_EDIT_LIGHT || e->kind == VIEW_EDIT_LIGHT_THERE;
        if (same_kind && e->id.index == from.index && e->id.generation == from.generation) e->id = to;
    }
}

static fnl_result add(struct view *v, struct view_edit *e) {
    const struct view_id before = e->id;
    fnl_result result;
    if (e->kind == VIEW_EDIT_LIGHT_THERE) {
        fnl_light_id id;
        result = fnl_scene_add_light(v->shown.scene, &e->after.light, &id);
        if (result == FNL_OK) e->id = (struct view_id){id.index, id.generation};
    } else {
        fnl_decal_id id;
        result = fnl_scene_add_decal(v->shown.scene, &e->after.decal, &id);
        if (result == FNL_OK) e->id = (struct view_id){id.index, id.generation};
    }
    if (result != FNL_OK) return result;
    const bool decal = e->kind == VIEW_EDIT_DECAL_THERE;
    if (before.generation) rename_all(v, decal, before, e->id);
    v->select.kind = decal ? VIEW_PICKED_DECAL : VIEW_PICKED_LIGHT;
    v->select.id = e->id;
    return FNL_OK;
}

static fnl_result apply(struct view *v, struct view_edit *e, bool forward) {
    const union view_value *value = forward ? &e->after : &e->before;
    fnl_scene *scene = v->shown.scene;
    const struct view_id id = e->id;
    view_want(v, 2);
    switch (e->kind) {
    case VIEW_EDIT_LIGHT:
        return fnl_scene_set_light(scene, (fnl_light_id){id.index, id.generation}, &value->light);
    case VIEW_EDIT_DECAL:
        return fnl_scene_set_decal(scene, (fnl_decal_id){id.index, id.generation}, &value->decal);
    case VIEW_EDIT_MATERIAL:
        return fnl_scene_set_material(scene, (fnl_material_id){id.index, id.generation}, &value->material);
    case VIEW_EDIT_TRANSFORM:
        return fnl_scene_set_instance_transform(scene, (fnl_instance_id){id.index, id.generation}, &value->transform);
    case VIEW_EDIT_LIGHT_MASK:
        return fnl_scene_set_instance_light_mask(scene, (fnl_instance_id){id.index, id.generation}, value->light_mask);
    case VIEW_EDIT_VIEW_MASK:
        return fnl_scene_set_instance_view_mask(scene, (fnl_instance_id){id.index, id.generation}, value->view_mask);
    case VIEW_EDIT_VISIBLE:
        return fnl_scene_set_instance_visible(scene, (fnl_instance_id){id.index, id.generation}, value->visible);
    case VIEW_EDIT_LIGHT_THERE:
        return e->comes == forward ? add(v, e) : fnl_scene_remove_light(scene, (fnl_light_id){id.index, id.generation});
    case VIEW_EDIT_DECAL_THERE:
        return e->comes == forward ? add(v, e) : fnl_scene_remove_decal(scene, (fnl_decal_id){id.index, id.generation});
    }
    return FNL_ERROR_INVALID;
}

static bool applied(struct view *v, struct view_edit *e, bool forward) {
    const bool good = apply(v, e, forward) == FNL_OK;
    view_select_changed(v);
    return good;
}

bool view_edit_do(struct view *v, struct view_edit *edit) {
    struct view_edits *edits = &v->select.edits;
    if (!v->shown.scene || !applied(v, edit, true)) return false;
    edit->gesture = edits->gesture;
    edits->count = edits->done;
    const bool there = edit->kind == VIEW_EDIT_LIGHT_THERE || edit->kind == VIEW_EDIT_DECAL_THERE;
    for (uint32_t i = edits->done; !there && i-- > 0 && edits->list[i].gesture == edit->gesture;) {
        struct view_edit *one = &edits->list[i];
        if (one->kind != edit->kind || one->id.index != edit->id.index || one->id.generation != edit->id.generation) continue;
        one->after = edit->after;
        return true;
    }
    if (edits->count == VIEW_EDITS) {
        memmove(edits->list, edits->list + 1, (VIEW_EDITS - 1) * sizeof *edits->list);
        edits->count--;
    }
    edits->list[edits->count++] = *edit;
    edits->done = edits->count;
    return true;
}

/* What can no longer be done, as its object is gone, is left out. */
bool view_edit_undo(struct view *v) {
    struct view_edits *edits = &v->select.edits;
    bool good = false;
    while (v->shown.scene && edits->done > 0 && (!good || edits->list[edits->done - 1].gesture == edits->list[edits->done].gesture))
        good |= applied(v, &edits->list[--edits->done], false);
    return good;
}

bool view_edit_redo(struct view *v) {
    struct view_edits *edits = &v->select.edits;
    bool good = false;
    while (v->shown.scene && edits->done < edits->count && (!good || edits->list[edits->done].gesture == edits->list[edits->done - 1].gesture))
        good |= applied(v, &edits->list[edits->done++], true);
    return good;
}
