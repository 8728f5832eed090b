// SPDX-License-Identifier: MIT
// One group walks through the lights of one tile for one list. Lights come in ascending order: a batch of marks is tested by all threads,
// and what they find is compacted by counting bits, so nothing depends on the order in which threads run. No number of lights is too many:
// the marks are taken in batches, and what a batch keeps is flushed before the next might not fit.
#ifndef FINE_TILE_GLSL
#define FINE_TILE_GLSL

#include "passes/lights/fine_pixels.glsl"

layout(constant_id = 2) const uint TILE_SIZE = 16u;  // pixels
layout(constant_id = 4) const uint BLENDS = 1u;      // 0: no list is of blended surfaces
layout(constant_id = 5) const uint KEPT_WORDS = 0u;  // masks that the count keeps for a square of pixels, of 32 lights each

// Each thread owns a square of the tile: see GROUP_SIDE in fine.c.
layout(local_size_x_id = 3, local_size_y_id = 3) in;

const uint THREADS = gl_WorkGroupSize.x * gl_WorkGroupSize.y, SIDE = TILE_SIZE / gl_WorkGroupSize.x, OWN = SIDE * SIDE;
// Shared memory limits how many groups run at a time: these are small. Once more than HELD lights touch the tile they are tested by pixels.
const uint HELD = 512u, ROOM = 1536u;
const uint RUN = 1024u / THREADS; // words of marks that a thread takes at a time
const uint RUNS = 16u, RUN_THREADS = THREADS / RUNS; // sums of what so many threads found are taken together

shared uint held[ROOM]; // lights in view that touch the tile's box; before them, the bounds of the threads' positions
shared uint kept_bits[ROOM / 32u];
shared uint run_sums[RUNS], thread_sums[THREADS];
shared uint taken_end, taken_threads; // of a batch: how many lights are held with it, and how many threads' words are in it
// What THREADS lights are tested for: this time, the time before, and zeros for the next.
const uint ROW = THREADS / 32u;
shared uint touched[3u * ROW];
shared uint quads[64]; // masks of 2 x 2 pixels, whose threads are four

uint thread, flags, cell;
vec3 positions[OWN];
float slacks[OWN];  // how far off a position may be; negative: there is no surface
vec4 segments[OWN]; // of blended surfaces: from the position in this direction so far

bool is_blended() { return BLENDS != 0u && (flags & FINE_BLENDED) != 0u; }

// What the count keeps of a cell: the lights, FINE_FOUND of them at most; how many words were tested, 0 if no masks are kept; the bits of
// what was tested and kept; and the masks, a word of all squares after the other.
const uint FOUND = KEPT_WORDS * 32u > FINE_FOUND ? KEPT_WORDS * 32u : FINE_FOUND;
uint fine_found_of(uint cell) { return cell * FINE_FOUND_WORDS(FOUND, KEPT_WORDS, fine_squares()); }
uint fine_found_bits(uint found) { return found + FOUND + 1u; }
uint fine_found_masks(uint found) { return fine_found_bits(found) + KEPT_WORDS; }

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

// Of a light it is the support of light_strength() (shaders/lighting/reach.glsl), widened by `slack` metres and by what rounding may do.
// All threads ask for the same lights at a time. They read them from memory rather than from shared memory: GPUs load what is uniform once, and a
// CPU gathers from memory in a few instructions, from shared memory in dozens.
#define VOLUMES fine_volume_array(push.bounds)

