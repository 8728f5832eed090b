// SPDX-License-Identifier: MIT
// Blocks of BC3: 4 x 4 texels of RGBA8 in 16 bytes, alpha by eight levels and color by four (Khronos Data Format Specification 1.3, chapters S3TC and RGTC).
// Ends are those of the box of the block's values; each channel of the color runs up or down, as it goes along with the widest.
#ifndef BC3_GLSL
#define BC3_GLSL

// 565 bits, and the color that they decode to.
uint bc3_pack_color(vec3 color, out vec3 decoded) {
    uvec3 c = uvec3(round(color * vec3(31.0, 63.0, 31.0)));
    decoded = vec3(c) / vec3(31.0, 63.0, 31.0);
    return c.r << 11 | c.g << 5 | c.b;
}

uvec4 bc3_encode(uint texels[16]) {
    vec4 low = vec4(1.0), high = vec4(0.0), mean = vec4(0.0);
    for (int i = 0; i < 16; i++) {
        vec4 t = unpackUnorm4x8(texels[i]);
        low = min(low, t);
        high = max(high, t);
        mean += t * (1.0 / 16.0);
    }
    // Alpha: level 0 is the greater end, level 7 the smaller one.
    uvec2 levels = uvec2(0u); // 48 bits, three for each texel
    float reach = high.a - low.a;
    for (uint i = 0u; i < 16u && reach > 0.0; i++) {
        uint step = uint(round((high.a - unpackUnorm4x8(texels[i]).a) / reach * 7.0)), code = step == 0u ? 0u : step == 7u ? 1u : step + 1u, at = 3u * i;
        if (at < 32u) levels.x |= code << at;
        if (at > 29u) levels.y |= at < 32u ? code >> 32u - at : code << at - 32u;
    }
    // Color.
    vec3 range = high.rgb - low.rgb;
    uint widest = range.r >= range.g && range.r >= range.b ? 0u : range.g >= range.b ? 1u : 2u;
    vec3 along = vec3(0.0);
    for (int i = 0; i < 16; i++) {
        vec3 off = unpackUnorm4x8(texels[i]).rgb - mean.rgb;
        along += off * off[widest];
    }
    vec3 first, last, from = mix(high.rgb, low.rgb, lessThan(along, vec3(0.0))), to = mix(low.rgb, high.rgb, lessThan(along, vec3(0.0)));
    uint ends = bc3_pack_color(from, first), codes = 0u;
    ends |= bc3_pack_color(to, last) << 16;
    vec3 axis = first - last;
    float squared = dot(axis, axis);
    for (uint i = 0u; i < 16u && squared > 0.0; i++) {
        uint step = uint(round(clamp(dot(first - unpackUnorm4x8(texels[i]).rgb, axis) / squared, 0.0, 1.0) * 3.0));
        codes |= (step == 0u ? 0u : step == 3u ? 1u : step + 1u) << 2u * i;
    }
    uvec2 alphas = uvec2(round(vec2(high.a, low.a) * 255.0));
    return uvec4(alphas.x | alphas.y << 8 | levels.x << 16, levels.x >> 16 | levels.y << 16, ends, codes);
}

#endif
