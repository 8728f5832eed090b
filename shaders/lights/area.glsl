// SPDX-License-Identifier: MIT
// Light from a whole area light (GPU_LIGHTING_AREA_LIGHTS): the BRDF's lobes, integrated over the part of the light above the surface's horizon. The diffuse
// one by Lambert's formula; the specular one as a cosine that is stretched and sheared (Heitz, Dupuy, Hill and Neubelt 2016, "Real-Time Polygonal-Light
// Shading with Linearly Transformed Cosines"), by the table of tools/area_lobes.c. Where the light takes little of the lobe, the lobe itself
// corrects the fit: at the direction that most light comes from. So a small or distant area light gives what a point does.
#ifndef LIGHTS_AREA_GLSL
#define LIGHTS_AREA_GLSL

#include "brdf.glsl"
#include "lighting/reach.glsl"

// Angle over sine, of an angle with this cosine: Abramowitz and Stegun, 4.4.46.
float area_angle(float cosine) {
    precise float x = min(abs(cosine), 1.0);
    precise float p = -0.0012624911;
    p = p * x + 0.0066700901;
    p = p * x - 0.0170881256;
    p = p * x + 0.0308918810;
    p = p * x - 0.0501743046;
    p = p * x + 0.0889789874;
    p = p * x - 0.2145988016;
    p = p * x + 1.5707963050;
    precise float acute = p * inversesqrt(1.0 + x);
    precise float obtuse = 3.14159265 * inversesqrt(max(1.0 - x * x, 1e-7)) - acute;
    return cosine < 0.0 ? obtuse : acute;
}

// Leaves what is above the plane z = 0.
void area_clip(inout area_polygon p) {
    area_polygon from = p;
    uint kept = 0u, first = 6u;
    vec3 leaves = vec3(0.0), enters = vec3(0.0); // where the border crosses the plane: once each way, for it is convex
    for (uint i = 0u; i < from.count; i++) {
        vec3 a = from.corners[i], e = from.edges[i], b = from.corners[i + 1u < from.count ? i + 1u : 0u];
        bool begins = a.z > 0.0, ends = b.z > 0.0;
        if (!begins && !ends || kept == 6u) continue;
        precise float at = begins == ends ? 1.0 : a.z / (a.z - b.z);
        precise vec3 crossing = a + e * at;
        crossing.z = 0.0;
        precise vec3 corner = begins ? a : crossing, edge = e * (begins ? at : 1.0 - at);
        if (!begins) enters = crossing;
        p.corners[kept] = corner;
        p.edges[kept++] = edge;
        if (!ends && kept < 6u) { // from here on along the plane
            leaves = crossing;
            first = kept;
            p.corners[kept++] = crossing;
        }
    }
    precise vec3 along = enters - leaves;
    if (first < 6u) p.edges[first] = along;
    p.count = kept;
}

// Lambert's formula, without its sign: z is the integral of the cosine over pi; along it most of the light comes.
vec3 area_flux(area_polygon p) {
    precise vec3 sum = vec3(0.0);
    for (uint i = 0u; i < p.count; i++) {
        precise vec3 a = p.corners[i], e = p.edges[i], b = p.corners[i + 1u < p.count ? i + 1u : 0u];
        precise float scale = inversesqrt(max(dot(a, a), 1e-30)) * inversesqrt(max(dot(b, b), 1e-30));
        precise vec3 across = cross(a, e);
        sum += across * (scale * area_angle(dot(a, b) * scale) * 0.159154943);
    }
    precise vec3 upward = sum.z < 0.0 ? -sum : sum;
    return upward;
}

// World to where the normal is z and the viewer lies in the plane of x and z.
mat3 area_frame(vec3 normal, vec3 to_view) {
    precise vec3 along = to_view - normal * dot(normal, to_view);
    precise float length2 = dot(along, along);
    vec3 any = abs(normal.x) < 0.7 ? vec3(0.0, -normal.z, normal.y) : vec3(-normal.z, 0.0, normal.x);
    if (!(length2 > 1e-10)) along = any;
    precise vec3 x = along * inversesqrt(dot(along, along));
    precise vec3 y = cross(normal, x);
    return transpose(mat3(x, y, normal));
}

struct area_lobe {
    vec2 stretch;
    float shear;
    vec2 turn; // cosine and sine
    float scale, above;
};

area_lobe area_look_up(light_set_block l, float alpha2, float n_v) {
    lobe_array t = l.set.lobes;
    precise float alpha = sqrt(alpha2), row = clamp(sqrt(alpha), 0.0, 1.0) * float(AREA_LOBE_ROWS - 1), column = sqrt(max(1.0 - n_v, 0.0)) * float(AREA_LOBE_COLUMNS - 1);
    uint i = min(uint(row), uint(AREA_LOBE_ROWS - 2)), k = min(uint(column), uint(AREA_LOBE_COLUMNS - 2));
    precise float down = row - float(i), right = column - float(k);
    uint upper = (i * uint(AREA_LOBE_COLUMNS) + k) * uint(AREA_LOBE_VALUES), lower = upper + uint(AREA_LOBE_COLUMNS * AREA_LOBE_VALUES);
    float value[AREA_LOBE_VALUES];
    for (uint j = 0u; j < uint(AREA_LOBE_VALUES); j++) {
        precise float high = mix(t.at[upper + j], t.at[upper + uint(AREA_LOBE_VALUES) + j], right);
        precise float low = mix(t.at[lower + j], t.at[lower + uint(AREA_LOBE_VALUES) + j], right);
        precise float between = mix(high, low, down);
        value[j] = between;
    }
    area_lobe lobe;
    precise vec2 stretch = vec2(value[0], value[1]) * alpha;
    // The mirror direction's angle is that of the viewer on the other side; from there to the axis, and back by the shear.
    precise float off = sqrt(max(1.0 - value[2] * value[2], 0.0)), n_x = sqrt(max(1.0 - n_v * n_v, 0.0));
    precise vec2 axis = vec2(off * n_v + value[2] * n_x, value[2] * n_v - off * n_x);
    precise vec2 turn = vec2(axis.x + value[3] * axis.y, axis.y - value[3] * axis.x);
    precise vec2 turned = turn * inversesqrt(dot(turn, turn));
    lobe.stretch = stretch;
    lobe.shear = value[3];
    lobe.turn = turned;
    lobe.scale = value[4];
    lobe.above = value[5];
    return lobe;
}

