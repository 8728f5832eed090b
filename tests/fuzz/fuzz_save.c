/* SPDX-License-Identifier: MIT */
/* fnl_scene_save: a file that can be loaded, with a light and a place changed or not, is saved as a file that loads as an equal scene, twice. */
#include "scene/scene.h"
#include "tests/fuzz/fuzz.h"

/* A macro, so that the stack of a failure names the line. */
#define SAME(condition)                                                                                                     \
    do {                                                                                                                    \
        if (!(condition)) abort();                                                                                          \
    } while (0)

static bool left_out; /* the saver says what a file cannot hold */

static void take_line(void *user, fnl_log_level level, const char *line) {
    UNUSED(user);
    UNUSED(level);
    left_out |= strstr(line, "left out") != NULL;
}

static bool same_bytes(const void *a, const void *b, size_t size) { return !a == !b && (!a || memcmp(a, b, size) == 0); }
static bool same_text(const char *a, const char *b) { return !a == !b && (!a || strcmp(a, b) == 0); }

static void compare_primitive(const struct scene_primitive *a, const struct scene_primitive *b) {
    const size_t count = a->vertex_count;
    SAME(a->vertex_count == b->vertex_count && a->index_count == b->index_count && a->material == b->material && a->topology == b->topology);
    SAME(a->joint_count == b->joint_count && a->morph_target_count == b->morph_target_count && a->mapping_count == b->mapping_count);
    SAME(same_bytes(a->indices, b->indices, a->index_count * sizeof *a->indices));
    SAME(same_bytes(a->positions, b->positions, count * sizeof *a->positions));
    SAME(same_bytes(a->normals, b->normals, count * sizeof *a->normals));
    SAME(same_bytes(a->tangents, b->tangents, count * sizeof *a->tangents));
    for (int i = 0; i < 2; i++) SAME(same_bytes(a->uv[i], b->uv[i], count * sizeof *a->uv[i]));
    SAME(same_bytes(a->colors, b->colors, count * sizeof *a->colors));
    SAME(same_bytes(a->joints, b->joints, count * a->joint_count * sizeof *a->joints));
    SAME(same_bytes(a->weights, b->weights, count * a->joint_count * sizeof *a->weights));
    for (uint32_t i = 0; i < a->morph_target_count; i++) SAME(same_bytes(a->morph_targets[i].positions, b->morph_targets[i].positions, count * sizeof(vec3)));
}

static void compare_material(const struct scene_material *a, const struct scene_material *b) {
    SAME(same_text(a->name, b->name) && same_text(a->extras, b->extras));
    SAME(memcmp(&a->base_color, &b->base_color, offsetof(struct scene_material, alpha_mode) - offsetof(struct scene_material, base_color)) == 0);
    SAME(a->alpha_mode == b->alpha_mode && a->alpha_cutoff == b->alpha_cutoff && a->double_sided == b->double_sided);
    SAME(a->unlit == b->unlit && a->casts_shadows == b->casts_shadows);
    SAME(a->clearcoat.strength == b->clearcoat.strength && a->clearcoat.roughness == b->clearcoat.roughness);
    SAME(memcmp(a->sheen.color, b->sheen.color, sizeof a->sheen.color) == 0 && a->iridescence.strength == b->iridescence.strength);
    SAME(a->anisotropy.strength == b->anisotropy.strength && a->transmission.strength == b->transmission.strength);
    SAME(a->volume.thickness == b->volume.thickness && a->dispersion == b->dispersion && a->diffuse_transmission.strength == b->diffuse_transmission.strength);
    for (int i = 0; i < SCENE_TEXTURE_SLOT_COUNT; i++) {
        const struct scene_texture *s = &a->textures[i], *t = &b->textures[i];
        SAME(s->image == t->image);
        if (s->image != SCENE_NONE) SAME(s->sampler == t->sampler && s->uv_set == t->uv_set && memcmp(s->transform, t->transform, sizeof s->transform) == 0);
    }
}

static void compare_node(const struct scene_node *a, const struct scene_node *b) {
    SAME(same_text(a->name, b->name) && same_text(a->extras, b->extras) && a->parent == b->parent && a->mesh == b->mesh && a->skin == b->skin);
    SAME(a->camera == b->camera && a->hidden == b->hidden && a->active == b->active && a->instance_count == b->instance_count);
    SAME(memcmp(&a->local_exact, &b->local_exact, sizeof a->local_exact) == 0 && memcmp(&a->world, &b->world, sizeof a->world) == 0);
    SAME(same_bytes(a->instances, b->instances, a->instance_count * sizeof *a->instances));
}

static void compare_animation(const struct scene_animation *a, const struct scene_animation *b) {
    SAME(same_text(a->name, b->name) && a->channel_count == b->channel_count && a->duration == b->duration);
    for (uint32_t i = 0; i < a->channel_count; i++) {
        const struct scene_channel *c = &a->channels[i], *d = &b->channels[i];
        SAME(c->node == d->node && c->path == d->path && c->interpolation == d->interpolation && c->key_count == d->key_count && c->width == d->width);
        const size_t values = (size_t)c->key_count * c->width * (c->interpolation == SCENE_INTERPOLATION_CUBIC ? 3 : 1);
        SAME(same_bytes(c->times, d->times, c->key_count * sizeof *c->times) && same_bytes(c->values, d->values, values * sizeof *c->values));
    }
}

