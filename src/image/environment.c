/* SPDX-License-Identifier: MIT */
#include "image/environment.h"

#include <math.h>

/* ---- RGBM ---- */

void rgbm_encode(const float color[3], uint8_t out[4]) {
    float roots[3], most = 0;
    for (int i = 0; i < 3; i++) {
        float c = color[i] > 0 ? color[i] : 0; /* NaN: 0 */
        roots[i] = sqrtf(fminf(c, RGBM_MOST)) / RGBM_RANGE;
        most = fmaxf(most, roots[i]);
    }
    float m = fmaxf(ceilf(most * 255), 1);
    out[3] = (uint8_t)fminf(m, 255);
    for (int i = 0; i < 3; i++) out[i] = (uint8_t)fminf(roundf(roots[i] * 255 * 255 / (float)out[3]), 255);
}

void rgbm_decode(const uint8_t rgbm[4], float out[3]) {
    for (int i = 0; i < 3; i++) {
        float root = (float)rgbm[3] / 255 * RGBM_RANGE * (float)rgbm[i] / 255;
        out[i] = root * root;
    }
}

/* ---- the cube ---- */

static uint32_t mip_side(const struct environment *e, uint32_t mip) { return MAX(e->size >> mip, 1u); }

static size_t mip_start(const struct environment *e, uint32_t mip) {
    size_t texels = 0;
    for (uint32_t i = 0; i < mip; i++) texels += 6 * (size_t)mip_side(e, i) * mip_side(e, i);
    return texels;
}

fnl_result environment_init(const fnl_host *host, uint32_t size, struct environment *out) {
    *out = (struct environment){.size = MAX(size, 1u), .mips = 1};
    while (out->size >> out->mips) out->mips++;
    out->texels = host_allocate_zero(host, mip_start(out, out->mips) * 3 * sizeof(float));
    return out->texels ? FNL_OK : FNL_ERROR_MEMORY;
}

void environment_finish(const fnl_host *host, struct environment *e) {
    if (e->texels) host_free(host, e->texels, mip_start(e, e->mips) * 3 * sizeof(float));
    *e = (struct environment){0};
}

/* The axes of a face: to the right, down, and out. */
static void face_axes(uint32_t face, vec3 axes[3]) {
    static const vec3 all[6][3] = {{{0, 0, -1}, {0, -1, 0}, {1, 0, 0}}, {{0, 0, 1}, {0, -1, 0}, {-1, 0, 0}},
                                   {{1, 0, 0}, {0, 0, 1}, {0, 1, 0}},   {{1, 0, 0}, {0, 0, -1}, {0, -1, 0}},
                                   {{1, 0, 0}, {0, -1, 0}, {0, 0, 1}},  {{-1, 0, 0}, {0, -1, 0}, {0, 0, -1}}};
    memcpy(axes, all[face], sizeof all[face]);
}

static vec3 face_point(uint32_t face, float u, float v) {
    vec3 axes[3];
    face_axes(face, axes);
    return vec3_add(vec3_add(vec3_scale(axes[0], u), vec3_scale(axes[1], v)), axes[2]);
}

static float texel_coordinate(uint32_t at, uint32_t side) { return (2 * (float)at + 1) / (float)side - 1; }

vec3 environment_direction(const struct environment *e, uint32_t mip, uint32_t face, uint32_t x, uint32_t y) {
    uint32_t side = mip_side(e, mip);
    return vec3_normalize(face_point(face, texel_coordinate(x, side), texel_coordinate(y, side)));
}

float *environment_texel(const struct environment *e, uint32_t mip, vec3 direction) {
    uint32_t face = 0, side = mip_side(e, mip);
    float best = -1;
    vec3 axes[3];
    for (uint32_t f = 0; f < 6; f++) {
        face_axes(f, axes);
        float along = vec3_dot(direction, axes[2]);
        if (along > best) {
            best = along;
            face = f;
        }
    }
    face_axes(face, axes);
    float u = vec3_dot(direction, axes[0]) / best, v = vec3_dot(direction, axes[1]) / best;
    uint32_t x = (uint32_t)CLAMP((u + 1) / 2 * (float)side, 0.0f, (float)(side - 1));
    uint32_t y = (uint32_t)CLAMP((v + 1) / 2 * (float)side, 0.0f, (float)(side - 1));
    return e->texels + 3 * (mip_start(e, mip) + ((size_t)face * side + y) * side + x);
}

