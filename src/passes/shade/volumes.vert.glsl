#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Solids that hold all that a light lights. They are drawn by their back faces where those are not in front of what is seen, so the
// viewer may stand inside. Or the rectangle of the light on the screen, drawn at the light's nearest depth where no surface is nearer.
#include "common.glsl"
#include "passes/shade/volumes.glsl"
#include "passes/lights/cells.glsl"

layout(constant_id = VOLUME_FRONTS_ID) const uint FRONTS = 0u; // 1: the draw looks for front faces behind the surface

layout(push_constant, scalar) uniform push_block { gpu_volume_head push; };

layout(location = 0) flat out uint out_light;
layout(location = 2) flat out uint out_rank; // place of the light among those drawn
layout(location = 1) flat out vec2 out_depths; // view depths that the light lies between

// Metres that a pixel is wide at a point: what rasterisation may lose at the edge of a solid.
float pixel_size(vec3 position) {
    view_block v = push.view;
    float view_depth = v.view.orthographic > 0.5 ? 1.0 : abs((v.view.world_to_view * vec4(position, 1.0)).z);
    vec2 size = 2.0 * abs(v.view.ndc_scale) * v.view.inverse_size * view_depth;
    return max(size.x, size.y);
}

// Corner 0 .. 3 of the rectangle that holds the projection of the light's bounding sphere beyond the near plane, and lies there where the
// sphere reaches through it: for a viewer inside, before the whole screen. So does that of a sphere without end or not even a number.
vec4 quad_corner(gpu_entity_bounds light, uint corner) {
    view_block v = push.view;
    vec2 at = vec2(corner & 1u, corner >> 1) * 2.0 - 1.0;
    vec3 center = (v.view.world_to_view * vec4(light.center, 1.0)).xyz;
    float radius = cell_radius(gpu_bound(center, light.radius)) +
                   float(BOUND_ROUNDING) * (length(light.center) + length(v.view.eye));
    bool flat_view = v.view.orthographic > 0.5;
    if (!(radius + length(center) < 1e8)) return vec4(at, 1.0, 1.0);
    vec2 x = center.x + vec2(-radius, radius), y = center.y + vec2(-radius, radius);
    if (!flat_view) {
        x = disk_slopes(vec2(center.x, -center.z), radius, v.view.near_distance);
        y = disk_slopes(vec2(center.y, -center.z), radius, v.view.near_distance);
    }
    // Rasterisation rounds corners to a part of a pixel.
    vec2 low = (vec2(x.x, y.x) - v.view.ndc_offset) / v.view.ndc_scale - 0.125 * v.view.inverse_size;
    vec2 high = (vec2(x.y, y.y) - v.view.ndc_offset) / v.view.ndc_scale + 0.125 * v.view.inverse_size;
    float depth = 1.0, nearest = -center.z - radius;
    if (nearest > v.view.near_distance) {
        vec4 clip = v.view.view_to_clip * vec4(0.0, 0.0, -nearest, 1.0);
        depth = clip.z / clip.w * (1.0 + 1e-6) + (flat_view ? 4e-7 : 0.0);
    }
    return vec4(clamp(mix(low, high, at * 0.5 + 0.5), -1.5, 1.5), clamp(depth, 0.0, 1.0), 1.0);
}

// Furthest point of the light's sphere, beyond the near plane, in a direction of the plane at view depth 1: x and y over depth.
float farthest_slope(vec3 center, float radius, vec2 direction) {
    float along = dot(center.xy, direction);
    if (push.view.view.orthographic > 0.5) return along + radius;
    return disk_slopes(vec2(along, -center.z), radius, push.view.view.near_distance).y;
}

// Corner 0 .. 7 of the octagon whose sides touch that ellipse (Mara & McGuire 2013), or, where the sphere reaches through the near plane,
// a corner of the rectangle.
vec4 octagon_corner(gpu_entity_bounds light, uint corner) {
    view_block v = push.view;
    vec4 flat_corner = quad_corner(light, uint[4](0u, 1u, 3u, 2u)[corner >> 1]);
    vec3 center = (v.view.world_to_view * vec4(light.center, 1.0)).xyz;
    float radius = cell_radius(gpu_bound(center, light.radius)) +
                   float(BOUND_ROUNDING) * (length(light.center) + length(v.view.eye));
    if (!(-center.z - radius > v.view.near_distance) || !(radius + length(center) < 1e8)) return flat_corner;
    float angle = float(corner) * (0.25 * PI);
    vec2 a = vec2(cos(angle), sin(angle)), b = vec2(cos(angle + 0.25 * PI), sin(angle + 0.25 * PI));
    vec2 slack = 0.125 * abs(v.view.ndc_scale) * v.view.inverse_size; // as that of the rectangle
    vec2 reach = vec2(farthest_slope(center, radius, a) + dot(abs(a), slack), farthest_slope(center, radius, b) + dot(abs(b), slack));
    // Where dot(a, p) = reach.x and dot(b, p) = reach.y
    vec2 p = vec2(reach.x * b.y - reach.y * a.y, reach.y * a.x - reach.x * b.x) / (a.x * b.y - a.y * b.x);
    return vec4((p - v.view.ndc_offset) / v.view.ndc_scale, flat_corner.z, 1.0);
}

