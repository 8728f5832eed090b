/* SPDX-License-Identifier: MIT */
/** What the files of ray_scene.h share. */
#ifndef FNL_RAY_RAY_INTERNAL_H
#define FNL_RAY_RAY_INTERNAL_H

#include "ray/embree.h"
#include "ray/ray_scene.h"

/* A primitive as it is posed: shared by all nodes that do not deform it. */
struct ray_part {
    const struct scene_primitive *primitive;
    const struct scene_material *material;
    const vec3 *positions, *normals; /* the primitive's, or `posed` */
    const vec4 *tangents;
    void *posed; /* owned; or NULL */
    size_t posed_size;
    struct ray_scene *scene;
    uint32_t index; /* of itself */
};

/* Parts under one transform; a scene of Embree's. */
struct ray_mesh {
    RTCScene handle;
    uint32_t first_part, part_count;
};

struct ray_instance {
    uint32_t mesh;
    mat4 matrix;
    dvec3 axes[3], origin; /* columns of the matrix */
    dvec3 cofactors[3];    /* columns that carry normals */
    double mirror;         /* -1 where it mirrors */
    uint32_t light_mask, view_mask; /* lights, cameras that share a bit affect it, show it */
    uint32_t first_glow;   /* into ray_scene.glows, one for each part of the mesh; SCENE_NONE: nothing of it glows */
};

/* A triangle of a surface that glows. */
struct ray_emitter {
    uint32_t instance, part, triangle;
    double end;     /* chances, added up */
    double density; /* chance per square metre */
};

struct ray_scene {
    const fnl_scene *scene;
    RTCDevice device;
    RTCScene handle;
    struct ray_image *images;
    struct scene_material standard;
    struct ray_environment environment;
    bool conserving;
    struct ray_albedos albedos; /* where there is an environment, or a material with layers, or `conserving` */
    ARRAY(struct ray_part) parts;
    ARRAY(struct ray_mesh) meshes;
    ARRAY(struct ray_instance) instances;
    uint32_t unseen;
    bool masks_views; /* some instance has a view mask */
    ARRAY(struct ray_light) lights; /* directional ones first */
    uint32_t sun_count;
    ARRAY(struct ray_emitter) emitters;
    ARRAY(uint32_t) glows; /* the first emitter of a part of an instance: one for each triangle; SCENE_NONE: none */
    RTCScene light_tree; /* boxes of the others; NULL where they are few */
};

/** How filters of Embree see the surfaces of a part: those of rays that look for the nearest one, and of shadow rays (ray_scene.c). */
void ray_filter_nearest(const struct RTCFilterFunctionNArguments *arguments);
void ray_filter_shadow(const struct RTCFilterFunctionNArguments *arguments);

/** Fills in all but the lights (ray_build.c). */
fnl_result ray_scene_build(struct ray_scene *scene, struct jobs *jobs);
/** The last error of Embree, logged. */
fnl_result ray_scene_check(const struct ray_scene *scene);

/** The lights, and the tree over them (ray_lights.c). */
fnl_result ray_lights_create(struct ray_scene *scene);
void ray_lights_destroy(struct ray_scene *scene);

/** The surfaces that glow (ray_emitters.c). */
fnl_result ray_emitters_create(struct ray_scene *scene);
void ray_emitters_destroy(struct ray_scene *scene);
/** Corners in the world, and about what luminance the triangle sends (ray_surface.c). */
void ray_corners(const struct ray_part *part, const struct ray_instance *instance, uint32_t triangle, dvec3 out[3]);
double ray_glow(const struct ray_part *part, uint32_t triangle);

/**
 * What of a triangle covers the point: 0 in the holes of cutouts, less than 1 where it blends (ray_surface.c). `neighbours` as in ray_find; without
 * them `instance` may be NULL.
 */
double ray_coverage(const struct ray_part *part, const struct ray_instance *instance, uint32_t triangle, double u, double v,
                    const struct ray_neighbours *neighbours);
/** What part of the light the material lets through there, 0 unless it is transmissive. */
double ray_transmission(const struct ray_part *part, uint32_t triangle, double u, double v);

#endif
