#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Writes the lights of each tile, ascending, and the masks that say which pixels they hold. A tile that the pool
// cannot hold is marked to use all lights instead; a packed one that its words cannot hold, all in view.
#include "common.glsl"
#include "passes/lights/fine_steps.glsl"
#include "passes/lights/fine_tile.glsl"

void make_masks(uint to, uint first, uint count) {
    uint words = (count + 31u) / 32u, step = joined_pixels();
    for (uint w = 0u; w < words; w++) {
        test_word(true, first + w * 32u, min(32u, count - w * 32u));
        for (uint i = 0u; i < OWN; i++) {
            if (i % step != 0u) continue;
            uint square = join_masks(i);
            if (square < fine_squares()) push.extra.at[to + square * words + w] = masks[i];
        }
        barrier();
    }
}

// Copies the masks that the count kept at `from`, without the bits of what the tile does not keep.
void copy_masks(uint to, uint from, uint count, uint tested) {
    uint words = (count + 31u) / 32u;
    for (uint square = thread; square < fine_squares(); square += THREADS) {
        uint at = to + square * words, filled = 0u, word = 0u;
        for (uint w = 0u; w < tested; w++) {
            uint bits = push.found.at[fine_found_bits(from) + w], mask = push.found.at[fine_found_masks(from) + w * fine_squares() + square];
            // What is dropped is 0 in all masks: the bits behind it move up, the last of them first.
            for (uint holes = ~bits & (bits == 0u ? 0u : 0xffffffffu >> (31 - findMSB(bits))); holes != 0u;) {
                uint below = (1u << uint(findMSB(holes))) - 1u;
                holes &= below;
                mask = (mask & below) | (mask >> 1u & ~below);
            }
            uint behind = filled + uint(bitCount(bits));
            word |= mask << filled;
            if (behind >= 32u) {
                push.extra.at[at++] = word;
                word = filled == 0u ? 0u : mask >> (32u - filled);
                behind -= 32u;
            }
            filled = behind;
        }
        if (filled != 0u) push.extra.at[at] = word;
    }
}

// From what the count found: places among the lights in view, ascending.
void pack(uint count) {
    uint_array words = uint_array(push.list.list.cells);
    uint from = fine_found_of(cell), to = cell * GPU_PACKED_WORDS;
    bool fits = count <= GPU_PACKED_LIGHTS && (count == 0u || push.found.at[from + count - 1u] < GPU_PACKED_IN_VIEW);
    if (thread < GPU_PACKED_WORDS) {
        uint first = min(thread * 3u, count), held = min(count - first, 3u), word = held << 3u * GPU_PACKED_BITS;
        if (fits)
            for (uint i = 0u; i < held; i++) word |= push.found.at[from + first + i] << i * GPU_PACKED_BITS;
        else
            word = thread == 0u ? GPU_PACKED_ALL : thread == 1u ? push.visible_sums.at[push.list.list.local_count] : 0u;
        words.at[to + thread] = word;
    }
    if (thread == 0u && !fits) atomicAdd(push.overflow.at[0], 1u);
}

void main() {
    begin_tile();
    uint first = push.sums.at[cell], last = push.sums.at[cell + 1u], count = last - first;
    if (push.list.list.packed == 1u) {
        pack(count);
        return;
    }
    bool fits = last <= push.capacity;
    if (thread == 0u) {
        push.list.list.cells.at[cell] = gpu_cell(first, fits ? count : GPU_CELL_ALL);
        if (!fits) atomicAdd(push.overflow.at[0], 1u);
    }
    if (!fits || count == 0u) return;
    bool has_words = (flags & FINE_PIXELS) != 0u && push.list.list.mask_size != 0u, found = count <= FOUND;
    uint from = fine_found_of(cell), to = fine_masks_of(push.list, cell, first);
    uint tested = has_words ? push.found.at[from + FOUND] : 0u;
    bool copies = tested != 0u;
    if ((flags & FINE_PIXELS) != 0u && !copies) take_positions();
    if (found) {
        for (uint i = thread; i < count; i += THREADS) push.ids.at[first + i] = push.found.at[from + i];
    } else {
        walk(push.ids, first, last);
    }
    if (copies) copy_masks(to, from, count, tested);
    memoryBarrierBuffer();
    barrier();
    if (has_words && !copies) make_masks(to, first, count);
    barrier();
    // From places among the lights in view to lights.
    for (uint i = thread; i < count; i += THREADS) push.ids.at[first + i] = push.visible_ids.at[push.ids.at[first + i]];
}
