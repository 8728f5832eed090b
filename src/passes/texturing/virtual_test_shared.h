/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_VIRTUAL_TEST_SHARED_H
#define FNL_PASSES_VIRTUAL_TEST_SHARED_H

#include "passes/texturing/virtual_shared.h"
#include "shared.h"

#ifdef GL_core_profile
layout(buffer_reference) buffer virtual_cases;
layout(buffer_reference) buffer virtual_results;
#endif

struct gpu_virtual_case {
    vec2 uv;
    float change; /* of u, to the right */
    uint material;
    vec4 normal;
    vec4 tangent;
};

struct gpu_virtual_result {
    uint packed;
    uint frame;
    vec4 normal;
    vec4 tangent;
};

struct gpu_virtual_test_push {
    ADDRESS(virtual_block) pages;
    ADDRESS(virtual_cases) cases;
    ADDRESS(virtual_results) results;
    uint count;
};

#ifdef GL_core_profile
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer virtual_cases { gpu_virtual_case at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer virtual_results { gpu_virtual_result at[]; };
#endif

#endif
