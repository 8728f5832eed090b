// SPDX-License-Identifier: MIT
// Gradients of texture coordinates, from neighbours.
vec4 uv_at(ivec2 pixel) { return uintBitsToFloat(target(TARGET_UV, pixel)); }

// Depth changes by a constant from pixel to pixel of a plane, so the slope tells whether a neighbour lies in this pixel's plane.
// Neighbours in the planes beside it, of a curved surface, do nearly: a fifth of the slope and a thousandth of the depth are allowed.
bool is_same_surface(ivec2 pixel, ivec2 side, uint id, uint frame, float depth, vec2 slopes) {
    ivec2 other = pixel + side;
    if (any(lessThan(other, ivec2(0))) || any(greaterThanEqual(uvec2(other), push.view.view.size))) return false;
    float there = depth_at(other);
    if (there <= 0.0 || target(TARGET_ID, other).x != id || (target(TARGET_FRAME, other).y ^ frame) >> 30 != 0u) return false;
    float change = dot(slopes, vec2(side));
    return abs(there / depth - 1.0 - change) <= 0.001 + 0.2 * abs(change);
}

// Of the neighbours on either side that lie on the same surface the one with the nearest coordinates; whether there is one.
bool derive_axis(ivec2 pixel, ivec2 side, uint id, uint frame, float depth, vec2 slopes, out vec4 change) {
    float best = 1e30;
    change = vec4(0.0);
    for (int way = -1; way <= 1; way += 2) {
        if (!is_same_surface(pixel, side * way, id, frame, depth, slopes)) continue;
        vec4 difference = (uv_at(pixel + side * way) - in_uv) * float(way);
        float distance = dot(difference, difference);
        if (distance >= best) continue;
        best = distance;
        change = difference;
    }
    return best < 1e30;
}

// Where no neighbour serves along one axis: as far as along the other one, at a right angle. Along neither: a level that is not the finest.
void derive_gradients(ivec2 pixel, uint id, uint frame, float depth, vec2 slopes) {
    bool along = derive_axis(pixel, ivec2(1, 0), id, frame, depth, slopes, in_uv_dx);
    bool down = derive_axis(pixel, ivec2(0, 1), id, frame, depth, slopes, in_uv_dy);
    if (!along && !down) in_uv_dx = vec4(1.0 / 256.0, 0.0, 1.0 / 256.0, 0.0);
    if (!along && down) in_uv_dx = in_uv_dy.yxwz * vec4(1.0, -1.0, 1.0, -1.0);
    if (!down) in_uv_dy = in_uv_dx.yxwz * vec4(-1.0, 1.0, -1.0, 1.0);
}

