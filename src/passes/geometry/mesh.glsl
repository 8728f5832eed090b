// SPDX-License-Identifier: MIT
// What mesh shaders do: a cluster of triangles in each work group, of its triangles those that culling has left, of its vertices those that they
// have. Triangles keep their order and their numbers. `push` is gpu_geometry_push; write_vertex() writes a vertex of an item to a place.
#ifndef MESH_GLSL
#define MESH_GLSL

#include "passes/geometry/mesh_shared.h"

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer mesh_draw_block { gpu_mesh_draw draw; };

layout(local_size_x = CLUSTERS_GROUP) in;
layout(triangles, max_vertices = CLUSTERS_MOST_VERTICES, max_primitives = CLUSTERS_MOST_TRIANGLES) out;

// Of the built-in ones these alone: others ask for features of the device.
out gl_MeshPerVertexEXT { vec4 gl_Position; }
gl_MeshVerticesEXT[];
perprimitiveEXT out gl_MeshPerPrimitiveEXT { int gl_PrimitiveID; }
gl_MeshPrimitivesEXT[];

shared uint used[2]; // a bit for each vertex that a triangle has

// The cluster of a work group, and which of its triangles are drawn.
gpu_cluster find_cluster(mesh_draw_block block, uint group, out uint item_index, out uint kept[CLUSTERS_MASK_WORDS]) {
    uint number;
    bool masked = false;
    uint slot = 0u;
    if (group < block.draw.listed) {
        slot = block.draw.list.at[group];
        item_index = block.draw.slots.at[slot];
        number = slot;
        masked = block.draw.by_triangle != 0u;
    } else {
        number = block.draw.first_whole + group - block.draw.listed;
        uint low = 0u, high = block.draw.item_count;
        while (high - low > 1u) {
            uint middle = (low + high) / 2u;
            if (block.draw.cluster_sums.at[middle] <= number) low = middle;
            else high = middle;
        }
        item_index = low;
    }
    gpu_primitive primitive = push.scene.scene.primitives.at[push.scene.scene.items.at[item_index].primitive];
    gpu_cluster cluster = push.scene.scene.clusters.at[primitive.first_cluster + number - block.draw.cluster_sums.at[item_index]];
    for (uint k = 0u; k < CLUSTERS_MASK_WORDS; k++) {
        uint count = clamp(int(cluster.triangle_count) - int(k * 32u), 0, 32);
        uint all = count == 32u ? 0xffffffffu : (1u << count) - 1u;
        kept[k] = masked ? block.draw.masks.at[slot * CLUSTERS_MASK_WORDS + k] : all;
    }
    return cluster;
}

uint rank_of_vertex(uint v) {
    uint before = bitCount(used[v >> 5] & ((1u << (v & 31u)) - 1u));
    return v < 32u ? before : before + bitCount(used[0]);
}

void main() {
    uint thread = gl_LocalInvocationIndex;
    mesh_draw_block block = mesh_draw_block(push.visible);
    uint group = LINEAR_GROUP;
    if (group >= block.draw.count) { // the whole group
        SetMeshOutputsEXT(0u, 0u);
        return;
    }
    uint item_index, kept[CLUSTERS_MASK_WORDS];
    gpu_cluster cluster = find_cluster(block, block.draw.first + group, item_index, kept);
    const_uint_array words = push.scene.scene.cluster_words;
    uint first_triangle = cluster.first_word + cluster.vertex_count;
    if (thread < 2u) used[thread] = 0u;
    barrier();
    for (uint i = thread; i < cluster.triangle_count; i += CLUSTERS_GROUP) {
        if ((kept[i >> 5] & (1u << (i & 31u))) == 0u) continue;
        uint corners = words.at[first_triangle + i];
        for (uint k = 0u; k < 3u; k++) {
            uint v = corners >> 8u * k & 255u;
            atomicOr(used[v >> 5], 1u << (v & 31u));
        }
    }
    barrier();
    uint triangles = bitCount(kept[0]) + bitCount(kept[1]) + bitCount(kept[2]) + bitCount(kept[3]);
    SetMeshOutputsEXT(bitCount(used[0]) + bitCount(used[1]), triangles);
    if (thread < cluster.vertex_count && (used[thread >> 5] & (1u << (thread & 31u))) != 0u) {
        gpu_primitive primitive = push.scene.scene.primitives.at[push.scene.scene.items.at[item_index].primitive];
        uint vertex = words.at[cluster.first_word + thread] + uint(primitive.vertex_offset), place = rank_of_vertex(thread);
        write_vertex(place, item_index, vertex);
    }
    for (uint i = thread; i < cluster.triangle_count; i += CLUSTERS_GROUP) {
        uint word = kept[i >> 5], bit = 1u << (i & 31u);
        if ((word & bit) == 0u) continue;
        uint place = bitCount(word & (bit - 1u)), corners = words.at[first_triangle + i];
        for (uint k = 0u; k < i >> 5; k++) place += bitCount(kept[k]);
        gl_PrimitiveTriangleIndicesEXT[place] =
            uvec3(rank_of_vertex(corners & 255u), rank_of_vertex(corners >> 8 & 255u), rank_of_vertex(corners >> 16));
        gl_MeshPrimitivesEXT[place].gl_PrimitiveID = int(cluster.first_triangle + i);
    }
}

#endif
