// SPDX-License-Identifier: MIT
// The parts of gpu_shadow_places.sums.
#ifndef SHADOW_PAGES_PLACES_GLSL
#define SHADOW_PAGES_PLACES_GLSL

#include "passes/shadow/pages.glsl"

uint cell_count(gpu_shadow_places p) { return p.side * p.side; }
uint first_new(gpu_shadow_places p, uint c) { return c * p.block_count; }
uint first_page(gpu_shadow_places p, uint c) { return (SHADOW_CLASSES + c) * p.block_count; }
uint first_free(gpu_shadow_places p, uint c) { return 2u * SHADOW_CLASSES * p.block_count + c * cell_count(p); } // c of SHADOW_CLASSES: of free cells

#endif
