/* SPDX-License-Identifier: MIT */
/** Converts lights to what shaders and lists read: a shape and bounds, by kind. */
#ifndef FNL_RENDER_DEVICE_LIGHT_SHAPES_H
#define FNL_RENDER_DEVICE_LIGHT_SHAPES_H

#include "fanal/light.h"
#include "lighting/lighting_shared.h"

/** The light of a slot and its bounds, which are empty for directional lights. `light->range` is finite. */
void device_light(const fnl_light_params *light, uint32_t slot, struct gpu_light *out, struct gpu_entity_bounds *out_bounds);
/** Where the shape of a slot's light lies, in bytes from that of the first slot. */
uint32_t device_light_shape(uint32_t slot);

#endif
