/* SPDX-License-Identifier: MIT */
#include "passes/transparency/transparency.h"

#include "passes/transparency/transparency_draw_shared.h"
#include "shaders.h"

struct formats {
    VkFormat sum, density;
};

static struct formats formats_of(bool half) {
    return half ? (struct formats){VK_FORMAT_R16G16B16A16_SFLOAT, VK_FORMAT_R16_SFLOAT}
                : (struct formats){VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_R32_SFLOAT};
}

bool weighted_needs_half(const gpu_device *device) {
    struct formats full = formats_of(false);
    return !gpu_format_supports(device, full.sum, VK_FORMAT_FEATURE_2_COLOR_ATTACHMENT_BLEND_BIT) ||
           !gpu_format_supports(device, full.density, VK_FORMAT_FEATURE_2_COLOR_ATTACHMENT_BLEND_BIT);
}

uint32_t weighted_bytes(bool half) { return half ? 8 + 2 : 16 + 4; }

struct draw_data {
    const struct geometry_scene *scene;
    struct geometry_draws draws;
    VkDeviceAddress view, lighting;
    graph_buffer counters;
    struct gpu_graphics_params state;
    bool half;
};

static void execute_draw(const struct graph_context *context, const void *data) {
    const struct draw_data *d = data;
    struct gpu_weighted_push push = {.geometry = {.view = d->view,
                                                  .lighting = d->lighting,
                                                  .counters = d->counters.id ? graph_address(context, d->counters) : 0},
                                     .half_sums = d->half};
    geometry_draw_with(context, d->scene, &d->draws, GEOMETRY_BLEND, &d->state, NULL, &push.geometry, sizeof push);
}

struct composite_data {
    graph_image sum, density;
    VkFormat format;
    uint32_t samples;
};

static void execute_composite(const struct graph_context *context, const void *data) {
    const struct composite_data *d = data;
    struct gpu_graphics_params state = {.vertex = &shader_screen_vert,
                                        .fragment = &shader_weighted_composite_frag,
                                        .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST,
                                        .color_count = 1,
                                        .color_formats = {d->format},
                                        .blends = {GPU_BLEND_ALPHA},
                                        .samples = d->samples};
    gpu_bind(context->commands, gpu_graphics_pipeline(context->device, &state));
    for (uint32_t i = 0; i < d->samples; i++) {
        struct gpu_weighted_composite_push push = {graph_sampled(context, d->sum), graph_sampled(context, d->density),
                                                   d->samples, i};
        gpu_push(context->commands, &push, sizeof push);
        gpu_draw(context->commands, 3, 1, 0, 0);
    }
}

struct weighted_sums weighted_sums_add(struct graph *graph, const struct shade_input *input, bool half, graph_image depth) {
    struct graph_image_params params = graph_image_info(graph, depth);
    struct formats formats = formats_of(half);
    uint32_t samples = MAX(params.samples, 1u);
    params.name = "weighted sum";
    params.format = formats.sum;
    graph_image sum = graph_create_image(graph, &params);
    params.name = "weighted density";
    params.format = formats.density;
    graph_image density = graph_create_image(graph, &params);

    struct draw_data draw = {.scene = input->scene,
                             .draws = *input->draws,
                             .view = input->view,
                             .lighting = input->lighting->address,
                             .counters = input->counters,
                             .half = half};
    draw.state = (struct gpu_graphics_params){.fragment = &shader_weighted_frag,
                                              .constant_count = 2,
                                              .constants = {[LIGHTING_ID] = input->lighting->bits, [COUNT_LIGHTS_ID] = input->counters.id != 0},
                                              .color_count = 2,
                                              .color_formats = {formats.sum, formats.density},
                                              .blends = {GPU_BLEND_ADD, GPU_BLEND_ADD},
                                              .depth_format = GEOMETRY_DEPTH_FORMAT,
                                              .depth_test = true,
                                              .depth_compare = VK_COMPARE_OP_GREATER,
                                              .samples = samples};
    struct graph_pass *pass =
        graph_add_pass(graph, "weighted blend", GRAPH_QUEUE_GRAPHICS, execute_draw, &draw, sizeof draw);
    geometry_use(pass, input->scene, input->draws, GEOMETRY_BLEND);
    lighting_use(pass, input->lighting, GRAPH_READ_FRAGMENT);
    if (input->glass.id) graph_use_image(pass, input->glass, GRAPH_SAMPLE_FRAGMENT);
    if (input->counters.id) graph_use_buffer(pass, input->counters, GRAPH_READ_WRITE_FRAGMENT);
    graph_color(pass, sum, VK_ATTACHMENT_LOAD_OP_CLEAR, (float[4]){0, 0, 0, 0});
    graph_color(pass, density, VK_ATTACHMENT_LOAD_OP_CLEAR, (float[4]){0, 0, 0, 0});
    graph_depth_read_only(pass, depth);
    return (struct weighted_sums){sum, density};
}

void weighted_add(struct graph *graph, const struct shade_input *input, bool half, graph_image radiance, graph_image depth) {
    struct graph_image_params target = graph_image_info(graph, radiance);
    struct weighted_sums sums = weighted_sums_add(graph, input, half, depth);
    struct composite_data composite = {sums.sum, sums.density, target.format, MAX(target.samples, 1u)};
    struct graph_pass *pass =
        graph_add_pass(graph, "weighted composite", GRAPH_QUEUE_GRAPHICS, execute_composite, &composite, sizeof composite);
    graph_use_image(pass, sums.sum, GRAPH_SAMPLE_FRAGMENT);
    graph_use_image(pass, sums.density, GRAPH_SAMPLE_FRAGMENT);
    graph_color(pass, radiance, VK_ATTACHMENT_LOAD_OP_LOAD, NULL);
}
