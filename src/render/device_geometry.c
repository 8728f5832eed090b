/* SPDX-License-Identifier: MIT */
#include "render/device_scene.h"

/* Whether a node's vertices are its own, moved every frame. */
static bool node_deforms(const struct scene_node *node, const struct scene_primitive *p) {
    return (node->skin != SCENE_NONE && p->joint_count > 0) || p->morph_target_count > 0;
}

static bool node_draws(const struct scene_node *node) { return node->active && !node->removed && node->mesh != SCENE_NONE; }

/* ---- materials ---- */

static VkSamplerAddressMode address_mode(enum scene_wrap wrap) {
    return wrap == SCENE_WRAP_REPEAT ? VK_SAMPLER_ADDRESS_MODE_REPEAT
         : wrap == SCENE_WRAP_MIRROR ? VK_SAMPLER_ADDRESS_MODE_MIRRORED_REPEAT : VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
}

static uint32_t sampler_index(struct device_scene *d, uint32_t index) {
    const struct scene_sampler *s = &d->scene->samplers.data[index];
    struct gpu_sampler_params params = {
        .mag = s->mag == SCENE_FILTER_LINEAR ? VK_FILTER_LINEAR : VK_FILTER_NEAREST,
        .min = s->min == SCENE_FILTER_LINEAR ? VK_FILTER_LINEAR : VK_FILTER_NEAREST,
        .mip = s->mip == SCENE_FILTER_LINEAR ? VK_SAMPLER_MIPMAP_MODE_LINEAR : VK_SAMPLER_MIPMAP_MODE_NEAREST,
        .mipmapped = s->mipmapped, .wrap_u = address_mode(s->wrap_u), .wrap_v = address_mode(s->wrap_v),
        .anisotropy = s->mipmapped && s->min == SCENE_FILTER_LINEAR ? 8 : 1};
    return gpu_sampler_index(d->device, &params);
}

static struct gpu_material device_material(struct device_scene *d, const struct scene_material *m) {
    float r = m->ior > 0 ? (m->ior - 1) / (m->ior + 1) : 1; /* an index of 0 means total reflection (KHR_materials_ior) */
    struct gpu_material g = {
        .base_color = m->base_color, .emissive = m->emissive, .metallic = m->metallic, .roughness = m->roughness,
        .dielectric_f0 = vec3_scale(m->specular_color, r * r), .specular = m->specular, .normal_scale = m->normal_scale,
        .occlusion_strength = m->occlusion_strength, .alpha_cutoff = m->alpha_cutoff,
        .flags = (m->unlit ? GPU_MATERIAL_UNLIT : 0) | (m->alpha_mode == FNL_ALPHA_MASK ? GPU_MATERIAL_MASK : 0) |
                 (m->alpha_mode == FNL_ALPHA_BLEND ? GPU_MATERIAL_BLEND : 0) | (m->double_sided ? GPU_MATERIAL_DOUBLE_SIDED : 0)};
    for (int slot = 0; slot < SCENE_TEXTURE_SLOT_COUNT; slot++) {
        const struct scene_texture *t = &m->textures[slot];
        struct gpu_texture *out = &g.textures[slot];
        out->image = GPU_TEXTURE_NONE;
        if (t->image == SCENE_NONE || !d->images.data[t->image].handle) continue;
        bool color = slot == SCENE_TEXTURE_BASE_COLOR || slot == SCENE_TEXTURE_EMISSIVE || slot == SCENE_TEXTURE_SPECULAR_COLOR;
        const struct gpu_image *image = &d->images.data[t->image];
        out->image = color && image->srgb_index != GPU_NO_INDEX ? image->srgb_index : image->sampled_index;
        out->sampler_index = sampler_index(d, t->sampler);
        out->uv_set = t->uv_set;
        memcpy(out->transform, t->transform, sizeof out->transform);
    }
    return g;
}

static fnl_result upload_array(struct device_scene *d, const char *name, struct gpu_buffer *buffer, const void *data, uint64_t size) {
    TRY(gpu_buffer_create(d->device, name, MAX(size, 16u), GPU_MEMORY_DEVICE, buffer));
    return size ? gpu_upload_buffer(d->device, buffer, 0, data, size) : FNL_OK;
}

