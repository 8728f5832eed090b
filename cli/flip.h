/* SPDX-License-Identifier: MIT */
/**
 * FLIP: how different two pictures look to somebody who flips between them, 0 (not) to 1. By P. Andersson, J. Nilsson, T. Akenine-Möller,
 * M. Oskarsson, K. Åström and M. D. Fairchild, "FLIP: A Difference Evaluator for Alternating Images", Proceedings of the ACM on Computer
 * Graphics and Interactive Techniques 3(2), 2020, from its formulas.
 */
#ifndef FNL_CLI_FLIP_H
#define FNL_CLI_FLIP_H

#include "fanal/image.h"

/** What the paper supposes: 0.7 m before a screen that is 0.7 m wide and has 3840 pixels. */
#define FLIP_PIXELS_PER_DEGREE 67.0206432765823

/**
 * The mean over the pixels of two sRGB pictures of one size, RGBA8 or RGBA16; alpha does not count. `map` (or NULL) gets the value of each
 * pixel. Negative when memory ran out.
 */
double flip_compare(const fnl_image *a, const fnl_image *b, double pixels_per_degree, float *map);

#endif
