/* SPDX-License-Identifier: MIT */
/**
 * Layers of a surface, as shaders/layers.glsl describes them: KHR_materials_anisotropy, _iridescence, _sheen, _clearcoat, _transmission, _volume,
 * _dispersion and _diffuse_transmission. Functions that take a surface allow one without layers, unless they say otherwise.
 */
#ifndef FNL_RAY_LAYERS_H
#define FNL_RAY_LAYERS_H

#include "ray/albedos.h"
#include "ray/microfacet.h"

struct scene_material;

/**
 * Factor that scales a light by the geometric normal: 0 behind the triangle, 1 where both normals agree, smooth in between.
 * Matches brdf_facing() in shaders/brdf.glsl. All vectors are normalized.
 */
double ray_facing(dvec3 geometric, dvec3 normal, dvec3 to_light);

/** The numbers of a material, before textures. */
void ray_layers_numbers(const struct scene_material *material, struct ray_layers *out);
/** Fills the members of ray_layers that depend on the viewer. Call it before the functions below. */
void ray_layers_prepare(const struct ray_albedos *albedos, struct ray_surface *surface, dvec3 to_view);

/** Makes a surface conserve energy (FNL_ENERGY_CONSERVING), for a viewer. Layers are prepared. */
void ray_energy_prepare(const struct ray_albedos *albedos, struct ray_surface *surface, dvec3 to_view);

/** Fraction of uniform light that enters a dielectric, by appendix B of glTF. */
double ray_energy_below(dvec3 f0, double f90, double n_v);

/** The part of the light in the base that its own color reflects; the rest passes through. */
double ray_opaque_part(const struct ray_surface *surface);
/** The part of the light that gets below the layers over the base. */
double ray_below_layers(const struct ray_surface *surface);
/** Applies the film to the reflectances of the base, `dielectric` and `metal`. */
void ray_film_over(const struct ray_surface *surface, dvec3 *dielectric, dvec3 *metal);
/** f cos of the surface with its layers; `base`: f cos of its base; `h` halves the angle. Only for surfaces with layers. */
dvec3 ray_layers_over(const struct ray_surface *surface, dvec3 to_view, dvec3 to_light, dvec3 h, dvec3 base);

/** Whether light from below shines through. */
bool ray_lets_through(const struct ray_surface *surface);
/** f cos of light from below. Only for surfaces with layers. */
dvec3 ray_behind_cos(const struct ray_surface *surface, dvec3 to_view, dvec3 to_light);
/** The part of the light from behind that the base lets through at a microfacet (KHR_materials_transmission). Only for surfaces with layers. */
dvec3 ray_through_weight(const struct ray_surface *surface, dvec3 to_view, dvec3 microfacet);

/** How light directions are sampled: `coat` by the coat's lobe, `even` uniformly over the hemisphere, `behind`: probability of diffuse light from below. */
struct ray_layer_lobes {
    struct ray_mirror coat;
    double coat_share, even_share, behind_share;
};
struct ray_layer_lobes ray_layer_lobes(const struct ray_surface *surface);

/** The lobe of fibers; n_l, n_v, n_h: cosines of the light, the viewer and the vector halfway between. */
double ray_sheen_lobe(double roughness, double n_l, double n_v, double n_h);
/** Ambient light from a direction. */
dvec3 ray_sky(dvec3 direction, dvec3 sky, dvec3 ground);
/** ray_ambient() by albedos: for surfaces with layers, and those that conserve energy. */
dvec3 ray_layers_ambient(const struct ray_albedos *albedos, const struct ray_surface *surface, dvec3 to_view, dvec3 sky, dvec3 ground);

#endif
