/* SPDX-License-Identifier: MIT */
/*
 * Tangents as glTF 2.0 (3.7.2.1) asks for them: those of M. S. Mikkelsen, "Simulation of Wrinkled Surfaces Revisited"
 * (2008), with what has become of them in practice. Faces around a vertex are a group as far as they hang together by edges
 * and show the picture the same way round; a group's corners get the mean of its faces' directions, weighted by the corners'
 * angles. Vertices that several groups use are split. docs/techniques/materials.md names what differs.
 */
#include "scene/mesh_build.h"

#define NONE UINT32_MAX
#define PENDING (UINT32_MAX - 1)

/** Directions this close to opposite are not averaged: their sum would be noise. */
#define OPPOSITE (-1 + 1e-6f)
/** Of the faces of a larger group no pairs are compared: the time would grow with its square. */
#define PAIRS_MAX 256u

struct face {
    vec3 u, v;            /* directions in which u and v grow, unit */
    uint32_t neighbor[3]; /* the face across the edge from corner k to the next, or NONE */
    bool mirrored;        /* the picture shows mirrored */
    bool open;            /* it has no directions, and joins the first group that reaches it */
    bool degenerate;      /* two corners are in one place: it takes no part */
};

struct member {
    uint32_t corner;
    vec3 u, v; /* in the plane of the normal; 0 for open faces */
    float angle;
    bool open;
};

struct work {
    const fnl_host *host;
    const struct scene_primitive *primitive;
    const vec2 *uv;
    uint32_t face_count;
    uint32_t *weld; /* per vertex: the first with its position, normal and uv */
    struct face *faces;
    uint32_t *space;    /* per corner: of `spaces`, or NONE */
    ARRAY(vec4) spaces; /* tangent and handedness */
    ARRAY(struct member) group;
};

/* ---- vertices that are one ---- */

struct weld_key {
    float v[8];
};

static struct weld_key weld_key(const struct scene_primitive *p, const vec2 *uv, uint32_t i) {
    vec3 a = p->positions[i], n = p->normals[i];
    /* + 0 turns the negative zero into the positive one: equal keys have equal bytes. */
    return (struct weld_key){{a.x + 0, a.y + 0, a.z + 0, n.x + 0, n.y + 0, n.z + 0, uv[i].x + 0, uv[i].y + 0}};
}

static fnl_result weld_vertices(struct work *w) {
    const struct scene_primitive *p = w->primitive;
    uint64_t slots = 16;
    while (slots < (uint64_t)p->vertex_count * 2) slots *= 2;
    uint32_t *table = host_allocate(w->host, sizeof(uint32_t) * (size_t)slots);
    if (!table) return FNL_ERROR_MEMORY;
    memset(table, 0xff, sizeof(uint32_t) * (size_t)slots);
    for (uint32_t i = 0; i < p->vertex_count; i++) {
        struct weld_key key = weld_key(p, w->uv, i);
        uint64_t slot = hash_bytes(&key, sizeof key, HASH_SEED) & (slots - 1);
        for (; table[slot] != NONE; slot = (slot + 1) & (slots - 1)) {
            struct weld_key other = weld_key(p, w->uv, table[slot]);
            if (memcmp(&key, &other, sizeof key) == 0) break;
        }
        if (table[slot] == NONE) table[slot] = i;
        w->weld[i] = table[slot];
    }
    host_free(w->host, table, sizeof(uint32_t) * (size_t)slots);
    return FNL_OK;
}

static uint32_t corner_weld(const struct work *w, uint32_t corner) { return w->weld[w->primitive->indices[corner]]; }

/* ---- faces ---- */

