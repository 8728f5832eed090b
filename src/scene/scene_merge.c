/* SPDX-License-Identifier: MIT */
/* A loaded file becomes a part of another scene: arrays are appended, and indices move on by what was there. */
#include "scene/scene.h"

/* How much indices of the file grow. */
struct offsets {
    uint32_t images, samplers, materials, primitives, meshes, nodes, skins, animations, lights, cameras, decals, probes, variants;
};

static uint32_t moved(uint32_t index, uint32_t offset) { return index == SCENE_NONE ? SCENE_NONE : index + offset; }

#define ROOM(name)                                                                                                          \
    ((uint64_t)into->name.count + from->name.count < SCENE_NONE &&                                                          \
     array_reserve(&into->host, &into->name, (uint64_t)into->name.count + from->name.count))

/* All that can fail. */
static fnl_result make_room(fnl_scene *into, const fnl_scene *from) {
    uint64_t nodes = (uint64_t)into->nodes.count + from->nodes.count + 1; /* the root is one more */
    bool room = ROOM(files) && ROOM(resources) && ROOM(sources) && ROOM(images) && ROOM(samplers) && ROOM(materials) && ROOM(primitives) &&
                ROOM(meshes) && ROOM(skins) && ROOM(animations) && ROOM(decals) && ROOM(probes) && ROOM(painted) && ROOM(cameras) &&
                ROOM(variants) && ROOM(profiles) && ROOM(levels) && into->profile_floats + from->profile_floats < SCENE_PROFILE_FLOATS_MAX && ROOM(packets) && ROOM(extensions) && ROOM(messages) && nodes < SCENE_NONE &&
                array_reserve(&into->host, &into->nodes, nodes) && array_reserve(&into->host, &into->parts, (uint64_t)into->parts.count + 1);
    if (room) return scene_reserve_lights(into, from->lights.count);
    log_error(&into->host, "%s: there is no room in %s", from->source, into->source); /* memory, or indices */
    return FNL_ERROR_MEMORY;
}

#define APPEND(name)                                                                                                        \
    do {                                                                                                                    \
        if (from->name.count)                                                                                               \
            memcpy(into->name.data + into->name.count, from->name.data, from->name.count * sizeof *from->name.data);        \
        into->name.count += from->name.count;                                                                               \
    } while (0)

static void append_materials(fnl_scene *into, const fnl_scene *from, const struct offsets *at) {
    APPEND(images);
    APPEND(samplers);
    APPEND(materials);
    for (uint32_t i = at->materials; i < into->materials.count; i++)
        for (uint32_t slot = 0; slot < SCENE_TEXTURE_SLOT_COUNT; slot++) {
            struct scene_texture *texture = &into->materials.data[i].textures[slot];
            texture->image = moved(texture->image, at->images);
            texture->sampler += at->samplers;
        }
}

static void append_meshes(fnl_scene *into, const fnl_scene *from, const struct offsets *at) {
    APPEND(primitives);
    APPEND(meshes);
    APPEND(variants);
    for (uint32_t i = at->primitives; i < into->primitives.count; i++) {
        struct scene_primitive *primitive = &into->primitives.data[i];
        struct scene_mapping *mappings = (struct scene_mapping *)primitive->mappings; /* as in append_animations() */
        primitive->material = moved(primitive->material, at->materials);
        primitive->standard_material = moved(primitive->standard_material, at->materials);
        for (uint32_t k = 0; k < primitive->mapping_count; k++) {
            mappings[k].variant += at->variants;
            mappings[k].material += at->materials;
        }
    }
    for (uint32_t i = at->variants; i < into->variants.count; i++) into->variants.data[i].first += at->variants;
    for (uint32_t i = at->meshes; i < into->meshes.count; i++) into->meshes.data[i].first_primitive += at->primitives;
}

/*
 * The file's roots become children of `root`, in their order. Entities without a node keep their places, now relative
 * to the scene's origin: a file may have had its own origin.
 */
