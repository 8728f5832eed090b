/* SPDX-License-Identifier: MIT */
#include "passes/debug/inspect.h"

#include "fanal/pixel.h"
#include "shaders.h"
#include "view_shared.h"

_Static_assert((uint32_t)FNL_PIXEL_LIGHTS == INSPECT_LIGHTS && (uint32_t)FNL_PIXEL_NONE == INSPECT_NONE && INSPECT_LIGHTS == 4 * INSPECT_GROUP &&
                   (uint32_t)FNL_PIXEL_SHADOW_MAP == INSPECT_SHADOW_MAP && FNL_PIXEL_SHADOW_COUNT == INSPECT_SHADOW_CUBEMAP + 1,
               "inspect_shared.h has the values of fanal/pixel.h");

enum { BLOCK = 2 }; /* pixels on a side that are drawn: derivatives are taken in such squares */

/* ---- the surface ---- */

/* The view, with the square of pixels that holds one as all that there is on the screen. Who asks for the pixel of a position gets the view's own, since
   with samples it is not that of the fragment. */
static struct gpu_view view_of_block(const struct gpu_view *view, uint32_t x, uint32_t y) {
    struct gpu_view block = *view;
    const float size[2] = {(float)view->size.x, (float)view->size.y};
    const float center[2] = {(float)(x / BLOCK * BLOCK + BLOCK / 2) / size[0] * 2 - 1, 1 - (float)(y / BLOCK * BLOCK + BLOCK / 2) / size[1] * 2};
    float *m = block.view_to_clip.m;
    for (int column = 0; column < 4; column++)
        for (int row = 0; row < 2; row++) m[4 * column + row] = size[row] / BLOCK * (m[4 * column + row] - center[row] * m[4 * column + 3]);
    block.world_to_clip = mat4_mul(block.view_to_clip, block.world_to_view);
    block.samples = MAX(block.samples, 2u);
    return block;
}

struct draw_data {
    const struct geometry_scene *scene;
    struct geometry_draws draws;
    VkDeviceAddress view;
    struct gpu_graphics_params state;
};

static void execute_draw(const struct graph_context *context, const void *data) {
    const struct draw_data *d = data;
    geometry_draw(context, d->scene, &d->draws, GEOMETRY_OPAQUE, &d->state, NULL, (struct gpu_geometry_push){.view = d->view});
}

static void add_surface(struct graph *graph, const struct inspect_input *input, VkDeviceAddress view, bool layers, graph_image *targets) {
    const VkFormat format = VK_FORMAT_R32G32B32A32_SFLOAT;
    const uint32_t count = layers ? SURFACE_LAYERS_VECTORS : INSPECT_TARGETS;
    const char *name = layers ? "inspect layers" : "inspect surface";
    static const float zero[4];
    struct draw_data data = {.scene = input->scene, .draws = *input->draws, .view = view};
    data.state = (struct gpu_graphics_params){.fragment = layers ? &shader_inspect_layers_frag : &shader_inspect_surface_frag,
                                              .color_count = count,
                                              .depth_format = GEOMETRY_DEPTH_FORMAT,
                                              .depth_test = true,
                                              .depth_write = true,
                                              .depth_compare = VK_COMPARE_OP_GREATER_OR_EQUAL,
                                              .samples = 1};
    for (uint32_t i = 0; i < count; i++) data.state.color_formats[i] = format;
    struct graph_pass *pass = graph_add_pass(graph, name, GRAPH_QUEUE_GRAPHICS, execute_draw, &data, sizeof data);
    geometry_use(pass, input->scene, input->draws, GEOMETRY_OPAQUE);
    for (uint32_t i = 0; i < count; i++) {
        targets[i] = graph_create_image(
            graph, &(struct graph_image_params){.name = graph_name(graph, "%s %u", name, i), .format = format, .width = BLOCK, .height = BLOCK});
        graph_color(pass, targets[i], VK_ATTACHMENT_LOAD_OP_CLEAR, zero);
    }
    const struct graph_image_params depth = {
        .name = graph_name(graph, "%s depth", name), .format = GEOMETRY_DEPTH_FORMAT, .width = BLOCK, .height = BLOCK};
    graph_depth(pass, graph_create_image(graph, &depth), VK_ATTACHMENT_LOAD_OP_CLEAR, 0);
}

/* ---- its lights ---- */

void inspect_add(struct graph *graph, gpu_device *device, const struct inspect_input *input) {
    graph_image targets[INSPECT_TARGETS], layers[SURFACE_LAYERS_VECTORS];
    const struct gpu_slice block = gpu_frame_allocate(device, sizeof(struct gpu_view));
    if (!block.data) return; /* the error sticks to the device */
    *(struct gpu_view *)block.data = view_of_block(input->view, input->x, input->y);
    add_surface(graph, input, block.address, false, targets);
    if (input->layered) add_surface(graph, input, block.address, true, layers);
    struct gpu_inspect_push push = {.view = input->view_address,
                                    .lighting = input->whole->address,
                                    .pixel = {input->x, input->y},
                                    .counter_stride = input->counters.id ? 2 : 0,
                                    .skips_layered = input->own_skips_layered};
    struct graph_pass *pass = graph_dispatch(graph, &(struct graph_dispatch){.name = "inspect lights",
                                                                             .pipeline = {&shader_inspect_lights_comp, 1, {input->whole->bits}},
                                                                             .groups = {1, 1},
                                                                             GRAPH_PUSH(push),
                                                                             GRAPH_ROWS(graph_writes(&push.out_pixel, input->out))});
    for (uint32_t i = 0; i < INSPECT_TARGETS; i++) graph_add_row(pass, graph_samples(&push.targets[i], targets[i]));
    for (uint32_t i = 0; i < SURFACE_LAYERS_VECTORS && input->layered; i++) graph_add_row(pass, graph_samples(&push.layers[i], layers[i]));
    graph_add_row(pass, graph_row_if(input->counters.id, graph_reads(&push.counters, input->counters)));
    lighting_use(pass, input->whole, GRAPH_READ_COMPUTE);
    if (!input->own) return;
    const uint32_t heeded = GPU_LIST_KINDS | GPU_LIST_SCATTERED | GPU_LIGHTING_SIMPLE | GPU_LIGHTING_PROFILES | GPU_LIGHTING_AREA_LIGHTS;
    push.lighting = input->own->address;
    pass = graph_dispatch(graph, &(struct graph_dispatch){.name = "inspect list",
                                                          .pipeline = {&shader_inspect_list_comp, 1, {input->own->bits & heeded}},
                                                          .groups = {1, 1},
                                                          GRAPH_PUSH(push),
                                                          GRAPH_ROWS(graph_changes(&push.out_pixel, input->out))});
    lighting_use(pass, input->own, GRAPH_READ_COMPUTE);
}
