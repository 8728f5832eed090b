// SPDX-License-Identifier: MIT
// Materials with layers: over the metallic-roughness base of brdf.glsl, whose highlights may be stretched (KHR_materials_anisotropy) and coloured
// by a thin film (_iridescence), fibres (_sheen) and over all of it a varnish (_clearcoat); below, diffuse light may go through (_diffuse_transmission),
// and in shaders of surfaces that one looks through (TRANSMISSION) all that the base does not reflect (_transmission, _volume, _dispersion). What a layer reflects of light from all around, its
// albedo, does not get below it. The albedos are those of the table that environments use (environment.glsl), so that a white material in an even
// light reflects all of it, whatever its layers.
#ifndef LAYERS_GLSL
#define LAYERS_GLSL

#include "brdf.glsl"
#include "environment.glsl"
#include "sheen.glsl"

const vec3 COAT_F0 = vec3(0.04); // of an index of refraction of 1.5

// What does not change from light to light; only `base` where the surface has no layers.
struct layers_view {
    brdf_view base, coat;
    vec3 bitangent;
    vec2 alpha_along;   // of anisotropic highlights: along the tangent and the bitangent
    float below_coat, below_sheen; // the parts of the light that get there
    float n_v;
    vec3 film_dielectric, film_metal; // reflectance with the film
};

// The normal that says which light comes from behind: with a coat its own, which is nearer to the triangle's.
vec3 facing_normal(surface s) { return LIGHTING_LAYERS && s.layered && s.layers.clearcoat > 0.0 ? s.layers.clearcoat_normal : s.normal; }

// The part of what gets into the base that its own colour reflects.
float opaque_part(surface s) {
    float part = 1.0 - s.layers.diffuse_transmission;
#ifdef TRANSMISSION
    part *= 1.0 - s.layers.transmission;
#endif
    return part;
}

// Whether lights behind the surface shine through.
bool lets_through(surface s) { return LIGHTING_LAYERS && s.layered && opaque_part(s) < 1.0; }

// By which side of the surface shadows of a light are looked for.
vec3 lit_normal(surface s, vec3 to_light) {
    vec3 normal = facing_normal(s);
    return lets_through(s) && dot(normal, to_light) < 0.0 ? -normal : normal;
}

#ifdef TRANSMISSION
// Alpha of what is seen through: microfacets of a sheet turn light by twice their tilt, as mirrors do; each face of a plate with an index of refraction n
// turns it by n - 1 times that (refraction at small angles), and the two are independent.
float through_alpha(surface s) {
    return max(alpha_of(s.roughness) * (s.layers.thickness > 0.0 ? clamp((s.layers.ior - 1.0) * 0.7071, 0.0, 1.0) : 1.0), ALPHA_MIN);
}
// What of the light is left after so many metres.
vec3 through_left(surface s, float way) { return exp(-s.layers.absorption * way); }

vec3 through_radiance(surface s, view_block v, vec3 to_view); // what is behind: of who draws
#endif

// ---- film (Belcour and Barla 2017, "A Practical Extension to Microfacet Theory for the Modeling of Varying Iridescence") ----

// The eye's answer to light whose parts are shifted by a path of `path` metres and by `shift`: three Gaussians and one more, in the frequency.
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

// ---- lights ----

brdf_view coat_view(surface s, vec3 to_view) {
    surface coat;
    coat.normal = s.layers.clearcoat_normal;
    coat.roughness = s.layers.clearcoat_roughness;
    return brdf_prepare(coat, to_view);
}

