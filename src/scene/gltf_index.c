/* SPDX-License-Identifier: MIT */
/* Indices and primitive modes (glTF 2.0, 3.7.2.1). */
#include "scene/gltf.h"

enum mode { POINTS, LINES, LINE_LOOP, LINE_STRIP, TRIANGLES, TRIANGLE_STRIP, TRIANGLE_FAN };

static const uint32_t *read_indices(struct gltf *g, uint32_t index, const struct at *at, uint32_t vertex_count) {
    struct gltf_accessor *accessor = &g->accessors[index];
    if (!accessor->valid) {
        gltf_warn(g, at, "accessor %u is broken; the primitive is left out", index);
        return NULL;
    }
    if (accessor->view != SCENE_NONE && g->views[accessor->view].stride)
        gltf_warn(g, at, "the buffer view of indices must not have a byteStride; it is used all the same");
    bool is_unsigned = accessor->component == GLTF_UNSIGNED_BYTE || accessor->component == GLTF_UNSIGNED_SHORT ||
                       accessor->component == GLTF_UNSIGNED_INT;
    if (accessor->type != GLTF_SCALAR || !is_unsigned) {
        char format[64];
        gltf_warn(g, at, "indices must be SCALAR of an unsigned integer type, not %s; the primitive is left out",
                  gltf_format_name(accessor, format, sizeof format));
        return NULL;
    }
    if (!gltf_spend(g, at, (uint64_t)accessor->count * 4)) return NULL;
    uint32_t *indices = accessor->decoded[GLTF_USE_INDEX];
    if (!indices) {
        indices = gltf_keep(g, accessor->count, sizeof *indices);
        if (!indices || !gltf_read_uints(g, index, at, indices)) return NULL;
        accessor->decoded[GLTF_USE_INDEX] = indices;
    }
    uint32_t restart = accessor->component == GLTF_UNSIGNED_BYTE    ? UINT8_MAX
                       : accessor->component == GLTF_UNSIGNED_SHORT ? UINT16_MAX
                                                                    : UINT32_MAX;
    uint32_t restart_count = 0;
    for (uint32_t i = 0; i < accessor->count; i++) {
        restart_count += indices[i] == restart;
        if (indices[i] < vertex_count) continue;
        gltf_warn(g, at, "index %u is %u, but there are %u vertices; the primitive is left out", i, indices[i],
                  vertex_count);
        return NULL;
    }
    if (restart_count)
        gltf_warn(g, at, "%u indices are %u, the primitive restart value, which glTF forbids; they are taken as vertices",
                  restart_count, restart);
    return indices;
}

/** Number of indices that `count` vertices of a mode expand to. */
static uint64_t expanded_count(enum mode mode, uint64_t count) {
    switch (mode) {
    case POINTS:
        return count;
    case LINES:
        return count / 2 * 2;
    case LINE_LOOP:
        return count < 2 ? 0 : count * 2;
    case LINE_STRIP:
        return count < 2 ? 0 : (count - 1) * 2;
    case TRIANGLES:
        return count / 3 * 3;
    case TRIANGLE_STRIP:
    case TRIANGLE_FAN:
        return count < 3 ? 0 : (count - 2) * 3;
    }
    return 0;
}

static void expand(enum mode mode, const uint32_t *in, uint32_t count, uint32_t *out, uint32_t out_count) {
    switch (mode) {
    case POINTS:
    case LINES:
    case TRIANGLES:
        memcpy(out, in, sizeof *out * out_count);
        break;
    case LINE_LOOP:
    case LINE_STRIP:
        for (uint32_t i = 0; i < out_count / 2; i++) {
            out[i * 2] = in[i];
            out[i * 2 + 1] = in[i + 1 < count ? i + 1 : 0];
        }
        break;
    case TRIANGLE_STRIP: /* every second triangle turns round, so that all wind alike */
        for (uint32_t i = 0; i < out_count / 3; i++) {
            out[i * 3] = in[i];
            out[i * 3 + 1] = in[i + 1 + i % 2];
            out[i * 3 + 2] = in[i + 2 - i % 2];
        }
        break;
    case TRIANGLE_FAN:
        for (uint32_t i = 0; i < out_count / 3; i++) {
            out[i * 3] = in[i + 1];
            out[i * 3 + 1] = in[i + 2];
            out[i * 3 + 2] = in[0];
        }
        break;
    }
}

