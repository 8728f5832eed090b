// SPDX-License-Identifier: MIT
#version 460
#extension GL_EXT_nonuniform_qualifier : require
#extension GL_EXT_samplerless_texture_functions : require

layout(constant_id = 0) const uint mode = 0u;
layout(set = 0, binding = 0) uniform texture2D textures[];
layout(push_constant) uniform push { uint first, second; };
layout(location = 0) out vec4 target;

void main() {
    ivec2 p = ivec2(gl_FragCoord.xy);
    target = texelFetch(textures[first], p, 0) + 0.5;
    if (mode == 1u) target += texelFetch(textures[second], p, 0);
}
