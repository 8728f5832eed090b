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
    animation_set_property(scene, channel, values);
}

fnl_result animation_apply(fnl_scene *scene, uint32_t animation, double seconds) {
    if (animation >= scene->animations.count) return FNL_OK;
    const struct scene_animation *what = &scene->animations.data[animation];
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
        if (channel->path == SCENE_PATH_TRANSLATION) node->translation = interpolate_vector(channel, &span);
        if (channel->path == SCENE_PATH_SCALE) node->scale = interpolate_vector(channel, &span);
        if (channel->path == SCENE_PATH_ROTATION) node->rotation = interpolate_rotation(channel, &span);
        node->local = mat4_from_trs(node->translation, node->rotation, node->scale);
    }
    return animation_finish_properties(scene, what);
}

void skin_matrices(const fnl_scene *scene, uint32_t skin, mat4 *out) {
    const struct scene_skin *what = &scene->skins.data[skin];
    for (uint32_t i = 0; i < what->joint_count; i++)
        out[i] = mat4_mul(scene->nodes.data[what->joints[i]].world, what->inverse_bind[i]);
}

fnl_result fnl_scene_set_time(fnl_scene *scene, uint32_t animation, double seconds) {
    TRY(check_handle(__func__, "scene", scene));
    if (!isfinite(seconds)) return misuse(CALL(&scene->host), "seconds is %g, must be finite", seconds);
    if (scene->animations.count || animation)
        TRY(check_index(CALL(&scene->host), "animation", animation, scene->animations.count, "animations"));
    const fnl_result result = animation_apply(scene, animation, seconds);
    scene_update_transforms(scene);
    /* Morph weights move no node, but renderers follow them by the same counter. */
    for (uint32_t i = 0; animation < scene->animations.count && i < scene->animations.data[animation].channel_count; i++)
        if (scene->animations.data[animation].channels[i].path == SCENE_PATH_WEIGHTS) {
            scene->transform_version++;
            break;
        }
    return result;
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
