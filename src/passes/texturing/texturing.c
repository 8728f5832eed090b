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
    if (scene->features & GPU_FEATURES_DECALS) form |= TEXTURING_ITEMS | TEXTURING_SLOPES;
    if (scene->features & GPU_FEATURE_LEANING) {
        form |= TEXTURING_SLOPES;
        if (is_virtual && samples > 1) form |= TEXTURING_ITEMS; /* which slopes are stored with then */
    }
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

/* The specialised pipeline; `list` or NULL: of several samples. */
static struct gpu_compute_params pipeline_of(const struct gpu_shader *shader, const struct shade_input *input,
                                             const struct texturing *t, const struct visible_list *list, VkFormat format) {
    const uint32_t values[15] = {[LIGHTING_ID] = input->lighting->bits,
                                 [COUNT_LIGHTS_ID] = input->counters.id != 0,
                                 [HAS_LIGHTS_ID] = 1,
                                 [HAS_METAL_ID] = 1,
                                 [TEXTURING_FORM_ID] = t->form,
                                 [SHOWS_LEVELS_ID] = t->shows_levels,
                                 [FOUND_FEATURES_ID] = input->scene->features,
                                 [HAS_TEXTURES_ID] = 1,
                                 [HAS_NORMAL_MAP_ID] = 1,
                                 [VISIBLE_LISTED_ID] = list ? list->listed : 0,
                                 [VISIBLE_SAMPLES_ID] = t->samples,
                                 [VISIBLE_FLOATS_ID] = format == VK_FORMAT_R32G32B32A32_SFLOAT};
    struct gpu_compute_params pipeline = {.shader = shader, .constant_count = COUNT_OF(values)};
    memcpy(pipeline.constants, values, sizeof values);
    memcpy(&pipeline.constants[GRADIENT_TAPS_ID], &input->scene->gradient_taps, sizeof(float));
    return pipeline;
}

static void add_target_rows(struct graph_pass *pass, const struct texturing *t, const uint32_t *targets,
                            const uint32_t *depth) {
    graph_add_row(pass, graph_samples(depth, t->depth));
    for (uint32_t i = 0; i < t->target_count; i++) graph_add_row(pass, graph_samples(&targets[i], t->targets[i]));
}

static void use_shading(struct graph_pass *pass, const struct shade_input *input, const struct texturing *t) {
    geometry_use_features(pass, input->scene, GRAPH_READ_COMPUTE);
    if (t->pages.address) virtual_use_sample(pass, &t->pages);
    lighting_use(pass, input->lighting, GRAPH_READ_COMPUTE);
}

/* ---- several samples ---- */

static struct visible_list shade_samples(struct graph *graph, const struct shade_input *input, const struct texturing *t,
                                         graph_image radiance) {
    const VkFormat format = graph_image_info(graph, radiance).format;
    const bool counts = input->counters.id;
    struct visible_list list = visible_surfaces_begin(graph, input, radiance);
    struct gpu_texturing_surfaces_push push = {.view = input->view, .target_count = t->target_count};
    struct graph_pass *pass = graph_dispatch(
        graph, &(struct graph_dispatch){.name = "texturing surfaces",
                                        .pipeline = pipeline_of(&shader_texturing_surfaces_comp, input, t, &list, format),
                                        .groups = {DIVIDE_UP(input->width, 8u), DIVIDE_UP(input->height, 8u)},
                                        GRAPH_PUSH(push),
                                        GRAPH_ROWS(graph_writes(&push.sums, list.sums), graph_writes(&push.words, list.words),
                                                   graph_changes(&push.counts, list.counts))});
    add_target_rows(pass, t, push.targets, &push.depth);
    visible_surfaces_end(graph, input, radiance, &list);
    uint64_t bytes = format == VK_FORMAT_R32G32B32A32_SFLOAT ? 12 : 8;
    graph_buffer results = graph_create_buffer(graph, "texturing results", list.capacity * bytes);
    struct gpu_texturing_samples_push shade = {
        .view = input->view, .scene = input->scene->scene, .lighting = input->lighting->address, .pages = t->pages.address};
    const struct gpu_shader *shader = t->form & TEXTURING_VIRTUAL ? &shader_virtual_samples_shade_comp
                                                                  : &shader_texturing_samples_shade_comp;
    pass = graph_dispatch(
        graph, &(struct graph_dispatch){.name = "texturing shade",
                                        .pipeline = pipeline_of(shader, input, t, &list, format),
                                        .indirect = list.dispatches,
                                        GRAPH_PUSH(shade),
                                        GRAPH_ROWS(graph_reads(&shade.words, list.words), graph_reads(&shade.sums, list.sums),
                                                   graph_reads(&shade.entries, list.entries),
                                                   graph_writes(&shade.results, results),
                                                   graph_row_if(counts, graph_changes(&shade.counters, input->counters)),
                                                   graph_row_if(counts, graph_changes(&shade.counts, list.counts)))});
    add_target_rows(pass, t, shade.targets, &shade.depth);
    use_shading(pass, input, t);
    visible_spread_add(graph, input, &list, results, radiance);
    return list;
}

