/* SPDX-License-Identifier: MIT */
/* Compiled pipelines between runs: one file for each device and driver version. */
#include "base/file.h"
#include "gpu/gpu_internal.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

/* Before the driver's data, because drivers trust what they are given. */
struct cache_header {
    char magic[8];
    uint64_t size, hash; /* of what follows */
};
static const char cache_magic[8] = "FNLPIPE1";

static void no_log(void *user, fnl_log_level level, const char *line) {
    UNUSED(user);
    UNUSED(level);
    UNUSED(line);
}

/** Makes a folder and those above it. */
static bool make_folders(char *path) {
    for (char *slash = strchr(path + 1, '/'); slash; slash = strchr(slash + 1, '/')) {
        *slash = 0;
        bool made = mkdir(path, 0755) == 0 || errno == EEXIST;
        *slash = '/';
        if (!made) return false;
    }
    return mkdir(path, 0755) == 0 || errno == EEXIST;
}

/** The folder that the params ask for; false when there is none. */
static bool find_folder(const char *asked, char *out, size_t capacity) {
    const char *cache = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
    int length;
    if (asked) {
        length = snprintf(out, capacity, "%s", asked);
    } else if (cache && cache[0] == '/') { /* relative paths are to be ignored (XDG Base Directory Specification) */
        length = snprintf(out, capacity, "%s/fanal", cache);
    } else if (home && home[0]) {
        length = snprintf(out, capacity, "%s/.cache/fanal", home);
    } else {
        return false;
    }
    return length > 0 && (size_t)length < capacity && make_folders(out) && access(out, W_OK | X_OK) == 0;
}

static bool set_path(gpu_device *device, const char *cache_folder) {
    char folder[3072], name[64 + 2 * VK_UUID_SIZE];
    if (!find_folder(cache_folder, folder, sizeof folder)) return false;
    size_t length = (size_t)snprintf(name, sizeof name, "/pipelines-");
    for (uint32_t i = 0; i < VK_UUID_SIZE; i++)
        length += (size_t)snprintf(name + length, sizeof name - length, "%02x", device->properties.pipelineCacheUUID[i]);
    snprintf(name + length, sizeof name - length, "-%08x.bin", device->properties.driverVersion);
    size_t size = strlen(folder) + strlen(name) + 1;
    char *path = host_allocate(&device->host, size);
    if (!path) return false;
    snprintf(path, size, "%s%s", folder, name);
    device->pipelines.cache_path = path;
    device->pipelines.cache_path_size = size;
    return true;
}

/** The driver's part of a file, or NULL with the reason. */
static const void *check_file(const gpu_device *device, const struct file_view *file, size_t *size, const char **reason) {
    struct cache_header header;
    VkPipelineCacheHeaderVersionOne driver;
    *reason = "it is no pipeline cache";
    if (file->size < sizeof header + sizeof driver) return NULL;
    memcpy(&header, file->data, sizeof header);
    const unsigned char *data = file->data + sizeof header;
    if (memcmp(header.magic, cache_magic, sizeof cache_magic) != 0) return NULL;
    *reason = "it is damaged";
    if (header.size != file->size - sizeof header || header.hash != hash_bytes(data, (size_t)header.size, HASH_SEED))
        return NULL;
    memcpy(&driver, data, sizeof driver);
    *reason = "it is of another device";
    if (driver.headerVersion != VK_PIPELINE_CACHE_HEADER_VERSION_ONE || driver.vendorID != device->properties.vendorID ||
        driver.deviceID != device->properties.deviceID ||
        memcmp(driver.pipelineCacheUUID, device->properties.pipelineCacheUUID, VK_UUID_SIZE) != 0)
        return NULL;
    *size = (size_t)header.size;
    return data;
}

