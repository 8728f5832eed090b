/* SPDX-License-Identifier: MIT */
/* Adding, changing and querying meshes. */
#include "base/check.h"
#include "scene/scene.h"

/* ---- checks ---- */

static uint32_t corner_count(enum scene_topology topology) { return 3 - (uint32_t)topology; }

static fnl_result check_indices(const struct call *call, const fnl_mesh_params *p) {
    for (uint32_t i = 0; i < p->index_count; i++)
        if (p->indices[i] >= p->vertex_count)
            return misuse(call, "indices[%u] is %u, must be below vertex_count, %u", i, p->indices[i], p->vertex_count);
    return FNL_OK;
}

static fnl_result check_vertices(const struct call *call, const char *name, const float *values, uint64_t count) {
    return values ? check_floats(call, name, values, count, -(double)FLT_MAX, (double)FLT_MAX, "") : FNL_OK;
}

static fnl_result check_mesh(const struct call *call, const fnl_scene *scene, const fnl_mesh_params *p, uint32_t corners) {
    uint64_t count = p->vertex_count;
    TRY(check_count(call, "vertex_count", count, 1, UINT32_MAX - 1));
    TRY(check_pointer(call, "positions", p->positions));
    if (!p->indices && p->index_count)
        return misuse(call, "indices is NULL, but index_count is %u; both or neither must be there", p->index_count);
    if (p->indices && !p->index_count)
        return misuse(call, "index_count is 0, but indices is not NULL; both or neither must be there");
    if ((p->indices ? p->index_count : p->vertex_count) % corners != 0)
        return misuse(call, "%s is %u, must be a multiple of %u", p->indices ? "index_count" : "vertex_count (without indices)",
                      p->indices ? p->index_count : p->vertex_count, corners);
    TRY(check_indices(call, p));
    TRY(check_vertices(call, "positions", p->positions, count * 3));
    TRY(check_vertices(call, "normals", p->normals, count * 3));
    TRY(check_vertices(call, "tangents", p->tangents, count * 4));
    TRY(check_vertices(call, "uv", p->uv, count * 2));
    TRY(check_vertices(call, "colors", p->colors, count * 4));
    return scene_check_material(call, scene, p->material, true);
}

/* What a file gave a mesh and fnl_mesh_params cannot express is stored per vertex: then vertices keep their number and order. */
static fnl_result check_kept(const struct call *call, const struct scene_primitive *old, const fnl_mesh_params *p) {
    if (!old->uv[1] && !old->joint_count && !old->morph_target_count && old->topology == SCENE_TOPOLOGY_TRIANGLES) return FNL_OK;
    const char *what = old->morph_target_count                      ? "morph targets"
                       : old->joint_count                           ? "joints"
                       : old->topology == SCENE_TOPOLOGY_TRIANGLES ? "a second set of texture coordinates"
                                                                    : "lines or points";
    if (p->vertex_count != old->vertex_count)
        return misuse(call, "vertex_count is %u, must stay %u: the mesh has %s", p->vertex_count, old->vertex_count, what);
    if (!p->indices) return misuse(call, "indices is NULL, must be given: the mesh has %s", what);
    if (old->topology != SCENE_TOPOLOGY_TRIANGLES) return FNL_OK;
    if (!p->normals) return misuse(call, "normals is NULL, must be given: the mesh has %s", what);
    if (!p->tangents && (p->uv || old->uv[1])) return misuse(call, "tangents is NULL, must be given: the mesh has %s", what);
    return FNL_OK;
}

/* ---- arrays ---- */

/** A copy of an optional array; `failed` is set when memory ran out. */
static const void *copy_optional(struct arena *arena, const void *data, uint64_t size, bool *failed) {
    if (!data) return NULL;
    void *copy = arena_copy(arena, data, (size_t)size);
    if (!copy) *failed = true;
    return copy;
}

/* The arrays of the params, completed. What else a primitive has is left out. */
static fnl_result make_primitive(const fnl_scene *scene, struct arena *arena, const fnl_mesh_params *p, enum scene_topology topology,
                                 struct scene_primitive *out) {
    bool failed = false;
    uint64_t count = p->vertex_count;
    *out = (struct scene_primitive){
        .material = p->material.generation ? p->material.index : SCENE_NONE,
        .topology = topology,
        .vertex_count = p->vertex_count,
        .index_count = p->index_count,
        .indices = copy_optional(arena, p->indices, (uint64_t)p->index_count * 4, &failed),
        .positions = copy_optional(arena, p->positions, count * sizeof(vec3), &failed),
        .normals = copy_optional(arena, p->normals, count * sizeof(vec3), &failed),
        .tangents = copy_optional(arena, p->tangents, count * sizeof(vec4), &failed),
        .uv = {copy_optional(arena, p->uv, count * sizeof(vec2), &failed)},
        .colors = copy_optional(arena, p->colors, count * sizeof(vec4), &failed),
    };
    return failed ? FNL_ERROR_MEMORY : mesh_complete_by(arena, out, 0, out->material == SCENE_NONE ? NULL : scene->materials.data[out->material].tangent_frame);
}

