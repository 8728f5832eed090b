/* SPDX-License-Identifier: MIT */
/* The parts of `fanal bench` that need no device: comparing pictures, paths, conclusions, files. */
#include "bench_lane.h"
#include "tests/frame_plain.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

const char program_commit[] = "unknown"; /* of program.h */

static char folder[] = "/tmp/fanal-bench-XXXXXX";

static int make_folder(void **state) {
    (void)state;
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state) {
    static const char *const names[] = {"results.json", "results.csv", "report.html", "path.txt"};
    char path[256];
    (void)state;
    for (int i = 0; i < 4; i++) {
        snprintf(path, sizeof path, "%s/%s", folder, names[i]);
        unlink(path);
    }
    return rmdir(folder);
}

/* ---- pictures ---- */

static void test_pictures_are_compared_bit_by_bit(void **state) {
    (void)state;
    float a[8] = {1, 2, 3, 1, 0, 5, 6, 1}, b[8];
    fnl_image first = {2, 1, FNL_PIXEL_FORMAT_RGBA32F, a}, second = {2, 1, FNL_PIXEL_FORMAT_RGBA32F, b};
    uint64_t differing;
    double max;
    memcpy(b, a, sizeof a);
    bench_picture_compare(&first, &second, &differing, &max);
    assert_int_equal(differing, 0);
    assert_true(max == 0);
    b[5] = nextafterf(5, 6);
    bench_picture_compare(&first, &second, &differing, &max);
    assert_int_equal(differing, 1);
    assert_true(max > 0 && max < 1e-6);
    b[4] = -0.0f; /* equal as a number, but not the same bits */
    b[5] = 5;
    bench_picture_compare(&first, &second, &differing, &max);
    assert_int_equal(differing, 1);
    b[0] = NAN;
    bench_picture_compare(&first, &second, &differing, &max);
    assert_int_equal(differing, 2);
    assert_true(isinf(max));
    second.width = 1;
    bench_picture_compare(&first, &second, &differing, &max);
    assert_int_equal(differing, 2);
}

/* ---- paths ---- */

static bool load_path(const char *text, struct bench_path *path) {
    char file[256];
    fnl_camera base = fnl_camera_default();
    snprintf(file, sizeof file, "%s/path.txt", folder);
    assert_true(bench_save_file(folder, "path.txt", text, strlen(text)));
    return bench_path_create(path, file, NULL, &base, 0, 1);
}

static void test_paths(void **state) {
    (void)state;
    struct bench_path path;
    assert_true(load_path("# comment\n\n  0 1 2 3  4 5 6\n0.5\t-1 2 3 4 5 6 # more\r\n1 7 8 9 1 1 1", &path));
    assert_int_equal(path.count, 3);
    assert_true(path.points[0].eye[1] == 2 && path.points[0].target[2] == 6);
    assert_true(path.points[1].time == 0.5 && path.points[1].eye[0] == -1);
    assert_true(path.points[2].eye[2] == 9);
    assert_true(path.points[2].camera.vertical_fov == fnl_camera_default().vertical_fov);
    bench_path_destroy(&path);
    static const char *const bad[] = {"",
                                      "# nothing\n",
                                      "0 1 2 3 4 5\n",
                                      "0 1 2 3 4 5 6 7\n",
                                      "0 1 2 3 4 5 x\n",
                                      "0 1 2 3 1 2 3\n",
                                      "1 1 2 3 4 5 6\n0 1 2 3 4 5 6\n",
                                      "nan 1 2 3 4 5 6\n",
                                      "0 inf 2 3 4 5 6\n"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) assert_false(load_path(bad[i], &path));
}

/* Circles go once round what the framing camera looks at, at its distance: orbits at its height one way, turntables level the other way. */
static void test_circles(void **state) {
    (void)state;
    struct bench_path orbit, turntable;
    fnl_scene *scene;
    fnl_camera framing;
    assert_int_equal(scene_load_plain(NULL, "builtin:spheres", NULL, &scene), FNL_OK);
    assert_int_equal(fnl_scene_query_framing_camera(scene, 1.5f, &framing), FNL_OK);
    assert_true(bench_path_create(&orbit, "orbit", scene, &framing, 4, 1.5f));
    assert_true(bench_path_create(&turntable, "turntable:8", scene, &framing, 4, 1.5f));
    assert_int_equal(orbit.count, 4);
    assert_int_equal(turntable.count, 8);
    fnl_vec3 center = framing.target, eye = framing.position;
    float x = eye.x - center.x, y = eye.y - center.y, z = eye.z - center.z, near = 1e-4f * (fabsf(x) + fabsf(y) + fabsf(z));
    float scale = hypotf(hypotf(x, z), y) / hypotf(x, z);
    const float quarter[2][3] = {{-z, y, x}, {z * scale, 0, -x * scale}}; /* from the x axis to the z axis, and back */
    for (int i = 0; i < 2; i++) {
        fnl_camera cameras[2], *first = &cameras[0], *next = &cameras[1];
        for (uint32_t k = 0; k < 2; k++) assert_true(bench_path_camera(i ? &turntable : &orbit, scene, i && k ? 2 : k, &cameras[k]));
        assert_float_equal(first->position.x, center.x + (i ? scale : 1) * x, near);
        assert_float_equal(first->position.z, center.z + (i ? scale : 1) * z, near);
        assert_float_equal(first->position.y, center.y + quarter[i][1], near);
        assert_float_equal(next->position.x, center.x + quarter[i][0], near);
        assert_float_equal(next->position.y, center.y + quarter[i][1], near);
        assert_float_equal(next->position.z, center.z + quarter[i][2], near);
        assert_true(next->target.x == center.x && next->target.y == center.y && next->target.z == center.z);
    }
    bench_path_destroy(&orbit);
    bench_path_destroy(&turntable);
    uint32_t count = 7;
    assert_true(bench_path_is_circle("orbit", &count) && count == 7);
    assert_true(bench_path_is_circle("turntable:12", &count) && count == 12);
    static const char *const others[] = {"orbits", "orbit:", "orbit:0", "orbit:x", "orbit:2x", "turntable:-1", "path.txt"};
    for (size_t i = 0; i < sizeof others / sizeof *others; i++) assert_false(bench_path_is_circle(others[i], &count));
    assert_int_equal(count, 12);
    fnl_scene_destroy(&scene);
}

/* ---- results ---- */

static json_t *make_result(const char *lists, double median, double mad, const char *equal) {
    return json_pack("{s:s,s:n,s:i,s:i,s:i,s:s,s:s,s:s,s:i,s:{s:f,s:f,s:f,s:f},s:o,s:i,s:f}", "scene", "a,\"b\".gltf",
                     "asked_lights", "width", 64, "height", 36, "msaa", 1, "shading", "deferred", "lists", lists, "options",
                     "", "lights", 9, "frame_ms", "median", median, "mad", mad, "low", median - mad, "high", median + mad, "equal",
                     strcmp(equal, "yes") == 0  ? json_true()
                     : strcmp(equal, "no") == 0 ? json_false()
                                                : json_null(),
                     "differing_pixels", 7, "max_difference", 0.5);
}

static const char *conclusion(const struct bench_data *data, size_t index) {
    return json_string_value(json_array_get(json_object_get(data->root, "conclusions"), index));
}

