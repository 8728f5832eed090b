/* SPDX-License-Identifier: MIT */
#include "scene/light_kinds.h"

#include "base/check.h"

/* ---- outlines ---- */

static void add_line(struct light_outline *out, vec3 from, vec3 to) {
    const vec3 ends[2] = {from, to};
    for (int i = 0; i < 2; i++, out->count++)
        if (out->count < out->capacity) out->points[out->count] = ends[i];
}

/* A place in the axes of a light: direction x up, up, direction. */
static vec3 place_in(const fnl_light_params *light, float across, float up, float along) {
    const vec3 side = vec3_cross(light->direction, light->up);
    return vec3_add_scaled(vec3_add_scaled(vec3_add_scaled(light->position, side, across), light->up, up), light->direction, along);
}

static void outline_spot(struct light_outline *out, const fnl_light_params *light, float length) {
    enum { SIDES = 12, EDGES = 4 };
    const float angle = fminf(light->outer_cone_angle, 1.5f);
    const vec3 axis = light->direction, x = vec3_normalize(vec3_cross(fabsf(axis.y) < 0.9f ? (vec3){0, 1, 0} : (vec3){0, 0, 1}, axis)), y = vec3_cross(axis, x);
    vec3 last = {0, 0, 0};
    for (int i = 0; i <= SIDES; i++) {
        const float turn = 2 * PI * (float)i / SIDES;
        const vec3 edge = vec3_add_scaled(vec3_add_scaled(vec3_scale(axis, cosf(angle)), x, sinf(angle) * cosf(turn)), y, sinf(angle) * sinf(turn));
        const vec3 end = vec3_add_scaled(light->position, edge, length);
        if (i > 0) add_line(out, last, end);
        if (i > 0 && i % (SIDES / EDGES) == 0) add_line(out, light->position, end);
        last = end;
    }
}

static void outline_capsule(struct light_outline *out, const fnl_light_params *light, float length) {
    UNUSED(length);
    const float half = 0.5f * light->length;
    add_line(out, vec3_add_scaled(light->position, light->direction, -half), vec3_add_scaled(light->position, light->direction, half));
}

static void outline_wedge(struct light_outline *out, const fnl_light_params *light, float length) {
    const float width = tanf(light->wedge_angles[0]), height = tanf(light->wedge_angles[1]), scale = length / hypotf(1, hypotf(width, height));
    vec3 corners[4];
    for (int i = 0; i < 4; i++) corners[i] = place_in(light, scale * width * (i == 1 || i == 2 ? 1.0f : -1.0f), scale * height * (i >= 2 ? 1.0f : -1.0f), scale);
    for (int i = 0; i < 4; i++) {
        add_line(out, corners[i], corners[(i + 1) % 4]);
        add_line(out, light->position, corners[i]);
    }
}

static void outline_box(struct light_outline *out, const fnl_light_params *light, float length) {
    UNUSED(length);
    vec3 corners[8];
    for (int i = 0; i < 8; i++)
        corners[i] = place_in(light, light->box_size.x * (i & 1 ? 0.5f : -0.5f), light->box_size.y * (i & 2 ? 0.5f : -0.5f),
                              light->box_size.z * (i & 4 ? 0.5f : -0.5f));
    for (int i = 0; i < 8; i++)
        for (int bit = 1; bit < 8; bit *= 2)
            if (!(i & bit)) add_line(out, corners[i], corners[i | bit]);
}

/* The border, and a ray from the center. */
static void outline_rectangle(struct light_outline *out, const fnl_light_params *light, float length) {
    UNUSED(length);
    const float width = 0.5f * light->rectangle_size[0], height = 0.5f * light->rectangle_size[1];
    vec3 corners[4];
    for (int i = 0; i < 4; i++) corners[i] = place_in(light, i == 1 || i == 2 ? width : -width, i >= 2 ? height : -height, 0);
    for (int i = 0; i < 4; i++) add_line(out, corners[i], corners[(i + 1) % 4]);
    add_line(out, light->position, vec3_add_scaled(light->position, light->direction, fmaxf(width, height)));
}

/* ---- shapes of scattered lights ---- */

