/* SPDX-License-Identifier: MIT */
#include "passes/texturing/texturing.h"

#include "passes/shade/samples_shared.h"
#include "passes/visibility/visible.h"
#include "scene_shared.h"
#include "shaders.h"

/* ---- the targets ---- */

static uint32_t samples_of(struct graph *graph, graph_image image) {
    return MAX(graph_image_info(graph, image).samples, 1u);
}

static uint32_t form_of(const struct geometry_scene *scene, bool is_virtual, bool derived, uint32_t samples) {
    uint32_t form = is_virtual ? TEXTURING_VIRTUAL : derived ? TEXTURING_SLOPES : TEXTURING_GRADIENTS;
    if (!is_virtual && scene->attributes & GEOMETRY_UV1) form |= TEXTURING_UV1;
    if (scene->attributes & GEOMETRY_COLORS) form |= TEXTURING_COLORS;
    if (scene->features) form |= TEXTURING_ITEMS | TEXTURING_SLOPES;
    if (scene->features & GPU_FEATURE_MESH_DECALS) form |= TEXTURING_BIND;
    if (samples > 1) form |= TEXTURING_SAMPLES;
    return form;
}

static void add_target(struct graph *graph, const struct shade_input *input, const char *name, VkFormat format,
                       struct texturing *t) {
    struct graph_image_params params = {
        .name = name, .format = format, .width = input->width, .height = input->height, .samples = t->samples};
    t->targets[t->target_count++] = graph_create_image(graph, &params);
    t->bytes += gpu_texel_bytes(format) * t->samples;
}

/* See target_stored in texturing.glsl. */
static void add_sampled_targets(struct graph *graph, const struct shade_input *input, struct texturing *t) {
    uint32_t form = t->form;
    VkFormat word = VK_FORMAT_R8G8B8A8_UNORM, pair = VK_FORMAT_R16G16B16A16_UNORM, four = VK_FORMAT_R32G32B32A32_SFLOAT;
    bool paged = form & TEXTURING_VIRTUAL;
    add_target(graph, input, "texturing frame", paged ? word : pair, t);
    add_target(graph, input, "texturing uv", paged ? word : form & TEXTURING_UV1 ? four : VK_FORMAT_R32G32_SFLOAT, t);
    if (!paged || form & TEXTURING_ITEMS) add_target(graph, input, "texturing id", form & TEXTURING_SLOPES ? pair : word, t);
    if (form & TEXTURING_GRADIENTS) add_target(graph, input, "texturing gradients", pair, t);
    if (form & TEXTURING_GRADIENTS && form & TEXTURING_UV1) add_target(graph, input, "texturing gradients 1", pair, t);
    if (form & TEXTURING_COLORS) add_target(graph, input, "texturing colors", pair, t);
    if (!(form & TEXTURING_BIND)) return;
    add_target(graph, input, "texturing bind", four, t);
    add_target(graph, input, "texturing bind changes", pair, t);
}

static void add_targets(struct graph *graph, const struct shade_input *input, struct texturing *t) {
    if (t->samples > 1) {
        add_sampled_targets(graph, input, t);
        return;
    }
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
    const struct gpu_shader *mask = d->state.samples > 1 ? &shader_texturing_samples_mask_frag : &shader_texturing_mask_frag;
    geometry_draw_with(context, d->scene, &d->draws, GEOMETRY_OPAQUE, &d->state, mask, &push.geometry, sizeof push);
}

static struct texturing draw_targets(struct graph *graph, const struct shade_input *input, struct texturing t,
                                     const char *name, bool prepass) {
    add_targets(graph, input, &t);
    struct targets_data data = {
        .scene = input->scene, .draws = *input->draws, .view = input->view, .pages = t.pages.address};
    data.state =
        (struct gpu_graphics_params){.fragment = t.samples > 1 ? &shader_texturing_samples_frag : &shader_texturing_frag,
                                     .constant_count = TEXTURING_FORM_ID + 1,
                                     .constants = {[HAS_LIGHTS_ID] = 1, [HAS_METAL_ID] = 1, [TEXTURING_FORM_ID] = t.form},
                                     .color_count = t.target_count,
                                     .depth_format = GEOMETRY_DEPTH_FORMAT,
                                     .depth_test = true,
                                     .depth_write = !prepass,
                                     .depth_compare = prepass ? VK_COMPARE_OP_EQUAL : VK_COMPARE_OP_GREATER_OR_EQUAL,
                                     .samples = t.samples};
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
    uint32_t samples = samples_of(graph, depth);
    struct texturing t = {.depth = depth, .samples = samples, .form = form_of(input->scene, false, derived, samples)};
    return draw_targets(graph, input, t, "texturing", prepass);
}