static void test_conclusions(void **state) {
    (void)state;
    struct bench_data data = {json_pack("{s:[]}", "results"), json_object()};
    json_t *results = json_object_get(data.root, "results");
    json_array_append_new(results, make_result("tiled", 4, 0.1, "yes"));
    json_array_append_new(results, make_result("clustered", 2, 0.1, "yes"));
    bench_conclude(&data);
    assert_int_equal(json_array_size(json_object_get(data.root, "conclusions")), 1);
    assert_string_equal(conclusion(&data, 0), "On a,\"b\".gltf with 9 lights at 64x36, deferred with clustered lists was fastest: 2 ms, "
                                              "2.00 times as fast as deferred with tiled lists.");
    assert_int_equal(bench_unequal_count(&data), 0);
    /* What the device does not support has not failed. */
    json_object_set_new(data.root, "skipped", json_pack("[{s:s},{s:s,s:b}]", "reason", "not supported", "reason", "memory ran out", "failed", 1));
    assert_int_equal(bench_failed_count(&data), 1);
    /* Brute force is what the others are measured by, wherever it stands. */
    json_array_append_new(results, make_result("brute-force", 250, 0.1, "yes"));
    bench_conclude(&data);
    assert_string_equal(conclusion(&data, 0), "On a,\"b\".gltf with 9 lights at 64x36, deferred with clustered lists was fastest: 2 ms, "
                                              "2.00 times as fast as deferred with tiled lists and 125.00 times as fast as deferred with brute force.");
    json_array_remove(results, 2);
    /* A lead that is less than the spread is none. */
    json_array_append_new(results, make_result("zbin", 2.15, 0.1, "no"));
    bench_conclude(&data);
    assert_non_null(strstr(conclusion(&data, 0), "was fastest: 2 ms. Its lead, 1.07 times as fast as deferred with zbin lists, is within the spread."));
    assert_non_null(strstr(conclusion(&data, 1),
                           "WRONG PICTURE on a,\"b\".gltf with 9 lights at 64x36: with deferred with zbin lists 7 pixels"));
    assert_int_equal(bench_unequal_count(&data), 1);
    /* Another case gets a sentence of its own. */
    json_t *other = make_result("tiled", 800, 0.1, "unknown");
    json_object_set_new(other, "msaa", json_integer(4));
    json_array_append_new(results, other);
    bench_conclude(&data);
    assert_int_equal(json_array_size(json_object_get(data.root, "conclusions")), 3);
    assert_string_equal(conclusion(&data, 1),
                        "On a,\"b\".gltf with 9 lights at 64x36, MSAA 4, deferred with tiled lists alone was measured: 800 ms.");
    assert_int_equal(bench_unequal_count(&data), 1);
    json_decref(data.root);
    json_decref(data.pictures);
}

static json_t *make_counted(const char *lists, const char *options, double frame, double without_lists, int evaluations, int useful) {
    json_t *result = make_result(lists, frame, 0.1, "yes");
    json_object_set_new(result, "options", json_string(options));
    json_object_set_new(result, "without_lists_ms", json_pack("{s:f}", "median", without_lists));
    json_object_set_new(result, "evaluations", json_integer(evaluations));
    json_object_set_new(result, "evaluations_useful", json_integer(useful));
    return result;
}

/* Results that differ in lists alone share an ideal, the least frame without the time of lists, if one of them has perfect lists. */
static void test_ideals_are_of_one_frame(void **state) {
    (void)state;
    struct bench_data data = {json_pack("{s:[]}", "results"), json_object()};
    json_t *results = json_object_get(data.root, "results");
    json_array_append_new(results, make_counted("tiled", "", 12, 10, 300, 100));
    json_array_append_new(results, make_counted("tiled", "tiles.size=8", 15, 9, 200, 100));
    json_array_append_new(results, make_counted("fine", "", 30, 8, 107, 100)); /* a little too many to be perfect */
    json_array_append_new(results, make_counted("tiled", "gbuffer.layout=siege", 20, 5, 300, 100));
    json_array_append_new(results, make_counted("fine", "gbuffer.layout=siege,fine.masks=2", 40, 6, 104, 100));
    bench_add_ideals(&data);
    for (size_t i = 0; i < 3; i++) assert_null(json_object_get(json_array_get(results, i), "ideal_ms"));
    for (size_t i = 3; i < 5; i++) assert_true(bench_number(json_array_get(results, i), "ideal_ms", 0) == 5);
    assert_true(bench_number(json_array_get(results, 4), "over_ideal", 0) == 8);
    json_object_set_new(json_array_get(results, 2), "evaluations", json_integer(105));
    bench_add_ideals(&data);
    static const double over[] = {1.5, 15. / 8, 30. / 8, 4, 8};
    for (size_t i = 0; i < 5; i++) assert_true(bench_number(json_array_get(results, i), "over_ideal", 0) == over[i]);
    bench_conclude(&data);
    assert_non_null(strstr(conclusion(&data, 0), " That is 1.50 times the ideal: the same frame with perfect lists that cost nothing."));
    /* Another path, and another case, have nothing to do with it; what no longer holds goes. */
    json_object_set_new(json_array_get(results, 2), "shading", json_string("forward"));
    json_object_set_new(json_array_get(results, 4), "width", json_integer(65));
    bench_add_ideals(&data);
    for (size_t i = 0; i < 5; i++) assert_true(!json_object_get(json_array_get(results, i), "over_ideal") == !(i == 2 || i == 4));
    json_decref(data.root);
    json_decref(data.pictures);
}

static void test_scenes_go_by_short_names(void **state) {
    (void)state;
    json_t *results = json_pack("[{s:s},{s:s},{s:s},{s:s},{s:s}]", "scene", "/home/me/one/scene.gltf", "scene", "/srv/two/scene.gltf", "scene",
                                "city.glb", "scene", "builtin:hall?lights=4", "scene", "/srv/other.glb");
    static const char *const names[] = {"one/scene.gltf", "two/scene.gltf", "city.glb", "builtin:hall?lights=4", "other.glb"};
    char text[256];
    for (size_t i = 0; i < 5; i++) {
        bench_scene_name(results, json_string_value(json_object_get(json_array_get(results, i), "scene")), text, sizeof text);
        assert_string_equal(text, names[i]);
    }
    json_decref(results);
}

/* ---- how far times can be trusted ---- */

static struct bench_spread spread_of(const double *times, uint32_t count) {
    struct bench_spread spread;
    assert_true(bench_spread_of(times, count, &spread));
    return spread;
}

/* The interval of the median leaves out as many samples at each end as the binomial distribution allows: with 6 none, 9 one, 20 five. */
static void test_intervals_of_medians(void **state) {
    (void)state;
    static const struct {
        uint32_t count, outside;
    } cases[] = {{1, 0}, {4, 0}, {6, 0}, {9, 1}, {10, 1}, {20, 5}, {50, 17}, {100, 39}, {2000, 955}};
    static double times[2000];
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const uint32_t count = cases[i].count;
        for (uint32_t k = 0; k < count; k++) times[k] = (double)(k * 7919u % count); /* all from 0 on, in disorder */
        if (count % 7919 == 0) continue;
        const struct bench_spread s = spread_of(times, count);
        assert_true(s.min == 0 && fabs(s.median - 0.5 * (count - 1)) < 1e-9);
        assert_int_equal((uint32_t)s.low, cases[i].outside);
        assert_int_equal((uint32_t)s.high, count - 1 - cases[i].outside);
    }
    struct bench_spread none;
    assert_false(bench_spread_of(times, 0, &none));
}

