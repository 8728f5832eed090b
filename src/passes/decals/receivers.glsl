// SPDX-License-Identifier: MIT
// Two words for each pixel: receiver bits and the face's normal (12 bits each way), the vertices' normal (16 bits each way).
#ifndef RECEIVERS_GLSL
#define RECEIVERS_GLSL

uvec2 receivers_pack(uint bits, vec3 face, vec3 normal) {
    uvec2 e = uvec2(round((octahedral_encode(face) * 0.5 + 0.5) * 4095.0));
    return uvec2(bits | e.x << 8 | e.y << 20, packSnorm2x16(octahedral_encode(normal)));
}

uint receivers_bits(uvec2 packed) { return packed.x & 255u; }
vec3 receivers_face(uvec2 packed) { return octahedral_decode(vec2(packed.x >> 8 & 4095u, packed.x >> 20) / 4095.0 * 2.0 - 1.0); }
vec3 receivers_normal(uvec2 packed) { return octahedral_decode(unpackSnorm2x16(packed.y)); }

#endif
