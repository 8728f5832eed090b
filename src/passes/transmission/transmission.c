/* SPDX-License-Identifier: MIT */
#include "passes/transmission/transmission.h"

#include "passes/transmission/transmission_behind_shared.h"
#include "passes/transmission/transmission_shared.h"
#include "shaders.h"

/* ---- depth of the layers ---- */

struct copy_data {
    graph_image from, to;
};

static void execute_copy(const struct graph_context *context, const void *data) {
    const struct copy_data *d = data;
    gpu_copy_image(context->commands, graph_get_image(context, d->from), graph_get_image(context, d->to), NULL);
}

struct depth_data {
    const struct geometry_scene *scene;
    struct geometry_draws draws;
    VkDeviceAddress view;
    graph_image nearer; /* id 0: the first layer */
    uint32_t samples;
};

static void execute_depth(const struct graph_context *context, const void *data) {
    const struct depth_data *d = data;
    struct gpu_graphics_params state = {.depth_format = GEOMETRY_DEPTH_FORMAT,
                                        .depth_test = true,
                                        .depth_write = true,
                                        .depth_compare = VK_COMPARE_OP_GREATER,
                                        .samples = d->samples};
    struct gpu_transmission_depth_push push = {.geometry = {.view = d->view}};
    if (!d->nearer.id) {
        geometry_draw(context, d->scene, &d->draws, GEOMETRY_GLASS, &state, &shader_depth_frag, push.geometry);
        return;
    }
    push.nearer = graph_sampled(context, d->nearer);
    state.fragment = d->samples > 1 ? &shader_transmission_depth_samples_frag : &shader_transmission_depth_frag;
    geometry_draw_with(context, d->scene, &d->draws, GEOMETRY_GLASS, &state, NULL, &push.geometry, sizeof push);
}

/* The nearest surfaces between `nearer`, or the viewer, and what is opaque; that where there is none. */
static graph_image add_depth(struct graph *graph, const struct shade_input *input, uint32_t layer, graph_image nearer, graph_image depth) {
    struct graph_image_params params = graph_image_info(graph, depth);
    params.name = graph_numbered_name(graph, "transmission depth", layer);
    params.layers = 1;
    graph_image out = graph_create_image(graph, &params);
    const struct copy_data copy = {depth, out};
    struct graph_pass *pass = graph_add_pass(graph, graph_numbered_name(graph, "transmission depth copy", layer), GRAPH_QUEUE_GRAPHICS,
                                             execute_copy, &copy, sizeof copy);
    graph_use_image(pass, depth, GRAPH_COPY_FROM);
    graph_use_image(pass, out, GRAPH_COPY_TO);
    const struct depth_data data = {input->scene, *input->draws, input->view, nearer, MAX(params.samples, 1u)};
    pass = graph_add_pass(graph, graph_numbered_name(graph, "transmission depth", layer), GRAPH_QUEUE_GRAPHICS, execute_depth, &data, sizeof data);
    geometry_use(pass, input->scene, input->draws, GEOMETRY_GLASS);
    if (nearer.id) graph_use_image(pass, nearer, GRAPH_SAMPLE_FRAGMENT);
    graph_depth(pass, out, VK_ATTACHMENT_LOAD_OP_LOAD, 0);
    return out;
}

/* ---- how many layers there are ---- */

struct count_data {
    const struct geometry_scene *scene;
    struct geometry_draws draws;
    VkDeviceAddress view;
    graph_buffer counts, totals;
    uint32_t samples;
};

static void execute_count(const struct graph_context *context, const void *data) {
    const struct count_data *d = data;
    const struct gpu_graphics_params state = {.fragment = &shader_transmission_count_frag,
                                              .depth_format = GEOMETRY_DEPTH_FORMAT,
                                              .depth_test = true,
                                              .depth_compare = VK_COMPARE_OP_GREATER,
                                              .samples = d->samples};
    struct gpu_transmission_count_push push = {.geometry = {.view = d->view, .counters = graph_address(context, d->counts)},
                                               .totals = graph_address(context, d->totals)};
    geometry_draw_with(context, d->scene, &d->draws, GEOMETRY_GLASS, &state, NULL, &push.geometry, sizeof push);
}

