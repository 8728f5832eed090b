/* SPDX-License-Identifier: MIT */
/* Life, building, transforms and bounds of a scene. */
#include "scene/scene.h"

/** A file that is wrong everywhere must not fill the memory with warnings. */
#define MESSAGE_MAX 1000u

uint32_t scene_take_generation(fnl_scene *scene) {
    if (++scene->next_generation == 0) scene->next_generation = 1;
    return scene->next_generation;
}

fnl_result scene_create(const fnl_host *host, const char *source, fnl_scene **out) {
    *out = NULL;
    fnl_host resolved = host_resolve(host);
    fnl_scene *scene = host_allocate_zero(&resolved, sizeof *scene);
    if (!scene) return FNL_ERROR_MEMORY;
    scene->host = resolved;
    arena_init(&scene->arena, &scene->host, (size_t)256 << 10);
    scene->source = arena_string(&scene->arena, source);
    scene->cutoff_roughness = 1;
    scene->reach.structure_version = UINT64_MAX;
    scene->anisotropy = 8;
    for (uint32_t i = 0; i < SCENE_POOLS; i++) scene->holes[i].end = RANGES_NONE; /* only the gaps are used */
    scene->profile_floats.end = 1;
    scene->stage = (struct scene_stage){.node = SCENE_NONE, .mesh = SCENE_NONE, .material = SCENE_NONE, .placed_version = UINT64_MAX};
    struct scene_sampler sampler = {.mag = SCENE_FILTER_LINEAR,
                                    .min = SCENE_FILTER_LINEAR,
                                    .mip = SCENE_FILTER_LINEAR,
                                    .mipmapped = true,
                                    .wrap_u = SCENE_WRAP_REPEAT,
                                    .wrap_v = SCENE_WRAP_REPEAT};
    if (!scene->source || scene_add_sampler(scene, &sampler) == SCENE_NONE) {
        fnl_scene_destroy(&scene);
        return FNL_ERROR_MEMORY;
    }
    *out = scene;
    return FNL_OK;
}

void fnl_scene_destroy(fnl_scene **scene_address) {
    if (!scene_address || !*scene_address) return;
    fnl_scene *scene = *scene_address;
    fnl_host host = scene->host;
    for (uint32_t i = 0; i < scene->files.count; i++) file_free(&host, &scene->files.data[i]);
    array_free(&host, &scene->files);
    for (uint32_t i = 0; i < scene->resources.count; i++) {
        const fnl_resource *resource = &scene->resources.data[i];
        if (resource->release) resource->release(resource->user, resource->data, resource->size);
    }
    array_free(&host, &scene->resources);
    array_free(&host, &scene->sources);
    for (uint32_t i = 0; i < scene->images.count; i++) host_free(&host, scene->images.data[i].memory, scene->images.data[i].memory_size);
    array_free(&host, &scene->images);
    array_free(&host, &scene->samplers);
    array_free(&host, &scene->materials);
    for (uint32_t i = 0; i < scene->nodes.count; i++) scene_free_weights(scene, &scene->nodes.data[i]);
    for (uint32_t i = 0; i < scene->primitives.count; i++) arena_finish(&scene->primitives.data[i].memory);
    array_free(&host, &scene->primitives);
    array_free(&host, &scene->meshes);
    array_free(&host, &scene->nodes);
    array_free(&host, &scene->skins);
    array_free(&host, &scene->animations);
    for (uint32_t i = 0; i < scene->lights.count; i++) light_hull_free(scene, &scene->lights.data[i]);
    array_free(&host, &scene->lights);
    for (uint32_t i = 0; i < scene->profiles.count; i++) arena_finish(&scene->profiles.data[i].memory);
    array_free(&host, &scene->profiles);
    ranges_finish(&host, &scene->profile_floats);
    array_free(&host, &scene->levels);
    array_free(&host, &scene->decals);
    scene_environment_finish(scene);
    array_free(&host, &scene->probes);
    array_free(&host, &scene->painted);
    for (uint32_t i = 0; i < scene->cameras.count; i++) host_free(&host, scene->cameras.data[i].own_name, scene->cameras.data[i].own_name ? strlen(scene->cameras.data[i].own_name) + 1 : 0);
    array_free(&host, &scene->cameras);
    array_free(&host, &scene->variants);
    array_free(&host, &scene->packets);
    array_free(&host, &scene->extensions);
    array_free(&host, &scene->messages);
    array_free(&host, &scene->moved);
    array_free(&host, &scene->edited);
    array_free(&host, &scene->free_nodes);
    array_free(&host, &scene->free_lights);
    array_free(&host, &scene->light_slots);
    array_free(&host, &scene->free_light_slots);
    array_free(&host, &scene->unlimited);
    array_free(&host, &scene->suns);
    array_free(&host, &scene->changed_slots);
    for (uint32_t i = 0; i < SCENE_POOLS; i++) ranges_finish(&host, &scene->holes[i]);
    for (uint32_t i = 0; i < scene->parts.count; i++) arena_finish(&scene->parts.data[i].arena);
    array_free(&host, &scene->parts);
    arena_finish(&scene->arena);
    host_free(&host, scene, sizeof *scene);
    *scene_address = NULL;
}

