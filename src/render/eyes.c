/* SPDX-License-Identifier: MIT */
#include "render/eyes.h"

#include "render/view.h"

/* Axes of the head, in world space: the mean of those of the eyes. */
struct axes {
    vec3 right, up, back, origin;
};

static vec3 column(const struct gpu_view *view, int i) {
    const float *m = view->view_to_world.m;
    return (vec3){m[4 * i], m[4 * i + 1], m[4 * i + 2]};
}

static bool find_axes(const struct gpu_view *eyes, uint32_t count, struct axes *out) {
    vec3 up = {0, 0, 0}, back = up, origin = up;
    for (uint32_t i = 0; i < count; i++) {
        up = vec3_add(up, column(&eyes[i], 1));
        back = vec3_add(back, column(&eyes[i], 2));
        origin = vec3_add_scaled(origin, eyes[i].eye, 1 / (float)count);
    }
    if (!(vec3_length(back) > 0.1f) || !(vec3_length(vec3_cross(up, back)) > 0.1f)) return false;
    out->back = vec3_normalize(back);
    out->right = vec3_normalize(vec3_cross(up, out->back));
    out->up = vec3_cross(out->back, out->right);
    out->origin = origin;
    return true;
}

static vec3 in_head(const struct axes *a, vec3 v) { return (vec3){vec3_dot(v, a->right), vec3_dot(v, a->up), vec3_dot(v, a->back)}; }

/*
 * Each side is a plane through the apex. In the head's space a point of an eye's frustum is o + t d, where d leads through one of its corners and its
 * distance ahead grows with t; so the plane of a side holds all of them if its slope is the greatest of any d, and if it holds all o. Digest of Quilez'
 * rule, which takes the outer planes of the eyes, and is wrong where an eye sees farther outwards than inwards: slopes of both eyes count for each side.
 */
struct sides {
    float slope[4], reach[4]; /* left, right, down, up; reach: how far out the plane is beside the head */
    float near;
};

static float side_of(vec3 v, int side) { return side == 0 ? -v.x : side == 1 ? v.x : side == 2 ? -v.y : v.y; }

static bool find_sides(const struct gpu_view *eyes, uint32_t count, const struct axes *a, float margin, struct sides *out) {
    const float steepest = 1.55f; /* radians */
    *out = (struct sides){.near = FLT_MAX};
    for (int s = 0; s < 4; s++) out->slope[s] = out->reach[s] = -FLT_MAX;
    for (uint32_t i = 0; i < count; i++) {
        const vec3 o = in_head(a, vec3_sub(eyes[i].eye, a->origin));
        for (uint32_t k = 0; k < 4; k++) {
            const float x = (k & 1 ? 1.0f : -1.0f) * eyes[i].ndc_scale.x + eyes[i].ndc_offset.x,
                        y = (k & 2 ? 1.0f : -1.0f) * eyes[i].ndc_scale.y + eyes[i].ndc_offset.y;
            const vec3 world = vec3_sub(vec3_add(vec3_scale(column(&eyes[i], 0), x), vec3_scale(column(&eyes[i], 1), y)), column(&eyes[i], 2));
            const vec3 d = in_head(a, world);
            if (!(-d.z > 0.02f * vec3_length(d))) return false;
            for (int s = 0; s < 4; s++) {
                /* A turn moves the ray within a cone; the plane through the axis across that touches it is so much farther out. */
                const float flat = hypotf(side_of(d, s), d.z) / vec3_length(d), turn = sinf(margin) / flat, angle = atanf(side_of(d, s) / -d.z) + asinf(fminf(turn, 1));
                if (!(angle < steepest)) return false;
                out->slope[s] = fmaxf(out->slope[s], tanf(angle));
            }
            const float off = acosf(fminf(-d.z / vec3_length(d), 1)) + margin, ahead = vec3_length(d) * cosf(off);
            out->near = fminf(out->near, -o.z + eyes[i].near_distance * ahead - margin * vec3_length(o));
        }
    }
    for (uint32_t i = 0; i < count; i++) {
        const vec3 o = in_head(a, vec3_sub(eyes[i].eye, a->origin));
        const float moved = margin * vec3_length(o); /* by a turn of the head */
        for (int s = 0; s < 4; s++) out->reach[s] = fmaxf(out->reach[s], side_of(o, s) + moved + out->slope[s] * (o.z + moved));
    }
    return true;
}

/* Rounding: a little wider than it must be. */
static void widen(struct sides *s) {
    for (int i = 0; i < 4; i++) {
        s->slope[i] += 1e-5f * (1 + fabsf(s->slope[i]));
        s->reach[i] += 1e-6f;
    }
}

