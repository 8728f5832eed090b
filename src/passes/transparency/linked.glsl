// SPDX-License-Identifier: MIT
#ifndef LINKED_GLSL
#define LINKED_GLSL

layout(buffer_reference) buffer blend_color_array;
layout(buffer_reference) buffer blend_key_array;
layout(buffer_reference) buffer blend_extent_array;

#include "passes/transparency/transparency_shared.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer blend_color_array { vec4 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer blend_key_array { gpu_blend_key at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer blend_extent_array { gpu_blend_extent at[]; };

#endif
