/* SPDX-License-Identifier: MIT */
#include "base/file.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdatomic.h>
#include <strings.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

static const char *kind_name(mode_t mode) {
    return S_ISDIR(mode)    ? "a folder"
           : S_ISFIFO(mode) ? "a pipe"
           : S_ISSOCK(mode) ? "a socket"
                            : "a device";
}

/* ---- reading ---- */

bool file_identify(const char *path, struct file_identity *out) {
    struct stat status;
    if (stat(path, &status) != 0) return false;
    *out = (struct file_identity){(uint64_t)status.st_dev, (uint64_t)status.st_ino, (uint64_t)status.st_size};
    return true;
}

/* Read, not mapped: a mapping ends the process by SIGBUS when another program makes the file shorter. */
static fnl_result read_all(const fnl_host *host, const char *path, int descriptor, unsigned char *data, size_t size) {
    for (size_t done = 0; done < size;) {
        ssize_t got = read(descriptor, data + done, size - done);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) {
            log_error(host, "%s: cannot be read: %s", path, got < 0 ? strerror(errno) : "it became shorter meanwhile");
            return FNL_ERROR_FILE;
        }
        done += (size_t)got;
    }
    return FNL_OK;
}

fnl_result file_load(const fnl_host *host, const char *path, struct file_view *out) {
    *out = (struct file_view){0};
    /* Without O_NONBLOCK, opening a pipe waits for somebody to write to it. */
    int descriptor = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    struct stat status;
    if (descriptor < 0 || fstat(descriptor, &status) != 0) {
        log_error(host, "%s: cannot be opened: %s", path, strerror(errno));
        if (descriptor >= 0) close(descriptor);
        return FNL_ERROR_FILE;
    }
    fnl_result result = FNL_OK;
    unsigned char *data = NULL;
    size_t size = (size_t)status.st_size;
    if (!S_ISREG(status.st_mode)) {
        log_error(host, "%s: is %s, not a regular file", path, kind_name(status.st_mode));
        result = FNL_ERROR_FILE;
    } else if (size > 0) {
        data = host_allocate(host, size);
        result = data ? read_all(host, path, descriptor, data, size) : FNL_ERROR_MEMORY;
    }
    close(descriptor);
    if (result != FNL_OK) {
        host_free(host, data, size);
        return result;
    }
    *out = (struct file_view){data, size, {(uint64_t)status.st_dev, (uint64_t)status.st_ino, (uint64_t)status.st_size}};
    return FNL_OK;
}

void file_free(const fnl_host *host, struct file_view *view) {
    host_free(host, (void *)(uintptr_t)view->data, view->size);
    *view = (struct file_view){0};
}

/* ---- writing ---- */

/** Follows symbolic links, also to where no file is yet, so that replacing the file leaves the links. False with errno. */
static bool follow_links(const char *path, char target[PATH_MAX]) {
    enum { LINKS_MAX = 40 }; /* as Linux */
    char link[PATH_MAX];
    if (snprintf(target, PATH_MAX, "%s", path) >= PATH_MAX) {
        errno = ENAMETOOLONG;
        return false;
    }
    for (int i = 0; i < LINKS_MAX; i++) {
        ssize_t length = readlink(target, link, sizeof link - 1);
        if (length < 0) return true; /* no link; if something is wrong with it, opening says so */
        link[length] = 0;
        size_t folder = 0;
        if (link[0] != '/' && strrchr(target, '/')) folder = (size_t)(strrchr(target, '/') + 1 - target);
        if (folder + (size_t)length >= PATH_MAX) {
            errno = ENAMETOOLONG;
            return false;
        }
        memcpy(target + folder, link, (size_t)length + 1);
    }
    errno = ELOOP;
    return false;
}

/** "fanal-PROCESS-NUMBER.part", as cli/output.c names them too. */
static bool is_temporary(const char *name) {
    const size_t digits = strncmp(name, "fanal-", 6) == 0 ? strspn(name + 6, "0123456789abcdef-") : 0;
    return digits > 0 && strcmp(name + 6 + digits, ".part") == 0;
}

/** Removes what programs left behind in a folder that ended in the middle of writing: nobody has written to it for a day. Not before each of many pictures. */
static void remove_stale(const char *folder) {
    enum { DAY = 24 * 60 * 60 };
    static atomic_ullong last;
    const uint64_t hash = hash_bytes(folder, strlen(folder), HASH_SEED);
    DIR *directory = atomic_exchange(&last, hash) == hash ? NULL : opendir(folder);
    if (!directory) return;
    for (struct dirent *entry; (entry = readdir(directory));) {
        struct stat status;
        if (is_temporary(entry->d_name) && fstatat(dirfd(directory), entry->d_name, &status, AT_SYMLINK_NOFOLLOW) == 0 && S_ISREG(status.st_mode) &&
            status.st_mtime < time(NULL) - DAY)
            unlinkat(dirfd(directory), entry->d_name, 0);
    }
    closedir(directory);
}

