/* SPDX-License-Identifier: MIT */
/** From radiance to a picture on the CPU, as frames do it: exposure, tone mapping, sRGB. */
#ifndef FNL_RAY_TONE_H
#define FNL_RAY_TONE_H

#include "fanal/frame.h"
#include "ray/dvec.h"

/** Tone mapping of exposed radiance; not yet clamped to 0..1. */
dvec3 ray_tone_map(fnl_tonemap tonemap, dvec3 color);
/** Clamps to 0..1 and encodes (IEC 61966-2-1). */
double ray_srgb(double linear);
/** The EV100 that a frame meters from RGBA pixels of radiance (exposure_shared.h); `surfaces`: 0 where a pixel shows the background. */
double ray_meter(const float *pixels, const uint8_t *surfaces, uint32_t width, uint32_t height);
/** What radiance is multiplied with at an EV100. */
double ray_exposure(double ev);

#endif
