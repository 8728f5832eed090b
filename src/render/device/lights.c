/* SPDX-License-Identifier: MIT */
#include "render/device/scene.h"

#include "passes/lights/sprites.h"
#include "render/device/light_lobes.h"
#include "render/device/light_shapes.h"
#include "scene/light_kinds.h"

/* Writes the planes of a hull, seen from the light: so they stay exact far from the world's origin. */
static void set_hull(struct gpu_shape *s, struct gpu_entity_bounds *bounds, const struct light_hull *hull, vec4 *planes) {
    s->hull_count = hull->plane_count;
    bounds->shape = device_light_shape(bounds->user);
    const double at[3] = {s->position.x, s->position.y, s->position.z};
    for (uint32_t i = 0; i < hull->plane_count; i++) {
        const double *n = hull->planes[i];
        planes[i] =
            (vec4){(float)n[0], (float)n[1], (float)n[2], (float)-(n[0] * at[0] + n[1] * at[1] + n[2] * at[2] + n[3])};
    }
    if (bounds->radius > hull->radius) { /* what both hold is held by the smaller */
        bounds->radius = hull->radius;
        bounds->center = hull->center;
    }
}

static void light_of(const fnl_scene *scene, const struct scene_light *light, uint32_t slot, struct gpu_light *out,
                     struct gpu_entity_bounds *out_bounds) {
    fnl_light_params params = light->params;
    params.range = light_effective_range(light);
    device_light(&params, slot, out, out_bounds);
    const struct light_profile *profile = scene_light_profile(scene, &params);
    if (!profile) return;
    out->shape.side = vec3_normalize(vec3_cross(params.direction, params.up));
    out->shape.size.x = (float)profile->offset;
}

/* ---- places ---- */

static bool is_lit(const fnl_scene *scene, const struct scene_light *light) {
    return scene_light_shines(light) && (light->node == SCENE_NONE || scene->nodes.data[light->node].active);
}

/* The light of a slot; NULL: none, or a hidden one. */
static const struct scene_light *light_at(const fnl_scene *scene, uint32_t slot) {
    uint32_t index = scene->light_slots.data[slot].light;
    return index != SCENE_NONE && is_lit(scene, &scene->lights.data[index]) ? &scene->lights.data[index] : NULL;
}

static bool is_place_lit(const struct gpu_light *place) { return place->shape.range > 0; }

/* Shaders need code for such lights that others do without. */
static bool is_place_shaped(const struct gpu_light *place) {
    return is_place_lit(place) && (place->shape.kind > GPU_SHAPE_CONE || place->shape.hull_count > 0);
}

static bool is_place_profiled(const struct gpu_light *place) {
    return is_place_lit(place) && place->shape.kind <= GPU_SHAPE_CONE && place->shape.size.x > 0;
}

static bool is_place_area(const struct gpu_light *place) { return is_place_lit(place) && light_kinds[place->shape.kind].info.area; }

static bool must_gather(const struct device_scene *d) {
    return d->sent.lights == UINT64_MAX || d->sent.lights < d->scene->light_set_version;
}

/* Slots that changed since the device was last told: those of the scene's list, or of all where a step was missed. */
struct changes {
    const uint32_t *slots; /* NULL: all */
    uint32_t count;
};

static struct changes changes_of(const struct device_scene *d) {
    const fnl_scene *scene = d->scene;
    if (d->sent.lights >= scene->changed_slots_since)
        return (struct changes){scene->changed_slots.data, scene->changed_slots.count};
    return (struct changes){NULL, scene->light_slots.count};
}

/* The i-th of them; SCENE_NONE: it had not changed after all. */
static uint32_t change_at(const struct device_scene *d, const struct changes *changes, uint32_t i) {
    uint32_t slot = changes->slots ? changes->slots[i] : i;
    return d->scene->light_slots.data[slot].changed_version > d->sent.lights ? slot : SCENE_NONE;
}

