/* SPDX-License-Identifier: MIT */
/** A scene that changes while it is shown: what each edit uploads, that pictures stay those of a fresh renderer, that memory stays flat. */
#include "tests/edit_world.h"

/* The lasting renderer and one that has just been made show the same, to the bit. */
static void check_picture(struct world *w, uint32_t round) {
    static const struct {
        fnl_shading shading;
        fnl_light_lists lists;
        fnl_culling culling;
    } ways[] = {{FNL_SHADING_DEFERRED, FNL_LISTS_TILED, FNL_CULLING_TRIANGLES},
                {FNL_SHADING_FORWARD, FNL_LISTS_CLUSTERED, FNL_CULLING_INSTANCES},
                {FNL_SHADING_VISIBILITY, FNL_LISTS_ALL, FNL_CULLING_CLUSTERS}};
    w->stage.frame.shading = ways[round % COUNT_OF(ways)].shading;
    w->stage.frame.lists = ways[round % COUNT_OF(ways)].lists;
    w->stage.frame.culling = ways[round % COUNT_OF(ways)].culling;
    struct stage fresh = w->stage;
    fresh.renderer = test_renderer(w->stage.scene);
    struct shot shot = stage_shoot(&w->stage, &w->stage.frame), other = stage_shoot(&fresh, &fresh.frame);
    uint64_t wrong = count_differing(&shot.radiance, &other.radiance);
    if (wrong) fail_msg("round %u: %llu pixels differ from a fresh renderer's", round, (unsigned long long)wrong);
    assert_int_equal(shot.stats.items, other.stats.items);
    assert_int_equal(shot.stats.triangles_total, other.stats.triangles_total);
    assert_int_equal(shot.stats.lights_total, other.stats.lights_total);
    fnl_renderer_destroy(&fresh.renderer);
    shot_free(&shot);
    shot_free(&other);
}

static void test_random_edits_show_what_a_fresh_renderer_shows(void **state) {
    UNUSED(state);
    struct world w = world_open();
    for (uint32_t round = 0; round < 45; round++) {
        check_picture(&w, round);
        for (uint32_t i = 0; i < 1 + round % 9; i++) world_edit(&w);
    }
    stage_close(&w.stage);
}

/* ---- what edits cost ---- */

static void shoot(struct world *w) {
    struct shot shot = stage_shoot(&w->stage, &w->stage.frame);
    shot_free(&shot);
}

/* Bytes that the next frame uploads before it begins. */
static uint64_t cost(struct world *w) {
    uint64_t before = w->stage.renderer->device_scene->bytes_uploaded;
    shoot(w);
    return w->stage.renderer->device_scene->bytes_uploaded - before;
}