static bool equal(const void *a, const void *b, uint64_t size) {
    return a == b || (a && b && memcmp(a, b, (size_t)size) == 0);
}

static bool equal_shapes(const struct scene_primitive *a, const struct scene_primitive *b) {
    return a->vertex_count == b->vertex_count && a->index_count == b->index_count &&
           equal(a->positions, b->positions, a->vertex_count * sizeof(vec3)) &&
           equal(a->indices, b->indices, a->index_count * sizeof(uint32_t));
}

/* Of equal vertex counts. */
static bool equal_attributes(const struct scene_primitive *a, const struct scene_primitive *b) {
    uint64_t count = a->vertex_count;
    return equal(a->normals, b->normals, count * sizeof(vec3)) && equal(a->tangents, b->tangents, count * sizeof(vec4)) &&
           equal(a->uv[0], b->uv[0], count * sizeof(vec2)) && equal(a->colors, b->colors, count * sizeof(vec4));
}

/* The arrays of `from`, which may be shared; material and memory stay. */
static void take_arrays(struct scene_primitive *to, const struct scene_primitive *from) {
    to->vertex_count = from->vertex_count;
    to->index_count = from->index_count;
    to->indices = from->indices;
    to->positions = from->positions;
    to->normals = from->normals;
    to->tangents = from->tangents;
    to->uv[0] = from->uv[0];
    to->colors = from->colors;
}

static void update_bounds(fnl_scene *scene, uint32_t index, struct scene_primitive *changed) {
    struct scene_mesh *mesh = &scene->meshes.data[index];
    changed->bounds = primitive_bounds(changed);
    changed->leans = primitive_leans(changed);
    mesh->bounds = box_empty();
    for (uint32_t i = 0; i < mesh->primitive_count; i++)
        box_add_box(&mesh->bounds, &scene->primitives.data[mesh->first_primitive + i].bounds);
}

/* ---- calls ---- */

fnl_result fnl_scene_add_mesh(fnl_scene *scene, const fnl_mesh_params *params, fnl_mesh_id *out) {
    TRY(check_handle(__func__, "scene", scene));
    const struct call *call = CALL(&scene->host);
    TRY(check_pointer(call, "out", out));
    *out = (fnl_mesh_id){0};
    TRY(check_pointer(call, "params", params));
    TRY(check_mesh(call, scene, params, 3));
    struct scene_primitive primitive;
    struct arena memory;
    arena_init(&memory, &scene->host, 4096);
    const fnl_result result = make_primitive(scene, &memory, params, SCENE_TOPOLOGY_TRIANGLES, &primitive);
    primitive.memory = memory;
    const uint32_t index = result == FNL_OK ? scene_add_mesh(scene, "", &primitive, 1) : SCENE_NONE;
    if (index == SCENE_NONE) {
        arena_finish(&memory);
        return result == FNL_OK ? FNL_ERROR_MEMORY : result;
    }
    *out = (fnl_mesh_id){index, scene->meshes.data[index].generation};
    return FNL_OK;
}

/* Copies that baked decals are painted on share the arrays, and are painted anew. */
static fnl_result update_painted(fnl_scene *scene, uint32_t mesh, uint32_t primitive, bool other_material) {
    for (uint32_t i = 0; i < scene->painted.count; i++) {
        const struct scene_painted *painted = &scene->painted.data[i];
        if (painted->mesh != mesh) continue;
        const struct scene_primitive *source = &scene->primitives.data[scene->meshes.data[mesh].first_primitive + primitive];
        struct scene_primitive *own =
            &scene->primitives.data[scene->meshes.data[painted->own_mesh].first_primitive + primitive];
        take_arrays(own, source);
        own->version = source->version;
        own->shape_version = source->shape_version;
        update_bounds(scene, painted->own_mesh, own);
        if (other_material) {
            struct scene_material *copy = &scene->materials.data[own->material];
            const uint32_t generation = copy->generation;
            *copy = source->material == SCENE_NONE ? scene_material_default() : scene->materials.data[source->material];
            copy->generation = generation;
        }
        if (!scene->nodes.data[painted->node].removed) TRY(decal_bake(scene, painted->node));
    }
    return FNL_OK;
}

