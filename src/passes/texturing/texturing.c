/* SPDX-License-Identifier: MIT */
#include "passes/texturing/texturing.h"

#include "scene_shared.h"
#include "shaders.h"

/* ---- the targets ---- */

static uint32_t form_of(const struct geometry_scene *scene, bool is_virtual, bool derived) {
    uint32_t form = is_virtual ? TEXTURING_VIRTUAL : derived ? TEXTURING_SLOPES : TEXTURING_GRADIENTS;
    if (!is_virtual && scene->attributes & GEOMETRY_UV1) form |= TEXTURING_UV1;
    if (scene->attributes & GEOMETRY_COLORS) form |= TEXTURING_COLORS;
    if (scene->features) form |= TEXTURING_ITEMS | TEXTURING_SLOPES;
    if (scene->features & GPU_FEATURE_MESH_DECALS) form |= TEXTURING_BIND;
    return form;
}

static void add_target(struct graph *graph, const struct shade_input *input, const char *name, VkFormat format,
                       struct texturing *t) {
    struct graph_image_params params = {.name = name, .format = format, .width = input->width, .height = input->height};
    t->targets[t->target_count++] = graph_create_image(graph, &params);
    t->bytes += gpu_texel_bytes(format);
}

static void add_targets(struct graph *graph, const struct shade_input *input, struct texturing *t) {
    uint32_t form = t->form, numbers = form & TEXTURING_ITEMS ? input->scene->item_count : input->scene->material_count;
    VkFormat pair = VK_FORMAT_R32G32_UINT, four = VK_FORMAT_R32G32B32A32_UINT;
    VkFormat least = form & TEXTURING_VIRTUAL ? VK_FORMAT_R32_UINT : pair;
    add_target(graph, input, "texturing frame", least, t);
    add_target(graph, input, "texturing uv", form & TEXTURING_UV1 ? four : least, t);
    if (!(form & TEXTURING_VIRTUAL) || form & TEXTURING_ITEMS)
        add_target(graph, input, "texturing id", numbers <= 65536 ? VK_FORMAT_R16_UINT : VK_FORMAT_R32_UINT, t);
    if (form & TEXTURING_GRADIENTS) add_target(graph, input, "texturing gradients", form & TEXTURING_UV1 ? four : pair, t);
    if (form & TEXTURING_SLOPES) add_target(graph, input, "texturing slopes", VK_FORMAT_R32_UINT, t);
    if (form & TEXTURING_COLORS) add_target(graph, input, "texturing colors", pair, t);
    if (!(form & TEXTURING_BIND)) return;
    add_target(graph, input, "texturing bind", four, t);
    add_target(graph, input, "texturing bind changes", pair, t);
}

/* ---- geometry ---- */

struct targets_data {
    const struct geometry_scene *scene;
    struct geometry_draws draws;
    VkDeviceAddress view, pages;
    struct gpu_graphics_params state;
};

static void execute_targets(const struct graph_context *context, const void *data) {
    const struct targets_data *d = data;
    struct gpu_texturing_geometry_push push = {.geometry = {.view = d->view}, .pages = d->pages};
    geometry_draw_with(context, d->scene, &d->draws, GEOMETRY_OPAQUE, &d->state, &shader_texturing_mask_frag, &push.geometry,
                       sizeof push);
}

static struct texturing draw_targets(struct graph *graph, const struct shade_input *input, struct texturing t,
                                     const char *name, bool prepass) {
    add_targets(graph, input, &t);
    struct targets_data data = {
        .scene = input->scene, .draws = *input->draws, .view = input->view, .pages = t.pages.address};
    data.state =
        (struct gpu_graphics_params){.fragment = &shader_texturing_frag,
                                     .constant_count = 5,
                                     .constants = {[2] = 1, [3] = 1, [4] = t.form},
                                     .color_count = t.target_count,
                                     .depth_format = GEOMETRY_DEPTH_FORMAT,
                                     .depth_test = true,
                                     .depth_write = !prepass,
                                     .depth_compare = prepass ? VK_COMPARE_OP_EQUAL : VK_COMPARE_OP_GREATER_OR_EQUAL,
                                     .samples = 1};
    for (uint32_t i = 0; i < t.target_count; i++) data.state.color_formats[i] = graph_image_info(graph, t.targets[i]).format;
    struct graph_pass *pass = graph_add_pass(graph, name, GRAPH_QUEUE_GRAPHICS, execute_targets, &data, sizeof data);
    geometry_use(pass, input->scene, input->draws, GEOMETRY_OPAQUE);
    if (t.pages.address) virtual_use_locate(pass, &t.pages);
    static const float none[4];
    for (uint32_t i = 0; i < t.target_count; i++) graph_color(pass, t.targets[i], VK_ATTACHMENT_LOAD_OP_CLEAR, none);
    if (prepass)
        graph_depth_read_only(pass, t.depth);
    else
        graph_depth(pass, t.depth, VK_ATTACHMENT_LOAD_OP_CLEAR, 0);
    return t;
}

struct texturing texturing_add(struct graph *graph, const struct shade_input *input, bool derived, bool prepass,
                               graph_image depth) {
    struct texturing t = {.depth = depth, .form = form_of(input->scene, false, derived)};
    return draw_targets(graph, input, t, "texturing", prepass);
}

