#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// One thread a record: fetches the vertices of a triangle that is seen, and puts the derivatives of their attributes behind its header.
// Attributes over w, and 1/w, are linear on the screen; kept is what they are at its centre, NDC (0, 0), and how they change with NDC x and y (Schied and Dachsbacher, GPU Pro 7, II.3).
#include "passes/dais/dais.glsl"
#include "passes/visibility/triangle.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_dais_derive_push push; };

vec3 unit(vec3 v) { return v * inversesqrt(max(dot(v, v), 1e-37)); }

// Weights of the vertices: what the barycentric coordinates are at a vertex of the part that is drawn, their gradients, and 1/w.
struct derivation {
    mat3 corners; // column i: the weights of the original vertices at corner i, over w
    vec3 dx, dy;  // of the corners' screen barycentrics
    vec2 from;    // NDC of the corner that is extrapolated from
    uint nearest;
};

void put(inout uint at, float dx, float dy, float value, uint stride) {
    push.pool.at[at] = floatBitsToUint(dx);
    push.pool.at[at + stride] = floatBitsToUint(dy);
    push.pool.at[at + 2u * stride] = floatBitsToUint(value);
    at++;
}

// One component of an attribute with these values at the vertices.
void derive(derivation d, vec3 vertices, inout uint at, uint stride) {
    vec3 f = vertices * d.corners; // over w, at the corners
    // Differences from one corner: what all have in common does not round.
    vec3 g = f - f[d.nearest];
    float dx = dot(d.dx, g), dy = dot(d.dy, g);
    put(at, dx, dy, f[d.nearest] - d.from.x * dx - d.from.y * dy, stride);
}

void derive3(derivation d, vec3 a, vec3 b, vec3 c, inout uint at) {
    for (uint k = 0u; k < 3u; k++) derive(d, vec3(a[k], b[k], c[k]), at, 3u);
    at += 6u;
}

void derive2(derivation d, vec2 vertices[3], inout uint at) {
    for (uint k = 0u; k < 2u; k++) derive(d, vec3(vertices[0][k], vertices[1][k], vertices[2][k]), at, 2u);
    at += 4u;
}

void derive4(derivation d, vec4 vertices[3], inout uint at) {
    for (uint k = 0u; k < 4u; k++) derive(d, vec3(vertices[0][k], vertices[1][k], vertices[2][k]), at, 4u);
    at += 8u;
}

#define ATTRIBUTES(i) push.scene.scene.attributes.at[t.vertices[i]]

