/* SPDX-License-Identifier: MIT */
/** The whole frame, in order. Read it as a table of contents; docs/overview.md tells the same story in words. */
#include "render/frame_steps.h"
#include "render/mono.h"
#include "render/multiview.h"
#include "render/shading.h"
#include "render/step.h"
#include "render/stereo.h"
#include "render/temporal.h"

static fnl_result send_constants(struct frame_state *shared);
static void add_camera(struct frame_state *f);
static void add_counters(struct frame_state *f);

static void push_view(const struct frame_state *f) {
    if (f->named) graph_push_names(f->graph, graph_name(f->graph, "view %u", f->view_index));
}

static void pop_view(const struct frame_state *f) {
    if (f->named) graph_pop_names(f->graph);
}

/* ---- groups of views ---- */

/* What all views of a frame share. */
struct frame_parts {
    struct frame_state shared;
    struct device_scene_frame scene;
    struct gpu_slice cameras;
};

/* The views of a group while it is declared: `count` views, then the mono view if there is one. */
struct group_state {
    const struct view_group *group;
    struct frame_display display;
    struct frame_state views[GROUP_MOST + GROUP_FAR];
    fnl_frame frames[GROUP_MOST + GROUP_FAR]; /* of each its own */
};

/* Everything of a view before it is drawn, but culling. */
static fnl_result begin_view(struct group_state *g, uint32_t i, const struct frame_parts *parts, uint32_t index) {
    struct frame_state *f = &g->views[i];
    *f = parts->shared;
    f->view_index = index;
    f->frame = &g->frames[i];
    f->kept = &f->input->views[index];
    f->made = &f->input->made[index];
    f->made->scene = parts->scene;
    f->scene = &f->made->scene;
    f->view_address = parts->cameras.address + index * sizeof(struct gpu_view);
    f->counts_offset = index * counters_size();
    f->named = frame_view_count(parts->shared.frame) > 1;
    f->group.display = g->group->is_display && i < g->group->count ? &g->display : NULL;
    push_view(f);
    add_camera(f);
    const fnl_result result = steps_begin_view(f);
    memcpy((struct gpu_view *)parts->cameras.data + index, &f->view, sizeof f->view);
    pop_view(f);
    return result;
}

static void cull_view(struct frame_state *f) {
    push_view(f);
    if (f->group.display)
        stereo_cull(f);
    else
        frame_cull(f);
    add_counters(f);
    pop_view(f);
}

static fnl_result begin_views(struct group_state *g, const struct frame_parts *parts) {
    const fnl_frame *frame = parts->shared.frame;
    for (uint32_t i = 0; i < g->group->count; i++) {
        g->frames[i] = *frame;
        if (frame->view_count > 0) g->frames[i].camera = frame->views[g->group->first + i];
        g->frames[i].views = NULL;
        TRY(begin_view(g, i, parts, g->group->first + i));
        if (!g->group->is_display) cull_view(&g->views[i]);
    }
    if (!g->group->is_display) return FNL_OK;
    TRY(stereo_begin(g->views, g->group->count));
    for (uint32_t i = 0; i < g->group->count; i++) cull_view(&g->views[i]);
    return FNL_OK;
}

/* The mono view's slot stays empty if the eyes diverge too far. */
static fnl_result begin_far(struct group_state *g, const struct frame_parts *parts) {
    const uint32_t count = g->group->count;
    struct frame_state *f = &g->views[count];
    if (!g->group->has_far) return FNL_OK;
    mono_frame(parts->shared.frame, g->group, &g->frames[count]);
    TRY(begin_view(g, count, parts, g->group->far_index));
    f->group.eyes = g->views;
    f->group.eye_count = count;
    cull_view(f);
    for (uint32_t i = 0; i < count; i++) g->views[i].group.mono = f;
    return FNL_OK;
}

/* Declares something under the names of the view. */
static void add_named(struct frame_state *f, void (*add)(struct frame_state *f)) {
    push_view(f);
    add(f);
    pop_view(f);
}

/* Draws the eyes, then the mono view behind their reopened depth; lights it first, then the eyes over it. */
static void add_display(struct group_state *g) {
    const uint32_t count = g->group->count, far_count = g->group->has_far;
    struct frame_state *views = g->views, *far = &g->views[count];
    const char *name = graph_name(views->graph, "display %u", g->group->first / count);
    for (uint32_t i = 0; i < count && g->group->together == 1; i++) add_named(&views[i], shading_draw);
    for (uint32_t i = 0; i < count && far_count; i++) add_named(&views[i], mono_open);
    if (far_count) add_named(far, shading_draw);
    if (far_count) add_named(far, mono_open);
    graph_push_names(views->graph, name);
    steps_begin_light(views, count + far_count);
    graph_pop_names(views->graph);
    if (far_count) add_named(far, steps_light_view);
    for (uint32_t i = 0; i < count; i++) add_named(&views[i], steps_light_view);
    graph_push_names(views->graph, name);
    steps_end_light(views, count);
    graph_pop_names(views->graph);
    for (uint32_t i = 0; i < count; i++) add_named(&views[i], steps_finish_view);
    if (far_count) add_named(far, outputs_add_counts);
}

