/* SPDX-License-Identifier: MIT */
/* Numbers in options, files and messages are the same in a program whose locale has a decimal comma. */
#include "tests/comma_locale.h"

#include "base/file.h"
#include "fanal/fanal.h"
#include "image/image.h"
#include "render/chooser.h"
#include "scene/scene.h"

#include <setjmp.h>
#include <unistd.h>

#include <cmocka.h>

static char folder[64], last_line[2048];

static void keep_line(void *user, fnl_log_level level, const char *line) {
    UNUSED(user);
    if (level >= FNL_LOG_WARNING) snprintf(last_line, sizeof last_line, "%s", line);
}

static fnl_host quiet_host(void) {
    fnl_host host = fnl_host_default();
    host.log = keep_line;
    last_line[0] = 0;
    return host;
}

static void set_locale(bool comma) { assert_true(comma ? comma_locale_set(folder) : setlocale(LC_NUMERIC, "C") != NULL); }

static void test_numbers(void **state) {
    UNUSED(state);
    char text[64], *end;
    snprintf(text, sizeof text, "%g", 1.5);
    assert_string_equal(text, "1,5"); /* C's own functions do it */
    assert_int_equal(text_format(text, sizeof text, "%g %.2f", 0.05, 3.0), 9);
    assert_string_equal(text, "0.05 3.00");
    assert_true(number_read("15.5,7", &end) == 15.5);
    assert_string_equal(end, ",7");
    snprintf(text, sizeof text, "%g", 1.5);
    assert_string_equal(text, "1,5"); /* the program's locale is as it was */
}

static void test_options_are_set_and_got(void **state) {
    UNUSED(state);
    const fnl_host host = quiet_host();
    fnl_option o;
    uint32_t fractions = 0;
    for (uint32_t i = 0; fnl_option_query(i, &o); i++) {
        fnl_frame frame = fnl_frame_default();
        char point[64], comma[64], again[64];
        const double middle = o.high < 1e6 && o.low > -1e6 ? (o.low + o.high) / 2 + 0.0625 : 0;
        if (o.kind != FNL_OPTION_NUMBER) continue;
        set_locale(false);
        fnl_frame_get(&frame, o.key, point, sizeof point);
        if (middle > o.low && middle < o.high) snprintf(point, sizeof point, "%.9g", middle);
        set_locale(true);
        if (fnl_frame_set(&host, &frame, o.key, point) != FNL_OK) fail_msg("%s=%s: %s", o.key, point, last_line);
        fnl_frame_get(&frame, o.key, comma, sizeof comma);
        assert_null(strchr(comma, ','));
        fractions += strchr(comma, '.') != NULL;
        assert_int_equal(fnl_frame_set(&host, &frame, o.key, comma), FNL_OK);
        fnl_frame_get(&frame, o.key, again, sizeof again);
        assert_string_equal(again, comma);
    }
    assert_true(fractions > 10);
    fnl_frame frame = fnl_frame_default();
    assert_int_equal(fnl_frame_set(&host, &frame, "ev", "15.5"), FNL_OK);
    assert_true(frame.ev == 15.5f);
    assert_int_equal(fnl_frame_set(&host, &frame, "ev", "15,5"), FNL_ERROR_INVALID);
}

static void test_photometric_file(void **state) {
    UNUSED(state);
    static const char text[] = "IESNA:LM-63-2002\nTILT=NONE\n1 -1 2.5 2 1 1 2 0 0 0\n1.0 1 0\n0 90.0\n0\n100.5 0\n";
    const fnl_host host = quiet_host();
    fnl_scene *scene = NULL;
    fnl_light_profile_id id;
    float candela = 0;
    assert_int_equal(fnl_scene_create(&host, &scene), FNL_OK);
    if (fnl_scene_add_light_profile(scene, "lamp.ies", text, strlen(text), &id, &candela) != FNL_OK) fail_msg("%s", last_line);
    assert_true(candela == 251.25f);
    fnl_scene_destroy(&scene);
}

static void test_radiance_file(void **state) {
    UNUSED(state);
    static const char text[] = "#?RADIANCE\nEXPOSURE=0.5\n\n-Y 1 +X 1\n\x80\x80\x80\x81";
    const fnl_host host = quiet_host();
    fnl_image image;
    float red;
    if (image_decode(&host, text, sizeof text - 1, "a.hdr", false, &image) != FNL_OK) fail_msg("%s", last_line);
    memcpy(&red, image.pixels, sizeof red);
    assert_true(red == 2);
    fnl_image_free(&host, &image);
}