static bool same_place(vec3 a, vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

/** v runs down in glTF's pictures and up in the paper, hence its sign. */
static void set_directions(const struct work *w, uint32_t f) {
    const uint32_t *i = w->primitive->indices + 3 * (size_t)f;
    const vec3 *p = w->primitive->positions;
    struct face *face = &w->faces[f];
    face->open = true;
    face->degenerate = same_place(p[i[0]], p[i[1]]) || same_place(p[i[0]], p[i[2]]) || same_place(p[i[1]], p[i[2]]);
    vec3 e1 = vec3_sub(p[i[1]], p[i[0]]), e2 = vec3_sub(p[i[2]], p[i[0]]);
    vec2 t0 = w->uv[i[0]], t1 = w->uv[i[1]], t2 = w->uv[i[2]];
    float u1 = t1.x - t0.x, v1 = t0.y - t1.y, u2 = t2.x - t0.x, v2 = t0.y - t2.y;
    float area = u1 * v2 - u2 * v1;
    face->mirrored = !(area > 0);
    if (!(fabsf(area) > FLT_MIN)) return;
    float sign = face->mirrored ? -1.0f : 1.0f;
    face->u = vec3_scale(vec3_normalize(vec3_sub(vec3_scale(e1, v2), vec3_scale(e2, v1))), sign);
    face->v = vec3_scale(vec3_normalize(vec3_sub(vec3_scale(e2, u1), vec3_scale(e1, u2))), sign);
    face->open = !(vec3_dot(face->u, face->u) > 0.5f && vec3_dot(face->v, face->v) > 0.5f);
}

struct edge {
    uint32_t other, corner; /* the greater of its two welded vertices; the corner that it leads away from */
};

static int compare_edges(const void *a, const void *b) {
    const struct edge *x = a, *y = b;
    if (x->other != y->other) return x->other < y->other ? -1 : 1;
    return x->corner < y->corner ? -1 : x->corner > y->corner;
}

/**
 * Two faces are neighbours across an edge that they run through in opposite directions. Of more than two at an edge, each
 * takes the first that is left, in the order of the faces. `edges` are those between two vertices, in that order.
 */
static void pair_edges(const struct work *w, const struct edge *edges, uint32_t count, uint32_t from) {
    uint32_t waiting = 0; /* the first without a neighbour; all that wait run the same way */
    for (uint32_t i = 0; i < count; i++) {
        uint32_t corner = edges[i].corner;
        while (waiting < i && w->faces[edges[waiting].corner / 3].neighbor[edges[waiting].corner % 3] != NONE) waiting++;
        uint32_t other = edges[waiting].corner;
        if (waiting == i || (corner_weld(w, corner) == from) == (corner_weld(w, other) == from)) continue;
        w->faces[corner / 3].neighbor[corner % 3] = other / 3;
        w->faces[other / 3].neighbor[other % 3] = corner / 3;
    }
}

static uint32_t next_corner(uint32_t corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; }
static uint32_t last_corner(uint32_t corner) { return corner % 3 == 0 ? corner + 2 : corner - 1; }

/** Edges are put in order by the lesser of their two vertices, then by the greater. */
static fnl_result find_neighbors(struct work *w) {
    uint32_t vertex_count = w->primitive->vertex_count, corner_count = w->face_count * 3;
    size_t start_size = sizeof(uint32_t) * ((size_t)vertex_count + 2),
           edge_size = sizeof(struct edge) * (size_t)corner_count;
    uint32_t *start = host_allocate_zero(w->host, start_size);
    struct edge *edges = host_allocate(w->host, edge_size);
    for (uint32_t c = 0; start && edges && c < corner_count; c++) {
        w->faces[c / 3].neighbor[c % 3] = NONE;
        if (w->faces[c / 3].degenerate) continue;
        uint32_t a = corner_weld(w, c), b = corner_weld(w, next_corner(c));
        start[MIN(a, b) + 2]++;
    }
    for (uint32_t i = 0; start && edges && i < vertex_count; i++) start[i + 2] += start[i + 1];
    for (uint32_t c = 0; start && edges && c < corner_count; c++) {
        if (w->faces[c / 3].degenerate) continue;
        uint32_t a = corner_weld(w, c), b = corner_weld(w, next_corner(c));
        edges[start[MIN(a, b) + 1]++] = (struct edge){MAX(a, b), c};
    }
    for (uint32_t i = 0; start && edges && i < vertex_count; i++) {
        uint32_t first = start[i], end = start[i + 1];
        qsort(edges + first, end - first, sizeof *edges, compare_edges);
        for (uint32_t run = first, next; run < end; run = next) {
            for (next = run + 1; next < end && edges[next].other == edges[run].other;) next++;
            pair_edges(w, edges + run, next - run, i);
        }
    }
    bool good = start && edges;
    host_free(w->host, start, start_size);
    host_free(w->host, edges, edge_size);
    return good ? FNL_OK : FNL_ERROR_MEMORY;
}

/* ---- groups ---- */

static vec3 on_plane(vec3 v, vec3 n) { return vec3_normalize(vec3_sub(v, vec3_scale(n, vec3_dot(v, n)))); }

static bool add_member(struct work *w, uint32_t corner, vec3 n) {
    const struct face *face = &w->faces[corner / 3];
    const vec3 *p = w->primitive->positions;
    const uint32_t *i = w->primitive->indices;
    vec3 at = p[i[corner]];
    vec3 e1 = on_plane(vec3_sub(p[i[next_corner(corner)]], at), n),
         e2 = on_plane(vec3_sub(p[i[last_corner(corner)]], at), n);
    struct member member = {.corner = corner, .open = face->open};
    if (!face->open) {
        member.u = on_plane(face->u, n);
        member.v = on_plane(face->v, n);
        member.angle = acosf(CLAMP(vec3_dot(e1, e2), -1.0f, 1.0f));
    }
    w->space[corner] = PENDING;
    return array_push(w->host, &w->group, member);
}

/** Goes round the vertex from face to face, across the edges that lead away from it (forward) or to it. */
static bool walk(struct work *w, uint32_t corner, bool mirrored, bool forward, vec3 n) {
    uint32_t vertex = corner_weld(w, corner);
    for (;;) {
        uint32_t edge = forward ? corner : last_corner(corner), f = w->faces[edge / 3].neighbor[edge % 3];
        if (f == NONE) return true;
        struct face *face = &w->faces[f];
        corner = 3 * f;
        while (corner_weld(w, corner) != vertex) corner++;
        if (w->space[corner] != NONE) return true;
        /* The first group that reaches an open face says which way round it shows. */
        const uint32_t *spaces = &w->space[3 * (size_t)f];
        if (face->open && spaces[0] == NONE && spaces[1] == NONE && spaces[2] == NONE) face->mirrored = mirrored;
        if (face->mirrored != mirrored) return true;
        if (!add_member(w, corner, n)) return false;
    }
}

static bool add_space(struct work *w, vec3 sum, vec3 n, bool mirrored) {
    vec3 t = vec3_normalize(sum);
    if (!(vec3_dot(t, t) > 0.5f)) t = vec3_perpendicular(vec3_dot(n, n) > 0.5f ? n : vec3_make(0, 1, 0));
    return array_push(w->host, &w->spaces, vec4_make(t.x, t.y, t.z, mirrored ? -1.0f : 1.0f));
}

/** Whether no two members can be opposite: all are on one side of their mean. */
static bool is_plain(const struct work *w, vec3 u_sum, vec3 v_sum) {
    for (uint32_t i = 0; i < w->group.count; i++) {
        const struct member *m = &w->group.data[i];
        if (!m->open && !(vec3_dot(m->u, u_sum) > 0 && vec3_dot(m->v, v_sum) > 0)) return false;
    }
    return true;
}

static bool are_opposite(const struct member *a, const struct member *b) {
    return !a->open && !b->open && (vec3_dot(a->u, b->u) <= OPPOSITE || vec3_dot(a->v, b->v) <= OPPOSITE);
}

/** Gives the members of the group their spaces: one, but for faces that are opposite to others. */
static bool finish_group(struct work *w, vec3 n, bool mirrored) {
    const struct member *members = w->group.data;
    uint32_t count = w->group.count, first = w->spaces.count;
    vec3 sum = {0, 0, 0}, u_sum = sum, v_sum = sum;
    for (uint32_t i = 0; i < count; i++) {
        sum = vec3_add_scaled(sum, members[i].u, members[i].angle);
        u_sum = vec3_add(u_sum, members[i].u);
        v_sum = vec3_add(v_sum, members[i].v);
    }
    if (!add_space(w, sum, n, mirrored)) return false;
    for (uint32_t i = 0; i < count; i++) w->space[members[i].corner] = first;
    if (count > PAIRS_MAX || is_plain(w, u_sum, v_sum)) return true;
    for (uint32_t i = 0; i < count; i++) {
        bool all = true;
        sum = vec3_make(0, 0, 0);
        for (uint32_t k = 0; k < count; k++) {
            bool left_out = k != i && are_opposite(&members[i], &members[k]);
            if (!left_out) sum = vec3_add_scaled(sum, members[k].u, members[k].angle);
            all &= !left_out;
        }
        if (all) continue;
        if (!add_space(w, sum, n, mirrored)) return false;
        /* One of the group's that is the same to the bit will do. */
        uint32_t added = w->spaces.count - 1, same = first;
        while (memcmp(&w->spaces.data[same], &w->spaces.data[added], sizeof(vec4)) != 0) same++;
        if (same < added) w->spaces.count--;
        w->space[members[i].corner] = same;
    }
    return true;
}

static bool find_groups(struct work *w) {
    for (uint32_t c = 0; c < w->face_count * 3; c++) {
        const struct face *face = &w->faces[c / 3];
        if (face->open || face->degenerate || w->space[c] != NONE) continue;
        vec3 n = w->primitive->normals[w->primitive->indices[c]];
        w->group.count = 0;
        if (!add_member(w, c, n) || !walk(w, c, face->mirrored, true, n) || !walk(w, c, face->mirrored, false, n) ||
            !finish_group(w, n, face->mirrored))
            return false;
    }
    return true;
}

/** Faces without area take over what the first other face has at the same vertex. */
static fnl_result finish_degenerate(struct work *w) {
    size_t size = sizeof(uint32_t) * (size_t)w->primitive->vertex_count;
    uint32_t *first = host_allocate(w->host, size);
    if (!first) return FNL_ERROR_MEMORY;
    memset(first, 0xff, size);
    for (uint32_t c = w->face_count * 3; c-- > 0;)
        if (!w->faces[c / 3].degenerate) first[corner_weld(w, c)] = c;
    for (uint32_t c = 0; c < w->face_count * 3; c++) {
        uint32_t source = w->faces[c / 3].degenerate ? first[corner_weld(w, c)] : NONE;
        if (source != NONE) w->space[c] = w->space[source];
    }
    host_free(w->host, first, size);
    return FNL_OK;
}

/* ---- vertices with tangents ---- */

/** What a corner has that no picture gives a direction: X, as far as the normal lets it. */
static vec4 default_space(vec3 n) {
    vec3 t = on_plane(vec3_make(1, 0, 0), n);
    if (!(vec3_dot(t, t) > 0.5f)) t = vec3_perpendicular(vec3_dot(n, n) > 0.5f ? n : vec3_make(0, 1, 0));
    return vec4_make(t.x, t.y, t.z, -1);
}

struct split {
    uint32_t *order;  /* corners by space */
    uint32_t *start;  /* of each space in `order` */
    uint32_t *seen;   /* per vertex: the space for which `number` holds; NONE: it is not used yet */
    uint32_t *number; /* per vertex: what it has become for that space */
    uint32_t *source; /* per new vertex */
    uint32_t *spaces; /* per new vertex */
};

/** Each vertex keeps its number for its first space and gets a copy for each other one; the copies come last. */
static uint32_t number_vertices(const struct work *w, struct split *s, uint32_t *indices) {
    const struct scene_primitive *p = w->primitive;
    uint32_t corner_count = w->face_count * 3, none = w->spaces.count, next = p->vertex_count;
    for (uint32_t i = 0; i < p->vertex_count; i++) {
        s->source[i] = i;
        s->spaces[i] = none;
        s->seen[i] = NONE;
    }
    for (uint32_t c = 0; c < corner_count; c++) s->start[MIN(w->space[c], none) + 2]++;
    for (uint32_t i = 0; i <= none; i++) s->start[i + 2] += s->start[i + 1];
    for (uint32_t c = 0; c < corner_count; c++) s->order[s->start[MIN(w->space[c], none) + 1]++] = c;
    for (uint32_t i = 0; i < corner_count; i++) {
        uint32_t c = s->order[i], v = p->indices[c], space = MIN(w->space[c], none);
        if (s->seen[v] != space) {
            s->number[v] = s->seen[v] == NONE ? v : next++;
            s->seen[v] = space;
            s->source[s->number[v]] = v;
            s->spaces[s->number[v]] = space;
        }
        indices[c] = s->number[v];
    }
    return next;
}

static fnl_result split_vertices(struct arena *arena, struct scene_primitive *p, const struct work *w) {
    size_t corners = (size_t)w->face_count * 3, vertices = p->vertex_count, most = corners + vertices,
           starts = (size_t)w->spaces.count + 3;
    size_t size = sizeof(uint32_t) * (corners + starts + 2 * vertices + 2 * most);
    if (most >= UINT32_MAX) {
        log_error(w->host, "tangents of a primitive with %zu corners could need more vertices than 32 bits can count", corners);
        return FNL_ERROR_UNSUPPORTED;
    }
    uint32_t *block = host_allocate_zero(w->host, size);
    uint32_t *indices = arena_allocate(arena, sizeof(uint32_t) * MAX(p->index_count, 1));
    if (!block || !indices) {
        host_free(w->host, block, size);
        return FNL_ERROR_MEMORY;
    }
    struct split s = {.order = block, .start = block + corners};
    s.seen = s.start + starts;
    s.number = s.seen + vertices;
    s.source = s.number + vertices;
    s.spaces = s.source + most;
    uint32_t count = number_vertices(w, &s, indices);
    fnl_result result = FNL_OK;
    if (count > p->vertex_count) {
        result = mesh_gather(arena, p, s.source, count) ? FNL_OK : FNL_ERROR_MEMORY;
        p->indices = indices;
    }
    vec4 *tangents = result == FNL_OK ? arena_allocate(arena, sizeof(vec4) * (size_t)count) : NULL;
    for (uint32_t i = 0; tangents && i < count; i++)
        tangents[i] = s.spaces[i] < w->spaces.count ? w->spaces.data[s.spaces[i]] : default_space(p->normals[i]);
    p->tangents = tangents;
    host_free(w->host, block, size);
    return tangents ? FNL_OK : FNL_ERROR_MEMORY;
}

fnl_result mesh_make_tangents(struct arena *arena, struct scene_primitive *p, const vec2 *uv) {
    struct work w = {.host = arena->host, .primitive = p, .uv = uv, .face_count = p->index_count / 3};
    size_t weld_size = sizeof *w.weld * (size_t)p->vertex_count, face_size = sizeof *w.faces * (size_t)w.face_count,
           space_size = sizeof *w.space * (size_t)w.face_count * 3;
    w.weld = host_allocate(w.host, weld_size);
    w.faces = host_allocate_zero(w.host, face_size);
    w.space = host_allocate(w.host, space_size);
    fnl_result result = w.weld && w.faces && w.space ? weld_vertices(&w) : FNL_ERROR_MEMORY;
    if (result == FNL_OK) {
        memset(w.space, 0xff, space_size);
        for (uint32_t f = 0; f < w.face_count; f++) set_directions(&w, f);
        result = find_neighbors(&w);
    }
    if (result == FNL_OK && !find_groups(&w)) result = FNL_ERROR_MEMORY;
    if (result == FNL_OK) result = finish_degenerate(&w);
    if (result == FNL_OK) result = split_vertices(arena, p, &w);
    host_free(w.host, w.weld, weld_size);
    host_free(w.host, w.faces, face_size);
    host_free(w.host, w.space, space_size);
    array_free(w.host, &w.spaces);
    array_free(w.host, &w.group);
    return result;
}