/* ---- building ---- */

struct scene_texture scene_texture_none(void) {
    return (struct scene_texture){.image = SCENE_NONE, .transform = {1, 0, 0, 0, 1, 0}};
}

void scene_turn_texture(struct scene_texture *texture, const struct scene_texture_turn *turn) {
    const float c = cosf(turn->rotation), s = sinf(turn->rotation), *scale = turn->scale;
    const float transform[6] = {c * scale[0], s * scale[1], turn->offset[0], -s * scale[0], c * scale[1], turn->offset[1]};
    memcpy(texture->transform, transform, sizeof transform);
}

const struct scene_texture *scene_tangent_texture(const struct scene_material *m) {
    static const enum scene_texture_slot slots[] = {SCENE_TEXTURE_NORMAL, SCENE_TEXTURE_CLEARCOAT_NORMAL, SCENE_TEXTURE_ANISOTROPY};
    for (size_t i = 0; i < COUNT_OF(slots); i++)
        if (m->textures[slots[i]].image != SCENE_NONE) return &m->textures[slots[i]];
    return NULL;
}

/*
 * Along u of the tangents' coordinates lies the tangent, against v the bitangent. A picture whose coordinates are those times R has its own tangent along
 * the first column of R's inverse, and its bitangent at right angles, on the other side where R mirrors.
 */
void scene_texture_turn_of(const struct scene_material *m, enum scene_texture_slot slot, float out[4]) {
    static const float identity[4] = {1, 0, 0, 1};
    const float *a = m->textures[slot].transform, *f = m->tangent_frame;
    const double determinant = (double)f[0] * (double)f[3] - (double)f[1] * (double)f[2];
    memcpy(out, identity, sizeof identity);
    if (m->textures[slot].image == SCENE_NONE) return;
    double r[4] = {(double)a[0], (double)a[1], (double)a[3], (double)a[4]};
    if (determinant != 0) {
        const double x = r[0], y = r[1], z = r[2], w = r[3];
        r[0] = (x * (double)f[3] - y * (double)f[2]) / determinant;
        r[1] = (y * (double)f[0] - x * (double)f[1]) / determinant;
        r[2] = (z * (double)f[3] - w * (double)f[2]) / determinant;
        r[3] = (w * (double)f[0] - z * (double)f[1]) / determinant;
    }
    const double area = r[0] * r[3] - r[1] * r[2], length = sqrt(r[2] * r[2] + r[3] * r[3]);
    if (!(length > 0) || !isfinite(length) || area == 0) return;
    const double sign = area < 0 ? -1 : 1, c = sign * r[3] / length, s = sign * r[2] / length;
    out[0] = (float)c;
    out[1] = (float)(-s * sign);
    out[2] = (float)s;
    out[3] = (float)(c * sign);
}

void scene_structure_changed(fnl_scene *scene) {
    scene->edited_since = ++scene->structure_version;
    scene->edited.count = 0;
}

