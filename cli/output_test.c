/* SPDX-License-Identifier: MIT */
/* Files that the command writes and reads: whole or not at all, through no link, with one error that names them; none makes it wait for ever. */
#include "input.h"
#include "output.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include <cmocka.h>

static char folder[64], said[1024];

static int make_folder(void **state) {
    (void)state;
    strcpy(folder, "/tmp/fanal-output-XXXXXX");
    return mkdtemp(folder) && chdir(folder) == 0 ? 0 : -1;
}

static int count_files(void) {
    int count = 0;
    DIR *directory = opendir(folder);
    for (struct dirent *entry; (entry = readdir(directory));) count += entry->d_name[0] != '.';
    closedir(directory);
    return count;
}

static int remove_folder(void **state) {
    (void)state;
    DIR *directory = opendir(folder);
    for (struct dirent *entry; (entry = readdir(directory));)
        if (entry->d_name[0] != '.') unlinkat(dirfd(directory), entry->d_name, 0);
    closedir(directory);
    return chdir("/") == 0 ? rmdir(folder) : -1;
}

static void write_text(const char *name, const char *text) {
    FILE *file = fopen(name, "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

static const char *content(const char *name) {
    static char text[64];
    FILE *file = fopen(name, "r");
    assert_non_null(file);
    text[fread(text, 1, sizeof text - 1, file)] = 0;
    fclose(file);
    return text;
}

/* What goes to stderr between the two is then in `said`. */
static FILE *kept;
static int terminal;

static void listen_begin(void) {
    kept = tmpfile();
    assert_non_null(kept);
    fflush(stderr);
    terminal = dup(STDERR_FILENO);
    dup2(fileno(kept), STDERR_FILENO);
}

static void listen_end(void) {
    fflush(stderr);
    dup2(terminal, STDERR_FILENO);
    close(terminal);
    rewind(kept);
    said[fread(said, 1, sizeof said - 1, kept)] = 0;
    fclose(kept);
}

static void test_links_and_pipes_of_its_names_stay(void **state) {
    struct output out;
    char expected[64];
    (void)state;
    write_text("victim", "precious");
    for (int i = 0; i < 64; i += 2) { /* the names that come next */
        snprintf(expected, sizeof expected, "fanal-%08x-%08x.part", (unsigned)getpid(), (unsigned)i);
        assert_int_equal(symlink("victim", expected), 0);
        snprintf(expected, sizeof expected, "fanal-%08x-%08x.part", (unsigned)getpid(), (unsigned)i + 1);
        assert_int_equal(mkfifo(expected, 0600), 0);
    }
    assert_true(output_save("file", "new", 3));
    assert_true(output_begin("other", &out));
    output_abandon(&out);
    assert_string_equal(content("file"), "new");
    assert_string_equal(content("victim"), "precious");
    assert_int_equal(access("other", F_OK), -1);
    assert_int_equal(count_files(), 64 + 2);
}

static void test_a_link_stays_and_its_target_is_replaced_with_its_mode(void **state) {
    struct stat is;
    (void)state;
    write_text("target", "old");
    chmod("target", 0640);
    assert_int_equal(symlink("target", "link"), 0);
    assert_true(output_save("link", "new", 3));
    assert_int_equal(lstat("link", &is), 0);
    assert_true(S_ISLNK(is.st_mode));
    assert_string_equal(content("target"), "new");
    assert_int_equal(stat("target", &is), 0);
    assert_int_equal(is.st_mode & 0777, 0640);
    assert_int_equal(count_files(), 2);
}

static void test_a_full_disk_is_one_error_that_names_the_file(void **state) {
    struct rlimit before, small;
    static char text[65536];
    (void)state;
    write_text("file", "whole");
    output_guard_streams(); /* no signal */
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    small = before;
    small.rlim_cur = 4096;
    listen_begin();
    setrlimit(RLIMIT_FSIZE, &small);
    const bool good = output_save("file", text, sizeof text);
    setrlimit(RLIMIT_FSIZE, &before);
    listen_end();
    assert_false(good);
    assert_string_equal(said, "fanal: error: file: cannot be written: File too large\n");
    assert_string_equal(content("file"), "whole");
    assert_int_equal(count_files(), 1);
    listen_begin();
    const bool device = output_save("/dev/full", "x", 1);
    listen_end();
    assert_false(device);
    assert_string_equal(said, "fanal: error: /dev/full: cannot be written: No space left on device\n");
}

static void test_devices_and_pipes_are_written_to_as_they_are(void **state) {
    struct stat is;
    char text[8] = "";
    (void)state;
    assert_true(output_save("/dev/null", "x", 1));
    assert_int_equal(stat("/dev/null", &is), 0);
    assert_true(S_ISCHR(is.st_mode));
    assert_int_equal(mkfifo("pipe", 0600), 0);
    const int reader = open("pipe", O_RDONLY | O_NONBLOCK);
    assert_true(output_save("pipe", "text", 4));
    assert_int_equal(read(reader, text, sizeof text), 4);
    assert_string_equal(text, "text");
    close(reader);
    assert_int_equal(count_files(), 1);
}

static void test_what_crashed_runs_left_is_removed_after_a_day(void **state) {
    static const struct {
        const char *name;
        int hours;
        bool stays;
    } files[] = {{"fanal-00000001-00000000.part", 48, false}, {"fanal-00000002.part", 48, false}, {"fanal-00000003-00000000.part", 1, true},
                 {"fanal-notes.part", 48, true},              {"other.part", 48, true},           {"fanal-00000001.part.png", 48, true}};
    (void)state;
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        const struct timespec times[2] = {{.tv_sec = time(NULL) - files[i].hours * 3600}, {.tv_sec = time(NULL) - files[i].hours * 3600}};
        write_text(files[i].name, "old");
        assert_int_equal(utimensat(AT_FDCWD, files[i].name, times, 0), 0);
    }
    assert_true(output_save("file", "new", 3));
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) assert_int_equal(access(files[i].name, F_OK) == 0, files[i].stays);
}

static void test_only_regular_files_are_read(void **state) {
    static const struct {
        const char *path, *words;
    } bad[] = {{"pipe", "fanal: error: pipe: cannot be read: it is a pipe, not a regular file\n"},
               {".", "fanal: error: .: cannot be read: it is a folder, not a regular file\n"},
               {"/dev/zero", "fanal: error: /dev/zero: cannot be read: it is a device, not a regular file\n"},
               {"large", "fanal: error: large: cannot be read: it is too large for such a file\n"},
               {"missing", "fanal: error: missing: cannot be read: No such file or directory\n"}};
    (void)state;
    assert_int_equal(mkfifo("pipe", 0600), 0);
    write_text("large", "");
    assert_int_equal(truncate("large", 1000001), 0);
    write_text("file", "text");
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        listen_begin();
        FILE *file = input_open(bad[i].path, 1000000);
        listen_end();
        assert_null(file);
        assert_string_equal(said, bad[i].words);
    }
    FILE *file = input_open("file", 4);
    assert_non_null(file);
    assert_int_equal(fgetc(file), 't');
    fclose(file);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_links_and_pipes_of_its_names_stay, make_folder, remove_folder), /* first: names are counted */
        cmocka_unit_test_setup_teardown(test_a_link_stays_and_its_target_is_replaced_with_its_mode, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_a_full_disk_is_one_error_that_names_the_file, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_devices_and_pipes_are_written_to_as_they_are, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_what_crashed_runs_left_is_removed_after_a_day, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_only_regular_files_are_read, make_folder, remove_folder),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
