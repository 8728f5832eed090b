/* SPDX-License-Identifier: MIT */
#include "passes/transparency/transparency.h"

#include "passes/geometry/prefix_sum.h"
#include "passes/transparency/transparency_draw_shared.h"
#include "shaders.h"

enum { COLOR_BYTES = 16, KEY_BYTES = sizeof(struct gpu_blend_key), EXTENT_BYTES = sizeof(struct gpu_blend_extent) };

uint32_t linked_bytes(uint32_t samples) { return COLOR_BYTES + KEY_BYTES + (samples > 1 ? EXTENT_BYTES : 0) + 4 * samples; }

/* ---- counting ---- */

static VkDeviceAddress address_or_zero(const struct graph_context *context, graph_buffer buffer) {
    return buffer.id ? graph_address(context, buffer) : 0;
}

struct draw_data {
    const struct geometry_scene *scene;
    struct geometry_draws draws;
    VkDeviceAddress view;
    graph_buffer counts;
    struct gpu_graphics_params state;
    enum geometry_set set;
    const struct gpu_shader *mask_fragment;
};

static void execute_draw(const struct graph_context *context, const void *data) {
    const struct draw_data *d = data;
    geometry_draw(context, d->scene, &d->draws, d->set, &d->state, d->mask_fragment,
                  (struct gpu_geometry_push){.view = d->view, .counters = address_or_zero(context, d->counts)});
}

/* The states of counting and filling: the same triangles pass the same tests. */
static struct gpu_graphics_params blend_state(const struct gpu_shader *fragment, uint32_t samples) {
    return (struct gpu_graphics_params){.fragment = fragment,
                                        .depth_format = GEOMETRY_DEPTH_FORMAT,
                                        .depth_test = true,
                                        .depth_compare = VK_COMPARE_OP_GREATER,
                                        .samples = samples};
}

static void add_count(struct graph *graph, const char *name, const struct geometry_scene *scene,
                      const struct geometry_draws *draws, VkDeviceAddress view, graph_buffer counts, graph_image depth) {
    uint32_t samples = MAX(graph_image_info(graph, depth).samples, 1u);
    struct draw_data count = {.scene = scene,
                              .draws = *draws,
                              .view = view,
                              .counts = counts,
                              .state = blend_state(&shader_blend_count_frag, samples),
                              .set = GEOMETRY_BLEND};
    struct graph_pass *pass = graph_add_pass(graph, name, GRAPH_QUEUE_GRAPHICS, execute_draw, &count, sizeof count);
    geometry_use(pass, scene, draws, GEOMETRY_BLEND);
    graph_use_buffer(pass, counts, GRAPH_READ_WRITE_FRAGMENT);
    graph_depth_read_only(pass, depth);
}

/* ---- lists ---- */

struct linked {
    graph_buffer sums, written, totals, colors, keys, extents, order;
    uint32_t width, height, capacity, samples;
};

static uint32_t pixel_count(const struct linked *l) { return l->width * l->height; }

struct fill_data {
    struct linked lists;
    const struct geometry_scene *scene;
    struct geometry_draws draws;
    VkDeviceAddress view, lighting;
    graph_buffer counters;
    struct gpu_graphics_params state;
};

static void execute_fill(const struct graph_context *context, const void *data) {
    const struct fill_data *d = data;
    const struct linked *l = &d->lists;
    struct gpu_linked_push push = {
        .geometry = {.view = d->view, .lighting = d->lighting, .counters = address_or_zero(context, d->counters)},
        .sums = graph_address(context, l->sums),
        .written = graph_address(context, l->written),
        .colors = graph_address(context, l->colors),
        .keys = graph_address(context, l->keys),
        .extents = address_or_zero(context, l->extents),
        .capacity = l->capacity,
        .samples = l->samples};
    geometry_draw_with(context, d->scene, &d->draws, GEOMETRY_BLEND, &d->state, NULL, &push.geometry, sizeof push);
}

