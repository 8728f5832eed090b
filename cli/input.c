/* SPDX-License-Identifier: MIT */
#include "input.h"

#include "print.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const char *problem_of(const struct stat *is, uint64_t most) {
    if (S_ISDIR(is->st_mode)) return "it is a folder, not a regular file";
    if (S_ISFIFO(is->st_mode)) return "it is a pipe, not a regular file";
    if (!S_ISREG(is->st_mode)) return "it is a device, not a regular file";
    return (uint64_t)is->st_size > most ? "it is too large for such a file" : NULL;
}

FILE *input_try(const char *path, uint64_t most, const char **problem) {
    /* Without O_NONBLOCK, opening a pipe waits for somebody to write to it. */
    const int descriptor = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    struct stat is;
    FILE *file = NULL;
    *problem = descriptor >= 0 && fstat(descriptor, &is) == 0 ? problem_of(&is, most) : strerror(errno);
    if (!*problem && !(file = fdopen(descriptor, "rb"))) *problem = strerror(errno);
    if (!file && descriptor >= 0) close(descriptor);
    return file;
}

FILE *input_open(const char *path, uint64_t most) {
    const char *problem;
    FILE *file = input_try(path, most, &problem);
    if (!file) fprintf(stderr, "fanal: error: %s: cannot be read: %s\n", path, problem);
    return file;
}