// Capsules, wedges and boxes; `from` the light's position.
bool fine_rare_holds(gpu_fine_volume v, uint kind, vec3 from, float slack) {
    shape_block s = shape_at(set_of(push.list), v.shape);
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

// The sphere round any shape.
bool fine_sphere_holds(vec3 center, float range, vec3 position, float slack) {
    vec3 from = position - center;
    range += slack;
    return !(dot(from, from) > range * range);
}

// True for other shapes.
bool fine_cone_holds(gpu_fine_volume v, vec3 position, float slack) {
    vec3 from = position - v.position;
    slack += 2e-6 * v.range;
    // A step of s at the distance d > s turns the ray by asin(s / d) at most, which is below 1.6 s / d; others may reach the apex.
    float d = length(from), along = dot(v.direction, from) + 1.6 * slack + 2e-6 * d;
    return (v.kind & 0xffu) != GPU_SHAPE_CONE || !(d > slack && along * v.spot_scale + v.spot_offset * d < 0.0);
}

vec4 fine_plane(gpu_fine_volume v, uint i) { return push.list.list.lights.set.planes.at[shape_at(set_of(push.list), v.shape).shape.hull_first + i]; }

// What is neither sphere nor cone: rare shapes, and hulls.
bool fine_rest_holds(gpu_fine_volume v, vec3 position, float slack) {
    slack += 2e-6 * v.range;
    uint kind = v.kind & 0xffu;
    if (kind > GPU_SHAPE_CONE && !fine_rare_holds(v, kind, position - v.position, slack)) return false;
    for (uint i = 0u; i < v.kind >> 8u; i++) {
        vec4 plane = fine_plane(v, i);
        if (dot(plane.xyz, position - v.position) > plane.w + slack) return false;
    }
    return true;
}

bool fine_holds(gpu_fine_volume v, vec3 position, float slack) {
    return fine_sphere_holds(v.position, v.range, position, slack) && fine_cone_holds(v, position, slack) &&
           (LIGHTING_SIMPLE || v.kind <= GPU_SHAPE_CONE || fine_rest_holds(v, position, slack));
}

// Whether the light may reach blended surfaces of the pixel. A segment is held when its middle is, by a volume that is wider by half of it;
// and its nearest point to the centre of the light's sphere is in that.
bool holds_segment(gpu_fine_volume v, uint i) {
    vec4 s = segments[i];
    vec3 to_center = v.center - positions[i], off = to_center - s.xyz * clamp(dot(to_center, s.xyz), 0.0, s.w);
    float radius = v.radius * (1.0 + CELL_SLACK) + slacks[i];
    if (dot(off, off) > radius * radius) return false;
    return s.w > 1e6 || fine_holds(v, positions[i] + s.xyz * (0.5 * s.w), slacks[i] + 0.5 * s.w);
}

// A box round the tile's positions and a sphere round it, which put aside most lights that hold none of them at the price of one pixel's test.
// Shared, because registers are dearer.
shared vec3 tile_low, tile_high;

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
    if (thread == 0u) {
        tile_low = low;
        tile_high = high;
    }
    barrier();
}

// Whether a volume may hold some of the tile's positions. The box lies snug at floors and walls, where the sphere would not.
bool reaches_tile(gpu_fine_volume v) {
    vec3 low = tile_low, high = tile_high, center = 0.5 * (low + high), off = max(max(low - v.position, v.position - high), vec3(0.0));
    float rounding = 1e-6 * (length(center) + length(v.position)), range = v.range * 1.00001 + rounding;
    return !(dot(off, off) > range * range) && fine_holds(v, center, 0.5 * length(high - low) * 1.00001 + rounding);
}

uint masks[OWN]; // which lights of a word may reach the thread's pixels

