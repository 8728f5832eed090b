/* SPDX-License-Identifier: MIT */
#include "ray/environment.h"

/* By visible normals: of what they mirror, all but what is shadowed arrives. */
static void reflectance_of(double roughness, double n_v, float out[2]) {
    enum { SIDE = 24 };
    struct ray_surface s = {.normal = {0, 0, 1}, .base_color = {1, 1, 1}, .metallic = 1, .roughness = roughness};
    const dvec3 v = {sqrt(1 - n_v * n_v), 0, n_v};
    double sum[2] = {0, 0};
    for (int i = 0; i < SIDE * SIDE; i++) {
        const double random[3] = {0, (i % SIDE + 0.5) / SIDE, (i / SIDE + 0.5) / SIDE};
        dvec3 l;
        const double all = ray_brdf_sample(&s, v, random, &l).x; /* Fresnel of a white metal is 1 */
        const dvec3 h = dvec3_normalize(dvec3_add(v, l));
        const double grazing = pow(1 - fmin(fmax(dvec3_dot(h, v), 0), 1), 5);
        sum[0] += all * (1 - grazing);
        sum[1] += all * grazing;
    }
    for (int i = 0; i < 2; i++) out[i] = (float)(sum[i] / (SIDE * SIDE));
}

void ray_environment_begin(const struct scene_environment *scene, struct ray_environment *out) {
    out->scene = scene;
    if (!ray_environment_is(out)) return;
    for (int r = 0; r < RAY_REFLECTANCE_SIDE; r++)
        for (int n = 0; n < RAY_REFLECTANCE_SIDE; n++)
            reflectance_of((double)r / (RAY_REFLECTANCE_SIDE - 1), fmax((double)n / (RAY_REFLECTANCE_SIDE - 1), 1e-3), out->reflectance[r][n]);
}

dvec3 ray_environment_from(const struct ray_environment *e, dvec3 d) {
    const struct panorama *p = &e->scene->panorama;
    const double c = cos((double)e->scene->rotation), s = sin((double)e->scene->rotation);
    const dvec3 turned = {c * d.x - s * d.z, d.y, c * d.z + s * d.x};
    const double x = (atan2(turned.z, turned.x) / (2 * DPI) + 0.5) * p->width - 0.5, y = acos(CLAMP(turned.y, -1.0, 1.0)) / DPI * p->height - 0.5;
    const double fx = x - floor(x), fy = y - floor(y);
    dvec3 out = {0, 0, 0};
    for (int k = 0; k < 4; k++) {
        const uint32_t column = (uint32_t)((int64_t)floor(x) + p->width + k % 2) % p->width;
        const uint32_t row = (uint32_t)CLAMP((int64_t)floor(y) + k / 2, (int64_t)0, (int64_t)p->height - 1);
        const float *texel = p->texels + 3 * ((size_t)row * p->width + column);
        const double weight = (k % 2 ? fx : 1 - fx) * (k / 2 ? fy : 1 - fy) * (double)e->scene->intensity;
        out = dvec3_add_scaled(out, dvec3_make((double)texel[0], (double)texel[1], (double)texel[2]), weight);
    }
    return out;
}

static dvec3 again_of(dvec3 f0, double f90, const double reflectance[2]) {
    const double rest = 1 - reflectance[0] - reflectance[1];
    const dvec3 grazing = {f90, f90, f90}, once = dvec3_add_scaled(dvec3_scale(f0, reflectance[0]), grazing, reflectance[1]);
    const dvec3 mean = dvec3_lerp(f0, grazing, 1.0 / 21);
    return dvec3_make(once.x * mean.x * rest / (1 - mean.x * rest), once.y * mean.y * rest / (1 - mean.y * rest), once.z * mean.z * rest / (1 - mean.z * rest));
}

void ray_environment_again(const struct ray_environment *e, struct ray_surface *s, dvec3 to_view) {
    if (!ray_environment_is(e)) return;
    const double at[2] = {CLAMP(s->roughness, 0.0, 1.0) * (RAY_REFLECTANCE_SIDE - 1), CLAMP(dvec3_dot(s->normal, to_view), 0.0, 1.0) * (RAY_REFLECTANCE_SIDE - 1)};
    const int r = (int)fmin(at[0], RAY_REFLECTANCE_SIDE - 2), n = (int)fmin(at[1], RAY_REFLECTANCE_SIDE - 2);
    double reflectance[2];
    for (int i = 0; i < 2; i++) {
        const double low = (double)e->reflectance[r][n][i] * (n + 1 - at[1]) + (double)e->reflectance[r][n + 1][i] * (at[1] - n);
        const double high = (double)e->reflectance[r + 1][n][i] * (n + 1 - at[1]) + (double)e->reflectance[r + 1][n + 1][i] * (at[1] - n);
        reflectance[i] = low * (r + 1 - at[0]) + high * (at[0] - r);
    }
    const dvec3 metal = again_of(s->base_color, 1, reflectance), coat = again_of(s->f0, s->f90, reflectance);
    const dvec3 dielectric = dvec3_add_scaled(coat, s->base_color, -dvec3_max(coat)); /* does not get below */
    s->again = dvec3_lerp(dielectric, metal, s->metallic);
}
