/* SPDX-License-Identifier: MIT */
#include "passes/shade/volumes.h"

#include "passes/geometry/prefix_sum.h"
#include "passes/shade/volumes_shared.h"
#include "scene_shared.h"
#include "shaders.h"

#define STENCIL_FORMAT VK_FORMAT_D32_SFLOAT_S8_UINT

_Static_assert(VOLUME_INDEX_COUNT == VOLUME_SPHERE_INDICES + VOLUME_CONE_INDICES, "both solids");

VkFormat volumes_format(const gpu_device *device) {
    return gpu_format_supports(device, VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_FEATURE_2_COLOR_ATTACHMENT_BLEND_BIT)
               ? VK_FORMAT_R32G32B32A32_SFLOAT
               : VK_FORMAT_R16G16B16A16_SFLOAT;
}

static uint32_t *add_triangle(uint32_t *at, uint32_t a, uint32_t b, uint32_t c) {
    at[0] = a;
    at[1] = b;
    at[2] = c;
    return at + 3;
}

void volumes_indices(uint32_t out[VOLUME_INDEX_COUNT]) {
    const uint32_t row = VOLUME_SIDE + 1;
    for (uint32_t y = 0; y < VOLUME_SIDE; y++)
        for (uint32_t x = 0; x < VOLUME_SIDE; x++) {
            uint32_t a = y * row + x, b = a + 1, c = b + row, d = a + row;
            if ((x < VOLUME_SIDE / 2) == (y < VOLUME_SIDE / 2)) { /* diagonals lie along the folds */
                out = add_triangle(out, a, b, d);
                out = add_triangle(out, b, c, d);
            } else {
                out = add_triangle(out, a, b, c);
                out = add_triangle(out, a, c, d);
            }
        }
    const uint32_t near = VOLUME_SPHERE_VERTICES, far = near + VOLUME_RING;
    for (uint32_t i = 0; i < VOLUME_RING; i++) {
        uint32_t next = (i + 1) % VOLUME_RING;
        out = add_triangle(out, near + i, far + i, far + next);
        out = add_triangle(out, near + i, far + next, near + next);
        if (i < 2) continue;
        out = add_triangle(out, near, near + i - 1, near + i);
        out = add_triangle(out, far, far + i, far + i - 1);
    }
}

/* ---- which volumes ---- */

struct totals_data {
    graph_buffer sums, totals;
    uint64_t offset;
};

static void execute_totals(const struct graph_context *context, const void *data) {
    const struct totals_data *d = data;
    const struct gpu_buffer *totals = graph_get_buffer(context, d->totals);
    gpu_copy_buffer(context->commands, graph_get_buffer(context, d->sums), d->offset, totals,
                    offsetof(struct light_totals, in_view), 4);
    gpu_fill_buffer(context->commands, totals, offsetof(struct light_totals, entries),
                    sizeof(struct light_totals) - offsetof(struct light_totals, entries), 0);
}

/* The three flat shapes, behind the indices of the solids. */
static const uint32_t flat_indices[VOLUME_QUAD_INDICES + VOLUME_OCTAGON_INDICES + VOLUME_SCREEN_INDICES] = {
#define AT(vertex) VOLUME_QUAD_VERTEX + (vertex)
    AT(0),
    AT(1),
    AT(2),
    AT(2),
    AT(1),
    AT(3),
#undef AT
#define AT(vertex) VOLUME_OCTAGON_VERTEX + (vertex)
    AT(0),
    AT(1),
    AT(2),
    AT(0),
    AT(2),
    AT(3),
    AT(0),
    AT(3),
    AT(4),
    AT(0),
    AT(4),
    AT(5),
    AT(0),
    AT(5),
    AT(6),
    AT(0),
    AT(6),
    AT(7),
#undef AT
    VOLUME_SCREEN_VERTEX,
    VOLUME_SCREEN_VERTEX + 1,
    VOLUME_SCREEN_VERTEX + 2};

