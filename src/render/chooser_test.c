/* SPDX-License-Identifier: MIT */
/* auto: the rules of choosing against made-up times, then on a device. */
#include "tests/render_harness.h"

enum { LATENCY = 2, MOST_FRAMES = 60 };

/* A device that takes a known time for each pair, told LATENCY frames later. */
struct machine {
    struct chooser *chooser;
    double lists[FNL_LISTS_COUNT], orders[FNL_SHADING_COUNT];
    double drift; /* part by which everything gets slower in each frame */
    bool mute;    /* tells no times */
    struct random_state random;
    uint64_t frame;
    double times[4096];
    bool tried[FNL_LISTS_COUNT];
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

static struct choice step(struct machine *m, const struct choice_case *at, bool pinned) {
    struct choice choice = chooser_pick(m->chooser, at, pinned);
    m->tried[choice.lists] = true;
    m->frame++;
    m->times[m->frame % 4096] = (m->orders[choice.shading] + m->lists[choice.lists]) * (1 + m->drift * (double)m->frame) *
                                (double)random_range(&m->random, 0.98f, 1.02f);
    if (!pinned) chooser_note(m->chooser, m->frame);
    for (uint64_t wanted; (wanted = chooser_wants(m->chooser)) && wanted + LATENCY <= m->frame;)
        chooser_feed(m->chooser, m->mute ? -1 : m->times[wanted % 4096]);
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
        if (many) assert_false(m.tried[FNL_LISTS_CLUSTERED]); /* each cell against each light */
        assert_false(m.tried[FNL_LISTS_MULTIPASS] || m.tried[FNL_LISTS_MESH]);
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
            settle(&m, &at);
            uint32_t tried = 0;
            for (uint32_t l = 0; l < FNL_LISTS_AUTO; l++) {
                assert_int_equal(m.tried[l], fnl_lists_likely((fnl_shading)shading, (fnl_light_lists)l, at.light_count, at.msaa));
                tried += m.tried[l];
            }
            assert_true(tried >= 2 && tried <= CHOOSER_CANDIDATES);
        }
    for (uint32_t shading = 0; shading < FNL_SHADING_COUNT; shading++)
        assert_int_equal(fnl_shading_likely((fnl_shading)shading), shading < 3); /* as fnl_shading says */
    assert_false(fnl_lists_likely(FNL_SHADING_AUTO, FNL_LISTS_TILED, 100, 1) ||
                 fnl_lists_likely(FNL_SHADING_DEFERRED, FNL_LISTS_AUTO, 100, 1));
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
    at.msaa = 4; /* deferred orders light edges elsewhere; lists that bound tiles by depth may be off by a hair */
    m = machine_make(&c);
    m.orders[FNL_SHADING_DEFERRED] = 0;
    m.lists[FNL_LISTS_TILED] = 0;
    settle(&m, &at);
    assert_int_not_equal(c.choice.shading, FNL_SHADING_DEFERRED);
    assert_false(m.tried[FNL_LISTS_TILED] || m.tried[FNL_LISTS_HALFZ]);
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
    assert_non_null(strstr(c.reason, "before the choice was pinned"));
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
    char *text = calloc(length + 64, 1);
    assert_int_equal(chooser_print(&c, text, length + 1), length);
    strcat(text, "rubbish\n12 deferred nothing 3\n99 deferred all");
    chooser_parse(&d, text, strlen(text));
    assert_int_equal(d.memory_count, CHOOSER_MEMORY);
    for (uint32_t i = 0; i < CHOOSER_MEMORY; i++) {
        assert_true(d.memory[i].key == c.memory[i].key);
        assert_int_equal(d.memory[i].choice.lists, FNL_LISTS_CLUSTERED);
    }
    struct choice_case at = some_case(900); /* of the same size */
    at.scene = CHOOSER_MEMORY + 19;
    assert_int_equal(chooser_pick(&d, &at, false).lists, FNL_LISTS_CLUSTERED);
    assert_int_equal(d.state, CHOOSER_DECIDED);
    at.scene = 0; /* forgotten: the oldest */
    chooser_pick(&d, &at, false);
    assert_int_equal(d.state, CHOOSER_MEASURING);
    free(text);
}

/* On a device: decided within 60 frames, each with the bits of brute force. */
static void test_frames(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:spheres?lights=100", 0);
    fnl_frame frame = stage.frame;
    frame.width = 96;
    frame.height = 54;
    frame.shading = FNL_SHADING_DEFERRED;
    frame.lists = FNL_LISTS_ALL;
    struct shot all = stage_shoot(&stage, &frame);
    assert_int_equal(all.stats.lists, FNL_LISTS_ALL);
    assert_string_equal(all.stats.choice, "");
    frame.lists = FNL_LISTS_AUTO;
    uint32_t decided = 0;
    bool used[FNL_LISTS_COUNT] = {0};
    for (uint32_t i = 1; i <= 70; i++) {
        struct shot shot = stage_shoot(&stage, &frame);
        assert_int_equal(count_differing(&all.radiance, &shot.radiance), 0);
        assert_true(shot.stats.lists < FNL_LISTS_AUTO && shot.stats.shading == FNL_SHADING_DEFERRED);
        used[shot.stats.lists] = true;
        if (!decided && !shot.stats.choosing) decided = i;
        if (decided) assert_non_null(strstr(shot.stats.choice, "fastest of"));
        shot_free(&shot);
    }
    assert_true(decided > 0 && decided <= MOST_FRAMES);
    uint32_t count = 0;
    for (uint32_t i = 0; i < FNL_LISTS_COUNT; i++) count += used[i];
    assert_true(count >= 2);
    frame.shading = FNL_SHADING_AUTO;
    frame.pin_choice = true;
    struct shot pinned = stage_shoot(&stage, &frame);
    assert_true(pinned.stats.shading < FNL_SHADING_AUTO && !pinned.stats.choosing);
    assert_true(greatest_difference(&all.color, &pinned.color) <= 2);
    shot_free(&pinned);
    shot_free(&all);
    stage_close(&stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_the_fastest_wins_whatever_it_is, harness_check),
        cmocka_unit_test_teardown(test_brute_force_is_tried_with_few_lights_only, harness_check),
        cmocka_unit_test_teardown(test_likely_pairs_are_those_that_are_tried, harness_check),
        cmocka_unit_test_teardown(test_slow_candidates_get_fewer_turns, harness_check),
        cmocka_unit_test_teardown(test_order_and_lists_together, harness_check),
        cmocka_unit_test_teardown(test_decides_again_when_much_changes, harness_check),
        cmocka_unit_test_teardown(test_pinned_measures_nothing, harness_check),
        cmocka_unit_test_teardown(test_without_times, harness_check),
        cmocka_unit_test_teardown(test_memory, harness_check),
        cmocka_unit_test_teardown(test_frames, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
