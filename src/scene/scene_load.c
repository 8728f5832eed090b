/* SPDX-License-Identifier: MIT */
/* The public calls that load a scene. */
#include "base/check.h"
#include "scene/scene.h"

#include <unistd.h>

fnl_load_params fnl_load_params_default(void) {
    long pages = sysconf(_SC_PHYS_PAGES), page_size = sysconf(_SC_PAGESIZE);
    bool known = pages > 0 && page_size > 0;
    return (fnl_load_params){.max_memory = known ? (uint64_t)pages * (uint64_t)page_size / 2 : (uint64_t)4 << 30};
}

fnl_result fnl_scene_load(const fnl_host *host, const char *source, const fnl_load_params *params, fnl_scene **out) {
    static const char prefix[] = "builtin:";
    fnl_host resolved = host_resolve(host);
    TRY(check_pointer(CALL(&resolved), "out", out));
    *out = NULL;
    TRY(check_pointer(CALL(&resolved), "source", source));
    if (strncmp(source, prefix, sizeof prefix - 1) == 0) return builtin_load(&resolved, source + sizeof prefix - 1, out);
    return gltf_load(&resolved, source, params, out);
}

fnl_result fnl_scene_load_memory(const fnl_host *host, const void *data, size_t size, const char *name,
                                 const fnl_load_params *params, fnl_scene **out) {
    fnl_host resolved = host_resolve(host);
    TRY(check_pointer(CALL(&resolved), "out", out));
    *out = NULL;
    if (size) TRY(check_pointer(CALL(&resolved), "data", data));
    TRY(check_pointer(CALL(&resolved), "name", name));
    return gltf_load_memory(&resolved, data, size, name, params, out);
}
