/* SPDX-License-Identifier: MIT */
#include "render/device/clusters.h"
#include "render/device/scene.h"

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

/* ---- what the device keeps of the scene's primitives: sent when they come and when they change ---- */

/* Blended surfaces stay in the order that they came in. */
static bool is_clustered(const struct device_scene *d, const struct scene_primitive *p) {
    return p->topology == SCENE_TOPOLOGY_TRIANGLES && p->index_count > 0 &&
           (p->material == SCENE_NONE || d->scene->materials.data[p->material].alpha_mode != FNL_ALPHA_BLEND);
}

/* Resizes a run in a pool; false if the pool is full. */
static bool place_run(struct device_scene *d, struct ranges *taken, uint32_t *first, uint32_t *count, uint64_t wanted) {
    if (*count == wanted) return true;
    ranges_give(&d->host, taken, *first, *count);
    *count = (uint32_t)wanted;
    *first = wanted >= RANGES_NONE ? RANGES_NONE : wanted ? ranges_take(taken, (uint32_t)wanted) : 0;
    if (*first == RANGES_NONE) *count = 0;
    return *first != RANGES_NONE;
}

static bool place_primitive(struct device_scene *d, const struct scene_primitive *p, struct device_primitive *place) {
    return place_run(d, &d->vertices_taken, &place->first_vertex, &place->vertex_count, p->vertex_count) &&
           place_run(d, &d->indices_taken, &place->first_index, &place->index_count, p->index_count) &&
           place_run(d, &d->influences_taken, &place->first_influence, &place->influence_count, (uint64_t)p->vertex_count * p->joint_count) &&
           place_run(d, &d->morphs_taken, &place->first_morph, &place->morph_count, (uint64_t)p->vertex_count * p->morph_target_count * 9) &&
           d->vertices_taken.end <= INT32_MAX;
}

/* Allocates room for new primitives and for those whose sizes changed. Removed primitives have size 0. */
static fnl_result place_primitives(struct device_scene *d) {
    const fnl_scene *scene = d->scene;
    if (!array_reserve(&d->host, &d->primitive_places, scene->primitives.count)) return FNL_ERROR_MEMORY;
    for (uint32_t i = 0; i < scene->primitives.count; i++) {
        const struct scene_primitive *p = &scene->primitives.data[i];
        if (i == d->primitive_places.count)
            d->primitive_places.data[d->primitive_places.count++] = (struct device_primitive){.version = p->version, .shape_version = p->shape_version};
        if (!place_primitive(d, p, &d->primitive_places.data[i])) return device_too_many_vertices(d);
    }
    d->index_count = d->indices_taken.end;
    d->influence_count = d->influences_taken.end;
    d->morph_count = d->morphs_taken.end;
    return FNL_OK;
}

/* The pools as large as what has a place in them; before, they held `vertices`, … of it. */
struct pools {
    uint32_t vertices, indices, influences, morphs;
};

static fnl_result reserve_pools(struct device_scene *d, const struct pools *before) {
    uint64_t vertices = d->vertices_taken.end;
    TRY(device_buffer_reserve(d, GPU_USE_GEOMETRY, "positions", &d->positions, before->vertices * 12ull, vertices * 12));
    TRY(device_buffer_reserve(d, GPU_USE_GEOMETRY, "attributes", &d->attributes, before->vertices * sizeof(struct gpu_attributes),
                              vertices * sizeof(struct gpu_attributes)));
    TRY(device_buffer_reserve(d, GPU_USE_GEOMETRY, "indices", &d->indices, before->indices * 4ull,
                              d->index_count * 4ull + d->pool_triangles * 12ull));
    TRY(device_buffer_reserve(d, GPU_USE_GEOMETRY, "influences", &d->influences, before->influences * sizeof(struct gpu_influence),
                              d->influence_count * sizeof(struct gpu_influence)));
    return device_buffer_reserve(d, GPU_USE_GEOMETRY, "morph targets", &d->morphs, before->morphs * 4ull, d->morph_count * 4ull);
}

static fnl_result upload_positions(struct device_scene *d, const struct scene_primitive *p, uint32_t first) {
    return device_upload(d, &d->positions, first * 12ull, p->positions, p->vertex_count * 12ull);
}

