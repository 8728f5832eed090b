/* SPDX-License-Identifier: MIT */
/** The tables of shading orders and debug views are complete, and the pages say what they say. Needs no device. */
#include "fanal/options.h"
#include "render/debug_views.h"
#include "render/orders/order.h"
#include "render/step.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static const struct debug_view *view_with(fnl_shading shading, uint32_t view) {
    return debug_views_find(shading, (fnl_debug_view)view);
}

static void test_orders_are_complete(void **state) {
    UNUSED(state);
    for (uint32_t i = 0; i < FNL_SHADING_AUTO; i++) {
        const struct order *order = shading_order((fnl_shading)i);
        if (!order || !order->add) fail_msg("%s has no row", fnl_value_name(FNL_ENUM_SHADING, i));
        for (uint32_t k = 0; k < i; k++) assert_ptr_not_equal(order, shading_order((fnl_shading)k));
        assert_int_equal(order->views != NULL, order->view_count > 0);
    }
    assert_false(shading_is(FNL_SHADING_AUTO, 0));
}

/* The options of views that are drawn at once name the paths that have the trait. */
static void test_options_know_multiview(void **state) {
    UNUSED(state);
    static const char *const keys[] = {"multiview", "stereo.path", "stereo.mono-distance"};
    uint32_t paths = 0;
    for (uint32_t i = 0; i < FNL_SHADING_AUTO; i++) paths |= (uint32_t)shading_is((fnl_shading)i, SHADING_MULTIVIEW) << i;
    assert_true(paths != 0);
    for (size_t i = 0; i < COUNT_OF(keys); i++) {
        fnl_option option;
        assert_true(fnl_option_find(keys[i], &option));
        assert_int_equal(option.shadings, paths);
    }
}

/* What the GPU counts for a table lies in a part of its own, and the table's rows in that part. */
static void test_counts_lie_apart(void **state) {
    UNUSED(state);
    uint32_t shadings, tables = 0;
    uint64_t end = 0;
    for (uint32_t t = 0; t < counter_table_count(); t++) {
        const struct counter_table *table = counter_table_at(t, &shadings);
        if (!table) continue;
        tables += table->counts_size > 0;
        assert_int_equal(table->counts_size % 4, 0);
        assert_int_equal(counters_place(table), end);
        end += table->counts_size;
        for (uint32_t i = 0; i < table->row_count; i++) assert_true((uint64_t)table->rows[i].offset + table->rows[i].size <= table->counts_size);
    }
    assert_int_equal(counters_size(), end);
    assert_true(tables > 10);
}

/* Each step does something, under a name of its own, and no number has two rows. */
static void test_steps_are_complete(void **state) {
    UNUSED(state);
    for (uint32_t i = 0; i < FRAME_STEP_COUNT; i++) {
        const struct frame_step *step = frame_step_at(i);
        assert_true(step && step->name && step->name[0]);
        const bool declares = step->begin_frame || step->begin_view || step->begin_light || step->light_view || step->end_light || step->finish_view;
        if (!declares && !step->init && !step->check && !step->prepare && !step->submitted && !step->forget && !step->grow && !step->destroy && !step->counters)
            fail_msg("%s does nothing", step->name);
        for (uint32_t k = 0; k < i; k++) assert_string_not_equal(step->name, frame_step_at(k)->name);
    }
    assert_null(frame_step_at(FRAME_STEP_COUNT));
    uint32_t shadings, rows = 0;
    for (uint32_t t = 0; t < counter_table_count(); t++) {
        const struct counter_table *table = counter_table_at(t, &shadings);
        for (uint32_t i = 0; table && i < table->row_count; i++) {
            fnl_counter counter;
            assert_true(fnl_counter_query(rows++, &counter));
            assert_string_equal(counter.key, table->rows[i].key);
            for (uint32_t k = 0; k < rows - 1; k++) {
                fnl_counter other;
                assert_true(fnl_counter_query(k, &other));
                assert_string_not_equal(counter.key, other.key);
            }
        }
    }
    assert_int_equal(rows, counters_total());
}

static bool is_color(const fnl_vec3 *c) { return c->x >= 0 && c->x <= 1 && c->y >= 0 && c->y <= 1 && c->z >= 0 && c->z <= 1; }

