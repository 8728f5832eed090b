// SPDX-License-Identifier: MIT
#version 460
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_nonuniform_qualifier : require
#extension GL_EXT_samplerless_texture_functions : require
#extension GL_EXT_shader_image_load_formatted : require

layout(local_size_x = 64) in;
layout(constant_id = 0) const uint mode = 0u;

layout(set = 0, binding = 0) uniform texture2D textures[];
layout(set = 0, binding = 2) uniform image2D images[];
layout(buffer_reference, scalar) buffer floats { float at[]; };
layout(push_constant, scalar) uniform push {
    uvec2 from, to;
    uint from_image, to_image, width, count;
    float value;
};

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= count) return;
    ivec2 p = ivec2(i % width, i / width);
    if (mode == 0u) floats(to).at[i] = float(i) + value;
    if (mode == 1u) imageStore(images[to_image], p, vec4(floats(from).at[i]));
    if (mode == 2u) imageStore(images[to_image], p, texelFetch(textures[from_image], p, 0) * 2.0 + value);
    if (mode == 3u) floats(to).at[i] = texelFetch(textures[from_image], p, 0).r;
    if (mode == 4u) imageStore(images[to_image], p, imageLoad(images[to_image], p) + value);
}
