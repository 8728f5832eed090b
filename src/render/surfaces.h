/* SPDX-License-Identifier: MIT */
/** Which kinds of surfaces the scene of a frame has, and what holds them. */
#ifndef FNL_RENDER_SURFACES_H
#define FNL_RENDER_SURFACES_H

#include "render/frame_state.h"

/** Whether there are blended surfaces. */
bool surfaces_have_blend(const struct frame_state *f);
/** Whether there are transmissive surfaces. */
bool surfaces_have_glass(const struct frame_state *f);
/**
 * Which opaque surfaces are drawn forward over the path's picture: GEOMETRY_LAYERED, if it shades no layers (that includes those with a light mask);
 * GEOMETRY_MASKED, if it does not know the item; 0: none.
 */
uint32_t surfaces_over(const struct frame_state *f);
/** The layout of the frame's G-buffer: the default becomes FNL_GBUFFER_LAYERS where that holds more of the scene. */
fnl_gbuffer surfaces_layout(const struct frame_state *f);

#endif
