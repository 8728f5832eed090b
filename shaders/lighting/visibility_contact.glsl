// SPDX-License-Identifier: MIT
// GPU_LIGHTING_CONTACT: a short march from the point toward the light, compared with the depth of the view's opaque surfaces. It finds occluders that maps are too
// coarse for. Occluders are assumed as thick as the march is long; occluders out of view or hidden are missing.
#ifndef LIGHTING_VISIBILITY_CONTACT_GLSL
#define LIGHTING_VISIBILITY_CONTACT_GLSL

const uint CONTACT_STEPS_LEAST = 4u, CONTACT_STEPS_MOST = 32u;
const float CONTACT_FADE = 0.75; // part of the length from which on shadows fade, so that they end softly

float contact_depth(lighting_block l, vec2 uv) {
    if (l.scope.shadows.contact_samples > 1u) {
        ivec2 size = textureSize(textures_multisampled[l.scope.shadows.contact]);
        return texelFetch(textures_multisampled[l.scope.shadows.contact], clamp(ivec2(uv * vec2(size)), ivec2(0), size - 1), 0).r;
    }
    ivec2 size = textureSize(textures[l.scope.shadows.contact], 0);
    return texelFetch(textures[l.scope.shadows.contact], clamp(ivec2(uv * vec2(size)), ivec2(0), size - 1), 0).r;
}

// The unshadowed fraction along the march, 0 .. 1.
float contact_visibility(lighting_block l, uint light, shadowed_point p, vec3 to_light, bool is_sun) {
    view_block v = l.scope.view;
    float reach = l.scope.shadows.contact_length;
    if (LIGHTING_MASKS) reach *= unpackHalf2x16(l.scope.lights.masks.at[light]).y;
    if (!is_sun) reach = min(reach, light_distance(lights_of(l), light, p.position, to_light));
    if (!(reach > 0.0)) return 1.0;
    float pixel = pixel_width(v, -(v.view.world_to_view * vec4(p.position, 1.0)).z);
    vec3 from = p.position + p.normal * pixel; // off the surface that the depth image shows there
    vec4 begin = v.view.world_to_clip * vec4(from, 1.0), end = v.view.world_to_clip * vec4(from + to_light * reach, 1.0);
    if (!(begin.w > 0.0)) return 1.0;
    if (v.view.orthographic == 0.0 && !(end.w > v.view.near_distance * 0.5)) end = begin; // it passes the viewer: of unknown length on the screen
    vec2 crossed = (end.xy / end.w - begin.xy / begin.w) * 0.5 * vec2(v.view.size);
    uint steps = clamp(uint(length(crossed)), CONTACT_STEPS_LEAST, CONTACT_STEPS_MOST);
    float shift = source_turn(l, light, p.position);
    for (uint i = 0u; i < steps; i++) {
        float part = (float(i) + shift) / float(steps);
        vec3 at = from + to_light * (part * reach);
        vec4 clip = v.view.world_to_clip * vec4(at, 1.0);
        if (!(clip.w > 0.0)) return 1.0;
        vec2 uv = vec2(clip.x, -clip.y) / clip.w * 0.5 + 0.5;
        if (any(lessThan(uv, vec2(0.0))) || any(greaterThan(uv, vec2(1.0)))) return 1.0;
        float depth = -(v.view.world_to_view * vec4(at, 1.0)).z, behind = depth - view_depth_of(v, contact_depth(l, uv));
        if (behind > pixel && behind < reach) return smoothstep(CONTACT_FADE, 1.0, part);
    }
    return 1.0;
}

#endif
