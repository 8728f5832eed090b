/* SPDX-License-Identifier: MIT */
/** The last push constants of shaders that draw into several layers by choosing them (LAYERED). */
#ifndef FNL_PASSES_LAYERED_SHARED_H
#define FNL_PASSES_LAYERED_SHARED_H

#include "shared.h"

#define LAYERED_AT 120

struct gpu_layered_push {
    uint first; /* the layer of a draw's first instance */
    uint count; /* of layers: instances are repeated so often, in a row */
};

#endif
