// SPDX-License-Identifier: MIT
// The visibility pass: finds or stores the triangle of a fragment and gives out its reference. Entry points say what they write to.
#include "passes/dais/dais.glsl"
#include "passes/visibility/triangle.glsl"

layout(constant_id = DAIS_STORE_SHARED_ID) const uint SHARED_SAMPLES = 0u; // 1: shading samples are handed out
layout(constant_id = DAIS_COLORS_ID) const uint COLORS = 1u;         // 1: some mesh has vertex colours
layout(constant_id = DAIS_ATTEMPTS_ID) const uint LOCK_ATTEMPTS = 1024u;
layout(constant_id = FEATURES_ID) const uint FEATURES = 0u;      // GPU_FEATURE_…

layout(early_fragment_tests) in;
layout(location = 5) flat in uvec3 in_ids; // material, item, 1 when the instance mirrors
layout(push_constant, scalar) uniform push_block { gpu_dais_visibility_push push; };

const uint LOCK_POLLS = 128u;

// The record of a reference is that of this triangle. Headers are complete before a reference can be seen, and never change.
bool is_of(uint reference, uint item, uint number) {
    if (reference == 0u) return false;
    uint base = reference - 1u;
    return push.pool.at[base] == item && push.pool.at[base + 1u] == number;
}

uint find_in_bucket(uint bucket, uint item, uint number) {
    uint newer = push.cache.at[bucket + 1u];
    if (is_of(newer, item, number)) return newer;
    uint older = push.cache.at[bucket + 2u];
    return is_of(older, item, number) ? older : 0u;
}

// What the material needs, a part of the record each; and colours where some vertex is not white.
uint record_bits(gpu_primitive primitive, uint number) {
    gpu_material m = push.geometry.scene.scene.materials.at[primitive.material];
    uint bits = primitive.corners << DAIS_CORNERS;
    for (uint i = 0u; i < GPU_TEXTURE_COUNT; i++)
        if (m.textures[i].image != GPU_TEXTURE_NONE) bits |= (m.textures[i].flags & GPU_TEXTURE_UV1) == 0u ? DAIS_UV0 : DAIS_UV1;
    if (m.textures[2].image != GPU_TEXTURE_NONE) bits |= DAIS_TANGENT;
    if ((m.flags & GPU_MATERIAL_LAYERED) != 0u) bits |= DAIS_UV0 | DAIS_UV1 | DAIS_TANGENT;
    if ((FEATURES & GPU_FEATURE_MESH_DECALS) != 0u) bits |= DAIS_BIND;
    if (COLORS == 0u) return bits;
    for (uint i = 0u; i < 3u; i++) {
        uint vertex = triangle_vertex(primitive, push.indices, number, i);
        if (push.geometry.scene.scene.attributes.at[vertex].color != uvec2(0xffffffffu)) bits |= DAIS_COLOR;
    }
    return bits;
}

uint record_size(uint bits) {
    return DAIS_HEADER + 12u + ((bits & DAIS_UV0) != 0u ? 6u : 0u) + ((bits & DAIS_UV1) != 0u ? 6u : 0u) +
           ((bits & DAIS_TANGENT) != 0u ? 12u : 0u) + ((bits & DAIS_COLOR) != 0u ? 12u : 0u) + ((bits & DAIS_BIND) != 0u ? 9u : 0u);
}

// Takes room for the record and writes its header: the derivative pass does the rest, where no lane waits for another. DAIS_NO_ROOM where
// there is none.
uint allocate(uint item, uint number, uint material, uint bits) {
    uint size = record_size(bits);
    // Without the first look, fragments that find no room would count up for ever.
    if (push.counts.at[DAIS_WORDS] > push.capacity - size) return DAIS_NO_ROOM;
    uint base = atomicAdd(push.counts.at[DAIS_WORDS], size);
    if (base > push.capacity - size) return DAIS_NO_ROOM;
    push.pool.at[base] = item;
    push.pool.at[base + 1u] = number;
    push.pool.at[base + 2u] = material;
    push.pool.at[base + 3u] = bits;
    push.stored.at[atomicAdd(push.counts.at[DAIS_STORED], 1u)] = base + 1u;
    return base + 1u;
}

