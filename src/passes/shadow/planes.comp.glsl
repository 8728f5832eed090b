#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Finds the planes of the surfaces in the depth image, and the oblong pages of suns that their pixels need.
#include "lighting/visibility.glsl"
#include "passes/shadow/oblong_shared.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 1) const uint SAMPLES = 1u;
layout(push_constant, scalar) uniform push_block { gpu_shadow_planes_push push; };

// The depth of a pixel; with MSAA, of its first sample.
float depth_at(ivec2 pixel) {
    return SAMPLES > 1u ? texelFetch(textures_multisampled[push.depth], pixel, 0).r : texelFetch(textures[push.depth], pixel, 0).r;
}
// Depths of the work group's pixels and two more on each side; beyond the picture, the depth of its last pixel.
const int SIDE = 12;
shared float depths[SIDE * SIDE];

void find_depths() {
    ivec2 last = ivec2(push.lighting.scope.view.view.size) - 1, first = ivec2(gl_WorkGroupID.xy) * 8 - 2;
    for (int i = int(gl_LocalInvocationIndex); i < SIDE * SIDE; i += 64) depths[i] = depth_at(clamp(first + ivec2(i % SIDE, i / SIDE), ivec2(0), last));
    barrier();
}
float depth_beside(ivec2 pixel) {
    ivec2 at = pixel - ivec2(gl_WorkGroupID.xy) * 8 + 2;
    return depths[at.y * SIDE + at.x];
}
vec3 view_position_at(ivec2 pixel, float depth) {
    view_block v = push.lighting.scope.view;
    return view_position_of(v, ndc_of_pixel(v, vec2(pixel) + 0.5), view_depth_of(v, depth));
}

const float BEND = 2e-6; // fraction of depth by which rounding may bend a plane
const float NONE = 3e38;

// A vector in the plane of a pixel, along an axis of the picture: from one pixel of the plane to another. On a plane,
// depth grows evenly from pixel to pixel. The side that bends less is used, or both if both are flat. 0: there is
// none.
vec3 along_plane(ivec2 pixel, ivec2 axis, float depth) {
    float before = depth_beside(pixel - axis), after = depth_beside(pixel + axis), far_before = depth_beside(pixel - 2 * axis), far_after = depth_beside(pixel + 2 * axis);
    float bend_before = before > 0.0 ? abs(far_before + depth - 2.0 * before) : NONE, bend_after = after > 0.0 ? abs(far_after + depth - 2.0 * after) : NONE;
    ivec2 last = ivec2(push.lighting.scope.view.view.size) - 1, from = pixel, to = pixel;
    int at = axis.x * pixel.x + axis.y * pixel.y, end = axis.x * last.x + axis.y * last.y;
    if (at < 2) bend_before = at < 1 ? NONE : 0.5 * NONE; // there are no depths beyond the picture
    if (at > end - 2) bend_after = at > end - 1 ? NONE : 0.5 * NONE;
    float flat_ = BEND * depth;
    if (bend_before <= flat_ && bend_after <= flat_ && abs(before + after - 2.0 * depth) <= flat_) {
        from = pixel - 2 * axis;
        to = pixel + 2 * axis;
    } else if (bend_before < bend_after) {
        from = pixel - axis;
    } else if (bend_after < NONE) {
        to = pixel + axis;
    }
    return from == to ? vec3(0.0) : view_position_at(to, depth_beside(to)) - view_position_at(from, depth_beside(from));
}

// The normal of the plane, in world space, toward the viewer; 0: not known.
vec3 plane_at(ivec2 pixel, float depth) {
    vec3 across = along_plane(pixel, ivec2(1, 0), depth), down = along_plane(pixel, ivec2(0, 1), depth);
    vec3 normal = cross(down, across); // +Y of the view is up, rows of pixels go down
    float size = length(normal);
    if (!(size > 0.0)) return vec3(0.0);
    return mat3(push.lighting.scope.view.view.view_to_world) * (normal / size);
}

// Adds `pixels` to the count of a page.
void note(uint sun, uint name, uint pixels) {
    uint slot = name * 0x9e3779b9u >> 19;
    for (uint i = 0u; i < 64u; i++) {
        uint at = 2u * (sun * OBLONG_FOUND + (slot + i) % OBLONG_FOUND), found = push.found.at[at];
        if (found == 0u) found = atomicCompSwap(push.found.at[at], 0u, name);
        if (found != 0u && found != name) continue;
        atomicAdd(push.found.at[at + 1u], pixels);
        return;
    }
}

shared uint names[64]; // names of the pages that the work group's pixels need

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    view_block v = push.lighting.scope.view;
    bool is_inside = all(lessThan(uvec2(pixel), v.view.size));
    find_depths();
    float depth = is_inside ? depth_beside(pixel) : 0.0;
    vec3 plane = depth > 0.0 ? plane_at(pixel, depth) : vec3(0.0), position = vec3(0.0);
    bool is_known = plane != vec3(0.0);
    float width = 0.0;
    uint stored = is_known ? packSnorm2x16(octahedral_encode(plane)) | 1u : 0u, thread = gl_LocalInvocationIndex;
    if (is_inside) push.planes.at[uint(pixel.y) * v.view.size.x + uint(pixel.x)] = stored;
    if (is_known) {
        plane = octahedral_decode(unpackSnorm2x16(stored)); // as later passes read it
        position = (v.view.view_to_world * vec4(view_position_at(pixel, depth), 1.0)).xyz;
        width = pixel_width(v, length(v.view.eye - position));
    }
    for (uint i = 0u; i < push.lighting.scope.lights.directional_count; i++) {
        shadow_oblong o;
        o.name = 0u;
        if (is_known && light_casts(lights_of(push.lighting), i)) shadow_oblong_on(push.suns.at[i], v, position, plane, width, o);
        names[thread] = o.name;
        barrier();
        bool is_first = o.name != 0u && (thread % 8u == 0u || names[thread - 1u] != o.name); // first of neighbors in its row that need the same page
        uint end = thread + 1u;
        while (is_first && end % 8u != 0u && names[end] == o.name) end++;
        if (is_first) note(i, o.name, end - thread);
        barrier();
    }
}
