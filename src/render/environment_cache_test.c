/* SPDX-License-Identifier: MIT */
/** What is kept of environments between runs: hits and misses, the same pictures, broken files, and how many files there are at most. */
#include "tests/coarse_cases.h"
#include "tests/render_test.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

enum { WIDTH = 32, HEIGHT = 16, PATH = 512, FILE_BYTES = 32 + 6 * 8 * (128 * 128 + 64 * 64 + 32 * 32 + 16 * 16 + 8 * 8) + 112 + 64 * 64 * 8 };

static char folder[64];

/* ---- the folder ---- */

/* Files of environments; the last one's path. */
static uint32_t kept_files(char *path) {
    DIR *directory = opendir(folder);
    uint32_t count = 0;
    assert_non_null(directory);
    for (struct dirent *entry; (entry = readdir(directory));) {
        assert_null(strstr(entry->d_name, ".part"));
        if (strncmp(entry->d_name, "environment-", 12) != 0) continue;
        if (path) snprintf(path, PATH, "%s/%.300s", folder, entry->d_name);
        count++;
    }
    closedir(directory);
    return count;
}

static void remove_files(const char *start) {
    DIR *directory = opendir(folder);
    for (struct dirent *entry; directory && (entry = readdir(directory));) {
        char path[PATH];
        snprintf(path, sizeof path, "%s/%.300s", folder, entry->d_name);
        if (strncmp(entry->d_name, start, strlen(start)) == 0 && entry->d_name[0] != '.') assert_int_equal(unlink(path), 0);
    }
    if (directory) closedir(directory);
}

static uint64_t size_of(const char *path) {
    struct stat status;
    return stat(path, &status) == 0 ? (uint64_t)status.st_size : UINT64_MAX;
}

/* ---- runs: renderers that share nothing but the folder ---- */

static fnl_device *device_with(const char *cache) {
    fnl_device_params params = fnl_device_params_default();
    fnl_device *device;
    params.host = test_host(&test_device_memory);
    params.validate = true;
    params.cache_folder = cache;
    assert_int_equal(fnl_device_create(&params, &device), FNL_OK);
    return device;
}

struct run {
    fnl_scene *scene;
    fnl_renderer *renderer;
};

static struct run run_open(fnl_device *device) {
    struct run run = {.scene = coarse_scene()};
    coarse_add_sphere(run.scene, coarse_material(run.scene, 0.4f, (fnl_image_id){0}), 1);
    assert_int_equal(fnl_renderer_create(device, run.scene, &run.renderer), FNL_OK);
    return run;
}

static void run_close(struct run *run) {
    fnl_renderer_destroy(&run->renderer);
    fnl_scene_destroy(&run->scene);
}

/* One that depends on `seed`, with a small sun, which becomes a light. */
static void surround(struct run *run, float seed, float rotation, bool compressed) {
    float pixels[WIDTH * HEIGHT * 4];
    for (uint32_t i = 0; i < WIDTH * HEIGHT; i++)
        for (uint32_t c = 0; c < 4; c++) pixels[4 * i + c] = i == 5 * WIDTH + 9 ? 900 : seed + (float)(i * (c + 3) % 17) / 16 + (float)(i / WIDTH) / HEIGHT;
    const fnl_image image = {WIDTH, HEIGHT, FNL_PIXEL_FORMAT_RGBA32F, pixels};
    fnl_environment_params params = fnl_environment_params_default();
    params.image = &image;
    params.rotation = rotation;
    params.compressed = compressed;
    assert_int_equal(fnl_scene_set_environment(run->scene, &params), FNL_OK);
}

enum made { THERE, FILTERED, CACHED };

/* Renders, says what the frame did for its environment, and checks that by its passes. */
static enum made render(struct run *run, fnl_image *out) {
    fnl_frame frame = frame_plain();
    fnl_frame_stats stats;
    bool filters = false, copies = false;
    frame.width = 24, frame.height = 16;
    frame.outputs = FNL_OUTPUT_RADIANCE;
    frame.shading = FNL_SHADING_FORWARD;
    frame.lists = FNL_LISTS_ALL;
    frame.timers = true;
    frame.camera.position = (fnl_vec3){0, 1, 3};
    frame.camera.target = (fnl_vec3){0, 0, 0};
    assert_int_equal(fnl_renderer_render(run->renderer, &frame), FNL_OK);
    if (out) assert_int_equal(fnl_renderer_read(run->renderer, FNL_OUTPUT_RADIANCE, out), FNL_OK);
    assert_int_equal(fnl_renderer_query_stats(run->renderer, &stats), FNL_OK);
    for (uint32_t i = 0; i < stats.pass_count; i++) {
        filters |= strstr(stats.passes[i].name, "environment filter") || strcmp(stats.passes[i].name, "reflectance") == 0;
        copies |= strcmp(stats.passes[i].name, "environment light copy") == 0;
    }
    assert_int_equal(counter(&stats, "environment.filtered"), filters);
    assert_int_equal(counter(&stats, "environment.cached"), copies);
    assert_false(filters && copies);
    return filters ? FILTERED : copies ? CACHED : THERE;
}

