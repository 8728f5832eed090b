#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// A square of two by two pixels round the middle of each light that is not whole.
#include "common.glsl"
#include "passes/lights/sprites.glsl"

layout(push_constant, scalar) uniform push_block { gpu_sprites_push push; };

layout(location = 0) flat out vec3 out_color; // radiance times pixels
layout(location = 1) flat out vec2 out_pixel;

// Part of what lies between axis and edge that an edge leaves: full up to 1 - 1 / scale, then a square's fall.
float edge_part(float scale) { return 1.0 - 2.0 / (3.0 * scale); }

// Luminous intensity in candela, of colour 1, that matt surfaces which catch half the light of a lamp, or all of a beam, send to one side.
float reflected_intensity(gpu_light light) {
    float part = 1.0; // lumens over 2 pi
    if (light.shape.kind == GPU_SHAPE_CONE) {
        float outer = -light.shape.spot_offset / light.shape.spot_scale, inner = outer + 1.0 / light.shape.spot_scale;
        part = 1.0 - inner + (inner - outer) / 3.0;
    } else if (light.shape.kind == GPU_SHAPE_WEDGE) {
        vec2 tangent = light.shape.size.xy * edge_part(light.shape.spot_scale);
        float angle = 4.0 * asin(tangent.x * tangent.y * inversesqrt((1.0 + tangent.x * tangent.x) * (1.0 + tangent.y * tangent.y)));
        part = angle / (2.0 * PI);
    } else if (light.shape.kind == GPU_SHAPE_BOX) {
        vec2 side = 2.0 * light.shape.size.xy * edge_part(light.shape.spot_scale);
        part = side.x * side.y / (2.0 * PI);
    } else if (shape_is_area(light.shape.kind)) {
        part = 0.5; // both sides of one that has two send as much, of which half is caught
    }
    return SPRITE_ALBEDO * part;
}

void main() {
    view_block v = push.view;
    gl_Position = vec4(0.0, 0.0, -1.0, 1.0); // clipped
    out_color = vec3(0.0);
    out_pixel = vec2(0.0);
    gpu_light light = push.lights.at[push.directional_count + gl_InstanceIndex];
    gpu_entity_bounds bounds = push.bounds.at[gl_InstanceIndex];
    if (!(bounds.radius > 0.0)) return;
    float rest = 1.0 - light_fade(v, bounds.center, bounds.radius, push.lod);
    vec4 clip = v.view.world_to_clip * vec4(light.shape.position, 1.0);
    if (!(rest > 0.0 && clip.w > 0.0)) return;
    vec3 ndc = clip.xyz / clip.w;
    vec2 size = vec2(v.view.size), pixel = vec2(ndc.x * 0.5 + 0.5, 0.5 - ndc.y * 0.5) * size;
    vec2 corner = floor(pixel - 0.5) + 2.0 * vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1);
    gl_Position = vec4(corner.x / size.x * 2.0 - 1.0, 1.0 - corner.y / size.y * 2.0, ndc.z, 1.0);

    // Candela on a pixel are cd/m^2 over what the pixel covers there: its solid angle times the squared distance, or its area.
    vec2 pixel_size = 2.0 * abs(v.view.ndc_scale) * v.view.inverse_size;
    float area = pixel_size.x * pixel_size.y;
    if (v.view.orthographic < 0.5) {
        float view_depth = clip.w;
        area *= view_depth * view_depth * view_depth / max(distance(light.shape.position, v.view.eye), 1e-10);
    }
    out_color = light.color * (rest * reflected_intensity(light) / max(area, 1e-30));
    out_pixel = pixel;
}
