/* SPDX-License-Identifier: MIT */
#include "passes/shade/light_prepass.h"

#include "passes/shade/gbuffer_layouts.h"
#include "shaders.h"

/* ---- surfaces ---- */

struct surfaces_data {
    const struct geometry_scene *scene;
    struct geometry_draws draws;
    VkDeviceAddress view;
    struct gpu_graphics_params state;
};

static void execute_surfaces(const struct graph_context *context, const void *data) {
    const struct surfaces_data *d = data;
    geometry_draw(context, d->scene, &d->draws, GEOMETRY_OPAQUE, &d->state, NULL,
                  (struct gpu_geometry_push){.view = d->view});
}

static graph_image create_image(struct graph *graph, const struct shade_input *input, const char *name, VkFormat format,
                                uint32_t samples) {
    return graph_create_image(
        graph,
        &(struct graph_image_params){
            .name = name, .format = format, .width = input->width, .height = input->height, .samples = samples});
}

struct light_surfaces light_surfaces_add(struct graph *graph, const struct shade_input *input, bool prepass, uint32_t buffer,
                                         graph_image depth) {
    const bool reflects = buffer == LIGHT_BUFFER_TWO, leaning = input->scene->features & GPU_FEATURE_LEANING;
    uint32_t samples = MAX(graph_image_info(graph, depth).samples, 1u);
    struct light_surfaces surfaces = {.depth = depth, .samples = samples, .layers.count = 1};
    const VkFormat format = buffer == LIGHT_BUFFER_NARROW ? VK_FORMAT_R8G8B8A8_UNORM : VK_FORMAT_R16G16B16A16_UNORM;
    surfaces.normal = create_image(graph, input, "light normals", format, samples);
    if (reflects)
        surfaces.reflectance = create_image(graph, input, "light reflectance", VK_FORMAT_R8G8B8A8_UNORM, samples);
    if (leaning)
        surfaces.geometric = create_image(graph, input, "light geometric normals", LIGHT_GEOMETRIC_FORMAT, samples);
    struct surfaces_data data = {.scene = input->scene, .draws = *input->draws, .view = input->view};
    data.state = (struct gpu_graphics_params){
        .fragment = &shader_light_prepass_surfaces_frag,
        .constant_count = MAX(SURFACE_HOLES_ARE_CUT_ID, LIGHT_BUFFER_ID) + 1,
        .constants = {[HAS_LIGHTS_ID] = 1,
                      [HAS_METAL_ID] = 1,
                      [LIGHT_BUFFER_ID] = buffer,
                      [SURFACE_HOLES_ARE_CUT_ID] = prepass && samples > 1},
        .color_count = 1,
        .color_formats = {format},
        .depth_format = GEOMETRY_DEPTH_FORMAT,
        .depth_test = true,
        .depth_write = !prepass,
        .depth_compare = prepass ? VK_COMPARE_OP_EQUAL : VK_COMPARE_OP_GREATER_OR_EQUAL,
        .samples = samples};
    if (reflects) data.state.color_formats[data.state.color_count++] = VK_FORMAT_R8G8B8A8_UNORM;
    if (leaning) data.state.color_formats[data.state.color_count++] = LIGHT_GEOMETRIC_FORMAT;
    struct graph_pass *pass =
        graph_add_pass(graph, "light surfaces", GRAPH_QUEUE_GRAPHICS, execute_surfaces, &data, sizeof data);
    geometry_use(pass, input->scene, input->draws, GEOMETRY_OPAQUE);
    static const float zero[4];
    graph_color(pass, surfaces.normal, VK_ATTACHMENT_LOAD_OP_CLEAR, zero);
    if (reflects) graph_color(pass, surfaces.reflectance, VK_ATTACHMENT_LOAD_OP_CLEAR, zero);
    if (leaning) graph_color(pass, surfaces.geometric, VK_ATTACHMENT_LOAD_OP_CLEAR, zero);
    if (prepass)
        graph_depth_read_only(pass, depth);
    else
        graph_depth(pass, depth, VK_ATTACHMENT_LOAD_OP_CLEAR, 0);
    return surfaces;
}

void light_surfaces_use(struct graph_pass *pass, const struct light_surfaces *surfaces, enum graph_use use) {
    graph_use_image(pass, surfaces->depth, use);
    graph_use_image(pass, surfaces->normal, use);
    if (surfaces->reflectance.id) graph_use_image(pass, surfaces->reflectance, use);
    if (surfaces->geometric.id) graph_use_image(pass, surfaces->geometric, use);
}

struct gpu_light_surfaces light_surfaces_handles(const struct graph_context *context,
                                                 const struct light_surfaces *surfaces) {
    return (struct gpu_light_surfaces){.depth = graph_sampled(context, surfaces->depth),
                                       .normal = graph_sampled(context, surfaces->normal),
                                       .reflectance =
                                           surfaces->reflectance.id ? graph_sampled(context, surfaces->reflectance) : 0,
                                       .geometric = surfaces->geometric.id ? graph_sampled(context, surfaces->geometric)
                                                                           : GPU_NO_INDEX};
}

