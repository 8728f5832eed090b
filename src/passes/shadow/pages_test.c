/* SPDX-License-Identifier: MIT */
/** The pages of shadow maps, frame after frame, against sets of pages that are made on the CPU one page at a time. */
#include "passes/shadow/pages.h"
#include "tests/list_bench.h"

enum {
    ROW_BITS = SHADOW_ROW_WORDS * 32,
    FACE_BITS = SHADOW_FACE_WORDS * 32,
    DIRECTIONAL = 3,
    CLASSES = 4,
    PRESSURES = 25,
    OLDEST = 31,
    NOBODY = SHADOW_MOST_ROWS,
};

/* ---- what the device is asked, and says ---- */

struct answer {
    uint32_t row_count, page_limit;
    uint32_t *held, *before, *biases;
    struct gpu_shadow_page *pages;
    struct gpu_shadow_counts counts;
};

static void answer_free(struct answer *a) {
    free(a->held);
    free(a->before);
    free(a->biases);
    free(a->pages);
    *a = (struct answer){0};
}

struct bench {
    struct graph *graph;
    struct shadow_state state;
    uint32_t row_count, row_limit, side; /* side: cells */
    struct gpu_light *lights;
    struct gpu_entity_bounds *bounds;
    uint32_t *wanted;
    struct gpu_view view;
    bool clears;                 /* the last frame cleared the atlas */
    uint32_t waits;              /* the row whose pages nobody draws, even those that need not be drawn; or NOBODY */
    struct random_state *chance; /* or a few, by chance */
    /* The reference's: what was there in the last frame, by row and bit. */
    bool *was;
    uint32_t *places; /* of what was there */
    uint8_t *ages;    /* frames for which nobody has looked it up, up to OLDEST */
    uint32_t *since;  /* frames since it was drawn */
    bool *lost;       /* it was idle and had to be drawn */
    struct gpu_shape *shapes;
    bool known;
    struct totals {
        uint32_t laid_anew, with_traced, with_coarsened, keeps_all, keeps_some, keeps_none; /* frames */
        uint32_t evicted;                                                                   /* pages */
    } totals;
};

static void *zeroed(size_t count, size_t size) {
    void *memory = calloc(MAX(count, 1u), size);
    assert_non_null(memory);
    return memory;
}

static struct bench bench_open(uint32_t row_limit, uint32_t side) {
    struct bench b = {.row_limit = row_limit, .row_count = row_limit, .side = side};
    assert_int_equal(graph_create(gpu_host(harness_device()), harness_device(), &b.graph), FNL_OK);
    b.lights = zeroed(row_limit, sizeof *b.lights);
    b.bounds = zeroed(row_limit, sizeof *b.bounds);
    b.wanted = zeroed(row_limit * SHADOW_ROW_WORDS, sizeof *b.wanted);
    b.was = zeroed(row_limit * ROW_BITS, sizeof *b.was);
    b.places = zeroed(row_limit * ROW_BITS, sizeof *b.places);
    b.ages = zeroed(row_limit * ROW_BITS, sizeof *b.ages);
    b.since = zeroed(row_limit * ROW_BITS, sizeof *b.since);
    b.lost = zeroed(row_limit * ROW_BITS, sizeof *b.lost);
    b.shapes = zeroed(row_limit, sizeof *b.shapes);
    b.view.eye = vec3_make(1, 2, 3);
    b.waits = NOBODY;
    return b;
}

static void bench_close(struct bench *b) {
    shadow_state_finish(harness_device(), &b->state);
    graph_destroy(&b->graph);
    void *all[] = {b->lights, b->bounds, b->wanted, b->was, b->places, b->ages, b->since, b->lost, b->shapes};
    for (uint32_t i = 0; i < COUNT_OF(all); i++) free(all[i]);
}

static struct answer run_frame(struct bench *b) {
    gpu_device *device = harness_device();
    struct answer a = {.row_count = b->row_count};
    struct gpu_buffer lights, wanted;
    const uint64_t bounds = (DIRECTIONAL + b->row_count) * sizeof(struct gpu_light),
                   light_bytes = bounds + b->row_count * sizeof(struct gpu_entity_bounds),
                   wanted_bytes = b->row_count * SHADOW_ROW_WORDS * 4ull;
    assert_int_equal(shadow_pages_prepare(device, &b->state, b->row_count, b->side * SHADOW_PAGE), FNL_OK);
    assert_int_equal(gpu_buffer_create(device, "test lights", light_bytes, GPU_MEMORY_UPLOAD, &lights), FNL_OK);
    assert_int_equal(gpu_buffer_create(device, "test wanted", wanted_bytes, GPU_MEMORY_UPLOAD, &wanted), FNL_OK);
    memset(lights.mapped, 0xff, DIRECTIONAL * sizeof(struct gpu_light));
    memcpy((struct gpu_light *)lights.mapped + DIRECTIONAL, b->lights, b->row_count * sizeof *b->lights);
    memcpy((char *)lights.mapped + bounds, b->bounds, b->row_count * sizeof *b->bounds);
    memcpy(wanted.mapped, b->wanted, wanted_bytes);
    graph_begin(b->graph);
    assert_int_equal(gpu_frame_begin(device), FNL_OK);
    struct gpu_slice view = gpu_frame_allocate(device, sizeof b->view);
    memcpy(view.data, &b->view, sizeof b->view);
    const struct light_set set = {.buffer = graph_import_buffer(b->graph, "test lights", &lights),
                                  .entities = lights.address + bounds,
                                  .lights = lights.address,
                                  .directional_count = DIRECTIONAL,
                                  .local_count = b->row_count};
    const struct lighting lighting = lighting_add(b->graph, device, &(struct lighting){.lights = set, .view = view.address}, NULL);
    struct shadow_turn next;
    struct shadow_pages made = shadow_pages_add(
        b->graph, device, &b->state,
        &(struct shadow_pages_input){.wanted = graph_import_buffer(b->graph, "test wanted", &wanted), .lighting = &lighting}, &next);
    a.page_limit = made.page_limit;
    assert_int_equal(made.row_count, b->row_count);
    struct list_reads reads;
    list_reads_add(b->graph, (graph_buffer[]){made.held, made.before, made.pages, made.biases, made.counts}, 5, &reads);
    assert_int_equal(graph_compile(b->graph), FNL_OK);
    static char plan[1 << 16];
    assert_true(graph_print(b->graph, plan, sizeof plan) < sizeof plan);
    b->clears = strstr(plan, "shadow clear") != NULL;
    assert_int_equal(graph_execute_frame(b->graph, &(struct graph_execute_params){.poison = true}), FNL_OK);
    assert_int_equal(gpu_wait_idle(device), FNL_OK);
    b->state.last = next;
    a.held = list_reads_take(&reads, 0);
    a.before = list_reads_take(&reads, 1);
    a.pages = list_reads_take(&reads, 2);
    a.biases = list_reads_take(&reads, 3);
    assert_true(reads.buffers[2].size >= a.page_limit * sizeof *a.pages);
    memcpy(&a.counts, reads.buffers[4].mapped, sizeof a.counts);
    list_reads_free(&reads);
    gpu_buffer_destroy(device, &lights);
    gpu_buffer_destroy(device, &wanted);
    return a;
}

