/* SPDX-License-Identifier: MIT */
#include "output.h"

#include "print.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

/* ---- paths ---- */

/** The file that a path leads to, without symbolic links; the file itself need not be there. (src/base/file.c does so for what the library writes; no
 * public function would let the command use that.) */
static bool follow_links(const char *path, char target[PATH_MAX]) {
    enum { LINKS_MAX = 40 };
    char link[PATH_MAX];
    if (snprintf(target, PATH_MAX, "%s", path) >= PATH_MAX) return false;
    for (int i = 0; i < LINKS_MAX; i++) {
        ssize_t length = readlink(target, link, sizeof link - 1);
        if (length < 0) return true;
        link[length] = 0;
        const char *slash = strrchr(target, '/');
        size_t folder = slash && link[0] != '/' ? (size_t)(slash + 1 - target) : 0;
        if (folder + (size_t)length >= PATH_MAX) return false;
        memcpy(target + folder, link, (size_t)length + 1);
    }
    return false;
}

/** The same from the root on. */
static bool resolve(const char *path, char out[PATH_MAX]) {
    char target[PATH_MAX], folder[PATH_MAX];
    if (!follow_links(path, target)) return false;
    char *slash = strrchr(target, '/');
    const char *name = slash ? slash + 1 : target;
    if (slash) *slash = 0;
    if (!realpath(!slash ? "." : *target ? target : "/", folder)) return false;
    return snprintf(out, PATH_MAX, "%s/%s", strcmp(folder, "/") == 0 ? "" : folder, name) < PATH_MAX;
}

bool output_is_same(const char *a, const char *b) {
    char first[PATH_MAX], second[PATH_MAX];
    if (strcmp(a, b) == 0) return true;
    return resolve(a, first) && resolve(b, second) && strcmp(first, second) == 0;
}

/* ---- files ---- */

static bool complain(const char *path) {
    fprintf(stderr, "fanal: error: %s: cannot be written: %s\n", path, strerror(errno));
    return false;
}

bool output_check(const char *path) {
    char target[PATH_MAX];
    struct stat is;
    errno = ENAMETOOLONG;
    if (!follow_links(path, target)) return complain(path);
    if (stat(target, &is) == 0 && S_ISDIR(is.st_mode)) {
        errno = EISDIR;
        return complain(path);
    }
    if (stat(target, &is) == 0 && !S_ISREG(is.st_mode)) return true; /* a device or a pipe is written to as it is */
    char *slash = strrchr(target, '/');
    if (slash) *(slash == target ? slash + 1 : slash) = 0;
    const char *folder = slash ? target : ".";
    if (stat(folder, &is) != 0 && errno == ENOENT) {
        fprintf(stderr, "fanal: error: %s: cannot be written: there is no folder %s\n", path, folder);
        return false;
    }
    return access(folder, W_OK | X_OK) == 0 || complain(path);
}

const char *output_next_field(const char *pattern, const char **percent, int *width) {
    const char *at = strchr(pattern, '%');
    while (at && at[1] == '%') at = strchr(at + 2, '%');
    if (!at) return NULL;
    const size_t digits = strspn(at + 1, "0123456789");
    *percent = at;
    *width = digits ? atoi(at + 1) : 0;
    return at + 1 + digits;
}

size_t output_append(char *out, size_t used, size_t capacity, const char *part, size_t length) {
    for (size_t i = 0; i < length && used + 1 < capacity; i++) {
        out[used++] = part[i];
        i += part[i] == '%' && i + 1 < length && part[i + 1] == '%';
    }
    if (used < capacity) out[used] = 0;
    return used;
}

bool output_check_pattern(const char *pattern) {
    char path[PATH_MAX];
    const char *slash = strrchr(pattern, '/'), *percent;
    int width;
    if (slash && output_next_field(pattern, &percent, &width) && percent < slash) return true;
    output_append(path, 0, sizeof path, pattern, strlen(pattern));
    return output_check(path);
}

/* "fanal-PROCESS-NUMBER.part", as src/base/file.c names them too. */
static bool is_temporary(const char *name) {
    const size_t digits = strncmp(name, "fanal-", 6) == 0 ? strspn(name + 6, "0123456789abcdef-") : 0;
    return digits > 0 && strcmp(name + 6 + digits, ".part") == 0;
}

