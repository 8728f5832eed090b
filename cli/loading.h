/* SPDX-License-Identifier: MIT */
/** The options of loading, which render, bench and info share. */
#ifndef FNL_CLI_LOADING_H
#define FNL_CLI_LOADING_H

#include "fanal/fanal.h"

/* Below all others, which are characters or begin at 256. */
enum { LOADING_LENIENT = 1, LOADING_CONFINE, LOADING_MAX_MEMORY, LOADING_END };

/** Rows for a table of getopt_long. */
#define LOADING_OPTIONS                                                                                                     \
    {"lenient", no_argument, NULL, LOADING_LENIENT}, {"confine", no_argument, NULL, LOADING_CONFINE},                       \
        {"max-memory", required_argument, NULL, LOADING_MAX_MEMORY}

#define LOADING_VARIANT_HELP                                                                                                \
    "  --variant NAME|INDEX       shows the file's meshes with this variant of their materials ('fanal info' lists them)\n"
/** Lines for a help text. */
#define LOADING_HELP                                                                                                        \
    "  --lenient                  loads what it can of a file that is refused otherwise: one that requires an extension\n"  \
    "                             that Fanal does not show, or whose data is missing\n"                                     \
    "  --confine                  refuses to read files outside the scene's folder\n"                                       \
    "  --max-memory SIZE          how much memory the file, and the environment's, may each decode to: bytes,\n"  \
    "                             or with K, M or G (half of the machine's)\n"

/** Whether an option that getopt_long gave is one of them. */
bool loading_has(int option);
/** Takes its value; false (printed) when that is bad. */
bool loading_parse(int option, const char *value, fnl_load_params *out);

/** Whether a scene is one of the built-in ones, by its name. */
bool loading_is_builtin(const char *source);
/**
 * What --lights N means everywhere: a built-in scene has N lights altogether, a file N more. `text` gets the source to load, with lights=N in the name of
 * a built-in scene, and the result is how many lights to scatter in it. `count` below 0: --lights is not given. `scattered`: those of a built-in scene
 * are scattered too, in place of its own.
 */
uint32_t loading_lights(const char *source, int64_t count, bool scattered, char *text, size_t capacity);
/** Shows the variant of materials with this name or number; NULL: none. False with a message that lists what there is. `out` (or NULL)
 * gets its number, FNL_NO_VARIANT for none. */
bool loading_select_variant(fnl_scene *scene, const char *variant, uint32_t *out);

#endif