/* The last material is glTF's default, for primitives without one. */
static fnl_result upload_materials(struct device_scene *d) {
    uint32_t count = d->scene->materials.count + 1;
    struct gpu_material *materials = host_allocate(&d->host, count * sizeof *materials);
    if (!materials) return FNL_ERROR_MEMORY;
    for (uint32_t i = 0; i + 1 < count; i++) materials[i] = device_material(d, &d->scene->materials.data[i]);
    struct scene_material standard = scene_material_default();
    materials[count - 1] = device_material(d, &standard);
    fnl_result result = upload_array(d, "materials", &d->materials, materials, count * sizeof *materials);
    host_free(&d->host, materials, count * sizeof *materials);
    return result;
}

static const struct scene_material *material_of(const fnl_scene *scene, const struct scene_primitive *p, const struct scene_material *standard) {
    return p->material == SCENE_NONE ? standard : &scene->materials.data[p->material];
}

/* ---- vertices ---- */

static uint32_t pack_snorm16(float v) { return (uint32_t)(uint16_t)(int16_t)lrintf(CLAMP(v, -1.0f, 1.0f) * 32767); }
static uint32_t pack_unorm16(float v) { return (uint32_t)lrintf(CLAMP(v, 0.0f, 1.0f) * 65535); }

static struct gpu_attributes pack_attributes(const struct scene_primitive *p, uint32_t v) {
    vec2 n = octahedral_encode(p->normals ? p->normals[v] : (vec3){0, 0, 1});
    vec4 t = p->tangents ? p->tangents[v] : (vec4){1, 0, 0, 1};
    vec2 e = octahedral_encode((vec3){t.x, t.y, t.z});
    vec4 c = p->colors ? p->colors[v] : (vec4){1, 1, 1, 1};
    uint32_t ex = (uint32_t)lrintf((e.x * 0.5f + 0.5f) * 65535), ey = (uint32_t)lrintf((e.y * 0.5f + 0.5f) * 32767);
    return (struct gpu_attributes){
        .normal = pack_snorm16(n.x) | pack_snorm16(n.y) << 16, .tangent = ex | ey << 16 | (t.w < 0 ? 0x80000000u : 0),
        .uv0 = p->uv[0] ? p->uv[0][v] : (vec2){0, 0}, .uv1 = p->uv[1] ? p->uv[1][v] : (vec2){0, 0},
        .color = {pack_unorm16(c.x) | pack_unorm16(c.y) << 16, pack_unorm16(c.z) | pack_unorm16(c.w) << 16}};
}

/* What is counted before anything is allocated; vertices and indices are below 2^32 in all. */
struct geometry_totals { uint64_t vertices, indices, deformed_vertices, influences, morph_floats; uint32_t primitives; };

struct upload {
    struct device_scene *d;
    ARRAY(struct gpu_primitive) primitives; /* those of the scene first, then those of deforming nodes */
    uint32_t *first_vertex;                 /* of each scene primitive */
    uint32_t *node_primitives;              /* of each node: its first own primitive, or SCENE_NONE */
    ARRAY(struct gpu_deform) deforms;
};

static struct geometry_totals count_geometry(const fnl_scene *scene) {
    struct geometry_totals t = {.primitives = scene->primitives.count};
    for (uint32_t i = 0; i < scene->primitives.count; i++) {
        t.vertices += scene->primitives.data[i].vertex_count;
        t.indices += scene->primitives.data[i].index_count;
    }
    for (uint32_t n = 0; n < scene->nodes.count; n++) {
        const struct scene_node *node = &scene->nodes.data[n];
        if (!node_draws(node)) continue;
        const struct scene_mesh *mesh = &scene->meshes.data[node->mesh];
        for (uint32_t i = 0; i < mesh->primitive_count; i++) {
            const struct scene_primitive *p = &scene->primitives.data[mesh->first_primitive + i];
            if (!node_deforms(node, p)) continue;
            t.deformed_vertices += p->vertex_count;
            if (node->skin != SCENE_NONE) t.influences += (uint64_t)p->vertex_count * p->joint_count;
            t.morph_floats += (uint64_t)p->vertex_count * p->morph_target_count * 9;
        }
    }
    return t;
}

