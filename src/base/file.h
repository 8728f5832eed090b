/* SPDX-License-Identifier: MIT */
/** Whole files: read into memory, written under a temporary name and renamed when complete. */
#ifndef FNL_BASE_FILE_H
#define FNL_BASE_FILE_H

#include "base/base.h"

/** Which file it is, whatever the path it was found by, and how long. */
struct file_identity {
    uint64_t device, node, size;
};
/** False when there is no such file. */
bool file_identify(const char *path, struct file_identity *out);

/** The bytes of a file, the host's memory. An empty file has data NULL and size 0. */
struct file_view {
    const unsigned char *data;
    size_t size;
    struct file_identity identity;
};

/** Reads a regular file; anything else (a pipe, a device, a folder) is refused. On failure logs path and reason; `out` is then empty. */
fnl_result file_load(const fnl_host *host, const char *path, struct file_view *out);
void file_free(const fnl_host *host, struct file_view *view);

/** A file being written: bytes go to a temporary name beside the target. */
struct file_writer {
    FILE *stream; /* write with stdio; errors are found at commit */
    char *path, *target, *temporary; /* as given; without symbolic links; what is written to. One block of names_size bytes */
    size_t names_size;
    fnl_host host;
};

/**
 * Where the path is a symbolic link, the file it points to is replaced and the link stays. A file that is replaced hands its mode down.
 * What is there but no regular file is refused. Each writer has a temporary name of its own: of several that write one path at the same time,
 * in one process or in several, the last to commit wins whole.
 */
fnl_result file_write_begin(const fnl_host *host, const char *path, struct file_writer *out);
/** Flushes and renames onto the target; on any error removes the temporary file, logs and fails. */
fnl_result file_write_commit(struct file_writer *writer);
/** Removes the temporary file; the target is untouched. Safe after a failed begin or a commit. */
void file_write_abandon(struct file_writer *writer);

/** Writes one block of bytes as a whole file. */
fnl_result file_save(const fnl_host *host, const char *path, const void *data, size_t size);

/** The absolute path without symbolic links, "." and "..". False with errno: there is no such file, or it does not fit. */
bool path_real(const char *path, char *out, size_t capacity);
/** Copies the folder part of a path, the last '/' included ("" when there is none), into `out`. False if too long. */
bool path_folder(const char *path, char *out, size_t capacity);
/** The text after the last '.' of the last path element ("" when there is none). */
const char *path_extension(const char *path);
/** Case-insensitive comparison of an extension without dot. */
bool path_has_extension(const char *path, const char *extension);

#endif