fnl_result gpu_pipeline_cache_load(gpu_device *device, const char *cache_folder) {
    struct gpu_pipelines *pipelines = &device->pipelines;
    bool kept = (!cache_folder || cache_folder[0]) && set_path(device, cache_folder);
    struct file_view file = {0};
    VkPipelineCacheCreateInfo info = {.sType = VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO};
    if (kept && access(pipelines->cache_path, R_OK) == 0 &&
        file_load(&device->host, pipelines->cache_path, &file) == FNL_OK) {
        const char *reason;
        info.pInitialData = check_file(device, &file, &info.initialDataSize, &reason);
        if (!info.pInitialData) log_debug(&device->host, "%s: not used: %s", pipelines->cache_path, reason);
    }
    pipelines->loaded_size = info.initialDataSize;
    if (info.initialDataSize) pipelines->loaded_hash = hash_bytes(info.pInitialData, info.initialDataSize, HASH_SEED);
    VkResult result = device->vk.CreatePipelineCache(device->handle, &info, NULL, &pipelines->cache);
    file_free(&device->host, &file);
    return gpu_check(device, result, "vkCreatePipelineCache");
}

/** The path of another file of the folder, for the same device and driver. */
static bool sibling_path(const gpu_device *device, const char *stem, char *out, size_t capacity) {
    const char *path = device->pipelines.cache_path;
    if (!path) return false;
    const char *name = strrchr(path, '/') + 1;
    int length = snprintf(out, capacity, "%.*s%s%s", (int)(name - path), path, stem, name + strlen("pipelines"));
    return length > 0 && (size_t)length < capacity;
}

bool gpu_cache_load(gpu_device *device, const char *stem, struct file_view *out) {
    char path[4096];
    *out = (struct file_view){0};
    return sibling_path(device, stem, path, sizeof path) && access(path, R_OK) == 0 &&
           file_load(&device->host, path, out) == FNL_OK;
}

FILE *gpu_cache_open(gpu_device *device, const char *stem) {
    char path[4096];
    struct stat status;
    const int file = sibling_path(device, stem, path, sizeof path) ? open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY) : -1;
    FILE *out = file >= 0 && fstat(file, &status) == 0 && S_ISREG(status.st_mode) ? fdopen(file, "rb") : NULL;
    if (!out && file >= 0) close(file);
    if (!out) return NULL;
    setvbuf(out, NULL, _IONBF, 0);
    (void)futimens(file, NULL); /* gpu_cache_trim() goes by it */
    return out;
}

bool gpu_cache_has_folder(const gpu_device *device) { return device->pipelines.cache_path != NULL; }

void gpu_cache_save(gpu_device *device, const char *stem, const void *data, size_t size) {
    char path[4096];
    if (!sibling_path(device, stem, path, sizeof path)) return;
    fnl_host quiet = device->host;
    quiet.log = no_log;
    if (file_save(&quiet, path, data, size) != FNL_OK) log_debug(&device->host, "%s: cannot be written", path);
}

struct kept_file {
    char name[256];
    uint64_t size;
    struct timespec used;
};

static int by_last_use(const void *a, const void *b) { /* latest first */
    const struct kept_file *x = a, *y = b;
    if (x->used.tv_sec != y->used.tv_sec) return x->used.tv_sec > y->used.tv_sec ? -1 : 1;
    if (x->used.tv_nsec != y->used.tv_nsec) return x->used.tv_nsec > y->used.tv_nsec ? -1 : 1;
    return strcmp(x->name, y->name);
}

