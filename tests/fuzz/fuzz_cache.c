/* SPDX-License-Identifier: MIT */
/* Files of the cache folder: choices of `auto`, and the header of pipeline caches. */
#define gpu_pipeline_cache_load fuzz_pipeline_cache_load /* the layer has its own */
#define gpu_pipeline_cache_save fuzz_pipeline_cache_save
#define gpu_cache_load fuzz_cache_load
#define gpu_cache_save fuzz_cache_save
#define gpu_cache_open fuzz_cache_open
#define gpu_cache_has_folder fuzz_cache_has_folder
#define gpu_cache_trim fuzz_cache_trim
#include "gpu/pipeline_cache.c"

#include "render/chooser.h"
#include "tests/fuzz/fuzz.h"

static void check_choices(const uint8_t *bytes, size_t size) {
    static struct chooser chooser, again;
    static char text[CHOOSER_MEMORY * 400];
    memset(&chooser, 0, sizeof chooser);
    memset(&again, 0, sizeof again);
    chooser_parse(&chooser, (const char *)bytes, size);
    if (chooser.memory_count > CHOOSER_MEMORY) abort();
    size_t length = chooser_print(&chooser, text, sizeof text);
    if (length >= sizeof text || length != chooser_print(&chooser, NULL, 0)) abort();
    chooser_parse(&again, text, length);
    if (again.memory_count != chooser.memory_count) abort();
    for (uint32_t i = 0; i < chooser.memory_count; i++) {
        const struct remembered_choice *a = &chooser.memory[i], *b = &again.memory[i];
        if (a->key != b->key || a->choice.shading != b->choice.shading || a->choice.lists != b->choice.lists) abort();
        if (a->choice.shading >= FNL_SHADING_AUTO || a->choice.lists >= FNL_LISTS_AUTO) abort();
        if (!isfinite(a->milliseconds) || a->milliseconds < 0) abort();
        struct choice_case at = {.asked = {FNL_SHADING_AUTO, FNL_LISTS_AUTO}, .scene = a->key, .msaa = 1, .pixel_count = 100};
        struct choice choice = chooser_pick(&chooser, &at, i % 2, (struct chooser_background){0});
        if (!fnl_shading_supports(choice.shading, choice.lists, 1)) abort();
    }
}

/* The header is made to agree, but for what the input asks to leave as it is, so that what comes behind it is reached. */
static void check_pipelines(const uint8_t *bytes, size_t size) {
    static gpu_device device; /* nothing of it is used but its properties, all zero */
    unsigned char *copy = malloc(size + 1);
    if (!copy) abort();
    memcpy(copy, bytes, size);
    struct cache_header header;
    uint8_t mends = size ? bytes[size - 1] : 0;
    if (size >= sizeof header) {
        memcpy(&header, copy, sizeof header);
        if (mends & 1) memcpy(header.magic, cache_magic, sizeof cache_magic);
        if (mends & 2) header.size = size - sizeof header;
        if (mends & 4) header.hash = hash_bytes(copy + sizeof header, size - sizeof header, HASH_SEED);
        memcpy(copy, &header, sizeof header);
    }
    struct file_view view = {.data = copy, .size = size};
    const char *reason;
    size_t taken = 0;
    const void *data = check_file(&device, &view, &taken, &reason);
    if (data && ((const unsigned char *)data != copy + sizeof header || taken != size - sizeof header)) abort();
    if (!data && !reason) abort();
    free(copy);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    if (size == 0) return 0;
    if (*bytes % 2)
        check_choices(bytes + 1, size - 1);
    else
        check_pipelines(bytes + 1, size - 1);
    return 0;
}