/* ---- the reference ---- */

static bool bit_of(const uint32_t *words, uint32_t row, uint32_t bit) {
    return words[row * SHADOW_ROW_WORDS + bit / 32] >> bit % 32 & 1;
}

static const uint32_t level_sides[SHADOW_LEVELS] = {16, 8, 4, 2, 1, 1, 1, 1};

static uint32_t page_bit(uint32_t face, uint32_t level, uint32_t x, uint32_t y) {
    uint32_t bit = face * FACE_BITS;
    for (uint32_t l = 0; l < level; l++) bit += level_sides[l] * level_sides[l];
    return bit + y * level_sides[level] + x;
}

/* The page some levels coarser that holds this one; one that is in no level: ROW_BITS. */
static uint32_t coarser_bit(uint32_t bit, uint32_t bias, uint32_t *out_level) {
    uint32_t face = bit / FACE_BITS, rest = bit % FACE_BITS, level = 0;
    while (level < SHADOW_LEVELS && rest >= level_sides[level] * level_sides[level]) {
        rest -= level_sides[level] * level_sides[level];
        level++;
    }
    if (level == SHADOW_LEVELS) return ROW_BITS;
    uint32_t x = rest % level_sides[level], y = rest / level_sides[level];
    for (; bias > 0 && level + 1 < SHADOW_LEVELS; bias--, level++) {
        x = x * level_sides[level + 1] / level_sides[level];
        y = y * level_sides[level + 1] / level_sides[level];
    }
    *out_level = level;
    return page_bit(face, level, x, y);
}

static uint32_t class_of_level(uint32_t level) {
    return level < SHADOW_SQUARE_LEVELS ? 0 : level - SHADOW_SQUARE_LEVELS + 1;
}

static uint32_t cells_for(const uint32_t counts[CLASSES]) {
    uint32_t cells = 0;
    for (uint32_t c = 0; c < CLASSES; c++) cells += DIVIDE_UP(counts[c], 1u << 2 * c);
    return cells;
}

/* In units of one over all directions from the viewer, times four. */
static double importance_of(const struct bench *b, uint32_t row) {
    const struct gpu_light *l = &b->lights[row];
    const struct gpu_shape *s = &l->shape;
    double flux = 0.2126 * (double)l->color.x + 0.7152 * (double)l->color.y + 0.0722 * (double)l->color.z, pi = acos(-1);
    if (s->kind == GPU_SHAPE_BOX) flux *= 2 * (double)s->size.x * 2 * (double)s->size.y;
    if (s->kind == GPU_SHAPE_SPHERE) flux *= 4 * pi;
    if (s->kind == GPU_SHAPE_CONE) flux *= 2 * pi * (1 - -(double)s->spot_offset / (double)s->spot_scale);
    if (s->kind == GPU_SHAPE_WEDGE) flux *= 4 * asin(sin(atan((double)s->size.x)) * sin(atan((double)s->size.y)));
    double radius = (double)b->bounds[row].radius, away = (double)vec3_distance(b->bounds[row].center, b->view.eye);
    double part = b->view.orthographic > 0.5f ? radius : away > radius ? radius / away : 1;
    return flux * part * part;
}

static uint32_t bias_under(uint32_t pressure, uint32_t offset) {
    if (pressure > 15 && offset < pressure - 15) return SHADOW_TRACED;
    return pressure <= offset ? 0 : MIN(pressure - offset, 7);
}

/* Whether the pages fit under a pressure, with the rows of importance 2^cut and more under the pressure before; fills in their biases. */
static bool fits(const struct bench *b, uint32_t pressure, double cut, double least, const bool *wants, uint32_t (*counts)[8][CLASSES],
                 uint32_t *biases) {
    uint32_t totals[CLASSES] = {0};
    for (uint32_t row = 0; row < b->row_count; row++) {
        const double octave = floor(log2(importance_of(b, row))), steps = floor((octave - least) / 2);
        const uint32_t own = octave >= cut && pressure > 0 ? pressure - 1 : pressure;
        biases[row] = bias_under(own, (uint32_t)fmin(fmax(steps, 0), 8));
        for (uint32_t c = 0; c < CLASSES && wants[row] && biases[row] != SHADOW_TRACED; c++) totals[c] += counts[row][biases[row]][c];
    }
    return cells_for(totals) <= b->side * b->side;
}

