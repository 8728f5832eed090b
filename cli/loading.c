/* SPDX-License-Identifier: MIT */
#include "loading.h"

#include "arguments.h"
#include "print.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool loading_has(int option) { return option >= LOADING_LENIENT && option < LOADING_END; }

bool loading_parse(int option, const char *value, fnl_load_params *out) {
    if (option == LOADING_LENIENT) out->lenient = true;
    if (option == LOADING_CONFINE) out->confine = true;
    return option != LOADING_MAX_MEMORY || argument_bytes("max-memory", value, &out->max_memory);
}

static bool find_variant(const fnl_scene *scene, uint32_t count, const char *wanted, uint32_t *out) {
    for (*out = 0; *out < count; ++*out) {
        fnl_entity_info info;
        if (fnl_scene_query_entity(scene, FNL_ENTITY_VARIANT, *out, &info) == FNL_OK && strcmp(info.name, wanted) == 0) return true;
    }
    char *end;
    const unsigned long index = strtoul(wanted, &end, 10);
    *out = (uint32_t)index;
    return *wanted >= '0' && *wanted <= '9' && !*end && index < count;
}

bool loading_select_variant(fnl_scene *scene, const char *variant, uint32_t *out) {
    if (out) *out = FNL_NO_VARIANT;
    if (!variant) return true;
    const uint32_t count = fnl_scene_count(scene, FNL_ENTITY_VARIANT);
    uint32_t index;
    if (find_variant(scene, count, variant, &index)) {
        if (out) *out = index;
        return fnl_scene_select_variant(scene, index) == FNL_OK;
    }
    fprintf(stderr, "fanal: error: --variant: the scene has no variant '%s'; it has %s", variant, count ? "" : "none");
    for (uint32_t i = 0; i < count; i++) {
        fnl_entity_info info = {.name = ""};
        (void)fnl_scene_query_entity(scene, FNL_ENTITY_VARIANT, i, &info);
        fprintf(stderr, "%s%u '%s'", i ? ", " : "", i, info.name);
    }
    fputc('\n', stderr);
    return false;
}

bool loading_is_builtin(const char *source) { return strncmp(source, "builtin:", 8) == 0; }

uint32_t loading_lights(const char *source, int64_t count, bool scattered, char *text, size_t capacity) {
    snprintf(text, capacity, "%s", source);
    if (count < 0) return 0;
    if (!loading_is_builtin(source)) return (uint32_t)count;
    char rest[1024] = "";
    const char *query = strchr(source, '?');
    const int name = query ? (int)(query - source) : (int)strlen(source);
    while (query && *query) { /* all keys but this one stay */
        const size_t length = strcspn(++query, "&");
        if (strncmp(query, "lights=", 7) != 0 && strlen(rest) + length + 2 < sizeof rest) {
            strcat(rest, "&");
            strncat(rest, query, length);
        }
        query += length;
    }
    snprintf(text, capacity, "%.*s?lights=%lld%s", name, source, scattered ? 0LL : (long long)count, rest);
    return scattered ? (uint32_t)count : 0;
}
