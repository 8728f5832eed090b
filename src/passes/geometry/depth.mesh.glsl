#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_mesh_shader : require
// What depth.vert.glsl does, for clusters.
#include "common.glsl"
#include "scene.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"
#include "passes/geometry/geometry_shared.h"

layout(push_constant, scalar) uniform push_block { gpu_geometry_push push; };

#include "passes/geometry/geometry_vertex.glsl"

void write_vertex(uint place, uint item_index, uint vertex);

#include "passes/geometry/mesh.glsl"

void write_vertex(uint place, uint item_index, uint vertex) {
    gl_MeshVerticesEXT[place].gl_Position = geometry_vertex_of(item_index, vertex).clip;
}