static void add_fill(struct graph *graph, const struct shade_input *input, const struct linked *lists, graph_image radiance,
                     graph_image depth) {
    struct fill_data fill = {.lists = *lists,
                             .scene = input->scene,
                             .draws = *input->draws,
                             .view = input->view,
                             .lighting = input->lighting->address,
                             .counters = input->counters,
                             .state = blend_state(&shader_linked_fill_frag, lists->samples)};
    fill.state.constant_count = 2;
    fill.state.constants[LIGHTING_ID] = input->lighting->bits;
    fill.state.constants[COUNT_LIGHTS_ID] = input->counters.id != 0;
    fill.state.color_count = 1;
    fill.state.color_formats[0] = graph_image_info(graph, radiance).format;
    fill.state.blends[0] = GPU_BLEND_ALPHA;
    struct graph_pass *pass = graph_add_pass(graph, "linked fill", GRAPH_QUEUE_GRAPHICS, execute_fill, &fill, sizeof fill);
    geometry_use(pass, input->scene, input->draws, GEOMETRY_BLEND);
    lighting_use(pass, input->lighting, GRAPH_READ_FRAGMENT);
    if (input->glass.id) graph_use_image(pass, input->glass, GRAPH_SAMPLE_FRAGMENT);
    if (input->counters.id) graph_use_buffer(pass, input->counters, GRAPH_READ_WRITE_FRAGMENT);
    graph_use_buffer(pass, lists->sums, GRAPH_READ_FRAGMENT);
    graph_use_buffer(pass, lists->written, GRAPH_READ_WRITE_FRAGMENT);
    graph_use_buffer(pass, lists->colors, GRAPH_WRITE_FRAGMENT);
    graph_use_buffer(pass, lists->keys, GRAPH_WRITE_FRAGMENT);
    if (lists->extents.id) graph_use_buffer(pass, lists->extents, GRAPH_WRITE_FRAGMENT);
    graph_color(pass, radiance, VK_ATTACHMENT_LOAD_OP_LOAD, NULL);
    graph_depth_read_only(pass, depth);
}

struct composite_data {
    struct linked lists;
    VkFormat format;
    graph_image depth;
};

static void execute_composite(const struct graph_context *context, const void *data) {
    const struct composite_data *d = data;
    const struct linked *l = &d->lists;
    struct gpu_graphics_params state = {.vertex = &shader_screen_vert,
                                        .fragment = &shader_linked_composite_frag,
                                        .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST,
                                        .color_count = 1,
                                        .color_formats = {d->format},
                                        .blends = {GPU_BLEND_ALPHA},
                                        .samples = l->samples};
    struct gpu_linked_composite_push push = {.sums = graph_address(context, l->sums),
                                             .written = graph_address(context, l->written),
                                             .colors = graph_address(context, l->colors),
                                             .keys = graph_address(context, l->keys),
                                             .extents = address_or_zero(context, l->extents),
                                             .order = graph_address(context, l->order),
                                             .width = l->width,
                                             .height = l->height,
                                             .capacity = l->capacity,
                                             .samples = l->samples,
                                             .depth = l->samples > 1 ? graph_sampled(context, d->depth) : 0};
    gpu_bind(context->commands, gpu_graphics_pipeline(context->device, &state));
    for (; push.sample_index < l->samples; push.sample_index++) {
        gpu_push(context->commands, &push, sizeof push);
        gpu_draw(context->commands, 3, 1, 0, 0);
    }
}

static void add_composite(struct graph *graph, const struct linked *lists, graph_image radiance, graph_image depth) {
    struct composite_data composite = {*lists, graph_image_info(graph, radiance).format, depth};
    struct graph_pass *pass =
        graph_add_pass(graph, "linked composite", GRAPH_QUEUE_GRAPHICS, execute_composite, &composite, sizeof composite);
    graph_use_buffer(pass, lists->sums, GRAPH_READ_FRAGMENT);
    graph_use_buffer(pass, lists->written, GRAPH_READ_FRAGMENT);
    graph_use_buffer(pass, lists->colors, GRAPH_READ_FRAGMENT);
    graph_use_buffer(pass, lists->keys, GRAPH_READ_FRAGMENT);
    if (lists->extents.id) graph_use_buffer(pass, lists->extents, GRAPH_READ_FRAGMENT);
    graph_use_buffer(pass, lists->order, GRAPH_WRITE_FRAGMENT);
    if (lists->samples > 1) graph_use_image(pass, depth, GRAPH_SAMPLE_FRAGMENT);
    graph_color(pass, radiance, VK_ATTACHMENT_LOAD_OP_LOAD, NULL);
}

