/* SPDX-License-Identifier: MIT */
#include "base/base.h"

#include <time.h>
#include <unistd.h>

#define STRINGIFY_(x) #x
#define STRINGIFY(x) STRINGIFY_(x)

const char *fnl_result_name(fnl_result result) {
    switch (result) {
    case FNL_OK:
        return "success";
    case FNL_ERROR_INVALID:
        return "invalid argument";
    case FNL_ERROR_FILE:
        return "file error";
    case FNL_ERROR_FORMAT:
        return "broken contents";
    case FNL_ERROR_UNSUPPORTED:
        return "not supported";
    case FNL_ERROR_MEMORY:
        return "out of memory";
    case FNL_ERROR_DEVICE:
        return "device error";
    case FNL_ERROR_DEVICE_LOST:
        return "device lost";
    case FNL_ERROR_CANCELLED:
        return "cancelled";
    }
    return "unknown result";
}

const char *fnl_version(void) {
    return STRINGIFY(FNL_VERSION_MAJOR) "." STRINGIFY(FNL_VERSION_MINOR) "." STRINGIFY(FNL_VERSION_PATCH);
}

/* ---- host ---- */

static void *default_reallocate(void *user, void *old, size_t old_size, size_t new_size) {
    UNUSED(user);
    UNUSED(old_size);
    if (new_size == 0) {
        free(old);
        return NULL;
    }
    return realloc(old, new_size);
}

static void default_log(void *user, fnl_log_level level, const char *line) {
    UNUSED(user);
    if (level >= FNL_LOG_WARNING) fprintf(stderr, "fanal: %s%s\n", level == FNL_LOG_ERROR ? "error: " : "warning: ", line);
}

fnl_host fnl_host_default(void) { return (fnl_host){.reallocate = default_reallocate, .log = default_log}; }

fnl_host host_resolve(const fnl_host *host) {
    fnl_host resolved = host ? *host : (fnl_host){0};
    if (!resolved.reallocate) resolved.reallocate = default_reallocate;
    if (!resolved.log) resolved.log = default_log;
    return resolved;
}

void *host_resize(const fnl_host *host, void *old, size_t old_size, size_t new_size) {
    if (new_size == 0) {
        host_free(host, old, old_size);
        return NULL;
    }
    void *block = host->reallocate(host->user, old, old_size, new_size);
    if (!block) log_error(host, "out of memory: %zu bytes were asked for", new_size);
    return block;
}

void *host_allocate(const fnl_host *host, size_t size) { return host_resize(host, NULL, 0, size); }

void *host_allocate_zero(const fnl_host *host, size_t size) {
    void *block = host_allocate(host, size);
    if (block) memset(block, 0, size);
    return block;
}

void host_free(const fnl_host *host, void *block, size_t size) {
    if (block) host->reallocate(host->user, block, size, 0);
}

uint64_t host_memory_limit(void) {
    const long pages = sysconf(_SC_PHYS_PAGES), page_size = sysconf(_SC_PAGESIZE);
    return pages > 0 && page_size > 0 ? (uint64_t)pages * (uint64_t)page_size / 2 : (uint64_t)4 << 30;
}

void host_log_list(const fnl_host *host, fnl_log_level level, const char *format, va_list arguments) {
    char line[2048];
    text_format_list(line, sizeof line, format, arguments);
    fnl_text_clean(line); /* names of files, and from them */
    host->log(host->user, level, line);
}

void host_log(const fnl_host *host, fnl_log_level level, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    host_log_list(host, level, format, arguments);
    va_end(arguments);
}

/* ---- text ---- */

/** Bytes of the character of UTF-8 that `text` begins with, and its code; 0 if it begins with none. */
static uint32_t utf8_length(const unsigned char *text, uint32_t *out_code) {
    static const uint32_t lowest[] = {0, 0, 0x80, 0x800, 0x10000};
    const uint32_t length = text[0] < 0x80 ? 1 : text[0] >> 5 == 6 ? 2 : text[0] >> 4 == 14 ? 3 : text[0] >> 3 == 30 ? 4 : 0;
    uint32_t code = length == 1 ? text[0] : text[0] & (0x7fu >> length);
    for (uint32_t i = 1; i < length; i++) {
        if (text[i] >> 6 != 2) return 0;
        code = code << 6 | (text[i] & 0x3f);
    }
    *out_code = code;
    return length && code >= lowest[length] && code <= 0x10ffff && code >> 11 != 0x1b ? length : 0; /* 0x1b: surrogates */
}

/** What changes more on a terminal than the place that it stands in: C0, DEL, C1, separators of lines, and what turns the direction of writing. */
static bool is_control(uint32_t code) {
    return code < 0x20 || (code >= 0x7f && code < 0xa0) || code == 0x61c || code == 0x200e || code == 0x200f ||
           (code >= 0x2028 && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069);
}

bool fnl_text_clean(char *text) {
    bool replaced = false;
    char *out = text;
    if (!text) return false;
    for (const char *in = text; *in;) {
        uint32_t code = 0, length = utf8_length((const unsigned char *)in, &code);
        if (length == 0 || is_control(code)) {
            *out++ = '?';
            in += MAX(length, 1u);
            replaced = true;
        } else {
            while (length--) *out++ = *in++;
        }
    }
    *out = 0;
    return replaced;
}

