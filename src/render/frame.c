/* SPDX-License-Identifier: MIT */
/** The whole frame, in order. Read it as a table of contents; docs/overview.md tells the same story in words. */
#include "passes/lights/sprites.h"
#include "passes/post/post.h"
#include "render/decals.h"
#include "render/frame_steps.h"
#include "render/inspect.h"
#include "render/mono.h"
#include "render/multiview.h"
#include "render/reflections.h"
#include "render/shading.h"
#include "render/shadows.h"
#include "render/stereo.h"
#include "render/temporal.h"

static fnl_result add_shared(struct frame_state *f, const struct device_scene_frame *scene);
static fnl_result add_view(struct frame_state *f, struct gpu_view *out);
static fnl_result fade_lights(struct frame_state *f);
static void add_counters(struct frame_state *f);

/* Prepares a view before anything is drawn for it; `out` receives its camera. */
static fnl_result begin_view(struct frame_state *f, struct gpu_view *out) {
    TRY(add_view(f, out));
    graph_set_role(f->graph, GRAPH_ROLE_SHADING);
    TRY(decals_add_list(f));
    reflections_add_list(f);
    graph_set_role(f->graph, GRAPH_ROLE_LISTS);
    return fade_lights(f);
}

static void shade_view(struct frame_state *f) {
    const fnl_frame *frame = f->frame;
    shading_add(f);
    graph_set_role(f->graph, GRAPH_ROLE_REST);
    if (frame_shows_surfaces(frame))
        f->aov = aov_add(f->graph, &f->scene->geometry, &f->draws, f->view_address, frame->width, frame->height);
    if (frame->outputs & FNL_OUTPUT_OBJECT)
        f->objects = objects_add(f->graph, f->r->device, &f->scene->geometry, &f->draws, f->view_address, f->object_table, frame->width, frame->height);
}

static bool wants_color(const struct frame_state *f) { return f->target || (f->frame->outputs & FNL_OUTPUT_COLOR); }

/* One for all. */
static void expose(struct frame_state *views, uint32_t count) {
    graph_set_role(views->graph, GRAPH_ROLE_REST);
    graph_image radiance[GROUP_MOST] = {{0}}, depth[GROUP_MOST] = {{0}};
    const fnl_frame *frame = views->frame;
    if (frame->exposure != FNL_EXPOSURE_AUTO || !(wants_color(views) || frame->aa == FNL_ANTIALIASING_TAA)) return;
    for (uint32_t i = 0; i < count; i++) radiance[i] = views[i].radiance, depth[i] = views[i].depth;
    views->exposure = exposure_add(views->graph, radiance, depth, count);
    for (uint32_t i = 1; i < count; i++) views[i].exposure = views->exposure;
}

static void finish_view(struct frame_state *f) {
    graph_set_role(f->graph, GRAPH_ROLE_REST);
    temporal_add(f);
    if (wants_color(f)) frame_add_picture(f);
    if (f->target) frame_add_target(f);
    inspect_declare(f);
    reflections_take_face(f);
    graph_set_role(f->graph, GRAPH_ROLE_READ);
    frame_add_outputs(f);
    frame_add_counts(f);
    frame_note_stats(f);
    temporal_end(f);
}

static void push_view(const struct frame_state *f) {
    if (f->named) graph_push_names(f->graph, graph_name(f->graph, "view %u", f->view_index));
}

static void pop_view(const struct frame_state *f) {
    if (f->named) graph_pop_names(f->graph);
}

/* ---- groups of views ---- */

/* The views of a group while it is declared: `count` views, then the mono view if there is one. */
struct group_state {
    const struct view_group *group;
    struct frame_display display;
    struct frame_state views[GROUP_MOST + GROUP_FAR];
    fnl_frame frames[GROUP_MOST + GROUP_FAR]; /* of each its own */
};

/* What all views of a frame have. */
struct frame_parts {
    struct frame_state shared;
    struct device_scene_frame scene;
    struct gpu_slice cameras;
};

/* Everything of a view before it is drawn, but culling. */
static fnl_result begin_one(struct group_state *g, uint32_t i, const struct frame_parts *parts, uint32_t index) {
    struct frame_state *f = &g->views[i];
    *f = parts->shared;
    f->view_index = index;
    f->frame = &g->frames[i];
    f->kept = &f->r->views.data[index];
    f->kept->scene = parts->scene;
    f->scene = &f->kept->scene;
    f->kept->numbers = (struct view_counters){0};
    f->view_address = parts->cameras.address + index * sizeof(struct gpu_view);
    f->counts_offset = index * sizeof(struct frame_counts);
    f->named = frame_view_count(parts->shared.frame) > 1;
    f->display = g->group->is_display && i < g->group->count ? &g->display : NULL;
    push_view(f);
    const fnl_result result = begin_view(f, (struct gpu_view *)parts->cameras.data + index);
    pop_view(f);
    return result;
}

