/* SPDX-License-Identifier: MIT */
/** Calls on a scene after the bytes of an input, with ids that are good, removed, or made up, beside a model of what must come of them. */
#ifndef FNL_FUZZ_CALLS_H
#define FNL_FUZZ_CALLS_H

#include "scene/scene.h"
#include "tests/fuzz/fuzz.h"

enum { CALLS_IDS = 32 };

/** Ids of one kind: the newest, and whether they are alive. */
struct calls_ids {
    struct {
        uint32_t index, generation;
        bool alive;
    } ids[CALLS_IDS];
    uint32_t count, alive_count;
};

struct calls {
    struct calls_ids images, materials, meshes, instances, lights, decals;
};

/* A macro, so that the stack of a failure names the line. */
#define EXPECT(condition)                                                                                                   \
    do {                                                                                                                    \
        if (!(condition)) abort();                                                                                          \
    } while (0)

static inline void calls_added(struct calls_ids *to, uint32_t index, uint32_t generation) {
    EXPECT(generation != 0);
    to->alive_count++;
    if (to->count == CALLS_IDS) return; /* alive, and never spoken of again */
    to->ids[to->count].index = index;
    to->ids[to->count].generation = generation;
    to->ids[to->count++].alive = true;
}

/** Picks an id; returns whether it is alive. `*slot` is CALLS_IDS for a made-up one. */
static inline bool calls_pick(struct fuzz_input *in, const struct calls_ids *from, uint32_t *index, uint32_t *generation,
                              uint32_t *slot) {
    uint8_t which = fuzz_byte(in);
    *slot = CALLS_IDS;
    *index = *generation = 0;
    if (which >= 240) { /* any bits: it may even be right */
        *index = fuzz_u32(in);
        *generation = fuzz_u32(in);
        for (uint32_t i = 0; i < from->count; i++)
            if (from->ids[i].index == *index && from->ids[i].generation == *generation) *slot = i;
    } else if (which < 230 && from->count) {
        *slot = which % from->count;
        *index = from->ids[*slot].index;
        *generation = from->ids[*slot].generation;
    }
    return *slot < CALLS_IDS && from->ids[*slot].alive;
}

static inline void calls_removed(struct calls_ids *from, uint32_t slot) {
    from->ids[slot].alive = false;
    from->alive_count--;
}

/** The result of a call that names an id: a bad one must be refused. An id of `tracked` false may be alive unknown to the model. */
static inline void calls_check(fnl_result result, bool alive, uint32_t slot, const struct calls_ids *ids) {
    bool known = slot < CALLS_IDS || ids->count < CALLS_IDS;
    if (!alive && known) EXPECT(result != FNL_OK);
}

static inline fnl_image_id calls_image(struct fuzz_input *in, const struct calls *c) {
    fnl_image_id id;
    uint32_t slot;
    calls_pick(in, &c->images, &id.index, &id.generation, &slot);
    return id;
}

static inline fnl_light_params calls_light(struct fuzz_input *in) {
    fnl_light_params p = fnl_light_params_default();
    p.kind = (fnl_light_kind)(fuzz_byte(in) % (FNL_LIGHT_KIND_COUNT + 1));
    p.position = fuzz_vec3(in);
    uint8_t changes = fuzz_byte(in);
    if (changes & 1) p.direction = fuzz_vec3(in);
    if (changes & 2) fuzz_floats(in, p.color, 3);
    if (changes & 4) p.intensity = fuzz_float(in);
    if (changes & 8) p.range = fuzz_float(in);
    if (changes & 16) p.inner_cone_angle = fuzz_float(in), p.outer_cone_angle = fuzz_float(in);
    if (changes & 32) p.up = fuzz_vec3(in), p.length = fuzz_float(in);
    if (changes & 64) fuzz_floats(in, p.wedge_angles, 2), p.inner_fraction = fuzz_float(in);
    if (changes & 64) fuzz_floats(in, p.rectangle_size, 2), p.two_sided = true, p.shadow_update = (fnl_shadow_update)(fuzz_byte(in) % (FNL_SHADOW_UPDATE_COUNT + 1));
    if (changes & 128) p.box_size = fuzz_vec3(in), p.casts_shadows = false, p.source_radius = p.source_angle = fuzz_float(in);
    return p;
}

static inline fnl_mat4 calls_matrix(struct fuzz_input *in) {
    fnl_mat4 m = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};
    for (uint8_t count = fuzz_byte(in) % 16; count > 0; count--) {
        uint8_t at = fuzz_byte(in);
        m.m[at % 16] = fuzz_float(in);
    }
    return m;
}

