/* SPDX-License-Identifier: MIT */
/** Debug views, and the surface as numbers (AOVs). */
#ifndef FNL_PASSES_DEBUG_H
#define FNL_PASSES_DEBUG_H

#include "passes/debug/debug_shared.h"
#include "passes/geometry/geometry.h"
#include "passes/lighting/lighting.h"

/** RGBA32F images of the nearest opaque surface: base colour and roughness; normal and view depth; position and item id + 1. */
struct aov_images {
    graph_image albedo, normal, position;
};
struct aov_images aov_add(struct graph *graph, const struct geometry_scene *scene, const struct geometry_draws *draws,
                          VkDeviceAddress view, uint32_t width, uint32_t height);

/**
 * RGBA32F image of FNL_OUTPUT_OBJECT: opaque, transmissive and blended surfaces. `table` is the address of a struct device_object for each item, three
 * words. `draws` has the blended items. Cost: the geometry, and a texture for each fragment.
 */
graph_image objects_add(struct graph *graph, gpu_device *device, const struct geometry_scene *scene, const struct geometry_draws *draws,
                        VkDeviceAddress view, VkDeviceAddress table, uint32_t width, uint32_t height);

/** Counts the fragments of all opaque items in `counters`, one uint per pixel, which the pass clears. */
graph_buffer overdraw_add(struct graph *graph, const struct geometry_scene *scene, const struct geometry_draws *draws,
                          VkDeviceAddress view, uint32_t width, uint32_t height);

/**
 * Counts the invocations that forward shading after a prepass spends on opaque items, helpers too: four for each primitive and each
 * square of 2x2 pixels that it shows in, in equal parts at the pixels where it shows. One uint per pixel, GPU_OVERSHADING_UNIT for one
 * invocation.
 */
graph_buffer overshading_add(struct graph *graph, const struct geometry_scene *scene, const struct geometry_draws *draws,
                             VkDeviceAddress view, uint32_t width, uint32_t height);

/** RG16F image of the nearest opaque surface: metalness, and the luminance of the diffuse colour that it leaves. */
graph_image halos_add(struct graph *graph, const struct geometry_scene *scene, const struct geometry_draws *draws,
                      VkDeviceAddress view, uint32_t width, uint32_t height);

/** A number for the cluster of triangles that each pixel shows; 0 nothing, 1 what has none. Needs fnl_device_info.primitive_ids. */
graph_buffer cluster_view_add(struct graph *graph, const struct geometry_scene *scene, const struct geometry_draws *draws,
                              VkDeviceAddress view, uint32_t width, uint32_t height);

/** A number for the triangle that each pixel shows; 0 nothing, 1 points and lines. Needs fnl_device_info.primitive_ids. */
graph_buffer triangle_view_add(struct graph *graph, const struct geometry_scene *scene, const struct geometry_draws *draws,
                               VkDeviceAddress view, uint32_t width, uint32_t height);

/** Numbers per pixel: the first of each `stride`; of fragments for GPU_DEBUG_OVERDRAW, of parts of invocations for
 *  GPU_DEBUG_OVERSHADING, of blended fragments for GPU_DEBUG_LAYERS, of lights where shading does not go by the list. */
struct debug_counts {
    graph_buffer buffer; /* id 0: none */
    uint32_t stride;
};

/** Writes the view `mode` (GPU_DEBUG_…) to a storage image. `metal`: of halos_add, for GPU_DEBUG_HALOS alone. */
void debug_view_add(struct graph *graph, uint32_t mode, const struct aov_images *aov, const struct light_list *lights,
                    struct debug_counts counts, graph_image metal, VkDeviceAddress view, graph_image target, bool swap);

/**
 * Writes a view of shadow maps (GPU_DEBUG_SHADOW_…) to a storage image. `lights` has maps, or rays find all shadows; GPU_DEBUG_SHADOW_ERRORS needs
 * rays too; GPU_DEBUG_SHADOW_CLASSES the list that shadow_dark_add() has shortened, and its `classes` (else id 0). Cost: a visit of every light of the
 * pixel's list; of errors, a look-up and a ray for each that reaches it; of rays, the rays.
 */
void shadow_view_add(struct graph *graph, uint32_t mode, const struct aov_images *aov, const struct lighting *lighting, graph_buffer classes,
                     VkDeviceAddress view, graph_image target, bool swap);

/**
 * Writes the view of light volumes to a storage image: surfaces in the hues of the lights that reach them, with a line where a light's volume ends.
 * Cost: a visit to every light in the pixel's list, and a test of four more points for each light that reaches the pixel.
 */
void light_volumes_view_add(struct graph *graph, const struct aov_images *aov, const struct lighting *lighting, VkDeviceAddress view, graph_image target,
                            bool swap);

/** Writes the view of reflection probes to a storage image: a colour for each, by its part of the light; grey where none is. */
void reflections_view_add(struct graph *graph, const struct aov_images *aov, const struct environment_light *light, VkDeviceAddress view,
                          graph_image target, bool swap);

#endif
