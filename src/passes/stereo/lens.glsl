// SPDX-License-Identifier: MIT
#ifndef LENS_GLSL
#define LENS_GLSL
#include "common.glsl"

layout(buffer_reference) buffer lens_eye_block;
layout(buffer_reference) buffer lens_layers;
layout(buffer_reference) buffer lens_vertices;
#include "passes/stereo/lens_shared.h"
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer lens_eye_block { gpu_lens_eye at; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer lens_layers { gpu_lens_layer at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer lens_vertices { gpu_lens_vertex at[]; };

layout(push_constant, scalar) uniform push_block { gpu_lens_push push; };

#endif
