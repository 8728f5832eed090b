/* SPDX-License-Identifier: MIT */
#include "render/shadows.h"

#include "render/shadows/contact.h"
#include "render/shadows/maps.h"
#include "render/shadows/method.h"
#include "render/step.h"
#include "scene/light_kinds.h"

/* ---- what finds them ---- */

/* Whether a light without shadow maps casts shadows. */
static bool find_mapless(const fnl_scene *scene) {
    for (uint32_t i = 0; i < scene->lights.count; i++) {
        const fnl_light_params *light = &scene->lights.data[i].params;
        if (light->casts_shadows && !light_kinds[light->kind].has_maps) return true;
    }
    return false;
}

/* Whether rays find some shadows: those of lights without maps, and of any light where the atlas may not hold the coarsest pages of all; or are compared
   with maps. */
static bool has_traced(const fnl_renderer *r, const fnl_frame *frame) {
    if (shadows_have(frame, SHADOWS_RAYS) || !shadow_maps_possible(r, frame) || frame->debug == FNL_DEBUG_SHADOW_ERRORS) return true;
    const uint64_t cells = shadow_maps_side(frame) / SHADOW_PAGE, smallest = SHADOW_PAGE / SHADOW_UNIT;
    return r->shadows.mapless || shadow_maps_rows(r) * SHADOW_FACES > cells * cells * smallest * smallest;
}

/* Whether rays go through the device's own structures. `auto` walks the trees on the CPU, where no hardware helps. */
static bool queries(const fnl_renderer *r, const fnl_frame *frame) {
    const fnl_device_info *info = gpu_info(r->device);
    if (shadows_have(frame, SHADOWS_TREES)) return false; /* the trees know what moves, and what is a wall */
    if (!info->ray_query || r->device_scene->item_count > RAY_QUERY_MOST_ITEMS) return false;
    return frame->shadow.ray_backend == FNL_RAY_BACKEND_RAY_QUERY ||
           (frame->shadow.ray_backend == FNL_RAY_BACKEND_AUTO && info->type != FNL_DEVICE_CPU);
}

static struct device_rays_use rays_use_of(const fnl_renderer *r, const fnl_frame *frame) {
    const bool traces = has_traced(r, frame), query = traces && queries(r, frame);
    return (struct device_rays_use){.trees = traces && !query, .query = query, .items = shadow_maps_possible(r, frame)};
}

/* Once for each renderer. */
static void tell_of_rays(fnl_renderer *r) {
    if (r->notes.shadow_rays) return;
    r->notes.shadow_rays = true;
    if (!gpu_info(r->device)->clip_distances)
        log_warning(&r->host, "shadows: this device has no clip_distances, which maps need: rays find all shadows");
    else
        log_warning(&r->host, "shadows: the scene has %u local and %u directional lights, more than may have maps: rays find all shadows",
                    r->scene->light_slot_end, r->scene->suns.count);
}

static void tell_of_trees(fnl_renderer *r) {
    if (r->notes.shadow_trees) return;
    r->notes.shadow_trees = true;
    if (!gpu_info(r->device)->ray_query)
        log_warning(&r->host, "shadows: this device has no ray_query, which shadow.ray-backend=ray-query needs: rays go through bounding volume hierarchies");
    else
        log_warning(&r->host, "shadows: the scene has %u items, more than ray queries can number: rays go through bounding volume hierarchies",
                    r->device_scene->item_count);
}

bool shadows_timed(const fnl_frame *frame) {
    const struct shadow_method *method = shadow_method(frame->shadows);
    return method->timed && method->timed(frame);
}

static fnl_result prepare(fnl_renderer *r, const fnl_frame *frame) {
    if (frame->shadows == FNL_SHADOWS_OFF) return FNL_OK;
    if (r->shadows.mapless_version != r->scene->light_version + 1) r->shadows.mapless = find_mapless(r->scene);
    r->shadows.mapless_version = r->scene->light_version + 1;
    const struct device_rays_use use = rays_use_of(r, frame);
    if (use.trees && frame->shadow.ray_backend == FNL_RAY_BACKEND_RAY_QUERY) tell_of_trees(r);
    if (shadows_have(frame, SHADOWS_MAPS) && shadow_maps_rows(r) > 0 && !shadow_maps_possible(r, frame)) tell_of_rays(r);
    TRY(device_rays_prepare(r->device_scene, use));
    const struct shadow_method *method = shadow_method(frame->shadows);
    if (method->prepare) TRY(method->prepare(r, frame));
    return shadows_prepare_view(r, frame, &r->views.data[0]);
}

