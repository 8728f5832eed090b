/* SPDX-License-Identifier: MIT */
/* auto: the rules of choosing against made-up times. What its frames do is in chooser_frames_test.c. */
#include "render/chooser.h"
#include "render/shading.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <stdlib.h>

enum { LATENCY = 2, MOST_FRAMES = 60, FOREVER = 1 << 30 };
#define DRAWING 0.25 /* milliseconds of each frame that are not compared */

/* A device that takes a known time for each pair, told LATENCY frames later. */
struct machine {
    struct chooser *chooser;
    double lists[FNL_LISTS_COUNT], orders[FNL_SHADING_COUNT];
    double cpu[FNL_LISTS_COUNT]; /* what lists take of the processor's time */
    double drift; /* part by which everything gets slower in each frame */
    bool mute;    /* tells no times */
    struct random_state random;
    uint64_t frame;
    double times[4096];
    bool tried[FNL_LISTS_COUNT];
    /* Making the pipelines of a pair takes so many frames, one pair after the other; frames take ten times as long meanwhile. */
    uint64_t making[FNL_LISTS_COUNT], made[FNL_LISTS_COUNT]; /* made: the frame from which on they are there; 0: never asked */
    uint64_t ends[32], ticket_count, busy_frames;
    uint32_t late; /* frames that had to make their pipelines themselves */
};

static struct choice_case some_case(uint32_t lights) {
    return (struct choice_case){.asked = {FNL_SHADING_DEFERRED, FNL_LISTS_AUTO},
                                .scene = 7,
                                .light_count = lights,
                                .msaa = 1,
                                .pixel_count = 1280 * 720,
                                .forward = {0, 0, -1},
                                .scene_size = 10};
}

static struct machine machine_make(struct chooser *chooser) {
    struct machine m = {.chooser = chooser, .random = {3}};
    for (uint32_t i = 0; i < FNL_LISTS_COUNT; i++) m.lists[i] = 4 + i;
    for (uint32_t i = 0; i < FNL_SHADING_COUNT; i++) m.orders[i] = 10;
    return m;
}

static struct chooser_background background(const struct machine *m) {
    struct chooser_background b = {.asked = m->ticket_count};
    while (b.done < b.asked && m->ends[b.done] <= m->frame) b.done++;
    return b;
}

static void ask(struct machine *m) {
    struct choice choice;
    if (!chooser_asks(m->chooser, &choice)) return;
    uint64_t *made = &m->made[choice.lists], last = m->ticket_count ? m->ends[m->ticket_count - 1] : 0;
    if (*made == 0) {
        *made = m->making[choice.lists] ? MAX(last, m->frame) + m->making[choice.lists] : m->frame;
        if (m->making[choice.lists]) m->ends[m->ticket_count++] = *made;
    }
    chooser_asked(m->chooser, *made > m->frame ? m->ticket_count : 0);
}

static struct choice step(struct machine *m, const struct choice_case *at, bool pinned) {
    m->frame++;
    struct chooser_background b = background(m);
    struct choice choice = chooser_pick(m->chooser, at, !pinned, b);
    if (m->made[choice.lists] == 0 || m->made[choice.lists] > m->frame) {
        m->late += m->making[choice.lists] > 0;
        m->made[choice.lists] = m->frame;
    }
    if (!pinned) ask(m);
    b = background(m);
    m->busy_frames += b.done < b.asked;
    m->tried[choice.lists] = true;
    m->times[m->frame % 4096] = (m->orders[choice.shading] + m->lists[choice.lists]) * (1 + m->drift * (double)m->frame) *
                                (double)random_range(&m->random, 0.98f, 1.02f) * (b.done < b.asked ? 10 : 1);
    if (!pinned) chooser_note(m->chooser, m->frame, m->cpu[choice.lists]);
    for (uint64_t wanted; (wanted = chooser_wants(m->chooser)) && wanted + LATENCY <= m->frame;)
        chooser_feed(m->chooser, m->mute ? -1 : m->times[wanted % 4096], DRAWING);
    return choice;
}

/* Frames until it has decided; fails after MOST_FRAMES. */
static uint32_t settle(struct machine *m, const struct choice_case *at) {
    for (uint32_t i = 1; i <= MOST_FRAMES; i++) {
        step(m, at, false);
        if (m->chooser->state == CHOOSER_DECIDED) return i;
    }
    fail_msg("undecided after %d frames", MOST_FRAMES);
    return 0;
}