uint32_t device_lights_count(const struct device_scene *d) {
    bool all = must_gather(d);
    struct changes changes = all ? (struct changes){NULL, d->scene->light_slots.count} : changes_of(d);
    uint32_t count = all ? 0 : d->lit_count;
    for (uint32_t i = 0; i < changes.count; i++) {
        uint32_t slot = all ? i : change_at(d, &changes, i);
        if (slot == SCENE_NONE) continue;
        bool was_lit = !all && slot < d->light_data.count && is_place_lit(&d->light_data.data[slot]);
        count += (uint32_t)(light_at(d->scene, slot) != NULL) - (uint32_t)was_lit;
    }
    return count;
}

/* Brings one place up to date; false where its planes find no room between those of others. */
static bool refresh(struct device_scene *d, uint32_t slot) {
    const struct scene_light *light = light_at(d->scene, slot);
    struct gpu_light *place = &d->light_data.data[slot], g = {.shape.kind = GPU_SHAPE_SPHERE};
    struct gpu_entity_bounds *bounds = &d->light_bounds.data[slot];
    *bounds = (struct gpu_entity_bounds){.shape = GPU_NO_SHAPE, .kind = GPU_ENTITY_LIGHT, .user = slot};
    if (light) light_of(d->scene, light, slot, &g, bounds);
    d->lit_count += (uint32_t)is_place_lit(&g) - (uint32_t)is_place_lit(place);
    d->shaped_count -= (uint32_t)is_place_shaped(place);
    d->profiled_count += (uint32_t)is_place_profiled(&g) - (uint32_t)is_place_profiled(place);
    d->area_count += (uint32_t)is_place_area(&g) - (uint32_t)is_place_area(place);
    ranges_give(&d->host, &d->planes_taken, place->shape.hull_first, place->shape.hull_count);
    *place = g;
    if (!light || !light->hull) {
        d->shaped_count += (uint32_t)is_place_shaped(place);
        return true;
    }
    uint32_t first = ranges_take(&d->planes_taken, light->hull->plane_count);
    if (first == RANGES_NONE || d->planes_taken.end > d->plane_room) {
        ranges_give(&d->host, &d->planes_taken, first, first == RANGES_NONE ? 0 : light->hull->plane_count);
        return false;
    }
    place->shape.hull_first = first;
    set_hull(&place->shape, bounds, light->hull, d->plane_data.data + first);
    d->shaped_count += (uint32_t)is_place_shaped(place);
    return true;
}

static fnl_result gather_suns(struct device_scene *d) {
    const fnl_scene *scene = d->scene;
    d->sun_data.count = 0;
    if (!array_reserve(&d->host, &d->sun_data, scene->suns.count)) return FNL_ERROR_MEMORY;
    for (uint32_t i = 0; i < scene->suns.count; i++) {
        const struct scene_light *light = &scene->lights.data[scene->suns.data[i]];
        struct gpu_entity_bounds none;
        if (is_lit(scene, light)) light_of(scene, light, 0, &d->sun_data.data[d->sun_data.count++], &none);
    }
    return FNL_OK;
}

/* Room for places that have come; they hold nothing yet. */
static fnl_result reserve_places(struct device_scene *d) {
    uint32_t before = d->light_data.count, count = d->scene->light_slots.count;
    if (!array_reserve(&d->host, &d->light_data, count)) return FNL_ERROR_MEMORY;
    d->plane_room = MAX((uint32_t)(d->planes.size / sizeof(vec4)), d->scene->hull_plane_count);
    if (!array_reserve(&d->host, &d->plane_data, d->plane_room)) return FNL_ERROR_MEMORY;
    if (!array_reserve(&d->host, &d->light_bounds, count)) return FNL_ERROR_MEMORY;
    if (count > before) {
        memset(d->light_data.data + before, 0, (count - before) * sizeof *d->light_data.data);
        memset(d->light_bounds.data + before, 0, (count - before) * sizeof *d->light_bounds.data);
    }
    d->light_data.count = d->light_bounds.count = MAX(before, count);
    return FNL_OK;
}

