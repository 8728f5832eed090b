/* SPDX-License-Identifier: MIT */
#include "base/base.h"
#include "base/file.h"
#include "base/jobs.h"
#include "base/maths.h"
#include "base/ranges.h"

#include "tests/test_memory.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

static void test_arena_reuses_its_blocks(void **state) {
    UNUSED(state);
    fnl_host host = host_resolve(NULL);
    struct arena arena;
    arena_init(&arena, &host, 1024);
    void *first = arena_allocate(&arena, 100);
    for (int i = 0; i < 50; i++) assert_non_null(arena_allocate(&arena, 500));
    arena_reset(&arena);
    assert_ptr_equal(arena_allocate(&arena, 100), first);
    assert_true(((uintptr_t)arena_allocate(&arena, 1) & 15) == 0);
    assert_string_equal(arena_format(&arena, "%d-%s", 7, "x"), "7-x");
    arena_finish(&arena);
}

static void add_index(void *context, uint32_t index) { atomic_fetch_add((atomic_ullong *)context, index + 1); }

static void test_parallel_for_visits_each_index_once(void **state) {
    UNUSED(state);
    for (uint32_t threads = 1; threads <= 5; threads++) {
        fnl_host host = host_resolve(NULL);
        host.thread_count = threads;
        struct jobs *jobs;
        assert_int_equal(jobs_create(&host, &jobs), FNL_OK);
        assert_int_equal(jobs_thread_count(jobs), threads);
        for (uint32_t count = 0; count < 200; count += 13) {
            atomic_ullong sum = 0;
            jobs_parallel_for(jobs, count, add_index, &sum);
            assert_int_equal(sum, (uint64_t)count * (count + 1) / 2);
        }
        jobs_destroy(&jobs);
        assert_null(jobs);
    }
}

/* Runs that come and go, against a map of all numbers: the lowest that is wide enough is taken, and none is lost or taken twice. */
static void test_ranges_come_and_go(void **state) {
    UNUSED(state);
    enum { NUMBERS = 400, RUNS = 60, STEPS = 4000 };
    fnl_host host = host_resolve(NULL);
    struct random_state random = {5};
    struct ranges ranges = {0};
    bool taken[NUMBERS] = {false};
    struct range runs[RUNS] = {{0, 0}};
    uint32_t total = 0, highest = 0;
    for (uint32_t step = 0; step < STEPS; step++) {
        struct range *run = &runs[random_bits(&random) % RUNS];
        bool gives = run->count > 0;
        if (gives) {
            for (uint32_t i = 0; i < run->count; i++) taken[run->first + i] = false;
            ranges_give(&host, &ranges, run->first, run->count);
            total -= run->count;
            run->count = 0;
        } else {
            uint32_t count = 1 + (uint32_t)(random_bits(&random) % 6), first = 0;
            for (uint32_t free = 0; free < count; first++) free = taken[first] ? 0 : free + 1;
            run->first = ranges_take(&ranges, count);
            assert_int_equal(run->first, first - count);
            run->count = count;
            total += count;
            for (uint32_t i = 0; i < count; i++) taken[run->first + i] = true;
        }
        uint32_t end = NUMBERS, gaps = 0;
        while (end > 0 && !taken[end - 1]) end--;
        for (uint32_t i = 0; i < ranges.gaps.count; i++) gaps += ranges.gaps.data[i].count;
        assert_int_equal(ranges.end, end);
        assert_int_equal(end - gaps, total);
        highest = MAX(highest, end);
    }
    assert_true(highest > RUNS * 3 / 2 && highest < RUNS * 6);
    for (uint32_t i = 0; i < RUNS; i++) ranges_give(&host, &ranges, runs[i].first, runs[i].count);
    assert_int_equal(ranges.end, 0);
    assert_int_equal(ranges_take(&ranges, RANGES_NONE - 1), 0);
    assert_int_equal(ranges_take(&ranges, 1), RANGES_NONE);
    ranges_finish(&host, &ranges);
}

/* ---- files ---- */

static char folder[64];