static void test_an_edit_uploads_what_was_edited(void **state) {
    UNUSED(state);
    struct world w = world_open();
    fnl_scene *scene = w.stage.scene;
    world_add_mesh(&w, 60, true); /* heavy, and the last: its item is */
    fnl_mesh_id heavy = w.meshes[w.mesh_count - 1];
    fnl_material_params params = world_look(&w, true);
    params.double_sided = true; /* drawn after all others */
    assert_int_equal(fnl_scene_set_material(scene, w.materials[w.mesh_count - 1], &params), FNL_OK);
    assert_true(cost(&w) > 61 * 61 * 44);
    assert_int_equal(cost(&w), 0);
    const uint64_t sorts = w.stage.renderer->device_scene->sort_count;
    const uint64_t item = sizeof(struct gpu_item), group = sizeof(struct gpu_group), placed = sizeof(struct gpu_instance),
                   material = sizeof(struct gpu_material);
    fnl_mat4 transform = world_pose(&w);
    if (mat4_determinant3(&transform) < 0) transform = mat4_mul(transform, mat4_scaling(vec3_make(-1, 1, 1))); /* items of mirrored ones lie elsewhere */

    /* Buffers grow once; then there is room. Items lie by mesh, so those behind one that comes or goes move along. */
    fnl_instance_id ids[4];
    const fnl_mat4 identity = mat4_identity();
    for (uint32_t i = 0; i < COUNT_OF(ids); i++) {
        assert_int_equal(fnl_scene_add_instance(scene, heavy, &identity, &ids[i]), FNL_OK);
        assert_int_equal(cost(&w), placed + item + group + (i == 0 ? sizeof(struct gpu_scene) : 0));
    }
    assert_int_equal(fnl_scene_set_instance_visible(scene, ids[3], false), FNL_OK);
    assert_int_equal(cost(&w), group);
    assert_int_equal(fnl_scene_set_instance_visible(scene, ids[3], true), FNL_OK);
    assert_int_equal(cost(&w), placed + item + group);
    assert_int_equal(fnl_scene_remove_instance(scene, ids[3]), FNL_OK);
    assert_int_equal(cost(&w), group);
    assert_int_equal(fnl_scene_set_instance_transform(scene, ids[0], &transform), FNL_OK);
    assert_int_equal(cost(&w), 0); /* inside the frame */
    assert_int_equal(fnl_scene_remove_instance(scene, w.instances[0]), FNL_OK);
    uint64_t all = w.stage.renderer->device_scene->item_count * item + w.stage.renderer->device_scene->group_count * group;
    assert_true(cost(&w) <= all);

    assert_int_equal(fnl_scene_query_material(scene, w.materials[1].index, &params), FNL_OK);
    params.base_color[1] *= 0.5f;
    assert_int_equal(fnl_scene_set_material(scene, w.materials[1], &params), FNL_OK);
    assert_int_equal(cost(&w), material);
    assert_int_equal(w.stage.renderer->device_scene->sort_count, sorts + 1); /* the first edit of the rest that sorts */
    params.base_color_image = w.images[1];
    assert_int_equal(fnl_scene_set_material(scene, w.materials[1], &params), FNL_OK);
    assert_int_equal(cost(&w), material + 16 * 16 * 4);
    world_add_image(&w); /* of no material */
    assert_int_equal(cost(&w), 0);

    world_add_mesh(&w, 25, true); /* its clusters come besides, and glTF's default material moves behind its own */
    const struct scene_primitive *p = &scene->primitives.data[scene->primitives.count - 1];
    uint64_t mesh = p->vertex_count * (12 + sizeof(struct gpu_attributes)) + p->index_count * 4, cut = p->index_count / 3 * 20;
    uint64_t sent = cost(&w);
    assert_true(sent > mesh && sent < mesh + cut);
    stage_close(&w.stage);
}

