/* SPDX-License-Identifier: MIT */
#include "scene/scene.h"

/* Interpolation as in glTF 2.0, appendix C. */

/** The keys around a time, and where between them it lies; at and beyond the ends both are the end key. */
struct key_span {
    uint32_t first, second;
    float fraction; /* 0..1 */
    float length;   /* seconds between the keys */
};

static struct key_span find_span(const struct scene_channel *channel, float time) {
    uint32_t low = 0, high = channel->key_count - 1;
    if (!(time > channel->times[low])) return (struct key_span){low, low, 0, 0};
    if (time >= channel->times[high]) return (struct key_span){high, high, 0, 0};
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (channel->times[middle] <= time)
            low = middle;
        else
            high = middle;
    }
    float length = channel->times[high] - channel->times[low];
    return (struct key_span){low, high, (time - channel->times[low]) / length, length};
}

/** The value part of a key: the middle third for cubic channels. */
static const float *key_value(const struct scene_channel *channel, uint32_t key) {
    size_t width = channel->width;
    return channel->interpolation == SCENE_INTERPOLATION_CUBIC ? channel->values + width * (3 * (size_t)key + 1)
                                                               : channel->values + width * key;
}

static float interpolate(const struct scene_channel *channel, const struct key_span *span, uint32_t i) {
    const float *a = key_value(channel, span->first), *b = key_value(channel, span->second);
    float t = span->fraction;
    if (span->first == span->second || channel->interpolation == SCENE_INTERPOLATION_STEP) return a[i];
    if (channel->interpolation == SCENE_INTERPOLATION_LINEAR) return a[i] + (b[i] - a[i]) * t;
    /* The out-tangent of a key follows its value, the in-tangent precedes it. */
    float out_tangent = a[channel->width + i], in_tangent = *(b + i - channel->width);
    float t2 = t * t, t3 = t2 * t;
    return (2 * t3 - 3 * t2 + 1) * a[i] + span->length * (t3 - 2 * t2 + t) * out_tangent + (3 * t2 - 2 * t3) * b[i] +
           span->length * (t3 - t2) * in_tangent;
}

static quat quat_load(const float *v) { return (quat){v[0], v[1], v[2], v[3]}; }

static quat interpolate_rotation(const struct scene_channel *channel, const struct key_span *span) {
    if (channel->interpolation == SCENE_INTERPOLATION_LINEAR && span->first != span->second)
        return quat_slerp(quat_load(key_value(channel, span->first)), quat_load(key_value(channel, span->second)),
                          span->fraction);
    float v[4];
    for (uint32_t i = 0; i < 4; i++) v[i] = interpolate(channel, span, i);
    return quat_normalize(quat_load(v));
}

static vec3 interpolate_vector(const struct scene_channel *channel, const struct key_span *span) {
    return vec3_make(interpolate(channel, span, 0), interpolate(channel, span, 1), interpolate(channel, span, 2));
}

/** The node's own weights; made from the mesh's when they are first animated or set. NULL without morph targets or memory. */
static float *own_weights(fnl_scene *scene, struct scene_node *node) {
    if (node->morph_weights || node->mesh == SCENE_NONE) return node->morph_weights;
    const struct scene_mesh *mesh = &scene->meshes.data[node->mesh];
    if (!mesh->morph_target_count) return NULL;
    node->morph_weights = host_allocate_zero(&scene->host, sizeof(float) * mesh->morph_target_count);
    node->owns_weights = node->morph_weights != NULL;
    if (node->morph_weights && mesh->morph_weights)
        memcpy(node->morph_weights, mesh->morph_weights, sizeof(float) * mesh->morph_target_count);
    return node->morph_weights;
}

static void apply_weights(fnl_scene *scene, struct scene_node *node, const struct scene_channel *channel,
                          const struct key_span *span) {
    float *weights = own_weights(scene, node);
    if (!weights) return;
    uint32_t first = channel->first_weight, targets = scene->meshes.data[node->mesh].morph_target_count;
    for (uint32_t i = 0; i < channel->width && first + i < targets; i++) weights[first + i] = interpolate(channel, span, i);
}

static void apply_property(fnl_scene *scene, const struct scene_channel *channel, const struct key_span *span) {
    float values[4] = {0};
    for (uint32_t i = 0; i < MIN(channel->width, COUNT_OF(values)); i++) values[i] = interpolate(channel, span, i);
    if (channel->property->effect == SCENE_EFFECT_ROTATION) {
        const quat rotation = interpolate_rotation(channel, span);
        memcpy(values, &rotation, sizeof rotation);
    }
    animation_set_property(scene, channel, values);
}

