/* SPDX-License-Identifier: MIT */
/** Views of what the G-buffer holds. */
#ifndef FNL_PASSES_GBUFFER_VIEW_SHARED_H
#define FNL_PASSES_GBUFFER_VIEW_SHARED_H

#include "gbuffer_shared.h"

/* What a field is. */
#define GBUFFER_SEEN_NORMAL 0u
#define GBUFFER_SEEN_COLOR 1u
#define GBUFFER_SEEN_ROUGHNESS 2u
#define GBUFFER_SEEN_METALLIC 3u
#define GBUFFER_SEEN_OCCLUSION 4u
#define GBUFFER_SEEN_F0 5u
#define GBUFFER_SEEN_F90 6u
#define GBUFFER_SEEN_MATERIAL 7u
#define GBUFFER_SEEN_MOTION 8u
#define GBUFFER_SEEN_POSITION 9u
#define GBUFFER_SEEN_DEPTH 10u
#define GBUFFER_SEEN_FORWARD 11u
#define GBUFFER_SEEN_CHANNEL(channel) (12u + (channel)) /* of the target, as it is stored */
#define GBUFFER_SEEN_COAT_NORMAL 16u

struct gpu_gbuffer_view_push {
    STRUCT(gpu_gbuffer) gbuffer;
    uint from;       /* render target, for channels */
    uint field_count; /* 1: the whole picture; up to 4: a quarter of the picture for each, from the top left */
    uint fields;     /* GBUFFER_SEEN_…, 8 bits each, the first lowest */
    uint target;     /* storage */
    uint swap;       /* 1: red and blue change places */
};

#endif
