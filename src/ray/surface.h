/* SPDX-License-Identifier: MIT */
/** The surface where a ray hits a triangle, as lighting needs it. */
#ifndef FNL_RAY_SURFACE_H
#define FNL_RAY_SURFACE_H

#include "ray/dvec.h"
#include "scene/material_layers.h"

/* The layers of a surface: the numbers of material_layers.h times their textures, and values derived from them. */
struct ray_layers {
#define SCALAR(id, ...) double id;
#define COLOR(id, ...) dvec3 id;
    MATERIAL_LAYER_NUMBERS(SCALAR, COLOR)
#undef SCALAR
#undef COLOR
    dvec3 clearcoat_normal; /* unit, on the viewer's side */
    double film_thickness;  /* nanometers */
    dvec3 absorption;       /* per meter; thickness 0: a sheet, else rays go through the mesh */
    double ior;
    dvec3 tangent; /* unit, at right angles to the normal: along it highlights are stretched */
    /* For one viewer (ray_layers_prepare): the parts of light that get below the coat and the fibres, and what the film reflects. */
    double below_coat, below_sheen;
    dvec3 film_dielectric, film_metal;
};

struct ray_surface {
    dvec3 position, normal; /* world space; the shading normal, unit, on the viewer's side */
    dvec3 geometric;        /* the triangle's normal, unit, on the viewer's side */
    dvec3 base_color, emissive;
    double alpha; /* coverage; 1 unless the material blends */
    double metallic, roughness, occlusion;
    double offset; /* how far off it rays have to start so that rounding does not make them hit it, meters */
    dvec3 f0;      /* reflectance of the dielectric part along the normal */
    double f90;    /* and at grazing angles */
    uint32_t light_mask; /* lights that share a bit with it affect the surface */
    bool layered;  /* `layers` is valid */
    struct ray_layers layers;
    bool lamps_shine_through; /* rays to lamps go straight through sheets and volumes: these send none of that light themselves */
    /* FNL_ENERGY_CONSERVING, for one viewer (ray_energy_prepare): the part of the light that gets below the dielectric surface, and the diffuse
       reflectance of light that is reflected more than once between microfacets. */
    bool conserving;
    double below;
    dvec3 between;
};

#endif
