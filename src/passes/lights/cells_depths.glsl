// SPDX-License-Identifier: MIT
// View depths inside of a cell: which of its depth cells a light touches, and between which depths a light is in it at all.
#ifndef CELLS_DEPTHS_GLSL
#define CELLS_DEPTHS_GLSL

#include "passes/lights/cells.glsl"
#include "lights/ranges.glsl"

// ---- masks of 32 depth cells: depth_cell() ----

uint cell_light_mask(gpu_cell_bounds b, gpu_bound light) {
    float radius = cell_radius(light), near = -light.center.z - radius, far = -light.center.z + radius;
    if (!(near <= far)) return 0xffffffffu;
    uint first = depth_cell(b, near), last = depth_cell(b, far);
    return (0xffffffffu >> (31u - (last - first))) << first;
}

// ---- depth ranges of lights ----

bool inside_sides(gpu_cell_bounds b, vec3 p, float slack) {
    for (int i = 0; i < 4; i++)
        if (dot(b.planes[i].xyz, p) + b.planes[i].w < -slack) return false;
    return true;
}

// Least and greatest view depth of what of a sphere lies between the side planes of a cell; false: none does. Each is taken at one of
// these: the sphere's own nearest or farthest point, that of its cut with a plane, a point on the ray of a corner, the eye.
bool cell_sphere_depths(gpu_cell_bounds b, gpu_bound light, out vec2 depths) {
    float radius = cell_radius(light), slack = radius - light.radius;
    vec3 center = light.center;
    depths = vec2(1e30, -1e30);
    for (int end = 0; end < 2; end++) {
        vec3 away = vec3(0.0, 0.0, end == 0 ? 1.0 : -1.0); // to the nearest, to the farthest
        vec3 p = center + radius * away;
        if (inside_sides(b, p, slack)) {
            depths = vec2(min(depths.x, -p.z), max(depths.y, -p.z));
            continue;
        }
        for (int i = 0; i < 4; i++) {
            vec3 normal = b.planes[i].xyz;
            float distance = dot(normal, center) + b.planes[i].w, cut2 = radius * radius - distance * distance;
            vec3 along = away - dot(away, normal) * normal;
            float along2 = dot(along, along);
            if (cut2 < 0.0 || !(along2 > 0.0)) continue;
            p = center - distance * normal + sqrt(cut2 / along2) * along;
            if (inside_sides(b, p, slack)) depths = vec2(min(depths.x, -p.z), max(depths.y, -p.z));
        }
    }
    for (int corner = 0; corner < 4; corner++) {
        vec2 x = cell_side(b, corner & 1), y = cell_side(b, 2 + (corner >> 1));
        vec3 ray = vec3(x.x, y.x, -1.0), from = vec3(x.y, y.y, 0.0) - center; // parameter: view depth
        float length2 = dot(ray, ray), middle = -dot(from, ray) / length2;
        vec3 nearest = from + middle * ray;
        float rest2 = radius * radius - dot(nearest, nearest);
        if (rest2 < 0.0) continue;
        float half_length = sqrt(rest2 / length2);
        depths = vec2(min(depths.x, middle - half_length), max(depths.y, middle + half_length));
    }
    if (b.planes[0].w == 0.0 && b.planes[2].w == 0.0 && dot(center, center) < radius * radius) depths = vec2(min(depths.x, 0.0), max(depths.y, 0.0));
    bool broken = !(radius < 1e30) || isnan(center.x + center.y + center.z);
    if (broken) depths = vec2(0.0, 1e30);
    return depths.y >= 0.0 && depths.x <= depths.y;
}

// Cuts a range to the depths of the light's cone; false: nothing is left.
bool cone_depths(gpu_reach r, inout vec2 depths) {
    if (!(r.range > 0.0)) return true;
    float near = -cone_farthest(r, vec3(0.0, 0.0, 1.0)).z - r.slack, far = -cone_farthest(r, vec3(0.0, 0.0, -1.0)).z + r.slack;
    if (near > depths.x) depths.x = near;
    if (far < depths.y) depths.y = far;
    return !(depths.x > depths.y);
}

#endif
