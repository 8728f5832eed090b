/* SPDX-License-Identifier: MIT */
#include "argument_next.h"

#include "print.h"

#include <ctype.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

/* What is wrong, in place of the messages of getopt_long(), which print an argument as it is. */
static void complain(char **argv, int option, const struct option *options) {
    const char *argument = argv[optind - 1];
    const bool is_long = strncmp(argument, "--", 2) == 0;
    const int length = (int)strcspn(argument, "=");
    int count = 0;
    for (const struct option *o = options; is_long && o->name; o++) count += strncmp(o->name, argument + 2, (size_t)length - 2) == 0;
    if (option == ':') fprintf(stderr, "fanal: error: %s needs a value", argument);
    else if (is_long && optopt) fprintf(stderr, "fanal: error: %.*s takes no value", length, argument);
    else if (is_long && count == 0) fprintf(stderr, "fanal: error: there is no option '%.*s'", length, argument);
    else if (!is_long) fprintf(stderr, "fanal: error: there is no option '-%c'", optopt);
    else fprintf(stderr, "fanal: error: '%.*s' could be", length, argument);
    for (const struct option *o = options; is_long && !optopt && o->name; o++)
        if (strncmp(o->name, argument + 2, (size_t)length - 2) == 0) fprintf(stderr, "%s --%s", --count ? "" : " or", o->name);
    fprintf(stderr, "; see 'fanal %s --help'\n", argv[0]);
}

int argument_next(int argc, char **argv, const char *letters, const struct option *options) {
    char quiet[32];
    snprintf(quiet, sizeof quiet, ":%s", letters);
    optopt = 0;
    int option = getopt_long(argc, argv, quiet, options, NULL);
    if (option == '?' || option == ':') {
        complain(argv, option, options);
        return '?';
    }
    if (option != -1 && optarg && !*optarg) {
        const char *name = argv[optind - (optarg == argv[optind - 1] ? 2 : 1)];
        fprintf(stderr, "fanal: error: the value of %.*s is empty; see 'fanal %s --help'\n", (int)strcspn(name, "="), name, argv[0]);
        return '?';
    }
    if (option == -1 || !optarg || optarg != argv[optind - 1] || optarg[0] != '-') return option;
    bool named = optarg[1] && !optarg[2] && isalpha((unsigned char)optarg[1]) && strchr(letters, optarg[1]);
    for (const struct option *o = options; o->name && optarg[1] == '-'; o++) {
        size_t length = strlen(o->name);
        named |= strncmp(optarg + 2, o->name, length) == 0 && (optarg[2 + length] == 0 || optarg[2 + length] == '=');
    }
    if (!named) return option;
    fprintf(stderr, "fanal: error: %s needs a value; '%s', which follows, is an option\n", argv[optind - 2], optarg);
    return '?';
}
