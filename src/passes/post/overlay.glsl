// SPDX-License-Identifier: MIT
#ifndef OVERLAY_GLSL
#define OVERLAY_GLSL
#include "common.glsl"

layout(buffer_reference) buffer overlay_vertices;
#include "passes/post/overlay_shared.h"
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer overlay_vertices { gpu_overlay_vertex at[]; };

layout(push_constant, scalar) uniform push_block { gpu_overlay_push push; };

#endif
