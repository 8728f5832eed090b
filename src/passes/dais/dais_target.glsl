// SPDX-License-Identifier: MIT
// References into a render target of as many samples as the picture has.
#include "passes/dais/dais_store.glsl"

layout(location = 0) out uint out_reference;
layout(location = 1) out uint out_sample;

void main() {
    uint reference = fragment_reference();
    out_reference = reference;
    out_sample = SHARED_SAMPLES == 1u ? shading_sample(reference) : 0u;
}
