/* SPDX-License-Identifier: MIT */
/** Files that the command writes by itself, and whether what it printed has arrived. */
#ifndef FNL_CLI_OUTPUT_H
#define FNL_CLI_OUTPUT_H

#include <limits.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

/** Whether two paths lead to one file, by whatever folders and symbolic links; neither has to exist. */
bool output_is_same(const char *a, const char *b);
/**
 * Whether a file can be written at `path`: its folder exists and takes files. False with a message. To be called before anything is loaded or rendered.
 */
bool output_check(const char *path);

/**
 * The next field of a pattern that names pictures, such as %d or %04d: what stands behind its digits. `percent` is where it begins, `width` its digits. NULL:
 * there is none. "%%" is no field but a percent sign.
 */
const char *output_next_field(const char *pattern, const char **percent, int *width);
/** Appends a part of a pattern that has no field to the `used` bytes in `out`, with a percent sign for "%%"; how many bytes there are then. */
size_t output_append(char *out, size_t used, size_t capacity, const char *part, size_t length);
/** output_check() for a pattern; a folder with a field is not looked at. */
bool output_check_pattern(const char *pattern);

/**
 * A file being written, as the library writes pictures: a new file beside the target, under a name that nobody else has and that is no link, which takes
 * the target's place when it is complete. A symbolic link stays one, and a file that is replaced hands its mode down. A device or a pipe is written to as it is.
 */
struct output {
    FILE *stream; /* errors are found by output_commit */
    const char *path;
    char target[PATH_MAX], temporary[PATH_MAX]; /* temporary: "" of a device or a pipe */
};
/** False with a message. `path` must live as long as the output. */
bool output_begin(const char *path, struct output *out);
/** Ends the file. False with one message that names it when some of it could not be written, on a full disk; there is then no file, or the one that was there. */
bool output_commit(struct output *out);
/** Drops what was written. Nothing after a failed begin or a commit. */
void output_abandon(struct output *out);
/** Writes one block of bytes as a whole file. False with a message. */
bool output_save(const char *path, const void *bytes, size_t size);
/** Makes a new folder for files that must have a name of their own for a while, in $TMPDIR or /tmp. False with a message. */
bool output_make_folder(char out[PATH_MAX]);

/**
 * To be called first: a closed standard stream would lend its number to the next file, and what is printed would go there. A limit on the size of files
 * (ulimit -f) becomes an error of the file in place of a signal.
 */
void output_guard_streams(void);
/** Sends what was printed on its way. False with a message, at the first time, when some of it is lost. */
bool output_flush(void);

#endif
