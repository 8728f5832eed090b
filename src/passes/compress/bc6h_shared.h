/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_BC6H_SHARED_H
#define FNL_PASSES_BC6H_SHARED_H

#include "shared.h"

#ifdef GL_core_profile
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer bc6h_blocks { uvec4 at[]; };
#endif

struct gpu_bc6h_push {
    ADDRESS(bc6h_blocks) blocks;
    uint first_block; /* of this picture in `blocks` */
    uint source;      /* sampled */
    uint sampler_index; /* nearest, clamped: edges are repeated */
    uint target; /* storage, where blocks go to an image */
    uint width;  /* texels of the source */
    uint height;
};

#endif
