/* SPDX-License-Identifier: MIT */
/** The eyes of a head as one: its common frustum, and its middle. */
#ifndef FNL_RENDER_EYES_H
#define FNL_RENDER_EYES_H

#include "base/maths.h"
#include "fanal/scene.h"
#include "view_shared.h"

/**
 * A view that sees all that any of the eyes sees, whatever their fields and directions: its apex lies behind them. `margin`: radians that it reaches
 * farther on each side, so that it still does if the head turns by that about any axis. Its pixels take about the angle that those of the eyes do. False: there is none, as eyes are
 * orthographic or look too far apart.
 */
bool eyes_combine(const struct gpu_view *eyes, uint32_t count, float margin, struct gpu_view *out);

/**
 * A camera in the middle of the head that sees all that any of the eyes sees from `distance` meters on; its near plane is nearer by `overlap` times that. Its
 * pixels are those of the first eye for things at infinity, moved by whole ones. False: there is none, as above.
 */
bool eyes_middle(const struct gpu_view *eyes, uint32_t count, float distance, float overlap, fnl_camera *out, uint32_t *width, uint32_t *height);

/**
 * The part of a combined view nearer than `distance` meters from the eyes. This plane replaces the near plane, which
 * culls almost nothing.
 */
struct gpu_view eyes_before(const struct gpu_view *head, const struct gpu_view *eyes, uint32_t count, float distance);

#endif