static void test_the_fastest_wins_whatever_it_is(void **state) {
    UNUSED(state);
    static const uint32_t counts[] = {10, 1000, 100000};
    static struct chooser c;
    for (uint32_t k = 0; k < COUNT_OF(counts); k++)
        for (uint32_t fastest = 0; fastest < FNL_LISTS_AUTO; fastest++)
            for (int drift = 0; drift < 2; drift++) {
                c = (struct chooser){0};
                struct machine m = machine_make(&c);
                struct choice_case at = some_case(counts[k]);
                m.lists[fastest] = 1;
                m.drift = drift ? 0.05 : 0; /* four times slower at the end: taking turns is fair */
                uint32_t frames = settle(&m, &at);
                if (!m.tried[fastest]) continue; /* not a candidate for this number of lights */
                assert_int_equal(c.choice.lists, fastest);
                assert_true(frames <= MOST_FRAMES && strstr(c.reason, "fastest of"));
                m.drift = 0;
                for (int i = 0; i < 100; i++) assert_int_equal(step(&m, &at, false).lists, fastest);
            }
}

static void test_brute_force_is_tried_with_few_lights_only(void **state) {
    UNUSED(state);
    static struct chooser c;
    for (int many = 0; many < 2; many++) {
        c = (struct chooser){0};
        struct machine m = machine_make(&c);
        struct choice_case at = some_case(many ? 65536 : 20);
        settle(&m, &at);
        assert_int_equal(m.tried[FNL_LISTS_ALL], !many);
        assert_true(m.tried[FNL_LISTS_CLUSTERED] && m.tried[FNL_LISTS_TILED]);
        if (many) assert_false(m.tried[FNL_LISTS_25D]); /* blocks of cells against each light: three of them are enough */
        assert_false(m.tried[FNL_LISTS_MULTIPASS] || m.tried[FNL_LISTS_MESH]);
    }
}

/* Without lights nothing is measured of lists: brute force, decided in the first frame; only paths still are. The first light is another case. */
static void test_no_lights_need_no_lists(void **state) {
    UNUSED(state);
    static struct chooser c;
    for (int close = 0; close < 2; close++) {
        c = (struct chooser){0};
        struct machine m = machine_make(&c);
        struct choice_case at = some_case(0);
        struct choice candidate;
        m.lists[FNL_LISTS_ALL] = 1000; /* whatever it would take */
        assert_int_equal(settle(&m, &at), 1);
        assert_false(chooser_asks(&c, &candidate));
        for (int i = 0; i < 300; i++) {
            at.forward = (vec3){0, 0, i % 2 ? 1 : -1};
            assert_int_equal(step(&m, &at, false).lists, FNL_LISTS_ALL);
            assert_int_equal(c.state, CHOOSER_DECIDED);
        }
        assert_int_equal(c.memory_count + c.trial_count, 0);
        assert_non_null(strstr(c.reason, "no lights"));
        at.light_count = 1;
        settle(&m, &at);
        assert_true(m.tried[FNL_LISTS_TILED] && c.choice.lists != FNL_LISTS_ALL);
        at.light_count = 0;
        assert_int_equal(step(&m, &at, false).lists, FNL_LISTS_ALL);
        at.asked.shading = FNL_SHADING_AUTO;
        at.close = close;
        m.orders[FNL_SHADING_FORWARD] = 3;
        m.lists[FNL_LISTS_ALL] = 0;
        memset(m.tried, 0, sizeof m.tried);
        settle(&m, &at);
        assert_int_equal(c.choice.shading, FNL_SHADING_FORWARD);
        for (uint32_t i = 0; i < FNL_LISTS_COUNT; i++) assert_int_equal(m.tried[i], i == FNL_LISTS_ALL);
    }
}

/* What a single picture takes. */
static void test_the_guess_goes_by_the_number_of_lights(void **state) {
    UNUSED(state);
    static const struct {
        uint32_t lights, msaa;
        fnl_shading shading;
        fnl_light_lists lists;
    } cases[] = {{0, 1, FNL_SHADING_FORWARD_PREPASS, FNL_LISTS_ALL},     {4, 1, FNL_SHADING_FORWARD_PREPASS, FNL_LISTS_ALL},
                 {8, 1, FNL_SHADING_FORWARD_PREPASS, FNL_LISTS_ALL},     {9, 1, FNL_SHADING_DEFERRED, FNL_LISTS_TILED},
                 {1000, 1, FNL_SHADING_DEFERRED, FNL_LISTS_TILED},       {0, 4, FNL_SHADING_FORWARD_PREPASS, FNL_LISTS_ALL},
                 {1000, 4, FNL_SHADING_FORWARD_PREPASS, FNL_LISTS_TILED}};
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct choice_case at = some_case(cases[i].lights);
        at.msaa = cases[i].msaa;
        at.asked.shading = FNL_SHADING_AUTO;
        const struct choice guess = chooser_guess(&at);
        assert_int_equal(guess.shading, cases[i].shading);
        assert_int_equal(guess.lists, cases[i].lists);
        at.close = true;
        assert_int_equal(chooser_guess(&at).shading, at.msaa > 1 ? FNL_SHADING_VISIBILITY : guess.shading);
        at.asked.shading = FNL_SHADING_FORWARD; /* what is asked for stays */
        assert_int_equal(chooser_guess(&at).shading, FNL_SHADING_FORWARD);
    }
}

