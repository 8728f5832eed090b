#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Writes the lights of each tile, ascending, and the masks that say which pixels they hold. A tile that the pool
// cannot hold is marked to use all lights instead.
#include "common.glsl"
#include "passes/lights/fine_steps.glsl"
#include "passes/lights/fine_tile.glsl"

// Each thread makes the words of its own pixels, or the one of all of them.
void write_masks(uint first, uint count) {
    uint size = push.list.list.mask_size, words = (count + 31u) / 32u;
    uvec2 corner = gl_LocalInvocationID.xy * SIDE;
    for (uint w = 0u; w < words; w++) {
        uint masks[OWN];
        for (uint i = 0u; i < OWN; i++) masks[i] = 0u;
        uint end = min(32u, count - w * 32u);
        for (uint b = 0u; b < end; b++) {
            fine_volume v = fine_volume_of(push.list.list.directional_count + push.ids.at[first + w * 32u + b]);
            for (uint i = 0u; i < OWN; i++)
                if (holds_own(v, i)) masks[i] |= 1u << b;
        }
        if (size == 1u) {
            for (uint i = 0u; i < OWN; i++)
                push.extra.at[fine_mask_of(push.list, cell, first, corner + uvec2(i % SIDE, i / SIDE), words) + w] = masks[i];
            continue;
        }
        for (uint y = 0u; y + 1u < SIDE; y += 2u) // squares of 2 x 2, which divide what a thread owns
            for (uint x = 0u; x + 1u < SIDE; x += 2u) {
                uint i = y * SIDE + x;
                push.extra.at[fine_mask_of(push.list, cell, first, corner + uvec2(x, y), words) + w] =
                    masks[i] | masks[i + 1u] | masks[i + SIDE] | masks[i + SIDE + 1u];
            }
    }
}

void main() {
    begin_tile();
    uint first = push.sums.at[cell], last = push.sums.at[cell + 1u], count = last - first;
    bool fits = last <= push.capacity;
    if (thread == 0u) {
        push.list.list.cells.at[cell] = gpu_cell(first, fits ? count : GPU_CELL_ALL);
        if (!fits) atomicAdd(push.overflow.at[0], 1u);
    }
    if (!fits || count == 0u) return;
    bool masks = (flags & FINE_PIXELS) != 0u && push.list.list.mask_size != 0u;
    if (masks || ((flags & FINE_PIXELS) != 0u && count > FINE_FOUND)) take_positions();
    if (count <= FINE_FOUND) {
        for (uint i = thread; i < count; i += THREADS) push.ids.at[first + i] = push.found.at[cell * FINE_FOUND + i];
    } else {
        walk(push.ids, first, last);
    }
    if (!masks) return;
    memoryBarrierBuffer();
    barrier();
    write_masks(first, count);
}
