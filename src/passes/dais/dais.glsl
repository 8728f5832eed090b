// SPDX-License-Identifier: MIT
// Types that dais_shared.h speaks of.
#ifndef DAIS_GLSL
#define DAIS_GLSL

#include "common.glsl"
#include "view.glsl"
#include "scene.glsl"
#include "lights/iterate.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) coherent volatile buffer dais_words { uint at[]; };

#include "passes/dais/dais_shared.h"

#endif