fnl_result device_lights_gather(struct device_scene *d) {
    d->light_data.count = d->light_bounds.count = d->bound_radii.count = d->lit_count = d->shaped_count = d->profiled_count = d->area_count = 0;
    d->planes_taken.gaps.count = d->planes_taken.end = 0;
    TRY(reserve_places(d));
    for (uint32_t slot = 0; slot < d->light_data.count; slot++) UNUSED(refresh(d, slot)); /* one after the other, all fit */
    return gather_suns(d);
}

/* All profiles one after the other: what was sent stays where it is. */
static fnl_result send_profiles(struct device_scene *d) {
    const fnl_scene *scene = d->scene;
    const uint32_t count = scene->profile_floats.end;
    if (scene->profile_version == d->profile_version) return FNL_OK;
    float *all = host_allocate_zero(&d->host, count * sizeof *all);
    for (uint32_t i = 0; all && i < scene->profiles.count; i++) {
        const struct light_profile *p = &scene->profiles.data[i];
        float *to = all + p->offset;
        to[0] = (float)p->rows;
        to[1] = (float)p->columns;
        memcpy(to + LIGHT_PROFILE_HEAD, p->values, (p->rows + 1) * p->columns * sizeof *to);
    }
    fnl_result result = all ? device_array_set(d, GPU_USE_LIGHTS, "light profiles", &d->profiles, all, count, sizeof *all) : FNL_ERROR_MEMORY;
    host_free(&d->host, all, count * sizeof *all);
    if (result == FNL_OK) d->profile_version = scene->profile_version;
    return result;
}

/* Uploads the lobe table once a scene has an area light. */
static fnl_result send_lobes(struct device_scene *d) {
    if (d->lobes.buffer.size || !d->scene->has_area_lights) return FNL_OK;
    return device_array_set(d, GPU_USE_LIGHTS, "light lobes", &d->lobes, light_lobes, COUNT_OF(light_lobes), sizeof *light_lobes);
}

fnl_result device_lights_prepare(struct device_scene *d) {
    const fnl_scene *scene = d->scene;
    enum { LEAST_SUNS = 4 };
    TRY(send_profiles(d));
    TRY(send_lobes(d));
    if (scene->suns.count > d->sun_room || !d->sun_room) { /* all others move */
        d->sun_room = MAX(scene->suns.count * 3 / 2, (uint32_t)LEAST_SUNS);
        d->sent.lights = UINT64_MAX;
    }
    bool sent = d->sent.lights != UINT64_MAX;
    uint64_t places = MAX(scene->light_slots.count, 1u), light_bytes = (d->sun_room + places) * sizeof(struct gpu_light);
    TRY(device_buffer_reserve(d, GPU_USE_LIGHTS, "lights", &d->lights, sent ? d->lights.size : 0, light_bytes));
    TRY(device_buffer_reserve(d, GPU_USE_LIGHTS, "light bounds", &d->bound_buffer, sent ? d->bound_buffer.size : 0,
                              places * sizeof(struct gpu_entity_bounds)));
    if (scene->has_light_masks) {
        if (!d->masks.size) d->sent.lights = UINT64_MAX; /* it gets those of all */
        TRY(device_buffer_reserve(d, GPU_USE_LIGHTS, "light masks", &d->masks, d->masks.size, (d->sun_room + places) * sizeof(uint32_t)));
    }
    uint64_t plane_bytes = scene->hull_plane_count * sizeof(vec4);
    return device_buffer_reserve(d, GPU_USE_LIGHTS, "light planes", &d->planes, sent ? d->planes.size : 0, plane_bytes);
}

