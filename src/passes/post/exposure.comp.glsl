#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// From the histograms to an exposure (exposure_shared.h); radiance is multiplied by 1 / (1.2 * 2^EV100) (Lagarde & de Rousiers 2014).
#include "common.glsl"

layout(buffer_reference) buffer float_array;
#include "passes/post/post_shared.h"
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer float_array { float at[]; };

layout(local_size_x = 1) in;
layout(push_constant, scalar) uniform push_block { gpu_exposure_push push; };

float count_of(uint bin) { return float(push.histogram.at[bin]) + METER_BACKGROUND * float(push.histogram.at[METER_BINS + bin]); }

float level_of(float bin) { return bin / float(METER_BINS) * (METER_HIGH - METER_LOW) + METER_LOW; }

// Below which this share of the surfaces is.
float surface_level(float share) {
    float all = 0.0, before = 0.0;
    for (uint i = 1u; i < METER_BINS; i++) all += float(push.histogram.at[i]);
    for (uint i = 1u; i < METER_BINS && all > 0.0; i++) {
        float count = float(push.histogram.at[i]), wanted = all * share;
        if (before + count >= wanted) return level_of(float(i) + (wanted - before) / count);
        before += count;
    }
    return METER_LOW;
}

void main() {
    float total = 0.0;
    for (uint i = 1u; i < METER_BINS; i++) total += count_of(i);
    float low = total * METER_TRIM, high = total * (1.0 - METER_TRIM), before = 0.0, sum = 0.0, weight = 0.0;
    for (uint i = 1u; i < METER_BINS; i++) {
        float count = count_of(i), inside = max(min(before + count, high) - max(before, low), 0.0);
        sum += inside * level_of(float(i) + 0.5);
        weight += inside;
        before += count;
    }
    float ev = weight > 0.0 ? max(sum / weight - log2(1.2 * METER_KEY), max(surface_level(METER_BRIGHT) - log2(1.2 * METER_SPARE),
                                                                            surface_level(METER_BROAD) - log2(1.2 * METER_LIGHT)))
                            : 0.0;
    push.exposure.at[0] = 1.0 / (1.2 * exp2(ev));
    push.exposure.at[1] = ev;
}