struct texturing texturing_virtual_add(struct graph *graph, const struct shade_input *input,
                                       const struct virtual_frame *pages, const char *name, bool prepass,
                                       graph_image depth) {
    struct texturing t = {.depth = depth, .form = form_of(input->scene, true, false), .pages = *pages};
    return draw_targets(graph, input, t, name, prepass);
}

/* ---- shading ---- */

struct shade_data {
    struct texturing texturing;
    const struct geometry_scene *scene;
    graph_image radiance;
    VkDeviceAddress view, lights;
    graph_buffer counters;
    uint32_t kind, width, height;
    float background[3];
};

static void execute_shade(const struct graph_context *context, const void *data) {
    const struct shade_data *d = data;
    struct gpu_compute_params params = {.shader = d->texturing.form & TEXTURING_VIRTUAL ? &shader_virtual_shade_comp
                                                                                        : &shader_texturing_shade_comp,
                                        .constant_count = 10,
                                        .constants = {d->kind, d->counters.id != 0, 1, 1, d->texturing.form,
                                                      d->texturing.shows_levels, [9] = d->scene->features}};
    memcpy(&params.constants[8], &d->scene->gradient_taps, sizeof(float));
    struct gpu_texturing_push push = {.view = d->view,
                                      .scene = d->scene->scene,
                                      .lights = d->lights,
                                      .counters = d->counters.id ? graph_address(context, d->counters) : 0,
                                      .pages = d->texturing.pages.address,
                                      .depth = graph_sampled(context, d->texturing.depth),
                                      .radiance = graph_storage(context, d->radiance),
                                      .background = {d->background[0], d->background[1], d->background[2]}};
    for (uint32_t i = 0; i < d->texturing.target_count; i++)
        push.targets[i] = graph_sampled(context, d->texturing.targets[i]);
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_dispatch(context->commands, DIVIDE_UP(d->width, 8u), DIVIDE_UP(d->height, 8u), 1);
}

void texturing_shade_add(struct graph *graph, const struct shade_input *input, const struct texturing *texturing,
                         graph_image radiance) {
    struct shade_data data = {.texturing = *texturing,
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
        graph_add_pass(graph, "texturing shade", GRAPH_QUEUE_GRAPHICS, execute_shade, &data, sizeof data);
    geometry_use_features(pass, input->scene, GRAPH_READ_COMPUTE);
    if (texturing->pages.address) virtual_use_sample(pass, &texturing->pages);
    graph_use_image(pass, texturing->depth, GRAPH_SAMPLE_COMPUTE);
    for (uint32_t i = 0; i < texturing->target_count; i++)
        graph_use_image(pass, texturing->targets[i], GRAPH_SAMPLE_COMPUTE);
    graph_use_image(pass, radiance, GRAPH_WRITE_COMPUTE);
    light_list_use(pass, input->lights, GRAPH_READ_COMPUTE);
    if (input->counters.id) graph_use_buffer(pass, input->counters, GRAPH_READ_WRITE_COMPUTE);
}

/* ---- what the atlas cannot hold ---- */

struct forward_data {
    const struct geometry_scene *scene;
    struct geometry_draws draws;
    VkDeviceAddress view, lights;
    graph_buffer counters;
    struct gpu_graphics_params state;
};

static void execute_forward(const struct graph_context *context, const void *data) {
    const struct forward_data *d = data;
    struct gpu_geometry_push push = {
        .view = d->view, .lights = d->lights, .counters = d->counters.id ? graph_address(context, d->counters) : 0};
    geometry_draw(context, d->scene, &d->draws, GEOMETRY_NOT_IN(VIRTUAL_FORWARD), &d->state, NULL, push);
}

void texturing_forward_add(struct graph *graph, const struct shade_input *input, graph_image radiance, graph_image depth) {
    if (!geometry_draw_count(input->scene, GEOMETRY_NOT_IN(VIRTUAL_FORWARD))) return;
    struct forward_data data = {.scene = input->scene,
                                .draws = *input->draws,
                                .view = input->view,
                                .lights = input->lights->header,
                                .counters = input->counters};
    data.state = (struct gpu_graphics_params){.fragment = &shader_forward_early_frag,
                                              .constant_count = 2,
                                              .constants = {input->lights->kind, input->counters.id != 0},
                                              .color_count = 1,
                                              .color_formats = {graph_image_info(graph, radiance).format},
                                              .depth_format = GEOMETRY_DEPTH_FORMAT,
                                              .depth_test = true,
                                              .depth_compare = VK_COMPARE_OP_EQUAL,
                                              .samples = 1};
    struct graph_pass *pass =
        graph_add_pass(graph, "lit forward", GRAPH_QUEUE_GRAPHICS, execute_forward, &data, sizeof data);
    geometry_use(pass, input->scene, input->draws, GEOMETRY_NOT_IN(VIRTUAL_FORWARD));
    light_list_use(pass, input->lights, GRAPH_READ_FRAGMENT);
    if (input->counters.id) graph_use_buffer(pass, input->counters, GRAPH_READ_WRITE_FRAGMENT);
    graph_color(pass, radiance, VK_ATTACHMENT_LOAD_OP_LOAD, (float[4]){0});
    graph_depth_read_only(pass, depth);
}
