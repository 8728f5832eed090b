/* SPDX-License-Identifier: MIT */
/** Push constants of everything that draws the scene. */
#ifndef FNL_PASSES_GEOMETRY_SHARED_H
#define FNL_PASSES_GEOMETRY_SHARED_H

#include "shared.h"

struct gpu_geometry_push {
    ADDRESS(view_block) view;
    ADDRESS(scene_block) scene;
    ADDRESS(const_uint_array) visible; /* instance of a draw -> item; of mesh shaders: struct gpu_mesh_draw */
    ADDRESS(lighting_block) lighting;
    ADDRESS(uint_array) counters;      /* one per pixel, or 0 when nothing is counted; of objects.frag.glsl: its table */
    ADDRESS(const_uint_array) triangles; /* with GPU_FEATURE_COMPACTED: struct gpu_cluster_push */
};

#endif