// To where the lobe is a cosine round z.
void area_to_cosine(area_lobe m, inout area_polygon p) {
    for (uint i = 0u; i < 2u * p.count; i++) {
        vec3 v = i < p.count ? p.corners[i] : p.edges[i - p.count];
        precise float z = v.x * m.turn.y + v.z * m.turn.x;
        precise vec3 q = vec3((v.x * m.turn.x - v.z * m.turn.y - m.shear * z) / m.stretch.x, v.y / m.stretch.y, z);
        if (i < p.count) p.corners[i] = q;
        else p.edges[i - p.count] = q;
    }
}

void area_mirror(inout area_polygon p) {
    for (uint i = 0u; i < p.count; i++) {
        p.corners[i].z = -p.corners[i].z;
        p.edges[i].z = -p.edges[i].z;
    }
}

vec3 area_from_cosine(area_lobe m, vec3 q) {
    precise float x = m.stretch.x * q.x + m.shear * q.z;
    precise vec3 p = vec3(x * m.turn.x + q.z * m.turn.y, m.stretch.y * q.y, q.z * m.turn.x - x * m.turn.y);
    return p;
}

// The lobes of a whole area light: n_l and n_l times specular are their integrals, divided by the share that light_reach() includes (area_share()), so they
// replace the lobes of a point. `mirrored`: of its mirror image behind the surface. `toward`: unit, where most of the diffuse light comes from.
bool area_lobes_of(light_set_block l, uint light, vec3 position, vec3 normal, brdf_view b, bool mirrored, out brdf_lobes lobes, out vec3 toward) {
    mat3 to_frame = area_frame(normal, b.to_view);
    precise float n_v = clamp(abs(dot(normal, b.to_view)), 1e-3, 1.0);
    area_lobe m = area_look_up(l, b.alpha2, n_v);
    lobes = brdf_lobes(0.0, 0.0, 0.0, 0.0);
    toward = normal;
    area_polygon p = area_polygon_of(l, light, position, to_frame);
    if (mirrored) area_mirror(p);
    vec3 flux[2] = vec3[2](vec3(0.0), vec3(0.0)), middle[2]; // of the diffuse lobe, and of the specular one
    brdf_lobes at[2];
    // Both are one loop, so that shaders hold its code once.
    for (uint k = 0u; k < 2u; k++) {
        if (k == 1u) area_to_cosine(m, p);
        area_clip(p);
        precise vec3 sum = area_flux(p);
        if (!(sum.z > 0.0)) break;
        precise vec3 mean = sum;
        if (k == 1u) mean = area_from_cosine(m, sum);
        precise vec3 direction = (mean * inversesqrt(max(dot(mean, mean), 1e-30))) * to_frame; // the frame's transpose turns back
        flux[k] = sum;
        middle[k] = direction;
        brdf_lobes_shaded(normal, b, direction, at[k]);
    }
    if (!(flux[0].z > 0.0)) return false;
    toward = middle[0];
    precise float n_l = flux[0].z * PI / area_share(l, light, position) * brdf_facing(b, toward);
    if (!(n_l > 0.0)) return false;
    lobes.n_l = n_l;
    lobes.m5_below = lobes.m5 = at[0].m5;
    if (!(flux[1].z > 0.0)) return true;
    precise vec3 q = flux[1];
    precise float length2 = dot(q, q);
    // The density of the transformed cosine: lengths are those that directions have once transformed.
    precise vec3 stretched = area_from_cosine(m, q);
    precise float scale2 = dot(stretched, stretched), cosine = q.z * sqrt(scale2);
    precise float fitted = m.scale * cosine * scale2 / (length2 * length2 * PI * m.stretch.x * m.stretch.y);
    precise float rest = 1.0 - min(q.z / m.above, 1.0), ratio = 1.0;
    if (fitted > 0.0) ratio = 1.0 + (min(at[1].specular * at[1].n_l / fitted, 4.0) - 1.0) * rest * rest;
    precise float specular = m.scale * q.z * ratio / (flux[0].z * PI);
    lobes.specular = specular;
    lobes.m5 = at[1].m5;
    return true;
}

// Whether a light is shaded as an area light: if it is narrower than a thousandth of a radian, a point is enough.
bool light_is_area(light_set_block l, uint light, vec3 position) {
    if (!LIGHTING_AREA_LIGHTS || !shape_is_area(l.set.lights.at[light].shape.kind)) return false;
    precise vec3 ray = l.set.lights.at[light].shape.position - position;
    return area_of(l, light) > 1e-6 * dot(ray, ray);
}

// brdf_lobes_of() for any light; `to_light` as light_reach() has it.
bool light_brdf_lobes(light_set_block l, uint light, vec3 position, vec3 normal, brdf_view b, vec3 to_light, out brdf_lobes lobes) {
    vec3 toward;
    if (light_is_area(l, light, position)) return area_lobes_of(l, light, position, normal, b, false, lobes, toward);
    return brdf_lobes_of(normal, b, to_light, lobes);
}

#endif