/* glTF is JSON: read, written, and read again. */
static void test_scene_file(void **state) {
    UNUSED(state);
    static const char text[] = "{\"asset\": {\"version\": \"2.0\"}, \"scene\": 0, \"scenes\": [{\"nodes\": [0]}], \"nodes\": [{\"camera\": 0, \"translation\": [0.1, 2.25, -1e-3]}],"
                               "\"cameras\": [{\"type\": \"perspective\", \"perspective\": {\"yfov\": 0.7, \"znear\": 0.05}}]}";
    const fnl_host host = quiet_host();
    char path[128], saved[128];
    snprintf(path, sizeof path, "%s/a.gltf", folder);
    snprintf(saved, sizeof saved, "%s/b.glb", folder);
    assert_int_equal(file_save(&host, path, text, strlen(text)), FNL_OK);
    for (int i = 0; i < 2; i++) {
        fnl_scene *scene = NULL;
        fnl_camera camera;
        if (fnl_scene_load(&host, i ? saved : path, NULL, &scene) != FNL_OK) fail_msg("%s", last_line);
        assert_int_equal(fnl_scene_query_camera(scene, 0, &camera), FNL_OK);
        assert_true(camera.vertical_fov == 0.7f && camera.near_distance == 0.05f);
        assert_true(camera.position.x == 0.1f && camera.position.y == 2.25f && camera.position.z == -1e-3f);
        fnl_light_id light;
        fnl_light_params lamp = fnl_light_params_default();
        lamp.intensity = 12.5f;
        assert_int_equal(fnl_scene_add_light(scene, &lamp, &light), FNL_OK);
        if (fnl_scene_save(scene, saved, NULL) != FNL_OK) fail_msg("%s", last_line);
        fnl_scene_destroy(&scene);
    }
    unlink(path);
    unlink(saved);
}

static void test_builtin_numbers(void **state) {
    UNUSED(state);
    const fnl_host host = quiet_host();
    fnl_scene *scene = NULL;
    fnl_environment_params sky = fnl_environment_params_default();
    sky.source = "builtin:sky?elevation=40.5&turbidity=2.5";
    assert_int_equal(fnl_scene_create(&host, &scene), FNL_OK);
    if (fnl_scene_set_environment(scene, &sky) != FNL_OK) fail_msg("%s", last_line);
    fnl_scene_destroy(&scene);
}

/* What auto has measured is remembered in a file. */
static void test_remembered_times(void **state) {
    UNUSED(state);
    static const char text[] = "000000000000000c deferred tiled 0.2500\ntrial 000000000000000d forward tiled 0.2500 1.5000\n";
    static struct chooser c;
    char printed[256];
    chooser_parse(&c, text, strlen(text));
    assert_int_equal(c.memory_count, 1);
    assert_true(c.memory[0].milliseconds == 0.25);
    assert_int_equal(c.trial_count, 1);
    assert_int_equal(c.trials[0].count, 2);
    assert_int_equal(chooser_print(&c, printed, sizeof printed), strlen(text));
    assert_string_equal(printed, text);
}

static void test_messages(void **state) {
    UNUSED(state);
    const fnl_host host = quiet_host();
    fnl_frame frame = fnl_frame_default();
    assert_int_equal(fnl_frame_set(&host, &frame, "ev", "1000.5"), FNL_ERROR_INVALID);
    assert_non_null(strstr(last_line, "1000.5"));
}

static int make_folder(void **state) {
    UNUSED(state);
    strcpy(folder, "/tmp/fanal-locale-XXXXXX");
    return mkdtemp(folder) && comma_locale_set(folder) ? 0 : -1;
}

static int remove_folder(void **state) {
    UNUSED(state);
    char path[128];
    snprintf(path, sizeof path, "%s/comma/LC_NUMERIC", folder);
    unlink(path);
    snprintf(path, sizeof path, "%s/comma", folder);
    rmdir(path);
    return rmdir(folder); /* nothing else was left */
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_numbers),       cmocka_unit_test(test_options_are_set_and_got), cmocka_unit_test(test_photometric_file),
        cmocka_unit_test(test_radiance_file), cmocka_unit_test(test_scene_file),              cmocka_unit_test(test_builtin_numbers),
        cmocka_unit_test(test_remembered_times), cmocka_unit_test(test_messages),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
