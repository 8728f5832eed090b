/* SPDX-License-Identifier: MIT */
/**
 * What nobody sees through a lens (fanal/stereo.h), as triangles that are drawn into depth: at the near plane nothing is drawn over it; at the far end
 * those who read depth find nothing there (Vlachos, "Advanced VR Rendering", GDC 2015). Cost: the pixels of the triangles, depth alone.
 */
#ifndef FNL_PASSES_HIDDEN_AREA_H
#define FNL_PASSES_HIDDEN_AREA_H

#include "fanal/stereo.h"
#include "graph/graph.h"
#include "view_shared.h"

struct hidden_area {
    VkDeviceAddress corners;
    uint32_t corner_count; /* 0: all is seen */
};
/** In the frame's memory, as `view` (without jitter) projects it. Nothing where memory ran out, of which the device then knows. */
struct hidden_area hidden_area_send(gpu_device *device, const fnl_hidden_area *area, const struct gpu_view *view);

enum hidden_area_depth { HIDDEN_AREA_NEAR, HIDDEN_AREA_FAR };
/** Into depth; `clears`: all that is not hidden becomes far. */
void hidden_area_add(struct graph *graph, const char *name, const struct hidden_area *area, enum hidden_area_depth to, bool clears, graph_image depth);
/** Black into `radiance`, near into `depth`. */
void hidden_area_blacken(struct graph *graph, const struct hidden_area *area, graph_image radiance, graph_image depth);

#endif