static void append_nodes(fnl_scene *into, const fnl_scene *from, const struct offsets *at, uint32_t root) {
    APPEND(nodes);
    struct scene_node *nodes = into->nodes.data;
    uint32_t *link = &nodes[root].first_child;
    for (uint32_t i = at->nodes; i < into->nodes.count; i++) {
        struct scene_node *node = &nodes[i];
        bool is_root = node->parent == SCENE_NONE;
        node->parent = is_root ? root : node->parent + at->nodes;
        node->first_child = moved(node->first_child, at->nodes);
        node->next_sibling = moved(node->next_sibling, at->nodes);
        node->mesh = moved(node->mesh, at->meshes);
        node->skin = moved(node->skin, at->skins);
        node->camera = moved(node->camera, at->cameras);
        node->generation = scene_take_generation(into);
        node->moved_version = node->edited_version = 0;
        if (!is_root) continue;
        *link = i;
        link = &node->next_sibling;
    }
    const uint32_t first_levels = into->levels.count;
    APPEND(levels);
    for (uint32_t i = first_levels; i < into->levels.count; i++) {
        uint32_t *members = (uint32_t *)into->levels.data[i].nodes; /* as in append_animations() */
        for (uint32_t k = 0; k < into->levels.data[i].count; k++) members[k] += at->nodes;
    }
    /* Lights, cameras and skins look at the nodes above them. */
    for (uint32_t i = root; i != SCENE_NONE; i = nodes[i].parent) nodes[i].linked = true;
    scene_activate(into, root);
}

/* Arrays of the file's own, in memory that goes over to the scene: they change where they are. */
static void append_animations(fnl_scene *into, const fnl_scene *from, const struct offsets *at) {
    APPEND(skins);
    APPEND(animations);
    for (uint32_t i = at->skins; i < into->skins.count; i++) {
        uint32_t *joints = (uint32_t *)into->skins.data[i].joints;
        for (uint32_t k = 0; k < into->skins.data[i].joint_count; k++) joints[k] += at->nodes;
    }
    for (uint32_t i = at->animations; i < into->animations.count; i++) {
        struct scene_channel *channels = (struct scene_channel *)into->animations.data[i].channels;
        for (uint32_t k = 0; k < into->animations.data[i].channel_count; k++) channels[k].node = moved(channels[k].node, at->nodes);
    }
}

/* After all that they set. No light before the animated ones was removed: those of an environment come after them. */
static void move_properties(fnl_scene *into, const struct offsets *at) {
    for (uint32_t i = at->animations; i < into->animations.count; i++) {
        struct scene_channel *channels = (struct scene_channel *)into->animations.data[i].channels;
        for (uint32_t k = 0; k < into->animations.data[i].channel_count; k++) {
            if (!channels[k].property) continue;
            const enum scene_property_owner owner = channels[k].property->owner;
            channels[k].object += owner == SCENE_PROPERTY_MATERIAL ? at->materials : owner == SCENE_PROPERTY_LIGHT ? at->lights : at->cameras;
            if (owner == SCENE_PROPERTY_ENVIRONMENT) channels[k].object = SCENE_NONE; /* it stays with its file */
            if (owner == SCENE_PROPERTY_LIGHT) channels[k].generation = into->lights.data[channels[k].object].generation;
        }
    }
}

static void append_cameras(fnl_scene *into, const fnl_scene *from, const struct offsets *at) {
    APPEND(cameras);
    for (uint32_t i = at->cameras; i < into->cameras.count; i++)
        into->cameras.data[i].node = moved(into->cameras.data[i].node, at->nodes);
}

static void append_lights(fnl_scene *into, const fnl_scene *from, const struct offsets *at) {
    const uint32_t holes = into->free_lights.count;
    const uint32_t first_profile = into->profiles.count;
    for (uint32_t i = 0; i < from->profiles.count; i++) { /* there is room */
        struct light_profile profile = from->profiles.data[i];
        profile.generation = scene_take_generation(into);
        scene_place_profile(into, &profile);
    }
    into->free_lights.count = 0; /* they go to the end, in their order */
    for (uint32_t i = 0; i < from->lights.count; i++) {
        const struct scene_light *light = &from->lights.data[i];
        if (light->removed) continue; /* of its environment */
        fnl_light_params params = light->params;
        if (params.profile.generation) {
            params.profile.index += first_profile;
            params.profile.generation = into->profiles.data[params.profile.index].generation;
        }
        uint32_t index = scene_add_light(into, &params, moved(light->node, at->nodes)); /* there is room */
        into->lights.data[index].name = light->name;
        into->lights.data[index].extras = light->extras;
    }
    into->free_lights.count = holes;
}

