/* SPDX-License-Identifier: MIT */
/* A program outside the tree: it knows the installed headers and library alone. */
#include <fanal/scene.h>

#include <stdio.h>
#include <string.h>

int main(void) {
    fnl_scene *scene = NULL;
    fnl_scene_info info;
    char version[32];
    snprintf(version, sizeof(version), "%d.%d.%d", FNL_VERSION_MAJOR, FNL_VERSION_MINOR, FNL_VERSION_PATCH);
    if (strcmp(version, fnl_version()) != 0) return 1;
    if (fnl_scene_load(NULL, "builtin:spheres", NULL, &scene) != FNL_OK) return 1;
    fnl_result result = fnl_scene_query_info(scene, &info);
    fnl_scene_destroy(&scene);
    if (result != FNL_OK || info.triangle_count == 0) return 1;
    printf("fanal %s: %llu triangles\n", version, (unsigned long long)info.triangle_count);
    return 0;
}