static graph_buffer add_count(struct graph *graph, const struct shade_input *input, graph_image depth) {
    struct count_data data = {.scene = input->scene,
                              .draws = *input->draws,
                              .view = input->view,
                              .counts = graph_create_buffer(graph, "transmission counts", (uint64_t)input->width * input->height * 4),
                              .totals = graph_create_buffer(graph, "transmission totals", sizeof(struct transmission_totals)),
                              .samples = MAX(graph_image_info(graph, depth).samples, 1u)};
    graph_add_clear(graph, "transmission clear", GRAPH_QUEUE_GRAPHICS, (struct graph_clear){.buffers = {data.counts, data.totals}});
    struct graph_pass *pass = graph_add_pass(graph, "transmission count", GRAPH_QUEUE_GRAPHICS, execute_count, &data, sizeof data);
    geometry_use(pass, input->scene, input->draws, GEOMETRY_GLASS);
    graph_use_buffer(pass, data.counts, GRAPH_READ_WRITE_FRAGMENT);
    graph_use_buffer(pass, data.totals, GRAPH_READ_WRITE_FRAGMENT);
    graph_depth_read_only(pass, depth);
    return data.totals;
}

/* ---- what is behind a layer ---- */

struct image_data {
    graph_buffer from;
    graph_image to;
};

static void execute_image(const struct graph_context *context, const void *data) {
    const struct image_data *d = data;
    gpu_copy_buffer_to_image(context->commands, graph_get_buffer(context, d->from), 0, graph_get_image(context, d->to));
}

static uvec2 mip_size(const struct shade_input *input, uint32_t mip) {
    return (uvec2){MAX(input->width >> mip, 1u), MAX(input->height >> mip, 1u)};
}

/* The format of the copy: halves hold no more than 65504 cd/m^2. */
static VkFormat behind_format(gpu_device *device, VkFormat radiance) {
    const bool floats = radiance == VK_FORMAT_R32G32B32A32_SFLOAT && gpu_format_supports(device, radiance, VK_FORMAT_FEATURE_2_SAMPLED_IMAGE_FILTER_LINEAR_BIT);
    return floats ? radiance : VK_FORMAT_R16G16B16A16_SFLOAT;
}

static uint32_t texel_size(VkFormat format) { return format == VK_FORMAT_R32G32B32A32_SFLOAT ? 16 : 8; }

/* The picture with all its mips; `shown` is its depth. */
static graph_image add_behind(struct graph *graph, const struct shade_input *input, uint32_t layer, uint32_t mips, VkFormat format, graph_image radiance,
                              graph_image shown) {
    const bool floats = texel_size(format) == 16;
    uint64_t texel_count = 0;
    for (uint32_t mip = 0; mip < mips; mip++) texel_count += (uint64_t)mip_size(input, mip).x * mip_size(input, mip).y;
    graph_buffer texels = graph_create_buffer(graph, graph_numbered_name(graph, "transmission texels", layer), texel_count * texel_size(format));
    graph_image behind = graph_create_image(graph, &(struct graph_image_params){.name = graph_numbered_name(graph, "transmission behind", layer),
                                                                                .format = format,
                                                                                .width = input->width,
                                                                                .height = input->height,
                                                                                .mips = mips});
    struct gpu_transmission_behind_push push = {.view = input->view, .samples = MAX(graph_image_info(graph, radiance).samples, 1u)};
    graph_dispatch(graph, &(struct graph_dispatch){.name = graph_numbered_name(graph, "transmission behind", layer),
                                                   .pipeline = {&shader_transmission_behind_comp, 2, {floats, push.samples}},
                                                   .groups = {DIVIDE_UP(input->width, 8u), DIVIDE_UP(input->height, 8u)},
                                                   GRAPH_PUSH(push),
                                                   GRAPH_ROWS(graph_samples(&push.radiance, radiance), graph_samples(&push.depth, shown),
                                                              graph_writes(&push.texels, texels))});
    struct gpu_transmission_level_push level = {.from = 0};
    for (uint32_t mip = 1; mip < mips; mip++) {
        level.from_size = mip_size(input, mip - 1), level.to_size = mip_size(input, mip);
        level.to = level.from + level.from_size.x * level.from_size.y;
        const char *name = graph_name(graph, "transmission level %u", mip);
        if (layer) name = graph_name(graph, "transmission level %u of %u", mip, layer);
        graph_dispatch(graph, &(struct graph_dispatch){.name = name,
                                                       .pipeline = {&shader_transmission_level_comp, 1, {floats}},
                                                       .groups = {DIVIDE_UP(level.to_size.x, 8u), DIVIDE_UP(level.to_size.y, 8u)},
                                                       GRAPH_PUSH(level),
                                                       GRAPH_ROWS(graph_changes(&level.texels, texels))});
        level.from = level.to;
    }
    const struct image_data data = {texels, behind};
    struct graph_pass *pass = graph_add_pass(graph, graph_numbered_name(graph, "transmission copy", layer), GRAPH_QUEUE_GRAPHICS, execute_image,
                                             &data, sizeof data);
    graph_use_buffer(pass, texels, GRAPH_COPY_FROM);
    graph_use_image(pass, behind, GRAPH_COPY_TO);
    return behind;
}

