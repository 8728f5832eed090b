/* SPDX-License-Identifier: MIT */
/** Debug views of the G-buffer: it is read as lighting reads it, not drawn anew. */
#ifndef FNL_PASSES_GBUFFER_VIEW_H
#define FNL_PASSES_GBUFFER_VIEW_H

#include "passes/shade/gbuffer.h"
#include "passes/shade/gbuffer_view_shared.h"

/** One field (GBUFFER_SEEN_…) over the whole picture. */
void gbuffer_view_field_add(struct graph *graph, const struct gbuffer *gbuffer, uint32_t field, graph_image target,
                            bool swap);
/** All fields of a render target, below gbuffer->target_count: a quarter of the picture each, in the order of fnl_gbuffer_info, if there are
 *  several. */
void gbuffer_view_target_add(struct graph *graph, const struct gbuffer *gbuffer, uint32_t index, graph_image target,
                             bool swap);

#endif
