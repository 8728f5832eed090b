// SPDX-License-Identifier: MIT
// How much larger a sphere becomes.
#ifndef STRETCH_GLSL
#define STRETCH_GLSL

// The largest factor by which a transform stretches, or a little more.
float stretch(gpu_instance instance) {
    mat3 m = mat3(instance.rows[0].xyz, instance.rows[1].xyz, instance.rows[2].xyz);
    mat3 g = m * transpose(m); // the norm of a symmetric matrix is at most its greatest row sum
    vec3 sums = abs(g[0]) + abs(g[1]) + abs(g[2]);
    return sqrt(max_component(sums)) * 1.0001;
}

#endif
