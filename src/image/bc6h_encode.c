/* SPDX-License-Identifier: MIT */
/* The encoders that the GPU has too (src/passes/compress): each operation on floats stands here as it stands there, so that blocks are equal. */
#include "image/bc6h_encode.h"

#include "base/jobs.h"
#include "base/maths.h"

/* So that the first and the last bucket, which are half as wide as the others, end where they should. The offsets are greater by 4e-6: whole codes
   often lie in the middle between two indices, and devices differ in the last bit of a quotient. */
#define INDEX4_SCALE 14.9333333f
#define INDEX4_OFFSET 0.533337333f
#define INDEX3_SCALE 6.98182f
#define INDEX3_OFFSET 0.509094f

static float dot3(const float a[3], const float b[3]) { return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]; }

static float code_float(float value, bool is_signed) { return (float)bc6h_code(value, is_signed); }

/* ---- mode 11 ---- */

struct color_box {
    float low[3], high[3];
};

static struct color_box bound(const float texels[16][3], enum bc6h_inset inset) {
    struct color_box box;
    for (int c = 0; c < 3; c++) {
        float low = texels[0][c], high = texels[0][c];
        for (int i = 1; i < 16; i++) {
            low = fminf(low, texels[i][c]);
            high = fmaxf(high, texels[i][c]);
        }
        float next_low = high, next_high = low, most = (high - low) * 0.0625f;
        for (int i = 0; i < 16; i++) {
            if (texels[i][c] != low) next_low = fminf(next_low, texels[i][c]);
            if (texels[i][c] != high) next_high = fmaxf(next_high, texels[i][c]);
        }
        box.low[c] = low;
        box.high[c] = high;
        if (inset == BC6H_INSET_NONE) continue;
        box.low[c] = low + (inset == BC6H_INSET_FIXED ? most : fminf(next_low - low, most));
        box.high[c] = high - (inset == BC6H_INSET_FIXED ? most : fminf(high - next_high, most));
    }
    return box;
}

/* Where colours stand on the line between the ends of the box: codes of what they are along its direction. */
static void indices_on_line(const float texels[16][3], const struct color_box *box, bool is_signed, uint8_t indices[16]) {
    float direction[3];
    for (int c = 0; c < 3; c++) direction[c] = box->high[c] - box->low[c];
    float sum = (direction[0] + direction[1]) + direction[2];
    float scale = sum > 0x1p-26f ? 1 / sum : 0;
    for (int c = 0; c < 3; c++) direction[c] = direction[c] * scale;
    float first = code_float(dot3(box->low, direction), is_signed), last = code_float(dot3(box->high, direction), is_signed);
    float per = last != first ? 1 / (last - first) : 0;
    for (int i = 0; i < 16; i++) {
        float r = (code_float(dot3(texels[i], direction), is_signed) - first) * per;
        indices[i] = (uint8_t)fminf(fmaxf(r * INDEX4_SCALE + INDEX4_OFFSET, 0), 15);
    }
}

void bc6h_anchor_indices(struct bc6h_fields *fields) {
    bool two = fields->mode <= 10;
    uint32_t mask = two ? bc6h_pattern(fields->pattern) : 0, last = two ? 7 : 15;
    for (uint32_t region = 0; region < (two ? 2u : 1u); region++) {
        if (fields->indices[region ? bc6h_anchor(fields->pattern) : 0] <= last / 2) continue;
        for (uint32_t i = 0; i < 16; i++)
            if ((mask >> i & 1) == region) fields->indices[i] = (uint8_t)(last - fields->indices[i]);
        for (uint32_t c = 0; c < 3; c++) {
            int32_t first = fields->endpoints[region * 2][c];
            fields->endpoints[region * 2][c] = fields->endpoints[region * 2 + 1][c];
            fields->endpoints[region * 2 + 1][c] = first;
        }
    }
}

/* For each texel that index of the 16 whose value is nearest. */
static void search_indices(const float texels[16][3], bool is_signed, struct bc6h_fields *fields) {
    for (uint32_t i = 0; i < 16; i++) fields->indices[i] = (uint8_t)i;
    int32_t codes[16][3];
    bc6h_decode_codes(fields, is_signed, codes);
    for (uint32_t i = 0; i < 16; i++) {
        double least = INFINITY;
        for (uint32_t k = 0; k < 16; k++) {
            double error = 0;
            for (uint32_t c = 0; c < 3; c++) {
                double difference = (double)bc6h_value(codes[k][c]) - (double)texels[i][c];
                error += difference * difference;
            }
            if (error >= least) continue;
            least = error;
            fields->indices[i] = (uint8_t)k;
        }
    }
}

