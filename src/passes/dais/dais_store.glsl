// SPDX-License-Identifier: MIT
// The visibility pass: finds or stores the triangle of a fragment and gives out its reference. Entry points say what they write to.
#include "passes/dais/dais.glsl"
#include "passes/visibility/triangle.glsl"

layout(constant_id = 7) const uint SHARED_SAMPLES = 0u; // 1: shading samples are handed out
layout(constant_id = 31) const uint FEATURES = 0u;      // GPU_FEATURE_…

layout(early_fragment_tests) in;
layout(location = 5) flat in uvec3 in_ids; // material, item, 1 when the instance mirrors
layout(push_constant, scalar) uniform push_block { gpu_dais_visibility_push push; };

const uint LOCK_ATTEMPTS = 1024u, LOCK_POLLS = 128u;

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

// What the material needs, a part of the record each.
uint record_bits(gpu_material m) {
    uint bits = 0u;
    for (uint i = 0u; i < GPU_TEXTURE_COUNT; i++)
        if (m.textures[i].image != GPU_TEXTURE_NONE) bits |= m.textures[i].uv_set == 0u ? DAIS_UV0 : DAIS_UV1;
    if (m.textures[2].image != GPU_TEXTURE_NONE) bits |= DAIS_TANGENT;
    return bits;
}

uint record_size(uint bits) {
    return DAIS_HEADER + 12u + ((bits & DAIS_UV0) != 0u ? 6u : 0u) + ((bits & DAIS_UV1) != 0u ? 6u : 0u) +
           ((bits & DAIS_TANGENT) != 0u ? 12u : 0u) + ((bits & DAIS_COLOR) != 0u ? 12u : 0u) + ((bits & DAIS_BIND) != 0u ? 9u : 0u);
}

void put(inout uint at, float value) { push.pool.at[at++] = floatBitsToUint(value); }

// Takes room for the record and writes its header; DAIS_NO_ROOM where there is none.
uint allocate(triangle t, uint number, uint bits) {
    uint size = record_size(bits);
    // Without the first look, fragments that find no room would count up for ever.
    if (push.counts.at[DAIS_WORDS] > push.capacity - size) return DAIS_NO_ROOM;
    uint base = atomicAdd(push.counts.at[DAIS_WORDS], size);
    if (base > push.capacity - size) return DAIS_NO_ROOM;
    push.pool.at[base] = t.item_index;
    push.pool.at[base + 1u] = number;
    push.pool.at[base + 2u] = t.primitive.material;
    push.pool.at[base + 3u] = bits;
    push.stored.at[atomicAdd(push.counts.at[DAIS_STORED], 1u)] = base + 1u;
    return base + 1u;
}

// Vertices as they lie in memory, but for positions, which are in view space: the derivative pass transforms the rest.
void store(triangle t, uint reference, uint bits) {
    uint at = reference - 1u + DAIS_HEADER;
    attributes_array attributes = push.geometry.scene.scene.attributes;
    for (uint i = 0u; i < 3u; i++) {
        put(at, t.seen[i].x);
        put(at, t.seen[i].y);
        put(at, t.seen[i].z);
        push.pool.at[at++] = attributes.at[t.vertices[i]].normal;
    }
    for (uint i = 0u; i < 3u; i++) {
        gpu_attributes a = attributes.at[t.vertices[i]];
        if ((bits & DAIS_UV0) != 0u) {
            put(at, a.uv0.x);
            put(at, a.uv0.y);
        }
        if ((bits & DAIS_UV1) != 0u) {
            put(at, a.uv1.x);
            put(at, a.uv1.y);
        }
        if ((bits & DAIS_TANGENT) != 0u) push.pool.at[at++] = a.tangent;
        if ((bits & DAIS_COLOR) != 0u) {
            push.pool.at[at++] = a.color.x;
            push.pool.at[at++] = a.color.y;
        }
        if ((bits & DAIS_BIND) != 0u) {
            vec3 bind = push.geometry.scene.scene.positions.at[int(t.vertices[i]) + t.primitive.bind_offset];
            put(at, bind.x);
            put(at, bind.y);
            put(at, bind.z);
        }
    }
}

uint store_new(uint item, uint number, uint more_bits, bool locked, uint bucket) {
    triangle t = triangle_of_item(push.geometry.scene, item);
    triangle_fetch_vertices(t, push.geometry.scene, push.indices, number);
    triangle_fetch_positions(t, push.geometry.scene, push.geometry.view);
    uint bits = record_bits(push.geometry.scene.scene.materials.at[t.primitive.material]) | more_bits | t.primitive.corners << DAIS_CORNERS;
    attributes_array attributes = push.geometry.scene.scene.attributes;
    bool white = true;
    for (uint i = 0u; i < 3u; i++) white = white && attributes.at[t.vertices[i]].color == uvec2(0xffffffffu);
    if (!white) bits |= DAIS_COLOR;
    if ((FEATURES & GPU_FEATURE_MESH_DECALS) != 0u) bits |= DAIS_BIND;
    if (triangle_front_facing(t, push.geometry.view)) bits |= DAIS_FRONT;
    if (in_ids.z != 0u) bits |= DAIS_MIRROR;
    uint reference = allocate(t, number, bits);
    if (reference != DAIS_NO_ROOM) {
        if (locked) {
            memoryBarrierBuffer(); // the header before the reference
            push.cache.at[bucket + 2u] = push.cache.at[bucket + 1u];
            push.cache.at[bucket + 1u] = reference;
        }
        store(t, reference, bits);
    }
    return reference;
}

// The reference of a triangle, stored by whoever asks first. Buckets of two, the older one is forgotten; those that stay locked for long
// are passed over, and the triangle is stored once more.
uint reference_of(uint item, uint number) {
    uint bucket = (item * 0x9e3779b1u + number & push.bucket_mask) * DAIS_BUCKET;
    uint found = find_in_bucket(bucket, item, number);
    // The branches of winners and losers are apart: run in lock-step, the losers' must not come before the winners' release.
    for (uint attempt = 0u; attempt < LOCK_ATTEMPTS && found == 0u; attempt++) {
        bool won = atomicExchange(push.cache.at[bucket], 1u) == 0u;
        if (won) {
            found = find_in_bucket(bucket, item, number);
            if (found == 0u) found = store_new(item, number, 0u, true, bucket);
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
        found = store_new(item, number, DAIS_REDUNDANT, false, 0u);
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
