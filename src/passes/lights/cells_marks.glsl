// SPDX-License-Identifier: MIT
// Marks: which lights in view touch each block of cells, so that a cell only looks at those. Included after the push constants.
#ifndef CELLS_MARKS_GLSL
#define CELLS_MARKS_GLSL

layout(constant_id = CELLS_BLOCK_ID) const uint BLOCK = 0u;

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer block_array { gpu_cell_block at[]; };

// What is `extra` in gpu_cells_push where blocks are measured and marked.
#define BLOCKS block_array(push.extra)

uvec3 cells_block_size() { return uvec3(BLOCK, BLOCK, CELLS_BLOCK_SLICES); }
uvec3 cells_grid() { return uvec3(push.list.list.tiles_x, push.list.list.tiles_y, push.list.list.slices); }
uvec3 cells_blocks() { return (cells_grid() + cells_block_size() - 1u) / cells_block_size(); }
uint cells_mark_words() { return (push.list.list.local_count + 31u) / 32u; } // of a block

// Where the marks of a cell's block begin.
uint cells_marks_of(uint cell) {
    if (BLOCK == 0u) return 0u;
    uvec3 grid = cells_grid(), blocks = cells_blocks();
    uvec3 block = uvec3(cell % grid.x, cell / grid.x % grid.y, cell / (grid.x * grid.y)) / cells_block_size();
    return ((block.z * blocks.y + block.y) * blocks.x + block.x) * cells_mark_words();
}

// The lights of 32 in view that the cell has to look at; those from `end` on are left out. Chunks begin with whole words.
uint cells_marked(uint marks, uint word, uint end) {
    return (BLOCK == 0u ? 0xffffffffu : push.marks.at[marks + word]) & 0xffffffffu >> 32u - min(end - word * 32u, 32u);
}

// What the count keeps for the fill: of 32 lights in view, those that each cell takes; then of the next 32.
uint cells_kept_at(uint cell, uint word) { return word * push.cell_count + cell; }

// for (uint w = …; w < cells_end_word(end); w++) for (uint bits = cells_marked(marks, w, end); bits != 0u; bits &= bits - 1u) …
uint cells_end_word(uint end) { return (end + 31u) / 32u; }

#endif
