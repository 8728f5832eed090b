/* SPDX-License-Identifier: MIT */
/* From the scene to triangles that Embree knows. */
#include "ray/ray_internal.h"

fnl_result ray_scene_check(const struct ray_scene *s) {
    enum RTCError error = rtcGetDeviceError(s->device);
    if (error == RTC_ERROR_NONE) return FNL_OK;
    log_error(&s->scene->host, "%s: Embree cannot take the scene: %s", s->scene->source,
              error == RTC_ERROR_OUT_OF_MEMORY     ? "memory ran out"
              : error == RTC_ERROR_UNSUPPORTED_CPU ? "it does not run on this processor"
                                                   : "an error of its own");
    return error == RTC_ERROR_OUT_OF_MEMORY ? FNL_ERROR_MEMORY : FNL_ERROR_UNSUPPORTED;
}

/* Morph targets, then joints, as glTF 2.0 says; NULL arrays stay so. */
static void pose_vertex(const struct scene_primitive *p, const float *weights, const mat4 *joints, uint32_t i,
                        vec3 *position, vec3 *normal, vec4 *tangent) {
    dvec3 at = dvec3_from(p->positions[i]), n = {0, 0, 0}, t = {0, 0, 0};
    if (p->normals) n = dvec3_from(p->normals[i]);
    if (p->tangents) t = dvec3_make((double)p->tangents[i].x, (double)p->tangents[i].y, (double)p->tangents[i].z);
    double hand = p->tangents ? (double)p->tangents[i].w : 1;
    for (uint32_t k = 0; k < p->morph_target_count; k++) {
        const struct scene_morph_target *target = &p->morph_targets[k];
        double weight = weights ? (double)weights[k] : 0;
        if (weight == 0) continue;
        if (target->positions) at = dvec3_add_scaled(at, dvec3_from(target->positions[i]), weight);
        if (target->normals) n = dvec3_add_scaled(n, dvec3_from(target->normals[i]), weight);
        if (target->tangents) t = dvec3_add_scaled(t, dvec3_from(target->tangents[i]), weight);
    }
    if (joints && p->joint_count) {
        double m[12] = {0};
        for (uint32_t k = 0; k < p->joint_count; k++) {
            double weight = (double)p->weights[(size_t)i * p->joint_count + k];
            const float *joint = joints[p->joints[(size_t)i * p->joint_count + k]].m;
            for (int c = 0; weight != 0 && c < 12; c++) m[c] += weight * (double)joint[c / 3 * 4 + c % 3];
        }
        const dvec3 x = {m[0], m[1], m[2]}, y = {m[3], m[4], m[5]}, z = {m[6], m[7], m[8]}, origin = {m[9], m[10], m[11]};
        at = dvec3_add(dvec3_combine(x, y, z, at), origin);
        double mirror = dvec3_dot(x, dvec3_cross(y, z)) < 0 ? -1 : 1;
        n = dvec3_scale(dvec3_combine(dvec3_cross(y, z), dvec3_cross(z, x), dvec3_cross(x, y), n), mirror);
        t = dvec3_combine(x, y, z, t);
        hand *= mirror;
    }
    n = dvec3_normalize(n);
    t = dvec3_normalize(t);
    *position = (vec3){(float)at.x, (float)at.y, (float)at.z};
    if (p->normals) *normal = (vec3){(float)n.x, (float)n.y, (float)n.z};
    if (p->tangents) *tangent = (vec4){(float)t.x, (float)t.y, (float)t.z, (float)hand};
}

/* What a node does to the vertices of its mesh. */
struct pose {
    const mat4 *joints; /* or NULL */
    const mat4 *flat;   /* or NULL: a transform into whose space no ray can be brought */
};

static void flatten_vertex(const mat4 *m, vec3 *position, vec3 *normal, vec4 *tangent) {
    const vec3 x = {m->m[0], m->m[1], m->m[2]}, y = {m->m[4], m->m[5], m->m[6]}, z = {m->m[8], m->m[9], m->m[10]},
               n = *normal;
    const vec3 t = vec3_normalize(mat4_direction(m, vec3_make(tangent->x, tangent->y, tangent->z)));
    *position = mat4_point(m, *position);
    *normal = vec3_scale(vec3_cross(y, z), n.x);
    *normal = vec3_add_scaled(*normal, vec3_cross(z, x), n.y);
    *normal = vec3_normalize(vec3_add_scaled(*normal, vec3_cross(x, y), n.z));
    *tangent = (vec4){t.x, t.y, t.z, tangent->w};
}

