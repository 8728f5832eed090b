// SPDX-License-Identifier: MIT
// The G-buffer of texturing: where its fields lie, and the tangent frame.
#ifndef TEXTURING_GLSL
#define TEXTURING_GLSL

#include "common.glsl"
#include "passes/texturing/texturing_shared.h"

layout(constant_id = TEXTURING_FORM_ID) const uint FORM = 0u; // TEXTURING_…

const bool HAS_ID = (FORM & (TEXTURING_VIRTUAL | TEXTURING_ITEMS)) != TEXTURING_VIRTUAL;
const bool HAS_SAMPLES = (FORM & TEXTURING_SAMPLES) != 0u;

#define TARGET_FRAME 0u
#define TARGET_UV 1u
#define TARGET_ID 2u
const uint TARGET_GRADIENTS = (FORM & (TEXTURING_VIRTUAL | TEXTURING_ITEMS)) == TEXTURING_VIRTUAL ? 2u : 3u;
#define TWO_GRADIENTS (TEXTURING_GRADIENTS | TEXTURING_UV1 | TEXTURING_SAMPLES)
const uint GRADIENT_TARGETS = ((FORM & TEXTURING_GRADIENTS) != 0u ? 1u : 0u) + ((FORM & TWO_GRADIENTS) == TWO_GRADIENTS ? 1u : 0u);
const uint TARGET_SLOPES = TARGET_GRADIENTS + GRADIENT_TARGETS; // with samples they are the number's second word
const uint TARGET_COLORS = TARGET_SLOPES + ((FORM & (TEXTURING_SLOPES | TEXTURING_SAMPLES)) == TEXTURING_SLOPES ? 1u : 0u);
const uint TARGET_BIND = TARGET_COLORS + ((FORM & TEXTURING_COLORS) != 0u ? 1u : 0u);

// With several samples: floats as they are, single words as bytes, pairs as parts of 65 535, from which the bits come back as they were.
// The last word of TARGET_BIND, two halves, keeps the 12 upper bits of each, as a whole number.
bool target_has_floats(uint i) {
    return (i == TARGET_UV && (FORM & TEXTURING_VIRTUAL) == 0u) || (i == TARGET_BIND && (FORM & TEXTURING_BIND) != 0u);
}

bool target_is_word(uint i) {
    return (i <= TARGET_UV && (FORM & TEXTURING_VIRTUAL) != 0u) || (i == TARGET_ID && HAS_ID && (FORM & TEXTURING_SLOPES) == 0u);
}

vec4 target_stored(uint i, uvec4 bits) {
    if (target_is_word(i)) return unpackUnorm4x8(bits.x);
    if (!target_has_floats(i)) return vec4(unpackUnorm2x16(bits.x), unpackUnorm2x16(bits.y));
    if (i == TARGET_UV) return uintBitsToFloat(bits);
    return vec4(uintBitsToFloat(bits.xyz), float(bits.w >> 4 & 0xfffu | bits.w >> 20 << 12));
}

uvec4 target_bits(uint i, vec4 stored) {
    if (target_is_word(i)) return uvec4(packUnorm4x8(stored), 0u, 0u, 0u);
    if (!target_has_floats(i)) return uvec4(packUnorm2x16(stored.xy), packUnorm2x16(stored.zw), 0u, 0u);
    if (i == TARGET_UV) return floatBitsToUint(stored);
    uint last = uint(stored.w);
    return uvec4(floatBitsToUint(stored.xyz), (last & 0xfffu) << 4 | last >> 12 << 20);
}

// Two directions across a unit vector (Duff et al. 2017, "Building an Orthonormal Basis, Revisited").
void basis_of(vec3 n, out vec3 a, out vec3 b) {
    float s = n.z < 0.0 ? -1.0 : 1.0, k = -1.0 / (s + n.z), m = n.x * n.y * k;
    a = vec3(1.0 + s * n.x * n.x * k, s * m, -s * n.x);
    b = vec3(m, s + n.y * n.y * k, -n.y);
}

// x: the normal, octahedral, 2 x 16 bits. y: from the lowest bit, angle of the tangent round it (16 bits), length of the normal (7
// bits: what interpolation leaves of 1), length of the tangent (7), handedness is -1 (1), seen from behind (1).
uvec2 frame_pack(vec3 normal, vec4 tangent, bool front) {
    float length2 = dot(normal, normal), size = 0.0;
    vec3 n = vec3(0.0, 1.0, 0.0);
    if (length2 > 1e-30 && length2 < 1e30) {
        size = sqrt(length2);
        n = normal / size;
    }
    uvec2 bits;
    bits.x = packSnorm2x16(octahedral_encode(n));
    vec3 a, b;
    basis_of(octahedral_decode(unpackSnorm2x16(bits.x)), a, b);
    vec2 t = vec2(dot(tangent.xyz, a), dot(tangent.xyz, b));
    float across = length(t), turn = across > 1e-15 && across < 1e15 ? atan(t.y, t.x) / (2.0 * PI) : 0.0;
    bits.y = uint(round((turn + 1.0) * 65536.0)) & 0xffffu;
    bits.y |= uint(round(clamp(size, 0.0, 1.0) * 127.0)) << 16 | uint(round(across < 1.0 ? across * 127.0 : 127.0)) << 23;
    if (tangent.w < 0.0) bits.y |= 0x40000000u;
    if (!front) bits.y |= 0x80000000u;
    return bits;
}

