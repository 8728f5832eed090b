/* SPDX-License-Identifier: MIT */
/*
 * A slow search, to judge the fast encoders by: all modes and patterns; lines by least squares, which are quantised and then moved by steps as long
 * as the error gets less.
 */
#include "image/bc6h_encode.h"

#include <math.h>

enum { PATTERNS_TRIED = 8, KEPT = 4, ROUNDS = 3 };

struct target {
    int32_t codes[16][3];
    float values[16][3];
    double weights[16][3]; /* of a squared error of the code */
    bool is_signed, linear;
};

/* A block with whole endpoints, and its error. */
struct candidate {
    struct bc6h_fields fields;
    double error;
};

struct line {
    double ends[2][3];
};

static double error_of(const struct target *t, uint32_t i, const int32_t codes[3], const float values[3]) {
    double sum = 0;
    for (uint32_t c = 0; c < 3; c++) {
        double d = t->linear ? (double)t->values[i][c] - (double)values[c] : (double)(t->codes[i][c] - codes[c]);
        sum += d * d;
    }
    return sum;
}

/* The colours of one region by index. */
static void palette(const struct target *t, const struct bc6h_fields *fields, uint32_t region, int32_t codes[16][3], float values[16][3]) {
    uint32_t bits = bc6h_mode(fields->mode).bits, last = fields->mode <= 10 ? 7 : 15;
    for (uint32_t c = 0; c < 3; c++) {
        int32_t first = bc6h_unquantise(fields->endpoints[region * 2][c], bits, t->is_signed);
        int32_t second = bc6h_unquantise(fields->endpoints[region * 2 + 1][c], bits, t->is_signed);
        for (uint32_t k = 0; k <= last; k++) {
            int32_t weight = (int32_t)((last == 7 ? k * 585 + 32 : k * 273 + 32) >> 6);
            codes[k][c] = bc6h_finish((first * (64 - weight) + second * weight + 32) >> 6, t->is_signed);
            values[k][c] = t->linear ? bc6h_value(codes[k][c]) : 0;
        }
    }
}

/* The best indices for the endpoints, and the error with them. */
static void assign(const struct target *t, struct candidate *candidate) {
    struct bc6h_fields *fields = &candidate->fields;
    bool two = fields->mode <= 10;
    uint32_t mask = two ? bc6h_pattern(fields->pattern) : 0;
    int32_t codes[2][16][3];
    float values[2][16][3];
    for (uint32_t region = 0; region < (two ? 2u : 1u); region++) palette(t, fields, region, codes[region], values[region]);
    candidate->error = 0;
    for (uint32_t i = 0; i < 16; i++) {
        uint32_t region = mask >> i & 1;
        double least = INFINITY;
        for (uint32_t k = 0; k < (two ? 8u : 16u); k++) {
            double error = error_of(t, i, codes[region][k], values[region][k]);
            if (error >= least) continue;
            least = error;
            fields->indices[i] = (uint8_t)k;
        }
        candidate->error += least;
    }
}

/* Whether the mode can store it, with the ends in the order that the anchors want. */
static bool is_stored(const struct bc6h_fields *fields) {
    struct bc6h_mode mode = bc6h_mode(fields->mode);
    struct bc6h_fields turned = *fields;
    bc6h_anchor_indices(&turned);
    for (uint32_t e = 1; e < (fields->mode <= 10 ? 4u : 2u); e++)
        for (uint32_t c = 0; c < 3; c++) {
            int32_t delta = turned.endpoints[e][c] - turned.endpoints[0][c], limit = 1 << mode.delta[c] >> 1;
            if (mode.delta[c] && (delta < -limit || delta >= limit)) return false;
        }
    return true;
}

/* The principal axis of the codes of a region, between the outermost of them. */
static struct line axis_of(const struct target *t, uint32_t mask, uint32_t region) {
    double mean[3] = {0}, total = 0, matrix[3][3] = {{0}};
    for (uint32_t i = 0; i < 16; i++) {
        if ((mask >> i & 1) != region) continue;
        double weight = fmax(t->weights[i][0], fmax(t->weights[i][1], t->weights[i][2]));
        for (uint32_t c = 0; c < 3; c++) mean[c] += weight * t->codes[i][c];
        total += weight;
    }
    for (uint32_t c = 0; c < 3; c++) mean[c] /= total;
    for (uint32_t i = 0; i < 16; i++) {
        if ((mask >> i & 1) != region) continue;
        for (uint32_t a = 0; a < 3; a++)
            for (uint32_t b = 0; b < 3; b++)
                matrix[a][b] += sqrt(t->weights[i][a] * t->weights[i][b]) * (t->codes[i][a] - mean[a]) * (t->codes[i][b] - mean[b]);
    }
    double axis[3] = {0}, greatest = -1;
    for (uint32_t c = 0; c < 3; c++) /* start with the longest column */
        if (matrix[c][c] > greatest) {
            greatest = matrix[c][c];
            memcpy(axis, matrix[c], sizeof axis);
        }
    for (uint32_t round = 0; round < 8; round++) {
        double next[3], length = 0;
        for (uint32_t c = 0; c < 3; c++) {
            next[c] = matrix[c][0] * axis[0] + matrix[c][1] * axis[1] + matrix[c][2] * axis[2];
            length += next[c] * next[c];
        }
        if (!(length > 0)) break;
        for (uint32_t c = 0; c < 3; c++) axis[c] = next[c] / sqrt(length);
    }
    double length2 = axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2], low = 0, high = 0;
    for (uint32_t i = 0; i < 16 && length2 > 0; i++) {
        if ((mask >> i & 1) != region) continue;
        double along = 0;
        for (uint32_t c = 0; c < 3; c++) along += (t->codes[i][c] - mean[c]) * axis[c] / length2;
        low = fmin(low, along);
        high = fmax(high, along);
    }
    struct line out;
    for (uint32_t c = 0; c < 3; c++) {
        out.ends[0][c] = mean[c] + axis[c] * low;
        out.ends[1][c] = mean[c] + axis[c] * high;
    }
    return out;
}