static void scatter_point(fnl_light_params *light, const struct scatter_numbers *numbers) {
    UNUSED(light);
    UNUSED(numbers);
}

static void scatter_spot(fnl_light_params *light, const struct scatter_numbers *numbers) {
    light->outer_cone_angle = numbers->cone;
    light->inner_cone_angle = 0.6f * numbers->cone;
    light->intensity *= 3; /* much the same luminous flux as a point light's */
}

static void scatter_capsule(fnl_light_params *light, const struct scatter_numbers *numbers) {
    const float range = light->range;
    light->range = range * (0.5f + 0.3f * numbers->parts[0]);
    light->length = 2 * range * (0.4f + 0.6f * numbers->parts[1]);
    light->intensity *= 0.5f;
}

static void scatter_wedge(fnl_light_params *light, const struct scatter_numbers *numbers) {
    light->range *= 1.5f;
    light->wedge_angles[0] = 0.4f + 0.4f * numbers->parts[0];
    light->wedge_angles[1] = light->wedge_angles[0] * (0.25f + 0.75f * numbers->parts[1]);
    light->intensity *= 3;
}

static void scatter_box(fnl_light_params *light, const struct scatter_numbers *numbers) {
    const float range = light->range, *part = numbers->parts;
    light->range = INFINITY;
    light->box_size = vec3_make(range * (0.6f + part[0]), range * (0.6f + part[1]), range * (0.8f + 1.2f * part[2]));
    light->intensity = 2 * SCATTER_ILLUMINANCE; /* lux */
}

/* The flux of a point light, to one side. */
static void scatter_rectangle(fnl_light_params *light, const struct scatter_numbers *numbers) {
    light->rectangle_size[0] = light->range * (0.1f + 0.4f * numbers->parts[0]);
    light->rectangle_size[1] = light->range * (0.1f + 0.4f * numbers->parts[1]);
    light->two_sided = numbers->parts[2] < 0.25f;
    light->intensity *= 2;
}

/* ---- ranges ---- */

static float range_of_directional(const fnl_light_params *light) {
    UNUSED(light);
    return INFINITY;
}

static float range_of_box(const fnl_light_params *light) { return 0.5f * vec3_length(light->box_size); }

/* ---- the rows ---- */

#define MEMBER(of, of_unit, values) .name = #of, .unit = FNL_LIGHT_UNIT_##of_unit, .offset = offsetof(fnl_light_params, of), .count = values
#define MEMBERS(rows) .member_count = COUNT_OF(rows), .members = rows
#define RIGHT_ANGLE (PI / 2 + 1e-6f) /* 90 degrees may round up */

/* A member that limits another follows it. */
static const fnl_light_member spot_members[] = {
    {MEMBER(inner_cone_angle, RADIANS, 1), .labels = {"inner cone"}, .hint = "From the axis to where full intensity ends", .high = RIGHT_ANGLE,
     .at_most = "outer_cone_angle"},
    {MEMBER(outer_cone_angle, RADIANS, 1), .labels = {"cone"}, .hint = "From the axis to the edge, where the light ends", .above_low = true, .high = RIGHT_ANGLE,
     .useful_low = 1e-3f, .defaults = {PI / 4}},
};

static const fnl_light_member capsule_members[] = {{MEMBER(length, METERS, 1), .labels = {"length"}, .hint = "", .high = FLT_MAX, .defaults = {1}}};

#define INNER_FRACTION                                                                                                                                  \
    {MEMBER(inner_fraction, FRACTION, 1), .labels = {"inner fraction"}, .hint = "Full intensity up to this part of the way from the axis to the edge", \
     .high = 1, .defaults = {0.7f}}

static const fnl_light_member wedge_members[] = {
    {MEMBER(wedge_angles, RADIANS, 2), .labels = {"horizontal angle", "vertical angle"}, .hint = "From the axis to the edge", .above_low = true, .high = 1.5f,
     .useful_low = 1e-3f, .defaults = {PI / 4, PI / 6}},
    INNER_FRACTION,
};

static const fnl_light_member box_members[] = {
    {MEMBER(box_size, METERS, 3), .labels = {"width", "height", "depth"}, .hint = "", .low = FLT_MIN, .high = 1e18f, /* the square of the diagonal stays finite */
     .useful_low = 1e-6f, .defaults = {1, 1, 1}},
    INNER_FRACTION,
};

