// SPDX-License-Identifier: MIT
// References to the structs of lighting_shared.h: lighting_block, light_set_block, light_list_block.
#ifndef LIGHTING_SCOPES_GLSL
#define LIGHTING_SCOPES_GLSL

#include "common.glsl"

#include "view.glsl"

layout(buffer_reference) buffer light_array;
layout(buffer_reference) buffer entity_array;
layout(buffer_reference) buffer shape_block;
layout(buffer_reference) buffer cell_array;
layout(buffer_reference) buffer bounds_array;
layout(buffer_reference) readonly buffer light_set_block;
layout(buffer_reference) readonly buffer light_list_block;

#include "lighting/lighting_shared.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer light_array { gpu_light at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer entity_array { gpu_entity_bounds at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer shape_block { gpu_shape shape; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer cell_array { gpu_cell at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer bounds_array { gpu_cell_bounds at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer light_set_block { gpu_light_set set; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer light_list_block { gpu_light_list list; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer lighting_block { gpu_lighting scope; };

// References to be passed on: glslang refuses members of readonly blocks as arguments.
light_set_block lights_of(lighting_block l) { return light_set_block(l); } // its first member
light_set_block set_of(light_list_block l) {
    light_set_block set = l.list.lights;
    return set;
}
light_list_block list_of(lighting_block l) {
    light_list_block list = l.scope.list;
    return list;
}

layout(constant_id = LIGHTING_ID) const uint LIGHTING_BITS = GPU_LIST_ALL;
const uint LIST_KIND = LIGHTING_BITS & GPU_LIST_KINDS;
const bool LIST_SCATTERED = (LIGHTING_BITS & GPU_LIST_SCATTERED) != 0u;
const bool LIGHTING_SIMPLE = (LIGHTING_BITS & GPU_LIGHTING_SIMPLE) != 0u;
const bool LIGHTING_MASKS = (LIGHTING_BITS & GPU_LIGHTING_MASKS) != 0u;
const bool LIGHTING_PROFILES = (LIGHTING_BITS & GPU_LIGHTING_PROFILES) != 0u;
const bool LIGHTING_AREA_LIGHTS = (LIGHTING_BITS & GPU_LIGHTING_AREA_LIGHTS) != 0u;
const bool LIGHTING_LAYERS = (LIGHTING_BITS & GPU_LIGHTING_LAYERS) != 0u;
const bool LIGHTING_ENVIRONMENT = (LIGHTING_BITS & GPU_LIGHTING_ENVIRONMENT) != 0u;
const bool LIGHTING_REFLECTIONS = (LIGHTING_BITS & GPU_LIGHTING_REFLECTIONS) != 0u;
const bool LIGHTING_CONSERVING = (LIGHTING_BITS & GPU_LIGHTING_CONSERVING) != 0u;
const bool LIGHTING_BEHIND_GLASS = (LIGHTING_BITS & GPU_LIGHTING_BEHIND_GLASS) != 0u;
const bool LIGHTING_SHADOWED = (LIGHTING_BITS & GPU_LIGHTING_CASTS) != 0u;
const bool LIGHTING_RAYS = (LIGHTING_BITS & GPU_LIGHTING_RAYS) != 0u;
const bool LIGHTING_MAPS = (LIGHTING_BITS & GPU_LIGHTING_MAPS) != 0u;
const bool LIGHTING_SOFT = (LIGHTING_BITS & GPU_LIGHTING_SOFT) != 0u;
const bool LIGHTING_FILTERED = (LIGHTING_BITS & GPU_LIGHTING_FILTERED) != 0u;
const bool LIGHTING_SAMPLED = (LIGHTING_BITS & GPU_LIGHTING_SAMPLED) != 0u;
const bool LIGHTING_RAY_QUERY = (LIGHTING_BITS & GPU_LIGHTING_RAY_QUERY) != 0u;
const bool LIGHTING_CONTACT = (LIGHTING_BITS & GPU_LIGHTING_CONTACT) != 0u;
const bool LIGHTING_CUBEMAP = (LIGHTING_BITS & GPU_LIGHTING_CUBEMAP) != 0u;
const bool LIGHTING_DENOISED = (LIGHTING_BITS & GPU_LIGHTING_DENOISED) != 0u;

#endif
