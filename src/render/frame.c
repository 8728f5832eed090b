/* SPDX-License-Identifier: MIT */
/** The whole frame, in order. Read it as a table of contents; docs/overview.md tells the same story in words. */
#include "passes/lights/sprites.h"
#include "passes/post/post.h"
#include "render/decals.h"
#include "render/frame_steps.h"
#include "render/shading.h"

static fnl_result add_shared(struct frame_state *f);
static fnl_result add_view(struct frame_state *f, struct gpu_view *out);
static fnl_result fade_lights(struct frame_state *f);
static void add_counters(struct frame_state *f);

/* Everything of one view; `out` is where its camera is sent to. */
static fnl_result declare_view(struct frame_state *f, struct gpu_view *out) {
    const fnl_frame *frame = f->frame;
    TRY(add_view(f, out));
    TRY(decals_add_list(f));
    TRY(fade_lights(f));
    frame_cull(f);
    add_counters(f);
    shading_add(f);
    if (frame_shows_surfaces(frame))
        f->aov = aov_add(f->graph, &f->scene->geometry, &f->draws, f->view_address, frame->width, frame->height);
    bool wants_color = f->target || (frame->outputs & FNL_OUTPUT_COLOR);
    if (frame->exposure == FNL_EXPOSURE_AUTO && (wants_color || frame->aa == FNL_ANTIALIASING_TAA))
        f->exposure = exposure_add(f->graph, f->radiance);
    temporal_add(f);
    if (wants_color) frame_add_picture(f);
    if (f->target) frame_add_target(f);
    frame_add_outputs(f);
    frame_add_counts(f);
    frame_note_stats(f);
    temporal_end(f);
    return FNL_OK;
}

fnl_result frame_declare(fnl_renderer *r, const fnl_frame *frame, const struct frame_target *target) {
    struct frame_state shared = {.r = r, .frame = frame, .graph = r->graph, .drawn_lists = frame->lists, .target = target};
    struct device_scene_frame scene;
    uint32_t count = frame_view_count(frame);
    graph_begin(r->graph);
    TRY(device_scene_add(&r->device_scene, r->graph, &scene));
    TRY(add_shared(&shared));
    struct gpu_slice cameras = gpu_frame_allocate(r->device, count * sizeof(struct gpu_view));
    if (!cameras.data) return gpu_status(r->device);
    for (uint32_t i = 0; i < count; i++) {
        fnl_frame own = *frame;
        if (frame->view_count > 0) own.camera = frame->views[i];
        own.views = NULL;
        struct frame_state f = shared;
        f.frame = &own;
        f.view_index = i;
        f.kept = &r->views.data[i];
        f.kept->scene = scene;
        f.scene = &f.kept->scene;
        f.view_address = cameras.address + i * sizeof(struct gpu_view);
        f.counts_offset = i * sizeof(struct frame_counts);
        if (count > 1) graph_push_names(r->graph, graph_name(r->graph, "view %u", i));
        TRY(declare_view(&f, (struct gpu_view *)cameras.data + i));
        if (count > 1) graph_pop_names(r->graph);
    }
    return graph_compile(r->graph);
}

/* ---- the steps that are short ---- */

static fnl_result add_shared(struct frame_state *f) {
    f->shared = (struct gpu_frame){.ambient_sky = f->r->scene->ambient_sky,
                                   .ambient_ground = f->r->scene->ambient_ground,
                                   .shade_cost = f->frame->shade_cost,
                                   .hdr_max = shading_format(f) == VK_FORMAT_R32G32B32A32_SFLOAT ? FLT_MAX : 65504.0f};
    shading_begin(f);
    struct gpu_slice slice = gpu_frame_allocate(f->r->device, sizeof f->shared);
    if (!slice.data) return gpu_status(f->r->device);
    memcpy(slice.data, &f->shared, sizeof f->shared);
    f->shared_address = slice.address;
    return decals_send(f);
}

/* `out` is the view's place among those of the frame. */
static fnl_result add_view(struct frame_state *f, struct gpu_view *out) {
    fnl_camera camera = f->frame->camera;
    temporal_begin(f);
    camera.shift.x -= 2 * f->temporal.jitter.x / (float)f->frame->width;
    camera.shift.y += 2 * f->temporal.jitter.y / (float)f->frame->height;
    f->view = view_from_camera(&camera, f->frame->width, f->frame->height);
    f->view.samples = f->frame->msaa;
    f->view.frame = f->shared_address;
    TRY(decals_begin(f));
    *out = f->view;
    f->scene->lights.view = f->view_address;
    f->scene->lights.width = f->frame->width;
    f->scene->lights.height = f->frame->height;
    return FNL_OK;
}

static fnl_result fade_lights(struct frame_state *f) {
    struct device_scene *d = &f->r->device_scene;
    float lod = f->frame->light_lod;
    TRY(device_lights_fade(d, &f->view, lod, lists_cull_on_cpu(f->frame->lists)));
    f->whole_lights = f->scene->lights;
    if (lod > 0) light_fade_add(f->graph, &f->scene->lights, &d->faded_lights, lod);
    return FNL_OK;
}

static void add_counters(struct frame_state *f) {
    if (!f->frame->count_lights && !shading_shows_volumes(f->frame)) return;
    f->counters = f->frame->count_lights
                      ? graph_import_buffer(f->graph, "light counters", &f->kept->counters)
                      : graph_create_buffer(f->graph, "light counters", f->frame->width * f->frame->height * 8ull + 4);
    graph_add_clear(f->graph, "clear counters", GRAPH_QUEUE_GRAPHICS, (struct graph_clear){.buffers = {f->counters}});
}