static fnl_result upload_primitive(struct upload *u, const struct scene_primitive *p, uint32_t first_vertex, uint32_t first_index) {
    struct gpu_attributes packed[256];
    struct device_scene *d = u->d;
    TRY(gpu_upload_buffer(d->device, &d->positions, first_vertex * 12ull, p->positions, p->vertex_count * 12ull));
    TRY(gpu_upload_buffer(d->device, &d->indices, first_index * 4ull, p->indices, p->index_count * 4ull));
    for (uint32_t v = 0; v < p->vertex_count;) {
        uint32_t count = MIN(p->vertex_count - v, COUNT_OF(packed));
        for (uint32_t i = 0; i < count; i++) packed[i] = pack_attributes(p, v + i);
        TRY(gpu_upload_buffer(d->device, &d->attributes, (uint64_t)(first_vertex + v) * sizeof *packed, packed, count * sizeof *packed));
        v += count;
    }
    struct gpu_primitive g = {.material = p->material == SCENE_NONE ? d->scene->materials.count : p->material, .first_index = first_index,
                              .index_count = p->index_count, .vertex_offset = (int32_t)first_vertex};
    g.center = vec3_scale(vec3_add(p->bounds.low, p->bounds.high), 0.5f);
    g.half_extent = vec3_scale(vec3_sub(p->bounds.high, p->bounds.low), 0.5f);
    return array_push(&d->host, &u->primitives, g) ? FNL_OK : FNL_ERROR_MEMORY;
}

/* Influences and morph differences of one deforming primitive. */
static fnl_result upload_deform(struct upload *u, const struct scene_node *node, const struct device_deform *deform, const struct scene_primitive *p,
                                uint64_t *influence_count, uint64_t *morph_count, struct gpu_deform *out) {
    struct device_scene *d = u->d;
    out->count = p->vertex_count;
    out->first_matrix = deform->first_matrix;
    out->first_weight = deform->first_weight;
    out->joint_count = node->skin != SCENE_NONE ? p->joint_count : 0;
    out->first_influence = (uint32_t)*influence_count;
    out->morph_count = p->morph_target_count;
    out->first_morph = (uint32_t)*morph_count;
    uint64_t pairs = (uint64_t)p->vertex_count * out->joint_count, floats = (uint64_t)p->vertex_count * out->morph_count * 9;
    size_t bytes = MAX(pairs * sizeof(struct gpu_influence), floats * 4);
    void *memory = bytes ? host_allocate(&d->host, bytes) : NULL;
    if (bytes && !memory) return FNL_ERROR_MEMORY;
    fnl_result result = FNL_OK;
    if (pairs) {
        struct gpu_influence *influences = memory;
        for (uint64_t i = 0; i < pairs; i++) influences[i] = (struct gpu_influence){p->joints[i], p->weights[i]};
        result = gpu_upload_buffer(d->device, &d->influences, *influence_count * sizeof *influences, influences, pairs * sizeof *influences);
    }
    if (floats && result == FNL_OK) {
        vec3 *differences = memory;
        for (uint32_t target = 0; target < p->morph_target_count; target++)
            for (uint32_t v = 0; v < p->vertex_count; v++) {
                const struct scene_morph_target *m = &p->morph_targets[target];
                vec3 *at = differences + ((uint64_t)target * p->vertex_count + v) * 3;
                at[0] = m->positions ? m->positions[v] : (vec3){0, 0, 0};
                at[1] = m->normals ? m->normals[v] : (vec3){0, 0, 0};
                at[2] = m->tangents ? m->tangents[v] : (vec3){0, 0, 0};
            }
        result = gpu_upload_buffer(d->device, &d->morphs, *morph_count * 4, differences, floats * 4);
    }
    if (bytes) host_free(&d->host, memory, bytes);
    *influence_count += pairs;
    *morph_count += floats;
    return result;
}