/* Before the anchor's index is looked at. */
static struct bc6h_fields encode_line(const struct bc6h_params *params, const float texels[16][3], const struct color_box *box) {
    struct bc6h_fields fields = {.mode = 11};
    for (int c = 0; c < 3; c++) {
        fields.endpoints[0][c] = bc6h_quantise(bc6h_code(box->low[c], params->is_signed), 10, params->is_signed);
        fields.endpoints[1][c] = bc6h_quantise(bc6h_code(box->high[c], params->is_signed), 10, params->is_signed);
    }
    if (params->exhaustive)
        search_indices(texels, params->is_signed, &fields);
    else
        indices_on_line(texels, box, params->is_signed, fields.indices);
    return fields;
}

/* ---- quality ---- */

struct search {
    float codes[16][3];
    bool is_signed;
    uint32_t modes;
    float least; /* squared error of the codes, of `best` */
    struct bc6h_fields best;
};

/* Ends of lines in codes: [region][end][channel]. */
struct lines {
    float ends[2][2][3];
};

static void project(const struct search *s, const struct lines *lines, uint32_t mask, bool two, uint8_t indices[16]) {
    float directions[2][3], per[2];
    for (int r = 0; r < 2; r++) {
        for (int c = 0; c < 3; c++) directions[r][c] = lines->ends[r][1][c] - lines->ends[r][0][c];
        float length2 = dot3(directions[r], directions[r]);
        per[r] = length2 > 0 ? 1 / length2 : 0;
    }
    for (int i = 0; i < 16; i++) {
        int r = mask >> i & 1;
        float from[3];
        for (int c = 0; c < 3; c++) from[c] = s->codes[i][c] - lines->ends[r][0][c];
        float t = dot3(from, directions[r]) * per[r];
        float index = two ? t * INDEX3_SCALE + INDEX3_OFFSET : t * INDEX4_SCALE + INDEX4_OFFSET;
        indices[i] = (uint8_t)fminf(fmaxf(index, 0), two ? 7 : 15);
    }
}

static void evaluate(struct search *s, struct bc6h_fields *fields) {
    int32_t codes[16][3];
    struct bc6h_fields stored = *fields;
    bc6h_store_deltas(&stored);
    bc6h_decode_codes(&stored, s->is_signed, codes);
    float error = 0;
    for (int i = 0; i < 16; i++) {
        float difference[3];
        for (int c = 0; c < 3; c++) difference[c] = s->codes[i][c] - (float)codes[i][c];
        error = error + dot3(difference, difference);
    }
    if (error >= s->least) return;
    s->least = error;
    s->best = *fields;
}

void bc6h_store_deltas(struct bc6h_fields *fields) {
    struct bc6h_mode mode = bc6h_mode(fields->mode);
    for (uint32_t e = 1; e < (fields->mode <= 10 ? 4u : 2u); e++)
        for (uint32_t c = 0; c < 3; c++)
            if (mode.delta[c]) fields->endpoints[e][c] -= fields->endpoints[0][c];
}

/* Quantises the lines in a mode and keeps the block if it is better than the best; false if differences are too large whichever end comes first. */
static bool try_mode(struct search *s, uint32_t mode, uint32_t pattern, const struct lines *lines) {
    struct bc6h_fields fields = {.mode = mode, .pattern = pattern};
    struct bc6h_mode format = bc6h_mode(mode);
    bool two = mode <= 10;
    struct lines decoded = {0};
    for (int c = 0; c < 3; c++) {
        int32_t least = INT32_MAX, most = INT32_MIN;
        for (int e = 0; e < (two ? 4 : 2); e++) {
            int32_t q = bc6h_quantise((int32_t)lines->ends[e / 2][e % 2][c], format.bits, s->is_signed);
            least = MIN(least, q);
            most = MAX(most, q);
            fields.endpoints[e][c] = q;
            decoded.ends[e / 2][e % 2][c] = (float)bc6h_finish(bc6h_unquantise(q, format.bits, s->is_signed), s->is_signed);
        }
        if (format.delta[c] && most - least >= 1 << (format.delta[c] - 1)) return false;
    }
    project(s, &decoded, two ? bc6h_pattern(pattern) : 0, two, fields.indices);
    evaluate(s, &fields);
    return true;
}