/* Removes what runs left behind in a folder that ended in the middle of writing: nobody has written to it for a day. */
static void remove_stale(const char *folder) {
    enum { DAY = 24 * 60 * 60 };
    DIR *directory = opendir(folder);
    if (!directory) return;
    for (struct dirent *entry; (entry = readdir(directory));) {
        struct stat is;
        if (is_temporary(entry->d_name) && fstatat(dirfd(directory), entry->d_name, &is, AT_SYMLINK_NOFOLLOW) == 0 && S_ISREG(is.st_mode) &&
            is.st_mtime < time(NULL) - DAY)
            unlinkat(dirfd(directory), entry->d_name, 0);
    }
    closedir(directory);
}

/* A new file beside the target. -1 with errno. */
static int open_temporary(const char *target, char temporary[PATH_MAX]) {
    static unsigned number;
    const char *slash = strrchr(target, '/');
    const int folder = slash ? (int)(slash + 1 - target) : 0;
    int descriptor;
    if (snprintf(temporary, PATH_MAX, "%.*s", folder, target) + (int)sizeof "fanal-12345678-12345678.part" > PATH_MAX) {
        errno = ENAMETOOLONG;
        return -1;
    }
    remove_stale(folder ? temporary : ".");
    do {
        snprintf(temporary + folder, PATH_MAX - (size_t)folder, "fanal-%08x-%08x.part", (unsigned)getpid(), number++);
        descriptor = open(temporary, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    } while (descriptor < 0 && errno == EEXIST);
    return descriptor;
}

bool output_begin(const char *path, struct output *out) {
    struct stat before;
    *out = (struct output){.path = path};
    errno = ENAMETOOLONG;
    if (!follow_links(path, out->target)) return complain(path);
    const bool exists = stat(out->target, &before) == 0, replaces = !exists || S_ISREG(before.st_mode);
    const int descriptor = replaces ? open_temporary(out->target, out->temporary) : open(out->target, O_WRONLY | O_CLOEXEC | O_NOCTTY);
    if (descriptor >= 0) out->stream = fdopen(descriptor, "wb");
    if (!out->stream) {
        complain(path);
        if (descriptor >= 0) close(descriptor);
        if (descriptor >= 0 && replaces) unlink(out->temporary);
        return false;
    }
    if (!replaces) out->temporary[0] = 0;
    if (exists && replaces) fchmod(descriptor, before.st_mode & 0777);
    return true;
}

bool output_commit(struct output *out) {
    bool good = !ferror(out->stream);
    if (!good) fputc(0, out->stream); /* what was wrong is known only at the time: once more, into a file that is dropped */
    errno = 0;
    good &= fflush(out->stream) == 0;
    int reason = errno ? errno : EIO;
    if (fclose(out->stream) != 0 && good) {
        good = false;
        reason = errno;
    }
    out->stream = NULL;
    if (good && out->temporary[0] && rename(out->temporary, out->target) != 0) {
        good = false;
        reason = errno;
    }
    if (good) return true;
    if (out->temporary[0]) unlink(out->temporary);
    errno = reason;
    return complain(out->path);
}

void output_abandon(struct output *out) {
    if (!out->stream) return;
    fclose(out->stream);
    out->stream = NULL;
    if (out->temporary[0]) unlink(out->temporary);
}

bool output_save(const char *path, const void *bytes, size_t size) {
    struct output out;
    if (!output_begin(path, &out)) return false;
    fwrite(bytes, 1, size, out.stream);
    return output_commit(&out);
}

bool output_make_folder(char out[PATH_MAX]) {
    const char *parent = getenv("TMPDIR");
    errno = ENAMETOOLONG;
    if (snprintf(out, PATH_MAX, "%s/fanal-XXXXXX", parent && *parent ? parent : "/tmp") < PATH_MAX && mkdtemp(out)) return true;
    fprintf(stderr, "fanal: error: %s: cannot be made: %s\n", out, strerror(errno));
    return false;
}

/* ---- what is printed ---- */

void output_guard_streams(void) {
    signal(SIGXFSZ, SIG_IGN);
    for (int i = 0; i <= 2; i++) /* writing to what is only for reading fails, as it should */
        if (fcntl(i, F_GETFD) < 0 && open("/dev/null", i == STDOUT_FILENO ? O_RDONLY : O_RDWR) != i) exit(2);
}

bool output_flush(void) {
    static bool told;
    errno = 0;
    bool good = fflush(stdout) == 0 && !ferror(stdout);
    if (!good && !told)
        fprintf(stderr, "fanal: error: the standard output cannot be written%s%s\n", errno ? ": " : "",
                errno ? strerror(errno) : "");
    told |= !good;
    return good;
}
