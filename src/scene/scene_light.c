/* SPDX-License-Identifier: MIT */
/* Lights that come, change and go, and the places that they keep meanwhile. */
#include "scene/light_kinds.h"
#include "scene/scene.h"

/** glTF lights sit at their node's origin and shine along its -Z axis; the node's scale does not matter. */
static void pose_light(const fnl_scene *scene, struct scene_light *light) {
    const float *m = scene->nodes.data[light->node].world.m;
    light->params.position = vec3_make(m[12], m[13], m[14]);
    vec3 direction = vec3_normalize(vec3_make(-m[8], -m[9], -m[10]));
    light->params.direction = vec3_dot(direction, direction) > 0 ? direction : vec3_make(0, 0, -1);
    light->params.up = light_up(light->params.direction, vec3_make(m[4], m[5], m[6]));
}

/* ---- places: free ones form a heap with the lowest on top, so that those in use stay dense ---- */

fnl_result scene_reserve_lights(fnl_scene *scene, uint32_t count) {
    const fnl_host *host = &scene->host;
    if (count == 0) return FNL_OK;
    const uint32_t local = scene->light_slots.count - scene->free_light_slots.count;
    const uint64_t fresh = count > scene->free_light_slots.count ? count - scene->free_light_slots.count : 0;
    const uint64_t slots = scene->light_slots.count + fresh, lights = (uint64_t)scene->lights.count + count;
    if (slots > SCENE_LOCAL_LIGHTS_MAX) {
        log_error(host, "%s: too many lights: %u to add to %u that are not directional, of which there can be at most %d",
                  scene->source, count, local, SCENE_LOCAL_LIGHTS_MAX);
        return FNL_ERROR_UNSUPPORTED;
    }
    bool room = lights < SCENE_NONE && array_reserve(host, &scene->lights, lights) &&
                array_reserve(host, &scene->light_slots, slots) && array_reserve(host, &scene->free_light_slots, slots) &&
                array_reserve(host, &scene->suns, (uint64_t)scene->suns.count + count) && array_reserve(host, &scene->unlimited, lights);
    if (!room) log_error(host, "%s: no memory for %u more lights", scene->source, count);
    return room ? FNL_OK : FNL_ERROR_MEMORY;
}

static void put_free_slot(fnl_scene *scene, uint32_t slot) {
    uint32_t *heap = scene->free_light_slots.data, at = scene->free_light_slots.count++;
    for (; at > 0 && heap[(at - 1) / 2] > slot; at = (at - 1) / 2) heap[at] = heap[(at - 1) / 2];
    heap[at] = slot;
}

static uint32_t take_free_slot(fnl_scene *scene) {
    uint32_t *heap = scene->free_light_slots.data, first = heap[0], count = --scene->free_light_slots.count;
    uint32_t last = heap[count], at = 0;
    for (uint32_t child; (child = 2 * at + 1) < count; at = child) {
        if (child + 1 < count && heap[child + 1] < heap[child]) child++;
        if (heap[child] >= last) break;
        heap[at] = heap[child];
    }
    heap[at] = last;
    return first;
}

/* At the present light_version. */
static void list_changed_slot(fnl_scene *scene, uint32_t slot) {
    struct scene_light_slot *place = &scene->light_slots.data[slot];
    bool listed = place->changed_version > scene->changed_slots_since;
    place->changed_version = scene->light_version;
    if (listed) return;
    uint32_t limit = 1024 + scene->light_slots.count / 16; /* as for nodes that move */
    if (scene->changed_slots.count < limit && array_push(&scene->host, &scene->changed_slots, slot)) return;
    scene->changed_slots.count = 0;
    scene->changed_slots_since = scene->light_version++;
}

