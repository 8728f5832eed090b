/* SPDX-License-Identifier: MIT */
/* The public calls that load a scene. */
#include "base/check.h"
#include "scene/scene.h"
#include "scene/scene_format.h"


fnl_load_params fnl_load_params_default(void) { return (fnl_load_params){.max_memory = host_memory_limit()}; }

/* The settings of a built-in scene, or NULL: it is a file. */
static const char *builtin_of(const char *source) {
    static const char prefix[] = "builtin:";
    return strncmp(source, prefix, sizeof prefix - 1) == 0 ? source + sizeof prefix - 1 : NULL;
}

static fnl_result load_file(const struct call *call, const char *source, const fnl_load_params *params, fnl_scene **out) {
    if (params && params->size) TRY(check_pointer(call, "params.data", params->data));
    if (params && params->data) return gltf_load_memory(call->host, params->data, params->size, source, params, out);
    char path[4096];
    TRY(scene_find_file(call->host, source, path, sizeof path));
    return gltf_load(call->host, path, params, out);
}

fnl_result fnl_scene_load(const fnl_host *host, const char *source, const fnl_load_params *params, fnl_scene **out) {
    fnl_host resolved = host_resolve(host);
    TRY(check_pointer(CALL(&resolved), "out", out));
    *out = NULL;
    TRY(check_pointer(CALL(&resolved), "source", source));
    if (builtin_of(source)) return builtin_load(&resolved, builtin_of(source), out);
    return load_file(CALL(&resolved), source, params, out);
}

fnl_result fnl_scene_load_into(fnl_scene *scene, fnl_instance_id parent, const char *source, const fnl_load_params *params,
                               fnl_loaded *out) {
    if (out) *out = (fnl_loaded){0};
    TRY(check_handle(__func__, "scene", scene));
    const struct call *call = CALL(&scene->host);
    TRY(check_pointer(call, "source", source));
    bool under = parent.index || parent.generation;
    if (under) TRY(scene_check_instance(call, scene, parent));
    if (builtin_of(source)) return unsupported(call, "%s is a built-in scene, which is no part of another", source);
    fnl_scene *loaded;
    TRY(load_file(call, source, params, &loaded));
    fnl_result result = fnl_scene_set_environment(loaded, NULL);
    if (result == FNL_OK) result = scene_merge(scene, under ? parent.index : SCENE_NONE, loaded, out);
    fnl_scene_destroy(&loaded);
    return result;
}