struct volumes volumes_prepare(struct graph *graph, gpu_device *device, const struct volumes_input *input) {
    const struct light_set *lights = &input->scopes->lights;
    const struct light_input all = lighting_input(input->scopes);
    const struct light_list list = light_list_all_add(graph, device, &all);
    const uint32_t count = lights->local_count;
    struct volumes volumes = {
        .lighting = lighting_add(graph, device, input->scopes, &list), .shape = input->shape, .batch = 1, .light_count = count};
    if (input->shape == VOLUME_SCREEN) volumes.batch = MIN(MAX(input->batch, 1u), VOLUME_BATCH_MAX);
    if (input->shape == VOLUME_STENCIL) {
        volumes.hook = input->hook;
        volumes.alone = MIN(count, input->hook ? input->hook->count : VOLUME_STENCIL_LIGHTS);
    }
    volumes.sums = graph_create_buffer(graph, "volume sums", (2ull * count + 1) * 4);
    volumes.ids = graph_create_buffer(graph, "volume ids", (count + volumes.batch) * 4ull);
    volumes.draws = graph_create_buffer(graph, "volume draws", (2ull + volumes.alone) * sizeof(struct gpu_draw));
    struct gpu_volumes_push push = {.view = input->view,
                                    .lighting = volumes.lighting.address,
                                    .light_count = count,
                                    .cull = input->cull,
                                    .shape = input->shape,
                                    .alone = volumes.alone,
                                    .by_light = volumes.hook != NULL,
                                    .batch = volumes.batch};
    graph_dispatch(graph, &(struct graph_dispatch){.name = "volumes mark",
                                                   .pipeline = {.shader = &shader_volumes_mark_comp},
                                                   .groups = {DIVIDE_UP(count + 1, 64u)},
                                                   GRAPH_PUSH(push),
                                                   GRAPH_ROWS(graph_reads(NULL, lights->buffer),
                                                              graph_writes(&push.sums, volumes.sums))});
    prefix_sum_add(graph, "volumes", GRAPH_QUEUE_GRAPHICS, volumes.sums, 2 * count + 1);
    graph_dispatch(graph, &(struct graph_dispatch){.name = "volumes fill",
                                                   .pipeline = {.shader = &shader_volumes_fill_comp},
                                                   .groups = {DIVIDE_UP(2 * MAX(count, 1u), 64u)},
                                                   GRAPH_PUSH(push),
                                                   GRAPH_ROWS(graph_reads(&push.sums, volumes.sums),
                                                              graph_writes(&push.ids, volumes.ids),
                                                              graph_writes(&push.draws, volumes.draws))});

    volumes.indices = gpu_frame_allocate(device, VOLUME_INDEX_COUNT * 4 + sizeof flat_indices);
    if (volumes.indices.data) {
        uint32_t *indices = volumes.indices.data;
        volumes_indices(indices);
        memcpy(indices + VOLUME_INDEX_COUNT, flat_indices, sizeof flat_indices);
    }
    struct totals_data totals = {volumes.sums, graph_create_buffer(graph, "volume totals", sizeof(struct light_totals)),
                                 2ull * count * 4};
    struct graph_pass *pass = graph_add_pass(graph, "volume counts", GRAPH_QUEUE_GRAPHICS, execute_totals, &totals, sizeof totals);
    graph_use_buffer(pass, totals.sums, GRAPH_COPY_FROM);
    graph_use_buffer(pass, totals.totals, GRAPH_COPY_TO);
    volumes.totals = totals.totals;
    return volumes;
}

/* ---- drawing them ---- */

void volumes_use(struct graph_pass *pass, const struct volumes *volumes) {
    lighting_use(pass, &volumes->lighting, GRAPH_READ_FRAGMENT);
    graph_use_buffer(pass, volumes->lighting.lights.buffer, GRAPH_READ_VERTEX);
    graph_use_buffer(pass, volumes->ids, GRAPH_READ_VERTEX);
    graph_use_buffer(pass, volumes->draws, GRAPH_INDIRECT);
}

static bool is_solid(uint32_t shape) {
    return shape == VOLUME_SOLIDS || shape == VOLUME_DEPTH_BOUNDS || shape == VOLUME_STENCIL;
}

