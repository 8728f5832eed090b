/* SPDX-License-Identifier: MIT */
#include "base/check.h"
#include "fanal/vulkan.h"
#include "passes/aa/taa.h"
#include "render/inspect.h"
#include "render/mono.h"
#include "render/multiview.h"
#include "render/overlay.h"
#include "render/reflections.h"
#include "render/shading.h"
#include "render/shadows.h"
#include "render/step.h"
#include "render/temporal.h"
#include "render/stereo.h"

/* ---- auto ---- */

enum { MOVING_FRAMES = 60 }; /* for which lights count as moving after a change of any */

static void load_choices(fnl_renderer *r) {
    struct file_view file;
    if (!gpu_cache_load(r->device, "choices", &file)) return;
    chooser_parse(&r->choice.chooser, (const char *)file.data, file.size);
    file_free(&r->host, &file);
}

static void save_choices(fnl_renderer *r) {
    if (!r->choice.chooser.memory_changed) return;
    r->choice.chooser.memory_changed = false;
    size_t size = chooser_print(&r->choice.chooser, NULL, 0);
    char *text = host_allocate(&r->host, size + 1);
    if (!text) return;
    chooser_print(&r->choice.chooser, text, size + 1);
    gpu_cache_save(r->device, "choices", text, size);
    host_free(&r->host, text, size + 1);
}

void renderer_choose(fnl_renderer *r, fnl_frame *frame) {
    const struct device_scene *d = r->device_scene;
    if (r->lights.version != d->scene->light_version && r->frame_number > 0)
        r->lights.moving_frames = MOVING_FRAMES;
    else if (r->lights.moving_frames > 0)
        r->lights.moving_frames--;
    r->lights.version = d->scene->light_version;
    r->choice.asked = (struct choice){frame->shading, frame->lists};
    if (frame->shading != FNL_SHADING_AUTO && frame->lists != FNL_LISTS_AUTO) {
        r->choice.chooser.last = CHOOSER_CANDIDATES;
        r->choice.measures = false;
        return;
    }
    uint64_t item_step = 0; /* a few objects more or less are the same scene */
    for (uint32_t count = d->item_count; count; count >>= 1) item_step++;
    const uint64_t parts[] = {item_step, d->buckets.count};
    const fnl_camera *camera = &frame->camera;
    struct choice_case at = {.asked = {frame->shading, frame->lists},
                             .scene = hash_bytes(parts, sizeof parts, HASH_SEED),
                             .light_count = device_lights_count(d),
                             .msaa = frame->msaa,
                             .pixel_count = (uint64_t)frame->width * frame->height,
                             .depth_first = frame->gbuffer.prepass,
                             .close = frame->choose_close && gpu_info(r->device)->primitive_ids,
                             .moves = r->lights.moving_frames > 0,
                             .eye = camera->position,
                             .forward = vec3_normalize(vec3_sub(camera->target, camera->position)),
                             .scene_size = box_is_empty(&d->bounds) ? 1 : vec3_distance(d->bounds.low, d->bounds.high)};
    /* Counting and asking for a pixel slow a frame down, and without its textures it is faster than it will be. */
    r->choice.measures = !frame->pin_choice && !frame->count_lights && !frame->pixel.asked && d->images_coming == 0;
    struct gpu_pipeline_stats pipelines = gpu_pipeline_stats(r->device);
    struct chooser_background background = {pipelines.asked, pipelines.done};
    struct choice choice = chooser_pick(&r->choice.chooser, &at, r->choice.measures, background);
    frame->shading = choice.shading;
    frame->lists = choice.lists;
}

/* The chooser's next candidate is made ready, one in a frame; the very first frame has pipelines of its own to make. */
static fnl_result prepare_candidate(fnl_renderer *r, const fnl_frame *frame, const struct frame_target *target) {
    struct choice choice;
    uint64_t ticket;
    if (!r->choice.measures || r->frame_number == 0 || !chooser_asks(&r->choice.chooser, &choice)) return FNL_OK;
    fnl_frame candidate = *frame;
    candidate.shading = choice.shading;
    candidate.lists = choice.lists;
    TRY(renderer_ask_pipelines(r, &candidate, target, &ticket));
    chooser_asked(&r->choice.chooser, ticket);
    return FNL_OK;
}

