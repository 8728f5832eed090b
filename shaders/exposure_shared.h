/* SPDX-License-Identifier: MIT */
/** What automatic exposure counts pixels in, on the GPU and on the CPU. */
#ifndef FNL_SHADERS_EXPOSURE_SHARED_H
#define FNL_SHADERS_EXPOSURE_SHARED_H

#define METER_BINS 256u /* of log2 luminance, from -20 to +20 */
#define METER_LOW -20.0
#define METER_HIGH 20.0

#endif