/* How many frames, by made-up samples. */
static void test_busy_machines_get_more_frames(void **state) {
    (void)state;
    static const double calm[] = {10, 10.1, 10, 9.9}, wild[] = {10, 10, 10, 25}, loose[] = {10, 11, 12, 13};
    static const double settled[] = {10, 10, 10, 10, 10, 10, 10, 10, 10, 10, 10, 10, 10, 10, 25, 25};
    const struct bench_spread steady = spread_of(calm, 4), unsteady = spread_of(wild, 4), wide = spread_of(loose, 4), known = spread_of(settled, 16);
    assert_true(bench_is_unsteady(&unsteady) && !bench_is_unsteady(&steady) && !bench_is_unsteady(&wide));
    assert_true(bench_is_busy(0.5, 2) && !bench_is_busy(0.5, 16) && !bench_is_busy(0, 1));
    assert_int_equal(bench_frames_wanted(&steady, 2, 4, true), 4);    /* what was asked for in any case */
    assert_int_equal(bench_frames_wanted(&steady, 4, 4, false), 4);
    assert_int_equal(bench_frames_wanted(&steady, 4, 4, true), 4);    /* busy, but the median is known */
    assert_int_equal(bench_frames_wanted(&wide, 4, 4, false), 4);     /* a wide interval alone is few frames */
    assert_int_equal(bench_frames_wanted(&wide, 4, 4, true), 8);
    assert_int_equal(bench_frames_wanted(&unsteady, 4, 4, false), 8);
    assert_int_equal(bench_frames_wanted(&unsteady, 14, 4, false), 16);
    assert_int_equal(bench_frames_wanted(&unsteady, 16, 4, true), 16); /* there is an end */
    assert_true(bench_is_unsteady(&known));
    assert_int_equal(bench_frames_wanted(&known, 12, 4, true), 12);   /* slow ones remain, but the median is known */
}

/* What a reader is told of it; and a lead counts only if the intervals do not overlap. */
static void test_warnings(void **state) {
    (void)state;
    struct bench_data data = {json_pack("{s:[],s:{s:i}}", "results", "machine", "cores", 2), json_object()};
    json_t *results = json_object_get(data.root, "results"), *a = make_result("tiled", 4, 0.1, "yes"), *b = make_result("clustered", 2, 0.1, "yes");
    json_object_update_new(json_object_get(a, "frame_ms"), json_pack("{s:f,s:f,s:f,s:f}", "low", 3.9, "high", 4.1, "p5", 3.9, "p95", 4.2));
    json_object_update_new(json_object_get(b, "frame_ms"), json_pack("{s:f,s:f,s:f,s:f}", "low", 1.9, "high", 2.1, "p5", 1.9, "p95", 2.2));
    json_array_append_new(results, a);
    json_array_append_new(results, b);
    bench_conclude(&data);
    assert_int_equal(json_array_size(json_object_get(data.root, "warnings")), 0);
    assert_true(bench_clear(b, a));
    json_object_set_new(a, "others", json_real(1.25));
    json_object_set_new(json_object_get(b, "frame_ms"), "high", json_real(3.95));
    json_object_set_new(json_object_get(b, "frame_ms"), "p95", json_real(2.9));
    bench_conclude(&data);
    const json_t *warnings = json_object_get(data.root, "warnings");
    assert_int_equal(json_array_size(warnings), 2);
    assert_non_null(strstr(json_string_value(json_array_get(warnings, 0)), "up to 1.2 of its 2 processors"));
    assert_non_null(strstr(json_string_value(json_array_get(warnings, 1)), "In 1 of 2 results"));
    assert_false(bench_clear(b, a));
    json_decref(data.root);
    json_decref(data.pictures);
}

/* With shadows and without are cases of their own, and the headlines say which. */
static void test_shadows_are_cases(void **state) {
    (void)state;
    struct bench_data data = {json_pack("{s:[]}", "results"), json_object()};
    json_t *results = json_object_get(data.root, "results"), *plain = make_result("tiled", 4, 0.1, "yes"), *mapped = make_result("tiled", 9, 0.1, "yes");
    json_object_set_new(mapped, "options", json_string("shadows=maps,tiles.size=8"));
    json_object_set_new(mapped, "settings", json_pack("{s:s,s:s}", "shadows", "maps", "tiles.size", "8"));
    json_array_append_new(results, plain);
    json_array_append_new(results, mapped);
    bench_conclude(&data);
    assert_string_equal(conclusion(&data, 0), "On a,\"b\".gltf with 9 lights at 64x36, without shadows, deferred with tiled lists alone was measured: 4 ms.");
    assert_string_equal(conclusion(&data, 1),
                        "On a,\"b\".gltf with 9 lights at 64x36, shadows by maps, deferred with tiled lists (tiles.size=8) alone was measured: 9 ms.");
    json_decref(data.root);
    json_decref(data.pictures);
    /* Where there are no lights there is nothing to cast them. */
    static const char *const scenes[] = {"builtin:hall"};
    struct bench_matrix m = {.usual_shadows = true, .size_count = 1, .msaa_count = 1, .light_count = 2, .lights = {0, 4}, .shading_count = 1, .lists_count = 1,
                             .shading = {FNL_SHADING_DEFERRED}, .lists = {FNL_LISTS_TILED}, .sizes = {{64, 36}}, .msaa = {1}};
    struct bench_plan plan = {.skipped = json_array()};
    const uint32_t own = 300;
    assert_true(bench_vary_add(&m, "shadows", "shadows", "off,maps"));
    assert_true(bench_plan_matrix(&m, scenes, &own, 1, &plan));
    assert_int_equal(plan.case_count, 2);
    assert_int_equal(plan.cases[0].candidate_count, 1);
    assert_string_equal(plan.cases[0].candidates[0].options, "");
    assert_int_equal(plan.cases[1].candidate_count, 2);
    assert_string_equal(plan.cases[1].candidates[1].options, "shadows=maps");
    bench_plan_free(&plan);
}

/* ---- frames of an earlier run ---- */

static void note_frame(struct lane *lane, double milliseconds) {
    fnl_pass_time passes[] = {{.name = "cull items", .milliseconds = 1, .role = FNL_PASS_GEOMETRY},
                              {.name = "tiled fill", .milliseconds = 3, .role = FNL_PASS_LISTS},
                              {.name = "deferred", .milliseconds = milliseconds, .role = FNL_PASS_SHADING}};
    const fnl_counter counter = {.key = "coarse.shared", .value = 5};
    fnl_frame_stats stats = {
        .passes = passes, .pass_count = 3, .triangles_total = 1000, .evaluations = 7, .counters = &counter, .counter_count = 1};
    if (lane->counted == 0 && !lane->kept) lane_note_counts(lane, &stats);
    lane->wall = milliseconds + 2;
    assert_true(lane_note_times(lane, &stats));
}

/* A lane that was cut off after two of four frames goes on with the third, and ends as one that was not. */
static void test_frames_are_taken_up_again(void **state) {
    (void)state;
    static const double times[] = {4, 10, 6, 5};
    struct bench_case where = {.scene = "a", .width = 8, .height = 8, .msaa = 1};
    struct bench_candidate candidate = {FNL_SHADING_DEFERRED, FNL_LISTS_TILED, ""};
    fnl_scene_info info = {.triangle_count = 1000};
    struct lane whole, first, second;
    assert_true(lane_init(&whole, &where, &candidate, 4) && lane_init(&first, &where, &candidate, 4) && lane_init(&second, &where, &candidate, 4));
    whole.checked = first.checked = 1;
    json_t *a = json_object(), *b = json_object();
    for (int i = 0; i < 4; i++) note_frame(&whole, times[i]);
    for (int i = 0; i < 2; i++) note_frame(&first, times[i]);
    lane_add_result(&whole, a, &info, false, 4);
    lane_add_result(&first, b, &info, false, 4);
    assert_true(json_is_true(json_object_get(a, "complete")) && !json_object_get(a, "samples"));
    assert_int_equal(json_integer_value(json_object_get(json_object_get(a, "counters"), "coarse.shared")), 5);
    assert_true(json_is_false(json_object_get(b, "complete")));
    /* Fewer pictures than asked for were compared: that has to be done again, what was timed stands. */
    lane_restore(&second, b, 3);
    assert_true(second.measured == 2 && !second.kept);
    lane_finish(&second);
    assert_true(lane_init(&second, &where, &candidate, 4));
    lane_restore(&second, b, 1);
    assert_true(second.measured == 2 && second.kept);
    for (int i = 2; i < 4; i++) note_frame(&second, times[i]);
    lane_add_result(&second, b, &info, false, 4);
    assert_true(json_equal(a, b));
    assert_true(fabs(bench_median(b, "gpu_ms") - 9.5) < 1e-9);
    assert_true(fabs(bench_median(b, "without_lists_ms") - 6.5) < 1e-9);
    lane_finish(&second);
    /* Of a result that is complete, of none, or of more frames than are wanted nothing is taken. */
    assert_true(lane_init(&second, &where, &candidate, 2));
    lane_restore(&second, a, 1);
    lane_restore(&second, NULL, 1);
    json_object_set_new(b, "samples", json_pack("{s:[f,f,f]}", "frame_ms", 1.0, 2.0, 3.0));
    lane_restore(&second, b, 1);
    assert_true(second.measured == 0 && !second.kept);
    lane_finish(&first);
    lane_finish(&second);
    lane_finish(&whole);
    json_decref(a);
    json_decref(b);
}

