/* SPDX-License-Identifier: MIT */
#include "passes/debug/debug.h"

#include "passes/debug/light_volumes_shared.h"

#include "fanal/renderer.h"
#include "shaders.h"

_Static_assert((uint32_t)FNL_DEBUG_DECALS == GPU_DEBUG_DECALS && FNL_DEBUG_GBUFFER_0 == FNL_DEBUG_DECALS + 1,
               "debug_shared.h has the values of fnl_debug_view");
_Static_assert((uint32_t)FNL_DEBUG_EDGES == GPU_DEBUG_EDGES && (uint32_t)FNL_DEBUG_HALOS == GPU_DEBUG_HALOS,
               "and those of the views of edges and halos");
_Static_assert((uint32_t)FNL_DEBUG_COARSE_REASON == GPU_DEBUG_COARSE_REASON &&
                   FNL_DEBUG_COARSE + 1 == FNL_DEBUG_COARSE_REASON,
               "and those of coarse shading");

_Static_assert((uint32_t)FNL_DEBUG_CLUSTERS == GPU_DEBUG_CLUSTERS && (uint32_t)FNL_DEBUG_TRIANGLES == GPU_DEBUG_TRIANGLES &&
                   (uint32_t)FNL_DEBUG_DEPTH_JUMPS == GPU_DEBUG_DEPTH_JUMPS,
               "and those of the views of clusters, triangles and depth jumps");

struct draw_data {
    const struct geometry_scene *scene;
    struct geometry_draws draws;
    VkDeviceAddress view;
    graph_buffer counters;
    struct gpu_graphics_params state;
    const struct gpu_shader *mask_fragment;
};

static void execute_draw(const struct graph_context *context, const void *data) {
    const struct draw_data *d = data;
    struct gpu_geometry_push push = {.view = d->view, .counters = d->counters.id ? graph_address(context, d->counters) : 0};
    geometry_draw(context, d->scene, &d->draws, GEOMETRY_OPAQUE, &d->state, d->mask_fragment, push);
}

static graph_image create_depth(struct graph *graph, const char *name, uint32_t width, uint32_t height) {
    return graph_create_image(graph, &(struct graph_image_params){
                                         .name = name, .format = GEOMETRY_DEPTH_FORMAT, .width = width, .height = height});
}

struct aov_images aov_add(struct graph *graph, const struct geometry_scene *scene, const struct geometry_draws *draws,
                          VkDeviceAddress view, uint32_t width, uint32_t height) {
    struct graph_image_params params = {
        .name = "aov albedo", .format = VK_FORMAT_R32G32B32A32_SFLOAT, .width = width, .height = height};
    struct aov_images images;
    images.albedo = graph_create_image(graph, &params);
    params.name = "aov normal";
    images.normal = graph_create_image(graph, &params);
    params.name = "aov position";
    images.position = graph_create_image(graph, &params);
    struct draw_data data = {.scene = scene, .draws = *draws, .view = view};
    data.state = (struct gpu_graphics_params){.fragment = &shader_aov_frag,
                                              .color_count = 3,
                                              .color_formats = {params.format, params.format, params.format},
                                              .depth_format = GEOMETRY_DEPTH_FORMAT,
                                              .depth_test = true,
                                              .depth_write = true,
                                              .depth_compare = VK_COMPARE_OP_GREATER_OR_EQUAL,
                                              .samples = 1};
    struct graph_pass *pass = graph_add_pass(graph, "aov", GRAPH_QUEUE_GRAPHICS, execute_draw, &data, sizeof data);
    geometry_use(pass, scene, draws, GEOMETRY_OPAQUE);
    static const float zero[4];
    graph_color(pass, images.albedo, VK_ATTACHMENT_LOAD_OP_CLEAR, zero);
    graph_color(pass, images.normal, VK_ATTACHMENT_LOAD_OP_CLEAR, zero);
    graph_color(pass, images.position, VK_ATTACHMENT_LOAD_OP_CLEAR, zero);
    graph_depth(pass, create_depth(graph, "aov depth", width, height), VK_ATTACHMENT_LOAD_OP_CLEAR, 0);
    return images;
}