static fnl_result upload_deforming_nodes(struct upload *u, uint32_t first_vertex) {
    struct device_scene *d = u->d;
    const fnl_scene *scene = d->scene;
    uint64_t influences = 0, morphs = 0;
    d->matrix_count = d->weight_count = 0;
    for (uint32_t n = 0; n < scene->nodes.count; n++) {
        const struct scene_node *node = &scene->nodes.data[n];
        u->node_primitives[n] = SCENE_NONE;
        if (!node_draws(node)) continue;
        const struct scene_mesh *mesh = &scene->meshes.data[node->mesh];
        bool deforms = false;
        for (uint32_t i = 0; i < mesh->primitive_count; i++)
            deforms = deforms || node_deforms(node, &scene->primitives.data[mesh->first_primitive + i]);
        if (!deforms) continue;
        struct device_deform deform = {.node = n, .skin = node->skin, .first_matrix = d->matrix_count, .first_weight = d->weight_count,
                                       .matrix_count = node->skin == SCENE_NONE ? 0 : scene->skins.data[node->skin].joint_count,
                                       .weight_count = mesh->morph_target_count};
        d->matrix_count += deform.matrix_count;
        d->weight_count += deform.weight_count;
        if (!array_push(&d->host, &d->deformed, deform)) return FNL_ERROR_MEMORY;
        u->node_primitives[n] = u->primitives.count;
        for (uint32_t i = 0; i < mesh->primitive_count; i++) {
            uint32_t index = mesh->first_primitive + i;
            const struct scene_primitive *p = &scene->primitives.data[index];
            struct gpu_primitive g = u->primitives.data[index];
            if (node_deforms(node, p)) {
                struct gpu_deform out = {.source = u->first_vertex[index], .target = first_vertex};
                TRY(upload_deform(u, node, &deform, p, &influences, &morphs, &out));
                g.vertex_offset = (int32_t)first_vertex;
                first_vertex += p->vertex_count;
                /* Joints and weights may carry the vertices anywhere: what deforms is never culled. */
                g.half_extent = (vec3){1e18f, 1e18f, 1e18f};
                if (!array_push(&d->host, &u->deforms, out) || !array_push(&d->host, &d->deform_vertex_counts, p->vertex_count))
                    return FNL_ERROR_MEMORY;
            }
            if (!array_push(&d->host, &u->primitives, g)) return FNL_ERROR_MEMORY;
        }
    }
    return FNL_OK;
}

/* ---- instances, items, groups, buckets ---- */

static struct gpu_instance device_instance(const mat4 *m) {
    struct gpu_instance r;
    for (int row = 0; row < 3; row++) r.rows[row] = (vec4){m->m[row], m->m[4 + row], m->m[8 + row], m->m[12 + row]};
    return r;
}

static mat4 instance_matrix(const struct scene_node *node, uint32_t k) {
    if (node->skin != SCENE_NONE) return mat4_identity(); /* the joints carry it (glTF 2.0, 3.7.3.1) */
    return node->instances ? mat4_mul(node->world, node->instances[k]) : node->world;
}

void device_scene_node_instances(const struct scene_node *node, struct gpu_instance *out) {
    for (uint32_t k = 0; k < node->instance_count; k++) {
        mat4 m = instance_matrix(node, k);
        out[k] = device_instance(&m);
    }
}

static fnl_result upload_instances(struct device_scene *d, uint32_t *out_count) {
    const fnl_scene *scene = d->scene;
    uint64_t count = 0;
    if (!array_reserve(&d->host, &d->node_instances, scene->nodes.count)) return FNL_ERROR_MEMORY;
    d->node_instances.count = scene->nodes.count;
    for (uint32_t n = 0; n < scene->nodes.count; n++) {
        bool draws = node_draws(&scene->nodes.data[n]);
        d->node_instances.data[n] = draws ? (uint32_t)count : SCENE_NONE;
        if (draws) count += scene->nodes.data[n].instance_count;
    }
    if (count > UINT32_MAX / sizeof(struct gpu_instance)) return FNL_ERROR_UNSUPPORTED;
    *out_count = (uint32_t)count;
    TRY(gpu_buffer_create(d->device, "instances", MAX(count, 1u) * sizeof(struct gpu_instance), GPU_MEMORY_DEVICE, &d->instances));
    struct gpu_instance chunk[256];
    for (uint32_t n = 0; n < scene->nodes.count; n++) {
        const struct scene_node *node = &scene->nodes.data[n];
        if (d->node_instances.data[n] == SCENE_NONE) continue;
        for (uint32_t k = 0; k < node->instance_count;) {
            uint32_t part = MIN(node->instance_count - k, COUNT_OF(chunk));
            for (uint32_t i = 0; i < part; i++) {
                mat4 m = instance_matrix(node, k + i);
                chunk[i] = device_instance(&m);
            }
            TRY(gpu_upload_buffer(d->device, &d->instances, (uint64_t)(d->node_instances.data[n] + k) * sizeof *chunk, chunk, part * sizeof *chunk));
            k += part;
        }
    }
    return FNL_OK;
}

