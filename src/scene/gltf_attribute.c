/* SPDX-License-Identifier: MIT */
/* Names, formats and counts of vertex attributes (glTF 2.0, 3.7.2; KHR_mesh_quantization). */
#include "scene/gltf.h"

#define BIT(component) (1u << ((component)-GLTF_BYTE))
#define FLOAT_BIT BIT(GLTF_FLOAT)
#define UNSIGNED_BITS (BIT(GLTF_UNSIGNED_BYTE) | BIT(GLTF_UNSIGNED_SHORT))
#define SIGNED_BITS (BIT(GLTF_BYTE) | BIT(GLTF_SHORT))

/** Component types that a semantic may have: as they are, and normalised; in core glTF, and with KHR_mesh_quantization. */
struct format_rule {
    const char *name;
    bool has_sets;
    enum gltf_type type;
    uint32_t plain, normalized, quantized_plain, quantized_normalized;
};

static const struct format_rule rules[GLTF_SEMANTIC_COUNT] = {
    [GLTF_POSITION] = {"POSITION", false, GLTF_VEC3, FLOAT_BIT, 0, UNSIGNED_BITS | SIGNED_BITS, UNSIGNED_BITS | SIGNED_BITS},
    [GLTF_NORMAL] = {"NORMAL", false, GLTF_VEC3, FLOAT_BIT, 0, 0, SIGNED_BITS},
    [GLTF_TANGENT] = {"TANGENT", false, GLTF_VEC4, FLOAT_BIT, 0, 0, SIGNED_BITS},
    [GLTF_TEXCOORD] = {"TEXCOORD", true, GLTF_VEC2, FLOAT_BIT, UNSIGNED_BITS, UNSIGNED_BITS | SIGNED_BITS, SIGNED_BITS},
    [GLTF_COLOR] = {"COLOR", true, GLTF_VEC4, FLOAT_BIT, UNSIGNED_BITS, 0, 0},
    [GLTF_JOINTS] = {"JOINTS", true, GLTF_VEC4, UNSIGNED_BITS, 0, 0, 0},
    [GLTF_WEIGHTS] = {"WEIGHTS", true, GLTF_VEC4, FLOAT_BIT, UNSIGNED_BITS, 0, 0},
};

/** Splits "TEXCOORD_1" into a semantic and a set. False: glTF has no such name. */
static bool parse_name(const char *name, enum gltf_semantic *semantic, uint32_t *set) {
    for (uint32_t i = 0; i < GLTF_SEMANTIC_COUNT; i++) {
        size_t length = strlen(rules[i].name);
        if (strncmp(name, rules[i].name, length) != 0) continue;
        *semantic = (enum gltf_semantic)i;
        *set = 0;
        if (!rules[i].has_sets) return name[length] == 0;
        const char *digits = name + length + 1;
        size_t digit_count = strspn(name[length] == '_' ? digits : "", "0123456789");
        if (digit_count == 0 || digits[digit_count] != 0 || (digit_count > 1 && digits[0] == '0')) return false;
        *set = digit_count > 4 ? UINT32_MAX : (uint32_t)atoi(digits);
        return true;
    }
    return false;
}

/** Whether the format can be used; complains where it must not be, or not without KHR_mesh_quantization. */
static bool check_format(struct gltf *g, const struct at *at, enum gltf_semantic semantic, bool is_target,
                         const struct gltf_accessor *accessor) {
    const struct format_rule *rule = &rules[semantic];
    uint32_t bit = BIT(accessor->component);
    bool normalized = accessor->normalized;
    bool type_good = accessor->type == (is_target && semantic == GLTF_TANGENT ? GLTF_VEC3 : rule->type) ||
                     (semantic == GLTF_COLOR && accessor->type == GLTF_VEC3);
    bool core = bit & (normalized ? rule->normalized : rule->plain);
    bool quantized = bit & (normalized ? rule->quantized_normalized : rule->quantized_plain);
    char format[64];
    if (!type_good || (!core && !quantized)) {
        gltf_warn(g, at, "%s cannot be %s; it is left out", rule->name, gltf_format_name(accessor, format, sizeof format));
        return false;
    }
    if (!core && !gltf_uses(g, "KHR_mesh_quantization"))
        gltf_warn(g, at, "%s cannot be %s without KHR_mesh_quantization; it is used all the same", rule->name,
                  gltf_format_name(accessor, format, sizeof format));
    return true;
}