static inline fnl_decal_params calls_decal(struct fuzz_input *in, const struct calls *c, bool *good_instance) {
    fnl_decal_params p = fnl_decal_params_default();
    uint32_t slot;
    p.kind = (fnl_decal_kind)(fuzz_byte(in) % (FNL_DECAL_KIND_COUNT + 1));
    p.transform = calls_matrix(in);
    uint8_t changes = fuzz_byte(in);
    *good_instance = calls_pick(in, &c->instances, &p.instance.index, &p.instance.generation, &slot);
    if (changes & 1) fuzz_floats(in, p.color, 4);
    if (changes & 2) p.metallic = fuzz_float(in), p.roughness = fuzz_float(in), p.normal_scale = fuzz_float(in);
    if (changes & 4) fuzz_floats(in, p.emissive, 3);
    if (changes & 8) p.color_image = calls_image(in, c), p.normal_image = calls_image(in, c);
    if (changes & 16) p.metallic_roughness_image = calls_image(in, c), p.emissive_image = calls_image(in, c);
    if (changes & 32) p.channels = fuzz_byte(in), p.blend = (fnl_decal_blend)(fuzz_byte(in) % (FNL_DECAL_BLEND_COUNT + 1));
    if (changes & 64) p.fade_start = fuzz_float(in), p.fade_end = fuzz_float(in), p.sort_key = (int32_t)fuzz_u32(in);
    if (changes & 128) p.cut = fuzz_float(in), p.slices = fuzz_byte(in), p.distance_field = fuzz_byte(in) & 1, p.receivers = fuzz_byte(in);
    return p;
}

static inline void calls_add_image(struct fuzz_input *in, fnl_scene *scene, struct calls *c) {
    uint8_t pixels[16 * 16 * 4];
    fnl_image image = {fuzz_byte(in) % 17, fuzz_byte(in) % 17, FNL_PIXEL_FORMAT_RGBA8, pixels};
    fuzz_take(in, pixels, MIN(sizeof pixels, (size_t)64));
    for (size_t i = 64; i < sizeof pixels; i++) pixels[i] = pixels[i - 64];
    fnl_image_id id;
    fnl_result result = fnl_scene_add_image(scene, &image, fuzz_byte(in) & 1, &id);
    EXPECT((result == FNL_OK) == (image.width && image.height));
    if (result == FNL_OK) calls_added(&c->images, id.index, id.generation);
}

static inline void calls_add_material(struct fuzz_input *in, fnl_scene *scene, struct calls *c) {
    fnl_material_params p = fnl_material_params_default();
    uint8_t changes = fuzz_byte(in);
    if (changes & 1) fuzz_floats(in, p.base_color, 4);
    if (changes & 2) p.metallic = fuzz_float(in), p.roughness = fuzz_float(in), p.ior = fuzz_float(in);
    if (changes & 4) fuzz_floats(in, p.emissive, 3);
    if (changes & 8) p.normal_scale = fuzz_float(in), p.occlusion_strength = fuzz_float(in), p.specular = fuzz_float(in);
    if (changes & 16) fuzz_floats(in, p.specular_color, 3);
    if (changes & 32) p.alpha_mode = (fnl_alpha_mode)(fuzz_byte(in) % 4), p.alpha_cutoff = fuzz_float(in);
    if (changes & 64) p.base_color_image = calls_image(in, c), p.normal_image = calls_image(in, c);
    if (changes & 128) p.metallic_roughness_image = calls_image(in, c), p.emissive_image = calls_image(in, c);
    p.double_sided = changes & 1;
    fnl_material_id id;
    if (fnl_scene_add_material(scene, &p, &id) == FNL_OK) calls_added(&c->materials, id.index, id.generation);
}

