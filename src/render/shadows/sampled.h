/* SPDX-License-Identifier: MIT */
/** Shadow rays for some of a pixel's lights, chosen by chance: guided by earlier frames, and denoised. */
#ifndef FNL_RENDER_SHADOWS_SAMPLED_H
#define FNL_RENDER_SHADOWS_SAMPLED_H

#include "render/frame_state.h"

/** What guides this frame, for shade_input.guide; before its surfaces are shaded. */
struct shade_guide shadow_sampled_guide(struct frame_state *f);
/** Adds to f->radiance what the order kept apart, denoised. */
void shadow_sampled_denoise(struct frame_state *f, const struct shade_apart *apart);

#endif