/** Two accessors may only share a buffer view whose stride is given (3.6.2.4). */
static void check_sharing(struct gltf *g, const struct at *at, uint32_t accessor) {
    uint32_t view_index = g->accessors[accessor].view;
    if (view_index == SCENE_NONE) return;
    struct gltf_view *view = &g->views[view_index];
    if (view->attribute_accessor == SCENE_NONE) view->attribute_accessor = accessor;
    if (view->stride || view->attribute_accessor == accessor) return;
    gltf_warn(g, at, "accessors %u and %u share a buffer view that has no byteStride; they are taken as tightly packed",
              view->attribute_accessor, accessor);
    view->attribute_accessor = accessor;
}

static void check_attribute(struct gltf *g, json_t *value, const struct at *at, const char *name,
                            const struct gltf_attributes *base, struct gltf_attributes *out) {
    enum gltf_semantic semantic = GLTF_POSITION;
    uint32_t set = 0;
    bool known = parse_name(name, &semantic, &set), is_target = base != NULL;
    if (!known && name[0] != '_') gltf_warn(g, at, "is not the name of an attribute; it is ignored");
    bool has_base = !is_target || (known && set < GLTF_SET_MAX && base->accessor[semantic][set] != SCENE_NONE);
    if (!has_base && name[0] != '_')
        gltf_warn(g, at, "the primitive itself has no such attribute that can be used; it is ignored");
    uint32_t index = gltf_index_value(g, value, at, g->accessor_count);
    if (index == SCENE_NONE) return;
    const struct gltf_accessor *accessor = &g->accessors[index];
    check_sharing(g, at, index);
    if (!accessor->valid) {
        gltf_warn(g, at, "accessor %u is broken; the attribute is left out", index);
        return;
    }
    if (accessor->component == GLTF_UNSIGNED_INT) {
        gltf_warn(g, at, "an attribute cannot be UNSIGNED_INT; it is left out");
        return;
    }
    if (!known || !has_base) return;
    if (set >= GLTF_SET_MAX) {
        gltf_warn(g, at, "only sets 0 to %u are read; it is left out", GLTF_SET_MAX - 1);
        return;
    }
    if (is_target && semantic > GLTF_TANGENT) {
        gltf_warn(g, at, "only POSITION, NORMAL and TANGENT are morphed; it is left out");
        return;
    }
    if (check_format(g, at, semantic, is_target, accessor) && gltf_accessor_readable(g, index, at))
        out->accessor[semantic][set] = index;
}

static void check_counts(struct gltf *g, const struct at *at, uint32_t position, struct gltf_attributes *out) {
    for (uint32_t i = 0; i < GLTF_SEMANTIC_COUNT; i++)
        for (uint32_t set = 0; set < GLTF_SET_MAX; set++) {
            uint32_t accessor = out->accessor[i][set];
            if (accessor == SCENE_NONE || g->accessors[accessor].count == g->accessors[position].count) continue;
            char name[32];
            snprintf(name, sizeof name, rules[i].has_sets ? "%s_%u" : "%s", rules[i].name, set);
            gltf_warn(g, AT_KEY(at, name), "has %u elements, but POSITION has %u; it is left out",
                      g->accessors[accessor].count, g->accessors[position].count);
            out->accessor[i][set] = SCENE_NONE;
        }
}

/** Sets must be numbered from 0 on without gaps. */
static void check_continuity(struct gltf *g, json_t *object, const struct at *at) {
    for (uint32_t i = 0; i < GLTF_SEMANTIC_COUNT; i++) {
        uint32_t count = 0, highest = 0;
        for (uint32_t set = 0; rules[i].has_sets && set < GLTF_SET_MAX; set++) {
            char name[32];
            snprintf(name, sizeof name, "%s_%u", rules[i].name, set);
            if (!json_object_get(object, name)) continue;
            count++;
            highest = set + 1;
        }
        if (count != highest) gltf_warn(g, at, "the sets of %s are not numbered from 0 on without gaps", rules[i].name);
    }
}

void gltf_find_attributes(struct gltf *g, json_t *object, const struct at *at, const struct gltf_attributes *base,
                          struct gltf_attributes *out) {
    memset(out, 0xff, sizeof *out); /* SCENE_NONE everywhere */
    const char *name;
    json_t *value;
    json_object_foreach(object, name, value) check_attribute(g, value, AT_KEY(at, name), name, base, out);
    check_continuity(g, object, at);
    uint32_t position = (base ? base : out)->accessor[GLTF_POSITION][0];
    if (position != SCENE_NONE) check_counts(g, at, position, out);
    if (!base && out->accessor[GLTF_TANGENT][0] != SCENE_NONE && out->accessor[GLTF_NORMAL][0] == SCENE_NONE) {
        gltf_warn(g, AT_KEY(at, "TANGENT"), "there is no NORMAL; it is ignored");
        out->accessor[GLTF_TANGENT][0] = SCENE_NONE;
    }
}
