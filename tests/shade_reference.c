/* SPDX-License-Identifier: MIT */
#include "tests/shade_reference.h"

#include "tests/light_reference.h"

#include <math.h>
#include <string.h>

static const double REFERENCE_PI = 3.14159265358979323846;

static double dot3(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
static double clamp01(double x) { return fmin(fmax(x, 0), 1); }
static double max3(const double a[3]) { return fmax(a[0], fmax(a[1], a[2])); }

struct reference_surface reference_surface_default(void) {
    return (struct reference_surface){.normal = {0, 0, 1},
                                      .base_color = {1, 1, 1},
                                      .metallic = 1,
                                      .roughness = 1,
                                      .occlusion = 1,
                                      .ior = 1.5,
                                      .specular = 1,
                                      .specular_color = {1, 1, 1}};
}

/* Reflectance of the dielectric part along the normal, and at grazing angles. */
static void dielectric_reflectance(const struct reference_surface *s, double f0[3], double *f90) {
    double r = s->ior == 0 ? 1 : (s->ior - 1) / (s->ior + 1);
    for (int i = 0; i < 3; i++) f0[i] = fmin(r * r * s->specular_color[i], 1) * s->specular;
    *f90 = s->specular;
}

/* Trowbridge-Reitz distribution times separable Smith visibility (appendix B, "Specular BRDF"). */
static double specular_lobe(double alpha, double n_l, double n_v, double n_h, double h_l, double h_v) {
    double a2 = alpha * alpha, d = 0, v = 0;
    if (n_h > 0) {
        double f = n_h * n_h * (a2 - 1) + 1;
        d = a2 / (REFERENCE_PI * f * f);
    }
    if (h_l > 0 && h_v > 0)
        v = 1 / ((fabs(n_l) + sqrt(a2 + (1 - a2) * n_l * n_l)) * (fabs(n_v) + sqrt(a2 + (1 - a2) * n_v * n_v)));
    return d * v;
}

/* f(l, v) cos for light from the upper side; the smallest alpha is 0.001, so that mirrors show point lights. */
static void brdf_cos(const struct reference_surface *s, const double l[3], const double v[3], double out[3]) {
    memset(out, 0, 3 * sizeof *out);
    double n_l = dot3(s->normal, l);
    if (n_l <= 0) return;
    double h[3] = {l[0] + v[0], l[1] + v[1], l[2] + v[2]}, length = sqrt(dot3(h, h));
    if (length == 0) return;
    for (int i = 0; i < 3; i++) h[i] /= length;
    double alpha = fmax(s->roughness * s->roughness, 1e-3), h_v = clamp01(dot3(h, v));
    double lobe = specular_lobe(alpha, n_l, dot3(s->normal, v), dot3(s->normal, h), dot3(h, l), dot3(h, v));
    double f0[3], f90, fresnel[3], weight = pow(1 - h_v, 5);
    dielectric_reflectance(s, f0, &f90);
    for (int i = 0; i < 3; i++) fresnel[i] = f0[i] + (f90 - f0[i]) * weight;
    for (int i = 0; i < 3; i++) {
        double dielectric = (1 - max3(fresnel)) * s->base_color[i] / REFERENCE_PI + fresnel[i] * lobe;
        double metal = (s->base_color[i] + (1 - s->base_color[i]) * weight) * lobe;
        out[i] = (dielectric * (1 - s->metallic) + metal * s->metallic) * n_l;
    }
}

/* Lux at right angles to the ray, with colour. */
static bool illuminate(const fnl_light_params *light, const double position[3], double l[3], double out[3]) {
    double strength = light_reference(light, position, l);
    for (int i = 0; i < 3; i++) out[i] = strength * light->color[i] * light->intensity;
    return strength > 0;
}

/* Ambient light blends from ground to sky by height. The specular part takes it from the mirror direction, through the fit
   of the environment integral by Karis ("Physically Based Shading on Mobile", 2014). */
static void add_ambient(const struct reference_surface *s, const double v[3], fnl_vec3 sky, fnl_vec3 ground, double out[3]) {
    const double skies[3] = {sky.x, sky.y, sky.z}, grounds[3] = {ground.x, ground.y, ground.z};
    double n_v = clamp01(dot3(s->normal, v)), mirror_y = 2 * dot3(s->normal, v) * s->normal[1] - v[1];
    double r = s->roughness, rx = 1 - r, ry = 0.0425 - 0.0275 * r, rz = 1.04 - 0.572 * r, rw = 0.022 * r - 0.04;
    double a = fmin(rx * rx, exp2(-9.28 * n_v)) * rx + ry, scale = fmax(-1.04 * a + rz, 0),
           bias = fmin(fmax(1.04 * a + rw, 0), 1 - scale);
    double f0[3], f90;
    dielectric_reflectance(s, f0, &f90);
    double reflected = max3(f0) * scale + f90 * bias, diffuse = (1 - reflected) * (1 - s->metallic),
           grazing = f90 * (1 - s->metallic) + s->metallic;
    for (int i = 0; i < 3; i++) {
        double along_normal = grounds[i] + (skies[i] - grounds[i]) * (s->normal[1] * 0.5 + 0.5);
        double mirrored = grounds[i] + (skies[i] - grounds[i]) * (mirror_y * 0.5 + 0.5);
        double straight = f0[i] * (1 - s->metallic) + s->base_color[i] * s->metallic;
        out[i] +=
            s->occlusion * (s->base_color[i] * diffuse * along_normal + (straight * scale + grazing * bias) * mirrored);
    }
}

void reference_shade(const struct reference_surface *s, const double to_view[3], const fnl_light_params *lights,
                     uint32_t light_count, fnl_vec3 ambient_sky, fnl_vec3 ambient_ground, double out[3]) {
    memcpy(out, s->emissive, 3 * sizeof *out);
    for (uint32_t k = 0; k < light_count; k++) {
        double l[3], lux[3], f[3];
        if (!illuminate(&lights[k], s->position, l, lux)) continue;
        brdf_cos(s, l, to_view, f);
        for (int i = 0; i < 3; i++) out[i] += lux[i] * f[i];
    }
    add_ambient(s, to_view, ambient_sky, ambient_ground, out);
}

/* ---- tone mapping ---- */

/* Khronos PBR Neutral, as its specification writes it. */
static void khronos_neutral(double c[3]) {
    const double f90 = 0.04, ks = 0.8 - f90, kd = 0.15;
    double x = fmin(c[0], fmin(c[1], c[2])), f = x <= 2 * f90 ? x - x * x / (4 * f90) : f90;
    for (int i = 0; i < 3; i++) c[i] -= f;
    double p = max3(c);
    if (p <= ks) return;
    double pn = 1 - (1 - ks) * (1 - ks) / (p + 1 - 2 * ks), g = 1 / (kd * (p - pn) + 1);
    for (int i = 0; i < 3; i++) c[i] = c[i] * pn / p * g + pn * (1 - g);
}

static void transform(const double rows[3][3], double c[3]) {
    double in[3] = {c[0], c[1], c[2]};
    for (int i = 0; i < 3; i++) c[i] = dot3(rows[i], in);
}

/* The fit by S. Hill of the ACES reference and output transforms. */
static void aces(double c[3]) {
    static const double into[3][3] = {{0.59719, 0.35458, 0.04823}, {0.07600, 0.90834, 0.01566}, {0.02840, 0.13383, 0.83777}};
    static const double back[3][3] = {
        {1.60475, -0.53108, -0.07367}, {-0.10208, 1.10813, -0.00605}, {-0.00327, -0.07276, 1.07602}};
    transform(into, c);
    for (int i = 0; i < 3; i++)
        c[i] = (c[i] * (c[i] + 0.0245786) - 0.000090537) / (c[i] * (0.983729 * c[i] + 0.4329510) + 0.238081);
    transform(back, c);
}

/* AgX by T. Sobotka with B. Wrensch's polynomial of sixth degree. */
static void agx(double c[3]) {
    static const double inset[3][3] = {{0.842479062253094, 0.0784335999999992, 0.0792237451477643},
                                       {0.0423282422610123, 0.878468636469772, 0.0791661274605434},
                                       {0.0423756549057051, 0.0784336, 0.879142973793104}};
    static const double outset[3][3] = {{1.19687900512017, -0.0980208811401368, -0.0990297440797205},
                                        {-0.0528968517574562, 1.15190312990417, -0.0989611768448433},
                                        {-0.0529716355144438, -0.0980434501171241, 1.15107367264116}};
    const double low = -12.47393, high = 4.026069;
    transform(inset, c);
    for (int i = 0; i < 3; i++) {
        double x = (fmin(fmax(log2(fmax(c[i], 1e-10)), low), high) - low) / (high - low);
        c[i] = -0.00232 + x * (0.1191 + x * (0.4298 + x * (-6.868 + x * (31.96 + x * (-40.14 + x * 15.5)))));
    }
    transform(outset, c);
    for (int i = 0; i < 3; i++) c[i] = pow(clamp01(c[i]), 2.2);
}

void reference_tonemap(fnl_tonemap tonemap, const double in[3], double out[3]) {
    memcpy(out, in, 3 * sizeof *out);
    if (tonemap == FNL_TONEMAP_KHRONOS_NEUTRAL) khronos_neutral(out);
    if (tonemap == FNL_TONEMAP_ACES) aces(out);
    if (tonemap == FNL_TONEMAP_AGX) agx(out);
}

double reference_srgb(double linear) {
    double c = clamp01(linear);
    return c <= 0.0031308 ? 12.92 * c : 1.055 * pow(c, 1 / 2.4) - 0.055;
}
