/* SPDX-License-Identifier: MIT */
#include "ray/brdf.h"

#include "base/base.h"

static double alpha_of(const struct ray_surface *s) { return fmax(s->roughness * s->roughness, 1e-3); }

double ray_ior_reflectance(double ior) {
    double r = ior == 0 ? 1 : (ior - 1) / (ior + 1);
    return r * r;
}

/* Trowbridge-Reitz distribution. */
static double distribution(double alpha, double n_h) {
    double a2 = alpha * alpha, f = n_h * n_h * (a2 - 1) + 1;
    return n_h > 0 ? a2 / (DPI * f * f) : 0;
}

/* |n.v| + sqrt(a2 + (1 - a2) (n.v)^2): 2 |n.v| of it is what of the microfacets is not masked. */
static double masking(double alpha, double n_v) {
    double a2 = alpha * alpha;
    return fabs(n_v) + sqrt(a2 + (1 - a2) * n_v * n_v);
}

/* Of two roughnesses, along the tangent and across it. */
static void stretched_alphas(const struct ray_surface *s, double out[2]) {
    double alpha = alpha_of(s), a = s->layers.anisotropy;
    out[0] = alpha + (1 - alpha) * a * a;
    out[1] = alpha;
}

static double stretched_masking(const struct ray_surface *s, const double alphas[2], dvec3 v) {
    dvec3 across = dvec3_cross(s->normal, s->layers.tangent);
    double n_v = fabs(dvec3_dot(s->normal, v));
    return n_v + sqrt(pow(alphas[0] * dvec3_dot(s->layers.tangent, v), 2) + pow(alphas[1] * dvec3_dot(across, v), 2) + n_v * n_v);
}

static double stretched_distribution(const struct ray_surface *s, const double alphas[2], dvec3 h) {
    dvec3 across = dvec3_cross(s->normal, s->layers.tangent);
    double n_h = dvec3_dot(s->normal, h), x = dvec3_dot(s->layers.tangent, h) / alphas[0], y = dvec3_dot(across, h) / alphas[1];
    double f = x * x + y * y + n_h * n_h;
    return n_h > 0 ? 1 / (DPI * alphas[0] * alphas[1] * f * f) : 0;
}

/* The specular lobe without Fresnel; `h` halves the angle between l and v. */
static double specular_lobe(const struct ray_surface *s, dvec3 v, dvec3 l, dvec3 h) {
    if (!(dvec3_dot(h, l) > 0 && dvec3_dot(h, v) > 0)) return 0;
    if (s->layered && s->layers.anisotropy > 0) {
        double alphas[2];
        stretched_alphas(s, alphas);
        return stretched_distribution(s, alphas, h) / (stretched_masking(s, alphas, l) * stretched_masking(s, alphas, v));
    }
    double alpha = alpha_of(s);
    return distribution(alpha, dvec3_dot(s->normal, h)) / (masking(alpha, dvec3_dot(s->normal, l)) * masking(alpha, dvec3_dot(s->normal, v)));
}

static dvec3 base_cos(const struct ray_surface *s, dvec3 v, dvec3 l, dvec3 h) {
    const dvec3 none = {0, 0, 0}, f90 = {s->f90, s->f90, s->f90}, white = {1, 1, 1};
    double n_l = dvec3_dot(s->normal, l), lobe = specular_lobe(s, v, l, h), weight = pow(1 - clamp01(dvec3_dot(h, v)), 5);
    if (!(n_l > 0)) return none;
    dvec3 fresnel = dvec3_lerp(s->f0, f90, weight), metal = dvec3_lerp(s->base_color, white, weight);
    if (s->layered) {
        fresnel = dvec3_lerp(fresnel, s->layers.film_dielectric, s->layers.film);
        metal = dvec3_lerp(metal, s->layers.film_metal, s->layers.film);
    }
    const double own = s->layered ? (1 - s->layers.transmission) * (1 - s->layers.diffuse_transmission) : 1;
    dvec3 dielectric = dvec3_add_scaled(dvec3_scale(s->base_color, (1 - dvec3_max(fresnel)) * own / DPI), fresnel, lobe);
    return dvec3_scale(dvec3_lerp(dielectric, dvec3_scale(metal, lobe), s->metallic), n_l);
}

