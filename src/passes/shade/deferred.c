/* SPDX-License-Identifier: MIT */
#include "passes/shade/classify.h"
#include "passes/shade/shade.h"
#include "passes/shade/shade_shared.h"
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

struct gbuffer gbuffer_add(struct graph *graph, const struct shade_input *input, bool prepass, graph_image radiance,
                           graph_image depth) {
    struct graph_image_params params = {
        .name = "gbuffer color", .format = VK_FORMAT_R8G8B8A8_SRGB, .width = input->width, .height = input->height};
    struct gbuffer gbuffer;
    gbuffer.color = graph_create_image(graph, &params);
    params.name = "gbuffer normal";
    params.format = VK_FORMAT_R16G16B16A16_UNORM;
    gbuffer.normal = graph_create_image(graph, &params);
    params.name = "gbuffer dielectric";
    params.format = VK_FORMAT_R8G8B8A8_UNORM;
    gbuffer.dielectric = graph_create_image(graph, &params);

    struct gbuffer_data data = {.scene = input->scene, .draws = *input->draws, .view = input->view};
    data.state =
        (struct gpu_graphics_params){.fragment = &shader_gbuffer_frag,
                                     .color_count = 4,
                                     .color_formats = {graph_image_info(graph, radiance).format, VK_FORMAT_R8G8B8A8_SRGB,
                                                       VK_FORMAT_R16G16B16A16_UNORM, VK_FORMAT_R8G8B8A8_UNORM},
                                     .depth_format = GEOMETRY_DEPTH_FORMAT,
                                     .depth_test = true,
                                     .depth_write = !prepass,
                                     .depth_compare = prepass ? VK_COMPARE_OP_EQUAL : VK_COMPARE_OP_GREATER_OR_EQUAL,
                                     .samples = 1};
    struct graph_pass *pass = graph_add_pass(graph, "gbuffer", GRAPH_QUEUE_GRAPHICS, execute_gbuffer, &data, sizeof data);
    geometry_use(pass, input->scene, input->draws, GEOMETRY_OPAQUE);
    graph_color(pass, radiance, VK_ATTACHMENT_LOAD_OP_CLEAR,
                (float[4]){input->background[0], input->background[1], input->background[2], 1});
    static const float zero[4];
    graph_color(pass, gbuffer.color, VK_ATTACHMENT_LOAD_OP_CLEAR, zero);
    graph_color(pass, gbuffer.normal, VK_ATTACHMENT_LOAD_OP_CLEAR, zero);
    graph_color(pass, gbuffer.dielectric, VK_ATTACHMENT_LOAD_OP_CLEAR, zero);
    if (prepass)
        graph_depth_read_only(pass, depth);
    else
        graph_depth(pass, depth, VK_ATTACHMENT_LOAD_OP_CLEAR, 0);
    return gbuffer;
}

struct deferred_data {
    struct gbuffer gbuffer;
    graph_image radiance, depth;
    VkDeviceAddress view, lights;
    graph_buffer counters;
    uint32_t kind, width, height;
    struct shade_classes classes;
};

static void execute_deferred(const struct graph_context *context, const void *data) {
    const struct deferred_data *d = data;
    struct gpu_compute_params params = {
        .shader = &shader_deferred_comp, .constant_count = 6, .constants = {d->kind, d->counters.id != 0, 1, 1, 0, 0}};
    struct gpu_deferred_push push = {.view = d->view,
                                     .lights = d->lights,
                                     .counters = d->counters.id ? graph_address(context, d->counters) : 0,
                                     .depth = graph_sampled(context, d->depth),
                                     .color = graph_sampled(context, d->gbuffer.color),
                                     .normal = graph_sampled(context, d->gbuffer.normal),
                                     .dielectric = graph_sampled(context, d->gbuffer.dielectric),
                                     .radiance = graph_storage(context, d->radiance)};
    if (d->classes.block_count == 0) {
        gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
        gpu_push(context->commands, &push, sizeof push);
        gpu_dispatch(context->commands, DIVIDE_UP(d->width, 8u), DIVIDE_UP(d->height, 8u), 1);
        return;
    }
    push.sums = graph_address(context, d->classes.sums);
    push.blocks = graph_address(context, d->classes.blocks);
    push.block_count = d->classes.block_count;
    params.constants[5] = d->classes.block_size;
    for (push.class_index = 0; push.class_index < SHADE_CLASSES; push.class_index++) {
        params.constants[2] = (push.class_index & SHADE_LIGHTS) != 0;
        params.constants[3] = (push.class_index & SHADE_METAL) != 0;
        params.constants[4] = (push.class_index & SHADE_FULL) != 0;
        gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
        gpu_push(context->commands, &push, sizeof push);
        gpu_dispatch_indirect(context->commands, graph_get_buffer(context, d->classes.dispatches), push.class_index * 12ull);
    }
}

void deferred_add(struct graph *graph, const struct shade_input *input, const struct gbuffer *gbuffer,
                  const struct shade_classes *classes, graph_image radiance, graph_image depth) {
    struct deferred_data data = {.gbuffer = *gbuffer,
                                 .radiance = radiance,
                                 .depth = depth,
                                 .view = input->view,
                                 .lights = input->lights->header,
                                 .counters = input->counters,
                                 .kind = input->lights->kind,
                                 .width = input->width,
                                 .height = input->height};
    if (classes) data.classes = *classes;
    struct graph_pass *pass = graph_add_pass(graph, "deferred", GRAPH_QUEUE_GRAPHICS, execute_deferred, &data, sizeof data);
    graph_use_image(pass, depth, GRAPH_SAMPLE_COMPUTE);
    graph_use_image(pass, gbuffer->color, GRAPH_SAMPLE_COMPUTE);
    graph_use_image(pass, gbuffer->normal, GRAPH_SAMPLE_COMPUTE);
    graph_use_image(pass, gbuffer->dielectric, GRAPH_SAMPLE_COMPUTE);
    graph_use_image(pass, radiance, GRAPH_READ_WRITE_COMPUTE);
    light_list_use(pass, input->lights, GRAPH_READ_COMPUTE);
    if (input->counters.id) graph_use_buffer(pass, input->counters, GRAPH_READ_WRITE_COMPUTE);
    if (!classes) return;
    graph_use_buffer(pass, classes->sums, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, classes->blocks, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, classes->dispatches, GRAPH_INDIRECT);
}
