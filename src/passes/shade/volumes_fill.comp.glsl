#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Writes which light each instance is, ascending, and the indirect draws: two, then those of one light each.
#include "common.glsl"
#include "passes/shade/volumes.glsl"
#include "scene.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer volume_draws { gpu_draw at[]; };

layout(local_size_x = 64) in;

gpu_draw solid_draw(bool sphere, uint first, uint count) {
    gpu_draw draw;
    draw.index_count = sphere ? VOLUME_SPHERE_INDICES : VOLUME_CONE_INDICES;
    draw.instance_count = count;
    draw.first_index = sphere ? 0u : VOLUME_SPHERE_INDICES;
    draw.vertex_offset = 0;
    draw.first_instance = first;
    return draw;
}

layout(push_constant, scalar) uniform push_block { gpu_volumes_push push; };

void main() {
    uint index = LINEAR_INVOCATION;
    uint count = push.light_count;
    if (index < 2u * count) {
        uint slot = push.sums.at[index];
        if (push.sums.at[index + 1u] != slot) {
            push.ids.at[slot] = index < count ? index : index - count;
            if (push.by_light == 0u && slot < push.alone) push.draws.at[2u + slot] = solid_draw(index < count, slot, 1u);
        }
        if (push.by_light == 1u && index < push.alone) {
            uint sphere = push.sums.at[index], cone = push.sums.at[count + index];
            bool is_sphere = push.sums.at[index + 1u] != sphere, is_cone = push.sums.at[count + index + 1u] != cone;
            push.draws.at[2u + index] = solid_draw(!is_cone, is_cone ? cone : sphere, is_sphere || is_cone ? 1u : 0u);
        } else if (index < push.alone && index >= push.sums.at[2u * count]) push.draws.at[2u + index] = solid_draw(true, 0u, 0u);
    }
    if (index < push.batch) push.ids.at[push.sums.at[2u * count] + index] = VOLUME_NONE;
    if (index < 2u) {
        uint end = push.sums.at[(index + 1u) * count], first = min(max(push.sums.at[index * count], push.alone), end);
        if (push.by_light == 1u) first = push.sums.at[index * count + push.alone];
        gpu_draw draw = solid_draw(index == 0u, first, end - first);
        const uint quads = VOLUME_SPHERE_INDICES + VOLUME_CONE_INDICES;
        if (index == 0u && push.shape == VOLUME_QUADS) {
            draw.index_count = VOLUME_QUAD_INDICES;
            draw.first_index = quads;
        } else if (index == 0u && push.shape == VOLUME_ELLIPSE) {
            draw.index_count = VOLUME_OCTAGON_INDICES;
            draw.first_index = quads + VOLUME_QUAD_INDICES;
        } else if (index == 0u && push.shape == VOLUME_SCREEN) {
            draw.index_count = VOLUME_SCREEN_INDICES;
            draw.instance_count = (draw.instance_count + push.batch - 1u) / push.batch;
            draw.first_index = quads + VOLUME_QUAD_INDICES + VOLUME_OCTAGON_INDICES;
        }
        push.draws.at[index] = draw;
    }
}
