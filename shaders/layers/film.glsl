// SPDX-License-Identifier: MIT
// A thin film that colors the reflection of the base (KHR_materials_iridescence), by
// Belcour and Barla 2017, "A Practical Extension to Microfacet Theory for the Modeling of Varying Iridescence".
#ifndef LAYERS_FILM_GLSL
#define LAYERS_FILM_GLSL

// The eye's response to light whose parts are shifted by a path of `path` meters and by `shift`: three Gaussians and one more, in the frequency.
vec3 film_sensitivity(float path, vec3 shift) {
    float phase = 2.0 * PI * path;
    const vec3 value = vec3(5.4856e-13, 4.4201e-13, 5.2481e-13), at = vec3(1.6810e6, 1.7953e6, 2.2084e6), spread = vec3(4.3278e9, 9.3046e9, 6.6121e9);
    vec3 xyz = value * sqrt(2.0 * PI * spread) * cos(at * phase + shift) * exp(-spread * phase * phase);
    xyz.x += 9.7470e-14 * sqrt(2.0 * PI * 4.5282e9) * cos(2.2399e6 * phase + shift.x) * exp(-4.5282e9 * phase * phase);
    xyz /= 1.0685e-7;
    const mat3 to_rgb = mat3(3.2404542, -0.9692660, 0.0556434, -1.5371385, 1.8760108, -0.2040259, -0.4985314, 0.0415560, 1.0572252);
    return to_rgb * xyz;
}

vec3 schlick(vec3 f0, float cosine) {
    float m = clamp(1.0 - cosine, 0.0, 1.0), m2 = m * m;
    return f0 + (1.0 - f0) * (m2 * m2 * m);
}

// Reflectance of a film over something that reflects base_f0 along the normal.
vec3 film_reflectance(float cosine, float film_ior, float thickness, vec3 base_f0) {
    float ior = mix(1.0, film_ior, smoothstep(0.0, 0.03e-9, thickness * 1e-9)); // no film where it is too thin
    float sine2 = (1.0 - cosine * cosine) / (ior * ior);
    if (sine2 >= 1.0) return vec3(1.0);
    float inner = sqrt(1.0 - sine2), outer_f0 = (ior - 1.0) / (ior + 1.0);
    float outside = schlick(vec3(outer_f0 * outer_f0), cosine).x, through = 1.0 - outside;
    vec3 root = sqrt(clamp(base_f0 + 1e-4, vec3(0.0), vec3(0.9999))), base_ior = (1.0 + root) / (1.0 - root);
    vec3 inside_f0 = (base_ior - ior) / (base_ior + ior), inside = schlick(inside_f0 * inside_f0, inner);
    vec3 shift = vec3(ior < 1.0 ? 0.0 : PI) + mix(vec3(0.0), vec3(PI), lessThan(base_ior, vec3(ior)));
    vec3 both = clamp(outside * inside, vec3(1e-5), vec3(0.9999)), amplitude = sqrt(both);
    vec3 steady = through * through * inside / (1.0 - both), sum = outside + steady, part = steady - through;
    float path = 2.0 * ior * thickness * 1e-9 * inner;
    for (float m = 1.0; m <= 2.0; m += 1.0) {
        part *= amplitude;
        sum += part * 2.0 * film_sensitivity(m * path, m * shift);
    }
    return max(sum, vec3(0.0));
}

// Reflectance of the dielectric part and of metal under the film; 0 without a film.
void film_reflectances(surface s, float n_v, out vec3 dielectric, out vec3 metal) {
    dielectric = metal = vec3(0.0);
    if (s.layers.film > 0.0) {
        vec3 f0 = s.dielectric_f0 / max(s.dielectric_f90, 1e-6);
        dielectric = film_reflectance(n_v, s.layers.film_ior, s.layers.film_thickness, f0) * s.dielectric_f90;
        metal = film_reflectance(n_v, s.layers.film_ior, s.layers.film_thickness, s.base_color);
    }
}

#endif
