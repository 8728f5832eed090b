#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The shell of one light for each group: nearest and farthest slice in each tile of its rectangle. Of a sphere these are known without a
// mesh, and threads take tiles. Of meshes threads take triangles, and a piece of the rectangle is gathered in shared memory at a time; this
// is the software twin of the draw in raster_draw.frag.glsl.
#include "common.glsl"
#include "passes/lights/raster.glsl"

layout(local_size_x = 64) in;

const uint PIECE = 256u; // tiles

shared vec3 vertices[GPU_CONE_VERTICES];
shared uint firsts[PIECE], lasts[PIECE], nearest_depth;

// ---- spheres ----

// What bounds a sphere in a tile: the sides left, right, bottom and top, as the component of each unit normal across the screen, that in
// depth, and how far inside the sphere's centre is.
struct tile_sides {
    vec4 across, deep, inside;
};

tile_sides sides_of(uvec2 tile, vec3 center, float margin) {
    vec4 slopes = vec4(column_slope(tile.x), column_slope(tile.x + 1u), row_slope(tile.y + 1u), row_slope(tile.y));
    bool orthographic = RASTER.view.view.orthographic > 0.5;
    tile_sides t;
    t.across = vec4(1.0, -1.0, 1.0, -1.0) * (orthographic ? vec4(1.0) : inversesqrt(1.0 + slopes * slopes));
    t.deep = orthographic ? vec4(0.0) : -t.across * slopes;
    t.inside = t.across * (vec4(center.xx, center.yy) - slopes * depth_scale(center)) + margin;
    return t;
}

// Widens the range of depths by a point, given from the centre, if it lies in the tile.
void add_point(tile_sides t, vec3 from_center, float slack, inout vec2 range) {
    vec4 inside = t.inside + t.across * vec4(from_center.xx, from_center.yy) + t.deep * from_center.z;
    if (all(greaterThanEqual(inside, vec4(-slack)))) range = vec2(min(range.x, from_center.z), max(range.y, from_center.z));
}

// Least and greatest depth of a sphere in a tile; x > y: none. What is cut out of it is convex, so its ends are among these: the ends of the
// sphere, of the circles on the sides, of the lines where two sides meet, and the eye, where all sides do.
vec2 sphere_depths(vec3 center, float radius, uvec2 tile) {
    float slack = 2e-6 * (radius + length(center));
    tile_sides t = sides_of(tile, center, slack);
    vec2 range = vec2(3e38, -3e38);
    if (any(lessThan(t.inside, vec4(-radius)))) return range;
    add_point(t, vec3(0.0, 0.0, radius), slack, range);
    add_point(t, vec3(0.0, 0.0, -radius), slack, range);
    for (int k = 0; k < 4; k++) {
        vec2 axis = k < 2 ? vec2(1.0, 0.0) : vec2(0.0, 1.0);
        float left = (radius - t.inside[k]) * (radius + t.inside[k]);
        if (left < 0.0) continue;
        vec3 middle = -t.inside[k] * vec3(axis * t.across[k], t.deep[k]);
        vec3 to_end = sqrt(left) * vec3(axis * (-sign(t.across[k]) * t.deep[k]), abs(t.across[k]));
        add_point(t, middle + to_end, slack, range);
        add_point(t, middle - to_end, slack, range);
    }
    for (int k = 0; k < 4; k++) {
        int i = k & 1, j = 2 + (k >> 1);
        vec3 a = vec3(t.across[i], 0.0, t.deep[i]), b = vec3(0.0, t.across[j], t.deep[j]);
        float cosine = a.z * b.z;
        vec2 weights = vec2(t.inside[i] - cosine * t.inside[j], t.inside[j] - cosine * t.inside[i]) / (1.0 - cosine * cosine);
        vec3 nearest = -(a * weights.x + b * weights.y);
        float away = length(nearest), left = (radius - away) * (radius + away);
        if (left < 0.0) continue;
        vec3 to_end = sqrt(left) * normalize(cross(a, b));
        add_point(t, nearest + to_end, slack, range);
        add_point(t, nearest - to_end, slack, range);
    }
    if (RASTER.view.view.orthographic < 0.5 && length(center) <= radius) range = vec2(min(range.x, -center.z), max(range.y, -center.z));
    return range + center.z;
}

