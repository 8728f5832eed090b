/* SPDX-License-Identifier: MIT */
/**
 * Energy model of materials: the fraction of incoming light that a surface reflects in total. It holds for lights, the
 * environment, reflection probes and ambient light, in frames and in fnl_scene_trace().
 *
 * The formulas of glTF lose light on rough metals and add some to smooth dielectrics at grazing angles. Use FNL_ENERGY_GLTF
 * to match other glTF renderers, FNL_ENERGY_CONSERVING for rough metals as bright as real ones; it costs one texture lookup
 * per pixel.
 */
#ifndef FANAL_ENERGY_H
#define FANAL_ENERGY_H

#ifdef __cplusplus
extern "C" {
#endif

typedef enum fnl_energy {
    /**
     * Appendix B of glTF 2.0. In uniform white light, a white metal of roughness 1 reflects 30 to 50 percent, and a white
     * dielectric 97 to 120 percent, the most at grazing angles.
     */
    FNL_ENERGY_GLTF = 0,
    /**
     * White surfaces reflect exactly the light that arrives. Light that leaves one microfacet for another comes back as
     * diffuse light (Fdez-Agüera 2019, "A Multiple-Scattering Microfacet Model for Real-Time Image-based Lighting"), and the
     * diffuse part gets the light that the specular part does not reflect.
     */
    FNL_ENERGY_CONSERVING,
    FNL_ENERGY_COUNT
} fnl_energy;

#ifdef __cplusplus
}
#endif
#endif
