/* SPDX-License-Identifier: MIT */
/* A loaded file becomes a part of another scene: arrays are appended, and indices move on by what was there. */
#include "scene/scene.h"

static uint32_t moved(uint32_t index, uint32_t offset) { return index == SCENE_NONE ? SCENE_NONE : index + offset; }

#define ROOM(name)                                                                                                          \
    ((uint64_t)into->name.count + from->name.count < SCENE_NONE &&                                                          \
     array_reserve(&into->host, &into->name, (uint64_t)into->name.count + from->name.count))

/* All that can fail. */
static fnl_result make_room(fnl_scene *into, const fnl_scene *from) {
    uint64_t nodes = (uint64_t)into->nodes.count + from->nodes.count + 1; /* the root is one more */
    const bool room = ROOM(files) && ROOM(resources) && ROOM(sources) && ROOM(images) && ROOM(samplers) && ROOM(materials) && ROOM(primitives) &&
                ROOM(meshes) && ROOM(skins) && ROOM(animations) && ROOM(decals) && ROOM(probes) && ROOM(painted) && ROOM(cameras) &&
                ROOM(variants) && ROOM(profiles) && ROOM(levels) && (uint64_t)into->profile_floats.end + from->profile_floats.end < SCENE_PROFILE_FLOATS_MAX && ROOM(packets) && ROOM(extensions) && ROOM(messages) && nodes < SCENE_NONE &&
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

/* A run of holes, or the end of the array, where there is room; the caller raises the array's count. */
static struct range take_block(fnl_scene *into, enum scene_pool pool, uint32_t count, uint32_t end) {
    const uint32_t first = scene_take_holes(into, pool, count);
    return (struct range){first == SCENE_NONE ? end : first, count};
}

/* Copies an array into its block. */
#define PUT(name, block)                                                                                                    \
    do {                                                                                                                    \
        if ((block).count) memcpy(into->name.data + (block).first, from->name.data, (block).count * sizeof *from->name.data); \
        into->name.count = MAX(into->name.count, (block).first + (block).count);                                            \
    } while (0)

/* The element at an index before PUT; zeros beyond the end. */
#define WAS(name, i) ((i) < into->name.count ? into->name.data[i] : (__typeof__(*into->name.data)){0})

static void put_images(fnl_scene *into, fnl_scene *from, const struct range *block) {
    for (uint32_t i = 0; i < block->count; i++) {
        const struct scene_image was = WAS(images, block->first + i);
        from->images.data[i].version += was.version + (was.generation > 0);
        from->images.data[i].generation = was.generation + 1;
    }
    PUT(images, *block);
}

static void put_materials(fnl_scene *into, fnl_scene *from, const struct range *blocks) {
    const struct range *block = &blocks[SCENE_MATERIALS];
    for (uint32_t i = 0; i < block->count; i++) {
        struct scene_material *material = &from->materials.data[i];
        material->generation = WAS(materials, block->first + i).generation + 1;
        for (uint32_t slot = 0; slot < SCENE_TEXTURE_SLOT_COUNT; slot++) {
            struct scene_texture *texture = &material->textures[slot];
            texture->image = moved(texture->image, blocks[SCENE_IMAGES].first);
            texture->sampler += blocks[SCENE_SAMPLERS].first;
        }
    }
    PUT(samplers, blocks[SCENE_SAMPLERS]);
    PUT(materials, *block);
}

static void put_meshes(fnl_scene *into, fnl_scene *from, const struct range *blocks) {
    const struct range *primitives = &blocks[SCENE_PRIMITIVES], *meshes = &blocks[SCENE_MESHES];
    for (uint32_t i = 0; i < primitives->count; i++) {
        struct scene_primitive *primitive = &from->primitives.data[i];
        struct scene_mapping *mappings = (struct scene_mapping *)primitive->mappings; /* as in put_animations() */
        const bool reused = primitives->first + i < into->primitives.count;
        primitive->version += reused ? into->primitives.data[primitives->first + i].version + 1 : 0;
        primitive->shape_version += reused ? into->primitives.data[primitives->first + i].shape_version + 1 : 0;
        primitive->material = moved(primitive->material, blocks[SCENE_MATERIALS].first);
        primitive->standard_material = moved(primitive->standard_material, blocks[SCENE_MATERIALS].first);
        for (uint32_t k = 0; k < primitive->mapping_count; k++) {
            mappings[k].variant += blocks[SCENE_VARIANTS].first;
            mappings[k].material += blocks[SCENE_MATERIALS].first;
        }
    }
    for (uint32_t i = 0; i < from->variants.count; i++) from->variants.data[i].first += blocks[SCENE_VARIANTS].first;
    for (uint32_t i = 0; i < meshes->count; i++) {
        from->meshes.data[i].first_primitive += primitives->first;
        from->meshes.data[i].generation = WAS(meshes, meshes->first + i).generation + 1;
    }
    PUT(primitives, *primitives);
    PUT(meshes, *meshes);
    PUT(variants, blocks[SCENE_VARIANTS]);
}

/*
 * The file's roots become children of `root`, in their order. Entities without a node keep their places, now relative
 * to the scene's origin: a file may have had its own origin.
 */
static void put_nodes(fnl_scene *into, fnl_scene *from, const struct range *blocks, uint32_t root) {
    const struct range block = {root + 1, from->nodes.count};
    for (uint32_t i = 0; i < block.count; i++) { /* holes may still be in the lists of nodes that moved and changed */
        const bool reused = block.first + i < into->nodes.count;
        from->nodes.data[i].moved_version = reused ? into->nodes.data[block.first + i].moved_version : 0;
        from->nodes.data[i].edited_version = reused ? into->nodes.data[block.first + i].edited_version : 0;
    }
    PUT(nodes, block);
    struct scene_node *nodes = into->nodes.data;
    uint32_t *link = &nodes[root].first_child;
    for (uint32_t i = block.first; i < block.first + block.count; i++) {
        struct scene_node *node = &nodes[i];
        bool is_root = node->parent == SCENE_NONE;
        node->parent = is_root ? root : node->parent + block.first;
        node->first_child = moved(node->first_child, block.first);
        node->next_sibling = moved(node->next_sibling, block.first);
        node->mesh = moved(node->mesh, blocks[SCENE_MESHES].first);
        node->skin = moved(node->skin, blocks[SCENE_SKINS].first);
        node->camera = moved(node->camera, blocks[SCENE_CAMERAS].first);
        node->generation = scene_take_generation(into);
        if (!is_root) continue;
        *link = i;
        link = &node->next_sibling;
    }
    const uint32_t first_levels = into->levels.count;
    APPEND(levels);
    for (uint32_t i = first_levels; i < into->levels.count; i++) {
        uint32_t *members = (uint32_t *)into->levels.data[i].nodes; /* as in put_animations() */
        for (uint32_t k = 0; k < into->levels.data[i].count; k++) members[k] += block.first;
    }
    /* Lights, cameras and skins look at the nodes above them. */
    for (uint32_t i = root; i != SCENE_NONE; i = nodes[i].parent) nodes[i].linked = true;
    scene_activate(into, root);
}

/* Arrays of the file's own, in memory that goes over to the scene: they change where they are. */
static void put_animations(fnl_scene *into, const fnl_scene *from, const struct range *blocks, uint32_t first_node) {
    PUT(skins, blocks[SCENE_SKINS]);
    PUT(animations, blocks[SCENE_ANIMATIONS]);
    for (uint32_t i = 0; i < from->skins.count; i++) {
        uint32_t *joints = (uint32_t *)from->skins.data[i].joints;
        for (uint32_t k = 0; k < from->skins.data[i].joint_count; k++) joints[k] += first_node;
    }
    for (uint32_t i = 0; i < from->animations.count; i++) {
        struct scene_channel *channels = (struct scene_channel *)from->animations.data[i].channels;
        for (uint32_t k = 0; k < from->animations.data[i].channel_count; k++) channels[k].node = moved(channels[k].node, first_node);
    }
}

/* After all that they set. No light before the animated ones was removed: those of an environment come after them. */
static void move_properties(const fnl_scene *into, const fnl_scene *from, const struct range *blocks) {
    for (uint32_t i = 0; i < from->animations.count; i++) {
        struct scene_channel *channels = (struct scene_channel *)from->animations.data[i].channels;
        for (uint32_t k = 0; k < from->animations.data[i].channel_count; k++) {
            if (!channels[k].property) continue;
            const enum scene_property_owner owner = channels[k].property->owner;
            channels[k].object += blocks[owner == SCENE_PROPERTY_MATERIAL ? SCENE_MATERIALS : owner == SCENE_PROPERTY_LIGHT ? SCENE_LIGHTS : SCENE_CAMERAS].first;
            if (owner == SCENE_PROPERTY_ENVIRONMENT) channels[k].object = SCENE_NONE; /* it stays with its file */
            if (owner == SCENE_PROPERTY_LIGHT) channels[k].generation = into->lights.data[channels[k].object].generation;
        }
    }
}

static void put_cameras(fnl_scene *into, const fnl_scene *from, const struct range *blocks, uint32_t first_node) {
    PUT(cameras, blocks[SCENE_CAMERAS]);
    for (uint32_t i = 0; i < from->cameras.count; i++) {
        struct scene_camera *camera = &into->cameras.data[blocks[SCENE_CAMERAS].first + i];
        camera->node = moved(camera->node, first_node);
    }
}

static void put_profiles(fnl_scene *into, fnl_scene *from, const struct range *block) {
    for (uint32_t i = 0; i < block->count; i++) {
        struct light_profile profile = from->profiles.data[i];
        arena_init(&profile.memory, &into->host, 1024);
        arena_adopt(&profile.memory, &from->profiles.data[i].memory);
        scene_place_profile(into, block->first + i, &profile);
    }
    into->profiles.count = MAX(into->profiles.count, block->first + block->count);
}

static void put_lights(fnl_scene *into, const fnl_scene *from, const struct range *blocks, uint32_t first_node) {
    uint32_t index = blocks[SCENE_LIGHTS].first;
    into->lights.count = MAX(into->lights.count, index + blocks[SCENE_LIGHTS].count);
    for (uint32_t i = 0; i < from->lights.count; i++) {
        const struct scene_light *light = &from->lights.data[i];
        if (light->removed) continue; /* of its environment */
        fnl_light_params params = light->params;
        if (params.profile.generation) {
            params.profile.index += blocks[SCENE_PROFILES].first;
            params.profile.generation = into->profiles.data[params.profile.index].generation;
        }
        scene_put_light(into, index, &params, moved(light->node, first_node));
        into->lights.data[index].name = light->name;
        into->lights.data[index].extras = light->extras;
        index++;
    }
}

static void put_decals(fnl_scene *into, const fnl_scene *from, const struct range *blocks, uint32_t first_node) {
    PUT(decals, blocks[SCENE_DECALS]);
    APPEND(painted);
    for (uint32_t i = 0; i < from->decals.count; i++) {
        struct scene_decal *decal = &into->decals.data[blocks[SCENE_DECALS].first + i];
        fnl_decal_params *params = &decal->params;
        fnl_image_id *images[] = {&params->color_image, &params->normal_image, &params->metallic_roughness_image,
                                  &params->emissive_image};
        decal->node = moved(decal->node, first_node);
        decal->generation = scene_take_generation(into);
        if (params->instance.generation) {
            params->instance.index += first_node;
            params->instance.generation = into->nodes.data[params->instance.index].generation;
        }
        for (uint32_t k = 0; k < COUNT_OF(images); k++)
            if (images[k]->generation) *images[k] = scene_image_id(into, images[k]->index + blocks[SCENE_IMAGES].first);
    }
    for (uint32_t i = into->painted.count - from->painted.count; i < into->painted.count; i++) {
        into->painted.data[i].node += first_node;
        into->painted.data[i].mesh += blocks[SCENE_MESHES].first;
        into->painted.data[i].own_mesh += blocks[SCENE_MESHES].first;
    }
    if (from->decals.count) into->decal_version++;
}

/* In the world as they are: they do not move with the root. */
static void put_probes(fnl_scene *into, const fnl_scene *from, const struct range *block) {
    PUT(probes, *block);
    if (block->count) into->probe_version++;
    for (uint32_t i = block->first; i < block->first + block->count; i++) {
        into->probes.data[i].generation = scene_take_generation(into);
        into->probes.data[i].params.centre = vec3_from_place(into->probes.data[i].place, into->origin);
        into->probes.data[i].version = into->probe_version;
    }
}

/* Extensions stay listed after their file is unloaded. */
static void append_words(fnl_scene *into, const fnl_scene *from) {
    APPEND(messages);
    APPEND(packets);
    for (uint32_t i = 0; i < from->extensions.count; i++) {
        struct scene_extension extension = from->extensions.data[i];
        uint32_t known = 0;
        while (known < into->extensions.count && strcmp(into->extensions.data[known].name, extension.name) != 0) known++;
        if (known < into->extensions.count) {
            into->extensions.data[known].required |= extension.required;
            continue;
        }
        extension.name = arena_string(&into->arena, extension.name);
        if (extension.name) into->extensions.data[into->extensions.count++] = extension;
    }
}

static uint32_t lights_that_stay(const fnl_scene *from) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < from->lights.count; i++) count += !from->lights.data[i].removed;
    return count;
}

