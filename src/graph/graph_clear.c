/* SPDX-License-Identifier: MIT */
#include "graph/graph.h"

static void execute_clear(const struct graph_context *context, const void *data) {
    const struct graph_clear *clear = data;
    for (uint32_t i = 0; i < COUNT_OF(clear->buffers); i++) {
        if (!clear->buffers[i].id) continue;
        const struct gpu_buffer *buffer = graph_get_buffer(context, clear->buffers[i]);
        gpu_fill_buffer(context->commands, buffer, 0, buffer->size, clear->word);
    }
}

void graph_add_clear(struct graph *graph, const char *name, enum graph_queue queue, struct graph_clear clear) {
    struct graph_pass *pass = graph_add_pass(graph, name, queue, execute_clear, &clear, sizeof clear);
    for (uint32_t i = 0; i < COUNT_OF(clear.buffers); i++)
        if (clear.buffers[i].id) graph_use_buffer(pass, clear.buffers[i], GRAPH_COPY_TO);
}