struct texturing texturing_virtual_add(struct graph *graph, const struct shade_input *input,
                                       const struct virtual_frame *pages, const char *name, bool prepass,
                                       graph_image depth) {
    uint32_t samples = samples_of(graph, depth);
    struct texturing t = {
        .depth = depth, .samples = samples, .form = form_of(input->scene, true, false, samples), .pages = *pages};
    return draw_targets(graph, input, t, name, prepass);
}

/* ---- shading ---- */

struct shade_data {
    struct texturing texturing;
    struct visible_list list; /* with several samples */
    const struct geometry_scene *scene;
    graph_image radiance;
    VkDeviceAddress view, lights;
    graph_buffer counters, results;
    uint32_t kind, width, height;
    VkFormat format;
    float background[3];
};

static struct shade_data shade_data_of(struct graph *graph, const struct shade_input *input,
                                       const struct texturing *texturing, graph_image radiance) {
    return (struct shade_data){.texturing = *texturing,
                               .scene = input->scene,
                               .radiance = radiance,
                               .view = input->view,
                               .lights = input->lights->header,
                               .counters = input->counters,
                               .kind = input->lights->kind,
                               .width = input->width,
                               .height = input->height,
                               .format = graph_image_info(graph, radiance).format,
                               .background = {input->background[0], input->background[1], input->background[2]}};
}

static void set_constants(const struct shade_data *d, uint32_t *count, uint32_t *constants) {
    const struct texturing *t = &d->texturing;
    const uint32_t values[15] = {[LISTS_ID] = d->kind,
                                 [COUNT_LIGHTS_ID] = d->counters.id != 0,
                                 [HAS_LIGHTS_ID] = 1,
                                 [HAS_METAL_ID] = 1,
                                 [TEXTURING_FORM_ID] = t->form,
                                 [SHOWS_LEVELS_ID] = t->shows_levels,
                                 [FOUND_FEATURES_ID] = d->scene->features,
                                 [HAS_TEXTURES_ID] = 1,
                                 [HAS_NORMAL_MAP_ID] = 1,
                                 [VISIBLE_LISTED_ID] = d->list.listed,
                                 [VISIBLE_SAMPLES_ID] = t->samples,
                                 [VISIBLE_FLOATS_ID] = d->format == VK_FORMAT_R32G32B32A32_SFLOAT};
    *count = COUNT_OF(values);
    memcpy(constants, values, sizeof values);
    memcpy(&constants[GRADIENT_TAPS_ID], &d->scene->gradient_taps, sizeof(float));
}

static void sample_targets(const struct graph_context *context, const struct texturing *t, uint32_t *targets,
                           uint32_t *depth) {
    for (uint32_t i = 0; i < t->target_count; i++) targets[i] = graph_sampled(context, t->targets[i]);
    *depth = graph_sampled(context, t->depth);
}

static void use_targets(struct graph_pass *pass, const struct texturing *t) {
    graph_use_image(pass, t->depth, GRAPH_SAMPLE_COMPUTE);
    for (uint32_t i = 0; i < t->target_count; i++) graph_use_image(pass, t->targets[i], GRAPH_SAMPLE_COMPUTE);
}

static void use_shading(struct graph_pass *pass, const struct shade_input *input, const struct texturing *t) {
    geometry_use_features(pass, input->scene, GRAPH_READ_COMPUTE);
    if (t->pages.address) virtual_use_sample(pass, &t->pages);
    use_targets(pass, t);
    light_list_use(pass, input->lights, GRAPH_READ_COMPUTE);
    if (input->counters.id) graph_use_buffer(pass, input->counters, GRAPH_READ_WRITE_COMPUTE);
}

static void execute_shade(const struct graph_context *context, const void *data) {
    const struct shade_data *d = data;
    const struct texturing *t = &d->texturing;
    struct gpu_compute_params params = {.shader = t->form & TEXTURING_VIRTUAL ? &shader_virtual_shade_comp
                                                                              : &shader_texturing_shade_comp};
    set_constants(d, &params.constant_count, params.constants);
    struct gpu_texturing_push push = {.view = d->view,
                                      .scene = d->scene->scene,
                                      .lights = d->lights,
                                      .counters = d->counters.id ? graph_address(context, d->counters) : 0,
                                      .pages = t->pages.address,
                                      .radiance = graph_storage(context, d->radiance),
                                      .background = {d->background[0], d->background[1], d->background[2]}};
    sample_targets(context, t, push.targets, &push.depth);
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_dispatch(context->commands, DIVIDE_UP(d->width, 8u), DIVIDE_UP(d->height, 8u), 1);
}

/* ---- several samples ---- */

static void execute_surfaces(const struct graph_context *context, const void *data) {
    const struct shade_data *d = data;
    struct gpu_compute_params params = {.shader = &shader_texturing_surfaces_comp};
    set_constants(d, &params.constant_count, params.constants);
    struct gpu_texturing_surfaces_push push = {.view = d->view,
                                               .words = graph_address(context, d->list.words),
                                               .sums = graph_address(context, d->list.sums),
                                               .counts = graph_address(context, d->list.counts),
                                               .target_count = d->texturing.target_count};
    sample_targets(context, &d->texturing, push.targets, &push.depth);
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_dispatch(context->commands, DIVIDE_UP(d->width, 8u), DIVIDE_UP(d->height, 8u), 1);
}