/* ---- layers ---- */

static const double coat_f0 = 0.04;

static struct ray_surface coat_of(const struct ray_surface *s) {
    return (struct ray_surface){.normal = s->layers.clearcoat_normal, .roughness = s->layers.clearcoat_roughness};
}

static double sheen_masking(double cosine, double alpha) {
    static const double ends[5][2] = {{21.5473, 25.3245}, {3.82987, 3.32435}, {0.19823, 0.16801}, {-1.97760, -1.27393}, {-4.32054, -4.85967}};
    double fit[5], at[2] = {cosine < 0.5 ? cosine : 1 - cosine, 0.5}, value[2];
    for (int i = 0; i < 5; i++) fit[i] = ends[i][0] + (ends[i][1] - ends[i][0]) * (1 - alpha) * (1 - alpha);
    for (int i = 0; i < 2; i++) value[i] = fit[0] / (1 + fit[1] * pow(at[i], fit[2])) + fit[3] * at[i] + fit[4];
    return exp(cosine < 0.5 ? value[0] : 2 * value[1] - value[0]);
}

static double sheen_lobe(double roughness, double n_l, double n_v, double n_h) {
    double alpha = fmax(roughness * roughness, 1e-3), facing = fmax(n_v, 1e-3);
    double distribution = (2 + 1 / alpha) * pow(fmax(1 - n_h * n_h, 0), 0.5 / alpha) / (2 * DPI);
    return distribution / ((1 + sheen_masking(facing, alpha) + sheen_masking(n_l, alpha)) * 4 * n_l * facing);
}

bool ray_lets_through(const struct ray_surface *s) { return s->layered && (s->layers.transmission > 0 || s->layers.diffuse_transmission > 0); }

/* What gets below the surface by a microfacet, of the dielectric part. */
static double below(const struct ray_surface *s, dvec3 v, dvec3 h) {
    const dvec3 f90 = {s->f90, s->f90, s->f90};
    dvec3 fresnel = dvec3_lerp(s->f0, f90, pow(1 - clamp01(dvec3_dot(h, v)), 5));
    fresnel = dvec3_lerp(fresnel, s->layers.film_dielectric, s->layers.film);
    return (1 - dvec3_max(fresnel)) * (1 - s->metallic) * s->layers.below_sheen * s->layers.below_coat;
}

dvec3 ray_through_weight(const struct ray_surface *s, dvec3 v, dvec3 h) { return dvec3_scale(s->base_color, below(s, v, h) * s->layers.transmission); }

/* By the mirror image of the light, in front of the surface. */
static dvec3 behind_cos(const struct ray_surface *s, dvec3 v, dvec3 l) {
    dvec3 image = dvec3_add_scaled(l, s->normal, -2 * dvec3_dot(s->normal, l)), h = dvec3_normalize(dvec3_add(image, v));
    double n_l = dvec3_dot(s->normal, image);
    struct ray_surface sheet = *s;
    sheet.layers.anisotropy = 0;
    const double slope = s->layers.thickness > 0 ? fmin(fmax((s->layers.ior - 1) * 0.7071, 0), 1) : 1;
    sheet.roughness = s->layers.transmission > 0 ? sqrt(fmax(alpha_of(s) * slope, 1e-3)) : s->roughness;
    dvec3 attenuated = {exp(-s->layers.absorption.x * s->layers.thickness), exp(-s->layers.absorption.y * s->layers.thickness),
                        exp(-s->layers.absorption.z * s->layers.thickness)};
    const double transmission = s->lamps_shine_through ? 0 : s->layers.transmission;
    dvec3 straight = dvec3_scale(dvec3_mul(s->base_color, attenuated), transmission * specular_lobe(&sheet, v, image, h));
    dvec3 diffuse = dvec3_scale(s->layers.diffuse_transmission_color, s->layers.diffuse_transmission * (1 - s->layers.transmission) / DPI);
    return dvec3_scale(dvec3_add(straight, diffuse), below(s, v, h) * n_l);
}

