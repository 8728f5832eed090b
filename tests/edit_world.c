/* SPDX-License-Identifier: MIT */
#include "tests/edit_world.h"

/* ---- what is in it ---- */

static uint32_t pick(struct world *w, uint32_t count) { return (uint32_t)(random_bits(&w->random) % count); }
static float number(struct world *w, float low, float high) { return random_range(&w->random, low, high); }

static fnl_vec3 place(struct world *w) { return vec3_make(number(w, -2, 2), number(w, -1.2f, 1.2f), number(w, -2, 1)); }

fnl_mat4 world_pose(struct world *w) {
    float size = number(w, 0.2f, 0.6f), mirror = pick(w, 4) ? 1 : -1;
    return mat4_from_trs(place(w), quat_axis_angle(vec3_normalize(place(w)), number(w, 0, 6)),
                         vec3_make(size * mirror, size, size));
}

void world_add_image(struct world *w) {
    enum { SIDE = 16 };
    uint8_t pixels[SIDE * SIDE * 4];
    for (uint32_t i = 0; i < sizeof pixels; i++) pixels[i] = (uint8_t)(i % 4 == 3 ? 255 : 64 + pick(w, 192));
    fnl_image image = {SIDE, SIDE, FNL_PIXEL_FORMAT_RGBA8, pixels};
    assert_int_equal(fnl_scene_add_image(w->stage.scene, &image, true, &w->images[w->image_count++]), FNL_OK);
}

fnl_material_params world_look(struct world *w, bool plain) {
    fnl_material_params look = fnl_material_params_default();
    for (int c = 0; c < 3; c++) look.base_color[c] = number(w, 0.1f, 1);
    look.base_color[3] = plain ? 1 : number(w, 0.3f, 1);
    look.metallic = plain || pick(w, 2) ? 0 : 1;
    look.roughness = number(w, 0.3f, 1);
    look.double_sided = !plain && pick(w, 2);
    look.alpha_mode = plain ? FNL_ALPHA_OPAQUE : (fnl_alpha_mode)pick(w, 3);
    if (!plain && pick(w, 2)) look.base_color_image = w->images[pick(w, w->image_count)];
    return look;
}

/* A bumpy sheet of side * side squares, on both sides where its material is. Free its arrays by world_free_sheet(). */
fnl_mesh_params world_sheet(struct world *w, uint32_t side) {
    uint32_t row = side + 1, vertex_count = row * row, at = 0;
    float *positions = malloc(vertex_count * 12), *uv = malloc(vertex_count * 8);
    uint32_t *indices = malloc(side * side * 24);
    for (uint32_t i = 0; i < vertex_count; i++) {
        uv[2 * i] = (float)(i % row) / (float)side;
        uv[2 * i + 1] = (float)(i / row) / (float)side;
        positions[3 * i] = 2 * uv[2 * i] - 1;
        positions[3 * i + 1] = 2 * uv[2 * i + 1] - 1;
        positions[3 * i + 2] = number(w, -0.2f, 0.2f);
    }
    for (uint32_t i = 0; i < side * side; i++) {
        uint32_t corner = i / side * row + i % side;
        const uint32_t square[] = {corner, corner + 1, corner + row, corner + row, corner + 1, corner + row + 1};
        memcpy(indices + at, square, sizeof square);
        at += 6;
    }
    return (fnl_mesh_params){
        .vertex_count = vertex_count, .index_count = at, .positions = positions, .uv = uv, .indices = indices};
}

void world_free_sheet(const fnl_mesh_params *sheet) {
    free((void *)sheet->positions);
    free((void *)sheet->uv);
    free((void *)sheet->indices);
}

void world_add_mesh(struct world *w, uint32_t side, bool plain) {
    fnl_scene *scene = w->stage.scene;
    fnl_mesh_params mesh = world_sheet(w, side);
    fnl_material_params params = world_look(w, plain);
    assert_int_equal(fnl_scene_add_material(scene, &params, &w->materials[w->mesh_count]), FNL_OK);
    mesh.material = w->materials[w->mesh_count];
    assert_int_equal(fnl_scene_add_mesh(scene, &mesh, &w->meshes[w->mesh_count++]), FNL_OK);
    world_free_sheet(&mesh);
}