/* The biases of all rows; fills rows of `wants`. */
static void choose(const struct bench *b, uint32_t *biases, bool *wants, uint32_t *cells_wanted) {
    double least = INFINITY;
    uint32_t(*counts)[8][CLASSES] = zeroed(b->row_count, sizeof *counts);
    bool *there = zeroed(ROW_BITS, 1);
    for (uint32_t row = 0; row < b->row_count; row++) {
        for (uint32_t bias = 0; bias < 8; bias++) {
            memset(there, 0, ROW_BITS);
            for (uint32_t bit = 0, level; bit < ROW_BITS; bit++) {
                uint32_t to = bit_of(b->wanted, row, bit) ? coarser_bit(bit, bias, &level) : ROW_BITS;
                if (to == ROW_BITS || there[to]) continue;
                there[to] = wants[row] = true;
                counts[row][bias][class_of_level(level)]++;
            }
            if (!wants[row]) break;
        }
        if (wants[row]) least = fmin(least, floor(log2(importance_of(b, row))));
    }
    uint32_t whole[CLASSES] = {0};
    for (uint32_t row = 0; row < b->row_count; row++)
        for (uint32_t c = 0; c < CLASSES; c++) whole[c] += counts[row][0][c];
    *cells_wanted = cells_for(whole);
    /* The least pressure under which all fit; then the least importance from which on lights may stay under the pressure before. */
    uint32_t pressure = 0;
    while (pressure < PRESSURES && !fits(b, pressure, INFINITY, least, wants, counts, biases)) pressure++;
    for (int cut = -140; cut < 140 && pressure > 0; cut++)
        if (fits(b, pressure, cut, least, wants, counts, biases)) break;
    free(there);
    free(counts);
}

/* Whether maps of both show the same. */
static bool same_maps(const struct gpu_shape *a, const struct gpu_shape *b) {
    bool same = a->kind == b->kind && memcmp(&a->position, &b->position, sizeof a->position) == 0 && a->range == b->range;
    if (a->kind != GPU_SHAPE_BOX) return same;
    return same && memcmp(&a->direction, &b->direction, sizeof a->direction) == 0 &&
           memcmp(&a->side, &b->side, sizeof a->side) == 0 && memcmp(&a->size, &b->size, sizeof a->size) == 0;
}

/* What is where in the atlas: by unit the page + 1, by cell the class + 1. */
struct atlas {
    uint32_t side, *units, *cells;
};

static struct atlas atlas_make(uint32_t side) {
    return (struct atlas){side, zeroed(side * side * 64, 4), zeroed(side * side, 4)};
}

static void atlas_free(struct atlas *atlas) {
    free(atlas->units);
    free(atlas->cells);
}

/* Fails unless the place is in the atlas, aligned, free, and in a cell of pages of its size. */
static void atlas_put(struct atlas *atlas, uint32_t place, uint32_t class, uint32_t page) {
    const uint32_t size = 8u >> class, x = place & 0xffff, y = place >> 16;
    assert_true(x % size == 0 && y % size == 0 && x + size <= atlas->side * 8 && y + size <= atlas->side * 8);
    uint32_t *cell = &atlas->cells[y / 8 * atlas->side + x / 8];
    assert_true(*cell == 0 || *cell == class + 1);
    *cell = class + 1;
    for (uint32_t i = 0; i < size * size; i++) {
        uint32_t *unit = &atlas->units[(y + i / size) * atlas->side * 8 + x + i % size];
        if (*unit) fail_msg("pages %u and %u overlap", *unit - 1, page);
        *unit = page + 1;
    }
}

static uint32_t atlas_used(const struct atlas *atlas) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < atlas->side * atlas->side; i++) count += atlas->cells[i] != 0;
    return count;
}

/* Cells that pages of a class take beside those that hold it already. */
static uint32_t cells_beside(const struct atlas *atlas, const uint32_t fresh[CLASSES], const uint32_t stays[CLASSES]) {
    uint32_t rest[CLASSES], cells[CLASSES] = {0};
    for (uint32_t i = 0; i < atlas->side * atlas->side; i++)
        if (atlas->cells[i]) cells[atlas->cells[i] - 1]++;
    for (uint32_t c = 0; c < CLASSES; c++) {
        uint32_t room = (cells[c] << 2 * c) - stays[c];
        rest[c] = fresh[c] > room ? fresh[c] - room : 0;
    }
    return cells_for(rest);
}

/* Adds idle pages to those that are wanted now (1), as 2: in cells with wanted pages, and in others by age, as many ages as there is room for. */
static void keep_idle(struct bench *b, uint8_t *now) {
    struct page {
        uint32_t at, class, cell;
        bool good;
    } *pages = zeroed(b->side * b->side * 64, sizeof *pages);
    uint32_t count = 0, idle = 0, kept = 0, level, fresh[CLASSES] = {0}, *ages = zeroed(b->side * b->side, 4);
    for (uint32_t i = 0; i < b->side * b->side; i++) ages[i] = OLDEST + 1;
    for (uint32_t at = 0; at < b->row_limit * ROW_BITS; at++) {
        const bool was = b->known && b->was[at];
        if (!was && !now[at]) continue;
        const uint32_t row = at / ROW_BITS;
        coarser_bit(at % ROW_BITS, 0, &level);
        if (!was) {
            fresh[class_of_level(level)]++;
            continue;
        }
        struct page page = {.at = at, .class = class_of_level(level)};
        page.cell = (b->places[at] >> 16) / 8 * b->side + (b->places[at] & 0xffff) / 8;
        page.good = now[at] || (row < b->row_count && !b->lost[at] && same_maps(&b->shapes[row], &b->lights[row].shape));
        b->ages[at] = now[at] ? 0 : (uint8_t)MIN(b->ages[at] + 1, OLDEST);
        if (page.good) ages[page.cell] = MIN(ages[page.cell], b->ages[at]);
        idle += !now[at] && page.good;
        pages[count++] = page;
    }
    for (int oldest = OLDEST; oldest >= 0; oldest--) {
        struct atlas atlas = atlas_make(b->side);
        uint32_t stays[CLASSES] = {0};
        for (uint32_t i = 0; i < count; i++) {
            const struct page *page = &pages[i];
            if (!page->good || ages[page->cell] > (uint32_t)oldest) continue;
            atlas_put(&atlas, b->places[page->at], page->class, page->at);
            stays[page->class]++;
        }
        const bool fits = atlas_used(&atlas) + cells_beside(&atlas, fresh, stays) <= b->side * b->side;
        atlas_free(&atlas);
        for (uint32_t i = 0; fits && i < count; i++) {
            const struct page *page = &pages[i];
            if (!page->good || ages[page->cell] > (uint32_t)oldest || now[page->at]) continue;
            now[page->at] = 2;
            kept++;
        }
        if (fits) break;
    }
    b->totals.keeps_all += idle > 0 && kept == idle;
    b->totals.keeps_some += kept > 0 && kept < idle;
    b->totals.keeps_none += idle > 0 && kept == 0;
    free(pages);
    free(ages);
}