vec2 depths_of(gpu_entity_bounds light) {
    view_block v = push.view;
    float depth = -(v.view.world_to_view * vec4(light.center, 1.0)).z;
    float radius = light.radius * (1.0 + CELL_SLACK) +
                   4.0 * float(BOUND_ROUNDING) * (length(light.center) + length(v.view.eye)) + 1e-5 * abs(depth);
    if (!(radius + abs(depth) < 1e8)) return vec2(-3e38, 3e38);
    // Depths of surfaces come from a stored depth, whose steps grow with distance.
    return vec2((depth - radius) * (depth > radius ? 1.0 - CELL_SLACK : 1.0), (depth + radius) * (1.0 + CELL_SLACK));
}

void main() {
    uint id = push.ids.at[gl_InstanceIndex], vertex = uint(gl_VertexIndex);
    gpu_entity_bounds light = push.lighting.scope.lights.entities.at[id];
    out_light = id;
    out_rank = gl_InstanceIndex;
    out_depths = depths_of(light);
    if (vertex >= VOLUME_SCREEN_VERTEX) {
        gl_Position = vec4(vec2(vertex - VOLUME_SCREEN_VERTEX & 1u, vertex - VOLUME_SCREEN_VERTEX >> 1) * 4.0 - 1.0, 1.0, 1.0);
        return;
    }
    if (vertex >= VOLUME_OCTAGON_VERTEX) {
        gl_Position = octagon_corner(light, vertex - VOLUME_OCTAGON_VERTEX);
        return;
    }
    if (vertex >= VOLUME_QUAD_VERTEX) {
        gl_Position = quad_corner(light, vertex - VOLUME_QUAD_VERTEX);
        return;
    }
    vec3 position;
    if (vertex < VOLUME_SPHERE_VERTICES) {
        vec3 center = light.center;
        float radius = light.radius;
        // What has no end, or is not even a number, is drawn everywhere.
        bool everywhere = !(radius + length(center) < 1e8);
        if (everywhere) {
            center = push.view.view.eye;
            radius = 1e4;
        }
        ivec2 corner = ivec2(vertex % (VOLUME_SIDE + 1u), vertex / (VOLUME_SIDE + 1u)) * 2 - int(VOLUME_SIDE);
        vec3 direction = octahedral_decode(vec2(corner) / float(VOLUME_SIDE));
        float slack = everywhere ? 0.0 : 1e-3 * radius + pixel_size(center) + 1e-6 * length(center);
        position = center + direction * ((radius + slack) / VOLUME_SPHERE_INSIDE);
        gl_Position = push.view.view.world_to_clip * vec4(position, 1.0);
        if (everywhere) gl_Position.z = 0.0; // behind all that is seen
        if (everywhere && FRONTS == 1u) gl_Position = vec4(0.0, 0.0, 0.0, 1.0); // and has no front
        return;
    }
    vertex -= VOLUME_SPHERE_VERTICES;
    bool far = vertex >= VOLUME_RING;
    float angle = float(vertex % VOLUME_RING) * (2.0 * PI / float(VOLUME_RING));
    gpu_shape shape = shape_of(lights_of(push.lighting), light);
    float cosine = volume_cosine(shape), tangent = sqrt(max(1.0 - cosine * cosine, 0.0)) / cosine;
    float slack = 1e-3 * shape.range + pixel_size(light.center) + 1e-6 * length(shape.position);
    float along = far ? shape.range + slack : -slack;
    float across = ((far ? along * tangent : 0.0) + 2.0 * slack) / VOLUME_CONE_INSIDE;
    vec3 up = cross(shape.side, shape.direction);
    position = shape.position + shape.direction * along + (shape.side * cos(angle) + up * sin(angle)) * across;
    gl_Position = push.view.view.world_to_clip * vec4(position, 1.0);
}
