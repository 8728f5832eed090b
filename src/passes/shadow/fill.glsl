// SPDX-License-Identifier: MIT
// Drawing pages of shadow maps: blocks, and what part of space a page shows.
#ifndef FILL_GLSL
#define FILL_GLSL

#include "shadows/rays.glsl"
#include "passes/geometry/stretch.glsl"
#include "shadows/faces.glsl"
#include "lights/iterate.glsl"

layout(buffer_reference) buffer shadow_counts_block;
layout(buffer_reference) buffer fill_entry_array;
layout(buffer_reference) buffer fill_pair_array;
layout(buffer_reference) buffer fill_totals_block;
layout(buffer_reference) buffer fill_kept_block;

#include "passes/shadow/fill_shared.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer shadow_counts_block { gpu_shadow_counts counts; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer fill_entry_array { gpu_fill_entry at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer fill_pair_array { gpu_fill_pair at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer fill_totals_block { gpu_fill_totals totals; };
// The items of the last frame.
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer fill_kept_block {
    uint count;
    gpu_fill_caster at[];
};

gpu_fill_caster caster_of(rays_block rays, uint index, uint caster_count) {
    scene_block s = rays.rays.scene;
    gpu_item item = s.scene.items.at[index];
    gpu_fill_caster c = gpu_fill_caster(s.scene.instances.at[item.instance].rows, vec3(1.0), vec3(0.0), item.primitive);
    uint flags = s.scene.materials.at[s.scene.primitives.at[item.primitive].material].flags;
    bool clear = (flags & (GPU_MATERIAL_TRANSMISSIVE | GPU_MATERIAL_DARK)) == GPU_MATERIAL_TRANSMISSIVE;
    if (index < caster_count && (flags & GPU_MATERIAL_SHADOWLESS) == 0u && !clear) {
        gpu_ray_box box = rays.rays.primitive_boxes.at[item.primitive];
        c.low = box.low;
        c.high = box.high;
    }
    return c;
}

// The convex part of space that a page shows with its borders, relative to the light.
struct page_volume {
    vec3 origin;     // the light, in the world
    float range;     // nothing farther away matters
    vec4 planes[6];  // inside is dot(xyz, p) + w >= 0; xyz is a unit vector
    vec3 corners[8]; // of four sides from the light's position to its range; of box lights of a box
};

page_volume page_volume_of(gpu_shape shape, uint bit) {
    shadow_page p = shadow_page_of(bit);
    vec2 scale = vec2(2.0 / shadow_width(p.level)), first = vec2(p.at * shadow_page_texels(p.level)) - float(SHADOW_BORDER);
    vec2 low = first * scale - 1.0, high = (first + float(shadow_page_size(p.level))) * scale - 1.0;
    bool is_box = shape.kind == GPU_SHAPE_BOX;
    vec3 u = vec3(0.0), v = vec3(0.0), along = vec3(0.0);
    float near = 0.0, far = shape.range;
    if (is_box) {
        u = shape.side;
        v = cross(shape.side, shape.direction);
        along = shape.direction;
        low *= shape.size.xy;
        high *= shape.size.xy;
        near = -shape.size.z;
        far = shape.size.z;
    } else {
        uint axis = p.face >> 1u;
        u[(axis + 1u) % 3u] = v[(axis + 2u) % 3u] = 1.0;
        along[axis] = (p.face & 1u) != 0u ? -1.0 : 1.0;
    }
    page_volume r;
    r.origin = shape.position;
    r.range = is_box ? 3e38 : shape.range; // the planes say more of a box
    r.planes[0] = is_box ? vec4(u, -low.x) : vec4(u - low.x * along, 0.0);
    r.planes[1] = is_box ? vec4(-u, high.x) : vec4(high.x * along - u, 0.0);
    r.planes[2] = is_box ? vec4(v, -low.y) : vec4(v - low.y * along, 0.0);
    r.planes[3] = is_box ? vec4(-v, high.y) : vec4(high.y * along - v, 0.0);
    r.planes[4] = vec4(along, -near);
    r.planes[5] = vec4(-along, far);
    for (int k = 0; k < 6; k++) r.planes[k] /= length(r.planes[k].xyz);
    for (int k = 0; k < 8; k++) {
        float at = k < 4 ? near : far, wide = is_box ? 1.0 : at;
        r.corners[k] = ((k & 1) != 0 ? high.x : low.x) * wide * u + ((k & 2) != 0 ? high.y : low.y) * wide * v + at * along;
    }
    return r;
}