static graph_buffer create_counters(struct graph *graph, uint32_t width, uint32_t height) {
    graph_buffer counters = graph_create_buffer(graph, "overdraw", (uint64_t)width * height * 4);
    graph_add_clear(graph, "overdraw clear", GRAPH_QUEUE_GRAPHICS, (struct graph_clear){.buffers = {counters}});
    return counters;
}

graph_buffer overdraw_add(struct graph *graph, const struct geometry_scene *scene, const struct geometry_draws *draws,
                          VkDeviceAddress view, uint32_t width, uint32_t height) {
    graph_buffer counters = create_counters(graph, width, height);
    struct draw_data data = {.scene = scene, .draws = *draws, .view = view, .counters = counters};
    data.state =
        (struct gpu_graphics_params){.fragment = &shader_overdraw_frag, .depth_format = GEOMETRY_DEPTH_FORMAT, .samples = 1};
    struct graph_pass *pass = graph_add_pass(graph, "overdraw", GRAPH_QUEUE_GRAPHICS, execute_draw, &data, sizeof data);
    geometry_use(pass, scene, draws, GEOMETRY_OPAQUE);
    graph_use_buffer(pass, counters, GRAPH_READ_WRITE_FRAGMENT);
    graph_depth(pass, create_depth(graph, "overdraw depth", width, height), VK_ATTACHMENT_LOAD_OP_CLEAR, 0);
    return counters;
}

/* What `fragment` counts of the surfaces that are seen in the end. */
static graph_buffer count_seen(struct graph *graph, const struct gpu_shader *fragment, const struct geometry_scene *scene,
                               const struct geometry_draws *draws, VkDeviceAddress view, uint32_t width, uint32_t height) {
    graph_buffer counters = create_counters(graph, width, height);
    graph_image depth = create_depth(graph, "overshading depth", width, height);
    struct draw_data data = {.scene = scene, .draws = *draws, .view = view, .mask_fragment = &shader_depth_frag};
    data.state = (struct gpu_graphics_params){.depth_format = GEOMETRY_DEPTH_FORMAT,
                                              .depth_test = true,
                                              .depth_write = true,
                                              .depth_compare = VK_COMPARE_OP_GREATER,
                                              .samples = 1};
    struct graph_pass *pass =
        graph_add_pass(graph, "overshading prepass", GRAPH_QUEUE_GRAPHICS, execute_draw, &data, sizeof data);
    geometry_use(pass, scene, draws, GEOMETRY_OPAQUE);
    graph_depth(pass, depth, VK_ATTACHMENT_LOAD_OP_CLEAR, 0);
    /* Only what is seen in the end, so the order of the draws does not matter. */
    data.state.fragment = fragment;
    data.mask_fragment = NULL;
    data.counters = counters;
    data.state.depth_write = false;
    data.state.depth_compare = VK_COMPARE_OP_EQUAL;
    pass = graph_add_pass(graph, "overshading", GRAPH_QUEUE_GRAPHICS, execute_draw, &data, sizeof data);
    geometry_use(pass, scene, draws, GEOMETRY_OPAQUE);
    graph_use_buffer(pass, counters, GRAPH_READ_WRITE_FRAGMENT);
    graph_depth_read_only(pass, depth);
    return counters;
}

graph_buffer overshading_add(struct graph *graph, const struct geometry_scene *scene, const struct geometry_draws *draws,
                             VkDeviceAddress view, uint32_t width, uint32_t height) {
    return count_seen(graph, &shader_overshading_frag, scene, draws, view, width, height);
}

graph_buffer cluster_view_add(struct graph *graph, const struct geometry_scene *scene, const struct geometry_draws *draws,
                              VkDeviceAddress view, uint32_t width, uint32_t height) {
    return count_seen(graph, &shader_cluster_view_frag, scene, draws, view, width, height);
}

graph_buffer triangle_view_add(struct graph *graph, const struct geometry_scene *scene, const struct geometry_draws *draws,
                               VkDeviceAddress view, uint32_t width, uint32_t height) {
    return count_seen(graph, &shader_triangle_view_frag, scene, draws, view, width, height);
}