static char *read_file(const char *name) {
    char path[256], *text = calloc(1, 1 << 20);
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    assert_true(fread(text, 1, (1 << 20) - 1, file) > 0);
    fclose(file);
    return text;
}

/* Whether results can be written is tried before hours of measuring: with a file of its own. */
static void test_preparing_the_folder_touches_no_file(void **state) {
    bool made = true;
    char victim[256], link[256];
    (void)state;
    snprintf(victim, sizeof victim, "%s/path.txt", folder);
    snprintf(link, sizeof link, "%s/writable.part", folder);
    FILE *file = fopen(victim, "w");
    assert_non_null(file);
    fputs("precious", file);
    fclose(file);
    assert_int_equal(symlink(victim, link), 0);
    assert_true(bench_prepare_folder(folder, &made));
    assert_false(made);
    char *text = read_file("path.txt");
    assert_string_equal(text, "precious");
    free(text);
    assert_int_equal(unlink(link), 0); /* it is still there */
    assert_int_equal(mkfifo(link, 0600), 0);
    assert_true(bench_prepare_folder(folder, &made));
    assert_int_equal(unlink(link), 0);
    unlink(victim);
    assert_false(bench_prepare_folder("/proc", &made));
}

static void test_files_round_trip(void **state) {
    (void)state;
    json_t *one = make_result("tiled", 4, 0.25, "yes"), *other = make_result("clustered", 4, 0.25, "yes");
    json_object_set_new(one, "counters", json_pack("{s:i,s:b}", "coarse.shared", 765, "mobile.merged", 1));
    json_object_set_new(other, "counters", json_pack("{s:i}", "gbuffer.bytes", 225));
    struct bench_data data = {json_pack("{s:[o,o],s:s}", "results", one, other, "note", "</script><!--"),
                              json_pack("{s:s}", "key", "data:image/png;base64,AAAA")};
    assert_true(bench_save(folder, &data, true));
    char *csv = read_file("results.csv"), *page = read_file("report.html");
    assert_non_null(strstr(csv, "\r\n\"a,\"\"b\"\".gltf\",64,36,1,deferred,tiled,9,"));
    assert_null(strstr(csv, "options"));
    assert_non_null(strstr(csv, ",4,"));
    assert_non_null(strstr(csv, ",0.25,"));
    /* A column for each counter that some result has, in the order of the library. */
    assert_non_null(strstr(csv, ",max_difference,gbuffer.bytes,coarse.shared,mobile.merged\r\n"));
    assert_non_null(strstr(csv, ",,765,true\r\n"));
    assert_non_null(strstr(csv, ",225,,\r\n"));
    assert_null(strstr(page, "</script><!--")); /* nothing of the data ends its element */
    assert_non_null(strstr(page, "\\u003c/script>\\u003c!--"));
    free(csv);
    free(page);
    struct bench_data again;
    assert_true(bench_load(folder, &again));
    assert_true(json_equal(again.root, data.root));
    assert_true(json_equal(again.pictures, data.pictures));
    json_decref(again.root);
    json_decref(again.pictures);
    json_decref(data.root);
    json_decref(data.pictures);
    struct bench_data none;
    assert_true(bench_load("/nowhere", &none));
    assert_null(none.root);
    char path[160]; /* there, but not to be read: what it holds must not be taken for nothing, and then be replaced */
    snprintf(path, sizeof path, "%s/results.json", folder);
    unlink(path);
    assert_int_equal(mkdir(path, 0700), 0);
    assert_false(bench_load(folder, &none));
    rmdir(path);
}

/* ---- ways ---- */

static void test_candidate_options(void **state) {
    (void)state;
    fnl_frame frame = bench_frame();
    char text[1024], ways[1024];
    bench_ways_print(&frame, true, text, sizeof text);
    assert_string_equal(text, "");
    frame.gbuffer.layout = FNL_GBUFFER_SIEGE;
    frame.transparency = FNL_TRANSPARENCY_LINKED;
    frame.deferred.msaa_method = FNL_MSAA_ALL;
    frame.clusters.slices = 16;
    frame.clusters.far = 50;
    frame.occlusion = true;
    frame.coarse.tolerance = 0.1f;
    frame.width = 7; /* of the case, not of the candidate */
    frame.shading = FNL_SHADING_DAIS;
    bench_ways_print(&frame, true, text, sizeof text);
    assert_string_equal(text, "transparency=linked,occlusion=on,clusters.slices=16,clusters.far=50,gbuffer.layout=siege,"
                              "deferred.msaa-method=all,coarse.tolerance=0.1");
    fnl_frame again = bench_frame();
    assert_true(bench_ways_apply("set", text, &again));
    again.width = frame.width;
    again.shading = frame.shading;
    bench_ways_print(&again, true, ways, sizeof ways);
    assert_string_equal(ways, text);
    assert_true(again.coarse.tolerance == 0.1f && again.clusters.far == 50 && isinf(again.clusters.near));
    bench_ways_of(text, ways, sizeof ways); /* what leaves the picture as it is, is left out */
    assert_string_equal(ways, "transparency=linked,gbuffer.layout=siege,deferred.msaa-method=all,coarse.tolerance=0.1");
    assert_false(bench_ways_apply("set", "gbuffer.layout=nonsense", &again));
    assert_false(bench_ways_apply("set", "nonsense=1", &again));
    assert_false(bench_ways_apply("set", "width=8", &again));
    assert_false(bench_ways_apply("set", "decals", &again));
    struct bench_candidate candidate = {FNL_SHADING_DEFERRED, FNL_LISTS_CLUSTERED, (char[]){"occlusion=on,decals=off"}};
    json_t *result = json_object();
    bench_ways_describe(&candidate, result);
    assert_string_equal(json_string_value(json_object_get(result, "ways")), "decals=off");
    assert_string_equal(json_string_value(json_object_get(json_object_get(result, "settings"), "occlusion")), "on");
    assert_int_equal(json_object_size(json_object_get(result, "settings")), 2);
    json_decref(result);
}

static void test_varied_options(void **state) {
    (void)state;
    struct bench_matrix *m = calloc(1, sizeof *m);
    assert_true(bench_vary_add(m, "vary", "tiles.size", "all"));
    assert_int_equal(m->varied[0].count, 4);
    assert_string_equal(m->varied[0].values[3], "64");
    assert_true(bench_vary_add(m, "msaa-method", "deferred.msaa-method", "all")); /* the name of one */
    assert_int_equal(m->varied[1].count, 1);
    assert_true(bench_vary_add(m, "geometry", "geometry", "all")); /* without auto, which is one of the others */
    assert_int_equal(m->varied[2].count, 2);
    assert_true(bench_vary_add(m, "vary", "tiles.size", "8,32")); /* replaces */
    assert_true(m->vary_count == 3 && m->varied[0].count == 2);
    assert_true(bench_vary_add(m, "occlusion", "occlusion", "all"));
    assert_int_equal(m->varied[3].count, 2);
    assert_true(bench_vary_add(m, "vary", "coarse.tolerance", "0,0.5"));
    assert_false(bench_vary_add(m, "vary", "coarse.tolerance", "all"));
    assert_false(bench_vary_add(m, "vary", "coarse.tolerance", "2"));
    assert_false(bench_vary_add(m, "vary", "shading", "deferred"));
    assert_false(bench_vary_add(m, "vary", "nonsense", "1"));
    free(m);
}

