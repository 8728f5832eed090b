// SPDX-License-Identifier: MIT
// Decals on what is drawn: for fragment shaders of the scene, right after material_surface().
#ifndef DECALS_RASTER_GLSL
#define DECALS_RASTER_GLSL

#include "decals.glsl"
#include "scene.glsl"

// in_bind: the position before the mesh deforms, in its own space. With MATERIAL_GRADIENTS (material.glsl) the shader fills it, what
// follows it, and in_pixel.
#ifdef MATERIAL_GRADIENTS
layout(constant_id = FOUND_FEATURES_ID) const uint FEATURES = 0u; // GPU_FEATURE_…
vec3 in_bind;
vec3 in_position_dx, in_position_dy, in_bind_dx, in_bind_dy; // per pixel to the right and down
uvec2 in_pixel;
#else
layout(constant_id = FEATURES_ID) const uint FEATURES = 0u; // GPU_FEATURE_…
layout(location = 7) centroid in vec3 in_bind;
#define in_position_dx dFdx(in_position)
#define in_position_dy dFdy(in_position)
#define in_bind_dx dFdx(in_bind)
#define in_bind_dy dFdy(in_bind)
#define in_pixel uvec2(gl_FragCoord.xy)
#endif

decal_point decal_raster_point(view_block v, gpu_item item, vec3 dx, vec3 dy) {
    decal_point p;
    p.position = in_position;
    p.dx = dx;
    p.dy = dy;
    float length2 = dot(in_normal, in_normal);
    p.facing = length2 > 1e-30 && length2 < 1e30 ? in_normal * inversesqrt(length2) : vec3(0.0, 1.0, 0.0);
    if (dot(p.facing, to_viewer(v, in_position)) < 0.0) p.facing = -p.facing;
    p.receivers = item.receivers & 255u;
    return p;
}

// Decals of the instance's own.
void decals_of_mesh(inout surface s, decal_block d, scene_block scene, gpu_item item, decal_point p, vec3 bind_dx, vec3 bind_dy) {
    gpu_instance instance = scene.scene.instances.at[item.instance];
    float mirror = dot(cross(instance.rows[0].xyz, instance.rows[1].xyz), instance.rows[2].xyz) < 0.0 ? -1.0 : 1.0;
    uint next = d.set.mesh_ranges.at[item.instance], end = p.receivers == 0u ? next : d.set.mesh_ranges.at[item.instance + 1u];
    decal_array decals = d.set.decals;
    for (; next < end; next++) {
        uint index = d.set.mesh_ids.at[next];
        vec3 q = decal_cube(decals, index, in_bind);
        if (!decal_holds(q) || !decal_meets(decals, index, p.receivers)) continue;
        decal_place place = decal_place_on_mesh(decals, index, q, p, bind_dx, bind_dy, mirror);
        decal_apply(s, decals, index, d.set.sampler_index, place, p);
    }
}

// Call where control flow is uniform: derivatives are taken here.
void decals_on(inout surface s, view_block v, scene_block scene, bool to_gbuffer) {
    if ((FEATURES & GPU_FEATURES_DECALS) == 0u) return;
    vec3 dx = in_position_dx, dy = in_position_dy, bind_dx = vec3(0.0), bind_dy = vec3(0.0);
    if ((FEATURES & GPU_FEATURE_MESH_DECALS) != 0u) {
        bind_dx = in_bind_dx;
        bind_dy = in_bind_dy;
    }
    decal_block d = decals_of(v);
    gpu_item item = scene.scene.items.at[in_ids.y];
    decal_point p = decal_raster_point(v, item, dx, dy);
    // No way leads past the loops: registers would keep the surface as it was for it. What receives nothing has no turns.
    if ((FEATURES & GPU_FEATURE_MESH_DECALS) != 0u) decals_of_mesh(s, d, scene, item, p, bind_dx, bind_dy);
    if ((FEATURES & GPU_FEATURE_DECALS) == 0u || to_gbuffer && d.set.in_gbuffer == 1u) return;
    vec3 view_position = (v.view.world_to_view * vec4(in_position, 1.0)).xyz;
    uvec2 pixel = v.view.samples > 1u ? pixel_of(v, view_position) : in_pixel;
    decals_apply(s, d, pixel, -view_position.z, p);
}

void decals_on_surface(inout surface s, view_block v, scene_block scene) { decals_on(s, v, scene, false); }

// What goes into a G-buffer, where another pass may apply boxes and volumes.
void decals_on_gbuffer(inout surface s, view_block v, scene_block scene) { decals_on(s, v, scene, true); }

#endif
