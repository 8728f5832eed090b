/* SPDX-License-Identifier: MIT */
/**
 * Occlusion culling in two phases: what the last frame's depth, seen from where the camera is now, does not hide is drawn as occluders; the
 * depth that this gives hides the rest (Doghramachi and Bucci, "Deferred+", GPU Zen, 2017; Haar and Aaltonen, SIGGRAPH 2015). The first phase only
 * chooses what is drawn early, so what it takes for hidden costs time and never the picture: in the end everything is tested against
 * depths of this very frame.
 */
#ifndef FNL_PASSES_OCCLUSION_H
#define FNL_PASSES_OCCLUSION_H

#include "passes/geometry/geometry.h"
#include "view_shared.h"

/** Hierarchical depth (hierarchy.glsl): width x height squares of 8 x 8 pixels, and levels of half the size. */
struct hierarchy {
    graph_buffer levels;
    uint32_t width, height;
};

/**
 * Culls items and writes draws as cull_add does, and leaves out opaque items and cutouts that others hide in all samples. `camera` is the view on
 * the CPU, `previous` that of the last frame or NULL. Every pass that draws the result must do so in pixels of the view's size with `samples`
 * samples each. `out` is what hid them. Cost: a depth-only pass over the occluders, the culling of items twice.
 */
struct geometry_draws occlusion_add(struct graph *graph, gpu_device *device, const struct geometry_scene *scene,
                                    const struct gpu_view *camera, const struct gpu_view *previous, VkDeviceAddress view,
                                    uint32_t samples, struct hierarchy *out);

#endif