/* Puts a directional light into the list of those, or takes it out. */
static void list_sun(fnl_scene *scene, uint32_t light, bool is_sun) {
    uint32_t at = 0;
    for (uint32_t high = scene->suns.count; at < high;) {
        uint32_t middle = at + (high - at) / 2;
        if (scene->suns.data[middle] < light)
            at = middle + 1;
        else
            high = middle;
    }
    uint32_t *place = scene->suns.data + at;
    bool was_sun = at < scene->suns.count && *place == light;
    if (was_sun || is_sun) scene->sun_version = scene->light_version;
    if (was_sun && !is_sun) {
        scene->suns.count--;
        memmove(place, place + 1, (scene->suns.count - at) * sizeof *place);
    } else if (is_sun && !was_sun) {
        memmove(place + 1, place, (scene->suns.count - at) * sizeof *place);
        *place = light;
        scene->suns.count++;
    }
}

/* Puts a light without a range into the list of those, or takes it out. */
static void list_unlimited(fnl_scene *scene, uint32_t index) {
    struct scene_light *light = &scene->lights.data[index];
    const bool is = light_is_unlimited(light), was = light->unlimited_at != SCENE_NONE;
    if (is == was) return;
    if (is) {
        light->unlimited_at = scene->unlimited.count;
        scene->unlimited.data[scene->unlimited.count++] = index;
        return;
    }
    const uint32_t last = scene->unlimited.data[--scene->unlimited.count];
    scene->unlimited.data[light->unlimited_at] = last;
    scene->lights.data[last].unlimited_at = light->unlimited_at;
    light->unlimited_at = SCENE_NONE;
}

/* Gives a light what it lacks of a place and takes what it no longer needs. Room is reserved. */
static void place_light(fnl_scene *scene, uint32_t index) {
    struct scene_light *light = &scene->lights.data[index];
    bool directional = light->params.kind == FNL_LIGHT_DIRECTIONAL;
    scene->has_area_lights |= light_kinds[light->params.kind].info.area;
    scene_use_light_masks(scene, light->params.mask != 255 || light->params.contact_scale != 1);
    scene->has_requested |= light->params.shadow_update == FNL_SHADOW_UPDATE_ON_REQUEST;
    list_sun(scene, index, directional && scene_light_shines(light));
    list_unlimited(scene, index);
    bool local = !directional && scene_light_shines(light);
    uint32_t slot = light->slot;
    if (slot == SCENE_NONE && local) {
        if (scene->free_light_slots.count) {
            slot = take_free_slot(scene);
        } else {
            slot = scene->light_slots.count++;
            scene->light_slots.data[slot].changed_version = 0;
        }
        light->slot = slot;
        scene->light_slots.data[slot].light = index;
        scene->light_slot_end = MAX(scene->light_slot_end, slot + 1);
    } else if (slot != SCENE_NONE && !local) {
        light->slot = SCENE_NONE;
        scene->light_slots.data[slot].light = SCENE_NONE;
        put_free_slot(scene, slot);
        while (scene->light_slot_end && scene->light_slots.data[scene->light_slot_end - 1].light == SCENE_NONE)
            scene->light_slot_end--;
    }
    if (slot != SCENE_NONE) list_changed_slot(scene, slot);
}

/* ---- what happens to lights ---- */

void scene_lights_changed(fnl_scene *scene) {
    scene->light_set_version = scene->changed_slots_since = scene->sun_version = ++scene->light_version;
    scene->changed_slots.count = 0;
}

void scene_light_changed(fnl_scene *scene, uint32_t light) {
    scene->light_version++;
    place_light(scene, light);
}

void scene_lights_edited(fnl_scene *scene, const fnl_light_id *lights, uint32_t count) {
    scene->light_version++;
    for (uint32_t i = 0; i < count; i++) place_light(scene, lights[i].index);
}

void scene_put_light(fnl_scene *scene, uint32_t index, const fnl_light_params *params, uint32_t node) {
    struct scene_light light = {.params = *params,
                                .node = node,
                                .slot = SCENE_NONE,
                                .unlimited_at = SCENE_NONE,
                                .reach = 1e18f,
                                .generation = scene_take_generation(scene),
                                .shadow_request = scene->shadow_requests++};
    if (node != SCENE_NONE) pose_light(scene, &light);
    place_from_vec3(light.params.position, scene->origin, light.place);
    scene->lights.data[index] = light;
    scene_light_changed(scene, index);
}

