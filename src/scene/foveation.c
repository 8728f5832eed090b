/* SPDX-License-Identifier: MIT */
/* Pictures whose resolution falls towards their edges: parts of an eye's picture that are rendered by themselves, and joined. */
#include "base/maths.h"
#include "scene/eye.h"

fnl_result fnl_eye_query_cells(const fnl_host *host, const fnl_eye *eye, uint32_t width, uint32_t height, float inner, float scale, fnl_eye_cell cells[9]) {
    const fnl_host resolved = host_resolve(host);
    const struct call *call = CALL(&resolved);
    TRY(eye_check(call, eye));
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

/* ---- lens-matched shading ---- */


static vec3 axis_of(const mat4 *m, uint32_t column) { return vec3_make(m->m[4 * column], m->m[4 * column + 1], m->m[4 * column + 2]); }

/* The tangents, in a cell that is turned so, of what an eye shows at its tangents. */
static fnl_vec2 seen_through(const mat4 *turn, fnl_vec2 tangents) {
    const vec3 p = vec3_make(tangents.x, tangents.y, -1);
    const float depth = -vec3_dot(axis_of(turn, 2), p);
    return (fnl_vec2){vec3_dot(axis_of(turn, 0), p) / depth, vec3_dot(axis_of(turn, 1), p) / depth};
}

/* How fast these grow with the tangents of the eye, at its axis, in x and y. The mapping also shears; the product of both is the growth of areas. */
static fnl_vec2 growth_of(const mat4 *turn) {
    const vec3 x = axis_of(turn, 0), y = axis_of(turn, 1), z = axis_of(turn, 2);
    const fnl_vec2 own = {x.x * z.z - x.z * z.x, y.y * z.z - y.z * z.y}, other = {x.y * z.z - x.z * z.y, y.x * z.z - y.z * z.x};
    const float scale = sqrtf(1 - other.x * other.y / (own.x * own.y)) / (z.z * z.z);
    return (fnl_vec2){own.x * scale, own.y * scale};
}

static mat4 turn_of(quat rotation) { return mat4_from_trs(vec3_make(0, 0, 0), quat_normalize(rotation), vec3_make(1, 1, 1)); }

/* Looks where 1 + x |tangent x| + y |tangent y| is the distance to a plane, whose signs are those of `slope`. */
static quat tilt(fnl_vec2 slope) {
    const float length = hypotf(slope.x, slope.y);
    return length > 0 ? quat_axis_angle(vec3_make(slope.y / length, -slope.x / length, 0), atanf(length)) : quat_identity();
}

fnl_result fnl_eye_query_quadrants(const fnl_host *host, const fnl_eye *eye, uint32_t width, uint32_t height,
                                   fnl_vec2 strength, fnl_eye_cell cells[4]) {
    const fnl_host resolved = host_resolve(host);
    const struct call *call = CALL(&resolved);
    TRY(eye_check(call, eye));
    TRY(check_pointer(call, "cells", cells));
    TRY(check_count(call, "width", width, 2, 16384));
    TRY(check_count(call, "height", height, 2, 16384));
    TRY(check_range(call, "strength.x", (double)strength.x, 0, 1, ""));
    TRY(check_range(call, "strength.y", (double)strength.y, 0, 1, ""));
    const float nearest = fminf(fminf(-eye->left, eye->right), fminf(-eye->down, eye->up));
    if (nearest < 1e-3f)
        return misuse(call, "eye: its axis is outside of its picture, or at the edge: left %g, right %g, down %g, up %g",
                      (double)eye->left, (double)eye->right, (double)eye->down, (double)eye->up);
    /* Parts meet at a corner of pixels, the one nearest to the eye's axis. */
    const float dx = (eye->right - eye->left) / (float)width, dy = (eye->up - eye->down) / (float)height;
    const uint32_t split_x = CLAMP((uint32_t)lroundf(-eye->left / dx), 1u, width - 1);
    const uint32_t split_y = CLAMP((uint32_t)lroundf(eye->up / dy), 1u, height - 1);
    const fnl_vec2 split = {eye->left + dx * (float)split_x, eye->up - dy * (float)split_y};
    fnl_vec2 steps[4];
    float most[2] = {0, 0}; /* pixels that a quadrant needs */
    for (uint32_t i = 0; i < 4; i++) {
        const bool right = i % 2, low = i / 2;
        const float edge_x = right ? eye->right : eye->left, edge_y = low ? eye->down : eye->up;
        const quat turn = tilt((fnl_vec2){strength.x / edge_x, strength.y / edge_y});
        const mat4 matrix = turn_of(turn);
        fnl_vec2 from = {INFINITY, INFINITY}, to = {-INFINITY, -INFINITY};
        for (uint32_t c = 0; c < 4; c++) {
            const fnl_vec2 place = {c % 2 ? edge_x : split.x, c / 2 ? edge_y : split.y}, corner = seen_through(&matrix, place);
            from = (fnl_vec2){fminf(from.x, corner.x), fminf(from.y, corner.y)};
            to = (fnl_vec2){fmaxf(to.x, corner.x), fmaxf(to.y, corner.y)};
        }
        const fnl_vec2 growth = growth_of(&matrix);
        steps[i] = (fnl_vec2){growth.x * dx, growth.y * dy};
        /* One more pixel on each side, for interpolation at the edges. */
        const fnl_rigid_pose pose = {eye->pose.position, quat_mul(eye->pose.rotation, turn)};
        cells[i] = (fnl_eye_cell){.eye = {.pose = pose, .left = from.x - steps[i].x, .up = to.y + steps[i].y},
                                  .x = right ? split_x : 0,
                                  .y = low ? split_y : 0,
                                  .width = right ? width - split_x : split_x,
                                  .height = low ? height - split_y : split_y};
        most[0] = fmaxf(most[0], ceilf((to.x - from.x) / steps[i].x - 1e-3f) + 2);
        most[1] = fmaxf(most[1], ceilf((to.y - from.y) / steps[i].y - 1e-3f) + 2);
    }
    if (!(most[0] <= 16384 && most[1] <= 16384))
        return misuse(call, "quadrants would need %g x %g pixels, must be within 16384: eye is too uneven", (double)most[0], (double)most[1]);
    for (uint32_t i = 0; i < 4; i++) {
        cells[i].rendered_width = (uint32_t)most[0];
        cells[i].rendered_height = (uint32_t)most[1];
        cells[i].eye.right = cells[i].eye.left + steps[i].x * most[0];
        cells[i].eye.down = cells[i].eye.up - steps[i].y * most[1];
    }
    return FNL_OK;
}

/* ---- joining ---- */

struct joined {
    const fnl_image *picture;
    float linear[256]; /* of a byte in sRGB */
};

static vec4 texel_at(const struct joined *j, uint32_t x, uint32_t y) {
    const size_t at = (size_t)y * j->picture->width + x;
    if (j->picture->format == FNL_PIXEL_FORMAT_RGBA32F) return ((const vec4 *)j->picture->pixels)[at];
    const uint8_t *b = (const uint8_t *)j->picture->pixels + 4 * at;
    return (vec4){j->linear[b[0]], j->linear[b[1]], j->linear[b[2]], (float)b[3] / 255};
}

static vec4 mix4(vec4 a, vec4 b, float t) {
    return t > 0 ? (vec4){a.x + (b.x - a.x) * t, a.y + (b.y - a.y) * t, a.z + (b.z - a.z) * t, a.w + (b.w - a.w) * t} : a;
}

/* At a place in pixels, where the middle of the first is 0, 0. Within a thousandth of a pixel its value is taken as it is. */
static vec4 value_at(const struct joined *j, fnl_vec2 place) {
    const float x = CLAMP(place.x, 0.0f, (float)(j->picture->width - 1)), y = CLAMP(place.y, 0.0f, (float)(j->picture->height - 1));
    const uint32_t left = (uint32_t)(x + 1e-3f), top = (uint32_t)(y + 1e-3f), right = MIN(left + 1, j->picture->width - 1), bottom = MIN(top + 1, j->picture->height - 1);
    const float u = x - (float)left < 1e-3f ? 0 : x - (float)left, v = y - (float)top < 1e-3f ? 0 : y - (float)top;
    return mix4(mix4(texel_at(j, left, top), texel_at(j, right, top), u), mix4(texel_at(j, left, bottom), texel_at(j, right, bottom), u), v);
}

static void join(const fnl_eye *eye, const fnl_eye_cell *cell, struct joined *j, fnl_image *out) {
    const quat back = {-eye->pose.rotation.x, -eye->pose.rotation.y, -eye->pose.rotation.z, eye->pose.rotation.w};
    const mat4 turn = turn_of(quat_mul(back, cell->eye.pose.rotation));
    const float dx = (eye->right - eye->left) / (float)out->width, dy = (eye->up - eye->down) / (float)out->height;
    const float across = (float)cell->rendered_width / (cell->eye.right - cell->eye.left), along = (float)cell->rendered_height / (cell->eye.up - cell->eye.down);
    for (uint32_t y = cell->y; y < cell->y + cell->height; y++)
        for (uint32_t x = cell->x; x < cell->x + cell->width; x++) {
            const fnl_vec2 at = seen_through(&turn, (fnl_vec2){eye->left + dx * ((float)x + 0.5f), eye->up - dy * ((float)y + 0.5f)});
            const vec4 value = value_at(j, (fnl_vec2){(at.x - cell->eye.left) * across - 0.5f, (cell->eye.up - at.y) * along - 0.5f});
            const size_t pixel = (size_t)y * out->width + x;
            if (out->format == FNL_PIXEL_FORMAT_RGBA32F) {
                ((vec4 *)out->pixels)[pixel] = value;
                continue;
            }
            uint8_t *byte = (uint8_t *)out->pixels + 4 * pixel;
            byte[0] = encode_byte(encode_srgb(value.x));
            byte[1] = encode_byte(encode_srgb(value.y));
            byte[2] = encode_byte(encode_srgb(value.z));
            byte[3] = encode_byte(value.w);
        }
}

static fnl_result check_cells(const struct call *call, const fnl_eye_cell *cells, uint32_t count, const fnl_image *pictures) {
    for (uint32_t i = 0; i < count; i++) {
        const fnl_eye_cell *cell = &cells[i];
        const fnl_image *picture = &pictures[i];
        char name[40];
        snprintf(name, sizeof name, "cells[%u].eye.pose", i);
        TRY(rigid_pose_check(call, name, &cell->eye.pose));
        if (cell->width > 16384 || cell->height > 16384 || cell->x > 16384 - cell->width || cell->y > 16384 - cell->height)
            return misuse(call, "cells[%u] ends beyond pixel 16384", i);
        if (!(cell->eye.left < cell->eye.right && cell->eye.down < cell->eye.up)) return misuse(call, "cells[%u].eye: edges must ascend", i);
        if (!picture->pixels) return misuse(call, "pictures[%u] has no pixels", i);
        if (picture->format == FNL_PIXEL_FORMAT_RGBA16 || picture->format != pictures[0].format) return misuse(call, "pictures[%u] must be RGBA8 or RGBA32F, as all of them", i);
        if (picture->width != cell->rendered_width || picture->height != cell->rendered_height || picture->width == 0 || picture->height == 0)
            return misuse(call, "pictures[%u] has %u x %u pixels, but its cell %u x %u", i, picture->width, picture->height, cell->rendered_width, cell->rendered_height);
    }
    return FNL_OK;
}

fnl_result fnl_eye_join_cells(const fnl_host *host, const fnl_eye *eye, const fnl_eye_cell *cells, uint32_t cell_count, const fnl_image *pictures, fnl_image *out) {
    const fnl_host resolved = host_resolve(host);
    const struct call *call = CALL(&resolved);
    TRY(check_pointer(call, "out", out));
    *out = (fnl_image){0};
    TRY(eye_check(call, eye));
    TRY(check_pointer(call, "cells", cells));
    TRY(check_pointer(call, "pictures", pictures));
    TRY(check_count(call, "cell_count", cell_count, 1, 64));
    TRY(check_cells(call, cells, cell_count, pictures));
    fnl_image joined = {.format = pictures[0].format};
    for (uint32_t i = 0; i < cell_count; i++) {
        joined.width = MAX(joined.width, cells[i].x + cells[i].width);
        joined.height = MAX(joined.height, cells[i].y + cells[i].height);
    }
    joined.pixels = host_allocate_zero(&resolved, (size_t)joined.width * joined.height * fnl_pixel_size(joined.format));
    if (!joined.pixels) return FNL_ERROR_MEMORY;
    struct joined j;
    for (uint32_t i = 0; i < 256; i++) j.linear[i] = decode_srgb((float)i / 255);
    for (uint32_t i = 0; i < cell_count; i++) {
        j.picture = &pictures[i];
        join(eye, &cells[i], &j, &joined);
    }
    *out = joined;
    return FNL_OK;
}