// The reference of a triangle, stored by whoever asks first. Buckets of two, the older one is forgotten; those that stay locked for long
// are passed over, and the triangle is stored once more.
uint reference_of(uint item, uint number) {
    uint bucket = (item * 0x9e3779b1u + number & push.bucket_mask) * DAIS_BUCKET;
    uint found = find_in_bucket(bucket, item, number);
    if (found == 0u) {
        gpu_primitive primitive = push.geometry.scene.scene.primitives.at[push.geometry.scene.scene.items.at[item].primitive];
        uint bits = record_bits(primitive, number);
        // The branches of winners and losers are apart: run in lock-step, the losers' must not come before the winners' release.
        for (uint attempt = 0u; attempt < LOCK_ATTEMPTS && found == 0u; attempt++) {
            bool won = atomicExchange(push.cache.at[bucket], 1u) == 0u;
            if (won) {
                found = find_in_bucket(bucket, item, number);
                if (found == 0u) {
                    found = allocate(item, number, primitive.material, bits);
                    if (found != DAIS_NO_ROOM) {
                        memoryBarrierBuffer(); // the header before the reference
                        push.cache.at[bucket + 2u] = push.cache.at[bucket + 1u];
                        push.cache.at[bucket + 1u] = found;
                    }
                }
                memoryBarrierBuffer();
                atomicExchange(push.cache.at[bucket], 0u);
            }
            if (!won) {
                for (uint poll = 0u; poll < LOCK_POLLS && push.cache.at[bucket] != 0u; poll++) {
                }
                found = find_in_bucket(bucket, item, number);
            }
        }
        if (found == 0u) {
            atomicAdd(push.counts.at[DAIS_FAILED], 1u);
            found = allocate(item, number, primitive.material, bits | DAIS_REDUNDANT);
        }
    }
    if (found == DAIS_NO_ROOM) atomicAdd(push.counts.at[DAIS_OVERFLOW], 1u);
    return found;
}

// A new shading sample here; 0 where there is no room: the pixel then shades for itself.
uint spawn(uint reference) {
    uint number = atomicAdd(push.counts.at[DAIS_SAMPLES], 1u) + 1u;
    if (number >= push.sample_capacity) return 0u;
    push.samples.at[2u * number] = reference;
    push.samples.at[2u * number + 1u] = uint(gl_FragCoord.x) | uint(gl_FragCoord.y) << 16;
    return number;
}

#ifdef DAIS_QUADS
// One for the square of four pixels, by its first lane; where that is a helper, whose writes count for nothing, each has its own.
uint shading_sample(uint reference) {
    uint number = 0u;
    bool stands = !gl_HelperInvocation && reference != DAIS_NO_ROOM;
    if ((gl_SubgroupInvocationID & 3u) == 0u && stands) number = spawn(reference);
    number = subgroupQuadBroadcast(number, 0u);
    bool shares = (gl_SubgroupInvocationID & 3u) != 0u;
    if (number == 0u && stands && shares) number = spawn(reference);
    return number;
}
#else
uint shading_sample(uint reference) { return gl_HelperInvocation || reference == DAIS_NO_ROOM ? 0u : spawn(reference); }
#endif

// Of the item, whatever culling has left out of it.
uint triangle_number() {
    uint number = uint(gl_PrimitiveID);
    if ((FEATURES & GPU_FEATURE_COMPACTED) == 0u) return number;
    uint first = push.geometry.triangles.at[in_ids.y];
    return first == 0xffffffffu ? number : push.geometry.triangles.at[first + number];
}

uint fragment_reference() { return gl_HelperInvocation ? 0u : reference_of(in_ids.y, triangle_number()); }