/* Of a mesh only what differs is sent, whatever else there is; and its clusters take the places of the old ones. */
static void test_a_changed_mesh_uploads_what_differs(void **state) {
    UNUSED(state);
    struct world w = world_open();
    fnl_scene *scene = w.stage.scene;
    const struct device_scene *d = w.stage.renderer->device_scene;
    const fnl_mesh_id id = w.meshes[1];
    const fnl_mat4 identity = mat4_identity();
    fnl_instance_id shown;
    assert_int_equal(fnl_scene_add_instance(scene, id, &identity, &shown), FNL_OK);
    shoot(&w);
    fnl_mesh_info info;
    assert_int_equal(fnl_scene_query_mesh(scene, id.index, 0, &info), FNL_OK);
    const struct device_primitive *place = &d->primitive_places.data[scene->meshes.data[id.index].first_primitive];
    const uint64_t vertices = info.params.vertex_count, attributes = vertices * sizeof(struct gpu_attributes),
                   row = sizeof(struct gpu_primitive);

    /* What it has already costs nothing, and no structure is sorted again. */
    uint64_t structures = d->upload_count;
    assert_int_equal(fnl_scene_set_mesh(scene, id, 0, &info.params), FNL_OK);
    assert_int_equal(cost(&w), 0);
    assert_int_equal(d->upload_count, structures);

    float *colors = malloc(vertices * 16), *positions = malloc(vertices * 12);
    for (uint64_t i = 0; i < 4 * vertices; i++) colors[i] = 0.5f;
    for (uint64_t i = 0; i < 3 * vertices; i++) positions[i] = info.params.positions[i] * 1.5f;
    fnl_mesh_params changed = info.params;
    changed.colors = colors;
    assert_int_equal(fnl_scene_set_mesh(scene, id, 0, &changed), FNL_OK);
    assert_int_equal(cost(&w), attributes);

    assert_int_equal(fnl_scene_query_mesh(scene, id.index, 0, &info), FNL_OK);
    changed = info.params;
    changed.positions = positions;
    assert_int_equal(fnl_scene_set_mesh(scene, id, 0, &changed), FNL_OK);
    uint64_t sent = cost(&w), words = place->word_count * 4ull, indices = info.params.index_count * 4ull;
    assert_int_equal(sent, vertices * 12 + attributes + indices + place->cluster_count * sizeof(struct gpu_cluster) + words + row);
    free(colors);
    free(positions);

    assert_int_equal(fnl_scene_query_mesh(scene, id.index, 0, &info), FNL_OK);
    changed = info.params;
    changed.material = w.materials[2];
    assert_int_equal(fnl_scene_set_mesh(scene, id, 0, &changed), FNL_OK);
    assert_int_equal(cost(&w), row); /* both are opaque and one-sided: items keep their order */

    /* A cloth that is another in each frame: memory on the device and in the scene stays what it was. */
    uint64_t device_bytes = 0;
    long long host_bytes = 0;
    uint32_t ends[2] = {0};
    for (uint32_t round = 0; round < 40; round++) {
        fnl_mesh_params other = world_sheet(&w, round % 2 ? 9 : 14);
        other.material = changed.material;
        assert_int_equal(fnl_scene_set_mesh(scene, id, 0, &other), FNL_OK);
        world_free_sheet(&other);
        shoot(&w);
        if (round == 9) {
            device_bytes = gpu_memory_stats(harness_device()).used_bytes;
            host_bytes = test_device_memory.live_bytes;
            ends[0] = d->vertices_taken.end;
            ends[1] = d->indices_taken.end;
        }
    }
    assert_true(d->vertices_taken.end <= ends[0] && d->indices_taken.end <= ends[1]);
    assert_int_equal(gpu_memory_stats(harness_device()).used_bytes, device_bytes);
    assert_true(test_device_memory.live_bytes < host_bytes + 16384); /* a mesh of its own takes more */
    stage_close(&w.stage);
}

/* The lists of a device that has followed edits against those of one that sorts everything now; places of instances may differ. */
static void check_lists(const struct device_scene *d, const struct device_scene *fresh, uint32_t round) {
    if (d->item_count != fresh->item_count || d->group_count != fresh->group_count)
        fail_msg("round %u: %u items in %u groups instead of %u in %u", round, d->item_count, d->group_count, fresh->item_count,
                 fresh->group_count);
    const struct gpu_item *items = (const void *)d->items.sent.data, *others = (const void *)fresh->items.sent.data;
    for (uint32_t i = 0; i < d->item_count; i++) {
        uint32_t node = d->item_nodes.data[i];
        assert_int_equal(node, fresh->item_nodes.data[i]);
        assert_true(items[i].primitive == others[i].primitive && items[i].receivers == others[i].receivers);
        uint32_t first = d->nodes.data[node].first_instance;
        assert_int_equal(items[i].instance - first, others[i].instance - fresh->nodes.data[node].first_instance);
    }
    if (d->group_count) assert_memory_equal(d->groups.sent.data, fresh->groups.sent.data, d->group_count * sizeof(struct gpu_group));
    assert_int_equal(d->buckets.count, fresh->buckets.count);
    for (uint32_t i = 0; i < d->buckets.count; i++) {
        const struct geometry_bucket *a = &d->buckets.data[i], *b = &fresh->buckets.data[i];
        assert_true(a->first_item == b->first_item && a->item_count == b->item_count && a->first_group == b->first_group &&
                    a->group_count == b->group_count && a->topology == b->topology && a->blend == b->blend &&
                    a->mask == b->mask && a->double_sided == b->double_sided && a->mirrored == b->mirrored &&
                    a->forward_layouts == b->forward_layouts);
    }
    assert_true(d->cluster_count == fresh->cluster_count && d->triangle_count == fresh->triangle_count);
    assert_true(d->most_triangles == fresh->most_triangles && d->blend_item_count == fresh->blend_item_count);
    if (d->blend_item_count) assert_int_equal(d->blend_first_item, fresh->blend_first_item);
    const struct box *all = &d->bounds, *box = &fresh->bounds;
    assert_true(all->low.x <= box->low.x && all->low.y <= box->low.y && all->low.z <= box->low.z);
    assert_true(all->high.x >= box->high.x && all->high.y >= box->high.y && all->high.z >= box->high.z);
}

