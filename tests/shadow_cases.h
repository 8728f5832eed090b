/* SPDX-License-Identifier: MIT */
/** Shadows whose edges are known: a light above a floor, and between them a square in many guises. For all that finds shadows. */
#ifndef FNL_TESTS_SHADOW_CASES_H
#define FNL_TESTS_SHADOW_CASES_H

#include "tests/trace_world.h"

enum { SHADOW_SIZE = 64 };
#define SHADOW_LIGHT ((vec3){0.3f, 3, -0.2f})

/** Fills in what part of the light reaches each pixel of a view of SHADOW_SIZE squared, and destroys the scene. */
typedef void shadow_measure(fnl_scene *scene, const fnl_trace_params *view, float *out);
/** Runs all cases: what is measured is right within the tolerance, but for a strip at the edges of shadows. */
struct shadow_cases {
    shadow_measure *measure;
    double tolerance;
    double strip; /* metres, a metre above the floor; on it shadows are half as large again */
    bool blended; /* blended surfaces cast shadows */
};
void shadow_cases(const struct shadow_cases *cases);
/** A floor of 20 metres under the light, which is a point light. */
fnl_scene *shadow_floor(void);

#endif
