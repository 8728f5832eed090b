/* SPDX-License-Identifier: MIT */
#include "base/file.h"

#include <errno.h>
#include <fcntl.h>
#include <strings.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

fnl_result file_map(const fnl_host *host, const char *path, struct file_view *out) {
    *out = (struct file_view){0};
    int descriptor = open(path, O_RDONLY | O_CLOEXEC);
    struct stat status;
    if (descriptor < 0 || fstat(descriptor, &status) != 0) {
        log_error(host, "%s: cannot be opened: %s", path, strerror(errno));
        if (descriptor >= 0) close(descriptor);
        return FNL_ERROR_FILE;
    }
    if (!S_ISREG(status.st_mode)) {
        log_error(host, "%s: is not a regular file", path);
        close(descriptor);
        return FNL_ERROR_FILE;
    }
    if (status.st_size > 0) {
        void *data = mmap(NULL, (size_t)status.st_size, PROT_READ, MAP_PRIVATE, descriptor, 0);
        if (data == MAP_FAILED) {
            log_error(host, "%s: cannot be mapped: %s", path, strerror(errno));
            close(descriptor);
            return FNL_ERROR_FILE;
        }
        *out = (struct file_view){.data = data, .size = (size_t)status.st_size};
    }
    close(descriptor);
    return FNL_OK;
}

void file_unmap(struct file_view *view) {
    if (view->data) munmap((void *)(uintptr_t)view->data, view->size);
    *view = (struct file_view){0};
}

static void writer_free(struct file_writer *writer) {
    if (writer->path) host_free(&writer->host, writer->path, strlen(writer->path) + 1);
    if (writer->temporary) host_free(&writer->host, writer->temporary, strlen(writer->temporary) + 1);
    *writer = (struct file_writer){0};
}

fnl_result file_write_begin(const fnl_host *host, const char *path, struct file_writer *out) {
    *out = (struct file_writer){.host = *host};
    size_t length = strlen(path);
    out->path = host_allocate(host, length + 1);
    out->temporary = host_allocate(host, length + 16);
    if (!out->path || !out->temporary) {
        if (out->temporary) host_free(host, out->temporary, length + 16);
        out->temporary = NULL;
        writer_free(out);
        return FNL_ERROR_MEMORY;
    }
    memcpy(out->path, path, length + 1);
    /* Same length for every name, so that the size given back on free is the size that was allocated. */
    snprintf(out->temporary, length + 16, "%s.part-%09u", path, (unsigned)getpid() % 1000000000u);
    out->stream = fopen(out->temporary, "wb");
    if (!out->stream) {
        log_error(host, "%s: cannot be written: %s", path, strerror(errno));
        writer_free(out);
        return FNL_ERROR_FILE;
    }
    return FNL_OK;
}

fnl_result file_write_commit(struct file_writer *writer) {
    if (!writer->stream) return FNL_ERROR_INVALID;
    errno = 0;
    bool failed = fflush(writer->stream) != 0 || ferror(writer->stream);
    failed |= fclose(writer->stream) != 0;
    writer->stream = NULL;
    if (!failed) failed = rename(writer->temporary, writer->path) != 0;
    if (failed) {
        log_error(&writer->host, "%s: cannot be written: %s", writer->path, strerror(errno));
        unlink(writer->temporary);
    }
    writer_free(writer);
    return failed ? FNL_ERROR_FILE : FNL_OK;
}

void file_write_abandon(struct file_writer *writer) {
    if (writer->stream) {
        fclose(writer->stream);
        unlink(writer->temporary);
    }
    writer_free(writer);
}

fnl_result file_save(const fnl_host *host, const char *path, const void *data, size_t size) {
    struct file_writer writer;
    TRY(file_write_begin(host, path, &writer));
    fwrite(data, 1, size, writer.stream);
    return file_write_commit(&writer);
}

bool path_folder(const char *path, char *out, size_t capacity) {
    const char *slash = strrchr(path, '/');
    size_t length = slash ? (size_t)(slash - path) + 1 : 0;
    if (length + 1 > capacity) return false;
    memcpy(out, path, length);
    out[length] = 0;
    return true;
}

const char *path_extension(const char *path) {
    const char *slash = strrchr(path, '/');
    const char *dot = strrchr(slash ? slash : path, '.');
    return dot ? dot + 1 : "";
}

bool path_has_extension(const char *path, const char *extension) { return strcasecmp(path_extension(path), extension) == 0; }
