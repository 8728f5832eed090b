/* SPDX-License-Identifier: MIT */
/** Files that the command reads by itself. */
#ifndef FNL_CLI_INPUT_H
#define FNL_CLI_INPUT_H

#include <stdint.h>
#include <stdio.h>

/** Opens a regular file of at most `most` bytes. NULL with `*problem` in words: pipes, devices and folders may have no end, or nobody writes to them. */
FILE *input_try(const char *path, uint64_t most, const char **problem);
/** The same with a message that names the file. */
FILE *input_open(const char *path, uint64_t most);

#endif
