// SPDX-License-Identifier: MIT
// GPU_LIST_TREE: tiles with bounding-interval hierarchies over view depth (Y. O'Donnell, M. G. Chajdas, "Tiled Light Trees", I3D 2017).
//
// A tile's lights ascend by index in ids. Each GPU_TREE_LIGHTS of them have a tree of their own, sorted by depth, without a stack: its
// nodes stand in preorder and an inner one says where its subtree ends. What the walk finds is marked in 128 bits, one per light, and the
// bits are visited from the lowest: so lights come in ascending order, as from all lists.
#ifndef LIGHTS_TREE_GLSL
#define LIGHTS_TREE_GLSL

#include "lights/ranges.glsl"

struct tree_cursor {
    uint first, next, end; // into ids: of the present tree, of the next one, of the tile's last
    uint depth;            // code of the point's view depth
    uvec4 found;
};

tree_cursor tree_begin(gpu_cell cell, float view_depth) {
    return tree_cursor(cell.offset, cell.offset, cell.offset + cell.count, depth_code(view_depth), uvec4(0u));
}

// Node i of the tree of the lights from `first` on is the words 4 first + 2 i of extra: its depth range, and a light's bit or the end of
// its subtree. Node 0 is not one: it says how many there are.
uvec4 tree_find(light_list_block l, uint first, uint depth) {
    uvec4 found = uvec4(0u);
    uint end = l.list.extra.at[4u * first] + 1u;
    for (uint i = 1u; i < end;) {
        bool holds = depth_in_range(depth, l.list.extra.at[4u * first + 2u * i]);
        uint link = l.list.extra.at[4u * first + 2u * i + 1u];
        bool leaf = (link & GPU_TREE_LEAF) != 0u;
        if (leaf && holds) {
            uint bit = 1u << (link & 31u), word = link >> 5 & 3u;
            found |= uvec4(word == 0u ? bit : 0u, word == 1u ? bit : 0u, word == 2u ? bit : 0u, word == 3u ? bit : 0u);
        }
        i = leaf || holds ? i + 1u : link;
    }
    return found;
}

bool tree_next(light_list_block l, inout tree_cursor c, out uint id) {
    id = 0u;
    // No return inside of the loop: with one, Mesa's llvmpipe goes on reading for invocations that have ended.
    while (c.found == uvec4(0u) && c.next < c.end) {
        c.first = c.next;
        c.next = min(c.first + GPU_TREE_LIGHTS, c.end);
        c.found = tree_find(l, c.first, c.depth);
    }
    if (c.found == uvec4(0u)) return false;
    uint word = c.found.x != 0u ? 0u : c.found.y != 0u ? 1u : c.found.z != 0u ? 2u : 3u;
    uint bits = word == 0u ? c.found.x : word == 1u ? c.found.y : word == 2u ? c.found.z : c.found.w;
    id = l.list.ids.at[c.first + word * 32u + uint(findLSB(bits))];
    bits &= bits - 1u;
    if (word == 0u) c.found.x = bits;
    else if (word == 1u) c.found.y = bits;
    else if (word == 2u) c.found.z = bits;
    else c.found.w = bits;
    return true;
}

#endif
