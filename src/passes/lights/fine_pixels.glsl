// SPDX-License-Identifier: MIT
// The positions of pixels that the fine-pruned tiles test lights at: those that deferred shading makes from depth. Of several samples, the
// mean: of a plane that covers the pixel that is the depth at its centre, for the standard sample positions are centred.
#ifndef FINE_PIXELS_GLSL
#define FINE_PIXELS_GLSL

layout(constant_id = 1) const uint SAMPLES = 1u;

// False where there is sky: in some sample, there is no position for the pixel.
bool fine_pixel_depth(uvec2 pixel, out float view_depth, out bool sky) {
    float sum = 0.0;
    sky = false;
    for (uint s = 0u; s < SAMPLES; s++) {
        float depth = SAMPLES > 1u ? texelFetch(textures_multisampled[push.depth], ivec2(pixel), int(s)).r
                                   : texelFetch(textures[push.depth], ivec2(pixel), 0).r;
        sky = sky || depth <= 0.0;
        sum += depth;
    }
    view_depth = view_depth_of(push.view, SAMPLES > 1u ? sum / float(SAMPLES) : sum);
    return !sky;
}

// Depths, as stored, of the nearest blended surface and of what is opaque behind. False: no blended surface shows.
bool fine_blended(uvec2 pixel, out float front, out float behind) {
    front = texelFetch(textures[push.front], ivec2(pixel), 0).r;
    behind = texelFetch(textures[push.depth], ivec2(pixel), 0).r;
    return front > 0.0 && front >= behind;
}

vec3 fine_position(uvec2 pixel, float view_depth) {
    vec3 view_position = view_position_of(push.view, ndc_of_pixel(push.view, vec2(pixel) + 0.5), view_depth);
    return (push.view.view.view_to_world * vec4(view_position, 1.0)).xyz;
}

#endif
