/* SPDX-License-Identifier: MIT */
#include "image/etc1s.h"

enum {
    GLOBAL_BYTES = 20,
    IMAGE_BYTES = 20, /* of an image's description, behind it */
    CODE_BITS_MAX = 16,
    LENGTH_SYMBOLS = 21, /* that code lengths are written with */
    SYMBOLS_MAX = 1 << 14,
    PREDICTIONS = 256,   /* of four blocks; the next symbol repeats the last one */
    RUN_SYMBOLS = 64,
};

/* ---- bits ---- */

/* From the lowest bit of the first byte on. Behind the end come zeros, and `broken` is set. */
struct reader {
    const unsigned char *bytes;
    uint64_t at, end; /* bits */
    bool broken;
};

static struct reader reader_of(const unsigned char *bytes, size_t size) { return (struct reader){.bytes = bytes, .end = (uint64_t)size * 8}; }

static uint32_t take(struct reader *r, uint32_t count) {
    uint32_t value = 0;
    if (r->end - r->at < count) {
        r->broken = true;
        r->at = r->end;
        return 0;
    }
    for (uint32_t i = 0; i < count; i++, r->at++) value |= (uint32_t)(r->bytes[r->at / 8] >> r->at % 8 & 1) << i;
    return value;
}

/* Numbers in pieces of `bits`, the lowest first; one bit more says whether another follows. */
static uint32_t take_pieces(struct reader *r, uint32_t bits) {
    uint32_t value = 0;
    for (uint32_t shift = 0; shift < 32; shift += bits) {
        uint32_t piece = take(r, bits + 1);
        value |= (piece & ((1u << bits) - 1)) << shift;
        if (!(piece >> bits)) return value;
    }
    r->broken = true;
    return 0;
}

/* ---- Huffman codes ---- */

/* Canonical, as in Deflate (RFC 1951, 3.2.2): symbols by length of their codes, then by number. */
struct codes {
    uint32_t counts[CODE_BITS_MAX + 1]; /* of codes by length */
    uint32_t symbol_count;
    uint16_t *symbols; /* with codes */
};

static void free_codes(const fnl_host *host, struct codes *c) {
    if (c->symbols) host_free(host, c->symbols, c->symbol_count * sizeof *c->symbols);
    *c = (struct codes){0};
}

/* FNL_ERROR_FORMAT: there are more codes than bits can tell apart. */
static fnl_result make_codes(const fnl_host *host, const uint8_t *lengths, uint32_t count, struct codes *out) {
    *out = (struct codes){0};
    uint32_t starts[CODE_BITS_MAX + 1], room = 1;
    for (uint32_t i = 0; i < count; i++) out->counts[lengths[i]]++;
    out->counts[0] = 0;
    for (uint32_t length = 1; length <= CODE_BITS_MAX; length++) {
        starts[length] = out->symbol_count;
        out->symbol_count += out->counts[length];
        room *= 2;
        if (out->counts[length] > room) return FNL_ERROR_FORMAT;
        room -= out->counts[length];
    }
    if (out->symbol_count == 0) return FNL_OK;
    out->symbols = host_allocate(host, out->symbol_count * sizeof *out->symbols);
    if (!out->symbols) return FNL_ERROR_MEMORY;
    for (uint32_t i = 0; i < count; i++)
        if (lengths[i]) out->symbols[starts[lengths[i]]++] = (uint16_t)i;
    return FNL_OK;
}

static uint32_t take_symbol(struct reader *r, const struct codes *c) {
    uint32_t code = 0, first = 0, index = 0;
    for (uint32_t length = 1; length <= CODE_BITS_MAX; length++) {
        code |= take(r, 1);
        if (code - first < c->counts[length]) return c->symbols[index + code - first];
        index += c->counts[length];
        first = (first + c->counts[length]) << 1;
        code <<= 1;
    }
    r->broken = true;
    return 0;
}

