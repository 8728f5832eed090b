/* SPDX-License-Identifier: MIT */
/**
 * Deferred attribute interpolation: the geometry pass stores for each sample a reference to a triangle, and each triangle that is seen
 * once; a compute pass interpolates its attributes, evaluates materials and lights (Schied and Dachsbacher, GPU Pro 7, II.3).
 */
#ifndef FNL_PASSES_DAIS_H
#define FNL_PASSES_DAIS_H

#include "passes/dais/dais_shared.h"
#include "passes/shade/shade.h"

struct dais_params {
    bool lists;            /* references stand in a list for each pixel, else in a render target */
    bool shared_samples;   /* light that changes slowly is found once for a square of four pixels of one triangle */
    bool each_sample;      /* lists: no coverage after the depth test; an element for each sample of an edge or not */
    bool quads;            /* the device lets fragments of a square talk to each other */
    uint32_t buckets;      /* of the cache, a power of two */
    uint32_t capacity;     /* words of the pool of triangles, 64 at least */
    uint32_t node_capacity;
    uint32_t probe;        /* DAIS_SHOW_… */
    uint32_t attempts;     /* to lock a bucket, of DAIS_ATTEMPTS */
};

/** What the visibility pass leaves. */
struct dais {
    struct dais_params params;
    graph_image depth, references, shared; /* images: id 0 with lists, or without shared samples */
    graph_buffer pool, stored, counts, heads, nodes, samples;
    uint32_t width, height, sample_count, sample_capacity;
    uint64_t fixed_bytes; /* of targets, heads and cache; what the pools hold comes on top */
};

/** What the device must have for so many samples. */
bool dais_target_supported(const gpu_device *device, uint32_t samples);

/**
 * References to what `depth` (complete) shows, and the triangles. The device needs fnl_device_info.primitive_ids. Cost: each fragment of the
 * opaque set that is seen looks its triangle up in a cache; for the first of a triangle it takes room for
 * a record of 16 words or more, which a lane each fills.
 */
struct dais dais_add(struct graph *graph, const struct shade_input *input, const struct dais_params *params, graph_image depth);

/**
 * Shades each triangle of each pixel once into `radiance`, single- or multisampled; what shows nothing gets the background. If
 * anything had no room, the whole frame is shaded forward instead, to the bit as forward_add() does after a prepass: what finds room depends
 * on the order of atomics. With light counters it also counts the different triangles.
 */
void dais_shade_add(struct graph *graph, const struct shade_input *input, const struct dais *dais, graph_image radiance);

/** A view for people, DAIS_VIEW_… of dais_shared.h, into a colour target; `swap`: blue comes first in it. */
void dais_view_add(struct graph *graph, const struct shade_input *input, const struct dais *dais, uint32_t which,
                   graph_image color, bool swap);

#endif
