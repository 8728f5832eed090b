// SPDX-License-Identifier: MIT
// Light meshes on the grid of tiles: the slices of depth that a triangle covers of a tile (K. Ortegren & E. Persson, "Clustered Shading:
// Assigning Lights Using Conservative Rasterization in DirectX 12", GPU Pro 7).
//
// Points here are (x, y, depth): view space with depth counted away from the viewer. A tile is what lies between two slopes in x and two in
// y, where the slope of a point is its coordinate over depth_scale(): its depth, or 1 in orthographic views.
#ifndef RASTER_GLSL
#define RASTER_GLSL

#include "passes/lights/cells.glsl"
#include "lights/proxy.glsl"

layout(buffer_reference) buffer raster_light_array;
layout(buffer_reference) buffer raster_slot_array;
layout(buffer_reference) buffer raster_mesh_array;
layout(buffer_reference) buffer point_array;
layout(buffer_reference) buffer raster_block;

#include "passes/lights/raster_shared.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer raster_light_array { gpu_raster_light at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer raster_slot_array { gpu_raster_slot at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer raster_mesh_array { gpu_raster_mesh at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer point_array { vec3 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer raster_block { gpu_raster r; };

layout(push_constant, scalar) uniform push_block { gpu_raster_push push; };
#define RASTER push.raster.r

const uint MESH_SPHERE = 0u, MESH_CONE = 1u, MESH_BOX = 2u, MESH_OWN = 3u; // of a sphere there is none

// A slice is that of a depth moved by this much, relatively: slices are found by the same function as in shading, from rounded depths.
const float DEPTH_SLACK = 2e-5;

// ---- meshes ----

struct light_mesh {
    uint kind, place; // MESH_…, place of the bounds
    uint vertex_count, triangle_count;
    uint first_triangle; // in RASTER.triangles; of MESH_OWN in RASTER.points
};

light_mesh mesh_of(uint place) {
    if (RASTER.own_meshes == 1u) {
        gpu_raster_mesh own = RASTER.meshes.at[place];
        if (own.count != 0u) return light_mesh(MESH_OWN, place, 0u, own.count, own.first);
    }
    uint shape = RASTER.list.list.lights.set.entities.at[place].shape, kind = GPU_SHAPE_SPHERE;
    if (shape != GPU_NO_SHAPE) kind = shape_at(set_of(RASTER.list), shape).shape.kind;
    if (kind == GPU_SHAPE_SPHERE) return light_mesh(MESH_SPHERE, place, 0u, 0u, 0u);
    if (kind == GPU_SHAPE_CONE) return light_mesh(MESH_CONE, place, GPU_CONE_VERTICES, GPU_CONE_TRIANGLES, 0u);
    return light_mesh(MESH_BOX, place, GPU_BOX_VERTICES, GPU_BOX_TRIANGLES, GPU_CONE_TRIANGLES);
}

vec3 to_view(vec3 world) {
    vec3 p = (RASTER.view.view.world_to_view * vec4(world, 1.0)).xyz;
    return vec3(p.xy, -p.z);
}

// Vertex of a cone or a box.
vec3 mesh_vertex(light_mesh mesh, uint index) {
    gpu_entity_bounds entity = RASTER.list.list.lights.set.entities.at[mesh.place];
    gpu_shape shape = shape_of(set_of(RASTER.list), entity);
    if (mesh.kind == MESH_BOX) {
        vec3 corners[8];
        shape_corners(shape, entity.center, entity.radius, corners);
        return to_view(corners[index]);
    }
    vec3 part = RASTER.vertices[index];
    // Rounding of the ramp may light a hair more than the cone.
    float cosine = clamp(-shape.spot_offset / shape.spot_scale - 1e-6, 0.0, 1.0), sine = sqrt(1.0 - cosine * cosine);
    float along = part.z == float(GPU_CONE_APEX) ? 0.0 : part.z == float(GPU_CONE_RIM) ? cosine : 1.0;
    float across = part.z == float(GPU_CONE_RIM) ? sine : part.z == float(GPU_CONE_CAP) ? sine / (1.0 + cosine) : 0.0;
    across *= float(GPU_CONE_SCALE);
    vec3 up = cross(shape.side, shape.direction);
    return to_view(shape.position + shape.range * (shape.direction * along + (shape.side * part.x + up * part.y) * across));
}