struct visible_list texturing_shade_add(struct graph *graph, const struct shade_input *input,
                                        const struct texturing *texturing, graph_image radiance) {
    const struct texturing *t = texturing;
    if (t->samples > 1) return shade_samples(graph, input, t, radiance);
    const struct gpu_shader *shader =
        t->form & TEXTURING_VIRTUAL ? &shader_virtual_shade_comp : &shader_texturing_shade_comp;
    struct gpu_texturing_push push = {.view = input->view,
                                      .scene = input->scene->scene,
                                      .lighting = input->lighting->address,
                                      .pages = t->pages.address,
                                      .background = {input->background[0], input->background[1], input->background[2]}};
    struct graph_pass *pass = graph_dispatch(
        graph,
        &(struct graph_dispatch){
            .name = "texturing shade",
            .pipeline = pipeline_of(shader, input, t, NULL, graph_image_info(graph, radiance).format),
            .groups = {DIVIDE_UP(input->width, 8u), DIVIDE_UP(input->height, 8u)},
            GRAPH_PUSH(push),
            GRAPH_ROWS(graph_stores(&push.radiance, radiance),
                       graph_row_if(input->counters.id, graph_changes(&push.counters, input->counters)))});
    add_target_rows(pass, t, push.targets, &push.depth);
    use_shading(pass, input, t);
    return (struct visible_list){0};
}

/* ---- what the atlas cannot hold ---- */

struct forward_data {
    const struct geometry_scene *scene;
    struct geometry_draws draws;
    VkDeviceAddress view, lighting;
    graph_buffer counters;
    struct gpu_graphics_params state;
};

static void execute_forward(const struct graph_context *context, const void *data) {
    const struct forward_data *d = data;
    struct gpu_geometry_push push = {
        .view = d->view, .lighting = d->lighting, .counters = d->counters.id ? graph_address(context, d->counters) : 0};
    geometry_draw(context, d->scene, &d->draws, GEOMETRY_NOT_IN(VIRTUAL_FORWARD), &d->state, NULL, push);
}

void texturing_forward_add(struct graph *graph, const struct shade_input *input, graph_image radiance, graph_image depth) {
    if (!geometry_draw_count(input->scene, GEOMETRY_NOT_IN(VIRTUAL_FORWARD))) return;
    struct forward_data data = {.scene = input->scene,
                                .draws = *input->draws,
                                .view = input->view,
                                .lighting = input->lighting->address,
                                .counters = input->counters};
    data.state = (struct gpu_graphics_params){.fragment = &shader_forward_early_frag,
                                              .constant_count = 2,
                                              .constants = {[LIGHTING_ID] = input->lighting->bits, [COUNT_LIGHTS_ID] = input->counters.id != 0},
                                              .color_count = 1,
                                              .color_formats = {graph_image_info(graph, radiance).format},
                                              .depth_format = GEOMETRY_DEPTH_FORMAT,
                                              .depth_test = true,
                                              .depth_compare = VK_COMPARE_OP_EQUAL,
                                              .samples = samples_of(graph, depth)};
    struct graph_pass *pass =
        graph_add_pass(graph, "lit forward", GRAPH_QUEUE_GRAPHICS, execute_forward, &data, sizeof data);
    geometry_use(pass, input->scene, input->draws, GEOMETRY_NOT_IN(VIRTUAL_FORWARD));
    lighting_use(pass, input->lighting, GRAPH_READ_FRAGMENT);
    if (input->counters.id) graph_use_buffer(pass, input->counters, GRAPH_READ_WRITE_FRAGMENT);
    graph_color(pass, radiance, VK_ATTACHMENT_LOAD_OP_LOAD, (float[4]){0});
    graph_depth_read_only(pass, depth);
}
