/* SPDX-License-Identifier: MIT */
/** Names of a frame's passes and resources: made from parts, put into scopes, and each kept once for the life of the graph. */
#include "graph/graph_internal.h"

enum { NAME_LIMIT = 256, NAMES_BLOCK = 16 << 10 };

struct graph_kept_name {
    struct graph_kept_name *next;
    char text[];
};

void graph_names_init(struct graph *graph) { arena_init(&graph->names.arena, &graph->host, NAMES_BLOCK); }
void graph_names_finish(struct graph *graph) { arena_finish(&graph->names.arena); }

static const char *keep(struct graph *graph, const char *text) {
    size_t size = strlen(text) + 1;
    struct graph_kept_name **first = &graph->names.buckets[hash_bytes(text, size, HASH_SEED) % GRAPH_NAME_BUCKETS];
    for (struct graph_kept_name *name = *first; name; name = name->next)
        if (strcmp(name->text, text) == 0) return name->text;
    struct graph_kept_name *name = arena_allocate(&graph->names.arena, sizeof *name + size);
    if (!name) {
        graph_fail(graph, FNL_ERROR_MEMORY);
        return "out of memory";
    }
    name->next = *first;
    memcpy(name->text, text, size);
    *first = name;
    return name->text;
}

__attribute__((format(printf, 2, 0))) static const char *keep_formatted(struct graph *graph, const char *format,
                                                                        va_list arguments) {
    char text[NAME_LIMIT];
    if (text_format_list(text, sizeof text, format, arguments) >= (int)sizeof text)
        graph_misuse(graph, "the name '%s…' is longer than %d bytes", text, NAME_LIMIT - 1);
    return keep(graph, text);
}

const char *graph_name(struct graph *graph, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    const char *name = keep_formatted(graph, format, arguments);
    va_end(arguments);
    return name;
}

const char *graph_numbered_name(struct graph *graph, const char *name, uint32_t number) {
    return number ? graph_name(graph, "%s %u", name, number) : name;
}

const char *graph_scoped_name(struct graph *graph, const char *name) {
    const struct graph_names *names = &graph->names;
    return names->depth && name ? graph_name(graph, "%s%s", names->prefixes[names->depth - 1], name) : name;
}

void graph_push_names(struct graph *graph, const char *name) {
    struct graph_names *names = &graph->names;
    if (names->depth == GRAPH_NAME_SCOPES) {
        graph_misuse(graph, "names '%s' are pushed below '%s', which is deeper than %d", name,
                     names->prefixes[names->depth - 1], GRAPH_NAME_SCOPES);
        names->lost++;
        return;
    }
    const char *prefix = graph_name(graph, "%s%s/", names->depth ? names->prefixes[names->depth - 1] : "", name);
    names->prefixes[names->depth++] = prefix;
}

void graph_pop_names(struct graph *graph) {
    struct graph_names *names = &graph->names;
    if (names->lost)
        names->lost--;
    else if (names->depth)
        names->depth--;
    else
        graph_misuse(graph, "names are popped that were not pushed");
}

void graph_check_names(struct graph *graph) {
    const struct graph_names *names = &graph->names;
    if (names->depth) graph_misuse(graph, "names '%s' are pushed and never popped", names->prefixes[names->depth - 1]);
    uint32_t capacity = 16;
    while (capacity < graph->passes.count * 2) capacity *= 2;
    const char **table = ARENA_ARRAY(&graph->arena, const char *, capacity);
    if (!table) {
        graph_fail(graph, FNL_ERROR_MEMORY);
        return;
    }
    for (uint32_t i = 0; i < graph->passes.count; i++) {
        const char *name = graph->passes.data[i]->name;
        uint32_t slot = (uint32_t)hash_bytes(name, strlen(name), HASH_SEED) & (capacity - 1);
        while (table[slot] && strcmp(table[slot], name) != 0) slot = (slot + 1) & (capacity - 1);
        if (table[slot]) graph_misuse(graph, "two passes are called '%s'", name);
        table[slot] = name;
    }
}
