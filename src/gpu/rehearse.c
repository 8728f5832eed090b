/* SPDX-License-Identifier: MIT */
/**
 * Mesa's CPU driver (25.0) compiles a shader not when a pipeline is made but when it is first used, on the thread of the queue, where every
 * frame waits for it; that takes seconds. What it has compiled it keeps in files, for all devices and runs. So pipelines that are made
 * ahead are used at once on a second device, whose queue has a thread of its own: a dispatch of no work groups, a draw of one vertex of
 * a triangle. Neither runs a shader, but the driver compiles for both. Vertex shaders are left out: they are small, and nearly all are in use
 * when something is asked for.
 */
#include "gpu/gpu_internal.h"

enum { SIDE = 4 };

struct canvas {
    struct gpu_image colors[GPU_MAX_COLORS], depth;
    struct gpu_rendering rendering;
};

static fnl_result make_target(gpu_device *stage, VkFormat format, const struct gpu_graphics_params *pipeline,
                              VkImageUsageFlags usage, struct gpu_image *out) {
    uint32_t layers = 1;
    while (pipeline->view_mask && layers < 32 && pipeline->view_mask >> layers) layers++;
    struct gpu_image_params params = {.name = "rehearsal",
                                      .format = format,
                                      .width = SIDE,
                                      .height = SIDE,
                                      .layers = layers,
                                      .mips = 1,
                                      .samples = pipeline->samples,
                                      .usage = usage};
    return gpu_image_create(stage, &params, out);
}

static fnl_result make_canvas(gpu_device *stage, const struct gpu_graphics_params *params, struct canvas *out) {
    out->rendering = (struct gpu_rendering){
        .width = SIDE, .height = SIDE, .layers = 1, .view_mask = params->view_mask, .color_count = params->color_count};
    for (uint32_t i = 0; i < params->color_count; i++) {
        TRY(make_target(stage, params->color_formats[i], params, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT,
                        &out->colors[i]));
        out->rendering.colors[i] = (struct gpu_attachment){.image = &out->colors[i],
                                                           .load = VK_ATTACHMENT_LOAD_OP_DONT_CARE,
                                                           .store = VK_ATTACHMENT_STORE_OP_DONT_CARE};
    }
    if (params->depth_format == VK_FORMAT_UNDEFINED) return FNL_OK;
    TRY(make_target(stage, params->depth_format, params, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT, &out->depth));
    out->rendering.depth = (struct gpu_attachment){.image = &out->depth,
                                                   .load = VK_ATTACHMENT_LOAD_OP_DONT_CARE,
                                                   .store = VK_ATTACHMENT_STORE_OP_DONT_CARE};
    return FNL_OK;
}

static void to_attachment(struct gpu_commands *commands, const struct gpu_image *image) {
    if (!image->handle) return;
    VkImageAspectFlags aspect = gpu_format_aspect(image->params.format);
    VkImageLayout layout = aspect & VK_IMAGE_ASPECT_COLOR_BIT           ? VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL
                           : aspect == VK_IMAGE_ASPECT_STENCIL_BIT      ? VK_IMAGE_LAYOUT_STENCIL_ATTACHMENT_OPTIMAL
                           : aspect & VK_IMAGE_ASPECT_STENCIL_BIT       ? VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL
                                                                        : VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL;
    struct gpu_image_barrier barrier = {.image = image,
                                        .to_stages = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                        .to_access = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT,
                                        .to_layout = layout};
    gpu_barrier(commands, &barrier, 1, 0, 0, 0, 0);
}

static void draw_nothing(struct gpu_commands *commands, const struct canvas *canvas,
                         const struct gpu_graphics_params *params) {
    for (uint32_t i = 0; i < params->color_count; i++) to_attachment(commands, &canvas->colors[i]);
    to_attachment(commands, &canvas->depth);
    gpu_begin_rendering(commands, &canvas->rendering);
    gpu_bind(commands, gpu_graphics_pipeline(commands->device, params));
    if (params->stencil.test && params->stencil.reference == GPU_STENCIL_SET) gpu_stencil_reference(commands, 0);
    gpu_draw(commands, 1, 1, 0, 0);
    gpu_end_rendering(commands);
}

bool gpu_rehearse(gpu_device *stage, const struct gpu_pipeline *pipeline) {
    bool compute = pipeline->point == VK_PIPELINE_BIND_POINT_COMPUTE;
    const struct gpu_graphics_params *graphics = compute ? NULL : &pipeline->key.graphics;
    /* Scopes belong to their device; one point makes no triangle, but it makes a point. */
    if (graphics && (graphics->scope || graphics->mesh || graphics->topology == VK_PRIMITIVE_TOPOLOGY_POINT_LIST))
        return false;
    struct canvas canvas = {0};
    bool done = false;
    if ((!graphics || make_canvas(stage, graphics, &canvas) == FNL_OK) && gpu_frame_begin(stage) == FNL_OK) {
        struct gpu_commands *commands = gpu_commands_begin(stage, GPU_QUEUE_GRAPHICS, 0);
        if (graphics) {
            draw_nothing(commands, &canvas, graphics);
        } else {
            gpu_bind(commands, gpu_compute_pipeline(stage, &pipeline->key.compute));
            gpu_dispatch(commands, 0, 0, 0);
        }
        gpu_commands_end(commands);
        const struct gpu_batch batch = {GPU_QUEUE_GRAPHICS, &commands, 1, GPU_NO_INDEX};
        done = gpu_frame_end(stage, &batch, 1, NULL) == FNL_OK;
    }
    for (uint32_t i = 0; i < GPU_MAX_COLORS; i++) gpu_image_destroy(stage, &canvas.colors[i]);
    gpu_image_destroy(stage, &canvas.depth);
    return gpu_wait_idle(stage) == FNL_OK && done;
}