void device_lights_finish(struct device_scene *d) {
    gpu_buffer_destroy(d->device, &d->lights);
    gpu_buffer_destroy(d->device, &d->bound_buffer);
    gpu_buffer_destroy(d->device, &d->planes);
    gpu_buffer_destroy(d->device, &d->masks);
    array_free(&d->host, &d->sun_data);
    array_free(&d->host, &d->light_data);
    array_free(&d->host, &d->light_bounds);
    array_free(&d->host, &d->plane_data);
    array_free(&d->host, &d->bound_radii);
    ranges_finish(&d->host, &d->planes_taken);
}

/* ---- fading ---- */

/* What the GPU rounds differently stays in the lists: it finds no colour there. */
#define FADE_SLACK 1e-4f

static void unfade(struct device_scene *d) {
    for (uint32_t i = 0; i < d->bound_radii.count; i++) d->light_bounds.data[i].radius = d->bound_radii.data[i];
    d->bound_radii.count = 0;
}

static fnl_result copy_room(struct device_scene *d, const char *name, const struct gpu_buffer *of, struct gpu_buffer *copy) {
    if (copy->size >= of->size) return FNL_OK;
    gpu_buffer_destroy(d->device, copy);
    return gpu_buffer_create_for(d->device, GPU_USE_LIGHTS, name, of->size, GPU_MEMORY_DEVICE, copy);
}

fnl_result device_lights_fade(struct device_scene_user *user, const struct gpu_view *view, float lod, bool walk) {
    struct device_scene *d = user->scene;
    unfade(d);
    if (!(lod > 0)) return FNL_OK;
    TRY(copy_room(d, "faded lights", &d->lights, &user->faded_lights));
    TRY(copy_room(d, "faded bounds", &d->bound_buffer, &user->faded_bounds));
    if (!walk) return FNL_OK;
    if (!array_reserve(&d->host, &d->bound_radii, d->light_data.count)) return FNL_ERROR_MEMORY;
    for (uint32_t i = 0; i < d->light_data.count; i++) {
        struct gpu_entity_bounds *bounds = &d->light_bounds.data[i];
        d->bound_radii.data[d->bound_radii.count++] = bounds->radius;
        if (light_fade(view, bounds, lod * (1 - FADE_SLACK)) == 0) bounds->radius = 0;
    }
    return FNL_OK;
}

/* ---- sending them ---- */

/* Pieces of the buffers, one after the other in the slice. */
enum target { TO_LIGHTS, TO_BOUNDS, TO_PLANES, TO_MASKS, TARGETS };

struct piece {
    uint64_t offset, size;
    enum target target;
};

struct send_data {
    struct gpu_slice slice;
    const struct gpu_buffer *targets[TARGETS];
    const struct piece *pieces;          /* in the frame's memory */
    uint32_t piece_count;
};

static void execute_send(const struct graph_context *context, const void *data) {
    const struct send_data *d = data;
    uint64_t from = d->slice.offset;
    for (uint32_t i = 0; i < d->piece_count; i++) {
        gpu_copy_buffer(context->commands, d->slice.buffer, from, d->targets[d->pieces[i].target], d->pieces[i].offset,
                        d->pieces[i].size);
        from += d->pieces[i].size;
    }
}

struct send {
    struct send_data data;
    struct piece *pieces;
    uint64_t filled;
};

/* Memory of the frame for so many bytes to copy. */
static fnl_result begin_send(struct device_scene *d, uint64_t size, uint32_t most_pieces, struct send *out) {
    struct gpu_slice pieces = gpu_frame_allocate(d->device, most_pieces * sizeof(struct piece));
    *out = (struct send){.data = {.targets = {&d->lights, &d->bound_buffer, &d->planes, &d->masks},
                                  .slice = gpu_frame_allocate(d->device, size),
                                  .pieces = pieces.data},
                         .pieces = pieces.data};
    return pieces.data && out->data.slice.data ? FNL_OK : gpu_status(d->device);
}