/* Whether the chooser wants the time of the frame: of a candidate's turn, and after a decision of those that are timed anyway. */
static bool wants_time(const fnl_renderer *r, const fnl_frame *frame) {
    return r->choice.measures &&
           (r->choice.chooser.last < CHOOSER_CANDIDATES || (frame->timers && r->choice.chooser.state == CHOOSER_DECIDED));
}

/* Hands the chooser the times that have come in. */
static void feed_chooser(fnl_renderer *r) {
    for (uint64_t wanted; (wanted = chooser_wants(&r->choice.chooser)) && wanted + GPU_FRAMES_IN_FLIGHT <= r->frame_number;) {
        const struct graph_timer *timers;
        uint32_t count;
        double sum = -1, left_out = 0;
        if (graph_query_timers(r->graph, wanted, &timers, &count) && count > 0) {
            sum = 0;
            for (uint32_t i = 0; i < count; i++) {
                sum += timers[i].milliseconds;
                if (!chooser_counts(&r->choice.asked, graph_pass_role(timers[i].role))) left_out += timers[i].milliseconds;
            }
        }
        chooser_feed(&r->choice.chooser, sum, left_out);
    }
    save_choices(r);
}

fnl_vec2 fnl_jitter(uint32_t index) { return pixel_jitter(index); }

/* ---- life ---- */

static fnl_result prepare_views(fnl_renderer *r, uint32_t count) {
    if (!array_reserve(&r->host, &r->views, count) || !array_reserve(&r->host, &r->lists.views, count) || !array_reserve(&r->host, &r->making, count))
        return FNL_ERROR_MEMORY;
    while (r->views.count < count) {
        r->views.data[r->views.count++] = (struct renderer_view){0};
        lists_init(&r->lists.views.data[r->lists.views.count++], &r->host);
    }
    return FNL_OK;
}

fnl_result fnl_renderer_create(fnl_device *device, fnl_scene *scene, fnl_renderer **out) {
    TRY(check_handle(__func__, "device", device));
    const fnl_host *host = gpu_host(device);
    TRY(check_pointer(CALL(host), "out", out));
    *out = NULL;
    TRY(check_pointer(CALL(host), "scene", scene));
    fnl_renderer *r = host_allocate_zero(host, sizeof *r);
    if (!r) return FNL_ERROR_MEMORY;
    r->host = *host;
    r->device = device;
    r->scene = scene;
    steps_init(r);
    load_choices(r);
    fnl_result result = prepare_views(r, 1);
    if (result == FNL_OK) result = device_scene_open(device, scene, &r->scene_user);
    r->device_scene = r->scene_user.scene;
    if (result == FNL_OK) result = graph_create(&r->host, device, &r->graph);
    for (uint32_t i = 0; i < GPU_FRAMES_IN_FLIGHT && result == FNL_OK; i++)
        result = gpu_buffer_create(device, "frame counts", counters_size(), GPU_MEMORY_READBACK, &r->slots.counts[i]);
    if (result != FNL_OK) fnl_renderer_destroy(&r);
    *out = r;
    return result;
}

void fnl_renderer_destroy(fnl_renderer **handle) {
    fnl_renderer *r = handle ? *handle : NULL;
    if (!r) return;
    gpu_wait_idle(r->device);
    chooser_keep(&r->choice.chooser);
    r->choice.chooser.memory_changed |= r->choice.chooser.trial_count > 0;
    save_choices(r);
    graph_destroy(&r->graph);
    graph_destroy(&r->dry.graph);
    device_scene_close(&r->scene_user);
    steps_destroy(r);
    for (uint32_t i = 0; i < r->views.count; i++) {
        struct renderer_view *view = &r->views.data[i];
        gpu_buffer_destroy(r->device, &view->draws);
        gpu_buffer_destroy(r->device, &view->counters);
    }
    for (uint32_t i = 0; i < OUTPUT_COUNT; i++) gpu_buffer_destroy(r->device, &r->outputs.pictures[i]);
    for (uint32_t i = 0; i < GPU_FRAMES_IN_FLIGHT; i++) gpu_buffer_destroy(r->device, &r->slots.counts[i]);
    array_free(&r->host, &r->views);
    array_free(&r->host, &r->last);
    array_free(&r->host, &r->making);
    array_free(&r->host, &r->counted_buckets);
    array_free(&r->host, &r->handed.view_stats);
    array_free(&r->host, &r->handed.counters);
    array_free(&r->host, &r->handed.pass_times);
    gpu_wait_idle(r->device); /* nothing is in flight: this frees device memory at once */
    fnl_host host = r->host;
    host_free(&host, r->tests, sizeof *r->tests);
    host_free(&host, r, sizeof *r);
    *handle = NULL;
}

