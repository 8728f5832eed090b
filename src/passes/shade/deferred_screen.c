/* SPDX-License-Identifier: MIT */
#include "passes/shade/deferred_screen.h"

#include "passes/shade/deferred_screen_shared.h"
#include "shaders.h"

struct screen_data {
    struct gbuffer gbuffer;
    graph_image emission; /* id 0: this is the pass that lays the stencil down */
    VkDeviceAddress lighting;
    graph_buffer counters;
    struct gpu_graphics_params state;
};

static void execute_screen(const struct graph_context *context, const void *data) {
    const struct screen_data *d = data;
    struct gpu_deferred_screen_push push = {.lighting = d->lighting,
                                            .counters = d->counters.id ? graph_address(context, d->counters) : 0,
                                            .gbuffer = gbuffer_handles(context, &d->gbuffer),
                                            .emission = d->emission.id ? graph_sampled(context, d->emission) : 0};
    gpu_bind(context->commands, gpu_graphics_pipeline(context->device, &d->state));
    gpu_push(context->commands, &push, sizeof push);
    gpu_draw(context->commands, 3, 1, 0, 0);
}

bool deferred_screen_supported(const gpu_device *device) {
    return gpu_format_supports(device, VK_FORMAT_S8_UINT, VK_FORMAT_FEATURE_2_DEPTH_STENCIL_ATTACHMENT_BIT);
}

graph_image deferred_screen_add(struct graph *graph, const struct shade_input *input, const struct gbuffer *gbuffer,
                                graph_image radiance) {
    struct graph_image_params params = graph_image_info(graph, radiance);
    params.name = "lit radiance";
    graph_image lit = graph_create_image(graph, &params);
    graph_image stencil = graph_create_image(graph, &(struct graph_image_params){.name = "stencil of lit pixels",
                                                                                 .format = VK_FORMAT_S8_UINT,
                                                                                 .width = input->width,
                                                                                 .height = input->height});
    struct screen_data data = {.gbuffer = *gbuffer};
    data.state = (struct gpu_graphics_params){.vertex = &shader_screen_vert,
                                              .fragment = &shader_deferred_mark_frag,
                                              .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST,
                                              .depth_format = VK_FORMAT_S8_UINT,
                                              .stencil = {1, VK_COMPARE_OP_ALWAYS, VK_STENCIL_OP_REPLACE, 1},
                                              .samples = 1};
    gbuffer_specialise(gbuffer, data.state.constants, &data.state.constant_count);
    struct graph_pass *pass =
        graph_add_pass(graph, "deferred stencil", GRAPH_QUEUE_GRAPHICS, execute_screen, &data, sizeof data);
    gbuffer_use(pass, gbuffer, GRAPH_SAMPLE_FRAGMENT);
    graph_depth(pass, stencil, VK_ATTACHMENT_LOAD_OP_CLEAR, 0);

    data.state.fragment = &shader_deferred_screen_frag;
    data.state.stencil = (struct gpu_stencil){.test = 1, .compare = VK_COMPARE_OP_EQUAL, .pass = VK_STENCIL_OP_KEEP, .reference = 1};
    data.state.color_count = 1;
    data.state.color_formats[0] = params.format;
    data.state.constants[LIGHTING_ID] = input->lighting->bits;
    data.state.constants[COUNT_LIGHTS_ID] = input->counters.id != 0;
    data.emission = radiance;
    data.lighting = input->lighting->address;
    data.counters = input->counters;
    pass = graph_add_pass(graph, "deferred", GRAPH_QUEUE_GRAPHICS, execute_screen, &data, sizeof data);
    gbuffer_use(pass, gbuffer, GRAPH_SAMPLE_FRAGMENT);
    graph_use_image(pass, radiance, GRAPH_SAMPLE_FRAGMENT);
    lighting_use(pass, input->lighting, GRAPH_READ_FRAGMENT);
    if (input->counters.id) graph_use_buffer(pass, input->counters, GRAPH_READ_WRITE_FRAGMENT);
    graph_color(pass, lit, VK_ATTACHMENT_LOAD_OP_CLEAR, input->background);
    graph_depth_read_only(pass, stencil);
    return lit;
}