/** Renumbers the indices so that only the vertices they name remain. Costs time by indices, not by vertices. */
static bool select_used(struct gltf *g, const struct at *at, uint32_t vertex_count, uint32_t *indices, uint32_t index_count,
                        struct gltf_selection *selection) {
    uint32_t known = g->vertex_map.count;
    if (vertex_count > known) {
        if (!gltf_take_memory(g, at, (uint64_t)(vertex_count - known) * sizeof *g->vertex_map.data)) return false;
        if (!array_reserve(g->host, &g->vertex_map, vertex_count)) {
            gltf_fail_memory(g);
            return false;
        }
        memset(g->vertex_map.data + known, 0, sizeof *g->vertex_map.data * (vertex_count - known));
        g->vertex_map.count = vertex_count;
    }
    uint32_t *source = gltf_keep(g, index_count, sizeof *source);
    if (!source) return false;
    uint32_t stamp = ++g->vertex_map_stamp, used = 0;
    for (uint32_t i = 0; i < index_count; i++) {
        struct gltf_vertex_map *entry = &g->vertex_map.data[indices[i]];
        if (entry->stamp != stamp) {
            *entry = (struct gltf_vertex_map){stamp, used};
            source[used++] = indices[i];
        }
        indices[i] = entry->index;
    }
    *selection = (struct gltf_selection){source, used};
    return true;
}

bool gltf_load_indices(struct gltf *g, json_t *primitive, const struct at *at, uint32_t vertex_count,
                       struct scene_primitive *out, struct gltf_selection *selection) {
    uint64_t mode_value = TRIANGLES;
    if (json_object_get(primitive, "mode") && !gltf_uint(g, primitive, at, "mode", false, POINTS, TRIANGLE_FAN, &mode_value))
        return false;
    enum mode mode = (enum mode)mode_value;
    uint32_t accessor = SCENE_NONE, count = vertex_count;
    if (json_object_get(primitive, "indices")) {
        accessor = gltf_index(g, primitive, at, "indices", true, g->accessor_count);
        if (accessor == SCENE_NONE) return false;
        count = g->accessors[accessor].count;
    }
    const uint32_t *given = NULL;
    if (accessor != SCENE_NONE) {
        given = read_indices(g, accessor, AT_KEY(at, "indices"), vertex_count);
        if (!given) return false;
    }
    uint64_t expanded = expanded_count(mode, count);
    if ((mode == TRIANGLES || mode == LINES) && expanded != count)
        gltf_warn(g, at, "%u vertices or indices are not a whole number of %s; the last are left out", count,
                  mode == LINES ? "lines" : "triangles");
    if (expanded == 0 || expanded > UINT32_MAX) {
        gltf_warn(g, at, "%u vertices or indices make up nothing to draw; the primitive is left out", count);
        return false;
    }
    out->topology = mode == POINTS     ? SCENE_TOPOLOGY_POINTS
                    : mode < TRIANGLES ? SCENE_TOPOLOGY_LINES
                                       : SCENE_TOPOLOGY_TRIANGLES;
    out->index_count = (uint32_t)expanded;
    *selection = (struct gltf_selection){NULL, vertex_count};
    bool plain = mode == POINTS || mode == LINES || mode == TRIANGLES, selects = given && expanded < vertex_count;
    if (plain && given && !selects) {
        out->indices = given;
        return true;
    }
    uint64_t passing = given ? 0 : (uint64_t)count * sizeof(uint32_t); /* the order of vertices without indices */
    if (!gltf_spend(g, at, expanded * sizeof(uint32_t) * (selects ? 2 : 1) + passing)) return false;
    uint32_t *indices = gltf_keep(g, expanded, sizeof *indices);
    uint32_t *order = NULL;
    if (!given && indices) {
        order = host_allocate(g->host, sizeof *order * (size_t)count);
        if (!order) gltf_fail_memory(g);
        for (uint32_t i = 0; order && i < count; i++) order[i] = i;
    }
    if (indices && (given || order)) expand(mode, given ? given : order, count, indices, (uint32_t)expanded);
    host_free(g->host, order, sizeof *order * (size_t)count);
    gltf_refund(g, passing);
    if (g->result != FNL_OK) return false;
    out->indices = indices;
    return !selects || select_used(g, at, vertex_count, indices, (uint32_t)expanded, selection);
}
