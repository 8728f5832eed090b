// SPDX-License-Identifier: MIT
// Shadow rays through the trees of rays_shared.h, in every shader stage and without support of the device. The walk goes from left to right and
// needs no stack (the ropes of Popov et al. 2007, "Stackless KD-Tree Traversal for High Performance GPU Ray Tracing", on a tree of boxes).
#ifndef SHADOWS_RAYS_GLSL
#define SHADOWS_RAYS_GLSL

#extension GL_EXT_buffer_reference_uvec2 : require

#include "scene.glsl"

layout(buffer_reference) buffer ray_node_array;
layout(buffer_reference) buffer ray_mesh_array;
layout(buffer_reference) buffer ray_item_array;
layout(buffer_reference) buffer ray_box_array;

#include "shadows/rays_shared.h"

#ifndef RAY_NODE_ACCESS
#define RAY_NODE_ACCESS readonly
#endif

layout(buffer_reference, scalar, buffer_reference_align = 4) RAY_NODE_ACCESS buffer ray_node_array { gpu_ray_node at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ray_mesh_array { gpu_ray_mesh at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer ray_item_array { gpu_ray_item at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer ray_box_array { gpu_ray_box at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer rays_block { gpu_rays rays; };

struct shadow_ray {
    vec3 origin, direction, inverse; // in the space that is walked; the direction's length is that of a metre of the world's
    float high;                      // where it ends, metres
};

shadow_ray shadow_ray_make(vec3 origin, vec3 direction, float high) {
    vec3 safe = mix(direction, vec3(1e-20), lessThan(abs(direction), vec3(1e-20)));
    return shadow_ray(origin, direction, 1.0 / safe, high);
}

bool ray_meets_box(shadow_ray r, vec3 low, vec3 high) {
    vec3 a = (low - r.origin) * r.inverse, b = (high - r.origin) * r.inverse, near = min(a, b), far = max(a, b);
    float begin = max(max(near.x, near.y), max(near.z, 0.0)), end = min(min(far.x, far.y), min(far.z, r.high));
    return begin <= end * 1.00001; // what rounds does not let rays slip through flat boxes
}

uvec3 ray_corners(rays_block b, gpu_ray_mesh mesh, uint primitive, uint triangle) {
    uint at = b.rays.scene.scene.primitives.at[primitive].first_index + 3u * (triangle - mesh.first);
    uint offset = uint(b.rays.scene.scene.primitives.at[primitive].vertex_offset);
    return uvec3(b.rays.indices.at[at], b.rays.indices.at[at + 1u], b.rays.indices.at[at + 2u]) + offset;
}

// Which items a ray meets: all; what does not move only so far; or what does not move alone.
const uint RAY_EVERYTHING = 0u, RAY_SOME = 1u, RAY_STILL = 2u;
struct ray_scope {
    uint kind;
    float high;              // RAY_SOME: metres up to which it meets what does not move
    const_uint_array moving; // a bit for each item
};

ray_scope ray_everything() { return ray_scope(RAY_EVERYTHING, 0.0, const_uint_array(uvec2(0u))); }

// How far the ray may go in an item: 0 where it passes it by.
float ray_reach(ray_scope scope, uint item, float high) {
    if (scope.kind == RAY_EVERYTHING) return high;
    bool moves = (scope.moving.at[item / 32u] >> (item % 32u) & 1u) != 0u;
    if (scope.kind == RAY_STILL) return moves ? 0.0 : high;
    return moves ? high : min(high, scope.high);
}

// Texture coordinates where the ray meets a triangle.
vec4 ray_uvs(rays_block b, uvec3 corners, vec3 weights) {
    vec4 uvs = vec4(0.0);
    for (int k = 0; k < 3; k++) uvs += vec4(b.rays.scene.scene.attributes.at[corners[k]].uv0, b.rays.scene.scene.attributes.at[corners[k]].uv1) * weights[k];
    return uvs;
}

vec4 ray_texel(gpu_texture t, vec4 uvs) {
    if (t.image == GPU_TEXTURE_NONE) return vec4(1.0);
    vec2 uv = (t.flags & GPU_TEXTURE_UV1) == 0u ? uvs.xy : uvs.zw;
    uv = vec2(t.transform[0] * uv.x + t.transform[1] * uv.y + t.transform[2], t.transform[3] * uv.x + t.transform[4] * uv.y + t.transform[5]);
    return textureLod(sampler2D(textures[nonuniformEXT(t.image)], samplers[nonuniformEXT(t.sampler_index)]), uv, 0.0);
}

// The base colour of a material where the ray meets it.
vec4 ray_color(rays_block b, uint material, uvec3 corners, vec3 weights) {
    vec4 vertex = vec4(0.0);
    for (int k = 0; k < 3; k++) {
        uvec2 color = b.rays.scene.scene.attributes.at[corners[k]].color;
        vertex += vec4(unpackUnorm2x16(color.x), unpackUnorm2x16(color.y)) * weights[k];
    }
    material_array materials = b.rays.scene.scene.materials;
    return materials.at[material].base_color * ray_texel(materials.at[material].textures[0], ray_uvs(b, corners, weights)) * vertex;
}

// What a transmissive material lets through there: nothing where it is metal.
float ray_transmission(rays_block b, uint material, uvec3 corners, vec3 weights) {
    material_array materials = b.rays.scene.scene.materials;
    float through = materials.at[material].layers.layers.transmission, metallic = materials.at[material].metallic;
    gpu_texture strength = materials.at[material].layers.layers.textures[GPU_TEXTURE_TRANSMISSION], metal = materials.at[material].textures[1];
    if (strength.image != GPU_TEXTURE_NONE || metal.image != GPU_TEXTURE_NONE) {
        vec4 uvs = ray_uvs(b, corners, weights);
        through *= ray_texel(strength, uvs).r;
        metallic *= ray_texel(metal, uvs).b;
    }
    return through * (1.0 - clamp(metallic, 0.0, 1.0));
}

// All other materials are opaque to light wherever a ray meets them.
#define RAY_OPEN_MATERIALS (GPU_MATERIAL_MASK | GPU_MATERIAL_BLEND | GPU_MATERIAL_TRANSMISSIVE | GPU_MATERIAL_SHADOWLESS)

// What part of the light a surface of this material takes where the ray meets it.
float ray_coverage(rays_block b, uint material, uvec3 corners, vec3 weights) {
    uint flags = b.rays.scene.scene.materials.at[material].flags;
    if ((flags & RAY_OPEN_MATERIALS) == 0u) return 1.0;
    if ((flags & GPU_MATERIAL_SHADOWLESS) != 0u) return 0.0;
    float cover = 1.0;
    if ((flags & (GPU_MATERIAL_MASK | GPU_MATERIAL_BLEND)) != 0u) {
        float alpha = ray_color(b, material, corners, weights).a;
        if ((flags & GPU_MATERIAL_MASK) != 0u) cover = alpha < b.rays.scene.scene.materials.at[material].alpha_cutoff ? 0.0 : 1.0;
        else cover = clamp(alpha, 0.0, 1.0);
    }
    if ((flags & GPU_MATERIAL_TRANSMISSIVE) != 0u) cover *= 1.0 - ray_transmission(b, material, corners, weights);
    return cover;
}

// What a surface leaves of the light. Tinted: its part as alpha, and as RGB the part of each colour: glass is as bright as it lets light through, and has the
// hue of its own colour.
#ifdef RAYS_TINTED
#define RAY_LIGHT vec4
vec4 ray_left(rays_block b, uint material, uvec3 corners, vec3 weights) {
    float open = 1.0 - ray_coverage(b, material, corners, weights);
    if (!(open > 0.0)) return vec4(0.0);
    vec3 color = ray_color(b, material, corners, weights).rgb;
    if ((b.rays.scene.scene.materials.at[material].flags & (GPU_MATERIAL_BLEND | GPU_MATERIAL_TRANSMISSIVE)) == 0u || !(max_component(color) > 0.0)) color = vec3(1.0);
    return vec4(color / max_component(color), 1.0) * open;
}
bool ray_is_dark(vec4 open) { return open.a <= 0.0; }
#else
#define RAY_LIGHT float
float ray_left(rays_block b, uint material, uvec3 corners, vec3 weights) { return 1.0 - ray_coverage(b, material, corners, weights); }
bool ray_is_dark(float open) { return open <= 0.0; }
#endif

// Whether the ray meets the triangle between its ends, and where. Both triangles at an edge decide about it by the same products, so that no ray
// passes between them (Davidovič et al. 2012, "3D rasterization: a bridge between rasterization and ray casting").
bool ray_meets_triangle(shadow_ray r, vec3 a, vec3 b, vec3 c, out vec3 weights) {
    a -= r.origin;
    b -= r.origin;
    c -= r.origin;
    precise vec3 bc = vec3(b.y * c.z - b.z * c.y, b.z * c.x - b.x * c.z, b.x * c.y - b.y * c.x);
    precise vec3 ca = vec3(c.y * a.z - c.z * a.y, c.z * a.x - c.x * a.z, c.x * a.y - c.y * a.x);
    precise vec3 ab = vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
    precise vec3 w = vec3(dot(bc, r.direction), dot(ca, r.direction), dot(ab, r.direction));
    weights = w;
    bool front = all(greaterThanEqual(w, vec3(0.0))), back = all(lessThanEqual(w, vec3(0.0)));
    float sum = w.x + w.y + w.z;
    if (!(front || back) || !(abs(sum) > 0.0)) return false;
    weights = w / sum;
    float at = dot(a * weights.x + b * weights.y + c * weights.z, r.direction) / dot(r.direction, r.direction);
    return at > 0.0 && at < r.high;
}

// The ray in the space of the item's mesh.
shadow_ray ray_in_item(gpu_ray_item item, shadow_ray world) {
    return shadow_ray_make(
        vec3(dot(item.rows[0], vec4(world.origin, 1.0)), dot(item.rows[1], vec4(world.origin, 1.0)), dot(item.rows[2], vec4(world.origin, 1.0))),
        vec3(dot(item.rows[0].xyz, world.direction), dot(item.rows[1].xyz, world.direction), dot(item.rows[2].xyz, world.direction)), world.high);
}

// Whether the triangle's plane holds the ray's origin to within so many metres.
bool ray_begins_on(gpu_ray_item item, shadow_ray r, vec3 p, vec3 q, vec3 s, float slack) {
    vec3 n = cross(q - p, s - p), to_world = item.rows[0].xyz * n.x + item.rows[1].xyz * n.y + item.rows[2].xyz * n.z;
    return !(abs(dot(n, p - r.origin)) > slack * length(to_world));
}

// The part of light that comes through one item. `slack`: what holds the ray's origin within so many metres casts no shadow on it.
RAY_LIGHT ray_through_item(rays_block b, gpu_ray_item item, shadow_ray world, float slack) {
    shadow_ray r = ray_in_item(item, world);
    gpu_ray_mesh mesh = b.rays.mesh_table.at[item.primitive];
    if (mesh.count == 0u) return RAY_LIGHT(1.0);
    uint end = mesh.first + mesh.count - 1u, material = b.rays.scene.scene.primitives.at[item.primitive].material;
    RAY_LIGHT open = RAY_LIGHT(1.0);
    for (uint reference = b.rays.roots.at[item.primitive]; reference != RAY_END;) {
        uint last = reference & ~RAY_LEAF;
        if ((reference & RAY_LEAF) == 0u) {
            gpu_ray_node node = b.rays.meshes.nodes.at[reference];
            if (ray_meets_box(r, node.low, node.high)) {
                reference = node.first;
                continue;
            }
            last = node.last;
        } else {
            uvec3 corners = ray_corners(b, mesh, item.primitive, b.rays.meshes.ids.at[last]);
            position_array positions = b.rays.scene.scene.positions;
            vec3 p = positions.at[corners.x], q = positions.at[corners.y], s = positions.at[corners.z], weights;
            if (ray_meets_triangle(r, p, q, s, weights)) {
                if (!ray_begins_on(item, r, p, q, s, slack)) open *= ray_left(b, material, corners, weights);
                if (ray_is_dark(open)) return RAY_LIGHT(0.0);
            }
        }
        reference = last == end ? RAY_END : b.rays.meshes.next.at[last];
    }
    return open;
}

// The part of light, 0 .. 1, that comes from `origin` + `high` metres along the unit `direction`: through the trees.
RAY_LIGHT tree_visibility(rays_block b, ray_scope scope, vec3 origin, vec3 direction, float high, float slack) {
    shadow_ray r = shadow_ray_make(origin, direction, high);
    RAY_LIGHT open = RAY_LIGHT(1.0);
    for (uint reference = b.rays.items.root; reference != RAY_END;) {
        uint last = reference & ~RAY_LEAF;
        if ((reference & RAY_LEAF) == 0u) {
            gpu_ray_node node = b.rays.items.nodes.at[reference];
            if (ray_meets_box(r, node.low, node.high)) {
                reference = node.first;
                continue;
            }
            last = node.last;
        } else {
            uint item = b.rays.items.ids.at[last];
            shadow_ray part = r;
            part.high = ray_reach(scope, item, high);
            if (scope.kind == RAY_EVERYTHING || part.high > 0.0) open *= ray_through_item(b, b.rays.placed.at[item], part, slack);
            if (ray_is_dark(open)) return RAY_LIGHT(0.0);
        }
        reference = b.rays.items.next.at[last];
    }
    return open;
}

#endif