/* Lists that the processor builds while the GPU does something else cost nothing; what takes longer than the GPU does is the frame's time. */
static void test_the_longer_of_both_times_counts(void **state) {
    UNUSED(state);
    static struct chooser c;
    for (int late = 0; late < 2; late++) {
        c = (struct chooser){0};
        struct machine m = machine_make(&c);
        struct choice_case at = some_case(1000);
        m.lists[FNL_LISTS_WORLD] = 1; /* with the path 11 ms; the others 14 or more */
        m.cpu[FNL_LISTS_WORLD] = late ? 40 : 10;
        m.lists[FNL_LISTS_ZBIN] = 2;
        settle(&m, &at);
        assert_int_equal(c.choice.lists, late ? FNL_LISTS_ZBIN : FNL_LISTS_WORLD);
        assert_true(fabs(c.milliseconds - ((late ? 12 : 11) - DRAWING)) < 0.3);
    }
}

/* Lists that are built once are tried while lights stand still, and given up when these move; both decisions are kept. */
static void test_lists_of_lights_that_stand_still(void **state) {
    UNUSED(state);
    static const uint32_t counts[] = {10, 1000, 100000};
    static struct chooser c;
    for (uint32_t k = 0; k < COUNT_OF(counts); k++) {
        c = (struct chooser){0};
        struct machine m = machine_make(&c);
        struct choice_case at = some_case(counts[k]);
        m.lists[FNL_LISTS_WORLD] = 1;
        settle(&m, &at);
        assert_int_equal(c.choice.lists, FNL_LISTS_WORLD);
        at.moves = true;
        memset(m.tried, 0, sizeof m.tried);
        settle(&m, &at);
        assert_false(m.tried[FNL_LISTS_WORLD]);
        const fnl_light_lists other = c.choice.lists;
        for (int i = 0; i < 6; i++) {
            at.moves = i % 2;
            assert_int_equal(step(&m, &at, false).lists, at.moves ? other : FNL_LISTS_WORLD);
            assert_int_equal(c.state, CHOOSER_DECIDED);
        }
    }
}

/* What others may know of the rules is what is measured, pair by pair. */
static void test_likely_pairs_are_those_that_are_tried(void **state) {
    UNUSED(state);
    static const uint32_t counts[] = {0, 64, 65, 16384, 16385};
    for (uint32_t n = 0; n < 2 * COUNT_OF(counts); n++)
        for (uint32_t shading = 0; shading < FNL_SHADING_AUTO; shading++) {
            struct chooser chooser = {0};
            struct machine m = machine_make(&chooser);
            struct choice_case at = some_case(counts[n / 2]);
            at.msaa = n % 2 ? 4 : 1;
            at.asked.shading = (fnl_shading)shading;
            if (!fnl_shading_supports(at.asked.shading, FNL_LISTS_AUTO, at.msaa)) { /* such frames are refused */
                assert_false(fnl_shading_likely(at.asked.shading, FNL_LISTS_TILED, at.light_count, at.msaa) & FNL_LIKELY_LISTS);
                continue;
            }
            settle(&m, &at);
            uint32_t tried = 0;
            for (uint32_t l = 0; l < FNL_LISTS_AUTO; l++) {
                uint32_t likely = fnl_shading_likely((fnl_shading)shading, (fnl_light_lists)l, at.light_count, at.msaa);
                assert_int_equal(m.tried[l], (likely & FNL_LIKELY_LISTS) != 0);
                assert_int_equal((likely & FNL_LIKELY_SHADING) != 0, shading < 3); /* as fnl_shading says */
                assert_int_equal((likely & FNL_LIKELY_CLOSE) != 0, shading == FNL_SHADING_VISIBILITY);
                tried += m.tried[l];
            }
            assert_true(tried >= (at.light_count ? 2u : 1u) && tried <= CHOOSER_CANDIDATES);
        }
    assert_int_equal(fnl_shading_likely(FNL_SHADING_AUTO, FNL_LISTS_TILED, 100, 1), 0);
    assert_int_equal(fnl_shading_likely(FNL_SHADING_COUNT, FNL_LISTS_TILED, 100, 1), 0);
    assert_int_equal(fnl_shading_likely(FNL_SHADING_DEFERRED, FNL_LISTS_AUTO, 100, 1), FNL_LIKELY_SHADING);
}

