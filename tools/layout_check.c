/* SPDX-License-Identifier: MIT */
/*
 * Build tool: layout_check OUT.c HEADER… -- MODULE.spv… writes a C file that includes the headers and asserts that every
 * struct gpu_* of the modules has the same member offsets in C, and the same size where it is an array's element. Only
 * structs that lie in buffers or push constants count (their members carry Offset decorations); blocks themselves have no
 * twin in C. Opcodes and layouts of instructions: the SPIR-V specification, sections 2.3 and 3.49.
 */
#include <inttypes.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SPIRV_MAGIC 0x07230203u
#define PREFIX "gpu_"

enum {
    OP_NAME = 5,
    OP_MEMBER_NAME = 6,
    OP_TYPE_ARRAY = 28,
    OP_TYPE_RUNTIME_ARRAY = 29,
    OP_DECORATE = 71,
    OP_MEMBER_DECORATE = 72
};
enum { DECORATION_BLOCK = 2, DECORATION_BUFFER_BLOCK = 3, DECORATION_ARRAY_STRIDE = 6, DECORATION_OFFSET = 35 };

static void die(const char *path, const char *what) {
    fprintf(stderr, "layout_check: %s: %s\n", path, what);
    exit(1);
}

static void *resize(void *old, size_t size) {
    void *block = realloc(old, size);
    if (!block) die("memory", "ran out");
    return block;
}

/** The lines of the result; duplicates go when they are sorted. */
static struct {
    char **data;
    size_t count;
} lines;

static void add_line(const char *expression, const char *type, const char *member, uint32_t number) {
    char line[1024];
    int length = snprintf(line, sizeof(line), "_Static_assert(%s(struct %s%s%s) == %" PRIu32 ", \"C and GLSL differ\");\n",
                          expression, type, *member ? ", " : "", member, number);
    if (length < 0 || (size_t)length >= sizeof(line)) die(type, "has too long a name");
    lines.data = resize(lines.data, (lines.count + 1) * sizeof(*lines.data));
    lines.data[lines.count] = resize(NULL, (size_t)length + 1);
    memcpy(lines.data[lines.count++], line, (size_t)length + 1);
}

static int compare_lines(const void *a, const void *b) { return strcmp(*(char *const *)a, *(char *const *)b); }

static uint32_t *read_module(const char *path, size_t *count) {
    FILE *file = fopen(path, "rb");
    if (!file || fseek(file, 0, SEEK_END)) die(path, "cannot be read");
    long size = ftell(file);
    if (size < 20 || size % 4) die(path, "is not SPIR-V");
    rewind(file);
    uint32_t *words = resize(NULL, (size_t)size);
    *count = (size_t)size / 4;
    if (fread(words, 4, *count, file) != *count) die(path, "cannot be read");
    fclose(file);
    if (words[0] != SPIRV_MAGIC) die(path, "is not SPIR-V");
    return words;
}

/** Steps through a module's instructions: false at the end. */
static bool next(const char *path, const uint32_t *words, size_t count, size_t *at, uint32_t *op, uint32_t *length) {
    if (*at == 0) {
        *at = 5;
    } else {
        *at += *length;
    }
    if (*at >= count) return false;
    *op = words[*at] & 0xffff;
    *length = words[*at] >> 16;
    if (*length == 0 || *at + *length > count) die(path, "ends within an instruction");
    return true;
}

static void check_module(const char *path) {
    size_t count;
    uint32_t *words = read_module(path, &count);
    uint32_t bound = words[3], op, length;
    struct id {
        const char *name;
        uint32_t stride, element;
        bool block;
    } *ids = resize(NULL, bound * sizeof(*ids));
    memset(ids, 0, bound * sizeof(*ids));
    for (size_t at = 0; next(path, words, count, &at, &op, &length);) {
        const uint32_t *w = words + at;
        if (length < 3 || w[1] >= bound) continue;
        struct id *id = &ids[w[1]];
        if (op == OP_NAME) id->name = (const char *)&w[2];
        if (op == OP_DECORATE && (w[2] == DECORATION_BLOCK || w[2] == DECORATION_BUFFER_BLOCK)) id->block = true;
        if (op == OP_DECORATE && w[2] == DECORATION_ARRAY_STRIDE && length > 3) id->stride = w[3];
        if ((op == OP_TYPE_ARRAY || op == OP_TYPE_RUNTIME_ARRAY) && w[2] < bound) id->element = w[2];
    }
    for (size_t at = 0; next(path, words, count, &at, &op, &length);) {
        const uint32_t *w = words + at;
        if (op != OP_MEMBER_DECORATE || length < 5 || w[3] != DECORATION_OFFSET || w[1] >= bound) continue;
        const struct id *type = &ids[w[1]];
        if (type->block || !type->name || strncmp(type->name, PREFIX, strlen(PREFIX)) != 0) continue;
        const char *member = NULL;
        uint32_t inner_op, inner_length;
        for (size_t i = 0; next(path, words, count, &i, &inner_op, &inner_length);) {
            if (inner_op == OP_MEMBER_NAME && words[i + 1] == w[1] && words[i + 2] == w[2])
                member = (const char *)&words[i + 3];
        }
        if (!member) die(path, "has no member names: compile shaders without stripping them");
        add_line("offsetof", type->name, member, w[4]);
    }
    for (uint32_t i = 0; i < bound; i++) {
        const struct id *element = &ids[ids[i].element];
        if (!ids[i].element || !ids[i].stride || !element->name || element->block) continue;
        if (strncmp(element->name, PREFIX, strlen(PREFIX)) != 0) continue;
        add_line("sizeof", element->name, "", ids[i].stride);
    }
    free(ids);
    free(words);
}

int main(int argc, char **argv) {
    int first_module = 2;
    while (first_module < argc && strcmp(argv[first_module], "--") != 0) first_module++;
    if (first_module >= argc) die("usage", "layout_check OUT.c HEADER… -- MODULE.spv…");
    for (int i = first_module + 1; i < argc; i++) check_module(argv[i]);
    if (lines.count) qsort(lines.data, lines.count, sizeof(*lines.data), compare_lines);

    FILE *out = fopen(argv[1], "w");
    if (!out) die(argv[1], "cannot be written");
    fprintf(out, "/* SPDX-License-Identifier: MIT */\n#include <stddef.h>\n");
    for (int i = 2; i < first_module; i++) fprintf(out, "#include \"%s\"\n", argv[i]);
    for (size_t i = 0; i < lines.count; i++) {
        if (i == 0 || strcmp(lines.data[i], lines.data[i - 1]) != 0) fputs(lines.data[i], out);
    }
    for (size_t i = 0; i < lines.count; i++) free(lines.data[i]);
    free(lines.data);
    bool failed = ferror(out);
    if (fclose(out) || failed) {
        remove(argv[1]);
        die(argv[1], "cannot be written");
    }
    return 0;
}
