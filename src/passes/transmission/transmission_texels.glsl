// SPDX-License-Identifier: MIT
// Texels of what is behind (transmission_behind_shared.h).
#ifndef TRANSMISSION_TEXELS_GLSL
#define TRANSMISSION_TEXELS_GLSL

layout(constant_id = 0) const bool FLOATS = false;

vec4 texel_read(texel_array texels, uint index) {
    if (FLOATS) return vec4(uintBitsToFloat(texels.at[2u * index]), uintBitsToFloat(texels.at[2u * index + 1u]));
    return vec4(unpackHalf2x16(texels.at[index].x), unpackHalf2x16(texels.at[index].y));
}

void texel_write(texel_array texels, uint index, vec4 value) {
    if (FLOATS) {
        texels.at[2u * index] = floatBitsToUint(value.xy);
        texels.at[2u * index + 1u] = floatBitsToUint(value.zw);
    } else {
        vec4 held = min(value, vec4(HALF_MAX));
        texels.at[index] = uvec2(packHalf2x16(held.xy), packHalf2x16(held.zw));
    }
}

#endif
