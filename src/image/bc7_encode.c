/* SPDX-License-Identifier: MIT */
/*
 * Blocks of BC7 from texels of which it is known how they lie: what transcodes UASTC, whose subsets and planes BC7 has too, and ETC1S, whose colours lie
 * on one line. The ends of each line are fitted by least squares, rounded with every setting of the lowest bits that they share, and the best is kept.
 */
#include "image/bc7.h"

#include <math.h>

enum { ROUNDS = 3, PATTERNS = 64, NONE = 4 };

/* One line through some texels, of some channels: its ends as they are stored, and an index for each of its texels. */
struct line {
    uint32_t mask, first, channels; /* bits of texels; channels first .. first + channels - 1 */
    uint32_t bits, index_bits;      /* stored bits of an end, without the lowest one that is shared (`p`) */
    uint32_t ends[2][4], p[2];
    uint8_t indices[16];
};

struct encoding {
    uint32_t mode, pattern, rotation, selection, error;
    struct line lines[3], alpha; /* by subset; of a channel with indices of its own */
};

static bool in(const struct line *l, uint32_t i) { return l->mask >> i & 1; }

/* What the decoder makes of a stored end. `has_p`: with a lowest bit of its own, or one that it shares. */
static uint32_t decoded_end(uint32_t stored, uint32_t bits, bool has_p, uint32_t p) {
    const uint32_t size = bits + has_p, value = has_p ? stored << 1 | p : stored;
    return value << (8 - size) | value >> (2 * size - 8);
}

static uint32_t stored_end(double value, uint32_t bits, bool has_p, uint32_t p) {
    const double most = (1u << bits) - 1, scale = ((1u << (bits + has_p)) - 1) / 255.0;
    return (uint32_t)fmin(fmax(floor((has_p ? (value * scale - p) / 2 : value * scale) + 0.5), 0), most);
}

/* The nearest index for each texel; the sum of squared differences. */
static uint32_t assign(const uint8_t texels[16][4], struct line *l, bool has_p) {
    uint8_t palette[16][4];
    uint32_t sum = 0;
    for (uint32_t c = l->first; c < l->first + l->channels; c++) {
        const uint32_t a = decoded_end(l->ends[0][c], l->bits, has_p, l->p[0]), b = decoded_end(l->ends[1][c], l->bits, has_p, l->p[1]);
        for (uint32_t k = 0; k < 1u << l->index_bits; k++) palette[k][c] = bc7_interpolate(a, b, k, l->index_bits);
    }
    for (uint32_t i = 0; i < 16; i++) {
        uint32_t least = UINT32_MAX;
        for (uint32_t k = 0; in(l, i) && k < 1u << l->index_bits; k++) {
            uint32_t error = 0;
            for (uint32_t c = l->first; c < l->first + l->channels; c++) {
                const int32_t d = texels[i][c] - palette[k][c];
                error += (uint32_t)(d * d);
            }
            if (error >= least) continue;
            least = error;
            l->indices[i] = (uint8_t)k;
        }
        if (in(l, i)) sum += least;
    }
    return sum;
}

/* The diagonal of the texels' box along which they lie. */
static void begin_ends(const uint8_t texels[16][4], const struct line *l, double ends[2][4]) {
    uint32_t longest = l->first;
    double mean[4] = {0}, count = 0;
    for (uint32_t c = l->first; c < l->first + l->channels; c++) {
        ends[0][c] = 255;
        ends[1][c] = 0;
        for (uint32_t i = 0; i < 16; i++) {
            if (!in(l, i)) continue;
            ends[0][c] = fmin(ends[0][c], texels[i][c]);
            ends[1][c] = fmax(ends[1][c], texels[i][c]);
            mean[c] += texels[i][c];
            count += c == l->first;
        }
        if (ends[1][c] - ends[0][c] > ends[1][longest] - ends[0][longest]) longest = c;
    }
    for (uint32_t c = l->first; c < l->first + l->channels; c++) {
        double covariance = 0;
        for (uint32_t i = 0; i < 16; i++)
            if (in(l, i)) covariance += (texels[i][c] - mean[c] / count) * (texels[i][longest] - mean[longest] / count);
        if (covariance >= 0) continue;
        const double low = ends[0][c];
        ends[0][c] = ends[1][c];
        ends[1][c] = low;
    }
}