/* ---- one frame ---- */

static fnl_result keep_buffer(fnl_renderer *r, struct gpu_buffer *buffer, const char *name, uint64_t size) {
    if (buffer->size >= size) return FNL_OK;
    gpu_buffer_destroy(r->device, buffer);
    return gpu_buffer_create(r->device, name, size, GPU_MEMORY_READBACK, buffer);
}

static fnl_result keep_buckets(fnl_renderer *r) {
    const uint32_t count = r->device_scene->buckets.count;
    if (!array_reserve(&r->host, &r->counted_buckets, count)) return FNL_ERROR_MEMORY;
    if (count) memcpy(r->counted_buckets.data, r->device_scene->buckets.data, count * sizeof *r->counted_buckets.data);
    r->counted_buckets.count = count;
    return FNL_OK;
}

static fnl_result prepare_buffers(fnl_renderer *r, const fnl_frame *frame, const struct view_plan *plan) {
    uint32_t views = frame_view_count(frame), cameras = plan->camera_count;
    TRY(prepare_views(r, cameras));
    const uint32_t step = MAX(frame->stereo.eyes, 1u); /* eyes share the maps of their first view */
    for (uint32_t i = step; i < views; i += step) TRY(shadows_prepare_view(r, frame, &r->views.data[i]));
    for (uint32_t i = 0; i < OUTPUT_COUNT; i++)
        if (frame->outputs & 1u << i)
            TRY(keep_buffer(r, &r->outputs.pictures[i], "output", views * renderer_picture_size(frame, i)));
    for (uint32_t i = 0; i < cameras && frame->count_lights; i++) {
        struct renderer_view *view = &r->views.data[i];
        fnl_frame own = *frame;
        if (i >= views) mono_frame(frame, &plan->groups[i - views], &own);
        view->counter_count = light_counter_count(&own);
        TRY(keep_buffer(r, &view->counters, "light counters", 4 * view->counter_count));
        TRY(keep_buffer(r, &view->draws, "draws", MAX(r->device_scene->group_count, 1u) * sizeof(struct gpu_draw)));
    }
    TRY(inspect_prepare(r, frame));
    return frame->count_lights ? keep_buckets(r) : FNL_OK;
}

/* Inside the frame: takes what the last one in this slot has counted, and clears the place for what this one will. */
static fnl_result prepare_counts(fnl_renderer *r, const fnl_frame *frame, uint32_t slot) {
    for (uint32_t i = 0; i < r->slots.views[slot]; i++) steps_grow(r, renderer_counts(r, slot, i));
    steps_counted(r, slot);
    r->slots.views[slot] = 0;
    uint64_t size = frame_camera_count(frame) * counters_size();
    TRY(keep_buffer(r, &r->slots.counts[slot], "frame counts", size));
    memset(r->slots.counts[slot].mapped, 0, size);
    return FNL_OK;
}

fnl_result renderer_prepare(fnl_renderer *r, fnl_frame *frame) {
    r->scene_user.wants_previous = temporal_needs_motion(frame);
    const fnl_camera head = frame->viewer ? *frame->viewer : stereo_head_camera(frame);
    scene_choose_levels(r->scene, &head);
    r->device_scene->conserves |= frame->energy == FNL_ENERGY_CONSERVING;
    TRY(device_scene_prepare(r->device_scene));
    frame->occlusion = frame_choose_occlusion(r, frame);
    renderer_choose(r, frame);
    return steps_prepare(r, frame);
}

/* When the parts of a frame were over, seconds. */
struct frame_times {
    double begun, updated, waited, asked, declared;
};

