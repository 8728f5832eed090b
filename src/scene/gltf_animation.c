/* SPDX-License-Identifier: MIT */
/* Animations (glTF 2.0, 3.11). */
#include "scene/gltf.h"

enum { PATH_COUNT = SCENE_PATH_WEIGHTS + 1 };

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

/** Translation and scale are floats; rotations and weights may be normalised integers. */
static bool output_format_good(const struct gltf_accessor *accessor, enum scene_animation_path path) {
    static const enum gltf_type types[] = {GLTF_VEC3, GLTF_VEC4, GLTF_VEC3, GLTF_SCALAR};
    bool may_be_integer = path == SCENE_PATH_ROTATION || path == SCENE_PATH_WEIGHTS;
    return accessor->type == types[path] && (accessor->component == GLTF_FLOAT || (may_be_integer && accessor->normalized));
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

static const float *load_values(struct gltf *g, const struct sampler *sampler, const struct scene_channel *channel,
                                const struct at *at, const struct at *output_at) {
    const struct gltf_accessor *accessor = &g->accessors[sampler->output];
    char format[64];
    if (!gltf_accessor_readable(g, sampler->output, at)) return NULL;
    if (!output_format_good(accessor, channel->path)) {
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
    if (channel->path == SCENE_PATH_ROTATION) make_unit(g, output_at, channel, values);
    return values;
}

/** KHR_animation_pointer replaces the target's node; the channel cannot be played, but its syntax is checked. */
static void warn_pointer(struct gltf *g, json_t *target, const struct at *at) {
    struct gltf_extension_place place;
    json_t *extension = gltf_extension(target, at, "KHR_animation_pointer", &place);
    if (!extension) return;
    const char *pointer = gltf_string(g, extension, &place.extension, "pointer", true);
    if (pointer && *pointer && *pointer != '/')
        gltf_warn(g, AT_KEY(&place.extension, "pointer"), "'%.100s' is no JSON pointer; the channel is left out", pointer);
    else if (pointer)
        gltf_warn(g, &place.extension, "is not supported; the animation of '%.100s' is left out", pointer);
}

/** The channel of the present animation that last moved a property of a node. */
struct last_channel {
    uint32_t animation, channel; /* numbers from 1 on; 0: none */
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

static bool load_target(struct gltf *g, json_t *object, const struct at *at, struct scene_channel *channel) {
    json_t *target = gltf_object(g, object, at, "target", true);
    if (!target) return false;
    const struct at *here = AT_KEY(at, "target");
    warn_pointer(g, target, here);
    channel->node = gltf_index(g, target, here, "node", false, g->node_count);
    const char *path = gltf_string(g, target, here, "path", true);
    if (!path || (channel->node == SCENE_NONE && strcmp(path, "pointer") == 0)) return false;
    if (!parse_path(path, &channel->path)) {
        gltf_warn(g, AT_KEY(here, "path"), "is unknown; the channel is left out");
        return false;
    }
    if (channel->node == SCENE_NONE) return false; /* allowed: there is nothing to move */
    const struct scene_node *node = &g->scene->nodes.data[channel->node];
    channel->width = channel->path == SCENE_PATH_ROTATION ? 4 : 3;
    if (channel->path == SCENE_PATH_WEIGHTS) {
        channel->width = node->mesh == SCENE_NONE ? 0 : g->scene->meshes.data[node->mesh].morph_target_count;
        if (channel->width == 0)
            gltf_warn(g, AT_KEY(here, "path"), "node %u has no morph targets; the channel is left out", channel->node);
        return channel->width > 0;
    }
    if (node->has_matrix)
        gltf_warn(g, AT_KEY(here, "path"), "node %u has a matrix, which cannot be animated; the channel is left out",
                  channel->node);
    return !node->has_matrix;
}

static bool load_channel(struct gltf *g, json_t *object, const struct at *at, const struct sampler *samplers,
                         uint32_t sampler_count, struct last_channel *last, uint32_t animation,
                         struct scene_channel *channel) {
    uint32_t index = gltf_index(g, object, at, "sampler", true, sampler_count);
    bool good = load_target(g, object, at, channel);
    if (good)
        check_duplicate(g, at, &last[(size_t)channel->node * PATH_COUNT + channel->path], animation,
                        (uint32_t)at->index);
    if (!good || index == SCENE_NONE || !samplers[index].valid) return false;
    channel->interpolation = samplers[index].interpolation;
    channel->key_count = samplers[index].key_count;
    channel->times = samplers[index].times;
    const struct at *samplers_at = AT_KEY(at->parent->parent, "samplers"), *sampler_at = AT_INDEX(samplers_at, index);
    channel->values =
        load_values(g, &samplers[index], channel, AT_KEY(at, "sampler"), AT_KEY(sampler_at, "output"));
    return channel->values != NULL;
}

static void load_animation(struct gltf *g, json_t *object, const struct at *at, struct last_channel *last,
                           struct scene_animation *animation) {
    animation->name = gltf_name(g, object, at);
    animation->extras = gltf_extras(g, object);
    json_t *samplers = gltf_array(g, object, at, "samplers", true), *channels = gltf_array(g, object, at, "channels", true);
    uint32_t sampler_count = gltf_count(samplers), channel_count = gltf_count(channels);
    struct sampler *loaded = gltf_scratch(g, sampler_count, sizeof *loaded);
    struct scene_channel *kept = loaded ? gltf_keep(g, channel_count, sizeof *kept) : NULL;
    if (!kept) return;
    const struct at *samplers_at = AT_KEY(at, "samplers"), *channels_at = AT_KEY(at, "channels");
    for (uint32_t i = 0; i < sampler_count && g->result == FNL_OK; i++) {
        json_t *sampler = gltf_element(g, samplers, samplers_at, i);
        if (sampler) load_sampler(g, sampler, AT_INDEX(samplers_at, i), &loaded[i]);
    }
    animation->channels = kept;
    for (uint32_t i = 0; i < channel_count && g->result == FNL_OK; i++) {
        struct scene_channel channel = {0};
        json_t *channel_object = gltf_element(g, channels, channels_at, i);
        if (!channel_object || !load_channel(g, channel_object, AT_INDEX(channels_at, i), loaded, sampler_count, last,
                                             (uint32_t)at->index, &channel))
            continue;
        kept[animation->channel_count++] = channel;
        animation->duration = fmaxf(animation->duration, channel.times[channel.key_count - 1]);
    }
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
