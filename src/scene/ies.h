/* SPDX-License-Identifier: MIT */
/** Light profiles: what a luminaire gives in each direction, from files of IESNA LM-63 (.ies). */
#ifndef FNL_SCENE_IES_H
#define FNL_SCENE_IES_H

#include "base/base.h"

/**
 * A regular grid over directions. The vertical angle goes from 0, along the light's direction, to pi in `rows` steps; the horizontal one from the
 * light's side towards its up and round in `columns` steps. Between its points it is bilinear in the angles.
 */
struct light_profile {
    const char *name;
    const float *values; /* [rows + 1][columns], 0 .. 1 */
    uint32_t rows, columns;
    uint32_t generation;
    uint32_t offset; /* of its place on the device, floats; above 0 */
    float candela;   /* in the brightest direction */
    struct arena memory; /* of the values and the name, if they are its own */
};

/** Floats before the values on the device: rows, columns. */
#define LIGHT_PROFILE_HEAD 2u
static inline uint32_t light_profile_floats(const struct light_profile *profile) { return LIGHT_PROFILE_HEAD + (profile->rows + 1) * profile->columns; }

/**
 * Reads LM-63-1986, -1991, -1995, -2002 and -2019, photometry of type C, B and A. `name` is for messages. Broken files are FNL_ERROR_FORMAT with one
 * log line that names the line. The values come from `arena`; offset and generation are left to the caller.
 */
fnl_result ies_read(const fnl_host *host, struct arena *arena, const char *name, const void *data, size_t size, struct light_profile *out);

/** The profile in a direction of unit length: its parts along the light's side, up and direction. */
double light_profile_at(const struct light_profile *profile, double side, double up, double along);

#endif
