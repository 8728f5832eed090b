/* SPDX-License-Identifier: MIT */
/*
 * Generated tangents against a slow reference in double precision, written from the description of the method: M. S.
 * Mikkelsen, "Simulation of Wrinkled Surfaces Revisited" (2008), which glTF 2.0 (3.7.2.1) names. It compares every pair of
 * vertices and of edges, spreads groups by recursion, and works out every corner for itself.
 */
#include "scene/scene.h"
#include "tests/test_meter.h"

#include <setjmp.h>
#include <unistd.h>

#include <cmocka.h>

/* ---- the reference ---- */

typedef struct {
    double x, y, z;
} real3;

static real3 real(vec3 a) { return (real3){(double)a.x, (double)a.y, (double)a.z}; }
static real3 minus(real3 a, real3 b) { return (real3){a.x - b.x, a.y - b.y, a.z - b.z}; }
static real3 times(real3 a, double s) { return (real3){a.x * s, a.y * s, a.z * s}; }
static real3 plus(real3 a, real3 b) { return (real3){a.x + b.x, a.y + b.y, a.z + b.z}; }
static double product(real3 a, real3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static double size_of(real3 a) { return sqrt(product(a, a)); }
static real3 unit(real3 a) { return size_of(a) > 1e-30 ? times(a, 1 / size_of(a)) : (real3){0, 0, 0}; }
static real3 project(real3 a, real3 n) { return unit(minus(a, times(n, product(a, n)))); }

enum { FACES_MAX = 4096, NOBODY = -1 };

struct reference_face {
    real3 s, t;
    bool preserving, any, degenerate;
    int weld[3], neighbor[3], group[3];
};

/** What becomes of a corner. */
struct reference_corner {
    bool given; /* false: nothing gives it a direction */
    bool clear; /* its direction is no rounding error */
    bool preserving;
    real3 tangent;
    int group;
    uint64_t members; /* a sum of what it is the mean of */
};

static struct reference_face faces[FACES_MAX];
static struct reference_corner corners[FACES_MAX * 3];
static int face_count, group_count;
static int group_vertex[FACES_MAX * 3];
static bool group_preserving[FACES_MAX * 3];

static bool equal3(vec3 a, vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

static bool same_vertex(const struct scene_primitive *p, const vec2 *uv, uint32_t a, uint32_t b) {
    return equal3(p->positions[a], p->positions[b]) && equal3(p->normals[a], p->normals[b]) && uv[a].x == uv[b].x &&
           uv[a].y == uv[b].y;
}

static void reference_derivatives(const struct scene_primitive *p, const vec2 *uv, int f) {
    struct reference_face *face = &faces[f];
    const uint32_t *i = p->indices + 3 * f;
    vec3 a = p->positions[i[0]], b = p->positions[i[1]], c = p->positions[i[2]];
    face->degenerate = equal3(a, b) || equal3(a, c) || equal3(b, c);
    face->any = true;
    /* dP = s du + t dv along two edges; the picture's v points up. */
    double du1 = (double)uv[i[1]].x - (double)uv[i[0]].x, dv1 = (double)uv[i[0]].y - (double)uv[i[1]].y;
    double du2 = (double)uv[i[2]].x - (double)uv[i[0]].x, dv2 = (double)uv[i[0]].y - (double)uv[i[2]].y;
    double determinant = du1 * dv2 - du2 * dv1;
    face->preserving = determinant > 0;
    if (fabs(determinant) < 1e-37) return;
    real3 d1 = minus(real(b), real(a)), d2 = minus(real(c), real(a));
    face->s = unit(times(minus(times(d1, dv2), times(d2, dv1)), 1 / determinant));
    face->t = unit(times(minus(times(d2, du1), times(d1, du2)), 1 / determinant));
    face->any = size_of(face->s) < 0.5 || size_of(face->t) < 0.5;
}

static void reference_neighbors(void) {
    for (int f = 0; f < face_count; f++)
        for (int k = 0; k < 3 && !faces[f].degenerate; k++)
            for (int g = f + 1; g < face_count && faces[f].neighbor[k] == NOBODY; g++)
                for (int m = 0; m < 3 && !faces[g].degenerate; m++) {
                    if (faces[g].neighbor[m] != NOBODY || faces[f].neighbor[k] != NOBODY) continue;
                    if (faces[f].weld[k] != faces[g].weld[(m + 1) % 3] || faces[f].weld[(k + 1) % 3] != faces[g].weld[m])
                        continue;
                    faces[f].neighbor[k] = g;
                    faces[g].neighbor[m] = f;
                }
}

static void spread(int f, int group) {
    int k = 0;
    if (f == NOBODY) return;
    struct reference_face *face = &faces[f];
    while (face->weld[k] != group_vertex[group]) k++;
    if (face->group[k] != NOBODY) return;
    if (face->any && face->group[0] == NOBODY && face->group[1] == NOBODY && face->group[2] == NOBODY)
        face->preserving = group_preserving[group];
    if (face->preserving != group_preserving[group]) return;
    face->group[k] = group;
    spread(face->neighbor[k], group);
    spread(face->neighbor[(k + 2) % 3], group);
}

static void reference_groups(void) {
    group_count = 0;
    for (int f = 0; f < face_count; f++)
        for (int k = 0; k < 3; k++) {
            if (faces[f].any || faces[f].degenerate || faces[f].group[k] != NOBODY) continue;
            group_vertex[group_count] = faces[f].weld[k];
            group_preserving[group_count] = faces[f].preserving;
            spread(f, group_count++);
        }
}

static void reference_corner(const struct scene_primitive *p, int f, int k) {
    struct reference_corner *out = &corners[3 * f + k];
    int group = faces[f].group[k];
    *out = (struct reference_corner){.given = group != NOBODY, .group = group};
    if (!out->given) return;
    real3 n = real(p->normals[group_vertex[group]]), sum = {0, 0, 0};
    real3 s = project(faces[f].s, n), t = project(faces[f].t, n);
    double weights = 0;
    out->preserving = group_preserving[group];
    for (int g = 0; g < face_count; g++)
        for (int m = 0; m < 3; m++) {
            if (faces[g].group[m] != group) continue;
            real3 s2 = project(faces[g].s, n), t2 = project(faces[g].t, n);
            bool with = faces[f].any || faces[g].any || f == g || (product(s, s2) > -1 + 1e-6 && product(t, t2) > -1 + 1e-6);
            if (!with) continue;
            out->members += (uint64_t)(g + 1) * (uint64_t)(g + 7919);
            if (faces[g].any) continue;
            const uint32_t *i = p->indices + 3 * g;
            real3 at = real(p->positions[i[m]]);
            real3 e1 = project(minus(real(p->positions[i[(m + 1) % 3]]), at), n),
                  e2 = project(minus(real(p->positions[i[(m + 2) % 3]]), at), n);
            double angle = acos(fmax(-1, fmin(1, product(e1, e2))));
            sum = plus(sum, times(s2, angle));
            weights += angle;
        }
    out->tangent = unit(sum);
    out->clear = size_of(sum) > 1e-3 * fmax(weights, 1e-30) && weights > 1e-3;
}

static void run_reference(const struct scene_primitive *p, const vec2 *uv) {
    face_count = (int)(p->index_count / 3);
    assert_true(face_count <= FACES_MAX);
    for (int f = 0; f < face_count; f++) {
        faces[f] = (struct reference_face){.neighbor = {NOBODY, NOBODY, NOBODY}, .group = {NOBODY, NOBODY, NOBODY}};
        for (int k = 0; k < 3; k++) {
            uint32_t v = p->indices[3 * f + k], first = 0;
            while (!same_vertex(p, uv, first, v)) first++;
            faces[f].weld[k] = (int)first;
        }
        reference_derivatives(p, uv, f);
    }
    reference_neighbors();
    reference_groups();
    for (int f = 0; f < face_count; f++)
        for (int k = 0; k < 3; k++)
            if (!faces[f].degenerate) reference_corner(p, f, k);
    /* Faces without area take what the first other face has at the same vertex. */
    for (int f = 0; f < face_count; f++)
        for (int k = 0; k < 3 && faces[f].degenerate; k++) {
            corners[3 * f + k] = (struct reference_corner){.group = NOBODY};
            for (int c = 0; c < face_count * 3; c++) {
                if (faces[c / 3].degenerate || faces[c / 3].weld[c % 3] != faces[f].weld[k]) continue;
                corners[3 * f + k] = corners[c];
                break;
            }
        }
}

/** How many vertices there must be: each with as many copies as it has different spaces, by their members or, at least, by their
 *  directions; unused ones once. */
static uint32_t reference_vertex_count(const struct scene_primitive *p, bool by_direction) {
    uint32_t count = p->vertex_count;
    for (uint32_t v = 0; v < p->vertex_count; v++) {
        uint32_t spaces = 0;
        for (uint32_t c = 0; c < p->index_count; c++) {
            if (p->indices[c] != v) continue;
            bool fresh = true;
            for (uint32_t d = 0; d < c && fresh; d++) {
                bool same = corners[d].group == corners[c].group && corners[d].members == corners[c].members;
                if (by_direction)
                    same = same || (corners[d].given == corners[c].given && corners[d].preserving == corners[c].preserving &&
                                    size_of(minus(corners[d].tangent, corners[c].tangent)) < 1e-5);
                fresh = p->indices[d] != v || !same;
            }
            spaces += fresh;
        }
        if (spaces > 1) count += spaces - 1;
    }
    return count;
}

/* ---- meshes ---- */

struct mesh {
    uint32_t vertex_count, index_count;
    vec3 positions[FACES_MAX * 3], normals[FACES_MAX * 3];
    vec2 uv[FACES_MAX * 3];
    uint32_t indices[FACES_MAX * 3];
    bool no_normals;
};

static uint32_t vertex(struct mesh *m, vec3 position, vec3 normal, float u, float v) {
    m->positions[m->vertex_count] = position;
    m->normals[m->vertex_count] = vec3_normalize(normal);
    m->uv[m->vertex_count] = (vec2){u, v};
    return m->vertex_count++;
}

static void face(struct mesh *m, uint32_t a, uint32_t b, uint32_t c) {
    m->indices[m->index_count++] = a;
    m->indices[m->index_count++] = b;
    m->indices[m->index_count++] = c;
}

static void quad(struct mesh *m, uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
    face(m, a, b, c);
    face(m, a, c, d);
}

static vec3 v3(float x, float y, float z) { return vec3_make(x, y, z); }
static const vec3 up = {0, 0, 1};

/** A flat corner of a floor, u and v as given. */
static uint32_t flat(struct mesh *m, float x, float y, float u, float v) { return vertex(m, v3(x, y, 0), up, u, v); }

/** A surface over a grid; `place` says where, and what its normal and coordinates are. */
static void grid(struct mesh *m, int columns, int rows, bool shared,
                 void (*place)(float x, float y, vec3 out[2], vec2 *uv)) {
    vec3 at[2];
    vec2 uv;
    uint32_t first = m->vertex_count;
    for (int y = 0; y <= rows && shared; y++)
        for (int x = 0; x <= columns; x++) {
            place((float)x / (float)columns, (float)y / (float)rows, at, &uv);
            vertex(m, at[0], at[1], uv.x, uv.y);
        }
    for (int y = 0; y < rows; y++)
        for (int x = 0; x < columns; x++) {
            uint32_t c[4];
            for (int k = 0; k < 4; k++) {
                int cx = x + (k == 1 || k == 2), cy = y + k / 2;
                c[k] = first + (uint32_t)(cy * (columns + 1) + cx);
                if (shared) continue;
                place((float)cx / (float)columns, (float)cy / (float)rows, at, &uv);
                c[k] = vertex(m, at[0], at[1], uv.x, uv.y);
            }
            quad(m, c[0], c[1], c[2], c[3]);
        }
}

static void place_sphere(float x, float y, vec3 out[2], vec2 *uv) {
    float a = x * 2 * PI, b = y * PI;
    /* The seam and the poles are in one place to the bit, as modelling programs write them. */
    if (x == 1) a = 0;
    float ring = y == 0 || y == 1 ? 0 : sinf(b);
    out[0] = out[1] = v3(ring * cosf(a), cosf(b), -ring * sinf(a));
    *uv = (vec2){x, y};
}
static void place_sphere_of_one_pole(float x, float y, vec3 out[2], vec2 *uv) {
    place_sphere(x, y, out, uv);
    if (y == 0 || y == 1) uv->x = 0.5f;
}
static void place_mirrored_tube(float x, float y, vec3 out[2], vec2 *uv) {
    float a = x == 1 ? 0 : x * 2 * PI;
    out[0] = v3(cosf(a), y * 3, sinf(a));
    out[1] = v3(cosf(a), 0, sinf(a));
    *uv = (vec2){x < 0.5f ? x : 1 - x, y};
}
static void place_torus(float x, float y, vec3 out[2], vec2 *uv) {
    float a = x == 1 ? 0 : x * 2 * PI, b = y == 1 ? 0 : y * 2 * PI;
    out[1] = v3(cosf(a) * cosf(b), sinf(b), sinf(a) * cosf(b));
    out[0] = v3(cosf(a) * 3 + out[1].x, out[1].y, sinf(a) * 3 + out[1].z);
    *uv = (vec2){x * 4, y * 2};
}
static void place_hills(float x, float y, vec3 out[2], vec2 *uv) {
    out[0] = v3(x * 4, sinf(x * 7) * cosf(y * 5), y * 4);
    out[1] = v3(-sinf(x * 9), 2, cosf(y * 3));
    *uv = (vec2){x + 0.3f * sinf(y * 6), y + 0.2f * cosf(x * 11)};
}
static void place_turned_back(float x, float y, vec3 out[2], vec2 *uv) {
    place_hills(x, y, out, uv);
    uv->x = sinf(x * 9); /* mirrored and back, with columns where u stands still */
    if (x > 0.4f && x < 0.6f) uv->x = 0.5f;
}

static void make_cube(struct mesh *m, bool smooth, bool one_picture) {
    for (int axis = 0; axis < 3; axis++)
        for (int side = 0; side < 2; side++) {
            uint32_t c[4];
            for (int k = 0; k < 4; k++) {
                float s = k == 1 || k == 2 ? 1.0f : -1.0f, t = k / 2 ? 1.0f : -1.0f, d = side ? 1.0f : -1.0f;
                float p[3], n[3] = {0, 0, 0};
                p[axis] = d;
                p[(axis + 1) % 3] = side ? s : -s;
                p[(axis + 2) % 3] = t;
                n[axis] = d;
                vec3 at = v3(p[0], p[1], p[2]);
                float u = one_picture ? (p[0] + p[1]) / 4 : (s + 1) / 2,
                      v = one_picture ? (p[1] + p[2] * 2) / 6 : (t + 1) / 2;
                c[k] = vertex(m, at, smooth ? at : v3(n[0], n[1], n[2]), u, v);
            }
            quad(m, c[0], c[1], c[2], c[3]);
        }
}

static void make_fan(struct mesh *m, int count, bool turning) {
    uint32_t center = flat(m, 0, 0, 0, 0);
    for (int i = 0; i < count; i++) {
        float a = 2 * PI * (float)i / (float)count, b = i + 1 == count ? 0 : 2 * PI * (float)(i + 1) / (float)count;
        /* turning: u runs outwards, so that it points everywhere at the centre; else it runs along X. */
        if (turning)
            face(m, center, flat(m, cosf(a), sinf(a), 1, (float)i), flat(m, cosf(b), sinf(b), 1, (float)(i + 1)));
        else
            face(m, center, flat(m, cosf(a), sinf(a), cosf(a), -sinf(a)), flat(m, cosf(b), sinf(b), cosf(b), -sinf(b)));
    }
}

/** Faces on few places, with few coordinates and two normals: much of it degenerate, doubled, mirrored, or with many faces to an edge. */
static void make_tangle(struct mesh *m, uint64_t seed, uint32_t count) {
    struct random_state random = {seed};
    static const vec3 normals[2] = {{0.36f, 0.48f, 0.8f}, {-0.6f, 0.64f, 0.48f}};
    for (uint32_t i = 0; i < 40; i++) {
        float x = (float)(random_bits(&random) % 3), y = (float)(random_bits(&random) % 3),
              z = (float)(random_bits(&random) % 2);
        uint64_t choice = random_bits(&random);
        /* Some coordinates belong to the place, so that faces hang together; -0 is 0. */
        float u = choice % 4 ? x : (float)(choice / 4 % 3), v = choice % 4 ? y : (float)(choice / 12 % 3);
        vertex(m, v3(x, y, choice % 2 && z == 0 ? -0.0f : z), normals[(int)(x + z) % 2], u, v);
    }
    for (uint32_t i = 0; i < count; i++)
        face(m, (uint32_t)(random_bits(&random) % 40), (uint32_t)(random_bits(&random) % 40),
             (uint32_t)(random_bits(&random) % 40));
}

/* ---- comparing ---- */

static void complete(fnl_scene *scene, const struct mesh *m, struct scene_primitive *p) {
    *p = (struct scene_primitive){.vertex_count = m->vertex_count,
                                  .index_count = m->index_count,
                                  .positions = m->positions,
                                  .normals = m->no_normals ? NULL : m->normals,
                                  .uv = {m->uv},
                                  .indices = m->indices};
    assert_int_equal(mesh_complete(&scene->arena, p), FNL_OK);
}

static uint32_t compared, exact;

static void expect_reference(const char *name, const struct mesh *m) {
    fnl_scene *scene;
    assert_int_equal(scene_create(NULL, name, &scene), FNL_OK);
    struct scene_primitive done, given;
    complete(scene, m, &done);
    given = (struct scene_primitive){.vertex_count = m->vertex_count,
                                     .index_count = m->index_count,
                                     .positions = m->positions,
                                     .normals = m->normals,
                                     .indices = m->indices};
    const vec2 *uv = m->uv;
    if (m->no_normals) { /* flat ones first: nothing is shared then */
        struct mesh *soup = calloc(1, sizeof *soup);
        for (uint32_t c = 0; c < m->index_count; c++)
            vertex(soup, m->positions[m->indices[c]], done.normals[done.indices[c]], m->uv[m->indices[c]].x,
                   m->uv[m->indices[c]].y);
        for (uint32_t c = 0; c < m->index_count; c += 3) face(soup, c, c + 1, c + 2);
        expect_reference(name, soup);
        free(soup);
        fnl_scene_destroy(&scene);
        return;
    }
    run_reference(&given, uv);
    assert_int_equal(done.index_count, m->index_count);
    for (uint32_t c = 0; c < m->index_count; c++) {
        uint32_t i = done.indices[c], v = m->indices[c];
        assert_true(i < done.vertex_count);
        assert_true(equal3(done.positions[i], m->positions[v]) && equal3(done.normals[i], m->normals[v]));
        assert_true(done.uv[0][i].x == m->uv[v].x && done.uv[0][i].y == m->uv[v].y);
        const struct reference_corner *expected = &corners[c];
        vec4 t = done.tangents[i];
        real3 got = {(double)t.x, (double)t.y, (double)t.z}, n = real(m->normals[v]), want = expected->tangent;
        if (!(fabs(size_of(got) - 1) < 1e-5 && fabs(product(got, n)) < 1e-4))
            fail_msg("%s: corner %u: (%g %g %g) is no unit vector in the plane", name, c, got.x, got.y, got.z);
        if (!expected->given) want = project((real3){1, 0, 0}, n); /* the method's default, put into the plane */
        if (t.w != (expected->given && expected->preserving ? 1.0f : -1.0f))
            fail_msg("%s: corner %u of face %u has the handedness %g", name, c % 3, c / 3, (double)t.w);
        if (expected->given ? !expected->clear : size_of(want) < 0.5) continue;
        compared++;
        if (size_of(minus(got, want)) > 2e-3)
            fail_msg("%s: corner %u of face %u: (%g %g %g), not (%g %g %g)", name, c % 3, c / 3, got.x, got.y, got.z, want.x,
                     want.y, want.z);
    }
    uint32_t least = reference_vertex_count(&given, true), most = reference_vertex_count(&given, false);
    if (done.vertex_count < least || done.vertex_count > most)
        fail_msg("%s: %u vertices, not %u to %u", name, done.vertex_count, least, most);
    exact += least == most;
    fnl_scene_destroy(&scene);
}

static void make_mesh(struct mesh *m, int number) {
    switch (number) {
    case 0: /* one square */
        quad(m, flat(m, 0, 0, 0, 1), flat(m, 1, 0, 1, 1), flat(m, 1, 1, 1, 0), flat(m, 0, 1, 0, 0));
        break;
    case 1: /* two that share vertices, the second mirrored */
        for (int i = 0; i < 6; i++) flat(m, (float)(i % 3), (float)(i / 3), (float)(i % 3 == 1), (float)(1 - i / 3));
        quad(m, 0, 1, 4, 3);
        quad(m, 1, 2, 5, 4);
        break;
    case 2:
        make_cube(m, false, false);
        break;
    case 3:
        make_cube(m, true, true);
        break;
    case 4:
        grid(m, 16, 9, true, place_sphere);
        break;
    case 5:
        grid(m, 13, 8, false, place_sphere_of_one_pole);
        break;
    case 6:
        grid(m, 16, 3, true, place_mirrored_tube);
        break;
    case 7:
        grid(m, 12, 7, false, place_torus);
        break;
    case 8:
        grid(m, 14, 14, true, place_hills);
        break;
    case 9:
        grid(m, 30, 6, true, place_turned_back);
        break;
    case 10: /* faces that touch at a vertex alone, with directions of their own */
        for (int i = 0; i < 4; i++) {
            float c = cosf((float)i * PI / 2), s = sinf((float)i * PI / 2);
            face(m, i ? 0 : flat(m, 0, 0, 0, 0), flat(m, 2 * c - s, 2 * s + c, (float)(1 + i), 1),
                 flat(m, c - 2 * s, s + 2 * c, (float)i, 2));
        }
        break;
    case 11: /* between a plain and a mirrored face one whose coordinates have no area */
        for (int i = 0; i < 5; i++)
            flat(m, (float)(i * (i % 2 ? 1 : 2)), (float)(i % 2 ? 3 : 0),
                 (float)(i == 1   ? 1
                         : i == 4 ? -1
                                  : i % 2),
                 (float)i);
        face(m, 0, 2, 1);
        face(m, 2, 3, 1);
        face(m, 2, 4, 3);
        m->uv[3] = (vec2){(m->uv[1].x + m->uv[2].x) / 2, (m->uv[1].y + m->uv[2].y) / 2};
        break;
    case 12: /* coordinates without area everywhere */
        grid(m, 3, 3, true, place_hills);
        for (uint32_t i = 0; i < m->vertex_count; i++) m->uv[i] = (vec2){0.25f, 0.75f};
        break;
    case 13: /* a face with two corners in one place, between others, and one alone */
        for (int i = 0; i < 6; i++) flat(m, (float)(i % 3), (float)(i / 3), (float)(i % 3), (float)(i / 3));
        quad(m, 0, 1, 4, 3);
        face(m, 1, 1, 4);
        face(m, 1, flat(m, 1, 0, 5, 5), 4);
        quad(m, 1, 2, 5, 4);
        face(m, flat(m, 7, 7, 0, 0), flat(m, 7, 7, 1, 0), flat(m, 8, 7, 0, 1));
        break;
    case 14: /* corners on one line, with coordinates that have area */
        face(m, flat(m, 0, 0, 0, 0), flat(m, 1, 0, 1, 0), flat(m, 2, 0, 0, 1));
        face(m, 2, 1, flat(m, 1, 2, 3, 1));
        break;
    case 15: /* three faces at an edge, and one that winds the other way */
        for (int i = 0; i < 6; i++)
            vertex(m, v3((float)(i > 1), (float)(i % 2), i > 1 ? (float)(i - 3) : 0), up, (float)(i > 1 ? i - 1 : 0),
                   (float)(i % 2));
        face(m, 0, 2, 1);
        face(m, 1, 3, 0);
        face(m, 0, 4, 1);
        face(m, 0, 1, 5);
        break;
    case 16: /* exactly opposite directions around a vertex, and at right angles to them */
        make_fan(m, 4, true);
        break;
    case 17:
        make_fan(m, 24, true);
        break;
    case 18:
        make_fan(m, 300, false);
        break;
    case 19: /* no normals are given */
        grid(m, 10, 10, true, place_hills);
        m->no_normals = true;
        break;
    case 20:
        make_cube(m, true, false);
        break;
    default:
        make_tangle(m, (uint64_t)number, 30 + (uint32_t)number % 7 * 20);
    }
}

static void test_tangents_are_those_of_the_published_method(void **state) {
    UNUSED(state);
    struct mesh *m = malloc(sizeof *m);
    for (int i = 0; i < 21 + 400; i++) {
        char name[32];
        memset(m, 0, sizeof *m);
        snprintf(name, sizeof name, "mesh %d", i);
        make_mesh(m, i);
        expect_reference(name, m);
        if (i == 20) {
            print_message("%u corners of 21 meshes, %u of them with an exact number of vertices\n", compared, exact);
            assert_true(compared > 5000 && exact >= 19);
        }
    }
    print_message("%u corners, %u meshes\n", compared, exact);
    assert_true(compared > 100000);
    free(m);
}

/** Vertices in another order, and faces turned to another first corner, change no corner's tangent. */
static void test_tangents_do_not_depend_on_how_faces_begin(void **state) {
    UNUSED(state);
    struct mesh *m = malloc(sizeof *m), *turned = malloc(sizeof *turned);
    memset(m, 0, sizeof *m);
    grid(m, 14, 9, true, place_torus);
    *turned = *m;
    for (uint32_t f = 0; f < m->index_count / 3; f++)
        for (uint32_t k = 0; k < 3; k++)
            turned->indices[3 * f + k] = m->vertex_count - 1 - m->indices[3 * f + (k + 1 + f % 2) % 3];
    for (uint32_t v = 0; v < m->vertex_count; v++) {
        uint32_t w = m->vertex_count - 1 - v;
        turned->positions[w] = m->positions[v];
        turned->normals[w] = m->normals[v];
        turned->uv[w] = m->uv[v];
    }
    fnl_scene *scene;
    assert_int_equal(scene_create(NULL, "turned", &scene), FNL_OK);
    struct scene_primitive a, b;
    complete(scene, m, &a);
    complete(scene, turned, &b);
    assert_int_equal(a.vertex_count, b.vertex_count);
    for (uint32_t f = 0; f < m->index_count / 3; f++)
        for (uint32_t k = 0; k < 3; k++) {
            vec4 x = a.tangents[a.indices[3 * f + (k + 1 + f % 2) % 3]], y = b.tangents[b.indices[3 * f + k]];
            assert_true(fabsf(x.x - y.x) + fabsf(x.y - y.y) + fabsf(x.z - y.z) < 1e-5f && x.w == y.w);
        }
    fnl_scene_destroy(&scene);
    free(m);
    free(turned);
}

/**
 * A vertex where many faces meet, or that many groups share, takes no time by the square of that: 9e10 pairs are more than the
 * time that CTest grants. And the memory is no more
 * than mesh_complete_bytes says beforehand, nor far less.
 */
static void test_many_faces_at_a_vertex(void **state) {
    UNUSED(state);
    enum { COUNT = 300000 };
    vec3 *positions = calloc(COUNT * 2 + 1, sizeof *positions), *normals = calloc(COUNT * 2 + 1, sizeof *normals);
    vec2 *uv = calloc(COUNT * 2 + 1, sizeof *uv);
    uint32_t *indices = calloc(COUNT * 3, sizeof *indices);
    for (int kind = 0; kind < 4;
         kind++) { /* a fan whose u runs outwards; faces that share the vertex alone; one edge for all; no normals */
        for (uint32_t i = 0; i <= COUNT * 2; i++) {
            double angle = 6.2831853 * (double)i / (COUNT * 2 + 1);
            positions[i] = i ? v3((float)cos(angle), (float)sin(angle), 0) : v3(0, 0, 0);
            normals[i] = up;
            uv[i] = i ? (vec2){1, (float)i} : (vec2){0, 0};
        }
        for (uint32_t f = 0; f < COUNT; f++) {
            indices[f * 3 + 1] = kind % 3 == 0 ? f + 1 : kind == 1 ? f * 2 + 1 : 1;
            indices[f * 3 + 2] = kind % 3 == 0 ? f + 2 : kind == 1 ? f * 2 + 2 : f + 2;
        }
        fnl_scene *scene;
        struct test_meter meter = {0};
        assert_int_equal(scene_create(&(fnl_host){.user = &meter, .reallocate = test_meter_reallocate}, "fan", &scene), FNL_OK);
        struct scene_primitive p = {.vertex_count = COUNT * 2 + 1,
                                    .index_count = COUNT * 3,
                                    .positions = positions,
                                    .normals = kind == 3 ? NULL : normals,
                                    .uv = {uv},
                                    .indices = indices};
        uint64_t before = meter.held, announced = mesh_complete_bytes(&p);
        assert_int_equal(mesh_complete(&scene->arena, &p), FNL_OK);
        uint64_t taken = meter.peak - before;
        print_message("kind %d: %.1f MB of %.1f MB\n", kind, (double)taken / 1e6, (double)announced / 1e6);
        assert_true(taken <= announced + (1 << 20) && taken >= announced / 4);
        if (kind == 1)
            assert_int_equal(p.vertex_count, COUNT * 2 + 1 + COUNT - 1); /* a copy of the centre for each but one */
        for (uint32_t c = 0; c < p.index_count; c++) {
            vec4 t = p.tangents[p.indices[c]];
            assert_true(fabsf(t.x * t.x + t.y * t.y + t.z * t.z - 1) < 1e-4f);
        }
        fnl_scene_destroy(&scene);
    }
    free(positions);
    free(normals);
    free(uv);
    free(indices);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_tangents_are_those_of_the_published_method),
        cmocka_unit_test(test_tangents_do_not_depend_on_how_faces_begin),
        cmocka_unit_test(test_many_faces_at_a_vertex),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