/* Instances that come, go, hide and move do not have all others sorted again, and stand in the lists where sorting would have them. */
static void test_instances_are_edited_in_place(void **state) {
    UNUSED(state);
    struct world w = world_open();
    fnl_scene *scene = w.stage.scene;
    for (uint32_t i = 0; i < 8; i++) world_add_mesh(&w, 1 + i, false);
    for (uint32_t i = 0; i < w.mesh_count; i++) /* what deforms is sorted with all others */
        if (w.meshes[i].index == w.morphed_mesh) w.meshes[i] = w.meshes[0];
    for (uint32_t i = 0; i < INSTANCES; i++) {
        if (w.instance_there[i]) assert_int_equal(fnl_scene_remove_instance(scene, w.instances[i]), FNL_OK);
        world_add_instance(&w, i);
    }
    w.stage.frame.width = 17;
    w.stage.frame.height = 9;
    check_picture(&w, 0);
    const struct device_scene *d = w.stage.renderer->device_scene;
    const uint64_t sorts = d->sort_count, structures = d->upload_count;
    w.keeps_handedness = true; /* else all are sorted */
    for (uint32_t round = 0; round < 150; round++) {
        for (uint32_t i = 0; i < 1 + round % 5; i++) world_edit_instance(&w);
        if (round % 50 == 49) /* all of them */
            for (uint32_t i = 0; i < INSTANCES; i++)
                if (w.instance_there[i]) assert_int_equal(fnl_scene_set_instance_visible(scene, w.instances[i], round == 99), FNL_OK);
        struct device_scene fresh;
        device_scene_init(&fresh, harness_device(), scene);
        assert_int_equal(device_scene_prepare(&fresh), FNL_OK);
        shoot(&w);
        check_lists(d, &fresh, round);
        device_scene_finish(&fresh);
    }
    assert_true(d->upload_count - structures > 100);
    assert_int_equal(d->sort_count, sorts);

    /* So many that sorting is cheaper; then a renderer that has missed none goes on in place. */
    for (uint32_t i = 0; i < 100; i++) world_add_instance(&w, i % INSTANCES);
    shoot(&w);
    assert_int_equal(d->sort_count, sorts + 1);
    assert_int_equal(fnl_scene_remove_instance(scene, w.instances[3]), FNL_OK);
    w.instance_there[3] = false;
    w.stage.frame.width = 65;
    w.stage.frame.height = 37;
    for (uint32_t i = 0; i < 3; i++) check_picture(&w, i);
    assert_int_equal(d->sort_count, sorts + 1);
    stage_close(&w.stage);
}

/* Of a run: FANAL_TEST_FRAMES, for measuring longer ones. */
static uint32_t frames(uint32_t few) {
    const char *asked = getenv("FANAL_TEST_FRAMES");
    return asked ? (uint32_t)atoi(asked) : few;
}

/* ---- memory ---- */

/* What came goes again. */
static void come_and_go(struct world *w, uint32_t round) {
    fnl_scene *scene = w->stage.scene;
    uint32_t i = 12 + round % 8, l = 8 + round % 8;
    if (!w->instance_there[i]) {
        world_add_instance(w, i);
        world_add_light(w, l);
    } else {
        assert_int_equal(fnl_scene_remove_instance(scene, w->instances[i]), FNL_OK);
        assert_int_equal(fnl_scene_remove_light(scene, w->lights[l]), FNL_OK);
        w->instance_there[i] = w->light_there[l] = false;
    }
    fnl_instance_id still = w->instances[round % 12];
    assert_int_equal(fnl_scene_set_instance_visible(scene, still, scene->nodes.data[still.index].hidden), FNL_OK);
    if (round % 5) return;
    fnl_decal_params decal = fnl_decal_params_default();
    if (w->decal_there[0])
        assert_int_equal(fnl_scene_remove_decal(scene, w->decals[0]), FNL_OK);
    else
        assert_int_equal(fnl_scene_add_decal(scene, &decal, &w->decals[0]), FNL_OK);
    w->decal_there[0] = !w->decal_there[0];
}

