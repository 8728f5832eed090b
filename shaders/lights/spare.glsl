// SPDX-License-Identifier: MIT
// The spare list (lights_shared.h), and where points are seen that may be shaded off their pixel.
#ifndef LIGHTS_SPARE_GLSL
#define LIGHTS_SPARE_GLSL

// The pixel that a point in view space is seen on. False: it is not in view, where lights may be left out of all lists.
bool seen_on(view_block v, vec3 seen, inout uvec2 pixel) {
    float spread = v.view.orthographic > 0.5 ? 1.0 : -seen.z;
    vec2 ndc = (seen.xy / spread - v.view.ndc_offset) / v.view.ndc_scale;
    vec2 at = (vec2(ndc.x, -ndc.y) * 0.5 + 0.5) * vec2(v.view.size);
    bool inside = -seen.z > v.view.near_distance * 1.0001 && all(greaterThan(at, vec2(0.0))) && all(lessThan(at, vec2(v.view.size)));
    if (inside) pixel = min(uvec2(at), v.view.size - 1u);
    return inside;
}

uint spare_bin(view_block v, float view_depth) {
    return uint(clamp(2.0 * log2(max(view_depth, 1e-30) / v.view.near_distance), 0.0, float(SPARE_BINS - 1u))); // NaN: 0
}

struct spare_cursor {
    uint word, bits; // the next word of the rows, and what is left of the last one
    uint tile, bin;  // where the rows begin
};

// False: all lights.
bool spare_begin(light_list_block l, vec3 position, out spare_cursor c) {
    c = spare_cursor(0u, 0u, 0u, 0u);
    if (l.list.spare_words == 0u || l.list.spare.at[0] == 0u) return false;
    view_block v = l.list.view;
    vec3 seen = (v.view.world_to_view * vec4(position, 1.0)).xyz;
    uvec2 pixel;
    if (!seen_on(v, seen, pixel)) return false;
    uvec2 tile = pixel / l.list.spare_tile_size;
    uint bin = l.list.spare_tiles.x * l.list.spare_tiles.y + spare_bin(v, -seen.z);
    c.tile = 1u + (tile.y * l.list.spare_tiles.x + tile.x) * l.list.spare_words;
    c.bin = 1u + bin * l.list.spare_words;
    return true;
}

// Moves on; false at the end.
bool spare_next(light_list_block l, inout spare_cursor c, out uint id) {
    while (c.bits == 0u && c.word < l.list.spare_words) { // no return from within: see bins_next()
        c.bits = l.list.spare.at[c.tile + c.word] & l.list.spare.at[c.bin + c.word];
        c.word++;
    }
    id = 0u;
    bool found = c.bits != 0u;
    if (found) {
        id = (c.word - 1u) * 32u + uint(findLSB(c.bits));
        c.bits &= c.bits - 1u;
    }
    return found;
}

// ---- masks of 32 depth cells (T. Harada, "A 2.5D Culling for Forward+", SIGGRAPH Asia 2012 Technical Briefs) ----

uint depth_cell(gpu_cell_bounds b, float view_depth) {
    float near = -b.high.z, far = -b.low.z;
    return uint(clamp((view_depth - near) / max(far - near, 1e-30) * 32.0, 0.0, 31.0));
}

#endif
