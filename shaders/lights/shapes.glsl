// SPDX-License-Identifier: MIT
// The shapes of what lists are built over.
#ifndef LIGHTS_SHAPES_GLSL
#define LIGHTS_SHAPES_GLSL

#extension GL_EXT_buffer_reference_uvec2 : require

#include "lights/iterate.glsl"

// `offset` is gpu_entity_bounds.shape, not GPU_NO_SHAPE.
shape_block shape_at(light_set_block l, uint offset) {
    uvec2 base = uvec2(l.set.shapes);
    uint carry, low = uaddCarry(base.x, offset, carry);
    return shape_block(uvec2(low, base.y + carry));
}

gpu_shape sphere_shape(vec3 center, float radius) {
    return gpu_shape(center, radius, GPU_SHAPE_SPHERE, 0u, vec3(0.0, 0.0, -1.0), 0.0, 0.0, vec3(0.0), vec3(0.0), 0u);
}

gpu_shape shape_of(light_set_block l, gpu_entity_bounds b) {
    if (b.shape == GPU_NO_SHAPE) return sphere_shape(b.center, b.radius);
    return shape_at(l, b.shape).shape;
}

#endif
