// SPDX-License-Identifier: MIT
// The pixel that is asked for.
#ifndef INSPECT_GLSL
#define INSPECT_GLSL

layout(buffer_reference) buffer inspected_block;
#include "passes/debug/inspect_shared.h"
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer inspected_block {
    gpu_inspected pixel;
    gpu_inspect_light lights[INSPECT_LIGHTS];
};

#endif