static bool heeded(const char *key, const char *value, fnl_shading shading, fnl_light_lists lists, uint32_t msaa) {
    fnl_option option;
    assert_true(bench_ways_find("vary", key, &option));
    return bench_way_heeded(&option, value, shading, lists, msaa);
}

static void test_options_are_heeded(void **state) {
    (void)state;
    const fnl_light_lists tiled = FNL_LISTS_TILED, clustered = FNL_LISTS_CLUSTERED;
    assert_true(heeded("gbuffer.layout", "siege", FNL_SHADING_DEFERRED, tiled, 1));
    assert_true(heeded("gbuffer.layout", "siege", FNL_SHADING_DEFERRED_VOLUMES, tiled, 1));
    assert_false(heeded("gbuffer.layout", "siege", FNL_SHADING_FORWARD, tiled, 1));
    assert_true(heeded("deferred.msaa-method", "all", FNL_SHADING_DEFERRED, tiled, 4));
    assert_false(heeded("deferred.msaa-method", "all", FNL_SHADING_DEFERRED, tiled, 1));
    assert_false(heeded("deferred.msaa-method", "all", FNL_SHADING_FORWARD, tiled, 4));
    assert_true(heeded("decals", "gbuffer", FNL_SHADING_MOBILE, tiled, 1));
    assert_false(heeded("decals", "gbuffer", FNL_SHADING_FORWARD, tiled, 1));
    assert_false(heeded("decals", "gbuffer", FNL_SHADING_DEFERRED, tiled, 4));
    assert_true(heeded("decals", "off", FNL_SHADING_FORWARD, tiled, 4));
    assert_true(heeded("dais.mode", "list", FNL_SHADING_DAIS, tiled, 1));
    assert_false(heeded("dais.multirate", "on", FNL_SHADING_VISIBILITY, tiled, 4));
    assert_true(heeded("visibility.grid", "on", FNL_SHADING_VISIBILITY, tiled, 1));
    assert_false(heeded("visibility.grid", "on", FNL_SHADING_VISIBILITY, tiled, 4));
    assert_false(heeded("transparency", "linked", FNL_SHADING_INFERRED, tiled, 1));
    assert_true(heeded("tiles.size", "8", FNL_SHADING_DEFERRED, tiled, 1));
    assert_false(heeded("tiles.size", "8", FNL_SHADING_DEFERRED, clustered, 1));
    assert_true(heeded("clusters.slices", "8", FNL_SHADING_DEFERRED, clustered, 1));
}

/* ---- the plan ---- */

static bool planned(const struct bench_case *c, fnl_shading shading, fnl_light_lists lists) {
    for (uint32_t i = 0; i < c->candidate_count; i++)
        if (c->candidates[i].shading == shading && c->candidates[i].lists == lists) return true;
    return false;
}

/* Without names: what auto would measure, and brute force with the default order as long as it is affordable. */
static void test_likely_ways_are_those_of_auto(void **state) {
    (void)state;
    static const char *const scenes[] = {"a.glb"};
    static const struct {
        uint32_t own;
        int64_t asked;
    } cases[] = {{0, 0}, {60, 4}, {60, 5}, {96, 4000}, {97, 4000}, {0, 1 << 20}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        struct bench_matrix m = {.light_count = 1, .size_count = 1, .msaa_count = 1, .sizes = {{64, 36}}, .msaa = {1}};
        struct bench_plan plan = {.skipped = json_array()};
        uint32_t count = cases[k].own + (uint32_t)cases[k].asked, wanted = 0;
        m.lights[0] = (uint32_t)cases[k].asked;
        assert_true(bench_plan_matrix(&m, scenes, &cases[k].own, 1, &plan));
        assert_int_equal(plan.case_count, 1);
        assert_true(plan.likely);
        for (uint32_t s = 0; s < FNL_SHADING_COUNT; s++)
            for (uint32_t l = 0; l < FNL_LISTS_COUNT; l++) {
                bool likely = fnl_shading_likely((fnl_shading)s, (fnl_light_lists)l, count, 1) == (FNL_LIKELY_SHADING | FNL_LIKELY_LISTS);
                if (s == FNL_SHADING_DEFERRED && l == FNL_LISTS_ALL) likely = likely || count <= 4096;
                assert_int_equal(planned(plan.cases, (fnl_shading)s, (fnl_light_lists)l), likely);
                wanted += likely;
            }
        assert_int_equal(plan.cases->candidate_count, wanted);
        assert_true(count ? wanted >= 10 && wanted <= 30 : wanted == 3); /* without lights lists do not matter */
        assert_int_equal(json_array_size(plan.skipped), 0);
        bench_plan_free(&plan);
    }
    /* Built-in scenes have as many lights as are asked for, not more. */
    assert_int_equal(bench_scene_lights("builtin:hall", 1024, 16), 16);
    assert_int_equal(bench_scene_lights("builtin:hall", 1024, -1), 1024);
    assert_int_equal(bench_scene_lights("a.glb", 5, 16), 21);
}

/* Names of orders or lists leave the others likely; "all" is every one, where lists make a difference. */
static void test_named_ways_are_planned(void **state) {
    (void)state;
    static const char *const scenes[] = {"builtin:hall"};
    const uint32_t lights[] = {1024};
    struct bench_matrix likely = {.size_count = 1, .msaa_count = 1, .sizes = {{64, 36}}, .msaa = {1}}, m = likely;
    struct bench_plan plan = {.skipped = json_array()};
    m.shading[m.shading_count++] = FNL_SHADING_VISIBILITY;
    m.shading[m.shading_count++] = FNL_SHADING_DEFERRED_VOLUMES;
    assert_true(bench_plan_matrix(&m, scenes, lights, 1, &plan) && plan.likely);
    assert_true(planned(plan.cases, FNL_SHADING_VISIBILITY, FNL_LISTS_ALL) && planned(plan.cases, FNL_SHADING_VISIBILITY, FNL_LISTS_WORLD));
    assert_false(planned(plan.cases, FNL_SHADING_VISIBILITY, FNL_LISTS_MESH) || planned(plan.cases, FNL_SHADING_DEFERRED, FNL_LISTS_TILED));
    uint32_t volumes = 0;
    for (uint32_t l = 0; l < FNL_LISTS_COUNT; l++) volumes += planned(plan.cases, FNL_SHADING_DEFERRED_VOLUMES, (fnl_light_lists)l);
    assert_int_equal(volumes, 1);
    bench_plan_free(&plan);
    m = likely;
    m.lists[m.lists_count++] = FNL_LISTS_MESH;
    plan = (struct bench_plan){.skipped = json_array()};
    assert_true(bench_plan_matrix(&m, scenes, lights, 1, &plan));
    assert_true(planned(plan.cases, FNL_SHADING_FORWARD, FNL_LISTS_MESH) && planned(plan.cases, FNL_SHADING_FORWARD_PREPASS, FNL_LISTS_MESH));
    assert_int_equal(plan.cases->candidate_count, 2);
    bench_plan_free(&plan);
    /* Perfect lists join once where they make a difference; with the options that they heed. */
    m = likely;
    m.ideal = true;
    m.shading[m.shading_count++] = FNL_SHADING_VISIBILITY;
    m.shading[m.shading_count++] = FNL_SHADING_DEFERRED;
    m.shading[m.shading_count++] = FNL_SHADING_DEFERRED_VOLUMES;
    m.lists[m.lists_count++] = FNL_LISTS_TILED;
    for (int twice = 0; twice < 2; twice++) {
        plan = (struct bench_plan){.skipped = json_array()};
        assert_true(bench_plan_matrix(&m, scenes, lights, 1, &plan));
        assert_true(planned(plan.cases, FNL_SHADING_VISIBILITY, FNL_LISTS_FINE) && planned(plan.cases, FNL_SHADING_DEFERRED, FNL_LISTS_FINE));
        assert_int_equal(planned(plan.cases, FNL_SHADING_DEFERRED_VOLUMES, FNL_LISTS_FINE), twice);
        assert_int_equal(plan.cases->candidate_count, 5 + twice);
        bench_plan_free(&plan);
        m.lists[m.lists_count++] = FNL_LISTS_FINE; /* named, it is planned already */
    }
    m = likely;
    m.every_shading = m.every_lists = true;
    plan = (struct bench_plan){.skipped = json_array()};
    assert_true(bench_plan_matrix(&m, scenes, lights, 1, &plan) && !plan.likely);
    for (uint32_t s = 0; s < FNL_SHADING_AUTO; s++) assert_true(planned(plan.cases, (fnl_shading)s, FNL_LISTS_ALL));
    for (uint32_t l = 0; l < FNL_LISTS_AUTO; l++) assert_true(planned(plan.cases, FNL_SHADING_FORWARD_PREPASS, (fnl_light_lists)l));
    assert_true(plan.cases->candidate_count > 150);
    bench_plan_free(&plan);
}

