// SPDX-License-Identifier: MIT
// One group walks through the lights of one tile for one list. Lights come in ascending order: a batch of marks is compacted by prefix
// sums over the threads, so nothing depends on the order in which threads run. No number of lights is too many: the marks are taken in
// batches, and what a batch keeps is flushed before the next might not fit.
#ifndef FINE_TILE_GLSL
#define FINE_TILE_GLSL

#include "passes/lights/fine_pixels.glsl"

layout(constant_id = 2) const uint TILE_SIZE = 16u; // pixels

layout(local_size_x = 8, local_size_y = 8) in; // each thread owns a square of the tile

const uint THREADS = 64u, SIDE = TILE_SIZE / 8u, OWN = SIDE * SIDE;
const uint FEW = OWN < 4u ? OWN : 4u; // pixels at a time
const uint HELD = 1024u, ROOM = 3072u; // a batch adds at most 2048

shared uint held[ROOM]; // lights in view that touch the tile's box
shared uint kept_bits[ROOM / 32u];
shared uint sums[THREADS], parts[8];

uint thread, flags, cell;
vec3 positions[OWN];
float slacks[OWN]; // how far off a position may be; negative: there is no surface
vec4 segments[OWN]; // of blended surfaces: from the position in this direction so far

// The sum of all threads before this one, and of all. Ends with a barrier behind it.
uint sum_before(uint value, out uint total) {
    sums[thread] = value;
    barrier();
    if (thread < 8u) {
        uint part = 0u;
        for (uint i = 0u; i < 8u; i++) part += sums[thread * 8u + i];
        parts[thread] = part;
    }
    barrier();
    uint sum = 0u;
    total = 0u;
    for (uint i = 0u; i < 8u; i++) {
        sum += i < thread / 8u ? parts[i] : 0u;
        total += parts[i];
    }
    for (uint i = thread & ~7u; i < thread; i++) sum += sums[i];
    barrier();
    return sum;
}

void take_positions() {
    uvec2 first = gl_WorkGroupID.xy * TILE_SIZE + gl_LocalInvocationID.xy * SIDE;
    for (uint i = 0u; i < OWN; i++) {
        uvec2 pixel = first + uvec2(i % SIDE, i / SIDE);
        positions[i] = vec3(0.0);
        slacks[i] = -1.0;
        if (any(greaterThanEqual(pixel, push.view.view.size))) continue;
        float view_depth;
        if ((flags & FINE_BLENDED) != 0u) {
            float front, behind;
            if (!fine_blended(pixel, front, behind)) continue;
            view_depth = view_depth_of(push.view, front);
            bool open = behind <= 0.0 && push.view.view.orthographic < 0.5; // up to the sky
            vec3 a = fine_position(pixel, view_depth), b = fine_position(pixel, open ? view_depth * 2.0 : view_depth_of(push.view, behind));
            float length_ab = distance(a, b);
            positions[i] = a;
            segments[i] = vec4(length_ab > 0.0 ? (b - a) / length_ab : vec3(0.0), open ? FINE_FAR : length_ab);
            // Positions are interpolated, and nobody compares them.
            slacks[i] = 4.0 * max(fine_slack(push.list, a), fine_slack(push.list, b));
            continue;
        }
        bool sky;
        if (!fine_pixel_depth(pixel, view_depth, sky)) continue;
        positions[i] = fine_position(pixel, view_depth);
        slacks[i] = fine_slack(push.list, positions[i]);
    }
}

// ---- whether a shape holds a point ----

// Of a light it is the support of light_strength() (shaders/lights/illuminate.glsl), widened by `slack` metres and by what rounding may do.
struct fine_volume {
    uint kind, hull_count, hull_first;
    vec3 position, direction, side, size, center;
    float range, spot_scale, spot_offset, radius;
};

