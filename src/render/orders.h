/* SPDX-License-Identifier: MIT */
/**
 * The shading orders' own functions, one file per family (order_*.c); shading.c calls them by its table. Each declares lists and
 * opaque surfaces and fills f->radiance; f->depth is complete with `prepass`. `input` is a copy that the order may change.
 */
#ifndef FNL_RENDER_ORDERS_H
#define FNL_RENDER_ORDERS_H

#include "passes/shade/volumes.h"
#include "render/frame_state.h"

void order_forward(struct frame_state *f, struct shade_input *input, bool prepass);
void order_deferred(struct frame_state *f, struct shade_input *input, bool prepass);
void order_volumes(struct frame_state *f, struct shade_input *input, bool prepass);
void order_light_prepass(struct frame_state *f, struct shade_input *input, bool prepass);
void order_pre_lighting(struct frame_state *f, struct shade_input *input, bool prepass);
void order_inferred(struct frame_state *f, struct shade_input *input, bool prepass);
void order_light_indexed(struct frame_state *f, struct shade_input *input, bool prepass);
void order_zioma(struct frame_state *f, struct shade_input *input, bool prepass);
void order_low_res(struct frame_state *f, struct shade_input *input, bool prepass);
void order_visibility(struct frame_state *f, struct shade_input *input, bool prepass);
void order_virtual_texturing(struct frame_state *f, struct shade_input *input, bool prepass);
void order_texturing(struct frame_state *f, struct shade_input *input, bool prepass);
void order_coarse(struct frame_state *f, struct shade_input *input, bool prepass);
void order_dais(struct frame_state *f, struct shade_input *input, bool prepass);
void order_mobile(struct frame_state *f, struct shade_input *input, bool prepass);

/* ---- what they share ---- */

/** Whether the scene has blended surfaces. */
bool order_has_blend(const struct frame_state *f);
/** Makes the frame's lists; `depth` (id 0: none yet) and `gbuffer` (or NULL) are what they may look at. */
void order_add_lists(struct frame_state *f, graph_image depth, const struct gbuffer *gbuffer);
/** Makes lists beside those of the frame, for pixels that those do not serve. */
struct light_list order_add_fallback_lists(struct frame_state *f);
/** The local lights' volumes of a shape of volumes_shared.h. */
struct volumes order_prepare_volumes(struct frame_state *f, uint32_t shape);
/** The lights in view are those whose volumes are drawn, where no lists count them. */
void order_count_volumes(struct frame_state *f, const struct volumes *volumes);
/** Whether lists of batches, or a pass per light, draw the opaque set in an order of their own. */
bool order_draws_batches(const struct frame_state *f);
bool order_draws_per_light(const struct frame_state *f);

#endif
