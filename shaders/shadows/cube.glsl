// SPDX-License-Identifier: MIT
// Cube maps and boxes: faces in Vulkan's order and orientation, and where rays leave a box.
#ifndef SHADOWS_CUBE_GLSL
#define SHADOWS_CUBE_GLSL

// The direction of a place on a face, -1 .. 1 from the left and from the top; its greatest component is 1.
vec3 cube_direction(uint face, vec2 at) {
    if (face == 0u) return vec3(1.0, -at.y, -at.x);
    if (face == 1u) return vec3(-1.0, -at.y, at.x);
    if (face == 2u) return vec3(at.x, 1.0, at.y);
    if (face == 3u) return vec3(at.x, -1.0, -at.y);
    return face == 4u ? vec3(at.x, -at.y, 1.0) : vec3(-at.x, -at.y, -1.0);
}

// The face that a direction meets, and where.
uint cube_face(vec3 d, out vec2 at) {
    vec3 size = abs(d);
    if (size.x >= size.y && size.x >= size.z) {
        at = vec2(d.x > 0.0 ? -d.z : d.z, -d.y) / size.x;
        return d.x > 0.0 ? 0u : 1u;
    }
    if (size.y >= size.z) {
        at = vec2(d.x, d.y > 0.0 ? d.z : -d.z) / size.y;
        return d.y > 0.0 ? 2u : 3u;
    }
    at = vec2(d.z > 0.0 ? d.x : -d.x, -d.y) / size.z;
    return d.z > 0.0 ? 4u : 5u;
}

// Metres from a point in a box round the origin along a unit vector to where it leaves it. Along a face, too: components that are zero leave nowhere,
// and 0 / 0 is not looked at. Negative where the point is beyond the face that it is heading for.
float box_exit(vec3 from, vec3 along, vec3 half_size) {
    vec3 face = mix(-half_size, half_size, greaterThan(along, vec3(0.0)));
    vec3 t = mix((face - from) / along, vec3(1e30), lessThan(abs(along), vec3(1e-30)));
    return min(t.x, min(t.y, t.z));
}

#endif
