#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// A vertex of an item as a page shows it, at the page's place in the atlas; what is beyond the page is cut off. CUTOUT: with
// what depth.frag.glsl reads.
#include "common.glsl"
#include "passes/shadow/fill.glsl"

layout(push_constant, scalar) uniform push_block { gpu_fill_draw_push push; };

#ifdef CUTOUT
layout(location = 3) centroid out vec4 out_uv; // as material.glsl has them
layout(location = 4) centroid out vec4 out_color;
layout(location = 5) flat out uvec3 out_ids;
#endif
out float gl_ClipDistance[4];

void main() {
    gpu_fill_pair pair = push.pairs.at[gl_InstanceIndex];
    scene_block s = push.geometry.scene;
    gpu_item item = s.scene.items.at[pair.item];
    vec3 position = transform_point(s.scene.instances.at[item.instance], s.scene.positions.at[gl_VertexIndex]);
    gpu_shadow_page page = push.pages.at[pair.page];
    shadow_page p = shadow_page_of(page.bit);
    gpu_shape shape = push.shapes.at[page.row];
    vec4 clip = shadow_face_clip(shape, p.face, position - shape.position);
    // Texels of the page, times w, which are linear on the triangle.
    vec2 texel = 0.5 * shadow_width(p.level) * (clip.xy + clip.w) + (float(SHADOW_BORDER) - vec2(p.at * shadow_page_texels(p.level))) * clip.w;
    vec2 beyond = float(shadow_page_size(p.level)) * clip.w - texel;
    gl_ClipDistance[0] = texel.x;
    gl_ClipDistance[1] = texel.y;
    gl_ClipDistance[2] = beyond.x;
    gl_ClipDistance[3] = beyond.y;
    vec2 place = vec2(page.place & 0xffffu, page.place >> 16u) * float(SHADOW_UNIT);
    vec2 at = (texel + place * clip.w) * (2.0 / push.side) - clip.w;
    gl_Position = vec4(at.x, -at.y, clip.zw); // the viewport has its first row at +1
#ifdef CUTOUT
    gpu_attributes a = s.scene.attributes.at[gl_VertexIndex];
    out_uv = vec4(a.uv0, a.uv1);
    out_color = vec4(unpackUnorm2x16(a.color.x), unpackUnorm2x16(a.color.y));
    out_ids = uvec3(s.scene.primitives.at[item.primitive].material, pair.item, 0u);
#endif
}