static void set_state(const struct volumes *volumes, struct gpu_graphics_params *state) {
    bool solid = is_solid(volumes->shape);
    /* Solids: back faces alone, and only those that are not in front of the surface. Flat shapes: not behind it. Depth is reversed. */
    state->vertex = &shader_volumes_vert;
    state->topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
    state->cull = solid ? VK_CULL_MODE_FRONT_BIT : VK_CULL_MODE_NONE;
    if (!state->depth_format) state->depth_format = GEOMETRY_DEPTH_FORMAT;
    state->depth_clamp = true;
    state->samples = 1;
    if (!state->depth_write) {
        state->depth_test = volumes->shape != VOLUME_SCREEN && state->depth_format != VK_FORMAT_S8_UINT;
        state->depth_compare = solid ? VK_COMPARE_OP_LESS_OR_EQUAL : VK_COMPARE_OP_GREATER_OR_EQUAL;
    }
}

void volumes_draw(const struct graph_context *context, const struct volumes *volumes, struct gpu_graphics_params *state,
                  struct gpu_volume_head *push, uint32_t size) {
    if (!volumes->indices.data) return; /* the device carries a sticky error */
    set_state(volumes, state);
    push->lighting = volumes->lighting.address;
    push->ids = graph_address(context, volumes->ids);
    gpu_bind(context->commands, graph_pipeline(context, state));
    gpu_push(context->commands, push, size);
    gpu_bind_indices(context->commands, volumes->indices.buffer, volumes->indices.offset);
    gpu_draw_indexed_indirect(context->commands, graph_get_buffer(context, volumes->draws), 0, 2);
}

struct draw_data {
    struct gbuffer gbuffer;
    struct volumes volumes;
    VkDeviceAddress view;
    graph_buffer counters;
    VkFormat format;
    uint32_t width, height;
    graph_buffer words; /* of struct surface_layers, as the next */
    uint32_t samples, layer;
    uint32_t first, end; /* of those that are drawn alone */
    bool begins, ends;   /* copies the depth; draws those that are not alone */
    graph_image mask;    /* or id 0 */
};

/* The depth of what is lit here, once more beside a stencil; sky and what is lit forward lie behind everything. */
static void copy_depth(const struct graph_context *context, const struct draw_data *d) {
    struct gpu_graphics_params state = {.vertex = &shader_screen_vert,
                                        .fragment = &shader_volumes_depth_frag,
                                        .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST,
                                        .color_count = 1,
                                        .color_formats = {d->format},
                                        .blends = {GPU_BLEND_KEEP},
                                        .depth_format = STENCIL_FORMAT,
                                        .depth_write = true,
                                        .samples = 1};
    gbuffer_specialise(&d->gbuffer, state.constants, &state.constant_count);
    state.constants[SAMPLES_ID] = d->samples;
    state.constant_count = SAMPLES_ID + 1;
    struct gpu_volume_push push = {.view = d->view,
                                   .words = d->words.id ? graph_address(context, d->words) : 0,
                                   .gbuffer = gbuffer_handles(context, &d->gbuffer),
                                   .layer = d->layer};
    gpu_bind(context->commands, gpu_graphics_pipeline(context->device, &state));
    gpu_push(context->commands, &push, sizeof push);
    gpu_draw(context->commands, 3, 1, 0, 0);
}

/* Light by light: what is behind its front faces is marked, then its back faces are drawn where nothing is. `state` and `push` are those
   of the rest. */