/* Checks the answer, and makes it the last frame. */
static void check(struct bench *b, const struct answer *a) {
    uint32_t *biases = zeroed(b->row_count, 4);
    bool *wants = zeroed(b->row_count, 1);
    uint8_t *now = zeroed(b->row_limit * ROW_BITS, 1); /* 1: wanted, 2: idle */
    struct gpu_shadow_counts counts = {0};
    choose(b, biases, wants, &counts.cells_wanted);

    /* Which pages. */
    for (uint32_t row = 0; row < b->row_count; row++) {
        bool coarser = false;
        if (a->biases[row] != biases[row]) fail_msg("row %u: bias %u, should be %u", row, a->biases[row], biases[row]);
        for (uint32_t bit = 0, level, bias = biases[row]; bit < ROW_BITS && wants[row]; bit++) {
            if (!bit_of(b->wanted, row, bit) || coarser_bit(bit, 0, &level) == ROW_BITS) continue;
            counts.wanted++;
            if (bias == SHADOW_TRACED) continue;
            uint32_t to = coarser_bit(bit, bias, &level);
            now[row * ROW_BITS + to] = 1;
            coarser = coarser || to != bit;
        }
        counts.traced += wants[row] && biases[row] == SHADOW_TRACED;
        counts.coarsened += coarser;
    }
    keep_idle(b, now);
    for (uint32_t row = 0; row < b->row_count; row++)
        for (uint32_t bit = 0; bit < ROW_BITS; bit++) {
            assert_int_equal(bit_of(a->held, row, bit), now[row * ROW_BITS + bit] != 0);
            if (!now[row * ROW_BITS + bit]) continue;
            assert_true(counts.pages < a->page_limit);
            const uint32_t word = row * SHADOW_ROW_WORDS + bit / 32, below = a->held[word] & ((1u << bit % 32) - 1);
            assert_int_equal(a->before[word] + (uint32_t)__builtin_popcount(below), counts.pages);
            assert_int_equal(a->pages[counts.pages].row, row);
            assert_int_equal(a->pages[counts.pages].bit, bit);
            counts.pages++;
        }

    /* Where they are. */
    struct atlas last = atlas_make(b->side), atlas = atlas_make(b->side);
    uint32_t fresh[CLASSES] = {0}, stays[CLASSES] = {0}, level;
    for (uint32_t row = 0; row < b->row_limit; row++)
        for (uint32_t bit = 0; bit < ROW_BITS; bit++) {
            const uint32_t at = row * ROW_BITS + bit;
            const bool was = b->known && b->was[at];
            if (was && !now[at]) counts.evicted++;
            if (!now[at]) continue;
            coarser_bit(bit, 0, &level);
            (was ? stays : fresh)[class_of_level(level)]++;
            if (was) atlas_put(&last, b->places[at], class_of_level(level), at);
        }
    const uint32_t beside = cells_beside(&last, fresh, stays);
    const bool anew = atlas_used(&last) + beside > b->side * b->side;
    for (uint32_t c = 0; c < CLASSES; c++) stays[c] += fresh[c];
    counts.cells = anew ? cells_for(stays) : atlas_used(&last) + beside;
    for (uint32_t i = 0; i < counts.pages; i++) {
        const struct gpu_shadow_page *page = &a->pages[i];
        const uint32_t at = page->row * ROW_BITS + page->bit;
        const bool was = b->known && b->was[at];
        coarser_bit(page->bit, 0, &level);
        atlas_put(&atlas, page->place, class_of_level(level), i);
        if (was && !anew && page->place != b->places[at]) fail_msg("page %u has moved", i);
        const bool draw = !was || anew || !same_maps(&b->shapes[page->row], &b->lights[page->row].shape) || b->lost[at];
        const uint32_t flags = now[at] == 2 ? SHADOW_PAGE_IDLE | (OLDEST + 1u - b->ages[at]) << 8
                               : draw       ? SHADOW_PAGE_DRAW
                                            : 0;
        b->since[at] = draw ? 0 : b->since[at] + 1;
        if (page->flags != (flags | b->since[at] << SHADOW_AGE_SHIFT)) fail_msg("page %u: flags %#x, should be %#x, age %u", i, page->flags, flags, b->since[at]);
        counts.drawn += draw;
        b->places[at] = page->place;
        if (now[at] == 1) b->ages[at] = 0;
    }
    assert_int_equal(atlas_used(&atlas), counts.cells);
    const uint32_t got[] = {a->counts.wanted,    a->counts.pages,  a->counts.drawn, a->counts.evicted,
                            a->counts.coarsened, a->counts.traced, a->counts.cells, a->counts.pairs, a->counts.cells_wanted, a->counts.oblong},
                   should[] = {counts.wanted,    counts.pages,  counts.drawn, counts.evicted,
                               counts.coarsened, counts.traced, counts.cells, 0, counts.cells_wanted, 0};
    for (uint32_t i = 0; i < COUNT_OF(got); i++)
        if (got[i] != should[i]) fail_msg("count %u is %u, should be %u", i, got[i], should[i]);

    b->totals.laid_anew += anew;
    b->totals.with_traced += counts.traced > 0;
    b->totals.with_coarsened += counts.coarsened > 0;
    b->totals.evicted += counts.evicted;
    b->known = true;
    for (uint32_t at = 0; at < b->row_limit * ROW_BITS; at++) b->was[at] = now[at] != 0;
    memset(b->lost, 0, b->row_limit * ROW_BITS);
    for (uint32_t row = 0; row < b->row_count; row++) b->shapes[row] = b->lights[row].shape;
    atlas_free(&last);
    atlas_free(&atlas);
    free(biases);
    free(wants);
    free(now);
}