void main() {
    uint index = LINEAR_INVOCATION;
    if (index >= push.counts.at[DAIS_STORED]) return;
    uint base = push.stored.at[index] - 1u, bits = push.pool.at[base + 3u];
    triangle t = triangle_of_item(push.scene, push.pool.at[base]);
    triangle_fetch_vertices(t, push.scene, push.indices, push.pool.at[base + 1u]);
    triangle_fetch_positions(t, push.scene, push.view);
    uint corners = t.primitive.corners;
    bool orthographic = push.view.view.orthographic > 0.5;

    vec3 seen[3] = t.seen;
    if (triangle_front_facing(t, push.view)) bits |= DAIS_FRONT;

    // The part in front of the near plane, or with two vertices there a triangle in it: derivatives are the same on every part. A vertex
    // behind the plane slides along an edge to one before it. Other planes need no such thing, as w is positive there, and shrinking against
    // one after the other can leave nothing.
    mat3 weights = mat3(1.0);
    if (!orthographic) {
        float near = push.view.view.near_distance;
        vec3 before = vec3(-seen[0].z, -seen[1].z, -seen[2].z) - near;
        bvec3 outside = lessThan(before, vec3(0.0));
        if (any(outside) && !all(outside)) {
            uint inside = !outside.x ? 0u : !outside.y ? 1u : 2u;
            vec3 to_seen = seen[inside];
            vec3 old[3] = vec3[](seen[0], seen[1], seen[2]);
            for (uint i = 0u; i < 3u; i++) {
                if (!outside[i]) continue;
                uint to = outside[(i + 1u) % 3u] ? inside : (i + 1u) % 3u;
                float t = before[to] / (before[to] - before[i]);
                weights[i] = vec3(0.0);
                weights[i][to] = 1.0 - t;
                weights[i][i] = t;
                seen[i] = mix(old[to], old[i], t);
            }
        }
    }

    vec2 p[3];
    vec3 over_w = vec3(1.0);
    for (uint i = 0u; i < 3u; i++) {
        float depth = orthographic ? 1.0 : max(-seen[i].z, 1e-20);
        p[i] = (seen[i].xy / depth - push.view.view.ndc_offset) / push.view.view.ndc_scale;
        over_w[i] = 1.0 / depth;
    }
    derivation d;
    d.nearest = 0u;
    for (uint i = 1u; i < 3u; i++)
        if (dot(p[i], p[i]) < dot(p[d.nearest], p[d.nearest])) d.nearest = i;
    d.from = p[d.nearest];
    d.dx = d.dy = vec3(0.0);
    if (corners == 3u) {
        vec2 a = p[2] - p[1], b = p[0] - p[1];
        float determinant = a.x * b.y - a.y * b.x;
        float scale = abs(determinant) > 1e-37 ? 1.0 / determinant : 0.0;
        d.dx = vec3(p[1].y - p[2].y, p[2].y - p[0].y, p[0].y - p[1].y) * scale;
        d.dy = vec3(p[2].x - p[1].x, p[0].x - p[2].x, p[1].x - p[0].x) * scale;
    } else if (corners == 2u) { // along the line, and nothing across it: by distances in pixels
        vec2 size = vec2(push.view.view.size), along = (p[1] - p[0]) * size;
        vec2 slope = along * size / max(dot(along, along), 1e-30);
        d.dx = vec3(-slope.x, slope.x, 0.0);
        d.dy = vec3(-slope.y, slope.y, 0.0);
    }
    for (uint i = 0u; i < 3u; i++) d.corners[i] = weights[i] * over_w[i];

    uint at = base + DAIS_HEADER;
    if (orthographic)
        derive(d, vec3(-seen[0].z, -seen[1].z, -seen[2].z), at, 1u); // 1/w would be 1: the depth itself
    else
        derive(d, vec3(1.0), at, 1u);
    at += 2u;

    // Attributes are fetched when their turn comes: all at once they would take 36 registers.
    float mirror = 1.0;
    vec3 vectors[3];
    vec4 values[3];
    for (uint i = 0u; i < 3u; i++) vectors[i] = unit(transform_normal(t.instance, unpack_normal(ATTRIBUTES(i).normal), mirror));
    if (mirror < 0.0 && corners == 3u) bits |= DAIS_MIRROR;
    push.pool.at[base + 3u] = bits;
    derive3(d, vectors[0], vectors[1], vectors[2], at);
    vec2 uv[3];
    if ((bits & DAIS_UV0) != 0u) {
        for (uint i = 0u; i < 3u; i++) uv[i] = ATTRIBUTES(i).uv0;
        derive2(d, uv, at);
    }
    if ((bits & DAIS_UV1) != 0u) {
        for (uint i = 0u; i < 3u; i++) uv[i] = ATTRIBUTES(i).uv1;
        derive2(d, uv, at);
    }
    if ((bits & DAIS_TANGENT) != 0u) {
        for (uint i = 0u; i < 3u; i++) {
            vec4 tangent = unpack_tangent(ATTRIBUTES(i).tangent);
            values[i] = vec4(unit(transform_direction(t.instance, tangent.xyz)), tangent.w * mirror);
        }
        derive4(d, values, at);
    }
    if ((bits & DAIS_COLOR) != 0u) {
        for (uint i = 0u; i < 3u; i++) values[i] = vec4(unpackUnorm2x16(ATTRIBUTES(i).color.x), unpackUnorm2x16(ATTRIBUTES(i).color.y));
        derive4(d, values, at);
    }
    if ((bits & DAIS_BIND) != 0u) {
        for (uint i = 0u; i < 3u; i++) vectors[i] = push.scene.scene.positions.at[int(t.vertices[i]) + t.primitive.bind_offset];
        derive3(d, vectors[0], vectors[1], vectors[2], at);
    }
}
