/* SPDX-License-Identifier: MIT */
/* Vertex data: decoded once per accessor and use, checked, then reduced to the vertices that the indices name. */
#include "scene/gltf.h"

/* ---- checks, in place; each complains once per accessor ---- */

static void replace_broken(struct gltf *g, const struct at *at, float *values, uint32_t count, uint32_t width,
                           float replacement) {
    uint32_t broken = 0, first = 0;
    for (uint32_t i = 0; i < count; i++) {
        bool finite = true;
        for (uint32_t k = 0; k < width; k++) finite &= isfinite(values[(size_t)i * width + k]) != 0;
        if (finite) continue;
        for (uint32_t k = 0; k < width; k++) values[(size_t)i * width + k] = replacement;
        if (broken++ == 0) first = i;
    }
    if (broken)
        gltf_warn(g, at, "%u element%s NaN or infinite, the first at index %u; they are replaced by %g", broken,
                  broken == 1 ? " is" : "s are", first, (double)replacement);
}

/** Makes the first three components of each element a unit vector; those of length 0 become `otherwise`. */
static void make_unit(struct gltf *g, const struct at *at, float *values, uint32_t count, uint32_t width, vec3 otherwise) {
    uint32_t wrong = 0, first = 0;
    for (uint32_t i = 0; i < count; i++) {
        float *v = values + (size_t)i * width;
        float length = sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
        if (fabsf(length - 1) < 1e-6f) continue;
        if (fabsf(length - 1) > 0.03f && (length > 0 || width == 3) && wrong++ == 0) first = i; /* 8-bit normals are off by up to 0.014 */
        vec3 unit = vec3_normalize(vec3_make(v[0], v[1], v[2]));
        if (!(vec3_dot(unit, unit) > 0.5f)) unit = otherwise;
        memcpy(v, &unit, sizeof unit);
    }
    if (wrong)
        gltf_warn(g, at, "%u vectors are not of unit length, the first at index %u; they are normalised", wrong, first);
}

static void check_handedness(struct gltf *g, const struct at *at, float *values, uint32_t count) {
    uint32_t wrong = 0, first = 0;
    for (uint32_t i = 0; i < count; i++) {
        float *w = &values[(size_t)i * 4 + 3];
        if (fabsf(*w) != 1 && wrong++ == 0) first = i;
        *w = *w < 0 ? -1.0f : 1.0f;
    }
    if (wrong)
        gltf_warn(g, at, "%u tangents have a w that is neither 1 nor -1, the first at index %u; its sign is used", wrong,
                  first);
}

static void clamp_colors(struct gltf *g, const struct at *at, float *values, uint32_t count) {
    uint32_t wrong = 0;
    for (size_t i = 0; i < (size_t)count * 4; i++) {
        if (values[i] >= 0 && values[i] <= 1) continue;
        values[i] = CLAMP(values[i], 0.0f, 1.0f);
        wrong++;
    }
    if (wrong) gltf_warn(g, at, "%u values are outside of 0 to 1; they are clamped", wrong);
}

/* ---- decoding ---- */

static void check_values(struct gltf *g, const struct at *at, enum gltf_use use, float *values, uint32_t count) {
    switch (use) {
    case GLTF_USE_POSITION:
    case GLTF_USE_MORPH:
        replace_broken(g, at, values, count, 3, 0);
        break;
    case GLTF_USE_UV:
        replace_broken(g, at, values, count, 2, 0);
        break;
    case GLTF_USE_NORMAL:
        replace_broken(g, at, values, count, 3, 0);
        make_unit(g, at, values, count, 3, vec3_make(0, 1, 0));
        break;
    case GLTF_USE_TANGENT:
        replace_broken(g, at, values, count, 4, 0);
        make_unit(g, at, values, count, 4, vec3_make(0, 0, 0));
        check_handedness(g, at, values, count);
        break;
    case GLTF_USE_COLOR:
        replace_broken(g, at, values, count, 4, 1);
        clamp_colors(g, at, values, count);
        break;
    case GLTF_USE_INDEX:
    case GLTF_USE_COUNT:
        break;
    }
}

/** RGB to RGBA in place; the block has room for four values per element. */
static void widen_colors(float *values, uint32_t count) {
    for (uint32_t i = count; i-- > 0;) {
        float rgb[3] = {values[(size_t)i * 3], values[(size_t)i * 3 + 1], values[(size_t)i * 3 + 2]};
        memcpy(values + (size_t)i * 4, rgb, sizeof rgb);
        values[(size_t)i * 4 + 3] = 1;
    }
}