// A point well inside of the same.
vec3 mesh_inside(light_mesh mesh) {
    if (mesh.kind == MESH_BOX) return 0.5 * (mesh_vertex(mesh, 0u) + mesh_vertex(mesh, 7u));
    return 0.5 * (mesh_vertex(mesh, 0u) + mesh_vertex(mesh, GPU_CONE_VERTICES - 1u));
}

uvec3 mesh_triangle(light_mesh mesh, uint index) {
    uint packed = RASTER.triangles[mesh.first_triangle + index];
    return uvec3(packed & 255u, packed >> 8 & 255u, packed >> 16);
}

// ---- the grid ----

float depth_scale(vec3 p) { return RASTER.view.view.orthographic > 0.5 ? 1.0 : p.z; }

// How far, in metres, a point may be off its true place: that of a light after the way to view space, that of a surface after the way from
// its pixel.
float light_margin(gpu_bound bound) { return 2e-6 * (length(bound.center) + bound.radius) + 1e-7; }

float column_slope(uint column) {
    float pixel = float(min(column * RASTER.list.list.tile_size, RASTER.view.view.size.x));
    return (pixel * RASTER.view.view.inverse_size.x * 2.0 - 1.0) * RASTER.view.view.ndc_scale.x + RASTER.view.view.ndc_offset.x;
}
float row_slope(uint row) { // falls with the row
    float pixel = float(min(row * RASTER.list.list.tile_size, RASTER.view.view.size.y));
    return (1.0 - pixel * RASTER.view.view.inverse_size.y * 2.0) * RASTER.view.view.ndc_scale.y + RASTER.view.view.ndc_offset.y;
}
// Columns or rows (from the slopes' low end) that slopes lie in, not clamped.
vec2 slope_tiles(vec2 slopes, int axis) {
    vec2 ndc = (slopes - RASTER.view.view.ndc_offset[axis]) / RASTER.view.view.ndc_scale[axis];
    vec2 pixels = (axis == 0 ? ndc * 0.5 + 0.5 : 0.5 - ndc.yx * 0.5) * float(RASTER.view.view.size[axis]);
    return floor((pixels + vec2(-1e-3, 1e-3)) / float(RASTER.list.list.tile_size));
}

uint near_slice(float depth, float margin) { return slice_of(RASTER.list, max(depth * (1.0 - DEPTH_SLACK) - margin, RASTER.near)); }
uint far_slice(float depth, float margin) { return slice_of(RASTER.list, max(depth * (1.0 + DEPTH_SLACK) + margin, RASTER.near)); }

// ---- triangles ----

struct polygon {
    vec3 at[8];
    uint count;
};

// Cuts off what is outside of dot(plane.xyz, p) + plane.w >= 0. In place: of a convex polygon, what is kept is never more than what was read and the corner
// that is read ahead. Rounding may make a polygon another one that lies along the plane; then corners on the plane are left out, beside which others are kept.
void cut(inout polygon p, vec4 plane) {
    uint kept = 0u;
    vec3 last = p.at[max(p.count, 1u) - 1u], next = p.at[0];
    float last_side = dot(plane.xyz, last) + plane.w;
    for (uint i = 0u; i < p.count; i++) {
        vec3 at = next;
        next = p.at[min(i + 1u, 7u)];
        float side = dot(plane.xyz, at) + plane.w;
        bool has_room = i + 2u >= p.count || side < 0.0 || kept <= i;
        if ((side < 0.0) != (last_side < 0.0) && kept < 8u && has_room)
            p.at[kept++] = mix(last, at, clamp(last_side / (last_side - side), 0.0, 1.0));
        if (side >= 0.0 && kept < 8u) p.at[kept++] = at;
        last = at;
        last_side = side;
    }
    p.count = kept;
}

// Inside of the slope on its greater (direction 1) or smaller side (-1), `margin` metres wider.
vec4 slope_plane(int axis, float slope, float direction, float margin) {
    vec4 plane = vec4(0.0);
    plane[axis] = direction;
    plane.w = margin;
    if (RASTER.view.view.orthographic > 0.5)
        plane.w -= direction * slope;
    else
        plane.z = -direction * slope;
    return plane;
}

