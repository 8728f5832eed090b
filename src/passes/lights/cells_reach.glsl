// SPDX-License-Identifier: MIT
// Tighter tests than sphere against planes and box, for any cell with gpu_cell_bounds: cells.glsl includes this. All keep the light when
// anything is NaN, and none loses a light to rounding.
#ifndef CELLS_REACH_GLSL
#define CELLS_REACH_GLSL

// How often a plane between cone and cell is looked for. Few pairs that do not touch need more; they are kept.
const int CONE_STEPS = 8;

// ---- cones ----

// The cone of a shape, in view space. `slack`: metres by which rounding may have moved it.
void reach_cone(gpu_shape shape, mat4 world_to_view, float slack, inout gpu_reach r) {
    r.apex = (world_to_view * vec4(shape.position, 1.0)).xyz;
    r.axis = normalize(mat3(world_to_view) * shape.direction);
    r.range = 0.0;
    if (shape.kind == GPU_SHAPE_CONE) {
        r.cosine = -shape.spot_offset / shape.spot_scale;
        r.range = shape.range;
    } else if (shape.kind == GPU_SHAPE_WEDGE) {
        r.cosine = inversesqrt(1.0 + dot(shape.size.xy, shape.size.xy));
        r.range = shape.range;
    }
    // Shading compares cosines: their rounding opens narrow cones more than wide ones.
    r.cosine = max(r.cosine - 2e-6, 0.0);
    r.sine = sqrt(1.0 - r.cosine * r.cosine);
    r.slack = slack + CELL_SLACK * (1e-2 + r.range + length(r.apex) * 1e-2);
}

// The point of the cone (a sector of a sphere) that lies farthest along a unit direction.
vec3 cone_farthest(gpu_reach r, vec3 direction) {
    float along = dot(direction, r.axis);
    if (along >= r.cosine) return r.apex + r.range * direction;
    vec3 across = direction - along * r.axis;
    float across_length = length(across), rim = r.cosine * along + r.sine * across_length;
    return rim > 0.0 ? r.apex + r.range * (r.cosine * r.axis + r.sine / across_length * across) : r.apex;
}

// A side of the cell as coordinate = x * view depth + y. 0: left, 1: right, 2: bottom, 3: top.
vec2 cell_side(gpu_cell_bounds b, int side) {
    vec4 p = side == 0 ? b.planes[0] : side == 1 ? b.planes[1] : side == 2 ? b.planes[2] : b.planes[3];
    return vec2(p.z, -p.w) / (side < 2 ? p.x : p.y);
}

// The corner, between two view depths, that lies farthest along a direction.
vec3 cell_farthest(gpu_cell_bounds b, float near, float far, vec3 direction) {
    vec2 x = cell_side(b, direction.x > 0.0 ? 1 : 0), y = cell_side(b, direction.y > 0.0 ? 3 : 2);
    float depth = direction.x * x.x + direction.y * y.x > direction.z ? far : near;
    return vec3(x.x * depth + x.y, y.x * depth + y.y, -depth);
}

// Cone against the cell between its planes and depths. Cut to the cone's own depths a long thin cell becomes a short one; then a
// separating plane is looked for by reflecting its normal at the gap between the two extreme points (K. Chung, W. Wang, "Quick
// Collision Detection of Polytopes in Virtual Environments", VRST 1996). True for lights without a cone.
bool cell_touches_cone(gpu_cell_bounds b, gpu_reach r) {
    if (!(r.range > 0.0)) return true;
    float near = max(max(-b.high.z, -cone_farthest(r, vec3(0.0, 0.0, 1.0)).z - r.slack), 0.0);
    float far = min(-b.low.z, -cone_farthest(r, vec3(0.0, 0.0, -1.0)).z + r.slack);
    if (near > far) return false;
    vec3 low = cell_farthest(b, near, far, vec3(-1.0, -1.0, 0.0)), high = cell_farthest(b, near, far, vec3(1.0, 1.0, 0.0));
    vec3 normal = vec3((low.xy + high.xy) * 0.5, -0.5 * (near + far)) - (r.apex + r.axis * (0.5 * r.range)); // from cone to cell
    for (int i = 0; i < CONE_STEPS; i++) {
        float length2 = dot(normal, normal);
        if (!(length2 > 0.0)) return true;
        normal *= inversesqrt(length2);
        vec3 gap = cell_farthest(b, near, far, -normal) - cone_farthest(r, normal);
        float apart = dot(normal, gap), gap2 = dot(gap, gap);
        if (apart > r.slack) return false;
        if (!(apart < 0.0)) return true;
        normal -= 2.0 * apart / gap2 * gap;
    }
    return true;
}