/* ---- arena ---- */

struct arena_block {
    struct arena_block *next;
    size_t size, used; /* bytes after the header */
};

enum { ARENA_HEADER = (sizeof(struct arena_block) + 15) / 16 * 16 };

void arena_init(struct arena *arena, const fnl_host *host, size_t block_size) {
    *arena = (struct arena){.host = host, .block_size = block_size};
}

void arena_finish(struct arena *arena) {
    for (struct arena_block *block = arena->first; block;) {
        struct arena_block *next = block->next;
        host_free(arena->host, block, ARENA_HEADER + block->size);
        block = next;
    }
    arena->first = arena->current = NULL;
}

void arena_adopt(struct arena *arena, struct arena *from) {
    struct arena_block **end = &from->first;
    while (*end) end = &(*end)->next;
    /* In front: what is allocated next goes on from the current block, or, where there is none, looks for one with room. */
    *end = arena->first;
    arena->first = from->first;
    if (!arena->current) arena->current = arena->first;
    from->first = from->current = NULL;
}

void arena_reset(struct arena *arena) {
    for (struct arena_block *block = arena->first; block; block = block->next) block->used = 0;
    arena->current = arena->first;
}

void *arena_allocate(struct arena *arena, size_t size) {
    if (size > SIZE_MAX - 64) {
        log_error(arena->host, "out of memory: %zu bytes were asked for", size);
        return NULL;
    }
    size = (size_t)align_up(size, 16);
    struct arena_block *block = arena->current;
    while (block && block->size - block->used < size) block = block->next;
    if (!block) {
        size_t capacity = MAX(size, arena->block_size);
        block = host_allocate(arena->host, ARENA_HEADER + capacity);
        if (!block) return NULL;
        *block = (struct arena_block){.size = capacity};
        /* Appended at the end, so that a reset arena is filled again in the same order. */
        struct arena_block **link = &arena->first;
        while (*link) link = &(*link)->next;
        *link = block;
    }
    arena->current = block;
    void *memory = (char *)block + ARENA_HEADER + block->used;
    block->used += size;
    return memory;
}

void *arena_allocate_zero(struct arena *arena, size_t size) {
    void *memory = arena_allocate(arena, size);
    if (memory) memset(memory, 0, size);
    return memory;
}

void *arena_copy(struct arena *arena, const void *data, size_t size) {
    void *memory = arena_allocate(arena, size);
    if (memory && size) memcpy(memory, data, size);
    return memory;
}

char *arena_string(struct arena *arena, const char *text) { return arena_copy(arena, text, strlen(text) + 1); }

char *arena_format(struct arena *arena, const char *format, ...) {
    va_list arguments, again;
    va_start(arguments, format);
    va_copy(again, arguments);
    int length = text_format_list(NULL, 0, format, arguments);
    va_end(arguments);
    char *text = length < 0 ? NULL : arena_allocate(arena, (size_t)length + 1);
    if (text) text_format_list(text, (size_t)length + 1, format, again);
    va_end(again);
    return text;
}

/* ---- arrays ---- */

bool array_reserve_raw(const fnl_host *host, void **data, uint32_t *capacity, uint64_t needed, size_t element_size) {
    if (needed <= *capacity) return true;
    uint64_t grown = MAX(needed, (uint64_t)*capacity + *capacity / 2 + 8);
    if (grown > UINT32_MAX || grown > SIZE_MAX / element_size) {
        log_error(host, "out of memory: an array of %llu elements was asked for", (unsigned long long)needed);
        return false;
    }
    void *block = host_resize(host, *data, *capacity * element_size, (size_t)grown * element_size);
    if (!block) return false;
    *data = block;
    *capacity = (uint32_t)grown;
    return true;
}

/* ---- hashing: 8 bytes a step, multiply and fold (the wyhash construction, Wang Yi 2019) ---- */

static uint64_t hash_mix(uint64_t a, uint64_t b) {
    __extension__ unsigned __int128 product = (unsigned __int128)a * b;
    return (uint64_t)product ^ (uint64_t)(product >> 64);
}

uint64_t hash_bytes(const void *data, size_t size, uint64_t seed) {
    const unsigned char *bytes = data;
    uint64_t hash = seed ^ (size * 0xa0761d6478bd642full);
    for (; size >= 8; bytes += 8, size -= 8) {
        uint64_t word;
        memcpy(&word, bytes, 8);
        hash = hash_mix(hash ^ 0xe7037ed1a0b428dbull, word ^ 0x8ebc6af09c88c6e3ull);
    }
    if (size) {
        uint64_t word = 0;
        memcpy(&word, bytes, size);
        hash = hash_mix(hash ^ 0x589965cc75374cc3ull, word ^ 0x1d8e4e27c47d124full);
    }
    return hash_mix(hash ^ 0xeb44accab455d165ull, 0x9e3779b97f4a7c15ull);
}

/* ---- random ---- */

uint64_t random_bits(struct random_state *random) {
    uint64_t z = random->state += 0x9e3779b97f4a7c15ull;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
}

float random_float(struct random_state *random) { return (float)(random_bits(random) >> 40) * 0x1p-24f; }

float random_range(struct random_state *random, float low, float high) { return low + (high - low) * random_float(random); }

/* ---- time ---- */

double time_now(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}
