/* SPDX-License-Identifier: MIT */
/* The cameras of a scene, and the one that frames it. */
#include "scene/scene.h"

void scene_camera_pose(const fnl_scene *scene, const struct scene_camera *camera, fnl_camera *out) {
    *out = camera->camera;
    if (camera->node == SCENE_NONE) return;
    const float *m = scene->nodes.data[camera->node].world.m;
    vec3 up = vec3_normalize(vec3_make(m[4], m[5], m[6])), forward = vec3_normalize(vec3_make(-m[8], -m[9], -m[10]));
    out->position = vec3_make(m[12], m[13], m[14]);
    if (vec3_dot(forward, forward) == 0) forward = vec3_make(0, 0, -1);
    if (vec3_dot(up, up) == 0) up = vec3_make(0, 1, 0);
    /* Far from the origin a target one metre away would round the direction. */
    out->target = vec3_add_scaled(out->position, forward, fmaxf(1, 0.1f * vec3_length(out->position)));
    out->up = up;
}

fnl_result fnl_scene_query_camera(const fnl_scene *scene, uint32_t index, fnl_camera *out) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(check_pointer(CALL(&scene->host), "out", out));
    TRY(check_index(CALL(&scene->host), "index", index, scene_entity_count(scene, FNL_ENTITY_CAMERA), "cameras"));
    scene_camera_pose(scene, &scene->cameras.data[scene_entity_slot(scene, FNL_ENTITY_CAMERA, index)], out);
    return FNL_OK;
}

/* The field's name in the struct that holds the camera, such as "camera.up". */
static const char *in(const char *prefix, const char *field, char text[64]) {
    snprintf(text, 64, "%s%s", prefix, field);
    return text;
}

fnl_result camera_check(const struct call *call, const char *prefix, const fnl_camera *camera) {
    const double infinite = (double)FLT_MAX;
    char name[64];
    TRY(check_finite(call, in(prefix, "position", name), camera->position));
    TRY(check_finite(call, in(prefix, "target", name), camera->target));
    if (!(vec3_distance(camera->position, camera->target) > 0))
        return misuse(call, "%starget is the position, must be another point", prefix);
    TRY(check_finite(call, in(prefix, "up", name), camera->up));
    if (camera->orthographic)
        TRY(check_range(call, in(prefix, "near_distance", name), (double)camera->near_distance, 0, infinite, " metres"));
    else
        TRY(check_above(call, in(prefix, "near_distance", name), (double)camera->near_distance, 0, infinite, " metres"));
    TRY(check_range(call, in(prefix, "shift.x", name), (double)camera->shift.x, -infinite, infinite, ""));
    TRY(check_range(call, in(prefix, "shift.y", name), (double)camera->shift.y, -infinite, infinite, ""));
    TRY(check_above(call, in(prefix, "pixel_aspect", name), (double)camera->pixel_aspect, 0, infinite, ""));
    TRY(check_count(call, in(prefix, "view_mask", name), camera->view_mask, 0, 255));
    if (!camera->orthographic) {
        if (camera->vertical_fov > 0 && camera->vertical_fov < PI) return FNL_OK;
        return misuse(call, "%svertical_fov is %g, must be above 0 and below pi radians", prefix, (double)camera->vertical_fov);
    }
    TRY(check_above(call, in(prefix, "vertical_extent", name), (double)camera->vertical_extent, 0, infinite, " metres"));
    return check_above(call, in(prefix, "far_distance", name), (double)camera->far_distance, (double)camera->near_distance,
                       infinite, " metres (near_distance)");
}