/* The ends that fit the indices best. Those of texels that all have one index stay. */
static void fit_ends(const uint8_t texels[16][4], const struct line *l, double ends[2][4]) {
    double aa = 0, ab = 0, bb = 0, x[4] = {0}, y[4] = {0};
    for (uint32_t i = 0; i < 16; i++) {
        if (!in(l, i)) continue;
        const double b = bc7_interpolate(0, 64, l->indices[i], l->index_bits) / 64.0, a = 1 - b;
        aa += a * a;
        ab += a * b;
        bb += b * b;
        for (uint32_t c = l->first; c < l->first + l->channels; c++) {
            x[c] += a * texels[i][c];
            y[c] += b * texels[i][c];
        }
    }
    const double determinant = aa * bb - ab * ab;
    if (!(determinant > 1e-3)) return;
    for (uint32_t c = l->first; c < l->first + l->channels; c++) {
        ends[0][c] = fmin(fmax((bb * x[c] - ab * y[c]) / determinant, 0), 255);
        ends[1][c] = fmin(fmax((aa * y[c] - ab * x[c]) / determinant, 0), 255);
    }
}

/* `p_kinds`: 0: ends have no lowest bit of that kind; 2: both share one; 4: each has its own. */
static uint32_t encode_line(const uint8_t texels[16][4], struct line *l, uint32_t p_kinds) {
    struct line best = *l;
    uint32_t least = UINT32_MAX;
    double ends[2][4];
    begin_ends(texels, l, ends);
    for (uint32_t round = 0; round < ROUNDS && least > 0; round++) {
        for (uint32_t p = 0; p < MAX(p_kinds, 1u); p++) {
            struct line next = *l;
            next.p[0] = p & 1;
            next.p[1] = p_kinds == 4 ? p >> 1 : p & 1;
            for (uint32_t e = 0; e < 2; e++)
                for (uint32_t c = l->first; c < l->first + l->channels; c++) next.ends[e][c] = stored_end(ends[e][c], l->bits, p_kinds > 0, next.p[e]);
            const uint32_t error = assign(texels, &next, p_kinds > 0);
            if (error >= least) continue;
            least = error;
            best = next;
        }
        fit_ends(texels, &best, ends);
    }
    *l = best;
    return least;
}

static void try_mode(const uint8_t texels[16][4], uint32_t mode, uint32_t pattern, uint32_t rotation, uint32_t selection, struct encoding *best) {
    const struct bc7_mode *m = &bc7_modes[mode];
    struct encoding next = {.mode = mode, .pattern = pattern, .rotation = rotation, .selection = selection};
    uint8_t turned[16][4];
    memcpy(turned, texels, sizeof turned);
    for (uint32_t i = 0; rotation && i < 16; i++) {
        turned[i][3] = texels[i][rotation - 1];
        turned[i][rotation - 1] = texels[i][3];
    }
    const bool together = m->alpha_bits && !m->second_bits; /* alpha has the indices of the colours */
    for (uint32_t s = 0; s < m->subsets; s++) {
        struct line *l = &next.lines[s];
        *l = (struct line){.channels = together ? 4 : 3, .bits = m->color_bits, .index_bits = selection ? m->second_bits : m->index_bits};
        for (uint32_t i = 0; i < 16; i++) l->mask |= (uint32_t)(bc7_subset_of(m->subsets, pattern, i) == s) << i;
        next.error += encode_line((const uint8_t(*)[4])turned, l, m->own_p ? 4 : m->shared_p ? 2 : 0);
    }
    for (uint32_t i = 0; !m->alpha_bits && i < 16; i++) next.error += (uint32_t)((255 - texels[i][3]) * (255 - texels[i][3]));
    if (m->second_bits) {
        next.alpha = (struct line){.mask = 0xffff, .first = 3, .channels = 1, .bits = m->alpha_bits, .index_bits = selection ? m->index_bits : m->second_bits};
        next.error += encode_line((const uint8_t(*)[4])turned, &next.alpha, 0);
    }
    if (next.error < best->error) *best = next;
}

/* Whether each subset of a pattern lies within one of the block's. */
static bool pattern_fits(uint32_t subsets, uint32_t pattern, const uint8_t wanted[16]) {
    uint8_t of[3] = {NONE, NONE, NONE};
    for (uint32_t i = 0; i < 16; i++) {
        const uint32_t s = bc7_subset_of(subsets, pattern, i);
        if (of[s] != NONE && of[s] != wanted[i]) return false;
        of[s] = wanted[i];
    }
    return true;
}

