/* SPDX-License-Identifier: MIT */
#include "render/device/clusters.h"
#include "render/device/scene.h"

/* Whether a node's vertices are its own, moved every frame. */
static bool node_deforms(const struct scene_node *node, const struct scene_primitive *p) {
    return (node->skin != SCENE_NONE && p->joint_count > 0) || p->morph_target_count > 0;
}

static uint32_t pack_snorm16(float v) { return (uint32_t)(uint16_t)(int16_t)lrintf(CLAMP(v, -1.0f, 1.0f) * 32767); }
static uint32_t pack_unorm16(float v) { return (uint32_t)lrintf(CLAMP(v, 0.0f, 1.0f) * 65535); }

static struct gpu_attributes pack_attributes(const struct scene_primitive *p, uint32_t v) {
    vec2 n = octahedral_encode(p->normals ? p->normals[v] : (vec3){0, 0, 1});
    vec4 t = p->tangents ? p->tangents[v] : (vec4){1, 0, 0, 1};
    vec2 e = octahedral_encode((vec3){t.x, t.y, t.z});
    vec4 c = p->colors ? p->colors[v] : (vec4){1, 1, 1, 1};
    uint32_t ex = (uint32_t)lrintf((e.x * 0.5f + 0.5f) * 65535), ey = (uint32_t)lrintf((e.y * 0.5f + 0.5f) * 32767);
    return (struct gpu_attributes){
        .normal = pack_snorm16(n.x) | pack_snorm16(n.y) << 16,
        .tangent = ex | ey << 16 | (t.w < 0 ? 0x80000000u : 0),
        .uv0 = p->uv[0] ? p->uv[0][v] : (vec2){0, 0},
        .uv1 = p->uv[1] ? p->uv[1][v] : (vec2){0, 0},
        .color = {pack_unorm16(c.x) | pack_unorm16(c.y) << 16, pack_unorm16(c.z) | pack_unorm16(c.w) << 16}};
}

/* What is counted before anything is allocated; vertices and indices are below 2^32 in all. */
struct geometry_totals {
    uint64_t vertices, indices, deformed_vertices, influences, morph_floats;
    uint32_t primitives;
};

struct upload {
    struct device_scene *d;
    ARRAY(struct gpu_primitive) primitives; /* those of the scene first, then those of deforming nodes */
    uint32_t *first_vertex;                 /* of each scene primitive */
    uint32_t *node_primitives;              /* of each node: its first own primitive, or SCENE_NONE */
    ARRAY(struct gpu_deform) deforms;
    gpu_cluster_list clusters;
    gpu_word_list words; /* of the clusters, for mesh shaders */
};