static void set_vector(double out[3], vec3 v) {
    out[0] = (double)v.x;
    out[1] = (double)v.y;
    out[2] = (double)v.z;
}

static void set_rotation(double out[4], quat q) {
    set_vector(out, vec3_make(q.x, q.y, q.z));
    out[3] = (double)q.w;
}

/* ---- one animation ---- */

static const struct scene_animation *animation_at(const fnl_scene *scene, uint32_t index) {
    return &scene->animations.data[scene_entity_slot(scene, FNL_ENTITY_ANIMATION, index)];
}

fnl_result animation_apply(fnl_scene *scene, uint32_t animation, double seconds) {
    if (animation >= scene_entity_count(scene, FNL_ENTITY_ANIMATION)) return FNL_OK;
    const struct scene_animation *what = animation_at(scene, animation);
    for (uint32_t i = 0; i < what->channel_count; i++) {
        const struct scene_channel *channel = &what->channels[i];
        if (!channel->key_count) continue;
        struct key_span span = find_span(channel, (float)seconds);
        if (channel->path == SCENE_PATH_PROPERTY) {
            apply_property(scene, channel, &span);
            continue;
        }
        if (channel->node >= scene->nodes.count) continue;
        struct scene_node *node = &scene->nodes.data[channel->node];
        if (node->removed) continue;
        if (channel->path == SCENE_PATH_VISIBLE) {
            scene_show_node(scene, channel->node, interpolate(channel, &span, 0) != 0);
            continue;
        }
        if (channel->path == SCENE_PATH_WEIGHTS) {
            apply_weights(scene, node, channel, &span);
            continue;
        }
        if (node->has_matrix) continue; /* glTF 2.0, 3.5.2: a node that is animated has no matrix */
        if (channel->path == SCENE_PATH_TRANSLATION) set_vector(node->translation, interpolate_vector(channel, &span));
        if (channel->path == SCENE_PATH_SCALE) set_vector(node->scale, interpolate_vector(channel, &span));
        if (channel->path == SCENE_PATH_ROTATION) set_rotation(node->rotation, interpolate_rotation(channel, &span));
        scene_pose_node(node);
    }
    return animation_finish_properties(scene, what);
}

void skin_matrices(const fnl_scene *scene, uint32_t skin, mat4 *out) {
    const struct scene_skin *what = &scene->skins.data[skin];
    for (uint32_t i = 0; i < what->joint_count; i++) {
        const struct affine bind = affine_from_mat4(&what->inverse_bind[i], no_origin);
        const struct affine moved = affine_mul(&scene->nodes.data[what->joints[i]].world_exact, &bind);
        out[i] = mat4_from_affine(&moved, scene->origin);
    }
}

/* Of the vertices of a mesh that its skin moves, this many of each primitive say which way round it is. */
#define SKIN_VOTERS 64u

static double joint_determinant(const fnl_scene *scene, const struct scene_skin *skin, uint32_t joint) {
    return (double)mat4_determinant3(&scene->nodes.data[skin->joints[joint]].world) * (double)mat4_determinant3(&skin->inverse_bind[joint]);
}

bool skin_mirrors(const fnl_scene *scene, const struct scene_node *node) {
    if (node->skin == SCENE_NONE || node->mesh == SCENE_NONE) return false;
    const struct scene_skin *skin = &scene->skins.data[node->skin];
    const struct scene_mesh *mesh = &scene->meshes.data[node->mesh];
    int votes = 0;
    for (uint32_t i = 0; i < mesh->primitive_count; i++) {
        const struct scene_primitive *p = &scene->primitives.data[mesh->first_primitive + i];
        const uint32_t voters = p->joint_count ? MIN(p->vertex_count, SKIN_VOTERS) : 0;
        for (uint32_t k = 0; k < voters; k++) {
            const size_t first = (size_t)((uint64_t)k * p->vertex_count / voters) * p->joint_count;
            size_t most = first; /* the joint that moves the vertex most */
            for (size_t j = first + 1; j < first + p->joint_count; j++)
                if (p->weights[j] > p->weights[most]) most = j;
            const double determinant = joint_determinant(scene, skin, p->joints[most]);
            votes += (determinant > 0) - (determinant < 0);
        }
    }
    return votes < 0;
}

mat4 skin_instance(bool mirrored) { return mat4_scaling(vec3_make(mirrored ? -1 : 1, 1, 1)); }