dvec3 ray_brdf_cos(const struct ray_surface *s, dvec3 v, dvec3 l) {
    const dvec3 none = {0, 0, 0};
    if (ray_lets_through(s) && dvec3_dot(s->normal, l) < 0) return behind_cos(s, v, l);
    dvec3 h = dvec3_add(l, v);
    if (dvec3_length(h) == 0) return none;
    h = dvec3_normalize(h);
    dvec3 base = base_cos(s, v, l, h);
    if (!s->layered) return base;
    const struct ray_layers *layers = &s->layers;
    double n_l = dvec3_dot(s->normal, l);
    base = dvec3_scale(base, layers->below_sheen);
    if (n_l > 0 && dvec3_max(layers->sheen_color) > 0) {
        double lobe = sheen_lobe(layers->sheen_roughness, n_l, clamp01(dvec3_dot(s->normal, v)), clamp01(dvec3_dot(s->normal, h)));
        base = dvec3_add_scaled(base, layers->sheen_color, lobe * n_l);
    }
    base = dvec3_scale(base, layers->below_coat);
    const struct ray_surface coat = coat_of(s);
    n_l = dvec3_dot(coat.normal, l);
    if (!(layers->clearcoat > 0 && n_l > 0)) return base;
    double reflected = layers->clearcoat * (coat_f0 + (1 - coat_f0) * pow(1 - clamp01(dvec3_dot(h, v)), 5)) * specular_lobe(&coat, v, l, h) * n_l;
    return dvec3_add(base, dvec3_make(reflected, reflected, reflected));
}

dvec3 ray_sky(dvec3 direction, dvec3 sky, dvec3 ground) { return dvec3_lerp(ground, sky, direction.y * 0.5 + 0.5); }

dvec3 ray_ambient(const struct ray_surface *s, dvec3 v, dvec3 sky, dvec3 ground) {
    double n_v = dvec3_dot(s->normal, v), facing = clamp01(n_v);
    double r = s->roughness, rx = 1 - r, ry = 0.0425 - 0.0275 * r, rz = 1.04 - 0.572 * r, rw = 0.022 * r - 0.04;
    double a = fmin(rx * rx, exp2(-9.28 * facing)) * rx + ry, scale = fmax(-1.04 * a + rz, 0),
           bias = fmin(fmax(1.04 * a + rw, 0), 1 - scale);
    double reflected = dvec3_max(s->f0) * scale + s->f90 * bias, grazing = s->f90 * (1 - s->metallic) + s->metallic;
    dvec3 along_normal = ray_sky(s->normal, sky, ground);
    dvec3 mirrored = ray_sky(dvec3_sub(dvec3_scale(s->normal, 2 * n_v), v), sky, ground);
    dvec3 straight = dvec3_scale(dvec3_lerp(s->f0, s->base_color, s->metallic), scale);
    dvec3 specular = dvec3_add(straight, dvec3_make(grazing * bias, grazing * bias, grazing * bias));
    dvec3 diffuse = dvec3_scale(s->base_color, (1 - reflected) * (1 - s->metallic));
    return dvec3_scale(dvec3_add(dvec3_mul(diffuse, along_normal), dvec3_mul(specular, mirrored)), s->occlusion);
}

/* ---- sampling ---- */

