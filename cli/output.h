/* SPDX-License-Identifier: MIT */
/** Files that the command writes by itself, and whether what it printed has arrived. */
#ifndef FNL_CLI_OUTPUT_H
#define FNL_CLI_OUTPUT_H

#include <limits.h>
#include <stdbool.h>
#include <stddef.h>

/** Whether two paths lead to one file, by whatever folders and symbolic links; neither has to exist. */
bool output_is_same(const char *a, const char *b);
/**
 * Whether a file can be written at `path`: its folder exists and takes files. False with a message. To be called before anything is loaded or rendered. A
 * folder that is named by a pattern (%d) is not looked at.
 */
bool output_check(const char *path);
/**
 * Writes a whole file under a temporary name, then renames it. As with pictures, a symbolic link stays one and a file that is replaced hands its
 * mode down; a device or a pipe is written to as it is. False with a message.
 */
bool output_save(const char *path, const void *bytes, size_t size);

/** To be called first: a closed standard stream would lend its number to the next file, and what is printed would go there. */
void output_guard_streams(void);
/** Sends what was printed on its way. False with a message, at the first time, when some of it is lost. */
bool output_flush(void);

#endif
