// SPDX-License-Identifier: MIT
// Shadow rays through the device's own acceleration structures (VK_KHR_ray_query), with the rules of rays.glsl for what a triangle hides.
#ifndef SHADOWS_RAY_QUERY_GLSL
#define SHADOWS_RAY_QUERY_GLSL

#extension GL_EXT_ray_query : require
#extension GL_EXT_demote_to_helper_invocation : require

#include "shadows/rays.glsl"

// What part of the light a triangle takes that the device says the ray meets. `places`: weights of its second and third corner, as the device has them;
// our own are those of the trees, but at edges the device decides.
float query_coverage(rays_block b, shadow_ray world, float slack, uint item_index, uint triangle, vec2 places) {
    gpu_ray_item item = b.rays.placed.at[item_index];
    shadow_ray r = ray_in_item(item, world);
    gpu_primitive primitive = b.rays.scene.scene.primitives.at[item.primitive];
    if (3u * triangle >= primitive.index_count) return 0.0;
    uint at = primitive.first_index + 3u * triangle;
    uvec3 corners = uvec3(b.rays.indices.at[at], b.rays.indices.at[at + 1u], b.rays.indices.at[at + 2u]) + uint(primitive.vertex_offset);
    position_array positions = b.rays.scene.scene.positions;
    vec3 p = positions.at[corners.x], q = positions.at[corners.y], s = positions.at[corners.z], weights;
    if (ray_begins_on(item, r, p, q, s, slack)) return 0.0;
    if ((b.rays.scene.scene.materials.at[primitive.material].flags & RAY_OPEN_MATERIALS) == 0u) return 1.0;
    if (!ray_meets_triangle(r, p, q, s, weights)) weights = vec3(1.0 - places.x - places.y, places);
    return ray_coverage(b, primitive.material, corners, weights);
}

// Mesa's CPU driver ends a walk where only helpers and discarded invocations are left in it, and has them go on with whatever they found so far:
// they must not take that for a triangle.
float query_visibility(rays_block b, vec3 origin, vec3 direction, float high, float slack) {
    vec3 sum = origin + direction;
    if (!(high > 0.0) || !(abs(sum.x + sum.y + sum.z) < 1e30)) return 1.0; // queries take no ray without length, and no NaN
#ifdef GL_FRAGMENT_SHADER
    if (helperInvocationEXT()) return 1.0;
#endif
    shadow_ray world = shadow_ray_make(origin, direction, high);
    float open = 1.0;
    rayQueryEXT query;
    rayQueryInitializeEXT(query, accelerationStructureEXT(b.rays.top), gl_RayFlagsNoOpaqueEXT, 0xffu, origin, 0.0, direction, high);
    while (rayQueryProceedEXT(query)) {
        if (rayQueryGetIntersectionTypeEXT(query, false) != gl_RayQueryCandidateIntersectionTriangleEXT) break;
        open *= 1.0 - query_coverage(b, world, slack, uint(rayQueryGetIntersectionInstanceCustomIndexEXT(query, false)),
                                     uint(rayQueryGetIntersectionPrimitiveIndexEXT(query, false)), rayQueryGetIntersectionBarycentricsEXT(query, false));
        if (open <= 0.0) return 0.0;
    }
    return open;
}

// Rays that this invocation has sent, and those of them that found at least half of their light.
uint rays_sent = 0u, rays_passed = 0u;

float ray_counted(float open) {
    rays_sent++;
    if (open >= 0.5) rays_passed++;
    return open;
}

// The part of light, 0 .. 1, that comes from `origin` + `high` metres along the unit `direction`. What holds the origin within `slack` metres casts no
// shadow on it.
float ray_visibility(rays_block b, vec3 origin, vec3 direction, float high, float slack) {
    return ray_counted(LIGHTING_RAY_QUERY ? query_visibility(b, origin, direction, high, slack)
                                      : tree_visibility(b, ray_everything(), origin, direction, high, slack));
}

// The same through some items; not with LIGHTING_RAY_QUERY.
float ray_visibility_in(rays_block b, ray_scope scope, vec3 origin, vec3 direction, float high, float slack) {
    return ray_counted(tree_visibility(b, scope, origin, direction, high, slack));
}

#endif
