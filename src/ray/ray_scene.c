/* SPDX-License-Identifier: MIT */
#include "ray/ray_scene.h"

#include "ray/embree.h"

/* A primitive as it is posed: shared by all nodes that do not deform it. */
struct part {
    const struct scene_primitive *primitive;
    const struct scene_material *material;
    const vec3 *positions, *normals; /* the primitive's, or `posed` */
    const vec4 *tangents;
    void *posed; /* owned; or NULL */
    size_t posed_size;
    struct ray_scene *scene;
    uint32_t index; /* of itself */
};

/* Parts under one transform; a scene of Embree's. */
struct mesh {
    RTCScene handle;
    uint32_t first_part, part_count;
};

struct instance {
    uint32_t mesh;
    mat4 matrix;
    dvec3 axes[3], origin;   /* columns of the matrix */
    dvec3 cofactors[3];      /* columns that carry normals */
    double mirror;           /* -1 where it mirrors */
};

struct ray_scene {
    const fnl_scene *scene;
    RTCDevice device;
    RTCScene handle;
    struct ray_image *images;
    struct scene_material standard;
    ARRAY(struct part) parts;
    ARRAY(struct mesh) meshes;
    ARRAY(struct instance) instances;
    ARRAY(struct ray_light) lights;
    double reach; /* greatest coordinate of the bounds */
    uint32_t unseen;
};

/* ---- what a ray is asked ---- */

struct query {
    embree_query embree; /* first: filters get it */
    enum ray_kind kind;
    const struct ray_neighbours *neighbours; /* or NULL */
    struct ray_walk *walk;
    double visibility;
};

static void interpolate_uv(const struct part *part, uint32_t triangle, double u, double v, double out[2][2]) {
    const struct scene_primitive *p = part->primitive;
    const uint32_t *c = p->indices + 3 * (size_t)triangle;
    for (int set = 0; set < 2; set++) {
        out[set][0] = out[set][1] = 0;
        if (!p->uv[set]) continue;
        const vec2 *uv = p->uv[set];
        out[set][0] = (double)uv[c[0]].x * (1 - u - v) + (double)uv[c[1]].x * u + (double)uv[c[2]].x * v;
        out[set][1] = (double)uv[c[0]].y * (1 - u - v) + (double)uv[c[1]].y * u + (double)uv[c[2]].y * v;
    }
}

static dvec3 carry(const dvec3 columns[3], dvec3 v) { return dvec3_combine(columns[0], columns[1], columns[2], v); }

/* Where a ray meets the plane of a triangle, as weights of corners 1 and 2 (Möller & Trumbore 1997); false where it is seen edge-on. */
static bool meet(const dvec3 p[3], dvec3 origin, dvec3 direction, double *u, double *v) {
    dvec3 e1 = dvec3_sub(p[1], p[0]), e2 = dvec3_sub(p[2], p[0]), h = dvec3_cross(direction, e2);
    double determinant = dvec3_dot(e1, h);
    if (determinant == 0) return false;
    dvec3 from = dvec3_sub(origin, p[0]), q = dvec3_cross(from, e1);
    *u = dvec3_dot(from, h) / determinant;
    *v = dvec3_dot(direction, q) / determinant;
    return isfinite(*u) && isfinite(*v);
}

static void find_corners(const struct part *part, const struct instance *in, uint32_t triangle, dvec3 out[3]) {
    const uint32_t *corners = part->primitive->indices + 3 * (size_t)triangle;
    for (int k = 0; k < 3; k++) out[k] = dvec3_add(carry(in->axes, dvec3_from(part->positions[corners[k]])), in->origin);
}

/* How texture coordinates change to the neighbours of a pixel. */
static void find_footprint(const struct part *part, uint32_t triangle, const dvec3 corners[3], const struct ray_neighbours *neighbours,
                           struct ray_uv *uv) {
    double(*const steps[2])[2] = {uv->along, uv->across};
    for (int k = 0; k < 2; k++) {
        double u, v;
        if (!meet(corners, neighbours->origin[k], neighbours->direction[k], &u, &v)) continue;
        interpolate_uv(part, triangle, u, v, steps[k]);
        for (int i = 0; i < 4; i++) steps[k][i / 2][i % 2] -= uv->at[i / 2][i % 2];
    }
}