/* The most precise of these modes that has room for the lines. */
static void try_modes(struct search *s, const uint32_t *modes, uint32_t count, uint32_t pattern, const struct lines *lines) {
    for (uint32_t i = 0; i < count; i++)
        if ((s->modes >> modes[i] & 1) && try_mode(s, modes[i], pattern, lines)) return;
}

/* Moves the ends to where the squared error is least with these indices; a region that says nothing of its ends keeps them. */
static void fit(const struct search *s, uint32_t mask, bool two, const uint8_t indices[16], struct lines *lines) {
    for (int r = 0; r < (two ? 2 : 1); r++) {
        float a = 0, b = 0, c = 0, x[3] = {0}, y[3] = {0}; /* sums of weights, squared and mixed; of weighted codes */
        for (int i = 0; i < 16; i++) {
            float inside = (int)(mask >> i & 1) == r ? 1 : 0;
            float t = (float)(two ? (indices[i] * 585 + 32) >> 6 : (indices[i] * 273 + 32) >> 6) * 0.015625f, u = 1 - t;
            a = a + inside * (u * u);
            b = b + inside * (u * t);
            c = c + inside * (t * t);
            for (int k = 0; k < 3; k++) {
                float from = s->codes[i][k] - lines->ends[r][0][k];
                x[k] = x[k] + inside * (u * from);
                y[k] = y[k] + inside * (t * from);
            }
        }
        float determinant = a * c - b * b;
        if (!(determinant > 0.01f)) continue;
        float per = 1 / determinant, least = s->is_signed ? -(float)BC6H_CODE_MAX : 0;
        for (int k = 0; k < 3; k++) {
            float base = lines->ends[r][0][k];
            lines->ends[r][0][k] = fminf(fmaxf(floorf(((c * x[k] - b * y[k]) * per + base) + 0.5f), least), BC6H_CODE_MAX);
            lines->ends[r][1][k] = fminf(fmaxf(floorf(((a * y[k] - b * x[k]) * per + base) + 0.5f), least), BC6H_CODE_MAX);
        }
    }
}

/* The ends of a box's diagonal become those of the diagonal along which the codes lie: channels that fall where the longest one rises change theirs. */
static void turn_ends(const struct search *s, uint32_t mask, int region, float ends[2][3]) {
    float middle[3], covariance[3] = {0};
    int longest = 0;
    for (int c = 0; c < 3; c++) {
        middle[c] = (ends[0][c] + ends[1][c]) * 0.5f;
        if (ends[1][c] - ends[0][c] > ends[1][longest] - ends[0][longest]) longest = c;
    }
    for (int i = 0; i < 16; i++) {
        if ((int)(mask >> i & 1) != region) continue;
        float along = s->codes[i][longest] - middle[longest];
        for (int c = 0; c < 3; c++) covariance[c] = covariance[c] + (s->codes[i][c] - middle[c]) * along;
    }
    for (int c = 0; c < 3; c++) {
        float first = ends[0][c], last = ends[1][c];
        ends[0][c] = covariance[c] < 0 ? last : first;
        ends[1][c] = covariance[c] < 0 ? first : last;
    }
}

static struct lines bound_regions(const struct search *s, uint32_t mask) {
    struct lines out;
    for (int r = 0; r < 2; r++) {
        for (int c = 0; c < 3; c++) {
            float low = 1e9f, high = -1e9f;
            for (int i = 0; i < 16; i++) {
                if ((int)(mask >> i & 1) != r) continue;
                low = fminf(low, s->codes[i][c]);
                high = fmaxf(high, s->codes[i][c]);
            }
            out.ends[r][0][c] = low;
            out.ends[r][1][c] = high;
        }
        turn_ends(s, mask, r, out.ends[r]);
    }
    return out;
}

/* The diagonals of the regions' boxes, fitted twice to the codes. */
static struct lines fit_regions(const struct search *s, uint32_t mask, bool two) {
    struct lines lines = bound_regions(s, mask);
    for (int round = 0; round < 2; round++) {
        uint8_t indices[16];
        project(s, &lines, mask, two, indices);
        fit(s, mask, two, indices, &lines);
    }
    return lines;
}

