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

void main() {
    float total = 0.0, surfaces = 0.0;
    for (uint i = 1u; i < METER_BINS; i++) {
        total += count_of(i);
        surfaces += float(push.histogram.at[i]);
    }
    float low = total * METER_TRIM, high = total * (1.0 - METER_TRIM), bright = surfaces * METER_BRIGHT, broad = surfaces * METER_BROAD;
    float before = 0.0, seen = 0.0, sum = 0.0, weight = 0.0, brightest = METER_LOW, broadest = METER_LOW; // of all, of surfaces
    for (uint i = 1u; i < METER_BINS; i++) {
        float count = count_of(i), shown = float(push.histogram.at[i]), inside = max(min(before + count, high) - max(before, low), 0.0);
        sum += inside * level_of(float(i) + 0.5);
        weight += inside;
        if (seen < broad && seen + shown >= broad) broadest = level_of(float(i) + (broad - seen) / shown);
        if (seen < bright && seen + shown >= bright) brightest = level_of(float(i) + (bright - seen) / shown);
        before += count;
        seen += shown;
    }
    float kept = max(brightest - log2(1.2 * METER_SPARE), broadest - log2(1.2 * METER_LIGHT));
    float ev = weight > 0.0 ? max(sum / weight - log2(1.2 * METER_KEY), kept) : 0.0;
    push.exposure.at[0] = 1.0 / (1.2 * exp2(ev));
    push.exposure.at[1] = ev;
}