static void vertex_color(const struct part *part, uint32_t triangle, double u, double v, double out[4]) {
    const struct scene_primitive *p = part->primitive;
    const uint32_t *c = p->indices + 3 * (size_t)triangle;
    for (int i = 0; i < 4; i++) out[i] = 1;
    if (!p->colors) return;
    const double weights[3] = {1 - u - v, u, v};
    for (int i = 0; i < 4; i++) out[i] = 0;
    for (int k = 0; k < 3; k++) {
        const float *color = &p->colors[c[k]].x;
        for (int i = 0; i < 4; i++) out[i] += weights[k] * clamp01((double)color[i]);
    }
}

/* What of the triangle covers the point: 0 in the holes of cutouts, less than 1 where it blends. */
static double coverage(const struct part *part, uint32_t triangle, double u, double v, const struct instance *in,
                       const struct ray_neighbours *neighbours) {
    const struct scene_material *m = part->material;
    if (m->alpha_mode == FNL_ALPHA_OPAQUE) return 1;
    struct ray_uv uv = {0};
    double texel[4], color[4];
    interpolate_uv(part, triangle, u, v, uv.at);
    if (neighbours) {
        dvec3 corners[3];
        find_corners(part, in, triangle, corners);
        find_footprint(part, triangle, corners, neighbours, &uv);
    }
    ray_texture_sample(part->scene->scene, part->scene->images, m, SCENE_TEXTURE_BASE_COLOR, &uv, texel);
    vertex_color(part, triangle, u, v, color);
    double alpha = (double)m->base_color.w * color[3] * texel[3];
    return m->alpha_mode == FNL_ALPHA_BLEND ? clamp01(alpha) : alpha < (double)m->alpha_cutoff ? 0 : 1;
}

/* Rays are asked for one by one: what filters get has the layout of one. */
static const struct RTCRay *filter_ray(const struct RTCFilterFunctionNArguments *arguments) {
    return (const struct RTCRay *)(const void *)arguments->ray;
}
static const struct RTCHit *filter_hit(const struct RTCFilterFunctionNArguments *arguments) {
    return (const struct RTCHit *)(const void *)arguments->hit;
}

/* A chance in 0..1 that does not depend on the order in which surfaces are found. */
static double chance_of(uint64_t key, uint32_t instance, uint32_t part, uint32_t triangle) {
    struct random_state random = {key ^ (uint64_t)triangle * 0x9e3779b97f4a7c15ull ^ ((uint64_t)instance << 32 | part) * 0xd1b54a32d192ed03ull};
    return (double)random_float(&random);
}

static struct ray_hit hit_of(const struct part *part, const struct RTCRay *ray, const struct RTCHit *hit) {
    return (struct ray_hit){.instance = hit->instID[0],
                            .part = part->index,
                            .triangle = hit->primID,
                            .u = (double)hit->u,
                            .v = (double)hit->v,
                            .distance = (double)ray->tfar,
                            .front = ray->dir_x * hit->Ng_x + ray->dir_y * hit->Ng_y + ray->dir_z * hit->Ng_z < 0};
}

static bool is_on_edge(const struct ray_hit *hit) { return fmin(fmin(hit->u, hit->v), 1 - hit->u - hit->v) < 1e-5; }

/* A ray through the edge that two triangles share meets both, and no crack: for what is passed they count as one. */
static bool is_same_crossing(const struct ray_hit *a, const struct ray_hit *b) {
    return a->part == b->part && a->instance == b->instance && fabs(a->distance - b->distance) <= 1e-5 * a->distance && is_on_edge(a) &&
           is_on_edge(b);
}

