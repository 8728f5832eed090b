/* SPDX-License-Identifier: MIT */
#include "passes/lights/sprites.h"

#include "passes/lights/sprites_shared.h"
#include "shaders.h"

float light_fade(const struct gpu_view *view, const struct gpu_entity_bounds *bounds, float lod) {
    float spread = view->orthographic > 0.5f ? 1 : vec3_distance(bounds->center, view->eye);
    float pixels = bounds->radius * (float)view->size.y / fmaxf(2 * fabsf(view->ndc_scale.y) * spread, 1e-20f);
    float t = pixels / lod - 1;
    if (!(t < 1)) return 1;
    t = fmaxf(t, 0);
    return t * t * (3 - 2 * t);
}

struct sprites_data {
    struct gpu_sprites_push push;
    struct gpu_graphics_params state;
};

static struct gpu_sprites_push push_of(VkDeviceAddress view, const struct light_set *set, float lod) {
    return (struct gpu_sprites_push){.view = view,
                                     .lights = set->lights,
                                     .bounds = set->entities,
                                     .directional_count = set->directional_count,
                                     .local_count = set->local_count,
                                     .lod = lod};
}

void light_fade_add(struct graph *graph, gpu_device *device, VkDeviceAddress view, struct light_set *set, const struct gpu_buffer *lights,
                    const struct gpu_buffer *bounds, float lod) {
    const uint32_t count = set->directional_count + set->local_count;
    if (count == 0) return;
    graph_buffer faded = graph_import_buffer(graph, "faded lights", lights);
    struct gpu_sprites_push push = push_of(view, set, lod);
    push.faded_bounds = bounds->address;
    graph_dispatch(graph,
                   &(struct graph_dispatch){.name = "fade lights",
                                            .pipeline = {.shader = &shader_sprites_fade_comp},
                                            .groups = {DIVIDE_UP(count, 64u)},
                                            GRAPH_PUSH(push),
                                            GRAPH_ROWS(graph_reads(NULL, set->buffer), graph_writes(&push.faded, faded))});
    set->buffer = faded;
    set->lights = lights->address;
    set->shapes = lights->address + set->directional_count * sizeof(struct gpu_light);
    set->entities = bounds->address;
    light_set_send(device, set);
}

static void execute_sprites(const struct graph_context *context, const void *data) {
    const struct sprites_data *d = data;
    gpu_bind(context->commands, gpu_graphics_pipeline(context->device, &d->state));
    gpu_push(context->commands, &d->push, sizeof d->push);
    gpu_draw(context->commands, 4, d->push.local_count, 0, 0);
}

void sprites_add(struct graph *graph, VkDeviceAddress view, const struct light_set *lights, float lod, graph_image radiance, graph_image depth) {
    if (lights->local_count == 0) return;
    struct graph_image_params target = graph_image_info(graph, radiance);
    struct sprites_data data = {.push = push_of(view, lights, lod)};
    data.state = (struct gpu_graphics_params){.vertex = &shader_sprites_vert,
                                              .fragment = &shader_sprites_frag,
                                              .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP,
                                              .color_count = 1,
                                              .color_formats = {target.format},
                                              .blends = {GPU_BLEND_ADD},
                                              .depth_format = graph_image_info(graph, depth).format,
                                              .depth_test = true,
                                              .depth_compare = VK_COMPARE_OP_GREATER_OR_EQUAL,
                                              .samples = MAX(target.samples, 1u)};
    struct graph_pass *pass =
        graph_add_pass(graph, "light sprites", GRAPH_QUEUE_GRAPHICS, execute_sprites, &data, sizeof data);
    graph_use_buffer(pass, lights->buffer, GRAPH_READ_VERTEX);
    graph_color(pass, radiance, VK_ATTACHMENT_LOAD_OP_LOAD, NULL);
    graph_depth_read_only(pass, depth);
}