static void add_piece(struct send *send, enum target target, uint64_t offset, const void *bytes, uint64_t size) {
    if (size == 0) return;
    memcpy((char *)send->data.slice.data + send->filled, bytes, size);
    send->filled += size;
    struct piece *last = send->data.piece_count ? &send->pieces[send->data.piece_count - 1] : NULL;
    if (last && last->target == target && last->offset + last->size == offset)
        last->size += size;
    else
        send->pieces[send->data.piece_count++] = (struct piece){offset, size, target};
}

/* As struct gpu_light_set has it. */
static uint32_t mask_of(const struct scene_light *light) {
    return light->params.mask | (uint32_t)half_from_float(light->params.contact_scale) << 16;
}

static void add_suns(const struct device_scene *d, struct send *send) {
    const uint32_t first = d->sun_room - d->sun_data.count;
    add_piece(send, TO_LIGHTS, first * sizeof(struct gpu_light), d->sun_data.data, d->sun_data.count * sizeof(struct gpu_light));
    if (!d->masks.size) return;
    const fnl_scene *scene = d->scene;
    for (uint32_t i = 0, at = first; i < scene->suns.count; i++) {
        const struct scene_light *light = &scene->lights.data[scene->suns.data[i]];
        const uint32_t mask = mask_of(light);
        if (is_lit(scene, light)) add_piece(send, TO_MASKS, at++ * sizeof mask, &mask, sizeof mask);
    }
}

static void add_mask(const struct device_scene *d, struct send *send, uint32_t slot) {
    const struct scene_light *light = light_at(d->scene, slot);
    const uint32_t mask = light ? mask_of(light) : 0;
    if (d->masks.size) add_piece(send, TO_MASKS, (d->sun_room + slot) * sizeof mask, &mask, sizeof mask);
}

static void end_send(struct device_scene *d, struct graph *graph, graph_buffer lights, const struct send *send) {
    d->light_bytes_sent += send->filled;
    if (send->data.piece_count == 0) return;
    struct graph_pass *pass =
        graph_add_pass(graph, "update lights", GRAPH_QUEUE_GRAPHICS, execute_send, &send->data, sizeof send->data);
    graph_use_buffer(pass, lights, GRAPH_COPY_TO);
}

static fnl_result send_all(struct device_scene *d, struct graph *graph, graph_buffer lights) {
    uint64_t count = d->scene->light_slot_end, light_size = count * sizeof(struct gpu_light),
             bound_size = count * sizeof(struct gpu_entity_bounds), plane_size = d->planes_taken.end * sizeof(vec4);
    struct send send;
    const uint64_t mask_size = d->masks.size ? (d->sun_data.count + count) * sizeof(uint32_t) : 0;
    TRY(begin_send(d, MAX(d->sun_data.count * sizeof(struct gpu_light) + light_size + bound_size + plane_size + mask_size, 1u), 6, &send));
    add_suns(d, &send);
    add_piece(&send, TO_LIGHTS, d->sun_room * sizeof(struct gpu_light), d->light_data.data, light_size);
    add_piece(&send, TO_BOUNDS, 0, d->light_bounds.data, bound_size);
    add_piece(&send, TO_PLANES, 0, d->plane_data.data, plane_size);
    for (uint32_t slot = 0; slot < count && d->masks.size; slot++) add_mask(d, &send, slot);
    end_send(d, graph, lights, &send);
    return FNL_OK;
}

static fnl_result gather_and_send(struct device_scene *d, struct graph *graph, graph_buffer lights) {
    TRY(device_lights_gather(d));
    return send_all(d, graph, lights);
}

