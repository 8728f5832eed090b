// SPDX-License-Identifier: MIT
// One group walks through the lights of one tile for one list. Lights come in ascending order: a batch of marks is tested by all threads,
// and what they find is compacted by counting bits, so nothing depends on the order in which threads run. No number of lights is too many:
// the marks are taken in batches, and what a batch keeps is flushed before the next might not fit.
#ifndef FINE_TILE_GLSL
#define FINE_TILE_GLSL

#include "passes/lights/fine_pixels.glsl"

layout(constant_id = 2) const uint TILE_SIZE = 16u;  // pixels
layout(constant_id = 4) const uint BLENDS = 1u;      // 0: no list is of blended surfaces
layout(constant_id = 5) const uint KEPT_WORDS = 0u;  // masks that the count keeps for a pixel, of 32 lights each

// Each thread owns a square of the tile: see GROUP_SIDE in fine.c.
layout(local_size_x_id = 3, local_size_y_id = 3) in;

const uint THREADS = gl_WorkGroupSize.x * gl_WorkGroupSize.y, SIDE = TILE_SIZE / gl_WorkGroupSize.x, OWN = SIDE * SIDE;
// Shared memory limits how many groups run at a time: these are small.
const uint BATCH = 1024u, BATCH_WORDS = BATCH / 32u, HELD = 512u, ROOM = HELD + BATCH;
const uint PART = BATCH / THREADS; // bits of a batch that a thread tests: a part of a word

shared uint held[ROOM]; // lights in view that touch the tile's box; before them, the bounds of the threads' positions
shared uint kept_bits[ROOM / 32u];
// Bits of this batch, of the one before, and zeros for the next; behind the bits, how many are set.
const uint ROW = BATCH_WORDS + 1u;
shared uint touched[3u * ROW];
shared uint quads[64]; // masks of 2 x 2 pixels, whose threads are four

uint thread, flags, cell;
vec3 positions[OWN];
float slacks[OWN];  // how far off a position may be; negative: there is no surface
vec4 segments[OWN]; // of blended surfaces: from the position in this direction so far

bool is_blended() { return BLENDS != 0u && (flags & FINE_BLENDED) != 0u; }

uint fine_found_of(uint cell) { return cell * (FINE_FOUND + fine_squares() * KEPT_WORDS); }

// Within the tile. Four in a row are a square of 2 x 2 pixels where the thread owns so many.
uvec2 own_pixel(uint i) {
    uvec2 at = uvec2(i & 1u, i >> 1u & 1u);
    if (SIDE > 2u) at += uvec2(i / 4u % (SIDE / 2u), i / 4u / (SIDE / 2u)) * 2u;
    return gl_LocalInvocationID.xy * SIDE + at;
}

void take_position(uint i) {
    uvec2 pixel = gl_WorkGroupID.xy * TILE_SIZE + own_pixel(i);
    positions[i] = vec3(0.0);
    slacks[i] = -1.0;
    segments[i] = vec4(0.0);
    if (any(greaterThanEqual(pixel, push.view.view.size))) return;
    float view_depth;
    if (is_blended()) {
        float front, behind;
        if (!fine_blended(pixel, front, behind)) return;
        view_depth = view_depth_of(push.view, front);
        bool open = behind <= 0.0 && push.view.view.orthographic < 0.5; // up to the sky
        vec3 a = fine_position(pixel, view_depth), b = fine_position(pixel, open ? view_depth * 2.0 : view_depth_of(push.view, behind));
        float length_ab = distance(a, b);
        positions[i] = a;
        segments[i] = vec4(length_ab > 0.0 ? (b - a) / length_ab : vec3(0.0), open ? FINE_FAR : length_ab);
        // Positions are interpolated, and nobody compares them.
        slacks[i] = 4.0 * max(fine_slack(push.list, a), fine_slack(push.list, b));
        return;
    }
    bool sky;
    if (!fine_pixel_depth(pixel, view_depth, sky)) return;
    positions[i] = fine_position(pixel, view_depth);
    slacks[i] = fine_slack(push.list, positions[i]);
}