/* The lengths of a table's codes, which are written with codes themselves. */
static void take_lengths(struct reader *r, const struct codes *c, uint8_t *lengths, uint32_t count) {
    for (uint32_t at = 0; at < count && !r->broken;) {
        uint32_t symbol = take_symbol(r, c), run = 1;
        uint8_t length = (uint8_t)symbol;
        if (symbol > CODE_BITS_MAX) {
            const bool repeats = symbol >= 19;
            run = symbol == 17 ? 3 + take(r, 3) : symbol == 18 ? 11 + take(r, 7) : symbol == 19 ? 3 + take(r, 2) : 7 + take(r, 7);
            if (repeats && (at == 0 || lengths[at - 1] == 0)) r->broken = true;
            length = repeats && at ? lengths[at - 1] : 0;
        }
        if (run > count - at) {
            r->broken = true;
            return;
        }
        memset(lengths + at, length, run);
        at += run;
    }
}

/* A table without symbols is allowed where nothing uses it. */
static fnl_result take_codes(const fnl_host *host, struct reader *r, struct codes *out) {
    static const uint8_t order[LENGTH_SYMBOLS] = {17, 18, 19, 20, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15, 16};
    uint8_t small[LENGTH_SYMBOLS] = {0};
    *out = (struct codes){0};
    const uint32_t count = take(r, 14);
    if (count == 0) return r->broken ? FNL_ERROR_FORMAT : FNL_OK;
    const uint32_t small_count = take(r, 5);
    if (small_count == 0 || small_count > LENGTH_SYMBOLS) return FNL_ERROR_FORMAT;
    for (uint32_t i = 0; i < small_count; i++) small[order[i]] = (uint8_t)take(r, 3);
    struct codes lengths_codes;
    TRY(make_codes(host, small, LENGTH_SYMBOLS, &lengths_codes));
    uint8_t *lengths = host_allocate_zero(host, SYMBOLS_MAX);
    fnl_result result = lengths ? FNL_OK : FNL_ERROR_MEMORY;
    if (result == FNL_OK) {
        take_lengths(r, &lengths_codes, lengths, count);
        result = r->broken ? FNL_ERROR_FORMAT : make_codes(host, lengths, count, out);
        host_free(host, lengths, SYMBOLS_MAX);
    }
    free_codes(host, &lengths_codes);
    return result;
}

/* ---- codebooks ---- */

struct endpoint {
    uint8_t rgb[3], intensity; /* 5 bits each; which row of modifiers */
};

struct etc1s {
    const unsigned char *images; /* their descriptions, in the file */
    uint32_t image_count, endpoint_count, selector_count, history_size;
    struct endpoint *endpoints;
    uint32_t *selectors; /* two bits for each texel, row by row */
    struct codes predictions, deltas, selector_codes, runs;
};

void etc1s_destroy(const fnl_host *host, struct etc1s **handle) {
    struct etc1s *e = *handle;
    if (!e) return;
    if (e->endpoints) host_free(host, e->endpoints, e->endpoint_count * sizeof *e->endpoints);
    if (e->selectors) host_free(host, e->selectors, e->selector_count * sizeof *e->selectors);
    struct codes *codes[] = {&e->predictions, &e->deltas, &e->selector_codes, &e->runs};
    for (uint32_t i = 0; i < COUNT_OF(codes); i++) free_codes(host, codes[i]);
    host_free(host, e, sizeof *e);
    *handle = NULL;
}

static fnl_result take_endpoints(const fnl_host *host, struct reader *r, struct etc1s *e) {
    struct codes colors[3] = {0}, intensities = {0};
    fnl_result result = FNL_OK;
    for (uint32_t i = 0; i < 3 && result == FNL_OK; i++) result = take_codes(host, r, &colors[i]);
    if (result == FNL_OK) result = take_codes(host, r, &intensities);
    const uint32_t channels = take(r, 1) ? 1 : 3;
    struct endpoint before = {{16, 16, 16}, 0};
    for (uint32_t i = 0; i < e->endpoint_count && result == FNL_OK; i++) {
        before.intensity = (before.intensity + take_symbol(r, &intensities)) & 7;
        for (uint32_t c = 0; c < channels; c++) {
            const uint8_t old = before.rgb[c];
            before.rgb[c] = (old + take_symbol(r, &colors[old < 10 ? 0 : old < 22 ? 1 : 2])) & 31;
        }
        if (channels == 1) before.rgb[1] = before.rgb[2] = before.rgb[0];
        e->endpoints[i] = before;
        if (r->broken) result = FNL_ERROR_FORMAT;
    }
    for (uint32_t i = 0; i < 3; i++) free_codes(host, &colors[i]);
    free_codes(host, &intensities);
    return result;
}

