/* SPDX-License-Identifier: MIT */
/* auto on a device: what its frames show and cost, and what it remembers. The rules are in chooser_test.c. */
#include "tests/render_test.h"

#include <dirent.h>
#include <time.h>
#include <unistd.h>

enum { MOST_FRAMES = 60 };

static bool background_rests(gpu_device *device) {
    struct gpu_pipeline_stats stats = gpu_pipeline_stats(device);
    return stats.done == stats.asked;
}

static fnl_frame auto_frame(const struct stage *stage) {
    fnl_frame frame = stage->frame;
    frame.width = 96;
    frame.height = 54;
    frame.shading = FNL_SHADING_DEFERRED;
    frame.lists = FNL_LISTS_AUTO;
    return frame;
}

/* Decided within 60 frames, those left out that were rendered while pipelines were made; each with the bits of brute force, and none made
   or waited for a pipeline but the first, whose own they were. */
static void test_frames(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:spheres?lights=100", 0);
    fnl_frame frame = auto_frame(&stage);
    frame.lists = FNL_LISTS_ALL;
    struct shot all = stage_shoot(&stage, &frame);
    assert_int_equal(all.stats.lists, FNL_LISTS_ALL);
    assert_string_equal(all.stats.choice, "");
    frame.lists = FNL_LISTS_AUTO;
    uint64_t late = 0, ahead = gpu_pipeline_stats(test_device).ahead;
    uint32_t decided = 0, waited = 0;
    bool used[FNL_LISTS_COUNT] = {0};
    for (uint32_t i = 1; !decided || i <= decided + 10; i++) {
        bool rests = background_rests(test_device);
        struct shot shot = stage_shoot(&stage, &frame);
        assert_int_equal(count_differing(&all.radiance, &shot.radiance), 0);
        assert_true(shot.stats.lists < FNL_LISTS_AUTO && shot.stats.shading == FNL_SHADING_DEFERRED);
        used[shot.stats.lists] = true;
        if (i == 1) late = gpu_pipeline_stats(test_device).late;
        if (!decided && !shot.stats.choosing) decided = i;
        if (decided) assert_non_null(strstr(shot.stats.choice, "fastest of"));
        if (!rests) {
            waited++;
            assert_int_equal(shot.stats.lists, FNL_LISTS_TILED); /* the likely one */
            nanosleep(&(struct timespec){.tv_nsec = 20000000}, NULL);
        }
        shot_free(&shot);
    }
    print_message("decided at frame %u; %u frames were rendered while pipelines were made\n", decided, waited);
    assert_true(decided - waited <= MOST_FRAMES);
    assert_true(gpu_pipeline_stats(test_device).ahead > ahead + 20);
    assert_int_equal(gpu_pipeline_stats(test_device).late, late);
    uint32_t count = 0;
    for (uint32_t i = 0; i < FNL_LISTS_COUNT; i++) count += used[i];
    assert_int_equal(count, 9); /* all candidates had a turn */
    frame.shading = FNL_SHADING_AUTO;
    frame.pin_choice = true;
    struct shot pinned = stage_shoot(&stage, &frame);
    assert_true(pinned.stats.shading < FNL_SHADING_AUTO && !pinned.stats.choosing);
    assert_true(greatest_difference(&all.color, &pinned.color) <= 2);
    shot_free(&pinned);
    shot_free(&all);
    stage_close(&stage);
}

