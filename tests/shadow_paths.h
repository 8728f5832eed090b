/* SPDX-License-Identifier: MIT */
/** What holds for all that finds shadows in frames: lists and shading paths do not know of it. */
#ifndef FNL_TESTS_SHADOW_PATHS_H
#define FNL_TESTS_SHADOW_PATHS_H

#include "tests/render_harness.h"

/** Several kinds of lists give the picture of brute force, to the bit. */
void expect_lists_alike(fnl_shadows shadows);
/** Each path with shadows is as close to forward shading with shadows as both are without. With several samples a few paths are tried. */
void expect_paths_alike(fnl_shadows shadows, uint32_t msaa);

/** The same with settings that no path knows of: of the paths, those of shadow_path_kinds are tried. */
void expect_lists_alike_with(fnl_shadows shadows, const fnl_shadow_options *settings);
void expect_path_kinds_alike(fnl_shadows shadows, const fnl_shadow_options *settings);

/** In a draw, per tile, light before material, and from triangles: paths that stand for all others. */
enum { SHADOW_PATH_KINDS = 4 };
extern const fnl_shading shadow_path_kinds[SHADOW_PATH_KINDS];

#endif
