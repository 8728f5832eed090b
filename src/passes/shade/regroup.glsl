// SPDX-License-Identifier: MIT
// What the fragment shaders of batches and of multipass share. Of surfaces at equal depth the last one drawn wins in every order; as these
// draw in an order of their own, a pass before has noted which triangle of which item each pixel shows.
#include "common.glsl"
#include "lights/iterate.glsl"
#define MATERIAL_LAYERS LIGHTING_LAYERS
#include "material.glsl"
#include "decals_raster.glsl"
#include "shade.glsl"
#include "passes/shade/regroup_shared.h"

layout(early_fragment_tests) in;
layout(location = 6) flat in uint in_corner;
layout(push_constant, scalar) uniform push_block { gpu_regroup_draw_push push; };

// To be asked after all textures are read: where neighbours have left, their derivatives are undefined.
bool is_shown(material_array materials, bool hole) {
    bool hidden = material_culled(materials, in_ids.x) || hole;
    return !hidden && texelFetch(textures_uint[push.owners], ivec2(gl_FragCoord.xy), 0).rg == uvec2(in_ids.y, in_corner);
}

float view_depth_at(vec3 position) { return -(push.geometry.view.view.world_to_view * vec4(position, 1.0)).z; }
