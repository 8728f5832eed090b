/* SPDX-License-Identifier: MIT */
/* Animations (glTF 2.0, 3.11). */
#include "scene/gltf.h"

enum { PATH_COUNT = SCENE_PATH_VISIBLE + 1 }; /* of nodes */

struct sampler {
    bool valid;
    uint32_t output;
    enum scene_interpolation interpolation;
    uint32_t key_count;
    const float *times;
};

/* ---- samplers ---- */

static const float *load_times(struct gltf *g, uint32_t index, const struct at *at) {
    const struct gltf_accessor *accessor = &g->accessors[index];
    if (!gltf_accessor_readable(g, index, at)) return NULL;
    if (accessor->type != GLTF_SCALAR || accessor->component != GLTF_FLOAT) {
        gltf_warn(g, at, "is not SCALAR of FLOAT; its channels are left out");
        return NULL;
    }
    if (!gltf_spend(g, at, (uint64_t)accessor->count * sizeof(float))) return NULL;
    float *times = gltf_keep(g, accessor->count, sizeof *times);
    if (!times || !gltf_read_floats(g, index, at, times)) return NULL;
    for (uint32_t i = 0; i < accessor->count; i++) {
        const char *fault = !isfinite(times[i])                   ? "is not finite"
                            : times[i] < 0                        ? "is negative"
                            : i > 0 && !(times[i] > times[i - 1]) ? "is not greater than the one before"
                                                                  : NULL;
        if (!fault) continue;
        gltf_warn(g, at, "time %u, %g, %s; its channels are left out", i, (double)times[i], fault);
        return NULL;
    }
    return times;
}

static void load_sampler(struct gltf *g, json_t *object, const struct at *at, struct sampler *sampler) {
    uint32_t input = gltf_index(g, object, at, "input", true, g->accessor_count);
    sampler->output = gltf_index(g, object, at, "output", true, g->accessor_count);
    const char *interpolation = gltf_string(g, object, at, "interpolation", false);
    sampler->interpolation = SCENE_INTERPOLATION_LINEAR;
    if (interpolation && strcmp(interpolation, "STEP") == 0)
        sampler->interpolation = SCENE_INTERPOLATION_STEP;
    else if (interpolation && strcmp(interpolation, "CUBICSPLINE") == 0)
        sampler->interpolation = SCENE_INTERPOLATION_CUBIC;
    else if (interpolation && strcmp(interpolation, "LINEAR") != 0)
        gltf_warn(g, AT_KEY(at, "interpolation"), "is unknown; it is taken as LINEAR");
    if (input == SCENE_NONE || sampler->output == SCENE_NONE) return;
    sampler->times = load_times(g, input, AT_KEY(at, "input"));
    sampler->key_count = g->accessors[input].count;
    sampler->valid = sampler->times != NULL;
}

/* ---- channels ---- */

static bool parse_path(const char *name, enum scene_animation_path *path) {
    static const char *const names[] = {"translation", "rotation", "scale", "weights"};
    for (uint32_t i = 0; i < COUNT_OF(names); i++)
        if (strcmp(names[i], name) == 0) {
            *path = (enum scene_animation_path)i;
            return true;
        }
    return false;
}

/** Translation and scale are floats; rotations and weights may be normalised integers; what a pointer names, any. */
static bool output_format_good(const struct gltf_accessor *accessor, const struct gltf_target *target) {
    static const enum gltf_type types[] = {GLTF_SCALAR, GLTF_VEC2, GLTF_VEC3, GLTF_VEC4};
    if (accessor->type != (target->path == SCENE_PATH_WEIGHTS ? GLTF_SCALAR : types[target->width - 1])) return false;
    if (target->path == SCENE_PATH_VISIBLE) return accessor->component == GLTF_UNSIGNED_BYTE;
    bool may_be_integer = target->path == SCENE_PATH_ROTATION || target->path == SCENE_PATH_WEIGHTS;
    return accessor->component == GLTF_FLOAT || target->pointer || (may_be_integer && accessor->normalized);
}

