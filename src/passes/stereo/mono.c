/* SPDX-License-Identifier: MIT */
#include "passes/stereo/mono.h"

#include "shaders.h"

/* All passes draw one triangle over the whole screen. */
struct mono_data {
    struct gpu_mono_push push;
    graph_image depth, radiance;
    graph_buffer counts;
    struct gpu_graphics_params state;
};

static struct gpu_graphics_params state_of(const struct gpu_shader *fragment, VkFormat depth, VkCompareOp compare) {
    return (struct gpu_graphics_params){.vertex = &shader_screen_vert,
                                        .fragment = fragment,
                                        .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST,
                                        .depth_format = depth,
                                        .depth_test = true,
                                        .depth_write = true,
                                        .depth_compare = compare,
                                        .samples = 1};
}

static void execute(const struct graph_context *context, const void *data) {
    const struct mono_data *d = data;
    struct gpu_mono_push push = d->push;
    if (d->depth.id) push.depth = graph_sampled(context, d->depth);
    if (d->radiance.id) push.radiance = graph_sampled(context, d->radiance);
    if (d->counts.id) push.counts = graph_address(context, d->counts);
    gpu_bind(context->commands, graph_pipeline(context, &d->state));
    gpu_push(context->commands, &push, sizeof push);
    gpu_draw(context->commands, 3, 1, 0, 0);
}

static struct mono_data data_of(const struct mono_eye *eye) {
    return (struct mono_data){.push = {.eye = eye->eye, .mono = eye->mono, .distance = eye->distance}};
}

static VkFormat format_of(struct graph *graph, graph_image image) { return graph_image_info(graph, image).format; }

void mono_plane_add(struct graph *graph, const char *name, const struct mono_eye *eye, graph_image depth) {
    struct mono_data data = data_of(eye);
    data.state = state_of(&shader_mono_plane_frag, format_of(graph, depth), VK_COMPARE_OP_ALWAYS);
    struct graph_pass *pass = graph_add_pass(graph, name, GRAPH_QUEUE_GRAPHICS, execute, &data, sizeof data);
    graph_depth(pass, depth, VK_ATTACHMENT_LOAD_OP_CLEAR, 0);
}

struct block_data {
    struct gpu_mono_block_push push;
    graph_image depths[6];
    struct gpu_graphics_params state;
};

static void execute_block(const struct graph_context *context, const void *data) {
    const struct block_data *d = data;
    struct gpu_mono_block_push push = d->push;
    for (uint32_t i = 0; i < push.eye_count; i++) push.depths[i] = graph_sampled(context, d->depths[i]);
    gpu_bind(context->commands, graph_pipeline(context, &d->state));
    gpu_push(context->commands, &push, sizeof push);
    gpu_draw(context->commands, 3, 1, 0, 0);
}

void mono_block_add(struct graph *graph, VkDeviceAddress mono, VkDeviceAddress first, const graph_image *depths, uint32_t count, graph_image depth) {
    struct block_data data = {.push = {.mono = mono, .eyes = first, .eye_count = count},
                              .state = state_of(&shader_mono_block_frag, format_of(graph, depth), VK_COMPARE_OP_ALWAYS)};
    memcpy(data.depths, depths, count * sizeof *depths);
    struct graph_pass *pass = graph_add_pass(graph, "mono block", GRAPH_QUEUE_GRAPHICS, execute_block, &data, sizeof data);
    for (uint32_t i = 0; i < count; i++) graph_use_image(pass, depths[i], GRAPH_SAMPLE_FRAGMENT);
    graph_depth(pass, depth, VK_ATTACHMENT_LOAD_OP_CLEAR, 0);
}

graph_image mono_open_add(struct graph *graph, const struct mono_eye *eye, graph_image depth, graph_buffer counts) {
    const struct graph_image_params from = graph_image_info(graph, depth);
    const graph_image out =
        graph_create_image(graph, &(struct graph_image_params){.name = "mono depth", .format = from.format, .width = from.width, .height = from.height, .samples = 1});
    struct mono_data data = data_of(eye);
    data.depth = depth;
    data.counts = counts;
    data.state = state_of(&shader_mono_open_frag, from.format, VK_COMPARE_OP_ALWAYS);
    data.state.constant_count = 1;
    data.state.constants[0] = counts.id != 0;
    struct graph_pass *pass = graph_add_pass(graph, "mono open", GRAPH_QUEUE_GRAPHICS, execute, &data, sizeof data);
    graph_use_image(pass, depth, GRAPH_SAMPLE_FRAGMENT);
    if (counts.id) graph_use_buffer(pass, counts, GRAPH_READ_WRITE_FRAGMENT);
    graph_depth(pass, out, VK_ATTACHMENT_LOAD_OP_CLEAR, 0);
    return out;
}

void mono_composite_add(struct graph *graph, const struct mono_eye *eye, graph_image mono_radiance, graph_image mono_depth, graph_image radiance, graph_image depth) {
    struct mono_data data = data_of(eye);
    data.depth = mono_depth;
    data.radiance = mono_radiance;
    data.state = state_of(&shader_mono_composite_frag, format_of(graph, depth), VK_COMPARE_OP_GREATER);
    data.state.color_count = 1;
    data.state.color_formats[0] = format_of(graph, radiance);
    struct graph_pass *pass = graph_add_pass(graph, "mono composite", GRAPH_QUEUE_GRAPHICS, execute, &data, sizeof data);
    graph_use_image(pass, mono_depth, GRAPH_SAMPLE_FRAGMENT);
    graph_use_image(pass, mono_radiance, GRAPH_SAMPLE_FRAGMENT);
    graph_color(pass, radiance, VK_ATTACHMENT_LOAD_OP_LOAD, NULL);
    graph_depth(pass, depth, VK_ATTACHMENT_LOAD_OP_LOAD, 0);
}
