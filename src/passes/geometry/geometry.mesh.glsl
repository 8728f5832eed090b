#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_mesh_shader : require
// What geometry.vert.glsl does, for clusters.
#include "common.glsl"
#include "scene.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"
#include "passes/geometry/geometry_shared.h"

layout(push_constant, scalar) uniform push_block { gpu_geometry_push push; };

#include "passes/geometry/geometry_vertex.glsl"

layout(location = 0) centroid out vec4 out_position[];
layout(location = 1) centroid out vec3 out_normal[];
layout(location = 2) centroid out vec4 out_tangent[];
layout(location = 3) centroid out vec4 out_uv[];
layout(location = 4) centroid out vec4 out_color[];
layout(location = 5) flat out uvec3 out_ids[];
layout(location = 6) flat out uint out_corner[];
layout(location = 7) centroid out vec3 out_bind[];

void write_vertex(uint place, uint item_index, uint vertex);

#include "passes/geometry/mesh.glsl"

void write_vertex(uint place, uint item_index, uint vertex) {
    geometry_vertex v = geometry_vertex_of(item_index, vertex);
    gl_MeshVerticesEXT[place].gl_Position = v.clip;
    out_position[place] = vec4(v.position, 1.0);
    out_normal[place] = v.normal;
    out_tangent[place] = v.tangent;
    out_uv[place] = v.uv;
    out_color[place] = v.color;
    out_ids[place] = v.ids;
    out_corner[place] = vertex;
    out_bind[place] = v.bind;
}