static void append_decals(fnl_scene *into, const fnl_scene *from, const struct offsets *at) {
    APPEND(decals);
    APPEND(painted);
    for (uint32_t i = at->decals; i < into->decals.count; i++) {
        struct scene_decal *decal = &into->decals.data[i];
        fnl_decal_params *params = &decal->params;
        fnl_image_id *images[] = {&params->color_image, &params->normal_image, &params->metallic_roughness_image,
                                  &params->emissive_image};
        decal->node = moved(decal->node, at->nodes);
        decal->generation = scene_take_generation(into);
        if (params->instance.generation) {
            params->instance.index += at->nodes;
            params->instance.generation = into->nodes.data[params->instance.index].generation;
        }
        for (uint32_t k = 0; k < COUNT_OF(images); k++)
            if (images[k]->generation) images[k]->index += at->images;
    }
    for (uint32_t i = into->painted.count - from->painted.count; i < into->painted.count; i++) {
        into->painted.data[i].node += at->nodes;
        into->painted.data[i].mesh += at->meshes;
        into->painted.data[i].own_mesh += at->meshes;
    }
    if (from->decals.count) into->decal_version++;
}

/* In the world as they are: they do not move with the root. */
static void append_probes(fnl_scene *into, const fnl_scene *from, const struct offsets *at) {
    APPEND(probes);
    if (from->probes.count) into->probe_version++;
    for (uint32_t i = at->probes; i < into->probes.count; i++) {
        into->probes.data[i].generation = scene_take_generation(into);
        into->probes.data[i].params.centre = vec3_from_place(into->probes.data[i].place, into->origin);
        into->probes.data[i].version = into->probe_version;
    }
}

static void append_words(fnl_scene *into, const fnl_scene *from) {
    APPEND(messages);
    APPEND(packets);
    for (uint32_t i = 0; i < from->extensions.count; i++) {
        const struct scene_extension *extension = &from->extensions.data[i];
        uint32_t known = 0;
        while (known < into->extensions.count && strcmp(into->extensions.data[known].name, extension->name) != 0) known++;
        if (known == into->extensions.count)
            into->extensions.data[into->extensions.count++] = *extension;
        else
            into->extensions.data[known].required |= extension->required;
    }
}

fnl_result scene_merge(fnl_scene *into, uint32_t parent, fnl_scene *from, fnl_loaded *out) {
    fnl_loaded loaded = {.root = {0}};
    for (int kind = 0; kind < FNL_ENTITY_COUNT; kind++) loaded.first[kind] = scene_entity_count(into, (fnl_entity)kind);
    TRY(make_room(into, from));

    const uint32_t holes = into->free_nodes.count;
    const mat4 identity = mat4_identity();
    into->free_nodes.count = 0; /* the root stands before its nodes */
    const uint32_t root = scene_add_node(into, from->source, parent, &identity, SCENE_NONE);
    into->free_nodes.count = holes;
    into->nodes.data[root].local_exact = affine_identity(); /* the file's coordinates, independent of the origin */
    const struct offsets at = {into->images.count,     into->samplers.count, into->materials.count, into->primitives.count,
                               into->meshes.count,     into->nodes.count,    into->skins.count,     into->animations.count,
                               into->lights.count,     into->cameras.count,  into->decals.count,
                               into->probes.count,     into->variants.count};
    into->parts.data[into->parts.count++] = (struct scene_part){root,
                                                                into->nodes.data[root].generation,
                                                                at.images,
                                                                from->images.count,
                                                                at.materials,
                                                                from->materials.count,
                                                                into->files.count,
                                                                from->files.count};
    APPEND(files);
    APPEND(resources);
    APPEND(sources);
    append_materials(into, from, &at);
    append_meshes(into, from, &at);
    append_nodes(into, from, &at, root);
    append_animations(into, from, &at);
    append_cameras(into, from, &at);
    scene_update_transforms(into);
    append_lights(into, from, &at);
    move_properties(into, &at);
    append_decals(into, from, &at);
    append_probes(into, from, &at);
    scene_use_light_masks(into, from->has_light_masks);
    append_words(into, from);
    scene_materials_changed(into);
    arena_adopt(&into->arena, &from->arena);
    from->files.count = from->resources.count = from->nodes.count = from->primitives.count = 0; /* they are the scene's now */

    loaded.root = (fnl_instance_id){root, into->nodes.data[root].generation};
    for (int kind = 0; kind < FNL_ENTITY_COUNT; kind++)
        loaded.count[kind] = scene_entity_count(into, (fnl_entity)kind) - loaded.first[kind];
    if (out) *out = loaded;
    return FNL_OK;
}
