/* SPDX-License-Identifier: MIT */
#include "passes/visibility/visibility.h"

#include "passes/visibility/visibility_shared.h"
#include "scene_shared.h"
#include "shaders.h"

static uint32_t bits_of(uint64_t value) {
    uint32_t bits = 0;
    for (; value; value >>= 1) bits++;
    return bits;
}

uint32_t visibility_bits(uint32_t item_count, uint32_t triangle_count, uint32_t *out_triangle_bits) {
    *out_triangle_bits = triangle_count > 1 ? bits_of(triangle_count - 1) : 0;
    uint32_t bits = *out_triangle_bits + bits_of(item_count);
    return bits <= 32 ? 32 : bits <= 48 ? 48 : 64;
}

/* ---- ids ---- */

struct ids_data {
    const struct geometry_scene *scene;
    struct geometry_draws draws;
    VkDeviceAddress view;
    struct gpu_graphics_params state;
};

static void execute_ids(const struct graph_context *context, const void *data) {
    const struct ids_data *d = data;
    geometry_draw(context, d->scene, &d->draws, GEOMETRY_OPAQUE, &d->state, &shader_visibility_mask_frag,
                  (struct gpu_geometry_push){.view = d->view});
}

struct visibility visibility_add(struct graph *graph, const struct shade_input *input, uint32_t bits, graph_image depth) {
    struct visibility v = {.depth = depth};
    uint32_t item_count = input->scene->item_count;
    uint32_t needed = visibility_bits(item_count, input->scene->most_triangles, &v.triangle_bits);
    if (bits > needed) v.triangle_bits = MIN(bits - bits_of(item_count), 31u); /* items reach into the upper bits */
    bits = MAX(bits, needed);
    struct graph_image_params params = {
        .name = "visibility", .format = VK_FORMAT_R32_UINT, .width = input->width, .height = input->height};
    v.ids = graph_create_image(graph, &params);
    if (bits > 32) {
        params.name = "visibility high";
        params.format = bits == 48 ? VK_FORMAT_R16_UINT : VK_FORMAT_R32_UINT;
        v.ids_high = graph_create_image(graph, &params);
    }
    struct ids_data data = {.scene = input->scene, .draws = *input->draws, .view = input->view};
    data.state =
        (struct gpu_graphics_params){.fragment = &shader_visibility_frag,
                                     .constant_count = 8,
                                     .constants = {[7] = v.triangle_bits},
                                     .color_count = bits > 32 ? 2 : 1,
                                     .color_formats = {VK_FORMAT_R32_UINT, bits > 32 ? params.format : 0},
                                     .depth_format = GEOMETRY_DEPTH_FORMAT,
                                     .depth_test = true,
                                     .depth_write = true,
                                     /* Of surfaces at equal depth the last one drawn wins, as in forward shading. */
                                     .depth_compare = VK_COMPARE_OP_GREATER_OR_EQUAL,
                                     .samples = 1};
    struct graph_pass *pass = graph_add_pass(graph, "visibility", GRAPH_QUEUE_GRAPHICS, execute_ids, &data, sizeof data);
    geometry_use(pass, input->scene, input->draws, GEOMETRY_OPAQUE);
    static const float none[4];
    graph_color(pass, v.ids, VK_ATTACHMENT_LOAD_OP_CLEAR, none);
    if (v.ids_high.id) graph_color(pass, v.ids_high, VK_ATTACHMENT_LOAD_OP_CLEAR, none);
    graph_depth(pass, depth, VK_ATTACHMENT_LOAD_OP_CLEAR, 0);
    return v;
}

/* ---- shading ---- */

struct shade_data {
    struct visibility visibility;
    const struct geometry_scene *scene;
    graph_image radiance;
    VkDeviceAddress view, lights;
    graph_buffer counters;
    uint32_t kind, width, height;
    float background[3];
};

static void execute_shade(const struct graph_context *context, const void *data) {
    const struct shade_data *d = data;
    struct gpu_compute_params params = {.shader = &shader_visibility_shade_comp,
                                        .constant_count = 10,
                                        .constants = {d->kind, d->counters.id != 0, 1, 1, [9] = d->scene->features}};
    memcpy(&params.constants[8], &d->scene->gradient_taps, sizeof(float));
    struct gpu_visibility_push push = {.view = d->view,
                                       .scene = d->scene->scene,
                                       .lights = d->lights,
                                       .counters = d->counters.id ? graph_address(context, d->counters) : 0,
                                       .indices = d->scene->indices->address,
                                       .ids = graph_sampled(context, d->visibility.ids),
                                       .ids_high = d->visibility.ids_high.id ? graph_sampled(context, d->visibility.ids_high)
                                                                             : GPU_TEXTURE_NONE,
                                       .radiance = graph_storage(context, d->radiance),
                                       .triangle_bits = d->visibility.triangle_bits,
                                       .background = {d->background[0], d->background[1], d->background[2]}};
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_dispatch(context->commands, DIVIDE_UP(d->width, 8u), DIVIDE_UP(d->height, 8u), 1);
}

void visibility_shade_add(struct graph *graph, const struct shade_input *input, const struct visibility *visibility,
                          graph_image radiance) {
    struct shade_data data = {.visibility = *visibility,
                              .scene = input->scene,
                              .radiance = radiance,
                              .view = input->view,
                              .lights = input->lights->header,
                              .counters = input->counters,
                              .kind = input->lights->kind,
                              .width = input->width,
                              .height = input->height,
                              .background = {input->background[0], input->background[1], input->background[2]}};
    struct graph_pass *pass =
        graph_add_pass(graph, "visibility shade", GRAPH_QUEUE_GRAPHICS, execute_shade, &data, sizeof data);
    graph_use_buffer(pass, input->scene->vertices, GRAPH_READ_COMPUTE);
    geometry_use_features(pass, input->scene, GRAPH_READ_COMPUTE);
    graph_use_image(pass, visibility->ids, GRAPH_SAMPLE_COMPUTE);
    if (visibility->ids_high.id) graph_use_image(pass, visibility->ids_high, GRAPH_SAMPLE_COMPUTE);
    graph_use_image(pass, radiance, GRAPH_WRITE_COMPUTE);
    light_list_use(pass, input->lights, GRAPH_READ_COMPUTE);
    if (input->counters.id) graph_use_buffer(pass, input->counters, GRAPH_READ_WRITE_COMPUTE);
}
