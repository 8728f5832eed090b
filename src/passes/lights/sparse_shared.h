/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_SPARSE_SHARED_H
#define FNL_PASSES_SPARSE_SHARED_H

#include "shared.h"
#include "gbuffer_shared.h"
#include "passes/lights/bvh_shared.h"

#define SPARSE_MARK 0u    /* steps over the pixels */
#define SPARSE_MEASURE 1u
#define SPARSE_FACE 2u
#define SPARSE_EXTENTS(buckets) ((buckets) == 1u ? 6u : 14u)

struct gpu_sparse_push {
    ADDRESS(view_block) view;
    ADDRESS(light_list_block) list;
    ADDRESS(uint_array) table;     /* one per key and one more: 1 for occupied ones, then their prefix sum */
    ADDRESS(uint_array) keys;      /* of the cells */
    ADDRESS(uint_array) extents;   /* of each cell's pixels, view space, as integers in the same order: least and
                                      greatest coordinates; with buckets also those of the normals on the bucket's face, and the least along
                                      the four corners of these */
    ADDRESS(bounds_array) bounds;  /* of the cells */
    ADDRESS(facing_array) facings; /* of the cells, where there are buckets */
    uint key_count;
    uint buckets;
    uint cell_limit;
    STRUCT(gpu_gbuffer) gbuffer;   /* its depth; and with buckets its normals */
};

#endif