static fnl_result begin_views(struct group_state *g, const struct frame_parts *parts) {
    const fnl_frame *frame = parts->shared.frame;
    for (uint32_t i = 0; i < g->group->count; i++) {
        struct frame_state *f = &g->views[i];
        g->frames[i] = *frame;
        if (frame->view_count > 0) g->frames[i].camera = frame->views[g->group->first + i];
        g->frames[i].views = NULL;
        TRY(begin_one(g, i, parts, g->group->first + i));
        if (f->display) continue;
        push_view(f);
        frame_cull(f);
        add_counters(f);
        pop_view(f);
    }
    if (!g->group->is_display) return FNL_OK;
    graph_set_role(g->views->graph, GRAPH_ROLE_GEOMETRY);
    TRY(stereo_begin(g->views, g->group->count));
    for (uint32_t i = 0; i < g->group->count; i++) {
        push_view(&g->views[i]);
        graph_set_role(g->views->graph, GRAPH_ROLE_GEOMETRY);
        stereo_cull(&g->views[i]);
        add_counters(&g->views[i]);
        pop_view(&g->views[i]);
    }
    return FNL_OK;
}

/* The mono view's slot stays empty if the eyes diverge too far. */
static fnl_result begin_far(struct group_state *g, const struct frame_parts *parts) {
    const uint32_t count = g->group->count, index = g->group->far_index;
    struct renderer_view *kept = &parts->shared.r->views.data[index];
    struct frame_state *f = &g->views[count];
    kept->stats = (fnl_frame_stats){0};
    kept->temporal.valid = false;
    kept->numbers = (struct view_counters){0};
    if (!g->group->has_far) return FNL_OK;
    mono_frame(parts->shared.frame, g->group, &g->frames[count]);
    TRY(begin_one(g, count, parts, index));
    f->eyes = g->views;
    f->eye_count = count;
    push_view(f);
    frame_cull(f);
    add_counters(f);
    pop_view(f);
    for (uint32_t i = 0; i < count; i++) g->views[i].mono = f;
    return FNL_OK;
}

/* Draws the eyes, then the mono view behind their reopened depth. */
static void draw_display(struct group_state *g) {
    const uint32_t count = g->group->count;
    for (uint32_t i = 0; i < count; i++) {
        struct frame_state *f = &g->views[i];
        push_view(f);
        if (!f->drawn) shading_draw(f);
        f->drawn = true;
        pop_view(f);
    }
    for (uint32_t i = 0; i < count && g->group->has_far; i++) {
        push_view(&g->views[i]);
        mono_open(&g->views[i]);
        pop_view(&g->views[i]);
    }
    if (!g->group->has_far) return;
    struct frame_state *far = &g->views[count];
    push_view(far);
    shading_draw(far);
    far->drawn = true;
    mono_open(far);
    pop_view(far);
}

/* Shades the mono view, then the eyes over it; one exposure. */
static void shade_display(struct group_state *g) {
    struct graph *graph = g->views->graph;
    const uint32_t count = g->group->count;
    const char *name = graph_name(graph, "display %u", g->group->first / count);
    graph_push_names(graph, name);
    shadows_add_display(g->views, count + g->group->has_far);
    graph_pop_names(graph);
    if (g->group->has_far) {
        push_view(&g->views[count]);
        shading_add(&g->views[count]);
        pop_view(&g->views[count]);
    }
    for (uint32_t i = 0; i < count; i++) {
        push_view(&g->views[i]);
        shade_view(&g->views[i]);
        pop_view(&g->views[i]);
    }
    graph_push_names(graph, name);
    expose(g->views, count);
    graph_pop_names(graph);
}

static fnl_result declare_group(const struct frame_parts *parts, const struct view_group *group) {
    struct group_state g;
    g.group = group;
    g.display = (struct frame_display){0};
    TRY(begin_views(&g, parts));
    if (group->is_display && frame_far_count(parts->shared.frame)) TRY(begin_far(&g, parts));
    if (group->together > 1) multiview_draw(g.views, group);
    if (group->is_display) {
        draw_display(&g);
        shade_display(&g);
    }
    /* Views that share only drawing finish one by one, so only their drawing targets are alive at once. */
    for (uint32_t i = 0; i < group->count; i++) {
        struct frame_state *f = &g.views[i];
        push_view(f);
        if (!group->is_display) {
            shade_view(f);
            expose(f, 1);
        }
        finish_view(f);
        pop_view(f);
    }
    if (!group->has_far) return FNL_OK;
    push_view(&g.views[group->count]);
    graph_set_role(g.views->graph, GRAPH_ROLE_READ);
    frame_add_counts(&g.views[group->count]);
    frame_note_stats(&g.views[group->count]);
    pop_view(&g.views[group->count]);
    return FNL_OK;
}