static void test_memory_stays_flat(void **state) {
    UNUSED(state);
    uint32_t rounds = frames(300);
    struct world w = world_open();
    w.stage.frame.width = 17;
    w.stage.frame.height = 9;
    shoot(&w);
    const struct device_scene *d = w.stage.renderer->device_scene;
    const fnl_scene *scene = w.stage.scene;
    uint32_t vertices = 20 * scene->primitives.data[scene->meshes.data[w.morphed_mesh].first_primitive].vertex_count;
    for (uint32_t i = 0; i < scene->primitives.count; i++) vertices += scene->primitives.data[i].vertex_count;
    uint64_t early = 0, late = 0;
    long long early_host = 0, late_host = 0;
    for (uint32_t round = 0; round < rounds; round++) {
        come_and_go(&w, round);
        shoot(&w);
        assert_true(d->instances_taken.end <= 20 && d->nodes.count <= 20 && d->vertices_taken.end <= vertices);
        assert_true(scene->light_slots.count <= 16 && scene->lights.count <= 16);
        bool first_third = round < rounds / 3;
        uint64_t used = gpu_memory_stats(harness_device()).used_bytes;
        long long held = test_device_memory.live_bytes;
        *(first_third ? &early : &late) = MAX(first_third ? early : late, used);
        *(first_third ? &early_host : &late_host) = MAX(first_third ? early_host : late_host, held);
    }
    print_message("%u rounds: at most %llu bytes of device memory, then %llu; of host memory %lld, then %lld\n", rounds,
                  (unsigned long long)early, (unsigned long long)late, early_host, late_host);
    assert_true(late <= early + early / 100);
    assert_true(late_host < early_host + 4 * rounds); /* arrays grow by leaps */
    stage_close(&w.stage);
}

/* ---- frames ---- */

/* An instance comes with every tenth frame: those frames upload it and what lies behind it, others nothing. */
static void test_no_frame_is_long(void **state) {
    UNUSED(state);
    enum { EVERY = 10, WARM = 20 };
    uint32_t count = frames(200);
    struct world w = world_open();
    world_add_mesh(&w, 100, true);
    for (uint32_t i = 0; i < WARM; i++) shoot(&w);
    struct device_scene *d = w.stage.renderer->device_scene;
    const fnl_mat4 identity = mat4_identity();
    uint32_t edits = 0;
    for (uint32_t i = 0; i < count; i++) {
        uint64_t bytes = d->bytes_uploaded, structures = d->upload_count, images = d->image_upload_count;
        fnl_instance_id id;
        bool adds = i % EVERY == 0;
        if (adds) assert_int_equal(fnl_scene_add_instance(w.stage.scene, w.meshes[1], &identity, &id), FNL_OK);
        assert_int_equal(fnl_renderer_render(w.stage.renderer, &w.stage.frame), FNL_OK);
        fnl_frame_stats stats;
        assert_int_equal(fnl_renderer_query_stats(w.stage.renderer, &stats), FNL_OK);
        bytes = d->bytes_uploaded - bytes;
        edits += adds;
        assert_int_equal(d->upload_count - structures, adds);
        assert_int_equal(d->image_upload_count, images);
        uint64_t most = sizeof(struct gpu_instance) + d->item_count * sizeof(struct gpu_item) +
                        d->group_count * sizeof(struct gpu_group) + sizeof(struct gpu_scene);
        assert_true(adds ? bytes > sizeof(struct gpu_instance) && bytes <= most : bytes == 0);
    }
    assert_int_equal(edits, DIVIDE_UP(count, EVERY));
    stage_close(&w.stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_an_edit_uploads_what_was_edited, harness_check),
        cmocka_unit_test_teardown(test_a_changed_mesh_uploads_what_differs, harness_check),
        cmocka_unit_test_teardown(test_instances_are_edited_in_place, harness_check),
        cmocka_unit_test_teardown(test_random_edits_show_what_a_fresh_renderer_shows, harness_check),
        cmocka_unit_test_teardown(test_memory_stays_flat, harness_check),
        cmocka_unit_test_teardown(test_no_frame_is_long, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