struct gbuffer light_surfaces_normals(const struct light_surfaces *surfaces) {
    /* Of the default layout's targets the second has the normals; nobody reads the first. */
    return (struct gbuffer){.depth = surfaces->depth,
                            .targets = {surfaces->normal, surfaces->normal},
                            .target_count = 2,
                            .normal = surfaces->normal,
                            .form = gbuffer_form_of(FNL_GBUFFER_DEFAULT, FNL_NORMALS_LAYOUT, false)};
}

struct edges light_surfaces_split(struct graph *graph, const struct shade_input *input, struct light_surfaces *surfaces) {
    if (surfaces->samples == 1) return (struct edges){0};
    /* A G-buffer of the default layout: the colour is not known and the same wherever normals are, as is the emission. */
    graph_image third = surfaces->reflectance.id ? surfaces->reflectance : surfaces->normal;
    struct gbuffer gbuffer = light_surfaces_normals(surfaces);
    gbuffer.targets[2] = third;
    gbuffer.target_count = 3;
    struct edges_params params = {.limit = surfaces->samples};
    struct edges edges = edges_add(graph, input, &gbuffer, surfaces->normal, &params);
    surfaces->layers = (struct surface_layers){.surfaces = edges.surfaces, .count = surfaces->samples};
    return edges;
}

/* ---- sums ---- */

struct light_sums light_sums_create(struct graph *graph, const struct shade_input *input, uint32_t buffer, uint32_t scale,
                                    VkFormat format, uint32_t layers) {
    struct light_sums sums = {.buffer = buffer,
                              .scale = scale,
                              .layers = layers,
                              .width = DIVIDE_UP(input->width, scale),
                              .height = DIVIDE_UP(input->height, scale),
                              .target_count = buffer == LIGHT_BUFFER_RGBA ? 1 : buffer == LIGHT_BUFFER_FOUR ? 4 : 2};
    struct graph_image_params params = {.format = format, .width = sums.width, .height = sums.height};
    for (uint32_t k = 0; k < layers; k++) {
        const char *name = graph_numbered_name(graph, k ? "edge light sums" : "light sums", k);
        for (uint32_t i = 0; i < sums.target_count; i++) {
            params.name = i ? graph_name(graph, "%s.%u", name, i) : name;
            graph_image image = graph_create_image(graph, &params);
            if (k == 0)
                sums.targets[i] = image;
            else
                sums.more[k - 1][i] = image;
        }
    }
    if (scale == 1) return sums;
    params.name = "light samples";
    params.format = VK_FORMAT_R32_UINT;
    sums.samples = graph_create_image(graph, &params);
    return sums;
}

const graph_image *light_sums_layer(const struct light_sums *sums, uint32_t layer) {
    return layer == 0 ? sums->targets : sums->more[layer - 1];
}

void light_sums_add(struct graph *graph, const struct shade_input *input, const struct light_surfaces *surfaces,
                    const struct light_sums *sums) {
    const bool counts = input->counters.id;
    struct gpu_light_prepass_push push = {.view = input->view,
                                          .lighting = input->lighting->address,
                                          .surfaces.geometric = GPU_NO_INDEX,
                                          .scale = sums->scale,
                                          .width = sums->width,
                                          .height = sums->height};
    struct graph_pass *pass = NULL;
    for (; push.layer < sums->layers; push.layer++) {
        pass = graph_dispatch(
            graph,
            &(struct graph_dispatch){
                .pass = pass,
                .name = "light sums",
                .pipeline = {&shader_light_prepass_lights_comp,
                             LIGHT_BUFFER_ID + 1,
                             {[LIGHTING_ID] = input->lighting->bits, [COUNT_LIGHTS_ID] = counts, [HAS_LIGHTS_ID] = 1, [HAS_METAL_ID] = 1,
                              [SAMPLES_ID] = surfaces->samples, [LIGHT_BUFFER_ID] = sums->buffer}},
                .groups = {DIVIDE_UP(sums->width, 8u), DIVIDE_UP(sums->height, 8u)},
                GRAPH_PUSH(push),
                GRAPH_ROWS(graph_samples(&push.surfaces.depth, surfaces->depth),
                           graph_samples(&push.surfaces.normal, surfaces->normal),
                           graph_row_if(surfaces->reflectance.id,
                                        graph_samples(&push.surfaces.reflectance, surfaces->reflectance)),
                           graph_row_if(surfaces->geometric.id,
                                        graph_samples(&push.surfaces.geometric, surfaces->geometric)),
                           graph_row_if(sums->layers > 1, graph_reads(&push.words, surfaces->layers.surfaces)),
                           graph_row_if(sums->samples.id, graph_stores(&push.samples, sums->samples)),
                           graph_row_if(counts, graph_changes(&push.counters, input->counters)))});
        for (uint32_t i = 0; i < sums->target_count; i++)
            graph_add_row(pass, graph_stores(&push.targets[i], light_sums_layer(sums, push.layer)[i]));
    }
    lighting_use(pass, input->lighting, GRAPH_READ_COMPUTE);
}