void skin_instance_matrices(const fnl_scene *scene, uint32_t skin, bool mirrored, mat4 *out) {
    skin_matrices(scene, skin, out);
    for (uint32_t i = 0; mirrored && i < scene->skins.data[skin].joint_count; i++)
        for (int column = 0; column < 4; column++) out[i].m[4 * column] = -out[i].m[4 * column];
}

/* ---- several at once ---- */

/* A channel at a time, and which of the blended animations it is of. */
struct blended {
    const struct scene_channel *channel;
    float seconds, weight;
    uint32_t animation, order;
};

static int compare_numbers(uint64_t a, uint64_t b) { return a < b ? -1 : a > b; }

/* By what is set: a node's path, or a property. */
static int compare_targets(const struct scene_channel *a, const struct scene_channel *b) {
    int order = compare_numbers(a->path, b->path);
    if (order == 0) order = compare_numbers(a->node, b->node);
    if (order == 0) order = compare_numbers((uintptr_t)a->property, (uintptr_t)b->property);
    return order == 0 && a->property ? compare_numbers(a->object, b->object) : order;
}

static int compare_blended(const void *left, const void *right) {
    const struct blended *a = left, *b = right;
    const int order = compare_targets(a->channel, b->channel);
    return order ? order : compare_numbers(a->order, b->order);
}

/* The heaviest: of equal ones that of the first animation, and of its channels the last, as where it is played alone. */
static const struct blended *heaviest(const struct blended *group, uint32_t count) {
    const struct blended *best = group;
    for (uint32_t i = 1; i < count; i++)
        if (group[i].weight > best->weight || group[i].animation == best->animation) best = &group[i];
    return best;
}

static bool is_stepped(const struct blended *group, uint32_t count) {
    for (uint32_t i = 0; i < count; i++)
        if (group[i].channel->interpolation != SCENE_INTERPOLATION_STEP) return false;
    return true;
}

/* What one component is by the animations that set it; false: none does. A later channel of an animation stands in for an earlier one. */
static bool blend_component(const struct blended *group, uint32_t count, uint32_t component, float *out) {
    float sum = 0, total = 0, value = 0;
    uint32_t used = 0;
    for (uint32_t i = 0; i < count; i++) {
        const struct scene_channel *c = group[i].channel;
        bool replaced = component < c->first_weight || component >= c->first_weight + c->width;
        for (uint32_t k = i + 1; k < count && group[k].animation == group[i].animation && !replaced; k++)
            replaced = component >= group[k].channel->first_weight && component < group[k].channel->first_weight + group[k].channel->width;
        if (replaced) continue;
        const struct key_span span = find_span(c, group[i].seconds);
        value = interpolate(c, &span, component - c->first_weight);
        sum += group[i].weight * value;
        total += group[i].weight;
        used++;
    }
    if (used > 0) *out = used == 1 ? value : sum / total;
    return used > 0;
}

/* The sum of all as they lie on the side of the heaviest, made a unit again; of one alone it is that. */
static quat blend_rotation(const struct blended *group, uint32_t count) {
    const struct blended *most = heaviest(group, count);
    struct key_span span = find_span(most->channel, most->seconds);
    const quat main = interpolate_rotation(most->channel, &span);
    quat sum = {0, 0, 0, 0};
    uint32_t used = 0;
    for (uint32_t i = 0; i < count; i++) {
        if (i + 1 < count && group[i + 1].animation == group[i].animation) continue;
        span = find_span(group[i].channel, group[i].seconds);
        const quat q = interpolate_rotation(group[i].channel, &span);
        const float w = q.x * main.x + q.y * main.y + q.z * main.z + q.w * main.w < 0 ? -group[i].weight : group[i].weight;
        sum = (quat){sum.x + w * q.x, sum.y + w * q.y, sum.z + w * q.z, sum.w + w * q.w};
        used++;
    }
    const float square = sum.x * sum.x + sum.y * sum.y + sum.z * sum.z + sum.w * sum.w;
    return used > 1 && square > 0 ? quat_normalize(sum) : main;
}

static bool blend_vector(const struct blended *group, uint32_t count, vec3 *out) {
    float v[3];
    for (uint32_t i = 0; i < 3; i++)
        if (!blend_component(group, count, i, &v[i])) return false;
    *out = vec3_make(v[0], v[1], v[2]);
    return true;
}

