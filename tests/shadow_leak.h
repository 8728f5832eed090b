/* SPDX-License-Identifier: MIT */
/** How much light maps let through, or keep out, where rays do not. */
#ifndef FNL_TESTS_SHADOW_LEAK_H
#define FNL_TESTS_SHADOW_LEAK_H

#include "tests/render_harness.h"

/** Luminance that differs from rays, as a part of what there would be without shadows. */
struct shadow_leak {
    double error, dark; /* dark: what rays take away */
    uint32_t far_off;   /* pixels that differ although no edge of a shadow or a surface is near */
};
/** Of the stage's frame, which it renders three times. `reach`: pixels from an edge that are near. */
struct shadow_leak shadow_leak_of(struct stage *s, int reach);

#endif
