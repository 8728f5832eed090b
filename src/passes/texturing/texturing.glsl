// SPDX-License-Identifier: MIT
// The G-buffer of texturing: where its fields lie, and the tangent frame.
#ifndef TEXTURING_GLSL
#define TEXTURING_GLSL

#include "common.glsl"
#include "passes/texturing/texturing_shared.h"

layout(constant_id = 4) const uint FORM = 0u; // TEXTURING_…

#define TARGET_FRAME 0u
#define TARGET_UV 1u
#define TARGET_ID 2u
const uint TARGET_GRADIENTS = 3u;
const uint TARGET_SLOPES = TARGET_GRADIENTS + ((FORM & TEXTURING_GRADIENTS) != 0u ? 1u : 0u);
const uint TARGET_COLORS = TARGET_SLOPES + ((FORM & TEXTURING_SLOPES) != 0u ? 1u : 0u);
const uint TARGET_BIND = TARGET_COLORS + ((FORM & TEXTURING_COLORS) != 0u ? 1u : 0u);

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

uint pack_halves(vec2 v) { return packHalf2x16(clamp(v, -HALF_MAX, HALF_MAX)); }

#endif
