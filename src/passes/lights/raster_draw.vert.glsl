#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Light meshes onto a target with a pixel for each tile: three vertices a triangle, an instance for each light in view. Each vertex carries
// the whole triangle.
#include "common.glsl"
#include "passes/lights/raster.glsl"

layout(location = 0) flat out vec3 out_a;
layout(location = 1) flat out vec3 out_b;
layout(location = 2) flat out vec3 out_c;
layout(location = 3) flat out uvec2 out_light; // number among those in view; 1 if this face may say where the light begins

void main() {
    uint index = gl_InstanceIndex, triangle = gl_VertexIndex / 3u, corner = gl_VertexIndex % 3u;
    out_a = out_b = out_c = vec3(0.0);
    out_light = uvec2(index, 0u);
    gl_Position = vec4(2.0, 2.0, 0.0, 1.0); // out of sight
    gpu_bound bound = RASTER.bounds.at[index];
    light_mesh mesh = mesh_of(RASTER.visible_ids.at[index]);
    if (triangle >= mesh.triangle_count || !has_slots(index)) return;
    uvec3 corners = mesh_triangle(mesh, triangle);
    out_a = mesh_vertex(mesh, corners.x);
    out_b = mesh_vertex(mesh, corners.y);
    out_c = mesh_vertex(mesh, corners.z);
    // No mesh reaches farther from the middle of the light's sphere than three of its radii.
    shell s = shell_of(index, bound, -bound.center.z - 3.0 * bound.radius);
    out_light.y = !s.cut_by_near || faces_viewer(out_a, out_b, out_c, mesh_inside(mesh)) ? 1u : 0u;

    vec3 p = corner == 0u ? out_a : corner == 1u ? out_b : out_c;
    vec4 clip = RASTER.view.view.view_to_clip * vec4(p.xy, -p.z, 1.0);
    // The grid begins in the top left corner of the picture and reaches beyond the other.
    vec2 part = vec2(RASTER.view.view.size) /
                (vec2(RASTER.list.list.tiles_x, RASTER.list.list.tiles_y) * float(RASTER.list.list.tile_size));
    gl_Position = vec4(clip.xy * part + clip.w * vec2(part.x - 1.0, 1.0 - part.y), clip.z, clip.w);
}
