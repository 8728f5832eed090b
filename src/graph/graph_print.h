/* SPDX-License-Identifier: MIT */
/** What prints plans: as text (graph_print.c) and as JSON (graph_print_json.c). */
#ifndef FNL_GRAPH_PRINT_H
#define FNL_GRAPH_PRINT_H

#include "graph/graph_internal.h"

struct printer {
    const struct graph *graph;
    char *text;
    size_t capacity, length;
};

/** Appends as much as fits. */
void print_put(struct printer *printer, const char *format, ...) __attribute__((format(printf, 2, 3)));
/** In Vulkan's names without prefix and suffix, with | between; NONE. */
void print_stages(struct printer *printer, VkPipelineStageFlags2 stages);
void print_access(struct printer *printer, VkAccessFlags2 access);
const char *print_layout_name(VkImageLayout layout);

#endif
