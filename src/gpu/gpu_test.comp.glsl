// SPDX-License-Identifier: MIT
#version 460
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_nonuniform_qualifier : require
#extension GL_EXT_samplerless_texture_functions : require
#extension GL_EXT_shader_image_load_formatted : require
#extension GL_EXT_ray_query : require

layout(local_size_x = 64) in;
layout(constant_id = 0) const uint mode = 0u;
layout(constant_id = 1) const uint factor = 0u;

layout(set = 0, binding = 0) uniform texture2D textures[];
layout(set = 0, binding = 1) uniform sampler samplers[];
layout(set = 0, binding = 2) uniform image2D images[];
layout(buffer_reference, scalar) buffer words { uint at[]; };
layout(buffer_reference, scalar) buffer texels { vec4 at[]; };
layout(push_constant, scalar) uniform push {
    uvec2 from, to;
    uint count, width, lod, image, sampler_index;
    float u, v;
};

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= count) return;
    ivec2 at = ivec2(i % width, i / width);
    if (mode == 0u) words(to).at[i] = words(from).at[i] * factor + 1u;
    if (mode == 1u) texels(to).at[i] = texelFetch(textures[nonuniformEXT(image)], at, int(lod));
    if (mode == 2u) imageStore(images[nonuniformEXT(image)], at, vec4(float(i) / 255.0, 1.0, 0.0, float(factor) / 255.0));
    if (mode == 3u) texels(to).at[i] = textureLod(sampler2D(textures[image], samplers[sampler_index]), vec2(u, v), float(lod));
    if (mode == 5u) { // a ray for each 100 metres along x: how many triangles it meets, and the numbers of the last
        vec4 found = vec4(0.0);
        rayQueryEXT query;
        rayQueryInitializeEXT(query, accelerationStructureEXT(from), gl_RayFlagsNoOpaqueEXT, 0xffu, vec3(0.25 + 100.0 * float(i), 0.25, -1.0), 0.0, vec3(0.0, 0.0, 1.0), u);
        while (rayQueryProceedEXT(query))
            found = vec4(found.x + 1.0, rayQueryGetIntersectionInstanceCustomIndexEXT(query, false), rayQueryGetIntersectionPrimitiveIndexEXT(query, false),
                         rayQueryGetIntersectionTEXT(query, false));
        texels(to).at[i] = found;
    }
    if (mode == 4u) texels(to).at[i] = imageLoad(images[nonuniformEXT(image)], at);
}
