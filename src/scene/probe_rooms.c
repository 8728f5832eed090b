/* SPDX-License-Identifier: MIT */
/*
 * Where the rooms of a scene are, for probes. Surfaces that stand still fill cells of a grid that is turned as most walls are. A free cell is indoors where
 * surfaces face it from above, from below and from three sides at least. From the indoor cell that is farthest from any surface a box grows: a face goes on
 * as long as it meets less surface than a wall has, so that furniture and pillars do not stop it, and doors do not let it out. What the box holds is taken;
 * then comes the next room. In the end faces are moved onto the walls that stopped them.
 */
#include "scene/scene.h"

#include <stdlib.h>

enum {
    CELLS = 400000, /* of the grid, about */
    LONGEST = 512,  /* cells along an axis */
    SEEN = 63,      /* bits 0 to 5: the cell has surfaces that face -x, +x, -y, +y, -z, +z */
    INDOORS = 64,
    TAKEN = 128,
    BINS = 48, /* of places near a face of a box */
    ROOMS = 64,
};
#define WALL_PART 0.4f /* the part of a layer of cells that makes it a wall */

struct room {
    uint32_t low[3], high[3]; /* cells; high is the first that it does not have */
    float walls[6][BINS], places[6][BINS]; /* area of surfaces near each face, and area times place */
    float faces[6]; /* where they lie in the end */
    bool even;      /* all on walls */
};

struct rooms {
    const fnl_scene *scene;
    struct box bounds; /* of what is looked at, in the axes of the grid */
    vec3 low;          /* the grid's corner */
    float size, yaw;
    mat4 into; /* from world space into its axes */
    uint32_t n[3];
    uint8_t *cells;
    uint16_t *away; /* cells from the nearest that is not free, corners count as 1 */
    struct room *list;
    uint32_t count;
    float *turns; /* while directions are counted */
};

static const uint32_t axes[3][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}}; /* the axis and the other two */

static size_t cell_count(const struct rooms *r) { return (size_t)r->n[0] * r->n[1] * r->n[2]; }
static size_t cell_at(const struct rooms *r, const uint32_t at[3]) { return ((size_t)at[2] * r->n[1] + at[1]) * r->n[0] + at[0]; }
static bool is_free(uint8_t cell) { return !(cell & (SEEN | TAKEN)); }
static float axis_of(const vec3 *v, uint32_t axis) { return (&v->x)[axis]; }

/* ---- triangles ---- */

struct triangle {
    vec3 p[3], normal; /* unit */
    float area;
    bool both; /* seen from both sides */
};

typedef void visit(struct rooms *r, const struct triangle *t);

static void visit_primitive(struct rooms *r, const struct scene_primitive *p, const mat4 *matrix, visit *what) {
    const bool mirrors = mat4_determinant3(matrix) < 0;
    const bool both = p->material != SCENE_NONE && r->scene->materials.data[p->material].double_sided;
    if (p->topology != SCENE_TOPOLOGY_TRIANGLES || p->morph_target_count) return;
    for (uint32_t i = 0; i + 2 < p->index_count; i += 3) {
        struct triangle t = {.both = both};
        for (uint32_t k = 0; k < 3; k++) t.p[k] = mat4_point(matrix, p->positions[p->indices[i + k]]);
        const vec3 cross = vec3_cross(vec3_sub(t.p[1], t.p[0]), vec3_sub(t.p[2], t.p[0]));
        t.area = 0.5f * vec3_length(cross);
        if (!(t.area > 0) || !isfinite(t.area)) continue;
        t.normal = vec3_scale(cross, (mirrors ? -0.5f : 0.5f) / t.area);
        what(r, &t);
    }
}