static int make_folder(void **state) {
    UNUSED(state);
    snprintf(folder, sizeof folder, "/tmp/fanal-base-test-XXXXXX");
    return mkdtemp(folder) ? 0 : -1;
}

static const char *path_of(const char *name) {
    static char paths[4][512];
    static int next;
    char *path = paths[next++ % 4];
    snprintf(path, sizeof paths[0], "%s/%s", folder, name);
    return path;
}

static int remove_folder(void **state) {
    UNUSED(state);
    DIR *directory = opendir(folder);
    for (struct dirent *entry; (entry = readdir(directory));)
        if (entry->d_name[0] != '.') unlink(path_of(entry->d_name));
    closedir(directory);
    return rmdir(folder);
}

/* Also those that no test expects, such as temporary files. */
static int count_files(void) {
    int count = 0;
    DIR *directory = opendir(folder);
    for (struct dirent *entry; (entry = readdir(directory));) count += entry->d_name[0] != '.';
    closedir(directory);
    return count;
}

static void log_to_memory(void *user, fnl_log_level level, const char *line) {
    struct test_memory *memory = user;
    if (level == FNL_LOG_ERROR) atomic_fetch_add(&memory->errors, 1);
    snprintf(memory->last_error, sizeof memory->last_error, "%s", line);
}

static fnl_host memory_host(struct test_memory *memory) {
    *memory = (struct test_memory){0};
    return host_resolve(&(fnl_host){.user = memory, .reallocate = test_memory_reallocate, .log = log_to_memory});
}

static void assert_content(const char *path, const char *expected) {
    fnl_host host = host_resolve(NULL);
    struct file_view view;
    assert_int_equal(file_load(&host, path, &view), FNL_OK);
    assert_int_equal(view.size, strlen(expected));
    if (view.size) assert_memory_equal(view.data, expected, view.size);
    file_free(&host, &view);
}

static void test_file_appears_complete_or_not_at_all(void **state) {
    UNUSED(state);
    fnl_host host = host_resolve(NULL);
    const char *path = path_of("file");
    struct file_writer writer;
    assert_int_equal(file_write_begin(&host, path, &writer), FNL_OK);
    fputs("half", writer.stream);
    assert_int_not_equal(access(path, F_OK), 0);
    file_write_abandon(&writer);
    assert_int_not_equal(access(path, F_OK), 0);
    assert_int_equal(file_save(&host, path, "whole", 5), FNL_OK);
    assert_content(path, "whole");
    assert_int_equal(file_save(&host, path, "", 0), FNL_OK);
    assert_content(path, "");
    assert_int_equal(count_files(), 1);
}

static void *fill_and_reallocate(void *user, void *old, size_t old_size, size_t new_size) {
    void *block = test_memory_reallocate(user, old, old_size, new_size);
    if (block && !old) memset(block, 0x5a, new_size); /* what was never written shows */
    return block;
}

static void test_files_without_memory_fail_and_give_all_back(void **state) {
    UNUSED(state);
    struct test_memory memory;
    fnl_host host = memory_host(&memory);
    host.reallocate = fill_and_reallocate;
    const char *path = path_of("file");
    long long needed = 0;
    for (fnl_result result = FNL_ERROR_MEMORY; result != FNL_OK; needed++) {
        atomic_store(&memory.allocations, 0);
        atomic_store(&memory.fail_at, needed + 1);
        result = file_save(&host, path, "whole", 5);
        assert_true(result == FNL_OK || result == FNL_ERROR_MEMORY);
        assert_true(result == FNL_OK || atomic_exchange(&memory.errors, 0) > 0);
        assert_int_equal(count_files(), result == FNL_OK);
        assert_int_equal(memory.live_bytes, 0);
        assert_int_equal(memory.wrong_sizes, 0);
    }
    assert_true(needed >= 2);
    struct file_view view;
    atomic_store(&memory.allocations, 0);
    atomic_store(&memory.fail_at, 1);
    assert_int_equal(file_load(&host, path, &view), FNL_ERROR_MEMORY);
    assert_null(view.data);
    assert_int_equal(memory.live_bytes, 0);
}