// Tests lights, up to 32 of them: of the list from `at` on, or of what is held.
void test_word(bool of_list, uint at, uint count) {
    for (uint i = 0u; i < OWN; i++) masks[i] = 0u;
    for (uint b = 0u; b < count; b++) {
        uint light = of_list ? push.ids.at[at + b] : held[at + b], bit = 1u << b;
        if (is_blended()) {
            gpu_fine_volume v = VOLUMES.at[light];
            for (uint i = 0u; i < OWN; i++)
                if (holds_segment(v, i)) masks[i] |= bit;
            continue;
        }
        vec3 position = VOLUMES.at[light].position;
        float range = VOLUMES.at[light].range;
        uint kind = VOLUMES.at[light].kind;
        for (uint i = 0u; i < OWN; i++)
            if (fine_sphere_holds(position, range, positions[i], slacks[i])) masks[i] |= bit;
        // Once or not at all: see leave().
        for (bool more = kind != GPU_SHAPE_SPHERE; more; more = false) {
            gpu_fine_volume v = VOLUMES.at[light];
            for (uint i = 0u; i < OWN; i++)
                if (!fine_cone_holds(v, positions[i], slacks[i])) masks[i] &= ~bit;
            for (bool rare = !LIGHTING_SIMPLE && kind > GPU_SHAPE_CONE; rare; rare = false)
                for (uint i = 0u; i < OWN; i++)
                    if (!fine_rest_holds(v, positions[i], slacks[i])) masks[i] &= ~bit;
        }
    }
    for (uint i = 0u; i < OWN; i++)
        if (slacks[i] < 0.0) masks[i] = 0u;
}

// ---- the walk ----

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

// Whether the walk keeps the masks of what it tests where these are few enough lights, and of how many words it has kept them.
bool makes_masks = false;
uint tested_words = 0u;

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

uint touched_row = 0u;

// Of what is held from `first` to `end`, leaves the lights whose box on the screen touches the tile's, or whose volume reaches the tile's
// positions. Returns the new end. Barriers are before it and behind.
uint leave(uint first, uint end, bool by_boxes, vec4 rect, vec2 depths) {
    uint count = first;
    for (uint base = first; base < end; base += THREADS) {
        uint id = 0u, next = touched_row == 2u * ROW ? 0u : touched_row + ROW;
        bool hit = false;
        // Once or not at all: a loop costs threads that have nothing to do nothing, also where branches are masks.
        for (uint i = base + thread; i < min(base + THREADS, end); i += THREADS) {
            id = held[i];
            hit = by_boxes ? fine_touches(push.boxes.at[id], flags, rect, depths)
                           : reaches_tile(VOLUMES.at[id]);
        }
        if (thread < ROW) touched[next + thread] = 0u; // was read two barriers ago
        if (hit) atomicOr(touched[touched_row + thread / 32u], 1u << (thread & 31u));
        barrier();
        uint at = count + uint(bitCount(touched[touched_row + thread / 32u] & ((1u << (thread & 31u)) - 1u)));
        for (uint w = 0u; w < ROW; w++) {
            uint bits = uint(bitCount(touched[touched_row + w]));
            if (w < thread / 32u) at += bits;
            count += bits;
        }
        if (hit) held[at] = id; // nobody reads that again
        touched_row = next;
    }
    barrier();
    return count;
}

// The masks of a word of what is tested.
void keep_masks(uint word) {
    uint to = fine_found_masks(fine_found_of(cell)) + word * fine_squares(), step = joined_pixels();
    for (uint i = 0u; i < OWN; i++) {
        if (i % step != 0u) continue;
        uint square = join_masks(i);
        if (square < fine_squares()) push.found.at[to + square] = masks[i];
    }
}

// Gives what is kept, places among the lights in view, to `out_ids` from `out_first` on, as far as it goes below `out_end`; returns how many are kept. `whole`: the tile has
// nothing before and behind. Barriers are before it and behind.
uint flush(uint count, bool whole, uint_array out_ids, uint out_first, uint out_end) {
    bool tests = (flags & FINE_PIXELS) != 0u;
    if (tests && !is_blended()) count = leave(0u, count, false, vec4(0.0), vec2(0.0));
    if (count == 0u) return 0u; // the whole group
    uint words = (count + 31u) / 32u;
    bool keeps = makes_masks && whole && words <= KEPT_WORDS;
    if (keeps) tested_words = words;
    for (uint w = thread; w < words; w += THREADS) {
        uint in_word = min(count - w * 32u, 32u);
        kept_bits[w] = tests ? 0u : 0xffffffffu >> (32u - in_word);
    }
    barrier();
    for (uint w = 0u; tests && w < words; w++) {
        uint bits = 0u, end = min(32u, count - w * 32u);
        test_word(false, w * 32u, end);
        for (uint i = 0u; i < OWN; i++) bits |= masks[i];
        if (bits != 0u) atomicOr(kept_bits[w], bits);
        if (keeps) keep_masks(w);
        barrier();
    }
    for (uint i = thread; i < count; i += THREADS) {
        if ((kept_bits[i / 32u] >> (i & 31u) & 1u) == 0u) continue;
        uint at = out_first + kept_before(i);
        if (at < out_end) out_ids.at[at] = held[i];
    }
    if (keeps && thread < words) push.found.at[fine_found_bits(fine_found_of(cell)) + thread] = kept_bits[thread];
    uint kept = kept_in(words);
    barrier();
    return kept;
}