/* ---- bits ---- */

static void put(unsigned char block[16], uint32_t *at, uint32_t value, uint32_t count) {
    for (uint32_t i = 0; i < count; i++, ++*at) block[*at / 8] |= (unsigned char)((value >> i & 1) << *at % 8);
}

/* The index of the anchor has a highest bit of 0: else the ends change places. */
static void turn_line(struct line *l, uint32_t anchor) {
    const uint32_t last = (1u << l->index_bits) - 1;
    if (l->indices[anchor] <= last / 2) return;
    for (uint32_t i = 0; i < 16; i++) l->indices[i] = (uint8_t)(last - l->indices[i]);
    for (uint32_t c = 0; c < 4; c++) {
        const uint32_t first = l->ends[0][c];
        l->ends[0][c] = l->ends[1][c];
        l->ends[1][c] = first;
    }
    const uint32_t p = l->p[0];
    l->p[0] = l->p[1];
    l->p[1] = p;
}

static void put_indices(unsigned char block[16], uint32_t *at, const struct encoding *e, const struct line *alone) {
    const uint32_t subsets = bc7_modes[e->mode].subsets;
    for (uint32_t i = 0; i < 16; i++) {
        const uint32_t s = bc7_subset_of(subsets, e->pattern, i);
        const struct line *l = alone ? alone : &e->lines[s];
        put(block, at, l->indices[i], l->index_bits - (bc7_anchor_of(subsets, e->pattern, s) == i));
    }
}

static void pack(struct encoding *e, unsigned char block[16]) {
    const struct bc7_mode *m = &bc7_modes[e->mode];
    uint32_t at = 0;
    memset(block, 0, 16);
    for (uint32_t s = 0; s < m->subsets; s++) turn_line(&e->lines[s], bc7_anchor_of(m->subsets, e->pattern, s));
    if (m->second_bits) turn_line(&e->alpha, 0);
    put(block, &at, 1u << e->mode, e->mode + 1);
    put(block, &at, e->pattern, m->pattern_bits);
    put(block, &at, e->rotation, m->rotation_bits);
    put(block, &at, e->selection, m->selection_bits);
    for (uint32_t c = 0; c < (m->alpha_bits ? 4u : 3u); c++)
        for (uint32_t k = 0; k < 2u * m->subsets; k++) {
            const struct line *l = m->second_bits && c == 3 ? &e->alpha : &e->lines[k / 2];
            put(block, &at, l->ends[k % 2][c], c == 3 ? m->alpha_bits : m->color_bits);
        }
    for (uint32_t s = 0; s < m->subsets; s++) {
        if (m->own_p || m->shared_p) put(block, &at, e->lines[s].p[0], 1);
        if (m->own_p) put(block, &at, e->lines[s].p[1], 1);
    }
    put_indices(block, &at, e, m->second_bits && e->selection ? &e->alpha : NULL);
    if (m->second_bits) put_indices(block, &at, e, e->selection ? &e->lines[0] : &e->alpha);
}

void bc7_encode(const uint8_t texels[16][4], const struct block_structure *structure, unsigned char block[16]) {
    struct encoding best = {.error = UINT32_MAX};
    try_mode(texels, 6, 0, 0, 0, &best);
    if (structure && best.error > 0) {
        uint32_t subsets = 1;
        for (uint32_t i = 0; i < 16; i++) subsets = MAX(subsets, structure->subsets[i] + 1u);
        if (structure->lone < NONE) {
            const uint32_t rotation = structure->lone == 3 ? 0 : structure->lone + 1u;
            try_mode(texels, 5, 0, rotation, 0, &best);
            for (uint32_t selection = 0; selection < 2; selection++) try_mode(texels, 4, 0, rotation, selection, &best);
        }
        for (uint32_t mode = 0; mode < 8 && subsets > 1; mode++) {
            const struct bc7_mode *m = &bc7_modes[mode];
            for (uint32_t pattern = 0; m->subsets >= subsets && m->subsets > 1 && pattern < 1u << m->pattern_bits && pattern < PATTERNS; pattern++)
                if (pattern_fits(m->subsets, pattern, structure->subsets)) try_mode(texels, mode, pattern, 0, 0, &best);
        }
    }
    pack(&best, block);
}