graph_image halos_add(struct graph *graph, const struct geometry_scene *scene, const struct geometry_draws *draws,
                      VkDeviceAddress view, uint32_t width, uint32_t height) {
    const struct graph_image_params params = {
        .name = "halos", .format = VK_FORMAT_R16G16_SFLOAT, .width = width, .height = height};
    graph_image metal = graph_create_image(graph, &params);
    struct draw_data data = {.scene = scene, .draws = *draws, .view = view};
    data.state = (struct gpu_graphics_params){.fragment = &shader_halos_frag,
                                              .color_count = 1,
                                              .color_formats = {params.format},
                                              .depth_format = GEOMETRY_DEPTH_FORMAT,
                                              .depth_test = true,
                                              .depth_write = true,
                                              .depth_compare = VK_COMPARE_OP_GREATER_OR_EQUAL,
                                              .samples = 1};
    struct graph_pass *pass = graph_add_pass(graph, "halos", GRAPH_QUEUE_GRAPHICS, execute_draw, &data, sizeof data);
    geometry_use(pass, scene, draws, GEOMETRY_OPAQUE);
    graph_color(pass, metal, VK_ATTACHMENT_LOAD_OP_CLEAR, (float[4]){0, 0, 0, 0});
    graph_depth(pass, create_depth(graph, "halos depth", width, height), VK_ATTACHMENT_LOAD_OP_CLEAR, 0);
    return metal;
}

void debug_view_add(struct graph *graph, uint32_t mode, const struct aov_images *aov, const struct light_list *lights,
                    struct debug_counts counts, graph_image metal, VkDeviceAddress view, graph_image target, bool swap) {
    struct graph_image_params image = graph_image_info(graph, target);
    struct gpu_debug_push push = {.view = view,
                                  .lights = lights->header,
                                  .has_cones = lights->cones.id != 0,
                                  .swap = swap,
                                  .mode = mode,
                                  .count_stride = counts.buffer.id ? counts.stride : 0};
    struct graph_pass *pass = graph_dispatch(
        graph,
        &(struct graph_dispatch){
            .name = "debug view",
            .pipeline = {&shader_debug_view_comp, 1, {lights->kind & GPU_LIST_KINDS}},
            .groups = {DIVIDE_UP(image.width, 8u), DIVIDE_UP(image.height, 8u)},
            GRAPH_PUSH(push),
            GRAPH_ROWS(graph_samples(&push.albedo, aov->albedo), graph_samples(&push.normal, aov->normal),
                       graph_samples(&push.position, aov->position),
                       graph_row_if(lights->cones.id, graph_reads(&push.cones, lights->cones)),
                       graph_row_if(counts.buffer.id, graph_reads(&push.counts, counts.buffer)),
                       graph_row_if(metal.id, graph_samples(&push.metal, metal)), graph_stores(&push.target, target))});
    light_list_use(pass, lights, GRAPH_READ_COMPUTE);
}

void light_volumes_view_add(struct graph *graph, const struct aov_images *aov, const struct lighting *lighting, VkDeviceAddress view, graph_image target,
                            bool swap) {
    const struct graph_image_params image = graph_image_info(graph, target);
    const uint32_t heeded = GPU_LIST_KINDS | GPU_LIGHTING_SIMPLE | GPU_LIGHTING_PROFILES | GPU_LIGHTING_AREA_LIGHTS;
    struct gpu_light_volumes_push push = {.view = view, .lighting = lighting->address, .swap = swap};
    struct graph_pass *pass =
        graph_dispatch(graph, &(struct graph_dispatch){.name = "debug view",
                                                       .pipeline = {&shader_light_volumes_comp, 1, {lighting->bits & heeded}},
                                                       .groups = {DIVIDE_UP(image.width, 8u), DIVIDE_UP(image.height, 8u)},
                                                       GRAPH_PUSH(push),
                                                       GRAPH_ROWS(graph_samples(&push.albedo, aov->albedo),
                                                                  graph_samples(&push.normal, aov->normal),
                                                                  graph_samples(&push.position, aov->position),
                                                                  graph_stores(&push.target, target))});
    lighting_use(pass, lighting, GRAPH_READ_COMPUTE);
}
