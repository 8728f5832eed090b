#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Lines and diagonals of luma edges, with sharp corners (morphological.h).
#include "passes/aa/morphological.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

const int SEARCH = 64;          // edges each way along a line
const int DIAGONAL_SEARCH = 32; // pixels each way along a stair
const int DIAGONAL_SHORTEST = 5; // edges of a stair that counts as a diagonal
const float CORNER_ROUNDING = 0.25;

// ---- lines ----

// Edges that a line may pass to get to its edge i from the one before: those that exist and that nothing crosses before.
uint passable(int axis, int line, int word) {
    return along_word(axis, line, word) & ~(across_word(axis, line - 1, word) | across_word(axis, line, word));
}

// First and last edge of the line that holds `at`, within the search.
ivec2 ends_of(int axis, int line, int at) {
    int word = at >> 5;
    // The line begins at the last edge, up to this one, that cannot be reached from the one before.
    uint stops = ~passable(axis, line, word) & (2u << uint(at & 31)) - 1u;
    while (stops == 0u && word > 0 && word * 32 > at - SEARCH) stops = ~passable(axis, line, --word);
    int first = stops == 0u ? word * 32 : word * 32 + findMSB(stops);
    if (first < at && !along(axis, line, first)) first++;
    word = at >> 5;
    stops = ~passable(axis, line, word) & ~((2u << uint(at & 31)) - 1u);
    while (stops == 0u && word + 1 < int(line_words(axis)) && word * 32 < at + SEARCH) stops = ~passable(axis, line, ++word);
    int last = stops == 0u ? word * 32 + 31 : word * 32 + findLSB(stops) - 1;
    return ivec2(max(first, at - SEARCH), min(min(last, line_length(axis) - 1), at + SEARCH));
}

// Bit 0: crossed before the line, bit 1: behind it.
int crossing(int axis, int line, int at) {
    return int(across(axis, line - 1, at)) | int(across(axis, line, at)) << 1;
}

// An edge that goes on beyond the row beside the line is the side of a shape: there the line ends in a corner, not in a step.
float sharpness(int axis, int line, int at, int side) {
    return across(axis, side > 0 ? line + 1 : line - 2, at) ? CORNER_ROUNDING : 1.0;
}

// Is an edge of the stair at one of its corners? See diagonal().
bool in_diagonal(ivec2 p, int axis);

float weight_of(int axis, int line, int at, int side) {
    if (!along(axis, line, at) || in_diagonal(axis == 0 ? ivec2(at, line) : ivec2(line, at), axis)) return 0.0;
    ivec2 ends = ends_of(axis, line, at);
    int wanted = side > 0 ? 2 : 1;
    int first = at - ends.x < SEARCH ? crossing(axis, line, ends.x) : 0;
    int last = ends.y - at < SEARCH ? crossing(axis, line, ends.y + 1) : 0;
    // Crossed on both sides it is a step if the other end says to which.
    if (first == 3) first = last == 1 || last == 2 ? 3 - last : 0;
    if (last == 3) last = first == 1 || first == 2 ? 3 - first : 0;
    float half_length = 0.5 * float(ends.y - ends.x + 1), weight = 0.0;
    if (first == wanted) weight += area_under(half_length, float(at - ends.x)) * sharpness(axis, line, ends.x, side);
    if (last == wanted) weight += area_under(half_length, float(ends.y - at)) * sharpness(axis, line, ends.y + 1, side);
    return weight;
}

// ---- diagonals ----

// The edges of pixel p that meet in its corner towards `corner` (each component -1 or 1).
bool level_edge(ivec2 p, ivec2 corner) { return along(0, corner.y < 0 ? p.y : p.y + 1, p.x); }
bool upright_edge(ivec2 p, ivec2 corner) { return along(1, corner.x < 0 ? p.x : p.x + 1, p.y); }

