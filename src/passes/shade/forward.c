/* SPDX-License-Identifier: MIT */
#include "passes/shade/shade.h"
#include "shaders.h"

struct forward_data {
    const struct geometry_scene *scene;
    struct geometry_draws draws;
    VkDeviceAddress view, lighting;
    graph_buffer counters;
    enum geometry_set set;
    struct gpu_graphics_params state;
    const struct gpu_shader *mask_fragment;
};

static void execute_forward(const struct graph_context *context, const void *data) {
    const struct forward_data *d = data;
    struct gpu_geometry_push push = {
        .view = d->view, .lighting = d->lighting, .counters = d->counters.id ? graph_address(context, d->counters) : 0};
    geometry_draw(context, d->scene, &d->draws, d->set, &d->state, d->mask_fragment, push);
}

void forward_add(struct graph *graph, const struct shade_input *input, enum geometry_set set, bool prepass,
                 graph_image radiance, graph_image depth) {
    struct graph_image_params target = graph_image_info(graph, radiance);
    const bool blends = set == GEOMETRY_BLEND, over = set != GEOMETRY_OPAQUE;
    struct forward_data data = {.scene = input->scene,
                                .draws = *input->draws,
                                .view = input->view,
                                .lighting = input->lighting->address,
                                .counters = input->counters,
                                .set = set,
                                .mask_fragment = blends               ? NULL
                                                 : !prepass           ? &shader_forward_frag
                                                 : target.samples > 1 ? &shader_forward_known_frag
                                                                      : NULL};
    data.state =
        (struct gpu_graphics_params){.fragment = &shader_forward_early_frag,
                                     .constant_count = 2,
                                     .constants = {[LIGHTING_ID] = input->lighting->bits, [COUNT_LIGHTS_ID] = input->counters.id != 0},
                                     .color_count = 1,
                                     .color_formats = {target.format},
                                     .blends = {blends ? GPU_BLEND_ALPHA : GPU_BLEND_NONE},
                                     .depth_format = GEOMETRY_DEPTH_FORMAT,
                                     .depth_test = true,
                                     .depth_write = !blends && !prepass,
                                     /* Of surfaces at equal depth the last one drawn wins, with a prepass and without. */
                                     .depth_compare = blends    ? VK_COMPARE_OP_GREATER
                                                      : prepass ? VK_COMPARE_OP_EQUAL
                                                                : VK_COMPARE_OP_GREATER_OR_EQUAL,
                                     .samples = MAX(target.samples, 1u)};
    struct graph_pass *pass = graph_add_pass(graph, blends ? "forward blend" : over ? "forward layers" : "forward", GRAPH_QUEUE_GRAPHICS,
                                             execute_forward, &data, sizeof data);
    geometry_use(pass, input->scene, input->draws, set);
    lighting_use(pass, input->lighting, GRAPH_READ_FRAGMENT);
    if (input->glass.id) graph_use_image(pass, input->glass, GRAPH_SAMPLE_FRAGMENT);
    if (input->counters.id) graph_use_buffer(pass, input->counters, GRAPH_READ_WRITE_FRAGMENT);
    graph_color(pass, radiance, over ? VK_ATTACHMENT_LOAD_OP_LOAD : VK_ATTACHMENT_LOAD_OP_CLEAR, input->background);
    if (blends || prepass)
        graph_depth_read_only(pass, depth);
    else
        graph_depth(pass, depth, geometry_depth_load(input->draws), 0);
}
