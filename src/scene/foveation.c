/* SPDX-License-Identifier: MIT */
/* Pictures whose resolution falls towards their edges. */
#include "base/check.h"
#include "base/maths.h"
#include "fanal/stereo.h"

fnl_result fnl_eye_query_cells(const fnl_host *host, const fnl_eye *eye, uint32_t width, uint32_t height, float inner, float scale, fnl_eye_cell cells[9]) {
    const fnl_host resolved = host_resolve(host);
    const struct call *call = CALL(&resolved);
    TRY(check_pointer(call, "eye", eye));
    TRY(check_pointer(call, "cells", cells));
    TRY(check_count(call, "width", width, 3, 16384));
    TRY(check_count(call, "height", height, 3, 16384));
    TRY(check_above(call, "inner", (double)inner, 0, 1, ""));
    TRY(check_above(call, "scale", (double)scale, 0, 1, ""));
    const uint32_t sizes[2] = {width, height};
    uint32_t starts[2][4], rendered[2][3];
    float edges[2][4];
    for (uint32_t axis = 0; axis < 2; axis++) {
        /* As many pixels on both sides, at least one each, so that cells that face each other have one size. */
        const uint32_t most = (sizes[axis] - 1) / 2, border = CLAMP((uint32_t)lroundf((1 - inner) * 0.5f * (float)sizes[axis]), 1u, most);
        const uint32_t at[4] = {0, border, sizes[axis] - border, sizes[axis]};
        const float from = axis ? eye->up : eye->left, to = axis ? eye->down : eye->right;
        for (uint32_t i = 0; i < 4; i++) {
            starts[axis][i] = at[i];
            edges[axis][i] = from + (to - from) * (float)at[i] / (float)sizes[axis];
        }
        for (uint32_t i = 0; i < 3; i++) rendered[axis][i] = i == 1 ? at[2] - at[1] : MAX((uint32_t)lroundf(scale * (float)border), 1u);
    }
    for (uint32_t i = 0; i < 9; i++) {
        const uint32_t x = i % 3, y = i / 3;
        cells[i] = (fnl_eye_cell){.eye = {eye->pose, edges[0][x], edges[0][x + 1], edges[1][y + 1], edges[1][y]},
                                  .x = starts[0][x],
                                  .y = starts[1][y],
                                  .width = starts[0][x + 1] - starts[0][x],
                                  .height = starts[1][y + 1] - starts[1][y],
                                  .rendered_width = rendered[0][x],
                                  .rendered_height = rendered[1][y]};
    }
    return FNL_OK;
}

fnl_vec2 fnl_lens_matched_place(fnl_vec2 strength, fnl_vec2 place, bool back) {
    const float w = strength.x * fabsf(place.x) + strength.y * fabsf(place.y), scale = back ? 1 - w : 1 + w;
    return (fnl_vec2){place.x / scale, place.y / scale};
}
