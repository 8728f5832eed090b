/* SPDX-License-Identifier: MIT */
#include "passes/shade/gbuffer.h"

#include "shaders.h"

struct gbuffer_data {
    const struct geometry_scene *scene;
    struct geometry_draws draws;
    VkDeviceAddress view;
    struct gpu_graphics_params state;
};

static void execute_gbuffer(const struct graph_context *context, const void *data) {
    const struct gbuffer_data *d = data;
    geometry_draw(context, d->scene, &d->draws, GEOMETRY_OPAQUE, &d->state, NULL,
                  (struct gpu_geometry_push){.view = d->view});
}

static const struct {
    const char *name;
    VkFormat format;
} targets[] = {{"gbuffer color", VK_FORMAT_R8G8B8A8_SRGB},
               {"gbuffer normal", VK_FORMAT_R16G16B16A16_UNORM},
               {"gbuffer dielectric", VK_FORMAT_R8G8B8A8_UNORM}};

struct gbuffer gbuffer_add(struct graph *graph, const struct shade_input *input, bool prepass, graph_image radiance,
                           graph_image depth) {
    struct gbuffer gbuffer = {.depth = depth, .target_count = COUNT_OF(targets)};
    uint32_t samples = MAX(graph_image_info(graph, depth).samples, 1u);
    for (uint32_t i = 0; i < gbuffer.target_count; i++)
        gbuffer.targets[i] = graph_create_image(graph, &(struct graph_image_params){.name = targets[i].name,
                                                                                    .format = targets[i].format,
                                                                                    .width = input->width,
                                                                                    .height = input->height,
                                                                                    .samples = samples});
    gbuffer.normal = gbuffer.targets[1];
    struct gbuffer_data data = {.scene = input->scene, .draws = *input->draws, .view = input->view};
    data.state =
        (struct gpu_graphics_params){.fragment = &shader_gbuffer_frag,
                                     .color_count = 1 + gbuffer.target_count,
                                     .color_formats = {graph_image_info(graph, radiance).format},
                                     .depth_format = GEOMETRY_DEPTH_FORMAT,
                                     .depth_test = true,
                                     .depth_write = !prepass,
                                     .depth_compare = prepass ? VK_COMPARE_OP_EQUAL : VK_COMPARE_OP_GREATER_OR_EQUAL,
                                     .samples = samples};
    for (uint32_t i = 0; i < gbuffer.target_count; i++) data.state.color_formats[1 + i] = targets[i].format;
    struct graph_pass *pass = graph_add_pass(graph, "gbuffer", GRAPH_QUEUE_GRAPHICS, execute_gbuffer, &data, sizeof data);
    geometry_use(pass, input->scene, input->draws, GEOMETRY_OPAQUE);
    graph_color(pass, radiance, VK_ATTACHMENT_LOAD_OP_CLEAR,
                (float[4]){input->background[0], input->background[1], input->background[2], 1});
    static const float zero[4];
    for (uint32_t i = 0; i < gbuffer.target_count; i++)
        graph_color(pass, gbuffer.targets[i], VK_ATTACHMENT_LOAD_OP_CLEAR, zero);
    if (prepass)
        graph_depth_read_only(pass, depth);
    else
        graph_depth(pass, depth, VK_ATTACHMENT_LOAD_OP_CLEAR, 0);
    return gbuffer;
}

void gbuffer_use(struct graph_pass *pass, const struct gbuffer *gbuffer, enum graph_use use) {
    graph_use_image(pass, gbuffer->depth, use);
    for (uint32_t i = 0; i < gbuffer->target_count; i++) graph_use_image(pass, gbuffer->targets[i], use);
}

struct gpu_gbuffer gbuffer_handles(const struct graph_context *context, const struct gbuffer *gbuffer) {
    struct gpu_gbuffer handles = {.depth = graph_sampled(context, gbuffer->depth)};
    for (uint32_t i = 0; i < gbuffer->target_count; i++) handles.targets[i] = graph_sampled(context, gbuffer->targets[i]);
    return handles;
}