static void test_slow_candidates_get_fewer_turns(void **state) {
    UNUSED(state);
    static struct chooser c;
    struct machine m = machine_make(&c);
    struct choice_case at = some_case(1000);
    m.lists[FNL_LISTS_CLUSTERED] = 1000;
    uint32_t slow = 0;
    while (c.state != CHOOSER_DECIDED) slow += step(&m, &at, false).lists == FNL_LISTS_CLUSTERED;
    assert_true(slow >= 2 && slow < CHOOSER_ROUNDS);
}

static void test_order_and_lists_together(void **state) {
    UNUSED(state);
    static struct chooser c;
    c = (struct chooser){0};
    struct machine m = machine_make(&c);
    struct choice_case at = some_case(1000);
    at.asked.shading = FNL_SHADING_AUTO;
    m.orders[FNL_SHADING_FORWARD_PREPASS] = 3;
    m.lists[FNL_LISTS_CLUSTERED] = 0.5;
    settle(&m, &at);
    assert_int_equal(c.choice.shading, FNL_SHADING_FORWARD_PREPASS);
    assert_int_equal(c.choice.lists, FNL_LISTS_CLUSTERED);
    at.msaa = 4; /* deferred orders light edges elsewhere */
    m = machine_make(&c);
    m.orders[FNL_SHADING_DEFERRED] = 0;
    m.lists[FNL_LISTS_TILED] = 0;
    settle(&m, &at);
    assert_int_not_equal(c.choice.shading, FNL_SHADING_DEFERRED);
    assert_true(m.tried[FNL_LISTS_TILED]);
}

/* What was measured is told with its times: of paths and lists, while it goes on and when it is decided. */
static void test_candidates_are_told(void **state) {
    UNUSED(state);
    static struct chooser c, later;
    fnl_candidate rows[CHOOSER_ROWS];
    c = later = (struct chooser){0};
    assert_int_equal(chooser_list(&c, rows), 0);
    struct machine m = machine_make(&c);
    struct choice_case at = some_case(1000);
    at.asked.shading = FNL_SHADING_AUTO;
    m.orders[FNL_SHADING_FORWARD_PREPASS] = 3;
    m.lists[FNL_LISTS_CLUSTERED] = 0.5;
    m.lists[FNL_LISTS_FINE] = 100;
    step(&m, &at, false);
    uint32_t count = chooser_list(&c, rows), measured = 0, shadings = 0, chosen = 0;
    assert_true(count > 1);
    for (uint32_t i = 0; i < count; i++) assert_true(!rows[i].chosen && rows[i].milliseconds == 0 && rows[i].frames == 0);
    settle(&m, &at);
    count = chooser_list(&c, rows);
    for (uint32_t i = 0; i < count; i++) {
        const bool is_choice = rows[i].shading == FNL_SHADING_FORWARD_PREPASS && rows[i].lists == FNL_LISTS_CLUSTERED;
        for (uint32_t k = 0; k < i; k++) assert_false(rows[i].shading == rows[k].shading && rows[i].lists == rows[k].lists);
        assert_int_equal(rows[i].chosen, is_choice);
        assert_int_equal(rows[i].milliseconds > 0, rows[i].frames > 0);
        chosen += rows[i].chosen;
        measured += rows[i].frames > 0;
        shadings += i == 0 || rows[i].shading != rows[i - 1].shading;
        const double real = m.orders[rows[i].shading] + m.lists[rows[i].lists] - DRAWING;
        if (rows[i].frames) assert_true(fabs(rows[i].milliseconds / real - 1) < 0.05);
        assert_true(rows[i].frames <= CHOOSER_TIMES);
    }
    assert_int_equal(chosen, 1);
    assert_int_equal(measured, c.measured_count);
    assert_int_equal(shadings, 3); /* deferred and forward, then forward with prepass with all its lists */
    assert_int_equal(rows[count - 1].shading, FNL_SHADING_FORWARD_PREPASS);

    /* Remembered in another run: the choice alone. */
    char text[8192];
    assert_true(chooser_print(&c, text, sizeof text) < sizeof text);
    chooser_parse(&later, text, strlen(text));
    chooser_pick(&later, &at, true, (struct chooser_background){0});
    assert_int_equal(chooser_list(&later, rows), 1);
    assert_true(rows[0].chosen && rows[0].frames == 0 && fabs(rows[0].milliseconds - c.milliseconds) < 1e-3);
    assert_int_equal(rows[0].lists, FNL_LISTS_CLUSTERED);
    at.scene++; /* another scene: from the start again */
    chooser_pick(&later, &at, true, (struct chooser_background){0});
    assert_true(chooser_list(&later, rows) > 1 && !rows[0].chosen && rows[0].milliseconds == 0);
}

