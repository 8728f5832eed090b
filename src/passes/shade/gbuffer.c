/* SPDX-License-Identifier: MIT */
#include "passes/shade/gbuffer.h"

#include "passes/shade/gbuffer_layouts.h"
#include "passes/shade/hybrid_shared.h"
#include "shaders.h"

#define MASK_FORMAT VK_FORMAT_R8_UNORM

struct gbuffer_data {
    const struct geometry_scene *scene;
    struct geometry_draws draws;
    VkDeviceAddress view, entries;
    uint32_t form;
    struct gpu_graphics_params state;
};

static void execute_gbuffer(const struct graph_context *context, const void *data) {
    const struct gbuffer_data *d = data;
    struct gpu_gbuffer_push push = {.geometry = {.view = d->view}, .entries = d->entries, .form = d->form};
    geometry_draw_with(context, d->scene, &d->draws, GEOMETRY_OPAQUE, &d->state, NULL, &push.geometry, sizeof push);
}

/* Whether some material of the scene is lit forward with this layout. */
static bool needs_mask(const struct geometry_scene *scene, fnl_gbuffer layout) {
    for (uint32_t i = 0; i < scene->bucket_count; i++)
        if (geometry_bucket_opaque(&scene->buckets[i]) && scene->buckets[i].forward_layouts >> layout & 1) return true;
    return false;
}

static void create_targets(struct graph *graph, const struct shade_input *input, uint32_t samples, uint32_t layers,
                           struct gbuffer *gbuffer) {
    const struct gbuffer_layout *layout = &gbuffer_layouts[input->layout];
    struct graph_image_params params = {.width = input->width, .height = input->height, .layers = layers, .samples = samples};
    const bool geometric = gbuffer->form & GBUFFER_FORM_GEOMETRIC, widens = geometric && input->layout == FNL_GBUFFER_LAYERS;
    gbuffer->target_count = layout->target_count;
    for (uint32_t i = 0; i < layout->target_count; i++) {
        params.name = layout->targets[i].name;
        params.format = i == layout->color_target && input->chroma ? VK_FORMAT_R8G8_UNORM : layout->targets[i].format;
        if (widens && i + 1 == layout->target_count) params.format = VK_FORMAT_R16G16B16A16_UNORM;
        gbuffer->targets[i] = graph_create_image(graph, &params);
    }
    gbuffer->normal = gbuffer->targets[layout->normal_target];
    if (input->normals == FNL_NORMALS_FLOAT) {
        params.name = "gbuffer float normal";
        params.format = VK_FORMAT_R32G32B32A32_SFLOAT;
        gbuffer->normal = gbuffer->targets[gbuffer->target_count++] = graph_create_image(graph, &params);
    }
    if (geometric && !widens) {
        params.name = "gbuffer geometric normal";
        params.format = VK_FORMAT_R16G16_UNORM;
        gbuffer->targets[gbuffer->target_count++] = graph_create_image(graph, &params);
    }
    if (!needs_mask(input->scene, input->layout)) return;
    params.name = "gbuffer mask";
    params.format = MASK_FORMAT;
    gbuffer->mask = graph_create_image(graph, &params);
    gbuffer->form |= GBUFFER_FORM_MASK;
}

static void create_extras(struct graph *graph, const struct shade_input *input, const struct gbuffer_extras *extras,
                          struct gbuffer *gbuffer) {
    for (uint32_t i = 0; i < extras->count; i++)
        gbuffer->extras[i] = graph_create_image(graph, &(struct graph_image_params){.name = extras->targets[i].name,
                                                                                    .format = extras->targets[i].format,
                                                                                    .width = input->width,
                                                                                    .height = input->height});
}

static const struct gpu_shader *views_fragment(const struct geometry_draws *draws) {
    return draws->layers == GEOMETRY_LAYERS_MULTIVIEW ? &shader_gbuffer_views_frag : &shader_gbuffer_layered_frag;
}

struct gbuffer gbuffer_add(struct graph *graph, const struct shade_input *input, bool prepass, graph_image radiance,
                           graph_image depth) {
    return gbuffer_add_with(graph, input, prepass, radiance, depth, NULL);
}

