/* SPDX-License-Identifier: MIT */
#include "argument_next.h"

#include <ctype.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

int argument_next(int argc, char **argv, const char *letters, const struct option *options) {
    int option = getopt_long(argc, argv, letters, options, NULL);
    if (option == -1 || option == '?' || !optarg || optarg != argv[optind - 1] || optarg[0] != '-') return option;
    bool named = optarg[1] && !optarg[2] && isalpha((unsigned char)optarg[1]) && strchr(letters, optarg[1]);
    for (const struct option *o = options; o->name && optarg[1] == '-'; o++) {
        size_t length = strlen(o->name);
        named |= strncmp(optarg + 2, o->name, length) == 0 && (optarg[2 + length] == 0 || optarg[2 + length] == '=');
    }
    if (!named) return option;
    fprintf(stderr, "fanal: error: %s needs a value; '%s', which follows, is an option\n", argv[optind - 2], optarg);
    return '?';
}
