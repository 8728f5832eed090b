/* SPDX-License-Identifier: MIT */
/** Which light lists use an option: what the table of options says, compared with what frames do. */
#include "fanal/options.h"
#include "tests/list_pairs.h"
#include "tests/frame_plain.h"

#include <inttypes.h>

enum { PLAN_CAPACITY = 1 << 17, POOL = 1 << 16 };

/* What a frame did for its lists. */
struct work {
    char plan[PLAN_CAPACITY]; /* with the sizes of everything */
    char numbers[256];
};

static struct work measure(struct stage *stage, const fnl_frame *frame) {
    struct work work;
    harness_set_pool(stage, POOL);
    struct shot shot = stage_shoot(stage, frame);
    const fnl_frame_stats *s = &shot.stats;
    snprintf(work.numbers, sizeof work.numbers,
             "%" PRIu64 " entries, %" PRIu64 " bytes used of %" PRIu64 ", %u lights in view, %" PRIu64 " evaluations",
             s->list_entries, s->list_used_bytes, s->list_bytes, s->lights_in_view, s->evaluations);
    shot_free(&shot);
    assert_true(fnl_renderer_print(stage->renderer, FNL_PRINT_PLAN, work.plan, sizeof work.plan) < sizeof work.plan);
    return work;
}

static bool differ(const struct work *a, const struct work *b) {
    return strcmp(a->numbers, b->numbers) != 0 || strcmp(a->plan, b->plan) != 0;
}

/* Value `index` of two or three that an option takes; false beyond the last. A later row of the table gets a greater number, so that what
   is set together goes together. */
static bool option_value(const fnl_option *o, uint32_t row, uint32_t index, char *text, size_t capacity) {
    const fnl_frame usual = frame_plain();
    const char *name = o->kind == FNL_OPTION_NAME ? fnl_value_name(o->names, index) : index == 0 ? "off" : index == 1 ? "on" : NULL;
    if (o->kind == FNL_OPTION_NAME || o->kind == FNL_OPTION_SWITCH) {
        if (name) snprintf(text, capacity, "%s", name);
        return name;
    }
    fnl_frame_get(&usual, o->key, text, capacity);
    double numbers[3] = {o->low, 2 * atof(text), 0};
    for (uint32_t i = 0; i < MIN(o->choice_count, 3u); i++) numbers[i] = (double)o->choices[i];
    if (o->kind == FNL_OPTION_NUMBER) numbers[0] = numbers[1] = 2 + row;
    if (index >= MAX(o->choice_count, 2u) || index >= 3) return false;
    snprintf(text, capacity, "%g", numbers[index]);
    return true;
}

/* Options of lists, as the table says, and what of it a frame can show. */
static bool is_of_lists(const fnl_option *o) { return o->lists != UINT32_MAX; }
static bool is_shown(const fnl_option *o) {
    return strcmp(o->key, "list.tree-hybrid") != 0 && /* what a tree looks like inside: tree_test.c */
           strcmp(o->key, "stereo.lists") != 0 &&     /* takes two eyes: stereo_test.c */
           strcmp(o->key, "raster.path") != 0;        /* some devices have but one */
}

static bool changes_work(struct stage *stage, const fnl_frame *frame, const struct work *before, struct work *after) {
    *after = measure(stage, frame);
    if (differ(before, after)) *after = measure(stage, frame); /* some only make again what they keep */
    return differ(before, after);
}

static uint32_t check_heeded(struct stage *stage, const fnl_frame *usual, const fnl_option *o, uint32_t row,
                             const struct work *before) {
    static struct work after;
    char value[64];
    for (uint32_t i = 0; option_value(o, row, i, value, sizeof value); i++) {
        fnl_frame frame = *usual;
        assert_int_equal(fnl_frame_set(NULL, &frame, o->key, value), FNL_OK);
        if (changes_work(stage, &frame, before, &after)) return 0;
    }
    print_message("%s does not use %s\n", pair_name(usual), o->key);
    return 1;
}

/* Changes all options at once that the lists do not use. */
static uint32_t check_unheeded(struct stage *stage, const fnl_frame *usual, const struct work *before) {
    static struct work after;
    fnl_option o;
    char value[64];
    for (uint32_t i = 0; i < 3; i++) {
        fnl_frame frame = *usual;
        for (uint32_t row = 0; fnl_option_query(row, &o); row++)
            if (is_of_lists(&o) && !(o.lists >> usual->lists & 1) && option_value(&o, row, i, value, sizeof value))
                assert_int_equal(fnl_frame_set(NULL, &frame, o.key, value), FNL_OK);
        if (!changes_work(stage, &frame, before, &after)) continue;
        print_message("%s uses an option that is not said to matter: %s; with all of them as usual: %s\n", pair_name(usual),
                      after.numbers, before->numbers);
        return 1;
    }
    return 0;
}

static void test_lists_that_use_options(void **state) {
    UNUSED(state);
    static struct work before;
    struct stage stage = stage_open("builtin:spheres?lights=0", 96);
    uint32_t wrong = 0, heeded = 0;
    fnl_option o;
    for (uint32_t l = FNL_LISTS_ALL; l < FNL_LISTS_AUTO; l++) {
        fnl_frame frame = stage.frame;
        frame.width = 65;
        frame.height = 37;
        frame.count_lights = true;
        frame.lists = (fnl_light_lists)l;
        if (!fnl_shading_supports(frame.shading, frame.lists, frame.msaa)) frame.shading = FNL_SHADING_FORWARD_PREPASS;
        for (int i = 0; i < 4; i++) before = measure(&stage, &frame); /* once what is kept has been made */
        for (uint32_t row = 0; fnl_option_query(row, &o); row++) {
            if (!is_of_lists(&o) || !(o.lists >> l & 1) || !is_shown(&o)) continue;
            wrong += check_heeded(&stage, &frame, &o, row, &before);
            heeded++;
        }
        wrong += check_unheeded(&stage, &frame, &before);
    }
    assert_int_equal(wrong, 0);
    assert_true(heeded > FNL_LISTS_AUTO);
    stage_close(&stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_lists_that_use_options),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