static void test_only_regular_files_are_read_and_replaced(void **state) {
    UNUSED(state);
    struct test_memory memory;
    fnl_host host = memory_host(&memory);
    const char *pipe_path = path_of("pipe"), *link_path = path_of("link");
    const struct {
        const char *path, *kind;
    } others[] = {{pipe_path, "a pipe"}, {folder, "a folder"}, {"/dev/null", "a device"}, {link_path, "a device"}};
    assert_int_equal(mkfifo(pipe_path, 0600), 0);
    assert_int_equal(symlink("/dev/null", link_path), 0);
    for (uint32_t i = 0; i < COUNT_OF(others); i++) {
        struct file_view view;
        char expected[256];
        assert_int_equal(file_load(&host, others[i].path, &view), FNL_ERROR_FILE);
        snprintf(expected, sizeof expected, "%s: is %s, not a regular file", others[i].path, others[i].kind);
        assert_string_equal(memory.last_error, expected);
        assert_int_equal(file_save(&host, others[i].path, "x", 1), FNL_ERROR_FILE);
        snprintf(expected, sizeof expected, "%s: cannot be written: it is %s, not a regular file", others[i].path,
                 others[i].kind);
        assert_string_equal(memory.last_error, expected);
    }
    struct stat status;
    assert_int_equal(stat("/dev/null", &status), 0);
    assert_true(S_ISCHR(status.st_mode));
    assert_int_equal(count_files(), 2);
    assert_int_equal(memory.live_bytes, 0);
}

/* What a write that failed has lost is told with its reason, although all that is left of the file can be written. */
static void test_a_full_disk_is_one_error_that_names_the_file(void **state) {
    UNUSED(state);
    struct test_memory memory;
    fnl_host host = memory_host(&memory);
    const char *path = path_of("file");
    struct rlimit before, small;
    char text[65536], expected[256];
    memset(text, 'x', sizeof text);
    assert_int_equal(file_save(&host, path, "whole", 5), FNL_OK);
    signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    small = before;
    small.rlim_cur = 4096;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    fnl_result result = file_save(&host, path, text, sizeof text);
    setrlimit(RLIMIT_FSIZE, &before);
    signal(SIGXFSZ, SIG_DFL);
    assert_int_equal(result, FNL_ERROR_FILE);
    snprintf(expected, sizeof expected, "%s: cannot be written: %s", path, strerror(EFBIG));
    assert_string_equal(memory.last_error, expected);
    assert_int_equal(memory.errors, 1);
    assert_content(path, "whole");
    assert_int_equal(count_files(), 1);
    assert_int_equal(memory.live_bytes, 0);
}

/* A file whose time of change is so many hours back. */
static void make_old(const char *name, int hours) {
    fnl_host host = host_resolve(NULL);
    const struct timespec times[2] = {{.tv_sec = time(NULL) - hours * 3600}, {.tv_sec = time(NULL) - hours * 3600}};
    if (access(path_of(name), F_OK) != 0) assert_int_equal(file_save(&host, path_of(name), "old", 3), FNL_OK);
    assert_int_equal(utimensat(AT_FDCWD, path_of(name), times, AT_SYMLINK_NOFOLLOW), 0);
}

static void test_what_crashed_runs_left_is_removed_after_a_day(void **state) {
    UNUSED(state);
    fnl_host host = host_resolve(NULL);
    static const char *const kept[] = {"fanal-00000002-00000000.part", "fanal-notes.part", "fanal-00000001.part.png", "other.part", "file"};
    make_old("fanal-00000002-00000000.part", 1);
    for (int i = 1; i < 5; i++) make_old(kept[i], 100);
    make_old("fanal-00000001-00000000.part", 48);
    assert_int_equal(symlink("file", path_of("fanal-00000003-00000000.part")), 0);
    make_old("fanal-00000003-00000000.part", 48);
    assert_int_equal(count_files(), 7);
    char elsewhere[512];
    snprintf(elsewhere, sizeof elsewhere, "%s/below", folder);
    assert_int_equal(mkdir(elsewhere, 0700), 0);
    assert_int_equal(file_save(&host, path_of("below/file"), "x", 1), FNL_OK); /* a folder is looked through when it is another than the last */
    unlink(path_of("below/file"));
    rmdir(elsewhere);
    assert_int_equal(file_save(&host, path_of("file"), "new", 3), FNL_OK);
    assert_int_equal(access(path_of("fanal-00000001-00000000.part"), F_OK), -1);
    for (int i = 0; i < 5; i++) assert_int_equal(access(path_of(kept[i]), F_OK), 0);
    assert_int_equal(count_files(), 6);
    assert_content(path_of("file"), "new");
}

