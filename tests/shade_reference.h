/* SPDX-License-Identifier: MIT */
/**
 * Shading in double precision by the CPU's tracer (src/ray), which is written from the specifications and not from the shaders; for tests.
 */
#ifndef FNL_TESTS_SHADE_REFERENCE_H
#define FNL_TESTS_SHADE_REFERENCE_H

#include "fanal/renderer.h"

struct reference_surface {
    double position[3], normal[3]; /* world space, unit */
    double geometric[3];           /* the same; 0: `normal` */
    double base_color[3];
    double metallic, roughness, occlusion;
    double emissive[3];
    double ior, specular, specular_color[3];
};

struct reference_surface reference_surface_default(void);
/** Outgoing radiance towards the unit vector `to_view`, in cd/m^2. */
void reference_shade(const struct reference_surface *surface, const double to_view[3], const fnl_light_params *lights,
                     uint32_t light_count, fnl_vec3 ambient_sky, fnl_vec3 ambient_ground, double out[3]);

/** Tone mapping of exposed radiance; not yet clamped to 0..1. */
void reference_tonemap(fnl_tonemap tonemap, const double in[3], double out[3]);
/** Clamps to 0..1 and encodes. */
double reference_srgb(double linear);

#endif