/* A group of items: one primitive, one handedness. Ordered by bucket; the bucket's bits are its sort key. */
struct group_key { uint32_t bucket, primitive, mirrored, count, first; };

static uint32_t bucket_bits(const struct scene_material *m, enum scene_topology topology, bool mirrored) {
    bool blend = m->alpha_mode == FNL_ALPHA_BLEND, sorted = blend && topology == SCENE_TOPOLOGY_TRIANGLES;
    /* Blended triangles form one bucket at the end: they are drawn in one order over all states. */
    if (sorted) return 1u << 16;
    return (uint32_t)topology << 4 | (uint32_t)blend << 3 | (uint32_t)(m->alpha_mode == FNL_ALPHA_MASK) << 2 |
           (uint32_t)m->double_sided << 1 | (uint32_t)(mirrored && !m->double_sided);
}

static int compare_groups(const void *a, const void *b) {
    const struct group_key *x = a, *y = b;
    if (x->bucket != y->bucket) return x->bucket < y->bucket ? -1 : 1;
    if (x->primitive != y->primitive) return x->primitive < y->primitive ? -1 : 1;
    return (int)x->mirrored - (int)y->mirrored;
}

struct item_walk { struct device_scene *d; const struct upload *u; struct group_key *keys; const uint32_t *group_of_key; struct gpu_item *items; };

/* Visits every item in the order of nodes; counts (items NULL) or places them. */
static void walk_items(struct item_walk *w) {
    const fnl_scene *scene = w->d->scene;
    for (uint32_t n = 0; n < scene->nodes.count; n++) {
        const struct scene_node *node = &scene->nodes.data[n];
        if (w->d->node_instances.data[n] == SCENE_NONE) continue;
        const struct scene_mesh *mesh = &scene->meshes.data[node->mesh];
        uint32_t own = w->u->node_primitives[n];
        for (uint32_t i = 0; i < mesh->primitive_count; i++) {
            uint32_t primitive = own == SCENE_NONE ? mesh->first_primitive + i : own + i;
            for (uint32_t k = 0; k < node->instance_count; k++) {
                mat4 m = instance_matrix(node, k);
                uint32_t key = primitive * 2 + (mat4_determinant3(&m) < 0);
                if (!w->items) {
                    w->keys[key].count++;
                    continue;
                }
                struct group_key *group = &w->keys[w->group_of_key[key]];
                w->items[group->first + group->count++] = (struct gpu_item){w->d->node_instances.data[n] + k, primitive};
            }
        }
    }
}

static VkPrimitiveTopology vulkan_topology(uint32_t topology) {
    return topology == SCENE_TOPOLOGY_LINES ? VK_PRIMITIVE_TOPOLOGY_LINE_LIST
         : topology == SCENE_TOPOLOGY_POINTS ? VK_PRIMITIVE_TOPOLOGY_POINT_LIST : VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
}