/** 3.11: keys of rotations are of unit length; tangents of splines are not. */
static void make_unit(struct gltf *g, const struct at *at, const struct scene_channel *channel, float *values) {
    bool cubic = channel->interpolation == SCENE_INTERPOLATION_CUBIC;
    uint32_t wrong = 0, first = 0;
    for (uint32_t i = 0; i < channel->key_count; i++) {
        float *q = values + ((size_t)i * (cubic ? 3 : 1) + cubic) * 4;
        float length = sqrtf(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
        if (fabsf(length - 1) < 0.01f) continue; /* as far as 8-bit rotations are off */
        if (wrong++ == 0) first = i;
        quat unit = quat_normalize((quat){q[0], q[1], q[2], q[3]});
        memcpy(q, &unit, sizeof unit);
    }
    if (wrong)
        gltf_warn(g, at, "%u rotations are not of unit length, the first at key %u; they are normalised", wrong, first);
}

static void warn_out_of_range(struct gltf *g, const struct at *at, const struct scene_channel *channel, const float *values) {
    const bool cubic = channel->interpolation == SCENE_INTERPOLATION_CUBIC;
    const struct scene_property *property = channel->property;
    uint32_t wrong = 0, first = 0;
    for (uint32_t i = 0; i < channel->key_count; i++) {
        const float *value = values + ((size_t)i * (cubic ? 3 : 1) + cubic) * channel->width;
        bool good = true;
        for (uint32_t k = 0; k < channel->width; k++) good &= value[k] >= property->low && value[k] <= property->high;
        if (!good && wrong++ == 0) first = i;
    }
    if (wrong)
        gltf_warn(g, at, "%u values are not in %g .. %g, the first at key %u; they are clamped", wrong, (double)property->low,
                  (double)property->high, first);
}

static const float *load_values(struct gltf *g, const struct sampler *sampler, const struct gltf_target *target,
                                const struct scene_channel *channel, const struct at *at, const struct at *output_at) {
    const struct gltf_accessor *accessor = &g->accessors[sampler->output];
    char format[64];
    if (!gltf_accessor_readable(g, sampler->output, at)) return NULL;
    if (!output_format_good(accessor, target)) {
        gltf_warn(g, at, "the output cannot be %s for this path; the channel is left out",
                  gltf_format_name(accessor, format, sizeof format));
        return NULL;
    }
    uint64_t elements = (uint64_t)channel->key_count * (channel->interpolation == SCENE_INTERPOLATION_CUBIC ? 3 : 1);
    if (channel->path == SCENE_PATH_WEIGHTS) elements *= channel->width;
    if (accessor->count != elements) {
        gltf_warn(g, at, "the output has %u elements, but %llu are needed; the channel is left out", accessor->count,
                  (unsigned long long)elements);
        return NULL;
    }
    uint64_t count = (uint64_t)accessor->count * gltf_type_components(accessor->type);
    if (!gltf_spend(g, at, count * sizeof(float))) return NULL;
    float *values = gltf_keep(g, count, sizeof *values);
    if (!values || !gltf_read_floats(g, sampler->output, at, values)) return NULL;
    for (uint64_t i = 0; i < count; i++)
        if (!isfinite(values[i])) {
            gltf_warn(g, at, "value %llu of the output is NaN or infinite; the channel is left out", (unsigned long long)i);
            return NULL;
        }
    const bool rotates = channel->property && channel->property->effect == SCENE_EFFECT_ROTATION;
    if (channel->path == SCENE_PATH_ROTATION || rotates) make_unit(g, output_at, channel, values);
    if (channel->property && !rotates) warn_out_of_range(g, output_at, channel, values);
    return values;
}

/** The channel of the present animation that last moved a property of a node. */
struct last_channel {
    uint32_t animation, channel; /* numbers from 1 on; 0: none */
};

/** An animation as it is loaded. */
struct animation_load {
    uint32_t animation, sampler_count;
    struct sampler *samplers;
    struct last_channel *last; /* of nodes, by node and path */
    json_t *pointers;          /* of others: numbers of channels */
    ARRAY(struct scene_channel) channels;
};

/** 3.11: no two channels of an animation have the same target. They are played in order, so the later one wins. */
static void check_duplicate(struct gltf *g, const struct at *at, struct last_channel *last, uint32_t animation,
                            uint32_t index) {
    if (last->animation == animation + 1) {
        const struct at *channels_at = at->parent, *first_at = AT_INDEX(channels_at, last->channel - 1);
        gltf_warn(g, AT_KEY(first_at, "target"), "channel %u has the same target, and is played instead", index);
    }
    *last = (struct last_channel){animation + 1, index + 1};
}

/** The same for what has no path of a node. */
static void check_pointers(struct gltf *g, const struct at *at, struct animation_load *load, const char *pointer) {
    json_t *known = json_object_get(load->pointers, pointer);
    if (known) {
        const struct at *channels_at = at->parent, *first_at = AT_INDEX(channels_at, (size_t)json_integer_value(known));
        gltf_warn(g, AT_KEY(first_at, "target"), "channel %zu has the same target, and is played instead", at->index);
    }
    if (json_object_set_new(load->pointers, pointer, json_integer((json_int_t)at->index)) != 0) gltf_fail_memory(g);
}

static bool load_node_target(struct gltf *g, const struct gltf_target *target, const struct at *at) {
    const struct scene_node *node = &g->scene->nodes.data[target->index];
    if (target->path > SCENE_PATH_SCALE || !node->has_matrix) return true;
    gltf_warn(g, at, "node %u has a matrix, which cannot be animated; the channel is left out", target->index);
    return false;
}

static bool load_plain_target(struct gltf *g, json_t *object, const struct at *at, const char *path, struct gltf_target *target) {
    target->index = gltf_index(g, object, at, "node", false, g->node_count);
    if (!parse_path(path, &target->path)) {
        gltf_warn(g, AT_KEY(at, "path"), "is unknown; the channel is left out");
        return false;
    }
    if (target->index == SCENE_NONE) return false; /* allowed: there is nothing to move */
    const struct scene_node *node = &g->scene->nodes.data[target->index];
    target->width = target->path == SCENE_PATH_ROTATION ? 4 : 3;
    if (target->path == SCENE_PATH_WEIGHTS) {
        target->width = node->mesh == SCENE_NONE ? 0 : g->scene->meshes.data[node->mesh].morph_target_count;
        if (target->width == 0)
            gltf_warn(g, AT_KEY(at, "path"), "node %u has no morph targets; the channel is left out", target->index);
        return target->width > 0;
    }
    return load_node_target(g, target, AT_KEY(at, "path"));
}

static bool load_target(struct gltf *g, json_t *object, const struct at *at, struct gltf_target *target) {
    json_t *values = gltf_object(g, object, at, "target", true);
    if (!values) return false;
    const struct at *here = AT_KEY(at, "target");
    const char *path = gltf_string(g, values, here, "path", true);
    struct gltf_extension_place place;
    json_t *extension = gltf_extension(values, here, "KHR_animation_pointer", &place);
    if (!path) return false;
    if (strcmp(path, "pointer") != 0) {
        if (extension) gltf_warn(g, &place.extension, "is ignored: the path is not 'pointer'");
        return load_plain_target(g, values, here, path, target);
    }
    if (!extension) {
        gltf_warn(g, AT_KEY(here, "path"), "is 'pointer', but there is no KHR_animation_pointer; the channel is left out");
        return false;
    }
    if (json_object_get(values, "node")) gltf_warn(g, AT_KEY(here, "node"), "stands beside a pointer; it is ignored");
    const struct at *pointer_at = AT_KEY(&place.extension, "pointer");
    const char *pointer = gltf_string(g, extension, &place.extension, "pointer", true);
    if (!pointer || !gltf_find_target(g, pointer, pointer_at, target)) return false;
    target->pointer = pointer;
    return target->kind != GLTF_TARGET_NODE || load_node_target(g, target, pointer_at);
}

static void add_channel(struct gltf *g, struct animation_load *load, const struct scene_channel *channel) {
    if (!array_push(g->host, &load->channels, *channel)) gltf_fail_memory(g);
}

/** A channel for each thing in the scene that the target is. */
static void add_channels(struct gltf *g, const struct at *at, struct animation_load *load, const struct gltf_target *target,
                         struct scene_channel channel) {
    channel.node = SCENE_NONE;
    if (target->kind == GLTF_TARGET_NODE) {
        channel.node = target->index;
        /* hidden because it is in no shown scene */
        const bool outside = !g->in_scene[target->index] && g->scene->nodes.data[target->index].parent == SCENE_NONE;
        if (channel.path != SCENE_PATH_VISIBLE || !outside) add_channel(g, load, &channel);
        return;
    }
    channel.object = target->index;
    const bool one = target->kind == GLTF_TARGET_MATERIAL || target->kind == GLTF_TARGET_ENVIRONMENT;
    if (one) add_channel(g, load, &channel);
    if (one || target->kind == GLTF_TARGET_UNUSED) return;
    for (uint32_t user = gltf_first_user(g, target->kind, target->index); user != SCENE_NONE && g->result == FNL_OK;
         user = g->users[target->kind].next[user]) {
        if (!gltf_spend(g, at, sizeof channel)) return;
        channel.object = user;
        if (target->kind == GLTF_TARGET_MESH) channel.node = user;
        if (target->kind == GLTF_TARGET_LIGHT) channel.generation = g->scene->lights.data[user].generation;
        add_channel(g, load, &channel);
    }
}

static void load_channel(struct gltf *g, json_t *object, const struct at *at, struct animation_load *load) {
    uint32_t index = gltf_index(g, object, at, "sampler", true, load->sampler_count);
    struct gltf_target target = {.kind = GLTF_TARGET_NODE};
    bool good = load_target(g, object, at, &target);
    if (good && target.kind == GLTF_TARGET_NODE && !target.one_weight)
        check_duplicate(g, at, &load->last[(size_t)target.index * PATH_COUNT + target.path], load->animation,
                        (uint32_t)at->index);
    else if (good)
        check_pointers(g, at, load, target.pointer);
    if (!good || index == SCENE_NONE || !load->samplers[index].valid) return;
    const struct sampler *sampler = &load->samplers[index];
    struct scene_channel channel = {.path = target.path,
                                    .property = target.property,
                                    .interpolation = sampler->interpolation,
                                    .key_count = sampler->key_count,
                                    .width = target.width,
                                    .first_weight = target.first_weight,
                                    .times = sampler->times};
    const struct at *samplers_at = AT_KEY(at->parent->parent, "samplers"), *sampler_at = AT_INDEX(samplers_at, index);
    if (target.path == SCENE_PATH_VISIBLE && sampler->interpolation != SCENE_INTERPOLATION_STEP) {
        gltf_warn(g, AT_KEY(at, "sampler"), "the interpolation must be STEP for this path; the channel is left out");
        return;
    }
    channel.values = load_values(g, sampler, &target, &channel, AT_KEY(at, "sampler"), AT_KEY(sampler_at, "output"));
    if (channel.values) add_channels(g, at, load, &target, channel);
}

static void load_animation(struct gltf *g, json_t *object, const struct at *at, struct last_channel *last,
                           struct scene_animation *animation) {
    animation->name = gltf_name(g, object, at);
    animation->extras = gltf_extras(g, object);
    json_t *samplers = gltf_array(g, object, at, "samplers", true), *channels = gltf_array(g, object, at, "channels", true);
    struct animation_load load = {.animation = (uint32_t)at->index, .sampler_count = gltf_count(samplers), .last = last};
    load.samplers = gltf_scratch(g, load.sampler_count, sizeof *load.samplers);
    if (!load.samplers) return;
    load.pointers = json_object();
    if (!load.pointers) gltf_fail_memory(g);
    const struct at *samplers_at = AT_KEY(at, "samplers"), *channels_at = AT_KEY(at, "channels");
    for (uint32_t i = 0; i < load.sampler_count && g->result == FNL_OK; i++) {
        json_t *sampler = gltf_element(g, samplers, samplers_at, i);
        if (sampler) load_sampler(g, sampler, AT_INDEX(samplers_at, i), &load.samplers[i]);
    }
    for (uint32_t i = 0; i < gltf_count(channels) && g->result == FNL_OK; i++) {
        json_t *channel = gltf_element(g, channels, channels_at, i);
        if (channel) load_channel(g, channel, AT_INDEX(channels_at, i), &load);
    }
    json_decref(load.pointers);
    for (uint32_t i = 0; i < load.channels.count; i++) {
        const struct scene_channel *channel = &load.channels.data[i];
        animation->duration = fmaxf(animation->duration, channel->times[channel->key_count - 1]);
    }
    if (g->result == FNL_OK && load.channels.count) {
        animation->channels = arena_copy(&g->scene->arena, load.channels.data, load.channels.count * sizeof *load.channels.data);
        if (!animation->channels) gltf_fail_memory(g);
        animation->channel_count = animation->channels ? load.channels.count : 0;
    }
    array_free(g->host, &load.channels);
}

void gltf_load_animations(struct gltf *g) {
    json_t *array = gltf_array(g, g->root, &g->top, "animations", false);
    const struct at *at = AT_KEY(&g->top, "animations");
    struct last_channel *last =
        gltf_count(array) ? gltf_scratch(g, (uint64_t)g->node_count * PATH_COUNT, sizeof *last) : NULL;
    for (uint32_t i = 0; i < gltf_count(array) && g->result == FNL_OK; i++) {
        struct scene_animation animation = {.name = ""};
        json_t *object = gltf_element(g, array, at, i);
        if (object) load_animation(g, object, AT_INDEX(at, i), last, &animation);
        if (!array_push(g->host, &g->scene->animations, animation)) gltf_fail_memory(g);
        gltf_step(g);
    }
}