/* Beyond this length it is cheaper for a renderer to read all nodes once. */
static uint32_t longest_list(const fnl_scene *scene) { return 1024 + scene->nodes.count / 16; }

/* Records that a node changed at the present structure_version. */
static void list_edited(fnl_scene *scene, uint32_t index) {
    struct scene_node *node = &scene->nodes.data[index];
    bool listed = node->edited_version > scene->edited_since;
    node->edited_version = scene->structure_version;
    if (listed) return;
    if (scene->edited.count < longest_list(scene) && array_push(&scene->host, &scene->edited, index)) return;
    scene_structure_changed(scene);
}

void scene_materials_changed(fnl_scene *scene) {
    scene->material_version++;
    scene_structure_changed(scene);
}

bool scene_image_create(const fnl_scene *scene, const char *kind, uint32_t width, uint32_t height, bool color, struct scene_image *out) {
    const size_t pixels = (size_t)width * height * 4, name = strlen(scene->source) + strlen(kind) + 3;
    uint8_t *memory = host_allocate(&scene->host, pixels + name);
    if (!memory) return false;
    snprintf((char *)memory + pixels, name, "%s: %s", scene->source, kind);
    *out = (struct scene_image){.name = (const char *)memory + pixels,
                                .file_kind = "generated",
                                .width = width,
                                .height = height,
                                .pixels = memory,
                                .memory = memory,
                                .memory_size = pixels + name,
                                .color = color};
    return true;
}

uint32_t scene_add_image(fnl_scene *scene, const struct scene_image *image) {
    const uint32_t index = scene_take_place(scene, SCENE_IMAGES, &scene->images);
    if (index == SCENE_NONE) {
        host_free(&scene->host, image->memory, image->memory_size);
        return SCENE_NONE;
    }
    struct scene_image *place = &scene->images.data[index];
    const uint32_t version = place->version, generation = place->generation;
    *place = *image;
    place->version = version + (generation > 0);
    place->generation = generation + 1;
    scene_materials_changed(scene);
    return index;
}

uint32_t scene_add_sampler(fnl_scene *scene, const struct scene_sampler *sampler) {
    const uint32_t index = scene_take_place(scene, SCENE_SAMPLERS, &scene->samplers);
    if (index == SCENE_NONE) return SCENE_NONE;
    scene->samplers.data[index] = *sampler;
    scene_materials_changed(scene);
    return index;
}

uint32_t scene_add_material(fnl_scene *scene, const struct scene_material *material) {
    const uint32_t index = scene_take_place(scene, SCENE_MATERIALS, &scene->materials);
    if (index == SCENE_NONE) return SCENE_NONE;
    const uint32_t generation = scene->materials.data[index].generation;
    scene->materials.data[index] = *material;
    scene->materials.data[index].generation = generation + 1;
    scene->materials.data[index].removed = false;
    scene_materials_changed(scene);
    return index;
}

uint32_t scene_add_mesh(fnl_scene *scene, const char *name, const struct scene_primitive *primitives, uint32_t count) {
    struct scene_mesh mesh = {.name = name, .primitive_count = count, .bounds = box_empty()};
    if (!array_reserve(&scene->host, &scene->primitives, (uint64_t)scene->primitives.count + count)) return SCENE_NONE;
    const uint32_t index = scene_take_place(scene, SCENE_MESHES, &scene->meshes);
    if (index == SCENE_NONE) return SCENE_NONE;
    mesh.first_primitive = scene_take_holes(scene, SCENE_PRIMITIVES, count);
    const bool reused = mesh.first_primitive != SCENE_NONE;
    if (!reused) {
        mesh.first_primitive = scene->primitives.count;
        for (uint32_t i = 0; i < count; i++) scene->primitives.data[scene->primitives.count++] = (struct scene_primitive){0};
    }
    for (uint32_t i = 0; i < count; i++) {
        struct scene_primitive *primitive = &scene->primitives.data[mesh.first_primitive + i];
        const uint32_t version = primitive->version, shape_version = primitive->shape_version;
        *primitive = primitives[i];
        primitive->version = version + reused;
        primitive->shape_version = shape_version + reused;
        primitive->bounds = primitive_bounds(primitive);
        primitive->leans = primitive_leans(primitive);
        box_add_box(&mesh.bounds, &primitive->bounds);
        mesh.morph_target_count = MAX(mesh.morph_target_count, primitive->morph_target_count);
    }
    mesh.generation = scene->meshes.data[index].generation + 1;
    scene->meshes.data[index] = mesh;
    scene_structure_changed(scene);
    return index;
}