static void blend_node(fnl_scene *scene, const struct blended *group, uint32_t count) {
    struct scene_node *node = &scene->nodes.data[group->channel->node];
    const enum scene_animation_path path = group->channel->path;
    if (path == SCENE_PATH_WEIGHTS) {
        float *weights = own_weights(scene, node);
        for (uint32_t i = 0; weights && i < scene->meshes.data[node->mesh].morph_target_count; i++) (void)blend_component(group, count, i, &weights[i]);
        return;
    }
    if (node->has_matrix) return;
    vec3 vector;
    if (path == SCENE_PATH_TRANSLATION && blend_vector(group, count, &vector)) set_vector(node->translation, vector);
    if (path == SCENE_PATH_SCALE && blend_vector(group, count, &vector)) set_vector(node->scale, vector);
    if (path == SCENE_PATH_ROTATION) set_rotation(node->rotation, blend_rotation(group, count));
    scene_pose_node(node);
}

/* All that set one thing. */
static void blend_group(fnl_scene *scene, const struct blended *group, uint32_t count) {
    const struct scene_channel *first = group->channel;
    if (first->path != SCENE_PATH_PROPERTY && (first->node >= scene->nodes.count || scene->nodes.data[first->node].removed)) return;
    struct blended only = *heaviest(group, count);
    if (first->path == SCENE_PATH_VISIBLE) {
        const struct key_span span = find_span(only.channel, only.seconds);
        scene_show_node(scene, first->node, interpolate(only.channel, &span, 0) != 0);
        return;
    }
    if (first->path != SCENE_PATH_WEIGHTS && is_stepped(group, count)) {
        group = &only;
        count = 1;
    }
    if (first->path != SCENE_PATH_PROPERTY) {
        blend_node(scene, group, count);
        return;
    }
    float values[4] = {0};
    for (uint32_t i = 0; i < MIN(first->width, COUNT_OF(values)); i++) (void)blend_component(group, count, i, &values[i]);
    animation_set_property(scene, first, values);
}

static fnl_result blend(fnl_scene *scene, const fnl_animation_time *times, uint32_t count) {
    uint32_t total = 0, used = 0;
    for (uint32_t i = 0; i < count; i++) total += times[i].weight > 0 ? animation_at(scene, times[i].animation)->channel_count : 0;
    const size_t size = MAX(total, 1u) * sizeof(struct blended);
    struct blended *all = host_allocate(&scene->host, size);
    if (!all) return FNL_ERROR_MEMORY;
    for (uint32_t i = 0; i < count; i++) {
        const struct scene_animation *animation = animation_at(scene, times[i].animation);
        for (uint32_t k = 0; k < animation->channel_count && times[i].weight > 0; k++)
            if (animation->channels[k].key_count) {
                all[used] = (struct blended){&animation->channels[k], (float)times[i].seconds, times[i].weight, i, used};
                used++;
            }
    }
    qsort(all, used, sizeof *all, compare_blended);
    for (uint32_t first = 0, next; first < used; first = next) {
        for (next = first + 1; next < used && compare_targets(all[first].channel, all[next].channel) == 0;) next++;
        blend_group(scene, all + first, next - first);
    }
    host_free(&scene->host, all, size);
    fnl_result result = FNL_OK;
    for (uint32_t i = 0; i < count && result == FNL_OK; i++)
        if (times[i].weight > 0) result = animation_finish_properties(scene, animation_at(scene, times[i].animation));
    return result;
}

/* ---- the calls ---- */

static bool sets_weights(const fnl_scene *scene, uint32_t animation) {
    const struct scene_animation *what = animation_at(scene, animation);
    for (uint32_t i = 0; i < what->channel_count; i++)
        if (what->channels[i].path == SCENE_PATH_WEIGHTS) return true;
    return false;
}

static fnl_result set_times(fnl_scene *scene, const fnl_animation_time *times, uint32_t count) {
    uint32_t weighty = 0, only = 0;
    if (scene_entity_count(scene, FNL_ENTITY_ANIMATION) == 0) return FNL_OK;
    for (uint32_t i = 0; i < count; i++) {
        if (!(times[i].weight > 0)) continue;
        weighty++;
        only = i;
    }
    const fnl_result result = weighty == 1 ? animation_apply(scene, times[only].animation, times[only].seconds) : blend(scene, times, count);
    scene_update_transforms(scene);
    /* Morph weights move no node, but renderers follow them by the same counter. */
    bool weights = false;
    for (uint32_t i = 0; i < count; i++) weights = weights || (times[i].weight > 0 && sets_weights(scene, times[i].animation));
    scene->transform_version += weights;
    return result;
}

static fnl_result check_animation(const struct call *call, const fnl_scene *scene, uint32_t animation) {
    const uint32_t count = scene_entity_count(scene, FNL_ENTITY_ANIMATION);
    return count || animation ? check_index(call, "animation", animation, count, "animations") : FNL_OK;
}

