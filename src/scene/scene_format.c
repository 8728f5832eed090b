/* SPDX-License-Identifier: MIT */
#include "scene/scene_format.h"

#include "base/file.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* ---- other formats ---- */

enum converter { ASSIMP, BLENDER, UNZIP };

/* By their marks first: a file may have any name. The zip is after what is zipped. */
static const struct format {
    const char *extension, *name, *mark; /* mark: how the contents begin; "": nothing tells */
    enum converter converter;
} formats[] = {
    {"usda", "a USD scene", "#usda ", BLENDER},
    {"usdc", "a USD scene", "PXR-USDC", BLENDER},
    {"usd", "a USD scene", "", BLENDER},
    {"usdz", "a USD scene", "", BLENDER},
    {"fbx", "an FBX file", "Kaydara FBX Binary", BLENDER},
    {"blend", "a Blender file", "BLENDER", BLENDER},
    {"ply", "a PLY file", "ply\n", ASSIMP},
    {"ply", "a PLY file", "ply\r", ASSIMP},
    {"stl", "an STL file", "solid ", ASSIMP},
    {"obj", "a Wavefront OBJ file", "", ASSIMP},
    {"3ds", "a 3DS file", "", ASSIMP},
    {"dae", "a COLLADA file", "", ASSIMP},
    {"zip", "a zip archive", "PK\3\4", UNZIP},
};

static bool begins_with(const void *bytes, size_t size, const char *mark) {
    const size_t length = strlen(mark);
    return length > 0 && size >= length && memcmp(bytes, mark, length) == 0;
}

static bool is_json(const char *text, size_t size) {
    size_t i = size >= 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0 ? 3 : 0;
    while (i < size && (text[i] == ' ' || text[i] == '\t' || text[i] == '\r' || text[i] == '\n')) i++;
    return i < size && (text[i] == '{' || text[i] == '[');
}

static const struct format *find_format(const char *name, const void *bytes, size_t size) {
    const struct format *by_mark = NULL, *by_name = NULL;
    for (size_t i = COUNT_OF(formats); i-- > 0;) {
        if (begins_with(bytes, size, formats[i].mark)) by_mark = &formats[i];
        if (path_has_extension(name, formats[i].extension)) by_name = &formats[i];
    }
    return by_mark && !(by_mark->converter == UNZIP && by_name) ? by_mark : by_name;
}

fnl_result scene_refuse_foreign(const fnl_host *host, const char *name, const void *bytes, size_t size) {
    const struct format *format = size == 0 || is_json(bytes, size) || begins_with(bytes, size, "glTF") ? NULL : find_format(name, bytes, size);
    if (!format) return FNL_OK;
    const char *extension = path_extension(name);
    const int stem = (int)strlen(name) - (*extension ? (int)strlen(extension) + 1 : 0);
    static const char reads[] = "Fanal reads glTF 2.0, as .gltf or .glb";
    if (format->converter == UNZIP)
        log_error(host, "%s: is %s. %s: unpack the archive and open the scene in it", name, format->name, reads);
    else if (format->converter == BLENDER)
        log_error(host, "%s: is %s. %s: convert it with Blender (File > %s, then File > Export > glTF 2.0)", name, format->name, reads,
                  strcmp(format->extension, "blend") == 0 ? "Open" : "Import");
    else
        log_error(host, "%s: is %s. %s: convert it by 'assimp export %s %.*s.glb' (Debian: assimp-utils), or with Blender (File > Export > glTF 2.0)", name,
                  format->name, reads, name, stem, name);
    return FNL_ERROR_UNSUPPORTED;
}

/* ---- folders ---- */

static int is_scene(const struct dirent *entry) {
    return entry->d_name[0] != '.' && (path_has_extension(entry->d_name, "gltf") || path_has_extension(entry->d_name, "glb"));
}

static void report_several(const fnl_host *host, const char *path, struct dirent *const *found, int count) {
    char list[1024] = "";
    int listed = 0;
    for (size_t used = 0; listed < count && used + strlen(found[listed]->d_name) + 3 < sizeof list; listed++)
        used += (size_t)snprintf(list + used, sizeof list - used, "%s%s", listed ? ", " : "", found[listed]->d_name);
    if (listed < count)
        log_error(host, "%s: is a folder with %d scenes, %s and %d more: name one of them", path, count, list, count - listed);
    else
        log_error(host, "%s: is a folder with %d scenes, %s: name one of them", path, count, list);
}

fnl_result scene_find_file(const fnl_host *host, const char *path, char *out, size_t capacity) {
    struct stat status;
    struct dirent **found = NULL;
    const bool is_folder = stat(path, &status) == 0 && S_ISDIR(status.st_mode);
    const int count = is_folder ? scandir(path, &found, is_scene, alphasort) : 0;
    const size_t length = strlen(path);
    int written = 0;
    if (count < 0) {
        log_error(host, "%s: cannot be opened: %s", path, strerror(errno));
        return FNL_ERROR_FILE;
    }
    if (is_folder && count == 0) log_error(host, "%s: is a folder without a scene: it has no .gltf or .glb file", path);
    if (count > 1) report_several(host, path, found, count);
    if (!is_folder) written = snprintf(out, capacity, "%s", path);
    if (count == 1) written = snprintf(out, capacity, "%s%s%s", path, length && path[length - 1] == '/' ? "" : "/", found[0]->d_name);
    for (int i = 0; i < count; i++) free(found[i]);
    free(found);
    if (is_folder && count != 1) return FNL_ERROR_FILE;
    if (written >= 0 && (size_t)written < capacity) return FNL_OK;
    log_error(host, "%.64s…: the path is too long", path);
    return FNL_ERROR_FILE;
}
