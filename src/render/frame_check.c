/* SPDX-License-Identifier: MIT */
/** What a frame may ask for. */
#include "render/options.h"
#include "render/shading.h"
#include "render/step.h"

static fnl_result check_views(const struct call *call, const fnl_frame *frame) {
    TRY(check_count(call, "view_count", frame->view_count, 0, FNL_VIEWS_MAX));
    const uint32_t eyes = frame->stereo.eyes;
    if (eyes == 1) return misuse(call, "stereo.eyes is 1, must be 0, or 2 .. %d", GROUP_MOST);
    if (eyes > 0 && (frame->view_count == 0 || frame->view_count % eyes != 0))
        return misuse(call, "stereo.eyes is %u, but view_count is %u, which must be a multiple of it", eyes, frame->view_count);
    if (eyes > 0 && frame->multiview != FNL_MULTIVIEW_AUTO)
        return misuse(call, "multiview is for views that are not eyes; stereo.path says how those are drawn");
    if (frame->viewer) TRY(camera_check(call, "viewer->", frame->viewer));
    if (frame->gaze) TRY(check_floats(call, "gaze", &frame->gaze->x, 3, -1e9, 1e9, " metres"));
    if (frame->view_count == 0) return camera_check(call, "camera.", &frame->camera);
    if (!frame->views) return misuse(call, "views is NULL, but view_count is %u", frame->view_count);
    for (uint32_t i = 0; i < frame->view_count; i++) {
        char prefix[32];
        snprintf(prefix, sizeof prefix, "views[%u].", i);
        TRY(camera_check(call, prefix, &frame->views[i]));
    }
    if (!shading_is(frame->shading, SHADING_VIEWS))
        return unsupported(call, "%s shading takes one view in a frame, not %u; every other path takes several",
                           fnl_value_name(FNL_ENUM_SHADING, frame->shading), frame->view_count);
    if (frame->light_lod > 0)
        return unsupported(call, "light_lod takes one view in a frame, not %u: small lights are faded for one camera",
                           frame->view_count);
    return FNL_OK;
}

static fnl_result check_hidden(const struct call *call, const fnl_frame *frame) {
    for (uint32_t i = 0; frame->hidden_areas && i < frame_view_count(frame); i++) {
        const fnl_hidden_area *area = &frame->hidden_areas[i];
        const fnl_camera *camera = frame->view_count ? &frame->views[i] : &frame->camera;
        char name[48];
        snprintf(name, sizeof name, "hidden_areas[%u].corners", i);
        if (area->corner_count % 3 || area->corner_count > 1u << 20)
            return misuse(call, "hidden_areas[%u].corner_count is %u, must be a multiple of 3, at most 2^20", i, area->corner_count);
        if (area->corner_count == 0) continue;
        TRY(check_pointer(call, name, area->corners));
        TRY(check_floats(call, name, &area->corners[0].x, 2ull * area->corner_count, -1e6, 1e6, ""));
        if (camera->orthographic) return unsupported(call, "hidden_areas[%u] is of an orthographic camera; only perspective ones have them", i);
    }
    if (!frame->hidden_areas) return FNL_OK;
    if (!frame_is(frame, SHADING_HIDDEN))
        return shading_refuse(call, "hidden_areas", frame, SHADING_HIDDEN);
    if (frame->lists == FNL_LISTS_BATCHES || frame->lists == FNL_LISTS_MULTIPASS)
        return unsupported(call, "hidden areas do not go together with the lists %s", fnl_value_name(FNL_ENUM_LISTS, frame->lists));
    return FNL_OK;
}

fnl_result frame_check(const struct call *call, fnl_renderer *r, const fnl_frame *frame) {
    TRY(options_check(call, frame));
    TRY(check_views(call, frame));
    TRY(check_count(call, "outputs", frame->outputs, 0, (1u << OUTPUT_COUNT) - 1));
    if (!fnl_shading_supports(frame->shading, frame->lists, 1))
        return unsupported(call, "%s lists do not work with %s shading", fnl_value_name(FNL_ENUM_LISTS, frame->lists),
                           fnl_value_name(FNL_ENUM_SHADING, frame->shading));
    if (!fnl_shading_supports(frame->shading, frame->lists, frame->msaa))
        return unsupported(call, "%s shading has no MSAA; use another path, or 1 sample", fnl_value_name(FNL_ENUM_SHADING, frame->shading));
    uint32_t counts = gpu_info(r->device)->msaa_counts;
    if (!(counts & frame->msaa))
        return unsupported(call, "this device cannot render with %u samples per pixel, only with 1%s%s%s", frame->msaa,
                           counts & 2 ? ", 2" : "", counts & 4 ? ", 4" : "", counts & 8 ? ", 8" : "");
    TRY(steps_check(call, r, frame));
    return check_hidden(call, frame);
}
