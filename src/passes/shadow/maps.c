/* SPDX-License-Identifier: MIT */
#include "passes/shadow/maps.h"

void shadow_maps_use(struct graph_pass *pass, const struct shadow_maps *maps, enum graph_use use) {
    graph_use_buffer(pass, maps->held, use);
    graph_use_buffer(pass, maps->before, use);
    graph_use_buffer(pass, maps->pages, use);
    graph_use_buffer(pass, maps->biases, use);
    graph_use_buffer(pass, maps->shapes, use);
    if (maps->suns.id) graph_use_buffer(pass, maps->suns, use);
    if (maps->planes.id) graph_use_buffer(pass, maps->keys, use);
    if (maps->planes.id) graph_use_buffer(pass, maps->planes, use);
    graph_use_image(pass, maps->atlas, use == GRAPH_READ_COMPUTE ? GRAPH_SAMPLE_COMPUTE : GRAPH_SAMPLE_FRAGMENT);
}
