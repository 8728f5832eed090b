#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The one vertex shader: pulls the vertex of an item by address. Depth passes and shading passes use it alike, so that depths are
// equal to the bit. Variants leave out what some fragment shaders do not read: NO_SURFACE, NO_TEXTURES, NO_CORNER; geometry.c picks them by
// what is left in the compiled shaders. Beside it stands geometry.mesh.glsl.
#include "common.glsl"
#include "scene.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"
#include "passes/geometry/layered.glsl"

#ifndef NO_SURFACE
layout(location = 0) centroid out vec4 out_position; // material.glsl says why four
layout(location = 1) centroid out vec3 out_normal;
layout(location = 2) centroid out vec4 out_tangent;
layout(location = 7) centroid out vec3 out_bind; // position before the mesh deforms, in its own space
#endif
#ifndef NO_TEXTURES
layout(location = 3) centroid out vec4 out_uv; // uv0, uv1
layout(location = 4) centroid out vec4 out_color;
#endif
layout(location = 5) flat out uvec3 out_ids; // material, item; 1: the instance mirrors, 2: not a triangle
#ifndef NO_CORNER
layout(location = 6) flat out uint out_corner; // tells triangles of an item apart
#endif
#ifdef LAYERED
layout(location = 8) flat out uint out_layer;
#endif

invariant gl_Position;

#include "passes/geometry/geometry_vertex.glsl"

void main() {
    geometry_vertex v = geometry_vertex_of(push.visible.at[drawn_instance()], uint(gl_VertexIndex));
    gl_Position = v.clip;
    gl_PointSize = 1.0;
#ifdef LAYERED
    gl_Layer = int(drawn_layer());
    out_layer = drawn_layer();
#endif
    out_ids = v.ids;
#ifndef NO_SURFACE
    out_position = vec4(v.position, 1.0);
    out_normal = v.normal;
    out_tangent = v.tangent;
    out_bind = v.bind;
#endif
#ifndef NO_TEXTURES
    out_uv = v.uv;
    out_color = v.color;
#endif
#ifndef NO_CORNER
    out_corner = uint(gl_VertexIndex);
#endif
}
