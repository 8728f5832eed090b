/* SPDX-License-Identifier: MIT */
/**
 * The stage: what a picture shows around a scene that does not bring it along. It belongs to the frame, or to the traced picture, not to the
 * scene: queries, bounds, fnl_scene_save, FNL_OUTPUT_OBJECT and framing cameras do not see it.
 *
 * The defaults show any model well: a studio if the scene has no light, a floor that catches shadows, a calm background. They cost a cube map
 * of light, one shadow map, one blended disk. Turn all of it off for scenes that are meant to be dark, and where your program draws the
 * surroundings itself. docs/techniques/stage.md shows the values.
 */
#ifndef FANAL_STAGE_H
#define FANAL_STAGE_H

#include "fanal/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/** The floor: a gray disk under the scene's bounds, which fades towards its border. It receives shadows, casts none, and is not seen from below. */
typedef enum fnl_ground {
    FNL_GROUND_OFF = 0,
    FNL_GROUND_ON,
    FNL_GROUND_AUTO, /**< on under the studio, unless the scene has a floor: triangles at its bottom that cover half of it */
    FNL_GROUND_COUNT
} fnl_ground;

/** What is seen where no surface is. */
typedef enum fnl_background {
    FNL_BACKGROUND_AUTO = 0, /**< gradient with the studio, otherwise scene */
    FNL_BACKGROUND_SCENE,    /**< the environment, unless fnl_environment_params.background is false; then, and with the studio, fnl_scene_set_background */
    FNL_BACKGROUND_GRADIENT, /**< gray, darker towards the zenith, by the mean luminance of the environment; without one by 1 cd/m^2 */
    FNL_BACKGROUND_BLUR,     /**< the environment, blurred by `background_blur`; without an environment as scene */
    FNL_BACKGROUND_COUNT
} fnl_background;

#ifdef __cplusplus
}
#endif
#endif
