/* SPDX-License-Identifier: MIT */
#include "passes/shade/pre_lighting.h"

#include "passes/shade/pre_lighting_shared.h"
#include "shaders.h"

struct pre_lighting_data {
    struct volumes volumes;
    struct light_surfaces surfaces;
    VkDeviceAddress view;
    graph_buffer counters;
    VkFormat format;
    uint32_t layer;
};

static void execute_pre_lighting(const struct graph_context *context, const void *data) {
    const struct pre_lighting_data *d = data;
    struct gpu_graphics_params state = {.fragment = &shader_pre_lighting_frag,
                                        .constant_count = LIGHT_BUFFER_ID + 1,
                                        .constants = {[LIGHTING_ID] = d->volumes.lighting.bits, [COUNT_LIGHTS_ID] = d->counters.id != 0, [HAS_LIGHTS_ID] = 1,
                                                      [HAS_METAL_ID] = 1, [SAMPLES_ID] = d->surfaces.samples, [LIGHT_BUFFER_ID] = LIGHT_BUFFER_TWO},
                                        .color_count = 2,
                                        .color_formats = {d->format, d->format},
                                        .blends = {GPU_BLEND_ADD, GPU_BLEND_ADD}};
    struct gpu_pre_lighting_push push = {
        .head = {.view = d->view, .counters = d->counters.id ? graph_address(context, d->counters) : 0},
        .words = d->surfaces.samples > 1 ? graph_address(context, d->surfaces.layers.surfaces) : 0,
        .surfaces = light_surfaces_handles(context, &d->surfaces),
        .layer = d->layer};
    volumes_draw(context, &d->volumes, &state, &push.head, sizeof push);
}

void pre_lighting_add(struct graph *graph, const struct shade_input *input, const struct volumes *volumes,
                      const struct light_surfaces *surfaces, const struct light_sums *sums) {
    struct pre_lighting_data data = {.volumes = *volumes,
                                     .surfaces = *surfaces,
                                     .view = input->view,
                                     .counters = input->counters,
                                     .format = graph_image_info(graph, sums->targets[0]).format};
    struct surface_layers layers = surfaces->layers;
    if (layers.count > 1) surface_layers_add_depths(graph, input, surfaces->depth, &layers);
    for (; data.layer < layers.count; data.layer++) {
        struct graph_pass *pass = graph_add_pass(graph, graph_numbered_name(graph, "light volumes", data.layer),
                                                 GRAPH_QUEUE_GRAPHICS, execute_pre_lighting, &data, sizeof data);
        volumes_use(pass, volumes);
        light_surfaces_use(pass, surfaces, GRAPH_SAMPLE_FRAGMENT);
        if (layers.count > 1) graph_use_buffer(pass, layers.surfaces, GRAPH_READ_FRAGMENT);
        if (input->counters.id) graph_use_buffer(pass, input->counters, GRAPH_READ_WRITE_FRAGMENT);
        for (uint32_t i = 0; i < sums->target_count; i++)
            graph_color(pass, light_sums_layer(sums, data.layer)[i], VK_ATTACHMENT_LOAD_OP_LOAD, (float[4]){0});
        graph_depth_read_only(pass, layers.count > 1 ? layers.depths[data.layer] : surfaces->depth);
    }
}
