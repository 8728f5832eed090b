/* SPDX-License-Identifier: MIT */
#include "passes/geometry/occlusion.h"

#include "passes/geometry/cull.h"
#include "passes/geometry/occlusion_shared.h"
#include "shaders.h"

enum { TILE = 8 };

/* What the passes have in common. */
struct occlusion_data {
    VkDeviceAddress view, previous;
    struct hierarchy hierarchy;
    uint32_t samples;
};

static struct gpu_occlusion_push push_of(const struct occlusion_data *d) {
    return (struct gpu_occlusion_push){.view = d->view,
                                       .previous = d->previous,
                                       .width = d->hierarchy.width,
                                       .height = d->hierarchy.height,
                                       .samples = d->samples};
}

static void execute_holes(const struct graph_context *context, const void *data) {
    const struct hierarchy *h = data;
    gpu_fill_buffer(context->commands, graph_get_buffer(context, h->levels), 0, (uint64_t)h->width * h->height * 4,
                    0x7f800000u);
}

static struct hierarchy create_hierarchy(struct graph *graph, const char *name, const struct gpu_view *camera) {
    struct hierarchy h = {.width = DIVIDE_UP(camera->size.x, (uint32_t)TILE),
                          .height = DIVIDE_UP(camera->size.y, (uint32_t)TILE)};
    uint64_t count = 0;
    for (uint32_t w = h.width, t = h.height;; w = (w + 1) / 2, t = (t + 1) / 2) {
        count += (uint64_t)w * t;
        if (w == 1 && t == 1) break;
    }
    h.levels = graph_create_buffer(graph, name, count * 4);
    return h;
}

static void add_levels(struct graph *graph, const char *name, const struct occlusion_data *data) {
    struct gpu_occlusion_push push = push_of(data);
    graph_dispatch(graph, &(struct graph_dispatch){.name = name,
                                                   .pipeline = {.shader = &shader_occlusion_levels_comp},
                                                   .groups = {1},
                                                   GRAPH_PUSH(push),
                                                   GRAPH_ROWS(graph_changes(&push.hierarchy, data->hierarchy.levels))});
}

static struct hierarchy add_reprojection(struct graph *graph, struct occlusion_data data, const struct gpu_view *camera,
                                         graph_image tiles) {
    data.hierarchy = create_hierarchy(graph, "reprojected depth", camera);
    struct graph_pass *pass =
        graph_add_pass(graph, "cull holes", GRAPH_QUEUE_GRAPHICS, execute_holes, &data.hierarchy, sizeof data.hierarchy);
    graph_use_buffer(pass, data.hierarchy.levels, GRAPH_COPY_TO);
    struct gpu_occlusion_push push = push_of(&data);
    graph_dispatch(
        graph, &(struct graph_dispatch){
                   .name = "cull reproject",
                   .pipeline = {.shader = &shader_occlusion_reproject_comp},
                   .groups = {DIVIDE_UP(data.hierarchy.width, 8u), DIVIDE_UP(data.hierarchy.height, 8u)},
                   GRAPH_PUSH(push),
                   GRAPH_ROWS(graph_samples(&push.depth, tiles), graph_changes(&push.hierarchy, data.hierarchy.levels))});
    add_levels(graph, "cull reprojected levels", &data);
    return data.hierarchy;
}

static struct hierarchy add_depth(struct graph *graph, struct occlusion_data data, const struct gpu_view *camera,
                                  graph_image depth, graph_image tiles) {
    data.hierarchy = create_hierarchy(graph, "hierarchical depth", camera);
    struct gpu_occlusion_push push = push_of(&data);
    graph_dispatch(graph,
                   &(struct graph_dispatch){.name = "cull tiles",
                                            .pipeline = {.shader = &shader_occlusion_tiles_comp},
                                            .groups = {data.hierarchy.width, data.hierarchy.height},
                                            GRAPH_PUSH(push),
                                            GRAPH_ROWS(graph_samples(&push.depth, depth), graph_stores(&push.tiles, tiles),
                                                       graph_writes(&push.hierarchy, data.hierarchy.levels))});
    add_levels(graph, "cull levels", &data);
    return data.hierarchy;
}

struct geometry_draws occlusion_add(struct graph *graph, gpu_device *device, const struct geometry_scene *scene,
                                    const struct gpu_view *camera, const struct gpu_view *previous, VkDeviceAddress view,
                                    uint32_t samples, struct hierarchy *out) {
    struct occlusion_data data = {.view = view, .samples = samples};
    struct graph_history tiles =
        graph_history(graph, &(struct graph_image_params){.name = "depth tiles",
                                                          .format = VK_FORMAT_R32_SFLOAT,
                                                          .width = DIVIDE_UP(camera->size.x, (uint32_t)TILE),
                                                          .height = DIVIDE_UP(camera->size.y, (uint32_t)TILE)});
    struct hierarchy likely = {0};
    struct gpu_slice slice = {0};
    if (previous && tiles.previous.id) slice = gpu_frame_allocate(device, sizeof *previous);
    if (slice.data) {
        memcpy(slice.data, previous, sizeof *previous);
        data.previous = slice.address;
        likely = add_reprojection(graph, data, camera, tiles.previous);
    }
    struct geometry_draws occluders =
        cull_items_add(graph, "cull occluders", scene, view, likely.levels.id ? &likely : NULL);
    graph_image depth = graph_create_image(graph, &(struct graph_image_params){.name = "occluder depth",
                                                                               .format = GEOMETRY_DEPTH_FORMAT,
                                                                               .width = camera->size.x,
                                                                               .height = camera->size.y,
                                                                               .samples = samples});
    geometry_depth_add(graph, "cull occluder depth", scene, &occluders, view, depth);
    *out = add_depth(graph, data, camera, depth, tiles.current);
    return cull_add_hidden(graph, scene, view, out);
}