// `place` is one of the bounds.
fine_volume fine_volume_of(uint place) {
    fine_volume v;
    uint offset = push.list.list.entities.at[place].shape;
    v.center = vec3(0.0);
    v.radius = 0.0;
    if (offset == GPU_NO_SHAPE || (flags & FINE_BLENDED) != 0u) {
        v.center = push.list.list.entities.at[place].center;
        v.radius = push.list.list.entities.at[place].radius;
    }
    v.position = v.center;
    v.range = v.radius;
    v.kind = GPU_SHAPE_SPHERE;
    v.hull_count = v.hull_first = 0u;
    v.direction = v.side = v.size = vec3(0.0);
    v.spot_scale = v.spot_offset = 0.0;
    if (offset == GPU_NO_SHAPE) return v;
    shape_block s = shape_at(push.list, offset);
    v.position = s.shape.position;
    v.range = s.shape.range;
    v.kind = s.shape.kind;
    v.hull_count = s.shape.hull_count;
    if (v.kind != GPU_SHAPE_SPHERE) v.direction = s.shape.direction;
    if (v.kind == GPU_SHAPE_CONE) {
        v.spot_scale = s.shape.spot_scale;
        v.spot_offset = s.shape.spot_offset;
    } else if (v.kind != GPU_SHAPE_SPHERE) {
        v.side = s.shape.side;
        v.size = s.shape.size;
    }
    if (v.hull_count != 0u) v.hull_first = s.shape.hull_first;
    return v;
}

shared fine_volume staged[32]; // lights that all threads test: fetched once, not by each of them

// All but the planes of the hull.
bool fine_shape_holds(fine_volume v, vec3 position, float slack) {
    vec3 from = position - v.position;
    float distance2 = dot(from, from), range = v.range + slack;
    if (distance2 > range * range) return false;
    slack += 2e-6 * v.range;
    if (v.kind == GPU_SHAPE_CONE) {
        // A step of s at the distance d > s turns the ray by asin(s / d) at most, which is below 1.6 s / d; others may reach the apex.
        float d = sqrt(distance2), along = dot(v.direction, from) + 1.6 * slack + 2e-6 * d;
        if (d > slack && along * v.spot_scale + v.spot_offset * d < 0.0) return false;
    } else if (v.kind == GPU_SHAPE_CAPSULE) {
        vec3 nearest = from - v.direction * clamp(dot(from, v.direction), -v.size.x, v.size.x);
        float radius = v.size.y + slack;
        if (dot(nearest, nearest) > radius * radius) return false;
    } else if (v.kind >= GPU_SHAPE_WEDGE) {
        vec3 at = vec3(dot(from, v.side), dot(from, cross(v.side, v.direction)), dot(from, v.direction));
        vec3 limit = v.kind == GPU_SHAPE_WEDGE ? vec3(v.size.xy * (at.z + slack), v.range) : v.size;
        if (v.kind == GPU_SHAPE_WEDGE && at.z < -slack) return false;
        if (any(greaterThan(abs(at), limit * (1.0 + 2e-6) + slack))) return false;
    }
    return true;
}

bool fine_holds(fine_volume v, vec3 position, float slack) {
    if (!fine_shape_holds(v, position, slack)) return false;
    vec3 from = position - v.position;
    slack += 2e-6 * v.range;
    for (uint i = 0u; i < v.hull_count; i++) {
        vec4 plane = push.list.list.planes.at[v.hull_first + i];
        if (dot(plane.xyz, from) > plane.w + slack) return false;
    }
    return true;
}

// Whether the light may reach surfaces of a pixel. A segment is held when its middle is, by a volume that is wider by half of it; and its
// nearest point to the centre of the light's sphere is in that.
bool holds_own(fine_volume v, uint i) {
    if (slacks[i] < 0.0) return false;
    if ((flags & FINE_BLENDED) == 0u) return fine_holds(v, positions[i], slacks[i]);
    vec4 s = segments[i];
    vec3 to_center = v.center - positions[i], off = to_center - s.xyz * clamp(dot(to_center, s.xyz), 0.0, s.w);
    float radius = v.radius * (1.0 + CELL_SLACK) + slacks[i];
    if (dot(off, off) > radius * radius) return false;
    return s.w > 1e6 || fine_holds(v, positions[i] + s.xyz * (0.5 * s.w), slacks[i] + 0.5 * s.w);
}

