/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_SHADE_SHARED_H
#define FNL_PASSES_SHADE_SHARED_H

#include "gbuffer_shared.h"

/* Work groups across a strip of the picture. Devices take groups in the order of their numbers, so strips are shaded one after the other: what one row of a
   strip looks up is still in caches when the next row needs it. */
#define DEFERRED_STRIP 4u

struct gpu_deferred_push { /* the view is that of the G-buffer */
    ADDRESS(lighting_block) lighting;
    ADDRESS(uint_array) counters;
    STRUCT(gpu_gbuffer) gbuffer;
    uint radiance;   /* storage: emission in, radiance out */
    ADDRESS(uint_array) sums;   /* of classify_shared.h, where pixels are classified */
    ADDRESS(uint_array) blocks;
    uint block_count;
    uint class_index;
    uint first_row;  /* of the dispatch: pixels */
    uint open;       /* storage, as the three below: struct gpu_denoise_collect_push says what they hold; with GPU_LIGHTING_DENOISED */
    uint seen;
    uint drawn;
    uint field;
    uint guide_weights; /* sampled, and */
    uint guide_seen;    /* storage: of shadows/guide_shared.h; with GPU_LIGHTING_GUIDED */
};

#endif
