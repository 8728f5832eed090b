/* SPDX-License-Identifier: MIT */
/** Results, the host callbacks (memory, log, jobs) and the version. Every other header includes this one. */
#ifndef FANAL_BASE_H
#define FANAL_BASE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#if defined(_WIN32)
#define FNL_API
#else
#define FNL_API __attribute__((visibility("default")))
#endif

#ifdef __cplusplus
extern "C" {
#endif

#define FNL_VERSION_MAJOR 0
#define FNL_VERSION_MINOR 1
#define FNL_VERSION_PATCH 0

/**
 * What a call came to. Zero is success; each failure also sends one line to the host's log. That of misuse names the function, the argument
 * or field, its value and what it must be: "fnl_scene_add_light: range is -3, must be above 0 metres". A handle that is NULL has no host: the
 * built-in log tells it.
 */
typedef enum fnl_result {
    FNL_OK = 0,
    FNL_ERROR_INVALID,     /**< misuse: an argument is out of its stated range */
    FNL_ERROR_FILE,        /**< a file cannot be opened, read or written */
    FNL_ERROR_FORMAT,      /**< a file's contents are broken */
    FNL_ERROR_UNSUPPORTED, /**< the contents are valid, but need something that is not built or not on this device */
    FNL_ERROR_MEMORY,      /**< host or device memory ran out */
    FNL_ERROR_DEVICE,      /**< no usable Vulkan device, or a Vulkan call failed */
    FNL_ERROR_DEVICE_LOST, /**< the device stopped answering; every object of it must be destroyed */
    FNL_ERROR_CANCELLED,   /**< the host's own callback ended it (fnl_load_params.progress); nothing is logged */
} fnl_result;

/** The result's name in words, such as "broken contents". Never NULL. */
FNL_API const char *fnl_result_name(fnl_result result);

/** The version of the library at run time, such as "0.1.0". */
FNL_API const char *fnl_version(void);

typedef enum fnl_log_level {
    FNL_LOG_DEBUG = 0,
    FNL_LOG_INFO,
    FNL_LOG_WARNING,
    FNL_LOG_ERROR,
} fnl_log_level;

/**
 * How Fanal reaches its surroundings. Copied by value into each object that is created with it, so the callbacks and
 * what `user` points to must outlive those objects. All callbacks may be called from several threads at once.
 * NULL callbacks mean the built-in ones.
 */
typedef struct fnl_host {
    void *user;
    /**
     * Allocates (old NULL), resizes, or frees (new_size 0). Aligned to 16 bytes. Returns NULL when memory ran out (the
     * old block then stays valid) and when it frees. Default: realloc and free.
     */
    void *(*reallocate)(void *user, void *old, size_t old_size, size_t new_size);
    /** Receives one line of text without a line break or other control characters. Default: warnings and errors go to stderr. */
    void (*log)(void *user, fnl_log_level level, const char *line);
    /** Calls run(context, i) for every i below count, on any threads, and returns when all are done. Default: a pool. */
    void (*parallel_for)(void *user, uint32_t count, void (*run)(void *context, uint32_t index), void *context);
    /** Number of threads that parallel_for spreads over; sizes the default pool. 0: one per processor. Default 0. */
    uint32_t thread_count;
} fnl_host;

/** A host with all defaults. */
FNL_API fnl_host fnl_host_default(void);

/**
 * Makes text that comes from a file, such as a name, safe to print on a terminal: each control character (line breaks, escape sequences, C1), each Unicode
 * line separator and bidirectional control, and each byte that is not UTF-8 becomes one '?'. Returns whether anything was replaced.
 * Lines of the log are safe already; names that a scene returns are not.
 */
FNL_API bool fnl_text_clean(char *text);

typedef struct fnl_vec2 {
    float x, y;
} fnl_vec2;
typedef struct fnl_vec3 {
    float x, y, z;
} fnl_vec3;
typedef struct fnl_vec4 {
    float x, y, z, w;
} fnl_vec4;
/** Column-major 4x4 matrix: m[column * 4 + row], as glTF stores it. */
typedef struct fnl_mat4 {
    float m[16];
} fnl_mat4;

#ifdef __cplusplus
}
#endif
#endif