bool eyes_combine(const struct gpu_view *eyes, uint32_t count, float margin, struct gpu_view *out) {
    struct axes a;
    struct sides s;
    for (uint32_t i = 0; i < count; i++)
        if (eyes[i].orthographic > 0.5f || eyes[i].mask != eyes[0].mask) return false;
    if (!find_axes(eyes, count, &a) || !find_sides(eyes, count, &a, margin, &s)) return false;
    widen(&s);
    /* As far behind the eyes as both pairs of planes ask for. */
    const float across = s.slope[0] + s.slope[1], along = s.slope[2] + s.slope[3];
    const float behind = fmaxf(fmaxf((s.reach[0] + s.reach[1]) / across, (s.reach[2] + s.reach[3]) / along), 0);
    const float x = ((s.reach[1] - s.slope[1] * behind) + (s.slope[0] * behind - s.reach[0])) / 2,
                y = ((s.reach[3] - s.slope[3] * behind) + (s.slope[2] * behind - s.reach[2])) / 2;
    const float near = (behind + s.near) * 0.999f;
    if (!(across > 0 && along > 0 && near > 1e-6f)) return false;
    fnl_camera camera = fnl_camera_default();
    camera.position = vec3_add_scaled(vec3_add_scaled(vec3_add_scaled(a.origin, a.right, x), a.up, y), a.back, behind);
    camera.target = vec3_add_scaled(camera.position, a.back, -fmaxf(1, 0.1f * vec3_length(camera.position)));
    camera.up = a.up;
    camera.view_mask = eyes[0].mask;
    camera.near_distance = near;
    camera.vertical_fov = 2 * atanf(along / 2);
    camera.shift = (fnl_vec2){-(s.slope[1] - s.slope[0]) / across, -(s.slope[3] - s.slope[2]) / along};
    /* Pixels as those of the first eye. */
    const float width = ceilf((float)eyes[0].size.x * across / (2 * eyes[0].ndc_scale.x)), height = ceilf((float)eyes[0].size.y * along / (2 * eyes[0].ndc_scale.y));
    const uint32_t size_x = (uint32_t)fminf(fmaxf(width, 1), 32768), size_y = (uint32_t)fminf(fmaxf(height, 1), 32768);
    camera.pixel_aspect = across / along * (float)size_y / (float)size_x;
    *out = view_from_camera(&camera, size_x, size_y);
    out->samples = eyes[0].samples;
    out->turn = eyes[0].turn;
    out->frame = eyes[0].frame;
    return true;
}

/* Edges of a picture, tangents, made wider to whole pixels of `pixel`, of which the first edge is a multiple away from `anchor`. */
static void fit_edges(float low, float high, float pixel, float anchor, float out[2], uint32_t *size) {
    out[0] = anchor - pixel * ceilf((anchor - low) / pixel);
    *size = (uint32_t)fminf(fmaxf(ceilf((high - out[0]) / pixel), 1), 16384);
    out[1] = fmaxf(out[0] + pixel * (float)*size, high);
}

bool eyes_middle(const struct gpu_view *eyes, uint32_t count, float distance, float overlap, fnl_camera *out, uint32_t *width, uint32_t *height) {
    struct axes a;
    struct sides s;
    float x[2], y[2], edges[4];
    for (uint32_t i = 0; i < count; i++)
        if (eyes[i].orthographic > 0.5f || eyes[i].mask != eyes[0].mask) return false;
    if (!find_axes(eyes, count, &a) || !find_sides(eyes, count, &a, 0, &s)) return false;
    const struct gpu_view *first = &eyes[0];
    const float near = distance * (1 - overlap), pixel_x = 2 * first->ndc_scale.x / (float)first->size.x, pixel_y = 2 * first->ndc_scale.y / (float)first->size.y;
    for (int i = 0; i < 4; i++) edges[i] = s.slope[i] + fmaxf(s.reach[i], 0) / near;
    fit_edges(-edges[0], edges[1], pixel_x, first->ndc_offset.x - first->ndc_scale.x, x, width);
    fit_edges(-edges[2], edges[3], pixel_y, first->ndc_offset.y - first->ndc_scale.y, y, height);
    fnl_camera camera = fnl_camera_default();
    camera.position = a.origin;
    camera.target = vec3_add_scaled(a.origin, a.back, -fmaxf(1, 0.1f * vec3_length(a.origin)));
    camera.up = a.up;
    camera.view_mask = eyes[0].mask;
    camera.near_distance = near;
    camera.vertical_fov = 2 * atanf((y[1] - y[0]) / 2);
    camera.shift = (fnl_vec2){-(x[1] + x[0]) / (x[1] - x[0]), -(y[1] + y[0]) / (y[1] - y[0])};
    camera.pixel_aspect = (x[1] - x[0]) / (y[1] - y[0]) * (float)*height / (float)*width;
    *out = camera;
    return true;
}

struct gpu_view eyes_before(const struct gpu_view *head, const struct gpu_view *eyes, uint32_t count, float distance) {
    struct gpu_view view = *head;
    struct axes a;
    if (!find_axes(eyes, count, &a)) return view;
    view.planes[4] = (vec4){a.back.x, a.back.y, a.back.z, distance - vec3_dot(a.back, a.origin)};
    return view;
}