/* A normal of the microfacets that the viewer sees; `v` is in the axes of the surface, z along the normal. */
static dvec3 visible_normal(const double alphas[2], dvec3 v, double u1, double u2) {
    dvec3 stretched = dvec3_normalize(dvec3_make(alphas[0] * v.x, alphas[1] * v.y, v.z)), t1, t2;
    dvec3_basis(stretched, &t1, &t2);
    /* Seen along `stretched`, the half of the disk that lies below the horizon shrinks: t2 must point up. */
    dvec3 up = dvec3_add_scaled(dvec3_make(0, 0, 1), stretched, -stretched.z);
    if (dvec3_length(up) > 1e-9) {
        t2 = dvec3_normalize(up);
        t1 = dvec3_cross(t2, stretched);
    }
    double radius = sqrt(u1), angle = 2 * DPI * u2, x = radius * cos(angle), y = radius * sin(angle);
    double part = 0.5 * (1 + stretched.z);
    y = (1 - part) * sqrt(fmax(1 - x * x, 0)) + part * y;
    dvec3 n = dvec3_combine(t1, t2, stretched, dvec3_make(x, y, sqrt(fmax(1 - x * x - y * y, 0))));
    return dvec3_normalize(dvec3_make(alphas[0] * n.x, alphas[1] * n.y, fmax(n.z, 1e-12)));
}

/* The chance that the specular lobe is chosen, of those of the base. */
static double specular_share(const struct ray_surface *s, double n_v) {
    double weight = pow(1 - clamp01(n_v), 5);
    const dvec3 f90 = {s->f90, s->f90, s->f90}, white = {1, 1, 1};
    dvec3 fresnel = dvec3_lerp(s->f0, f90, weight);
    double specular = dvec3_luminance(dvec3_lerp(fresnel, dvec3_lerp(s->base_color, white, weight), s->metallic));
    double diffuse = dvec3_luminance(s->base_color) * (1 - dvec3_max(fresnel)) * (1 - s->metallic);
    if (s->layered) diffuse *= (1 - s->layers.transmission) * (1 - s->layers.diffuse_transmission);
    if (!(specular > 0)) return 0;
    return diffuse > 0 ? CLAMP(specular / (specular + diffuse), 0.1, 0.9) : 1;
}

/* A lobe that mirrors by visible normals. */
struct mirror {
    dvec3 normal, side, up;
    double alphas[2]; /* along side and up */
};

static struct mirror mirror_of(const struct ray_surface *s) {
    struct mirror m = {.normal = s->normal, .alphas = {alpha_of(s), alpha_of(s)}};
    dvec3_basis(s->normal, &m.side, &m.up);
    if (!s->layered || !(s->layers.anisotropy > 0)) return m;
    stretched_alphas(s, m.alphas);
    m.side = s->layers.tangent;
    m.up = dvec3_cross(s->normal, m.side);
    return m;
}

/* Normal maps may lean away from the viewer. */
static dvec3 mirror_view(const struct mirror *m, dvec3 to_view) {
    return dvec3_normalize(dvec3_make(dvec3_dot(to_view, m->side), dvec3_dot(to_view, m->up), fmax(dvec3_dot(to_view, m->normal), 1e-4)));
}

static dvec3 mirror_sample(const struct mirror *m, dvec3 to_view, double u1, double u2) {
    dvec3 v = mirror_view(m, to_view), h = visible_normal(m->alphas, v, u1, u2), l = dvec3_sub(dvec3_scale(h, 2 * dvec3_dot(v, h)), v);
    return dvec3_combine(m->side, m->up, m->normal, l);
}

/* Visible normals have the density D max(v.h, 0) 2 / masking, mirroring divides by 4 v.h. */
static double mirror_density(const struct mirror *m, dvec3 to_view, dvec3 to_light) {
    const dvec3 v = mirror_view(m, to_view), l = {dvec3_dot(to_light, m->side), dvec3_dot(to_light, m->up), dvec3_dot(to_light, m->normal)};
    if (!(l.z > 0)) return 0;
    const dvec3 h = dvec3_normalize(dvec3_add(v, l));
    const double x = h.x / m->alphas[0], y = h.y / m->alphas[1], f = x * x + y * y + h.z * h.z;
    const double across = pow(m->alphas[0] * v.x, 2) + pow(m->alphas[1] * v.y, 2);
    return h.z > 0 ? 1 / (DPI * m->alphas[0] * m->alphas[1] * f * f) / (2 * (v.z + sqrt(across + v.z * v.z))) : 0;
}

