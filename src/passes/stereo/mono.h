/* SPDX-License-Identifier: MIT */
/**
 * The mono/stereo hybrid (Palandri and Green, "Hybrid Mono Rendering in UE4 and Unity", 2016): what lies beyond a plane at right angles to the head's
 * view is drawn once, from the middle between the eyes, and put behind what each eye sees before it. The view of it is a perspective one whose near
 * plane lies MONO_OVERLAP nearer than the plane; eyes draw against the plane, which is put into their depth first. One sample a pixel. Cost: three passes
 * over the pixels of each eye, two over those of the mono view.
 */
#ifndef FNL_PASSES_MONO_H
#define FNL_PASSES_MONO_H

#include "graph/graph.h"
#include "passes/stereo/mono_shared.h"

/** An eye, or with distance 0 the mono view itself: addresses of structs gpu_view. */
struct mono_eye {
    VkDeviceAddress eye, mono;
    float distance; /* of the plane, metres */
};

/** Clears the depth of an eye to the plane. */
void mono_plane_add(struct graph *graph, const char *name, const struct mono_eye *eye, graph_image depth);
/** Clears the depth of the mono view, and fills it with the near end where all of the eyes (one after the other from `first` on), whose depths are opened, see something nearer. */
void mono_block_add(struct graph *graph, VkDeviceAddress mono, VkDeviceAddress first, const graph_image *depths, uint32_t count, graph_image depth);
/** A copy of depth, without what it was begun with. `counts`: MONO_COUNTS words, or id 0. */
graph_image mono_open_add(struct graph *graph, const struct mono_eye *eye, graph_image depth, graph_buffer counts);
/** Puts the finished mono view into an eye's radiance and opened depth, behind what is there. */
void mono_composite_add(struct graph *graph, const struct mono_eye *eye, graph_image mono_radiance, graph_image mono_depth, graph_image radiance, graph_image depth);

#endif