static void filter_nearest(const struct RTCFilterFunctionNArguments *arguments) {
    const struct part *part = arguments->geometryUserPtr;
    const struct query *query = (const struct query *)(const void *)arguments->context;
    const struct scene_material *m = part->material;
    const struct ray_hit hit = hit_of(part, filter_ray(arguments), filter_hit(arguments)); /* in the space of the instance */
    if (query->kind == RAY_CAMERA && !hit.front && !m->double_sided) {
        arguments->valid[0] = 0;
        return;
    }
    if (m->alpha_mode == FNL_ALPHA_OPAQUE) return;
    double cover = query->kind == RAY_CAMERA && m->alpha_mode == FNL_ALPHA_BLEND ? 0 : coverage(part, hit.triangle, hit.u, hit.v, &part->scene->instances.data[hit.instance], query->neighbours);
    if (m->alpha_mode == FNL_ALPHA_BLEND) {
        struct ray_walk *walk = query->walk;
        if (query->kind == RAY_CAMERA && !array_push(&part->scene->scene->host, &walk->layers, hit)) walk->failed = true;
        if (query->kind == RAY_PATH && chance_of(walk->key, hit.instance, hit.part, hit.triangle) < cover) return;
        cover = 0;
    }
    if (cover == 0) arguments->valid[0] = 0;
}

static void filter_shadow(const struct RTCFilterFunctionNArguments *arguments) {
    const struct part *part = arguments->geometryUserPtr;
    struct query *query = (struct query *)(void *)arguments->context;
    const struct ray_hit hit = hit_of(part, filter_ray(arguments), filter_hit(arguments));
    struct ray_walk *walk = query->walk;
    double cover = coverage(part, hit.triangle, hit.u, hit.v, NULL, NULL);
    for (uint32_t i = 0; i < walk->crossed.count && cover < 1; i++)
        if (is_same_crossing(&hit, &walk->crossed.data[i])) cover = 0;
    query->visibility *= 1 - cover;
    if (query->visibility == 0) return;
    arguments->valid[0] = 0;
    if (cover > 0 && is_on_edge(&hit) && !array_push(&part->scene->scene->host, &walk->crossed, hit)) walk->failed = true;
}

/* ---- building ---- */

static fnl_result check_device(const struct ray_scene *s) {
    enum RTCError error = rtcGetDeviceError(s->device);
    if (error == RTC_ERROR_NONE) return FNL_OK;
    log_error(&s->scene->host, "%s: Embree cannot take the scene: %s", s->scene->source,
              error == RTC_ERROR_OUT_OF_MEMORY ? "memory ran out" : error == RTC_ERROR_UNSUPPORTED_CPU ? "it does not run on this processor" : "an error of its own");
    return error == RTC_ERROR_OUT_OF_MEMORY ? FNL_ERROR_MEMORY : FNL_ERROR_UNSUPPORTED;
}

/* Morph targets, then joints, as glTF 2.0 says; NULL arrays stay so. */
static void pose_vertex(const struct scene_primitive *p, const float *weights, const mat4 *joints, uint32_t i, vec3 *position,
                        vec3 *normal, vec4 *tangent) {
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

static fnl_result pose_part(struct ray_scene *s, const struct scene_node *node, const mat4 *joints, struct part *part) {
    const struct scene_primitive *p = part->primitive;
    const size_t count = p->vertex_count;
    part->posed_size = count * (sizeof(vec3) * 2 + sizeof(vec4));
    vec4 *tangents = part->posed = host_allocate(&s->scene->host, part->posed_size);
    if (!tangents) return FNL_ERROR_MEMORY;
    vec3 *positions = (vec3 *)(tangents + count), *normals = positions + count;
    const float *weights = node->morph_weights ? node->morph_weights : s->scene->meshes.data[node->mesh].morph_weights;
    for (uint32_t i = 0; i < count; i++) pose_vertex(p, weights, joints, i, &positions[i], &normals[i], &tangents[i]);
    part->positions = positions;
    if (p->normals) part->normals = normals;
    if (p->tangents) part->tangents = tangents;
    return FNL_OK;
}

/* The part's geometry; Embree wants readable bytes behind the last vertex, so it gets copies. */
static fnl_result attach_part(struct ray_scene *s, struct mesh *mesh, struct part *part) {
    const struct scene_primitive *p = part->primitive;
    const size_t triangles = p->index_count / 3;
    RTCGeometry geometry = rtcNewGeometry(s->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    void *vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(vec3), p->vertex_count);
    void *indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(uint32_t), triangles);
    if (vertices && indices) {
        memcpy(vertices, part->positions, p->vertex_count * sizeof(vec3));
        memcpy(indices, p->indices, triangles * 3 * sizeof(uint32_t));
        rtcSetGeometryUserData(geometry, part);
        if (part->material->alpha_mode != FNL_ALPHA_OPAQUE || !part->material->double_sided)
            rtcSetGeometryIntersectFilterFunction(geometry, filter_nearest);
        if (part->material->alpha_mode != FNL_ALPHA_OPAQUE) rtcSetGeometryOccludedFilterFunction(geometry, filter_shadow);
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(mesh->handle, geometry, part->index - mesh->first_part);
    }
    rtcReleaseGeometry(geometry);
    return vertices && indices ? FNL_OK : check_device(s);
}

