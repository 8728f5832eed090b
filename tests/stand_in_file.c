/* SPDX-License-Identifier: MIT */
/* stand_in_file NAME FILE: writes the model that replaces a sample (stand_in.h), for tests of the command. */
#include "tests/stand_in.h"

#include <stdlib.h>

int main(int count, char **arguments) {
    size_t size;
    if (count != 3) return 2;
    unsigned char *glb = stand_in_model(arguments[1], &size);
    FILE *file = glb ? fopen(arguments[2], "wb") : NULL;
    const bool written = file && fwrite(glb, 1, size, file) == size;
    free(glb);
    return (!file || fclose(file) == 0) && written ? 0 : 1;
}
