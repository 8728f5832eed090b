/* SPDX-License-Identifier: MIT */
#include "render/stereo.h"

#include "passes/geometry/cull.h"
#include "render/frame_steps.h"
#include "render/eyes.h"
#include "render/step.h"
#include "render/surfaces.h"
#include "render/view.h"

static VkDeviceAddress send(gpu_device *device, const struct gpu_view *view) {
    struct gpu_slice slice = gpu_frame_allocate(device, sizeof *view);
    if (!slice.data) return 0;
    memcpy(slice.data, view, sizeof *view);
    return slice.address;
}

fnl_result stereo_begin(struct frame_state *views, uint32_t count) {
    struct gpu_view eyes[GROUP_MOST];
    struct frame_display *display = views->group.display;
    for (uint32_t i = 0; i < count; i++) eyes[i] = views[i].view;
    if (!eyes_combine(eyes, count, views->frame->stereo.margin * (PI / 180), &display->head)) return FNL_OK;
    display->head_address = send(views->r->device, &display->head);
    if (!display->head_address) return gpu_status(views->r->device);
    if (frame_far_count(views->frame) == 0 || surfaces_have_blend(views) || surfaces_have_glass(views)) return FNL_OK; /* which are drawn for each eye at any distance */
    const struct gpu_view near = eyes_before(&display->head, eyes, count, views->frame->stereo.mono_distance);
    display->near_address = send(views->r->device, &near);
    return display->near_address ? FNL_OK : gpu_status(views->r->device);
}

void stereo_cull(struct frame_state *f) {
    struct frame_display *display = f->group.display;
    if (!display->head_address || f->frame->culling != FNL_CULLING_INSTANCES || frame_culls_hidden(f->frame)) {
        frame_cull(f);
        return;
    }
    graph_set_role(f->graph, GRAPH_ROLE_GEOMETRY);
    if (!display->draws.sums.id) display->draws = cull_items_add(f->graph, "cull", &f->scene->geometry, display->near_address ? display->near_address : display->head_address, NULL);
    f->draws = display->draws;
    cull_sort_add(f->graph, &f->scene->geometry, f->view_address, &f->draws);
}

fnl_camera stereo_head_camera(const fnl_frame *frame) {
    fnl_camera camera = frame->view_count > 0 ? frame->views[0] : frame->camera;
    if (frame->view_count == 0 || frame->stereo.eyes == 0) return camera;
    camera.position = camera.target = (fnl_vec3){0, 0, 0};
    for (uint32_t i = 0; i < frame->stereo.eyes; i++) {
        camera.position = vec3_add_scaled(camera.position, frame->views[i].position, 1 / (float)frame->stereo.eyes);
        camera.target = vec3_add_scaled(camera.target, frame->views[i].target, 1 / (float)frame->stereo.eyes);
    }
    return camera;
}

/* Building goes with the cells, and so with the pixels: of eyes that look apart the common frustum has more. */
static bool one_list(const struct frame_state *f) {
    const fnl_stereo_options *options = &f->frame->stereo;
    const uvec2 head = f->group.display->head.size, eye = f->view.size;
    if (options->lists == FNL_STEREO_LISTS_AUTO) return (uint64_t)head.x * head.y <= (uint64_t)options->eyes * eye.x * eye.y;
    return options->lists == FNL_STEREO_LISTS_HEAD;
}

static bool has_grid(fnl_light_lists lists) {
    return lists == FNL_LISTS_CLUSTERED || lists == FNL_LISTS_CLUSTERED_CPU || lists == FNL_LISTS_BVH || lists == FNL_LISTS_ZBIN || lists == FNL_LISTS_RASTER;
}

bool stereo_shares_list(const struct frame_state *f, fnl_light_lists lists) {
    return has_grid(lists) && f->group.display && f->group.display->head_address && one_list(f) && !f->shadows.surface_lights.header;
}

bool stereo_asks_list(const struct frame_state *f, fnl_light_lists lists) {
    const fnl_stereo_options *options = &f->frame->stereo;
    return has_grid(lists) && f->r->dry.together > 0 && options->eyes > 0 && options->lists != FNL_STEREO_LISTS_EYE && !f->shadows.surface_lights.header;
}

/* ---- numbers ---- */

void stereo_count_work(struct frame_state *f, struct geometry_draws *draws, uint32_t passes) {
    if (f->frame->stereo.eyes == 0 || passes == 0) return;
    counters_note(f, "stereo.states", (uint64_t)passes * geometry_draw_count(&f->scene->geometry, GEOMETRY_OPAQUE));
    const uint32_t first = f->common->vertex_queries, count = passes * geometry_query_count(draws);
    if (!f->frame->count_lights || !gpu_info(f->r->device)->vertex_counts || first + count > GPU_MAX_VERTEX_COUNTS) return;
    draws->counts_vertices = true;
    draws->first_query = first;
    f->common->vertex_queries += count;
    counters_note(f, "stereo.vertices", (uint64_t)first << 32 | count);
}

static bool find_vertices(const struct counted *counted, uint64_t *value) {
    const uint32_t first = (uint32_t)(*value >> 32), count = (uint32_t)*value;
    return gpu_frame_vertex_count(counted->r->device, counted->r->frame_number, first, count, value);
}

static const struct counter rows[] = {
    {"stereo.states", "states", "of an eye: pipelines bound for what is drawn before light lists; of eyes that are drawn at once the first has them", NOTED},
    {"stereo.vertices", "vertices", "that vertex shaders ran for there, as the device counts them", .needs = "count-lights", .find = find_vertices},
};
static const struct counter_table counters_stereo = COUNTER_TABLE(rows);
const struct frame_step step_stereo = {.name = "stereo", .counters = &counters_stereo};
