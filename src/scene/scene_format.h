/* SPDX-License-Identifier: MIT */
/** Names that are no glTF file: folders, and scenes in formats that Fanal does not read. */
#ifndef FNL_SCENE_FORMAT_H
#define FNL_SCENE_FORMAT_H

#include "base/base.h"

/**
 * The scene that `path` stands for: the only .gltf or .glb of a folder, or the path itself where it is no folder. FNL_ERROR_FILE, logged: the folder holds
 * none or several, which are listed.
 */
fnl_result scene_find_file(const fnl_host *host, const char *path, char *out, size_t capacity);
/**
 * FNL_ERROR_UNSUPPORTED for a scene in another format (OBJ, FBX, USD …), with a message that says how to convert it. The format is known by the contents
 * where they have a mark, else by the extension of `name`. FNL_OK for all else, JSON in any case.
 */
fnl_result scene_refuse_foreign(const fnl_host *host, const char *name, const void *bytes, size_t size);

#endif
