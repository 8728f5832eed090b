// SPDX-License-Identifier: MIT
// What all points of a box may ask a light for: never less than request_light() would ask for any of them.
#ifndef SHADOW_REQUESTS_BOX_GLSL
#define SHADOW_REQUESTS_BOX_GLSL

#include "passes/shadow/requests.glsl"

struct request_box {
    vec3 low, high;   // world space
    float near;       // the greatest of the points
    float fine, wide; // the least and the greatest width of a pixel, metres
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

const uint REQUEST_MOST = 16u; // pages that are looked at; of more, some are likely to be missing

// Of a face: `low` and `high` bound where the points are seen on it, `across` the widths of shadow_across(). `room`: pages that may still be looked at.
bool request_face_made(uint_array wanted, uint row, uint face, vec2 low, vec2 high, vec2 across, float slack, inout uint room) {
    slack += 1e-5;
    uint finest = shadow_level_for(across.y * (1.0 + slack + 2e-4)), coarsest = shadow_level_for(across.x / (1.0 + slack + 2e-4));
    request_walk walk = request_walk_begin(face, finest, coarsest, low, high, slack);
    bool is_made = request_is_made(wanted, row, request_walk_bit(walk)), is_last = request_walk_ends(walk);
    for (; is_made && !is_last; room--) {
        is_last = !request_walk_next(walk);
        is_made = is_last || room > 1u && request_is_made(wanted, row, request_walk_bit(walk));
    }
    return is_made;
}

// Whether all that the points may ask the light for has been asked for. False also where that is not known.
bool request_box_made(uint_array wanted, uint row, gpu_shape shape, request_box box) {
    vec3 low = box.low - shape.position, high = box.high - shape.position;
    uint room = REQUEST_MOST;
    if (shape.kind == GPU_SHAPE_BOX) {
        vec3 up = cross(shape.side, shape.direction), middle = 0.5 * (low + high), half_size = 0.5 * (high - low);
        vec2 at = vec2(dot(middle, shape.side), dot(middle, up)) / shape.size.xy;
        vec2 size = vec2(dot(half_size, abs(shape.side)), dot(half_size, abs(up))) / shape.size.xy;
        float width = 2.0 * max(shape.size.x, shape.size.y), slack = box.near / min(shape.size.x, shape.size.y);
        return request_face_made(wanted, row, 0u, at - size, at + size, width / vec2(box.wide, box.fine), slack, room);
    }
    vec3 least = max(max(low, -high), vec3(0.0)); // distances along each axis
    float along_least = max(least.x, max(least.y, least.z)) - 2.01 * box.near;
    if (!(along_least > 0.0)) return false; // the light may be among them
    bvec3 ahead = greaterThanEqual(high, vec3(along_least)), behind = lessThanEqual(low, vec3(-along_least));
    uint faces = uint(ahead.x) | uint(behind.x) << 1 | uint(ahead.y) << 2 | uint(behind.y) << 3 | uint(ahead.z) << 4 | uint(behind.z) << 5;
    bool is_made = true;
    for (; faces != 0u && is_made; faces &= faces - 1u) {
        uint face = uint(findLSB(faces)), axis = face >> 1u, u = axis == 2u ? 0u : axis + 1u, v = axis == 0u ? 2u : axis - 1u;
        bool is_behind = (face & 1u) != 0u;
        float from = max(is_behind ? -high[axis] : low[axis], along_least), to = is_behind ? -low[axis] : high[axis];
        vec2 a = vec2(low[u], low[v]), b = vec2(high[u], high[v]);
        a = mix(a / from, a / to, greaterThan(a, vec2(0.0)));
        b = mix(b / to, b / from, greaterThan(b, vec2(0.0)));
        is_made = request_face_made(wanted, row, face, max(a, vec2(-2.0)), min(b, vec2(2.0)), 2.0 * vec2(from / box.wide, to / box.fine),
                                    box.near / from, room);
    }
    return is_made;
}

#endif
