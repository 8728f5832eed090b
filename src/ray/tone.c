/* SPDX-License-Identifier: MIT */
#include "ray/tone.h"

#include "exposure_shared.h"

#include "base/base.h"

/* Khronos PBR Neutral, as its specification writes it. */
static dvec3 khronos_neutral(dvec3 c) {
    const double f90 = 0.04, ks = 0.8 - f90, kd = 0.15;
    double x = fmin(c.x, fmin(c.y, c.z)), f = x <= 2 * f90 ? x - x * x / (4 * f90) : f90;
    c = dvec3_sub(c, dvec3_make(f, f, f));
    double p = dvec3_max(c);
    if (p <= ks) return c;
    double pn = 1 - (1 - ks) * (1 - ks) / (p + 1 - 2 * ks), g = 1 / (kd * (p - pn) + 1);
    return dvec3_add_scaled(dvec3_make(pn * (1 - g), pn * (1 - g), pn * (1 - g)), c, pn / p * g);
}

static dvec3 transform(const double rows[3][3], dvec3 c) {
    double out[3];
    for (int i = 0; i < 3; i++) out[i] = rows[i][0] * c.x + rows[i][1] * c.y + rows[i][2] * c.z;
    return dvec3_make(out[0], out[1], out[2]);
}

/* The fit by S. Hill of the ACES reference and output transforms. */
static double aces_curve(double x) {
    return (x * (x + 0.0245786) - 0.000090537) / (x * (0.983729 * x + 0.4329510) + 0.238081);
}
static dvec3 aces(dvec3 c) {
    static const double into[3][3] = {{0.59719, 0.35458, 0.04823}, {0.07600, 0.90834, 0.01566}, {0.02840, 0.13383, 0.83777}};
    static const double back[3][3] = {
        {1.60475, -0.53108, -0.07367}, {-0.10208, 1.10813, -0.00605}, {-0.00327, -0.07276, 1.07602}};
    c = transform(into, c);
    return transform(back, dvec3_make(aces_curve(c.x), aces_curve(c.y), aces_curve(c.z)));
}

/* AgX by T. Sobotka with B. Wrensch's polynomial of sixth degree. */
static double agx_curve(double c) {
    const double low = -12.47393, high = 4.026069, x = (CLAMP(log2(fmax(c, 1e-10)), low, high) - low) / (high - low);
    return -0.00232 + x * (0.1191 + x * (0.4298 + x * (-6.868 + x * (31.96 + x * (-40.14 + x * 15.5)))));
}
static dvec3 agx(dvec3 c) {
    static const double inset[3][3] = {{0.842479062253094, 0.0784335999999992, 0.0792237451477643},
                                       {0.0423282422610123, 0.878468636469772, 0.0791661274605434},
                                       {0.0423756549057051, 0.0784336, 0.879142973793104}};
    static const double outset[3][3] = {{1.19687900512017, -0.0980208811401368, -0.0990297440797205},
                                        {-0.0528968517574562, 1.15190312990417, -0.0989611768448433},
                                        {-0.0529716355144438, -0.0980434501171241, 1.15107367264116}};
    c = transform(inset, c);
    c = transform(outset, dvec3_make(agx_curve(c.x), agx_curve(c.y), agx_curve(c.z)));
    return dvec3_make(pow(clamp01(c.x), 2.2), pow(clamp01(c.y), 2.2), pow(clamp01(c.z), 2.2));
}

dvec3 ray_tone_map(fnl_tonemap tonemap, dvec3 color) {
    if (tonemap == FNL_TONEMAP_KHRONOS_NEUTRAL) return khronos_neutral(color);
    if (tonemap == FNL_TONEMAP_ACES) return aces(color);
    if (tonemap == FNL_TONEMAP_AGX) return agx(color);
    return color;
}

double ray_srgb(double linear) {
    double c = clamp01(linear);
    return c <= 0.0031308 ? 12.92 * c : 1.055 * pow(c, 1 / 2.4) - 0.055;
}

static double level_of(double bin) { return bin / METER_BINS * (METER_HIGH - METER_LOW) + METER_LOW; }

/* Below which this share of the counts is. */
static double level_at(const double counts[METER_BINS], double share) {
    double all = 0, before = 0;
    for (uint32_t i = 1; i < METER_BINS; i++) all += counts[i];
    for (uint32_t i = 1; i < METER_BINS && all > 0; i++) {
        if (before + counts[i] >= share * all) return level_of(i + (share * all - before) / counts[i]);
        before += counts[i];
    }
    return METER_LOW;
}

double ray_meter(const float *pixels, const uint8_t *surfaces, uint32_t width, uint32_t height) {
    double counts[METER_BINS] = {0}, shown[METER_BINS] = {0} /* surfaces */, total = 0;
    for (uint32_t y = 0; y < height; y++)
        for (uint32_t x = 0; x < width; x++) {
            const size_t i = (size_t)y * width + x;
            const double luminance = dvec3_luminance(dvec3_make((double)pixels[4 * i], (double)pixels[4 * i + 1], (double)pixels[4 * i + 2]));
            const double level = (log2(fmax(luminance, 1e-12)) - METER_LOW) / (METER_HIGH - METER_LOW) * METER_BINS;
            const double across = (2.0 * x + 1) / width - 1, down = (2.0 * y + 1) / height - 1;
            const double weight = floor(METER_WEIGHT(fmax(METER_NEARNESS(across, down), 0)));
            const uint32_t bin = (uint32_t)CLAMP(level, 0, METER_BINS - 1.0);
            counts[bin] += surfaces[i] ? weight : METER_BACKGROUND * weight;
            shown[bin] += surfaces[i] ? weight : 0;
        }
    for (uint32_t i = 1; i < METER_BINS; i++) total += counts[i];
    const double low = METER_TRIM * total, high = (1 - METER_TRIM) * total;
    double before = 0, sum = 0, weight = 0;
    for (uint32_t i = 1; i < METER_BINS; i++) {
        const double inside = fmax(fmin(before + counts[i], high) - fmax(before, low), 0);
        sum += inside * level_of(i + 0.5);
        weight += inside;
        before += counts[i];
    }
    if (weight == 0) return 0;
    const double kept = fmax(level_at(shown, METER_BRIGHT) - log2(1.2 * METER_SPARE), level_at(shown, METER_BROAD) - log2(1.2 * METER_LIGHT));
    return fmax(sum / weight - log2(1.2 * METER_KEY), kept);
}

double ray_exposure(double ev) { return 1 / (1.2 * exp2(ev)); }
