/* SPDX-License-Identifier: MIT */
#include "ray/microfacet.h"

#include "base/base.h"

double ray_alpha(const struct ray_surface *s) { return fmax(s->roughness * s->roughness, 1e-3); }

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
    double alpha = ray_alpha(s), a = s->layers.anisotropy;
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
double ray_specular_lobe(const struct ray_surface *s, dvec3 v, dvec3 l, dvec3 h) {
    if (!(dvec3_dot(h, l) > 0 && dvec3_dot(h, v) > 0)) return 0;
    if (s->layered && s->layers.anisotropy > 0) {
        double alphas[2];
        stretched_alphas(s, alphas);
        return stretched_distribution(s, alphas, h) / (stretched_masking(s, alphas, l) * stretched_masking(s, alphas, v));
    }
    double alpha = ray_alpha(s);
    return distribution(alpha, dvec3_dot(s->normal, h)) / (masking(alpha, dvec3_dot(s->normal, l)) * masking(alpha, dvec3_dot(s->normal, v)));
}

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

struct ray_mirror ray_mirror_of(const struct ray_surface *s) {
    struct ray_mirror m = {.normal = s->normal, .alphas = {ray_alpha(s), ray_alpha(s)}};
    dvec3_basis(s->normal, &m.side, &m.up);
    if (!s->layered || !(s->layers.anisotropy > 0)) return m;
    stretched_alphas(s, m.alphas);
    m.side = s->layers.tangent;
    m.up = dvec3_cross(s->normal, m.side);
    return m;
}

/* Normal maps may lean away from the viewer. */
static dvec3 mirror_view(const struct ray_mirror *m, dvec3 to_view) {
    return dvec3_normalize(dvec3_make(dvec3_dot(to_view, m->side), dvec3_dot(to_view, m->up), fmax(dvec3_dot(to_view, m->normal), 1e-4)));
}

dvec3 ray_mirror_sample(const struct ray_mirror *m, dvec3 to_view, double u1, double u2) {
    dvec3 v = mirror_view(m, to_view), h = visible_normal(m->alphas, v, u1, u2), l = dvec3_sub(dvec3_scale(h, 2 * dvec3_dot(v, h)), v);
    return dvec3_combine(m->side, m->up, m->normal, l);
}

/* Visible normals have the density D max(v.h, 0) 2 / masking, mirroring divides by 4 v.h. */
double ray_mirror_density(const struct ray_mirror *m, dvec3 to_view, dvec3 to_light) {
    const dvec3 v = mirror_view(m, to_view), l = {dvec3_dot(to_light, m->side), dvec3_dot(to_light, m->up), dvec3_dot(to_light, m->normal)};
    if (!(l.z > 0)) return 0;
    const dvec3 h = dvec3_normalize(dvec3_add(v, l));
    const double x = h.x / m->alphas[0], y = h.y / m->alphas[1], f = x * x + y * y + h.z * h.z;
    const double across = pow(m->alphas[0] * v.x, 2) + pow(m->alphas[1] * v.y, 2);
    return h.z > 0 ? 1 / (DPI * m->alphas[0] * m->alphas[1] * f * f) / (2 * (v.z + sqrt(across + v.z * v.z))) : 0;
}

dvec3 ray_microfacet_sample(const struct ray_surface *s, dvec3 to_view, const double random[2]) {
    struct ray_mirror m = {.normal = s->normal, .alphas = {ray_alpha(s), ray_alpha(s)}};
    dvec3_basis(s->normal, &m.side, &m.up);
    return dvec3_combine(m.side, m.up, m.normal, visible_normal(m.alphas, mirror_view(&m, to_view), random[0], random[1]));
}
