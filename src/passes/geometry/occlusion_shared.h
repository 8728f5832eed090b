/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_OCCLUSION_SHARED_H
#define FNL_PASSES_OCCLUSION_SHARED_H

#include "shared.h"

struct gpu_occlusion_push {
    ADDRESS(view_block) view;
    ADDRESS(view_block) previous; /* reprojection: the last frame's */
    ADDRESS(hierarchy_array) hierarchy;
    uint depth; /* sampled: depth of this frame, or tiles of the last */
    uint tiles; /* storage: the same tiles for the next frame */
    uint width; /* of the first level */
    uint height;
    uint samples; /* of depth */
};

#endif