/* A path whose picture is only close is a candidate where that is allowed, and nowhere else, however fast it is. */
static void test_close_paths_where_they_are_allowed(void **state) {
    UNUSED(state);
    static struct chooser c;
    for (uint32_t msaa = 1; msaa <= 4; msaa *= 4) {
        c = (struct chooser){0};
        struct machine m = machine_make(&c);
        m.orders[FNL_SHADING_VISIBILITY] = 0.01;
        m.orders[FNL_SHADING_FORWARD] = 3;
        struct choice_case at = some_case(1000);
        at.asked.shading = FNL_SHADING_AUTO;
        at.msaa = msaa;
        for (uint32_t frame = 0; c.state != CHOOSER_DECIDED; frame++) {
            assert_true(frame < MOST_FRAMES);
            assert_int_not_equal(step(&m, &at, false).shading, FNL_SHADING_VISIBILITY);
        }
        assert_int_equal(c.choice.shading, FNL_SHADING_FORWARD);

        at.close = true;
        assert_int_equal(chooser_guess(&at).shading, msaa > 1 ? FNL_SHADING_VISIBILITY : FNL_SHADING_DEFERRED); /* before it is measured */
        settle(&m, &at);
        assert_int_equal(c.choice.shading, FNL_SHADING_VISIBILITY);
        assert_int_equal(step(&m, &at, true).shading, FNL_SHADING_VISIBILITY);

        at.close = false; /* from the next frame on, by what is remembered */
        assert_int_equal(step(&m, &at, true).shading, FNL_SHADING_FORWARD);
        assert_int_equal(c.state, CHOOSER_DECIDED);
        at.asked.shading = FNL_SHADING_DEFERRED; /* a path that was named stays */
        at.close = true;
        settle(&m, &at);
        assert_int_equal(c.choice.shading, FNL_SHADING_DEFERRED);
    }
}

static void test_decides_again_when_much_changes(void **state) {
    UNUSED(state);
    static struct chooser c;
    c = (struct chooser){0};
    struct machine m = machine_make(&c);
    struct choice_case at = some_case(1000), other;
    settle(&m, &at);
    other = at;
    other.light_count = 1300; /* little */
    step(&m, &other, false);
    assert_int_equal(c.state, CHOOSER_DECIDED);
    for (int change = 0; change < 4; change++) {
        other = at;
        if (change == 0) other.light_count = 9000;
        if (change == 1) other.pixel_count *= 4;
        if (change == 2) other.msaa = 2;
        if (change == 3) other.scene++;
        step(&m, &other, false);
        assert_int_equal(c.state, CHOOSER_MEASURING);
        settle(&m, &other);
        step(&m, &at, false); /* the way back is remembered */
        assert_int_equal(c.state, CHOOSER_DECIDED);
        assert_non_null(strstr(c.reason, "remembered"));
    }
    /* The view: not at once, or a spin would never settle. */
    other = at;
    other.forward = (vec3){0, 0, 1};
    step(&m, &other, false);
    assert_int_equal(c.state, CHOOSER_DECIDED);
    for (int i = 0; i < 260; i++) step(&m, &other, false);
    assert_true(c.at.forward.z > 0);
    settle(&m, &other);
    for (int i = 0; i < 260; i++) step(&m, &other, false);
    assert_int_equal(c.state, CHOOSER_DECIDED);
    /* It has become slow. */
    for (uint32_t i = 0; i < FNL_LISTS_COUNT; i++) m.lists[i] = 90;
    m.lists[FNL_LISTS_ZBIN] = 1;
    bool again = false;
    for (int i = 0; i < 60 && !again; i++) {
        step(&m, &other, false);
        again = c.state == CHOOSER_MEASURING;
    }
    assert_true(again);
}

static void test_pinned_measures_nothing(void **state) {
    UNUSED(state);
    static struct chooser c;
    c = (struct chooser){0};
    struct machine m = machine_make(&c);
    struct choice_case at = some_case(1000);
    struct choice guess = chooser_guess(&at);
    for (int i = 0; i < 20; i++) {
        struct choice choice = step(&m, &at, true);
        assert_int_equal(choice.lists, guess.lists);
        assert_int_equal(choice.shading, FNL_SHADING_DEFERRED);
        assert_false(chooser_wants(&c));
    }
    m.lists[FNL_LISTS_CLUSTERED] = 0.1;
    for (int i = 0; i < 16; i++) step(&m, &at, false); /* pinned in the middle of measuring: the best so far */
    assert_int_equal(c.state, CHOOSER_MEASURING);
    assert_int_equal(step(&m, &at, true).lists, FNL_LISTS_CLUSTERED);
    assert_non_null(strstr(c.reason, "measured so far"));
    /* once let go it measures, and the result is kept when pinned again */
    settle(&m, &at);
    assert_int_equal(c.choice.lists, FNL_LISTS_CLUSTERED);
    assert_int_equal(step(&m, &at, true).lists, FNL_LISTS_CLUSTERED);
}

