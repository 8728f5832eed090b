/* SPDX-License-Identifier: MIT */
/* Panoramas and the bright sources in them. */
#include "scene/scene_environment.h"

#include <stdlib.h>

static size_t byte_count(const struct panorama *p) { return (size_t)p->width * p->height * 3 * sizeof(float); }

void panorama_finish(const fnl_host *host, struct panorama *p) {
    if (p->texels) host_free(host, p->texels, byte_count(p));
    *p = (struct panorama){0};
}

float panorama_unit(const struct panorama *p) {
    const size_t count = (size_t)p->width * p->height * 3;
    float most = 0;
    int exponent;
    for (size_t i = 0; i < count; i++) most = fmaxf(most, p->texels[i]);
    if (most == 0) return 1;
    (void)frexpf(most, &exponent);
    const float unit = ldexpf(1, MAX(exponent - 16, -126)); /* its reciprocal is finite */
    return most / unit > 65504 ? 2 * unit : unit;
}

static float longitude_of(const struct panorama *p, float x) { return ((x + 0.5f) / (float)p->width - 0.5f) * 2 * PI; }
static float latitude_of(const struct panorama *p, float y) { return (y + 0.5f) / (float)p->height * PI; }

vec3 panorama_direction(const struct panorama *p, float x, float y) {
    const float longitude = longitude_of(p, x), latitude = latitude_of(p, y);
    return vec3_make(sinf(latitude) * cosf(longitude), cosf(latitude), sinf(latitude) * sinf(longitude));
}

void panorama_place(const struct panorama *p, vec3 d, float *x, float *y) {
    *x = (atan2f(d.z, d.x) / (2 * PI) + 0.5f) * (float)p->width - 0.5f;
    *y = acosf(CLAMP(d.y, -1.0f, 1.0f)) / PI * (float)p->height - 0.5f;
}

static float texel_angle(const struct panorama *p, uint32_t y) { /* steradian */
    const float step = PI / (float)p->height;
    return 2 * PI / (float)p->width * (cosf(step * (float)y) - cosf(step * (float)(y + 1)));
}

static inline float texel_luminance(const float *texel) { return 0.2126f * texel[0] + 0.7152f * texel[1] + 0.0722f * texel[2]; }

fnl_result panorama_shrink(const fnl_host *host, struct panorama *p, uint32_t most_width) {
    const size_t before = byte_count(p);
    float *all = p->texels;
    while (p->width > most_width) {
        const uint32_t width = p->width / 2, height = p->height / 2;
        for (uint32_t y = 0; y < height; y++)
            for (uint32_t x = 0; x < width; x++)
                for (uint32_t c = 0; c < 3; c++) {
                    const float *from = p->texels + 3 * ((size_t)2 * y * p->width + 2 * x) + c;
                    p->texels[3 * ((size_t)y * width + x) + c] = (from[0] + from[3] + from[3 * p->width] + from[3 * p->width + 3]) / 4;
                }
        p->width = width;
        p->height = height;
    }
    if (byte_count(p) == before) return FNL_OK;
    p->texels = host_allocate(host, byte_count(p));
    if (p->texels) memcpy(p->texels, all, byte_count(p));
    host_free(host, all, before);
    if (p->texels) return FNL_OK;
    *p = (struct panorama){0};
    return FNL_ERROR_MEMORY;
}

/* ---- bright sources ---- */

/* What all of it gives to a sphere, as if it came at right angles, where nothing is brighter than `most`: cd/m^2 times steradian. */
static double whole_light(const struct panorama *p, const float *luminances, float most) {
    enum { ROWS = 4 }; /* at once: sums of several rows do not wait for each other */
    double sum = 0;
    for (uint32_t first = 0; first < p->height; first += ROWS) {
        const uint32_t rows = MIN(p->height - first, (uint32_t)ROWS);
        const float *at = luminances + (size_t)first * p->width;
        double sums[ROWS] = {0};
        if (rows == ROWS)
            for (uint32_t x = 0; x < p->width; x++)
                for (uint32_t r = 0; r < ROWS; r++) {
                    const float l = at[(size_t)r * p->width + x];
                    sums[r] += (double)(l < most ? l : most);
                }
        else
            for (uint32_t r = 0; r < rows; r++)
                for (uint32_t x = 0; x < p->width; x++) sums[r] += (double)fminf(at[(size_t)r * p->width + x], most);
        for (uint32_t r = 0; r < rows; r++) sum += sums[r] * (double)texel_angle(p, first + r);
    }
    return sum;
}

double panorama_flux(const struct panorama *p) {
    double sum = 0;
    for (uint32_t y = 0; y < p->height; y++) {
        double row = 0;
        for (uint32_t x = 0; x < p->width; x++) row += (double)texel_luminance(p->texels + 3 * ((size_t)y * p->width + x));
        sum += row * (double)texel_angle(p, y);
    }
    return sum;
}

/* Texels above it belong to sources: so many times the mean of what is below it. */
static float threshold_of(const struct panorama *p, const float *luminances, double whole) {
    enum { TIMES = 12, ROUNDS = 8 };
    float threshold = TIMES * (float)(whole / (4 * (double)PI)), before = FLT_MAX;
    for (uint32_t round = 1; round < ROUNDS && threshold != before; round++) {
        before = threshold;
        threshold = TIMES * (float)(whole_light(p, luminances, threshold) / (4 * (double)PI));
    }
    return threshold;
}

/* Texels that hang together: `stack` has room for all. Their light above the threshold is summed up. */
struct region {
    double light[3], toward[3], angle;
};

