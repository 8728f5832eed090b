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

/** The numbers of a material, before textures. */
void ray_layers_numbers(const struct scene_material *material, struct ray_layers *out);
/** Fills what layers depend on for one viewer; for surfaces with layers before all that follows. */
void ray_layers_prepare(const struct ray_albedos *albedos, struct ray_surface *surface, dvec3 to_view);

/** The part of the light in the base that its own color reflects: the rest goes through. */
double ray_opaque_part(const struct ray_surface *surface);
/** The part of the light that gets below the layers over the base. */
double ray_below_layers(const struct ray_surface *surface);
/** Colors what the base reflects: `dielectric` and `metal` with the film. */
void ray_film_over(const struct ray_surface *surface, dvec3 *dielectric, dvec3 *metal);
/** What leaves the surface in place of `base`, which is f cos of its base; `h` halves the angle. With layers only. */
dvec3 ray_layers_over(const struct ray_surface *surface, dvec3 to_view, dvec3 to_light, dvec3 h, dvec3 base);

/** Whether light from below shines through. */
bool ray_lets_through(const struct ray_surface *surface);
/** f cos of light from below; with layers only. */
dvec3 ray_behind_cos(const struct ray_surface *surface, dvec3 to_view, dvec3 to_light);
/** The part of what is behind that the base shows (KHR_materials_transmission) along a normal of its microfacets. With layers only. */
dvec3 ray_through_weight(const struct ray_surface *surface, dvec3 to_view, dvec3 microfacet);

/** How directions of light are chosen: `coat` mirrors, `even` are all over the hemisphere, `behind` is the chance of diffuse light from below. */
struct ray_layer_lobes {
    struct ray_mirror coat;
    double coat_share, even_share, behind_share;
};
struct ray_layer_lobes ray_layer_lobes(const struct ray_surface *surface);

/** The lobe of fibres; cosines of light and viewer, and of the vector between them. */
double ray_sheen_lobe(double roughness, double n_l, double n_v, double n_h);
/** Ambient light from a direction. */
dvec3 ray_sky(dvec3 direction, dvec3 sky, dvec3 ground);
/** Of a surface with layers, as ray_ambient(), by albedos. */
dvec3 ray_layers_ambient(const struct ray_albedos *albedos, const struct ray_surface *surface, dvec3 to_view, dvec3 sky, dvec3 ground);

#endif
