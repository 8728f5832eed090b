/* SPDX-License-Identifier: MIT */
#include "ray/brdf.h"

#include "base/base.h"

static dvec3 base_cos(const struct ray_surface *s, dvec3 v, dvec3 l, dvec3 h) {
    const dvec3 none = {0, 0, 0}, f90 = {s->f90, s->f90, s->f90}, white = {1, 1, 1};
    double n_l = dvec3_dot(s->normal, l), lobe = ray_specular_lobe(s, v, l, h), weight = pow(1 - clamp01(dvec3_dot(h, v)), 5);
    if (!(n_l > 0)) return none;
    dvec3 fresnel = dvec3_lerp(s->f0, f90, weight), metal = dvec3_lerp(s->base_color, white, weight);
    ray_film_over(s, &fresnel, &metal);
    const double below = s->conserving ? s->below : 1 - dvec3_max(fresnel);
    const dvec3 dielectric = dvec3_add_scaled(dvec3_scale(s->base_color, below * ray_opaque_part(s) / DPI), fresnel, lobe);
    const dvec3 once = dvec3_lerp(dielectric, dvec3_scale(metal, lobe), s->metallic);
    return dvec3_scale(dvec3_add_scaled(once, s->between, 1 / DPI), n_l * ray_facing(s->geometric, s->normal, l));
}

dvec3 ray_brdf_cos(const struct ray_surface *s, dvec3 v, dvec3 l) {
    const dvec3 none = {0, 0, 0};
    if (ray_lets_through(s) && dvec3_dot(s->normal, l) < 0) return ray_behind_cos(s, v, l);
    dvec3 h = dvec3_add(l, v);
    if (dvec3_length(h) == 0) return none;
    h = dvec3_normalize(h);
    const dvec3 base = base_cos(s, v, l, h);
    return s->layered ? ray_layers_over(s, v, l, h, base) : base;
}

dvec3 ray_ambient(const struct ray_surface *s, dvec3 v, dvec3 sky, dvec3 ground) {
    double n_v = dvec3_dot(s->normal, v), facing = clamp01(n_v);
    const double r = s->roughness, n = facing, smooth = 1 - r;
    const double lost = r * r * (1.8003 + n * (-1.9662 + n * (-1.3978 + n * 0.3372)) + r * (-3.8406 + n * (7.0593 + n * 0.6746) + r * (3.0845 - 4.405 * n - 0.6577 * r)));
    const double all = 1 - clamp01(lost), a = fmin(smooth * smooth, exp2(-9.28 * n)) * smooth + 0.0425 - 0.0275 * r;
    const double bias = fmin(fmax(1.04 * a + 0.022 * r - 0.04, 0), all), scale = all - bias;
    const double below = ray_energy_below(s->f0, s->f90, facing), grazing = s->f90 * (1 - s->metallic) + s->metallic;
    dvec3 along_normal = ray_sky(s->normal, sky, ground);
    dvec3 mirrored = ray_sky(dvec3_sub(dvec3_scale(s->normal, 2 * n_v), v), sky, ground);
    dvec3 straight = dvec3_scale(dvec3_lerp(s->f0, s->base_color, s->metallic), scale);
    dvec3 specular = dvec3_add(straight, dvec3_make(grazing * bias, grazing * bias, grazing * bias));
    dvec3 diffuse = dvec3_scale(s->base_color, below * (1 - s->metallic));
    return dvec3_scale(dvec3_add(dvec3_mul(diffuse, along_normal), dvec3_mul(specular, mirrored)), s->occlusion);
}

/* ---- sampling ---- */

/* The chance that the specular lobe is chosen, of those of the base. */
static double specular_share(const struct ray_surface *s, double n_v) {
    double weight = pow(1 - clamp01(n_v), 5);
    const dvec3 f90 = {s->f90, s->f90, s->f90}, white = {1, 1, 1};
    dvec3 fresnel = dvec3_lerp(s->f0, f90, weight);
    double specular = dvec3_luminance(dvec3_lerp(fresnel, dvec3_lerp(s->base_color, white, weight), s->metallic));
    double diffuse = dvec3_luminance(s->base_color) * (1 - dvec3_max(fresnel)) * (1 - s->metallic) * ray_opaque_part(s) + dvec3_luminance(s->between);
    if (!(specular > 0)) return 0;
    return diffuse > 0 ? CLAMP(specular / (specular + diffuse), 0.1, 0.9) : 1;
}

/* From which lobe a direction is taken, and with what chances. */
struct lobes {
    struct ray_mirror base;
    double mirrors; /* the specular share of the directions in front that coat and even leave */
    struct ray_layer_lobes layers; /* behind_share is apart from the other shares */
};

static struct lobes lobes_of(const struct ray_surface *s, dvec3 to_view) {
    return (struct lobes){.base = ray_mirror_of(s), .mirrors = specular_share(s, fmax(dvec3_dot(s->normal, to_view), 1e-4)), .layers = ray_layer_lobes(s)};
}

static double density_of(const struct ray_surface *s, const struct lobes *l, dvec3 v, dvec3 to_light) {
    const double n_l = dvec3_dot(s->normal, to_light), rest = 1 - l->layers.coat_share - l->layers.even_share;
    if (!(n_l > 0) && s->layered) return l->layers.behind_share * -n_l / DPI; /* only diffuse transmission samples light from below */
    double density = rest * ((1 - l->mirrors) * fmax(n_l, 0) / DPI + l->mirrors * ray_mirror_density(&l->base, v, to_light));
    if (l->layers.coat_share > 0) density += l->layers.coat_share * ray_mirror_density(&l->layers.coat, v, to_light);
    if (n_l > 0) density += l->layers.even_share / (2 * DPI);
    return (1 - l->layers.behind_share) * density;
}