/* A view of several orders has one legend; what its kind needs is there. */
static void check_legend(fnl_debug_view view, const char *name) {
    fnl_debug_legend legend;
    assert_true(fnl_debug_legend_query(view, &legend));
    for (uint32_t i = 0; i < FNL_SHADING_AUTO; i++) {
        const struct debug_view *row = view_with((fnl_shading)i, view);
        if (row && row->legend.text != legend.text) fail_msg("%s has another legend with %s", name, fnl_value_name(FNL_ENUM_SHADING, i));
    }
    if (!legend.text || strlen(legend.text) < 8) fail_msg("the legend of %s says nothing", name);
    for (uint32_t i = 0; i < legend.color_count; i++) {
        if (!is_color(&legend.colors[i])) fail_msg("%s: colour %u is none", name, i);
        if (legend.kind == FNL_LEGEND_COLORS && (!legend.names[i] || !legend.names[i][0])) fail_msg("%s: colour %u means nothing", name, i);
    }
    const bool is_ramp = legend.kind == FNL_LEGEND_RAMP;
    assert_int_equal(is_ramp, legend.low && legend.high && legend.color_count == FNL_LEGEND_COLORS_MAX);
    assert_int_equal(legend.kind == FNL_LEGEND_TEXT, legend.color_count == 0);
}

/* Each view is offered by some order, has a name and a line of help, and is drawn. */
static void test_views_are_complete(void **state) {
    UNUSED(state);
    for (uint32_t view = FNL_DEBUG_NONE + 1; view < FNL_DEBUG_COUNT; view++) {
        const char *name = fnl_value_name(FNL_ENUM_DEBUG_VIEW, view), *help = fnl_value_help(FNL_ENUM_DEBUG_VIEW, view);
        uint32_t offered = 0;
        for (uint32_t i = 0; i < FNL_SHADING_AUTO; i++) {
            const struct debug_view *row = view_with((fnl_shading)i, view);
            offered += row != NULL;
            if (row && (row->view != (fnl_debug_view)view || !row->add)) fail_msg("the row of the view %s is wrong", name);
        }
        if (!offered) fail_msg("no order has a row for the view %s", name);
        check_legend((fnl_debug_view)view, name);
        if (!help || strlen(help) < 8) fail_msg("the view %s has no help", name);
        /* auto may become any order: it takes what all of them offer. */
        assert_int_equal(view_with(FNL_SHADING_AUTO, view) != NULL, offered == FNL_SHADING_AUTO);
    }
    assert_null(fnl_value_help(FNL_ENUM_DEBUG_VIEW, FNL_DEBUG_COUNT));
    fnl_debug_legend legend;
    assert_false(fnl_debug_legend_query(FNL_DEBUG_NONE, &legend));
    assert_false(fnl_debug_legend_query(FNL_DEBUG_COUNT, &legend));
    assert_null(fnl_value_help(FNL_ENUM_SHADING, 0));
    assert_null(fnl_value_help(FNL_ENUM_COUNT, 0));
}

static void test_views_go_with_their_orders(void **state) {
    UNUSED(state);
    assert_non_null(view_with(FNL_SHADING_COARSE, FNL_DEBUG_COARSE));
    assert_null(view_with(FNL_SHADING_DEFERRED, FNL_DEBUG_COARSE));
    assert_non_null(view_with(FNL_SHADING_DEFERRED_VOLUMES, FNL_DEBUG_GBUFFER_4));
    assert_null(view_with(FNL_SHADING_LIGHT_PREPASS, FNL_DEBUG_GBUFFER_4)); /* whose G-buffer is its own */
    assert_null(view_with(FNL_SHADING_TEXTURING, FNL_DEBUG_PAGES));
    for (uint32_t i = 0; i < FNL_SHADING_AUTO; i++)
        for (uint32_t view = FNL_DEBUG_GBUFFER_0; view <= FNL_DEBUG_LIT_FORWARD; view++)
            assert_int_equal(view_with((fnl_shading)i, view) != NULL, shading_is((fnl_shading)i, SHADING_LAYOUTS));
}

