/* SPDX-License-Identifier: MIT */
#include "ray/albedos.h"

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

double ray_sheen_albedo(const struct ray_albedos *albedos, double roughness, double n_v) {
    const struct albedo_place p = albedo_place(roughness, n_v);
    double sum = 0;
    for (int k = 0; k < 4; k++) sum += p.weights[k] * (double)albedos->sheen[p.r + k / 2][p.n + k % 2];
    return sum;
}