dvec3 ray_microfacet_sample(const struct ray_surface *s, dvec3 to_view, const double random[2]) {
    struct mirror m = {.normal = s->normal, .alphas = {alpha_of(s), alpha_of(s)}};
    dvec3_basis(s->normal, &m.side, &m.up);
    return dvec3_combine(m.side, m.up, m.normal, visible_normal(m.alphas, mirror_view(&m, to_view), random[0], random[1]));
}

/* From which lobe a direction is taken, and with what chances. */
struct lobes {
    struct mirror base, coat;
    double mirrors, coat_share, even_share; /* of those in front; even: fibres, directions all over the hemisphere; mirrors: of what is left then */
    double behind_share;                    /* diffuse light from below is none of the others' */
};

static struct lobes lobes_of(const struct ray_surface *s, dvec3 to_view) {
    struct lobes l = {.base = mirror_of(s), .mirrors = specular_share(s, fmax(dvec3_dot(s->normal, to_view), 1e-4))};
    if (!s->layered) return l;
    const struct ray_surface varnish = coat_of(s);
    l.coat = mirror_of(&varnish);
    l.coat_share = s->layers.clearcoat > 0 ? CLAMP(1 - s->layers.below_coat, 0.2, 0.8) : 0;
    l.even_share = dvec3_max(s->layers.sheen_color) > 0 ? 0.3 * (1 - l.coat_share) : 0;
    l.behind_share = s->layers.diffuse_transmission > 0 ? 0.4 : 0;
    return l;
}

static double density_of(const struct ray_surface *s, const struct lobes *l, dvec3 v, dvec3 to_light) {
    const double n_l = dvec3_dot(s->normal, to_light), rest = 1 - l->coat_share - l->even_share;
    if (!(n_l > 0) && s->layered) return l->behind_share * -n_l / DPI; /* light from below has ways of its own */
    double density = rest * ((1 - l->mirrors) * fmax(n_l, 0) / DPI + l->mirrors * mirror_density(&l->base, v, to_light));
    if (l->coat_share > 0) density += l->coat_share * mirror_density(&l->coat, v, to_light);
    if (n_l > 0) density += l->even_share / (2 * DPI);
    return (1 - l->behind_share) * density;
}

/* f cos, of light that paths bring. */
static dvec3 path_cos(const struct ray_surface *s, dvec3 v, dvec3 to_light) {
    const dvec3 none = {0, 0, 0};
    const double n_l = dvec3_dot(s->normal, to_light);
    if (n_l > 0) return dvec3_add_scaled(ray_brdf_cos(s, v, to_light), s->again, n_l / DPI);
    if (!s->layered || !(s->layers.diffuse_transmission > 0)) return none;
    struct ray_surface paper = *s;
    paper.layers.transmission = 0;
    return dvec3_scale(behind_cos(&paper, v, to_light), 1 - s->layers.transmission);
}

dvec3 ray_brdf_light(const struct ray_surface *s, dvec3 to_view, dvec3 to_light, double *density) {
    const struct lobes lobes = lobes_of(s, to_view);
    *density = density_of(s, &lobes, to_view, to_light);
    return path_cos(s, to_view, to_light);
}

