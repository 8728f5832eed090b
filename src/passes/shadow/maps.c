/* SPDX-License-Identifier: MIT */
#include "passes/shadow/maps.h"

#include "passes/geometry/geometry.h"
#include "passes/lights/light_list.h"
#include "passes/shadow/requests_shared.h"
#include "passes/shadow/suns_shared.h"
#include "constants_shared.h"
#include "shaders.h"

void shadow_maps_use(struct graph_pass *pass, const struct shadow_maps *maps, enum graph_use use) {
    graph_use_buffer(pass, maps->held, use);
    graph_use_buffer(pass, maps->before, use);
    graph_use_buffer(pass, maps->pages, use);
    graph_use_buffer(pass, maps->biases, use);
    graph_use_buffer(pass, maps->shapes, use);
    if (maps->suns.id) graph_use_buffer(pass, maps->suns, use);
    graph_use_image(pass, maps->atlas, use == GRAPH_READ_COMPUTE ? GRAPH_SAMPLE_COMPUTE : GRAPH_SAMPLE_FRAGMENT);
}

uint32_t shadow_row_count(const struct light_input *lights) { return lights->directional_count * SHADOW_SUN_ROWS + lights->local_count; }

graph_buffer shadow_suns_add(struct graph *graph, gpu_device *device, const struct light_input *lights, const struct rays *rays) {
    if (lights->directional_count == 0) return (graph_buffer){0};
    graph_buffer suns = graph_create_buffer(graph, "shadow suns", lights->directional_count * (uint64_t)sizeof(struct gpu_shadow_sun));
    struct gpu_shadow_suns_push push = {.rays = rays->address};
    light_list_header(device, lights, &push.list);
    struct graph_pass *pass = graph_dispatch(
        graph, &(struct graph_dispatch){.name = "shadow suns",
                                        .pipeline = {.shader = &shader_suns_comp},
                                        .groups = {DIVIDE_UP(lights->directional_count, 64u)},
                                        GRAPH_PUSH(push),
                                        GRAPH_ROWS(graph_reads(NULL, lights->buffer), graph_writes(&push.suns, suns))});
    rays_use(pass, rays, GRAPH_READ_COMPUTE);
    return suns;
}

graph_buffer shadow_requests_add(struct graph *graph, const struct light_list *list, graph_buffer suns, uint32_t row_count,
                                 graph_image depth, bool weighs) {
    graph_buffer wanted = graph_create_buffer(graph, "shadow requests", row_count * (SHADOW_ROW_WORDS + weighs) * 4ull);
    graph_add_clear(graph, "shadow requests clear", GRAPH_QUEUE_GRAPHICS, (struct graph_clear){.buffers = {wanted}});
    shadow_requests_more_add(graph, list, suns, wanted, depth, weighs);
    return wanted;
}

void shadow_requests_more_add(struct graph *graph, const struct light_list *list, graph_buffer suns, graph_buffer wanted, graph_image depth,
                              bool weighs) {
    const struct graph_image_params image = graph_image_info(graph, depth);
    struct gpu_shadow_requests_push push = {.list = list->header};
    struct graph_pass *pass = graph_dispatch(
        graph, &(struct graph_dispatch){.name = "shadow requests",
                                        .pipeline = {&shader_requests_comp, 3, {[LISTS_ID] = list->kind, MAX(image.samples, 1u), weighs}},
                                        .groups = {DIVIDE_UP(image.width, 8u), DIVIDE_UP(image.height, 8u)},
                                        GRAPH_PUSH(push),
                                        GRAPH_ROWS(graph_samples(&push.depth, depth), graph_changes(&push.wanted, wanted))});
    light_list_use(pass, list, GRAPH_READ_COMPUTE);
    if (suns.id) graph_use_buffer(pass, suns, GRAPH_READ_COMPUTE);
}

struct blend_data {
    const struct geometry_scene *scene;
    struct geometry_draws draws;
    VkDeviceAddress view, lights;
    graph_buffer wanted;
    uint32_t kind, samples;
    bool weighs;
    enum geometry_set set;
};

static void execute_blend(const struct graph_context *context, const void *data) {
    const struct blend_data *d = data;
    struct gpu_graphics_params state = {.fragment = &shader_requests_blend_frag,
                                        .constant_count = 3,
                                        .constants = {[LISTS_ID] = d->kind, [SHADOW_WEIGHS_ID] = d->weighs},
                                        .depth_format = GEOMETRY_DEPTH_FORMAT,
                                        .depth_test = true,
                                        .depth_compare = VK_COMPARE_OP_GREATER,
                                        .samples = d->samples};
    geometry_draw(context, d->scene, &d->draws, d->set, &state, NULL,
                  (struct gpu_geometry_push){.view = d->view, .lights = d->lights, .counters = graph_address(context, d->wanted)});
}

void shadow_requests_blend_add(struct graph *graph, const struct light_list *list, graph_buffer suns, graph_buffer wanted,
                               const struct geometry_scene *scene, const struct geometry_draws *draws, bool glass, VkDeviceAddress view,
                               graph_image depth, bool weighs) {
    struct blend_data data = {.set = glass ? GEOMETRY_GLASS : GEOMETRY_BLEND,
                              .scene = scene,
                              .draws = *draws,
                              .view = view,
                              .lights = list->header,
                              .wanted = wanted,
                              .kind = list->kind,
                              .weighs = weighs,
                              .samples = MAX(graph_image_info(graph, depth).samples, 1u)};
    struct graph_pass *pass = graph_add_pass(graph, glass ? "shadow requests glass" : "shadow requests blend", GRAPH_QUEUE_GRAPHICS, execute_blend, &data, sizeof data);
    geometry_use(pass, scene, draws, data.set);
    light_list_use(pass, list, GRAPH_READ_FRAGMENT);
    if (suns.id) graph_use_buffer(pass, suns, GRAPH_READ_FRAGMENT);
    graph_use_buffer(pass, wanted, GRAPH_READ_WRITE_FRAGMENT);
    graph_depth_read_only(pass, depth);
}