/* ---- suites ---- */

/* A suite's candidates, all with the same numbers: every ratio is 1, wherever it stands. */
static void test_suites(void **state) {
    (void)state;
    for (int s = 0; bench_suite_name(s); s++) {
        const struct bench_suite *suite = bench_suite_find(bench_suite_name(s));
        struct bench_plan plan = {.skipped = json_array()};
        struct bench_data data = {json_pack("{s:[]}", "results"), NULL};
        assert_non_null(suite);
        assert_true(bench_suite_plan(suite, 0, 0, &plan));
        if (bench_suite_kind_of(suite) != BENCH_SUITE_RATIOS) {
            assert_int_equal(plan.case_count, 0);
            bench_plan_free(&plan);
            json_decref(data.root);
            continue;
        }
        assert_true(plan.case_count > 0);
        for (uint32_t c = 0; c < plan.case_count; c++) {
            struct bench_case *at = &plan.cases[c];
            assert_true(at->width >= 1280);
            for (uint32_t i = 0; i < at->candidate_count; i++) {
                json_t *result = bench_key(at, &at->candidates[i]), *passes = json_array();
                static const char *const times[] = {"gpu_ms", "lists_ms", "shading_ms"};
                for (int t = 0; t < 3; t++)
                    json_object_set_new(result, times[t], json_pack("{s:f,s:f,s:f}", "median", 2.0, "mad", 0.0, "p95", 5.0));
                json_object_set_new(result, "per_pixel", json_real(3));
                json_object_set_new(result, "list_used_bytes", json_integer(64));
                json_array_append_new(passes,
                                      json_pack("{s:s,s:s,s:f,s:f}", "name", "raster shell", "role", "lists", "median", 1.0, "mad", 0.5));
                json_array_append_new(passes,
                                      json_pack("{s:s,s:s,s:f,s:f}", "name", "raster fill", "role", "lists", "median", 1.0, "mad", 0.5));
                json_object_set_new(result, "passes", passes);
                json_array_append_new(json_object_get(data.root, "results"), result);
                assert_true(bench_find(&data, at, &at->candidates[i]) == result);
            }
        }
        if (strcmp(bench_suite_name(s), "rtr20") == 0) assert_int_equal(json_array_size(plan.skipped), 0);
        bench_suite_conclude(suite, 0, 0, &data);
        const json_t *row;
        size_t i;
        json_array_foreach(json_object_get(json_object_get(data.root, "suite"), "rows"), i, row) {
            assert_true(json_is_string(json_object_get(row, "quantity")));
            const char *verdict = json_string_value(json_object_get(row, "verdict"));
            bool least = strcmp(json_string_value(json_object_get(row, "comparison")), ">=") == 0;
            double limit = bench_number(row, "limit", NAN), ours = bench_number(row, "ours", NAN);
            if (strcmp(verdict, "not measured") == 0) continue; /* where a pair is left out */
            assert_true(fabs(ours - 1) < 1e-9);
            const char *quantity = json_string_value(json_object_get(row, "quantity"));
            bool passes = strncmp(quantity, "fill", 4) == 0 || strncmp(quantity, "shell", 5) == 0; /* off by a half on both sides */
            assert_true(fabs(bench_number(row, "spread", NAN) - passes) < 1e-9);
            if (!isnan(limit) && fabs(limit - 1) >= passes)
                assert_string_equal(verdict, (least ? 1 >= limit : 1 <= limit) ? "reached" : "missed");
        }
        assert_true(i >= 4);
        bench_plan_free(&plan);
        json_decref(data.root);
    }
    assert_null(bench_suite_find("nonsense"));
}

/* A ratio that is nearer to its bound than what it may be off by is not decided; the headline counts. */
static void test_verdicts_heed_the_spread(void **state) {
    (void)state;
    assert_string_equal(bench_verdict(1.2, 0.1, 1, true), "reached");
    assert_string_equal(bench_verdict(1.2, 0.3, 1, true), "undecided");
    assert_string_equal(bench_verdict(0.8, 0.3, 1, true), "undecided");
    assert_string_equal(bench_verdict(0.8, 0.1, 1, true), "missed");
    assert_string_equal(bench_verdict(0.8, 0.1, 1, false), "reached");
    assert_string_equal(bench_verdict(1, 0, 1, false), "reached");
    const struct bench_suite *suite = bench_suite_find("fine-pruned");
    struct bench_plan plan = {.skipped = json_array()};
    struct bench_data data = {json_pack("{s:[],s:{s:s}}", "results", "device", "type", fnl_value_name(FNL_ENUM_DEVICE_TYPE, FNL_DEVICE_CPU)), NULL};
    assert_true(bench_suite_plan(suite, 0, 0, &plan));
    assert_int_equal(plan.case_count, 3);
    for (uint32_t c = 0; c < plan.case_count; c++)
        for (uint32_t i = 0; i < plan.cases[c].candidate_count; i++) {
            /* Lighting takes 5 to 1 (at least 3.86), both together 6 to 4 (at least 1.64), building 3 to 1 (at most 3.4): within a thousandth with 40
               lights, within three tenths with 80; with 120 the pictures are wrong. */
            bool coarse = strstr(plan.cases[c].candidates[i].options, "off") != NULL;
            double mad = c == 1 ? 0.3 : 0.001;
            json_t *result = bench_key(&plan.cases[c], &plan.cases[c].candidates[i]);
            json_object_set_new(result, "shading_ms", json_pack("{s:f,s:f}", "median", coarse ? 5.0 : 1.0, "mad", coarse ? 5 * mad : mad));
            json_object_set_new(result, "lists_ms", json_pack("{s:f,s:f}", "median", coarse ? 1.0 : 3.0, "mad", coarse ? mad : 3 * mad));
            json_object_set_new(result, "per_pixel", json_real(3));
            json_object_set_new(result, "equal", json_boolean(c != 2));
            json_array_append_new(json_object_get(data.root, "results"), result);
        }
    bench_suite_conclude(suite, 0, 0, &data);
    const json_t *found = json_object_get(data.root, "suite"), *row;
    static const char *const verdicts[] = {"reached",   "missed",        "reached",       "no number in the source", "undecided", "undecided",
                                           "undecided", "no number in the source", "wrong picture", "wrong picture", "wrong picture"};
    size_t i;
    json_array_foreach(json_object_get(found, "rows"), i, row) {
        if (i < 11) assert_string_equal(json_string_value(json_object_get(row, "verdict")), verdicts[i]);
    }
    assert_string_equal(json_string_value(json_object_get(found, "headline")),
                        "2 of 9 ratios reached, 1 missed, 3 undecided: within the spread, 3 of wrong pictures.");
    assert_non_null(strstr(json_string_value(json_object_get(found, "warning")), "is a CPU"));
    json_object_set_new(json_object_get(data.root, "device"), "type", json_string(fnl_value_name(FNL_ENUM_DEVICE_TYPE, FNL_DEVICE_DISCRETE)));
    bench_suite_conclude(suite, 0, 0, &data);
    assert_null(json_object_get(json_object_get(data.root, "suite"), "warning"));
    bench_plan_free(&plan);
    json_decref(data.root);
}

