#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Which nodes are below which, from sorted keys: node i begins or ends at leaf i, and ends where keys differ most (Karras 2012, "Maximizing
// Parallelism in the Construction of BVHs, Octrees, and k-d Trees"). Equal keys are told apart by their places.
#include "common.glsl"
#include "passes/shadow/rays_build.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_ray_links_push push; };

// Leading bits that the keys of leaves i and j have in common; j may lie outside.
int common_bits(uint i, int j) {
    if (j < 0 || j >= int(push.count)) return -1;
    uint differ = push.pairs.at[i * 2u] ^ push.pairs.at[uint(j) * 2u];
    return differ != 0u ? 31 - findMSB(differ) : 63 - findMSB(i ^ uint(j));
}

uint group_of(uint leaf) { return push.shift < 32u ? push.pairs.at[leaf * 2u] >> push.shift : 0u; }

// The root of a group is the node, or leaf, that holds all its leaves and no others.
void find_root(uint low, uint high, uint reference) {
    if (push.has_roots == 0u) return;
    uint group = group_of(low);
    if (group_of(high) != group || (low > 0u && group_of(low - 1u) == group)) return;
    if (high + 1u < push.count && group_of(high + 1u) == group) return;
    push.roots.at[group] = reference;
}

void main() {
    uint i = LINEAR_INVOCATION;
    if (i >= push.count) return;
    push.ids.at[i] = push.pairs.at[i * 2u + 1u];
    find_root(i, i, i | RAY_LEAF);
    if (i == 0u) {
        push.next.at[push.count - 1u] = RAY_END;
        push.parents.at[push.count > 1u ? 0u : push.count] = RAY_END;
    }
    if (i + 1u >= push.count) return;

    int at = int(i), way = common_bits(i, at + 1) > common_bits(i, at - 1) ? 1 : -1;
    int least = common_bits(i, at - way), length = 2;
    while (common_bits(i, at + length * way) > least) length *= 2;
    int reach = 0;
    for (int step = length / 2; step > 0; step /= 2)
        if (common_bits(i, at + (reach + step) * way) > least) reach += step;
    int end = at + reach * way, shared_bits = common_bits(i, end), split = 0;
    for (int step = (reach + 1) / 2;; step = (step + 1) / 2) {
        if (common_bits(i, at + (split + step) * way) > shared_bits) split += step;
        if (step <= 1) break;
    }
    uint low = uint(min(at, end)), high = uint(max(at, end)), left = uint(at + split * way + min(way, 0)), right = left + 1u;
    uint first = left == low ? left | RAY_LEAF : left, second = right == high ? right | RAY_LEAF : right;
    push.nodes.at[i].first = first;
    push.nodes.at[i].last = high;
    push.next.at[left] = second;
    push.parents.at[left == low ? push.count + left : left] = i;
    push.parents.at[right == high ? push.count + right : right] = i;
    find_root(low, high, i);
}