static void note_sections(fnl_renderer *r, const struct frame_times *at, double now) {
    const struct graph_stats graph = graph_query_stats(r->graph);
    const double execute = graph.place_milliseconds + graph.record_milliseconds + graph.submit_milliseconds;
    const fnl_cpu_section sections[] = {
        {.name = "update the scene", .milliseconds = (at->updated - at->begun) * 1e3},
        {.name = "wait for the GPU", .milliseconds = (at->waited - at->updated) * 1e3}, /* the frame before the last is over */
        {.name = "prepare", .milliseconds = (at->asked - at->waited) * 1e3}, /* pools by what earlier frames counted; the pipelines of a candidate of auto */
        {.name = "declare passes", .milliseconds = (at->declared - at->asked) * 1e3 - graph.compile_milliseconds},
        {.name = "compile the graph", .milliseconds = graph.compile_milliseconds},
        {.name = "place resources", .milliseconds = graph.place_milliseconds},
        {.name = "record", .milliseconds = graph.record_milliseconds},
        {.name = "submit", .milliseconds = graph.submit_milliseconds},
        {.name = "clean up", .milliseconds = (now - at->declared) * 1e3 - execute}};
    _Static_assert(COUNT_OF(sections) == RENDERER_CPU_SECTIONS, "a place for each");
    double begin = 0;
    for (r->handed.cpu_section_count = 0; r->handed.cpu_section_count < COUNT_OF(sections); r->handed.cpu_section_count++) {
        fnl_cpu_section *section = &r->handed.cpu_sections[r->handed.cpu_section_count];
        *section = sections[r->handed.cpu_section_count];
        section->milliseconds = MAX(section->milliseconds, 0.0);
        section->begin_milliseconds = begin;
        begin += section->milliseconds;
    }
    r->handed.cpu_milliseconds = (now - at->waited) * 1e3;
}

/* The declared frame becomes the last one; the next frame reuses the memory of the one before. */
static void take_made(fnl_renderer *r) {
    struct view_made *data = r->last.data;
    const uint32_t capacity = r->last.capacity;
    r->last.data = r->making.data;
    r->last.capacity = r->making.capacity;
    r->making.data = data;
    r->making.capacity = capacity;
}

static fnl_result make_frame(fnl_renderer *r, fnl_frame *frame, const struct frame_target *target,
                             const struct gpu_external_semaphores *external, double begun) {
    struct frame_times at = {.begun = begun};
    TRY(renderer_prepare(r, frame));
    struct view_plan plan;
    multiview_plan(r, frame, &plan);
    TRY(prepare_buffers(r, frame, &plan));
    at.updated = time_now();
    TRY(gpu_frame_begin(r->device));
    at.waited = time_now();
    const uint64_t late = gpu_pipeline_stats(r->device).late;
    uint32_t slot = gpu_frame_slot(r->device);
    fnl_result result = prepare_counts(r, frame, slot);
    if (result == FNL_OK) result = prepare_candidate(r, frame, target);
    at.asked = time_now(); /* what comes next is the frame's own */
    const struct frame_input input = {.frame = frame,
                                      .plan = &plan,
                                      .target = target,
                                      .graph = r->graph,
                                      .views = r->views.data,
                                      .outputs = &r->outputs,
                                      .made = r->making.data,
                                      .user = &r->scene_user,
                                      .shared_lists = &r->lists.shared,
                                      .lists = r->lists.views.data,
                                      .notes = &r->notes};
    if (result == FNL_OK) result = frame_declare(r, &input);
    at.declared = time_now();
    if (result != FNL_OK) {
        gpu_frame_end(r->device, NULL, 0, NULL);
        return result;
    }
    bool timed = wants_time(r, frame);
    struct graph_execute_params execute = {.record_threads = frame->record_threads,
                                           .timers = frame->timers || timed || shadows_timed(frame),
                                           .force_async_on_graphics = renderer_tests(r).force_async,
                                           .poison = renderer_tests(r).poison,
                                           .external = external};
    TRY(graph_execute_frame(r->graph, &execute));
    device_scene_submitted(&r->scene_user);
    take_made(r);
    r->frame = *frame;
    r->frame.views = NULL;
    r->frame.hidden_areas = NULL;
    r->frame.viewer = NULL;
    r->frame.gaze = NULL;
    r->frame.overlay = NULL;
    r->frame_number = gpu_frame_number(r->device);
    if (timed) chooser_note(&r->choice.chooser, r->frame_number, (time_now() - at.asked) * 1e3);
    feed_chooser(r);
    steps_submitted(r, frame);
    r->frame_slot = slot;
    r->slots.views[slot] = frame_camera_count(frame);
    r->slots.frames[slot] = r->frame_number;
    r->pipelines_made = (uint32_t)(gpu_pipeline_stats(r->device).late - late);
    for (uint32_t i = r->slots.views[slot]; i < r->views.count; i++) r->views.data[i].temporal.valid = false;
    note_sections(r, &at, time_now());
    return FNL_OK;
}

