/* SPDX-License-Identifier: MIT */
/** A small mesh builder for the built-in scenes. Lengths and uvs are metres; faces are seen counter-clockwise. */
#ifndef FNL_SCENE_BUILTIN_MESH_H
#define FNL_SCENE_BUILTIN_MESH_H

#include "scene/builtin.h"

/** The faces of one material; becomes a primitive. */
struct mesh_part {
    uint32_t material;
    ARRAY(vec3) positions;
    ARRAY(vec3) normals;
    ARRAY(vec2) uv;
    ARRAY(uint32_t) indices;
};

/** A mesh being made. Set `transform` to place what is added next (a mirroring one turns the faces round). */
struct mesh_builder {
    struct builtin *builtin;
    mat4 transform;
    struct mesh_part parts[8];
    uint32_t part_count, part;
};

enum mesh_faces {
    FACE_LEFT = 1,
    FACE_RIGHT = 2,
    FACE_BOTTOM = 4,
    FACE_TOP = 8,
    FACE_BACK = 16,
    FACE_FRONT = 32,
    FACE_ALL = 63,
    FACE_SIDES = 51,
    FACE_NO_BOTTOM = 59
};

void mesh_begin(struct mesh_builder *m, struct builtin *b);
/** What follows has this material; at most 8 per mesh. */
void mesh_material(struct mesh_builder *m, uint32_t material);
/** Makes the scene's mesh, tangents included, and empties the builder. Empty parts are left out. */
uint32_t mesh_end(struct mesh_builder *m, const char *name);

uint32_t mesh_vertex(struct mesh_builder *m, vec3 position, vec3 normal, vec2 uv);
void mesh_triangle(struct mesh_builder *m, uint32_t a, uint32_t b, uint32_t c);

/** Corners p, p+u, p+u+v, p+v; normal along u x v; uv runs from (0, |v|) at p to (|u|, 0), upright pictures. */
void mesh_quad(struct mesh_builder *m, vec3 p, vec3 u, vec3 v);
/** The same with given uvs at p (low left) and at p+u+v (top right). */
void mesh_quad_uv(struct mesh_builder *m, vec3 p, vec3 u, vec3 v, vec2 uv_low, vec2 uv_high);
/** Faces -X left, +X right, -Y bottom, +Y top, -Z back, +Z front. */
void mesh_box(struct mesh_builder *m, vec3 low, vec3 high, unsigned faces);
/** A box with rounded-looking (45 degree) edges of width `bevel`. */
void mesh_bevel_box(struct mesh_builder *m, vec3 low, vec3 high, float bevel);
/**
 * Turns a profile of (radius, height) points, bottom to top, about +Y through `base`. Corners over 40 degrees stay
 * sharp. uv: length around at the greatest radius, and along the profile.
 */
void mesh_lathe(struct mesh_builder *m, vec3 base, const vec2 *profile, uint32_t count, uint32_t segments);
/** An upright truncated cone with both caps. */
void mesh_cylinder(struct mesh_builder *m, vec3 base, float radius_low, float radius_high, float height, uint32_t segments);
void mesh_sphere(struct mesh_builder *m, vec3 centre, float radius, uint32_t segments);
/** A tube around a path of at least 2 points. */
void mesh_tube(struct mesh_builder *m, const vec3 *path, uint32_t count, float radius, uint32_t sides);
/** A closed, convex or concave outline in the XY plane (counter-clockwise), drawn along Z from z0 up to z1, caps optional
 * (they fan from the first point). */
void mesh_prism(struct mesh_builder *m, const vec2 *outline, uint32_t count, float z0, float z1, bool caps);
/** An open profile in the XY plane, drawn along Z; normals to the left of its direction. Smooth below 40 degrees. */
void mesh_strip(struct mesh_builder *m, const vec2 *profile, uint32_t count, float z0, float z1);

/** A surface over (s, t) in [0, 1]^2; normal along dS/ds x dS/dt; uv given by the function. */
typedef vec3 mesh_surface_function(const void *context, float s, float t, vec2 *uv);
void mesh_surface(struct mesh_builder *m, uint32_t columns, uint32_t rows, mesh_surface_function *function,
                  const void *context);

#endif