struct cutting_host {
    struct test_memory memory; /* first: the log takes it too */
    const char *path;
};

/* Between finding the size and reading: the moment when another program makes the file shorter. */
static void *cut_and_reallocate(void *user, void *old, size_t old_size, size_t new_size) {
    struct cutting_host *cutting = user;
    if (new_size) assert_int_equal(truncate(cutting->path, 3), 0);
    return test_memory_reallocate(&cutting->memory, old, old_size, new_size);
}

static void test_files_that_shrink_are_errors_or_stay_whole(void **state) {
    UNUSED(state);
    struct cutting_host cutting = {.path = path_of("file")};
    fnl_host host = {.user = &cutting, .reallocate = cut_and_reallocate, .log = log_to_memory};
    fnl_host plain = host_resolve(NULL);
    char text[20000];
    memset(text, 'x', sizeof text);
    assert_int_equal(file_save(&plain, cutting.path, text, sizeof text), FNL_OK);
    struct file_view view;
    assert_int_equal(file_load(&host, cutting.path, &view), FNL_ERROR_FILE);
    assert_non_null(strstr(cutting.memory.last_error, "became shorter"));
    assert_int_equal(cutting.memory.live_bytes, 0);
    assert_int_equal(file_save(&plain, cutting.path, text, sizeof text), FNL_OK);
    assert_int_equal(file_load(&plain, cutting.path, &view), FNL_OK);
    assert_int_equal(truncate(cutting.path, 0), 0);
    assert_memory_equal(view.data, text, sizeof text); /* a mapping would end the process here */
    file_free(&plain, &view);
}

enum { WRITER_COUNT = 4, WRITES = 60, WRITE_BYTES = 50000 };

struct writing {
    pthread_t thread;
    const char *path;
    char letter;
    int failures;
};

static void *write_often(void *user) {
    struct writing *writing = user;
    fnl_host host = host_resolve(NULL);
    char *text = malloc(WRITE_BYTES);
    memset(text, writing->letter, WRITE_BYTES);
    for (int i = 0; i < WRITES; i++) writing->failures += file_save(&host, writing->path, text, WRITE_BYTES) != FNL_OK;
    free(text);
    return NULL;
}

static void test_threads_that_write_one_path_each_write_it_whole(void **state) {
    UNUSED(state);
    struct writing writers[WRITER_COUNT];
    const char *path = path_of("shared");
    fnl_host host = host_resolve(NULL);
    struct file_view view;
    for (int i = 0; i < WRITER_COUNT; i++) {
        writers[i] = (struct writing){.path = path, .letter = (char)('a' + i)};
        assert_int_equal(pthread_create(&writers[i].thread, NULL, write_often, &writers[i]), 0);
    }
    for (int i = 0; i < WRITER_COUNT; i++) {
        pthread_join(writers[i].thread, NULL);
        assert_int_equal(writers[i].failures, 0);
    }
    assert_int_equal(file_load(&host, path, &view), FNL_OK);
    assert_int_equal(view.size, WRITE_BYTES);
    for (size_t i = 1; i < view.size; i++) assert_int_equal(view.data[i], view.data[0]);
    file_free(&host, &view);
    assert_int_equal(count_files(), 1);
}