fnl_result frame_declare(fnl_renderer *r, const fnl_frame *frame, const struct view_plan *plan, const struct frame_target *target) {
    struct frame_parts parts = {.shared = {.r = r, .frame = frame, .graph = r->graph, .drawn_lists = frame->lists, .target = target}};
    graph_begin(r->graph);
    multiview_tell(r, frame, plan->path);
    r->stereo.vertex_queries = 0;
    graph_set_role(r->graph, GRAPH_ROLE_GEOMETRY);
    TRY(device_scene_add(&r->scene_user, r->graph, &parts.scene));
    graph_set_role(r->graph, GRAPH_ROLE_REST);
    TRY(add_shared(&parts.shared, &parts.scene));
    parts.shared.lighting = (struct lighting){.lights = parts.scene.lights, .layered = parts.scene.layered, .environment = parts.scene.environment};
    shadows_begin(&parts.shared, &parts.scene);
    parts.cameras = gpu_frame_allocate(r->device, plan->camera_count * sizeof(struct gpu_view));
    if (!parts.cameras.data) return gpu_status(r->device);
    for (uint32_t i = 0; i < plan->group_count; i++) TRY(declare_group(&parts, &plan->groups[i]));
    return graph_compile(r->graph);
}

/* ---- the steps that are short ---- */

static fnl_result name_objects(struct frame_state *f) {
    const struct device_scene *d = f->r->device_scene;
    struct gpu_slice slice = gpu_frame_allocate(f->r->device, d->item_count * sizeof(struct device_object));
    if (!slice.data) return gpu_status(f->r->device);
    f->object_table = slice.address;
    return device_items_name(d, slice.data);
}

static fnl_result add_shared(struct frame_state *f, const struct device_scene_frame *scene) {
    const struct scene_environment *environment = &f->r->scene->environment;
    f->shared = (struct gpu_frame){.ambient_sky = f->r->scene->ambient_sky,
                                   .ambient_ground = f->r->scene->ambient_ground,
                                   .shade_cost = f->frame->shade_cost,
                                   .shadow_filter = (uint32_t)f->frame->shadow.filter,
                                   .shadow_samples = f->frame->shadow.samples,
                                   .light_radius = f->frame->shadow.light_radius,
                                   .environment_scale = scene_environment_scale(environment) * environment->unit,
                                   .sun_tangent = tanf(f->frame->shadow.sun_degrees * (PI / 180)),
                                   .hdr_max = shading_format(f) == VK_FORMAT_R32G32B32A32_SFLOAT ? FLT_MAX : 65504.0f};
    scene_environment_axes(environment, f->shared.environment_rows);
    shading_begin(f);
    struct gpu_slice slice = gpu_frame_allocate(f->r->device, sizeof f->shared);
    if (!slice.data) return gpu_status(f->r->device);
    if (scene->environment.table.id) environment_tell(f->r->device, &f->shared);
    memcpy(slice.data, &f->shared, sizeof f->shared);
    if (scene->environment.table.id) environment_put(f->graph, &scene->environment, slice.data);
    f->shared_address = slice.address;
    TRY(decals_send(f));
    return f->frame->outputs & FNL_OUTPUT_OBJECT ? name_objects(f) : FNL_OK;
}

/* `out` is the view's place among those of the frame. */
static fnl_result add_view(struct frame_state *f, struct gpu_view *out) {
    fnl_camera camera = frame_camera(f);
    temporal_begin(f);
    camera.shift.x -= 2 * f->temporal.jitter.x / (float)f->frame->width;
    camera.shift.y += 2 * f->temporal.jitter.y / (float)f->frame->height;
    f->view = view_from_camera(&camera, f->frame->width, f->frame->height);
    f->view.samples = f->frame->msaa;
    f->view.turn = MAX(f->temporal.index, f->temporal.sequence) % 64;
    f->view.frame = f->shared_address;
    if (f->frame->hidden_areas) f->hidden = hidden_area_send(f->r->device, &f->frame->hidden_areas[f->view_index], &f->temporal.view);
    TRY(decals_begin(f));
    TRY(reflections_begin(f));
    *out = f->view;
    f->lighting.view = f->view_address;
    return FNL_OK;
}

static fnl_result fade_lights(struct frame_state *f) {
    struct device_scene_user *user = &f->r->scene_user;
    float lod = f->frame->light_lod;
    TRY(device_lights_fade(user, &f->view, lod, lists_cull_on_cpu(f->frame->lists)));
    f->whole_lights = f->lighting.lights;
    if (lod > 0) light_fade_add(f->graph, f->r->device, f->view_address, &f->lighting.lights, &user->faded_lights, &user->faded_bounds, lod);
    return FNL_OK;
}

static void add_counters(struct frame_state *f) {
    graph_set_role(f->graph, GRAPH_ROLE_REST);
    if (!f->frame->count_lights && !shading_shows_volumes(f->frame)) return;
    f->counters = f->frame->count_lights
                      ? graph_import_buffer(f->graph, "light counters", &f->kept->counters)
                      : graph_create_buffer(f->graph, "light counters", 4 * light_counter_count(f->frame));
    graph_add_clear(f->graph, "clear counters", GRAPH_QUEUE_GRAPHICS, (struct graph_clear){.buffers = {f->counters}});
}