/* The nearest of the weights of a palette; then the ends that fit them best. Returns the error of the line. */
static double fit_line(const struct target *t, uint32_t mask, uint32_t region, uint32_t last, const uint8_t *indices, struct line *line) {
    double sums[3][5] = {{0}}, error = 0; /* by channel: aa, ab, bb, a * code, b * code */
    for (uint32_t i = 0; i < 16; i++) {
        if ((mask >> i & 1) != region) continue;
        double along = 0, length2 = 0;
        for (uint32_t c = 0; c < 3; c++) {
            double direction = line->ends[1][c] - line->ends[0][c];
            along += t->weights[i][c] * direction * (t->codes[i][c] - line->ends[0][c]);
            length2 += t->weights[i][c] * direction * direction;
        }
        double place = length2 > 0 ? fmin(fmax(along / length2, 0), 1) : 0;
        double b = indices ? (double)((last == 7 ? indices[i] * 585u + 32 : indices[i] * 273u + 32) >> 6) / 64 : rint(place * last) / last, a = 1 - b;
        for (uint32_t c = 0; c < 3; c++) {
            double w = t->weights[i][c], off = t->codes[i][c] - (line->ends[0][c] * a + line->ends[1][c] * b);
            error += w * off * off;
            sums[c][0] += w * a * a;
            sums[c][1] += w * a * b;
            sums[c][2] += w * b * b;
            sums[c][3] += w * a * t->codes[i][c];
            sums[c][4] += w * b * t->codes[i][c];
        }
    }
    for (uint32_t c = 0; c < 3; c++) {
        double *s = sums[c], determinant = s[0] * s[2] - s[1] * s[1];
        if (determinant <= 1e-6 * s[0] * s[2] || !(determinant > 0)) continue;
        double least = t->is_signed ? -(double)BC6H_CODE_MAX : 0;
        line->ends[0][c] = fmin(fmax((s[2] * s[3] - s[1] * s[4]) / determinant, least), BC6H_CODE_MAX);
        line->ends[1][c] = fmin(fmax((s[0] * s[4] - s[1] * s[3]) / determinant, least), BC6H_CODE_MAX);
    }
    return error;
}

static void keep(struct candidate *kept, const struct candidate *new) {
    if (!is_stored(&new->fields)) return;
    for (uint32_t i = 0; i < KEPT; i++)
        if (kept[i].error <= new->error && memcmp(&kept[i].fields, &new->fields, sizeof new->fields) == 0) return;
    uint32_t at = KEPT;
    while (at > 0 && new->error < kept[at - 1].error) at--;
    if (at == KEPT) return;
    memmove(kept + at + 1, kept + at, (KEPT - 1 - at) * sizeof *kept);
    kept[at] = *new;
}

/* Quantises lines in a mode, and fits them again to the indices that follow. */
static void try_mode(const struct target *t, uint32_t mode, uint32_t pattern, const struct line lines[2], struct candidate *kept) {
    bool two = mode <= 10;
    uint32_t bits = bc6h_mode(mode).bits, mask = two ? bc6h_pattern(pattern) : 0;
    struct line now[2] = {lines[0], lines[1]};
    double before = INFINITY;
    for (uint32_t round = 0; round < ROUNDS; round++) {
        struct candidate candidate = {.fields = {.mode = mode, .pattern = two ? pattern : 0}};
        for (uint32_t e = 0; e < (two ? 4u : 2u); e++)
            for (uint32_t c = 0; c < 3; c++)
                candidate.fields.endpoints[e][c] = bc6h_quantise((int32_t)lrint(now[e / 2].ends[e % 2][c]), bits, t->is_signed);
        assign(t, &candidate);
        keep(kept, &candidate);
        if (candidate.error >= before) return;
        before = candidate.error;
        for (uint32_t region = 0; region < (two ? 2u : 1u); region++)
            fit_line(t, mask, region, two ? 7 : 15, candidate.fields.indices, &now[region]);
    }
}

