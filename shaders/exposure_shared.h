/* SPDX-License-Identifier: MIT */
/**
 * Automatic exposure, on the GPU and on the CPU. Pixels are counted in bins of log2 luminance, surfaces and background apart, those in the
 * middle of the picture up to four times. The mean of the logarithms, without the darkest and brightest 5 %, is shown as METER_KEY, unless that
 * would push the brightest 1 % of the surfaces beyond METER_SPARE, or the brightest 10 % beyond METER_LIGHT. In the mean the background counts METER_BACKGROUND of what a surface counts.
 */
#ifndef FNL_SHADERS_EXPOSURE_SHARED_H
#define FNL_SHADERS_EXPOSURE_SHARED_H

#define METER_BINS 256u /* of log2 luminance, from -20 to +20; the first holds black, which says nothing */
#define METER_LOW -20.0
#define METER_HIGH 20.0
#define METER_TRIM 0.05          /* of the weight, left out at each end of the mean */
#define METER_BRIGHT 0.99        /* of the surfaces' weight is kept below METER_SPARE */
#define METER_KEY 0.18           /* linear, 1 is white: what the mean is shown as */
#define METER_BROAD 0.90         /* of the surfaces' weight is kept below METER_LIGHT */
#define METER_LIGHT 0.5          /* light, and far from white */
#define METER_SPARE 3.0          /* what the tone mappers still tell from white */
#define METER_BACKGROUND 0.03125 /* weight of a background pixel */

/* Of a pixel, 1 .. 4, to be rounded down; across and down: -1 .. 1 from one side of the picture to the other. `nearness`: at least 0. */
#define METER_NEARNESS(across, down) (1.0 - (across) * (across) - (down) * (down))
#define METER_WEIGHT(nearness) (1.5 + 3.0 * (nearness))

#endif
