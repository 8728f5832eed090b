#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// What a pixel of the display shows: each colour looks its own way, through all layers.
#include "passes/stereo/lens.glsl"

#ifdef LENS_MESH
layout(location = 0) in vec2 in_red;
layout(location = 1) in vec2 in_green;
layout(location = 2) in vec2 in_blue;
#endif
layout(location = 0) out vec4 out_color;

#define VIEW_MASK 1u
#define VIEW_MESH 2u
#define VIEW_FRINGES 3u

vec2 bent(gpu_lens_eye eye, vec2 q, int channel) {
    vec2 d = q - eye.center;
    float r2 = dot(d, d), factor = 0.0;
    for (int i = LENS_TERMS - 1; i >= 0; i--) factor = (factor + eye.terms[channel * LENS_TERMS + i]) * r2;
    return q + d * factor;
}

float layer_channel(gpu_lens_layer layer, vec2 tangents, int channel, out float alpha) {
    vec3 direction = vec3(tangents, -1.0);
    float depth = dot(layer.rows[2], direction);
    vec2 place = vec2(dot(layer.rows[0], direction), dot(layer.rows[1], direction)) / depth;
    alpha = 0.0;
    if (!(depth > 0.0) || any(lessThan(place, vec2(0.0))) || any(greaterThan(place, vec2(1.0)))) return 0.0;
    vec4 texel = textureLod(sampler2D(textures[layer.image], samplers[push.sampler_index]), place, 0.0);
    alpha = layer.blended == 1u ? texel.a : 1.0;
    return texel[channel];
}

void main() {
    gpu_lens_eye eye = push.eye.at;
    vec2 place = (gl_FragCoord.xy - push.origin) / push.size;
    vec2 tangents[3];
#ifdef LENS_MESH
    tangents[0] = in_red;
    tangents[1] = in_green;
    tangents[2] = in_blue;
#else
    vec2 q = vec2(mix(eye.display.x, eye.display.y, place.x), mix(eye.display.w, eye.display.z, place.y));
    for (int c = 0; c < 3; c++) tangents[c] = bent(eye, q, c);
#endif
    vec3 color = vec3(0.0);
    bvec3 hidden;
    for (int c = 0; c < 3; c++) {
        vec2 t = tangents[c];
        hidden[c] = t.x < eye.rendered.x || t.x > eye.rendered.y || t.y < eye.rendered.z || t.y > eye.rendered.w || distance(t, eye.center) > eye.visible_radius;
        for (uint i = 0u; i < push.layer_count; i++) {
            float alpha, value = layer_channel(push.layers.at[i], t, c, alpha);
            color[c] = mix(color[c], value, alpha);
        }
        if (hidden[c] && push.view != VIEW_MASK) color[c] = 0.0;
    }
    if (push.view == VIEW_MASK && any(hidden)) color = mix(color, vec3(1.0, 0.0, 1.0), 0.5);
    if (push.view == VIEW_FRINGES) {
        vec2 pixels = eye.source_size / vec2(eye.rendered.y - eye.rendered.x, eye.rendered.w - eye.rendered.z);
        float red = length((tangents[0] - tangents[1]) * pixels), blue = length((tangents[2] - tangents[1]) * pixels);
        color = any(hidden) ? vec3(0.0) : vec3(red, 0.0, blue) / 8.0;
    }
#ifdef LENS_MESH
    if (push.view == VIEW_MESH) {
        vec2 cell = place * float(LENS_QUADS), near = abs(cell - round(cell)) * push.size / float(LENS_QUADS);
        float diagonal = abs(fract(cell.x) + fract(cell.y) - 1.0) * min(push.size.x, push.size.y) / float(LENS_QUADS) * 0.7071;
        if (min(min(near.x, near.y), diagonal) < 0.6) color = vec3(0.0, 1.0, 0.2);
    }
#endif
    if ((push.flags & LENS_COUNTS) != 0u) atomicAdd(push.count.at[0], 1u);
    out_color = vec4((push.flags & LENS_ENCODES) != 0u ? srgb_encode(clamp(color, 0.0, 1.0)) : color, 1.0);
}