void renderer_forget(fnl_renderer *r) { steps_forget(r); }

void renderer_settle_views(fnl_frame *frame) {
    if (frame->view_count == 1 && frame->views) {
        frame->camera = frame->views[0];
        frame->view_count = 0;
    }
    if (frame->view_count == 0 && !frame->hidden_areas) return;
    if (frame->shading == FNL_SHADING_AUTO) frame->shading = FNL_SHADING_DEFERRED;
    if (frame->lists == FNL_LISTS_AUTO) frame->lists = FNL_LISTS_CLUSTERED;
}

static void say_nothing(void *user, fnl_log_level level, const char *line) { UNUSED(user), UNUSED(level), UNUSED(line); }

/* 4 samples where nothing refuses them, or would be done in another way with them. */
static void settle_samples(fnl_renderer *r, fnl_frame *frame) {
    if (frame->msaa == FNL_MSAA_AUTO) {
        fnl_host silent = r->host;
        silent.log = say_nothing;
        fnl_frame tried = *frame;
        tried.msaa = 4;
        if (tried.aa == FNL_ANTIALIASING_AUTO) tried.aa = FNL_ANTIALIASING_NONE;
        frame->msaa = frame->decals != FNL_DECALS_GBUFFER && frame_check(CALL(&silent), r, &tried) == FNL_OK ? 4 : 1;
    }
    if (frame->aa == FNL_ANTIALIASING_AUTO) frame->aa = frame->msaa > 1 ? FNL_ANTIALIASING_NONE : FNL_ANTIALIASING_SMAA;
}

fnl_result renderer_settle(fnl_renderer *r, fnl_frame *frame) {
    TRY(scene_set_stage(r->scene, frame->studio, frame->ground));
    scene_follow_reach(r->scene);
    renderer_settle_views(frame);
    shadows_settle(r, frame);
    settle_samples(r, frame);
    return FNL_OK;
}

static fnl_result render(const struct call *call, fnl_renderer *r, const fnl_frame *given, const struct frame_target *target,
                         const struct gpu_external_semaphores *external) {
    const double begun = time_now();
    fnl_frame frame = given ? *given : fnl_frame_default();
    TRY(renderer_settle(r, &frame));
    TRY(frame_check(call, r, &frame));
    fnl_result result = overlay_prepare(r, &frame);
    if (result == FNL_OK) result = reflections_capture(r, &frame);
    if (result == FNL_OK) result = make_frame(r, &frame, target, external, begun);
    if (result != FNL_OK) {
        r->frame_number = 0; /* buffers may have changed without a frame to fill them */
        renderer_forget(r);
    }
    return result;
}

fnl_result fnl_renderer_render(fnl_renderer *r, const fnl_frame *frame) {
    TRY(check_handle(__func__, "renderer", r));
    return render(CALL(&r->host), r, frame, NULL, NULL);
}

fnl_result renderer_check_target(const struct call *call, VkFormat format) {
    static const VkFormat formats[] = {VK_FORMAT_R8G8B8A8_UNORM,      VK_FORMAT_R8G8B8A8_SRGB,
                                       VK_FORMAT_B8G8R8A8_UNORM,      VK_FORMAT_B8G8R8A8_SRGB,
                                       VK_FORMAT_R16G16B16A16_SFLOAT, VK_FORMAT_R32G32B32A32_SFLOAT,
                                       VK_FORMAT_A2B10G10R10_UNORM_PACK32, VK_FORMAT_A2R10G10B10_UNORM_PACK32};
    for (uint32_t i = 0; i < COUNT_OF(formats); i++)
        if (formats[i] == format) return FNL_OK;
    return unsupported(call, "the target image has format %d, which is none of those that fnl_vulkan_target lists",
                       (int)format);
}

