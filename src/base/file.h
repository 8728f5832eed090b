/* SPDX-License-Identifier: MIT */
/** Whole files: mapped for reading, written under a temporary name and renamed when complete. */
#ifndef FNL_BASE_FILE_H
#define FNL_BASE_FILE_H

#include "base/base.h"

/** A read-only view of a file. An empty file has data NULL and size 0. */
struct file_view {
    const unsigned char *data;
    size_t size;
};

/** Maps a file. On failure logs the path and the reason; `out` is then empty. */
fnl_result file_map(const fnl_host *host, const char *path, struct file_view *out);
void file_unmap(struct file_view *view);

/** A file being written: bytes go to a temporary name beside the target. */
struct file_writer {
    FILE *stream; /* write with stdio; errors are found at commit */
    char *path, *temporary;
    fnl_host host;
};

fnl_result file_write_begin(const fnl_host *host, const char *path, struct file_writer *out);
/** Flushes and renames onto the target; on any error removes the temporary file, logs and fails. */
fnl_result file_write_commit(struct file_writer *writer);
/** Removes the temporary file; the target is untouched. Safe after a failed begin or a commit. */
void file_write_abandon(struct file_writer *writer);

/** Writes one block of bytes as a whole file. */
fnl_result file_save(const fnl_host *host, const char *path, const void *data, size_t size);

/** Copies the folder part of a path, the last '/' included ("" when there is none), into `out`. False if too long. */
bool path_folder(const char *path, char *out, size_t capacity);
/** The text after the last '.' of the last path element ("" when there is none). */
const char *path_extension(const char *path);
/** Case-insensitive comparison of an extension without dot. */
bool path_has_extension(const char *path, const char *extension);

#endif
