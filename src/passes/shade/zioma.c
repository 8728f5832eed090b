/* SPDX-License-Identifier: MIT */
#include "passes/shade/zioma.h"

#include "passes/shade/sample_bounds.h"
#include "shaders.h"

#define RAY_FORMAT VK_FORMAT_R32G32B32A32_SFLOAT
#define COLOR_FORMAT VK_FORMAT_R32G32B32A32_SFLOAT

struct layer_data {
    struct volumes volumes;
    VkDeviceAddress view;
    graph_image depth, previous;
    graph_buffer counters;
    uint32_t layer, samples;
};

static void execute_layer(const struct graph_context *context, const void *data) {
    const struct layer_data *d = data;
    struct gpu_graphics_params state = {
        .fragment = &shader_zioma_layer_frag,
        .constant_count = 14,
        .constants = {[LIGHTING_ID] = d->volumes.lighting.bits, [COUNT_LIGHTS_ID] = d->counters.id != 0, [HAS_LIGHTS_ID] = 1, [HAS_METAL_ID] = 1,
                      [SAMPLES_ID] = d->samples, [ZIOMA_LAYER_ID] = d->layer > 0},
        .color_count = d->samples > 1 ? 0 : 2,
        .color_formats = {RAY_FORMAT, COLOR_FORMAT},
        .depth_test = true,
        .depth_write = true,
        .depth_compare = VK_COMPARE_OP_GREATER};
    struct gpu_zioma_push push = {
        .head = {.view = d->view, .counters = d->counters.id ? graph_address(context, d->counters) : 0},
        .depth = graph_sampled(context, d->depth),
        .previous = d->previous.id ? graph_sampled(context, d->previous) : 0};
    volumes_draw(context, &d->volumes, &state, &push.head, sizeof push);
}

struct material_data {
    const struct geometry_scene *scene;
    struct geometry_draws draws;
    VkDeviceAddress view, lighting;
    graph_buffer counters, totals;
    graph_image rays[ZIOMA_LAYERS], colors[ZIOMA_LAYERS], places[ZIOMA_LAYERS], last, ranges;
    uint32_t layers;
    struct gpu_graphics_params state;
};

static void execute_material(const struct graph_context *context, const void *data) {
    const struct material_data *d = data;
    struct gpu_zioma_material_push push = {
        .geometry = {.view = d->view,
                     .lighting = d->lighting,
                     .counters = d->counters.id ? graph_address(context, d->counters) : 0},
        .totals = graph_address(context, d->totals),
        .layers = d->layers,
        .last = graph_sampled(context, d->last)};
    for (uint32_t i = 0; i < d->layers; i++) {
        push.rays[i] = graph_sampled(context, d->rays[i]);
        push.colors[i] = graph_sampled(context, d->colors[i]);
    }
    geometry_draw_with(context, d->scene, &d->draws, GEOMETRY_OPAQUE, &d->state, NULL, &push.geometry, sizeof push);
}

static void execute_samples(const struct graph_context *context, const void *data) {
    const struct material_data *d = data;
    struct gpu_zioma_samples_push push = {
        .geometry = {.view = d->view,
                     .lighting = d->lighting,
                     .counters = d->counters.id ? graph_address(context, d->counters) : 0},
        .totals = graph_address(context, d->totals),
        .layers = d->layers,
        .ranges = graph_sampled(context, d->ranges)};
    for (uint32_t i = 0; i < d->layers; i++) push.places[i] = graph_sampled(context, d->places[i]);
    geometry_draw_with(context, d->scene, &d->draws, GEOMETRY_OPAQUE, &d->state, NULL, &push.geometry, sizeof push);
}