static void execute_shade_samples(const struct graph_context *context, const void *data) {
    const struct shade_data *d = data;
    const struct texturing *t = &d->texturing;
    struct gpu_compute_params params = {.shader = t->form & TEXTURING_VIRTUAL ? &shader_virtual_samples_shade_comp
                                                                              : &shader_texturing_samples_shade_comp};
    set_constants(d, &params.constant_count, params.constants);
    struct gpu_texturing_samples_push push = {.view = d->view,
                                              .scene = d->scene->scene,
                                              .lights = d->lights,
                                              .pages = t->pages.address,
                                              .words = graph_address(context, d->list.words),
                                              .sums = graph_address(context, d->list.sums),
                                              .entries = graph_address(context, d->list.entries),
                                              .results = graph_address(context, d->results)};
    if (d->counters.id) {
        push.counters = graph_address(context, d->counters);
        push.counts = graph_address(context, d->list.counts);
    }
    sample_targets(context, t, push.targets, &push.depth);
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_dispatch_indirect(context->commands, graph_get_buffer(context, d->list.dispatches), 0);
}

static struct visible_list shade_samples(struct graph *graph, const struct shade_input *input,
                                         const struct texturing *texturing, graph_image radiance) {
    struct shade_data data = shade_data_of(graph, input, texturing, radiance);
    data.list = visible_surfaces_begin(graph, input, radiance);
    struct graph_pass *pass =
        graph_add_pass(graph, "texturing surfaces", GRAPH_QUEUE_GRAPHICS, execute_surfaces, &data, sizeof data);
    use_targets(pass, texturing);
    graph_use_buffer(pass, data.list.sums, GRAPH_WRITE_COMPUTE);
    graph_use_buffer(pass, data.list.words, GRAPH_WRITE_COMPUTE);
    graph_use_buffer(pass, data.list.counts, GRAPH_READ_WRITE_COMPUTE);
    visible_surfaces_end(graph, input, radiance, &data.list);
    uint64_t bytes = data.format == VK_FORMAT_R32G32B32A32_SFLOAT ? 12 : 8;
    data.results = graph_create_buffer(graph, "texturing results", data.list.capacity * bytes);
    pass = graph_add_pass(graph, "texturing shade", GRAPH_QUEUE_GRAPHICS, execute_shade_samples, &data, sizeof data);
    use_shading(pass, input, texturing);
    graph_use_buffer(pass, data.list.words, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, data.list.sums, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, data.list.entries, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, data.list.dispatches, GRAPH_INDIRECT);
    graph_use_buffer(pass, data.results, GRAPH_WRITE_COMPUTE);
    if (input->counters.id) graph_use_buffer(pass, data.list.counts, GRAPH_READ_WRITE_COMPUTE);
    visible_spread_add(graph, input, &data.list, data.results, radiance);
    return data.list;
}

struct visible_list texturing_shade_add(struct graph *graph, const struct shade_input *input,
                                        const struct texturing *texturing, graph_image radiance) {
    if (texturing->samples > 1) return shade_samples(graph, input, texturing, radiance);
    struct shade_data data = shade_data_of(graph, input, texturing, radiance);
    struct graph_pass *pass =
        graph_add_pass(graph, "texturing shade", GRAPH_QUEUE_GRAPHICS, execute_shade, &data, sizeof data);
    use_shading(pass, input, texturing);
    graph_use_image(pass, radiance, GRAPH_WRITE_COMPUTE);
    return (struct visible_list){0};
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
                                              .constants = {[LISTS_ID] = input->lights->kind, [COUNT_LIGHTS_ID] = input->counters.id != 0},
                                              .color_count = 1,
                                              .color_formats = {graph_image_info(graph, radiance).format},
                                              .depth_format = GEOMETRY_DEPTH_FORMAT,
                                              .depth_test = true,
                                              .depth_compare = VK_COMPARE_OP_EQUAL,
                                              .samples = samples_of(graph, depth)};
    struct graph_pass *pass =
        graph_add_pass(graph, "lit forward", GRAPH_QUEUE_GRAPHICS, execute_forward, &data, sizeof data);
    geometry_use(pass, input->scene, input->draws, GEOMETRY_NOT_IN(VIRTUAL_FORWARD));
    light_list_use(pass, input->lights, GRAPH_READ_FRAGMENT);
    if (input->counters.id) graph_use_buffer(pass, input->counters, GRAPH_READ_WRITE_FRAGMENT);
    graph_color(pass, radiance, VK_ATTACHMENT_LOAD_OP_LOAD, (float[4]){0});
    graph_depth_read_only(pass, depth);
}
