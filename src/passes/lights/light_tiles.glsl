// SPDX-License-Identifier: MIT
// The tiles and depths that a light's bounding sphere may touch.
#ifndef LIGHT_TILES_GLSL
#define LIGHT_TILES_GLSL

#include "passes/lights/cells.glsl"

// Tangents of the two view rays that touch a circle, in a plane through the view axis; infinite where they do not cross the screen.
// cf. Mara & McGuire 2013, 2D Polyhedral Bounds of a Clipped, Perspective-Projected 3D Sphere.
vec2 tangents(float across, float depth, float radius) {
    float far2 = across * across + depth * depth - radius * radius;
    if (!(far2 > 0.0)) return vec2(-1e30, 1e30); // the viewer is in it
    float side = sqrt(far2);
    vec2 low = vec2(across * side - depth * radius, depth * side + across * radius);
    vec2 high = vec2(across * side + depth * radius, depth * side - across * radius);
    return vec2(low.y > 0.0 ? low.x / low.y : -1e30, high.y > 0.0 ? high.x / high.y : 1e30);
}

// First and last tile of an axis; `at` is what the screen's plane is cut at, at depth 1.
uvec2 tile_range(vec2 at, float scale, float offset, bool down, float size, float tile_size, uint tile_count) {
    vec2 part = ((at - offset) / scale) * (down ? -0.5 : 0.5) + 0.5;
    float a = min(part.x, part.y) * size - 0.25, b = max(part.x, part.y) * size + 0.25;
    float last = float(tile_count - 1u);
    // NaN takes all.
    uint first = a > 0.0 ? uint(min(floor(a / tile_size), last)) : 0u;
    uint end = b < size ? uint(clamp(floor(b / tile_size), 0.0, last)) : tile_count - 1u;
    return uvec2(min(first, end), end);
}

// First and last column and row: xy to zw. `depths`: the view depths that the light reaches, widened.
uvec4 tiles_of_light(view_block v, gpu_bound light, uint tile_size, uvec2 tiles, out vec2 depths) {
    float radius = cell_radius(light), depth = -light.center.z;
    depths = vec2((depth - radius) * (1.0 - CELL_SLACK), (depth + radius) * (1.0 + CELL_SLACK));
    vec2 x = vec2(light.center.x - radius, light.center.x + radius), y = vec2(light.center.y - radius, light.center.y + radius);
    if (v.view.orthographic <= 0.5) {
        x = tangents(light.center.x, depth, radius);
        y = tangents(light.center.y, depth, radius);
    }
    float size = float(tile_size);
    uvec2 columns = tile_range(x, v.view.ndc_scale.x, v.view.ndc_offset.x, false, float(v.view.size.x), size, tiles.x);
    uvec2 rows = tile_range(y, v.view.ndc_scale.y, v.view.ndc_offset.y, true, float(v.view.size.y), size, tiles.y);
    return uvec4(columns.x, rows.x, columns.y, rows.y);
}

#endif