void scene_put_node(fnl_scene *scene, uint32_t index, const char *name, uint32_t parent, const mat4 *local, uint32_t mesh) {
    const bool reused = index < scene->nodes.count; /* a reused node may still be in the lists; do not add it twice */
    const uint64_t moved_version = reused ? scene->nodes.data[index].moved_version : 0;
    const uint64_t edited_version = reused ? scene->nodes.data[index].edited_version : 0;
    scene->nodes.count = MAX(scene->nodes.count, index + 1);
    struct scene_node *node = &scene->nodes.data[index];
    *node = (struct scene_node){
        .name = name,
        .parent = parent,
        .first_child = SCENE_NONE,
        .next_sibling = SCENE_NONE,
        .has_matrix = true,
        .active = true,
        .rotation = {0, 0, 0, 1},
        .scale = {1, 1, 1},
        .world = *local,
        .local_exact = affine_from_mat4(local, parent == SCENE_NONE ? scene->origin : no_origin),
        .mesh = mesh,
        .skin = SCENE_NONE,
        .camera = SCENE_NONE,
        .instance_count = 1,
        .generation = scene_take_generation(scene),
        .moved_version = moved_version,
        .edited_version = edited_version,
    };
    node->world_exact = node->local_exact;
    if (parent != SCENE_NONE) {
        struct scene_node *above = &scene->nodes.data[parent];
        node->next_sibling = above->first_child;
        above->first_child = index;
        node->world_exact = affine_mul(&above->world_exact, &node->local_exact);
        node->world = mat4_from_affine(&node->world_exact, scene->origin);
        node->active = above->active;
    }
    scene->structure_version++;
    list_edited(scene, index);
}

uint32_t scene_add_node(fnl_scene *scene, const char *name, uint32_t parent, const mat4 *local, uint32_t mesh) {
    uint32_t index;
    if (scene->free_nodes.count > 0) {
        index = scene->free_nodes.data[--scene->free_nodes.count];
        scene->hole_counts[SCENE_NODES]--;
    } else {
        index = scene_take_holes(scene, SCENE_NODES, 1);
        if (index == SCENE_NONE) index = scene->nodes.count;
        if (index == SCENE_NONE || !array_reserve(&scene->host, &scene->nodes, (uint64_t)index + 1)) return SCENE_NONE;
    }
    scene_put_node(scene, index, name, parent, local, mesh);
    return index;
}

void scene_add_message(fnl_scene *scene, const char *format, ...) {
    if (scene->messages.count > MESSAGE_MAX) return;
    char text[1024];
    if (scene->messages.count == MESSAGE_MAX) {
        snprintf(text, sizeof text, "%s: further warnings are left out", scene->source);
    } else {
        va_list arguments;
        va_start(arguments, format);
        text_format_list(text, sizeof text, format, arguments);
        va_end(arguments);
    }
    fnl_text_clean(text);
    log_warning(&scene->host, "%s", text);
    const char *kept = arena_string(&scene->arena, text);
    if (kept) UNUSED(array_push(&scene->host, &scene->messages, kept)); /* it has been logged in any case */
}

/* ---- transforms ---- */

/** The node after `index` in depth-first order below `root`; SCENE_NONE at the end. Needs no stack, however deep. */
static uint32_t next_in_tree(const struct scene_node *nodes, uint32_t index, uint32_t root) {
    if (nodes[index].first_child != SCENE_NONE) return nodes[index].first_child;
    while (index != root) {
        if (nodes[index].next_sibling != SCENE_NONE) return nodes[index].next_sibling;
        index = nodes[index].parent;
    }
    return SCENE_NONE;
}

