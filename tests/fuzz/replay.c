/* SPDX-License-Identifier: MIT */
/* Runs a fuzz target once on nothing and on each file in the folders named, in the place of a fuzzer: the seeds as a test, with any compiler. */
#include "tests/fuzz/fuzz.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>

static bool run(const char *folder, const char *name) {
    char *path = NULL;
    uint8_t *bytes = NULL;
    size_t size = 0;
    bool done = asprintf(&path, "%s/%s", folder, name) > 0;
    FILE *file = done ? fopen(path, "rb") : NULL;
    for (size_t room = 0; file && !feof(file) && !ferror(file);) {
        room += 65536;
        bytes = realloc(bytes, room);
        if (!bytes) abort();
        size += fread(bytes + size, 1, room - size, file);
    }
    done = file && !ferror(file);
    if (file) fclose(file);
    if (done) LLVMFuzzerTestOneInput(bytes, size);
    else fprintf(stderr, "replay: %s cannot be read\n", path);
    free(bytes);
    free(path);
    return done;
}

int main(int count, char **folders) {
    int runs = 1;
    LLVMFuzzerTestOneInput((const uint8_t *)"", 0);
    for (int i = 1; i < count; i++) {
        DIR *folder = opendir(folders[i]);
        if (!folder) {
            perror(folders[i]);
            return 1;
        }
        for (struct dirent *entry; (entry = readdir(folder));) {
            if (entry->d_name[0] == '.') continue;
            if (!run(folders[i], entry->d_name)) return 1;
            runs++;
        }
        closedir(folder);
    }
    printf("%d runs\n", runs);
    return 0;
}
