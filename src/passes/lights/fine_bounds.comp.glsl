#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Tight bounds on the screen and in depth for each light in view (M. Mikkelsen, "Fine Pruned Tiled Light Lists", GPU Pro 7, 2.1): the
// corners of its proxy clipped against the view, and the corners of the view inside the proxy, cut with the bounds of its sphere.
#include "common.glsl"
#include "passes/lights/fine_steps.glsl"
#include "lights/proxy.glsl"

layout(local_size_x = 64) in;

const uint SIDES[24] = uint[](0u, 1u, 3u, 2u, 4u, 5u, 7u, 6u, 0u, 1u, 5u, 4u, 2u, 3u, 7u, 6u, 0u, 2u, 6u, 4u, 1u, 3u, 7u, 5u);

// Grows over what is seen: x and y in normalised device coordinates, view depth.
vec3 low, high;

void extend(vec3 p, float slack) {
    float depth = max(-p.z, push.view.view.near_distance);
    float spread = push.view.view.orthographic > 0.5 ? 1.0 : depth;
    vec2 ndc = (p.xy / spread - push.view.view.ndc_offset) / push.view.view.ndc_scale;
    vec2 margin = abs(slack / (spread * push.view.view.ndc_scale));
    low = min(low, vec3(ndc - margin, depth - slack));
    high = max(high, vec3(ndc + margin, depth + slack));
}

// ---- the sphere ----

// Where a disc of the plane (x, view depth) beyond the near plane is seen: least and greatest x, divided by the depth. The extremes are the
// tangents' points, or where those are too near, those of the circle on the near plane (Mara & McGuire 2013).
vec2 disc_slopes(float x, float depth, float radius, float near) {
    vec2 slopes = vec2(FINE_FAR, -FINE_FAR);
    float to_near = near - depth, half2 = radius * radius - to_near * to_near, distance2 = x * x + depth * depth;
    if (half2 >= 0.0) slopes = vec2(x - sqrt(half2), x + sqrt(half2)) / near;
    float tangent2 = distance2 - radius * radius;
    if (tangent2 > 0.0) {
        float t = sqrt(tangent2);
        vec2 a = vec2(t * x - radius * depth, t * depth + radius * x), b = vec2(t * x + radius * depth, t * depth - radius * x);
        if (a.y * t >= near * distance2) slopes = vec2(min(slopes.x, a.x / a.y), max(slopes.y, a.x / a.y));
        if (b.y * t >= near * distance2) slopes = vec2(min(slopes.x, b.x / b.y), max(slopes.y, b.x / b.y));
    }
    return slopes.x <= slopes.y ? slopes : vec2(-FINE_FAR, FINE_FAR);
}

void extend_by_sphere(gpu_bound bound) {
    float radius = bound.radius * (1.0 + CELL_SLACK) + CELL_SLACK * (1e-2 + length(bound.center) * 1e-2);
    float depth = -bound.center.z, near = push.view.view.near_distance;
    low.z = max(depth - radius, near);
    high.z = depth + radius;
    vec2 x = bound.center.x + vec2(-radius, radius), y = bound.center.y + vec2(-radius, radius);
    if (push.view.view.orthographic < 0.5) {
        x = disc_slopes(bound.center.x, depth, radius, near);
        y = disc_slopes(bound.center.y, depth, radius, near);
    }
    x = (x - push.view.view.ndc_offset.x) / push.view.view.ndc_scale.x;
    y = (y - push.view.view.ndc_offset.y) / push.view.view.ndc_scale.y;
    low.xy = vec2(min(x.x, x.y), min(y.x, y.y));
    high.xy = vec2(max(x.x, x.y), max(y.x, y.y));
}

// ---- the proxy ----

shared vec4 planes[5]; // of the view, in view space; inside is dot(plane, (p, 1)) >= 0
vec3 corners[8];
bool proxy_known = true;

// A side of the proxy, clipped (Sutherland & Hodgman 1974) in place: of a convex polygon no more is kept than was read, and the corner that is
// read ahead. Where rounding makes it another one, the proxy says nothing.
void extend_by_side(uint side, float slack) {
    vec3 polygon[9];
    uint count = 4u;
    for (uint i = 0u; i < 4u; i++) polygon[i] = corners[SIDES[side * 4u + i]];
    for (uint k = 0u; k < 5u && count > 0u; k++) {
        vec4 plane = planes[k] + vec4(0.0, 0.0, 0.0, slack);
        uint kept = 0u;
        vec3 before = polygon[count - 1u], next = polygon[0];
        float inside_before = dot(plane.xyz, before) + plane.w;
        for (uint i = 0u; i < count; i++) {
            vec3 at = next;
            next = polygon[min(i + 1u, 8u)];
            float inside = dot(plane.xyz, at) + plane.w;
            if ((inside >= 0.0) != (inside_before >= 0.0) && kept < 9u)
                polygon[kept++] = mix(before, at, inside_before / (inside_before - inside));
            if (inside >= 0.0 && kept < 9u) polygon[kept++] = at;
            if (kept > i + 2u && i + 2u < count) proxy_known = false;
            before = at;
            inside_before = inside;
        }
        count = kept;
    }
    for (uint i = 0u; i < count; i++) extend(polygon[i], slack);
}

