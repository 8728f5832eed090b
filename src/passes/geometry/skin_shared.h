/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_SKIN_SHARED_H
#define FNL_PASSES_SKIN_SHARED_H

#include "shared.h"

/* One deformed primitive: the vertices [source, source + count) of the rest pose go to [target, target + count). */
struct gpu_deform {
    uint source;
    uint target;
    uint count;
    uint joint_count;       /* per vertex, a multiple of 4; 0: not skinned */
    uint first_influence;   /* into influences: joint_count pairs per vertex */
    uint first_matrix;      /* into matrices */
    uint morph_count;
    uint first_morph;       /* into morphs: per target, per vertex: 9 floats, differences of position, normal, tangent */
    uint first_weight;      /* into weights: one per target */
};

struct gpu_influence {
    uint joint;
    float weight;
};

struct gpu_skin_push {
    ADDRESS(position_array) positions;
    ADDRESS(attributes_array) attributes;
    ADDRESS(deform_array) deforms;
    ADDRESS(influence_array) influences;
    ADDRESS(float_array) morphs;
    ADDRESS(float_array) weights;
    ADDRESS(matrix_array) matrices; /* world matrix of the joint times its inverse bind matrix, of this frame */
    uint deform;
};

#endif