static inline void calls_add_mesh(struct fuzz_input *in, fnl_scene *scene, struct calls *c) {
    enum { VERTICES_MAX = 12 };
    float positions[3 * VERTICES_MAX], normals[3 * VERTICES_MAX], tangents[4 * VERTICES_MAX], uv[2 * VERTICES_MAX];
    uint32_t indices[VERTICES_MAX], slot, count = fuzz_byte(in) % (VERTICES_MAX + 1);
    uint8_t has = fuzz_byte(in);
    fuzz_floats(in, positions, 3 * count);
    fnl_mesh_params p = {.vertex_count = count, .positions = has & 1 && has & 2 ? NULL : positions};
    if (has & 4) p.normals = normals, fuzz_floats(in, normals, 3 * count);
    if (has & 8) p.tangents = tangents, fuzz_floats(in, tangents, 4 * count);
    if (has & 16) p.uv = uv, fuzz_floats(in, uv, 2 * count);
    if (has & 32) {
        p.indices = indices;
        p.index_count = fuzz_byte(in) % (VERTICES_MAX + 1);
        for (uint32_t i = 0; i < p.index_count; i++) indices[i] = fuzz_byte(in) % (VERTICES_MAX + 2);
    }
    bool no_material = has & 64;
    bool good = no_material || calls_pick(in, &c->materials, &p.material.index, &p.material.generation, &slot);
    bool zero = p.material.index == 0 && p.material.generation == 0;
    fnl_mesh_id id;
    if (has & 128) {
        bool alive = calls_pick(in, &c->meshes, &id.index, &id.generation, &slot);
        calls_check(fnl_scene_set_mesh(scene, id, 0, &p), alive, slot, &c->meshes);
        return;
    }
    fnl_result result = fnl_scene_add_mesh(scene, &p, &id);
    if (!good && !zero && c->materials.count < CALLS_IDS) EXPECT(result != FNL_OK);
    if (!p.positions || count == 0) EXPECT(result != FNL_OK);
    for (uint32_t i = 0; i < 3 * count && p.positions; i++)
        if (!isfinite(positions[i])) EXPECT(result != FNL_OK);
    if (result == FNL_OK) calls_added(&c->meshes, id.index, id.generation);
}

static inline void calls_on_instance(struct fuzz_input *in, fnl_scene *scene, struct calls *c, uint8_t what) {
    fnl_instance_id id;
    uint32_t slot;
    if (what == 0) {
        fnl_mesh_id mesh;
        bool alive = calls_pick(in, &c->meshes, &mesh.index, &mesh.generation, &slot);
        fnl_mat4 m = calls_matrix(in);
        fnl_result result = fnl_scene_add_instance(scene, mesh, &m, &id);
        calls_check(result, alive, slot, &c->meshes);
        if (result == FNL_OK) calls_added(&c->instances, id.index, id.generation);
        return;
    }
    bool alive = calls_pick(in, &c->instances, &id.index, &id.generation, &slot);
    if (what == 1) {
        fnl_mat4 m = calls_matrix(in);
        calls_check(fnl_scene_set_instance_transform(scene, id, &m), alive, slot, &c->instances);
        const fnl_instance_id twice[2] = {id, id};
        const fnl_mat4 moves[2] = {calls_matrix(in), m};
        calls_check(fnl_scene_set_instance_transforms(scene, twice, moves, 2), alive, slot, &c->instances);
    } else if (what == 2) {
        calls_check(fnl_scene_set_instance_receivers(scene, id, fuzz_byte(in)), alive, slot, &c->instances);
    } else {
        fnl_result result = fnl_scene_remove_instance(scene, id);
        calls_check(result, alive, slot, &c->instances);
        if (result == FNL_OK && slot < CALLS_IDS) calls_removed(&c->instances, slot);
    }
}

static inline void calls_on_light(struct fuzz_input *in, fnl_scene *scene, struct calls *c, uint8_t what) {
    fnl_light_id id;
    uint32_t slot;
    if (what == 0) {
        fnl_light_params p = calls_light(in);
        fnl_result result = fnl_scene_add_light(scene, &p, &id);
        if (p.kind >= FNL_LIGHT_KIND_COUNT || !isfinite(p.intensity) || p.intensity < 0) EXPECT(result != FNL_OK);
        if (result == FNL_OK) calls_added(&c->lights, id.index, id.generation);
        return;
    }
    bool alive = calls_pick(in, &c->lights, &id.index, &id.generation, &slot);
    if (what == 1) {
        fnl_light_params p = calls_light(in);
        calls_check(fnl_scene_set_light(scene, id, &p), alive, slot, &c->lights);
        const fnl_light_id twice[2] = {id, id};
        const fnl_light_params both[2] = {calls_light(in), p};
        calls_check(fnl_scene_set_lights(scene, twice, both, 2), alive, slot, &c->lights);
    } else if (what == 2) {
        fnl_vec3 points[8];
        uint32_t count = fuzz_byte(in) % 9;
        for (uint32_t i = 0; i < count; i++) points[i] = fuzz_vec3(in);
        calls_check(fnl_scene_set_light_hull(scene, id, points, count), alive, slot, &c->lights);
    } else {
        fnl_result result = fnl_scene_remove_light(scene, id);
        calls_check(result, alive, slot, &c->lights);
        if (alive) EXPECT(result == FNL_OK);
        if (result == FNL_OK && slot < CALLS_IDS) calls_removed(&c->lights, slot);
    }
}

