// SPDX-License-Identifier: MIT
// Gradients of texture coordinates, from neighbours.
vec4 uv_at(ivec2 pixel, int at) { return uintBitsToFloat(target(TARGET_UV, pixel, at)); }

// Depth changes by a constant from pixel to pixel of a plane, so the slope tells whether a neighbour lies in this pixel's plane.
// Neighbours in the planes beside it, of a curved surface, do nearly: a fifth of the slope and a thousandth of the depth are allowed.
bool is_same_surface(vec2 point, ivec2 other, int at, uint id, uint frame, float depth, vec2 slopes) {
    if (any(lessThan(other, ivec2(0))) || any(greaterThanEqual(uvec2(other), push.view.view.size))) return false;
    float there = depth_at(other, at);
    if (there <= 0.0 || target(TARGET_ID, other, at).x != id) return false;
    if ((target(TARGET_FRAME, other, at).y ^ frame) >> 30 != 0u) return false;
    float change = dot(slopes, vec2(other) + seen_place(at) - point);
    return abs(there / depth - 1.0 - change) <= 0.001 + 0.2 * abs(change);
}

// Of the neighbours on either side that lie on the same surface the one with the nearest coordinates; whether there is one.
bool derive_axis(ivec2 pixel, vec2 point, ivec2 side, uint id, uint frame, float depth, vec2 slopes, out vec4 change) {
    float best = 1e30;
    change = vec4(0.0);
    for (int i = 0; i < 2 * SEEN_SAMPLES; i++) {
        int way = i < SEEN_SAMPLES ? -1 : 1, at = i % SEEN_SAMPLES;
        if (!is_same_surface(point, pixel + side * way, at, id, frame, depth, slopes)) continue;
        vec4 difference = (uv_at(pixel + side * way, at) - in_uv) * float(way);
        float distance = dot(difference, difference);
        if (distance >= best) continue;
        best = distance;
        change = difference;
    }
    return best < 1e30;
}

// Where no neighbour serves along one axis: as far as along the other one, at a right angle. Along neither: a level that is not the finest.
void derive_gradients(ivec2 pixel, vec2 point, uint id, uint frame, float depth, vec2 slopes) {
    bool along = derive_axis(pixel, point, ivec2(1, 0), id, frame, depth, slopes, in_uv_dx);
    bool down = derive_axis(pixel, point, ivec2(0, 1), id, frame, depth, slopes, in_uv_dy);
    if (!along && !down) in_uv_dx = vec4(1.0 / 256.0, 0.0, 1.0 / 256.0, 0.0);
    if (!along && down) in_uv_dx = in_uv_dy.yxwz * vec4(1.0, -1.0, 1.0, -1.0);
    if (!down) in_uv_dy = in_uv_dx.yxwz * vec4(-1.0, 1.0, -1.0, 1.0);
}

