/* SPDX-License-Identifier: MIT */
/**
 * Level of detail for lights: one whose bounding sphere is small on the screen fades out, costs no evaluation once it is gone, and is
 * drawn as a point of as much light instead (the sprites of far lights in Just Cause 3, E. Persson).
 *
 * A light is whole from a projected radius of twice the threshold on, and gone below the threshold; the sprite has what it lacks. Fading
 * works on copies of the lights and their bounds, so that every list and every shading order, brute force included, sees the same lights: those that
 * are gone have a bounding radius of 0 and no colour.
 *
 * Cost: a pass over all lights, and a quad of 2x2 pixels for each light that is not whole.
 */
#ifndef FNL_PASSES_SPRITES_H
#define FNL_PASSES_SPRITES_H

#include "passes/lights/light_list.h"
#include "view_shared.h"

/** What is left of a light, 0 .. 1, as the GPU computes it up to rounding. `lod`: the threshold, pixels. */
float light_fade(const struct gpu_view *view, const struct gpu_entity_bounds *bounds, float lod);

/**
 * Copies the lights to `lights` and their bounds to `bounds`, faded for a view, and makes `set` refer to the copies, which have room for as many as
 * the originals and live as long as the frame.
 */
void light_fade_add(struct graph *graph, gpu_device *device, VkDeviceAddress view, struct light_set *set, const struct gpu_buffer *lights,
                    const struct gpu_buffer *bounds, float lod);

/** Draws the sprites of `lights` (those before fading) over what is opaque. `radiance` and `depth` may be multisampled. */
void sprites_add(struct graph *graph, VkDeviceAddress view, const struct light_set *lights, float lod, graph_image radiance, graph_image depth);

#endif
