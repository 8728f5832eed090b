/* SPDX-License-Identifier: MIT */
/* Build tool: spirv_embed STEM.STAGE IN.spv OUT.c writes a SPIR-V module, compressed, as the C definition of shader_STEM_STAGE. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zstd.h>

#define SPIRV_MAGIC 0x07230203u

static uint32_t *read_words(const char *path, size_t *count) {
    FILE *file = fopen(path, "rb");
    uint32_t *words = NULL;
    size_t capacity = 0;
    if (!file) return NULL;
    for (*count = 0;;) {
        capacity = capacity ? capacity * 2 : 16384;
        uint32_t *bigger = realloc(words, capacity * sizeof(*words));
        if (!bigger) break;
        words = bigger;
        *count += fread(words + *count, sizeof(*words), capacity - *count, file);
        if (*count < capacity) {
            fclose(file);
            return words;
        }
    }
    free(words);
    fclose(file);
    return NULL;
}

enum { OP_VARIABLE = 59, OP_DECORATE = 71, STORAGE_INPUT = 1, STORAGE_OUTPUT = 3, DECORATION_LOCATION = 30, HEADER_WORDS = 5 };

static int is_variable(const uint32_t *words, size_t count, uint32_t id, uint32_t storage) {
    for (size_t i = HEADER_WORDS, length; i < count && (length = words[i] >> 16) && length <= count - i; i += length)
        if ((words[i] & 0xffffu) == OP_VARIABLE && words[i + 2] == id) return words[i + 3] == storage;
    return 0;
}

/* Bits of the locations of inputs or outputs; spirv-opt has removed those that nothing uses. */
static uint32_t find_locations(const uint32_t *words, size_t count, uint32_t storage) {
    uint32_t bits = 0;
    for (size_t i = HEADER_WORDS, length; i < count && (length = words[i] >> 16) && length <= count - i; i += length)
        if ((words[i] & 0xffffu) == OP_DECORATE && words[i + 2] == DECORATION_LOCATION && words[i + 3] < 32 &&
            is_variable(words, count, words[i + 1], storage))
            bits |= 1u << words[i + 3];
    return bits;
}

int main(int argc, char **argv) {
    if (argc != 4) {
        fprintf(stderr, "usage: spirv_embed STEM.STAGE IN.spv OUT.c\n");
        return 2;
    }
    size_t count = 0;
    uint32_t *words = read_words(argv[2], &count);
    if (!words || count < 5 || words[0] != SPIRV_MAGIC) {
        fprintf(stderr, "%s: cannot be read, or is not SPIR-V\n", argv[2]);
        free(words);
        return 1;
    }
    size_t size = count * sizeof(*words), bound = ZSTD_compressBound(size);
    unsigned char *bytes = malloc(bound);
    size_t packed = bytes ? ZSTD_compress(bytes, bound, words, size, 19) : (size_t)-1;
    uint32_t inputs = find_locations(words, count, STORAGE_INPUT), outputs = find_locations(words, count, STORAGE_OUTPUT);
    free(words);
    if (!bytes || ZSTD_isError(packed)) {
        fprintf(stderr, "%s: cannot be compressed\n", argv[2]);
        free(bytes);
        return 1;
    }
    FILE *out = fopen(argv[3], "w");
    if (!out) {
        perror(argv[3]);
        free(bytes);
        return 1;
    }
    fprintf(out, "/* SPDX-License-Identifier: MIT */\n#include \"shaders.h\"\n\nstatic const unsigned char packed[%zu] = {", packed);
    for (size_t i = 0; i < packed; i++) fprintf(out, "%s%u,", i % 32 ? "" : "\n    ", bytes[i]);
    fprintf(out, "\n};\n\nconst struct gpu_shader shader_");
    for (const char *c = argv[1]; *c; c++) fputc(*c == '.' ? '_' : *c, out);
    fprintf(out, " = {\"%s\", packed, sizeof(packed), %zu, 0x%xu, 0x%xu};\n", argv[1], size, inputs, outputs);
    free(bytes);
    int failed = ferror(out);
    failed |= fclose(out);
    if (failed) {
        fprintf(stderr, "%s: cannot be written\n", argv[3]);
        remove(argv[3]);
        return 1;
    }
    return 0;
}