// Before the first test of pixels.
void take_positions() {
    for (uint i = 0u; i < OWN; i++) take_position(i);
}

// ---- whether a shape holds a point ----

// Of a light it is the support of light_strength() (shaders/lights/illuminate.glsl), widened by `slack` metres and by what rounding may do.
// What only rare shapes need stays where it is.
struct fine_volume {
    uint kind, shape; // GPU_SHAPE_…, and the number of the hull's planes << 8; where the shape is, or GPU_NO_SHAPE
    vec3 position, direction, center;
    float range, spot_scale, spot_offset, radius;
};

// `place` is one of the bounds.
fine_volume fine_volume_of(uint place) {
    fine_volume v;
    v.shape = push.list.list.entities.at[place].shape;
    v.center = vec3(0.0);
    v.radius = 0.0;
    if (v.shape == GPU_NO_SHAPE || is_blended()) {
        v.center = push.list.list.entities.at[place].center;
        v.radius = push.list.list.entities.at[place].radius;
    }
    v.position = v.center;
    v.range = v.radius;
    v.kind = GPU_SHAPE_SPHERE;
    v.direction = vec3(0.0);
    v.spot_scale = v.spot_offset = 0.0;
    if (v.shape == GPU_NO_SHAPE) return v;
    shape_block s = shape_at(push.list, v.shape);
    v.position = s.shape.position;
    v.range = s.shape.range;
    v.kind = s.shape.kind;
    if (v.kind != GPU_SHAPE_SPHERE) v.direction = s.shape.direction;
    if (v.kind == GPU_SHAPE_CONE) {
        v.spot_scale = s.shape.spot_scale;
        v.spot_offset = s.shape.spot_offset;
    }
    if (!LIST_SIMPLE) v.kind |= s.shape.hull_count << 8u;
    return v;
}

shared fine_volume staged[32]; // lights that all threads test: fetched once, not by each of them
shared uint whole_bits; // those of them that hold the whole tile

// Capsules, wedges and boxes; `from` the light's position.
bool fine_rare_holds(fine_volume v, uint kind, vec3 from, float slack) {
    shape_block s = shape_at(push.list, v.shape);
    vec3 size = s.shape.size;
    if (kind == GPU_SHAPE_CAPSULE) {
        vec3 nearest = from - v.direction * clamp(dot(from, v.direction), -size.x, size.x);
        float radius = size.y + slack;
        return !(dot(nearest, nearest) > radius * radius);
    }
    vec3 side = s.shape.side, at = vec3(dot(from, side), dot(from, cross(side, v.direction)), dot(from, v.direction));
    vec3 limit = kind == GPU_SHAPE_WEDGE ? vec3(size.xy * (at.z + slack), v.range) : size;
    if (kind == GPU_SHAPE_WEDGE && at.z < -slack) return false;
    return !any(greaterThan(abs(at), limit * (1.0 + 2e-6) + slack));
}

// All but the planes of the hull.
bool fine_shape_holds(fine_volume v, vec3 position, float slack) {
    vec3 from = position - v.position;
    float distance2 = dot(from, from), range = v.range + slack;
    if (distance2 > range * range) return false;
    slack += 2e-6 * v.range;
    uint kind = v.kind & 0xffu;
    if (kind == GPU_SHAPE_CONE) {
        // A step of s at the distance d > s turns the ray by asin(s / d) at most, which is below 1.6 s / d; others may reach the apex.
        float d = sqrt(distance2), along = dot(v.direction, from) + 1.6 * slack + 2e-6 * d;
        if (d > slack && along * v.spot_scale + v.spot_offset * d < 0.0) return false;
    }
    return LIST_SIMPLE || kind <= GPU_SHAPE_CONE || fine_rare_holds(v, kind, from, slack);
}

vec4 fine_plane(fine_volume v, uint i) { return push.list.list.planes.at[shape_at(push.list, v.shape).shape.hull_first + i]; }

bool fine_holds(fine_volume v, vec3 position, float slack) {
    if (!fine_shape_holds(v, position, slack)) return false;
    slack += 2e-6 * v.range;
    for (uint i = 0u; !LIST_SIMPLE && i < v.kind >> 8u; i++) {
        vec4 plane = fine_plane(v, i);
        if (dot(plane.xyz, position - v.position) > plane.w + slack) return false;
    }
    return true;
}

