/* SPDX-License-Identifier: MIT */
/** Runs a subcommand in a process of its own, for tests, and keeps what it prints. */
#ifndef FNL_CLI_COMMAND_CAPTURE_H
#define FNL_CLI_COMMAND_CAPTURE_H

#include <fcntl.h>
#include <setjmp.h>
#include <stdio.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

static char out[65536], err[8192]; /* what the last run printed */

static inline void capture_read(const char *name, char *text, size_t capacity) {
    FILE *stream = fopen(name, "rb");
    assert_non_null(stream);
    text[fread(text, 1, capacity - 1, stream)] = 0;
    fclose(stream);
}

/** The exit status; `line` is the subcommand and its arguments, separated by blanks. Leaves two files in the working folder. */
static inline int capture(int (*command)(int argc, char **argv), const char *line) {
    char words[512], *argv[16], *rest = words;
    int argc = 0;
    snprintf(words, sizeof words, "%s", line);
    for (char *word; (word = strtok_r(rest, " ", &rest));) argv[argc++] = word;
    argv[argc] = NULL;
    fflush(NULL);
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        const char *names[] = {"out", "err"};
        for (int i = 0; i < 2; i++)
            if (dup2(open(names[i], O_WRONLY | O_CREAT | O_TRUNC, 0600), 1 + i) < 0) _exit(99);
        int code = command(argc, argv);
        fflush(NULL);
        _exit(code);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status));
    capture_read("out", out, sizeof out);
    capture_read("err", err, sizeof err);
    return WEXITSTATUS(status);
}

#endif