struct gbuffer gbuffer_add_with(struct graph *graph, const struct shade_input *input, bool prepass, graph_image radiance,
                                graph_image depth, const struct gbuffer_extras *extras) {
    struct gbuffer gbuffer = {.depth = depth,
                              .view = input->view,
                              .entries = input->scene->material_entries,
                              .form = gbuffer_form_of(input->layout, input->normals, input->chroma)};
    const struct graph_image_params like = graph_image_info(graph, depth);
    const uint32_t samples = MAX(like.samples, 1u);
    const bool views = input->draws->view_mask;
    /* Float normals in the largest layout leave no target free. Paths that add targets have it in all scenes, so that
       theirs keep their numbers. */
    const bool full =
        input->normals == FNL_NORMALS_FLOAT && gbuffer_layouts[input->layout].target_count + 1 == GBUFFER_TARGETS;
    if ((input->scene->features & GPU_FEATURE_LEANING || extras) && !full) gbuffer.form |= GBUFFER_FORM_GEOMETRIC;
    create_targets(graph, input, samples, like.layers, &gbuffer);
    if (extras) create_extras(graph, input, extras, &gbuffer);
    struct gbuffer_data data = {.scene = input->scene,
                                .draws = *input->draws,
                                .view = input->view,
                                .entries = gbuffer.entries,
                                .form = gbuffer.form};
    data.state =
        (struct gpu_graphics_params){.fragment = extras  ? extras->fragment
                                                 : views ? views_fragment(input->draws)
                                                         : &shader_gbuffer_frag,
                                     .color_formats = {graph_image_info(graph, radiance).format},
                                     .depth_format = GEOMETRY_DEPTH_FORMAT,
                                     .depth_test = true,
                                     .depth_write = !prepass,
                                     .depth_compare = prepass ? VK_COMPARE_OP_EQUAL : VK_COMPARE_OP_GREATER_OR_EQUAL,
                                     .samples = samples};
    gbuffer_specialise(&gbuffer, data.state.constants, &data.state.constant_count);
    data.state.constants[HOLES_ARE_CUT_ID] = prepass && samples > 1;
    data.state.constants[GBUFFER_EXTRA_CONSTANT] = extras ? extras->constant : 0;
    data.state.constant_count = extras ? GBUFFER_EXTRA_CONSTANT + 1 : HOLES_ARE_CUT_ID + 1;
    graph_image images[GBUFFER_TARGETS + GBUFFER_EXTRAS + 1];
    uint32_t count = 0;
    for (; count < gbuffer.target_count; count++) images[count] = gbuffer.targets[count];
    if (gbuffer.mask.id) images[count++] = gbuffer.mask;
    for (uint32_t i = 0; extras && i < extras->count; i++) images[count++] = gbuffer.extras[i];
    data.state.color_count = 1 + count;
    struct graph_pass *pass;
    for (uint32_t i = 0; i < count; i++) data.state.color_formats[1 + i] = graph_image_info(graph, images[i]).format;
    pass = graph_add_pass(graph, "gbuffer", GRAPH_QUEUE_GRAPHICS, execute_gbuffer, &data, sizeof data);
    geometry_use(pass, input->scene, input->draws, GEOMETRY_OPAQUE);
    graph_color(pass, radiance, VK_ATTACHMENT_LOAD_OP_CLEAR, input->background);
    static const float zero[4];
    for (uint32_t i = 0; i < count; i++) graph_color(pass, images[i], VK_ATTACHMENT_LOAD_OP_CLEAR, zero);
    if (prepass)
        graph_depth_read_only(pass, depth);
    else
        graph_depth(pass, depth, geometry_depth_load(input->draws), 0);
    geometry_set_layers(pass, input->draws);
    return gbuffer;
}

struct gbuffer gbuffer_layer(struct graph *graph, const struct gbuffer *gbuffer, uint32_t layer, VkDeviceAddress view) {
    struct gbuffer one = *gbuffer;
    one.view = view;
    one.depth = graph_image_layer(graph, gbuffer->depth, layer);
    for (uint32_t i = 0; i < gbuffer->target_count; i++) one.targets[i] = graph_image_layer(graph, gbuffer->targets[i], layer);
    one.normal = graph_image_layer(graph, gbuffer->normal, layer);
    if (gbuffer->mask.id) one.mask = graph_image_layer(graph, gbuffer->mask, layer);
    return one;
}

