// SPDX-License-Identifier: MIT
// Occupied clusters: a table over all clusters (and, in deferred shading, 54 ranges of normals in each) says which of them have a cell.
#ifndef LIGHTS_SPARSE_GLSL
#define LIGHTS_SPARSE_GLSL

const uint SPARSE_BUCKETS = 54u; // 3x3 on each face of a cube

uint cube_third(float part, float whole) { return 3.0 * part < -whole ? 0u : 3.0 * part > whole ? 2u : 1u; }

// Does not depend on the length of the normal.
uint normal_bucket(vec3 n) {
    vec3 a = abs(n);
    uint face = a.x >= a.y && a.x >= a.z ? 0u : a.y >= a.z ? 2u : 4u;
    float whole = face == 0u ? n.x : face == 2u ? n.y : n.z;
    vec2 parts = face == 0u ? n.yz : face == 2u ? n.xz : n.xy;
    if (whole < 0.0) face++;
    return (face * 3u + cube_third(parts.x, abs(whole))) * 3u + cube_third(parts.y, abs(whole));
}

// Where a normal pierces the bucket's face of the cube, -1 .. 1, and back. What lies between four points there, between four normals
// that is, lies between their directions.
vec2 bucket_parts(uint bucket, vec3 n) {
    uint face = bucket / 9u;
    return face < 2u ? n.yz / abs(n.x) : face < 4u ? n.xz / abs(n.y) : n.xy / abs(n.z);
}
vec3 bucket_normal(uint bucket, vec2 parts) {
    uint face = bucket / 9u;
    float whole = (face & 1u) == 1u ? -1.0 : 1.0;
    return normalize(face < 2u ? vec3(whole, parts) : face < 4u ? vec3(parts.x, whole, parts.y) : vec3(parts, whole));
}

uint sparse_key(light_list_block l, uvec2 tile, uint slice, uint bucket) {
    return ((slice * l.list.tiles_y + tile.y) * l.list.tiles_x + tile.x) * l.list.buckets + bucket;
}

// False where there is no cell: all lights are used there.
bool sparse_find(light_list_block l, uint key, out uint cell) {
    cell = l.list.extra.at[key];
    return l.list.extra.at[key + 1u] != cell && cell < l.list.cell_limit;
}

#endif