static bool is_solid(const struct scene_primitive *p) { return p->topology == SCENE_TOPOLOGY_TRIANGLES && p->index_count >= 3; }

static fnl_result add_mesh(struct ray_scene *s, const struct scene_node *node, const mat4 *joints, bool deforms, uint32_t *out) {
    const fnl_scene *scene = s->scene;
    const struct scene_mesh *source = &scene->meshes.data[node->mesh];
    struct mesh mesh = {.first_part = s->parts.count};
    for (uint32_t i = 0; i < source->primitive_count; i++) {
        const struct scene_primitive *p = &scene->primitives.data[source->first_primitive + i];
        if (!is_solid(p)) {
            s->unseen += p->topology != SCENE_TOPOLOGY_TRIANGLES;
            continue;
        }
        struct part part = {.primitive = p,
                            .material = p->material == SCENE_NONE ? &s->standard : &scene->materials.data[p->material],
                            .positions = p->positions,
                            .normals = p->normals,
                            .tangents = p->tangents,
                            .scene = s,
                            .index = s->parts.count};
        if (deforms) TRY(pose_part(s, node, joints, &part));
        s->parts.data[s->parts.count++] = part; /* reserved: filters point to it */
        mesh.part_count++;
    }
    mesh.handle = rtcNewScene(s->device);
    *out = s->meshes.count;
    if (!mesh.handle) return check_device(s);
    rtcSetSceneFlags(mesh.handle, RTC_SCENE_FLAG_ROBUST); /* no cracks between triangles */
    s->meshes.data[s->meshes.count++] = mesh;
    for (uint32_t i = 0; i < mesh.part_count; i++) TRY(attach_part(s, &mesh, &s->parts.data[mesh.first_part + i]));
    rtcCommitScene(mesh.handle);
    return check_device(s);
}

static struct instance instance_make(uint32_t mesh, const mat4 *m) {
    struct instance in = {.mesh = mesh, .matrix = *m};
    for (int c = 0; c < 3; c++) in.axes[c] = dvec3_make((double)m->m[4 * c], (double)m->m[4 * c + 1], (double)m->m[4 * c + 2]);
    in.origin = dvec3_make((double)m->m[12], (double)m->m[13], (double)m->m[14]);
    for (int c = 0; c < 3; c++) in.cofactors[c] = dvec3_cross(in.axes[(c + 1) % 3], in.axes[(c + 2) % 3]);
    in.mirror = dvec3_dot(in.axes[0], in.cofactors[0]) < 0 ? -1 : 1;
    for (int c = 0; c < 3; c++) in.cofactors[c] = dvec3_scale(in.cofactors[c], in.mirror);
    return in;
}

static fnl_result attach_instance(struct ray_scene *s, const struct instance *in) {
    RTCGeometry geometry = rtcNewGeometry(s->device, RTC_GEOMETRY_TYPE_INSTANCE);
    if (!geometry) return check_device(s);
    rtcSetGeometryInstancedScene(geometry, s->meshes.data[in->mesh].handle);
    rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, in->matrix.m);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(s->handle, geometry, s->instances.count);
    rtcReleaseGeometry(geometry);
    return array_push(&s->scene->host, &s->instances, *in) ? FNL_OK : FNL_ERROR_MEMORY;
}

