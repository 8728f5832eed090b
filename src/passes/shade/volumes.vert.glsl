#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Solids that hold all that a light lights. They are drawn by their back faces where those are not in front of what is seen, so the
// viewer may stand inside.
#include "common.glsl"
#include "passes/shade/volumes.glsl"

layout(push_constant, scalar) uniform push_block { gpu_volume_push push; };

layout(location = 0) flat out uint out_light;

// Metres that a pixel is wide at a point: what rasterisation may lose at the edge of a solid.
float pixel_size(vec3 position) {
    view_block v = push.view;
    float view_depth = v.view.orthographic > 0.5 ? 1.0 : abs((v.view.world_to_view * vec4(position, 1.0)).z);
    vec2 size = 2.0 * abs(v.view.ndc_scale) * v.view.inverse_size * view_depth;
    return max(size.x, size.y);
}

void main() {
    uint id = push.ids.at[gl_InstanceIndex], vertex = uint(gl_VertexIndex);
    gpu_light light = push.list.list.lights.at[push.list.list.directional_count + id];
    out_light = id;
    vec3 position;
    if (vertex < VOLUME_SPHERE_VERTICES) {
        vec3 center = light.bound_center;
        float radius = light.bound_radius;
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
        return;
    }
    vertex -= VOLUME_SPHERE_VERTICES;
    bool far = vertex >= VOLUME_RING;
    float angle = float(vertex % VOLUME_RING) * (2.0 * PI / float(VOLUME_RING));
    float cosine = volume_cosine(light), tangent = sqrt(max(1.0 - cosine * cosine, 0.0)) / cosine;
    float slack = 1e-3 * light.range + pixel_size(light.bound_center) + 1e-6 * length(light.position);
    float along = far ? light.range + slack : -slack;
    float across = ((far ? along * tangent : 0.0) + 2.0 * slack) / VOLUME_CONE_INSIDE;
    vec3 up = cross(light.side, light.direction);
    position = light.position + light.direction * along + (light.side * cos(angle) + up * sin(angle)) * across;
    gl_Position = push.view.view.world_to_clip * vec4(position, 1.0);
}