/* ---- shading ---- */

struct draw_data {
    const struct geometry_scene *scene;
    struct geometry_draws draws;
    VkDeviceAddress view, lighting;
    graph_buffer counters;
    graph_image behind;
    struct gpu_graphics_params state;
    uint32_t mips;
};

static void execute_draw(const struct graph_context *context, const void *data) {
    const struct draw_data *d = data;
    struct gpu_transmission_push push = {.geometry = {.view = d->view,
                                                      .lighting = d->lighting,
                                                      .counters = d->counters.id ? graph_address(context, d->counters) : 0},
                                         .behind = graph_sampled(context, d->behind),
                                         .last_mip = (float)(d->mips - 1)};
    geometry_draw_with(context, d->scene, &d->draws, GEOMETRY_GLASS, &d->state, NULL, &push.geometry, sizeof push);
}

static void add_draw(struct graph *graph, const struct shade_input *input, uint32_t layer, uint32_t mips, graph_image behind,
                     graph_image radiance, graph_image depth) {
    const struct graph_image_params target = graph_image_info(graph, radiance);
    struct draw_data data = {.scene = input->scene,
                             .draws = *input->draws,
                             .view = input->view,
                             .lighting = input->lighting->address,
                             .counters = input->counters,
                             .behind = behind,
                             .mips = mips};
    data.state = (struct gpu_graphics_params){.fragment = &shader_transmission_frag,
                                              .constant_count = 2,
                                              .constants = {[LIGHTING_ID] = input->lighting->bits, [COUNT_LIGHTS_ID] = input->counters.id != 0},
                                              .color_count = 1,
                                              .color_formats = {target.format},
                                              .depth_format = GEOMETRY_DEPTH_FORMAT,
                                              .depth_test = true,
                                              .depth_compare = VK_COMPARE_OP_EQUAL,
                                              .samples = MAX(target.samples, 1u)};
    struct graph_pass *pass =
        graph_add_pass(graph, graph_numbered_name(graph, "transmission", layer), GRAPH_QUEUE_GRAPHICS, execute_draw, &data, sizeof data);
    geometry_use(pass, input->scene, input->draws, GEOMETRY_GLASS);
    lighting_use(pass, input->lighting, GRAPH_READ_FRAGMENT);
    if (input->counters.id) graph_use_buffer(pass, input->counters, GRAPH_READ_WRITE_FRAGMENT);
    graph_use_image(pass, behind, GRAPH_SAMPLE_FRAGMENT);
    graph_color(pass, radiance, VK_ATTACHMENT_LOAD_OP_LOAD, NULL);
    graph_depth_read_only(pass, depth);
}

struct transmission transmission_find(struct graph *graph, gpu_device *device, const struct shade_input *input, uint32_t layers, graph_image radiance,
                                      graph_image depth) {
    struct transmission out = {.layers = layers,
                               .format = behind_format(device, graph_image_info(graph, radiance).format),
                               .totals = add_count(graph, input, depth)};
    for (uint32_t i = 0; i < layers; i++) out.depths[i] = add_depth(graph, input, i, i ? out.depths[i - 1] : (graph_image){0}, depth);
    const uint64_t pixels = (uint64_t)input->width * input->height;
    out.byte_count = pixels * (layers * 4ull * MAX(graph_image_info(graph, depth).samples, 1u) + 2 * texel_size(out.format) * 4 / 3 + 4);
    return out;
}

void transmission_add(struct graph *graph, const struct shade_input *input, const struct transmission *found,
                      graph_image radiance, graph_image depth) {
    uint32_t mips = 1;
    while (MAX(input->width, input->height) >> mips && mips < TRANSMISSION_MIPS) mips++;
    for (uint32_t i = found->layers; i-- > 0;) {
        /* As far as what is opaque: through a layer behind this one that is what one sees. */
        graph_image behind = add_behind(graph, input, i, mips, found->format, radiance, depth);
        add_draw(graph, input, i, mips, behind, radiance, found->depths[i]);
    }
}