static fnl_result pose_part(struct ray_scene *s, const struct scene_node *node, const struct pose *pose,
                            struct ray_part *part) {
    const struct scene_primitive *p = part->primitive;
    const size_t count = p->vertex_count;
    part->posed_size = count * (sizeof(vec3) * 2 + sizeof(vec4));
    vec4 *tangents = part->posed = host_allocate(&s->scene->host, part->posed_size);
    if (!tangents) return FNL_ERROR_MEMORY;
    vec3 *positions = (vec3 *)(tangents + count), *normals = positions + count;
    const float *weights = node->morph_weights ? node->morph_weights : s->scene->meshes.data[node->mesh].morph_weights;
    memset(tangents, 0, part->posed_size);
    for (uint32_t i = 0; i < count; i++) {
        pose_vertex(p, weights, pose->joints, i, &positions[i], &normals[i], &tangents[i]);
        if (pose->flat) flatten_vertex(pose->flat, &positions[i], &normals[i], &tangents[i]);
    }
    part->positions = positions;
    if (p->normals) part->normals = normals;
    if (p->tangents) part->tangents = tangents;
    return FNL_OK;
}

/* The part's geometry; Embree wants readable bytes behind the last vertex, so it gets copies. */
static fnl_result attach_part(struct ray_scene *s, struct ray_mesh *mesh, struct ray_part *part) {
    const struct scene_primitive *p = part->primitive;
    const size_t triangles = p->index_count / 3;
    RTCGeometry geometry = rtcNewGeometry(s->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    void *vertices =
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(vec3), p->vertex_count);
    void *indices =
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(uint32_t), triangles);
    if (vertices && indices) {
        memcpy(vertices, part->positions, p->vertex_count * sizeof(vec3));
        memcpy(indices, p->indices, triangles * 3 * sizeof(uint32_t));
        rtcSetGeometryUserData(geometry, part);
        if (s->masks_views || part->material->alpha_mode != FNL_ALPHA_OPAQUE || !part->material->double_sided)
            rtcSetGeometryIntersectFilterFunction(geometry, ray_filter_nearest);
        if (part->material->alpha_mode != FNL_ALPHA_OPAQUE || scene_material_transmissive(part->material) || !part->material->casts_shadows)
            rtcSetGeometryOccludedFilterFunction(geometry, ray_filter_shadow);
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(mesh->handle, geometry, part->index - mesh->first_part);
    }
    rtcReleaseGeometry(geometry);
    return vertices && indices ? FNL_OK : ray_scene_check(s);
}

static bool is_solid(const struct scene_primitive *p) {
    return p->topology == SCENE_TOPOLOGY_TRIANGLES && p->index_count >= 3;
}

/* `pose` NULL: as it is, for all nodes that do not deform it. */
static fnl_result add_mesh(struct ray_scene *s, const struct scene_node *node, const struct pose *pose, uint32_t *out) {
    const fnl_scene *scene = s->scene;
    const struct scene_mesh *source = &scene->meshes.data[node->mesh];
    struct ray_mesh mesh = {.first_part = s->parts.count};
    for (uint32_t i = 0; i < source->primitive_count; i++) {
        const struct scene_primitive *p = &scene->primitives.data[source->first_primitive + i];
        if (!is_solid(p)) {
            s->unseen += p->topology != SCENE_TOPOLOGY_TRIANGLES;
            continue;
        }
        struct ray_part part = {.primitive = p,
                                .material = p->material == SCENE_NONE ? &s->standard : &scene->materials.data[p->material],
                                .positions = p->positions,
                                .normals = p->normals,
                                .tangents = p->tangents,
                                .scene = s,
                                .index = s->parts.count};
        if (pose) TRY(pose_part(s, node, pose, &part));
        s->parts.data[s->parts.count++] = part; /* reserved: filters point to it */
        mesh.part_count++;
    }
    mesh.handle = rtcNewScene(s->device);
    *out = s->meshes.count;
    if (!mesh.handle) return ray_scene_check(s);
    rtcSetSceneFlags(mesh.handle, RTC_SCENE_FLAG_ROBUST); /* no cracks between triangles */
    s->meshes.data[s->meshes.count++] = mesh;
    for (uint32_t i = 0; i < mesh.part_count; i++) TRY(attach_part(s, &mesh, &s->parts.data[mesh.first_part + i]));
    rtcCommitScene(mesh.handle);
    return ray_scene_check(s);
}

