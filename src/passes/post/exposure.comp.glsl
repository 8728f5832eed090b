#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// From the histogram to an exposure: the mean log luminance between the 50th and the 98th percentile becomes the reflected-light
// reading, EV100 = log2(L * 100 / 12.5), and the picture is scaled by 1 / (1.2 * 2^EV100) (Lagarde & de Rousiers 2014).
#include "common.glsl"

layout(buffer_reference) buffer float_array;
#include "passes/post/post_shared.h"
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer float_array { float at[]; };

layout(local_size_x = 1) in;
layout(push_constant, scalar) uniform push_block { gpu_exposure_push push; };

void main() {
    float total = 0.0;
    // Bin 0 holds black: it says nothing about brightness.
    for (uint i = 1u; i < METER_BINS; i++) total += float(push.histogram.at[i]);
    float low = total * 0.5, high = total * 0.98, before = 0.0, sum = 0.0, weight = 0.0;
    for (uint i = 1u; i < METER_BINS; i++) {
        float count = float(push.histogram.at[i]);
        float inside = max(min(before + count, high) - max(before, low), 0.0);
        sum += inside * ((float(i) + 0.5) / float(METER_BINS) * (METER_HIGH - METER_LOW) + METER_LOW);
        weight += inside;
        before += count;
    }
    float ev = weight > 0.0 ? sum / weight + 3.0 : 0.0;
    push.exposure.at[0] = 1.0 / (1.2 * exp2(ev));
    push.exposure.at[1] = ev;
}
