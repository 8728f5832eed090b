/* SPDX-License-Identifier: MIT */
/* What `fanal bench --resume` finds in its folder, and paths of cameras: whatever the bytes, an error, or results that can be concluded from and saved. */
#include "cli/bench.h"
#include "tests/fuzz/fuzz.h"

const char program_commit[] = "unknown"; /* of cli/program.h */

static void check_path(const uint8_t *bytes, size_t size) {
    struct bench_path path;
    fnl_camera base = fnl_camera_default();
    if (!bench_path_create(&path, fuzz_file("path.txt", bytes, size), NULL, &base, 1, 1)) return;
    if (path.count == 0) abort();
    for (uint32_t i = 0; i < path.count; i++) {
        const fnl_camera *c = &path.points[i].camera;
        if (!isfinite(path.points[i].time) || !isfinite(c->position.x + c->position.y + c->position.z)) abort();
        if (i && path.points[i].time < path.points[i - 1].time) abort();
    }
    bench_path_destroy(&path);
}

/* A byte 0 parts results.json from report.html. The first byte: a path instead. */
int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    if (size > 0 && *bytes == '#') {
        check_path(bytes, size);
        return 0;
    }
    const uint8_t *middle = size ? memchr(bytes, 0, size) : NULL;
    size_t first = middle ? (size_t)(middle - bytes) : size;
    fuzz_file("results.json", bytes, first);
    fuzz_file("report.html", middle ? middle + 1 : bytes, middle ? size - first - 1 : 0);
    struct bench_data data;
    if (bench_load(fuzz_folder(), &data)) {
        if (!json_is_object(data.root)) abort();
        if (!data.pictures) data.pictures = json_object();
        struct bench_case where = {.scene = "builtin:spheres", .lights = -1, .width = 32, .height = 18, .msaa = 1};
        struct bench_candidate what = {FNL_SHADING_DEFERRED, FNL_LISTS_TILED, (char[]){""}};
        bench_find(&data, &where, &what);
        bench_conclude(&data);
        bench_print(&data);
        bench_aa_print(&data);
        bench_coarse_print(&data);
        bench_tables_print(&data);
        bench_unequal_count(&data);
        if (!bench_save(fuzz_folder(), &data, middle != NULL)) abort(); /* the page is large */
    }
    json_decref(data.root);
    json_decref(data.pictures);
    return 0;
}
