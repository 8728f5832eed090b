/* SPDX-License-Identifier: MIT */
/** Shadows whose edges are known: a light above a floor, and between them a square in many guises. For all that finds shadows. */
#ifndef FNL_TESTS_SHADOW_CASES_H
#define FNL_TESTS_SHADOW_CASES_H

#include "tests/trace_world.h"

enum { SHADOW_SIZE = 64 };
#define SHADOW_LIGHT ((vec3){0.3f, 3, -0.2f})

/** Fills in what part of the light reaches each pixel of a view of SHADOW_SIZE squared, and destroys the scene. */
typedef void shadow_measure(fnl_scene *scene, const fnl_trace_params *view, float *out);
/** Runs all cases: what is measured is right within the tolerance, but for a strip of a millimetre at the edges. */
void shadow_cases(shadow_measure *measure, double tolerance);
/** A floor of 20 metres under the light, which is a point light. */
fnl_scene *shadow_floor(void);

#endif
