#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Which object the camera sees: a row of push.counters, three words for each item, and the triangle. Writes exact whole numbers.
#include "common.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"
#include "material.glsl"
#include "passes/geometry/geometry_shared.h"

layout(constant_id = FEATURES_ID) const uint FEATURES = 0u; // GPU_FEATURE_…
layout(push_constant, scalar) uniform push_block { gpu_geometry_push push; };

layout(location = 0) out vec4 out_object;

#ifdef NO_PRIMITIVE_IDS
uint triangle_number() { return 0u; }
#else
#include "passes/geometry/triangle_number.glsl"
#endif

void main() {
    material_array materials = push.scene.scene.materials;
    float alpha = material_base_color(materials, in_ids.x).a;
    bool blends = (materials.at[in_ids.x].flags & GPU_MATERIAL_BLEND) != 0u;
    // Blended triangles are drawn without culling.
    if (material_cut(materials, in_ids.x, alpha) || (blends && (alpha < 1.0 / 16.0 || material_culled(materials, in_ids.x)))) discard;
    uint row = 3u * in_ids.y;
    if (push.counters.at[row] == 0u) discard; // a part of the stage
    out_object = vec4(float(push.counters.at[row]), float(push.counters.at[row + 1u]), float(int(push.counters.at[row + 2u])), float(triangle_number()));
}
