#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Motion of what stands still; that of objects is taken from what was drawn.
#include "passes/aa/motion.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform push_block { gpu_motion_push push; };

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(uvec2(p), push.view.view.size))) return;
    float depth = texelFetch(textures[push.depth], p, 0).x;
    vec2 pixel = vec2(p) + 0.5, ndc = ndc_of_pixel(push.view, pixel);
    bool sky = depth <= 0.0 && push.view.view.orthographic < 0.5;
    vec4 position = sky ? vec4(view_position_of(push.view, ndc, 1.0), 0.0)
                        : vec4(view_position_of(push.view, ndc, view_depth_of(push.view, depth)), 1.0);
    vec4 found = motion_of(push.motion, pixel, vec4((push.motion.motion.view_to_previous * position).xyz, position.w));
    if (push.has_objects == 1u) {
        vec4 object = texelFetch(textures[push.objects], p, 0);
        if (object.z > 0.0) { // one was drawn here
            if (object.w > 0.0) object.w += length(object.xy - found.xy);
            found = object;
        }
    }
    imageStore(images[push.target], p, found);
}
