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

static fnl_result add_shared(struct frame_state *f, const struct device_scene_frame *scene);
static fnl_result add_view(struct frame_state *f, struct gpu_view *out);
static fnl_result fade_lights(struct frame_state *f);
static void add_counters(struct frame_state *f);

/* Prepares a view before anything is drawn for it; `out` receives its camera. */
static fnl_result begin_view(struct frame_state *f, struct gpu_view *out) {
    TRY(add_view(f, out));
    TRY(decals_add_list(f));
    reflections_add_list(f);
    return fade_lights(f);
}

static void shade_view(struct frame_state *f) {
    const fnl_frame *frame = f->frame;
    shading_add(f);
    if (frame_shows_surfaces(frame))
        f->aov = aov_add(f->graph, &f->scene->geometry, &f->draws, f->view_address, frame->width, frame->height);
    if (frame->outputs & FNL_OUTPUT_OBJECT)
        f->objects = objects_add(f->graph, f->r->device, &f->scene->geometry, &f->draws, f->view_address, f->object_table, frame->width, frame->height);
}

static bool wants_color(const struct frame_state *f) { return f->target || (f->frame->outputs & FNL_OUTPUT_COLOR); }

/* One for all. */
static void expose(struct frame_state *views, uint32_t count) {
    graph_image radiance[MULTIVIEW_MOST] = {{0}}, depth[MULTIVIEW_MOST] = {{0}};
    const fnl_frame *frame = views->frame;
    if (frame->exposure != FNL_EXPOSURE_AUTO || !(wants_color(views) || frame->aa == FNL_ANTIALIASING_TAA)) return;
    for (uint32_t i = 0; i < count; i++) radiance[i] = views[i].radiance, depth[i] = views[i].depth;
    views->exposure = exposure_add(views->graph, radiance, depth, count);
    for (uint32_t i = 1; i < count; i++) views[i].exposure = views->exposure;
}

