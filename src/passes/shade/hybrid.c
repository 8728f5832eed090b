/* SPDX-License-Identifier: MIT */
#include "passes/shade/gbuffer.h"
#include "passes/shade/hybrid_shared.h"
#include "shaders.h"

struct hybrid_data {
    const struct geometry_scene *scene;
    struct geometry_draws draws;
    struct gbuffer gbuffer;
    VkDeviceAddress view, lighting;
    graph_buffer counters;
    struct gpu_graphics_params state;
};

static enum geometry_set set_of(const struct gbuffer *gbuffer) {
    return GEOMETRY_NOT_IN(GBUFFER_FORM_LAYOUT(gbuffer->form));
}

static void execute_hybrid(const struct graph_context *context, const void *data) {
    const struct hybrid_data *d = data;
    struct gpu_hybrid_push push = {
        .geometry = {.view = d->view,
                     .lighting = d->lighting,
                     .counters = d->counters.id ? graph_address(context, d->counters) : 0},
        .gbuffer = gbuffer_handles(context, &d->gbuffer),
    };
    geometry_draw_with(context, d->scene, &d->draws, set_of(&d->gbuffer), &d->state, NULL, &push.geometry, sizeof push);
}

void hybrid_add(struct graph *graph, const struct shade_input *input, const struct gbuffer *gbuffer, graph_image radiance) {
    if (!gbuffer->mask.id) return;
    struct hybrid_data data = {.scene = input->scene,
                               .draws = *input->draws,
                               .gbuffer = *gbuffer,
                               .view = input->view,
                               .lighting = input->lighting->address,
                               .counters = input->counters};
    data.state = (struct gpu_graphics_params){.fragment = &shader_hybrid_frag,
                                              .constant_count = 2,
                                              .constants = {[LIGHTING_ID] = input->lighting->bits, [COUNT_LIGHTS_ID] = input->counters.id != 0},
                                              .color_count = 1,
                                              .color_formats = {graph_image_info(graph, radiance).format},
                                              .depth_format = GEOMETRY_DEPTH_FORMAT,
                                              .depth_test = true,
                                              .depth_compare = VK_COMPARE_OP_EQUAL,
                                              .samples = MAX(graph_image_info(graph, radiance).samples, 1u)};
    gbuffer_specialise(gbuffer, data.state.constants, &data.state.constant_count);
    data.state.constants[SAMPLES_ID] = data.state.samples;
    data.state.constant_count = SAMPLES_ID + 1;
    struct graph_pass *pass = graph_add_pass(graph, "lit forward", GRAPH_QUEUE_GRAPHICS, execute_hybrid, &data, sizeof data);
    geometry_use(pass, input->scene, input->draws, set_of(gbuffer));
    gbuffer_use(pass, gbuffer, GRAPH_SAMPLE_FRAGMENT);
    lighting_use(pass, input->lighting, GRAPH_READ_FRAGMENT);
    if (input->counters.id) graph_use_buffer(pass, input->counters, GRAPH_READ_WRITE_FRAGMENT);
    graph_color(pass, radiance, VK_ATTACHMENT_LOAD_OP_LOAD, (float[4]){0});
    graph_depth_read_only(pass, gbuffer->depth);
}
