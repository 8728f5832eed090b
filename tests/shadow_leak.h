/* SPDX-License-Identifier: MIT */
/** What part of their light shadows leave to pixels, and how much of it maps let through, or keep out, where rays do not. */
#ifndef FNL_TESTS_SHADOW_LEAK_H
#define FNL_TESTS_SHADOW_LEAK_H

#include "tests/render_harness.h"
#include "tests/shadow_cases.h"

/** A scene that it takes, seen as shadow_measure wants it, without shadows as yet. */
struct stage shadow_stage(fnl_scene *scene, const fnl_trace_params *view);
/** The part for each pixel of the stage's frame, which it renders twice; 1 where there is no light. Returns the stats of the one with shadows. */
fnl_frame_stats shadow_parts(struct stage *s, float *out);

/** Luminance that differs from rays, as a part of what there would be without shadows. */
struct shadow_leak {
    double error, dark; /* dark: what rays take away */
    uint32_t far_off;   /* pixels that differ although no edge of a shadow or a surface is near */
};
/** Of the stage's frame, which it renders three times. `reach`: pixels from an edge that are near. */
struct shadow_leak shadow_leak_of(struct stage *s, int reach);

#endif