static fnl_result take_selectors(const fnl_host *host, struct reader *r, struct etc1s *e) {
    struct codes deltas = {0};
    if (take(r, 2)) return FNL_ERROR_FORMAT;
    const bool raw = take(r, 1);
    fnl_result result = raw ? FNL_OK : take_codes(host, r, &deltas);
    for (uint32_t i = 0; i < e->selector_count && result == FNL_OK; i++) {
        uint32_t value = 0;
        for (uint32_t row = 0; row < 4; row++) value |= (raw || i == 0 ? take(r, 8) : take_symbol(r, &deltas) & 255) << 8 * row;
        e->selectors[i] = raw || i == 0 ? value : value ^ e->selectors[i - 1];
        if (r->broken) result = FNL_ERROR_FORMAT;
    }
    free_codes(host, &deltas);
    return result;
}

static fnl_result take_tables(const fnl_host *host, struct reader *r, struct etc1s *e) {
    TRY(take_codes(host, r, &e->predictions));
    TRY(take_codes(host, r, &e->deltas));
    TRY(take_codes(host, r, &e->selector_codes));
    TRY(take_codes(host, r, &e->runs));
    e->history_size = take(r, 13);
    return r->broken ? FNL_ERROR_FORMAT : FNL_OK;
}

static fnl_result part_result(const struct image_source *source, fnl_result result, const char *part) {
    if (result == FNL_ERROR_MEMORY) return image_fail(source, result, "out of memory");
    return result == FNL_OK ? FNL_OK : image_fail(source, result, "broken BasisLZ: the %s cannot be read", part);
}

static fnl_result read_global(const struct image_source *source, const unsigned char *global, size_t size, uint32_t images, struct etc1s *e) {
    const fnl_host *host = source->host;
    const uint64_t head = GLOBAL_BYTES + (uint64_t)images * IMAGE_BYTES;
    if (size < head) return image_fail(source, FNL_ERROR_FORMAT, "broken BasisLZ: the global data is cut off");
    const uint32_t lengths[] = {little32(global + 4), little32(global + 8), little32(global + 12)};
    if ((uint64_t)lengths[0] + lengths[1] + lengths[2] > size - head)
        return image_fail(source, FNL_ERROR_FORMAT, "broken BasisLZ: codebooks of %u, %u and %u bytes do not fit in the global data", lengths[0], lengths[1],
                          lengths[2]);
    e->images = global + GLOBAL_BYTES;
    e->image_count = images;
    e->endpoint_count = little32(global) & 0xffff;
    e->selector_count = little32(global) >> 16;
    if (e->endpoint_count == 0 || e->selector_count == 0) return image_fail(source, FNL_ERROR_FORMAT, "broken BasisLZ: a codebook is empty");
    e->endpoints = host_allocate(host, e->endpoint_count * sizeof *e->endpoints);
    e->selectors = host_allocate(host, e->selector_count * sizeof *e->selectors);
    if (!e->endpoints || !e->selectors) return image_fail(source, FNL_ERROR_MEMORY, "out of memory");
    const unsigned char *part = global + head;
    struct reader readers[3];
    for (uint32_t i = 0; i < 3; part += lengths[i++]) readers[i] = reader_of(part, lengths[i]);
    TRY(part_result(source, take_endpoints(host, &readers[0], e), "codebook of endpoints"));
    TRY(part_result(source, take_selectors(host, &readers[1], e), "codebook of selectors"));
    return part_result(source, take_tables(host, &readers[2], e), "tables of codes");
}

