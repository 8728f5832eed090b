/* SPDX-License-Identifier: MIT */
#include "fanal/trace.h"

#include "base/check.h"
#include "scene/scene.h"

fnl_result fnl_scene_trace(const fnl_scene *scene, const fnl_trace_params *params, fnl_trace *out) {
    UNUSED(params);
    TRY(check_handle(__func__, "scene", scene));
    TRY(check_pointer(CALL(&scene->host), "out", out));
    *out = (fnl_trace){0};
    return unsupported(
        CALL(&scene->host),
        "Fanal was built without Embree; install it (Debian and Ubuntu: libembree-dev) and build with -DFANAL_RAY=ON");
}
