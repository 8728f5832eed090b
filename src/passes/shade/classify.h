/* SPDX-License-Identifier: MIT */
/**
 * Specialised deferred shading: blocks of 8x8 or 4x4 pixels are sorted by the parts of the shader that they need, and each class is
 * dispatched with a variant that has nothing else. Code is needed where any pixel of a block asks for it, tests are left out where all
 * pixels agree (RTR 4, 20.3; Split/Second's 4x4 classes). The picture is that of the one shader for all, to the bit. Cost: the G-buffer is
 * read once more.
 */
#ifndef FNL_PASSES_CLASSIFY_H
#define FNL_PASSES_CLASSIFY_H

#include "passes/shade/classify_shared.h"
#include "passes/shade/gbuffer.h"

struct shade_classes {
    graph_buffer sums, blocks, dispatches;
    graph_buffer counts;              /* uint[SHADE_CLASSES + 1]: blocks of each class, and those that need nothing */
    uint32_t block_size, block_count; /* 0: not classified */
};

/** `block_size` is 8 or 4. */
struct shade_classes classify_add(struct graph *graph, const struct shade_input *input, const struct gbuffer *gbuffer,
                                  uint32_t block_size);

#endif