fnl_result fnl_scene_add_camera(fnl_scene *scene, const char *name, const fnl_camera *camera) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(check_pointer(CALL(&scene->host), "camera", camera));
    TRY(camera_check(CALL(&scene->host), "", camera));
    if (!(vec3_length(camera->up) > 0)) return misuse(CALL(&scene->host), "up is 0, 0, 0, must have a length");
    const size_t size = strlen(name ? name : "") + 1;
    struct scene_camera added = {.own_name = host_allocate(&scene->host, size), .node = SCENE_NONE, .camera = *camera};
    const uint32_t index = added.own_name ? scene_take_place(scene, SCENE_CAMERAS, &scene->cameras) : SCENE_NONE;
    if (index == SCENE_NONE) {
        host_free(&scene->host, added.own_name, size);
        return FNL_ERROR_MEMORY;
    }
    added.name = memcpy(added.own_name, name ? name : "", size);
    place_from_vec3(camera->position, scene->origin, added.place);
    scene->cameras.data[index] = added;
    return FNL_OK;
}

/* ---- the camera that frames a scene ---- */

enum { EXACT_POINTS = 1 << 22 }; /* beyond so many of one primitive its box is framed */
enum { LENSES = 16, LENSES_PER_OCTAVE = 4 };
static const float FRAMING_FOV = 0.7f; /* radians; narrower where things would reach close to the eye */
static const float FRAMING_FILL = 0.8f; /* of the side of the picture that the scene reaches first */

/* The scene in the axes of the view, x to the right, y up, z towards the eye. An eye at z = t sees a point in a picture whose edge has the slope s if
   x <= s (t - z): the most of x + s z over all points says how far away it must be. These are tabulated, for lenses of ever narrower slopes. */
struct framing {
    vec3 center, right, above, back;
    float wide[LENSES], high[LENSES]; /* slopes, the widest first */
    float reach[4][LENSES];           /* right, left, up, down: the most of x + wide z, -x + wide z, y + high z, -y + high z */
    float nearest;                    /* z of the point that is nearest to the eye */
};

static inline float larger(float a, float b) { return a > b ? a : b; }

static void frame_point(struct framing *f, vec3 p) {
    const vec3 d = vec3_sub(p, f->center);
    const float x = vec3_dot(d, f->right), y = vec3_dot(d, f->above), z = vec3_dot(d, f->back);
    for (int i = 0; i < LENSES; i++) {
        const float w = f->wide[i] * z, h = f->high[i] * z;
        f->reach[0][i] = larger(f->reach[0][i], x + w);
        f->reach[1][i] = larger(f->reach[1][i], w - x);
        f->reach[2][i] = larger(f->reach[2][i], y + h);
        f->reach[3][i] = larger(f->reach[3][i], h - y);
    }
    f->nearest = larger(f->nearest, z);
}

static void frame_box(struct framing *f, const struct box *box) {
    for (int corner = 0; corner < 8; corner++)
        frame_point(f, vec3_make(corner & 1 ? box->high.x : box->low.x, corner & 2 ? box->high.y : box->low.y,
                                 corner & 4 ? box->high.z : box->low.z));
}

/* Lens `at` may lie between two of the table. */
static double between(const float *row, double at) {
    const int i = (int)fmin(at, LENSES - 2);
    return (double)row[i] + ((double)row[i + 1] - (double)row[i]) * (at - i);
}

/* The distance of the eye at which both sides of an axis touch the scene, 0: left and right, 1: up and down. */
static double axis_distance(const struct framing *f, int axis, double at, double *middle) {
    const double plus = between(f->reach[2 * axis], at), minus = between(f->reach[2 * axis + 1], at);
    if (middle) *middle = (plus - minus) / 2;
    return (plus + minus) / (2 * between(axis ? f->high : f->wide, at));
}

/* The widest lens, 0 .. LENSES - 1, with which the eye is at least so far away. */
static double find_lens(const struct framing *f, bool wide, bool high, double distance) {
    double low = 0, most = LENSES - 1; /* the narrower, the farther away */
    for (int i = 0; i < 40; i++) {
        const double at = i ? (low + most) / 2 : 0;
        const double reached = fmax(wide ? axis_distance(f, 0, at, NULL) : -DBL_MAX, high ? axis_distance(f, 1, at, NULL) : -DBL_MAX);
        if (reached >= distance) most = at;
        else low = at;
    }
    return most;
}