static void add_alone(struct frame_state *f, bool is_drawn) {
    push_view(f);
    if (!is_drawn) shading_draw(f);
    steps_begin_light(f, 1);
    steps_light_view(f);
    steps_end_light(f, 1);
    steps_finish_view(f);
    pop_view(f);
}

/* Views that share only drawing are lit and finished one by one, so only their drawing targets are alive at once. */
static fnl_result add_group(const struct frame_parts *parts, const struct view_group *group) {
    struct group_state g;
    g.group = group;
    g.display = (struct frame_display){0};
    TRY(begin_views(&g, parts));
    if (group->is_display && frame_far_count(parts->shared.frame)) TRY(begin_far(&g, parts));
    if (group->together > 1) multiview_draw(g.views, group);
    if (group->is_display) add_display(&g);
    for (uint32_t i = 0; i < group->count && !group->is_display; i++) add_alone(&g.views[i], group->together > 1);
    return FNL_OK;
}

fnl_result frame_declare(const fnl_renderer *r, const struct frame_input *input) {
    const fnl_frame *frame = input->frame;
    struct frame_common common = {0};
    struct frame_parts parts = {.shared = {.r = r, .input = input, .common = &common, .frame = frame, .graph = input->graph}};
    struct frame_state *shared = &parts.shared;
    shared->scene = &parts.scene;
    shared->lists.drawn = frame->lists;
    memset(input->made, 0, input->plan->camera_count * sizeof *input->made);
    graph_begin(input->graph);
    multiview_tell(shared, input->plan->path);
    graph_set_role(input->graph, GRAPH_ROLE_GEOMETRY);
    TRY(device_scene_add(input->user, input->graph, &parts.scene));
    shared->lighting = (struct lighting){.lights = parts.scene.lights, .layered = parts.scene.layered, .environment = parts.scene.environment};
    shared->lighting.environment.conserving = frame->energy == FNL_ENERGY_CONSERVING;
    graph_set_role(input->graph, GRAPH_ROLE_REST);
    TRY(send_constants(shared));
    TRY(steps_begin_frame(shared));
    parts.cameras = gpu_frame_allocate(r->device, input->plan->camera_count * sizeof(struct gpu_view));
    if (!parts.cameras.data) return gpu_status(r->device);
    for (uint32_t i = 0; i < input->plan->group_count; i++) TRY(add_group(&parts, &input->plan->groups[i]));
    return graph_compile(input->graph);
}

/* ---- what belongs to no step ---- */

static fnl_result send_constants(struct frame_state *shared) {
    const struct scene_environment *environment = &shared->r->scene->environment;
    const struct environment_light *maps = &shared->scene->environment;
    shared->shared = (struct gpu_frame){.ambient_sky = shared->r->scene->ambient_sky,
                                        .ambient_ground = shared->r->scene->ambient_ground,
                                        .shade_cost = shared->frame->shade_cost,
                                        .shadow_filter = (uint32_t)shared->frame->shadow.filter,
                                        .shadow_samples = shared->frame->shadow.samples,
                                        .light_radius = shared->frame->shadow.light_radius,
                                        .environment_scale = scene_environment_scale(environment) * environment->unit,
                                        .sun_tangent = tanf(shared->frame->shadow.sun_degrees * (PI / 180)),
                                        .hdr_max = shading_format(shared) == VK_FORMAT_R32G32B32A32_SFLOAT ? FLT_MAX : 65504.0f};
    scene_environment_axes(environment, shared->shared.environment_rows);
    shading_begin(shared);
    struct gpu_slice slice = gpu_frame_allocate(shared->r->device, sizeof shared->shared);
    if (!slice.data) return gpu_status(shared->r->device);
    if (maps->table.id) environment_tell(shared->r->device, &shared->shared);
    memcpy(slice.data, &shared->shared, sizeof shared->shared);
    if (maps->table.id) environment_put(shared->graph, maps, slice.data);
    shared->shared_address = slice.address;
    return FNL_OK;
}

static void add_camera(struct frame_state *f) {
    fnl_camera camera = frame_camera(f);
    temporal_begin(f);
    camera.shift.x -= 2 * f->temporal.jitter.x / (float)f->frame->width;
    camera.shift.y += 2 * f->temporal.jitter.y / (float)f->frame->height;
    f->view = view_from_camera(&camera, f->frame->width, f->frame->height);
    f->view.samples = f->frame->msaa;
    f->view.turn = MAX(f->temporal.index, f->temporal.sequence) % 64;
    f->view.frame = f->shared_address;
    f->lighting.view = f->view_address;
    if (f->frame->hidden_areas) f->hidden = hidden_area_send(f->r->device, &f->frame->hidden_areas[f->view_index], &f->temporal.view);
}

static void add_counters(struct frame_state *f) {
    graph_set_role(f->graph, GRAPH_ROLE_REST);
    if (!f->frame->count_lights && !shading_shows_volumes(f->frame)) return;
    f->counters = f->frame->count_lights
                      ? graph_import_buffer(f->graph, "light counters", &f->kept->counters)
                      : graph_create_buffer(f->graph, "light counters", 4 * light_counter_count(f->frame));
    graph_add_clear(f->graph, "clear counters", GRAPH_QUEUE_GRAPHICS, (struct graph_clear){.buffers = {f->counters}});
}
