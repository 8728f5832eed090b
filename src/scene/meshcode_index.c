/* SPDX-License-Identifier: MIT */
/* Triangles and index sequences of KHR_meshopt_compression (Appendix A, modes 1 and 2). */
#include "scene/meshcode.h"

#include "base/base.h"

/** What follows the codes. Past the end it reads zeros and says so once, at the end. */
struct stream {
    const unsigned char *at, *end;
    bool broken;
};

static inline uint32_t read_byte(struct stream *in) {
    if (in->at == in->end) {
        in->broken = true;
        return 0;
    }
    return *in->at++;
}

/** Unsigned LEB128 of at most five bytes. */
static inline uint32_t read_varint(struct stream *in) {
    uint32_t byte = read_byte(in), value = byte & 0x7f;
    for (uint32_t shift = 7; byte & 0x80; shift += 7) {
        if (shift > 28) {
            in->broken = true;
            return 0;
        }
        byte = read_byte(in);
        value |= (byte & 0x7f) << shift;
    }
    return value;
}

static inline uint32_t unzigzag(uint32_t value) { return value >> 1 ^ (0 - (value & 1)); }

static inline void put(void *out, size_t index, size_t stride, uint32_t value) {
    if (stride == 2)
        ((uint16_t *)out)[index] = (uint16_t)value;
    else
        ((uint32_t *)out)[index] = value;
}

/** Queues of the last 16; what was never written must not be read. */
struct state {
    uint32_t edges[16][2], vertices[16];
    size_t edge_count, vertex_count; /* ever pushed */
    uint32_t next, last;
    struct stream data;
};

static inline void push_edge(struct state *s, uint32_t a, uint32_t b) {
    s->edges[s->edge_count % 16][0] = a;
    s->edges[s->edge_count % 16][1] = b;
    s->edge_count++;
}

static inline void push_vertex(struct state *s, uint32_t v) { s->vertices[s->vertex_count++ % 16] = v; }

/** 0 is the youngest. */
static inline uint32_t old_vertex(struct state *s, size_t age) {
    if (age >= s->vertex_count) {
        s->data.broken = true;
        return 0;
    }
    return s->vertices[(s->vertex_count - 1 - age) % 16];
}

static inline uint32_t read_index(struct state *s) { return s->last += unzigzag(read_varint(&s->data)); }

/** A corner by four bits: new, a recent vertex, or (15) stored. */
static inline uint32_t read_corner(struct state *s, uint32_t bits) {
    return bits == 0 ? s->next++ : bits < 15 ? old_vertex(s, bits - 1) : read_index(s);
}

static inline void share_edge(struct state *s, uint32_t code, uint32_t oldest, uint32_t corners[3]) {
    const size_t age = code >> 4;
    const uint32_t how = code & 15;
    if (age >= s->edge_count) {
        s->data.broken = true;
        return;
    }
    const uint32_t *edge = s->edges[(s->edge_count - 1 - age) % 16], a = edge[0], b = edge[1];
    uint32_t c;
    if (how == 0)
        c = s->next++;
    else if (how < oldest)
        c = old_vertex(s, how);
    else if (how < 15)
        c = s->last = how == 13 ? s->last - 1 : s->last + 1;
    else
        c = read_index(s);
    push_edge(s, c, b);
    push_edge(s, a, c);
    if (how == 0 || how >= oldest) push_vertex(s, c);
    corners[0] = a;
    corners[1] = b;
    corners[2] = c;
}

static inline void stand_alone(struct state *s, uint32_t code, const unsigned char *table, uint32_t corners[3]) {
    const bool stored = code >= 0xfe;
    const uint32_t how = stored ? read_byte(&s->data) : table[code & 15], second = how >> 4, third = how & 15;
    if (stored && how == 0) s->next = 0;
    const uint32_t a = code == 0xff ? read_index(s) : s->next++, b = read_corner(s, second), c = read_corner(s, third);
    push_edge(s, b, a);
    push_edge(s, c, b);
    push_edge(s, a, c);
    push_vertex(s, a);
    if (second == 0 || second == 15) push_vertex(s, b);
    if (third == 0 || third == 15) push_vertex(s, c);
    corners[0] = a;
    corners[1] = b;
    corners[2] = c;
}

bool meshcode_triangles(void *out, size_t count, size_t stride, const unsigned char *data, size_t size) {
    enum { TABLE = 16 };
    const size_t triangle_count = count / 3;
    if (count % 3 != 0 || size < 1 + TABLE || (data[0] & 0xf0) != 0xe0 || (data[0] & 15) > 1) return false;
    if (size - 1 - TABLE < triangle_count) return false;
    const unsigned char *codes = data + 1, *table = data + size - TABLE;
    for (int i = 0; i < TABLE; i++)
        if (table[i] >> 4 == 15 || (table[i] & 15) == 15 || (i >= 14 && table[i])) return false;
    /* Version 0 has older vertices in place of those beside the last. */
    const uint32_t oldest = data[0] & 1 ? 13 : 15;
    struct state s = {.data = {codes + triangle_count, table, false}};
    for (size_t i = 0; i < triangle_count && !s.data.broken; i++) {
        uint32_t corners[3] = {0, 0, 0};
        if (codes[i] < 0xf0)
            share_edge(&s, codes[i], oldest, corners);
        else
            stand_alone(&s, codes[i], table, corners);
        for (size_t k = 0; k < 3; k++) put(out, i * 3 + k, stride, corners[k]);
    }
    return !s.data.broken && s.data.at == s.data.end;
}

bool meshcode_indices(void *out, size_t count, size_t stride, const unsigned char *data, size_t size) {
    enum { TAIL = 4 };
    if (size < 1 + TAIL || (data[0] & 0xf0) != 0xd0 || (data[0] & 15) > 1) return false;
    struct stream in = {data + 1, data + size - TAIL, false};
    uint32_t last[2] = {0, 0};
    for (size_t i = 0; i < count && !in.broken; i++) {
        const uint32_t value = read_varint(&in);
        put(out, i, stride, last[value & 1] += unzigzag(value >> 1));
    }
    return !in.broken && in.at == in.end;
}
