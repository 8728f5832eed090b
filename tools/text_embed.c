/* SPDX-License-Identifier: MIT */
/* Build tool: text_embed NAME IN OUT.c writes a text file as the C definitions of NAME and NAME_size. With IN "" the text is empty. */
#include <stdio.h>

int main(int argc, char **argv) {
    if (argc != 4) {
        fprintf(stderr, "usage: text_embed NAME IN OUT.c\n");
        return 2;
    }
    FILE *in = *argv[2] ? fopen(argv[2], "rb") : NULL, *out = fopen(argv[3], "w");
    if ((*argv[2] && !in) || !out) {
        perror(in || !*argv[2] ? argv[3] : argv[2]);
        return 1;
    }
    unsigned long size = 0;
    fprintf(out, "/* SPDX-License-Identifier: MIT */\n#include \"bench_page_parts.h\"\n\nconst char %s[] = {", argv[1]);
    for (int byte; in && (byte = fgetc(in)) != EOF; size++)
        fprintf(out, byte < 128 ? "%s%d," : "%s'\\%o',", size % 24 ? " " : "\n    ", byte);
    fprintf(out, "\n    0};\nconst size_t %s_size = %lu;\n", argv[1], size);
    int failed = ferror(out) || (in && ferror(in));
    if (in) fclose(in);
    failed |= fclose(out);
    if (failed) {
        fprintf(stderr, "%s: cannot be written\n", argv[3]);
        remove(argv[3]);
    }
    return failed != 0;
}