struct linked_lists linked_add(struct graph *graph, const struct shade_input *input, const struct linked_params *params,
                               graph_image radiance, graph_image depth) {
    struct linked l = {.width = input->width,
                       .height = input->height,
                       .capacity = MIN(params->capacity, LINKED_CAPACITY_MAX),
                       .samples = MAX(graph_image_info(graph, radiance).samples, 1u)};
    uint64_t capacity = l.capacity, sums_bytes = (pixel_count(&l) + 1) * 4ull;
    l.sums = graph_create_buffer(graph, "linked sums", sums_bytes);
    l.written = graph_create_buffer(graph, "linked written", pixel_count(&l) * 4ull);
    l.totals = graph_create_buffer(graph, "linked totals", sizeof(struct linked_totals));
    l.colors = graph_create_buffer(graph, "linked colors", capacity * COLOR_BYTES);
    l.keys = graph_create_buffer(graph, "linked keys", capacity * KEY_BYTES);
    if (l.samples > 1) l.extents = graph_create_buffer(graph, "linked extents", capacity * EXTENT_BYTES);
    l.order = graph_create_buffer(graph, "linked order", capacity * 4 * l.samples);

    graph_add_clear(graph, "linked clear", GRAPH_QUEUE_GRAPHICS,
                    (struct graph_clear){.buffers = {l.sums, l.written, l.totals}});
    add_count(graph, "linked count", input->scene, input->draws, input->view, l.sums, depth);
    prefix_sum_add(graph, "linked", GRAPH_QUEUE_GRAPHICS, l.sums, pixel_count(&l) + 1);
    struct gpu_linked_totals_push push = {.pixel_count = pixel_count(&l), .capacity = l.capacity};
    graph_dispatch(graph, &(struct graph_dispatch){
                              .name = "linked totals",
                              .pipeline = {.shader = &shader_linked_totals_comp},
                              .groups = {DIVIDE_UP(pixel_count(&l), 256u)},
                              GRAPH_PUSH(push),
                              GRAPH_ROWS(graph_reads(&push.sums, l.sums), graph_changes(&push.totals, l.totals))});
    add_fill(graph, input, &l, radiance, depth);
    add_composite(graph, &l, radiance, depth);
    return (struct linked_lists){l.totals, capacity * linked_bytes(l.samples) + sums_bytes + pixel_count(&l) * 4ull};
}

/* ---- the debug view ---- */

graph_buffer layers_add(struct graph *graph, const struct geometry_scene *scene, const struct geometry_draws *draws,
                        VkDeviceAddress view, uint32_t width, uint32_t height) {
    graph_image depth = graph_create_image(
        graph, &(struct graph_image_params){
                   .name = "layers depth", .format = GEOMETRY_DEPTH_FORMAT, .width = width, .height = height, .samples = 1});
    graph_buffer counts = graph_create_buffer(graph, "layers", (uint64_t)width * height * 4);
    graph_add_clear(graph, "layers clear", GRAPH_QUEUE_GRAPHICS, (struct graph_clear){.buffers = {counts}});
    struct draw_data prepass = {.scene = scene,
                                .draws = *draws,
                                .view = view,
                                .state = blend_state(NULL, 1),
                                .set = GEOMETRY_OPAQUE,
                                .mask_fragment = &shader_depth_frag};
    prepass.state.depth_write = true;
    struct graph_pass *pass =
        graph_add_pass(graph, "layers prepass", GRAPH_QUEUE_GRAPHICS, execute_draw, &prepass, sizeof prepass);
    geometry_use(pass, scene, draws, GEOMETRY_OPAQUE);
    graph_depth(pass, depth, VK_ATTACHMENT_LOAD_OP_CLEAR, 0);
    add_count(graph, "layers count", scene, draws, view, counts, depth);
    return counts;
}