/* What the public interface says of a path follows from its traits. */
static void test_options_and_bits_follow_traits(void **state) {
    UNUSED(state);
    static const struct {
        const char *key;
        uint32_t trait;
    } rows[] = {{"gbuffer.layout", SHADING_LAYOUTS}, {"decal-mip-fix", SHADING_LAYOUTS | SHADING_DECALS}};
    uint32_t blended = 0;
    for (uint32_t i = 0; i < FNL_SHADING_AUTO; i++) {
        const fnl_shading shading = (fnl_shading)i;
        fnl_option option = {0};
        for (uint32_t k = 0; k < COUNT_OF(rows); k++) {
            assert_true(fnl_option_find(rows[k].key, &option));
            if ((option.shadings >> i & 1) != shading_is(shading, rows[k].trait))
                fail_msg("the row of %s is wrong about %s", rows[k].key, fnl_value_name(FNL_ENUM_SHADING, i));
        }
        bool bit = fnl_shading_likely(shading, FNL_LISTS_AUTO, 0, 1) & FNL_LIKELY_BLENDED;
        assert_int_equal(bit, shading_is(shading, SHADING_VOLUMES));
        assert_int_equal(bit, (fnl_shading_likely(shading, FNL_LISTS_TILED, 5000, 4) & FNL_LIKELY_BLENDED) != 0);
        blended += bit;
    }
    assert_int_equal(blended, 4); /* deferred-volumes, pre-lighting, light-indexed, zioma */
    assert_int_equal(fnl_shading_likely(FNL_SHADING_AUTO, FNL_LISTS_TILED, 100, 1), 0);
}

/* ---- the pages ---- */

static char *read_page(const char *path) {
    FILE *file = fopen(path, "rb");
    if (!file) fail_msg("%s cannot be read", path);
    assert_int_equal(fseek(file, 0, SEEK_END), 0);
    long size = ftell(file);
    rewind(file);
    char *text = calloc((size_t)size + 1, 1);
    assert_int_equal(fread(text, 1, (size_t)size, file), (size_t)size);
    fclose(file);
    return text;
}

static const char *lists_of(fnl_shading shading) {
    bool mesh = fnl_shading_supports(shading, FNL_LISTS_MESH, 1), batches = fnl_shading_supports(shading, FNL_LISTS_BATCHES, 1);
    assert_int_equal(batches, fnl_shading_supports(shading, FNL_LISTS_MULTIPASS, 1));
    if (batches) return "all";
    return mesh ? "all but `batches`, `multipass`" : "all but `mesh`, `batches`, `multipass`";
}

/* The row of an order in the table of docs/choosing.md. */
static void print_row(fnl_shading shading, char *row, size_t capacity) {
    const char *layouts = shading_is(shading, SHADING_LAYOUTS) ? "all" : "-";
    const char *prepass = shading_is(shading, SHADING_PREPASS) ? "always" : shading_is(shading, SHADING_MAY_PREPASS) ? "if asked" : "never";
    snprintf(row, capacity, "| `%s` | %s | %s | %s | %s | %s |\n", fnl_value_name(FNL_ENUM_SHADING, shading),
             shading_is(shading, SHADING_APPROXIMATE) ? "close" : "equal",
             fnl_shading_supports(shading, FNL_LISTS_AUTO, 4) ? "yes" : "no", layouts, prepass, lists_of(shading));
}

static void test_choosing_page_says_what_orders_do(void **state) {
    UNUSED(state);
    char *page = read_page(SOURCE_DIR "/docs/choosing.md"), row[256];
    static const char head[] = "| path | picture | MSAA | `gbuffer.layout` | depth prepass | lists |\n|---|---|---|---|---|---|\n";
    const char *at = strstr(page, head);
    assert_non_null(at);
    at += strlen(head);
    for (uint32_t i = 0; i < FNL_SHADING_AUTO; i++, at += strlen(row)) {
        print_row((fnl_shading)i, row, sizeof row);
        if (strncmp(at, row, strlen(row)) != 0) fail_msg("docs/choosing.md should have here: %s", row);
    }
    assert_int_equal(*at, '\n'); /* and no more rows */
    free(page);
}

/* The names in backquotes at the beginning of a table's row. */
static void test_views_page_lists_all_views(void **state) {
    UNUSED(state);
    char *page = read_page(SOURCE_DIR "/docs/techniques/debug-views.md"), name[64];
    bool told[FNL_DEBUG_COUNT] = {false};
    for (char *line = strtok(page, "\n"); line; line = strtok(NULL, "\n")) {
        if (strncmp(line, "| `", 3) != 0) continue;
        char *end = strchr(line + 2, '|');
        assert_non_null(end);
        *end = 0;
        for (const char *at = line; (at = strchr(at, '`'));) {
            size_t length = strcspn(++at, "`");
            uint32_t view;
            snprintf(name, sizeof name, "%.*s", (int)length, at);
            at += length + 1;
            if (!fnl_value_find(FNL_ENUM_DEBUG_VIEW, name, &view)) fail_msg("debug-views.md has %s, which is no view", name);
            if (told[view]) fail_msg("debug-views.md has %s twice", name);
            told[view] = true;
        }
    }
    for (uint32_t view = FNL_DEBUG_NONE + 1; view < FNL_DEBUG_COUNT; view++)
        if (!told[view]) fail_msg("debug-views.md lacks %s", fnl_value_name(FNL_ENUM_DEBUG_VIEW, view));
    free(page);
}