static bool node_draws(const struct scene_node *node) { return node->active && !node->removed && node->mesh != SCENE_NONE; }

static bool mesh_deforms(const fnl_scene *scene, const struct scene_node *node) {
    const struct scene_mesh *mesh = &scene->meshes.data[node->mesh];
    bool deforms = false;
    for (uint32_t i = 0; i < mesh->primitive_count; i++) {
        const struct scene_primitive *p = &scene->primitives.data[mesh->first_primitive + i];
        deforms = deforms || (node->skin != SCENE_NONE && p->joint_count > 0) || p->morph_target_count > 0;
    }
    return deforms;
}

static fnl_result add_node(struct ray_scene *s, const struct scene_node *node, uint32_t *shared) {
    const fnl_scene *scene = s->scene;
    uint32_t mesh = shared[node->mesh];
    const bool deforms = mesh_deforms(scene, node);
    if (deforms || mesh == SCENE_NONE) {
        const struct scene_skin *skin = node->skin == SCENE_NONE ? NULL : &scene->skins.data[node->skin];
        size_t size = skin ? skin->joint_count * sizeof(mat4) : 0;
        mat4 *joints = host_allocate(&scene->host, size);
        if (size && !joints) return FNL_ERROR_MEMORY;
        if (skin) skin_matrices(scene, node->skin, joints);
        fnl_result result = add_mesh(s, node, joints, deforms, &mesh);
        host_free(&scene->host, joints, size);
        TRY(result);
        if (!deforms) shared[node->mesh] = mesh;
    }
    if (s->meshes.data[mesh].part_count == 0) return FNL_OK;
    for (uint32_t k = 0; k < node->instance_count; k++) {
        mat4 matrix = node->skin != SCENE_NONE ? mat4_identity() /* the joints carry it (glTF 2.0, 3.7.3.1) */
                      : node->instances        ? mat4_mul(node->world, node->instances[k])
                                               : node->world;
        struct instance in = instance_make(mesh, &matrix);
        if (dvec3_dot(in.axes[0], in.cofactors[0]) == 0) continue; /* flat: it has no inside that a ray could be brought to */
        TRY(attach_instance(s, &in));
    }
    return FNL_OK;
}

static fnl_result add_lights(struct ray_scene *s) {
    const fnl_scene *scene = s->scene;
    for (uint32_t i = 0; i < scene->lights.count; i++) {
        const struct scene_light *light = &scene->lights.data[i];
        if (light->removed || (light->node != SCENE_NONE && !scene->nodes.data[light->node].active)) continue;
        double range = (double)fnl_light_range(&light->params, scene->cutoff_roughness, scene->cutoff_illuminance);
        struct ray_light made = ray_light_make(&light->params, range, light->hull);
        if (dvec3_max(made.color) > 0 && !array_push(&scene->host, &s->lights, made)) return FNL_ERROR_MEMORY;
    }
    return FNL_OK;
}