fnl_result fnl_scene_set_mesh(fnl_scene *scene, fnl_mesh_id id, uint32_t primitive, const fnl_mesh_params *params) {
    TRY(check_handle(__func__, "scene", scene));
    const struct call *call = CALL(&scene->host);
    TRY(scene_check_mesh(call, scene, id));
    TRY(check_pointer(call, "params", params));
    const struct scene_mesh *mesh = &scene->meshes.data[id.index];
    TRY(check_index(call, "primitive", primitive, mesh->primitive_count, "primitives"));
    for (uint32_t i = 0; i < scene->painted.count; i++)
        if (scene->painted.data[i].own_mesh == id.index)
            return misuse(call, "mesh (index %u) is a copy that baked decals are painted on, change the mesh itself (index %u)",
                          id.index, scene->painted.data[i].mesh);
    struct scene_primitive *old = &scene->primitives.data[mesh->first_primitive + primitive], made;
    TRY(check_mesh(call, scene, params, corner_count(old->topology)));
    TRY(check_kept(call, old, params));

    struct arena memory;
    arena_init(&memory, &scene->host, 4096);
    fnl_result result = make_primitive(scene, &memory, params, old->topology, &made);
    if (result != FNL_OK) {
        arena_finish(&memory);
        return result;
    }
    bool other_material = old->material != made.material, other_shape = !equal_shapes(old, &made);
    bool other_vertices = other_shape || !equal_attributes(old, &made);
    old->material = made.material;
    if (other_vertices) {
        take_arrays(old, &made);
        struct arena before = old->memory;
        old->memory = memory;
        memory = before;
        old->version++;
        old->shape_version += other_shape;
        update_bounds(scene, id.index, old);
    }
    if (other_vertices || other_material) {
        scene_structure_changed(scene);
        result = update_painted(scene, id.index, primitive, other_material);
    }
    arena_finish(&memory); /* what is not used, or no longer */
    return result;
}

/* What it shows in a variant of its file; FNL_NO_VARIANT: in none. */
static uint32_t material_in(const struct scene_primitive *p, uint32_t variant) {
    for (uint32_t i = 0; i < p->mapping_count; i++)
        if (p->mappings[i].variant == variant) return p->mappings[i].material;
    return p->standard_material;
}

fnl_result fnl_scene_select_variant(fnl_scene *scene, uint32_t variant) {
    TRY(check_handle(__func__, "scene", scene));
    const bool all = variant == FNL_NO_VARIANT;
    if (!all) TRY(check_index(CALL(&scene->host), "variant", variant, scene_entity_count(scene, FNL_ENTITY_VARIANT), "variants"));
    if (!all) variant = scene_entity_slot(scene, FNL_ENTITY_VARIANT, variant);
    fnl_result result = FNL_OK;
    bool changed = false;
    for (uint32_t m = 0; m < scene->meshes.count; m++)
        for (uint32_t i = 0; i < scene->meshes.data[m].primitive_count; i++) {
            struct scene_primitive *p = &scene->primitives.data[scene->meshes.data[m].first_primitive + i];
            if (!p->mapping_count) continue;
            if (!all && scene->variants.data[p->mappings[0].variant].first != scene->variants.data[variant].first) continue;
            const uint32_t material = material_in(p, variant);
            if (p->material == material) continue;
            p->material = material;
            changed = true;
            const fnl_result painted = update_painted(scene, m, i, true);
            if (result == FNL_OK) result = painted;
        }
    if (changed) scene_structure_changed(scene);
    return result;
}

fnl_result fnl_scene_query_mesh(const fnl_scene *scene, uint32_t index, uint32_t primitive, fnl_mesh_info *out) {
    TRY(check_handle(__func__, "scene", scene));
    const struct call *call = CALL(&scene->host);
    TRY(check_pointer(call, "out", out));
    TRY(check_index(call, "index", index, scene_entity_count(scene, FNL_ENTITY_MESH), "meshes"));
    const struct scene_mesh *mesh = &scene->meshes.data[scene_entity_slot(scene, FNL_ENTITY_MESH, index)];
    TRY(check_index(call, "primitive", primitive, mesh->primitive_count, "primitives"));
    const struct scene_primitive *p = &scene->primitives.data[mesh->first_primitive + primitive];
    *out = (fnl_mesh_info){
        .primitive_count = mesh->primitive_count,
        .corner_count = corner_count(p->topology),
        .morph_target_count = mesh->morph_target_count,
        .bounds_low = mesh->bounds.low,
        .bounds_high = mesh->bounds.high,
        .params = {.vertex_count = p->vertex_count,
                   .index_count = p->index_count,
                   .positions = &p->positions->x,
                   .normals = p->normals ? &p->normals->x : NULL,
                   .tangents = p->tangents ? &p->tangents->x : NULL,
                   .uv = p->uv[0] ? &p->uv[0]->x : NULL,
                   .colors = p->colors ? &p->colors->x : NULL,
                   .indices = p->indices,
                   .material = scene_material_id(scene, p->material)}};
    return FNL_OK;
}
