// SPDX-License-Identifier: MIT
// The solids that stand for lights in deferred shading by volumes.
#ifndef VOLUMES_GLSL
#define VOLUMES_GLSL

#include "view.glsl"
#include "lights/shapes.glsl"

layout(buffer_reference) buffer volume_draws;

#include "passes/shade/volumes_shared.h"

// Cosine between axis and rim of a spot's cone; rounding of the ramp may light a hair more.
float volume_cosine(gpu_shape shape) { return -shape.spot_offset / shape.spot_scale - 4e-7; }

// Wide cones fit into a sphere better than into a pyramid.
bool volume_is_cone(gpu_shape shape) { return shape.kind == GPU_SHAPE_CONE && volume_cosine(shape) > 0.5; }

#endif