static void test_the_first_frame_has_the_likely_or_the_remembered_lists(void **state) {
    UNUSED(state);
    static const struct {
        const char *source;
        fnl_light_lists likely, other;
    } cases[] = {{"builtin:spheres?lights=1", FNL_LISTS_ALL, FNL_LISTS_CLUSTERED},
                 {"builtin:spheres?lights=1024", FNL_LISTS_TILED, FNL_LISTS_ZBIN},
                 {"builtin:spheres?lights=65536", FNL_LISTS_HALFZ, FNL_LISTS_SPARSE}};
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        char memory[128] = "";
        struct stage stage = stage_open(cases[i].source, 0);
        fnl_frame frame = auto_frame(&stage);
        frame.width = 16;
        frame.height = 9;
        frame.outputs = FNL_OUTPUT_COLOR;
        for (int round = 0; round < 4; round++) {
            bool remembered = round >= 2;
            fnl_frame_stats stats;
            fnl_renderer_destroy(&stage.renderer);
            assert_int_equal(fnl_renderer_create(test_device, stage.scene, &stage.renderer), FNL_OK);
            chooser_parse(&stage.renderer->choice.chooser, memory, strlen(memory));
            frame.pin_choice = round % 2;
            assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_OK);
            assert_int_equal(fnl_renderer_query_stats(stage.renderer, &stats), FNL_OK);
            assert_int_equal(stats.lists, remembered ? cases[i].other : cases[i].likely);
            assert_int_equal(stats.choosing, !remembered && !frame.pin_choice);
            if (remembered) assert_non_null(strstr(stats.choice, "remembered: 1.50 ms"));
            if (round == 1)
                snprintf(memory, sizeof memory, "%016llx deferred %s 1.5\n",
                         (unsigned long long)chooser_key(&stage.renderer->choice.chooser.at), fnl_value_name(FNL_ENUM_LISTS, cases[i].other));
        }
        stage_close(&stage);
    }
}

/* Without lights `auto` is brute force, in memory and pipelines too. */
static void test_no_lights_cost_no_lists(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:spheres?lights=0", 0);
    fnl_frame frame = auto_frame(&stage);
    fnl_frame_stats first, last;
    frame.outputs = FNL_OUTPUT_COLOR;
    frame.lists = FNL_LISTS_ALL;
    for (int i = 0; i < 4; i++) assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_OK);
    assert_int_equal(fnl_renderer_query_stats(stage.renderer, &first), FNL_OK);
    const struct gpu_pipeline_stats before = gpu_pipeline_stats(test_device);
    frame.lists = FNL_LISTS_AUTO;
    for (int i = 0; i < 12; i++) {
        assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_OK);
        assert_int_equal(fnl_renderer_query_stats(stage.renderer, &last), FNL_OK);
        assert_int_equal(last.lists, FNL_LISTS_ALL);
        assert_false(last.choosing);
        assert_int_equal(last.candidate_count, 0);
    }
    const struct gpu_pipeline_stats after = gpu_pipeline_stats(test_device);
    assert_int_equal(after.made, before.made);
    assert_int_equal(after.asked, before.asked);
    assert_int_equal(last.device_bytes, first.device_bytes);
    assert_int_equal(last.list_bytes, first.list_bytes);
    stage_close(&stage);
}

/* Lights move from the frame after their change on, until they have stood still for a while; a camera that moves is no matter. */
static void test_frames_say_whether_lights_move(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:spheres?lights=16", 0);
    fnl_frame frame = auto_frame(&stage);
    frame.width = 16;
    frame.height = 9;
    frame.pin_choice = true;
    fnl_light_params light = fnl_light_params_default();
    fnl_light_id id;
    assert_int_equal(fnl_scene_add_light(stage.scene, &light, &id), FNL_OK);
    uint32_t moving = 0;
    for (int i = 0; i < 100; i++) {
        frame.camera.position.x += 0.01f;
        light.position.y += 0.1f;
        if (i == 10 || i == 12) assert_int_equal(fnl_scene_set_light(stage.scene, id, &light), FNL_OK);
        assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_OK);
        moving += stage.renderer->choice.chooser.at.moves;
        if (i < 10 || i > 12 + 60) assert_false(stage.renderer->choice.chooser.at.moves);
    }
    assert_int_equal(moving, 62);
    stage_close(&stage);
}

/* What is remembered for frames that allow a close picture is taken by them alone. */
static void test_frames_say_whether_close_is_good_enough(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:spheres?lights=16", 0);
    fnl_frame frame = auto_frame(&stage);
    frame.shading = FNL_SHADING_AUTO;
    frame.pin_choice = true;
    fnl_frame_stats stats;
    for (int round = 0; round < 3; round++) {
        frame.choose_close = round > 0;
        assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_OK);
        assert_int_equal(fnl_renderer_query_stats(stage.renderer, &stats), FNL_OK);
        assert_int_equal(stats.shading, round < 2 ? FNL_SHADING_DEFERRED : FNL_SHADING_VISIBILITY);
        if (round != 1) continue;
        assert_true(stage.renderer->choice.chooser.at.close);
        char memory[128];
        int length = snprintf(memory, sizeof memory, "%016llx visibility tiled 1.5\n", (unsigned long long)chooser_key(&stage.renderer->choice.chooser.at));
        fnl_renderer_destroy(&stage.renderer);
        assert_int_equal(fnl_renderer_create(test_device, stage.scene, &stage.renderer), FNL_OK);
        chooser_parse(&stage.renderer->choice.chooser, memory, (size_t)length);
    }
    frame.choose_close = false;
    assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_OK);
    assert_int_equal(fnl_renderer_query_stats(stage.renderer, &stats), FNL_OK);
    assert_int_equal(stats.shading, FNL_SHADING_DEFERRED);

    frame.choose_close = true; /* then the options of visibility have to go together */
    frame.visibility.grid = true;
    frame.msaa = 4;
    assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_ERROR_UNSUPPORTED);
    frame.choose_close = false;
    assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_OK);
    stage_close(&stage);
}