static void compare_light(const fnl_light_params *a, const fnl_light_params *b) {
    SAME(a->kind == b->kind && memcmp(a->color, b->color, sizeof a->color) == 0 && a->intensity == b->intensity && a->range == b->range);
    SAME(a->casts_shadows == b->casts_shadows);
    if (a->kind != FNL_LIGHT_DIRECTIONAL) SAME(memcmp(&a->position, &b->position, sizeof a->position) == 0);
    if (a->kind != FNL_LIGHT_POINT) SAME(memcmp(&a->direction, &b->direction, sizeof a->direction) == 0);
    if (a->kind == FNL_LIGHT_SPOT) SAME(a->inner_cone_angle == b->inner_cone_angle && a->outer_cone_angle == b->outer_cone_angle);
}

/* `more`: a light without a node has got one. */
static void compare(const fnl_scene *a, const fnl_scene *b, uint32_t more) {
    SAME(a->nodes.count + more == b->nodes.count && a->meshes.count == b->meshes.count && a->primitives.count == b->primitives.count);
    SAME(a->materials.count == b->materials.count && a->images.count == b->images.count && a->samplers.count == b->samplers.count);
    SAME(a->skins.count == b->skins.count && a->animations.count == b->animations.count && a->cameras.count == b->cameras.count);
    SAME(a->variants.count == b->variants.count && fnl_scene_count(a, FNL_ENTITY_LIGHT) == fnl_scene_count(b, FNL_ENTITY_LIGHT));
    SAME(memcmp(&a->ambient_sky, &b->ambient_sky, 3 * sizeof a->ambient_sky) == 0);
    for (uint32_t i = 0; i < a->primitives.count; i++) compare_primitive(&a->primitives.data[i], &b->primitives.data[i]);
    for (uint32_t i = 0; i < a->materials.count; i++) compare_material(&a->materials.data[i], &b->materials.data[i]);
    /* What levels of detail by material are made of stands behind the file's own, and so behind what was added. */
    for (uint32_t i = 0; i < a->nodes.count && !(more && a->levels.count); i++) compare_node(&a->nodes.data[i], &b->nodes.data[i]);
    for (uint32_t i = 0; i < a->animations.count; i++) compare_animation(&a->animations.data[i], &b->animations.data[i]);
    for (uint32_t i = 0; i < a->images.count; i++) {
        const struct scene_image *s = &a->images.data[i], *t = &b->images.data[i];
        SAME(s->encoded_size == t->encoded_size && same_bytes(s->encoded, t->encoded, s->encoded_size));
    }
    for (uint32_t i = 0; i < fnl_scene_count(a, FNL_ENTITY_LIGHT); i++) {
        fnl_light_params p, q;
        SAME(fnl_scene_query_light(a, i, &p) == FNL_OK && fnl_scene_query_light(b, i, &q) == FNL_OK);
        compare_light(&p, &q);
    }
}

static void change(fnl_scene *scene) {
    const mat4 place = {{0, 0, -2, 0, 0, 1, 0, 0, 0.5f, 0, 0, 0, 3, 4, 5, 1}};
    fnl_light_params light = fnl_light_params_default();
    fnl_light_id id;
    light.position = vec3_make(1, 2, 3);
    light.direction = vec3_make(0, -1, 0);
    light.range = 4;
    if (fnl_scene_add_light(scene, &light, &id) != FNL_OK) abort();
    for (uint32_t i = 0; i < scene->nodes.count; i++)
        if (scene->nodes.data[i].mesh != SCENE_NONE && scene->animations.count == 0) {
            fnl_scene_set_instance_transform(scene, (fnl_instance_id){i, scene->nodes.data[i].generation}, &place);
            break;
        }
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    fnl_host host = host_resolve(&(fnl_host){.log = take_line});
    fnl_load_params params = fnl_load_params_default();
    char path[320];
    fnl_scene *scene, *again;
    params.data = bytes;
    params.size = size;
    params.lenient = size % 2;
    params.max_memory = (uint64_t)64 << 20;
    if (fnl_scene_load(&host, "input", &params, &scene) != FNL_OK) return 0;
    params.data = NULL;
    params.size = 0;
    params.max_memory *= 2; /* what was stored packed or shared may be written plain */
    const bool changed = size / 2 % 2;
    if (changed) change(scene);
    for (int round = 0; round < 2; round++) {
        snprintf(path, sizeof path, "%s/saved%d.glb", fuzz_folder(), round);
        left_out = false;
        if (fnl_scene_save(scene, path, NULL) != FNL_OK) abort();
        if (fnl_scene_load(&host, path, &params, &again) != FNL_OK) abort();
        if (!left_out) compare(scene, again, changed && round == 0);
        fnl_scene_destroy(&scene);
        scene = again;
    }
    fnl_scene_destroy(&scene);
    return 0;
}