void put_sphere(uint index, gpu_bound bound) {
    shell s = shell_of(index, bound, 0.0);
    uvec2 size = s.last_tile - s.first_tile + 1u;
    for (uint i = gl_LocalInvocationIndex; i < size.x * size.y; i += 64u) {
        vec2 depths = sphere_depths(vec3(bound.center.xy, -bound.center.z), bound.radius + s.margin,
                                    s.first_tile + uvec2(i % size.x, i / size.x));
        // Not a number: all slices.
        span all = span(0u, 0u), none = span(RASTER_UNSET, RASTER_UNSET);
        span found = isnan(depths.x + depths.y) ? all : depths.y < max(depths.x, RASTER.near) ? none : span_of(s, depths, true);
        RASTER.slots.at[RASTER.slot_sums.at[index] + i] = gpu_raster_slot(found.first, found.last);
    }
}

// ---- meshes ----

// Floats as integers in the same order.
uint ordered(float f) {
    uint bits = floatBitsToUint(f);
    return (bits & 0x80000000u) != 0u ? ~bits : bits | 0x80000000u;
}
float unordered(uint bits) { return uintBitsToFloat((bits & 0x80000000u) != 0u ? bits & 0x7fffffffu : ~bits); }

void put(shell s, vec2 depths, bool front, uint at) {
    span found = span_of(s, depths, front);
    atomicMin(firsts[at], found.first);
    atomicMin(lasts[at], found.last);
}

void draw(shell s, vec3 a, vec3 b, vec3 c, bool front, uvec2 first, uvec2 last) {
    vec2 all_depths = vec2(min(a.z, min(b.z, c.z)), max(a.z, max(b.z, c.z)));
    if (!(all_depths.y >= RASTER.near)) return;
    uint width = last.x - first.x + 1u;
    bool cut_by_near = all_depths.x < RASTER.near;
    if (!cut_by_near && RASTER.gradient == 0u) {
        // Most triangles lie in one tile: nothing is to be cut.
        vec3 scale = 1.0 / vec3(depth_scale(a), depth_scale(b), depth_scale(c));
        vec3 x = vec3(a.x, b.x, c.x) * scale, y = vec3(a.y, b.y, c.y) * scale;
        float wider = s.slack + s.margin * max(scale.x, max(scale.y, scale.z));
        vec2 x_range = vec2(min(x.x, min(x.y, x.z)) - wider, max(x.x, max(x.y, x.z)) + wider);
        vec2 y_range = vec2(min(y.x, min(y.y, y.z)) - wider, max(y.x, max(y.y, y.z)) + wider);
        vec2 columns = slope_tiles(x_range, 0), rows = slope_tiles(y_range, 1);
        vec2 low = vec2(first), high = vec2(last);
        if (columns.y < low.x || columns.x > high.x || rows.y < low.y || rows.x > high.y) return;
        // The last tiles may be cut short by the edge of the picture.
        if (columns.x == columns.y && rows.x == rows.y && x_range.y <= column_slope(uint(columns.x) + 1u) &&
            y_range.x >= row_slope(uint(rows.x) + 1u)) {
            put(s, all_depths, front, (uint(rows.x) - first.y) * width + uint(columns.x) - first.x);
            return;
        }
        uvec2 begin = uvec2(max(vec2(columns.x, rows.x), low)), end = uvec2(min(vec2(columns.y, rows.y), high));
        for (uint row = begin.y; row <= end.y; row++)
            for (uint column = begin.x; column <= end.x; column++) {
                vec2 depths = triangle_depths(a, b, c, all_depths, vec2(column_slope(column), row_slope(row + 1u)) - s.slack,
                                              vec2(column_slope(column + 1u), row_slope(row)) + s.slack, s.margin, wider);
                if (depths.x <= depths.y) put(s, depths, front, (row - first.y) * width + column - first.x);
            }
        return;
    }
    polygon p = visible_part(a, b, c);
    if (p.count == 0u) return;
    all_depths.x = max(all_depths.x, RASTER.near);
    float wider = s.slack + s.margin / (RASTER.view.view.orthographic > 0.5 ? 1.0 : all_depths.x);
    ivec2 rows = tiles_of(s, slope_range(p, 1, s.margin), 1, first.y, last.y);
    for (int row = rows.x; row <= rows.y; row++) {
        polygon part = row_part(s, visible_part(a, b, c), uint(row)); // anew: it does not take registers between rows
        if (part.count == 0u) continue;
        ivec2 columns = tiles_of(s, slope_range(part, 0, s.margin), 0, first.x, last.x);
        for (int column = columns.x; column <= columns.y; column++) {
            vec2 depths;
            if (RASTER.gradient == 0u)
                depths = tile_depths(s, part, uint(column));
            else
                depths = gradient_range(a, b, c, all_depths, vec2(column_slope(uint(column)), row_slope(uint(row) + 1u)) - wider,
                                        vec2(column_slope(uint(column) + 1u), row_slope(uint(row))) + wider);
            if (depths.x <= depths.y) put(s, depths, front, (uint(row) - first.y) * width + uint(column) - first.x);
        }
    }
}