/* A vertex of a skinned or morphed primitive in its pose. `joints` NULL: not skinned. */
static vec3 posed_point(const struct scene_primitive *p, const float *weights, const mat4 *joints, uint32_t vertex) {
    vec3 at = p->positions[vertex], sum = {0, 0, 0};
    for (uint32_t t = 0; t < p->morph_target_count && weights; t++)
        if (p->morph_targets[t].positions) at = vec3_add_scaled(at, p->morph_targets[t].positions[vertex], weights[t]);
    if (!joints) return at;
    for (uint32_t k = 0; k < p->joint_count; k++) {
        const size_t i = (size_t)vertex * p->joint_count + k;
        if (p->weights[i] > 0) sum = vec3_add_scaled(sum, mat4_point(&joints[p->joints[i]], at), p->weights[i]);
    }
    return sum;
}

/* Whether a point of a line or triangle shows anything: not where corners coincide. */
static bool has_size(const struct scene_primitive *p, uint32_t index) {
    const uint32_t corners = p->topology == SCENE_TOPOLOGY_TRIANGLES ? 3 : p->topology == SCENE_TOPOLOGY_LINES ? 2 : 1, first = index - index % corners;
    if (first + corners > p->index_count) return false;
    for (uint32_t i = 0; i < corners && corners > 1; i++) {
        const vec3 a = p->positions[p->indices[first + i]], b = p->positions[p->indices[first + (i + 1) % corners]];
        if (a.x == b.x && a.y == b.y && a.z == b.z) return false;
    }
    return true;
}

/* Calls visit() for each vertex that triangles, lines and points use, or for the corners of a box around very many. Meshes of no size do not count. */
static void visit_primitive(const fnl_scene *scene, const struct scene_node *node, const struct scene_primitive *p, const mat4 *joints,
                            void (*visit)(void *context, vec3 point), void *context) {
    const float *weights = node->morph_weights ? node->morph_weights : scene->meshes.data[node->mesh].morph_weights;
    const mat4 *skin = p->joint_count > 0 ? joints : NULL;
    const uint32_t instances = skin ? 1 : node->instance_count;
    const bool exact = (uint64_t)p->index_count * instances <= EXACT_POINTS;
    for (uint32_t k = 0; k < instances; k++) {
        const mat4 world = skin ? mat4_identity() : scene_instance_world(scene, node, k);
        const struct box box = box_transform(&p->bounds, &world);
        if (!skin && (box_is_empty(&box) || (box.low.x == box.high.x && box.low.y == box.high.y && box.low.z == box.high.z))) continue;
        for (uint32_t i = 0; i < p->index_count && exact; i++)
            if (has_size(p, i)) visit(context, mat4_point(&world, posed_point(p, weights, skin, p->indices[i])));
        for (int corner = 0; corner < 8 && !exact; corner++)
            visit(context, vec3_make(corner & 1 ? box.high.x : box.low.x, corner & 2 ? box.high.y : box.low.y, corner & 4 ? box.high.z : box.low.z));
    }
}

static void visit_points(const fnl_scene *scene, void (*visit)(void *context, vec3 point), void *context) {
    for (uint32_t n = 0; n < scene->nodes.count; n++) {
        const struct scene_node *node = &scene->nodes.data[n];
        if (!scene_node_draws(node) || node->staged) continue;
        const struct scene_mesh *mesh = &scene->meshes.data[node->mesh];
        const size_t size = node->skin == SCENE_NONE ? 0 : sizeof(mat4) * scene->skins.data[node->skin].joint_count;
        mat4 *joints = size ? host_allocate(&scene->host, size) : NULL;
        if (joints) skin_matrices(scene, node->skin, joints);
        for (uint32_t i = 0; i < mesh->primitive_count; i++)
            visit_primitive(scene, node, &scene->primitives.data[mesh->first_primitive + i], joints, visit, context);
        host_free(&scene->host, joints, size);
    }
}

static void visit_box(void *context, vec3 point) {
    if (vec3_finite(point)) box_add_point(context, point);
}
/* So that what is made of a place stays finite. */
static vec3 within_reach(vec3 point) {
    const vec3 most = vec3_make(1e36f, 1e36f, 1e36f);
    return vec3_min(vec3_max(point, vec3_scale(most, -1)), most);
}

