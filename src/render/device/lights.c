/* SPDX-License-Identifier: MIT */
#include "render/device/scene.h"

#include "passes/lights/sprites.h"

/* The smallest sphere round a cone and its spherical end: through apex and rim, or round the rim of a wide cone. */
static void bound_cone(struct gpu_light *g, float cosine, float sine) {
    float along = cosine > 0.70710678f ? g->range / (2 * cosine) : g->range * cosine;
    g->bound_radius = cosine > 0.70710678f ? along : g->range * sine;
    g->bound_center = vec3_add_scaled(g->position, g->direction, along);
}

/* Wedges and boxes fade between their inner part and the edge; a hard edge is a thousandth wide. */
static float edge_scale(const fnl_light_params *light) { return 1 / fmaxf(0.001f, 1 - light->inner_fraction); }

/* `range` is the first test of any light: a hair larger than these shapes, which have exact ones of their own. */
#define SHAPE_SLACK (1 + 1e-5f)

static void set_capsule(struct gpu_light *g, const fnl_light_params *light) {
    g->size = (vec3){0.5f * light->length, g->range, 0};
    g->range = (g->range + g->size.x) * SHAPE_SLACK;
    g->bound_radius = g->range;
}

static void set_wedge(struct gpu_light *g, const fnl_light_params *light) {
    g->size = (vec3){tanf(light->wedge_angles[0]), tanf(light->wedge_angles[1]), 0};
    g->spot_scale = edge_scale(light);
    /* Its corners lie on a round cone; seen from the axis nothing is farther. */
    float tangent = hypotf(g->size.x, g->size.y), cosine = 1 / hypotf(1, tangent);
    bound_cone(g, cosine, tangent * cosine);
}

static void set_box(struct gpu_light *g, const fnl_light_params *light) {
    g->size = vec3_scale(light->box_size, 0.5f);
    g->spot_scale = edge_scale(light);
    g->range = vec3_length(g->size) * SHAPE_SLACK;
    g->bound_radius = g->range;
}

struct gpu_light device_light(const fnl_light_params *light) {
    struct gpu_light g = {.position = light->position,
                          .kind = (uint32_t)light->kind,
                          .direction = light->direction,
                          .color = {light->color[0] * light->intensity, light->color[1] * light->intensity,
                                    light->color[2] * light->intensity},
                          .entity = GPU_ENTITY_LIGHT};
    if (light->kind == FNL_LIGHT_DIRECTIONAL) return g;
    bool dark = !(fmaxf(g.color.x, fmaxf(g.color.y, g.color.z)) > 0);
    g.range = light_effective_range(light);
    if (!(g.range > 0)) g.range = 1e-6f;
    g.bound_center = light->position;
    g.bound_radius = g.range;
    if (light->kind != FNL_LIGHT_POINT)
        g.side = vec3_normalize(vec3_cross(light->direction, light_up(light->direction, light->up)));
    if (light->kind == FNL_LIGHT_SPOT) {
        float outer = cosf(light->outer_cone_angle), inner = cosf(light->inner_cone_angle);
        g.spot_scale = 1 / fmaxf(0.001f, inner - outer);
        g.spot_offset = -outer * g.spot_scale;
        bound_cone(&g, outer, sinf(light->outer_cone_angle));
    }
    if (light->kind == FNL_LIGHT_CAPSULE) set_capsule(&g, light);
    if (light->kind == FNL_LIGHT_WEDGE) set_wedge(&g, light);
    if (light->kind == FNL_LIGHT_BOX) set_box(&g, light);
    if (dark) {
        g.bound_center = light->position;
        g.bound_radius = 0;
    }
    return g;
}

/* Writes the planes of a hull, seen from the light: so they stay exact far from the world's origin. */
static void set_hull(struct gpu_light *g, const struct light_hull *hull, vec4 *planes) {
    g->hull_count = hull->plane_count;
    const double at[3] = {g->position.x, g->position.y, g->position.z};
    for (uint32_t i = 0; i < hull->plane_count; i++) {
        const double *n = hull->planes[i];
        planes[i] =
            (vec4){(float)n[0], (float)n[1], (float)n[2], (float)-(n[0] * at[0] + n[1] * at[1] + n[2] * at[2] + n[3])};
    }
    if (g->bound_radius > hull->radius) { /* what both hold is held by the smaller */
        g->bound_radius = hull->radius;
        g->bound_center = hull->center;
    }
}

uint64_t device_lights_planes_offset(uint32_t light_count) {
    return DIVIDE_UP(light_count * sizeof(struct gpu_light), sizeof(vec4)) * sizeof(vec4);
}

static struct gpu_light light_of(const fnl_scene *scene, const struct scene_light *light) {
    fnl_light_params params = light->params;
    if (isinf(params.range)) params.range = fnl_light_range(&params, scene->cutoff_roughness, scene->cutoff_illuminance);
    return device_light(&params);
}