float environment_mip(uint32_t mips, float roughness) { return CLAMP(roughness, 0.0f, 1.0f) * (float)(mips - 1); }

/* ---- lobes ---- */

double ggx_distribution(double roughness, double n_h) {
    double alpha = roughness * roughness, d = n_h * n_h * (alpha * alpha - 1) + 1;
    return n_h > 0 ? alpha * alpha / ((double)PI * d * d) : 0;
}

double schlick_roughness(double f0, double roughness, double n_v) {
    return f0 + (fmax(1 - roughness, f0) - f0) * pow(1 - CLAMP(n_v, 0.0, 1.0), 5);
}

/* ---- filtering ---- */

/* All of mip 0, each texel by its solid angle; the mirrored lobe about `axis` has the density D / 4 at half the angle. */
static void sum_exactly(const struct environment *e, vec3 axis, double roughness, double out[3]) {
    double weight = 0;
    const float *texel = e->texels;
    for (uint32_t face = 0; face < 6; face++)
        for (uint32_t y = 0; y < e->size; y++)
            for (uint32_t x = 0; x < e->size; x++, texel += 3) {
                vec3 point = face_point(face, texel_coordinate(x, e->size), texel_coordinate(y, e->size));
                double length2 = (double)vec3_dot(point, point), n_l = (double)vec3_dot(axis, point) / sqrt(length2);
                if (n_l <= 0) continue;
                double n_h = sqrt(0.5 * (1 + n_l)), w = ggx_distribution(roughness, n_h) * n_l / (length2 * sqrt(length2));
                for (int c = 0; c < 3; c++) out[c] += w * (double)texel[c];
                weight += w;
            }
    for (int c = 0; c < 3; c++) out[c] = weight > 0 ? out[c] / weight : 0;
}

/* Half vectors by the inverse of the distribution's integral, from Hammersley's points. */
static void sum_samples(const struct environment *e, vec3 axis, double roughness, uint32_t samples, double out[3]) {
    double alpha = roughness * roughness, weight = 0;
    vec3 side = fabsf(axis.y) < 0.9f ? (vec3){0, 1, 0} : (vec3){1, 0, 0};
    vec3 t = vec3_normalize(vec3_cross(side, axis)), b = vec3_cross(axis, t);
    for (uint32_t i = 0; i < samples; i++) {
        uint32_t bits = i;
        double turned = 0, half = 0.5;
        for (; bits; bits >>= 1, half /= 2) turned += bits & 1 ? half : 0;
        double u = ((double)i + 0.5) / samples, cosine = sqrt((1 - turned) / (1 + (alpha * alpha - 1) * turned));
        double sine = sqrt(fmax(1 - cosine * cosine, 0)), angle = 2 * (double)PI * u;
        vec3 h = vec3_add(vec3_add(vec3_scale(t, (float)(sine * cos(angle))), vec3_scale(b, (float)(sine * sin(angle)))),
                          vec3_scale(axis, (float)cosine));
        vec3 l = vec3_sub(vec3_scale(h, 2 * vec3_dot(h, axis)), axis);
        double n_l = (double)vec3_dot(axis, l);
        if (n_l <= 0) continue;
        const float *texel = environment_texel(e, 0, l);
        for (int c = 0; c < 3; c++) out[c] += n_l * (double)texel[c];
        weight += n_l;
    }
    for (int c = 0; c < 3; c++) out[c] = weight > 0 ? out[c] / weight : 0;
}

void environment_prefilter(struct environment *e, uint32_t samples) {
    for (uint32_t mip = 1; mip < e->mips; mip++) {
        double roughness = (double)mip / (e->mips - 1);
        float *texel = e->texels + 3 * mip_start(e, mip);
        for (uint32_t face = 0; face < 6; face++)
            for (uint32_t y = 0; y < mip_side(e, mip); y++)
                for (uint32_t x = 0; x < mip_side(e, mip); x++, texel += 3) {
                    vec3 axis = environment_direction(e, mip, face, x, y);
                    double sum[3] = {0, 0, 0};
                    if (samples)
                        sum_samples(e, axis, roughness, samples, sum);
                    else
                        sum_exactly(e, axis, roughness, sum);
                    for (int c = 0; c < 3; c++) texel[c] = (float)sum[c];
                }
    }
}