fnl_result shadows_prepare_view(fnl_renderer *r, const fnl_frame *frame, struct renderer_view *view) {
    const struct shadow_method *method = shadow_method(frame->shadows);
    return method->prepare_view ? method->prepare_view(r, frame, view) : FNL_OK;
}

static fnl_result begin_frame(struct frame_state *shared) {
    if (shared->frame->shadows == FNL_SHADOWS_OFF) return FNL_OK;
    const struct device_rays_use use = rays_use_of(shared->r, shared->frame);
    graph_set_role(shared->graph, GRAPH_ROLE_SHADOWS);
    shared->shadows.rays = device_rays_add(shared->r->device_scene, shared->graph, &shared->scene->geometry, use);
    if (use.trees || use.query) shared->lighting.shadows.rays = shared->shadows.rays;
    const struct shadow_method *method = shadow_method(shared->frame->shadows);
    if (method->begin) method->begin(shared);
    if (shared->frame->shadow.samples > 1) shared->lighting.shadows.bits |= GPU_LIGHTING_SOFT;
    if (shared->frame->shadow.filter != FNL_SHADOW_FILTER_HARD) shared->lighting.shadows.bits |= GPU_LIGHTING_FILTERED;
    return FNL_OK;
}

/* ---- auto ---- */

enum { FEW_LIGHTS = 4, FILTERED_LIGHTS = 8 };

void shadows_settle(const fnl_renderer *r, fnl_frame *frame) {
    const fnl_scene *scene = r->scene;
    const fnl_device_info *info = gpu_info(r->device);
    const uint32_t count = scene->suns.count + scene->light_slots.count - scene->free_light_slots.count;
    if (count == 0 && shadows_have(frame, SHADOWS_MAPS) && frame->debug == FNL_DEBUG_NONE) frame->shadows = FNL_SHADOWS_OFF; /* without a pass, or code in shaders */
    if (frame->shadow.filter == FNL_SHADOW_FILTER_AUTO) frame->shadow.filter = count <= FILTERED_LIGHTS ? FNL_SHADOW_FILTER_PCF : FNL_SHADOW_FILTER_HARD;
    if (frame->shadows != FNL_SHADOWS_AUTO) return;
    const bool moves = r->lights.moving_frames > 0 || (r->frame_number > 0 && r->lights.version != scene->light_version);
    frame->shadows = FNL_SHADOWS_MAPS;
    if (count == 0)
        frame->shadows = FNL_SHADOWS_OFF;
    else if (!shadow_maps_possible(r, frame) || (count <= FEW_LIGHTS && info->ray_query && info->type != FNL_DEVICE_CPU))
        frame->shadows = FNL_SHADOWS_RAYS;
    else if (moves && scene->lights.count > 0)
        frame->shadows = FNL_SHADOWS_HYBRID;
}

/* The first view has what all share. */
static void note_structures(struct frame_state *f) {
    const struct device_structures *s = &f->r->device_scene->structures;
    if (!f->shadows.rays.top.id) return;
    const bool first = f->view_index == 0;
    counters_note(f, "shadows.instances", s->frame.instances);
    counters_note(f, "shadows.structures-built", first ? s->frame.built + s->frame.placed : 0);
    counters_note(f, "shadows.structures-refitted", first ? s->frame.updated : 0);
    counters_note(f, "shadows.structures-compacted", first ? s->frame.compacted : 0);
    counters_note(f, "shadows.structure-bytes", gpu_memory_stats(f->r->device).structure_bytes);
}

/* The shadow maps of the views, before the lists that use them. The eyes of a display share the maps of the first. */
static void begin_light(struct frame_state *views, uint32_t count) {
    const struct shadow_method *method = shadow_method(views->frame->shadows);
    for (uint32_t i = 0; i < count; i++) {
        note_structures(&views[i]);
        if (method->begin_view) method->begin_view(&views[i]);
    }
    graph_set_role(views->graph, GRAPH_ROLE_SHADOWS);
    if (method->add) method->add(views, count);
    for (uint32_t i = 0; i < count; i++) shadow_contact_add(&views[i]);
}

/* ---- numbers ---- */