static struct region flood(const struct panorama *p, uint32_t start, float threshold, uint8_t *seen, uint32_t *stack) {
    struct region out = {0};
    uint32_t count = 0;
    stack[count++] = start;
    seen[start] = 1;
    while (count > 0) {
        const uint32_t at = stack[--count], x = at % p->width, y = at / p->width;
        const float *texel = p->texels + 3 * (size_t)at;
        const double angle = (double)texel_angle(p, y), above = 1 - (double)(threshold / texel_luminance(texel));
        const vec3 direction = panorama_direction(p, (float)x, (float)y);
        for (int c = 0; c < 3; c++) out.light[c] += (double)texel[c] * above * angle;
        const double weight = (double)texel_luminance(texel) * above * angle;
        out.toward[0] += weight * (double)direction.x;
        out.toward[1] += weight * (double)direction.y;
        out.toward[2] += weight * (double)direction.z;
        out.angle += angle;
        for (int k = 0; k < 9; k++) {
            const int64_t row = (int64_t)y + k / 3 - 1;
            if (row < 0 || row >= p->height) continue;
            const uint32_t next = (uint32_t)row * p->width + (x + p->width + (uint32_t)(k % 3) - 1) % p->width;
            if (seen[next] || !(texel_luminance(p->texels + 3 * (size_t)next) > threshold)) continue;
            seen[next] = 1;
            stack[count++] = next;
        }
    }
    return out;
}

static float region_light(const struct region *r) {
    const float light[3] = {(float)r->light[0], (float)r->light[1], (float)r->light[2]};
    return texel_luminance(light);
}

/* Lowers what hangs together with `start` to the threshold. */
static void lower(struct panorama *p, uint32_t start, float threshold, uint8_t *seen, uint32_t *stack) {
    uint32_t count = 0;
    stack[count++] = start;
    seen[start] = 0;
    while (count > 0) {
        const uint32_t at = stack[--count], x = at % p->width, y = at / p->width;
        float *texel = p->texels + 3 * (size_t)at;
        const float part = threshold / texel_luminance(texel);
        for (int c = 0; c < 3; c++) texel[c] *= part;
        for (int k = 0; k < 9; k++) {
            const int64_t row = (int64_t)y + k / 3 - 1;
            if (row < 0 || row >= p->height) continue;
            const uint32_t next = (uint32_t)row * p->width + (x + p->width + (uint32_t)(k % 3) - 1) % p->width;
            if (!seen[next]) continue;
            seen[next] = 0;
            stack[count++] = next;
        }
    }
}

/* In `p`, by the luminances of its texels; `seen` and `stack` have room for all. */
static void part(struct panorama *p, const float *luminances, uint8_t *seen, uint32_t *stack, struct panorama_source *out, uint32_t *count) {
    const size_t texel_count = (size_t)p->width * p->height;
    const double whole = whole_light(p, luminances, FLT_MAX);
    const float least = 0.02f * (float)whole, threshold = threshold_of(p, luminances, whole), widest = 2 * PI * (1 - cosf(5 * PI / 180));
    uint32_t starts[ENVIRONMENT_LIGHTS_MAX + 1];
    struct region regions[ENVIRONMENT_LIGHTS_MAX + 1];
    for (uint32_t i = 0; i < texel_count; i++) {
        if (!(luminances[i] > threshold) || seen[i]) continue;
        const struct region r = flood(p, i, threshold, seen, stack);
        if (!(region_light(&r) > least) || r.angle > (double)widest) continue;
        uint32_t place = *count; /* the brightest come first; the last of one too many drops out */
        for (; place > 0 && region_light(&regions[place - 1]) < region_light(&r); place--) {
            regions[place] = regions[place - 1];
            starts[place] = starts[place - 1];
        }
        regions[place] = r;
        starts[place] = i;
        *count = MIN(*count + 1, ENVIRONMENT_LIGHTS_MAX);
    }
    for (uint32_t i = 0; i < *count; i++) {
        const struct region *r = &regions[i];
        lower(p, starts[i], threshold, seen, stack);
        out[i] = (struct panorama_source){
            .illuminance = vec3_make((float)r->light[0], (float)r->light[1], (float)r->light[2]),
            .direction = vec3_normalize(vec3_make((float)r->toward[0], (float)r->toward[1], (float)r->toward[2])),
            .half_angle = acosf(fmaxf(1 - (float)r->angle / (2 * PI), -1))};
    }
}

fnl_result panorama_part(const fnl_host *host, struct panorama *p, struct panorama_source out[ENVIRONMENT_LIGHTS_MAX], uint32_t *count) {
    const size_t texel_count = (size_t)p->width * p->height;
    uint8_t *seen = host_allocate_zero(host, texel_count);
    uint32_t *stack = host_allocate(host, texel_count * sizeof *stack);
    float *luminances = host_allocate(host, texel_count * sizeof *luminances);
    const fnl_result result = seen && stack && luminances ? FNL_OK : FNL_ERROR_MEMORY;
    *count = 0;
    for (size_t i = 0; i < texel_count && result == FNL_OK; i++) luminances[i] = texel_luminance(p->texels + 3 * i);
    if (result == FNL_OK) part(p, luminances, seen, stack, out, count);
    if (seen) host_free(host, seen, texel_count);
    if (stack) host_free(host, stack, texel_count * sizeof *stack);
    if (luminances) host_free(host, luminances, texel_count * sizeof *luminances);
    return result;
}
