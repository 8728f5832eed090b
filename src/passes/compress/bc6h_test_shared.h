/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_BC6H_TEST_SHARED_H
#define FNL_PASSES_BC6H_TEST_SHARED_H

#include "shared.h"

#ifdef GL_core_profile
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer bc6h_texels { vec4 at[]; };
#endif

struct gpu_bc6h_test_push {
    ADDRESS(bc6h_texels) texels;
    uint image;
    uint width;
    uint height;
    uint first;
};

#endif