// Which of the thread's pixels from `first` on, FEW of them, may be reached. Without loops within the loop over the pixels it unrolls, and
// positions stay in registers.
uint holds_few(fine_volume v, uint first) {
    uint bits = 0u;
    if ((flags & FINE_BLENDED) != 0u) {
        for (uint k = 0u; k < FEW; k++)
            if (holds_own(v, first + k)) bits |= 1u << k;
        return bits;
    }
    for (uint k = 0u; k < FEW; k++)
        if (slacks[first + k] >= 0.0 && fine_shape_holds(v, positions[first + k], slacks[first + k])) bits |= 1u << k;
    if (bits == 0u) return bits;
    for (uint i = 0u; i < v.hull_count; i++) {
        vec4 plane = push.list.list.planes.at[v.hull_first + i];
        for (uint k = 0u; k < FEW; k++) {
            float limit = plane.w + (slacks[first + k] + 2e-6 * v.range);
            if (dot(plane.xyz, positions[first + k] - v.position) > limit) bits &= ~(1u << k);
        }
    }
    return bits;
}

// ---- the walk ----

// Masks of the thread's pixels over what the tile keeps; the count makes them on the way where it tests no more than 32 lights.
bool makes_masks = false, has_masks = false;
uint masks[OWN];

void add_to_masks(uint b) { // a staged light, as bit b
    for (uint i = 0u; i < OWN; i += FEW) {
        uint bits = holds_few(staged[b], i);
        for (uint k = 0u; k < FEW; k++) masks[i + k] |= (bits >> k & 1u) << b;
    }
}

uint local_light(uint index) { return push.visible_ids.at[index]; }

// Fetches what is kept from `first` on, 32 lights at most. All threads call it; before they
// call it again they pass a barrier.
void stage_held(uint first, uint count) {
    if (thread < count) staged[thread] = fine_volume_of(local_light(held[first + thread]));
    barrier();
}

// A sphere round the tile's positions, which puts aside most lights that hold none of them at the price of one pixel's test.
shared vec3 lows[THREADS], highs[THREADS];
vec3 tile_center;
float tile_radius;

void bound_tile() {
    vec3 low = vec3(FINE_FAR), high = vec3(-FINE_FAR);
    for (uint i = 0u; i < OWN; i++) {
        if (slacks[i] < 0.0) continue;
        low = min(low, positions[i] - slacks[i]);
        high = max(high, positions[i] + slacks[i]);
    }
    lows[thread] = low;
    highs[thread] = high;
    barrier();
    if (thread < 8u)
        for (uint i = thread + 8u; i < THREADS; i += 8u) {
            lows[thread] = min(lows[thread], lows[i]);
            highs[thread] = max(highs[thread], highs[i]);
        }
    barrier();
    for (uint i = 0u; i < 8u; i++) {
        low = min(low, lows[i]);
        high = max(high, highs[i]);
    }
    tile_center = 0.5 * (low + high);
    tile_radius = 0.5 * length(high - low) * 1.00001 + 1e-6 * length(tile_center);
}

// Leaves of what is held the lights whose volumes, widened by the tile's sphere, hold its centre.
uint hold_tile(uint count) {
    uint left = 0u;
    for (uint base = 0u; base < count; base += THREADS) {
        uint i = base + thread, id = i < count ? held[i] : 0u, total;
        bool hit = i < count && fine_holds(fine_volume_of(local_light(id)), tile_center, tile_radius);
        uint at = left + sum_before(hit ? 1u : 0u, total);
        if (hit) held[at] = id;
        left += total;
    }
    barrier();
    return left;
}

