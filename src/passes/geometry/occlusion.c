/* SPDX-License-Identifier: MIT */
#include "passes/geometry/occlusion.h"

#include "passes/geometry/cull.h"
#include "passes/geometry/occlusion_shared.h"
#include "shaders.h"

enum { TILE = 8 };

struct occlusion_data {
    VkDeviceAddress view, previous;
    struct hierarchy hierarchy;
    graph_image depth, tiles;
    uint32_t samples, groups[2];
    const struct gpu_shader *shader;
};

static void execute_occlusion(const struct graph_context *context, const void *data) {
    const struct occlusion_data *d = data;
    struct gpu_compute_params params = {.shader = d->shader};
    struct gpu_occlusion_push push = {.view = d->view,
                                      .previous = d->previous,
                                      .hierarchy = graph_address(context, d->hierarchy.levels),
                                      .depth = d->depth.id ? graph_sampled(context, d->depth) : 0,
                                      .tiles = d->tiles.id ? graph_storage(context, d->tiles) : 0,
                                      .width = d->hierarchy.width,
                                      .height = d->hierarchy.height,
                                      .samples = d->samples};
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_dispatch(context->commands, d->groups[0], d->groups[1], 1);
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

static void add_levels(struct graph *graph, const char *name, struct occlusion_data data) {
    data.shader = &shader_occlusion_levels_comp;
    data.groups[0] = data.groups[1] = 1;
    data.depth = data.tiles = (graph_image){0};
    struct graph_pass *pass = graph_add_pass(graph, name, GRAPH_QUEUE_GRAPHICS, execute_occlusion, &data, sizeof data);
    graph_use_buffer(pass, data.hierarchy.levels, GRAPH_READ_WRITE_COMPUTE);
}

static struct hierarchy add_reprojection(struct graph *graph, struct occlusion_data data, const struct gpu_view *camera,
                                         graph_image tiles) {
    data.hierarchy = create_hierarchy(graph, "reprojected depth", camera);
    data.depth = tiles;
    struct graph_pass *pass =
        graph_add_pass(graph, "cull holes", GRAPH_QUEUE_GRAPHICS, execute_holes, &data.hierarchy, sizeof data.hierarchy);
    graph_use_buffer(pass, data.hierarchy.levels, GRAPH_COPY_TO);
    data.shader = &shader_occlusion_reproject_comp;
    data.groups[0] = DIVIDE_UP(data.hierarchy.width, 8u);
    data.groups[1] = DIVIDE_UP(data.hierarchy.height, 8u);
    pass = graph_add_pass(graph, "cull reproject", GRAPH_QUEUE_GRAPHICS, execute_occlusion, &data, sizeof data);
    graph_use_image(pass, tiles, GRAPH_SAMPLE_COMPUTE);
    graph_use_buffer(pass, data.hierarchy.levels, GRAPH_READ_WRITE_COMPUTE);
    add_levels(graph, "cull reprojected levels", data);
    return data.hierarchy;
}

static struct hierarchy add_depth(struct graph *graph, struct occlusion_data data, const struct gpu_view *camera,
                                  graph_image depth, graph_image tiles) {
    data.hierarchy = create_hierarchy(graph, "hierarchical depth", camera);
    data.depth = depth;
    data.tiles = tiles;
    data.shader = &shader_occlusion_tiles_comp;
    data.groups[0] = data.hierarchy.width;
    data.groups[1] = data.hierarchy.height;
    struct graph_pass *pass =
        graph_add_pass(graph, "cull tiles", GRAPH_QUEUE_GRAPHICS, execute_occlusion, &data, sizeof data);
    graph_use_image(pass, depth, GRAPH_SAMPLE_COMPUTE);
    graph_use_image(pass, tiles, GRAPH_WRITE_COMPUTE);
    graph_use_buffer(pass, data.hierarchy.levels, GRAPH_WRITE_COMPUTE);
    add_levels(graph, "cull levels", data);
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
    struct geometry_draws occluders = cull_items_add(graph, "cull occluders", scene, view, likely.levels.id ? &likely : NULL);
    graph_image depth = graph_create_image(graph, &(struct graph_image_params){.name = "occluder depth",
                                                                               .format = GEOMETRY_DEPTH_FORMAT,
                                                                               .width = camera->size.x,
                                                                               .height = camera->size.y,
                                                                               .samples = samples});
    geometry_depth_add(graph, "cull occluder depth", scene, &occluders, view, depth);
    *out = add_depth(graph, data, camera, depth, tiles.current);
    return cull_add_hidden(graph, scene, view, out);
}