/* Where triangles become smaller dais falls behind: between 8 and 2 samples to one in the series, at no place in the other size. */
static void test_crossing_DI_15(void **state) {
    (void)state;
    json_t *rows = json_array();
    static const struct {
        const char *series;
        int width;
        double samples, ratio;
    } values[] = {{"a", 64, 99, 1.1}, {"a", 64, 32, 0.5}, {"b", 64, 20, 4}, {"a", 32, 9, 0.9}, {"a", 64, 8, 0.5}, {"a", 64, 2, 2}, {"a", 32, 3, 0.95}};
    for (size_t i = 0; i < sizeof values / sizeof *values; i++)
        json_array_append_new(rows, json_pack("{s:s,s:i,s:i,s:f,s:f}", "series", values[i].series, "width", values[i].width, "msaa",
                                              4, "samples_per_triangle", values[i].samples, "ratio", values[i].ratio));
    assert_true(fabs(bench_dais_crossing(rows, json_array_get(rows, 0), "ratio") - 4) < 1e-9); /* half of the way, in logarithms */
    assert_true(isnan(bench_dais_crossing(rows, json_array_get(rows, 3), "ratio")));
    assert_true(isnan(bench_dais_crossing(rows, json_array_get(rows, 2), "ratio")));
    json_decref(rows);
}

/* At a quarter of the size as many clusters: they shrink along. */
/* The four pipelines of the textbook, each with numbers of its own, in the columns where they belong. */
static void test_table_of_pipelines(void **state) {
    (void)state;
    const struct bench_suite *suite = bench_suite_find("rtr20");
    struct bench_plan plan = {.skipped = json_array()};
    struct bench_data data = {json_pack("{s:[]}", "results"), NULL};
    assert_string_equal(bench_suite_camera_path(suite), "orbit");
    assert_null(bench_suite_camera_path(bench_suite_find("thesis")));
    assert_true(bench_suite_plan(suite, 100, 50, &plan));
    for (uint32_t c = 0; c < plan.case_count; c++)
        for (uint32_t i = 0; i < plan.cases[c].candidate_count; i++) {
            const struct bench_case *at = &plan.cases[c];
            json_t *result = bench_key(at, &at->candidates[i]);
            const double time = (strstr(at->scene, "decals") ? 3 : strstr(at->scene, "triangles") ? 7 : 2) * at->msaa + at->candidates[i].shading;
            json_object_set_new(result, "gpu_ms", json_pack("{s:f,s:f,s:f}", "median", time, "mad", 0.0, "p95", 1.5 * time));
            json_object_set_new(result, "per_pixel", json_real(at->candidates[i].shading + 0.5));
            json_object_set_new(result, "image_bytes_read", json_integer(5000 * at->candidates[i].shading));
            json_object_set_new(result, "image_bytes_written", json_integer(20000));
            json_object_set_new(result, "passes", json_pack("[{},{},{}]"));
            json_array_append_new(json_object_get(data.root, "results"), result);
        }
    bench_suite_conclude(suite, 100, 50, &data);
    const json_t *table = json_array_get(json_object_get(data.root, "tables"), 0), *rows = json_object_get(table, "rows");
    const fnl_shading shadings[] = {FNL_SHADING_FORWARD, FNL_SHADING_DEFERRED_VOLUMES, FNL_SHADING_DEFERRED, FNL_SHADING_FORWARD_PREPASS};
    assert_int_equal(json_array_size(rows), 7);
    for (uint32_t p = 0; p < 4; p++) {
        const double s = shadings[p], plain = 2 + s, expected[] = {3, s + 0.5, 0, s + 4, (8 + s) / plain, (7 + s) / plain, (3 + s) / plain};
        for (size_t r = 0; r < 7; r++) {
            const double found = json_number_value(json_array_get(json_array_get(rows, r), p + 1));
            if (!(fabs(found - expected[r]) < 1e-9)) fail_msg("pipeline %u, row %zu: %g, not %g", p, r, found, expected[r]);
        }
    }
    bench_plan_free(&plan);
    json_decref(data.root);
}

/* Ratios of times, and what becomes of one that was not measured. */
static void test_table_of_stereo(void **state) {
    (void)state;
    struct bench_data data = {json_pack("{s:[{s:f,s:f},{s:f,s:f},{s:f,s:f},{s:f,s:f}]}", "stereo", "gpu_ms", 10.0, "mad", 0.1, "gpu_ms", 18.0, "mad", 0.1, "gpu_ms",
                                        16.0, "mad", 0.1, "gpu_ms", 13.0, "mad", 0.1), NULL};
    static const double ratios[] = {1.8, 16 / 18.0, 13 / 16.0, 1.6};
    static const char *const verdicts[] = {"reached", "reached", "missed", "reached"};
    json_t *tables = json_array();
    bench_table_stereo(&data, tables);
    const json_t *rows = json_object_get(json_array_get(tables, 0), "rows");
    assert_int_equal(json_array_size(rows), 4);
    for (size_t i = 0; i < 4; i++) {
        const json_t *row = json_array_get(rows, i);
        assert_true(fabs(json_number_value(json_array_get(row, 2)) - ratios[i]) < 1e-9);
        assert_string_equal(json_string_value(json_array_get(row, 4)), verdicts[i]);
    }
    json_array_remove(json_object_get(data.root, "stereo"), 3);
    json_decref(tables);
    tables = json_array();
    bench_table_stereo(&data, tables);
    assert_int_equal(json_array_size(json_object_get(json_array_get(tables, 0), "rows")), 3);
    json_decref(tables);
    json_decref(data.root);
}

static void test_suites_scale_their_clusters(void **state) {
    (void)state;
    struct bench_plan plan = {.skipped = json_array()};
    assert_true(bench_suite_plan(bench_suite_find("clustered"), 384, 192, &plan));
    uint32_t coarse = 0, fine = 0;
    for (uint32_t c = 0; c < plan.case_count; c++)
        for (uint32_t i = 0; i < plan.cases[c].candidate_count; i++) {
            const char *options = plan.cases[c].candidates[i].options;
            coarse += strncmp(options, "clusters.size=16,clusters.slices=", 33) == 0;
            fine += strncmp(options, "clusters.size=8,clusters.slices=", 32) == 0;
            assert_null(strstr(options, "clusters.size=64"));
        }
    assert_int_equal(coarse, 19);
    assert_int_equal(fine, 19);
    bench_plan_free(&plan);
}

/* ---- tables ---- */

struct measured {
    const char *scene, *shading, *options;
    int width, msaa, triangles, drawn;
    double frame, mad, pass;
    const char *pass_name;
};