static void finish_view(struct frame_state *f) {
    temporal_add(f);
    if (wants_color(f)) frame_add_picture(f);
    if (f->target) frame_add_target(f);
    inspect_declare(f);
    frame_add_outputs(f);
    reflections_take_face(f);
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

/* Behind the eyes, which have been drawn: what is far away. */
static void draw_mono(struct frame_state *eyes, uint32_t count, struct frame_state *mono) {
    for (uint32_t i = 0; i < count; i++) {
        push_view(&eyes[i]);
        mono_open(&eyes[i]);
        pop_view(&eyes[i]);
    }
    push_view(mono);
    shading_draw(mono);
    mono->drawn = true;
    mono_open(mono);
    pop_view(mono);
}

/* What the eyes of a viewer share, with names for them all. */
static void finish_display(struct frame_state *views, uint32_t count) {
    struct graph *graph = views->graph;
    const bool has_mono = views->mono; /* views[count] */
    const char *name = graph_name(graph, "display %u", views->view_index / count);
    for (uint32_t i = 0; i < count; i++) {
        push_view(&views[i]);
        if (!views[i].drawn) shading_draw(&views[i]);
        views[i].drawn = true;
        pop_view(&views[i]);
    }
    if (has_mono) draw_mono(views, count, &views[count]);
    graph_push_names(graph, name);
    shadows_add_display(views, count + has_mono);
    graph_pop_names(graph);
    if (has_mono) {
        push_view(&views[count]);
        shading_add(&views[count]);
        pop_view(&views[count]);
    }
    for (uint32_t i = 0; i < count; i++) {
        push_view(&views[i]);
        shade_view(&views[i]);
        pop_view(&views[i]);
    }
    graph_push_names(graph, name);
    expose(views, count);
    graph_pop_names(graph);
}

/* Everything of a view before it is drawn, but culling. `frame` is its own. */
static fnl_result begin_one(struct frame_state *f, const struct frame_state *shared, const fnl_frame *frame, uint32_t index, const struct gpu_slice *cameras,
                            const struct device_scene_frame *scene) {
    *f = *shared;
    f->view_index = index;
    f->frame = frame;
    f->kept = &f->r->views.data[index];
    f->kept->scene = *scene;
    f->scene = &f->kept->scene;
    f->kept->numbers = (struct view_counters){0};
    f->view_address = cameras->address + index * sizeof(struct gpu_view);
    f->counts_offset = index * sizeof(struct frame_counts);
    f->named = frame_view_count(shared->frame) > 1;
    push_view(f);
    const fnl_result result = begin_view(f, (struct gpu_view *)cameras->data + index);
    pop_view(f);
    return result;
}

/* The view of what is far away from the eyes of a display, behind them in `views`. */
static fnl_result begin_mono(struct frame_state *views, uint32_t count, const struct frame_state *shared, fnl_frame *own, const struct gpu_slice *cameras,
                             const struct device_scene_frame *scene) {
    const uint32_t display = views->view_index / count, index = frame_view_count(shared->frame) + display;
    struct frame_state *f = &views[count];
    f->r = shared->r;
    f->r->views.data[index].stats = (fnl_frame_stats){0};
    f->r->views.data[index].temporal.valid = false;
    f->r->views.data[index].numbers = (struct view_counters){0};
    if (!mono_frame(shared->frame, display, own)) return FNL_OK;
    TRY(begin_one(f, shared, own, index, cameras, scene));
    f->eyes = views;
    f->eye_count = count;
    push_view(f);
    frame_cull(f);
    add_counters(f);
    pop_view(f);
    for (uint32_t i = 0; i < count; i++) views[i].mono = f;
    return FNL_OK;
}

static void finish_mono(struct frame_state *f) {
    push_view(f);
    frame_add_counts(f);
    frame_note_stats(f);
    pop_view(f);
}

/* Declares `count` views from `first` on; `at_once`: what needs no lists is drawn for all of them at once. */
static fnl_result declare_views(const struct frame_state *shared, uint32_t first, uint32_t count, bool at_once, const struct gpu_slice *cameras,
                                const struct device_scene_frame *scene) {
    const fnl_frame *frame = shared->frame;
    struct frame_display display = {0}, *shares = frame->stereo.eyes > 0 && count > 1 ? &display : NULL;
    struct frame_state views[DISPLAY_MOST];
    fnl_frame frames[DISPLAY_MOST];
    for (uint32_t i = 0; i < count; i++) {
        struct frame_state *f = &views[i];
        frames[i] = *frame;
        if (frame->view_count > 0) frames[i].camera = frame->views[first + i];
        frames[i].views = NULL;
        TRY(begin_one(f, shared, &frames[i], first + i, cameras, scene));
        f->display = shares;
        push_view(f);
        if (!shares) frame_cull(f);
        if (!shares) add_counters(f);
        pop_view(f);
    }
    if (shares) TRY(stereo_begin(views, count));
    for (uint32_t i = 0; i < count && shares; i++) {
        push_view(&views[i]);
        stereo_cull(&views[i]);
        add_counters(&views[i]);
        pop_view(&views[i]);
    }
    if (shares && frame_mono_count(frame)) TRY(begin_mono(views, count, shared, &frames[count], cameras, scene));
    const uint32_t together = MAX(at_once ? count : 1, shared->r->asking_together);
    if (together > 1) multiview_draw(views, count, together);
    if (shares) finish_display(views, count);
    for (uint32_t i = 0; i < count; i++) {
        push_view(&views[i]);
        if (!shares) {
            shade_view(&views[i]);
            expose(&views[i], 1);
        }
        finish_view(&views[i]);
        pop_view(&views[i]);
    }
    if (views->mono) finish_mono(&views[count]);
    return FNL_OK;
}

fnl_result frame_declare(fnl_renderer *r, const fnl_frame *frame, const struct frame_target *target) {
    struct frame_state shared = {.r = r, .frame = frame, .graph = r->graph, .drawn_lists = frame->lists, .target = target};
    struct device_scene_frame scene;
    uint32_t count = frame_view_count(frame);
    graph_begin(r->graph);
    multiview_tell(r, frame);
    r->vertex_queries = 0;
    TRY(device_scene_add(&r->scene_user, r->graph, &scene));
    TRY(add_shared(&shared, &scene));
    shadows_begin(&shared, &scene);
    struct gpu_slice cameras = gpu_frame_allocate(r->device, frame_camera_count(frame) * sizeof(struct gpu_view));
    if (!cameras.data) return gpu_status(r->device);
    for (uint32_t first = 0, together; first < count; first += together) {
        const uint32_t at_once = multiview_count(r, frame, first);
        together = frame->view_count > 0 && frame->stereo.eyes > 0 ? frame->stereo.eyes : at_once;
        TRY(declare_views(&shared, first, together, at_once > 1, &cameras, &scene));
    }
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
    if (scene->lights.environment.table.id) environment_tell(f->r->device, &f->shared);
    memcpy(slice.data, &f->shared, sizeof f->shared);
    if (scene->lights.environment.table.id) environment_put(f->graph, &scene->lights.environment, slice.data);
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
    f->scene->lights.view = f->view_address;
    f->scene->lights.width = f->frame->width;
    f->scene->lights.height = f->frame->height;
    return FNL_OK;
}

static fnl_result fade_lights(struct frame_state *f) {
    struct device_scene_user *user = &f->r->scene_user;
    float lod = f->frame->light_lod;
    TRY(device_lights_fade(user, &f->view, lod, lists_cull_on_cpu(f->frame->lists)));
    f->whole_lights = f->scene->lights;
    if (lod > 0) light_fade_add(f->graph, &f->scene->lights, &user->faded_lights, &user->faded_bounds, lod);
    return FNL_OK;
}

static void add_counters(struct frame_state *f) {
    if (!f->frame->count_lights && !shading_shows_volumes(f->frame)) return;
    f->counters = f->frame->count_lights
                      ? graph_import_buffer(f->graph, "light counters", &f->kept->counters)
                      : graph_create_buffer(f->graph, "light counters", 4 * light_counter_count(f->frame));
    graph_add_clear(f->graph, "clear counters", GRAPH_QUEUE_GRAPHICS, (struct graph_clear){.buffers = {f->counters}});
}
