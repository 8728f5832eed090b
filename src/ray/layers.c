/* SPDX-License-Identifier: MIT */
#include "ray/layers.h"

#include "scene/scene.h"

void ray_layers_numbers(const struct scene_material *m, struct ray_layers *out) {
#define SCALAR(id, member, ...) out->id = (double)m->member;
#define COLOR(id, member, ...) out->id = dvec3_make((double)m->member[0], (double)m->member[1], (double)m->member[2]);
    MATERIAL_LAYER_NUMBERS(SCALAR, COLOR)
#undef SCALAR
#undef COLOR
}

double ray_facing(dvec3 geometric, dvec3 normal, dvec3 to_light) {
    const double g_l = dvec3_dot(geometric, to_light);
    if (!(g_l > 0)) return 0;
    const double lean = dvec3_dot(geometric, normal), part = fmin(2 * g_l / sqrt(fmax(1 - lean * lean, 1e-8)), 1);
    return part * part * (3 - 2 * part);
}

/* ---- coat ---- */

static const double coat_f0 = 0.04;

static struct ray_surface coat_of(const struct ray_surface *s) {
    return (struct ray_surface){.normal = s->layers.clearcoat_normal, .geometric = s->geometric, .roughness = s->layers.clearcoat_roughness};
}

static double coat_lobe(const struct ray_surface *s, dvec3 v, dvec3 l, dvec3 h) {
    const struct ray_surface coat = coat_of(s);
    const double n_l = dvec3_dot(coat.normal, l);
    if (!(s->layers.clearcoat > 0 && n_l > 0)) return 0;
    return s->layers.clearcoat * (coat_f0 + (1 - coat_f0) * pow(1 - clamp01(dvec3_dot(h, v)), 5)) * ray_specular_lobe(&coat, v, l, h) * n_l *
           ray_facing(coat.geometric, coat.normal, l);
}

static double coat_albedo(const struct ray_albedos *albedos, double roughness, double n_v) {
    double parts[2];
    ray_specular_albedo(albedos, roughness, n_v, parts);
    return coat_f0 * parts[0] + parts[1];
}

/* ---- sheen ---- */

static double sheen_masking(double cosine, double alpha) {
    static const double ends[5][2] = {{21.5473, 25.3245}, {3.82987, 3.32435}, {0.19823, 0.16801}, {-1.97760, -1.27393}, {-4.32054, -4.85967}};
    double fit[5], at[2] = {cosine < 0.5 ? cosine : 1 - cosine, 0.5}, value[2];
    for (int i = 0; i < 5; i++) fit[i] = ends[i][0] + (ends[i][1] - ends[i][0]) * (1 - alpha) * (1 - alpha);
    for (int i = 0; i < 2; i++) value[i] = fit[0] / (1 + fit[1] * pow(at[i], fit[2])) + fit[3] * at[i] + fit[4];
    return exp(cosine < 0.5 ? value[0] : 2 * value[1] - value[0]);
}

double ray_sheen_lobe(double roughness, double n_l, double n_v, double n_h) {
    double alpha = fmax(roughness * roughness, 1e-3), facing = fmax(n_v, 1e-3);
    double distribution = (2 + 1 / alpha) * pow(fmax(1 - n_h * n_h, 0), 0.5 / alpha) / (2 * DPI);
    return distribution / ((1 + sheen_masking(facing, alpha) + sheen_masking(n_l, alpha)) * 4 * n_l * facing);
}

/* ---- film (Belcour and Barla 2017, "A Practical Extension to Microfacet Theory for the Modeling of Varying Iridescence") ---- */

static double schlick(double f0, double cosine) { return f0 + (1 - f0) * pow(1 - clamp01(cosine), 5); }

/* The eye's response to light whose parts are shifted by a path, meters, and by `shift`, radians: Gaussians in the frequency; linear RGB. */
static void film_sensitivity(double path, const double shift[3], double out[3]) {
    static const double value[4] = {5.4856e-13, 4.4201e-13, 5.2481e-13, 9.7470e-14}, at[4] = {1.6810e6, 1.7953e6, 2.2084e6, 2.2399e6},
                        spread[4] = {4.3278e9, 9.3046e9, 6.6121e9, 4.5282e9};
    static const double to_rgb[3][3] = {{3.2404542, -1.5371385, -0.4985314}, {-0.9692660, 1.8760108, 0.0415560}, {0.0556434, -0.2040259, 1.0572252}};
    const double phase = 2 * DPI * path;
    double xyz[3] = {0, 0, 0};
    for (int i = 0; i < 4; i++)
        xyz[i % 3] += value[i] * sqrt(2 * DPI * spread[i]) * cos(at[i] * phase + shift[i % 3]) * exp(-spread[i] * phase * phase) / 1.0685e-7;
    for (int i = 0; i < 3; i++) out[i] = to_rgb[i][0] * xyz[0] + to_rgb[i][1] * xyz[1] + to_rgb[i][2] * xyz[2];
}