fnl_result scene_merge(fnl_scene *into, uint32_t parent, fnl_scene *from, fnl_loaded *out) {
    TRY(make_room(into, from));
    struct scene_part part = {.files = {into->files.count, from->files.count},
                              .resources = {into->resources.count, from->resources.count},
                              .sources = {into->sources.count, from->sources.count},
                              .messages = {into->messages.count, from->messages.count},
                              .packets = {into->packets.count, from->packets.count}};
#define BLOCK(pool, name) part.blocks[pool] = take_block(into, pool, from->name.count, into->name.count)
    BLOCK(SCENE_IMAGES, images);
    BLOCK(SCENE_SAMPLERS, samplers);
    BLOCK(SCENE_MATERIALS, materials);
    BLOCK(SCENE_PRIMITIVES, primitives);
    BLOCK(SCENE_MESHES, meshes);
    BLOCK(SCENE_SKINS, skins);
    BLOCK(SCENE_ANIMATIONS, animations);
    BLOCK(SCENE_CAMERAS, cameras);
    BLOCK(SCENE_DECALS, decals);
    BLOCK(SCENE_PROBES, probes);
    BLOCK(SCENE_VARIANTS, variants);
    BLOCK(SCENE_PROFILES, profiles);
#undef BLOCK
    part.blocks[SCENE_LIGHTS] = take_block(into, SCENE_LIGHTS, lights_that_stay(from), into->lights.count);
    part.blocks[SCENE_NODES] = take_block(into, SCENE_NODES, from->nodes.count + 1, into->nodes.count);
    const struct range *blocks = part.blocks;
    const uint32_t root = blocks[SCENE_NODES].first, first_node = root + 1; /* the root stands before its nodes */
    const mat4 identity = mat4_identity();
    scene_put_node(into, root, from->source, parent, &identity, SCENE_NONE);
    into->nodes.data[root].local_exact = affine_identity(); /* the file's coordinates, independent of the origin */
    part.root = root;
    part.generation = into->nodes.data[root].generation;
    APPEND(files);
    APPEND(resources);
    APPEND(sources);
    put_images(into, from, &blocks[SCENE_IMAGES]);
    put_materials(into, from, blocks);
    put_meshes(into, from, blocks);
    put_nodes(into, from, blocks, root);
    put_animations(into, from, blocks, first_node);
    put_cameras(into, from, blocks, first_node);
    scene_update_transforms(into);
    put_profiles(into, from, &blocks[SCENE_PROFILES]);
    put_lights(into, from, blocks, first_node);
    move_properties(into, from, blocks);
    put_decals(into, from, blocks, first_node);
    put_probes(into, from, &blocks[SCENE_PROBES]);
    scene_use_light_masks(into, from->has_light_masks);
    append_words(into, from);
    scene_materials_changed(into);
    into->parts.data[into->parts.count++] = part;
    struct arena *memory = &into->parts.data[into->parts.count - 1].arena;
    arena_init(memory, &into->host, (size_t)64 << 10);
    arena_adopt(memory, &from->arena);

    /* `into` owns their memory now. */
    from->files.count = from->resources.count = from->nodes.count = from->primitives.count = from->images.count = from->cameras.count = 0;
    from->profiles.count = 0;

    if (out) *out = (fnl_loaded){.root = {root, part.generation}};
    const uint32_t firsts[FNL_ENTITY_COUNT] = {
        [FNL_ENTITY_INSTANCE] = root, [FNL_ENTITY_LIGHT] = blocks[SCENE_LIGHTS].first, [FNL_ENTITY_DECAL] = blocks[SCENE_DECALS].first,
        [FNL_ENTITY_MESH] = blocks[SCENE_MESHES].first, [FNL_ENTITY_MATERIAL] = blocks[SCENE_MATERIALS].first,
        [FNL_ENTITY_IMAGE] = blocks[SCENE_IMAGES].first, [FNL_ENTITY_CAMERA] = blocks[SCENE_CAMERAS].first,
        [FNL_ENTITY_ANIMATION] = blocks[SCENE_ANIMATIONS].first, [FNL_ENTITY_PROBE] = blocks[SCENE_PROBES].first,
        [FNL_ENTITY_VARIANT] = blocks[SCENE_VARIANTS].first, [FNL_ENTITY_METADATA] = part.packets.first};
    const uint32_t counts[FNL_ENTITY_COUNT] = {
        [FNL_ENTITY_INSTANCE] = blocks[SCENE_NODES].count, [FNL_ENTITY_LIGHT] = blocks[SCENE_LIGHTS].count,
        [FNL_ENTITY_DECAL] = blocks[SCENE_DECALS].count, [FNL_ENTITY_MESH] = blocks[SCENE_MESHES].count,
        [FNL_ENTITY_MATERIAL] = blocks[SCENE_MATERIALS].count, [FNL_ENTITY_IMAGE] = blocks[SCENE_IMAGES].count,
        [FNL_ENTITY_CAMERA] = blocks[SCENE_CAMERAS].count, [FNL_ENTITY_ANIMATION] = blocks[SCENE_ANIMATIONS].count,
        [FNL_ENTITY_PROBE] = blocks[SCENE_PROBES].count, [FNL_ENTITY_VARIANT] = blocks[SCENE_VARIANTS].count,
        [FNL_ENTITY_METADATA] = part.packets.count};
    for (int kind = 0; kind < FNL_ENTITY_COUNT && out; kind++) {
        out->first[kind] = scene_entity_index(into, (fnl_entity)kind, firsts[kind]);
        out->count[kind] = counts[kind];
    }
    return FNL_OK;
}