static void test_replacing_keeps_mode_and_links(void **state) {
    UNUSED(state);
    fnl_host host = host_resolve(NULL);
    struct stat status;
    char text[128];
    assert_int_equal(file_save(&host, path_of("file"), "one", 3), FNL_OK);
    assert_int_equal(chmod(path_of("file"), 0640), 0);
    assert_int_equal(symlink("file", path_of("link")), 0);
    assert_int_equal(symlink(path_of("link"), path_of("link of link")), 0);
    assert_int_equal(file_save(&host, path_of("link of link"), "two", 3), FNL_OK);
    assert_int_equal(lstat(path_of("file"), &status), 0);
    assert_true(S_ISREG(status.st_mode));
    assert_int_equal(status.st_mode & 0777, 0640);
    assert_int_equal(readlink(path_of("link"), text, sizeof text), 4);
    assert_content(path_of("file"), "two");
    /* A link to where nothing is yet, and links that lead nowhere. */
    assert_int_equal(symlink("new", path_of("early")), 0);
    assert_int_equal(file_save(&host, path_of("early"), "three", 5), FNL_OK);
    assert_int_equal(readlink(path_of("early"), text, sizeof text), 3);
    assert_content(path_of("new"), "three");
    assert_int_equal(symlink("loop", path_of("loop")), 0);
    struct test_memory memory;
    host = memory_host(&memory);
    assert_int_equal(file_save(&host, path_of("loop"), "four", 4), FNL_ERROR_FILE);
    assert_non_null(strstr(memory.last_error, "/loop: cannot be written: Too many levels"));
    assert_int_equal(count_files(), 6);
}

static void test_long_names_can_be_written(void **state) {
    UNUSED(state);
    fnl_host host = host_resolve(NULL);
    char path[64 + 257];
    snprintf(path, sizeof path, "%s/%0255d", folder, 7); /* the longest that there is */
    assert_int_equal(file_save(&host, path, "long", 4), FNL_OK);
    assert_content(path, "long");
    assert_int_equal(unlink(path), 0);
}

static void test_half_floats_round_trip(void **state) {
    UNUSED(state);
    for (uint32_t half = 0; half < 0x10000; half++) {
        if ((half & 0x7c00) == 0x7c00 && (half & 0x3ff)) continue; /* NaN */
        assert_int_equal(half_from_float(half_to_float((uint16_t)half)), half);
    }
    assert_int_equal(half_from_float(65520.0f), 0x7c00);
    assert_int_equal(half_from_float(65519.0f), 0x7bff);
    assert_int_equal(half_from_float(1.0f + 0x1p-11f), 0x3c00); /* tie to even */
    assert_int_equal(half_from_float(1.0f + 3 * 0x1p-11f), 0x3c02);
}

/* Replaces in place; what is left is UTF-8 without controls. */
static void test_text_is_made_safe_to_print(void **state) {
    UNUSED(state);
    static const struct {
        const char *text, *expected;
    } rows[] = {
        {"", ""},
        {"plain ~ äß€𝄞", "plain ~ äß€𝄞"},
        {"\033]52;c;AA\a\r\n\t\b\177", "?]52;c;AA??????"},
        {"\xc2\x80\xc2\x9b\xc2\x9f\xc2\xa0", "???\xc2\xa0"},                     /* C1, and what follows it */
        {"\x9b" "1m\xff\xfe", "?1m??"},                                           /* alone: not UTF-8 */
        {"\xe2\x80\x8e\xe2\x80\x8f\xe2\x80\xaa\xe2\x80\xae\xe2\x81\xa6\xe2\x81\xa9\xd8\x9c", "???????"}, /* direction of writing */
        {"\xe2\x80\xa8\xe2\x80\xa9\xe2\x80\x90", "??\xe2\x80\x90"},               /* separators; a hyphen */
        {"\xc0\x8a\xe0\x80\x8a\xf0\x80\x80\x8a", "?????????"},                   /* longer than needed */
        {"\xed\xa0\x80\xf4\x90\x80\x80", "???????"},                            /* surrogate; above U+10FFFF */
        {"a\xe2\x82", "a??"},                                                     /* cut off */
    };
    for (uint32_t i = 0; i < COUNT_OF(rows); i++) {
        char text[64];
        strcpy(text, rows[i].text);
        assert_int_equal(fnl_text_clean(text), strcmp(rows[i].text, rows[i].expected) != 0);
        assert_string_equal(text, rows[i].expected);
    }
    assert_false(fnl_text_clean(NULL));
}