// ---- rectangles ----

// Least and greatest coordinate / view depth of a disk's part beyond the near plane: tangents from the viewer, or the ends of the cut
// where they touch before it (M. Mara, M. McGuire, "2D Polyhedral Bounds of a Clipped, Perspective-Projected 3D Sphere", JCGT 2(2), 2013).
vec2 disk_slopes(vec2 center, float radius, float near) {
    float to_plane = near - center.y, half_cut = sqrt(max(radius * radius - to_plane * to_plane, 0.0));
    vec2 slopes = vec2(center.x - half_cut, center.x + half_cut) / near;
    float tangent2 = dot(center, center) - radius * radius;
    if (tangent2 > 0.0) {
        float tangent = sqrt(tangent2), least = near * dot(center, center) / tangent;
        vec2 low = vec2(tangent * center.x - radius * center.y, tangent * center.y + radius * center.x);
        vec2 high = vec2(tangent * center.x + radius * center.y, tangent * center.y - radius * center.x);
        if (low.y >= least) slopes.x = low.x / low.y;
        if (high.y >= least) slopes.y = high.x / high.y;
    }
    return slopes;
}

void reach_rectangle(view_block v, gpu_bound light, inout gpu_reach r) {
    float radius = cell_radius(light);
    r.low = light.center.xy - radius;
    r.high = light.center.xy + radius;
    if (v.view.orthographic > 0.5) return;
    vec2 x = disk_slopes(vec2(light.center.x, -light.center.z), radius, v.view.near_distance);
    vec2 y = disk_slopes(vec2(light.center.y, -light.center.z), radius, v.view.near_distance);
    r.low = vec2(x.x, y.x);
    r.high = vec2(x.y, y.y);
}

// Left, right, bottom and top of a cell in the measure of gpu_reach's rectangle.
vec4 cell_rectangle(gpu_cell_bounds b) {
    return vec4((b.planes[0].z - b.planes[0].w) / b.planes[0].x, (b.planes[1].z - b.planes[1].w) / b.planes[1].x,
                (b.planes[2].z - b.planes[2].w) / b.planes[2].y, (b.planes[3].z - b.planes[3].w) / b.planes[3].y);
}

// Rectangle and depth range of the sphere against those of the cell.
bool cell_touches_rectangle(gpu_cell_bounds b, gpu_bound light, gpu_reach r) {
    vec4 cell = cell_rectangle(b);
    float radius = cell_radius(light);
    if (r.low.x > cell.y || r.high.x < cell.x || r.low.y > cell.w || r.high.y < cell.z) return false;
    return !(light.center.z - radius > b.high.z) && !(light.center.z + radius < b.low.z) && !(b.low.z > b.high.z);
}

// Sphere against the side planes and the depth range.
bool cell_touches_planes(gpu_cell_bounds b, gpu_bound light) {
    float radius = cell_radius(light);
    for (int i = 0; i < 4; i++)
        if (dot(b.planes[i].xyz, light.center) + b.planes[i].w < -radius) return false;
    return !(light.center.z - radius > b.high.z) && !(light.center.z + radius < b.low.z) && !(b.low.z > b.high.z);
}

#endif
