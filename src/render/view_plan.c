/* SPDX-License-Identifier: MIT */
#include "render/view_plan.h"

#include "passes/stereo/mono_shared.h"
#include "render/eyes.h"
#include "render/traits.h"
#include "render/view.h"

/* Culling by clusters leaves what one view sees, and so does occlusion, of which eyes draw the union; decals are found in lists of one view. */
static bool draws_at_once(const struct view_plan_input *in) {
    const fnl_frame *frame = in->frame;
    const bool decals = frame->decals != FNL_DECALS_OFF && in->has_decals;
    return frame_is(frame, SHADING_MULTIVIEW) && frame->culling == FNL_CULLING_INSTANCES && (frame->occlusion == FNL_OCCLUSION_OFF || frame->stereo.eyes) && !decals;
}

static vec3 direction_of(const fnl_camera *camera) { return vec3_normalize(vec3_sub(camera->target, camera->position)); }

/*
 * Whether two cameras see almost the same, so that hardly anything is drawn for a view that does not see it: they look the same way within 10
 * degrees, with the same field of view, from places that are less than 1/32 of the scene's diagonal apart.
 */
static bool see_the_same(const struct box *bounds, const fnl_camera *a, const fnl_camera *b) {
    if (box_is_empty(bounds) || a->orthographic != b->orthographic || a->vertical_fov != b->vertical_fov || a->vertical_extent != b->vertical_extent || a->pixel_aspect != b->pixel_aspect)
        return false;
    const float cos_10_degrees = 0.98480775f;
    return vec3_dot(direction_of(a), direction_of(b)) >= cos_10_degrees &&
           vec3_length(vec3_sub(a->position, b->position)) * 32 <= vec3_length(vec3_sub(bounds->high, bounds->low));
}

/* How eyes are drawn: as asked for, or by the nearest that the device has. */
static fnl_stereo_path path_of(const struct view_plan_input *in) {
    const fnl_stereo_path path = in->frame->stereo.path;
    if (path == FNL_STEREO_PATH_EYES) return path;
    /* Paths that draw after their lists share only the prepass, which gains nothing (docs/techniques/views.md). */
    if (path == FNL_STEREO_PATH_AUTO && frame_is(in->frame, SHADING_LISTS_FIRST)) return FNL_STEREO_PATH_EYES;
    if (in->vertex_layers && (path == FNL_STEREO_PATH_OBJECTS || path == FNL_STEREO_PATH_INSTANCES)) return path;
    return in->multiview ? FNL_STEREO_PATH_MULTIVIEW : FNL_STEREO_PATH_EYES;
}

/* Whether all cameras show the same instances. */
static bool show_the_same(const fnl_camera *cameras, uint32_t count) {
    for (uint32_t i = 1; i < count; i++)
        if (cameras[i].view_mask != cameras[0].view_mask) return false;
    return true;
}

/* How many views from `first` on are drawn at once. */
static uint32_t count_together(const struct view_plan_input *in, fnl_stereo_path path, uint32_t first) {
    const fnl_frame *frame = in->frame;
    if (frame->view_count < 2 || !draws_at_once(in)) return 1;
    if (frame->stereo.eyes) return path == FNL_STEREO_PATH_EYES || !show_the_same(&frame->views[first], frame->stereo.eyes) ? 1 : frame->stereo.eyes;
    if (frame->multiview == FNL_MULTIVIEW_OFF || !in->multiview) return 1;
    if (frame->multiview == FNL_MULTIVIEW_AUTO && frame_is(frame, SHADING_LISTS_FIRST)) return 1;
    const uint32_t most = MIN(frame->view_count - first, (uint32_t)GROUP_MOST);
    uint32_t count = 1;
    while (count < most && show_the_same(&frame->views[first], count + 1) && (frame->multiview == FNL_MULTIVIEW_ON || see_the_same(&in->bounds, &frame->views[first], &frame->views[first + count]))) count++;
    return count;
}

static void find_far(const fnl_frame *frame, struct view_group *group) {
    struct gpu_view eyes[GROUP_MOST];
    for (uint32_t i = 0; i < group->count; i++) eyes[i] = view_from_camera(&frame->views[group->first + i], frame->width, frame->height);
    group->has_far = eyes_middle(eyes, group->count, frame->stereo.mono_distance, MONO_OVERLAP, &group->far_camera, &group->far_width, &group->far_height);
}

void view_plan_make(const struct view_plan_input *in, struct view_plan *out) {
    const fnl_frame *frame = in->frame;
    const uint32_t count = frame_view_count(frame), eyes = frame->view_count > 0 ? frame->stereo.eyes : 0;
    out->group_count = 0;
    out->camera_count = frame_camera_count(frame);
    out->path = path_of(in);
    for (uint32_t first = 0; first < count;) {
        const uint32_t together = count_together(in, out->path, first);
        struct view_group *group = &out->groups[out->group_count++];
        *group = (struct view_group){.first = first, .count = eyes > 0 ? eyes : together};
        group->together = MAX(together, in->asked_together);
        group->path = frame->stereo.eyes ? out->path : FNL_STEREO_PATH_MULTIVIEW;
        group->is_display = eyes > 0 && group->count > 1;
        group->far_index = count + first / group->count;
        if (group->is_display && frame_far_count(frame)) find_far(frame, group);
        first += group->count;
    }
}