static struct ray_instance instance_make(uint32_t mesh, const mat4 *m) {
    struct ray_instance in = {.mesh = mesh, .matrix = *m, .first_glow = SCENE_NONE};
    for (int c = 0; c < 3; c++)
        in.axes[c] = dvec3_make((double)m->m[4 * c], (double)m->m[4 * c + 1], (double)m->m[4 * c + 2]);
    in.origin = dvec3_make((double)m->m[12], (double)m->m[13], (double)m->m[14]);
    for (int c = 0; c < 3; c++) in.cofactors[c] = dvec3_cross(in.axes[(c + 1) % 3], in.axes[(c + 2) % 3]);
    in.mirror = dvec3_dot(in.axes[0], in.cofactors[0]) < 0 ? -1 : 1;
    for (int c = 0; c < 3; c++) in.cofactors[c] = dvec3_scale(in.cofactors[c], in.mirror);
    return in;
}

static fnl_result attach_instance(struct ray_scene *s, const struct ray_instance *in) {
    RTCGeometry geometry = rtcNewGeometry(s->device, RTC_GEOMETRY_TYPE_INSTANCE);
    if (!geometry) return ray_scene_check(s);
    rtcSetGeometryInstancedScene(geometry, s->meshes.data[in->mesh].handle);
    rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, in->matrix.m);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(s->handle, geometry, s->instances.count);
    rtcReleaseGeometry(geometry);
    return array_push(&s->scene->host, &s->instances, *in) ? FNL_OK : FNL_ERROR_MEMORY;
}

static bool node_draws(const struct scene_node *node) { return scene_node_draws(node); }

static bool mesh_deforms(const fnl_scene *scene, const struct scene_node *node) {
    const struct scene_mesh *mesh = &scene->meshes.data[node->mesh];
    bool deforms = false;
    for (uint32_t i = 0; i < mesh->primitive_count; i++) {
        const struct scene_primitive *p = &scene->primitives.data[mesh->first_primitive + i];
        deforms = deforms || (node->skin != SCENE_NONE && p->joint_count > 0) || p->morph_target_count > 0;
    }
    return deforms;
}

static mat4 node_matrix(const fnl_scene *scene, const struct scene_node *node, uint32_t k) {
    if (node->skin != SCENE_NONE) return skin_instance(skin_mirrors(scene, node)); /* the joints carry it (glTF 2.0, 3.7.3.1) */
    return scene_instance_world(scene, node, k);
}

/* No ray can be brought into its space, or not with floats: there products of lengths are beyond them. */
static bool is_flat(const struct ray_instance *in) {
    const double x = dvec3_length(in->axes[0]), y = dvec3_length(in->axes[1]), z = dvec3_length(in->axes[2]);
    return fabs(dvec3_dot(in->axes[0], in->cofactors[0])) <= 1e-9 * x * y * z || fmax(x, fmax(y, z)) > 1e9 || fmin(x, fmin(y, z)) < 1e-9;
}

static bool is_finite(const mat4 *m) {
    for (int i = 0; i < 16; i++)
        if (!isfinite(m->m[i])) return false;
    return true;
}

static fnl_result add_posed(struct ray_scene *s, const struct scene_node *node, uint32_t *out) {
    const fnl_scene *scene = s->scene;
    const struct scene_skin *skin = node->skin == SCENE_NONE ? NULL : &scene->skins.data[node->skin];
    size_t size = skin ? skin->joint_count * sizeof(mat4) : 0;
    mat4 *joints = host_allocate(&scene->host, size);
    if (size && !joints) return FNL_ERROR_MEMORY;
    if (skin) skin_instance_matrices(scene, node->skin, skin_mirrors(scene, node), joints);
    fnl_result result = add_mesh(s, node, &(struct pose){.joints = joints}, out);
    host_free(&scene->host, joints, size);
    return result;
}