/* Sum of squared distances of the codes to the diagonals of their regions' boxes. */
static float distance_to_lines(const struct search *s, const struct lines *lines, uint32_t mask) {
    float directions[2][3], per[2], sum = 0;
    for (int r = 0; r < 2; r++) {
        for (int c = 0; c < 3; c++) directions[r][c] = lines->ends[r][1][c] - lines->ends[r][0][c];
        float length2 = dot3(directions[r], directions[r]);
        per[r] = length2 > 0 ? 1 / length2 : 0;
    }
    for (int i = 0; i < 16; i++) {
        int r = mask >> i & 1;
        float from[3];
        for (int c = 0; c < 3; c++) from[c] = s->codes[i][c] - lines->ends[r][0][c];
        float along = dot3(from, directions[r]);
        sum = sum + (dot3(from, from) - (along * along) * per[r]);
    }
    return sum;
}

static uint32_t choose_pattern(const struct search *s) {
    uint32_t best = 0;
    float least = INFINITY;
    for (uint32_t pattern = 0; pattern < BC6H_PATTERNS; pattern++) {
        struct lines lines = bound_regions(s, bc6h_pattern(pattern));
        float distance = distance_to_lines(s, &lines, bc6h_pattern(pattern));
        if (distance >= least) continue;
        least = distance;
        best = pattern;
    }
    return best;
}

static struct bc6h_fields encode_quality(const struct bc6h_params *params, const float texels[16][3], const struct color_box *box,
                                         const struct bc6h_fields *fast) {
    struct search s = {.is_signed = params->is_signed, .modes = (params->modes ? params->modes : ~0u) | 1u << 11, .least = INFINITY};
    for (int i = 0; i < 16; i++)
        for (int c = 0; c < 3; c++) s.codes[i][c] = code_float(texels[i][c], params->is_signed);
    struct bc6h_fields start = *fast;
    evaluate(&s, &start);

    static const uint32_t one[] = {14, 13, 12, 11}, two[] = {6, 2, 10};
    struct lines lines = {0};
    for (int c = 0; c < 3; c++) {
        lines.ends[0][0][c] = code_float(box->low[c], params->is_signed);
        lines.ends[0][1][c] = code_float(box->high[c], params->is_signed);
    }
    try_modes(&s, one, COUNT_OF(one), 0, &lines);
    lines = fit_regions(&s, 0, false);
    try_modes(&s, one, COUNT_OF(one), 0, &lines);

    if (s.modes & (1u << 2 | 1u << 6 | 1u << 10)) {
        uint32_t pattern = choose_pattern(&s);
        lines = fit_regions(&s, bc6h_pattern(pattern), true);
        try_modes(&s, two, COUNT_OF(two), pattern, &lines);
    }
    return s.best;
}

/* ---- blocks and pictures ---- */

struct bc6h_block bc6h_encode(const struct bc6h_params *params, const float source[16][3]) {
    float texels[16][3];
    for (int i = 0; i < 16; i++)
        for (int c = 0; c < 3; c++) texels[i][c] = bc6h_limit(source[i][c], params->is_signed);
    if (params->quality == BC6H_BEST) return bc6h_encode_best(params, (const float (*)[3])texels);
    struct color_box box = bound((const float (*)[3])texels, params->inset);
    struct bc6h_fields fields = encode_line(params, (const float (*)[3])texels, &box);
    if (params->quality == BC6H_QUALITY) fields = encode_quality(params, (const float (*)[3])texels, &box, &fields);
    bc6h_anchor_indices(&fields);
    bc6h_store_deltas(&fields);
    return bc6h_pack(&fields);
}

struct rows {
    const struct bc6h_params *params;
    const struct bc6h_picture *picture;
    struct bc6h_block *blocks;
};

static void encode_row(void *context, uint32_t y) {
    const struct rows *rows = context;
    uint32_t across = DIVIDE_UP(rows->picture->width, 4u);
    for (uint32_t x = 0; x < across; x++) {
        float texels[16][3];
        bc6h_fetch(rows->picture, x, y, texels);
        rows->blocks[(size_t)y * across + x] = bc6h_encode(rows->params, (const float (*)[3])texels);
    }
}

void bc6h_encode_picture(struct jobs *jobs, const struct bc6h_params *params, const struct bc6h_picture *picture, struct bc6h_block *blocks) {
    struct rows rows = {params, picture, blocks};
    uint32_t count = DIVIDE_UP(picture->height, 4u);
    if (jobs) {
        jobs_parallel_for(jobs, count, encode_row, &rows);
        return;
    }
    for (uint32_t y = 0; y < count; y++) encode_row(&rows, y);
}
