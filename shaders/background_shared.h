/* SPDX-License-Identifier: MIT */
/** Backgrounds of fanal/stage.h, for frames and for rays. */
#ifndef FNL_SHADERS_BACKGROUND_SHARED_H
#define FNL_SHADERS_BACKGROUND_SHARED_H

/* Parts of the mean luminance that the gradient shows towards the zenith, at the horizon, and towards the nadir. */
#define GRADIENT_ZENITH 0.12
#define GRADIENT_HORIZON 0.38
#define GRADIENT_NADIR 0.3

/* The alpha (squared roughness) of the GGX lobe whose half maximum is as wide as an angle, given a quarter of it: tan(t) = alpha sqrt(sqrt(2) - 1). */
#define BLUR_ALPHA(quarter) (tan(quarter) / 0.6436)
#define BLUR_MOST 2.2 /* radians: alpha is 1 beyond */

#endif