vec2 slope_range(polygon p, int axis, float margin) {
    vec2 range = vec2(3e38, -3e38);
    for (uint i = 0u; i < p.count; i++) {
        float scale = 1.0 / depth_scale(p.at[i]);
        range = vec2(min(range.x, (p.at[i][axis] - margin) * scale), max(range.y, (p.at[i][axis] + margin) * scale));
    }
    return range;
}

// Least and greatest depth of what lies between two slopes in x, `margin` metres wider; x > y: nothing. The corners of the part are
// corners of the polygon or lie on its edges, so it is enough to cut the edges.
vec2 depth_range(polygon p, float low, float high, float margin) {
    vec2 range = vec2(3e38, -3e38);
    vec3 last = p.at[max(p.count, 1u) - 1u];
    for (uint i = 0u; i < p.count; i++) {
        vec3 next = p.at[i];
        float t0 = 0.0, t1 = 1.0;
        for (int k = 0; k < 2; k++) {
            float a = margin + (k == 0 ? last.x - low * depth_scale(last) : high * depth_scale(last) - last.x);
            float b = margin + (k == 0 ? next.x - low * depth_scale(next) : high * depth_scale(next) - next.x);
            if (a < 0.0 && b < 0.0) t0 = 2.0;
            else if (a < 0.0) t0 = max(t0, a / (a - b));
            else if (b < 0.0) t1 = min(t1, a / (a - b));
        }
        if (t0 <= t1) {
            float d0 = mix(last.z, next.z, t0), d1 = mix(last.z, next.z, t1);
            range = vec2(min(range.x, min(d0, d1)), max(range.y, max(d0, d1)));
        }
        last = next;
    }
    return range;
}

// Depths of the part of an edge that lies in a tile.
void edge_depths(vec3 a, vec3 b, vec2 low, vec2 high, float margin, inout vec2 range) {
    float wa = depth_scale(a), wb = depth_scale(b), t0 = 0.0, t1 = 1.0;
    vec4 from = vec4(a.xy - low * wa, high * wa - a.xy) + margin, to = vec4(b.xy - low * wb, high * wb - b.xy) + margin;
    for (int k = 0; k < 4; k++) {
        float t = from[k] / (from[k] - to[k]);
        t0 = from[k] < 0.0 ? (to[k] < 0.0 ? 2.0 : max(t0, t)) : t0;
        t1 = from[k] >= 0.0 && to[k] < 0.0 ? min(t1, t) : t1;
    }
    if (t0 > t1) return;
    float d0 = mix(a.z, b.z, t0), d1 = mix(a.z, b.z, t1);
    range = vec2(min(range.x, min(d0, d1)), max(range.y, max(d0, d1)));
}

// Least and greatest depth of a triangle that is wholly before the viewer in a tile: of its edges within, and where the tile's corner rays
// hit it. Rays that pass it by less than the margin count too.
vec2 triangle_depths(vec3 a, vec3 b, vec3 c, vec2 depths, vec2 low, vec2 high, float margin, float wider) {
    vec2 range = vec2(3e38, -3e38);
    edge_depths(a, b, low, high, margin, range);
    edge_depths(b, c, low, high, margin, range);
    edge_depths(c, a, low, high, margin, range);
    bool orthographic = RASTER.view.view.orthographic > 0.5;
    vec3 ha = vec3(a.xy, depth_scale(a)), hb = vec3(b.xy, depth_scale(b)), hc = vec3(c.xy, depth_scale(c));
    vec3 e0 = cross(ha, hb), e1 = cross(hb, hc), e2 = cross(hc, ha), n = cross(b - a, c - a);
    float side = dot(e0, hc) < 0.0 ? -1.0 : 1.0, d = dot(n, a), scale = orthographic ? n.z : d;
    vec3 tolerance = wider * vec3(abs(e0.x) + abs(e0.y), abs(e1.x) + abs(e1.y), abs(e2.x) + abs(e2.y));
    float change = wider * (abs(n.x) + abs(n.y)) / abs(scale);
    for (uint k = 0u; k < 4u; k++) {
        vec3 ray = vec3((k & 1u) != 0u ? high.x : low.x, (k & 2u) != 0u ? high.y : low.y, 1.0);
        if (any(lessThan(side * vec3(dot(e0, ray), dot(e1, ray), dot(e2, ray)), -tolerance))) continue;
        float at = (orthographic ? d - dot(n.xy, ray.xy) : dot(n, ray)) / scale;
        vec2 hit = vec2(at - change, at + change);
        if (!orthographic) hit = vec2(1.0 / hit.y, hit.x > 0.0 ? 1.0 / hit.x : 3e38);
        // Edge on a ray may hit it anywhere.
        bool known = hit.y >= hit.x && hit.y > 0.0;
        range = vec2(min(range.x, known ? clamp(hit.x, depths.x, depths.y) : depths.x),
                     max(range.y, known ? clamp(hit.y, depths.x, depths.y) : depths.y));
    }
    return range;
}