static void draw_alone(const struct graph_context *context, const struct draw_data *d,
                       const struct gpu_graphics_params *state, struct gpu_volume_push push) {
    if (!d->volumes.indices.data) return;
    struct gpu_graphics_params fronts, backs;
    memcpy(&backs, state, sizeof backs); /* hashed as bytes */
    set_state(&d->volumes, &backs);
    memcpy(&fronts, &backs, sizeof fronts);
    fronts.fragment = NULL;
    fronts.constants[VOLUME_FRONTS_ID] = 1;
    fronts.blends[0] = GPU_BLEND_KEEP;
    fronts.cull = VK_CULL_MODE_BACK_BIT;
    fronts.depth_compare = VK_COMPARE_OP_LESS;
    fronts.stencil = (struct gpu_stencil){.test = 1, .compare = VK_COMPARE_OP_ALWAYS, .pass = VK_STENCIL_OP_REPLACE, .reference = GPU_STENCIL_SET};
    backs.stencil = (struct gpu_stencil){.test = 1, .compare = VK_COMPARE_OP_NOT_EQUAL, .pass = VK_STENCIL_OP_KEEP, .reference = GPU_STENCIL_SET};
    const struct gpu_pipeline *mark = gpu_graphics_pipeline(context->device, &fronts);
    const struct gpu_pipeline *light = gpu_graphics_pipeline(context->device, &backs);
    const struct gpu_buffer *draws = graph_get_buffer(context, d->volumes.draws);
    push.lighting = d->volumes.lighting.address;
    push.ids = graph_address(context, d->volumes.ids);
    gpu_push(context->commands, &push, sizeof push);
    gpu_bind_indices(context->commands, d->volumes.indices.buffer, d->volumes.indices.offset);
    for (uint32_t i = d->first; i < d->end; i++) {
        const uint64_t offset = (2ull + i) * sizeof(struct gpu_draw);
        if (i > 0 && i % 255 == 0) gpu_clear_stencil(context->commands, d->width, d->height, 0);
        gpu_bind(context->commands, mark);
        gpu_stencil_reference(context->commands, i % 255 + 1);
        gpu_draw_indexed_indirect(context->commands, draws, offset, 1);
        gpu_bind(context->commands, light);
        /* Mesa's CPU driver 25.0 takes constants for sent to a fragment shader after a draw that has none. */
        gpu_push(context->commands, &push, sizeof push);
        gpu_draw_indexed_indirect(context->commands, draws, offset, 1);
    }
}

static void execute_draw(const struct graph_context *context, const void *data) {
    const struct draw_data *d = data;
    struct gpu_graphics_params state = {.fragment = &shader_volumes_frag,
                                        .constant_count = 2,
                                        .constants = {[LIGHTING_ID] = d->volumes.lighting.bits, [COUNT_LIGHTS_ID] = d->counters.id != 0},
                                        .color_count = 1,
                                        .color_formats = {d->format},
                                        .blends = {GPU_BLEND_ADD}};
    gbuffer_specialise(&d->gbuffer, state.constants, &state.constant_count);
    state.constants[SAMPLES_ID] = d->samples;
    state.constants[VOLUME_BATCH_ID] = d->volumes.batch;
    state.constants[VOLUME_BOUND_DEPTHS_ID] = d->volumes.shape == VOLUME_DEPTH_BOUNDS;
    state.constant_count = MAX(state.constant_count, VOLUME_BOUND_DEPTHS_ID + 1);
    struct gpu_volume_push push = {.view = d->view,
                                   .counters = d->counters.id ? graph_address(context, d->counters) : 0,
                                   .words = d->words.id ? graph_address(context, d->words) : 0,
                                   .gbuffer = gbuffer_handles(context, &d->gbuffer),
                                   .layer = d->layer};
    if (d->volumes.shape == VOLUME_STENCIL) {
        if (d->begins) copy_depth(context, d);
        state.depth_format = STENCIL_FORMAT;
        state.constants[VOLUME_MASKED_ID] = d->mask.id != 0;
        state.constant_count = VOLUME_FRONTS_ID + 1;
        if (d->mask.id) push.mask = graph_sampled(context, d->mask);
        draw_alone(context, d, &state, push);
    }
    if (d->ends) volumes_draw(context, &d->volumes, &state, (struct gpu_volume_head *)&push, sizeof push);
}

bool volumes_stencil_supported(const gpu_device *device) {
    return gpu_format_supports(device, STENCIL_FORMAT, VK_FORMAT_FEATURE_2_DEPTH_STENCIL_ATTACHMENT_BIT);
}

static void add_draw(struct graph *graph, const char *name, const struct draw_data *draw, graph_image radiance,
                     graph_image both) {
    struct graph_pass *pass = graph_add_pass(graph, name, GRAPH_QUEUE_GRAPHICS, execute_draw, draw, sizeof *draw);
    volumes_use(pass, &draw->volumes);
    gbuffer_use(pass, &draw->gbuffer, GRAPH_SAMPLE_FRAGMENT);
    if (draw->mask.id) graph_use_image(pass, draw->mask, GRAPH_SAMPLE_FRAGMENT);
    if (draw->counters.id) graph_use_buffer(pass, draw->counters, GRAPH_READ_WRITE_FRAGMENT);
    graph_color(pass, radiance, VK_ATTACHMENT_LOAD_OP_LOAD, (float[4]){0});
    if (both.id)
        graph_depth(pass, both, draw->begins ? VK_ATTACHMENT_LOAD_OP_CLEAR : VK_ATTACHMENT_LOAD_OP_LOAD, 0);
    else
        graph_depth_read_only(pass, draw->gbuffer.depth);
}