/* What is done with pages after they were chosen: those that should be are drawn, but for some. Things move before these, if they are there already. */
static void draw(struct bench *b, struct answer *a) {
    for (uint32_t i = 0; i < a->counts.pages; i++) {
        struct gpu_shadow_page *page = &a->pages[i];
        bool *lost = &b->lost[page->row * ROW_BITS + page->bit];
        *lost = page->row == b->waits || (b->chance && random_bits(b->chance) % 64 == 0);
        page->flags = *lost ? page->flags | SHADOW_PAGE_DRAW : page->flags & ~SHADOW_PAGE_DRAW;
    }
    if (a->counts.pages == 0) return;
    assert_int_equal(
        gpu_upload_buffer(harness_device(), &b->state.pages[b->state.last.turn], 0, a->pages, a->counts.pages * sizeof *a->pages),
        FNL_OK);
    assert_int_equal(gpu_upload_flush(harness_device()), FNL_OK);
}

/* A frame that is as it should be; gives its numbers. */
static struct gpu_shadow_counts frame(struct bench *b) {
    struct answer a = run_frame(b);
    check(b, &a);
    draw(b, &a);
    const struct gpu_shadow_counts counts = a.counts;
    answer_free(&a);
    return counts;
}

/* Frames that leave what a settled one has made as it is, without a pass. */
static void stand_still(struct bench *b, uint32_t frames) {
    gpu_device *device = harness_device();
    struct answer last = run_frame(b);
    check(b, &last);
    draw(b, &last);
    assert_int_equal(last.counts.drawn + last.counts.evicted, 0);
    for (uint32_t i = 0; i < frames; i++) {
        struct list_reads reads;
        graph_begin(b->graph);
        assert_int_equal(gpu_frame_begin(device), FNL_OK);
        struct shadow_turn next;
        const struct shadow_pages made = shadow_pages_again(b->graph, &b->state, &next);
        list_reads_add(b->graph, (graph_buffer[]){made.held, made.before, made.pages, made.biases, made.counts}, 5, &reads);
        assert_int_equal(graph_compile(b->graph), FNL_OK);
        static char plan[1 << 16];
        assert_true(graph_print(b->graph, plan, sizeof plan) < sizeof plan);
        assert_null(strstr(plan, "shadow stay"));
        assert_int_equal(graph_execute_frame(b->graph, &(struct graph_execute_params){.poison = true}), FNL_OK);
        assert_int_equal(gpu_wait_idle(device), FNL_OK);
        b->state.last = next;
        assert_true(made.row_count == b->row_count && made.page_limit == last.page_limit);
        const size_t words = b->row_count * SHADOW_ROW_WORDS * 4ull;
        assert_memory_equal(reads.buffers[0].mapped, last.held, words);
        assert_memory_equal(reads.buffers[1].mapped, last.before, words);
        assert_memory_equal(reads.buffers[2].mapped, last.pages, last.counts.pages * sizeof *last.pages);
        assert_memory_equal(reads.buffers[3].mapped, last.biases, b->row_count * 4ull);
        assert_memory_equal(reads.buffers[4].mapped, &last.counts, sizeof last.counts);
        list_reads_free(&reads);
    }
    for (uint32_t at = 0; at < b->row_limit * ROW_BITS; at++) {
        if (!b->was[at]) continue;
        b->since[at] += frames;
        if (b->ages[at] > 0) b->ages[at] = (uint8_t)MIN(b->ages[at] + frames, OLDEST);
    }
    answer_free(&last);
}

/* ---- lights and requests ---- */

/* A light of any kind. Its importance is far enough from the powers of two that rounding does not tell. */
static void set_light(struct bench *b, uint32_t row, struct random_state *random) {
    struct gpu_light *l = &b->lights[row];
    const uint32_t kinds[] = {GPU_SHAPE_SPHERE, GPU_SHAPE_CONE, GPU_SHAPE_WEDGE, GPU_SHAPE_BOX};
    *l =
        (struct gpu_light){.color = {random_range(random, 0, 1), random_range(random, 0.1f, 1), random_range(random, 0, 1)}};
    l->shape = (struct gpu_shape){.kind = kinds[random_bits(random) % COUNT_OF(kinds)],
                                  .range = random_range(random, 0.5f, 8),
                                  .direction = {0, 0, -1},
                                  .side = {1, 0, 0},
                                  .size = {random_range(random, 0.2f, 3), random_range(random, 0.2f, 3), 1},
                                  .spot_scale = random_range(random, 1.2f, 5)};
    l->shape.spot_offset = -l->shape.spot_scale * random_range(random, 0.1f, 0.9f);
    l->shape.position =
        vec3_make(random_range(random, -20, 20), random_range(random, -20, 20), random_range(random, -20, 20));
    l->color = vec3_scale(l->color, exp2f(random_range(random, -8, 12)));
    b->bounds[row] = (struct gpu_entity_bounds){.center = vec3_add(l->shape.position, vec3_make(0.1f, 0, 0)),
                                                .radius = l->shape.range * 0.7f,
                                                .shape = GPU_NO_SHAPE};
    for (double octaves; octaves = log2(importance_of(b, row)), fabs(octaves - round(octaves)) < 1e-3;)
        l->color = vec3_scale(l->color, 1.01f);
}