/* ---- materials ---- */

struct material_data {
    const struct geometry_scene *scene;
    struct geometry_draws draws;
    struct light_surfaces surfaces;
    struct light_sums sums;
    VkDeviceAddress view, lighting;
    graph_buffer counters;
    struct gpu_graphics_params state;
};

static void execute_materials(const struct graph_context *context, const void *data) {
    const struct material_data *d = data;
    bool filters = d->sums.scale > 1, splits = d->sums.layers > 1;
    struct gpu_light_material_push push = {
        .geometry = {.view = d->view,
                     .lighting = d->lighting,
                     .counters = d->counters.id ? graph_address(context, d->counters) : 0},
        .samples = filters ? graph_sampled(context, d->sums.samples) : 0,
        .scale = d->sums.scale};
    if (filters || splits) push.surfaces = light_surfaces_handles(context, &d->surfaces);
    for (uint32_t i = 0; i < d->sums.target_count; i++) push.targets[i] = graph_sampled(context, d->sums.targets[i]);
    if (splits) {
        struct gpu_slice slice =
            gpu_frame_allocate(context->device, (uint64_t)d->sums.layers * LIGHT_BUFFER_TARGETS * sizeof(uint32_t));
        if (!slice.data) return; /* the device carries a sticky error */
        uint32_t *layers = slice.data;
        for (uint32_t i = 0; i < d->sums.layers * LIGHT_BUFFER_TARGETS; i++) {
            graph_image image = light_sums_layer(&d->sums, i / LIGHT_BUFFER_TARGETS)[i % LIGHT_BUFFER_TARGETS];
            layers[i] = image.id ? graph_sampled(context, image) : 0;
        }
        push.layers = slice.address;
        push.words = graph_address(context, d->surfaces.layers.surfaces);
    }
    geometry_draw_with(context, d->scene, &d->draws, GEOMETRY_OPAQUE, &d->state, NULL, &push.geometry, sizeof push);
}

void light_material_add(struct graph *graph, const struct shade_input *input, const struct light_surfaces *surfaces,
                        const struct light_sums *sums, graph_image radiance) {
    bool filters = sums->scale > 1, splits = sums->layers > 1;
    struct material_data data = {.scene = input->scene,
                                 .draws = *input->draws,
                                 .surfaces = *surfaces,
                                 .sums = *sums,
                                 .view = input->view,
                                 .lighting = input->lighting->address,
                                 .counters = filters ? input->counters : (graph_buffer){0}};
    data.state = (struct gpu_graphics_params){
        .fragment = &shader_light_prepass_material_frag,
        .constant_count = LIGHT_SCALE_ID + 1,
        .constants = {[LIGHTING_ID] = input->lighting->bits, [COUNT_LIGHTS_ID] = data.counters.id != 0, [HAS_LIGHTS_ID] = 1, [HAS_METAL_ID] = 1,
                      [SAMPLES_ID] = surfaces->samples, [LIGHT_BUFFER_ID] = sums->buffer, [LIGHT_SCALE_ID] = sums->scale},
        .color_count = 1,
        .color_formats = {graph_image_info(graph, radiance).format},
        .depth_format = GEOMETRY_DEPTH_FORMAT,
        .depth_test = true,
        .depth_compare = VK_COMPARE_OP_EQUAL,
        .samples = surfaces->samples};
    struct graph_pass *pass =
        graph_add_pass(graph, "light materials", GRAPH_QUEUE_GRAPHICS, execute_materials, &data, sizeof data);
    geometry_use(pass, input->scene, input->draws, GEOMETRY_OPAQUE);
    for (uint32_t k = 0; k < sums->layers; k++)
        for (uint32_t i = 0; i < sums->target_count; i++)
            graph_use_image(pass, light_sums_layer(sums, k)[i], GRAPH_SAMPLE_FRAGMENT);
    if (filters || splits) light_surfaces_use(pass, surfaces, GRAPH_SAMPLE_FRAGMENT);
    if (splits) graph_use_buffer(pass, surfaces->layers.surfaces, GRAPH_READ_FRAGMENT);
    if (filters) {
        lighting_use(pass, input->lighting, GRAPH_READ_FRAGMENT);
        graph_use_image(pass, sums->samples, GRAPH_SAMPLE_FRAGMENT);
        if (data.counters.id) graph_use_buffer(pass, data.counters, GRAPH_READ_WRITE_FRAGMENT);
    }
    graph_color(pass, radiance, VK_ATTACHMENT_LOAD_OP_CLEAR, input->background);
    graph_depth_read_only(pass, surfaces->depth);
}
