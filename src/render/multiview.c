/* SPDX-License-Identifier: MIT */
#include "render/multiview.h"

#include "render/shading.h"

void multiview_plan(const fnl_renderer *r, const fnl_frame *frame, struct view_plan *out) {
    const fnl_device_info *info = gpu_info(r->device);
    const struct view_plan_input input = {.frame = frame,
                                          .multiview = info->multiview,
                                          .vertex_layers = info->vertex_layers,
                                          .has_decals = r->device_scene->decals.order.count > 0,
                                          .bounds = r->device_scene->bounds,
                                          .asked_together = r->dry.together};
    view_plan_make(&input, out);
}

void multiview_tell(const struct frame_state *shared, fnl_stereo_path path) {
    const fnl_stereo_path asked = shared->frame->stereo.path;
    if (!shared->frame->stereo.eyes || asked == FNL_STEREO_PATH_AUTO || asked == path || !FRAME_TELLS(shared, stereo_path)) return;
    log_warning(&shared->r->host, "stereo.path=%s: this device has no %s: %s is used", fnl_value_name(FNL_ENUM_STEREO_PATH, asked),
                asked == FNL_STEREO_PATH_MULTIVIEW ? "multiview" : "vertex_layers", fnl_value_name(FNL_ENUM_STEREO_PATH, path));
}

void multiview_draw(struct frame_state *views, const struct view_group *group) {
    const uint32_t count = group->count, together = group->together;
    struct frame_state all = views[0];
    struct graph *graph = all.graph;
    all.group.layers = views;
    all.group.layer_count = count;
    graph_set_role(graph, GRAPH_ROLE_GEOMETRY);
    graph_push_names(graph, graph_name(graph, "views %u-%u", all.view_index, all.view_index + together - 1));
    if (frame_culls_hidden(all.frame)) {
        const struct geometry_draws *draws[GROUP_MOST];
        for (uint32_t i = 0; i < count; i++) draws[i] = &views[i].draws;
        all.draws = cull_union_add(graph, &all.scene->geometry, draws, count, together);
    } else if (all.group.display && all.group.display->draws.sums.id) {
        all.draws = all.group.display->draws;
        all.draws.view_mask = UINT32_MAX >> (32 - together);
    } else {
        all.draws = cull_views_add(graph, &all.scene->geometry, all.view_address, together);
    }
    if (group->path == FNL_STEREO_PATH_OBJECTS) all.draws.layers = GEOMETRY_LAYERS_DRAWS;
    if (group->path == FNL_STEREO_PATH_INSTANCES) cull_repeat_add(graph, &all.scene->geometry, &all.draws);
    shading_draw(&all);
    graph_pop_names(graph);
    for (uint32_t i = 0; i < count; i++) shading_take_layer(&views[i], &all, i);
}
