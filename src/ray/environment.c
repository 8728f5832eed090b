/* SPDX-License-Identifier: MIT */
#include "ray/environment.h"

static double along(vec3 axis, dvec3 d) { return (double)axis.x * d.x + (double)axis.y * d.y + (double)axis.z * d.z; }

dvec3 ray_environment_from(const struct ray_environment *e, dvec3 d) {
    const struct panorama *p = &e->scene->panorama;
    const double scale = (double)scene_environment_scale(e->scene);
    vec3 rows[3];
    scene_environment_axes(e->scene, rows);
    const dvec3 turned = dvec3_normalize(dvec3_make(along(rows[0], d), along(rows[1], d), along(rows[2], d)));
    const double x = (atan2(turned.z, turned.x) / (2 * DPI) + 0.5) * p->width - 0.5, y = acos(CLAMP(turned.y, -1.0, 1.0)) / DPI * p->height - 0.5;
    const double fx = x - floor(x), fy = y - floor(y);
    dvec3 out = {0, 0, 0};
    for (int k = 0; k < 4; k++) {
        const uint32_t column = (uint32_t)((int64_t)floor(x) + p->width + k % 2) % p->width;
        const uint32_t row = (uint32_t)CLAMP((int64_t)floor(y) + k / 2, (int64_t)0, (int64_t)p->height - 1);
        const float *texel = p->texels + 3 * ((size_t)row * p->width + column);
        const double weight = (k % 2 ? fx : 1 - fx) * (k / 2 ? fy : 1 - fy) * scale;
        out = dvec3_add_scaled(out, dvec3_make((double)texel[0], (double)texel[1], (double)texel[2]), weight);
    }
    return out;
}

double ray_environment_mean(const struct ray_environment *e) {
    const struct panorama *p = &e->scene->panorama;
    double sum = 0;
    for (uint32_t y = 0; y < p->height; y++) {
        const double share = (cos(DPI * y / p->height) - cos(DPI * (y + 1) / p->height)) / 2 / p->width;
        double row = 0;
        for (uint32_t x = 0; x < p->width; x++) {
            const float *texel = p->texels + 3 * ((size_t)y * p->width + x);
            row += dvec3_luminance(dvec3_make((double)texel[0], (double)texel[1], (double)texel[2]));
        }
        sum += row * share;
    }
    return sum * (double)scene_environment_scale(e->scene);
}

static dvec3 again_of(dvec3 f0, dvec3 f90, const double albedo[2]) {
    const double rest = 1 - albedo[0] - albedo[1];
    const dvec3 once = dvec3_add_scaled(dvec3_scale(f0, albedo[0]), f90, albedo[1]), mean = dvec3_lerp(f0, f90, 1.0 / 21);
    return dvec3_make(once.x * mean.x * rest / (1 - mean.x * rest), once.y * mean.y * rest / (1 - mean.y * rest), once.z * mean.z * rest / (1 - mean.z * rest));
}

void ray_environment_again(const struct ray_environment *e, struct ray_surface *s, dvec3 to_view) {
    if (!ray_environment_is(e)) return;
    double albedo[2];
    ray_specular_albedo(e->albedos, s->roughness, dvec3_dot(s->normal, to_view), albedo);
    dvec3 f0 = s->f0, f90 = {s->f90, s->f90, s->f90}, metal_f0 = s->base_color, metal_f90 = {1, 1, 1};
    double below = 1;
    if (s->layered) {
        f0 = dvec3_lerp(f0, s->layers.film_dielectric, s->layers.film);
        f90 = dvec3_lerp(f90, s->layers.film_dielectric, s->layers.film);
        metal_f0 = dvec3_lerp(metal_f0, s->layers.film_metal, s->layers.film);
        metal_f90 = dvec3_lerp(metal_f90, s->layers.film_metal, s->layers.film);
        below = s->layers.below_coat * s->layers.below_sheen;
    }
    const dvec3 metal = again_of(metal_f0, metal_f90, albedo), coat = again_of(f0, f90, albedo);
    const double own = s->layered ? (1 - s->layers.transmission) * (1 - s->layers.diffuse_transmission) : 1;
    const dvec3 dielectric = dvec3_add_scaled(coat, s->base_color, -dvec3_max(coat) * own); /* does not get below */
    s->again = dvec3_scale(dvec3_lerp(dielectric, metal, s->metallic), below);
}
