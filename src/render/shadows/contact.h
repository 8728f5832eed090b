/* SPDX-License-Identifier: MIT */
/** Contact shadows of a view. */
#ifndef FNL_RENDER_SHADOWS_CONTACT_H
#define FNL_RENDER_SHADOWS_CONTACT_H

#include "render/frame_state.h"

/** Adds the view's depth to its lighting if the frame has contact shadows. Call it after the passes that come before lists, and before lighting_add(). */
void shadow_contact_add(struct frame_state *f);

#endif
