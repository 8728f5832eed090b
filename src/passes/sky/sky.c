/* SPDX-License-Identifier: MIT */
#include "passes/sky/sky.h"

#include "passes/ambient/environment_maps_shared.h"
#include "passes/sky/sky_shared.h"
#include "shaders.h"

struct sky_data {
    struct gpu_sky_push push;
    struct gpu_graphics_params state;
};

static void execute(const struct graph_context *context, const void *data) {
    const struct sky_data *d = data;
    gpu_bind(context->commands, graph_pipeline(context, &d->state));
    gpu_push(context->commands, &d->push, sizeof d->push);
    gpu_draw(context->commands, 3, 1, 0, 0);
}

/* The mip of the cube that is filtered for the lobe. */
static float lod_of(struct graph *graph, const struct environment_light *environment, float blur) {
    if (!(blur > 0) || !environment->cube.id) return 0;
    const uint32_t last = environment_last_mip(graph_image_info(graph, environment->cube).width);
    return (float)(pow(fmin(sqrt(BLUR_ALPHA(fmin((double)blur, BLUR_MOST) / 4)), 1), 1 / (double)ENVIRONMENT_ROUGHNESS_POWER) * last);
}

void sky_add(struct graph *graph, const struct environment_light *environment, const struct sky_params *params, VkDeviceAddress view,
             graph_image radiance, graph_image depth) {
    const struct graph_image_params target = graph_image_info(graph, radiance);
    struct sky_data data = {.push = {.view = view, .lod = lod_of(graph, environment, params->blur)}};
    if (params->gradient) data.push.gradient = environment->cube.id ? 1 : 2;
    data.state = (struct gpu_graphics_params){.vertex = &shader_screen_vert,
                                              .fragment = &shader_sky_frag,
                                              .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST,
                                              .color_count = 1,
                                              .color_formats = {target.format},
                                              .depth_format = graph_image_info(graph, depth).format,
                                              .depth_test = true,
                                              .depth_compare = VK_COMPARE_OP_GREATER_OR_EQUAL,
                                              .samples = MAX(target.samples, 1u)};
    struct graph_pass *pass = graph_add_pass(graph, "sky", GRAPH_QUEUE_GRAPHICS, execute, &data, sizeof data);
    if (environment->cube.id) environment_use(pass, environment, GRAPH_READ_FRAGMENT);
    graph_color(pass, radiance, VK_ATTACHMENT_LOAD_OP_LOAD, NULL);
    graph_depth_read_only(pass, depth);
}