void scene_pose_node(struct scene_node *node) {
    node->local_exact = affine_from_trs(node->translation, node->rotation, node->scale);
    node->placed = false;
}

static bool update_node(fnl_scene *scene, uint32_t index, uint64_t version) {
    struct scene_node *nodes = scene->nodes.data, *node = &nodes[index];
    const bool root = node->parent == SCENE_NONE;
    node->world_exact = root ? node->local_exact : affine_mul(&nodes[node->parent].world_exact, &node->local_exact);
    const mat4 world = mat4_from_affine(&node->world_exact, scene->origin);
    const bool moved = node->moved_version == version || memcmp(&world, &node->world, sizeof world) != 0;
    node->world = world;
    if (moved) node->moved_version = version;
    return moved;
}

void scene_update_transforms(fnl_scene *scene) {
    struct scene_node *nodes = scene->nodes.data;
    uint64_t version = scene->transform_version + 1;
    bool any = false, listed = array_reserve(&scene->host, &scene->moved, scene->nodes.count);
    uint32_t moved_count = 0;
    for (uint32_t root = 0; root < scene->nodes.count; root++) {
        if (nodes[root].parent != SCENE_NONE || nodes[root].removed) continue;
        for (uint32_t i = root; i != SCENE_NONE; i = next_in_tree(nodes, i, root)) {
            if (!update_node(scene, i, version)) continue;
            any = true;
            if (listed) scene->moved.data[moved_count++] = i;
        }
    }
    if (!any) return;
    scene->moved.count = moved_count;
    scene->moved_since = listed ? scene->transform_version : version;
    scene->transform_version = version;

    scene_pose_lights(scene, version);
}

/* At the present transform_version; `before` is the moved_version that the node had. */
static void list_moved(fnl_scene *scene, uint32_t node, uint64_t before) {
    if (before > scene->moved_since) return;
    if (scene->moved.count < longest_list(scene) && array_push(&scene->host, &scene->moved, node)) return;
    scene->moved.count = 0;
    scene->moved_since = scene->transform_version;
}

/* Updates what is below a node that moved, and lists what that moves. */
static void move_tree(fnl_scene *scene, uint32_t root, uint64_t version) {
    struct scene_node *nodes = scene->nodes.data;
    for (uint32_t i = root; i != SCENE_NONE; i = next_in_tree(nodes, i, root)) {
        uint64_t before = nodes[i].moved_version;
        scene->nodes_placed++;
        if (update_node(scene, i, version)) list_moved(scene, i, before);
    }
}

void scene_move_nodes(fnl_scene *scene, const fnl_instance_id *ids, const mat4 *locals, uint32_t count) {
    struct scene_node *nodes = scene->nodes.data;
    uint64_t version = ++scene->transform_version;
    bool linked = false;
    for (uint32_t i = 0; i < count; i++) {
        struct scene_node *node = &nodes[ids[i].index];
        node->local_exact = affine_from_mat4(&locals[i], node->parent == SCENE_NONE ? scene->origin : no_origin);
        node->placed = node->moves = true;
        linked = linked || node->linked;
    }
    for (uint32_t i = 0; i < count; i++) {
        uint32_t above = nodes[ids[i].index].parent; /* the nearest that moves by itself brings all below it along */
        while (above != SCENE_NONE && !nodes[above].moves) above = nodes[above].parent;
        if (above == SCENE_NONE) move_tree(scene, ids[i].index, version);
    }
    for (uint32_t i = 0; i < count; i++) nodes[ids[i].index].moves = false;
    if (linked) scene_pose_lights(scene, version);
}

void scene_weights_changed(fnl_scene *scene, uint32_t index) {
    struct scene_node *node = &scene->nodes.data[index];
    uint64_t before = node->moved_version;
    node->moved_version = ++scene->transform_version;
    list_moved(scene, index, before);
}

void scene_free_weights(fnl_scene *scene, struct scene_node *node) {
    if (node->owns_weights)
        host_free(&scene->host, node->morph_weights, sizeof(float) * scene->meshes.data[node->mesh].morph_target_count);
    node->morph_weights = NULL;
    node->owns_weights = false;
}

