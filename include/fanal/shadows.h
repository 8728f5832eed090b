/* SPDX-License-Identifier: MIT */
/** Shadows: what stops light on its way. docs/techniques/shadows.md tells more. */
#ifndef FANAL_SHADOWS_H
#define FANAL_SHADOWS_H

#include "fanal/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/** How shadows are found. */
typedef enum fnl_shadows {
    FNL_SHADOWS_OFF = 0, /**< not at all: light goes through walls */
    /** A ray from each surface to each light that reaches it: exact hard shadows of all lights, through cutouts and glass. Slow with many lights. */
    FNL_SHADOWS_RAYS,
    /**
     * Shadow maps of all lights in one image of a fixed size, in pages that are made only where a pixel looks them up and are kept from frame to frame.
     * Capsules trace rays, and so do lights for which the image has no room. Blended surfaces receive shadows but cast none.
     */
    FNL_SHADOWS_MAPS,
    FNL_SHADOWS_COUNT
} fnl_shadows;

/** Settings of shadows. */
typedef struct fnl_shadow_options {
    /**
     * maps: memory of the image that holds all maps, MiB, 1 .. 1024, for each view; rounded down to a square of whole pages. Where it is too small
     * for maps as fine as the picture, those of the lights that matter least become coarser first. Default 64.
     */
    uint32_t memory;
} fnl_shadow_options;

#ifdef __cplusplus
}
#endif
#endif