static fnl_result upload_attributes(struct device_scene *d, const struct scene_primitive *p, uint32_t first) {
    struct gpu_attributes packed[256];
    if (p->colors) d->color_bits |= GEOMETRY_COLORS;
    if (p->leans) d->leaning = true;
    for (uint32_t v = 0; v < p->vertex_count;) {
        uint32_t count = MIN(p->vertex_count - v, COUNT_OF(packed));
        for (uint32_t i = 0; i < count; i++) packed[i] = pack_attributes(p, v + i);
        TRY(device_upload(d, &d->attributes, (uint64_t)(first + v) * sizeof *packed, packed, count * sizeof *packed));
        v += count;
    }
    return FNL_OK;
}

/* Influences and morph differences, which all nodes that show the primitive share. */
static fnl_result upload_deformation(struct device_scene *d, const struct scene_primitive *p,
                                     const struct device_primitive *place) {
    uint64_t pairs = (uint64_t)p->vertex_count * p->joint_count,
             floats = (uint64_t)p->vertex_count * p->morph_target_count * 9;
    size_t bytes = MAX(pairs * sizeof(struct gpu_influence), floats * 4);
    void *memory = bytes ? host_allocate(&d->host, bytes) : NULL;
    if (bytes && !memory) return FNL_ERROR_MEMORY;
    fnl_result result = FNL_OK;
    if (pairs) {
        struct gpu_influence *influences = memory;
        for (uint64_t i = 0; i < pairs; i++) influences[i] = (struct gpu_influence){p->joints[i], p->weights[i]};
        result = device_upload(d, &d->influences, place->first_influence * sizeof *influences, influences,
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
        result = device_upload(d, &d->morphs, place->first_morph * 4ull, differences, floats * 4);
    }
    if (bytes) host_free(&d->host, memory, bytes);
    return result;
}

/* ---- triangles and the clusters that they are cut into ---- */

/* The clusters of several primitives, before they have a place. */
struct cluster_batch {
    gpu_cluster_list clusters;
    gpu_word_list words; /* for mesh shaders */
};

/* Sends the indices, cluster by cluster where there are any; places are within the batch. */
static fnl_result upload_triangles(struct device_scene *d, const struct scene_primitive *p, struct device_primitive *place,
                                   struct cluster_batch *batch) {
    place->clustered = is_clustered(d, p);
    place->first_cluster = batch->clusters.count;
    place->first_word = batch->words.count;
    place->cluster_count = place->word_count = 0;
    if (!place->clustered)
        return device_upload(d, &d->indices, place->first_index * 4ull, p->indices, p->index_count * 4ull);
    uint32_t *indices = host_allocate(&d->host, p->index_count * 4ull);
    if (!indices) return FNL_ERROR_MEMORY;
    gpu_word_list *words = gpu_info(d->device)->mesh_shader ? &batch->words : NULL;
    fnl_result result = device_clusters_build(&d->host, p, &batch->clusters, indices, words);
    if (result == FNL_OK)
        result = device_upload(d, &d->indices, place->first_index * 4ull, indices, p->index_count * 4ull);
    host_free(&d->host, indices, p->index_count * 4ull);
    place->cluster_count = batch->clusters.count - place->first_cluster;
    place->word_count = batch->words.count - place->first_word;
    return result;
}

/* Sends a batch; `changed` are the primitives that it is of. */
static fnl_result place_clusters(struct device_scene *d, struct cluster_batch *batch, const uint32_t *changed,
                                 uint32_t changed_count) {
    uint32_t cluster_end = d->clusters_taken.end, word_end = d->words_taken.end, first_cluster = 0, first_word = 0;
    if (batch->clusters.count) first_cluster = ranges_take(&d->clusters_taken, batch->clusters.count);
    if (batch->words.count) first_word = ranges_take(&d->words_taken, batch->words.count);
    if (first_cluster == RANGES_NONE || first_word == RANGES_NONE) return device_too_many_vertices(d);
    for (uint32_t i = 0; i < batch->clusters.count; i++) batch->clusters.data[i].first_word += first_word;
    for (uint32_t i = 0; i < changed_count; i++) {
        d->primitive_places.data[changed[i]].first_cluster += first_cluster;
        d->primitive_places.data[changed[i]].first_word += first_word;
    }
    const uint64_t size = sizeof *batch->clusters.data;
    TRY(device_buffer_reserve(d, GPU_USE_GEOMETRY, "clusters", &d->clusters, cluster_end * size, d->clusters_taken.end * size));
    TRY(device_buffer_reserve(d, GPU_USE_GEOMETRY, "cluster words", &d->cluster_words, word_end * 4ull, d->words_taken.end * 4ull));
    TRY(device_upload(d, &d->clusters, first_cluster * size, batch->clusters.data, batch->clusters.count * size));
    return device_upload(d, &d->cluster_words, first_word * 4ull, batch->words.data, batch->words.count * 4ull);
}

/* Of the primitives from `first` on, and of those before that have another shape, or whose material has begun or ceased to blend. */
static fnl_result upload_all_triangles(struct device_scene *d, uint32_t first) {
    struct cluster_batch batch = {{0}, {0}};
    ARRAY(uint32_t) changed = {0};
    fnl_result result = FNL_OK;
    for (uint32_t i = 0; i < d->primitive_places.count && result == FNL_OK; i++) {
        const struct scene_primitive *p = &d->scene->primitives.data[i];
        struct device_primitive *place = &d->primitive_places.data[i];
        if (i < first && place->clustered == is_clustered(d, p) && place->shape_version == p->shape_version) continue;
        place->shape_version = p->shape_version;
        ranges_give(&d->host, &d->clusters_taken, place->first_cluster, place->cluster_count);
        ranges_give(&d->host, &d->words_taken, place->first_word, place->word_count);
        result = upload_triangles(d, p, place, &batch);
        if (result == FNL_OK && !array_push(&d->host, &changed, i)) result = FNL_ERROR_MEMORY;
    }
    if (result == FNL_OK) result = place_clusters(d, &batch, changed.data, changed.count);
    array_free(&d->host, &changed);
    array_free(&d->host, &batch.clusters);
    array_free(&d->host, &batch.words);
    return result;
}

/* ---- all primitives: those of the scene, then those of deforming nodes ---- */

struct upload {
    struct device_scene *d;
    ARRAY(struct gpu_primitive) primitives;
    ARRAY(struct gpu_deform) deforms;
};

static struct gpu_primitive device_primitive(const struct device_scene *d, uint32_t index) {
    const struct scene_primitive *p = &d->scene->primitives.data[index];
    const struct device_primitive *place = &d->primitive_places.data[index];
    return (struct gpu_primitive){
        .center = vec3_scale(vec3_add(p->bounds.low, p->bounds.high), 0.5f),
        .half_extent = vec3_scale(vec3_sub(p->bounds.high, p->bounds.low), 0.5f),
        .material = p->material == SCENE_NONE ? d->scene->materials.count : p->material,
        .first_index = place->first_index,
        .index_count = p->index_count,
        .vertex_offset = (int32_t)place->first_vertex,
        .corners = 3 - (uint32_t)p->topology,
        .first_cluster = place->cluster_count ? place->first_cluster : 0,
        .cluster_count = place->cluster_count};
}

/* The primitives of one deforming node; its vertices have their place. */
static fnl_result add_deforming_node(struct upload *u, uint32_t n) {
    struct device_scene *d = u->d;
    const fnl_scene *scene = d->scene;
    const struct scene_node *node = &scene->nodes.data[n];
    const struct scene_mesh *mesh = &scene->meshes.data[node->mesh];
    struct device_deform deform = {
        .node = n,
        .skin = node->skin,
        .first_matrix = d->matrix_count,
        .first_weight = d->weight_count,
        .matrix_count = node->skin == SCENE_NONE ? 0 : scene->skins.data[node->skin].joint_count,
        .weight_count = mesh->morph_target_count};
    d->matrix_count += deform.matrix_count;
    d->weight_count += deform.weight_count;
    if (!array_push(&d->host, &d->deformed, deform)) return FNL_ERROR_MEMORY;
    d->nodes.data[n].first_primitive = u->primitives.count;
    uint32_t first_vertex = d->nodes.data[n].first_vertex;
    for (uint32_t i = 0; i < mesh->primitive_count; i++) {
        uint32_t index = mesh->first_primitive + i;
        const struct scene_primitive *p = &scene->primitives.data[index];
        const struct device_primitive *place = &d->primitive_places.data[index];
        struct gpu_primitive g = u->primitives.data[index];
        if (device_node_deforms(node, p)) {
            struct gpu_deform out = {.source = place->first_vertex,
                                     .target = first_vertex,
                                     .count = p->vertex_count,
                                     .first_matrix = deform.first_matrix,
                                     .first_weight = deform.first_weight,
                                     .joint_count = node->skin != SCENE_NONE ? p->joint_count : 0,
                                     .first_influence = place->first_influence,
                                     .morph_count = p->morph_target_count,
                                     .first_morph = place->first_morph};
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
    return FNL_OK;
}

static fnl_result upload_all(struct upload *u) {
    struct device_scene *d = u->d;
    const fnl_scene *scene = d->scene;
    if (!array_reserve(&d->host, &u->primitives, MAX(scene->primitives.count, 1u))) return FNL_ERROR_MEMORY;
    for (uint32_t i = 0; i < scene->primitives.count; i++) u->primitives.data[i] = device_primitive(d, i);
    u->primitives.count = scene->primitives.count;
    d->deformed.count = d->deform_vertex_counts.count = d->matrix_count = d->weight_count = 0;
    d->sent.poses = UINT64_MAX;
    d->first_deformed = d->vertices_taken.end;
    for (uint32_t n = 0; n < d->nodes.count; n++) {
        d->nodes.data[n].first_primitive = SCENE_NONE;
        if (d->nodes.data[n].vertex_count == 0) continue;
        d->first_deformed = MIN(d->first_deformed, d->nodes.data[n].first_vertex);
        TRY(add_deforming_node(u, n));
    }
    d->deformed_vertex_count = d->vertices_taken.end - d->first_deformed;
    TRY(device_array_set(d, GPU_USE_GEOMETRY, "primitives", &d->primitives, u->primitives.data, u->primitives.count,
                         sizeof *u->primitives.data));
    TRY(device_array_set(d, GPU_USE_GEOMETRY, "deforms", &d->deforms, u->deforms.data, u->deforms.count, sizeof *u->deforms.data));
    TRY(device_items_upload(d));
    return device_table_send(d);
}

fnl_result device_table_send(struct device_scene *d) {
    struct gpu_scene table = {.positions = d->positions.address,
                              .attributes = d->attributes.address,
                              .instances = d->instances.address,
                              .primitives = d->primitives.buffer.address,
                              .materials = d->materials.buffer.address,
                              .items = d->items.buffer.address,
                              .groups = d->groups.buffer.address,
                              .clusters = d->clusters.address,
                              .cluster_words = d->cluster_words.address};
    return device_array_set(d, GPU_USE_GEOMETRY, "scene table", &d->table, &table, 1, sizeof table);
}

fnl_result device_geometry_upload(struct device_scene *d) {
    const fnl_scene *scene = d->scene;
    uint32_t first = d->primitive_places.count;
    const struct pools before = {d->vertices_taken.end, d->index_count, d->influence_count, d->morph_count};
    TRY(place_primitives(d));
    TRY(device_nodes_place(d, NULL, scene->nodes.count));
    TRY(reserve_pools(d, &before));
    for (uint32_t i = first; i < scene->primitives.count; i++) {
        const struct scene_primitive *p = &scene->primitives.data[i];
        TRY(upload_positions(d, p, d->primitive_places.data[i].first_vertex));
        TRY(upload_attributes(d, p, d->primitive_places.data[i].first_vertex));
        TRY(upload_deformation(d, p, &d->primitive_places.data[i]));
    }
    for (uint32_t i = 0; i < first; i++) {
        const struct scene_primitive *p = &scene->primitives.data[i];
        struct device_primitive *place = &d->primitive_places.data[i];
        if (place->version == p->version) continue;
        if (place->shape_version != p->shape_version) {
            TRY(upload_positions(d, p, place->first_vertex));
            TRY(upload_deformation(d, p, place)); /* another primitive may have taken the index */
        }
        TRY(upload_attributes(d, p, place->first_vertex));
        place->version = p->version;
    }
    TRY(upload_all_triangles(d, first));
    struct upload u = {.d = d};
    fnl_result result = upload_all(&u);
    array_free(&d->host, &u.primitives);
    array_free(&d->host, &u.deforms);
    return result;
}
