/* SPDX-License-Identifier: MIT */
/** The cube maps of the scene's probes (passes/shadow/cubemap.h): kept by each renderer until what they show changes. */
#ifndef FNL_RENDER_PROBES_H
#define FNL_RENDER_PROBES_H

#include "render/frame_state.h"

/** Outside of frames, after device_rays_prepare(), for frames with FNL_SHADOWS_CUBEMAP. */
fnl_result probes_prepare(fnl_renderer *r);
/** Then, in the frame, once its rays are declared: bakes what has changed, and gives the lights their probes. */
void probes_add(struct frame_state *shared, struct device_scene_frame *scene);
/** The counters of a view. */
void probes_note(struct frame_state *f);

#endif
