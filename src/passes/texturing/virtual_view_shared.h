/* SPDX-License-Identifier: MIT */
/** Debug views of virtual texturing. */
#ifndef FNL_PASSES_VIRTUAL_VIEW_SHARED_H
#define FNL_PASSES_VIRTUAL_VIEW_SHARED_H

#include "passes/texturing/virtual_shared.h"

#define VIRTUAL_VIEW_ATLAS 0u /* the base colours of all places */
#define VIRTUAL_VIEW_PAGES 1u /* the page and tier of each pixel */

struct gpu_virtual_view_push {
    ADDRESS(view_block) view;
    ADDRESS(virtual_block) pages;
    uint uv;     /* sampled, both: of one sample */
    uint depth;
    uint target; /* storage */
    uint swap;   /* 1: red and blue change places */
    uint mode;
};

#endif
