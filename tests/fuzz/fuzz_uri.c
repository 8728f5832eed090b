/* SPDX-License-Identifier: MIT */
/* URIs of buffers and images that a glTF names: whatever they are, the importer does not wait, leave its memory, or read one file twice. */
#include "scene/scene.h"
#include "tests/fuzz/fuzz.h"

#include <sys/stat.h>

static const char *make_folder(void) {
    static char folder[300];
    char path[320];
    if (*folder) return folder;
    snprintf(path, sizeof path, "%s/pipe", fuzz_folder());
    if (mkfifo(path, 0600) != 0) abort();
    snprintf(path, sizeof path, "%s/loop", fuzz_folder());
    if (symlink("loop", path) != 0) abort();
    fuzz_file("empty.bin", "", 0);
    fuzz_file("a b.bin", "0123456789abcdef", 16);
    fuzz_file("long.png", "\x89PNG\r\n\x1a\n", 8);
    snprintf(folder, sizeof folder, "%s/", fuzz_folder());
    return folder;
}

static size_t escape(const char *text, size_t length, char *out) {
    char *to = out;
    for (size_t i = 0; i < length; i++) {
        unsigned char c = (unsigned char)text[i];
        if (c == '"' || c == '\\') *to++ = '\\';
        *to++ = c < ' ' || c > '~' ? '?' : (char)c;
    }
    *to = 0;
    return (size_t)(to - out);
}

/* Lines: the first two are URIs of buffers, the third is that of an image. */
int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    enum { LINE_MAX_BYTES = 6000 };
    static char uris[3][2 * LINE_MAX_BYTES + 1], json[7 * LINE_MAX_BYTES];
    const char *text = (const char *)bytes, *end = text + size;
    for (int i = 0; i < 3; i++) {
        const char *line = text < end ? memchr(text, '\n', (size_t)(end - text)) : NULL;
        size_t length = line ? (size_t)(line - text) : (size_t)(end - text);
        escape(text, MIN(length, (size_t)LINE_MAX_BYTES), uris[i]);
        text = line ? line + 1 : end;
    }
    int length = snprintf(json, sizeof json,
                          "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":4,\"uri\":\"%s\"},"
                          "{\"byteLength\":9,\"uri\":\"%s\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":4},"
                          "{\"buffer\":1,\"byteLength\":9}],\"images\":[{\"uri\":\"%s\"},{\"uri\":\"%s\"},{\"bufferView\":1,"
                          "\"mimeType\":\"image/png\"}]}",
                          uris[0], uris[1], uris[2], uris[0]);
    fnl_host host = fuzz_host();
    fnl_scene *scene;
    make_folder();
    fnl_load_params params = fnl_load_params_default();
    params.lenient = size % 2;
    params.confine = size % 3 == 0;
    fnl_result result = fnl_scene_load(&host, fuzz_file("input.gltf", json, (size_t)length), &params, &scene);
    if (result != FNL_OK) {
        if (scene) abort();
        return 0;
    }
    static const struct file_identity none; /* of data: URIs */
    for (uint32_t i = 0; i < scene->files.count; i++)
        for (uint32_t k = 0; k < i; k++)
            if (memcmp(&scene->files.data[i].identity, &none, sizeof none) != 0 && memcmp(&scene->files.data[i].identity, &scene->files.data[k].identity, sizeof(struct file_identity)) == 0)
                abort();
    fnl_scene_destroy(&scene);
    return 0;
}