static inline void calls_on_decal(struct fuzz_input *in, fnl_scene *scene, struct calls *c, uint8_t what) {
    fnl_decal_id id;
    uint32_t slot;
    bool good_instance;
    if (what == 0) {
        fnl_decal_params p = calls_decal(in, c, &good_instance);
        fnl_result result = fnl_scene_add_decal(scene, &p, &id);
        if (result == FNL_OK) calls_added(&c->decals, id.index, id.generation);
        return;
    }
    bool alive = calls_pick(in, &c->decals, &id.index, &id.generation, &slot);
    if (what == 1) {
        fnl_decal_params p = calls_decal(in, c, &good_instance);
        calls_check(fnl_scene_set_decal(scene, id, &p), alive, slot, &c->decals);
    } else {
        fnl_result result = fnl_scene_remove_decal(scene, id);
        calls_check(result, alive, slot, &c->decals);
        if (result == FNL_OK && slot < CALLS_IDS) calls_removed(&c->decals, slot);
    }
}

static inline void calls_on_scene(struct fuzz_input *in, fnl_scene *scene, uint8_t what) {
    fnl_camera camera = fnl_camera_default();
    double seconds = (double)fuzz_float(in);
    switch (what) {
    case 0:
        fnl_scene_set_time(scene, fuzz_byte(in) % 4, seconds);
        return;
    case 1: {
        fnl_vec3 sky = fuzz_vec3(in);
        fnl_scene_set_ambient(scene, sky, fuzz_vec3(in));
        return;
    }
    case 2:
        fnl_scene_set_background(scene, fuzz_vec3(in));
        return;
    case 3:
        fnl_scene_set_anisotropy(scene, (float)seconds);
        return;
    case 4:
        fnl_scene_set_light_cutoff(scene, (float)seconds, fuzz_float(in));
        return;
    case 5:
        fnl_scene_grow_metal(scene, fuzz_byte(in) % 8);
        return;
    case 6:
        fnl_scene_select_variant(scene, (uint32_t)fuzz_byte(in) % 5 - 1);
        return;
    default:
        camera.position = fuzz_vec3(in);
        camera.target = fuzz_vec3(in);
        camera.vertical_fov = fuzz_float(in);
        camera.near_distance = fuzz_float(in);
        fnl_scene_add_camera(scene, fuzz_byte(in) & 1 ? "a" : NULL, &camera);
        return;
    }
}

/** One call. */
static inline void calls_make(struct fuzz_input *in, fnl_scene *scene, struct calls *c) {
    uint8_t call = fuzz_byte(in);
    switch (call % 8) {
    case 0:
        calls_add_image(in, scene, c);
        return;
    case 1:
        calls_add_material(in, scene, c);
        return;
    case 2:
        calls_add_mesh(in, scene, c);
        return;
    case 3:
    case 4:
        calls_on_instance(in, scene, c, call / 8 % 4);
        return;
    case 5:
        calls_on_light(in, scene, c, call / 8 % 4);
        return;
    case 6:
        calls_on_decal(in, scene, c, call / 8 % 3);
        return;
    default:
        calls_on_scene(in, scene, call / 8 % 8);
        return;
    }
}

/** What the scene says of itself, beside the model; `lights` were there before the calls. */
static inline void calls_check_scene(const fnl_scene *scene, const struct calls *c, uint32_t lights) {
    fnl_scene_info info;
    EXPECT(fnl_scene_query_info(scene, &info) == FNL_OK);
    if (c->lights.count < CALLS_IDS) EXPECT(info.light_count == lights + c->lights.alive_count);
    for (uint32_t i = 0; i < info.light_count; i++) {
        fnl_light_params p;
        EXPECT(fnl_scene_query_light(scene, i, &p) == FNL_OK);
        EXPECT(isfinite(p.intensity) && p.intensity >= 0 && vec3_finite(p.position));
        if (p.kind != FNL_LIGHT_DIRECTIONAL && p.kind != FNL_LIGHT_BOX) EXPECT(p.range > 0); /* the others have none */
    }
    fnl_camera camera;
    fnl_result framed = fnl_scene_query_framing_camera(scene, 1.5f, &camera);
    if (framed == FNL_OK)
        EXPECT(vec3_finite(camera.position) && camera.near_distance > 0);
}

#endif
