/* SPDX-License-Identifier: MIT */
/* The interface of scenes: whatever is called in whatever order, bad ids and values are refused and the scene keeps its own rules. */
#include "tests/fuzz/calls.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    fnl_host host = fuzz_host();
    struct fuzz_input in = {bytes, size};
    struct calls calls = {0};
    fnl_scene *scene;
    if (fnl_scene_create(&host, &scene) != FNL_OK) abort();
    for (int i = 0; in.size > 0 && i < 64; i++) calls_make(&in, scene, &calls);
    calls_check_scene(scene, &calls, 0);
    fnl_scene_destroy(&scene);
    return 0;
}
