/* SPDX-License-Identifier: MIT */
/**
 * Lists of what a visibility buffer shows: pixels, or with several samples the triangles of each pixel, counted, summed up and filled in; sorted
 * by what their materials need, so that each class is shaded by a variant of the shader that has nothing else, dispatched indirectly (RTR
 * 4, 20.5, names per-pixel sorts by material). Nothing depends on the order of atomics. Cost: ids are read twice, each four bits of the keys move
 * 8 bytes an entry three times.
 */
#ifndef FNL_PASSES_VISIBLE_H
#define FNL_PASSES_VISIBLE_H

#include "passes/visibility/visibility.h"
#include "passes/visibility/visible_shared.h"

struct visible_list {
    graph_buffer entries, ranges, dispatches; /* visible_shared.h; two words and three for each class */
    graph_buffer sums;
    graph_buffer words, counts; /* with several samples: samples_shared.h */
    uint32_t capacity;          /* entries */
    uint32_t listed;            /* VISIBLE_… */
    uint32_t classes; /* bit 1 << c: class c may occur; the entries of lists that are not sorted are all of class 0 */
};

/** `radiance` gets the background at pixels that show nothing, if it has one sample. */
struct visible_list visible_list_add(struct graph *graph, const struct shade_input *input,
                                     const struct visibility *visibility, enum visibility_sort sort, graph_image radiance);

/**
 * The same for surfaces that the caller tells apart, several samples a pixel: after `begin` a pass of the caller's fills `sums` (at visible.glsl's place
 * of a pixel: how many surfaces it shows; 0 at places beyond the picture), `words` and, all but EDGES_SHADED, `counts`, which are cleared. `end` lists them.
 */
struct visible_list visible_surfaces_begin(struct graph *graph, const struct shade_input *input, graph_image radiance);
void visible_surfaces_end(struct graph *graph, const struct shade_input *input, graph_image radiance,
                          struct visible_list *list);

/** Gives each sample of `radiance` the result of its triangle or surface, or the background; `results` in the order of unsorted entries, as
 *  store_result of samples.glsl writes them. */
void visible_spread_add(struct graph *graph, const struct shade_input *input, const struct visible_list *list,
                        graph_buffer results, graph_image radiance);

#endif