dvec3 ray_brdf_sample(const struct ray_surface *s, dvec3 to_view, const double random[3], dvec3 *to_light, double *density) {
    const dvec3 none = {0, 0, 0};
    const struct lobes lobes = lobes_of(s, to_view);
    const bool behind = random[0] < lobes.behind_share;
    const double chosen = (random[0] - lobes.behind_share) / (1 - lobes.behind_share), mirrors = lobes.mirrors * (1 - lobes.coat_share - lobes.even_share);
    if (!behind && chosen < lobes.coat_share) {
        *to_light = mirror_sample(&lobes.coat, to_view, random[1], random[2]);
    } else if (!behind && chosen - lobes.coat_share < mirrors) {
        *to_light = mirror_sample(&lobes.base, to_view, random[1], random[2]);
    } else {
        const bool even = !behind && chosen - lobes.coat_share - mirrors < lobes.even_share;
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
    struct ray_surface s = {.normal = {0, 0, 1}, .base_color = {1, 1, 1}, .metallic = 1, .roughness = roughness};
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
        sum += sheen_lobe(roughness, n_l, n_v, h.z) * n_l;
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

/* Four entries of a table, and their weights. */
struct albedo_place {
    int r, n;
    double weights[4]; /* of r, n; r, n + 1; r + 1, n; r + 1, n + 1 */
};

static struct albedo_place albedo_place(double roughness, double n_v) {
    const double y = clamp01(roughness) * (RAY_ALBEDO_SIDE - 1), x = clamp01(n_v) * (RAY_ALBEDO_SIDE - 1);
    struct albedo_place p = {.r = (int)fmin(y, RAY_ALBEDO_SIDE - 2), .n = (int)fmin(x, RAY_ALBEDO_SIDE - 2)};
    const double fy = y - p.r, fx = x - p.n;
    p.weights[0] = (1 - fy) * (1 - fx);
    p.weights[1] = (1 - fy) * fx;
    p.weights[2] = fy * (1 - fx);
    p.weights[3] = fy * fx;
    return p;
}

void ray_specular_albedo(const struct ray_albedos *albedos, double roughness, double n_v, double out[2]) {
    const struct albedo_place p = albedo_place(roughness, n_v);
    out[0] = out[1] = 0;
    for (int k = 0; k < 4; k++)
        for (int i = 0; i < 2; i++) out[i] += p.weights[k] * (double)albedos->specular[p.r + k / 2][p.n + k % 2][i];
}

double ray_coat_albedo(const struct ray_albedos *albedos, double roughness, double n_v) {
    double parts[2];
    ray_specular_albedo(albedos, roughness, n_v, parts);
    return coat_f0 * parts[0] + parts[1];
}

static double sheen_albedo_at(const struct ray_albedos *albedos, double roughness, double n_v) {
    const struct albedo_place p = albedo_place(roughness, n_v);
    double sum = 0;
    for (int k = 0; k < 4; k++) sum += p.weights[k] * (double)albedos->sheen[p.r + k / 2][p.n + k % 2];
    return sum;
}

/* ---- film (Belcour and Barla 2017, "A Practical Extension to Microfacet Theory for the Modeling of Varying Iridescence") ---- */

static double schlick(double f0, double cosine) { return f0 + (1 - f0) * pow(1 - clamp01(cosine), 5); }

/* The eye's answer to light whose parts are shifted by a path, metres, and by `shift`, radians: Gaussians in the frequency; linear RGB. */
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

void ray_layers_prepare(const struct ray_albedos *albedos, struct ray_surface *s, dvec3 to_view) {
    if (!s->layered) return;
    struct ray_layers *l = &s->layers;
    const double n_v = clamp01(dvec3_dot(s->normal, to_view));
    l->below_coat = 1 - l->clearcoat * ray_coat_albedo(albedos, l->clearcoat_roughness, dvec3_dot(l->clearcoat_normal, to_view));
    l->below_sheen = 1 - dvec3_max(l->sheen_color) * sheen_albedo_at(albedos, l->sheen_roughness, n_v);
    if (!(l->film > 0)) return;
    l->film_dielectric = dvec3_scale(film_reflectance(n_v, l->film_ior, l->film_thickness, dvec3_scale(s->f0, 1 / fmax(s->f90, 1e-6))), s->f90);
    l->film_metal = film_reflectance(n_v, l->film_ior, l->film_thickness, s->base_color);
}

static dvec3 mirrored(dvec3 normal, dvec3 v) { return dvec3_sub(dvec3_scale(normal, 2 * dvec3_dot(normal, v)), v); }

/* What a lobe is aimed at: wide ones are bent to the normal (Lagarde and de Rousiers 2014, "Moving Frostbite to Physically Based Rendering"). */
static dvec3 lobe_direction(dvec3 normal, double roughness, dvec3 v) {
    const double alpha = roughness * roughness, smooth = 1 - alpha;
    return dvec3_normalize(dvec3_lerp(normal, mirrored(normal, v), smooth * (sqrt(smooth) + alpha)));
}

/* Light of a lobe, of what is mirrored once and more often, and the part of light that it takes. */
static dvec3 ambient_lobe(dvec3 f0, dvec3 f90, const double albedo[2], dvec3 once_from, dvec3 around, dvec3 *taken) {
    const double rest = 1 - albedo[0] - albedo[1];
    const dvec3 once = dvec3_add_scaled(dvec3_scale(f0, albedo[0]), f90, albedo[1]), mean = dvec3_lerp(f0, f90, 1.0 / 21);
    const dvec3 again = {once.x * mean.x * rest / (1 - mean.x * rest), once.y * mean.y * rest / (1 - mean.y * rest), once.z * mean.z * rest / (1 - mean.z * rest)};
    *taken = dvec3_add(once, again);
    return dvec3_add(dvec3_mul(once, once_from), dvec3_mul(again, around));
}

dvec3 ray_layers_ambient(const struct ray_albedos *albedos, const struct ray_surface *s, dvec3 v, dvec3 sky, dvec3 ground) {
    const struct ray_layers *l = &s->layers;
    const double n_v = clamp01(dvec3_dot(s->normal, v));
    double albedo[2];
    dvec3 normal = s->normal, taken;
    if (l->anisotropy > 0) { /* microfacets lean along the tangent, so those nearest to the viewer count */
        const dvec3 across = dvec3_cross(s->normal, l->tangent);
        const double bend = pow(1 - l->anisotropy * (1 - s->roughness), 4);
        normal = dvec3_normalize(dvec3_lerp(dvec3_normalize(dvec3_add_scaled(v, across, -dvec3_dot(across, v))), s->normal, bend));
    }
    ray_specular_albedo(albedos, s->roughness, n_v, albedo);
    const dvec3 around = ray_sky(s->normal, sky, ground), seen = ray_sky(lobe_direction(normal, s->roughness, v), sky, ground);
    const dvec3 f90 = {s->f90, s->f90, s->f90}, white = {1, 1, 1};
    dvec3 dielectric = ambient_lobe(dvec3_lerp(s->f0, l->film_dielectric, l->film), dvec3_lerp(f90, l->film_dielectric, l->film), albedo, seen, around, &taken);
    dvec3 base = dvec3_scale(dvec3_mul(s->base_color, around), 1 - l->diffuse_transmission);
    base = dvec3_add_scaled(base, dvec3_mul(l->diffuse_transmission_color, ray_sky(dvec3_scale(s->normal, -1), sky, ground)), l->diffuse_transmission);
    dielectric = dvec3_add_scaled(dielectric, base, (1 - l->transmission) * (1 - dvec3_max(taken)));
    const dvec3 metal = ambient_lobe(dvec3_lerp(s->base_color, l->film_metal, l->film), dvec3_lerp(white, l->film_metal, l->film), albedo, seen, around, &taken);
    dvec3 light = dvec3_scale(dvec3_lerp(dielectric, metal, s->metallic), l->below_sheen);
    light = dvec3_add(light, dvec3_mul(dvec3_scale(l->sheen_color, sheen_albedo_at(albedos, l->sheen_roughness, n_v)), around));
    const dvec3 coat = ray_sky(lobe_direction(l->clearcoat_normal, l->clearcoat_roughness, v), sky, ground);
    light = dvec3_add_scaled(dvec3_scale(light, l->below_coat), coat, 1 - l->below_coat);
    return dvec3_scale(light, s->occlusion);
}
