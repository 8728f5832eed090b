/* SPDX-License-Identifier: MIT */
/** A scene's environment in double precision: what rays see that leave the scene, and how much of it comes back between microfacets. */
#ifndef FNL_RAY_ENVIRONMENT_H
#define FNL_RAY_ENVIRONMENT_H

#include "ray/brdf.h"
#include "scene/scene_environment.h"

struct ray_environment {
    const struct scene_environment *scene; /* panorama.width 0: there is none */
    const struct ray_albedos *albedos;
    double mean; /* luminance of its radiance from all around, cd/m^2 */
};

static inline bool ray_environment_is(const struct ray_environment *e) { return e->scene->panorama.width > 0; }
/** Radiance from a direction, bilinear. */
dvec3 ray_environment_from(const struct ray_environment *e, dvec3 direction);
/** The luminance of its radiance, averaged over all directions. */
double ray_environment_mean(const struct ray_environment *e);
/** Gives a surface what it reflects of the environment between its microfacets: surface->again (Fdez-Aguera 2019). Layers are prepared. */
void ray_environment_again(const struct ray_environment *e, struct ray_surface *surface, dvec3 to_view);

#endif