static void test_new_lights_count_in_the_very_next_frame(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:spheres?lights=1", 0);
    fnl_frame frame = auto_frame(&stage);
    frame.pin_choice = true;
    fnl_light_id ids[300];
    for (uint32_t step = 0; step < 4; step++) {
        fnl_frame_stats stats;
        if (step == 2)
            for (uint32_t i = 0; i < COUNT_OF(ids); i++) {
                fnl_light_params light = test_point((vec3){0, 1, (float)i * 0.01f}, 1, 0.5f);
                assert_int_equal(fnl_scene_add_light(stage.scene, &light, &ids[i]), FNL_OK);
            }
        if (step == 3)
            for (uint32_t i = 0; i < COUNT_OF(ids); i++) assert_int_equal(fnl_scene_remove_light(stage.scene, ids[i]), FNL_OK);
        assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_OK);
        assert_int_equal(fnl_renderer_query_stats(stage.renderer, &stats), FNL_OK);
        assert_int_equal(stage.renderer->choice.chooser.at.light_count, step == 2 ? 301 : 1);
        assert_int_equal(stats.lists, step == 2 ? FNL_LISTS_TILED : FNL_LISTS_ALL);
    }
    stage_close(&stage);
}

static void test_pinned_frames_ask_for_nothing(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:spheres?lights=100", 0);
    fnl_frame frame = auto_frame(&stage);
    uint64_t asked = gpu_pipeline_stats(test_device).asked;
    frame.msaa = 4; /* other pipelines than those of the tests before */
    frame.pin_choice = true;
    fnl_light_lists first = FNL_LISTS_COUNT;
    for (int i = 0; i < 20; i++) {
        struct shot shot = stage_shoot(&stage, &frame);
        if (i == 0) first = shot.stats.lists;
        assert_int_equal(shot.stats.lists, first);
        assert_false(shot.stats.choosing);
        assert_int_equal(chooser_wants(&stage.renderer->choice.chooser), 0);
        assert_true(shot.stats.gpu_milliseconds == 0); /* nor are there timers that nobody asked for */
        shot_free(&shot);
    }
    assert_null(stage.renderer->dry.graph);
    assert_int_equal(gpu_pipeline_stats(test_device).asked, asked);
    frame.pin_choice = false;
    assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_OK);
    assert_true(gpu_pipeline_stats(test_device).asked > asked);
    stage_close(&stage);
}

struct run {
    fnl_device *device;
    fnl_scene *scene;
    fnl_renderer *renderer;
    fnl_frame frame;
};

/* As a program of its own: what it leaves is in the folder. */
static struct run run_open(const char *folder) {
    struct run run = {.frame = test_frame(FNL_OUTPUT_COLOR)};
    fnl_device_params params = fnl_device_params_default();
    params.cache_folder = folder;
    assert_int_equal(fnl_device_create(&params, &run.device), FNL_OK);
    assert_int_equal(scene_load_plain(NULL, "builtin:spheres?lights=20", NULL, &run.scene), FNL_OK);
    assert_int_equal(fnl_renderer_create(run.device, run.scene, &run.renderer), FNL_OK);
    assert_int_equal(fnl_scene_query_camera(run.scene, 0, &run.frame.camera), FNL_OK);
    run.frame.width = run.frame.height = 32;
    run.frame.shading = FNL_SHADING_DEFERRED;
    run.frame.lists = FNL_LISTS_AUTO;
    return run;
}

static void run_close(struct run *run) {
    fnl_renderer_destroy(&run->renderer);
    fnl_device_destroy(&run->device);
    fnl_scene_destroy(&run->scene);
}

