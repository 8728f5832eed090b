/* SPDX-License-Identifier: MIT */
/* Animated properties of materials, lights, cameras and environments (KHR_animation_pointer). */
#include "scene/scene.h"

static void *at_offset(void *object, const struct scene_property *property) { return (char *)object + property->offset; }

/* Within the property's limits, NaN too. Whether they are new. */
static bool store(float *to, const struct scene_channel *channel, const float *values) {
    const struct scene_property *property = channel->property;
    bool differs = false;
    for (uint32_t i = 0; i < channel->width; i++) {
        float value = fminf(fmaxf(values[i], property->low), property->high);
        if (property->effect == SCENE_EFFECT_IOR && value > 0) value = fmaxf(value, 1);
        if (property->effect == SCENE_EFFECT_EXTENT) value = fmaxf(2 * fabsf(value), 1e-6f);
        differs |= to[i] != value;
        to[i] = value;
    }
    return differs;
}

static void set_material(struct scene_material *material, const struct scene_channel *channel, const float *values) {
    const struct scene_property *property = channel->property;
    bool differs = store(at_offset(material, property), channel, values);
    if (property->effect == SCENE_EFFECT_EMISSIVE) {
        const vec3 before = material->emissive;
        material->emissive = vec3_scale(material->parts.emissive, material->parts.emissive_strength);
        differs |= memcmp(&before, &material->emissive, sizeof before) != 0;
    } else if (property->effect == SCENE_EFFECT_TURN) {
        struct scene_texture *texture = &material->textures[property->slot];
        const struct scene_texture before = *texture;
        scene_turn_texture(texture, &material->parts.turns[property->slot]);
        differs |= memcmp(before.transform, texture->transform, sizeof before.transform) != 0;
    }
    material->animated |= differs;
}

static struct scene_light *light_of(fnl_scene *scene, const struct scene_channel *channel) {
    struct scene_light *light = &scene->lights.data[channel->object];
    return light->removed || light->generation != channel->generation ? NULL : light;
}

void animation_set_property(fnl_scene *scene, const struct scene_channel *channel, const float *values) {
    const struct scene_property *property = channel->property;
    if (property->owner == SCENE_PROPERTY_MATERIAL) {
        set_material(&scene->materials.data[channel->object], channel, values);
    } else if (property->owner == SCENE_PROPERTY_LIGHT) {
        struct scene_light *light = light_of(scene, channel);
        if (light) light->animated |= store(at_offset(&light->params, property), channel, values);
    } else if (property->owner == SCENE_PROPERTY_ENVIRONMENT) {
        struct scene_environment *e = &scene->environment;
        const bool shown = e->panorama.width > 0 && e->own.light != SCENE_NONE && e->own.light == channel->object;
        if (shown) e->animated |= store(at_offset(&e->own, property), channel, values);
    } else {
        store(at_offset(&scene->cameras.data[channel->object].camera, property), channel, values);
    }
}

/* What several channels set together is mended after all of them. */
static void finish_light(fnl_scene *scene, const struct scene_channel *channel) {
    struct scene_light *light = light_of(scene, channel);
    if (!light || !light->animated) return;
    light->animated = false;
    light->params.inner_cone_angle = fminf(light->params.inner_cone_angle, light->params.outer_cone_angle);
    scene_light_changed(scene, channel->object);
}

static void finish_camera(fnl_camera *camera) {
    if (!camera->orthographic) return;
    if (!(camera->near_distance < camera->far_distance)) camera->near_distance = 0.999f * camera->far_distance;
}

fnl_result animation_finish_properties(fnl_scene *scene, const struct scene_animation *animation) {
    bool any = false;
    for (uint32_t i = 0; i < animation->channel_count; i++) {
        const struct scene_channel *channel = &animation->channels[i];
        if (!channel->property) continue;
        if (channel->property->owner == SCENE_PROPERTY_LIGHT) finish_light(scene, channel);
        if (channel->property->owner == SCENE_PROPERTY_CAMERA) finish_camera(&scene->cameras.data[channel->object].camera);
        if (channel->property->owner == SCENE_PROPERTY_MATERIAL) any |= scene->materials.data[channel->object].animated;
    }
    if (scene->environment.animated) scene_environment_moved(scene);
    if (!any) return FNL_OK;
    scene_materials_changed(scene);
    fnl_result result = FNL_OK;
    for (uint32_t i = 0; i < animation->channel_count; i++) {
        const struct scene_channel *channel = &animation->channels[i];
        if (!channel->property || channel->property->owner != SCENE_PROPERTY_MATERIAL) continue;
        const struct scene_material material = scene->materials.data[channel->object];
        if (!material.animated) continue;
        scene->materials.data[channel->object].animated = false;
        if (result == FNL_OK) result = scene_repaint(scene, channel->object, &material);
    }
    return result;
}