/* A copy of the first mesh with two morph targets, as only files have them. */
static void add_morphed_mesh(struct world *w) {
    fnl_scene *scene = w->stage.scene;
    struct scene_primitive p = scene->primitives.data[scene->meshes.data[w->meshes[0].index].first_primitive];
    p.memory = (struct arena){0};
    p.positions = arena_copy(&scene->arena, p.positions, p.vertex_count * sizeof *p.positions);
    p.normals = arena_copy(&scene->arena, p.normals, p.vertex_count * sizeof *p.normals);
    p.tangents = p.tangents ? arena_copy(&scene->arena, p.tangents, p.vertex_count * sizeof *p.tangents) : NULL;
    p.uv[0] = p.uv[0] ? arena_copy(&scene->arena, p.uv[0], p.vertex_count * sizeof *p.uv[0]) : NULL;
    p.colors = p.colors ? arena_copy(&scene->arena, p.colors, p.vertex_count * sizeof *p.colors) : NULL;
    p.indices = arena_copy(&scene->arena, p.indices, p.index_count * sizeof *p.indices);
    struct scene_morph_target *targets = ARENA_ARRAY(&scene->arena, struct scene_morph_target, 2);
    for (int t = 0; t < 2; t++) {
        vec3 *moved = ARENA_ARRAY(&scene->arena, vec3, p.vertex_count);
        for (uint32_t v = 0; v < p.vertex_count; v++) moved[v] = vec3_make(0, t ? 0.8f : 0, t ? 0 : 0.7f);
        targets[t].positions = moved;
    }
    p.morph_targets = targets;
    p.morph_target_count = 2;
    w->morphed_mesh = scene_add_mesh(scene, "morphed", &p, 1);
    assert_int_not_equal(w->morphed_mesh, SCENE_NONE);
    w->meshes[w->mesh_count] = (fnl_mesh_id){w->morphed_mesh, 1};
    w->materials[w->mesh_count++] = w->materials[0];
}

void world_add_instance(struct world *w, uint32_t i) {
    fnl_mat4 transform = world_pose(w);
    assert_int_equal(fnl_scene_add_instance(w->stage.scene, w->meshes[pick(w, w->mesh_count)], &transform, &w->instances[i]),
                     FNL_OK);
    w->instance_there[i] = true;
}

void world_add_light(struct world *w, uint32_t i) {
    fnl_light_params light = fnl_light_params_default();
    light.kind = (fnl_light_kind)pick(w, FNL_LIGHT_KIND_COUNT);
    light.position = place(w);
    light.direction = vec3_normalize(place(w));
    light.intensity = light.kind == FNL_LIGHT_DIRECTIONAL ? 2 : 20;
    light.range = 2;
    assert_int_equal(fnl_scene_add_light(w->stage.scene, &light, &w->lights[i]), FNL_OK);
    w->light_there[i] = true;
}

struct world world_open(void) {
    struct world w = {.random = {17}};
    fnl_scene *scene;
    assert_int_equal(fnl_scene_create(gpu_host(harness_device()), &scene), FNL_OK);
    w.stage = stage_open_scene(scene);
    w.stage.frame.width = 65;
    w.stage.frame.height = 37;
    w.stage.frame.exposure = FNL_EXPOSURE_NONE;
    w.stage.frame.outputs = FNL_OUTPUT_RADIANCE;
    w.stage.frame.camera = fnl_camera_default();
    w.stage.frame.camera.position = vec3_make(0, 0, 4);
    assert_int_equal(fnl_scene_set_ambient(scene, vec3_make(0.2f, 0.2f, 0.3f), vec3_make(0.1f, 0.1f, 0.1f)), FNL_OK);
    for (uint32_t i = 0; i < 3; i++) world_add_image(&w);
    for (uint32_t i = 0; i < 3; i++) world_add_mesh(&w, 9, true);
    add_morphed_mesh(&w);
    for (uint32_t i = 0; i < 12; i++) world_add_instance(&w, i);
    for (uint32_t i = 0; i < 8; i++) world_add_light(&w, i);
    return w;
}

/* ---- edits at random ---- */