/* A run of one frame in the environment of that seed. */
static enum made run_once(fnl_device *device, float seed, float rotation, bool compressed, fnl_image *out) {
    struct run run = run_open(device);
    surround(&run, seed, rotation, compressed);
    const enum made made = render(&run, out);
    run_close(&run);
    return made;
}

static void forget(fnl_image *image) {
    const fnl_host host = test_host(&test_device_memory);
    fnl_image_free(&host, image);
}

/* ---- tests ---- */

static fnl_device *device, *plain; /* with the folder; without any */

static int begin(void **state) {
    if (harness_begin(state) != 0) return -1;
    snprintf(folder, sizeof folder, "/tmp/fanal-environment-test-%d", (int)getpid());
    device = device_with(folder);
    plain = device_with("");
    return 0;
}

static int end(void **state) {
    assert_int_equal(fnl_device_validation_count(device), 0);
    fnl_device_destroy(&device);
    fnl_device_destroy(&plain);
    remove_files("");
    rmdir(folder);
    return harness_end(state);
}

/* Kept and filtered maps give the same bytes; another picture is not taken for this one, another turn of it is. */
static void test_kept_maps_give_the_same_bytes_EN_30(void **state) {
    UNUSED(state);
    fnl_image without, filtered, cached, other;
    remove_files("environment-");
    for (uint32_t compressed = 0; compressed < 1 + (uint32_t)gpu_info(plain)->texture_compression; compressed++) {
        assert_int_equal(run_once(plain, 0, 0.3f, compressed, &without), FILTERED);
        assert_int_equal(kept_files(NULL), compressed);
        assert_int_equal(run_once(device, 0, 0.3f, compressed, &filtered), FILTERED);
        assert_int_equal(kept_files(NULL), 1 + compressed);
        assert_int_equal(run_once(device, 0, 0.3f, compressed, &cached), CACHED);
        assert_int_equal(run_once(device, 0, 1, compressed, &other), CACHED);
        assert_int_equal(count_differing(&without, &filtered), 0);
        assert_int_equal(count_differing(&without, &cached), 0);
        assert_true(count_differing(&without, &other) > 0);
        forget(&without);
        forget(&filtered);
        forget(&other);
        forget(&cached);
    }
    assert_int_equal(run_once(device, 0.001f, 0.3f, false, NULL), FILTERED);
}

/* One renderer: maps are kept as soon as their frame is over, or before others take their place, and serve at once. */
static void test_kept_while_running_EN_30(void **state) {
    UNUSED(state);
    remove_files("environment-");
    struct run run = run_open(device);
    surround(&run, 0, 0, false);
    assert_int_equal(render(&run, NULL), FILTERED);
    assert_int_equal(kept_files(NULL), 0); /* the next picture comes before anybody has asked whether the frame is over */
    surround(&run, 1, 0, false);
    assert_int_equal(render(&run, NULL), FILTERED);
    assert_int_equal(kept_files(NULL), 1);
    for (int i = 0; i < 4; i++) assert_int_equal(render(&run, NULL), THERE);
    assert_int_equal(kept_files(NULL), 2);
    assert_null(run.renderer->device_scene->environment.kept.handle); /* its memory is given back */
    surround(&run, 0, 0, false);
    assert_int_equal(render(&run, NULL), CACHED);
    assert_int_equal(render(&run, NULL), THERE);
    assert_null(run.renderer->device_scene->environment.kept.handle);
    run_close(&run);
    assert_int_equal(kept_files(NULL), 2);
    run = run_open(device); /* declared for its pipelines alone: there is nothing to keep */
    surround(&run, 2, 0, false);
    assert_int_equal(fnl_renderer_warm(run.renderer, NULL, NULL, true, NULL), FNL_OK);
    run_close(&run);
    assert_int_equal(kept_files(NULL), 2);
}