// Gives what is kept to `out_ids` from `out_first` on, as far as it goes below `out_end`; returns how many are kept. `whole`: the tile has
// nothing before and behind.
uint flush(uint count, bool whole, uint_array out_ids, uint out_first, uint out_end) {
    if ((flags & FINE_PIXELS) != 0u && (flags & FINE_BLENDED) == 0u) count = hold_tile(count);
    if (count == 0u) return 0u; // the whole group
    uint words = (count + 31u) / 32u;
    for (uint w = thread; w < words; w += THREADS) kept_bits[w] = (flags & FINE_PIXELS) != 0u ? 0u : 0xffffffffu;
    barrier();
    has_masks = makes_masks && whole && count <= 32u;
    if (has_masks) {
        uint bits = 0u;
        for (uint i = 0u; i < OWN; i++) masks[i] = 0u;
        stage_held(0u, count);
        for (uint b = 0u; b < count; b++) add_to_masks(b);
        for (uint i = 0u; i < OWN; i++) bits |= masks[i];
        if (bits != 0u) atomicOr(kept_bits[0], bits);
        barrier();
        uint kept = kept_bits[0]; // their bits close up
        for (uint i = 0u; i < OWN; i++) {
            uint mask = 0u, at = 0u;
            for (bits = kept; bits != 0u; bits &= bits - 1u, at++) mask |= (masks[i] >> uint(findLSB(bits)) & 1u) << at;
            masks[i] = mask;
        }
    } else if ((flags & FINE_PIXELS) != 0u) {
        for (uint w = 0u; w < words; w++) {
            uint bits = 0u, end = min(32u, count - w * 32u);
            stage_held(w * 32u, end);
            for (uint b = 0u; b < end; b++) {
                uint any_held = 0u;
                for (uint i = 0u; i < OWN; i += FEW) any_held |= holds_few(staged[b], i);
                if (any_held != 0u) bits |= 1u << b;
            }
            if (bits != 0u) atomicOr(kept_bits[w], bits);
            barrier();
        }
        barrier();
    }
    uint kept = 0u;
    for (uint base = 0u; base < words; base += THREADS) { // 96 words at most: twice
        uint w = base + thread, bits = w < words ? kept_bits[w] : 0u, total;
        if (w < words && count - w * 32u < 32u) bits &= (1u << (count - w * 32u)) - 1u;
        uint at = out_first + kept + sum_before(uint(bitCount(bits)), total);
        for (; bits != 0u; bits &= bits - 1u, at++)
            if (at < out_end) {
                uint index = held[w * 32u + uint(findLSB(bits))];
                out_ids.at[at] = push.list.list.packed == 1u ? index : local_light(index);
            }
        kept += total;
    }
    barrier();
    return kept;
}

uint walk(uint_array out_ids, uint out_first, uint out_end) {
    uint marks = fine_marks_of(gl_WorkGroupID.z, gl_WorkGroupID.xy);
    uint words = (push.visible_sums.at[push.list.list.local_count] + 31u) / 32u;
    uint kept = 0u, count = 0u;
    bool flushed = false;
    vec2 depths = vec2(0.0, FINE_FAR);
    if ((flags & (FINE_MIN_DEPTH | FINE_MAX_DEPTH)) != 0u)
        depths = fine_depths(flags, fine_range_of(flags, gl_WorkGroupID.xy));
    if (depths.x > depths.y) return 0u; // the whole group
    if ((flags & FINE_PIXELS) != 0u && (flags & FINE_BLENDED) == 0u) bound_tile();
    vec4 rect = vec4(gl_WorkGroupID.xy * TILE_SIZE, min((gl_WorkGroupID.xy + 1u) * TILE_SIZE, push.view.view.size));
    for (uint base = 0u; base < words; base += THREADS) {
        uint w = base + thread, hits = 0u, total;
        for (uint bits = w < words ? push.marks.at[marks + w] : 0u; bits != 0u; bits &= bits - 1u) {
            uint bit = uint(findLSB(bits));
            if (fine_touches(push.boxes.at[w * 32u + bit], flags, rect, depths)) hits |= 1u << bit;
        }
        uint at = count + sum_before(uint(bitCount(hits)), total);
        for (; hits != 0u; hits &= hits - 1u) held[at++] = w * 32u + uint(findLSB(hits));
        count += total;
        barrier();
        if (count > HELD) {
            kept += flush(count, false, out_ids, out_first + kept, out_end);
            count = 0u;
            flushed = true;
        }
    }
    if (count > 0u) kept += flush(count, !flushed, out_ids, out_first + kept, out_end);
    return kept;
}

// Word `w` of `words` of the thread's pixels or squares of them, which divide what it owns.
void store_masks(uint_array to, uint first, uint words, uint w) {
    uint size = push.list.list.mask_size, row = TILE_SIZE / size;
    uvec2 corner = gl_LocalInvocationID.xy * SIDE;
    for (uint y = 0u; y < SIDE; y += size)
        for (uint x = 0u; x < SIDE; x += size) {
            uint i = y * SIDE + x, mask = masks[i];
            if (size == 2u) mask |= masks[i + 1u] | masks[i + SIDE] | masks[i + SIDE + 1u];
            to.at[first + ((corner.y + y) / size * row + (corner.x + x) / size) * words + w] = mask;
        }
}

void begin_tile() {
    thread = gl_LocalInvocationIndex;
    flags = fine_flags(gl_WorkGroupID.z);
    cell = gl_WorkGroupID.z * fine_tile_count() + gl_WorkGroupID.y * push.list.list.tiles_x + gl_WorkGroupID.x;
}

#endif