/* One step up or down of an endpoint, or of both ends of a channel, as long as that helps. */
static void climb(const struct target *t, struct candidate *best) {
    struct bc6h_mode mode = bc6h_mode(best->fields.mode);
    uint32_t ends = best->fields.mode <= 10 ? 4 : 2;
    int32_t most = t->is_signed ? (1 << (mode.bits - 1)) - 1 : (1 << mode.bits) - 1, least = t->is_signed ? -most : 0;
    for (bool moved = true; moved;) {
        moved = false;
        for (uint32_t e = 0; e < ends; e++)
            for (uint32_t c = 0; c < 3; c++)
                for (int32_t way = 0; way < 6; way++) {
                    int32_t step = (way & 1 ? -1 : 1) * (1 << (mode.bits == 16 ? way / 2 * 2 : 0));
                    struct candidate next = *best;
                    next.fields.endpoints[e][c] += step;
                    if (way / 2 == 1) next.fields.endpoints[e ^ 1][c] += step;
                    if (way / 2 == 2) next.fields.endpoints[e ^ 1][c] -= step;
                    bool inside = true;
                    for (uint32_t k = 0; k < ends; k++) inside &= next.fields.endpoints[k][c] >= least && next.fields.endpoints[k][c] <= most;
                    if (!inside) continue;
                    assign(t, &next);
                    if (next.error >= best->error || !is_stored(&next.fields)) continue;
                    *best = next;
                    moved = true;
                }
    }
}

/* Patterns in the order of what their lines leave. */
static uint32_t order_patterns(const struct target *t, struct line lines[BC6H_PATTERNS][2], uint32_t order[BC6H_PATTERNS]) {
    double errors[BC6H_PATTERNS];
    for (uint32_t p = 0; p < BC6H_PATTERNS; p++) {
        errors[p] = 0;
        for (uint32_t region = 0; region < 2; region++) {
            double error = INFINITY;
            lines[p][region] = axis_of(t, bc6h_pattern(p), region);
            for (uint32_t round = 0; round < ROUNDS; round++) error = fmin(error, fit_line(t, bc6h_pattern(p), region, 7, NULL, &lines[p][region]));
            errors[p] += error;
        }
        uint32_t at = p;
        for (; at > 0 && errors[order[at - 1]] > errors[p]; at--) order[at] = order[at - 1];
        order[at] = p;
    }
    return PATTERNS_TRIED;
}

struct bc6h_block bc6h_encode_best(const struct bc6h_params *params, const float texels[16][3]) {
    struct target t = {.is_signed = params->is_signed, .linear = params->linear};
    uint32_t modes = (params->modes ? params->modes : ~0u) | 1u << 11;
    for (uint32_t i = 0; i < 16; i++)
        for (uint32_t c = 0; c < 3; c++) {
            t.codes[i][c] = bc6h_code(texels[i][c], params->is_signed);
            t.values[i][c] = bc6h_value(t.codes[i][c]);
            int32_t code = abs(t.codes[i][c]);
            double slope = (double)bc6h_value(MIN(code + 1, BC6H_CODE_MAX)) - (double)bc6h_value(MIN(code, BC6H_CODE_MAX - 1));
            t.weights[i][c] = params->linear ? slope * slope * 0x1p24 : 1;
        }

    struct candidate kept[KEPT];
    for (uint32_t i = 0; i < KEPT; i++) kept[i] = (struct candidate){.error = INFINITY};
    /* What the other encoders find is the least that must be found here. */
    for (uint32_t i = 0; i < 2; i++) {
        struct bc6h_params fast = {.quality = i ? BC6H_QUALITY : BC6H_FAST, .is_signed = params->is_signed, .modes = params->modes};
        struct bc6h_block block = bc6h_encode(&fast, texels);
        struct candidate candidate = {.fields = bc6h_unpack(&block)};
        bc6h_whole_endpoints(&candidate.fields, params->is_signed);
        assign(&t, &candidate);
        keep(kept, &candidate);
    }
    struct line one[2] = {axis_of(&t, 0, 0)};
    for (uint32_t round = 0; round < ROUNDS; round++) fit_line(&t, 0, 0, 15, NULL, &one[0]);
    for (uint32_t mode = 11; mode <= 14; mode++)
        if (modes >> mode & 1) try_mode(&t, mode, 0, one, kept);
    if (modes & 0x7fe) {
        struct line lines[BC6H_PATTERNS][2];
        uint32_t order[BC6H_PATTERNS], count = order_patterns(&t, lines, order);
        for (uint32_t i = 0; i < count; i++)
            for (uint32_t mode = 1; mode <= 10; mode++)
                if (modes >> mode & 1) try_mode(&t, mode, order[i], lines[order[i]], kept);
    }
    uint32_t least = 0;
    for (uint32_t i = 0; i < KEPT; i++) {
        if (!(kept[i].error < INFINITY)) continue;
        climb(&t, &kept[i]);
        if (kept[i].error < kept[least].error) least = i;
    }
    bc6h_anchor_indices(&kept[least].fields);
    bc6h_store_deltas(&kept[least].fields);
    return bc6h_pack(&kept[least].fields);
}
