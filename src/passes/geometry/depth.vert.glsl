#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Vertices for depth alone. Depth is that of geometry.vert.glsl, to the bit.
#include "common.glsl"
#include "scene.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"
#include "passes/geometry/layered.glsl"

invariant gl_Position;

void main() {
    gpu_item item = push.scene.scene.items.at[push.visible.at[drawn_instance()]];
    gpu_instance instance = push.scene.scene.instances.at[item.instance];
    precise vec3 position = transform_point(instance, push.scene.scene.positions.at[gl_VertexIndex]);
    precise vec4 clip = DRAWN_VIEW(push.view).view.world_to_clip * vec4(position, 1.0);
    gl_Position = clip;
    gl_PointSize = 1.0;
#ifdef LAYERED
    gl_Layer = int(drawn_layer());
#endif
}
