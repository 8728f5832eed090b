/* SPDX-License-Identifier: MIT */
#include "render/device/light_shapes.h"

#include "scene/light_kinds.h"
#include "scene/scene.h"

/* ---- one function for each kind ---- */

/* `range` is the first test of any light: a hair larger than these shapes, which have exact ones of their own. */
#define SHAPE_SLACK (1 + 1e-5f)

/* The smallest sphere round a cone and its spherical end: through apex and rim, or round the rim of a wide cone. */
static void bound_cone(struct gpu_entity_bounds *bounds, const struct gpu_shape *s, float cosine, float sine) {
    float along = cosine > 0.70710678f ? s->range / (2 * cosine) : s->range * cosine;
    bounds->radius = cosine > 0.70710678f ? along : s->range * sine;
    bounds->center = vec3_add_scaled(s->position, s->direction, along);
}

/* Wedges and boxes fade between their inner part and the edge; a hard edge is a thousandth wide. */
static float edge_scale(const fnl_light_params *light) { return 1 / fmaxf(0.001f, 1 - light->inner_fraction); }

static void set_cone(struct gpu_shape *s, struct gpu_entity_bounds *bounds, const fnl_light_params *light) {
    float outer = cosf(light->outer_cone_angle), inner = cosf(light->inner_cone_angle);
    s->spot_scale = 1 / fmaxf(0.001f, inner - outer);
    s->spot_offset = -outer * s->spot_scale;
    bound_cone(bounds, s, outer, sinf(light->outer_cone_angle));
}

static void set_capsule(struct gpu_shape *s, struct gpu_entity_bounds *bounds, const fnl_light_params *light) {
    s->size = (vec3){0.5f * light->length, s->range, 0};
    s->range = (s->range + s->size.x) * SHAPE_SLACK;
    bounds->radius = s->range;
}

static void set_wedge(struct gpu_shape *s, struct gpu_entity_bounds *bounds, const fnl_light_params *light) {
    s->size = (vec3){tanf(light->wedge_angles[0]), tanf(light->wedge_angles[1]), 0};
    s->spot_scale = edge_scale(light);
    /* Its corners lie on a round cone; seen from the axis nothing is farther. */
    float tangent = hypotf(s->size.x, s->size.y), cosine = 1 / hypotf(1, tangent);
    bound_cone(bounds, s, cosine, tangent * cosine);
}

static void set_box(struct gpu_shape *s, struct gpu_entity_bounds *bounds, const fnl_light_params *light) {
    s->size = vec3_scale(light->box_size, 0.5f);
    s->spot_scale = edge_scale(light);
    s->range = vec3_length(s->size) * SHAPE_SLACK;
    bounds->radius = s->range;
}

/* The box for lists contains all points within the range of the rectangle. */
static void set_rectangle(struct gpu_shape *s, struct gpu_entity_bounds *bounds, const fnl_light_params *light) {
    s->spot_scale = 0.5f * light->rectangle_size[0];
    s->spot_offset = light->two_sided ? -0.5f * light->rectangle_size[1] : 0.5f * light->rectangle_size[1];
    s->size = (vec3){s->spot_scale + s->range, fabsf(s->spot_offset) + s->range, s->range};
    s->range = (s->range + hypotf(s->spot_scale, s->spot_offset)) * SHAPE_SLACK;
    bounds->radius = s->range;
}

/* The shape already has position, direction, side and range; the bounds are the sphere of this range. NULL: nothing to add. */
static void (*const set_shape[FNL_LIGHT_KIND_COUNT])(struct gpu_shape *, struct gpu_entity_bounds *, const fnl_light_params *) = {
    [FNL_LIGHT_SPOT] = set_cone, [FNL_LIGHT_CAPSULE] = set_capsule, [FNL_LIGHT_WEDGE] = set_wedge, [FNL_LIGHT_BOX] = set_box, [FNL_LIGHT_RECTANGLE] = set_rectangle,
};

_Static_assert((uint32_t)FNL_LIGHT_DIRECTIONAL == GPU_SHAPE_NONE && (uint32_t)FNL_LIGHT_POINT == GPU_SHAPE_SPHERE && (uint32_t)FNL_LIGHT_SPOT == GPU_SHAPE_CONE &&
                   (uint32_t)FNL_LIGHT_CAPSULE == GPU_SHAPE_CAPSULE && (uint32_t)FNL_LIGHT_WEDGE == GPU_SHAPE_WEDGE && (uint32_t)FNL_LIGHT_BOX == GPU_SHAPE_BOX &&
                   (uint32_t)FNL_LIGHT_RECTANGLE == GPU_SHAPE_RECTANGLE,
               "the kind of a light is that of its shape");

/* ---- lights ---- */

static float source_of(const fnl_light_params *light) {
    if (!light->casts_shadows) return GPU_LIGHT_UNSHADOWED;
    return light_kinds[light->kind].info.parallel ? tanf(light->source_angle) : light->source_radius;
}

/* The shape is the first member of the light. */
uint32_t device_light_shape(uint32_t slot) { return slot * (uint32_t)sizeof(struct gpu_light); }
_Static_assert(offsetof(struct gpu_light, shape) == 0, "the shape begins the light");
_Static_assert((uint64_t)SCENE_LOCAL_LIGHTS_MAX * sizeof(struct gpu_light) <= GPU_NO_SHAPE, "offsets of shapes have 32 bits");

static void set_volume(const fnl_light_params *light, uint32_t slot, struct gpu_light *g, struct gpu_entity_bounds *bounds) {
    struct gpu_shape *s = &g->shape;
    s->range = light->range;
    if (!(s->range > 0)) s->range = 1e-6f;
    bounds->radius = s->range;
    if (light_kinds[light->kind].info.has_direction) {
        s->side = vec3_normalize(vec3_cross(light->direction, light_up(light->direction, light->up)));
        bounds->shape = device_light_shape(slot);
    }
    if (set_shape[light->kind]) set_shape[light->kind](s, bounds, light);
    if (!(fmaxf(g->color.x, fmaxf(g->color.y, g->color.z)) > 0)) { /* dark */
        bounds->center = light->position;
        bounds->radius = 0;
    }
}

void device_light(const fnl_light_params *light, uint32_t slot, struct gpu_light *out, struct gpu_entity_bounds *out_bounds) {
    *out = (struct gpu_light){.shape = {.position = light->position, .kind = (uint32_t)light->kind, .direction = light->direction},
                              .color = {light->color[0] * light->intensity, light->color[1] * light->intensity, light->color[2] * light->intensity},
                              .source = source_of(light)};
    *out_bounds = (struct gpu_entity_bounds){.center = light->position, .shape = GPU_NO_SHAPE, .kind = GPU_ENTITY_LIGHT, .user = slot};
    if (light->kind != FNL_LIGHT_DIRECTIONAL) set_volume(light, slot, out, out_bounds);
}