static dvec3 film_reflectance(double cosine, double film_ior, double thickness, dvec3 base_f0) {
    const double t = clamp01(thickness / 0.03), ior = 1 + (film_ior - 1) * t * t * (3 - 2 * t); /* no film where it is too thin */
    const double sine2 = (1 - cosine * cosine) / (ior * ior), *f0 = &base_f0.x;
    if (sine2 >= 1) return dvec3_make(1, 1, 1);
    const double inner = sqrt(1 - sine2), outside = schlick(ray_ior_reflectance(ior), cosine), through = 1 - outside, path = 2 * ior * thickness * 1e-9 * inner;
    double shift[3], amplitude[3], part[3], sum[3], color[3];
    for (int i = 0; i < 3; i++) {
        const double root = sqrt(CLAMP(f0[i] + 1e-4, 0.0, 0.9999)), base_ior = (1 + root) / (1 - root), r = (base_ior - ior) / (base_ior + ior);
        const double inside = schlick(r * r, inner), both = CLAMP(outside * inside, 1e-5, 0.9999), steady = through * through * inside / (1 - both);
        shift[i] = (ior < 1 ? 0 : DPI) + (base_ior < ior ? DPI : 0);
        amplitude[i] = sqrt(both);
        sum[i] = outside + steady;
        part[i] = steady - through;
    }
    for (int m = 1; m <= 2; m++) {
        const double shifts[3] = {m * shift[0], m * shift[1], m * shift[2]};
        film_sensitivity(m * path, shifts, color);
        for (int i = 0; i < 3; i++) sum[i] += (part[i] *= amplitude[i]) * 2 * color[i];
    }
    return dvec3_make(fmax(sum[0], 0), fmax(sum[1], 0), fmax(sum[2], 0));
}

void ray_film_over(const struct ray_surface *s, dvec3 *dielectric, dvec3 *metal) {
    if (!s->layered) return;
    *dielectric = dvec3_lerp(*dielectric, s->layers.film_dielectric, s->layers.film);
    *metal = dvec3_lerp(*metal, s->layers.film_metal, s->layers.film);
}

/* ---- light that goes through ---- */

double ray_opaque_part(const struct ray_surface *s) {
    return s->layered ? (1 - s->layers.transmission) * (1 - s->layers.diffuse_transmission) : 1;
}

bool ray_lets_through(const struct ray_surface *s) { return s->layered && (s->layers.transmission > 0 || s->layers.diffuse_transmission > 0); }

/* The part of the light that gets below the surface at a microfacet; dielectric part only. */
static double below(const struct ray_surface *s, dvec3 v, dvec3 h) {
    if (s->conserving) return s->below * (1 - s->metallic) * s->layers.below_sheen * s->layers.below_coat;
    const dvec3 f90 = {s->f90, s->f90, s->f90};
    dvec3 fresnel = dvec3_lerp(s->f0, f90, pow(1 - clamp01(dvec3_dot(h, v)), 5));
    fresnel = dvec3_lerp(fresnel, s->layers.film_dielectric, s->layers.film);
    return (1 - dvec3_max(fresnel)) * (1 - s->metallic) * s->layers.below_sheen * s->layers.below_coat;
}

dvec3 ray_through_weight(const struct ray_surface *s, dvec3 v, dvec3 h) { return dvec3_scale(s->base_color, below(s, v, h) * s->layers.transmission); }

/* By the mirror image of the light, in front of the surface. */
dvec3 ray_behind_cos(const struct ray_surface *s, dvec3 v, dvec3 l) {
    dvec3 image = dvec3_add_scaled(l, s->normal, -2 * dvec3_dot(s->normal, l)), h = dvec3_normalize(dvec3_add(image, v));
    double n_l = dvec3_dot(s->normal, image);
    struct ray_surface sheet = *s;
    sheet.layers.anisotropy = 0;
    const double slope = s->layers.thickness > 0 ? fmin(fmax((s->layers.ior - 1) * 0.7071, 0), 1) : 1;
    sheet.roughness = s->layers.transmission > 0 ? sqrt(fmax(ray_alpha(s) * slope, 1e-3)) : s->roughness;
    dvec3 attenuated = {exp(-s->layers.absorption.x * s->layers.thickness), exp(-s->layers.absorption.y * s->layers.thickness),
                        exp(-s->layers.absorption.z * s->layers.thickness)};
    const double transmission = s->lamps_shine_through ? 0 : s->layers.transmission;
    dvec3 straight = dvec3_scale(dvec3_mul(s->base_color, attenuated), transmission * ray_specular_lobe(&sheet, v, image, h));
    dvec3 diffuse = dvec3_scale(s->layers.diffuse_transmission_color, s->layers.diffuse_transmission * (1 - s->layers.transmission) / DPI);
    const double facing = ray_facing(dvec3_scale(s->geometric, -1), dvec3_scale(s->normal, -1), l);
    return dvec3_scale(dvec3_add(straight, diffuse), below(s, v, h) * n_l * facing);
}