// What rounds in the place of something, metres: of its vertices, and of the numbers of these tests.
float volume_slack(page_volume r, vec3 center) { return 4e-6 * (length(r.origin) + length(center)); }

// Whether a box may touch the volume; `center` is relative to the light. Comparisons are such that a NaN keeps the box.
bool volume_meets_box(page_volume r, vec3 center, vec3 a, vec3 b, vec3 c) {
    float slack = volume_slack(r, center);
    if (length(max(abs(center) - abs(a) - abs(b) - abs(c), vec3(0.0))) > r.range + slack) return false;
    for (int k = 0; k < 6; k++) {
        vec3 n = r.planes[k].xyz;
        float reach = abs(dot(n, a)) + abs(dot(n, b)) + abs(dot(n, c));
        if (dot(n, center) + r.planes[k].w < -reach - slack) return false;
    }
    return true;
}

// The same for a box that does not lie along the axes: the volume may be all on one side of it.
bool volume_meets_turned_box(page_volume r, vec3 center, vec3 a, vec3 b, vec3 c) {
    if (!volume_meets_box(r, center, a, b, c)) return false;
    vec3 edges[3] = vec3[3](a, b, c);
    float slack = volume_slack(r, center);
    for (int k = 0; k < 3; k++) {
        vec3 n = cross(edges[(k + 1) % 3], edges[(k + 2) % 3]);
        float reach = abs(dot(n, edges[k])) + slack * length(n), low = 3e38, high = -3e38;
        for (int i = 0; i < 8; i++) {
            float at = dot(n, r.corners[i] - center);
            low = min(low, at);
            high = max(high, at);
        }
        if (low > reach || high < -reach) return false;
    }
    return true;
}

bool volume_meets_node(page_volume r, gpu_ray_node node) {
    vec3 center = 0.5 * (node.low + node.high) - r.origin, half_size = 0.5 * (node.high - node.low);
    return node.low.x <= node.high.x &&
           volume_meets_box(r, center, vec3(half_size.x, 0.0, 0.0), vec3(0.0, half_size.y, 0.0), vec3(0.0, 0.0, half_size.z));
}

bool volume_meets_caster(page_volume r, gpu_fill_caster c) {
    if (c.low.x > c.high.x) return false;
    gpu_instance instance = gpu_instance(c.rows);
    vec3 center = transform_point(instance, 0.5 * (c.low + c.high)) - r.origin, half_size = 0.5 * (c.high - c.low);
    return volume_meets_turned_box(r, center, transform_direction(instance, vec3(half_size.x, 0.0, 0.0)),
                                   transform_direction(instance, vec3(0.0, half_size.y, 0.0)),
                                   transform_direction(instance, vec3(0.0, 0.0, half_size.z)));
}

bool volume_meets_sphere(page_volume r, vec3 center, float radius) {
    float reach = radius + volume_slack(r, center);
    if (length(center) > r.range + reach) return false;
    for (int k = 0; k < 6; k++)
        if (dot(r.planes[k].xyz, center) + r.planes[k].w < -reach) return false;
    return true;
}

// The group that an item is in, or, by_unit, a unit. Both lie in the order of groups.
uint group_of(scene_block s, uint group_count, uint index, bool by_unit) {
    uint low = 0u, high = group_count;
    while (high - low > 1u) {
        uint middle = (low + high) / 2u;
        if ((by_unit ? s.scene.groups.at[middle].first_unit : s.scene.groups.at[middle].first_item) <= index) low = middle;
        else high = middle;
    }
    return low;
}

// How many units a group has.
uint units_of(scene_block s, uint group_count, uint unit_count, uint group) {
    return (group + 1u < group_count ? s.scene.groups.at[group + 1u].first_unit : unit_count) - s.scene.groups.at[group].first_unit;
}

#endif