// The same for the whole plane of a triangle over a tile, cut to the triangle's own depths (M. Pettineo): the inverse of depth (in
// orthographic views, depth) is linear on the screen, so from the middle of the tile it changes by half of both slopes. A superset.
vec2 gradient_range(vec3 a, vec3 b, vec3 c, vec2 depths, vec2 low, vec2 high) {
    bool orthographic = RASTER.view.view.orthographic > 0.5;
    vec3 n = cross(b - a, c - a);
    float d = dot(n, a);
    vec2 middle = 0.5 * (low + high);
    float scale = orthographic ? n.z : d;
    float at = (orthographic ? d - dot(n.xy, middle) : dot(n, vec3(middle, 1.0))) / scale;
    float change = 0.5 * dot(abs(n.xy / scale), high - low) + 1e-6 * abs(at);
    vec2 range = vec2(at - change, at + change);
    // Edge on there is no gradient; nor is there any behind the viewer.
    if (!(abs(scale) > 1e-3 * length(n) * (orthographic ? 1.0 : length(a))) || (!orthographic && !(range.y > 0.0))) return depths;
    if (!orthographic) range = vec2(1.0 / range.y, range.x > 0.0 ? 1.0 / range.x : 3e38);
    return clamp(range, depths.x, depths.y);
}

// ---- shells ----

// A light while its triangles are drawn.
struct shell {
    uvec2 first_tile, last_tile; // of its rectangle, columns and rows
    float margin;                // metres
    float slack;                 // by how much tiles are widened for the rounding of their slopes
    bool cut_by_near;            // part of the mesh is nearer than the near plane
};

// Slices of a triangle in a tile, for both ends of a slot; a face that may lie at the back does not say where the light begins.
struct span {
    uint first, last;
};
span span_of(shell s, vec2 depths, bool front) {
    return span(front ? near_slice(depths.x, s.margin) : RASTER_UNSET, 0xffffu - far_slice(depths.y, s.margin));
}

// Whether a triangle surely looks at the viewer. `inside` lies within the mesh.
bool faces_viewer(vec3 a, vec3 b, vec3 c, vec3 inside) {
    vec3 n = cross(b - a, c - a);
    if (dot(n, a - inside) < 0.0) n = -n;
    vec3 ray = RASTER.view.view.orthographic > 0.5 ? vec3(0.0, 0.0, 1.0) : a;
    return dot(n, ray) < -1e-4 * length(n) * length(ray);
}

// What of a triangle is in front of the near plane.
polygon visible_part(vec3 a, vec3 b, vec3 c) {
    polygon p;
    p.at[0] = a;
    p.at[1] = b;
    p.at[2] = c;
    p.count = 3u;
    if (min(a.z, min(b.z, c.z)) < RASTER.near) cut(p, vec4(0.0, 0.0, 1.0, -RASTER.near));
    return p;
}

polygon row_part(shell s, polygon p, uint row) {
    cut(p, slope_plane(1, row_slope(row + 1u) - s.slack, 1.0, s.margin));
    cut(p, slope_plane(1, row_slope(row) + s.slack, -1.0, s.margin));
    return p;
}

// Tiles of a range of slopes, within `first` .. `last`; x > y: none. Broken ranges take all.
ivec2 tiles_of(shell s, vec2 slopes, int axis, uint first, uint last) {
    vec2 tiles = slope_tiles(slopes + vec2(-s.slack, s.slack), axis);
    return ivec2(tiles.x > float(first) ? int(min(tiles.x, float(last + 1u))) : int(first),
                 tiles.y < float(last) ? int(max(tiles.y, -1.0)) : int(last));
}