static fnl_result send_changed(struct device_scene *d, struct graph *graph, graph_buffer lights) {
    struct changes changes = changes_of(d);
    uint32_t count = 0;
    uint64_t size = 0;
    unfade(d);
    TRY(reserve_places(d));
    for (uint32_t i = 0; i < changes.count; i++) {
        uint32_t slot = change_at(d, &changes, i);
        if (slot == SCENE_NONE) continue;
        if (!refresh(d, slot)) return gather_and_send(d, graph, lights);
        size += sizeof(struct gpu_light) + sizeof(struct gpu_entity_bounds) + d->light_data.data[slot].shape.hull_count * sizeof(vec4) +
                (d->masks.size ? sizeof(uint32_t) : 0);
        count++;
    }
    bool suns = d->scene->sun_version > d->sent.lights;
    if (suns) TRY(gather_suns(d));
    if (count > (d->sun_data.count + d->scene->light_slot_end) / 2) return send_all(d, graph, lights); /* in one piece */
    if (suns) size += d->sun_data.count * (sizeof(struct gpu_light) + (d->masks.size ? sizeof(uint32_t) : 0));
    if (size == 0) return FNL_OK;
    struct send send;
    TRY(begin_send(d, size, 4 * count + 2, &send));
    if (suns) add_suns(d, &send);
    for (uint32_t i = 0; i < changes.count; i++) {
        uint32_t slot = change_at(d, &changes, i);
        if (slot == SCENE_NONE) continue;
        const struct gpu_light *g = &d->light_data.data[slot];
        const struct gpu_entity_bounds *bounds = &d->light_bounds.data[slot];
        add_piece(&send, TO_LIGHTS, (d->sun_room + slot) * sizeof *g, g, sizeof *g);
        add_piece(&send, TO_BOUNDS, slot * sizeof *bounds, bounds, sizeof *bounds);
        add_piece(&send, TO_PLANES, g->shape.hull_first * sizeof(vec4), d->plane_data.data + g->shape.hull_first,
                  g->shape.hull_count * sizeof(vec4));
        add_mask(d, &send, slot);
    }
    end_send(d, graph, lights, &send);
    return FNL_OK;
}

void device_lights_updates(const struct device_scene *d, uint32_t *out) {
    const fnl_scene *scene = d->scene;
#define UPDATE_OF(light) ((light) && (light)->params.shadow_update == FNL_SHADOW_UPDATE_ON_REQUEST ? (light)->shadow_request + 1 : 0)
    for (uint32_t i = 0; i < scene->suns.count; i++) {
        const struct scene_light *light = &scene->lights.data[scene->suns.data[i]];
        if (is_lit(scene, light)) *out++ = UPDATE_OF(light);
    }
    for (uint32_t slot = 0; slot < scene->light_slot_end; slot++) {
        const struct scene_light *light = light_at(scene, slot);
        *out++ = UPDATE_OF(light);
    }
#undef UPDATE_OF
}

fnl_result device_lights_add(struct device_scene *d, struct graph *graph, graph_buffer lights) {
    d->light_bytes_sent = 0;
    if (d->sent.lights == d->scene->light_version) return FNL_OK;
    TRY(must_gather(d) ? gather_and_send(d, graph, lights) : send_changed(d, graph, lights));
    d->sent.lights = d->scene->light_version;
    return FNL_OK;
}

struct light_set device_lights_set(const struct device_scene *d, graph_buffer lights) {
    uint32_t local_count = d->scene->light_slot_end;
    VkDeviceAddress first_place = d->lights.address + d->sun_room * sizeof(struct gpu_light);
    struct light_set set = {.buffer = lights,
                            .entities = d->bound_buffer.address,
                            .shapes = first_place,
                            .planes = d->planes.address,
                            .lights = first_place - d->sun_data.count * sizeof(struct gpu_light),
                            .masks = d->masks.size ? d->masks.address + (d->sun_room - d->sun_data.count) * sizeof(uint32_t) : 0,
                            .profiles = d->profiled_count > 0 ? d->profiles.buffer.address : 0,
                            .lobes = d->area_count > 0 ? d->lobes.buffer.address : 0,
                            .simple = d->shaped_count == 0,
                            .directional_count = d->sun_data.count,
                            .local_count = local_count,
                            .unlit_count = local_count - d->lit_count};
    light_set_send(d->device, &set);
    return set;
}
