/* SPDX-License-Identifier: MIT */
/* The table of options: every row is what fnl_frame has, and takes what it says. */
#include "base/values.h"
#include "render/options.h"

#include "fanal/options.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

static char last_line[1024];
static void keep_line(void *user, fnl_log_level level, const char *line) {
    UNUSED(user);
    UNUSED(level);
    snprintf(last_line, sizeof last_line, "%s", line);
}
static fnl_host quiet_host(void) {
    fnl_host host = fnl_host_default();
    host.log = keep_line;
    return host;
}

static void assert_takes(const char *key, const char *value) {
    const fnl_host host = quiet_host();
    fnl_frame frame = fnl_frame_default();
    char text[64];
    last_line[0] = 0;
    if (fnl_frame_set(&host, &frame, key, value) != FNL_OK) fail_msg("%s refuses %s: %s", key, value, last_line);
    assert_int_equal(fnl_frame_get(&frame, key, text, sizeof text), strlen(value));
    assert_string_equal(text, value);
    if (options_check(CALL(&host), &frame) != FNL_OK) fail_msg("%s=%s: %s", key, value, last_line);
}

/* A bad value changes nothing, and the line names the key and the value. */
static void assert_refuses(const char *key, const char *value) {
    const fnl_host host = quiet_host();
    const fnl_frame usual = fnl_frame_default();
    fnl_frame frame;
    memcpy(&frame, &usual, sizeof frame);
    last_line[0] = 0;
    if (fnl_frame_set(&host, &frame, key, value) != FNL_ERROR_INVALID) fail_msg("%s takes %s", key, value);
    assert_memory_equal(&frame, &usual, sizeof frame);
    if (!strstr(last_line, key) || !strstr(last_line, "must be")) fail_msg("%s=%s: %s", key, value, last_line);
}

static void try_count(const fnl_option *o) {
    char text[32];
    if (o->choice_count) {
        for (uint32_t i = 0; i < o->choice_count; i++) {
            assert_true(o->choices[i] >= o->low && o->choices[i] <= o->high);
            snprintf(text, sizeof text, "%u", o->choices[i]);
            assert_takes(o->key, text);
        }
        assert_refuses(o->key, "7");
    } else {
        snprintf(text, sizeof text, "%.0f", o->low);
        assert_takes(o->key, text);
        snprintf(text, sizeof text, "%.0f", o->high);
        assert_takes(o->key, text);
    }
    if (o->low > 0) {
        snprintf(text, sizeof text, "%.0f", o->low - 1);
        assert_refuses(o->key, text);
    }
    snprintf(text, sizeof text, "%.0f", o->high + 1);
    assert_refuses(o->key, text);
    if (o->multiple > 1) {
        snprintf(text, sizeof text, "%.0f", o->low + 1);
        assert_refuses(o->key, text);
    }
    if (o->power_of_two) assert_refuses(o->key, "3");
    assert_refuses(o->key, "-1");
    assert_refuses(o->key, "1.5");
    assert_refuses(o->key, "4294967297"); /* 1, were it cut to 32 bits */
    assert_refuses(o->key, "99999999999999999999999");
}

static void try_number(const fnl_option *o) {
    char text[64];
    snprintf(text, sizeof text, "%.9g", o->above_low ? o->low + 0.25 : o->low);
    assert_takes(o->key, text);
    if (o->above_low) {
        snprintf(text, sizeof text, "%g", o->low);
        assert_refuses(o->key, text);
    }
    snprintf(text, sizeof text, "%g", o->low - 1);
    assert_refuses(o->key, text);
    if (o->high < (double)FLT_MAX) {
        snprintf(text, sizeof text, "%g", o->high);
        assert_takes(o->key, text);
        snprintf(text, sizeof text, "%g", o->high * 1.01 + 0.01);
        assert_refuses(o->key, text);
    }
    if (o->has_auto) assert_takes(o->key, "auto");
    else assert_refuses(o->key, "auto");
    assert_refuses(o->key, "nan");
    assert_refuses(o->key, "inf");
    assert_refuses(o->key, "1e99");
    assert_refuses(o->key, "0.5x");
}

static void test_every_row_takes_its_range(void **state) {
    UNUSED(state);
    fnl_option o, found;
    const char *name;
    uint32_t count = 0;
    for (; fnl_option_query(count, &o); count++) {
        assert_true(strlen(o.help) > 5 && o.shadings && o.lists);
        assert_true(fnl_option_find(o.key, &found) && memcmp(&o, &found, sizeof o) == 0); /* no key stands twice */
        assert_refuses(o.key, "");
        assert_refuses(o.key, "nonsense");
        if (o.kind == FNL_OPTION_SWITCH) {
            assert_takes(o.key, "on");
            assert_takes(o.key, "off");
        }
        for (uint32_t i = 0; o.kind == FNL_OPTION_NAME && (name = fnl_value_name(o.names, i)); i++) assert_takes(o.key, name);
        if (o.kind == FNL_OPTION_COUNT) try_count(&o);
        if (o.kind == FNL_OPTION_NUMBER) try_number(&o);
    }
    assert_true(count > 70);
    assert_false(fnl_option_find("nonsense", NULL));
}