fnl_result etc1s_create(const struct image_source *source, const unsigned char *global, size_t size, uint32_t images, struct etc1s **out) {
    *out = host_allocate_zero(source->host, sizeof **out);
    if (!*out) return image_fail(source, FNL_ERROR_MEMORY, "out of memory");
    fnl_result result = read_global(source, global, size, images, *out);
    if (result != FNL_OK) etc1s_destroy(source->host, out);
    return result;
}

/* ---- slices ---- */

/* Selectors that came lately, the more often used further in front. */
struct history {
    uint16_t *values;
    uint32_t size, next;
};

static void history_add(struct history *h, uint16_t value) {
    if (h->size == 0) return;
    h->values[h->next++] = value;
    if (h->next == h->size) h->next = h->size / 2;
}

static uint16_t history_use(struct history *h, uint32_t index) {
    uint16_t value = h->values[index];
    h->values[index] = h->values[index / 2];
    h->values[index / 2] = value;
    return value;
}

struct slice {
    const struct etc1s *e;
    struct reader r;
    uint32_t across;          /* blocks */
    uint16_t *rows[2];        /* endpoints of this row of blocks and the one above, by the row's parity */
    uint8_t *below;           /* predictions that the row above read for this one, for each two blocks */
    struct history history;
    uint32_t bits, last_bits, repeats; /* predictions */
    uint32_t endpoint, run;
};

/* How each of 2 x 2 blocks finds its endpoint, two bits for each. */
static void next_predictions(struct slice *s, uint32_t x, uint32_t y) {
    if (y & 1) {
        s->bits = s->below[x / 2];
        return;
    }
    if (s->repeats) {
        s->repeats--;
    } else {
        uint32_t symbol = take_symbol(&s->r, &s->e->predictions);
        if (symbol > PREDICTIONS) s->r.broken = true;
        if (symbol >= PREDICTIONS)
            s->repeats = take_pieces(&s->r, 4) + 2;
        else
            s->last_bits = symbol;
    }
    s->bits = s->last_bits;
    s->below[x / 2] = (uint8_t)(s->bits >> 4);
}

static void next_endpoint(struct slice *s, uint32_t x, uint32_t y) {
    if ((x & 1) == 0) next_predictions(s, x, y);
    const uint32_t prediction = s->bits & 3;
    const uint16_t *above = s->rows[(y & 1) ^ 1];
    s->bits >>= 2;
    if ((prediction != 1 && prediction != 3 && x == 0) || ((prediction == 1 || prediction == 2) && y == 0)) {
        s->r.broken = true;
        return;
    }
    if (prediction == 1) s->endpoint = above[x];
    if (prediction == 2) s->endpoint = above[x - 1];
    if (prediction == 3) {
        s->endpoint += take_symbol(&s->r, &s->e->deltas);
        if (s->endpoint >= s->e->endpoint_count) s->endpoint -= s->e->endpoint_count;
    }
    if (s->endpoint >= s->e->endpoint_count) {
        s->r.broken = true;
        s->endpoint = 0;
    }
    s->rows[y & 1][x] = (uint16_t)s->endpoint;
}

static uint32_t next_selector(struct slice *s) {
    const uint32_t count = s->e->selector_count;
    uint32_t symbol = count;
    if (s->run) {
        s->run--;
    } else {
        symbol = take_symbol(&s->r, &s->e->selector_codes);
        if (symbol == count + s->history.size) {
            uint32_t length = take_symbol(&s->r, &s->e->runs);
            s->run = (length == RUN_SYMBOLS - 1 ? take_pieces(&s->r, 7) : length) + 2; /* behind this block */
            symbol = count;
        }
    }
    if (symbol < count) {
        history_add(&s->history, (uint16_t)symbol);
        return symbol;
    }
    if (symbol - count >= s->history.size) {
        s->r.broken = true;
        return 0;
    }
    return history_use(&s->history, symbol - count);
}

struct target {
    uint8_t *pixels;
    uint32_t width, height;
    bool alpha; /* only alpha is written, from green */
};

