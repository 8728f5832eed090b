// SPDX-License-Identifier: MIT
// From an id and a pixel to interpolated attributes with their gradients: what vertex shader and rasteriser do for forward shading.
//
// A pixel's ray meets the plane of a triangle a, b, c. With e1 = b - a, e2 = c - a and s the ray's point at a's depth minus a, all in view
// space, the weights of b and c are
//     s.(d x e2) / e1.(d x e2)  and  d.(s x e1) / e1.(d x e2)
// (Moeller and Trumbore 1997, with the origin moved to where rounding is smallest). It holds for triangles that reach behind the viewer, since
// nothing is divided by a vertex's depth.
#ifndef TRIANGLE_GLSL
#define TRIANGLE_GLSL

#include "view.glsl"
#include "scene.glsl"

struct triangle {
    gpu_item item;
    uint item_index;
    gpu_primitive primitive;
    gpu_instance instance;
    uint vertices[3]; // lines repeat the second, points the only one
    vec3 positions[3]; // world space
    vec3 seen[3];      // view space
};

triangle triangle_of_item(scene_block scene, uint item_index) {
    triangle t;
    t.item_index = item_index;
    t.item = scene.scene.items.at[item_index];
    t.primitive = scene.scene.primitives.at[t.item.primitive];
    t.instance = scene.scene.instances.at[t.item.instance];
    for (uint i = 0u; i < 3u; i++) t.positions[i] = t.seen[i] = vec3(0.0);
    return t;
}

// Number of a corner's vertex; lines repeat the second, points the only one.
uint triangle_vertex(gpu_primitive primitive, const_uint_array indices, uint number, uint corner) {
    uint index = indices.at[primitive.first_index + number * primitive.corners + min(corner, primitive.corners - 1u)];
    return uint(int(index) + primitive.vertex_offset);
}

void triangle_fetch_vertices(inout triangle t, scene_block scene, const_uint_array indices, uint number) {
    for (uint i = 0u; i < 3u; i++) t.vertices[i] = triangle_vertex(t.primitive, indices, number, i);
}

void triangle_fetch_positions(inout triangle t, scene_block scene, view_block view) {
    for (uint i = 0u; i < 3u; i++) {
        precise vec3 position = transform_point(t.instance, scene.scene.positions.at[t.vertices[i]]);
        t.positions[i] = position;
        t.seen[i] = (view.view.world_to_view * vec4(position, 1.0)).xyz;
    }
}

// Weights of the three vertices at a point of the screen, pixels from the top left. Lines: those of the nearest point on the screen. Beyond
// the edges they go on, as at helper invocations.
vec3 triangle_weights(triangle t, view_block view, vec2 pixel) {
    vec2 ndc = ndc_of_pixel(view, pixel);
    if (t.primitive.corners == 1u) return vec3(1.0, 0.0, 0.0);
    vec2 slope = ndc * view.view.ndc_scale + view.view.ndc_offset;
    bool orthographic = view.view.orthographic > 0.5;
    if (t.primitive.corners == 2u) {
        vec2 a = t.seen[0].xy / (orthographic ? 1.0 : max(-t.seen[0].z, 1e-6)), b = t.seen[1].xy / (orthographic ? 1.0 : max(-t.seen[1].z, 1e-6));
        vec2 along = b - a;
        float share = clamp(dot(slope - a, along) / max(dot(along, along), 1e-30), 0.0, 1.0);
        if (!orthographic) share = share * t.seen[0].z / mix(t.seen[1].z, t.seen[0].z, share);
        return vec3(1.0 - share, share, 0.0);
    }
    vec3 direction = orthographic ? vec3(0.0, 0.0, -1.0) : vec3(slope, -1.0);
    vec3 e1 = t.seen[1] - t.seen[0], e2 = t.seen[2] - t.seen[0];
    vec3 s = vec3(slope * (orthographic ? 1.0 : -t.seen[0].z) - t.seen[0].xy, 0.0);
    vec3 p = cross(direction, e2);
    float determinant = dot(e1, p);
    float scale = abs(determinant) > 1e-37 ? 1.0 / determinant : 0.0;
    float b = dot(s, p) * scale, c = dot(direction, cross(s, e1)) * scale;
    return vec3(1.0 - b - c, b, c);
}

// Whether its vertices run counter-clockwise on the screen.
bool triangle_front_facing(triangle t, view_block view) {
    vec3 normal = cross(t.seen[1] - t.seen[0], t.seen[2] - t.seen[0]);
    float facing = view.view.orthographic > 0.5 ? normal.z : -dot(normal, t.seen[0]);
    return facing * view.view.ndc_scale.x * view.view.ndc_scale.y > 0.0 || t.primitive.corners != 3u;
}

#endif