/*
 * Each row has a place of its own, and all of fnl_frame but camera, views, what it points to, outputs, the pixel that is asked for and padding belongs to one: with a value other than the default for
 * each row in turn, no byte is written twice.
 */
static void test_rows_have_their_own_places(void **state) {
    UNUSED(state);
    static unsigned char owner[sizeof(fnl_frame)];
    fnl_option o;
    for (uint32_t i = 0; fnl_option_query(i, &o); i++) {
        fnl_frame zeros, ones;
        memset(&zeros, 0, sizeof zeros);
        memset(&ones, 0xff, sizeof ones);
        const char *value = o.kind == FNL_OPTION_SWITCH ? "on" : o.kind == FNL_OPTION_NAME ? fnl_value_name(o.names, 0) : NULL;
        char text[32];
        if (!value) {
            snprintf(text, sizeof text, "%.9g", o.kind == FNL_OPTION_COUNT && o.choice_count ? o.choices[0] : o.above_low ? 1 : o.high < 1e9 ? o.high : 1);
            value = text;
        }
        assert_int_equal(fnl_frame_set(NULL, &zeros, o.key, value), FNL_OK);
        assert_int_equal(fnl_frame_set(NULL, &ones, o.key, value), FNL_OK);
        uint32_t bytes = 0;
        for (size_t b = 0; b < sizeof zeros; b++) {
            bool written = ((unsigned char *)&zeros)[b] == ((unsigned char *)&ones)[b];
            if (written && owner[b]) fail_msg("%s lies on option %u", o.key, owner[b] - 1);
            if (written) owner[b] = (unsigned char)(i + 1);
            bytes += written;
        }
        assert_int_equal(bytes, o.kind == FNL_OPTION_SWITCH ? sizeof(bool) : 4);
    }
    static const fnl_frame zeroed;
    uint32_t free_bytes = 0;
    for (size_t b = 0; b < sizeof owner; b++) free_bytes += owner[b] == 0;
    const size_t pointers = sizeof zeroed.views + sizeof zeroed.hidden_areas + sizeof zeroed.viewer + sizeof zeroed.gaze + sizeof zeroed.overlay;
    const size_t others = sizeof(fnl_camera) + sizeof zeroed.view_count + pointers + sizeof zeroed.outputs + sizeof(fnl_pixel_query);
    assert_true(free_bytes >= others && free_bytes <= others + 3 * 24); /* at most three bytes of padding behind each switch */
}

static void test_defaults_are_in_range(void **state) {
    UNUSED(state);
    const fnl_host host = quiet_host();
    fnl_frame frame = fnl_frame_default();
    assert_int_equal(options_check(CALL(&host), &frame), FNL_OK);
    char text[4];
    assert_int_equal(fnl_frame_get(&frame, "shading", text, sizeof text), strlen("deferred")); /* cut, but zero-terminated */
    assert_string_equal(text, "def");
    assert_int_equal(fnl_frame_get(&frame, "shading", NULL, 0), strlen("deferred"));
    assert_int_equal(fnl_frame_get(&frame, "nonsense", text, sizeof text), 0);
}

/* Every value of every enum has a name of its own. */
static void test_values_have_names(void **state) {
    UNUSED(state);
    uint32_t value;
    for (uint32_t type = 0; type < FNL_ENUM_COUNT; type++) {
        uint32_t count = value_count((fnl_enum)type);
        assert_true(count > 0 && strncmp(value_type((fnl_enum)type), "fnl_", 4) == 0);
        for (uint32_t i = 0; i < count; i++) {
            const char *name = fnl_value_name((fnl_enum)type, i);
            assert_true(name && fnl_value_find((fnl_enum)type, name, &value) && value == i);
        }
        assert_null(fnl_value_name((fnl_enum)type, count));
        assert_null(fnl_value_name((fnl_enum)type, UINT32_MAX));
        assert_false(fnl_value_find((fnl_enum)type, "nonsense", &value));
    }
    assert_null(fnl_value_name(FNL_ENUM_COUNT, 0));
    assert_null(fnl_value_name((fnl_enum)-1, 0));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_row_takes_its_range),
        cmocka_unit_test(test_rows_have_their_own_places),
        cmocka_unit_test(test_defaults_are_in_range),
        cmocka_unit_test(test_values_have_names),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
