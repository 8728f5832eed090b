/* SPDX-License-Identifier: MIT */
#include "tests/figure_file.h"
#include "tests/figure_load.h"

bool figure_load(const fnl_host *host, const char *name, fnl_scene **out) {
    const struct figure *figure = figure_find(name);
    size_t size;
    if (!figure) return false;
    unsigned char *glb = figure_glb(figure, &size);
    const bool good = gltf_load_memory(host, glb, size, name, NULL, out) == FNL_OK;
    free(glb);
    return good;
}
