/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_NORMAL_ENCODINGS_TEST_SHARED_H
#define FNL_PASSES_NORMAL_ENCODINGS_TEST_SHARED_H

#include "shared.h"

#define ENCODING_XY 0u
#define ENCODING_SPHERICAL 1u
#define ENCODING_SPHERE_MAP 2u
#define ENCODING_STEREOGRAPHIC 3u
#define ENCODING_OCTAHEDRAL 4u
#define ENCODING_VIEW 5u
#define ENCODING_BEST_FIT 6u
#define ENCODING_XYZ 7u
#define ENCODING_COUNT 8u

struct gpu_encodings_push {
    ADDRESS(normal_array) normals;
    ADDRESS(normal_array) decoded;
    ADDRESS(normal_array) stored; /* what a UNORM target would hold */
    vec3 to_view;
    uint count;
    uint encoding;
    uint most;                    /* of a component: 255 or 65535 */
};

#endif
