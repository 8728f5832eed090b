/* SPDX-License-Identifier: MIT */
/** The specular lobes by which rectangle lights are integrated: lighting_shared.h says what the numbers are. */
#ifndef FNL_RENDER_DEVICE_LIGHT_LOBES_H
#define FNL_RENDER_DEVICE_LIGHT_LOBES_H

#include "lighting/lighting_shared.h"

extern const float light_lobes[AREA_LOBE_ROWS * AREA_LOBE_COLUMNS * AREA_LOBE_VALUES];

#endif