// Whether the light may reach blended surfaces of the pixel. A segment is held when its middle is, by a volume that is wider by half of it;
// and its nearest point to the centre of the light's sphere is in that.
bool holds_segment(fine_volume v, uint i) {
    vec4 s = segments[i];
    vec3 to_center = v.center - positions[i], off = to_center - s.xyz * clamp(dot(to_center, s.xyz), 0.0, s.w);
    float radius = v.radius * (1.0 + CELL_SLACK) + slacks[i];
    if (dot(off, off) > radius * radius) return false;
    return s.w > 1e6 || fine_holds(v, positions[i] + s.xyz * (0.5 * s.w), slacks[i] + 0.5 * s.w);
}

// A sphere round the tile's positions, which puts aside most lights that hold none of them at the price of one pixel's test.
vec3 tile_center;
float tile_radius;

void put_bounds(vec3 low, vec3 high) {
    for (uint k = 0u; k < 3u; k++) {
        held[thread * 6u + k] = floatBitsToUint(low[k]);
        held[thread * 6u + 3u + k] = floatBitsToUint(high[k]);
    }
}

void grow_bounds(inout vec3 low, inout vec3 high, uint of) {
    for (uint k = 0u; k < 3u; k++) {
        low[k] = min(low[k], uintBitsToFloat(held[of * 6u + k]));
        high[k] = max(high[k], uintBitsToFloat(held[of * 6u + 3u + k]));
    }
}

void bound_tile() {
    vec3 low = vec3(FINE_FAR), high = vec3(-FINE_FAR);
    for (uint i = 0u; i < OWN; i++) {
        if (slacks[i] < 0.0) continue;
        low = min(low, positions[i] - slacks[i]);
        high = max(high, positions[i] + slacks[i]);
    }
    put_bounds(low, high);
    barrier();
    for (uint i = thread < 8u ? thread + 8u : THREADS; i < THREADS; i += 8u) grow_bounds(low, high, i);
    if (thread < 8u) put_bounds(low, high);
    barrier();
    for (uint i = thread == 0u ? 1u : 8u; i < 8u; i++) grow_bounds(low, high, i);
    if (thread == 0u) put_bounds(low, high);
    barrier();
    grow_bounds(low, high, 0u);
    tile_center = 0.5 * (low + high);
    tile_radius = 0.5 * length(high - low) * 1.00001 + 1e-6 * length(tile_center);
}

// Whether a volume holds all of the tile's positions, so that none needs a test. The cone's bound grows no faster than distance does.
bool holds_whole_tile(fine_volume v) {
    vec3 from = tile_center - v.position;
    float d = length(from), room = v.range - d;
    if (is_blended() || v.kind > GPU_SHAPE_CONE || room < tile_radius) return false;
    return v.kind == GPU_SHAPE_SPHERE ||
           dot(v.direction, from) * v.spot_scale + v.spot_offset * d >= tile_radius * (abs(v.spot_scale) + abs(v.spot_offset));
}

// Fetches a light as bit `b`. All threads then pass a barrier.
void stage(uint b, uint place) {
    fine_volume v = fine_volume_of(place);
    staged[b] = v;
    if (holds_whole_tile(v)) atomicOr(whole_bits, 1u << b);
}

uint masks[OWN]; // which of the staged lights may reach the thread's pixels

// Without loops within the loops over pixels these unroll, and positions stay in registers.
void test_light(uint b) {
    fine_volume v = staged[b];
    uint bit = 1u << b;
    if (is_blended()) {
        for (uint i = 0u; i < OWN; i++)
            if (slacks[i] >= 0.0 && holds_segment(v, i)) masks[i] |= bit;
        return;
    }
    for (uint i = 0u; i < OWN; i++)
        if (slacks[i] >= 0.0 && fine_shape_holds(v, positions[i], slacks[i])) masks[i] |= bit;
    for (uint k = 0u; !LIST_SIMPLE && k < v.kind >> 8u; k++) {
        vec4 plane = fine_plane(v, k);
        for (uint i = 0u; i < OWN; i++)
            if (dot(plane.xyz, positions[i] - v.position) > plane.w + (slacks[i] + 2e-6 * v.range)) masks[i] &= ~bit;
    }
}

