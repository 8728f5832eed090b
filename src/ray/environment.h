/* SPDX-License-Identifier: MIT */
/** A scene's environment in double precision: what rays see that leave the scene. */
#ifndef FNL_RAY_ENVIRONMENT_H
#define FNL_RAY_ENVIRONMENT_H

#include "ray/brdf.h"
#include "scene/scene_environment.h"

struct ray_environment {
    const struct scene_environment *scene; /* panorama.width 0: there is none */
    const struct ray_albedos *albedos;
    double mean; /* luminance of its radiance from all around, cd/m^2 */
    dvec3 axes[3]; /* rows of the matrix that brings directions into those of the picture */
    double scale;  /* of the texels */
    /* By which bright parts are chosen, of the cells between the middles of texels: NULL where none is brighter than all are in the mean. */
    struct ray_environment_row *rows; /* panorama.height + 1 */
    float *ends;                      /* of each row's cells: chances, added up */
};

struct ray_environment_row {
    double end;     /* chances of the rows, added up */
    double density; /* per steradian, of a cell that has all of its row's chance */
};

static inline bool ray_environment_is(const struct ray_environment *e) { return e->scene->panorama.width > 0; }
fnl_result ray_environment_create(const fnl_host *host, const struct scene_environment *scene, const struct ray_albedos *albedos, struct ray_environment *out);
void ray_environment_destroy(const fnl_host *host, struct ray_environment *environment);
/** Radiance from a direction, bilinear. */
dvec3 ray_environment_from(const struct ray_environment *e, dvec3 direction);
/**
 * A direction from which more than the mean comes, by two numbers in [0, 1): the more is the chance (Karlik et al., "MIS Compensation", 2019). All other
 * directions are left to the surface's own samples, so that light which is the same from everywhere has no noise. Returns its density per steradian; 0: none.
 */
double ray_environment_sample(const struct ray_environment *e, const double random[2], dvec3 *direction);
/** The density with which it returns a unit direction. */
double ray_environment_density(const struct ray_environment *e, dvec3 direction);

#endif