void frame_unpack(uvec2 bits, out vec3 normal, out vec4 tangent, out bool front) {
    vec3 n = octahedral_decode(unpackSnorm2x16(bits.x)), a, b;
    basis_of(n, a, b);
    float angle = float(bits.y & 0xffffu) / 65536.0 * 2.0 * PI;
    normal = n * (float(bits.y >> 16 & 127u) / 127.0);
    tangent.xyz = (a * cos(angle) + b * sin(angle)) * (float(bits.y >> 23 & 127u) / 127.0);
    tangent.w = (bits.y & 0x40000000u) != 0u ? -1.0 : 1.0;
    front = (bits.y & 0x80000000u) == 0u;
}

// In 32 bits: a quaternion that turns the axes into tangent, bitangent and normal. From the lowest bit: which of its parts is largest and
// left out (2 bits), handedness is -1 (1), the next three parts round the circle (10, 10 and 9). Lengths are lost, and what lies along the
// normal of the tangent.
uint quaternion_pack(vec3 normal, vec4 tangent) {
    float length2 = dot(normal, normal);
    vec3 n = length2 > 1e-30 && length2 < 1e30 ? normal * inversesqrt(length2) : vec3(0.0, 1.0, 0.0), t, b;
    basis_of(n, t, b);
    vec3 across = tangent.xyz - n * dot(n, tangent.xyz);
    float across2 = dot(across, across);
    if (across2 > 1e-20 && across2 < 1e30) t = across * inversesqrt(across2);
    b = cross(n, t);
    // Four times the squares of the parts (Shepperd 1978).
    vec4 squares = vec4(1.0 + t.x - b.y - n.z, 1.0 - t.x + b.y - n.z, 1.0 - t.x - b.y + n.z, 1.0 + t.x + b.y + n.z);
    vec4 q = vec4(0.0);
    uint largest = 0u;
    for (uint i = 1u; i < 4u; i++)
        if (squares[i] > squares[largest]) largest = i;
    if (largest == 0u) q = vec4(squares.x, t.y + b.x, n.x + t.z, b.z - n.y);
    if (largest == 1u) q = vec4(t.y + b.x, squares.y, b.z + n.y, n.x - t.z);
    if (largest == 2u) q = vec4(n.x + t.z, b.z + n.y, squares.z, t.y - b.x);
    if (largest == 3u) q = vec4(b.z - n.y, n.x - t.z, t.y - b.x, squares.w);
    q = normalize(q) * (q[largest] < 0.0 ? -1.0 : 1.0);
    vec3 rest = vec3(q[(largest + 1u) & 3u], q[(largest + 2u) & 3u], q[(largest + 3u) & 3u]) * 1.41421356;
    uvec3 bits = uvec3(round((clamp(rest, -1.0, 1.0) * 0.5 + 0.5) * vec3(1022.0, 1022.0, 510.0)));
    return largest | (tangent.w < 0.0 ? 4u : 0u) | bits.x << 3 | bits.y << 13 | bits.z << 23;
}

void quaternion_unpack(uint bits, out vec3 normal, out vec4 tangent) {
    uint largest = bits & 3u;
    vec3 rest = (vec3(bits >> 3 & 1023u, bits >> 13 & 1023u, bits >> 23) / vec3(1022.0, 1022.0, 510.0) * 2.0 - 1.0) * 0.70710678;
    vec4 q;
    q[largest] = sqrt(max(1.0 - dot(rest, rest), 0.0));
    q[(largest + 1u) & 3u] = rest.x;
    q[(largest + 2u) & 3u] = rest.y;
    q[(largest + 3u) & 3u] = rest.z;
    q = normalize(q);
    tangent.xyz = vec3(1.0 - 2.0 * (q.y * q.y + q.z * q.z), 2.0 * (q.x * q.y + q.z * q.w), 2.0 * (q.x * q.z - q.y * q.w));
    normal = vec3(2.0 * (q.x * q.z + q.y * q.w), 2.0 * (q.y * q.z - q.x * q.w), 1.0 - 2.0 * (q.x * q.x + q.y * q.y));
    tangent.w = (bits & 4u) != 0u ? -1.0 : 1.0;
}

uint pack_halves(vec2 v) { return packHalf2x16(clamp(v, -HALF_MAX, HALF_MAX)); }

#endif
