/* SPDX-License-Identifier: MIT */
/** The surroundings of a scene (fanal/environment.h). */
#ifndef FNL_SCENE_ENVIRONMENT_H
#define FNL_SCENE_ENVIRONMENT_H

#include "fanal/environment.h"
#include "base/base.h"
#include "base/maths.h"

#define ENVIRONMENT_LIGHTS_MAX 8u

/** A panorama: RGB floats, cd/m^2, finite, not negative. */
struct panorama {
    uint32_t width, height;
    float *texels;
};

/** A bright source that was parted off: what it gives at right angles, in lux, the direction to it, and half the angle that it fills. */
struct panorama_source {
    vec3 illuminance, direction;
    float half_angle;
};

/** What the light of a file (EXT_lights_image_based) says, as the animation has it now. */
struct scene_environment_own {
    quat rotation;
    float intensity;
    uint32_t light; /* which of the file's; SCENE_NONE: the picture is no file's */
};

struct scene_environment {
    struct panorama panorama; /* width 0: there is none; without the sources */
    float unit;               /* a power of two, cd/m^2: divided by it the panorama fits half floats (panorama_unit) */
    struct panorama_source sources[ENVIRONMENT_LIGHTS_MAX];
    uint32_t source_count;
    fnl_light_id lights[ENVIRONMENT_LIGHTS_MAX]; /* of the sources */
    char *name;                                  /* params.source, or NULL */
    float rotation, intensity;                   /* of the params: on top of the file's own */
    struct scene_environment_own own;
    bool background, parted, compressed;
    bool staged; /* the stage's studio: public calls find no environment */
    bool animated; /* something of `own` is new: scene_environment_moved() */
    uint64_t max_memory; /* of the params */
    uint64_t version; /* of the panorama */
};

void panorama_finish(const fnl_host *host, struct panorama *p);
/**
 * One of fanal/environment.h, by what follows "builtin:". `apart`: its light or sun is in `source`, if it has one, rather than in the picture.
 * FNL_ERROR_UNSUPPORTED where there is none of that name.
 */
fnl_result panorama_make(const fnl_host *host, const char *name, bool apart, struct panorama *out, struct panorama_source *source, uint32_t *source_count);
/** The luminance of all directions, times their solid angles. */
double panorama_flux(const struct panorama *p);
/** The power of two by which values are divided for half floats: the greatest then lies in 32752 .. 65504, so dim values keep their bits too. */
float panorama_unit(const struct panorama *p);
/** The direction of a texel's centre, and which texel (fractional, from the first one's centre) a unit direction is at. */
vec3 panorama_direction(const struct panorama *p, float x, float y);
void panorama_place(const struct panorama *p, vec3 direction, float *x, float *y);
/** Parts small bright sources off; returns how many. FNL_ERROR_MEMORY leaves all as it was. */
fnl_result panorama_part(const fnl_host *host, struct panorama *p, struct panorama_source out[ENVIRONMENT_LIGHTS_MAX], uint32_t *count);
/** Averages 2 x 2 texels while it is wider than this. After FNL_ERROR_MEMORY it is empty. */
fnl_result panorama_shrink(const fnl_host *host, struct panorama *p, uint32_t most_width);

/** Surrounds the scene by a file's light. */
fnl_result scene_set_own_environment(fnl_scene *scene, const fnl_environment_params *params, const struct scene_environment_own *own);
/** Rows of the matrix that brings directions into the axes of the picture, and what its values are multiplied by. */
void scene_environment_axes(const struct scene_environment *environment, vec3 out[3]);
float scene_environment_scale(const struct scene_environment *environment);
/** After changes of `own`: turns and scales its lights. */
void scene_environment_moved(fnl_scene *scene);
void scene_environment_finish(fnl_scene *scene);

#endif