void gbuffer_use(struct graph_pass *pass, const struct gbuffer *gbuffer, enum graph_use use) {
    graph_use_image(pass, gbuffer->depth, use);
    for (uint32_t i = 0; i < gbuffer->target_count; i++) graph_use_image(pass, gbuffer->targets[i], use);
    if (gbuffer->mask.id) graph_use_image(pass, gbuffer->mask, use);
}

void gbuffer_use_normal(struct graph_pass *pass, const struct gbuffer *gbuffer, enum graph_use use) {
    graph_use_image(pass, gbuffer->depth, use);
    graph_use_image(pass, gbuffer->normal, use);
}

struct gpu_gbuffer gbuffer_block(const struct gbuffer *gbuffer) {
    return (struct gpu_gbuffer){.view = gbuffer->view, .entries = gbuffer->entries, .form = gbuffer->form};
}

void gbuffer_add_rows(struct graph_pass *pass, const struct gpu_gbuffer *member, const struct gbuffer *gbuffer,
                      enum graph_use use) {
    graph_add_row(pass, graph_image_row(&member->depth, gbuffer->depth, use));
    for (uint32_t i = 0; i < gbuffer->target_count; i++)
        graph_add_row(pass, graph_image_row(&member->targets[i], gbuffer->targets[i], use));
    graph_add_row(pass, graph_row_if(gbuffer->mask.id, graph_image_row(&member->mask, gbuffer->mask, use)));
}

void gbuffer_add_normal_rows(struct graph_pass *pass, const struct gpu_gbuffer *member, const struct gbuffer *gbuffer,
                             enum graph_use use) {
    graph_add_row(pass, graph_image_row(&member->depth, gbuffer->depth, use));
    for (uint32_t i = 0; i < gbuffer->target_count; i++)
        if (gbuffer->targets[i].id == gbuffer->normal.id)
            graph_add_row(pass, graph_image_row(&member->targets[i], gbuffer->normal, use));
}

void gbuffer_put_normal(struct graph *graph, struct gpu_gbuffer *place, const struct gbuffer *gbuffer) {
    *place = gbuffer_block(gbuffer);
    graph_put_sampled(graph, &place->depth, gbuffer->depth);
    for (uint32_t i = 0; i < gbuffer->target_count; i++)
        if (gbuffer->targets[i].id == gbuffer->normal.id) graph_put_sampled(graph, &place->targets[i], gbuffer->normal);
}

struct gpu_gbuffer gbuffer_normal_handles(const struct graph_context *context, const struct gbuffer *gbuffer) {
    struct gpu_gbuffer handles = gbuffer_block(gbuffer);
    handles.depth = graph_sampled(context, gbuffer->depth);
    for (uint32_t i = 0; i < gbuffer->target_count; i++)
        if (gbuffer->targets[i].id == gbuffer->normal.id) handles.targets[i] = graph_sampled(context, gbuffer->normal);
    return handles;
}

struct gpu_gbuffer gbuffer_handles(const struct graph_context *context, const struct gbuffer *gbuffer) {
    struct gpu_gbuffer handles = gbuffer_normal_handles(context, gbuffer);
    for (uint32_t i = 0; i < gbuffer->target_count; i++) handles.targets[i] = graph_sampled(context, gbuffer->targets[i]);
    if (gbuffer->mask.id) handles.mask = graph_sampled(context, gbuffer->mask);
    return handles;
}

void gbuffer_specialise(const struct gbuffer *gbuffer, uint32_t constants[GPU_MAX_CONSTANTS], uint32_t *count) {
    for (uint32_t i = *count; i < GBUFFER_CONSTANT; i++) constants[i] = i == HAS_LIGHTS_ID || i == HAS_METAL_ID;
    constants[GBUFFER_CONSTANT] = gbuffer->form;
    *count = MAX(*count, GBUFFER_CONSTANT + 1);
}