static struct geometry_totals count_geometry(const fnl_scene *scene) {
    struct geometry_totals t = {.primitives = scene->primitives.count};
    for (uint32_t i = 0; i < scene->primitives.count; i++) {
        t.vertices += scene->primitives.data[i].vertex_count;
        t.indices += scene->primitives.data[i].index_count;
    }
    for (uint32_t n = 0; n < scene->nodes.count; n++) {
        const struct scene_node *node = &scene->nodes.data[n];
        if (!device_node_draws(node)) continue;
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

/* Blended surfaces stay in the order that they came in. */
static bool is_clustered(const struct device_scene *d, const struct scene_primitive *p) {
    return p->topology == SCENE_TOPOLOGY_TRIANGLES && p->index_count > 0 &&
           (p->material == SCENE_NONE || d->scene->materials.data[p->material].alpha_mode != FNL_ALPHA_BLEND);
}

static fnl_result upload_clusters(struct upload *u, const struct scene_primitive *p, uint32_t first_index) {
    struct device_scene *d = u->d;
    uint32_t *indices = host_allocate(&d->host, p->index_count * 4ull);
    if (!indices) return FNL_ERROR_MEMORY;
    fnl_result result =
        device_clusters_build(&d->host, p, &u->clusters, indices, gpu_info(d->device)->mesh_shader ? &u->words : NULL);
    if (result == FNL_OK)
        result = gpu_upload_buffer(d->device, &d->indices, first_index * 4ull, indices, p->index_count * 4ull);
    host_free(&d->host, indices, p->index_count * 4ull);
    return result;
}

static fnl_result upload_primitive(struct upload *u, const struct scene_primitive *p, uint32_t first_vertex,
                                   uint32_t first_index) {
    struct gpu_attributes packed[256];
    struct device_scene *d = u->d;
    if (p->colors) d->attribute_bits |= GEOMETRY_COLORS;
    TRY(gpu_upload_buffer(d->device, &d->positions, first_vertex * 12ull, p->positions, p->vertex_count * 12ull));
    uint32_t first_cluster = u->clusters.count;
    if (is_clustered(d, p))
        TRY(upload_clusters(u, p, first_index));
    else
        TRY(gpu_upload_buffer(d->device, &d->indices, first_index * 4ull, p->indices, p->index_count * 4ull));
    for (uint32_t v = 0; v < p->vertex_count;) {
        uint32_t count = MIN(p->vertex_count - v, COUNT_OF(packed));
        for (uint32_t i = 0; i < count; i++) packed[i] = pack_attributes(p, v + i);
        TRY(gpu_upload_buffer(d->device, &d->attributes, (uint64_t)(first_vertex + v) * sizeof *packed, packed,
                              count * sizeof *packed));
        v += count;
    }
    struct gpu_primitive g = {.material = p->material == SCENE_NONE ? d->scene->materials.count : p->material,
                              .first_index = first_index,
                              .index_count = p->index_count,
                              .vertex_offset = (int32_t)first_vertex,
                              .corners = 3 - (uint32_t)p->topology,
                              .first_cluster = first_cluster,
                              .cluster_count = u->clusters.count - first_cluster};
    g.center = vec3_scale(vec3_add(p->bounds.low, p->bounds.high), 0.5f);
    g.half_extent = vec3_scale(vec3_sub(p->bounds.high, p->bounds.low), 0.5f);
    return array_push(&d->host, &u->primitives, g) ? FNL_OK : FNL_ERROR_MEMORY;
}

/* Influences and morph differences of one deforming primitive. */
static fnl_result upload_deform(struct upload *u, const struct scene_node *node, const struct device_deform *deform,
                                const struct scene_primitive *p, uint64_t *influence_count, uint64_t *morph_count,
                                struct gpu_deform *out) {
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
        result = gpu_upload_buffer(d->device, &d->influences, *influence_count * sizeof *influences, influences,
                                   pairs * sizeof *influences);
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
        if (!device_node_draws(node)) continue;
        const struct scene_mesh *mesh = &scene->meshes.data[node->mesh];
        bool deforms = false;
        for (uint32_t i = 0; i < mesh->primitive_count; i++)
            deforms = deforms || node_deforms(node, &scene->primitives.data[mesh->first_primitive + i]);
        if (!deforms) continue;
        struct device_deform deform = {.node = n,
                                       .skin = node->skin,
                                       .first_matrix = d->matrix_count,
                                       .first_weight = d->weight_count,
                                       .matrix_count =
                                           node->skin == SCENE_NONE ? 0 : scene->skins.data[node->skin].joint_count,
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
                g.bind_offset = (int32_t)(out.source - first_vertex);
                first_vertex += p->vertex_count;
                /* Joints and weights may carry the vertices anywhere: what deforms is never culled. */
                g.half_extent = (vec3){1e18f, 1e18f, 1e18f};
                if (!array_push(&d->host, &u->deforms, out) ||
                    !array_push(&d->host, &d->deform_vertex_counts, p->vertex_count))
                    return FNL_ERROR_MEMORY;
            }
            if (!array_push(&d->host, &u->primitives, g)) return FNL_ERROR_MEMORY;
        }
    }
    return FNL_OK;
}