static fnl_result add_nodes(struct ray_scene *s) {
    const fnl_scene *scene = s->scene;
    const fnl_host *host = &scene->host;
    uint64_t parts = scene->primitives.count, meshes = scene->meshes.count;
    for (uint32_t n = 0; n < scene->nodes.count; n++) {
        const struct scene_node *node = &scene->nodes.data[n];
        if (!node_draws(node) || !mesh_deforms(scene, node)) continue;
        parts += scene->meshes.data[node->mesh].primitive_count;
        meshes++;
    }
    if (!array_reserve(host, &s->parts, MAX(parts, 1u)) || !array_reserve(host, &s->meshes, MAX(meshes, 1u))) return FNL_ERROR_MEMORY;
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

static fnl_result build(struct ray_scene *s, struct jobs *jobs) {
    struct RTCBounds bounds;
    TRY(ray_images_create(s->scene, jobs, &s->images));
    /* One thread builds: trees, and with them the order of equal hits, must not depend on how many there are. */
    s->device = rtcNewDevice("threads=1");
    if (!s->device) return check_device(s);
    s->handle = rtcNewScene(s->device);
    if (!s->handle) return check_device(s);
    rtcSetSceneFlags(s->handle, RTC_SCENE_FLAG_ROBUST);
    TRY(add_nodes(s));
    rtcCommitScene(s->handle);
    TRY(check_device(s));
    rtcGetSceneBounds(s->handle, &bounds);
    const dvec3 low = {(double)bounds.lower_x, (double)bounds.lower_y, (double)bounds.lower_z},
                high = {(double)bounds.upper_x, (double)bounds.upper_y, (double)bounds.upper_z};
    s->reach = low.x <= high.x ? fmax(dvec3_reach(low), dvec3_reach(high)) : 0;
    for (uint32_t i = 0; i < s->scene->decals.count; i++)
        s->unseen += s->scene->decals.data[i].params.kind != FNL_DECAL_BAKED && decal_shows(s->scene, &s->scene->decals.data[i]);
    return add_lights(s);
}

fnl_result ray_scene_create(const fnl_scene *scene, struct jobs *jobs, struct ray_scene **out) {
    struct ray_scene *s = *out = host_allocate_zero(&scene->host, sizeof *s);
    if (!s) return FNL_ERROR_MEMORY;
    s->scene = scene;
    s->standard = scene_material_default();
    fnl_result result = build(s, jobs);
    if (result != FNL_OK) ray_scene_destroy(out);
    return result;
}

void ray_scene_destroy(struct ray_scene **handle) {
    struct ray_scene *s = *handle;
    if (!s) return;
    const fnl_host *host = &s->scene->host;
    if (s->handle) rtcReleaseScene(s->handle);
    for (uint32_t i = 0; i < s->meshes.count; i++) rtcReleaseScene(s->meshes.data[i].handle);
    if (s->device) rtcReleaseDevice(s->device);
    for (uint32_t i = 0; i < s->parts.count; i++) host_free(host, s->parts.data[i].posed, s->parts.data[i].posed_size);
    ray_images_destroy(s->scene, &s->images);
    array_free(host, &s->parts);
    array_free(host, &s->meshes);
    array_free(host, &s->instances);
    array_free(host, &s->lights);
    host_free(host, s, sizeof *s);
    *handle = NULL;
}

const struct ray_light *ray_scene_lights(const struct ray_scene *s, uint32_t *count) {
    *count = s->lights.count;
    return s->lights.data;
}

const fnl_host *ray_scene_host(const struct ray_scene *s) { return &s->scene->host; }

void ray_scene_surroundings(const struct ray_scene *s, dvec3 *sky, dvec3 *ground, dvec3 *background) {
    *sky = dvec3_from(s->scene->ambient_sky);
    *ground = dvec3_from(s->scene->ambient_ground);
    *background = dvec3_from(s->scene->background);
}

uint32_t ray_scene_unseen(const struct ray_scene *s) { return s->unseen; }

/* ---- asking ---- */

static struct RTCRay embree_ray(dvec3 origin, dvec3 direction, double low, double high) {
    return (struct RTCRay){.org_x = (float)origin.x,
                           .org_y = (float)origin.y,
                           .org_z = (float)origin.z,
                           .tnear = (float)low,
                           .dir_x = (float)direction.x,
                           .dir_y = (float)direction.y,
                           .dir_z = (float)direction.z,
                           .tfar = high < (double)FLT_MAX ? (float)high : INFINITY,
                           .mask = UINT32_MAX};
}

static int compare_layers(const void *a, const void *b) {
    const struct ray_hit *x = a, *y = b;
    if (x->distance != y->distance) return x->distance < y->distance ? -1 : 1;
    if (x->instance != y->instance) return x->instance < y->instance ? -1 : 1;
    if (x->part != y->part) return x->part < y->part ? -1 : 1;
    return x->triangle < y->triangle ? -1 : x->triangle > y->triangle;
}

bool ray_find(const struct ray_scene *s, enum ray_kind kind, dvec3 origin, dvec3 direction, double low, double high,
              const struct ray_neighbours *neighbours, struct ray_walk *walk, struct ray_hit *hit) {
    struct query query = {.kind = kind, .neighbours = neighbours, .walk = walk};
    struct RTCRayHit ray = {.ray = embree_ray(origin, direction, low, high),
                            .hit = {.geomID = RTC_INVALID_GEOMETRY_ID, .instID = {RTC_INVALID_GEOMETRY_ID}}};
    embree_query_init(&query.embree);
    if (kind == RAY_CAMERA) walk->layers.count = 0;
    walk->ray_count++;
    embree_intersect(s->handle, &query.embree, &ray);
    bool found = ray.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    if (found) {
        const struct instance *in = &s->instances.data[ray.hit.instID[0]];
        dvec3 normal = {(double)ray.hit.Ng_x, (double)ray.hit.Ng_y, (double)ray.hit.Ng_z};
        *hit = (struct ray_hit){.instance = ray.hit.instID[0],
                                .part = s->meshes.data[in->mesh].first_part + ray.hit.geomID,
                                .triangle = ray.hit.primID,
                                .u = (double)ray.hit.u,
                                .v = (double)ray.hit.v,
                                .distance = (double)ray.ray.tfar,
                                .front = dvec3_dot(direction, dvec3_combine(in->cofactors[0], in->cofactors[1], in->cofactors[2], normal)) < 0};
    }
    if (kind != RAY_CAMERA) return found;
    if (walk->layers.count > 1) qsort(walk->layers.data, walk->layers.count, sizeof *walk->layers.data, compare_layers);
    uint32_t kept = 0;
    for (uint32_t i = 0; i < walk->layers.count; i++)
        if (kept == 0 || !is_same_crossing(&walk->layers.data[kept - 1], &walk->layers.data[i])) walk->layers.data[kept++] = walk->layers.data[i];
    walk->layers.count = kept;
    while (found && walk->layers.count && walk->layers.data[walk->layers.count - 1].distance >= hit->distance) walk->layers.count--;
    return found;
}

double ray_visibility(const struct ray_scene *s, dvec3 origin, dvec3 direction, double distance, struct ray_walk *walk) {
    struct query query = {.visibility = 1, .walk = walk};
    struct RTCRay ray = embree_ray(origin, direction, 0, distance);
    embree_query_init(&query.embree);
    walk->crossed.count = 0;
    walk->ray_count++;
    embree_occluded(s->handle, &query.embree, &ray);
    return ray.tfar < 0 ? 0 : query.visibility;
}

double ray_offset(const struct ray_scene *s, dvec3 position) {
    /* Embree takes floats, and transforms them into the space of instances: some units in the last place of the greatest coordinate. */
    return fmax(s->reach, dvec3_reach(position)) * 0x1p-20;
}

/* ---- surfaces ---- */

/* The means of the corners' unit vectors in the world, as vertices have them. */
static dvec3 interpolate_normal(const struct part *part, const struct instance *in, const uint32_t *corners, const double weights[3]) {
    dvec3 sum = {0, 0, 0};
    for (int k = 0; k < 3; k++)
        sum = dvec3_add_scaled(sum, dvec3_normalize(carry(in->cofactors, dvec3_from(part->normals[corners[k]]))), weights[k]);
    return sum;
}

static dvec3 bend_normal(const struct part *part, const struct instance *in, const uint32_t *corners, const double weights[3],
                         dvec3 normal, const double texel[4]) {
    dvec3 tangent = {0, 0, 0};
    for (int k = 0; k < 3; k++) {
        vec4 t = part->tangents[corners[k]];
        dvec3 own = dvec3_normalize(carry(in->axes, dvec3_make((double)t.x, (double)t.y, (double)t.z)));
        tangent = dvec3_add_scaled(tangent, own, weights[k]);
    }
    double hand = (double)part->tangents[corners[0]].w * in->mirror, scale = (double)part->material->normal_scale;
    dvec3 mapped = {(texel[0] * 2 - 1) * scale, (texel[1] * 2 - 1) * scale, texel[2] * 2 - 1};
    return dvec3_combine(tangent, dvec3_scale(dvec3_cross(normal, tangent), hand), normal, mapped);
}

static dvec3 rgb(const double texel[4]) { return dvec3_make(texel[0], texel[1], texel[2]); }

static void shade_material(const struct ray_scene *s, const struct part *part, const struct ray_uv *uv, const double color[4],
                           struct ray_surface *out) {
    const struct scene_material *m = part->material;
    double texel[4];
#define SAMPLE(slot) ray_texture_sample(s->scene, s->images, m, SCENE_TEXTURE_##slot, uv, texel)
    SAMPLE(BASE_COLOR);
    const dvec3 factor = {(double)m->base_color.x, (double)m->base_color.y, (double)m->base_color.z};
    out->base_color = dvec3_mul(dvec3_mul(factor, rgb(color)), rgb(texel));
    out->alpha = m->alpha_mode == FNL_ALPHA_BLEND ? clamp01((double)m->base_color.w * color[3] * texel[3]) : 1;
    SAMPLE(METALLIC_ROUGHNESS);
    out->metallic = clamp01((double)m->metallic * texel[2]);
    out->roughness = clamp01((double)m->roughness * texel[1]);
    SAMPLE(OCCLUSION);
    out->occlusion = 1 + (double)m->occlusion_strength * (texel[0] - 1);
    SAMPLE(EMISSIVE);
    out->emissive = dvec3_mul(dvec3_from(m->emissive), rgb(texel));
    SAMPLE(SPECULAR);
    out->f90 = (double)m->specular * texel[3];
    SAMPLE(SPECULAR_COLOR);
#undef SAMPLE
    dvec3 f0 = dvec3_scale(dvec3_mul(dvec3_from(m->specular_color), rgb(texel)), ray_ior_reflectance((double)m->ior));
    out->f0 = dvec3_scale(dvec3_make(fmin(f0.x, 1), fmin(f0.y, 1), fmin(f0.z, 1)), out->f90);
    if (!m->unlit) return;
    out->emissive = out->base_color;
    out->base_color = out->f0 = (dvec3){0, 0, 0};
    out->metallic = out->f90 = 0;
}

struct ray_surface ray_surface_at(const struct ray_scene *s, const struct ray_hit *hit, dvec3 origin, dvec3 direction,
                                  const struct ray_neighbours *neighbours) {
    const struct part *part = &s->parts.data[hit->part];
    const struct instance *in = &s->instances.data[hit->instance];
    const uint32_t *corners = part->primitive->indices + 3 * (size_t)hit->triangle;
    const struct scene_material *m = part->material;
    struct ray_surface out = {0};
    struct ray_uv uv = {0};
    dvec3 p[3];
    double u = hit->u, v = hit->v, color[4], texel[4];
    find_corners(part, in, hit->triangle, p);
    if (!meet(p, origin, direction, &u, &v)) u = hit->u, v = hit->v;
    const double weights[3] = {1 - u - v, u, v};
    for (int k = 0; k < 3; k++) out.position = dvec3_add_scaled(out.position, p[k], weights[k]);
    interpolate_uv(part, hit->triangle, u, v, uv.at);
    if (neighbours) find_footprint(part, hit->triangle, p, neighbours, &uv);
    vertex_color(part, hit->triangle, u, v, color);
    shade_material(s, part, &uv, color, &out);

    double sign = hit->front ? 1 : -1;
    dvec3 face = dvec3_normalize(dvec3_scale(dvec3_cross(dvec3_sub(p[1], p[0]), dvec3_sub(p[2], p[0])), in->mirror));
    dvec3 normal = part->normals ? interpolate_normal(part, in, corners, weights) : face;
    if (part->normals && part->tangents && ray_texture_exists(s->images, m, SCENE_TEXTURE_NORMAL)) {
        ray_texture_sample(s->scene, s->images, m, SCENE_TEXTURE_NORMAL, &uv, texel);
        dvec3 bent = bend_normal(part, in, corners, weights, normal, texel);
        if (dvec3_length(bent) > 1e-10) normal = bent;
    }
    out.geometric = dvec3_scale(face, sign);
    out.normal = dvec3_length(normal) > 0 ? dvec3_scale(dvec3_normalize(normal), sign) : out.geometric;
    return out;
}