static void visit_framing(void *context, vec3 point) {
    if (vec3_finite(point)) frame_point(context, within_reach(point));
}

/* Without the overflow of squares. */
static double length_of(vec3 v) { return sqrt((double)v.x * (double)v.x + (double)v.y * (double)v.y + (double)v.z * (double)v.z); }

fnl_result fnl_scene_query_framing_camera(const fnl_scene *scene, float aspect, fnl_camera *out) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(check_pointer(CALL(&scene->host), "out", out));
    TRY(check_above(CALL(&scene->host), "aspect", (double)aspect, 0, (double)FLT_MAX, ""));
    struct box bounds = box_empty();
    visit_points(scene, visit_box, &bounds);
    const bool has_points = !box_is_empty(&bounds);
    if (!has_points) bounds = scene_bounds(scene);
    const bool has_none = box_is_empty(&bounds);
    for (uint32_t i = 0; i < scene->lights.count && has_none; i++) {
        const struct scene_light *light = &scene->lights.data[i];
        if (!light->removed && light->params.kind != FNL_LIGHT_DIRECTIONAL) box_add_point(&bounds, light->params.position);
    }
    if (box_is_empty(&bounds)) bounds = (struct box){{-0.5f, -0.5f, -0.5f}, {0.5f, 0.5f, 0.5f}};
    bounds.low = within_reach(bounds.low);
    bounds.high = within_reach(bounds.high);
    const vec3 center = vec3_add(vec3_scale(bounds.low, 0.5f), vec3_scale(bounds.high, 0.5f));
    const vec3 half = vec3_scale(vec3_sub(bounds.high, bounds.low), 0.5f);
    /* A single point is seen from as near as floats tell positions apart. */
    const double radius = fmax(length_of(half), fmax(1e-6, 1e-5 * length_of(center)));

    fnl_camera camera = fnl_camera_default();
    struct framing f = {.center = center, .nearest = -FLT_MAX};
    f.back = vec3_normalize(vec3_make(0.6f, 0.35f, 1)); /* from the front, to the right and above: the usual three-quarter view */
    f.right = vec3_normalize(vec3_cross(camera.up, f.back));
    f.above = vec3_cross(f.back, f.right);
    for (int i = 0; i < LENSES; i++) {
        f.high[i] = FRAMING_FILL * tanf(FRAMING_FOV / 2) * exp2f(-(float)i / LENSES_PER_OCTAVE);
        f.wide[i] = f.high[i] * aspect;
        for (int side = 0; side < 4; side++) f.reach[side][i] = -FLT_MAX;
    }
    const float r = (float)radius;
    if (has_points && length_of(half) > 0) visit_points(scene, visit_framing, &f);
    else frame_box(&f, &(struct box){vec3_sub(center, vec3_make(r, r, r)), vec3_add(center, vec3_make(r, r, r))});

    /* The eye is where the sides of the picture touch the scene; not so close to it that perspective distorts it. */
    const double lens = find_lens(&f, true, true, (double)f.nearest + radius);
    const double distance = fmax(fmax(axis_distance(&f, 0, lens, NULL), axis_distance(&f, 1, lens, NULL)), (double)f.nearest + 0.05 * radius);
    double x, y; /* in the middle of the axis that is not filled, too */
    (void)axis_distance(&f, 0, find_lens(&f, true, false, distance), &x);
    (void)axis_distance(&f, 1, find_lens(&f, false, true, distance), &y);
    camera.vertical_fov = 2 * atanf((float)between(f.high, lens) / FRAMING_FILL);
    camera.target = vec3_add_scaled(vec3_add_scaled(center, f.right, (float)x), f.above, (float)y);
    camera.position = vec3_add_scaled(camera.target, f.back, (float)distance);
    camera.near_distance = (float)fmin(0.01 * radius, 0.5 * (distance - (double)f.nearest));
    camera.far_distance = (float)(distance + 2 * radius);
    camera.vertical_extent = (float)(2 * distance) * tanf(camera.vertical_fov / 2);
    *out = camera;
    return FNL_OK;
}