/* Of all that is shown and does not deform, in the axes of the grid. */
static void visit_all(struct rooms *r, visit *what) {
    for (uint32_t n = 0; n < r->scene->nodes.count; n++) {
        const struct scene_node *node = &r->scene->nodes.data[n];
        if (!scene_node_draws(node) || node->staged || node->skin != SCENE_NONE) continue;
        const struct scene_mesh *mesh = &r->scene->meshes.data[node->mesh];
        for (uint32_t k = 0; k < node->instance_count; k++) {
            const mat4 world = scene_instance_world(r->scene, node, k), matrix = mat4_mul(r->into, world);
            for (uint32_t i = 0; i < mesh->primitive_count; i++)
                visit_primitive(r, &r->scene->primitives.data[mesh->first_primitive + i], &matrix, what);
        }
    }
}

/* ---- the grid ---- */

enum { TURNS = 180 }; /* half degrees, of a quarter turn */

static void count_turn(struct rooms *r, const struct triangle *t) {
    if (fabsf(t->normal.y) > 0.2f) return;
    float turn = atan2f(-t->normal.z, t->normal.x) / (PI / 2);
    turn = (turn - floorf(turn)) * TURNS;
    const uint32_t bin = (uint32_t)(turn + 0.5f);
    r->turns[bin % TURNS] += t->area;
    r->turns[TURNS + bin % TURNS] += t->area * (turn - (float)bin);
}

/* The direction of most walls; that of the world's axes where about as many have it. */
static float find_yaw(struct rooms *r) {
    float turns[2 * TURNS] = {0}, sums[TURNS]; /* areas, and area times how far from the middle of its bin */
    uint32_t most = 0;
    r->turns = turns;
    visit_all(r, count_turn);
    for (uint32_t i = 0; i < TURNS; i++) {
        sums[i] = turns[(i + TURNS - 1) % TURNS] + turns[i] + turns[(i + 1) % TURNS];
        if (sums[i] > sums[most]) most = i;
    }
    if (sums[0] >= 0.5f * sums[most]) return 0;
    const uint32_t before = (most + TURNS - 1) % TURNS, after = (most + 1) % TURNS;
    const float off = turns[after] - turns[before] + turns[TURNS + before] + turns[TURNS + most] + turns[TURNS + after];
    return ((float)most + off / sums[most]) / TURNS * (PI / 2);
}

static void add_bounds(struct rooms *r, const struct triangle *t) {
    for (uint32_t k = 0; k < 3; k++) box_add_point(&r->bounds, t->p[k]);
}

static fnl_result make_grid(struct rooms *r) {
    r->bounds = box_empty();
    visit_all(r, add_bounds);
    if (box_is_empty(&r->bounds) || !vec3_finite(r->bounds.low) || !vec3_finite(r->bounds.high)) return FNL_OK;
    const vec3 extent = vec3_sub(r->bounds.high, r->bounds.low);
    const float longest = fmaxf(extent.x, fmaxf(extent.y, extent.z));
    if (!(longest > 0) || !(longest < 1e12f)) return FNL_OK;
    const double volume = fmax((double)extent.x, 1e-3 * (double)longest) * fmax((double)extent.y, 1e-3 * (double)longest) * fmax((double)extent.z, 1e-3 * (double)longest);
    r->size = fmaxf((float)cbrt(volume / CELLS), longest / (LONGEST - 4));
    for (uint32_t k = 0; k < 3; k++) { /* a cell and a half around all; outer walls are not on borders of cells */
        r->n[k] = (uint32_t)(axis_of(&extent, k) / r->size) + 4;
        (&r->low.x)[k] = axis_of(&r->bounds.low, k) - 1.37f * r->size;
    }
    r->cells = host_allocate_zero(&r->scene->host, cell_count(r));
    r->away = host_allocate(&r->scene->host, cell_count(r) * sizeof *r->away);
    return r->cells && r->away ? FNL_OK : FNL_ERROR_MEMORY;
}