/* Renders until a decision, or so many frames while the background is at rest. */
static fnl_frame_stats run_frames(struct run *run, uint32_t most) {
    fnl_frame_stats stats = {.choosing = true};
    for (uint32_t i = 0; i < most && stats.choosing;) {
        bool rests = background_rests(run->device);
        i += rests;
        if (!rests) nanosleep(&(struct timespec){.tv_nsec = 20000000}, NULL);
        assert_int_equal(fnl_renderer_render(run->renderer, &run->frame), FNL_OK);
        assert_int_equal(fnl_renderer_query_stats(run->renderer, &stats), FNL_OK);
    }
    return stats;
}

/* The text of the file of choices in a folder, if there is one. */
static void read_choices(const char *folder, char *text, size_t capacity) {
    DIR *directory = opendir(folder);
    size_t length = 0;
    assert_non_null(directory);
    for (struct dirent *entry; (entry = readdir(directory));) {
        char path[512];
        snprintf(path, sizeof path, "%s/%.300s", folder, entry->d_name);
        FILE *file = strncmp(entry->d_name, "choices-", 8) == 0 ? fopen(path, "r") : NULL;
        if (file) length = fread(text, 1, capacity - 1, file);
        if (file) fclose(file);
    }
    closedir(directory);
    text[length] = 0;
}

static void remove_folder(const char *folder) {
    DIR *directory = opendir(folder);
    for (struct dirent *entry; directory && (entry = readdir(directory));) {
        char path[512];
        snprintf(path, sizeof path, "%s/%.300s", folder, entry->d_name);
        unlink(path);
    }
    if (directory) closedir(directory);
    rmdir(folder);
}

/* What one measured is where another begins, undecided or decided. */
static void test_the_next_run_goes_on(void **state) {
    UNUSED(state);
    char folder[64], text[4096];
    snprintf(folder, sizeof folder, "/tmp/fanal-chooser-test-%d", (int)getpid());
    struct run run = run_open(folder);
    assert_true(run_frames(&run, 18).choosing);
    read_choices(folder, text, sizeof text);
    assert_string_equal(text, ""); /* written in the end: no frame waits for files */
    run_close(&run);
    read_choices(folder, text, sizeof text);
    assert_int_equal(strncmp(text, "trial ", 6), 0);

    run = run_open(folder);
    assert_true(run.renderer->choice.chooser.trial_count >= 3);
    run_frames(&run, 1);
    uint32_t known = 0;
    for (uint32_t i = 0; i < run.renderer->choice.chooser.candidate_count; i++) known += run.renderer->choice.chooser.candidates[i].got;
    assert_true(known >= 3);
    fnl_frame_stats stats = run_frames(&run, MOST_FRAMES);
    assert_false(stats.choosing);
    run_close(&run);
    read_choices(folder, text, sizeof text);
    assert_non_null(strstr(text, fnl_value_name(FNL_ENUM_LISTS, stats.lists)));
    assert_null(strstr(text, "trial"));

    run = run_open(folder);
    fnl_frame_stats again = run_frames(&run, 1); /* the first frame */
    assert_int_equal(again.lists, stats.lists);
    assert_false(again.choosing);
    assert_non_null(strstr(again.choice, "remembered"));
    assert_int_equal(gpu_pipeline_stats(run.device).asked, 0);
    run_close(&run);
    remove_folder(folder);
}

struct edited {
    fnl_instance_id instance;
    fnl_light_id light;
};

static struct edited add_edited(fnl_scene *scene) {
    static const float positions[] = {-1, -1, 0, 1, -1, 0, 0, 1, 0};
    static const uint32_t indices[] = {0, 1, 2};
    struct edited e;
    fnl_mesh_params params = {.vertex_count = 3, .index_count = 3, .positions = positions, .indices = indices};
    fnl_mesh_id mesh;
    fnl_mat4 at = mat4_from_trs((vec3){0, 1, 0}, quat_identity(), (vec3){1, 1, 1});
    fnl_light_params light = test_point((vec3){0, 2, 1}, 30, 5);
    fnl_decal_params decal = fnl_decal_params_default();
    fnl_decal_id id;
    assert_int_equal(fnl_scene_add_mesh(scene, &params, &mesh), FNL_OK);
    assert_int_equal(fnl_scene_add_instance(scene, mesh, &at, &e.instance), FNL_OK);
    assert_int_equal(fnl_scene_add_light(scene, &light, &e.light), FNL_OK);
    decal.instance = e.instance;
    decal.color[1] = 0;
    assert_int_equal(fnl_scene_add_decal(scene, &decal, &id), FNL_OK);
    return e;
}