static fnl_result check_part(const struct call *call, const struct gpu_image *image, fnl_vulkan_part *part) {
    const uint32_t width = image->params.width, height = image->params.height;
    if (part->width == 0 && part->height == 0 && part->x == 0 && part->y == 0) {
        part->width = width;
        part->height = height;
    }
    if (part->width == 0 || part->height == 0 || part->x >= width || part->y >= height || part->width > width - part->x || part->height > height - part->y)
        return misuse(call, "target.part is %u x %u pixels at %u, %u, must be inside of the image, which has %u x %u", part->width, part->height, part->x,
                      part->y, width, height);
    return FNL_OK;
}

fnl_result fnl_renderer_render_to(fnl_renderer *r, const fnl_frame *given, const fnl_vulkan_target *target) {
    TRY(check_handle(__func__, "renderer", r));
    const struct call *call = CALL(&r->host);
    TRY(check_pointer(call, "target", target));
    if (target->image == VK_NULL_HANDLE) return misuse(call, "image is VK_NULL_HANDLE");
    if (target->final_layout == VK_IMAGE_LAYOUT_UNDEFINED || target->final_layout == VK_IMAGE_LAYOUT_PREINITIALIZED)
        return misuse(call, "final_layout is %d, must not be UNDEFINED or PREINITIALIZED", (int)target->final_layout);
    fnl_frame frame = given ? *given : fnl_frame_default();
    frame.outputs &= ~(uint32_t)FNL_OUTPUT_COLOR; /* the picture goes into the target */
    TRY(check_count(call, "frame.width", frame.width, 1, 16384)); /* the image has its size */
    TRY(check_count(call, "frame.height", frame.height, 1, 16384));
    TRY(check_count(call, "frame.view_count", frame.view_count, 0, FNL_VIEWS_MAX));
    const bool sized = target->width || target->height;
    TRY(check_count(call, "width", target->width, sized, 16384));
    TRY(check_count(call, "height", target->height, sized, 16384));
    struct gpu_image_params params = {.name = "target",
                                      .format = target->format,
                                      .width = sized ? target->width : frame.width,
                                      .height = sized ? target->height : frame.height,
                                      .layers = frame_view_count(&frame),
                                      .mips = 1,
                                      .samples = 1,
                                      .usage = VK_IMAGE_USAGE_TRANSFER_DST_BIT};
    TRY(renderer_check_target(call, target->format));
    struct gpu_image image = {.params = params};
    struct gpu_image_params depth_params = params;
    depth_params.name = "target depth";
    depth_params.format = GEOMETRY_DEPTH_FORMAT;
    struct gpu_image depth;
    struct frame_target frame_target = {.image = &image,
                                        .initial_layout = target->initial_layout,
                                        .final_layout = target->final_layout,
                                        .part = target->part,
                                        .depth_initial_layout = target->depth_initial_layout,
                                        .depth_final_layout = target->depth_final_layout,
                                        .depth_forward = target->depth_forward};
    TRY(check_part(call, &image, &frame_target.part));
    const struct gpu_extent size = frame_target_size(&frame_target);
    if (frame.view_count > 1 && (size.width != frame.width || size.height != frame.height))
        return unsupported(call, "frames of several views are not scaled: the target must have the frame's size");
    if (target->depth && (target->depth_final_layout == VK_IMAGE_LAYOUT_UNDEFINED || target->depth_final_layout == VK_IMAGE_LAYOUT_PREINITIALIZED))
        return misuse(call, "depth_final_layout is %d, must not be UNDEFINED or PREINITIALIZED", (int)target->depth_final_layout);
    if (target->depth && (size.width != frame.width || size.height != frame.height))
        return unsupported(call, "depth is not scaled: the target must have the frame's size");
    TRY(gpu_image_import(r->device, target->image, &params, &image));
    frame_target.image = &image;
    fnl_result result = target->depth ? gpu_image_import(r->device, target->depth, &depth_params, &depth) : FNL_OK;
    if (target->depth) frame_target.depth = &depth;
    struct gpu_external_semaphores external = {target->wait, target->signal, target->wait_value, target->signal_value};
    if (result == FNL_OK) result = render(call, r, &frame, &frame_target, &external);
    gpu_image_destroy(r->device, &image);
    if (target->depth) gpu_image_destroy(r->device, &depth);
    return result;
}