static void print_color(char *line, size_t capacity, const char *lead, const char *name, const fnl_vec3 *c) {
    const size_t length = strlen(line);
    snprintf(line + length, capacity - length, "%s%s (#%02x%02x%02x)", lead, name, (unsigned)lroundf(c->x * 255), (unsigned)lroundf(c->y * 255),
             (unsigned)lroundf(c->z * 255));
}

/* The list of legends in debug-views.md, as the command prints them. */
static void test_views_page_has_all_legends(void **state) {
    UNUSED(state);
    char *page = read_page(SOURCE_DIR "/docs/techniques/debug-views.md"), line[1024];
    for (uint32_t view = FNL_DEBUG_NONE + 1; view < FNL_DEBUG_COUNT; view++) {
        fnl_debug_legend l;
        assert_true(fnl_debug_legend_query((fnl_debug_view)view, &l));
        snprintf(line, sizeof line, "- `%s`: ", fnl_value_name(FNL_ENUM_DEBUG_VIEW, view));
        if (l.kind == FNL_LEGEND_RAMP) {
            print_color(line, sizeof line, "", l.low, &l.colors[0]);
            print_color(line, sizeof line, " to ", l.high, &l.colors[l.color_count - 1]);
        }
        for (uint32_t i = 0; l.kind == FNL_LEGEND_COLORS && i < l.color_count; i++) print_color(line, sizeof line, i ? ", " : "", l.names[i], &l.colors[i]);
        const size_t length = strlen(line);
        snprintf(line + length, sizeof line - length, "%s%s\n", l.kind == FNL_LEGEND_TEXT ? "" : ": ", l.text);
        if (!strstr(page, line)) fail_msg("debug-views.md should have: %s", line);
    }
    free(page);
}

/* Facts of choosing.md, what AUTO means, and values that no frame can have. */
static void test_supported_triples(void **state) {
    UNUSED(state);
    static const struct {
        fnl_shading shading;
        fnl_light_lists lists;
        uint32_t msaa;
        bool supported;
    } cases[] = {
        {FNL_SHADING_FORWARD, FNL_LISTS_MESH, 4, true},          {FNL_SHADING_FORWARD, FNL_LISTS_BATCHES, 1, false},
        {FNL_SHADING_FORWARD_PREPASS, FNL_LISTS_BATCHES, 8, true}, {FNL_SHADING_DEFERRED, FNL_LISTS_TILED, 2, true},
        {FNL_SHADING_DEFERRED, FNL_LISTS_MESH, 1, false},        {FNL_SHADING_MOBILE, FNL_LISTS_TILED, 1, true},
        {FNL_SHADING_MOBILE, FNL_LISTS_TILED, 2, false},         {FNL_SHADING_MOBILE, FNL_LISTS_AUTO, 1, true},
        {FNL_SHADING_MOBILE, FNL_LISTS_AUTO, 4, false},          {FNL_SHADING_AUTO, FNL_LISTS_AUTO, 8, true},
        {FNL_SHADING_AUTO, FNL_LISTS_MULTIPASS, 4, true},        {FNL_SHADING_COUNT, FNL_LISTS_TILED, 1, false},
        {FNL_SHADING_DEFERRED, FNL_LISTS_COUNT, 1, false},       {FNL_SHADING_AUTO, FNL_LISTS_COUNT, 1, false},
    };
    for (uint32_t i = 0; i < COUNT_OF(cases); i++)
        assert_int_equal(fnl_shading_supports(cases[i].shading, cases[i].lists, cases[i].msaa), cases[i].supported);
    for (uint32_t samples = 0; samples < 20; samples++)
        assert_int_equal(fnl_shading_supports(FNL_SHADING_FORWARD, FNL_LISTS_TILED, samples),
                         samples == 1 || samples == 2 || samples == 4 || samples == 8);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_orders_are_complete),
        cmocka_unit_test(test_steps_are_complete),
        cmocka_unit_test(test_counts_lie_apart),
        cmocka_unit_test(test_options_know_multiview),
        cmocka_unit_test(test_views_are_complete),
        cmocka_unit_test(test_views_go_with_their_orders),
        cmocka_unit_test(test_options_and_bits_follow_traits),
        cmocka_unit_test(test_choosing_page_says_what_orders_do),
        cmocka_unit_test(test_views_page_lists_all_views),
        cmocka_unit_test(test_views_page_has_all_legends),
        cmocka_unit_test(test_supported_triples),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
