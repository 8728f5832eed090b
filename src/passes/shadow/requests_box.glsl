// SPDX-License-Identifier: MIT
// What all points of a box may ask a light for: never less than request_light() would ask for any of them.
#ifndef SHADOW_REQUESTS_BOX_GLSL
#define SHADOW_REQUESTS_BOX_GLSL

#include "passes/shadow/requests.glsl"

struct request_box {
    vec3 low, high;   // world space
    float near;       // the greatest of the points
    float fine, wide; // the least and the greatest width of a pixel, metres
    float widest;     // as of the maps
};

// Whether the light may reach some of the points.
bool request_box_reached(request_box box, gpu_shape shape) {
    vec3 away = max(max(box.low - shape.position, shape.position - box.high), vec3(0.0));
    if (dot(away, away) > shape.range * shape.range * 1.001) return false;
    if (shape.kind != GPU_SHAPE_CONE) return true;
    vec3 ray = 0.5 * (box.low + box.high) - shape.position; // the ball round the box against the cone
    float cosine = clamp(-shape.spot_offset / shape.spot_scale, -1.0, 1.0), along = dot(ray, shape.direction);
    float across = sqrt(max(dot(ray, ray) - along * along, 0.0)), radius = 0.5 * length(box.high - box.low) + box.near;
    return !(across * cosine - along * sqrt(1.0 - cosine * cosine) > radius + 1e-3 * length(ray));
}

// Where points are seen on a face.
struct request_seen {
    vec2 low, high;
    vec2 along; // least and greatest w of shadow_face_clip()
    float slack; // by which they may lie beside that, in faces' widths of 2
};

// Bits of the faces that the points may be seen in, and how far from the light those are at least; 0: the light may be among them.
uint request_box_faces(gpu_shape shape, request_box box, out float least) {
    if (shape.kind == GPU_SHAPE_BOX) {
        least = 1.0;
        return 1u;
    }
    vec3 low = box.low - shape.position, high = box.high - shape.position;
    vec3 away = max(max(low, -high), vec3(0.0)); // along each axis
    least = max(away.x, max(away.y, away.z)) - 2.01 * box.near;
    if (!(least > 0.0)) return 0u;
    bvec3 ahead = greaterThanEqual(high, vec3(least)), behind = lessThanEqual(low, vec3(-least));
    return uint(ahead.x) | uint(behind.x) << 1 | uint(ahead.y) << 2 | uint(behind.y) << 3 | uint(ahead.z) << 4 | uint(behind.z) << 5;
}

request_seen request_box_seen(gpu_shape shape, request_box box, uint face, float least) {
    vec3 low = box.low - shape.position, high = box.high - shape.position;
    request_seen s;
    if (shape.kind == GPU_SHAPE_BOX) {
        vec3 up = cross(shape.side, shape.direction), middle = 0.5 * (low + high), half_size = 0.5 * (high - low);
        vec2 at = vec2(dot(middle, shape.side), dot(middle, up)) / shape.size.xy;
        vec2 size = vec2(dot(half_size, abs(shape.side)), dot(half_size, abs(up))) / shape.size.xy;
        s.low = at - size;
        s.high = at + size;
        s.along = vec2(1.0);
        s.slack = box.near / min(shape.size.x, shape.size.y) + 1e-5;
        return s;
    }
    uint axis = face >> 1u, u = axis == 2u ? 0u : axis + 1u, v = axis == 0u ? 2u : axis - 1u;
    bool is_behind = (face & 1u) != 0u;
    float from = max(is_behind ? -high[axis] : low[axis], least), to = is_behind ? -low[axis] : high[axis];
    vec2 a = vec2(low[u], low[v]), b = vec2(high[u], high[v]);
    s.low = max(mix(a / from, a / to, greaterThan(a, vec2(0.0))), vec2(-2.0));
    s.high = min(mix(b / to, b / from, greaterThan(b, vec2(0.0))), vec2(2.0));
    s.along = vec2(from, to);
    s.slack = box.near / from + 1e-5;
    return s;
}

// The finest and the coarsest level that they need.
uvec2 request_seen_levels(gpu_shape shape, request_box box, request_seen s) {
    return uvec2(shadow_level_for(shadow_across(shape, s.along.y, box.fine) * (1.0 + s.slack + 2e-4), box.widest),
                 shadow_level_for(shadow_across(shape, s.along.x, box.wide) / (1.0 + s.slack + 2e-4), box.widest));
}

const uint REQUEST_MOST = 16u; // pages that are looked at; of more, some are likely to be missing

// Whether all that the points may ask the light for has been asked for. False also where that is not known.
bool request_box_made(uint_array wanted, uint row, gpu_shape shape, request_box box) {
    float least;
    uint faces = request_box_faces(shape, box, least), room = REQUEST_MOST;
    bool is_made = faces != 0u;
    for (; faces != 0u && is_made; faces &= faces - 1u) {
        uint face = uint(findLSB(faces));
        request_seen s = request_box_seen(shape, box, face, least);
        uvec2 levels = request_seen_levels(shape, box, s);
        request_walk walk = request_walk_begin(face, levels.x, levels.y, s.low, s.high, s.slack);
        bool is_last = request_walk_ends(walk);
        is_made = request_is_made(wanted, row, request_walk_bit(walk));
        for (; is_made && !is_last; room--) {
            is_last = !request_walk_next(walk);
            is_made = is_last || room > 1u && request_is_made(wanted, row, request_walk_bit(walk));
        }
    }
    return is_made;
}

#endif
