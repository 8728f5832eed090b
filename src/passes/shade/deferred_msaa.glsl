// SPDX-License-Identifier: MIT
// What shading and spreading share.
#include "common.glsl"
#include "gbuffer.glsl"
#include "lights/iterate.glsl"
#include "passes/shade/edges.glsl"
#include "passes/shade/deferred_msaa_shared.h"

layout(constant_id = MSAA_METHOD_ID) const uint METHOD = MSAA_ALL;

// The surface that shows at most samples of a pixel, the first of several.
uint widest_surface(uint word) {
    uint widest = 0u, most = 0u;
    for (uint i = 0u; i < SAMPLES; i++) {
        uint count = uint(bitCount(surface_samples(word, i)));
        if (count <= most) continue;
        most = count;
        widest = i;
    }
    return widest;
}