void zioma_add(struct graph *graph, const struct shade_input *input, const struct volumes *volumes, uint32_t layers,
               graph_image radiance, graph_image depth) {
    const uint32_t samples = MAX(graph_image_info(graph, depth).samples, 1u);
    struct sample_bounds bounds = {0};
    if (samples > 1) bounds = sample_bounds_add(graph, input, depth);
    struct layer_data layer = {.volumes = *volumes,
                               .view = input->view,
                               .depth = samples > 1 ? bounds.ranges : depth,
                               .counters = input->counters,
                               .samples = samples};
    struct material_data material = {.scene = input->scene,
                                     .draws = *input->draws,
                                     .view = input->view,
                                     .lighting = volumes->lighting.address,
                                     .counters = input->counters,
                                     .totals = volumes->totals,
                                     .ranges = bounds.ranges,
                                     .layers = layers};
    struct graph_image_params image = {.width = input->width, .height = input->height};
    static const float zero[4];
    for (uint32_t i = 0; i < layers; i++) {
        if (samples == 1) {
            image.name = graph_numbered_name(graph, "light layer rays", i);
            image.format = RAY_FORMAT;
            material.rays[i] = graph_create_image(graph, &image);
            image.name = graph_numbered_name(graph, "light layer colors", i);
            image.format = COLOR_FORMAT;
            material.colors[i] = graph_create_image(graph, &image);
        }
        image.name = graph_numbered_name(graph, "light layer order", i);
        image.format = GEOMETRY_DEPTH_FORMAT;
        material.places[i] = material.last = graph_create_image(graph, &image);
        layer.layer = i;
        struct graph_pass *pass = graph_add_pass(graph, graph_numbered_name(graph, "light layer", i), GRAPH_QUEUE_GRAPHICS,
                                                 execute_layer, &layer, sizeof layer);
        volumes_use(pass, volumes);
        graph_use_image(pass, layer.depth, GRAPH_SAMPLE_FRAGMENT);
        if (i > 0) graph_use_image(pass, layer.previous, GRAPH_SAMPLE_FRAGMENT);
        if (input->counters.id) graph_use_buffer(pass, input->counters, GRAPH_READ_WRITE_FRAGMENT);
        if (samples == 1) {
            graph_color(pass, material.rays[i], VK_ATTACHMENT_LOAD_OP_CLEAR, zero);
            graph_color(pass, material.colors[i], VK_ATTACHMENT_LOAD_OP_CLEAR, zero);
        }
        graph_depth(pass, material.last, VK_ATTACHMENT_LOAD_OP_CLEAR, 0);
        layer.previous = material.last;
    }
    material.state = (struct gpu_graphics_params){.fragment = samples > 1 ? &shader_zioma_samples_frag : &shader_zioma_frag,
                                                  .constant_count = 2,
                                                  .constants = {[LIGHTING_ID] = volumes->lighting.bits, [COUNT_LIGHTS_ID] = input->counters.id != 0},
                                                  .color_count = 1,
                                                  .color_formats = {graph_image_info(graph, radiance).format},
                                                  .depth_format = GEOMETRY_DEPTH_FORMAT,
                                                  .depth_test = true,
                                                  .depth_compare = VK_COMPARE_OP_EQUAL,
                                                  .samples = samples};
    struct graph_pass *pass =
        graph_add_pass(graph, "light layers shaded", GRAPH_QUEUE_GRAPHICS, samples > 1 ? execute_samples : execute_material,
                       &material, sizeof material);
    geometry_use(pass, input->scene, input->draws, GEOMETRY_OPAQUE);
    lighting_use(pass, &volumes->lighting, GRAPH_READ_FRAGMENT);
    for (uint32_t i = 0; i < layers; i++) {
        if (samples > 1) {
            graph_use_image(pass, material.places[i], GRAPH_SAMPLE_FRAGMENT);
            continue;
        }
        graph_use_image(pass, material.rays[i], GRAPH_SAMPLE_FRAGMENT);
        graph_use_image(pass, material.colors[i], GRAPH_SAMPLE_FRAGMENT);
    }
    if (samples > 1)
        graph_use_image(pass, material.ranges, GRAPH_SAMPLE_FRAGMENT);
    else
        graph_use_image(pass, material.last, GRAPH_SAMPLE_FRAGMENT);
    graph_use_buffer(pass, material.totals, GRAPH_READ_WRITE_FRAGMENT);
    if (input->counters.id) graph_use_buffer(pass, input->counters, GRAPH_READ_WRITE_FRAGMENT);
    graph_color(pass, radiance, VK_ATTACHMENT_LOAD_OP_CLEAR, input->background);
    graph_depth_read_only(pass, depth);
}