/* ---- showing and removing ---- */

void scene_activate(fnl_scene *scene, uint32_t root) {
    struct scene_node *nodes = scene->nodes.data;
    scene->structure_version++;
    for (uint32_t i = root; i != SCENE_NONE; i = next_in_tree(nodes, i, root)) {
        bool active = !nodes[i].hidden && !nodes[i].unchosen && (nodes[i].parent == SCENE_NONE || nodes[nodes[i].parent].active);
        if (active != nodes[i].active) list_edited(scene, i);
        nodes[i].active = active;
    }
}

void scene_node_edited(fnl_scene *scene, uint32_t node) {
    scene->structure_version++;
    list_edited(scene, node);
}

void scene_set_receivers(fnl_scene *scene, uint32_t index, uint32_t receivers) {
    scene->nodes.data[index].refuses = (uint8_t)~receivers;
    scene_node_edited(scene, index);
}

void scene_set_view_mask(fnl_scene *scene, uint32_t index, uint32_t mask) {
    scene->nodes.data[index].unseen = (uint8_t)~mask;
    scene_node_edited(scene, index);
}

void scene_use_light_masks(fnl_scene *scene, bool used) {
    if (!used || scene->has_light_masks) return;
    scene->has_light_masks = true;
    scene_structure_changed(scene); /* instances that lack bits are drawn apart from now on */
}

void scene_set_light_mask(fnl_scene *scene, uint32_t index, uint32_t mask) {
    scene_use_light_masks(scene, mask == 0); /* any other mask shares a bit with a light's 255 */
    scene->nodes.data[index].unlit = (uint8_t)~mask;
    scene_node_edited(scene, index);
}

void scene_show_node(fnl_scene *scene, uint32_t index, bool visible) {
    struct scene_node *nodes = scene->nodes.data;
    if (nodes[index].hidden == !visible) return;
    nodes[index].hidden = !visible;
    scene_activate(scene, index);
    scene->decal_version++;
    if (nodes[index].linked) scene_show_lights(scene, index);
}

fnl_result scene_remove_node(fnl_scene *scene, uint32_t index) {
    const fnl_host *host = &scene->host;
    struct scene_node *nodes = scene->nodes.data;
    uint32_t count = 0;
    for (uint32_t i = index; i != SCENE_NONE; i = next_in_tree(nodes, i, index)) count++;
    if (!array_reserve(host, &scene->free_nodes, (uint64_t)scene->free_nodes.count + count) ||
        !array_reserve(host, &scene->free_lights, scene->lights.count))
        return FNL_ERROR_MEMORY;
    bool linked = nodes[index].linked;
    for (uint32_t i = index; i != SCENE_NONE; i = next_in_tree(nodes, i, index)) nodes[i].removed = true;
    for (uint32_t i = 0; i < scene->cameras.count && linked; i++) { /* cameras stay where they are */
        struct scene_camera *camera = &scene->cameras.data[i];
        if (camera->node == SCENE_NONE || !nodes[camera->node].removed) continue;
        fnl_camera pose;
        scene_camera_pose(scene, camera, &pose);
        camera->camera = pose;
        memcpy(camera->place, nodes[camera->node].world_exact.m + 9, sizeof camera->place);
        camera->node = SCENE_NONE;
    }
    for (uint32_t i = 0; i < scene->lights.count && linked; i++) {
        const struct scene_light *light = &scene->lights.data[i];
        if (!light->removed && light->node != SCENE_NONE && nodes[light->node].removed) scene_remove_light(scene, i);
    }
    if (nodes[index].parent != SCENE_NONE) {
        uint32_t *link = &nodes[nodes[index].parent].first_child;
        while (*link != index) link = &nodes[*link].next_sibling;
        *link = nodes[index].next_sibling;
    }
    scene->structure_version++;
    for (uint32_t i = index, next; i != SCENE_NONE; i = next) {
        next = next_in_tree(nodes, i, index);
        nodes[i].active = false;
        list_edited(scene, i);
        scene_free_weights(scene, &nodes[i]);
        nodes[i].mesh = SCENE_NONE;
        scene->hole_counts[SCENE_NODES]++;
        if (!nodes[i].linked && !scene_is_reserved(scene, SCENE_NODES, i)) /* joints keep the pose that they had */
            scene->free_nodes.data[scene->free_nodes.count++] = i;
    }
    decal_forget_removed(scene);
    scene->decal_version++;
    scene_drop_parts(scene);
    return FNL_OK;
}

