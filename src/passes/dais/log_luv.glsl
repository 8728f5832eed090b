// SPDX-License-Identifier: MIT
// Radiance in 32 bits: 16 of the logarithm of luminance, 8 each of CIE 1976 u' and v' (Larson, "LogLuv Encoding for Full-Gamut,
// High-Dynamic Range Images", 1998). Never 0.
#ifndef LOG_LUV_GLSL
#define LOG_LUV_GLSL

uint log_luv_encode(vec3 rgb) {
    const mat3 to_xyz = mat3(0.4124, 0.2126, 0.0193, 0.3576, 0.7152, 0.1192, 0.1805, 0.0722, 0.9505);
    vec3 xyz = to_xyz * max(rgb, vec3(0.0));
    float scale = xyz.x + 15.0 * xyz.y + 3.0 * xyz.z;
    vec2 uv = scale > 1e-30 ? vec2(4.0 * xyz.x, 9.0 * xyz.y) / scale : vec2(0.1978, 0.4683);
    float level = xyz.y > 0.0 ? clamp(floor(512.0 * (log2(xyz.y) + 64.0)), 1.0, 65535.0) : 0.0; // 0.14 % a step
    uvec2 bytes = uvec2(clamp(410.0 * uv + 0.5, vec2(1.0), vec2(255.0)));
    return uint(level) << 16 | bytes.x << 8 | bytes.y;
}

vec3 log_luv_decode(uint word) {
    if (word >> 16 == 0u) return vec3(0.0);
    const mat3 from_xyz = mat3(3.2406, -0.9689, 0.0557, -1.5372, 1.8758, -0.2040, -0.4986, 0.0415, 1.0570);
    float y = exp2((float(word >> 16) + 0.5) / 512.0 - 64.0);
    vec2 uv = vec2(word >> 8 & 255u, word & 255u) / 410.0;
    float x = 9.0 * uv.x / (4.0 * uv.y) * y, z = (12.0 - 3.0 * uv.x - 20.0 * uv.y) / (4.0 * uv.y) * y;
    return max(from_xyz * vec3(x, y, z), vec3(0.0));
}

#endif
