/* SPDX-License-Identifier: MIT */
/* What stands around a scene that is saved: FNL_surroundings of its glTF scene, which gltf_surroundings.c reads; and what no file can say. */
#include "scene/glb.h"

#include "image/image.h"

#define NAME "FNL_surroundings"

/* The picture as it is stored; it lives until the file is written. */
static bool add_panorama(struct glb *g, json_t *object, const char *path) {
    struct file_view view;
    struct image_file_info info;
    const fnl_result result = file_load(g->host, path, &view);
    if (result != FNL_OK) {
        glb_fail(g, result, "the environment %s cannot be read any more", path);
        return false;
    }
    const char *type = image_peek(g->host, view.data, view.size, path, &info) != FNL_OK ? NULL
                       : info.kind == IMAGE_FILE_HDR                                     ? "image/vnd.radiance"
                       : info.kind == IMAGE_FILE_EXR                                     ? "image/x-exr"
                       : info.kind == IMAGE_FILE_PNG                                     ? "image/png"
                       : info.kind == IMAGE_FILE_JPEG                                    ? "image/jpeg"
                                                                                         : "application/octet-stream";
    void *bytes = type ? glb_memory(g, view.size, 1) : NULL;
    if (!type) glb_fail(g, FNL_ERROR_FORMAT, "the environment %s is no picture any more", path);
    if (bytes) {
        memcpy(bytes, view.data, view.size);
        glb_set(g, object, "bufferView", json_integer((json_int_t)glb_add_view(g, bytes, view.size, 0)));
        glb_set(g, object, "mimeType", json_string(type));
    }
    file_free(g->host, &view);
    return bytes != NULL;
}

static bool same_environment(const struct scene_environment *a, const struct scene_environment *b) {
    return a->version == b->version && a->rotation == b->rotation && a->intensity == b->intensity && a->background == b->background &&
           a->compressed == b->compressed;
}

static void save_environment(struct glb *g) {
    static const struct scene_environment nothing = {0};
    const struct scene_environment *e = g->scene->environment.staged ? &nothing : &g->scene->environment, *before = g->file ? &g->file->environment : &nothing;
    if (same_environment(e, before) || (e->panorama.width == 0 && before->panorama.width == 0)) return;
    glb_remove_extension(glb_shown_scene(g), "EXT_lights_image_based");
    json_t *old = json_object_get(json_object_get(glb_shown_scene(g), "extensions"), NAME);
    json_object_del(old, "environment");
    if (e->panorama.width == 0) return;
    if (!e->name) {
        glb_left_out(g, "the environment, which is not of a file");
        return;
    }
    json_t *object = glb_object(g, glb_extension(g, glb_shown_scene(g), NAME), "environment");
    if (strncmp(e->name, "builtin:", 8) == 0)
        glb_set(g, object, "source", glb_text(g, e->name));
    else if (!add_panorama(g, object, e->name))
        return;
    if (e->rotation != 0) glb_set(g, object, "rotation", glb_float(e->rotation));
    if (e->intensity != 1) glb_set(g, object, "intensity", glb_float(e->intensity));
    if (!e->background) glb_set(g, object, "visible", json_false());
    if (!e->parted) glb_set(g, object, "lights", json_false());
    if (e->compressed) glb_set(g, object, "compressed", json_true());
}

static void save_color(struct glb *g, const char *key, vec3 now, vec3 before) {
    if (memcmp(&now, &before, sizeof now) != 0) glb_set(g, glb_extension(g, glb_shown_scene(g), NAME), key, glb_floats(&now.x, 3));
}

static json_t *probes_of(struct glb *g, const fnl_scene *scene) {
    json_t *array = json_array();
    for (uint32_t i = 0; scene && i < scene->probes.count; i++) {
        const fnl_probe_params *p = &scene->probes.data[i].params;
        if (scene->probes.data[i].removed) continue;
        json_t *object = json_object();
        glb_set(g, object, "centre", glb_doubles(scene->probes.data[i].place, 3));
        glb_set(g, object, "halfSize", glb_floats(&p->half_size.x, 3));
        glb_set(g, object, "rotation", glb_floats(&p->rotation.x, 4));
        glb_set(g, object, "capture", glb_floats(&p->capture.x, 3));
        glb_set(g, object, "wall", glb_float(p->wall));
        glb_set(g, object, "faceSize", json_integer((json_int_t)p->face_size));
        glb_set(g, object, "shadows", json_boolean(p->shadows));
        glb_set(g, object, "softness", glb_float(p->softness));
        glb_set(g, object, "reflection", json_boolean(p->reflection));
        glb_set(g, object, "blend", glb_float(p->blend));
        glb_set(g, object, "priority", json_integer(p->priority));
        glb_set(g, object, "intensity", glb_float(p->intensity));
        if (p->mask != 255) glb_set(g, object, "mask", json_integer((json_int_t)p->mask));
        glb_append(g, array, object);
    }
    return array;
}

static void save_probes(struct glb *g) {
    json_t *now = probes_of(g, g->scene), *before = probes_of(g, g->file);
    if (!json_equal(now, before)) {
        if (json_array_size(now) > 0)
            glb_set(g, glb_extension(g, glb_shown_scene(g), NAME), "probes", json_incref(now));
        else
            json_object_del(json_object_get(json_object_get(glb_shown_scene(g), "extensions"), NAME), "probes");
    }
    json_decref(now);
    json_decref(before);
}

/* Decals by what they are: of a file those that it gave itself are no change. */
static uint32_t other_decals(const struct glb *g) {
    uint32_t count = 0;
    const uint32_t known = g->file ? g->file->decals.count : 0;
    for (uint32_t i = 0; i < MAX(g->scene->decals.count, known); i++) {
        const struct scene_decal *now = i < g->scene->decals.count && !g->scene->decals.data[i].removed ? &g->scene->decals.data[i] : NULL;
        const struct scene_decal *base = i < known ? &g->file->decals.data[i] : NULL;
        const bool same = now && base && now->generation == base->generation && memcmp(&now->params, &base->params, sizeof now->params) == 0;
        count += !same && (now || base);
    }
    return count;
}

void glb_save_surroundings(struct glb *g) {
    const fnl_scene *now = g->scene;
    const vec3 black = {0, 0, 0};
    save_color(g, "ambientSky", now->ambient_sky, g->file ? g->file->ambient_sky : black);
    save_color(g, "ambientGround", now->ambient_ground, g->file ? g->file->ambient_ground : black);
    save_color(g, "background", now->background, g->file ? g->file->background : black);
    save_environment(g);
    save_probes(g);
    const uint32_t decals = other_decals(g);
    if (decals) glb_left_out(g, "%u decals that were added, changed or removed", decals);
    if (now->cutoff_illuminance > 0)
        glb_left_out(g, "how far lights without a range reach (fnl_scene_set_light_cutoff)");
    if (now->anisotropy != 8) glb_left_out(g, "the anisotropy of textures");
}