static void want(struct bench *b, uint32_t row, uint32_t bit) {
    b->wanted[row * SHADOW_ROW_WORDS + bit / 32] |= 1u << bit % 32;
}

static void want_nothing(struct bench *b, uint32_t row) {
    memset(&b->wanted[row * SHADOW_ROW_WORDS], 0, SHADOW_ROW_WORDS * 4);
}

/* Whatever may be, bits that are of no page too. */
static void want_anything(struct bench *b, uint32_t row, struct random_state *random) {
    for (uint32_t i = 0; i < SHADOW_ROW_WORDS; i++) b->wanted[row * SHADOW_ROW_WORDS + i] = (uint32_t)random_bits(random);
}

static void want_less(struct bench *b, uint32_t row, struct random_state *random) {
    for (uint32_t i = 0; i < SHADOW_ROW_WORDS; i++)
        b->wanted[row * SHADOW_ROW_WORDS + i] &= (uint32_t)(random_bits(random) & random_bits(random));
}

/* As pixels do: patches of neighbours at a level or two, on some faces. */
static void want_something(struct bench *b, uint32_t row, struct random_state *random, uint32_t least_level) {
    want_nothing(b, row);
    for (uint32_t face = 0; face < SHADOW_FACES; face++) {
        if (random_bits(random) % 2) continue;
        for (uint32_t patch = 0; patch < 2; patch++) {
            const uint32_t level = least_level + (uint32_t)random_bits(random) % (SHADOW_LEVELS - least_level),
                           side = level_sides[level], x = (uint32_t)random_bits(random) % side,
                           y = (uint32_t)random_bits(random) % side;
            for (uint32_t i = 0; i < 9; i++)
                if (x + i % 3 < side && y + i / 3 < side) want(b, row, page_bit(face, level, x + i % 3, y + i / 3));
        }
    }
}

/* ---- tests ---- */

struct play {
    uint32_t rows, side, frames, least_level;
};

/* Lights that come, go and move, and pixels that look elsewhere. `answers`: one for each frame, or NULL. */
static void play(const struct play *p, uint32_t seed, struct answer *answers, struct totals *totals) {
    struct random_state random = {seed};
    struct bench b = bench_open(p->rows, p->side);
    b.chance = &random;
    for (uint32_t i = 0; i < p->frames; i++) {
        b.row_count = i % 3 == 1 ? DIVIDE_UP(p->rows, 2) : p->rows;
        for (uint32_t row = 0; row < p->rows; row++) {
            const uint32_t chance = (uint32_t)random_bits(&random) % 8;
            if (i == 0 || chance == 0) set_light(&b, row, &random);
            if (i == 0 || chance == 1 || i % 5 == 4) want_something(&b, row, &random, p->least_level);
            if (chance == 2) want_nothing(&b, row);
            if (i % 5 == 3) want_less(&b, row, &random);
            if (chance == 3 && random_bits(&random) % 8 == 0) want_anything(&b, row, &random);
        }
        if (i % 4 == 3) b.view.eye = vec3_make(random_range(&random, -9, 9), 0, 0);
        b.view.orthographic = i == 6;
        for (uint32_t row = 0; row < p->rows; row++) { /* seen from elsewhere, see set_light */
            double octaves = log2(importance_of(&b, row));
            if (fabs(octaves - round(octaves)) < 1e-3) b.lights[row].color = vec3_scale(b.lights[row].color, 1.01f);
        }
        struct answer a = run_frame(&b);
        check(&b, &a);
        draw(&b, &a);
        if (answers)
            answers[i] = a;
        else
            answer_free(&a);
    }
    for (uint32_t i = 0; i < sizeof *totals / 4; i++) ((uint32_t *)totals)[i] += ((const uint32_t *)&b.totals)[i];
    bench_close(&b);
}

static void test_random_frames(void **state) {
    UNUSED(state);
    static const struct play plays[] = {{1, 1, 8, 3},   {1, 4, 8, 0},    {5, 1, 10, 5},   {40, 4, 14, 1},
                                        {40, 6, 20, 4}, {300, 8, 10, 2}, {300, 3, 10, 0}, {130, 16, 6, 0}};
    struct totals sum = {0};
    for (uint32_t i = 0; i < COUNT_OF(plays); i++) play(&plays[i], 7 + i, NULL, &sum);
    print_message("laid anew in %u frames; %u with traced lights, %u with coarser pages; all idle pages stay in %u, some in "
                  "%u, none in %u\n",
                  sum.laid_anew, sum.with_traced, sum.with_coarsened, sum.keeps_all, sum.keeps_some, sum.keeps_none);
    assert_true(sum.laid_anew >= 3 && sum.with_traced >= 3 && sum.with_coarsened >= 10 && sum.evicted >= 100);
    assert_true(sum.keeps_all >= 3 && sum.keeps_some >= 3 && sum.keeps_none >= 3);
}

static void test_same_bytes(void **state) {
    UNUSED(state);
    enum { FRAMES = 8 };
    struct answer runs[2][FRAMES];
    struct totals sum = {0};
    for (int i = 0; i < 2; i++) play(&(struct play){200, 8, FRAMES, 2}, 99, runs[i], &sum);
    for (int i = 0; i < FRAMES; i++) {
        struct answer *a = &runs[0][i], *b = &runs[1][i];
        const size_t words = a->row_count * SHADOW_ROW_WORDS * 4ull;
        assert_memory_equal(a->held, b->held, words);
        for (size_t k = 0; k < words / 4; k++) assert_true(a->held[k] == 0 || a->before[k] == b->before[k]);
        assert_memory_equal(a->biases, b->biases, a->row_count * 4ull);
        assert_memory_equal(a->pages, b->pages, a->counts.pages * sizeof *a->pages);
        assert_memory_equal(&a->counts, &b->counts, sizeof a->counts);
        answer_free(a);
        answer_free(b);
    }
}