static void test_without_times(void **state) {
    UNUSED(state);
    static struct chooser c;
    c = (struct chooser){0};
    struct machine m = machine_make(&c);
    m.mute = true;
    struct choice_case at = some_case(1000);
    settle(&m, &at);
    assert_int_equal(c.choice.lists, chooser_guess(&at).lists);
    assert_non_null(strstr(c.reason, "no times"));
    assert_int_equal(c.memory_count, 0);
}

static void test_memory(void **state) {
    UNUSED(state);
    static struct chooser c, d;
    c = d = (struct chooser){0};
    struct machine m = machine_make(&c);
    for (uint32_t i = 0; i < CHOOSER_MEMORY + 20; i++) {
        struct choice_case at = some_case(1000);
        at.scene = i;
        m.lists[FNL_LISTS_CLUSTERED] = 0.1;
        settle(&m, &at);
    }
    assert_int_equal(c.memory_count, CHOOSER_MEMORY);
    size_t length = chooser_print(&c, NULL, 0);
    char *text = calloc(length + 256, 1);
    assert_int_equal(chooser_print(&c, text, length + 1), length);
    strcat(text, "rubbish\n12 deferred nothing 3\n13 deferred tiled nan\n14 deferred tiled inf\n15 deferred tiled -1\n"
                 "16 deferred tiled 1e300\n99 deferred all");
    chooser_parse(&d, text, strlen(text));
    assert_int_equal(d.memory_count, CHOOSER_MEMORY);
    for (uint32_t i = 0; i < CHOOSER_MEMORY; i++) {
        assert_true(d.memory[i].key == c.memory[i].key);
        assert_int_equal(d.memory[i].choice.lists, FNL_LISTS_CLUSTERED);
    }
    struct choice_case at = some_case(900); /* of the same size */
    at.scene = CHOOSER_MEMORY + 19;
    assert_int_equal(chooser_pick(&d, &at, true, (struct chooser_background){0}).lists, FNL_LISTS_CLUSTERED);
    assert_int_equal(d.state, CHOOSER_DECIDED);
    at.scene = 0; /* forgotten: the oldest */
    chooser_pick(&d, &at, true, (struct chooser_background){0});
    assert_int_equal(d.state, CHOOSER_MEASURING);
    free(text);
}

/* What draws the surfaces costs the same with all lists. */
static void test_which_passes_are_compared(void **state) {
    UNUSED(state);
    const struct choice lists = {FNL_SHADING_DEFERRED, FNL_LISTS_AUTO}, both = {FNL_SHADING_AUTO, FNL_LISTS_AUTO};
    for (uint32_t i = 0; i < FNL_PASS_ROLE_COUNT; i++) {
        const fnl_pass_role role = (fnl_pass_role)i;
        assert_true(chooser_counts(&lists, role) == (role != FNL_PASS_GEOMETRY));
        assert_true(chooser_counts(&both, role));
    }
}

static void test_candidates_wait_for_their_pipelines(void **state) {
    UNUSED(state);
    static struct chooser c;
    for (uint32_t fastest = 0; fastest < FNL_LISTS_AUTO; fastest++) {
        c = (struct chooser){0};
        struct machine m = machine_make(&c);
        struct choice_case at = some_case(1000);
        struct choice guess = chooser_guess(&at);
        for (uint32_t i = 0; i < FNL_LISTS_COUNT; i++) m.making[i] = 7;
        m.lists[fastest] = 1;
        uint32_t frames = 0, measured = 0;
        for (; c.state != CHOOSER_DECIDED || frames == 0; frames++) {
            uint64_t noted = c.frames;
            struct choice choice = step(&m, &at, false);
            struct chooser_background b = background(&m);
            bool busy = b.done < b.asked;
            if (busy && frames > 0) { /* who has no pipelines is not drawn with, and nobody is measured */
                assert_int_equal(choice.lists, guess.lists);
                assert_int_equal(c.frames, noted);
            }
            measured += !busy;
            assert_true(frames < 200);
        }
        assert_int_equal(m.late, 1); /* the very first */
        assert_true(m.busy_frames > 40 && measured <= MOST_FRAMES);
        if (!m.tried[fastest]) continue;
        assert_int_equal(c.choice.lists, fastest);
        assert_true(c.milliseconds < (m.orders[FNL_SHADING_DEFERRED] + 1) * 1.03); /* ten times that while pipelines were made */
    }
}