void test_staged(uint count) {
    for (uint i = 0u; i < OWN; i++) masks[i] = slacks[i] >= 0.0 ? whole_bits : 0u;
    for (uint rest = ~whole_bits & 0xffffffffu >> (32u - count); rest != 0u; rest &= rest - 1u) test_light(uint(findLSB(rest)));
}

// ---- the walk ----

// Masks of the thread's pixels over what the walk tests, kept where these are few enough lights.
bool makes_masks = false, has_masks = false;
uint tested_words = 0u;
uint kept_masks[OWN * KEPT_WORDS + 1u];

uint local_light(uint index) { return push.visible_ids.at[index]; }

// How many bits are set among those of `kept_bits` before this one.
uint kept_before(uint bit) {
    uint sum = uint(bitCount(kept_bits[bit / 32u] & ((1u << (bit & 31u)) - 1u)));
    for (uint w = 0u; w < bit / 32u; w++) sum += uint(bitCount(kept_bits[w]));
    return sum;
}

uint kept_in(uint words) {
    uint sum = 0u;
    for (uint w = 0u; w < words; w++) sum += uint(bitCount(kept_bits[w]));
    return sum;
}

// Leaves of what is held the lights whose volumes, widened by the tile's sphere, hold its centre. Barriers are before it and behind.
uint hold_tile(uint count) {
    uint words = (count + 31u) / 32u;
    if (thread < words) kept_bits[thread] = 0u;
    barrier();
    for (uint base = 0u; base < count; base += THREADS) {
        uint id = 0xffffffffu;
        // Once or not at all: a loop costs threads that have nothing to do nothing, also where branches are masks.
        for (uint i = base + thread; i < min(base + THREADS, count); i += THREADS) {
            if (!fine_holds(fine_volume_of(local_light(held[i])), tile_center, tile_radius)) continue;
            id = held[i];
            atomicOr(kept_bits[i / 32u], 1u << (i & 31u));
        }
        barrier();
        if (id != 0xffffffffu) held[kept_before(base + thread)] = id; // nobody reads that again
    }
    uint left = kept_in(words);
    barrier();
    return left;
}

// Gives what is kept to `out_ids` from `out_first` on, as far as it goes below `out_end`; returns how many are kept. `whole`: the tile has
// nothing before and behind. Barriers are before it and behind.
uint flush(uint count, bool whole, uint_array out_ids, uint out_first, uint out_end) {
    bool tests = (flags & FINE_PIXELS) != 0u;
    if (tests && !is_blended()) count = hold_tile(count);
    if (count == 0u) return 0u; // the whole group
    uint words = (count + 31u) / 32u;
    has_masks = makes_masks && whole && words <= KEPT_WORDS;
    tested_words = words;
    if (thread < max(words, KEPT_WORDS)) {
        uint in_word = min(count - min(thread * 32u, count), 32u);
        kept_bits[thread] = tests || in_word == 0u ? 0u : 0xffffffffu >> (32u - in_word);
    }
    barrier();
    for (uint w = 0u; tests && w < words; w++) {
        uint bits = 0u, end = min(32u, count - w * 32u);
        if (thread == 0u) whole_bits = 0u;
        barrier();
        for (uint b = thread; b < end; b += THREADS) stage(b, local_light(held[w * 32u + b]));
        barrier();
        test_staged(end);
        for (uint i = 0u; i < OWN; i++) {
            bits |= masks[i];
            for (uint k = 0u; k < KEPT_WORDS; k++)
                if (k == w) kept_masks[i * KEPT_WORDS + k] = masks[i];
        }
        if (bits != 0u) atomicOr(kept_bits[w], bits);
        barrier();
    }
    for (uint i = thread; i < count; i += THREADS) {
        if ((kept_bits[i / 32u] >> (i & 31u) & 1u) == 0u) continue;
        uint at = out_first + kept_before(i);
        if (at < out_end) out_ids.at[at] = push.list.list.packed == 1u ? held[i] : local_light(held[i]);
    }
    uint kept = kept_in(words);
    barrier();
    return kept;
}

