/* SPDX-License-Identifier: MIT */
#ifndef FNL_TESTS_FIGURE_LOAD_H
#define FNL_TESTS_FIGURE_LOAD_H

#include "scene/scene.h"

/** What figure_file.h makes in the place of a sample; false: nothing replaces it. */
bool figure_load(const fnl_host *host, const char *name, fnl_scene **out);

#endif
