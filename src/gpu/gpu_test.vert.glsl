// SPDX-License-Identifier: MIT
#version 460
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
#extension GL_EXT_scalar_block_layout : require

struct vertex { vec4 position, color; };
layout(buffer_reference, scalar) buffer vertices { vertex at[]; };
layout(push_constant, scalar) uniform push { uvec2 address; };
layout(location = 0) out vec4 color;

void main() {
    vertex v = vertices(address).at[gl_VertexIndex];
    gl_Position = v.position;
    color = v.color;
}