uint walk(uint_array out_ids, uint out_first, uint out_end) {
    uint marks = fine_marks_of(gl_WorkGroupID.z, gl_WorkGroupID.xy);
    uint words = (push.visible_sums.at[push.list.list.local_count] + 31u) / 32u;
    uint kept = 0u, count = 0u, row = 0u;
    bool flushed = false;
    vec2 depths = vec2(0.0, FINE_FAR);
    if ((flags & (FINE_MIN_DEPTH | FINE_MAX_DEPTH)) != 0u)
        depths = fine_depths(flags, fine_range_of(flags, gl_WorkGroupID.xy));
    if (depths.x > depths.y) return 0u; // the whole group
    if ((flags & FINE_PIXELS) != 0u && !is_blended()) bound_tile();
    vec4 rect = vec4(gl_WorkGroupID.xy * TILE_SIZE, min((gl_WorkGroupID.xy + 1u) * TILE_SIZE, push.view.view.size));
    uint word = thread * PART / 32u, shift = thread * PART % 32u; // the thread's part of each batch
    if (thread < ROW) touched[thread] = 0u;
    barrier();
    for (uint base = 0u; base < words; base += BATCH_WORDS) {
        uint w = base + word, hits = 0u, next = row == 2u * ROW ? 0u : row + ROW;
        for (uint bits = w < words ? push.marks.at[marks + w] & ((1u << PART) - 1u) << shift : 0u; bits != 0u; bits &= bits - 1u) {
            uint bit = uint(findLSB(bits));
            if (fine_touches(push.boxes.at[w * 32u + bit], flags, rect, depths)) hits |= 1u << bit;
        }
        if (thread < ROW) touched[next + thread] = 0u; // was read two barriers ago
        if (hits != 0u) {
            atomicOr(touched[row + word], hits);
            atomicAdd(touched[row + BATCH_WORDS], uint(bitCount(hits)));
        }
        barrier();
        if (hits != 0u) {
            uint at = count + uint(bitCount(touched[row + word] & ((1u << shift) - 1u)));
            for (uint i = 0u; i < word; i++) at += uint(bitCount(touched[row + i]));
            for (; hits != 0u; hits &= hits - 1u) held[at++] = w * 32u + uint(findLSB(hits));
        }
        count += touched[row + BATCH_WORDS];
        row = next;
        if (count > HELD) {
            barrier();
            kept += flush(count, false, out_ids, out_first + kept, out_end);
            count = 0u;
            flushed = true;
        }
    }
    barrier();
    if (count > 0u) kept += flush(count, !flushed, out_ids, out_first + kept, out_end);
    return kept;
}

// Joins the masks of pixels that share one: `i` is the first of them. Returns the number of the square of pixels in the tile; fine_squares():
// another thread stores it. All threads call it; before they call it again they pass a barrier.
uint join_masks(uint i) {
    uint size = push.list.list.mask_size, row = TILE_SIZE / size;
    uvec2 square = own_pixel(i) / size;
    uint at = square.y * row + square.x;
    if (size == 1u) return at;
    if (SIDE > 1u) {
        for (uint k = 1u; k < 4u; k++) masks[i] |= masks[min(i + k, OWN - 1u)];
        return at;
    }
    if (thread < 64u) quads[thread] = 0u; // 2 x 2 threads
    barrier();
    if (masks[i] != 0u) atomicOr(quads[at], masks[i]);
    barrier();
    masks[i] = quads[thread & 63u];
    return min(thread, fine_squares());
}

// Pixels of a thread's that share a mask.
uint joined_pixels() { return SIDE == 1u ? 1u : push.list.list.mask_size * push.list.list.mask_size; }

void begin_tile() {
    thread = gl_LocalInvocationIndex;
    flags = fine_flags(gl_WorkGroupID.z);
    cell = gl_WorkGroupID.z * fine_tile_count() + gl_WorkGroupID.y * push.list.list.tiles_x + gl_WorkGroupID.x;
}

#endif