static void add_measured(json_t *results, const struct measured *m) {
    json_array_append_new(
        results, json_pack("{s:s,s:n,s:i,s:i,s:i,s:s,s:s,s:s,s:i,s:i,s:f,s:f,s:{s:f,s:f,s:f,s:f},s:{s:f,s:f},s:[{s:s,s:f}]}", "scene", m->scene,
                           "asked_lights", "width", m->width, "height", m->width / 2, "msaa", m->msaa, "shading", m->shading,
                           "lists", "clustered", "options", m->options, "triangles", m->triangles, "triangles_drawn", m->drawn,
                           "triangles_culled_share", 1 - (double)m->drawn / m->triangles, "triangles_per_second",
                           1000 / m->frame * m->triangles, "frame_ms", "median", m->frame, "mad", m->mad, "low", m->frame - m->mad, "high", m->frame + m->mad, "geometry_ms", "median",
                           m->frame / 2, "mad", 0.0, "passes", "name", m->pass_name, "median", m->pass));
}

static const json_t *cell(const json_t *table, size_t row, const char *column) {
    const json_t *name;
    size_t i;
    json_array_foreach(json_object_get(table, "columns"), i, name) {
        if (strcmp(json_string_value(name), column) == 0)
            return json_array_get(json_array_get(json_object_get(table, "rows"), row), i);
    }
    fail_msg("no column %s", column);
    return NULL;
}
static const char *line_of(const json_t *table, size_t index) {
    return json_string_value(json_array_get(json_object_get(table, "lines"), index));
}

static void test_geometry_is_set_against_triangles(void **state) {
    (void)state;
    static const struct measured measured[] = {
        {"small", "visibility", "", 64, 1, 1000, 500, 4, 0.1, 1, "visibility"},
        {"small", "visibility", "cull=triangles", 64, 1, 1000, 100, 2, 0.1, 1, "visibility"},
        {"great", "visibility", "", 64, 1, 9000, 4000, 20, 0.1, 1, "visibility"},
        {"great", "visibility", "cull=triangles", 64, 1, 9000, 150, 3, 0.6, 1, "visibility"}};
    struct bench_data data = {json_pack("{s:[]}", "results"), NULL};
    for (int i = 0; i < 4; i++) add_measured(json_object_get(data.root, "results"), &measured[i]);
    json_t *tables = json_array();
    bench_table_geometry(&data, tables);
    const json_t *table = json_array_get(tables, 0);
    assert_int_equal(json_array_size(json_object_get(table, "rows")), 4);
    assert_string_equal(json_string_value(cell(table, 1, "<drawn by")), "visibility (cull=triangles)");
    assert_int_equal(json_integer_value(cell(table, 3, "triangles")), 9000);
    assert_int_equal(json_integer_value(cell(table, 3, "drawn")), 150);
    assert_true(fabs(json_real_value(cell(table, 1, "culled, %")) - 90) < 1e-9);
    assert_true(fabs(json_real_value(cell(table, 2, "million triangles/s")) - 0.45) < 1e-9); /* 9000 in 20 ms */
    assert_true(fabs(json_real_value(cell(table, 1, "ns/drawn")) - 1e4) < 1e-6);             /* 1 ms for 100 */
    assert_int_equal(json_array_size(json_object_get(table, "lines")), 2);
    assert_string_equal(line_of(table, 0),
                        "visibility: 9 times the triangles, 8 times those drawn, 5 times the frame's time.");
    assert_string_equal(line_of(table, 1), "visibility (cull=triangles): 9 times the triangles, 1.5 times those drawn, 1.5 "
                                           "times the frame's time (unsettled: times spread by 20 %).");
    json_decref(tables);
    json_decref(data.root);
}

static void test_orders_are_told_where_they_win(void **state) {
    (void)state;
    static const struct measured measured[] = {
        {"builtin:hall?overdraw=1", "deferred", "", 64, 1, 10, 10, 4, 0.1, 2, "gbuffer"},
        {"builtin:hall?overdraw=1", "visibility", "", 64, 1, 10, 10, 2, 0.1, 1, "visibility"},
        {"builtin:hall?overdraw=1", "deferred", "", 128, 1, 10, 10, 4, 0.1, 2, "gbuffer"},
        {"builtin:hall?overdraw=1", "visibility", "", 128, 1, 10, 10, 4.1, 0.1, 1.3, "visibility"},
        {"builtin:hall?overdraw=1", "deferred", "", 128, 4, 10, 10, 4, 0.1, 2, "gbuffer"}};
    struct bench_data data = {json_pack("{s:[]}", "results"), NULL};
    for (int i = 0; i < 5; i++) add_measured(json_object_get(data.root, "results"), &measured[i]);
    json_t *tables = json_array();
    bench_table_orders(&data, tables);
    const json_t *orders = json_array_get(tables, 0), *ids = json_array_get(tables, 1);
    assert_int_equal(json_array_size(json_object_get(orders, "rows")), 3);
    assert_true(fabs(json_real_value(cell(orders, 0, "deferred")) - 4) < 1e-9);
    assert_string_equal(json_string_value(cell(orders, 0, "<fastest")), "visibility");
    assert_true(fabs(json_real_value(cell(orders, 0, "lead")) - 2) < 1e-9);
    assert_string_equal(json_string_value(cell(orders, 0, "<")), "");
    assert_string_equal(json_string_value(cell(orders, 1, "<")), "within the spread");
    assert_true(json_is_null(cell(orders, 2, "visibility")));
    assert_string_equal(line_of(orders, 0), "deferred wins 2 of 3: builtin:hall?overdraw=1 128x64 1x (within the spread), "
                                            "builtin:hall?overdraw=1 128x64 4x.");
    assert_string_equal(line_of(orders, 1), "visibility wins 1 of 3: builtin:hall?overdraw=1 64x32 1x.");
    assert_int_equal(json_array_size(json_object_get(ids, "rows")), 2);
    assert_true(fabs(json_real_value(cell(ids, 0, "ratio")) - 0.5) < 1e-9);
    assert_string_equal(json_string_value(cell(ids, 0, "<verdict")), "reached");
    assert_string_equal(json_string_value(cell(ids, 1, "<verdict")), "missed");
    json_decref(tables);
    json_decref(data.root);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_pictures_are_compared_bit_by_bit),
        cmocka_unit_test(test_paths),
                                       cmocka_unit_test(test_circles),
        cmocka_unit_test(test_conclusions),
        cmocka_unit_test(test_intervals_of_medians),
        cmocka_unit_test(test_busy_machines_get_more_frames),
        cmocka_unit_test(test_warnings),
        cmocka_unit_test(test_shadows_are_cases),
        cmocka_unit_test(test_ideals_are_of_one_frame),
        cmocka_unit_test(test_preparing_the_folder_touches_no_file),
        cmocka_unit_test(test_files_round_trip),
        cmocka_unit_test(test_candidate_options),
        cmocka_unit_test(test_varied_options),
        cmocka_unit_test(test_options_are_heeded),
        cmocka_unit_test(test_scenes_go_by_short_names),
        cmocka_unit_test(test_frames_are_taken_up_again),
        cmocka_unit_test(test_likely_ways_are_those_of_auto),
        cmocka_unit_test(test_named_ways_are_planned),
        cmocka_unit_test(test_suites),
        cmocka_unit_test(test_table_of_pipelines),
        cmocka_unit_test(test_table_of_stereo),
        cmocka_unit_test(test_verdicts_heed_the_spread),
        cmocka_unit_test(test_crossing_DI_15),
        cmocka_unit_test(test_suites_scale_their_clusters),
        cmocka_unit_test(test_geometry_is_set_against_triangles),
        cmocka_unit_test(test_orders_are_told_where_they_win),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
