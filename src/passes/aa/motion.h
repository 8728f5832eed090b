/* SPDX-License-Identifier: MIT */
/**
 * Motion vectors: where what a pixel shows was in the last frame. What stands still is found from depth and the two cameras;
 * objects that moved or deformed are drawn once more, with their last transforms and positions, wherever they are what depth
 * holds. Cost: a pass over the screen; in frames where objects move, one over the geometry, whose triangles at rest are
 * dropped before they are rasterised.
 */
#ifndef FNL_PASSES_MOTION_H
#define FNL_PASSES_MOTION_H

#include "passes/geometry/geometry.h"
#include "view_shared.h"

/** What moved between two frames, besides the camera. */
struct motion_objects {
    const struct geometry_scene *scene;
    const struct geometry_draws *draws;
    /** The first instance_count instances of the last frame, with rows of 0 for those that it did not draw, as it drew none behind them;
        then, at position_offset, the positions of deformed_count vertices from first_deformed on, which are all that may have moved.
        id 0: nothing moved or came. */
    graph_buffer previous;
    uint64_t position_offset;
    vec3 origin_moved; /* since the last frame; `previous` is relative to the old origin */
    uint32_t instance_count, first_deformed, deformed_count;
};

struct motion_input {
    VkDeviceAddress view;            /* of this frame */
    const struct gpu_view *current;  /* the same on the CPU */
    const struct gpu_view *previous; /* of the last frame, without jitter; NULL: there was none */
    vec2 jitter;       /* of this frame: what is seen at a pixel's centre lies this many pixels right of and below it */
    graph_image depth; /* of opaque surfaces, one sample per pixel */
    struct motion_objects objects;
};

/**
 * RGBA32F: motion in pixels, right and down, from this frame's place to the last one's, both without jitter; view depth in
 * the last frame, metres, 1e30 for an empty sky; 1 and by how many pixels the object itself has moved, or 0 where it was
 * behind the camera, or was not drawn, or there was no last frame (motion is 0 then).
 */
graph_image motion_add(struct graph *graph, gpu_device *device, const struct motion_input *input);

/** Depth of the opaque set for orders that keep none; one sample per pixel. */
graph_image motion_depth_add(struct graph *graph, const struct geometry_scene *scene, const struct geometry_draws *draws,
                             VkDeviceAddress view, uint32_t width, uint32_t height);

/** A picture of motion: hue is direction, saturation speed on a logarithmic scale up to 64 pixels; grey stands still, black was unseen. */
void motion_view_add(struct graph *graph, graph_image motion, graph_image target, bool swap);

#endif
