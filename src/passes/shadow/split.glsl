// SPDX-License-Identifier: MIT
#ifndef SHADOW_SPLIT_GLSL
#define SHADOW_SPLIT_GLSL

#include "common.glsl"

layout(buffer_reference) buffer split_row_array;
layout(buffer_reference) buffer split_counts_block;
#if !defined(LIGHTS_ITERATE_GLSL) && !defined(SHADOW_PAGES_GLSL)
layout(buffer_reference) readonly buffer lighting_block;
#endif
#if !defined(SHADOWS_FACES_GLSL) && !defined(SHADOW_PAGES_GLSL)
layout(buffer_reference) buffer shadow_page_array;
#endif
#include "passes/shadow/split_shared.h"
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer split_row_array { gpu_shadow_split_row at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer split_counts_block { gpu_shadow_split_counts counts; };

#endif