layers_view layers_prepare(surface s, view_block v, vec3 to_view) {
    layers_view b;
    b.base = brdf_prepare(s, to_view);
    if (!LIGHTING_LAYERS || !s.layered) return b;
    b.n_v = clamp(dot(s.normal, to_view), 0.0, 1.0);
    b.coat = coat_view(s, to_view);
    vec3 coat = environment_reflectance(v, clamp(dot(s.layers.clearcoat_normal, to_view), 0.0, 1.0), s.layers.clearcoat_roughness).xyz;
    b.below_coat = 1.0 - s.layers.clearcoat * (COAT_F0.x * coat.x + coat.y);
    b.below_sheen = 1.0 - max_component(s.layers.sheen_color) * environment_sheen(v, b.n_v, s.layers.sheen_roughness);
    b.film_dielectric = b.film_metal = vec3(0.0);
    if (s.layers.film > 0.0) {
        vec3 f0 = s.dielectric_f0 / max(s.dielectric_f90, 1e-6);
        b.film_dielectric = film_reflectance(b.n_v, s.layers.film_ior, s.layers.film_thickness, f0) * s.dielectric_f90;
        b.film_metal = film_reflectance(b.n_v, s.layers.film_ior, s.layers.film_thickness, s.base_color);
    }
    float alpha = alpha_of(s.roughness);
    b.alpha_along = vec2(mix(alpha, 1.0, s.layers.anisotropy * s.layers.anisotropy), alpha);
    b.bitangent = cross(s.normal, s.layers.tangent);
    if (s.layers.anisotropy > 0.0) {
        vec2 across = b.alpha_along * vec2(dot(s.layers.tangent, to_view), dot(b.bitangent, to_view));
        float n_v = abs(dot(s.normal, to_view));
        b.base.masking = PI * (n_v + sqrt(dot(across, across) + n_v * n_v));
    }
    return b;
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

// `n_l`: of `to_light`, which fibres know.
vec3 layered_base_of(surface s, layers_view b, brdf_lobes lobes, vec3 to_light, float n_l) {
    vec3 fresnel = mix(s.dielectric_f0 + (vec3(s.dielectric_f90) - s.dielectric_f0) * lobes.m5, b.film_dielectric, s.layers.film);
    vec3 taken = mix(s.dielectric_f0 + (vec3(s.dielectric_f90) - s.dielectric_f0) * lobes.m5_below, b.film_dielectric, s.layers.film);
    vec3 metal = mix(s.base_color + (1.0 - s.base_color) * lobes.m5, b.film_metal, s.layers.film) * lobes.specular;
    vec3 dielectric = s.base_color * ((1.0 - max_component(taken)) * (1.0 / PI) * opaque_part(s)) + fresnel * lobes.specular;
    vec3 base = mix(dielectric, metal, s.metallic) * b.below_sheen;
    if (max_component(s.layers.sheen_color) > 0.0) {
        float n_h = clamp(dot(s.normal, normalize(to_light + b.base.to_view)), 0.0, 1.0);
        base += s.layers.sheen_color * sheen_lobe(s.layers.sheen_roughness, n_l, b.n_v, n_h);
    }
    return base * lobes.n_l;
}

vec3 layered_base(surface s, layers_view b, vec3 to_light) {
    brdf_lobes lobes;
    if (!brdf_lobes_of(s.normal, b.base, to_light, lobes)) return vec3(0.0);
    if (s.layers.anisotropy > 0.0) lobes.specular = stretched_lobe(s, b, to_light, lobes.n_l);
    return layered_base_of(s, b, lobes, to_light, lobes.n_l);
}

// A light behind the surface: its mirror image in front says what gets in, and where the lobe of what is seen through lies.
brdf_view behind_view(surface s, layers_view b) {
#ifdef TRANSMISSION
    surface sheet = s;
    sheet.roughness = sqrt(through_alpha(s));
    return brdf_prepare(sheet, b.base.to_view);
#else
    return b.base;
#endif
}

vec3 layered_behind_of(surface s, layers_view b, brdf_lobes lobes) {
    vec3 fresnel = mix(s.dielectric_f0 + (vec3(s.dielectric_f90) - s.dielectric_f0) * lobes.m5_below, b.film_dielectric, s.layers.film);
    vec3 through = s.layers.diffuse_transmission_color * (s.layers.diffuse_transmission * (1.0 / PI));
#ifdef TRANSMISSION
    through = mix(through, s.base_color * lobes.specular * through_left(s, s.layers.thickness), s.layers.transmission);
#endif
    return through * ((1.0 - max_component(fresnel)) * (1.0 - s.metallic) * b.below_sheen * lobes.n_l);
}

vec3 layered_behind(surface s, layers_view b, vec3 to_light) {
    vec3 image = to_light - 2.0 * dot(s.normal, to_light) * s.normal;
    brdf_lobes lobes;
    if (!brdf_lobes_of(s.normal, behind_view(s, b), image, lobes)) return vec3(0.0);
    return layered_behind_of(s, b, lobes);
}

// f(l, v) times the cosine, as brdf_cos().
vec3 layers_cos(surface s, layers_view b, vec3 to_light) {
    if (!LIGHTING_LAYERS || !s.layered) return brdf_cos(s, b.base, to_light);
    vec3 sum = layered_base(s, b, to_light) * b.below_coat;
    if (lets_through(s) && dot(s.normal, to_light) < 0.0) sum += layered_behind(s, b, to_light) * b.below_coat;
    brdf_lobes coat;
    if (s.layers.clearcoat > 0.0 && brdf_lobes_of(s.layers.clearcoat_normal, b.coat, to_light, coat))
        sum += s.layers.clearcoat * (COAT_F0 + (1.0 - COAT_F0) * coat.m5) * (coat.specular * coat.n_l);
    return sum;
}

// layers_cos() of a rectangle. Highlights that are stretched along the tangent are a fan of round ones (see stretched_radiance()); fibres see the rectangle
// where most of its light comes from. All lobes are integrated in one loop, so that shaders hold its code once.
vec3 area_cos(light_set_block l, uint light, surface s, layers_view b) {
    const uint BASE = 0u, BEHIND = 1u, COAT = 2u, FAN = 3u, FAN_COUNT = 8u;
    bool layered = LIGHTING_LAYERS && s.layered, fans = layered && s.layers.anisotropy > 0.0;
    brdf_lobes base = brdf_lobes(0.0, 0.0, 0.0, 0.0);
    vec3 base_toward = s.normal, sum = vec3(0.0);
    float fan = 0.0, weights = 1e-6;
    for (uint lobe = BASE; lobe < (fans ? FAN + FAN_COUNT : layered ? FAN : BEHIND); lobe++) {
        vec3 normal = s.normal, toward;
        brdf_view view = b.base;
        float weight = 1.0;
        brdf_lobes lobes;
        if (LIGHTING_LAYERS && lobe == BEHIND) {
            if (!lets_through(s)) continue;
            view = behind_view(s, b);
        } else if (LIGHTING_LAYERS && lobe == COAT) {
            if (!(s.layers.clearcoat > 0.0)) continue;
            normal = s.layers.clearcoat_normal;
            view = b.coat;
        } else if (LIGHTING_LAYERS && lobe >= FAN) {
            float across = b.alpha_along.y, lean = sqrt(max(b.alpha_along.x * b.alpha_along.x - across * across, 0.0));
            float u = 2.0 * (float(lobe - FAN) + 0.5) / float(FAN_COUNT) - 1.0;
            surface leaning = s;
            leaning.roughness = sqrt(max(across, lean / float(FAN_COUNT)));
            normal += s.layers.tangent * (lean * u * inversesqrt(1.0 - u * u));
            weight = max(dot(b.base.to_view, normal), 0.0);
            normal = leaning.normal = normalize(normal);
            view = brdf_prepare(leaning, b.base.to_view);
        }
        weights += lobe >= FAN ? weight : 0.0;
        if (!area_lobes_of(l, light, s.position, normal, view, lobe == BEHIND, lobes, toward)) continue;
        if (lobe == BASE) {
            base = lobes;
            base_toward = toward;
        } else if (LIGHTING_LAYERS && lobe == BEHIND) {
            sum += layered_behind_of(s, b, lobes) * b.below_coat;
        } else if (LIGHTING_LAYERS && lobe == COAT) {
            sum += s.layers.clearcoat * (COAT_F0 + (1.0 - COAT_F0) * lobes.m5) * (lobes.specular * lobes.n_l);
        } else {
            fan += weight * lobes.specular * lobes.n_l;
        }
    }
    if (!(base.n_l > 0.0)) return sum;
    if (!layered) return brdf_cos_of(s, base);
    if (fans) base.specular = fan / (weights * base.n_l);
    return sum + layered_base_of(s, b, base, base_toward, max(dot(s.normal, base_toward), 1e-4)) * b.below_coat;
}

// ---- light from all around ----

vec3 radiance_from(view_block v, vec3 direction, float lod) {
    return LIGHTING_ENVIRONMENT ? environment_radiance(v, direction, lod) : ambient_radiance(v, normalize(direction));
}

// The normal by which highlights that are stretched along the tangent mirror ambient light: microfacets lean that way, so those nearest to the viewer count (Revie 2011, "Implementing Fur Using Deferred Shading", GPU Pro 2).
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

// `through`: the part of what is behind that shows through the base.
vec3 layers_environment(surface s, layers_view b, view_block v, out vec3 through) {
    vec3 table = environment_reflectance(v, b.n_v, s.roughness), mirrored, around, taken;
    surface bent = s, coat = s;
    if (s.layers.anisotropy > 0.0) bent.normal = stretched_normal(s, b);
    coat.normal = s.layers.clearcoat_normal;
    coat.roughness = s.layers.clearcoat_roughness;
    light_around light_from;
    if (LIGHTING_REFLECTIONS) {
        float lod = s.layers.clearcoat > 0.0 ? environment_reflectance(v, 1.0, coat.roughness).z : -1.0;
        light_from = reflections_gather(v, s.position, s.normal, s.light_mask, lobe_direction(bent, b.base.to_view), table.z, lobe_direction(coat, b.base.to_view), lod);
        mirrored = s.layers.anisotropy > 0.0 ? stretched_radiance(s, b, v) : light_from.mirrored;
        around = light_from.diffuse;
    } else {
        mirrored = LIGHTING_ENVIRONMENT && s.layers.anisotropy > 0.0 ? stretched_radiance(s, b, v)
                                                                 : radiance_from(v, lobe_direction(bent, b.base.to_view), table.z);
        around = AMBIENT_DIFFUSE(v, s.normal);
    }
    // The film's reflectance holds for the whole lobe: as f0 and f90 in one.
    vec3 f0 = mix(s.dielectric_f0, b.film_dielectric, s.layers.film), f90 = mix(vec3(s.dielectric_f90), b.film_dielectric, s.layers.film);
    vec3 light = environment_lobe(f0, f90, table.xy, mirrored, around, taken);
    vec3 below = s.base_color * around;
    if (s.layers.diffuse_transmission > 0.0) {
        vec3 behind = LIGHTING_REFLECTIONS ? reflections_gather(v, s.position, -s.normal, s.light_mask, -s.normal, 0.0, s.normal, -1.0).diffuse : AMBIENT_DIFFUSE(v, -s.normal);
        below = mix(below, s.layers.diffuse_transmission_color * behind, s.layers.diffuse_transmission);
    }
    through = vec3(0.0);
#ifdef TRANSMISSION
    below *= 1.0 - s.layers.transmission;
    through = s.base_color * ((1.0 - max_component(taken)) * (1.0 - s.metallic) * s.layers.transmission * b.below_sheen * b.below_coat);
#endif
    light += below * (1.0 - max_component(taken));
    f0 = mix(s.base_color, b.film_metal, s.layers.film), f90 = mix(vec3(1.0), b.film_metal, s.layers.film);
    light = mix(light, environment_lobe(f0, f90, table.xy, mirrored, around, taken), s.metallic) * b.below_sheen;
    light += s.layers.sheen_color * environment_sheen(v, b.n_v, s.layers.sheen_roughness) * around;
    if (s.layers.clearcoat <= 0.0) return light;
    table = environment_reflectance(v, clamp(dot(coat.normal, b.base.to_view), 0.0, 1.0), coat.roughness);
    vec3 coat_light = LIGHTING_REFLECTIONS ? light_from.coat : radiance_from(v, lobe_direction(coat, b.base.to_view), table.z);
    return light * b.below_coat + s.layers.clearcoat * (COAT_F0 * table.x + table.y) * coat_light;
}

vec3 layers_rest(surface s, view_block v, vec3 to_view, vec3 sum) {
    layers_view b = layers_prepare(s, v, to_view);
    vec3 through, around = layers_environment(s, b, v, through) * s.occlusion;
#ifdef TRANSMISSION
    if (max_component(through) > 0.0) sum += through * through_radiance(s, v, to_view);
#endif
    return sum + around + s.emissive * b.below_coat;
}

#endif