void gpu_cache_trim(gpu_device *device, const char *stem, uint64_t most_bytes) {
    char folder[4096];
    ARRAY(struct kept_file) files = {0};
    DIR *directory = device->pipelines.cache_path && path_folder(device->pipelines.cache_path, folder, sizeof folder) ? opendir(folder) : NULL;
    if (!directory) return;
    for (struct dirent *entry; (entry = readdir(directory));) {
        struct stat status;
        struct kept_file file;
        if (strncmp(entry->d_name, stem, strlen(stem)) != 0 || strlen(entry->d_name) >= sizeof file.name) continue;
        if (fstatat(dirfd(directory), entry->d_name, &status, AT_SYMLINK_NOFOLLOW) != 0 || !S_ISREG(status.st_mode)) continue;
        file = (struct kept_file){.size = (uint64_t)status.st_size, .used = status.st_mtim};
        strcpy(file.name, entry->d_name);
        if (!array_push(&device->host, &files, file)) break;
    }
    if (files.count) qsort(files.data, files.count, sizeof *files.data, by_last_use);
    uint64_t sum = 0;
    for (uint32_t i = 0; i < files.count; i++) {
        sum += files.data[i].size;
        if (sum > most_bytes) (void)unlinkat(dirfd(directory), files.data[i].name, 0);
    }
    closedir(directory);
    array_free(&device->host, &files);
}

/** Adds what another process has saved meanwhile, so that the file keeps it. */
static void merge_file(gpu_device *device) {
    struct gpu_pipelines *pipelines = &device->pipelines;
    struct file_view file;
    VkPipelineCacheCreateInfo info = {.sType = VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO};
    const char *reason;
    if (!gpu_cache_load(device, "pipelines", &file)) return;
    info.pInitialData = check_file(device, &file, &info.initialDataSize, &reason);
    bool known = info.initialDataSize == pipelines->loaded_size && info.pInitialData &&
                 hash_bytes(info.pInitialData, info.initialDataSize, HASH_SEED) == pipelines->loaded_hash;
    VkPipelineCache other = VK_NULL_HANDLE;
    if (info.pInitialData && !known &&
        device->vk.CreatePipelineCache(device->handle, &info, NULL, &other) == VK_SUCCESS)
        device->vk.MergePipelineCaches(device->handle, pipelines->cache, 1, &other);
    device->vk.DestroyPipelineCache(device->handle, other, NULL);
    file_free(&device->host, &file);
}

/**
 * One process at a time loads, merges and saves. False: another has the lock, and may keep it for ever. -1: there is no lock to be had; then the last one
 * wins, with a whole file.
 */
static bool lock_folder(const char *path, int *lock) {
    char folder[4096];
    *lock = path_folder(path, folder, sizeof folder) ? open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC) : -1;
    if (*lock < 0 || flock(*lock, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return true;
    close(*lock);
    return false;
}

static void write_file(gpu_device *device) {
    struct gpu_pipelines *pipelines = &device->pipelines;
    size_t size = 0;
    merge_file(device);
    if (device->vk.GetPipelineCacheData(device->handle, pipelines->cache, &size, NULL) != VK_SUCCESS) return;
    size_t capacity = sizeof(struct cache_header) + size;
    unsigned char *bytes = host_allocate(&device->host, capacity);
    if (!bytes) return;
    if (device->vk.GetPipelineCacheData(device->handle, pipelines->cache, &size, bytes + sizeof(struct cache_header)) ==
        VK_SUCCESS) {
        struct cache_header header = {.size = size, .hash = hash_bytes(bytes + sizeof header, size, HASH_SEED)};
        memcpy(header.magic, cache_magic, sizeof cache_magic);
        memcpy(bytes, &header, sizeof header);
        gpu_cache_save(device, "pipelines", bytes, sizeof header + size);
    }
    host_free(&device->host, bytes, capacity);
}

void gpu_pipeline_cache_save(gpu_device *device) {
    struct gpu_pipelines *pipelines = &device->pipelines;
    size_t size = 0;
    if (!pipelines->cache_path || !pipelines->cache) return;
    if (device->vk.GetPipelineCacheData(device->handle, pipelines->cache, &size, NULL) != VK_SUCCESS) return;
    if (size <= pipelines->loaded_size) return;
    int lock;
    if (!lock_folder(pipelines->cache_path, &lock)) {
        log_info(&device->host, "%s: not written: another program has locked its folder; pipelines are compiled again in the next run", pipelines->cache_path);
        return;
    }
    write_file(device);
    if (lock >= 0) close(lock); /* which unlocks it */
}
