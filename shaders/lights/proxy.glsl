// SPDX-License-Identifier: MIT
// A convex solid with eight corners round each shape: a box whose far four corners may be spread wider than the near four, down to a
// pyramid whose near four meet in the apex (M. Mikkelsen, "Fine Pruned Tiled Light Lists", GPU Pro 7, 2.1). Its twin on the CPU is
// src/passes/lights/light_proxy.c; a test compares them.
#ifndef LIGHTS_PROXY_GLSL
#define LIGHTS_PROXY_GLSL

#include "lights/shapes.glsl"

// Half widths near and far across one axis of a pyramid with this tangent, cut by a sphere round its apex. From 60 degrees on a prism
// as wide as the sphere's part is smaller.
vec2 shape_spread(float range, float tangent) {
    float cosine = inversesqrt(1.0 + tangent * tangent);
    return cosine > 0.5 ? vec2(0.0, range * tangent) : vec2(range * cosine * tangent);
}

// Corners in world space. Bit 0 of the index: across (side), bit 1: up, bit 2: along the direction, far when set. They hold all of
// the shape, not only what its hull leaves of it; where the sphere of its bounds is smaller, that.
void shape_corners(gpu_shape s, vec3 sphere_center, float radius, out vec3 corners[8]) {
    vec3 side = vec3(1.0, 0.0, 0.0), up = vec3(0.0, 1.0, 0.0), along = vec3(0.0, 0.0, 1.0), center = s.position;
    vec2 x = vec2(s.range), y = vec2(s.range), z = vec2(-s.range, s.range); // near and far
    if (s.kind != GPU_SHAPE_SPHERE) {
        side = s.side;
        along = s.direction;
        up = cross(side, along);
    }
    if (s.kind == GPU_SHAPE_CONE) {
        // Rounding of the ramp may light a hair more than the cone.
        float cosine = -s.spot_offset / s.spot_scale - 4e-7, sine = sqrt(max(1.0 - cosine * cosine, 0.0));
        x = cosine > 0.5 ? vec2(0.0, s.range * sine / cosine) : vec2(s.range * sine);
        y = x;
        z = vec2(min(0.0, s.range * cosine), s.range);
    } else if (s.kind == GPU_SHAPE_CAPSULE) {
        x = y = vec2(s.size.y);
        z = vec2(-s.size.x - s.size.y, s.size.x + s.size.y);
    } else if (s.kind == GPU_SHAPE_WEDGE) {
        x = shape_spread(s.range, s.size.x);
        y = shape_spread(s.range, s.size.y);
        z = vec2(0.0, s.range);
    } else if (s.kind >= GPU_SHAPE_BOX) {
        x = vec2(s.size.x);
        y = vec2(s.size.y);
        z = vec2(-s.size.z, s.size.z);
    }
    if (s.hull_count != 0u && 8.0 * radius * radius * radius <
                                      (z.y - z.x) * (x.x + x.y) * (y.x + y.y)) {
        center = sphere_center;
        x = y = vec2(radius);
        z = vec2(-radius, radius);
    }
    float slack = 1e-5 * s.range + 1e-6 * length(center);
    z += vec2(-slack, slack);
    x = x * (1.0 + 1e-5) + slack;
    y = y * (1.0 + 1e-5) + slack;
    for (uint i = 0u; i < 8u; i++) {
        bool far = (i & 4u) != 0u;
        vec2 half_size = far ? vec2(x.y, y.y) : vec2(x.x, y.x);
        corners[i] = center + side * ((i & 1u) != 0u ? half_size.x : -half_size.x) + up * ((i & 2u) != 0u ? half_size.y : -half_size.y) +
                     along * (far ? z.y : z.x);
    }
}

#endif