vec2 tile_depths(shell s, polygon in_row, uint column) {
    return depth_range(in_row, column_slope(column) - s.slack, column_slope(column + 1u) + s.slack, s.margin);
}

// Of the light whose number among those in view is `index`; `nearest` is the least depth of its mesh.
shell shell_of(uint index, gpu_bound bound, float nearest) {
    shell s;
    gpu_raster_light light = RASTER.lights.at[index];
    s.first_tile = uvec2(light.columns, light.rows) & 0xffffu;
    s.last_tile = uvec2(light.columns >> 16, light.rows >> 16);
    s.margin = light_margin(bound);
    s.slack = 1e-6 * (max(abs(RASTER.view.view.ndc_scale.x), abs(RASTER.view.view.ndc_scale.y)) +
                      max(abs(RASTER.view.view.ndc_offset.x), abs(RASTER.view.view.ndc_offset.y)));
    s.cut_by_near = nearest - s.margin < RASTER.near;
    return s;
}

// A light that lies in one tile has no slots, nor has one whose slots do not fit.
bool has_slots(uint index) {
    uint end = RASTER.slot_sums.at[index + 1u];
    return end > RASTER.slot_sums.at[index] && end <= RASTER.slot_capacity;
}

// Leaves those slices that the light's sphere touches in a tile: meshes stick out of it. What a plane cuts off a sphere fits into a
// smaller one round the middle of the cut.
uvec2 slices_of_sphere(uint index, uvec2 tile, uvec2 slices) {
    gpu_bound bound = RASTER.bounds.at[index];
    vec3 center = vec3(bound.center.xy, -bound.center.z);
    float margin = light_margin(bound), radius = bound.radius + margin;
    bool orthographic = RASTER.view.view.orthographic > 0.5, moved = false;
    for (int axis = 0; axis < 2; axis++) {
        vec2 slopes = axis == 0 ? vec2(column_slope(tile.x), column_slope(tile.x + 1u)) : vec2(row_slope(tile.y + 1u), row_slope(tile.y));
        vec2 scale = orthographic ? vec2(1.0) : inversesqrt(1.0 + slopes * slopes);
        vec2 outside = (slopes * depth_scale(center) - center[axis]) * vec2(scale.x, -scale.y) - 2e-6 * radius;
        float most = max(outside.x, outside.y);
        if (most > radius) return uvec2(1u, 0u);
        if (!(most > 0.0)) continue;
        bool low = outside.x > outside.y;
        center[axis] += low ? most * scale.x : -most * scale.y;
        if (!orthographic) center.z += low ? -most * scale.x * slopes.x : most * scale.y * slopes.y;
        radius = sqrt(max(radius * radius - most * most, 0.0));
        moved = true;
    }
    if (!moved) return slices;
    return uvec2(max(slices.x, near_slice(center.z - radius, margin)), min(slices.y, far_slice(center.z + radius, margin)));
}

// First and last slice of a light in a tile; first > last: none. A light without slots counts as if it filled its rectangle.
uvec2 slices_in_tile(uint index, uvec2 tile) {
    gpu_raster_light light = RASTER.lights.at[index];
    uvec2 none = uvec2(1u, 0u), low = uvec2(light.columns, light.rows) & 0xffffu;
    uvec2 high = uvec2(light.columns >> 16, light.rows >> 16);
    if (any(lessThan(tile, low)) || any(greaterThan(tile, high))) return none;
    uvec2 slices = uvec2(light.slices & 0xffffu, light.slices >> 16);
    slices = slices_of_sphere(index, tile, slices);
    if (slices.x > slices.y || !has_slots(index)) return slices;
    gpu_raster_slot slot =
        RASTER.slots.at[RASTER.slot_sums.at[index] + (tile.y - low.y) * (high.x - low.x + 1u) + (tile.x - low.x)];
    if (slot.last == RASTER_UNSET) return none;
    if (slot.first != RASTER_UNSET) slices.x = max(slices.x, slot.first);
    slices.y = min(slices.y, 0xffffu - slot.last);
    return slices;
}

#endif
