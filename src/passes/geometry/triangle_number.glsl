// SPDX-License-Identifier: MIT
// Fragment shaders: the number of their triangle in its primitive, whatever culling has left out of it. `push` begins with gpu_geometry_push.
#ifndef TRIANGLE_NUMBER_GLSL
#define TRIANGLE_NUMBER_GLSL

uint triangle_number() {
    uint number = uint(gl_PrimitiveID);
    if ((FEATURES & GPU_FEATURE_COMPACTED) == 0u) return number;
    uint first = push.triangles.at[in_ids.y];
    return first == 0xffffffffu ? number : push.triangles.at[first + number];
}

#endif
