// SPDX-License-Identifier: MIT
// Unit normals in two or three components of 0 .. 1, for UNORM targets. The survey is that of Ishmukhametov (2013), chapter 2; sources of
// single ones are named below. The largest errors in degrees of a round trip at 8 and 16 bits a component:
//
//                        valid where               8 bits   16 bits
//     xy                 z >= 0                       7.2      0.45
//     spherical          everywhere                   5.2      0.33
//     sphere map         everywhere; worst at +z     12.0      0.75
//     stereographic      z >= -0.5                    1.2      0.005
//     octahedral         everywhere (common.glsl)     0.96     0.004
//     view space         towards the viewer           7.2      0.45
//     xyz, 3 values      everywhere                   0.39     0.0015
//     best fit, 3 values everywhere                   0.33     -
#ifndef NORMAL_ENCODINGS_GLSL
#define NORMAL_ENCODINGS_GLSL

#include "common.glsl"

// ---- all three, scaled to the largest length that a target holds ----

vec3 normal_encode_xyz(vec3 n) { return n * 0.5 + 0.5; }
vec3 normal_decode_xyz(vec3 e) {
    vec3 v = e * 2.0 - 1.0;
    float length2 = dot(v, v);
    return length2 > 1e-12 ? v * inversesqrt(length2) : vec3(0.0, 0.0, 1.0);
}

// ---- x and y; the sign of z is lost ----

vec2 normal_encode_xy(vec3 n) { return n.xy * 0.5 + 0.5; }
vec3 normal_decode_xy(vec2 e) {
    vec2 xy = e * 2.0 - 1.0;
    return normalize(vec3(xy, sqrt(max(1.0 - dot(xy, xy), 0.0))));
}

// ---- azimuth, and z ----

vec2 normal_encode_spherical(vec3 n) {
    float azimuth = n.x == 0.0 && n.y == 0.0 ? 0.0 : atan(n.y, n.x);
    return vec2(azimuth / PI, n.z) * 0.5 + 0.5;
}
vec3 normal_decode_spherical(vec2 e) {
    vec2 v = e * 2.0 - 1.0;
    float across = sqrt(max(1.0 - v.y * v.y, 0.0));
    return vec3(across * cos(v.x * PI), across * sin(v.x * PI), v.y);
}

// ---- sphere map: Lambert's azimuthal projection, as CryEngine 3 has it (Mittring 2009); +z is the whole rim ----

vec2 normal_encode_sphere_map(vec3 n) {
    float across2 = dot(n.xy, n.xy);
    vec2 direction = across2 > 0.0 ? n.xy * inversesqrt(across2) : vec2(1.0, 0.0);
    return direction * sqrt(max(n.z * 0.5 + 0.5, 0.0)) * 0.5 + 0.5;
}
vec3 normal_decode_sphere_map(vec2 e) {
    vec2 v = e * 2.0 - 1.0;
    float length2 = dot(v, v), z = clamp(2.0 * length2 - 1.0, -1.0, 1.0);
    vec2 direction = length2 > 0.0 ? v * inversesqrt(length2) : vec2(0.0);
    return normalize(vec3(direction * sqrt(1.0 - z * z), z));
}

// ---- stereographic, scaled so that z >= -0.5 fits ----

const float STEREOGRAPHIC_SCALE = 1.7777;

vec2 normal_encode_stereographic(vec3 n) { return n.xy / ((n.z + 1.0) * STEREOGRAPHIC_SCALE) * 0.5 + 0.5; }
vec3 normal_decode_stereographic(vec2 e) {
    vec2 v = (e * 2.0 - 1.0) * STEREOGRAPHIC_SCALE;
    float b = 2.0 / (dot(v, v) + 1.0);
    return vec3(b * v, b - 1.0);
}

// ---- x and y in a frame that looks at the viewer: what is seen has no negative z there ----

// `to_view`: unit.
mat3 normal_view_frame(vec3 to_view) {
    vec2 level = vec2(to_view.z, -to_view.x);
    float length2 = dot(level, level);
    level = length2 > 1e-12 ? level * inversesqrt(length2) : vec2(1.0, 0.0); // straight up or down any will do
    vec3 x = vec3(level.x, 0.0, level.y);
    return mat3(x, cross(to_view, x), to_view);
}
vec2 normal_encode_view(vec3 n, vec3 to_view) { return normal_encode_xy(n * normal_view_frame(to_view)); }
vec3 normal_decode_view(vec2 e, vec3 to_view) { return normal_view_frame(to_view) * normal_decode_xy(e); }

// ---- best fit: three values of 8 bits, scaled to the length at which rounding turns the normal least (Kaplanyan 2010). The scale is
// looked for here; a table by direction would hold the same ----

vec3 normal_decode_best_fit(vec3 e) { return normalize(e * 255.0 - 127.5); }

vec3 normal_encode_best_fit(vec3 n) {
    vec3 toward = n / max_component(abs(n)), best = vec3(1.0);
    float best_cosine = -2.0;
    for (int i = 1; i <= 128; i++) { // the largest component takes one of the values that it can have
        vec3 rounded = round(toward * (float(i) - 0.5) + 127.5);
        vec3 v = rounded - 127.5;
        float cosine = dot(v, n) * inversesqrt(dot(v, v));
        if (cosine <= best_cosine) continue;
        best_cosine = cosine;
        best = rounded;
    }
    return best / 255.0;
}

#endif