void world_edit_instance(struct world *w) {
    fnl_scene *scene = w->stage.scene;
    uint32_t i = pick(w, INSTANCES);
    fnl_mat4 transform = world_pose(w);
    if (!w->instance_there[i]) {
        world_add_instance(w, i);
        return;
    }
    fnl_instance_id id = w->instances[i];
    switch (pick(w, 5)) {
    case 0:
        assert_int_equal(fnl_scene_remove_instance(scene, id), FNL_OK);
        w->instance_there[i] = false;
        break;
    case 1:
        assert_int_equal(fnl_scene_set_instance_visible(scene, id, scene->nodes.data[id.index].hidden), FNL_OK);
        break;
    case 2:
        assert_int_equal(fnl_scene_set_instance_receivers(scene, id, pick(w, 256)), FNL_OK);
        break;
    default:
        if (w->keeps_handedness && mat4_determinant3(&transform) * mat4_determinant3(&scene->nodes.data[id.index].world) < 0)
            transform = mat4_mul(transform, mat4_scaling(vec3_make(-1, 1, 1)));
        assert_int_equal(fnl_scene_set_instance_transform(scene, id, &transform), FNL_OK);
    }
}

/* Some that are there, one of them twice; the scene shows the last. */
static void move_several(struct world *w) {
    fnl_instance_id ids[8];
    fnl_mat4 transforms[8];
    uint32_t count = 0;
    for (uint32_t i = pick(w, INSTANCES), k = 0; k < INSTANCES && count < 7; k++, i = (i + 1) % INSTANCES) {
        if (!w->instance_there[i]) continue;
        transforms[count] = world_pose(w);
        ids[count++] = w->instances[i];
    }
    if (count == 0) return;
    ids[count] = ids[0];
    transforms[count++] = world_pose(w);
    assert_int_equal(fnl_scene_set_instance_transforms(w->stage.scene, ids, transforms, count), FNL_OK);
    assert_memory_equal(&w->stage.scene->nodes.data[ids[0].index].world, &transforms[count - 1], sizeof transforms[0]);
}

static void change_lights(struct world *w) {
    fnl_light_id ids[LIGHTS];
    fnl_light_params params[LIGHTS];
    uint32_t count = 0;
    for (uint32_t i = 0; i < LIGHTS; i++) {
        if (!w->light_there[i] || pick(w, 2)) continue;
        params[count] = w->stage.scene->lights.data[w->lights[i].index].params;
        params[count].kind = (fnl_light_kind)pick(w, FNL_LIGHT_KIND_COUNT);
        params[count].position = place(w);
        ids[count++] = w->lights[i];
    }
    assert_int_equal(fnl_scene_set_lights(w->stage.scene, ids, params, count), FNL_OK);
}

static void edit_light(struct world *w) {
    fnl_scene *scene = w->stage.scene;
    uint32_t i = pick(w, LIGHTS);
    if (!w->light_there[i]) {
        world_add_light(w, i);
        return;
    }
    fnl_light_params light = scene->lights.data[w->lights[i].index].params;
    fnl_vec3 corners[6];
    for (int k = 0; k < 6; k++) corners[k] = vec3_add_scaled(light.position, place(w), 1);
    switch (pick(w, 4)) {
    case 0:
        assert_int_equal(fnl_scene_remove_light(scene, w->lights[i]), FNL_OK);
        w->light_there[i] = false;
        break;
    case 1:
        assert_int_equal(fnl_scene_set_light_hull(scene, w->lights[i], corners, 6), FNL_OK);
        break;
    case 2:
        assert_int_equal(fnl_scene_set_light_hull(scene, w->lights[i], NULL, 0), FNL_OK);
        break;
    default:
        light.kind = (fnl_light_kind)pick(w, FNL_LIGHT_KIND_COUNT);
        light.position = place(w);
        assert_int_equal(fnl_scene_set_light(scene, w->lights[i], &light), FNL_OK);
    }
}

