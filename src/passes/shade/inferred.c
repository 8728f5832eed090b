/* SPDX-License-Identifier: MIT */
#include "passes/shade/inferred.h"

#include "passes/shade/inferred_shared.h"
#include "shaders.h"

#define NORMAL_FORMAT VK_FORMAT_R16G16B16A16_UNORM
#define ITEM_FORMAT VK_FORMAT_R32_UINT

struct surfaces_data {
    const struct geometry_scene *scene;
    struct geometry_draws draws;
    VkDeviceAddress view;
    bool blend;
};

static void execute_surfaces(const struct graph_context *context, const void *data) {
    const struct surfaces_data *d = data;
    struct gpu_graphics_params state = {.fragment = &shader_inferred_surfaces_frag,
                                        .constant_count = STIPPLED_ID + 1,
                                        .constants = {[LIGHT_BUFFER_ID] = LIGHT_BUFFER_FOUR},
                                        .color_count = 2,
                                        .color_formats = {NORMAL_FORMAT, ITEM_FORMAT},
                                        .depth_format = GEOMETRY_DEPTH_FORMAT,
                                        .depth_test = true,
                                        .depth_write = true,
                                        .depth_compare = VK_COMPARE_OP_GREATER_OR_EQUAL,
                                        .samples = 1};
    if (d->scene->features & GPU_FEATURE_LEANING) state.color_formats[state.color_count++] = LIGHT_GEOMETRIC_FORMAT;
    struct gpu_geometry_push push = {.view = d->view};
    geometry_draw(context, d->scene, &d->draws, GEOMETRY_OPAQUE, &state, NULL, push);
    if (!d->blend) return;
    state.constants[STIPPLED_ID] = 1;
    geometry_draw(context, d->scene, &d->draws, GEOMETRY_BLEND, &state, NULL, push);
}

struct inferred inferred_surfaces_add(struct graph *graph, const struct shade_input *low, bool blend) {
    struct graph_image_params image = {
        .name = "inferred normals", .format = NORMAL_FORMAT, .width = low->width, .height = low->height};
    struct inferred inferred = {.low = low->view, .surfaces = {.samples = 1, .layers.count = 1}};
    inferred.surfaces.normal = graph_create_image(graph, &image);
    image.name = "inferred items";
    image.format = ITEM_FORMAT;
    inferred.items = graph_create_image(graph, &image);
    if (low->scene->features & GPU_FEATURE_LEANING) {
        image.name = "inferred geometric normals";
        image.format = LIGHT_GEOMETRIC_FORMAT;
        inferred.surfaces.geometric = graph_create_image(graph, &image);
    }
    image.name = "inferred depth";
    image.format = GEOMETRY_DEPTH_FORMAT;
    inferred.surfaces.depth = graph_create_image(graph, &image);
    struct surfaces_data data = {low->scene, *low->draws, low->view, blend};
    struct graph_pass *pass =
        graph_add_pass(graph, "inferred surfaces", GRAPH_QUEUE_GRAPHICS, execute_surfaces, &data, sizeof data);
    geometry_use(pass, low->scene, low->draws, GEOMETRY_OPAQUE);
    if (blend) geometry_use(pass, low->scene, low->draws, GEOMETRY_BLEND);
    static const float zero[4];
    graph_color(pass, inferred.surfaces.normal, VK_ATTACHMENT_LOAD_OP_CLEAR, zero);
    graph_color(pass, inferred.items, VK_ATTACHMENT_LOAD_OP_CLEAR, zero);
    if (inferred.surfaces.geometric.id)
        graph_color(pass, inferred.surfaces.geometric, VK_ATTACHMENT_LOAD_OP_CLEAR, zero);
    graph_depth(pass, inferred.surfaces.depth, VK_ATTACHMENT_LOAD_OP_CLEAR, 0);
    return inferred;
}

struct material_data {
    const struct geometry_scene *scene;
    struct geometry_draws draws;
    struct inferred inferred;
    struct light_sums sums;
    VkDeviceAddress view, lighting;
    graph_buffer counters;
    enum geometry_set set;
    struct gpu_graphics_params state;
};

static void execute_materials(const struct graph_context *context, const void *data) {
    const struct material_data *d = data;
    struct gpu_inferred_material_push push = {
        .geometry = {.view = d->view,
                     .lighting = d->lighting,
                     .counters = d->counters.id ? graph_address(context, d->counters) : 0},
        .low = d->inferred.low,
        .surfaces = light_surfaces_handles(context, &d->inferred.surfaces),
        .items = graph_sampled(context, d->inferred.items)};
    for (uint32_t i = 0; i < d->sums.target_count; i++) push.targets[i] = graph_sampled(context, d->sums.targets[i]);
    geometry_draw_with(context, d->scene, &d->draws, d->set, &d->state, NULL, &push.geometry, sizeof push);
}

void inferred_material_add(struct graph *graph, const struct shade_input *input, enum geometry_set set,
                           const struct inferred *inferred, const struct light_sums *sums, graph_image radiance,
                           graph_image depth) {
    bool blends = set == GEOMETRY_BLEND;
    struct material_data data = {.scene = input->scene,
                                 .draws = *input->draws,
                                 .inferred = *inferred,
                                 .sums = *sums,
                                 .view = input->view,
                                 .lighting = input->lighting->address,
                                 .counters = input->counters,
                                 .set = set};
    data.state = (struct gpu_graphics_params){
        .fragment = &shader_inferred_material_frag,
        .constant_count = STIPPLED_ID + 1,
        .constants = {[LIGHTING_ID] = input->lighting->bits, [COUNT_LIGHTS_ID] = input->counters.id != 0, [HAS_LIGHTS_ID] = 1, [HAS_METAL_ID] = 1,
                      [SAMPLES_ID] = graph_image_info(graph, radiance).samples, [LIGHT_BUFFER_ID] = sums->buffer, [STIPPLED_ID] = blends},
        .color_count = 1,
        .color_formats = {graph_image_info(graph, radiance).format},
        .blends = {blends ? GPU_BLEND_ALPHA : GPU_BLEND_NONE},
        .depth_format = GEOMETRY_DEPTH_FORMAT,
        .depth_test = true,
        .depth_compare = blends ? VK_COMPARE_OP_GREATER : VK_COMPARE_OP_EQUAL,
        .samples = MAX(graph_image_info(graph, radiance).samples, 1u)};
    struct graph_pass *pass = graph_add_pass(graph, blends ? "forward blend" : "light materials", GRAPH_QUEUE_GRAPHICS,
                                             execute_materials, &data, sizeof data);
    geometry_use(pass, input->scene, input->draws, set);
    light_surfaces_use(pass, &inferred->surfaces, GRAPH_SAMPLE_FRAGMENT);
    graph_use_image(pass, inferred->items, GRAPH_SAMPLE_FRAGMENT);
    for (uint32_t i = 0; i < sums->target_count; i++) graph_use_image(pass, sums->targets[i], GRAPH_SAMPLE_FRAGMENT);
    lighting_use(pass, input->lighting, GRAPH_READ_FRAGMENT);
    if (input->counters.id) graph_use_buffer(pass, input->counters, GRAPH_READ_WRITE_FRAGMENT);
    graph_color(pass, radiance, blends ? VK_ATTACHMENT_LOAD_OP_LOAD : VK_ATTACHMENT_LOAD_OP_CLEAR, input->background);
    graph_depth_read_only(pass, depth);
}