/* One of those that follow the counts of pixels. */
static bool find_at(const struct counted *counted, uint64_t place, uint64_t *value) {
    const struct renderer_view *view = counted->view;
    *value = ((const uint32_t *)view->counters.mapped)[view->counter_count - LIGHT_COUNTERS_MORE + place];
    return counted->r->frame.shadows != FNL_SHADOWS_OFF;
}
static bool find_rays(const struct counted *counted, uint64_t *value) { return find_at(counted, LIGHT_COUNTER_RAYS, value); }
static bool find_rays_passed(const struct counted *counted, uint64_t *value) { return find_at(counted, LIGHT_COUNTER_RAYS_PASSED, value); }
static bool find_filtered_at(const struct counted *counted, uint64_t place, uint64_t *value) {
    const fnl_frame *frame = &counted->r->frame;
    return find_at(counted, place, value) && shadows_have(frame, SHADOWS_MAPS) && frame->shadow.filter != FNL_SHADOW_FILTER_HARD;
}
static bool find_filtered(const struct counted *counted, uint64_t *value) { return find_filtered_at(counted, LIGHT_COUNTER_FILTERED, value); }
static bool find_settled(const struct counted *counted, uint64_t *value) { return find_filtered_at(counted, LIGHT_COUNTER_SETTLED, value); }

static const struct counter rows[] = {
    {"shadows.rays", "rays", "shadow rays that surfaces send", .find = find_rays, .needs = "count-lights"},
    {"shadows.rays-passed", "rays", "of them, those that find at least half of their light", .find = find_rays_passed, .needs = "count-lights"},
    {"shadows.filtered", "points", "shadow map lookups that are filtered: one for each light of a surface point", .find = find_filtered, .needs = "count-lights"},
    {"shadows.settled", "points", "of them, those that ended after the first points: entirely lit or entirely in shadow", .find = find_settled, .needs = "count-lights"},
    {"shadows.instances", "items", "items in the device's acceleration structure, with ray queries", NOTED},
    {"shadows.structures-built", "structures", "acceleration structures built in this frame: of meshes, and one of the instances when any has moved", NOTED},
    {"shadows.structures-refitted", "structures", "of meshes that deform, adapted to this frame's vertices without being built anew", NOTED},
    {"shadows.structures-compacted", "structures", "of meshes, made smaller in this frame", NOTED},
    {"shadows.structure-bytes", "bytes", "memory of all acceleration structures on the device", NOTED},
};
static const struct counter_table counters_shadows = COUNTER_TABLE(rows);

/* ---- the step ---- */

/* The rows of all methods are called, whatever the frame uses, except for `check`. */

static void init(fnl_renderer *r) {
    for (int i = 0; i < FNL_SHADOWS_AUTO; i++)
        if (shadow_method((fnl_shadows)i)->init) shadow_method((fnl_shadows)i)->init(r);
}

static fnl_result check(const struct call *call, fnl_renderer *r, const fnl_frame *frame) {
    const struct shadow_method *method = shadow_method(frame->shadows);
    return method->check ? method->check(call, r, frame) : FNL_OK;
}

static void counted(fnl_renderer *r, uint32_t slot) {
    for (int i = 0; i < FNL_SHADOWS_AUTO; i++)
        if (shadow_method((fnl_shadows)i)->counted) shadow_method((fnl_shadows)i)->counted(r, slot);
}

static void submitted(fnl_renderer *r, const fnl_frame *frame) {
    for (int i = 0; i < FNL_SHADOWS_AUTO; i++)
        if (shadow_method((fnl_shadows)i)->submitted) shadow_method((fnl_shadows)i)->submitted(r, frame);
}

static void forget(fnl_renderer *r) {
    for (int i = 0; i < FNL_SHADOWS_AUTO; i++)
        if (shadow_method((fnl_shadows)i)->forget) shadow_method((fnl_shadows)i)->forget(r);
}

static void grow(fnl_renderer *r, const struct frame_counts *counts) {
    for (int i = 0; i < FNL_SHADOWS_AUTO; i++)
        if (shadow_method((fnl_shadows)i)->grow) shadow_method((fnl_shadows)i)->grow(r, counts);
}

static void destroy(fnl_renderer *r) {
    for (int i = 0; i < FNL_SHADOWS_AUTO; i++)
        if (shadow_method((fnl_shadows)i)->destroy) shadow_method((fnl_shadows)i)->destroy(r);
}

const struct frame_step step_shadows = {.name = "shadows",
                                        .init = init,
                                        .check = check,
                                        .prepare = prepare,
                                        .begin_frame = begin_frame,
                                        .begin_light = begin_light,
                                        .counted = counted,
                                        .submitted = submitted,
                                        .forget = forget,
                                        .grow = grow,
                                        .destroy = destroy,
                                        .counters = &counters_shadows};