static void edit_decal(struct world *w) {
    fnl_scene *scene = w->stage.scene;
    uint32_t i = pick(w, DECALS), on = pick(w, INSTANCES);
    if (w->decal_there[i]) {
        assert_int_equal(fnl_scene_remove_decal(scene, w->decals[i]), FNL_OK);
        w->decal_there[i] = false;
        return;
    }
    if (!w->instance_there[on]) return;
    fnl_decal_params decal = fnl_decal_params_default();
    static const fnl_decal_kind kinds[] = {FNL_DECAL_BOX, FNL_DECAL_MESH, FNL_DECAL_REDRAW, FNL_DECAL_BAKED};
    decal.kind = kinds[pick(w, COUNT_OF(kinds))];
    if (decal.kind == FNL_DECAL_BAKED && scene->nodes.data[w->instances[on].index].mesh == w->morphed_mesh) return;
    decal.transform = decal.kind == FNL_DECAL_BOX ? world_pose(w) : mat4_scaling(vec3_make(0.9f, 0.9f, 2));
    if (decal.kind != FNL_DECAL_BOX || pick(w, 2)) decal.instance = w->instances[on];
    decal.color[pick(w, 3)] = 0;
    decal.color_image = w->images[pick(w, w->image_count)];
    assert_int_equal(fnl_scene_add_decal(scene, &decal, &w->decals[i]), FNL_OK);
    w->decal_there[i] = true;
}

/* Decals go with the instance that they are on, but their ids last until they are removed: fnl_scene_remove_decal takes them. */

static void edit_weights(struct world *w) {
    fnl_scene *scene = w->stage.scene;
    for (uint32_t i = 0; i < INSTANCES; i++) {
        if (!w->instance_there[i] || scene->nodes.data[w->instances[i].index].mesh != w->morphed_mesh) continue;
        const float weights[2] = {number(w, 0, 1), number(w, 0, 1)};
        const fnl_pose bent = {.morph_weights = weights, .morph_weight_count = 2};
        assert_int_equal(fnl_scene_set_pose(scene, w->instances[i], &bent), FNL_OK);
    }
}

/* Other positions, other colours, another material, or a sheet of another size. */
static void edit_mesh(struct world *w) {
    fnl_scene *scene = w->stage.scene;
    fnl_mesh_id id = w->meshes[pick(w, w->mesh_count)];
    fnl_mesh_info info;
    assert_int_equal(fnl_scene_query_mesh(scene, id.index, 0, &info), FNL_OK);
    float *values = malloc(info.params.vertex_count * 16);
    fnl_mesh_params changed = info.params;
    switch (pick(w, id.index == w->morphed_mesh ? 3 : 4)) {
    case 0:
        for (uint32_t i = 0; i < 3 * info.params.vertex_count; i++) values[i] = info.params.positions[i] * number(w, 0.7f, 1.2f);
        changed.positions = values;
        break;
    case 1:
        for (uint32_t i = 0; i < 4 * info.params.vertex_count; i++) values[i] = number(w, 0.2f, 1);
        changed.colors = values;
        break;
    case 2:
        changed.material = w->materials[pick(w, w->mesh_count)];
        break;
    default:
        changed = world_sheet(w, 1 + pick(w, 12));
        changed.material = info.params.material;
    }
    assert_int_equal(fnl_scene_set_mesh(scene, id, 0, &changed), FNL_OK);
    if (changed.uv != info.params.uv) world_free_sheet(&changed);
    free(values);
}

void world_edit(struct world *w) {
    fnl_scene *scene = w->stage.scene;
    uint32_t what = pick(w, 20), mesh = pick(w, w->mesh_count);
    fnl_material_params params = world_look(w, false);
    if (what < 4)
        world_edit_instance(w);
    else if (what == 4)
        move_several(w);
    else if (what < 7)
        edit_light(w);
    else if (what == 7)
        change_lights(w);
    else if (what < 10)
        edit_decal(w);
    else if (what < 12)
        edit_weights(w);
    else if (what < 14)
        assert_int_equal(fnl_scene_set_material(scene, w->materials[mesh], &params), FNL_OK);
    else if (what < 17)
        edit_mesh(w);
    else if (what == 17 && w->image_count < IMAGES)
        world_add_image(w);
    else if (w->mesh_count < MESHES)
        world_add_mesh(w, 1 + pick(w, 12), false);
}
