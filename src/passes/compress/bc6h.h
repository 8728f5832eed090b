/* SPDX-License-Identifier: MIT */
/**
 * BC6H on the GPU: pictures and cube maps of high dynamic range into a sixth of their size, one thread a block of 4 x 4 texels (Narkowicz,
 * "Real-Time BC6H Compression on GPU", GPU Pro 7, V.2). The blocks are those of bc6h_encode() in src/image/bc6h.h, bit for bit where the device
 * divides as the CPU does.
 *
 * Cost: a read of the source and a write of 16 bytes a block; with `quality` about 50 times the arithmetic. The copy into an image is extra.
 */
#ifndef FNL_PASSES_BC6H_H
#define FNL_PASSES_BC6H_H

#include "graph/graph.h"

struct bc6h_gpu_params {
    bool quality; /* modes 2, 6 and 10 to 14 by least error; false (default): mode 11 */
    bool is_signed;
};

/**
 * What is compressed: mip 0 of an image of one layer, or what `part` shows of `image`, one mip of one face (gpu_image_part). Any format of floats
 * that can be sampled. Edges are repeated where a side is no multiple of 4. Alpha is left out, NaN becomes 0, infinities 65504, and so
 * do negative values 0 unless `is_signed`.
 */
struct bc6h_source {
    graph_image image;
    const struct gpu_image *part; /* or NULL */
};

/** Compresses in one pass; the blocks of each source follow those of the one before, row by row, 16 bytes each. */
graph_buffer bc6h_add(struct graph *graph, gpu_device *device, const char *name, const struct bc6h_source *sources, uint32_t count,
                      const struct bc6h_gpu_params *params);
/** Copies such blocks into all of an image of BC6H: sources were mip after mip, in each of them face after face. */
void bc6h_copy_add(struct graph *graph, const char *name, graph_buffer blocks, graph_image target);
/**
 * In place of both, where gpu_block_stores_supported(): stores blocks into `target`, an image of BC6H with usage STORAGE; parts[i] (gpu_image_part with
 * as_blocks) is where those of source i go.
 */
void bc6h_store_add(struct graph *graph, gpu_device *device, const char *name, const struct bc6h_source *sources,
                    const struct gpu_image *const *parts, uint32_t count, graph_image target, const struct bc6h_gpu_params *params);

#endif