/* ---- bounds ---- */

struct affine scene_instance_exact(const struct scene_node *node, uint32_t k) {
    if (!node->instances) return node->world_exact;
    const struct affine own = affine_from_mat4(&node->instances[k], no_origin);
    return affine_mul(&node->world_exact, &own);
}

mat4 scene_instance_world(const fnl_scene *scene, const struct scene_node *node, uint32_t k) {
    if (!node->instances) return node->world;
    const struct affine world = scene_instance_exact(node, k);
    return mat4_from_affine(&world, scene->origin);
}

mat4 scene_node_local(const fnl_scene *scene, const struct scene_node *node) {
    return mat4_from_affine(&node->local_exact, node->parent == SCENE_NONE ? scene->origin : no_origin);
}

/** Grows `out` by all that a skinned primitive can reach: a skinned vertex is a weighted mean of its joints' images. */
static void add_skinned_bounds(const struct scene_primitive *primitive, const mat4 *joints, struct box *out) {
    bool morphs = primitive->morph_target_count > 0;
    for (uint32_t i = 0; i < primitive->vertex_count; i++) {
        for (uint32_t k = 0; k < primitive->joint_count; k++) {
            size_t at = (size_t)i * primitive->joint_count + k;
            if (primitive->weights[at] <= 0) continue;
            const mat4 *joint = &joints[primitive->joints[at]];
            if (morphs) {
                struct box moved = box_transform(&primitive->bounds, joint);
                box_add_box(out, &moved);
            } else {
                box_add_point(out, mat4_point(joint, primitive->positions[i]));
            }
        }
    }
}

static void add_node_bounds(const fnl_scene *scene, const struct scene_node *node, struct box *out) {
    const struct scene_mesh *mesh = &scene->meshes.data[node->mesh];
    mat4 *joints = NULL;
    size_t joints_size = 0;
    if (node->skin != SCENE_NONE) {
        joints_size = sizeof *joints * scene->skins.data[node->skin].joint_count;
        joints = host_allocate(&scene->host, joints_size);
        if (joints) skin_matrices(scene, node->skin, joints);
    }
    for (uint32_t i = 0; i < mesh->primitive_count; i++) {
        const struct scene_primitive *primitive = &scene->primitives.data[mesh->first_primitive + i];
        if (joints && primitive->joint_count > 0) {
            add_skinned_bounds(primitive, joints, out);
            continue;
        }
        if (box_is_empty(&primitive->bounds)) continue;
        for (uint32_t k = 0; k < node->instance_count; k++) {
            const mat4 world = scene_instance_world(scene, node, k);
            struct box moved = box_transform(&primitive->bounds, &world);
            box_add_box(out, &moved);
        }
    }
    host_free(&scene->host, joints, joints_size);
}

struct box scene_bounds(const fnl_scene *scene) {
    struct box bounds = box_empty();
    for (uint32_t i = 0; i < scene->nodes.count; i++) {
        const struct scene_node *node = &scene->nodes.data[i];
        if (scene_node_draws(node) && !node->staged) add_node_bounds(scene, node, &bounds);
    }
    return bounds;
}

struct box scene_tree_bounds(const fnl_scene *scene, uint32_t root, bool alone) {
    struct box bounds = box_empty();
    for (uint32_t i = root; i != SCENE_NONE; i = alone ? SCENE_NONE : next_in_tree(scene->nodes.data, i, root)) {
        const struct scene_node *node = &scene->nodes.data[i];
        if (!node->removed && node->mesh != SCENE_NONE) add_node_bounds(scene, node, &bounds);
    }
    return bounds;
}
