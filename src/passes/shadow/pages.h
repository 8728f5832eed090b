/* SPDX-License-Identifier: MIT */
/**
 * Which pages of shadow maps there are (shadows/maps_shared.h), and where in the atlas. Pixels have asked for pages at the level that suits
 * them; here every row, of a local light or of a block of a directional one, with a page to be shown is given some, however many there are. If all that was asked for does not fit, pages become
 * coarser, those of the least important lights first: under a pressure of p a light with offset o gets pages min(max(p - o, 0), 7) levels
 * coarser, where o is half the logarithm to base 2 of how many times more important than the least important one it is, rounded down, at most
 * 8. (Before that, under pressures that are not counted here, oblong blocks of suns become coarser, by two levels at
 * most. Then they are dropped, and square blocks replace them.)
 * Importance is flux times the part of the directions round the viewer that the light's volume takes. The least pressure under which all
 * fit is taken, and of the lights under it the most important ones stay under the pressure before as far as there is room; the choice depends on
 * this frame alone, so it cannot swing. Only where even the coarsest pages of all lights do not fit, from
 * pressure 16 on, do the least important lights have none (SHADOW_TRACED).
 *
 * A page that was there in the last frame stays in its place and is drawn again only if its light has changed, or if it was not drawn then. One that nobody looks up any more
 * is idle: it stays while its light is as it was and there is room. New pages take free places in cells (of SHADOW_PAGE texels) that hold pages of
 * their size, then free cells, then those cells that have held nothing but idle pages for longest; if that is not enough, all idle pages go. Where
 * the places of wanted pages are so scattered that the new ones still do not fit, all pages are laid out anew, and drawn. Everything is done by
 * counts and prefix sums, so two runs give the same bytes.
 *
 * Cost: 1.2 KiB for each row (and the atlas, and 2 KiB for each of its cells of 128 x 128 texels); a few dozen operations for each face of a
 * light, and for each page that there is room for.
 */
#ifndef FNL_PASSES_SHADOW_PAGES_H
#define FNL_PASSES_SHADOW_PAGES_H

#include "passes/lighting/lighting.h"
#include "passes/shadow/split.h"
#include "shadows/maps_shared.h"

/** The part of struct shadow_state that a frame changes. */
struct shadow_turn {
    uint32_t row_count;
    uint32_t turn;          /* which of the two of each buffer hold the pages */
    bool known;             /* the pages are in the atlas */
    bool cleared;           /* the atlas is cleared */
    uint32_t kept;          /* frames that shadow_pages_again() was called in since */
    bool splits;            /* the frame had a split */
};

/** What a view keeps between frames. Zeroed: nothing yet. */
struct shadow_state {
    struct gpu_buffer held[2], before[2], pages[2]; /* of the last frame and of this one, in turns */
    struct gpu_buffer shapes, counts, biases;
    struct gpu_buffer least; /* the least depths of squares of texels (dark_shared.h), of pages that were drawn */
    struct gpu_image atlas; /* D32_SFLOAT; an attachment, and sampled */
    uint32_t row_room;      /* rows that there is memory for */
    struct gpu_buffer split;  /* struct gpu_shadow_split_row for each row */
    struct shadow_turn last;
};
void shadow_state_finish(gpu_device *device, struct shadow_state *state);
/** All pages of the next frame are drawn: after what they show has changed as a whole, and after a frame that was declared and not executed. */
void shadow_state_forget(struct shadow_state *state);

/**
 * Memory for a frame; before it begins. `row_count` is at most SHADOW_MOST_ROWS, `atlas_side` a multiple of SHADOW_PAGE, in texels. Where one
 * outgrows what there is, or the atlas changes, all pages are drawn anew. After an error the state is empty.
 */
fnl_result shadow_pages_prepare(gpu_device *device, struct shadow_state *state, uint32_t row_count, uint32_t atlas_side);

struct shadow_pages_input {
    graph_buffer wanted; /* SHADOW_ROW_WORDS words for each row: a bit for each page that a pixel asks for */
    graph_buffer suns;   /* of shadow_suns_add(). id 0: directional lights have no rows */
    graph_buffer keys;   /* of shadow_oblong_add(). id 0: no oblong block has a row */
    VkDeviceAddress updates; /* a number for each directional, then each local light: not 0, and its pages are drawn again where it is another than in the last frame. 0: 0 for all */
    const struct shadow_split_input *split; /* NULL: all lights that cast shadows have maps (split.h) */
    const struct lighting *lighting; /* whose lights' rows they are: at least one, as many as the state was prepared for or fewer */
};
struct shadow_pages {
    graph_buffer held, before, pages,
        biases, shapes;  /* as struct gpu_shadow_maps has them; `before` is undefined for words without pages */
    graph_buffer counts; /* struct gpu_shadow_counts, whose `pairs` is 0 */
    graph_buffer least;  /* of the state */
    graph_buffer split, split_counts; /* with a split: of the state, and struct gpu_shadow_split_counts */
    graph_image
        atlas; /* holds what pages without SHADOW_PAGE_DRAW show; others are to be cleared and drawn, but for idle ones */
    uint32_t row_count;
    uint32_t page_limit; /* room in `pages` */
};
/**
 * Once a frame, after shadow_pages_prepare(). When the frame is submitted, `next` becomes state->last. All passes are on the graphics queue. More rows than
 * prepared for are an error of the device.
 */
struct shadow_pages shadow_pages_add(struct graph *graph, gpu_device *device, const struct shadow_state *state,
                                     const struct shadow_pages_input *input, struct shadow_turn *next);
/**
 * In place of it, where its input would be that of the last frame and that frame left all pages as they were: none drawn, evicted or waiting. Adds no passes.
 * Nothing is changed, ages apart, which the next shadow_pages_add() brings up to date.
 */
struct shadow_pages shadow_pages_again(struct graph *graph, const struct shadow_state *state, struct shadow_turn *next);

#endif