// Puts the marked lights of the words from `next` on behind what is held, as far as there is room, and moves `next` on. Returns how many are
// held then. `run_sums` are 0. Barriers are before it and behind.
uint take_marked(uint marks, inout uint next, uint words, uint count) {
    uint first = min(next + thread * RUN, words), end = min(first + RUN, words), own = 0u;
    for (uint w = first; w < end; w++) own += uint(bitCount(push.marks.at[marks + w]));
    thread_sums[thread] = own;
    if (own != 0u) atomicAdd(run_sums[thread / RUN_THREADS], own);
    barrier();
    uint at = count, run = thread / RUN_THREADS;
    for (uint r = 0u; r < run; r++) at += run_sums[r];
    for (uint i = run * RUN_THREADS; i < thread; i++) at += thread_sums[i];
    bool fits = at + own <= ROOM;
    if (fits ? thread == THREADS - 1u : at <= ROOM) { // the last, or the first that does not fit
        taken_end = fits ? at + own : at;
        taken_threads = fits ? THREADS : thread;
    }
    if (fits)
        for (uint w = first; w < end; w++)
            for (uint rest = push.marks.at[marks + w]; rest != 0u; rest &= rest - 1u) held[at++] = w * 32u + uint(findLSB(rest));
    barrier();
    if (thread < RUNS) run_sums[thread] = 0u;
    next += taken_threads * RUN;
    return taken_end;
}

uint walk(uint_array out_ids, uint out_first, uint out_end) {
    uint marks = fine_marks_of(gl_WorkGroupID.z, gl_WorkGroupID.xy);
    uint words = (push.visible_sums.at[push.list.list.local_count] + 31u) / 32u;
    uint kept = 0u, count = 0u, next = 0u;
    vec2 depths = vec2(0.0, FINE_FAR);
    if ((flags & (FINE_MIN_DEPTH | FINE_MAX_DEPTH)) != 0u)
        depths = fine_depths(flags, fine_range_of(flags, gl_WorkGroupID.xy));
    if (depths.x > depths.y) return 0u; // the whole group
    if ((flags & FINE_PIXELS) != 0u && !is_blended()) bound_tile();
    vec4 rect = vec4(gl_WorkGroupID.xy * TILE_SIZE, min((gl_WorkGroupID.xy + 1u) * TILE_SIZE, push.view.view.size));
    if (thread < ROW) touched[thread] = 0u;
    if (thread < RUNS) run_sums[thread] = 0u;
    barrier();
    for (bool flushed = false; next < words;) {
        uint first = count;
        count = take_marked(marks, next, words, count);
        count = leave(first, count, true, rect, depths);
        bool last = next >= words;
        if (count == 0u || !last && count <= HELD) continue;
        kept += flush(count, last && !flushed, out_ids, out_first + kept, out_end);
        count = 0u;
        flushed = true;
    }
    return kept;
}

void begin_tile() {
    thread = gl_LocalInvocationIndex;
    flags = fine_flags(gl_WorkGroupID.z);
    cell = gl_WorkGroupID.z * fine_tile_count() + gl_WorkGroupID.y * push.list.list.tiles_x + gl_WorkGroupID.x;
}

#endif