/* ---- energy (shaders/energy.glsl) ---- */

/* Reflectance of a specular lobe in uniform light, by single and by multiple scattering (Fdez-Agüera 2019). */
struct energy_lobe {
    dvec3 once, again;
};

static struct energy_lobe energy_lobe(dvec3 f0, dvec3 f90, const double albedo[2], bool conserving) {
    const double rest = 1 - albedo[0] - albedo[1];
    const dvec3 once = dvec3_add_scaled(dvec3_scale(f0, albedo[0]), f90, albedo[1]), mean = dvec3_lerp(f0, f90, 1.0 / 21);
    const dvec3 again = {once.x * mean.x * rest / (1 - mean.x * rest), once.y * mean.y * rest / (1 - mean.y * rest), once.z * mean.z * rest / (1 - mean.z * rest)};
    return (struct energy_lobe){once, conserving ? again : (dvec3){0, 0, 0}};
}

/* The part of even light that gets below a dielectric surface. In appendix B it is the mean of 1 - F, here by a fit of the mean of (1 - v.h)^5, within 0.0003. */
static double energy_below(dvec3 f0, dvec3 f90, struct energy_lobe lobe, double n_v, bool conserving) {
    const double grazing = exp2(-5.1593 - n_v * (3.8194 + 2.4681 * n_v));
    return 1 - dvec3_max(conserving ? dvec3_add(lobe.once, lobe.again) : dvec3_lerp(f0, f90, grazing));
}

double ray_energy_below(dvec3 f0, double f90, double n_v) {
    return energy_below(f0, dvec3_make(f90, f90, f90), (struct energy_lobe){{0, 0, 0}, {0, 0, 0}}, n_v, false);
}

/* Reflectances of the dielectric part, and of the metal, along the normal and at grazing angles. */
static void reflectances(const struct ray_surface *s, dvec3 f0[2], dvec3 f90[2]) {
    f0[0] = s->f0, f90[0] = dvec3_make(s->f90, s->f90, s->f90);
    f0[1] = s->base_color, f90[1] = dvec3_make(1, 1, 1);
    ray_film_over(s, &f0[0], &f0[1]);
    ray_film_over(s, &f90[0], &f90[1]);
}

void ray_energy_prepare(const struct ray_albedos *albedos, struct ray_surface *s, dvec3 to_view) {
    const double n_v = clamp01(dvec3_dot(s->normal, to_view));
    double albedo[2];
    dvec3 f0[2], f90[2];
    ray_specular_albedo(albedos, s->roughness, n_v, albedo);
    reflectances(s, f0, f90);
    const struct energy_lobe dielectric = energy_lobe(f0[0], f90[0], albedo, true), metal = energy_lobe(f0[1], f90[1], albedo, true);
    s->conserving = true;
    s->below = energy_below(f0[0], f90[0], dielectric, n_v, true);
    s->between = dvec3_lerp(dielectric.again, metal.again, s->metallic);
}

/* ---- all ---- */

void ray_layers_prepare(const struct ray_albedos *albedos, struct ray_surface *s, dvec3 to_view) {
    if (!s->layered) return;
    struct ray_layers *l = &s->layers;
    const double n_v = clamp01(dvec3_dot(s->normal, to_view));
    l->below_coat = 1 - l->clearcoat * coat_albedo(albedos, l->clearcoat_roughness, dvec3_dot(l->clearcoat_normal, to_view));
    l->below_sheen = 1 - dvec3_max(l->sheen_color) * ray_sheen_albedo(albedos, l->sheen_roughness, n_v);
    if (!(l->film > 0)) return;
    l->film_dielectric = dvec3_scale(film_reflectance(n_v, l->film_ior, l->film_thickness, dvec3_scale(s->f0, 1 / fmax(s->f90, 1e-6))), s->f90);
    l->film_metal = film_reflectance(n_v, l->film_ior, l->film_thickness, s->base_color);
}

double ray_below_layers(const struct ray_surface *s) { return s->layered ? s->layers.below_coat * s->layers.below_sheen : 1; }

