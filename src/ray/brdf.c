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

dvec3 ray_brdf_cos(const struct ray_surface *s, dvec3 v, dvec3 l) {
    const dvec3 none = {0, 0, 0};
    double n_l = dvec3_dot(s->normal, l);
    if (!(n_l > 0)) return none;
    dvec3 h = dvec3_add(l, v);
    if (dvec3_length(h) == 0) return none;
    h = dvec3_normalize(h);
    double alpha = alpha_of(s), n_v = dvec3_dot(s->normal, v), h_v = clamp01(dvec3_dot(h, v));
    double lobe = 0;
    if (dvec3_dot(h, l) > 0 && h_v > 0)
        lobe = distribution(alpha, dvec3_dot(s->normal, h)) / (masking(alpha, n_l) * masking(alpha, n_v));
    double weight = pow(1 - h_v, 5);
    const dvec3 f90 = {s->f90, s->f90, s->f90}, white = {1, 1, 1};
    dvec3 fresnel = dvec3_lerp(s->f0, f90, weight);
    dvec3 dielectric = dvec3_add_scaled(dvec3_scale(s->base_color, (1 - dvec3_max(fresnel)) / DPI), fresnel, lobe);
    dvec3 metal = dvec3_scale(dvec3_lerp(s->base_color, white, weight), lobe);
    return dvec3_scale(dvec3_lerp(dielectric, metal, s->metallic), n_l);
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
static dvec3 visible_normal(double alpha, dvec3 v, double u1, double u2) {
    dvec3 stretched = dvec3_normalize(dvec3_make(alpha * v.x, alpha * v.y, v.z)), t1, t2;
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
    return dvec3_normalize(dvec3_make(alpha * n.x, alpha * n.y, fmax(n.z, 1e-12)));
}

/* The chance that the specular lobe is chosen. */
static double specular_share(const struct ray_surface *s, double n_v) {
    double weight = pow(1 - clamp01(n_v), 5);
    const dvec3 f90 = {s->f90, s->f90, s->f90}, white = {1, 1, 1};
    dvec3 fresnel = dvec3_lerp(s->f0, f90, weight);
    double specular = dvec3_luminance(dvec3_lerp(fresnel, dvec3_lerp(s->base_color, white, weight), s->metallic));
    double diffuse = dvec3_luminance(s->base_color) * (1 - dvec3_max(fresnel)) * (1 - s->metallic);
    if (!(specular > 0)) return 0;
    return diffuse > 0 ? CLAMP(specular / (specular + diffuse), 0.1, 0.9) : 1;
}

dvec3 ray_brdf_sample(const struct ray_surface *s, dvec3 to_view, const double random[3], dvec3 *to_light) {
    const dvec3 none = {0, 0, 0};
    dvec3 side, up;
    dvec3_basis(s->normal, &side, &up);
    dvec3 v = {dvec3_dot(to_view, side), dvec3_dot(to_view, up), fmax(dvec3_dot(to_view, s->normal), 1e-4)}, l;
    v = dvec3_normalize(v); /* normal maps may lean away from the viewer */
    double alpha = alpha_of(s), share = specular_share(s, v.z);
    if (random[0] < share) {
        dvec3 h = visible_normal(alpha, v, random[1], random[2]);
        l = dvec3_sub(dvec3_scale(h, 2 * dvec3_dot(v, h)), v);
    } else {
        double radius = sqrt(random[1]), angle = 2 * DPI * random[2];
        l = dvec3_make(radius * cos(angle), radius * sin(angle), sqrt(fmax(1 - random[1], 0)));
    }
    *to_light = dvec3_combine(side, up, s->normal, l);
    if (!(l.z > 0)) return none;
    /* Both lobes may have given it. Visible normals have the density D max(v.h, 0) 2 / masking, mirroring divides by 4 v.h. */
    dvec3 h = dvec3_normalize(dvec3_add(v, l));
    double density = (1 - share) * l.z / DPI + share * distribution(alpha, h.z) / (2 * masking(alpha, v.z));
    return density > 0 ? dvec3_scale(dvec3_add_scaled(ray_brdf_cos(s, to_view, *to_light), s->again, l.z / DPI), 1 / density) : none;
}