/* f cos, of light that paths bring. */
static dvec3 path_cos(const struct ray_surface *s, dvec3 v, dvec3 to_light) {
    const dvec3 none = {0, 0, 0};
    const double n_l = dvec3_dot(s->normal, to_light);
    if (n_l > 0) return ray_brdf_cos(s, v, to_light);
    if (!s->layered || !(s->layers.diffuse_transmission > 0)) return none;
    struct ray_surface paper = *s;
    paper.layers.transmission = 0;
    return dvec3_scale(ray_behind_cos(&paper, v, to_light), 1 - s->layers.transmission);
}

dvec3 ray_brdf_light(const struct ray_surface *s, dvec3 to_view, dvec3 to_light, double *density) {
    const struct lobes lobes = lobes_of(s, to_view);
    *density = density_of(s, &lobes, to_view, to_light);
    return path_cos(s, to_view, to_light);
}

dvec3 ray_brdf_sample(const struct ray_surface *s, dvec3 to_view, const double random[3], dvec3 *to_light, double *density) {
    const dvec3 none = {0, 0, 0};
    const struct lobes lobes = lobes_of(s, to_view);
    const bool behind = random[0] < lobes.layers.behind_share;
    const double chosen = (random[0] - lobes.layers.behind_share) / (1 - lobes.layers.behind_share), mirrors = lobes.mirrors * (1 - lobes.layers.coat_share - lobes.layers.even_share);
    if (!behind && chosen < lobes.layers.coat_share) {
        *to_light = ray_mirror_sample(&lobes.layers.coat, to_view, random[1], random[2]);
    } else if (!behind && chosen - lobes.layers.coat_share < mirrors) {
        *to_light = ray_mirror_sample(&lobes.base, to_view, random[1], random[2]);
    } else {
        const bool even = !behind && chosen - lobes.layers.coat_share - mirrors < lobes.layers.even_share;
        const double z = even ? random[1] : sqrt(fmax(1 - random[1], 1e-12)), radius = sqrt(fmax(1 - z * z, 0)), angle = 2 * DPI * random[2];
        dvec3 side, up;
        dvec3_basis(s->normal, &side, &up);
        *to_light = dvec3_combine(side, up, s->normal, dvec3_make(radius * cos(angle), radius * sin(angle), behind ? -z : z));
    }
    *density = density_of(s, &lobes, to_view, *to_light); /* any of them may have given it */
    return *density > 0 ? dvec3_scale(path_cos(s, to_view, *to_light), 1 / *density) : none;
}

/* ---- albedos ---- */

/* By visible normals: of what they mirror, all but what is shadowed arrives. */
static void specular_albedo(double roughness, double n_v, float out[2]) {
    enum { SIDE = 24 };
    struct ray_surface s = {.normal = {0, 0, 1}, .geometric = {0, 0, 1}, .base_color = {1, 1, 1}, .metallic = 1, .roughness = roughness};
    const dvec3 v = {sqrt(1 - n_v * n_v), 0, n_v};
    double sum[2] = {0, 0};
    for (int i = 0; i < SIDE * SIDE; i++) {
        const double random[3] = {0, (i % SIDE + 0.5) / SIDE, (i / SIDE + 0.5) / SIDE};
        dvec3 l;
        double density;
        const double all = ray_brdf_sample(&s, v, random, &l, &density).x; /* Fresnel of a white metal is 1 */
        const dvec3 h = dvec3_normalize(dvec3_add(v, l));
        const double grazing = pow(1 - fmin(fmax(dvec3_dot(h, v), 0), 1), 5);
        sum[0] += all * (1 - grazing);
        sum[1] += all * grazing;
    }
    for (int i = 0; i < 2; i++) out[i] = (float)(sum[i] / (SIDE * SIDE));
}

/* Midpoints of squares of equal solid angle. */
static float sheen_albedo(double roughness, double n_v) {
    enum { SIDE = 32 };
    const dvec3 v = {sqrt(1 - n_v * n_v), 0, n_v};
    double sum = 0;
    for (int i = 0; i < SIDE * SIDE; i++) {
        const double n_l = (i % SIDE + 0.5) / SIDE, angle = DPI * (i / SIDE + 0.5) / SIDE, away = sqrt(1 - n_l * n_l);
        const dvec3 h = dvec3_normalize(dvec3_add(v, dvec3_make(away * cos(angle), away * sin(angle), n_l)));
        sum += ray_sheen_lobe(roughness, n_l, n_v, h.z) * n_l;
    }
    return (float)fmin(sum * 2 * DPI / (SIDE * SIDE), 1);
}

void ray_albedos_fill(struct ray_albedos *out) {
    for (int r = 0; r < RAY_ALBEDO_SIDE; r++)
        for (int n = 0; n < RAY_ALBEDO_SIDE; n++) {
            const double roughness = (double)r / (RAY_ALBEDO_SIDE - 1), n_v = fmax((double)n / (RAY_ALBEDO_SIDE - 1), 1e-3);
            specular_albedo(roughness, n_v, out->specular[r][n]);
            out->sheen[r][n] = sheen_albedo(roughness, n_v);
        }
}
