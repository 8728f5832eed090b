/* SPDX-License-Identifier: MIT */
/** Steps of a frame, in the order of frame.c, that have files of their own. */
#ifndef FNL_RENDER_FRAME_STEPS_H
#define FNL_RENDER_FRAME_STEPS_H

#include "passes/geometry/clusters_shared.h"
#include "render/frame_state.h"

struct culling_counts {
    uint32_t visible_items, hidden_items;
    struct gpu_cluster_totals clusters;
};
extern const struct counter_table counters_culling;
struct exposure_counts {
    float metered[2]; /* factor and EV */
};
extern const struct counter_table counters_exposure;

/** Culls the opaque scene: fills f->draws (culling.c). */
void frame_cull(struct frame_state *f);
/** Whether a debug view or an output of the frame looks at the nearest surface of each pixel (picture.c). */
bool frame_shows_surfaces(const fnl_frame *frame);
/** Copies exact counts of this frame to where the CPU reads them, and notes the numbers that are known before the GPU runs (outputs.c). */
void outputs_add_counts(struct frame_state *f);

#endif
