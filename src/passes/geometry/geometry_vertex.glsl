// SPDX-License-Identifier: MIT
// A vertex of an item as everything that draws the scene has it: vertex and mesh shaders compute it alike, so that pictures are equal to
// the bit. `push` is gpu_geometry_push.
#ifndef GEOMETRY_VERTEX_GLSL
#define GEOMETRY_VERTEX_GLSL

layout(constant_id = FEATURES_ID) const uint FEATURES = 0u; // GPU_FEATURE_…

struct geometry_vertex {
    vec4 clip;
    vec3 position;
    vec3 normal;
    vec4 tangent;
    vec4 uv; // uv0, uv1
    vec4 color;
    uvec3 ids; // material, item; 1: the instance mirrors, 2: not a triangle
    vec3 bind; // position before the mesh deforms, in its own space
};

vec3 unit(vec3 v) { return v * inversesqrt(max(dot(v, v), 1e-37)); }

geometry_vertex geometry_vertex_of(uint item_index, uint vertex) {
    geometry_vertex v;
    gpu_item item = push.scene.scene.items.at[item_index];
    gpu_instance instance = push.scene.scene.instances.at[item.instance];
    gpu_attributes a = push.scene.scene.attributes.at[vertex];

    precise vec3 position = transform_point(instance, push.scene.scene.positions.at[vertex]);
    precise vec4 clip = DRAWN_VIEW(push.view).view.world_to_clip * vec4(position, 1.0);
    v.clip = clip;

    float mirror;
    v.position = position;
    // Unit vectors, so that a scaled instance keeps the proportions of its tangent space.
    v.normal = unit(transform_normal(instance, unpack_normal(a.normal), mirror));
    vec4 tangent = unpack_tangent(a.tangent);
    v.tangent = vec4(unit(transform_direction(instance, tangent.xyz)), tangent.w * mirror);
    v.uv = vec4(a.uv0, a.uv1);
    v.color = vec4(unpackUnorm2x16(a.color.x), unpackUnorm2x16(a.color.y));
    gpu_primitive primitive = push.scene.scene.primitives.at[item.primitive];
    v.bind = vec3(0.0);
    if ((FEATURES & GPU_FEATURE_MESH_DECALS) != 0u) v.bind = push.scene.scene.positions.at[int(vertex) + primitive.bind_offset];
    v.ids = uvec3(primitive.material, item_index, primitive.corners != 3u ? 2u : uint(mirror < 0.0));
    return v;
}

#endif
