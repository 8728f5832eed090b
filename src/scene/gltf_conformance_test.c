/* SPDX-License-Identifier: MIT */
/*
 * Loads the files of ../shared/scenes/gltf-conformance and compares with the verdicts of the
 * reference validator that stand beside them: every error about something that is used must come as an error or a warning
 * with the same JSON pointer, and what has no such error must load.
 */
#include "scene/scene.h"

#include <ftw.h>
#include <jansson.h>
#include <setjmp.h>
#include <unistd.h>

#include <cmocka.h>

#define FOLDER "../shared/scenes/gltf-conformance"

/** Errors that do not concern what is read; `pointer_part` narrows a code down to some pointers. */
static const struct {
    const char *code, *pointer_part, *reason;
} not_concerning[] = {
    /* The only file with this code needs the tangents for a clearcoat normal map; clearcoat is ignored. */
    {"MESH_PRIMITIVE_NO_TANGENT_SPACE", "/meshes/", "tangents are generated"},
};

/** Valid files whose data nobody can have: to load them would show nothing at all. */
static const struct {
    const char *path, *reason;
} without_data[] = {
    {"/base/data/buffer/non_relative_uri.gltf", "http:"},
    {"/base/data/root/unused_objects.gltf", "a primitive reads from a placeholder"},
};

static bool has_no_data(const char *path) {
    bool found = false;
    for (uint32_t i = 0; i < COUNT_OF(without_data); i++) found |= strstr(path, without_data[i].path) != NULL;
    return found;
}

struct log {
    char text[64][2400];
    uint32_t count;
};

static void keep_line(void *user, fnl_log_level level, const char *line) {
    struct log *log = user;
    if (level >= FNL_LOG_WARNING && log->count < COUNT_OF(log->text))
        snprintf(log->text[log->count++], sizeof log->text[0], "%s", line);
}

static bool concerns_us(const char *code, const char *pointer) {
    for (uint32_t i = 0; i < COUNT_OF(not_concerning); i++)
        if (strcmp(code, not_concerning[i].code) == 0 && strstr(pointer, not_concerning[i].pointer_part)) return false;
    return true;
}

/** Whether a line "FILE: POINTER: text" names the pointer; the root is "/" in the log, "" or "/" in the reports. */
static bool log_names(const struct log *log, const char *file, const char *pointer) {
    char expected[2048];
    snprintf(expected, sizeof expected, "%s: %s: ", file, *pointer ? pointer : "/");
    for (uint32_t i = 0; i < log->count; i++)
        if (strncmp(log->text[i], expected, strlen(expected)) == 0) return true;
    return false;
}

static uint32_t file_count, error_count, fault_count;

static void check_file(const char *report_path) {
    char path[1024];
    snprintf(path, sizeof path, "%.*s", (int)(strlen(report_path) - strlen(".report.json")), report_path);
    json_t *report = json_load_file(report_path, 0, NULL);
    assert_non_null(report);
    static struct log log;
    log.count = 0;
    fnl_host host = fnl_host_default();
    host.user = &log;
    host.log = keep_line;
    fnl_scene *scene = NULL;
    fnl_result result = fnl_scene_load(&host, path, NULL, &scene);
    assert_int_equal(result == FNL_OK, scene != NULL);
    file_count++;

    json_t *messages = json_object_get(json_object_get(report, "issues"), "messages");
    bool any_error = false;
    for (size_t i = 0; i < json_array_size(messages); i++) {
        json_t *message = json_array_get(messages, i), *pointer_value = json_object_get(message, "pointer");
        if (json_integer_value(json_object_get(message, "severity")) != 0) continue;
        const char *code = json_string_value(json_object_get(message, "code"));
        const char *pointer =
            pointer_value ? json_string_value(pointer_value) : ""; /* errors of the GLB container have none */
        any_error = true;
        if (!concerns_us(code, pointer)) continue;
        error_count++;
        if (log_names(&log, path, pointer)) continue;
        fault_count++;
        print_error("%s: %s at '%s' was not reported\n", path, code, pointer);
    }
    if (has_no_data(path)) assert_int_equal(result, FNL_ERROR_FILE);
    if (!any_error && result != FNL_OK && !has_no_data(path)) {
        fault_count++;
        print_error("%s: is valid but was not loaded: %s\n", path, log.count ? log.text[log.count - 1] : "");
    }
    fnl_scene_destroy(&scene);
    json_decref(report);
}

static int visit(const char *path, const struct stat *status, int type, struct FTW *walk) {
    UNUSED(status);
    UNUSED(walk);
    size_t length = strlen(path), tail = strlen(".report.json");
    if (type == FTW_F && length > tail && strcmp(path + length - tail, ".report.json") == 0) check_file(path);
    return 0;
}

static void test_conformance(void **state) {
    UNUSED(state);
    if (access(FOLDER, R_OK) != 0) {
        print_message("skipped: %s is missing; the validator's 177 files and verdicts have no stand-in\n", FOLDER);
        skip();
    }
    assert_int_equal(nftw(FOLDER, visit, 16, FTW_PHYS), 0);
    print_message("%u files, %u errors that concern us, %u faults\n", file_count, error_count, fault_count);
    assert_true(file_count >= 177);
    assert_true(error_count >= 177);
    assert_int_equal(fault_count, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_conformance)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
