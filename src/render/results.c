/* SPDX-License-Identifier: MIT */
/** What the last frame made: pictures and numbers. */
#include "base/check.h"
#include "render/frame_steps.h"
#include "render/shading.h"
#include "render/step.h"

uint64_t renderer_picture_size(const fnl_frame *frame, uint32_t bit) {
    return (uint64_t)frame->width * frame->height * (bit == 0 ? 4 : 16);
}

fnl_result fnl_renderer_read(fnl_renderer *r, fnl_output output, fnl_image *out) {
    TRY(check_handle(__func__, "renderer", r));
    TRY(check_pointer(CALL(&r->host), "out", out));
    *out = (fnl_image){0};
    uint32_t bit = 0;
    while (bit < OUTPUT_COUNT && output != (fnl_output)(1u << bit)) bit++;
    const struct call *call = CALL(&r->host);
    if (bit == OUTPUT_COUNT) return misuse(call, "output is %d, must be one value of fnl_output", (int)output);
    if (r->frame_number == 0) return misuse(call, "no frame has been rendered");
    if (!(r->frame.outputs & (uint32_t)output))
        return misuse(call, "output is %d, but the last frame kept %u (fnl_frame.outputs)", (int)output, r->frame.outputs);
    TRY(gpu_frame_wait(r->device, r->frame_number));
    uint32_t views = frame_view_count(&r->frame);
    size_t size = (size_t)renderer_picture_size(&r->frame, bit) * views;
    void *pixels = host_allocate(&r->host, size);
    if (!pixels) return FNL_ERROR_MEMORY;
    memcpy(pixels, r->outputs.pictures[bit].mapped, size);
    *out =
        (fnl_image){r->frame.width, r->frame.height * views, bit == 0 ? FNL_PIXEL_FORMAT_RGBA8 : FNL_PIXEL_FORMAT_RGBA32F, pixels};
    return FNL_OK;
}

fnl_result fnl_renderer_query_done(fnl_renderer *r, bool *out) {
    TRY(check_handle(__func__, "renderer", r));
    TRY(check_pointer(CALL(&r->host), "out", out));
    return gpu_frame_done(r->device, r->frame_number, out);
}

static void sum_evaluations(const fnl_renderer *r, const struct renderer_view *view, fnl_frame_stats *s) {
    const uint32_t *counters = view->counters.mapped;
    uint64_t pixels = (view->counter_count - LIGHT_COUNTERS_MORE) / 2;
    for (uint64_t i = 0; i < pixels; i++) {
        s->evaluations += counters[2 * i];
        s->evaluations_useful += counters[2 * i + 1];
        s->max_per_pixel = MAX(s->max_per_pixel, counters[2 * i]);
    }
    s->unserved_points = counters[2 * pixels];
    s->mean_per_pixel = (double)s->evaluations / (double)pixels;
    s->evaluations_counted = true;
    const struct gpu_draw *draws = view->draws.mapped;
    for (uint32_t b = 0; b < r->counted_buckets.count; b++) {
        const struct geometry_bucket *bucket = &r->counted_buckets.data[b];
        if (bucket->topology != VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST) continue;
        for (uint32_t i = 0; i < bucket->group_count; i++) {
            const struct gpu_draw *draw = &draws[bucket->first_group + i];
            s->triangles_visible += (uint64_t)draw->index_count / 3 * draw->instance_count;
        }
    }
}

/* The numbers of one view. */
static void query_view(const fnl_renderer *r, const struct counted *counted, fnl_frame_stats *out) {
    const struct frame_counts *counts = counted->counts;
    const struct view_made *made = counted->made;
    const struct lists_counts *lists = COUNTS(counts, lists);
    const struct culling_counts *culling = COUNTS(counts, culling);
    *out = made->stats;
    struct light_totals lights = made->totals_known ? made->known_totals : lists->lights;
    out->lights_in_view = lights.in_view + made->scene.lights.directional_count;
    out->list_entries = (uint64_t)lights.entries + lists->blend_lights.entries;
    out->overflow_cells = lights.overflow_cells + lists->blend_lights.overflow_cells;
    out->list_used_bytes = made->fixed_bytes + lights.entries * (uint64_t)made->entry_bytes +
                           lists->blend_lights.entries * (uint64_t)made->blend_entry_bytes;
    out->items_visible = culling->visible_items;
    const uint32_t *reasons = culling->clusters.reasons;
    uint64_t *const triangles[] = {[CLUSTERS_DRAWN] = &out->triangles_drawn,
                                   [CLUSTERS_OUTSIDE] = &out->triangles_outside,
                                   [CLUSTERS_BACK] = &out->triangles_back,
                                   [CLUSTERS_SMALL] = &out->triangles_small,
                                   [CLUSTERS_OCCLUDED] = &out->triangles_occluded};
    for (uint32_t i = 0; i < COUNT_OF(triangles); i++) *triangles[i] = reasons[2 * i] | (uint64_t)reasons[2 * i + 1] << 32;
    out->clusters_drawn = culling->clusters.clusters_drawn;
    out->items_occluded = culling->hidden_items;
    out->items_whole = culling->clusters.whole_items;
    if (r->frame.exposure == FNL_EXPOSURE_AUTO) out->ev = COUNTS(counts, exposure)->metered[1];
    if (r->frame.count_lights) sum_evaluations(r, counted->view, out);
}

