#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Objects that moved. Places are computed as geometry.vert.glsl does, so that depths are equal to the bit.
#include "passes/aa/motion.glsl"

layout(push_constant, scalar) uniform push_block { gpu_motion_objects_push push; };

layout(location = 0) out vec3 out_previous; // in the last frame's view space
layout(location = 1) flat out uint out_new; // 1: the last frame did not draw it

invariant gl_Position;

void main() {
    scene_block scene = push.geometry.scene;
    gpu_item item = scene.scene.items.at[push.geometry.visible.at[gl_InstanceIndex]];
    gpu_instance instance = scene.scene.instances.at[item.instance], before = instance;
    vec3 point = scene.scene.positions.at[gl_VertexIndex], point_before = point;
    bool known = item.instance < push.instance_count;
    if (known) before = push.instances.at[item.instance];
    out_new = uint(!known || (before.rows[0] == vec4(0.0) && before.rows[1] == vec4(0.0) && before.rows[2] == vec4(0.0)));
    uint deformed = uint(gl_VertexIndex) - push.first_deformed; // a large number where the vertex comes before
    bool deforms = deformed < push.deformed_count && scene.scene.primitives.at[item.primitive].bind_offset != 0;
    if (deforms && out_new == 0u) point_before = push.positions.at[deformed]; // of a new one nobody has written them

    precise vec3 position = transform_point(instance, point);
    precise vec4 clip = push.geometry.view.view.world_to_clip * vec4(position, 1.0);
    gl_Position = clip;
    gl_PointSize = 1.0;
    vec3 moved = push.motion.motion.origin_moved;
    vec3 was = out_new == 1u ? position : transform_point(before, point_before) - moved; // new objects have not moved
    out_previous = (push.motion.motion.previous.world_to_view * vec4(was, 1.0)).xyz;
    // Triangles of what is at rest fall together before the near plane.
    if (out_new == 0u && !deforms && moved == vec3(0.0) && instance.rows == before.rows) gl_Position = vec4(0.0, 0.0, 2.0, 1.0);
}
