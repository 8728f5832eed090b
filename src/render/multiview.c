/* SPDX-License-Identifier: MIT */
#include "render/multiview.h"

#include "render/shading.h"

/* Culling by clusters leaves what one view sees, and so does occlusion, of which eyes draw the union; decals are found in lists of one view. */
static bool is_possible(const fnl_renderer *r, const fnl_frame *frame) {
    const struct device_scene *scene = r->device_scene;
    bool decals = frame->decals != FNL_DECALS_OFF && scene->decals.order.count > 0;
    return frame_is(frame, SHADING_MULTIVIEW) && frame->culling == FNL_CULLING_INSTANCES && (frame->occlusion == FNL_OCCLUSION_OFF || frame->stereo.eyes) && !decals;
}

static vec3 direction_of(const fnl_camera *camera) { return vec3_normalize(vec3_sub(camera->target, camera->position)); }

/*
 * Whether two cameras see almost the same, so that hardly anything is drawn for a view that does not see it: they look the same way within 10
 * degrees, with the same field of view, from places that are less than 1/32 of the scene's diagonal apart.
 */
static bool see_the_same(const fnl_renderer *r, const fnl_camera *a, const fnl_camera *b) {
    const struct box *bounds = &r->device_scene->bounds;
    if (box_is_empty(bounds) || a->orthographic != b->orthographic || a->vertical_fov != b->vertical_fov ||
        a->vertical_extent != b->vertical_extent || a->pixel_aspect != b->pixel_aspect)
        return false;
    const float cos_10_degrees = 0.98480775f;
    return vec3_dot(direction_of(a), direction_of(b)) >= cos_10_degrees &&
           vec3_length(vec3_sub(a->position, b->position)) * 32 <= vec3_length(vec3_sub(bounds->high, bounds->low));
}

/* How eyes are drawn: as asked for, or by the nearest that the device has. */
static fnl_stereo_path path_of(const fnl_renderer *r, const fnl_frame *frame) {
    const fnl_device_info *info = gpu_info(r->device);
    const fnl_stereo_path path = frame->stereo.path;
    if (path == FNL_STEREO_PATH_EYES) return path;
    /* Paths that draw after their lists share only the prepass, which gains nothing (docs/techniques/views.md). */
    if (path == FNL_STEREO_PATH_AUTO && frame_is(frame, SHADING_LISTS_FIRST)) return FNL_STEREO_PATH_EYES;
    if (info->vertex_layers && (path == FNL_STEREO_PATH_OBJECTS || path == FNL_STEREO_PATH_INSTANCES)) return path;
    return info->multiview ? FNL_STEREO_PATH_MULTIVIEW : FNL_STEREO_PATH_EYES;
}

void multiview_tell(fnl_renderer *r, const fnl_frame *frame) {
    const fnl_stereo_path asked = frame->stereo.path, path = path_of(r, frame);
    if (r->told_of_path || !frame->stereo.eyes || asked == FNL_STEREO_PATH_AUTO || asked == path) return;
    r->told_of_path = true;
    log_warning(&r->host, "stereo.path=%s: this device has no %s: %s is used", fnl_value_name(FNL_ENUM_STEREO_PATH, asked),
                asked == FNL_STEREO_PATH_MULTIVIEW ? "multiview" : "vertex_layers", fnl_value_name(FNL_ENUM_STEREO_PATH, path));
}

uint32_t multiview_count(const fnl_renderer *r, const fnl_frame *frame, uint32_t first) {
    if (frame->view_count < 2 || !is_possible(r, frame)) return 1;
    if (frame->stereo.eyes) return path_of(r, frame) == FNL_STEREO_PATH_EYES ? 1 : frame->stereo.eyes;
    if (frame->multiview == FNL_MULTIVIEW_OFF || !gpu_info(r->device)->multiview) return 1;
    if (frame->multiview == FNL_MULTIVIEW_AUTO && frame_is(frame, SHADING_LISTS_FIRST)) return 1;
    uint32_t most = MIN(frame->view_count - first, (uint32_t)MULTIVIEW_MOST), count = 1;
    while (count < most && (frame->multiview == FNL_MULTIVIEW_ON ||
                            see_the_same(r, &frame->views[first], &frame->views[first + count])))
        count++;
    return count;
}

uint32_t multiview_counts(const fnl_renderer *r, const fnl_frame *frame) {
    uint32_t counts = 0;
    for (uint32_t first = 0, count; first < frame_view_count(frame); first += count) {
        count = multiview_count(r, frame, first);
        counts |= 1u << count;
    }
    return counts;
}

void multiview_draw(struct frame_state *views, uint32_t count, uint32_t together) {
    struct frame_state all = views[0];
    struct graph *graph = all.graph;
    all.layers = views;
    all.layer_count = count;
    graph_push_names(graph, graph_name(graph, "views %u-%u", all.view_index, all.view_index + together - 1));
    if (frame_culls_hidden(all.frame)) {
        const struct geometry_draws *draws[MULTIVIEW_MOST];
        for (uint32_t i = 0; i < count; i++) draws[i] = &views[i].draws;
        all.draws = cull_union_add(graph, &all.scene->geometry, draws, count, together);
    } else if (all.display && all.display->draws.sums.id) {
        all.draws = all.display->draws;
        all.draws.view_mask = UINT32_MAX >> (32 - together);
    } else {
        all.draws = cull_views_add(graph, &all.scene->geometry, all.view_address, together);
    }
    const fnl_stereo_path path = all.frame->stereo.eyes ? path_of(all.r, all.frame) : FNL_STEREO_PATH_MULTIVIEW;
    if (path == FNL_STEREO_PATH_OBJECTS) all.draws.layers = GEOMETRY_LAYERS_DRAWS;
    if (path == FNL_STEREO_PATH_INSTANCES) cull_repeat_add(graph, &all.scene->geometry, &all.draws);
    shading_draw(&all);
    graph_pop_names(graph);
    for (uint32_t i = 0; i < count; i++) shading_take_layer(&views[i], &all, i);
}

/* ---- numbers ---- */

void multiview_count_work(struct frame_state *f, struct geometry_draws *draws, uint32_t passes) {
    if (f->frame->stereo.eyes == 0 || passes == 0) return;
    counters_note(f, "stereo.states", (uint64_t)passes * geometry_draw_count(&f->scene->geometry, GEOMETRY_OPAQUE));
    const uint32_t first = f->r->vertex_queries, count = passes * geometry_query_count(draws);
    if (!f->frame->count_lights || !gpu_info(f->r->device)->vertex_counts || first + count > GPU_MAX_VERTEX_COUNTS) return;
    draws->counts_vertices = true;
    draws->first_query = first;
    f->r->vertex_queries += count;
    counters_note(f, "stereo.vertices", (uint64_t)first << 32 | count);
}

static bool find_vertices(const struct counted *counted, uint64_t *value) {
    const uint32_t first = (uint32_t)(*value >> 32), count = (uint32_t)*value;
    return gpu_frame_vertex_count(counted->r->device, counted->r->frame_number, first, count, value);
}

static const struct counter counters[] = {
    {"stereo.states", "states", "of an eye: pipelines bound for what is drawn before light lists; of eyes that are drawn at once the first has them", NOTED},
    {"stereo.vertices", "vertices", "that vertex shaders ran for there, as the device counts them", .needs = "count-lights", .find = find_vertices},
};
const struct counter_table multiview_counters = {counters, COUNT_OF(counters)};
