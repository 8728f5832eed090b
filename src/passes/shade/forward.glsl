// SPDX-License-Identifier: MIT
// Forward shading, opaque and transparent: what all entry points that shade as they draw share.
#include "common.glsl"
#include "lights/iterate.glsl"
#define MATERIAL_LAYERS LIGHTING_LAYERS
#include "material.glsl"
#include "decals_raster.glsl"
#include "shade.glsl"
#include "passes/geometry/geometry_shared.h"

// Of the sample where it is farthest: fragments are not cut within a pixel, and at its edges none is drawn twice.
float nearest_glass(view_block v, lighting_block l) {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    if (v.view.samples == 1u) return texelFetch(textures[l.scope.glass], pixel, 0).r;
    float depth = 1.0;
    for (uint i = 0u; i < v.view.samples; i++) depth = min(depth, texelFetch(textures_multisampled[l.scope.glass], pixel, int(i)).r);
    return depth;
}

// Radiance times coverage, and coverage. Leaves where there is a hole, or the back of a single-sided surface. `view_depth` is that of the
// point that is shaded.
vec4 forward_shade(gpu_geometry_push push, out float view_depth) {
    material_array materials = push.scene.scene.materials;
    bool hole;
    surface s = material_surface(materials, in_ids.x, hole);
    if (LIGHTING_MASKS) s.light_mask = item_light_mask(push.scene, in_ids.y);
#ifdef TRANSMISSION // thickness is measured in the mesh: lengths of the instance's axes, as one number
    gpu_instance instance = push.scene.scene.instances.at[push.scene.scene.items.at[in_ids.y].instance];
    s.layers.thickness *= pow(abs(dot(instance.rows[0].xyz, cross(instance.rows[1].xyz, instance.rows[2].xyz))), 1.0 / 3.0);
#endif
    decals_on_surface(s, push.view, push.scene);
#ifdef HOLES_ARE_CUT
    hole = false;
#endif
    if (material_culled(materials, in_ids.x) || hole) discard;
    if (LIGHTING_BEHIND_GLASS && gl_FragCoord.z >= nearest_glass(push.view, push.lighting)) discard;
    // Of the point that is shaded, not of gl_FragCoord: where MSAA covers a pixel in part, that may lie far off along the plane, and beside
    // the pixel.
    vec3 view_position = (push.view.view.world_to_view * vec4(s.position, 1.0)).xyz;
    uvec2 pixel = push.view.view.samples > 1u ? pixel_of(push.view, view_position) : uvec2(gl_FragCoord.xy);
    view_depth = -view_position.z;
    vec3 radiance = shade_surface(s, push.view, push.lighting, push.counters, pixel, view_depth, in_ids.y);
    // Premultiplied; a blended surface keeps its glow and its highlights by alpha as glTF asks (coverage, not transmission).
    return vec4(min(radiance, vec3(push.view.view.frame.frame.hdr_max)) * s.alpha, s.alpha);
}