static void edit(fnl_scene *scene, const struct edited *e, uint32_t step) {
    fnl_mat4 at = mat4_from_trs((vec3){0.1f * (float)step, 1, 0.2f}, quat_identity(), (vec3){1, 1, 1});
    fnl_light_params light = test_point((vec3){0.2f * (float)step, 2, 1}, 30, 5);
    fnl_light_id id;
    if (step % 3 == 0) assert_int_equal(fnl_scene_set_light(scene, e->light, &light), FNL_OK);
    if (step % 3 == 1) assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
    if (step % 2 == 0) assert_int_equal(fnl_scene_set_instance_transform(scene, e->instance, &at), FNL_OK);
}

/* Frames that ask for the pipelines of others, while lights come and change, an instance moves with a decal, and TAA collects, are the frames
   that they would have been. */
static void test_asking_changes_nothing(void **state) {
    UNUSED(state);
    struct stage asks = stage_open("builtin:spheres?lights=100", 0), plain = stage_open("builtin:spheres?lights=100", 0);
    struct edited edited[2] = {add_edited(asks.scene), add_edited(plain.scene)};
    fnl_frame frame = auto_frame(&asks);
    frame.aa = FNL_ANTIALIASING_TAA;
    frame.exposure = FNL_EXPOSURE_AUTO;
    /* Lists that keep things from frame to frame come first, and in between. */
    static const fnl_light_lists keep[] = {FNL_LISTS_RASTER, FNL_LISTS_WORLD, FNL_LISTS_CLUSTERED_CPU};
    uint32_t asked = 0;
    for (uint32_t i = 0; i < 20; i++) {
        bool keeps = i < 3 || i % 6 == 5;
        frame.lists = keeps ? keep[i % COUNT_OF(keep)] : FNL_LISTS_AUTO;
        edit(asks.scene, &edited[0], i);
        edit(plain.scene, &edited[1], i);
        if (i % 5 == 4) asks.renderer->choice.chooser = (struct chooser){0}; /* asks anew */
        struct choice choice;
        struct shot a = stage_shoot(&asks, &frame);
        asked += asks.renderer->dry.graph && chooser_asks(&asks.renderer->choice.chooser, &choice);
        fnl_frame same = frame;
        same.lists = a.stats.lists;
        struct shot b = stage_shoot(&plain, &same);
        assert_int_equal(count_differing(&a.radiance, &b.radiance), 0);
        assert_int_equal(count_differing(&a.color, &b.color), 0);
        assert_int_equal(a.stats.lights_total, b.stats.lights_total);
        assert_int_equal(a.stats.lights_in_view, b.stats.lights_in_view);
        assert_int_equal(asks.renderer->device_scene->light_bytes_sent, plain.renderer->device_scene->light_bytes_sent);
        shot_free(&a);
        shot_free(&b);
    }
    assert_true(asked > 8);
    stage_close(&asks);
    stage_close(&plain);
}

/* Tests count the pipelines that are made: none of other parts of the program. */
static int begin_anew(void **state) { return harness_finish() ? harness_begin(state) : -1; }

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_frames, harness_check),
        cmocka_unit_test_teardown(test_the_first_frame_has_the_likely_or_the_remembered_lists, harness_check),
        cmocka_unit_test_teardown(test_no_lights_cost_no_lists, harness_check),
        cmocka_unit_test_teardown(test_frames_say_whether_lights_move, harness_check),
        cmocka_unit_test_teardown(test_frames_say_whether_close_is_good_enough, harness_check),
        cmocka_unit_test_teardown(test_new_lights_count_in_the_very_next_frame, harness_check),
        cmocka_unit_test_teardown(test_pinned_frames_ask_for_nothing, harness_check),
        cmocka_unit_test_teardown(test_the_next_run_goes_on, harness_check),
        cmocka_unit_test_teardown(test_asking_changes_nothing, harness_check),
    };
    return cmocka_run_group_tests(tests, begin_anew, harness_end);
}
