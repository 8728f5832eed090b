/* SPDX-License-Identifier: MIT */
#include "passes/shadow/requests.h"

#include "passes/shadow/requests_shared.h"
#include "passes/shadow/suns_shared.h"
#include "constants_shared.h"
#include "shaders.h"

uint32_t shadow_row_count(const struct light_set *lights) { return lights->directional_count * SHADOW_SUN_ROWS + lights->local_count; }

graph_buffer shadow_suns_add(struct graph *graph, const struct lighting *lighting, const struct rays *rays) {
    const struct light_set *lights = &lighting->lights;
    if (lights->directional_count == 0) return (graph_buffer){0};
    graph_buffer suns = graph_create_buffer(graph, "shadow suns", lights->directional_count * (uint64_t)sizeof(struct gpu_shadow_sun));
    struct gpu_shadow_suns_push push = {.lighting = lighting->address, .rays = rays->address};
    struct graph_pass *pass = graph_dispatch(
        graph, &(struct graph_dispatch){.name = "shadow suns",
                                        .pipeline = {.shader = &shader_suns_comp},
                                        .groups = {DIVIDE_UP(lights->directional_count, 64u)},
                                        GRAPH_PUSH(push),
                                        GRAPH_ROWS(graph_reads(NULL, lights->buffer), graph_writes(&push.suns, suns))});
    rays_use(pass, rays, GRAPH_READ_COMPUTE);
    return suns;
}

static void use_places(struct graph_pass *pass, const struct shadow_maps *places, enum graph_use use) {
    const graph_buffer all[] = {places->suns, places->keys, places->planes};
    for (uint32_t i = 0; i < COUNT_OF(all); i++)
        if (all[i].id) graph_use_buffer(pass, all[i], use);
}

graph_buffer shadow_requests_add(struct graph *graph, const struct lighting *lighting, const struct shadow_maps *places, uint32_t row_count,
                                 graph_image depth, bool weighs) {
    graph_buffer wanted = graph_create_buffer(graph, "shadow requests", row_count * (SHADOW_ROW_WORDS + weighs) * 4ull);
    graph_add_clear(graph, "shadow requests clear", GRAPH_QUEUE_GRAPHICS, (struct graph_clear){.buffers = {wanted}});
    shadow_requests_more_add(graph, lighting, places, wanted, depth, weighs);
    return wanted;
}

void shadow_requests_more_add(struct graph *graph, const struct lighting *lighting, const struct shadow_maps *places, graph_buffer wanted, graph_image depth,
                              bool weighs) {
    const struct graph_image_params image = graph_image_info(graph, depth);
    struct gpu_shadow_requests_push push = {.lighting = lighting->address};
    struct graph_pass *pass = graph_dispatch(
        graph, &(struct graph_dispatch){.name = "shadow requests",
                                        .pipeline = {&shader_requests_comp, 3, {[LIGHTING_ID] = lighting->bits, MAX(image.samples, 1u), weighs}},
                                        .groups = {DIVIDE_UP(image.width, 8u), DIVIDE_UP(image.height, 8u)},
                                        GRAPH_PUSH(push),
                                        GRAPH_ROWS(graph_samples(&push.depth, depth), graph_changes(&push.wanted, wanted))});
    lighting_use(pass, lighting, GRAPH_READ_COMPUTE);
    use_places(pass, places, GRAPH_READ_COMPUTE);
}

struct blend_data {
    const struct geometry_scene *scene;
    struct geometry_draws draws;
    VkDeviceAddress view, lighting;
    graph_buffer wanted;
    uint32_t bits, samples;
    bool weighs;
    enum geometry_set set;
};

static void execute_blend(const struct graph_context *context, const void *data) {
    const struct blend_data *d = data;
    struct gpu_graphics_params state = {.fragment = &shader_requests_blend_frag,
                                        .constant_count = 3,
                                        .constants = {[LIGHTING_ID] = d->bits, [SHADOW_WEIGHS_ID] = d->weighs},
                                        .depth_format = GEOMETRY_DEPTH_FORMAT,
                                        .depth_test = true,
                                        .depth_compare = VK_COMPARE_OP_GREATER,
                                        .samples = d->samples};
    geometry_draw(context, d->scene, &d->draws, d->set, &state, NULL,
                  (struct gpu_geometry_push){.view = d->view, .lighting = d->lighting, .counters = graph_address(context, d->wanted)});
}

void shadow_requests_blend_add(struct graph *graph, const struct lighting *lighting, const struct shadow_maps *places, graph_buffer wanted,
                               const struct geometry_scene *scene, const struct geometry_draws *draws, bool glass, VkDeviceAddress view,
                               graph_image depth, bool weighs) {
    struct blend_data data = {.set = glass ? GEOMETRY_GLASS : GEOMETRY_BLEND,
                              .scene = scene,
                              .draws = *draws,
                              .view = view,
                              .lighting = lighting->address,
                              .wanted = wanted,
                              .bits = lighting->bits,
                              .weighs = weighs,
                              .samples = MAX(graph_image_info(graph, depth).samples, 1u)};
    struct graph_pass *pass = graph_add_pass(graph, glass ? "shadow requests glass" : "shadow requests blend", GRAPH_QUEUE_GRAPHICS, execute_blend, &data, sizeof data);
    geometry_use(pass, scene, draws, data.set);
    lighting_use(pass, lighting, GRAPH_READ_FRAGMENT);
    use_places(pass, places, GRAPH_READ_FRAGMENT);
    graph_use_buffer(pass, wanted, GRAPH_READ_WRITE_FRAGMENT);
    graph_depth_read_only(pass, depth);
}