dvec3 ray_layers_over(const struct ray_surface *s, dvec3 v, dvec3 l, dvec3 h, dvec3 base) {
    const struct ray_layers *layers = &s->layers;
    const double n_l = dvec3_dot(s->normal, l);
    base = dvec3_scale(base, layers->below_sheen);
    if (n_l > 0 && dvec3_max(layers->sheen_color) > 0) {
        double lobe = ray_sheen_lobe(layers->sheen_roughness, n_l, clamp01(dvec3_dot(s->normal, v)), clamp01(dvec3_dot(s->normal, h)));
        base = dvec3_add_scaled(base, layers->sheen_color, lobe * n_l * ray_facing(s->geometric, s->normal, l));
    }
    const double coat = coat_lobe(s, v, l, h);
    return dvec3_add(dvec3_scale(base, layers->below_coat), dvec3_make(coat, coat, coat));
}

struct ray_layer_lobes ray_layer_lobes(const struct ray_surface *s) {
    struct ray_layer_lobes lobes = {.coat_share = 0};
    if (!s->layered) return lobes;
    const struct ray_surface varnish = coat_of(s);
    lobes.coat = ray_mirror_of(&varnish);
    lobes.coat_share = s->layers.clearcoat > 0 ? CLAMP(1 - s->layers.below_coat, 0.2, 0.8) : 0;
    lobes.even_share = dvec3_max(s->layers.sheen_color) > 0 ? 0.3 * (1 - lobes.coat_share) : 0;
    lobes.behind_share = s->layers.diffuse_transmission > 0 ? 0.4 : 0;
    return lobes;
}

/* ---- ambient light ---- */

dvec3 ray_sky(dvec3 direction, dvec3 sky, dvec3 ground) { return dvec3_lerp(ground, sky, direction.y * 0.5 + 0.5); }

static dvec3 mirrored(dvec3 normal, dvec3 v) { return dvec3_sub(dvec3_scale(normal, 2 * dvec3_dot(normal, v)), v); }

/* What a lobe is aimed at: wide ones are bent to the normal (Lagarde and de Rousiers 2014, "Moving Frostbite to Physically Based Rendering"). */
static dvec3 lobe_direction(dvec3 normal, double roughness, dvec3 v) {
    const double alpha = roughness * roughness, smooth = 1 - alpha;
    return dvec3_normalize(dvec3_lerp(normal, mirrored(normal, v), smooth * (sqrt(smooth) + alpha)));
}

dvec3 ray_layers_ambient(const struct ray_albedos *albedos, const struct ray_surface *s, dvec3 v, dvec3 sky, dvec3 ground) {
    const struct ray_layers none = {.below_coat = 1, .below_sheen = 1, .clearcoat_normal = s->normal}, *l = s->layered ? &s->layers : &none;
    const double n_v = clamp01(dvec3_dot(s->normal, v));
    double albedo[2];
    dvec3 normal = s->normal, f0[2], f90[2];
    if (l->anisotropy > 0) { /* microfacets lean along the tangent, so those nearest to the viewer count */
        const dvec3 across = dvec3_cross(s->normal, l->tangent);
        const double bend = pow(1 - l->anisotropy * (1 - s->roughness), 4);
        normal = dvec3_normalize(dvec3_lerp(dvec3_normalize(dvec3_add_scaled(v, across, -dvec3_dot(across, v))), s->normal, bend));
    }
    ray_specular_albedo(albedos, s->roughness, n_v, albedo);
    const dvec3 around = ray_sky(s->normal, sky, ground), seen = ray_sky(lobe_direction(normal, s->roughness, v), sky, ground);
    reflectances(s, f0, f90);
    const struct energy_lobe coated = energy_lobe(f0[0], f90[0], albedo, s->conserving), metallic = energy_lobe(f0[1], f90[1], albedo, s->conserving);
    dvec3 dielectric = dvec3_add(dvec3_mul(coated.once, seen), dvec3_mul(coated.again, around));
    const dvec3 metal = dvec3_add(dvec3_mul(metallic.once, seen), dvec3_mul(metallic.again, around));
    dvec3 base = dvec3_scale(dvec3_mul(s->base_color, around), 1 - l->diffuse_transmission);
    base = dvec3_add_scaled(base, dvec3_mul(l->diffuse_transmission_color, ray_sky(dvec3_scale(s->normal, -1), sky, ground)), l->diffuse_transmission);
    dielectric = dvec3_add_scaled(dielectric, base, (1 - l->transmission) * energy_below(f0[0], f90[0], coated, n_v, s->conserving));
    dvec3 light = dvec3_scale(dvec3_lerp(dielectric, metal, s->metallic), l->below_sheen);
    light = dvec3_add(light, dvec3_mul(dvec3_scale(l->sheen_color, ray_sheen_albedo(albedos, l->sheen_roughness, n_v)), around));
    const dvec3 coat = ray_sky(lobe_direction(l->clearcoat_normal, l->clearcoat_roughness, v), sky, ground);
    light = dvec3_add_scaled(dvec3_scale(light, l->below_coat), coat, 1 - l->below_coat);
    return dvec3_scale(light, s->occlusion);
}