static void test_a_decision_falls_although_pipelines_never_come(void **state) {
    UNUSED(state);
    static struct chooser c;
    c = (struct chooser){0};
    struct machine m = machine_make(&c);
    struct choice_case at = some_case(1000);
    for (uint32_t i = 0; i < FNL_LISTS_COUNT; i++) m.making[i] = 2;
    m.making[FNL_LISTS_FINE] = FOREVER;
    m.lists[FNL_LISTS_FINE] = 0.1;
    m.lists[FNL_LISTS_ZBIN] = 0.2;
    uint32_t frames = 0;
    while (c.state != CHOOSER_DECIDED && frames <= CHOOSER_PATIENCE + MOST_FRAMES) {
        step(&m, &at, false);
        frames++;
    }
    assert_int_equal(c.state, CHOOSER_DECIDED);
    assert_true(frames > CHOOSER_PATIENCE);
    assert_int_equal(c.choice.lists, FNL_LISTS_ZBIN); /* asked for before it */
    assert_false(m.tried[FNL_LISTS_FINE]);
    assert_int_equal(m.late, 1);
}

static void hand_on(struct chooser *from, struct chooser *to, const char *more) {
    chooser_keep(from);
    size_t length = chooser_print(from, NULL, 0);
    char *text = calloc(length + strlen(more) + 1, 1);
    assert_int_equal(chooser_print(from, text, length + 1), length);
    strcat(text, more);
    *to = (struct chooser){0};
    chooser_parse(to, text, strlen(text));
    free(text);
}

/* Decides with these times of two candidates, all others take 15 ms; of each the first `told` times become known. */
static void decide_by(struct chooser *c, fnl_light_lists one, const double *times_of_one, fnl_light_lists other, const double *times_of_other, uint32_t told) {
    const struct choice_case at = some_case(1000);
    *c = (struct chooser){0};
    for (uint64_t frame = 1; frame <= MOST_FRAMES; frame++) {
        struct choice asked;
        const struct choice choice = chooser_pick(c, &at, true, (struct chooser_background){0});
        if (c->state == CHOOSER_DECIDED) return;
        while (chooser_asks(c, &asked)) chooser_asked(c, 0);
        assert_true(c->last < CHOOSER_CANDIDATES);
        const uint32_t turn = c->candidates[c->last].given; /* the first is not counted */
        const double time = turn == 0 ? 15 : choice.lists == one ? times_of_one[turn - 1] : choice.lists == other ? times_of_other[turn - 1] : 15;
        chooser_note(c, frame, 0);
        chooser_feed(c, turn > told ? -1 : time, 0);
    }
    fail_msg("undecided after %d frames", MOST_FRAMES);
}

/* The least median wins: one frame that took unusually long or short changes no decision, whichever of the frames it was. */
static void test_the_median_of_the_times_decides(void **state) {
    UNUSED(state);
    static struct chooser c;
    static const struct {
        double fast[CHOOSER_TIMES], rival[CHOOSER_TIMES]; /* turned round below */
        uint32_t told;
        double median;
    } cases[] = {{{18, 10, 10.5}, {11, 11, 11}, 3, 10.5}, /* means: 12.8 and 11 */
                 {{10, 10, 10}, {5.5, 12, 12}, 3, 10},    /* means: 10 and 9.8 */
                 {{10.5, 18, 3}, {11, 11, 10.8}, 3, 10.5},
                 {{8, 14}, {12, 12}, 2, 11},
                 {{12, 12}, {9, 17}, 2, 12},
                 {{14}, {15}, 1, 14}};
    for (uint32_t i = 0; i < COUNT_OF(cases); i++)
        for (uint32_t turn = 0; turn < 2 * cases[i].told; turn++) {
            double fast[CHOOSER_TIMES], rival[CHOOSER_TIMES];
            for (uint32_t k = 0; k < cases[i].told; k++) {
                const uint32_t from = (k + turn) % cases[i].told;
                fast[k] = cases[i].fast[from], rival[k] = cases[i].rival[from];
            }
            const fnl_light_lists first = turn < cases[i].told ? FNL_LISTS_TILED : FNL_LISTS_ZBIN;
            const fnl_light_lists second = first == FNL_LISTS_TILED ? FNL_LISTS_ZBIN : FNL_LISTS_TILED;
            decide_by(&c, first, fast, second, rival, cases[i].told);
            if (c.choice.lists != first) fail_msg("case %u, turned by %u: %s", i, turn, c.reason);
            if (fabs(c.milliseconds - cases[i].median) > 1e-9) fail_msg("case %u, turned by %u: %g ms", i, turn, c.milliseconds);
            for (uint32_t k = 0; k < c.candidate_count; k++)
                if (c.candidates[k].choice.lists == first) assert_int_equal(c.candidates[k].got, cases[i].told);
        }
}