void main() {
    uint index = LINEAR_GROUP, thread = gl_LocalInvocationIndex;
    if (index >= RASTER.visible_sums.at[RASTER.light_count] || !has_slots(index)) return; // the whole group
    gpu_bound bound = RASTER.bounds.at[index];
    light_mesh mesh = mesh_of(RASTER.visible_ids.at[index]);
    if (mesh.kind == MESH_SPHERE) put_sphere(index, bound);
    if (mesh.kind == MESH_SPHERE || RASTER.draws == 1u) return;
    bool own = mesh.kind == MESH_OWN;
    if (thread == 0u) nearest_depth = 0xffffffffu;
    barrier();
    uint vertex_count = own ? mesh.triangle_count * 3u : mesh.vertex_count;
    for (uint i = thread; i < vertex_count; i += 64u) {
        vec3 p = own ? to_view(RASTER.points.at[mesh.first_triangle * 3u + i]) : mesh_vertex(mesh, i);
        if (!own) vertices[i] = p;
        atomicMin(nearest_depth, ordered(p.z));
    }
    barrier();
    shell s = shell_of(index, bound, unordered(nearest_depth));
    vec3 inside = own ? vec3(0.0) : mesh_inside(mesh);
    uvec2 size = s.last_tile - s.first_tile + 1u;
    uvec2 piece = uvec2(min(size.x, PIECE), 0u);
    piece.y = min(size.y, PIECE / piece.x);
    uint slots = RASTER.slot_sums.at[index];
    for (uint y = 0u; y < size.y; y += piece.y)
        for (uint x = 0u; x < size.x; x += piece.x) {
            uvec2 first = s.first_tile + uvec2(x, y), last = min(first + piece - 1u, s.last_tile);
            uint width = last.x - first.x + 1u, count = width * (last.y - first.y + 1u);
            for (uint i = thread; i < count; i += 64u) firsts[i] = lasts[i] = RASTER_UNSET;
            barrier();
            for (uint i = thread; i < mesh.triangle_count; i += 64u) {
                vec3 a, b, c;
                bool front = !s.cut_by_near;
                if (own) {
                    uint at = (mesh.first_triangle + i) * 3u;
                    // Meshes of their own need not be convex: where they reach behind the near plane they begin there.
                    a = to_view(RASTER.points.at[at]);
                    b = to_view(RASTER.points.at[at + 1u]);
                    c = to_view(RASTER.points.at[at + 2u]);
                } else {
                    uvec3 corners = mesh_triangle(mesh, i);
                    a = vertices[corners.x];
                    b = vertices[corners.y];
                    c = vertices[corners.z];
                    front = front || faces_viewer(a, b, c, inside);
                }
                draw(s, a, b, c, front, first, last);
            }
            barrier();
            for (uint i = thread; i < count; i += 64u) {
                uint slot = slots + (y + i / width) * size.x + x + i % width;
                RASTER.slots.at[slot] = gpu_raster_slot(firsts[i], lasts[i]);
            }
            barrier();
        }
}
