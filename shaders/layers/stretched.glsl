// SPDX-License-Identifier: MIT
// Highlights of the base that are stretched along the tangent (KHR_materials_anisotropy).
#ifndef LAYERS_STRETCHED_GLSL
#define LAYERS_STRETCHED_GLSL

void stretched_prepare(surface s, vec3 to_view, inout layers_view b) {
    float alpha = alpha_of(s.roughness);
    b.alpha_along = vec2(mix(alpha, 1.0, s.layers.anisotropy * s.layers.anisotropy), alpha);
    b.bitangent = cross(s.normal, s.layers.tangent);
    if (s.layers.anisotropy > 0.0) {
        vec2 across = b.alpha_along * vec2(dot(s.layers.tangent, to_view), dot(b.bitangent, to_view));
        float n_v = abs(dot(s.normal, to_view));
        b.base.masking = PI * (n_v + sqrt(dot(across, across) + n_v * n_v));
    }
}

// The specular lobe of brdf_lobes_of() with two roughnesses (Burley 2012, "Physically-Based Shading at Disney").
float stretched_lobe(surface s, layers_view b, vec3 to_light, float n_l) {
    vec3 half_vector = normalize(to_light + b.base.to_view);
    float n_h = dot(s.normal, half_vector);
    vec2 h = vec2(dot(s.layers.tangent, half_vector), dot(b.bitangent, half_vector)) / b.alpha_along;
    vec2 l = vec2(dot(s.layers.tangent, to_light), dot(b.bitangent, to_light)) * b.alpha_along;
    float d = dot(h, h) + n_h * n_h, shadowing = n_l + sqrt(dot(l, l) + n_l * n_l);
    return n_h > 0.0 ? 1.0 / (b.alpha_along.x * b.alpha_along.y * d * d * shadowing * b.base.masking) : 0.0;
}

// Rectangles: one of the round lobes that make up a stretched one, with its weight (see stretched_radiance()).
brdf_view stretched_part(surface s, layers_view b, uint part, uint count, out vec3 normal, out float weight) {
    float across = b.alpha_along.y, lean = sqrt(max(b.alpha_along.x * b.alpha_along.x - across * across, 0.0));
    float u = 2.0 * (float(part) + 0.5) / float(count) - 1.0;
    surface leaning = s;
    leaning.roughness = sqrt(max(across, lean / float(count)));
    normal = s.normal;
    normal += s.layers.tangent * (lean * u * inversesqrt(1.0 - u * u));
    weight = max(dot(b.base.to_view, normal), 0.0);
    normal = leaning.normal = normalize(normal);
    return brdf_prepare(leaning, b.base.to_view);
}

// The normal by which highlights that are stretched along the tangent mirror ambient light: microfacets lean that way, so the ones nearest to the viewer count
// (Revie 2011, "Implementing Fur Using Deferred Shading", GPU Pro 2).
vec3 stretched_normal(surface s, layers_view b) {
    vec3 along = b.base.to_view - b.bitangent * dot(b.bitangent, b.base.to_view);
    float bend = s.layers.anisotropy * clamp(1.0 - s.roughness, 0.0, 1.0), rest = (1.0 - bend) * (1.0 - bend);
    return normalize(mix(normalize(along), s.normal, rest * rest));
}

// What a stretched lobe mirrors: the round lobe of the smaller roughness, by a fan of normals that lean along the tangent as slopes of the distribution do
// (its marginal has the quantiles a u / sqrt(1 - u^2)); those that the viewer sees more of count more (Heitz 2018). Lobes are as wide as the gaps between them.
vec3 stretched_radiance(surface s, layers_view b, view_block v) {
    const float COUNT = 16.0;
    float across = b.alpha_along.y, lean = sqrt(max(b.alpha_along.x * b.alpha_along.x - across * across, 0.0));
    surface leaning = s;
    leaning.roughness = sqrt(max(across, lean / COUNT));
    float lod = environment_reflectance(v, b.n_v, leaning.roughness).z, weights = 1e-6;
    vec3 sum = vec3(0.0);
    for (float i = 0.5; i < COUNT; i += 1.0) {
        float u = 2.0 * i / COUNT - 1.0;
        vec3 normal = s.normal + s.layers.tangent * (lean * u * inversesqrt(1.0 - u * u));
        float seen = max(dot(b.base.to_view, normal), 0.0); // times 1 / (n.h), which is the length of `normal`, over itself
        leaning.normal = normalize(normal);
        float weight = dot(s.normal, reflect(-b.base.to_view, leaning.normal)) > 0.0 ? seen : 0.0;
        vec3 direction = lobe_direction(leaning, b.base.to_view);
        if (weight > 0.0) {
            if (LIGHTING_REFLECTIONS) sum += weight * reflections_gather(v, s.position, s.normal, s.light_mask, direction, lod, s.normal, -1.0).mirrored;
            else sum += weight * environment_radiance(v, direction, lod);
        }
        weights += weight;
    }
    return sum / weights;
}

#endif
