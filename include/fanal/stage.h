/* SPDX-License-Identifier: MIT */
/**
 * The stage: light, a floor and a background for scenes that have none. It belongs to the frame, or to the traced
 * picture, not to the scene: queries, bounds, fnl_scene_save, FNL_OUTPUT_OBJECT and framing cameras ignore it.
 *
 * The defaults show any model well: a studio if the scene has no light, a studio fill if it has only lights, a floor that
 * catches shadows, and a calm background. They cost one environment cube map, one shadow map and one blended
 * disk. Turn the stage off for scenes that are meant to be dark, or if your program draws the surroundings itself.
 * docs/techniques/stage.md describes the values.
 */
#ifndef FANAL_STAGE_H
#define FANAL_STAGE_H

#include "fanal/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Maximum number of lights for which the studio fills in shadows. With more lights the studio is off. */
#define FNL_STUDIO_FILL_LIGHTS 1024

/**
 * The floor: a gray disk under the scene's bounds, which fades toward its edge. It receives shadows, casts none, and is
 * invisible from below.
 */
typedef enum fnl_ground {
    FNL_GROUND_OFF = 0,
    FNL_GROUND_ON,
    FNL_GROUND_AUTO, /**< on in the studio, unless triangles at the scene's bottom cover half of its area */
    FNL_GROUND_COUNT
} fnl_ground;

/** What a frame shows where there is no surface. */
typedef enum fnl_background {
    FNL_BACKGROUND_AUTO = 0, /**< gradient with the studio, otherwise scene */
    FNL_BACKGROUND_SCENE,    /**< the environment, unless fnl_environment_params.background is false; then, and with the studio, fnl_scene_set_background */
    FNL_BACKGROUND_GRADIENT, /**< gray, darker toward the zenith, by the environment's mean luminance, else 1 cd/m^2 */
    FNL_BACKGROUND_BLUR,     /**< the environment, blurred by `background_blur`; without one as scene */
    FNL_BACKGROUND_COUNT
} fnl_background;

#ifdef __cplusplus
}
#endif
#endif
