/* SPDX-License-Identifier: MIT */
/**
 * Light on a surface in double precision, from the specifications: the BRDF of glTF 2.0, appendix B, with KHR_materials_ior and
 * KHR_materials_specular; over it, as shaders/layers.glsl describes, KHR_materials_anisotropy, _iridescence, _sheen and _clearcoat.
 */
#ifndef FNL_RAY_BRDF_H
#define FNL_RAY_BRDF_H

#include "ray/dvec.h"

/* What lies over the material, or changes how it mirrors. */
struct ray_layers {
    double clearcoat, clearcoat_roughness;
    dvec3 clearcoat_normal; /* unit, on the viewer's side */
    dvec3 sheen_color;
    double sheen_roughness;
    double film, film_ior, film_thickness; /* nanometres */
    double transmission, thickness; /* thickness: 0: a sheet; else rays go through the mesh */
    dvec3 absorption;               /* per metre */
    double ior, dispersion;
    double diffuse_transmission;
    dvec3 diffuse_transmission_color;
    double anisotropy;
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
    double offset; /* how far off it rays have to start so that rounding does not make them hit it, metres */
    dvec3 f0;      /* reflectance of the dielectric part along the normal */
    double f90;    /* and at grazing angles */
    uint32_t light_mask; /* lights that share a bit with it affect the surface */
    bool layered;  /* the next holds */
    struct ray_layers layers;
    bool lamps_shine_through; /* rays to lamps go straight through sheets and volumes: these send none of that light themselves */
    dvec3 again;   /* diffuse reflectance besides, for light of paths: ray_environment_again(); else 0 */
};

/** Reflectance along the normal for an index of refraction, before colour and strength; an index of 0 reflects everything (KHR_materials_ior). */
double ray_ior_reflectance(double ior);
/** Side of ray_albedos. */
enum { RAY_ALBEDO_SIDE = 33 };
/** What lobes reflect of the same light from everywhere, by roughness and the cosine of the viewer, both 0 .. 1. */
struct ray_albedos {
    float specular[RAY_ALBEDO_SIDE][RAY_ALBEDO_SIDE][2]; /* f0 times the first and f90 times the second */
    float sheen[RAY_ALBEDO_SIDE][RAY_ALBEDO_SIDE];       /* of white fibres */
};
void ray_albedos_fill(struct ray_albedos *out);
/** Fills what layers depend on for one viewer; for surfaces with layers before all that follows. */
void ray_layers_prepare(const struct ray_albedos *albedos, struct ray_surface *surface, dvec3 to_view);
/** Of a coat of varnish, index of refraction 1.5, the part that it reflects. */
double ray_coat_albedo(const struct ray_albedos *albedos, double roughness, double n_v);
void ray_specular_albedo(const struct ray_albedos *albedos, double roughness, double n_v, double out[2]);

/** f(l, v) times the cosine; 0 for light from below, unless some goes through the surface, as through a sheet. The smallest alpha is 0.001, so that mirrors show point lights. */
dvec3 ray_brdf_cos(const struct ray_surface *surface, dvec3 to_view, dvec3 to_light);
/**
 * What a surface sends of ambient light that nothing shadows: the light blends from ground to sky by height; the reflected part comes from the
 * mirror direction, through the fit of the environment integral by Karis ("Physically Based Shading on Mobile", 2014).
 */
dvec3 ray_ambient(const struct ray_surface *surface, dvec3 to_view, dvec3 sky, dvec3 ground);
/** The same of a surface with layers, by albedos. */
dvec3 ray_layers_ambient(const struct ray_albedos *albedos, const struct ray_surface *surface, dvec3 to_view, dvec3 sky, dvec3 ground);
/** Ambient light from a direction. */
dvec3 ray_sky(dvec3 direction, dvec3 sky, dvec3 ground);

/** Whether light from below shines through. */
bool ray_lets_through(const struct ray_surface *surface);
/** The part of what is behind that the base shows (KHR_materials_transmission) along a normal of its microfacets. */
dvec3 ray_through_weight(const struct ray_surface *surface, dvec3 to_view, dvec3 microfacet);
/** A microfacet that the viewer sees, by two numbers in [0, 1); `shadowed`: the part of what it mirrors or refracts that gets away. */
dvec3 ray_microfacet_sample(const struct ray_surface *surface, dvec3 to_view, const double random[2]);

/**
 * Chooses a direction from which light may come, by three numbers in [0, 1): returns f cos / density for it, 0 where there is none. The lobes are
 * chosen by their reflectance; normals of the specular one follow Heitz, "Sampling the GGX Distribution of Visible Normals", 2018.
 * `density`: per steradian.
 */
dvec3 ray_brdf_sample(const struct ray_surface *surface, dvec3 to_view, const double random[3], dvec3 *to_light, double *density);
/** f cos of light from a direction, as ray_brdf_sample() counts it, and the density with which that would have chosen it. */
dvec3 ray_brdf_light(const struct ray_surface *surface, dvec3 to_view, dvec3 to_light, double *density);

#endif
