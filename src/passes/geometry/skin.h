/* SPDX-License-Identifier: MIT */
/**
 * Morph targets and skinning, once a frame in compute, into the vertex buffer that all passes read (glTF 2.0, 3.7.3 and 3.7.2.2).
 * Cost: one read and one write per vertex, plus its influences and targets.
 */
#ifndef FNL_PASSES_SKIN_H
#define FNL_PASSES_SKIN_H

#include "graph/graph.h"
#include "passes/geometry/skin_shared.h"

struct skin_input {
    graph_buffer vertices; /* imported; positions and attributes share its hazards */
    VkDeviceAddress positions, attributes, deforms, influences, morphs, weights, matrices;
    const uint32_t *vertex_counts; /* per deform */
    uint32_t deform_count;
};

/** Deforms all primitives; adds nothing when there are none. */
void skin_add(struct graph *graph, const struct skin_input *input);

#endif
