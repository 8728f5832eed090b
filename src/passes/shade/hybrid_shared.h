/* SPDX-License-Identifier: MIT */
/** Push constants of what draws the scene into the G-buffer, and of what lights forward what that cannot hold. */
#ifndef FNL_PASSES_HYBRID_SHARED_H
#define FNL_PASSES_HYBRID_SHARED_H

#include "gbuffer_shared.h"
#include "passes/geometry/geometry_shared.h"

struct gpu_gbuffer_push {
    STRUCT(gpu_geometry_push) geometry;
    ADDRESS(material_entries) entries;
    uint form;
};

struct gpu_hybrid_push {
    STRUCT(gpu_geometry_push) geometry;
    STRUCT(gpu_gbuffer) gbuffer;
};

#endif