/* Where the planes begin, in units of hull_first. */
static uint32_t first_plane(const struct device_scene *d) {
    return (uint32_t)(device_lights_planes_offset(d->light_data.count) / sizeof(vec4));
}

static bool is_gathered(const fnl_scene *scene, const struct scene_light *light, bool local) {
    if (light->removed || (light->node != SCENE_NONE && !scene->nodes.data[light->node].active)) return false;
    return (light->params.kind != FNL_LIGHT_DIRECTIONAL) == local;
}

static bool must_gather(const struct device_scene *d) {
    return d->light_version == UINT64_MAX || d->light_version < d->scene->light_set_version;
}

uint32_t device_lights_count(const struct device_scene *d) {
    if (!must_gather(d)) return d->light_data.count - d->directional_count;
    uint32_t count = 0;
    for (uint32_t i = 0; i < d->scene->lights.count; i++) count += is_gathered(d->scene, &d->scene->lights.data[i], true);
    return count;
}

fnl_result device_lights_gather(struct device_scene *d) {
    const fnl_scene *scene = d->scene;
    d->light_data.count = d->plane_data.count = d->bound_radii.count = d->light_slots.count = 0;
    if (!array_reserve(&d->host, &d->light_data, scene->lights.count)) return FNL_ERROR_MEMORY;
    if (!array_reserve(&d->host, &d->light_slots, scene->lights.count)) return FNL_ERROR_MEMORY;
    if (!array_reserve(&d->host, &d->plane_data, scene->hull_plane_count)) return FNL_ERROR_MEMORY;
    d->light_slots.count = scene->lights.count;
    d->directional_count = 0;
    for (uint32_t i = 0; i < scene->lights.count; i++) d->light_slots.data[i] = SCENE_NONE;
    for (int local = 0; local < 2; local++)
        for (uint32_t i = 0; i < scene->lights.count; i++) {
            const struct scene_light *light = &scene->lights.data[i];
            if (!is_gathered(scene, light, local)) continue;
            struct gpu_light g = light_of(scene, light);
            if (local && light->hull) {
                g.hull_first = d->plane_data.count; /* the lights before the planes are added when their number is known */
                set_hull(&g, light->hull, d->plane_data.data + d->plane_data.count);
                d->plane_data.count += g.hull_count;
            }
            d->light_slots.data[i] = d->light_data.count;
            d->light_data.data[d->light_data.count++] = g;
            if (!local) d->directional_count++;
        }
    uint32_t base = first_plane(d);
    for (uint32_t i = 0; i < d->light_data.count; i++)
        if (d->light_data.data[i].hull_count) d->light_data.data[i].hull_first += base;
    return FNL_OK;
}

/* What the GPU rounds differently stays in the lists: it finds no colour there. */
#define FADE_SLACK 1e-4f

static void unfade(struct device_scene *d) {
    for (uint32_t i = 0; i < d->bound_radii.count; i++) d->light_data.data[i].bound_radius = d->bound_radii.data[i];
    d->bound_radii.count = 0;
}

fnl_result device_lights_fade(struct device_scene *d, const struct gpu_view *view, float lod, bool walk) {
    unfade(d);
    if (!(lod > 0)) return FNL_OK;
    if (d->faded_lights.size < d->lights.size) {
        gpu_buffer_destroy(d->device, &d->faded_lights);
        TRY(gpu_buffer_create(d->device, "faded lights", d->lights.size, GPU_MEMORY_DEVICE, &d->faded_lights));
    }
    if (!walk) return FNL_OK;
    if (!array_reserve(&d->host, &d->bound_radii, d->light_data.count)) return FNL_ERROR_MEMORY;
    for (uint32_t i = 0; i < d->light_data.count; i++) {
        struct gpu_light *light = &d->light_data.data[i];
        d->bound_radii.data[d->bound_radii.count++] = light->bound_radius;
        if (i >= d->directional_count && light_fade(view, light, lod * (1 - FADE_SLACK)) == 0) light->bound_radius = 0;
    }
    return FNL_OK;
}

/* ---- sending them ---- */

/* Pieces of the buffer, one after the other in the slice. */
struct piece {
    uint64_t offset, size;
};

struct send_data {
    struct gpu_slice slice;
    struct gpu_buffer target;
    const struct piece *pieces; /* in the frame's memory */
    uint32_t piece_count;
};

static void execute_send(const struct graph_context *context, const void *data) {
    const struct send_data *d = data;
    uint64_t from = d->slice.offset;
    for (uint32_t i = 0; i < d->piece_count; i++) {
        gpu_copy_buffer(context->commands, d->slice.buffer, from, &d->target, d->pieces[i].offset, d->pieces[i].size);
        from += d->pieces[i].size;
    }
}

/* Bytes for the frame to copy into the buffer. */
static fnl_result begin_send(struct device_scene *d, uint64_t size, uint32_t most_pieces, struct send_data *out,
                             struct piece **out_pieces) {
    struct gpu_slice pieces = gpu_frame_allocate(d->device, most_pieces * sizeof(struct piece));
    *out = (struct send_data){.target = d->lights, .slice = gpu_frame_allocate(d->device, size), .pieces = pieces.data};
    *out_pieces = pieces.data;
    return pieces.data && out->slice.data ? FNL_OK : gpu_status(d->device);
}