static void put_block(const struct endpoint *endpoint, uint32_t selector, const struct target *to, uint32_t x, uint32_t y) {
    static const int16_t modifiers[8][4] = {{-8, -2, 2, 8},     {-17, -5, 5, 17},   {-29, -9, 9, 29},     {-42, -13, 13, 42},
                                            {-60, -18, 18, 60}, {-80, -24, 24, 80}, {-106, -33, 33, 106}, {-183, -47, 47, 183}};
    uint8_t colors[4][4];
    for (int k = 0; k < 4; k++) {
        for (int c = 0; c < 3; c++) {
            int value = (endpoint->rgb[c] << 3 | endpoint->rgb[c] >> 2) + modifiers[endpoint->intensity][k];
            colors[k][c] = (uint8_t)CLAMP(value, 0, 255);
        }
        colors[k][3] = 255;
    }
    for (uint32_t j = 0; j < 4 && 4 * y + j < to->height; j++)
        for (uint32_t i = 0; i < 4 && 4 * x + i < to->width; i++) {
            uint8_t *pixel = to->pixels + 4 * ((size_t)(4 * y + j) * to->width + 4 * x + i);
            const uint8_t *color = colors[selector >> (8 * j + 2 * i) & 3];
            if (to->alpha)
                pixel[3] = color[1];
            else
                memcpy(pixel, color, 4);
        }
}

static fnl_result decode_slice(const struct image_source *source, const struct etc1s *e, const unsigned char *bytes, size_t size, const struct target *to) {
    const uint32_t across = DIVIDE_UP(to->width, 4u), down = DIVIDE_UP(to->height, 4u);
    const size_t memory = (2 * (size_t)across + e->history_size) * sizeof(uint16_t) + DIVIDE_UP(across, 2u);
    uint16_t *scratch = host_allocate_zero(source->host, memory);
    if (!scratch) return image_fail(source, FNL_ERROR_MEMORY, "out of memory");
    struct slice s = {.e = e, .r = reader_of(bytes, size), .across = across, .rows = {scratch, scratch + across}};
    s.history = (struct history){scratch + 2 * (size_t)across, e->history_size, e->history_size / 2};
    s.below = (uint8_t *)(scratch + 2 * (size_t)across + e->history_size);
    for (uint32_t y = 0; y < down && !s.r.broken; y++)
        for (uint32_t x = 0; x < across && !s.r.broken; x++) {
            next_endpoint(&s, x, y);
            uint32_t selector = next_selector(&s);
            if (!s.r.broken) put_block(&e->endpoints[s.endpoint], e->selectors[selector], to, x, y);
        }
    host_free(source->host, scratch, memory);
    return s.r.broken ? FNL_ERROR_FORMAT : FNL_OK;
}

fnl_result etc1s_decode(const struct image_source *source, const struct etc1s *e, uint32_t image, const unsigned char *level, size_t level_size,
                        bool alpha, uint32_t width, uint32_t height, uint8_t *pixels) {
    REQUIRE(source->host, image < e->image_count);
    const unsigned char *description = e->images + IMAGE_BYTES * (size_t)image;
    if (little32(description) & 2) return image_fail(source, FNL_ERROR_UNSUPPORTED, "BasisLZ: image %u is a frame of an animation (only pictures are read)", image);
    for (uint32_t k = 0; k < (alpha ? 2 : 1); k++) {
        uint32_t offset = little32(description + 4 + 8 * k), length = little32(description + 8 + 8 * k);
        const char *what = k ? "alpha" : "colour";
        if (length == 0 || (uint64_t)offset + length > level_size)
            return image_fail(source, FNL_ERROR_FORMAT, "broken BasisLZ: the %s of image %u is cut off (%u bytes from %u on of %zu)", what, image, length, offset,
                              level_size);
        fnl_result result = decode_slice(source, e, level + offset, length, &(struct target){pixels, width, height, k == 1});
        if (result == FNL_ERROR_FORMAT) return image_fail(source, result, "broken BasisLZ: the %s of image %u cannot be decoded", what, image);
        TRY(result);
    }
    return FNL_OK;
}