static const fnl_light_member rectangle_members[] = {
    {MEMBER(rectangle_size, METERS, 2), .labels = {"width", "height"}, .hint = "", .low = 1e-9f, .high = 1e9f, /* its area is a float above 0 */
     .useful_low = 1e-9f, .defaults = {1, 1}},
    {MEMBER(two_sided, SWITCH, 1), .labels = {"two-sided"}, .hint = "", .high = 1},
};

const struct light_kind light_kinds[FNL_LIGHT_KIND_COUNT] = {
    [FNL_LIGHT_DIRECTIONAL] = {.info = {.has_direction = true, .has_source_angle = true, .parallel = true},
                               .type = "directional",
                               .punctual = true,
                               .has_maps = true,
                               .range = range_of_directional},
    [FNL_LIGHT_POINT] = {.info = {.has_position = true, .has_range = true, .has_source_radius = true, .has_profile = true},
                         .type = "point",
                         .punctual = true,
                         .has_maps = true,
                         .scatter = scatter_point},
    [FNL_LIGHT_SPOT] = {.info = {.has_position = true, .has_direction = true, .has_range = true, .has_source_radius = true, .has_profile = true, MEMBERS(spot_members)},
                        .type = "spot",
                        .punctual = true,
                        .has_maps = true,
                        .scatter = scatter_spot,
                        .outline = outline_spot},
    [FNL_LIGHT_CAPSULE] = {.info = {.has_position = true, .has_direction = true, .has_range = true, .has_source_radius = true, MEMBERS(capsule_members)},
                           .type = "point",
                           .scatter = scatter_capsule,
                           .outline = outline_capsule},
    [FNL_LIGHT_WEDGE] = {.info = {.has_position = true, .has_direction = true, .has_up = true, .has_range = true, .has_source_radius = true, MEMBERS(wedge_members)},
                         .type = "spot",
                         .has_maps = true,
                         .scatter = scatter_wedge,
                         .outline = outline_wedge},
    [FNL_LIGHT_BOX] = {.info = {.has_position = true, .has_direction = true, .has_up = true, .has_source_angle = true, .parallel = true, MEMBERS(box_members)},
                       .type = "directional",
                       .has_maps = true,
                       .range = range_of_box,
                       .scatter = scatter_box,
                       .outline = outline_box},
    [FNL_LIGHT_RECTANGLE] = {.info = {.has_position = true, .has_direction = true, .has_up = true, .has_range = true, .area = true, MEMBERS(rectangle_members)},
                             .type = "point",
                             .scatter = scatter_rectangle,
                             .outline = outline_rectangle},
};

/* ---- looking them up ---- */

const char *light_member_key(const fnl_light_member *member, char key[LIGHT_KEY]) {
    uint32_t length = 0;
    for (const char *from = member->name; *from && length < LIGHT_KEY - 1; from++) {
        const bool starts = *from == '_' && from[1];
        if (starts) from++;
        key[length++] = starts && *from >= 'a' && *from <= 'z' ? (char)(*from - 'a' + 'A') : *from;
    }
    key[length] = 0;
    return key;
}

const fnl_light_member *light_member_find(const fnl_light_kind_info *kind, const char *name) {
    uint32_t i = 0;
    while (strcmp(kind->members[i].name, name) != 0) i++;
    return &kind->members[i];
}

const fnl_light_kind_info *fnl_light_kind_find(fnl_light_kind kind) { return (uint32_t)kind < FNL_LIGHT_KIND_COUNT ? &light_kinds[kind].info : NULL; }

uint32_t fnl_light_outline(const fnl_light_params *params, float length, uint32_t capacity, fnl_vec3 *points) {
    if (check_handle(__func__, "params", params) != FNL_OK) return 0;
    if (capacity > 0 && check_handle(__func__, "points", points) != FNL_OK) return 0;
    struct light_outline out = {.points = points, .capacity = capacity};
    if (fnl_light_kind_find(params->kind) && light_kinds[params->kind].outline) light_kinds[params->kind].outline(&out, params, length);
    return out.count;
}