static void keep_line(void *user, fnl_log_level level, const char *line) {
    UNUSED(level);
    snprintf(user, 64, "%s", line);
}

static void test_no_name_breaks_a_line_of_the_log(void **state) {
    UNUSED(state);
    char line[64] = "";
    fnl_host host = host_resolve(&(fnl_host){.user = line, .log = keep_line});
    log_error(&host, "%s: broken", "a\n\033[2J\xe2\x80\xae.gltf");
    assert_string_equal(line, "a??[2J?.gltf: broken");
}

static void test_matrix_inverse(void **state) {
    UNUSED(state);
    mat4 m = mat4_from_trs(vec3_make(1, -2, 3e4f), quat_normalize((quat){1, 2, 3, 4}), vec3_make(2, -3, 0.01f)), inverse;
    assert_true(mat4_inverse(&m, &inverse));
    vec3 p = mat4_point(&inverse, mat4_point(&m, vec3_make(5, 6, 7)));
    assert_true(vec3_distance(p, vec3_make(5, 6, 7)) < 0.3f); /* 3e4 / 0.01 leaves few bits */
    assert_true(mat4_determinant3(&m) < 0);
    mat4 flat = mat4_scaling(vec3_make(1, 0, 1));
    assert_false(mat4_inverse(&flat, &inverse));
}

/* Of any length that a float can have. */
static void test_extreme_vectors_are_normalized(void **state) {
    UNUSED(state);
    for (int exponent = -140; exponent <= 126; exponent++) {
        const float s = ldexpf(1, exponent);
        const vec3 v = vec3_normalize(vec3_make(s, 0, -s));
        const quat q = quat_normalize((quat){s, -s, s, s});
        assert_float_equal(v.x, 0.70710678f, 1e-6f);
        assert_float_equal(v.z, -0.70710678f, 1e-6f);
        assert_float_equal(q.y, -0.5f, 1e-6f);
    }
    assert_true(vec3_length(vec3_normalize(vec3_make(0, 0, 0))) == 0);
    assert_true(vec3_length(vec3_normalize(vec3_make(INFINITY, 0, 0))) == 0);
    assert_true(quat_normalize((quat){0, 0, 0, 0}).w == 1);
}

static void test_octahedral_round_trip(void **state) {
    UNUSED(state);
    struct random_state random = {1};
    float worst = 1;
    for (int i = 0; i < 100000; i++) {
        vec3 n = vec3_normalize(
            vec3_make(random_range(&random, -1, 1), random_range(&random, -1, 1), random_range(&random, -1, 1)));
        worst = fminf(worst, vec3_dot(n, octahedral_decode(octahedral_encode(n))));
    }
    assert_true(worst > 0.999999f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_arena_reuses_its_blocks),
        cmocka_unit_test(test_parallel_for_visits_each_index_once),
        cmocka_unit_test(test_ranges_come_and_go),
        cmocka_unit_test_setup_teardown(test_file_appears_complete_or_not_at_all, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_a_full_disk_is_one_error_that_names_the_file, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_what_crashed_runs_left_is_removed_after_a_day, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_files_without_memory_fail_and_give_all_back, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_only_regular_files_are_read_and_replaced, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_files_that_shrink_are_errors_or_stay_whole, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_threads_that_write_one_path_each_write_it_whole, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_replacing_keeps_mode_and_links, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_long_names_can_be_written, make_folder, remove_folder),
        cmocka_unit_test(test_half_floats_round_trip),
        cmocka_unit_test(test_text_is_made_safe_to_print),
        cmocka_unit_test(test_no_name_breaks_a_line_of_the_log),
        cmocka_unit_test(test_matrix_inverse),
        cmocka_unit_test(test_extreme_vectors_are_normalized),
        cmocka_unit_test(test_octahedral_round_trip),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