// Follows the stair from an edge of p away from the corner: along its upright edge, or along its level one. x: edges passed; y: where
// it leads on behind the end, 1 out of the shape that p belongs to, -1 into it, 0 nowhere.
ivec2 follow(ivec2 p, ivec2 corner, bool upright_first) {
    ivec2 step = upright_first ? ivec2(corner.x, -corner.y) : ivec2(-corner.x, corner.y);
    int count = 1;
    bool upright = upright_first; // the last edge passed
    ivec2 at = p;
    for (int i = 0; i < 2 * DIAGONAL_SEARCH; i++) {
        if (upright == upright_first) {
            // The pixel's second edge is passed: the next one's first follows.
            if (upright ? level_edge(at + step, corner) : upright_edge(at + step, corner)) {
                at += step;
            } else {
                bool longer = upright ? upright_edge(at + ivec2(0, step.y), corner) : level_edge(at + ivec2(step.x, 0), corner);
                return ivec2(count, longer ? -1 : 0);
            }
        } else if (!(upright ? level_edge(at, corner) : upright_edge(at, corner))) {
            bool longer = upright ? upright_edge(at + ivec2(0, step.y), corner) : level_edge(at + ivec2(step.x, 0), corner);
            return ivec2(count, longer ? 1 : 0);
        }
        upright = !upright;
        count++;
    }
    return ivec2(count, 0);
}

// The part of p that the line along the stair at this corner cuts off, or -1 when there is no stair. A line at 45 degrees through the
// middle of all edges cuts off a triangle with legs of half a pixel. Where the stair leads on by a longer step, the line moves out or in
// by half a pixel; between two ends it does so evenly, from a single end within half the length.
float diagonal(ivec2 p, ivec2 corner) {
    if (!level_edge(p, corner) || !upright_edge(p, corner)) return -1.0;
    ivec2 up = follow(p, corner, true), level = follow(p, corner, false);
    if (up.x + level.x < DIAGONAL_SHORTEST) return -1.0;
    float t = float(level.x) / float(up.x + level.x), from = 0.5 * float(level.y), to = 0.5 * float(up.y);
    float moved = from * to < 0.0 ? mix(from, to, t) : t < 0.5 ? from * (1.0 - 2.0 * t) : to * (2.0 * t - 1.0);
    float leg = clamp(0.5 - moved, 0.0, 1.0);
    return 0.5 * leg * leg;
}

bool in_stair(ivec2 p, ivec2 corner) {
    if (!level_edge(p, corner) || !upright_edge(p, corner)) return false;
    return follow(p, corner, true).x + follow(p, corner, false).x >= DIAGONAL_SHORTEST;
}

// The edge before p is one of two pixels' corners on each of its ends.
bool in_diagonal(ivec2 p, int axis) {
    ivec2 before = axis == 0 ? p - ivec2(0, 1) : p - ivec2(1, 0), one = axis == 0 ? ivec2(1, -1) : ivec2(-1, 1);
    return in_stair(p, ivec2(-1, -1)) || in_stair(p, one) || in_stair(before, ivec2(1, 1)) || in_stair(before, -one);
}

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, picture_size()))) return;
    vec4 self = picture_at(p);
    bvec4 edges = bvec4(along(0, p.y, p.x), along(0, p.y + 1, p.x), along(1, p.x, p.y), along(1, p.x + 1, p.y));
    if (!any(edges)) {
        imageStore(images[push.target], p, self);
        return;
    }
    float total = 0.0;
    vec4 sum = vec4(0.0);
    for (int i = 0; i < 4; i++) {
        ivec2 corner = ivec2((i & 1) * 2 - 1, (i & 2) - 1);
        float cut = diagonal(p, corner);
        if (cut <= 0.0) continue;
        vec4 outside = to_light(picture_at(p + ivec2(corner.x, 0))) + to_light(picture_at(p + ivec2(0, corner.y)));
        sum += outside * (0.5 * cut);
        total += cut;
    }
    if (total > 0.0) {
        float scale = total > 1.0 ? 1.0 / total : 1.0;
        imageStore(images[push.target], p, from_light(to_light(self) * (1.0 - total * scale) + sum * scale));
        return;
    }
    vec4 weights = vec4(weight_of(0, p.y, p.x, 1), weight_of(0, p.y + 1, p.x, -1), weight_of(1, p.x, p.y, 1),
                        weight_of(1, p.x + 1, p.y, -1));
    imageStore(images[push.target], p, blended(p, self, weights));
}
