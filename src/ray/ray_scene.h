/* SPDX-License-Identifier: MIT */
/** A scene as rays find it: posed triangles in world space, what they are made of, and which lights shine. It is a snapshot. */
#ifndef FNL_RAY_SCENE_H
#define FNL_RAY_SCENE_H

#include "fanal/energy.h"
#include "ray/brdf.h"
#include "ray/environment.h"
#include "ray/light.h"
#include "ray/texture.h"

struct ray_scene;

/** `scene` must stay as it is until the end. */
fnl_result ray_scene_create(const fnl_scene *scene, fnl_energy energy, struct jobs *jobs, struct ray_scene **out);
void ray_scene_destroy(struct ray_scene **scene);

const fnl_host *ray_scene_host(const struct ray_scene *scene);
/** Ambient light from above and below, and what is seen behind everything. */
void ray_scene_surroundings(const struct ray_scene *scene, dvec3 *sky, dvec3 *ground, dvec3 *background);
/** Light from all around; in place of ambient light and background where there is one. */
const struct ray_environment *ray_scene_environment(const struct ray_scene *scene);
/** Lines, points and decals that rays do not see. */
uint32_t ray_scene_unseen(const struct ray_scene *scene);

/** A place on a triangle; `uv` are its weights of corners 1 and 2. */
struct ray_hit {
    uint32_t instance, part, triangle;
    double u, v, distance;
    bool front; /* seen from the side from which its corners run anticlockwise */
};

/** What a ray sees of a surface: which side of it, and whether coverage is a matter of chance. */
enum ray_kind {
    RAY_CAMERA, /* not the backs of single-sided materials; blended surfaces on the way are listed */
    RAY_PATH,   /* both sides; a blended surface stops it by the chance of its coverage */
    RAY_THROUGH, /* of what is seen through a surface: sides as for the camera, blended surfaces as for paths */
    RAY_LAMP,    /* to a lamp: both sides; goes straight through what is transmissive, and through what casts no shadows */
};

/** Working memory of one thread. */
struct ray_walk {
    ARRAY(struct ray_hit) layers;  /* blended surfaces in front of the hit, the nearest first */
    ARRAY(struct ray_hit) crossed; /* by the last shadow ray */
    uint64_t ray_count;
    ARRAY(uint32_t) lights; /* of ray_scene_find_lights */
    uint32_t unseen;        /* bits that the camera's view mask lacks: rays of the kinds CAMERA and THROUGH pass instances that have no others */
    bool failed;            /* memory ran out */
    uint64_t key;           /* RAY_PATH, RAY_THROUGH: of the chances */
};

/** Neighbours of a camera's ray, one pixel to the right and one down, which textures are filtered by. */
struct ray_neighbours {
    dvec3 origin[2], direction[2];
};

/** Which lights may reach a point: walk->lights, ascending. All others do not. */
void ray_scene_find_lights(const struct ray_scene *scene, dvec3 position, struct ray_walk *walk);
const struct ray_light *ray_scene_light(const struct ray_scene *scene, uint32_t index);

/** The nearest surface at low < distance < high that is not blended; `direction` is unit. `neighbours` NULL: textures of
    cutouts are sampled without a footprint. */
bool ray_find(const struct ray_scene *scene, enum ray_kind kind, dvec3 origin, dvec3 direction, double low, double high,
              const struct ray_neighbours *neighbours, struct ray_walk *walk, struct ray_hit *hit);
/** The part of light that gets from the origin along a unit direction to `distance`: cutouts let through what is cut, blended surfaces what they do
    not cover. Every surface has two sides. `kind`: RAY_LAMP, or RAY_PATH for the chance that a path gets there straight. */
double ray_visibility(const struct ray_scene *scene, enum ray_kind kind, dvec3 origin, dvec3 direction, double distance, struct ray_walk *walk);

/** A point of a surface that glows, for paths to be sent to. */
struct ray_emitter_point {
    struct ray_hit hit; /* distance and front: not yet */
    dvec3 position, geometric; /* the triangle's unit normal, on either side */
    double density;            /* per square metre */
};
/** Chooses one by three numbers in [0, 1), by the light that triangles send; false: there is none. */
bool ray_emitters_sample(const struct ray_scene *scene, const double random[3], struct ray_emitter_point *out);
/** The density per square metre with which it chooses the points of a triangle; 0: it is never chosen. */
double ray_emitters_density(const struct ray_scene *scene, const struct ray_hit *hit);
/** What the surface covers of what is behind it, 0 .. 1. */
double ray_scene_coverage(const struct ray_scene *scene, const struct ray_hit *hit);

/** The surface at a hit. `neighbours` as in ray_find. */
struct ray_surface ray_surface_at(const struct ray_scene *scene, const struct ray_hit *hit, dvec3 origin, dvec3 direction,
                                  const struct ray_neighbours *neighbours);
/** How much Embree may be off, which takes floats and carries rays into the space of instances, where coordinates are as great as `reach`; metres. */
static inline double ray_rounding(double reach) { return reach * 0x1p-20; }

#endif
