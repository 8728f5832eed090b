// SPDX-License-Identifier: MIT
// The lobe of fibres that stand out of cloth (Estevez and Kulla 2017, "Production Friendly Microfacet Sheen BRDF").
#ifndef LAYERS_SHEEN_LOBE_GLSL
#define LAYERS_SHEEN_LOBE_GLSL

float sheen_fit(float x, float alpha) {
    float rest = (1.0 - alpha) * (1.0 - alpha);
    float a = mix(21.5473, 25.3245, rest), b = mix(3.82987, 3.32435, rest), c = mix(0.19823, 0.16801, rest);
    return a / (1.0 + b * pow(x, c)) + mix(-1.97760, -1.27393, rest) * x + mix(-4.32054, -4.85967, rest);
}

float sheen_masking(float cosine, float alpha) {
    return exp(cosine < 0.5 ? sheen_fit(cosine, alpha) : 2.0 * sheen_fit(0.5, alpha) - sheen_fit(1.0 - cosine, alpha));
}

// Distribution times visibility.
float sheen_lobe(float roughness, float n_l, float n_v, float n_h) {
    float alpha = max(roughness * roughness, 1e-3), facing = max(n_v, 1e-3);
    float distribution = (2.0 + 1.0 / alpha) * pow(max(1.0 - n_h * n_h, 0.0), 0.5 / alpha) * (0.5 / PI);
    return distribution / ((1.0 + sheen_masking(facing, alpha) + sheen_masking(n_l, alpha)) * 4.0 * n_l * facing);
}

#endif