static fnl_result upload_groups(struct upload *u, struct group_key *keys, uint32_t *group_of_key, uint32_t key_count) {
    struct device_scene *d = u->d;
    const fnl_scene *scene = d->scene;
    struct scene_material standard = scene_material_default();
    struct item_walk walk = {.d = d, .u = u, .keys = keys, .group_of_key = group_of_key};
    walk_items(&walk);

    /* What each key draws, from the scene primitive it came from. */
    uint32_t group_count = 0;
    uint64_t item_count = 0;
    for (uint32_t key = 0; key < key_count; key++) {
        if (keys[key].count == 0) continue;
        struct group_key group = {.primitive = key / 2, .mirrored = key & 1, .count = keys[key].count};
        keys[key].count = 0;
        const struct gpu_primitive *g = &u->primitives.data[group.primitive];
        const struct scene_primitive *source = &scene->primitives.data[group_of_key[key]];
        if (g->index_count == 0) continue;
        group.bucket = bucket_bits(material_of(scene, source, &standard), source->topology, group.mirrored);
        item_count += group.count;
        keys[group_count++] = group; /* never overtakes `key` */
    }
    if (item_count > UINT32_MAX - 1) return FNL_ERROR_UNSUPPORTED;
    qsort(keys, group_count, sizeof *keys, compare_groups);
    memset(group_of_key, 0, key_count * sizeof *group_of_key);

    struct gpu_group *groups = host_allocate_zero(&d->host, MAX(group_count, 1u) * sizeof *groups);
    struct gpu_item *items = host_allocate_zero(&d->host, MAX(item_count, 1u) * sizeof *items);
    fnl_result result = groups && items ? FNL_OK : FNL_ERROR_MEMORY;
    uint32_t first = 0;
    d->blend_item_count = 0;
    for (uint32_t i = 0; i < group_count && result == FNL_OK; i++) {
        struct group_key *key = &keys[i];
        group_of_key[key->primitive * 2 + key->mirrored] = i;
        key->first = first;
        groups[i] = (struct gpu_group){.first_item = first, .item_count = key->count, .primitive = key->primitive};
        struct geometry_bucket *last = d->buckets.count ? &d->buckets.data[d->buckets.count - 1] : NULL;
        if (i == 0 || keys[i - 1].bucket != key->bucket) {
            bool sorted = key->bucket == 1u << 16;
            struct geometry_bucket bucket = {
                .topology = sorted ? VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST : vulkan_topology(key->bucket >> 4), .blend = sorted || key->bucket & 8,
                .mask = !sorted && key->bucket & 4, .double_sided = !sorted && key->bucket & 2, .mirrored = !sorted && key->bucket & 1,
                .first_item = first, .first_group = i};
            if (!array_push(&d->host, &d->buckets, bucket)) {
                result = FNL_ERROR_MEMORY;
                break;
            }
            last = &d->buckets.data[d->buckets.count - 1];
            if (sorted) d->blend_first_item = first;
        }
        last->item_count += key->count;
        last->group_count++;
        if (key->bucket == 1u << 16) d->blend_item_count += key->count;
        first += key->count;
        key->count = 0;
    }
    if (result == FNL_OK) {
        walk.items = items;
        walk_items(&walk);
        d->item_count = (uint32_t)item_count;
        d->group_count = group_count;
        result = upload_array(d, "items", &d->items, items, item_count * sizeof *items);
        if (result == FNL_OK) result = upload_array(d, "groups", &d->groups, groups, group_count * sizeof *groups);
    }
    if (groups) host_free(&d->host, groups, MAX(group_count, 1u) * sizeof *groups);
    if (items) host_free(&d->host, items, MAX(item_count, 1u) * sizeof *items);
    return result;
}

/* Scene primitive of each key: deforming nodes' primitives stand behind those of the scene. */
static void map_keys(const struct upload *u, uint32_t *source_of_key) {
    const fnl_scene *scene = u->d->scene;
    for (uint32_t i = 0; i < scene->primitives.count; i++) source_of_key[i * 2] = source_of_key[i * 2 + 1] = i;
    for (uint32_t n = 0; n < scene->nodes.count; n++) {
        if (u->node_primitives[n] == SCENE_NONE) continue;
        const struct scene_mesh *mesh = &scene->meshes.data[scene->nodes.data[n].mesh];
        for (uint32_t i = 0; i < mesh->primitive_count; i++) {
            uint32_t key = (u->node_primitives[n] + i) * 2;
            source_of_key[key] = source_of_key[key + 1] = mesh->first_primitive + i;
        }
    }
}