static void test_still_and_moved(void **state) {
    UNUSED(state);
    struct random_state random = {5};
    struct bench b = bench_open(20, 24);
    uint32_t own = 0;
    for (uint32_t row = 0; row < 20; row++) {
        set_light(&b, row, &random);
        want_something(&b, row, &random, 2);
    }
    b.lights[3].shape.kind = GPU_SHAPE_CONE;
    b.lights[4].shape.kind = GPU_SHAPE_BOX;
    b.wanted[SHADOW_FACE_WORDS - 1] |= 0xff000000u; /* of no page */
    want(&b, 3, page_bit(1, 2, 0, 1));
    want(&b, 4, page_bit(0, 3, 1, 1));
    struct gpu_shadow_counts first = frame(&b);
    assert_true(b.clears && first.pages > 100 && first.drawn == first.pages && first.coarsened == 0);
    for (int i = 0; i < 3; i++) {
        assert_int_equal(frame(&b).drawn, 0);
        assert_false(b.clears);
    }
    b.lights[3].shape.direction = vec3_make(0, -1, 0); /* the faces of its cube stay where they are */
    b.lights[3].shape.side = vec3_make(0, 0, 1);
    b.lights[3].color = vec3_scale(b.lights[3].color, 0.5f);
    assert_int_equal(frame(&b).drawn, 0);
    b.lights[4].shape.direction = vec3_make(0, -1, 0);
    assert_true(frame(&b).drawn > 0);
    b.lights[3].shape.position.y += 0.25f;
    struct gpu_shadow_counts moved = frame(&b);
    for (uint32_t bit = 0; bit < ROW_BITS; bit++) own += b.was[3 * ROW_BITS + bit];
    assert_true(own > 0 && moved.drawn == own && moved.evicted == 0);
    assert_int_equal(frame(&b).drawn, 0);
    b.lights[3].shape.range *= 1.5f; /* more may throw shadows */
    b.waits = 3;
    assert_int_equal(frame(&b).drawn, own);
    b.waits = NOBODY;
    assert_int_equal(frame(&b).drawn, own); /* they have not been drawn yet */
    assert_int_equal(frame(&b).drawn, 0);
    shadow_state_forget(&b.state);
    b.known = false;
    struct gpu_shadow_counts again = frame(&b);
    assert_true(again.drawn == again.pages && again.evicted == 0 && !b.clears);
    /* What outgrows its memory begins anew, and so does another atlas. */
    b.known = false;
    b.side = 16;
    assert_true(frame(&b).drawn > 0 && b.clears);
    bench_close(&b);
}

/* Pages that stand still grow older all the same, those that nobody looks up too: what goes first does not depend on it. */
static void test_stands_still(void **state) {
    UNUSED(state);
    struct random_state random = {15};
    struct bench b = bench_open(20, 14);
    for (uint32_t row = 0; row < 20; row++) {
        set_light(&b, row, &random);
        want_something(&b, row, &random, 3);
    }
    assert_int_equal(frame(&b).coarsened, 0);
    static const uint32_t still[] = {3, 1, 40, 7};
    uint32_t idle = 0;
    for (uint32_t i = 0; i < COUNT_OF(still); i++) {
        for (uint32_t row = i; row < 20; row += 7) want_nothing(&b, row);
        const struct gpu_shadow_counts counts = frame(&b);
        assert_true(counts.drawn == 0 && counts.evicted == 0);
        stand_still(&b, still[i]);
        frame(&b);
    }
    for (uint32_t at = 0; at < 20 * ROW_BITS; at++) idle += b.was[at] && b.ages[at] > 0;
    assert_true(idle > 10);
    for (uint32_t row = 0; row < 20; row++) want_something(&b, row, &random, 1); /* idle ones must go */
    assert_true(frame(&b).evicted > 0);
    bench_close(&b);
}

/* A small page is left in each of four cells, so that no cell is free for large ones; together they would take one. */
static void test_scattered(void **state) {
    UNUSED(state);
    struct random_state random = {3};
    struct bench b = bench_open(50, 2);
    for (uint32_t row = 0; row < 50; row++) set_light(&b, row, &random);
    for (uint32_t i = 0; i < 256; i++) want(&b, i / SHADOW_FACES, page_bit(i % SHADOW_FACES, 7, 0, 0));
    struct answer full = run_frame(&b);
    check(&b, &full);
    assert_true(full.counts.pages == 256 && full.counts.cells == 4);
    memset(b.wanted, 0, 50 * SHADOW_ROW_WORDS * 4);
    uint32_t cells = 0;
    for (uint32_t i = 0; i < 256; i++) {
        const struct gpu_shadow_page *page = &full.pages[i];
        const uint32_t cell = 1u << ((page->place & 0xffff) / 8 + (page->place >> 16) / 8 * 2);
        if (!(cells & cell)) want(&b, page->row, page->bit);
        cells |= cell;
    }
    draw(&b, &full);
    answer_free(&full);
    struct gpu_shadow_counts few = frame(&b);
    assert_true(few.pages == 256 && few.drawn == 0 && few.cells == 4);
    want(&b, 45, page_bit(2, 7, 0, 0)); /* in place of an idle one */
    struct gpu_shadow_counts five = frame(&b);
    assert_true(five.pages == 5 && five.drawn == 1 && five.evicted == 252 && b.totals.laid_anew == 0);
    for (uint32_t i = 0; i < 3; i++) want(&b, 49, page_bit(i, 2, 3, i));
    struct gpu_shadow_counts anew = frame(&b);
    assert_true(anew.pages == 8 && anew.drawn == 8 && anew.cells == 4 && anew.coarsened == 0 && b.totals.laid_anew == 1);
    assert_int_equal(frame(&b).drawn, 0);
    bench_close(&b);
}

