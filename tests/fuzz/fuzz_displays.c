/* SPDX-License-Identifier: MIT */
/* Displays of `fanal cave` and tracks of heads: whatever the bytes, an error, or walls whose cameras can be made. */
#include "cli/cave/cave.h"
#include "tests/fuzz/fuzz.h"

/* A byte 0 parts the JSON from the file of the track, track.txt. */
int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    const uint8_t *middle = size ? memchr(bytes, 0, size) : NULL;
    const size_t first = middle ? (size_t)(middle - bytes) : size;
    struct cave_displays d;
    fuzz_file("track.txt", middle ? middle + 1 : bytes, middle ? size - first - 1 : 0);
    if (cave_displays_load(fuzz_file("displays.json", bytes, first), &d)) {
        const struct cave_options o = {.render.frame_time = 0.1};
        struct cave_view views[CAVE_VIEWS];
        fnl_camera camera = fnl_camera_default();
        if (d.wall_count == 0 || d.wall_count > CAVE_WALLS || d.track_count == 0) abort();
        const struct cave_moment m = cave_predict(&o, &d, 3, 0);
        const struct cave_place place = cave_find_place(&d, &m, &camera, false);
        const uint32_t count = cave_list_views(&o, &d, 0, views);
        if (count < d.wall_count || count > CAVE_VIEWS) abort();
        for (uint32_t i = 0; i < count; i++) {
            char path[64];
            cave_path("%w-%e-%04d.png", &d, &views[i], 3, path, sizeof path);
            if (!strstr(path, "-0003.png")) abort();
            if (cave_view_camera(&d, &place, &m, &views[i], &camera) && !(camera.vertical_fov > 0 && camera.vertical_fov < 3.1416f && camera.pixel_aspect > 0)) abort();
        }
    }
    cave_displays_free(&d);
    return 0;
}
