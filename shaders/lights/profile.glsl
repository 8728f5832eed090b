// SPDX-License-Identifier: MIT
// Light profiles: how bright points and spots are in each direction. A profile is a grid over the angle from the light's direction, 0 to pi, and
// the one from its side towards its up, once round; between, it is bilinear in the angles (src/scene/ies.h).
#ifndef LIGHTS_PROFILE_GLSL
#define LIGHTS_PROFILE_GLSL

#include "lights/iterate.glsl"

// Within 3e-8; spelled out, so that it is the same to the bit in every shader. Abramowitz and Stegun, 4.4.46.
float profile_acos(float x) {
    precise float a = min(abs(x), 1.0);
    precise float p = -0.0012624911;
    p = p * a + 0.0066700901;
    p = p * a - 0.0170881256;
    p = p * a + 0.0308918810;
    p = p * a - 0.0501743046;
    p = p * a + 0.0889789874;
    p = p * a - 0.2145988016;
    p = p * a + 1.5707963050;
    precise float angle = p * sqrt(1.0 - a);
    precise float other = 3.14159265 - angle;
    return x < 0.0 ? other : angle;
}

// `to_light` is unit.
float light_profile(light_set_block l, uint light, vec3 to_light) {
    uint place = uint(l.set.lights.at[light].shape.size.x);
    if (place == 0u) return 1.0;
    profile_array p = l.set.profiles;
    vec3 direction = l.set.lights.at[light].shape.direction, side = l.set.lights.at[light].shape.side;
    precise vec3 up = cross(side, direction);
    precise vec2 across = vec2(-dot(to_light, side), -dot(to_light, up));
    precise float along = -dot(to_light, direction);
    float rows = p.at[place], columns = p.at[place + 1u];
    precise float row = profile_acos(along) * (rows * 0.318309886);
    uint count = uint(columns), i = min(uint(row), uint(rows) - 1u), k = 0u;
    precise float down = min(row - float(i), 1.0), right = 0.0;
    if (count > 1u) {
        precise float turn = profile_acos(across.x * inversesqrt(max(dot(across, across), 1e-30))) * 0.159154943;
        if (across.y < 0.0) turn = 1.0 - turn;
        precise float column = turn * columns;
        k = min(uint(column), count - 1u);
        right = min(column - float(k), 1.0);
    }
    uint next = k + 1u < count ? k + 1u : 0u, upper = place + 2u + i * count, lower = upper + count;
    precise float high = mix(p.at[upper + k], p.at[upper + next], right), low = mix(p.at[lower + k], p.at[lower + next], right);
    precise float value = mix(high, low, down);
    return value;
}

#endif