static void spoil(const char *path, int how) {
    const int file = open(path, O_RDWR);
    unsigned char byte, all[64];
    assert_true(file >= 0);
    if (how == 0) assert_int_equal(ftruncate(file, (off_t)size_of(path) - 1), 0);
    if (how == 1) assert_int_equal(pwrite(file, "x", 1, (off_t)size_of(path)), 1);
    if (how == 2) { /* a bit of the last byte */
        assert_int_equal(pread(file, &byte, 1, (off_t)size_of(path) - 1), 1);
        byte ^= 4;
        assert_int_equal(pwrite(file, &byte, 1, (off_t)size_of(path) - 1), 1);
    }
    if (how == 3) { /* another version's */
        assert_int_equal(pread(file, all, 8, 0), 8);
        all[7]++;
        assert_int_equal(pwrite(file, all, 8, 0), 8);
    }
    close(file);
}

/* What is no whole file of this picture is not used, and the next run has one. */
static void test_broken_files_are_made_anew_EN_31(void **state) {
    UNUSED(state);
    char path[PATH], elsewhere[PATH];
    fnl_image want, got;
    remove_files("environment-");
    assert_int_equal(run_once(device, 0, 0, false, &want), FILTERED);
    assert_int_equal(kept_files(path), 1);
    const uint64_t size = size_of(path);
    for (int how = 0; how < 4; how++) {
        spoil(path, how);
        assert_int_equal(run_once(device, 0, 0, false, &got), FILTERED);
        assert_int_equal(count_differing(&want, &got), 0);
        forget(&got);
        assert_int_equal(size_of(path), size);
    }
    assert_int_equal(run_once(device, 0, 0, false, &got), CACHED);
    assert_int_equal(count_differing(&want, &got), 0);
    forget(&got);
    /* Whole, but of another picture. */
    char other[PATH];
    snprintf(elsewhere, sizeof elsewhere, "%s/moved", folder);
    assert_int_equal(rename(path, elsewhere), 0);
    assert_int_equal(run_once(device, 3, 0, false, NULL), FILTERED);
    assert_int_equal(kept_files(other), 1);
    assert_int_equal(rename(other, path), 0);
    assert_int_equal(run_once(device, 0, 0, false, &got), FILTERED);
    assert_int_equal(count_differing(&want, &got), 0);
    forget(&got);
    forget(&want);
    assert_int_equal(unlink(elsewhere), 0);
}

/* Files that nobody has used for longest go when all together are too large, of whatever device; others stay. */
static void test_the_folder_is_bounded_EN_32(void **state) {
    UNUSED(state);
    static const char *const names[] = {"environment-old.bin", "environment-older.bin", "choices-old.bin"};
    char path[PATH];
    remove_files("environment-");
    for (uint32_t i = 0; i < 3; i++) { /* sparse: 200 MiB each */
        const struct timespec times[2] = {{.tv_sec = 1000000 - i}, {.tv_sec = 1000000 - i}};
        snprintf(path, sizeof path, "%s/%s", folder, names[i]);
        const int file = open(path, O_WRONLY | O_CREAT, 0644);
        assert_true(file >= 0 && ftruncate(file, 200 << 20) == 0 && futimens(file, times) == 0);
        close(file);
    }
    assert_int_equal(run_once(device, 0, 0, false, NULL), FILTERED);
    assert_int_equal(kept_files(NULL), 2); /* 200 MiB and its own: the older one has gone */
    snprintf(path, sizeof path, "%s/%s", folder, names[1]);
    assert_int_equal(access(path, F_OK), -1);
    snprintf(path, sizeof path, "%s/%s", folder, names[2]);
    assert_int_equal(access(path, F_OK), 0);
    assert_int_equal(unlink(path), 0);
    assert_int_equal(run_once(device, 1, 0, false, NULL), FILTERED);
    nanosleep(&(struct timespec){.tv_nsec = 50000000}, NULL); /* file systems' clocks are coarse */
    assert_int_equal(run_once(device, 0, 0, false, NULL), CACHED); /* has been used last */
    gpu_cache_trim(device, "environment-", FILE_BYTES * 3 / 2);
    assert_int_equal(kept_files(path), 1);
    assert_int_equal(size_of(path), FILE_BYTES);
    assert_int_equal(run_once(device, 0, 0, false, NULL), CACHED);
    gpu_cache_trim(device, "environment-", 0);
    assert_int_equal(kept_files(NULL), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_kept_maps_give_the_same_bytes_EN_30, harness_check),
        cmocka_unit_test_teardown(test_kept_while_running_EN_30, harness_check),
        cmocka_unit_test_teardown(test_broken_files_are_made_anew_EN_31, harness_check),
        cmocka_unit_test_teardown(test_the_folder_is_bounded_EN_32, harness_check),
    };
    return cmocka_run_group_tests(tests, begin, end);
}