fnl_result fnl_scene_set_time(fnl_scene *scene, uint32_t animation, double seconds) {
    TRY(check_handle(__func__, "scene", scene));
    if (!isfinite(seconds)) return misuse(CALL(&scene->host), "seconds is %g, must be finite", seconds);
    TRY(check_animation(CALL(&scene->host), scene, animation));
    const fnl_animation_time time = {animation, seconds, 1};
    return set_times(scene, &time, 1);
}

fnl_result fnl_scene_set_times(fnl_scene *scene, const fnl_animation_time *times, uint32_t count) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(check_pointer(CALL(&scene->host), "times", times));
    TRY(check_count(CALL(&scene->host), "count", count, 1, 1024));
    float sum = 0;
    for (uint32_t i = 0; i < count; i++) {
        const struct call *call = CALL_ELEMENT(&scene->host, i, count);
        if (!isfinite(times[i].seconds)) return misuse(call, "seconds is %g, must be finite", times[i].seconds);
        TRY(check_animation(call, scene, times[i].animation));
        TRY(check_range(call, "weight", (double)times[i].weight, 0, 1e6, ""));
        sum += times[i].weight;
    }
    if (!(sum > 0)) return misuse(CALL(&scene->host), "all weights are 0, one must be above");
    return set_times(scene, times, count);
}

/* ---- poses that a program makes ---- */

static fnl_result check_pose(const struct call *call, const fnl_scene *scene, const struct scene_node *node, const fnl_pose *pose) {
    uint32_t weights = node->mesh == SCENE_NONE ? 0 : scene->meshes.data[node->mesh].morph_target_count;
    uint32_t joints = node->skin == SCENE_NONE ? 0 : scene->skins.data[node->skin].joint_count;
    if (pose->morph_weights ? pose->morph_weight_count != weights : pose->morph_weight_count != 0)
        return misuse(call, "morph_weight_count is %u, must be %u%s", pose->morph_weight_count, pose->morph_weights ? weights : 0,
                      pose->morph_weights ? ", the number of morph targets" : ": morph_weights is NULL");
    if (pose->joints ? pose->joint_count != joints : pose->joint_count != 0)
        return misuse(call, "joint_count is %u, must be %u%s", pose->joint_count, pose->joints ? joints : 0,
                      pose->joints ? ", the number of joints of the skin" : ": joints is NULL");
    if (pose->morph_weights)
        TRY(check_floats(call, "morph_weights", pose->morph_weights, weights, -(double)FLT_MAX, (double)FLT_MAX, ""));
    for (uint32_t i = 0; i < pose->joint_count; i++) {
        const struct call joint = {.host = call->host, .function = call->function, .in_array = true, .element = i};
        TRY(scene_check_affine(&joint, &pose->joints[i]));
    }
    return FNL_OK;
}

fnl_result fnl_scene_set_pose(fnl_scene *scene, fnl_instance_id instance, const fnl_pose *pose) {
    TRY(check_handle(__func__, "scene", scene));
    const struct call *call = CALL(&scene->host);
    TRY(scene_check_instance(call, scene, instance));
    TRY(check_pointer(call, "pose", pose));
    struct scene_node *node = &scene->nodes.data[instance.index];
    TRY(check_pose(call, scene, node, pose));
    float *weights = pose->morph_weight_count ? own_weights(scene, node) : NULL;
    if (pose->morph_weight_count && !weights) return FNL_ERROR_MEMORY;
    const struct scene_skin *skin = pose->joint_count ? &scene->skins.data[node->skin] : NULL;
    size_t size = pose->joint_count * (sizeof(fnl_instance_id) + sizeof(mat4));
    mat4 *locals = skin ? host_allocate(&scene->host, size) : NULL;
    if (skin && !locals) return FNL_ERROR_MEMORY;

    if (weights) {
        memcpy(weights, pose->morph_weights, sizeof *weights * pose->morph_weight_count);
        scene_weights_changed(scene, instance.index);
    }
    if (!skin) return FNL_OK;
    fnl_instance_id *joints = (fnl_instance_id *)(locals + pose->joint_count);
    uint32_t count = 0;
    for (uint32_t i = 0; i < pose->joint_count; i++) {
        if (scene->nodes.data[skin->joints[i]].removed) continue; /* stays where it was */
        joints[count] = (fnl_instance_id){.index = skin->joints[i]};
        locals[count++] = pose->joints[i];
    }
    scene_move_nodes(scene, joints, locals, count);
    host_free(&scene->host, locals, size);
    return FNL_OK;
}