/* Whether a direction parts a triangle from the cell around the origin with this half size; the triangle is given from there. */
static bool parts(vec3 axis, const vec3 p[3], float half) {
    const float a = vec3_dot(axis, p[0]), b = vec3_dot(axis, p[1]), c = vec3_dot(axis, p[2]);
    const float reach = half * (fabsf(axis.x) + fabsf(axis.y) + fabsf(axis.z));
    return fminf(a, fminf(b, c)) > reach || fmaxf(a, fmaxf(b, c)) < -reach;
}

/* Akenine-Moeller, "Fast 3D Triangle-Box Overlap Testing", 2001; the cell's own axes are the caller's. */
static bool touches(const struct triangle *t, vec3 centre, float half) {
    static const vec3 units[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    vec3 p[3];
    for (uint32_t k = 0; k < 3; k++) p[k] = vec3_sub(t->p[k], centre);
    if (parts(t->normal, p, half)) return false;
    for (uint32_t edge = 0; edge < 3; edge++)
        for (uint32_t k = 0; k < 3; k++)
            if (parts(vec3_cross(units[k], vec3_sub(p[(edge + 1) % 3], p[edge])), p, half)) return false;
    return true;
}

static uint32_t cell_of(const struct rooms *r, float place, uint32_t axis) {
    return (uint32_t)CLAMP((place - axis_of(&r->low, axis)) / r->size, 0.0f, (float)(r->n[axis] - 1));
}

static void fill_cells(struct rooms *r, const struct triangle *t) {
    uint32_t low[3], high[3], at[3];
    uint8_t seen = 0;
    for (uint32_t k = 0; k < 3; k++) {
        low[k] = cell_of(r, fminf(axis_of(&t->p[0], k), fminf(axis_of(&t->p[1], k), axis_of(&t->p[2], k))), k);
        high[k] = cell_of(r, fmaxf(axis_of(&t->p[0], k), fmaxf(axis_of(&t->p[1], k), axis_of(&t->p[2], k))), k);
        const float facing = axis_of(&t->normal, k);
        if (facing < -0.2f || (t->both && facing > 0.2f)) seen |= (uint8_t)(1u << (2 * k));
        if (facing > 0.2f || (t->both && facing < -0.2f)) seen |= (uint8_t)(2u << (2 * k));
    }
    for (at[2] = low[2]; at[2] <= high[2]; at[2]++)
        for (at[1] = low[1]; at[1] <= high[1]; at[1]++)
            for (at[0] = low[0]; at[0] <= high[0]; at[0]++) {
                const vec3 centre = {r->low.x + ((float)at[0] + 0.5f) * r->size, r->low.y + ((float)at[1] + 0.5f) * r->size,
                                     r->low.z + ((float)at[2] + 0.5f) * r->size};
                if (touches(t, centre, 0.5f * r->size)) r->cells[cell_at(r, at)] |= seen;
            }
}

/* Marks the free cells that are indoors; returns how many there are. */
static uint64_t find_indoors(struct rooms *r, uint8_t *met) {
    for (uint32_t k = 0; k < 3; k++) {
        const uint32_t u = axes[k][1], v = axes[k][2];
        uint32_t at[3];
        for (at[u] = 0; at[u] < r->n[u]; at[u]++)
            for (at[v] = 0; at[v] < r->n[v]; at[v]++)
                for (uint32_t back = 0; back < 2; back++) { /* a surface behind faces +k; coming from the other end, -k */
                    const uint8_t bit = (uint8_t)((back ? 1u : 2u) << (2 * k));
                    bool meets = false;
                    for (uint32_t i = 0; i < r->n[k]; i++) {
                        at[k] = back ? r->n[k] - 1 - i : i;
                        const size_t cell = cell_at(r, at);
                        if (r->cells[cell] & SEEN) meets = (r->cells[cell] & bit) != 0;
                        else if (meets) met[cell] |= bit;
                    }
                }
    }
    uint64_t count = 0;
    for (size_t i = 0; i < cell_count(r); i++) {
        const uint32_t sides = (met[i] & 1u) + (met[i] >> 1 & 1u) + (met[i] >> 4 & 1u) + (met[i] >> 5 & 1u);
        if (r->cells[i] & SEEN || (met[i] & 12) != 12 || sides < 3) continue;
        r->cells[i] |= INDOORS;
        count++;
    }
    return count;
}

/* ---- rooms ---- */

/* In two passes over the grid, which see all neighbours. */
static void find_away(struct rooms *r) {
    for (uint32_t back = 0; back < 2; back++) {
        const size_t count = cell_count(r);
        for (size_t i = 0; i < count; i++) {
            const size_t cell = back ? count - 1 - i : i;
            const uint32_t at[3] = {(uint32_t)(cell % r->n[0]), (uint32_t)(cell / r->n[0] % r->n[1]), (uint32_t)(cell / r->n[0] / r->n[1])};
            uint32_t least = is_free(r->cells[cell]) ? back ? r->away[cell] : 0xfffe : 0;
            bool border = false;
            for (uint32_t k = 0; k < 3; k++) border |= at[k] == 0 || at[k] + 1 == r->n[k];
            if (border) least = MIN(least, 1);
            for (int32_t z = -1; z <= 0 && !border && least > 0; z++)
                for (int32_t y = -1; y <= (z ? 1 : 0); y++)
                    for (int32_t x = -1; x <= (z || y ? 1 : -1); x++) { /* the 13 before it */
                        const int64_t step = ((int64_t)z * r->n[1] + y) * r->n[0] + x;
                        least = MIN(least, r->away[(int64_t)cell + (back ? -step : step)] + 1u);
                    }
            r->away[cell] = (uint16_t)least;
        }
    }
}

/* Whether a face of the box can go on into the next layer of cells. */
static bool goes_on(const struct rooms *r, const struct room *room, uint32_t face) {
    const uint32_t k = face / 2, u = axes[k][1], v = axes[k][2];
    uint32_t at[3], full = 0, indoors = 0, count = 0;
    if (face % 2 ? room->high[k] >= r->n[k] : room->low[k] == 0) return false;
    at[k] = face % 2 ? room->high[k] : room->low[k] - 1;
    for (at[u] = room->low[u]; at[u] < room->high[u]; at[u]++)
        for (at[v] = room->low[v]; at[v] < room->high[v]; at[v]++) {
            const uint8_t cell = r->cells[cell_at(r, at)];
            full += !is_free(cell);
            indoors += is_free(cell) && cell & INDOORS;
            count++;
        }
    return (float)full < WALL_PART * (float)count && 2 * indoors >= count - full;
}

static void grow(const struct rooms *r, struct room *room) {
    for (bool grown = true; grown;) { /* a face that something small stops goes on once the others have */
        grown = false;
        for (uint32_t face = 0; face < 6; face++) {
            if (!goes_on(r, room, face)) continue;
            if (face % 2) room->high[face / 2]++;
            else room->low[face / 2]--;
            grown = true;
        }
    }
}

/* Takes its cells; returns how many of them are indoors. */
static uint64_t take(struct rooms *r, const struct room *room) {
    uint64_t count = 0;
    uint32_t at[3];
    for (at[2] = room->low[2]; at[2] < room->high[2]; at[2]++)
        for (at[1] = room->low[1]; at[1] < room->high[1]; at[1]++)
            for (at[0] = room->low[0]; at[0] < room->high[0]; at[0]++) {
                uint8_t *cell = &r->cells[cell_at(r, at)];
                count += is_free(*cell) && *cell & INDOORS;
                *cell |= TAKEN;
            }
    return count;
}

static uint64_t volume_of(const struct room *room) {
    return (uint64_t)(room->high[0] - room->low[0]) * (room->high[1] - room->low[1]) * (room->high[2] - room->low[2]);
}

static int by_volume(const void *a, const void *b) { /* largest first */
    const struct room *x = a, *y = b;
    const uint64_t large = volume_of(x), small = volume_of(y);
    return large != small ? (large > small ? -1 : 1) : memcmp(x->low, y->low, sizeof x->low);
}

static void find_rooms(struct rooms *r, uint64_t indoors) {
    enum { LEAST = 3, TRIES = 2 * ROOMS }; /* cells on a side; boxes */
    for (uint32_t tries = 0; tries < TRIES && r->count < ROOMS; tries++) {
        size_t start = 0;
        find_away(r);
        for (size_t i = 0; i < cell_count(r); i++)
            if (r->cells[i] & INDOORS && is_free(r->cells[i]) && (!(r->cells[start] & INDOORS) || !is_free(r->cells[start]) || r->away[i] > r->away[start]))
                start = i;
        if (!(r->cells[start] & INDOORS) || !is_free(r->cells[start]) || r->away[start] < 2) return;
        const uint32_t at[3] = {(uint32_t)(start % r->n[0]), (uint32_t)(start / r->n[0] % r->n[1]), (uint32_t)(start / r->n[0] / r->n[1])};
        const uint32_t reach = r->away[start] - 1u;
        struct room *room = &r->list[r->count];
        *room = (struct room){.even = true};
        for (uint32_t k = 0; k < 3; k++) {
            room->low[k] = at[k] - MIN(reach, at[k]);
            room->high[k] = MIN(at[k] + reach + 1, r->n[k]);
        }
        grow(r, room);
        bool large = true;
        for (uint32_t k = 0; k < 3; k++) large &= room->high[k] - room->low[k] >= LEAST;
        const uint64_t own = take(r, room);
        r->count += large && own * 50 >= indoors; /* a cupboard is no room */
    }
}

/* ---- walls ---- */

static float face_place(const struct rooms *r, const struct room *room, uint32_t face) {
    const uint32_t k = face / 2;
    return axis_of(&r->low, k) + (float)(face % 2 ? room->high[k] : room->low[k]) * r->size;
}

/* The part of a triangle's area that lies over a face of a box, by their bounds. */
static float area_over(const struct rooms *r, const struct room *room, uint32_t k, const struct triangle *t) {
    float part = t->area;
    for (uint32_t i = 1; i < 3; i++) {
        const uint32_t axis = axes[k][i];
        const float a = axis_of(&t->p[0], axis), b = axis_of(&t->p[1], axis), c = axis_of(&t->p[2], axis);
        const float low = fminf(a, fminf(b, c)), high = fmaxf(a, fmaxf(b, c)), from = face_place(r, room, 2 * axis), to = face_place(r, room, 2 * axis + 1);
        part *= high > low ? CLAMP((fminf(high, to) - fmaxf(low, from)) / (high - low), 0.0f, 1.0f) : 0;
    }
    return part;
}

/* Surfaces that lie as a face does, look into the box, and are within a cell and a half of the face. Places count from there outwards. */
static void find_walls(struct rooms *r, const struct triangle *t) {
    uint32_t k = 0;
    while (k < 3 && fabsf(axis_of(&t->normal, k)) < 0.98f) k++;
    if (k == 3) return;
    const float place = (axis_of(&t->p[0], k) + axis_of(&t->p[1], k) + axis_of(&t->p[2], k)) / 3;
    for (uint32_t i = 0; i < r->count; i++)
        for (uint32_t high = 0; high < 2; high++) {
            struct room *room = &r->list[i];
            const uint32_t face = 2 * k + high;
            const float out = (place - face_place(r, room, face)) * (high ? 1 : -1) / r->size;
            if (out < -1.5f || out >= 1.5f || (!t->both && (axis_of(&t->normal, k) > 0) == high)) continue;
            const float area = area_over(r, room, k, t);
            const uint32_t bin = (uint32_t)((out + 1.5f) / 3 * BINS) % BINS;
            room->walls[face][bin] += area;
            room->places[face][bin] += area * place;
        }
}

/* The innermost place at which a good part of the face has a wall; false: there is none, it is uneven. */
static bool settle_face(const struct rooms *r, const struct room *room, uint32_t face, float *out) {
    const uint32_t k = face / 2, u = axes[k][1], v = axes[k][2];
    const float whole = (float)(room->high[u] - room->low[u]) * (float)(room->high[v] - room->low[v]) * r->size * r->size;
    *out = face_place(r, room, face);
    for (uint32_t bin = 0; bin + 1 < BINS; bin++) { /* a wall may lie on the border of two */
        const float area = room->walls[face][bin] + room->walls[face][bin + 1];
        if (area < 0.25f * whole) continue;
        *out = (room->places[face][bin] + room->places[face][bin + 1]) / area;
        return true;
    }
    return false;
}

/* An indoor cell without surfaces in it or beside it. The grid's border has no such cells. */
static bool is_clear(const struct rooms *r, const uint32_t at[3]) {
    const size_t cell = cell_at(r, at), steps[3] = {1, r->n[0], (size_t)r->n[0] * r->n[1]};
    if (!(r->cells[cell] & INDOORS)) return false;
    for (uint32_t k = 0; k < 3; k++)
        if (at[k] == 0 || at[k] + 1 == r->n[k] || (r->cells[cell - steps[k]] | r->cells[cell + steps[k]]) & SEEN) return false;
    return true;
}

/* From where the room is seen: its middle, or the free cell that is nearest to it. */
static vec3 find_capture(const struct rooms *r, const struct room *room, vec3 middle) {
    vec3 best = middle;
    float least = FLT_MAX;
    uint32_t at[3];
    for (at[2] = room->low[2]; at[2] < room->high[2]; at[2]++)
        for (at[1] = room->low[1]; at[1] < room->high[1]; at[1]++)
            for (at[0] = room->low[0]; at[0] < room->high[0]; at[0]++) {
                if (!is_clear(r, at)) continue;
                const vec3 centre = {r->low.x + ((float)at[0] + 0.5f) * r->size, r->low.y + ((float)at[1] + 0.5f) * r->size,
                                     r->low.z + ((float)at[2] + 0.5f) * r->size};
                const float far = vec3_distance(centre, middle);
                if (far >= least) continue;
                least = far;
                best = centre;
            }
    return least < r->size ? middle : best;
}

/* Half of the thickest wall to another room, of those up to a metre: that far rooms reach into their doorways, which meet in the middle; but not through
 * any wall. 0: there is none. */
static float half_wall(const struct rooms *r, const struct room *room) {
    float thinnest = 1, thickest = 0;
    for (uint32_t i = 0; i < r->count; i++)
        for (uint32_t k = 0; k < 3; k++) {
            const struct room *other = &r->list[i];
            const float gap = fmaxf(other->faces[2 * k] - room->faces[2 * k + 1], room->faces[2 * k] - other->faces[2 * k + 1]);
            bool beside = other != room && gap > 0 && gap <= 1;
            for (uint32_t axis = 0; axis < 3; axis++)
                beside &= axis == k || (other->faces[2 * axis] < room->faces[2 * axis + 1] && room->faces[2 * axis] < other->faces[2 * axis + 1]);
            if (!beside) continue;
            thinnest = fminf(thinnest, gap);
            thickest = fmaxf(thickest, gap);
        }
    return fminf(thickest / 2, 0.8f * thinnest);
}

static fnl_probe_params probe_of(const struct rooms *r, const struct room *room, const fnl_probe_params *params) {
    fnl_probe_params out = *params;
    const float *faces = room->faces;
    const vec3 low = {faces[0], faces[2], faces[4]}, high = {faces[1], faces[3], faces[5]}, middle = vec3_scale(vec3_add(low, high), 0.5f);
    const vec3 half = vec3_scale(vec3_sub(high, low), 0.5f), capture = vec3_sub(find_capture(r, room, middle), middle);
    mat4 back;
    mat4_inverse(&r->into, &back);
    out.centre = mat4_point(&back, middle);
    out.half_size = half;
    out.rotation = quat_axis_angle(vec3_make(0, 1, 0), r->yaw);
    out.capture = vec3_max(vec3_scale(half, -1), vec3_min(half, capture));
    out.wall = fmaxf(out.wall, fmaxf(room->even ? 0 : 1.5f * r->size, half_wall(r, room)));
    return out;
}

static fnl_result find_all(struct rooms *r, uint32_t most) {
    r->into = mat4_identity();
    r->yaw = find_yaw(r);
    r->into = mat4_from_trs(vec3_make(0, 0, 0), quat_axis_angle(vec3_make(0, 1, 0), -r->yaw), vec3_make(1, 1, 1));
    TRY(make_grid(r));
    if (!r->cells) return FNL_OK;
    uint8_t *met = host_allocate_zero(&r->scene->host, cell_count(r));
    if (!met) return FNL_ERROR_MEMORY;
    visit_all(r, fill_cells);
    const uint64_t indoors = find_indoors(r, met);
    host_free(&r->scene->host, met, cell_count(r));
    if (indoors == 0) return FNL_OK;
    find_rooms(r, indoors);
    if (r->count) qsort(r->list, r->count, sizeof *r->list, by_volume);
    r->count = MIN(r->count, most);
    visit_all(r, find_walls);
    for (uint32_t i = 0; i < r->count; i++)
        for (uint32_t face = 0; face < 6; face++) r->list[i].even &= settle_face(r, &r->list[i], face, &r->list[i].faces[face]);
    return FNL_OK;
}

static fnl_result add_probes(fnl_scene *scene, const struct rooms *r, const fnl_probe_params *params, uint32_t *out_count) {
    fnl_probe_id id;
    fnl_probe_params probe = *params;
    for (uint32_t i = 0; i < r->count; i++, ++*out_count) {
        probe = probe_of(r, &r->list[i], params);
        TRY(fnl_scene_add_probe(scene, &probe, &id));
    }
    const struct box bounds = scene_bounds(scene);
    if (r->count > 0 || box_is_empty(&bounds)) return FNL_OK;
    probe.centre = vec3_scale(vec3_add(bounds.low, bounds.high), 0.5f);
    probe.half_size = vec3_scale(vec3_sub(bounds.high, bounds.low), 0.5f);
    probe.rotation = quat_identity();
    probe.capture = vec3_make(0, 0, 0);
    if (!(probe.half_size.x > 0 && probe.half_size.y > 0 && probe.half_size.z > 0)) return FNL_OK;
    *out_count = 1;
    return fnl_scene_add_probe(scene, &probe, &id);
}

fnl_result fnl_scene_place_probes(fnl_scene *scene, const fnl_probe_params *given, uint32_t most, uint32_t *out_count) {
    if (out_count) *out_count = 0;
    TRY(check_handle(__func__, "scene", scene));
    const struct call *call = CALL(&scene->host);
    fnl_probe_params params = given ? *given : fnl_probe_params_default();
    uint32_t count = 0;
    params.centre = params.capture = vec3_make(0, 0, 0);
    params.half_size = vec3_make(1, 1, 1);
    params.rotation = quat_identity();
    TRY(scene_check_probe(call, &params));
    TRY(check_count(call, "most", most, 1, ROOMS));
    struct rooms r = {.scene = scene};
    r.list = host_allocate(&scene->host, ROOMS * sizeof *r.list);
    if (!r.list) return FNL_ERROR_MEMORY;
    fnl_result result = find_all(&r, most);
    if (result == FNL_OK) result = add_probes(scene, &r, &params, &count);
    host_free(&scene->host, r.list, ROOMS * sizeof *r.list);
    if (r.cells) host_free(&scene->host, r.cells, cell_count(&r));
    if (r.away) host_free(&scene->host, r.away, cell_count(&r) * sizeof *r.away);
    if (out_count) *out_count = count;
    return result;
}
