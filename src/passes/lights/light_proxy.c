/* SPDX-License-Identifier: MIT */
#include "passes/lights/light_proxy.h"

/* Half sizes at the near and the far end, along x and y; z: where the ends are. */
struct extent {
    float x[2], y[2], z[2];
};

/* Across one axis of a pyramid with this tangent, cut by a sphere round its apex. From 60 degrees on a prism as wide as the sphere's part
   is smaller. */
static void spread(float range, float tangent, float out[2]) {
    float cosine = 1 / sqrtf(1 + tangent * tangent);
    out[1] = cosine > 0.5f ? range * tangent : range * cosine * tangent;
    out[0] = cosine > 0.5f ? 0 : out[1];
}

static struct extent extent_of(const struct gpu_shape *shape) {
    float r = shape->range, s = 0;
    struct extent e = {{r, r}, {r, r}, {-r, r}};
    switch (shape->kind) {
    case GPU_SHAPE_CONE: { /* rounding of the ramp may light a hair more than the cone */
        float cosine = -shape->spot_offset / shape->spot_scale - 4e-7f, sine = sqrtf(fmaxf(1 - cosine * cosine, 0));
        s = cosine > 0.5f ? r * sine / cosine : r * sine;
        e = (struct extent){{cosine > 0.5f ? 0 : s, s}, {cosine > 0.5f ? 0 : s, s}, {fminf(0, r * cosine), r}};
        break;
    }
    case GPU_SHAPE_CAPSULE:
        s = shape->size.x + shape->size.y;
        e = (struct extent){{shape->size.y, shape->size.y}, {shape->size.y, shape->size.y}, {-s, s}};
        break;
    case GPU_SHAPE_WEDGE:
        spread(r, shape->size.x, e.x);
        spread(r, shape->size.y, e.y);
        e.z[0] = 0;
        break;
    case GPU_SHAPE_NONE:
    case GPU_SHAPE_SPHERE:
        break;
    default: /* boxes */
        e = (struct extent){{shape->size.x, shape->size.x}, {shape->size.y, shape->size.y}, {-shape->size.z, shape->size.z}};
        break;
    }
    return e;
}

void shape_corners(const struct gpu_shape *shape, const struct gpu_entity_bounds *bounds, vec3 corners[8]) {
    vec3 side = {1, 0, 0}, up = {0, 1, 0}, along = {0, 0, 1}, center = shape->position;
    struct extent e = extent_of(shape);
    if (shape->kind != GPU_SHAPE_SPHERE) {
        side = shape->side;
        along = shape->direction;
        up = vec3_cross(side, along);
    }
    float r = bounds->radius;
    if (shape->hull_count && 8 * r * r * r < (e.z[1] - e.z[0]) * (e.x[0] + e.x[1]) * (e.y[0] + e.y[1])) {
        center = bounds->center;
        e = (struct extent){{r, r}, {r, r}, {-r, r}};
    }
    float slack = 1e-5f * shape->range + 1e-6f * vec3_length(center);
    for (uint32_t i = 0; i < 8; i++) {
        uint32_t far = i >> 2;
        float x = e.x[far] * (1 + 1e-5f) + slack, y = e.y[far] * (1 + 1e-5f) + slack, z = e.z[far] + (far ? slack : -slack);
        corners[i] =
            vec3_add_scaled(vec3_add_scaled(vec3_add_scaled(center, side, i & 1 ? x : -x), up, i & 2 ? y : -y), along, z);
    }
}