void volumes_add(struct graph *graph, const struct shade_input *input, const struct volumes *volumes,
                 const struct gbuffer *gbuffer, graph_image radiance) {
    struct draw_data draw = {.gbuffer = *gbuffer,
                             .volumes = *volumes,
                             .view = input->view,
                             .counters = input->counters,
                             .format = graph_image_info(graph, radiance).format,
                             .width = input->width,
                             .height = input->height,
                             .begins = true};
    graph_image both = {0};
    if (volumes->shape == VOLUME_STENCIL)
        both = graph_create_image(
            graph, &(struct graph_image_params){
                       .name = "volume stencil", .format = STENCIL_FORMAT, .width = input->width, .height = input->height});
    for (; volumes->hook && draw.first < volumes->alone; draw.first++) {
        draw.end = draw.first + 1;
        draw.mask = volumes->hook->add(graph, draw.first, volumes->hook->user);
        add_draw(graph, graph_name(graph, "volumes of light %u", draw.first), &draw, radiance, both);
        draw.begins = false;
    }
    draw.mask = (graph_image){0};
    draw.end = volumes->alone;
    draw.ends = true;
    add_draw(graph, "volumes", &draw, radiance, both);
}

void volumes_add_samples(struct graph *graph, const struct shade_input *input, const struct volumes *volumes,
                         const struct gbuffer *gbuffer, const struct surface_layers *layers, graph_image radiance) {
    struct surface_layers with_depths = *layers;
    bool stencil = volumes->shape == VOLUME_STENCIL;
    if (!stencil) surface_layers_add_depths(graph, input, gbuffer->depth, &with_depths);
    struct graph_image_params image = {
        .format = graph_image_info(graph, radiance).format, .width = input->width, .height = input->height};
    struct draw_data draw = {.gbuffer = *gbuffer,
                             .volumes = *volumes,
                             .view = input->view,
                             .counters = input->counters,
                             .format = image.format,
                             .width = input->width,
                             .height = input->height,
                             .words = layers->surfaces,
                             .samples = layers->count,
                             .end = volumes->alone,
                             .begins = true,
                             .ends = true};
    graph_image targets[SURFACE_LAYERS] = {{0}};
    static const float zero[4];
    for (; draw.layer < layers->count; draw.layer++) {
        image.name = graph_numbered_name(graph, "volume radiance", draw.layer);
        targets[draw.layer] = graph_create_image(graph, &image);
        struct graph_pass *pass = graph_add_pass(graph, graph_numbered_name(graph, "volumes", draw.layer), GRAPH_QUEUE_GRAPHICS,
                                                 execute_draw, &draw, sizeof draw);
        volumes_use(pass, volumes);
        gbuffer_use(pass, gbuffer, GRAPH_SAMPLE_FRAGMENT);
        graph_use_buffer(pass, draw.words, GRAPH_READ_FRAGMENT);
        if (input->counters.id) graph_use_buffer(pass, input->counters, GRAPH_READ_WRITE_FRAGMENT);
        graph_color(pass, targets[draw.layer], VK_ATTACHMENT_LOAD_OP_CLEAR, zero);
        if (stencil) {
            struct graph_image_params both = {.name = graph_numbered_name(graph, "volume stencil", draw.layer),
                                              .format = STENCIL_FORMAT,
                                              .width = input->width,
                                              .height = input->height};
            graph_depth(pass, graph_create_image(graph, &both), VK_ATTACHMENT_LOAD_OP_CLEAR, 0);
        } else {
            graph_depth_read_only(pass, with_depths.depths[draw.layer]);
        }
    }
    surface_layers_spread(graph, input, layers, targets, radiance);
}