/** A new file beside the target, under a name that no other thread or process has. -1 with errno. */
static int open_temporary(const char *target, char *name, size_t capacity) {
    static atomic_uint counter;
    const char *slash = strrchr(target, '/');
    int folder = slash ? (int)(slash + 1 - target) : 0, descriptor;
    snprintf(name, capacity, "%.*s", folder, target);
    remove_stale(folder ? name : ".");
    do {
        /* Short, whatever the target is called: names have a limit. */
        snprintf(name, capacity, "%.*sfanal-%08x-%08x.part", folder, target, (unsigned)getpid(),
                 atomic_fetch_add(&counter, 1));
        descriptor = open(name, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    } while (descriptor < 0 && errno == EEXIST); /* left behind by a process that was killed */
    return descriptor;
}

/** The file that is replaced hands down its mode and, where that is allowed, its owner. */
static void keep_mode(int descriptor, const struct stat *before) {
    struct stat now;
    if (fstat(descriptor, &now) != 0) return;
    bool other_owner = now.st_uid != before->st_uid || now.st_gid != before->st_gid;
    if (other_owner && fchown(descriptor, before->st_uid, before->st_gid) != 0) errno = 0; /* only root may */
    fchmod(descriptor, before->st_mode & 0777);
}

static void writer_free(struct file_writer *writer) {
    host_free(&writer->host, writer->path, writer->names_size);
    *writer = (struct file_writer){0};
}

fnl_result file_write_begin(const fnl_host *host, const char *path, struct file_writer *out) {
    enum { TEMPORARY_NAME_SIZE = sizeof "fanal-12345678-12345678.part" };
    char target[PATH_MAX];
    struct stat before;
    *out = (struct file_writer){.host = *host};
    if (!follow_links(path, target)) {
        log_error(host, "%s: cannot be written: %s", path, strerror(errno));
        return FNL_ERROR_FILE;
    }
    bool exists = stat(target, &before) == 0;
    if (exists && !S_ISREG(before.st_mode)) { /* a device must not become a file */
        log_error(host, "%s: cannot be written: it is %s, not a regular file", path, kind_name(before.st_mode));
        return FNL_ERROR_FILE;
    }
    size_t path_size = strlen(path) + 1, target_size = strlen(target) + 1;
    out->names_size = path_size + target_size + target_size + TEMPORARY_NAME_SIZE;
    out->path = host_allocate(host, out->names_size);
    if (!out->path) return FNL_ERROR_MEMORY;
    out->target = out->path + path_size;
    out->temporary = out->target + target_size;
    memcpy(out->path, path, path_size);
    memcpy(out->target, target, target_size);
    int descriptor = open_temporary(target, out->temporary, target_size + TEMPORARY_NAME_SIZE);
    out->stream = descriptor >= 0 ? fdopen(descriptor, "wb") : NULL;
    if (!out->stream) {
        log_error(host, "%s: cannot be written: %s", path, strerror(errno));
        if (descriptor >= 0) {
            close(descriptor);
            unlink(out->temporary);
        }
        writer_free(out);
        return FNL_ERROR_FILE;
    }
    if (exists) keep_mode(descriptor, &before);
    return FNL_OK;
}

fnl_result file_write_commit(struct file_writer *writer) {
    if (!writer->stream) return FNL_ERROR_INVALID;
    bool failed = ferror(writer->stream);
    if (failed) fputc(0, writer->stream); /* what was wrong is known only at the time: once more, into a file that is dropped */
    errno = 0;
    failed |= fflush(writer->stream) != 0;
    if (failed && errno == 0) errno = EIO;
    int reason = errno;
    if (fclose(writer->stream) != 0 && !failed) {
        failed = true;
        reason = errno;
    }
    writer->stream = NULL;
    if (!failed && rename(writer->temporary, writer->target) != 0) {
        failed = true;
        reason = errno;
    }
    if (failed) {
        log_error(&writer->host, "%s: cannot be written: %s", writer->path, strerror(reason));
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

bool path_real(const char *path, char *out, size_t capacity) {
    char *real = realpath(path, NULL);
    bool fits = real && strlen(real) < capacity;
    if (fits)
        strcpy(out, real);
    else if (real)
        errno = ENAMETOOLONG;
    free(real);
    return fits;
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
