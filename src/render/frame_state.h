/* SPDX-License-Identifier: MIT */
/** What the parts of a frame hand to each other while it is declared. */
#ifndef FNL_RENDER_FRAME_STATE_H
#define FNL_RENDER_FRAME_STATE_H

#include "decals_shared.h"
#include "passes/aa/motion.h"
#include "render/renderer_internal.h"

/** Decals of the frame (decals.c). */
struct frame_decals {
    struct device_decals_frame buffers;
    struct gpu_decal_set *set; /* NULL: there are none */
    VkDeviceAddress set_address;
    struct light_input input;
    struct lights_in_view in_view;
    struct light_list list;
    graph_buffer fragments; /* of the G-buffer's way: struct decals_gbuffer_totals */
};

/** Of the frame and the last one (temporal.c). */
struct frame_temporal {
    struct gpu_view view; /* without jitter */
    vec2 jitter;          /* pixels right of and below their centres */
    uint32_t index;
    bool keeps, still; /* the last frame's history counts; and nothing has changed since */
    graph_image motion;
};

struct frame_state {
    fnl_renderer *r;
    const fnl_frame *frame;
    struct graph *graph;
    struct device_scene_frame *scene; /* the renderer's: passes look at it while they are recorded */
    struct gpu_view view;
    VkDeviceAddress view_address;
    struct geometry_draws draws;
    graph_image radiance, depth;
    struct gbuffer gbuffer; /* depth id 0: none */
    struct light_input whole_lights;        /* before small ones were faded */
    fnl_light_lists drawn_lists;            /* the frame's, or those that stand in for them */
    struct light_list lights, blend_lights; /* the same list but for tiles with depth bounds */
    graph_buffer counters, exposure, class_counts;
    graph_buffer surfaces, edge_counts; /* of deferred shading with MSAA (passes/shade/edges.h) */
    struct frame_decals decals;
    struct aov_images aov;
    struct linked_lists linked; /* transparency */
    uint64_t blend_bytes;
    struct frame_temporal temporal;
    graph_image color;
};

/** An image of the frame's size. */
static inline graph_image frame_create_image(struct frame_state *f, const char *name, VkFormat format, uint32_t samples) {
    return graph_create_image(
        f->graph,
        &(struct graph_image_params){
            .name = name, .format = format, .width = f->frame->width, .height = f->frame->height, .samples = samples});
}

#endif