static fnl_result add_node(struct ray_scene *s, const struct scene_node *node, uint32_t *shared) {
    const bool deforms = mesh_deforms(s->scene, node);
    uint32_t mesh = SCENE_NONE; /* until an instance needs it */
    for (uint32_t k = 0; k < node->instance_count; k++) {
        mat4 matrix = node_matrix(s->scene, node, k);
        struct ray_instance in = instance_make(SCENE_NONE, &matrix);
        if (!is_finite(&matrix)) continue; /* it is nowhere */
        if (is_flat(&in)) {
            uint32_t flat;
            const mat4 instance = skin_instance(in.mirror < 0), posed = mat4_mul(instance, matrix);
            TRY(add_mesh(s, node, &(struct pose){.flat = &posed}, &flat));
            in = instance_make(flat, &instance);
        } else {
            if (mesh == SCENE_NONE && !deforms) mesh = shared[node->mesh];
            if (mesh == SCENE_NONE) TRY(deforms ? add_posed(s, node, &mesh) : add_mesh(s, node, NULL, &mesh));
            if (!deforms) shared[node->mesh] = mesh;
            in.mesh = mesh;
        }
        in.light_mask = 255u & ~node->unlit;
        in.view_mask = 255u & ~node->unseen;
        if (s->meshes.data[in.mesh].part_count) TRY(attach_instance(s, &in));
    }
    return FNL_OK;
}

/* Meshes that a node has for itself. */
static uint64_t own_meshes(const fnl_scene *scene, const struct scene_node *node) {
    uint64_t count = mesh_deforms(scene, node);
    for (uint32_t k = 0; k < node->instance_count; k++) {
        const mat4 matrix = node_matrix(scene, node, k);
        const struct ray_instance in = instance_make(SCENE_NONE, &matrix);
        count += is_finite(&matrix) && is_flat(&in);
    }
    return count;
}

static fnl_result add_nodes(struct ray_scene *s) {
    const fnl_scene *scene = s->scene;
    const fnl_host *host = &scene->host;
    uint64_t parts = scene->primitives.count, meshes = scene->meshes.count;
    for (uint32_t n = 0; n < scene->nodes.count; n++) {
        const struct scene_node *node = &scene->nodes.data[n];
        const uint64_t own = node_draws(node) ? own_meshes(scene, node) : 0;
        parts += own ? own * scene->meshes.data[node->mesh].primitive_count : 0;
        meshes += own;
    }
    if (!array_reserve(host, &s->parts, MAX(parts, 1u)) || !array_reserve(host, &s->meshes, MAX(meshes, 1u)))
        return FNL_ERROR_MEMORY;
    size_t size = MAX(scene->meshes.count, 1u) * sizeof(uint32_t);
    uint32_t *shared = host_allocate(host, size);
    if (!shared) return FNL_ERROR_MEMORY;
    memset(shared, 0xff, size);
    fnl_result result = FNL_OK;
    for (uint32_t n = 0; n < scene->nodes.count && result == FNL_OK; n++)
        if (node_draws(&scene->nodes.data[n])) result = add_node(s, &scene->nodes.data[n], shared);
    host_free(host, shared, size);
    return result;
}

fnl_result ray_scene_build(struct ray_scene *s, struct jobs *jobs) {
    for (uint32_t i = 0; i < s->scene->nodes.count; i++) s->masks_views |= s->scene->nodes.data[i].unseen != 0;
    TRY(ray_images_create(s->scene, jobs, &s->images));
    /* One thread builds: trees, and with them the order of equal hits, must not depend on how many there are. */
    s->device = rtcNewDevice("threads=1");
    if (!s->device) return ray_scene_check(s);
    s->handle = rtcNewScene(s->device);
    if (!s->handle) return ray_scene_check(s);
    rtcSetSceneFlags(s->handle, RTC_SCENE_FLAG_ROBUST);
    TRY(add_nodes(s));
    rtcCommitScene(s->handle);
    TRY(ray_scene_check(s));
    for (uint32_t i = 0; i < s->scene->decals.count; i++)
        s->unseen +=
            s->scene->decals.data[i].params.kind != FNL_DECAL_BAKED && decal_shows(s->scene, &s->scene->decals.data[i]);
    return FNL_OK;
}