// Whether the proxy holds a point; sides without area say nothing.
bool proxy_holds(vec3 point, vec3 center, float size) {
    for (uint side = 0u; side < 6u; side++) {
        vec3 a = corners[SIDES[side * 4u]], c = corners[SIDES[side * 4u + 2u]];
        vec3 normal = cross(c - a, corners[SIDES[side * 4u + 3u]] - corners[SIDES[side * 4u + 1u]]);
        float area = length(normal), toward = dot(normal, center - a) < 0.0 ? 1.0 : -1.0;
        if (area < 1e-6 * size * size) continue;
        if (toward * dot(normal, point - a) > 1e-4 * size * area) return false;
    }
    return true;
}

void extend_by_proxy(gpu_shape shape, gpu_entity_bounds entity) {
    vec3 world[8];
    shape_corners(shape, entity.center, entity.radius, world);
    vec3 center = vec3(0.0);
    float size = 0.0, extent = 0.0;
    for (uint i = 0u; i < 8u; i++) {
        corners[i] = (push.view.view.world_to_view * vec4(world[i], 1.0)).xyz;
        center += corners[i] * 0.125;
        extent = max(extent, length(corners[i]) + length(world[i]));
    }
    for (uint i = 0u; i < 8u; i++) size = max(size, distance(corners[i], center));
    float slack = 1e-6 * extent + 4e-7 * length(push.view.view.eye);

    float near = push.view.view.near_distance;
    bool all_inside = true;
    for (uint k = 0u; k < 5u; k++)
        for (uint i = 0u; i < 8u; i++) all_inside = all_inside && dot(planes[k].xyz, corners[i]) + (planes[k].w + slack) >= 0.0;
    if (all_inside) {
        for (uint i = 0u; i < 8u; i++) extend(corners[i], slack);
        return;
    }
    for (uint side = 0u; side < 6u; side++) extend_by_side(side, slack);
    for (uint i = 0u; i < 4u; i++) {
        vec3 corner = view_position_of(push.view, vec2((i & 1u) != 0u ? 1.0 : -1.0, (i & 2u) != 0u ? 1.0 : -1.0), near);
        if (proxy_holds(corner, center, size)) extend(corner, slack);
    }
}

void store_volume(uint index, gpu_entity_bounds entity, gpu_shape shape) {
    gpu_fine_volume v;
    v.position = v.center = entity.center;
    v.range = v.radius = entity.radius;
    v.kind = GPU_SHAPE_SPHERE;
    v.direction = vec3(0.0);
    v.spot_scale = v.spot_offset = 0.0;
    v.shape = entity.shape;
    if (v.shape != GPU_NO_SHAPE) {
        v.position = shape.position;
        v.range = shape.range;
        v.kind = shape.kind | (LIGHTING_SIMPLE ? 0u : shape.hull_count << 8u);
        v.direction = shape.direction;
        v.spot_scale = shape.spot_scale;
        v.spot_offset = shape.spot_offset;
    }
    fine_volume_array(push.extra).at[index] = v;
}

void main() {
    if (gl_LocalInvocationIndex == 0u) {
    float near = push.view.view.near_distance;
    gpu_cell_bounds view = cell_bounds(push.view, vec2(-1.0), vec2(1.0), near, near * 2.0);
    for (uint k = 0u; k < 4u; k++) planes[k] = view.planes[k];
    planes[4] = vec4(0.0, 0.0, -1.0, -near);
    }
    barrier();
    uint index = LINEAR_INVOCATION, light_count = push.list.list.local_count;
    if (index >= push.visible_sums.at[light_count]) return;
    gpu_entity_bounds entity = push.list.list.lights.set.entities.at[push.visible_ids.at[index]];
    gpu_shape shape = shape_of(set_of(push.list), entity);
    store_volume(index, entity, shape); // first: what it needs is not kept in registers
    gpu_bound bound = push.bounds.at[index];
    low = vec3(FINE_FAR);
    high = vec3(-FINE_FAR);
    if (shape.kind != GPU_SHAPE_SPHERE) extend_by_proxy(shape, entity);
    vec3 proxy_low = low, proxy_high = high;
    extend_by_sphere(bound);
    if (shape.kind != GPU_SHAPE_SPHERE && proxy_known) {
        low = max(low, proxy_low);
        high = min(high, proxy_high);
    }
    gpu_fine_box box;
    box.kind = entity.kind;
    // Broken numbers are seen everywhere.
    vec4 pair = vec4(bound.center, bound.radius);
    if (any(isnan(pair)) || any(isinf(pair)) || any(isnan(low)) || any(isnan(high))) {
        low = vec3(-1.0, -1.0, 0.0);
        high = vec3(1.0, 1.0, FINE_FAR);
    }
    vec2 size = vec2(push.view.view.size);
    vec2 top_left = (vec2(low.x, -high.y) * 0.5 + 0.5) * size - 0.01, bottom_right = (vec2(high.x, -low.y) * 0.5 + 0.5) * size + 0.01;
    box.rect = vec4(max(top_left, vec2(0.0)), min(bottom_right, size));
    if (any(greaterThan(box.rect.xy, box.rect.zw)) || low.z > high.z) box.rect = vec4(1.0, 1.0, -1.0, -1.0);
    box.depth = vec2(low.z * (1.0 - CELL_SLACK), high.z * (1.0 + CELL_SLACK));
    push.boxes.at[index] = box;
}