static fnl_result upload_all(struct upload *u, const struct geometry_totals *totals) {
    struct device_scene *d = u->d;
    const fnl_scene *scene = d->scene;
    uint64_t vertices = totals->vertices + totals->deformed_vertices;
    TRY(gpu_buffer_create(d->device, "positions", MAX(vertices, 1u) * 12, GPU_MEMORY_DEVICE, &d->positions));
    TRY(gpu_buffer_create(d->device, "attributes", MAX(vertices, 1u) * sizeof(struct gpu_attributes), GPU_MEMORY_DEVICE,
                          &d->attributes));
    TRY(gpu_buffer_create(d->device, "indices", MAX(totals->indices, 1u) * 4, GPU_MEMORY_DEVICE, &d->indices));
    d->index_count = (uint32_t)totals->indices;
    d->pool_triangles = 0;
    TRY(gpu_buffer_create(d->device, "influences", MAX(totals->influences, 1u) * sizeof(struct gpu_influence),
                          GPU_MEMORY_DEVICE, &d->influences));
    TRY(gpu_buffer_create(d->device, "morph targets", MAX(totals->morph_floats, 1u) * 4, GPU_MEMORY_DEVICE, &d->morphs));
    uint32_t first_vertex = 0, first_index = 0;
    for (uint32_t i = 0; i < scene->primitives.count; i++) {
        const struct scene_primitive *p = &scene->primitives.data[i];
        u->first_vertex[i] = first_vertex;
        TRY(upload_primitive(u, p, first_vertex, first_index));
        first_vertex += p->vertex_count;
        first_index += p->index_count;
    }
    TRY(device_materials_upload(d));
    d->first_deformed = first_vertex;
    d->deformed_vertex_count = (uint32_t)totals->deformed_vertices;
    TRY(upload_deforming_nodes(u, first_vertex));
    TRY(device_upload_array(d, "primitives", &d->primitives, u->primitives.data,
                            u->primitives.count * sizeof *u->primitives.data));
    TRY(device_upload_array(d, "clusters", &d->clusters, u->clusters.data, u->clusters.count * sizeof *u->clusters.data));
    TRY(device_upload_array(d, "cluster words", &d->cluster_words, u->words.data, u->words.count * 4ull));
    TRY(device_upload_array(d, "deforms", &d->deforms, u->deforms.data, u->deforms.count * sizeof *u->deforms.data));
    TRY(device_items_upload(d, u->primitives.data, u->primitives.count, u->node_primitives));
    struct gpu_scene table = {.positions = d->positions.address,
                              .attributes = d->attributes.address,
                              .instances = d->instances.address,
                              .primitives = d->primitives.address,
                              .materials = d->materials.address,
                              .items = d->items.address,
                              .groups = d->groups.address,
                              .clusters = d->clusters.address,
                              .cluster_words = d->cluster_words.address};
    return device_upload_array(d, "scene table", &d->table, &table, sizeof table);
}

fnl_result device_geometry_upload(struct device_scene *d) {
    const fnl_scene *scene = d->scene;
    struct geometry_totals totals = count_geometry(scene);
    if (totals.vertices + totals.deformed_vertices > INT32_MAX || totals.indices > UINT32_MAX ||
        totals.influences > UINT32_MAX || totals.morph_floats > UINT32_MAX) {
        log_error(&d->host, "%s: has more vertices or indices than 32-bit draws can address", scene->source);
        return FNL_ERROR_UNSUPPORTED;
    }
    struct upload u = {.d = d};
    size_t vertex_size = MAX(scene->primitives.count, 1u) * sizeof(uint32_t),
           node_size = MAX(scene->nodes.count, 1u) * sizeof(uint32_t);
    u.first_vertex = host_allocate(&d->host, vertex_size);
    u.node_primitives = host_allocate(&d->host, node_size);
    fnl_result result = u.first_vertex && u.node_primitives ? upload_all(&u, &totals) : FNL_ERROR_MEMORY;
    if (result == FNL_OK && !array_reserve(&d->host, &d->node_primitives, scene->nodes.count)) result = FNL_ERROR_MEMORY;
    if (result == FNL_OK && scene->nodes.count)
        memcpy(d->node_primitives.data, u.node_primitives, scene->nodes.count * sizeof(uint32_t));
    if (u.first_vertex) host_free(&d->host, u.first_vertex, vertex_size);
    if (u.node_primitives) host_free(&d->host, u.node_primitives, node_size);
    array_free(&d->host, &u.primitives);
    array_free(&d->host, &u.deforms);
    array_free(&d->host, &u.clusters);
    array_free(&d->host, &u.words);
    return result;
}