/* Those of the whole frame. */
static fnl_result query_frame(fnl_renderer *r, fnl_frame_stats *out) {
    struct graph_stats graph = graph_query_stats(r->graph);
    out->image_bytes_read = graph.image_bytes_read;
    out->image_bytes_written = graph.image_bytes_written;
    out->tile_bytes = graph.tile_bytes;
    struct graph_lazy_memory lazy = graph_query_lazy_memory(r->graph);
    out->lazy_bytes = lazy.reserved_bytes;
    out->lazy_committed_bytes = lazy.committed_bytes;
    out->cpu_milliseconds = r->handed.cpu_milliseconds;
    struct gpu_memory_stats memory = gpu_memory_stats(r->device);
    out->device_bytes = memory.used_bytes;
    out->device_peak_bytes = memory.peak_used_bytes;
    for (uint32_t i = 0; i < GPU_USE_COUNT; i++) { /* other comes last */
        const enum gpu_use use = (enum gpu_use)((i + 1) % GPU_USE_COUNT);
        r->handed.memory_kinds[i] = (fnl_memory_kind){gpu_use_name(use), memory.use_bytes[use]};
    }
    out->memory_kinds = r->handed.memory_kinds;
    out->memory_kind_count = GPU_USE_COUNT;
    const struct graph_timer *timers;
    uint32_t count;
    r->handed.pass_times.count = 0;
    if (r->frame.timers && graph_query_timers(r->graph, r->frame_number, &timers, &count)) {
        if (!array_reserve(&r->host, &r->handed.pass_times, count)) return FNL_ERROR_MEMORY;
        for (uint32_t i = 0; i < count; i++) {
            r->handed.pass_times.data[r->handed.pass_times.count++] =
                (fnl_pass_time){timers[i].name, timers[i].milliseconds, timers[i].begin_milliseconds,
                                timers[i].queue == GPU_QUEUE_COMPUTE ? FNL_QUEUE_COMPUTE : FNL_QUEUE_GRAPHICS, graph_pass_role(timers[i].role)};
            out->gpu_milliseconds += timers[i].milliseconds;
        }
    }
    bool is_auto = r->choice.asked.shading == FNL_SHADING_AUTO || r->choice.asked.lists == FNL_LISTS_AUTO;
    out->shading = r->frame.shading;
    out->choosing = is_auto && !r->frame.pin_choice && r->choice.chooser.state == CHOOSER_MEASURING;
    struct gpu_pipeline_stats pipelines = gpu_pipeline_stats(r->device);
    out->pipelines_pending = (uint32_t)(pipelines.asked - pipelines.done);
    out->pipelines_made = r->pipelines_made;
    out->pipelines_total = (uint32_t)pipelines.made;
    out->pipelines_cached = (uint32_t)pipelines.cached;
    out->choice = is_auto ? r->choice.chooser.reason : "";
    out->passes = r->handed.pass_times.data;
    out->pass_count = r->handed.pass_times.count;
    out->cpu_sections = r->handed.cpu_sections;
    out->cpu_section_count = r->handed.cpu_section_count;
    out->candidate_count = is_auto ? chooser_list(&r->choice.chooser, r->handed.candidates) : 0;
    if (is_auto) out->candidates = r->handed.candidates;
    return FNL_OK;
}

/* r->handed.counters has room for the view's. */
static fnl_result query_one(fnl_renderer *r, uint32_t view, fnl_frame_stats *out) {
    const struct view_made *made = &r->last.data[view];
    const struct counted counted = {r, &r->views.data[view], made, renderer_counts(r, r->frame_slot, view), &made->numbers, &r->frame};
    fnl_counter *counters = r->handed.counters.data + r->handed.counters.count;
    query_view(r, &counted, out);
    out->counters = counters;
    out->counter_count = counters_query(&counted, counters);
    r->handed.counters.count += out->counter_count;
    return query_frame(r, out);
}

fnl_result fnl_renderer_query_stats(fnl_renderer *r, fnl_frame_stats *out) {
    TRY(check_handle(__func__, "renderer", r));
    TRY(check_pointer(CALL(&r->host), "out", out));
    if (r->frame_number == 0) return misuse(CALL(&r->host), "no frame has been rendered");
    TRY(gpu_frame_wait(r->device, r->frame_number));
    for (uint32_t i = 0; i < frame_camera_count(&r->frame); i++) steps_grow(r, renderer_counts(r, r->frame_slot, i));
    uint32_t views = r->frame.view_count ? frame_camera_count(&r->frame) : 0;
    r->handed.counters.count = 0;
    if (!array_reserve(&r->host, &r->handed.counters, (1 + views) * counters_total())) return FNL_ERROR_MEMORY;
    TRY(query_one(r, 0, out));
    if (views == 0) return FNL_OK;
    if (!array_reserve(&r->host, &r->handed.view_stats, views)) return FNL_ERROR_MEMORY;
    r->handed.view_stats.count = views;
    for (uint32_t i = 0; i < views; i++) TRY(query_one(r, i, &r->handed.view_stats.data[i]));
    out->view_count = views;
    out->views = r->handed.view_stats.data;
    return FNL_OK;
}

size_t fnl_renderer_print(const fnl_renderer *r, fnl_print what, char *text, size_t capacity) {
    if (check_handle(__func__, "renderer", r) != FNL_OK) return 0;
    if (check_enum(CALL(&r->host), "what", (int32_t)what, FNL_PRINT_COUNT, "fnl_print") != FNL_OK) return 0;
    if (!text && capacity) {
        misuse(CALL(&r->host), "text is NULL, but capacity is %zu", capacity);
        return 0;
    }
    static size_t (*const prints[])(const struct graph *, char *, size_t) = {
        [FNL_PRINT_PLAN] = graph_print, [FNL_PRINT_TRAFFIC] = graph_print_traffic, [FNL_PRINT_PLAN_JSON] = graph_print_json};
    _Static_assert(COUNT_OF(prints) == FNL_PRINT_COUNT, "a row for each");
    return prints[what](r->graph, text, capacity);
}