uint32_t scene_add_light(fnl_scene *scene, const fnl_light_params *params, uint32_t node) {
    uint32_t index;
    if (scene_reserve_lights(scene, 1) != FNL_OK) return SCENE_NONE;
    if (scene->free_lights.count > 0) {
        index = scene->free_lights.data[--scene->free_lights.count];
        scene->hole_counts[SCENE_LIGHTS]--;
    } else {
        index = scene_take_holes(scene, SCENE_LIGHTS, 1);
        if (index == SCENE_NONE) index = scene->lights.count++;
    }
    scene_put_light(scene, index, params, node);
    return index;
}

void scene_remove_light(fnl_scene *scene, uint32_t index) {
    light_hull_free(scene, &scene->lights.data[index]);
    scene->lights.data[index].removed = true;
    scene->lights.data[index].staged = false;
    scene->hole_counts[SCENE_LIGHTS]++;
    if (!scene_is_reserved(scene, SCENE_LIGHTS, index)) scene->free_lights.data[scene->free_lights.count++] = index;
    scene_light_changed(scene, index);
}

void scene_pose_lights(fnl_scene *scene, uint64_t version) {
    bool any = false;
    for (uint32_t i = 0; i < scene->lights.count; i++) {
        struct scene_light *light = &scene->lights.data[i];
        if (light->removed || light->node == SCENE_NONE || scene->nodes.data[light->node].moved_version != version) continue;
        pose_light(scene, light);
        if (!any) scene->light_version++;
        place_light(scene, i);
        any = true;
    }
}

void scene_show_lights(fnl_scene *scene, uint32_t root) {
    const struct scene_node *nodes = scene->nodes.data;
    scene->light_version++;
    for (uint32_t i = 0; i < scene->lights.count; i++) {
        uint32_t node = scene->lights.data[i].removed ? SCENE_NONE : scene->lights.data[i].node;
        while (node != SCENE_NONE && node != root) node = nodes[node].parent;
        if (node != SCENE_NONE) place_light(scene, i);
    }
}

/* ---- profiles ---- */

fnl_result scene_add_profile(fnl_scene *scene, const fnl_host *host, const char *name, const void *data, size_t size, fnl_light_profile_id *out) {
    struct light_profile profile = {0};
    struct arena memory;
    const bool room = array_reserve(&scene->host, &scene->profiles, (uint64_t)scene->profiles.count + 1);
    arena_init(&memory, &scene->host, 1024);
    fnl_result result = room ? ies_read(host, &memory, name, data, size, &profile) : FNL_ERROR_MEMORY;
    if (result == FNL_ERROR_MEMORY) log_error(host, "%s: memory ran out", name);
    if (result == FNL_OK && (uint64_t)scene->profile_floats.end + light_profile_floats(&profile) >= SCENE_PROFILE_FLOATS_MAX) {
        log_error(host, "%s: the scene has no room for more light profiles", name);
        result = FNL_ERROR_UNSUPPORTED;
    }
    if (result != FNL_OK) {
        arena_finish(&memory);
        return result;
    }
    profile.memory = memory;
    const uint32_t index = scene_take_place(scene, SCENE_PROFILES, &scene->profiles); /* there is room */
    scene_place_profile(scene, index, &profile);
    *out = (fnl_light_profile_id){index, scene->profiles.data[index].generation};
    return FNL_OK;
}

/* Shaders find a profile by a float; 0 is none. */
void scene_place_profile(fnl_scene *scene, uint32_t index, const struct light_profile *profile) {
    scene->profiles.data[index] = *profile;
    scene->profiles.data[index].generation = scene_take_generation(scene);
    scene->profiles.data[index].offset = ranges_take(&scene->profile_floats, light_profile_floats(profile));
    scene->profile_version++;
}

const struct light_profile *scene_light_profile(const fnl_scene *scene, const fnl_light_params *light) {
    return light_is_profiled(light) ? &scene->profiles.data[light->profile.index] : NULL;
}