/* A page for each frame in an atlas of four: the one that nobody has looked up for longest goes. */
static void test_idle(void **state) {
    UNUSED(state);
    struct random_state random = {8};
    struct bench b = bench_open(6, 2);
    static const struct {
        uint32_t row, drawn, evicted, pages;
    } steps[] = {{0, 1, 0, 1}, {1, 1, 0, 2}, {2, 1, 0, 3}, {3, 1, 0, 4}, {1, 0, 0, 4}, {4, 1, 1, 4},
                 {1, 0, 0, 4}, {3, 0, 0, 4}, {0, 1, 1, 4}, {2, 1, 1, 4}, {4, 1, 1, 4}, {3, 0, 0, 4}};
    for (uint32_t row = 0; row < 6; row++) set_light(&b, row, &random);
    for (uint32_t i = 0; i < COUNT_OF(steps); i++) {
        memset(b.wanted, 0, 6 * SHADOW_ROW_WORDS * 4);
        want(&b, steps[i].row, page_bit(0, 4, 0, 0));
        b.waits = i + 1 < COUNT_OF(steps) ? NOBODY : 0;
        struct gpu_shadow_counts counts = frame(&b);
        if (counts.drawn != steps[i].drawn || counts.evicted != steps[i].evicted || counts.pages != steps[i].pages)
            fail_msg("step %u: %u drawn, %u evicted, %u pages", i, counts.drawn, counts.evicted, counts.pages);
    }
    /* There are those of 0, 2 and 4, and that of 3 is wanted. Something has moved before that of 0; the light of 2 moves. */
    b.waits = NOBODY;
    b.lights[2].shape.position.x += 1;
    want(&b, 0, page_bit(0, 4, 0, 0));
    struct gpu_shadow_counts counts = frame(&b);
    assert_true(counts.drawn == 1 && counts.evicted == 1 && counts.pages == 3);
    memset(b.wanted, 0, 6 * SHADOW_ROW_WORDS * 4);
    b.waits = 3;
    counts = frame(&b);
    assert_true(counts.drawn == 0 && counts.evicted == 0 && counts.pages == 3);
    counts = frame(&b);
    assert_true(counts.drawn == 0 && counts.evicted == 1 && counts.pages == 2);
    for (uint32_t i = 0; i < 40; i++) frame(&b); /* the oldest grow no older */
    assert_int_equal(frame(&b).pages, 2);
    bench_close(&b);
}

static void test_limits(void **state) {
    UNUSED(state);
    struct random_state random = {11};
    /* Nothing wanted. */
    struct bench b = bench_open(70, 2);
    for (uint32_t row = 0; row < 70; row++) set_light(&b, row, &random);
    assert_int_equal(frame(&b).pages, 0);
    /* Everything that there is. */
    memset(b.wanted, 0xff, SHADOW_ROW_WORDS * 4);
    assert_true(frame(&b).coarsened == 1);
    memset(b.wanted, 0xff, 70 * SHADOW_ROW_WORDS * 4);
    struct gpu_shadow_counts crowded = frame(&b);
    assert_true(crowded.traced > 0 && crowded.pages > 0 && crowded.wanted == 70 * SHADOW_FACES * 344);
    memset(b.wanted, 0, 70 * SHADOW_ROW_WORDS * 4);
    struct gpu_shadow_counts idle = frame(&b);
    assert_true(idle.evicted == 0 && idle.pages == crowded.pages);
    want(&b, 0, page_bit(3, 0, 7, 7));
    assert_true(frame(&b).pages > 0);
    bench_close(&b);
    /* One cell holds 64 of the smallest pages: ten whole lights, and of an eleventh nothing. */
    b = bench_open(11, 1);
    for (uint32_t row = 0; row < 11; row++) {
        set_light(&b, row, &random);
        for (uint32_t face = 0; face < SHADOW_FACES; face++) want(&b, row, page_bit(face, 0, 5, 9));
    }
    for (uint32_t row = 0; row < 11; row++) { /* the last is by far the least important */
        const double octaves = (row < 10 ? 14 : -17) - floor(log2(importance_of(&b, row)));
        b.lights[row].color = vec3_scale(b.lights[row].color, (float)exp2(octaves));
    }
    b.row_count = 10;
    struct gpu_shadow_counts ten = frame(&b);
    assert_true(ten.pages == 60 && ten.cells == 1 && ten.traced == 0 && ten.coarsened == 10);
    b.row_count = 11;
    struct gpu_shadow_counts eleven = frame(&b);
    assert_true(eleven.traced == 1 && eleven.pages == 60 && eleven.drawn == 0);
    bench_close(&b);
    /* Many lights, all at the coarsest: enough room, and too little. */
    for (uint32_t side = 20; side >= 12; side -= 8) {
        b = bench_open(4096, side);
        for (uint32_t row = 0; row < 4096; row++) {
            set_light(&b, row, &random);
            for (uint32_t face = 0; face < SHADOW_FACES; face++) want(&b, row, page_bit(face, SHADOW_LEVELS - 1, 0, 0));
        }
        struct gpu_shadow_counts many = frame(&b);
        assert_true(side == 12 ? many.traced > 0 : many.traced == 0 && many.pages == 4096 * SHADOW_FACES);
        assert_int_equal(frame(&b).drawn, 0);
        bench_close(&b);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        {"pages, biases and places are those of the reference, frame after frame", test_random_frames, NULL, harness_check,
         NULL},
        {"two runs give the same bytes", test_same_bytes, NULL, harness_check, NULL},
        {"a still scene draws nothing, a light that has changed its own pages", test_still_and_moved, NULL, harness_check,
         NULL},
        {"pages that are left alone grow older", test_stands_still, NULL, harness_check, NULL},
        {"pages that lie scattered are laid anew where others need the room", test_scattered, NULL, harness_check, NULL},
        {"pages that nobody looks up stay while there is room", test_idle, NULL, harness_check, NULL},
        {"nothing wanted, one cell, and more lights than fit", test_limits, NULL, harness_check, NULL},
    };
    return cmocka_run_group_tests_name("shadow pages", tests, harness_begin, harness_end);
}
