/* SPDX-License-Identifier: MIT */
#include "passes/aa/motion.h"

#include "passes/aa/motion_shared.h"
#include "shaders.h"

struct objects_data {
    struct motion_objects objects;
    struct geometry_draws draws;
    VkDeviceAddress view, motion;
};

/* Both views are rigid, so the way between them is found in doubles without an inverse. */
static mat4 view_to_previous(const struct gpu_view *current, const struct gpu_view *previous) {
    const float *c = current->world_to_view.m, *p = previous->world_to_view.m;
    mat4 out = mat4_identity();
    for (int row = 0; row < 3; row++) {
        double moved = p[12 + row];
        for (int column = 0; column < 3; column++) {
            double sum = 0;
            for (int k = 0; k < 3; k++) sum += (double)p[k * 4 + row] * c[k * 4 + column];
            out.m[column * 4 + row] = (float)sum;
            moved -= sum * c[12 + column];
        }
        out.m[12 + row] = (float)moved;
    }
    return out;
}

static void execute_objects(const struct graph_context *context, const void *data) {
    const struct objects_data *d = data;
    struct gpu_graphics_params state = {.vertex = &shader_motion_objects_vert,
                                        .fragment = &shader_motion_objects_frag,
                                        .color_count = 1,
                                        .color_formats = {VK_FORMAT_R32G32B32A32_SFLOAT},
                                        .depth_format = GEOMETRY_DEPTH_FORMAT,
                                        .depth_test = true,
                                        .depth_compare = VK_COMPARE_OP_GREATER_OR_EQUAL,
                                        .samples = 1};
    VkDeviceAddress previous = graph_address(context, d->objects.previous);
    struct gpu_motion_objects_push push = {.geometry = {.view = d->view},
                                           .motion = d->motion,
                                           .instances = previous,
                                           .positions = previous + d->objects.position_offset,
                                           .instance_count = d->objects.instance_count,
                                           .first_deformed = d->objects.first_deformed,
                                           .deformed_count = d->objects.deformed_count};
    geometry_draw_with(context, d->objects.scene, &d->draws, GEOMETRY_OPAQUE, &state, NULL, &push.geometry, sizeof push);
}

static graph_image add_objects(struct graph *graph, const struct motion_input *input, VkDeviceAddress motion,
                               struct graph_image_params image) {
    struct objects_data data = {input->objects, *input->objects.draws, input->view, motion};
    image.name = "motion of objects";
    graph_image target = graph_create_image(graph, &image);
    struct graph_pass *pass =
        graph_add_pass(graph, "motion objects", GRAPH_QUEUE_GRAPHICS, execute_objects, &data, sizeof data);
    static const float zero[4];
    geometry_use(pass, input->objects.scene, &data.draws, GEOMETRY_OPAQUE);
    graph_use_buffer(pass, input->objects.previous, GRAPH_READ_VERTEX);
    graph_color(pass, target, VK_ATTACHMENT_LOAD_OP_CLEAR, zero);
    graph_depth_read_only(pass, input->depth);
    return target;
}

graph_image motion_add(struct graph *graph, gpu_device *device, const struct motion_input *input) {
    struct graph_image_params image = {.name = "motion",
                                       .format = VK_FORMAT_R32G32B32A32_SFLOAT,
                                       .width = input->current->size.x,
                                       .height = input->current->size.y};
    struct gpu_slice slice = gpu_frame_allocate(device, sizeof(struct gpu_motion));
    graph_image target = graph_create_image(graph, &image);
    if (!slice.data) return target; /* the error sticks to the device */
    const struct gpu_view *previous = input->previous ? input->previous : input->current;
    *(struct gpu_motion *)slice.data = (struct gpu_motion){.previous = *previous,
                                                           .view_to_previous = view_to_previous(input->current, previous),
                                                           .jitter = input->jitter,
                                                           .has_previous = input->previous != NULL,
                                                           .origin_moved = input->objects.origin_moved};
    graph_image objects = {0};
    if (input->objects.previous.id && input->previous) objects = add_objects(graph, input, slice.address, image);
    struct gpu_motion_push push = {.view = input->view, .motion = slice.address, .has_objects = objects.id != 0};
    graph_dispatch(graph,
                   &(struct graph_dispatch){.name = "motion",
                                            .pipeline = {.shader = &shader_motion_comp},
                                            .groups = {DIVIDE_UP(image.width, 8u), DIVIDE_UP(image.height, 8u)},
                                            GRAPH_PUSH(push),
                                            GRAPH_ROWS(graph_samples(&push.depth, input->depth),
                                                       graph_row_if(push.has_objects, graph_samples(&push.objects, objects)),
                                                       graph_stores(&push.target, target))});
    return target;
}

/* ---- depth of its own ---- */

struct depth_data {
    const struct geometry_scene *scene;
    struct geometry_draws draws;
    VkDeviceAddress view;
};

static void execute_depth(const struct graph_context *context, const void *data) {
    const struct depth_data *d = data;
    struct gpu_graphics_params state = {.depth_format = GEOMETRY_DEPTH_FORMAT,
                                        .depth_test = true,
                                        .depth_write = true,
                                        .depth_compare = VK_COMPARE_OP_GREATER,
                                        .samples = 1};
    geometry_draw(context, d->scene, &d->draws, GEOMETRY_OPAQUE, &state, &shader_depth_frag,
                  (struct gpu_geometry_push){.view = d->view});
}

graph_image motion_depth_add(struct graph *graph, const struct geometry_scene *scene, const struct geometry_draws *draws,
                             VkDeviceAddress view, uint32_t width, uint32_t height) {
    struct depth_data data = {scene, *draws, view};
    graph_image depth = graph_create_image(
        graph, &(struct graph_image_params){
                   .name = "motion depth", .format = GEOMETRY_DEPTH_FORMAT, .width = width, .height = height});
    struct graph_pass *pass = graph_add_pass(graph, "motion depth", GRAPH_QUEUE_GRAPHICS, execute_depth, &data, sizeof data);
    geometry_use(pass, scene, draws, GEOMETRY_OPAQUE);
    graph_depth(pass, depth, VK_ATTACHMENT_LOAD_OP_CLEAR, 0);
    return depth;
}

/* ---- debug view ---- */

void motion_view_add(struct graph *graph, graph_image motion, graph_image target, bool swap) {
    struct graph_image_params image = graph_image_info(graph, target);
    struct gpu_motion_view_push push = {.width = image.width, .height = image.height, .swap = swap};
    graph_dispatch(graph, &(struct graph_dispatch){
                              .name = "motion view",
                              .pipeline = {.shader = &shader_motion_view_comp},
                              .groups = {DIVIDE_UP(image.width, 8u), DIVIDE_UP(image.height, 8u)},
                              GRAPH_PUSH(push),
                              GRAPH_ROWS(graph_samples(&push.motion, motion), graph_stores(&push.target, target))});
}
