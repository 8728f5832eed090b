/* SPDX-License-Identifier: MIT */
/** From radiance to the picture, or to a debug view in its place: exposure and picture. */
#include "passes/aa/morphological.h"
#include "passes/post/overlay.h"
#include "passes/post/post.h"
#include "render/debug_views.h"
#include "render/frame_steps.h"
#include "render/overlay.h"
#include "render/step.h"

bool frame_shows_surfaces(const fnl_frame *frame) {
    return debug_views_need_surfaces(frame) ||
           (frame->outputs & (FNL_OUTPUT_SURFACE | FNL_OUTPUT_NORMAL | FNL_OUTPUT_POSITION));
}

static void add_picture(struct frame_state *f) {
    struct picture picture = frame_picture(f);
    bool linear = picture.tonemap.linear, swap = picture.tonemap.swap, done = f->color.id; /* by the shading order */
    if (!done) f->color = frame_create_image(f, "color", picture.format, 1);
    picture.tonemap.exposure = f->exposure;
    if (f->frame->debug != FNL_DEBUG_NONE) {
        debug_views_add(f, swap);
        return;
    }
    if (!done) tonemap_add(f->graph, f->radiance, f->color, &picture.tonemap);
    struct morphological_params shapes = {linear, swap};
    if (f->frame->aa == FNL_ANTIALIASING_MLAA) f->color = mlaa_add(f->graph, f->color, &shapes);
    if (f->frame->aa == FNL_ANTIALIASING_SMAA) f->color = smaa_add(f->graph, f->color, &shapes);
}

static void finish_picture(struct frame_state *f) {
    add_picture(f);
    if (f->input->target) {
        const struct gpu_extent size = frame_target_size(f->input->target);
        if (size.width != f->frame->width || size.height != f->frame->height) f->color = scale_add(f->r->device, f->graph, f->color, size.width, size.height);
    }
    const struct picture picture = frame_picture(f);
    const bool decode = picture.tonemap.linear && f->frame->debug != FNL_DEBUG_NONE; /* debug views are colours, not light */
    if (decode && picture.display == DISPLAY_LINEAR) f->color = display_add(f->graph, f->color, DISPLAY_LINEAR, true);
    if (f->frame->overlay) overlay_draw(f);
    if (picture.display != DISPLAY_LINEAR) f->color = display_add(f->graph, f->color, picture.display, decode);
}

struct copy_image_data {
    graph_image from, to;
    struct gpu_image_copy copy;
};

static void execute_copy_image(const struct graph_context *context, const void *data) {
    const struct copy_image_data *d = data;
    gpu_copy_image(context->commands, graph_get_image(context, d->from), graph_get_image(context, d->to), &d->copy);
}

/* Depth goes where the picture does. */
static void add_target_depth(struct frame_state *f, const struct gpu_image_copy *part) {
    const struct frame_target *target = f->input->target;
    struct copy_image_data copy = {depth_picture_add(f->graph, f->depth, target->depth_forward),
                                   graph_import_image(f->graph, target->depth, target->depth_initial_layout, target->depth_final_layout), *part};
    struct graph_pass *pass = graph_add_pass(f->graph, "copy depth to target", GRAPH_QUEUE_GRAPHICS, execute_copy_image, &copy, sizeof copy);
    graph_use_image(pass, copy.from, GRAPH_COPY_FROM);
    graph_use_image(pass, copy.to, GRAPH_COPY_TO);
}

static void add_target(struct frame_state *f) {
    const fnl_vulkan_part *part = &f->input->target->part;
    struct copy_image_data copy = {
        f->color, graph_import_image(f->graph, f->input->target->image, f->input->target->initial_layout, f->input->target->final_layout),
        {.to_x = part->x, .to_y = part->y, .width = part->width, .height = part->height, .layer = f->view_index}};
    if (!part->fitted) {
        copy.copy.from_x = part->x;
        copy.copy.from_y = part->y;
    }
    struct graph_pass *pass =
        graph_add_pass(f->graph, "copy to target", GRAPH_QUEUE_GRAPHICS, execute_copy_image, &copy, sizeof copy);
    graph_use_image(pass, copy.from, GRAPH_COPY_FROM);
    graph_use_image(pass, copy.to, GRAPH_COPY_TO);
    if (f->input->target->depth) add_target_depth(f, &copy.copy);
}

/* ---- the steps ---- */

static bool wants_color(const struct frame_state *f) { return f->input->target || (f->frame->outputs & FNL_OUTPUT_COLOR); }

static void expose(struct frame_state *views, uint32_t count) {
    graph_set_role(views->graph, GRAPH_ROLE_REST);
    graph_image radiance[GROUP_MOST] = {{0}}, depth[GROUP_MOST] = {{0}};
    const fnl_frame *frame = views->frame;
    if (frame->exposure != FNL_EXPOSURE_AUTO || !(wants_color(views) || frame->aa == FNL_ANTIALIASING_TAA)) return;
    for (uint32_t i = 0; i < count; i++) radiance[i] = views[i].radiance, depth[i] = views[i].depth;
    views->exposure = exposure_add(views->graph, radiance, depth, count);
    for (uint32_t i = 1; i < count; i++) views[i].exposure = views->exposure;
}

const struct counter_table counters_exposure = {.counts_size = sizeof(struct exposure_counts)};

/* One for all views that are lit together. */
const struct frame_step step_exposure = {.name = "exposure", .end_light = expose, .counters = &counters_exposure};

static void finish_view(struct frame_state *f) {
    graph_set_role(f->graph, GRAPH_ROLE_REST);
    if (wants_color(f)) finish_picture(f);
    if (f->input->target) add_target(f);
}

const struct frame_step step_picture = {.name = "picture", .finish_view = finish_view};