static const float *decode(struct gltf *g, uint32_t index, enum gltf_use use, const struct at *at) {
    struct gltf_accessor *accessor = &g->accessors[index];
    if (accessor->decoded[use]) return accessor->decoded[use];
    uint32_t components = gltf_type_components(accessor->type), width = use == GLTF_USE_COLOR ? 4 : components;
    if (!gltf_spend(g, at, (uint64_t)accessor->count * width * sizeof(float))) return NULL;
    float *values = gltf_keep(g, (uint64_t)accessor->count * width, sizeof *values);
    if (!values || !gltf_read_floats(g, index, at, values)) return NULL;
    if (width > components) widen_colors(values, accessor->count);
    check_values(g, at, use, values, accessor->count);
    accessor->decoded[use] = values;
    return values;
}

/** The selected elements of an attribute; NULL when it is absent or broken. */
static const void *load(struct gltf *g, uint32_t index, enum gltf_use use, const struct at *at,
                        const struct gltf_selection *selection) {
    const float *values = index == SCENE_NONE ? NULL : decode(g, index, use, at);
    if (!values || !selection->source) return values;
    size_t width = use == GLTF_USE_COLOR ? 4 : gltf_type_components(g->accessors[index].type);
    if (!gltf_spend(g, at, (uint64_t)selection->count * width * sizeof(float))) return NULL;
    float *picked = gltf_keep(g, (uint64_t)selection->count * width, sizeof *picked);
    for (uint32_t i = 0; picked && i < selection->count; i++)
        memcpy(picked + i * width, values + selection->source[i] * width, width * sizeof *picked);
    return picked;
}

/* ---- morph targets ---- */

static void load_targets(struct gltf *g, json_t *primitive, const struct at *at, const struct gltf_attributes *attributes,
                         const struct gltf_selection *selection, struct scene_primitive *out) {
    json_t *array = gltf_array(g, primitive, at, "targets", false);
    uint32_t count = gltf_count(array);
    if (count == 0) return;
    struct scene_morph_target *targets = gltf_keep(g, count, sizeof *targets);
    for (uint32_t i = 0; targets && i < count && g->result == FNL_OK; i++) {
        const struct at *targets_at = AT_KEY(at, "targets"), *here = AT_INDEX(targets_at, i);
        json_t *object = gltf_element(g, array, targets_at, i);
        if (!object) continue;
        struct gltf_attributes target;
        gltf_find_attributes(g, object, here, attributes, &target);
        targets[i].positions =
            load(g, target.accessor[GLTF_POSITION][0], GLTF_USE_MORPH, AT_KEY(here, "POSITION"), selection);
        targets[i].normals = load(g, target.accessor[GLTF_NORMAL][0], GLTF_USE_MORPH, AT_KEY(here, "NORMAL"), selection);
        targets[i].tangents = load(g, target.accessor[GLTF_TANGENT][0], GLTF_USE_MORPH, AT_KEY(here, "TANGENT"), selection);
    }
    out->morph_targets = targets;
    out->morph_target_count = targets ? count : 0;
}

/** One of length 0 has no direction: all of the primitive count as absent, and are made as if there were none. */
static const vec4 *load_tangents(struct gltf *g, uint32_t index, const struct at *at, const struct gltf_selection *selection) {
    const vec4 *tangents = load(g, index, GLTF_USE_TANGENT, at, selection);
    uint32_t missing = 0;
    for (uint32_t i = 0; tangents && i < selection->count; i++) missing += tangents[i].x == 0 && tangents[i].y == 0 && tangents[i].z == 0;
    if (missing) gltf_warn(g, at, "%u tangents are of length 0; tangents are made anew", missing);
    return missing ? NULL : tangents;
}

bool gltf_load_vertices(struct gltf *g, json_t *primitive, const struct at *at, const struct gltf_attributes *attributes,
                        const struct gltf_selection *selection, struct scene_primitive *out) {
    const struct at *here = AT_KEY(at, "attributes");
    out->vertex_count = selection->count;
    out->positions = load(g, attributes->accessor[GLTF_POSITION][0], GLTF_USE_POSITION, AT_KEY(here, "POSITION"), selection);
    if (!out->positions) return false;
    out->normals = load(g, attributes->accessor[GLTF_NORMAL][0], GLTF_USE_NORMAL, AT_KEY(here, "NORMAL"), selection);
    if (out->normals)
        out->tangents = load_tangents(g, attributes->accessor[GLTF_TANGENT][0], AT_KEY(here, "TANGENT"), selection);
    out->uv[0] = load(g, attributes->accessor[GLTF_TEXCOORD][0], GLTF_USE_UV, AT_KEY(here, "TEXCOORD_0"), selection);
    out->uv[1] = load(g, attributes->accessor[GLTF_TEXCOORD][1], GLTF_USE_UV, AT_KEY(here, "TEXCOORD_1"), selection);
    out->colors = load(g, attributes->accessor[GLTF_COLOR][0], GLTF_USE_COLOR, AT_KEY(here, "COLOR_0"), selection);
    load_targets(g, primitive, at, attributes, selection, out);
    return g->result == FNL_OK;
}