static fnl_result upload_items(struct upload *u) {
    struct device_scene *d = u->d;
    uint32_t instance_count, key_count = u->primitives.count * 2;
    TRY(upload_instances(d, &instance_count));
    size_t keys_size = MAX(key_count, 1u) * sizeof(struct group_key), map_size = MAX(key_count, 1u) * sizeof(uint32_t);
    struct group_key *keys = host_allocate_zero(&d->host, keys_size);
    uint32_t *map = host_allocate_zero(&d->host, map_size);
    fnl_result result = FNL_ERROR_MEMORY;
    if (keys && map) {
        map_keys(u, map);
        result = upload_groups(u, keys, map, key_count);
    }
    if (keys) host_free(&d->host, keys, keys_size);
    if (map) host_free(&d->host, map, map_size);
    return result;
}

/* ---- all of it ---- */

static fnl_result upload_all(struct upload *u, const struct geometry_totals *totals) {
    struct device_scene *d = u->d;
    const fnl_scene *scene = d->scene;
    uint64_t vertices = totals->vertices + totals->deformed_vertices;
    TRY(gpu_buffer_create(d->device, "positions", MAX(vertices, 1u) * 12, GPU_MEMORY_DEVICE, &d->positions));
    TRY(gpu_buffer_create(d->device, "attributes", MAX(vertices, 1u) * sizeof(struct gpu_attributes), GPU_MEMORY_DEVICE, &d->attributes));
    TRY(gpu_buffer_create(d->device, "indices", MAX(totals->indices, 1u) * 4, GPU_MEMORY_DEVICE, &d->indices));
    TRY(gpu_buffer_create(d->device, "influences", MAX(totals->influences, 1u) * sizeof(struct gpu_influence), GPU_MEMORY_DEVICE, &d->influences));
    TRY(gpu_buffer_create(d->device, "morph targets", MAX(totals->morph_floats, 1u) * 4, GPU_MEMORY_DEVICE, &d->morphs));
    uint32_t first_vertex = 0, first_index = 0;
    for (uint32_t i = 0; i < scene->primitives.count; i++) {
        const struct scene_primitive *p = &scene->primitives.data[i];
        u->first_vertex[i] = first_vertex;
        TRY(upload_primitive(u, p, first_vertex, first_index));
        first_vertex += p->vertex_count;
        first_index += p->index_count;
    }
    TRY(upload_materials(d));
    TRY(upload_deforming_nodes(u, first_vertex));
    TRY(upload_array(d, "primitives", &d->primitives, u->primitives.data, u->primitives.count * sizeof *u->primitives.data));
    TRY(upload_array(d, "deforms", &d->deforms, u->deforms.data, u->deforms.count * sizeof *u->deforms.data));
    TRY(upload_items(u));
    struct gpu_scene table = {.positions = d->positions.address, .attributes = d->attributes.address, .instances = d->instances.address,
                              .primitives = d->primitives.address, .materials = d->materials.address, .items = d->items.address,
                              .groups = d->groups.address};
    return upload_array(d, "scene table", &d->table, &table, sizeof table);
}

fnl_result device_geometry_upload(struct device_scene *d) {
    const fnl_scene *scene = d->scene;
    struct geometry_totals totals = count_geometry(scene);
    if (totals.vertices + totals.deformed_vertices > INT32_MAX || totals.indices > UINT32_MAX || totals.influences > UINT32_MAX || totals.morph_floats > UINT32_MAX) {
        log_error(&d->host, "%s: has more vertices or indices than 32-bit draws can address", scene->source);
        return FNL_ERROR_UNSUPPORTED;
    }
    struct upload u = {.d = d};
    size_t vertex_size = MAX(scene->primitives.count, 1u) * sizeof(uint32_t), node_size = MAX(scene->nodes.count, 1u) * sizeof(uint32_t);
    u.first_vertex = host_allocate(&d->host, vertex_size);
    u.node_primitives = host_allocate(&d->host, node_size);
    fnl_result result = u.first_vertex && u.node_primitives ? upload_all(&u, &totals) : FNL_ERROR_MEMORY;
    if (u.first_vertex) host_free(&d->host, u.first_vertex, vertex_size);
    if (u.node_primitives) host_free(&d->host, u.node_primitives, node_size);
    array_free(&d->host, &u.primitives);
    array_free(&d->host, &u.deforms);
    return result;
}
