/* SPDX-License-Identifier: MIT */
/** Contact shadows of a view. */
#ifndef FNL_RENDER_SHADOWS_CONTACT_H
#define FNL_RENDER_SHADOWS_CONTACT_H

#include "render/frame_state.h"

/** Gives the view's lighting its depth, if the frame has contact shadows: lightings that are made afterwards have them. After what is drawn before lists. */
void shadow_contact_add(struct frame_state *f);

#endif
