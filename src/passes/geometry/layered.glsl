// SPDX-License-Identifier: MIT
// Push constants of the vertex shaders, and the instance that a vertex belongs to. With LAYERED instances are repeated for each view, and so is the first
// one of a draw, and the shader chooses the layer of the view that it draws for. Comes behind view.glsl and before what uses DRAWN_VIEW.
#ifndef LAYERED_GLSL
#define LAYERED_GLSL

#include "passes/geometry/geometry_shared.h"

#ifdef LAYERED
#extension GL_ARB_shader_viewport_layer_array : require
#include "passes/geometry/layered_shared.h"

layout(push_constant, scalar) uniform push_block {
    gpu_geometry_push push;
    layout(offset = LAYERED_AT) gpu_layered_push layered;
};

uint drawn_layer() { return layered.first + uint(gl_InstanceIndex) % layered.count; }
uint drawn_instance() { return uint(gl_InstanceIndex) / layered.count; }
#undef DRAWN_VIEW
#define DRAWN_VIEW(first) view_at(first, drawn_layer())
#else
layout(push_constant, scalar) uniform push_block { gpu_geometry_push push; };

uint drawn_instance() { return uint(gl_InstanceIndex); }
#endif

#endif