static void end_send(struct device_scene *d, struct graph *graph, graph_buffer lights, const struct send_data *send) {
    for (uint32_t i = 0; i < send->piece_count; i++) d->light_bytes_sent += send->pieces[i].size;
    struct graph_pass *pass = graph_add_pass(graph, "update lights", GRAPH_QUEUE_GRAPHICS, execute_send, send, sizeof *send);
    graph_use_buffer(pass, lights, GRAPH_COPY_TO);
}

static fnl_result send_all(struct device_scene *d, struct graph *graph, graph_buffer lights) {
    uint64_t light_size = d->light_data.count * sizeof(struct gpu_light), plane_size = d->plane_data.count * sizeof(vec4);
    if (light_size == 0) return FNL_OK;
    struct send_data send;
    struct piece *pieces;
    TRY(begin_send(d, light_size + plane_size, 2, &send, &pieces));
    memcpy(send.slice.data, d->light_data.data, light_size);
    pieces[send.piece_count++] = (struct piece){0, light_size};
    if (plane_size) {
        memcpy((char *)send.slice.data + light_size, d->plane_data.data, plane_size);
        pieces[send.piece_count++] = (struct piece){device_lights_planes_offset(d->light_data.count), plane_size};
    }
    end_send(d, graph, lights, &send);
    return FNL_OK;
}

/* A light again at its place, and its planes at theirs. */
static void refresh(struct device_scene *d, uint32_t index) {
    const struct scene_light *light = &d->scene->lights.data[index];
    struct gpu_light *old = &d->light_data.data[d->light_slots.data[index]], g = light_of(d->scene, light);
    if (old->hull_count) {
        g.hull_first = old->hull_first;
        set_hull(&g, light->hull, d->plane_data.data + (old->hull_first - first_plane(d)));
    }
    *old = g;
}

static void add_piece(struct send_data *send, struct piece *pieces, uint64_t *filled, uint64_t offset, const void *bytes,
                      uint64_t size) {
    memcpy((char *)send->slice.data + *filled, bytes, size);
    *filled += size;
    struct piece *last = send->piece_count ? &pieces[send->piece_count - 1] : NULL;
    if (last && last->offset + last->size == offset)
        last->size += size;
    else
        pieces[send->piece_count++] = (struct piece){offset, size};
}

/* What changed while all lights stayed in their places: those of the scene's list, or of all where a step was missed. */
static fnl_result send_changed(struct device_scene *d, struct graph *graph, graph_buffer lights) {
    const fnl_scene *scene = d->scene;
    bool listed = d->light_version >= scene->changed_lights_since;
    uint32_t candidates = listed ? scene->changed_lights.count : scene->lights.count, count = 0;
    uint64_t size = 0;
    unfade(d);
    for (uint32_t i = 0; i < candidates; i++) {
        uint32_t index = listed ? scene->changed_lights.data[i] : i;
        if (scene->lights.data[index].changed_version <= d->light_version) continue;
        if (d->light_slots.data[index] == SCENE_NONE) continue;
        refresh(d, index);
        size += sizeof(struct gpu_light);
        size += d->light_data.data[d->light_slots.data[index]].hull_count * sizeof(vec4);
        count++;
    }
    if (count == 0) return FNL_OK;
    if (count > d->light_data.count / 2) return send_all(d, graph, lights); /* in one piece */
    struct send_data send;
    struct piece *pieces;
    TRY(begin_send(d, size, 2 * count, &send, &pieces));
    uint64_t filled = 0;
    for (uint32_t i = 0; i < candidates; i++) {
        uint32_t index = listed ? scene->changed_lights.data[i] : i, slot = d->light_slots.data[index];
        if (scene->lights.data[index].changed_version <= d->light_version || slot == SCENE_NONE) continue;
        const struct gpu_light *g = &d->light_data.data[slot];
        add_piece(&send, pieces, &filled, slot * sizeof *g, g, sizeof *g);
        if (g->hull_count)
            add_piece(&send, pieces, &filled, g->hull_first * sizeof(vec4),
                      d->plane_data.data + (g->hull_first - first_plane(d)), g->hull_count * sizeof(vec4));
    }
    end_send(d, graph, lights, &send);
    return FNL_OK;
}

fnl_result device_lights_add(struct device_scene *d, struct graph *graph, graph_buffer lights) {
    d->light_bytes_sent = 0;
    if (d->light_version == d->scene->light_version) return FNL_OK;
    if (must_gather(d)) {
        TRY(device_lights_gather(d));
        TRY(send_all(d, graph, lights));
    } else {
        TRY(send_changed(d, graph, lights));
    }
    d->light_version = d->scene->light_version;
    return FNL_OK;
}