/* Runs of a few frames each come to a decision together. */
static void test_measurements_are_kept_from_run_to_run(void **state) {
    UNUSED(state);
    static struct chooser c, d;
    for (int orders = 0; orders < 2; orders++) {
        struct choice_case at = some_case(1000);
        if (orders) at.asked.shading = FNL_SHADING_AUTO;
        c = (struct chooser){0};
        uint32_t runs = 0, kept = 0;
        for (; c.state != CHOOSER_DECIDED; runs++) {
            struct machine m = machine_make(&c);
            m.lists[FNL_LISTS_ZBIN] = 0.1;
            m.orders[FNL_SHADING_FORWARD_PREPASS] = 4;
            for (int i = 0; i < 20 && c.state != CHOOSER_DECIDED; i++) step(&m, &at, false);
            if (c.state == CHOOSER_DECIDED) break;
            hand_on(&c, &d, "trial rubbish\ntrial 12 deferred nothing 3\ntrial 12 deferred tiled\ntrial 12 deferred tiled -1\n");
            assert_true(d.trial_count > kept);
            kept = d.trial_count;
            c = d;
            assert_true(runs < 5);
        }
        assert_true(runs > 0);
        assert_int_equal(c.choice.lists, FNL_LISTS_ZBIN);
        assert_int_equal(c.choice.shading, orders ? FNL_SHADING_FORWARD_PREPASS : FNL_SHADING_DEFERRED);
        assert_int_equal(c.trial_count, 0); /* what is decided needs no more */
        hand_on(&c, &d, "");
        assert_int_equal(chooser_pick(&d, &at, true, (struct chooser_background){0}).lists, FNL_LISTS_ZBIN);
        assert_int_equal(d.state, CHOOSER_DECIDED);
    }
    /* All that was missing was the decision. */
    c = (struct chooser){0};
    struct machine m = machine_make(&c);
    struct choice_case at = some_case(1000);
    m.lists[FNL_LISTS_HALFZ] = 0.1;
    uint32_t turns = 0;
    for (bool all = false; !all;) {
        step(&m, &at, false);
        all = c.candidate_count > 0;
        for (uint32_t i = 0; i < c.candidate_count; i++) all = all && (c.candidates[i].dropped || c.candidates[i].got == CHOOSER_TIMES);
        assert_true(turns++ < MOST_FRAMES);
    }
    assert_int_equal(c.state, CHOOSER_MEASURING);
    hand_on(&c, &d, "");
    struct choice pinned = chooser_pick(&d, &at, true, (struct chooser_background){0}); /* the best measured, not the guess */
    assert_int_equal(pinned.lists, FNL_LISTS_HALFZ);
    m = machine_make(&d);
    step(&m, &at, false);
    assert_int_equal(d.state, CHOOSER_DECIDED);
    assert_int_equal(d.choice.lists, FNL_LISTS_HALFZ);
}

static void test_trials_of_other_cases_do_not_pile_up(void **state) {
    UNUSED(state);
    static struct chooser c;
    c = (struct chooser){0};
    struct machine m = machine_make(&c);
    for (uint32_t i = 0; i < CHOOSER_TRIALS; i++) { /* none comes to a decision */
        struct choice_case at = some_case(1000);
        at.scene = i;
        for (int k = 0; k < 20; k++) step(&m, &at, false);
        assert_int_equal(c.state, CHOOSER_MEASURING);
        assert_true(c.trial_count <= CHOOSER_TRIALS);
    }
    assert_int_equal(c.trial_count, CHOOSER_TRIALS);
    struct choice_case at = some_case(1000), last = some_case(1000);
    at.scene = CHOOSER_TRIALS - 2;
    step(&m, &at, false); /* goes on where it was left */
    assert_true(c.candidates[0].got > 0);
    last.scene = 0; /* the oldest is forgotten */
    step(&m, &last, false);
    assert_int_equal(c.candidates[0].got, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_which_passes_are_compared),
        cmocka_unit_test(test_the_fastest_wins_whatever_it_is),
        cmocka_unit_test(test_no_lights_need_no_lists),
        cmocka_unit_test(test_the_guess_goes_by_the_number_of_lights),
        cmocka_unit_test(test_the_longer_of_both_times_counts),
        cmocka_unit_test(test_lists_of_lights_that_stand_still),
        cmocka_unit_test(test_brute_force_is_tried_with_few_lights_only),
        cmocka_unit_test(test_likely_pairs_are_those_that_are_tried),
        cmocka_unit_test(test_slow_candidates_get_fewer_turns),
        cmocka_unit_test(test_the_median_of_the_times_decides),
        cmocka_unit_test(test_order_and_lists_together),
        cmocka_unit_test(test_candidates_are_told),
        cmocka_unit_test(test_close_paths_where_they_are_allowed),
        cmocka_unit_test(test_decides_again_when_much_changes),
        cmocka_unit_test(test_pinned_measures_nothing),
        cmocka_unit_test(test_without_times),
        cmocka_unit_test(test_memory),
        cmocka_unit_test(test_candidates_wait_for_their_pipelines),
        cmocka_unit_test(test_a_decision_falls_although_pipelines_never_come),
        cmocka_unit_test(test_measurements_are_kept_from_run_to_run),
        cmocka_unit_test(test_trials_of_other_cases_do_not_pile_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
