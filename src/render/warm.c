/* SPDX-License-Identifier: MIT */
/** Pipelines and uploads ahead of the frames that need them. */
#include "base/check.h"
#include "fanal/vulkan.h"
#include "passes/debug/inspect.h"
#include "render/multiview.h"
#include "render/overlay.h"
#include "render/shading.h"
#include "render/shadows.h"

/* Buffers with sizes alone: nothing is recorded, and what the last frame wrote stays where it is. */
static struct renderer_outputs stand_ins(const fnl_frame *frame) {
    struct renderer_outputs outputs = {.pixel = {.size = sizeof(struct inspected)}};
    for (uint32_t i = 0; i < OUTPUT_COUNT; i++) outputs.pictures[i] = (struct gpu_buffer){.size = renderer_picture_size(frame, i)};
    return outputs;
}

fnl_result renderer_ask_pipelines(fnl_renderer *r, const fnl_frame *frame, const struct frame_target *target,
                                  uint64_t *out_ticket) {
    if (!r->dry.graph) TRY(graph_create(&r->host, r->device, &r->dry.graph));
    const struct renderer_outputs outputs = stand_ins(frame);
    struct renderer_view view = r->views.data[0]; /* all views of a frame have the same pipelines */
    view.counters = (struct gpu_buffer){.size = 4 * light_counter_count(frame)};
    view.draws = (struct gpu_buffer){.size = MAX(r->device_scene->group_count, 1u) * sizeof(struct gpu_draw)};
    struct view_made made;
    struct lists_state lists;
    struct lists_shared shared_lists;
    lists_init(&lists, &r->host);
    lists_shared_init(&shared_lists, &r->host);
    struct view_plan plan;
    multiview_plan(r, frame, &plan);
    const struct frame_input input = {.frame = frame,
                                      .plan = &plan,
                                      .target = target,
                                      .graph = r->dry.graph,
                                      .views = &view,
                                      .outputs = &outputs,
                                      .made = &made,
                                      .user = &r->scene_user,
                                      .shared_lists = &shared_lists,
                                      .lists = &lists};
    fnl_result result = frame_declare(r, &input);
    if (result == FNL_OK) result = graph_ask_pipelines(r->dry.graph, out_ticket);
    lists_finish(&lists, r->device);
    lists_shared_finish(&shared_lists, r->device);
    return result;
}

/* In a frame of the device that renders nothing. */
static fnl_result ask(fnl_renderer *r, const fnl_frame *frame, const struct frame_target *target, uint64_t *out_ticket) {
    TRY(gpu_frame_begin(r->device));
    fnl_result result = renderer_ask_pipelines(r, frame, target, out_ticket);
    fnl_result ended = gpu_frame_end(r->device, NULL, 0, NULL);
    return result != FNL_OK ? result : ended;
}

/* What `auto` is going to measure: else the frames after the first would ask for it one by one. */
static fnl_result ask_candidates(fnl_renderer *r, const fnl_frame *frame, const struct frame_target *target, uint64_t *ticket) {
    fnl_frame candidate = *frame;
    struct choice choice;
    uint64_t last;
    while (chooser_asks(&r->choice.chooser, &choice)) {
        candidate.shading = choice.shading;
        candidate.lists = choice.lists;
        TRY(ask(r, &candidate, target, &last));
        chooser_asked(&r->choice.chooser, last);
        *ticket = MAX(*ticket, last);
    }
    return FNL_OK;
}

fnl_result fnl_renderer_warm(fnl_renderer *r, const fnl_frame *given, const fnl_vulkan_target *target, bool wait,
                             uint32_t *out_pending) {
    TRY(check_handle(__func__, "renderer", r));
    const struct call *call = CALL(&r->host);
    if (out_pending) *out_pending = 0;
    fnl_frame frame = given ? *given : fnl_frame_default();
    if (target) {
        TRY(renderer_check_target(call, target->format));
        frame.outputs &= ~(uint32_t)FNL_OUTPUT_COLOR;
    }
    TRY(renderer_settle(r, &frame));
    TRY(frame_check(call, r, &frame));
    fnl_frame whole = frame;
    if (frame.view_count) frame.camera = frame.views[0];
    frame.view_count = frame.pixel.view = 0; /* the view that is declared */
    const bool chooses = wait && !frame.pin_choice && (frame.shading == FNL_SHADING_AUTO || frame.lists == FNL_LISTS_AUTO);
    frame.pin_choice = true; /* nothing is measured */
    const struct choice asked = r->choice.asked;
    const bool measures = r->choice.measures;
    const struct gpu_image image = {
        .params = {.name = "target",
                   .format = target ? target->format : VK_FORMAT_UNDEFINED,
                   .width = target && target->width ? target->width : frame.width,
                   .height = target && target->height ? target->height : frame.height,
                   .layers = 1,
                   .mips = 1,
                   .samples = 1,
                   .usage = VK_IMAGE_USAGE_TRANSFER_DST_BIT},
        .sampled_index = GPU_NO_INDEX,
        .storage_index = GPU_NO_INDEX,
        .srgb_index = GPU_NO_INDEX};
    struct gpu_image depth = image;
    depth.params.format = GEOMETRY_DEPTH_FORMAT;
    const struct frame_target frame_target = {.image = &image,
                                              .initial_layout = VK_IMAGE_LAYOUT_UNDEFINED,
                                              .final_layout = VK_IMAGE_LAYOUT_GENERAL,
                                              .part = {.width = image.params.width, .height = image.params.height},
                                              .depth = target && target->depth ? &depth : NULL,
                                              .depth_initial_layout = VK_IMAGE_LAYOUT_UNDEFINED,
                                              .depth_final_layout = VK_IMAGE_LAYOUT_GENERAL,
                                              .depth_forward = target && target->depth_forward};
    uint64_t ticket = 0;
    fnl_result result = overlay_prepare(r, &frame);
    if (result == FNL_OK) result = renderer_prepare(r, &frame);
    whole.shading = frame.shading; /* that was chosen */
    frame.occlusion = whole.occlusion = frame_choose_occlusion(r, &whole); /* it goes by the number of views */
    struct view_plan plan = {0};
    if (result == FNL_OK) multiview_plan(r, &whole, &plan);
    uint32_t counts = 0; /* bit n: some n views are drawn at once */
    for (uint32_t i = 0; i < plan.group_count; i++) counts |= 1u << plan.groups[i].together;
    for (uint32_t together = 1; counts >> together && result == FNL_OK; together++) {
        if (!(counts >> together & 1)) continue;
        uint64_t last = 0;
        r->dry.together = together;
        result = ask(r, &frame, target ? &frame_target : NULL, &last);
        ticket = MAX(ticket, last);
    }
    r->dry.together = 0;
    if (chooses && result == FNL_OK) result = ask_candidates(r, &frame, target ? &frame_target : NULL, &ticket);
    if (wait && result == FNL_OK) result = gpu_upload_flush(r->device);
    r->choice.asked = asked;
    r->choice.measures = measures;
    if (result != FNL_OK) {
        renderer_forget(r);
        return result;
    }
    if (wait) gpu_ask_wait(r->device, ticket);
    const uint64_t done = gpu_pipeline_stats(r->device).done;
    if (out_pending && ticket > done) *out_pending = (uint32_t)(ticket - done);
    return FNL_OK;
}
